"""What a grid of basins says in numbers: fractions with their errors, entropies, uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from math import fsum, log, sqrt
from typing import TYPE_CHECKING

import numpy as np

from camcli.analysis.basins.window import Window

if TYPE_CHECKING:
    from camcli.analysis.basins.attractor_finder import AttractorFinder

BOX = 5  # cells along a box of the entropies
UNCERTAINTY_STARTS = 8192  # each with two others beside it, for every error
FINEST, COARSEST = 11, 4  # errors of a start are 2^-n of the window's sides
LEAST = 10  # starts in doubt, for an error to count
SATURATED = 0.25  # share in doubt, beyond which it grows with the error by no power any more
FEWEST = 3  # errors for a line
PLASTIC = 1.324717957244746  # real root of x^3 = x + 1: its powers fill the plane evenly


def fractions(codes: np.ndarray, attractors: list[int]) -> dict[int, tuple[float, float]]:
    """(fraction, standard error) of the cells not below the cam, by code.

    A cell is a sample of its own area. One whose neighbours are all like it is taken as right; for
    the others the share p of the code among the 3 x 3 cells around estimates the variance p (1 - p)
    of one sample. Hence error^2 = sum of p (1 - p) over all cells, over their number squared.
    """
    above = codes != -1
    total = int(above.sum())
    around = _around(above.astype(np.int16))
    shares = {}
    others = [int(code) for code in np.unique(codes) if code < -1 or code == 0]
    for code in [*attractors, *sorted(others, reverse=True)]:
        mine = codes == code
        near = _around(mine.astype(np.int16))
        edge = above & (near > 0) & (near < around)
        p = near[edge] / around[edge]
        square = fsum((p * (1.0 - p)).tolist())
        cells = max(total, 1)
        shares[code] = (int(mine.sum()) / cells, sqrt(square) / cells)
    return shares


def _around(table: np.ndarray) -> np.ndarray:
    """Sum over the 3 x 3 cells around each, less at the edges."""
    wide = np.pad(table, 1)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]


def boundary(codes: np.ndarray) -> np.ndarray:
    """True for cells not below the cam of which one of the eight neighbours above is different."""
    wide = np.pad(codes, 1, constant_values=-1)
    nv, nq = codes.shape
    differs = np.zeros(codes.shape, dtype=bool)
    for i in range(3):
        for j in range(3):
            other = wide[i : i + nv, j : j + nq]
            differs |= (other != codes) & (other != -1)
    return differs & (codes != -1)


def entropies(codes: np.ndarray) -> dict[str, float | int]:
    """Basin entropy and boundary entropy over boxes of BOX x BOX cells.

    A. Daza, A. Wagemakers, B. Georgeot, D. Guery-Odelin, M. A. F. Sanjuan, Basin entropy: a new
    tool to analyze uncertainty in dynamical systems, Scientific Reports 6, 31416 (2016).

    In a box with shares p of the codes the entropy is -sum p log p; the basin entropy is its mean
    over all boxes, the boundary entropy that over boxes with more than one code. Undecided counts
    as a code; cells below the cam, and boxes of such alone, do not count.
    """
    nv, nq = (size // BOX * BOX for size in codes.shape)
    blocks = codes[:nv, :nq].reshape(nv // BOX, BOX, nq // BOX, BOX).swapaxes(1, 2)
    boxes = blocks.reshape(-1, BOX * BOX)
    total = (boxes != -1).sum(axis=1)
    kinds = [int(code) for code in np.unique(boxes) if code != -1]
    counts = np.stack([(boxes == code).sum(axis=1) for code in kinds]) if kinds else None
    if counts is None:
        return {"basin_entropy": 0.0, "boundary_entropy": 0.0, "boxes": 0, "boundary_boxes": 0}
    logs = np.array([0.0] + [log(k) for k in range(1, BOX * BOX + 1)])
    full = total > 0
    counts = counts[:, full]
    total = total[full]
    each = logs[total] - (counts * logs[counts]).sum(axis=0) / total
    mixed = (counts > 0).sum(axis=0) > 1
    return {
        "basin_entropy": float(each.mean()),
        "boundary_entropy": float(each[mixed].mean()) if mixed.any() else 0.0,
        "boxes": len(total),
        "boundary_boxes": int(mixed.sum()),
    }


@dataclass(frozen=True)
class Uncertainty:
    """Exponent alpha of f ~ error^alpha, and the boundary dimension 2 - alpha.

    error: standard, of the counts, and larger where the shares lie further off the line than these.
    """

    exponent: float
    error: float
    rows: tuple[tuple[float, float, int], ...]  # error, share in doubt, starts in doubt

    @property
    def dimension(self) -> float:
        return 2.0 - self.exponent


def uncertainty(
    finder: AttractorFinder, window: Window, starts: int = UNCERTAINTY_STARTS
) -> Uncertainty | None:
    """How the share of starts in doubt falls with the error of the start.

    S. W. McDonald, C. Grebogi, E. Ott, J. A. Yorke, Fractal basin boundaries, Physica D 17 (1985).

    Starts are spread over the window, each with two others an error away in both coordinates. One
    is in doubt where one of the three ends elsewhere; those with an undecided or impossible one do
    not count. None where fewer than FEWEST errors leave at least LEAST starts in doubt. Errors that
    leave more than SATURATED of them in doubt are not fitted, but for the FEWEST finest.
    """
    n = np.arange(starts)
    x = (0.5 + n / PLASTIC) % 1.0
    y = (0.5 + n / (PLASTIC * PLASTIC)) % 1.0
    (q0, q1), (v0, v1) = window.q, window.v

    def ends(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return finder.settle(q0 + (q1 - q0) * x, v0 + (v1 - v0) * y)[0]

    middle = ends(x, y)
    rows = []
    for power in range(COARSEST, FINEST + 1):
        error = 0.5**power
        high, low = ends(x + error, y + error), ends(x - error, y - error)
        known = (middle >= 0) & (high >= 0) & (low >= 0)
        doubt = known & ((middle != high) | (middle != low))
        if doubt.sum() >= LEAST:
            rows.append((error, float(doubt.sum() / known.sum()), int(doubt.sum())))
    if len(rows) < FEWEST:
        return None
    error, share, count = np.array(rows).T  # a line of logarithms, weighted by the starts in doubt
    fitted = share <= SATURATED
    fitted[-FEWEST:] = True
    x = np.log(error[fitted])
    y = np.log(share[fitted])
    weight = np.sqrt(count[fitted])
    (slope, level), cov = np.polyfit(x, y, 1, w=weight, cov="unscaled")
    off = weight * (y - slope * x - level)
    misfit = fsum((off * off).tolist()) / max(1, len(x) - 2)
    return Uncertainty(float(slope), sqrt(cov[0, 0] * max(1.0, misfit)), tuple(rows))
