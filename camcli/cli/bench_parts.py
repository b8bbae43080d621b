"""The three parts of `cam bench`: each measures, writes its artefacts and says what failed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from typing import Any

from camcli.analysis.bench import methods, precision, scenes, stability
from camcli.analysis.bench.cases import case
from camcli.analysis.bench.flights import flights
from camcli.analysis.bench.row import OK
from camcli.artefacts.bench import flights_csv, precision_csv, scenes_csv, stability_csv
from camcli.artefacts.store import Store
from camcli.cli import bench_words as words
from camcli.cli.bench_runs import bench_of
from camcli.cli.options import Request
from camcli.cli.panel import note
from camcli.cli.progress import bar
from camcli.cli.setup import Setup
from camcli.scene.bench import Bench

QUICK_FLIGHTS = 100
STEPS_OF_FLIGHTS = 100  # of the progress bar


@dataclass
class Run:
    """One run of the bench: what was asked, and what has been found so far."""

    request: Request
    setup: Setup
    store: Store
    result: dict[str, Any] = field(default_factory=dict)
    trouble: list[str] = field(default_factory=list)  # a line per failure
    impacts: int = 0

    def bar(self, title: str, total: int):
        """A progress bar, unless --quiet."""
        return nullcontext() if self.request.quiet else bar(title, total)

    @property
    def quick(self) -> bool:
        """Whether a subset is wanted."""
        return self.setup.scene.bench.quick

    @property
    def repeats(self) -> int:
        """Timings of a point."""
        return 1 if self.quick else self.setup.scene.bench.repeats

    @property
    def flights(self) -> int:
        """Random flights to compare."""
        wanted = self.setup.scene.bench.flights
        named = self.request.extra["flights"] is not None
        return min(wanted, QUICK_FLIGHTS) if self.quick and not named else wanted


def run_stability(here: Run) -> None:
    """The table of extreme cases."""
    rows = stability.ROWS
    with here.bar("extreme cases", len(rows)) as tick:
        outcomes = list(stability.stability(bench_of(), rows, tick or (lambda: None)))
    here.store.write_text("stability.csv", stability_csv(outcomes))
    if here.request.no_plot:
        here.store.remove("stability.png")
    else:
        from camcli.artefacts.figures.bench_stability import draw_stability

        here.store.write("stability.png", lambda file: draw_stability(outcomes, file))
    here.trouble += words.stability_faults(outcomes)
    failed = [o.case for o in outcomes if o.status != OK]
    here.result["stability"] = {"rows": len(outcomes), "failed": failed}
    if not here.request.json:
        words.show_stability(outcomes)


def run_precision(here: Run) -> None:
    """Work and precision of all methods on all cases, and the random flights."""
    section, bench = here.setup.scene.bench, bench_of()
    work = precision.plan(section.cases, section.methods, here.quick, bench)
    with here.bar("points", len(work)) as tick:
        found = list(precision.precision(work, here.repeats, here.quick, tick or (lambda: None)))
    flown = _flights(here) if here.flights else []
    here.impacts += sum(m.impacts for m in found if m.ours)
    here.store.write_text("precision.csv", precision_csv(found))
    here.store.write_text("flights.csv", flights_csv(flown))
    if here.request.no_plot:
        here.store.remove("precision.png")
    else:
        from camcli.artefacts.figures.bench_precision import draw_precision

        titles = {name: case(name).title for name in section.cases}
        here.store.write("precision.png", lambda file: draw_precision(found, titles, file))
    here.trouble += words.precision_faults(found, flown)
    here.result["precision"] = words.precision_summary(found, flown)
    if not here.request.json:
        words.show_precision(found, flown)
    absent = any(m.status == precision.ABSENT for m in found)
    if absent and not here.request.quiet:
        note("heyoka is not installed, its points are left out: pip install 'camcli[bench]'")


def _flights(here: Run):
    count, done = here.flights, 0
    with here.bar("flights", STEPS_OF_FLIGHTS) as tick:

        def on_flight() -> None:
            nonlocal done
            done += 1
            if tick and done * STEPS_OF_FLIGHTS % count < STEPS_OF_FLIGHTS:
                tick()

        return flights(bench_of(), count, on_flight=on_flight)


def run_scenes(here: Run) -> None:
    """Time and modules of whole commands."""
    total = len(scenes.QUICK if here.quick else scenes.SCENES)
    with here.bar("scenes", total) as tick:
        found = list(scenes.scenes(here.repeats, here.quick, tick or (lambda: None)))
    here.store.write_text("scenes.csv", scenes_csv(found))
    here.trouble += words.scenes_faults(found)
    here.result["scenes"] = words.scenes_summary(found)
    if not here.request.json:
        words.show_scenes(found)


def planned(section: Bench, parts: Sequence[str]) -> dict[str, dict[str, float]]:
    """What each part would do: points or rows or commands, and seconds at the most."""
    repeats = 1 if section.quick else section.repeats
    wanted = methods.points(tuple(section.methods), section.quick, bench_of())
    points = len(wanted) * len(section.cases)
    allowed = precision.QUICK_ALLOWED if section.quick else precision.ALLOWED
    commands = len(scenes.QUICK if section.quick else scenes.SCENES)
    rows = len(stability.ROWS)
    table = {
        "precision": {"runs": points, "seconds": 0.25 * allowed * points * (1 + 0.2 * repeats)},
        "stability": {"runs": rows, "seconds": 6.0},
        "scenes": {"runs": commands * repeats, "seconds": 1.5 * commands * repeats},
    }
    return {part: table[part] for part in parts}
