"""cam bench"""

from __future__ import annotations

import json
from time import perf_counter
from typing import Any

from camcli.analysis.bench.clock import Schedule
from camcli.cli.bench_parts import run_precision, run_scenes, run_stability
from camcli.cli.bench_run import Plan, Run
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.long_run import working
from camcli.cli.options import Request
from camcli.cli.report import finish, table
from camcli.cli.setup import set_up
from camcli.errors import Fault, SceneError

NAME = "bench"
PARTS = {"precision": run_precision, "stability": run_stability, "scenes": run_scenes}


def run(request: Request) -> int:
    """Run the parts asked for and write their artefacts; returns the exit code."""
    parts = _parts(request)
    setup = set_up(request, _options(request))
    plan = Plan(setup.scene.bench, parts, request.extra["flights"] is not None)
    if request.dry_run:
        _show_plan(request, plan)
        return DONE
    began = perf_counter()
    with working(NAME, request, setup) as desk:
        here = Run(request, plan, desk, Schedule(plan.seconds))
        for part in parts:
            PARTS[part](here)
        seconds, known = perf_counter() - began, desk.journal.found
        found = here.result
        finish(NAME, request, setup, desk.store, here.cost, seconds, found, False, known)
    if not request.json:
        kept = f", {known} pieces of them from disk" if known else ""
        print(f"{', '.join(here.done)} in {seconds:.3g} s{kept}")
    for line in here.trouble:
        note(line)
    return NUMERICS if here.trouble else DONE


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    """Scene values of this command's options; a speed is refused, every case has its own."""
    for name, given in (("--rpm", request.rpm), ("--points", request.points)):
        if given is not None:
            found, cure = f"found {given}", "leave it out, or choose bench.cases"
            raise SceneError(Fault(name, "", found, "expected none: every case has its own", cure))
    values: dict[str, tuple[Any, str]] = {}
    if request.extra["quick"]:
        values["bench.quick"] = (True, "--quick")
    if request.extra["flights"] is not None:
        values["bench.flights"] = (request.extra["flights"], "--flights")
    return values


def _parts(request: Request) -> tuple[str, ...]:
    part = request.extra["part"]
    if part is None:
        return tuple(PARTS)
    if part not in PARTS:
        expected = f"expected one of {', '.join(PARTS)}"
        raise SceneError(Fault("PART", "", f"found '{part}'", expected, "leave it out for all"))
    return (part,)


def _show_plan(request: Request, plan: Plan) -> None:
    """Print what would be done, as a table or as one JSON object."""
    planned = plan.table()
    if request.json:
        print(json.dumps({"command": NAME, "plan": planned}, indent=2))
        return
    rows = [[part, str(p["runs"]), f"{p['seconds']:.3g}"] for part, p in planned.items()]
    table("cam bench, planned", ["part", "runs", "seconds (at most)"], rows)
