"""Clouds of points over speed as images: denser where a column has more of its points.

A sweep may hold more points than memory: one speed is seen at a time, and only what its points
come to, and the cells of the image, is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import (
    LinearSegmentedColormap,
    ListedColormap,
    LogNorm,
    Normalize,
    to_rgba,
)
from matplotlib.image import AxesImage

from camcli.plots import style

WIDE, PER_MM = 1200, 10  # cells of an image: from left to right, per mm of its nominal height
WIDEST = 3  # cells, a point of a speed: some speeds look as many do
FILLED = 5  # cells: speeds so close fill what lies between them, and make lines
THICKNESS = 3  # cells, of a branch
FEW, LARGEST = 2.4, 5  # of the room from speed to speed a point takes this part; cells, at most
POOLED = 1.3  # cells to a pixel from which two by two make one: points stay as large
PALEST = 0.5  # opacity of the emptiest cell that is not blank, unless its colour is light
LIGHT = 0.425  # luminance of a colour that has none to lose
DOT = 0.32, 0.45  # mm, a point at least and at most; wider than its speed where there are few
SPARSE = 0.1  # of its column, which these fill
AROUND = 4  # blank cells: pixels are interpolated from no more than these, as a rule
LEVELS = 256  # of the opacity of a pixel
FULLEST = 0.1  # share of a column's points per cell from which it is opaque


def palest(colour: str) -> float:
    """Opacity of the emptiest cell of a colour that is not blank."""
    return PALEST if style.luminance(colour) < LIGHT else 1.0


class Cloud:
    """How many finite values every speed has, the smallest (inf if none), the largest (-inf)."""

    def __init__(self, speeds: int) -> None:
        self.low, self.high = np.full(speeds, np.inf), np.full(speeds, -np.inf)
        self.count = np.zeros(speeds, np.int64)

    def take(self, speed: int, values: np.ndarray) -> None:
        """More finite values of a speed, given by its index."""
        self.low[speed] = values.min(initial=self.low[speed])
        self.high[speed] = values.max(initial=self.high[speed])
        self.count[speed] += len(values)

    def ends(self, speeds: Any = True) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest value of every speed that has any, of some `speeds` or all."""
        some = (self.count > 0) & speeds
        return self.low[some], self.high[some]

    def extremes(self, speeds: Any = True) -> np.ndarray:
        """Smallest and largest value of some speeds or all; empty where there is none."""
        low, high = self.ends(speeds)
        return np.array([low.min(), high.max()]) if len(low) else np.empty(0)


