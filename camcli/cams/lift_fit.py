"""The smoothing spline of a measured lift, and how far its second derivative may be trusted.

    minimise  sum (c(theta_k) - lift_k)^2 + weight * sum (fourth differences of coefficients)^2

over periodic splines of degree 7 on equal knots: six continuous derivatives, as the kernel wants.
Coefficients in the middle of a dwell are held at its level, so the dwell is exactly flat there. The
weight that fits the rounding is the largest at which doubling the smoothing length still changes
c_thetatheta by no more than BALANCE standard errors: more smoothing would bend the cam, less would
let the rounding through (P. H. C. Eilers, B. D. Marx, Flexible smoothing with B-splines and
penalties, Statistical Science 11 (1996), for the penalty).

The error of c_thetatheta has two parts. Rounding passes through the linear smoother: a standard
error, and a worst case in which every row is wrong by half a digit in the worst direction.
Smoothing bends: how much, shows in what twice the smoothing length changes. Where the cam's
c_thetatheta has corners the bending falls by half with half the length; where it jumps, it does
not, and its bound is wider.

The coefficients come from additions, multiplications and divisions in a fixed order, element by
element: LAPACK and BLAS may give other last bits on another machine, these do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cache, cached_property
from math import factorial, sqrt
from typing import Any

import numpy as np

from camcli.cams.compile import Piece
from camcli.cams.decimals import DIGITS, pi
from camcli.cams.lift_reading import DEG, Turn
from camcli.kernel.cam_table import TERMS

DEGREE = 7
WIDTH = DEGREE + 1  # coefficients of an interval
CENTER = 3  # coefficient j weighs most at u = j - CENTER
MOST_KNOTS, LEAST_KNOTS = 720, 32
MARGIN = 1.0  # knot spacings of a dwell's ends where coefficients stay free
PENALTY = np.array([[1.0, -4.0, 6.0, -4.0, 1.0]])
STEP = 4.0  # between weights; the smoothing length grows by its eighth root
DOUBLE = STEP**4  # doubles the smoothing length
LOWEST, HIGHEST = -4, 17  # powers of STEP
BALANCE = 4.0
GIVE_UP = 10.0  # standard errors: no larger weight can balance
HALVINGS = 20  # of the logarithm of the weight
PLACES = 12  # phases at which the standard error is looked at
SAMPLE = 600  # rows that estimate the noise
NORMAL = 0.6745  # median of |x| of a normal distribution
ERRORS = 4.0  # standard errors in the bound
SAFETY = 1.25  # of the estimate of the bending
LEAST_RATIO, MOST_RATIO = 1.33, 3.0  # of the bending when the length doubles
JUMP = 1.5  # a smaller ratio speaks of a jump
NEAR = 2.0  # smoothing lengths around a phase in which bending counts there
SHARES = 90  # of the turn, each with its own bound

Rows = list[list[float]]


def noise(turn: Turn) -> float:
    """Standard deviation of the rows, m: of the rounding, or more where rows scatter more.

    The scatter is the least of three estimates from polynomials of rising degree: where the lift
    itself bends between rows, the higher ones see less of it.
    """
    level = (np.roll(turn.lift, 1) == turn.lift) & (np.roll(turn.lift, -1) == turn.lift)
    moving = np.flatnonzero((turn.line > 0) & ~level)
    moving = moving[:: 1 + len(moving) // SAMPLE]
    estimates = [0.0] if len(moving) == 0 else []
    for reach in (2, 3, 4) if len(moving) else ():
        off, weights = turn.deviations(reach)
        scatter = np.sort((np.abs(off) / np.sqrt(1.0 + (weights * weights).sum(axis=0)))[moving])
        estimates.append(float(scatter[(len(moving) - 1) // 2]) / NORMAL)
    return max(turn.quantum / sqrt(12.0), min(estimates))


# -- B-splines of degree 7 on equal knots ------------------------------------------------------
# Angles are in knot spacings, u = theta K/(2 pi). Interval i holds u in [i, i + 1] and depends on
# the coefficients i, ..., i + 7 (modulo K).


@cache
def _weights() -> list[list[int]]:
    """7! times the power coefficients in t = u - i of the weight of coefficient i + k, by k."""
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
    found = []
    for row in _weights():
        value = 0.0 * t
        for j in range(DEGREE, order - 1, -1):
            value = value * t + row[j] * (factorial(j) // factorial(j - order)) / factorial(DEGREE)
        found.append(value)
    return np.stack(found, axis=-1)


def at(coefficients: np.ndarray, i: np.ndarray, weights: np.ndarray) -> Any:
    """The spline (or a derivative) in the intervals i (n,) with their weights (n, 8).

    Of coefficients (count,), or of several splines (count, m) at once: (n, m).
    """
    value = 0.0
    for k in range(WIDTH):
        value = value + (weights[:, k] * coefficients[(i + k) % len(coefficients)].T).T
    return value


def piece(coefficients: np.ndarray, i: int, base: float = 0.0) -> Piece:
    """Interval i, plus a base, as a piece of the kernel's table, rounded once from 40 digits."""
    count = len(coefficients)
    with localcontext() as context:
        context.prec = DIGITS
        width = 2 * pi() / count
        low, high = float(width * i), float(width * (i + 1))
        center = (low + high) / 2
        powers = [Decimal(base) * factorial(DEGREE), *[Decimal(0)] * DEGREE]
        for k, row in enumerate(_weights()):
            for j, factor in enumerate(row):
                powers[j] += Decimal(float(coefficients[(i + k) % count])) * factor
        t = Decimal(center) / width - i  # about a half: the centre in doubles
        for k in range(DEGREE):  # synthetic division: powers of t - center
            for j in range(DEGREE - 1, k - 1, -1):
                powers[j] += t * powers[j + 1]
        values = [float(v / factorial(DEGREE) / width**j) for j, v in enumerate(powers)]
    return Piece(center, (high - low) / 2, tuple(values + [0.0] * (TERMS - WIDTH)))


