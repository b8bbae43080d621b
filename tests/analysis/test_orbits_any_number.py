"""Branches in numbers of the cam: events against own shooting in 40 digits, ends, and refusals."""

from functools import cache
from itertools import pairwise
from math import degrees, pi, sqrt
from types import SimpleNamespace

import pytest
from mpmath import mp, mpf

from camcli import SceneError, load_scene, orbits
from camcli.analysis.orbits import study
from camcli.analysis.orbits.family_shooting import FamilyShooting
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.proofs import prove_event
from camcli.analysis.orbits.shooter import Shooter
from camcli.api.family import in_family
from camcli.api.machine import machine_of
from camcli.errors import NoMachineError
from camcli.scene import Axis
from tests.support.followed import (
    Machines,
    Scca,
    Wave,
    arcs,
    at_corner,
    doubling,
    event,
    fading,
    fold,
)
from tests.support.oracle import Arc

pytestmark = pytest.mark.slow

CHAPTER = {"mass": 1.221, "stiffness": 1430.8}
BALL = {
    "follower": {"mass": 1, "stiffness": 0, "gravity": 9.81, "restitution": 0.6},
    "cam": {"kind": "eccentric", "base": 0, "lift": 0.005},
    "run": {"rpm": 600},
}
OSCILLATOR = {
    "follower": {"restitution": 0.8},
    "cam": {"kind": "oscillator", "damping": 0.1, "amplitude": 1, "frequency": 1, "clearance": 1},
}

LAW = {
    "follower": {**CHAPTER, "restitution": 0.8},
    "cam": {
        "kind": "law",
        "base": 0.1,
        "lift": 0.15,
        "rise": {
            "start_deg": 90,
            "length_deg": 70,
            "law": {"scca": {"b": 0.2, "c": 0.3, "d": 0.5}},
        },
        "top_dwell_deg": 40,
        "fall": {"length_deg": 70, "law": "4-5-6-7"},
    },
}
SCENES = {"ball": BALL, "oscillator": OSCILLATOR, "law": LAW}


@cache
def _studied(scene, key, low, high, at, label, branches, rpm):
    axis = {"key": key, "start": low, "stop": high, "num": 8 if key == "cam.flank_center" else 3}
    overrides = {
        "orbits.vary": [axis],
        "orbits.label": label,
        "orbits.branches": branches,
        "orbits.stability": "stable",
    }
    overrides |= {} if rpm is None else {"run.rpm": rpm}
    overrides |= {} if at is None else {key: at}
    if at is not None and key == "cam.flank_center":  # the circles of the scene are closed
        overrides["cam.flank_radius"] = 0.4 + at
    return orbits(load_scene(SCENES.get(scene), overrides))


def solved(key, low, high, scene=None, at=None, label="P(1;1)", branches=0, rpm=None):
    """`cam orbits` for one label in a number of the cam from a value on, once for all."""
    return _studied(scene, key, low, high, at, label, branches, rpm)


def studied(*asked, **more):
    """Its branches and events."""
    return solved(*asked, **more).values


def located(study, kind, label="P(1;1)"):
    """The only event of a kind and a label."""
    (one,) = [b for b in study.bifurcations if (b.kind, b.label) == (kind, label)]
    return one


def arc(cam, piece: int, theta) -> Arc:
    """A piece of the oracle's cam, 1 for (a, b), in the turn of an unrolled angle."""
    one = cam.arcs[piece - 1]
    return one._replace(origin=one.origin + 2 * mp.pi * mp.floor(theta / (2 * mp.pi)))


def on_arcs(rpm, pieces, **changes) -> Machines:
    """The default follower on circles that move with the number; pieces: of each impact."""
    cam = arcs(**changes)

    def arcs_of(p) -> list[Arc]:
        """The piece of impact k in turn k."""
        return [arc(cam(p), piece, 2 * mp.pi * turn) for turn, piece in enumerate(pieces)]

    return Machines(lambda p: dict(CHAPTER), lambda p: rpm, arcs_of)


