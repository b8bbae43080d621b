"""Check the statements of a proof.json of `cam orbits --prove`: python check.py proof.json

This file needs Python 3.11 and python-flint, and nothing of camcli: copy it wherever you like. It
was written from the theorems, which stand in the guide (`cam guide proofs`), not from the program
that finds the proofs: it has equations and derivatives of its own, and knows no kind of cam.

Exit code 0: every statement is confirmed; 1: one is not; 2: the file is no certificate; 3: it
holds no statement, so that nothing is confirmed.

How to read it. Sections 1 to 5 are all that a periodic orbit needs: numbers, the cam, a flight, an
orbit with its box, and the statement. Each section behind them has one more kind of statement,
with its theorem. The last three read the file and say what was found.

Terms. The unknowns z of an orbit are theta_1, v_1, ..., theta_n, v_n, p: the phase of each impact
(rad within the turn), the relative rate at which it leaves the cam (m/rad), and the parameter, a
constant of the machine, or (cam.NAME) a number of the cam. Rates and accelerations are those by
the angle of the cam; the gap is the height q of the follower less that of the cam, c.
"""

import ast
import json
import os
import re
import sys
from collections.abc import Callable
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from itertools import combinations_with_replacement, pairwise, product
from operator import add, mul, sub, truediv
from types import SimpleNamespace
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series, ctx

BITS = 256  # of every ball
BITS_OF_COVER = 64  # of the balls of a cover, whose boxes are wide
ORDERS = (8, 16, 32, 64, 128)  # of the terms by which a step of a varying cam is bounded
TERMS = ORDERS[-1] + 2  # more than any series has
LARGEST_FILE = 400_000_000  # bytes
NEAR_CRITICAL = arb(2) ** -10  # |b^2 - 4 k m| over b^2
ROUNDED_SLOPE = 1e-9  # m/rad: by less the slopes of a fit's pieces differ where they meet
MOST_AT_STROBE = 6  # impacts of one orbit that may lie on either side of the strobe
DIGITS_OF_ANGLE = 7  # of the angle by which a corner of the cam is named, deg
DIGITS_OF_SIZE = 3  # of the size of an ellipse, rounded down
SHOWN = 30  # digits of a number in what is printed
NOTHING = "the file holds no statement: nothing was proved, or nothing that a certificate can have"
NO_STATEMENT = 3  # the exit code for a file in which there is nothing to confirm
CONSTANTS = ("rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution")
POSITIVE = ("rpm", "mass", "stiffness", "damping", "restitution")  # where it is the parameter


class RefusedError(Exception):
    """A statement was not confirmed; the text says why."""


class NoCertificateError(Exception):
    """The file is not of the form that a certificate has; the text says where."""


def need(holds, why):
    """Refuse the statement unless a comparison certainly holds."""
    if not holds:
        raise RefusedError(why)


# -- 1. Numbers. A number is a ball (python-flint's `arb`), so that a comparison is true only where
# it holds for all that the number may be; or a series of two terms, which are the ball of the
# number and the ball of its derivative by one unknown.


def ball_of(x):
    """The ball of a fraction; what is no fraction stays as it is."""
    return arb(x.numerator) / x.denominator if isinstance(x, Fraction) else x


def around(middle, radius):
    """The ball about a point that holds all within a radius."""
    return middle + arb(0, 1) * radius


def sloped(value, slope):
    """The number with this value and this derivative."""
    return arb_series([value, slope], 2)


def value_of(x):
    """The ball of a number, without its derivative."""
    return x[0] if isinstance(x, arb_series) else arb(x)


def slope_of(x):
    """The derivative of a number: zero of one that depends on nothing."""
    return x[1] if isinstance(x, arb_series) else arb(0)


def angle_of(y, x):
    """The angle of the vector (x, y), rad: a ball, or a series where x or y is one.

    The angle's derivative is (x y' - y x')/(x^2 + y^2); its integral lacks the constant term,
    which is the angle of the constant terms.
    """
    constant_term = arb.atan2(value_of(y), value_of(x))
    if not isinstance(x, arb_series) and not isinstance(y, arb_series):
        return constant_term
    no_change = arb_series([0], TERMS)  # added, it makes a series of the one that is a ball
    x = x + no_change
    y = y + no_change
    derivative = (x * y.derivative() - y * x.derivative()) / (x * x + y * y)
    return derivative.integral() + constant_term


def exponential_rest(x, k):
    """E_k(x), the sum of x^j/(j + k)! over all j >= 0, for k = 1 or 2.

    E_1 = (exp x - 1)/x and E_2 = (exp x - 1 - x)/x^2, both regular at x = 0. With Kummer's
    function M, E_k(x) = M(1, k + 1, x)/k!, and M' = M(2, k + 2, x)/(k + 1).
    """
    at = value_of(x)
    value = at.hypgeom_1f1(1, k + 1) / k
    if not isinstance(x, arb_series):
        return value
    denominator = {1: 2, 2: 6}[k]  # k! (k + 1)
    slope = at.hypgeom_1f1(2, k + 2) / denominator * slope_of(x)
    return sloped(value, slope)


def radians(degrees):
    """Degrees to rad."""
    return ball_of(degrees) * arb.pi() / 180


# -- 2. The cam: smooth stretches, each a closed form. The numbers of these are formulas in the
# file, made of the numbers of the cam, one of which may be the parameter.


def hyperbolic(x):
    """sinh(sqrt x)/sqrt x and cosh(sqrt x), both regular at x = 0 and real for x < 0.

    They are F(3/2, x/4) and F(1/2, x/4) with F(a, y) the sum of y^j/(j! a (a + 1) ... (a + j - 1)),
    Bessel's series, and F'(a, y) = F(a + 1, y)/a.
    """
    at = value_of(x) / 4
    half = arb(1) / 2
    quotient = at.hypgeom_0f1(half + 1)
    cosine = at.hypgeom_0f1(half)
    if not isinstance(x, arb_series):
        return quotient, cosine
    slope_of_quotient = at.hypgeom_0f1(half + 2) * slope_of(x) / 6
    return sloped(quotient, slope_of_quotient), sloped(cosine, quotient * slope_of(x) / 2)


class Stretch:
    """The cam between two angles (rad), analytic a little beyond them. With x = theta - center,

    c = sum a_j x^j + A cos k x + B sin k x + kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x),

    a_j in `polynomial`, (A, B, k) in `wave` and (kappa, rho) in `circle`, which may be empty. seat:
    there the follower meets not the cam but its seat, which may have a restitution of its own.
    """

    def __init__(self, start, end, center, polynomial, wave=(), circle=(), seat=False):
        self.start = start
        self.end = end
        self.center = center
        self.seat = seat
        self.polynomial = polynomial
        self.wave = wave
        self.circle = circle

    def derivatives(self, theta, order):
        """[c, c', ...] up to the derivative by theta of `order` (3 at most), at an angle (rad).

        theta may be a ball, for all of whose angles the values hold, or a series.
        """
        x = theta - self.center
        sums = []
        coefficients = list(self.polynomial)
        for _ in range(order + 1):
            total = x * 0
            for coefficient in reversed(coefficients):
                total = total * x + coefficient
            sums.append(total)
            coefficients = [j * coefficients[j] for j in range(1, len(coefficients))]
        if self.wave:
            of_cosine, of_sine, k = self.wave
            sine, cosine = (x * k).sin_cos()
            for j in range(order + 1):
                sums[j] += of_cosine * cosine + of_sine * sine
                # (A cos k x + B sin k x)' = k B cos k x - k A sin k x
                of_cosine, of_sine = k * of_sine, -(k * of_cosine)
        if self.circle:
            for j, derivative in enumerate(on_circle(x, *self.circle)[: order + 1]):
                sums[j] += derivative
        return sums


def on_circle(x, kappa, rho):
    """kappa cos x + sqrt(g), g = rho^2 - kappa^2 sin^2 x, and its first three derivatives.

    They follow from root = sqrt(g): 2 root root' = g', and this derived once and twice more.
    """
    sine, cosine = x.sin_cos()
    double_sine, double_cosine = (2 * x).sin_cos()
    across = kappa * sine
    square = kappa * kappa
    g1 = -square * double_sine
    g2 = -2 * square * double_cosine
    g3 = 4 * square * double_sine
    root = (rho * rho - across * across).sqrt()
    root1 = g1 / (2 * root)
    root2 = (g2 - 2 * root1 * root1) / (2 * root)
    root3 = (g3 - 6 * root1 * root2) / (2 * root)
    return [kappa * cosine + root, root1 - across, root2 - kappa * cosine, root3 + across]


class Cam:
    """A cam: its numbers by name, and the formulas of its stretches, as they are in the file.

    source: the entry `cam` of the file (see CAM in section 13). The first stretch begins at 0, each
    other one where the one before it ends, the last ends at 2 pi. stretches: those of the numbers
    as they are; seat_restitution: of impacts on a seat, None where it is that of the cam.
    """

    def __init__(self, source):
        self.kind = source.kind
        self.numbers = source.numbers
        self.formulas = source.formulas
        self.formulas_of_stretches = source.stretches
        self.seat_restitution = source.seat_restitution
        self.stretches = self.with_numbers({})

    def with_numbers(self, changed):
        """The stretches that have a length, where some numbers, by name, have other values.

        A changed value is a ball or a series. Raises NoCertificateError where a stretch would end
        before it begins, or where they do not fill the turn.
        """
        names = {key: ball_of(x) for key, x in self.numbers.items()}
        names["pi"] = arb.pi()
        names |= changed
        for named_formula in self.formulas:
            names[named_formula.name] = evaluated(named_formula.formula, names)
        stretches = []
        start = arb(0)
        for source in self.formulas_of_stretches:
            end = evaluated(source.end, names)
            center = evaluated(source.center, names)
            polynomial = [evaluated(x, names) for x in source.polynomial]
            wave = [evaluated(x, names) for x in source.wave]
            circle = [evaluated(x, names) for x in source.circle]
            length_of_stretch = value_of(end) - value_of(start)
            complete = len(polynomial) > 0 and len(wave) in (0, 3) and len(circle) in (0, 2)
            forwards = length_of_stretch > 0 or abs(length_of_stretch) < TINY
            if not (complete and forwards):
                raise NoCertificateError("cam: these numbers make no cam")
            if length_of_stretch > 0:
                stretches.append(Stretch(start, end, center, polynomial, wave, circle, source.seat))
            start = end
        if not abs(value_of(start) - 2 * arb.pi()) < TINY:
            raise NoCertificateError("cam: its stretches do not fill one turn")
        return stretches


def evaluated(term, names):
    """The value of a formula: a fraction, or the syntax tree of an expression of named numbers.

    Known are whole numbers, names, + - * /, sqrt(x) and atan2(y, x). Raises NoCertificateError.
    """
    if isinstance(term, Fraction):
        return ball_of(term)
    if isinstance(term, ast.Constant) and type(term.value) is int:
        return arb(term.value)
    if isinstance(term, ast.Name) and term.id in names:
        return names[term.id]
    if isinstance(term, ast.UnaryOp) and isinstance(term.op, ast.USub):
        return -evaluated(term.operand, names)
    if isinstance(term, ast.BinOp) and type(term.op) in OPERATIONS:
        left = evaluated(term.left, names)
        right = evaluated(term.right, names)
        return OPERATIONS[type(term.op)](left, right)
    if isinstance(term, ast.Call) and isinstance(term.func, ast.Name) and not term.keywords:
        values = [evaluated(x, names) for x in term.args]
        if term.func.id == "sqrt" and len(values) == 1:
            return values[0].sqrt()
        if term.func.id == "atan2" and len(values) == 2:
            return angle_of(*values)
    raise NoCertificateError("cam: a formula has what is not known here")


OPERATIONS = {ast.Add: add, ast.Sub: sub, ast.Mult: mul, ast.Div: truediv}


def jumps(stretches, order):
    """Whether the derivative of the cam of this order (0: the cam) may jump between stretches.

    Balls that overlap show no jump, and a wide ball would hide one: it may not be wide either.
    """
    for k, behind in enumerate(stretches):
        before = stretches[k - 1]  # of the first stretch it is the last one of the turn
        at_end = before.derivatives(before.end, order)[order]
        at_start = behind.derivatives(behind.start, order)[order]
        if not (at_end.overlaps(at_start) and abs(at_end - at_start) < TINY):
            return True
    return False


TINY = arb(2) ** (64 - BITS)  # what the roundings of a cam's numbers stay below


# -- 3. A flight: q'' + 2 Z q' + W2 q + G = 0.


