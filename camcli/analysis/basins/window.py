"""The window of starts and its cells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Window:
    """Starts at the strobe phase: q in m, v in m/s; cell n is in row n // nq, column n % nq."""

    q: tuple[float, float]
    v: tuple[float, float]
    nq: int
    nv: int

    @property
    def count(self) -> int:
        """Number of cells."""
        return self.nq * self.nv

    def halved(self, levels: int = 1) -> Window:
        """The same window with every cell cut in four, `levels` times."""
        return replace(self, nq=self.nq << levels, nv=self.nv << levels)

    def with_cells(self, nq: int, nv: int) -> Window:
        """The same window with other cells."""
        return replace(self, nq=nq, nv=nv)

    def q_of(self, columns) -> np.ndarray:
        """Centres along q of columns, m."""
        return _centres(self.q, np.asarray(columns), self.nq)

    def v_of(self, rows) -> np.ndarray:
        """Centres along v of rows, m/s."""
        return _centres(self.v, np.asarray(rows), self.nv)

    def centres(self, cells) -> tuple[np.ndarray, np.ndarray]:
        """(q, v) of the centres of cells."""
        cells = np.asarray(cells)
        return self.q_of(cells % self.nq), self.v_of(cells // self.nq)


def _centres(span: tuple[float, float], n: np.ndarray, count: int) -> np.ndarray:
    """Centres of the cells n of `count` equal ones from the low to the high end of a span."""
    low, high = span
    return low + (high - low) * ((2 * n + 1) / (2 * count))
