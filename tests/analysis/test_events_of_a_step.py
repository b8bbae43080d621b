"""What a step of a branch says of an event on it, on steps whose roots are known in closed form.

A root lies so far along its step, and has the value and the rates that a formula gives there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, inf, pi, sin, ulp
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.analysis.orbits import branch_segment, curves
from camcli.analysis.orbits.branch_segment import BranchSegment, _pass_corner, _take_smooth_events
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Crossing, Located, beyond_both, graze_on, parent_of
from camcli.analysis.orbits.proofs import _leaning, _sections
from camcli.cams.eccentric import EccentricCam
from camcli.system import Follower, System

TURN = 2.0 * pi


@dataclass(frozen=True)
class Root:
    """A root of the shooting equations, as far as its step knows it."""

    x: tuple[float, ...] = ()
    rates: tuple[float, ...] = (-1.0,)
    whole: tuple = ()
    turns: int = 1
    trace: float = 0.0
    det: float = 0.5
    along: float = 0.0

    @property
    def value(self) -> float:
        return self.x[-1]

    @property
    def count(self) -> int:
        return len(self.rates)

    @property
    def theta(self) -> tuple[float, ...]:
        return self.x[:-1:2]


def step_of(root, length: float = 1.0, lost: float = inf):
    """A step whose roots a formula of the length gives, none beyond `lost`."""

    def at(_, along):
        return root(along) if along <= lost else None

    return Stub(at=at, before=root(0.0), after=root(length), length=length)


@pytest.mark.parametrize("lost", [inf, 0.4])
@pytest.mark.parametrize("slope", [3.0, -3.0, 0.0])
def test_a_graze_is_where_a_root_is_a_motion_for_the_last_time(slope, lost):
    """It grazes at 0.7 of the way; at `lost` the solver finds no root any more."""
    end = min(0.7, lost)

    def root(along):
        return Root((1.0, 0.2, 2.0, 0.3, 700.0 + slope * along), (-1.0, -2.0), along=along)

    shooter = Stub(
        admits=lambda one: one.along <= end,
        verdict=lambda one: (3, 1, 5.0 + one.along),
        zero_rate=1e-3,
    )
    step = step_of(root, lost=lost)
    found = graze_on(shooter, step)
    assert (found.kind, found.status, found.impact, found.fading) == (
        Kind.GRAZING, Bracket.OK, 1, None
    )  # fmt: skip
    assert found.root.along == found.reach <= end
    assert found.reach == pytest.approx(end, abs=1e-12)
    rounding = 8.0 * ulp(700.0)
    if lost == inf:  # the contact that is new is that of the first root which is no motion
        assert found.phase > 5.0 + end
        assert found.phase == pytest.approx(5.0 + end)
        assert abs(slope) * (end - found.reach) <= found.error <= 1e-10
        assert found.error >= rounding
    else:
        assert found.phase == 6.0
        assert found.error == max(rounding, abs(slope) * (1.0 - found.reach))
    if slope == 0.0:
        assert found.error == rounding
    shooter.admits = lambda one: one.along <= 1.0
    assert graze_on(shooter, step) is None


@pytest.mark.parametrize("rise", [2.0, -2.0])
@pytest.mark.parametrize(
    ("fades", "lost", "furthest"),
    [(0.7, inf, None), (1.4, inf, None), (3.0, inf, None), (5.0, inf, None),
     (5.1, inf, 1.5**4), (20.0, inf, 1.5**4), (1.6, 1.5, 1.5), (1.1, 1.4, 1.0)],
)  # fmt: skip
def test_an_impact_fades_up_to_four_steps_beyond(fades, lost, furthest, rise):
    """The slowest of three impacts: it is looked for 1.5, 2.25, ... steps ahead, beyond 4 no more.

    furthest: where it was looked at last in vain; at `lost` the solver finds no root any more.
    Its rate is zero at `fades`; the roots cease to be motions 1e-4 before, or at half a step.
    """
    ends = min(0.5, fades - 1e-4)
    slope = 1e-4 / fades

    def root(along):
        rates = (-1.0, slope * (along - fades), -0.5)
        x = (1.0, 0.2, 2.0 + along, 0.3, 3.0, 0.1, 700.0 + rise * along)
        return Root(x, rates, along=along)

    def moved(_, value):
        return root((value - 700.0) / rise)

    shooter = Stub(admits=lambda one: one.along <= ends, zero_rate=1e-3, moved=moved)
    found = graze_on(shooter, step_of(root, lost=lost))
    assert (found.kind, found.impact, found.fading) == (Kind.GRAZING, 1, 1)
    assert found.phase == found.root.theta[1]
    if furthest is None:
        assert found.status is Bracket.OK
        assert found.root.rates[1] <= 0.0
        assert found.reach == found.root.along == pytest.approx(fades, rel=1e-12)
        assert abs(found.root.value - (700.0 + rise * fades)) <= found.error <= 1e-6
    else:
        assert found.status is Bracket.UNRESOLVED
        assert found.reach == found.root.along == pytest.approx(ends)
        assert found.error == pytest.approx(2.0 * (furthest - ends))


@pytest.mark.parametrize(("curve", "asked", "found"), [
    (lambda x: 0.1 + 3.5 * (x - 0.5) ** 2, [0.5], None),  # it is at the lowest place already
    (lambda x: 0.1 + (x - 0.4) ** 2, [0.5], None),
    (lambda x: 0.1 + (x - 0.3) ** 2, [0.5, 0.3], None),
    (lambda x: 0.1 + (x - 0.7) ** 2, [0.5, 0.7], None),
    (lambda x: (x - 0.3) ** 2 - 0.01, [0.5, 0.3], 0.3),
    (lambda x: (x - 0.7) ** 2 - 0.01, [0.5, 0.7], 0.7),
    (lambda x: 3.0 * (x - 0.5) ** 2 - 0.01, [0.5], 0.5),
    (lambda x: 1.0 - 2.0 * (x - 0.5) ** 2, [0.5], None),  # it has no lowest place
    (lambda x: 0.1 + x, [0.5], None),
    (lambda x: 0.01 * (x + 0.5) ** 2, [0.5], None),  # that lies before the step
    (lambda x: 0.01 * (x - 1.5) ** 2, [0.5], None),  # and that behind it
    (lambda x: 0.99 + 9.0 * x * (x - 0.3), [0.5, 0.15], None),  # one end is below 1
    (lambda x: 1.0 + 9.0 * x * (x - 0.5), [], None),
    (lambda x: (x - 0.5) ** 2 - 0.25, [], None),
    (lambda x: x - 0.25, [], None),
    (lambda x: 0.75 - x, [], None),
])  # fmt: skip
def test_a_dip_below_zero_is_looked_for_where_parabolas_are_lowest(curve, asked, found):
    """A parabola is met at once: from the middle of the step its lowest place is the next one."""
    looked_at = []

    def at(shooter, x):
        looked_at.append(x)
        return x if x <= lost else None

    lost = inf
    step = Stub(at=at, before=0.0, after=1.0, length=1.0)
    root = beyond_both("shooter", step, curve, 1.0)
    assert looked_at == pytest.approx(asked)
    assert root == (None if found is None else pytest.approx(found))
    lost = -inf
    assert beyond_both("shooter", step, curve, 1.0) is None
    assert len(looked_at) == len(asked) + bool(asked)
    step.length = 0.0
    assert beyond_both("shooter", step, curve, 1.0) is None
    assert len(looked_at) == len(asked) + bool(asked)


DOUBLED = Root(
    (1.0, 0.5, 2.0, 0.7, 1.02, 0.9, 2.04, 0.1, 700.0),
    (-1.0,) * 4,
    whole=(4, 0, 5, 0, 4, 1, 5, 1),
    turns=2,
)


def parent(root, zero, within=0.0):
    """The doubling of a family of single orbits whose 1 + trace + det is zero at a value."""
    asked = []

    def moved(one, value):
        asked.append(one)
        return replace(one, x=(*one.x[:-1], value), trace=-1.5 + 1e-3 * (value - zero))

    event = Located(Kind.FOLD, root, 0.25, 0.0, Bracket.OK)
    return parent_of(Stub(moved=moved, scale=0.7), event, within), asked


def test_the_doubling_that_a_branch_is_born_at_is_that_of_the_mean_of_its_halves():
    """It is bracketed about its own value, not about that of the fold."""
    zero = 700.0 * (1.0 + 0.9e-6)
    found, asked = parent(DOUBLED, zero)
    assert asked[0].x == pytest.approx((1.01, 0.7, 2.02, 0.4, 700.0))
    assert (asked[0].whole, asked[0].turns) == ((4, 0, 5, 0), 1)
    assert (found.kind, found.status, found.reach) == (Kind.PERIOD_DOUBLING, Bracket.OK, 0.25)
    assert abs(found.root.value - zero) <= found.error <= 1e-10 * zero


@pytest.mark.parametrize(
    ("change", "off", "within", "is_found"),
    [
        ({}, 0.0, 0.0, True),
        ({"rates": (-1.0,) * 3}, 0.0, 0.0, False),
        ({"turns": 3}, 0.0, 0.0, False),
        ({"x": (*DOUBLED.x[:4], 1.049, *DOUBLED.x[5:])}, 0.0, 0.0, True),
        ({"x": (*DOUBLED.x[:4], 1.051, *DOUBLED.x[5:])}, 0.0, 0.0, False),  # halves too unlike
        ({"x": (*DOUBLED.x[:4], 1.051, *DOUBLED.x[5:])}, 0.0, 0.1, True),  # past the doubling
        ({}, 0.99e-6 * 700.7, 0.0, True),
        ({}, 1.01e-6 * 700.7, 0.0, False),
        ({}, 0.09, 0.1, True),
        ({}, -0.11, 0.1, False),
    ],
)
def test_which_fold_is_a_doubling_of_the_single_orbit(change, off, within, is_found):
    found, _ = parent(replace(DOUBLED, **change), 700.0 + off, within)
    assert (found is not None) is is_found


def test_the_passage_of_a_flight_that_comes_nearest_counts():
    """A flight through the lift, whose path rises slowly: each turn it comes nearer to the top.

    Free of forces, q = rate s beside c = lift (1 - cos theta)/2; near theta = pi the gap is lowest
    where its slope rate - lift sin(theta)/2 is zero.
    """
    lift, rate = 0.01, 0.0006
    cam = EccentricCam(kind="eccentric", base=0.0, lift=lift)
    system = System.build(Follower(mass=2.0, stiffness=0.0), cam)
    const = system.constants(600.0, 1e-12, 0)
    level = pi - np.arcsin(2.0 * rate / lift)  # behind it the cam falls away

    def gap(s):
        return rate * s - lift * (1.0 - cos(s)) / 2.0

    assert sin(level) * lift / 2.0 == pytest.approx(rate)
    for length, turns in ((2.4 * TURN, (0, 1, 2)), (1.3 * TURN, (0, 1)), (0.9 * TURN, (0,))):
        root = Stub(const=const, x=[0.0, rate, 600.0], stretch=lambda k: 0,
                    flight_length=lambda k, length=length: length)  # fmt: skip
        shooter = Stub(system_of=lambda one: system)
        passages = [level + n * TURN for n in turns if level + n * TURN < length]
        nearest = min(passages, key=lambda s: abs(gap(s)))
        found = curves.touch_near(shooter, root, Stub(impact=0, phase=level + 0.05))
        assert found == pytest.approx((gap(nearest), nearest), abs=1e-9)
    short = Stub(const=const, x=[0.0, rate, 600.0], stretch=lambda k: 0,
                 flight_length=lambda k: 2.0)  # fmt: skip
    found = curves.touch_near(shooter, short, Stub(impact=0, phase=2.5))
    assert found == pytest.approx((gap(2.5), 2.5))  # the flight continued


# --- what a segment makes of them


def located(kind, name, status=Bracket.OK):
    return Located(kind, name, 0.0, 0.0, status)


PLAIN, DOUBLING = located(Kind.FOLD, "fold"), located(Kind.PERIOD_DOUBLING, "doubling")
UNRESOLVED = located(Kind.FOLD, "fold", Bracket.UNRESOLVED)
BIRTH = located(Kind.PERIOD_DOUBLING, "birth")


@pytest.mark.parametrize(
    ("events", "collapsed", "birth", "grazes", "goes_on", "points", "told", "end"),
    [
        ([], False, None, False, True, [], [], Kind.LOST),
        ([DOUBLING], False, None, False, True, ["doubling"], [DOUBLING], Kind.LOST),
        ([DOUBLING, PLAIN], False, None, False, True, ["doubling", "fold"], [DOUBLING, PLAIN],
         Kind.LOST),
        ([DOUBLING, PLAIN], False, BIRTH, False, False, ["doubling", "fold"], [DOUBLING, BIRTH],
         Kind.PERIOD_DOUBLING),
        ([DOUBLING, PLAIN], True, BIRTH, False, False, [], [BIRTH], Kind.PERIOD_DOUBLING),
        ([PLAIN], True, None, False, False, [], [], Kind.PERIOD_DOUBLING),
        ([UNRESOLVED], False, BIRTH, False, False, [], [BIRTH], Kind.PERIOD_DOUBLING),
        ([UNRESOLVED], False, None, True, True, ["fold"], [UNRESOLVED], Kind.LOST),
        ([UNRESOLVED], True, None, True, False, [], [], Kind.PERIOD_DOUBLING),
        ([DOUBLING], True, BIRTH, False, True, ["doubling"], [DOUBLING], Kind.LOST),
    ],
)  # fmt: skip
def test_what_a_segment_takes_from_a_step(
    monkeypatch, events, collapsed, birth, grazes, goes_on, points, told, end
):
    """A fold where the branch was born ends it; one that is not resolved does so but at a graze."""
    asked = []

    def parent_near(shooter, event, within=0.0):
        asked.append((event.kind, within))
        return birth if event.kind == Kind.FOLD else None

    monkeypatch.setattr(branch_segment, "smooth_events", lambda *_: events)
    monkeypatch.setattr(branch_segment, "collapses", lambda shooter, root: collapsed)
    monkeypatch.setattr(branch_segment, "parent_of", parent_near)
    metric = Stub(oriented=lambda root, along: np.array([0.5, -0.5]))
    step = Stub(metric=metric, unit=np.array([0.1, 0.9]), length=0.5, before=Stub(value=699.0),
                after=Stub(value=700.5))  # fmt: skip
    segment = BranchSegment(points=["begin"])
    assert _take_smooth_events("shooter", segment, step, grazes) is goes_on
    assert segment.points == ["begin", *points]
    assert segment.events == [(event, None) for event in told]
    assert segment.end == end
    if not points and not goes_on:  # past the birth: looked for within twice the step
        assert asked == [(Kind.FOLD, 3.0)]


@pytest.mark.parametrize(
    ("unit", "ahead", "turned"),
    [(0.9, 0.5, False), (0.9, -0.5, True), (-0.9, 0.5, True), (-0.9, -0.5, False)],
)
@pytest.mark.parametrize(
    ("begins_doubling", "first", "known"),
    [(True, True, True), (True, False, False), (False, True, False)],
)
def test_what_is_known_of_a_step_before_its_events(
    monkeypatch, unit, ahead, turned, begins_doubling, first, known
):
    """Whether the parameter turns round, and whether the doubling at its begin has been told."""
    asked = []
    monkeypatch.setattr(branch_segment, "smooth_events", lambda *args: asked.append(args) or [])
    metric = Stub(oriented=lambda root, along: np.array([0.5, ahead]))
    points = [Stub(), Stub()]
    step = Stub(metric=metric, unit=np.array([0.1, unit]), after="after",
                before=points[0 if first else 1])  # fmt: skip
    segment = BranchSegment(points=points, begins_doubling=begins_doubling)
    assert _take_smooth_events("shooter", segment, step, False)
    assert asked == [("shooter", step, turned, known)]


def crossing(coming=1.0, far=1.0, corner="b", kink=False):
    left = Stub(tangent=[0.0, coming], name="left")
    right = Stub(tangent=[0.0, far], name="right")
    return Crossing(left, right, 0, True, corner, kink, [])


@pytest.mark.parametrize(
    ("crossed", "goes_on", "events", "turned", "end"),
    [
        (crossing(), True, 1, False, Kind.LOST),
        (crossing(corner=""), True, 0, False, Kind.LOST),  # the cam is smooth there
        (crossing(corner="", kink=True), True, 0, False, Kind.LOST),
        (crossing(far=-1.0), False, 1, True, Kind.CORNER_IMPACT),  # a nonsmooth fold
        (crossing(kink=True), False, 1, False, Kind.CORNER_IMPACT),
        (crossing(far=-1.0, kink=True), False, 1, False, Kind.CORNER_IMPACT),
        (None, False, 1, False, Kind.CORNER_IMPACT),
    ],
)
def test_how_a_segment_passes_a_corner(monkeypatch, crossed, goes_on, events, turned, end):
    """From a nonsmooth fold another branch leaves."""
    monkeypatch.setattr(branch_segment, "cross", lambda shooter, event: crossed)
    segment = BranchSegment(points=["begin"])
    assert _pass_corner("shooter", segment, "event") is (crossed if goes_on else None)
    assert segment.events == [("event", crossed)] * events
    assert segment.turned is (crossed if turned else None)
    assert segment.end == end
    assert segment.points == ["begin", *([crossed.far] if goes_on and events else [])]


@pytest.mark.parametrize(
    ("points", "events", "sections"),
    [
        ("a1 a2 a3", "", ["a1 a2 a3"]),
        ("a3 a2 a1", "", ["a1 a2 a3"]),  # the parameter rises
        ("a1 a2", "", []),  # too few
        ("a1 a2 a3 a4 a5", "3", ["a1 a2 a3", "a3 a4 a5"]),  # the event is an end of both
        ("a1 a2 a3 a4", "3", ["a1 a2 a3"]),
        ("a1 a2 a3 b3 b4 b5", "", ["a1 a2 a3", "b3 b4 b5"]),
        ("a1 a2 a3 b3 b4 b5 b6", "4", ["a1 a2 a3", "b4 b5 b6"]),
        ("a1 a2 a3 a2 a1", "", []),  # it turns round where no event is
        ("a1 a2 a3 a2 a1", "3", ["a1 a2 a3", "a1 a2 a3"]),
        ("a1 a2 a2 a3", "", []),
        ("a1 a2 a3 b4", "", ["a1 a2 a3"]),
    ],
)
def test_a_branch_is_proved_between_its_events_where_the_parameter_rises(points, events, sections):
    """A letter for the stretches of the impacts, a digit for the parameter."""

    def orbit(value, stretches=""):
        return Root((1.0, 0.1, value), whole=(stretches,))

    made = [
        Stub(name=word, value=float(word[1]), root=orbit(float(word[1]), word[0]))
        for word in points.split()
    ]
    happened = [Stub(value=float(x), located=Stub(root=orbit(float(x)))) for x in events]
    found = _sections(Stub(points=tuple(made)), happened)
    assert [" ".join(point.name for point in section) for section in found] == sections


@pytest.mark.parametrize(
    ("phases", "steep", "leans_along"),
    [
        ((1.0, 1.1, 1.4), "first", 0),
        ((1.0, 1.1, 1.4), "last", 0),
        ((1.4, 1.1, 1.0), "last", 0),
        ((1.0, 1.1, 1.4), "middle", 4),  # the parameter
        ((1.0, 1.1, 1.4), "none", 4),
        ((1.0, 1.5, 1.4), "first", 4),  # it turns round on the way
        ((1.0, 0.9, 1.4), "first", 4),
        ((1.0, 1.0, 1.4), "first", 0),
        ((1.4, 1.4, 1.4), "first", 2),  # the other one changes most
    ],
)
def test_along_what_the_boxes_of_a_section_lean(phases, steep, leans_along):
    """The phase that changes most, where the branch is steep at either end; else the parameter."""
    tangent = {True: [50.0, 0.0, 20.0, 0.0, 1.0], False: [0.4, 0.0, 0.1, 0.0, 1.0]}
    roots = [
        Stub(
            count=2, x=[theta, 0.5, 3.0 + 0.1 * k, 0.5, 700.0 + k], tangent=tangent[place == steep]
        )
        for k, (theta, place) in enumerate(zip(phases, ("first", "middle", "last"), strict=True))
    ]
    assert _leaning(roots) == leans_along
    assert _leaning(roots[::-1]) == leans_along
