"""How far the second derivative of a fitted lift may be trusted.

Its error has two parts. Rounding passes through the linear smoother: a standard error, and a worst
case in which every row is wrong by half a digit in the worst direction. Smoothing bends: how much,
shows in what twice the smoothing length changes. Where the cam's c_thetatheta has corners the
bending falls by half with half the length; where it jumps, it does not, and its bound is wider.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

from camcli.cams.bspline import basis
from camcli.cams.lift_fit import OCTAVE, STEP, Fit, Smoother

ERRORS = 4.0  # standard errors in the bound
SAFETY = 1.25  # of the estimate of the bending
LEAST_RATIO, MOST_RATIO = 1.33, 3.0  # of the bending when the length doubles
JUMP = 1.5  # a smaller ratio speaks of a jump
NEAR = 2.0  # smoothing lengths around a phase in which bending counts there
SHARES = 90
RADIAN = 57.29577951308232


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
        knot = 360.0 / smoother.count / RADIAN
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
        pairs = zip(
            self.smoother.accels(self.fit),
            self.smoother.accels(self._smoother_fits[0]),
            strict=True,
        )
        return [abs(b - a) * self.per_square for a, b in pairs]

    @cached_property
    def ratio(self) -> float:
        """How the bending grows when the length doubles."""
        twice, four = self._smoother_fits
        first = self.smoother.change(self.fit, twice)
        return self.smoother.change(twice, four) / first if first > 0.0 else MOST_RATIO

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
        places = s.moving()
        if i not in places:
            return 0.0
        standard = self.noise * self.per_square * s.spread(self.fit, i, basis(u - i, 2))
        reach, bending = NEAR * self.length, 0.0
        for k, place in enumerate(places):
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
        residuals = [abs(r) if line else 0.0 for r, line in
                     zip(s.residuals(self.fit), turn.line, strict=True)]  # fmt: skip
        largest = max(residuals)
        accels = [abs(value) * self.per_square for value in s.accels(self.fit)]
        at = self.changes.index(max(self.changes))
        places = s.moving()
        middle = places[accels.index(max(accels)) // 2]
        worst = s.worst(self.fit, middle, basis(0.5, 2))
        significant = max(self.changes) > ERRORS * self.noise * self.per_square * s.error(self.fit)
        jump = significant and self.ratio < JUMP
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
            standard=self.noise * self.per_square * s.error(self.fit),
            worst=0.5 * turn.quantum * self.per_square * worst,
            bending=self._factor * max(self.changes),
            jump_deg=(places[at // 2] + 0.5 * (at % 2)) * 360.0 / s.count if jump else None,
        )
