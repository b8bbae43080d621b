"""Periodic orbits proved: the shooting equations in balls, solved by Krawczyk's method.

Terms of this file. Impact k of a period is at the cam angle theta_k (rad, within the turn) and
leaves the cam at the relative rate v_k (m/rad). Flight k leads from it to the next impact, and from
the last one to the first of the next period. The unknowns are x = theta_0, v_0, theta_1, v_1, ...;
z is x followed by p, one parameter of the machine. Each flight gives two equations, those of
`kernel.shooting`: E1 = gap where it ends, and E2 = r u + v', where u is the rate it lands at and v'
the rate that the next impact leaves at. If

    K(X) = z - Y E(z) + (1 - Y E'(X)) (X - z)

lies inside the box X about z, there is exactly one zero of E in X, and it lies in K(X)
(R. Krawczyk, Computing 4 (1969) 187; R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to
Interval Analysis, 2009, ch. 8). One unknown, mostly p, is given: its index in z is `fixed`, and its
value is a number, or an interval, over which the box leans along the branch. Numbers are balls
(`arb`), or power series of two coefficients: a ball and its derivative along the branch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series, ctx

from camcli.cams.balls import UndecidedError, head, slope
from camcli.cams.compile import Shape
from camcli.cams.varied import constants_of, with_number
from camcli.exact.first_root import first_root
from camcli.exact.machine import (
    BallMachine,
    BallStretch,
    Place,
    identity,
    stretches_of,
    varied_stretches,
)
from camcli.quantities import PARAMETERS
from camcli.system import Follower

MIDDLE_STEPS = 12  # steps towards the middle of a box
FILLED = 0.6  # of a box's errors over a number of the cam: a checker encloses its lift less sharply
INFLATIONS = 8  # boxes tried, each twice as wide as what came out of the last one
END_HALVINGS = 60  # of an interval at either end of a flight, on which the gap rises or falls
MOST_STRETCHES = 10_000  # passed in one flight, before it is given up

Number = Any  # a ball, or a series of two coefficients: a number and its derivative
Gap = Callable[[arb], list[Any]]  # s -> gap after s rad of a flight, and derivatives
TestFunction = Callable[[list[Number]], Number]  # of the unknowns z = x, p as series
Equations = Callable[[Sequence[arb]], tuple[arb_mat, arb_mat]]  # z -> (E, E')


class Touch(NamedTuple):
    """Where a flight touches the cam without an impact: its number, and rad after its start."""

    flight: int
    angle: arb


class ProofStep(StrEnum):
    """The step of a proof that failed; `camcli.words.proofs` says it in words."""

    NO_ORBIT = "no-orbit"  # the orbit proved is another than the one found
    SINGULAR = "singular"  # no box was shown to hold exactly one orbit
    ELSEWHERE = "elsewhere"  # an impact lies outside its stretch of the cam
    PASSES = "passes"  # between two points an impact passes an end of its stretch, or the strobe
    STROBE = "strobe"  # an impact may lie on the other side of the strobe, where the label changes
    PULLS = "pulls"  # an impact leaves the cam at a negative rate
    CONTACT = "contact"  # a flight meets the cam on its way
    GRAZES = "grazes"  # a flight comes too near to the cam to exclude that
    NEUTRAL = "neutral"  # a multiplier is too near to the unit circle
    CROSSING = "crossing"  # the test function of an event was not shown to cross zero
    NUMBER = "number"  # an event's value lies outside the error claimed for it
    BOXES = "boxes"  # more boxes would be needed than are tried
    WORK_BUDGET = "work-budget"
    FAULT = "fault"  # an exception that nobody foresaw
    MODEL = "model"  # an orbit of a kind that is not proved
    CAM = "cam"  # the parameter is a number over which the cam is not known in balls
    NO_CHAIN = "no-chain"  # no impacts were found that leave an orbit and come back to it
    COVERING = "covering"  # a box was not shown to be mapped over another one


class NotProvedError(Exception):
    """The proof failed; `step` says where, `refuted` that the contrary was shown."""

    def __init__(self, step: ProofStep, refuted: bool = False):
        super().__init__(step)
        self.step = step
        self.refuted = refuted


class StartSlopes(NamedTuple):
    """Derivatives of a flight's E1 and E2 by theta and v of the impact that it starts from."""

    gap_by_theta: Number  # of E1
    gap_by_v: Number
    bounce_by_theta: Number  # of E2
    bounce_by_v: Number


