"""Along a branch nothing changes without an event: what `stable` says is never left unexplained."""

from fractions import Fraction
from itertools import pairwise
from math import pi
from random import Random
from types import SimpleNamespace

import pytest
from mpmath import cos, exp, findroot, mp, mpf, radians, sin, sqrt

from camcli.analysis.integrate import budgeted
from camcli.analysis.labels import Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import (
    ERRORS,
    Bracket,
    _bracket,
    _root_of,
    beyond_both,
    smooth_events,
)
from camcli.analysis.orbits.study import OrbitsQuestion, orbits
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
from camcli.system import Follower, System
from tests.conftest import chapter_system, settings
from tests.support.oracle import ArcsCam
from tests.support.orbit_oracle import Machine, solve

pytestmark = pytest.mark.slow

CAM = ArcsCam()
RUN = settings(transient=60, record=20)
ENOUGH = 40_000_000  # evaluations: a study is cut short after them


def unexplained(result):
    """(branch, value, value) of neighbouring points that differ in `stable`, neither an event.

    Points of a machine that loses nothing are left out: both multipliers are on the unit circle.
    """
    found = []
    for branch in result.branches:
        events = [b.orbit for b in result.bifurcations if b.branch == branch.number]
        for a, b in pairwise(branch.points):
            told = any(same(point, event) for point in (a, b) for event in events)
            if a.stable != b.stable and not told and max(a.det, b.det) < 1.0:
                found.append((branch.number, a.value, b.value))
    return found


def same(point, event):
    """True where a point of a branch is an event, seen from either side.

    The event of a doubled orbit is one of the single orbit, gone through twice; nearer to it than
    1e-10 the multiplier of the doubled one, which is 1 there, is above or below that by rounding.
    """
    if abs(point.value - event.value) > 1e-10 * abs(event.value) or len(point.theta) % len(
        event.theta or (0.0,)
    ):
        return False
    times = len(point.theta) // max(1, len(event.theta))
    away = (abs(a - b) for a, b in zip(point.theta, event.theta * times, strict=True))
    near = 1e-6 if times == 1 else 1e-4  # a doubled orbit opens with the root of the parameter
    return all(min(x, 2 * pi - x) < near for x in away)


def study(system, rpm, low, high, parameter="rpm", points=30, label=None, starts=3):
    wanted = None if label is None else Label.parse(label)
    question = OrbitsQuestion(
        rpm, parameter, Span(low, high, (high - low) / points), wanted, starts=starts
    )
    with budgeted(ENOUGH, lambda done, limit: None):
        return orbits(system, RUN, question)


# -- a fold and a grazing side by side ---------------------------------------------------------

BASE, LIFT, AT = -1.9225202303303943, 1.8450404606607889, 7.525208582654958


def impact_oscillator(base=BASE, **changes):
    """The forced impact oscillator near a point where a fold of P(2;1:0) meets its grazing."""
    follower = {"mass": 1.0, "stiffness": 1.0, "damping": 0.04, "restitution": 0.9, **changes}
    return System.build(Follower(**follower), EccentricCam(kind="eccentric", base=base, lift=LIFT))


def exact_fold(base, rpm, degrees, rate):
    """rpm at which gap(theta, v) = 0 = v + r u has a singular Jacobian, after two turns."""
    with mp.workdps(40):
        base, lift, zeta, r = mpf(base), mpf(LIFT), mpf(0.04) / 2, mpf(0.9)
        f = sqrt(1 - zeta * zeta)

        def equations(theta, v, omega):
            t, q0, v0 = 4 * mp.pi / omega, base + lift * (1 - cos(theta)) / 2, None
            slope = omega * lift * sin(theta) / 2
            v0 = slope + v
            fall, c, s = exp(-zeta * t), cos(f * t), sin(f * t) / f
            q = fall * (q0 * c + (v0 + zeta * q0) * s)
            w = fall * (v0 * c - (q0 + zeta * v0) * s)
            return q - q0, v + r * (w - slope)

        def jacobian(*x):
            (a, b), (c, d) = (
                [mp.diff(lambda *y, i=i: equations(*y)[i], x, by) for by in ((1, 0, 0), (0, 1, 0))]
                for i in (0, 1)
            )
            return a * d - b * c

        guess = radians(mpf(degrees)), mpf(rate), mpf(rpm) * mp.pi / 30
        found = findroot(lambda *x: [*equations(*x), jacobian(*x)], guess)
        return found[2] * 30 / mp.pi


