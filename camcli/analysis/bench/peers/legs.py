"""Flights in legs, the same for every peer: which coordinates, where a leg ends, and back again.

A leg is one integration. One in (q, v) lasts a turn at most; one in the gap y = q - c and u = y'
ends at the next breakpoint of the cam. A method says how it integrates: `_in_position`, `_in_gap`.
"""

from __future__ import annotations

from typing import NamedTuple

from camcli.analysis.bench.peers.lifts import TWO_PI
from camcli.analysis.bench.peers.world import World

GAP_BELOW = 1e-3  # turns: a flight that falls back sooner is integrated in the gap


class Leg(NamedTuple):
    """How a leg ended: unwrapped theta, gap, relative velocity, whether at a contact."""

    theta: float
    y: float
    u: float
    contact: bool


class At(NamedTuple):
    """Where a leg begins, and the seconds until the flight falls back on the cam."""

    turn: int
    theta: float
    y: float
    u: float
    fall: float


class Legs:
    """Flights of one run; called with a state it gives that at the next contact or the end."""

    def __init__(self, world: World):
        self.world = world
        self.gap_below = GAP_BELOW * world.period

    def __call__(self, turn: int, theta: float, y: float, u: float):
        """(contact, turn, theta, y, u) at the next contact or at the end of the run."""
        contact = False
        while not contact and self.world.seconds_left(turn, theta) > 0.0:
            self.world.check()
            fall = self.world.fall_time(theta, y, u)
            fly = self._in_gap if fall < self.gap_below else self._in_position
            theta, y, u, contact = fly(At(turn, theta, y, u, fall))
            turn, theta = self.world.wrap(turn, theta)
        return contact, turn, theta, y, u

    def _in_position(self, at: At) -> Leg:
        """Integrate (q, v) for a turn at most."""
        raise NotImplementedError

    def _in_gap(self, at: At) -> Leg:
        """Integrate (y, u) to the next breakpoint at most."""
        raise NotImplementedError

    def end(self, turn: int) -> float:
        """Where the run ends, as an angle counted from the beginning of a turn."""
        return (self.world.end - turn) * TWO_PI

    def absolute(self, at: At) -> tuple[float, float]:
        """(q, v) where a leg begins."""
        c, slope, _ = self.world.lift.law(self.world.lift.region(at.theta), at.theta)
        return c + at.y, at.u + self.world.omega * slope

    def relative(self, theta: float, q: float, v: float) -> tuple[float, float]:
        """(y, u) of a position and velocity at any angle."""
        lift, angle = self.world.lift, theta % TWO_PI
        c, slope, _ = lift.law(lift.region(angle), angle)
        return q - c, v - self.world.omega * slope

    def after(self, at: At, t: float, span: float, stop: float) -> float:
        """The angle t seconds after a leg began; `stop` where it lasted for the whole span."""
        return stop if t >= span else at.theta + self.world.omega * t

    def turn_at_most(self, at: At) -> tuple[float, float]:
        """(seconds of a leg in position, seconds left in the run)."""
        left = self.world.seconds_left(at.turn, at.theta)
        return min(self.world.period, left), left

    def stretch(self, at: At) -> tuple[int, float, float]:
        """(region, angle where a leg in the gap must stop, seconds until there)."""
        index = self.world.lift.region(at.theta)
        stop = min(self.world.lift.regions[index].end, self.end(at.turn))
        return index, stop, (stop - at.theta) / self.world.omega
