"""Rows 4, 10 to 16, 21 to 23: speeds from 1e-3 to 1e6 rpm, corners, strobes and detachment."""

import itertools
from math import nextafter, pi

import pytest

from camcli.analysis.engine import Orbit, Settings
from camcli.analysis.labels import label
from camcli.errors import OK
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.kernel.helpers import ORACLE_CAM, events, run, system

B, C = (float(ORACLE_CAM.breakpoints[k]) for k in (1, 2))


def phases(tape, kind="impact"):
    return [row[2] for row in events(tape) if row[0] == kind]


@pytest.mark.parametrize("b", [0.0, 20.0])
def test_row_10_a_stiffer_faster_machine_has_the_same_phases(b):
    plain = run(358.5, system(damping=b, gravity=1.0), record=40, q=0.3, v=2.0)
    for n in (-20, -3, 1, 20):
        f = 2.0**n
        machine = system(stiffness=146 * 9.8 * 4.0**n, damping=b * f, gravity=4.0**n)
        scaled = run(358.5 * f, machine, record=40, q=0.3, v=2.0 * f)
        assert list(plain.theta) == list(scaled.theta)
        assert list(plain.strobe_w) == list(scaled.strobe_w)


def test_row_11_a_heavier_machine_has_the_same_phases():
    plain = run(700.0, system(damping=3.0, preload=5.0), record=60)
    for n in (-40, -1, 7, 40):
        f = 2.0**n
        machine = system(mass=1.221 * f, stiffness=146 * 9.8 * f, damping=3.0 * f, preload=5.0 * f)
        assert list(plain.theta) == list(run(700.0, machine, record=60).theta)


def test_row_12_a_thousandth_of_a_turn_per_minute_sticks():
    tape = run(1e-3, record=2000)
    assert tape.status == OK
    assert label(tape) == "contact"
    assert not events(tape)


@pytest.mark.slow
def test_row_12_phases_are_local_to_the_turn_after_a_million_turns():
    early, late = (run(150.0, record=1, transient=n) for n in (10, 1_000_000))
    assert phases(early) == phases(late)


def test_row_12_phases_are_local_to_the_turn():
    early, late = (run(150.0, record=1, transient=n) for n in (10, 2000))
    assert phases(early) == phases(late)
    assert phases(early, "chatter") == phases(late, "chatter")


def test_row_13_flights_of_a_thousand_turns_cost_little():
    tape = run(1e6, record=20000)
    assert tape.status == OK
    assert 5 < tape.cost.impacts < 100
    assert tape.cost.evaluations < 20 * tape.cost.impacts
    assert tape.cost.crossings < 2 * 20000


def test_row_14_stiff_and_fast():
    tape = run(50000.0, system(stiffness=1e8), record=30)
    assert tape.status == OK
    assert label(tape).startswith("P(1;")


@pytest.mark.parametrize(("offset", "leaves"), [(-1e-5, False), (1e-5, True)])
def test_row_15_first_detachment(offset, leaves):
    tape = run(114.979326744 + offset, record=3)
    rows = events(tape)
    assert bool(rows) == leaves
    assert not leaves or rows[0][:3] == ("detachment", 0, B)


@pytest.mark.parametrize("offset", [1e-9, 1e-7, 1e-5])
def test_row_16_impacts_near_the_first_detachment_are_not_invented(offset):
    """The flight at b rises by less than its landing speed squared over the deceleration."""
    rows = events(run(114.979326744 + offset, record=1))
    speeds = [-row[4] for row in rows if row[0] == "impact" and row[2] < pi]
    assert all(later < earlier for earlier, later in itertools.pairwise(speeds))
    assert all(row[2] - B < offset for row in rows if row[0] == "impact" and row[2] < pi)


def test_row_16_at_114_98():
    rows = events(run(114.98, record=1))
    speeds = [-row[4] * 114.98 * pi / 30 for row in rows if row[0] == "impact" and row[2] < pi]
    assert 1e-10 < speeds[0] < 1e-6
    assert all(later < earlier for earlier, later in itertools.pairwise(speeds))


def near_corner(count):
    """Speeds around the one whose first impact is exactly on c, closest doubles."""
    low, high = 124.99, 125.01
    while nextafter(low, high) < high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if phases(run(middle, record=1))[0] < C else (low, middle)
    speeds = [low]
    for _ in range(count):
        speeds = [nextafter(speeds[0], 0), *speeds, nextafter(speeds[-1], 999)]
    return speeds


def test_row_21_an_impact_on_a_corner_is_one_impact():
    for rpm in near_corner(6):
        rows = events(run(rpm, record=1, tolerance=1e-16))
        here = [row for row in rows if abs(row[2] - C) < 1e-12]
        assert [row[0] for row in here] == ["impact"], rpm


def test_row_21_the_hops_after_it_are_there():
    for rpm in near_corner(6):
        rows = events(run(rpm, record=1, tolerance=1e-16))
        hops = [row for row in rows if row[0] == "impact" and C + 1e-12 < row[2] < 3.2]
        assert len(hops) > 20, rpm


def test_row_22_an_event_at_the_strobe_is_in_one_period():
    """The strobe a few ulp around the impact of P(1;1): every period holds one impact."""
    rows = events(run(700.0, record=1, transient=2000))
    phase = next(row[2] for row in rows if row[0] == "impact") * 180 / pi
    strobes = [phase]
    for _ in range(8):
        strobes = [nextafter(strobes[0], 0), *strobes, nextafter(strobes[-1], 360)]
    for strobe in strobes:
        tape = run(700.0, system(strobe), record=50, transient=2000)
        assert tape.status == OK
        total, count = sum(tape.impacts), len([k for k in tape.kind if k == 1])
        assert total == count
        assert 49 <= total <= 51


def test_row_22_a_start_on_the_strobe_counts_its_impact_once():
    tape = run(190.0, record=1, theta_deg=0.0, v=-3.0)
    rows = events(tape)
    assert rows[0][:3] == ("impact", 0, 0.0)
    assert list(tape.impacts) == [sum(row[0] == "impact" for row in rows)]


def test_row_23_chatter_turns_incomplete_once():
    """From rest, the chatter of the first turn ends in the second, before b or not at all."""
    complete = [bool(run(198.5505 + 0.001 * k, record=2).chatter[1]) for k in range(21)]
    assert complete == sorted(complete, reverse=True)
    assert complete[0]
    assert not complete[-1]


def test_a_spring_without_force_on_the_dwell_is_no_trouble():
    """c = 0 on the base, so force and acceleration of a landing there vanish together."""
    scene = load_scene(None, ["cam.offset=0.4"])
    machine = System.build(Follower(**scene.follower.model_dump()), scene.cam.parts())
    tape = Orbit(machine, 300.0, Settings(5, 50, 1e-9, 10**6)).run()
    assert tape.status == OK
    assert tape.cost.evaluations < 10 * tape.cost.impacts
