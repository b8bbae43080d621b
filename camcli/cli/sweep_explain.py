"""cam sweep --explain: classify the speeds of a sweep, and say why its diagram changes."""

from __future__ import annotations

from contextlib import nullcontext

from camcli.analysis.classify import Motion, classify_at
from camcli.analysis.explain.changes import explain
from camcli.analysis.labels import LONGEST_PERIOD
from camcli.analysis.sweep import Sweep
from camcli.cli.classify_words import show_explanation
from camcli.cli.options import Request
from camcli.cli.progress import bar
from camcli.cli.report import finish
from camcli.cli.setup import Setup, timed
from camcli.cli.sweep import NAME, show, summary, write
from camcli.kernel import backend
from camcli.output.classify import corners_csv
from camcli.output.explanations import explained
from camcli.output.run_folder import RunFolder
from camcli.parallel import in_threads


def finish_explained(
    request: Request, setup: Setup, store: RunFolder, result: Sweep, seconds: float
) -> None:
    """Explain a sweep, write all its artefacts and print its tables."""
    with timed(request) as watch:
        motions = _motions(request, setup, [speed.rpm for speed in result.speeds])
        with nullcontext() if request.quiet else bar("changes", len(motions) - 1) as tick:
            explanation = explain(setup.system, setup.settings, motions, tick or (lambda: None))
    seconds += watch.seconds
    store.write_text("corners.csv", corners_csv(explanation.bifurcations))
    write(request, setup, store, result, explanation.events)
    if not request.json:
        show(result)
        show_explanation(explanation)
    cost = sum((motion.cost for motion in motions), result.cost + explanation.cost)
    words = {**summary(result), **explained(explanation)}
    known = store.resumed
    finish(NAME, request, setup, store, cost, seconds, words, from_disk=known)


def _motions(request: Request, setup: Setup, rpms: list[float]) -> list[Motion]:
    """The motion from the scene's start at every speed, in order."""
    settings = setup.settings
    turns = len(rpms) * (settings.transient + max(settings.record, 2 * LONGEST_PERIOD))
    backend.for_work(turns)

    def piece(rpm: float) -> Motion:
        return classify_at(setup.system, rpm, settings)

    motions = []
    with nullcontext() if request.quiet else bar("motions", len(rpms)) as tick:
        for motion in in_threads(piece, rpms, request.threads):
            motions.append(motion)
            if tick:
                tick()
    return motions
