"""The state at a strobe between the departure from a rest and the first impact is in flight."""

from math import cos, radians, sin, sqrt

import pytest

from camcli.api.machine import machine_of
from camcli.cams.balls import precision
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion
from camcli.scene import load_scene

RPM, LEAVES = 130.0, 150.1793714951576  # rpm; deg, where the example's flank ends
C, C1 = 0.2312555620189976, 0.2747021271326710  # of its cam there, m and m/rad


@pytest.mark.parametrize("after", [0.5, 1.0])
def test_a_strobe_in_the_first_flight_sees_the_flight(after):
    """Undamped: q = c cos f s + c' sin(f s)/f from the departure, with f = omega0/omega."""
    system = machine_of(load_scene(None, {"run.rpm": RPM})).system
    follower = system.follower
    f = sqrt(follower.stiffness / follower.mass) / (RPM * 3.141592653589793 / 30.0)
    strobe = radians(LEAVES + after)
    with precision(40):
        motion = BallMotion(BallMachine(system.shape, follower, RPM), strobe, radians(LEAVES))
        motion.step()
        q, w = motion.trail.states[0]
        s = radians(after)
        assert float(q) == pytest.approx(C * cos(f * s) + C1 * sin(f * s) / f, abs=1e-12)
        assert float(w) == pytest.approx(C1 * cos(f * s) - C * f * sin(f * s), abs=1e-12)
