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
        """The grid over states (gap, rate), (n, 2)."""
        low = points.min(axis=0)
        high = points.max(axis=0)
        step = np.maximum(high - low, 1e-12) / SIDE
        gap, rate = (low - 2.0 * step).tolist()
        per_gap, per_rate = (1.0 / step).tolist()
        return cls(gap, rate, per_gap, per_rate)

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

    `records` maps the index of an attractor to its states (gap, rate), (n, 2); regions: those of
    all attractors, None for the aperiodic ones; count: of all attractors. A box that several
    records visit belongs to the last of them, and one that a record visits to no neighbour's.
    Stays are not known yet: longer than any.
    """
    grid = Grid.over(np.concatenate(list(records.values())))
    owner = np.zeros(grid.side * grid.side, dtype=np.int64)
    visited_last = sorted(NEIGHBOURS, key=lambda offset: offset == (0, 0))
    for rows_up, columns_right in visited_last:
        for k in sorted(records):
            boxes = grid.boxes(records[k]) + rows_up * grid.side + columns_right
            owner[np.clip(boxes, 0, len(owner) - 1)] = k + 1
    for region in regions:
        if region is not None:
            _clear(owner, grid, region)
    return Boxes(grid, owner, [1 << 40] * count)


def _clear(owner: np.ndarray, grid: Grid, region: CaptureRegion) -> None:
    """Take the boxes that a periodic attractor's capture region touches out of `owner`."""
    table = owner.reshape(grid.side, grid.side)  # a row for each rate, a column for each gap
    for point, half_width in zip(region.points, region.half_widths(), strict=True):
        low_gap, low_rate = point - half_width
        high_gap, high_rate = point + half_width
        first_column = _index((low_gap - grid.gap) * grid.per_gap, grid.side)
        last_column = _index((high_gap - grid.gap) * grid.per_gap, grid.side)
        first_row = _index((low_rate - grid.rate) * grid.per_rate, grid.side)
        last_row = _index((high_rate - grid.rate) * grid.per_rate, grid.side)
        table[max(first_row, 0) : last_row + 1, max(first_column, 0) : last_column + 1] = 0


def _index(boxes: float, side: int) -> int:
    """The row or column that is so many boxes up; -1 below the first, `side` above the last."""
    return int(np.clip(np.floor(boxes), -1, side))


def stays_of(boxes: Boxes, tried: np.ndarray, ended: np.ndarray, stay: np.ndarray) -> list[int]:
    """Turns in its boxes that decide, for each attractor.

    tried, ended, stay: of trials, the box they began in, the owner of where they ended (0: none),
    and their longest stay in boxes of one attractor. More turns are needed than the longest stay of
    a trial that began in a box of the attractor and ended elsewhere.
    """
    lengths = list(boxes.stays)
    for owner in sorted(set(boxes.owner[boxes.owner > 0].tolist())):
        astray = (boxes.owner[tried] == owner) & (ended != owner)
        lengths[owner - 1] = LEAST_STAY + STAY_MARGIN * int(stay[astray].max(initial=0))
    return lengths