@dataclass(frozen=True)
class Columns:
    """Which column of an image shows which speed, over the range low..high of the axis.

    Up to one speed per column, a speed fills the columns nearest to it, or `point` of them where
    speeds are more than FILLED columns apart; beyond, the speeds of a column are counted together.
    `bin_of_speed` and `bin_of_column` meet in the bins; -1 is blank, and a speed beside the range.
    `point`: an odd number of cells, as wide and high as a point is; larger where speeds are few.
    """

    low: float
    high: float
    bins: int
    bin_of_speed: np.ndarray
    bin_of_column: np.ndarray
    point: int = WIDEST

    @classmethod
    def of(
        cls,
        speeds: Sequence[float] | np.ndarray,
        width: int = WIDE,
        span: tuple[float, float] = (-np.inf, np.inf),
    ) -> Columns:
        """From speeds in any order and the width of the image, over the part `span` of them."""
        every = np.asarray(speeds, dtype=float)
        seen = (every >= span[0]) & (every <= span[1])
        rising, inverse = np.unique(every[seen], return_inverse=True)
        which = np.full(len(every), -1)
        which[seen] = inverse
        low, high = float(rising[0]), float(rising[-1])
        steps = max(len(rising) - 1, 1)
        room = (high - low) * min(0.5 / steps, 0.02) or max(abs(low) * 0.01, 1e-6)
        low, high = low - room, high + room
        place = (rising - low) / (high - low) * width
        columns = np.arange(width)
        if len(rising) > width:
            bins = np.append(np.minimum(place.astype(int), width - 1), -1)
            return cls(low, high, width, bins[which], columns)
        nearest = np.searchsorted((place[1:] + place[:-1]) / 2.0, columns + 0.5)
        step = (place[-1] - place[0]) / steps
        point = min(max(int(step / FEW) // 2 * 2 + 1, WIDEST), LARGEST) if step else LARGEST
        widest = FILLED if 0.0 < step <= FILLED else point
        far = np.abs(columns + 0.5 - place[nearest]) > widest / 2.0
        return cls(low, high, len(rising), which, np.where(far, -1, nearest), point)


def _odd(cells: float) -> int:
    """The odd number nearest to a number of cells."""
    return 2 * round(0.5 * (cells - 1.0)) + 1 if cells > 1.0 else 1


def _raised(cells: np.ndarray, thickness: int) -> np.ndarray:
    """Rows of cells in which each is the fullest of so many about it, an odd number."""
    raised = cells.copy()
    for k in range(1, thickness // 2 + 1):
        raised[:, :-k] = np.maximum(raised[:, :-k], cells[:, k:])
        raised[:, k:] = np.maximum(raised[:, k:], cells[:, :-k])
    return raised


class _Given(LogNorm):
    """LogNorm whose ends are given, so that it need not look at an image to find them."""

    def autoscale_None(self, A: Any) -> None:  # noqa: N802 - matplotlib's names
        """Nothing: the ends are given."""


class _Levels(Normalize):
    """Opacities, from 0 to 1, as the levels that a pixel can have, from 0 to LEVELS - 1."""

    def __call__(self, value: Any, clip: bool | None = None) -> Any:
        """The highest level that is not above each opacity."""
        return (value * (LEVELS - 1)).astype(int)


class _Points(AxesImage):
    """An image in shades of one colour, which differ in their opacity; masked cells are blank.

    Where cells do not fit pixels, matplotlib interpolates red, green, blue and opacity. Only the
    last one varies here: an image of it alone takes a quarter of the time.
    """

    def make_image(
        self, renderer: Any, magnification: float = 1.0, unsampled: bool = False
    ) -> tuple[Any, float, float, Any]:
        """The pixels, see matplotlib."""
        cells: Any = self.get_array()
        rows, columns = cells.shape
        left, right, bottom, top = self.get_extent()
        cell_wide = (right - left) / columns
        cell_high = (top - bottom) / rows
        # Blank cells on all sides, since pixels at the ends of an image are covered in part.
        opacity = np.zeros((rows + 2 * AROUND, columns + 2 * AROUND))
        shown = ~np.ma.getmaskarray(cells)
        inside = opacity[AROUND:-AROUND, AROUND:-AROUND]
        inside[shown] = self.to_rgba(cells.data[shown])[:, 3]
        red, green, blue, _ = self.cmap(1.0)
        # In the middle of each level, so that none is rounded to the one below.
        levels = np.minimum((np.arange(LEVELS) + 0.5) / (LEVELS - 1), 1.0)
        image = AxesImage(
            self.axes,
            cmap=ListedColormap([(red, green, blue, level) for level in levels]),
            norm=_Levels(0.0, 1.0),
            interpolation=self.get_interpolation(),
            interpolation_stage="data",
            resample=True,
            origin="lower",
            extent=(
                left - AROUND * cell_wide,
                right + AROUND * cell_wide,
                bottom - AROUND * cell_high,
                top + AROUND * cell_high,
            ),
            transform=self.get_transform(),
        )
        image.set_data(opacity)
        return image.make_image(renderer, magnification, unsampled)


def seen_wide(axes: Axes) -> float:
    """How many pixels wide the axes are."""
    return float(axes.get_window_extent().width)


def pooled(
    shares: Any, extent: tuple[float, float, float, float]
) -> tuple[Any, tuple[float, float, float, float]]:
    """Two by two cells as one, the fullest of the four, and where the ends of the image are."""
    rows, columns = shares.shape
    filled = np.pad(np.ma.filled(shares, 0.0), ((0, rows % 2), (0, columns % 2)))
    left, right, bottom, top = extent
    right += (right - left) / columns * (columns % 2)
    top += (top - bottom) / rows * (rows % 2)
    fullest = filled.reshape(filled.shape[0] // 2, 2, filled.shape[1] // 2, 2).max(axis=(1, 3))
    return np.ma.masked_equal(fullest, 0.0), (left, right, bottom, top)


class Image:
    """Values counted per bin and row of an image from `low` to `high`."""

    def __init__(
        self, columns: Columns, low: float, high: float, height: int, thickness: int = THICKNESS
    ) -> None:
        self.columns = columns
        self.low = low
        self.high = high
        self.height = height
        self.thickness = thickness
        self._cells = np.zeros((columns.bins, height), dtype=np.int64)
        self._totals = np.zeros(columns.bins, dtype=np.int64)

    def take(self, speed: int, values: np.ndarray) -> None:
        """Count finite values of a speed; those outside low..high do not show."""
        bin_ = self.columns.bin_of_speed[speed]
        if bin_ < 0:
            return
        self._totals[bin_] += len(values)
        seen = values[(values >= self.low) & (values <= self.high)]
        row = ((seen - self.low) * (self.height / (self.high - self.low))).astype(np.int64)
        row = np.minimum(row, self.height - 1)
        self._cells[bin_] += np.bincount(row, minlength=self.height)

    def shares(self, thickness: int = 0, more: int = 0) -> np.ndarray:
        """(height, width), row 0 at `low`: share of a column's points per cell, or masked.

        Points are as many cells high as the image says, an odd number, or as a point is wide. In
        columns with few points they are `thickness` cells high, where one is given, and `more`
        cells wider to the left, and to the right.
        """
        some = np.flatnonzero(self._totals)  # bins that are not blank
        cells = self._cells[some] / self._totals[some, None]
        usual = max(self.thickness, self.columns.point)
        thick = np.zeros((len(some) + 1, self.height))  # the last one is blank
        thick[:-1] = _raised(cells, usual)
        few = np.mean(thick > 0.0, axis=1) < SPARSE
        thick[:-1][few[:-1]] = _raised(cells[few[:-1]], thickness or usual)
        row_of_bin = np.full(self.columns.bins + 1, len(some))  # bin -1 is blank too
        row_of_bin[some] = np.arange(len(some))
        row_of_column = row_of_bin[self.columns.bin_of_column]
        shown = np.take(thick.T, row_of_column, axis=1)
        alone = np.where(few[row_of_column], shown, 0.0)
        for k in range(1, more + 1):
            shown[:, :-k] = np.maximum(shown[:, :-k], alone[:, k:])
            shown[:, k:] = np.maximum(shown[:, k:], alone[:, :-k])
        return np.ma.masked_equal(shown, 0.0)

    def _size_of_point(self, axes: Axes) -> tuple[int, int]:
        """Cells that a point is high, an odd number, and by which it is wider than its speed.

        It is as high as its speed is wide, but between the two sizes of DOT.
        """
        box = axes.get_window_extent()
        columns = self.columns.bin_of_column
        wide = box.width / style.DPI * 25.4 / columns.size  # mm, of a cell
        high = box.height / style.DPI * 25.4 / self.height
        at_speed = np.count_nonzero(columns >= 0) / self.columns.bins  # columns
        size = min(max(at_speed * wide, DOT[0]), DOT[1])
        more = max(round(0.5 * (size / wide - at_speed)), 0)
        return _odd(size / high * self.thickness / THICKNESS), more

    def _cropped(self, shares: Any) -> tuple[Any, tuple[float, float, float, float]]:
        """`shares` without the blank cells around them, and where they end on both axes.

        The ends are left, right, bottom and top.
        """
        seen = ~np.ma.getmaskarray(shares)
        rows = np.flatnonzero(seen.any(axis=1))
        columns = np.flatnonzero(seen.any(axis=0))
        first_row, last_row = int(rows[0]), int(rows[-1]) + 1
        first_column, last_column = int(columns[0]), int(columns[-1]) + 1
        height, width = seen.shape
        cell_wide = (self.columns.high - self.columns.low) / width
        span = self.high - self.low
        extent = (
            self.columns.low + first_column * cell_wide,
            self.columns.low + last_column * cell_wide,
            self.low + first_row * span / height,
            self.low + last_row * span / height,
        )
        return shares[first_row:last_row, first_column:last_column], extent

    def draw(self, axes: Axes, colour: str = "black", opaque: float = 1.0) -> None:
        """The image over its range, which becomes that of the axes.

        The more of a column's points a cell has, the less of what lies behind it shows, up to
        `opaque`. In a narrow panel two by two cells make one, which shows the fuller of them. Fewer
        pixels than cells show the mean of these, so that no line breaks.
        """
        least = min(1.0 / max(1, int(self._totals.max(initial=0))), 0.1 * FULLEST)
        axes.set(xlim=(self.columns.low, self.columns.high), ylim=(self.low, self.high))
        shares = self.shares(*self._size_of_point(axes))
        if not np.ma.count(shares):
            return
        shares, extent = self._cropped(shares)
        if seen_wide(axes) * POOLED < self.columns.bin_of_column.size:
            shares, extent = pooled(shares, extent)
        ends = [to_rgba(colour, palest(colour) * opaque), to_rgba(colour, opaque)]
        colours = LinearSegmentedColormap.from_list("points", ends)
        shades = colours.with_extremes(bad=to_rgba(colour, 0.0))  # of which means have a share
        image = _Points(
            axes, extent=extent, origin="lower", interpolation="antialiased",
            cmap=shades, norm=_Given(least, FULLEST, clip=True), zorder=2,
        )  # fmt: skip
        image.set_data(shares)
        image.set_clip_path(axes.patch)
        axes.add_image(image)
