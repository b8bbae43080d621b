"""cam detach"""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

from camcli.analysis.contact_loss.bursts import RECORD
from camcli.analysis.contact_loss.detachment import SpeedStatus
from camcli.analysis.contact_loss.study import ContactLoss, detach
from camcli.analysis.integrate import Start
from camcli.analysis.sweep import rpm_grid
from camcli.cli.detach_words import show
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request
from camcli.cli.plan_starts import starts_planned
from camcli.cli.progress import bar
from camcli.cli.report import finish
from camcli.cli.setup import Setup, set_up, speed_range, timed
from camcli.errors import Fault, SceneError, Status
from camcli.output.detach import summary
from camcli.output.run_folder import RunFolder, run_folder
from camcli.output.tables import accumulation_csv, corner_hits_csv, detach_csv, force_csv
from camcli.scene import parse_rpm

NAME = "detach"


def run(request: Request) -> int:
    """Find where contact is lost and chatter ends, write the artefacts; returns the exit code."""
    setup = set_up(request, _options(request))
    section = setup.scene.detach.rpm
    settings = replace(
        setup.settings, transient=setup.scene.detach.settle, record=RECORD, start=Start()
    )
    setup = replace(setup, settings=settings)
    rpms = rpm_grid(section.start, section.stop, section.num)
    if starts_planned(NAME, request, setup, rpms, settings, "detach.rpm.num"):
        return DONE
    with run_folder(request.folder(NAME)) as store:
        with timed(request) as watch:
            result = _compute(request, setup, rpms)
        seconds = watch.seconds
        _write(request, setup, store, result)
        if not request.json:
            show(result)
        finish(NAME, request, setup, store, result.cost, seconds, summary(result))
        return _verdict(result)


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    """Scene values of --rpm, --points and --hold-to."""
    values = speed_range(request, "detach")
    if request.rpm is not None and not isinstance(parse_rpm(request.rpm), tuple):
        values["detach.force_rpm"] = ([parse_rpm(request.rpm)], "--rpm")
    asked = request.extra["hold_to"]
    if asked is not None:
        values["detach.hold_to"] = (_speed(asked), "--hold-to")
    return values


def _speed(text: str) -> float:
    try:
        rpm = parse_rpm(text)
    except SceneError as error:
        raise SceneError(*(replace(fault, where="--hold-to") for fault in error.faults)) from None
    if isinstance(rpm, tuple):
        found = f"found the range '{text}'"
        raise SceneError(Fault("--hold-to", "", found, "expected one speed", "give its top"))
    return rpm


def _compute(request: Request, setup: Setup, rpms: list[float]) -> ContactLoss:
    section = setup.scene.detach
    with nullcontext() if request.quiet else bar("speeds", len(rpms)) as tick:
        return detach(
            setup.system,
            rpms,
            setup.settings,
            settle=section.settle,
            impacts=section.impacts,
            force_rpm=section.force_rpm,
            hold_rpm=section.hold_to,
            margin=section.margin_n,
            precompression=section.precompression_m,
            on_speed=tick or (lambda: None),
        )


def _write(request: Request, setup: Setup, store: RunFolder, result: ContactLoss) -> None:
    store.write_text("detach.csv", detach_csv(result))
    store.write_text("accumulation.csv", accumulation_csv(result))
    store.write_text("corner_hits.csv", corner_hits_csv(result))
    store.write_text("force.csv", force_csv(result))
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.detach import draw_detach

    store.write("detach.png", partial(write_png, draw_detach(result, setup.system)))


def _verdict(result: ContactLoss) -> int:
    """Exit code 3 and a note where a speed or a simulation could not be settled."""
    for code in sorted({status for _, status in result.troubled}):
        rpms = [f"{rpm:.10g}" for rpm, status in result.troubled if status == code]
        shown = ", ".join(rpms[:5]) + (", ..." if len(rpms) > 5 else "")
        status = Status(code)
        note(f"{status.text} at {len(rpms)} speeds ({shown} rpm): {status.cause}; {status.cure}")
    unsafe = [c for c in result.critical_speeds if c.status is SpeedStatus.UNRESOLVED]
    for c in unsafe:
        note(f"{c.status}: {c.quantity} {c.region} near {c.rpm:.10g} rpm has no safe bracket")
    return NUMERICS if result.troubled or unsafe else DONE
