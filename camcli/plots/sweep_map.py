"""Picture of a map: the kind of motion over two numbers, its exponent, and what it loads."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.image import AxesImage

from camcli.analysis.sweep import Map, Speed
from camcli.plots.axes import axis_name
from camcli.plots.picture import Panel, Picture
from camcli.plots.sweep import colour_of, kind_of
from camcli.quantities import EXPONENT, LOADS, Units, labelled
from camcli.words.loads import load
from camcli.words.sweep import map_heading

HEIGHT = 90.0  # mm
DASHES = {"period-doubling": (0, (4, 1.5)), "fold": (0, (1, 1)), "grazing": (0, (4, 1, 1, 1))}
Curve = tuple[str, Sequence[float], Sequence[float]]  # kind of bifurcation, along both numbers


def draw_map(found: Map, units: Units, curves: Sequence[Curve] = ()) -> Picture:
    """Panels `kind`, `exponents` where they were measured, and by name each of the loads.

    curves: bifurcations in the two numbers, drawn over all.
    """
    rows = [list(line) for line in found.lines]

    def over(draw: Callable[[Axes], None], axes: Axes) -> None:
        draw(axes)
        for label, x, y in curves:
            axes.plot(x, y, color="white", lw=2.0, zorder=3)
            axes.plot(x, y, color="black", lw=0.8, zorder=4, ls=DASHES.get(label, "-"), label=label)
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