def ball(p) -> list:
    """The table of the bouncing ball, p its lift."""
    return [Wave(p / 2, -p / 2)]


def oscillating(p, amplitude=1, frequency=1, clearance=1) -> list:
    """The stop of the oscillator m x'' + b x' + k x = F cos wt, from its steady motion."""
    spring, damper = 1 - frequency**2, mpf(0.1) * frequency
    share = amplitude / (spring**2 + damper**2)
    return [Wave(-clearance, spring * share, damper * share)]


def on_a_law(rpm, zone, b, d) -> Machines:
    """The default follower on the rise of a law whose widths move with the number."""

    def pieces(p) -> list[Scca]:
        """The zone of the only impact."""
        widths = b(p), 1 - b(p) - d(p), d(p)
        return [Scca(mpf(0.1), mpf(0.15), mp.radians(90), mp.radians(70), widths, zone)]

    return Machines(lambda p: dict(CHAPTER), lambda p: rpm, pieces)


def breaks(number: int, **changes):
    """A corner of the circles, 0 for a."""
    cam = arcs(**changes)
    return lambda p: cam(p).breakpoints[number]


LOADED = {"mass": 1, "stiffness": 0, "gravity": 9.81, "restitution": 0.6}
SPRUNG = {"mass": 1, "stiffness": 1, "damping": 0.1}
TWO = "P(2;1:1)"
EVENTS = {
    "a doubling in the nose": (
        ("cam.nose_radius", 0.1528, 0.1532, 0.1531, None, 740.5), Kind.PERIOD_DOUBLING, "P(1;1)",
        on_arcs(740.5, [2], nose_radius=lambda p: p), doubling,
    ),
    "two impacts, one at a corner": (
        ("cam.nose_radius", 0.1528, 0.1532, 0.1531, None, 740.5), Kind.CORNER_IMPACT, TWO,
        on_arcs(740.5, [2, 2], nose_radius=lambda p: p),
        at_corner(1, lambda p: breaks(2, nose_radius=lambda p: p)(p) + 2 * mp.pi),
    ),
    "a fold in the flank": (
        ("cam.flank_center", 0.361, 0.377, 0.375, None, 675), Kind.FOLD, "P(1;1)",
        on_arcs(675, [1], flank_center=lambda p: p), fold,
    ),
    "a corner that moves with the flank": (
        ("cam.flank_center", 0.361, 0.377, 0.375, None, 675), Kind.CORNER_IMPACT, "P(1;1)",
        on_arcs(675, [1], flank_center=lambda p: p),
        at_corner(0, breaks(1, flank_center=lambda p: p)),
    ),
    "a fold in the lift": (
        ("cam.lift", 0.0037, 0.0067, 0.005, "ball", None), Kind.FOLD, "P(1;1)",
        Machines(lambda p: dict(LOADED), lambda p: 600, ball), fold,
    ),
    "a doubling in the lift": (
        ("cam.lift", 0.0037, 0.0067, 0.005, "ball", None), Kind.PERIOD_DOUBLING, "P(1;1)",
        Machines(lambda p: dict(LOADED), lambda p: 600, ball), doubling,
    ),
    "a doubling in the sine's share of a law": (
        ("cam.rise.law.scca.b", 0.19, 0.21, None, "law", 803.65), Kind.PERIOD_DOUBLING, "P(1;1)",
        on_a_law(803.65, "sine", lambda p: p, lambda p: mpf("0.5")), doubling,
    ),
    "a doubling in the constant share, with which the sine's goes": (
        ("cam.rise.law.scca.c", 0.29, 0.31, None, "law", 803.65), Kind.PERIOD_DOUBLING, "P(1;1)",
        on_a_law(803.65, "sine", lambda p: mpf("0.5") - p, lambda p: mpf("0.5")), doubling,
    ),
    "a fold in the cosine's share of a law": (
        ("cam.rise.law.scca.d", 0.49, 0.56, None, "law", 670.5), Kind.FOLD, "P(1;1)",
        on_a_law(670.5, "cosine", lambda p: mpf("0.2"), lambda p: p), fold,
    ),
    "a fold in the amplitude": (
        ("cam.amplitude", 0.09, 0.13, 0.12, "oscillator", None), Kind.FOLD, "P(1;1)",
        Machines(lambda p: dict(SPRUNG), lambda p: 30 / mp.pi,
                 lambda p: oscillating(p, amplitude=p)), fold,
    ),
    "an impact that fades in the clearance": (
        ("cam.clearance", 9.5, 10.2, 9.9, "oscillator", None), Kind.GRAZING, "P(1;1)",
        Machines(lambda p: dict(SPRUNG), lambda p: 30 / mp.pi,
                 lambda p: oscillating(p, clearance=p)), fading(0),
    ),
    "a fold in the frequency, which is the speed too": (
        ("cam.frequency", 1.6, 1.8, 1.7, "oscillator", None), Kind.FOLD, "P(1;1)",
        Machines(lambda p: dict(SPRUNG), lambda p: p * 30 / mp.pi,
                 lambda p: oscillating(p, frequency=p)), fold,
    ),
}  # fmt: skip


