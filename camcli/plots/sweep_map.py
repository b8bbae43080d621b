"""Picture of a map: the kind of motion over two numbers, its exponent, and what it loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.image import AxesImage
from matplotlib.patheffects import withStroke

from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.speeds import Speed
from camcli.analysis.sweep_map import Map
from camcli.plots import style
from camcli.plots.axes import axis_name, mark_points, point_looks, say
from camcli.plots.curve_numbers import spots_of, write_number
from camcli.plots.picture import Cell, Panel, Picture
from camcli.plots.proofs import SAMPLE, WITHOUT_GAP, draw_band, proved_stretches
from camcli.plots.sweep import colour_of, in_order, kind_of
from camcli.quantities import EXPONENT, LOADS, SEAT, Units, labelled
from camcli.words.loads import load
from camcli.words.sweep import curve_words, map_heading

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo

HEIGHT, SHAPE = 90.0, 0.75  # mm; of the width, at most
DASHES = {"period-doubling": (0, (4, 1.5)), "fold": (0, (1.2, 1.2)), "grazing": (0, (4, 1, 1, 1))}
LINES = (  # colour, width and edge of the curves in turn: neighbours in the list differ in colour
    ("black", 0.9, "white"),
    (style.CURVE_RED, 0.9, "white"),
    (style.CURVE_GREEN, 0.9, "black"),
    ("white", 0.9, "black"),
    ("black", 2.0, "white"),
    (style.CURVE_RED, 2.0, "white"),
    (style.CURVE_GREEN, 2.0, "black"),
    ("white", 2.0, "black"),
)
EDGE = 1.2  # pt, of which half is on either side of a curve
BAND_LAYER = 4.0  # above the map, below its curves
TALLEST = 170.0  # mm, of a map with its lists in a column of a journal


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
        for curve, look in zip(curves, looks, strict=True):
            layer = 5.0 - 0.4 * look["lw"]  # a thin one shows on a wide one that runs along it
            for part in proved_stretches(curve.proved):
                draw_band(axes, curve.first[part], curve.second[part], look["lw"], BAND_LAYER)
            axes.plot(curve.first, curve.second, zorder=layer, scalex=False, scaley=False, **look)
        if len(curves) > 1:
            _number_curves(axes, curves, points)
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
    lists = [_curve_rows(curves, looks), _point_rows(points)]
    return Picture(title, panels, caption=words, lists=lists, tall=TALLEST)


def _number_curves(axes: Axes, curves: Sequence[CurveLine], points: Sequence[CodimTwo]) -> None:
    """The number of each curve in its colour, away from the others and from points."""
    marks = [(point.first, point.second) for point in points]
    spots = spots_of(axes, [(curve.first, curve.second) for curve in curves], marks)
    for number, spot in enumerate(spots, 1):
        if spot is not None:
            colour, _, edge = LINES[(number - 1) % len(LINES)]
            write_number(axes, number, spot, colour, edge)


def _looks(curves: Sequence[CurveLine]) -> list[dict[str, Any]]:
    """Of each curve: the dashes of its kind, in a line that the few before of it do not have."""
    looks: list[dict[str, Any]] = []
    for k, curve in enumerate(curves):
        colour, width, edge = LINES[k % len(LINES)]
        seam = [withStroke(linewidth=width + EDGE, foreground=edge)]
        dashes = DASHES.get(curve.kind, "-")
        looks.append({"color": colour, "lw": width, "ls": dashes, "path_effects": seam})
    return looks


def _curve_rows(curves: Sequence[CurveLine], looks: Sequence[dict[str, Any]]) -> list[list[Cell]]:
    """The list of the curves: line, number and words; what the band along some of them says."""
    if not curves:
        return []
    rows: list[list[Cell]] = [["", "", "bifurcations"]]
    if any(any(curve.proved) for curve in curves):
        rows.append([SAMPLE, "", WITHOUT_GAP])  # in front, where no list is cut
    for number, (curve, look) in enumerate(zip(curves, looks, strict=True), 1):
        words = curve_words(curve.kind, curve.label, curve.corner)
        rows.append([look, str(number) if len(curves) > 1 else "", words])
    return rows


def _point_rows(points: Sequence[CodimTwo]) -> list[list[Cell]]:
    """The list of the kinds of points of codimension two: mark and words."""
    looks = point_looks(points)
    if not looks:
        return []
    rows: list[list[Cell]] = [["", "points of codimension two"]]
    return rows + [[look, words] for words, look in looks.items()]


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
