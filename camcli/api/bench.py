"""What `cam bench` measures: our errors and times beside others', extreme cases, whole studies."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, replace
from functools import cache, partial
from math import isnan, nan
from typing import Any

from pydantic import TypeAdapter

from camcli.analysis.after_rest import of_shape
from camcli.analysis.bench import precision, stability
from camcli.analysis.bench.machine import Machines
from camcli.analysis.integrate import Cost
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
from camcli.words.bench import NO_HEYOKA, precision_notes, stability_notes


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
)  # fmt: skip
DRAWN = ("precision", "stability")
STUDIES: dict[str, tuple[Callable[..., Result], float, dict[str, Any]]] = {  # with their turns
    "sweep": (sweep, 401_000, {"sweep.rpm": {"start": 660.0, "stop": 760.0, "num": 401}}),
    "map": (
        sweep,
        2_880_000,
        {
            "run.record": 200,
            "sweep.vary": [
                {"key": "rpm", "start": 660.0, "stop": 760.0, "num": 60},
                {"key": "follower.restitution", "start": 0.6, "stop": 0.9, "num": 60},
            ],
        },
    ),
    "basins": (basins, nan, {"basins.cells": [256, 256]}),
}
PER_ROW = 0.5  # s of an extreme case, about
PER_STUDY = 5.0  # s on one thread and on all, about


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
    """Errors and times (``precision``), extreme cases (``stability``), whole studies (``scale``).

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
        Tables ``precision``, ``stability`` and ``scale``; their columns are in the guide
        (`cam guide bench`).
    """
    scene = scene or load_scene()
    with stopwatch() as watch, gathering() as faults:
        found = {name: _measured(name, scene, progress, work or Work()) for name in parts_of(scene)}
    results = {name: RESULTS[name](rows) for name, rows in found.items()}
    trouble = [f"{name}: {line}" for name, (_, failed) in results.items() for line in failed]
    ours = [m for m in found.get("precision", ()) if m.ours]
    absent = any(m.status == precision.ABSENT for m in found.get("precision", ()))
    return Result(
        command="bench",
        scene=scene,
        system=None,
        values=found,
        tables={one.name: _table(one, found[one.name]) for one in HEADS if one.name in found},
        summary={name: result for name, (result, _) in results.items()},
        pictures={k: drawn_by(f"bench.draw_{k}", found[k]) for k in DRAWN if k in found},
        cost=Cost(sum(m.impacts for m in ours), sum(m.evaluations for m in ours)),
        seconds=watch.seconds,
        notes=(*trouble, *[NO_HEYOKA] * absent),
        complete=not trouble,
        faults=tuple(faults),
    )


def parts_of(scene: Scene) -> list[str]:
    """The parts that a scene asks for: one, or all of them."""
    return list(PARTS) if scene.bench.part is None else [scene.bench.part]


def plan(scene: Scene) -> dict[str, dict[str, Any]]:
    """How many runs a part has, and the seconds of all: at most, or about."""
    each = {name: _pieces(name, scene) for name in parts_of(scene)}
    return {name: {"runs": len(few), "seconds": most} for name, (few, _, most) in each.items()}


def _pieces(name: str, scene: Scene) -> tuple[Sequence, Callable, float]:
    """The pieces of a part, what measures one, and the seconds of all."""
    section = scene.bench
    if name == "stability":
        rows = list(stability.ROWS.values())
        return rows, partial(stability.measure, machines=machines()), PER_ROW * len(rows)
    repeats = 1 if section.quick else section.repeats
    if name == "scale":
        return list(STUDIES), partial(_studied, repeats=repeats), PER_STUDY * repeats * len(STUDIES)
    points = precision.points(section.methods, section.quick)
    allowed = precision.QUICK_ALLOWED if section.quick else precision.ALLOWED
    measure = partial(precision.measure, machines=machines(), allowed=allowed, repeats=repeats)
    pieces = [(case, point) for case in section.cases for point in points]
    return pieces, measure, (allowed + repeats * precision.LONG) * len(pieces)


def _studied(name: str, repeats: int) -> Throughput:
    """The row of a study."""
    study, turns, changes = STUDIES[name]
    scene, threads = load_scene(None, changes), thread_count(None)
    seconds: dict[int, list[float]] = {1: [], threads: []}
    for _ in range(repeats):
        for count, times in seconds.items():
            of_shape.cache_clear()  # what one run has followed in balls, another would not
            found = study(scene, work=Work(count))
            times.append(found.seconds)
    one, several, impacts = min(seconds[1]), min(seconds[threads]), found.cost.impacts
    ratios = one / several, impacts / several
    return Throughput(name, turns, impacts, threads, one, several, *ratios)


def _measured(name: str, scene: Scene, progress: Progress | None, work: Work) -> list:
    """A row for every piece, measured one after the other.

    Of a piece that raises what nobody foresaw: a row of status FAULT where rows have one.
    """
    pieces, measure, _ = _pieces(name, scene)
    codec = Codec(
        lambda row: list(astuple(row)),
        lambda stored: PARTS[name](*stored),
        faults=lambda row: [row] if isinstance(row, PieceFault) else [],
    )
    alone = replace(work.within(name), threads=1)
    task = partial(_attempted, name, measure)
    found = alone.collect(task, pieces, codec, ticks(progress, name, len(pieces)))
    gather(row for row in found if isinstance(row, PieceFault))
    rows = []
    for piece, row in zip(pieces, found, strict=True):
        if not isinstance(row, PieceFault):
            rows.append(row)
        elif name == "precision":
            case, point = piece
            status = Status.FAULT.text
            rows.append(precision.Measured(case, point.method, point.setting, status=status))
    return rows


def _attempted(part: str, measure: Callable[[Any], Any], piece: Any) -> Any:
    """The row of a piece, or what it failed of."""
    words = piece
    if part == "precision":
        case, point = piece
        words = f"{case}, {point.method} {point.setting}"
    return attempt(f"{part}: {words}", lambda: measure(piece))


def _table(head: Head, rows: Sequence) -> Table:
    """The fields of each row, in their order, under the names of the columns."""
    cells = [[_cell(value) for value in astuple(row)] for row in rows]
    return Table.of_rows(head.names(), lambda: cells)


def _cell(value: Any) -> Any:
    """Text that needs no quotes, a number, or nothing."""
    if isinstance(value, str):
        return " ".join(value.replace(",", ";").replace('"', "'").split())
    return None if isinstance(value, float) and isnan(value) else value


def _precision_result(rows: Sequence[precision.Measured]) -> tuple[Any, list[str]]:
    """(result of run.json, a line for every failure)."""
    bad = [m for m in rows if m.ours and m.status != precision.OK]
    tally = Counter((m.method, m.status) for m in rows)
    result = {
        "cases": [asdict(v) for v in precision.verdicts(rows)],
        "points": [{"method": a, "status": b, "points": n} for (a, b), n in tally.items()],
        "failed": [f"{m.case}, {m.setting}: {m.status}" for m in bad],
    }
    return result, precision_notes(bad)


def _stability_result(rows: Sequence[stability.RowOutcome]) -> tuple[Any, list[str]]:
    bad = [o for o in rows if o.status != stability.OK]
    return {"rows": len(rows), "failed": [o.case for o in bad]}, stability_notes(bad)


def _scale_result(rows: Sequence[Throughput]) -> tuple[Any, list[str]]:
    return {"studies": [asdict(row) for row in rows]}, []


RESULTS: dict[str, Callable] = {
    "precision": _precision_result,
    "stability": _stability_result,
    "scale": _scale_result,
}


# --- the command


COMMAND = Command(
    run=bench,
    tables=HEADS,
    files=("precision.png", "stability.png"),
    keeps_pieces=lambda scene: True,
)  # fmt: skip
