"""Aperiodic attractors: recognised by recurrence, told apart by the boxes they visit.

A record that has run long is aperiodic and settled where its second half visits hardly any box of
the section that its first half has not. Two such records are of one attractor where their boxes
meet. A start belongs to it after so many turns in its boxes in a row that no trial start did the
same and went elsewhere: every box is tried from its centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camcli.analysis.basins.region import CaptureRegion
from camcli.kernel.cells import Targets

SIDE = 96  # boxes along each side of the visited range
NEW = 0.02  # share of the second half's turns in boxes the first half has not seen
LEAST_STAY, MOST_STAY = 16, 500  # turns
STAY_MARGIN = 2  # times the longest stay of a trial that went elsewhere
NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]


@dataclass(frozen=True)
class Grid:
    """SIDE x SIDE boxes over the visited range and two spare ones at each edge; m, m/rad."""

    gap: float
    rate: float
    per_gap: float
    per_rate: float
    side: int = SIDE + 4

    @classmethod
    def over(cls, points: np.ndarray) -> Grid:
        """The grid of states (gap, rate)."""
        low, high = points.min(axis=0), points.max(axis=0)
        step = np.maximum(high - low, 1e-12) / SIDE
        return cls(*(low - 2.0 * step).tolist(), *(1.0 / step).tolist())

    def boxes(self, points: np.ndarray) -> np.ndarray:
        """Flat box index of each state inside."""
        x = ((points[:, 0] - self.gap) * self.per_gap).astype(np.int64)
        y = ((points[:, 1] - self.rate) * self.per_rate).astype(np.int64)
        return np.clip(y, 0, self.side - 1) * self.side + np.clip(x, 0, self.side - 1)

    def centres(self, boxes: np.ndarray) -> np.ndarray:
        """(n, 2) states at the centres, none below the cam."""
        gap = self.gap + (boxes % self.side + 0.5) / self.per_gap
        rate = self.rate + (boxes // self.side + 0.5) / self.per_rate
        return np.column_stack((np.maximum(gap, 0.0), rate))


@dataclass(frozen=True)
class Boxes:
    """The boxes of all aperiodic attractors of one speed; `owner` is 1 + their index, or 0."""

    grid: Grid
    owner: np.ndarray
    stays: list[int]

    def fill(self, targets: Targets) -> Targets:
        """The kernel's table with these boxes."""
        grid = self.grid
        return targets._replace(
            boxes=self.owner, stay=self.stays, gap=grid.gap, rate=grid.rate,
            per_gap=grid.per_gap, per_rate=grid.per_rate, columns=grid.side, rows=grid.side,
        )  # fmt: skip


def is_recurrent(points: np.ndarray) -> bool:
    """True where the second half of a record stays in the boxes of the first."""
    boxes = Grid.over(points).boxes(points)
    half = len(boxes) // 2
    new = ~np.isin(boxes[half:], boxes[:half])
    return float(new.mean()) <= NEW


def meet(a: np.ndarray, b: np.ndarray) -> bool:
    """True where two records visit a common box."""
    grid = Grid.over(np.concatenate((a, b)))
    return bool(np.isin(grid.boxes(a), grid.boxes(b)).any())


def boxes_of(
    records: dict[int, np.ndarray], regions: list[CaptureRegion | None], count: int
) -> Boxes:
    """Boxes visited by each record and those around them, but none near a periodic attractor.

    `records` maps the index of an attractor to its states (gap, rate).
    """
    grid = Grid.over(np.concatenate(list(records.values())))
    owner = np.zeros(grid.side * grid.side, dtype=np.int64)
    for offset in sorted(NEIGHBOURS, key=lambda o: o != (0, 0), reverse=True):
        for k in sorted(records):
            boxes = grid.boxes(records[k]) + offset[0] * grid.side + offset[1]
            owner[np.clip(boxes, 0, len(owner) - 1)] = k + 1
    for region in regions:
        if region is not None:
            _clear(owner, grid, region)
    return Boxes(grid, owner, [1 << 40] * count)


def _clear(owner: np.ndarray, grid: Grid, region: CaptureRegion) -> None:
    """Take the boxes that a periodic attractor's capture region touches out of `owner`."""
    table = owner.reshape(grid.side, grid.side)
    for point, half in zip(region.points, region.half_widths(), strict=True):
        x = (point[0] + np.array([-half[0], half[0]]) - grid.gap) * grid.per_gap
        y = (point[1] + np.array([-half[1], half[1]]) - grid.rate) * grid.per_rate
        (x0, x1), (y0, y1) = (np.clip(np.floor(z), -1, grid.side).astype(int) for z in (x, y))
        table[max(y0, 0) : y1 + 1, max(x0, 0) : x1 + 1] = 0


def stays_of(boxes: Boxes, tried: np.ndarray, ended: np.ndarray, stay: np.ndarray) -> list[int]:
    """Turns that decide, per attractor; of trials: box, owner of the end, longest stay."""
    lengths = list(boxes.stays)
    for k in sorted(set(boxes.owner[boxes.owner > 0].tolist())):
        astray = (boxes.owner[tried] == k) & (ended != k)
        lengths[k - 1] = LEAST_STAY + STAY_MARGIN * int(stay[astray].max(initial=0))
    return lengths
