"""The motion from a rest on, in balls: lift-off, flight, impact, complete chatter, rest, and so on.

In flight q'' = -(G + W2 q) - 2 Z q', derivatives by the cam's angle, with the constants of
`BallMachine`. Angles phi are those of the cam, counted on from turn to turn: phi = theta + 2 pi n.
Every decision is certain; UndecidedError says that the balls in use are too wide for it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from flint import arb, arb_mat, ctx

from camcli.cams.balls import UndecidedError, below, coarsely
from camcli.cams.compile import SMALLEST_KICK
from camcli.exact.first_root import Function, first_root, sharpened
from camcli.exact.machine import BallMachine, Place

BEFORE = 1e-6  # rad: so long before a departure, as doubles know it, the follower rests
MOST_STRETCHES = 10_000  # of one flight
SLACK = 2.0**-48  # of the length of a flight
HOP = 2.5  # times rate/fall: a hop lasts 2 of them, more or less
MOST_HALVINGS = 60  # of the first interval of a flight
GUARD = 64  # bits beyond the known ones
LIFT_OFF, CORNER, BLOW = 3, 2, 1  # order of the first derivative of the gap that is above zero


@dataclass(frozen=True)
class Parallelogram:
    """m + p t + Q e: all (phase, rate) that a motion may have, over all machines it is about.

    middle: m; lean: p, how they move with t, which tells the machines apart: |t| <= 1 is the same
    all along a motion; frame: Q; error: e, two balls about zero. m, p and Q are exact.

    Errors that turn and stretch are not made boxes of: e is in two balls and Q nearly orthonormal
    (R. J. Lohner, Enclosing the solutions of ordinary initial and boundary value problems, 1987).
    Boxes instead lose 0.9 digits at every impact of a motion whose errors grow by 0.1.
    """

    middle: arb_mat
    lean: arb_mat
    frame: arb_mat
    error: arb_mat

    @classmethod
    def around(cls, x: arb, y: arb) -> Parallelogram:
        """Two independent balls."""
        middle = arb_mat([[x.mid()], [y.mid()]])
        frame = arb_mat([[1, 0], [0, 1]])
        return cls(middle, arb_mat(2, 1), frame, arb_mat([[x], [y]]) - middle)

    def hull(self) -> tuple[arb, arb]:
        """The balls that hold each number."""
        x, y = (self.middle + self.lean * arb(0, 1) + self.frame * self.error).entries()
        return x, y

    def image(
        self, of_middle: arb_mat, jacobian: arb_mat, drift: arb_mat, unit: arb_mat
    ) -> Parallelogram:
        """The parallelogram that holds F(x) of all x in this one: F(m) + (J p + d) t + J Q e.

        of_middle: F(m); jacobian, drift: J and d, which hold the derivatives of F by x and by t at
        all points and all t. The new Q is orthonormal in numbers y = x / unit. Raises
        UndecidedError where the balls in J are too wide for a new Q.
        """
        middle = of_middle.mid()
        lean_balls = jacobian * self.lean + drift
        lean = lean_balls.mid()
        spread = jacobian * self.frame
        frame = self._new_frame(spread, unit)
        try:
            left_out = of_middle - middle + (lean_balls - lean) * arb(0, 1)
            error = frame.inv() * (spread * self.error + left_out)
        except ZeroDivisionError:  # its columns are known too badly to tell them apart
            raise UndecidedError from None
        return Parallelogram(middle, lean, frame, error)

    def _new_frame(self, spread: arb_mat, unit: arb_mat) -> arb_mat:
        """The frame, orthonormal in numbers x / unit, in which the longer side keeps its direction.

        spread: the sides of the image, J Q, as columns, to be taken as far as `error` says.
        """
        first_x, second_x, first_y, second_y = (unit.inv() * spread).mid().entries()
        first_reach, second_reach = (x.rad() for x in self.error.entries())
        first_square = first_x * first_x + first_y * first_y
        second_square = second_x * second_x + second_y * second_y
        x = first_x
        y = first_y
        square = first_square
        if first_square * first_reach**2 <= second_square * second_reach**2:
            x = second_x
            y = second_y
            square = second_square
        return (unit * arb_mat([[x, -y], [y, x]]) / square.sqrt()).mid()


class EndlessError(Exception):
    """The follower rests for good, or never comes back."""


@dataclass
class Trail:
    """The past of a motion.

    impacts: (phi, incoming rate m/rad) of each; states: (q m, dq/dtheta m/rad) at strobe k + 1;
    symbols: of turn k, which ends there, its number of impacts, or inf where a chatter ends in it;
    chatters: balls of phi that hold the accumulation; leaves: phi of the departures from rest.
    """

    impacts: list[tuple[arb, arb]] = field(default_factory=list)
    chatters: list[arb] = field(default_factory=list)
    states: list[tuple[arb, arb]] = field(default_factory=list)
    symbols: list[float] = field(default_factory=list)
    leaves: list[arb] = field(default_factory=list)


class BallLanding(NamedTuple):
    """A landing of all states of a parallelogram.

    place: stretch and turn; s: rad of flight; slopes: the first three derivatives of the gap there;
    jacobian: of (phi, rate) after the impact by those at the start; drift: of the same by the
    width of the speeds; unit: the columns that errors are measured along, see
    `Parallelogram.image`.
    """

    place: Place
    s: arb
    slopes: list[arb]
    jacobian: arb_mat
    drift: arb_mat
    unit: arb_mat


class BallMotion:
    """A follower that rests on the cam before its first departure, then moves on by `step`.

    Where it is: at the angle phi, on the stretch and in the turn of `place`, or leaving it.
    enclosure: holds (phi, rate) with all their errors; the balls phi, rate, q, w and fall are made
    of it. trail: what has happened. bits: most bits in use; less as digits are used up. impacts,
    chattered: of the turn that is not over. resting: whether it rests on the cam. order: of the
    first derivative of the gap that is above zero as the flight begins, LIFT_OFF, CORNER or BLOW.
    """

    rate: arb  # of the follower relative to the cam, m/rad
    q: arb  # position, m
    w: arb  # dq/dtheta, m/rad
    fall: arb  # -gap'' as the flight begins, m/rad^2

    def __init__(self, machine: BallMachine, strobe: float, theta: float):
        """Begin at the departure near theta; strobe: phase of the section; both rad, [0, 2 pi)."""
        self.machine = machine
        self.turn = machine.turn
        self.trail = Trail()
        self.bits = ctx.prec
        self.section = arb(strobe)
        self.strobe = self.section - (0 if strobe <= theta else self.turn)  # the last one
        self.phi = arb(theta) - BEFORE
        stretch = next(k for k, one in enumerate(machine.stretches) if one.end > self.phi)
        self.place = Place(stretch, 0)
        self.impacts = 0
        self.chattered = False
        self.resting = True
        self._leave()

    def step(self) -> None:
        """One impact further, or from it through a rest to the next departure."""
        landing = coarsely(self._landing)
        gap_of_middle = self._gap(landing.place, middle=True)
        flown, rate_before = sharpened(gap_of_middle, landing.s, landing.slopes)
        r = self.machine.restitution(landing.place.stretch)
        after = arb_mat([[self.enclosure.middle[0, 0] + flown], [-r * rate_before]])
        enclosure = self.enclosure.image(after, landing.jacobian, landing.drift, landing.unit)
        self._strobes(enclosure.hull()[0])
        self.place = landing.place
        self._begin_flight(enclosure, BLOW)
        self._struck(-self.rate / r if r > 0 else landing.slopes[0])
        if r == 0:
            self.order = CORNER
            self.resting = below(0, self.fall)
        elif self.fall > 0:
            self.resting = self._accumulates()
        if self.resting:
            self._leave()

    def symbol_of_turn(self, phi: arb) -> float:
        """The symbol of the turn that is not over, if it goes on as the turn of phi did after phi.

        That is its number of impacts, or inf where a chatter ends in it.
        """
        turn = self.turn_of(phi)
        trail = self.trail
        later = [x for x, _ in trail.impacts if x >= phi and self.turn_of(x) == turn]
        ends = any(x > phi and self.turn_of(x) == turn for x in trail.chatters)
        return inf if self.chattered or ends else float(self.impacts + len(later))

    def turn_of(self, phi: arb) -> int:
        """Number of strobes passed up to phi."""
        turns = ((phi - self.strobe) / self.turn).floor().unique_fmpz()
        if turns is None:
            raise UndecidedError
        return int(turns)

    def phase(self, phi: arb) -> float:
        """phi as an angle of the turn, rad."""
        return float(phi - (phi / self.turn).mid().floor() * self.turn)

    def _cam(self, phi: arb, place: Place, order: int = 2) -> list[arb]:
        """[c, c', ...] up to an order at the angle phi, on the stretch of a place."""
        return self.machine.stretches[place.stretch].derivatives(
            phi - place.turn * self.turn, order
        )

    def _end(self, place: Place) -> arb:
        """Where the stretch at a place ends, as an angle counted on."""
        return self.machine.stretches[place.stretch].end + place.turn * self.turn

    def _next(self, place: Place) -> Place:
        """The place behind this one."""
        return place.next(len(self.machine.stretches))

    def _begin_flight(self, enclosure: Parallelogram, order: int) -> None:
        """Begin a flight, and set `ctx.prec`: no more bits than what is known of it deserves.

        enclosure: of phi and the rate relative to the cam; order: see the class.
        """
        self.enclosure = enclosure
        self.order = order
        self.phi, self.rate = enclosure.hull()
        c = self._cam(self.phi, self.place)
        machine = self.machine
        self.q = c[0]
        self.w = c[1] + self.rate
        self.fall = machine.G + machine.W2 * self.q + 2 * machine.Z * self.w + c[2]
        known = max(x.rel_accuracy_bits() for x in (self.phi, self.rate))
        ctx.prec = min(self.bits, known + GUARD)  # further digits say nothing

    def _struck(self, u: arb) -> None:
        """Note an impact here with the incoming rate u."""
        self.impacts += 1
        self.trail.impacts.append((self.phi, u))

    def _gap(self, place: Place, order: int = 2, middle: bool = False) -> Function:
        """s -> [gap, gap', ...] after s rad of flight, to the stretch at a place, up to order <= 3.

        From all states of the parallelogram, or from the one in the middle.
        """
        phi = self.phi
        q = self.q
        w = self.w
        machine = self.machine
        if middle:
            machine = machine.center
            phi, rate = self.enclosure.middle.entries()
            q, cam_slope = self._cam(phi, self.place, 1)
            w = cam_slope + rate
        stretch = self.machine.stretches[place.stretch]
        theta = phi - place.turn * self.turn

        def gap(s: arb) -> list[arb]:
            cam = stretch.derivatives(theta + s, order)
            return [x - y for x, y in zip(machine.move(q, w, s, order), cam, strict=True)]

        return gap

    def _contact(self) -> tuple[arb, Place]:
        """(angle of flight to the next contact, its place); raises EndlessError where none comes.

        The flight is followed stretch by stretch of the cam.
        """
        place = self.place
        low, cut = self._opening()
        for k in range(MOST_STRETCHES):
            gap = self._gap(place)
            high = self._end(place) - self.phi
            if cut is not None or not self._clear(low.union(high), place):
                if k and not gap(low)[0] > 0:
                    raise UndecidedError
                s = first_root(gap, low, high.upper(), cut) if low < high else None
                if s is not None and below(s, high):
                    return s, place
            place = self._next(place)
            low = high
            cut = None
        raise EndlessError

    def _clear(self, s: arb, place: Place) -> bool:
        """Is the gap to the stretch at a place above zero for all s (rad), at first sight?"""
        b, _, p = self.machine.flow(s)
        force = self.machine.G + self.machine.W2 * self.q
        height = self.q + self.w * b - force * p
        return height > self._cam(self.phi + s, place, 0)[0]

    def _opening(self) -> tuple[arb, arb | None]:
        """(low, cut): rad of flight up to which the gap is above zero, and where to look first.

        low: up to there the gap's derivative of order self.order is above zero, so that the gap is
        too; cut: None, or the end of a first hop all along which the gap is concave: then low is 0,
        and the contact is expected before the cut.
        """
        high = self._end(self.place) - self.phi
        gap = self._gap(self.place, order=LIFT_OFF)
        s = high.upper()
        if self.order == BLOW and self.rate > 0 and self.fall > 0:
            hop = (HOP * self.rate / self.fall).mid()
            if hop < high and gap(arb(0).union(hop))[2] < 0:
                return arb(0), hop
            s = min(s, hop)
        for _ in range(MOST_HALVINGS):
            if gap(arb(0).union(s))[self.order] > 0:
                return s, None
            s = (s / 2).mid()
        raise UndecidedError

    def _landing(self) -> BallLanding:
        """The landing that ends the flight; raises UndecidedError, or EndlessError where none does.

        A start (dphi, drate) beside is at equal phi a difference (dq, dw) = (-rate dphi,
        drate - gap'' dphi). It lands at dphi = -dq/u later, its u different by dw + gap'' dphi.
        """
        machine = self.machine
        s, place = self._contact()
        s = arb(s.mid(), 4 * s.rad() + SLACK * abs(s).upper())  # room to sharpen it in
        _, u, accel, jerk = self._gap(place, order=3)(s)
        b, b1, _ = machine.flow(s)
        if not u < 0:
            raise UndecidedError
        r = machine.restitution(place.stretch)
        # (dphi, drate) -> (dq, dw) at the start, over the flight, and back at its end
        at_equal_phi = arb_mat([[-self.rate, 0], [self.fall, 1]])
        flight = arb_mat([[b1 + 2 * machine.Z * b, b], [-machine.W2 * b, b1]])
        later = arb_mat([[-1 / u, 0], [r * accel / u, -r]])
        return BallLanding(
            place=place,
            s=s,
            slopes=[u, accel, jerk],
            jacobian=later * flight * at_equal_phi,
            drift=later * machine.drift(self.q, self.w, s),
            unit=arb_mat([[1, 0], [accel, u]]).mid(),
        )

    def _accumulates(self) -> bool:
        """After an impact: does the follower come to rest before its stretch and turn end?

        While -A <= gap'' <= -a, a hop that begins with the rate v lasts 2 v/A to 2 v/a and lands
        with a rate of at most k v, k = sqrt(A/a): gap <= v^2/(2 a) all along. With r k < 1 the hops
        shrink, and the infinitely many take between (2 v/A)/(1 - r/k) and (2 v/a)/(1 - r k).
        The bounds are taken over all gaps, rates and angles that this allows with k <= 2.
        """
        machine = self.machine
        v = self.rate.upper()
        r = machine.restitution(self.place.stretch)
        if not r < 1:
            return False
        reach = (3 * v / (self.fall * (1 - r))).upper()
        last = self.phi + reach
        if not (last < self._end(self.place) and last < self._next_strobe()):
            return False
        c = self._cam(self.phi + arb(0).union(reach), self.place)
        height = v * reach
        q = c[0] + arb(0).union(height)
        w = c[1] + (-2 * v).union(2 * v)
        falls = machine.G + machine.W2 * q + 2 * machine.Z * w + c[2]  # -gap''
        least = falls.lower()  # a
        most = falls.upper()  # A
        if not least > 0:
            return False
        k = (most / least).sqrt()
        if not (k < 2 and r * k < 1):  # so that v^2/(2 a) < 2 v^2/A < height
            return False
        longest = (2 * v / least / (1 - r * k)).upper()
        if not longest < reach:
            return False
        shortest = (2 * self.rate.lower() / most / (1 - r / k)).lower()
        self.trail.chatters.append(self.phi + shortest.union(longest))
        self.phi += longest  # it rests from here on at the latest
        self.chattered = True
        return True

    def _leave(self) -> None:
        """From a rest on to where the follower leaves the cam; EndlessError where it rests a turn.

        It leaves where the force of contact falls through zero, or at a corner: where it is pressed
        no more behind that, where the cam falls away, or where the cam strikes it and it bounces.
        """
        machine = self.machine
        begun = self.phi
        ctx.prec = self.bits
        while self.phi < begun + self.turn + 1:
            place = self.place

            def force(phi: arb, place: Place = place) -> list[arb]:
                return machine.force(self._cam(phi, place, 4))

            end = self._end(place)
            if not below(0, force(self.phi)[0]):  # at a corner, pressed no more from there on
                return self._depart(self.phi, arb(0), CORNER)
            root = first_root(force, self.phi, end.upper())
            if root is not None and below(root, end):
                return self._depart(root, arb(0), LIFT_OFF)
            self.phi = end
            self.place = self._next(place)
            kick = self._cam(end, self.place)[1] - self._cam(end, place)[1]
            if below(abs(kick), arb(SMALLEST_KICK)):
                continue
            if kick < 0:  # the cam falls away
                return self._depart(end, -kick, BLOW)
            r = machine.restitution(self.place.stretch)
            if r > 0:
                self._depart(end, r * kick, BLOW)
                return self._struck(-kick)
            self._strobes(end)
            self._struck(-kick)
        raise EndlessError

    def _depart(self, phi: arb, rate: arb, order: int) -> None:
        """Leave the cam from rest at phi with this rate."""
        self._strobes(phi)
        self.resting = False
        self._begin_flight(Parallelogram.around(phi, rate), order)
        self.trail.leaves.append(phi)

    def _next_strobe(self) -> arb:
        """The angle of the first strobe whose state is not noted."""
        return self.strobe + (len(self.trail.states) + 1) * self.turn

    def _strobes(self, phi: arb) -> None:
        """Note the states at the strobes up to phi, in flight from here or at rest on the cam.

        At rest the state is that of the cam; where the strobe is at a corner, that of the stretch
        which begins there.
        """
        while below(strobe := self._next_strobe(), phi):
            if self.resting:
                not_behind = [
                    stretch
                    for stretch in self.machine.stretches
                    if not stretch.start > self.section
                ]
                state = not_behind[-1].derivatives(self.section, 1)
            else:
                state = self.machine.move(self.q, self.w, strobe - self.phi)
            self.trail.states.append((state[0], state[1]))
            self.trail.symbols.append(inf if self.chattered else float(self.impacts))
            self.impacts = 0
            self.chattered = False
