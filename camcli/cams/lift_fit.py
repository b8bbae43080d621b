"""The smoothing spline of a measured lift: least squares with a penalty on roughness.

    minimise  sum (c(theta_k) - lift_k)^2 + weight * sum (fourth differences of coefficients)^2

over periodic splines of degree 7 on equal knots. Coefficients in the middle of a dwell are held at
its level, so the dwell is exactly flat there. The weight that fits the rounding is the largest at
which doubling the smoothing length still changes c_thetatheta by no more than BALANCE standard
errors: more smoothing would bend the cam, less would let the rounding through.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

from camcli.cams.banded import Banded
from camcli.cams.bspline import CENTER, DEGREE, WIDTH, at, basis
from camcli.cams.lift_data import Turn

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


@dataclass(frozen=True)
class Fit:
    """Coefficients of one weight and what solves for others."""

    weight: float
    coefficients: list[float]
    factors: Banded


class Smoother:
    """Normal equations of one table; `count` knots a turn, u = theta count/360 deg."""

    def __init__(self, turn: Turn):
        self.turn = turn
        self.count = max(LEAST_KNOTS, min(MOST_KNOTS, int(360.0 / turn.spacing + 0.5)))
        self.levels = self._levels()
        self._number()
        self.normal, self.right, self.squares = self._normal()
        self.penalty, self.penalty_right = self._penalty()
        self.rows_per_knot = len(turn.lift) / self.count
        self.fits: dict[int, Fit] = {}

    def _levels(self) -> dict[int, float]:
        """Coefficients held at the level of a dwell."""
        held = {}
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

    def _number(self) -> None:
        """Unknowns in an order with a narrow band: behind a dwell, or folded round the turn."""
        n = self.count
        if self.levels:
            start = next(j for j in self.levels if (j + 1) % n not in self.levels)
            order = [(start + k) % n for k in range(n)]
        else:
            order = [k // 2 if k % 2 == 0 else n - 1 - k // 2 for k in range(n)]
        order = [j for j in order if j not in self.levels]
        self.order = order
        self.position = {j: k for k, j in enumerate(order)}
        self.band = DEGREE if self.levels else 2 * DEGREE

    def _empty(self) -> list[list[float]]:
        return [[0.0] * (self.band + 1) for _ in self.order]

    def _add(self, rows, right, indices, factors, value: float) -> None:
        """Add the normal equations of one equation sum factors x = value."""
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

    def _normal(self):
        """(matrix, right-hand side, intervals and weights of every row)."""
        rows, right, squares = self._empty(), [0.0] * len(self.order), []
        n = self.count
        for theta, lift in zip(self.turn.theta, self.turn.lift, strict=True):
            u = theta * n / 360.0
            i = min(int(u), n - 1)
            weights = basis(u - i)
            squares.append((i, weights))
            self._add(rows, right, [(i + k) % n for k in range(WIDTH)], weights, lift)
        return rows, right, squares

    def _penalty(self):
        rows, right = self._empty(), [0.0] * len(self.order)
        for i in range(self.count):
            indices = [(i + k) % self.count for k in range(len(PENALTY))]
            self._add(rows, right, indices, PENALTY, 0.0)
        return rows, right

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
        matrix = [
            [a + weight * b for a, b in zip(row, other, strict=True)]
            for row, other in zip(self.normal, self.penalty, strict=True)
        ]
        factors = Banded(matrix)
        right = [a + weight * b for a, b in zip(self.right, self.penalty_right, strict=True)]
        solved = factors.solve(right)
        coefficients = [0.0] * self.count
        for j, level in self.levels.items():
            coefficients[j] = level
        for j, value in zip(self.order, solved, strict=True):
            coefficients[j] = value
        return Fit(weight, coefficients, factors)

    def residuals(self, fit: Fit) -> list[float]:
        """Spline minus table, m, at every row."""
        return [
            at(fit.coefficients, i, weights) - lift
            for (i, weights), lift in zip(self.squares, self.turn.lift, strict=True)
        ]

    def rms(self, fit: Fit) -> float:
        """Root mean square deviation from the rows that move, m."""
        total, count = 0.0, 0
        for deviation, lift, line in zip(
            self.residuals(fit), self.turn.lift, self.turn.line, strict=True
        ):
            if line and lift != 0.0:
                total += deviation * deviation
                count += 1
        return sqrt(total / max(1, count))

    def spread(self, fit: Fit, i: int, row: list[float]) -> float:
        """Standard error of a derivative in interval i per standard deviation of the rows."""
        z = fit.factors.solve(self._functional(i, row))
        total = 0.0
        for p, line in enumerate(self.normal):
            total += line[0] * z[p] * z[p]
            for k in range(1, min(p, self.band) + 1):
                total += 2.0 * line[k] * z[p] * z[p - k]
        return sqrt(max(0.0, total))

    def worst(self, fit: Fit, i: int, row: list[float]) -> float:
        """Largest change of a derivative when no row changes by more than one."""
        z = fit.factors.solve(self._functional(i, row))
        whole = [0.0] * self.count
        for j, value in zip(self.order, z, strict=True):
            whole[j] = value
        total = 0.0
        for (i, weights), line in zip(self.squares, self.turn.line, strict=True):
            total += abs(at(whole, i, weights)) if line else 0.0
        return total

    def _functional(self, i: int, row: list[float]) -> list[float]:
        right = [0.0] * len(self.order)
        for k in range(WIDTH):
            p = self.position.get((i + k) % self.count)
            if p is not None:
                right[p] = row[k]
        return right

    def moving(self) -> list[int]:
        """Intervals that are not held flat."""
        n, held = self.count, self.levels
        return [i for i in range(n) if any((i + k) % n not in held for k in range(WIDTH))]

    def accels(self, fit: Fit) -> list[float]:
        """c_thetatheta per knot spacing squared, at the knot and the middle of moving intervals."""
        knot, middle = basis(0.0, 2), basis(0.5, 2)
        values = []
        for i in self.moving():
            values += [at(fit.coefficients, i, knot), at(fit.coefficients, i, middle)]
        return values

    def error(self, fit: Fit) -> float:
        """Largest standard error of c_thetatheta per standard deviation, at some phases."""
        places = self.moving()
        stride = max(1, len(places) // PLACES)
        rows = basis(0.0, 2), basis(0.5, 2)
        largest = 0.0
        for k, i in enumerate(places[stride // 2 :: stride]):
            largest = max(largest, self.spread(fit, i, rows[k % 2]))
        return largest

    def change(self, fit: Fit, smoother: Fit) -> float:
        """The largest change of `accels` from one fit to another."""
        pairs = zip(self.accels(fit), self.accels(smoother), strict=True)
        return max(abs(b - a) for a, b in pairs)

    def balanced(self, sigma: float) -> Fit:
        """The fit whose weight balances bending and rounding (see the module)."""
        best = LOWEST
        for power in range(LOWEST, HIGHEST):
            error = sigma * self.error(self.fit(power))
            change = self.change(self.fit(power), self.fit(power + OCTAVE))
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
