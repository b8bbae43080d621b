"""The flow of a flight in balls against the exponential of its matrix, in every regime of damping.

Of d/ds (q, w, 1) = A (q, w, 1) with A = [[0, 1, 0], [-W^2, -2 Z, 1], [0, 0, 0]] the exponential
holds B, B' and P in its upper right corner; its derivative by a constant that A depends on is the
upper right block of the exponential of [[A, A'], [0, A]]. No regime is special there.
"""

from dataclasses import asdict, replace
from fractions import Fraction
from functools import cache
from itertools import product
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_series
from mpmath import mp, mpf

from camcli import check
from camcli.cams.balls import UndecidedError, head, precision, slope
from camcli.exact.machine import BallMachine, BallStretch
from camcli.system import Follower

DIGITS = 60
RPM = 240.0
SPANS = (0.01, 1.7, 13.0)  # rad
REGIMES = {
    "no spring, no damper": (0.0, 0.0),
    "no spring, damped": (0.0, 3.0),
    "no spring, hardly damped": (0.0, 1e-9),
    "no spring, very much damped": (0.0, 1e4),
    "undamped": (1430.0, 0.0),
    "hardly a spring, undamped": (1e-12, 0.0),
    "underdamped": (1430.0, 5.0),
    "just underdamped": (64.0, 15.999999999999998),
    "critical": (64.0, 16.0),
    "just overdamped": (64.0, 16.000000000000004),
    "overdamped": (64.0, 50.0),
    "very much overdamped": (64.0, 1e4),
    "hardly a spring, overdamped": (1e-12, 3.0),
}
PARAMETERS = ("rpm", "mass", "stiffness", "damping")
NO_CAM: list[BallStretch] = []


def follower_of(regime: str) -> Follower:
    stiffness, damping = REGIMES[regime]
    return Follower(1.0, stiffness, damping, 9.81, 0.5, 0.8)


def machine_of(follower: Follower, parameter: str = "rpm", value=RPM) -> BallMachine:
    """With a constant, or the speed, replaced by a ball or a series."""
    if parameter == "rpm":
        return BallMachine(NO_CAM, follower, value)
    return BallMachine(NO_CAM, replace(follower, **{parameter: value}), RPM)


def value_of(follower: Follower, parameter: str) -> float:
    return RPM if parameter == "rpm" else getattr(follower, parameter)


@cache
def expected(follower: Follower, rpm: float, s: float, parameter: str = "rpm") -> list[list[mpf]]:
    """[B, B', P] after s rad of flight and the derivatives of the three by the parameter."""
    with mp.workdps(DIGITS + 30):
        f = {name: mpf(value) for name, value in asdict(follower).items() if value is not None}
        m, k, b, omega = f["mass"], f["stiffness"], f["damping"], mpf(rpm) * mp.pi / 30
        w2, z2 = k / m / omega**2, b / m / omega
        dw2, dz2 = {
            "rpm": (-2 * w2 / rpm, -z2 / rpm),
            "mass": (-w2 / m, -z2 / m),
            "stiffness": (1 / m / omega**2, mpf(0)),
            "damping": (mpf(0), 1 / m / omega),
        }[parameter]
        own = mp.matrix([[0, 1, 0], [-w2, -z2, 1], [0, 0, 0]])
        both = mp.zeros(6)
        for i, j in product(range(3), range(3)):
            both[i, j] = both[i + 3, j + 3] = own[i, j]
        both[1, 3], both[1, 4] = -dw2, -dz2
        power = mp.expm(both * mpf(s))
        places = (0, 1), (1, 1), (0, 2)
        return [[power[i, j + by] for i, j in places] for by in (0, 3)]


def ball_of(number: mpf) -> arb:
    """With the error that the oracle's digits leave."""
    text = mp.nstr(number, 100)
    return arb(text, abs(arb(text)) * arb("1e-80") + arb("1e-80"))


def agrees(ball: arb, number: mpf) -> None:
    """The number lies in the ball, and the ball is small."""
    assert ball.overlaps(ball_of(number)), (ball, number)
    assert ball.rad() < (1 + abs(ball)) * arb("1e-25"), ball


