"""What `cam bench` measures: errors and times beside others', extreme cases, studies, papers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import cache, partial
from math import isnan, nan
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from camcli.analysis.after_rest import of_shape
from camcli.analysis.bench import precision, stability
from camcli.analysis.bench import validation as published
from camcli.analysis.bench.machine import Machines
from camcli.analysis.integrate import Cost
from camcli.api import validation
from camcli.api.basins import basins
from camcli.api.command import Command
from camcli.api.result import Progress, Result, drawn_by, ticks
from camcli.api.sweep import sweep
from camcli.errors import Status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.parallel import Codec, Work
from camcli.parallel.threads import thread_count
from camcli.piece_faults import PieceFault, attempt, gather, gathering
from camcli.quantities import STATUS, Head, Quantity
from camcli.scene import Cam, Scene, load_scene
from camcli.words.bench import NO_HEYOKA, precision_notes, stability_notes, validation_notes


@dataclass(frozen=True)
class Throughput:
    """A row of scale.csv: a study on one thread and on all, in turn; the least seconds of each."""

    case: str
    turns: float  # NaN: not counted
    impacts: int
    threads: int
    seconds_one_thread: float
    seconds: float
    speedup: float
    impacts_per_s: float


PARTS: dict[str, Any] = {
    "precision": precision.Measured,
    "stability": stability.RowOutcome,
    "scale": Throughput,
    "validation": published.ValidationRow,
}
CASE = Quantity("case", "", "case", "what is measured")
SECONDS = Quantity("seconds", "s", "seconds", "time of a run")
HEADS = (
    Head(
        "precision",
        "ours and general integrators on the same motions",
        (
            CASE, Quantity("method", "", "method", "what integrates"),
            Quantity("setting", "", "setting", "its tolerance or step"),
            SECONDS, Quantity("error", "turns", "error", "largest error"),
            Quantity("impacts", "", "impacts", "impacts of the run"),
            Quantity("evaluations", "", "evaluations", "gaps or derivatives computed"),
            Quantity("missed", "", "missed", "impacts of the reference not found"),
            Quantity("extra", "", "extra", "impacts found but not there"),
            Quantity("bound", "turns", "bound", "error promised where it is largest"),
            Quantity("of_bound", "", "of bound", "largest error over its own bound"), STATUS,
        ),
    ),
    Head(
        "stability",
        "the table of extreme cases, run",
        (
            CASE, Quantity("expected", "", "expected", "what should happen"),
            Quantity("observed", "", "observed", "what happens"), STATUS, SECONDS,
        ),
    ),
    Head(
        "scale",
        "a sweep of 401 speeds, a map of 60 x 60 points, basins of 256 x 256 cells, on one thread "
        "and on all in turn, the least of bench.repeats each",
        (
            CASE, Quantity("turns", "turns", "turns", "turns computed", "empty: not counted"),
            Quantity("impacts", "", "impacts", "impacts computed"),
            Quantity("threads", "", "threads", "threads of the second run"),
            Quantity("seconds_one_thread", "s", "seconds", "time on one thread"),
            SECONDS._replace(words="time on all threads"),
            Quantity("speedup", "", "speedup", "the first time over the second"),
            Quantity("impacts_per_s", "1/s", "impacts", "impacts a second on all threads"),
        ),
    ),
    Head(
        "validation",
        "published numbers beside ours",
        (
            Quantity("source", "", "source", "who published it, where"),
            Quantity("quantity", "", "quantity", "what it is, and its unit"),
            Quantity("published", "", "published", "the number as it is printed there"),
            Quantity("ours", "", "ours", "the number as computed here"),
            Quantity("difference", "", "difference", "ours minus published"),
            Quantity(
                "bound", "", "bound",
                "what it may be: half a unit in the last published digit and our own error",
            ),
            Quantity("place", "", "place", "where in the source the number stands"),
            Quantity(
                "digits", "", "digits", "published digits",
                "count: a number of things; formula: of the source, evaluated in 20 digits",
            ),
            Quantity(
                "independent", "", "independent", "its value from an independent computation",
                "empty: none was needed",
            ),
            STATUS, SECONDS._replace(words="time that the number took"),
            Quantity("problem", "", "problem", "its scene in configs/validation"),
        ),
    ),
)  # fmt: skip
DRAWN = ("precision", "stability", "validation")  # the parts that have a picture


class WholeStudy(NamedTuple):
    """A study of the part `scale`: the API function that is timed, and what it is asked.

    turns: of all its orbits, the transients with them; NaN where they are not counted. keys: of the
    scene, beside the default one.
    """

    run: Callable[..., Result]
    turns: float
    keys: Mapping[str, Any]


STUDIES = {
    "sweep": WholeStudy(
        run=sweep,
        turns=401_000,
        keys={"sweep.rpm": {"start": 660.0, "stop": 760.0, "num": 401}},
    ),
    "map": WholeStudy(
        run=sweep,
        turns=2_880_000,
        keys={
            "run.record": 200,
            "sweep.vary": [
                {"key": "rpm", "start": 660.0, "stop": 760.0, "num": 60},
                {"key": "follower.restitution", "start": 0.6, "stop": 0.9, "num": 60},
            ],
        },
    ),
    "basins": WholeStudy(run=basins, turns=nan, keys={"basins.cells": [256, 256]}),
}
# For the plan of a run, about; a study runs on one thread and on all.
SECONDS_A_CASE = 0.5
SECONDS_A_STUDY = 5.0
SECONDS_A_PROBLEM = 0.25


@cache
def machines() -> Machines:
    """The machines of the bench; their cams are validated like those of scenes."""
    cams: TypeAdapter[Any] = TypeAdapter(Cam)
    return Machines(lambda section: cams.validate_python(dict(section)))


def bench(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    work: Work | None = None,
) -> Result:
    """Errors and times, extreme cases, whole studies, published problems.

    Parameters
    ----------
    scene : Scene, optional
        Its section ``bench``: part, cases, methods, repeats, quick. Its machine is not used.
    progress : callable, optional
        Called as ``progress(part, done, total)``.
    work : Work, optional
        Keeps the points of an interrupted run on disk, as the timings they are.

    Returns
    -------
    Result
        Tables ``precision``, ``stability``, ``scale`` and ``validation``; their columns are in the
        guide (`cam guide bench`).
    """
    scene = scene or load_scene()
    with stopwatch() as watch, gathering() as faults:
        rows = {name: _measured(name, scene, progress, work or Work()) for name in parts_of(scene)}
    results = {name: RESULTS[name](rows[name]) for name in rows}
    failures = [f"{name}: {line}" for name, part in results.items() for line in part.failures]
    notes = list(failures)
    precision_rows = rows.get("precision", ())
    ours = [row for row in precision_rows if row.ours]
    if any(row.status == precision.ABSENT for row in precision_rows):
        notes.append(NO_HEYOKA)
    return Result(
        command="bench",
        scene=scene,
        system=None,
        values=rows,
        tables={head.name: _table(head, rows[head.name]) for head in HEADS if head.name in rows},
        summary={name: part.record for name, part in results.items()},
        pictures={
            name: drawn_by(f"bench.draw_{name}", rows[name]) for name in DRAWN if name in rows
        },
        cost=Cost(sum(row.impacts for row in ours), sum(row.evaluations for row in ours)),
        seconds=watch.seconds,
        notes=tuple(notes),
        complete=not failures,
        faults=tuple(faults),
    )


def parts_of(scene: Scene) -> list[str]:
    """The parts of the benchmark that a scene asks for: one of them, or all."""
    return list(PARTS) if scene.bench.part is None else [scene.bench.part]


def plan(scene: Scene) -> dict[str, dict[str, Any]]:
    """Of each part, how many runs it has, and the seconds of all of them, about or at most."""
    plans = {}
    for name in parts_of(scene):
        part = _part_plan(name, scene)
        plans[name] = {"runs": len(part.pieces), "seconds": part.seconds}
    return plans


class PartPlan(NamedTuple):
    """The work of a part: its pieces, the function that measures one, the seconds of all."""

    pieces: Sequence[Any]
    measure: Callable[[Any], Any]
    seconds: float


def _part_plan(name: str, scene: Scene) -> PartPlan:
    """The work of the part of this name, as the scene's section `bench` asks for it."""
    section = scene.bench
    measure: Callable[[Any], Any]
    if name == "stability":
        cases = list(stability.ROWS.values())
        measure = partial(stability.measure, machines=machines())
        return PartPlan(cases, measure, SECONDS_A_CASE * len(cases))
    if name == "validation":
        problems = validation.chosen(section.quick)
        return PartPlan(problems, validation.measure, SECONDS_A_PROBLEM * len(problems))
    repeats = 1 if section.quick else section.repeats
    if name == "scale":
        studies = list(STUDIES)
        measure = partial(_throughput, repeats=repeats)
        return PartPlan(studies, measure, SECONDS_A_STUDY * repeats * len(studies))
    settings = precision.points(section.methods, section.quick)
    points = [precision.Point(case, setting) for case in section.cases for setting in settings]
    allowed = precision.QUICK_ALLOWED if section.quick else precision.ALLOWED
    measure = partial(precision.measure, machines=machines(), allowed=allowed, repeats=repeats)
    return PartPlan(points, measure, (allowed + repeats * precision.LONG) * len(points))