HEAVY = (
    "a doubling in the nose",
    "two impacts, one at a corner",
    "a fold in the flank",
    "a corner that moves with the flank",
    "an impact that fades in the clearance",
    "a fold in the frequency, which is the speed too",
    "a doubling in the constant share, with which the sine's goes",
    "a fold in the cosine's share of a law",
)


MARKS = {name: [pytest.mark.soak] for name in HEAVY}
MARKS["a doubling in the sine's share of a law"] = [pytest.mark.ci]


@pytest.mark.parametrize("name", [pytest.param(name, marks=MARKS.get(name, [])) for name in EVENTS])
def test_events_in_numbers_of_the_cam_are_those_of_own_shooting(name):
    (key, low, high, at, scene, rpm), kind, label, machines, condition = EVENTS[name]
    branches = int(key == "cam.nose_radius")
    result = solved(key, low, high, scene, at, branches=branches, rpm=rpm)
    found = located(result.values, kind, label)
    root = found.orbit.root
    omega = root.machine[0] * pi / 30
    turn = [2 * mp.pi * n for n in root.whole[1::2]]
    guess = [
        (theta + n, v * omega) for theta, n, v in zip(root.theta, turn, root.x[1:-1:2], strict=True)
    ]
    exact, thetas = event(machines, condition, guess, root.turns, found.value)
    assert abs(found.value - exact) <= max(found.error, mpf(2) ** -50 * abs(exact))
    assert found.error < 1e-12 * abs(exact)
    for theta, (near, _) in zip(thetas, guess, strict=True):
        assert abs(theta - near) < 1e-5
    proof = prove_event(result.system, found, key)
    assert proof.proved
    middle, _, radius = proof.value.strip("[]").partition(" +/- ")
    assert abs(exact - mpf(middle)) <= 2 * mpf(radius) < mpf("1e-25")


def test_the_bouncing_ball_s_fold_and_doubling_in_closed_form():
    """A w^2 at the fold is d = pi g (1 - r)/(1 + r), at the doubling its square is

    d^2 + (2 g (1 + r^2)/(1 + r)^2)^2: A. C. J. Luo and R. P. S. Han, Nonlinear Dyn. 10 (1996) 1.
    """
    study = studied("cam.lift", 0.0037, 0.0067, "ball", 0.005)
    r, g, w2 = mpf(0.6), mpf(9.81), (20 * mp.pi) ** 2
    rise = mp.pi * (1 - r) / (1 + r)
    at_fold = 2 * rise * g / w2
    at_doubling = 2 * g / w2 * mp.sqrt(rise**2 + (2 * (1 + r**2) / (1 + r) ** 2) ** 2)
    assert abs(located(study, Kind.FOLD).value / at_fold - 1) < 1e-12
    assert abs(located(study, Kind.PERIOD_DOUBLING).value / at_doubling - 1) < 1e-12


