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
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from itertools import combinations_with_replacement, pairwise, product
from operator import add, mul, sub, truediv
from types import SimpleNamespace

from flint import arb, arb_mat, arb_series, ctx

BITS = 256  # of every ball
BITS_OF_COVER = 64  # of the balls of a cover, whose boxes are wide
ORDERS = (8, 16, 32, 64, 128)  # of the terms by which a step of a varying cam is bounded
TERMS = ORDERS[-1] + 2  # more than any series has
LARGEST_FILE = 400_000_000  # bytes
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
    """The angle of the vector (x, y)."""
    a, b = value_of(x), value_of(y)
    if not isinstance(x, arb_series) and not isinstance(y, arb_series):
        return arb.atan2(b, a)
    x, y = x + arb_series([0], TERMS), y + arb_series([0], TERMS)  # the one that is no series
    turning = (x * y.derivative() - y * x.derivative()) / (x * x + y * y)
    return turning.integral() + arb.atan2(b, a)


def exponential_rest(x, k):
    """The sum of x^j/(j + k)! over all j, for k = 1 or 2."""
    at = value_of(x)
    value = at.hypgeom_1f1(1, k + 1) / k
    if not isinstance(x, arb_series):
        return value
    slope = at.hypgeom_1f1(2, k + 2) / (4 * k - 2) * slope_of(x)
    return sloped(value, slope)


def radians(degrees):
    """Degrees to rad."""
    return ball_of(degrees) * arb.pi() / 180


# -- 2. The cam: smooth stretches, each a closed form. The numbers of these are formulas in the
# file, made of the numbers of the cam, one of which may be the parameter.


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
        """c and its derivatives by theta, up to `order` (3 at most), for all angles of a ball."""
        x = theta - self.center
        found = []
        terms = list(self.polynomial)
        for _ in range(order + 1):
            total = x * 0
            for a in reversed(terms):
                total = total * x + a
            found.append(total)
            terms = [j * terms[j] for j in range(1, len(terms))]
        if self.wave:
            a, b, k = self.wave
            sine, cosine = (x * k).sin_cos()
            for j in range(order + 1):
                found[j] += a * cosine + b * sine
                a, b = k * b, -(k * a)
        if self.circle:
            for j, more in enumerate(on_circle(x, *self.circle)[: order + 1]):
                found[j] += more
        return found


def on_circle(x, kappa, rho):
    """kappa cos x + sqrt(g), g = rho^2 - kappa^2 sin^2 x, and its three derivatives."""
    sine, cosine = x.sin_cos()
    double_sine, double_cosine = (2 * x).sin_cos()
    across = kappa * sine
    square = kappa * kappa
    g1, g2, g3 = -square * double_sine, -2 * square * double_cosine, 4 * square * double_sine
    root = (rho * rho - across * across).sqrt()
    root1 = g1 / (2 * root)
    root2 = (g2 - 2 * root1 * root1) / (2 * root)
    root3 = (g3 - 6 * root1 * root2) / (2 * root)
    return [kappa * cosine + root, root1 - across, root2 - kappa * cosine, root3 + across]


class Cam:
    """A cam: its numbers and, in `said`, the formulas of its stretches as they are in the file.

    The first stretch begins at 0, each other one where the one before it ends, the last at 2 pi.
    """

    def __init__(self, said):
        self.kind = said.kind
        self.numbers = said.numbers
        self.said = said
        self.stretches = self.made()

    def made(self, varied=None):
        """The stretches that have a length; varied: numbers by name that have another value."""
        names = {key: ball_of(x) for key, x in self.numbers.items()}
        names |= {"pi": arb.pi(), **(varied or {})}
        for one in self.said.formulas:
            names[one.name] = evaluated(one.formula, names)
        found = []
        start = arb(0)
        for one in self.said.stretches:
            end = evaluated(one.end, names)
            center = evaluated(one.center, names)
            polynomial, wave, circle = (
                [evaluated(x, names) for x in values]
                for values in (one.polynomial, one.wave, one.circle)
            )
            size = value_of(end) - value_of(start)
            fits = len(polynomial) > 0 and len(wave) in (0, 3) and len(circle) in (0, 2)
            if not (fits and (size > 0 or abs(size) < TINY)):
                raise NoCertificateError("cam: these numbers make no cam")
            if size > 0:
                found.append(Stretch(start, end, center, polynomial, wave, circle, one.seat))
            start = end
        if not abs(value_of(start) - 2 * arb.pi()) < TINY:
            raise NoCertificateError("cam: its stretches do not fill one turn")
        return found


def evaluated(term, names):
    """The value of a formula: a fraction, or the syntax tree of an expression of named numbers."""
    if isinstance(term, Fraction):
        return ball_of(term)
    if isinstance(term, ast.Constant) and type(term.value) is int:
        return arb(term.value)
    if isinstance(term, ast.Name) and term.id in names:
        return names[term.id]
    if isinstance(term, ast.UnaryOp) and isinstance(term.op, ast.USub):
        return -evaluated(term.operand, names)
    if isinstance(term, ast.BinOp) and type(term.op) in OPERATIONS:
        left, right = evaluated(term.left, names), evaluated(term.right, names)
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
    """Whether a derivative of the cam, or the cam itself (0), may jump from stretch to stretch.

    Balls that overlap show no jump, and a wide ball would hide one: it may not be wide either.
    """
    for k, there in enumerate(stretches):
        here = stretches[k - 1]
        end = here.derivatives(here.end, order)[order]
        start = there.derivatives(there.start, order)[order]
        if not (end.overlaps(start) and abs(end - start) < TINY):
            return True
    return False


TINY = arb(2) ** (64 - BITS)  # what the roundings of a cam's numbers stay below


# -- 3. A flight: q'' + 2 Z q' + W2 q + G = 0.


class Machine:
    """Cam and follower at one value of each parameter, or at all values of a ball.

    The numbers of a flight are balls, or series where a parameter is one.
    """

    def __init__(self, cam, constants, parameters=None):
        """constants: by name, None where they follow from the parameters, by name as well."""
        parameters = parameters or {}
        values = {name.removeprefix("cam."): p for name, p in parameters.items()}
        known = {key: ball_of(values.get(key) if x is None else x) for key, x in constants.items()}
        self.stretches = cam.stretches
        self.r_seat = ball_of(cam.said.seat_restitution)
        varied = of_cam(parameters)
        if varied:
            self.stretches = cam.made(varied)
            need(len(self.stretches) == len(cam.stretches), "the cam has other parts there")
            if cam.kind == "oscillator":
                frequency = {**cam.numbers, **varied}["frequency"]
                need(value_of(ball_of(frequency)) > 0, "the frequency is not positive")
                known["rpm"] = ball_of(frequency) * 30 / arb.pi()
        rpm, m, k, b, g, load, self.r = (known[key] for key in CONSTANTS)
        second = 30 / arb.pi() / rpm  # the time in which the cam turns by a radian
        self.W2, self.Z = k / m * (second * second), b / (2 * m) * second
        self.G = (g + load / m) * (second * second)
        self.sprung = constants["stiffness"] != 0
        self.damped = constants["damping"] != 0
        exact = [constants[key] for key in ("mass", "stiffness", "damping")]
        self.critical = None not in exact and exact[2] ** 2 == 4 * exact[0] * exact[1]
        square = 4 * (k * m) - b * b
        self.under = bool(value_of(square) > 0)
        if not self.critical:
            settled = self.under or value_of(square) < 0
            need(settled, "whether the follower is overdamped is open")
            self.f = (square if self.under else -square).sqrt() / (2 * m) * second

    def parts(self, s):
        """(B, B', P) after s rad: B solves it for G = 0, B(0) = 0, B'(0) = 1; P is its integral."""
        if self.damped and not self.sprung:
            x = -(2 * (self.Z * s))
            return s * exponential_rest(x, 1), x.exp(), s * s * exponential_rest(x, 2)
        decay = (-(self.Z * s)).exp() if self.damped else 1
        if self.critical:
            b, c = decay * s, decay
        elif self.under:
            sine, cosine = (self.f * s).sin_cos()
            b, c = decay * (sine / self.f), decay * cosine
        else:
            slow = ((self.f - self.Z) * s).exp()
            fast = (-((self.f + self.Z) * s)).exp()
            b, c = (slow - fast) / (2 * self.f), (slow + fast) / 2
        zb = self.Z * b
        return b, c - zb, (1 - c - zb) / self.W2 if self.sprung else s * s / 2

    def state(self, q, w, s):
        """(q, q', q'') after s rad of flight from (q, w)."""
        b, b1, p = self.parts(s)
        pull = self.G + self.W2 * q
        q, w = q + w * b - pull * p, w * b1 - pull * b
        return q, w, self.acceleration(q, w)

    def restitution(self, stretch):
        """That of an impact on a stretch: on the seat its own, where the file has one."""
        return self.r_seat if stretch.seat and self.r_seat is not None else self.r

    def acceleration(self, q, w):
        """q'' at a place and a rate."""
        return -(self.G + self.W2 * q + 2 * (self.Z * w))


def of_cam(parameters):
    """Those parameters, by name, that are numbers of the cam, by the names that they have there."""
    prefix = "cam."
    return {key.removeprefix(prefix): p for key, p in parameters.items() if key.startswith(prefix)}


# -- 4. An orbit: its equations, the box that holds it, and the gap in its flights.