class Factors:
    """LDL' of a symmetric positive definite band matrix; `rows[i][k]` is its (i, i - k)."""

    def __init__(self, rows: Rows):
        self.lower: Rows = []  # (i, i - k) of L
        self.pivots: list[float] = []
        for i, row in enumerate(rows):
            reach = min(i, len(row) - 1)
            scaled = [0.0] * len(row)  # L(i, j) D(j)
            for k in range(reach, 0, -1):
                value, above = row[k], self.lower[i - k]
                for m in range(1, reach - k + 1):
                    value -= scaled[k + m] * above[m]
                scaled[k] = value
            lower, pivot = [1.0] + [0.0] * (len(row) - 1), row[0]
            for k in range(1, reach + 1):
                lower[k] = scaled[k] / self.pivots[i - k]
                pivot -= scaled[k] * lower[k]
            self.lower.append(lower)
            self.pivots.append(pivot)

    def solve(self, right: Sequence) -> np.ndarray:
        """The solution for one right-hand side, or for every column of several."""
        x, n = list(right), len(right)
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
    """Coefficients of one weight and what solves for others."""

    weight: float
    coefficients: np.ndarray
    factors: Factors


class Smoother:
    """Normal equations of one table; `count` knots a turn, u = theta count/360 deg.

    `moving` are the intervals that are not held flat; `halves` their knots and middles.
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
        self.normal, self.right = self._equations(self.interval, self.weights, turn.lift)
        every = np.arange(n)
        penalty = np.repeat(PENALTY, n, axis=0)
        self.penalty, self.penalty_right = self._equations(every, penalty, np.zeros(n))
        self.rows_per_knot = len(turn.lift) / n
        self.fits: dict[float, Fit] = {}

    def _levels(self) -> dict[int, float]:
        """Coefficients held at the level of a dwell."""
        held: dict[int, float] = {}
        scale = self.count / 360.0
        for dwell in self.turn.dwells:
            low, high = dwell.start * scale + MARGIN, dwell.end * scale - MARGIN
            run = range(int(low + CENTER) + 1, int(np.floor(high + CENTER)) + 1)
            if len(run) >= WIDTH:
                held.update((j % self.count, dwell.level) for j in run)
        return held

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

    def fit(self, weight: float) -> Fit:
        """The fit of a weight."""
        if weight not in self.fits:
            factors = Factors((self.normal + weight * self.penalty).tolist())
            solved = np.zeros(self.count)
            solved[self.order] = factors.solve((self.right + weight * self.penalty_right).tolist())
            solved[list(self.levels)] = list(self.levels.values())
            self.fits[weight] = Fit(weight, solved, factors)
        return self.fits[weight]

    def balanced(self, sigma: float) -> Fit:
        """The fit whose weight balances bending and rounding (see the module)."""
        best = LOWEST
        for power in range(LOWEST, HIGHEST):
            fit = self.fit(self.rows_per_knot * STEP**power)
            error = sigma * self.error(fit)
            change = max(self.changes(fit))
            if change <= BALANCE * error:
                best = power
            elif change > GIVE_UP * error:
                break
        return self.fit(self.rows_per_knot * STEP**best)

    def with_rms(self, wanted: float) -> Fit:
        """The fit whose root mean square deviation is `wanted`, or the nearest there is."""
        low = self.fit(self.rows_per_knot * STEP**LOWEST)
        high = self.fit(self.rows_per_knot * STEP**HIGHEST * DOUBLE)
        if self.rms(low) >= wanted:
            return low
        if self.rms(high) <= wanted:
            return high
        for _ in range(HALVINGS):
            middle = self.fit(sqrt(low.weight) * sqrt(high.weight))
            if self.rms(middle) < wanted:
                low = middle
            else:
                high = middle
        return low

    def residuals(self, fit: Fit) -> np.ndarray:
        """Spline minus table, m, at every row."""
        return at(fit.coefficients, self.interval, self.weights) - self.turn.lift

    def rms(self, fit: Fit) -> float:
        """Root mean square deviation from the rows that move, m."""
        off = self.residuals(fit)[(self.turn.line > 0) & (self.turn.lift != 0.0)]
        return sqrt(float((off * off).sum()) / max(1, len(off)))

    def accels(self, fit: Fit) -> np.ndarray:
        """c_thetatheta at `halves`, m/rad2."""
        return at(fit.coefficients, *self.halves) * self.per_square

    def changes(self, fit: Fit) -> np.ndarray:
        """|change| of `accels` when the smoothing length doubles."""
        return np.abs(self.accels(self.fit(fit.weight * DOUBLE)) - self.accels(fit))

    def response(self, fit: Fit, intervals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """How derivatives answer to the right-hand side: (count, places), zero where held."""
        right = np.zeros((self.count, len(intervals)))
        for k in range(WIDTH):
            right[(intervals + k) % self.count, np.arange(len(intervals))] = weights[..., k]
        whole = np.zeros_like(right)
        whole[self.order] = fit.factors.solve(right[self.order])
        return whole

    def spread(self, fit: Fit, intervals: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Standard errors of c_thetatheta at places per standard deviation of the rows, 1/rad2."""
        rows = at(self.response(fit, intervals, weights), self.interval, self.weights)
        return np.sqrt((rows * rows).sum(axis=0)) * self.per_square

    def error(self, fit: Fit) -> float:
        """Largest of these at some phases."""
        stride = max(1, len(self.moving) // PLACES)
        places = self.moving[stride // 2 :: stride]
        weights = basis(np.array([0.0, 0.5]), 2)[np.arange(len(places)) % 2]
        return max(self.spread(fit, places, weights), default=0.0)


# -- its error ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Accuracy:
    """Errors of one fit; lengths in m, c_thetatheta in m/rad2, angles in deg."""

    rows: int
    knots: int
    lift: float  # highest minus lowest row
    quantum: float  # step of the last digit
    noise: float  # standard deviation of a row: of the rounding, or more where rows scatter more
    rms: float  # deviation of the fit from the rows that move
    largest: float
    line: int  # of the file, where it is largest
    length_deg: float  # smoothing length
    accel: float  # largest |c_thetatheta|
    standard: float  # standard error of c_thetatheta
    worst: float  # its error were every row half a digit off, in the worst direction
    bending: float  # what smoothing may have changed
    jump_deg: float | None  # where c_thetatheta seems to jump

    @property
    def bound(self) -> float:
        """Bound on the error of c_thetatheta anywhere."""
        return ERRORS * self.standard + self.bending


class Errors:
    """The errors of one fit, looked at only where they are asked for."""

    def __init__(self, smoother: Smoother, fit: Fit, noise: float):
        self.smoother, self.fit, self.noise = smoother, fit, noise

    @cached_property
    def changes(self) -> np.ndarray:
        """|change| of c_thetatheta at `Smoother.halves` when the length doubles, m/rad2."""
        return self.smoother.changes(self.fit)

    @cached_property
    def ratio(self) -> float:
        """How the bending grows when the length doubles."""
        twice = self.smoother.fit(self.fit.weight * DOUBLE)
        first = max(self.changes)
        return float(max(self.smoother.changes(twice)) / first) if first > 0.0 else MOST_RATIO

    @property
    def factor(self) -> float:
        """Of the bending over what it changes when the length doubles."""
        return SAFETY / (min(max(self.ratio, LEAST_RATIO), MOST_RATIO) - 1.0)

    @property
    def length(self) -> float:
        """Smoothing length in knot spacings: the eighth root of the weight per row."""
        return max(1.0, (self.fit.weight / self.smoother.rows_per_knot) ** 0.125)

    @cached_property
    def bounds(self) -> list[float]:
        """Bound on the error of c_thetatheta in SHARES equal shares of the turn, m/rad2.

        The larger value of its two ends; 0 in the middle of a dwell.
        """
        s, count = self.smoother, self.smoother.count
        u = np.arange(SHARES) * (count / SHARES)
        i = u.astype(int)
        standard = self.noise * s.spread(self.fit, i, basis(u - i, 2))
        apart = np.abs((s.moving + 0.5 - u[:, None] + count / 2) % count - count / 2)
        nearby = apart <= NEAR * self.length + 0.5
        bending = np.where(nearby, self.changes.reshape(-1, 2).max(axis=1), 0.0).max(axis=1)
        ends = np.where(np.isin(i, s.moving), ERRORS * standard + self.factor * bending, 0.0)
        return np.maximum(ends, np.roll(ends, -1)).tolist()

    def accuracy(self) -> Accuracy:
        """Everything about the fit as a whole."""
        s, turn = self.smoother, self.smoother.turn
        off = np.where(turn.line > 0, np.abs(s.residuals(self.fit)), 0.0)
        accels, most = np.abs(s.accels(self.fit)), int(np.argmax(self.changes))
        middle = s.moving[[np.argmax(accels) // 2]]
        answer = s.response(self.fit, middle, basis(np.array([0.5]), 2))
        answer = at(answer, s.interval, s.weights)[turn.line > 0]
        standard = self.noise * s.error(self.fit)
        jump = self.changes[most] > ERRORS * standard and self.ratio < JUMP
        return Accuracy(
            rows=int((turn.line > 0).sum()),
            knots=s.count,
            lift=float(max(turn.lift) - min(turn.lift)),
            quantum=turn.quantum,
            noise=self.noise,
            rms=s.rms(self.fit),
            largest=float(max(off)),
            line=int(turn.line[np.argmax(off)]),
            length_deg=self.length * 360.0 / s.count,
            accel=float(max(accels)),
            standard=float(standard),
            worst=float(0.5 * turn.quantum * s.per_square * np.abs(answer).sum()),
            bending=float(self.factor * self.changes[most]),
            jump_deg=float(s.moving[most // 2] + 0.5 * (most % 2)) * 360.0 / s.count
            if jump
            else None,
        )
