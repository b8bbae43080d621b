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
    """The jump near a place (deg) that the widest of the windows shows; None where none does."""
    for half in WINDOWS:
        jump = _jump_in_window(RowsAbout(turn, shares, place, half), turn, noise)
        if jump is not None:
            return jump
    return None


def _jump_in_window(window: RowsAbout, turn: Turn, noise: float) -> Jump | None:
    """The jump that the rows of a window show beyond doubt (see the module); None without one.

    noise: the standard deviation of a row, m.
    """
    if window.freedom < FREEDOM:
        return None
    least_step = 0.5 * turn.spacing
    reach = min(JUMP_REACH, window.half / 3.0)
    step = max(least_step, STEPS[0])
    best = min(window.best_jump(2, reach, step), window.best_jump(1, reach, step))
    variance = max(best.left / window.freedom, turn.quantum**2 / 12.0)
    size, error = window.size_of_jump(best.order, best.phase, sqrt(variance))
    if best.left > NOISE * window.freedom * noise * noise or abs(size) < PLAIN * error:
        return None
    step = max(least_step, STEPS[1])
    corner = window.best_jump(3, 0.7 * window.half, step)
    more_left = min(corner.left, window.best_change(step)) - best.left
    if more_left <= 0.0:
        return None
    evidence = window.freedom * log1p(more_left / (window.freedom * variance))
    if evidence < ENOUGH:
        return None
    return Jump((window.place + best.phase) % 360.0, best.order, size, error, evidence)


class JumpFit(NamedTuple):
    """The jump of one order that fits a window's rows best; compared by what it leaves of them."""

    left: float  # sum of squares, m2
    phase: float  # deg from the window's place
    order: int  # of the derivative that jumps