class Machine:
    """Cam and follower at one value of each parameter, or at all values of a ball.

    In flight q'' + 2 Z q' + W2 q + G = 0, with Z = b/(2 m omega), W2 = k/(m omega^2) and
    G = (g + F0/m)/omega^2; r is the restitution. These are balls, or series where a parameter is
    one. near_critical: whether the damping is critical, or so near to it that what is divided by
    the root f = sqrt(|W2 - Z^2|) is a wide ball: then square = Z^2 - W2 is known, and no f.
    under: whether it swings.
    """

    def __init__(self, cam, constants, parameters=None):
        """constants: by name, None where they follow from the parameters, by name as well."""
        parameters = parameters or {}
        values = {name.removeprefix("cam."): p for name, p in parameters.items()}
        known = {key: ball_of(values.get(key) if x is None else x) for key, x in constants.items()}
        self.stretches = cam.stretches
        self.r_seat = ball_of(cam.seat_restitution)
        varied = of_cam(parameters)
        if varied:
            self.stretches = cam.with_numbers(varied)
            need(len(self.stretches) == len(cam.stretches), "the cam has other parts there")
            if cam.kind == "oscillator":
                frequency = {**cam.numbers, **varied}["frequency"]
                need(value_of(ball_of(frequency)) > 0, "the frequency is not positive")
                known["rpm"] = ball_of(frequency) * 30 / arb.pi()
        m = known["mass"]
        k = known["stiffness"]
        b = known["damping"]
        self.r = known["restitution"]
        per_radian = 30 / arb.pi() / known["rpm"]  # s in which the cam turns by a radian, 1/omega
        self.W2 = k / m * (per_radian * per_radian)
        self.Z = b / (2 * m) * per_radian
        self.G = (known["gravity"] + known["preload"] / m) * (per_radian * per_radian)
        self.sprung = constants["stiffness"] != 0
        self.damped = constants["damping"] != 0
        need(not self.sprung or value_of(self.W2) > 0, "whether there is a spring is open")
        discriminant = b * b - 4 * (k * m)
        near = NEAR_CRITICAL * value_of(b) * value_of(b)
        self.under = bool(value_of(discriminant) < -near)
        self.near_critical = not (self.under or value_of(discriminant) > near)
        per_force = per_radian / (2 * m)
        if self.near_critical:
            self.square = discriminant * (per_force * per_force)
        else:
            self.f = (-discriminant if self.under else discriminant).sqrt() * per_force

    def flow(self, s):
        """(B, B', P) after s rad: B solves it for G = 0, B(0) = 0, B'(0) = 1; P is its integral.

        Under and over critical damping B is exp(-Z s) times sin(f s)/f and sinh(f s)/f, and
        C = B' + Z B is exp(-Z s) times cos(f s) and cosh(f s). Near it they are exp(-Z s) times
        s sinh(sqrt x)/sqrt x and cosh(sqrt x) with x = (Z^2 - W2) s^2, which may have any sign
        (`hyperbolic`). P = (1 - C - Z B)/W2. Without a spring B = s E_1(x), B' = exp x and
        P = s^2 E_2(x) with x = -2 Z s (`exponential_rest`).
        """
        if self.damped and not self.sprung:
            x = -(2 * (self.Z * s))
            return s * exponential_rest(x, 1), x.exp(), s * s * exponential_rest(x, 2)
        decay = (-(self.Z * s)).exp() if self.damped else 1
        if self.near_critical:
            quotient, cosine = hyperbolic(self.square * (s * s))
            b = decay * s * quotient
            c = decay * cosine
        elif self.under:
            sine, cosine = (self.f * s).sin_cos()
            b = decay * (sine / self.f)
            c = decay * cosine
        else:
            slow = ((self.f - self.Z) * s).exp()
            fast = (-((self.f + self.Z) * s)).exp()
            b = (slow - fast) / (2 * self.f)
            c = (slow + fast) / 2
        zb = self.Z * b
        p = (1 - c - zb) / self.W2 if self.sprung else s * s / 2
        return b, c - zb, p

    def state(self, q, w, s):
        """(q, q', q'') after s rad of flight from the height q (m) and the rate w (m/rad)."""
        b, b1, p = self.flow(s)
        pull = self.G + self.W2 * q
        height = q + w * b - pull * p
        rate = w * b1 - pull * b
        return height, rate, self.acceleration(height, rate)

    def restitution(self, stretch):
        """That of an impact on a stretch: on the seat its own, where the file has one."""
        return self.r_seat if stretch.seat and self.r_seat is not None else self.r

    def acceleration(self, q, w):
        """q'' in flight at a height q (m) with the rate w (m/rad)."""
        return -(self.G + self.W2 * q + 2 * (self.Z * w))


def of_cam(parameters):
    """Those parameters, by name, that are numbers of the cam, by the names that they have there."""
    prefix = "cam."
    return {key.removeprefix(prefix): p for key, p in parameters.items() if key.startswith(prefix)}


# -- 4. An orbit: its equations, the box that holds it, and the gap in its flights.


class FlightEnd(NamedTuple):
    """A flight at the phase where it ends: the gap, and its derivatives by the cam's angle.

    The slopes of gap and rate are those by phase (theta) and rate (v) of the impact it begins with.
    """

    gap: Any  # m
    rate: Any  # m/rad, of the gap
    acceleration: Any  # m/rad^2, of the gap
    gap_by_theta: Any
    gap_by_v: Any
    rate_by_theta: Any
    rate_by_v: Any
    r: Any  # restitution of an impact there


class ImpactSlopes(NamedTuple):
    """How a change (dtheta, dv) of an impact moves a later one: a matrix."""

    theta_by_theta: Any
    theta_by_v: Any
    v_by_theta: Any
    v_by_v: Any

    def after(self, first):
        """The map that does `first` and then this one: the product of the matrices."""
        return ImpactSlopes(
            self.theta_by_theta * first.theta_by_theta + self.theta_by_v * first.v_by_theta,
            self.theta_by_theta * first.theta_by_v + self.theta_by_v * first.v_by_v,
            self.v_by_theta * first.theta_by_theta + self.v_by_v * first.v_by_theta,
            self.v_by_theta * first.theta_by_v + self.v_by_v * first.v_by_v,
        )

    def matrix(self):
        """The same as a matrix of balls."""
        return arb_mat([[self.theta_by_theta, self.theta_by_v], [self.v_by_theta, self.v_by_v]])


class PartOfFlight(NamedTuple):
    """A part of a flight above one stretch of the cam, between two phases.

    start, end: rad, counted on from the turn of the impact that the flight begins with; offset: rad
    to be taken off for phases within the turn of the stretch; passage: number of the passage.
    """

    start: Any
    end: Any
    stretch: Stretch
    offset: Any
    passage: int


class Orbit:
    """The orbits with impacts at certain places (stretch and turn), in so many turns.

    parameters: the names of one, or of two; then the orbits are those to which an event happens.
    """

    def __init__(self, cam, constants, parameters, places, turns, event=None):
        self.cam = cam
        self.constants = constants
        self.parameters = parameters
        self.places = places
        self.turns = turns
        self.n = len(places)
        self.event = event
        # a graze has one unknown more: rad of flight from its impact to where gap and slope are 0
        self.grazes = event is not None and event.event == "grazing"
        unknowns = 2 * self.n + len(parameters) + self.grazes
        self.equation_count = unknowns - 1
        need(self.n > 0, "an orbit without impacts is not checked here")
        count = len(cam.stretches)
        need(all(place.stretch < count for place in places), "the cam has no such stretch")
        # a period begins at the strobe, so that it may end a turn later than at the angle zero
        need(all(place.turn <= turns for place in places), "an impact lies beyond the period")
        possible(constants, left_open(cam, constants, parameters))

    def machine(self, *values):
        """The machine at a value of each parameter, which has to be possible."""
        parameters = dict(zip(self.parameters, values, strict=True))
        for key, p in parameters.items():
            name = key.removeprefix("cam.")
            need(value_of(p) > 0 or name not in POSITIVE, "the parameter is no such constant")
            need(value_of(p) <= 1 or name != "restitution", "the restitution exceeds 1")
        return Machine(self.cam, self.constants, parameters)

    def values(self, z):
        """Those of the parameters among the unknowns z."""
        return z[2 * self.n : 2 * self.n + len(self.parameters)]

    def at(self, z):
        """The machine of the unknowns z."""
        return self.machine(*self.values(z))

    def turned(self, k):
        """The turns between impact k and the next one, rad."""
        after = (k + 1) % self.n
        turns = self.places[after].turn - self.places[k].turn
        return 2 * arb.pi() * (turns + (self.turns if after == 0 else 0))

    def flight(self, machine, z, k, end=None):
        """Where flight k ends above the stretch of its next impact, as a FlightEnd.

        end: the phase within the turn at which it ends, that of the next impact if none is given.
        Moved with its impact by dtheta, a flight starts v dtheta lower than it would go on, and
        (c'' - q'') dtheta + dv faster; a start higher by dq and faster by dw moves the end by
        (1 - W2 P) dq + B dw, and its rate by -W2 B dq + B' dw.
        """
        after = (k + 1) % self.n
        end = z[2 * after] if end is None else end
        theta = z[2 * k]
        v = z[2 * k + 1]
        c, c1, c2 = machine.stretches[self.places[k].stretch].derivatives(theta, 2)
        landing = machine.stretches[self.places[after].stretch]
        end_c, end_c1, end_c2 = landing.derivatives(end, 2)
        s = end - theta + self.turned(k)
        q, w, acceleration = machine.state(c, c1 + v, s)
        b, b1, p = machine.flow(s)
        faster = c2 - machine.acceleration(c, c1 + v)
        return FlightEnd(
            gap=q - end_c,
            rate=w - end_c1,
            acceleration=acceleration - end_c2,
            gap_by_theta=faster * b - v * (1 - machine.W2 * p),
            gap_by_v=b,
            rate_by_theta=faster * b1 + v * (machine.W2 * b),
            rate_by_v=b1,
            r=machine.restitution(landing),
        )

    def equations(self, z, with_slopes):
        """(E, E'): the equations' values, and their derivatives by all unknowns, as matrices.

        Flight k gives E1, the gap where it ends, and E2 = r rate + v of the impact there; an event
        gives its own. E' is None where it is not asked for. The derivatives by theta and v are
        those of FlightEnd; those by each unknown behind them are taken by series along it.
        """
        values = []
        rows = []
        behind_impacts = range(2 * self.n, len(z))
        points = [direction(z, j) for j in behind_impacts] if with_slopes else [z]
        machines = [self.at(point) for point in points]
        for k in range(self.n):
            flights = [self.flight(machine, z, k) for machine in machines]
            flight = flights[0]  # its values are those of all of them
            theta = 2 * ((k + 1) % self.n)  # index in z of the next impact's phase
            v = theta + 1
            bounces = [one.r * one.rate + z[v] for one in flights]
            values += [[value_of(flight.gap)], [value_of(bounces[0])]]
            r = value_of(flight.r)
            by_gap = [arb(0)] * (2 * self.n)
            by_gap[2 * k] += value_of(flight.gap_by_theta)
            by_gap[2 * k + 1] += value_of(flight.gap_by_v)
            by_gap[theta] += value_of(flight.rate)
            by_bounce = [arb(0)] * (2 * self.n)
            by_bounce[2 * k] += r * value_of(flight.rate_by_theta)
            by_bounce[2 * k + 1] += r * value_of(flight.rate_by_v)
            by_bounce[theta] += r * value_of(flight.acceleration)
            by_bounce[v] += 1
            rows.append([*by_gap, *(slope_of(one.gap) for one in flights)])
            rows.append([*by_bounce, *(slope_of(bounce) for bounce in bounces)])
        if self.event is not None:
            function = zero_at(self, self.event)
            values += [[value_of(x)] for x in function(z)]
            if with_slopes:
                columns = [function(direction(z, j)) for j in range(len(z))]
                rows += [[slope_of(x) for x in row] for row in zip(*columns, strict=True)]
        return arb_mat(values), arb_mat(rows) if with_slopes else None

    def trace_det(self, z, times_rates=False):
        """(trace, determinant, scale) of the map of (theta, v) over one period.

        It is the product of one matrix a flight (`impact_map`). times_rates: none of these is
        divided by the rate at which its flight ends, so that all stays finite where one is zero;
        trace comes times `scale`, the product of these rates. Otherwise scale is 1.
        """
        machine = self.at(z)
        scale = arb(1)
        whole = ImpactSlopes(1, 0, 0, 1)
        det = (-(4 * arb.pi() * self.turns * machine.Z)).exp()
        for k in range(self.n):
            flight = self.flight(machine, z, k)
            whole = impact_map(flight, times_rates).after(whole)
            if times_rates:
                scale = scale * flight.rate
            det = det * flight.r * flight.r
        return whole.theta_by_theta + whole.v_by_v, det, scale

    def krawczyk(self, box):
        """Show that the box holds exactly one orbit for each eta; sets its hull and derivatives.

        A box holds the points z = middle + tangent eta + e, |eta| <= half and |e| <= error; the
        unknown `fixed` has the tangent 1 and the error 0, so that eta is how far it differs from
        its middle. With Y near the inverse of E' by the free unknowns, e is mapped by an orbit's
        equations to -Y E(middle) + (1 - Y E') e - Y E' tangent eta, which has to lie in the box.
        Sets, for each unknown: reach, the ball of its error; center, a ball of it in the orbit at
        eta = 0; hull, a ball of it in all orbits; slope, a ball of its derivative by eta.
        """
        size = self.equation_count
        fixed = box.fixed
        check_form(box, size)
        free = [k for k in range(size + 1) if k != fixed]
        eta = around(0, box.half)
        box.reach = [around(0, e) for e in box.error]
        points = zip(box.middle, box.tangent, box.reach, strict=True)
        value, _ = self.equations(box.middle, with_slopes=False)
        _, slopes = self.equations([m + t * eta + e for m, t, e in points], with_slopes=True)
        y = arb_mat(box.inverse)
        by_free = y * arb_mat([[slopes[i, k] for k in free] for i in range(size)])
        along = y * (slopes * arb_mat([[t] for t in box.tangent])) * eta
        unit = identity(size)
        off = arb_mat([[box.reach[k]] for k in free])
        image = (unit - by_free) * off - y * value - along
        for _ in range(3):  # of the orbit at eta = 0
            off = (unit - by_free) * off - y * value
        box.center = list(box.middle)
        box.hull = list(box.middle)
        for row, k in enumerate(free):
            inside = box.reach[k].contains_interior(image[row, 0])
            need(inside, "no box was shown to hold exactly one orbit")
            box.center[k] += off[row, 0]
            box.hull[k] += image[row, 0]
        box.hull = [z + t * eta for z, t in zip(box.hull, box.tangent, strict=True)]
        by_fixed = y * arb_mat([[slopes[i, fixed]] for i in range(size)])
        try:
            slope = by_free.solve(by_fixed)
        except ZeroDivisionError:
            raise RefusedError("the slopes of a branch are not enclosed") from None
        box.slope = [arb(1)] * (size + 1)
        for row, k in enumerate(free):
            box.slope[k] = -slope[row, 0]
        without_steps(self, box)

    def motion(self, hull, flights, corner=None):
        """Show that every orbit in a hull is a motion; the impact `corner` may leave its stretch.

        hull: a ball for each unknown; flights: as the file divides them, one for each impact.
        """
        need(len(flights) == self.n, "not every impact has its flight")
        stretches = self.at(hull).stretches
        for k, place in enumerate(self.places):
            theta = hull[2 * k]
            v = hull[2 * k + 1]
            stretch = stretches[place.stretch]
            inside = k == corner or (stretch.start < theta and theta < stretch.end)
            need(inside, f"impact {k + 1} may lie outside its stretch of the cam")
            need(v > 0, f"impact {k + 1} may not bounce")
            self.clear(hull, k, flights[k])

    def clear(self, hull, k, flight, lifts=False):
        """Show that the gap is above zero in flight k: it rises first, and falls at last.

        On a part with the middle x and h = theta - x the gap is gap(x) + h (gap'(x) + h gap''/2),
        and its slope is gap'(x) + h gap'', with gap'' taken over all of the part. lifts: the flight
        begins without a rate, so that on its first part the slope of the gap rises. So it does on
        the part with a graze, where gap and slope are zero: elsewhere the gap is above zero.
        """
        machine = self.at(hull)
        after = (k + 1) % self.n
        theta = hull[2 * k]
        lands = hull[2 * after] + self.turned(k)
        need(lands > theta, f"flight {k + 1} ends before it begins")
        parts = self.divided(machine, k, flight.passages, theta, lands)
        first_not_rising = flight.rise
        first_falling = len(parts) - flight.fall
        well = 0 < first_not_rising <= first_falling < len(parts)
        need(well, f"flight {k + 1} does not rise first and fall last")
        c, c1 = machine.stretches[self.places[k].stretch].derivatives(theta, 1)
        w = c1 + hull[2 * k + 1]
        touch = theta + hull[-1] if self.grazes and k == self.event.impact else None
        gains = []  # how much higher the gap is at the end of each part than at its start
        for m, part in enumerate(parts):
            phase = part.start.union(part.end)
            x = phase.mid()
            h = phase - x
            q, q1, _ = machine.state(c, w, x - theta)
            lift, lift1 = part.stretch.derivatives(x - part.offset, 1)
            bend = machine.state(c, w, phase - theta)[2]
            bend -= part.stretch.derivatives(phase - part.offset, 2)[2]
            slope = q1 - lift1 + h * bend
            gains.append(slope * (part.end - part.start))
            if m == 0 and lifts:
                holds = bend > 0
            elif m < first_not_rising:
                holds = slope > 0
            elif m >= first_falling:
                holds = slope < 0
            elif touch is not None and part.start < touch and touch < part.end:
                passage = flight.passages[part.passage]
                touched = self.event.touch
                same_place = (passage.stretch, passage.turn) == (touched.stretch, touched.turn)
                holds = same_place and bend > 0
            else:
                holds = q - lift + h * (q1 - lift1 + h * bend / 2) > 0
            need(holds, f"flight {k + 1} may meet the cam on its way")
        if self.cam.kind == "pieces":
            pairs = list(zip(parts, gains, strict=True))
            above_edges(k, pairs[:first_not_rising], 1)
            above_edges(k, pairs[first_falling:][::-1], -1)

    def divided(self, machine, k, passages, theta, lands):
        """The parts of flight k, one behind the other, as a list of PartOfFlight.

        A flight passes the stretches one after the other, and each passage is cut into parts.
        theta, lands: phases at which it begins and ends, rad, counted on from impact k's turn.
        """
        count = len(machine.stretches)
        after = (k + 1) % self.n
        need(all(one.stretch < count for one in passages), "the cam has no such stretch")
        passed = [one.stretch + count * one.turn for one in passages]  # counted on over the turns
        here = self.places[k]
        there = self.places[after]
        first = here.stretch + count * here.turn
        last = there.stretch + count * (there.turn + (self.turns if after == 0 else 0))
        need(
            bool(passed)
            and passed[0] == first
            and passed[-1] == last
            and all(b == a + 1 for a, b in pairwise(passed)),
            f"flight {k + 1} does not pass stretch after stretch from impact to impact",
        )
        parts = []
        for i, passage in enumerate(passages):
            stretch = machine.stretches[passage.stretch]
            offset = 2 * arb.pi() * (passage.turn - passages[0].turn)
            start = theta if i == 0 else stretch.start + offset
            end = lands if i == len(passages) - 1 else stretch.end + offset
            points = [start, *(cut + offset for cut in passage.cuts), end]
            parts += [PartOfFlight(a, b, stretch, offset, i) for a, b in pairwise(points)]
        return parts

    def along(self, box, function):
        """(value, slope) of each number that a function of z returns, along the branch of a box.

        value: at the orbit in the middle, where eta = 0; slope: its derivative by eta, a ball that
        holds it on all of the box.
        """
        on_branch = [sloped(z, by_eta) for z, by_eta in zip(box.hull, box.slope, strict=True)]
        on_box = function(on_branch)
        in_middle = function(box.center)
        return [(value_of(a), slope_of(b)) for a, b in zip(in_middle, on_box, strict=True)]

    def multipliers(self, box):
        """(trace, det) of the map of a period, balls that hold those of all orbits of a box."""
        eta = around(0, box.half)
        trace, det, _ = [value + slope * eta for value, slope in self.along(box, self.trace_det)]
        return [trace, det]

    def steady(self, box, stable):
        """Show that both multipliers lie inside the unit circle, or one outside: Jury."""
        trace, det = self.multipliers(box)
        if stable:
            need(det < 1 and abs(trace) < 1 + det, "a multiplier may lie outside the unit circle")
        else:
            need(det > 1 or abs(trace) > 1 + det, "both multipliers may lie inside the unit circle")


