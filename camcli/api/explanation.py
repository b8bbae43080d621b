"""Why a diagram changes: the study of classify and sweep, its record and its table."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.kinds import Kind
from camcli.api.machine import Machine
from camcli.api.result import Progress, budget_of, ticks
from camcli.api.rows import CORNERS, bifurcation_row
from camcli.errors import Status
from camcli.output.tables import Table
from camcli.piece_faults import piece

if TYPE_CHECKING:
    from camcli.analysis.classify import ClassifiedMotion
    from camcli.analysis.explain.changes import Explanation


def explanation_of(
    machine: Machine, motions: list[ClassifiedMotion], progress: Progress | None
) -> Explanation:
    """The changes of the motion from the scene's own start, as far as run.work_budget goes.

    Between neighbours of which something is known: a speed that failed is left out.
    """
    from camcli.analysis.explain.changes import Explanation, explain

    from_start = [m for m in motions if m.start == machine.settings.start and m.fault is None]
    if len(from_start) < 2:
        return Explanation([], [], [], Cost())
    on_change = ticks(progress, "changes", len(from_start) - 1)
    with budget_of(machine.scene, progress) as budget:
        explanation = piece(
            "the explanation",
            lambda: explain(machine.system, machine.settings, from_start, on_change),
            None,
        )
    if explanation is None:  # an unforeseen exception has cost it
        return Explanation([], [], [], Cost(), Status.FAULT)
    return replace(explanation, status=budget.status)


def explained(explanation: Explanation) -> dict[str, Any]:
    """What run.json keeps of an explanation: status, events and changes, in sentences too."""
    from camcli.words.explanations import change_sentence, event_sentence

    return {
        "status": explanation.status.text,
        "events": [
            {
                "rpm": event.rpm,
                "error": event.error,
                "kind": event.kind,
                "label": event.label,
                "corner": event.corner,
                "classification": event.classification,
                "status": event.status,
                "words": event_sentence(event),
            }
            for event in explanation.events
        ],
        "changes": [
            {
                "from_rpm": change.low,
                "to_rpm": change.high,
                "before": change.before,
                "after": change.after,
                "cause": change.cause,
                "words": change_sentence(change, explanation.events),
            }
            for change in explanation.changes
        ],
    }


def corners_table(explanation: Explanation | None) -> Table:
    """corners.csv: corner impacts of the followed branches."""
    bifurcations = [] if explanation is None else explanation.bifurcations
    corners = [b for b in bifurcations if b.kind == Kind.CORNER_IMPACT]
    return Table.of_rows(CORNERS.names(), lambda: (bifurcation_row(b, "rpm") for b in corners))
