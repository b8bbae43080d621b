"""Curves of bifurcations proved point by point: the enclosures hold what mpmath has."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace as Made

import pytest
from mpmath import mp, mpf

from camcli import load_scene, orbits
from camcli.analysis.orbits import curve_proofs, proofs
from camcli.analysis.orbits.curve_proofs import prove_curve
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.proofs import Proof, prove_on_curve
from camcli.exact.shooting import ProofStep
from tests.support.followed import Machines, Wave, arcs, at_corner, doubling, event, fold
from tests.support.oracle import Arc

pytestmark = pytest.mark.slow

OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {
        "kind": "oscillator",
        "damping": 0.1,
        "amplitude": 0.6,
        "frequency": 4,
        "clearance": -0.5,
    },
}
SPRUNG = {"mass": 1, "stiffness": 1, "damping": 0.1}
CHAPTER = {"mass": 1.221, "stiffness": 1430.8}


def proved(scene, kind, first, second, prove=True, **more):
    """`cam orbits --curve KIND --prove` for P(1;1) in two numbers, each (key, low, high)."""
    axes = [dict(zip(("key", "start", "stop"), one, strict=True), num=9) for one in (first, second)]
    overrides = {"orbits.vary": axes, "orbits.curve": kind, "orbits.label": "P(1;1)"}
    overrides |= {"orbits.branches": 0, "orbits.stability": "stable", **more}
    return orbits(load_scene(scene, overrides), prove=prove)


def pressed(amplitude, frequency) -> list:
    """The stop of the oscillator above."""
    spring, damper = 1 - frequency**2, mpf(0.1) * frequency
    share = amplitude / (spring**2 + damper**2)
    return [Wave(mpf("0.5"), spring * share, damper * share)]


def enclosures(result, key):
    """(low, high) of a number at each point of the curve."""
    table = result.tables["curve"]
    assert set(table["proved"]) == {"yes"}
    return list(zip(table[f"{key}_low"], table[f"{key}_high"], strict=True))


def check(result, keys, machines_at, condition):
    """Where one number is a double, the other one of own shooting lies in the enclosure."""
    (curve,) = result.values.curves
    ends = [enclosures(result, key) for key in keys]
    mp.dps = 40
    for k, point in enumerate(curve.points):
        values = (point.first, point.second)
        free = next(i for i in (0, 1) if ends[i][k][0] < ends[i][k][1])
        low, high = ends[free][k]
        assert ends[1 - free][k] == (values[1 - free], values[1 - free])
        given = mpf(values[1 - free])
        machines = machines_at(free, given)
        root = point.orbit.root
        guess = [(root.theta[0], root.x[1] * point.orbit.rpm * pi / 30)]
        exact, _ = event(machines, condition(free, given), guess, 1, values[free])
        assert low <= exact <= high, (k, exact, low, high)
        assert high - low < 1e-14 * abs(high)


@pytest.mark.parametrize(
    ("kind", "condition"),
    [
        pytest.param("fold", fold, marks=pytest.mark.soak),
        pytest.param("period-doubling", doubling, marks=pytest.mark.ci),
    ],
)
def test_points_of_an_oscillator_s_curves_are_enclosed(kind, condition):
    keys = "cam.amplitude", "cam.frequency"
    result = proved(OSCILLATOR, kind, (keys[0], 0.15, 2.0), (keys[1], 3.0, 5.0))

    def machines_at(free, given):
        if free == 0:
            return Machines(
                lambda p: dict(SPRUNG), lambda p: given * 30 / mp.pi, lambda p: pressed(p, given)
            )
        return Machines(
            lambda p: dict(SPRUNG), lambda p: p * 30 / mp.pi, lambda p: pressed(given, p)
        )

    check(result, keys, machines_at, lambda free, given: condition)


@pytest.mark.ci
def test_points_of_a_curve_of_corner_impacts_in_speed_and_nose_are_enclosed():
    keys = "rpm", "cam.nose_radius"
    result = proved(None, "corner-impact", (keys[0], 668.0, 682.0), (keys[1], 0.145, 0.155),
                    **{"run.rpm": 680.0})  # fmt: skip

    def cam_at(nose):
        return arcs(nose_radius=lambda p: nose)(0)

    def piece(cam) -> list[Arc]:
        return [cam.arcs[1]]

    def machines_at(free, given):
        if free == 0:
            return Machines(lambda p: dict(CHAPTER), lambda p: p, lambda p: piece(cam_at(given)))
        return Machines(lambda p: dict(CHAPTER), lambda p: given, lambda p: piece(cam_at(p)))

    def condition(free, given):
        if free == 0:
            return at_corner(0, lambda p: cam_at(given).breakpoints[1])
        return at_corner(0, lambda p: cam_at(p).breakpoints[1])

    check(result, keys, machines_at, condition)


@pytest.mark.ci
def test_a_point_beside_its_curve_is_not_proved():
    """Its number is off by more than any rounding, or its orbit by more than a root may be."""
    window = ("cam.amplitude", 0.2, 0.7), ("cam.frequency", 3.5, 4.5)
    result = proved(OSCILLATOR, "fold", *window, prove=False)
    (curve,) = result.values.curves
    point = curve.points[len(curve.points) // 2]
    assert prove_on_curve(result.system, curve, point).proved
    root = point.orbit.root
    off = replace(root, x=[*root.x[:-1], root.value * (1 + 1e-9)])
    moved = replace(point, orbit=replace(point.orbit, root=off))
    assert prove_on_curve(result.system, curve, moved).step == ProofStep.NUMBER
    assert prove_on_curve(result.system, replace(curve, located=None), point) == Proof(
        ProofStep.MODEL
    )


@pytest.mark.parametrize("kind", [Kind.FOLD, Kind.CORNER_IMPACT, Kind.GRAZING])
@pytest.mark.parametrize("fading", [None, 0])
def test_only_a_graze_that_does_not_fade_is_looked_for_along_its_flight(monkeypatch, kind, fading):
    """The event that is proved has the touch of this very point."""
    asked = []
    root = Made(parameter="rpm", machine=(), theta=(0.5, 1.5), value=700.0)
    located = Located(kind, None, 0.0, 0.0, Bracket.OK, 1, 0, 7.0, fading)
    curve = Made(kind=kind, corner="b", located=located)
    monkeypatch.setattr(proofs, "_name", lambda *_: "rpm")
    monkeypatch.setattr(proofs, "with_machine", lambda *_: (None,))
    monkeypatch.setattr(proofs, "Shooter", lambda *_: None)
    monkeypatch.setattr(proofs, "touch_near", lambda *_: (None, 0.25))
    monkeypatch.setattr(proofs, "prove_event", lambda _, event, __: asked.append(event))
    prove_on_curve(None, curve, Made(orbit=Made(root=root), value=None))
    (event,) = asked
    touches = kind is Kind.GRAZING and fading is None
    assert event.located.phase == (1.75 if touches else 7.0)
    assert event.located.root is root


def between(curve, machines_at, condition, k):
    """Own shooting half way between point k of a curve and the next one: (first, second)."""
    here, there = curve.points[k], curve.points[k + 1]
    given, free = mpf((here.first + there.first) / 2), (here.second + there.second) / 2
    root = here.orbit.root
    guess = [(root.theta[0], root.x[1] * here.orbit.rpm * pi / 30)]
    return given, event(machines_at(given), condition, guess, 1, free)[0]


@pytest.mark.ci
def test_a_curve_is_proved_without_a_gap_and_own_shooting_is_on_it_between_its_points():
    """The fold of a stop that presses, in amplitude and frequency: all of it, as a chain."""
    keys = ("cam.amplitude", 0.2, 0.7), ("cam.frequency", 3.8, 4.4)
    result = proved(OSCILLATOR, "fold", *keys)
    (curve,) = result.values.curves
    (part,) = result.values.proofs.curve_ranges
    last = len(curve.points)
    assert (part.curve, part.first, part.last, part.failed_step) == (1, 1, last, None)
    ends = [(point.first, point.second) for point in (curve.points[0], curve.points[-1])]
    assert list(part.places) == ends
    assert part.boxes >= last - 1
    words = [text for text in result.summary["words"] if "no gap" in text]
    assert words == [
        f"proved: curve 1 has no gap from amplitude {ends[0][0]:.10g}, frequency "
        f"{ends[0][1]:.10g} to amplitude {ends[1][0]:.10g}, frequency {ends[1][1]:.10g}, where its "
        f"bifurcation happens at every value between ({part.boxes} boxes)"
    ]
    record = result.summary["proofs"]["curve_ranges"]
    assert [(one["first"], one["last"], one["failed_step"]) for one in record] == [(1, last, None)]

    def machines_at(given):
        return Machines(
            lambda p: dict(SPRUNG), lambda p: p * 30 / mp.pi, lambda p: pressed(given, p)
        )

    mp.dps = 40
    plane = result.values.question.plane
    for k in (0, last // 2):
        first, second = between(curve, machines_at, fold, k)
        here = curve.points[k]
        x = [*here.orbit.root.x[:-1], float(second)]
        middle = replace(here, first=float(first), second=float(second))
        middle = replace(middle, orbit=replace(here.orbit, root=replace(here.orbit.root, x=x)))
        more = replace(curve, points=(here, middle, curve.points[k + 1]))
        (whole,) = prove_curve(result.system, more, 1, plane)  # it lies on the chain
        assert whole.failed_step is None


@pytest.mark.ci
def test_points_of_two_curves_are_not_joined():
    """From a fold to a doubling of the same orbit there is no curve of folds."""
    keys = ("cam.amplitude", 0.15, 2.0), ("cam.frequency", 3.8, 4.4)
    folds, doublings = (
        proved(OSCILLATOR, kind, *keys, prove=False) for kind in ("fold", "period-doubling")
    )
    curve, other = folds.values.curves[0], doublings.values.curves[0]
    plane = folds.values.question.plane
    mixed = replace(curve, points=(curve.points[0], curve.points[1], other.points[1]))
    ranges = prove_curve(folds.system, mixed, 1, plane)
    assert [(one.last, one.failed_step is None) for one in ranges] == [(2, True), (3, False)]
    passing = curve.points[1].orbit.root.landing_on(0, 0, 1)
    moved = replace(curve.points[1], orbit=replace(curve.points[1].orbit, root=passing))
    beside = replace(curve, points=(curve.points[0], moved))
    (part,) = prove_curve(folds.system, beside, 1, plane)
    assert part.failed_step == ProofStep.PASSES


@pytest.mark.parametrize(
    ("end", "given"), [((712.0, 0.72), 0), ((688.0, 0.68), 0), ((706.0, 0.9), 1), ((706.0, 0.5), 1)]
)
def test_the_number_that_changes_more_of_its_range_is_given_in_the_boxes(monkeypatch, end, given):
    """From (700, 0.7) in a plane of 40 rpm by 0.5: whichever way both of them change."""
    asked = []

    class OnCurve:
        place = 4
        meeting = Made(admit=lambda hull: None)

        def unknowns(self, system, curve, plane, root, values):
            return values

        def values(self, z):
            return z

        def box(self, z, at):
            asked.append(at)
            return Made(hull=lambda: z)

        def chain(self, start, end, at, count):
            asked.append(at)
            return [], []

    monkeypatch.setattr(curve_proofs, "OnCurve", lambda *_: OnCurve())

    def point(values):
        root = Made(whole=(1, 0))
        return Made(orbit=Made(root=root), first=values[0], second=values[1])

    plane = Plane(("rpm", "restitution"), ((680.0, 720.0), (0.45, 0.95)), 20)
    curve_proofs._part(None, Made(located=True), plane, (point((700.0, 0.7)), point(end)), None, 1)
    assert asked == [4 + given] * 3
