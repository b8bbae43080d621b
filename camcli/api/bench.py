"""What `cam bench` measures: our errors and times beside others', and the extreme cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, fields, replace
from functools import cache, partial
from math import isnan
from typing import Any

from pydantic import TypeAdapter

from camcli.analysis.bench import precision, stability
from camcli.analysis.bench.machine import Machines
from camcli.analysis.integrate import Cost
from camcli.api.result import Progress, Result, drawn_by, ticks
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.parallel import Codec, Work
from camcli.scene import Cam, Scene, load_scene

PARTS: dict[str, Any] = {"precision": precision.Measured, "stability": stability.Outcome}
PER_ROW = 0.5  # s of an extreme case, about
NO_HEYOKA = "heyoka is not installed, its points are left out: pip install 'camcli[bench]'"


@cache
def machines() -> Machines:
    """The machines of the bench; their cams are validated like those of scenes."""
    cams: TypeAdapter[Any] = TypeAdapter(Cam)
    return Machines(lambda section: cams.validate_python(dict(section)))


def bench(
    scene: Scene | None = None,
    progress: Progress | None = None,
    *,
    part: str | None = None,
    work: Work | None = None,
) -> Result:
    """Measure errors and times (``precision``), and run the extreme cases (``stability``).

    Parameters
    ----------
    scene : Scene, optional
        Its section ``bench``: cases, methods, repeats, quick. Its machine is not used.
    progress : callable, optional
        Called as ``progress(part, done, total)``.
    part : str, optional
        Only this part; both if left out.
    work : Work, optional
        Keeps the points of an interrupted run on disk, as the timings they are.

    Returns
    -------
    Result
        Tables, named as their files without the ending:

        precision.csv  case, method, setting, seconds, error, impacts, evaluations, missed, extra,
                       bound, of_bound, status: ours and general integrators on the same motions
        stability.csv  case, expected, observed, status, seconds: the table of extreme cases, run
    """
    scene = scene or load_scene()
    with stopwatch() as watch:
        parts = [part] if part else PARTS
        found = {name: _measured(name, scene, progress, work or Work()) for name in parts}
    results = {name: RESULTS[name](rows) for name, rows in found.items()}
    trouble = [f"{name}: {line}" for name, (_, failed) in results.items() for line in failed]
    ours = [m for m in found.get("precision", ()) if m.ours]
    absent = any(m.status == precision.ABSENT for m in found.get("precision", ()))
    return Result(
        command="bench",
        scene=scene,
        system=None,
        values=found,
        tables={name: _table(PARTS[name], rows) for name, rows in found.items()},
        summary={name: result for name, (result, _) in results.items()},
        pictures={name: drawn_by(f"bench.draw_{name}", rows) for name, rows in found.items()},
        cost=Cost(sum(m.impacts for m in ours), sum(m.evaluations for m in ours)),
        seconds=watch.seconds,
        notes=(*trouble, *[NO_HEYOKA] * absent),
        complete=not trouble,
        options={"part": part} if part else {},
    )


def plan(scene: Scene, part: str | None) -> dict[str, dict[str, Any]]:
    """How many runs a part has, and the seconds of all: at most, or about."""
    each = {name: _pieces(name, scene) for name in ([part] if part else PARTS)}
    return {name: {"runs": len(few), "seconds": most} for name, (few, _, most) in each.items()}


def _pieces(name: str, scene: Scene) -> tuple[Sequence, Callable, float]:
    """The pieces of a part, what measures one, and the seconds of all."""
    section = scene.bench
    if name == "stability":
        rows = list(stability.ROWS.values())
        return rows, partial(stability.measure, machines=machines()), PER_ROW * len(rows)
    points = precision.points(section.methods, section.quick)
    allowed = precision.QUICK_ALLOWED if section.quick else precision.ALLOWED
    repeats = 1 if section.quick else section.repeats
    measure = partial(precision.measure, machines=machines(), allowed=allowed, repeats=repeats)
    pieces = [(case, point) for case in section.cases for point in points]
    return pieces, measure, (allowed + repeats * precision.LONG) * len(pieces)


def _measured(name: str, scene: Scene, progress: Progress | None, work: Work) -> list:
    """A row for every piece, measured one after the other."""
    pieces, measure, _ = _pieces(name, scene)
    codec = Codec(lambda row: list(astuple(row)), lambda stored: PARTS[name](*stored))
    alone = replace(work.within(name), threads=1)
    return list(alone.collect(measure, pieces, codec, ticks(progress, name, len(pieces))))


def _table(kind: Any, rows: Sequence) -> Table:
    cells = [[_cell(value) for value in astuple(row)] for row in rows]
    return Table.of_rows([f.name for f in fields(kind)], lambda: cells)


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
