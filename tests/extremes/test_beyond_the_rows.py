"""Extreme cases beside the rows of `cam bench stability`: more speeds, starts, bounded cost."""

import itertools
from math import pi, sqrt

import pytest

import camcli
from camcli.analysis.integrate import Orbit, Settings, StartError
from camcli.analysis.labels import label
from camcli.analysis.simulate import simulate
from camcli.analysis.sweep import sweep
from camcli.errors import Status
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.kernel.helpers import ORACLE_CAM, events, run, settings, system

B = float(ORACLE_CAM.breakpoints[1])


def phases(tape, kind="impact"):
    return [row[2] for row in events(tape) if row[0] == kind]


@pytest.mark.parametrize("damping", [0.0, 1.0])
@pytest.mark.parametrize("rpm", [1.0, 500.0])
def test_rows_9_and_24_no_force_holds_the_follower(rpm, damping):
    """k = g = preload = 0 from rest on the dwell: the lobe throws it off, once and for good."""
    tape = run(rpm, system(stiffness=0.0, damping=damping), record=50)
    assert len(events(tape)) < 100
    assert tape.status in ((Status.NO_RETURN,) if damping == 0.0 else (Status.OK, Status.NO_RETURN))


def test_row_12_phases_are_local_to_the_turn_after_many_turns():
    early, late = (run(150.0, record=1, transient=n) for n in (10, 100_000))
    assert phases(early) == phases(late)


def test_row_14_stiff_and_fast():
    tape = run(50000.0, system(stiffness=1e8), record=30)
    assert tape.status == Status.OK
    assert label(tape).startswith("P(1;")


@pytest.mark.parametrize("offset", [1e-9, 1e-7, 1e-5])
def test_row_16_impacts_near_the_first_detachment_are_not_invented(offset):
    """The flight at b rises by less than its landing speed squared over the deceleration."""
    rows = events(run(114.979326744 + offset, record=1))
    speeds = [-row[4] for row in rows if row[0] == "impact" and row[2] < pi]
    assert all(later < earlier for earlier, later in itertools.pairwise(speeds))
    assert all(row[2] - B < offset for row in rows if row[0] == "impact" and row[2] < pi)


def test_a_spring_without_force_on_the_dwell_is_no_trouble():
    """c = 0 on the base, so force and acceleration of a landing there vanish together."""
    scene = load_scene(None, ["cam.offset=0.4"])
    machine = System.build(Follower(**scene.follower.model_dump()), scene.cam.parts())
    tape = Orbit(machine, 300.0, Settings(5, 50, 1e-9, 10**6)).run()
    assert tape.status == Status.OK
    assert tape.cost.evaluations < 10 * tape.cost.impacts


@pytest.mark.parametrize("rpm", [115.0, 700.0])
@pytest.mark.parametrize("b", [6.7e3, 4.1e4, 1e6, 1e9, 1e12])
def test_rows_6_and_7_heavy_damping(b, rpm):
    """The follower hangs above the cam and creeps; nothing overflows, the cost is bounded."""
    tape = run(rpm, system(damping=b), record=3)
    assert tape.status == Status.OK
    assert all(0.0999 < q < 0.26 for q in tape.strobe_q)
    assert all(abs(u) < 1.0 for u in tape.u)
    assert tape.cost.evaluations < 20_000 * max(1, tape.cost.impacts)


@pytest.mark.parametrize("b", [6.7e3, 4.1e4, 1e6, 1e9, 1e12])
def test_row_7_creep_from_the_top(b):
    """Without inertia: q decays as exp(-k t/b) from the end of the top dwell."""
    rpm, k = 115.0, 146 * 9.8
    tape = run(rpm, system(damping=b), record=1)
    leave = next(row for row in events(tape) if row[0] == "detachment" and row[2] > 3.4)
    end = tape.strobe_q[-1] if len(tape.strobe_q) > 1 else None
    orbit = Orbit(system(damping=b), rpm, settings(1))
    orbit.run(events=False)
    end = orbit.position()[0]
    t = (2 * pi - leave[2]) / (rpm * pi / 30)
    slow = 2 * (k / 1.221) / (b / 1.221 + sqrt((b / 1.221) ** 2 - 4 * k / 1.221))
    assert end == pytest.approx(leave[3] * 2.718281828459045 ** (-slow * t), rel=2e-3)


def test_row_20_a_start_below_the_cam_is_refused_with_its_depth():
    for call in (
        lambda s: Orbit(system(), 190.0, s),
        lambda s: simulate(system(), 190.0, s, 10),
        lambda s: sweep(system(), [190.0], s),
    ):
        with pytest.raises(StartError, match=r"0\.05 m below"):
            call(settings(1, q=0.05, v=0.0))


@pytest.mark.parametrize("q", [0.1, 0.4 - 0.3])
def test_row_18_the_height_of_the_dwell_as_written_is_on_the_cam(q):
    """0.4 m - 0.3 m is an ulp more than 0.1 m."""
    scene = load_scene(None, {"run.start.q": q, "run.start.v": 0.0, "run.rpm": 100.0})
    assert not simulate(system(), 100.0, settings(1, q=q, v=0.0), 10).events
    assert not len(camcli.simulate(scene).tables["events"]["t_s"])


def test_row_10_the_scene_takes_the_numbers_of_the_row():
    f = 2.0**20
    keys = {"follower.stiffness": 1430.8, "run.record": 3, "run.transient": 3}
    one = load_scene(None, {**keys, "run.rpm": 700.0})
    keys["follower.stiffness"] *= f * f
    two = load_scene(None, {**keys, "run.rpm": 700.0 * f})
    found = [camcli.simulate(scene).tables["events"]["theta_deg"] for scene in (one, two)]
    assert list(found[0]) == list(found[1])


def test_row_17_the_start_on_the_nose_is_the_oracles_lift():
    """Starts given in m hit the cam they mean: c of the package within an ulp or two."""
    for degrees in (100.0, 155.0, 205.0, 250.0):
        q = Orbit(system(), 190.0, settings(1, theta_deg=degrees)).position()[0]
        assert q == pytest.approx(float(ORACLE_CAM.c(degrees * (pi / 180))), rel=4e-16)
