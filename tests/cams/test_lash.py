"""`cam.lash` against a valve between two things that hold it up, a lobe and a seat.

The oracle (`tests.support.valve_on_seat`) knows no clipped cam: it watches two gaps in mpmath, and
each surface has a law of impact of its own.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import log, nextafter, pi, radians, sqrt, tau
from pathlib import Path

import numpy as np
import pytest
from flint import arb
from matplotlib.figure import Figure
from mpmath import mp, mpf

import camcli
from camcli.analysis.exponents import of_orbit, of_record
from camcli.analysis.integrate import Orbit, Settings
from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.attraction import flight_map
from camcli.analysis.orbits.curves import Plane
from camcli.analysis.orbits.identify import RecordedImpact, newton_from
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.api.detach import _outline
from camcli.api.explore_page import machine_data
from camcli.api.machine import machine_of
from camcli.cams.balls import precision
from camcli.errors import SceneError
from camcli.plots.mechanism import machine_panels
from camcli.words.detach_tables import answers
from camcli.words.loads import struck
from camcli.words.machine import machine as report_machine
from camcli.words.verdict import verdict
from tests.support.valve_lift import FLANK, lift
from tests.support.valve_on_seat import Lobe, Valve

CONFIGS = Path(__file__).parents[2] / "configs"
DIGITS = 30
FOLLOWER = {"mass": 0.12, "stiffness": 40_000.0, "preload": 350.0, "damping": 20.0}
LASH = 0.00025
# law, rpm, lash, restitution on the cam and on the seat, base
MACHINES = {
    "holds": ("modified-sine", 1500.0, LASH, 0.3, 0.5, 0.0),
    "bounces": ("cycloidal", 2900.0, LASH, 0.5, 0.3, 0.003),
    "floats": ("constant-acceleration", 4300.0, 0.0006, 0.6, 0.7, -0.002),
    "hard": ("harmonic", 2200.0, LASH, 0.4, 0.6, 0.0),
}


def machine(law, rpm, lash, r, r_seat, base, rise=60.0, dwell=6.0, fall=70.0, **follower):
    """(scene without its run, oracle) of the same machine."""
    constants = {**FOLLOWER, "restitution": r, "seat_restitution": r_seat, **follower}
    lobe = {"base": base, "lift": 0.01, "start": 100.0, "rise": rise, "dwell": dwell, "fall": fall}
    cam = {
        "kind": "law", "base": base, "lift": 0.01, "lash": lash, "top_dwell_deg": dwell,
        "rise": {"start_deg": 100.0, "length_deg": rise, "law": law},
        "fall": {"length_deg": fall, "law": law},
    }  # fmt: skip
    oracle = Valve(Lobe(**lobe, law=law, lash=lash), rpm, **constants)
    return {"follower": constants, "cam": cam}, oracle


def events_of(scene, rpm, turns):
    """The recorded events of a run from rest, with chatters followed as far as doubles go."""
    run = {"rpm": rpm, "transient": 0, "record": turns, "chatter_tolerance": 1e-15}
    return camcli.simulate(camcli.load_scene({**scene, "run": run})).tables["events"]


def corners_of(scene):
    """Where the slope or the curvature jumps, deg."""
    return sorted(np.degrees(machine_of(scene).system.corners))


def compare(scene, oracle, rpm, impacts, turns=40):
    """(largest error of a phase in rad, of a rate over the hardest) of so many recorded impacts."""
    events = events_of(scene, rpm, turns)
    omega = rpm * pi / 30
    known = oracle.events()
    phase = error = hardest = 0.0
    seen = 0
    names = "event", "period", "theta_deg", "u_minus_m_per_s", "u_plus_m_per_s"
    for kind, turn, degrees, u, after in zip(*(events[name] for name in names), strict=True):
        expected = next(known)
        if kind == "chatter":  # the program closes it earlier, by its map
            while expected.kind == "impact":
                expected = next(known)
        assert kind == expected.kind
        at = 2 * mp.pi * (int(turn) + mpf(float(degrees)) / 360)
        phase = max(phase, abs(at - expected.theta))
        if kind == "impact":
            error = max(error, abs(mpf(float(u)) / omega - expected.u))
            hardest = max(hardest, -expected.u)
            assert after == pytest.approx(-float(oracle.r[expected.surface]) * u, rel=1e-15)
            seen += 1
        if seen == impacts:
            return float(phase), float(error / hardest)
    raise AssertionError(f"only {seen} impacts in {turns} turns")


@pytest.mark.parametrize("name", MACHINES)
def test_impacts_are_those_of_a_valve_between_lobe_and_seat(name):
    with mp.workdps(DIGITS):
        scene, oracle = machine(*MACHINES[name])
        phase, speed = compare(scene, oracle, MACHINES[name][1], impacts=8)
    assert phase < 1e-13
    assert speed < 1e-12


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(20))
def test_sixty_impacts_of_any_valve(seed):
    rng = np.random.default_rng(seed)
    laws = ["harmonic", "cycloidal", "3-4-5", "4-5-6-7", "modified-trapezoid", "modified-sine"]
    rpm = float(rng.uniform(1500, 4500))
    damping = float(rng.choice([0.0, 20.0]))
    rise, dwell, fall = (float(rng.uniform(*ends)) for ends in ((50, 80), (1, 20), (50, 80)))
    numbers = (float(rng.uniform(*ends)) for ends in ((1e-4, 6e-4), (0.3, 0.8), (0.2, 0.8)))
    base, law = float(rng.choice([0.0, 0.003, -0.002])), str(rng.choice(laws))
    with mp.workdps(DIGITS):
        scene, oracle = machine(law, rpm, *numbers, base, rise, dwell, fall, damping=damping)
        phase, speed = compare(scene, oracle, rpm, impacts=60, turns=100)
    assert phase < 1e-12
    assert speed < 1e-12


def test_the_corners_are_where_the_lobe_is_as_high_as_the_seat():
    """Of a harmonic lobe: lift (1 - cos x)/2 = lash at both ends."""
    scene, _ = machine("harmonic", 3000.0, LASH, 0.4, 0.4, 0.0)
    corners = corners_of(camcli.load_scene(scene))
    x = np.arccos(1 - 2 * LASH / 0.01) / pi
    assert corners[0] == pytest.approx(100 + 60 * x, abs=1e-12)
    assert corners[-1] == pytest.approx(236 - 70 * x, abs=1e-12)


def test_without_a_restitution_of_its_own_the_seat_has_that_of_the_cam():
    scene, _ = machine(*MACHINES["floats"])
    scene["follower"]["seat_restitution"] = None
    alone = events_of(scene, 4300.0, 3)
    scene["follower"]["seat_restitution"] = scene["follower"]["restitution"]
    both = events_of(scene, 4300.0, 3)
    assert all((alone[name] == both[name]).all() for name in alone)


ARCS = {
    "kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
    "nose_center": 0.40393320723821, "nose_radius": 0.15, "top_dwell_deg": 40.0, "offset": 0.3,
}  # fmt: skip


def test_the_lash_of_a_cam_of_arcs():
    """On the flank c - 0.1 = 0.85 sqrt(..) - 0.45 cos x - 0.4 = lash, by bisection in mpmath."""
    scene = {"follower": {"mass": 1.2, "stiffness": 1430.8, "restitution": 0.8}, "cam": ARCS}
    scene = camcli.load_scene(scene, {"cam.lash": 0.01, "run.transient": 0, "run.record": 2})
    result = camcli.simulate(scene)
    opens = corners_of(scene)[0]
    x = np.radians(opens - 90.0)
    lift = -0.45 * np.cos(x) + np.sqrt(0.85**2 - (0.45 * np.sin(x)) ** 2) - 0.4
    assert lift == pytest.approx(0.01, abs=1e-15)
    trajectory = result.tables["trajectory"]
    assert trajectory["c_m"].min() == pytest.approx(0.1, abs=1e-16)
    assert trajectory["c_m"].max() == pytest.approx(0.25393320723821 - 0.01, abs=1e-15)


def test_the_lash_of_an_eccentric():
    """Without a dwell the seat is the lowest point: lift (1 - cos theta)/2 = lash."""
    cam = {"kind": "eccentric", "base": 0.02, "lift": 0.01, "lash": 0.001}
    scene = {"follower": {"mass": 1.0, "stiffness": 5000.0, "restitution": 0.5}, "cam": cam}
    scene["run"] = {"rpm": 100.0, "transient": 0, "record": 1}
    corners = corners_of(camcli.load_scene(scene))
    opens = np.degrees(np.arccos(1 - 0.2))
    assert corners == pytest.approx([opens, 360 - opens], abs=1e-12)


@pytest.mark.parametrize("ratio", [1.0, 1.6])
def test_the_lash_of_a_table_is_measured_at_the_valve(tmp_path, ratio):
    """A harmonic lobe of 7 mm behind a rocker: the valve opens where it has lifted by the lash."""
    angle = np.arange(0.0, 360.0, 1.0)
    x = np.clip((angle - 100.0) / 140.0, 0.0, 1.0)
    lift = 7.0 * np.sin(pi * x) ** 2
    rows = "\n".join(f"{a:g},{y:.6f}" for a, y in zip(angle, lift, strict=True))
    (tmp_path / "lift.csv").write_text(f"angle,lift\n{rows}\n")
    cam = {
        "kind": "table", "file": "lift.csv", "header": True, "angle_column": "angle",
        "lift_column": "lift", "angle": "cam", "lift": "mm", "rocker_ratio": ratio,
        "zero_deg": 0.0, "direction": "same", "base": 0.001, "lash": LASH,
    }  # fmt: skip
    scene = {"follower": {**FOLLOWER, "restitution": 0.4}, "cam": cam}
    scene["run"] = {"rpm": 500.0, "transient": 1, "record": 1}
    result = camcli.simulate(camcli.load_scene(scene, folder=tmp_path))
    events = result.tables["events"]
    opens = 100 + 140 * np.arcsin(np.sqrt(LASH / (0.007 * ratio))) / pi
    assert events["theta_deg"][0] == pytest.approx(opens, abs=0.05)  # the table's own error
    slope = 0.007 * ratio * pi / np.radians(140) * np.sin(2 * pi * (opens - 100) / 140)
    blow = slope * 500.0 * tau / 60.0
    assert -events["u_minus_m_per_s"][0] == pytest.approx(blow, rel=0.02)
    assert events["q_m"][0] == pytest.approx(0.001, abs=1e-15)
    rests = result.tables["trajectory"]["theta_deg"] < 90.0
    assert (result.tables["trajectory"]["q_m"][rests] == result.tables["events"]["q_m"][0]).all()


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"cam.lash": 0.01}, "a cam that lifts 0.01 m"),
        ({"cam.lash": 0.02}, "a cam that lifts 0.01 m"),
        ({"cam.lash": -0.001}, "found -0.001"),
        ({"cam.lash": "0.25 mm"}, "found '0.25 mm'"),
        ({"cam.lash": None, "follower.seat_restitution": 0.4}, "found 0.4 without cam.lash"),
        ({"cam.lash": None, "follower.seat_restitution": 0.0}, "found 0.0 without cam.lash"),
        ({"cam.lash": None, "follower.seat_restitution": 1.0}, "found 1.0 without cam.lash"),
        ({"follower.seat_restitution": 1.2}, "found 1.2"),
        ({"follower.seat_restitution": 1.0 + 2e-16}, "found 1.0000000000000002"),
        ({"follower.seat_restitution": -1e-300}, "found -1e-300"),
    ],
)
def test_what_cannot_be_is_refused(change, found):
    scene, _ = machine(*MACHINES["holds"])
    scene["follower"]["seat_restitution"] = None
    with pytest.raises(SceneError) as refused:
        camcli.load_scene(scene, change)
    (fault,) = refused.value.faults
    assert found in fault.found


@pytest.mark.parametrize(
    "change",
    [
        {"cam.lash": 0.01 * (1 - 1e-12)},
        {"cam.lash": 1e-12},
        {"cam.lash": 0.0},
        {"follower.seat_restitution": 0.0},
        {"follower.seat_restitution": 1.0},
        {"cam.lash": None},
    ],
)
def test_what_is_just_possible_is_taken(change):
    scene, _ = machine(*MACHINES["holds"])
    scene["follower"]["seat_restitution"] = None
    loaded = camcli.load_scene(scene, change)
    for key, value in change.items():
        section, name = key.split(".")
        assert getattr(getattr(loaded, section), name) == value


@pytest.mark.parametrize("law", ["modified-sine", "cycloidal"])
def test_without_clearance_a_valve_moves_as_without_lash_and_has_a_seat(law):
    """`lash: 0` changes nothing but on the seat, which is where the lobe is on its base circle."""
    scene, _ = machine(law, 4000.0, LASH, 0.4, 0.4, 0.002)
    scene["follower"]["seat_restitution"] = scene["cam"]["lash"] = None
    run = {"rpm": 4000.0, "transient": 5, "record": 5}
    range_ = {"rpm": {"start": 1500.0, "stop": 7500.0, "num": 3}}
    plain, seated, soft = (
        camcli.load_scene({**scene, "run": run, "sweep": range_}, change)
        for change in ({}, {"cam.lash": 0.0}, {"cam.lash": 0.0, "follower.seat_restitution": 0.1})
    )
    for table in ("events", "trajectory"):
        one, other = (camcli.simulate(given).tables[table] for given in (plain, seated))
        for column in one.columns:
            assert np.array_equal(one[column], other[column]), column
    one, other, damped = (camcli.sweep(given).tables["speeds"] for given in (plain, seated, soft))
    of_the_lobe = {"min_contact_force_n", "contact_lost_deg", "contact_regained_deg"}
    for column in set(one.columns) - of_the_lobe - {"shut_bounces_per_turn"}:
        assert list(one[column]) == pytest.approx(list(other[column]), nan_ok=True), column
    dwell = 360.0 - 60.0 - 6.0 - 70.0
    assert other["seat_open_lash_deg"] == pytest.approx(360.0 - dwell, abs=1e-10)
    assert other["seat_open_drawn_deg"] == pytest.approx(360.0 - dwell, abs=1e-10)
    assert list(other["seat_lift_lost_m"]) == [0.0, 0.0, 0.0]
    assert max(other["seat_ramp_velocity_m_per_s"]) < 1e-9
    assert other["seat_open_deg"][0] == pytest.approx(360.0 - dwell, abs=1e-10)
    assert other["seat_open_deg"][2] > 360.0 - dwell + 5.0  # floats, and bounces on its seat
    assert damped["seat_bounces_per_turn"][2] < other["seat_bounces_per_turn"][2]
    lost = [camcli.detach(given).values.detachment.first.rpm for given in (plain, seated)]
    assert lost[0] == lost[1]


@pytest.mark.parametrize(
    ("rpm", "spring", "told"),
    [
        (1500.0, 40_000.0, "contact holds in the turns recorded."),
        (4500.0, 40_000.0, " m/s, and never on its seat."),
        (4500.0, 10_000.0, " m/s, on its seat at up to "),
    ],
)
def test_the_verdict_of_a_valve_without_clearance(rpm, spring, told):
    scene, _ = machine("modified-sine", rpm, LASH, 0.4, 0.4, 0.0, stiffness=spring)
    scene["cam"]["lash"] = 0.0
    run = {"rpm": rpm, "transient": 5, "record": 5}
    (said,) = camcli.simulate(camcli.load_scene({**scene, "run": run})).verdict
    assert told in said


def test_a_seat_without_clearance_asks_for_a_dwell_on_the_base_circle():
    cam = {"kind": "eccentric", "base": 0.0, "lift": 0.01, "lash": 0.0}
    with pytest.raises(SceneError) as refused:
        camcli.load_scene({"follower": {"mass": 1, "stiffness": 1, "restitution": 0}, "cam": cam})
    (fault,) = refused.value.faults
    assert fault.path == "cam.lash"
    assert "stays nowhere on its base circle" in fault.found


def test_the_open_angle_of_a_table_as_it_is_drawn_is_where_its_digits_tell():
    """Between the angles where the law is half a digit high and one and a half."""
    run = {"transient": 1, "record": 1}
    sweep = {"rpm": {"start": 1000.0, "stop": 1000.0, "num": 1}}
    found = {}
    for lash in (0.0, 0.0003):
        changes = {"cam.lash": lash, "run": run, "sweep": sweep}
        table = camcli.sweep(camcli.load_scene("configs/lift-table.yaml", changes)).tables["speeds"]
        found[lash] = table["seat_open_drawn_deg"][0]
    assert found[0.0] == found[0.0003]

    def open_above(inch: float) -> float:
        """deg of the cam over which the law of the table is higher."""
        low, high = 60.0, float(FLANK)  # deg of the crank from the nose
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if float(lift(Fraction(middle))) > inch else (low, middle)
        return low  # two flanks, of half as many degrees each

    assert open_above(1.5e-4) < found[0.0] < open_above(0.5e-4)


def test_a_lash_beyond_the_lift_is_told_at_its_own_line(tmp_path):
    file = tmp_path / "scene.yaml"
    law = "length_deg: 60, law: cycloidal"
    machine = "follower: {mass: 1, stiffness: 1000, restitution: 0.5}\n"
    cam = "cam:\n  kind: law\n  base: 0\n  lift: 0.01\n  lash: 0.02\n"
    cam += f"  rise: {{start_deg: 100, {law}}}\n  top_dwell_deg: 0\n  fall: {{{law}}}\n"
    file.write_text(machine + cam)
    with pytest.raises(SceneError) as refused:
        camcli.load_scene(file)
    (fault,) = refused.value.faults
    assert (fault.path, fault.where) == ("cam.lash", f"{file}:6:3")


@pytest.mark.parametrize("change", [{"cam.lash": 0.01}, {"follower.seat_restitution": 0.5}])
def test_an_oscillator_has_neither_lash_nor_seat(change):
    cam = {"kind": "oscillator", "frequency": 2.6, "clearance": 0.1}
    with pytest.raises(SceneError) as refused:
        camcli.load_scene({"follower": {"restitution": 0.8}, "cam": cam}, change)
    (fault,) = refused.value.faults
    assert fault.path in change
    assert "beside an oscillator" in fault.found


# -- what an engineer reads off the seat --------------------------------------------------------


def turn_of(oracle, number):
    """The events of one turn, each with its angle from the turn's begin, and the one after them."""
    events = []
    for event in oracle.events():
        angle = event.theta - 2 * mp.pi * number
        if angle >= 0:
            events.append(event._replace(theta=angle))
        if angle >= 2 * mp.pi:
            return events
    raise AssertionError


