"""Drive the kernel for one orbit: start state, slices of work, growing logs, resume.

Plain Python does the first `PLAIN_STEPS` steps; longer work compiles the kernel. Both give the
same bits, so the switch can happen in the middle of an orbit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from copy import copy
from dataclasses import dataclass, field, replace
from math import degrees, tau

import numpy as np

from camcli.errors import CamError, Fault, SceneError, Status
from camcli.interrupts import look
from camcli.kernel import backend
from camcli.kernel.cam_table import Cam, lift_at, stretch_at
from camcli.kernel.contact_search import Tally
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.forms import Kernel, row_of
from camcli.kernel.orbit_loop import RESTING, Log, Plan, State, Strobe
from camcli.piece_faults import attempt
from camcli.system import System, omega_of

PLAIN_STEPS = 20_000  # steps in plain Python before compiling pays (about half a second)
SLICE = 200_000  # steps of a call of the compiled kernel: some 40 ms, at worst half a second
FIRST_CAPACITY, MOST_CAPACITY = 256, 1 << 20  # rows of a log
ROUNDING_M = 2e-16  # m per m of lift: rounding of q - c where a contact is found
PATIENCE = 20_000  # turns that a motion is followed on before it is called aperiodic
LOGGED = int, int, float, float, float  # kinds of numbers in the columns of a log
TURN = tau  # rad
ROW = 20  # evaluations that take as long as looking at a row of a log


@dataclass(frozen=True)
class Start:
    """Initial state: q (m), v (m/s), None meaning on the cam and at its velocity; theta in rad.

    place: where it stands in the scene.
    """

    q: float | None = None
    v: float | None = None
    theta: float = 0.0
    place: str = field(default="run.start", compare=False, repr=False)

    @classmethod
    def at_strobe(cls, system: System, rpm: float, state: Sequence[float] | None) -> Start:
        """A state (q m, dq/dtheta m/rad) exactly at the strobe; None: at rest on the cam there."""
        if state is None:
            return cls(theta=system.strobe)
        q, w = state
        return cls(float(q), float(w) * omega_of(rpm), system.strobe)


@dataclass(frozen=True)
class Settings:
    """What every run shares: turns, tolerance (fraction of a turn) and the impact budget.

    patience: turns that a motion which looks aperiodic is followed on, see `analysis.patience`.
    """

    transient: int
    record: int
    chatter_tolerance: float
    impact_budget: int
    start: Start = field(default_factory=Start)
    patience: int = PATIENCE


Setup = tuple[System, float, Settings]  # a machine, its speed (rpm) and its runs


@dataclass(frozen=True)
class AtSpeeds:
    """The machine at a speed: what makes it where no other number is varied."""

    system: System
    settings: Settings

    def __call__(self, rpm: float) -> Setup:
        return self.system, rpm, self.settings


class BudgetSpentError(CamError):
    """All the work that an analysis may do is done."""


class Budget:
    """Work that a whole analysis may do: evaluations of the gap, or what takes about as long.

    It is counted, not timed, so that where an analysis ends does not depend on the machine. `tick`
    is called with what is done, and the limit.
    """

    def __init__(self, limit: int, tick: Callable[[int, int], None]):
        self.limit, self.tick, self.done = limit, tick, 0

    @property
    def status(self) -> Status:
        """OK, or WORK_BUDGET where something was left out."""
        return Status.OK if self.done < self.limit else Status.WORK_BUDGET

    def spend(self, work: int) -> None:
        """Count work; raises BudgetSpentError where no more is left."""
        self.done += work
        self.tick(min(self.done, self.limit), self.limit)
        if self.done >= self.limit:
            raise BudgetSpentError


_budget: ContextVar[Budget | None] = ContextVar("budget", default=None)


@contextmanager
def budgeted(limit: int, tick: Callable[[int, int], None]) -> Iterator[Budget]:
    """Count the work of every orbit and every solve in the block."""
    budget = Budget(limit, tick)
    token = _budget.set(budget)
    try:
        yield budget
    finally:
        _budget.reset(token)


def spend(work: int) -> None:
    """Count work other than an orbit's, in the budget around it if there is one."""
    look()
    budget = _budget.get()
    if budget is not None:
        budget.spend(work)


