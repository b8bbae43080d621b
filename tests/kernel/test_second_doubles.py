"""What a double of the velocity after an impact leaves out is kept in a second one.

On the base dwell of the example, whose height is a double, a flight is a cosine and a sine: mpmath
has the landing and the velocity after it to fifty digits.
"""

from __future__ import annotations

import pytest
from mpmath import cos, findroot, mp, mpf, sin, sqrt

from camcli.analysis.integrate import Orbit
from camcli.kernel.cam_table import lift_parts
from tests.conftest import chapter_system, settings

STARTS = [(0.03, -3.0), (0.02, -5.0), (0.5, -80.0), (0.011, -2.0)]  # m above the dwell, m/s
RPM = 700.0
LEFT_OUT = 1e-18  # m/rad: a rounding of these velocities is up to 1e-16


@pytest.mark.parametrize("restitution", [0.8, 0.35, 0.999])
@pytest.mark.parametrize(("height", "v"), STARTS)
def test_the_velocity_after_an_impact_is_known_beyond_a_double(monkeypatch, height, v, restitution):
    """The budget is of one impact, so that the run ends where the follower has just left again."""
    monkeypatch.setenv("CAMCLI_KERNEL", "python")
    system = chapter_system(restitution=restitution)
    orbit = Orbit(system, RPM, settings(0, 1, budget=1, q=0.1 + height, v=v))
    gap, rate = orbit.state.gap, orbit.state.gap_rate
    record = orbit.run()
    state = orbit.state
    assert len(record.theta) == 1
    with mp.workdps(50):
        level, gain, slope, bend, _ = map(mpf, lift_parts(system.cam, 0, 0.0))
        assert slope == bend == 0
        c = level + gain
        k, m = mpf(system.follower.stiffness), mpf(system.follower.mass)
        w0 = sqrt(k / m) / (mpf(RPM) * mp.pi / 30)
        q = c + mpf(gap)
        lands = findroot(lambda x: q * cos(w0 * x) + rate / w0 * sin(w0 * x) - c,
                         mpf(float(record.theta[0])))  # fmt: skip
        assert abs(lands - mpf(float(record.theta[0]))) < 2e-16
        before = -q * w0 * sin(w0 * lands) + rate * cos(w0 * lands)
        after = -mpf(restitution) * before
        known = mpf(state.slope) + mpf(state.slope_rest) + mpf(state.gap_rate)
        assert abs(known - after) < LEFT_OUT
        assert abs(float(record.u[0]) - before) < 1e-16
