"""A motion in decimals from a departure on: doubles find each event, Newton's method polishes it.

The phase of an impact solves q(s) - c(theta + s) = 0 with the rate u of the double search as slope.
Where doubles do not see clearly (`scout`), an impact comes too near to an edge of a smooth part, or
the error has grown beyond what the digits hold, the motion ends with the reason.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Decimal
from math import inf

from camcli.analysis.integrate import Settings
from camcli.cams.decimals import pi
from camcli.exact.departure import Departure, departure
from camcli.exact.drive import DIGITS, Drive
from camcli.exact.error import Doubt
from camcli.exact.lifts import Lifts
from camcli.exact.scout import Found, Scout
from camcli.kernel.cam_table import lift
from camcli.kernel.orbit_loop import EventKind
from camcli.system import System

EDGE = Decimal("1e-12")  # rad: an impact nearer to the edge of a part may be on either side
APART = 1e-8  # rad: a polished phase farther from the double one is another root
ENOUGH = Decimal("1e-85")  # last step of Newton's method, of the flight
STEPS = 20
LARGEST_ERROR = 1e-10  # of the lift
UNCLEAR = "closer to a graze than doubles can tell"
ON_EDGE = "an impact at an edge of a smooth part"
FORGOT = "no digit is left"
RESTS = "no departure from the rest is certain"


@dataclass
class Trail:
    """What is kept: impacts (place rad, relative rate m/rad), states at strobes, turns between.

    states[k] = (q m, dq/dtheta m/rad) at strobe k + 1, after turn k with symbols[k]; `leaves`:
    places of the departures. Places count from the strobe before the first departure.
    """

    impacts: list[tuple[Decimal, Decimal]] = field(default_factory=list)
    states: list[tuple[Decimal, Decimal]] = field(default_factory=list)
    symbols: list[float] = field(default_factory=list)
    leaves: list[tuple[Decimal, Departure]] = field(default_factory=list)


class TrueMotion:
    """The motion after a departure; every call belongs into a context of DIGITS digits."""

    def __init__(self, system: System, rpm: float, settings: Settings, share=Decimal(0)):
        self.drive, self.lifts = Drive.of(system.follower, rpm, share), Lifts(system)
        self.scout = Scout(system, rpm, settings)
        self.cam, self.turn = system.cam, 2 * pi(DIGITS)
        self.strobe = Decimal(system.strobe)
        self.rows = system.cam.strobe
        self.doubt = Doubt(self.scout.lane, self.scout.size)
        self.trail, self.reason, self.worst = Trail(), "", 0.0

    def leave(self, i: int, theta: float) -> bool:
        """Begin, or go on, with the departure near theta (rad) on stretch i; False ends it."""
        at = departure(self.drive, self.scout.lane, self.cam, self.lifts, i, theta)
        if at is None:
            self.reason = RESTS
            return False
        self.i, self.theta, self.rate = at.i, at.theta, at.rate
        self.q = self.lifts.c(at.i, at.theta)
        self.w = self.lifts.c1(at.i, at.theta) + at.rate
        self.doubt.reset()
        if not self.trail.leaves:
            since = at.theta - self.strobe
            self.place = since if since >= 0 else since + self.turn
            self.impacts, self.chattered = 0, False
        self.trail.leaves.append((self.place, at))
        return True

    def step(self) -> bool:
        """One event further; False where the motion cannot be followed."""
        found = self.scout.after(self.i, float(self.theta), float(self.rate))
        if found is None:
            self.reason = UNCLEAR
            return False
        return self._impact(found) if found.kind == EventKind.IMPACT else self._rest(found)

    def _impact(self, found: Found) -> bool:
        s, theta = self._landing(found)
        if s is None:
            return False
        low, high = self.lifts.edges(found.i)
        if not low + EDGE < theta < high - EDGE:
            self.reason = ON_EDGE
            return False
        q, w = self.drive.move(self.q, self.w, s)
        c1 = self.lifts.c1(found.i, theta)
        u = w - c1
        self.doubt.flight(float(s))
        self.doubt.impact(lift(self.cam, found.i, float(theta)), float(u))
        self.worst = max(self.worst, self.doubt.error)
        if not self.doubt.error <= LARGEST_ERROR or u >= 0:
            self.reason = FORGOT
            return False
        self._strobes(self.place + s)
        self.place, self.theta, self.i = self.place + s, theta, found.i
        self.rate = -self.drive.r * u
        self.q, self.w = q, c1 + self.rate
        self.impacts += 1
        self.trail.impacts.append((self.place, u))
        return True

    def _landing(self, found: Found) -> tuple[Decimal | None, Decimal | None]:
        """(rad of flight, phase) of the impact, polished."""
        s = guess = Decimal(found.s)
        whole = round((self.theta + s - Decimal(found.theta)) / self.turn) * self.turn
        for _ in range(STEPS):
            q, _ = self.drive.move(self.q, self.w, s)
            theta = self.theta + s - whole
            step = (q - self.lifts.c(found.i, theta)) / Decimal(found.u)
            s -= step
            if not guess / 2 < s < 2 * guess:
                break
            if abs(step) <= ENOUGH * s:
                if abs(s - guess) > APART:
                    break
                return s, theta - step
        self.reason = UNCLEAR
        return None, None

    def _rest(self, found: Found) -> bool:
        """A complete chatter (or an impact without rebound): on to where the follower leaves."""
        after = found
        if found.kind == EventKind.CHATTER:
            after = self.scout.leaves(self.i, float(self.theta), float(self.rate))
            if after is None:
                self.reason = RESTS
                return False
        begins = self.place + Decimal(found.s)
        self._strobes(begins)
        self.chattered |= found.kind == EventKind.CHATTER
        ends = begins + (Decimal(after.s) if after is not found else 0)
        self._strobes(ends, resting=True)
        self.place = ends
        return self.leave(after.i, after.theta)

    def symbol_of_turn(self, begins: Decimal) -> float:
        """Symbol of the turn begun here and ended as that of a departure in the place `begins`."""
        turn = int(begins / self.turn)
        after = sum(1 for p, _ in self.trail.impacts if begins <= p < (turn + 1) * self.turn)
        return inf if self.chattered else float(self.impacts + after)

    def _strobes(self, place: Decimal, resting: bool = False) -> None:
        """Note the strobes up to a place, in flight from here or at rest on the cam."""
        while (len(self.trail.states) + 1) * self.turn <= place:
            state = self._at_strobe(resting)
            self.trail.states.append(state)
            self.trail.symbols.append(inf if self.chattered else float(self.impacts))
            self.impacts, self.chattered = 0, False

    def _at_strobe(self, resting: bool) -> tuple[Decimal, Decimal]:
        if resting:
            return self.lifts.c(self.rows, self.strobe), self.lifts.c1(self.rows, self.strobe)
        s = (len(self.trail.states) + 1) * self.turn - self.place
        return self.drive.move(self.q, self.w, s)
