"""Branches: bifurcations against the oracle, every point solved again, ends, odd ranges."""

import itertools
from functools import cache
from itertools import pairwise
from math import isfinite, nextafter, pi
from types import SimpleNamespace

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import BranchStep, Metric, Span
from camcli.analysis.orbits.locate import _before_corner
from camcli.analysis.orbits.orbit import _since_strobe
from camcli.analysis.orbits.shooter import Shooter, with_machine
from camcli.analysis.orbits.study import Branch, OrbitsQuestion, orbits
from camcli.kernel.cam_table import TURN
from tests.conftest import chapter_system, settings
from tests.support import oracle
from tests.support.orbit_oracle import (
    DOUBLED,
    GRAZE,
    STABLE,
    THRICE,
    TWICE,
    UNSTABLE,
    B,
    C,
    Machine,
    corner_rpm,
    fold_rpm,
    gap_graze_rpm,
    period_doubling_rpm,
)

pytestmark = pytest.mark.slow

CAM = oracle.ArcsCam()
CHAPTER = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}


@cache
def _studied(rpm, parameter, span, label, transient, changes):
    wanted = None if label is None else Label.parse(label)
    question = OrbitsQuestion(rpm, parameter, Span(*span), wanted, starts=1)
    return orbits(chapter_system(**dict(changes)), settings(transient=transient), question)


def studied(rpm, low, high, parameter="rpm", label=None, transient=60, points=60, **changes):
    """A study with few starts, made once for all tests."""
    span = low, high, (high - low) / points
    return _studied(rpm, parameter, span, label, transient, tuple(sorted(changes.items())))


def events(result, kind, label=None):
    return [b for b in result.bifurcations if b.kind == kind and label in (None, b.label)]


def relative(value, exact, tolerance=1e-11):
    assert abs(mpf(value) - exact) <= tolerance * abs(exact), (value, exact)


def claimed(event, exact, times=10):
    """The value is within its error, and that is not so many times what is off.

    The smallest half width that is tried is 1e-13 of the value, some hundred roundings of it.
    """
    off = abs(mpf(event.value) - exact)
    assert off <= event.error
    assert event.error <= max(times * off, 1.01e-13 * abs(exact)), (off, event.error)


MACHINES = {
    "base": ({}, "673.234445003812", "739.319780216002", "739.377929649277"),
    "b": ({"damping": 2.0}, "679.166437752676", "739.075742370577", "739.156414773701"),
}


@pytest.mark.parametrize("name", MACHINES)
def test_bifurcations_of_p11_agree_with_the_oracle(name):
    """Corner b, period doubling, corner c: speeds 1e-11, traces 1e-8, determinants 1e-13."""
    changes, *known = MACHINES[name]
    machine = Machine(**{**CHAPTER, **changes})
    result = studied(700.0, 660.0, 760.0, **changes)
    exact_b = corner_rpm(CAM, machine, STABLE, 1, 0, B, 680)
    exact_2 = period_doubling_rpm(CAM, machine, STABLE, 1, 700, 745, steps=2)
    exact_c = corner_rpm(CAM, machine, DOUBLED, 2, 1, C, exact_2.rpm + mpf("0.05"))
    for exact, value in zip((exact_b, exact_2, exact_c), known, strict=True):
        relative(mpf(value), exact.rpm, 1e-14)
    corners = [b for b in events(result, "corner-impact", "P(1;1)") if b.corner == "b"]
    assert len(corners) == 2  # once on either branch
    (flip,) = events(result, "period-doubling", "P(1;1)")
    (corner_c,) = events(result, "corner-impact", "P(2;1:1)")
    assert corner_c.corner == "c"
    claimed(flip, exact_2.rpm)
    relative(flip.orbit.trace, exact_2.orbit.trace, 1e-8)
    relative(flip.orbit.det, exact_2.orbit.det, 1e-13)
    for found, exact in ((corners[0], exact_b), (corners[1], exact_b), (corner_c, exact_c)):
        claimed(found, exact.rpm)
        for side, orbit in ((found.left, exact.left), (found.right, exact.right)):
            relative(side.trace, orbit.trace, 1e-8)
            relative(side.det, orbit.det, 1e-13)
        assert found.agrees
    assert {b.classification for b in corners} == {"nonsmooth-fold"}
    for b in result.bifurcations:
        assert b.status == "ok"