def test_the_columns_of_the_seat():
    """The valve rests on its seat in every turn, so that each one is the first turn again."""
    _, rpm, lash, *_ = MACHINES["floats"]
    with mp.workdps(DIGITS):
        scene, oracle = machine(*MACHINES["floats"])
        *events, after = turn_of(oracle, 1)
        omega = rpm * pi / 30
        seat = [float(-one.u) * omega for one in events if one.surface == "seat" and one.u < 0]
        hardest = max(seat)
        opens = next(float(-one.u) * omega for one in events if one.surface == "lobe")
        closing = oracle.lobe.at(oracle.lobe.shuts)[1]
        shut = next(one.theta for one in reversed(events) if one.kind == "chatter")
        at_rest = (events[0].theta + 2 * mp.pi - shut) / (2 * mp.pi) * 360
        heights = [0.0]
        for one, following in zip(events, [*events[1:], after], strict=True):
            if one.surface == "seat" and -one.u * omega > hardest / 2:
                span = following.theta - one.theta
                v = -oracle.r["seat"] * one.u
                path = (oracle.flight(oracle.seat, v, span * k / 400)[0] for k in range(400))
                heights.append(float(max(path) - oracle.seat))
        on_lobe = sum(
            b.theta - a.theta
            for a, b in pairwise(events)
            if a.kind == "chatter" and a.surface == "lobe"
        )
    run = {"rpm": rpm, "transient": 3, "record": 4}
    sweep = {"rpm": {"start": rpm, "stop": rpm, "num": 1}}
    table = camcli.sweep(camcli.load_scene({**scene, "run": run, "sweep": sweep})).tables["speeds"]
    row = {column: table[column][0] for column in table if column.startswith("seat")}
    assert row["seat_velocity_m_per_s"] == pytest.approx(hardest, rel=1e-10)
    assert row["seat_ramp_velocity_m_per_s"] == pytest.approx(float(-closing) * omega, rel=1e-12)
    assert row["seat_opening_velocity_m_per_s"] == pytest.approx(opens, rel=1e-10)
    assert row["seat_bounces_per_turn"] == sum(u >= hardest / 10 for u in seat)
    assert row["seat_bounce_height_m"] == pytest.approx(max(heights), rel=1e-4)
    assert row["seat_lift_lost_m"] == lash
    assert row["seat_open_deg"] == pytest.approx(360 - float(at_rest), abs=1e-5)
    lobe = float((oracle.lobe.shuts - oracle.lobe.opens) / (2 * mp.pi) * 360)
    assert row["seat_open_lash_deg"] == pytest.approx(lobe, abs=1e-10)
    assert row["seat_open_drawn_deg"] == pytest.approx(136.0, abs=1e-10)
    assert row["seat_lobe_fraction"] == pytest.approx(float(on_lobe / (2 * mp.pi)), abs=1e-5)
    shut = sum(u >= max(float(-one.u) * omega for one in events) / 10 for u in seat)
    assert table["shut_bounces_per_turn"][0] == shut


