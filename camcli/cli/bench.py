"""cam bench: what is measured, written and said."""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, fields, replace
from functools import cache, partial
from math import isnan
from time import perf_counter
from typing import Annotated, Any

from typer import Argument, Option

from camcli.analysis.bench import precision, stability
from camcli.analysis.bench.machine import Machines
from camcli.analysis.integrate import Cost
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import DRAWING, Request, given
from camcli.cli.report import progress_bar, table
from camcli.cli.run import compiling, open_folder
from camcli.errors import Fault, SceneError
from camcli.output.run_folder import RunFolder
from camcli.output.run_record import cost_record, run_record, to_text
from camcli.output.tables import Table
from camcli.parallel import Codec
from camcli.scene import load_scene, resolved, scene_hash
from camcli.scene.schema import Bench

NAME = "bench"
WITHOUT = DRAWING  # shared options that mean nothing here
PARTS: dict[str, Any] = {
    "precision": precision.Measured,
    "stability": stability.Outcome,
}  # and their rows
PER_ROW = 0.5  # s of an extreme case, about
SHOWN = {
    "precision": ("Work and precision", [f.name for f in fields(precision.Verdict)]),
    "stability": ("Extreme cases", ["case", "observed", "status", "seconds"]),
}


@cache
def machines() -> Machines:
    """The machines of the bench; their cams are validated like those of scenes."""
    from pydantic import TypeAdapter

    from camcli.scene import Cam

    cams: TypeAdapter[Any] = TypeAdapter(Cam)
    return Machines(lambda section: cams.validate_python(dict(section)))


def bench(
    request: Request,
    part: Annotated[
        str | None, Argument(help="precision or stability. Default: both.", metavar="[PART]")
    ] = None,
    quick: Annotated[bool, Option("--quick", help="A subset within a minute.")] = False,
) -> int:
    """How exact, how robust and how fast.

    \b
    precision.csv  case, method, setting, seconds, error, impacts, evaluations, missed, extra,
                   bound, of_bound, status: ours and general integrators on the same motions
    precision.png  error against time, a panel per case
    stability.csv  case, expected, observed, status, seconds: the table of extreme cases, run
    stability.png  its times, failed cases in a colour of their own

    \b
    Every case of precision has its own machine, start and whole turns; the reference comes from a
    multiple-precision solution stored with the program, not from this kernel. seconds: median of
    bench.repeats calls, or of the first where it takes long. error: the largest of impact and
    accumulation phases (turns) and of the final state (q over the cam's lift, v over omega times
    it). missed, extra: impacts of the reference not found, and found but not there; the last 1e-3
    turn of a complete chatter is not asked of anybody. bound: what is promised for ours where the
    error is largest; of_bound: the largest share of any bound, beyond 1 a failure.
    Status: ok; over-bound (exit code 3); missed or invented (impacts); given-up (time or impacts
    used up); failed (the method stopped with an error); not-installed.
    Methods: core (over its chatter tolerance), rk45, dop853, lsoda, radau (scipy's solve_ivp with
    contact events over rtol = atol, without a step limit and with steps of at most 1/16 turn),
    heyoka (Taylor series with terminal events; extra `bench`), rk4 (fixed steps and bisection).
    All integrate the gap from corner to corner of the cam, stick, and close a chatter by its map.

    \b
    The machine of the scene is not used; section bench chooses cases, methods and repeats. Exit
    code 3 if a row of stability fails, or if an error of ours is beyond its bound.
    """
    if part is not None and part not in PARTS:
        expected = f"expected one of {', '.join(PARTS)}"
        raise SceneError(Fault("PART", "", f"found '{part}'", expected, "leave it out for all"))
    for name, word in (("--rpm", request.rpm), ("--points", request.points)):
        if word is not None:
            expected, cure = "expected none: every case has its own", "choose bench.cases instead"
            raise SceneError(Fault(name, "", f"found {word}", expected, cure))
    scene = load_scene(request.config, request.sets or (), given("bench", quick=quick))
    parts = list(PARTS) if part is None else [part]
    work = {name: _work(name, scene.bench) for name in parts}
    if request.dry_run:
        _tell_plan({name: (len(pieces), most) for name, (pieces, _, most) in work.items()}, request)
        return DONE
    began = perf_counter()
    found: dict[str, list] = {}
    result: dict[str, Any] = {}
    trouble: list[str] = []
    with compiling(request), open_folder(NAME, scene, request) as folder:
        for name, (pieces, measure, _) in work.items():
            rows = found[name] = _measured(name, pieces, measure, folder, request)
            _write(name, rows, folder, request)
            result[name], failed = RESULTS[name](rows)
            trouble += [f"{name}: {line}" for line in failed]
        ours = [m for m in found.get("precision", ()) if m.ours]
        cost = Cost(sum(m.impacts for m in ours), sum(m.evaluations for m in ours))
        seconds = perf_counter() - began
        record = run_record(
            command=NAME,
            scene=resolved(scene),
            scene_sha256=scene_hash(scene),
            options={**({"part": part} if part else {}), "plot": not request.no_plot},
            cost=cost_record(cost, seconds, folder.resumed),
            error={},
            result=result,
            artefacts=dict(folder.hashes),
        )
        folder.write_text("run.json", [to_text(record)])
        folder.commit()
        if request.json:
            print(to_text(record), end="")
        else:
            kept = f", {folder.resumed} of them from disk" if folder.resumed else ""
            count = " and ".join(f"{len(rows)} of {name}" for name, rows in found.items())
            print(f"{folder.folder}/: {', '.join(folder.hashes)}")
            print(f"{count} in {seconds:.3g} s{kept}")
    for line in trouble:
        note(line)
    if any(m.status == precision.ABSENT for m in found.get("precision", ())) and not request.quiet:
        note("heyoka is not installed, its points are left out: pip install 'camcli[bench]'")
    return NUMERICS if trouble else DONE


