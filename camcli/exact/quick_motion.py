"""`BallMotion` with fewer balls: doubles find each landing, and only its digits are balls.

`kernel.enclosed_landing` shows in doubles which landing is the first, and encloses it and its
derivatives to some 12 digits. Where it does, the phase and the rate are refined in balls to all
digits in use, and the spread of errors is carried in doubles with an exponent of its own. Where it
does not (a departure from rest, a near graze, a landing beside a corner), `BallMotion` does the
step. Every decision is as certain as there.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import frexp, ldexp, log2
from typing import NamedTuple

from flint import arb, arb_mat, ctx

from camcli.cams.balls import COARSE, UndecidedError
from camcli.cams.compile import Shape
from camcli.exact.machine import BallMachine, BallStretch, Place
from camcli.exact.motion import BLOW, GUARD, BallMotion, Parallelogram
from camcli.exact.table_bounds import table_and_bounds
from camcli.kernel import backend
from camcli.kernel.enclosed_landing import (
    ANGLE,
    COLUMNS,
    ENCLOSED,
    ERROR,
    RATE,
    RATE_RADIUS,
    SIZE,
    THETA,
    THETA_RADIUS,
)
from camcli.kernel.forms import as_list
from camcli.system import Follower, System

SPARE = 1.0 + 1e-9  # covers the roundings in a bound
ULPS = 2.0**-50  # relative error of a sum of few products
SURE = 1.01  # times an estimate in doubles, where a test in balls would say the same
ENOUGH = 128  # bits of what is compared or printed
LOST = 12  # bits, that such a step may lose to the sizes of derivatives
UNSAID = 9  # bits by which doubles are better than the bounds of their errors
CHORDS = 2  # that cost less than a step of Newton's method with derivatives


Matrix = tuple[float, float, float, float]  # rows one after the other
Pair = tuple[float, float]


@contextmanager
def fewer_bits(bits: int) -> Iterator[None]:
    """Calculate with no more than so many bits."""
    full = ctx.prec
    ctx.prec = min(full, bits)
    try:
        yield
    finally:
        ctx.prec = full


class StateSpread(NamedTuple):
    """Where (phase, rate) may be about a middle: p t + Q e with |t| <= 1, in doubles.

    The same set as `motion.Parallelogram` without its middle. lean: p, m and m/rad; frame: Q, whose
    columns are the two sides of the set; sizes and exponent: |e_k| <= sizes[k] 2^exponent, since
    errors may be far below what a double can hold. Every method rounds outwards: SPARE and ULPS
    are its margins.
    """

    lean: Pair
    frame: Matrix
    sizes: Pair
    exponent: int

    def reach(self) -> Pair:
        """How far Q e goes in phase and in rate, in units of 2^exponent, without margins."""
        phase_of_1, phase_of_2, rate_of_1, rate_of_2 = self.frame
        size_1, size_2 = self.sizes
        return (
            abs(phase_of_1) * size_1 + abs(phase_of_2) * size_2,
            abs(rate_of_1) * size_1 + abs(rate_of_2) * size_2,
        )

    def radii(self) -> tuple[arb, arb]:
        """How far phase and rate may be from the middle: a bound of each, as exact numbers."""
        in_phase, in_rate = self.reach()
        scale = arb(2) ** self.exponent
        phase = scale * (SPARE * in_phase)
        rate = scale * (SPARE * in_rate)
        lean_phase, lean_rate = self.lean
        if lean_phase or lean_rate:
            phase += abs(lean_phase)
            rate += abs(lean_rate)
        return phase, rate

    def image(
        self, jacobian: Matrix, error: Matrix, unit: Pair, rest: Sequence[arb],
        drift: Sequence[Pair],
    ) -> StateSpread:  # fmt: skip
        """The spread after a map whose derivatives are within `error` of `jacobian`.

        unit: gap'' and gap' at the landing; in numbers scaled by them the new frame is orthonormal.
        rest: radii of the image of the middle. drift: derivatives of the map by t, each with its
        radius; empty where the machine is one.
        """
        stretched = _product(jacobian, self.frame)  # J Q
        frame = self._frame(stretched, *unit)
        lean = self.lean
        lean_error = (0.0, 0.0)
        if drift or lean[0] or lean[1]:
            lean, lean_error = _lean_of_image(jacobian, error, lean, drift)
        left_out = self._left_out(jacobian, error, stretched)
        scale = arb(2) ** -self.exponent
        off = [left_out[k] + float((rest[k] + lean_error[k]) * scale) for k in (0, 1)]
        size_1, size_2 = self._sizes_in(frame, stretched, off)
        shift = frexp(max(size_1, size_2))[1]
        sizes = (ldexp(SPARE * size_1, -shift), ldexp(SPARE * size_2, -shift))
        return StateSpread(lean, frame, sizes, self.exponent + shift)

    def _left_out(self, jacobian: Matrix, error: Matrix, stretched: Matrix) -> Pair:
        """What J Q e leaves out, in units of 2^exponent: errors of J, and roundings of the product.

        An error of J is multiplied by how far Q e goes.
        """
        in_phase, in_rate = self.reach()
        size_1, size_2 = self.sizes
        bounds = []
        for first in (0, 2):  # index of the first entry of a row of a matrix
            second = first + 1
            by_phase = error[first] + ULPS * abs(jacobian[first])
            by_rate = error[second] + ULPS * abs(jacobian[second])
            rounding = ULPS * (abs(stretched[first]) * size_1 + abs(stretched[second]) * size_2)
            bounds.append(by_phase * in_phase + by_rate * in_rate + rounding)
        return bounds[0], bounds[1]

    def _sizes_in(self, frame: Matrix, stretched: Matrix, off: Sequence[float]) -> Pair:
        """Bounds of the coordinates in a new frame F of J Q e + (anything within `off`).

        They are F^-1 J Q e and F^-1 off, where F^-1 is ((s, -q), (-r, p)) over the determinant of
        F = ((p, q), (r, s)). Raises UndecidedError where rounding could make that zero.
        """
        p, q, r, s = frame
        det = p * s - q * r
        doubt = ULPS * (abs(p * s) + abs(q * r))
        if not abs(det) > 2.0 * doubt:
            raise UndecidedError
        size_1, size_2 = self.sizes
        phase_of_1, phase_of_2, rate_of_1, rate_of_2 = stretched
        first = abs(s * phase_of_1 - q * rate_of_1) * size_1
        first += abs(s * phase_of_2 - q * rate_of_2) * size_2
        first += SPARE * (abs(s) * off[0] + abs(q) * off[1])
        second = abs(p * rate_of_1 - r * phase_of_1) * size_1
        second += abs(p * rate_of_2 - r * phase_of_2) * size_2
        second += SPARE * (abs(r) * off[0] + abs(p) * off[1])
        per_determinant = SPARE / (abs(det) - doubt)
        return per_determinant * first, per_determinant * second

    def _frame(self, stretched: Matrix, accel: float, u: float) -> Matrix:
        """A frame in which the longer side of the image keeps its direction.

        stretched: J Q. It is orthonormal in (x, y), phase = x and rate = accel x + u y. Raises
        UndecidedError where that side has no length.
        """
        phase_of_1, phase_of_2, rate_of_1, rate_of_2 = stretched
        size_1, size_2 = self.sizes
        x = phase_of_1
        y = (rate_of_1 - accel * phase_of_1) / u
        x_of_2 = phase_of_2
        y_of_2 = (rate_of_2 - accel * phase_of_2) / u
        of_1 = (x * x + y * y) * size_1 * size_1  # squares of the sides' lengths
        of_2 = (x_of_2 * x_of_2 + y_of_2 * y_of_2) * size_2 * size_2
        if of_1 <= of_2:
            x = x_of_2
            y = y_of_2
        length = (x * x + y * y) ** 0.5
        if not length > 0.0:
            raise UndecidedError
        x = x / length
        y = y / length
        return x, -y, accel * x + u * y, u * x - accel * y


def _product(left: Matrix, right: Matrix) -> Matrix:
    """The product of two matrices."""
    a, b, c, d = right
    first, second, third, fourth = left
    return (
        first * a + second * c,
        first * b + second * d,
        third * a + fourth * c,
        third * b + fourth * d,
    )


def _lean_of_image(
    jacobian: Matrix, error: Matrix, lean: Pair, drift: Sequence[Pair]
) -> tuple[Pair, Pair]:
    """(J p + d, bounds of what this leaves out); p: lean, d: drift, each with its radius.

    error: of the entries of J. No drift at all is one of zero.
    """
    values = []
    bounds = []
    for k in (0, 1):  # phase and rate: the rows of J
        by_phase, by_rate = jacobian[2 * k : 2 * k + 2]
        error_by_phase, error_by_rate = error[2 * k : 2 * k + 2]
        d, d_radius = drift[k] if drift else (0.0, 0.0)
        values.append(by_phase * lean[0] + by_rate * lean[1] + d)
        size = abs(by_phase * lean[0]) + abs(by_rate * lean[1]) + abs(d)
        of_jacobian = error_by_phase * abs(lean[0]) + error_by_rate * abs(lean[1])
        bounds.append(of_jacobian + d_radius + ULPS * size)
    return (values[0], values[1]), (bounds[0], bounds[1])


class EnclosedLanding(NamedTuple):
    """A landing as `kernel.enclosed_landing` encloses it, for all machines and starts.

    The numbers stand in the order of the kernel's column, each followed by its radius, but for the
    last four. angle: rad of flight; u, accel, jerk: gap', gap'' and gap''' there; j11 to j22: the
    derivatives of (phase, rate) after the impact by those at the start; snap: a bound of |gap''''|;
    phase: within the turn, rad, known to `sliver`; wraps: turns that end on the way.
    """

    angle: float
    angle_radius: float
    u: float
    u_radius: float
    accel: float
    accel_radius: float
    jerk: float
    jerk_radius: float
    j11: float
    j11_error: float
    j12: float
    j12_error: float
    j21: float
    j21_error: float
    j22: float
    j22_error: float
    snap: float
    phase: float
    wraps: float
    sliver: float

    @property
    def jacobian(self) -> Matrix:
        """The derivatives of (phase, rate) after the impact."""
        return self.j11, self.j12, self.j21, self.j22

    @property
    def jacobian_error(self) -> Matrix:
        """The errors of its entries."""
        return self.j11_error, self.j12_error, self.j21_error, self.j22_error


class LandingTable:
    """The kernel's table of a machine, bounds of its errors, and room for one landing.

    search: `kernel.enclosed_landing`; known: whether there are bounds, without which nothing is
    enclosed; jerk: bound of the cam's third derivative; column: of numbers, which the kernel reads
    the start from and writes the landing to.
    """

    def __init__(self, shape: Shape, follower: Follower, strobe: float, rpm: float):
        kernel = backend.current()
        cam, bounds = table_and_bounds(shape, strobe)
        system = System(follower, cam, shape)
        self.search = kernel.enclose_landing
        self.cam = kernel.cam(cam)
        self.known = bounds is not None
        third_derivative = SIZE - ERROR + 3  # where the bounds have its size
        self.jerk = bounds[third_derivative] if bounds is not None else 0.0
        numbers = [*system.machine(rpm), *(bounds or ())]
        self.column = kernel.numbers(numbers + [0.0] * (COLUMNS - len(numbers)))

    def enclosed(self, theta: arb, rate: arb) -> EnclosedLanding | None:
        """The landing of a flight that leaves the cam at theta (rad) with a rate (m/rad), or None.

        None where the kernel cannot enclose it.
        """
        if not self.known:
            return None
        theta_middle = float(theta)
        rate_middle = float(rate)
        column = self.column
        column[THETA] = theta_middle
        column[RATE] = rate_middle
        column[THETA_RADIUS] = (float(theta.rad()) + abs(theta_middle) * ULPS) * SPARE
        column[RATE_RADIUS] = (float(rate.rad()) + abs(rate_middle) * ULPS) * SPARE
        if self.search(self.cam, column) != ENCLOSED:
            return None
        return EnclosedLanding._make(as_list(column[ANGLE:]))


class Swing(NamedTuple):
    """An undamped flight q = level + by_rate sin(f s) + far cos(f s), with f the frequency W."""

    level: arb  # m, where the forces balance: -G/W^2
    by_rate: arb  # m, the rate at the start over f
    far: arb  # m, of the start from the level


class LandedMiddle(NamedTuple):
    """The landing of the start in the middle: the angle of flight, gap', c and c' there."""

    angle: arb
    rate: arb
    c: arb
    c1: arb


class QuickMotion(BallMotion):
    """A `BallMotion` that takes most steps in doubles with certain errors.

    table: of the kernel, for the machine in the middle of the balls. lost: bits, at most, that
    errors have used up of the first ones. middle: (phi, rate) of the start in the middle, exact;
    spread: about it, None where `enclosure` of the base class is the start; q_and_w: q and w of the
    start in the middle; swing: its free oscillation, see `_fly_from`. state_computed: whether q, w
    and fall, of the base class, are those of this start; they are computed only where somebody
    asks for them.
    """

    middle: tuple[arb, arb]
    spread: StateSpread | None

    def __init__(self, machine: BallMachine, strobe: float, theta: float, table: LandingTable):
        self.table = table
        self.starts_of_stretches = [float(stretch.start) for stretch in machine.stretches]
        self.ends_of_stretches = [*self.starts_of_stretches[1:], float(machine.stretches[-1].end)]
        self.lost = 0
        self.damping = float(machine.Z)
        self.state_computed = True
        super().__init__(machine, strobe, theta)

    def _begin_flight(self, enclosure: Parallelogram, order: int) -> None:
        super()._begin_flight(enclosure, order)
        self.state_computed = True
        self.middle = enclosure.middle[0, 0], enclosure.middle[1, 0]
        self.spread = None

    def _spread_from_balls(self) -> StateSpread:
        """The spread about the middle that holds the parallelogram of `BallMotion`.

        Its frame and lean are rounded to doubles; what that changes is added to the errors.
        """
        enclosure = self.enclosure
        phi, rate = self.middle
        level, slope = self._cam(phi, self.place, 1)
        self._fly_from(level, slope + rate)
        a, b, c, d = map(float, enclosure.frame.mid().entries())
        lean_phase, lean_rate = map(float, enclosure.lean.mid().entries())
        with fewer_bits(COARSE):
            frame = arb_mat([[a, b], [c, d]])
            lean_off = enclosure.lean - arb_mat([[lean_phase], [lean_rate]])
            off = lean_off * arb(0, 1) + enclosure.frame * enclosure.error
            try:
                size_1, size_2 = (x.abs_upper() for x in (frame.inv() * off).entries())
            except ZeroDivisionError:
                raise UndecidedError from None
        exponent = _exponent(size_1.max(size_2))
        scale = arb(2) ** -exponent
        sizes = float(size_1 * scale) * SPARE, float(size_2 * scale) * SPARE
        return StateSpread((lean_phase, lean_rate), (a, b, c, d), sizes, exponent)

    def _compute_state(self) -> None:
        """q, w and fall of the start, to as many digits as anybody asks for."""
        if self.state_computed:
            return
        machine = self.machine
        with fewer_bits(ENOUGH):
            c = self._cam(self.phi, self.place)
            self.q = c[0]
            self.w = c[1] + self.rate
            self.fall = machine.G + machine.W2 * self.q + 2 * machine.Z * self.w + c[2]
        self.state_computed = True

    def _back_to_balls(self) -> None:
        """The start as `BallMotion` knows it: the spread about the middle as a parallelogram."""
        spread = self.spread
        if spread is None:
            return
        a, b, c, d = spread.frame
        scale = arb(2) ** spread.exponent
        enclosure = Parallelogram(
            middle=arb_mat([[x] for x in self.middle]),
            lean=arb_mat([[x] for x in spread.lean]),
            frame=arb_mat([[a, b], [c, d]]),
            error=arb_mat([[arb(0, scale * size)] for size in spread.sizes]),
        )
        self._begin_flight(enclosure, BLOW)

    def step(self) -> None:
        """One step: in doubles where they enclose the landing, else as `BallMotion`."""
        if self.order != BLOW or not self._quick_step():
            self._back_to_balls()
            super().step()

    def _quick_step(self) -> bool:
        """Try the step in doubles; False, with nothing changed, where they do not enclose it.

        The kernel encloses the landing and its derivatives for all starts; the landing of the start
        in the middle is solved in all digits, and the spread is mapped with the derivatives.
        """
        landing = self.table.enclosed(self.phi - self.place.turn * self.turn, self.rate)
        if landing is None:
            return False
        stretch = self._stretch(landing.phase, landing.sliver)
        if stretch < 0:
            return False
        r = self.machine.restitution(stretch)
        if not r > 0:
            return False
        if self.spread is None:
            self.spread = self._spread_from_balls()
        place = Place(stretch, self.place.turn + int(landing.wraps))
        landed = self._landed(landing, place)
        if landed is None:
            return False
        phi_of_middle = self.middle[0] + landed.angle
        rate_of_middle = -r * landed.rate
        spread = self.spread.image(
            landing.jacobian,
            landing.jacobian_error,
            unit=(landing.accel, landing.u),
            rest=(phi_of_middle.rad(), rate_of_middle.rad()),
            drift=self._drift(landing, r) if self.machine.width else (),
        )
        middle = phi_of_middle.mid(), rate_of_middle.mid()
        phi_radius, rate_radius = spread.radii()
        phi = arb(middle[0], phi_radius)
        strobe = self._next_strobe()
        if not strobe > phi:
            self._compute_state()
            with fewer_bits(ENOUGH):
                self._strobes(phi)
                strobe = self._next_strobe()
        self.place = place
        self.middle = middle
        self.spread = spread
        self.phi = phi
        self.rate = arb(middle[1], rate_radius)
        self._fly_from(landed.c, landed.c1 + middle[1])
        self.state_computed = False
        self._count_bits()
        self._struck(-self.rate / r)
        if self._may_accumulate(landing, float(strobe)):
            self._compute_state()
            with fewer_bits(ENOUGH):
                self.resting = bool(self.fall > 0) and self._accumulates()
            if self.resting:
                self._leave()
        return True

    def _count_bits(self) -> None:
        """Note how many bits are lost by now, and use no more than what is known deserves."""
        known = max(self.phi.rel_accuracy_bits(), self.rate.rel_accuracy_bits())
        self.lost = max(self.lost, self.bits - known)
        ctx.prec = min(self.bits, known + GUARD)

    def _fly_from(self, q: arb, w: arb) -> None:
        """Take q (m) and w (m/rad) of the start in the middle.

        Without damping q = level + (w/f) sin(f s) + far cos(f s), f = W: `swing` holds level, w/f
        and far, the distance to the equilibrium at -G/W^2.
        """
        center = self.machine.center
        self.q_and_w = q, w
        self.swing = None
        if center.undamped and center.sprung and not center.near_critical:
            equilibrium = center.G / center.W2  # below zero by so much
            self.swing = Swing(-equilibrium, w / center.frequency, q + equilibrium)

    def _stretch(self, phase: float, radius: float) -> int:
        """The stretch that holds all phases within `radius` (rad) of a phase, or -1."""
        i = bisect(self.starts_of_stretches, phase) - 1
        inside = self.starts_of_stretches[i] + radius < phase < self.ends_of_stretches[i] - radius
        return i if inside else -1

    def _landed(self, landing: EnclosedLanding, place: Place) -> LandedMiddle | None:
        """The landing of the start in the middle on the stretch at a place, or None.

        Doubles have found an interval that holds the landing, and bounds of gap', gap'' and gap'''
        over all of it. A point x in it is solved to half of the digits in use; the landing lies d
        beyond x. Two enclosures of d follow by the mean value theorem, g and u being the gap and
        its slope at x:

        - d = -g/u', where u' is gap' somewhere between x and the landing;
        - d = -g/(u + a d/2), where a is gap'' there. The d on the right is the first enclosure: it
          is multiplied by itself in effect, so that its width hardly matters.

        What the landing has is then Taylor's formula about x, with its remainder enclosed.
        """
        theta = self.middle[0] - place.turn * self.turn
        stretch = self.machine.stretches[place.stretch]
        x = self._near_landing(landing, stretch, theta)
        if not abs(float(x) - landing.angle) < 0.9 * landing.angle_radius:
            return None
        (g, u, a), (c, c1, c2) = self._at(x, stretch, theta)
        about_half = -g / arb(2.0 * landing.u, 2.0 * landing.u_radius)
        d = -g / (u + about_half * arb(landing.accel, landing.accel_radius))
        half = d / 2
        jerk = arb(landing.jerk, landing.jerk_radius)
        jerk_of_cam = arb(0, self.table.jerk)
        return LandedMiddle(
            angle=x + d,
            rate=u + d * (a + half * jerk),
            c=c + d * (c1 + half * (c2 + d * jerk_of_cam)),
            c1=c1 + d * (c2 + half * jerk_of_cam),
        )

    def _near_landing(self, landing: EnclosedLanding, stretch: BallStretch, theta: arb) -> arb:
        """The angle of flight to the landing, to half of the bits in use and more.

        A step of `_newton` makes three times the bits of the one before and those of a double, less
        LOST. What is missing then may be few enough for a chord, x - gap(x)/u with the slope u
        there, which adds as many bits as u has, and costs a third of such a step.
        """
        full = ctx.prec
        x = arb(landing.angle)
        slope: arb | float = landing.u
        of_double = int(-log2(landing.angle_radius)) + UNSAID
        bits = of_double
        off = landing.u_radius + abs(landing.accel) * landing.angle_radius
        bits_of_slope = int(-log2(off / -landing.u)) + UNSAID
        enough = (full - bits_of_slope) // 2 + LOST
        try:
            while bits < enough:
                if enough - bits <= CHORDS * bits_of_slope:
                    bits = min(bits + bits_of_slope, enough)
                    ctx.prec = bits + LOST
                    x = (x - self._gap_at(x, stretch, theta) / slope).mid()
                else:
                    bits_of_slope = 2 * bits + of_double - LOST
                    bits = min(3 * bits + of_double - LOST, enough)
                    ctx.prec = bits + LOST
                    gap, _ = self._at(x, stretch, theta)
                    d = _newton(gap, landing.jerk)
                    slope = gap[1] + d * (gap[2] + d * (0.5 * landing.jerk))
                    x = (x + d).mid()
        finally:
            ctx.prec = full
        return x

    def _gap_at(self, s: arb, stretch: BallStretch, theta: arb) -> arb:
        """The first number of `_at` alone: the gap of the start in the middle after s rad."""
        center = self.machine.center
        swing = self.swing
        if swing is None:
            q = center.move(*self.q_and_w, s, 2)[0]
        else:
            sine, cosine = (center.frequency * s).sin_cos()
            q = swing.level + swing.by_rate * sine + swing.far * cosine
        return q - stretch.derivatives(theta + s, 0)[0]

    def _at(self, s: arb, stretch: BallStretch, theta: arb) -> tuple[list[arb], list[arb]]:
        """([gap, gap', gap''], [c, c', c'']) of the start in the middle after s rad.

        theta: the phase of that start in the turn of the stretch, rad.
        """
        center = self.machine.center
        if self.swing is None:
            q, w, accel = center.move(*self.q_and_w, s, 2)
        else:
            frequency = center.frequency
            sine, cosine = (frequency * s).sin_cos()
            swing = self.swing
            off = swing.by_rate * sine + swing.far * cosine  # from the level
            q = swing.level + off
            w = (swing.by_rate * cosine - swing.far * sine) * frequency
            accel = -center.W2 * off
        cam = stretch.derivatives(theta + s, 2)
        return [q - cam[0], w - cam[1], accel - cam[2]], cam

    def _drift(self, landing: EnclosedLanding, r: arb) -> list[Pair]:
        """How far the speeds of the machines spread the phase and the rate after this landing.

        Each is a double and a bound of its error. A machine whose follower is dq further from the
        cam after the same angle lands dq/-u later, and its rate before the impact differs by dw and
        by what the acceleration does until then. r: restitution.
        """
        self._compute_state()
        with fewer_bits(COARSE):
            s = arb(landing.angle, landing.angle_radius)
            u = arb(landing.u, landing.u_radius)
            accel = arb(landing.accel, landing.accel_radius)
            dq, dw = self.machine.drift(self.q, self.w, s).entries()
            d_phase = -dq / u
            d_rate = -r * (dw + accel * d_phase)
            return [_double_and_error(d_phase), _double_and_error(d_rate)]

    def _may_accumulate(self, landing: EnclosedLanding, strobe: float) -> bool:
        """False where `_accumulates` certainly says no: hops of that length leave the stretch.

        strobe: the angle of the next one, counted on, rad. The same test as there, in doubles: the
        reach 3 v/(fall (1 - r)) may not go beyond the stretch or the turn.
        """
        r = float(self.machine.restitution(self.place.stretch))
        u = landing.u
        fall = abs(-landing.accel - 2.0 * self.damping * (1.0 + r) * u) + 1e-9
        to_end_of_stretch = self.ends_of_stretches[self.place.stretch] - landing.phase
        room = min(to_end_of_stretch, strobe - float(self.phi)) + 1e-9
        return 3.0 * float(self.rate) <= SURE * fall * (1.0 - r) * room


def _double_and_error(x: arb) -> tuple[float, float]:
    """A ball as a double and a bound of what it may be off."""
    middle = float(x)
    return middle, float(x.rad()) * SPARE + abs(middle) * ULPS


def _newton(gap: Sequence[arb], jerk: float) -> arb:
    """A step to a zero of g + u d + a d^2/2 + j d^3/6, right up to the fourth power of g; exact.

    gap: g, u, a, the gap and its derivatives. jerk: j, of which doubles know enough.
    """
    g, u, a = gap
    per = 1 / u
    linear = -g * per
    bend = a * per / 2
    of_jerk = per * (jerk / 6.0)
    return (linear - linear * linear * (bend + linear * (of_jerk - 2 * bend * bend))).mid()


def _exponent(size: arb) -> int:
    """The exponent of 2 with which size 2^-exponent is about one."""
    if size == 0:
        return -ctx.prec
    mantissa, exponent = size.mid().man_exp()
    return int(exponent) + int(mantissa).bit_length()