def test_a_fold_on_the_step_of_a_grazing_is_the_closed_forms():
    speeds = 7.497515622556969, 7.554811402070051
    result = study(impact_oscillator(), AT, *speeds, points=100, label="P(2;1:0)")
    fold, graze = result.bifurcations
    assert (fold.kind, graze.kind) == ("fold", "grazing")
    truth = exact_fold(BASE, fold.value, fold.orbit.theta[0] * 180 / pi, 0.9 * 1.373)
    assert abs(fold.value - truth) < 4e-15 * truth
    assert fold.value - graze.value == pytest.approx(6.29e-8, rel=1e-2)
    assert not unexplained(result)


@pytest.mark.parametrize("points", [7, 101])
@pytest.mark.parametrize("by", [-1e-3, -1e-4, -1e-6, 1e-6, 1e-4, 1e-3])
def test_beside_it_and_in_any_steps_too(by, points):
    result = study(
        impact_oscillator(BASE + by), AT, 7.3, 7.7, points=points, starts=1, label="P(2;1:0)"
    )
    assert result.branches
    assert not unexplained(result)


# -- the same in any number of steps -----------------------------------------------------------


def law_machine(law="modified-sine", **changes):
    flank = {"law": law, "length_deg": 90}
    rise = {**flank, "start_deg": 60}
    shape = LawCam(kind="law", base=0.25, lift=0.5, rise=rise, top_dwell_deg=30, fall=flank)
    return System.build(Follower(**{"mass": 0.58, "stiffness": 14.37, **changes}), shape)


def test_an_impact_that_leaves_its_region_within_a_long_step_is_followed_beyond_it():
    """From far behind the boundary Newton's method does not find it: that was taken for a graze."""
    system, span = law_machine(restitution=0.57), (0.0, 4.823)
    long, short = (
        study(system, 397.4, *span, "damping", points, "P(4;1:0:0:0)") for points in (4, 60)
    )
    assert events(long) == events(short)
    assert [branch.ends for branch in long.branches] == [branch.ends for branch in short.branches]


def events(result):
    return sorted((b.kind, b.label, f"{b.value:.9g}") for b in result.bifurcations)


BUBBLE = {"mass": 3.2, "stiffness": 345.0, "damping": 18.28, "gravity": 9.81, "preload": -151.0,
          "restitution": 0.95}  # fmt: skip


@pytest.mark.parametrize("points", [3, 12, 100])
def test_two_doublings_within_a_step_are_both_found(points):
    """1 + trace + det of P(1;1) dips below zero from 117.559 to 119.168 rpm; the oracle agrees."""
    result = study(chapter_system(**BUBBLE), 125.0, 112.0, 180.0, points=points, label="P(1;1)")
    told = {f"{b.value:.9g}" for b in result.bifurcations if b.kind == "period-doubling"}
    found = sorted(map(float, told))
    assert found == [pytest.approx(117.55861, abs=1e-5), pytest.approx(119.16783, abs=1e-5)]
    (seed,) = (orbit for orbit in result.orbits if orbit.label == "P(1;1)" and orbit.theta[0] < 2.6)
    flips = []
    for rpm in (*(value + by for value in found for by in (-1e-6, 1e-6)),):
        impact = seed.theta[0], seed.root.x[1] * rpm * pi / 30
        orbit = solve(CAM, Machine(**BUBBLE), rpm, [impact], 1)
        flips.append(1 + orbit.trace + orbit.det > 0)
    assert flips == [True, False, False, True]


DIPS = [(0.3, -1e-3, True), (0.9, -1e-6, True), (0.6, 1e-6, False), (1.5, -1.0, False)]


@pytest.mark.parametrize(("x", "least", "seen"), DIPS)
def test_a_dip_below_zero_between_two_ends_is_looked_for(x, least, seen):
    """Of a curve that is no parabola, near its lowest point at x."""

    class Line:
        """A step of length 1 whose roots are their own distances."""

        before, after, length = 0.0, 1.0, 1.0

        def at(self, shooter, distance):
            return distance

    def curve(s):
        return least + (s - x) ** 2 * (1 + 0.3 * (s - x))

    assert (beyond_both(None, Line(), curve, 10.0) is not None) == seen


# -- any machine -------------------------------------------------------------------------------


