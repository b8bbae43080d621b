"""What each condition of a point of codimension two is, and which of them is looked for.

Of P(3;3:3:2) of the chapter's machine at 358.5 rpm, whose eight impacts lie in three turns: the
values of the conditions beside closed forms, with the strobe in two places. Then the choice: which
dip is the graze of a curve, what may have ended it, how two conditions are called.
"""

from dataclasses import replace
from itertools import product
from math import inf, pi
from types import SimpleNamespace as Made

import numpy as np
import pytest
from conftest import chapter_system, settings, solve_from

from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.codim2 import Condition, Meeting, PointKind, _CurveSearch
from camcli.analysis.orbits.codim2 import Test as What
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.shooter import Shooter
from camcli.cams.balls import precision
from camcli.cams.law import LawCam
from camcli.cams.regions import corner_list
from camcli.exact.shooting import NotProvedError
from camcli.kernel.certify import Verdict
from camcli.system import Follower, System
from tests.support.machines import CHAPTER

RPM, TURN = 358.5, 2.0 * pi
PLANE = Plane(("rpm", "restitution"), ((350.0, 390.0), (0.7, 0.9)), 20)
ENDS = np.radians([0.0, 90.0, 150.1793714951576, 160.0, 200.0, 209.8206285048424, 270.0, 360.0])
FREQUENCY = np.sqrt(CHAPTER.stiffness / CHAPTER.mass) * 30.0 / (RPM * pi)  # per rad of the cam


@pytest.fixture(scope="module", params=[0.0, 251.0])
def machine(request):
    system = chapter_system(request.param)
    return system, solve_from(system, RPM, settings(600)).root


def values(machine, conditions):
    """The conditions' values at the orbit, behind the slopes of the gap at grazes."""
    system, root = machine
    with precision(40):
        meeting = Meeting(system, PLANE, root, conditions)
        u = meeting.start(root, (RPM, 0.8))
        return [float(value.mid()) for value in meeting.equations(u)]


def lift(theta):
    """c (m) and c_theta (m/rad) of the cam at rad of any turn."""
    (c,), (slope,), _ = CHAPTER.cam.lift(np.degrees([theta]) % 360.0)
    return c, slope


def test_the_conditions_on_impacts_and_multipliers(machine):
    _, root = machine
    product = np.prod(root.rates)
    for k in range(root.count):
        theta = root.theta[k]
        upper = int(np.searchsorted(ENDS, theta))
        found = values(machine, [Condition(What.CORNER, k, 1), Condition(What.CORNER, k, -1)])
        assert np.abs(found[: 2 * root.count]).max() < 1e-12  # the orbit's own equations
        assert found[-2:] == pytest.approx(
            [theta - ENDS[upper], theta - ENDS[upper - 1]], abs=1e-12
        )
        assert values(machine, [Condition(What.FADE, k)])[-1] == pytest.approx(
            root.rates[k], rel=1e-10
        )
    found = values(machine, [Condition(What.FOLD), Condition(What.FLIP)])[-2:]
    det = 0.64**root.count  # without damping
    wanted = [(1.0 - root.trace + det) * product, (1.0 + root.trace + det) * product]
    assert found == pytest.approx(wanted, rel=1e-8)