class StartError(SceneError):
    """The start lies below the cam; the fault says how deep."""


@dataclass(frozen=True)
class Cost:
    """Tally done, transient included."""

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
class Record:
    """Recorded rows of one orbit; angles in rad, lengths in m, velocities in m/rad.

    kind, period, theta, q, u have a row per logged event, `strobe_*` one per started period;
    `impacts` and `chatter` count within it, `periods` of them are whole.
    """

    kind: np.ndarray
    period: np.ndarray
    theta: np.ndarray
    q: np.ndarray
    u: np.ndarray
    strobe_q: np.ndarray
    strobe_w: np.ndarray
    impacts: np.ndarray
    chatter: np.ndarray
    periods: int
    detachments: int
    resting: bool
    status: Status
    cost: Cost

    @property
    def touches(self) -> bool:
        """False where the follower rested on the cam during the whole record."""
        return self.detachments > 0 or not self.resting or bool(self.impacts.any())

    def events(self) -> list[tuple[int, int, float, float, float]]:
        """(kind, period, theta, q, u) of every logged event, in Python's own numbers."""
        columns = self.kind, self.period, self.theta, self.q, self.u
        return list(zip(*(column.tolist() for column in columns), strict=True))


class Orbit:
    """One orbit between calls of the kernel."""

    def __init__(self, system: System, rpm: float, settings: Settings, start: Start | None = None):
        self.system, self.settings = system, settings
        self.omega = omega_of(rpm)
        self.const = system.constants(rpm, settings.chatter_tolerance, settings.impact_budget)
        self.state = _initial(
            system.cam, self.omega, settings, settings.start if start is None else start
        )
        self.work = Tally()

    def run(self, events: bool = True, strobes: bool = True) -> Record:
        """Run transient and record; `events` and `strobes` say what is logged at all.

        Raises BudgetSpentError where there is a `Budget`, and too little left.
        """
        spend(0)
        rows, kernel = self.settings.record if strobes else 0, backend.current()
        strobe = kernel.strobe(rows)
        if rows and self.state.period == 0:
            strobe.q[0], strobe.w[0] = self.position()
        logs: list[tuple] = []  # columns of each slice
        capacity = (
            min(max(FIRST_CAPACITY, 4 * self.settings.record), MOST_CAPACITY) if events else 0
        )
        while True:
            done = self.work.steps + self.work.evaluations
            status, log, strobe = self._slice(kernel, capacity, strobe)
            spend(self.work.steps + self.work.evaluations - done + ROW * self.state.logged)
            if self.state.logged or not logs:
                logs.append(tuple(column[: self.state.logged] for column in log[:5]))
            if status == Status.LOG_FULL:
                capacity = min(2 * capacity, MOST_CAPACITY)
            elif status == Status.PAUSED and not kernel.compiled:
                kernel = backend.compiled()
            elif status == Status.PAUSED:
                look()
            else:
                return self._record(logs, strobe, status)

    def go_on(self, skipped: int, record: int) -> Orbit:
        """The same orbit from where it is, to the last bit: turns to skip, and then to record.

        This one must have come to the end of its record, and stays there.
        """
        on = copy(self)
        on.settings = with_turns(self.settings, skipped, record)
        on.state = replace(self.state, period=-skipped, logged=0, total_impacts=0, detachments=0)
        on.work = Tally()
        return on

    def position(self) -> tuple[float, float]:
        """(q, dq/dtheta) now; m, m/rad."""
        c, c1, _ = lift_at(self.system.cam, self.state.stretch, self.state.theta)
        return c + self.state.gap, c1 + self.state.gap_rate

    def as_start(self) -> Start:
        """The present state as a start for another run; None values where it rests on the cam."""
        if self.state.mode == RESTING:
            return Start(theta=self.state.theta)
        q, w = self.position()
        return Start(q, w * self.omega, self.state.theta)

    @property
    def _thrown_off(self) -> bool:
        """Whether a downward kink throws the follower off right now, out of a rest."""
        stretch = self.system.cam.stretches[self.state.stretch]
        at_start = self.state.theta == stretch.start and self.state.gap == 0.0
        return at_start and self.state.gap_rate == -stretch.slope_jump > 0.0

    def _slice(self, kernel: Kernel, capacity: int, strobe: Strobe) -> tuple[Status, Log, Strobe]:
        """One call of the kernel: its status, the rows it logged, the strobe."""
        cam = self.system.cam_for(kernel)
        first = 0 if self.settings.transient else -1
        limited = not kernel.compiled and backend.may_compile()
        plan = Plan(first, self.settings.record, PLAIN_STEPS if limited else SLICE)
        self.state.logged = 0
        states, works = kernel.table(State, [self.state]), kernel.table(Tally, [self.work])
        strobe = strobe._replace(
            q=kernel.numbers(strobe.q), w=kernel.numbers(strobe.w),
            impacts=kernel.numbers(strobe.impacts, int),
            chatter=kernel.numbers(strobe.chatter, int),
        )  # fmt: skip
        log = kernel.log(capacity)
        flows = kernel.stretch_flows(cam, self.const)
        status = kernel.advance(cam, self.const, flows, states, plan, log, strobe, works)
        self.state, self.work = row_of(State, states[0]), row_of(Tally, works[0])
        return Status(status), log, strobe

    def _record(self, logs: list[tuple], strobe: Strobe, status: Status) -> Record:
        state = self.state
        periods = max(0, min(state.period, self.settings.record))
        started = min(periods + 1, strobe.rows) if state.period >= 0 else 0
        kind, period, theta, q, u = (
            np.concatenate([np.asarray(part, type_) for part in parts])
            for parts, type_ in zip(zip(*logs, strict=True), LOGGED, strict=True)
        )
        return Record(
            kind, period, theta, q, u,
            strobe_q=np.asarray(strobe.q[:started], float),
            strobe_w=np.asarray(strobe.w[:started], float),
            impacts=np.asarray(strobe.impacts[:started], int),
            chatter=np.asarray(strobe.chatter[:started], int),
            periods=periods,
            detachments=state.detachments,
            resting=state.mode == RESTING or self._thrown_off,
            status=status,
            cost=Cost(state.total_impacts, self.work.evaluations, self.work.crossings),
        )  # fmt: skip


