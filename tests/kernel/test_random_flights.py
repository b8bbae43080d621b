"""Random and grazing flights judged in ball arithmetic: no contact is missed or invented."""

from math import pi

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.analysis.bench.machine import reference
from camcli.analysis.bench.peers import Lift
from camcli.analysis.bench.precision import case
from camcli.cli.bench_run import machines
from tests.kernel.helpers import ORACLE_CAM, events, run, system
from tests.random_flights import Flight, first_impact, random_flight, verdict


def outcomes(seed, count):
    """How many of so many random flights ours gets right; none may be missed or invented."""
    rng = np.random.default_rng(seed)
    right = 0
    for _ in range(count):
        flight = random_flight(rng)
        outcome, expected = verdict(flight, first_impact(flight))
        assert outcome in ("right", "undecided"), (flight, outcome, expected)
        right += outcome == "right"
    return right


@pytest.mark.parametrize("seed", range(4))
def test_random_flights(seed):
    assert outcomes(seed, 600) > 450


@pytest.mark.soak
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 12))
def test_many_random_flights(seed):
    assert outcomes(seed, 8000) > 6000


def test_the_judge_calls_a_contact_elsewhere_missed_or_invented():
    """A start on the cam after an impact of the oracle's motion lands where the next one is."""
    some = case("p3")
    hits = [e for e in reference("p3")["events"] if e["kind"] == "impact"]
    before, after = hits[1], hits[2]
    theta, u = float(before["theta"]), -0.8 * float(before["u"])
    w = Lift(some.cam).at(theta)[1] + u / (some.rpm * pi / 30)
    flown = machines().system(some.follower, some.cam)
    flight = Flight(flown, some.rpm, theta * 180.0 / pi, 0.0, w, True)
    s = float(after["theta"]) - theta + 2.0 * pi * (after["turn"] - before["turn"])
    assert verdict(flight, s) == ("right", pytest.approx(s, abs=1e-13))
    outcomes = [verdict(flight, x)[0] for x in (None, s + 1e-9, s - 0.01)]
    assert outcomes == ["missed", "missed", "invented"]


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