class ImpactSlopes(NamedTuple):
    """How (dtheta, dv) of an impact move those of a later one: a matrix of balls, or of series."""

    theta_by_theta: Number
    theta_by_v: Number
    v_by_theta: Number
    v_by_v: Number

    def after(self, earlier: ImpactSlopes) -> ImpactSlopes:
        """The product self * earlier: first the earlier one, then this one."""
        return ImpactSlopes(
            theta_by_theta=self.theta_by_theta * earlier.theta_by_theta
            + self.theta_by_v * earlier.v_by_theta,
            theta_by_v=self.theta_by_theta * earlier.theta_by_v + self.theta_by_v * earlier.v_by_v,
            v_by_theta=self.v_by_theta * earlier.theta_by_theta + self.v_by_v * earlier.v_by_theta,
            v_by_v=self.v_by_theta * earlier.theta_by_v + self.v_by_v * earlier.v_by_v,
        )

    @property
    def trace(self) -> Number:
        """The sum of both multipliers."""
        return self.theta_by_theta + self.v_by_v


class StateSlopes(NamedTuple):
    """Derivatives of (q, w) after some flight by theta and v of the impact that it starts from."""

    q_by_theta: Number
    q_by_v: Number
    w_by_theta: Number
    w_by_v: Number

    @classmethod
    def after(cls, machine: BallMachine, s: Number, v: Number, accel: Number) -> StateSlopes:
        """After s rad of a flight that leaves the cam at the rate v (m/rad) with gap'' = accel.

        Moved by dtheta along the cam, the flight begins v dtheta lower than it would have been and
        -accel dtheta faster; moved by dv it begins dv faster. At a fixed phase (q, w) changes with
        the start's q by (1 - W^2 P, -W^2 B), with its w by (B, B').
        """
        b, b1, p = machine.flow(s)
        return cls(
            q_by_theta=-(v * (1 - machine.W2 * p) + b * accel),
            q_by_v=b,
            w_by_theta=machine.W2 * b * v - b1 * accel,
            w_by_v=b1,
        )


class BallFlight(NamedTuple):
    """A flight where it meets the cam again, and how that depends on where it started."""

    gap: Number  # m, E1
    rate: Number  # m/rad, of the gap
    accel: Number  # m/rad^2, of the gap
    r: Number  # restitution where it lands
    by_start: StartSlopes

    def slopes(self) -> ImpactSlopes:
        """The derivatives of the impact at the end of the flight by the impact at its start.

        The equations E1 and E2 of the flight stay zero where both are moved.
        """
        theta_by_theta = -self.by_start.gap_by_theta / self.rate
        theta_by_v = -self.by_start.gap_by_v / self.rate
        return ImpactSlopes(
            theta_by_theta=theta_by_theta,
            theta_by_v=theta_by_v,
            v_by_theta=-self.by_start.bounce_by_theta - self.r * self.accel * theta_by_theta,
            v_by_v=-self.by_start.bounce_by_v - self.r * self.accel * theta_by_v,
        )

    def slopes_times_rate(self) -> ImpactSlopes:
        """`slopes` times the rate at which the flight lands: regular where that is zero."""
        theta_by_theta = -self.by_start.gap_by_theta
        theta_by_v = -self.by_start.gap_by_v
        accel_after = self.r * self.accel
        return ImpactSlopes(
            theta_by_theta=theta_by_theta,
            theta_by_v=theta_by_v,
            v_by_theta=-self.by_start.bounce_by_theta * self.rate - accel_after * theta_by_theta,
            v_by_v=-self.by_start.bounce_by_v * self.rate - accel_after * theta_by_v,
        )


