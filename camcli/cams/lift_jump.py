"""Does c_thetatheta of a measured lift jump? Four descriptions of the rows, side by side.

The rows within WINDOWS deg of a place are described by a polynomial of degree DEGREE plus, x being
the angle past a phase p, and x+ the same or 0 before it,

    a jump    A x+^2 + B x+^3 + D x+^4,         p wherever it fits best,
    a kink    E x+ + A x+^2 + B x+^3,           the same, where c_theta itself jumps,
    a change  B x+^3 + C (x - R)+^3 + D x+^4,   p, and R >= LEAST deg, wherever they fit best,
    a corner  B x+^3 + D x+^4 + F x+^5,         the same, of c_thetatheta.

In the last two c_thetatheta is continuous. In a change it turns at p and again at p + R, so it may
change as much as it likes, but not faster than within LEAST deg; a cycloidal law begins and ends
with a corner.
All have three coefficients: none fits by its freedom alone. With S1 the sum of squares of the jump
or the kink, whichever fits better, S0 that of the change or the corner, and n degrees of freedom,

    evidence = n ln(1 + (S0 - S1)/(n variance)),   variance = S1/n, or that of rounding if larger,

twice the logarithm of a ratio of likelihoods; its root is told as standard errors. A jump is one
where the rows leave no more than noise beside it and the evidence is ENOUGH. Where a jump cannot be
told from a fast change nothing is said.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import log1p, pi, sqrt
from typing import NamedTuple

import numpy as np

from camcli.cams.lift_reading import Turn

DEGREE = 5
LEAST = 4.0  # deg: laws of valves and of machines change c_thetatheta within 6 deg and more
LENGTHS = LEAST * 1.3 ** np.arange(6)  # deg, where the search for the length of a change begins
WINDOWS = (27.0, 18.0, 12.0, 8.0)  # deg to either side; far away the polynomial does not reach
FREEDOM = 3  # degrees of freedom, at least
JUMP_TERMS = 4  # the three coefficients and the phase
JUMP_REACH = 3.0  # deg to either side of a place, and at most a third of a window
STEPS = 0.25, 0.5  # deg, of the first grid, for a jump and a change; no less than half a row's
FINER, GRIDS = 4.0, 5  # grids, each so much finer than the one before
NOISE = 2.0  # largest variance left by a jump, over that of the rows
PLAIN = 4.0  # standard errors of a jump that is worth a search for changes
ENOUGH = 20.0  # of 144 tables without a jump none had more than 12
DEPENDENT = 1e-10  # share of a column that is rounding beside others


class Jump(NamedTuple):
    """A jump: where (deg), by how much and with which standard error.

    order: 2 of c_thetatheta (m/rad2), 1 of c_theta (m/rad).
    """

    at: float
    order: int
    size: float
    error: float
    evidence: float

    @property
    def errors(self) -> float:
        """By how many standard errors a jump describes the rows better than a change does."""
        return sqrt(self.evidence)


def find_jump(turn: Turn, shares: np.ndarray, noise: float, places: Iterable[float]) -> Jump | None:
    """The most evident jump near one of the places (deg); shares: how much the rows count.

    noise: the standard deviation of a row, m.
    """
    jumps = [jump for place in places if (jump := _jump_near(turn, shares, noise, place))]
    return max(jumps, key=lambda jump: jump.evidence, default=None)


def _jump_near(turn: Turn, shares: np.ndarray, noise: float, place: float) -> Jump | None:
    """The jump near a place that the widest of the windows shows."""
    coarse = 0.5 * turn.spacing
    for half in WINDOWS:
        window = RowsAbout(turn, shares, place, half)
        if window.freedom < FREEDOM:
            continue
        reach = min(JUMP_REACH, half / 3.0)
        left, p, order = min(window.best_jump(n, reach, max(coarse, STEPS[0])) for n in (2, 1))
        variance = max(left / window.freedom, turn.quantum**2 / 12.0)
        size, error = window.size_of_jump(order, p, sqrt(variance))
        if left > NOISE * window.freedom * noise * noise or abs(size) < PLAIN * error:
            continue
        corner, *_ = window.best_jump(3, 0.7 * half, max(coarse, STEPS[1]))
        more = min(corner, window.best_change(max(coarse, STEPS[1]))) - left
        if more > 0.0:
            evidence = window.freedom * log1p(more / (window.freedom * variance))
            if evidence >= ENOUGH:
                return Jump((place + p) % 360.0, order, size, error, evidence)
    return None


class RowsAbout:
    """The rows about a place, less a polynomial; angles in deg from the place."""

    def __init__(self, turn: Turn, shares: np.ndarray, place: float, half: float):
        off = (turn.theta - place + 180.0) % 360.0 - 180.0
        rows = np.flatnonzero(abs(off) <= half)
        self.half = half
        self.x = off[rows] / half
        self.root = np.sqrt(shares[rows])
        self.freedom = float(shares[rows].sum()) - (DEGREE + 1) - JUMP_TERMS
        self.polynomials: list[np.ndarray] = []  # orthonormal on the rows
        if len(rows) > DEGREE + JUMP_TERMS:
            column = self.root
            for _ in range(DEGREE + 1):
                column = _unit(self._rest(column))
                self.polynomials.append(column)
                column = self.x * column
        else:
            self.freedom = 0.0
        lift = turn.lift[rows]
        self.lift = self._rest(self.root * (lift - lift[:1]))

    def _rest(self, columns: np.ndarray) -> np.ndarray:
        """Columns (..., rows) less their projection on the polynomials, twice for rounding."""
        for column in 2 * self.polynomials:
            columns = columns - (columns * column).sum(axis=-1, keepdims=True) * column
        return columns

    def _power(self, phases: np.ndarray, n: int) -> np.ndarray:
        """x+^n from each phase (units of `half`), beside the polynomials; (phases, rows)."""
        return self._rest(self.root * np.maximum(self.x - phases[:, None], 0.0) ** n)

    def _left(self, *columns: np.ndarray) -> np.ndarray:
        """Sums of squares that the columns, each (choices, rows), leave of the lift; (choices,)."""
        used: list[np.ndarray] = []
        left = (self.lift * self.lift).sum()
        for column in columns:
            size = (column * column).sum(axis=-1)
            for other in 2 * used:
                column = column - (column * other).sum(axis=-1, keepdims=True) * other
            counts = (column * column).sum(axis=-1) > DEPENDENT * size
            used.append(np.where(counts[:, None], _unit(column), 0.0))
            left = left - (used[-1] * self.lift).sum(axis=-1) ** 2
        return np.maximum(left, 0.0)

    def best_jump(self, order: int, reach: float, step: float) -> tuple[float, float, int]:
        """(sum of squares left, phase in deg, order) of the jump of an order that fits best."""
        powers = (order + 2, order + 1, order)
        step /= self.half
        phases = np.arange(-reach / self.half, reach / self.half + 0.5 * step, step)
        for _ in range(GRIDS):
            left = self._left(*(self._power(phases, n) for n in powers))
            best = int(np.argmin(left))
            least = float(left[best])
            phase = float(phases[best])
            step /= FINER
            phases = phase + step * np.arange(-5, 6)
        return least, phase * self.half, order

    def best_change(self, step: float) -> float:
        """Sum of squares left by the change over LEAST deg or more that fits best."""
        step /= self.half
        stretch = 0.13
        starts = np.arange(-0.9, 0.7, step)
        phases = np.repeat(starts, len(LENGTHS))
        lengths = np.tile(LENGTHS, len(starts)) / self.half
        # steps of phase and of length to the choices of the next round, about the best one
        phase_steps = np.repeat(np.arange(-3, 4), 7)
        length_steps = np.tile(np.arange(-3, 4), 7)
        for _ in range(GRIDS):
            ends = self._power(phases + lengths, 3)
            left = self._left(self._power(phases, 4), self._power(phases, 3), ends)
            best = int(np.argmin(left))
            step /= FINER
            stretch /= FINER
            phases = phases[best] + step * phase_steps
            longer = lengths[best] * (1.0 + stretch * length_steps)
            lengths = np.maximum(longer, LEAST / self.half)
        return float(left[best])

    def size_of_jump(self, order: int, phase: float, deviation: float) -> tuple[float, float]:
        """Jump of the derivative of an order at a phase (deg) and its standard error, m and rad."""
        column, higher, highest = (
            self._power(np.array([phase / self.half]), order + n)[0] for n in (0, 1, 2)
        )
        highest = _unit(highest)
        higher = _unit(higher - (higher * highest).sum() * highest)
        for other in 2 * [highest, higher]:
            column = column - (column * other).sum() * other
        scale = order / (self.half * pi / 180.0) ** order  # of the order's derivative, per rad
        size = sqrt(float((column * column).sum()))
        value = float((column * self.lift).sum()) / (size * size)
        return scale * value, scale * deviation / size


def _unit(columns: np.ndarray) -> np.ndarray:
    """The columns (..., rows) scaled to length one; a column of zeros stays as it is."""
    size = np.sqrt((columns * columns).sum(axis=-1, keepdims=True))
    return columns / np.where(size > 0.0, size, 1.0)
