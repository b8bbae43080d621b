"""The next event as doubles see it, and whether they see it clearly.

The kernel's certified search finds the event; the same search from neighbouring starts, an outgoing
rate lower and higher by DOUBT, must find it where the linear map says, du B(s)/|u-| further. Near a
graze the landing moves otherwise, or is another one: then nothing is certain.
"""

from __future__ import annotations

from dataclasses import dataclass

from camcli.analysis.integrate import Settings
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.cam_table import TURN
from camcli.kernel.flight import BOUNCED, RELEASED
from camcli.kernel.flow import flow
from camcli.kernel.orbit_loop import MODE, STRETCH, EventKind, Log, Plan, Strobe
from camcli.system import System

DOUBT = 1e-9  # relative change of the outgoing rate; of `size` after a rest
BENT = 0.1  # how far from the linear map a neighbour may land, of the way it predicts
ROUNDING = 1e-14  # rad, of phases and of sums of turns
IDLE = 2_000  # turns without an event


@dataclass(frozen=True)
class Found:
    """An event: kind of `kernel.orbit`, rad of flight to it, stretch, phase, rate before it."""

    kind: int
    s: float
    i: int
    theta: float
    u: float


class Scout:
    """The kernel at one speed, one event at a time."""

    def __init__(self, system: System, rpm: float, settings: Settings):
        self.kernel, self.strobe = backend.current(), system.strobe
        self.cam = system.cam_for(self.kernel)
        self.lane = system.lane(rpm, settings.chatter_tolerance, settings.impact_budget)
        self.flows = self.kernel.stretch_flows(self.cam, self.lane)
        self.size = max(abs(float(x)) for x in (self.cam.top, 1e-3))

    def after(self, i: int, theta: float, rate: float) -> Found | None:
        """The event after leaving the cam with a rate (m/rad), 0 after a rest; None if unclear."""
        found, _ = self._next(i, theta, rate, BOUNCED if rate > 0.0 else RELEASED)
        if found is None or found.kind != EventKind.IMPACT:
            return found
        du = DOUBT * (rate if rate > 0.0 else self.size)
        moved = du * abs(flow(self.lane, found.s)[0] / found.u)
        for sign in (1.0, -1.0) if rate > 0.0 else (1.0,):
            other, _ = self._next(i, theta, rate + sign * du, BOUNCED)
            if other is None or other.kind != EventKind.IMPACT:
                return None
            if abs(abs(other.s - found.s) - moved) > BENT * moved + ROUNDING * (1.0 + found.s):
                return None
        return found

    def leaves(self, i: int, theta: float, rate: float) -> Found | None:
        """Where a follower that comes to rest in the next event leaves the cam again."""
        found, state = self._next(i, theta, rate, BOUNCED if rate > 0.0 else RELEASED)
        return None if found is None else self._go(found.theta, *state)[0]

    def _next(self, i: int, theta: float, rate: float, mode: int):
        count = [0] * 9
        count[MODE], count[STRETCH] = mode, i
        return self._go(theta, [theta, 0.0, rate], count)

    def _go(self, theta: float, state, count):
        """(the next event, the state there) from a state; (None, _) without one."""
        kernel = self.kernel
        log = Log(kernel.zeros(2, int), kernel.zeros(3), 1)
        strobe = Strobe(kernel.zeros(0), kernel.zeros(0, int), 0)
        state, count = kernel.numbers(list(state)), kernel.numbers([*count[:2], *[0] * 7], int)
        plan, work = Plan(0, IDLE, 1 << 62), kernel.zeros(3, int)
        status = kernel.advance(
            self.cam, self.lane, self.flows, state, count, plan, log, strobe, work
        )
        if status != Status.LOG_FULL:
            return None, None
        at, u = float(log.real[0]), float(log.real[2])
        s = self._since(at) - self._since(theta) + TURN * int(log.whole[1])
        return Found(int(log.whole[0]), s, int(count[STRETCH]), at, u), (state, count)

    def _since(self, theta: float) -> float:
        """Angle since the strobe, rad."""
        return theta - self.strobe + (TURN if theta < self.strobe else 0.0)
