"""What the rows of a lift table say of themselves: their digits, their scatter, where they rest."""

from decimal import Decimal
from math import gcd, pi, prod, sqrt

import numpy as np
import pytest

from camcli.cams.lift_reading import (
    Cell,
    Turn,
    _base_circle,
    _dwells,
    _phase,
    _quantum,
)


@pytest.mark.parametrize("reach", [1, 2, 3, 4])
def test_a_row_is_off_the_polynomial_through_its_neighbours_by_its_divided_difference(reach):
    """Of x^(2 r) that is the product of the distances; of lower powers it is nothing.

    Of x^(2 r + 1) it is that product times the sum of all places. Round the turn it is the same.
    """
    rng = np.random.default_rng(reach)
    theta = np.sort(rng.uniform(0.0, 360.0, 24))
    for begin in (0, 9):
        angles = np.sort((theta + 40.0 * (begin > 0)) % 360.0)
        for k in (0, 5, 23):
            x = (angles - angles[k] + 180.0) % 360.0 - 180.0
            beside = [(k + step) % 24 for step in range(-reach, reach + 1) if step]
            distances = prod(-x[j] for j in beside)
            total = sum(x[j] for j in beside)
            wanted = {2 * reach: distances, 2 * reach + 1: distances * total, 1: 0.0,
                      2 * reach - 1: 0.0, 0: 0.0}  # fmt: skip
            for power, off in wanted.items():
                turn = Turn(angles, x**power, np.arange(24), 1.0, 15.0, [])
                found, weights = turn.deviations(reach)
                size = np.abs(x[beside]).max() ** max(power, 1)
                assert found[k] == pytest.approx(off, abs=1e-11 * size * abs(weights[:, k]).sum())
                assert weights[:, k].sum() == pytest.approx(1.0)
                near = [weights[j, k] * x[i] for j, i in enumerate(beside)]
                assert sum(near) == pytest.approx(0.0, abs=1e-11 * max(map(abs, near)))


def cells(*texts):
    return [Cell("", 1, text, Decimal(text)) for text in texts]


@pytest.mark.parametrize(
    ("texts", "zero", "digit", "steps"),
    [
        (("0.002", "0.01", "1"), "0", "0.002", [2, 10, 1000]),
        (("0.003", "0.01", "1"), "0", "0.001", [3, 10, 1000]),
        (("10.5", "12", "13.5"), "10.5", "1.5", [0, 15, 30]),
        (("10.5", "12", "13.5"), "10.5001", "1.5", [0, 15, 30]),  # rounded to the last place
        (("100", "200", "50"), "0", "50", [100, 200, 50]),
        (("0", "0.0"), "0", "0.1", [0, 0]),
        (("1.25e-1", "3.2e-2", "0"), "0", None, [125, 32, 0]),
    ],
)
def test_the_last_digit_is_the_greatest_common_divisor_of_the_lifts(texts, zero, digit, steps):
    """Numbers with powers of ten have three digits each here: their steps are 0.001 and 0.0001."""
    found, whole = _quantum(cells(*texts), Decimal(zero))
    if digit is None:
        assert float(found) == pytest.approx(sqrt((1e-3**2 + 1e-4**2) / 2.0))
        assert [Decimal(step).scaleb(-3) for step in whole] == [Decimal(text) for text in texts]
    else:
        assert found == Decimal(digit)
        assert whole == steps


@pytest.mark.parametrize(("rows", "taken"), [(40, 10), (79, 19), (80, 20), (84, 20), (400, 20)])
@pytest.mark.parametrize("top", [10_000, 100_000])
def test_an_end_is_on_the_base_circle_up_to_five_deviations_of_second_differences(rows, taken, top):
    """Of a quarter of the rows, 20 at most, but the first; and up to 0.005 of the largest lift.

    A ramp does not matter. White noise has second differences of the variance 1 + 4 + 1.
    """
    rng = np.random.default_rng(rows)
    noise = rng.normal(0.0, 30.0, rows)
    steps = [round(x + 7.0 * k) for k, x in enumerate(noise)]
    steps[0] += 1000
    steps[taken:] = [step + 500 * (-1) ** k for k, step in enumerate(steps[taken:])]
    steps[-1] = -top
    bends = np.diff(np.array(steps[1:taken], float), 2)
    scatter = sqrt((bends**2).mean() / 6.0)
    assert 50.0 < 5.0 * scatter < 450.0
    found = _base_circle(steps)
    assert found == pytest.approx(min(5.0 * scatter, 0.005 * top))
    for ramp in (range(0, 3 * rows, 3), range(0, -3 * rows, -3)):
        assert _base_circle(list(ramp)) == gcd(*ramp) == 3  # a flank
    level = [6 * (k % 2) for k in range(rows)]
    assert _base_circle(level) == 6  # no more than 0.005 of the largest, but a last digit


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_rows_of_one_lift_are_a_dwell_where_a_nose_would_be_flat_for_less_than_half_as_long(share):
    """A parabola with the curvature 2 lift/(half of what moves)^2 is flat for 2 sqrt(digit/it)."""
    rows, flat = 360, 30
    theta = [float(k) for k in range(rows)]
    steps = [abs(k - 180) for k in range(rows)]
    first = 180 - flat // 2
    steps[first : first + flat + 1] = [0] * (flat + 1)
    moving, lift, curved = (360.0 - flat) * pi / 180.0, 180.0, 0.0
    curved = 2.0 * lift / (moving / 2.0) ** 2
    digit = curved * (flat * pi / 180.0 / 4.0) ** 2 * share
    found = _dwells("t", theta, [float(step) for step in steps], steps, digit)
    assert [(dwell.start, dwell.end, dwell.level) for dwell in found] == (
        [(165.0, 195.0, 0.0)] if share < 1.0 else []
    )


@pytest.mark.parametrize(
    ("angle", "phase"),
    [("0", 0.0), ("360", 0.0), ("-0.5", 359.5), ("725.25", 5.25), ("-720", 0.0), ("-1e-30", 0.0)],
)
def test_a_phase_is_from_zero_and_below_a_turn(angle, phase):
    assert _phase(Decimal(angle)) == phase
