"""Speeds, heights, angles and limits that follow from a machine by one formula."""

from __future__ import annotations

from fractions import Fraction
from math import acos, atan2, ceil, cos, inf, log2, nextafter, pi, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from camcli.analysis import surge as surge_module
from camcli.analysis.bracketing import bracket, lowest
from camcli.analysis.contact_loss.force import Hertz, polar_curvature
from camcli.analysis.contact_loss.hold import usual_precompression
from camcli.analysis.differences import since_first_strobe
from camcli.analysis.grid import rpm_grid
from camcli.analysis.multipliers import attracts, multipliers
from camcli.analysis.natural_speed import Basis, natural_speed
from camcli.analysis.orbits.same_orbit import (
    close_returns,
    distance,
    distance_to,
    distances,
    same_orbit,
    same_states,
    shortest_period,
    size_of,
)
from camcli.analysis.surge import Harmonic, Surge, own_frequency
from camcli.analysis.throw import throw
from camcli.cams.decimals import decimal, exact, exactly
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import LawCam
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


@pytest.mark.parametrize(("rise", "fall"), [(60.0, 150.0), (150.0, 60.0)])
def test_the_steeper_flank_of_a_cam_throws(rise, fall):
    """A harmonic lift of 1 cm over an angle b has at most c_theta = lift pi/(2 b)."""
    law = "harmonic"
    cam = LawCam(kind="law", base=0.0, lift=0.01, top_dwell_deg=20.0,
                 rise={"start_deg": 10.0, "length_deg": rise, "law": law},
                 fall={"length_deg": fall, "law": law})  # fmt: skip
    system = System.build(Follower(mass=2.0, stiffness=0.0, gravity=9.81), cam)
    v = 60.0 / RPM * 0.01 * pi / (2.0 * min(rise, fall) * pi / 180.0)
    assert throw(system, 60.0).height == pytest.approx(v * v / (2.0 * 9.81), rel=1e-9)


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
        (lambda x: 1e-16 * cos(x / 4.0), TURN, 0.0),  # a tie is one of relative size
        (lambda x: 1e12 * (3.0 - abs(x - pi)) - 1e-4 * x, 0.0, 1e12 * (3.0 - pi)),
    ],
)  # fmt: skip
def test_the_lowest_place_is_refined(f, place, value):
    found = lowest(f, 0.0, TURN, 40)
    assert found == (pytest.approx(value, abs=1e-9), pytest.approx(place, abs=2e-8))


@pytest.mark.parametrize(
    ("large", "small"),
    [(3.0, 0.5), (-3.0, 0.5), (2.0, -0.25), (-1.5, -0.5), (1e12, 1e-12), (-1e12, 1e-12), (0.0, 0.0),
     (1.0, 1.0)],
)  # fmt: skip
def test_multipliers_are_the_roots_of_their_equation(large, small):
    """The larger first, and the smaller one to all digits."""
    found = multipliers(large + small, large * small)
    assert [z.real for z in found] == pytest.approx([large, small], rel=1e-13)
    assert [z.imag for z in found] == [0.0, 0.0]
    assert attracts(large + small, large * small) == (abs(large) < 1.0 > abs(small))


@pytest.mark.parametrize(("real", "imaginary"), [(0.6, 0.7), (-0.9, 0.5), (0.0, 1.0)])
def test_a_complex_pair_has_the_upper_one_first(real, imaginary):
    found = multipliers(2.0 * real, real**2 + imaginary**2)
    wanted = complex(real, imaginary), complex(real, -imaginary)
    assert found == pytest.approx(wanted)
    assert attracts(2.0 * real, real**2 + imaginary**2) == (abs(wanted[0]) < 1.0)


@pytest.mark.parametrize(
    ("trace", "det", "inside"),
    [(1.5, 0.5, False), (-1.5, 0.5, False), (1.4999, 0.5, True), (0.0, 1.0, False),
     (0.0, 0.9999, True), (0.25, -0.75, False), (0.2, -0.75, True)],
)  # fmt: skip
def test_an_orbit_attracts_within_the_triangle_of_jury(trace, det, inside):
    assert attracts(trace, det) == inside