def test_the_force_of_the_seat_is_none_of_the_lobe():
    """The seat bears the preload of 350 N; on the lobe the spring is pressed further."""
    scene, _ = machine(*MACHINES["holds"])
    sweep = {"rpm": {"start": 300.0, "stop": 300.0, "num": 1}}
    run = {"transient": 2, "record": 2}
    table = camcli.sweep(camcli.load_scene({**scene, "run": run, "sweep": sweep})).tables["speeds"]
    assert 350.5 < table["min_contact_force_n"][0] < 400.0


def test_without_lash_there_is_no_column_of_the_seat():
    speeds = camcli.sweep(
        camcli.load_scene(
            None, {"sweep.rpm.num": 1, "run.transient": 0, "run.record": 2, "run.patience": 0}
        )
    )
    assert not [name for name in speeds.tables["speeds"] if name.startswith("seat")]


def test_contact_is_lost_on_the_lobe():
    """A harmonic lobe is left at its nose, where k (lift - lash) + F0 = m omega^2 lift/2 (pi/b)^2.

    The seat bears k seat + F0 at any speed, and is not asked.
    """
    scene, _ = machine("harmonic", 3000.0, LASH, 0.4, 0.4, 0.0, dwell=0.0, damping=0.0)
    detach = {"rpm": {"start": 2000.0, "stop": 2400.0, "num": 3}}
    table = camcli.detach(camcli.load_scene({**scene, "detach": detach})).tables["detach"]
    pressed = FOLLOWER["stiffness"] * (0.01 - LASH) + FOLLOWER["preload"]
    omega = sqrt(pressed / (FOLLOWER["mass"] * 0.005 * 9.0))  # pi/b = 3 for the rise of 60 deg
    assert table["quantity"][0] == "first_detachment"
    assert table["rpm"][0] == pytest.approx(omega * 30 / pi, rel=1e-12)
    assert table["theta_deg"][0] == pytest.approx(160.0, abs=1e-6)
    assert len(set(table["region"])) == 2  # rise and fall, without the seat


