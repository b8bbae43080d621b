"""The parts of `cam bench`: each measures, writes its artefacts and says what failed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from camcli.analysis.bench import flights, precision, scenes, stability
from camcli.analysis.bench.budget import FLIGHTS, POINTS, ROWS, SCENES
from camcli.analysis.bench.cases import case
from camcli.analysis.bench.clock import NOT_REACHED
from camcli.analysis.bench.row import OK
from camcli.cli import bench_words as words
from camcli.cli.bench_run import Run
from camcli.cli.bench_runs import bench_of
from camcli.cli.exit_codes import note
from camcli.output.bench import flights_csv, precision_csv, scenes_csv, stability_csv


def run_stability(here: Run) -> None:
    """The table of extreme cases."""
    rows = stability.numbers()
    with here.bar("extreme cases", len(rows)) as tick:
        outcomes = list(
            stability.stability(
                bench_of(), rows, here.schedule.clock(ROWS), tick, here.keeping(ROWS)
            )
        )
    here.store.write_text("stability.csv", stability_csv(outcomes))
    if here.request.no_plot:
        here.store.remove("stability.png")
    else:
        from camcli.output.pictures import write_png
        from camcli.plots.bench_stability import draw_stability

        here.store.write("stability.png", partial(write_png, draw_stability(outcomes)))
    here.done.append(f"{_reached(outcomes)} extreme cases")
    here.trouble += words.stability_faults(outcomes)
    failed = [o.case for o in outcomes if o.status != OK]
    here.result["stability"] = {"rows": len(outcomes), "failed": failed}
    if not here.request.json:
        words.show_stability(outcomes)


def run_precision(here: Run) -> None:
    """Work and precision of all methods on all cases, and the random flights."""
    work = here.plan.work()
    with here.bar("points", len(work)) as tick:
        found = list(
            precision.precision(
                work, bench_of(), here.schedule.clock(POINTS), tick, here.keeping(POINTS)
            )
        )
    flown = _flights(here) if here.plan.flights else []
    here.count(found)
    here.store.write_text("precision.csv", precision_csv(found))
    here.store.write_text("flights.csv", flights_csv(flown))
    if here.request.no_plot:
        here.store.remove("precision.png")
    else:
        from camcli.output.pictures import write_png
        from camcli.plots.bench_precision import draw_precision

        titles = {name: case(name).title for name in here.plan.section.cases}
        here.store.write("precision.png", partial(write_png, draw_precision(found, titles)))
    measured = sum(m.status not in (precision.ABSENT, NOT_REACHED) for m in found)
    here.done.append(f"{measured} of {len(found)} points")
    here.done += [f"{f.flights} random flights" for f in flown[:1]]
    here.trouble += words.precision_faults(found, flown)
    here.result["precision"] = words.precision_summary(found, flown)
    if not here.request.json:
        words.show_precision(found, flown)
    if not here.request.quiet:
        for line in words.precision_notes(found, flown):
            note(line)


def _flights(here: Run) -> list[flights.Flights]:
    work = flights.blocks(here.plan.flights)
    with here.bar("blocks of flights", len(work)) as tick:
        clock = here.schedule.clock(FLIGHTS)
        return flights.totals(flights.flights(bench_of(), work, clock, tick, here.keeping(FLIGHTS)))


def run_scenes(here: Run) -> None:
    """Time and modules of whole commands."""
    work = scenes.plan(here.plan.repeats, here.plan.quick)
    with here.bar("scenes", len(work)) as tick:
        found = list(scenes.scenes(work, here.schedule.clock(SCENES), tick, here.keeping(SCENES)))
    here.store.write_text("scenes.csv", scenes_csv(found))
    here.done.append(f"{_reached(found)} commands")
    here.trouble += words.scenes_faults(found)
    here.result["scenes"] = words.scenes_summary(found)
    if not here.request.json:
        words.show_scenes(found)


def _reached(found: Sequence[Any]) -> str:
    """How many were run: '5', or '3 of 5'."""
    count = sum(x.status != NOT_REACHED for x in found)
    return str(count) if count == len(found) else f"{count} of {len(found)}"
