"""What the picture of a sweep shows: points counted per pixel, ranges, the cam's curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from camcli.kernel.profile import PIECE, TERMS, Cam
from camcli.profiles.table import column

TURN_DEG = 360.0
WIDEST = 8  # px, column of one speed where there are few
THICKNESS = 2  # px, of a branch
NARROW_DEG = 120.0  # impact phases within less are shown enlarged
ENLARGED_SHARE = 0.4  # of the speeds, for a panel of their own


@dataclass(frozen=True)
class Cloud:
    """Finite values of all speeds, end to end, with the index of the speed each belongs to."""

    values: np.ndarray
    owner: np.ndarray

    @classmethod
    def of(cls, columns: Sequence) -> Cloud:
        """From one column of values per speed (lists or arrays)."""
        arrays = [np.asarray(column, dtype=float) for column in columns]
        values = np.concatenate([*arrays, np.empty(0)])
        owner = np.repeat(np.arange(len(arrays)), [len(array) for array in arrays])
        finite = np.isfinite(values)
        return cls(values[finite], owner[finite])

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Smallest and largest value of every speed that has any."""
        first = np.flatnonzero(np.diff(self.owner, prepend=-1))
        if not len(first):
            return np.empty(0), np.empty(0)
        return np.minimum.reduceat(self.values, first), np.maximum.reduceat(self.values, first)


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
        """From ascending speeds and the width of the picture in pixels."""
        speeds = np.asarray(rpms, dtype=float)
        low, high = _outer(speeds)
        place = (speeds - low) / (high - low) * width
        pixels = np.arange(width)
        if len(speeds) > width:
            return cls(low, high, width, np.minimum(place.astype(int), width - 1), pixels)
        nearest = np.searchsorted((place[1:] + place[:-1]) / 2.0, pixels + 0.5)
        far = np.abs(pixels + 0.5 - place[nearest]) > WIDEST / 2.0
        return cls(low, high, len(speeds), np.arange(len(speeds)), np.where(far, -1, nearest))


def _outer(speeds: np.ndarray) -> tuple[float, float]:
    """Ends of the rpm axis: half a step beyond the speeds, less where they are few."""
    low, high = float(speeds[0]), float(speeds[-1])
    if high <= low:
        pad = max(abs(low) * 0.01, 1e-6)
    else:
        pad = (high - low) * min(0.5 / (len(speeds) - 1), 0.02)
    return low - pad, high + pad


def shares(cloud: Cloud, columns: Columns, low: float, high: float, height: int) -> np.ndarray:
    """Picture (height, width), row 0 at `low`: share of a column's points in a pixel, or masked.

    Branches are THICKNESS pixels thick. Points outside low..high count, but do not show.
    """
    row = np.floor((cloud.values - low) * (height / (high - low))).astype(np.int64)
    row[cloud.values == high] = height - 1
    bins = columns.bin_of_speed[cloud.owner]
    seen = (row >= 0) & (row < height)
    cells = np.bincount(bins[seen] * height + row[seen], minlength=columns.bins * height)
    cells = cells.reshape(columns.bins, height).astype(float)
    cells /= np.maximum(np.bincount(bins, minlength=columns.bins), 1)[:, None]
    thick = cells.copy()
    for k in range(1, THICKNESS):
        thick[:, :-k] = np.maximum(thick[:, :-k], cells[:, k:])
    picture = np.where(columns.bin_of_column < 0, 0.0, thick[columns.bin_of_column].T)
    return np.ma.masked_equal(picture, 0.0)


def one_point(clouds: Sequence[Cloud], columns: Columns) -> float:
    """The share that a single point has in the column with most of them."""
    totals = [np.bincount(columns.bin_of_speed[cloud.owner]) for cloud in clouds]
    return 1.0 / max([1, *(int(total.max(initial=0)) for total in totals)])


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
    if not len(cloud.values):
        return 0.0, TURN_DEG
    low, high = padded(cloud.values, 5.0)
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