# -- orbits that hit lobe and seat ----------------------------------------------------------------

FAST = 6800.0  # rpm: an impact on the lobe and two on the seat in each turn, and no rest
GUESS = [  # turn, phase (rad) and incoming rate (m/rad) of its impacts
    RecordedImpact(0, np.radians(97.66), -0.0072),
    RecordedImpact(0, np.radians(135.24), -0.0113),
    RecordedImpact(0, np.radians(314.37), -0.0150),
]


def fast_machine():
    """(scene, oracle) of a machine with such an orbit: nearly that of configs/valve-lash.yaml."""
    scene, _ = machine("modified-sine", FAST, LASH, 0.7, 0.6, 0.0, 65.0, 0.0, 65.0, preload=250.0)
    scene["cam"]["rise"]["start_deg"] = 115.0
    lobe = Lobe(0.0, 0.01, 115.0, 65.0, 0.0, 65.0, "modified-sine", LASH)
    return scene, Valve(lobe, FAST, **scene["follower"])


def one_turn(oracle, q, w):
    """(state a turn later, surfaces that were hit) from a state in flight at theta = 0."""
    theta, skip, hit = mpf(0), mpf(0), []
    while True:
        at, surface, u = oracle._next(theta, q, w, "seat", skip)
        if at > 2 * mp.pi:
            return oracle.flight(q, w, 2 * mp.pi - theta), hit
        hit.append(surface)
        q, slope, _ = oracle.surface(surface, at)
        w = slope - oracle.r[surface] * u
        theta, skip = at, mpf(10) ** -6


