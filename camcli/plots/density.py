"""Clouds of points over speed: discs, and where a column is full an image, denser where points are.

A sweep may hold more points than memory: one speed is seen at a time, and only what its points
come to, and the cells of the image, is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_rgba
from matplotlib.image import AxesImage
from PIL import Image as Pillow

from camcli.plots import style
from camcli.plots.discs import Discs, have_no_room
from camcli.quantities import MM_PER_INCH

WIDE, PER_MM = 1200, 10  # cells of an image: from left to right, per mm of its nominal height
ABOUT = 2  # ways from speed to speed, on either side, of which the widest counts for discs to meet
FILLED = 5  # cells: speeds so close fill what lies between them, where they are full
BANDS = 16  # of a panel's height: those with points are the paper of a speed
THICKNESS = 3  # cells, of a point in a full column
POOLED = 1.3  # cells to a pixel from which two by two make one, which is a point
PALEST = 0.5  # opacity of the emptiest cell that is not blank, unless its colour is light
LIGHT = 0.425  # luminance of a colour that has none to lose
AROUND = 4  # blank cells: pixels are interpolated from no more than these, as a rule
FULLEST = 0.1  # share of a column's points per cell from which it is opaque

Ends = tuple[float, float, float, float]  # of an image on its axes: left, right, bottom, top


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

    Up to one speed per column, a speed fills the columns nearest to it, at most FILLED of them;
    beyond, the speeds of a column are counted together. `bin_of_speed` and `bin_of_column` meet in
    the bins; -1 is blank, and a speed beside the range. `place_of_bin` is a bin's speed, or the
    middle of its column; `room_of_bin` the way to the nearest bin, `way_of_bin` the widest from bin
    to bin about there.
    """

    low: float
    high: float
    bins: int
    bin_of_speed: np.ndarray
    bin_of_column: np.ndarray
    place_of_bin: np.ndarray
    room_of_bin: np.ndarray
    way_of_bin: np.ndarray

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
        room = (high - low) * min(max(0.5 / steps, 0.004), 0.02) or max(abs(low) * 0.01, 1e-6)
        low, high = low - room, high + room
        place = (rising - low) / (high - low) * width
        columns = np.arange(width)
        if len(rising) > width:
            bins = np.append(np.minimum(place.astype(int), width - 1), -1)
            cell = (high - low) / width
            middles = low + cell * (columns + 0.5)
            cells = np.full(width, cell)
            return cls(low, high, width, bins[which], columns, middles, cells, cells)
        nearest = np.searchsorted((place[1:] + place[:-1]) / 2.0, columns + 0.5)
        far = np.abs(columns + 0.5 - place[nearest]) > FILLED / 2.0
        bin_of_column = np.where(far, -1, nearest)
        if len(rising) > 1:
            rooms, ways = _nearest(rising), _widest(rising)
        else:
            rooms = ways = np.array([high - low])
        return cls(low, high, len(rising), which, bin_of_column, rising, rooms, ways)


def _nearest(rising: np.ndarray) -> np.ndarray:
    """How far from each place the next one is, of two or more."""
    ways = np.diff(rising)
    return np.minimum(np.append(ways, np.inf), np.append(np.inf, ways))


def _widest(rising: np.ndarray) -> np.ndarray:
    """The widest of the ABOUT ways from place to place on either side of each of two or more."""
    ways = np.pad(np.diff(rising), ABOUT)
    return np.lib.stride_tricks.sliding_window_view(ways, 2 * ABOUT).max(axis=1)


def _first_to_last(seen: np.ndarray, aside: int = 0) -> slice:
    """The places from the first to the last that is seen, and so many more at both ends."""
    places = np.flatnonzero(seen)
    if not len(places):
        return slice(0, 0)
    return slice(max(int(places[0]) - aside, 0), min(int(places[-1]) + 1 + aside, len(seen)))


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


class _Points(AxesImage):
    """An image in shades of one colour, which differ in their opacity; masked cells are blank.

    Where cells do not fit pixels, matplotlib interpolates red, green, blue and opacity with much
    around it. Only the last one varies here, in 256 levels, which is what Pillow is made for.
    """

    def make_image(
        self, renderer: Any, magnification: float = 1.0, unsampled: bool = False
    ) -> tuple[Any, float, float, Any]:
        """The pixels from the lowest row up, and where their left lower corner is, in pixels.

        magnification: pixels of the image to a pixel of the figure, which are larger in an SVG.
        """
        ends = self.get_window_extent()
        if ends.width <= 0.0 or ends.height <= 0.0:  # somebody has turned an axis round
            return super().make_image(renderer, magnification, unsampled)
        cells: Any = self.get_array()
        # Blank cells on all sides, since pixels at the ends of an image are covered in part.
        levels = np.zeros([count + 2 * AROUND for count in cells.shape], np.uint8)
        shown = ~np.ma.getmaskarray(cells)
        inside = levels[AROUND:-AROUND, AROUND:-AROUND]
        inside[shown] = self.to_rgba(cells.data[shown], bytes=True)[:, 3]

        seen = self.axes.bbox
        columns = _Pixels.of(ends.intervalx, seen.intervalx, cells.shape[1], magnification)
        rows = _Pixels.of(ends.intervaly, seen.intervaly, cells.shape[0], magnification)
        if columns.count < 1 or rows.count < 1:
            return None, 0.0, 0.0, None
        opacity = Pillow.fromarray(levels).resize(
            (columns.count, rows.count),
            Pillow.Resampling.HAMMING,
            box=(columns.first_cell, rows.first_cell, columns.last_cell, rows.last_cell),
        )
        pixels = np.empty((rows.count, columns.count, 4), np.uint8)
        for channel, level in enumerate(self.cmap(1.0, bytes=True)[:3]):
            pixels[..., channel] = level
        pixels[..., 3] = np.asarray(opacity)
        return pixels, columns.begin / magnification, rows.begin / magnification, None


