"""cam sweep"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from functools import partial
from typing import Any

from camcli.analysis.sweep import FIXED, Speed, Sweep, bare, rpm_grid, status_name, sweep
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.long_run import long_run
from camcli.cli.options import Request
from camcli.cli.plan_sweep import sweep_planned
from camcli.cli.progress import bar
from camcli.cli.report import finish, table, warn_of_height
from camcli.cli.setup import Setup, set_up, speed_range, timed
from camcli.errors import Fault, SceneError, Status
from camcli.output.run_folder import RunFolder
from camcli.output.tables import (
    IMPACTS,
    STROBE,
    impacts_csv,
    section_rows,
    speeds_csv,
    strobe_csv,
)
from camcli.parallel import Work

NAME = "sweep"
SHOWN = 40  # rows of the table on stdout


def run(request: Request) -> int:
    """Sweep a range of speeds and write its artefacts; returns the exit code."""
    setup = set_up(request, _options(request))
    section = setup.scene.sweep
    _refuse_to_explain(setup)
    if sweep_planned(request, setup):
        return DONE
    rpms = rpm_grid(section.rpm.start, section.rpm.stop, section.rpm.num)
    with long_run(NAME, request, setup) as store:
        result, seconds = _compute(request, setup, rpms, store.work)
        _finish(request, setup, store, result, seconds)
        if not request.quiet:
            warn_of_height(_heights(result), setup.system.cam.top)
        return _verdict(result)
    return DONE  # of a shard


def _finish(
    request: Request, setup: Setup, store: RunFolder, result: Sweep, seconds: float
) -> None:
    """Write everything and say it."""
    if setup.scene.sweep.explain:
        from camcli.cli.sweep_explain import finish_explained

        finish_explained(request, setup, store, result, seconds)
        return
    write(request, setup, store, result)
    if not request.json:
        show(result)
    found, known = summary(result), store.resumed
    finish(NAME, request, setup, store, result.cost, seconds, found, from_disk=known)


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    values = speed_range(request, NAME)
    for name in ("lyapunov", "explain"):
        if request.extra[name]:
            values[f"sweep.{name}"] = (True, f"--{name}")
    return values


def _refuse_to_explain(setup: Setup) -> None:
    """Raise SceneError where there are no changes that a fixed start could explain."""
    section = setup.scene.sweep
    if not section.explain:
        return
    if section.direction != FIXED:
        cure = "leave --explain out, or set sweep.direction=fixed"
        found = f"found {section.direction}"
        raise SceneError(Fault("--explain", "sweep.direction", found, "expected fixed", cure))
    if section.rpm.num < 2:
        found = f"found one speed, {section.rpm.start!r}"
        cure = "give --rpm LO:HI and --points"
        raise SceneError(Fault("--explain", "sweep.rpm", found, "expected a range", cure))


def _compute(request: Request, setup: Setup, rpms: list[float], work: Work):
    """(sweep, seconds)."""
    sections = setup.scene.sweep.sections
    progress = nullcontext() if request.quiet else bar("speeds", len(rpms))
    with timed(request) as watch, progress as tick:
        result = sweep(
            setup.system,
            rpms,
            setup.settings,
            direction=setup.scene.sweep.direction,
            impacts="impacts" in sections,
            strobe="strobe" in sections,
            lyapunov=setup.scene.sweep.lyapunov,
            work=work,
            on_speed=(lambda speed: None) if tick is None else (lambda speed: tick()),
        )
    return result, watch.seconds


def write(request: Request, setup: Setup, store: RunFolder, result: Sweep, events=None) -> None:
    """Write the tables and the picture, with the events in it where they are given."""
    for section in ("impacts", "strobe"):
        _write_section(setup, store, section, result)
    store.write_text("speeds.csv", speeds_csv(result))
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.sweep import draw_sweep

    figure = draw_sweep(result, setup.system, setup.settings, events or ())
    store.write("sweep.png", partial(write_png, figure))


def _write_section(setup: Setup, store: RunFolder, section: str, result: Sweep) -> None:
    """A section's table in the form asked for."""
    form = setup.scene.sweep.tables if section in setup.scene.sweep.sections else "none"
    if form == "csv":
        text = impacts_csv if section == "impacts" else strobe_csv
        store.write_text(f"{section}.csv", text(result))
    elif form == "npz":
        from camcli.output.bulk import write_npz

        names = IMPACTS if section == "impacts" else STROBE
        rows = partial(section_rows, result, section)
        store.write(f"{section}.npz", partial(write_npz, names, rows))


def summary(result: Sweep) -> dict:
    """The result of run.json."""
    return {
        "direction": result.direction,
        "ranges": [
            {"label": label, "status": status, "from_rpm": a.rpm, "to_rpm": b.rpm, "speeds": n}
            for label, status, a, b, n in _ranges(result)
        ],
    }


def _ranges(result: Sweep) -> list[tuple[str, str, Speed, Speed, int]]:
    """(label, status, first, last, count) of consecutive speeds of one label and status."""
    found: list[tuple[str, str, Speed, Speed, int]] = []
    for speed in map(bare, result.speeds):
        key = (speed.label, status_name(speed.status))
        if found and found[-1][:2] == key:
            found[-1] = (*key, found[-1][2], speed, found[-1][4] + 1)
        else:
            found.append((*key, speed, speed, 1))
    return found


def show(result: Sweep) -> None:
    """Print the ranges of one label."""
    ranges = _ranges(result)
    rows = [
        [label, f"{a.rpm:.10g}", f"{b.rpm:.10g}", str(n), status]
        for label, status, a, b, n in ranges
    ]
    title = f"{len(result.speeds)} speeds, {len(ranges)} ranges of one label"
    if len(rows) > SHOWN:
        title += f", the first {SHOWN} (all of them in speeds.csv)"
    table(title, ["label", "from (rpm)", "to (rpm)", "speeds", "status"], rows[:SHOWN])


def _heights(result: Sweep) -> Iterator[tuple[float, float]]:
    """(rpm, largest q at the strobe, m)."""
    for speed in result.speeds:
        if speed.strobe is not None:
            yield speed.rpm, max(speed.strobe[1], default=0.0)


def _verdict(result: Sweep) -> int:
    """Exit code 3 and a note per kind of trouble, with the speeds it happened at."""
    troubled = result.troubled
    for code in sorted({speed.status for speed in troubled}):
        rpms = [f"{speed.rpm:.10g}" for speed in troubled if speed.status == code]
        shown = ", ".join(rpms[:5]) + (", ..." if len(rpms) > 5 else "")
        status = Status(code)
        note(f"{status.text} at {len(rpms)} speeds ({shown} rpm): {status.cause}; {status.cure}")
    return NUMERICS if troubled else DONE
