"""Brute-force bifurcation diagram: one orbit per speed, impact and stroboscopic sections."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate, groupby, pairwise
from typing import Any

import numpy as np

from camcli.analysis.integrate import AtSpeeds, Cost, Settings, Setup, Start, refuse_below
from camcli.analysis.labels import APERIODIC, UNDECIDED
from camcli.analysis.motion_at_speed import SpeedTask
from camcli.analysis.speeds import Speed, SpeedColumns
from camcli.analysis.stored_speeds import OF_STARTS, OF_VALUES, faults_of, load_section
from camcli.errors import Status
from camcli.parallel import Work
from camcli.parallel.work import Kept
from camcli.piece_faults import PieceFault
from camcli.system import System

FIXED, UP, DOWN, BOTH = "fixed", "up", "down", "both"
FINEST = 1200  # of the range: an adaptive sweep goes down to steps of one of so many parts
CHANGED = 0.1  # of the range of a load: more is a change of a chaotic motion
SURE = 2  # neighbours that stay aperiodic: a transient is not looked for beyond them
SECTIONS = ("impacts", "strobe")  # of a `Speed`
CHAOS_LOOK, APERIODIC_LOOK = 1, 2  # of a motion: it stands among chaos; it looks aperiodic itself


@dataclass(frozen=True)
class Sweep:
    """All speeds in the order they were run.

    key: of what is varied; also: further starts; bare: the speeds without their sections, which may
    be on disk; values: of what is varied, of each speed; ways: what tells each speed from others of
    the same value, see `way_names`; row_counts: how many rows each section has of each speed, by
    its name.
    """

    speeds: Sequence[Speed]
    direction: str
    cost: Cost
    key: str = "rpm"
    also: Sequence[Start] = ()
    bare: Sequence[Speed] = ()
    values: Sequence[float] = ()
    ways: Sequence[tuple[str | int, ...]] = ()
    row_counts: Mapping[str, Sequence[int]] = field(default_factory=dict)

    @property
    def way_names(self) -> tuple[str, ...]:
        """What each entry of `ways` consists of.

        The direction where the state is carried both ways, the number of the start where there are
        several; nothing where each value stands once.
        """
        names = ["direction"] if self.direction == BOTH else []
        if self.also:
            names.append("start")
        return tuple(names)

    def sections(self, names: Sequence[str]) -> Iterator[tuple[float, list[tuple]]]:
        """(value, columns of each section named) of each speed.

        names: of `impacts` and `strobe`, whichever were asked for.
        """
        for k, value in enumerate(self.values):
            yield value, _sections_of(self.speeds, k, names)

    @property
    def troubled(self) -> list[tuple[float, int]]:
        """(value, status) of each speed whose status is not ok."""
        return [(speed.value, speed.status) for speed in self.bare if speed.status != Status.OK]

    @property
    def faults(self) -> list[PieceFault]:
        """The faults that cost single speeds, see `Speed`."""
        return faults_of(self.bare)


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
    turns_each = settings.transient + settings.record
    task = SpeedTask(
        key=key,
        setup=setup or AtSpeeds(system, settings),
        impacts=impacts,
        strobe=strobe,
        lyapunov=lyapunov,
        turns=len(values) * turns_each,
        turns_each=turns_each,
        keeps_ends=direction != FIXED,
    )
    tasks = [task, *(replace(task, start=start) for start in also)]
    if values:
        for task in tasks:
            refuse_below(task.setup, (values[0],), task.start)
    rows = _SweepRows(work or Work(), on_speed, patient=settings.patience > 0)
    values_were_added = False
    for number, task in enumerate(tasks):
        start = (number,) if also else ()
        if direction == FIXED:
            listed = rows.fixed(task, values, adaptive)
            rows.enlist(listed, start)
            values_were_added = values_were_added or len(listed.at) > len(values)
        elif direction == BOTH:
            rows.enlist(rows.carried(task, sorted(values)), (UP, *start))
            rows.enlist(rows.carried(task, sorted(values, reverse=True)), (DOWN, *start))
        else:
            in_order = sorted(values, reverse=direction == DOWN)
            rows.enlist(rows.carried(task, in_order), start)
    if values_were_added:
        rows.sort_by_value()
    return Sweep(
        speeds=_Joined(rows.parts, rows.order),
        direction=direction,
        cost=rows.bare.cost,
        key=key,
        also=also,
        bare=rows.bare.chosen(rows.order),
        values=array("d", (rows.values[at] for at in rows.order)),
        ways=rows.ways,
        row_counts=rows.listed_counts(),
    )


@dataclass
class _Rows:
    """Rows of a sweep from one start, in one direction, while they are made.

    at: of each its number among `_SweepRows.bare`; watched: of each, whether it was followed on
    with patience. carried_from: where each starts from the end of the one before it, the number in
    `bare` of the first one as it was computed, None where each starts alike.
    """

    task: SpeedTask
    carried_from: int | None = None
    at: array = field(default_factory=lambda: array("q"))
    watched: bytearray = field(default_factory=bytearray)


class _SweepRows:
    """The speeds of a sweep as they are computed.

    parts: all speeds in the order they were computed, in sequences that may be on disk; bare: the
    same speeds without their sections; values: of what is varied, of each; looks: APERIODIC_LOOK,
    CHAOS_LOOK or 0 of each; counts: of the rows of each section, of each; order: the numbers of the
    speeds that the sweep will list (one that was watched takes the place of another, which stays in
    `bare` for its cost); ways: for each of these, what `Sweep.ways` says.
    """

    def __init__(self, work: Work, on_speed: Callable[[Speed], None], patient: bool):
        """patient: motions that look aperiodic are followed on, see `_watch_ends`."""
        self.work = work
        self.on_speed = on_speed
        self.patient = patient
        self.parts: list[Sequence[Speed]] = []
        self.bare = SpeedColumns(rows=work.rows)
        self.values = array("d")
        self.looks = bytearray()
        self.counts = {name: array("i") for name in SECTIONS}
        self.order = array("q")
        self.ways: list[tuple[str | int, ...]] = []

    def fixed(self, task: SpeedTask, values: Sequence[float], adaptive: bool) -> _Rows:
        """A row for each value, all from the same start; adaptive: with values added between."""
        rows = _Rows(task)
        more: Sequence[float] = values
        while more:
            self._extend(rows, self.work.collect(task, more, OF_VALUES, self._count))
            if self.patient:
                self._watch_ends(rows)
            more = _between([self.bare[at] for at in rows.at]) if adaptive else []
        return rows

    def carried(self, task: SpeedTask, values: Sequence[float]) -> _Rows:
        """A row for each value in this order, each started from where the one before ends."""
        rows = _Rows(task, carried_from=len(self.bare))
        in_order = array("d", values)
        chain = self.work.collect_chain(task.after, None, in_order, OF_VALUES, self._count)
        self._extend(rows, chain)
        if self.patient:
            self._watch_ends(rows)
        return rows

    def enlist(self, rows: _Rows, way: tuple[str | int, ...]) -> None:
        """Let the sweep list these rows, in this order."""
        self.order += rows.at
        self.ways += [way] * len(rows.at)

    def listed_counts(self) -> dict[str, Sequence[int]]:
        """How many rows each section has of each listed speed."""
        return {
            name: array("i", (counts[at] for at in self.order))
            for name, counts in self.counts.items()
        }

    def sort_by_value(self) -> None:
        """Put the listed rows in ascending order of their values; equal ones stay in order."""
        ranked = self._ranked(self.order)
        self.order = array("q", (self.order[k] for k in ranked))
        self.ways = [self.ways[k] for k in ranked]

    def _ranked(self, at: array) -> array:
        """The places in `at` in ascending order of the values there; equal ones stay in order."""
        values = np.frombuffer(self.values)[np.frombuffer(at, np.int64)]
        return array("q", np.argsort(values, kind="stable").tobytes())

    def _count(self, speed: Speed) -> None:
        """Take in a speed that has just been computed, and tell of it."""
        self._take(speed)
        self.on_speed(speed)

    def _take(self, speed: Speed) -> None:
        """Take in a speed that has just been computed."""
        self.bare.append(speed)
        self.values.append(speed.value)
        look = 0
        if speed.label == APERIODIC:
            look = APERIODIC_LOOK
        elif speed.label == UNDECIDED or speed.holds_for:
            look = CHAOS_LOOK
        self.looks.append(look)
        for name, counts in self.counts.items():
            section = getattr(speed, name)
            counts.append(0 if section is None else len(section[0]))

    def _extend(self, rows: _Rows, speeds: Sequence[Speed]) -> None:
        """Add a row for each of the last speeds of `bare`; they become another part."""
        self.parts.append(speeds)
        count = len(self.bare)
        rows.at.extend(range(count - len(speeds), count))
        rows.watched.extend(bytes(len(speeds)))

    def _start(self, rows: _Rows, row: int) -> Start | None:
        """Where the motion of a row that was not watched began; None for the scene's start."""
        if rows.carried_from is None or row == 0:
            return rows.task.start
        return self.bare[rows.carried_from + row - 1].end

    def _watch_ends(self, rows: _Rows) -> None:
        """Follow motions that look aperiodic on, from both ends of each range of such inwards.

        Until SURE neighbours in a row stay aperiodic. A row that was watched refers to the new
        speed from then on.
        """
        watching = _WatchedFrom(replace(rows.task, patient=True))
        ranked = self._ranked(rows.at)
        ranges = _ranges_of_chaos(rows, self.looks, ranked)
        while True:
            todo: list[int] = []  # rows
            unfinished = []
            for places in ranges:
                unwatched = _unwatched(rows, self.looks, ranked, places)
                if unwatched:
                    todo += unwatched
                    unfinished.append(places)
            if not todo:
                return
            ranges = unfinished
            todo.sort(key=lambda row: self.values[rows.at[row]])
            pieces = [(self.values[rows.at[row]], self._start(rows, row)) for row in todo]
            first = len(self.bare)
            self.parts.append(self.work.collect(watching, pieces, OF_STARTS, self._take))
            for at, row in enumerate(todo, first):
                rows.at[row] = at
                rows.watched[row] = True