class Orbit:
    """The orbits with impacts at certain places (stretch and turn), in so many turns.

    parameters: the names of one, or of two; then the orbits are those to which an event happens.
    """

    def __init__(self, cam, constants, parameters, places, turns, event=None):
        self.cam, self.constants, self.parameters = cam, constants, parameters
        self.places, self.turns, self.n, self.event = places, turns, len(places), event
        self.grazes = event is not None and event.event == "grazing"  # rad of flight: an unknown
        self.size = 2 * self.n + len(parameters) - 1 + self.grazes  # of equations; one unknown more
        need(self.n > 0, "an orbit without impacts is not checked here")
        count = len(cam.stretches)
        need(all(one.stretch < count for one in places), "the cam has no such stretch")
        # a period begins at the strobe, so that it may end a turn later than at the angle zero
        need(all(one.turn <= turns for one in places), "an impact lies beyond the period")
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
        """Where flight k meets the cam again: gap, its rate and acceleration, and their slopes; r.

        gap_by, rate_by: the slopes by theta and v of impact k. Moved with its impact, a flight
        starts by v dtheta lower, and by (c'' - q'') dtheta + dv faster. end: the phase within the
        turn at which it is looked at, that of the next impact if none is given.
        """
        after = (k + 1) % self.n
        end = z[2 * after] if end is None else end
        theta, v = z[2 * k : 2 * k + 2]
        c, c1, c2 = machine.stretches[self.places[k].stretch].derivatives(theta, 2)
        landing = machine.stretches[self.places[after].stretch]
        there = landing.derivatives(end, 2)
        s = end - theta + self.turned(k)
        q, w, a = machine.state(c, c1 + v, s)
        b, b1, p = machine.parts(s)
        lag = c2 - machine.acceleration(c, c1 + v)
        return SimpleNamespace(
            gap=q - there[0],
            rate=w - there[1],
            acceleration=a - there[2],
            gap_by=(lag * b - v * (1 - machine.W2 * p), b),
            rate_by=(lag * b1 + v * (machine.W2 * b), b1),
            r=machine.restitution(landing),
        )

    def equations(self, z, with_slopes):
        """(E, E') as matrices; E' only where it is asked for.

        Flight k gives E1, the gap where it ends, and E2 = r rate + v of the impact there.
        """
        values = []
        rows = []
        last = range(2 * self.n, len(z))
        along = [direction(z, j) for j in last] if with_slopes else [z]
        machines = [self.at(one) for one in along]
        for k in range(self.n):
            one, *others = (self.flight(machine, z, k) for machine in machines)
            after = 2 * ((k + 1) % self.n)
            gaps = [slope_of(x.gap) for x in (one, *others)]
            bounces = [x.r * x.rate + z[after + 1] for x in (one, *others)]
            r = value_of(one.r)
            values += [[value_of(one.gap)], [value_of(bounces[0])]]
            by_gap = [arb(0)] * (2 * self.n)
            by_bounce = [arb(0)] * (2 * self.n)
            for i in (0, 1):
                by_gap[2 * k + i] += value_of(one.gap_by[i])
                by_bounce[2 * k + i] += r * value_of(one.rate_by[i])
            by_gap[after] += value_of(one.rate)
            by_bounce[after] += r * value_of(one.acceleration)
            by_bounce[after + 1] += 1
            rows += [[*by_gap, *gaps], [*by_bounce, *map(slope_of, bounces)]]
        if self.event is not None:
            function = zero_at(self, self.event)
            values += [[value_of(x)] for x in function(z)]
            if with_slopes:
                columns = [function(direction(z, j)) for j in range(len(z))]
                rows += [list(map(slope_of, row)) for row in zip(*columns, strict=True)]
        return arb_mat(values), arb_mat(rows) if with_slopes else None

    def trace_det(self, z, times_rates=False):
        """Trace and determinant of the map of one period, and 1: a matrix of (dtheta, dv) a flight.

        times_rates: trace and 1 come times the rates at which all impacts meet the cam, and are not
        divided by any, so that they stay finite where one of these is zero.
        """
        machine = self.at(z)
        scale = arb(1)
        a, b, c, d = 1, 0, 0, 1  # the product [[a, b], [c, d]] so far
        det = (-(4 * arb.pi() * self.turns * machine.Z)).exp()
        for k in range(self.n):
            one = self.flight(machine, z, k)
            e, f, g, h = moves(one, times_rates)
            a, b, c, d = e * a + f * c, e * b + f * d, g * a + h * c, g * b + h * d
            scale = scale * one.rate if times_rates else scale
            det = det * one.r * one.r
        return a + d, det, scale

    def krawczyk(self, box):
        """Show that the box holds exactly one orbit for each eta; sets its hull and derivatives.

        A box holds the points z = middle + tangent eta + e, |eta| <= half and |e| <= error; the
        unknown `fixed` has the tangent 1 and the error 0, so that eta is how far it differs from
        its middle. With Y near the inverse of E' by the free unknowns, e is mapped by an orbit's
        equations to -Y E(middle) + (1 - Y E') e - Y E' tangent eta, which has to lie in the box.
        """
        size = self.size
        fixed = box.fixed
        lengths = {len(x) for x in (box.middle, box.tangent, box.error)}
        whole = lengths == {size + 1} and fixed <= size
        need(whole, "a box has not one entry for each unknown")
        shape = [len(row) for row in box.inverse]
        need(shape == [size] * size, "a matrix has not one row and column for each free unknown")
        need(box.half >= 0 and all(e >= 0 for e in box.error), "a box has a negative width")
        leans = box.tangent[fixed] == 1 and box.error[fixed] == 0
        need(leans, "a box does not lean along its unknown")
        free = [k for k in range(size + 1) if k != fixed]
        eta = around(0, box.half)
        error = [around(0, e) for e in box.error]
        wide = [m + t * eta + e for m, t, e in zip(box.middle, box.tangent, error, strict=True)]
        value, _ = self.equations(box.middle, False)
        _, slopes = self.equations(wide, True)
        y = arb_mat(box.inverse)
        by_free = y * arb_mat([[slopes[i, k] for k in free] for i in range(size)])
        leaning = y * (slopes * arb_mat([[t] for t in box.tangent])) * eta
        one = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
        off = arb_mat([[error[k]] for k in free])
        image = (one - by_free) * off - y * value - leaning
        for _ in range(3):  # of the orbit at eta = 0
            off = (one - by_free) * off - y * value
        box.reach = error
        box.center = list(box.middle)
        box.hull = list(box.middle)
        for row, k in enumerate(free):
            inside = error[k].contains_interior(image[row, 0])
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
        """Show that every orbit of a box is a motion; the impact `corner` may leave its stretch."""
        need(len(flights) == self.n, "not every impact has its flight")
        stretches = self.at(hull).stretches
        for k, place in enumerate(self.places):
            theta, v = hull[2 * k : 2 * k + 2]
            here = stretches[place.stretch]
            inside = k == corner or (here.start < theta and theta < here.end)
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
        machine, after = self.at(hull), (k + 1) % self.n
        theta, lands = hull[2 * k], hull[2 * after] + self.turned(k)
        need(lands > theta, f"flight {k + 1} ends before it begins")
        parts = self.divided(machine, k, flight.passages, theta, lands)
        rise, fall = flight.rise, len(parts) - flight.fall
        need(0 < rise <= fall < len(parts), f"flight {k + 1} does not rise first and fall last")
        c, c1 = machine.stretches[self.places[k].stretch].derivatives(theta, 1)
        w = c1 + hull[2 * k + 1]
        touch = theta + hull[-1] if self.grazes and k == self.event.impact else None
        for m, part in enumerate(parts):
            phase = part.start.union(part.end)
            x = phase.mid()
            h = phase - x
            q, q1, _ = machine.state(c, w, x - theta)
            lift, lift1 = part.stretch.derivatives(x - part.turn, 1)
            bend = machine.state(c, w, phase - theta)[2]
            bend -= part.stretch.derivatives(phase - part.turn, 2)[2]
            slope = q1 - lift1 + h * bend
            part.gain = slope * (part.end - part.start)  # of the gap
            if m == 0 and lifts:
                holds = bend > 0
            elif m < rise:
                holds = slope > 0
            elif m >= fall:
                holds = slope < 0
            elif touch is not None and part.start < touch and touch < part.end:
                place = flight.passages[part.passage]
                at = self.event.touch
                holds = (place.stretch, place.turn) == (at.stretch, at.turn) and bend > 0
            else:
                holds = q - lift + h * (q1 - lift1 + h * bend / 2) > 0
            need(holds, f"flight {k + 1} may meet the cam on its way")
        if self.cam.kind == "pieces":
            above_edges(k, parts[:rise], 1)
            above_edges(k, parts[fall:][::-1], -1)

    def divided(self, machine, k, passages, theta, lands):
        """The parts of flight k, in the turn of impact k: start and end, stretch and its turn, rad.

        A flight passes the stretches one after the other, and each passage is cut into parts.
        """
        count = len(machine.stretches)
        after = (k + 1) % self.n
        need(all(one.stretch < count for one in passages), "the cam has no such stretch")
        at = [one.stretch + count * one.turn for one in passages]
        ends = [one.stretch + count * one.turn for one in (self.places[k], self.places[after])]
        ends[1] += count * self.turns if after == 0 else 0
        right = at and [at[0], at[-1]] == ends and all(b == a + 1 for a, b in pairwise(at))
        need(right, f"flight {k + 1} does not pass stretch after stretch from impact to impact")
        parts = []
        for i, one in enumerate(passages):
            stretch = machine.stretches[one.stretch]
            turn = 2 * arb.pi() * (one.turn - passages[0].turn)
            start = theta if i == 0 else stretch.start + turn
            end = lands if i == len(passages) - 1 else stretch.end + turn
            points = [start, *(cut + turn for cut in one.cuts), end]
            parts += [
                SimpleNamespace(start=a, end=b, stretch=stretch, turn=turn, passage=i)
                for a, b in pairwise(points)
            ]
        return parts

    def along(self, box, function):
        """(value at the middle, slope on all of a box) of the numbers that a function of z has."""
        there = function([sloped(z, d) for z, d in zip(box.hull, box.slope, strict=True)])
        middle = function(box.center)
        return [(value_of(a), slope_of(b)) for a, b in zip(middle, there, strict=True)]

    def multipliers(self, box):
        """(trace, det) of all orbits of a box."""
        eta = around(0, box.half)
        return [value + slope * eta for value, slope in self.along(box, self.trace_det)[:2]]

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


