"""Where a fold touches a stable manifold, on folds that move with the speed by a formula.

After n turns the height of the fold is slope (rpm - touches_n) + (t - t_0 - drift rpm)^2, so that
it is lowest at t_0 + drift rpm, and zero there at touches_n.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.explain.tangency import Fold, FoldPoint, Folds, touch

NEAR, FAR = 740.0, 741.0
T0, DRIFT = 0.4, -3e-4


class Moving:
    """Folds of such a formula; asked: of the turns, the widths and the speeds."""

    def __init__(self, touches, slope=0.05, xi=1e-6, growth=4.0, turns=1, range_=(NEAR, FAR)):
        self.touches, self.slope, self.xi = touches, slope, xi
        self.carried = SimpleNamespace(near=range_[0], far=range_[1])
        self.saddle = SimpleNamespace(multipliers=(-growth + 0j, 0.1 + 0j), turns=turns)
        self.asked = []

    def lowest(self, rpm, n, t, half):
        self.asked.append((n, half, rpm, t))
        eta = self.slope * (rpm - self.touches(n))
        xi = self.xi if isinstance(self.xi, float) else self.xi(n)
        return FoldPoint(eta, T0 + DRIFT * rpm, xi)


def start(rpm=740.2, n=10) -> Fold:
    return Fold(rpm, n, T0 + DRIFT * rpm, 1e-3, 0.0)


@pytest.mark.parametrize("range_", [(NEAR, FAR), (FAR, NEAR)])
def test_a_fold_is_followed_to_where_it_touches(range_):
    """Turn after turn, until one more moves the speed by no more than it is known to."""
    folds = Moving(lambda n: 740.25 + 0.01 * 4.0 ** -(n - 10), xi=0.5, range_=range_)
    fold, change = touch(folds, start(740.2 if range_[0] == NEAR else 740.3))
    assert fold.rpm == pytest.approx(740.25, abs=1e-6)
    assert abs(fold.eta) <= 1e-6
    assert fold.slope == pytest.approx(DRIFT, rel=1e-4)
    assert fold.t == pytest.approx(T0 + DRIFT * fold.rpm, abs=1e-9)
    assert fold.xi == 0.5
    assert 0.0 <= change <= 1e-9 * 740.3
    turns = fold.n - 10
    before = folds.touches(fold.n - 1)
    assert change == pytest.approx(abs(fold.rpm - before), abs=1e-6)
    assert turns >= 8
    widths = {n: half for n, half, *_ in folds.asked}
    assert widths[11] == pytest.approx(1e-3 / 4.0)
    assert widths[12] == pytest.approx(1e-3 / 16.0)
    # each guess is where the fold has drifted to
    late = [(rpm, t) for n, _, rpm, t in folds.asked if n == fold.n]
    assert all(t == pytest.approx(T0 + DRIFT * rpm, abs=1e-7) for rpm, t in late)


def test_where_it_is_straight_along_the_manifold_one_touch_is_enough():
    """So near to the saddle that further turns change nothing."""
    folds = Moving(lambda n: 740.25, xi=lambda n: 1.0 if n < 12 else 1e-12)
    fold, change = touch(folds, start())
    assert 11 <= fold.n <= 12  # the next one is where the first was
    assert fold.rpm == pytest.approx(740.25, abs=1e-6)
    assert change < 1e-9 * 740.3
    straight = Moving(lambda n: 740.25 - 0.01 * n, xi=1e-12)
    fold, change = touch(straight, start(740.1))
    assert (fold.n, fold.rpm) == (10, pytest.approx(740.15, abs=1e-6))
    assert 0.0 < change < 1e-6 * 740.0
    assert fold.left == 150 - (len(straight.asked) - 1)  # secants of the first fold and those spent


@pytest.mark.parametrize(
    "folds",
    [
        Moving(lambda n: 741.3),  # beyond the far end
        Moving(lambda n: 739.9),  # on the other side of the near one
        Moving(lambda n: 740.25, slope=0.0),  # its height does not change
        Moving(lambda n: 740.25 + 0.01 * (n - 10) ** 2, xi=0.5),  # later with every turn
    ],
)
def test_a_fold_that_never_touches(folds):
    assert touch(folds, start()) is None


def test_a_saddle_of_several_turns_is_met_once_a_period():
    folds = Moving(lambda n: 740.25 + 0.01 * 0.1 ** (n - 10), xi=0.5, turns=3, growth=1.0)
    fold, _ = touch(folds, start())
    assert {n % 3 for n, *_ in folds.asked} == {10 % 3}
    assert fold.n % 3 == 1
    widths = [half for n, half, *_ in folds.asked if n == 13]
    assert widths[0] < 1e-3  # narrower, though the saddle does not stretch


def test_the_lowest_place_of_a_fold_has_both_of_its_numbers():
    """eta = (t - 2.1)^2 - 3 after two turns, and xi = 10 t there; other turns have others."""
    asked = []

    class Made(Folds):
        def at(self, rpm):
            return "pair"

        def places(self, rpm, pair, t, n):
            asked.append((rpm, pair, n))
            rows = np.full((n + 2, 2), 99.0)
            rows[n] = (t - 2.1) ** 2 - 3.0, 10.0 * t
            return rows

    found = Made(None, None, None, 1.0).lowest(700.0, 2, 2.0, 0.25)
    assert {*asked} == {(700.0, "pair", 2)}
    assert found == pytest.approx((-3.0, 2.1, 21.0), abs=1e-6)
    at_an_end = Made(None, None, None, 1.0).lowest(700.0, 2, 1.0, 0.25)
    assert at_an_end == pytest.approx((0.85**2 - 3.0, 1.25, 12.5))
