"""What several panels draw: ranges, corners, events, the cam's curves, forces, numbers in rows."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import degrees, radians
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.markers import CARETUP
from matplotlib.ticker import Formatter, MultipleLocator

from camcli.cams.compile import column
from camcli.kernel.cam_table import PIECE, TERMS, Cam
from camcli.plots import style
from camcli.quantities import (
    FORCE,
    JERK,
    LENGTHS,
    LIFTS,
    MM,
    PER_DEGREE,
    THETA,
    Units,
    drawn,
    labelled,
)
from camcli.system import System, units_of
from camcli.words.in_print import number_text, parameter, written_out

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.force import ForceCurve
    from camcli.analysis.orbits.codim2 import CodimTwo

Corners = Iterable[tuple[str, float]]  # names and phases (deg)
TURN_DEG = 360.0
DECIMALS, DIGITS = 9, 10  # of the number of a tick, at most
SMALL = 0.02  # of a unit: lengths that are all smaller are shown in the next one
NARROW_DEG = 120.0  # impact phases within less are shown enlarged
ENLARGED_SHARE = 0.4  # of the speeds, whose phases then matter more than those of the others
DOTTED, DASHED = (0, (1, 2)), (0, (4.0, 2.4))
ROOM = {"x": 6.0, "y": 6.5}  # pt, from one name or number beside a panel to the next
CROWDED = 20  # numbers above a panel from which they stand in two rows
LOST = ("X", style.TROUBLE, "white", 6.0)
MARKS = {  # event: marker, face, edge, size; a triangle hangs by its tip, so that both show where
    # a chatter ends in a detachment
    "impact": ("o", style.IMPACT, "none", 2.0),
    "chatter": (CARETUP, style.CHATTER, "white", 6.5),
    "chatter-completion": (CARETUP, style.CHATTER, "white", 6.5),
    "detachment": ("D", style.DETACHMENT, "white", 5.5),
    "departure": ("d", "white", style.DETACHMENT, 5.5),
    "period-doubling": ("s", "white", style.IMPACT, 4.0),
    "fold": ("<", "white", style.IMPACT, 5.0),
    "corner-impact": ("o", "white", style.IMPACT, 4.4),
    "grazing": ("v", "white", style.IMPACT, 5.0),
}
LIFT_PANELS = dict(zip(("lift", "velocity", "acceleration"), LIFTS.values(), strict=True))
CAM_PANELS = {**LIFT_PANELS, "jerk": JERK}

# --- ranges and names of axes


def axis_name(key: str) -> str:
    """The name of an axis over what is varied, a key of the scene: words, symbol and unit."""
    quantity = parameter(key)
    return key if quantity is None else quantity._replace(unit=quantity.unit or "-").label


def padded(
    values: np.ndarray | Sequence[float], constant: float | None = None, zero: float = 1.0
) -> tuple:
    """Range of the values with a margin.

    On either side of values that do not vary `constant`, else a tenth of them, or of zeros `zero`.
    """
    values = np.asarray(values, dtype=float)
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    size = max(abs(low), abs(high))
    if high - low <= 1e-6 * size:
        constant = (0.1 * size or zero) if constant is None else constant
        return low - constant, high + constant
    return low - 0.04 * (high - low), high + 0.04 * (high - low)


def phase_range(values: np.ndarray | Sequence[float]) -> tuple[float, float]:
    """Phases to show, degrees: those of the impacts where they are close, else the whole turn."""
    low, high = padded(values, 5.0)
    if not len(values) or high - low > NARROW_DEG:
        return 0.0, TURN_DEG
    return max(low, 0.0), min(high, TURN_DEG)


def gathered(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Smallest and largest phase to show, given those of every speed; empty where there is none.

    Where motions of some speeds fill the turn, those of the others if they are many and each has
    its phases close together.
    """
    if not len(low):
        return np.empty(0)
    every = np.array([low.min(), high.max()])
    narrow = high - low <= NARROW_DEG / 2.0
    if phase_range(every) != (0.0, TURN_DEG) or narrow.mean() < ENLARGED_SHARE:
        return every
    return np.array([low[narrow].min(), high[narrow].max()])


