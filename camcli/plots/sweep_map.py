"""Picture of a map: the kind of motion over two numbers, its exponent, and what it loads."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import hypot
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.image import AxesImage
from matplotlib.patheffects import withStroke

from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.sweep import Map, Speed
from camcli.plots.axes import axis_name, mark_points
from camcli.plots.picture import Panel, Picture
from camcli.plots.sweep import colour_of, kind_of
from camcli.quantities import EXPONENT, LOADS, Units, labelled
from camcli.words.loads import load
from camcli.words.sweep import curve_words, map_heading

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo

HEIGHT = 90.0  # mm
DASHES = {"period-doubling": (0, (4, 1.5)), "fold": (0, (1, 1)), "grazing": (0, (4, 1, 1, 1))}
MOST_NAMED = 16  # curves in the legend
PLACES = (0.5, 0.36, 0.64, 0.22, 0.78)  # of a curve, where its number may stand


def draw_map(
    found: Map,
    units: Units,
    curves: Sequence[CurveLine] = (),
    points: Sequence[CodimTwo] = (),
) -> Picture:
    """Panels `kind`, `exponents` where they were measured, and by name each of the loads.

    curves: bifurcations in the two numbers, drawn over all, with numbers where there are several;
    points: of codimension two on them.
    """
    rows = [list(line) for line in found.lines]

    def over(draw: Callable[[Axes], None], axes: Axes) -> None:
        draw(axes)
        places = _number_places(curves, found)
        for number, (curve, place) in enumerate(zip(curves, places, strict=True), 1):
            _draw_curve(axes, curve, number if len(curves) > 1 else 0, place)
        if len(curves) > MOST_NAMED:
            axes.plot([], [], " ", label=f"and {len(curves) - MOST_NAMED} more curves")
        mark_points(axes, points)
        axes.set(xlim=cell_edges(found.first), ylim=cell_edges(found.second))
        axes.set_xlabel(axis_name(found.keys[0]))
        axes.set_ylabel(axis_name(found.keys[1]))

    panels = {"kind": Panel(partial(over, partial(_draw_kinds, found, rows)), HEIGHT)}
    for name, quantity in {"exponents": EXPONENT, **LOADS}.items():
        values = np.array([[_value(speed, name) for speed in row] for row in rows], dtype=float)
        unit, scale = units.shown(quantity.unit)
        usual = quantity is EXPONENT and bool(np.isfinite(values).any())
        words = labelled(quantity.name, unit)
        draw = partial(_draw_values, found, values * scale, words, quantity is EXPONENT)
        panels[name] = Panel(partial(over, draw), HEIGHT, usual=usual)
    title, words = map_heading(found)
    return Picture(title, panels, caption=words)


def _number_places(curves: Sequence[CurveLine], found: Map) -> list[tuple[float, float]]:
    """Where the number of each curve stands on it: as far as it can from those before it."""
    spans = [(max(values) - min(values)) or 1.0 for values in (found.first, found.second)]
    places: list[tuple[float, float]] = []

    def room(at: tuple[float, float]) -> float:
        """Distance to the nearest number, in shares of the map's width and height."""
        shares = (
            [(a - b) / span for a, b, span in zip(at, other, spans, strict=True)]
            for other in places
        )
        return min((hypot(*share) for share in shares), default=0.0)

    for curve in curves:
        last = len(curve.first) - 1
        points = [int(share * last) for share in PLACES]
        tried = [(curve.first[k], curve.second[k]) for k in points] if last >= 0 else [(0.0, 0.0)]
        places.append(max(tried, key=room))
    return places


def _draw_curve(axes: Axes, curve: CurveLine, number: int, place: tuple[float, float]) -> None:
    """A curve in the dashes of its kind, named with its orbit and corner.

    number: 0 for none; place: where it stands.
    """
    axes.plot(curve.first, curve.second, color="white", lw=2.0, zorder=3)
    words = curve_words(curve.kind, curve.label, curve.corner)
    look: dict[str, Any] = {"color": "black", "lw": 0.8, "zorder": 4}
    if number <= MOST_NAMED:
        look["label"] = f"{number}  {words}" if number else words
    axes.plot(curve.first, curve.second, ls=DASHES.get(curve.kind, "-"), **look)
    if number and len(curve.first):
        halo = [withStroke(linewidth=2.0, foreground="white")]
        axes.annotate(
            str(number), place, (3, 3), textcoords="offset points", fontsize=7, zorder=7,
            path_effects=halo, annotation_clip=True,
        )  # fmt: skip


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
    kinds = sorted({kind_of(speed) for row in rows for speed in row})
    cells = np.array([[kinds.index(kind_of(speed)) for speed in row] for row in rows])
    colours = ListedColormap([colour_of(kind) for kind in kinds])
    _image(axes, found, cells, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5)
    for kind in kinds:
        axes.plot([], [], "s", color=colour_of(kind), ms=4, label=kind)


def _draw_values(found: Map, values: np.ndarray, words: str, signed: bool, axes: Axes) -> None:
    """signed: zero is white."""
    cells = np.ma.masked_invalid(values)
    if signed:
        size = float(np.abs(cells).max()) if cells.count() else 1.0
        image = _image(axes, found, cells, cmap="RdBu_r", vmin=-size, vmax=size)
    else:
        image = _image(axes, found, cells, cmap="viridis")
    axes.figure.colorbar(image, ax=axes, label=words)
