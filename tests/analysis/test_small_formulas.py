"""Speeds, heights, angles and limits that follow from a machine by one formula."""

from __future__ import annotations

from math import acos, ceil, cos, inf, log2, nextafter, pi, sqrt

import pytest

from camcli.analysis.bracketing import bracket, lowest
from camcli.analysis.differences import since_first_strobe
from camcli.analysis.natural_speed import Basis, natural_speed
from camcli.analysis.surge import Harmonic, Surge, own_frequency
from camcli.analysis.throw import throw
from camcli.cams.eccentric import EccentricCam
from camcli.system import Follower, System

TURN = 2.0 * pi
RPM = 30.0 / pi


def machine(base=0.02, lift=0.01, strobe=0.0, **follower) -> System:
    """c = base + lift (1 - cos theta)/2, on which a follower of 2 kg runs."""
    values = {"mass": 2.0, "stiffness": 0.0, **follower}
    cam = EccentricCam(kind="eccentric", base=base, lift=lift)
    return System.build(Follower(**values), cam, strobe)


def test_the_speed_that_belongs_to_a_machine():
    """k c + m g + F0 + m omega^2 c'' is zero first at the top, where c'' = -lift/2."""
    sprung = natural_speed(machine(stiffness=800.0, gravity=9.81, preload=5.0))
    force = 800.0 * 0.03 + 2.0 * 9.81 + 5.0
    assert sprung.basis is Basis.FIRST_LOSS
    assert sprung.rpm == pytest.approx(RPM * sqrt(force / (2.0 * 0.005)), rel=1e-9)
    below = natural_speed(machine(base=-0.02, stiffness=800.0))  # the spring pulls from the start
    assert (below.basis, below.rpm) == (Basis.NATURAL, pytest.approx(RPM * sqrt(800.0 / 2.0)))
    weightless = natural_speed(machine())
    assert (weightless.basis, weightless.rpm) == (Basis.FALL, 0.0)
    pulled = natural_speed(machine(gravity=-3.0, preload=8.0, damping=0.0, base=0.0))
    assert pulled.basis is Basis.FIRST_LOSS  # 8/2 - 3 presses
    assert pulled.rpm == pytest.approx(RPM * sqrt((8.0 - 6.0) / (2.0 * 0.005)), rel=1e-9)
    lifted = natural_speed(machine(gravity=-5.0, preload=8.0))
    assert (lifted.basis, lifted.rpm) == (Basis.FALL, 0.0)


@pytest.mark.parametrize("rpm", [60.0, 900.0])
def test_how_high_a_cam_throws(rpm):
    """From the top, 0.03 m, with omega lift/2: until the energy is spent, or the damper has it."""
    v = rpm / RPM * 0.005
    for follower, height in (
        ({}, inf),
        ({"gravity": 9.81}, v * v / (2.0 * 9.81)),
        ({"gravity": 4.0, "preload": 10.0}, v * v / (2.0 * 9.0)),
        ({"stiffness": 800.0, "preload": 10.0},
         # k h^2/2 + (k top + F0) h = m v^2/2
         (-(24.0 + 10.0) + sqrt(34.0**2 + 800.0 * 2.0 * v * v)) / 800.0),
        ({"damping": 1000.0}, 2.0 * v / 1000.0),
        ({"damping": 1e-6, "gravity": 9.81}, v * v / (2.0 * 9.81)),
    ):  # fmt: skip
        found = throw(machine(**follower), rpm)
        assert (found.rpm, found.lift) == (rpm, pytest.approx(0.01))
        assert found.height == pytest.approx(height, rel=1e-9)


@pytest.mark.parametrize(
    ("theta", "angle"), [(2.0, 0.0), (2.5, 0.5), (1.5, TURN - 0.5), (0.0, TURN - 2.0)]
)
@pytest.mark.parametrize("period", [0, 3])
def test_the_angle_since_the_first_strobe(theta, angle, period):
    system = machine(strobe=2.0, stiffness=800.0)
    found = since_first_strobe(system, period, theta)
    assert found == pytest.approx(angle + TURN * period, abs=1e-12)


def test_the_frequency_of_a_spring_and_its_strong_harmonics():
    """A wave runs along it and back in 2 sqrt(m/k)."""
    assert own_frequency(40_000.0, 0.1) == pytest.approx(0.5 * sqrt(400_000.0))
    factors = 0.12, nextafter(0.12, 1.0), 0.5, 0.3
    harmonics = tuple(Harmonic(n, 1e-4, 6000.0 / n, f) for n, f in enumerate(factors, 1))
    assert [one.strong for one in harmonics] == [False, True, True, True]
    told = Surge(0.1, 100.0, harmonics)
    for rpm, numbers in ((3000.0, [4, 3, 2]), (2999.0, [4, 3]), (1500.0, [4]), (1499.0, [])):
        assert [one.number for one in told.strong_below(rpm)] == numbers


FUNCTIONS = {  # of speeds from 100 on, each with where it is zero or jumps
    "a line": (lambda x: x - 150.3, 150.3),
    "a cubic": (lambda x: (x - 190.7) ** 3, 190.7),
    "a root": (lambda x: sqrt(abs(x - 113.1)) * (1.0 if x > 113.1 else -1.0), 113.1),
    "steep at one end": (lambda x: -1e-9 if x < 199.999 else 1e9, 199.999),
    "a jump": (lambda x: -1.0 if x < 137.7 else 1.0, 137.7),
    "no number behind": (lambda x: -3.0 if x < 120.2 else inf, 120.2),
    "zero from there on": (lambda x: min(0.0, x - 171.9), 171.9),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_sign_is_bracketed_in_one_step_more_than_bisection(name):
    """To a relative 1e-12: by the secant in far fewer where the function is smooth."""
    f, place = FUNCTIONS[name]
    asked = []

    def counted(x):
        asked.append(x)
        return f(x)

    low, high, f_low, f_high = bracket(counted, 100.0, 200.0, f(100.0), f(200.0))
    assert low < place <= high
    assert high - low <= 1e-12 * high
    assert (f_low, f_high) == (f(low), f(high))
    assert f_low < 0.0 <= f_high
    assert len(asked) <= ceil(log2(100.0 / (1e-12 * high))) + 1
    if name == "a line":
        assert len(asked) <= 10


@pytest.mark.parametrize(
    ("f", "place", "value"),
    [
        (lambda x: cos(x), pi, -1.0),
        (lambda x: cos(2.0 * x) + 0.1 * cos(x), acos(-0.025), -1.00125),
        (lambda x: abs(x - 2.0) if x > 1.0 else inf, 2.0, 0.0),
        (lambda x: x, 0.0, 0.0),
        (lambda x: -x, TURN, -TURN),
        (lambda x: min(1.0, abs(x - 1.0), abs(x - 5.0)), 1.0, 0.0),  # of two alike the first
        (lambda x: -abs(x - pi), 0.0, -pi),  # both ends of a turn are one
        (lambda x: inf if x else 3.0, 0.0, 3.0),
    ],
)  # fmt: skip
def test_the_lowest_place_is_refined(f, place, value):
    found = lowest(f, 0.0, TURN, 40)
    assert found == (pytest.approx(value, abs=1e-9), pytest.approx(place, abs=2e-8))
