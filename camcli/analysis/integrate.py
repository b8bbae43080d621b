"""Drive the kernel for one orbit: start state, slices of work, growing logs, resume.

Plain Python does the first `PLAIN_STEPS` steps; longer work compiles the kernel. Both give the
same bits, so the switch can happen in the middle of an orbit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import pi

from camcli.errors import Fault, SceneError, Status
from camcli.kernel import backend
from camcli.kernel.backend import Kernel
from camcli.kernel.cam_table import ROW, START, Cam, lift_at, stretch_at
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import (
    LEAVES,
    LOGGED,
    MODE,
    PERIOD,
    RESTING,
    STRETCH,
    TOTAL,
    Log,
    Plan,
    Strobe,
)
from camcli.system import System, omega_of

PLAIN_STEPS = 20_000  # steps in plain Python before compiling pays (about half a second)
EVERYTHING = 1 << 62
FIRST_CAPACITY, MOST_CAPACITY = 256, 1 << 20  # rows of a log


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


class StartError(SceneError):
    """The start lies below the cam; the fault says how deep."""


@dataclass(frozen=True)
class Cost:
    """Work done, transient included."""

    impacts: int = 0
    evaluations: int = 0
    crossings: int = 0

    def __add__(self, other: Cost) -> Cost:
        return Cost(
            self.impacts + other.impacts,
            self.evaluations + other.evaluations,
            self.crossings + other.crossings,
        )


@dataclass(frozen=True)
class Tape:
    """Recorded rows of one orbit; angles in rad, lengths in m, velocities in m/rad.

    Columns are lists (plain Python) or arrays (compiled kernel). `strobe_*` have a row per started
    period; `impacts` and `chatter` count within it, `periods` of them are whole.
    """

    kind: Sequence[int]
    period: Sequence[int]
    theta: Sequence[float]
    q: Sequence[float]
    u: Sequence[float]
    strobe_q: Sequence[float]
    strobe_w: Sequence[float]
    impacts: Sequence[int]
    chatter: Sequence[int]
    periods: int
    detachments: int
    resting: bool
    status: Status
    cost: Cost

    @property
    def touches(self) -> bool:
        """False where the follower rested on the cam during the whole record."""
        return self.detachments > 0 or not self.resting or any(self.impacts)


class Orbit:
    """One lane's state between calls of the kernel."""

    def __init__(self, system: System, rpm: float, settings: Settings, start: Start | None = None):
        self.system, self.settings = system, settings
        self.omega = omega_of(rpm)
        self.lane = system.lane(rpm, settings.chatter_tolerance, settings.impact_budget)
        self.state, self.count = _initial(
            system.cam, self.omega, settings, settings.start if start is None else start
        )
        self.work = [0, 0, 0]

    def run(self, events: bool = True, strobes: bool = True) -> Tape:
        """Run transient and record; `events` and `strobes` say what is logged at all."""
        rows, kernel = self.settings.record if strobes else 0, backend.current()
        strobe = Strobe(kernel.zeros(2 * rows), kernel.zeros(2 * rows, int), rows)
        if rows and self.count[PERIOD] == 0:
            strobe.state[0], strobe.state[1] = self.position()
        logs: list[Log] = []
        capacity = (
            min(max(FIRST_CAPACITY, 2 * self.settings.record), MOST_CAPACITY) if events else 0
        )
        while True:
            status, log, strobe = self._slice(kernel, capacity, strobe)
            logs.append(log)
            if status == Status.LOG_FULL:
                capacity = min(2 * capacity, MOST_CAPACITY)
            elif status == Status.PAUSED:
                kernel = backend.compiled()
            else:
                return self._tape(logs, strobe, status)

    def position(self) -> tuple[float, float]:
        """(q, dq/dtheta) now; m, m/rad."""
        c, c1, _ = lift_at(self.system.cam, self.count[STRETCH], self.state[0])
        return c + self.state[1], c1 + self.state[2]

    def here(self) -> Start:
        """The present state as a start for another run; None values where it rests on the cam."""
        theta_deg = self.state[0] * (180.0 / pi)
        if self.count[MODE] == RESTING:
            return Start(None, None, theta_deg)
        q, w = self.position()
        return Start(q, w * self.omega, theta_deg)

    def _slice(self, kernel: Kernel, capacity: int, strobe: Strobe):
        """One call of the kernel: (status, the rows it logged, the strobe)."""
        cam = self.system.cam_for(kernel)
        first = 0 if self.settings.transient else -1
        limited = not kernel.compiled and backend.may_compile()
        plan = Plan(first, self.settings.record, PLAIN_STEPS if limited else EVERYTHING)
        self.count[LOGGED] = 0
        state, count, work = (
            kernel.numbers(self.state),
            kernel.numbers(self.count, int),
            kernel.numbers(self.work, int),
        )
        strobe = strobe._replace(
            state=kernel.numbers(strobe.state), events=kernel.numbers(strobe.events, int)
        )
        log = Log(kernel.zeros(2 * capacity, int), kernel.zeros(3 * capacity), capacity)
        flows = kernel.stretch_flows(cam, self.lane)
        status = kernel.advance(cam, self.lane, flows, state, count, plan, log, strobe, work)
        self.state = [float(value) for value in state]
        self.count = [int(value) for value in count]
        self.work = [int(value) for value in work]
        used = self.count[LOGGED]
        return Status(status), Log(log.whole[: 2 * used], log.real[: 3 * used], used), strobe

    def _tape(self, logs: list[Log], strobe: Strobe, status: Status) -> Tape:
        whole = _joined([log.whole for log in logs])
        real = _joined([log.real for log in logs])
        periods = max(0, min(self.count[PERIOD], self.settings.record))
        started = min(periods + 1, strobe.rows) if self.count[PERIOD] >= 0 else 0
        return Tape(
            kind=whole[::2],
            period=whole[1::2],
            theta=real[::3],
            q=real[1::3],
            u=real[2::3],
            strobe_q=strobe.state[: 2 * started : 2],
            strobe_w=strobe.state[1 : 2 * started : 2],
            impacts=strobe.events[: 2 * started : 2],
            chatter=strobe.events[1 : 2 * started : 2],
            periods=periods,
            detachments=self.count[LEAVES],
            resting=self.count[MODE] == RESTING,
            status=status,
            cost=Cost(self.count[TOTAL], self.work[0], self.work[1]),
        )


