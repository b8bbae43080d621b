"""The error bound of the chatter map against exact sums of synthetic chatters."""

import random
from typing import NamedTuple

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.kernel import flight
from camcli.kernel.cam_table import higher
from camcli.kernel.contact_search import ACCUMULATED, Tally, flight_at
from camcli.kernel.flight import BOUNCED, REFUSED, chatter_map
from camcli.kernel.flow import Constants
from camcli.kernel.forms import PLAIN
from camcli.kernel.sticking import contact_accel
from tests.support.random_flights import CAMS, machine_on

DIGITS = 32
ORDERS = 24  # terms of the gap's Taylor series in a hop


class Chatter(NamedTuple):
    """gap'' + 2 Z gap' + W^2 gap = -1 - a1 t - a2 t^2/2 - a3 t^3/6; a first hop of about `hop`."""

    r: float
    Z: float
    W: float
    hop: float
    a1: float
    a2: float
    a3: float


def series(case, t, rate):
    """Taylor coefficients of the gap from an impact at t, divided by the time since then."""
    _, Z, W, _, a1, a2, a3 = case
    forcing = [
        -1 - t * (a1 + t * (a2 / 2 + t * a3 / 6)),
        -a1 - t * (a2 + t * a3 / 2),
        -(a2 + t * a3) / 2,
        -a3 / 6,
    ]
    rows = [mpf(0), rate]
    for n in range(ORDERS):
        force = forcing[n] if n < 4 else 0
        rows.append((force - 2 * Z * (n + 1) * rows[-1] - W * W * rows[-2]) / ((n + 1) * (n + 2)))
    return rows[1:]


def hop(rows, guess):
    """(duration, landing rate) of a hop by Newton on gap/s, None where it does not land."""
    s = guess
    for _ in range(40):
        value = slope = mpf(0)
        for row in reversed(rows):
            slope, value = slope * s + value, value * s + row
        if not slope < 0:
            return None
        step = value / slope
        s -= step
        if not 0 < s < 4 * guess:
            return None
        if abs(step) < s * mpf(10) ** (2 - DIGITS):
            return s, slope * s
    return None


def exact(case):
    """Duration of a chatter, None where it does not end.

    Hop by hop; the last part, below 1e-14 of the first hop, by the geometric series.
    """
    with mp.workdps(DIGITS):
        case = Chatter(*map(mpf, case))
        t, u = mpf(0), case.hop / 2
        while True:
            rows = series(case, t, u)
            if rows[1] >= 0:
                return None
            guess = -u / rows[1]
            if guess < case.hop * mpf("1e-14"):
                return t + guess / (1 - case.r)
            landed = hop(rows, guess)
            if landed is None:
                return None
            t, u = t + landed[0], -case.r * landed[1]


def random_chatter(rng):
    """A chatter whose constants change by any small part over its length."""
    r = rng.choice([rng.uniform(0.02, 0.9), rng.uniform(0.8, 0.95), rng.uniform(0.001, 0.1)])
    length = 10 ** rng.uniform(-4, 1)

    def part(most, power, signs=(0, -1, 1)):
        return rng.choice(signs) * most * 10 ** rng.uniform(-4, 0) / length**power

    W = part(0.7, 1, (0, 1)) / (1 - r)
    return Chatter(
        r, part(0.08, 1, (0, 1)), W, length * (1 - r), part(0.2, 1), part(0.1, 2), part(0.3, 3)
    )


def claimed(case):
    """The map's (tau, error) with an honest bound on the derivative ahead."""
    r, Z, W, length, a1, a2, a3 = case
    const = Constants(W, W * W, Z, (Z - W) * (Z + W), 0.0, r, 0.0, 0)
    return chatter_map(const, r, length, a1, a2, abs(a3))


def ratio(case):
    """True error over claimed error, rounding taken off; None where the map refuses."""
    tau, error = claimed(case)
    if error == REFUSED:
        return None
    true = exact(case)
    assert true is not None, case
    rest = max(abs(float(mpf(tau) - true)) - 1e-15 * tau, 0.0)
    return rest / error if error > 0 else rest / tau * 1e16