def test_a_point_of_a_branch_is_the_orbit_of_a_scene_with_its_value():
    """The orbit solved anew, on a cam of arcs, of a law, and of an oscillator with its speed."""
    law = {
        "follower": {"mass": 1, "stiffness": 400, "preload": 2, "restitution": 0.6},
        "cam": {"kind": "law", "base": 0.01, "lift": 0.012,
                "rise": {"start_deg": 60, "length_deg": 70, "law": "cycloidal"},
                "fall": {"length_deg": 80, "law": "modified-sine"}},
        "run": {"rpm": 500},
    }  # fmt: skip
    few = {"orbits.label": "P(1;1)", "orbits.branches": 0}
    for scene, rpm, key, low, high in (
        (None, 700.0, "cam.top_dwell_deg", 38.0, 42.0),
        (law, 500.0, "cam.rise.length_deg", 68.0, 71.0),
        (OSCILLATOR, None, "cam.frequency", 0.98, 1.01),
    ):
        axis = {"key": key, "start": low, "stop": high, "num": 2}
        study = orbits(load_scene(scene, {"orbits.vary": [axis], **few}
                                  | ({} if rpm is None else {"run.rpm": rpm}))).values  # fmt: skip
        for branch in study.branches:
            for point in (branch.points[0], branch.points[-1]):
                assert point.value in (low, high)
                alone = {key: point.value, **few}
                alone |= {} if rpm is None else {"orbits.rpm.start": rpm, "orbits.rpm.stop": rpm}
                again = orbits(load_scene(scene, alone)).values
                near = [one for one in again.orbits if abs(one.trace - point.trace) < 1e-9]
                (one,) = near
                assert one.rpm == pytest.approx(point.rpm, rel=1e-14)
                assert one.theta == pytest.approx(point.theta, abs=1e-12)
                assert one.states[0] == pytest.approx(point.states[0], rel=1e-11)
                assert one.regions == point.regions


def test_a_branch_ends_with_its_reason_where_the_machine_does():
    """At resonance the oscillator swings 1/damping high, and no cam may be higher than 1e6 m."""
    study = studied("cam.damping", 0.0, 0.11, "oscillator")
    (limit,) = study.limits
    assert limit.value == pytest.approx(1e-6, rel=1e-6)
    assert "at most 1e6 m" in limit.reason
    (branch,) = study.branches
    ends = dict(zip(branch.ends, (branch.points[0], branch.points[-1]), strict=True))
    assert ends[Kind.NO_MACHINE].value == limit.value
    assert ends[Kind.END_OF_RANGE].value == 0.11


def test_a_branch_ends_where_a_part_of_the_cam_vanishes():
    study = studied("cam.top_dwell_deg", 0.0, 41.0, rpm=700.0)
    (limit,) = study.limits
    assert 0.0 < limit.value < degrees(2e-12)
    assert "one appears or vanishes" in limit.reason
    assert {branch.ends[0] for branch in study.branches} == {Kind.NO_MACHINE}


def test_contact_is_lost_at_the_lift_whose_acceleration_is_that_of_the_load():
    """A branch at rest: the force is zero at the top where lift/2 w^2 = g + k/m (base + lift)."""
    scene = {
        "follower": {"mass": 1, "stiffness": 1, "gravity": 9.81, "restitution": 0.5},
        "cam": {"kind": "eccentric", "base": 0.1, "lift": 0.019},
        "run": {"rpm": 300, "transient": 20},
    }
    axis = {"key": "cam.lift", "start": 0.0185, "stop": 0.021, "num": 3}
    found = orbits(load_scene(scene, {"orbits.vary": [axis], "orbits.starts": 0})).values
    (event,) = found.bifurcations
    assert event.kind == Kind.DETACHMENT
    exact = (9.81 + 0.1) / (0.5 * (10.0 * pi) ** 2 - 1.0)
    assert abs(event.value - exact) <= event.error + 4e-16 * exact
    assert event.error < 1e-10


