"""The smoothing spline of a measured lift, and how far its second derivative may be trusted.

    minimise  sum share_k (c(theta_k) - lift_k)^2
              + weight sum (fourth differences of the coefficients)^2

over periodic splines of degree 7 on equal knots: six continuous derivatives, as the kernel wants.
The weight is the eighth power of a smoothing length (P. H. C. Eilers, B. D. Marx, Flexible
smoothing with B-splines and penalties, Statistical Science 11 (1996)). Coefficients in the middle
of a dwell are held at its level, so the dwell is exactly flat there. Rows side by side that are
rounded to one lift count as one: their roundings are the same.

The cam is at every knot the fit of the largest length whose bending is still hidden by the rounding
(O. V. Lepskii, Theory of Probability and its Applications 35 (1991)): a length AHEAD of it, where a
third of the rounding is left, changes c_thetatheta nearby by no more than BALANCE standard errors
when it doubles. In between coefficients of neighbouring lengths are blended. One penalty whose
weight varies would bend the cam more: its variation acts on the fourth derivative, not the eighth.

The error of c_thetatheta at a phase is ERRORS standard errors, so 99.7 % of normal ones: noise
passes through the linear smoother, its size is that of the rounding or of the residuals. Bending by
a length L is taken as C L^p, p = 1 at a corner of c_thetatheta, more where it is smooth, 0 at a
jump; ratio = 2^p is measured. What doubling a length of AHEAD L changes beyond QUIET standard
errors (`excess`) is C L^p ratio^(2/3) (ratio - 1), so the bound is
    ERRORS standard errors + excess/(ratio^(2/3) (ratio - 1)).
`Accuracy.worst`, not in the bound, is the error if every row were half a digit off, each in the
worst direction.

The coefficients come from additions, multiplications and divisions in a fixed order, element by
element: LAPACK and BLAS may give other last bits on another machine, these do not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import factorial, sqrt
from typing import Any, NamedTuple

import numpy as np
from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS, Piece
from camcli.cams.lift_jump import find_jump
from camcli.cams.lift_reading import DEG, Turn
from camcli.kernel.cam_table import TERMS

DEGREE = 7
WIDTH = DEGREE + 1  # coefficients of an interval
CENTER = 3  # coefficient j weighs most at u = j - CENTER
MOST_KNOTS, LEAST_KNOTS = 720, 32
TOE = 8  # last digits: the lift of x^3 climbs them in 2.5 times the length hidden below half of one
LONGEST_RUN = 8  # rows of one lift that count as one together
FREE_SPACINGS = 1.0  # knot spacings of a dwell's ends where coefficients stay free
PENALTY = np.array([[1.0, -4.0, 6.0, -4.0, 1.0]])
THIRD = 2.0 ** (1 / 3)
LENGTHS = [0.5 * 2**octave * step for octave in range(6) for step in (1.0, THIRD, THIRD * THIRD)]
AHEAD = THIRD * THIRD  # twice a length it shows how a length bends the cam, with less noise
BALANCE, QUIET = 6.0, 3.0  # standard errors: a corner of c_thetatheta bends by 4 of them, and by 2
ACCEL, JERK = 2, 3  # orders of derivatives
TINY = 1e-300
SLOPE = 0.5  # of the length along the turn
LENGTH_HALVINGS = 20  # of the logarithm of the length
SAMPLE = 600  # rows that estimate the noise
# How many times more is seen off polynomials of degree 3 than of degree 5 where the lift bends
# between rows by more than they scatter: bending as large as the scatter makes it sqrt(2) at most.
COARSE = 1.5
TRIMMED = 0.6230  # mean square of the nine tenths of a normal distribution nearest its mean
ERRORS = 3.0  # standard errors in the bound
LEAST_RATIO, SMOOTH = 1.28, 4.0  # growth of the bending with twice the length, that is counted on
WRONG = 6.0  # standard deviations: so far off is a row that is wrong, no noise
SURE_OF_NOISE = 2.0  # standard errors by which residuals are more than rounding
APART, PLACES = 6, 6  # knots between, and the most places where bending asks whether it is a jump
JUMPS = {1: "c_theta", 2: "c_thetatheta"}  # by the order of the derivative
BESIDE = 2.0  # deg: so close to a dwell's end it is that end
BENDING_REACH = 2.0  # smoothing lengths around a phase in which bending counts there

Rows = list[list[float]]
Shares = dict[float, np.ndarray]  # of fits by their smoothing length, at every knot


def scatter(turn: Turn) -> float:
    """Standard deviation of the rows before there is a fit, m: no less than that of the rounding.

    The scatter is the least of three estimates from polynomials of rising degree: where the lift
    itself bends between rows, the higher ones see less of it.
    """
    return max(turn.quantum / sqrt(12.0), min(_scatters(turn)))


def bends_between_rows(turn: Turn) -> bool:
    """Whether the rows lie too far apart for the lift.

    Scatter is the same for polynomials of every degree, bending is less for higher ones.
    """
    degree_3, degree_5, _ = _scatters(turn)
    return degree_3 > COARSE * degree_5


def _scatters(turn: Turn) -> list[float]:
    """Standard deviation of the rows that move from polynomials of degree 3, 5 and 7, m.

    A row's deviation is taken from the polynomial through its neighbours; its variance is that of a
    row times 1 + the sum of the squared weights. The tenth of the rows that is furthest off is left
    out, and TRIMMED makes up for that.
    """
    same_before = np.roll(turn.lift, 1) == turn.lift
    same_after = np.roll(turn.lift, -1) == turn.lift
    moving = np.flatnonzero((turn.line > 0) & ~(same_before & same_after))
    moving = moving[:: 1 + len(moving) // SAMPLE]
    if len(moving) == 0:
        return [0.0, 0.0, 0.0]
    estimates = []
    for neighbours in (2, 3, 4):  # on either side
        deviation, weights = turn.deviations(neighbours)
        variances = deviation * deviation / (1.0 + (weights * weights).sum(axis=0))
        nearest = np.sort(variances[moving])[: int(0.9 * len(moving)) + 1]
        estimates.append(sqrt(float(nearest.mean()) / TRIMMED))
    return estimates


def _shares(lift: np.ndarray) -> np.ndarray:
    """The weight of each row, (n,): rows side by side that round to one lift count as one row.

    A run of more than LONGEST_RUN rows counts as one for each LONGEST_RUN of them. A run may go
    through the end of the turn.
    """
    run_starts = np.flatnonzero(lift != np.roll(lift, 1))
    if len(run_starts) == 0:
        return np.ones(len(lift))
    run_lengths = np.diff(np.append(run_starts, run_starts[0] + len(lift)))
    from_first_run = np.repeat(1.0 / np.minimum(run_lengths, LONGEST_RUN), run_lengths)
    return np.roll(from_first_run, run_starts[0])


# -- B-splines of degree 7 on equal knots ------------------------------------------------------
# Angles are in knot spacings, u = theta K/(2 pi). Interval i holds u in [i, i + 1] and depends on
# the coefficients i, ..., i + 7 (modulo K).


@cache
def _weights() -> list[list[int]]:
    """The weights of a spline's coefficients in an interval, as polynomials (whole numbers).

    The spline of degree 7 in interval i is the sum over k of coefficient i + k times weight k(t),
    t = u - i from 0 to 1. Entry k holds 7! times the coefficients of weight k by powers of t.

    They are the pieces of one basis function B, from its last to its first: piece r is B(r + t).
    With p! B of degree p,
        B_p(u) = u B_(p-1)(u) + (p + 1 - u) B_(p-1)(u - 1),
    so piece r of the lower degree gives (r + t) times itself to piece r of the higher degree, and
    (p - r - t) times itself to piece r + 1.
    """
    pieces = [[1]]  # of degree 0
    for p in range(1, DEGREE + 1):
        raised = [[0] * (p + 1) for _ in range(p + 1)]
        for r, lower in enumerate(pieces):
            for j, value in enumerate(lower):
                raised[r][j] += value * r
                raised[r][j + 1] += value
                raised[r + 1][j] += value * (p - r)
                raised[r + 1][j + 1] -= value
        pieces = raised
    return pieces[::-1]


def basis(t: Any, order: int = 0) -> np.ndarray:
    """Weights of the eight coefficients of an interval at t in [0, 1], (..., 8).

    order: of a derivative by u, the angle in knot spacings.
    """
    columns = []
    for weight in _weights():
        value = 0.0 * t
        for j in range(DEGREE, order - 1, -1):  # Horner's scheme
            by_derivation = factorial(j) // factorial(j - order)
            value = value * t + weight[j] * by_derivation / factorial(DEGREE)
        columns.append(value)
    return np.stack(columns, axis=-1)


def at(coefficients: np.ndarray, i: np.ndarray, weights: np.ndarray) -> Any:
    """The spline (or a derivative) in the intervals i (n,) with their weights (n, 8).

    Of coefficients (count,), or of several splines (count, m) at once: (n, m).
    """
    value = 0.0
    for k in range(WIDTH):
        value = value + (weights[:, k] * coefficients[(i + k) % len(coefficients)].T).T
    return value


def piece(coefficients: np.ndarray, i: int, base: float = 0.0) -> Piece:
    """Interval i of the spline, plus a base (m), as a piece of the kernel's table, rounded once."""
    count = len(coefficients)
    with precision(DIGITS):
        width = 2 * arb.pi() / count  # of an interval, rad
        low = float(width * i)
        high = float(width * (i + 1))
        center = (low + high) / 2
        powers = [arb(base) * factorial(DEGREE), *[arb(0)] * DEGREE]  # 7! times those of t
        for k, weight in enumerate(_weights()):
            coefficient = arb(float(coefficients[(i + k) % count]))
            for j, factor in enumerate(weight):
                powers[j] += coefficient * factor
        middle = center / width - i  # t of the centre in doubles, about a half
        for k in range(DEGREE):  # synthetic division: powers of t - middle
            for j in range(DEGREE - 1, k - 1, -1):
                powers[j] += middle * powers[j + 1]
        values = [float(power / factorial(DEGREE) / width**j) for j, power in enumerate(powers)]
    return Piece(center, (high - low) / 2, tuple(values + [0.0] * (TERMS - WIDTH)))


