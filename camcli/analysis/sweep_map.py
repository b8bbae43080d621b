"""The kind of motion at each point of a map over two numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from camcli.analysis.integrate import Cost, Setup, refuse_below
from camcli.analysis.motion_at_speed import SpeedTask
from camcli.analysis.speeds import Speed
from camcli.analysis.stored_speeds import faults_of, of_lines
from camcli.analysis.sweep import DOWN, FIXED
from camcli.parallel import Work
from camcli.piece_faults import PieceFault, attempt


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
        return [fault for line in self.lines for fault in faults_of(line)]


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
    settings = attempt("", lambda: setup(first[0], second[0])[2])
    turns_each = 0
    if not isinstance(settings, PieceFault):
        turns_each = settings.transient + settings.record
    ordered = list(first) if direction == FIXED else sorted(first, reverse=direction == DOWN)
    task = _LineTask(
        keys=keys,
        setup=setup,
        first=ordered,
        carry=direction != FIXED,
        lyapunov=lyapunov,
        turns=len(first) * len(second) * turns_each,
        turns_each=turns_each,
        decide=decide,
    )
    cost = Cost()

    def count(line: Sequence[Speed]) -> None:
        nonlocal cost
        cost = sum((speed.cost for speed in line), cost)
        on_line(line)

    lines = (work or Work()).collect(task, second, of_lines(ordered), count)
    return Map(keys, ordered, second, lines, direction, cost)


@dataclass(frozen=True)
class _LineTask:
    """The work on a line of a map: all values of the first number at one of the second.

    carry: each point starts where the one before it ends; turns: of the whole map; turns_each: of
    a point; decide: as of `sweep_map`.
    """

    keys: tuple[str, str]
    setup: Callable[[float, float], Setup]
    first: Sequence[float]
    carry: bool
    lyapunov: bool
    turns: float
    turns_each: float
    decide: bool

    def __call__(self, second: float) -> list[Speed]:
        """The results at all first numbers, in order, where the second number has this value."""
        task = SpeedTask(
            key=f"{self.keys[1]} = {second!r}, {self.keys[0]}",
            setup=lambda value: self.setup(value, second),
            impacts=False,
            strobe=False,
            lyapunov=self.lyapunov,
            turns=self.turns,
            turns_each=self.turns_each,
            follow=self.decide,
            keeps_ends=True,  # the page of `explore` shows motions of a map from there
        )
        speeds: list[Speed] = []
        if self.carry:
            for value in self.first:
                speeds.append(task.after(speeds[-1] if speeds else None, value))
            return speeds
        count = task.at_once
        for begin in range(0, len(self.first), count):
            speeds += task.many(self.first[begin : begin + count])
        return speeds
