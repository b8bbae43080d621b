"""Critical speeds in a picture over speed: numbered, and listed below its heading."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from math import floor, isfinite, log10
from typing import TYPE_CHECKING

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from camcli.plots import style
from camcli.plots.axes import event_lines, event_numbers, row_middle, text_row, text_rows

if TYPE_CHECKING:  # a picture without events needs nothing of the explanations
    from camcli.analysis.explain.events import Event

SINGLE, MOST = 20, 44  # events in one column of the list, and in two
MINOR = ("corner-hit", "accumulation-at-corner", "itinerary")  # change no attractor's kind
COLUMNS = (20, 60, 345, 600, 890)  # px: number, event, speed, motion, classification
CLOSE = (20, 58, 316, 462)  # px, in one of two columns; the last holds what is left
DIGITS = 9


@dataclass(frozen=True)
class Numbered:
    """An event with its number in the picture; none where there are too many."""

    number: int | None
    source: Event

    @property
    def name(self) -> str:
        """Period doubling, corner impact at b, ..."""
        words = self.source.kind.replace("-", " ").replace("+", ", ")
        if not self.source.corner:
            return words
        is_region = not self.source.corner.islower()
        joint = " " if is_region or words.endswith("corner") else " at "
        return words + joint + self.source.corner

    @property
    def speed(self) -> str:
        """To DIGITS digits; fewer, with its error, where it is less certain."""
        rpm, error = self.source.rpm, self.source.error
        whole = 1 + floor(log10(rpm)) if rpm > 0.0 else 1
        decimals = max(0, DIGITS - whole)
        if not isfinite(error) or error < 10.0**-decimals:
            return f"{rpm:.{decimals}f}"
        decimals = max(0, -floor(log10(error)))
        return f"{rpm:.{decimals}f} ± {error:.{decimals}f}"

    @property
    def verdict(self) -> str:
        """Classification, and the status where it is not ok."""
        status = "" if self.source.status == "ok" else self.source.status
        return ", ".join(filter(None, (self.source.classification.replace("-", " "), status)))


def numbered(events: Sequence[Event]) -> list[Numbered]:
    """In ascending order; beyond MOST, the last of the minor ones stay without a number."""
    order = sorted(events, key=lambda event: event.rpm)
    minor = sorted(order, key=lambda event: event.kind in MINOR)
    chosen = {id(event) for event in minor[:MOST]}
    number = count(1)
    return [Numbered(next(number) if id(event) in chosen else None, event) for event in order]


def list_height(events: Sequence[Numbered]) -> int:
    """Pixels that the list needs."""
    if not events:
        return 0
    shown = min(len(events), MOST)
    rows = shown if shown <= SINGLE else (shown + 1) // 2
    return style.LINE * (1 + rows + (len(events) > MOST))


def draw_list(figure: Figure, top: int, events: Sequence[Numbered]) -> None:
    """The list, from `top` downwards: in one column, or in two where they are many."""
    if not events:
        return
    axes = text_rows(figure, top, list_height(events) // style.LINE)
    shown = [event for event in events if event.number is not None]
    verdicts = any(event.verdict for event in shown)
    close = len(shown) > SINGLE
    rows = (len(shown) + 1) // 2 if close else len(shown)
    columns = CLOSE if close else COLUMNS if verdicts else COLUMNS[:-1]
    heads = ["no.", "event", "at (rpm)", "motion", "classification"]
    if close and verdicts:
        heads[3] = "motion, classification"
    for begin in range(0, len(shown), rows):
        left = 0 if begin == 0 else style.WIDTH // 2
        _cells(axes, left, 0, columns, heads, style.CAM)
        for row, event in enumerate(shown[begin : begin + rows], 1):
            motion = style.motion(event.source.label, 44)
            cells = [str(event.number), event.name, event.speed, motion, event.verdict]
            if close:
                cells[3:] = [", ".join(filter(None, cells[3:]))]
            _cells(axes, left, row, columns, cells)
    if len(events) > MOST:
        words = f"and {len(events) - MOST} more, drawn without a number, listed in run.json"
        axes.text(COLUMNS[0], row_middle(1 + rows), words, va="center_baseline", size=7)


def _cells(
    axes: Axes, left: int, row: int, columns: Sequence[int], cells: Sequence[str], colour="black"
) -> None:
    """One row; what is too long for its column is cut."""
    size, last = (7, style.WIDTH // 2) if columns is CLOSE else (8, style.WIDTH)
    texts = text_row(axes, row, [left + x for x in columns], cells, size=size, color=colour)
    for text, begin, end in zip(texts, columns, [*columns[1:], last], strict=False):
        _fit(text, end - begin - 6)


def _fit(text: Text, room: float) -> None:
    """Cut a text on one line to so many pixels."""
    words, wide = text.get_text(), text.get_window_extent().width
    if wide <= room:
        return
    words = words[: 2 + int(len(words) * room / wide)]
    while len(words) > 1 and text.get_window_extent().width > room:
        words = words[:-1]
        text.set_text(words.rstrip(":;, ") + "…")


def draw_events(axes: Axes, events: Sequence[Numbered], numbers: bool) -> None:
    """A line at every event in a panel, and the numbers above it."""
    event_lines(axes, [event.source.rpm for event in events])
    if numbers:
        pairs = [(event.number, event.source.rpm) for event in events]
        event_numbers(axes, [(number, rpm) for number, rpm in pairs if number is not None])