def test_circles_stay_closed_where_one_of_them_moves():
    """With base_radius and flank_center the flank's radius goes along; b moves with them."""
    for key, low, high, base, center in (
        ("cam.base_radius", 0.39, 0.41, lambda p: p, lambda p: 0.45),
        ("cam.flank_radius", 0.84, 0.86, lambda p: 0.4, lambda p: p - 0.4),
    ):
        study = studied(key, low, high, rpm=700.0)
        assert not study.limits
        point = next(b for b in study.branches if b.points[0].stable).points[-1]
        cam = arcs(base_radius=base, flank_center=center)(mpf(point.value))
        c, c1, _ = cam.laws(point.theta[0])
        w = mp.sqrt(mpf(1430.8) / mpf(1.221)) * 30 / (700 * mp.pi)
        r = mpf(0.8)
        assert abs(c - (1 + r) / (1 - r) * mp.cot(mp.pi * w) * c1 / w) < 1e-12


def curve_of(kind, first, second, scene=None, **more):
    """The only curve of a kind of P(1;1) in two numbers, each (key, low, high)."""
    axes = [dict(zip(("key", "start", "stop"), one, strict=True), num=9) for one in (first, second)]
    overrides = {"orbits.vary": axes, "orbits.curve": kind, "orbits.label": "P(1;1)"}
    overrides |= {"orbits.branches": 0, "orbits.stability": "stable", **more}
    (found,) = orbits(load_scene(scene, overrides)).values.curves
    return found


def test_a_curve_of_corner_impacts_in_speed_and_nose_is_that_of_own_shooting():
    first, second = ("rpm", 672.0, 682.0), ("cam.nose_radius", 0.13, 0.17)
    found = curve_of("corner-impact", first, second, **{"run.rpm": 680.0})
    assert found.limits == ("cam.nose_radius", "cam.nose_radius")
    assert (found.points[0].second, found.points[-1].second) == (0.13, 0.17)
    for point in (found.points[0], found.points[-1]):
        nose = mpf(point.second)
        cam = arcs(nose_radius=lambda p, nose=nose: nose)(0)
        machines = Machines(lambda p: dict(CHAPTER), lambda p: p, lambda p, c=cam: [arc(c, 2, 0)])
        root = point.orbit.root
        guess = [(root.theta[0], root.x[1] * point.orbit.rpm * pi / 30)]
        condition = at_corner(0, lambda p, cam=cam: cam.breakpoints[1])
        rpm, _ = event(machines, condition, guess, 1, point.first)
        assert abs(rpm - point.first) < 1e-12 * rpm


def test_a_member_of_a_family_is_the_machine_of_its_scene():
    """Cam, follower and speed, to the last bit, of every kind of cam."""
    widths = {"b": 0.2, "c": 0.3, "d": 0.5}
    law = {"follower": {"mass": 1, "stiffness": 400, "restitution": 0.8},
           "cam": {"kind": "law", "base": 0.01, "lift": 0.012,
                   "rise": {"start_deg": 60, "length_deg": 70, "law": "cycloidal"},
                   "fall": {"length_deg": 80, "law": {"scca": widths}}}}  # fmt: skip
    for scene, key, value, other in (
        (None, "cam.base_radius", 0.4, 0.41),
        (law, "cam.fall.law.scca.b", 0.2, 0.17),
        (law, "cam.fall.law.scca.c", 0.3, 0.33),
        (law, "cam.rise.length_deg", 70.0, 68.3),
        (law, "cam.lift", 0.012, 0.013),
        (BALL, "cam.lift", 0.005, 0.0061),
        (OSCILLATOR, "cam.frequency", 1.0, 1.07),
        (OSCILLATOR, "cam.mass", 1.0, 0.97),
    ):
        axis = Axis(key=key, start=value, stop=other, num=2)
        family = in_family(machine_of(load_scene(scene)), [axis]).member.family
        member = family.at([other]).system
        changes = {key: other}
        if key == "cam.base_radius":
            changes["cam.flank_radius"] = other + 0.45
        if ".scca." in key:  # the constant share goes with the others, the sine's with that
            along = {"b": "c", "c": "b"}[key[-1]]
            changes[f"cam.fall.law.scca.{along}"] = {0.17: 0.33, 0.33: 0.17}[other]
        alone = machine_of(load_scene(scene, changes))
        assert member.cam == alone.system.cam
        assert member.follower == alone.system.follower
        assert family.at([other]).machine[0] == alone.scene.run.rpm