def machine_of(rng):
    """A machine with a spring, and its speed in rpm."""
    omega, mass = 10 ** rng.uniform(0, 2), 10 ** rng.uniform(-1, 1)
    stiffness = mass * (omega * 10 ** rng.uniform(-1.2, 0.3)) ** 2
    constants = {
        "mass": mass,
        "stiffness": stiffness,
        "damping": 2 * sqrt(mass * stiffness) * rng.choice([0.0, rng.uniform(0, 0.3)]),
        "gravity": rng.choice([0.0, 9.81]),
        "preload": stiffness * rng.choice([0.0, rng.uniform(-0.5, 0.5)]),
        "restitution": rng.choice([rng.uniform(0.2, 0.99), 0.8, 0.95]),
    }
    constants = {name: float(value) for name, value in constants.items()}
    kind = rng.choice(["arcs", "eccentric", "law"])
    if kind == "arcs":
        system = chapter_system(**constants)
    elif kind == "law":
        system = law_machine(rng.choice(["cycloidal", "3-4-5", "harmonic"]), **constants)
    else:
        cam = EccentricCam(kind="eccentric", base=rng.choice([0.25, rng.uniform(-1, 1)]), lift=0.5)
        system = System.build(Follower(**constants), cam)
    return system, omega * 30 / pi


def explained(seed):
    """Follow the orbits of a machine: each change of stability is told."""
    rng = Random(seed)
    system, rpm = machine_of(rng)
    parameter = rng.choice(["rpm", "restitution", "damping", "stiffness", "preload"])
    f = system.follower
    low, high = {
        "rpm": (0.7 * rpm, 1.4 * rpm),
        "restitution": (0.1, max(0.99, f.restitution)),
        "damping": (0.0, 2 * f.damping + 0.02 * f.mass * rpm),
        "stiffness": (0.3 * f.stiffness, 2 * f.stiffness),
        "preload": (-0.6 * f.stiffness, 0.6 * f.stiffness),
    }[parameter]
    result = study(system, rpm, low, high, parameter, rng.choice([9, 30]), starts=2)
    assert not unexplained(result)
    for branch in result.branches:
        assert all(low <= point.value <= high for point in branch.points)


@pytest.mark.parametrize("seed", range(12))
def test_no_machine_gains_or_loses_stability_without_an_event(seed):
    explained(seed)


SHARP = {"rounding": lambda root: 0.0}  # of a shooter: rounding moves none of its roots


@pytest.mark.parametrize("relative", ERRORS)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_bracket_of_an_event_holds_its_zero(relative, side):
    """The test function is zero 0.9 widths off the root: the width that is told reaches it."""
    zero = 700.0 * (1.0 + 0.9 * side * relative)
    shooter = SimpleNamespace(moved=lambda root, value: SimpleNamespace(value=value), **SHARP)
    width, status = _bracket(shooter, SimpleNamespace(value=700.0), lambda root: root.value - zero)
    assert status == Bracket.OK
    assert abs(zero - 700.0) <= width <= 2.0 * abs(zero - 700.0)


@pytest.mark.parametrize("at", [Fraction(3, 10), Fraction(2, 3), Fraction(1, 7)])
def test_the_error_of_a_fold_reaches_the_ends_of_its_bracket(at):
    """A steep turn of the parameter between two lengths that doubles tell apart."""

    def root(_, length):
        off = Fraction(length) - at
        slope = -1.0 if off > 0 else 1.0
        return SimpleNamespace(value=float(700 - 10**7 * abs(off)), tangent=[slope], x=[length])

    step = SimpleNamespace(at=root, length=1.0, before=root(0, 0.0), after=root(0, 1.0))
    found = _root_of(
        SimpleNamespace(**SHARP), step, Kind.FOLD, lambda one: one.tangent[-1], 1.0, -1.0
    )
    assert found.status == Bracket.OK
    assert abs(found.root.value - 700.0) <= found.error <= 1e7 * 1e-12


@pytest.mark.parametrize(("flip", "fold"), [(0.3, 0.6), (0.8, 0.6), (0.2, 0.9)])
def test_events_of_a_step_are_in_the_order_in_which_it_meets_them(flip, fold):
    """A step on which the parameter turns at one place and 1 + trace + det is zero at another."""

    def root(length):
        value, slope = 700.0 - (length - fold) ** 2, -2.0 * (length - fold)
        trace = length - flip - 1.5
        return SimpleNamespace(value=value, trace=trace, det=0.5, tangent=[slope], length=length)

    def moved(one, value):
        side = 1.0 if one.length > fold else -1.0
        return root(fold + side * max(0.0, 700.0 - value) ** 0.5)

    step = SimpleNamespace(at=lambda _, length: root(length), length=1.0, before=root(0.0),
                           after=root(1.0), unit=[1.0])  # fmt: skip
    found = smooth_events(SimpleNamespace(moved=moved, **SHARP), step, True)
    wanted = sorted([(flip, Kind.PERIOD_DOUBLING), (fold, Kind.FOLD)])
    assert [event.kind for event in found] == [kind for _, kind in wanted]
    assert [event.reach for event in found] == pytest.approx([x for x, _ in wanted], abs=1e-6)