def worst(seed, count):
    rng = random.Random(seed)
    ratios = [x for x in (ratio(random_chatter(rng)) for _ in range(count)) if x is not None]
    assert len(ratios) > count / 2
    return max(ratios)


@pytest.mark.slow
def test_the_claimed_error_is_never_exceeded():
    """And the bound is not a hundred times too wide: users would fly hops for nothing."""
    assert 0.05 < worst(1, 15) <= 1.0


EDGES = [  # parts of the chatter's length that add up to the limit, but for a hair
    (0, -1, 0, 0), (0, 1, 0, 0), (0, 0, -1, 0), (0, 0, 1, 0), (0, 0, 0, -1), (0, 0, 0, 1),
    (1, 0, 0, 0), (0.5, -0.4, 0, 0), (0, -0.7, -0.1, -0.2), (0, -0.6, 0, -0.4), (0.3, 0, 0.4, 0),
    (0, 0, 0, 0),
]  # fmt: skip


@pytest.mark.parametrize(("r", "w"), [(0.001, 0.7), (0.8, 0.0)])
@pytest.mark.parametrize(("z", "j", "s", "d"), EDGES)
def test_the_edge_of_what_the_bound_covers(r, w, z, j, s, d):
    """The limit of 1/4 split between damping and the derivatives, without and with a spring."""
    for scale in (0.2, 0.17, 0.12):
        made = scale * z, w / (1 - r), 1 - r, scale * j, 2 * scale * s, 6 * 0.7 * scale * d
        found = ratio(Chatter(r, *made))
        if found is not None:
            break
    assert found is not None
    assert found <= 1.0


@pytest.mark.parametrize("part", ["Z", "a1", "a2", "a3"])
def test_beyond_the_range_that_was_checked_the_map_refuses(part):
    """Of a chatter one unit long: e1 + e2 + e3 <= 1/4."""
    ball = Chatter(0.8, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0)
    inside, outside = {"Z": (0.19, 0.23), "a1": (0.24, 0.26), "a2": (0.48, 0.52)}.get(
        part, (1.1, 1.15)
    )
    assert claimed(ball._replace(**{part: inside}))[1] < REFUSED
    assert claimed(ball._replace(**{part: outside}))[1] == REFUSED


def test_what_the_machine_hands_to_the_map(monkeypatch):
    """The bound on A''' holds up to the corner, and no accumulation is claimed that may pass it."""
    asked = []

    def spy(const, r, hop, slope, curve, drift):
        tau, error = chatter_map(const, r, hop, slope, curve, drift)
        asked.append((drift, tau, error))
        return tau, error

    monkeypatch.setattr(flight, "chatter_map", spy)
    rng, held_back, closed = np.random.default_rng(7), 0, 0
    for draw in range(1200):
        system, rpm, _ = machine_on(CAMS[draw % len(CAMS)], rng)
        cam, const = system.cam, system.constants(rpm, 0.0, 1)._replace(tolerance=0.1)
        i = int(rng.integers(len(cam.stretches)))
        part = cam.stretches[i]
        theta = float(rng.uniform(part.start, part.end))
        force = -contact_accel(cam, const, i, theta)[0]
        if not force > 0.0:
            continue
        hop = (1 - const.r) * (part.end - theta) * rng.uniform(0.9, 1.05)
        flows = PLAIN.stretch_flows(cam, const)
        asked.clear()
        f = flight_at(cam, const, i, theta, 0.0, 0.5 * hop * force)
        code, reached, _, _ = flight.fly(cam, const, flows, i, f, BOUNCED, Tally())
        if not asked:
            continue
        drift, tau, error = asked[0]
        ahead = [higher(cam, i, t)[:3] for t in np.linspace(theta, part.end, 50)[:-1]]
        thirds = [const.W2 * c3 + 2 * const.Z * c4 + c5 for c3, c4, c5 in ahead]
        assert max(map(abs, thirds)) <= drift * force * (1 + 1e-9)
        within = theta + tau + error < part.end
        held_back += not within and tau < part.end - theta and error <= const.tolerance
        closed += code == ACCUMULATED
        assert code != ACCUMULATED or (within and reached < part.end)
    assert held_back
    assert closed > 30