@pytest.mark.ci
@pytest.mark.parametrize(("kind", "condition"), [("fold", fold), ("period-doubling", doubling)])
def test_curves_of_a_stop_that_presses_over_a_factor_of_two_in_both_numbers(kind, condition):
    """Fold and doubling of P(1;1) from end to end; each point as own shooting has it."""
    cam = {**OSCILLATOR["cam"], "amplitude": 0.6, "frequency": 4, "clearance": -0.5}
    first, second = ("cam.amplitude", 0.15, 5.0), ("cam.frequency", 2.4, 6.0)
    found = curve_of(kind, first, second, {**OSCILLATOR, "cam": cam})
    assert found.ends == (Kind.END_OF_RANGE, Kind.END_OF_RANGE)
    for values in ([p.first for p in found.points], [p.second for p in found.points]):
        assert max(values) > 2 * min(values)
        rising = [b > a for a, b in pairwise(values)]
        assert all(rising) or not any(rising)
    for point in found.points:
        frequency = mpf(point.second)
        machines = Machines(
            lambda p: dict(SPRUNG), lambda p, w=frequency: w * 30 / mp.pi,
            lambda p, w=frequency: oscillating(p, p, w, mpf(-0.5)),
        )  # fmt: skip
        root = point.orbit.root
        guess = [(root.theta[0], root.x[1] * point.second)]
        amplitude, _ = event(machines, condition, guess, root.turns, point.first)
        assert abs(amplitude - point.first) < 1e-11 * amplitude


@pytest.mark.soak
def test_the_doubling_of_an_oscillator_over_a_factor_of_two():
    """In the frequency, which is the speed as well, while the clearance goes through zero."""
    scene = {**OSCILLATOR, "cam": {**OSCILLATOR["cam"], "frequency": 2.3, "clearance": 0.1}}
    first, second = ("cam.frequency", 1.9, 4.5), ("cam.clearance", -1.0, 0.3)
    found = curve_of("period-doubling", first, second, scene)
    assert found.points[0].first == 4.5
    assert found.points[-1].second == 0.3
    assert found.points[-1].first < 2.1
    for point in found.points:
        gap = mpf(point.second)
        machines = Machines(
            lambda p: dict(SPRUNG), lambda p: p * 30 / mp.pi,
            lambda p, gap=gap: oscillating(p, frequency=p, clearance=gap),
        )  # fmt: skip
        root = point.orbit.root
        guess = [(root.theta[0], root.x[1] * point.first)]
        frequency, _ = event(machines, doubling, guess, root.turns, point.first)
        assert abs(frequency - point.first) < 1e-12 * frequency