STATES = [(0.1, 2.0), (0.3, -4.0), (0.1, 2.0), (0.3, -4.0)]


def test_distances_of_states_are_relative_to_the_orbit():
    """Each number to its own largest size; 1 where that is zero."""
    assert size_of(STATES) == (0.3, 4.0)
    assert size_of([(0.0, 0.0), (0.0, 5.0)]) == (1.0, 5.0)
    size = (0.5, 10.0)
    assert distance((0.1, 2.0), (0.2, 2.5), size) == pytest.approx(0.2)
    assert distance((0.1, 2.0), (0.11, 7.0), size) == pytest.approx(0.5)
    one, other = np.array(STATES), np.array(STATES[1:] + STATES[:1])
    assert distances(one, other, size).tolist() == pytest.approx([0.6] * 4)
    assert distance_to((0.12, 2.0), STATES) == pytest.approx(0.02 / 0.3)
    assert distance_to((0.3, 4.0), STATES) == pytest.approx(0.2 / 0.3)


def test_where_a_motion_comes_close_to_itself():
    states = np.array([(0.0, 0.0), (1.0, 1.0), (0.1, 0.0), (1.25, 1.0), (0.1, 0.25)])
    first, apart = close_returns(states, 2, (1.0, 1.0), 0.25)
    assert first.tolist() == [0, 1, 2]
    assert apart == pytest.approx([0.1, 0.25, 0.25])
    first, apart = close_returns(states, 2, (1.0, 1.0), 0.2499)
    assert (first.tolist(), apart.tolist()) == ([0], [pytest.approx(0.1)])
    first, _ = close_returns(states, 1, (1.0, 1.0), 0.5)
    assert first.tolist() == []


def test_when_orbits_are_one():
    """The same states in the same order, whatever the turn; symbols and impacts count too."""
    assert shortest_period(STATES) == 2
    assert shortest_period(STATES[:3]) == 3
    assert shortest_period(STATES[:1] * 6) == 1
    assert not same_states(STATES, STATES[1:] + STATES[:1])
    assert not same_states(STATES, STATES[:2])

    def orbit(**changes):
        usual = {"symbols": (1.0, 2.0), "theta": (0.1, 0.2, 0.3), "states": STATES[:2]}
        return SimpleNamespace(**{**usual, **changes})

    assert same_orbit(orbit(), orbit())
    for changes in ({"symbols": (2.0, 1.0)}, {"theta": (0.1, 0.2)}, {"states": STATES[1:3]}):
        assert not same_orbit(orbit(), orbit(**changes))


def test_a_range_has_both_of_its_ends():
    assert rpm_grid(1.0, 2.0, 1) == [1.0]
    assert rpm_grid(0.1, 0.7, 4) == [0.1, pytest.approx(0.3), pytest.approx(0.5), 0.7]
    assert rpm_grid(7.0, 1.0, 3) == [7.0, 4.0, 1.0]


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.5, "0.5"), (-3.0, "-3"), (2.0**-4, "0.0625"), (0.0, "0"),
     (2.0**-100, f"{5**100}e-100"), (-(2.0**-100), f"-{5**100}e-100")],
)  # fmt: skip
def test_a_double_is_written_with_all_its_digits(value, text):
    """With an exponent below 1e-30."""
    assert exact(value) == text
    assert Fraction(exact(value)) == Fraction(value)
    assert Fraction(exactly(arb(value))) == Fraction(value)


def test_small_doubles_have_an_exponent():
    assert "e" not in exact(1.0000001e-30)
    assert "e" in exact(0.9999999e-30)
    assert decimal(Fraction(3, 8)) == "375e-3"
    assert decimal(Fraction(-7)) == "-7"


