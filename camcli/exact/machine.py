"""A machine at one speed in balls: its cam, its flight, the force of contact.

The numbers of a scene are taken as the doubles they are, and what follows from them exactly: the
angles of tangency of three circles, omega = rpm pi/30. Equations and units are those of
`kernel.flow`: the angle s of the cam is the variable, lengths are in m.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ulp
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series

from camcli.cams import balls
from camcli.cams.balls import UndecidedError, derivatives, head
from camcli.cams.compile import Part, Piece, Shape
from camcli.cams.taylor import Taylor
from camcli.system import Follower

NEAR_CRITICAL = 2.0**-10  # |b^2 - 4 k m| over b^2: of less, what its root divides is a wide ball


class Place(NamedTuple):
    """A stretch of the cam in one of its turns, both counted from 0."""

    stretch: int
    turn: int

    def next(self, count: int) -> Place:
        """The stretch behind this one, of `count` on the cam; behind the last one the first."""
        if self.stretch + 1 < count:
            return Place(self.stretch + 1, self.turn)
        return Place(0, self.turn + 1)


def identity(size: int) -> arb_mat:
    """The matrix with ones on its diagonal."""
    return arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])


@dataclass(frozen=True)
class BallStretch:
    """A smooth part of the cam between two angles (rad) of the turn.

    lift: c (m) as a function of the angle, None where it is `level` all over; slopes: the function
    that gives [c, c', c'', c'''], where the cam has one; varies: whether a number of the cam is a
    series, in which its lift and its ends are series too.
    """

    start: Any
    end: Any
    lift: Callable[[Any], Any] | None
    level: Any
    slopes: Callable[[Any], list[Any]] | None = None
    seat: bool = False
    varies: bool = False

    def derivatives(self, theta: Any, order: int) -> list[Any]:
        """[c, c', ...] by theta (rad) up to the derivative of an order, m.

        theta may be a ball, for all of whose angles the values hold. Where the cam varies they are
        series, with the derivative by what varies.
        """
        if self.lift is None:
            return [self.level, *[arb(0)] * order]
        if order == 0:
            return [self.lift(theta)]
        if self.slopes is not None and order <= 3:
            return self.slopes(theta)[: order + 1]
        if self.varies:
            return self.lift(Taylor.variable(theta, order)).derivatives()
        return derivatives(self.lift, theta, order)


class BallMachine:
    """The follower's constants per rad of cam angle, and the cam's stretches.

    In flight q'' + 2 Z q' + W^2 q + G = 0, with W2 = k/(m omega^2), Z = b/(2 m omega) and G = (g +
    F0/m)/omega^2. r, r_seat: restitution on the cam and on its seat. over: whether it is
    overdamped; near_critical: whether that is open, or Z^2 - W^2 so small that what its root
    divides is a wide ball: square = Z^2 - W^2 is known then, and not frequency = sqrt(|square|).
    turn: 2 pi.

    It is one machine, or all of a range of speeds at once (`within_last_digit`). Of a range,
    `center` is the machine at the middle speed, `slopes` the machine whose numbers are series in
    the speed, with their derivatives by it, and `width` half the width of the range, rpm. One
    machine is its own center, and its width is zero.
    """

    def __init__(
        self,
        cam: Shape | list[BallStretch],
        follower: Follower,
        rpm: Any,
        share: Fraction | int = 0,
    ):
        """At the speed rpm (1 + share). The constants may be doubles, balls or series of balls."""
        m = balls.number(follower.mass)
        k = balls.number(follower.stiffness)
        b = balls.number(follower.damping)
        gravity = balls.number(follower.gravity)
        preload = balls.number(follower.preload)
        self.r = balls.number(follower.restitution)
        self.r_seat = self.r
        if follower.seat_restitution is not None:
            self.r_seat = balls.number(follower.seat_restitution)
        omega = balls.number(rpm) * balls.number(1 + share) * arb.pi() / 30  # rad/s
        self.W2 = k / m / (omega * omega)
        self.Z = b / (2 * m) / omega
        self.Z2 = 2 * self.Z
        self.G = (gravity + preload / m) / (omega * omega)
        self.undamped = isinstance(b, arb) and b == 0
        self.springless = isinstance(k, arb) and k == 0
        self.free = self.undamped and self.springless
        self.sprung = head(self.W2) > 0 or head(self.W2) < 0
        discriminant = b * b - 4 * k * m  # of m x^2 + b x + k
        near = NEAR_CRITICAL * head(b) * head(b)
        self.over = head(discriminant) > near
        under = head(discriminant) < -near
        self.near_critical = not (self.over or under)
        if self.near_critical:
            self.square = discriminant / (4 * m * m * omega * omega)
        else:
            size = discriminant if self.over else -discriminant
            self.frequency = size.sqrt() / (2 * m * omega)
        self.turn = 2 * arb.pi()
        self.stretches = cam if isinstance(cam, list) else stretches_of(cam)
        self.center = self
        self.slopes = self
        self.width = 0.0

    @classmethod
    def within_last_digit(cls, shape: Shape, follower: Follower, rpm: float) -> BallMachine:
        """Every machine at once whose speed rounds to rpm."""
        center = cls(shape, follower, rpm)
        width = ulp(rpm) / 2
        speeds = arb(rpm, width)
        machine = cls(center.stretches, follower, speeds)
        machine.center = center
        machine.width = width
        machine.slopes = cls(center.stretches, follower, arb_series([speeds, 1], 2))
        return machine

    def restitution(self, i: int) -> Any:
        """The coefficient of restitution on stretch i: that of the cam, or of its seat."""
        return self.r_seat if self.stretches[i].seat else self.r

    def drift(self, q: arb, w: arb, s: arb) -> arb_mat:
        """How far the speeds of these machines spread (q, w) after s rad of flight, m and m/rad.

        It is the derivative of (q, w) by the speed, times half the width of the speeds. The
        machine `slopes` has a series for a speed, so q and w are series, and entry 1 of a series is
        the derivative.
        """
        if self.width == 0.0:
            return arb_mat(2, 1)
        after: Any = self.slopes.move(q, w, s)
        q_series = after[0]
        w_series = after[1]
        return arb_mat([[q_series[1] * self.width], [w_series[1] * self.width]])

    def flow(self, s: arb) -> tuple[arb, arb, arb]:
        """(B, B', P) after s rad of flight: q = q0 + w0 B - F P, w = w0 B' - F B, F = G + W^2 q0.

        With e = exp(-Z s) and f^2 = |Z^2 - W^2|: B = e sin(f s)/f, C = e cos(f s) below critical
        damping, B = (e1 - e2)/(2 f), C = (e1 + e2)/2 above, where e1,2 = exp((+-f - Z) s), and
        B = e S(x) s, C = e cosh(sqrt x), x = (Z^2 - W^2) s^2, S(x) = sinh(sqrt x)/sqrt x where
        that may be zero. B' = C - Z B, P = (1 - C - Z B)/W^2; see `_integral_of_b` where W may
        be zero.
        """
        if self.over:
            f = self.frequency
            slow = ((f - self.Z) * s).exp()
            fast = ((-f - self.Z) * s).exp()
            b = (slow - fast) / (2 * f)
            c = (slow + fast) / 2
        elif self.free:
            b = s
            c = arb(1)
        elif self.near_critical:
            x = self.square * s * s
            b = _sinh_over_root(x) * s
            c = _cosh_of_root(x)
        else:
            sine, c = (self.frequency * s).sin_cos()
            b = sine / self.frequency
        if self.undamped:
            return b, c, (1 - c) / self.W2 if self.sprung else self._integral_of_b(s)
        if not self.over:
            decay = (-self.Z * s).exp()
            b = decay * b
            c = decay * c
        zb = self.Z * b
        p = (1 - c - zb) / self.W2 if self.sprung else self._integral_of_b(s)
        return b, c - zb, p

    def _integral_of_b(self, s: arb) -> arb:
        """P = the integral of B where W may be zero; raises UndecidedError.

        Undamped that is S(-(W s/2)^2)^2 s^2/2. With W = 0 it is D(-2 Z s) s^2, D(x) = (E(x) - 1)/x
        and E(x) = (exp x - 1)/x; overdamped (E((f - Z) s) - E(-(f + Z) s)) s/(2 f).
        """
        if self.free:
            return s * s / 2
        if self.undamped:
            half = _sinh_over_root(-self.W2 * s * s / 4)
            return half * half * s * s / 2
        if self.springless:
            return _quotient_of_quotient(-self.Z2 * s) * s * s
        if self.over:
            slow = (self.frequency - self.Z) * s
            fast = (-self.frequency - self.Z) * s
            return (_exp_quotient(slow) - _exp_quotient(fast)) * s / (2 * self.frequency)
        raise UndecidedError

    def move(self, q: arb, w: arb, s: arb, order: int = 3) -> list[arb]:
        """q (m) and its derivatives by the angle up to `order`, 2 or 3, after s rad of flight.

        The flight begins at the height q (m) with the rate w (m/rad).
        """
        b, b1, p = self.flow(s)
        pull = self.G + self.W2 * q
        height = q + w * b - pull * p
        rate = w * b1 - pull * b
        accel = -(self.G + self.W2 * height)
        if not self.undamped:
            accel -= self.Z2 * rate
        if order == 2:
            return [height, rate, accel]
        jerk = -self.W2 * rate
        if not self.undamped:
            jerk -= self.Z2 * accel
        return [height, rate, accel, jerk]

    def force(self, c: list[arb]) -> list[arb]:
        """[N, N', N''] of the contact at rest over m omega^2: N = G + W^2 c + 2 Z c' + c''.

        c: the lift and its derivatives up to the fourth.
        """
        varying = [self.W2 * c[k] + 2 * self.Z * c[k + 1] + c[k + 2] for k in range(3)]
        return [self.G + varying[0], varying[1], varying[2]]


def _cosh_of_root(x: Any) -> Any:
    """cosh(sqrt x) of a ball or of a series of two coefficients; entire, cos(sqrt -x) below 0."""
    at = head(x)
    return (at / 4).hypgeom_0f1(arb(0.5)) + (at / 4).hypgeom_0f1(arb(1.5)) * (x - at) / 2


def _sinh_over_root(x: Any) -> Any:
    """S(x) = sinh(sqrt x)/sqrt x, likewise."""
    at = head(x)
    return (at / 4).hypgeom_0f1(arb(1.5)) + (at / 4).hypgeom_0f1(arb(2.5)) * (x - at) / 6


def _exp_quotient(x: Any) -> Any:
    """E(x) = (exp x - 1)/x, likewise."""
    at = head(x)
    return at.hypgeom_1f1(1, 2) + at.hypgeom_1f1(2, 3) * (x - at) / 2


def _quotient_of_quotient(x: Any) -> Any:
    """D(x) = (E(x) - 1)/x, likewise."""
    at = head(x)
    return at.hypgeom_1f1(1, 3) / 2 + at.hypgeom_1f1(2, 4) * (x - at) / 6


def stretches_of(shape: Shape) -> list[BallStretch]:
    """The smooth parts of a cam, in the digits in use."""
    return [stretch for part in shape.parts() for stretch in _stretches(part)]


def varied_stretches(shape: Shape) -> list[BallStretch]:
    """The stretches of a cam, one number of which is a series: their heights are series too."""
    return [replace(stretch, varies=True) for stretch in stretches_of(shape)]


def _stretches(part: Part) -> list[BallStretch]:
    """The stretches of a part: one, or one for each of its polynomials, which are equally long."""
    if not part.pieces:
        return [BallStretch(part.start, part.end, part.lift, part.level, part.slopes, part.seat)]
    count = len(part.pieces)
    width = (part.end - part.start) / count
    edges = [part.start + k * width for k in range(count + 1)]
    return [
        BallStretch(edges[k], edges[k + 1], _polynomial(piece), part.level)
        for k, piece in enumerate(part.pieces)
    ]


def _polynomial(piece: Piece) -> Callable[[Any], Any]:
    """sum a_j x^j, x = theta - center, with the doubles of the piece taken as they are."""

    def lift(theta: Any) -> Any:
        """The sum at theta, by Horner's scheme."""
        x = theta - arb(piece.center)
        total = arb(0)
        for coefficient in reversed(piece.coefficients):
            total = total * x + arb(coefficient)
        return total

    return lift