def test_an_orbit_on_lobe_and_seat_and_its_multipliers():
    """The orbit comes back in the oracle, whose differences give trace and determinant."""
    with mp.workdps(DIGITS):
        scene, oracle = fast_machine()
        orbits = {"rpm": {"start": FAST, "stop": FAST + 1.0, "num": 2}, "at": FAST}
        run = {"rpm": FAST, "transient": 300, "record": 100}
        result = camcli.orbits(camcli.load_scene({**scene, "orbits": orbits, "run": run}))
        branch = result.tables["branch"]
        row = {name: branch[name][0] for name in branch}
        omega = FAST * mp.pi / 30
        q, w = mpf(float(row["q_m"])), mpf(float(row["v_m_per_s"])) / omega
        (q1, w1), hit = one_turn(oracle, q, w)
        small = mpf(10) ** -14
        beside = [one_turn(oracle, q + dq, w + dw)[0] for dq, dw in ((small, 0), (0, small))]
        (a, c), (b, d) = (((q2 - q1) / small, (w2 - w1) / small) for q2, w2 in beside)
    assert row["label"] == "P(1;3)"
    assert sorted(hit) == ["lobe", "seat", "seat"]
    assert abs(q1 - q) < 1e-15
    assert abs(w1 - w) < 1e-15
    assert row["trace"] == pytest.approx(float(a + d), rel=1e-9)
    assert row["det"] == pytest.approx(float(a * d - b * c), rel=1e-9)
    damper = np.exp(-FOLLOWER["damping"] / FOLLOWER["mass"] * 60.0 / FAST)
    assert row["det"] == pytest.approx(0.7**2 * 0.6**4 * damper, rel=1e-14)


def test_the_sum_of_the_exponents_of_an_orbit_on_lobe_and_seat():
    """ln det: 2 ln r for each impact, r that of what is hit, and the damper."""
    scene, _ = fast_machine()
    built = machine_of(camcli.load_scene({**scene, "run": {"rpm": FAST}}))
    root = newton_from(Shooter(built.system, FAST), GUESS, 1)
    found = of_orbit(built.system, from_root(built.system, root))
    damper = FOLLOWER["damping"] / FOLLOWER["mass"] * 60.0 / FAST
    assert found.rule == pytest.approx(2 * log(0.7) + 4 * log(0.6) - damper, rel=1e-13)
    assert abs(found.defect) < 1e-12
    record = Orbit(built.system, FAST, Settings(300, 60, 1e-9, 10**6)).run()
    measured = of_record(built.system, FAST, record)
    assert abs(measured.defect) < 1e-9
    assert measured.rule == pytest.approx(found.rule, rel=0.02)  # it begins and ends in a turn


@pytest.mark.parametrize("parameter", ["restitution", "seat_restitution", "rpm"])
def test_the_tangent_of_a_branch_along_either_restitution(parameter):
    scene, _ = fast_machine()
    built = machine_of(camcli.load_scene({**scene, "run": {"rpm": FAST}}))
    shooter = Shooter(built.system, FAST, parameter)
    orbit = newton_from(shooter, GUESS, 1)
    h = 1e-5 * shooter.value
    sides = [shooter.at_value(orbit.x, orbit.whole, 1, shooter.value + s * h).x for s in (-1, 1)]
    slopes = [(after - before) / (2 * h) for before, after in zip(*sides, strict=True)]
    tangent = [x / orbit.tangent[-1] for x in orbit.tangent]
    assert tangent[:-1] == pytest.approx(slopes[:-1], rel=1e-5)


