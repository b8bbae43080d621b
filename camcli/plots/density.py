"""Clouds of points over speed as images: which share of a column's points each pixel holds.

A sweep may hold more points than memory: they are seen in batches, and only what each speed's
points come to, and the pixels, is kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, LogNorm
from matplotlib.image import AxesImage

BATCH = 1 << 18  # values held at a time
WIDEST = 8  # px, column of one speed where there are few
THICKNESS = 2  # px, of a branch
FULLEST = 0.1  # share of a column's points per pixel from which it is darkest

Take = Callable[[np.ndarray, np.ndarray], None]  # owners (indices of speeds) and their values


class Batches:
    """Columns of values, one or more per speed, handed on some at a time.

    `take(owner, values)` gets finite values, those of a speed together, and the index of the
    speed of each; no Python runs per value.
    """

    def __init__(self, take: Take) -> None:
        self._take = take
        self._owners: list[int] = []
        self._parts: list[np.ndarray] = []
        self._held = 0

    def add(self, owner: int, values: Sequence[float] | np.ndarray) -> None:
        """A column of the speed `owner`; it is copied, since it may be a buffer used again."""
        for begin in range(0, len(values), BATCH):
            part = np.array(values[begin : begin + BATCH], dtype=float)
            self._owners.append(owner)
            self._parts.append(part)
            self._held += len(part)
            if self._held >= BATCH:
                self.flush()

    def flush(self) -> None:
        """Hand on what is held; call it at the end."""
        if not self._parts:
            return
        values = np.concatenate(self._parts)
        owner = np.repeat(self._owners, [len(part) for part in self._parts])
        self._owners, self._parts, self._held = [], [], 0
        finite = np.isfinite(values)
        if finite.any():
            self._take(owner[finite], values[finite])


def take_all(columns: Iterable[Sequence[float] | np.ndarray], take: Take) -> None:
    """Hand on one column of values per speed."""
    batches = Batches(take)
    for owner, values in enumerate(columns):
        batches.add(owner, values)
    batches.flush()


@dataclass(frozen=True)
class Cloud:
    """How many finite values every speed has, the smallest (inf if none), the largest (-inf)."""

    low: np.ndarray
    high: np.ndarray
    count: np.ndarray

    @classmethod
    def empty(cls, speeds: int) -> Cloud:
        """Before any value is taken."""
        return cls(np.full(speeds, np.inf), np.full(speeds, -np.inf), np.zeros(speeds, np.int64))

    @classmethod
    def of(cls, columns: Sequence) -> Cloud:
        """From one column of values per speed (lists or arrays)."""
        cloud = cls.empty(len(columns))
        take_all(columns, cloud.take)
        return cloud

    def take(self, owner: np.ndarray, values: np.ndarray) -> None:
        """More values, with the speed of each; those of a speed stand together."""
        first = np.flatnonzero(np.diff(owner, prepend=-1))
        own = owner[first]
        self.low[own] = np.minimum(self.low[own], np.minimum.reduceat(values, first))
        self.high[own] = np.maximum(self.high[own], np.maximum.reduceat(values, first))
        self.count[own] += np.diff(first, append=len(owner))

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest value of every speed that has any."""
        some = self.count > 0
        return self.low[some], self.high[some]

    def extremes(self) -> np.ndarray:
        """Smallest and largest value of all; empty where there is none."""
        low, high = self.ends()
        return np.array([low.min(), high.max()]) if len(low) else np.empty(0)


