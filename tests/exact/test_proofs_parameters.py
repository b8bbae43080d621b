"""Proofs along every constant of the follower, and that what is proved is true.

The judge is `tests.support.orbit_oracle` at 60 digits, on the cam whose flank circle
has exactly the radius that the program gives it: base_radius + flank_center.
"""

from functools import cache
from itertools import pairwise
from random import Random
from types import SimpleNamespace

import pytest
from conftest import chapter_system
from mpmath import iv, mp, mpf

import camcli
from camcli.analysis.orbits import proofs as proofs_module
from camcli.exact.shooting import ProofStep
from camcli.scene import load_scene
from tests.conftest import some_in_ci
from tests.support.oracle import ArcsCam
from tests.support.orbit_oracle import DIGITS, Machine, admissible, solve

pytestmark = pytest.mark.slow

mp.dps = iv.dps = DIGITS
NEAR = mpf("1e-22")
CAM = ArcsCam(flank_radius=mpf(0.4) + mpf(0.45))
MACHINE = Machine(mass=1.221, stiffness=1430.8, restitution=0.8)
# The range, and the kinds of events in it.
RANGES = {
    "mass": (1.12, 1.365, {"corner-impact", "period-doubling"}),
    "stiffness": (1280.0, 1550.0, {"corner-impact", "period-doubling"}),
    "damping": (0.0, 12.0, {"corner-impact"}),
    "gravity": (-215.0, 380.0, {"corner-impact", "period-doubling", "grazing"}),
    "preload": (-260.0, 460.0, {"corner-impact", "period-doubling", "grazing"}),
    "restitution": (0.57, 0.9, {"corner-impact"}),
}


@cache
def proved(key):
    """`cam orbits --prove` along a constant of the follower, at 700 rpm."""
    low, high, _ = RANGES[key]
    return study({"parameter": key, "range": [low, high], "branches": 1})


def study(section):
    values = {f"orbits.{name}": value for name, value in {"starts": 0, **section}.items()}
    return camcli.orbits(load_scene(None, values), prove=True)


def interval(text):
    """The interval of '[middle +/- radius]'; a number alone is itself."""
    middle, _, radius = text.strip("[]").partition(" +/- ")
    return iv.mpf([mpf(middle) - mpf(radius or 0), mpf(middle) + mpf(radius or 0)])


def oracles(key, value, orbit, regions=None):
    """The machine, and the orbit near one that was found, at a value of the key and 700 rpm."""
    root, omega = orbit.root, mpf(700) * mp.pi / 30
    impacts = [
        (mpf(theta) + 2 * mp.pi * root.whole[2 * k + 1], mpf(root.x[2 * k + 1]) * omega)
        for k, theta in enumerate(root.theta)
    ]
    machine = MACHINE if key == "rpm" else MACHINE._replace(**{key: mpf(value)})
    return machine, solve(CAM, machine, 700.0, impacts, root.turns, regions or regions_of(orbit))


def regions_of(orbit):
    """The smooth region of each impact of the solved equations, in their order."""
    names = system().region_names
    return [names[orbit.root.whole[2 * k]] for k in range(orbit.root.count)]


@cache
def system():
    return chapter_system()


def is_held(proof, orbit):
    """True where the boxes of a proof hold the phases and rates of the oracle's orbit."""
    omega = mpf(700) * mp.pi / 30
    numbers = []
    for theta, u in orbit.impacts:
        numbers += [theta % (2 * mp.pi), u / omega]
    return all(x in interval(text) for x, text in zip(numbers, proof.box, strict=True))


@pytest.mark.ci
@pytest.mark.parametrize(
    "key",
    [
        key if key in ("stiffness", "restitution") else pytest.param(key, marks=pytest.mark.soak)
        for key in RANGES
    ],
)
def test_every_twentieth_point_that_is_proved_is_the_oracles(key):
    result = proved(key)
    for branch, proofs in zip(result.values.branches, result.values.proofs.points, strict=True):
        sure = [(o, p) for o, p in zip(branch.points, proofs, strict=True) if p.proved]
        assert len(sure) >= len(branch.points) - 2  # those at a corner, on its edge
        for orbit, proof in sure[::20]:
            machine, truth = oracles(key, orbit.value, orbit)
            assert is_held(proof, truth)
            assert admissible(CAM, machine, 700.0, truth)
            assert (abs(truth.trace) < 1 + truth.det) == orbit.stable