def _joined(parts: list):
    """Concatenate lists or arrays; a mixture (compiled in mid-run) becomes a list."""
    if len(parts) == 1:
        return parts[0]
    if not any(isinstance(part, list) for part in parts):
        import numpy as np

        return np.concatenate(parts)
    joined: list = []
    for part in parts:
        joined.extend(part if isinstance(part, list) else part.tolist())
    return joined


def _initial(cam: Cam, omega: float, settings: Settings, start: Start):
    """(state, count) of the kernel at the start; raises StartError below the cam."""
    theta = (start.theta_deg % 360.0) * (pi / 180.0)
    i = stretch_at(cam, theta)
    c, c1, _ = lift_at(cam, i, theta)
    gap = 0.0 if start.q is None else start.q - c
    rate = 0.0 if start.v is None else start.v / omega - c1
    if gap < 0.0:
        found = f"found q = {start.q!r} m, {-gap:.6g} m below the cam"
        expected = f"expected at least c = {c!r} m at {start.theta_deg!r} deg"
        raise StartError(Fault("", "run.start.q", found, expected, "raise it, or null for rest"))
    on_strobe = i == cam.strobe and theta == cam.rows[i * ROW + START]
    count = [0] * 9
    count[MODE] = FREE if gap > 0.0 or rate < 0.0 else BOUNCED
    count[STRETCH] = i
    count[PERIOD] = -settings.transient - (0 if on_strobe else 1)
    return [theta, gap, rate], count


def with_turns(settings: Settings, transient: int, record: int) -> Settings:
    """The same settings for another number of turns."""
    return replace(settings, transient=transient, record=record)
