"""Periodic orbits proved: the shooting equations in balls, solved by Krawczyk's method.

Unknowns and equations are those of `kernel.shooting`: phase theta_k and outgoing rate v_k of every
impact, and one parameter p of the machine; E1 = gap at the end of flight k, E2 = r u + v'. If

    K(X) = z - Y E(z) + (1 - Y E'(X)) (X - z)

lies inside the box X about z, there is exactly one zero of E in X, and it lies in K(X)
(R. Krawczyk, Computing 4 (1969) 187; R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to
Interval Analysis, 2009, ch. 8). One unknown, mostly p, is given: a number, or an interval, over
which the box leans along the branch. A derivative along the branch is the second coefficient of a
power series.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series, ctx

from camcli.cams.balls import UndecidedError, head, slope
from camcli.cams.compile import Shape
from camcli.exact.first_root import first_root
from camcli.exact.machine import BallMachine, BallStretch, stretches_of
from camcli.system import Follower

MIDDLE_STEPS = 12  # steps towards the middle of a box
INFLATIONS = 8  # boxes tried, each twice as wide as what came out of the last one
END_HALVINGS = 60  # of an interval at either end of a flight
MOST_STRETCHES = 10_000  # of one flight

Number = Any  # a ball, or a series of two coefficients: a number and its derivative
Place = tuple[int, int]  # stretch of the cam, and turn
Gap = Callable[[arb], list[Any]]  # s -> gap after s rad of a flight, and derivatives
Test = Callable[[list[Number]], Number]  # of the unknowns z = x, p as series


class ProofStep(StrEnum):
    """The step of a proof that failed; `camcli.words.proofs` says it in words."""

    NO_ORBIT = "no-orbit"
    SINGULAR = "singular"
    ELSEWHERE = "elsewhere"
    PULLS = "pulls"
    CONTACT = "contact"
    GRAZES = "grazes"
    NEUTRAL = "neutral"
    CROSSING = "crossing"
    NUMBER = "number"
    BOXES = "boxes"
    WORK_BUDGET = "work-budget"
    FAULT = "fault"
    MODEL = "model"


class NotProvedError(Exception):
    """The proof failed; `step` says where, `refuted` that the contrary was shown."""

    def __init__(self, step: ProofStep, refuted: bool = False):
        super().__init__(step)
        self.step = step
        self.refuted = refuted


class BallFlight(NamedTuple):
    """Flight k: gap and rate as it meets the cam, the derivatives of E1, E2 by either impact."""

    gap: Number
    rate: Number
    start: tuple[Number, Number, Number, Number]  # by theta, v: E1, E1, E2, E2
    accel: Number  # of the gap, at its end


@dataclass(frozen=True)
class Box:
    """The points middle + tangent eta + error, |eta| <= half: one orbit for every eta.

    `fixed` is the unknown that is given; its tangent is 1, its error 0.
    """

    middle: list[arb]
    tangent: list[arb]
    error: list[arb]
    fixed: int
    half: arb

    def hull(self) -> list[arb]:
        """The balls that hold each unknown."""
        return self.at(arb(0, self.half))

    def at(self, eta: arb) -> list[arb]:
        """Where the given unknown differs by eta from its middle."""
        parts = zip(self.middle, self.tangent, self.error, strict=True)
        return [z + t * eta + e for z, t, e in parts]

    def holds(self, orbit: Sequence[arb]) -> bool:
        """True where an orbit, known in a ball, lies in the box: it is the one of its eta."""
        eta = orbit[self.fixed] - self.middle[self.fixed]
        parts = zip(orbit, self.middle, self.tangent, self.error, strict=True)
        return abs(eta) <= self.half and all(
            k == self.fixed or e.contains(x - z - t * eta) for k, (x, z, t, e) in enumerate(parts)
        )


@dataclass(frozen=True)
class Shooting:
    """The equations of an orbit of n impacts in m turns; use it at one precision only.

    places: stretch and turn of every impact.
    """

    shape: Shape
    follower: Follower
    rpm: Any
    parameter: str
    places: tuple[Place, ...]
    turns: int

    @cached_property
    def stretches(self) -> list[BallStretch]:
        return stretches_of(self.shape)

    @property
    def n(self) -> int:
        return len(self.places)

    def machine(self, p: Number) -> BallMachine:
        """At a value of the parameter."""
        if self.parameter == "rpm":
            return BallMachine(self.stretches, self.follower, p)
        return BallMachine(self.stretches, replace(self.follower, **{self.parameter: p}), self.rpm)

    def lift(self, place: Place, theta: Number, order: int = 2) -> list[Number]:
        """c and derivatives at theta, an angle of the turn, or a series of angles."""
        stretch = self.stretches[place[0]]
        if not isinstance(theta, arb_series):
            return stretch.derivatives(theta, order)
        c = stretch.derivatives(theta[0], order + 1)
        return [arb_series([c[k], c[k + 1] * theta[1]], 2) for k in range(order + 1)]

    def span(self, x: Sequence[Number], k: int) -> Number:
        """rad of flight k."""
        j = (k + 1) % self.n
        turns = self.places[j][1] - self.places[k][1] + (self.turns if k == self.n - 1 else 0)
        return x[2 * j] - x[2 * k] + 2 * arb.pi() * turns

    def flights(self, machine: BallMachine, x: Sequence[Number]) -> list[BallFlight]:
        """All flights between the impacts x."""
        pieces = []
        for k in range(self.n):
            j = (k + 1) % self.n
            v = x[2 * k + 1]
            r = machine.r
            c, c1, c2 = self.lift(self.places[k], x[2 * k])
            end_c, end_c1, end_c2 = self.lift(self.places[j], x[2 * j])
            b, b1, p = machine.flow(self.span(x, k))
            w = c1 + v
            pull = machine.G + machine.W2 * c
            end_q = c + w * b - pull * p
            end_w = w * b1 - pull * b
            accel = -(pull + 2 * machine.Z * w) - c2
            end_accel = -(machine.G + machine.W2 * end_q + 2 * machine.Z * end_w) - end_c2
            start = (
                -(v * (1 - machine.W2 * p) + b * accel), b,
                r * (machine.W2 * b * v - b1 * accel), r * b1,
            )  # fmt: skip
            pieces.append(BallFlight(end_q - end_c, end_w - end_c1, start, end_accel))
        return pieces

    def equations(self, z: Sequence[arb]) -> tuple[arb_mat, arb_mat]:
        """(E, E') at the unknowns z = x, p: (2 n, 1) and (2 n, 2 n + 1)."""
        n = self.n
        machine = self.machine(arb_series([z[-1], 1], 2))
        r = head(machine.r)
        values = [[arb(0)] for _ in range(2 * n)]
        rows = [[arb(0)] * (2 * n + 1) for _ in range(2 * n)]
        for k, flight in enumerate(self.flights(machine, z[:-1])):
            j = (k + 1) % n
            bounce = machine.r * flight.rate + z[2 * j + 1]
            end = flight.rate, arb(0), r * head(flight.accel), arb(1)
            for i, equation in enumerate((flight.gap, bounce)):
                row = rows[2 * k + i]
                values[2 * k + i][0] = head(equation)
                row[-1] = slope(equation)
                for column, block in ((2 * k, flight.start), (2 * j, end)):
                    row[column] += head(block[2 * i])
                    row[column + 1] += head(block[2 * i + 1])
        return arb_mat(values), arb_mat(rows)

    def box(self, guess: Sequence[arb], fixed: int, half: arb | int = 0) -> Box:
        """A box with exactly one orbit for every value of the given unknown within `half`.

        Raises NotProvedError.
        """
        try:
            return self._krawczyk([x.mid() for x in guess], fixed, arb(half).mid())
        except (ZeroDivisionError, ValueError, UndecidedError):
            raise NotProvedError(ProofStep.SINGULAR) from None

    def _krawczyk(self, z: list[arb], fixed: int, half: arb) -> Box:
        """`box` from a guess that is exact numbers: Newton's method, then Krawczyk's operator.

        The operator maps a box about the root into itself where it holds exactly one; the box is
        widened until it does.
        """
        free = [k for k in range(len(z)) if k != fixed]
        small = arb(2) ** (16 - ctx.prec)
        for _ in range(MIDDLE_STEPS):
            value, slopes = self.equations(z)
            inverse = _columns(slopes, free).mid().inv().mid()
            step = (inverse * value).entries()
            for k, change in zip(free, step, strict=True):
                z[k] = (z[k] - change).mid()
            pairs = zip(free, step, strict=True)
            if all(s.contains(0) or abs(s) < (1 + abs(z[k])) * small for k, s in pairs):
                break
        value, slopes = self.equations(z)
        off = inverse * value
        eta = arb(0, half)
        one = arb_mat(len(free), len(free), [int(i == j) for i in free for j in free])
        tangent = (inverse * _columns(slopes, [fixed])).mid().entries()
        leaning = [arb(0)] * len(z)
        leaning[fixed] = arb(1)
        for k, t in zip(free, tangent, strict=True):
            leaning[k] = -t
        room = [abs(x).upper() * 2 + arb(2) ** (24 - ctx.prec) for x in off.entries()]
        for _ in range(INFLATIONS):
            error = [arb(0)] * len(z)
            for k, size in zip(free, room, strict=True):
                error[k] = arb(0, size)
            box = Box(z, leaning, error, fixed, half)
            _, slopes = self.equations(box.hull())
            errors = arb_mat([[error[k]] for k in free])
            rest = (one - inverse * _columns(slopes, free)) * errors
            along = inverse * (slopes * arb_mat([[t] for t in leaning])) * eta
            image = (rest - off - along).entries()
            if all(error[k].contains_interior(x) for k, x in zip(free, image, strict=True)):
                for k, x in zip(free, image, strict=True):
                    error[k] = x
                return Box(z, leaning, error, fixed, half)
            room = [2 * max(size, abs(x).upper()) for size, x in zip(room, image, strict=True)]
        raise NotProvedError(ProofStep.SINGULAR)

    def along(self, hull: Sequence[arb], fixed: int) -> list[Number]:
        """The unknowns as series in the given one: with the derivatives of the whole branch."""
        _, slopes = self.equations(hull)
        free = [k for k in range(len(hull)) if k != fixed]
        try:
            tangent = _columns(slopes, free).solve(_columns(slopes, [fixed])).entries()
        except ZeroDivisionError:
            raise NotProvedError(ProofStep.SINGULAR) from None
        slopes_of = dict(zip(free, (-t for t in tangent), strict=True))
        return [arb_series([x, slopes_of.get(k, 1)], 2) for k, x in enumerate(hull)]

    def zero(
        self, guess: Sequence[arb], fixed: int, test: Test, reach: arb | None = None
    ) -> tuple[Box, Box]:
        """The box of the only zero of a test function within `reach`, and that of the whole reach.

        The test is taken along the branch, over its given unknown; its slope keeps its sign on all
        of the reach, so that the zero is simple: the interval Newton method shows both.
        """
        box = self.box(guess, fixed)
        for _ in range(MIDDLE_STEPS):
            value = test(self.along(box.hull(), fixed))
            step = (head(value) / slope(value)).mid()
            box.middle[fixed] = (box.middle[fixed] - step).mid()
            box = self.box(box.middle, fixed)
            if abs(step) < (1 + abs(box.middle[fixed])) * arb(2) ** (-ctx.prec // 2):
                break
        at = box.middle[fixed]
        off = head(test(self.along(box.hull(), fixed)))
        least = (1 + abs(at)) * arb(2) ** (-ctx.prec // 2)
        wide = least if reach is None else reach
        around = self.box(box.middle, fixed, wide)
        root = at - off / slope(test(self.along(around.hull(), fixed)))
        if not arb(at, wide.mid()).contains_interior(root):
            raise NotProvedError(ProofStep.CROSSING)
        middle = list(box.middle)
        middle[fixed] = root.mid()
        return self.box(middle, fixed, root.rad() + least**2), around

    def trace_det(self, z: Sequence[Number]) -> tuple[Number, Number]:
        """Trace and determinant of the stroboscopic map over one period."""
        machine = self.machine(z[-1])
        a, b, c, d = arb(1), arb(0), arb(0), arb(1)  # the product [[a, b], [c, d]] so far
        det = (-2 * machine.Z * machine.turn * self.turns).exp()
        for flight in self.flights(machine, z[:-1]):
            by_theta1, by_v1, by_theta2, by_v2 = flight.start
            theta_theta = -by_theta1 / flight.rate
            theta_v = -by_v1 / flight.rate
            v_theta = -by_theta2 - machine.r * flight.accel * theta_theta
            v_v = -by_v2 - machine.r * flight.accel * theta_v
            a, c = theta_theta * a + theta_v * c, v_theta * a + v_v * c
            b, d = theta_theta * b + theta_v * d, v_theta * b + v_v * d
            det = det * machine.r * machine.r
        return a + d, det

    def admissible(
        self,
        hull: Sequence[arb],
        ends: Sequence[int] = (),
        touch: tuple[int, arb] | None = None,
        fading: int | None = None,
    ) -> None:
        """Show that every orbit in the hull is a motion: raises NotProvedError.

        Every impact lies in its region (those in `ends` on its boundary), bounces, and no flight
        meets the cam on its way; the touch (flight, rad of it) is a gap of zero that is none. The
        fading impact has no rate left, exactly.
        """
        machine = self.machine(hull[-1])
        for k in range(self.n):
            theta = hull[2 * k]
            stretch = self.stretches[self.places[k][0]]
            inside = stretch.start < theta and theta < stretch.end
            if not inside and k not in ends:
                outside = theta < stretch.start or theta > stretch.end
                raise NotProvedError(ProofStep.ELSEWHERE, bool(outside))
            if k != fading and not hull[2 * k + 1] > 0:
                raise NotProvedError(ProofStep.PULLS, bool(hull[2 * k + 1] < 0))
        for k in range(self.n):
            try:
                self._clear(machine, hull, k, touch[1] if touch and touch[0] == k else None, fading)
            except UndecidedError:
                raise NotProvedError(ProofStep.GRAZES) from None

    def gap(self, machine: BallMachine, z: Sequence[Number], k: int, place: Place) -> Gap:
        """s -> gap to a stretch after s rad of flight k, and its derivatives up to the second."""
        c, c1, _ = self.lift(self.places[k], z[2 * k])
        w = c1 + z[2 * k + 1]
        turns = self.places[k][1] - place[1]

        def gap(s: Number) -> list[Number]:
            cam = self.lift(place, z[2 * k] + s + machine.turn * turns)
            return [x - y for x, y in zip(machine.move(c, w, s), cam, strict=False)]

        return gap

    def _clear(
        self, machine: BallMachine, x: Sequence[arb], k: int, touch: arb | None, fading: int | None
    ) -> None:
        """Show that the gap is above zero during flight k, or raise; a touch is passed over."""
        following = (k + 1) % self.n
        whole = self.span(x, k)
        last_stretch, turn = self.places[following]
        last = last_stretch, turn + (self.turns if k == self.n - 1 else 0)
        place = self.places[k]
        low = arb(0)  # up to here the gap is above zero

        def rises(at: Place) -> Callable[[arb], bool]:
            """Whether the gap rises over the first s rad; of no rate at the start: is convex."""
            order = 2 if k == fading else 1
            return lambda s: self.gap(machine, x, k, at)(arb(0).union(s))[order] > 0

        def falls(at: Place, end: arb) -> Callable[[arb], bool]:
            """Whether the gap falls over s rad up to `end`; of no rate there: is convex."""
            if following == fading:
                return lambda s: self.gap(machine, x, k, at)((end - s).union(end))[2] > 0
            return lambda s: self.gap(machine, x, k, at)((end - s).union(end))[1] < 0

        for _ in range(MOST_STRETCHES):
            end = self._end(place, k) - x[2 * k]
            begun = [place]
            if low == 0 and not end > 0:  # from the end of a stretch: off both its sides
                place = self._next(place)
                end = self._end(place, k) - x[2 * k]
                begun.append(place)
            if low == 0:
                low = min(end.lower(), (whole / 2).lower()).mid()
                for at in begun:
                    low = _shrunk(low, rises(at))
            gap = self.gap(machine, x, k, place)
            if touch is not None and place == self.place(x[2 * k] + touch, self.places[k][1]):
                low = _beyond_touch(gap, low, touch, whole / 8)
                touch = None
            if place == last:
                back = _shrunk((whole / 4).mid(), falls(place, whole))
                return _positive(gap, low, whole - back)
            if self._next(place) == last and not end < whole:  # onto the start of a stretch
                back = _shrunk((whole / 4).mid(), falls(place, end))
                if not self.gap(machine, x, k, last)(end.union(whole))[1] < 0:
                    raise UndecidedError
                return _positive(gap, low, end - back)
            _positive(gap, low, end)
            low = end
            place = self._next(place)
        raise UndecidedError

    def touch(self, hull: Sequence[arb], k: int, s: arb) -> tuple[Place, arb]:
        """Where flight k comes nearest to the cam, near s rad: its place, and s in a ball."""
        place = self.place(hull[2 * k] + s, self.places[k][1])
        gap = self.gap(self.machine(hull[-1]), hull, k, place)
        s = s.mid()
        for _ in range(MIDDLE_STEPS):
            s = (s - gap(s)[1] / gap(s)[2]).mid()
        wide = 2 * abs(gap(s)[1] / gap(s)[2]).upper() + arb(2) ** (24 - ctx.prec)
        zero = s - gap(s)[1] / gap(arb(s, wide))[2]
        if not arb(s, wide).contains_interior(zero):
            raise NotProvedError(ProofStep.GRAZES)
        return place, zero

    def place(self, theta: arb, turn: int) -> Place:
        """Stretch and turn of an angle counted on from the beginning of a turn."""
        later = int(float((theta / (2 * arb.pi())).mid().floor()))
        rest = theta.mid() - 2 * arb.pi() * later
        return next(k for k, s in enumerate(self.stretches) if rest < s.end), turn + later

    def _end(self, place: Place, k: int) -> arb:
        """Angle, counted as that of impact k, at which a stretch ends."""
        return self.stretches[place[0]].end + 2 * arb.pi() * (place[1] - self.places[k][1])

    def _next(self, place: Place) -> Place:
        i, turn = place
        return (i + 1, turn) if i + 1 < len(self.stretches) else (0, turn + 1)


def _columns(matrix: arb_mat, chosen: Sequence[int]) -> arb_mat:
    return arb_mat([[matrix[i, j] for j in chosen] for i in range(matrix.nrows())])


def _beyond_touch(gap: Gap, low: arb, touch: arb, room: arb) -> arb:
    """Show that the gap is above zero up to a touch and convex about it; an angle behind it."""
    wide = _shrunk(room.mid(), lambda s: gap((touch - s).union(touch + s))[2] > 0)
    _positive(gap, low, touch - wide)
    return touch + wide


def _shrunk(s: arb, holds: Callable[[arb], bool]) -> arb:
    """The first of s, s/2, s/4, ... for which something holds; raises UndecidedError."""
    for _ in range(END_HALVINGS):
        if holds(s):
            return s
        s = (s / 2).mid()
    raise UndecidedError


def _positive(gap: Gap, low: arb, high: arb) -> None:
    """Show that a gap above zero at `low` stays there up to `high`, or raise."""
    low, high = low.lower(), high.upper()
    if low < high and first_root(gap, low, high) is not None:
        raise NotProvedError(ProofStep.CONTACT, True)
