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
from typing import Any

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
    """Standard deviation of the rows that move from polynomials of degree 3, 5 and 7, m."""
    level = (np.roll(turn.lift, 1) == turn.lift) & (np.roll(turn.lift, -1) == turn.lift)
    moving = np.flatnonzero((turn.line > 0) & ~level)
    moving = moving[:: 1 + len(moving) // SAMPLE]
    if len(moving) == 0:
        return [0.0, 0.0, 0.0]
    estimates = []
    for reach in (2, 3, 4):
        off, weights = turn.deviations(reach)
        squares = np.sort((off * off / (1.0 + (weights * weights).sum(axis=0)))[moving])
        estimates.append(sqrt(float(squares[: int(0.9 * len(moving)) + 1].mean()) / TRIMMED))
    return estimates


def _shares(lift: np.ndarray) -> np.ndarray:
    """The weight of each row, (n,): rows side by side that round to one lift count as one row."""
    start = np.flatnonzero(lift != np.roll(lift, 1))
    if len(start) == 0:
        return np.ones(len(lift))
    length = np.diff(np.append(start, start[0] + len(lift)))
    return np.roll(np.repeat(1.0 / np.minimum(length, LONGEST_RUN), length), start[0])


# -- B-splines of degree 7 on equal knots ------------------------------------------------------
# Angles are in knot spacings, u = theta K/(2 pi). Interval i holds u in [i, i + 1] and depends on
# the coefficients i, ..., i + 7 (modulo K).


@cache
def _weights() -> list[list[int]]:
    """The weights of a spline's coefficients in an interval, as polynomials (whole numbers).

    The spline of degree 7 in interval i is the sum over k of coefficient i + k times weight k(t),
    t = u - i from 0 to 1. Entry k holds 7! times the coefficients of weight k by powers of t.
    """
    pieces = [[1]]  # p! times those of degree p; piece r of a basis function holds [r, r + 1]
    for p in range(1, WIDTH):
        raised = [[0] * (p + 1) for _ in range(p + 1)]
        for r, old in enumerate(pieces):
            for j, value in enumerate(old):
                raised[r][j] += value * r
                raised[r][j + 1] += value
                raised[r + 1][j] += value * (p - r)
                raised[r + 1][j + 1] -= value
        pieces = raised
    return pieces[::-1]


def basis(t: Any, order: int = 0) -> np.ndarray:
    """Weights of the eight coefficients, or of a derivative by u, at t in [0, 1]; (..., 8)."""
    columns = []
    for row in _weights():
        value = 0.0 * t
        for j in range(DEGREE, order - 1, -1):
            value = value * t + row[j] * (factorial(j) // factorial(j - order)) / factorial(DEGREE)
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
    """Interval i, plus a base, as a piece of the kernel's table, rounded once."""
    count = len(coefficients)
    with precision(DIGITS):
        width = 2 * arb.pi() / count
        low, high = float(width * i), float(width * (i + 1))
        center = (low + high) / 2
        powers = [arb(base) * factorial(DEGREE), *[arb(0)] * DEGREE]
        for k, row in enumerate(_weights()):
            for j, factor in enumerate(row):
                powers[j] += arb(float(coefficients[(i + k) % count])) * factor
        t = center / width - i  # about a half: the centre in doubles
        for k in range(DEGREE):  # synthetic division: powers of t - center
            for j in range(DEGREE - 1, k - 1, -1):
                powers[j] += t * powers[j + 1]
        values = [float(v / factorial(DEGREE) / width**j) for j, v in enumerate(powers)]
    return Piece(center, (high - low) / 2, tuple(values + [0.0] * (TERMS - WIDTH)))


def widest(values: np.ndarray, reach: np.ndarray | float) -> np.ndarray:
    """The largest of values (not negative) within `reach` knots."""
    largest = values
    most = int(np.max(reach))
    for step in range(-most, most + 1):
        largest = np.maximum(largest, np.where(abs(step) <= reach, np.roll(values, step), 0.0))
    return largest


class Factors:
    """LDL' of a symmetric positive definite band matrix; `rows[i][k]` is its (i, i - k)."""

    def __init__(self, rows: Rows):
        self.lower: Rows = []  # (i, i - k) of L
        self.pivots: list[float] = []
        for i, row in enumerate(rows):
            reach = min(i, len(row) - 1)
            scaled = [0.0] * len(row)  # L(i, j) D(j)
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

    def solve(self, right: Sequence | np.ndarray) -> np.ndarray:
        """The solution for one right-hand side, or for every column of several."""
        x = list(right)
        n = len(right)
        for i, row in enumerate(self.lower):
            for k in range(1, min(i, len(row) - 1) + 1):
                x[i] = x[i] - row[k] * x[i - k]
        x = [value / pivot for value, pivot in zip(x, self.pivots, strict=True)]
        for i in range(n - 1, -1, -1):
            row = self.lower[i]
            for k in range(1, min(i, len(row) - 1) + 1):
                x[i - k] = x[i - k] - row[k] * x[i]
        return np.array(x)


# -- the fit -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fit:
    """Coefficients of one smoothing length, and what solves for others."""

    coefficients: np.ndarray
    factors: Factors


class Smoother:
    """Normal equations of one table; `count` knots a turn, u = theta count/360 deg.

    moving: the intervals that are not held flat; halves: their knots and middles; shares: the
    weight of each row of the table; band: diagonals on one side of the matrix.
    """

    def __init__(self, turn: Turn):
        self.turn = turn
        self.count = n = max(LEAST_KNOTS, min(MOST_KNOTS, int(360.0 / turn.spacing + 0.5)))
        self.per_square = (n * DEG / 360.0) ** 2  # from knot spacings to rad
        self.levels = held = self._levels()
        # unknowns in an order with a narrow band: behind a dwell, or folded round the turn
        start = next((j for j in held if (j + 1) % n not in held), None)
        order = [k // 2 if k % 2 == 0 else n - 1 - k // 2 for k in range(n)]
        if start is not None:
            order = [(start + k) % n for k in range(n)]
        self.band = 2 * DEGREE if start is None else DEGREE
        self.order = np.array([j for j in order if j not in held])
        self.position = np.full(n, -1)
        self.position[self.order] = np.arange(len(self.order))
        free = self.position >= 0
        spread = np.arange(n)[:, None] + np.arange(WIDTH)
        self.moving = np.flatnonzero(free[spread % n].any(axis=1))
        knot_and_middle = basis(np.array([0.0, 0.5]), 2)
        self.halves = np.repeat(self.moving, 2), np.tile(knot_and_middle, (len(self.moving), 1))
        u = turn.theta * n / 360.0
        self.interval = np.minimum(u.astype(int), n - 1)
        self.weights = basis(u - self.interval)
        self.shares = _shares(turn.lift)
        root = np.sqrt(self.shares)
        factors = self.weights * root[:, None]
        self.normal, self.right = self._equations(self.interval, factors, turn.lift * root)
        bent = np.tile(PENALTY, (n, 1))  # centred at knot i + 2
        self.penalty = self._equations(np.arange(n), bent, np.zeros(n))
        self.rows_per_knot = len(turn.lift) / n
        self.fits: dict[float, Fit] = {}

    def _levels(self) -> dict[int, float]:
        """The coefficients that are not fitted but held at a dwell's level (m), by number.

        A table shows a dwell as a run of equal rows, though the lift may begin to rise within the
        run by less than a digit. So the coefficients near both ends of a run stay free: as far from
        an end as the lift needs beyond it to climb TOE digits, and FREE_SPACINGS knots at least.
        """
        levels: dict[int, float] = {}
        scale = self.count / 360.0
        for dwell in self.turn.dwells:
            off = self.turn.theta[abs(self.turn.lift - dwell.level) > TOE * self.turn.quantum]
            before = min((dwell.start - off) % 360.0, default=0.0) * scale
            after = min((off - dwell.end) % 360.0, default=0.0) * scale
            low = dwell.start * scale + max(FREE_SPACINGS, before)
            high = dwell.end * scale - max(FREE_SPACINGS, after)
            run = range(int(low + CENTER) + 1, int(np.floor(high + CENTER)) + 1)
            if len(run) >= WIDTH:
                levels.update((j % self.count, dwell.level) for j in run)
        return levels

    def _equations(self, first: np.ndarray, factors: np.ndarray, values: np.ndarray):
        """Normal equations of sum over k of factors[., k] x[first + k] = values: band, right."""
        size = factors.shape[1]
        columns = (first[:, None] + np.arange(size)) % self.count
        places = self.position[columns]
        level = np.zeros(self.count)
        level[list(self.levels)] = list(self.levels.values())
        products = factors[:, :, None] * factors[:, None, :]
        given = np.concatenate(
            [(factors * values[:, None])[..., None], -products * level[columns][:, None, :]], axis=2
        )
        free = places >= 0
        right = np.zeros(len(self.order))
        np.add.at(right, np.repeat(places[free], size + 1), given[free].ravel())
        down = places[:, :, None] - places[:, None, :]
        pair = free[:, :, None] & free[:, None, :] & (down >= 0)
        band = np.zeros((len(self.order), self.band + 1))
        row = np.broadcast_to(places[:, :, None], down.shape)
        np.add.at(band, (row[pair], down[pair]), products[pair])
        return band, right

    def fit(self, length: float) -> Fit:
        """The fit of one smoothing length, in knot spacings."""
        length = float(f"{length:.9g}")  # one for those that differ by rounding
        if length not in self.fits:
            weight = self.rows_per_knot * length**8
            solver = Factors((self.normal + weight * self.penalty[0]).tolist())
            solved = np.zeros(self.count)
            solved[self.order] = solver.solve((self.right + weight * self.penalty[1]).tolist())
            solved[list(self.levels)] = list(self.levels.values())
            self.fits[length] = Fit(solved, solver)
        return self.fits[length]

    def change(self, length: float, order: int = ACCEL) -> np.ndarray:
        """|change| of a derivative at every knot when the length doubles; m/rad2 of order 2."""
        values = (self.knot_values(self.fit(x), order) for x in (2.0 * length, length))
        return np.abs(next(values) - next(values))

    def per_rad(self, order: int) -> float:
        """Factor of a derivative of that order from knot spacings to rad."""
        return self.per_square if order == ACCEL else self.per_square * self.count * DEG / 360.0

    def balanced(self, sigma: float) -> np.ndarray:
        """The smoothing length at every knot that balances bending and noise (see the module)."""
        knots = np.arange(self.count)
        length = np.full(self.count, LENGTHS[0])
        good = np.ones(self.count, bool)
        for x in LENGTHS:
            limit = BALANCE * sigma * self.spread({x: np.ones(self.count)}, knots)
            good &= widest(self.change(AHEAD * x), BENDING_REACH * x) <= widest(
                limit, BENDING_REACH * x
            )
            if not good.any():
                break
            length[good] = x
        for _ in range(2):  # a length does not change faster than SLOPE
            for k in range(1, 2 * self.count):
                i = k % self.count
                length[i] = min(length[i], length[i - 1] + SLOPE)
            length = length[::-1].copy()
        return length

    def with_rms(self, wanted: float) -> float:
        """The length whose root mean square deviation is `wanted`, or the nearest there is."""
        low, high = LENGTHS[0], LENGTHS[-1]
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
            normal[row, row - k] = self.normal[k:, k]
            normal[row - k, row] = self.normal[k:, k]
        leverages = np.zeros(self.count)
        leverages[self.order] = np.diagonal(self.fit(length).factors.solve(normal))
        return leverages

    def residuals(self, coefficients: np.ndarray) -> np.ndarray:
        """Spline minus table, m, at every row."""
        return at(coefficients, self.interval, self.weights) - self.turn.lift

    def rms(self, coefficients: np.ndarray) -> float:
        """Root mean square deviation from the rows that move, m."""
        off = self.residuals(coefficients)[(self.turn.line > 0) & (self.turn.lift != 0.0)]
        return sqrt(float((off * off).sum()) / max(1, len(off)))

    def response(self, shares: Shares, intervals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """How derivatives answer to the right-hand side: (count, places), zero where held."""
        right = np.zeros((self.count, len(intervals)))
        for k in range(WIDTH):
            right[(intervals + k) % self.count, np.arange(len(intervals))] = weights[..., k]
        whole = np.zeros_like(right)
        for length, share in shares.items():
            mine = right * share[:, None]
            some = np.flatnonzero(mine.any(axis=0))
            moved = self.fit(length).factors.solve(mine[np.ix_(self.order, some)])
            whole[np.ix_(self.order, some)] += moved
        return whole

    def spread(self, shares: Shares, intervals: np.ndarray, order: int = ACCEL) -> np.ndarray:
        """Standard errors of a derivative at knots per standard deviation of the rows.

        Of c_thetatheta in 1/rad2.
        """
        z = self.response(shares, intervals, basis(np.zeros(1), order))[self.order]
        total = (self.normal[:, :1] * z * z).sum(axis=0)
        for k in range(1, self.band + 1):
            total += 2.0 * (self.normal[k:, k : k + 1] * z[k:] * z[:-k]).sum(axis=0)
        return np.sqrt(np.maximum(total, 0.0)) * self.per_rad(order)


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
    """The errors of one fit, looked at only where they are asked for."""

    def __init__(self, smoother: Smoother, length: np.ndarray | float):
        self.smoother = smoother
        self.given = length
        count = smoother.count
        self.length = np.broadcast_to(length, count)  # (knots,), in knot spacings
        self.shares: Shares = {}
        if isinstance(length, float):
            self.shares = {length: np.ones(count)}
        else:
            place = np.interp(np.log(length), np.log(LENGTHS), np.arange(len(LENGTHS)))
            hats = {x: np.maximum(0.0, 1.0 - abs(place - m)) for m, x in enumerate(LENGTHS)}
            self.shares = {x: hat for x, hat in hats.items() if hat.any()}
        self.coefficients = self.blended(lambda x: smoother.fit(x).coefficients)

    @property
    def rougher(self) -> Errors:
        """The errors of a rougher fit, whose lengths are AHEAD times these."""
        return Errors(self.smoother, AHEAD * self.given)

    def blended(self, value: Callable[[float], np.ndarray]) -> np.ndarray:
        """What a smoothing length gives at every knot, of the lengths that count there."""
        return sum(share * value(x) for x, share in self.shares.items())

    @cached_property
    def noise(self) -> float:
        """Standard deviation of a row, m: that of the residuals, or that of rounding to a digit.

        The residuals count only where they are larger than rounding by SURE_OF_NOISE standard
        errors. Their mean square over the degrees of freedom (the rows less the trace of the hat
        matrix) has a relative standard error of sqrt(2 / freedom).
        """
        s = self.smoother
        off = s.residuals(self.coefficients)
        moves = np.isin(s.interval, s.moving)
        freedom = max(float(s.shares[moves].sum() - self.blended(s.leverage).sum()), 1.0)
        squares = (s.shares * off * off)[moves]
        squares = squares[squares < (WRONG * scatter(s.turn)) ** 2]
        deviation = sqrt(float(squares.sum()) / freedom)
        rounding = s.turn.quantum / sqrt(12.0)
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

    def accuracy(self) -> Accuracy:
        """Everything about the fit as a whole."""
        s = self.smoother
        turn = self.smoother.turn
        off = np.where(turn.line > 0, np.abs(s.residuals(self.coefficients)), 0.0)
        accels = np.abs(at(self.coefficients, *s.halves) * s.per_square)
        # how much one unit of each row moves c_thetatheta where that is largest
        middle = s.moving[[np.argmax(accels) // 2]]
        answer = s.response(self.shares, middle, basis(np.array([0.5]), 2))
        answer = (s.shares * at(answer, s.interval, s.weights).T).T[turn.line > 0]
        jump = find_jump(turn, s.shares, self.noise, self.places_of_jumps())
        return Accuracy(
            rows=int((turn.line > 0).sum()),
            knots=s.count,
            lift=float(max(turn.lift) - min(turn.lift)),
            quantum=turn.quantum,
            spacing_deg=turn.spacing,
            bends_between_rows=bends_between_rows(turn),
            noise=self.noise,
            rms=s.rms(self.coefficients),
            largest=float(max(off)),
            line=int(turn.line[np.argmax(off)]),
            length_deg=float(np.median(self.length[s.moving])) * 360.0 / s.count,
            accel=float(max(accels)),
            standard=float(max(self.standard)),
            worst=float(0.5 * turn.quantum * s.per_square * np.abs(answer).sum()),
            bending=float(max(self.bounds)) - ERRORS * float(max(self.standard)),
            jump_deg=jump.at if jump else None,
            jump_of=JUMPS[jump.order] if jump else None,
            jump=jump.size if jump else None,
            jump_error=jump.error if jump else None,
            jump_sure=jump.errors if jump else None,
        )

    def places_of_jumps(self) -> list[float]:
        """Phases (deg) at which to look for a jump: ends of dwells, and where the cam is bent."""
        ends = [end % 360.0 for d in self.smoother.turn.dwells for end in (d.start, d.end)]
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
    """What a fit may have wrong of a derivative: c_thetatheta (order 2), or the third (order 3)."""

    def __init__(self, errors: Errors, order: int):
        self.errors = errors
        self.order = order

    def _changes(self, factor: float) -> np.ndarray:
        """|change| at every knot when a length of `factor` times the fit's doubles."""
        errors = self.errors
        return errors.blended(lambda x: errors.smoother.change(factor * x, self.order))

    @cached_property
    def standard(self) -> np.ndarray:
        """Standard errors at every knot; 0 in a dwell."""
        errors = self.errors
        s = self.errors.smoother
        standard = np.zeros(s.count)
        standard[s.moving] = errors.noise * s.spread(errors.shares, s.moving, self.order)
        return standard

    @cached_property
    def excess(self) -> np.ndarray:
        """How much more a length AHEAD changes the derivative than QUIET standard errors."""
        change = self._changes(AHEAD)
        return np.where(self.standard > 0.0, np.maximum(change - QUIET * self.standard, 0.0), 0.0)

    @cached_property
    def ratio(self) -> np.ndarray:
        """How the bending about every knot grows when the length doubles."""
        reach = BENDING_REACH * self.errors.length
        change, more = (widest(self._changes(factor), reach) for factor in (1.0, 2.0))
        return np.clip(more / np.maximum(change, TINY), LEAST_RATIO, SMOOTH)

    @cached_property
    def bounds(self) -> list[float]:
        """Bound on the error in every knot interval; 0 in a dwell."""
        s = self.errors.smoother
        moves = np.zeros(s.count)
        moves[s.moving] = 1.0
        bending = self.excess / (self.ratio ** (2 / 3) * (self.ratio - 1.0))
        total = ERRORS * self.standard + widest(bending, self.errors.length)
        edge = widest(1.0 - moves, WIDTH) > 0.0  # held coefficients take no rounding: no measure
        return (np.where(edge, widest(total, WIDTH), total) * moves).tolist()