@pytest.mark.parametrize(
    ("key", "low", "high", "said"),
    [
        ("cam.kind", 0, 1, "it is a text, 'arcs'"),
        ("run.transient", 1, 1000, "no orbit depends on it"),
        ("run.start.q", 0, 1, "no orbit depends on it"),
        ("cam.nose_radius", -1, 1, "a number greater than 0"),
        ("cam.nose_radius", 0.2, 0.3, "a range that holds cam.nose_radius = 0.15"),
        ("cam.nosy", 0, 1, "unknown key 'nosy'"),
        ("follower.seat", 0, 1, "expected a constant of the follower"),
        ("follower.seat_restitution", 0, 1, "without cam.lash the follower has no seat"),
    ],
)
def test_what_cannot_be_followed_says_why(key, low, high, said):
    axis = {"key": key, "start": low, "stop": high, "num": 3}
    with pytest.raises(SceneError) as error:
        orbits(load_scene(None, {"orbits.vary": [axis]}))
    assert len(error.value.faults) == 1
    assert said in str(error.value)


SEAT = "seat_restitution"
NOWHERE = "the scene leaves it out, so that a branch has nowhere to begin"
SEATLESS = "without cam.lash the follower has no seat, no orbit depends on it"


@pytest.mark.parametrize(
    ("scene", "section", "path", "said"),
    [
        (None, {"parameter": SEAT}, "orbits.parameter", SEATLESS),
        (None, {"curve": "fold", "curve_in": SEAT}, "orbits.curve_in", SEATLESS),
        ("lash", {"parameter": SEAT}, "orbits.parameter", NOWHERE),
        ("lash", {"vary": [{"key": f"follower.{SEAT}", "start": 0, "stop": 1}]}, "orbits.vary",
         NOWHERE),
    ],
)  # fmt: skip
def test_a_restitution_on_a_seat_that_is_not_there_is_refused(scene, section, path, said):
    changes = {} if scene is None else {"cam.lash": 0.01}
    asked = {f"orbits.{key}": value for key, value in section.items()}
    with pytest.raises(SceneError) as error:
        orbits(load_scene(LAW if scene else None, changes | asked))
    (fault,) = error.value.faults
    assert (fault.path, fault.expected) == (path, f"expected a number to follow: {said}")
    cure = "give it a value in the scene, or with --set" if scene else "follow a number of"
    assert fault.cure.startswith(cure)


@pytest.mark.ci
def test_a_curve_through_two_events_is_followed_once():
    """Both impacts that fade along a branch of P(2;2:0) lie on one curve, which turns round."""
    cam = {"kind": "oscillator", "damping": 0.1, "amplitude": 0.5, "frequency": 0.8}
    scene = {"follower": {"restitution": 0.7}, "cam": {**cam, "clearance": 1}}
    window = [
        {"key": "cam.frequency", "start": 0.68, "stop": 0.85, "num": 5},
        {"key": "cam.amplitude", "start": 0.4, "stop": 0.6, "num": 5},
    ]
    asked = {"orbits.vary": window, "orbits.curve": "grazing", "orbits.label": "P(2;2:0)"}
    result = orbits(load_scene(scene, {**asked, "orbits.branches": 0})).values
    faded = [b.value for b in result.bifurcations if b.kind == Kind.GRAZING]
    assert len(faded) == 2
    (curve,) = result.curves
    line = [(p.first, p.second) for p in curve.points]
    crossed = [
        (a, b) for (a, x), (b, y) in pairwise(line) if (x - 0.5) * (y - 0.5) <= 0.0 and x != y
    ]
    for value in faded:
        assert any(min(ends) <= value <= max(ends) for ends in crossed)