@pytest.mark.ci
@pytest.mark.parametrize(
    "key",
    [
        key if key in ("stiffness", "restitution") else pytest.param(key, marks=pytest.mark.soak)
        for key in RANGES
    ],
)
def test_at_every_enclosed_event_the_oracle_sees_the_crossing(key):
    """Just beside both ends of an enclosure of 24 digits and more the test functions differ."""
    result, kinds = proved(key), set()
    rows = zip(result.values.bifurcations, result.values.proofs.events, strict=True)
    for event, proof in rows:
        if not proof.proved or event.located.fading is not None:
            continue
        kinds.add(event.kind)
        value = interval(proof.value)
        assert value.delta < 1e-24 * (1 + abs(event.value))
        low, high = (mpf(end.mid) for end in (value.a, value.b))
        assert proof.low <= low <= high <= proof.high
        signs = [crossing(key, end, event) for end in (low - NEAR, high + NEAR)]
        assert signs[0] != signs[1], (event.kind, event.label)
    assert kinds == RANGES[key][2]


def crossing(key, value, event):
    """On which side of an event the oracle's orbit at a value of the key is."""
    machine, orbit = oracles(key, value, event.orbit)
    if event.kind == "corner-impact":
        theta = orbit.thetas[event.located.impact] % (2 * mp.pi)
        return theta > min(CAM.breakpoints, key=lambda corner: abs(corner - theta))
    if event.kind == "grazing":
        return admissible(CAM, machine, 700.0, orbit)
    sign = 1 if event.kind == "period-doubling" else -1
    return 1 + sign * orbit.trace + orbit.det > 0


@pytest.mark.parametrize("key", some_in_ci(RANGES, quick=["restitution"]))
def test_the_ranges_that_are_proved_are_true_at_random_values(key):
    result, rng, seen = proved(key), Random(key), 0
    for one in result.values.proofs.ranges:
        if one.failed_step is not None:
            continue
        seen += 1
        points = result.values.branches[one.branch - 1].points
        low, high = (float(interval(end).mid) for end in (one.low, one.high))
        edge = 1e-6 * (high - low)  # a point at a corner may be that of its other side
        inside = [point for point in points if low + edge < point.value < high - edge]
        for _ in range(3):
            value = rng.uniform(low, high)
            near = min(inside, key=lambda point: abs(point.value - value))
            machine, truth = oracles(key, value, near)
            assert admissible(CAM, machine, 700.0, truth)
            assert (abs(truth.trace) < 1 + truth.det) == one.stable
    assert seen >= 2


@pytest.mark.parametrize("key", some_in_ci(RANGES, quick=["restitution"]))
def test_orbits_found_at_a_speed_are_proved_for_that_speed(key):
    """Whatever is varied then: a bouncing one at 700 rpm, one that rests at 190 rpm."""
    result = proved(key)
    for orbit, proof in zip(result.values.orbits, result.values.proofs.orbits, strict=True):
        assert proof.proved
        assert is_held(proof, oracles("rpm", 700.0, orbit)[1])
    said = " ".join(result.summary["words"])
    assert "proved: P(1;1), stable, rpm = 700.0 and every value that rounds to it" in said
    own = getattr(MACHINE, key)
    near = {"parameter": key, "range": [own, own + 1e-3], "rpm.num": 3, "at": 190.0}
    alone = {"rpm.start": 190.0, "rpm.stop": 190.0, "rpm.num": 1}
    resting = study(near)
    assert resting.values.proofs.orbits == study(alone).values.proofs.orbits
    assert "proved: P(1;inf), rpm = 190.0" in " ".join(resting.summary["words"])


