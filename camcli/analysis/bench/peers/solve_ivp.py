"""scipy's solve_ivp with a terminal contact event: RK45, DOP853, LSODA and Radau.

A flight stops at a contact and at the bottom of a dip of the gap. Without the second event a step
that enters the cam and leaves it again, as in a chatter that does not complete, would show no
change of sign and lose the impact.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import process_time

from camcli.analysis.bench.peers.legs import At, Leg, Legs
from camcli.analysis.bench.peers.lifts import TWO_PI
from camcli.analysis.bench.peers.world import BudgetError, Trace, World, follow

NAMES = {"rk45": "RK45", "dop853": "DOP853", "lsoda": "LSODA", "radau": "Radau"}
CONTACT, TURNING = 0, 1  # events of a flight
TINY = 1e-300  # m, an open gap
RETRIES = 20
CHECKED = 256  # evaluations from one look at the clock to the next


@dataclass(frozen=True)
class Flight:
    """One call of solve_ivp: equations, gap and its rate, initial values and limits."""

    rhs: Callable
    gap: Callable
    rate: Callable | None
    start: tuple[float, float]
    u: float
    span: float
    fall: float
    max_step: float

    def events(self, first: float) -> list[Callable]:
        """Contact, and the bottom of a dip of the gap; before `first` a leaving flight has none.

        LSODA begins with steps much shorter than the one it is given, where a gap that opens with
        the cube of time is below the rounding of q - c.
        """
        leaves = self.u >= 0.0

        def contact(t, z):
            gap = self.gap(t, z)
            return max(gap, TINY) if leaves and t < first else gap

        def turning(t, z):
            return 1.0 if leaves and t < first else self.rate(t, z)

        contact.terminal = turning.terminal = True
        contact.direction, turning.direction = -1, 1
        return [contact] if self.rate is None else [contact, turning]


class Flights(Legs):
    """Flights of one run by one method."""

    def __init__(self, world: World, method: str, tolerance: float, max_turn: float):
        super().__init__(world)
        self.options = {"method": NAMES[method], "rtol": tolerance, "atol": tolerance}
        self.max_step = max_turn * world.period
        self.until_check = CHECKED

    def _counted(self, rhs: Callable) -> Callable:
        """The right-hand side; now and then it looks at the clock."""

        def call(t, z):
            self.until_check -= 1
            if self.until_check < 0:
                self.until_check = CHECKED
                if process_time() > self.world.deadline:
                    raise BudgetError
            return rhs(t, z)

        return call

    def _in_position(self, at: At) -> Leg:
        world, lift, omega = self.world, self.world.lift, self.world.omega
        k, b, load = world.w2, world.b, world.load

        def rhs(_t, z):
            return z[1], -k * z[0] - b * z[1] - load

        def gap(t, z):
            return z[0] - lift.height(at.theta + omega * t)

        def rate(t, z):
            angle = (at.theta + omega * t) % TWO_PI
            return z[1] - omega * lift.law(lift.region(angle), angle)[1]

        span, left = self.turn_at_most(at)
        start, limits = self.absolute(at), (span, at.fall, self.max_step)
        flight = Flight(self._counted(rhs), gap, rate, start, at.u, *limits)
        t, q, v, event = self._integrate(flight)
        theta = self.after(at, t, left, self.end(at.turn))
        return self._leg(theta, *self.relative(theta, q, v), event)

    def _in_gap(self, at: At) -> Leg:
        world, omega = self.world, self.world.omega
        k, b = world.w2, world.b
        index, stop, span = self.stretch(at)

        def rhs(t, z):
            return z[1], world.pushed(index, at.theta + omega * t) - k * z[0] - b * z[1]

        def gap(_t, z):
            return z[0]

        def rate(_t, z):
            return z[1]

        limits = (span, at.fall, min(self.max_step, at.fall))
        flight = Flight(self._counted(rhs), gap, rate, (at.y, at.u), at.u, *limits)
        t, y, u, event = self._integrate(flight)
        return self._leg(self.after(at, t, span, stop), y, u, event)

    @staticmethod
    def _leg(theta: float, y: float, u: float, event: int | None) -> Leg:
        """What an event makes exact: the gap at a contact, its rate at a turning point."""
        if event == CONTACT:
            return Leg(theta, 0.0, u, True)
        return Leg(theta, max(y, 0.0), 0.0 if event == TURNING else u, False)

    def _integrate(self, flight: Flight) -> tuple[float, float, float, int | None]:
        """Time, state and event at the end of a flight; no contact at its own start."""
        first = min(0.5 * flight.fall, flight.max_step, flight.span, self.world.period / 64.0)
        for _ in range(RETRIES):
            try:
                t, z, gap, event = self._solve(flight, first)
            except ValueError:  # LSODA's interpolant does not meet its steps: no root between them
                first *= 0.7
                continue
            if event == TURNING and gap < 0.0:  # a dip inside one step: end it at the bottom
                t, z, gap, event = self._solve(replace(flight, rate=None, span=t), first)
            if event != CONTACT or t > 0.0:
                return t, float(z[0]), float(z[1]), event
            first /= 8.0  # the first step jumped over the whole flight
        raise ArithmeticError("the contact event cannot leave its starting point")

    def _solve(self, flight: Flight, first: float):
        """Time, state, gap and the event that stopped solve_ivp."""
        from scipy.integrate import solve_ivp

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sol = solve_ivp(
                flight.rhs,
                (0.0, flight.span),
                flight.start,
                events=flight.events(min(first, flight.span)),
                first_step=min(first, flight.span),
                max_step=flight.max_step,
                **self.options,
            )
        self.world.trace.evaluations += sol.nfev
        if sol.status < 0:
            raise ArithmeticError(sol.message)
        t, z = float(sol.t[-1]), sol.y[:, -1]
        event = None
        if sol.status == 1:
            event = CONTACT if sol.t_events[CONTACT].size else TURNING
        return t, z, flight.gap(t, z), event


def load() -> None:
    """Import scipy, so that the first run is like the others."""
    import scipy.integrate  # noqa: F401


def run(
    world: World, start: tuple, method: str, tolerance: float, max_turn: float = math.inf
) -> Trace:
    """One run with rtol = atol = tolerance and steps of at most max_turn turns."""
    return follow(world, Flights(world, method, tolerance, max_turn), start)