@pytest.mark.ci
def test_a_curve_ends_where_its_orbit_becomes_one_of_fewer_turns():
    """The curve of P(2;2:0) ends where P(1;1) doubles as its impact fades; it goes no further.

    There the stop is touched without any rate, by the forced motion of an amplitude
    A / |k - m w^2 + i c w| that is the clearance, and the free motion has turned by an odd number
    of half turns, three, in two turns of the force: w = 2 w_d / 3, w_d^2 = k / m - (c / 2m)^2.
    """
    cam = {"kind": "oscillator", "damping": 0.1, "amplitude": 0.5, "frequency": 0.8}
    scene = {"follower": {"restitution": 0.7}, "cam": {**cam, "clearance": 1}}
    window = [
        {"key": "cam.frequency", "start": 0.6, "stop": 0.85, "num": 5},
        {"key": "cam.amplitude", "start": 0.4, "stop": 0.6, "num": 5},
    ]
    asked = {"orbits.vary": window, "orbits.curve": "grazing", "orbits.label": "P(2;2:0)"}
    result = orbits(load_scene(scene, {**asked, "orbits.branches": 0})).values
    (curve,) = result.curves
    assert Kind.SHORTER_ORBIT in curve.ends
    frequency = 2.0 / 3.0 * sqrt(1.0 - 0.05**2)
    amplitude = abs(complex(1.0 - frequency**2, 0.1 * frequency))
    assert min(p.first for p in curve.points) > frequency
    (point,) = [p for p in result.codim2 if p.ends]
    assert (point.kind, point.label) == ("period-doubling-grazing", "P(1;1)")
    assert point.first == pytest.approx(frequency, rel=1e-12)
    assert point.second == pytest.approx(amplitude, rel=1e-12)


@pytest.mark.parametrize(
    ("value", "beside"), [(0.5, 0.50001), (0.99999999, 0.99998999), (1.0, 0.99999)]
)
def test_the_machine_beside_another_lies_below_it_where_there_is_none_above(value, beside):
    def at(number):
        if number > 1.0:
            raise NoMachineError("there is none")
        return number

    family = SimpleNamespace(range=1.0, at=at)
    assert FamilyShooting._beside(family, value) == pytest.approx(beside, abs=1e-12)
    family.range = 1e9
    family.at = lambda number: at(2.0)
    assert FamilyShooting._beside(family, value) is None


def test_a_branch_leaves_from_the_event_that_it_is_noted_at(monkeypatch):
    """Doublings, and corners at which a branch turns, behind events from which none leaves."""
    monkeypatch.setattr(study, "from_root", lambda system, root: "orbit")
    diagram = study.Diagram(SimpleNamespace(system="system"), "settings")
    monkeypatch.setattr(diagram, "_corner_impact", lambda crossing: "study")
    events = []
    for number, (kind, crossing, turned) in enumerate([
        (Kind.FOLD, None, False), (Kind.PERIOD_DOUBLING, None, False),
        (Kind.CORNER_IMPACT, "crossed", False), (Kind.CORNER_IMPACT, "turned", True),
        (Kind.PERIOD_DOUBLING, None, False),
    ]):  # fmt: skip
        located = SimpleNamespace(kind=kind, root=SimpleNamespace(value=700.0 + number), error=1e-9,
                                  status="ok")  # fmt: skip
        corner = crossing and SimpleNamespace(corner=crossing)
        diagram._add_bifurcation(3, located, corner, turned)
        events.append(corner or located)
    assert diagram.branch_points == [(1, events[1]), (3, events[3]), (4, events[4])]
    assert [one.value for one in diagram.bifurcations] == [700.0, 701.0, 702.0, 703.0, 704.0]
    assert [one.corner for one in diagram.bifurcations] == ["", "", "crossed", "turned", ""]


def test_what_is_little_of_a_number_of_the_cam_is_little_of_its_range():
    """Wherever the range lies, so that a number may be zero or below."""
    scales = []
    for low, high in ((0.1, 0.2), (-0.2, -0.1), (-0.3, 0.0)):
        cam = {"kind": "eccentric", "base": (low + high) / 2.0, "lift": 0.02}
        scene = load_scene({"follower": {"mass": 1.0, "stiffness": 9.0, "restitution": 0.5},
                            "cam": cam, "run": {"rpm": 600.0}})  # fmt: skip
        system = in_family(machine_of(scene), [Axis(key="cam.base", start=low, stop=high, num=3)])
        scales.append(Shooter(system, 600.0, "cam.base").scale)
    assert scales == pytest.approx([scales[0], scales[0], 3.0 * scales[0]])
    assert 0.0 < scales[0] < 0.1
