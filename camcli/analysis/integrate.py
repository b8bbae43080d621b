"""Drive the kernel: start states, batches of orbits, slices of work, growing logs, resume.

Plain Python does the first steps (see `Portions`); longer work compiles the kernel. Both give the
same bits, so the switch can happen in the middle of an orbit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from copy import copy
from dataclasses import dataclass, field, replace
from functools import partial
from math import degrees, tau
from typing import NamedTuple

import numpy as np

from camcli.errors import CamError, Fault, SceneError, Status
from camcli.interrupts import raise_if_interrupted
from camcli.kernel import backend
from camcli.kernel.cam_table import Cam, lift_at, stretch_at
from camcli.kernel.contact_search import Tally
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.flow import Constants, Flow
from camcli.kernel.follow import Run
from camcli.kernel.forms import Kernel, rows_of
from camcli.kernel.loads import SHUT, Loads
from camcli.kernel.orbit_loop import NEVER, RESTING, Earlier, State
from camcli.piece_faults import attempt
from camcli.system import System, omega_of

EVENTS_A_TURN = 4  # for which a log has room at first; where there are more it grows
MOST_MEASURED = 10_000  # turns whose loads one call of the kernel measures: less than half a second
ROUNDING_M = 2e-16  # m per m of lift: rounding of q - c where a contact is found
PATIENCE = 20_000  # turns that a motion is followed on before it is called aperiodic
TURN = tau  # rad
ROW = 20  # evaluations that take as long as looking at a row of a log


@dataclass(frozen=True)
class Portions:
    """How much of the work is one call of the kernel. No bit of a record depends on it."""

    plain_steps: int = 20_000  # in plain Python before compiling pays (about half a second)
    compiled_steps: int = 200_000  # of a call of the compiled kernel: 40 ms, at worst half a second
    first_rows: int = 256  # of a log, at least
    most_rows: int = 1 << 20  # of a log when it is made; it grows where that is too little
    copies_turns: bool = True  # that are others again, to the last bit; else all are flown


USUAL_PORTIONS = Portions()
ALL_FLOWN = Portions(copies_turns=False)  # for a comparison with programs that fly every turn


@dataclass(frozen=True)
class Start:
    """Initial state: q (m), v (m/s), None meaning on the cam and at its velocity; theta in rad.

    place: the key of the scene under which it stands.
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
    """A function that returns the `Setup` of a speed: where no other number is varied."""

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
        self.limit = limit
        self.tick = tick
        self.done = 0

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
    raise_if_interrupted()
    budget = _budget.get()
    if budget is not None:
        budget.spend(work)


class StartError(SceneError):
    """The start lies below the cam; the fault says how deep."""


class Cost(NamedTuple):
    """Tally done, transient included; a named tuple, which a sweep makes quickly."""

    impacts: int = 0
    evaluations: int = 0
    crossings: int = 0

    def __add__(self, other: Cost) -> Cost:  # type: ignore[override]
        return Cost(
            self.impacts + other.impacts,
            self.evaluations + other.evaluations,
            self.crossings + other.crossings,
        )


class Record(NamedTuple):
    """Recorded rows of one orbit; angles in rad, lengths in m, velocities in m/rad.

    kind, period, theta, q, u have a row per logged event, `strobe_*` one per started period;
    `impacts` and `chatter` count within it, `periods` of them are whole: hits and chatters are the
    sums over these. repeats: after how many turns the record repeats at its end, 0 where it does
    not; near: whether it nearly does (`kernel.returns`); loads: those measured on the way, or None.
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
    hits: int = 0
    chatters: int = 0
    repeats: int = 0
    near: bool = False
    loads: Loads | None = None

    @property
    def rests_throughout(self) -> bool:
        """True where the follower rested on the cam during the whole record."""
        return self.resting and self.detachments == 0 and self.hits == 0

    def events(self) -> list[tuple[int, int, float, float, float]]:
        """(kind, period, theta, q, u) of every logged event, in Python's own numbers."""
        columns = self.kind, self.period, self.theta, self.q, self.u
        return list(zip(*(column.tolist() for column in columns), strict=True))