@dataclass(frozen=True)
class _WatchedFrom:
    """The work of watching one motion; a piece of it is its value and its start."""

    task: SpeedTask

    def __call__(self, piece: tuple[float, Start | None]) -> Speed:
        value, start = piece
        return self.task.started_at(value, start)


def _ranges_of_chaos(rows: _Rows, looks: Sequence[int], ranked: Sequence[int]) -> list[range]:
    """Each range of motions that look aperiodic, or came to a rest among such.

    looks: see `_SweepRows`; ranked: the rows in ascending order of their values, and a range is one
    of places in it. Chaos that may come to a rest does so at some speeds within the record and at
    others later, by chance: a row that rested is no end of the range that it stands in. A row that
    was watched stays in its range whatever it turned out to be: the ranges stay as they are.
    """

    def in_chaos(place: int) -> bool:
        row = ranked[place]
        return bool(rows.watched[row] or looks[rows.at[row]])

    ranges = []
    end = 0
    for chaos, places in groupby(range(len(ranked)), in_chaos):
        begin = end
        end += sum(1 for _ in places)
        if chaos:
            ranges.append(range(begin, end))
    return ranges


def _unwatched(
    rows: _Rows, looks: Sequence[int], ranked: Sequence[int], places: range
) -> list[int]:
    """The rows of a range to be watched next, from both ends inwards, see `_SweepRows._watch_ends`.

    From each end up to the place where SURE neighbours stay aperiodic, if those that look so and
    were not watched yet stay so. looks, ranked, places: see `_ranges_of_chaos`.
    """
    chosen: dict[int, None] = {}  # a set in the order in which they were chosen
    for from_one_end in (places, reversed(places)):
        in_a_row = 0  # aperiodic, or still to be watched
        for place in from_one_end:
            if in_a_row == SURE:
                break
            row = ranked[place]
            aperiodic = looks[rows.at[row]] == APERIODIC_LOOK
            if not rows.watched[row] and aperiodic:
                chosen[row] = None
            if aperiodic:
                in_a_row += 1
            elif rows.watched[row]:
                in_a_row = 0
    return list(chosen)