class RowsAbout:
    """The rows within `half` deg of a place, less the polynomial of degree DEGREE that fits best.

    x: the angles from the place, in units of `half`. root: square roots of the rows' shares, by
    which every column is multiplied so that sums of squares are weighted. polynomials: orthonormal
    columns that span the polynomials. lift: what they leave of the lift, m. freedom: degrees of
    freedom beside a polynomial and a jump, 0 where there are too few rows. A column has a number
    for each row.
    """

    def __init__(self, turn: Turn, shares: np.ndarray, place: float, half: float):
        off = (turn.theta - place + 180.0) % 360.0 - 180.0
        rows = np.flatnonzero(abs(off) <= half)
        self.place = place
        self.half = half
        self.x = off[rows] / half
        self.root = np.sqrt(shares[rows])
        self.freedom = float(shares[rows].sum()) - (DEGREE + 1) - JUMP_TERMS
        self.polynomials: list[np.ndarray] = []
        if len(rows) > DEGREE + JUMP_TERMS:
            column = self.root
            for _ in range(DEGREE + 1):
                column = _unit(self._less_polynomials(column))
                self.polynomials.append(column)
                column = self.x * column
        else:
            self.freedom = 0.0
        lift = turn.lift[rows]
        self.lift = self._less_polynomials(self.root * (lift - lift[:1]))

    def _less_polynomials(self, columns: np.ndarray) -> np.ndarray:
        """Columns (..., rows) less their projection on the polynomials.

        It is subtracted twice: the second time takes away what rounding has left.
        """
        for column in 2 * self.polynomials:
            columns = columns - (columns * column).sum(axis=-1, keepdims=True) * column
        return columns

    def _power(self, phases: np.ndarray, n: int) -> np.ndarray:
        """x+^n from each phase (units of `half`), less the polynomials; (phases, rows)."""
        past = np.maximum(self.x - phases[:, None], 0.0)
        return self._less_polynomials(self.root * np.where(past > 0.0, past**n, 0.0))

    def _left(self, *columns: np.ndarray) -> np.ndarray:
        """Sum of squares that the best combination of columns leaves of the lift, (choices,).

        Each argument holds one column for each choice, (choices, rows). They are made orthonormal
        one after the other; one that depends on those before it counts for nothing.
        """
        orthonormal: list[np.ndarray] = []
        left = (self.lift * self.lift).sum()
        for column in columns:
            size = (column * column).sum(axis=-1)
            for other in 2 * orthonormal:
                column = column - (column * other).sum(axis=-1, keepdims=True) * other
            counts = (column * column).sum(axis=-1) > DEPENDENT * size
            orthonormal.append(np.where(counts[:, None], _unit(column), 0.0))
            left = left - (orthonormal[-1] * self.lift).sum(axis=-1) ** 2
        return np.maximum(left, 0.0)

    def best_jump(self, order: int, reach: float, step: float) -> JumpFit:
        """The jump of an order, within `reach` deg of the place, that fits best.

        It is searched on GRIDS grids, each about the best phase of the one before; step: of the
        first one, deg.
        """
        step /= self.half
        phases = np.arange(-reach / self.half, reach / self.half + 0.5 * step, step)
        for _ in range(GRIDS):
            left = self._left(*(self._power(phases, n) for n in (order + 2, order + 1, order)))
            best = int(np.argmin(left))
            least = float(left[best])
            phase = float(phases[best])
            step /= FINER
            phases = phase + step * np.arange(-5, 6)
        return JumpFit(least, phase * self.half, order)

    def best_change(self, step: float) -> float:
        """Sum of squares left by the change over LEAST deg or more that fits best.

        It is searched on GRIDS grids of its phase and its length; step: of the first one, deg.
        """
        step /= self.half
        stretch = 0.13  # of the length, relative, from a choice to the next
        starts = np.arange(-0.9, 0.7, step)
        phases = np.repeat(starts, len(LENGTHS))
        lengths = np.tile(LENGTHS, len(starts)) / self.half
        # steps of phase and of length to the choices of the next grid, about the best one
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
        """(jump of the derivative of an order at a phase in deg, its standard error), m and rad.

        deviation: the standard deviation of a row, m. The jump is the coefficient of x+^order,
        times the derivative of that power. It is found from what the higher powers leave of the
        column. Its error takes in that of the phase, by which the jump changes as the coefficients
        beside it say: what is left of the column counts less the derivative of the fit by the
        phase, -sum n A_n x+^(n-1).
        """
        at_phase = np.array([phase / self.half])
        powers = {n: self._power(at_phase, n)[0] for n in range(order - 1, order + 3)}
        jump, higher, highest = (powers[order + n] for n in (0, 1, 2))
        alone = {
            order: _beside(jump, highest, higher),
            order + 1: _beside(higher, highest, jump),
            order + 2: _beside(highest, higher, jump),
        }
        fit = {n: float((column * self.lift).sum() / (column * column).sum())
               for n, column in alone.items()}  # fmt: skip
        by_phase = sum(n * fit[n] * powers[n - 1] for n in fit)
        left = _beside(jump, highest, higher, by_phase)
        per_unit = order / (self.half * pi / 180.0) ** order  # order! is order here: 1 or 2
        return per_unit * fit[order], per_unit * deviation / sqrt(float((left * left).sum()))


def _beside(column: np.ndarray, *others: np.ndarray) -> np.ndarray:
    """What other columns leave of a column, (rows,): orthogonal to each of them.

    They are made orthonormal one after the other; each projection is subtracted twice, as rounding
    is left of the first time.
    """
    orthonormal: list[np.ndarray] = []
    for other in (*others, column):
        for done in 2 * orthonormal:
            other = other - (other * done).sum() * done
        orthonormal.append(_unit(other))
    return other


def _unit(columns: np.ndarray) -> np.ndarray:
    """The columns (..., rows) scaled to length one; a column of zeros stays as it is."""
    size = np.sqrt((columns * columns).sum(axis=-1, keepdims=True))
    return columns / np.where(size > 0.0, size, 1.0)
