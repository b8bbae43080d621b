"""The uncertainty exponent: how the share of starts in doubt falls with the error of the start.

S. W. McDonald, C. Grebogi, E. Ott, J. A. Yorke, Fractal basin boundaries, Physica D 17 (1985).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, sqrt

import numpy as np

from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.window import Window

STARTS = 8192
FINEST, COARSEST = 11, 4  # errors are 2^-n of the window's sides
LEAST = 10  # starts in doubt, for an error to count
PLASTIC = 1.324717957244746  # real root of x^3 = x + 1: its powers fill the plane evenly


@dataclass(frozen=True)
class Uncertainty:
    """Exponent alpha of f ~ error^alpha, and the boundary dimension 2 - alpha."""

    exponent: float
    error: float  # standard
    rows: tuple[tuple[float, float, int], ...]  # error, share in doubt, starts in doubt

    @property
    def dimension(self) -> float:
        """Dimension of the boundary in the plane of starts."""
        return 2.0 - self.exponent


def uncertainty(finder: AttractorFinder, window: Window) -> Uncertainty | None:
    """Starts spread over the window, each with two others an error away in both coordinates.

    A start is in doubt where one of the three ends elsewhere; those with an undecided or impossible
    one do not count. None where fewer than three errors leave at least LEAST starts in doubt.
    """
    n = np.arange(STARTS)
    x = (0.5 + n / PLASTIC) % 1.0
    y = (0.5 + n / (PLASTIC * PLASTIC)) % 1.0
    middle = _settled(finder, window, x, y)
    rows = []
    for power in range(COARSEST, FINEST + 1):
        error = 0.5**power
        high = _settled(finder, window, x + error, y + error)
        low = _settled(finder, window, x - error, y - error)
        known = (middle >= 0) & (high >= 0) & (low >= 0)
        doubt = known & ((middle != high) | (middle != low))
        if doubt.sum() >= LEAST:
            rows.append((error, float(doubt.sum() / known.sum()), int(doubt.sum())))
    return _fit(rows) if len(rows) >= 3 else None


def _settled(finder: AttractorFinder, window: Window, x, y) -> np.ndarray:
    q = window.q[0] + (window.q[1] - window.q[0]) * x
    v = window.v[0] + (window.v[1] - window.v[0]) * y
    return finder.settle(q, v)[0]


def _fit(rows) -> Uncertainty:
    """Line through log f over log error, each weighted by its starts in doubt."""
    weight = [float(count) for _, _, count in rows]
    a = [log(error) for error, _, _ in rows]
    b = [log(share) for _, share, _ in rows]
    total = sum(weight)
    centre = sum(w * x for w, x in zip(weight, a, strict=True)) / total
    spread = sum(w * (x - centre) ** 2 for w, x in zip(weight, a, strict=True))
    slope = sum(w * (x - centre) * y for w, x, y in zip(weight, a, b, strict=True)) / spread
    return Uncertainty(slope, sqrt(1.0 / spread), tuple(rows))