def test_a_proof_holds_for_an_orbit_on_lobe_and_seat():
    scene, _ = fast_machine()
    orbits = {"rpm": {"start": FAST, "stop": FAST + 1.0, "num": 2}, "at": FAST, "prove": True}
    run = {"rpm": FAST, "transient": 300, "record": 100}
    result = camcli.orbits(camcli.load_scene({**scene, "orbits": orbits, "run": run}))
    assert set(result.tables["branch"]["proved"]) == {"yes"}


def test_attraction_and_two_conditions_take_each_restitution_where_it_holds():
    """Trace and determinant of the same orbit, which the oracle above confirms."""
    scene, _ = fast_machine()
    system = machine_of(camcli.load_scene({**scene, "run": {"rpm": FAST}})).system
    root = newton_from(Shooter(system, FAST), GUESS, 1)
    plane = Plane(("rpm", "restitution"), ((6000.0, 7000.0), (0.5, 0.9)), 20)
    values = FAST, 0.7
    with precision(40):
        tests = [codim2.Condition(codim2.Test.FOLD), codim2.Condition(codim2.Test.FLIP)]
        meeting = codim2.Meeting(system, plane, root, tests)
        at = meeting.shooting([arb(x) for x in values])
        flights = at.flights(at.machine(at.rpm), [arb(x) for x in root.x[:-1]])
        first, second, third = map(flight_map, flights)
        whole = third * second * first
        *residuals, fold, flip = map(float, meeting.equations(meeting.start(root, values)))
    trace, det = float(whole[0, 0] + whole[1, 1]), float(whole.det())
    assert (trace, det) == pytest.approx((root.trace, root.det), rel=1e-9)
    assert max(map(abs, residuals)) < 1e-15
    rates = np.prod(root.rates)
    assert fold == pytest.approx((1.0 - root.trace + root.det) * rates, rel=1e-9)
    assert flip == pytest.approx((1.0 + root.trace + root.det) * rates, rel=1e-9)


def test_the_page_moves_on_cam_and_seat_and_the_sheet_is_of_the_drawn_cam():
    """On the page the lobe is lowered, so that the lash is seen below the shut valve."""
    scene, _ = machine(*MACHINES["holds"])
    built = machine_of(camcli.load_scene(scene))
    page = machine_data(built)
    assert (min(page["cam"]["c"]), max(page["cam"]["c"])) == pytest.approx((0.0, 0.01 - LASH))
    distance = np.hypot(page["outline"]["x"], page["outline"]["y"])
    assert np.ptp(distance) == pytest.approx(0.01, rel=1e-9)
    assert distance.min() == pytest.approx(page["outline"]["rise"] - LASH, rel=1e-9)
    sheet = camcli.simulate(camcli.load_scene(scene), profile_only=True).tables["profile"]
    assert sheet["c_m"].max() == pytest.approx(0.01, abs=1e-12)
    shut = sheet["theta_deg"] < 90.0
    assert set(sheet["force_n"][shut]) == {FOLLOWER["preload"]}
    nose = np.argmin(abs(sheet["theta_deg"] - 163.0))  # in the middle of the top dwell
    pressed = FOLLOWER["preload"] + FOLLOWER["stiffness"] * (0.01 - LASH)
    assert sheet["force_n"][nose] == pytest.approx(pressed, rel=1e-12)


@pytest.mark.parametrize(
    ("spring", "rpm", "told", "rests"),
    [
        ({"stiffness": 40_000.0}, 1500.0, "keeps to the lobe once that has hit it", True),
        ({"stiffness": 400.0, "preload": 4.0}, 6000.0, "never rests on it", False),
    ],
)
def test_the_verdict_says_whether_the_follower_rests_on_the_lobe(spring, rpm, told, rests):
    """Beside samples of the motion: where on the lobe the follower is in contact."""
    scene, _ = machine(*MACHINES["holds"], **spring)
    result = camcli.simulate(camcli.load_scene({**scene, "run": {"rpm": rpm, "record": 40}}))
    way = result.tables["trajectory"]
    on_lobe = (way["contact"] != "flight") & (way["c_m"] > way["c_m"].min() + 1e-6)
    assert on_lobe.any() == rests
    (sentence,) = verdict(result, None, None).lines
    assert told in sentence
    lands = result.system.is_seat
    seats = any(lands(np.radians(theta)) for theta in result.tables["events"]["theta_deg"])
    assert ("does not come to its seat" in sentence) == (not seats)


LASHED = {  # a valve that holds
    "follower": {**FOLLOWER, "restitution": 0.4},
    "cam": {
        "kind": "law", "base": 0.0, "lift": 0.01, "lash": LASH, "top_dwell_deg": 0.0,
        "rise": {"start_deg": 115.0, "length_deg": 65.0, "law": "modified-sine"},
        "fall": {"length_deg": 65.0, "law": "modified-sine"},
    },
    "run": {"rpm": 2000.0},
}  # fmt: skip


def test_a_branch_along_the_lash_ends_where_the_cam_loses_a_part():
    """The last eighth of a modified sine begins at s = (17/4 + 7 pi/8) / (4 + pi)."""
    axis = {"key": "cam.lash", "start": 0.009, "stop": 0.02, "num": 5}
    scene = camcli.load_scene(
        LASHED, {"cam.lash": 0.0095, "orbits.vary": [axis], "orbits.starts": 0, "orbits.at": 2000.0}
    )
    branch = camcli.orbits(scene).tables["branch"]
    last = 0.01 * (17 / 4 + 7 * pi / 8) / (4 + pi)
    assert branch["cam.lash"].max() == pytest.approx(last, rel=1e-9)


