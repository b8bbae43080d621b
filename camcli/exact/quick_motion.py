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
from typing import Any, NamedTuple

from flint import arb, arb_mat, ctx

from camcli.cams.balls import COARSE, UndecidedError
from camcli.cams.compile import Shape
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BLOW, GUARD, BallMotion, Parallelogram
from camcli.exact.table_bounds import table_and_bounds
from camcli.kernel import backend
from camcli.kernel.enclosed_landing import (
    ACCEL,
    ANGLE,
    COLUMNS,
    ENCLOSED,
    ERROR,
    J11,
    J12,
    J21,
    J22,
    JERK,
    PHASE,
    RATE,
    RATE_RADIUS,
    SIZE,
    SLIVER,
    SNAP,
    THETA,
    THETA_RADIUS,
    WRAPS,
    U,
)
from camcli.kernel.forms import as_list
from camcli.system import Follower, System

SPARE = 1.0 + 1e-9  # covers the roundings in a bound
ULPS = 2.0**-50  # relative error of a sum of few products
SURE = 1.01  # times an estimate in doubles, where a test in balls would say the same
ORDER = 4  # of a step of Newton's method with three derivatives
ENOUGH = 128  # bits of what is compared or printed
LOST = 24  # bits, that such a step may lose to the sizes of derivatives


Matrix = tuple[float, float, float, float]  # rows one after the other


@contextmanager
def fewer_bits(bits: int) -> Iterator[None]:
    """Calculate with no more than so many bits."""
    full = ctx.prec
    ctx.prec = min(full, bits)
    try:
        yield
    finally:
        ctx.prec = full


class Spread(NamedTuple):
    """Where (phase, rate) may be about a middle: p t + Q e with |t| <= 1, in doubles.

    The same set as `motion.Parallelogram` without its middle. lean: p, m and m/rad; frame: Q;
    sizes and exponent: |e_k| <= sizes[k] 2^exponent, since errors may be far below what a double
    can hold. Every method rounds outwards: SPARE and ULPS are its margins.
    """

    lean: tuple[float, float]
    frame: Matrix
    sizes: tuple[float, float]
    exponent: int

    def radii(self) -> tuple[arb, arb]:
        """How far each of the two numbers may be from the middle: a bound, as exact numbers."""
        a, b, c, d = self.frame
        x, y = self.sizes
        scale = arb(2) ** self.exponent
        first = scale * (SPARE * (abs(a) * x + abs(b) * y))
        second = scale * (SPARE * (abs(c) * x + abs(d) * y))
        p, r = self.lean
        if p or r:
            first += abs(p)
            second += abs(r)
        return first, second

    def image(
        self, jacobian: Matrix, error: Matrix, unit: tuple[float, float], rest: Sequence[arb],
        drift: Sequence[tuple[float, float]],
    ) -> Spread:  # fmt: skip
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
        sizes = self._sizes_in(frame, stretched, off)
        shift = frexp(max(sizes))[1]
        scaled = ldexp(SPARE * sizes[0], -shift), ldexp(SPARE * sizes[1], -shift)
        return Spread(lean, frame, scaled, self.exponent + shift)

    def _left_out(self, jacobian: Matrix, error: Matrix, stretched: Matrix) -> tuple[float, float]:
        """What J Q e leaves out, in units of 2^exponent: errors of J, and roundings of the product.

        |J e'| differs by `error` on the sides of the box that holds Q e.
        """
        a, b, c, d = self.frame
        x, y = self.sizes
        sides = abs(a) * x + abs(b) * y, abs(c) * x + abs(d) * y
        bounds = []
        for k in (0, 2):  # the first entry of a row
            of_jacobian = [error[k + n] + ULPS * abs(jacobian[k + n]) for n in (0, 1)]
            rounding = ULPS * (abs(stretched[k]) * x + abs(stretched[k + 1]) * y)
            bounds.append(of_jacobian[0] * sides[0] + of_jacobian[1] * sides[1] + rounding)
        return bounds[0], bounds[1]

    def _sizes_in(
        self, frame: Matrix, stretched: Matrix, off: Sequence[float]
    ) -> tuple[float, float]:
        """Bounds of the coordinates in a new frame F of J Q e + (anything within `off`).

        They are F^-1 J Q e and F^-1 off, where F^-1 is ((s, -q), (-r, p)) over the determinant of
        F = ((p, q), (r, s)). Raises UndecidedError where rounding could make that zero.
        """
        p, q, r, s = frame
        det = p * s - q * r
        doubt = ULPS * (abs(p * s) + abs(q * r))
        if not abs(det) > 2.0 * doubt:
            raise UndecidedError
        x, y = self.sizes
        a, b, c, d = stretched
        per = SPARE / (abs(det) - doubt)
        first = abs(s * a - q * c) * x + abs(s * b - q * d) * y
        second = abs(p * c - r * a) * x + abs(p * d - r * b) * y
        first += SPARE * (abs(s) * off[0] + abs(q) * off[1])
        second += SPARE * (abs(r) * off[0] + abs(p) * off[1])
        return per * first, per * second

    def _frame(self, stretched: Matrix, accel: float, u: float) -> Matrix:
        """A frame of which the longer side of the image keeps its direction."""
        a, b = stretched[0], stretched[1]
        c, d = (stretched[2] - accel * a) / u, (stretched[3] - accel * b) / u
        x, y = self.sizes
        if (a * a + c * c) * x * x <= (b * b + d * d) * y * y:
            a, c = b, d
        length = (a * a + c * c) ** 0.5
        if not length > 0.0:
            raise UndecidedError
        a, c = a / length, c / length
        return a, -c, accel * a + u * c, u * a - accel * c


