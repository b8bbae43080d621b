"""Drive the kernel for one orbit: start state, slices of work, growing logs, resume.

Plain Python does the first `PLAIN_STEPS` steps; longer work compiles the kernel. Both give the
same bits, so the switch can happen in the middle of an orbit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi

from camcli.errors import LOG_FULL, OK, PAUSED
from camcli.kernel import backend, lanes
from camcli.kernel.events import BOUNCED, FREE
from camcli.kernel.orbit import Log, Plan, Strobe
from camcli.kernel.profile import ROW, START, Cam, lift_at, stretch_at
from camcli.system import System, omega_of

PLAIN_STEPS = 60_000  # steps in plain Python before compiling pays (about a second)
FIRST_CAPACITY = 256
EVERYTHING = 1 << 62


@dataclass(frozen=True)
class Start:
    """Initial state: q (m), v (m/s), None meaning on the cam and at its velocity; theta in deg."""

    q: float | None = None
    v: float | None = None
    theta_deg: float = 0.0


@dataclass(frozen=True)
class Settings:
    """What every run shares: turns, tolerance (fraction of a turn) and the impact budget."""

    transient: int
    record: int
    chatter_tolerance: float
    impact_budget: int
    start: Start = field(default_factory=Start)


class StartError(ValueError):
    """The start lies below the cam; the message says how deep."""


@dataclass
class Tape:
    """Recorded rows of one orbit as plain lists or arrays; lengths in m, velocities per rad."""

    kind: list
    period: list
    theta: list
    q: list
    u: list
    strobe: Strobe
    periods: int  # recorded periods that are whole
    status: int
    impacts: int  # of the whole run, transient included
    evaluations: int
    crossings: int


class Orbit:
    """One lane's state between calls of the kernel."""

    def __init__(self, system: System, rpm: float, settings: Settings, start: Start):
        self.system, self.settings = system, settings
        self.omega = omega_of(rpm)
        self.lane = system.lane(rpm, settings.chatter_tolerance, settings.impact_budget)
        self.state, self.count = _initial(system.cam, self.omega, settings, start)
        self.work = [0, 0, 0]

    def run(self, events: bool = True, strobes: bool = True) -> Tape:
        """Run transient and record; `events` and `strobes` say what is logged at all."""
        record = self.settings.record
        logs: list[Log] = []
        rows = record if strobes else 0
        strobe = Strobe([0.0] * (2 * rows), [0] * (2 * rows), rows)
        if rows and self.count[2] == 0:
            strobe.state[:2] = self.position()
        capacity = FIRST_CAPACITY if events else 0
        first = 0 if self.settings.transient else -1
        while True:
            status, log, strobe = self._slice(capacity, first, record, strobe)
            if events:
                logs.append(log)
            if status == LOG_FULL:
                capacity *= 2
            elif status == PAUSED:
                backend.compile_kernel()
            else:
                break
        return self._tape(logs, strobe, status)

    def position(self) -> tuple[float, float]:
        """(q, dq/dtheta) now."""
        c, c1, _ = lift_at(self.system.cam, self.count[1], self.state[0])
        return c + self.state[1], c1 + self.state[2]

    def _slice(self, capacity: int, first: int, record: int, strobe: Strobe):
        plain = not backend.is_compiled() and backend.may_compile()
        cam, turns = tables(self.system, self.lane)
        whole, real = backend.zeros(2 * capacity, int), backend.zeros(3 * capacity)
        plan = Plan(first, record, PLAIN_STEPS if plain else EVERYTHING)
        state, count, work = (
            backend.numbers(self.state),
            backend.numbers(self.count, int),
            backend.numbers(self.work, int),
        )
        count[5] = 0
        strobe = strobe._replace(
            state=backend.numbers(strobe.state), events=backend.numbers(strobe.events, int)
        )
        log = Log(whole, real, capacity)
        status = lanes.advance(cam, self.lane, turns, state, count, plan, log, strobe, work)
        self.state, self.count, self.work = list(state), list(count), list(work)
        used = int(count[5])
        return int(status), Log(whole[: 2 * used], real[: 3 * used], used), strobe

    def _tape(self, logs: list[Log], strobe: Strobe, status: int) -> Tape:
        whole = [value for log in logs for value in _list(log.whole)]
        real = [value for log in logs for value in _list(log.real)]
        return Tape(
            kind=whole[::2],
            period=whole[1::2],
            theta=real[::3],
            q=real[1::3],
            u=real[2::3],
            strobe=strobe,
            periods=max(0, min(int(self.count[2]), self.settings.record)),
            status=OK if status == OK else status,
            impacts=int(self.count[7]),
            evaluations=int(self.work[0]),
            crossings=int(self.work[1]),
        )


def _list(values) -> list:
    return values.tolist() if hasattr(values, "tolist") else values


def tables(system: System, lane) -> tuple[Cam, list]:
    """The cam in native form and the lane's flows over whole stretches."""
    cam = system.native_cam()
    turns = backend.zeros(3 * cam.stretches * cam.stretches)
    lanes.prepare(cam, lane, turns)
    return cam, turns


def _initial(cam: Cam, omega: float, settings: Settings, start: Start):
    """(state, count) of the kernel at the start; raises StartError below the cam."""
    theta = start.theta_deg * (pi / 180.0)
    i = stretch_at(cam, theta)
    c, c1, _ = lift_at(cam, i, theta)
    gap = 0.0 if start.q is None else start.q - c
    rate = 0.0 if start.v is None else start.v / omega - c1
    if gap < 0.0:
        raise StartError(
            f"the follower starts {-gap:.6g} m below the cam: q = {start.q:.17g} m, "
            f"c = {c:.17g} m at {start.theta_deg:g} deg"
        )
    mode = FREE if gap > 0.0 or rate < 0.0 else BOUNCED
    on_strobe = i == cam.strobe and theta == cam.rows[i * ROW + START]
    period = -settings.transient - (0 if on_strobe else 1)
    return [theta, gap, rate], [mode, i, period, 0, 0, 0, 0, 0]
