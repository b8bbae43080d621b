"""What a double of the velocity after an impact leaves out is kept in a second one.

Without damping a flight is a cosine and a sine: mpmath has the landing and the velocity after it to
fifty digits, on the base dwell of the example, whose height is a double, and on the polynomials of
its curved stretches.
"""

from __future__ import annotations

from functools import partial
from math import radians

import pytest
from mpmath import cos, findroot, mp, mpf, sin, sqrt

from camcli.analysis.integrate import Orbit
from camcli.kernel.cam_table import (
    LIFT,
    LIFT_REST,
    SLOPE,
    SLOPE_REST,
    TERMS,
    lift_parts,
    piece_at,
    stretch_at,
)
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


def table_near(cam, near: float, order: int, rest: int, theta: mpf) -> mpf:
    """Lift or slope of the cam's table, exactly: the polynomial and what its constant leaves out.

    near: a phase on the same piece.
    """
    piece = piece_at(cam, stretch_at(cam, near), near)
    x = theta - mpf(cam.pieces[piece])
    powers = sum(mpf(cam.pieces[piece + order + k]) * x**k for k in range(TERMS))
    return powers + mpf(cam.pieces[piece + rest])


STARTS_ON_CURVES = [  # phase (deg), height (m) and velocity (m/s)
    (92.0, 0.2, -320.0), (120.0, 0.3, -250.0), (141.0, 0.1, -150.0), (147.0, 0.15, -300.0),
    (151.5, 0.25, -210.0), (217.0, 0.4, -120.0), (235.0, 0.3, -260.0), (255.0, 0.2, -380.0),
]  # fmt: skip


@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize(("impacts", "r", "phase_error"), [(1, 0.8, 3e-17), (2, 0.02, 1.2e-16)])
def test_impacts_on_curved_stretches_are_known_beyond_a_double(
    monkeypatch, gravity, impacts, r, phase_error
):
    """Velocity and phase (m/rad, rad), of which a rounding is 1e-16 to 4e-16.

    A second flight begins with what the first landing has left out, and some go through 360 deg.
    """
    monkeypatch.setenv("CAMCLI_KERNEL", "python")
    for deg, height, v in STARTS_ON_CURVES:
        system = chapter_system(deg, gravity=gravity, restitution=r)
        cam, follower = system.cam, system.follower
        q = cam.stretches[cam.strobe].start_c + height
        orbit = Orbit(system, RPM, settings(0, 1, budget=impacts, q=q, v=v, theta_deg=deg))
        begin, gap, rate = orbit.state.theta, orbit.state.gap, orbit.state.gap_rate
        assert begin == pytest.approx(radians(deg), abs=1e-14)
        record, state = orbit.run(), orbit.state
        assert len(record.theta) == impacts
        with mp.workdps(50):
            omega = mpf(RPM) * mp.pi / 30
            w0 = sqrt(mpf(follower.stiffness) / mpf(follower.mass)) / omega
            pull = mpf(gravity) / omega**2 / w0**2  # m, from the spring's rest to its balance
            phase = mpf(begin)
            q = table_near(cam, begin, LIFT, LIFT_REST, phase) + gap
            w = table_near(cam, begin, SLOPE, SLOPE_REST, phase) + rate
            for theta in map(float, record.theta):
                lift = partial(table_near, cam, theta, LIFT, LIFT_REST)
                phase -= 2 * mp.pi if theta < phase else 0

                def gap_at(x, phase=phase, q=q, w=w, w0=w0, pull=pull, lift=lift):
                    swing = (q + pull) * cos(w0 * x) + w / w0 * sin(w0 * x) - pull
                    return swing - lift(phase + x)

                x = findroot(gap_at, theta - phase)
                phase = phase + x
                slope = table_near(cam, theta, SLOPE, SLOPE_REST, phase)
                before = w * cos(w0 * x) - (q + pull) * w0 * sin(w0 * x)
                q = lift(phase)
                w = slope - mpf(follower.restitution) * (before - slope)
            known = mpf(state.slope) + mpf(state.slope_rest) + mpf(state.gap_rate)
            assert abs(known - w) < 2.5e-17
            assert abs(mpf(theta) + state.rest - phase) < phase_error
