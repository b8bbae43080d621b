"""The statistics of a jump: those of dense least squares, and those of many tables with one noise.

Rows of a polynomial, a jump of its first or second derivative and normal noise; the oracle fits
their four descriptions (`camcli.cams.lift_jump`) by `numpy.linalg.lstsq`, and searches the phases
on a grid of its own.
"""

from __future__ import annotations

from functools import partial
from math import factorial, inf, log, radians, sqrt

import numpy as np
import pytest
from scipy.optimize import minimize, minimize_scalar

from camcli.cams.lift_jump import RowsAbout, find_jump
from camcli.cams.lift_reading import Turn

PLACE = 358.0  # deg: windows go through the end of the turn
UM = 1e-6


def turn_of(
    jump: float, order: int, at: float, noise: float, seed: int, quantum=0.01 * UM, bump=0.0
) -> Turn:
    """Rows about a degree apart whose derivative of an order jumps at `at` deg past PLACE.

    jump: m and rad. Beside it the lift is a polynomial of degree 5 on either side; bump: m/rad, by
    how much its slope jumps 19 deg from PLACE.
    """
    rng = np.random.default_rng(seed)
    theta = (np.arange(360.0) + rng.uniform(-0.2, 0.2, 360)) % 360.0
    theta.sort()
    x = np.radians((theta - PLACE + 180.0) % 360.0 - 180.0)
    lift = 2e-3 + 1e-3 * x - 4e-3 * x**2 + 3e-3 * x**3 - 2e-3 * x**4 + 5e-3 * x**5
    past = np.maximum(x - radians(at), 0.0)
    lift += jump / factorial(order) * past**order * (1.0 - 4.0 * past + 8.0 * past**2)
    lift += bump * np.maximum(abs(x) - radians(19.0), 0.0)
    lift += rng.normal(0.0, noise, 360)
    return Turn(theta, lift, np.arange(360) + 2, quantum, 1.0, [])


class Dense:
    """The rows within `half` deg of PLACE, of which one counts `shares`."""

    def __init__(self, turn: Turn, shares: np.ndarray, half: float):
        off = (turn.theta - PLACE + 180.0) % 360.0 - 180.0
        rows = abs(off) <= half
        self.half, self.x, self.lift = half, off[rows], turn.lift[rows] - turn.lift[rows].mean()
        self.root = np.sqrt(shares[rows])
        self.freedom = shares[rows].sum() - 10  # a polynomial of 6 coefficients, 3 more, a phase

    def columns(self, *powers: tuple[float, int]) -> np.ndarray:
        """Those of the polynomial, in rad, and of x+^n from each phase (deg)."""
        x = np.radians(self.x)
        plus = [np.maximum(x - radians(p), 0.0) ** n for p, n in powers]
        return self.root[:, None] * np.stack([*(x**n for n in range(6)), *plus], axis=-1)

    def left(self, *powers: tuple[float, int]) -> float:
        """The weighted sum of squares that the best combination leaves."""
        columns = self.columns(*powers)
        columns = columns / np.sqrt((columns**2).sum(axis=0)).clip(1e-300)
        right = self.root * self.lift
        return float(((columns @ np.linalg.lstsq(columns, right, 1e-11)[0] - right) ** 2).sum())

    def jump(self, order: int, p: float) -> float:
        return self.left(*((p, order + n) for n in range(3)))

    def best_jump(self, order: int, reach: float, step: float) -> tuple[float, float]:
        """(sum of squares, phase): the best of a grid, and between its neighbours."""
        f = partial(self.jump, order)
        best = min(np.arange(-reach, reach + step / 2, step), key=f)
        ends = (best - step, best + step)
        found = minimize_scalar(f, bounds=ends, method="bounded", options={"xatol": 1e-4})
        return float(found.fun), float(found.x)

    def best_change(self) -> float:
        """c_thetatheta that turns at p and at p + R, R from 4 to 4 * 1.3^5 deg at first."""

        def f(at: np.ndarray) -> float:
            p, length = at[0], max(at[1], 4.0)
            return self.left((p, 3), (p + length, 3), (p, 4))

        starts = [
            (p, length)
            for p in np.arange(-0.9 * self.half, 0.7 * self.half, 0.5)
            for length in 4.0 * 1.3 ** np.arange(6)
        ]
        return float(minimize(f, min(starts, key=f), method="Nelder-Mead").fun)


def size_and_its_error(dense: Dense, order: int, at: float) -> tuple[float, float]:
    """(coefficient of x+^order, its standard error for rows with one of 1), by a fitted phase.

    The error is an entry of the inverse of J^T J, J being the derivatives of what is fitted by its
    coefficients and, as a difference, by the phase.
    """
    powers, step = range(order, order + 3), 1e-3
    columns = dense.columns(*((at, n) for n in powers))
    scale = np.sqrt((columns**2).sum(axis=0))
    fit = np.linalg.lstsq(columns / scale, dense.root * dense.lift, 1e-14)[0] / scale
    late, early = (dense.columns(*((at + d, n) for n in powers)) @ fit for d in (step, -step))
    jacobian = np.column_stack((columns, (late - early) / (2.0 * radians(step))))
    scale = np.sqrt((jacobian**2).sum(axis=0))
    inverse = np.linalg.inv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    return float(fit[6]), sqrt(inverse[6, 6])