@pytest.mark.parametrize("lash", [1e-30, 0.9e-14])
def test_a_lash_below_the_rounding_of_the_heights_is_refused(lash):
    with pytest.raises(SceneError) as caught:
        camcli.load_scene(LASHED, {"cam.lash": lash})
    (fault,) = caught.value.faults
    assert fault.path == "cam.lash"
    assert fault.expected == "expected 1e-14 or more"
    assert fault.cure.startswith("leave it out")
    assert camcli.load_scene(LASHED, {"cam.lash": 1.1e-14}).cam.lash == 1.1e-14


def test_a_tolerance_of_a_number_that_the_scene_leaves_out_is_told_in_words():
    without = {**LASHED, "cam": {**LASHED["cam"], "lash": None}}
    scene = camcli.load_scene(without, {"detach.tolerance": [{"key": "cam.lash", "percent": 5.0}]})
    with pytest.raises(SceneError) as caught:
        camcli.detach(scene)
    text = str(caught.value)
    assert "the scene leaves it out" in text
    assert "None" not in text


@pytest.mark.parametrize("lash", [None, 0.02])
def test_the_derivatives_of_an_arc_begin_with_its_height(lash):
    """At the middle of each arc, with and without lash: height and slope as of the arc itself."""
    cam = camcli.load_scene(None, {"cam.lash": lash}).cam
    count = 0
    with precision(40):
        for part in cam.parts():
            if part.slopes is None or part.lift is None:
                continue
            theta, near = (arb(part.start) + arb(part.end)) / 2, arb(10) ** -15
            height, slope, *_ = part.slopes(theta)
            ends = [part.lift(theta + side * near) for side in (-1, 1)]
            assert abs(float(height - part.lift(theta))) < 1e-30
            assert abs(float(slope - (ends[1] - ends[0]) / (2 * near))) < 1e-18
            count += 1
    assert count >= 3


def test_on_the_seat_the_cam_bears_no_pressure():
    """The seat carries the valve there, though a follower kept on it is pressed by its spring."""
    scene, _ = machine(*MACHINES["floats"])
    contact = {"width": 0.012, "base_radius": 0.02}
    asked = {"detach.rpm": {"start": 3000.0, "stop": 3100.0, "num": 2}, "detach.settle": 0}
    loaded = camcli.load_scene({**scene, "contact": contact}, {**asked, "detach.impacts": 0})
    table = camcli.detach(loaded).tables["force"]
    theta, force, pressure = (table[name] for name in ("theta_deg", "force_n", "pressure_pa"))
    span = 60.0 + 6.0 + 70.0  # of the lobe as it is drawn, from 100 deg on
    off_lobe = (theta < 100.0 - 1e-6) | (theta > 100.0 + span + 1e-6)
    assert off_lobe.sum() > 100
    assert min(table["rpm"]) == 0.0, "the slowest cam presses hardest, at its nose"
    assert (force[off_lobe] > 0.0).all()
    assert (pressure[off_lobe] == 0.0).all()
    pressed = (theta > 130.0) & (theta < 190.0) & (force > 0.0)
    assert pressed.any()
    assert (pressure[pressed] > 0.0).all()


def test_a_certificate_names_the_orbit_with_rest_that_it_does_not_cover(cam, tmp_path):
    few = "--set orbits.starts=0 --no-plot -o out"
    said = cam(f"orbits --prove -c {CONFIGS}/valve-lash.yaml --rpm 3450 {few}", code=0).stdout
    assert "- proved: P(1;inf)" in said
    certificate = json.loads((tmp_path / "out/proof.json").read_text())
    assert certificate["statements"] == []
    assert any("P(1;inf)" in text for text in certificate["uncovered"])


def test_how_hard_it_seats_at_the_working_speed_is_told_though_contact_holds():
    """A follower that keeps to the lobe seats with w c' where the lift falls to the lash."""
    path = str(Path(__file__).parents[2] / "configs/valve-lash.yaml")
    speeds = {"start": 2900.0, "stop": 3000.0, "num": 2}
    values = {"detach.rpm": speeds, "detach.settle": 0, "run.rpm": 3000.0}
    scene = camcli.load_scene(path, values)
    result = camcli.detach(scene)
    sheet = camcli.simulate(scene, profile_only=True).tables["profile"]
    c, c1 = (np.asarray(sheet[name]) for name in ("c_m", "c_theta_m_per_rad"))
    closing = c1 < 0.0
    above = c[closing] - c.min() - scene.cam.lash
    slope = np.interp(0.0, above[::-1], c1[closing][::-1])
    seats = -slope * 3000.0 * np.pi / 30.0
    working = result.summary["working"]
    assert working["max_impact_m_per_s"] is None  # contact holds
    assert working["seat_velocity_m_per_s"] == pytest.approx(seats, rel=1e-2)
    (said,) = [words for words in result.verdict if "At the working speed" in words]
    assert said.endswith(f"comes to its seat with {working['seat_velocity_m_per_s']:.2g} m/s.")
    (rows,) = [rows for title, _, rows in answers(result) if title.startswith("On the seat")]
    assert [row[0] for row in rows] == ["3000*"]
    assert float(rows[0][1]) == pytest.approx(seats, rel=1e-2)


def test_of_a_sweep_from_below_the_loss_only_what_is_past_it_is_told_so():
    """A valve strikes lobe and seat at every speed; it leaves the lobe at 3231 rpm."""
    path = str(CONFIGS / "valve-lash.yaml")
    short = {"run.transient": 5, "run.record": 5}
    for stop, told in ((3300.0, ["Past it, at 3300 rpm", "It seats"]),
                       (3200.0, ["It seats with up to "])):  # fmt: skip
        speeds = {"start": 3000.0, "stop": stop, "num": 2}
        result = camcli.sweep(camcli.load_scene(path, {**short, "sweep.rpm": speeds}))
        _, *lines = result.verdict
        assert [line.startswith(words) for line, words in zip(lines, told, strict=True)] == [
            True
        ] * len(told)
        hardest = result.tables["speeds"]["seat_velocity_m_per_s"][-1]
        assert f"with up to {hardest:.2g} m/s" in lines[-1]


