"""Which events curves and branches are begun at, and whether a curve leads through an event."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from math import cos, inf, sin
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from camcli.analysis.border_collision import Rule
from camcli.analysis.explain import changes
from camcli.analysis.exponents import of_orbit
from camcli.analysis.orbits import atlas, curves, locate, proofs
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Bracket, Certainty
from camcli.analysis.orbits.shooter import Shooter
from camcli.exact.shooting import Place
from tests.conftest import chapter_system

PLANE = SimpleNamespace(names=("rpm", "cam.lift"))
PLACE_OF = {"rpm": 0, "cam.lift": 7}  # in a machine


def root(first: float, second: float, theta=(1.0, 2.0), parameter="rpm"):
    """A root with both parameters; its value is that of the one it was solved for."""
    theta = np.array(theta)
    return SimpleNamespace(
        parameter=PLACE_OF[parameter], value=first if parameter == "rpm" else second, theta=theta,
        count=len(theta), x=[*theta, 0.5, -1.0], both=(first, second),
    )  # fmt: skip


class Circle:
    """`_Tracer` of the curve first^2 + second^2 = 25, whose impacts do not move on the way."""

    moved = 0.0
    asked: list = []  # noqa: RUF012

    def __init__(self, system, located, plane):
        pass

    def values(self, root):
        return root.both

    def solve(self, beside, guess, free, given):
        Circle.asked.append((beside, guess, free, given))
        if abs(given) > 5.0:
            return None
        other = (25.0 - given * given) ** 0.5
        both = (other, given) if free == 0 else (given, other)
        theta = np.array(beside.theta) + self.moved
        return root(*both, theta[::-1], "rpm" if free == 0 else "cam.lift")


def passes(monkeypatch, event, free=0, kind=Kind.FOLD, located=True, moved=0.0, count=2) -> bool:
    """Whether the curve, known at (5, 0), (4, 3) and (3, 4), leads through an event."""
    monkeypatch.setattr(curves, "_Tracer", Circle)
    monkeypatch.setattr(curves, "place_of", lambda system, name: PLACE_OF[name])
    monkeypatch.setattr(Circle, "moved", moved)
    Circle.asked.clear()
    points = [
        SimpleNamespace(
            values=both, orbit=SimpleNamespace(root=root(*both, (1.0, 2.0, 3.0)[:count]))
        )
        for both in ((5.0, 0.0), (4.0, 3.0), (3.0, 4.0))
    ]
    known = SimpleNamespace(kind=Kind.FOLD, located="known" if located else None, points=points)
    given = root(*event, parameter="rpm" if free == 0 else "cam.lift")
    return curves.passes(None, known, SimpleNamespace(kind=kind, root=given), PLANE)


ON = (25.0 - 3.625**2) ** 0.5, 3.625


@pytest.mark.parametrize("free", [0, 1])
def test_a_curve_leads_through_an_event_that_it_is_solved_at(monkeypatch, free):
    """Solved beside the nearer point for the parameter that the event was solved for."""
    assert passes(monkeypatch, ON, free)
    ((beside, guess, solved_for, given),) = Circle.asked
    apart = [abs(both[1 - free] - ON[1 - free]) for both in ((4.0, 3.0), (3.0, 4.0))]
    assert beside.both == ((4.0, 3.0), (3.0, 4.0))[int(np.argmin(apart))]
    assert guess == [*beside.x[:-1], beside.both[free]]
    assert (solved_for, given) == (free, ON[1 - free])


@pytest.mark.parametrize(
    ("event", "free", "more"),
    [
        ((ON[0] + 1e-6, ON[1]), 0, {}),  # beside the curve
        ((ON[0], ON[1] + 1e-6), 1, {}),
        ((0.0, 5.0), 0, {}),  # beyond its points
        ((5.0, 0.1), 1, {}),
        (ON, 0, {"kind": Kind.PERIOD_DOUBLING}),
        (ON, 0, {"located": False}),
        (ON, 0, {"moved": np.array([1e-3, 1e-3])}),  # other impacts
        (ON, 0, {"moved": np.array([1e-3, 0.0])}),
        (ON, 1, {"moved": np.array([0.0, 1e-3])}),
        (ON, 0, {"count": 3}),  # of an orbit with more impacts
    ],
)
def test_a_curve_does_not_lead_through_other_events(monkeypatch, event, free, more):
    assert not passes(monkeypatch, event, free, **more)


def test_branches_leave_from_events_of_few_turns_first_and_once_each():
    """A branch that is followed may add to the events from which others leave."""
    turns = [3, 1, 2, 1]
    followed = []
    diagram = SimpleNamespace(
        bifurcations=[
            SimpleNamespace(kind="fold", value=1.0 + n, orbit=SimpleNamespace(turns=n))
            for n in turns
        ],
        branch_points=[(0, "a"), (1, "b"), (2, "c")],
    )

    def switch(index, event, span):
        assert span == "span"
        followed.append((index, event))
        if index == 2:
            diagram.branch_points.append((3, "d"))

    diagram.switch = switch
    atlas._follow_from_events(diagram, 3, "span")
    assert followed == [(1, "b"), (2, "c"), (3, "d")]
    atlas._follow_from_events(diagram, 10, "span")
    assert followed[3:] == [(1, "b"), (3, "d"), (2, "c"), (0, "a")]
    diagram.branch_points.clear()
    atlas._follow_from_events(diagram, 10, "span")
    assert len(followed) == 7


def test_a_branch_is_begun_at_a_doubling_only_where_its_test_is_zero(monkeypatch):
    """An event that begins a branch lies at no distance along it."""
    certainty = Certainty(1e-9, Bracket.OK)
    monkeypatch.setattr(locate, "_bracket", lambda shooter, root, test: certainty)
    for off, begun in ((0.0, True), (-0.9e-10, True), (1.1e-10, False), (-1.1e-10, False)):
        monkeypatch.setattr(locate, "flip_test", lambda root, off=off: off)
        found = locate.doubling_at("shooter", "root")
        assert (found is not None) is begun
    monkeypatch.setattr(locate, "flip_test", lambda root: 0.0)
    found = locate.doubling_at("shooter", "root")
    assert (found.kind, found.root, found.reach) == (Kind.PERIOD_DOUBLING, "root", 0.0)
    assert (found.error, found.status) == (1e-9, Bracket.OK)


def test_the_exponents_of_a_solved_orbit_are_exact():
    """ln |multiplier| a turn; of one that rests nothing is left, in infinitely many impacts."""
    system = chapter_system()
    resting = SimpleNamespace(rpm=358.5, resting=True)
    found = of_orbit(system, resting)
    assert (found.largest, found.second, found.spread) == (-inf, -inf, 0.0)
    assert (found.rule, found.impacts, found.chaotic) == (-inf, inf, False)
    orbit = SimpleNamespace(
        rpm=700.0, resting=False, impacts=3, turns=2, theta=np.array([0.1, 0.2, 0.3]),
        multipliers=(-4.0 + 0j, 0.25 + 0j),
    )  # fmt: skip
    found = of_orbit(system, orbit)
    assert (found.largest, found.second) == pytest.approx((np.log(2.0), -np.log(2.0)))
    assert (found.spread, found.impacts) == (0.0, 1.5)
    assert found.rule == pytest.approx(1.5 * 2.0 * np.log(0.8))


@dataclass(frozen=True)
class OfMaps:
    """`Shooting` whose map, as (trace, determinant), depends on where its impacts are."""

    stretches: tuple
    places: tuple
    maps: dict

    def trace_det(self, hull):
        return self.maps[self.places]


@pytest.mark.parametrize(
    ("own", "side", "behind"),
    [
        (Place(1, 2), 1, Place(2, 2)),
        (Place(1, 2), -1, Place(0, 2)),
        (Place(3, 2), 1, Place(0, 3)),  # through the end of the turn
        (Place(0, 2), -1, Place(3, 1)),
    ],
)
def test_the_signs_of_a_corner_impact_are_of_the_maps_on_both_sides(own, side, behind):
    """1 - tau + delta is 0.5 and -1.5, 1 + tau + delta 2.5 and 3.5; a ball about zero has none."""
    other = Place(2, 0)
    here, there = (arb(1.0), arb(0.5)), (arb(2.5), arb(0.0))
    for map_there, signs in ((there, (-1, 1)), ((arb(-1, 0.5), arb(0)), (1, 0))):
        maps = {(other, own): here, (other, behind): map_there}
        shooting = OfMaps((0, 1, 2, 3), (other, own), maps)
        found = proofs._corner_signs(shooting, [], SimpleNamespace(impact=1, side=side))
        assert found == tuple(
            zip((Rule.PRODUCT_AT_ONE, Rule.PRODUCT_AT_MINUS_ONE), signs, strict=True)
        )


@pytest.mark.parametrize("s", [0.9, 1.5, 1.97, 2.0, 2.3, 3.1])
def test_a_flight_comes_nearest_to_the_cam_where_its_gap_is_level(s):
    """A gap of 1.01 - cos(s - 2): at 2, from as far away as it is convex and the flight goes."""

    def gap(at: float) -> tuple[float, float, float]:
        return 1.01 - cos(at - 2.0), sin(at - 2.0), cos(at - 2.0)

    assert curves._lowest(gap, s, 4.0) == (pytest.approx(0.01), pytest.approx(2.0, abs=1e-12))
    least, at = curves._lowest(gap, 0.9, 1.45)  # the flight ends before
    assert 1.35 <= at < 1.45
    assert least == gap(at)[0]
    assert curves._lowest(gap, 0.4, 4.0) == (gap(0.4)[0], 0.4)  # concave


@pytest.mark.parametrize(
    ("kind", "trace", "det", "holds"),
    [
        (Kind.PERIOD_DOUBLING, arb(-1.64), arb(0.64), True),
        (Kind.PERIOD_DOUBLING, arb(1.6), arb(0.64), True),
        (Kind.PERIOD_DOUBLING, arb(1.7), arb(0.64), False),  # the other one beyond +1
        (Kind.PERIOD_DOUBLING, arb(1.6, 0.1), arb(0.64), False),  # it may be
        (Kind.PERIOD_DOUBLING, arb(-1.9), arb(1.0), False),  # nothing is lost
        (Kind.PERIOD_DOUBLING, arb(-1.9), arb(0.9, 0.2), False),
        (Kind.FOLD, arb(1.64), arb(0.64), True),
        (Kind.FOLD, arb(-1.6), arb(0.64), True),
        (Kind.FOLD, arb(-1.7), arb(0.64), False),  # beyond -1
        (Kind.FOLD, arb(-1.6, 0.1), arb(0.64), False),
        (Kind.FOLD, arb(1.9), arb(1.1), False),
    ],
)
def test_at_an_event_the_other_multiplier_is_inside_the_circle(kind, trace, det, holds):
    shooting = SimpleNamespace(trace_det=lambda hull: (trace, det))
    box = SimpleNamespace(hull=lambda: None)
    if holds:
        proofs._prove_other_inside(shooting, box, kind)
    else:
        with pytest.raises(proofs.NotProvedError) as refusal:
            proofs._prove_other_inside(shooting, box, kind)
        assert refusal.value.step == proofs.ProofStep.NEUTRAL


def test_a_branch_passes_an_end_of_a_stretch_where_no_event_is(monkeypatch):
    """Between two neighbours on unlike stretches; an event lies at one of them at most."""
    wholes = ["a", "a", "b", "b", None, "c", "d", "e"]
    points = [
        SimpleNamespace(root=None if whole is None else SimpleNamespace(whole=whole), place=k)
        for k, whole in enumerate(wholes)
    ]
    branch = SimpleNamespace(points=points)
    monkeypatch.setattr(
        proofs, "_event_at", lambda point, events: events if point.place in events else None
    )
    for events, passed in [((), [1, 5, 6]), ((1,), [5, 6]), ((2,), [5, 6]), ((6,), [1])]:
        found = [(a.place, b.place) for a, b in proofs._passings(branch, events)]
        assert found == [(k, k + 1) for k in passed]


@pytest.mark.parametrize(
    ("kind", "left", "right", "det", "stable", "is_one"),
    [
        (Kind.CORNER_IMPACT, True, False, 0.64, False, True),
        (Kind.CORNER_IMPACT, False, True, 0.64, False, True),
        (Kind.CORNER_IMPACT, False, False, 0.64, True, False),
        (Kind.CORNER_IMPACT, None, True, 0.64, False, False),  # a side is not known: the orbit
        (Kind.CORNER_IMPACT, True, None, 0.64, True, True),
        (Kind.FOLD, None, None, 0.64, False, True),
        (Kind.FOLD, None, None, 1.0, True, False),
        (Kind.PERIOD_DOUBLING, None, None, 0.99, False, True),
        (Kind.PERIOD_DOUBLING, True, True, 1.01, True, False),
        (Kind.GRAZING, None, None, 0.64, True, True),
        (Kind.GRAZING, True, True, 0.64, False, False),
    ],
)
def test_what_attracts_changes_at_an_event(kind, left, right, det, stable, is_one):
    sides = [None if one is None else SimpleNamespace(stable=one) for one in (left, right)]
    orbit = SimpleNamespace(det=det, stable=stable)
    event = SimpleNamespace(kind=kind, left=sides[0], right=sides[1], orbit=orbit)
    assert changes.of_attractor(event) is is_one


@pytest.mark.parametrize("value", [700.0, -0.03])
@pytest.mark.parametrize(("off", "is_there"), [(0.9e-11, True), (-0.9e-11, True), (1.1e-11, False)])
def test_a_point_of_a_branch_is_at_an_event_of_its_value_and_its_impacts(value, off, is_there):
    """The value to 1e-11 of itself, whatever its size."""

    def orbit(*theta):
        return SimpleNamespace(theta=list(theta), count=len(theta))

    point = SimpleNamespace(value=value, root=orbit(1.0, 2.0))
    there = value * (1.0 + off)
    event = SimpleNamespace(value=there, located=SimpleNamespace(root=orbit(1.0, 2.0)))
    others = [
        SimpleNamespace(value=there, located=None),
        SimpleNamespace(value=there, located=SimpleNamespace(root=orbit(1.0))),
        SimpleNamespace(value=there, located=SimpleNamespace(root=orbit(1.0, 2.1))),
    ]
    assert proofs._event_at(point, others) is None
    assert proofs._event_at(point, [*others, event]) is (event if is_there else None)
    assert proofs._event_at(SimpleNamespace(value=value, root=None), [event]) is None


@pytest.mark.parametrize(("side", "edge"), [(1, 2.5), (-1, 2.0)])
def test_an_orbit_at_a_corner_of_a_cam_that_varies_is_solved_from_the_corner(side, edge):
    asked = []
    stretch = SimpleNamespace(start=2.0, end=2.5)
    shooter = SimpleNamespace(
        system_of=lambda root: SimpleNamespace(cam=SimpleNamespace(stretches=[None, stretch])),
        family=SimpleNamespace(correct=lambda x, *more: asked.append(x)),
        _as_root=lambda *solved: None,
    )
    shooter.edge = partial(Shooter.edge, shooter)
    guess = SimpleNamespace(x=[1.0, -0.5, 2.2, -0.25, 700.0], whole=(0, 0, 1, 0), turns=1)
    Shooter.at_corner(shooter, guess, 1, side)
    assert asked == [[1.0, -0.5, edge, -0.25, 700.0]]