def checkers_machine(follower: Follower, parameter: str | None = None) -> check.Machine:
    """The machine of the checker of certificates: of exact constants, one of which may vary."""
    values = {"rpm": RPM, **{k: v for k, v in asdict(follower).items() if v is not None}}
    constants = {name: Fraction(value) for name, value in values.items()}
    varied = {}
    if parameter is not None:
        varied = {parameter: arb_series([values[parameter], 1], 2)}
        constants[parameter] = None
    return check.Machine(Stub(stretches=[], seat_restitution=Fraction(1)), constants, varied)


def agree(
    machine: BallMachine | check.Machine, follower: Follower, parameter: str | None = None
) -> None:
    """The flights of a machine, and their derivatives by what varies, are the oracle's."""
    for s in SPANS:
        numbers = expected(follower, RPM, s, parameter or "rpm")
        for found, value, by in zip(machine.flow(arb(s)), *numbers, strict=True):
            agrees(head(found), value)
            if parameter is not None:
                agrees(slope(found), by)


@pytest.mark.parametrize("made", [machine_of, checkers_machine])
@pytest.mark.parametrize("regime", REGIMES)
def test_a_flight_is_the_exponential_of_its_matrix(regime, made):
    follower = follower_of(regime)
    with precision(DIGITS):
        agree(made(follower), follower)


@pytest.mark.parametrize("parameter", PARAMETERS)
@pytest.mark.parametrize("regime", REGIMES)
def test_its_derivatives_by_a_constant_are_too(regime, parameter):
    follower = follower_of(regime)
    with precision(DIGITS):
        series = arb_series([value_of(follower, parameter), 1], 2)
        machine = machine_of(follower, parameter, series)
        agree(machine, follower, parameter)


@pytest.mark.parametrize("parameter", PARAMETERS)
@pytest.mark.parametrize("regime", REGIMES)
def test_the_checker_has_their_derivatives_or_says_nothing(regime, parameter):
    """It says nothing where there may be a spring or none."""
    follower = follower_of(regime)
    with precision(DIGITS):
        if regime.startswith("no spring") and parameter == "stiffness":
            with pytest.raises(check.RefusedError, match="whether there is a spring is open"):
                checkers_machine(follower, parameter)
            return
        machine = checkers_machine(follower, parameter)
        agree(machine, follower, parameter)


WIDE = [
    case
    for case in product(REGIMES, PARAMETERS)
    if case != ("no spring, hardly damped", "stiffness")
]


@pytest.mark.parametrize(("regime", "parameter"), WIDE)
def test_a_ball_of_machines_holds_each_of_them(regime, parameter):
    """Also where it holds machines of more than one regime: about critical damping, about zero."""
    follower = follower_of(regime)
    middle, half = value_of(follower, parameter), 1e-7
    with precision(DIGITS):
        series = arb_series([arb(middle, half), 1], 2)
        machine = machine_of(follower, parameter, series)
        for s in SPANS[1:]:
            flow = machine.flow(arb(s))
            for share in (-1.0, 0.3, 1.0):
                at = middle + share * half
                other = follower if parameter == "rpm" else replace(follower, **{parameter: at})
                rpm = at if parameter == "rpm" else RPM
                for found, value, by in zip(flow, *expected(other, rpm, s, parameter), strict=True):
                    assert head(found).overlaps(ball_of(value))
                    assert slope(found).overlaps(ball_of(by))
                    assert head(found).is_finite()
                    assert slope(found).is_finite()


def test_of_springs_about_none_under_a_damper_of_nearly_none_nothing_is_said():
    follower = follower_of("no spring, hardly damped")
    machine = machine_of(follower, "stiffness", arb_series([arb(0.0, 1e-7), 1], 2))
    with pytest.raises(UndecidedError):
        machine.flow(arb(1.7))


def test_speeds_that_read_the_same_move_apart_alike():
    """`Machine.within_last_digit` of a ball without a spring: (q, w) at its ends."""
    follower = Follower(0.01, 0.0, 0.0, 9.81, 0.0, 0.5)
    with precision(DIGITS):
        machine = BallMachine.within_last_digit(NO_CAM, follower, 1225.0)
        drift = machine.drift(arb(0.001), arb(0.002), arb(3.0)).entries()
        ends = [
            BallMachine(NO_CAM, follower, arb(1225.0) + side * machine.width).move(
                arb(0.001), arb(0.002), arb(3.0)
            )
            for side in (-1, 1)
        ]
        for k in range(2):
            assert abs((ends[1][k] - ends[0][k]) / 2 / drift[k] - 1) < 1e-12