def rounding_of(c: float) -> float:
    """What a start on the cam may be off it by rounding, m."""
    return ROUNDING_M * max(1.0, abs(c))


def _initial(cam: Cam, omega: float, settings: Settings, start: Start) -> State:
    """The kernel's state at the start; raises StartError below the cam."""
    theta = start.theta % TURN
    i = stretch_at(cam, theta)
    c, c1, _ = lift_at(cam, i, theta)
    gap = 0.0 if start.q is None else start.q - c
    rate = 0.0 if start.v is None else start.v / omega - c1
    if abs(gap) <= rounding_of(c):
        gap = 0.0  # q = 0.1 on a dwell of 0.4 - 0.3, which is an ulp more
    if gap < 0.0:
        found = f"found q = {start.q!r} m, {-gap:.6g} m below the cam"
        expected = f"expected at least c = {c!r} m at {round(degrees(theta), 9)!r} deg"
        raise StartError(
            Fault("", f"{start.place}.q", found, expected, "raise it, or null for rest")
        )
    on_strobe = i == cam.strobe and theta == cam.stretches[i].start
    mode = FREE if gap > 0.0 or rate < 0.0 else BOUNCED
    return State(theta, gap, rate, mode, i, -settings.transient - (0 if on_strobe else 1))


def refuse_below(
    setup: Callable[..., Setup], values: Sequence[float], start: Start | None = None
) -> None:
    """Raise StartError where the start lies below the cam at these values of what is varied.

    Any other failure there is that of one piece of the work, which will meet it.
    """
    attempt("", lambda: Orbit(*setup(*values), start))


def with_turns(settings: Settings, transient: int, record: int) -> Settings:
    """The same settings for another number of turns."""
    return replace(settings, transient=transient, record=record)