def test_the_conditions_on_a_flight_at_any_place_of_it(machine):
    """The gap, its slope, and how far the place is from either end of its part of the cam.

    Flights of P(3;3:3:2) go on into the next turn, and beyond the end of the period.
    """
    _, root = machine
    turns = set()
    for k in range(root.count):
        after = (k + 1) % root.count
        whole = root.theta[after] - root.theta[k]
        whole += TURN * (root.turn(after) - root.turn(k) + (root.turns if after == 0 else 0))
        low, slope = lift(root.theta[k])
        rate = root.x[2 * k + 1] + slope
        for share in (0.13, 0.41, 0.77, 0.96):
            s = share * whole
            place = root.theta[k] + s
            turns.add(root.turn(k) + int(place // TURN))
            upper = int(np.searchsorted(ENDS, place % TURN))
            c, c1 = lift(place)
            sine, cosine = np.sin(FREQUENCY * s), np.cos(FREQUENCY * s)
            gap = low * cosine + rate / FREQUENCY * sine - c
            rises = -low * FREQUENCY * sine + rate * cosine - c1
            for side, end in ((1, ENDS[upper]), (-1, ENDS[upper - 1])):
                own = Condition(What.GRAZE, k, angle=s)
                other = Condition(What.GRAZE_AT_CORNER, k, side)
                found = values(machine, [own, other])[-3:]
                assert found == pytest.approx([rises, gap, place % TURN - end], abs=1e-9)
    assert turns == {0, 1, 2, 3}


# --- which condition is looked for


def search(located, system=None):
    return _CurveSearch(system, Made(located=located, points=(), ends=(None, None)), 4, PLANE)


def dip(k, angle):
    return Condition(What.GRAZE, k, angle=angle)


def test_the_graze_of_a_curve_is_the_dip_that_touches(monkeypatch):
    """Not the lowest one: a dip below the cam is that of an orbit which is virtual."""
    located = Made(kind=Kind.GRAZING, fading=None, impact=3)
    asked = []

    def dips(self, root, flights):
        asked.append(list(flights))
        return [(-1e-3, dip(3, 0.5)), (-2e-12, dip(3, 1.5)), (0.25, dip(3, 2.5))]

    monkeypatch.setattr(_CurveSearch, "_dips", dips)
    assert search(located).own(Made(x=[1.0])) == dip(3, 1.5)
    assert asked == [[3]]
    monkeypatch.setattr(_CurveSearch, "_dips", lambda *_: [])
    with pytest.raises(NotProvedError):
        search(located).own(Made(x=[1.0]))
    fading = Made(kind=Kind.GRAZING, fading=2, impact=3)
    assert search(fading).own(Made(x=[1.0])) == Condition(What.FADE, 2)
    for kind, what in ((Kind.FOLD, What.FOLD), (Kind.PERIOD_DOUBLING, What.FLIP)):
        own = search(Made(kind=kind, fading=None, impact=-1)).own(Made(x=[1.0]))
        assert own == Condition(what)


@pytest.mark.parametrize("side", [1, -1])
def test_the_corner_of_a_curve_is_the_nearer_end_of_the_stretch(machine, side):
    system, root = machine
    for k in range(root.count):
        upper = int(np.searchsorted(ENDS, root.theta[k]))
        end = ENDS[upper] - 0.01 if side > 0 else ENDS[upper - 1] + 0.01
        x = [end if j == 2 * k else value for j, value in enumerate(root.x)]
        found = search(Made(kind=Kind.CORNER_IMPACT, fading=None, impact=k), system)
        assert found.own(replace(root, x=x)) == Condition(What.CORNER, k, side)


LOW = [(0.1 * n, dip(1, float(n))) for n in range(1, 6)]


@pytest.mark.parametrize(
    ("test", "first"),
    [
        (What.FOLD, [Condition(What.CUSP)]),
        (What.FLIP, []),
        (What.CORNER, []),
        (What.GRAZE, [Condition(What.FOLD), Condition(What.FLIP)]),
    ],
)
@pytest.mark.parametrize(
    ("flight", "angle", "same"),
    [(1, 2.0, True), (1, 2.2999, True), (1, 1.7001, True), (1, 2.3001, False), (1, 1.6999, False),
     (0, 2.0, False)],
)  # fmt: skip
def test_what_may_have_ended_a_curve(monkeypatch, test, first, flight, angle, same):
    """The impact that is slowest; its own kinds; the three lowest dips but that of the curve.

    A dip TURNED (0.3 rad) from that of the curve is another one; so is one of another flight.
    """
    monkeypatch.setattr(_CurveSearch, "_dips", lambda *_: LOW)
    monkeypatch.setattr(_CurveSearch, "own", lambda *_: Condition(test, flight, angle=angle))
    root = Made(rates=[-0.5, -0.01, -0.2], count=3)
    taken = [1, 3] if same and test == What.GRAZE else [1, 2, 3]
    assert list(search(Made(impact=1))._causes(root, None)) == [
        Condition(What.FADE, 1), *first, *(dip(1, float(n)) for n in taken)
    ]  # fmt: skip


def corner_at(system, stretch: int) -> bool:
    """Whether a stretch begins at a corner of the cam: 0 deg and the strobe are none."""
    start = system.cam.stretches[stretch].start % TURN
    return bool(np.abs(ENDS[1:7] - start).min() < 1e-9)


def noted(monkeypatch) -> list:
    """What a search asks to be solved: (guess, values, room, condition)."""
    solved = []

    def note(self, *asked):
        solved.append(asked)
        return iter(())

    monkeypatch.setattr(_CurveSearch, "_solved", note)
    return solved


def test_an_impact_that_changes_its_stretch_has_passed_the_corner_between(monkeypatch, machine):
    """Forwards its stretch's end, backwards its start, also into the turn before or behind it."""
    system, root = machine
    solved = noted(monkeypatch)
    last = len(system.cam.stretches) - 1
    found = search(Made(kind=Kind.FOLD), system)
    seen = set()
    for k in range(root.count):
        for stretch in range(last + 1):
            for side in (1, -1):
                later = (stretch + side) % (last + 1)
                turn = 1 + (later == 0 and side > 0) - (later == last and side < 0)
                before, behind = (
                    replace(root, whole=(*root.whole[: 2 * k], *place, *root.whole[2 * k + 2 :]))
                    for place in ((stretch, 1), (later, turn))
                )
                solved.clear()
                points = (Made(orbit=Made(root=one)) for one in (before, behind))
                assert not list(found._corner_passed(*points))
                if corner_at(system, later if side > 0 else stretch):
                    seen.add(side)
                    ((*asked, room, condition),) = solved
                    assert asked == [before, (RPM, 0.8)]
                    assert room == pytest.approx((2.0, 0.01))  # a step of the plane
                    assert condition == Condition(What.CORNER, k, side)
                else:
                    assert solved == []
    assert seen == {1, -1}
    solved.clear()
    same = Made(orbit=Made(root=root))
    for points in ((same, same), (same, Made(orbit=Made(root=None)))):
        assert not list(found._corner_passed(*points))
    assert solved == []


def test_a_graze_that_changes_its_stretch_has_passed_the_corner_between(monkeypatch, machine):
    """Also behind the end of the turn, where the stretches begin again with the first."""
    system, root = machine
    solved = noted(monkeypatch)
    found = search(Made(kind=Kind.GRAZING), system)
    second = replace(root, x=[*root.x[:-1], RPM + 1.0])
    for k, start, turn in product(range(root.count), ENDS[:7], (1, 2)):
        angle = start + TURN * turn - root.theta[k]
        for low, high, side in ((-0.01, 0.01, 1), (0.01, -0.01, -1), (0.01, 0.02, 0)):

            def own(self, one, k=k, ends=(angle + low, angle + high)):
                return dip(k, ends[one is second])

            monkeypatch.setattr(_CurveSearch, "own", own)
            solved.clear()
            assert not list(found._corner_grazing(root, second, (1.0, 0.0)))
            there = Condition(What.GRAZE_AT_CORNER, k, side)
            assert solved == ([(root, (RPM, 0.8), (1.0, 0.0), there)] if side else [])


@pytest.mark.parametrize("verdict", list(Verdict))
def test_the_orbit_that_was_refused_behind_a_curve_shows_what_ended_it(
    monkeypatch, machine, verdict
):
    """The impacts off their stretch, the farthest first, and where a flight meets the cam early."""
    system, root = machine
    monkeypatch.setattr(_CurveSearch, "_dips", lambda *_: [])
    monkeypatch.setattr(_CurveSearch, "own", lambda *_: FLIP)
    stretches = [system.cam.stretches[root.whole[2 * k]] for k in range(root.count)]
    off = {k: 0.001 * (1 + (3 * k) % 8) for k in range(root.count)}  # rad, each another
    for side in (1, -1):
        x = list(root.x)
        for k, stretch in enumerate(stretches):
            x[2 * k] = stretch.end + off[k] if side > 0 else stretch.start - off[k]
        refused = replace(root, x=x)
        phase = refused.theta[2] + 1.25 - TURN * (side > 0)  # of the turn before, too
        monkeypatch.setattr(Shooter, "verdict", lambda *_, at=phase: (int(verdict), 2, at))
        edges = {k: root.whole[2 * k] + (side > 0) for k in off}
        met = [k for k in sorted(off, key=off.get, reverse=True) if k != 1
               and corner_at(system, edges[k] % len(system.cam.stretches))]  # fmt: skip
        wanted = [Condition(What.CORNER, k, side) for k in met]
        causes = list(search(Made(impact=1), system)._causes(root, refused))
        slowest = int(np.argmin(np.abs(root.rates)))
        assert met
        assert causes[: len(met)] == wanted
        rest = causes[len(met) :]
        if verdict == Verdict.EARLY:
            graze, *rest = rest
            assert (graze.test, graze.impact) == (What.GRAZE, 2)
            assert graze.angle == pytest.approx(1.25, abs=1e-12)
        assert rest == [Condition(What.FADE, slowest)]


@pytest.mark.parametrize(
    ("moved", "near"),
    [(0.0, True), (0.0999, True), (-0.0999, True), (0.1001, False), (-0.1001, False)],
)
def test_a_solution_is_the_point_looked_for_near_its_guess_alone(moved, near):
    """Within the room in both parameters, within the plane, impacts within TURNED (0.3 rad)."""
    found = search(Made(kind=Kind.FOLD))
    guess = Made(theta=[1.0, 2.0])
    meeting = Made(n=2, values=lambda u: (u[4], u[5]))

    def is_near(rpm, restitution, *thetas):
        u = [thetas[0], 9.0, thetas[1], 9.0, rpm, restitution]
        return found._near(meeting, u, guess, (360.0, 0.8), (1.0, 0.1))

    assert is_near(360.0, 0.8 + moved, 1.0, 2.0) == near
    assert is_near(360.0 + 10.0 * moved, 0.8, 1.0, 2.0) == near
    assert is_near(360.0, 0.8, 1.0, 2.0 + 3.0 * moved) == near
    assert is_near(360.0, 0.8, 1.0 + 3.0 * moved, 2.0) == near
    for rpm, inside in ((350.0, True), (349.999, False), (390.0, True), (390.001, False)):
        u = [1.0, 9.0, 2.0, 9.0, rpm, 0.8]
        assert found._near(meeting, u, guess, (rpm, 0.8), (1.0, 1.0)) == inside


CORNER, SECOND = Condition(What.CORNER, 1, 1), Condition(What.CORNER, 2, -1)
FOLD, FLIP, FADE, GRAZE = (
    Condition(What.FOLD),
    Condition(What.FLIP),
    Condition(What.FADE, 1),
    dip(0, 1.0),
)


@pytest.mark.parametrize(
    ("own", "other", "kind"),
    [
        (FOLD, GRAZE, PointKind.FOLD_GRAZING),
        (FADE, FOLD, PointKind.FOLD_GRAZING),
        (GRAZE, FLIP, PointKind.PERIOD_DOUBLING_GRAZING),
        (FLIP, FADE, PointKind.PERIOD_DOUBLING_GRAZING),
        (FOLD, Condition(What.CUSP), PointKind.CUSP),
        (CORNER, FOLD, PointKind.CORNER_IMPACT_FOLD),
        (FLIP, CORNER, PointKind.CORNER_IMPACT_PERIOD_DOUBLING),
        (CORNER, SECOND, PointKind.DOUBLE_CORNER_IMPACT),
        (SECOND, FADE, PointKind.CORNER_IMPACT_GRAZING),
        (CORNER, FADE, PointKind.CORNER_GRAZING),  # the impact that fades is the one at the corner
        (CORNER, GRAZE, PointKind.CORNER_IMPACT_GRAZING),
        (GRAZE, dip(1, 1.0), PointKind.DOUBLE_GRAZING),
        (FADE, Condition(What.FADE, 2), PointKind.DOUBLE_GRAZING),
        (GRAZE, FADE, PointKind.DOUBLE_GRAZING),
        (GRAZE, Condition(What.GRAZE_AT_CORNER, 0, 1), PointKind.CORNER_GRAZING),
    ],
)
def test_how_two_conditions_at_once_are_called(machine, own, other, kind):
    system, root = machine
    meeting = Made(
        root_at=lambda u: root, values=lambda u: (RPM, 0.8), conditions=(own, other),
        bracketed=lambda u: ((0.5, 0.25), 1e-9, Bracket.OK),
    )  # fmt: skip
    point = search(Made(kind=Kind.FOLD), system)._point(meeting, [])
    names = "fabcdef"  # the corner at the start of each stretch: 0 deg is none
    wanted = []
    for one in (own, other):
        if one.test == What.CORNER:
            upper = int(np.searchsorted(ENDS, root.theta[one.impact]))
            at = upper if one.side > 0 else upper - 1
            wanted.append(names[at] if 0 < at < 7 else "")
    assert (point.kind, point.corners) == (kind, tuple(wanted))
    assert (point.before, point.behind, point.errors) == (-1e-9, 1e-9, (0.5, 0.25))
    assert (point.first, point.second, point.curves) == (RPM, 0.8, (4,))


def test_a_point_is_looked_for_where_a_function_that_is_linear_would_be_zero(monkeypatch):
    """From -1 to 3 that is at a quarter of the way, in every unknown and both parameters."""
    monkeypatch.setattr(_CurveSearch, "_pairs", lambda self, a, b: [(a, b)])
    monkeypatch.setattr(_CurveSearch, "_corner_passed", lambda *_: [])
    monkeypatch.setattr(_CurveSearch, "values", lambda self, root: (root.x[-1], 10.0 * root.x[-1]))
    monkeypatch.setattr(_CurveSearch, "own", lambda self, root: FOLD)
    monkeypatch.setattr(_CurveSearch, "_tests", lambda self, root: root.tests)
    solved = []

    def note(self, guess, values, room, condition):
        solved.append((guess.x, values, room, condition))
        return iter(())

    monkeypatch.setattr(_CurveSearch, "_solved", note)
    monkeypatch.setattr(codim2, "replace", lambda root, x: Made(x=x))
    here = Made(x=[1.0, 2.0, 4.0], tests={FLIP: -1.0, CORNER: 2.0, GRAZE: 0.0})
    there = Made(x=[2.0, 6.0, 8.0], tests={FLIP: 3.0, CORNER: 1.0, FADE: -5.0, GRAZE: 0.0})
    assert not list(search(Made(kind=Kind.FOLD)).between(here, there))
    assert solved == [([1.25, 3.0, 5.0], [5.0, 50.0], (4.0, 40.0), FLIP)]


def test_a_doubled_orbit_is_looked_for_as_the_single_one(monkeypatch, machine):
    """Its two halves may lie TURNED (0.3 rad) apart; the corner is met by impact k of the half."""
    _, root = machine
    doubled = replace(
        root, x=[1.0, 0.5, 2.0, 0.25, 1.1, 0.7, 2.2, 0.45, 361.0], whole=(1, 0, 2, 0, 1, 1, 2, 1),
        turns=2, rates=[-0.1, -0.2, -0.3, -0.4], tangent=[*range(9)],
    )  # fmt: skip
    solved = []

    def note(self, single, values, room, condition, own):
        solved.append((single, condition, own))
        return iter(())

    monkeypatch.setattr(_CurveSearch, "_solved", note)
    monkeypatch.setattr(_CurveSearch, "values", lambda *_: (361.0, 0.8))
    for impact in (1, 3):
        located = Condition(What.CORNER, impact, -1)
        monkeypatch.setattr(_CurveSearch, "own", lambda self, root, one=located: one)
        found = _CurveSearch(None, Made(located=True), 1, PLANE)
        assert not list(found._collapse(doubled, (1.0, 1.0)))
        single, condition, own = solved.pop()
        assert single.x == pytest.approx([1.05, 0.6, 2.1, 0.35, 361.0])
        assert (single.whole, single.turns, single.rates) == ((1, 0, 2, 0), 1, [-0.1, -0.2])
        assert single.tangent == [0, 1, 2, 3, 8]
        assert (condition, own) == (FLIP, Condition(What.CORNER, 1, -1))
    apart = replace(doubled, x=[1.0, 0.5, 2.0, 0.25, 1.1, 0.7, 2.3001, 0.45, 361.0])
    close = replace(doubled, x=[1.0, 0.5, 2.0, 0.25, 1.1, 0.7, 2.2999, 0.45, 361.0])
    for one, count in ((apart, 0), (close, 1), (replace(doubled, turns=3), 0)):
        solved.clear()
        assert not list(_CurveSearch(None, Made(located=True), 1, PLANE)._collapse(one, (1.0, 1.0)))
        assert len(solved) == count


@pytest.mark.parametrize("condition", [FOLD, FLIP, FADE, CORNER])
def test_the_trace_at_a_point_is_that_of_its_condition(machine, condition):
    """1 + det at a fold, -(1 + det) at a doubling, without bound where an impact fades."""
    system, root = machine
    with precision(40):
        meeting = Meeting(system, PLANE, root, [condition])
        found = meeting.root_at(meeting.start(root, (RPM, 0.8)))
    wanted = {What.FOLD: 1.0 + root.det, What.FLIP: -1.0 - root.det, What.FADE: inf}
    assert found.trace == pytest.approx(wanted.get(condition.test, root.trace), rel=1e-9)
    assert found.rates == pytest.approx(root.rates, rel=1e-10)
    assert found.x == pytest.approx(root.x, rel=1e-12)


def test_the_corner_at_either_end_of_a_stretch_is_that_at_its_phase():
    """Also behind the last stretch: the rise begins at 0 deg, where c'' jumps."""
    rise = {"start_deg": 0.0, "length_deg": 100.0, "law": "harmonic"}
    cam = LawCam(kind="law", base=0.0, lift=0.01, rise=rise,
                 fall={"length_deg": 80.0, "law": "harmonic"})  # fmt: skip
    system = System.build(Follower(mass=1.0, stiffness=1000.0), cam, 4.0)
    names = {
        round(np.degrees(corner.theta)) % 360: corner.name for corner in corner_list(system.cam)
    }
    assert sorted(names) == [0, 100, 180]
    found = _CurveSearch(system, Made(located=True), 1, PLANE)
    for i, stretch in enumerate(system.cam.stretches):
        root = Made(stretch=lambda k, i=i: i)
        for side, phase in ((-1, stretch.start), (1, stretch.end)):
            name = names.get(round(np.degrees(phase)) % 360, "")
            assert found._corner(root, 0, side) == name, (i, side)
    assert found._corner(Made(stretch=lambda k: len(system.cam.stretches) - 1), 0, 1) == names[0]


@pytest.mark.parametrize("end", [0, 1])
def test_what_ended_a_curve_is_looked_for_from_the_root_that_was_refused_there(monkeypatch, end):
    asked = []

    def causes(self, root, beyond):
        asked.append((root, beyond))
        return iter(())

    monkeypatch.setattr(_CurveSearch, "_causes", causes)
    monkeypatch.setattr(_CurveSearch, "_conserves", lambda self, point: False)
    monkeypatch.setattr(_CurveSearch, "_collapse", lambda self, root, room: iter(()))
    points = [Made(orbit=Made(root=name)) for name in ("first", "middle", "last")]
    curve = Made(located=True, points=points, ends=[Kind.LOST, Kind.GRAZING],
                 beyond=["before all", "behind all"])  # fmt: skip
    assert not list(_CurveSearch(None, curve, 1, PLANE).at_end(end))
    assert asked == [(("first", "before all"), ("last", "behind all"))[end]]