@dataclass(frozen=True)
class Box:
    """The points z = middle + tangent eta + error, |eta| <= half: one orbit for every eta.

    eta is how far the given unknown, z[fixed], differs from its middle: its tangent is 1, its error
    0. The others have their tangent along the branch, and a ball about 0 as their error. within:
    the larger errors, within which there is no other orbit; inverse: Y, with which that was shown.
    """

    middle: list[arb]
    tangent: list[arb]
    error: list[arb]
    fixed: int
    half: arb
    within: list[arb]
    inverse: arb_mat

    def hull(self) -> list[arb]:
        """A ball for each unknown that holds it in every orbit of the box."""
        return self.orbit_at(arb(0, self.half))

    def orbit_at(self, eta: arb) -> list[arb]:
        """Balls about the orbit whose given unknown differs by eta from its middle."""
        parts = zip(self.middle, self.tangent, self.error, strict=True)
        return [z + t * eta + e for z, t, e in parts]

    def holds(self, orbit: Sequence[arb]) -> bool:
        """True where an orbit, each unknown known in a ball, is certainly one of the box's own.

        It is where it lies within the larger errors, for there is no other one there.
        """
        eta = orbit[self.fixed] - self.middle[self.fixed]
        if not abs(eta) <= self.half:
            return False
        for k, x in enumerate(orbit):
            off = x - self.middle[k] - self.tangent[k] * eta
            if k != self.fixed and not self.within[k].contains(off):
                return False
        return True


