"""The inequalities that make the contact search certain, each tested as an inequality."""

from math import factorial

import numpy as np
import pytest
from flint import arb

from camcli.cams.compile import Part, column
from camcli.errors import Status
from camcli.kernel.cam_table import higher, lift_at
from camcli.kernel.contact_search import (
    CLEAR,
    DIPS,
    LANDED,
    PHASE_CAP,
    UNKNOWN,
    Tally,
    accel_bounds,
    decide,
    flight_at,
    search,
)
from camcli.kernel.flight import leap
from camcli.kernel.flow import move
from camcli.kernel.forms import PLAIN
from camcli.system import Follower, System, omega_of
from tests.support.kernel_runs import cam, events, run, system
from tests.support.machines import Shape
from tests.support.random_flights import CAMS, cam_of, machine_on


def bang_bang(rng):
    """(gap, rate, low, high, s, accelerations and ends of three parts) of a gap near zero.

    Its acceleration is one of its two bounds, or in between; its minimum is moved to near zero.
    """
    low = rng.choice([-1.0, -0.3, 0.0, 0.2])
    high = max(low, rng.choice([-0.2, 0.0, 0.4, 1.0]))
    s = 10 ** rng.uniform(-2, 0)
    ends = s * np.append(np.sort(rng.uniform(0, 1, 2)), 1.0)
    accels = rng.choice([low, high, rng.uniform(low, high)], 3)
    rate = rng.choice([0.0, *(rng.uniform(-1, 1, 3) * s)])
    t = np.linspace(0.0, s, 501)
    lowest = min(gap_at(t, 0.0, rate, ends, accels))
    gap = max(0.0, rng.choice([-1, 1]) * 10 ** rng.uniform(-9, -3) * s * s - lowest)
    return gap, rate, low, high, s, ends, accels


def gap_at(t, gap, rate, ends, accels):
    """The gap at the times t: parabolas joined smoothly."""
    total = gap + rate * t
    begin = 0.0
    for end, accel in zip(ends, accels, strict=True):
        part = np.clip(t - begin, 0.0, end - begin)
        total = total + accel * (0.5 * part**2 + part * np.maximum(t - end, 0.0))
        begin = end
    return total


@pytest.mark.slow
def test_what_is_decided_holds_for_every_gap_with_that_acceleration():
    rng, said = np.random.default_rng(0), set()
    for _ in range(8000):
        gap, rate, low, high, s, ends, accels = bang_bang(rng)
        if gap == 0.0 and rate <= 0.0:
            continue
        t = np.linspace(0.0, s, 501)[1:]
        gaps = gap_at(t, gap, rate, ends, accels)
        u1 = rate + float(accels @ np.diff(ends, prepend=0.0))
        answer = decide(gap, rate, float(gaps[-1]), u1, low, high, s)
        said.add(answer)
        if answer == CLEAR:
            assert gaps.min() >= -1e-12 * s * s
        elif answer == LANDED:
            below = gaps <= 0.0
            assert below[-1]
            assert not np.diff(below.astype(int)).min() < 0
        elif answer == DIPS:
            assert low >= 0.0
    assert said >= {CLEAR, LANDED, DIPS}


def test_a_gap_with_three_roots_is_not_decided():
    """It falls below zero, rises above it, and ends below it."""
    ends, accels = np.array([0.5, 0.98, 1.0]), [1.0, 1.0, -1000.0]
    gaps = gap_at(np.linspace(0.0, 1.0, 101), 0.1, -0.55, ends, accels)
    assert np.count_nonzero(np.diff(np.sign(gaps))) == 3
    assert decide(0.1, -0.55, float(gaps[-1]), -0.55 + 0.98 - 20.0, -1000.0, 1.0, 1.0) == UNKNOWN


