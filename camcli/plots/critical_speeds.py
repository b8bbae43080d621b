"""Critical speeds in a picture over speed: numbered above the panels, listed below the heading."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from math import floor, isfinite, log10
from typing import TYPE_CHECKING

from camcli.plots import style
from camcli.plots.picture import Rows

if TYPE_CHECKING:  # a picture without events needs nothing of the explanations
    from camcli.analysis.explain.changes import Event

SINGLE, MOST = 20, 44  # events in one list, and in two
MINOR = ("corner-hit", "accumulation-at-corner", "itinerary")  # change no attractor's kind
DIGITS = 9
LONG, SHORT = 40, 16  # letters of a motion in one list, and in one of two

Numbered = tuple[int | None, "Event"]


def numbered(events: Sequence[Event]) -> list[Numbered]:
    """In ascending order; beyond MOST, the last of the minor ones stay without a number."""
    order = sorted(events, key=lambda event: event.rpm)
    chosen = {id(event) for event in sorted(order, key=lambda e: e.kind in MINOR)[:MOST]}
    number = count(1)
    return [(next(number) if id(event) in chosen else None, event) for event in order]


def event_lists(events: Sequence[Numbered]) -> list[Rows]:
    """Number, name, speed, motion and classification of the numbered ones, in one list or two."""
    shown = [(number, event) for number, event in events if number is not None]
    one = len(shown) <= SINGLE
    rows = []
    for number, event in shown:
        status = "" if event.status == "ok" else event.status
        said = ", ".join(filter(None, (event.classification.replace("-", " "), status)))
        motion = style.motion(event.label, LONG if one else SHORT)
        rows.append([str(number), event_name(event), event_speed(event), motion, said])
        if not one:
            rows[-1][3:] = [", ".join(filter(None, rows[-1][3:]))[:24]]
    if not rows:
        return []
    head = ["", "event", "rpm", "motion"] + [""] * one
    half = len(rows) if one else (len(rows) + 1) // 2
    lists: list[Rows] = [[head, *rows[k : k + half]] for k in range(0, len(rows), half)]
    if len(events) > len(rows):
        more = f"and {len(events) - len(rows)} more, drawn without a number, listed in run.json"
        lists.append([[more]])
    return lists


def event_name(event: Event) -> str:
    """Period doubling, corner impact at b, ..."""
    words = event.kind.replace("-", " ").replace("+", ", ")
    if not event.corner:
        return words
    is_region = not event.corner.islower()
    return words + (" " if is_region or words.endswith("corner") else " at ") + event.corner


def event_speed(event: Event) -> str:
    """To DIGITS digits; fewer, with its error, where it is less certain."""
    whole = 1 + floor(log10(event.rpm)) if event.rpm > 0.0 else 1
    decimals = max(0, DIGITS - whole)
    if not isfinite(event.error) or event.error < 10.0**-decimals:
        return f"{event.rpm:.{decimals}f}"
    decimals = max(0, -floor(log10(event.error)))
    return f"{event.rpm:.{decimals}f} ± {event.error:.{decimals}f}"
