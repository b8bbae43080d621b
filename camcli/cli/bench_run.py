"""What `cam bench` measures, writes and says."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, astuple, dataclass, field, fields, replace
from functools import cache, partial
from math import inf, isnan
from time import perf_counter
from typing import Any

from camcli.analysis.bench import flights, precision, scenes, stability
from camcli.analysis.bench.machine import Machines
from camcli.analysis.bench.pieces import FAILED, NOT_REACHED, OK, measured
from camcli.analysis.integrate import Cost
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request
from camcli.cli.report import progress_bar, table
from camcli.cli.run import compiling, given, open_folder
from camcli.errors import Fault, SceneError
from camcli.output.run_folder import RunFolder
from camcli.output.run_record import cost_record, run_record, to_text
from camcli.output.tables import Table
from camcli.scene import Scene, load_scene, resolved, scene_hash
from camcli.scene.bench import Bench

NAME = "bench"
POINTS, FLIGHTS, ROWS, SCENES = "points", "flights", "stability", "scenes"
# Seconds of what is measured, 570 s in all and 52 s where it is quick: what is missing to ten
# minutes and to one is for starting, drawing, and the one piece by which each may overrun.
FULL = {POINTS: 360.0, FLIGHTS: 30.0, ROWS: 80.0, SCENES: 100.0}
QUICK = {POINTS: 26.0, FLIGHTS: 4.0, ROWS: 11.0, SCENES: 11.0}
PER_FLIGHT = 3e-3  # s, with its judge; an estimate
QUICK_FLIGHTS = 100
PRECISION_CSV = tuple(f.name for f in fields(precision.Measured))
FLIGHTS_CSV = tuple(f.name for f in fields(flights.Flights))
STABILITY_CSV = tuple(f.name for f in fields(stability.Outcome))
SCENES_CSV = ("scene", "status", "seconds", "ratio", "compute_s", "modules", "heavy")


@cache
def machines() -> Machines:
    """The machines of the bench; their cams are validated like those of scenes."""
    from pydantic import TypeAdapter

    from camcli.scene import Cam

    cams: TypeAdapter[Any] = TypeAdapter(Cam)
    return Machines(lambda section: cams.validate_python(dict(section)))


@dataclass
class Run:
    """One run of the bench: what was asked, and what has been found so far."""

    request: Request
    section: Bench
    flights_named: bool = False  # so many flights were asked for on the command line
    folder: RunFolder = field(init=False)  # once it is open
    result: dict[str, Any] = field(default_factory=dict)
    trouble: list[str] = field(default_factory=list)  # a line per failure
    done: list[str] = field(default_factory=list)  # what was measured, in words
    cost: Cost = field(default_factory=Cost)  # of ours, one run of each point

    @property
    def repeats(self) -> int:
        """Timings of a point."""
        return 1 if self.section.quick else self.section.repeats

    @property
    def flights(self) -> int:
        """Random flights: fewer where it is quick, unless so many were asked for."""
        wanted, named = self.section.flights, self.flights_named
        return min(wanted, QUICK_FLIGHTS) if self.section.quick and not named else wanted

    def seconds(self, name: str) -> float:
        """Time of what is measured, at the most; inf for more flights than usual."""
        if name == FLIGHTS and self.flights > Bench.model_fields["flights"].default:
            return inf
        return (QUICK if self.section.quick else FULL)[name]

    def pieces(self, name: str) -> Sequence:
        """What there is to measure, in order."""
        if name == POINTS:
            points = precision.points(self.section.methods, self.section.quick)
            return [(case, point) for case in self.section.cases for point in points]
        if name == FLIGHTS:
            return flights.blocks(self.flights)
        if name == ROWS:
            return list(stability.ROWS.values())
        return list(scenes.QUICK if self.section.quick else scenes.SCENES)

    def plan(self, name: str) -> dict[str, float]:
        """Runs, and seconds at the most; of flights asked for: about."""
        count = self.flights if name == FLIGHTS else len(self.pieces(name))
        most = self.seconds(name)
        about = PER_FLIGHT * self.flights if most == inf else most
        return {"runs": count * (self.repeats if name == SCENES else 1), "seconds": about}

    def rows(self, name: str, kind: type, measure: Callable[..., list]) -> list:
        """Measure the pieces one after the other."""
        work = replace(self.folder.work.within(name), threads=1)
        pieces: Sequence = self.pieces(name)
        found: list = []
        with progress_bar(self.request.quiet) as progress:
            rows_of = measured(kind, measure, pieces, work, self.seconds(name))
            for done, rows in enumerate(rows_of, 1):
                found += rows
                if progress is not None:
                    progress(name, done, len(pieces))
        return found

    def write(self, name: str, columns: Sequence[str], rows: Sequence) -> None:
        """Write a table."""
        cells = ([_cell(value) for value in astuple(row)[: len(columns)]] for row in rows)
        self.folder.write_text(f"{name}.csv", Table.of_rows(columns, lambda: cells).csv())

    def draw(self, name: str, picture: Callable[[], Any]) -> None:
        """Write a picture, unless --no-plot."""
        if self.request.no_plot:
            return
        from camcli.output.pictures import write_png

        self.folder.write(f"{name}.png", partial(write_png, picture()))

    def show(self, title: str, columns: Sequence[str], rows: Iterable[Any]) -> None:
        """Print fields of dataclasses as a table, unless --json."""
        if not self.request.json:
            cells = [[_text(getattr(row, column)) for column in columns] for row in rows]
            table(title, [column.replace("_", " ") for column in columns], cells)

    def unreached(self, what: str, rows: Sequence) -> list[str]:
        """A line where the clock left no time for some."""
        count = sum(row.status == NOT_REACHED for row in rows)
        return [f"{what} not reached, time was up: {count} of {len(rows)}"] if count else []

    def count(self, what: str, rows: Sequence) -> None:
        """Say how many were measured."""
        count = sum(row.status not in (NOT_REACHED, precision.ABSENT) for row in rows)
        of = "" if count == len(rows) else f" of {len(rows)}"
        self.done.append(f"{count}{of} {what}")


def run(request: Request, part: str | None, quick: bool, flights: int | None) -> int:
    """Run the parts asked for and write their artefacts; returns the exit code."""
    if part is not None and part not in PARTS:
        expected = f"expected one of {', '.join(PARTS)}"
        raise SceneError(Fault("PART", "", f"found '{part}'", expected, "leave it out for all"))
    parts = tuple(PARTS) if part is None else (part,)
    for name, word in (("--rpm", request.rpm), ("--points", request.points)):
        if word is not None:
            found, cure = f"found {word}", "leave it out, or choose bench.cases"
            raise SceneError(Fault(name, "", found, "expected none: every case has its own", cure))
    values = given({"bench.quick": (quick, "--quick"), "bench.flights": (flights, "--flights")})
    scene = load_scene(request.config, request.sets or (), values)
    here = Run(request, scene.bench, flights is not None)
    if request.dry_run:
        plan = {name: here.plan(name) for part in parts for name in PARTS[part][1]}
        if request.json:
            print(json.dumps({"command": NAME, "plan": plan}, indent=2))
        else:
            lines = [[name, *map(_text, p.values())] for name, p in plan.items()]
            table("cam bench, planned", ["part", "runs", "seconds (at most)"], lines)
        return DONE
    began = perf_counter()
    with compiling(request), open_folder(NAME, scene, request) as folder:
        here.folder = folder
        for part in parts:
            PARTS[part][0](here)
        seconds = perf_counter() - began
        _finish(here, scene, folder, seconds, {} if len(parts) > 1 else {"part": parts[0]})
    for line in here.trouble:
        note(line)
    return NUMERICS if here.trouble else DONE


def _finish(
    here: Run, scene: Scene, folder: RunFolder, seconds: float, options: dict[str, Any]
) -> None:
    """Write run.json and say what was measured."""
    known, request = folder.resumed, here.request
    record = run_record(
        command=NAME,
        scene=resolved(scene),
        scene_sha256=scene_hash(scene),
        options={**options, "plot": not request.no_plot},
        cost=cost_record(here.cost, seconds, known),
        error={},
        result=here.result,
        artefacts=dict(folder.hashes),
    )
    text = to_text(record)
    folder.write_text("run.json", [text])
    folder.commit()
    if request.json:
        print(text, end="")
        return
    print(f"{folder.folder}/: {', '.join(folder.hashes)}")
    kept = f", {known} pieces of them from disk" if known else ""
    print(f"{', '.join(here.done)} in {seconds:.3g} s{kept}")


def _cell(value: Any) -> Any:
    """Text that needs no quotes, a number, or nothing."""
    if isinstance(value, str):
        return " ".join(value.replace(",", ";").replace('"', "'").split())
    return None if isinstance(value, float) and isnan(value) else value


def _text(value: Any) -> str:
    if value is None or (isinstance(value, float) and isnan(value)):
        return "-"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def run_precision(here: Run) -> None:
    """Work and precision of all methods on all cases, and the random flights."""
    most = precision.QUICK_ALLOWED if here.section.quick else precision.ALLOWED
    measure = partial(precision.measure, machines=machines(), most=most, repeats=here.repeats)
    found = here.rows(POINTS, precision.Measured, measure)
    flown = flights.total(
        here.rows(
            FLIGHTS, flights.Flights, lambda b, _, left: flights.fly_block(b, machines(), left)
        )
    )
    here.write("precision", PRECISION_CSV, found)
    here.write("flights", FLIGHTS_CSV, [flown])

    def picture():
        from camcli.plots.bench import draw_precision

        titles = {name: precision.case(name).title for name in here.section.cases}
        return draw_precision(found, titles)

    here.draw("precision", picture)
    ours, others = ([m for m in found if m.ours == own] for own in (True, False))
    here.cost = Cost(sum(m.impacts for m in ours), sum(m.evaluations for m in ours))
    here.count("points", found)
    here.done.append(f"{flown.flights} random flights")
    for m in (m for m in ours if m.status not in (OK, NOT_REACHED)):
        said = f"error {m.error:.2g} turns, {m.of_bound:.3g} times its bound at most"
        here.trouble.append(
            f"precision: {m.case}, {m.setting}: {m.status}: {said}, {m.missed} impacts missed"
        )
    here.trouble += here.unreached("precision: points of ours", ours)
    if flown.missed or flown.invented:
        here.trouble.append(
            f"precision: random flights: {flown.missed} contacts missed, {flown.invented} invented"
        )
    verdicts = precision.verdicts(found)
    tally = Counter((m.method, m.status) for m in found)
    here.result["precision"] = {
        "cases": [asdict(v) for v in verdicts],
        "points": [{"method": a, "status": b, "points": n} for (a, b), n in tally.items()],
        "failed": [f"{m.case}, {m.setting}: {m.status}" for m in ours if m.status != OK],
        "flights": [{k: v for k, v in asdict(flown).items() if k != "seconds"}],
    }
    here.show("Work and precision", [f.name for f in fields(precision.Verdict)], verdicts)
    here.show("Random flights", FLIGHTS_CSV, [flown])
    if not here.request.quiet:
        for line in here.unreached("precision: points of others", others):
            note(line)
        if flown.flights < flown.asked:
            note(f"precision: time was up after {flown.flights} of {flown.asked} random flights")
        if any(m.status == precision.ABSENT for m in found):
            note("heyoka is not installed, its points are left out: pip install 'camcli[bench]'")


def run_stability(here: Run) -> None:
    """The table of extreme cases."""

    def measure(row: stability.Row, _: float, left: float) -> list[stability.Outcome]:
        return stability.measure(row, machines(), left)

    found = here.rows(ROWS, stability.Outcome, measure)
    here.write("stability", STABILITY_CSV, found)

    def picture():
        from camcli.plots.bench import draw_stability

        return draw_stability(found)

    here.draw("stability", picture)
    here.count("extreme cases", found)
    for o in (o for o in found if o.status == FAILED):
        here.trouble.append(f"stability: row {o.case}: expected {o.expected}: {o.observed}")
    here.trouble += here.unreached("stability: rows", found)
    failed = [o.case for o in found if o.status != OK]
    here.result["stability"] = {"rows": len(found), "failed": failed}
    here.show("Extreme cases", ["case", "observed", "status", "seconds"], found)


def run_scenes(here: Run) -> None:
    """Time and modules of whole commands."""

    def measure(name: str, share: float, left: float) -> list[scenes.Scene]:
        return scenes.measure(name, here.repeats, share, left)

    found = scenes.with_ratios(here.rows(SCENES, scenes.Scene, measure))
    here.write("scenes", SCENES_CSV, found)
    here.count("commands", found)
    for s in (s for s in found if s.status == FAILED):
        here.trouble.append(f"scenes: {s.scene}: exit code {s.exit_code}")
    here.trouble += here.unreached("scenes: commands", found)
    here.result["scenes"] = [
        {
            "scene": s.scene,
            "words": scenes.SCENES[s.scene].split(),
            "status": s.status,
            "exit_code": s.exit_code,
            "ratio": None if isnan(s.ratio) else s.ratio,
            "modules": s.modules,
            "heavy": s.heavy.split(),
        }
        for s in found
    ]
    here.show("What a scene costs", SCENES_CSV, found)


PARTS = {
    "precision": (run_precision, (POINTS, FLIGHTS)),
    "stability": (run_stability, (ROWS,)),
    "scenes": (run_scenes, (SCENES,)),
}