def _throughput(name: str, repeats: int) -> Throughput:
    """The row of a study of this name, run `repeats` times on one thread and on all, in turn."""
    study = STUDIES[name]
    scene = load_scene(None, study.keys)
    threads = thread_count(None)
    seconds: dict[int, list[float]] = {1: [], threads: []}
    for _ in range(repeats):
        for count, times in seconds.items():
            of_shape.cache_clear()  # what one run has followed in balls, another would not
            result = study.run(scene, work=Work(count))
            times.append(result.seconds)
    impacts = result.cost.impacts
    one_thread = min(seconds[1])
    all_threads = min(seconds[threads])
    return Throughput(
        case=name,
        turns=study.turns,
        impacts=impacts,
        threads=threads,
        seconds_one_thread=one_thread,
        seconds=all_threads,
        speedup=one_thread / all_threads,
        impacts_per_s=impacts / all_threads,
    )


def _measured(name: str, scene: Scene, progress: Progress | None, work: Work) -> list:
    """The rows of a part, measured one piece after the other; a problem has several rows.

    A piece that raised what nobody foresaw is gathered with the faults of the run. It has a row of
    status `fault` in precision.csv, and none in the other tables.
    """
    plan = _part_plan(name, scene)
    codec = Codec(  # the result of a piece is its rows, or a PieceFault
        lambda rows: [list(astuple(row)) for row in rows],
        lambda stored: [PARTS[name](*row) for row in stored],
        faults=lambda result: [result] if isinstance(result, PieceFault) else [],
    )
    alone = replace(work.within(name), threads=1)  # a time is that of a machine with nothing else
    task = partial(_attempted, name, plan.measure)
    on_piece = ticks(progress, name, len(plan.pieces))
    results = alone.collect(task, plan.pieces, codec, on_piece)
    gather(result for result in results if isinstance(result, PieceFault))
    rows = []
    for piece, result in zip(plan.pieces, results, strict=True):
        if not isinstance(result, PieceFault):
            rows.extend(result)
        elif name == "precision":
            rows.append(piece.row(status=Status.FAULT.text))
    return rows