class Orbit:
    """One orbit between calls of the kernel.

    omega: of the cam, rad/s; const: the kernel's constants of the speed; state: where it is; work:
    what was done so far. start: where it begins, by default that of the settings.
    """

    def __init__(self, system: System, rpm: float, settings: Settings, start: Start | None = None):
        self.system = system
        self.settings = settings
        self.omega = omega_of(rpm)
        self.const = system.constants(rpm, settings.chatter_tolerance, settings.impact_budget)
        self.state = _initial(
            system.cam, self.omega, settings, settings.start if start is None else start
        )
        self.work = Tally()

    def run(
        self, events: bool = True, strobes: bool = True, portions: Portions = USUAL_PORTIONS
    ) -> Record:
        """Run transient and record; `events` and `strobes` say what is logged at all.

        Raises BudgetSpentError where there is a `Budget`, and too little left.
        """
        return run_all([self], events, strobes, portions=portions)[0]

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


def run_all(
    orbits: Sequence[Orbit],
    events: bool = True,
    strobes: bool = True,
    loads: bool = False,
    portions: Portions = USUAL_PORTIONS,
) -> list[Record]:
    """`Orbit.run` of orbits on one cam, in as few calls of the kernel as possible.

    loads: they are measured on the way, where a record is not too long for that.
    """
    spend(0)
    return _Batch(orbits, events, strobes, loads, portions).run() if orbits else []


def follow_on(orbit: Orbit, parts: Sequence[int]) -> list[tuple[Orbit, Record]]:
    """Follow an orbit on in parts of so many turns, and look at the record of each.

    orbit: at the end of its record; it stays there. Returns for each part, in order, the orbit at
    its end and its record, which has no events. The last part is the first one whose record
    repeats, has a rest or ended in trouble: those after it are left out.
    """
    spend(0)
    orbits = [orbit.go_on(0, turns) for turns in parts]
    batch = _Batch(
        orbits, events=False, strobes=True, loads=False, portions=USUAL_PORTIONS, in_a_row=True
    )
    records = batch.run()
    runs = rows_of(Run, batch.runs)
    return [
        (on, record)
        for on, record, run in zip(orbits, records, runs, strict=True)
        if not run.not_begun
    ]