def phase_axis(axes: Axes, low: float, high: float, what: str = "impact") -> None:
    """Phases upwards, a tick every 60 degrees of a whole turn."""
    axes.set(ylim=(low, high), ylabel=labelled(rf"{what} phase $\theta$", THETA.unit))
    if (low, high) == (0.0, TURN_DEG):
        axes.yaxis.set_major_locator(MultipleLocator(60))


def turn_axis(axes: Axes, corners: dict[str, float], **more: Any) -> None:
    """One turn of the cam to the right, with its corners."""
    axes.set(xlim=(0.0, TURN_DEG), xlabel=THETA.label)
    axes.xaxis.set_major_locator(MultipleLocator(60))
    corner_lines(axes, corners.items(), "x", **more)


def length_axis(axis: Axis, name: str, largest: float) -> None:
    """The name of an axis over lengths in m, whose numbers are mm or µm where all are small."""
    unit = next((unit for unit in ("m", "mm") if largest >= SMALL * LENGTHS[unit]), "um")
    _count(axis, LENGTHS[unit])
    axis.set_label_text(labelled(name, unit))


def unit_axis(axis: Axis, name: str, units: Units, unit: str = "m", **text: Any) -> None:
    """The name of an axis over numbers in a unit, which are shown in the machine's."""
    shown, factor = units.shown(unit)
    _count(axis, 1.0 / factor)
    axis.set_label_text(labelled(name, shown), **text)


def lift_axis(axis: Axis, panel: str, units: Units) -> None:
    """The axis of the lift or of one of its derivatives: the name of its panel, symbol and unit."""
    quantity = CAM_PANELS[panel]
    between = " " if panel == "lift" else "\n"  # the others are too long for a low panel
    name = f"{panel}{between}{quantity.name}"
    unit_axis(axis, name, units, quantity.unit, size=style.WITH_INDEX)


def per_degree_axis(axes: Axes, panel: str) -> None:
    """A second axis at the right, in mm and degrees; the panel's own counts m and rad."""
    order = list(CAM_PANELS).index(panel)
    factor = MM * radians(1.0) ** order
    right = axes.secondary_yaxis(
        "right", functions=(lambda y: np.multiply(y, factor), lambda y: np.divide(y, factor))
    )
    right.set_ylabel(drawn(PER_DEGREE[order].unit), size=style.WITH_INDEX)


def _count(axis: Axis, size: float) -> None:
    """Numbers in a unit of so many m."""
    if size != 1.0:
        axis.set_major_formatter(_InUnit(size))