@pytest.mark.ci
def test_what_lies_between_two_ranges_without_an_event_is_told():
    """In the frequency of an oscillator the impact passes the angle zero, where nothing happens."""
    axis = {"key": "cam.frequency", "start": 0.86, "stop": 0.92, "num": 5}
    cam = {"kind": "oscillator", "damping": 0.1, "frequency": 0.9, "clearance": 1}
    overrides = {"orbits.vary": [axis], "orbits.branches": 0, "orbits.label": "P(1;1)"}
    scene = load_scene({"cam": cam, "follower": {"restitution": 0.8}}, overrides)
    result = camcli.orbits(scene, prove=True)
    (branch,) = result.values.branches
    assert not result.values.bifurcations
    before, told = result.values.proofs.ranges
    assert before.failed_step is None
    assert (float(before.low), before.high) == (branch.points[0].value, told.low)
    assert told.failed_step == ProofStep.PASSES
    low, high = float(told.low), float(told.high)
    pairs = list(pairwise(branch.points))
    (passed,) = [(a, b) for a, b in pairs if a.root.whole != b.root.whole]
    assert low < passed[0].value < high == passed[1].value
    assert abs(passed[0].theta[0] - 2 * mp.pi) < 1e-12 < passed[1].theta[0] < 0.1
    words = f"not proved: P(1;1) for all cam.frequency from {told.low} to {told.high} (branch 1): "
    why = "an impact passes an end of its part of the cam, the strobe or the angle zero there"
    assert words + why in result.summary["words"]


LAW = {
    "follower": {"mass": 1, "stiffness": 400, "preload": 2, "restitution": 0.6},
    "cam": {"kind": "law", "base": 0.01, "lift": 0.012,
            "rise": {"start_deg": 60, "length_deg": 70, "law": "cycloidal"},
            "fall": {"length_deg": 80, "law": "modified-sine"}},
}  # fmt: skip
LASHED = {
    "follower": {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8, "seat_restitution": 0.5},
    "cam": {"kind": "law", "base": 0.1, "lift": 0.15, "lash": 0.01, "top_dwell_deg": 40,
            "rise": {"start_deg": 90, "length_deg": 70, "law": "cycloidal"},
            "fall": {"length_deg": 70, "law": "cycloidal"}},
}  # fmt: skip
WIDE = {"cam.rise.law": {"scca": {"b": 0.2, "c": 0.3, "d": 0.5}}}


@pytest.mark.ci
@pytest.mark.parametrize(
    ("scene", "more", "key", "low", "high"),
    [
        # the impact lies on the nose, which the base circle neither moves nor bends
        (None, {"run.rpm": 700.0}, "cam.base_radius", 0.39, 0.41),
        # no top dwell: a rise that moves takes the fall along
        (LAW, {"run.rpm": 500.0}, "cam.rise.start_deg", 59.0, 61.0),
        (LAW, {"run.rpm": 500.0, **WIDE}, "cam.rise.law.scca.b", 0.19, 0.21),
        # corners of the seat move
        (LASHED, {"run.rpm": 700.0}, "cam.lash", 0.005, 0.015),
        (LASHED, {"run.rpm": 700.0}, "cam.lift", 0.145, 0.155),
        # the impact goes there and back
        (LAW, {"run.rpm": 500.0, **WIDE}, "cam.rise.law.scca.d", 0.485, 0.515),
    ],
)
def test_whole_branches_in_numbers_of_a_cam_are_proved(scene, more, key, low, high):
    axis = {"key": key, "start": low, "stop": high, "num": 3}
    overrides = {"orbits.vary": [axis], "orbits.branches": 0, "orbits.stability": "stable"}
    result = camcli.orbits(load_scene(scene, overrides | more), prove=True)
    assert result.values.branches
    for one in result.values.proofs.ranges:
        assert one.failed_step is None
        assert (float(one.low), float(one.high)) == (low, high)


@pytest.mark.parametrize(("key", "value"), [("restitution", 0.55), ("rpm", 640.0)])
@pytest.mark.parametrize("free", [False, True])
def test_a_motion_that_rests_is_proved_for_the_machine_of_its_value(monkeypatch, key, value, free):
    """An orbit that bounces brings its parameter along; one that rests is of a machine."""
    seen = []
    for name, proof in (("_resting", 1), ("_free", 2)):
        monkeypatch.setattr(
            proofs_module, name, lambda system, *_, proof=proof, **__: seen.append(system) or proof
        )
    rpm = value if key == "rpm" else 640.0
    orbit = SimpleNamespace(root=None, rpm=rpm, value=value, theta=[], free=free)
    system = chapter_system()
    assert proofs_module.prove_orbit(system, orbit, key) == (2 if free else 1)
    (machine,) = seen
    assert machine.follower.restitution == (value if key == "restitution" else 0.8)
    assert machine.follower.mass == system.follower.mass
    if key == "restitution":  # for a range of a number of the follower there is no such proof
        assert proofs_module.prove_orbit(system, orbit, key, 1e-9).step is ProofStep.MODEL
        assert len(seen) == 1