class _Batch:
    """Orbits on one cam, and the tables in which a kernel runs them.

    Loads are measured from the events and the strobes of a record, so only where both are logged,
    and where it has no more turns than one call of the kernel can do at once.
    """

    def __init__(
        self,
        orbits: Sequence[Orbit],
        events: bool,
        strobes: bool,
        loads: bool,
        portions: Portions,
        in_a_row: bool = False,
    ):
        """in_a_row: each orbit begins where the one before it ends, see `follow_on`."""
        kernel = backend.current()
        self.orbits = orbits
        self.kernel = kernel
        self.portions = portions
        shut = shut_lift(orbits[0].system) if loads else 0.0
        runs = _runs_of(orbits, events, strobes, loads)
        for run in runs[1:]:
            run.continues = int(in_a_row)
        self.runs = kernel.table(Run, runs)
        self.consts = kernel.table(Constants, [orbit.const for orbit in orbits])
        self.states = kernel.table(State, [orbit.state for orbit in orbits])
        self.works = kernel.table(Tally, [orbit.work for orbit in orbits])
        earlier = Earlier() if portions.copies_turns else Earlier(keep_in=NEVER)
        self.earliers = kernel.copies(Earlier, earlier, len(orbits))
        self.loads = kernel.copies(Loads, Loads(shut=shut), len(orbits))
        self.strobe = kernel.strobe(sum(run.strobe_rows for run in runs))
        for orbit, run in zip(orbits, runs, strict=True):
            if run.strobe_rows and orbit.state.period == 0:
                q, w = orbit.position()
                self.strobe.q[run.strobe_first] = q
                self.strobe.w[run.strobe_first] = w
        capacity = EVENTS_A_TURN * sum(run.turns for run in runs)
        rows = min(max(portions.first_rows, capacity), portions.most_rows) if events else 0
        self.log = kernel.unwritten_log(rows)
        self.before = [_spent(orbit.work, 0) for orbit in orbits]
        self.done = 0  # work on the orbits that are at their ends
        self.counted = 0  # work that is spent already, see `spend`

    def run(self) -> list[Record]:
        """The records, and the orbits at their ends."""
        records: list[Record] = []
        while len(records) < len(self.orbits):
            begin = len(records)
            reached = self._call(begin)
            records += self._records(slice(begin, reached))
            self._count(reached)
            if reached == len(self.orbits):
                break
            if self.runs[reached].status == Status.LOG_FULL:
                self._make_room(reached)
            elif self.kernel.compiled:
                raise_if_interrupted()
            else:
                self._take(backend.compiled())
        return records

    def _call(self, begin: int) -> int:
        """One call of the kernel: the number of the orbit that is not at its end."""
        cam = self.orbits[0].system.cam_for(self.kernel)
        steps = self.portions.compiled_steps
        if not self.kernel.compiled and backend.may_compile():
            steps = self.portions.plain_steps
        return self.kernel.follow_orbits(
            cam, self.consts, self.kernel.room(Flow, len(cam.stretches) ** 2), self.states,
            self.works, self.runs, self.earliers, self.loads, self.log, self.strobe, begin, steps,
        )  # fmt: skip

    def _count(self, reached: int) -> None:
        """Take the work of the last call from the budget of work (`spend`).

        reached: the orbit that the call stopped at. Its work so far counts, and that of the orbits
        before it, which are at their ends, less what was counted after earlier calls.
        """
        done = self.done
        if reached < len(self.orbits):
            work = self.works[reached]
            run = self.runs[reached]
            done += _spent(work, int(run.log_last - run.log_first)) - self.before[reached]
        spend(done - self.counted)
        self.counted = done

    def _take(self, kernel: Kernel) -> None:
        """Go on with another kernel: put all tables, as they are now, into the form it takes."""
        self.kernel = kernel
        self.runs = kernel.table(Run, self.runs)
        self.consts = kernel.table(Constants, self.consts)
        self.states = kernel.table(State, self.states)
        self.works = kernel.table(Tally, self.works)
        self.earliers = kernel.table(Earlier, self.earliers)
        self.loads = kernel.table(Loads, self.loads)
        real = kernel.numbers
        whole = partial(kernel.numbers, kind=int)
        self.strobe = self.strobe._replace(
            q=real(self.strobe.q),
            w=real(self.strobe.w),
            impacts=whole(self.strobe.impacts),
            chatter=whole(self.strobe.chatter),
        )
        self.log = self.log._replace(
            kind=whole(self.log.kind),
            period=whole(self.log.period),
            theta=real(self.log.theta),
            q=real(self.log.q),
            u=real(self.log.u),
        )

    def _make_room(self, k: int) -> None:
        """Give orbit k, whose log is full, one twice as large, which begins with its own events.

        The events of the orbits before it are left out: they are in their records.
        """
        run = self.runs[k]
        full = self.log
        its_rows = slice(run.log_first, run.log_last)
        count = int(run.log_last - run.log_first)
        self.log = self.kernel.unwritten_log(2 * full.capacity)
        for name in ("kind", "period", "theta", "q", "u"):
            getattr(self.log, name)[:count] = getattr(full, name)[its_rows]
        self.earliers[k].logged -= run.log_first
        run.log_first = 0
        run.log_last = count
        self.states[k].logged = count

    def _records(self, some: slice) -> list[Record]:
        """The records of orbits that are at their ends."""
        runs = rows_of(Run, self.runs[some])
        if not runs:
            return []
        rows = (
            self.orbits[some],
            runs,
            rows_of(State, self.states[some]),
            rows_of(Tally, self.works[some]),
            rows_of(Loads, self.loads[some]),
            self.before[some],
        )
        log = self.log
        strobe = self.strobe
        used = runs[-1].log_last
        if len(self.orbits) == 1 and self.kernel.compiled:
            for column in (log.kind, log.period, log.theta, log.q, log.u):
                column.resize(used, refcheck=False)  # cut off in place: a copy costs new memory
        events = [np.asarray(column[:used], int) for column in (log.kind, log.period)]
        events += [np.asarray(column[:used], float) for column in (log.theta, log.q, log.u)]
        strobes = [np.asarray(strobe.q, float), np.asarray(strobe.w, float)]
        strobes += [np.asarray(strobe.impacts, int), np.asarray(strobe.chatter, int)]
        return [self._record(events, strobes, *of_orbit) for of_orbit in zip(*rows, strict=True)]

    def _record(
        self,
        events: list[np.ndarray],
        strobes: list[np.ndarray],
        orbit: Orbit,
        run: Run,
        state: State,
        work: Tally,
        loads: Loads,
        before: int,
    ) -> Record:
        """The record of an orbit that is at its end.

        events, strobes: the columns of the whole batch; the only record has columns of its own,
        others are parts of these.
        """
        state.logged = 0
        orbit.state = state
        orbit.work = work
        self.done += _spent(work, run.log_last - run.log_first) - before
        started = min(run.periods + 1, run.strobe_rows) if state.period >= 0 else 0
        logged = [column[run.log_first : run.log_last] for column in events]
        recorded = slice(run.strobe_first, run.strobe_first + started)
        turns = [column[recorded] for column in strobes]
        if len(self.orbits) == 1:
            turns = [column.copy() for column in turns]
        kind, period, theta, q, u = logged
        strobe_q, strobe_w, impacts, chatter = turns
        measured = run.wants_loads and run.periods
        return Record(
            kind, period, theta, q, u, strobe_q, strobe_w, impacts, chatter,
            periods=run.periods,
            detachments=state.detachments,
            resting=bool(run.resting),
            status=Status(run.status),
            cost=Cost(state.total_impacts, work.evaluations, work.crossings),
            hits=run.impacts,
            chatters=run.chatters,
            repeats=run.repeats,
            near=bool(run.near),
            loads=loads if measured else None,
        )  # fmt: skip


