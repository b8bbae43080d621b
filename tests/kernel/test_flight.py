"""The closed-form flow against mpmath in every regime of damping, without cancellation."""

import random
from math import isfinite, nextafter, pi, sqrt

import pytest
from mpmath import mp, mpf

from camcli.kernel.arithmetic import sincos
from camcli.kernel.contact_search import LONGEST_PHASE, NEAR, flight_at, gap_near
from camcli.kernel.flight import TAYLOR_PHASE, series_gap, taylor
from camcli.kernel.flow import RAD_PER_S, Constants, flow
from tests import oracle
from tests.kernel.helpers import cam


def lane(W, Z, D=None):
    """A lane of nothing but its flow."""
    D = (Z - W) * (Z + W) if D is None else D
    return Constants(W, W * W, Z, D, 0.0, 0.5, 1e-9, 1000)


def exact(constants, s):
    """(B, B', P) of the kernel's own doubles W2 and Z, in 60 digits or more."""
    with mp.workdps(80):
        follower = oracle.Follower.make(1, mpf(constants.W2), 2 * mpf(constants.Z))
        b, b1 = follower.flow(mpf(s), mpf(0), mpf(1))
        p = -follower._replace(load=mpf(1)).flow(mpf(s), mpf(0), mpf(0))[0]
        return b, b1, p


def relative_errors(constants, s):
    """Errors of B, B', P: B and P relative to the envelope of the motion, B' to 1."""
    ours, theirs = flow(constants, s), exact(constants, s)
    phase = constants.W * s
    scale_b = min(s, 1 / constants.W) if constants.W > 0 and phase > 1 else s
    scales = scale_b, 1.0, max(abs(float(theirs[2])), 1e-300)
    if constants.Z * s > 1:
        b = abs(float(theirs[0]))
        scales = b, max(abs(float(theirs[1])), constants.Z * b), scales[2]
    return [abs(float(a - b)) / c for a, b, c in zip(ours, theirs, scales, strict=True)]


def worst(constants, steps):
    return max(max(relative_errors(constants, s)) for s in steps)


STEPS = [1e-12, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0]


@pytest.mark.parametrize("W", [0.0, 1e-3, 0.03, 0.5, 1.0, 1.4, 3.0, 40.0])
def test_undamped(W):
    assert worst(lane(W, 0.0), STEPS) < 2e-15 * (1 + W)


@pytest.mark.parametrize("W", [1e-3, 0.05, 0.5, 1.0, 3.0, 20.0])
@pytest.mark.parametrize("ratio", [1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999])
def test_underdamped(W, ratio):
    assert worst(lane(W, ratio * W), [s for s in STEPS if ratio * W * s < 1]) < 4e-15 * (1 + W)


@pytest.mark.parametrize("W", [0.0, 1e-6, 1e-3, 0.05, 0.5, 1.0])
@pytest.mark.parametrize("ratio", [1.001, 1.1, 2.0, 10.0, 1e3, 1e6, 1e9, 1e12])
def test_overdamped(W, ratio):
    """Row 7: the slow root by division; b = 1e9 and 1e12 keep full precision."""
    constants = lane(W, ratio * (W or 1.0))
    for s in STEPS:
        b, b1, p = flow(constants, s)
        eb, _, ep = exact(constants, s)
        assert abs(b - eb) <= 3e-14 * abs(eb)
        assert abs(p - ep) <= 3e-14 * abs(ep)
        assert abs(b1) <= 1.0


@pytest.mark.parametrize("Z", [1e-9, 1e-3, 0.1, 1.0, 10.0, 1e6])
def test_no_spring(Z):
    """Row 8: k = 0 with damping; P grows without bound and stays exact."""
    constants = lane(0.0, Z)
    for s in STEPS:
        b, _, p = flow(constants, s)
        eb, _, ep = exact(constants, s)
        assert abs(b - eb) <= 1e-14 * eb
        assert abs(p - ep) <= 1e-14 * ep


def test_no_spring_no_damping_is_a_parabola():
    assert all(flow(lane(0.0, 0.0), s) == (s, 1.0, 0.5 * s * s) for s in STEPS)


