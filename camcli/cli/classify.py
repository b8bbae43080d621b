"""cam classify"""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial
from typing import Any

from camcli.analysis.classify import Motion, classify
from camcli.analysis.explain.changes import Explanation, explain
from camcli.analysis.integrate import Cost
from camcli.analysis.sweep import rpm_grid
from camcli.cli.classify_words import show, summary
from camcli.cli.exit_codes import DONE, NUMERICS, note
from camcli.cli.options import Request
from camcli.cli.plan_classify import classify_planned
from camcli.cli.progress import bar
from camcli.cli.report import finish
from camcli.cli.setup import Setup, set_up, speed_range, timed
from camcli.errors import Fault, SceneError, Status
from camcli.output.classify import classify_csv, corners_csv
from camcli.output.run_folder import RunFolder, run_folder

NAME = "classify"


def run(request: Request) -> int:
    """Classify every speed, explain the changes if asked, write the artefacts."""
    if request.extra["trace"] is not None or request.extra["det"] is not None:
        from camcli.cli.border import run as calculate

        return calculate(request)
    setup = set_up(request, _options(request))
    section = setup.scene.classify
    if section.explain and section.rpm.num < 2:
        found = f"found one speed, {section.rpm.start!r}"
        cure = "give --rpm LO:HI and --points"
        raise SceneError(Fault("--explain", "classify.rpm", found, "expected a range", cure))
    if classify_planned(request, setup):
        return DONE
    rpms = rpm_grid(section.rpm.start, section.rpm.stop, section.rpm.num)
    with run_folder(request.folder(NAME)) as store:
        with timed(request) as watch:
            motions = _classify(request, setup, rpms)
            explanation = _explain(request, setup, motions) if section.explain else None
        seconds = watch.seconds
        _write(request, setup, store, motions, explanation)
        if not request.json:
            show(motions, explanation)
        cost = sum((m.cost for m in motions), explanation.cost if explanation else Cost())
        finish(NAME, request, setup, store, cost, seconds, summary(motions, explanation))
        return _verdict(motions)


def _options(request: Request) -> dict[str, tuple[Any, str]]:
    values = speed_range(request, NAME)
    for name in ("starts", "seed"):
        if request.extra[name] is not None:
            values[f"classify.{name}"] = (request.extra[name], f"--{name}")
    if request.extra["explain"]:
        values["classify.explain"] = (True, "--explain")
    return values


def _classify(request: Request, setup: Setup, rpms: list[float]) -> list[Motion]:
    """Motions of all speeds, in the order of the speeds."""
    section, settings = setup.scene.classify, setup.settings
    with nullcontext() if request.quiet else bar("speeds", len(rpms)) as tick:
        return classify(
            setup.system, settings, rpms, section.starts, section.seed, request.threads,
            tick or (lambda: None),
        )  # fmt: skip


def _explain(request: Request, setup: Setup, motions: list[Motion]) -> Explanation:
    """The changes of the motion from the scene's own start."""
    own = [m for m in motions if m.start == setup.settings.start]
    with nullcontext() if request.quiet else bar("changes", max(1, len(own) - 1)) as tick:
        return explain(setup.system, setup.settings, own, tick or (lambda: None))


def _write(request, setup: Setup, store: RunFolder, motions, explanation) -> None:
    store.write_text("classify.csv", classify_csv(motions))
    found = [] if explanation is None else explanation.bifurcations
    store.write_text("corners.csv", corners_csv(found))
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.classify import draw_classify

    events = [] if explanation is None else explanation.events
    figure = draw_classify(motions, setup.system, events)
    store.write("classify.png", partial(write_png, figure))


def _verdict(motions: list[Motion]) -> int:
    """Exit code 3 and a note where a record ended early."""
    troubled = [m for m in motions if m.status != Status.OK]
    for code in sorted({m.status for m in troubled}):
        rpms = [f"{m.rpm:.10g}" for m in troubled if m.status == code]
        shown = ", ".join(rpms[:5]) + (", ..." if len(rpms) > 5 else "")
        status = Status(code)
        note(f"{status.text} at {len(rpms)} speeds ({shown} rpm): {status.cause}; {status.cure}")
    return NUMERICS if troubled else DONE