def told_by_dense_algebra(dense: Dense, quantum: float, changes: bool = True):
    """(phase, order, size, its standard error, evidence); changes: or corners alone."""
    reach = min(3.0, dense.half / 3.0)
    (left, at), order = min((dense.best_jump(n, reach, 0.5), n) for n in (1, 2))
    variance = max(left / dense.freedom, quantum**2 / 12.0)
    size, of_unit = size_and_its_error(dense, order, at)
    corner, _ = dense.best_jump(3, 0.7 * dense.half, 0.5)
    more = min(corner, dense.best_change() if changes else corner) - left
    evidence = dense.freedom * log(1.0 + more / (dense.freedom * variance))
    per = factorial(order)
    return at, order, per * size, per * sqrt(variance) * of_unit, evidence


@pytest.mark.parametrize(
    ("jump", "order", "at", "noise", "quantum", "half"),
    [
        (0.05, 2, 1.3, 0.3 * UM, 0.01 * UM, 27.0),
        (-0.1, 2, -2.2, 0.1 * UM, 1.0 * UM, 27.0),  # rounding is more than they scatter
        (2e-3, 1, 2.7, 1.0 * UM, 0.01 * UM, 27.0),
        (0.1, 2, 0.4, 0.1 * UM, 0.01 * UM, 18.0),  # the widest window has more than noise
    ],
)
def test_a_jump_and_its_error_are_those_of_dense_least_squares(
    jump, order, at, noise, quantum, half
):
    bump = 0.0 if half == 27.0 else 2e-3
    turn = turn_of(jump, order, at, noise, 4, quantum, bump)
    shares = np.where(np.arange(360) % 3 == 0, 0.5, 1.0)
    found = find_jump(turn, shares, max(noise, quantum / sqrt(12.0)), [100.0, PLACE])
    phase, of, size, error, evidence = told_by_dense_algebra(Dense(turn, shares, half), quantum)
    assert of == found.order == order
    assert found.at == pytest.approx((PLACE + phase) % 360.0, abs=2e-3)
    assert found.size == pytest.approx(size, rel=1e-3)
    assert found.error == pytest.approx(error, rel=3e-3)
    assert found.evidence == pytest.approx(evidence, rel=2e-3)
    assert found.errors == sqrt(found.evidence)
    assert abs(found.size - jump) < 4.0 * found.error


def test_a_jump_has_to_describe_the_rows_better_than_a_corner(monkeypatch):
    """Changes are left out, of which one is mostly the best description without a jump."""
    monkeypatch.setattr(RowsAbout, "best_change", lambda window, step: inf)
    turn = turn_of(0.05, 2, 1.3, 0.3 * UM, 4)
    shares = np.ones(360)
    found = find_jump(turn, shares, 0.3 * UM, [PLACE])
    *_, evidence = told_by_dense_algebra(Dense(turn, shares, 27.0), turn.quantum, changes=False)
    assert found.evidence == pytest.approx(evidence, rel=2e-3)


def test_the_standard_error_of_a_jump_is_its_scatter_over_tables():
    """Of 120 tables with one jump and noise of 0.5 um; its phase is fitted as well.

    The deviation of 120 is known to 1/sqrt(240); with 45 degrees of freedom it is sqrt(45/43). An
    error that leaves the phase out is 1.17 times too small here.
    """
    jumps = [
        find_jump(turn_of(0.2, 2, 1.3, 0.5 * UM, seed), np.ones(360), 0.5 * UM, [PLACE])
        for seed in range(120)
    ]
    off = np.array([(jump.size - 0.2) / jump.error for jump in jumps])
    assert abs(off.mean()) < 3.0 / sqrt(120.0)
    assert off.std() == pytest.approx(sqrt(45.0 / 43.0), abs=3.0 / sqrt(240.0))


def test_no_jump_is_found_where_none_is_or_rows_are_wrong_beside_it():
    shares = np.ones(360)
    for seed in range(5):
        smooth = turn_of(0.0, 2, 1.3, 0.3 * UM, seed)
        assert find_jump(smooth, shares, 0.3 * UM, [PLACE]) is None
    jumps = turn_of(0.1, 2, 1.3, 0.3 * UM, 4)
    assert find_jump(jumps, shares, 0.3 * UM, []) is None
    assert find_jump(jumps, shares, 0.3 * UM, [PLACE]) is not None
    assert find_jump(jumps, shares, 0.15 * UM, [PLACE]) is None  # more is left than noise
    assert find_jump(jumps, shares / 6.0, 0.3 * UM, [PLACE]) is None  # no freedom


def test_of_two_jumps_the_more_evident_one_is_told():
    turn = turn_of(0.2, 2, 0.5, 0.3 * UM, 5)
    past = np.maximum(np.radians((turn.theta - PLACE + 180.0) % 360.0 - 180.0) - 1.05, 0.0)
    lift = turn.lift + 0.05 * past**2 * (1.0 - 4.0 * past + 8.0 * past**2)
    both = Turn(turn.theta, lift, turn.line, turn.quantum, 1.0, [])
    places, shares = [58.0, PLACE], np.ones(360)
    alone = [find_jump(both, shares, 0.3 * UM, [place]) for place in places]
    best = max(alone, key=lambda one: one.evidence)
    for order in (places, places[::-1]):
        assert find_jump(both, shares, 0.3 * UM, order) == best
    assert [one.size for one in alone] == pytest.approx([0.1, 0.2], abs=0.01)
