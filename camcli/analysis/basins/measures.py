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

    codes: of all cells, (rows, columns), -1 below the cam. attractors: codes that are listed in any
    case; other codes follow where there are cells of them.

    A cell is a sample of its own area. One whose neighbours are all like it is taken as right; for
    the others the share p of the code among the 3 x 3 cells around estimates the variance p (1 - p)
    of one sample. Hence error^2 = sum of p (1 - p) over all cells, over their number squared.
    """
    above_cam = codes != -1
    count = max(int(above_cam.sum()), 1)
    cells_around = _sum_around(above_cam.astype(np.int16))
    others = [int(code) for code in np.unique(codes) if code < -1 or code == 0]
    shares = {}
    for code in [*attractors, *sorted(others, reverse=True)]:
        has_code = codes == code
        alike_around = _sum_around(has_code.astype(np.int16))
        edge = above_cam & (alike_around > 0) & (alike_around < cells_around)
        p = alike_around[edge] / cells_around[edge]
        variance = fsum((p * (1.0 - p)).tolist())
        shares[code] = (int(has_code.sum()) / count, sqrt(variance) / count)
    return shares


def _sum_around(table: np.ndarray) -> np.ndarray:
    """Sum over the 3 x 3 cells around each, of fewer at the edges of the table."""
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
    """Basin entropy and boundary entropy over boxes of BOX x BOX cells, and how many boxes.

    A. Daza, A. Wagemakers, B. Georgeot, D. Guery-Odelin, M. A. F. Sanjuan, Basin entropy: a new
    tool to analyze uncertainty in dynamical systems, Scientific Reports 6, 31416 (2016).

    In a box with shares p of the codes the entropy is -sum p log p; the basin entropy is its mean
    over all boxes, the boundary entropy that over boxes with more than one code. Undecided counts
    as a code; cells below the cam, and boxes of such alone, do not count.
    """
    rows, columns = (size // BOX * BOX for size in codes.shape)
    blocks = codes[:rows, :columns].reshape(rows // BOX, BOX, columns // BOX, BOX)
    boxes = blocks.swapaxes(1, 2).reshape(-1, BOX * BOX)  # a row of cells for each box
    kinds = [int(code) for code in np.unique(boxes) if code != -1]
    if not kinds:
        return {"basin_entropy": 0.0, "boundary_entropy": 0.0, "boxes": 0, "boundary_boxes": 0}
    counts = np.stack([(boxes == code).sum(axis=1) for code in kinds])  # (codes, boxes)
    totals = (boxes != -1).sum(axis=1)
    has_cells = totals > 0
    counts = counts[:, has_cells]
    totals = totals[has_cells]
    log_of = np.array([0.0] + [log(k) for k in range(1, BOX * BOX + 1)])  # log_of[0] is not used
    # with n cells of a code among N: -sum n/N log(n/N) = log N - sum n log n / N
    entropy = log_of[totals] - (counts * log_of[counts]).sum(axis=0) / totals
    is_mixed = (counts > 0).sum(axis=0) > 1
    return {
        "basin_entropy": float(entropy.mean()),
        "boundary_entropy": float(entropy[is_mixed].mean()) if is_mixed.any() else 0.0,
        "boxes": len(totals),
        "boundary_boxes": int(is_mixed.sum()),
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
    not count. None where fewer than FEWEST errors leave at least LEAST starts in doubt.
    """
    n = np.arange(starts)
    x = (0.5 + n / PLASTIC) % 1.0
    y = (0.5 + n / (PLASTIC * PLASTIC)) % 1.0
    q_low, q_high = window.q
    v_low, v_high = window.v

    def ends(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Outcomes of starts at shares x and y of the window's sides."""
        outcome, _ = finder.settle(q_low + (q_high - q_low) * x, v_low + (v_high - v_low) * y)
        return outcome

    middle = ends(x, y)
    rows = []
    for power in range(COARSEST, FINEST + 1):
        error = 0.5**power
        high = ends(x + error, y + error)
        low = ends(x - error, y - error)
        known = (middle >= 0) & (high >= 0) & (low >= 0)
        doubt = known & ((middle != high) | (middle != low))
        if doubt.sum() >= LEAST:
            rows.append((error, float(doubt.sum() / known.sum()), int(doubt.sum())))
    return _fitted(rows) if len(rows) >= FEWEST else None


def _fitted(rows: list[tuple[float, float, int]]) -> Uncertainty:
    """The line through the logarithms of error and share, weighted by the starts in doubt.

    rows: (error, share in doubt, starts in doubt). Errors that leave more than SATURATED of the
    starts in doubt are not fitted, but for the FEWEST finest.
    """
    error, share, count = np.array(rows).T
    is_fitted = share <= SATURATED
    is_fitted[-FEWEST:] = True
    x = np.log(error[is_fitted])
    y = np.log(share[is_fitted])
    weight = np.sqrt(count[is_fitted])
    (slope, level), covariance = np.polyfit(x, y, 1, w=weight, cov="unscaled")
    residuals = weight * (y - slope * x - level)
    misfit = fsum((residuals * residuals).tolist()) / max(1, len(x) - 2)
    return Uncertainty(float(slope), sqrt(covariance[0, 0] * max(1.0, misfit)), tuple(rows))
