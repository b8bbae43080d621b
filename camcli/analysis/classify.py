"""Name the motion at one speed: solved periodic orbit, chaos with its exponent, or undecided."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from math import nan

import numpy as np

from camcli.analysis.after_rest import CYCLE, HoldsFor, after_first_rest
from camcli.analysis.exponents import Exponents, of_orbit, of_record
from camcli.analysis.integrate import (
    AtSpeeds,
    Cost,
    Orbit,
    Record,
    Settings,
    Setup,
    Start,
    refuse_below,
    with_turns,
)
from camcli.analysis.labels import APERIODIC, FEWEST_TURNS, LONGEST_PERIOD, UNDECIDED, passages
from camcli.analysis.orbits.identify import TOO_LARGE, identify, largest_growth
from camcli.analysis.orbits.orbit import PeriodicOrbit, resting_orbit
from camcli.analysis.orbits.same_orbit import SAME, distance_to, same_orbit
from camcli.analysis.orbits.search import cloud
from camcli.analysis.patience import watch
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.orbit_loop import IMPACT
from camcli.parallel import in_threads
from camcli.piece_faults import PieceFault, attempt
from camcli.system import System

COMPLETE, INCOMPLETE, NONE = "complete", "incomplete", "none"
BURST = 8  # impacts in a row, each weaker than the one before, that make an incomplete chatter
LONGER = 8  # times the record, where neither a period nor an exponent was certain


@dataclass(frozen=True)
class ClassifiedMotion:
    """The motion that one start leads to, at one speed.

    value: the speed (rpm), or that of what is varied instead; label: P(m;...), contact, aperiodic
    or undecided; orbit: solved, where periodic; exponents: None where the record shows too little;
    transient: turns until the orbit is reached (None without one); impacts: in one period of the
    orbit, or the mean per turn; record: of the recorded turns; holds_for: the machines that a label
    is about which doubles alone could not tell (`after_rest`); watched: turns for which a motion
    that looked aperiodic was followed in all, None for others; fault: what nobody foresaw and cost
    this value: its status is FAULT then, and nothing of the motion is known.
    """

    value: float
    rpm: float
    start: Start
    label: str
    orbit: PeriodicOrbit | None
    exponents: Exponents | None
    impacts: float
    chatter: str
    transient: int | None
    status: int
    cost: Cost
    record: Record
    holds_for: HoldsFor | None = None
    watched: int | None = None
    fault: PieceFault | None = None

    @property
    def period(self) -> int:
        """Turns after which the motion repeats; 0 where it does not."""
        return 0 if self.orbit is None else self.orbit.turns

    @property
    def chatters(self) -> int:
        """Complete chatters in the record."""
        return int(self.record.chatter[: self.record.periods].sum())

    @property
    def stable(self) -> bool | None:
        """True for a solved attracting orbit, None where nothing is solved."""
        return None if self.orbit is None else self.orbit.stable


def classify(
    system: System,
    settings: Settings,
    values: Sequence[float],
    starts: int = 0,
    seed: int = 0,
    threads: int | None = 1,
    on_speed: Callable[[], None] = lambda: None,
    setup: Callable[[float], Setup] | None = None,
    key: str = "rpm",
) -> list[ClassifiedMotion]:
    """The motions from settings.start and `starts` of a cloud, speed by speed in order.

    Each with the length of its transient; `seed` chooses other starts of the cloud. The values are
    speeds (rpm), or what `setup` makes machines of; key: of what is varied. A value that raises
    what nobody foresaw has one motion, of status FAULT. Raises StartError before any work if the
    start lies below the cam.
    """
    setup = setup or AtSpeeds(system, settings)
    if values:
        refuse_below(setup, (values[0],))
    turns = len(values) * (starts + 1) * (settings.transient + settings.record)
    backend.for_work(turns)

    def motions_at(value: float) -> list[ClassifiedMotion]:
        varied, rpm, runs = setup(value)
        motions = attractors(varied, rpm, runs, starts, seed)
        return [replace(motion, value=value) for motion in motions]

    def motions_or_fault(value: float) -> list[ClassifiedMotion]:
        result = attempt(f"{key} = {value!r}", lambda: motions_at(value))
        if isinstance(result, PieceFault):
            return [_failed(value, value if key == "rpm" else nan, settings.start, result)]
        return result

    motions: list[ClassifiedMotion] = []
    for found in in_threads(motions_or_fault, values, threads):
        motions += found
        on_speed()
    return motions


def _failed(value: float, rpm: float, start: Start, fault: PieceFault) -> ClassifiedMotion:
    """A motion of which nothing is known."""
    nothing = np.empty(0)
    count = np.empty(0, int)
    record = Record(
        count, count, nothing, nothing, nothing, nothing, nothing, count, count,
        periods=0, detachments=0, resting=False, status=Status.FAULT, cost=Cost(),
    )  # fmt: skip
    return ClassifiedMotion(
        value, rpm, start, UNDECIDED, None, None, nan, "", None, Status.FAULT, Cost(), record,
        fault=fault,
    )  # fmt: skip


def classify_at(
    system: System,
    rpm: float,
    settings: Settings,
    start: Start | None = None,
    begun: tuple[Orbit, Record] | None = None,
) -> ClassifiedMotion:
    """The motion from a start (settings.start unless given), after settings.transient turns.

    Periodic means: Newton's iteration from the end of the record converges to an admissible,
    attracting orbit that the record approaches, of a period up to LONGEST_PERIOD. Aperiodic means:
    no such orbit, a largest Lyapunov exponent above zero by three standard errors, and neither an
    orbit nor a rest in settings.patience further turns (`analysis.patience`). Where neither can be
    shown in LONGER times the record, or a record without a period holds complete chatters, the
    motion after the rest is followed with many digits (`analysis.after_rest`) and named instead; if
    even that is not certain, it is undecided.

    begun: the orbit at the end of its record, where it has been run; the cost is without it then.
    """
    start = settings.start if start is None else start
    motion = _Followed(system, rpm, settings, start, begun)
    if motion.status == Status.OK and not motion.certain:
        motion.go_on()
    if motion.status == Status.OK and motion.orbit is None and motion.rests_in_record:
        motion.follow_after_rest()
    rests = False
    if motion.status == Status.OK and motion.orbit is None and motion.certain:
        motion.follow_with_patience()
        rests = motion.orbit is None and motion.rests_in_record > 0
        if rests and motion.rests_in_record > 1:  # often enough to be followed
            rests = not motion.end_after_rest()
    orbit = motion.orbit
    label = UNDECIDED
    if orbit is not None:
        label = orbit.label
    elif motion.status == Status.OK and not rests and motion.certain:
        label = APERIODIC
    return ClassifiedMotion(
        value=rpm,
        rpm=rpm,
        start=start,
        label=label,
        orbit=orbit,
        exponents=motion.exponents,
        impacts=_impacts(orbit, motion.record),
        chatter=_chatter(motion.record),
        transient=None,
        status=motion.status,
        cost=motion.cost,
        record=motion.record,
        holds_for=motion.holds_for if orbit else None,
        watched=motion.watched,
    )


class _Followed:
    """A motion that is followed until it can be named, and what is known of it so far.

    run: from where doubles can go on; record: the last turns that were recorded; turns: how many
    it was followed for in all, the transient included; watched: how many of them until it was
    called aperiodic, None where it was not; holds_for: as in `ClassifiedMotion`.
    """

    def __init__(
        self,
        system: System,
        rpm: float,
        settings: Settings,
        start: Start,
        begun: tuple[Orbit, Record] | None,
    ):
        self.system = system
        self.rpm = rpm
        self.settings = settings
        self.recorded = max(settings.record, FEWEST_TURNS)
        if begun is not None and settings.record == self.recorded:
            self.run, self.record = begun
            self.cost = Cost()
        else:
            settings_here = with_turns(settings, settings.transient, self.recorded)
            self.run = Orbit(system, rpm, settings_here, start)
            self.record = self.run.run()
            self.cost = self.record.cost
        self.turns = settings.transient + self.recorded
        self.orbit, self.exponents = _solved(system, rpm, self.record)
        self.holds_for: HoldsFor | None = None
        self.watched: int | None = None

    @property
    def status(self) -> int:
        """How the last record ended."""
        return self.record.status

    @property
    def certain(self) -> bool:
        """True where an orbit was solved, or the exponent says chaos."""
        chaotic = self.exponents is not None and self.exponents.chaotic
        return self.orbit is not None or chaotic

    @property
    def rests_in_record(self) -> int:
        """Complete chatters in the last record."""
        return int(self.record.chatter[: self.record.periods].sum())

    def go_on(self) -> None:
        """Follow the motion for LONGER times its record, and solve for its end again."""
        more_turns = LONGER * self.recorded
        run = self.run.go_on(0, more_turns)
        record = run.run()
        self.cost = self.cost + record.cost
        self.orbit, self.exponents = _solved(self.system, self.rpm, record)
        if record.status == Status.OK:
            self.run = run
            self.record = record
            self.turns += more_turns

    def follow_after_rest(self) -> None:
        """Take the true motion after the first rest of the record for the one of doubles."""
        after = _after_rest(self.system, self.rpm, self.settings, self.record)
        self.orbit = after.orbit
        self.exponents = after.exponents
        self.holds_for = after.holds_for
        if after.run is not None:
            self.run = after.run
            self.record = after.record
            self.cost = self.cost + after.record.cost
            self.turns += self.settings.transient + self.recorded

    def follow_with_patience(self) -> None:
        """Follow what looks aperiodic on for long; what it ends on takes its place."""
        seen = watch(self.run, self.rpm, self.settings.patience, self.recorded)
        self.watched = self.turns + seen.turns
        self.cost = self.cost + seen.cost
        if seen.stays or seen.record is None:
            return
        self.record = seen.record
        self.orbit = seen.orbit
        if seen.orbit is None:
            self.exponents = _exponents(self.system, self.rpm, seen.record)
        else:
            self.exponents = of_orbit(self.system, seen.orbit)

    def end_after_rest(self) -> bool:
        """Take the orbit that the motion ends on after a rest; False where none is known."""
        after = _after_rest(self.system, self.rpm, self.settings, self.record)
        if after.orbit is None:
            return False
        self.orbit = after.orbit
        self.exponents = after.exponents
        self.holds_for = after.holds_for
        self.record = after.record
        self.cost = self.cost + after.record.cost
        return True


def _solved(
    system: System, rpm: float, record: Record
) -> tuple[PeriodicOrbit | None, Exponents | None]:
    """The orbit at the end of a record, and its exponents or those of the record."""
    orbit = identify(system, rpm, record)
    if orbit is not None:
        return orbit, of_orbit(system, orbit)
    return None, _exponents(system, rpm, record)


def _exponents(system: System, rpm: float, record: Record) -> Exponents | None:
    """The exponents of a record; None where it ended in trouble."""
    return of_record(system, rpm, record) if record.status == Status.OK else None


@dataclass(frozen=True)
class _AfterRest:
    """The true motion after a rest, if known: its orbit, its record, and for whom it is.

    run: where doubles went on from what ball arithmetic found, None where they did not.
    """

    orbit: PeriodicOrbit | None
    exponents: Exponents | None
    record: Record
    holds_for: HoldsFor | None
    run: Orbit | None = None


def _after_rest(system: System, rpm: float, settings: Settings, record: Record) -> _AfterRest:
    """The true motion after the first rest of a record, see `analysis.after_rest`.

    A cycle through rests is its orbit. Any other end, if known, is a state that doubles go on from.
    """
    after = after_first_rest(system, rpm, record)
    if after.kind == CYCLE:
        cycle = resting_orbit(system, rpm, after.states, after.symbols, after.leaves)
        return _AfterRest(cycle, of_orbit(system, cycle), record, after.holds_for)
    start = after.start(system, rpm)
    run = None
    if start is not None:
        turns = with_turns(settings, settings.transient, max(settings.record, FEWEST_TURNS))
        run = Orbit(system, rpm, turns, start)
        record = run.run()
    holds_for = after.holds_for or HoldsFor.ROUNDING  # it wandered, and doubles went on
    orbit, exponents = _solved(system, rpm, record)
    return _AfterRest(orbit, exponents, record, holds_for, run)


def own_end(system: System, settings: Settings, motion: ClassifiedMotion) -> ClassifiedMotion:
    """The motion with the orbit that its start ends on, where that can be told, and its transient.

    On the way from a rest to an orbit without rests an error of rounding may grow beyond all
    digits. Doubles then end on an attractor of the machine, but another one may be the end of this
    start: the motion after the rest is followed with many digits. Where that finds no end, the
    label stays and holds for ROUNDING.
    """
    orbit = motion.orbit
    if orbit is None or orbit.resting or motion.holds_for is not None:
        return with_transient(system, settings, motion)
    record = _from_start(system, settings, motion, True)
    motion = _reached(motion, record)
    turns = record.periods if motion.transient is None else motion.transient
    if largest_growth(system, motion.rpm, record, range(-1, turns)) <= TOO_LARGE:
        return motion
    after = _after_rest(system, motion.rpm, settings, record)
    if after.holds_for in (None, HoldsFor.ROUNDING) or after.orbit is None:
        return replace(motion, holds_for=HoldsFor.ROUNDING)
    motion = replace(motion, holds_for=after.holds_for)
    if same_orbit(after.orbit, orbit):
        return motion
    return replace(
        motion,
        label=after.orbit.label,
        orbit=after.orbit,
        exponents=after.exponents,
        impacts=_impacts(after.orbit, after.record),
        chatter=COMPLETE if after.orbit.resting else _chatter(after.record),
        transient=None,
        record=after.record,
    )


def attractors(
    system: System, rpm: float, settings: Settings, starts: int, seed: int
) -> list[ClassifiedMotion]:
    """The different motions reached from the scene's start and a cloud, in a fixed order.

    Each with its transient; that of the scene's start is where this start ends (`own_end`).
    """
    skip = seed * starts
    motions: list[ClassifiedMotion] = []
    for start in (settings.start, *islice(cloud(system, rpm), skip, skip + starts)):
        motion = classify_at(system, rpm, settings, start)
        if not motions:
            motion = own_end(system, settings, motion)
        known = next((k for k, other in enumerate(motions) if same_motion(motion, other)), None)
        if known is None:
            motions.append(motion)
        else:  # what it took was done all the same
            motions[known] = replace(motions[known], cost=motions[known].cost + motion.cost)
    others = [with_transient(system, settings, motion) for motion in motions[1:]]
    return sorted([*motions[:1], *others], key=_order)


def same_motion(a: ClassifiedMotion, b: ClassifiedMotion) -> bool:
    """The same solved orbit, or the same word for what is not solved."""
    if a.orbit is not None and b.orbit is not None:
        return same_orbit(a.orbit, b.orbit)
    return a.label == b.label and a.orbit is None and b.orbit is None


def _order(motion: ClassifiedMotion):
    orbit = motion.orbit
    state = (0.0, 0.0) if orbit is None else orbit.states[0]
    return (orbit is None, motion.period, motion.label, state)


def _impacts(orbit: PeriodicOrbit | None, record: Record) -> float:
    """Impacts in one period, inf with a complete chatter; of no period the mean per turn."""
    if orbit is not None:
        return sum(orbit.symbols) if orbit.theta else 0.0
    return float(record.impacts[: record.periods].sum()) / max(1, record.periods)


def _chatter(record: Record) -> str:
    """Complete where impacts accumulate in the record, incomplete where a long burst does not."""
    if record.chatter[: record.periods].any():
        return COMPLETE
    speeds = -record.u[record.kind == IMPACT]
    weaker = speeds[1:] < speeds[:-1]
    not_weaker = 1 + np.flatnonzero(~weaker)  # impacts at which a burst begins anew
    longest = int(np.diff(not_weaker, prepend=0, append=len(speeds)).max()) - 1
    return INCOMPLETE if longest >= BURST else NONE


def with_transient(
    system: System, settings: Settings, motion: ClassifiedMotion
) -> ClassifiedMotion:
    """The motion with the length of its transient, from a run logged from the start.

    Counted in turns until the state at the strobe stays at the solved orbit.
    """
    if motion.orbit is None:
        return motion
    return _reached(motion, _from_start(system, settings, motion, False))


def _from_start(
    system: System, settings: Settings, motion: ClassifiedMotion, events: bool
) -> Record:
    """The transient of a motion, and some turns more."""
    run = with_turns(settings, 0, settings.transient + 2 * LONGEST_PERIOD)
    return Orbit(system, motion.rpm, run, motion.start).run(events=events)


def _reached(motion: ClassifiedMotion, record: Record) -> ClassifiedMotion:
    """The motion with its transient, where it reaches its orbit in a record from the start."""
    orbit = motion.orbit
    motion = replace(motion, cost=motion.cost + record.cost)
    assert orbit is not None
    away = [distance_to(state, orbit.states) > SAME for state in passages(record)[0]]
    if not away or away[-1]:
        return motion
    last = max((k for k, far in enumerate(away) if far), default=-1)
    return replace(motion, transient=last + 1)
