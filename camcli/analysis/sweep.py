"""Brute-force bifurcation diagram: one orbit per speed, impact and stroboscopic sections."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, groupby, pairwise
from typing import Any

from camcli.analysis.integrate import AtSpeeds, Cost, Settings, Setup, Start, refuse_below
from camcli.analysis.labels import APERIODIC
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


@dataclass(frozen=True)
class Sweep:
    """All speeds in the order they were run.

    key: of what is varied; also: further starts; bare: the speeds without their sections, which may
    be on disk; ways: what tells each speed from others of the same value, see `way_names`.
    """

    speeds: Sequence[Speed]
    direction: str
    cost: Cost
    key: str = "rpm"
    also: Sequence[Start] = ()
    bare: Sequence[Speed] = ()
    ways: Sequence[tuple[str | int, ...]] = ()

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
        for k, speed in enumerate(self.bare):
            yield speed.value, _sections_of(self.speeds, k, names)

    @property
    def troubled(self) -> list[Speed]:
        """Speeds whose status is not ok, without their sections."""
        return [speed for speed in self.bare if speed.status != Status.OK]

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
            values_were_added = values_were_added or len(listed) > len(values)
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
        ways=rows.ways,
    )


@dataclass(slots=True)
class _Row:
    """A row of a sweep while it is made.

    at: its number among `_SweepRows.bare`; start: where its motion began, None for the scene's;
    watched: whether it was followed on with patience.
    """

    at: int
    start: Start | None
    watched: bool = False


class _SweepRows:
    """The speeds of a sweep as they are computed.

    parts: all speeds in the order they were computed, in sequences that may be on disk; bare: the
    same speeds without their sections; order: the numbers of the speeds that the sweep will list
    (one that was watched takes the place of another, which stays in `bare` for its cost); ways: for
    each of these, what `Sweep.ways` says.
    """

    def __init__(self, work: Work, on_speed: Callable[[Speed], None], patient: bool):
        """patient: motions that look aperiodic are followed on, see `_watch_ends`."""
        self.work = work
        self.on_speed = on_speed
        self.patient = patient
        self.parts: list[Sequence[Speed]] = []
        self.bare = SpeedColumns()
        self.order: list[int] = []
        self.ways: list[tuple[str | int, ...]] = []

    def fixed(self, task: SpeedTask, values: Sequence[float], adaptive: bool) -> list[_Row]:
        """A row for each value, all from the same start; adaptive: with values added between."""
        rows = self._added(self.work.collect(task, values, OF_VALUES, self._count), task.start)
        while True:
            if self.patient:
                self._watch_ends(task, rows)
            more = _between([self.bare[row.at] for row in rows]) if adaptive else []
            if not more:
                return rows
            rows += self._added(self.work.collect(task, more, OF_VALUES, self._count), task.start)

    def carried(self, task: SpeedTask, values: Sequence[float]) -> list[_Row]:
        """A row for each value in this order, each started from where the one before ends."""
        chain = self.work.collect_chain(task.after, None, values, OF_VALUES, self._count)
        rows = self._added(chain, task.start)
        for before, row in pairwise(rows):
            row.start = self.bare[before.at].end
        if self.patient:
            self._watch_ends(task, rows)
        return rows

    def enlist(self, rows: Sequence[_Row], way: tuple[str | int, ...]) -> None:
        """Let the sweep list these rows, in this order."""
        self.order += [row.at for row in rows]
        self.ways += [way] * len(rows)

    def sort_by_value(self) -> None:
        """Put the listed rows in ascending order of their values; equal ones stay in order."""
        ranked = sorted(range(len(self.order)), key=lambda k: self.bare.value(self.order[k]))
        self.order = [self.order[k] for k in ranked]
        self.ways = [self.ways[k] for k in ranked]

    def _count(self, speed: Speed) -> None:
        """Take in a speed that has just been computed."""
        self.bare.append(speed)
        self.on_speed(speed)

    def _added(self, speeds: Sequence[Speed], start: Start | None) -> list[_Row]:
        """The rows of speeds that are the last of `bare`; the speeds become another part."""
        self.parts.append(speeds)
        count = len(self.bare)
        return [_Row(at, start) for at in range(count - len(speeds), count)]

    def _watch_ends(self, task: SpeedTask, rows: list[_Row]) -> None:
        """Follow motions that look aperiodic on, from both ends of each range of such inwards.

        Until SURE neighbours in a row stay aperiodic. rows: of one start and direction; one that
        was watched refers to the new speed from then on.
        """
        watching = _WatchedFrom(replace(task, patient=True))
        ranked = sorted(rows, key=lambda row: self.bare.value(row.at))
        ranges = _ranges_of_chaos(ranked, self.bare)
        while True:
            todo: list[_Row] = []
            unfinished = []
            for members in ranges:
                unwatched = _unwatched(members, self.bare)
                if unwatched:
                    todo += unwatched
                    unfinished.append(members)
            if not todo:
                return
            ranges = unfinished
            todo.sort(key=lambda row: self.bare.value(row.at))
            pieces = [(self.bare.value(row.at), row.start) for row in todo]
            first = len(self.bare)
            self.parts.append(self.work.collect(watching, pieces, OF_STARTS, self.bare.append))
            for at, row in enumerate(todo, first):
                row.at = at
                row.watched = True


@dataclass(frozen=True)
class _WatchedFrom:
    """The work of watching one motion; a piece of it is its value and its start."""

    task: SpeedTask

    def __call__(self, piece: tuple[float, Start | None]) -> Speed:
        value, start = piece
        return self.task.started_at(value, start)


def _ranges_of_chaos(ranked: Sequence[_Row], speeds: SpeedColumns) -> list[list[_Row]]:
    """The rows of each range of motions that look aperiodic, or came to a rest among such.

    ranked: in ascending order of their values. Chaos that may come to a rest does so at some speeds
    within the record and at others later, by chance: a row that rested is no end of the range that
    it stands in. A row that was watched stays in its range whatever it turned out to be, so that
    the ranges stay as they are.
    """

    def in_chaos(row: _Row) -> bool:
        return row.watched or speeds.in_chaos(row.at)

    return [list(members) for chaos, members in groupby(ranked, in_chaos) if chaos]


def _unwatched(members: Sequence[_Row], speeds: SpeedColumns) -> list[_Row]:
    """The rows of a range to be watched next, from both ends inwards, see `_SweepRows._watch_ends`.

    From each end up to the place where SURE neighbours stay aperiodic, if those that look so and
    were not watched yet stay so.
    """
    chosen: dict[int, _Row] = {}
    for from_one_end in (members, reversed(members)):
        in_a_row = 0  # aperiodic, or still to be watched
        for row in from_one_end:
            if in_a_row == SURE:
                break
            aperiodic = speeds.labels[row.at] == APERIODIC
            if not row.watched and aperiodic:
                chosen[row.at] = row
            if aperiodic:
                in_a_row += 1
            elif row.watched:
                in_a_row = 0
    return list(chosen.values())


class _Joined(Sequence[Speed]):
    """Sequences of speeds, which may be read from a disk, as one sequence in another order.

    order: of each speed its number when the parts are put one behind the other.
    """

    def __init__(self, parts: Sequence[Sequence[Speed]], order: Sequence[int]):
        self.parts = parts
        self._order = array("q", order)
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
        return speeds.part(k, lambda stored: [load_section(name, stored) for name in names])
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
