"""Picture of a map: the kind of motion over two numbers, its exponent, and what it loads."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.image import AxesImage
from matplotlib.patheffects import withStroke

from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.sweep import Map, Speed
from camcli.plots import style
from camcli.plots.axes import axis_name, mark_points, point_looks, say
from camcli.plots.picture import COMPACT, Cell, Panel, Picture
from camcli.plots.sweep import colour_of, in_order, kind_of
from camcli.quantities import EXPONENT, LOADS, SEAT, Units, labelled
from camcli.words.loads import load
from camcli.words.sweep import curve_words, map_heading

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo

HEIGHT, SHAPE = 90.0, 0.75  # mm; of the width, at most
DASHES = {"period-doubling": (0, (4, 1.5)), "fold": (0, (1.2, 1.2)), "grazing": (0, (4, 1, 1, 1))}
LINES = (  # colour, width and edge of the curves of one kind, in turn
    ("black", 0.9, "white"),
    ("white", 0.9, "black"),
    ("black", 2.0, "white"),
    (style.CURVE_RED, 0.9, "white"),
    (style.CURVE_GREEN, 0.9, "black"),
    (style.CURVE_RED, 2.0, "white"),
    ("white", 2.0, "black"),
    (style.CURVE_GREEN, 2.0, "black"),
)
EDGE = 1.2  # pt, of which half is on either side of a curve
BAND = 3.2  # pt, by which the band of a proved curve is wider than the curve
BAND_LOOK: dict[str, Any] = {"color": style.PROVED, "ls": "-", "solid_capstyle": "butt"}
MOST_NAMED = 16  # curves in the list
TOP = 0.9  # of the map's size: a number beyond stands beside its place, as it does below 0.1
PLACES = (0.5, 0.36, 0.64, 0.22, 0.78, 0.08, 0.92)  # of a curve, where its number may stand
NEAR_CURVE, NEAR_NUMBER = 0.03, 0.1  # of the map's size: no place needs more room
NEAR_POINT, ASIDE = 0.035, 12.0  # of the map's size, and pt: of a number that a point would hide


def draw_map(
    found: Map,
    units: Units,
    curves: Sequence[CurveLine] = (),
    points: Sequence[CodimTwo] = (),
    seat: bool = False,
    kind: str = "",
) -> Picture:
    """Panels `kind`, `exponents` where they were measured, and by name each of the loads.

    seat: with the loads of the seat, of a cam with lash; kind: of the cam.
    curves: bifurcations in the two numbers, drawn over all, with numbers where there are several;
    points: of codimension two on them.
    """
    rows = [list(line) for line in found.lines]
    looks = _looks(curves)

    def with_curves(draw: Callable[[Axes], None], axes: Axes) -> None:
        """A panel's own content, and the curves and points over it."""
        draw(axes)
        axes.set(xlim=cell_edges(found.first), ylim=cell_edges(found.second))
        places = _number_places(curves, found, points)
        for number, (curve, look, place) in enumerate(zip(curves, looks, places, strict=True), 1):
            level = 5.0 - 0.4 * look["lw"]  # a thin one shows on a wide one that runs along it
            for along, across in proved_lines(curve):
                band = {**BAND_LOOK, "lw": look["lw"] + BAND}
                axes.plot(along, across, zorder=4.0, scalex=False, scaley=False, **band)
            axes.plot(curve.first, curve.second, zorder=level, scalex=False, scaley=False, **look)
            if len(curves) > 1 and place is not None:
                _number(axes, number, place, _near_point(place, found, points))
        mark_points(axes, points, named=False)
        axes.set_xlabel(axis_name(found.keys[0]))
        axes.set_ylabel(axis_name(found.keys[1]))

    measured = {"exponents": EXPONENT, **LOADS, **(SEAT if seat else {})}
    kinds = partial(with_curves, partial(_draw_kinds, found, rows))
    panels = {"kind": Panel(kinds, HEIGHT, shape=SHAPE)}
    for name, quantity in measured.items():
        values = np.array([[_value(speed, name) for speed in row] for row in rows], dtype=float)
        unit, scale = units.shown(quantity.unit)
        usual = quantity is EXPONENT and bool(np.isfinite(values).any())
        words = labelled(quantity.name, unit)
        draw = partial(_draw_values, found, values * scale, words, quantity is EXPONENT)
        panels[name] = Panel(partial(with_curves, draw), HEIGHT, usual=usual, shape=SHAPE)
    title, words = map_heading(found, kind)
    lists = [_curve_rows(curves, looks), _proof_rows(curves), _point_rows(points)]
    return Picture(title, panels, caption=words, lists=lists, tall=COMPACT)