def _product(left: Matrix, right: Matrix) -> Matrix:
    """The product of two matrices."""
    a, b, c, d = right
    j, k, m, n = left
    return j * a + k * c, j * b + k * d, m * a + n * c, m * b + n * d


def _lean_of_image(
    jacobian: Matrix, error: Matrix, lean: tuple[float, float], drift: Sequence
) -> tuple[tuple[float, float], tuple[float, float]]:
    """(J p + d, bounds of what this leaves out); d: `drift`, pairs of a value and its radius."""
    found = []
    doubts = []
    for k in (0, 1):
        row = jacobian[2 * k : 2 * k + 2]
        doubt = error[2 * k : 2 * k + 2]
        own, own_doubt = drift[k] if drift else (0.0, 0.0)
        found.append(row[0] * lean[0] + row[1] * lean[1] + own)
        size = abs(row[0] * lean[0]) + abs(row[1] * lean[1]) + abs(own)
        doubts.append(doubt[0] * abs(lean[0]) + doubt[1] * abs(lean[1]) + own_doubt + ULPS * size)
    return (found[0], found[1]), (doubts[0], doubts[1])


class Table:
    """The kernel's table of a machine, bounds of its errors, and room for one landing.

    search: `kernel.enclosed_landing`; known: whether there are bounds, without which nothing is
    enclosed; snap: bound of the cam's fourth derivative; room: the column of numbers that the
    kernel reads the start from and writes the landing to.
    """

    def __init__(self, shape: Shape, follower: Follower, strobe: float, rpm: float):
        kernel = backend.current()
        cam, bounds = table_and_bounds(shape, strobe)
        system = System(follower, cam, shape)
        self.search = kernel.enclose_landing
        self.cam = kernel.cam(cam)
        self.known = bounds is not None
        self.snap = bounds[SIZE + 4 - ERROR] if bounds is not None else 0.0
        columns = [*system.machine(rpm), *(bounds or ())]
        self.room = kernel.numbers(columns + [0.0] * (COLUMNS - len(columns)))

    def enclosed(self, theta: arb, rate: arb) -> list[float] | None:
        """The column of `kernel.enclosed_landing` after a flight from the cam, or None."""
        if not self.known:
            return None
        room = self.room
        room[THETA], room[RATE] = x, y = float(theta), float(rate)
        room[THETA_RADIUS] = (float(theta.rad()) + abs(x) * ULPS) * SPARE
        room[RATE_RADIUS] = (float(rate.rad()) + abs(y) * ULPS) * SPARE
        return as_list(room) if self.search(self.cam, room) == ENCLOSED else None


