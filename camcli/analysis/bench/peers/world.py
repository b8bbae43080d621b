"""What the peers share: the machine at one speed, sticking, the reset map and the chatter map."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from time import process_time

from camcli.analysis.bench.peers.lifts import TWO_PI, Lift
from camcli.system import Follower

GRID = 16  # cells of a region in the search for the end of a sticking

State = tuple[int, float, float, float]  # whole turns, theta, gap y (m), relative velocity u (m/s)


class BudgetError(Exception):
    """The budget of time or impacts is used up."""


@dataclass
class Trace:
    """What a method found: impacts (turn, theta, u), rests (turn, theta), the end (q, v)."""

    hits: list[tuple[int, float, float]] = field(default_factory=list)
    rests: list[tuple[int, float]] = field(default_factory=list)
    final: tuple[float, float] | None = None
    evaluations: int = 0
    given_up: bool = False


@dataclass
class World:
    """A follower on a cam at one speed, and the rules that are not integration."""

    follower: Follower
    lift: Lift
    omega: float
    end: float  # turns
    chatter_tolerance: float  # turns
    deadline: float = math.inf  # of process_time, so that a busy machine changes nothing
    most_impacts: int = 10**9
    trace: Trace = field(default_factory=Trace)

    def __post_init__(self) -> None:
        f = self.follower
        self.w2, self.b, self.load = (
            f.stiffness / f.mass,
            f.damping / f.mass,
            f.gravity + f.preload / f.mass,
        )
        self.period = TWO_PI / self.omega

    def pushed(self, index: int, theta: float) -> float:
        """Relative acceleration of a follower on the cam, by the law of a region, m/s2."""
        c, slope, bend = self.lift.law(index, theta)
        omega = self.omega
        return -self.w2 * c - self.b * omega * slope - self.load - omega * omega * bend

    def fall_time(self, theta: float, y: float, u: float) -> float:
        """Seconds until the gap closes at the present relative acceleration."""
        a = self.pushed(self.lift.region(theta), theta) - self.w2 * y - self.b * u
        if a >= 0.0:
            return math.inf
        return (u + math.sqrt(u * u - 2.0 * a * y)) / -a

    @staticmethod
    def wrap(turn: int, theta: float) -> tuple[int, float]:
        """The same angle with theta in [0, 2 pi)."""
        whole = math.floor(theta / TWO_PI)
        return turn + whole, theta - whole * TWO_PI

    def check(self) -> None:
        """Raise BudgetError where the budget is used up."""
        if process_time() > self.deadline or len(self.trace.hits) > self.most_impacts:
            raise BudgetError

    def seconds_left(self, turn: int, theta: float) -> float:
        """Time until the end of the run."""
        return ((self.end - turn) * TWO_PI - theta) / self.omega

    def rest(self, turn: int, theta: float) -> State | None:
        """State in which a follower at rest on the cam leaves it; None: it rests to the end."""
        while turn < self.end:
            index = self.lift.region(theta)
            leave = self._leaves(index, theta)
            if leave is not None:
                turn, theta = self.wrap(turn, leave)
                return (turn, theta, 0.0, 0.0) if turn < self.end else None
            turn, theta = self.wrap(turn, min(self.lift.regions[index].end, theta + TWO_PI))
        return None

    def _leaves(self, index: int, theta: float) -> float | None:
        """First angle of a region, from theta on, at which the follower is pulled off."""
        if self.pushed(index, theta) > 0.0:
            return theta
        high = min(self.lift.regions[index].end, theta + TWO_PI)
        grid = [theta + (high - theta) * k / GRID for k in range(GRID + 1)]
        for left, right in pairwise(grid):
            if self.pushed(index, right) > 0.0:
                return bisected(lambda x: self.pushed(index, x) > 0.0, left, right)
        return None

    def rebound(self, turn: int, theta: float, u: float) -> State | None:
        """State after an impact: thrown up, or where the rest ends that closes a chatter."""
        self.check()
        self.trace.hits.append((turn, theta, u))
        r = self.follower.restitution
        a = self.pushed(self.lift.region(theta), theta)
        if a < 0.0 and r < 1.0:
            left = 2.0 * r * u / ((1.0 - r) * a)
            if left <= self.chatter_tolerance * self.period:
                turn, theta = self.wrap(turn, theta + self.omega * left)
                self.trace.rests.append((turn, theta))
                return self.rest(turn, theta)
        return turn, theta, 0.0, -r * u


def bisected(above: Callable[[float], bool], low: float, high: float) -> float:
    """Where a condition that is false at low and true at high begins to hold."""
    for _ in range(80):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (low, middle) if above(middle) else (middle, high)
    return high


Fly = Callable[[int, float, float, float], tuple[bool, int, float, float, float]]


def follow(world: World, fly: Fly, start: tuple[float | None, float | None]) -> Trace:
    """Follow the follower from theta = 0; `fly` gives (contact, turn, theta, y, u) at its end."""
    trace, lift = world.trace, world.lift
    c, slope, _ = lift.law(0, 0.0)
    if start[0] is None:
        state = world.rest(0, 0.0)
    else:
        state = (0, 0.0, start[0] - c, start[1] - world.omega * slope)
    try:
        while state is not None:
            contact, turn, theta, y, u = fly(*state)
            if not contact:
                at = lift.law(lift.region(theta), theta)
                trace.final = (at[0] + y, world.omega * at[1] + u)
                return trace
            state = world.rebound(turn, theta, u)
        trace.final = (c, world.omega * slope)
    except BudgetError:
        trace.given_up = True
    return trace
