"""Random and grazing flights against a brute-force search: no contact is missed or invented."""

from math import pi

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.analysis.engine import Orbit, Settings, Start
from camcli.system import Follower, System
from tests.kernel import dense
from tests.kernel.helpers import ORACLE_CAM, cam, events, run, system

TURNS = 2.5
CORNERS = [0.0, *(float(x) * 180 / pi for x in ORACLE_CAM.breakpoints)]


def random_flight(rng):
    """A machine, its speed and a start: (system, rpm, theta_deg, gap, u, contact)."""
    rpm, W = 10 ** rng.uniform(1.5, 4), 10 ** rng.uniform(-2, 1.3)
    omega = rpm * pi / 30
    Z = rng.choice([0, W, W * (1 + 1e-15), 1.0, 10.0]) * 10 ** (rng.uniform(-3, 0))
    gravity = rng.choice([0, 1]) * 10 ** rng.uniform(-2, 2)
    machine = System(Follower(1.0, (W * omega) ** 2, 2 * Z * omega, gravity, 0.0, 0.5), cam())
    theta = rng.choice(CORNERS) if rng.random() < 0.2 else rng.uniform(0, 360)
    contact = rng.random() < 0.3
    gap = 0.0 if contact else 10 ** rng.uniform(-6, 0.3)
    u = 10 ** rng.uniform(-4, 1) * (1 if contact else rng.choice([-1, 1]))
    return machine, rpm, float(theta), gap, float(u), bool(contact)


def ours(machine, rpm, theta_deg, gap, u, contact):
    """Phase of the package's first impact from the start, None if beyond TURNS, and the start."""
    theta, omega = theta_deg * (pi / 180), rpm * (pi / 30)
    c, c1 = (float(x[0]) for x in dense.lift(np.array([theta])))
    start = Start(None if contact else c + gap, (c1 + u) * omega, theta_deg)
    orbit = Orbit(machine, rpm, Settings(0, 3, 1e-16, 1), start)
    q, w = orbit.position()
    rows = events(orbit.run(), 0 if theta == 0 else 1)
    phases = [row[2] + 2 * pi * row[1] - theta for row in rows if row[0] == "impact"]
    return (phases[0] if phases else None), (theta, q, w)


def check(flight):
    """True where the flight counts: it has a contact that brute force can decide."""
    machine, rpm, *_, contact = flight
    lane = machine.lane(rpm, 1e-9, 1)
    found, (theta, q, w) = ours(*flight)
    expected, doubtful = dense.first_contact(lane.W, lane.Z, lane.G, theta, q, w, TURNS, contact)
    if doubtful or (found is not None and found > TURNS * 2 * pi - 1e-6):
        assert doubtful or expected is None or expected > TURNS * 2 * pi - 1e-5, flight
        return False
    assert (found is None) == (expected is None), (flight, found, expected)
    if expected is None:
        return False
    _, slope = dense.flow(lane.W, lane.Z, lane.G, q, w, expected)
    u = abs(slope - dense.lift(np.array([theta + expected]))[1][0])
    size = abs(q) + abs(w) + lane.G * expected**2 + lane.G / lane.W2
    assert abs(found - expected) <= 1e-12 * size / max(u, 1e-7) + 2e-12, (flight, found, expected)
    return True


@pytest.mark.parametrize("seed", range(4))
def test_random_flights(seed):
    rng = np.random.default_rng(seed)
    assert sum(check(random_flight(rng)) for _ in range(600)) > 450


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 14))
def test_many_random_flights(seed):
    rng = np.random.default_rng(seed)
    assert sum(check(random_flight(rng)) for _ in range(8000)) > 6000


def toward_graze(rpm, theta, delta, s):
    """Start (theta_deg, q, v) of an undamped flight tangent to the cam, raised by delta, at theta.

    Flown backwards by s in 40 digits; None where the start would lie in the cam.
    """
    with mp.workdps(40):
        omega = mpf(rpm) * mp.pi / 30
        W = mp.sqrt(mpf(1430.8) / mpf(1.221)) / omega
        c, c1, _ = ORACLE_CAM.laws(theta)
        q, w = c + mpf(delta), c1
        q, w = q * mp.cos(W * s) - w / W * mp.sin(W * s), w * mp.cos(W * s) + W * q * mp.sin(W * s)
        start = {"theta_deg": (theta - s) * 180 / pi, "q": float(q), "v": float(w * omega)}
        return start if q > ORACLE_CAM.c(theta - s) else None


GRAZES = [
    (rpm, degrees, s)
    for rpm in (300.0, 400.0, 700.0)
    for degrees in (150.5, 153.0, 155.0, 158.0)
    for s in (0.2, 0.3, 0.6, 1.0)
    if toward_graze(rpm, degrees * pi / 180, 1e-9, s)
]


def near(rpm, start, theta, width):
    """(rows of impacts within width of theta before the next far one, tape)."""
    tape = run(rpm, system(stiffness=1430.8), record=1, tolerance=1e-16, budget=4, **start)
    rows = [row for row in events(tape, 1) if row[0] == "impact"]
    return [row for row in rows if abs(row[2] - theta) < width], tape


def test_there_are_grazes_to_test():
    assert len(GRAZES) >= 10


@pytest.mark.parametrize(("rpm", "degrees", "s"), GRAZES)
@pytest.mark.parametrize("delta", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14])
def test_just_above_the_cam_is_no_contact(rpm, degrees, s, delta):
    theta = degrees * pi / 180
    rows, _ = near(rpm, toward_graze(rpm, theta, delta, s), theta, 2e-3)
    assert rows == []


@pytest.mark.parametrize(("rpm", "degrees", "s"), GRAZES)
@pytest.mark.parametrize("delta", [-1e-6, -1e-8, -1e-10, -1e-12, -1e-14])
def test_just_below_the_cam_is_a_double_contact_and_the_first_is_found(rpm, degrees, s, delta):
    """gap = delta + a x^2/2 with a > 0: the first root is at x = -sqrt(2 |delta|/a)."""
    theta = degrees * pi / 180
    rows, _ = near(rpm, toward_graze(rpm, theta, delta, s), theta, 4e-3)
    c, _, c2 = ORACLE_CAM.laws(theta)
    W2 = 1430.8 / 1.221 / (rpm * pi / 30) ** 2
    x = (2 * abs(delta) / float(-W2 * c - c2)) ** 0.5
    assert rows
    assert rows[0][2] - theta == pytest.approx(-x, rel=0.05 if delta < -1e-13 else 0.3)
    assert rows[0][4] == pytest.approx(-2 * abs(delta) / x, rel=0.05 if delta < -1e-13 else 0.3)


@pytest.mark.parametrize(("rpm", "degrees", "s"), GRAZES)
@pytest.mark.parametrize("delta", [-1e-16, 0.0, 1e-16])
def test_an_exact_graze_is_at_most_one_slow_contact(rpm, degrees, s, delta):
    """Row 17: within one ulp either outcome is right, an impact with a speed is not."""
    theta = degrees * pi / 180
    rows, tape = near(rpm, toward_graze(rpm, theta, delta, s), theta, 1e-4)
    assert len(rows) <= 1
    assert all(abs(row[4]) < 1e-6 for row in rows)
    assert tape.status in (0, 2)