@dataclass(frozen=True)
class Shooting:
    """The equations of an orbit with n impacts in so many turns; use it at one precision only.

    parameter: what is the last unknown: `rpm`, a constant of the follower, or the key of a number
    of the cam; shape, follower, rpm: the machine where the parameter changes nothing of it; places:
    stretch and turn of each impact.
    """

    shape: Shape
    follower: Follower
    rpm: Any
    parameter: str
    places: tuple[Place, ...]
    turns: int

    @cached_property
    def stretches(self) -> list[BallStretch]:
        """The stretches of the cam, in the digits in use when they are first asked for."""
        return stretches_of(self.shape)

    def with_stretches(self, stretches: list[BallStretch]) -> Shooting:
        """The same equations with the stretches of the cam as they are given, not made anew."""
        same = replace(self)
        same.__dict__["stretches"] = stretches  # in the place of the cached property
        return same

    @property
    def n(self) -> int:
        """Impacts in a period."""
        return len(self.places)

    @property
    def in_cam(self) -> bool:
        """Whether the parameter is a number of the cam."""
        return self.parameter not in PARAMETERS

    def machine(self, p: Number) -> BallMachine:
        """The machine whose parameter has the value p.

        Where p is a number of the cam, that cam must certainly have as many stretches as the shape:
        raises UndecidedError where the balls do not tell, or it has others.
        """
        if self.parameter == "rpm":
            return BallMachine(self.stretches, self.follower, p)
        if not self.in_cam:
            changed = replace(self.follower, **{self.parameter: p})
            return BallMachine(self.stretches, changed, self.rpm)
        shape, follower, rpm = varied_machine(
            self.shape, self.follower, self.rpm, self.parameter, p
        )
        stretches = (varied_stretches if isinstance(p, arb_series) else stretches_of)(shape)
        if len(stretches) != len(self.stretches):
            raise UndecidedError
        return BallMachine(stretches, follower, rpm)

    def lift(
        self, machine: BallMachine, place: Place, theta: Number, order: int = 2
    ) -> list[Number]:
        """[c, c_theta, ...] up to a derivative's order, at an angle of the turn; m and rad.

        A series of angles gives a series each, by the chain rule.
        """
        stretch = machine.stretches[place.stretch]
        if stretch.varies or not isinstance(theta, arb_series):
            return stretch.derivatives(theta, order)
        c = stretch.derivatives(theta[0], order + 1)
        return [arb_series([c[k], c[k + 1] * theta[1]], 2) for k in range(order + 1)]

    def span(self, x: Sequence[Number], k: int) -> Number:
        """How long flight k between the impacts x lasts, rad."""
        after = (k + 1) % self.n
        turns = self.landing(k).turn - self.places[k].turn
        return x[2 * after] - x[2 * k] + 2 * arb.pi() * turns

    def landing(self, k: int) -> Place:
        """Where flight k lands; the flight from the last impact does so in the next period."""
        if k < self.n - 1:
            return self.places[k + 1]
        first = self.places[0]
        return Place(first.stretch, first.turn + self.turns)

    def flights(self, machine: BallMachine, x: Sequence[Number]) -> list[BallFlight]:
        """The n flights between the impacts x."""
        return [self.flight(machine, x, k) for k in range(self.n)]

    def flight(self, machine: BallMachine, x: Sequence[Number], k: int) -> BallFlight:
        """Flight k between the impacts x, by the closed form of `kernel.flow`.

        Its slopes by the start: moved by dtheta along the cam, the flight begins v dtheta lower
        than it would have been and (c'' - q'') dtheta faster, moved by dv it begins dv faster.
        """
        after = (k + 1) % self.n
        v = x[2 * k + 1]
        r = machine.restitution(self.places[after].stretch)
        c, c1, c2 = self.lift(machine, self.places[k], x[2 * k])
        end_c, end_c1, end_c2 = self.lift(machine, self.places[after], x[2 * after])
        b, b1, p = machine.flow(self.span(x, k))
        w = c1 + v
        force = machine.G + machine.W2 * c
        end_q = c + w * b - force * p
        end_w = w * b1 - force * b
        accel = -(force + 2 * machine.Z * w) - c2  # of the gap as the flight begins
        end_accel = -(machine.G + machine.W2 * end_q + 2 * machine.Z * end_w) - end_c2
        by_start = StartSlopes(
            gap_by_theta=-(v * (1 - machine.W2 * p) + b * accel),
            gap_by_v=b,
            bounce_by_theta=r * (machine.W2 * b * v - b1 * accel),
            bounce_by_v=r * b1,
        )
        return BallFlight(
            gap=end_q - end_c, rate=end_w - end_c1, accel=end_accel, r=r, by_start=by_start
        )

    def equations(self, z: Sequence[arb]) -> tuple[arb_mat, arb_mat]:
        """(E, E') at the unknowns z: (2 n, 1) and (2 n, 2 n + 1), rows E1, E2 of each flight.

        The derivatives by p are the slopes of series, those by the impacts have closed forms.
        """
        n = self.n
        machine = self.machine(arb_series([z[-1], 1], 2))
        values = [[arb(0)] for _ in range(2 * n)]
        rows = [[arb(0)] * (2 * n + 1) for _ in range(2 * n)]
        for k, flight in enumerate(self.flights(machine, z[:-1])):
            theta = 2 * k  # indices in z: of the impact the flight begins with,
            v = theta + 1
            next_theta = 2 * ((k + 1) % n)  # and of the one that it ends with
            next_v = next_theta + 1
            bounce = flight.r * flight.rate + z[next_v]
            slopes = flight.by_start
            gap_row = rows[2 * k]
            values[2 * k][0] = head(flight.gap)
            gap_row[-1] = slope(flight.gap)
            gap_row[theta] += head(slopes.gap_by_theta)
            gap_row[v] += head(slopes.gap_by_v)
            gap_row[next_theta] += head(flight.rate)
            bounce_row = rows[2 * k + 1]
            values[2 * k + 1][0] = head(bounce)
            bounce_row[-1] = slope(bounce)
            bounce_row[theta] += head(slopes.bounce_by_theta)
            bounce_row[v] += head(slopes.bounce_by_v)
            bounce_row[next_theta] += head(flight.r) * head(flight.accel)
            bounce_row[next_v] += 1
        return arb_mat(values), arb_mat(rows)

    def box(self, guess: Sequence[arb], fixed: int, half: arb | int = 0) -> Box:
        """A box with exactly one orbit for every value of the given unknown within `half`.

        guess: z near an orbit, whose given unknown stays as it is. Raises NotProvedError.
        """
        filled = FILLED if self.in_cam else 1
        return box_of(self.equations, guess, fixed, half, filled)

    def along(self, hull: Sequence[arb], fixed: int) -> list[Number]:
        """The unknowns as series in the given one: with the derivatives of the whole branch.

        The derivatives hold for all orbits in the hull: dz/dz_fixed solves E' dz = 0. Raises
        NotProvedError.
        """
        _, slopes = self.equations(hull)
        free = [k for k in range(len(hull)) if k != fixed]
        try:
            minus_tangent = _columns(slopes, free).solve(_columns(slopes, [fixed])).entries()
        except ZeroDivisionError:
            raise NotProvedError(ProofStep.SINGULAR) from None
        tangent = [arb(1)] * len(hull)
        for k, minus in zip(free, minus_tangent, strict=True):
            tangent[k] = -minus
        return [arb_series([x, by_fixed], 2) for x, by_fixed in zip(hull, tangent, strict=True)]

    def zero(
        self, guess: Sequence[arb], fixed: int, test: TestFunction, reach: arb | None = None
    ) -> tuple[Box, Box]:
        """(zero, around): the box of the only zero of a test function in a wider box around it.

        guess: z near the zero; reach: how far the given unknown goes to either side in `around`,
        None for as little as the digits allow. The test is taken along the branch, over the given
        unknown; its slope keeps its sign on all of the reach, so that the zero is simple: the
        interval Newton method shows both. Raises NotProvedError.
        """
        small = arb(2) ** (-ctx.prec // 2)  # half of the digits
        box = self.box(guess, fixed)
        for _ in range(MIDDLE_STEPS):
            value = test(self.along(box.hull(), fixed))
            step = (head(value) / slope(value)).mid()
            box.middle[fixed] = (box.middle[fixed] - step).mid()
            box = self.box(box.middle, fixed)
            if abs(step) < (1 + abs(box.middle[fixed])) * small:
                break
        center = box.middle[fixed]
        value = head(test(self.along(box.hull(), fixed)))
        least = (1 + abs(center)) * small
        half = least if reach is None else reach
        around = self.box(box.middle, fixed, half)
        root = center - value / slope(test(self.along(around.hull(), fixed)))
        if not arb(center, half.mid()).contains_interior(root):
            raise NotProvedError(ProofStep.CROSSING)
        middle = list(box.middle)
        middle[fixed] = root.mid()
        return self.box(middle, fixed, root.rad() + least**2), around

    def trace_det(self, z: Sequence[Number]) -> tuple[Number, Number]:
        """Trace and determinant of the stroboscopic map over one period, from the unknowns z.

        The map is the product of one matrix a flight. Its determinant follows from what is lost in
        flights and impacts, without the matrices.
        """
        machine = self.machine(z[-1])
        product = ImpactSlopes(arb(1), arb(0), arb(0), arb(1))
        det = (-2 * machine.Z * machine.turn * self.turns).exp()
        for flight in self.flights(machine, z[:-1]):
            product = flight.slopes().after(product)
            det = det * flight.r * flight.r
        return product.trace, det

    def admissible(
        self,
        hull: Sequence[arb],
        ends: Sequence[int] = (),
        touch: Touch | None = None,
        fading: int | None = None,
    ) -> None:
        """Show that every orbit in the hull is a motion: raises NotProvedError.

        Every impact lies on its stretch and bounces, and no flight meets the cam on its way.
        ends: impacts that may lie where their stretch begins or ends; touch: where the gap is zero
        without an impact; fading: the impact that has a rate of exactly zero.
        """
        machine = self.machine(hull[-1])
        for k, place in enumerate(self.places):
            theta = hull[2 * k]
            v = hull[2 * k + 1]
            stretch = machine.stretches[place.stretch]
            inside = stretch.start < theta and theta < stretch.end
            if not inside and k not in ends:
                outside = theta < stretch.start or theta > stretch.end
                raise NotProvedError(ProofStep.ELSEWHERE, refuted=bool(outside))
            if k != fading and not v > 0:
                raise NotProvedError(ProofStep.PULLS, refuted=bool(v < 0))
        for k in range(self.n):
            touched = touch.angle if touch is not None and touch.flight == k else None
            flight = FlightToShow(self, machine, hull, k, fading)
            try:
                flight.stays_off_the_cam(touched)
            except UndecidedError:
                raise NotProvedError(ProofStep.GRAZES) from None

    def gap(self, machine: BallMachine, z: Sequence[Number], k: int, place: Place) -> Gap:
        """The function s -> [gap, gap', gap''] after s rad of flight k, m and rad.

        The gap is that to the cam's stretch at `place`, continued beyond its ends.
        """
        theta = z[2 * k]
        v = z[2 * k + 1]
        c, c1, _ = self.lift(machine, self.places[k], theta)
        w = c1 + v
        turns = self.places[k].turn - place.turn

        def gap(s: Number) -> list[Number]:
            cam = self.lift(machine, place, theta + s + machine.turn * turns)
            return [x - y for x, y in zip(machine.move(c, w, s), cam, strict=False)]

        return gap

    def passed(self, k: int) -> list[Place]:
        """The stretches that flight k passes, from that of its impact to that of the next."""
        places = [self.places[k]]
        last = self.landing(k)
        while places[-1] != last and len(places) < MOST_STRETCHES:
            places.append(places[-1].next(len(self.stretches)))
        return places

    def touch(self, hull: Sequence[arb], k: int, s: arb) -> tuple[Place, arb]:
        """Where flight k comes nearest to the cam, near s rad: (place, rad of flight in a ball).

        That is the zero of gap', enclosed by the interval Newton method. Raises NotProvedError.
        """
        machine = self.machine(hull[-1])
        place = self.place(hull[2 * k] + s, self.places[k].turn, machine)
        gap = self.gap(machine, hull, k, place)
        s = s.mid()
        for _ in range(MIDDLE_STEPS):
            s = (s - gap(s)[1] / gap(s)[2]).mid()
        wide = 2 * abs(gap(s)[1] / gap(s)[2]).upper() + arb(2) ** (24 - ctx.prec)
        zero = s - gap(s)[1] / gap(arb(s, wide))[2]
        if not arb(s, wide).contains_interior(zero):
            raise NotProvedError(ProofStep.GRAZES)
        return place, zero

    def place(self, theta: arb, turn: int, machine: BallMachine | None = None) -> Place:
        """The stretch and the turn that hold an angle, rad from the begin of a turn.

        The angle may be beyond 2 pi, or below zero; of a ball the middle is taken. Raises
        UndecidedError where it is so near to a whole turn that the turn is not certain.
        """
        stretches = self.stretches if machine is None else machine.stretches
        turns_on = int(float((theta / (2 * arb.pi())).mid().floor()))
        in_turn = theta.mid() - 2 * arb.pi() * turns_on
        index = next((k for k, stretch in enumerate(stretches) if in_turn < stretch.end), None)
        if index is None:
            raise UndecidedError
        return Place(index, turn + turns_on)


class FlightToShow:
    """A flight of all orbits in a hull, whose gap is to be shown above zero on its way.

    k: its number; fading: the impact that has no rate, or None.
    """

    def __init__(
        self,
        shooting: Shooting,
        machine: BallMachine,
        hull: Sequence[arb],
        k: int,
        fading: int | None,
    ):
        self.shooting = shooting
        self.machine = machine
        self.hull = hull
        self.k = k
        self.starts_without_rate = k == fading
        self.ends_without_rate = (k + 1) % shooting.n == fading

    def gap(self, place: Place) -> Gap:
        """The function s -> [gap, gap', gap''], to the cam's stretch at a place."""
        return self.shooting.gap(self.machine, self.hull, self.k, place)

    def end_of(self, place: Place) -> arb:
        """The angle of flight at which the stretch at a place ends, rad."""
        turns = place.turn - self.shooting.places[self.k].turn
        end = self.machine.stretches[place.stretch].end + 2 * arb.pi() * turns
        return end - self.hull[2 * self.k]

    def rises_over(self, place: Place) -> Callable[[arb], bool]:
        """The test whether the gap rises over the first s rad; without a rate it is convex."""
        order = 2 if self.starts_without_rate else 1
        return lambda s: self.gap(place)(arb(0).union(s))[order] > 0

    def falls_up_to(self, place: Place, end: arb) -> Callable[[arb], bool]:
        """The test whether the gap falls over the last s rad up to `end`; or is convex."""
        if self.ends_without_rate:
            return lambda s: self.gap(place)((end - s).union(end))[2] > 0
        return lambda s: self.gap(place)((end - s).union(end))[1] < 0

    def stays_off_the_cam(self, touch: arb | None) -> None:
        """Show that the gap is above zero during the flight; raises NotProved- or UndecidedError.

        It is zero at both ends of the flight: there a first interval is found on which it rises,
        and a last one on which it falls. Between them the flight is walked stretch by stretch of
        the cam. A touch, rad after the flight's start, is passed over. Where an end of the flight
        is the fading impact, the gap has no slope there: it is convex instead.
        """
        shooting = self.shooting
        count = len(shooting.stretches)
        length = shooting.span(self.hull, self.k)
        last = shooting.landing(self.k)
        place = shooting.places[self.k]
        touched = None
        if touch is not None:
            theta = self.hull[2 * self.k] + touch
            touched = shooting.place(theta, place.turn, self.machine)
        low = arb(0)  # the gap is shown to be above zero from the start to this angle of flight
        for _ in range(MOST_STRETCHES):
            end = self.end_of(place)
            touching = [place]  # stretches that the flight starts on
            if low == 0 and not end > 0:  # from the end of a stretch: off both its sides
                place = place.next(count)
                end = self.end_of(place)
                touching.append(place)
            # How far it rises is tried from here on. A longer try would prove nothing false: beyond
            # the stretch's end the walk begins at that end again, and where it reaches the part
            # on which the gap falls, no slope is both above and below zero.
            if low == 0:
                low = min(end.lower(), (length / 2).lower()).mid()
                for beside in touching:
                    low = _first_half(low, self.rises_over(beside))
            gap = self.gap(place)
            if touch is not None and place == touched:
                low = _beyond_touch(gap, low, touch, length / 8)
            if place == last:
                back = _first_half((length / 4).mid(), self.falls_up_to(place, length))
                return _show_no_zero(gap, low, length - back)
            if place.next(count) == last and not end < length:  # onto the start of a stretch
                back = _first_half((length / 4).mid(), self.falls_up_to(place, end))
                if not self.gap(last)(end.union(length))[1] < 0:
                    raise UndecidedError
                return _show_no_zero(gap, low, end - back)
            _show_no_zero(gap, low, end)
            low = end
            place = place.next(count)
        raise UndecidedError


def box_of(
    equations: Equations,
    guess: Sequence[arb],
    fixed: int,
    half: arb | int = 0,
    filled: float = 1,
) -> Box:
    """A box with exactly one zero of some equations for each value of the given unknown.

    equations: one fewer than unknowns; guess: z near a zero, whose given unknown, z[fixed], stays
    as it is; half: by how much it varies to either side; filled: the share of the errors that the
    operator's image may fill. Raises NotProvedError.
    """
    try:
        exact_guess = [x.mid() for x in guess]
        return _krawczyk(equations, exact_guess, fixed, arb(half).mid(), filled)
    except (ZeroDivisionError, ValueError, UndecidedError):
        raise NotProvedError(ProofStep.SINGULAR) from None


def _krawczyk(equations: Equations, guess: list[arb], fixed: int, half: arb, filled: float) -> Box:
    """`box_of` from a guess of exact numbers.

    Krawczyk's operator maps the errors e of the free unknowns to (1 - Y E') e - Y E(z) - Y E' t eta
    (t: the tangent), into themselves where there is exactly one root; the errors are widened until
    they are. Y is an exact approximate inverse of E' by the free unknowns.
    """
    free = [k for k in range(len(guess)) if k != fixed]
    middle, inverse = _newton(equations, guess, free)
    value, slopes = equations(middle)
    off = inverse * value  # Y E(z)
    tangent = _tangent(inverse, slopes, free, fixed)
    eta = arb(0, half)
    unit = identity(len(free))
    sizes = [abs(x).upper() * 2 + arb(2) ** (24 - ctx.prec) for x in off.entries()]
    for _ in range(INFLATIONS):
        error = _spread_out(middle, free, [arb(0, size) for size in sizes])
        box = Box(middle, tangent, error, fixed, half, within=error, inverse=inverse)
        _, slopes = equations(box.hull())
        free_errors = arb_mat([[error[k]] for k in free])
        contracted = (unit - inverse * _columns(slopes, free)) * free_errors
        along = inverse * (slopes * arb_mat([[t] for t in tangent])) * eta
        image = (contracted - off - along).entries()
        allowed = [error[k] * filled for k in free]
        if all(e.contains_interior(x) for e, x in zip(allowed, image, strict=True)):
            return replace(box, error=_spread_out(middle, free, image))
        sizes = [2 * max(size, abs(x).upper()) for size, x in zip(sizes, image, strict=True)]
    raise NotProvedError(ProofStep.SINGULAR)


def _spread_out(middle: Sequence[arb], free: list[int], values: Sequence[arb]) -> list[arb]:
    """A list as long as `middle` with the values at the free indices, and zero at the given one."""
    everywhere = [arb(0)] * len(middle)
    for k, value in zip(free, values, strict=True):
        everywhere[k] = value
    return everywhere


def _newton(equations: Equations, guess: list[arb], free: list[int]) -> tuple[list[arb], arb_mat]:
    """(z, Y): a root to the digits in use, in exact numbers, and the inverse of E' near it.

    Only the unknowns whose indices are in `free` are moved.
    """
    z = list(guess)
    small = arb(2) ** (16 - ctx.prec)
    for _ in range(MIDDLE_STEPS):
        value, slopes = equations(z)
        inverse = _columns(slopes, free).mid().inv().mid()
        step = (inverse * value).entries()
        for k, change in zip(free, step, strict=True):
            z[k] = (z[k] - change).mid()
        pairs = zip(free, step, strict=True)
        if all(s.contains(0) or abs(s) < (1 + abs(z[k])) * small for k, s in pairs):
            break
    return z, inverse


def varied_machine(
    shape: Shape, follower: Follower, rpm: Any, key: str, p: Number
) -> tuple[Shape, Follower, Any]:
    """Cam, follower and speed (rpm) where the number of the cam at a key of the scene is p."""
    varied = with_number(shape, key, p)
    constants = constants_of(varied)
    speed = constants.pop("rpm", rpm)
    return varied, replace(follower, **constants), speed


def _columns(matrix: arb_mat, chosen: Sequence[int]) -> arb_mat:
    """The matrix of the chosen columns, in their order."""
    return arb_mat([[matrix[i, j] for j in chosen] for i in range(matrix.nrows())])


def _tangent(inverse: arb_mat, slopes: arb_mat, free: list[int], fixed: int) -> list[arb]:
    """How fast each unknown changes with the given one along the branch, as exact numbers.

    inverse: Y; slopes: E'. By the free unknowns it is -Y E'_fixed, by the given one itself 1.
    """
    tangent = [arb(0)] * (len(free) + 1)
    tangent[fixed] = arb(1)
    by_fixed = (inverse * _columns(slopes, [fixed])).mid().entries()
    for k, t in zip(free, by_fixed, strict=True):
        tangent[k] = -t
    return tangent


def _beyond_touch(gap: Gap, low: arb, touch: arb, room: arb) -> arb:
    """Pass a touch: an angle of flight behind it, up to which the gap is zero only there.

    The gap, above zero at `low`, is shown to have no zero up to an interval about the touch, at
    most `room` to either side, and to be convex on that interval. All are rad of flight; raises
    NotProvedError or UndecidedError.
    """
    half = _first_half(room.mid(), lambda s: gap((touch - s).union(touch + s))[2] > 0)
    _show_no_zero(gap, low, touch - half)
    return touch + half


def _first_half(s: arb, holds: Callable[[arb], bool]) -> arb:
    """The first of s, s/2, s/4, ... for which `holds` is true; raises UndecidedError."""
    for _ in range(END_HALVINGS):
        if holds(s):
            return s
        s = (s / 2).mid()
    raise UndecidedError


def _show_no_zero(gap: Gap, low: arb, high: arb) -> None:
    """Show that a gap above zero at `low` stays there up to `high`, or raise NotProvedError."""
    first = low.lower()
    last = high.upper()
    if first < last and first_root(gap, first, last) is not None:
        raise NotProvedError(ProofStep.CONTACT, refuted=True)
