"""Brute-force bifurcation diagram: one orbit per speed, impact and stroboscopic sections."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, groupby, pairwise
from math import nan
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.classify import ClassifiedMotion, classify_at
from camcli.analysis.integrate import (
    AtSpeeds,
    Cost,
    Orbit,
    Record,
    Settings,
    Setup,
    Start,
    refuse_below,
    run_all,
    with_turns,
)
from camcli.analysis.labels import APERIODIC, UNDECIDED, from_plain, sections, to_plain
from camcli.analysis.loads import Loads, loads_of
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.same_orbit import SAME, distances, size_of
from camcli.analysis.patience import forgets_too_much, named_on, names_nothing, turns_after
from camcli.analysis.speeds import NOTHING, Speed, SpeedColumns
from camcli.errors import Status
from camcli.kernel import backend
from camcli.kernel.cam_table import lift_at
from camcli.kernel.orbit_loop import IMPACT
from camcli.parallel import Codec, Work, stored
from camcli.parallel.work import Kept
from camcli.piece_faults import PieceFault, attempt
from camcli.system import System

FIXED, UP, DOWN, BOTH = "fixed", "up", "down", "both"
FINEST = 1200  # of the range: an adaptive sweep goes down to steps of one of so many parts
CHANGED = 0.1  # of the range of a load: more is a change of a chaotic motion
SURE = 2  # neighbours that stay aperiodic: a transient is not looked for beyond them
ON_CAM = 1e-12  # relative distance of a state from the cam's that is rounding

AT_ONCE, MOST_AT_ONCE = 20_000, 64  # turns and speeds that are run together: some 5 ms


@dataclass(frozen=True)
class Sweep:
    """All speeds in the order they were run."""

    speeds: Sequence[Speed]
    direction: str
    cost: Cost
    key: str = "rpm"  # what is varied
    also: Sequence[Start] = ()  # started from too
    bare: Sequence[Speed] = ()  # without their sections, which may be on disk
    ways: Sequence[tuple[str | int, ...]] = ()  # values of way_names, for each speed

    @property
    def way_names(self) -> tuple[str, ...]:
        """What tells the speeds apart: direction where carried both ways, start of several."""
        names = ["direction"] if self.direction == BOTH else []
        if self.also:
            names.append("start")
        return tuple(names)

    def sections(self, names: Sequence[str]) -> Iterator[tuple[float, list[tuple]]]:
        """(value, columns of each section named) of each speed.

        names: of `impacts` and `strobe`, whichever were asked for.
        """
        for k, speed in enumerate(self.bare):
            yield speed.value, _sections_of(self.speeds, k, names)

    @property
    def troubled(self) -> list[Speed]:
        """Speeds whose status is not ok, without their sections."""
        return [speed for speed in self.bare if speed.status != Status.OK]

    @property
    def faults(self) -> list[PieceFault]:
        """The faults that cost single speeds, see `Speed`."""
        return _faults(self.bare)


@dataclass(frozen=True)
class Map:
    """Motions over two numbers: lines[j][k] at the k-th value of the first, the j-th of the second.

    Its speeds have no sections, and their `value` is that of the first number.
    """

    keys: tuple[str, str]
    first: Sequence[float]
    second: Sequence[float]
    lines: Sequence[Sequence[Speed]]
    direction: str
    cost: Cost

    @property
    def speeds(self) -> Iterator[Speed]:
        """All, line after line."""
        for line in self.lines:
            yield from line

    @property
    def faults(self) -> list[PieceFault]:
        """The faults that cost single points, see `Speed`."""
        return [fault for line in self.lines for fault in _faults(line)]


def sweep(
    system: System,
    values: Sequence[float],
    settings: Settings,
    *,
    key: str = "rpm",
    setup: Callable[[float], Setup] | None = None,
    direction: str = FIXED,
    also: Sequence[Start] = (),
    adaptive: bool = False,
    impacts: bool = True,
    strobe: bool = True,
    lyapunov: bool = False,
    work: Work | None = None,
    on_speed: Callable[[Speed], None] = lambda speed: None,
) -> Sweep:
    """Run every value; `up` and `down` carry the state from each to the next, `both` up, then down.

    All is done again from each start of `also`. `adaptive` adds values between two whose labels
    differ, or the sizes of whose chaos do, down to FINEST of the range; only where each starts
    alike (`fixed`). Where motions look aperiodic, those at the ends of each range of them are
    followed on with patience as `classify` does, inwards until two neighbours stay aperiodic; what
    one settles on takes its place. The values are speeds (rpm), or what `setup` makes machines of.

    Where `work` has a checkpoint, the speeds are kept in it and read from it. `on_speed` is called
    with each finished speed, in order. A speed that raises what nobody foresaw has the status
    FAULT. Raises StartError before any work if a start lies below the cam.
    """
    each = settings.transient + settings.record
    turns = len(values) * each
    machines = setup or AtSpeeds(system, settings)
    carries = direction != FIXED
    task = _Task(key, machines, impacts, strobe, lyapunov, turns, each, keeps_ends=carries)
    tasks = [task, *(replace(task, start=start) for start in also)]
    if values:
        for one in tasks:
            refuse_below(one.setup, (values[0],), one.start)
    made = _SweepInTheMaking(work or Work(), on_speed, patient=settings.patience > 0)
    added = False
    for number, one in enumerate(tasks):
        start = (number,) if also else ()
        if direction == FIXED:
            own = made.fixed(one, values, adaptive)
            made.enlist(own, start)
            added = added or len(own) > len(values)
            continue
        ways = (UP, DOWN) if direction == BOTH else (direction,)
        for way in ways:
            own = made.carried(one, sorted(values, reverse=way == DOWN))
            made.enlist(own, (way, *start) if direction == BOTH else start)
    if added:
        made.sort_by_value()
    return Sweep(
        speeds=_Joined(made.parts, made.order),
        direction=direction,
        cost=made.rows.cost,
        key=key,
        also=also,
        bare=made.rows.chosen(made.order),
        ways=made.ways,
    )


@dataclass(slots=True)
class _Row:
    """A row of a sweep while it is made: where it is among all, and from where it starts."""

    at: int
    start: Start | None
    watched: bool = False


class _SweepInTheMaking:
    """The speeds of a sweep as they are computed.

    parts: all speeds in the order they were computed, in sequences that may be on disk; rows: the
    same speeds without their sections; order: the indices in `rows` of the speeds that
    the sweep will list (one that was watched takes the place of another, which stays in `rows` for
    its cost); ways: for each of these, what `Sweep.ways` says.
    """

    def __init__(self, work: Work, on_speed: Callable[[Speed], None], patient: bool):
        """patient: motions that look aperiodic are followed on, see `_watch_ends`."""
        self.work = work
        self.on_speed = on_speed
        self.patient = patient
        self.parts: list[Sequence[Speed]] = []
        self.rows = SpeedColumns()
        self.order: list[int] = []
        self.ways: list[tuple[str | int, ...]] = []

    def fixed(self, task: _Task, values: Sequence[float], adaptive: bool) -> list[_Row]:
        """A row for each value, all from the same start; adaptive: with values added between."""
        own = self._added(self.work.collect(task, values, CODEC, self._count), task.start)
        while True:
            if self.patient:
                _watch_ends(self.work, task, own, self.parts, self.rows)
            more = _between([self.rows[row.at] for row in own]) if adaptive else []
            if not more:
                return own
            own += self._added(self.work.collect(task, more, CODEC, self._count), task.start)

    def carried(self, task: _Task, values: Sequence[float]) -> list[_Row]:
        """A row for each value in this order, each started from where the one before ends."""
        chain = self.work.collect_chain(task.after, None, values, CODEC, self._count)
        own = self._added(chain, task.start)
        for before, row in pairwise(own):
            row.start = self.rows[before.at].end
        if self.patient:
            _watch_ends(self.work, task, own, self.parts, self.rows)
        return own

    def enlist(self, own: Sequence[_Row], way: tuple[str | int, ...]) -> None:
        """Let the sweep list these rows, in this order."""
        self.order += [row.at for row in own]
        self.ways += [way] * len(own)

    def sort_by_value(self) -> None:
        """Put the listed rows in ascending order of their values; equal ones stay in order."""
        ranked = sorted(range(len(self.order)), key=lambda k: self.rows.value(self.order[k]))
        self.order = [self.order[k] for k in ranked]
        self.ways = [self.ways[k] for k in ranked]

    def _count(self, speed: Speed) -> None:
        """Take in a speed that has just been computed."""
        self.rows.append(speed)
        self.on_speed(speed)

    def _added(self, speeds: Sequence[Speed], start: Start | None) -> list[_Row]:
        """The rows of speeds that are the last of `rows`; the speeds become another part."""
        self.parts.append(speeds)
        count = len(self.rows)
        return [_Row(k, start) for k in range(count - len(speeds), count)]


def _watch_ends(
    work: Work, task: _Task, own: list[_Row], parts: list[Sequence[Speed]], rows: SpeedColumns
) -> None:
    """Follow what looks aperiodic on at the ends of each range, inwards until two in a row stay.

    own: the rows of one sweep; a row that was watched takes the place of the one before.
    """
    ends = _Ends(replace(task, patient=True))
    ranges = _ranges_of_chaos(sorted(own, key=lambda row: rows.value(row.at)), rows)
    while True:
        todo: list[_Row] = []
        unfinished = []
        for members in ranges:
            unwatched = _unwatched(members, rows)
            if unwatched:
                todo += unwatched
                unfinished.append(members)
        if not todo:
            return
        ranges = unfinished
        todo.sort(key=lambda row: rows.value(row.at))
        pieces = [(rows.value(row.at), row.start) for row in todo]
        first = len(rows)
        parts.append(work.collect(ends, pieces, OF_ENDS, rows.append))
        for k, row in enumerate(todo):
            row.at = first + k
            row.watched = True


def _ranges_of_chaos(ranked: Sequence[_Row], rows: SpeedColumns) -> list[list[_Row]]:
    """The rows of each range of motions that look aperiodic, or came to a rest among such.

    Chaos that may come to a rest does so at some speeds within the record and at others later, by
    chance: a row that rested is no end of the range that it stands in. A row that was watched stays
    in its range whatever it turned out to be, so that the ranges stay as they are.
    """

    def in_chaos(row: _Row) -> bool:
        return row.watched or rows.in_chaos(row.at)

    return [list(members) for chaos, members in groupby(ranked, in_chaos) if chaos]


def _unwatched(members: Sequence[_Row], rows: SpeedColumns) -> list[_Row]:
    """The rows of a range to be watched next, from both ends inwards, see `_watch_ends`."""
    found: dict[int, _Row] = {}
    for way in (members, reversed(members)):
        stay = 0  # in a row, or still to be seen
        for row in way:
            if stay == SURE:
                break
            aperiodic = rows.labels[row.at] == APERIODIC
            if not row.watched and aperiodic:
                found[row.at] = row
            if row.watched or aperiodic:
                stay = stay + 1 if aperiodic else 0
    return list(found.values())


class _Joined(Sequence[Speed]):
    """Sequences that may come from a disk as one, in another order."""

    def __init__(self, parts: Sequence[Sequence[Speed]], order: Sequence[int]):
        self.parts = parts
        self._order = array("q", order)
        self._ends = list(accumulate(map(len, parts)))

    def __len__(self) -> int:
        return len(self._order)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(len(self)))]
        part, own = self.place(k)
        return part[own]

    def place(self, k: int) -> tuple[Sequence[Speed], int]:
        """The sequence that holds number k, and its number there."""
        at = self._order[k]
        n = bisect_right(self._ends, at)
        return self.parts[n], at - (self._ends[n - 1] if n else 0)


def _sections_of(speeds: Sequence[Speed], k: int, names: Sequence[str]) -> list[tuple]:
    """Sections of a speed; where it is on disk it is read once, and nothing else of it is made."""
    while isinstance(speeds, _Joined):
        speeds, k = speeds.place(k)
    if isinstance(speeds, Kept) and k not in speeds.unkept:
        return speeds.part(k, lambda stored: [_load_section(name, stored) for name in names])
    speed = speeds[k]
    return [getattr(speed, name) for name in names]


def _between(speeds: Sequence[Speed]) -> list[float]:
    """The middles between neighbours that differ and are further apart than FINEST.

    Neighbours differ in their labels, or are both aperiodic and differ in the size of the motion:
    the largest gap or the hardest impact, each as a share of its range over all speeds.
    """
    rows = sorted(speeds, key=lambda s: s.value)
    if len(rows) < 2:
        return []
    least = (rows[-1].value - rows[0].value) / FINEST
    sizes = []
    for name in ("max_gap_m", "max_impact_m_per_s"):
        column = [getattr(speed.loads, name) or 0.0 for speed in rows]
        width = (max(column) - min(column)) or 1.0
        sizes.append([x / width for x in column])
    middles = []
    for k, (before, after) in enumerate(pairwise(rows)):
        if after.value - before.value <= least:
            continue
        if Status.FAULT in (before.status, after.status):
            continue  # nothing is known of the motion there
        differs = before.label != after.label
        if before.label == after.label == APERIODIC:
            differs = any(abs(size[k + 1] - size[k]) > CHANGED for size in sizes)
        if differs:
            middles.append(0.5 * (before.value + after.value))
    return middles


def sweep_map(
    keys: tuple[str, str],
    first: Sequence[float],
    second: Sequence[float],
    setup: Callable[[float, float], Setup],
    *,
    direction: str = FIXED,
    lyapunov: bool = False,
    decide: bool = False,
    work: Work | None = None,
    on_line: Callable[[Sequence[Speed]], None] = lambda line: None,
) -> Map:
    """The motion at every pair of values; `up` and `down` carry the state along the first number.

    A motion that a sweep follows beyond doubles is undecided here unless `decide`: that takes a
    tenth of a second and more for each.

    A line of one second value is a piece of `work`: kept, shared and run like the speeds of
    `sweep`. Raises StartError before any work if the first start lies below the cam.
    """
    refuse_below(setup, (first[0], second[0]))
    found = attempt("", lambda: setup(first[0], second[0])[2])
    runs = 0 if isinstance(found, PieceFault) else found.transient + found.record
    turns = len(first) * len(second) * runs
    ordered = list(first) if direction == FIXED else sorted(first, reverse=direction == DOWN)
    task = _Line(keys, setup, ordered, direction != FIXED, lyapunov, turns, runs, decide)
    cost = Cost()

    def count(line: Sequence[Speed]) -> None:
        nonlocal cost
        cost = sum((speed.cost for speed in line), cost)
        on_line(line)

    lines = (work or Work()).collect(task, second, _lines_over(ordered), count)
    return Map(keys, ordered, second, lines, direction, cost)


@dataclass(frozen=True)
class _Line:
    """The speeds of a map at one value of its second number."""

    keys: tuple[str, str]
    setup: Callable[[float, float], Setup]
    first: Sequence[float]
    carry: bool
    lyapunov: bool
    turns: float  # of the whole map
    turns_each: float  # of a point
    decide: bool

    def __call__(self, second: float) -> list[Speed]:
        """The results at all first numbers, in order, where the second number has this value."""
        machines = lambda x: self.setup(x, second)  # noqa: E731
        key = f"{self.keys[1]} = {second!r}, {self.keys[0]}"
        each = self.turns_each
        task = _Task(
            key, machines, False, False, self.lyapunov, self.turns, each, self.decide,
            keeps_ends=True,  # the page of `explore` shows motions of a map from there
        )  # fmt: skip
        found: list[Speed] = []
        if self.carry:
            for x in self.first:
                found.append(task.after(found[-1] if found else None, x))
            return found
        count = task.at_once
        for k in range(0, len(self.first), count):
            found += task.many(self.first[k : k + count])
        return found


@dataclass(frozen=True)
class _Ends:
    """One speed at the end of a chaotic range; a piece is its value and its start."""

    task: _Task

    def __call__(self, piece: tuple[float, Start | None]) -> Speed:
        return self.task._at(*piece)


@dataclass(frozen=True)
class _Task:
    """One speed, wherever it is computed; key: of what is varied."""

    key: str
    setup: Callable[[float], Setup]
    impacts: bool
    strobe: bool
    lyapunov: bool
    turns: float  # of all speeds
    turns_each: float  # of one
    follow: bool = True  # beyond doubles, where a rest makes the record one of many
    start: Start | None = None  # another than the scene's
    patient: bool = False  # follow what looks aperiodic on, as `classify` does
    keeps_ends: bool = False  # where each motion ends is kept: the next speed may start there

    def __call__(self, value: float) -> Speed:
        """The speed, from its start."""
        return self._at(value, self.start)

    def after(self, before: Speed | None, value: float) -> Speed:
        """The speed, from where the one before ended."""
        return self._at(value, self.start if before is None else before.end)

    @property
    def at_once(self) -> int:
        """How many speeds `many` should be given: few turns in all, for an interrupt waits so long.

        Plain Python switches to the compiled kernel in the middle of an orbit, so it takes one.
        """
        backend.for_work(self.turns)
        if not backend.current().compiled:
            return 1
        return max(1, min(MOST_AT_ONCE, int(AT_ONCE / max(1.0, self.turns_each))))

    def many(self, values: Sequence[float]) -> list[Speed]:
        """The speeds at several values, each as if it were alone, in fewer calls of the kernel."""
        if len(values) == 1:
            return [self(values[0])]
        begun = [self._begun(value, self.start) for value in values]
        done = attempt("", lambda: _run([x for x in begun if isinstance(x, _Begun)]))
        if isinstance(done, PieceFault):  # one of them is guilty
            return [self(value) for value in values]
        found = []
        own = iter(done)
        for value, one in zip(values, begun, strict=True):
            found.append(self._ended(value, one, *next(own)) if isinstance(one, _Begun) else one)
        return found

    def _at(self, value: float, start: Start | None) -> Speed:
        """The motion that one speed ends on; a fault is kept in the result and not raised."""
        one = self._begun(value, start)
        if not isinstance(one, _Begun):
            return one
        record = attempt(one.name, lambda: run_all([one.orbit], loads=True)[0])
        if isinstance(record, PieceFault):
            return self._failed(value, one.rpm, record)
        return self._ended(value, one, record)

    def _begun(self, value: float, start: Start | None) -> _Begun | Speed:
        """The orbit of a speed, ready to run; a speed with its fault where it cannot be made."""
        name = f"{self.key} = {value!r}"
        name += f" from {start.place}" if start is not None and start == self.start else ""
        machine = attempt(name, lambda: self.setup(value))
        if isinstance(machine, PieceFault):
            return self._failed(value, nan, machine)
        system, rpm, settings = machine
        orbit = attempt(name, lambda: Orbit(system, rpm, settings, start))
        if isinstance(orbit, PieceFault):
            return self._failed(value, rpm, orbit)
        return _Begun(name, system, rpm, settings, start, orbit)

    def _ended(
        self, value: float, one: _Begun, record: Record, longer: Record | None = None
    ) -> Speed:
        """Name and measure an orbit that has run; longer: its longer record, see `named_on`."""
        found = attempt(one.name, lambda: self._measured(value, one, record, longer))
        return self._failed(value, one.rpm, found) if isinstance(found, PieceFault) else found

    def _failed(self, value: float, rpm: float, fault: PieceFault) -> Speed:
        """A speed of which nothing is known."""
        nothing = np.empty(0)
        none = np.empty(0, int)
        impacts = (none, nothing, nothing, nothing) if self.impacts else None
        strobe = (range(0), nothing, nothing, none, none) if self.strobe else None
        status = Status.FAULT
        return Speed(value, rpm, UNDECIDED, None, status, impacts, strobe, Cost(), fault=fault)

    def _measured(self, value: float, one: _Begun, record: Record, longer: Record | None) -> Speed:
        """Name what a speed ends on.

        Where rounding decides the record after a rest, the true motion is followed if `follow` asks
        for it, else the speed counts as not known. An aperiodic record is followed on if `patient`.
        """
        system = one.system
        rpm = one.rpm
        orbit = one.orbit
        end = None
        cost = record.cost
        n = record.periods
        to_mps = orbit.omega
        status = record.status
        known = True
        holds_for = watched = None
        name = UNDECIDED
        exponents = None
        forgets = forgets_too_much(record)
        if not forgets:
            name, exponents, told = named_on(orbit, rpm, record, self.lyapunov, longer)
            forgets = forgets_too_much(told)
        if forgets and not self.follow:
            name = UNDECIDED
            exponents = None
            known = False
        elif forgets or (self.patient and name == APERIODIC):
            motion, record, end = true_motion(orbit, rpm, one.settings, one.start, record)
            name = motion.label
            exponents = motion.exponents
            known = name != UNDECIDED
            cost = cost + motion.cost
            holds_for = motion.holds_for
            watched = motion.watched
            if status == Status.OK:
                status = Status(motion.status)
        elif name == APERIODIC:
            watched = one.settings.transient + n
        if not self.keeps_ends or status != Status.OK:
            end = None
        elif end is None:
            end = orbit.as_start()
        strobe = None
        if self.strobe:
            q, v = record.strobe_q[:n], record.strobe_w[:n] * to_mps
            strobe = (range(n), q, v, record.impacts[:n], record.chatter[:n])
        return Speed(
            value=value,
            rpm=rpm,
            label=name,
            impact_count=record.hits,
            status=status,
            impacts=_impact_rows(record, to_mps) if self.impacts else None,
            strobe=strobe,
            cost=cost,
            exponent=exponents.largest if self.lyapunov and exponents else None,
            exponent_error=exponents.spread if self.lyapunov and exponents else None,
            end=end,
            loads=loads_of(system, rpm, record) if known else NOTHING,
            known=known,
            holds_for=holds_for,
            watched=watched,
        )


class _Begun(NamedTuple):
    """An orbit at its start; name: of the piece that it is."""

    name: str
    system: System
    rpm: float
    settings: Settings
    start: Start | None
    orbit: Orbit


def _run(begun: Sequence[_Begun]) -> list[tuple[Record, Record | None]]:
    """The records of orbits, and the turns after those that are too short to name anything."""
    records = _together([one.orbit for one in begun], loads=True)
    short = [k for k, record in enumerate(records) if names_nothing(record)]
    longer: dict[int, Record] = {}
    if short:
        after = _together([turns_after(begun[k].orbit) for k in short], loads=False)
        longer = dict(zip(short, after, strict=True))
    return [(record, longer.get(k)) for k, record in enumerate(records)]


def _together(orbits: Sequence[Orbit], loads: bool) -> list[Record]:
    """The records of orbits; orbits on one cam are computed in one call of the kernel."""
    records: list[Record] = []
    for _, members in groupby(orbits, lambda orbit: id(orbit.system.cam)):
        records += run_all(list(members), loads=loads)
    return records


def true_motion(
    run: Orbit, rpm: float, settings: Settings, start: Start | None, record: Record
) -> tuple[ClassifiedMotion, Record, Start]:
    """(the motion as `classify` names it, a record that shows it, the state at that record's end).

    run, record: the plain run of doubles, at its end, and its record. The record is given back
    where the motion has no orbit, or where each turn of the record is a turn of that orbit.
    Otherwise doubles ended elsewhere: between two rests an error of rounding may grow beyond all
    digits, so that theirs is one of many motions, or the record was over before the motion had
    settled. Then the record returned consists of as many turns computed from the states of the
    orbit.
    """
    system = run.system
    motion = classify_at(system, rpm, settings, start, begun=(run, record))
    orbit = motion.orbit
    if orbit is None or _shows(record, orbit):
        return motion, record, run.as_start()
    starts = [start_at(system, rpm, state) for state in orbit.states]
    one_turn = with_turns(settings, 0, 1)
    turns = run_all([Orbit(system, rpm, one_turn, one) for one in starts])
    n = record.periods
    return motion, _joined([turns[k % orbit.turns] for k in range(n)]), starts[n % orbit.turns]


def _shows(record: Record, orbit: PeriodicOrbit) -> bool:
    """True where every turn of a record is a turn of the orbit.

    A turn of the record is one of the orbit if it begins at one of the orbit's states, within SAME,
    and has as many impacts as the orbit has from that state. The order of the turns need not be
    compared: the same map leads from each to the next.
    """
    states, symbols = sections(record)
    own = np.array(orbit.states)
    size = size_of(orbit.states)
    near = np.array([distances(states, state, size) <= SAME for state in own])
    if not near.any(axis=0).all():
        return False
    first = near.argmax(axis=0).tolist()
    return all(orbit.symbols[k] == symbol for k, symbol in zip(first, symbols, strict=True))


def start_at(system: System, rpm: float, state: Sequence[float]) -> Start:
    """A state (m, m/rad) at the strobe as a start; None values where it rests on the cam."""
    c, c1, _ = lift_at(system.cam, system.cam.strobe, system.strobe)
    q, w = state
    if abs(q - c) <= ON_CAM * abs(c) and abs(w - c1) <= ON_CAM * (abs(c1) + abs(c)):
        return Start.at_strobe(system, rpm, None)
    return Start.at_strobe(system, rpm, state)


def _joined(turns: Sequence[Record]) -> Record:
    """The whole turns of records one after the other, each of one turn."""
    logged = [turn.period == 0 for turn in turns]
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(t, name)[own] for t, own in zip(turns, logged, strict=True)])
        for name in ("kind", "theta", "q", "u")
    }
    columns["period"] = np.repeat(np.arange(len(turns)), [own.sum() for own in logged])
    for name in ("strobe_q", "strobe_w", "impacts", "chatter"):
        columns[name] = np.array([getattr(turn, name)[0] for turn in turns])
    sums: dict[str, Any] = {
        "hits": sum(turn.hits for turn in turns),
        "chatters": sum(t.chatters for t in turns),
    }
    unknown: dict[str, Any] = {"repeats": 0, "near": False, "loads": None}
    return turns[-1]._replace(**columns, **sums, **unknown, periods=len(turns))


def _store(speed: Speed) -> dict[str, Any]:
    """What a file keeps of a speed without a fault."""
    values = speed._asdict()
    del values["fault"]
    return values | {
        "label": to_plain(speed.label),
        "strobe": speed.strobe and speed.strobe[1:],
        "cost": speed.cost._asdict(),
        "end": speed.end and vars(speed.end),
    }


LOAD = stored.optional(stored.real)
START = {"q": LOAD, "v": LOAD, "theta": stored.real, "place": stored.text}
CHECKS: dict[str, Callable[[Any], Any]] = {  # of what `_store` makes of a speed
    "value": stored.real,
    "rpm": stored.real,
    "label": from_plain,
    "impact_count": stored.whole,
    "status": stored.one_of(*map(int, Status)),
    "impacts": stored.optional(stored.columns(4)),
    "strobe": stored.optional(stored.columns(4)),
    "cost": lambda value: Cost(**stored.fields(value, dict.fromkeys(Cost._fields, stored.whole))),
    "exponent": stored.optional(stored.extended),
    "exponent_error": stored.optional(stored.extended),
    "end": stored.optional(lambda value: Start(**stored.fields(value, START))),
    "loads": lambda value: Loads(*stored.items(LOAD, len(Loads._fields))(value)),
    "known": stored.flag,
    "holds_for": stored.optional(stored.one_of(*map(str, HoldsFor))),
    "watched": stored.optional(stored.whole),
}


def _load(value: Any) -> Speed:
    found = stored.fields(value, CHECKS)
    return Speed(**{**found, "strobe": _numbered(found["strobe"])})


def _load_section(name: str, value: Any) -> Any:
    columns = CHECKS[name](value[name])
    return _numbered(columns) if name == "strobe" else columns


def _numbered(strobe: tuple | None) -> tuple | None:
    """The columns of a strobe section with the periods before them, which are not kept."""
    return strobe and (range(len(strobe[0])), *strobe)


def _load_line(value: Any) -> list[Speed]:
    return stored.items(_load)(value)


def _faults(speeds: Sequence[Speed]) -> list[PieceFault]:
    return [speed.fault for speed in speeds if speed.fault is not None]


CODEC = Codec(
    _store, _load, lambda speed, value: speed.value == value, lambda speed: _faults([speed])
)

OF_ENDS = CODEC._replace(fits=lambda speed, piece: speed.value == piece[0])


def _lines_over(first: Sequence[float]) -> Codec:
    """Lines of a map over these values of its first number."""
    return Codec(
        lambda line: [_store(speed) for speed in line],
        _load_line,
        lambda line, _: [speed.value for speed in line] == list(first),
        _faults,
    )


def _impact_rows(record, omega: float) -> tuple:
    """(period, theta_deg, q_m, u_minus_m_per_s) of the impacts of whole recorded periods."""
    if record.hits == len(record.kind):  # nothing else was logged
        angles = np.degrees(record.theta)
        return record.period.copy(), angles, record.q.copy(), record.u * omega
    keep = (record.kind == IMPACT) & (record.period >= 0)
    return (
        record.period[keep],
        np.degrees(record.theta[keep]),
        record.q[keep],
        record.u[keep] * omega,
    )


def status_name(status: int) -> str:
    """The status as it stands in a CSV."""
    return Status(status).text
