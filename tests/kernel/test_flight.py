"""The closed-form flow against mpmath in every regime of damping, without cancellation."""

import random
from itertools import product
from math import nextafter, pi, sqrt

import pytest
from mpmath import mp, mpf

from camcli.kernel.arithmetic import exp_decay, sincos
from camcli.kernel.contact_search import (
    EXACTLY,
    LONGEST_PHASE,
    NEAR,
    NEARLY,
    Tally,
    flight_at,
    gap_near,
)
from camcli.kernel.flight import BOUNCED, FREE, TAYLOR_PHASE, fly, series_gap, taylor
from camcli.kernel.flow import RAD_PER_S, Constants, constants_of, displacement, flow
from tests.support import oracle
from tests.support.kernel_runs import cam


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


STEPS = [1e-12, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.7, 1.0, 1.5, 2.0, 6.0]
REGIMES = {  # values of W, of Z/W (of Z without a spring), and what an error may be over 1 + W
    "undamped": ([0.0, 1e-3, 0.03, 0.5, 1.0, 1.4, 3.0, 40.0], [0.0], 2e-15),
    "underdamped": ([1e-3, 0.05, 0.5, 1.0, 3.0, 20.0], [1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999], 4e-15),
    "critical": (
        [0.05, 0.5, 1.3, 4.0],
        [1.0, nextafter(1.0, 9), nextafter(1.0, 0), 1 + 1e-12, 1 - 1e-12], 3e-14,
    ),
    "overdamped": (
        [1e-6, 1e-3, 0.05, 0.5, 3.0], [1.001, 1.1, 2.0, 10.0, 1e2, 1e3, 1e6, 1e9, 1e12], 3e-14,
    ),
    "no spring": ([0.0], [1e-9, 1e-3, 0.1, 1.0, 10.0, 1e6, 1e12], 1e-14),
}  # fmt: skip


@pytest.mark.parametrize("regime", REGIMES)
def test_no_digit_is_lost_in_any_regime(regime):
    """Rows 5 to 8: beside critical too; b = 1e12 neither overflows nor cancels."""
    widths, ratios, tolerance = REGIMES[regime]
    for W, ratio in product(widths, ratios):
        constants = lane(W, ratio * (W or 1.0))
        for s in STEPS:
            if ratio >= 1.0 or W == 0.0 or constants.Z * s < 1.0:
                assert max(relative_errors(constants, s)) < tolerance * (1 + W), (W, ratio, s)


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
    assert max(relative_errors(lane(1.5e-3, 0.0), 6283.0)) < 1e-12
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
        found = gap_near(table, constants, 0, f, s)[0]
        if phase == TAYLOR_PHASE:
            t = taylor(table, constants, 0, f.theta, f.q2, f.q3, f.c2)
            found = series_gap(0.0, rate, t, s)[0]
        assert abs(found - true) < 4e-16 * (abs(rate) * s + abs(f.q2) * s * s)


def test_a_fall_on_a_dwell_is_exact_to_rounding():
    """In closed form, from the cam and from above it, however low it is."""
    table, draw, codes = cam(), random.Random(5), set()
    for n in range(400):
        const = lane(draw.choice([0.0, 0.1, 0.5, 3.0]), 0.0)
        const = const._replace(G=draw.choice([0.0, 0.3]) if const.W else 0.3, tolerance=-1.0)
        s = 10 ** draw.uniform(-7, 0) * min(1.0, 0.9 / (const.W or 0.9))
        speed = s * (const.G + 0.1 * const.W2)
        gap, rate = (
            (0.0, 0.4 * speed) if n % 2 else (0.2 * s * speed, draw.uniform(-1, 0.1) * speed)
        )
        f = flight_at(table, const, 0, 0.0, gap, rate)
        code, theta, rest, u = fly(table, const, None, 0, f, FREE if gap else BOUNCED, Tally())
        codes.add(code)
        s = mpf(theta) + rest
        b, b1, p = exact(const, s)
        with mp.workdps(40):
            force = mpf(const.G) + mpf(const.W2) * f.q
            error = gap + mpf(rate) * b - force * p
        assert abs(error) < 1e-15 * s * abs(u)
        assert abs(rate * b1 - force * b - u) < 1e-15 * abs(u)
    assert codes == {NEARLY, EXACTLY}


def test_a_displacement_is_exact_beyond_a_double():
    """Undamped: with q, w and s in two parts, the exact speed and the exact square of omega0."""
    draw = random.Random(6)
    for _ in range(300):
        mass, k, rpm = draw.uniform(0.1, 3), 10 ** draw.uniform(0, 8), 10 ** draw.uniform(1.5, 4)
        gravity = draw.choice([0.0, 9.81])
        const = constants_of([rpm, mass, k, 0.0, gravity, 0.0, 0.8, -1.0], 0.0, 0)
        q, w, s = draw.uniform(0.1, 0.5), draw.uniform(-1, 1), draw.uniform(0.03, 7.0) / const.W
        rests = [draw.uniform(-1, 1) * 2.0**-54 * x for x in (q, w, s)]
        dq, dq_rest, dw, dw_rest = displacement(const, q, rests[0], w, rests[1], s, rests[2])
        with mp.workdps(40):
            W = mp.sqrt(mpf(k) / mpf(mass)) / (mpf(rpm) * mp.pi / 30)
            x, y, t = (mpf(value) + rest for value, rest in zip((q, w, s), rests, strict=True))
            level = mpf(const.G) / mpf(const.W2)
            swing, slope = (x + level) * (mp.cos(W * t) - 1), y * mp.sin(W * t) / W
            size = 2.0**-55 * (abs(x) + abs(y) / W) + 2.0**-51 * level  # G and W2 are rounded
            assert abs(mpf(dq) + dq_rest - (swing + slope)) < size
            fall = y * (mp.cos(W * t) - 1) - W * (x + level) * mp.sin(W * t)
            assert abs(mpf(dw) + dw_rest - fall) < W * size


def test_a_rate_that_damping_has_worn_down_keeps_its_digits():
    draw = random.Random(7)
    for _ in range(100):
        const = lane(draw.choice([0.0, 0.1]), 10 ** draw.uniform(0, 3))._replace(G=0.01)
        q, w, s = draw.uniform(0.1, 0.5), draw.uniform(1, 100), draw.uniform(5, 50) / const.Z
        _, _, dw, dw_rest = displacement(const, q, 0.0, w, 0.0, s, 0.0)
        b, b1, _ = exact(const, s)
        slowed, pull = w * b1, (mpf(const.G) + mpf(const.W2) * q) * b
        assert abs(w + mpf(dw) + dw_rest - (slowed - pull)) < 1e-14 * (abs(slowed) + abs(pull))


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


def test_a_decay_is_that_of_mpmath_until_it_underflows():
    """To some ulp, and where doubles have fewer digits to two steps of the smallest double."""
    with mp.workdps(30):
        for x in (0.0, 1e-9, 0.3465, 0.35, 1.0, 31.5, 700.5, 708.0, 720.0, 740.0, 744.0, 745.1):
            exact = mp.exp(-mpf(x))
            assert abs(exp_decay(x) - exact) <= 4e-16 * exact + mpf(2) ** -1073, x
    assert exp_decay(740.0) > 0.0
    assert exp_decay(746.0) == exp_decay(1e300) == 0.0