@dataclass(frozen=True)
class Columns:
    """Which pixel column shows which speed, over the range low..high of the axis.

    Up to one speed per pixel, a speed fills its columns (`widest` at most); beyond, the speeds of
    a pixel are counted together. `bin_of_speed` and `bin_of_column` meet in the bins; -1 is blank.
    """

    low: float
    high: float
    bins: int
    bin_of_speed: np.ndarray
    bin_of_column: np.ndarray

    @classmethod
    def of(
        cls,
        speeds: Sequence[float] | np.ndarray,
        width: int,
        widest: float = WIDEST,
        ends: tuple[float, float] | None = None,
    ) -> Columns:
        """From speeds in any order, the width of the picture in pixels, the ends of its axis."""
        every = np.asarray(speeds, dtype=float)
        order = np.argsort(every, kind="stable")
        rising = every[order]
        low, high = ends or _ends(rising)
        place = (rising - low) / (high - low) * width
        pixels = np.arange(width)
        bins = np.empty(len(rising), dtype=int)
        if len(rising) > width:
            bins[order] = np.minimum(place.astype(int), width - 1)
            return cls(low, high, width, bins, pixels)
        bins[order] = np.arange(len(rising))
        nearest = np.searchsorted((place[1:] + place[:-1]) / 2.0, pixels + 0.5)
        far = np.abs(pixels + 0.5 - place[nearest]) > widest / 2.0
        return cls(low, high, len(rising), bins, np.where(far, -1, nearest))

    def totals(self, cloud: Cloud) -> np.ndarray:
        """Values in every bin."""
        return np.bincount(self.bin_of_speed, weights=cloud.count, minlength=self.bins)


def _ends(rising: np.ndarray) -> tuple[float, float]:
    """Ends of the axis: half a step beyond the speeds, less where they are few."""
    low, high = float(rising[0]), float(rising[-1])
    if high <= low:
        room = max(abs(low) * 0.01, 1e-6)
    else:
        room = (high - low) * min(0.5 / (len(rising) - 1), 0.02)
    return low - room, high + room


class Pixels:
    """Values counted per bin and row of a picture of `height` rows from `low` to `high`."""

    def __init__(self, columns: Columns, low: float, high: float, height: int) -> None:
        self.columns, self.low, self.high, self.height = columns, low, high, height
        self._cells = np.zeros(columns.bins * height, dtype=np.int64)

    def take(self, owner: np.ndarray, values: np.ndarray) -> None:
        """Count values, with the speed of each; those outside low..high do not show."""
        scale = self.height / (self.high - self.low)
        row = np.floor((values - self.low) * scale).astype(np.int64)
        row[values == self.high] = self.height - 1
        seen = (row >= 0) & (row < self.height)
        cell = (self.columns.bin_of_speed[owner] * self.height + row)[seen]
        if len(cell):
            first = cell.min()  # a batch is of few bins where the speeds are in order
            counts = np.bincount(cell - first)
            self._cells[first : first + len(counts)] += counts

    def shares(self, cloud: Cloud) -> np.ndarray:
        """Picture (height, width), row 0 at `low`: share of a column's points per pixel, or masked.

        Branches are THICKNESS pixels thick; `cloud` tells how many points a column has.
        """
        cells = self._cells.reshape(self.columns.bins, self.height).astype(float)
        cells /= np.maximum(self.columns.totals(cloud), 1)[:, None]
        thick = cells.copy()
        for k in range(1, THICKNESS):
            thick[:, :-k] = np.maximum(thick[:, :-k], cells[:, k:])
        wide = self.columns.bin_of_column
        return np.ma.masked_equal(np.where(wide < 0, 0.0, thick[wide].T), 0.0)


def shading(clouds: Sequence[Cloud], columns: Columns) -> LogNorm:
    """From the share that a single point has in the fullest column to FULLEST."""
    most = max([1, *(int(columns.totals(cloud).max(initial=0)) for cloud in clouds)])
    return LogNorm(min(1.0 / most, 0.1 * FULLEST), FULLEST, clip=True)


def draw_shares(
    axes: Axes, pixels: Pixels, cloud: Cloud, shades: Colormap, norm: LogNorm
) -> AxesImage:
    """The points as one image on the pixels of the panel, which has the size of the picture."""
    extent = (pixels.columns.low, pixels.columns.high, pixels.low, pixels.high)
    return axes.imshow(
        pixels.shares(cloud),
        extent=extent,
        origin="lower",
        aspect="auto",
        interpolation="none",
        cmap=shades,
        norm=norm,
        zorder=2,
    )