def test_grazing_of_the_unstable_orbit_agrees_with_the_oracle():
    (found,) = events(studied(700.0, 660.0, 800.0), "grazing")
    exact = gap_graze_rpm(CAM, Machine(**CHAPTER), UNSTABLE, 1, 0, 780, GRAZE)
    claimed(found, exact.rpm)
    assert found.located.impact == 0
    assert found.located.fading is None


def test_the_orbit_of_three_turns():
    """Fold and period doubling of P(3;3:3:2); the branch passes the fold smoothly."""
    result = studied(358.5, 350.0, 360.5, label="P(3;3:3:2)", transient=300, points=30)
    fold = fold_rpm(CAM, Machine(**CHAPTER), THRICE, 3, 358)
    flip = period_doubling_rpm(CAM, Machine(**CHAPTER), THRICE, 3, 358.5, 361, steps=2)
    (found,) = events(result, "fold", "P(3;3:3:2)")
    claimed(found, fold.rpm)
    assert abs(1 - found.orbit.trace + found.orbit.det) < 1e-5
    (found,) = events(result, "period-doubling", "P(3;3:3:2)")
    claimed(found, flip.rpm)
    branch = result.branches[0]
    assert branch.ends == ("end-of-range", "end-of-range")
    assert [branch.points[0].value, branch.points[-1].value] == [360.5, 360.5]
    assert abs(min(p.value for p in branch.points) - fold.rpm) < 1e-9
    assert {p.stable for p in branch.points} == {True, False}


def test_the_orbit_of_two_impacts_ends_at_b():
    result = studied(358.5, 340.0, 365.0, label="P(1;2)", transient=300, points=30)
    exact = corner_rpm(CAM, Machine(**CHAPTER), TWICE, 1, 0, B, 355.2)
    assert result.branches[0].ends == ("corner-impact", "end-of-range")
    corner = next(b for b in events(result, "corner-impact", "P(1;2)") if b.branch == 1)
    claimed(corner, exact.rpm)
    relative(corner.left.trace, exact.left.trace, 1e-8)
    relative(corner.right.trace, exact.right.trace, 1e-8)
    assert (corner.corner, corner.agrees, corner.continues) == ("b", True, 2)


def test_the_resting_branch():
    """P(1;inf): from the detachment, by a departure at d, to the completion of the chatter."""
    result = studied(190.0, 100.0, 220.0, transient=10)
    (branch,) = result.branches
    assert branch.labels == ["P(1;inf)"]
    assert branch.ends == ("detachment", "chatter-completion")
    (found,) = events(result, "detachment")
    claimed(found, oracle.first_detachment_rpm(CAM, CHAPTER["mass"], CHAPTER["stiffness"]))
    assert found.beyond == "contact"
    departure = events(result, "departure")[0]
    assert abs(departure.value - 136.3124) < 1e-4
    assert departure.corner == "d"
    assert abs(events(result, "chatter-completion")[-1].value - 198.5605) < 1e-4
    values = [p.value for p in branch.points]
    assert {found.value, departure.value} <= set(values)  # a row at each event, the last before it
    assert (values[0], values[-1]) == (
        found.value, events(result, "chatter-completion")[-1].value
    )  # fmt: skip
    assert values == sorted(set(values))  # no speed twice, none farther apart than asked
    assert max(b - a for a, b in pairwise(values)) <= 2.0 * (1.0 + 1e-9)


BRANCHES = {
    "speed": (700.0, 660.0, 760.0, "rpm", {}),
    "many impacts": (358.5, 350.0, 360.5, "rpm", {}),
    "restitution": (700.0, 0.0, 1.0, "restitution", {}),
    "damping": (700.0, 0.0, 10.0, "damping", {"damping": 2.0}),
    "gravity": (700.0, -20.0, 20.0, "gravity", {}),
}