def _runs_of(orbits: Sequence[Orbit], events: bool, strobes: bool, loads: bool) -> list[Run]:
    """What the kernel is asked for of each orbit; arguments as of `run_all`.

    The rows of the orbits' strobes stand one after the other in one table.
    """
    runs = []
    strobe_first = 0
    for orbit in orbits:
        turns = orbit.settings.record
        measured = loads and events and strobes and turns <= MOST_MEASURED
        strobe_rows = turns if strobes else 0
        # Recorded turns count from 0. The start may lie before the first strobe: without a
        # transient the events until then, of turn -1, are logged too.
        log_from = 0 if orbit.settings.transient else -1
        runs.append(
            Run(
                log_from=log_from,
                turns=turns,
                strobe_first=strobe_first,
                strobe_rows=strobe_rows,
                wants_loads=int(measured),
            )
        )
        strobe_first += strobe_rows
    return runs


def _spent(work: Tally, rows: int) -> int:
    """The work on an orbit as a budget counts it: steps, evaluations, and rows logged."""
    return int(work.steps + work.evaluations) + ROW * rows


def shut_lift(system: System) -> float:
    """The lift up to which a cam counts as shut, m."""
    lowest, highest = system.lift_range
    return lowest + SHUT * (highest - lowest)


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
    # On the cam with a rate into it, the follower lands at once; with none or one off the cam it is
    # where an impact leaves it.
    mode = FREE if gap > 0.0 or rate < 0.0 else BOUNCED
    period = -settings.transient
    if not on_strobe:
        period -= 1  # the turn that the start cuts short
    return State(theta=theta, gap=gap, gap_rate=rate, mode=mode, stretch=i, period=period)


def refuse_below(
    setup: Callable[..., Setup], values: Sequence[float], start: Start | None = None
) -> None:
    """Raise StartError where the start lies below the cam at these values of what is varied.

    Any other failure at these values is left alone: the piece of work that computes them will
    meet it again, and reports it.
    """
    attempt("", lambda: Orbit(*setup(*values), start))


def with_turns(settings: Settings, transient: int, record: int) -> Settings:
    """The same settings for another number of turns."""
    return replace(settings, transient=transient, record=record)