def widest(values: np.ndarray, reach: np.ndarray | float) -> np.ndarray:
    """The largest of the values (not negative) within `reach` knots of each knot, (knots,).

    reach: one for all knots, or one for each.
    """
    largest = values
    most = int(np.max(reach))
    for step in range(-most, most + 1):
        shifted = np.roll(values, step)
        largest = np.maximum(largest, np.where(abs(step) <= reach, shifted, 0.0))
    return largest


class Factors:
    """The factors L D L' of a symmetric positive definite band matrix A.

    L is lower triangular with a diagonal of ones, D diagonal. `rows[i][k]` is A(i, i - k), k = 0 to
    the number of diagonals below the main one; entries left of the matrix are not read.
    """

    def __init__(self, rows: Rows):
        self.lower: Rows = []  # [i][k] is L(i, i - k)
        self.pivots: list[float] = []  # D
        for i, row in enumerate(rows):
            reach = min(i, len(row) - 1)
            scaled = [0.0] * len(row)  # [k] is L(i, i - k) D(i - k)
            for k in range(reach, 0, -1):
                value = row[k]
                above = self.lower[i - k]
                for m in range(1, reach - k + 1):
                    value -= scaled[k + m] * above[m]
                scaled[k] = value
            lower = [1.0] + [0.0] * (len(row) - 1)
            pivot = row[0]
            for k in range(1, reach + 1):
                lower[k] = scaled[k] / self.pivots[i - k]
                pivot -= scaled[k] * lower[k]
            self.lower.append(lower)
            self.pivots.append(pivot)

    def solve(self, right: Sequence[float]) -> np.ndarray:
        """The solution x of A x = right, (n,)."""
        x = list(right)
        n = len(right)
        for i, row in enumerate(self.lower):  # L y = right
            for k in range(1, min(i, len(row) - 1) + 1):
                x[i] = x[i] - row[k] * x[i - k]
        x = [value / pivot for value, pivot in zip(x, self.pivots, strict=True)]
        for i in range(n - 1, -1, -1):  # L' x = D^-1 y
            row = self.lower[i]
            for k in range(1, min(i, len(row) - 1) + 1):
                x[i - k] = x[i - k] - row[k] * x[i]
        return np.array(x)

    def solve_all(self, right: np.ndarray) -> np.ndarray:
        """The solutions of several right-hand sides at once, (n, m), to the bits of `solve`.

        The products of a row are taken at once, and subtracted one after the other in its order.
        """
        x = np.array(right, dtype=float)
        if x.size == 0:
            return x
        n, columns = x.shape
        lower = np.array(self.lower)[:, :, None]  # [i, k] is L(i, i - k)
        most = lower.shape[1] - 1
        terms = np.empty((most + 1, columns))  # x(i), and what is subtracted from it
        for i in range(1, n):  # L y = right
            reach = min(i, most)
            terms[0] = x[i]
            nearest_first = x[i - reach : i][::-1]
            np.multiply(lower[i, 1 : reach + 1], nearest_first, out=terms[1 : reach + 1])
            np.subtract.reduce(terms[: reach + 1], axis=0, out=x[i])
        x /= np.array(self.pivots)[:, None]
        for i in range(n - 1, 0, -1):  # L' x = D^-1 y
            reach = min(i, most)
            nearest_first = x[i - reach : i][::-1]
            np.multiply(lower[i, 1 : reach + 1], x[i], out=terms[:reach])
            nearest_first -= terms[:reach]
        return x