@pytest.mark.parametrize("W", [0.05, 0.5, 1.3, 4.0])
def test_critical_damping_is_not_special(W):
    """Row 5: one ulp and 1e-12 beside critical, the same digits on both sides."""
    beside = [W, nextafter(W, 9), nextafter(W, 0), W * (1 + 1e-12), W * (1 - 1e-12)]
    for s in STEPS:
        rows = [flow(lane(W, Z), s) for Z in beside]
        for Z, row in zip(beside, rows, strict=True):
            assert all(isfinite(value) for value in row)
            assert max(relative_errors(lane(W, Z), s)) < 3e-14
            for a, b in zip(row[::2], rows[0][::2], strict=True):
                assert abs(a - b) <= 2e-11 * abs(b)


@pytest.mark.parametrize("b", [6.6e3, 6.7e3, 4e4, 1e5, 1e9, 1e12])
@pytest.mark.parametrize("rpm", [115.0, 700.0])
def test_heavy_damping_never_overflows(b, rpm):
    """Row 6: cosh would overflow where exp underflows."""
    omega = rpm * 3.141592653589793 / 30
    constants = lane(sqrt(1430.8 / 1.221) / omega, b / 2.442 / omega)
    for s in (*STEPS, 6.283185307179586):
        row = flow(constants, s)
        assert all(isfinite(value) for value in row)
        for ours, theirs in zip(row[::2], exact(constants, s)[::2], strict=True):
            assert abs(ours - theirs) <= 5e-14 * abs(theirs)


def test_random_constants():
    """Log-uniform W, Z and s: every branch and every limit between branches."""
    rng = random.Random(4)
    for _ in range(1500):
        W, s = 10 ** rng.uniform(-3, 1.3), 10 ** rng.uniform(-5, 0.8)
        Z = W * 10 ** rng.uniform(-4, 4)
        constants = lane(W, Z)
        b, _, p = flow(constants, s)
        eb, _, ep = exact(constants, s)
        envelope = float(abs(eb)) if Z >= W else min(s, 1 / sqrt(W * W - Z * Z))
        assert abs(b - eb) <= 4e-14 * (1 + W * s) * envelope, (W, Z, s)
        assert abs(p - ep) <= 4e-14 * (1 + W * s) * abs(ep), (W, Z, s)


def test_long_flights_stay_bounded():
    """A thousand turns at W = 1.5e-3 (10^6 rpm), and many oscillations at W = 40."""
    assert worst(lane(1.5e-3, 0.0), [6283.0]) < 1e-12
    b, b1, p = flow(lane(40.0, 0.0), 1000.0)
    assert abs(1 - (b1 * b1 + (40.0 * b) ** 2)) < 1e-11
    assert 0.0 <= p <= 2.0 / 1600.0


@pytest.mark.parametrize("phase", [LONGEST_PHASE, TAYLOR_PHASE])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("W", [0.5, 3.0, 20.0])
def test_short_flights_above_a_dwell_are_exact_to_rounding(W, ratio, phase):
    """The series in relative coordinates at the end of their ranges, where they are worst."""
    constants, table, draw = lane(W, ratio * W), cam(), random.Random(3)
    s = min(phase / (W + 2.0 * ratio * W), NEAR)
    for _ in range(20):
        rate = draw.uniform(-1, 1) * 10 ** draw.uniform(-6, 0)
        f = flight_at(table, constants, 0, 0.5, 0.0, rate)
        with mp.workdps(40):
            b, _, p = exact(constants, s)
            true = f.w * b - (mpf(constants.G) + mpf(constants.W2) * f.q) * p
        size = abs(rate) * s + abs(f.q2) * s * s
        if phase == LONGEST_PHASE:
            assert abs(gap_near(table, constants, 0, f, s)[0] - true) < 4e-16 * size
        else:
            t = taylor(table, constants, 0, f.theta, f.q2, f.q3, f.c2)
            assert abs(series_gap(0.0, rate, t, s)[0] - true) < 2.0**-52 * f.q  # q and c rounded


def test_angles():
    """Of any size that a run meets, and the speed in rad/s."""
    draw = random.Random(5)
    with mp.workdps(40):
        for _ in range(300):
            x = draw.choice([1.0, 1e3, 1.6e6]) * draw.uniform(-1, 1)
            for ours, theirs in zip(sincos(x), (mp.sin(x), mp.cos(x)), strict=True):
                assert abs(ours - theirs) < 2.3e-16
        near = float(1_000_000.5 * mp.pi)
        assert abs(sincos(near)[1] - mp.cos(near)) < 1e-24
    assert pi / 30 == RAD_PER_S  # as in doubles everywhere; the nearest double is one higher