@dataclass(frozen=True)
class _Pixels:
    """The pixels that show an image along one axis, whole ones, and which part of it they show.

    The cells are counted from the first of AROUND blank ones, and may be parts of cells.
    """

    begin: int
    count: int
    first_cell: float
    last_cell: float

    @classmethod
    def of(cls, ends: Any, seen: Any, cells: int, magnification: float) -> _Pixels:
        """Of an image of so many cells between two ends; seen: those of the axes, in pixels."""
        low, high = (end * magnification for end in ends)
        cell = (high - low) / cells
        low -= AROUND * cell
        high += AROUND * cell
        first_seen, last_seen = (round(end * magnification) for end in seen)
        begin = max(ceil(low), first_seen)
        end = min(floor(high), last_seen)
        last_cell = min((end - low) / cell, cells + 2.0 * AROUND)  # beyond it by rounding alone
        return cls(begin, end - begin, (begin - low) / cell, last_cell)


def seen_wide(axes: Axes) -> float:
    """How many pixels wide the axes are."""
    return float(axes.get_window_extent().width)


def pooled(shares: Any, ends: Ends) -> tuple[Any, Ends]:
    """Two by two cells as one, the fullest of the four, and where these end."""
    rows, columns = shares.shape
    filled = np.pad(np.ma.filled(shares, 0.0), ((0, rows % 2), (0, columns % 2)))
    left, right, bottom, top = ends
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
        self._places = np.zeros((columns.bins, height), dtype=np.float32)  # sums, within cells
        self._totals = np.zeros(columns.bins, dtype=np.int64)
        self._most = 0  # points of a speed

    def take(self, speed: int, values: np.ndarray) -> None:
        """Count finite values of a speed; those outside low..high do not show."""
        bin_ = self.columns.bin_of_speed[speed]
        if bin_ < 0:
            return
        self._totals[bin_] += len(values)
        self._most = max(self._most, len(values))
        seen = values[(values >= self.low) & (values <= self.high)]
        place = (seen - self.low) * (self.height / (self.high - self.low))
        row = np.minimum(place.astype(np.int64), self.height - 1)
        self._cells[bin_] += np.bincount(row, minlength=self.height)
        self._places[bin_] += np.bincount(row, place - row, minlength=self.height)

    def shares(self, shown: Any = True, thickness: int = THICKNESS) -> tuple[Any, Ends]:
        """Share of a column's points per cell, and where the cells end on both axes.

        A masked array of rows from the lowest up and columns; blank ones at the ends of the image
        are left out. shown: of all bins, or of each, whether it is. thickness: cells of a point, an
        odd number.
        """
        some = np.flatnonzero((self._totals > 0) & shown)  # bins that are not blank
        counts = self._cells[some]
        rows = _first_to_last(np.any(counts, axis=0), thickness // 2)
        cells = (counts[:, rows] / self._totals[some, None]).astype(np.float32)
        thick = np.zeros((len(some) + 1, cells.shape[1]), np.float32)  # the last one is blank
        thick[:-1] = _raised(cells, thickness)
        row_of_bin = np.full(self.columns.bins + 1, len(some))  # bin -1 is blank too
        row_of_bin[some] = np.arange(len(some))
        row_of_column = row_of_bin[self.columns.bin_of_column]
        columns = _first_to_last(np.less(row_of_column, len(some)))
        in_columns = np.take(thick.T, row_of_column[columns], axis=1)
        return self._cropped(in_columns, rows.start, columns.start)

    def _cropped(self, shown: np.ndarray, first_row: int, first_column: int) -> tuple[Any, Ends]:
        """Cells without the blank ones around them, which are masked, and where they end.

        first_row, first_column: where in the image the cells begin.
        """
        blank = shown == 0.0
        rows = _first_to_last(~blank.all(axis=1))
        columns = _first_to_last(~blank.all(axis=0))
        cells = np.ma.array(shown[rows, columns], mask=blank[rows, columns], fill_value=0.0)
        cell_wide = (self.columns.high - self.columns.low) / self.columns.bin_of_column.size
        span = self.high - self.low
        ends = (
            self.columns.low + (first_column + columns.start) * cell_wide,
            self.columns.low + (first_column + columns.stop) * cell_wide,
            self.low + (first_row + rows.start) * span / self.height,
            self.low + (first_row + rows.stop) * span / self.height,
        )
        return cells, ends

    def _paper(self) -> tuple[np.ndarray, np.ndarray]:
        """How many cells of each bin have points, and what paper about it there is for these.

        Returns (bins,) and, as shares of the panel's sides, (4, bins): the way to the next bin,
        that to the next one with any points, the widest about there, and the bands in which points
        are.
        """
        columns = self.columns
        some = np.flatnonzero(self._totals)
        crowd = np.count_nonzero(self._cells, axis=1)
        room = columns.room_of_bin.copy()
        if len(some) > 1:
            room[some] = _nearest(columns.place_of_bin[some])
        ends = np.linspace(0, self.height, BANDS + 1).astype(int)[:-1]
        bands = np.count_nonzero(np.add.reduceat(self._cells, ends, axis=1), axis=1)
        wide = columns.high - columns.low
        ways = np.array([columns.room_of_bin, room, columns.way_of_bin]) / wide
        return crowd, np.vstack([ways, bands / BANDS])

    def _draw_discs(self, axes: Axes, colour: str, norm: Any, ends: Any) -> np.ndarray:
        """Draw points as discs, and return for which bins discs have no room."""
        crowd, shares = self._paper()
        box = axes.get_window_extent()
        sides = [length / style.DPI * MM_PER_INCH for length in (box.width, box.height)]
        step, room, spread = shares[[0, 1, 3]] * [sides[:1], sides[:1], sides[1:]]
        close = step <= sides[0] * FILLED / self.columns.bin_of_column.size
        full: np.ndarray = close & have_no_room(crowd, step, room, spread)
        bins, rows = np.nonzero(self._cells * ~full[:, None])
        if len(bins):
            counts = self._cells[bins, rows]
            cell = (self.high - self.low) / self.height
            y = self.low + cell * (rows + self._places[bins, rows] / counts)
            least, most = ends
            discs = Discs(
                axes,
                colour,
                np.column_stack([self.columns.place_of_bin[bins], y]),
                least + (most - least) * norm(counts / self._totals[bins]),
                shares[:, bins],
                crowd[bins],
                self.thickness / THICKNESS,
            )
            discs.set_clip_path(axes.patch)
            axes.add_image(discs)
        return full

    def draw(self, axes: Axes, colour: str = "black", opaque: float = 1.0) -> None:
        """The image over its range, which becomes that of the axes.

        The more of a column's points a cell has, the less of what lies behind it shows, up to
        `opaque`. In a narrow panel two by two cells make one, which shows the fuller of them. Fewer
        pixels than cells show the mean of these, so that no line breaks.
        """
        least = min(1.0 / max(1, self._most), 0.1 * FULLEST)
        axes.set(xlim=(self.columns.low, self.columns.high), ylim=(self.low, self.high))
        norm = _Given(least, FULLEST, clip=True)
        opacities = palest(colour) * opaque, opaque
        full = self._draw_discs(axes, colour, norm, opacities)
        narrow = seen_wide(axes) * POOLED < self.columns.bin_of_column.size
        thickness = self.thickness - (THICKNESS - 1 if narrow else 0)  # a pooled cell is a point
        shares, ends = self.shares(full, thickness)
        if not shares.size:
            return
        if narrow:
            shares, ends = pooled(shares, ends)
        shades = [to_rgba(colour, opacity) for opacity in opacities]
        colours: Any = LinearSegmentedColormap.from_list("points", shades)
        colours = colours.with_extremes(bad=to_rgba(colour, 0.0))
        image = _Points(
            axes, extent=ends, origin="lower", interpolation="antialiased",
            cmap=colours, norm=norm, zorder=2,
        )  # fmt: skip
        image.set_data(shares)
        image.set_clip_path(axes.patch)
        axes.add_image(image)


def is_free(axes: Axes, box: Any) -> bool:
    """Whether none of the images on axes has points in a box, which counts in pixels."""
    places = axes.transData.inverted().transform(box.get_points())
    (left, bottom), (right, top) = places
    for image in axes.images:
        if isinstance(image, Discs):
            x, y = image.places.T
        else:
            x, y = _filled_cells(image)
        if ((x >= left) & (x <= right) & (y >= bottom) & (y <= top)).any():
            return False
    return True


def _filled_cells(image: Any) -> tuple[np.ndarray, np.ndarray]:
    """Where the middles of the cells are that are not blank, on the image's axes."""
    shown = ~np.ma.getmaskarray(image.get_array())
    rows, columns = np.nonzero(shown)
    left, right, bottom, top = image.get_extent()
    x = left + (columns + 0.5) * (right - left) / shown.shape[1]
    y = bottom + (rows + 0.5) * (top - bottom) / shown.shape[0]
    return x, y
