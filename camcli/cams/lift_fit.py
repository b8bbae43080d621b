"""The smoothing spline of a measured lift, and how far its second derivative may be trusted.

    minimise  sum share_k (c(theta_k) - lift_k)^2
              + sum weight_j (fourth difference of the coefficients about knot j)^2

over periodic splines of degree 7 on equal knots: six continuous derivatives, as the kernel wants.
The weight is the eighth power of a smoothing length (P. H. C. Eilers, B. D. Marx, Flexible
smoothing with B-splines and penalties, Statistical Science 11 (1996)). Coefficients in the middle
of a dwell are held at its level, so the dwell is exactly flat there. Rows side by side that are
rounded to one lift count as one: their roundings are the same.

The length at every knot is the largest up to which doubling it has changed c_thetatheta nearby by
no more than BALANCE standard errors: more smoothing would bend the cam there, less would let the
rounding through.

The error of c_thetatheta has two parts. Rounding passes through the linear smoother: a standard
error, and a worst case in which every row is wrong by half a digit in the worst direction.
Smoothing bends: how much, shows in what twice the length changes. Where the cam's c_thetatheta has
corners the bending falls by half with half the length, where it has none by more, as far as that
shows; where it jumps, it does not fall, and its bound is wider.

The coefficients come from additions, multiplications and divisions in a fixed order, element by
element: LAPACK and BLAS may give other last bits on another machine, these do not.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from math import factorial, sqrt
from typing import Any

import numpy as np
from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS, Piece
from camcli.cams.lift_reading import DEG, Turn
from camcli.kernel.cam_table import TERMS

DEGREE = 7
WIDTH = DEGREE + 1  # coefficients of an interval
CENTER = 3  # coefficient j weighs most at u = j - CENTER
MOST_KNOTS, LEAST_KNOTS = 720, 32
TOE = 8  # last digits: the lift of x^3 climbs them in 2.5 times the length hidden below half of one
LONGEST_RUN = 8  # rows of one lift that count as one together
MARGIN = 1.0  # knot spacings of a dwell's ends where coefficients stay free
PENALTY = np.array([[1.0, -4.0, 6.0, -4.0, 1.0]])
THIRD = 2.0 ** (1 / 3)
LENGTHS = [0.5 * 2**octave * step for octave in range(6) for step in (1.0, THIRD, THIRD * THIRD)]
BALANCE = 4.0
SLOPE = 0.5  # of the length along the turn
HALVINGS = 20  # of the logarithm of the length
SAMPLE = 600  # rows that estimate the noise
NORMAL = 0.6745  # median of |x| of a normal distribution
ERRORS = 4.0  # standard errors in the bound
SAFETY = 1.25  # of the estimate of the bending
LEAST_RATIO, CORNER = 1.33, 2.0  # of the bending when the length doubles: at a jump, at a corner
SMOOTH = 4.0  # the same without corners; more is not counted on
JUMP = 1.5  # a smaller ratio speaks of a jump
NEAR = 2.0  # smoothing lengths around a phase in which bending counts there

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


def _shares(lift: np.ndarray) -> np.ndarray:
    """What each row counts, (n,): rows side by side that are rounded to one lift are one."""
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
    """Coefficients of one smoothing length at every knot, and what solves for others."""

    weights: np.ndarray
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
        self.shares = _shares(turn.lift)
        root = np.sqrt(self.shares)
        factors = self.weights * root[:, None]
        self.normal, self.right = self._equations(self.interval, factors, turn.lift * root)
        self.rows_per_knot = len(turn.lift) / n
        self.fits: dict[bytes, Fit] = {}

    def _levels(self) -> dict[int, float]:
        """Coefficients held at the level of a dwell, but for what rounding may hide at its ends.

        Beside a run of equal rows the lift is hidden about as far as it takes to climb TOE digits.
        """
        held: dict[int, float] = {}
        scale = self.count / 360.0
        for dwell in self.turn.dwells:
            off = self.turn.theta[abs(self.turn.lift - dwell.level) > TOE * self.turn.quantum]
            before = min((dwell.start - off) % 360.0, default=0.0) * scale
            after = min((off - dwell.end) % 360.0, default=0.0) * scale
            low = dwell.start * scale + max(MARGIN, before)
            high = dwell.end * scale - max(MARGIN, after)
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

    def fit(self, length: np.ndarray | float) -> Fit:
        """The fit of a smoothing length in knot spacings: one, or one at every knot (count,)."""
        square = np.broadcast_to(length, self.count) ** 2
        weights = self.rows_per_knot * square * square * square * square
        key = weights.tobytes()
        if key not in self.fits:
            factors = np.sqrt(np.roll(weights, 1))[:, None] * PENALTY  # centred at knot i - 1
            none = np.zeros(self.count)
            penalty, right = self._equations(np.arange(self.count), factors, none)
            solver = Factors((self.normal + penalty).tolist())
            solved = np.zeros(self.count)
            solved[self.order] = solver.solve((self.right + right).tolist())
            solved[list(self.levels)] = list(self.levels.values())
            self.fits[key] = Fit(weights, solved, solver)
        return self.fits[key]

    def balanced(self, sigma: float) -> np.ndarray:
        """The smoothing length at every knot that balances bending and noise (see the module)."""
        knots = np.arange(self.count)
        length = np.full(self.count, LENGTHS[0])
        good = np.ones(self.count, bool)
        for x in LENGTHS:
            fit = self.fit(x)
            change = np.abs(self.knot_accels(self.fit(2.0 * x)) - self.knot_accels(fit))
            bad = change > BALANCE * sigma * self.spread(fit, knots, basis(np.zeros(1), 2))
            reach = int(np.ceil(NEAR * x))
            for step in range(-reach, reach + 1):
                good &= ~np.roll(bad, step)
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
        if self.rms(self.fit(low)) >= wanted:
            return low
        for _ in range(HALVINGS):
            middle = sqrt(low * high)
            if self.rms(self.fit(middle)) < wanted:
                low = middle
            else:
                high = middle
        return low

    def knot_accels(self, fit: Fit) -> np.ndarray:
        """c_thetatheta at every knot, m/rad2."""
        knots = np.arange(self.count)
        weights = np.broadcast_to(basis(np.zeros(1), 2), (self.count, WIDTH))
        return at(fit.coefficients, knots, weights) * self.per_square

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
        z = self.response(fit, intervals, weights)[self.order]
        total = (self.normal[:, :1] * z * z).sum(axis=0)
        for k in range(1, self.band + 1):
            total += 2.0 * (self.normal[k:, k : k + 1] * z[k:] * z[:-k]).sum(axis=0)
        return np.sqrt(np.maximum(total, 0.0)) * self.per_square


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
    bending: float  # the rest of the bound: what smoothing may have changed
    jump_deg: float | None  # where c_thetatheta seems to jump

    @property
    def bound(self) -> float:
        """Bound on the error of c_thetatheta anywhere."""
        return ERRORS * self.standard + self.bending


class Errors:
    """The errors of one fit, looked at only where they are asked for."""

    def __init__(self, smoother: Smoother, length: np.ndarray | float, noise: float):
        self.smoother, self.noise = smoother, noise
        self.length = np.broadcast_to(length, smoother.count)  # (knots,), in knot spacings
        self.fit = smoother.fit(self.length)

    @cached_property
    def changes(self) -> list[np.ndarray]:
        """|change| of c_thetatheta at `Smoother.halves` when the length doubles, and again."""
        s = self.smoother
        accels = [s.accels(s.fit(self.length * factor)) for factor in (1.0, 2.0, 4.0)]
        return [np.abs(b - a) for a, b in pairwise(accels)]

    @cached_property
    def standard(self) -> np.ndarray:
        """Standard errors of c_thetatheta at the knots of the moving intervals, m/rad2."""
        s = self.smoother
        return self.noise * s.spread(self.fit, s.moving, basis(np.zeros(1), 2))

    @cached_property
    def ratio(self) -> float:
        """How the bending grows when the length doubles; as at a corner where it is not seen."""
        first, second = (float(max(change)) for change in self.changes)
        return second / first if first > BALANCE * max(self.standard) else CORNER

    @property
    def factor(self) -> float:
        """Of the bending over what it changes when the length doubles."""
        return SAFETY / (min(max(self.ratio, LEAST_RATIO), SMOOTH) - 1.0)

    @cached_property
    def bounds(self) -> list[float]:
        """Bound on the error of c_thetatheta in every knot interval, m/rad2; 0 in a dwell.

        The bending at a place is the mean of what doubling the length changes within a length of
        it, since most of that is rounding, or within NEAR lengths the largest that is more.
        """
        s, change, sure = (
            self.smoother,
            np.zeros(self.smoother.count),
            np.zeros(self.smoother.count),
        )
        change[s.moving] = self.changes[0].reshape(-1, 2).max(axis=1)
        sure[s.moving] = np.where(change[s.moving] > BALANCE * self.standard, change[s.moving], 0.0)
        middle, reach = np.floor(self.length), np.ceil(NEAR * self.length)
        total, largest = np.zeros(s.count), np.zeros(s.count)
        for step in range(-int(max(reach)), int(max(reach)) + 1):
            total += np.where(abs(step) <= middle, np.roll(change, step) ** 2, 0.0)
            largest = np.where(
                abs(step) <= reach, np.maximum(largest, np.roll(sure, step)), largest
            )
        found = self.factor * np.maximum(largest, np.sqrt(total / (2 * middle + 1)))
        found[s.moving] += ERRORS * self.standard
        found[np.setdiff1d(np.arange(s.count), s.moving)] = 0.0
        return found.tolist()

    def accuracy(self) -> Accuracy:
        """Everything about the fit as a whole."""
        s, turn = self.smoother, self.smoother.turn
        off = np.where(turn.line > 0, np.abs(s.residuals(self.fit)), 0.0)
        accels, most = np.abs(s.accels(self.fit)), int(np.argmax(self.changes[0]))
        middle = s.moving[[np.argmax(accels) // 2]]
        answer = s.response(self.fit, middle, basis(np.array([0.5]), 2))
        answer = (s.shares * at(answer, s.interval, s.weights).T).T[turn.line > 0]
        bound = float(max(self.bounds))
        jump = self.changes[0][most] > BALANCE * max(self.standard) and self.ratio < JUMP
        return Accuracy(
            rows=int((turn.line > 0).sum()),
            knots=s.count,
            lift=float(max(turn.lift) - min(turn.lift)),
            quantum=turn.quantum,
            noise=self.noise,
            rms=s.rms(self.fit),
            largest=float(max(off)),
            line=int(turn.line[np.argmax(off)]),
            length_deg=float(np.median(self.length[s.moving])) * 360.0 / s.count,
            accel=float(max(accels)),
            standard=float(max(self.standard)),
            worst=float(0.5 * turn.quantum * s.per_square * np.abs(answer).sum()),
            bending=bound - ERRORS * float(max(self.standard)),
            jump_deg=float(s.moving[most // 2] + 0.5 * (most % 2)) * 360.0 / s.count
            if jump
            else None,
        )