def _work(name: str, section: Bench) -> tuple[Sequence, Callable, float]:
    """The pieces of a part, what measures one, and the seconds of all: at most, or about."""
    if name == "stability":
        rows = list(stability.ROWS.values())
        return rows, partial(stability.measure, machines=machines()), PER_ROW * len(rows)
    points = precision.points(section.methods, section.quick)
    allowed = precision.QUICK_ALLOWED if section.quick else precision.ALLOWED
    repeats = 1 if section.quick else section.repeats
    measure = partial(precision.measure, machines=machines(), allowed=allowed, repeats=repeats)
    pieces = [(case, point) for case in section.cases for point in points]
    return pieces, measure, (allowed + repeats * precision.LONG) * len(pieces)


def _tell_plan(plan: dict[str, tuple[int, float]], request: Request) -> None:
    if request.json:
        planned = {name: {"runs": runs, "seconds": most} for name, (runs, most) in plan.items()}
        print(json.dumps({"command": NAME, "plan": planned}, indent=2))
        return
    lines = [[name, str(runs), f"{most:.3g}"] for name, (runs, most) in plan.items()]
    table("cam bench, planned", ["part", "runs", "seconds (at most)"], lines)


def _measured(
    name: str, pieces: Sequence, measure: Callable, folder: RunFolder, request: Request
) -> list:
    """A row for every piece, measured one after the other; kept as the timings they are."""
    work = replace(folder.work.within(name), threads=1)
    found: list = []
    codec = Codec(lambda row: list(astuple(row)), lambda stored: PARTS[name](*stored))
    with progress_bar(request.quiet) as progress:
        for row in work.run(lambda k: measure(pieces[k]), range(len(pieces)), codec):
            found.append(row)
            if progress is not None:
                progress(name, len(found), len(pieces))
    return found


def _write(name: str, rows: Sequence, folder: RunFolder, request: Request) -> None:
    """The table of a part, its picture, and what a person reads of it."""
    cells = [[_cell(value) for value in astuple(row)] for row in rows]
    columns = [f.name for f in fields(PARTS[name])]
    folder.write_text(f"{name}.csv", Table.of_rows(columns, lambda: cells).csv())
    if not request.no_plot:
        from camcli.output.pictures import write_picture
        from camcli.plots.bench import draw_precision, draw_stability

        draw = draw_precision if name == "precision" else draw_stability
        folder.write(f"{name}.png", partial(write_picture, draw(rows)))
    if not request.json:
        title, shown = SHOWN[name]
        told = precision.verdicts(rows) if name == "precision" else rows
        lines = [[_text(getattr(row, column)) for column in shown] for row in told]
        table(title, [column.replace("_", " ") for column in shown], lines)


def _cell(value: Any) -> Any:
    """Text that needs no quotes, a number, or nothing."""
    if isinstance(value, str):
        return " ".join(value.replace(",", ";").replace('"', "'").split())
    return None if isinstance(value, float) and isnan(value) else value


def _text(value: Any) -> str:
    if _cell(value) is None:
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _precision_result(rows: Sequence[precision.Measured]) -> tuple[Any, list[str]]:
    """(result of run.json, a line for every failure)."""
    bad = [m for m in rows if m.ours and m.status != precision.OK]
    tally = Counter((m.method, m.status) for m in rows)
    result = {
        "cases": [asdict(v) for v in precision.verdicts(rows)],
        "points": [{"method": a, "status": b, "points": n} for (a, b), n in tally.items()],
        "failed": [f"{m.case}, {m.setting}: {m.status}" for m in bad],
    }
    return result, [
        f"{m.case}, {m.setting}: {m.status}: error {m.error:.2g} turns, {m.of_bound:.3g} times its "
        f"bound at most, {m.missed} impacts missed"
        for m in bad
    ]


def _stability_result(rows: Sequence[stability.Outcome]) -> tuple[Any, list[str]]:
    bad = [o for o in rows if o.status != stability.OK]
    lines = [f"row {o.case}: expected {o.expected}: {o.observed}" for o in bad]
    return {"rows": len(rows), "failed": [o.case for o in bad]}, lines


RESULTS: dict[str, Callable] = {"precision": _precision_result, "stability": _stability_result}