class _InUnit(Formatter):
    """Numbers of an axis in a unit, all with as many decimals as the longest of them."""

    def __init__(self, size: float) -> None:
        """size: of the unit, m."""
        self.size = size
        self.decimals = 0

    def set_locs(self, locs: Any) -> None:
        """What matplotlib calls with all ticks before it asks for the text of each."""
        texts = [written_out(round(x / self.size, DECIMALS), DIGITS) for x in locs]
        self.decimals = max((len(text.partition(".")[2]) for text in texts), default=0)

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The text of one tick."""
        value = round(x / self.size, DECIMALS) + 0.0  # no minus before a zero
        return f"{value:.{min(self.decimals, DECIMALS)}f}".replace("-", "−")


def strobe_axis(axis: Axis, system: System, words: str = "") -> None:
    """The axis of stroboscopic positions."""
    phase = number_text(round(degrees(system.strobe), 9))
    unit_axis(axis, "stroboscopic $q$", units_of(system))
    if phase != "0":
        words = rf", $\theta$ = {phase} deg{words}"
    axis.label.set_text(axis.label.get_text() + words)


def say(axes: Axes, text: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.set(xticks=[], yticks=[])
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=style.CAM)


# --- names and numbers in a row, corners and events


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


def places_beside(axes: Axes, values: Sequence[float], way: str, room: float = 1.0) -> list[float]:
    """Where the names of ascending values stand along an axis, none upon another."""
    low, high = axes.get_xlim() if way == "x" else axes.get_ylim()
    box = axes.get_window_extent()
    points = (box.width if way == "x" else box.height) / style.DPI * 72.0
    # the layout makes the panel smaller afterwards, by its numbers and names
    return spread(values, 1.2 * room * ROOM[way] * (high - low) / points, low, high)


def corner_lines(axes: Axes, corners: Corners, way: str, named: bool = True) -> None:
    """Corners of the cam at their phases, which grow along `way`, named at the panel's edge."""
    low, high = axes.get_xlim() if way == "x" else axes.get_ylim()
    seen = sorted((phase, name) for name, phase in corners if low <= phase <= high)
    places = places_beside(axes, [phase for phase, _ in seen], way)
    for (phase, name), place in zip(seen, places, strict=True):
        line: dict[str, Any] = {"color": style.GUIDE, "linewidth": 0.5, "zorder": 0.5}
        look: dict[str, Any] = {"color": style.CAM, "size": style.NOTE, "clip_on": False}
        if way == "x":
            axes.axvline(phase, linestyle=DOTTED, **line)
            look |= {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "bottom"}
        else:
            axes.axhline(phase, **line)
            look |= {"transform": axes.get_yaxis_transform(), "va": "center_baseline"}
        if named:
            axes.text(*((place, 1.01) if way == "x" else (1.01, place)), name, **look)


def mark_look(kind: str) -> dict[str, Any]:
    """The mark of an event, or of a place where something could not be followed."""
    marker, face, edge, size = MARKS.get(kind, LOST)
    width = 0.5 if edge == "white" else 0.8
    return {"marker": marker, "ms": size, "mfc": face, "mec": edge, "mew": width, "ls": "None"}


def mark(
    axes: Axes, kind: str, x: Any, y: Any, label: str | None = None, zorder: float = 6
) -> None:
    """Marks of an event."""
    axes.plot(x, y, label=label, zorder=zorder, **mark_look(kind))


def number_events(axes: Axes, events: Sequence[tuple[int | None, float]], named: bool) -> None:
    """A dotted line at every event within the axis; above the panel their numbers, joined to them.

    events: (number, place along x); one whose number is None has a line alone. named: with numbers.
    The axis must have its range.
    """
    low, high = axes.get_xlim()
    seen = [(value, number) for number, value in events if low <= value <= high]
    seen.sort(key=lambda event: (event[0], event[1] or 0))
    for value, _ in seen:
        axes.axvline(value, color=style.CAM, linewidth=0.5, linestyle=DOTTED, zorder=3)
    seen = [(value, number) for value, number in seen if named and number is not None]
    crowded = len(seen) > CROWDED
    places = places_beside(axes, [v for v, _ in seen], "x", 0.8 if crowded else 1.5)
    line = {"arrowstyle": "-", "color": style.GUIDE, "lw": 0.5, "shrinkA": 0, "shrinkB": 0}
    look: dict[str, Any] = {"ha": "center", "va": "bottom", "size": style.NOTE}
    look |= {"xycoords": axes.get_xaxis_transform(), "textcoords": ("data", "offset points")}
    look["annotation_clip"] = False
    for k, ((value, number), place) in enumerate(zip(seen, places, strict=True)):
        above = 19 if crowded and k % 2 == 1 else 11  # pt: in two rows where they are crowded
        axes.annotate(str(number), (value, 1.0), (place, above), arrowprops=line, **look)


def trouble_ticks(axes: Axes, x: Sequence[float] | np.ndarray) -> None:
    """A red tick at the bottom edge where a status is not ok."""
    at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    if len(x):  # empty lines would have a place in the layout
        axes.plot(x, np.zeros(len(x)), "|", color=style.TROUBLE, ms=7, mew=0.9, **at)


# --- the cam and its force