@pytest.mark.parametrize("name", BRANCHES)
def test_every_point_of_a_branch_is_an_orbit(name):
    """Certified, and one period of simulation returns to it; the ends are the range's or events."""
    rpm, low, high, parameter, changes = BRANCHES[name]
    if name == "many impacts":
        result = studied(rpm, low, high, label="P(3;3:3:2)", transient=300, points=30)
    else:
        result = studied(rpm, low, high, parameter, **changes)
    shooter = Shooter(chapter_system(**changes), rpm, parameter)
    assert result.branches
    for branch in result.branches:
        assert len(branch.points) > 5
        for n, point in enumerate(branch.points):
            assert low <= point.value <= high
            at_event = any(abs(point.value - b.value) < 1e-9 for b in result.bifurcations)
            if not at_event:
                assert shooter.admits(point.root)
                assert point.primitive
            if point.stable and n % 3 == 0:
                _returns(shooter, point)
        for end, point in zip(branch.ends, (branch.points[0], branch.points[-1]), strict=True):
            assert end != "lost"
            if end == "end-of-range":
                assert point.value in (low, high)
            elif end != "period-doubling":
                there = [b.value for b in result.bifurcations if b.kind == end]
                assert min(abs(x - point.value) for x in there) <= 1e-12 * abs(point.value)


def _returns(shooter, point):
    system, rpm = with_machine(shooter.system, point.root.machine)
    omega = rpm * (pi / 30)
    q, w = point.states[0]
    tape = Orbit(system, rpm, settings(record=point.turns + 1, q=q, v=w * omega)).run()
    sizes = [max(abs(s[j]) for s in point.states) for j in range(2)]
    ends = float(tape.strobe_q[point.turns]), float(tape.strobe_w[point.turns])
    for j in range(2):
        assert abs(ends[j] - point.states[0][j]) < 1e-10 * sizes[j], point.value


@pytest.mark.parametrize(("seed", "points"), [(739.0, 60), (700.0, 11)])
def test_neither_the_seed_nor_the_spacing_moves_a_bifurcation(seed, points):
    one, two = (
        sorted((b.kind, b.label, b.corner, b.value, b.error) for b in result.bifurcations)
        for result in (studied(700.0, 660.0, 760.0), studied(seed, 660.0, 760.0, points=points))
    )
    assert [x[:3] for x in one] == [x[:3] for x in two]
    for a, b in zip(one, two, strict=True):
        assert abs(a[3] - b[3]) <= a[4] + b[4] < 1e-11 * a[3]


OTHERS = {
    "damping": (0.0, 12.0), "stiffness": (1400.0, 1600.0), "mass": (1.1, 1.25),
}  # fmt: skip


@pytest.mark.parametrize("parameter", OTHERS)
def test_a_bifurcation_met_in_another_parameter_is_the_same(parameter):
    """Along another constant to the corner at b, there the oracle's speed is the speed used."""
    result = studied(700.0, *OTHERS[parameter], parameter)
    found = next(b for b in events(result, "corner-impact", "P(1;1)") if b.corner == "b")
    machine = Machine(**{**CHAPTER, parameter: found.value})
    assert found.error <= 1.01e-12 * found.value
    relative(700.0, corner_rpm(CAM, machine, STABLE, 1, 0, B, 695).rpm, 1e-12)


def test_the_doubled_branch_ends_where_it_was_born():
    """Downwards from 739.35 P(2;1:1) ends at the period doubling of P(1;1), and is no P(1;1)."""
    result = studied(739.35, 738.0, 745.0, label="P(2;1:1)", transient=300)
    assert not events(result, "fold")
    assert all(p.primitive for branch in result.branches for p in branch.points)
    assert min(p.value for p in result.branches[0].points) > 739.31978
    assert len(events(result, "corner-impact")) == 1


def test_a_doubled_orbit_that_is_born_beside_a_corner_is_none_twice():
    """A period doubling 1e-4 from the corner b: the new branch must not be P(1;1) gone twice."""
    machine = {"restitution": 0.51, "damping": 4.84}
    result = studied(729.2, 0.44, 0.55, "restitution", transient=120, **machine)
    assert events(result, "period-doubling")
    for branch in result.branches:
        assert all(p.primitive for p in branch.points), branch.origin


def test_a_single_impact_that_fades():
    """P(2;1:0) without damping: a flight of a whole period of the spring comes back as it left.

    Two turns are that period at 2 omega0, where u+ = -r u- = -u- leaves u = 0 alone.
    """
    result = studied(700.0, 640.0, 720.0, label="P(2;1:0)", preload=-500.0)
    zero = 60 * mp.sqrt(mpf(CHAPTER["stiffness"]) / mpf(CHAPTER["mass"])) / mp.pi
    (found,) = events(result, "grazing")
    claimed(found, zero)
    assert found.located.fading == 0