def _looks(curves: Sequence[CurveLine]) -> list[dict[str, Any]]:
    """Of each curve: the dashes of its kind, in a line that the few before of it do not have."""
    many: Counter[str] = Counter()
    looks: list[dict[str, Any]] = []
    for curve in curves:
        colour, width, edge = LINES[many[curve.kind] % len(LINES)]
        many[curve.kind] += 1
        seam = [withStroke(linewidth=width + EDGE, foreground=edge)]
        dashes = DASHES.get(curve.kind, "-")
        looks.append({"color": colour, "lw": width, "ls": dashes, "path_effects": seam})
    return looks


def _curve_rows(curves: Sequence[CurveLine], looks: Sequence[dict[str, Any]]) -> list[list[Cell]]:
    """The list of the curves: line, number and words."""
    if not curves:
        return []
    rows: list[list[Cell]] = [["", "", "bifurcations"]]
    for number, (curve, look) in enumerate(zip(curves, looks, strict=True), 1):
        words = curve_words(curve.kind, curve.label, curve.corner)
        rows.append([look, str(number) if len(curves) > 1 else "", words])
    more = len(curves) - MOST_NAMED
    return [*rows[: MOST_NAMED + 1], ["", "", f"and {more} more"]] if more > 0 else rows


def _proof_rows(curves: Sequence[CurveLine]) -> list[list[Cell]]:
    """The list of what the band along a curve says, where any of them has one."""
    if not any(any(curve.proved) for curve in curves):
        return []
    return [["", "proofs"], [{**BAND_LOOK, "lw": BAND + 0.9}, "proved without a gap"]]


def proved_lines(curve: CurveLine) -> list[tuple[Sequence[float], Sequence[float]]]:
    """The proved parts of a curve along both numbers, each as long as it has no gap."""
    lines: list[tuple[Sequence[float], Sequence[float]]] = []
    first = 0
    for proved, parts in groupby(curve.proved):
        last = first + len(list(parts))
        if proved:
            lines.append((curve.first[first : last + 1], curve.second[first : last + 1]))
        first = last
    return lines


def _point_rows(points: Sequence[CodimTwo]) -> list[list[Cell]]:
    """The list of the kinds of points of codimension two: mark and words."""
    looks = point_looks(points)
    if not looks:
        return []
    rows: list[list[Cell]] = [["", "points of codimension two"]]
    return rows + [[look, words] for words, look in looks.items()]


def _spans(found: Map) -> list[float]:
    """How far both numbers of a map reach."""
    return [(max(values) - min(values)) or 1.0 for values in (found.first, found.second)]


def _near_point(place: tuple[float, float], found: Map, points: Sequence[CodimTwo]) -> bool:
    """Whether a mark of a point of codimension two would lie below a number at a place."""
    spans = _spans(found)
    marks = np.array([(point.first, point.second) for point in points]).reshape(-1, 2)
    return _distance(np.array(place) / spans, marks / spans) < NEAR_POINT


def _number_places(
    curves: Sequence[CurveLine], found: Map, points: Sequence[CodimTwo] = ()
) -> list[tuple[float, float] | None]:
    """Where the number of each curve stands on it: away from other curves and numbers before it.

    And from points of codimension two. A curve without points has no number, and no place.
    """
    spans = _spans(found)
    marks = np.array([(point.first, point.second) for point in points]).reshape(-1, 2) / spans
    lines = [np.column_stack([curve.first, curve.second]) / spans for curve in curves]
    taken: list[np.ndarray] = []
    places: list[tuple[float, float] | None] = []

    for number, (curve, line) in enumerate(zip(curves, lines, strict=True)):
        if not len(line):
            places.append(None)
            continue
        others = np.concatenate([np.empty((0, 2)), *lines[:number], *lines[number + 1 :]])

        def room(k: int, line: np.ndarray = line, others: np.ndarray = others) -> float:
            """How much of the wanted room there is, and how far away the nearest number is."""
            to_curve = _distance(line[k], others) / NEAR_CURVE
            to_mark = _distance(line[k], marks) / NEAR_POINT
            to_number = _distance(line[k], np.array(taken).reshape(-1, 2))
            return (
                min(to_curve, 1.0)
                + min(to_mark, 1.0)
                + min(to_number / NEAR_NUMBER, 1.0)
                + 0.1 * min(to_number, 1.0)
            )

        best = max((int(share * (len(line) - 1)) for share in PLACES), key=room)
        places.append((curve.first[best], curve.second[best]))
        taken.append(line[best])
    return places


