"""Starts at the strobe: there to the last bit, whatever degrees the strobe phase was given in."""

from math import tau

import pytest

from camcli.analysis.integrate import Orbit, Start
from camcli.api.machine import machine_of
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.scene import load_scene
from tests.conftest import chapter_system, settings

# Of these 52 strobe phases some are, multiplied by pi/180, an ulp less than their nearest double.
PHASES = [7.0 * n for n in range(52)]


def test_a_start_given_at_the_strobe_is_not_behind_it():
    for degrees in PHASES:
        values = {"run.strobe_deg": degrees, "run.start.theta_deg": degrees, "run.start.q": 0.5}
        machine = machine_of(load_scene(None, values))
        assert machine.settings.start.theta == machine.system.strobe
        orbit = Orbit(machine.system, 700.0, machine.settings)
        assert orbit.state.period == -machine.settings.transient


def test_the_end_of_a_record_is_a_start_at_the_strobe():
    for degrees in PHASES[::9]:
        system = chapter_system(degrees)
        orbit = Orbit(system, 700.0, settings(transient=5, record=2))
        orbit.run()
        end = orbit.as_start()
        assert end.theta % tau == system.strobe
        q, w = orbit.position()
        assert Start.at_strobe(system, 700.0, (q, w)) == Start(end.q, end.v, system.strobe)
        assert Orbit(system, 700.0, settings(transient=1), end).state.period == -1


def test_a_start_that_rests_has_its_phase_alone():
    """At 100 rpm the follower never leaves the cam."""
    for degrees in PHASES[1::9]:
        orbit = Orbit(chapter_system(degrees), 100.0, settings(transient=1, record=1))
        orbit.run()
        end = orbit.as_start()
        assert (end.q, end.v) == (None, None)
        assert end.theta == orbit.system.strobe > 0.0


def test_the_first_strobe_of_a_record_is_its_start():
    """Where the cam's slope is not zero: v = omega dq/dtheta of the follower, not of the gap."""
    system = chapter_system(210.0)
    omega = 700.0 * tau / 60.0
    orbit = Orbit(system, 700.0, settings(0, 2), Start(0.95, -1.5, system.strobe))
    record = orbit.run()
    assert (record.strobe_q[0], record.strobe_w[0]) == pytest.approx(
        (0.95, -1.5 / omega), rel=1e-14
    )
    slope = lift_at(system.cam, stretch_at(system.cam, system.strobe), system.strobe)[1]
    assert abs(slope) > 0.01