ODD = {
    "springless": (300.0, 250.0, 350.0, "rpm", {"stiffness": 0.0, "gravity": 9.81}),
    "plastic": (700.0, 660.0, 760.0, "rpm", {"restitution": 0.0}),
    "tiny range": (700.0, 700.0 - 5e-7, 700.0 + 5e-7, "rpm", {}),
    "an end at the corner": (700.0, 673.2344450038121, 720.0, "rpm", {}),
    "huge range": (700.0, 10.0, 1e5, "rpm", {}),
    "resting, restitution 0 to 1": (190.0, 0.0, 1.0, "restitution", {}),
    "stiffness to 0": (700.0, 0.0, 2000.0, "stiffness", {}),
}


@pytest.mark.parametrize("name", ODD)
def test_odd_machines_and_ranges_have_finite_answers(name):
    rpm, low, high, parameter, changes = ODD[name]
    result = studied(rpm, low, high, parameter, transient=40, points=40, **changes)
    assert result.branches
    points = [p for branch in result.branches for p in branch.points]
    for o in [*result.orbits, *result.virtual, *points]:
        numbers = [o.rpm, o.value, *o.theta, *o.rates, o.trace, o.det, *map(abs, o.multipliers)]
        assert all(isfinite(x) for x in [*numbers, *itertools.chain(*o.states)]), o
    assert all(low <= x.value <= high for x in [*points, *result.bifurcations])
    assert all(isfinite(b.error) for b in result.bifurcations)


def test_a_seed_or_an_end_exactly_at_a_period_doubling():
    result = studied(739.3197802160017, 700.0, 760.0)
    assert len(events(result, "period-doubling", "P(1;1)")) == 1
    (stable, _) = studied(700.0, 690.0, 739.3197802160017).branches
    assert stable.points[-1].value == pytest.approx(739.3197802160017, rel=1e-14)


CHAOTIC = {
    "preload": (754.4, (-30.0, 60.0), {"restitution": 0.304, "gravity": 9.81}),
    "damping": (
        740.7,
        (0.0, 12.0),
        {"restitution": 0.477, "damping": 1.82, "gravity": 9.81, "preload": 15.3},
    ),
}


@pytest.mark.parametrize("parameter", CHAOTIC)
def test_small_chaos_beside_a_corner_is_not_called_periodic(parameter):
    """Robust chaos just beyond the corner b: the normal form and the simulation agree."""
    rpm, (low, high), changes = CHAOTIC[parameter]
    result = studied(rpm, low, high, parameter, transient=120, **changes)
    found = [b for b in events(result, "corner-impact", "P(1;1)") if b.corner == "b"]
    assert {b.classification for b in found} == {"robust-chaos"}
    assert all(b.agrees is not False for b in found)


STRETCHES = {  # values and stabilities along a branch, its events, where it comes from: the ranges
    "all": ([1, 2, 3], "sss", [], None, [(0, 2, 1, 3)]),
    "none": ([1, 2, 3], "uuu", [2], None, []),
    "up to an event": ([1, 2, 3, 4], "ssuu", [3], None, [(0, 1, 1, 3)]),
    "from an event": ([1, 2, 3, 4], "uuss", [2], None, [(2, 3, 2, 4)]),
    "no event beside it": ([1, 2, 3, 4], "ussu", [], None, [(1, 2, 2, 3)]),
    "twice": ([1, 2, 3, 4, 5], "suuss", [2, 3], None, [(0, 0, 1, 2), (3, 4, 3, 5)]),
    "downwards": ([9, 8, 7, 6], "ssuu", [7], None, [(0, 1, 7, 9)]),
    "round a fold": ([5, 6, 7, 6.5, 6], "ssuuu", [7], None, [(0, 1, 5, 7)]),
    "born at a doubling": ([6, 7, 8], "ssu", [8], 5, [(0, 1, 5, 8)]),
    "born, and stable later": ([6, 7, 8], "uss", [], 5, [(1, 2, 7, 8)]),
    "rounding at its last event": ([1, 2, 3 - 1e-11, 3 + 1e-10], "ssus", [3], None, [(0, 3, 1, 3)]),
    "rounding beside it": ([1, 2, 3 + 1e-10, 4], "ssuu", [3], None, [(0, 1, 1, 3)]),
    "not stable beyond": ([1, 2, 3 - 1e-11, 4], "ssuu", [3], None, [(0, 1, 1, 3)]),
    "between two events": ([1, 2, 3, 4], "susu", [2, 4], None, [(0, 2, 1, 4)]),
}


