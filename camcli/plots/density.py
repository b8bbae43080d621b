"""What the picture of a sweep shows: points counted per pixel, ranges, the cam's curves.

A sweep may hold more points than memory: they are seen in batches, and only what each speed's
points come to, and the pixels, is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camcli.cams.compile import column
from camcli.kernel.cam_table import PIECE, TERMS, Cam
from camcli.plots.batches import add_all

TURN_DEG = 360.0
WIDEST = 8  # px, column of one speed where there are few
THICKNESS = 2  # px, of a branch
NARROW_DEG = 120.0  # impact phases within less are shown enlarged
ENLARGED_SHARE = 0.4  # of the speeds, for a panel of their own


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
        add_all(columns, cloud.take)
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
    """Which pixel column shows which speed, over the range low..high of rpm.

    Up to one speed per pixel, a speed fills its columns (WIDEST at most); beyond, the speeds of a
    pixel are counted together. `bin_of_speed` and `bin_of_column` meet in the bins; -1 is blank.
    """

    low: float
    high: float
    bins: int
    bin_of_speed: np.ndarray
    bin_of_column: np.ndarray

    @property
    def width(self) -> int:
        """Of the picture, in pixels."""
        return len(self.bin_of_column)

    @classmethod
    def of(cls, rpms: Sequence[float], width: int) -> Columns:
        """From speeds in any order and the width of the picture in pixels."""
        every = np.asarray(rpms, dtype=float)
        order = np.argsort(every, kind="stable")
        speeds = every[order]
        low, high = _outer(speeds)
        place = (speeds - low) / (high - low) * width
        pixels = np.arange(width)
        bins = np.empty(len(speeds), dtype=int)
        if len(speeds) > width:
            bins[order] = np.minimum(place.astype(int), width - 1)
            return cls(low, high, width, bins, pixels)
        bins[order] = np.arange(len(speeds))
        nearest = np.searchsorted((place[1:] + place[:-1]) / 2.0, pixels + 0.5)
        far = np.abs(pixels + 0.5 - place[nearest]) > WIDEST / 2.0
        return cls(low, high, len(speeds), bins, np.where(far, -1, nearest))

    def totals(self, cloud: Cloud) -> np.ndarray:
        """Values in every bin."""
        return np.bincount(self.bin_of_speed, weights=cloud.count, minlength=self.bins)


def _outer(speeds: np.ndarray) -> tuple[float, float]:
    """Ends of the rpm axis: half a step beyond the speeds, less where they are few."""
    low, high = float(speeds[0]), float(speeds[-1])
    if high <= low:
        pad = max(abs(low) * 0.01, 1e-6)
    else:
        pad = (high - low) * min(0.5 / (len(speeds) - 1), 0.02)
    return low - pad, high + pad


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
        cell = self.columns.bin_of_speed[owner] * self.height + row
        seen = (row >= 0) & (row < self.height)
        if not seen.all():
            cell = cell[seen]
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
        picture = np.where(wide < 0, 0.0, thick[wide].T)
        return np.ma.masked_equal(picture, 0.0)


def shares(
    values: Sequence, cloud: Cloud, columns: Columns, low: float, high: float, height: int
) -> np.ndarray:
    """Picture of one column of values per speed, whose `cloud` is known; see Pixels.shares."""
    pixels = Pixels(columns, low, high, height)
    add_all(values, pixels.take)
    return pixels.shares(cloud)


def one_point(clouds: Sequence[Cloud], columns: Columns) -> float:
    """The share that a single point has in the column with most of them."""
    return 1.0 / max([1, *(int(columns.totals(cloud).max(initial=0)) for cloud in clouds)])


def padded(values: np.ndarray, constant: float) -> tuple[float, float]:
    """Range of the values with a margin; `constant` on either side where they do not vary."""
    if not len(values):
        return 0.0, 1.0
    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        return low - constant, high + constant
    return low - 0.04 * (high - low), high + 0.04 * (high - low)


def phase_range(cloud: Cloud) -> tuple[float, float]:
    """Phases to show, degrees: those of the impacts where they are close, else the whole turn."""
    values = cloud.extremes()
    if not len(values):
        return 0.0, TURN_DEG
    low, high = padded(values, 5.0)
    if high - low > NARROW_DEG:
        return 0.0, TURN_DEG
    return max(low, 0.0), min(high, TURN_DEG)


def enlarged_range(cloud: Cloud) -> tuple[float, float] | None:
    """Phases that deserve an enlarged panel: many speeds impact there and nowhere else."""
    if phase_range(cloud) != (0.0, TURN_DEG):
        return None
    low, high = cloud.ends()
    narrow = high - low <= NARROW_DEG / 2.0
    if not len(low) or narrow.mean() < ENLARGED_SHARE:
        return None
    low, high = padded(np.concatenate([low[narrow], high[narrow]]), 5.0)
    return (max(low, 0.0), min(high, TURN_DEG)) if high - low <= NARROW_DEG else None


def lift_curves(cam: Cam, count: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Phases in degrees, and there c and its first derivatives by theta; nan between stretches."""
    pieces = np.asarray(cam.pieces, dtype=float).reshape(-1, PIECE)
    theta, orders = [], [[] for _ in range(count)]
    columns = [column(cam, name) for name in ("START", "END", "FIRST", "COUNT")]
    for start, end, first, number in zip(*columns, strict=True):
        x = np.linspace(start, end, 2 + int((end - start) * 200))
        k = ((x - start) / (end - start) * number).astype(int)
        piece = pieces[int(first) + np.minimum(k, int(number) - 1)]
        powers = (x - piece[:, 0])[:, None] ** np.arange(TERMS)
        theta += [np.degrees(x), [np.nan]]
        for order, rows in enumerate(orders):
            terms = piece[:, 1 + order * TERMS : 1 + (order + 1) * TERMS]
            rows += [(terms * powers).sum(axis=1), [np.nan]]
    return np.concatenate(theta), [np.concatenate(rows) for rows in orders]
