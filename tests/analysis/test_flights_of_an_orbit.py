"""Flights between the impacts of a solved orbit, beside the closed form of their motion."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import chapter_system, settings, solve_from
from flint import arb

from camcli.analysis.orbits import codim2
from camcli.analysis.orbits.attraction import _passes
from camcli.analysis.orbits.codim2 import Test as What
from camcli.analysis.orbits.codim2 import _CurveSearch, exact_shooting
from camcli.cams.balls import precision
from camcli.exact import shooting as shooting_module
from tests.support.machines import CHAPTER

RPM = 358.5
LOW = CHAPTER.cam.lift(np.zeros(1))[0][0]  # m, of the cam on its base circle


@pytest.fixture(scope="module")
def orbit():
    """P(3;3:3:2), whose eight flights begin on the base circle, on a flank and on the nose."""
    return solve_from(chapter_system(), RPM, settings(600))


def flight(orbit, k):
    """(follower's lift at an angle from impact k, that of the cam, the angle to the next impact)"""
    root, frequency = orbit.root, np.sqrt(CHAPTER.stiffness / CHAPTER.mass) * 30.0 / (RPM * np.pi)
    theta, after = root.theta[k], (k + 1) % root.count
    turns = root.whole[2 * after + 1] - root.whole[2 * k + 1] + (orbit.turns if after == 0 else 0)

    def cam(angle):
        return CHAPTER.cam.lift(np.degrees(np.atleast_1d(theta + angle)) % 360.0)

    (low,), (slope,), _ = cam(0.0)
    rate = root.x[2 * k + 1] + slope

    def follower(s):
        return low * np.cos(frequency * s) + rate / frequency * np.sin(frequency * s)

    return follower, lambda s: cam(s)[0], root.theta[after] - theta + 2.0 * np.pi * turns


def test_the_lowest_places_of_the_flights_are_those_of_a_sampled_gap(orbit):
    wanted = []
    for k in range(orbit.root.count):
        follower, cam, whole = flight(orbit, k)
        s = np.linspace(0.0, whole, 20001)
        gap = follower(s) - cam(s)
        assert abs(gap[-1]) < 1e-13
        dips = np.flatnonzero((gap[1:-1] < gap[:-2]) & (gap[1:-1] <= gap[2:])) + 1
        wanted += [(gap[j], k, s[j]) for j in dips]
    assert len(wanted) == 2
    search = _CurveSearch(chapter_system(), SimpleNamespace(located=True), 1, None)
    found = search._dips(orbit.root, range(orbit.root.count))
    for (gap, k, s), (mine, there) in zip(sorted(wanted), found, strict=True):
        assert there.impact == k
        assert mine == pytest.approx(gap, abs=1e-7)
        assert there.angle == pytest.approx(s, abs=1e-3)


def test_of_many_low_places_the_lowest_four_are_refined(monkeypatch):
    """The first flight is sampled at every 1/64 rad, and its dip is midway between two samples.

    The second has six dips, each lower than the one before; the last flight is not asked.
    """
    dip = 3.5 / 64.0
    lengths = [0.125, 1.0, 1.0]
    gaps = [
        lambda s: (s - dip) ** 2 - 1.25,
        lambda s: -s - 0.375 * np.cos(12.0 * np.pi * (s - 0.04)),
        lambda s: s - 9.0,
    ]
    base = SimpleNamespace(
        machine=lambda rpm: rpm,
        rpm=8.0,
        places=[SimpleNamespace(turn=turn) for turn in (4, 5, 6)],
        place=lambda theta, turn: (theta, turn),
        span=lambda x, k: arb(lengths[k]),
    )

    def gap(machine, x, k, place):
        def of(s):
            theta, turn = place
            assert (machine, turn, float(theta)) == (8.0, 4 + k, float(x[2 * k] + s))
            return [arb(float(gaps[k](float(s)))), arb(99)]

        return of

    base.gap = gap
    monkeypatch.setattr(codim2, "exact_shooting", lambda system, root: base)
    root = SimpleNamespace(x=[1.0, 0.5, 2.0, 0.25, 3.0, 0.125, 7.0])
    found = _CurveSearch._dips(SimpleNamespace(system="system"), root, [0, 1])
    s = np.linspace(0.0, 1.0, 200001)
    gap_of_second = gaps[1](s)
    low = np.flatnonzero((gap_of_second[1:-1] < gap_of_second[:-2])
                         & (gap_of_second[1:-1] <= gap_of_second[2:])) + 1  # fmt: skip
    assert len(low) == 6
    wanted = sorted([(-1.25, 0, dip), *((gap_of_second[j], 1, s[j]) for j in low)])[:4]
    assert [k for _, k, _ in wanted].count(0) == 1
    for (value, k, angle), (mine, there) in zip(wanted, found, strict=True):
        assert (there.test, there.impact) == (What.GRAZE, k)
        assert mine == pytest.approx(value, abs=1e-8)
        assert there.angle == pytest.approx(angle, abs=1e-4)


@pytest.mark.parametrize("reach", [1e-6, 0.03, 0.4, 1.0, 1.6, 2.7, 3.2])
def test_a_flight_is_over_before_and_behind_the_ellipse_in_which_it_lands(orbit, reach):
    """From a tiny ellipse on to one so many rad wide, on the base circle."""
    system, root = chapter_system(), orbit.root
    refused = 0
    with precision(40):
        shooting = exact_shooting(system, root)
        z = [arb(x) for x in root.x]
        machine = shooting.machine(z[-1])
        for k in range(root.count):
            after = (k + 1) % root.count
            if abs(CHAPTER.cam.lift(np.degrees([root.theta[after]]))[0][0] - LOW) > 1e-12:
                continue
            follower, _, whole = flight(orbit, k)
            axes = [1e-12 * np.eye(2) for _ in range(root.count)]
            axes[after][0, 0] = reach
            for side in (-1, 1):
                holds = -side * (follower(whole + side * reach) - LOW) > 0.0
                assert _passes(shooting, machine, z, z, axes, k, side) == holds
                refused += not holds
    assert (refused > 0) == (reach > 2.0)


@pytest.mark.parametrize("half", [0.0, 1e-6, 0.01])
def test_a_box_holds_the_orbit_wherever_its_middle_is(orbit, half, monkeypatch):
    """Each orbit, to 70 digits, lies in a box whose middle Newton's iteration left too early."""
    last = 2 * orbit.root.count

    def orbit_at(share):
        with precision(80):
            guess = [*map(arb, orbit.root.x[:-1]), arb(RPM) + share * arb(half)]
            return exact_shooting(chapter_system(), orbit.root).box(guess, last).middle

    exact = {share: orbit_at(share) for share in (-1, 0, 1)}
    newton = shooting_module._newton

    def stopped_early(equations, guess, free):
        middle, inverse = newton(equations, guess, free)
        return [x if k == last else (x + (-1) ** k * 1e-9).mid() for k, x in enumerate(middle)], (
            inverse
        )

    monkeypatch.setattr(shooting_module, "_newton", stopped_early)
    with precision(40):
        shooting = exact_shooting(chapter_system(), orbit.root)
        box = shooting.box([arb(x) for x in orbit.root.x], last, arb(half))
        for share, orbit_there in exact.items():
            hull = box.orbit_at(share * arb(half))
            assert all(ball.contains(x) for ball, x in zip(hull, orbit_there, strict=True))
            assert box.holds(orbit_there)
        if not half:
            assert max(float(ball.rad()) for ball in box.hull()) < 1e-12