@pytest.mark.parametrize(
    ("theta", "named"), [(124.6, "blow"), (236.18, "seat"), (300.0, "seat"), (200.0, None)]
)
def test_what_a_valve_strikes_is_named(theta, named):
    """The lobe comes to it where the lash is used up, 9.6 deg after 115; then it shuts."""
    system = machine_of(camcli.load_scene(str(CONFIGS / "valve-lash.yaml"))).system
    corners = np.degrees(system.corners)
    nearest = corners[np.argmin(abs(corners - theta))]
    at = nearest if abs(nearest - theta) < 1.0 else theta
    assert struck(system, radians(at)) == named
    assert struck(machine_of(camcli.load_scene(None)).system, radians(at)) is None


def test_a_speed_that_is_asked_for_and_the_working_speed_have_rows_of_their_own():
    path = str(CONFIGS / "valve-lash.yaml")
    one = {"detach.rpm": {"start": 3000.0, "stop": 3000.0, "num": 1}, "detach.settle": 0}
    result = camcli.detach(camcli.load_scene(path, one))
    ((title, _, rows),) = [table for table in answers(result) if "seat" in table[0]]
    assert title == "On the seat (*: the working speed)"
    assert [row[0] for row in rows] == ["3000", "3450*"]
    past = result.values.at_work._replace(rpm=nextafter(3450.0, 0.0))
    result = replace(result, values=replace(result.values, past=(past,)))
    ((_, _, marked),) = [table for table in answers(result) if "seat" in table[0]]
    assert marked == rows  # a speed that is the working speed but for rounding stands once
    swept = {"sweep.rpm": one["detach.rpm"], "run.transient": 20, "run.record": 20}
    table = camcli.sweep(camcli.load_scene(path, swept)).tables["speeds"]
    assert float(rows[0][1]) == pytest.approx(table["seat_velocity_m_per_s"][0], rel=5e-3)


@pytest.mark.ci
def test_each_speed_that_reads_alike_has_one_row_on_the_seat():
    path = str(CONFIGS / "valve-lash.yaml")
    short = {"detach.rpm": {"start": 2500.0, "stop": 3700.0, "num": 2}, "detach.settle": 0}
    result = camcli.detach(camcli.load_scene(path, short))
    near = [past.rpm for past in result.values.past if round(past.rpm) == 3450]
    assert len(near) == 1
    assert near != [3450.0]
    ((_, _, rows),) = [table for table in answers(result) if "seat" in table[0]]
    speeds = [row[0].rstrip("*") for row in rows]
    assert len(speeds) == len(set(speeds))
    assert "3450*" in [row[0] for row in rows]


@pytest.mark.ci
@pytest.mark.parametrize(("start", "turned"), [(115.0, 0.0), (295.0, 180.0)])
def test_the_lash_of_a_report_is_drawn_where_the_follower_is_on_its_seat(start, turned):
    """Also of a cam whose nose is at 0 deg."""
    scene = camcli.load_scene(str(CONFIGS / "valve-lash.yaml"), {"cam.rise.start_deg": start})
    found = machine_of(scene).system
    sketch = _outline(scene, found)
    assert found.is_seat(radians(sketch.at_rest_deg))
    assert sketch.at_rest_deg == turned
    assert sketch.widened > 1.0
    axes = Figure().add_subplot()
    machine_panels(sketch, {})["outline"].draw(axes)
    title = axes.get_title(loc="left")
    assert "times as wide" in title
    assert rf"\theta$ = {turned:g} deg" in title


@pytest.mark.ci
@pytest.mark.parametrize("ratio", [1.0, 1.6])
def test_the_lash_of_a_report_is_that_of_the_valve_and_drawn_at_the_lobe(ratio):
    """Behind a rocker the lobe moves `ratio` times less than the valve, over the lash as well."""
    values = {"cam.lash": 0.0024, "cam.rocker_ratio": ratio}
    scene = camcli.load_scene(str(CONFIGS / "lift-table.yaml"), values)
    found = machine_of(scene).system
    sketch = _outline(scene, found)
    assert sketch.lash == pytest.approx(0.0024 / ratio, rel=1e-12)
    seen = sketch.lash * sketch.widened
    axes = Figure().add_subplot()
    machine_panels(sketch, {})["outline"].draw(axes)
    told = re.match(r"lash (\S+) mm(?:, drawn (\S+) times as wide)?\n", axes.get_title(loc="left"))
    assert float(told[1]) == pytest.approx(2.4, rel=1e-3)
    widened = float(told[2] or 1.0)
    assert widened == pytest.approx(seen / (0.0024 / ratio), abs=0.051)


@pytest.mark.ci
def test_the_page_of_a_report_names_both_restitutions_and_the_side_of_its_table():
    values = {"cam.lash": 0.0002, "cam.rocker_ratio": 1.5, "detach.settle": 0,
              "detach.rpm": {"start": 1000.0, "stop": 1000.0, "num": 1}}  # fmt: skip
    for own, told in ((None, "0.4"), (0.3, "0.3")):
        more = {} if own is None else {"follower.seat_restitution": own}
        scene = camcli.load_scene(str(CONFIGS / "lift-table.yaml"), {**values, **more})
        rows = dict(map(tuple, report_machine(camcli.detach(scene))))
        assert (rows["restitution"], rows["restitution, seat"]) == ("0.4", told)
        assert (rows["rocker ratio"], rows["table of the"]) == ("1.5", "lobe")