@pytest.mark.parametrize("name", STRETCHES)
def test_ranges_of_stable_orbits_end_at_the_events_beside_them(name):
    values, kinds, events, source, wanted = STRETCHES[name]
    points = [SimpleNamespace(value=x, stable=k == "s") for x, k in zip(values, kinds, strict=True)]
    found = [SimpleNamespace(value=x, branch=3, continues=None) for x in events]
    found.append(SimpleNamespace(value=6.5, branch=4, continues=None))  # of another branch
    if source is not None:
        found.append(SimpleNamespace(value=source, branch=1, continues=3))
    branch = SimpleNamespace(number=3, points=points)
    told = Branch.stable_stretches(branch, found)
    assert [(rows[0], rows[-1], *ends) for rows, ends in told] == wanted


@pytest.mark.parametrize(
    ("values", "turns"),
    [([1, 2, 3], []), ([1, 3, 2], [3]), ([1, 3, 3, 2], [3]), ([1, 3, 2, 4], [3, 2]),
     ([5, 4, 3, 4], [3]), ([1, 3, nextafter(3.0, 0.0), 4], []), ([7], []), ([2, 1], [])],
)  # fmt: skip
def test_a_branch_turns_round_where_its_parameter_does(values, turns):
    branch = SimpleNamespace(points=[SimpleNamespace(value=float(x)) for x in values])
    assert Branch.turning_points.fget(branch) == turns


@pytest.mark.parametrize(
    ("theta", "turns", "places"),
    [
        ((1.0, 2.0), (0, 1), [1.0, TURN + 2.0]),
        ((1.0, TURN), (0, 1), [0.0, 1.0]),  # 360 deg at the end of the period
        ((1.0, TURN), (0, 0), [1.0, TURN]),  # at the end of its first turn
        ((-5e-30, 2.0), (0, 0), [0.0, 2.0]),  # before the strobe by less than rounding
    ],
)
def test_an_impact_at_the_strobe_begins_a_turn(theta, turns, places):
    root = SimpleNamespace(theta=theta, turn=lambda k: turns[k], turns=2)
    since = _since_strobe(SimpleNamespace(strobe=0.0), root)
    assert [place for place, _ in since] == places


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("start", "found"), [(0.7, 1.0), (0.9, 1.0), (1.0, 1.0), (1.05, 1.05)])
def test_a_branch_ends_at_the_last_root_before_its_corner(start, found, side):
    """The impact moves by 0.4 rad over a step, towards a corner at 1 rad, or is there."""

    def at(_, length):
        return SimpleNamespace(theta=[0.0, side * (start + 0.4 * length)])

    step = SimpleNamespace(before=at(None, 0.0), after=at(None, 1.0), length=1.0, at=at)
    shooter = SimpleNamespace(edge=lambda root, k, side: side)
    last = side * _before_corner(shooter, step, 1, side).theta[1]
    assert found - 1e-12 < last <= found


def test_a_step_is_cut_in_two_at_a_root_on_it():
    """Lengths are along the tangents where each part begins; the branch bends at the root.

    The weights are 4 and 1, so that (0.5, 0) and (0, 1) have the length 1.
    """
    metric = Metric(np.array([4.0, 1.0]))
    places = ((0.0, 0.0), (1.0, 0.5), (2.0, 3.0))
    before, root, after = (SimpleNamespace(x=np.array(x)) for x in places)
    root.tangent = np.array([-3.0, -8.0])  # of the length 10, and turned round
    step = BranchStep(before, np.array([0.5, 0.0]), after, 7.0, metric)
    first, rest = step.cut(root), step.rest(root)
    assert (first.before, first.after, first.length) == (before, root, pytest.approx(2.0))
    assert first.unit is step.unit
    assert (rest.before, rest.after) == (root, after)
    assert rest.unit == pytest.approx([0.3, 0.8])
    assert rest.length == pytest.approx(4.0 * 0.3 * 1.0 + 0.8 * 2.5)
    assert (first.metric, rest.metric) == (metric, metric)
    assert step.reach(after) == pytest.approx(4.0)
