"""cam bench"""

from __future__ import annotations

import json
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from camcli.cli.exit_codes import note
from camcli.cli.options import Request, argument, flag, given
from camcli.cli.report import table

if TYPE_CHECKING:
    from camcli.api.result import Result

MOST_CHARACTERS = 18  # characters of a published number on the screen
MOST_DIGITS = 16  # of ours
WITHOUT = ("verbose", "rpm", "points", "panels")  # every case has its own


def bench(
    request: Request,
    part: str | None = argument(
        "precision, stability, scale or validation. Default: all.", "[PART]"
    ),
    quick: bool = flag("A subset: about a minute on an idle machine."),
) -> int:
    """How exact, robust and fast; published numbers beside ours.

    Examples:
      cam bench --quick                        a minute of everything
      cam bench precision                      error against run time
      cam bench scale                          sweep, map and basins on all threads
      cam bench validation                     published numbers beside ours

    Files:
      precision.csv    error and seconds of each method and setting
      stability.csv    extreme cases, expected and observed
      scale.csv        turns, impacts and seconds of whole studies
      validation.csv   published numbers, ours, and by how much they may differ
      precision.png    error against time; stability.png the cases
      validation.png   by how much each published number is off

    \b
    precision.png  error against time, a panel per case
    stability.png  its times, failed cases in a colour of their own
    validation.png  a line per number: its bound, and ours less the published one

    \b
    Every case of precision has its own machine, start and whole turns; the reference comes from a
    multiple-precision solution stored with the program, not from this kernel. seconds: median of
    bench.repeats calls, or of the first where it takes long. error: the largest of impact and
    accumulation phases (turns) and of the final state (q over the cam's lift, v over omega times
    it). missed, extra: impacts of the reference not found, and found but not there; the last 1e-3
    turn of a complete chatter is not asked of anybody. bound: what is promised for ours where the
    error is largest; of_bound: the largest share of any bound, beyond 1 a failure.
    Status: ok; over-bound (exit code 3); missed or invented (impacts); given-up (time or impacts
    used up); failed (the method stopped with an error); fault (of camcli, exit code 1, run.json has
    the traceback); not-installed.
    Methods: core (over its chatter tolerance), rk45, dop853, lsoda, radau (scipy's solve_ivp with
    contact events over rtol = atol, without a step limit and with steps of at most 1/16 turn),
    heyoka (Taylor series with terminal events; extra `bench`), rk4 (fixed steps and bisection).
    All integrate the gap from corner to corner of the cam, stick, and close a chatter by its map.

    \b
    Every problem of validation is a scene in configs/validation, by people who do not know this
    program. bound: half a unit in the last digit that they print, and our own error; 0 for a count.
    digits: of the published number; formula: the source has a formula, which is evaluated here in
    20 digits. Status: ok; published-off (the published number is off by more than its digits; ours
    agrees with independent, a computation in 40 digits that the tests repeat); failed (exit code
    3).

    \b
    The machine of the scene is not used; section bench chooses cases, methods and repeats. Exit
    code 3 if a row of stability or validation fails, or if an error of ours is beyond its bound.
    """
    from camcli.api.bench import COMMAND, plan
    from camcli.cli.run import execute
    from camcli.scene import load_scene

    values = (
        given("bench", quick=quick) | given("bench", "PART", part=part) | request.picture_values()
    )
    scene = load_scene(request.config, request.sets or (), values)
    if request.config is not None and not request.quiet:
        note(
            f"note: of {request.config} only the section bench is used: "
            "every case has a machine of its own"
        )
    if not request.dry_run:
        return execute(COMMAND, scene, request, show)
    planned = plan(scene)
    if request.json:
        print(json.dumps({"command": "bench", "plan": planned}, indent=2))
    else:
        rows = [[name, str(p["runs"]), f"{p['seconds']:.3g}"] for name, p in planned.items()]
        table("cam bench, planned", ["part", "runs", "seconds (at most)"], rows)
    return 0


def show(result: Result, _: bool) -> None:
    """What a person reads of each part, and how much was measured."""
    from camcli.analysis.bench import precision

    rows_of = result.values  # by part
    if "precision" in rows_of:
        verdicts = precision.verdicts(rows_of["precision"])
        columns = [field.name for field in fields(precision.CaseVerdict)]
        _show("Work and precision", columns, verdicts)
    if "stability" in rows_of:
        _show("Extreme cases", ["case", "observed", "status", "seconds"], rows_of["stability"])
    if "validation" in rows_of:
        _show_numbers(rows_of["validation"])
    if "scale" in rows_of:
        columns = ["case", "impacts", "threads", "seconds", "speedup", "impacts_per_s"]
        _show("Whole studies", columns, rows_of["scale"])
    count = " and ".join(f"{len(rows)} of {name}" for name, rows in rows_of.items())
    print(f"{count} in {result.seconds:.3g} s")


def _show_numbers(rows: list) -> None:
    """Print the published numbers by problem, ours with two digits more than published."""
    heads = ["quantity", "published", "ours", "difference", "bound", "status"]
    for problem in dict.fromkeys(row.problem for row in rows):
        cells = []
        for row in rows:
            if row.problem != problem:
                continue
            published_digits = sum(sign.isdigit() for sign in row.published.lstrip("-0."))
            digits = min(MOST_DIGITS, published_digits + 2)
            cells.append(
                [
                    row.quantity,
                    _shortened(row.published),
                    f"{row.ours:.{digits}g}",
                    f"{row.difference:.1e}",
                    f"{row.bound:.1e}",
                    row.status,
                ]
            )
        table(problem, heads, cells)


def _shortened(number: str) -> str:
    """A published number with as many digits as a double has."""
    return f"{number[:MOST_CHARACTERS]}.." if len(number) > MOST_CHARACTERS + 2 else number


def _show(title: str, columns: list[str], rows: list) -> None:
    """Print a table; columns: names of fields of the rows."""
    cells = [[_text(getattr(row, column)) for column in columns] for row in rows]
    table(title, [column.replace("_", " ") for column in columns], cells)


def _text(value: Any) -> str:
    """A value as a cell: two digits of a number, `-` for what is not known."""
    is_nan = value != value
    if value is None or is_nan:
        return "-"
    if isinstance(value, float):
        return f"{value:.2g}"
    return str(value).replace(" tol ", " ")