def moves(one, times_rate=False):
    """[[e, f], [g, h]]: how (dtheta, dv) of an impact moves those of the next, by its flight.

    times_rate: all of it times the rate at which the flight ends.
    """
    over, rate = (1, one.rate) if times_rate else (one.rate, 1)
    e, f = (-(slope / over) for slope in one.gap_by)  # of the next phase
    g, h = (
        -(one.r * (by_start * rate + one.acceleration * by_phase))
        for by_start, by_phase in zip(one.rate_by, (e, f), strict=True)
    )
    return e, f, g, h


def possible(constants, missing):
    """Show that the constants are those of a machine, all but the missing ones."""
    wanted = {key for key, value in constants.items() if value is None}
    need(wanted == set(missing), "exactly the parameter has to be left open")
    known = {key: value for key, value in constants.items() if value is not None}
    need(all(known.get(key, 1) > 0 for key in ("rpm", "mass")), "speed or mass is not positive")
    negative = any(known.get(key, 0) < 0 for key in ("stiffness", "damping"))
    need(not negative, "a constant is negative")
    need(0 < known.get("restitution", 1) <= 1, "the restitution lies outside 0 to 1")


# -- 5. The statement `orbit`: for every value of the parameter from `low` to `high` the box holds
# exactly one orbit, which is a motion, has the label, and is stable or unstable.


def check_orbit(cam, said):
    """The only orbit in the box is a motion, and is stable or unstable."""
    orbit = only_one(cam, said)
    orbit.motion(said.box.hull, said.box.flights)
    orbit.steady(said.box, said.stable)
    named(said, said.box.hull)


def orbit_of(cam, said):
    """The orbits that a statement is about."""
    need(0 <= said.strobe < 360, "the strobe lies outside the turn")
    if said.kind == "curve":
        names = said.parameter, said.second
        return Orbit(cam, said.constants, names, said.impacts, said.turns, said.event)
    return Orbit(cam, said.constants, (said.parameter,), said.impacts, said.turns)


def only_one(cam, said):
    """The orbit of a statement, shown to be one for every value of the parameter in its range."""
    orbit = orbit_of(cam, said)
    box = said.box
    need(box.fixed == 2 * orbit.n, "the box of an orbit leans along the parameter")
    orbit.krawczyk(box)
    need(said.low <= said.high, "its range is empty")
    low = ball_of(said.low)
    middle = box.middle[-1]
    high = ball_of(said.high)
    covered = middle - box.half <= low and high <= middle + box.half
    need(covered, "its box does not cover the range of the parameter")
    return orbit


def labels(said, hull):
    """The labels that the orbits of a box may have: the impacts of each turn after the strobe.

    One that may lie on either side of the strobe is counted on both.
    """
    strobe = radians(said.strobe)
    sides = []  # of each impact: whether it lies before the strobe
    for theta in hull[: 2 * len(said.impacts) : 2]:
        known = theta < strobe or theta >= strobe
        sides.append([bool(theta < strobe)] if known else [True, False])
    open_sides = sum(len(one) > 1 for one in sides)
    need(open_sides <= MOST_AT_STROBE, "impacts may lie on either side of the strobe")
    names = set()
    for chosen in product(*sides):
        counts = [0] * said.turns
        for impact, before in zip(said.impacts, chosen, strict=True):
            counts[(impact.turn - before) % said.turns] += 1
        turned = max(counts[k:] + counts[:k] for k in range(said.turns))
        names.add(f"P({said.turns};{':'.join(map(str, turned))})")
    return sorted(names)


def counted(said, hull):
    """Show that the label is that of all orbits of a box."""
    names = labels(said, hull)
    need(names == [said.label], f"its label is {' or '.join(names)}")


