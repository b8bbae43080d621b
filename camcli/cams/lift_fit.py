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

All of it is plain floats in a fixed order: LAPACK may give other last bits on another machine, IEEE
add, multiply and divide do not. No `sum` of floats: its rounding depends on the version of Python.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache, cached_property
from math import sqrt
from statistics import median_low

from camcli.cams.compile import Piece
from camcli.cams.decimals import DIGITS, pi
from camcli.cams.lift_reading import DEG, Turn
from camcli.kernel.cam_table import TERMS

DEGREE = 7
WIDTH = DEGREE + 1  # coefficients of an interval
CENTER = 3  # coefficient j weighs most at u = j - CENTER
MOST_KNOTS, LEAST_KNOTS = 720, 32
MARGIN = 1.0  # knot spacings of a dwell's ends where coefficients stay free
PENALTY = (1.0, -4.0, 6.0, -4.0, 1.0)
STEP = 4.0  # between weights; the smoothing length grows by its eighth root
OCTAVE = 4  # steps that double the smoothing length
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


def noise(turn: Turn) -> float:
    """Standard deviation of the rows, m: of the rounding, or more where rows scatter more.

    The scatter is the least of three estimates from polynomials of rising degree: where the lift
    itself bends between rows, the higher ones see less of it.
    """
    n = len(turn.lift)
    moving = [
        k
        for k in range(n)
        if turn.line[k] and any(turn.lift[(k + j) % n] != turn.lift[k] for j in (-1, 1))
    ]
    estimates = []
    for reach in (2, 3, 4):
        found = []
        for k in moving[:: 1 + len(moving) // SAMPLE]:
            d, weights = turn.deviation(k, reach)
            square = 1.0
            for weight in weights:
                square += weight * weight
            found.append(abs(d) / sqrt(square))
        estimates.append(median_low(found) / NORMAL if found else 0.0)
    return max(turn.rounding, min(estimates))


# -- B-splines of degree 7 on equal knots ------------------------------------------------------
# Angles are in knot spacings, u = theta K/(2 pi). Interval i holds u in [i, i + 1] and depends on
# the coefficients i, ..., i + 7 (modulo K).


@cache
def _weights() -> tuple[tuple[Fraction, ...], ...]:
    """Power coefficients in t = u - i of the weight of coefficient i + k, k = 0 ... 7."""
    pieces = [[Fraction(1)]]  # of degree 0; piece r of a basis function holds [r, r + 1]
    for p in range(1, WIDTH):
        raised = [[Fraction(0)] * (p + 1) for _ in range(p + 1)]
        for r, old in enumerate(pieces):
            for j, value in enumerate(old):
                raised[r][j] += value * r / p
                raised[r][j + 1] += value / p
                raised[r + 1][j] += value * (p - r) / p
                raised[r + 1][j + 1] -= value / p
        pieces = raised
    return tuple(tuple(piece) for piece in reversed(pieces))


@cache
def _floats(order: int) -> tuple[tuple[float, ...], ...]:
    """`_weights` derived `order` times by u, in floats, highest power first."""
    rows = []
    for row in _weights():
        for _ in range(order):
            row = tuple(value * j for j, value in enumerate(row))[1:]
        rows.append(tuple(float(value) for value in reversed(row)))
    return tuple(rows)


def basis(t: float, order: int = 0) -> list[float]:
    """Weights of the eight coefficients at t in [0, 1] of an interval, or of a derivative by u."""
    result = []
    for row in _floats(order):
        value = 0.0
        for factor in row:
            value = value * t + factor
        result.append(value)
    return result


def at(coefficients: Sequence[float], i: int, row: Sequence[float]) -> float:
    """The spline (or a derivative) in interval i with the weights `row`."""
    count = len(coefficients)
    value = 0.0
    for k in range(WIDTH):
        value += row[k] * coefficients[(i + k) % count]
    return value


def piece(coefficients: Sequence[float], i: int, base: float = 0.0) -> Piece:
    """Interval i, plus a base, as a piece of the kernel's table, rounded once from 40 digits."""
    count = len(coefficients)
    scale = max(value.denominator for row in _weights() for value in row)  # 7!
    with localcontext() as context:
        context.prec = DIGITS
        width = 2 * pi() / count
        low, high = float(width * i), float(width * (i + 1))
        center = (low + high) / 2
        powers = [Decimal(0)] * WIDTH
        for k, row in enumerate(_weights()):
            value = Decimal(coefficients[(i + k) % count])
            for j, factor in enumerate(row):
                powers[j] += value * int(factor * scale)
        powers[0] += Decimal(base) * scale
        t = Decimal(center) / width - i  # about a half: the centre in doubles
        for k in range(DEGREE):  # synthetic division: powers of t - center
            for j in range(DEGREE - 1, k - 1, -1):
                powers[j] += t * powers[j + 1]
        values = [float(value / scale / width**j) for j, value in enumerate(powers)]
    return Piece(center, (high - low) / 2, tuple(values + [0.0] * (TERMS - WIDTH)))


class Factors:
    """LDL' of a symmetric positive definite band matrix; `rows[i][k]` is its (i, i - k)."""

    def __init__(self, rows: Sequence[Sequence[float]]):
        self.band = len(rows[0]) - 1
        self.lower: list[list[float]] = []
        self.pivots: list[float] = []
        for i, row in enumerate(rows):
            self._eliminate(i, list(row))

    def _eliminate(self, i: int, row: list[float]) -> None:
        """Turn row i into factors: lower[i][k] = L(i, i - k) and the pivot."""
        reach = min(i, self.band)
        scaled = [0.0] * (self.band + 1)  # L(i, j) D(j)
        for k in range(reach, 0, -1):
            value, above = row[k], self.lower[i - k]
            for m in range(1, reach - k + 1):
                value -= scaled[k + m] * above[m]
            scaled[k] = value
        pivot = row[0]
        for k in range(1, reach + 1):
            row[k] = scaled[k] / self.pivots[i - k]
            pivot -= scaled[k] * row[k]
        self.lower.append(row)
        self.pivots.append(pivot)

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


# -- the fit -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fit:
    """Coefficients of one weight and what solves for others."""

    weight: float
    coefficients: list[float]
    factors: Factors


class Smoother:
    """Normal equations of one table; `count` knots a turn, u = theta count/360 deg.

    `moving` are the intervals that are not held flat.
    """

    def __init__(self, turn: Turn):
        self.turn = turn
        self.count = n = max(LEAST_KNOTS, min(MOST_KNOTS, int(360.0 / turn.spacing + 0.5)))
        self.levels = self._levels()
        held = self.levels
        self.moving = [i for i in range(n) if any((i + k) % n not in held for k in range(WIDTH))]
        # unknowns in an order with a narrow band: behind a dwell, or folded round the turn
        if held:
            start = next(j for j in held if (j + 1) % n not in held)
            order = [(start + k) % n for k in range(n)]
        else:
            order = [k // 2 if k % 2 == 0 else n - 1 - k // 2 for k in range(n)]
        self.order = [j for j in order if j not in held]
        self.position = {j: k for k, j in enumerate(self.order)}
        self.band = DEGREE if held else 2 * DEGREE
        self.squares = []  # interval and weights of every row
        self.normal, self.right = self._empty()
        for theta, lift in zip(turn.theta, turn.lift, strict=True):
            u = theta * n / 360.0
            i = min(int(u), n - 1)
            weights = basis(u - i)
            self.squares.append((i, weights))
            self._add(self.normal, self.right, i, weights, lift)
        self.penalty, self.penalty_right = self._empty()
        for i in range(n):
            self._add(self.penalty, self.penalty_right, i, PENALTY, 0.0)
        self.rows_per_knot = len(turn.lift) / n
        self.fits: dict[int, Fit] = {}

    def _levels(self) -> dict[int, float]:
        """Coefficients held at the level of a dwell."""
        held: dict[int, float] = {}
        scale = self.count / 360.0
        for dwell in self.turn.dwells:
            low, high = dwell.start * scale + MARGIN, dwell.end * scale - MARGIN
            j = int(low + CENTER) + 1
            run = []
            while j - CENTER <= high:
                run.append(j % self.count)
                j += 1
            if len(run) >= WIDTH:
                held.update(dict.fromkeys(run, dwell.level))
        return held

    def _empty(self) -> tuple[list[list[float]], list[float]]:
        return [[0.0] * (self.band + 1) for _ in self.order], [0.0] * len(self.order)

    def _add(self, rows, right, i: int, factors: Sequence[float], value: float) -> None:
        """Add the normal equations of the equation sum over k of factors[k] x[i + k] = value."""
        indices = [(i + k) % self.count for k in range(len(factors))]
        for a, j in enumerate(indices):
            p = self.position.get(j)
            if p is None:
                continue
            right[p] += factors[a] * value
            for b, other in enumerate(indices):
                q = self.position.get(other)
                if q is None:
                    right[p] -= factors[a] * factors[b] * self.levels[other]
                elif q <= p:
                    rows[p][p - q] += factors[a] * factors[b]

    def fit(self, power: int) -> Fit:
        """The fit of the weight STEP^power."""
        if power not in self.fits:
            weight = self.rows_per_knot
            for _ in range(abs(power)):
                weight = weight * STEP if power > 0 else weight / STEP
            self.fits[power] = self.fit_of(weight)
        return self.fits[power]

    def fit_of(self, weight: float) -> Fit:
        """The fit of any weight."""
        factors = Factors(
            [
                [a + weight * b for a, b in zip(row, other, strict=True)]
                for row, other in zip(self.normal, self.penalty, strict=True)
            ]
        )
        right = [a + weight * b for a, b in zip(self.right, self.penalty_right, strict=True)]
        solved = self._whole(factors.solve(right))
        for j, level in self.levels.items():
            solved[j] = level
        return Fit(weight, solved, factors)

    def _whole(self, unknowns: list[float]) -> list[float]:
        """Coefficients from the unknowns in their order; zero where held."""
        whole = [0.0] * self.count
        for j, value in zip(self.order, unknowns, strict=True):
            whole[j] = value
        return whole

    def balanced(self, sigma: float) -> Fit:
        """The fit whose weight balances bending and rounding (see the module)."""
        best = LOWEST
        for power in range(LOWEST, HIGHEST):
            error = sigma * self.error(self.fit(power))
            change = max(self.changes(self.fit(power), self.fit(power + OCTAVE)))
            if change <= BALANCE * error:
                best = power
            elif change > GIVE_UP * error:
                break
        return self.fit(best)

    def with_rms(self, wanted: float) -> Fit:
        """The fit whose root mean square deviation is `wanted`, or the nearest there is."""
        low, high = self.fit(LOWEST), self.fit(HIGHEST + OCTAVE)
        if self.rms(low) >= wanted:
            return low
        if self.rms(high) <= wanted:
            return high
        for _ in range(HALVINGS):
            middle = self.fit_of(sqrt(low.weight) * sqrt(high.weight))
            if self.rms(middle) < wanted:
                low = middle
            else:
                high = middle
        return low

    def residuals(self, fit: Fit) -> list[float]:
        """Spline minus table, m, at every row."""
        return [
            at(fit.coefficients, i, weights) - lift
            for (i, weights), lift in zip(self.squares, self.turn.lift, strict=True)
        ]

    def rms(self, fit: Fit) -> float:
        """Root mean square deviation from the rows that move, m."""
        total, count = 0.0, 0
        rows = zip(self.residuals(fit), self.turn.lift, self.turn.line, strict=True)
        for deviation, lift, line in rows:
            if line and lift != 0.0:
                total += deviation * deviation
                count += 1
        return sqrt(total / max(1, count))

    def accels(self, fit: Fit) -> list[float]:
        """c_thetatheta per knot spacing squared, at the knot and the middle of moving intervals."""
        knot, middle = basis(0.0, 2), basis(0.5, 2)
        values = []
        for i in self.moving:
            values += [at(fit.coefficients, i, knot), at(fit.coefficients, i, middle)]
        return values

    def changes(self, fit: Fit, other: Fit) -> list[float]:
        """|change| of `accels` from one fit to another."""
        pairs = zip(self.accels(fit), self.accels(other), strict=True)
        return [abs(b - a) for a, b in pairs]

    def _response(self, fit: Fit, i: int, row: list[float]) -> list[float]:
        """How a derivative in interval i answers to the right-hand side, by unknown."""
        right = [0.0] * len(self.order)
        for k in range(WIDTH):
            p = self.position.get((i + k) % self.count)
            if p is not None:
                right[p] = row[k]
        return fit.factors.solve(right)

    def spread(self, fit: Fit, i: int, row: list[float]) -> float:
        """Standard error of a derivative in interval i per standard deviation of the rows."""
        z = self._response(fit, i, row)
        total = 0.0
        for p, line in enumerate(self.normal):
            total += line[0] * z[p] * z[p]
            for k in range(1, min(p, self.band) + 1):
                total += 2.0 * line[k] * z[p] * z[p - k]
        return sqrt(max(0.0, total))

    def error(self, fit: Fit) -> float:
        """Largest standard error of c_thetatheta per standard deviation, at some phases."""
        stride = max(1, len(self.moving) // PLACES)
        rows = basis(0.0, 2), basis(0.5, 2)
        places = enumerate(self.moving[stride // 2 :: stride])
        return max([0.0, *(self.spread(fit, i, rows[k % 2]) for k, i in places)])

    def worst(self, fit: Fit, i: int, row: list[float]) -> float:
        """Largest change of a derivative when no row changes by more than one."""
        whole = self._whole(self._response(fit, i, row))
        total = 0.0
        for (j, weights), line in zip(self.squares, self.turn.line, strict=True):
            total += abs(at(whole, j, weights)) if line else 0.0
        return total


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
        knot = 360.0 / smoother.count / DEG
        self.per_square = 1.0 / (knot * knot)

    @cached_property
    def _smoother_fits(self) -> tuple[Fit, Fit]:
        """Fits with twice and four times the smoothing length."""
        weight, fits = self.fit.weight, []
        for _ in range(2):
            for _ in range(OCTAVE):
                weight *= STEP
            fits.append(self.smoother.fit_of(weight))
        return fits[0], fits[1]

    @cached_property
    def changes(self) -> list[float]:
        """|change| of c_thetatheta at `Smoother.accels` when the length doubles, m/rad2."""
        changes = self.smoother.changes(self.fit, self._smoother_fits[0])
        return [change * self.per_square for change in changes]

    @cached_property
    def ratio(self) -> float:
        """How the bending grows when the length doubles."""
        twice, four = self._smoother_fits
        first = max(self.smoother.changes(self.fit, twice))
        return max(self.smoother.changes(twice, four)) / first if first > 0.0 else MOST_RATIO

    @property
    def _factor(self) -> float:
        return SAFETY / (min(max(self.ratio, LEAST_RATIO), MOST_RATIO) - 1.0)

    @property
    def length(self) -> float:
        """Smoothing length in knot spacings: the eighth root of the weight per row."""
        length = self.fit.weight / self.smoother.rows_per_knot
        for _ in range(3):
            length = sqrt(length)
        return max(1.0, length)

    def near(self, theta_deg: float) -> float:
        """Bound on the error of c_thetatheta about a phase, m/rad2; 0 in the middle of a dwell."""
        s, count = self.smoother, self.smoother.count
        u = (theta_deg % 360.0) * count / 360.0
        i = min(int(u), count - 1)
        if i not in s.moving:
            return 0.0
        standard = self.noise * self.per_square * s.spread(self.fit, i, basis(u - i, 2))
        reach, bending = NEAR * self.length, 0.0
        for k, place in enumerate(s.moving):
            apart = abs((place + 0.5 - u + count / 2) % count - count / 2)
            if apart <= reach + 0.5:
                bending = max(bending, self.changes[2 * k], self.changes[2 * k + 1])
        return ERRORS * standard + self._factor * bending

    @cached_property
    def bounds(self) -> list[float]:
        """`near` over SHARES equal shares of the turn: the larger value of its two ends."""
        ends = [self.near(360.0 * k / SHARES) for k in range(SHARES)]
        return [max(ends[k], ends[(k + 1) % SHARES]) for k in range(SHARES)]

    def accuracy(self) -> Accuracy:
        """Everything about the fit as a whole."""
        s, turn = self.smoother, self.smoother.turn
        rows = zip(s.residuals(self.fit), turn.line, strict=True)
        residuals = [abs(r) if line else 0.0 for r, line in rows]
        largest = max(residuals)
        accels = [abs(value) * self.per_square for value in s.accels(self.fit)]
        at = self.changes.index(max(self.changes))
        middle = s.moving[accels.index(max(accels)) // 2]
        worst = s.worst(self.fit, middle, basis(0.5, 2))
        standard = self.noise * self.per_square * s.error(self.fit)
        jump = max(self.changes) > ERRORS * standard and self.ratio < JUMP
        return Accuracy(
            rows=len([line for line in turn.line if line]),
            knots=s.count,
            lift=max(turn.lift) - min(turn.lift),
            quantum=turn.quantum,
            noise=self.noise,
            rms=s.rms(self.fit),
            largest=largest,
            line=turn.line[residuals.index(largest)],
            length_deg=self.length * 360.0 / s.count,
            accel=max(accels),
            standard=standard,
            worst=0.5 * turn.quantum * self.per_square * worst,
            bending=self._factor * max(self.changes),
            jump_deg=(s.moving[at // 2] + 0.5 * (at % 2)) * 360.0 / s.count if jump else None,
        )
