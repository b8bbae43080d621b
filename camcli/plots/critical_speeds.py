"""Critical speeds in a picture over speed: numbered above the panels, listed below the heading."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import TYPE_CHECKING

from camcli.plots.picture import Rows
from camcli.words.in_print import label_text

if TYPE_CHECKING:  # a picture without events needs nothing of the explanations
    from camcli.analysis.explain.changes import CriticalEvent

SINGLE, MOST = 20, 44  # events in one list, and in two
MINOR = ("corner-hit", "accumulation-at-corner", "itinerary")  # change no attractor's kind
LONG, SHORT = 40, 16  # letters of a motion in one list, and in one of two

Numbered = tuple[int | None, "CriticalEvent"]


def numbered(events: Sequence[CriticalEvent]) -> list[Numbered]:
    """In ascending order; beyond MOST, the last of the minor ones stay without a number."""
    order = sorted(events, key=lambda event: event.rpm)
    chosen = {id(event) for event in sorted(order, key=lambda e: e.kind in MINOR)[:MOST]}
    number = count(1)
    return [(next(number) if id(event) in chosen else None, event) for event in order]


def event_lists(events: Sequence[Numbered]) -> list[Rows]:
    """Number, name, speed, motion and classification of the numbered ones, in one list or two."""
    if not events:
        return []
    from camcli.words.explanations import event_name, event_speed, unnumbered

    shown = [(number, event) for number, event in events if number is not None]
    one = len(shown) <= SINGLE
    rows = []
    for number, event in shown:
        status = "" if event.status == "ok" else event.status
        said = ", ".join(filter(None, (event.classification.replace("-", " "), status)))
        motion = label_text(event.label, LONG if one else SHORT)
        rows.append([str(number), event_name(event), event_speed(event), motion, said])
        if not one:
            rows[-1][3:] = [", ".join(filter(None, rows[-1][3:]))[:24]]
    if not rows:
        return []
    head = ["", "event", "rpm", "motion"] + [""] * one
    half = len(rows) if one else (len(rows) + 1) // 2
    lists: list[Rows] = [[head, *rows[k : k + half]] for k in range(0, len(rows), half)]
    if len(events) > len(rows):
        lists.append([[unnumbered(len(events) - len(rows))]])
    return lists
