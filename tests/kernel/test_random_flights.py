"""Random and grazing flights judged in ball arithmetic: no contact is missed or invented."""

import random
from math import pi, ulp

import numpy as np
import pytest
from mpmath import mp, mpf

from camcli.analysis.bench.machine import reference as stored
from camcli.analysis.bench.peers import Lift
from camcli.analysis.bench.precision import case
from camcli.analysis.integrate import Orbit
from camcli.api.bench import machines
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import column
from camcli.kernel.flight import BOUNCED
from camcli.kernel.sticking import contact_accel
from tests.conftest import settings
from tests.support import oracle
from tests.support.kernel_runs import CHAPTER, ORACLE_CAM, events, reference, run, system
from tests.support.random_flights import (
    CAMS,
    TURNS,
    Flight,
    landing,
    low_hop,
    near_graze,
    random_flight,
    true_contact,
    verdict,
)

EPS = 2.0**-53
ROUNDINGS = 28  # at most eight stretches crossed and a landing, three each, and one of the lift


@pytest.mark.slow
@pytest.mark.parametrize("make", [near_graze, low_hop])
@pytest.mark.parametrize("name", CAMS)
def test_the_first_contact_is_found(name, make):
    """Where it is near to being another: balls decide."""
    rng, right = np.random.default_rng(7), 0
    while right < 60:
        if f := make(name, rng):
            ours = landing(f)
            outcome, expected = verdict(f, ours and ours[0])
            assert outcome in ("right", "undecided"), (f, outcome, expected)
            right += outcome == "right"


def claimed(f: Flight, at: float, u: float) -> tuple[float, float]:
    """Bounds of the errors of the phase (rad) and the rate (m/rad) of a landing at so many rad.

    ROUNDINGS of the largest position met, over the rate of the gap, and of the phase; the rate errs
    by as many roundings of the largest slope, and by its own change over the error of the phase.
    """
    const, cam = f.system.constants(f.rpm, 0.0, 1), f.system.cam
    fall = min(const.G * at * at, const.G / const.W2)
    q = abs(f.q) + abs(f.w) * min(at, 1 / const.W) + fall + cam.top
    slope = abs(f.w) + const.W * q + abs(u)
    accel = const.W2 * q + const.G + 2 * const.Z * slope
    accel += max(map(abs, (*column(cam, "accel_min"), *column(cam, "accel_max"))))
    phase = ROUNDINGS * EPS * (q / abs(u) + at + 2 * pi)
    return phase, ROUNDINGS * EPS * slope + accel * phase


def errors_of_flights(name: str, seed: int, count: int) -> int:
    """How many of so many flights land, each within its claim in phase and rate."""
    rng, landed = np.random.default_rng(seed), 0
    for _ in range(count):
        f = random_flight(name, rng)
        ours = landing(f)
        try:
            with precision(30):
                true = true_contact(f)
        except UndecidedError:
            continue
        if true is None or ours is None:
            assert ours is None or ours[0] > TURNS * 2 * pi - 1e-5
            assert true is None or float(true[0]) > TURNS * 2 * pi - 1e-5
            continue
        with precision(30):
            at, u = float(true[0]), float(true[1])
            off, wrong = (abs(float(x - y)) for x, y in zip(true, ours, strict=True))
        phase, rate = claimed(f, at, u)
        assert (off <= phase, wrong <= rate) == (True, True), (f, off / phase, wrong / rate)
        landed += 1
    return landed


@pytest.mark.parametrize("name", CAMS)
def test_the_error_of_a_landing_is_below_its_claim(name):
    assert errors_of_flights(name, 1, 250) > 125


@pytest.mark.soak
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 110))
@pytest.mark.parametrize("name", CAMS)
def test_the_errors_of_many_landings_are_below_their_claims(name, seed):
    """60 000 landings of 100 000 flights."""
    assert errors_of_flights(name, seed, 1700) > 850


def test_the_rate_of_a_landing_near_its_first_guess():
    """At 745 rpm: a landing found at once, whose rate once took the jerk from far away.

    -47.77089926203954 m/s is a result of 300 digits.
    """
    start = {"q": 0.2512666338255029, "v": 47.67833473776078}
    row = events(run(745.0, record=1, budget=1, theta_deg=156.58059853924627, **start))[0]
    assert row[4] * 745 * pi / 30 == pytest.approx(-47.77089926203954, rel=8 * EPS, abs=0.0)


