"""Where the numbers of curves stand in a panel: on their curves, else beside them with a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from camcli.plots import style

TRIED = 40  # places on a curve, at most, where its number may stand
MOST_STEPS = 1000  # from one point of a curve to the next: it may be far beside the panel
STEP = 3.0  # pt, between the points of a curve that others keep away from
EDGE = 6.0  # pt, from the middle of a number to the border of the panel, at least
NEAR_CURVE, NEAR_MARK, NEAR_NUMBER = 6.0, 8.0, 11.0  # pt, of a number: less is too near
CLEAR = (
    10.0  # pt, from the place on its curve to another curve: less leaves in doubt which is meant
)
REACHES = (11.0, 16.0, 24.0, 34.0)  # pt, from the curve to the middle of a number beside it
FREE_ENDS = 4.0, 4.0  # pt, of the line to a number beside: at the curve, and below the number
GRID = 1.0  # pt: how finely is known what such a line would cross
DIRECTIONS = 12  # in which it may stand beside the curve
COST_OF_WAY = 0.02  # of each pt of that way, where being as near as can be to something costs 1
COST_OF_END = 0.6  # of standing at the end of a curve, not in the middle
COST_OF_NUMBER = 4.0  # of standing on another number
COST_OF_CROSSING = 3.0  # of a line that crosses another curve, a mark or another number


@dataclass(frozen=True)
class Spot:
    """Where a number stands: a place of its curve, and the way from there to the number, pt."""

    place: tuple[float, float]
    way: tuple[float, float]


def spots_of(
    axes: Axes,
    curves: Sequence[tuple[Sequence[float], Sequence[float]]],
    marks: Sequence[tuple[float, float]] = (),
) -> list[Spot | None]:
    """A spot for each curve that is seen, as far from other curves, marks and numbers as can be.

    curves: x and y of the points of each; marks: places of others. Both axes must have their range.
    None for a curve that has no point in the panel.
    """
    size = np.array(axes.get_window_extent().size) / style.DPI * 72.0  # pt
    lines = [_in_points(axes, np.column_stack(curve), size) for curve in curves]
    dense = [_dense(line, size) for line in lines]
    all_marks = _in_points(axes, np.array(marks, dtype=float).reshape(-1, 2), size)
    ink = _Ink(size)
    drawn = [ink.cells_of(line) for line in lines]
    for cells in drawn:
        ink.add(cells)
    ink.add(ink.cells_about(all_marks, NEAR_MARK / 2.0))
    numbers: list[np.ndarray] = []
    lead_points: list[np.ndarray] = []
    spots: list[Spot | None] = []
    for k, line in enumerate(lines):
        inside = np.flatnonzero(((line >= 0.0) & (line <= size)).all(axis=1))
        if not len(inside):
            spots.append(None)
            continue
        tried = inside[np.linspace(0, len(inside) - 1, min(TRIED, len(inside))).astype(int)]
        from_middle = np.abs(np.linspace(-1.0, 1.0, len(tried))) if len(tried) > 1 else np.zeros(1)
        others = np.concatenate([np.empty((0, 2)), *dense[:k], *dense[k + 1 :]])
        places = line[tried]
        unclear = _nearness(places, np.concatenate([others, all_marks]), CLEAR)
        of_place = unclear + COST_OF_END * from_middle
        best_cost = np.inf
        ink.remove(drawn[k])
        for way in _ways():
            at = places + way
            reach = float(np.hypot(*way))
            if of_place.min() + COST_OF_WAY * reach >= best_cost:
                break  # longer ways cost more
            near = others if reach == 0.0 else np.concatenate([others, dense[k]])
            cost = (
                _nearness(at, near, NEAR_CURVE)
                + _nearness(at, all_marks, NEAR_MARK)
                + COST_OF_NUMBER * _nearness(at, np.array(numbers), NEAR_NUMBER)
                + COST_OF_NUMBER * _nearness(at, _joined(lead_points), NEAR_CURVE)
                + COST_OF_CROSSING * ink.any_along(_lead(way)[:, None] + places)
                + of_place
                + COST_OF_WAY * reach
            )
            cost[((at < EDGE) | (at > size - EDGE)).any(axis=1)] = np.inf
            first = int(np.argmin(cost))
            if cost[first] < best_cost:
                best_cost = float(cost[first])
                best = tried[first]
                best_way = way
        ink.add(drawn[k])
        if best_cost == np.inf:  # the panel is too small for any number
            spots.append(None)
            continue
        numbers.append(line[best] + best_way)
        lead_points.append(line[best] + _lead(best_way))
        ink.add(ink.cells_about(numbers[-1:], NEAR_NUMBER / 2.0))
        x, y = curves[k]
        spots.append(Spot((float(x[best]), float(y[best])), (best_way[0], best_way[1])))
    return spots


def write_number(
    axes: Axes, number: int, spot: Spot, colour: str = "black", edge: str = "white"
) -> None:
    """The number of a curve at its spot; a thin line leads to the curve where it stands beside.

    colour, edge: of the number, those of the curve. The line is black, or it would look like a
    part of the curve.
    """
    beside = spot.way != (0.0, 0.0)
    line: dict[str, Any] = {"arrowstyle": "-", "lw": 0.6, "color": "black", "shrinkB": 0.0}
    axes.annotate(
        str(number), spot.place, spot.way, textcoords="offset points", fontsize=style.NOTE,
        ha="center", va="center", zorder=7, annotation_clip=True, color=colour,
        arrowprops={**line, "shrinkA": 1.0} if beside else None,
        path_effects=[withStroke(linewidth=2.0, foreground=edge)],
    )  # fmt: skip


def _in_points(axes: Axes, places: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Places of the axes in pt from their lower left corner; size: of the axes, pt."""
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    return (places - low) / (high - low) * size


