"""The load columns of speeds.csv against dense samples of the motion, in code of its own.

Random machines with damping, gravity, preload, a strobe anywhere and cams below zero; just past
every loss of contact; several losses in a turn.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import camcli
from camcli.analysis.integrate import Orbit, run_all
from camcli.api.machine import machine_of
from camcli.kernel.orbit_loop import IMPACT
from camcli.quantities import LOADS
from tests.conftest import chapter_system, settings, some_in_ci
from tests.support.loads import loads
from tests.support.mechanics import TURN, Flight, Machine, lift_of

TRANSIENT, RECORD = 30, 12
MACHINES = 30
ARCS = {"kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
        "nose_center": 0.40393320723821, "nose_radius": 0.15, "top_dwell_deg": 40.0}  # fmt: skip
# machines of the same kind, and how much faster they turn, that lose contact twice in a turn
SEVERAL = [(103, 1.6), (105, 1.0), (113, 1.3), (118, 1.0), (119, 1.3), (125, 1.3), (137, 1.3)]
SMOOTH = ["harmonic", "cycloidal", "3-4-5", "4-5-6-7"]


def rounded(value: float) -> float:
    return float(f"{value:.6g}")


def random_scene(seed: int) -> dict[str, Any]:
    """A machine whose spring holds its cam up to some speed, and a speed around that one."""
    rng = np.random.default_rng(1000 + seed)
    kind = ("arcs", "eccentric", "law", "law", "kinked")[seed % 5]
    size = 10 ** rng.uniform(-2.5, 0.0)
    if kind == "arcs":
        cam = {**ARCS, "offset": rounded(rng.uniform(0.3, 0.6))}
        low, size = 0.4 - cam["offset"], 0.15393320723821
    elif kind == "eccentric":
        low = rng.choice([-1.0, 1.0]) * size * rng.uniform(0.0, 1.0)
        cam = {"kind": "eccentric", "base": low, "lift": size}
    else:
        low = -size * rng.uniform(0.0, 1.5)
        names = ["constant-velocity"] if kind == "kinked" else SMOOTH
        rise, fall = rng.uniform(40, 120, 2)
        cam = {
            "kind": "law", "base": low, "lift": size,
            "rise": {"start_deg": rng.uniform(-180, 180), "length_deg": rise,
                     "law": str(rng.choice(names))},
            "top_dwell_deg": float(rng.choice([0.0, rng.uniform(1, 60)])),
            "fall": {"length_deg": fall, "law": str(rng.choice(SMOOTH))},
        }  # fmt: skip
    mass, own = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(0.5, 2)  # kg, rad/s
    stiffness = mass * own**2
    # the force at the lowest lift is positive
    preload = stiffness * (max(-low, 0.0) + size * rng.uniform(0.02, 1.0))
    gravity = float(rng.choice([0.0, 9.81]))
    damping = 2 * mass * own * 10 ** rng.uniform(-2, 0.3)
    follower = {
        "mass": mass, "stiffness": stiffness, "damping": damping, "gravity": gravity,
        "preload": preload,
        "restitution": float(rng.choice([0.0, 0.3, 0.6, 0.8, 0.9])),
    }  # fmt: skip
    scene = {"follower": follower, "cam": cam, "run": {"strobe_deg": rng.uniform(0, 360)}}
    first = Machine.of(scene, 1.0).first_loss()
    if not np.isfinite(first):
        first = own * 30 / np.pi
    share = (1.0001, 1.003, 1.05, 1.3, 2.0, 0.95)[seed % 6]
    scene["run"]["rpm"] = first * share
    return scene


def judged(scene: dict[str, Any], **run: Any) -> tuple[dict[str, float], dict[str, float]]:
    """The load columns of a scene at its speed, and the same from samples of its motion."""
    rpm = scene["run"]["rpm"]
    # chaos that may rest later is measured as it was recorded
    own = {"transient": TRANSIENT, "record": RECORD, "patience": 0}
    scene = {**scene, "run": {**own, **scene["run"], **run}}
    scene["sweep"] = {"rpm": {"start": rpm, "stop": rpm, "num": 1}}
    swept = camcli.sweep(camcli.load_scene(scene))
    simulated = camcli.simulate(camcli.load_scene({**scene, "simulate": {"samples": 1}}))
    speeds, strobe = swept.tables["speeds"], swept.tables["strobe"]
    events, turns = simulated.tables["events"], simulated.summary["periods"]
    hits = (events["event"] == "impact") & (events["period"] >= 0)
    np.testing.assert_array_equal(events["theta_deg"][hits], swept.tables["impacts"]["theta_deg"])
    wanted = loads(Machine.of(scene), events, strobe["q_m"][0], strobe["v_m_per_s"][0], turns)
    return {name: float(speeds[name][0]) for name in wanted}, wanted


def compare(found: dict[str, float], wanted: dict[str, float], scene: dict[str, Any]) -> None:
    """A gap may be off by what an event's phase, a double, leaves of it."""
    size = np.ptp(lift_of(scene["cam"]).range)
    for name, value in found.items():
        small = 1e-18 * size if name == "max_gap_m" else 1e-11
        assert value == pytest.approx(wanted[name], rel=1e-9, abs=small, nan_ok=True), name
        assert not value < 0.0, name  # nor by a rounding