@pytest.mark.parametrize("damping", [50.0, 1000.0])
@pytest.mark.parametrize(("q", "v"), [(0.6, 5.0), (0.5, -1.0)])
def test_a_flight_of_many_turns_lands_as_exactly_as_a_short_one(damping, q, v):
    """Up to 30 turns at 3000 rpm, hundreds of stretches of the cam."""
    machine = system(damping=damping, restitution=0.9)
    rows = events(run(3000.0, machine, record=60, budget=1, q=q, v=v))
    (true,) = reference(3000.0, impacts=1, damping=damping, restitution=0.9, start={"q": q, "v": v})
    assert rows[0][1] == true.turn
    assert abs(rows[0][2] - true.theta) / (2 * pi) < 8 * EPS


def short_hop(rng: random.Random, corner: str) -> tuple[Orbit, float]:
    """A hop of 1e-8 to 0.03 rad, (its start, speed), from before a corner to behind it.

    The start is exact in doubles. A strobe phase behind the corner makes a stretch of the cam that
    the hop may leave behind as a whole.
    """
    degrees = {"a": 90.0, "c": 160.0, "f": 270.0}[corner]
    rpm = rng.uniform(90, 119) if corner == "c" else 10 ** rng.uniform(1.8, 3.5)
    length = 10 ** rng.uniform(-8, -1.5)
    theta_deg = degrees - length * rng.uniform(0.02, 0.6) * 180 / pi
    strobe_deg = rng.choice([0.0, degrees + length * rng.uniform(0.05, 0.3) * 180 / pi])
    flown = system(strobe_deg)
    orbit = Orbit(flown, rpm, settings(0, 1, budget=1, tolerance=-1.0, theta_deg=theta_deg))
    state = orbit.state
    accel = contact_accel(flown.cam, orbit.const, state.stretch, state.theta)[0]
    state.gap_rate, state.mode = -0.5 * accel * length, BOUNCED
    return orbit, rpm


def hop_of_the_oracle(theta: mpf, u: mpf, rpm: float) -> mpf:
    """Phase of the next contact after an impact that leaves with u m/rad at theta."""
    omega = mpf(rpm) * mp.pi / 30
    c, c1, _ = ORACLE_CAM.laws(theta)
    follower = oracle.Follower.make(CHAPTER["mass"], CHAPTER["stiffness"])
    flight = oracle.Flight(ORACLE_CAM, follower, omega, theta, c, omega * (c1 + u))
    hit = flight.first_contact(2 * mp.pi / omega, True)
    return theta + omega * hit.t


@pytest.mark.parametrize("corner", ["a", "c", "f"])
def test_a_short_hop_across_a_corner_lands_within_eight_roundings(corner):
    """Of its phase, carried along by the hop; by the difference of two lifts it was 13 off."""
    rng = random.Random(3)
    for _ in range(60):
        orbit, rpm = short_hop(rng, corner)
        theta, u = orbit.state.theta, orbit.state.gap_rate
        landed = events(orbit.run())[0]
        with mp.workdps(50):
            true, change = hop_of_the_oracle(mpf(theta), mpf(u), rpm), mpf("1e-30")
            later = hop_of_the_oracle(theta + change, mpf(u), rpm) - true
            faster = hop_of_the_oracle(mpf(theta), u * (1 + change), rpm) - true
            growth = float(max(1, abs(later / change), abs(faster / change)))
            error = float(abs(landed[2] - true))
        assert error < 8 * ulp(landed[2]) * growth, (theta, u, rpm)


def test_the_judge_calls_a_contact_elsewhere_missed_or_invented():
    """A start on the cam after an impact of the oracle's motion lands where the next one is."""
    some = case("p3")
    hits = [e for e in stored("p3")["events"] if e["kind"] == "impact"]
    before, after = hits[1], hits[2]
    theta, u = float(before["theta"]), -0.8 * float(before["u"])
    w = Lift(some.cam).at(theta)[1] + u / (some.rpm * pi / 30)
    flown = machines().system(some.follower, some.cam)
    flight = Flight(flown, some.rpm, theta * 180.0 / pi, 0.0, w, True)
    s = float(after["theta"]) - theta + 2.0 * pi * (after["turn"] - before["turn"])
    assert verdict(flight, s) == ("right", pytest.approx(s, abs=1e-13))
    outcomes = [verdict(flight, x)[0] for x in (None, s + 1e-9, s - 0.01)]
    assert outcomes == ["missed", "missed", "invented"]
