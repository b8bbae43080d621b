"""What several pictures draw: corners, events, legends, lists, the cam's curves, forces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import MultipleLocator

from camcli.cams.compile import column
from camcli.kernel.cam_table import PIECE, TERMS, Cam
from camcli.plots import style
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.force import ForceCurve

TURN_DEG = 360.0
NARROW_DEG = 120.0  # impact phases within less are shown enlarged
DOTTED, DASHED = (0, (1, 2)), (0, (3.2, 1.6))
FORCE_LINES = ("-", (0, (5, 1.5)), (0, (1.5, 1)), (0, (5, 1.2, 1.2, 1.2)))
LOST = ("X", style.TROUBLE, "white", 6.0)
MARKS = {  # event: marker, face, edge, size
    "impact": ("o", style.IMPACT, "none", 2.0),
    "chatter": ("^", style.CHATTER, "white", 6.5),
    "chatter-completion": ("^", style.CHATTER, "white", 6.5),
    "detachment": ("D", style.DETACHMENT, "white", 5.5),
    "departure": ("d", "white", style.DETACHMENT, 5.5),
    "period-doubling": ("s", "white", style.IMPACT, 4.0),
    "fold": ("<", "white", style.IMPACT, 5.0),
    "corner-impact": ("o", "white", style.IMPACT, 4.4),
    "grazing": ("v", "white", style.IMPACT, 5.0),
}


# --- ranges and ticks


def padded(values: np.ndarray, constant: float) -> tuple[float, float]:
    """Range of the values with a margin; `constant` on either side where they do not vary."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        return low - constant, high + constant
    return low - 0.04 * (high - low), high + 0.04 * (high - low)


def phase_range(values: np.ndarray) -> tuple[float, float]:
    """Phases to show, degrees: those of the impacts where they are close, else the whole turn."""
    low, high = padded(values, 5.0)
    if not len(values) or high - low > NARROW_DEG:
        return 0.0, TURN_DEG
    return max(low, 0.0), min(high, TURN_DEG)


def phase_axis(axes: Axes, low: float, high: float) -> None:
    """Phases upwards, a tick every 60 degrees of a whole turn."""
    axes.set_ylim(low, high)
    if (low, high) == (0.0, TURN_DEG):
        axes.yaxis.set_major_locator(MultipleLocator(60))


def at_strobe(system: System) -> str:
    """The phase of the stroboscopic section."""
    return rf"$\theta$ = {style.number(round(system.strobe_deg, 9))} deg"