def agree(scene: dict[str, Any], **run: Any) -> dict[str, float]:
    """Compare the columns of a scene; returns them."""
    found, wanted = judged(scene, **run)
    compare(found, wanted, scene)
    return found


def default_machine(rpm: float) -> dict[str, Any]:
    return {
        "follower": {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8},
        "cam": {**ARCS, "offset": 0.3},
        "run": {"rpm": rpm},
    }


def kinked(restitution: float, strobe_deg: float, start_deg: float, rpm: float) -> dict[str, Any]:
    """A cam of constant velocity: a blow at the foot, and a launch at the top, once a turn."""
    own = ("mass", "stiffness", "damping", "gravity", "preload", "restitution")
    return {
        "follower": dict(zip(own, (1.0, 2000.0, 10.0, 9.81, 120.0, restitution), strict=True)),
        "cam": {
            "kind": "law", "base": -0.03, "lift": 0.05,
            "rise": {"start_deg": start_deg, "length_deg": 80.0, "law": "constant-velocity"},
            "fall": {"length_deg": 100.0, "law": "constant-velocity"},
        },
        "run": {"rpm": rpm, "strobe_deg": strobe_deg},
    }  # fmt: skip


@cache
def random_machine(seed: int) -> tuple[dict[str, float], dict[str, float]]:
    return judged(random_scene(seed))


@pytest.mark.parametrize("seed", some_in_ci(range(MACHINES), quick=range(10)))
def test_random_machines(seed):
    compare(*random_machine(seed), random_scene(seed))


@pytest.mark.parametrize(("seed", "faster"), SEVERAL)
def test_several_losses_of_contact_in_a_turn(seed, faster):
    """The first loss and the last return are those columns, as phases after the strobe."""
    scene = random_scene(seed)
    scene["run"]["rpm"] *= faster
    agree(scene)


def test_what_the_machines_above_do():
    """They lose contact or not, rest or not, for one turn in some and in each, and none is idle."""
    found = [random_machine(seed)[1] for seed in range(MACHINES)]
    never = sum(np.isnan(one["contact_lost_deg"]) for one in found)
    assert 3 <= never <= MACHINES - 20
    assert sum(one["airborne_fraction"] == 1.0 for one in found) >= 2
    assert sum(one["shut_bounces_per_turn"] > 0 for one in found) >= 8
    assert sum(0.0 < one["max_gap_m"] < 1e-6 for one in found) >= 6
    assert sum(one["contact_lost_deg"] > one["contact_regained_deg"] for one in found) >= 5
    assert sum(one["min_contact_force_n"] > 0.0 for one in found) >= 5


@pytest.mark.parametrize(
    ("rpm", "gap_m"),
    [(115.0, 3.05e-12), (116.0, 3.740e-7), (120.0, 4.84e-5), (125.0, 4.461e-4), (126.0, 6.17e-4)],
)
def test_just_past_the_first_loss(rpm, gap_m):
    """Flights that begin from rest; the numbers are those of another program."""
    found = agree(default_machine(rpm), record=4)
    assert found["max_gap_m"] == pytest.approx(gap_m, rel=2e-3)


def test_bounces_are_measured_by_the_hardest_of_the_record():
    """Seven a turn at 190 rpm, whatever came before the hardest impact."""
    assert agree(default_machine(190.0), record=4)["shut_bounces_per_turn"] == 7.0


def test_the_hardest_impact_of_a_turn_that_is_not_whole_does_not_count():
    """A follower dropped 0.1 mm lands at 0.15 m/s; just past the turn it lands at 12 m/s.

    The budget ends in the second turn, so that the record has one whole turn.
    """
    system = chapter_system(strobe_deg=272.0)
    start = {"q": 0.1001, "v": 0.0, "theta_deg": 271.0}
    (record,) = run_all([Orbit(system, 340.0, settings(0, 2, budget=3, **start))], loads=True)
    speeds = -record.u[record.kind == IMPACT]
    assert record.periods == 1
    assert speeds.max() > 50.0 * speeds[0]
    assert record.loads.max_impact == speeds[0]
    assert record.loads.shut_bounces == 1


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize(
    ("strobe_deg", "start_deg"), [(33.0, -90.0), (350.0, -90.0), (270.0, -90.0), (90.0, -90.0),
                                  (0.0, -80.0), (0.0, 0.0)],
)  # fmt: skip
def test_kinks_launch_and_strike(restitution, strobe_deg, start_deg):
    """With the strobe elsewhere, and on each of the three kinks."""
    found = agree(kinked(restitution, strobe_deg, start_deg, 30.0), record=4)
    assert found["airborne_fraction"] < 0.01
    assert found["max_gap_m"] > 1e-5