def _dense(line: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Points along a line that are STEP pt apart or less, those in the panel."""
    if len(line) < 2:
        return line
    parts = [line[:1]]
    for begin, end in pairwise(line):
        count = min(1 + int(np.hypot(*(end - begin)) / STEP), MOST_STEPS)
        shares = np.linspace(0.0, 1.0, count + 1)[1:, None]
        parts.append(begin + shares * (end - begin))
    every = np.concatenate(parts)
    return every[((every >= -EDGE) & (every <= size + EDGE)).all(axis=1)]


def _lead(way: tuple[float, float]) -> np.ndarray:
    """Points of the line from a curve to a number beside it, without its FREE_ENDS."""
    reach = float(np.hypot(*way))
    first, last = FREE_ENDS[0], reach - FREE_ENDS[1]
    shares = np.arange(first, last, GRID) / reach
    return shares[:, None] * np.array(way)


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    """The points of all parts."""
    return np.concatenate([np.empty((0, 2)), *parts])


class _Ink:
    """What is drawn on a panel by cells of GRID, with the cells around it: how many things."""

    def __init__(self, size: np.ndarray) -> None:
        """size: of the panel, pt."""
        self._shape = tuple(np.ceil(size / GRID).astype(int) + 1)
        self._count = np.zeros(self._shape, dtype=np.int16)

    def cells_of(self, line: np.ndarray) -> np.ndarray:
        """The cells of a line from point to point, and those around them."""
        if len(line) < 2:
            return self.cells_about(line, GRID)
        steps = np.abs(np.diff(line, axis=0)).max(axis=1) / GRID
        ends = np.concatenate([[0.0], np.cumsum(np.minimum(np.ceil(steps), MOST_STEPS))])
        places = np.arange(ends[-1] + 1.0)
        dense = np.column_stack([np.interp(places, ends, column) for column in line.T])
        return self.cells_about(dense, GRID)

    def cells_about(self, points: np.ndarray | Sequence[np.ndarray], radius: float) -> np.ndarray:
        """The cells within a radius (pt) of any point, each once."""
        span = np.arange(-ceil(radius / GRID), ceil(radius / GRID) + 1)
        x, y = (part.ravel() for part in np.meshgrid(span, span))
        around = np.column_stack([x, y])[np.hypot(x, y) * GRID <= radius * 1.5]
        middles = np.rint(np.reshape(points, (-1, 2)) / GRID).astype(int)
        cells = np.unique(middles, axis=0)[:, None] + around
        inside = ((cells >= 0) & (cells < self._shape)).all(axis=2)
        return np.unique(np.ravel_multi_index(tuple(cells[inside].T), self._shape))

    def add(self, cells: np.ndarray) -> None:
        """Draw one thing more."""
        self._count.ravel()[cells] += 1

    def remove(self, cells: np.ndarray) -> None:
        """Take back a thing that has been added."""
        self._count.ravel()[cells] -= 1

    def any_along(self, lines: np.ndarray) -> np.ndarray:
        """For each of some lines, (points, lines, 2), whether it is on anything; 1.0 or 0.0."""
        cells = np.rint(lines / GRID).astype(int)
        inside = ((cells >= 0) & (cells < self._shape)).all(axis=2)
        cells[~inside] = 0
        found: np.ndarray = (self._count[cells[..., 0], cells[..., 1]] > 0) & inside
        return found.any(axis=0).astype(float)


def _ways() -> list[tuple[float, float]]:
    """The ways from a curve to its number that are tried, pt: none first, then short ones."""
    angles = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ways = [(0.0, 0.0)]
    for reach in REACHES:
        ways += [(reach * float(np.cos(a)), reach * float(np.sin(a))) for a in angles]
    return ways


def _nearness(at: np.ndarray, others: np.ndarray, wanted: float) -> np.ndarray:
    """For each place 1 where it lies on one of the others, 0 from the distance wanted on."""
    if not len(others):
        return np.zeros(len(at))
    squares = (at**2).sum(axis=1)[:, None] + (others**2).sum(axis=1) - 2.0 * (at @ others.T)
    away = np.sqrt(np.maximum(squares.min(axis=1), 0.0))
    return np.clip(1.0 - away / wanted, 0.0, 1.0)