def spread(values: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Ascending positions moved apart to at least `gap`, each group centred, within the range."""
    gap = min(gap, (high - low) / max(1, len(values) - 1))
    groups: list[list[float]] = []

    def begin(group: list[float]) -> float:
        return sum(group) / len(group) - gap * (len(group) - 1) / 2.0

    for value in values:
        groups.append([value])
        while len(groups) > 1 and begin(groups[-1]) < begin(groups[-2]) + gap * len(groups[-2]):
            groups[-2:] = [groups[-2] + groups[-1]]
    places = [begin(group) + k * gap for group in groups for k in range(len(group))]
    last = len(places) - 1
    return [min(max(x, low + k * gap), high - (last - k) * gap) for k, x in enumerate(places)]


# --- corners and events


def corners_upwards(axes: Axes, corners: Iterable[tuple[str, float]], named: bool = True) -> None:
    """Corners of the cam as lines in a panel with phases upwards, named at its right edge."""
    low, high = axes.get_ylim()
    seen = sorted((phase, name) for name, phase in corners if low <= phase <= high)
    for phase, _ in seen:
        axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
    if named:
        gap = 24.0 * (high - low) / axes.get_window_extent().height
        places = spread([phase for phase, _ in seen], gap, low, high)
        for (_, name), place in zip(seen, places, strict=True):
            at = axes.get_yaxis_transform()
            axes.text(1.012, place, name, va="center_baseline", color=style.CAM, transform=at)


def corners_across(
    axes: Axes, corners: Iterable[tuple[str, float]], named: bool = True, inside: bool = False
) -> None:
    """Corners as dotted lines in a panel with phases to the right, named at or above its top."""
    low, high = axes.get_xlim()
    seen = sorted((phase, name) for name, phase in corners if low <= phase <= high)
    for phase, _ in seen:
        axes.axvline(phase, color=style.GUIDE, linewidth=0.6, linestyle=DOTTED, zorder=0.5)
    if named:
        gap = 18.0 * (high - low) / axes.get_window_extent().width
        places = spread([phase for phase, _ in seen], gap, low, high)
        y, va = (0.985, "top") if inside else (1.015, "bottom")
        for (_, name), x in zip(seen, places, strict=True):
            at = axes.get_xaxis_transform()
            axes.text(x, y, name, ha="center", va=va, color=style.CAM, transform=at)


def mark(axes: Axes, kind: str, x: Any, y: Any, **more: Any) -> None:
    """The mark of an event, or of a place where something could not be followed."""
    marker, face, edge, size = MARKS.get(kind, LOST)
    more = {"zorder": 6, "mew": 0.5 if edge == "white" else 0.8, **more}
    axes.plot(x, y, marker, ms=size, mfc=face, mec=edge, **more)


def event_lines(axes: Axes, values: Iterable[float]) -> None:
    """A dotted vertical line at every event in the range."""
    low, high = axes.get_xlim()
    for value in values:
        if low <= value <= high:
            axes.axvline(value, color=style.CAM, linewidth=0.5, linestyle=DOTTED, zorder=3)


CROWDED = 20  # numbers above a panel from which they stand in two rows
STEP = 24.0  # px between these
SMALL, LARGE = 20.0, 28.0  # px, from one number to the next, of one digit and of two


def numbers_height(count: int) -> int:
    """Pixels that so many numbers above a panel need."""
    return 64 + round(STEP) * (count > CROWDED) if count else 0


def event_numbers(axes: Axes, events: Sequence[tuple[int, float]]) -> None:
    """Numbers of events in ascending order above a panel, each with a line to its place."""
    low, high = axes.get_xlim()
    box = axes.get_window_extent()
    seen = [(number, value) for number, value in events if low <= value <= high]
    crowded = len(seen) > CROWDED
    room = LARGE / 2.0 if crowded else LARGE if len(seen) > 9 else SMALL
    places = spread([value for _, value in seen], room * (high - low) / box.width, low, high)
    at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
    for k, ((number, value), place) in enumerate(zip(seen, places, strict=True)):
        up = STEP * (k % 2) if crowded else 0.0
        y = [1.0 + rise / box.height for rise in (0.0, 6.0, 24.0, 26.0 + up)]
        axes.plot([value, value, place, place], y, color=style.GUIDE, linewidth=0.5, **at)
        y_text = 1.0 + (29.0 + up) / box.height
        axes.text(place, y_text, str(number), ha="center", va="bottom", size=7, **at)


def trouble_ticks(axes: Axes, x: Sequence[float] | np.ndarray) -> None:
    """A red tick at the bottom edge where a status is not ok."""
    at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    axes.plot(x, np.zeros(len(x)), "|", color=style.TROUBLE, ms=7, mew=0.9, **at)


# --- words


def legend(
    figure: Figure,
    top: float,
    handles: Sequence,
    names: Sequence[str],
    columns: int = 1,
    left: float = 20,
) -> None:
    """A legend whose top left corner is at a pixel, below the heading of the page or a panel's."""
    figure.legend(handles, names, bbox_to_anchor=style.share(figure, left, top), ncols=columns)


def text_rows(figure: Figure, top: float, count: int) -> Axes:
    """Axes without a frame over the width of the page for rows of text, in pixels."""
    wide, height = figure.get_figwidth() * style.DPI, style.LINE * count
    axes = style.place(figure, 0, top, wide, height, frame_on=False)
    axes.set(xlim=(0, wide), ylim=(height, 0), xticks=[], yticks=[])
    return axes


def row_middle(row: int) -> float:
    """Height of a row of text in its axes."""
    return (row + 0.5) * style.LINE


def text_row(
    axes: Axes, row: int, lefts: Sequence[float], cells: Sequence[str], **look: Any
) -> list[Text]:
    """One row of texts, each from its left end."""
    pairs = zip(lefts, cells, strict=False)
    return [axes.text(x, row_middle(row), s, va="center_baseline", **look) for x, s in pairs]


# --- the cam and its force


def lift_curves(cam: Cam, count: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Phases in degrees, and there c and its first derivatives by theta; nan between stretches."""
    pieces = np.asarray(cam.pieces, dtype=float).reshape(-1, PIECE)
    theta: list[np.ndarray] = []
    orders: list[list[np.ndarray]] = [[] for _ in range(count)]
    gap = np.array([np.nan])
    columns = [column(cam, name) for name in ("start", "end", "first_piece", "piece_count")]
    for start, end, first, number in zip(*columns, strict=True):
        x = np.linspace(start, end, 2 + int((end - start) * 200))
        k = ((x - start) / (end - start) * number).astype(int)
        piece = pieces[int(first) + np.minimum(k, int(number) - 1)]
        powers = (x - piece[:, 0])[:, None] ** np.arange(TERMS)
        theta += [np.degrees(x), gap]
        for order, rows in enumerate(orders):
            terms = piece[:, 1 + order * TERMS : 1 + (order + 1) * TERMS]
            rows += [(terms * powers).sum(axis=1), gap]
    return np.concatenate(theta), [np.concatenate(rows) for rows in orders]


def draw_forces(axes: Axes, curves: Sequence[ForceCurve], names: Sequence[str] = ()) -> None:
    """N over the turn, darker from curve to curve; below zero a follower would leave."""
    colours = style.FORCES if len(curves) > 1 else (style.FORCE,)
    for k, curve in enumerate(curves):
        turn, place = divmod(k, len(colours))
        line, name = FORCE_LINES[turn % len(FORCE_LINES)], names[k] if names else None
        axes.plot(curve.theta_deg, curve.force_n, color=colours[place], ls=line, label=name)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    low, high = axes.get_ylim()
    if low < 0.0 and any(min(curve.force_n) < 0.0 for curve in curves):
        axes.axhspan(low, 0.0, color=style.PULL, linewidth=0, zorder=0)
    axes.set_ylim(low, high)
    axes.set_ylabel("contact force (N)")


def newtons(value: float, digits: int) -> str:
    """A force for print, with a minus sign and no negative zero."""
    return f"{round(value, 6) + 0.0:.{digits}g} N".replace("-", "−")