class QuickMotion(BallMotion):
    """A `BallMotion` that takes most steps in doubles with certain errors.

    table: of the kernel, for the machine in the middle of the balls. lost: bits, at most, that
    errors have used up of the first ones. here: q and w of the start in the middle. swing: the free
    oscillation from there, see `_fly_from`. state_computed: whether q, w and fall, of the base
    class, are those of this start; they are computed only where somebody asks for them.
    """

    spread: Spread | None  # about `middle`; None where the parallelogram `at` is the start

    def __init__(self, machine: BallMachine, strobe: float, theta: float, table: Table):
        self.table = table
        self.starts_of_stretches = [float(at.start) for at in machine.stretches]
        self.ends_of_stretches = [*self.starts_of_stretches[1:], float(machine.stretches[-1].end)]
        self.lost = 0
        self.damping = float(machine.Z)
        self.state_computed = True
        super().__init__(machine, strobe, theta)

    def _begin_flight(self, at: Parallelogram, order: int) -> None:
        super()._begin_flight(at, order)
        self.state_computed = True
        self.middle = at.middle[0, 0], at.middle[1, 0]
        self.spread = None

    def _spread_from_balls(self) -> Spread:
        """The spread about the middle that holds the parallelogram of `BallMotion`.

        Its frame and lean are rounded to doubles; what that changes is added to the errors.
        """
        at = self.at
        phi, rate = self.middle
        level, slope = self._cam(phi, self.i, self.n, 1)
        self._fly_from(level, slope + rate)
        a, b, c, d = map(float, at.frame.mid().entries())
        x, y = map(float, at.lean.mid().entries())
        with fewer_bits(COARSE):
            exact = arb_mat([[a, b], [c, d]])
            off = (at.lean - arb_mat([[x], [y]])) * arb(0, 1) + at.frame * at.error
            try:
                first, second = (x.abs_upper() for x in (exact.inv() * off).entries())
            except ZeroDivisionError:
                raise UndecidedError from None
        exponent = _exponent(first.max(second))
        scale = arb(2) ** -exponent
        sizes = float(first * scale) * SPARE, float(second * scale) * SPARE
        return Spread((x, y), (a, b, c, d), sizes, exponent)

    def _compute_state(self) -> None:
        """q, w and fall of the start, to as many digits as anybody asks for."""
        if self.state_computed:
            return
        machine = self.machine
        with fewer_bits(ENOUGH):
            c = self._cam(self.phi, self.i, self.n)
            self.q, self.w = c[0], c[1] + self.rate
            self.fall = machine.G + machine.W2 * self.q + 2 * machine.Z * self.w + c[2]
        self.state_computed = True

    def _back_to_balls(self) -> None:
        """The start as `BallMotion` knows it."""
        spread = self.spread
        if spread is None:
            return
        a, b, c, d = spread.frame
        scale = arb(2) ** spread.exponent
        self._begin_flight(
            Parallelogram(
                arb_mat([[x] for x in self.middle]),
                arb_mat([[x] for x in spread.lean]),
                arb_mat([[a, b], [c, d]]),
                arb_mat([[arb(0, scale * x)] for x in spread.sizes]),
            ),
            BLOW,
        )

    def step(self) -> None:
        """One step: in doubles where they enclose the landing, else as `BallMotion`."""
        if self.order != BLOW or not self._quick_step():
            self._back_to_balls()
            super().step()

    def _quick_step(self) -> bool:
        """Try the step in doubles; False, with nothing changed, where they do not enclose it."""
        machine = self.machine
        theta = self.phi - self.n * self.turn
        found = self.table.enclosed(theta, self.rate)
        if found is None:
            return False
        i = self._stretch(found[PHASE], found[SLIVER])
        if i < 0:
            return False
        r = machine.restitution(i)
        if not r > 0:
            return False
        if self.spread is None:
            self.spread = self._spread_from_balls()
        n = self.n + int(found[WRAPS])
        landed = self._landed(found, i, n)
        if landed is None:
            return False
        later, rate, c, c1 = landed
        phi = self.middle[0] + later
        rate = -r * rate
        drift = self._drift(found, r) if machine.width else ()
        spread = self.spread.image(
            (found[J11], found[J12], found[J21], found[J22]),
            (found[J11 + 1], found[J12 + 1], found[J21 + 1], found[J22 + 1]),
            (found[ACCEL], found[U]),
            (phi.rad(), rate.rad()),
            drift,
        )
        middle = phi.mid(), rate.mid()
        radii = spread.radii()
        phi = arb(middle[0], radii[0])
        rate = arb(middle[1], radii[1])
        strobe = self._next_strobe()
        if not strobe > phi:
            self._compute_state()
            with fewer_bits(ENOUGH):
                self._strobes(phi)
                strobe = self._next_strobe()
        self.i, self.n = i, n
        self.middle = middle
        self.spread = spread
        self.phi = phi
        self.rate = rate
        self._fly_from(c, c1 + middle[1])
        self.state_computed = False
        known = max(phi.rel_accuracy_bits(), rate.rel_accuracy_bits())
        self.lost = max(self.lost, self.bits - known)
        ctx.prec = min(self.bits, known + GUARD)
        self._struck(-rate / r)
        if self._may_accumulate(found, float(strobe)):
            self._compute_state()
            with fewer_bits(ENOUGH):
                self.resting = bool(self.fall > 0) and self._accumulates()
            if self.resting:
                self._leave()
        return True

    def _fly_from(self, q: arb, w: arb) -> None:
        """Take q and w of the start in the middle.

        Without damping q = level + (w/f) sin(f s) + far cos(f s), f = W: `swing` holds level, w/f
        and far, the distance to the equilibrium at -G/W^2.
        """
        center = self.machine.center
        self.here = q, w
        self.swing = None
        if center.undamped and center.sprung and not center.near_critical:
            rest = center.G / center.W2
            self.swing = -rest, w / center.frequency, q + rest

    def _stretch(self, phase: float, radius: float) -> int:
        """The stretch that holds all phases within `radius` (rad) of a phase, or -1."""
        i = bisect(self.starts_of_stretches, phase) - 1
        inside = self.starts_of_stretches[i] + radius < phase < self.ends_of_stretches[i] - radius
        return i if inside else -1

    def _landed(self, found: Sequence[float], i: int, n: int) -> tuple[arb, arb, arb, arb] | None:
        """(angle of flight, gap', c, c') at the landing of the start in the middle, or None.

        Newton's method with three derivatives, in as many bits as the next step makes of them. Its
        last step d is the fixed point of -(g + d^2 (a/2 + d j/6 + d^2 k/24))/u with |k| <= K, which
        maps a ball about it into itself (Brouwer); there is no other zero where doubles found one.
        """
        full = ctx.prec
        phi = self.middle[0] - n * self.turn
        stretch = self.machine.stretches[i]
        s = _ball(found, ANGLE)
        x = arb(found[ANGLE])
        bits = int(-log2(found[ANGLE + 1]))
        enough = full // (ORDER - 1) + LOST
        try:
            while bits < enough:
                bits = min(ORDER * bits - LOST, enough)
                ctx.prec = bits + LOST
                gap, _ = self._at(x, stretch, phi)
                x = (x + _newton(gap)[0]).mid()
        finally:
            ctx.prec = full
        gap, cam = self._at(x, stretch, phi)
        u, a, j = gap[1:]
        d, (linear, bend, jerk) = _newton(gap)
        around = arb(d, 4 * linear.rad() + d**4 * _newton_remainder(found))
        fourth = arb(0, 1.01 * found[SNAP] / (24.0 * found[U]))
        step = linear - around * around * (bend + around * (jerk + around * fourth))
        if not (around.contains_interior(step) and s.contains(x + around)):
            return None
        # Taylor's polynomials at x, with the fourth derivatives within their bounds
        d = step
        half = d / 2
        third = d / 3
        rate = u + d * (a + half * (j + third * arb(0, found[SNAP])))
        c, c1, c2, c3 = cam
        bend_of_c = c2 + third * (c3 + half * arb(0, self.table.snap))
        bend_of_c1 = c2 + half * (c3 + third * arb(0, self.table.snap))
        return x + d, rate, c + d * (c1 + half * bend_of_c), c1 + d * bend_of_c1

    def _at(self, s: arb, stretch: Any, phi: arb) -> tuple[list[arb], list[arb]]:
        """The gap of the start in the middle after s rad, and the cam, with three derivatives."""
        center = self.machine.center
        if self.swing is None:
            q, w, y, z = center.move(*self.here, s)
        else:
            level, w0, far = self.swing
            frequency = center.frequency
            sine, cosine = (frequency * s).sin_cos()
            off = w0 * sine + far * cosine
            q, w = level + off, (w0 * cosine - far * sine) * frequency
            y, z = -center.W2 * off, -center.W2 * w
        cam = stretch.derivatives(phi + s, 3)
        return [q - cam[0], w - cam[1], y - cam[2], z - cam[3]], cam

    def _drift(self, found: Sequence[float], r: arb) -> list[tuple[float, float]]:
        """How far the speeds of the machines spread the phase and the rate after this landing.

        Each is a double and a bound of its error. A machine whose follower is dq further from the
        cam after the same angle lands dq/-u later, and its rate before the impact differs by dw and
        by what the acceleration does until then. found: the landing, as `enclosed_landing` has it;
        r: restitution.
        """
        self._compute_state()
        with fewer_bits(COARSE):
            s = _ball(found, ANGLE)
            u = _ball(found, U)
            accel = _ball(found, ACCEL)
            dq, dw = self.machine.drift(self.q, self.w, s).entries()
            d_phase = -dq / u
            d_rate = -r * (dw + accel * d_phase)
            return [_double_and_error(d_phase), _double_and_error(d_rate)]

    def _may_accumulate(self, found: Sequence[float], strobe: float) -> bool:
        """False where `_accumulates` certainly says no: hops of that length leave the stretch."""
        r = float(self.machine.restitution(self.i))
        fall = abs(-found[ACCEL] - 2.0 * self.damping * (1.0 + r) * found[U]) + 1e-9
        end = min(self.ends_of_stretches[self.i] - found[PHASE], strobe - float(self.phi)) + 1e-9
        return r < 1.0 and 3.0 * float(self.rate) <= SURE * fall * (1.0 - r) * end