@pytest.mark.parametrize("mass", [0.06, 0.25])
def test_where_the_harmonics_of_a_cam_meet_a_spring(monkeypatch, mass):
    """Harmonic n of a spring of f Hz is met at 60 f/n rpm; a_n and b_n are at right angles."""
    monkeypatch.setattr(
        surge_module, "fourier", lambda cam, numbers: [(3e-3 / n, -4e-3 / n) for n in numbers]
    )
    found = surge_module.surge(machine(stiffness=800.0), mass)
    hertz = 0.5 * sqrt(800.0 / mass)
    assert (found.mass, found.hertz) == (mass, pytest.approx(hertz))
    assert [one.number for one in found.harmonics] == list(range(1, 41))
    for n, one in enumerate(found.harmonics, 1):
        assert one.amplitude == pytest.approx(5e-3 / n)
        assert one.rpm == pytest.approx(60.0 * hertz / n)
        assert one.factor == pytest.approx(n * 5.0 / 25.4)


@pytest.mark.parametrize(("roller", "ratio"), [(None, 1.0), (None, 1.5), (0.5, 1.0), (0.25, 1.5)])
def test_the_pressure_of_a_line_contact_by_hand(roller, ratio):
    """p = sqrt(F E*/(pi w R)), 1/R the curvatures of cam and face together.

    A flat face touches where the cam is curved by base + c + c''. The centre of a roller goes round
    at R = base + roller + c, and the cam itself lies by the radius of the roller further inside.
    """
    hertz = Hertz(0.02, 1.1e11, 0.3, roller, ratio)
    c, c1, c2 = 0.012, 0.021, -0.0315
    c_lobe, c1_lobe, c2_lobe = c / ratio, c1 / ratio, c2 / ratio
    if roller is None:
        curvature = 1.0 / (0.3 + c_lobe + c2_lobe)
    else:
        away = 0.3 + roller + c_lobe
        pitch = (away**2 + c1_lobe**2) ** 1.5 / (away**2 + 2 * c1_lobe**2 - away * c2_lobe)
        curvature = 1.0 / (pitch - roller) + 1.0 / roller
    pressure = sqrt(450.0 * ratio * 1.1e11 * curvature / (pi * 0.02))
    assert hertz.pressure(450.0, c, c1, c2) == pytest.approx(pressure, rel=1e-12)
    assert hertz.pressure(0.0, c, c1, c2) == hertz.pressure(-1.0, c, c1, -9.0) == 0.0
    assert hertz.pressure(450.0, c, c1, -9.0) == inf  # undercut


def test_the_curvature_of_a_curve_about_an_axis():
    """An ellipse with the axes 3 and 2, at an angle t of its circle."""
    a, b, t = 3.0, 2.0, 0.7
    h = 1e-3

    def radius(angle):
        return a * b / sqrt((b * cos(angle)) ** 2 + (a * sin(angle)) ** 2)

    angle = atan2(b * sin(t), a * cos(t))
    low, here, high = (radius(angle + k * h) for k in (-1, 0, 1))
    curvature = a * b / ((a * sin(t)) ** 2 + (b * cos(t)) ** 2) ** 1.5
    found = polar_curvature(here, (high - low) / (2 * h), (high - 2 * here + low) / h**2)
    assert found == pytest.approx(curvature, rel=1e-4)
    assert polar_curvature(0.0, 0.0, -3.0) == inf


@pytest.mark.parametrize(
    ("preload", "stiffness", "base", "precompression"),
    [
        (6.0, 800.0, 0.02, 6.0 / 800.0),
        (0.0, 800.0, 0.02, 0.005),  # half of the lift of 10 mm
        (6.0, 0.0, 0.02, 0.005),
        (-6.0, 800.0, 0.02, 0.005),
        (0.0, 800.0, -0.03, 0.035),  # and as far as the lowest lift is below zero
    ],
)
def test_how_far_a_new_spring_is_usually_compressed(preload, stiffness, base, precompression):
    system = machine(base=base, preload=preload, stiffness=stiffness)
    assert usual_precompression(system) == pytest.approx(precompression, rel=1e-9)
