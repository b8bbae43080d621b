"""One run of `cam bench`: what was asked, how long each part may take, what has been found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from camcli.analysis.bench import precision, scenes, stability
from camcli.analysis.bench.budget import FLIGHTS, POINTS, ROWS, SCENES, flying, seconds_of
from camcli.analysis.bench.clock import Schedule
from camcli.analysis.bench.flights import MOST_OF_PEERS
from camcli.analysis.integrate import Cost
from camcli.cli.long_run import Desk
from camcli.cli.options import Request
from camcli.cli.progress import bar
from camcli.output.run_folder import Store
from camcli.parallel import Work
from camcli.scene.bench import Bench

QUICK_FLIGHTS = 100
PIECES = {"precision": (POINTS, FLIGHTS), "stability": (ROWS,), "scenes": (SCENES,)}


@dataclass(frozen=True)
class Plan:
    """What was asked: the section of the scene, the parts, and whether flights were asked for."""

    section: Bench
    parts: tuple[str, ...]
    flights_named: bool = False

    @property
    def quick(self) -> bool:
        """Whether a subset is wanted."""
        return self.section.quick

    @property
    def repeats(self) -> int:
        """Timings of a point."""
        return 1 if self.quick else self.section.repeats

    @property
    def flights(self) -> int:
        """Random flights to compare: fewer where it is quick, unless so many were asked for."""
        wanted = self.section.flights
        return wanted if self.flights_named or not self.quick else min(wanted, QUICK_FLIGHTS)

    @property
    def seconds(self) -> dict[str, float]:
        """Seconds of each part at the most; inf for more flights than usual."""
        names = tuple(name for part in self.parts for name in PIECES[part])
        seconds = seconds_of(names, self.quick)
        if self.flights > Bench.model_fields["flights"].default and FLIGHTS in seconds:
            seconds[FLIGHTS] = inf
        return seconds

    def work(self) -> list[precision.Task]:
        """The points."""
        section = self.section
        return precision.plan(section.cases, section.methods, self.quick, self.repeats)

    def table(self) -> dict[str, dict[str, float]]:
        """What each part would do: runs, and seconds at the most (flights asked for: about)."""
        runs = {
            POINTS: len(self.work()),
            FLIGHTS: self.flights,
            ROWS: len(stability.numbers()),
            SCENES: sum(task.repeats for task in scenes.plan(self.repeats, self.quick)),
        }
        about = flying(self.flights, MOST_OF_PEERS)
        return {
            name: {"runs": runs[name], "seconds": about if most == inf else most}
            for name, most in self.seconds.items()
        }


@dataclass
class Run:
    """One run of the bench, and what has been found so far."""

    request: Request
    plan: Plan
    desk: Desk
    schedule: Schedule
    result: dict[str, Any] = field(default_factory=dict)
    trouble: list[str] = field(default_factory=list)  # a line per failure
    done: list[str] = field(default_factory=list)  # what was measured, in words
    cost: Cost = field(default_factory=Cost)  # of ours, one run of each point

    @property
    def store(self) -> Store:
        """Where the artefacts go."""
        return self.desk.store

    def keeping(self, part: str) -> Work:
        """Runs the pieces of a part one by one, and keeps them."""
        return replace(self.desk.work.within(part), threads=1)

    @contextmanager
    def bar(self, title: str, total: int) -> Iterator[Callable[[], None]]:
        """A progress bar, unless --quiet; yields what is called after each piece."""
        if self.request.quiet:
            yield _nothing
            return
        with bar(title, total) as tick:
            yield tick or _nothing

    def count(self, found: Sequence[precision.Measured]) -> None:
        """Add the cost of our points."""
        for point in found:
            if point.ours:
                self.cost += Cost(point.impacts, point.evaluations)


def _nothing() -> None:
    """No progress is shown."""
