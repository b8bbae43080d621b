"""Power series in the cam's angle against the derivatives that mpmath finds.

Each formula is made of the operations of a cam's lift, on a quadratic inside, so that no
coefficient is missed. mpmath knows it as a function alone.
"""

from __future__ import annotations

import pytest
from flint import arb, arb_series
from mpmath import mp, mpf

from camcli.cams.balls import precision
from camcli.cams.taylor import Taylor

THETA = mpf("0.375")
ORDER = 5
BALLS = {
    "sum": lambda x: 2 + x * x + (x - 3) + x - (0.5 - x) - x * 4,
    "product": lambda x: (x * x + 1) * (x - 2) * 3 / 8,
    "sine": lambda x: (x * x - x).sin(),
    "cosine": lambda x: (3 * x + x * x).cos(),
    "root": lambda x: (4 - x * x * 2 + x).sqrt(),
    "flank": lambda x: (0.7225 - 0.2025 * (x - 1).sin() * (x - 1).sin()).sqrt() - (x - 1).cos(),
}
NUMBERS = {
    "sum": lambda x: 2 + x**2 + (x - 3) + x - (mpf("0.5") - x) - 4 * x,
    "product": lambda x: (x**2 + 1) * (x - 2) * 3 / 8,
    "sine": lambda x: mp.sin(x**2 - x),
    "cosine": lambda x: mp.cos(3 * x + x**2),
    "root": lambda x: mp.sqrt(4 - 2 * x**2 + x),
    "flank": lambda x: mp.sqrt(mpf(0.7225) - mpf(0.2025) * mp.sin(x - 1) ** 2) - mp.cos(x - 1),
}


@pytest.mark.parametrize("name", BALLS)
def test_the_derivatives_of_a_formula(name):
    with precision(50), mp.workdps(60):
        found = BALLS[name](Taylor.variable(arb(float(THETA)), ORDER)).derivatives()
        assert len(found) == ORDER + 1
        for order, ball in enumerate(found):
            number = arb(mp.nstr(mp.diff(NUMBERS[name], THETA, order), 40))
            assert abs(ball - number) < arb("1e-25"), order


def test_the_coefficients_may_be_series_of_another_number():
    """Of sqrt(p + x) at p = 2, x = 0.375: by p and by x it has the same derivatives."""
    with precision(50), mp.workdps(60):
        p = arb_series([2, 1], 2)
        found = (Taylor.variable(arb(float(THETA)), 2) + p).sqrt().derivatives()
        slopes = [mp.diff(mp.sqrt, 2 + THETA, order) for order in range(4)]
        for order, series in enumerate(found):
            for by_p in (0, 1):
                number = arb(mp.nstr(slopes[order + by_p], 40))
                assert abs(series[by_p] - number) < arb("1e-25"), (order, by_p)