def direction(z, j):
    """The point z as series along its entry j."""
    return [sloped(x, int(i == j)) for i, x in enumerate(z)]


def impact_map(flight, times_rate=False):
    """How (dtheta, dv) of an impact moves those of the next, from the FlightEnd between them.

    The gap at the end stays zero, and v = -r rate. times_rate: all of it times the rate at which
    the flight ends, so that nothing is divided by that.
    """
    divisor = 1 if times_rate else flight.rate
    factor = flight.rate if times_rate else 1
    theta_by_theta = -(flight.gap_by_theta / divisor)
    theta_by_v = -(flight.gap_by_v / divisor)
    return ImpactSlopes(
        theta_by_theta,
        theta_by_v,
        -(flight.r * (flight.rate_by_theta * factor + flight.acceleration * theta_by_theta)),
        -(flight.r * (flight.rate_by_v * factor + flight.acceleration * theta_by_v)),
    )


def identity(size):
    """The matrix with ones on its diagonal."""
    return arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])


def check_form(box, size):
    """Show that the lists of a box fit `size` equations, and that it leans along its unknown."""
    lengths = {len(x) for x in (box.middle, box.tangent, box.error)}
    complete = lengths == {size + 1} and box.fixed <= size
    need(complete, "a box has not one entry for each unknown")
    shape = [len(row) for row in box.inverse]
    need(shape == [size] * size, "a matrix has not one row and column for each free unknown")
    need(box.half >= 0 and all(e >= 0 for e in box.error), "a box has a negative width")
    leans = box.tangent[box.fixed] == 1 and box.error[box.fixed] == 0
    need(leans, "a box does not lean along its unknown")


def possible(constants, missing):
    """Show that the constants are those of a machine, all but the missing ones.

    constants: by name, None where they are left open; missing: the names that have to be so.
    """
    left_out = {key for key, value in constants.items() if value is None}
    need(left_out == set(missing), "exactly the parameter has to be left open")
    known = {key: value for key, value in constants.items() if value is not None}
    need(all(known.get(key, 1) > 0 for key in ("rpm", "mass")), "speed or mass is not positive")
    negative = any(known.get(key, 0) < 0 for key in ("stiffness", "damping"))
    need(not negative, "a constant is negative")
    need(0 < known.get("restitution", 1) <= 1, "the restitution lies outside 0 to 1")


# -- 5. The statement `orbit`: for every value of the parameter from `low` to `high` the box holds
# exactly one orbit, which is a motion, has the label, and is stable or unstable.


def check_orbit(cam, statement):
    """The only orbit in the box is a motion, and is stable or unstable."""
    orbit = only_one(cam, statement)
    orbit.motion(statement.box.hull, statement.box.flights)
    orbit.steady(statement.box, statement.stable)
    named(statement, statement.box.hull)


def orbit_of(cam, statement):
    """The equations of the orbits that a statement is about, as an Orbit."""
    need(0 <= statement.strobe < 360, "the strobe lies outside the turn")
    parameters = [statement.parameter]
    event = None
    if statement.kind == "curve":
        parameters.append(statement.second)
        event = statement.event
    return Orbit(cam, statement.constants, parameters, statement.impacts, statement.turns, event)


def only_one(cam, statement):
    """The orbit of a statement, shown to be one for every value of the parameter in its range."""
    orbit = orbit_of(cam, statement)
    box = statement.box
    need(box.fixed == 2 * orbit.n, "the box of an orbit leans along the parameter")
    orbit.krawczyk(box)
    need(statement.low <= statement.high, "its range is empty")
    low = ball_of(statement.low)
    high = ball_of(statement.high)
    middle = box.middle[-1]
    covered = middle - box.half <= low and high <= middle + box.half
    need(covered, "its box does not cover the range of the parameter")
    return orbit


def labels(statement, hull):
    """The labels P(turns; impacts of each turn) that the orbits in a hull may have, sorted.

    A turn is counted from strobe to strobe. An impact that may lie on either side of the strobe is
    counted on both. Of the rotations of a label the largest is taken.
    """
    strobe = radians(statement.strobe)
    phases = hull[: 2 * len(statement.impacts) : 2]
    sides = []  # for each impact: whether it lies before the strobe, or both answers
    for theta in phases:
        if theta < strobe:
            sides.append([True])
        elif theta >= strobe:
            sides.append([False])
        else:
            sides.append([True, False])
    undecided = sum(len(answers) > 1 for answers in sides)
    need(undecided <= MOST_AT_STROBE, "impacts may lie on either side of the strobe")
    turns = statement.turns
    names = set()
    for answers in product(*sides):
        counts = [0] * turns
        for impact, before_strobe in zip(statement.impacts, answers, strict=True):
            turn = impact.turn - 1 if before_strobe else impact.turn
            counts[turn % turns] += 1
        largest = max(counts[k:] + counts[:k] for k in range(turns))
        names.add(f"P({turns};{':'.join(map(str, largest))})")
    return sorted(names)


def counted(statement, hull):
    """Show that the statement's label is that of all orbits in a hull."""
    names = labels(statement, hull)
    need(names == [statement.label], f"its label is {' or '.join(names)}")


