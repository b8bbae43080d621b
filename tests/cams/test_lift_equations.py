"""The equations of a fit: band matrices factored and solved, for one right-hand side and many."""

from fractions import Fraction
from random import Random

import numpy as np
import pytest

from camcli.cams.lift_fit import Factors
from tests.support.lift_tables import Lobe, scene, smooth, table


def band_matrix(size, band, seed):
    """Rows of a symmetric positive definite band matrix: [i][k] is A(i, i - k)."""
    rng = Random(seed)
    return [[4.0 * band, *(rng.uniform(-1, 1) for _ in range(band))] for _ in range(size)]


@pytest.mark.parametrize(("size", "band"), [(1, 7), (5, 7), (40, 7), (60, 14)])
def test_the_solutions_fulfil_the_equations_and_have_the_same_bits_one_by_one(size, band):
    """A x = b in fractions, of right-hand sides with few entries, as those of a response are."""
    rows = band_matrix(size, band, seed=size)
    factors = Factors(rows)
    rng = Random(band)
    right = np.array([
        [rng.uniform(-1, 1) if rng.random() < 0.3 else 0.0 for _ in range(4)] for _ in range(size)
    ])  # fmt: skip
    together = factors.solve_all(right)
    for column, solution in zip(right.T, together.T, strict=True):
        assert factors.solve(column.tolist()).tolist() == solution.tolist()
        x = [Fraction(value) for value in solution]
        for i in range(size):
            below = [(k, rows[i][k]) for k in range(1, min(i, band) + 1)]
            above = [(k, rows[i + k][k]) for k in range(1, min(size - 1 - i, band) + 1)]
            value = Fraction(rows[i][0]) * x[i]
            value += sum(Fraction(entry) * x[i - k] for k, entry in below)
            value += sum(Fraction(entry) * x[i + k] for k, entry in above)
            assert abs(float(value - Fraction(column[i]))) < 1e-13 * size


def test_no_right_hand_side_has_no_solution():
    assert Factors(band_matrix(5, 2, seed=1)).solve_all(np.zeros((5, 0))).shape == (5, 0)


def test_a_table_is_fitted_once_and_another_one_by_itself(tmp_path):
    """The same file read again; other lifts of its rows, and other rows under its name."""
    text = table(Lobe(smooth), 2, 1e-3, 3)
    one, again = (scene(tmp_path, text).cam for _ in range(2))
    assert one.errors is again.errors
    assert one.accuracy is again.accuracy
    larger = one.with_lifts(one.measured.lift * 2.0)
    assert larger.errors is not one.errors
    assert larger.accuracy.accel == pytest.approx(2.0 * one.accuracy.accel, rel=0.01)
    other = scene(tmp_path, text.replace("5\n", "6\n")).cam  # the same name, other rows
    assert other.errors is not one.errors