def _ball(found: Sequence[float], at: int) -> arb:
    """The number at a place of `enclosed_landing`, whose radius stands behind it."""
    return arb(found[at], found[at + 1])


def _double_and_error(x: arb) -> tuple[float, float]:
    """A ball as a double and a bound of what it may be off."""
    middle = float(x)
    return middle, float(x.rad()) * SPARE + abs(middle) * ULPS


def _newton(gap: Sequence[arb]) -> tuple[arb, tuple[arb, arb, arb]]:
    """A step of Newton's method with the second and third derivative.

    gap: g, u, a, j, the gap and its derivatives. Returns the zero d of g + u d + a d^2/2 + j d^3/6
    up to the fourth power of g, and what it is made of: -g/u, a/2u, j/6u.
    """
    g, u, a, j = gap
    per = 1 / u
    d = -g * per
    bend, jerk = a * per / 2, j * per / 6
    zero = d - d * d * (bend + d * (jerk - 2 * bend * bend))
    return zero.mid(), (d, bend, jerk)


def _newton_remainder(found: Sequence[float]) -> float:
    """A number above the factor of d^4 in what `_newton` leaves out."""
    u = found[U]
    bend, jerk, snap = found[ACCEL] / u, found[JERK] / u, found[SNAP] / u
    return abs(bend) ** 3 + abs(bend * jerk) + abs(snap)


def _exponent(size: arb) -> int:
    """The exponent of 2 with which size 2^-exponent is about one."""
    if size == 0:
        return -ctx.prec
    man, exp = size.mid().man_exp()
    return int(exp) + int(man).bit_length()