@pytest.mark.parametrize("name", CAMS)
def test_the_acceleration_of_the_gap_stays_within_its_bounds(name):
    """Over any step from any state, also those whose q''' is zero, where the bound is sharpest."""
    rng = np.random.default_rng(5)
    for _ in range(1500):
        system, rpm, lift = machine_on(name, rng)
        cam, const = system.cam, system.constants(rpm, 0.0, 1)
        i = int(rng.integers(len(cam.stretches)))
        start, end = cam.stretches[i].start, cam.stretches[i].end
        theta = float(rng.uniform(start, end))
        c, c1, _ = lift_at(cam, i, theta)
        q = c + lift * 10 ** rng.uniform(-6, 1)
        w = lift * rng.uniform(-5, 5)
        if rng.random() < 0.5 and const.W2 != 4.0 * const.Z**2:
            w = 2.0 * const.Z * (const.G + const.W2 * q) / (const.W2 - 4.0 * const.Z**2)
        f = flight_at(cam, const, i, theta, q - c, w - c1)
        s = min(f.end, PHASE_CAP / const.W) * 10 ** rng.uniform(-2, 0)

        def accel(t, const=const, f=f):
            q, w = move(const, f.q, f.w, t)
            return -const.G - const.W2 * q - 2.0 * const.Z * w

        low, high = accel_bounds(cam, const, i, f, s, accel(s))
        size = abs(f.q2) + const.W * abs(f.w) + abs(low) + abs(high) + f.energy * s
        for t in np.linspace(0.0, s, 9)[1:-1]:
            here = accel(float(t)) - lift_at(cam, i, theta + float(t))[2]
            assert low - 1e-9 * size <= here <= high + 1e-9 * size, (f, s, t)


def polynomial_machine(accel, jerk, snap):
    """A free mass on a cam whose gap is u s + a s^2/2 + j s^3/6 + k s^4/24 from the cam at 0."""

    def lift(theta):
        a, j, k = (arb(float(x)) for x in (accel, jerk, snap))
        return 1 - theta * theta * (a / 2 + theta * (j / 6 + theta * k / 24))

    def parts():
        return [Part(arb(0), arb(1), lift), Part(arb(1), 2 * arb.pi(), None, lift(arb(1)))]

    return System.build(Follower(1.0, 0.0), Shape(parts))


@pytest.mark.parametrize("seed", range(2))
def test_the_first_root_of_a_polynomial_gap(seed):
    """Bounds on the derivatives are sharp here: nothing else keeps a root from being passed."""
    rng, omega, landed = np.random.default_rng(seed), 10.0, 0
    for _ in range(150):
        s = 10 ** rng.uniform(-3, -0.5)  # where its terms balance
        jerk = rng.choice([-1.0, 1.0])
        accel = s * rng.choice([1e-9, 0.2, 1.0, -jerk])
        snap = -jerk / s * rng.choice([0.1, 0.2, 0.4, 1.0, 2.0, 6.0])
        rate = s * s * rng.choice([0.0, 1e-6, 0.1, 0.5])
        roots = np.roots([snap / 24, jerk / 6, accel / 2, rate, 0.0][: 5 if rate else 4])
        real = np.sort(roots[np.abs(roots.imag) < 1e-6 * s].real)
        real = real[real > 1e-12 * s]
        if (rate == 0.0 and accel < 0.0) or np.any(np.diff(real, prepend=0.0) < 0.1 * s):
            continue  # it does not leave the cam, or nearly grazes it
        machine = polynomial_machine(accel, jerk, snap)
        record = run(omega * 30 / np.pi, machine, 2, 0, -1.0, 1, v=rate * omega or None)
        first = next((row[2] for row in events(record) if row[0] == "impact"), np.inf)
        if not real.size or real[0] > 0.99:
            assert first > 0.99
            if not real.size:  # a free mass keeps its velocity
                gap = 1.0 + 2 * np.pi * rate - machine.cam.stretches[-1].end_c
                assert record.strobe_q[1] - 1.0 == pytest.approx(gap, rel=1e-10)
        else:
            assert first == pytest.approx(real[0], rel=1e-3)
            landed += 1
    assert landed > 30