# -- the fit -----------------------------------------------------------------------------------


class Equations(NamedTuple):
    """Normal equations of the unknown coefficients, as the entries of a symmetric band matrix.

    matrix[i, k] is the entry (i, i - k), (unknowns, diagonals); right is (unknowns,).
    """

    matrix: np.ndarray
    right: np.ndarray


@dataclass(frozen=True)
class Fit:
    """The spline of one smoothing length: its coefficients in m, and the factors of its matrix."""

    coefficients: np.ndarray
    factors: Factors


class Smoother:
    """The least squares problem of one table: its rows and its penalty, for any smoothing length.

    count        knots of a turn, so that u = theta count/360 deg; also intervals and coefficients
    levels       the coefficients that are held at the level of a dwell (m), by number
    order        numbers of the others, the unknowns, in the order of the equations
    position     of each coefficient among the unknowns, -1 where it is held
    band         diagonals of the equations' matrix below the main one
    moving       the intervals of which not all coefficients are held
    halves       (interval, weights of c_thetatheta) at the knots and middles of these
    interval, weights, shares    of each row: where it lies, the weights of its eight coefficients,
                 and how much it counts
    rows, penalty                the equations of both
    """

    def __init__(self, turn: Turn):
        self.turn = turn
        count = max(LEAST_KNOTS, min(MOST_KNOTS, int(360.0 / turn.spacing + 0.5)))
        self.count = count
        self.per_square = (count * DEG / 360.0) ** 2  # from knot spacings to rad
        self.levels = self._levels()
        self.order, self.band = self._unknowns()
        self.position = np.full(count, -1)
        self.position[self.order] = np.arange(len(self.order))
        is_free = self.position >= 0
        of_interval = (np.arange(count)[:, None] + np.arange(WIDTH)) % count
        self.moving = np.flatnonzero(is_free[of_interval].any(axis=1))
        knot_and_middle = basis(np.array([0.0, 0.5]), ACCEL)
        self.halves = np.repeat(self.moving, 2), np.tile(knot_and_middle, (len(self.moving), 1))
        u = turn.theta * count / 360.0
        self.interval = np.minimum(u.astype(int), count - 1)
        self.weights = basis(u - self.interval)
        self.shares = _shares(turn.lift)
        root = np.sqrt(self.shares)
        self.rows = self._equations(self.interval, self.weights * root[:, None], turn.lift * root)
        fourth_differences = np.tile(PENALTY, (count, 1))  # centred at knot i + 2
        self.penalty = self._equations(np.arange(count), fourth_differences, np.zeros(count))
        self.rows_per_knot = len(turn.lift) / count
        self.fits: dict[float, Fit] = {}

    def _unknowns(self) -> tuple[np.ndarray, int]:
        """(numbers of the coefficients that are not held, in the order of the equations; the band).

        A coefficient meets only its DEGREE neighbours on either side in an equation. Behind a dwell
        they are taken one after the other. Without a dwell the turn is folded, 0, n - 1, 1, n - 2,
        ..., so that neighbours across the start of the turn are near; the band is twice as wide.
        """
        count = self.count
        held = self.levels
        last_of_dwell = next((j for j in held if (j + 1) % count not in held), None)
        if last_of_dwell is not None:
            order = [(last_of_dwell + k) % count for k in range(count)]
            band = DEGREE
        else:
            order = [k // 2 if k % 2 == 0 else count - 1 - k // 2 for k in range(count)]
            band = 2 * DEGREE
        return np.array([j for j in order if j not in held]), band

    def _levels(self) -> dict[int, float]:
        """The coefficients that are not fitted but held at a dwell's level (m), by number.

        A table shows a dwell as a run of equal rows, though the lift may begin to rise within the
        run by less than a digit. So the coefficients near both ends of a run stay free: as far from
        an end as the lift needs beyond it to climb TOE digits, and FREE_SPACINGS knots at least.
        """
        levels: dict[int, float] = {}
        turn = self.turn
        knots_per_deg = self.count / 360.0
        for dwell in turn.dwells:
            climbed = turn.theta[abs(turn.lift - dwell.level) > TOE * turn.quantum]
            before = min((dwell.start - climbed) % 360.0, default=0.0) * knots_per_deg
            after = min((climbed - dwell.end) % 360.0, default=0.0) * knots_per_deg
            low = dwell.start * knots_per_deg + max(FREE_SPACINGS, before)
            high = dwell.end * knots_per_deg - max(FREE_SPACINGS, after)
            run = range(int(low + CENTER) + 1, int(np.floor(high + CENTER)) + 1)
            if len(run) >= WIDTH:
                levels.update((j % self.count, dwell.level) for j in run)
        return levels

    def _equations(self, first: np.ndarray, factors: np.ndarray, values: np.ndarray) -> Equations:
        """The normal equations F' F x = F' values of a problem of least squares F x = values.

        Row r of F holds factors[r, k] at the coefficients first[r] + k. What a coefficient that is
        held contributes goes to the right-hand side. first (rows,), factors (rows, m), values
        (rows,).
        """
        size = factors.shape[1]
        columns = (first[:, None] + np.arange(size)) % self.count  # (rows, m), of coefficients
        places = self.position[columns]  # (rows, m), of unknowns
        is_free = places >= 0
        level = np.zeros(self.count)
        level[list(self.levels)] = list(self.levels.values())
        products = factors[:, :, None] * factors[:, None, :]  # (rows, m, m), of two factors each
        # the right side: F' values, less what the products give with the levels
        of_values = (factors * values[:, None])[..., None]
        of_levels = -products * level[columns][:, None, :]
        summands = np.concatenate([of_values, of_levels], axis=2)  # (rows, m, 1 + m)
        right = np.zeros(len(self.order))
        np.add.at(right, np.repeat(places[is_free], size + 1), summands[is_free].ravel())
        # the lower half of the matrix: products of two unknowns, by row and diagonal
        diagonal = places[:, :, None] - places[:, None, :]  # below the main one
        counts = is_free[:, :, None] & is_free[:, None, :] & (diagonal >= 0)
        matrix = np.zeros((len(self.order), self.band + 1))
        row = np.broadcast_to(places[:, :, None], diagonal.shape)
        np.add.at(matrix, (row[counts], diagonal[counts]), products[counts])
        return Equations(matrix, right)

    def fit(self, length: float) -> Fit:
        """The fit of one smoothing length, in knot spacings."""
        length = float(f"{length:.9g}")  # one for those that differ by rounding
        if length not in self.fits:
            weight = self.rows_per_knot * length**8
            matrix = self.rows.matrix + weight * self.penalty.matrix
            right = self.rows.right + weight * self.penalty.right
            factors = Factors(matrix.tolist())
            coefficients = np.zeros(self.count)
            coefficients[self.order] = factors.solve(right.tolist())
            coefficients[list(self.levels)] = list(self.levels.values())
            self.fits[length] = Fit(coefficients, factors)
        return self.fits[length]

    def change(self, length: float, order: int = ACCEL) -> np.ndarray:
        """|change| of a derivative at every knot when the length doubles; m/rad2 of order 2."""
        doubled = self.knot_values(self.fit(2.0 * length), order)
        return np.abs(doubled - self.knot_values(self.fit(length), order))

    def per_rad(self, order: int) -> float:
        """Factor of a derivative of that order from knot spacings to rad."""
        return self.per_square if order == ACCEL else self.per_square * self.count * DEG / 360.0

    def balanced(self, sigma: float) -> np.ndarray:
        """The smoothing length at every knot that balances bending and noise, in knot spacings.

        It is the largest of LENGTHS up to which the bending is hidden (see the module), and along
        the turn it changes by no more than SLOPE from a knot to the next. sigma: the standard
        deviation of a row, m.
        """
        lengths = np.full(self.count, LENGTHS[0])
        is_hidden = np.ones(self.count, bool)
        limit = np.zeros(self.count)  # in a dwell nothing is fitted, so nothing scatters
        for length in LENGTHS:
            spread = self.spread({length: np.ones(self.count)}, self.moving)
            limit[self.moving] = BALANCE * sigma * spread
            bending = widest(self.change(AHEAD * length), BENDING_REACH * length)
            is_hidden &= bending <= widest(limit, BENDING_REACH * length)
            if not is_hidden.any():
                break
            lengths[is_hidden] = length
        for _ in range(2):  # forwards, then backwards along the turn
            for k in range(1, 2 * self.count):
                i = k % self.count
                lengths[i] = min(lengths[i], lengths[i - 1] + SLOPE)
            lengths = lengths[::-1].copy()
        return lengths

    def with_rms(self, wanted: float) -> float:
        """The smoothing length whose root mean square deviation is `wanted`, m, by bisection.

        Where every length deviates by more, or every one by less, it is the shortest or longest.
        """
        low = LENGTHS[0]
        high = LENGTHS[-1]
        if self.rms(self.fit(low).coefficients) >= wanted:
            return low
        for _ in range(LENGTH_HALVINGS):
            middle = sqrt(low * high)
            if self.rms(self.fit(middle).coefficients) < wanted:
                low = middle
            else:
                high = middle
        return low

    def knot_values(self, fit: Fit, order: int) -> np.ndarray:
        """c_thetatheta (order 2, m/rad2) or the third derivative at every knot."""
        knots = np.arange(self.count)
        weights = np.broadcast_to(basis(np.zeros(1), order), (self.count, WIDTH))
        return at(fit.coefficients, knots, weights) * self.per_rad(order)

    def leverage(self, length: float) -> np.ndarray:
        """How much of each coefficient the rows decide, from 0 to 1; the penalty decides the rest.

        The matrix of the fit is N + w P: N is the normal matrix of the rows, w P that of the
        penalty with this smoothing length. The shares are the diagonal of (N + w P)^-1 N, whose
        trace is that of the hat matrix: the degrees of freedom of the fit. A coefficient that is
        held at the level of a dwell has the share zero.
        """
        size = len(self.order)
        normal = np.zeros((size, size))
        for k in range(self.band + 1):  # the k-th diagonal below the main one, and above it
            row = np.arange(k, size)
            normal[row, row - k] = self.rows.matrix[k:, k]
            normal[row - k, row] = self.rows.matrix[k:, k]
        leverages = np.zeros(self.count)
        leverages[self.order] = np.diagonal(self.fit(length).factors.solve_all(normal))
        return leverages

    def residuals(self, coefficients: np.ndarray) -> np.ndarray:
        """Spline minus table, m, at every row."""
        return at(coefficients, self.interval, self.weights) - self.turn.lift

    def rms(self, coefficients: np.ndarray) -> float:
        """Root mean square deviation from the rows that move, m."""
        off = self.residuals(coefficients)[(self.turn.line > 0) & (self.turn.lift != 0.0)]
        return sqrt(float((off * off).sum()) / max(1, len(off)))

    def response(self, shares: Shares, intervals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """How much a derivative at some places answers to the right-hand side of the equations.

        A place k is in intervals[k], and its derivative is the sum of weights[..., j] times
        coefficient j of the interval. Column k of the result, (count, places), holds how much that
        changes by one unit of each coefficient's right-hand side: M^-1 w, as the matrix M is
        symmetric. Where the fit is blended of several lengths, each counts by its share at the
        coefficients. Zero where a coefficient is held.
        """
        places = np.arange(len(intervals))
        weight_of = np.zeros((self.count, len(intervals)))
        for k in range(WIDTH):
            weight_of[(intervals + k) % self.count, places] = weights[..., k]
        response = np.zeros_like(weight_of)
        for length, share in shares.items():
            blended = weight_of * share[:, None]
            some = np.flatnonzero(blended.any(axis=0))  # places where this length counts
            solved = self.fit(length).factors.solve_all(blended[np.ix_(self.order, some)])
            response[np.ix_(self.order, some)] += solved
        return response

    def spread(self, shares: Shares, intervals: np.ndarray, order: int = ACCEL) -> np.ndarray:
        """Standard errors of a derivative at knots per standard deviation of the rows.

        With z the response of the derivative, and N the normal matrix of the rows, the variance is
        z' N z. Of c_thetatheta the result is in 1/rad2, (intervals,).
        """
        z = self.response(shares, intervals, basis(np.zeros(1), order))[self.order]
        normal = self.rows.matrix
        variance = (normal[:, :1] * z * z).sum(axis=0)
        for k in range(1, self.band + 1):  # the k-th diagonal below the main one, and above it
            variance += 2.0 * (normal[k:, k : k + 1] * z[k:] * z[:-k]).sum(axis=0)
        return np.sqrt(np.maximum(variance, 0.0)) * self.per_rad(order)


# -- its error ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Accuracy:
    """Errors of one fit; lengths in m, c_thetatheta in m/rad2, angles in deg."""

    rows: int
    knots: int
    lift: float  # highest minus lowest row
    quantum: float  # step of the last digit
    spacing_deg: float  # median, between rows
    bends_between_rows: bool  # the rows lie too far apart for the lift
    noise: float  # standard deviation of a row: of the rounding, or more where rows scatter more
    rms: float  # deviation of the fit from the rows that move
    largest: float
    line: int  # of the file, where it is largest
    length_deg: float  # smoothing length
    accel: float  # largest |c_thetatheta|
    standard: float  # largest standard error of c_thetatheta
    worst: float  # its error were every row half a digit off, in the worst direction
    bending: float  # the rest of the bound: what smoothing may have changed
    jump_deg: float | None  # where c_thetatheta seems to jump, or c_theta; None where neither does
    jump_of: str | None  # which of them
    jump: float | None  # by how much, m/rad2 or m/rad
    jump_error: float | None  # standard error of that
    jump_sure: float | None  # standard errors by which no change over 4 deg or more fits as well

    @property
    def bound(self) -> float:
        """Largest bound on the error of c_thetatheta at a phase."""
        return ERRORS * self.standard + self.bending


def _apart(one_deg: float, other_deg: float) -> float:
    """How far two phases (deg) lie apart, by the shorter way round."""
    return abs((one_deg - other_deg + 180.0) % 360.0 - 180.0)


class Errors:
    """A fit of a table, and its errors, which are computed only where they are asked for.

    length: the smoothing length at every knot, or one for all, in knot spacings. A length between
    two of LENGTHS is blended of the fits of both; shares: how much each counts at every knot.
    """

    def __init__(self, smoother: Smoother, length: np.ndarray | float):
        self.smoother = smoother
        self.given = length
        count = smoother.count
        self.length = np.broadcast_to(length, count)  # (knots,)
        self.shares: Shares = {}
        if isinstance(length, float):
            self.shares = {length: np.ones(count)}
        else:
            # where each knot's length stands among LENGTHS: between two of them, or on one
            place = np.interp(np.log(length), np.log(LENGTHS), np.arange(len(LENGTHS)))
            for number, one_length in enumerate(LENGTHS):
                share = np.maximum(0.0, 1.0 - abs(place - number))
                if share.any():
                    self.shares[one_length] = share
        self.coefficients = self.blended(lambda x: smoother.fit(x).coefficients)

    @property
    def rougher(self) -> Errors:
        """The errors of a rougher fit, whose lengths are AHEAD times these."""
        return Errors(self.smoother, AHEAD * self.given)

    def blended(self, value: Callable[[float], np.ndarray]) -> np.ndarray:
        """The mean at every knot of what `value` returns for each length, by the lengths' shares.

        value: takes a smoothing length and returns a number for every knot, (knots,).
        """
        return sum(share * value(length) for length, share in self.shares.items())

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a row, m: that of the residuals, or that of rounding to a digit.

        The residuals count only where they are larger than rounding by SURE_OF_NOISE standard
        errors. Their mean square over the degrees of freedom (the rows less the trace of the hat
        matrix) has a relative standard error of sqrt(2 / freedom).
        """
        smoother = self.smoother
        turn = smoother.turn
        residuals = smoother.residuals(self.coefficients)
        moves = np.isin(smoother.interval, smoother.moving)
        trace = self.blended(smoother.leverage).sum()
        freedom = max(float(smoother.shares[moves].sum() - trace), 1.0)
        squares = (smoother.shares * residuals * residuals)[moves]
        squares = squares[squares < (WRONG * scatter(turn)) ** 2]
        deviation = sqrt(float(squares.sum()) / freedom)
        rounding = turn.quantum / sqrt(12.0)  # of a uniform distribution one quantum wide
        certain = (1.0 + SURE_OF_NOISE / sqrt(2.0 * freedom)) * rounding
        return deviation if deviation > certain else rounding

    @cached_property
    def accel(self) -> DerivativeErrors:
        """The errors of c_thetatheta."""
        return DerivativeErrors(self, ACCEL)

    @cached_property
    def jerk(self) -> DerivativeErrors:
        """The errors of the third derivative."""
        return DerivativeErrors(self, JERK)

    @property
    def standard(self) -> np.ndarray:
        """Standard errors of c_thetatheta at every knot, m/rad2; 0 in a dwell."""
        return self.accel.standard

    @property
    def bounds(self) -> list[float]:
        """Bound on the error of c_thetatheta in every knot interval, m/rad2; 0 in a dwell."""
        return self.accel.bounds

    @cached_property
    def accuracy(self) -> Accuracy:
        """Everything about the fit as a whole."""
        smoother = self.smoother
        turn = smoother.turn
        deviations = np.where(turn.line > 0, np.abs(smoother.residuals(self.coefficients)), 0.0)
        accels = np.abs(at(self.coefficients, *smoother.halves) * smoother.per_square)
        largest_standard = float(max(self.standard))
        jump = find_jump(turn, smoother.shares, self.noise, self.places_of_jumps())
        return Accuracy(
            rows=int((turn.line > 0).sum()),
            knots=smoother.count,
            lift=float(max(turn.lift) - min(turn.lift)),
            quantum=turn.quantum,
            spacing_deg=turn.spacing,
            bends_between_rows=bends_between_rows(turn),
            noise=self.noise,
            rms=smoother.rms(self.coefficients),
            largest=float(max(deviations)),
            line=int(turn.line[np.argmax(deviations)]),
            length_deg=float(np.median(self.length[smoother.moving])) * 360.0 / smoother.count,
            accel=float(max(accels)),
            standard=largest_standard,
            worst=self._worst_of_rounding(int(np.argmax(accels))),
            bending=float(max(self.bounds)) - ERRORS * largest_standard,
            jump_deg=jump.at if jump else None,
            jump_of=JUMPS[jump.order] if jump else None,
            jump=jump.size if jump else None,
            jump_error=jump.error if jump else None,
            jump_sure=jump.errors if jump else None,
        )

    def _worst_of_rounding(self, half: int) -> float:
        """The error of c_thetatheta in an interval, m/rad2, were every row half a digit off.

        Each row is off in the direction that adds to the error. half: index of a knot or middle
        (`Smoother.halves`), two for each interval that moves. With z the response in the middle of
        the interval, a row there changes c_thetatheta by share x sum of weights z.
        """
        smoother = self.smoother
        turn = smoother.turn
        interval = smoother.moving[[half // 2]]
        z = smoother.response(self.shares, interval, basis(np.array([0.5]), ACCEL))
        of_rows = (smoother.shares * at(z, smoother.interval, smoother.weights).T).T
        measured = of_rows[turn.line > 0]
        return float(0.5 * turn.quantum * smoother.per_square * np.abs(measured).sum())

    def places_of_jumps(self) -> list[float]:
        """Phases (deg) at which to look for a jump: ends of dwells, and where the cam is bent.

        These are the PLACES highest peaks of the bending, unless a dwell ends beside them.
        """
        dwells = self.smoother.turn.dwells
        ends = [end % 360.0 for dwell in dwells for end in (dwell.start, dwell.end)]
        excess = self.accel.excess
        peaks = (excess > 0.0) & (excess == widest(excess, APART))
        highest_first = sorted(np.flatnonzero(peaks), key=lambda k: -excess[k])
        places = list(ends)
        for k in highest_first[:PLACES]:
            place = float(k) * 360.0 / self.smoother.count
            if all(_apart(place, end) > BESIDE for end in ends):
                places.append(place)
        return places


class DerivativeErrors:
    """What a fit may have wrong of a derivative: c_thetatheta (order 2), or the third (order 3).

    Its arrays have a number for every knot, (knots,), or for every interval behind a knot.
    """

    def __init__(self, errors: Errors, order: int):
        self.errors = errors
        self.order = order

    def _changes(self, factor: float) -> np.ndarray:
        """|change| at every knot when a length of `factor` times the fit's doubles."""
        smoother = self.errors.smoother
        return self.errors.blended(lambda length: smoother.change(factor * length, self.order))

    @cached_property
    def standard(self) -> np.ndarray:
        """Standard errors at every knot; 0 in a dwell."""
        errors = self.errors
        smoother = errors.smoother
        standard = np.zeros(smoother.count)
        spread = smoother.spread(errors.shares, smoother.moving, self.order)
        standard[smoother.moving] = errors.noise * spread
        return standard

    @cached_property
    def excess(self) -> np.ndarray:
        """How much more a length AHEAD changes the derivative than QUIET standard errors."""
        more = np.maximum(self._changes(AHEAD) - QUIET * self.standard, 0.0)
        return np.where(self.standard > 0.0, more, 0.0)

    @cached_property
    def ratio(self) -> np.ndarray:
        """How the bending about every knot grows when the length doubles."""
        reach = BENDING_REACH * self.errors.length
        change = widest(self._changes(1.0), reach)
        change_of_double = widest(self._changes(2.0), reach)
        return np.clip(change_of_double / np.maximum(change, TINY), LEAST_RATIO, SMOOTH)

    @cached_property
    def bounds(self) -> list[float]:
        """Bound on the error in every knot interval, (knots,); 0 in a dwell.

        ERRORS standard errors, and the bending by the smoothing length L. That is C L^p, of which
        doubling a length AHEAD L = 2^(2/3) L shows excess = C L^p ratio^(2/3) (ratio - 1), ratio =
        2^p; about a knot the largest within L counts. Beside a dwell held coefficients take no part
        in the rounding: there the standard errors are too small, and the bound is the largest one
        within a basis function's width.
        """
        smoother = self.errors.smoother
        moves = np.zeros(smoother.count)
        moves[smoother.moving] = 1.0
        bending = self.excess / (self.ratio ** (2 / 3) * (self.ratio - 1.0))
        bound = ERRORS * self.standard + widest(bending, self.errors.length)
        beside_a_dwell = widest(1.0 - moves, WIDTH) > 0.0
        return (np.where(beside_a_dwell, widest(bound, WIDTH), bound) * moves).tolist()