class _Joined(Sequence[Speed]):
    """Sequences of speeds, which may be read from a disk, as one sequence in another order.

    order: of each speed its number when the parts are put one behind the other.
    """

    def __init__(self, parts: Sequence[Sequence[Speed]], order: Sequence[int]):
        self.parts = parts
        self._order = order
        self._ends = list(accumulate(map(len, parts)))  # how many speeds there are up to each part

    def __len__(self) -> int:
        return len(self._order)

    def __getitem__(self, k: Any) -> Any:
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(len(self)))]
        part, number = self.place(k)
        return part[number]

    def place(self, k: int) -> tuple[Sequence[Speed], int]:
        """The part that holds number k, and its number there."""
        number = self._order[k]
        part = bisect_right(self._ends, number)
        if part > 0:
            number -= self._ends[part - 1]
        return self.parts[part], number


def _sections_of(speeds: Sequence[Speed], k: int, names: Sequence[str]) -> list[tuple]:
    """Sections of a speed; where it is on disk it is read once, and nothing else of it is made."""
    while isinstance(speeds, _Joined):
        speeds, k = speeds.place(k)
    if isinstance(speeds, Kept) and k not in speeds.unkept:
        return speeds.part(k, lambda stored: [load_section(name, stored) for name in names], names)
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


def status_name(status: int) -> str:
    """The status as it stands in a CSV."""
    return Status(status).text