def test_a_leap_stays_above_the_cam():
    """Where a spring pulls toward a height above it, also past the lowest point of the flight."""
    rng, leaps, table = np.random.default_rng(1), 0, cam()
    count, top = len(table.stretches), table.top
    for _ in range(2000):
        i, more = rng.integers(count), rng.integers(2, count)
        start, end = table.stretches[i], table.stretches[(i + more) % count]
        length = end.start - start.start + (2 * np.pi if end.start <= start.start else 0.0)
        phase, last = rng.uniform(-1.0, 1.5), np.pi + rng.uniform(-0.3, 0.3)
        W, omega, center = (last - phase) / length, 10.0, top * rng.uniform(1.1, 3.0)
        stiffness = (W * omega) ** 2
        machine = System(Follower(1.0, stiffness, preload=-stiffness * center), table, None)
        const = machine.constants(omega * 30 / np.pi, 0.0, 1)
        swing = (center - top) * rng.uniform(0.9, 1.05)
        q, w = center + swing * np.cos(phase), -swing * W * np.sin(phase)
        gap, rate, flows = q - start.start_c, w - start.start_c1, PLAIN.stretch_flows(table, const)
        skipped, after, _ = leap(table, const, flows, int(i), float(gap), float(rate), Tally())
        if skipped:
            leaps += 1
            end = table.stretches[(i + skipped) % count]
            length = end.start - start.start + (2 * np.pi if end.start <= start.start else 0.0)
            heights = [move(const, q, w, float(s))[0] for s in np.linspace(0.0, length, 60)]
            assert min(heights) > top * (1 - 1e-12)
            assert end.start_c + after == pytest.approx(heights[-1], rel=1e-9)
    assert leaps > 100


def test_a_landing_on_a_kink_meets_the_slope_behind_it():
    """Closing at 1/2 m/rad on a dwell that ends at 1 rad, behind which the cam rises."""

    def parts():
        rises = Part(arb(1), 2 * arb.pi(), lambda theta: (theta - 1) / 4)
        return [Part(arb(0), arb(1), None), rises]

    machine, corner = System.build(Follower(1.0, 0.0), Shape(parts)), 0
    for theta in np.linspace(0.1, 0.9, 300).tolist():
        start = {"theta_deg": theta * 180 / np.pi, "q": 0.5 * (1.0 - theta)}
        record = run(1.0, machine, 1, 0, -1.0, 1, v=-0.5 * omega_of(1.0), **start)
        (_, _, landed, _, u) = events(record)[0]
        assert landed == pytest.approx(1.0, rel=1e-14)
        assert u == pytest.approx(-0.5 if landed < 1.0 else -0.75, rel=1e-13)
        corner += landed == 1.0
    assert corner > 0


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_damped_mass_without_spring_returns_if_its_last_height_is_below_the_cam(share):
    """It comes to rest at q + v m/b; else it is known not to return."""
    damping, q = 2.0, 1.0
    v = -share * (q - cam().top) * damping
    record = run(600.0, System(Follower(1.0, 0.0, damping), cam(), None), 400, 0, 1e-9, 3, q=q, v=v)
    assert record.status == Status.NO_RETURN
    assert (len(record.kind) > 0) == (share > 1.0)


@pytest.mark.parametrize("name", CAMS)
def test_the_local_series_of_the_cam_is_exact_within_its_radius(name):
    """The slope after six derivatives at a phase errs by roundings, in every stretch."""
    table = cam_of(name).cam
    rng, size = np.random.default_rng(2), max(map(abs, column(table, "slope_min")))
    for i, stretch in enumerate(table.stretches):
        s = min(stretch.radius, 0.5 * (stretch.end - stretch.start))
        for theta in rng.uniform(stretch.start, stretch.end - s, 5).tolist():
            c1, c2 = lift_at(table, i, theta)[1:]
            series = c1
            for n, value in enumerate((c2, *higher(table, i, theta)), 1):
                series += value * s**n / factorial(n)
            assert series == pytest.approx(lift_at(table, i, theta + s)[1], abs=4e-15 * size)


@pytest.mark.parametrize(("rpm", "whole"), [(100.0, False), (350.0, True)])
def test_a_step_of_a_flight_is_no_longer_than_a_quarter_of_a_swing(rpm, whole):
    """1.5 of the spring's phase, or to the end of the stretch: the base circle up to 90 deg."""
    machine = system()
    const = machine.constants(rpm, 1e-9, 1)
    f = flight_at(machine.cam, const, 0, 0.01, 0.9, 2.0)
    flows = PLAIN.stretch_flows(machine.cam, const)
    code, theta, _, _ = search(machine.cam, const, flows, 0, f, Tally())
    assert code == CLEAR
    step = np.pi / 2.0 - 0.01 if whole else 1.5 / (np.sqrt(1430.8 / 1.221) / (rpm * np.pi / 30.0))
    assert theta - 0.01 == pytest.approx(step, rel=1e-12)