def named(statement, hull):
    """Show that the label is that of all orbits in a hull, and that none has a shorter period.

    An orbit with a shorter period of `turns` turns would have the same phase and rate again, so
    many impacts later: there is none where one of these pairs lies apart.
    """
    counted(statement, hull)
    n = len(statement.impacts)
    size = 2 * n  # of the phases and rates together
    for turns in range(1, statement.turns):
        if statement.turns % turns == 0 and n * turns % statement.turns == 0:
            step = 2 * (n * turns // statement.turns)  # in the unknowns, to one period later
            apart = any(not hull[a].overlaps(hull[(a + step) % size]) for a in range(size))
            need(apart, f"it may be an orbit of {amount(turns, 'turn')} gone through several times")


# -- 6. Of these, where the parameter is a number of the cam, where the cam is a fit, whose
# polynomials meet but for roundings, and where it has a seat.


def left_open(cam, constants, parameters):
    """The names of the constants that follow from the parameters, and are left open in the file.

    A parameter that is a constant is left open itself; one that is a number of the cam leaves none
    open, but for an oscillator. That turns as fast as its force, and its mass, stiffness and
    damping are those of its cam too; they stand in both where they are no parameter.
    """
    names = {name.removeprefix("cam.") for name in parameters}
    need(len(names) == len(parameters), "its parameters are one number")
    numbers = set(of_cam(dict.fromkeys(parameters)))
    if not numbers:
        return names
    need(numbers <= set(cam.numbers), "the cam has no such number")
    exactly_known = all(isinstance(x, Fraction) for x in cam.numbers.values())
    has_seat = any(stretch.seat for stretch in cam.stretches)
    can_vary = exactly_known and not has_seat
    need(can_vary, "the ends of the cam's stretches may vary with its numbers")
    if cam.kind != "oscillator":
        return names - numbers
    need("rpm" not in names, "an oscillator turns as fast as its force")
    shared = {"mass", "stiffness", "damping"}
    for key in shared - numbers:
        same = constants[key] == cam.numbers[key]
        need(same, "the oscillator has other constants than its cam")
    return {"rpm", *(names - numbers), *(numbers & shared)}


def without_steps(orbit, box):
    """Show that the cam has no step of TINY or more at any value that its number has in a box.

    By Taylor's theorem about the middle p0 of the number's ball p, |p - p0| <= half:
    |step(p)| <= sum of |a_j| half^j, with the terms a_j at p0 below some order, and the term of
    that order taken over all of p. The orders of ORDERS are tried. A cam that is one wave has no
    step whatever its numbers are. Raises RefusedError where that does not show it.
    """
    varied = of_cam(dict(zip(orbit.parameters, orbit.values(box.hull), strict=True)))
    if not varied or is_one_wave(orbit.cam.with_numbers(varied)):
        return
    need(len(varied) == 1, "whether this cam has a step is not known over two of its numbers")
    ((name, p),) = varied.items()
    half = arb(p.rad())
    for order in ORDERS:
        about_middle = {name: arb_series([p.mid(), 1], order)}
        over_ball = {name: arb_series([p, 1], order + 1)}
        at_middle = steps(orbit.cam.with_numbers(about_middle), order)
        everywhere = steps(orbit.cam.with_numbers(over_ball), order + 1)
        bounds = []
        for terms, terms_over_ball in zip(at_middle, everywhere, strict=False):
            taylor = [*terms, terms_over_ball[order]]
            bounds.append(sum((abs(a) * half**j for j, a in enumerate(taylor)), arb(0)))
        same_stretches = len(at_middle) == len(everywhere)
        if same_stretches and all(bound < TINY for bound in bounds):
            return
    raise RefusedError("the cam may have a step")


def is_one_wave(stretches):
    """Whether the cam is A cos x + B sin x beside a constant, so that a turn leads back to it."""
    whole = stretches[0]
    if len(stretches) > 1 or whole.circle or len(whole.polynomial) > 1 or not whole.wave:
        return False
    a, b, k = whole.wave
    missing_to_turn = abs(whole.end - whole.start - 2 * arb.pi())
    return k == 1 and (abs(a) + abs(b)) * missing_to_turn < TINY


def steps(stretches, order):
    """How much higher each stretch begins than the one before it ends: `order` terms of a series.

    The series is in the number of the cam that varies.
    """
    terms_of_steps = []
    for k, behind in enumerate(stretches):
        before = stretches[k - 1]
        step = behind.derivatives(behind.start, 0)[0] - before.derivatives(before.end, 0)[0]
        series = arb_series([step], order) if isinstance(step, arb) else step
        terms_of_steps.append([series[j] for j in range(order)])
    return terms_of_steps


def above_edges(k, parts, sign):
    """Show that the gap of flight k stays above zero where stretches meet but for roundings.

    The pieces of a fitted cam may have a step at such an edge, by which the gap changes.
    parts: (PartOfFlight, how much the gap grows on it) of those on which the gap rises, from the
    start on (sign 1); or of those on which it falls, from the end of the flight backwards (-1).
    """
    gap = arb(0)
    for (part, gain), (following, _) in pairwise(parts):
        gap += sign * gain
        if part.passage != following.passage:
            if sign > 0:
                at_edge = part.stretch.end
                beyond_edge = following.stretch.start
            else:
                at_edge = part.stretch.start
                beyond_edge = following.stretch.end
            gap += part.stretch.derivatives(at_edge, 0)[0]
            gap -= following.stretch.derivatives(beyond_edge, 0)[0]
            need(gap > 0, f"flight {k + 1} may meet an edge of the cam")


def above_seat(stretches):
    """Whether the seat is level, and the cam nowhere below it by more than the roundings.

    A follower with lash rests on the higher one of cam and seat. The stretches are cut in half
    until each part is shown to lie above the seat; False where more parts would be needed.
    """
    seats = [stretch for stretch in stretches if stretch.seat]
    level = all(not one.wave and not one.circle and len(one.polynomial) == 1 for one in seats)
    if not seats or not level:
        return level
    height = seats[0].polynomial[0]
    parts = [(stretch, stretch.start, stretch.end, 0) for stretch in stretches]
    while parts:
        stretch, start, end, depth = parts.pop()
        c = stretch.derivatives(start.union(end), 0)[0]
        too_high = stretch.seat and c > height + TINY  # for a seat
        if c > height - TINY and not too_high:
            continue
        if not stretch.seat and rises_from(stretch, start, end, height - TINY):
            continue
        if depth == BITS:
            return False
        middle = ((start + end) / 2).mid()
        parts += [(stretch, start, middle, depth + 1), (stretch, middle, end, depth + 1)]
        if len(parts) > BITS or c < height - TINY:
            return False
    return True


def rises_from(stretch, start, end, height):
    """Whether the cam is above a height between two angles, since it rises from one of them.

    By Taylor's theorem: a derivative is not negative between them, and all terms before it keep
    the cam above the height. Without lash the cam leaves its seat so, with slope zero.
    """
    last = 3 if stretch.circle else 4  # order of the derivatives that a stretch has in closed form
    between = stretch.derivatives(start.union(end), last)
    for at, way, direction_of_way in ((start, end - start, 1), (end, start - end, -1)):
        terms = stretch.derivatives(at, last)
        total = arb(0)  # of the terms before `order`, anywhere on the way
        factorial = 1
        for order in range(last + 1):
            remainder_sign = direction_of_way**order  # of way^order
            if order > 0 and remainder_sign * between[order] >= 0 and total > height:
                return True
            factorial *= max(order, 1)
            total += terms[order] * arb(0).union(way) ** order / factorial
    return False


# -- 7. The statement `attractor`: every motion with an impact in an ellipse about one of the
# orbit's tends to the orbit. The ellipse of impact k holds (theta, v) + M u, |u| <= 1, with
# M = [[a, b], [c, d]]. From each of its points the cam is met next within the next ellipse: the
# gap is above zero where that begins and below where it ends, and u is shorter there.


def check_attractor(cam, statement):
    """The ellipses of an orbit are mapped into one another, and shrink."""
    orbit = only_one(cam, statement)
    box = statement.box
    axes = statement.axes
    complete = len(axes) == orbit.n and all(len(one) == 4 for one in axes)
    need(complete, "not every impact has an ellipse")
    reaches = [(length(a, b), length(c, d)) for a, b, c, d in axes]  # in theta and in v
    wide = list(box.hull)
    for k, (in_theta, in_v) in enumerate(reaches):
        wide[2 * k] += around(0, in_theta)
        wide[2 * k + 1] += around(0, in_v)
    orbit.motion(wide, box.flights)
    named(statement, box.hull)
    machine = orbit.at(box.hull)
    for k in range(orbit.n):
        after = (k + 1) % orbit.n
        check_landings(orbit, machine, box.hull, wide, k, axes[k], reaches[after][0])
        need(area(axes[after]) > 0 or area(axes[after]) < 0, "an ellipse is flat")
        slopes = impact_map(orbit.flight(machine, wide, k)).matrix()
        step = inverse(axes[after]) * slopes * matrix(axes[k])  # in units of both ellipses
        left = identity(2) - step.transpose() * step
        positive_definite = left[0, 0] > 0 and left.det() > 0
        need(positive_definite, f"flight {k + 1} may not come nearer to the orbit")


def check_landings(orbit, machine, hull, wide, k, axes, reach):
    """Show that all motions from ellipse k land where the next ellipse lies.

    At a phase `reach` before and behind the orbit's own landing the gap of the orbit is changed by
    a start off by M u, |u| <= 1, by at most the length of M^T (gap_by_theta, gap_by_v).
    hull: unknowns of the orbit; wide: of all motions in the ellipses; axes: M of ellipse k.
    """
    a, b, c, d = axes
    after = (k + 1) % orbit.n
    for side in (-1, 1):
        end = hull[2 * after] + side * reach
        gap = orbit.flight(machine, hull, k, end).gap
        flight = orbit.flight(machine, wide, k, end)
        spread = length(
            flight.gap_by_theta * a + flight.gap_by_v * c,
            flight.gap_by_theta * b + flight.gap_by_v * d,
        )
        need(-side * gap > spread, f"flight {k + 1} may land outside the next ellipse")


def length(x, y):
    """That of a vector."""
    return (x * x + y * y).sqrt()


def area(axes):
    """The determinant of M = [[a, b], [c, d]], the axes of an ellipse or a box."""
    a, b, c, d = axes
    return a * d - b * c


def inverse(axes):
    """The inverse of M."""
    a, b, c, d = axes
    return arb_mat([[d, -b], [-c, a]]) * (1 / area(axes))


def matrix(axes):
    """M = [[a, b], [c, d]] as a matrix."""
    a, b, c, d = axes
    return arb_mat([[a, b], [c, d]])


# -- 8. The statement `event`: its function crosses zero in the box, where its slope along the
# branch is not zero, and the parameter there lies from `low` to `high`. At a doubling and a fold no
# other multiplier is on the unit circle; a corner impact has the signs of the products, over both
# sides of the corner, of 1 - trace + det and of 1 + trace + det.


def check_event(cam, statement):
    """One event of an orbit, at a value of the parameter that is enclosed."""
    orbit = orbit_of(cam, statement)
    box = statement.box
    event = statement.event
    orbit.krawczyk(box)
    corner = corner_of(orbit, event)
    orbit.motion(box.hull, box.flights, corner)
    crosses(orbit, box, event)
    named(statement, box.hull)
    enclosed_there = lies(box.hull[-1], statement.low, statement.high)
    need(enclosed_there, "its parameter may lie elsewhere")
    if corner is not None:
        check_signs(orbit, statement, corner)
        return
    need(statement.signs == [], "it has more than its kind needs")
    if event.event != "multipliers-meet":
        need(other_inside(orbit, box, event), "another multiplier may lie on the unit circle")


def check_signs(orbit, statement, corner):
    """The signs that a corner impact has, of (1 - trace + det) and (1 + trace + det).

    Each is multiplied over both sides of the corner: the impact `corner` is put on the stretch
    before it and on the one after it, and trace and determinant are those of the map with the
    impact there. There are no signs where the slope of the cam jumps at the corner.
    """
    hull = statement.box.hull
    side = statement.event.side
    if kink(orbit, corner, side, hull):
        no_signs = statement.signs == []
        need(no_signs, "where the slope of the cam jumps a corner impact has no signs")
        return
    need(len(statement.signs) == 2, "a corner impact has two signs")
    at_plus_one = 1  # the product of 1 - trace + det, zero where a multiplier is +1
    at_minus_one = 1  # the product of 1 + trace + det, zero where one is -1
    places = orbit.places
    count = len(orbit.cam.stretches)
    for step in (0, side):
        turns_on, stretch = divmod(places[corner].stretch + step, count)
        z = list(hull)
        z[2 * corner] -= 2 * arb.pi() * turns_on
        moved = list(places)
        moved[corner] = SimpleNamespace(stretch=stretch, turn=places[corner].turn + turns_on)
        orbit.places = moved
        trace, det, _ = orbit.trace_det(z)
        at_plus_one = at_plus_one * (1 - trace + det)
        at_minus_one = at_minus_one * (1 + trace + det)
    orbit.places = places
    for value, sign in zip((at_plus_one, at_minus_one), statement.signs, strict=True):
        need(sign != 0 and value * sign > 0, "a sign of a corner impact is another, or open")


def crosses(orbit, box, event):
    """Show that the event's function of eta has one zero in a box, with a slope.

    It is value + slope eta for |eta| <= half, the slope of one sign.
    """
    ((value, slope),) = orbit.along(box, zero_at(orbit, event))
    need(abs(value) < abs(slope) * box.half, "the function of an event may have no zero")


def zero_at(orbit, event):
    """The function of the unknowns z that gives what is zero at an event, as a list.

    A graze has two such numbers, the slope of the gap and the gap, every other event one. That of
    the multipliers is 1 + trace + det or 1 - trace + det; on a curve, where impacts may fade, it is
    multiplied by the rates of all impacts.
    """

    def function(z):
        if event.event == "corner-impact":
            stretches = orbit.at(z).stretches
            stretch = stretches[orbit.places[event.impact].stretch]
            corner = stretch.end if event.side > 0 else stretch.start
            return [z[2 * event.impact] - corner]
        if event.event == "grazing":
            return touching(orbit, z, event)
        on_curve = orbit.event is not None
        trace, det, scale = orbit.trace_det(z, times_rates=on_curve)
        if event.event == "multipliers-meet":
            return [trace * trace - 4 * det]
        signed_trace = trace if event.event == "period-doubling" else -trace
        return [scale + scale * det + signed_trace]

    return function


def touching(orbit, z, event):
    """[gap', gap] where a flight touches the cam: z[-1] rad after the event's impact."""
    k = event.impact
    touched = event.touch
    theta = z[2 * k]
    v = z[2 * k + 1]
    machine = orbit.at(z)
    c, c1 = machine.stretches[orbit.places[k].stretch].derivatives(theta, 1)
    q, q1, _ = machine.state(c, c1 + v, z[-1])
    phase = theta + z[-1] - 2 * arb.pi() * (touched.turn - orbit.places[k].turn)
    lift, lift1 = machine.stretches[touched.stretch].derivatives(phase, 1)
    return [q1 - lift1, q - lift]


def corner_of(orbit, event):
    """The number of the impact that may lie beyond its stretch, or None; the event has its form.

    Only at a corner impact there is one. An event of another kind names no impact and no side, but
    a graze its flight and where it touches.
    """
    if event is None:
        return None
    if event.event == "grazing":
        count = len(orbit.cam.stretches)
        complete = event.touch is not None and event.impact < orbit.n and event.side == 0
        need(complete and event.touch.stretch < count, "a graze names its flight and its stretch")
        return None
    if event.event != "corner-impact":
        need(event.impact == event.side == 0, "an event has more than its kind needs")
        return None
    complete = event.impact < orbit.n and event.side != 0
    need(complete, "a corner impact names its impact and side")
    return event.impact


def other_inside(orbit, box, event):
    """Whether, where one multiplier is +1 (fold) or -1 (doubling), the other is inside the circle.

    Their product is det < 1. The other one is not beyond -1 at a fold, where 1 + trace + det > 0,
    and not beyond +1 at a doubling, where 1 - trace + det > 0.
    """
    trace, det = orbit.multipliers(box)
    signed_trace = trace if event.event == "fold" else -trace
    return det < 1 and signed_trace > -(1 + det)


def kink(orbit, k, side, z):
    """Whether the cam's slope jumps at the end (side 1) or the start (-1) of impact k's stretch.

    The pieces of a fit meet but for roundings. A seat with a restitution of its own is as good as
    a kink.
    """
    stretches = orbit.at(z).stretches
    index = orbit.places[k].stretch
    here = stretches[index]
    there = stretches[(index + side) % len(stretches)]
    if here.seat != there.seat and orbit.cam.seat_restitution is not None:
        return True
    at_end_of_here = here.end if side > 0 else here.start
    at_end_of_there = there.start if side > 0 else there.end
    slope_here = here.derivatives(at_end_of_here, 1)[1]
    slope_there = there.derivatives(at_end_of_there, 1)[1]
    if orbit.cam.kind == "pieces":
        return not abs(slope_here - slope_there) < ROUNDED_SLOPE
    return not slope_here.overlaps(slope_there)


def lies(x, low, high):
    """Whether a ball lies between two fractions."""
    return ball_of(low) <= x and x <= ball_of(high)


# -- 9. The statement `branch`: a curve of orbits on which the parameter takes every value between
# its two ends. Each box shares an orbit with the one before and the one after, a joint; the first
# and the last joint are the ends. At an end that is an event the function of the event has a slope
# in all of the box beside it, so that it has one sign between the event and the next joint.


def check_branch(cam, statement):
    """Every box of a branch is a box of motions of one stability, and they are one curve."""
    orbit = orbit_of(cam, statement)
    boxes = statement.boxes
    joints = statement.joints
    need(len(statement.ends) == 2, "a branch has two ends")
    first_event, last_event = statement.ends
    one_chain(orbit, statement)
    for ends_of_range, joint in ((statement.low, joints[0]), (statement.high, joints[-1])):
        there = len(ends_of_range) == 2 and lies(joint.hull[-1], *ends_of_range)
        need(there, "an end of the branch may lie elsewhere")
    need(statement.low[1] <= statement.high[0], "its range is empty")
    need(len(boxes) > 1 or None in statement.ends, "one box can have one event only")
    for k, box in enumerate(boxes):
        event = None
        at_event = joints[k]
        beside_event = joints[k + 1]
        if k == 0 and first_event is not None:
            event = first_event
        elif k == len(boxes) - 1 and last_event is not None:
            event = last_event
            at_event = joints[k + 1]
            beside_event = joints[k]
        orbit.motion(box.hull, box.flights, corner_of(orbit, event))
        counted(statement, box.hull)
        if event is None:
            orbit.steady(box, statement.stable)
        else:
            check_end(orbit, statement.stable, box, event, at_event, beside_event)


def one_chain(orbit, statement):
    """Show that the boxes of a branch or a curve hold one curve of orbits, with its label."""
    boxes = statement.boxes
    joints = statement.joints
    need(len(joints) == len(boxes) + 1 >= 2, "a chain has one joint more than boxes")
    for box in (*boxes, *joints):
        orbit.krawczyk(box)
    for k, box in enumerate(boxes):
        joins(box, joints[k])
        joins(box, joints[k + 1])
    named(statement, joints[len(joints) // 2].hull)


def check_end(orbit, stable, box, event, at_event, beside_event):
    """Show the event at an end of a branch, and the stability of the orbits beside it.

    The event's function is zero in the joint `at_event`, one end of the box, and has one slope on
    all of the box: so it has one sign up to the joint `beside_event`, the other end.
    """
    crosses(orbit, at_event, event)
    ((_, slope),) = orbit.along(box, zero_at(orbit, event))
    inner = slope * (beside_event.hull[box.fixed] - at_event.hull[box.fixed])  # of its sign there
    if event.event == "corner-impact":
        need(inner * event.side < 0, "the branch goes to the wrong side of a corner")
        orbit.steady(box, stable)
        return
    need(other_inside(orbit, box, event), "another multiplier may cross the unit circle")
    need(inner > 0 if stable else inner < 0, "the stability beside an event is another")


# The statement `curve`: in two parameters an event happens at every point of a curve. Its condition
# is one equation more, and the second parameter one unknown more. Each box leans along one of the
# parameters: at each of its values the orbit has the event where the other one has its value, and
# the event's function crosses zero where that alone varies. A graze has one unknown more, too: how
# long after impact `impact` gap and slope are zero, rad, above the stretch in `touch`.


def check_curve(cam, statement):
    """In every box of a curve all orbits are motions with the event, and they are one curve."""
    orbit = orbit_of(cam, statement)
    event = statement.event
    corner = corner_of(orbit, event)
    need(orbit.grazes or event.touch is None, "an event has more than its kind needs")
    one_chain(orbit, statement)
    first, last = statement.joints[0], statement.joints[-1]
    for end, joint in ((statement.begin, first), (statement.end, last)):
        first_parameter, second_parameter = orbit.values(joint.hull)
        there = lies(first_parameter, end.parameter.low, end.parameter.high)
        there = there and lies(second_parameter, end.second.low, end.second.high)
        need(there, "an end of the curve may lie elsewhere")
    for box in statement.boxes:
        leans_along_parameter = 0 <= box.fixed - 2 * orbit.n < 2
        need(leans_along_parameter, "a box of a curve leans along a parameter")
        orbit.motion(box.hull, box.flights, corner)
        counted(statement, box.hull)
        if event.event in ("period-doubling", "fold"):
            _, det, _ = orbit.trace_det(box.hull)
            need(det < 1, "another multiplier may lie on the unit circle")


def joins(box, joint):
    """Show that the orbits of a small box, a joint, are those of a larger one that lie there."""
    eta = joint.hull[box.fixed] - box.middle[box.fixed]
    need(abs(eta) <= box.half, "neighbouring boxes do not overlap")
    for k, z in enumerate(joint.hull):
        off = z - box.middle[k] - box.tangent[k] * eta
        need(k == box.fixed or box.reach[k].contains(off), "neighbouring boxes do not overlap")


# -- 10. The statement `all-orbits`: the orbits that it names are all with so few impacts in so few
# turns. From c(a) to c(b), s = b - a rad later, exactly one solution of the flight's equation leads
# where B(s) > 0: it starts at the rate w = (c(b) - c(a) + (G + W2 c(a)) P)/B. So an orbit is its
# phases: those at which each impact's rates, out = w - c'(a) and into = w' - c'(b) of the flight
# before, make E = out + r into = 0. A cover has a tree of boxes of phases for each sequence of
# stretches: a letter for each box, before those of its two halves. The figure k: it is cut in half
# along phase k; a point: it holds no orbit; o: it holds none but a known one, the next in the list.


def check_all(cam, statement):
    """The known orbits are all that there are with so few impacts in so few turns."""
    constants_of_machine = statement.constants
    need(cam.kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    has_seat = any(stretch.seat for stretch in cam.stretches)
    need(not has_seat, "a cam with a seat has no such statement")
    possible(constants_of_machine, ())
    for k, orbit in enumerate(statement.orbits):
        check_orbit(cam, orbit)
        same_machine = (
            {**constants_of_machine, "rpm": None} == orbit.constants
            and orbit.strobe == statement.strobe
            and orbit.parameter == "rpm"
        )
        need(same_machine, "an orbit is one of another machine")
        same_speed = orbit.low <= constants_of_machine["rpm"] <= orbit.high
        need(same_speed, "an orbit is one of another speed")
        small = len(orbit.impacts) <= statement.impacts and orbit.turns <= statement.turns
        need(small, "an orbit is larger than those that are covered")
        again = any(may_be_one(orbit, other) for other in statement.orbits[:k])
        need(not again, "an orbit may stand there twice")
    sizes = [
        (impacts, turns)
        for turns in range(1, statement.turns + 1)
        for impacts in range(1, statement.impacts + 1)
    ]
    covered_sizes = [(cover.impacts, cover.turns) for cover in statement.covers]
    need(covered_sizes == sizes, "a cover is missing")
    try:
        flights = PhaseCover(Machine(cam, constants_of_machine))
        for cover in statement.covers:
            check_cover(flights, cover, statement.orbits)
    finally:
        ctx.prec = BITS


def may_be_one(first, second):
    """Whether two statements may be about one orbit, whose impacts may be counted from any one."""
    if len(first.impacts) != len(second.impacts) or first.turns != second.turns:
        return False
    of_first = first.box.hull[:-1]
    of_second = second.box.hull[:-1]
    rotations = [of_second[2 * k :] + of_second[: 2 * k] for k in range(len(first.impacts))]
    return any(
        all(x.overlaps(y) for x, y in zip(of_first, rotated, strict=True)) for rotated in rotations
    )


def check_cover(flights, cover, orbits):
    """Show that the boxes of a cover, which are all, hold no orbit but those known.

    flights: a PhaseCover; cover: its tree of boxes as letters, and for each letter o the index of
    the known orbit in `orbits`.
    """
    turns = cover.turns
    letters = iter(cover.boxes)
    known = iter(cover.orbits)
    for whole_box in whole_boxes(cover.impacts, turns, len(flights.stretches)):
        boxes = [whole_box]
        while boxes:
            box = boxes.pop()
            letter = next(letters, "")
            need(letter != "", "boxes are missing in a cover")
            if letter == ".":
                need(flights.empty(box, turns), "a box of a cover may hold an orbit")
            elif letter == "o":
                index = next(known, -1)
                need(0 <= index < len(orbits), "a box names an orbit that is not there")
                rotations = ways(orbits[index], cover.impacts, turns, len(flights.stretches))
                alone = any(flights.alone(box, turns, one) for one in rotations)
                need(alone, "a box may hold another orbit than the one it names")
            else:
                boxes += halves(box, int(letter) - 1)
    all_used = next(letters, None) is None and next(known, None) is None
    need(all_used, "a cover has too many boxes")


def whole_boxes(impacts, turns, count):
    """The boxes that are not cut yet: one for each sequence of stretches the impacts may lie on.

    The first one lies in the first turn, each other one not before it. A box has a key for each
    impact, (stretch counted on from turn to turn, 0, 0), see `PhaseCover.cell`; count: stretches.
    """
    for first in range(count):
        not_before = range(first, first + turns * count + 1)
        for others in combinations_with_replacement(not_before, impacts - 1):
            yield [(index, 0, 0) for index in (first, *others)]


def halves(box, k):
    """A box cut in half along phase k: first the half of the later phases."""
    need(k < len(box), "a box is cut along a phase that it has not")
    index, depth, i = box[k]
    need(depth < 60, "a box is too small")
    return [[*box[:k], (index, depth + 1, part), *box[k + 1 :]] for part in (2 * i + 1, 2 * i)]


def ways(orbit, impacts, turns, count):
    """The ways to write an orbit as one of so many impacts and turns: one from each impact on.

    orbit: a statement on it. It is gone through as often as these turns hold it; there is no way
    where it does not have `impacts` impacts then. A way is a list of (stretch, phase within the
    turn, rad); stretches are counted on from turn to turn, `count` of them a turn.
    """
    times = turns // orbit.turns
    if times * orbit.turns != turns or times * len(orbit.impacts) != impacts:
        return []
    phases = orbit.box.hull[: 2 * len(orbit.impacts) : 2]
    period = [
        (impact.stretch, impact.turn, phase)
        for impact, phase in zip(orbit.impacts, phases, strict=True)
    ]
    rotations = []
    for k, (_, first_turn, _) in enumerate(period):
        next_period = [(stretch, turn + orbit.turns, phase) for stretch, turn, phase in period[:k]]
        from_impact_k = [*period[k:], *next_period]
        rotations.append([
            (stretch + count * (turn - first_turn + again * orbit.turns), phase)
            for again in range(times)
            for stretch, turn, phase in from_impact_k
        ])  # fmt: skip
    return rotations


class CellPoint(NamedTuple):
    """The point in the middle of a cell: its phase (rad), counted on, and the cam there."""

    phase: Any
    c: Any
    c1: Any


class Cell:
    """A part of one stretch of the cam in one of its turns: balls of the phase and of the lift.

    index: of the stretch, counted on from turn to turn; x: the phases, rad, counted on likewise;
    in_turn: the same within the turn; c, c1, c2: the lift and its derivatives on all of them;
    middle: a CellPoint; h: what phases of the cell may differ from that of the middle.
    """

    def __init__(self, stretches, index, in_turn):
        """in_turn: phases within the turn, of the stretch or a little beyond it."""
        turn, number = divmod(index, len(stretches))
        shift = 2 * arb.pi() * turn
        middle = in_turn.mid()
        self.index = index
        self.in_turn = in_turn
        self.h = in_turn - middle
        self.stretch = stretches[number]
        c, c1 = self.stretch.derivatives(middle, 1)
        self.c, self.c1, self.c2 = self.stretch.derivatives(in_turn, 2)
        # the mean value theorem may be sharper
        self.c1 = self.c1.intersection(c1 + self.c2 * self.h)
        self.c = self.c.intersection(c + self.c1 * self.h)
        self.x = in_turn + shift
        self.middle = CellPoint(middle + shift, c, c1)


class Rates(NamedTuple):
    """The rates at which a flight leaves the cam and meets it again, relative to it, m/rad."""

    out: Any
    into: Any


class RateSlopes(NamedTuple):
    """The derivatives of Rates by the phases at which the flight starts and lands."""

    out_by_start: Any
    out_by_landing: Any
    into_by_start: Any
    into_by_landing: Any


class CellFlight(NamedTuple):
    """What the flights from one cell to another have in common.

    out, into: balls that hold the rates of all of them (see Rates), None where nothing is known;
    slopes: likewise, None where they are not known, and middle too: the rates between the middles
    of the cells.
    """

    out: Any = None
    into: Any = None
    slopes: RateSlopes | None = None
    middle: Rates | None = None


class PhaseCover:
    """The flights between phases of the cam, by the two phases alone; each is worked out once."""

    STEPS = 8  # a flight is compared with the cam at the ends of so many equal parts
    SHORT = 0.6  # rad: of so short a flight its acceleration is looked at too
    BOUND_DEPTH = 5  # halvings of a stretch for the bounds of the cam

    def __init__(self, machine):
        """The balls of a cover are of BITS_OF_COVER bits from here on."""
        self.machine = machine
        self.stretches = machine.stretches
        self.cells = {}
        self.flights = {}
        need(not jumps(self.stretches, 1), "the slope of the cam jumps")
        ctx.prec = BITS_OF_COVER
        self.longest = None  # rad, no flight is as long; None where there is no such bound
        self.least = arb(0)  # m/(m/rad), no flight with K < 0 has a smaller B, see `bound`
        if machine.sprung and machine.under:
            self.bound()

    def bound(self):
        """Set `longest` and `least`, the limits of flights where the spring swings.

        A flight stays above the level at which the spring rests, so it lasts for less than half a
        swing, pi/f. Its energy w^2/2 + W2 x^2/2 does not grow, with x the height above that level
        and S the steepest slope of the cam: one that leaves the cam with the relative rate u meets
        it with at most u + F, F = 2 S + W sqrt(max x^2 - min x^2), and leaves with r times that.
        So no orbit leaves the cam faster than U = r/(1 - r) F. A flight with K = 1 - W2 P < 0
        lands at x = K x0 + B w < B w with w <= S + U, which takes B >= min x/(S + U).
        """
        machine = self.machine
        parts = [
            self.cell((k, self.BOUND_DEPTH, i))
            for k in range(len(self.stretches))
            for i in range(2**self.BOUND_DEPTH)
        ]
        heights = [part.c + machine.G / machine.W2 for part in parts]
        low = arb(min(x.lower() for x in heights))
        high = arb(max(x.upper() for x in heights))
        steepest = arb(max(abs(part.c1).upper() for part in parts))
        need(low > 0, "the follower may come to rest in flight, and flights may be long")
        self.longest = arb.pi() / machine.f
        if machine.r < 1:
            gained = 2 * steepest + (machine.W2 * (high * high - low * low)).sqrt()  # F
            leaves = gained * machine.r / (1 - machine.r)  # U
            self.least = low / (leaves + steepest)

    def cell(self, key):
        """Part i of the 2^depth equal parts of a stretch, by (index, depth, i)."""
        if key not in self.cells:
            index, depth, i = key
            stretch = self.stretches[index % len(self.stretches)]
            length_of_stretch = stretch.end - stretch.start
            start = stretch.start + length_of_stretch * i / 2**depth
            end = stretch.start + length_of_stretch * (i + 1) / 2**depth
            self.cells[key] = Cell(self.stretches, index, start.union(end))
        return self.cells[key]

    def known(self, a, b):
        """`flight` of two cells by their keys."""
        if (a, b) not in self.flights:
            self.flights[a, b] = self.flight(self.cell(a), self.cell(b))
        return self.flights[a, b]

    def flight(self, a, b):
        """The CellFlight from cell a to cell b; None where there is no flight between them.

        The slopes, with K = 1 - W2 P and D = exp(-2 Z s):
            of out:  out K/B - (c''(a) - q''(a)),  -into/B
            of into: out D/B,                      q''(b) - c''(b) - into B'/B
        """
        machine = self.machine
        s = b.x - a.x
        if s <= 0 or (self.longest is not None and s >= self.longest):
            return None
        by_acceleration = self.short(a, b, s) if b.index - a.index <= 1 else CellFlight()
        if by_acceleration is None or not s > 0:
            return by_acceleration
        big, rate, p = machine.flow(s)
        keeps = 1 - machine.W2 * p  # K
        if keeps < 0 and big < self.least:
            return None
        if not big > 0:
            return by_acceleration
        decay = (-(2 * (machine.Z * s))).exp()
        out = (b.c - a.c * keeps + machine.G * p) / big - a.c1
        into = (b.c * rate - a.c * decay + machine.G * (p * rate - big * big)) / big - b.c1
        if by_acceleration.out is not None:
            out = out.intersection(by_acceleration.out)
            into = into.intersection(by_acceleration.into)
        w_middle, middle = self.between_middles(a, b)
        for _ in range(2):  # the mean value theorem, with slopes by out and into themselves
            leaves = a.c2 - machine.acceleration(a.c, a.c1 + out)
            lands = machine.acceleration(b.c, b.c1 + into) - b.c2
            slopes = RateSlopes(
                out_by_start=out * keeps / big - leaves,
                out_by_landing=-into / big,
                into_by_start=out * decay / big,
                into_by_landing=lands - into * rate / big,
            )
            out = out.intersection(
                middle.out + slopes.out_by_start * a.h + slopes.out_by_landing * b.h
            )
            into = into.intersection(
                middle.into + slopes.into_by_start * a.h + slopes.into_by_landing * b.h
            )
        if out <= 0 or into >= 0 or self.below(a, b, w_middle, Rates(out, into), big):
            return None
        return CellFlight(out, into, slopes, middle)

    def between_middles(self, a, b):
        """(w, Rates) of the flight between the middles of two cells; w: m/rad, not relative."""
        machine = self.machine
        start = a.middle
        end = b.middle
        big, rate, p = machine.flow(end.phase - start.phase)
        w = (end.c - start.c * (1 - machine.W2 * p) + machine.G * p) / big
        w_end = w * rate - (machine.G + machine.W2 * start.c) * big
        return w, Rates(w - start.c1, w_end - end.c1)

    def below(self, a, b, w, rates, big):
        """Whether all flights from a to b are below the cam at a phase on their way.

        w: the rate of the one between the cells' middles; moved to other ends, a flight is higher
        by -out B(b - x) exp(-2 Z (x - a))/B da - into B(x - a)/B db, with B (`big`) of all of its
        way.
        """
        machine = self.machine
        start = a.middle
        end = b.middle
        for k in range(1, self.STEPS):
            phase = (start.phase + (end.phase - start.phase) * k / self.STEPS).mid()
            lift = self.lift(phase)
            if lift is None or not (a.x < phase and phase < b.x):
                continue
            q = machine.state(start.c, w, phase - start.phase)[0]
            since = phase - a.x
            by_end = -rates.into * machine.flow(since)[0] / big
            decay = (-(2 * (machine.Z * since))).exp()
            by_start = -rates.out * machine.flow(b.x - phase)[0] * decay / big
            if q + by_start * a.h + by_end * b.h < lift:
                return True
        return False

    def short(self, a, b, s):
        """The rates of flights on one stretch, or from one to the next; None if there are none.

        s: rad of flight. The gap is zero at both ends, so that out is -s/2 times a mean of its
        acceleration, and into s/2 times another; and where that is nowhere negative the gap is
        nowhere positive.
        """
        machine = self.machine
        most = s.upper()
        if most > self.SHORT or not (self.longest is None or most < self.longest):
            return CellFlight()
        big, rate, _ = machine.flow(most)
        if not (big > 0 and rate > 0):
            return CellFlight()
        if a.index == b.index:
            _, c1, c2 = a.stretch.derivatives(a.in_turn.union(b.in_turn), 2)
        else:
            _, c1, c2 = a.stretch.derivatives(a.in_turn.union(a.stretch.end), 2)
            _, c1_next, c2_next = b.stretch.derivatives(b.in_turn.union(b.stretch.start), 2)
            c1 = c1.union(c1_next)
            c2 = c2.union(c2_next)
        time = arb(0).union(most)
        pull = machine.G + machine.W2 * a.c
        w = c1 * arb(1).union(most / big) + pull * time  # B is concave here: s/2 < P/B < s
        bend = machine.state(a.c, w, time)[2] - c2
        if bend >= 0:
            return None
        half = s / 2 if s > 0 else time / 2
        return CellFlight(out=-half * bend, into=half * bend)

    def lift(self, phase):
        """c at a phase; None beside a corner."""
        in_turn = phase - 2 * arb.pi() * (phase / (2 * arb.pi())).floor()
        for stretch in self.stretches:
            if in_turn > stretch.start and in_turn < stretch.end:
                return stretch.derivatives(in_turn, 0)[0]
        return None

    def newton(self, flights, cells):
        """(E at the cells' middles, its derivatives on all of them) as matrices.

        E of impact k is out + r into, with the rates of the flight after it and of the one before.
        """
        n = len(cells)
        r = self.machine.r
        values = arb_mat(n, 1)
        slopes = arb_mat(n, n)
        for k, after in enumerate(flights):
            before = flights[k - 1]
            values[k, 0] = after.middle.out + r * before.middle.into
            slopes[k, (k - 1) % n] += r * before.slopes.into_by_start
            slopes[k, k] += r * before.slopes.into_by_landing + after.slopes.out_by_start
            slopes[k, (k + 1) % n] += after.slopes.out_by_landing
        return values, slopes

    def later(self, key, turns):
        """The same cell some turns later."""
        index, depth, i = key
        return index + turns * len(self.stretches), depth, i

    def empty(self, keys, turns):
        """Whether no orbit of so many turns has its impacts in these cells, one after the other.

        Of its flights the first one is the longest, or one of these.
        """
        n = len(keys)
        closed = [*keys, self.later(keys[0], turns)]
        cells = [self.cell(key) for key in closed]
        lengths = [b.x - a.x for a, b in pairwise(cells)]
        if any(one > lengths[0] for one in lengths[1:]):
            return True
        if n > 1 and n * lengths[0] < 2 * turns * arb.pi():
            return True
        flights = [self.known(a, b) for a, b in pairwise(closed)]
        if None in flights:
            return True
        for k, after in enumerate(flights):
            before = flights[k - 1]
            known = after.out is not None and before.into is not None
            if known and not (after.out + self.machine.r * before.into).contains(0):
                return True
        if any(flight.slopes is None for flight in flights):
            return False
        values, slopes = self.newton(flights, cells[:-1])
        return self.newton_excludes(values, slopes, arb_mat([[cell.h] for cell in cells[:-1]]))

    def newton_excludes(self, values, slopes, off):
        """Whether E has no zero in the cells: by the mean value theorem, or a step of Newton's.

        values: E at the cells' middles; slopes: its derivatives; off: what phases may be off these.
        """
        if not all(x.contains(0) for x in (values + slopes * off).entries()):
            return True
        try:
            y = slopes.mid().inv().mid()
        except ZeroDivisionError:
            return False
        image = (identity(values.nrows()) - y * slopes) * off - y * values
        pairs = zip(image.entries(), off.entries(), strict=True)
        return not all(x.overlaps(cell) for x, cell in pairs)

    def alone(self, keys, turns, orbit):
        """Whether the orbit's impacts are the only zero of E near cells, which it lies in or near.

        orbit: (index of the stretch, phase within the turn) of each of its impacts. E has one zero
        at most where the sums of the rows of |Y E' - 1| are below one.
        """
        if [key[0] for key in keys] != [index for index, _ in orbit]:
            return False
        wide = [
            Cell(self.stretches, key[0], self.cell(key).in_turn.union(theta))
            for key, (_, theta) in zip(keys, orbit, strict=True)
        ]
        last_index = self.later(keys[0], turns)[0]
        last = Cell(self.stretches, last_index, wide[0].in_turn)
        flights = [self.flight(a, b) for a, b in pairwise([*wide, last])]
        if any(flight is None or flight.slopes is None for flight in flights):
            return False
        _, slopes = self.newton(flights, wide)
        n = len(keys)
        try:
            product_of_both = slopes.mid().inv().mid() * slopes
        except ZeroDivisionError:
            return False
        off = [[abs(product_of_both[i, j] - int(i == j)) for j in range(n)] for i in range(n)]
        return all(sum(row) < 1 for row in off)


# -- 11. The statement `chaos`: every sequence of boxes along the coverings is that of a motion's
# impacts. A box holds the impacts (theta, v) = middle + M (x, y), |x|, |y| <= 1. It covers another
# one if all of its flights land at |y| < 1 there, those from x = -1 on one side of it, x < -1 or
# x > 1, and those from x = 1 on the other side. `weights` show that the number of sequences grows
# by `growth` from impact to impact, and its logarithm is at most the entropy.


def check_chaos(cam, statement):
    """The boxes lie apart, cover one another as it is said, and their sequences grow.

    weights: w_k >= 0, not all zero. Where sum of w_j over all boxes j that box k covers is at least
    growth w_k, the number of sequences grows by that factor from impact to impact.
    """
    boxes = statement.boxes
    numbers_of_box = {len(box.middle) + len(box.axes) for box in boxes}
    need(numbers_of_box == {6}, "a box has not two numbers and four of its axes")
    need(statement.low <= statement.high, "its range is empty")
    for k, box in enumerate(boxes):
        need(area(box.axes) > 0 or area(box.axes) < 0, f"box {k + 1} is flat")
        for j, other in enumerate(boxes[:k]):
            apart = box.stretch != other.stretch or beside(box, other) or beside(other, box)
            need(apart, f"boxes {j + 1} and {k + 1} may overlap")
    coverings = {tuple(pair) for pair in statement.coverings}
    pairs_of_boxes = all(len(pair) == 2 and max(pair) < len(boxes) for pair in coverings)
    each_once = len(coverings) == len(statement.coverings)
    need(pairs_of_boxes and each_once, "its coverings are no pairs of boxes")
    for k in range(len(boxes)):
        covered = [j for i, j in sorted(coverings) if i == k]
        check_covers(cam, statement, k, covered)
    weights = statement.weights
    need(len(weights) == len(boxes) and min(weights) >= 0 < max(weights), "it has not its weights")
    need(statement.growth > 1, "the number of sequences does not grow")
    for k, weight in enumerate(weights):
        of_covered = sum(weights[j] for i, j in coverings if i == k)
        grows = of_covered >= statement.growth * weight
        need(grows, "the number of sequences may grow more slowly")


def beside(box, other):
    """Whether another box lies on one side of this one, along one of its axes.

    In units of this box, |x|, |y| <= 1, the other one is a parallelogram about its middle, with
    the sums of the rows of |inverse(M) M_other| for half its width.
    """
    middle = within(box, other.middle)
    axes = inverse(box.axes) * matrix(other.axes)
    half_widths = [abs(axes[k, 0]) + abs(axes[k, 1]) for k in (0, 1)]
    return any(abs(middle[k, 0]) > 1 + half_widths[k] for k in (0, 1))


def within(box, point):
    """(x, y) of a point (theta, v) in units of a box, as a column: middle + M (x, y) = point."""
    return inverse(box.axes) * arb_mat([[point[k] - box.middle[k]] for k in (0, 1)])


class CellOfBox(NamedTuple):
    """A cell of a box of impacts, and where its flights land.

    ends: x of the ends of the box (-1, 1) that the cell touches, counted from the cell's middle and
    so with the sign of the end; image: (theta, v) of the landing from that middle; slopes: matrix
    of the derivatives of the landings by (x, y), on all of the cell; reach: balls of what x and y
    may differ from the cell's middle.
    """

    ends: list
    image: tuple
    slopes: Any
    reach: list


def check_covers(cam, statement, k, covered):
    """Show that box k covers the boxes whose numbers are in `covered`, by its cells.

    With the matrix D of the slopes of the impact map on a cell, a point of it lands at the image of
    the cell's middle + D times its distance from there.
    """
    box = statement.boxes[k]
    same_stretch = all(statement.boxes[j].stretch == box.lands.stretch for j in covered)
    need(same_stretch, "a flight lands on another box")
    places = [SimpleNamespace(stretch=box.stretch, turn=0), box.lands]
    parameters = (statement.parameter,)
    orbit = Orbit(cam, statement.constants, parameters, places, box.lands.turn + 1)
    p = ball_of(statement.low).union(ball_of(statement.high))
    # for each covered box: whether the ends of box k land on the side of x of their own sign
    same_sides: dict[int, set[bool]] = {j: set() for j in covered}
    for cell in cells(orbit, box, p):
        for j in covered:
            image = within(statement.boxes[j], cell.image)
            slopes = inverse(statement.boxes[j].axes) * cell.slopes
            y = image[1, 0] + slopes[1, 0] * cell.reach[0] + slopes[1, 1] * cell.reach[1]
            need(abs(y) < 1, f"box {k + 1} may be mapped beside box {j + 1}")
            for end in cell.ends:
                x = image[0, 0] + slopes[0, 0] * end + slopes[0, 1] * cell.reach[1]
                need(x < -1 or x > 1, f"an end of box {k + 1} may be mapped into box {j + 1}")
                same_sides[j].add((x > 0) == (end > 0))
    for j in covered:
        across = len(same_sides[j]) == 1  # both ends on their own side, or both on the other
        need(across, f"box {k + 1} is not mapped across box {j + 1}")


def cells(orbit, box, p):
    """The cells of a box, each as a CellOfBox, with its flights checked.

    orbit: with the place of the box and the one where its flights land; p: ball of the parameter.
    """
    machine = orbit.machine(p)
    axes = matrix(box.axes)
    need(len(box.cells) == 2, "a box is divided along both of its axes")
    columns, rows = box.cells  # along x and along y
    need(len(box.flights) == columns * rows, "not every cell of a box has its flights")
    reach = [around(0, 1 / arb(columns)), around(0, 1 / arb(rows))]
    spread = axes * arb_mat([[x] for x in reach])  # of (theta, v) in a cell
    for number, flight in enumerate(box.flights):
        column, row = divmod(number, rows)
        x = arb(2 * column + 1) / columns - 1
        y = arb(2 * row + 1) / rows - 1
        off = axes * arb_mat([[x], [y]])
        middle = [box.middle[0] + off[0, 0], box.middle[1] + off[1, 0]]
        landings = flight.low.union(flight.high)  # rad within the turn
        check_cell_flight(orbit, machine, middle, spread, flight, p)
        lands = landing(orbit, machine, middle, 0, landings)
        need(lands is not None, "no landing was found")
        end = orbit.flight(machine, middle, 0, lands)
        leaves_at = -(end.r * end.rate)
        # the slopes twice: first over all landings given, then over those that follow from them
        z = [middle[0] + spread[0, 0], middle[1] + spread[1, 0], landings]
        rough = impact_map(orbit.flight(machine, z, 0))
        z[2] = lands + rough.theta_by_theta * spread[0, 0] + rough.theta_by_v * spread[1, 0]
        slopes = impact_map(orbit.flight(machine, z, 0)).matrix() * axes
        ends = []
        if column == 0:
            ends.append(arb(-1) / columns)
        if column == columns - 1:
            ends.append(arb(1) / columns)
        yield CellOfBox(ends, (lands, leaves_at), slopes, reach)


def check_cell_flight(orbit, machine, middle, spread, flight, p):
    """Show that all flights from a cell bounce, clear the cam, and land between low and high.

    middle: (theta, v) of the cell's middle; spread: column of the balls of what theta and v may
    differ from it; flight: its low and high phase of landing, and its parts; p: ball of the
    parameter.
    """
    theta = middle[0] + spread[0, 0]
    v = middle[1] + spread[1, 0]
    landings = flight.low.union(flight.high)
    for phase, place in zip((theta, landings), orbit.places, strict=True):
        stretch = machine.stretches[place.stretch]
        inside = stretch.start < phase and phase < stretch.end
        need(inside, "a flight may begin or land outside its stretch of the cam")
    need(v > 0, "an impact may not bounce")
    v_of_landing = arb(1)  # the flight does not depend on it
    z = [theta, v, landings, v_of_landing, p]
    orbit.clear(z, 0, flight)
    for end, sign_of_gap in ((flight.low, 1), (flight.high, -1)):
        gap = orbit.flight(machine, middle, 0, end).gap
        slopes = orbit.flight(machine, z, 0, end)
        gap += slopes.gap_by_theta * spread[0, 0] + slopes.gap_by_v * spread[1, 0]
        need(sign_of_gap * gap > 0, "a flight may not land between the phases that are given")


def landing(orbit, machine, z, k, landings):
    """The phase at which flight k lands, by Newton's interval method; None if it may lie elsewhere.

    landings: the ball of phases in which it is, with a landing at each of its ends excluded.
    """

    def gap(phase):
        return value_of(orbit.flight(machine, z, k, phase).gap)

    rate = value_of(orbit.flight(machine, z, k, landings).rate)
    phase = landings.mid()
    for _ in range(10):  # towards the landing
        phase = (phase - gap(phase) / rate).mid()
    enclosed_phase = phase - gap(phase) / rate
    inside = landings.contains(phase) and landings.contains(enclosed_phase)
    return enclosed_phase if inside else None


# -- 12. Loss of contact. The statement `first-detachment`: a follower that rests on the cam stays
# there at all speeds up to `low`, and not at `high`. The force of contact at the angular velocity
# omega is N = k c + m g + F0 + omega b c' + omega^2 m c''.


def check_detachment(cam, statement):
    """The force is above zero all over the cam at all speeds up to `low`, and not at `high`."""
    constants_of_machine = resting(cam, statement)
    need(len(statement.cuts) == len(cam.stretches), "not every stretch has its cuts")
    force = ContactForce(constants_of_machine)
    low = ball_of(statement.low) * arb.pi() / 30  # rad/s
    high = ball_of(statement.high) * arb.pi() / 30
    for stretch, cuts in zip(cam.stretches, statement.cuts, strict=True):
        for start, end in pairwise([stretch.start, *cuts, stretch.end]):
            need(start < end, "the cuts of a stretch do not follow one another")
            pressed = force.presses(stretch, start, end, low)
            need(pressed, "the force may end at a lower speed")
    need(statement.stretch < len(cam.stretches), "the cam has no such stretch")
    there = cam.stretches[statement.stretch]
    phase = there.end if statement.at_end else there.start
    ends = force.at(high, there.derivatives(phase, 2)) < 0
    need(ends, "the force may not end")


class ContactForce:
    """The force of contact at rest, N = k c + m g + F0 + omega b c' + omega^2 m c''."""

    def __init__(self, constants_of_machine):
        self.m = ball_of(constants_of_machine["mass"])
        self.k = ball_of(constants_of_machine["stiffness"])
        self.b = ball_of(constants_of_machine["damping"])
        self.damped = constants_of_machine["damping"] != 0
        gravity = ball_of(constants_of_machine["gravity"])
        self.level = self.m * gravity + ball_of(constants_of_machine["preload"])

    def of_lift(self, omega, c):
        """What depends on the cam, at omega (rad/s); c: [c, c', c''], or for N' [c', c'', c''']."""
        return self.k * c[0] + omega * (self.b * c[1] + omega * self.m * c[2])

    def at(self, omega, c):
        """N at omega (rad/s), with c = [c, c', c'']."""
        return self.level + self.of_lift(omega, c)

    def presses(self, stretch, start, end, omega):
        """Whether N > 0 between two phases of a stretch, at all speeds from 0 to omega (rad/s).

        At omega N is monotonic between them, or above zero by the mean value theorem. As a function
        of the speed N is least at standstill or at omega where it is concave (c'' < 0), or has no
        linear term (b = 0); elsewhere it is taken over all speeds.
        """
        phase = start.union(end)
        c = stretch.derivatives(phase, 3)
        slope = self.of_lift(omega, c[1:])
        at_start = self.at(omega, stretch.derivatives(start, 2))
        at_end = self.at(omega, stretch.derivatives(end, 2))
        at_omega = (
            (at_start > 0 and slope > 0)
            or (at_end > 0 and slope < 0)
            or at_start + (phase - start) * slope > 0
        )
        at_standstill = self.at(arb(0), c) > 0
        least_at_an_end = not self.damped or c[2] < 0
        return (
            at_omega and at_standstill and (least_at_an_end or self.at(arb(0).union(omega), c) > 0)
        )


def resting(cam, statement):
    """The constants of a machine whose follower can rest all over the cam, at any speed."""
    need(cam.kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    has_seat = any(stretch.seat for stretch in cam.stretches)
    need(not has_seat, "a cam with a seat has no such statement")
    need(not jumps(cam.stretches, 1), "the slope of the cam jumps")
    possible(statement.constants, ("rpm",))
    need(0 < statement.low < statement.high, "its range is empty")
    return statement.constants


# The statement `corner-hit`: a follower that rests on the cam leaves it at the start of the stretch
# `start`. The flight after its last impact in `impacts` is followed to the end of the stretch
# `corner`, where the gap has one sign at `low`, the other at `high`, and a slope by the speed
# between them: so that impact is at the corner at exactly one speed.


def check_corner_hit(cam, statement):
    """The impact after those that are given lands on a corner at one speed."""
    resting(cam, statement)
    stretches = cam.stretches
    impacts = statement.impacts
    need(len(statement.flights) == len(impacts) + 1, "not every impact has its flight")
    in_cam = max(statement.start, statement.corner.stretch) < len(stretches)
    need(in_cam, "the cam has no such stretch")
    places = [SimpleNamespace(stretch=statement.start, turn=0), *impacts, statement.corner]
    turns = 1 + max(place.turn for place in places)
    orbit = Orbit(cam, statement.constants, ("rpm",), places, turns)
    low = ball_of(statement.low)
    high = ball_of(statement.high)
    all_speeds = low.union(high)
    lifts_off(orbit.machine(all_speeds), statement.start)
    motion = flown(orbit, statement, all_speeds)
    for k in range(orbit.n - 1):
        z = list(motion.unknowns)
        z[2 * k + 2] = motion.landings[k]
        if k > 0:
            stretch = stretches[places[k].stretch]
            inside = stretch.start < motion.landings[k - 1] < stretch.end
            need(inside, f"impact {k} may lie outside its stretch of the cam")
            need(motion.unknowns[2 * k + 1] > 0, f"impact {k} may not bounce")
        orbit.clear([*z, all_speeds], k, statement.flights[k], lifts=k == 0)
    gap_at_low = value_of(flown(orbit, statement, low).gap)
    gap_at_high = value_of(flown(orbit, statement, high).gap)
    falls = gap_at_low > 0 and gap_at_high < 0
    rises = gap_at_low < 0 and gap_at_high > 0
    need(falls or rises, "the corner may not be met")
    slope = slope_of(motion.gap)
    need(slope > 0 or slope < 0, "the corner may be met at several speeds")


def lifts_off(machine, start):
    """Show that a follower at rest is pressed before the start of a stretch, and not behind it."""
    before = machine.stretches[start - 1]
    behind = machine.stretches[start]
    for stretch, corner, sign in ((before, before.end, -1), (behind, behind.start, 1)):
        c, c1, c2 = stretch.derivatives(corner, 2)
        gap_acceleration = machine.acceleration(c, c1) - c2  # below zero where it is pressed
        need(sign * gap_acceleration > 0, "the follower may not leave there")


class FlownImpacts(NamedTuple):
    """A motion from lift-off to the corner of a statement `corner-hit`, at one speed or a ball.

    unknowns: theta and v of lift-off and of each impact, then the phase of the corner and a zero in
    the place of v; landings: the ball of phases that the file gives for each impact, then the
    corner's phase; gap: above the corner, a series with its derivative by the speed.
    """

    unknowns: list
    landings: list
    gap: Any


def flown(orbit, statement, rpm):
    """The motion from lift-off on, as FlownImpacts, at all speeds of a ball (rpm)."""
    machine = orbit.machine(sloped(rpm, 1))
    z = [sloped(orbit.cam.stretches[statement.start].start, 0), sloped(0, 0)]
    landings = []
    for k, impact in enumerate(statement.impacts):
        given = impact.low.union(impact.high)
        for end, sign_of_gap in ((impact.low, 1), (impact.high, -1)):
            gap = value_of(orbit.flight(machine, z, k, end).gap)
            need(sign_of_gap * gap > 0, f"impact {k + 1} may lie elsewhere")
        phase = landing(orbit, machine, z, k, given)
        need(phase is not None, f"impact {k + 1} may lie elsewhere")
        end_at_fixed_phase = orbit.flight(machine, z, k, phase)
        slope_of_gap = slope_of(end_at_fixed_phase.gap)
        theta = sloped(phase, -(slope_of_gap / value_of(end_at_fixed_phase.rate)))
        end_of_flight = orbit.flight(machine, z, k, theta)
        z += [theta, -(end_of_flight.r * end_of_flight.rate)]
        landings.append(given)
    corner = orbit.cam.stretches[statement.corner.stretch].end
    gap = orbit.flight(machine, z, orbit.n - 2, corner).gap
    unknowns = [value_of(x) for x in z] + [corner, arb(0)]
    return FlownImpacts(unknowns, [*landings, corner], gap)


# -- 13. The file: the form of every value, and no key is left over.


def expect(holds, where, what):
    """Refuse the file where a value has not its form."""
    if not holds:
        raise NoCertificateError(f"{where}: expected {what}")


def read(value, form, where):
    """A value of the file in the form that it must have.

    A dictionary is the form of an object with exactly these keys, [form] that of a list, a range
    that of a whole number, a tuple that of one of these words. Other forms are functions.
    """
    if isinstance(form, dict):
        fits = isinstance(value, dict) and set(value) == set(form)
        expect(fits, where, f"an object with the keys {', '.join(form)}")
        entries = {key: read(value[key], form[key], f"{where}.{key}") for key in form}
        return SimpleNamespace(**entries)
    if isinstance(form, list):
        expect(isinstance(value, list), where, "a list")
        return [read(one, form[0], f"{where}[{k}]") for k, one in enumerate(value)]
    if isinstance(form, range):
        fits = type(value) is int and value in form
        expect(fits, where, f"a whole number from {form[0]} to {form[-1]}")
        return value
    if isinstance(form, tuple):
        fits = isinstance(value, str) and value in form
        expect(fits, where, f"one of {', '.join(form)}")
        return value
    return form(value, where)


def exact(value, where):
    """An exact number, written as text."""
    fits = isinstance(value, str) and NUMBER.fullmatch(value)
    expect(fits, where, 'a number as text, like "0.85"')
    return Fraction(value)


def ball(value, where):
    """An exact number as a ball."""
    return ball_of(exact(value, where))


def truth(value, where):
    """True or false."""
    expect(type(value) is bool, where, "true or false")
    return value


def text(value, where):
    """A short text of one line: what is printed of a file must not look like another line."""
    fits = isinstance(value, str) and len(value) <= 400 and value.isprintable()
    expect(fits, where, "a short text in one line")
    return value


def tree(value, where):
    """Boxes cut in half again and again, as text (section 10)."""
    fits = isinstance(value, str) and TREE.fullmatch(value)
    expect(fits, where, "the letters of a cover")
    return value


def identifier(value, where):
    """The name of a number of the cam."""
    expect(isinstance(value, str) and NAME.fullmatch(value), where, "a name")
    return value


def formula(value, where):
    """A number, or an expression of numbers by their names: `evaluated` says of what."""
    if isinstance(value, str) and NUMBER.fullmatch(value):
        return Fraction(value)
    expect(isinstance(value, str) and FORMULA.fullmatch(value), where, "a formula")
    try:
        return ast.parse(value, mode="eval").body
    except SyntaxError:
        raise NoCertificateError(f"{where}: expected a formula") from None


def parameter(value, where):
    """A constant of the machine, or with cam. before it the name of a number of the cam."""
    if isinstance(value, str) and value.startswith("cam."):
        return "cam." + identifier(value.removeprefix("cam."), where)
    return read(value, CONSTANTS, where)


def constants(value, where):
    """The constants of the machine by name; None for one that is left open."""
    form = dict.fromkeys(CONSTANTS, exact_or_none)
    return vars(read(value, form, where))


def numbers(value, where):
    """Numbers by their names."""
    expect(isinstance(value, dict) and "pi" not in value, where, "numbers by their names, not pi")
    return {identifier(key, where): enclosed(x, f"{where}.{key}") for key, x in value.items()}


def enclosed(value, where):
    """An exact number, or the ball of all numbers "2.5 +/- 1e-60"."""
    if not isinstance(value, str) or " +/- " not in value:
        return exact(value, where)
    middle, _, radius = value.partition(" +/- ")
    return around(ball(middle, where), ball(radius, where))


def place_or_none(value, where):
    """A stretch in one of the turns, or None."""
    return None if value is None else read(value, PLACE, where)


def exact_or_none(value, where):
    """An exact number, or None."""
    return None if value is None else exact(value, where)


def cam_of(value, where):
    """The cam of the file as a Cam, checked for steps; None where the file has none."""
    if value is None:
        return None
    cam = Cam(read(value, CAM, where))
    if cam.kind != "pieces" and jumps(cam.stretches, 0):  # steps of a fit: see `above_edges`
        raise NoCertificateError(f"{where}: these numbers make no cam, it has a step")
    expect(above_seat(cam.stretches), where, "a seat that is level, and nothing below it")
    possible_on_seat = cam.seat_restitution is None or 0 < cam.seat_restitution <= 1
    expect(possible_on_seat, where, "a restitution from 0 to 1 on the seat")
    return cam


def statement_of(value, where, kinds=None):
    """A statement in the form of its kind, which has to be one of `kinds`, or any where None."""
    kind = value.get("kind") if isinstance(value, dict) else None
    kind = read(kind, kinds or tuple(STATEMENTS), f"{where}.kind")
    form = STATEMENTS[kind].keys
    return read(value, {"kind": text, **form}, where)


def known_orbit(value, where):
    """A statement on an orbit, within another statement."""
    return statement_of(value, where, ("orbit",))


def event_at_end(value, where):
    """The event at which a branch ends, or None."""
    return None if value is None else read(value, {**EVENT, "event": ENDS}, where)


class KindOfStatement(NamedTuple):
    """How a statement is checked, a function of (cam, statement), and the form of its keys."""

    check: Callable
    keys: dict


NUMBER = re.compile(r"-?[0-9]{1,400}(\.[0-9]{1,1200})?(e-?[0-9]{1,3})?")
FORMULA = re.compile(r"[A-Za-z0-9_+*/(), -]{1,2000}")
NAME = re.compile(r"[A-Za-z]\w{0,40}")
TREE = re.compile(r"[.o1-9]{1,20000000}")
INDEX = range(1_000_001)
SIGN = range(-1, 2)
SMALL = range(1, 10)
STRETCH = {"end": formula, "center": formula, "polynomial": [formula], "wave": [formula],
           "circle": [formula], "seat": truth}  # fmt: skip
CAM = {"kind": ("arcs", "eccentric", "law", "oscillator", "pieces"), "numbers": numbers,
       "formulas": [{"name": identifier, "formula": formula}], "stretches": [STRETCH],
       "seat_restitution": exact_or_none}  # fmt: skip
PLACE = {"stretch": INDEX, "turn": range(1001)}
PASSAGE = {"stretch": INDEX, "turn": range(2001), "cuts": [ball]}
FLIGHT = {"rise": INDEX, "fall": INDEX, "passages": [PASSAGE]}
POINT = {"middle": [ball], "tangent": [ball], "error": [ball], "fixed": INDEX, "half": ball,
         "inverse": [[ball]]}  # fmt: skip
BOX = {**POINT, "flights": [FLIGHT]}
# events at which a branch may end, and those of which a curve may be
ENDS = ("period-doubling", "fold", "corner-impact")
EVENT = {"event": (*ENDS, "multipliers-meet"), "impact": INDEX, "side": SIGN}
EVENT_OF_CURVE = {**EVENT, "event": (*ENDS, "grazing"), "touch": place_or_none}
RANGE = {"low": exact, "high": exact}
END = {"parameter": RANGE, "second": RANGE}
OF_ORBIT = {"label": text, "parameter": parameter, "constants": constants,
            "turns": range(1, 1001), "strobe": exact, "impacts": [PLACE]}  # fmt: skip
SECTION = {"stretch": INDEX, "middle": [ball], "axes": [ball], "lands": PLACE,
           "cells": [range(1, 1001)],
           "flights": [{"low": ball, "high": ball, **FLIGHT}]}  # fmt: skip
COVER = {"impacts": SMALL, "turns": SMALL, "boxes": tree, "orbits": [INDEX]}
STATEMENTS = {
    "orbit": KindOfStatement(
        check_orbit, {**OF_ORBIT, **RANGE, "stable": truth, "box": BOX}
    ),
    "attractor": KindOfStatement(
        check_attractor, {**OF_ORBIT, **RANGE, "box": BOX, "axes": [[ball]]}
    ),
    "event": KindOfStatement(
        check_event, {**OF_ORBIT, **RANGE, "box": BOX, "event": EVENT, "signs": [SIGN]}
    ),
    "branch": KindOfStatement(
        check_branch,
        {**OF_ORBIT, "low": [exact], "high": [exact], "stable": truth, "ends": [event_at_end],
         "boxes": [BOX], "joints": [POINT]},
    ),
    "curve": KindOfStatement(
        check_curve,
        {**OF_ORBIT, "second": parameter, "event": EVENT_OF_CURVE, "begin": END, "end": END,
         "boxes": [BOX], "joints": [POINT]},
    ),
    "all-orbits": KindOfStatement(
        check_all,
        {"constants": constants, "strobe": exact, "impacts": SMALL, "turns": SMALL,
         "orbits": [known_orbit], "covers": [COVER]},
    ),
    "chaos": KindOfStatement(
        check_chaos,
        {**RANGE, "parameter": CONSTANTS, "constants": constants, "boxes": [SECTION],
         "coverings": [[INDEX]], "growth": exact, "weights": [exact]},
    ),
    "first-detachment": KindOfStatement(
        check_detachment,
        {**RANGE, "constants": constants, "stretch": INDEX, "at_end": truth, "cuts": [[ball]]},
    ),
    "corner-hit": KindOfStatement(
        check_corner_hit,
        {**RANGE, "constants": constants, "start": INDEX,
         "impacts": [{**PLACE, **dict.fromkeys(RANGE, ball)}], "corner": PLACE,
         "flights": [FLIGHT]},
    ),
}  # fmt: skip
FILE = {"format": ("camcli-proof-1",), "cam": cam_of, "statements": [statement_of],
        "uncovered": [text]}  # fmt: skip


# -- 14. What is said of each statement, in words; ranges of orbits are rounded inwards, those of
# events outwards, so that no more is said than was shown.


def claim(statement, cam):
    """What a statement says, as a sentence without its full stop."""
    return CLAIMS[statement.kind](statement, cam)


def claim_of_all(statement, cam):
    """What `all-orbits` says."""
    names = [f"{orbit.label}, {state(orbit)}" for orbit in statement.orbits]
    rpm = statement.constants["rpm"]
    speed = "open" if rpm is None else in_full(rpm)
    size = f"{up_to(statement.impacts, 'impact')} in {up_to(statement.turns, 'turn')}"
    return (
        f"at rpm = {speed} the orbits without rest that have {size} are {len(names)}: "
        f"{'; '.join(names) or 'none'}"
    )


def claim_of_branch(statement, cam):
    """What `branch` says: its range rounded inwards, between the far ends of both enclosures."""
    from_highest = [shown(x, ROUND_CEILING) for x in statement.low[-1:]]
    to_lowest = [shown(x, ROUND_FLOOR) for x in statement.high[:1]]
    return (
        f"{statement.label} exists and is {state(statement)} for all {statement.parameter} "
        f"between {' and '.join(from_highest + to_lowest)}"
    )


def claim_of_curve(statement, cam):
    """What `curve` says."""
    return (
        f"{statement.event.event} of {statement.label} all along a curve without a gap from "
        f"{end_name(statement, statement.begin)} to {end_name(statement, statement.end)}"
    )


def claim_of_event(statement, cam):
    """What `event` says: its range rounded outwards."""
    return (
        f"{statement.event.event} of {statement.label}, {statement.parameter} {outwards(statement)}"
    )


def claim_of_detachment(statement, cam):
    """What `first-detachment` says."""
    low = shown(statement.low, ROUND_FLOOR)
    high = shown(statement.high, ROUND_CEILING)
    return (
        f"a follower that rests on the cam stays there at every rpm up to {low}, "
        f"and leaves it at {high}"
    )


def claim_of_corner_hit(statement, cam):
    """What `corner-hit` says."""
    leaves = corner_name(cam, statement.start, "start")
    lands = corner_name(cam, statement.corner.stretch, "end")
    return (
        f"a follower that rests on the cam leaves it at {leaves}, and its impact "
        f"{len(statement.impacts) + 1} is at {lands}, for exactly one rpm {outwards(statement)}"
    )


def claim_of_orbit(statement, cam):
    """What `orbit` says."""
    every = f"for every {statement.parameter} {span(statement)}"
    return f"{statement.label}, {state(statement)}, {every}: exactly one in its box"


def claim_of_attractor(statement, cam):
    """What `attractor` says, with the size of the first ellipse."""
    size = ""
    if statement.axes and len(statement.axes[0]) == 4:
        a, b, c, d = statement.axes[0]
        by_theta = at_least(length(a, b) * 180 / arb.pi())
        by_v = at_least(length(c, d))
        size = f", {by_theta} deg and {by_v} m/rad to either side,"
    return (
        f"every motion with an impact in an ellipse about impact 1 of {statement.label}{size} "
        f"tends to it, for every {statement.parameter} {span(statement)}"
    )


def claim_of_chaos(statement, cam):
    """What `chaos` says."""
    turns = max([1, *(box.lands.turn for box in statement.boxes)])
    return (
        f"chaos for every {statement.parameter} {span(statement)}: {len(statement.boxes)} boxes of "
        f"impacts with {len(statement.coverings)} coverings, so infinitely many periodic orbits "
        "and an entropy of the impact map of at "
        f"least log({shown(statement.growth, ROUND_FLOOR)}); from one impact to the next at most "
        f"{turns} {'turn passes' if turns == 1 else 'turns pass'}"
    )


CLAIMS = {  # what a statement of each kind says, a function of (statement, cam)
    "all-orbits": claim_of_all,
    "attractor": claim_of_attractor,
    "branch": claim_of_branch,
    "chaos": claim_of_chaos,
    "corner-hit": claim_of_corner_hit,
    "curve": claim_of_curve,
    "event": claim_of_event,
    "first-detachment": claim_of_detachment,
    "orbit": claim_of_orbit,
}


def end_name(statement, end):
    """An end of a curve in both parameters: one that is enclosed rounded outwards."""
    texts = []
    for name, x in ((statement.parameter, end.parameter), (statement.second, end.second)):
        if x.low == x.high:
            value = in_full(x.low)
        else:
            value = f"[{shown(x.low, ROUND_FLOOR)}, {shown(x.high, ROUND_CEILING)}]"
        texts.append(f"{name} = {value}")
    return ", ".join(texts)


def state(statement):
    """The stability that a statement claims."""
    return "stable" if statement.stable else "unstable"


def shown(x, way, digits=SHOWN):
    """A fraction to so many digits, rounded down or up."""
    context = Context(prec=digits, rounding=way)
    return str(context.divide(Decimal(x.numerator), Decimal(x.denominator)))


def in_full(x):
    """A fraction whose decimals end, with all of them."""
    return str(Context(prec=3000).divide(Decimal(x.numerator), Decimal(x.denominator)))


def span(statement):
    """From where to where a statement holds: rounded inwards, or in full where that leaves none."""
    low = shown(statement.low, ROUND_CEILING)
    high = shown(statement.high, ROUND_FLOOR)
    if Decimal(low) > Decimal(high):
        low = in_full(statement.low)
        high = in_full(statement.high)
    return f"from {low} to {high}"


def outwards(statement):
    """Between which values an event happens: rounded outwards."""
    return f"from {shown(statement.low, ROUND_FLOOR)} to {shown(statement.high, ROUND_CEILING)}"


def at_least(x):
    """A number to few digits that is no larger than any in a ball."""
    mantissa, exponent = x.lower().man_exp()
    least = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return shown(least, ROUND_FLOOR, DIGITS_OF_SIZE)


def corner_name(cam, index, end):
    """The `start` or the `end` of a stretch by its angle, deg, and its number in the file."""
    numbered = f"the {end} of stretch {index}"
    if index >= len(cam.stretches):
        return numbered
    stretch = cam.stretches[index]
    angle = stretch.start if end == "start" else stretch.end
    degrees = value_of(angle) * 180 / arb.pi()
    return f"{float(degrees.mid()):.{DIGITS_OF_ANGLE}g} deg ({numbered})"


def amount(count, name):
    """1 turn, 2 turns."""
    return f"{count} {name}" if count == 1 else f"{count} {name}s"


def up_to(most, what):
    """So many of something, from one on, in words."""
    return f"1 {what}" if most == 1 else f"1 to {most} {what}s"


# -- 15. The command.


def main(arguments):
    """Check one file; print a line for each statement and return the exit code."""
    if len(arguments) != 1 or arguments[0].startswith("-"):
        say(__doc__)
        return 0 if arguments in (["-h"], ["--help"]) else 2
    ctx.prec = BITS
    try:
        return checked(certificate(arguments[0]))
    except NoCertificateError as error:
        fault = str(error)
    except OSError as error:
        fault = (
            f"cannot be read ({error.strerror}); `cam orbits --prove` writes out/orbits/proof.json"
        )
    except (ValueError, ArithmeticError, RecursionError, MemoryError) as error:
        fault = f"{type(error).__name__}: {error}"[:300]
    print(f"{arguments[0]}: no certificate: {fault}", file=sys.stderr)
    return 2


def certificate(path):
    """The content of a file, read in the form FILE; raises NoCertificateError where it has not."""
    with open(path, "rb") as file:
        data = file.read(LARGEST_FILE + 1)
    expect(len(data) <= LARGEST_FILE, "the file", "a smaller one")
    value = json.loads(data.decode("utf-8"), object_pairs_hook=single, parse_constant=no_number)
    content = read(value, FILE, "the file")
    has_cam = content.cam is not None or not content.statements
    expect(has_cam, "the file.cam", "a cam, as there are statements")
    return content


def single(pairs):
    """The entries of an object; refuse a key that stands there twice."""
    expect(len({key for key, _ in pairs}) == len(pairs), "an object", "each key once")
    return dict(pairs)


def no_number(word):
    """Refuse NaN and the infinities."""
    raise NoCertificateError(f"found {word}")


def checked(content):
    """Check statement by statement and say so; the exit code."""
    confirmed = 0
    count = len(content.statements)
    for statement in content.statements:
        try:
            STATEMENTS[statement.kind].check(content.cam, statement)
        except (RefusedError, NoCertificateError) as failed:
            say(f"not confirmed: {claim(statement, content.cam)}: {failed}")
        else:
            confirmed += 1
            say(f"confirmed: {claim(statement, content.cam)}")
    if count == 0:
        say(NOTHING)
    else:
        verb = "is" if confirmed == 1 else "are"
        say(f"{confirmed} of {amount(count, 'statement')} {verb} confirmed")
    for name in content.uncovered:
        say(f"without a certificate: {name}")
    if count == 0:
        return NO_STATEMENT
    return 0 if confirmed == count else 1


def say(line):
    """Print a line; where nobody reads on, the rest is checked all the same for its exit code."""
    try:
        print(line, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