def _distance(at: np.ndarray, points: np.ndarray) -> float:
    """To the nearest of the points; infinite where there are none."""
    return float(np.hypot(*(points - at).T).min()) if len(points) else inf


def _number(axes: Axes, number: int, place: tuple[float, float], beside: bool = False) -> None:
    """The number of a curve on its place; at an edge of the panel beside it, within the panel.

    beside: to the right of the place, or to the left at the right edge, where a point is.
    """
    across, x_shift = _beside_edge(place[0], axes.get_xlim(), ("left", "center", "right"))
    upright, y_shift = _beside_edge(place[1], axes.get_ylim(), ("bottom", "center", "top"))
    if beside:
        x_shift = -ASIDE if across == "right" else ASIDE
    axes.annotate(
        str(number), place, (x_shift, y_shift), fontsize=style.NOTE, textcoords="offset points",
        ha=across, va=upright, zorder=7,
        annotation_clip=True, path_effects=[withStroke(linewidth=2.0, foreground="white")],
    )  # fmt: skip


def _beside_edge(
    value: float, limits: tuple[float, float], names: tuple[str, str, str]
) -> tuple[str, float]:
    """(alignment, shift in pt) of a text at a value of an axis, so that it stays within the panel.

    names: of the alignments near the lower edge, in between, and near the upper edge.
    """
    low, high = limits
    lower, middle, upper = names
    share = (value - low) / (high - low)
    if share > TOP:
        return upper, -3
    if share > 1.0 - TOP:
        return middle, 0
    return lower, 3


def _value(speed: Speed, name: str) -> float | None:
    """The exponent of a point, or one of its loads."""
    return speed.exponent if name == "exponents" else load(speed.loads, name)


def cell_edges(values: Sequence[float]) -> tuple[float, float]:
    """Edges of the cells around the first and the last value, ascending."""
    low, high = min(values), max(values)
    half = 0.5 * (high - low) / max(len(values) - 1, 1) or 0.01 * abs(low) or 1e-6
    return low - half, high + half


def _image(axes: Axes, found: Map, cells: np.ndarray, **look: Any) -> AxesImage:
    """Cells in ascending order of both numbers."""
    cells = cells[np.argsort(found.second)][:, np.argsort(found.first)]
    extent = (*cell_edges(found.first), *cell_edges(found.second))
    return axes.imshow(
        cells, extent=extent, origin="lower", aspect="auto", interpolation="nearest", **look
    )


def _draw_kinds(found: Map, rows: Sequence[Sequence[Speed]], axes: Axes) -> None:
    kinds = in_order(kind_of(speed) for row in rows for speed in row)
    cells = np.array([[kinds.index(kind_of(speed)) for speed in row] for row in rows])
    shades = [style.AREAS[colour_of(kind)] for kind in kinds]
    colours = ListedColormap(shades)
    _image(axes, found, cells, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5)
    for kind, shade in zip(kinds, shades, strict=True):
        axes.plot([], [], "s", color=shade, mec=style.CAM, mew=0.4, ms=5, label=kind)


def _draw_values(found: Map, values: np.ndarray, words: str, signed: bool, axes: Axes) -> None:
    """Cells in the colour of their value, with a colour bar; those without a value are grey.

    words: the title of the bar. signed: values of both signs count, and zero is white.
    """
    cells = np.ma.masked_invalid(values)
    if not cells.count():
        say(axes, "no value at any of these points")
        axes.set(title=words)
        return
    if cells.count() < cells.size:
        axes.set_facecolor(style.BLANK)
        axes.plot([], [], "s", color=style.BLANK, ms=5, label="no value")
    if signed:
        size = float(np.abs(cells).max())
        image = _image(axes, found, cells, cmap="RdBu_r", vmin=-size, vmax=size)
    else:
        image = _image(axes, found, cells, cmap="viridis")
    axes.figure.colorbar(image, ax=axes, label=words)