@pytest.mark.parametrize("seed", range(200, 210))
def test_a_stiff_damper_presses_on_every_slope(seed):
    """The force has its extremes where damper and inertia balance, not where the cam turns."""
    scene = random_scene(seed)
    follower = scene["follower"]
    follower["damping"] *= 20.0
    speed = scene["run"]["rpm"] * np.pi / 30
    slope = np.abs(lift_of(scene["cam"]).at(np.linspace(0.0, 6.28, 2000))[1]).max()
    follower["preload"] += 1.05 * follower["damping"] * speed * slope
    found = agree(scene, transient=2, record=2)
    assert found["max_contact_force_n"] > 3.0 * found["min_contact_force_n"]


@pytest.mark.parametrize("strobe_deg", [0.0, 100.0])
def test_the_force_turns_twice_between_the_ends_of_a_stretch(strobe_deg):
    """A smooth cam is one stretch, at whose ends the force of its damper has the same slope."""
    own = ("mass", "stiffness", "damping", "gravity", "preload", "restitution")
    follower = dict(zip(own, (0.5, 100.0, 400.0, 9.81, 60.0, 0.5), strict=True))
    scene = {
        "follower": follower, "cam": {"kind": "eccentric", "base": -0.01, "lift": 0.02},
        "run": {"strobe_deg": strobe_deg, "rpm": 60.0},
    }  # fmt: skip
    found = agree(scene, transient=1, record=2)
    assert found["airborne_fraction"] == 0.0
    assert found["max_contact_force_n"] - found["min_contact_force_n"] > 40.0


@pytest.mark.parametrize("rpm", [660.0, 665.0, 670.0])
def test_a_record_cut_by_the_budget_counts_its_whole_turns(rpm):
    scene = default_machine(rpm)
    run = {"transient": 5, "record": 60, "impact_budget": 3}
    assert agree(scene, **run) != agree(scene, **{**run, "impact_budget": 1000})


@pytest.mark.parametrize("name", ["speeds", "map"])
def test_a_record_of_one_turn_has_the_loads_of_many(name):
    """Of P(1;1), long settled: a turn is like the next."""
    span = {"start": 700, "stop": 701, "num": 2}
    mass = {"key": "follower.mass", "start": 1.221, "stop": 1.2211, "num": 2}
    asked = {"speeds": {"sweep.rpm": span}, "map": {"sweep.vary": [{"key": "rpm", **span}, mass]}}
    rows = []
    for record in (1, 9):
        values = {"run.transient": 2000, "run.record": record, **asked[name]}
        rows.append(camcli.sweep(camcli.load_scene(None, values)).tables[name])
    one, many = rows
    assert set(one["label"].tolist()) == {"P(1;1)"}
    for column in LOADS:
        np.testing.assert_allclose(one[column], many[column], rtol=1e-7, err_msg=column)
    assert np.isfinite(one["max_impact_m_per_s"]).all()
    assert (one["airborne_fraction"] == 1.0).all()


@pytest.mark.parametrize("strobe_deg", [110.0, 200.0])
def test_every_orbit_of_a_batch_has_the_loads_of_its_own_record(strobe_deg):
    """Of one turn, which begins in flight: the way up to its first impact counts from its start.

    The highest gap is that of samples of the flight on which the first strobe lies.
    """
    scene = default_machine(700.0)
    scene["run"]["strobe_deg"] = strobe_deg
    system = machine_of(camcli.load_scene(scene)).system
    rpms = (500.0, 580.0, 660.0, 740.0)
    orbits = [Orbit(system, rpm, settings(7, 1)) for rpm in rpms]
    begun = set()
    for rpm, record in zip(rpms, run_all(orbits, loads=True), strict=True):
        machine = Machine.of(scene, rpm)
        (c,), (c1,), _ = machine.cam(machine.strobe)
        gap, rate = record.strobe_q[0] - c, record.strobe_w[0] * machine.omega - c1
        first = record.period.tolist().index(0)
        span = (record.theta[first] - machine.strobe) % TURN
        flight = Flight(machine.strobe, span, gap, rate)
        highest = machine.gap_of(flight)(np.linspace(0.0, span, 4001)).max()
        assert record.loads.max_gap >= highest * (1.0 - 1e-6)
        begun.add(record.loads.max_gap == pytest.approx(highest, rel=1e-5))
        found = record.loads
        (alone,) = run_all([Orbit(system, rpm, settings(7, 1))], loads=True)
        assert found == alone.loads
    assert True in begun