@pytest.mark.parametrize("on_seat", [None, 0.0, 0.25])
def test_the_constants_of_a_machine_are_those_of_its_follower(on_seat):
    """Per radian of the cam, at a mass that is not 1 and a speed of 32 rad/s, by hand."""
    follower = Follower(0.5, 64.0, 8.0, 9.75, 2.5, 0.75, on_seat)
    r_seat = 0.75 if on_seat is None else on_seat
    with precision(DIGITS):
        rpm = 960 / arb.pi()
        made = BallMachine(NO_CAM, follower, rpm)
        names = ("mass", "stiffness", "damping", "gravity", "preload", "restitution")
        constants = {name: Fraction(getattr(follower, name)) for name in names}
        stub = Stub(stretches=[], seat_restitution=Fraction(r_seat))
        checked = check.Machine(stub, {**constants, "rpm": None}, {"rpm": rpm})
        for machine in (made, checked):
            found = machine.W2, machine.Z, machine.G, machine.r, machine.r_seat
            expected = 0.125, 0.25, (9.75 + 5.0) / 1024.0, 0.75, r_seat
            for ball, number in zip(found, expected, strict=True):
                assert ball.contains(arb(number))
                assert ball.rad() < 1e-15
        assert abs(made.Z2 - 0.5) < 1e-15
        faster = BallMachine(NO_CAM, follower, 480 / arb.pi(), Fraction(1, 1))
        assert abs(faster.G - made.G) < 1e-15


@pytest.mark.parametrize("scale", [2.0**-20, 1.0, 2.0**20])
@pytest.mark.parametrize("off", [-1.5, -0.5, 0.5, 1.5])
def test_how_near_to_critical_a_damping_is_does_not_depend_on_its_unit(scale, off):
    """b^2 - 4 k m against b^2, on both sides of the limits of 2^-10."""
    damping, mass = 4.0 * scale, 2.0 * scale
    stiffness = 2.0 * scale * (1.0 - off * 2.0**-10)
    follower = Follower(mass, stiffness, damping, 0.0, 0.0, 0.5)
    near, over = abs(off) < 1.0, off > 1.0
    with precision(DIGITS):
        machine, checked = machine_of(follower), checkers_machine(follower)
        assert (machine.near_critical, machine.over) == (near, over)
        assert (checked.near_critical, checked.under) == (near, off < -1.0)
        size = abs(off) * 2.0**-10 / (RPM * arb.pi() / 30) ** 2  # of (b/2m)^2 = 1
        if near:
            assert abs(machine.square - (size if off > 0 else -size)) < 1e-15
            assert abs(checked.square - (size if off > 0 else -size)) < 1e-15
        else:
            assert abs(machine.frequency - size.sqrt()) < 1e-15
            assert abs(checked.f - size.sqrt()) < 1e-15


def test_a_range_of_speeds_is_that_of_the_last_digit():
    """Half a digit to either side, about the given speed, with slopes that hold for all of them."""
    follower = Follower(0.5, 64.0, 8.0, 9.75, 2.5, 0.75)
    rpm = 1024.0  # its doubles are 2^-42 apart
    with precision(DIGITS):
        machine = BallMachine.within_last_digit(NO_CAM, follower, rpm)
        assert machine.width == 2.0**-43
        assert abs(machine.center.W2.rad()) < 1e-40
        for name, power in (("W2", 2), ("Z", 1), ("G", 2)):
            middle = getattr(machine.center, name)
            for share, inside in ((-1.0, True), (1.0, True), (-1.01, False), (1.01, False)):
                there = middle * (rpm / (arb(rpm) + share * arb(machine.width))) ** power
                assert getattr(machine, name).overlaps(there) == inside
                if inside:
                    by_speed = -power * there / (arb(rpm) + share * arb(machine.width))
                    assert slope(getattr(machine.slopes, name)).overlaps(by_speed)
