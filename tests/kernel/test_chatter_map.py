"""The error bound of the chatter map against exact sums of synthetic chatters."""

import random
from types import SimpleNamespace

import pytest
from mpmath import mp, mpf

from camcli.kernel.flight import REFUSED, chatter_map

DIGITS = 32
ORDERS = 16  # terms of the gap's Taylor series in a hop


def derivatives(force, Z, t, rate):
    """gap', gap'', ... at t for gap'' = a(t) - 2 Z gap', a quadratic in t."""
    a0, a1, a2 = force
    forcing = [a0 + t * (a1 + t * a2 / 2), a1 + t * a2, a2]
    rows = [rate]
    for n in range(ORDERS):
        rows.append((forcing[n] if n < 3 else 0) - 2 * Z * rows[-1])
    return rows


def hop(rows, guess):
    """(duration, landing rate) of a hop by Newton on gap/s, None where it does not land."""
    s = guess
    for _ in range(40):
        value = slope = mpf(0)
        weight = mpf(1)
        for n, row in enumerate(rows):
            value += row * weight / (n + 1)
            slope += row * weight
            weight *= s / (n + 1)
        if not slope < 0:
            return None
        step = value * s / slope
        s -= step
        if not 0 < s < 4 * guess:
            return None
        if abs(step) < s * mpf(10) ** (2 - DIGITS):
            return s, slope
    return None


def exact(r, Z, u, jerk, snap):
    """Duration of a chatter that begins with gap' = u, gap'' = -1, gap''' = jerk, gap'''' = snap.

    Hop by hop; the last part, below 1e-16 of the first hop, by the geometric series.
    """
    with mp.workdps(DIGITS):
        r, Z, u, jerk, snap = map(mpf, (r, Z, u, jerk, snap))
        force = -1 + 2 * Z * u, jerk - 2 * Z, snap + 2 * Z * jerk
        t, first = mpf(0), 2 * u
        while True:
            rows = derivatives(force, Z, t, u)
            if rows[1] >= 0:
                return None
            guess = -2 * u / rows[1]
            if guess < first * mpf("1e-14"):
                return t + guess / (1 - r)
            landed = hop(rows, guess)
            if landed is None:
                return None
            t, u = t + landed[0], -r * landed[1]


def random_chatter(rng):
    """(r, Z, u, jerk, snap), scaled so that the change over the chatter is of every size."""
    r = rng.choice([rng.uniform(0.02, 0.9), rng.uniform(0.8, 0.95), rng.uniform(0.001, 0.1)])
    length = 10 ** rng.uniform(-4, 1)
    jerk = rng.choice([0, -1, 1]) * 0.25 * 10 ** rng.uniform(-4, 0) / length
    Z = rng.choice([0, 1]) * 0.125 * 10 ** rng.uniform(-4, 0) / length
    snap = rng.choice([0, -1, 1]) * 10 ** rng.uniform(-4, 1) / length**2
    return r, Z, length * (1 - r) / 2, jerk, snap


def claimed(r, Z, u, jerk, snap):
    """The map's (tau, error) with honest bounds on the derivatives ahead."""
    length = 2 * u / (1 - r)
    lane = SimpleNamespace(r=r, Z=Z)
    return chatter_map(lane, u, -1.0, jerk, abs(jerk) + abs(snap) * length, abs(snap))


def ratio(case):
    """True error over claimed error, rounding taken off; None where the map refuses."""
    tau, error = claimed(*case)
    if error == REFUSED:
        return None
    true = exact(*case)
    assert true is not None, case
    rest = max(abs(float(mpf(tau) - true)) - 1e-15 * tau, 0.0)
    return rest / error if error > 0 else rest / tau * 1e16


def worst(seed, count):
    rng = random.Random(seed)
    ratios = [x for x in (ratio(random_chatter(rng)) for _ in range(count)) if x is not None]
    assert len(ratios) > count / 2
    return max(ratios)


def test_the_claimed_error_is_never_exceeded():
    """And the bound is not a hundred times too wide: users would fly hops for nothing."""
    assert 0.05 < worst(1, 40) <= 1.0


CORNERS = [
    (r, 0.999 * z, 0.999 * j, s)
    for r in (0.05, 0.8, 0.95)
    for z, j in ((0, -0.25), (0, 0.25), (0.125, 0), (0.06, -0.12), (0.06, 0.12), (0, 0))
    for s in (-3.0, 0.0, 3.0)
]


@pytest.mark.parametrize(("r", "z", "j", "s"), CORNERS)
def test_the_edge_of_what_the_bound_covers(r, z, j, s):
    """eta at its limit of 1/4, split between jerk, damping and snap."""
    eta = abs(j) + 2 * z + abs(s)
    scale = min(1.0, 0.2499 / eta) if eta else 1.0
    found = ratio((r, z * scale, (1 - r) / 2, j * scale, s * scale))
    assert found is not None
    assert found <= 1.0


@pytest.mark.parametrize("r", [0.05, 0.3, 0.8, 0.98])
def test_a_bouncing_ball_is_exact(r):
    """Constant acceleration: 2 u/((1 - r) alpha), and no error claimed."""
    tau, error = claimed(r, 0.0, 0.37, 0.0, 0.0)
    assert tau == pytest.approx(0.74 / (1 - r), rel=4e-16)
    assert error == 0.0


@pytest.mark.parametrize("scale", [2.0**-300, 1e-100, 1e-10])
def test_the_map_has_no_scale(scale):
    """Short chatters are mapped as exactly as long ones."""
    tau, error = claimed(0.8, 0.0, 0.1 * scale, 0.0, 0.0)
    assert tau == pytest.approx(scale, rel=1e-15)
    tau, error = claimed(0.8, 0.01 / scale, 0.1 * scale, 0.02 / scale, 0.0)
    twin, claim = claimed(0.8, 0.01, 0.1, 0.02, 0.0)
    assert tau == pytest.approx(twin * scale, rel=1e-14)
    assert error == pytest.approx(claim * scale, rel=1e-12)
