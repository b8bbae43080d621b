"""cam basins"""

from __future__ import annotations

from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any

from camcli.analysis.basins.mapping import SIMPLE, Question
from camcli.analysis.basins.study import Study, study
from camcli.analysis.basins.window import Window
from camcli.analysis.sweep import rpm_grid
from camcli.cli.basins_words import show, summary, undecided_words
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.long_run import long_run
from camcli.cli.options import Request
from camcli.cli.plan_basins import basins_planned
from camcli.cli.progress import bar
from camcli.cli.report import finish
from camcli.cli.setup import Setup, set_up, speed_range, timed
from camcli.errors import Fault, SceneError, Status, shown
from camcli.output.basins import attractors_csv, basins_csv
from camcli.output.run_folder import RunFolder
from camcli.parallel import Work
from camcli.scene import scalar
from camcli.scene.schema import MOST_CELLS

NAME = "basins"
STEPS = 100  # of the progress bar


def run(request: Request) -> int:
    """Map the basins of one speed or of a range and write them; returns the exit code."""
    setup = set_up(request, _options(request))
    section = setup.scene.basins
    question = _question(setup)
    if basins_planned(request, setup, question):
        return DONE
    speeds = section.rpm
    rpms = rpm_grid(speeds.start, speeds.stop, 1 if speeds.start == speeds.stop else speeds.num)
    with long_run(NAME, request, setup) as store:
        with timed(request) as watch:
            result = _compute(request, setup, question, rpms, store.work)
        seconds = watch.seconds
        _write(request, setup, store, question, result)
        if not request.json:
            show(result, question)
        found, known = summary(result, question), store.resumed
        finish(NAME, request, setup, store, result.cost, seconds, found, from_disk=known)
        return _verdict(result, request.quiet, question)
    return DONE  # of a shard


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    """Scene values of --rpm, --points and the options of this command."""
    values = speed_range(request, NAME)
    extra = request.extra
    if extra["cells"] is not None:
        values["basins.cells"] = (_cells(extra["cells"]), "--cells")
    for side in ("q", "v"):
        if extra[side] is not None:
            values[f"basins.{side}"] = (_span(extra[side], f"--{side}"), f"--{side}")
    for key in ("method", "refine"):
        if extra[key] is not None:
            values[f"basins.{key}"] = (extra[key], f"--{key}")
    for key in ("boundary", "exponents"):
        if extra[key]:
            values[f"basins.{key}"] = (True, f"--{key}")
    return values


def _cells(text: str) -> list[int]:
    numbers = [scalar(word.strip()) for word in text.replace("x", ",").split(",")]
    good = all(type(n) is int and 1 <= n <= MOST_CELLS for n in numbers)
    if not good or len(numbers) > 2:
        expected = f"expected N or NQ,NV, whole numbers from 1 to {MOST_CELLS}"
        path = "basins.cells" if all(type(n) is int for n in numbers) else ""
        raise SceneError(Fault("--cells", path, f"found '{shown(text)}'", expected, "e.g. 400,300"))
    return [numbers[0], numbers[-1]]


def _span(text: str, name: str) -> list[float]:
    values = [scalar(word.strip()) for word in text.split(":")]
    if len(values) != 2 or any(isinstance(v, bool | str | None) for v in values):
        found = f"found '{shown(text)}'"
        raise SceneError(Fault(name, "", found, "expected LO:HI, two numbers", "e.g. -20:40"))
    return [float(value) for value in values]


def _question(setup: Setup) -> Question:
    section = setup.scene.basins
    window = Window(section.q, section.v, *section.cells)
    if section.method == SIMPLE and section.refine:
        found = f"found {section.refine} with the method simple"
        expected = "expected the method orbit: a cell map has one size of cells"
        cure = "use --method orbit, or more --cells"
        raise SceneError(Fault("", "basins.refine", found, expected, cure))
    return Question(window, section.method, section.budget, section.refine)


def _compute(request: Request, setup: Setup, question: Question, rpms, work: Work) -> Study:
    total = question.window.count * len(rpms)
    with _progress(total, request.quiet) as on_cells:
        return study(
            setup.system,
            rpms,
            setup.settings,
            question,
            boundary=setup.scene.basins.boundary,
            exponents=setup.scene.basins.exponents,
            work=work,
            on_cells=on_cells,
        )


@contextmanager
def _progress(total: int, quiet: bool):
    """A function to call with finished cells; it moves a bar of STEPS steps."""
    done = shown = 0
    with nullcontext() if quiet else bar("cells", STEPS) as tick:

        def on_cells(cells: int) -> None:
            nonlocal done, shown
            done += cells
            while tick is not None and shown * total < done * STEPS and shown < STEPS:
                shown += 1
                tick()

        yield on_cells


def _write(
    request: Request, setup: Setup, store: RunFolder, question: Question, result: Study
) -> None:
    store.write_text("attractors.csv", attractors_csv(result))
    if result.grid is not None:
        store.write_text("basins.csv", basins_csv(result.grid, question.refine))
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.basins import draw_basins

    figure = draw_basins(result, question, setup.system)
    store.write("basins.png", partial(write_png, figure))


def _verdict(result: Study, quiet: bool, question: Question) -> int:
    """Exit code 3 and a note per kind of trouble; a note where cells stayed undecided."""
    if not any(speed.computed for speed in result.speeds):
        note("no start of this window lies above the cam: raise basins.q")
    words = undecided_words(result, question)
    if words and not quiet:
        note(words)
    for code in sorted({code for speed in result.speeds for code in speed.troubled}):
        cells = sum(speed.troubled.get(code, 0) for speed in result.speeds)
        status = Status(code)
        note(f"{status.text} in {cells} cells: {status.cause}; {status.cure}")
    return NUMERICS if result.troubled else DONE
