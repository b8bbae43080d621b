"""Every zero is found, however near another one; and what the multipliers of an orbit say.

The functions are polynomials with known zeros.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from flint import arb

from camcli.analysis.orbits.proofs import _certainly_stable
from camcli.analysis.orbits.single_impact import _Equation, _Terms
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.lash import _slopes_through_zero


class Known(_Equation):
    """The equation of single impacts, h being a polynomial with these zeros."""

    def __init__(self, zeros: list[float]):
        self.zeros = zeros
        self.slope = np.polynomial.Polynomial.fromroots(zeros).deriv() if zeros else None

    def h(self, i: int, theta: float) -> float:
        return float(np.prod([theta - zero for zero in self.zeros])) if self.zeros else 1.0

    def _terms(self, i: int, theta: float) -> _Terms:
        slope = 0.0 if self.slope is None else float(self.slope(theta))
        return _Terms(self.h(i, theta), slope, 1.0)

    def bend(self, low: float, high: float) -> float:
        """A bound of |h''| between two angles."""
        if len(self.zeros) < 2:
            return 0.0
        return 1.001 * float(np.abs(self.slope.deriv()(np.linspace(low, high, 2001))).max())


@pytest.mark.parametrize(
    "zeros",
    [
        [], [0.7], [0.0], [3.0], [-0.1, 3.1], [0.0, 3.0], [1.5], [0.75, 1.5],
        *([1.1, 1.1 + 10.0**-n, 2.5] for n in range(1, 6)),
        *([1.5 - 10.0**-n, 1.5, 1.5 + 10.0**-n] for n in range(1, 4)),
        [0.2, 0.5, 0.9, 1.4, 2.0, 2.7],
        [0.001, 0.002, 2.998, 2.999],
    ],
)  # fmt: skip
def test_every_orbit_of_one_impact_on_a_stretch_is_a_zero_that_is_found(zeros):
    """In ascending order; one at the end of the stretch is the next one's."""
    equation = Known(zeros)
    found = list(equation._within(0, 0.0, 3.0, equation.bend(0.0, 3.0)))
    wanted = [zero for zero in zeros if 0.0 <= zero < 3.0]
    assert found == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize(
    "zeros",
    [
        [], ["0.7"], ["1.5"], ["0.75", "1.5", "2.25"], ["-0.1", "3.1"],
        *(["1.1", str(1.1 + 10.0**-n), "2.5"] for n in range(1, 7)),
        ["0.2", "0.5", "0.9", "1.4", "2.0", "2.7"],
    ],
)  # fmt: skip
def test_a_seat_meets_the_cam_wherever_its_height_above_it_is_zero(zeros):
    """Each zero lies on a slope of its own, which may begin where the one before ends."""

    def height(theta):
        total = 1 + 0 * theta
        for zero in zeros:
            total = total * (theta - arb(zero))
        return total

    with precision(40):
        inside = [arb(zero) for zero in zeros if 0.0 < float(zero) < 3.0]
        slopes = _slopes_through_zero(height, arb(0), arb(3))
        # a slope on which the height is small need not have a zero
        holding = [[one for one in slopes if one.low <= zero <= one.high] for zero in inside]
        assert [len(found) for found in holding] == [1] * len(inside)
        for before, after in pairwise(slopes):
            assert before.high <= after.low
        known = np.polynomial.Polynomial.fromroots([float(zero) for zero in zeros or ["-1"]])
        assert slopes == [] or zeros
        for one in slopes:
            assert not one.rate.contains(0)
            for at in np.linspace(float(one.low), float(one.high), 7):
                assert one.rate.overlaps(arb(float(known.deriv()(at)), 1e-12))
        signs = [(-1) ** sum(other > zero for other in map(arb, zeros)) for zero in inside]
        for (found,), sign in zip(holding, signs, strict=True):
            assert found.rate * sign > 0
            assert sum(one is found for (one,) in holding) == 1


def test_a_height_that_only_touches_zero_is_not_decided():
    with precision(40), pytest.raises(UndecidedError):
        _slopes_through_zero(
            lambda theta: (theta - arb("1.3")) * (theta - arb("1.3")), arb(0), arb(3)
        )


@pytest.mark.parametrize("det", [0.0, 0.64, 0.999, 1.0, 1.001, 1.5, -0.2, -0.99, -1.5])
def test_an_orbit_is_stable_where_both_multipliers_are_inside_the_circle(det):
    """Of z^2 - trace z + det; on the circle, and in a ball that reaches it, nothing is said."""
    for trace in np.linspace(-3.0, 3.0, 61).round(2):
        sizes = np.abs(np.roots([1.0, -trace, det]))
        largest = sizes.max()
        told = _certainly_stable(arb(float(trace)), arb(det))
        if abs(largest - 1.0) < 1e-6:
            assert told is None or abs(abs(trace) - (1.0 + det)) < 1e-9
        else:
            assert told in ((largest < 1.0), None) if det < -1.0 else told is bool(largest < 1.0)
    assert _certainly_stable(arb(1.6, 0.1), arb(0.64)) is None
    assert _certainly_stable(arb(0.5), arb(1.0, 0.01)) is None
    assert _certainly_stable(arb(-1.6, 0.1), arb(0.64)) is None