def named(said, hull):
    """Show that the label is that of a box's orbits, and that none has a shorter period."""
    counted(said, hull)
    n = len(said.impacts)
    size = 2 * len(said.impacts)
    for turns in range(1, said.turns):
        if said.turns % turns == 0 and n * turns % said.turns == 0:
            step = 2 * (n * turns // said.turns)  # of the unknowns, from one period to the next
            apart = any(not hull[a].overlaps(hull[(a + step) % size]) for a in range(size))
            need(apart, f"it may be an orbit of {turns} turns gone through several times")


# -- 6. Of these, where the parameter is a number of the cam, where the cam is a fit, whose
# polynomials meet but for roundings, and where it has a seat.


def left_open(cam, constants, parameters):
    """The constants of the machine that follow from the parameters.

    An oscillator turns as fast as its force, and its mass, stiffness and damping are those of
    its cam too; they stand in both where they are no parameter.
    """
    names = {name.removeprefix("cam.") for name in parameters}
    need(len(names) == len(parameters), "its parameters are one number")
    numbers = set(of_cam(dict.fromkeys(parameters)))
    if not numbers:
        return names
    need(numbers <= set(cam.numbers), "the cam has no such number")
    known = all(isinstance(x, Fraction) for x in cam.numbers.values())
    known = known and not any(one.seat for one in cam.stretches)
    need(known, "the ends of the cam's stretches may vary with its numbers")
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

    By Taylor's theorem about the middle: all terms up to an order there, and the next one with its
    derivative taken over all of the box. A cam that is one wave has none whatever its numbers are.
    """
    varied = of_cam(dict(zip(orbit.parameters, orbit.values(box.hull), strict=True)))
    if not varied or is_one_wave(orbit.cam.made(varied)):
        return
    need(len(varied) == 1, "whether this cam has a step is not known over two of its numbers")
    ((name, p),) = varied.items()
    half = arb(p.rad())
    for order in ORDERS:
        middle = steps(orbit.cam.made({name: arb_series([p.mid(), 1], order)}), order)
        whole = steps(orbit.cam.made({name: arb_series([p, 1], order + 1)}), order + 1)
        bounds = [
            sum((abs(x) * half**j for j, x in enumerate([*near, far[order]])), arb(0))
            for near, far in zip(middle, whole, strict=False)
        ]
        if len(middle) == len(whole) and all(bound < TINY for bound in bounds):
            return
    raise RefusedError("the cam may have a step")


def is_one_wave(stretches):
    """Whether the cam is A cos x + B sin x beside a constant, so that a turn leads back to it."""
    one = stretches[0]
    if len(stretches) > 1 or one.circle or len(one.polynomial) > 1 or not one.wave:
        return False
    a, b, k = one.wave
    return k == 1 and (abs(a) + abs(b)) * abs(one.end - one.start - 2 * arb.pi()) < TINY


def steps(stretches, order):
    """How much higher each stretch begins than the one before it ends: terms of a series."""
    found = []
    for k, there in enumerate(stretches):
        here = stretches[k - 1]
        step = there.derivatives(there.start, 0)[0] - here.derivatives(here.end, 0)[0]
        series = arb_series([step], order) if isinstance(step, arb) else step
        found.append([series[j] for j in range(order)])
    return found


def above_edges(k, parts, sign):
    """Show that the gap stays above zero where stretches meet but for roundings.

    parts: those on which the gap rises, or, from the end on (sign -1), those on which it falls.
    """
    gap = arb(0)
    for one, other in pairwise(parts):
        gap += sign * one.gain
        if one.passage != other.passage:
            here, there = (one.stretch.end, other.stretch.start)
            if sign < 0:
                here, there = one.stretch.start, other.stretch.end
            gap += one.stretch.derivatives(here, 0)[0] - other.stretch.derivatives(there, 0)[0]
            need(gap > 0, f"flight {k + 1} may meet an edge of the cam")


def above_seat(stretches):
    """Whether the seat is level, and the cam nowhere below it by more than the roundings.

    A follower with lash rests on the higher one of cam and seat.
    """
    seats = [one for one in stretches if one.seat]
    level = all(not one.wave and not one.circle and len(one.polynomial) == 1 for one in seats)
    if not seats or not level:
        return level
    height = seats[0].polynomial[0]
    todo = [(one, one.start, one.end, 0) for one in stretches]
    while todo:
        one, start, end, depth = todo.pop()
        c = one.derivatives(start.union(end), 0)[0]
        if c > height - TINY and not (one.seat and c > height + TINY):
            continue
        if not one.seat and rises_from(one, start, end, height - TINY):
            continue
        if depth == BITS:
            return False
        middle = ((start + end) / 2).mid()
        todo += [(one, start, middle, depth + 1), (one, middle, end, depth + 1)]
        if len(todo) > BITS or c < height - TINY:
            return False
    return True


def rises_from(stretch, start, end, height):
    """Whether the cam is above a height between two angles, since it rises from one of them.

    By Taylor's theorem: a derivative is not negative between them, and all terms before it keep
    the cam above the height. Without lash the cam leaves its seat so, with slope zero.
    """
    between = start.union(end)
    last = 3 if stretch.circle else 4
    rates = stretch.derivatives(between, last)
    for at, way in ((start, end - start), (end, start - end)):
        total = arb(0)
        factorial = 1
        terms = stretch.derivatives(at, last)
        for order in range(last + 1):
            power = (-1) ** order if at is end else 1
            if order > 0 and power * rates[order] >= 0 and total > height:
                return True
            factorial *= max(order, 1)
            total += terms[order] * arb(0).union(way) ** order / factorial
    return False


# -- 7. The statement `attractor`: every motion with an impact in an ellipse about one of the
# orbit's tends to the orbit. The ellipse of impact k holds (theta, v) + M u, |u| <= 1, with
# M = [[a, b], [c, d]]. From each of its points the cam is met next within the next ellipse: the
# gap is above zero where that begins and below where it ends, and u is shorter there.


def check_attractor(cam, said):
    """The ellipses of an orbit are mapped into one another, and shrink."""
    orbit = only_one(cam, said)
    box = said.box
    axes = said.axes
    whole = len(axes) == orbit.n and all(len(one) == 4 for one in axes)
    need(whole, "not every impact has an ellipse")
    size = [(length(a, b), length(c, d)) for a, b, c, d in axes]
    wide = list(box.hull)
    for k, (by_theta, by_v) in enumerate(size):
        wide[2 * k] += around(0, by_theta)
        wide[2 * k + 1] += around(0, by_v)
    orbit.motion(wide, box.flights)
    named(said, box.hull)
    machine = orbit.at(box.hull)
    for k, (a, b, c, d) in enumerate(axes):
        after = (k + 1) % orbit.n
        for side in (-1, 1):
            end = box.hull[2 * after] + side * size[after][0]
            gap = orbit.flight(machine, box.hull, k, end).gap
            by_theta, by_v = orbit.flight(machine, wide, k, end).gap_by
            spread = length(by_theta * a + by_v * c, by_theta * b + by_v * d)
            need(-side * gap > spread, f"flight {k + 1} may land outside the next ellipse")
        need(area(axes[after]) > 0 or area(axes[after]) < 0, "an ellipse is flat")
        e, f, g, h = moves(orbit.flight(machine, wide, k))
        step = inverse(axes[after]) * arb_mat([[e, f], [g, h]]) * arb_mat([[a, b], [c, d]])
        left = arb_mat([[1, 0], [0, 1]]) - step.transpose() * step
        shrinks = left[0, 0] > 0 and left.det() > 0
        need(shrinks, f"flight {k + 1} may not come nearer to the orbit")


def length(x, y):
    """That of a vector."""
    return (x * x + y * y).sqrt()


def area(axes):
    """The determinant of M = [[a, b], [c, d]]."""
    a, b, c, d = axes
    return a * d - b * c


def inverse(axes):
    """The inverse of M."""
    a, b, c, d = axes
    return arb_mat([[d, -b], [-c, a]]) * (1 / area(axes))


# -- 8. The statement `event`: its function crosses zero in the box, where its slope along the
# branch is not zero, and the parameter there lies from `low` to `high`. At a doubling and a fold no
# other multiplier is on the unit circle; a corner impact has the signs of the products, over both
# sides of the corner, of 1 - trace + det and of 1 + trace + det.


def check_event(cam, said):
    """One event of an orbit, at a value of the parameter that is enclosed."""
    orbit = orbit_of(cam, said)
    box = said.box
    event = said.event
    orbit.krawczyk(box)
    corner = corner_of(orbit, event)
    orbit.motion(box.hull, box.flights, corner)
    crosses(orbit, box, event)
    named(said, box.hull)
    need(lies(box.hull[-1], said.low, said.high), "its parameter may lie elsewhere")
    if corner is not None:
        check_signs(orbit, said, corner)
        return
    need(said.signs == [], "it has more than its kind needs")
    if event.event != "multipliers-meet":
        need(other_inside(orbit, box, event), "another multiplier may lie on the unit circle")


def check_signs(orbit, said, corner):
    """The signs that a corner impact has, of (1 - trace + det) and (1 + trace + det).

    Each is multiplied over both sides of the corner: the impact is put on the stretch before it and
    on the one after it, and trace and determinant are those of the map with the impact there. There
    are no signs where the slope of the cam jumps at the corner.
    """
    side = said.event.side
    hull = said.box.hull
    places = orbit.places
    if kink(orbit, corner, side, hull):
        need(said.signs == [], "where the slope of the cam jumps a corner impact has no signs")
        return
    need(len(said.signs) == 2, "a corner impact has two signs")
    at_one = 1
    at_minus_one = 1
    count = len(orbit.cam.stretches)
    for step in (0, side):
        turn, stretch = divmod(places[corner].stretch + step, count)
        z = list(hull)
        moved = list(places)
        z[2 * corner] -= 2 * arb.pi() * turn
        moved[corner] = SimpleNamespace(stretch=stretch, turn=places[corner].turn + turn)
        orbit.places = moved
        trace, det, _ = orbit.trace_det(z)
        at_one = at_one * (1 - trace + det)
        at_minus_one = at_minus_one * (1 + trace + det)
    orbit.places = places
    for value, sign in zip((at_one, at_minus_one), said.signs, strict=True):
        need(sign != 0 and value * sign > 0, "a sign of a corner impact is another, or open")


def crosses(orbit, box, event):
    """Show that the event's function has one zero in a box, with a slope."""
    ((value, slope),) = orbit.along(box, zero_at(orbit, event))
    need(abs(value) < abs(slope) * box.half, "the function of an event may have no zero")


def zero_at(orbit, event):
    """The function of z that is zero at an event; on a curve times the rates of all impacts."""

    def function(z):
        if event.event == "corner-impact":
            stretches = orbit.at(z).stretches
            place = stretches[orbit.places[event.impact].stretch]
            return [z[2 * event.impact] - (place.end if event.side > 0 else place.start)]
        if event.event == "grazing":
            return touching(orbit, z, event)
        trace, det, one = orbit.trace_det(z, orbit.event is not None)
        if event.event == "multipliers-meet":
            return [trace * trace - 4 * det]
        return [one + one * det + (trace if event.event == "period-doubling" else -trace)]

    return function


def touching(orbit, z, event):
    """The slope of the gap and the gap, z[-1] rad after the impact that a graze comes after."""
    machine, k, at = orbit.at(z), event.impact, event.touch
    theta, v = z[2 * k : 2 * k + 2]
    c, c1 = machine.stretches[orbit.places[k].stretch].derivatives(theta, 1)
    q, q1, _ = machine.state(c, c1 + v, z[-1])
    phase = theta + z[-1] - 2 * arb.pi() * (at.turn - orbit.places[k].turn)
    lift, lift1 = machine.stretches[at.stretch].derivatives(phase, 1)
    return [q1 - lift1, q - lift]


def corner_of(orbit, event):
    """The impact that may lie beyond its stretch, or None."""
    if event is None:
        return None
    if event.event == "grazing":
        count = len(orbit.cam.stretches)
        well = event.touch is not None and event.impact < orbit.n and event.side == 0
        need(well and event.touch.stretch < count, "a graze names its flight and its stretch")
        return None
    if event.event != "corner-impact":
        need(event.impact == event.side == 0, "an event has more than its kind needs")
        return None
    well = event.impact < orbit.n and event.side != 0
    need(well, "a corner impact names its impact and side")
    return event.impact


def other_inside(orbit, box, event):
    """Whether the multiplier that does not cross at a doubling or a fold is inside."""
    trace, det = orbit.multipliers(box)
    other = trace if event.event == "fold" else -trace
    return det < 1 and other > -(1 + det)


def kink(orbit, k, side, z):
    """Whether the cam's slope jumps at the end (side 1) or the start of impact k's stretch.

    The pieces of a fit meet but for roundings. A seat with a restitution of its own is as good as
    a kink.
    """
    stretches = orbit.at(z).stretches
    index = orbit.places[k].stretch
    here, there = stretches[index], stretches[(index + side) % len(stretches)]
    if here.seat != there.seat and orbit.cam.said.seat_restitution is not None:
        return True
    ends = (here.end, there.start) if side > 0 else (here.start, there.end)
    one = here.derivatives(ends[0], 1)[1]
    other = there.derivatives(ends[1], 1)[1]
    if orbit.cam.kind == "pieces":
        return not abs(one - other) < ROUNDED_SLOPE
    return not one.overlaps(other)


def lies(x, low, high):
    """Whether a ball lies between two fractions."""
    return ball_of(low) <= x and x <= ball_of(high)


# -- 9. The statement `branch`: a curve of orbits on which the parameter takes every value between
# its two ends. Each box shares an orbit with the one before and the one after, a joint; the first
# and the last joint are the ends. At an end that is an event the function of the event has a slope
# in all of the box beside it, so that it has one sign between the event and the next joint.


def check_branch(cam, said):
    """Every box of a branch is a box of motions of one stability, and they are one curve."""
    orbit = orbit_of(cam, said)
    boxes = said.boxes
    joints = said.joints
    ends = said.ends
    need(len(ends) == 2, "a branch has two ends")
    one_chain(orbit, said)
    for claim, joint in ((said.low, joints[0]), (said.high, joints[-1])):
        there = len(claim) == 2 and lies(joint.hull[-1], *claim)
        need(there, "an end of the branch may lie elsewhere")
    need(said.low[1] <= said.high[0], "its range is empty")
    need(len(boxes) > 1 or None in ends, "one box can have one event only")
    for k, box in enumerate(boxes):
        event = None
        at = joints[k]
        after = joints[k + 1]
        if k == 0 and ends[0] is not None:
            event = ends[0]
        elif k == len(boxes) - 1 and ends[1] is not None:
            event = ends[1]
            at = joints[k + 1]
            after = joints[k]
        orbit.motion(box.hull, box.flights, corner_of(orbit, event))
        counted(said, box.hull)
        if event is None:
            orbit.steady(box, said.stable)
        else:
            check_end(orbit, said.stable, box, event, at, after)


def one_chain(orbit, said):
    """Show that the boxes of a branch or a curve hold one curve of orbits, with its label."""
    boxes = said.boxes
    joints = said.joints
    need(len(joints) == len(boxes) + 1 >= 2, "a chain has one joint more than boxes")
    for one in (*boxes, *joints):
        orbit.krawczyk(one)
    for k, box in enumerate(boxes):
        joins(box, joints[k])
        joins(box, joints[k + 1])
    named(said, joints[len(joints) // 2].hull)


def check_end(orbit, stable, box, event, at, after):
    """The box beside an event: the event is in the joint `at`, and `after` is on its right side."""
    crosses(orbit, at, event)
    ((_, slope),) = orbit.along(box, zero_at(orbit, event))
    inner = slope * (after.hull[box.fixed] - at.hull[box.fixed])
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


def check_curve(cam, said):
    """In every box of a curve all orbits are motions with the event, and they are one curve."""
    orbit, event = orbit_of(cam, said), said.event
    corner = corner_of(orbit, event)
    need(orbit.grazes or event.touch is None, "an event has more than its kind needs")
    one_chain(orbit, said)
    for claim, joint in ((said.begin, said.joints[0]), (said.end, said.joints[-1])):
        for x, there in zip(orbit.values(joint.hull), vars(claim).values(), strict=True):
            need(lies(x, there.low, there.high), "an end of the curve may lie elsewhere")
    for box in said.boxes:
        need(0 <= box.fixed - 2 * orbit.n < 2, "a box of a curve leans along a parameter")
        orbit.motion(box.hull, box.flights, corner)
        counted(said, box.hull)
        if event.event in ("period-doubling", "fold"):
            need(orbit.trace_det(box.hull)[1] < 1, "another multiplier may lie on the unit circle")


def joins(box, point):
    """Show that the orbits of a small box are those of a larger one that lie there."""
    eta = point.hull[box.fixed] - box.middle[box.fixed]
    need(abs(eta) <= box.half, "neighbouring boxes do not overlap")
    for k, z in enumerate(point.hull):
        off = z - box.middle[k] - box.tangent[k] * eta
        need(k == box.fixed or box.reach[k].contains(off), "neighbouring boxes do not overlap")


# -- 10. The statement `all-orbits`: the orbits that it names are all with so few impacts in so few
# turns. From c(a) to c(b), s = b - a rad later, exactly one solution of the flight's equation leads
# where B(s) > 0: it starts at the rate w = (c(b) - c(a) + (G + W2 c(a)) P)/B. So an orbit is its
# phases: those at which each impact's rates, out = w - c'(a) and into = w' - c'(b) of the flight
# before, make E = out + r into = 0. A cover has a tree of boxes of phases for each sequence of
# stretches: a letter for each box, before those of its two halves. The figure k: it is cut in half
# along phase k; a point: it holds no orbit; o: it holds none but a known one, the next in the list.


def check_all(cam, said):
    """The known orbits are all that there are with so few impacts in so few turns."""
    fixed = said.constants
    need(cam.kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    need(not any(one.seat for one in cam.stretches), "a cam with a seat has no such statement")
    possible(fixed, ())
    for k, one in enumerate(said.orbits):
        check_orbit(cam, one)
        same = {**fixed, "rpm": None} == one.constants and one.strobe == said.strobe
        same = same and one.parameter == "rpm"
        need(same, "an orbit is one of another machine")
        need(one.low <= fixed["rpm"] <= one.high, "an orbit is one of another speed")
        small = len(one.impacts) <= said.impacts and one.turns <= said.turns
        need(small, "an orbit is larger than those that are covered")
        again = any(may_be_one(one, other) for other in said.orbits[:k])
        need(not again, "an orbit may stand there twice")
    sizes = [(n, m) for m in range(1, said.turns + 1) for n in range(1, said.impacts + 1)]
    need([(one.impacts, one.turns) for one in said.covers] == sizes, "a cover is missing")
    try:
        cover = Cover(Machine(cam, fixed))
        for one in said.covers:
            check_cover(cover, one, said.orbits)
    finally:
        ctx.prec = BITS


def may_be_one(one, other):
    """Whether two statements may be about one orbit."""
    if len(one.impacts) != len(other.impacts) or one.turns != other.turns:
        return False
    here, there = one.box.hull[:-1], other.box.hull[:-1]
    turned = [there[2 * k :] + there[: 2 * k] for k in range(len(one.impacts))]
    return any(all(x.overlaps(y) for x, y in zip(here, z, strict=True)) for z in turned)


def check_cover(cover, said, orbits):
    """Show that the boxes of a cover, which are all, hold no orbit but those known."""
    n = said.impacts
    turns = said.turns
    count = len(cover.stretches)
    letters = iter(said.boxes)
    known = iter(said.orbits)
    for first in range(count):
        later = range(first, first + turns * count + 1)
        for rest in combinations_with_replacement(later, n - 1):
            boxes = [[(index, 0, 0) for index in (first, *rest)]]
            while boxes:
                box = boxes.pop()
                letter = next(letters, "")
                need(letter != "", "boxes are missing in a cover")
                if letter == ".":
                    need(cover.empty(box, turns), "a box of a cover may hold an orbit")
                elif letter == "o":
                    index = next(known, -1)
                    need(0 <= index < len(orbits), "a box names an orbit that is not there")
                    places = ways(orbits[index], n, turns, count)
                    alone = any(cover.alone(box, turns, one) for one in places)
                    need(alone, "a box may hold another orbit than the one it names")
                else:
                    k = int(letter) - 1
                    need(k < n, "a box is cut along a phase that it has not")
                    index, depth, i = box[k]
                    need(depth < 60, "a box is too small")
                    for half in (2 * i + 1, 2 * i):
                        boxes += [[*box[:k], (index, depth + 1, half), *box[k + 1 :]]]
    whole = next(letters, None) is None and next(known, None) is None
    need(whole, "a cover has too many boxes")


def ways(said, n, turns, count):
    """The ways to write an orbit as one of n impacts in so many turns: one from each impact on.

    The orbit is gone through as often as these turns hold it; there is no way where its impacts
    are not n then. A way is a list of (stretch, phase within the turn, rad); the stretches are
    counted on from turn to turn, `count` of them a turn.
    """
    times = turns // said.turns
    if times * said.turns != turns or times * len(said.impacts) != n:
        return []
    phases = said.box.hull[: 2 * len(said.impacts) : 2]
    own = [(one.stretch, one.turn, x) for one, x in zip(said.impacts, phases, strict=True)]
    found = []
    for k, (_, begun, _) in enumerate(own):
        next_period = [(stretch, turn + said.turns, x) for stretch, turn, x in own[:k]]
        found.append([
            (stretch + count * (turn - begun + again * said.turns), x)
            for again in range(times)
            for stretch, turn, x in [*own[k:], *next_period]
        ])  # fmt: skip
    return found


class Cell:
    """A part of one stretch of the cam in one of its turns: balls of the phase and of the lift.

    index: of the stretch, counted on from turn to turn; x: the phases, rad; c, c1, c2: the lift
    and its derivatives on all of them; middle: phase, lift and slope at one point, h: x less that.
    """

    def __init__(self, stretches, index, x):
        """x: phases within the turn, of the stretch or a little beyond it."""
        turn = index // len(stretches)
        stretch = stretches[index % len(stretches)]
        shift = 2 * arb.pi() * turn
        middle = x.mid()
        self.index = index
        self.own = x
        self.h = x - middle
        self.stretch = stretch
        at, at1 = stretch.derivatives(middle, 1)
        self.c, self.c1, self.c2 = stretch.derivatives(x, 2)
        self.c1 = self.c1.intersection(at1 + self.c2 * self.h)
        self.c = self.c.intersection(at + self.c1 * self.h)
        self.x = x + shift
        self.middle = (middle + shift, at, at1)


class Cover:
    """The flights between phases of the cam, by the two phases alone; each is looked at once."""

    STEPS = 8  # a flight is compared with the cam at the ends of so many equal parts
    SHORT = 0.6  # rad: of so short a flight its acceleration is looked at too

    def __init__(self, machine):
        self.machine = machine
        self.stretches = machine.stretches
        self.cells = {}
        self.flights = {}
        need(not jumps(self.stretches, 1), "the slope of the cam jumps")
        ctx.prec = BITS_OF_COVER
        self.longest = None  # rad, no flight is as long; None where there is no such bound
        self.least = arb(0)  # where B falls again with the length, no flight has a B below this
        if machine.sprung and not machine.critical and machine.under:
            self.bound()

    def bound(self):
        """How long a flight may be where the spring swings, and how small B where K < 0."""
        machine = self.machine
        parts = [self.cell((k, 5, i)) for k in range(len(self.stretches)) for i in range(32)]
        rest = [one.c + machine.G / machine.W2 for one in parts]
        low, high = arb(min(x.lower() for x in rest)), arb(max(x.upper() for x in rest))
        steepest = arb(max(abs(one.c1).upper() for one in parts))
        need(low > 0, "the follower may come to rest in flight, and flights may be long")
        self.longest = arb.pi() / machine.f
        if machine.r < 1:
            fastest = 2 * steepest + (machine.W2 * (high * high - low * low)).sqrt()
            self.least = low / (fastest * machine.r / (1 - machine.r) + steepest)

    def cell(self, key):
        """Part i of the 2^depth equal parts of a stretch, by (index, depth, i)."""
        if key not in self.cells:
            index, depth, i = key
            one = self.stretches[index % len(self.stretches)]
            ends = [one.start + (one.end - one.start) * k / 2**depth for k in (i, i + 1)]
            self.cells[key] = Cell(self.stretches, index, ends[0].union(ends[1]))
        return self.cells[key]

    def known(self, a, b):
        """`flight` of two cells by their keys."""
        if (a, b) not in self.flights:
            self.flights[a, b] = self.flight(self.cell(a), self.cell(b))
        return self.flights[a, b]

    def flight(self, a, b):
        """What the flights from one cell to another have in common; None where there is none.

        out, into: the rates at which they leave and meet the cam, None where nothing is known.
        slopes: of out by both phases, then of into, None where they are not known; middle: both
        between the cells' middles.
        """
        machine = self.machine
        s = b.x - a.x
        short = SimpleNamespace(out=None, into=None, slopes=None, middle=None)
        if s <= 0 or (self.longest is not None and s >= self.longest):
            return None
        if b.index - a.index <= 1:
            short = self.short(a, b, s)
        if short is None or not s > 0:
            return short
        big, rate, p = machine.parts(s)
        keeps = 1 - machine.W2 * p  # of the height above the spring's rest
        if keeps < 0 and big < self.least:
            return None
        if not big > 0:
            return short
        decay = (-(2 * (machine.Z * s))).exp()
        out = (b.c - a.c * keeps + machine.G * p) / big - a.c1
        into = (b.c * rate - a.c * decay + machine.G * (p * rate - big * big)) / big - b.c1
        if short.out is not None:
            out = out.intersection(short.out)
            into = into.intersection(short.into)
        (start, c, c1), (end, end_c, end_c1) = a.middle, b.middle
        big_there, rate_there, p = machine.parts(end - start)
        w = (end_c - c * (1 - machine.W2 * p) + machine.G * p) / big_there
        w_end = w * rate_there - (machine.G + machine.W2 * c) * big_there
        middle = w - c1, w_end - end_c1
        for _ in range(2):  # the mean value theorem, with slopes by out and into themselves
            leaves = a.c2 - machine.acceleration(a.c, a.c1 + out)
            lands = machine.acceleration(b.c, b.c1 + into) - b.c2
            slopes = (out * keeps / big - leaves, -into / big,
                      out * decay / big, lands - into * rate / big)  # fmt: skip
            out = out.intersection(middle[0] + slopes[0] * a.h + slopes[1] * b.h)
            into = into.intersection(middle[1] + slopes[2] * a.h + slopes[3] * b.h)
        if out <= 0 or into >= 0 or self.below(a, b, w, out, into, big):
            return None
        return SimpleNamespace(out=out, into=into, slopes=slopes, middle=middle)

    def below(self, a, b, w, out, into, big):
        """Whether all flights are below the cam at a phase on their way.

        w: the rate of the one between the cells' middles; moved to other ends, a flight is higher
        by -out B(b - x) exp(-2 Z (x - a))/B da - into B(x - a)/B db, with B of all of its way.
        """
        machine, (start, c, _), end = self.machine, a.middle, b.middle[0]
        for k in range(1, self.STEPS):
            phase = (start + (end - start) * k / self.STEPS).mid()
            lift = self.lift(phase)
            if lift is None or not (a.x < phase and phase < b.x):
                continue
            q = machine.state(c, w, phase - start)[0]
            since = phase - a.x
            by_end = -into * machine.parts(since)[0] / big
            decay = (-(2 * (machine.Z * since))).exp()
            by_start = -out * machine.parts(b.x - phase)[0] * decay / big
            if q + by_start * a.h + by_end * b.h < lift:
                return True
        return False

    def short(self, a, b, s):
        """The rates of flights on one stretch, or from one to the next; None if there are none.

        The gap is zero at both ends, so that out is -s/2 times a mean of its acceleration, and
        into s/2 times another; and where that is nowhere negative the gap is nowhere positive.
        """
        machine = self.machine
        nothing = SimpleNamespace(out=None, into=None, slopes=None)
        most = s.upper()
        if most > self.SHORT or not (self.longest is None or most < self.longest):
            return nothing
        big, rate, _ = machine.parts(most)
        if not (big > 0 and rate > 0):
            return nothing
        if a.index == b.index:
            _, c1, c2 = a.stretch.derivatives(a.own.union(b.own), 2)
        else:
            _, c1, c2 = a.stretch.derivatives(a.own.union(a.stretch.end), 2)
            _, d1, d2 = b.stretch.derivatives(b.own.union(b.stretch.start), 2)
            c1, c2 = c1.union(d1), c2.union(d2)
        time = arb(0).union(most)
        pull = machine.G + machine.W2 * a.c
        w = c1 * arb(1).union(most / big) + pull * time  # B is concave here: s/2 < P/B < s
        bend = machine.state(a.c, w, time)[2] - c2
        if bend >= 0:
            return None
        half = s / 2 if s > 0 else time / 2
        return SimpleNamespace(out=-half * bend, into=half * bend, slopes=None)

    def lift(self, phase):
        """c at a phase; None beside a corner."""
        phase = phase - 2 * arb.pi() * (phase / (2 * arb.pi())).floor()
        for one in self.stretches:
            if phase > one.start and phase < one.end:
                return one.derivatives(phase, 0)[0]
        return None

    def newton(self, flights, cells):
        """(E at the cells' middles, its derivatives on all of them) as matrices."""
        n, r = len(cells), self.machine.r
        values = arb_mat(n, 1)
        slopes = arb_mat(n, n)
        for k, (here, before) in enumerate(zip(flights, flights[-1:] + flights[:-1], strict=True)):
            values[k, 0] = here.middle[0] + r * before.middle[1]
            slopes[k, (k - 1) % n] += r * before.slopes[2]
            slopes[k, k] += r * before.slopes[3] + here.slopes[0]
            slopes[k, (k + 1) % n] += here.slopes[1]
        return values, slopes

    def later(self, key, turns):
        """The same cell some turns later."""
        return key[0] + turns * len(self.stretches), *key[1:]

    def empty(self, keys, turns):
        """Whether no orbit of so many turns has its impacts in these cells, one after the other.

        Of its flights the first one is the longest, or one of these.
        """
        n = len(keys)
        keys = [*keys, self.later(keys[0], turns)]
        cells = [self.cell(key) for key in keys]
        lengths = [b.x - a.x for a, b in pairwise(cells)]
        if any(one > lengths[0] for one in lengths[1:]):
            return True
        if n > 1 and n * lengths[0] < 2 * turns * arb.pi():
            return True
        flights = [self.known(a, b) for a, b in pairwise(keys)]
        if None in flights:
            return True
        for here, before in zip(flights, flights[-1:] + flights[:-1], strict=True):
            known = here.out is not None and before.into is not None
            if known and not (here.out + self.machine.r * before.into).contains(0):
                return True
        if any(one.slopes is None for one in flights):
            return False
        values, slopes = self.newton(flights, cells[:-1])
        off = arb_mat([[one.h] for one in cells[:-1]])
        if not all(x.contains(0) for x in (values + slopes * off).entries()):
            return True
        try:
            inverse = slopes.mid().inv().mid()
        except ZeroDivisionError:
            return False
        one = arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
        image = (one - inverse * slopes) * off - inverse * values
        pairs = zip(image.entries(), off.entries(), strict=True)
        return not all(x.overlaps(y) for x, y in pairs)

    def alone(self, keys, turns, orbit):
        """Whether the orbit's impacts are the only zero of E near cells, which it lies in or near.

        orbit: (index of the stretch, phases) of each of its impacts.
        """
        if [key[0] for key in keys] != [index for index, _ in orbit]:
            return False
        wide = [
            Cell(self.stretches, key[0], self.cell(key).own.union(theta))
            for key, (_, theta) in zip(keys, orbit, strict=True)
        ]
        last = Cell(self.stretches, self.later(keys[0], turns)[0], wide[0].own)
        flights = [self.flight(a, b) for a, b in pairwise([*wide, last])]
        if any(one is None or one.slopes is None for one in flights):
            return False
        _, slopes = self.newton(flights, wide)
        n = len(keys)
        try:
            off = slopes.mid().inv().mid() * slopes
        except ZeroDivisionError:
            return False
        rows = [sum(abs(off[i, j] - int(i == j)) for j in range(n)) for i in range(n)]
        return all(row < 1 for row in rows)


# -- 11. The statement `chaos`: every sequence of boxes along the coverings is that of a motion's
# impacts. A box holds the impacts (theta, v) = middle + M (x, y), |x|, |y| <= 1. It covers another
# one if all of its flights land at |y| < 1 there, those from x = -1 on one side of it, x < -1 or
# x > 1, and those from x = 1 on the other side. `weights` show that the number of sequences grows
# by `growth` from impact to impact, and its logarithm is at most the entropy.


def check_chaos(cam, said):
    """The boxes lie apart, cover one another as it is said, and their sequences grow."""
    boxes = said.boxes
    sizes = {len(box.middle) + len(box.axes) for box in said.boxes}
    need(sizes == {6}, "a box has not two numbers and four of its axes")
    need(said.low <= said.high, "its range is empty")
    for k, one in enumerate(boxes):
        need(area(one.axes) > 0 or area(one.axes) < 0, f"box {k + 1} is flat")
        for j, other in enumerate(boxes[:k]):
            apart = one.stretch != other.stretch or beside(one, other) or beside(other, one)
            need(apart, f"boxes {j + 1} and {k + 1} may overlap")
    pairs = {tuple(pair) for pair in said.coverings}
    well = all(len(pair) == 2 and max(pair) < len(boxes) for pair in pairs)
    need(well and len(pairs) == len(said.coverings), "its coverings are no pairs of boxes")
    for k in range(len(boxes)):
        check_covers(cam, said, k, [j for i, j in sorted(pairs) if i == k])
    weights = said.weights
    need(len(weights) == len(boxes) and min(weights) >= 0 < max(weights), "it has not its weights")
    need(said.growth > 1, "the number of sequences does not grow")
    for k, weight in enumerate(weights):
        grown = sum(weights[j] for i, j in pairs if i == k)
        need(grown >= said.growth * weight, "the number of sequences may grow more slowly")


def matrix(axes):
    """M = [[a, b], [c, d]]."""
    a, b, c, d = axes
    return arb_mat([[a, b], [c, d]])


def beside(one, other):
    """Whether a box lies on one side of another one, along one of its axes."""
    places = within(one, other.middle)
    reach = inverse(one.axes) * matrix(other.axes)
    return any(abs(places[k, 0]) > 1 + abs(reach[k, 0]) + abs(reach[k, 1]) for k in (0, 1))


def within(box, point):
    """(x, y) of a point (theta, v) about a box."""
    return inverse(box.axes) * arb_mat([[point[k] - box.middle[k]] for k in (0, 1)])


def check_covers(cam, said, k, over):
    """Show that box k covers those whose numbers are in `over`, by its cells.

    With the matrix D of the slopes of the impact map on a cell, a point of it lands at the image of
    the cell's middle + D times its distance from there.
    """
    one = said.boxes[k]
    lands = said.boxes[k].lands
    need(all(said.boxes[j].stretch == lands.stretch for j in over), "a flight lands on another box")
    places = [SimpleNamespace(stretch=one.stretch, turn=0), lands]
    orbit = Orbit(cam, said.constants, (said.parameter,), places, lands.turn + 1)
    sides: dict[int, set[bool]] = {j: set() for j in over}
    p = ball_of(said.low).union(ball_of(said.high))
    for edges, image, slopes, off in cells(orbit, one, p):
        for j in over:
            at = within(said.boxes[j], image)
            turned = inverse(said.boxes[j].axes) * slopes
            y = at[1, 0] + turned[1, 0] * off[0] + turned[1, 1] * off[1]
            need(abs(y) < 1, f"box {k + 1} may be mapped beside box {j + 1}")
            for edge in edges:
                x = at[0, 0] + turned[0, 0] * edge + turned[0, 1] * off[1]
                need(x < -1 or x > 1, f"an end of box {k + 1} may be mapped into box {j + 1}")
                sides[j].add((x > 0) == (edge > 0))
    for j in over:
        need(len(sides[j]) == 1, f"box {k + 1} is not mapped across box {j + 1}")


def cells(orbit, one, p):
    """The cells of a box: (edges, image, slopes, distances), each with its flights checked.

    edges: x of the ends of the box, from the cell's middle, where it is at an end; image: of that
    middle; slopes: by (x, y), of the landings of all of the cell; distances: what (x, y) may be.
    """
    machine = orbit.machine(p)
    axes = matrix(one.axes)
    need(len(one.cells) == 2, "a box is divided along both of its axes")
    across, along = one.cells
    need(len(one.flights) == across * along, "not every cell of a box has its flights")
    off = [around(0, 1 / arb(across)), around(0, 1 / arb(along))]
    spread = axes * arb_mat([[x] for x in off])
    for number, flight in enumerate(one.flights):
        i, j = divmod(number, along)
        at = axes * arb_mat([[arb(2 * i + 1) / across - 1], [arb(2 * j + 1) / along - 1]])
        middle = [one.middle[n] + at[n, 0] for n in (0, 1)]
        there = flight.low.union(flight.high)
        wide = [middle[0] + spread[0, 0], middle[1] + spread[1, 0], there, arb(1), p]
        for phase, place in zip((wide[0], there), orbit.places, strict=True):
            stretch = machine.stretches[place.stretch]
            inside = stretch.start < phase and phase < stretch.end
            need(inside, "a flight may begin or land outside its stretch of the cam")
        need(wide[1] > 0, "an impact may not bounce")
        orbit.clear(wide, 0, flight)
        for end, side in ((flight.low, 1), (flight.high, -1)):
            gap = orbit.flight(machine, middle, 0, end).gap
            by_theta, by_v = orbit.flight(machine, wide, 0, end).gap_by
            gap += by_theta * spread[0, 0] + by_v * spread[1, 0]
            need(side * gap > 0, "a flight may not land between the phases that are given")
        lands = landing(orbit, machine, middle, 0, there)
        need(lands is not None, "no landing was found")
        met = orbit.flight(machine, middle, 0, lands)
        speed = -(met.r * met.rate)
        by_theta, by_v, _, _ = moves(orbit.flight(machine, wide, 0))
        wide[2] = lands + by_theta * spread[0, 0] + by_v * spread[1, 0]
        e, f, g, h = moves(orbit.flight(machine, wide, 0))
        ends = [end for end, at_end in ((-1, i == 0), (1, i == across - 1)) if at_end]
        edges = [arb(end) / across for end in ends]
        yield edges, (lands, speed), arb_mat([[e, f], [g, h]]) * axes, off


def landing(orbit, machine, z, k, there):
    """The phase at which flight k lands, by Newton's interval method; None if it may lie elsewhere.

    there: the ball of phases in which it is, with a landing at each of its ends excluded.
    """
    rate = value_of(orbit.flight(machine, z, k, there).rate)
    lands = there.mid()
    for _ in range(10):  # towards the landing
        lands = (lands - value_of(orbit.flight(machine, z, k, lands).gap) / rate).mid()
    found = lands - value_of(orbit.flight(machine, z, k, lands).gap) / rate
    return found if there.contains(lands) and there.contains(found) else None


# -- 12. Loss of contact. The statement `first-detachment`: a follower that rests on the cam stays
# there at all speeds up to `low`, and not at `high`. The force of contact at the angular velocity
# omega is N = k c + m g + F0 + omega b c' + omega^2 m c''.


def check_detachment(cam, said):
    """The force is above zero all over the cam at all speeds up to `low`."""
    fixed = resting(cam, said)
    need(len(said.cuts) == len(cam.stretches), "not every stretch has its cuts")
    low, high = (ball_of(x) * arb.pi() / 30 for x in (said.low, said.high))
    m, k, b = (ball_of(fixed[key]) for key in ("mass", "stiffness", "damping"))
    level = m * ball_of(fixed["gravity"]) + ball_of(fixed["preload"])

    def force(omega, c):
        """The force less what is the same everywhere, N, by the lift and its derivatives."""
        return k * c[0] + omega * (b * c[1] + omega * m * c[2])

    for one, cuts in zip(cam.stretches, said.cuts, strict=True):
        for start, end in pairwise([one.start, *cuts, one.end]):
            need(start < end, "the cuts of a stretch do not follow one another")
            phase = start.union(end)
            c = one.derivatives(phase, 3)
            rising = force(low, c[1:])
            begins, ends = (level + force(low, one.derivatives(x, 2)) for x in (start, end))
            holds = (begins > 0 and rising > 0) or (ends > 0 and rising < 0)
            holds = holds or begins + (phase - start) * rising > 0
            # Between standstill and `low` it is least at one of both, or else above zero.
            least = fixed["damping"] == 0 or c[2] < 0 or level + force(arb(0).union(low), c) > 0
            holds = holds and least and level + force(arb(0), c) > 0
            need(holds, "the force may end at a lower speed")
    need(said.stretch < len(cam.stretches), "the cam has no such stretch")
    there = cam.stretches[said.stretch]
    phase = there.end if said.at_end else there.start
    need(level + force(high, there.derivatives(phase, 2)) < 0, "the force may not end")


def resting(cam, said):
    """The constants of a machine whose follower can rest all over the cam, at any speed."""
    need(cam.kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    need(not any(one.seat for one in cam.stretches), "a cam with a seat has no such statement")
    need(not jumps(cam.stretches, 1), "the slope of the cam jumps")
    possible(said.constants, ("rpm",))
    need(0 < said.low < said.high, "its range is empty")
    return said.constants


# The statement `corner-hit`: a follower that rests on the cam leaves it at the start of the stretch
# `start`. The flight after its last impact in `impacts` is followed to the end of the stretch
# `corner`, where the gap has one sign at `low`, the other at `high`, and a slope by the speed
# between them: so that impact is at the corner at exactly one speed.


def check_corner_hit(cam, said):
    """The impact after those that are given lands on a corner at one speed."""
    resting(cam, said)
    stretches = cam.stretches
    need(len(said.flights) == len(said.impacts) + 1, "not every impact has its flight")
    need(max(said.start, said.corner.stretch) < len(stretches), "the cam has no such stretch")
    places = [SimpleNamespace(stretch=said.start, turn=0), *said.impacts, said.corner]
    turns = 1 + max(one.turn for one in places)
    orbit = Orbit(cam, said.constants, ("rpm",), places, turns)
    low, high = ball_of(said.low), ball_of(said.high)
    machine = orbit.machine(low.union(high))
    theta = stretches[said.start].start
    before = stretches[said.start - 1]
    for one, at, sign in ((before, before.end, -1), (stretches[said.start], theta, 1)):
        c, c1, c2 = one.derivatives(at, 2)
        leaves = sign * (machine.acceleration(c, c1) - c2) > 0
        need(leaves, "the follower may not leave there")
    _, _, gap = flown(orbit, said, low)
    _, _, later = flown(orbit, said, high)
    hull, spans, between = flown(orbit, said, low.union(high))
    for k in range(orbit.n - 1):
        at = list(hull)
        at[2 * k + 2] = spans[k]
        if k > 0:
            place = stretches[places[k].stretch]
            inside = place.start < spans[k - 1] and spans[k - 1] < place.end
            need(inside, f"impact {k} may lie outside its stretch of the cam")
            need(hull[2 * k + 1] > 0, f"impact {k} may not bounce")
        orbit.clear([*at, low.union(high)], k, said.flights[k], lifts=k == 0)
    one = value_of(gap)
    other = value_of(later)
    slope = slope_of(between)
    need((one > 0 and other < 0) or (one < 0 and other > 0), "the corner may not be met")
    need(slope > 0 or slope < 0, "the corner may be met at several speeds")


def flown(orbit, said, speed):
    """Unknowns of all impacts from lift-off on, the last phase of each flight, the last gap.

    At all speeds of a ball; the gap, at the corner, has its derivative by the speed.
    """
    machine = orbit.machine(sloped(speed, 1))
    z = [sloped(orbit.cam.stretches[said.start].start, 0), sloped(0, 0)]
    spans = []
    for k, one in enumerate(said.impacts):
        there = one.low.union(one.high)
        for end, sign in ((one.low, 1), (one.high, -1)):
            gap = value_of(orbit.flight(machine, z, k, end).gap)
            need(sign * gap > 0, f"impact {k + 1} may lie elsewhere")
        phase = landing(orbit, machine, z, k, there)
        need(phase is not None, f"impact {k + 1} may lie elsewhere")
        met = orbit.flight(machine, z, k, phase)
        theta = sloped(phase, -(slope_of(met.gap) / value_of(met.rate)))
        met = orbit.flight(machine, z, k, theta)
        z += [theta, -(met.r * met.rate)]
        spans.append(there)
    corner = orbit.cam.stretches[said.corner.stretch].end
    gap = orbit.flight(machine, z, orbit.n - 2, corner).gap
    return [value_of(x) for x in z] + [corner, arb(0)], [*spans, corner], gap


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
    """The cam; None where the file has none."""
    if value is None:
        return None
    cam = Cam(read(value, CAM, where))
    if cam.kind != "pieces" and jumps(cam.stretches, 0):  # steps of a fit: see `above_edges`
        raise NoCertificateError(f"{where}: these numbers make no cam, it has a step")
    expect(above_seat(cam.stretches), where, "a seat that is level, and nothing below it")
    own = cam.said.seat_restitution
    expect(own is None or 0 < own <= 1, where, "a restitution from 0 to 1 on the seat")
    return cam


def statement(value, where, kinds=None):
    """A statement by its kind, one of some."""
    kind = value.get("kind") if isinstance(value, dict) else None
    kind = read(kind, kinds or tuple(STATEMENTS), f"{where}.kind")
    return read(value, {"kind": text, **STATEMENTS[kind][1]}, where)


def known_orbit(value, where):
    """A statement on an orbit, within another statement."""
    return statement(value, where, ("orbit",))


def event_at_end(value, where):
    """The event at which a branch ends, or None."""
    return None if value is None else read(value, {**EVENT, "event": ENDS}, where)


NUMBER = re.compile(r"-?[0-9]{1,400}(\.[0-9]{1,1200})?(e-?[0-9]{1,3})?")
FORMULA, NAME = re.compile(r"[A-Za-z0-9_+*/(), -]{1,2000}"), re.compile(r"[A-Za-z]\w{0,40}")
TREE = re.compile(r"[.o1-9]{1,20000000}")
INDEX, SIGN, SMALL = range(1_000_001), range(-1, 2), range(1, 10)
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
ENDS = "period-doubling", "fold", "corner-impact"  # events at which a branch may end, or of a curve
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
STATEMENTS = {  # of each kind: how it is checked, and its keys
    "orbit": (check_orbit, {**OF_ORBIT, **RANGE, "stable": truth, "box": BOX}),
    "attractor": (check_attractor, {**OF_ORBIT, **RANGE, "box": BOX, "axes": [[ball]]}),
    "event": (check_event, {**OF_ORBIT, **RANGE, "box": BOX, "event": EVENT, "signs": [SIGN]}),
    "branch": (check_branch, {**OF_ORBIT, "low": [exact], "high": [exact], "stable": truth,
                              "ends": [event_at_end], "boxes": [BOX], "joints": [POINT]}),
    "curve": (check_curve, {**OF_ORBIT, "second": parameter, "event": EVENT_OF_CURVE,
                            "begin": END, "end": END, "boxes": [BOX], "joints": [POINT]}),
    "all-orbits": (check_all, {"constants": constants, "strobe": exact, "impacts": SMALL,
                               "turns": SMALL, "orbits": [known_orbit], "covers": [COVER]}),
    "chaos": (check_chaos, {**RANGE, "parameter": CONSTANTS, "constants": constants,
                            "boxes": [SECTION], "coverings": [[INDEX]], "growth": exact,
                            "weights": [exact]}),
    "first-detachment": (check_detachment, {**RANGE, "constants": constants, "stretch": INDEX,
                                            "at_end": truth, "cuts": [[ball]]}),
    "corner-hit": (check_corner_hit, {**RANGE, "constants": constants, "start": INDEX,
                                      "impacts": [{**PLACE, **dict.fromkeys(RANGE, ball)}],
                                      "corner": PLACE, "flights": [FLIGHT]}),
}  # fmt: skip
FILE = {"format": ("camcli-proof-1",), "cam": cam_of, "statements": [statement],
        "uncovered": [text]}  # fmt: skip


# -- 14. What is said of each statement, in words; ranges of orbits are rounded inwards, those of
# events outwards, so that no more is said than was shown.


def claim(said, cam):
    """What a statement says."""
    if said.kind == "all-orbits":
        names = [f"{one.label}, {state(one)}" for one in said.orbits]
        rpm = "open" if said.constants["rpm"] is None else in_full(said.constants["rpm"])
        size = f"{up_to(said.impacts, 'impact')} in {up_to(said.turns, 'turn')}"
        return (f"at rpm = {rpm} the orbits without rest that have {size} are {len(names)}: "
                f"{'; '.join(names) or 'none'}")  # fmt: skip
    if said.kind == "branch":
        ends = [shown(x, ROUND_CEILING) for x in said.low[-1:]]
        ends += [shown(x, ROUND_FLOOR) for x in said.high[:1]]
        return (f"{said.label} exists and is {state(said)} for all {said.parameter} "
                f"between {' and '.join(ends)}")  # fmt: skip
    if said.kind == "curve":
        return (f"{said.event.event} of {said.label} all along a curve without a gap from "
                f"{end_name(said, said.begin)} to {end_name(said, said.end)}")  # fmt: skip
    low, high = shown(said.low, ROUND_FLOOR), shown(said.high, ROUND_CEILING)
    if said.kind == "event":
        return f"{said.event.event} of {said.label}, {said.parameter} from {low} to {high}"
    if said.kind == "first-detachment":
        return (f"a follower that rests on the cam stays there at every rpm up to {low}, "
                f"and leaves it at {high}")  # fmt: skip
    if said.kind == "corner-hit":
        leaves = corner_name(cam, said.start, "start")
        lands = corner_name(cam, said.corner.stretch, "end")
        impact = f"its impact {len(said.impacts) + 1} is at {lands}"
        return (f"a follower that rests on the cam leaves it at {leaves}, and {impact}, "
                f"for exactly one rpm from {low} to {high}")  # fmt: skip
    every = f"for every {said.parameter} {span(said)}"
    if said.kind == "orbit":
        return f"{said.label}, {state(said)}, {every}: exactly one in its box"
    if said.kind == "attractor":
        size = ""
        if said.axes and len(said.axes[0]) == 4:
            a, b, c, d = said.axes[0]
            by_theta, by_v = at_least(length(a, b) * 180 / arb.pi()), at_least(length(c, d))
            size = f", {by_theta} deg and {by_v} m/rad to either side,"
        return (f"every motion with an impact in an ellipse about impact 1 of {said.label}{size} "
                f"tends to it, {every}")  # fmt: skip
    turns = max([1, *(box.lands.turn for box in said.boxes)])
    return (f"chaos {every}: {len(said.boxes)} boxes of impacts with {len(said.coverings)} "
            "coverings, so infinitely many periodic orbits and an entropy of the impact map of at "
            f"least log({shown(said.growth, ROUND_FLOOR)}); from one impact to the next at most "
            f"{turns} {'turn passes' if turns == 1 else 'turns pass'}")  # fmt: skip


def end_name(said, end):
    """An end of a curve in both parameters: one that is enclosed rounded outwards."""
    texts = []
    for name, x in ((said.parameter, end.parameter), (said.second, end.second)):
        text = f"[{shown(x.low, ROUND_FLOOR)}, {shown(x.high, ROUND_CEILING)}]"
        texts.append(f"{name} = {in_full(x.low) if x.low == x.high else text}")
    return ", ".join(texts)


def state(said):
    """The stability that a statement claims."""
    return "stable" if said.stable else "unstable"


def shown(x, way, digits=SHOWN):
    """A fraction to so many digits, rounded down or up."""
    context = Context(prec=digits, rounding=way)
    return str(context.divide(Decimal(x.numerator), Decimal(x.denominator)))


def in_full(x):
    """A fraction whose decimals end, with all of them."""
    return str(Context(prec=3000).divide(Decimal(x.numerator), Decimal(x.denominator)))


def span(said):
    """From where to where a statement holds: rounded inwards, or in full where that leaves none."""
    low, high = shown(said.low, ROUND_CEILING), shown(said.high, ROUND_FLOOR)
    if Decimal(low) > Decimal(high):
        low, high = in_full(said.low), in_full(said.high)
    return f"from {low} to {high}"


def at_least(x):
    """A number to few digits that is no larger than any in a ball."""
    mantissa, exponent = x.lower().man_exp()
    least = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return shown(least, ROUND_FLOOR, DIGITS_OF_SIZE)


def corner_name(cam, index, end):
    """The `start` or the `end` of a stretch by its angle, deg, and its number in the file."""
    named = f"the {end} of stretch {index}"
    if index >= len(cam.stretches):
        return named
    angle = value_of(getattr(cam.stretches[index], end)) * 180 / arb.pi()
    return f"{float(angle.mid()):.{DIGITS_OF_ANGLE}g} deg ({named})"


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
    """The content of a file, in its form."""
    with open(path, "rb") as file:
        data = file.read(LARGEST_FILE + 1)
    expect(len(data) <= LARGEST_FILE, "the file", "a smaller one")
    value = json.loads(data.decode("utf-8"), object_pairs_hook=single, parse_constant=no_number)
    found = read(value, FILE, "the file")
    fits = found.cam is not None or not found.statements
    expect(fits, "the file.cam", "a cam, as there are statements")
    return found


def single(pairs):
    """The entries of an object; refuse a key that stands there twice."""
    expect(len({key for key, _ in pairs}) == len(pairs), "an object", "each key once")
    return dict(pairs)


def no_number(word):
    """Refuse NaN and the infinities."""
    raise NoCertificateError(f"found {word}")


def checked(found):
    """Check statement by statement and say so; the exit code."""
    confirmed = 0
    count = len(found.statements)
    for said in found.statements:
        check = STATEMENTS[said.kind][0]
        try:
            check(found.cam, said)
        except (RefusedError, NoCertificateError) as failed:
            say(f"not confirmed: {claim(said, found.cam)}: {failed}")
        else:
            confirmed += 1
            say(f"confirmed: {claim(said, found.cam)}")
    if count == 0:
        say(NOTHING)
    else:
        say(f"{confirmed} of {count} statements are confirmed")
    for name in found.uncovered:
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
