"""Critical speeds in a picture over speed: a numbered list, numbers above a panel, lines in it."""

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

if TYPE_CHECKING:  # a picture without events needs nothing of the explanations
    from camcli.analysis.explain.events import Event

SINGLE, MOST = 20, 44  # events in one column of the list, and in two
STEP, CROWDED = 24.0, 20  # px between two rows of numbers, numbers from which there are two
SMALL, LARGE = 20.0, 28.0  # px, from one number to the next, of one digit and of two
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
        joint = " " if words.endswith("corner") else " at " if self.source.corner.islower() else " "
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


def numbers_height(events: Sequence[Numbered]) -> int:
    """Pixels that the numbers above a panel need."""
    return 64 + round(STEP) * (len(events) > CROWDED) if events else 0


def draw_list(figure: Figure, top: int, events: Sequence[Numbered]) -> None:
    """The list, from `top` downwards."""
    if not events:
        return
    height = list_height(events)
    axes = style.place(figure, 0, top, style.WIDTH, height, frame_on=False)
    axes.set(xlim=(0, style.WIDTH), ylim=(height, 0), xticks=[], yticks=[])
    shown = [event for event in events if event.number is not None]
    columns = COLUMNS if len(shown) <= SINGLE else CLOSE
    if columns is COLUMNS and not any(event.verdict for event in shown):
        columns = COLUMNS[:-1]
    rows = (len(shown) + 1) // 2 if columns is CLOSE else len(shown)
    heads = ["no.", "event", "at (rpm)", "motion", "classification"]
    if columns is CLOSE and any(event.verdict for event in shown):
        heads[3] = "motion, classification"
    for begin in range(0, len(shown), rows):
        left = 0 if begin == 0 else style.WIDTH // 2
        _cells(axes, left, 0, columns, heads, {"color": style.CAM})
        for row, event in enumerate(shown[begin : begin + rows], 1):
            motion = style.motion(event.source.label, 44)
            cells = [str(event.number), event.name, event.speed, motion, event.verdict]
            if columns is CLOSE:
                cells[3:] = [", ".join(filter(None, cells[3:]))]
            _cells(axes, left, row, columns, cells, {})
    if len(events) > MOST:
        words = f"and {len(events) - MOST} more, drawn without a number, listed in run.json"
        axes.text(COLUMNS[0], height - 0.5 * style.LINE, words, va="center_baseline", size=7)


def _cells(axes: Axes, left: int, row: int, columns: Sequence[int], cells, look: dict) -> None:
    """One row; what is too long for its column is cut."""
    size, last = (7, style.WIDTH // 2) if columns is CLOSE else (8, style.WIDTH)
    ends = [*columns[1:], last]
    for begin, end, words in zip(columns, ends, cells, strict=False):
        at = (left + begin, (row + 0.5) * style.LINE)
        text = axes.text(*at, words, va="center_baseline", size=size, **look)
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


def draw_lines(axes: Axes, events: Sequence[Numbered]) -> None:
    """A dotted vertical line at every event in the range."""
    low, high = axes.get_xlim()
    for event in events:
        if low <= event.source.rpm <= high:
            look = {"color": style.CAM, "linewidth": 0.5, "linestyle": (0, (1, 2)), "zorder": 3}
            axes.axvline(event.source.rpm, **look)


def draw_numbers(axes: Axes, events: Sequence[Numbered], wide: int, tall: int) -> None:
    """The numbers above a panel, each with a line to its place; many in two rows."""
    low, high = axes.get_xlim()
    seen = [e for e in events if e.number is not None and low <= e.source.rpm <= high]
    crowded = len(seen) > CROWDED
    gap = (high - low) / wide * (LARGE / 2.0 if crowded else LARGE if len(seen) > 9 else SMALL)
    places = _inside(style.spread([e.source.rpm for e in seen], gap, low, high), gap, low, high)
    at = {"transform": axes.get_xaxis_transform(), "clip_on": False}
    text = {"ha": "center", "va": "bottom", "size": 7}
    for k, (event, place) in enumerate(zip(seen, places, strict=True)):
        up = STEP * (k % 2) if crowded else 0.0
        x = [event.source.rpm, event.source.rpm, place, place]
        y = [1.0 + rise / tall for rise in (0.0, 6.0, 24.0, 26.0 + up)]
        axes.plot(x, y, color=style.GUIDE, linewidth=0.5, **at)
        axes.text(place, 1.0 + (29.0 + up) / tall, str(event.number), **text, **at)


def _inside(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Ascending places at least a gap apart, pushed back into the range from both of its ends."""
    out = list(places)
    for ahead, step in ((range(1, len(out)), 1), (range(len(out) - 2, -1, -1), -1)):
        if step == -1 and out:
            out[-1] = min(out[-1], high)
        for k in ahead:
            beside = out[k - step] + step * gap
            out[k] = max(out[k], beside) if step == 1 else min(out[k], beside)
    return out