def _attempted(part: str, measure: Callable[[Any], Any], piece: Any) -> Any:
    """The rows of a piece, or the `PieceFault` that an unforeseen exception makes of it.

    piece: of the precision a point, of the validation a problem, else the name of a case or study.
    """
    if part == "validation":  # one problem gives several rows
        return attempt(f"{part}: {piece.scene}", lambda: measure(piece))
    name = piece
    if part == "precision":
        name = f"{piece.case}, {piece.setting.method} {piece.setting.setting}"
    return attempt(f"{part}: {name}", lambda: [measure(piece)])


def _table(head: Head, rows: Sequence) -> Table:
    """A table of a part; rows: dataclasses whose fields are the columns, in their order."""
    cells = [[_cell(value) for value in astuple(row)] for row in rows]
    return Table.of_rows(head.names(), lambda: cells)


def _cell(value: Any) -> Any:
    """A value as a cell of a CSV: text without what needs quotes, a number, or None for NaN."""
    if isinstance(value, str):
        return " ".join(value.replace(",", ";").replace('"', "'").split())
    return None if isinstance(value, float) and isnan(value) else value


class PartResult(NamedTuple):
    """What the rows of a part say: its entry of run.json, and a line for every failure."""

    record: dict[str, Any]
    failures: list[str]


def _precision_result(rows: Sequence[precision.Measured]) -> PartResult:
    """The verdict on each case, how often each method ended how, and what ours failed in."""
    bad = [row for row in rows if row.ours and row.status != precision.OK]
    tally = Counter((row.method, row.status) for row in rows)
    record = {
        "cases": [asdict(verdict) for verdict in precision.verdicts(rows)],
        "points": [
            {"method": method, "status": status, "points": count}
            for (method, status), count in tally.items()
        ],
        "failed": [f"{row.case}, {row.setting}: {row.status}" for row in bad],
    }
    return PartResult(record, precision_notes(bad))


def _stability_result(rows: Sequence[stability.RowOutcome]) -> PartResult:
    """How many extreme cases were run, and which of them failed."""
    bad = [row for row in rows if row.status != stability.OK]
    record = {"rows": len(rows), "failed": [row.case for row in bad]}
    return PartResult(record, stability_notes(bad))


def _scale_result(rows: Sequence[Throughput]) -> PartResult:
    """The rows as they are: a time cannot fail."""
    return PartResult({"studies": [asdict(row) for row in rows]}, [])


def _validation_result(rows: Sequence[published.ValidationRow]) -> PartResult:
    """How many numbers were compared, which are published wrong, and which are not reproduced."""
    wrong = [row for row in rows if row.status == published.MISPRINT]
    bad = [row for row in rows if row.status == published.FAILED]
    record = {
        "problems": len({row.problem for row in rows}),
        "rows": len(rows),
        "published_off": [f"{row.problem}: {row.quantity}" for row in wrong],
        "failed": [f"{row.problem}: {row.quantity}" for row in bad],
    }
    return PartResult(record, validation_notes(bad))


RESULTS: dict[str, Callable[[Any], PartResult]] = {
    "precision": _precision_result,
    "stability": _stability_result,
    "scale": _scale_result,
    "validation": _validation_result,
}


# --- the command


COMMAND = Command(
    run=bench,
    tables=HEADS,
    files=("precision.png", "stability.png", "validation.png"),
    keeps_pieces=lambda scene: True,
)  # fmt: skip