def lift_curves(cam: Cam, count: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Phases in degrees, and there c and its first derivatives by theta; nan between stretches.

    count: how many of these, c among them: 1 to 3.
    """
    angles = []
    curves = []
    for k, (start, end) in enumerate(zip(column(cam, "start"), column(cam, "end"), strict=True)):
        theta = np.linspace(start, end, 2 + int((end - start) * 200))
        orders = _values(cam, np.full(len(theta), k), theta)
        angles.append(np.append(np.degrees(theta), np.nan))
        curves.append(np.column_stack([orders, [np.nan] * 3]))
    return np.concatenate(angles), list(np.concatenate(curves, axis=1)[:count])


def lift(cam: Cam, theta: np.ndarray) -> np.ndarray:
    """c and its two derivatives by theta (rad) at phases of any turn: (3, phases)."""
    starts = np.asarray(column(cam, "start"))
    order = np.argsort(starts)
    x = starts.min() + (theta - starts.min()) % np.radians(TURN_DEG)
    return _values(cam, order[np.searchsorted(starts[order], x, side="right") - 1], x)


def _values(cam: Cam, stretch: np.ndarray, x: np.ndarray) -> np.ndarray:
    """c and its two derivatives at phases x (rad) of the stretches given for each: (3, phases).

    A stretch is cut into pieces of equal length. The row of a piece has a phase first and, for c
    and each derivative, the coefficients of a polynomial in the distance from there.
    """
    start = np.asarray(column(cam, "start"))[stretch]
    end = np.asarray(column(cam, "end"))[stretch]
    first = np.asarray(column(cam, "first_piece"))[stretch].astype(int)
    count = np.asarray(column(cam, "piece_count"))[stretch]
    within = np.minimum(((x - start) / (end - start) * count).astype(int), count.astype(int) - 1)
    pieces = np.asarray(cam.pieces, dtype=float).reshape(-1, PIECE)[first + within]
    origins = pieces[:, 0]
    coefficients = pieces[:, 1:-2].reshape(len(x), -1, TERMS)[:, :3]
    powers = (x - origins)[:, None] ** np.arange(TERMS)
    return np.einsum("xot,xt->ox", coefficients, powers)


def draw_forces(axes: Axes, curves: Sequence[ForceCurve], names: Sequence[str] = ()) -> None:
    """N over the turn, darker from curve to curve; below zero a follower would leave."""
    few = style.FORCES[1:2] if len(curves) == 1 else style.FORCES
    for k, curve in enumerate(curves):
        turn, place = divmod(k, len(few))
        line = ("-", (0, (5, 1.5)), (0, (1.5, 1)))[turn % 3]
        name = names[k] if names else None
        axes.plot(np.degrees(curve.theta), curve.force_n, color=few[place], ls=line, label=name)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    low, high = axes.get_ylim()
    if low < 0.0 and any(min(curve.force_n) < 0.0 for curve in curves):
        axes.axhspan(low, 0.0, color=style.PULL, linewidth=0, zorder=0)
    axes.set(ylim=(low, high), ylabel=FORCE.label)


POINT_MARKS = "sD^v<>phX*P"  # of the kinds of points of codimension two, in the order of the list


def mark_points(axes: Axes, points: Sequence[CodimTwo], named: bool = True) -> None:
    """Points of codimension two: a mark for each kind, named in the legend where it is asked."""
    for words, look in point_looks(points).items():
        mine = [point for point in points if point.kind.replace("-", " ") == words]
        x, y = [point.first for point in mine], [point.second for point in mine]
        axes.plot(x, y, zorder=6, label=words if named else None, **look)


def point_looks(points: Sequence[CodimTwo]) -> dict[str, dict[str, Any]]:
    """The marks of the kinds of points of codimension two, by their words."""
    kinds = list(dict.fromkeys(point.kind for point in points))
    order = list(type(kinds[0])) if kinds else []
    look: dict[str, Any] = {"color": "black", "mfc": "white", "ms": 5.5, "mew": 1.1, "ls": "None"}
    return {
        kind.replace("-", " "): {"marker": POINT_MARKS[order.index(kind)], **look} for kind in kinds
    }
