"""Symmetric positive definite band systems by Cholesky's LDL', in plain floats.

LAPACK may give other last bits on another machine; IEEE add, multiply and divide in a fixed order
do not. No `sum` of floats: its rounding depends on the version of Python.
"""

from __future__ import annotations

from collections.abc import Sequence


class Banded:
    """Factors of a symmetric matrix whose rows hold the band below the diagonal.

    `rows[i][k]` is the element (i, i - k) for k <= `band`.
    """

    def __init__(self, rows: Sequence[Sequence[float]]):
        self.band = len(rows[0]) - 1
        self.lower: list[list[float]] = []
        self.pivots: list[float] = []
        for i, row in enumerate(rows):
            self._eliminate(i, list(row))

    def _eliminate(self, i: int, row: list[float]) -> None:
        """Turn row i into factors: lower[i][k] = L(i, i - k) and the pivot."""
        lower, pivots = self.lower, self.pivots
        reach = min(i, self.band)
        scaled = [0.0] * (self.band + 1)  # L(i, j) D(j)
        for k in range(reach, 0, -1):
            j = i - k
            value, above = row[k], lower[j]
            for m in range(1, min(reach - k, self.band) + 1):
                value -= scaled[k + m] * above[m]
            scaled[k] = value
        pivot = row[0]
        for k in range(1, reach + 1):
            row[k] = scaled[k] / pivots[i - k]
            pivot -= scaled[k] * row[k]
        lower.append(row)
        pivots.append(pivot)

    def solve(self, right: Sequence[float]) -> list[float]:
        """The solution for one right-hand side."""
        x = list(right)
        n = len(x)
        for i in range(n):
            value, row = x[i], self.lower[i]
            for k in range(1, min(i, self.band) + 1):
                value -= row[k] * x[i - k]
            x[i] = value
        for i in range(n):
            x[i] /= self.pivots[i]
        for i in range(n - 1, -1, -1):
            value, row = x[i], self.lower[i]
            for k in range(1, min(i, self.band) + 1):
                x[i - k] -= row[k] * value
        return x
