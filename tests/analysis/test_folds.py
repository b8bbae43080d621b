"""Folds of a manifold over another one, and their first touch, on motions written in closed form.

The start at t on W^u is the state (t, 0); after k turns it is at
eta_k = height_k(rpm) + (t - at_k)^2, xi_k = xi, in the axes of a saddle that is not at the origin.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import e, exp, inf, log
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.explain import saddles, tangency
from camcli.analysis.explain.saddles import LostError
from camcli.analysis.explain.tangency import NEAR_SADDLE, FoldPoint, Folds, Sampling, first_touch
from camcli.analysis.integrate import StartError
from camcli.kernel.orbit_loop import CHATTER, IMPACT
from tests.conftest import chapter_system

AXES = np.array([[2.0, -1.0], [0.5, 3.0]])  # columns a_1, a_2
PLACE = np.array([0.3, -7.0])
FAR_AWAY = 5.0
SAMPLING = Sampling(starts=40, searches=2, solved=3)


@dataclass
class Motions:
    """`CarriedAttractor` as the folds ask it; folds: (height, at) by turns after the start."""

    folds: dict
    side: float = 1.0
    near: float = 700.0
    far: float = 710.0
    xi: float = 1e-3
    stays: float = 701.0
    leaves: float = 703.2
    crowding: float = 1.0
    below_cam: tuple[float, float] = (inf, inf)  # t between which a start is none
    ends_after: int = 10_000
    far_along: tuple[int, ...] = ()  # after so many turns it is far along W^s
    system: object = None
    asked: list = field(default_factory=list)

    def way(self, rpm: float) -> float:
        return abs(rpm - self.near)

    def states(self, rpm: float, x: np.ndarray, turns: int) -> np.ndarray:
        """One turn more than is asked for may be there."""
        t = x[0]
        self.asked.append((rpm, t, turns))
        if self.below_cam[0] <= t <= self.below_cam[1]:
            raise StartError(0.0, 0.0)
        found = []
        for k in range(min(turns + 2, self.ends_after)):
            eta = FAR_AWAY
            if k in self.folds:
                height, at = self.folds[k]
                eta = self.side * (height(rpm) + (t - at) ** 2)
            xi = 1.1 * NEAR_SADDLE if k in self.far_along else self.xi
            found.append(PLACE + eta * AXES[:, 0] + xi * AXES[:, 1])
        return np.array(found)


class KnownFolds(Folds):
    """Folds whose base and saddle are the same at every speed."""

    def at(self, rpm: float):
        base = SimpleNamespace(mu=self.base.mu, leaf=lambda t: np.array([t, 0.0]))
        return base, SimpleNamespace(x=PLACE, to=np.linalg.inv(AXES).T)


def folds_of(motions: Motions, mu=e, sampling=SAMPLING, turns=1) -> KnownFolds:
    base = SimpleNamespace(turns=turns, mu=mu)
    saddle = SimpleNamespace(turns=1, multipliers=(2.0 + 0j, 0.1 + 0j))
    return KnownFolds(motions, base, saddle, motions.side, sampling)


def level(value: float):
    return lambda rpm: value


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_places_are_coordinates_about_the_saddle(side):
    """eta is positive on the attractor's side; xi keeps its sign."""
    motions = Motions({2: (level(0.01), 0.4)}, side, below_cam=(0.9, 1.0))
    folds = folds_of(motions)
    pair = folds.at(700.0)
    found = folds.places(700.0, pair, 0.5, 3)
    assert found.shape == (4, 2)
    assert found[2] == pytest.approx([0.02, 1e-3])
    assert found[:, 0] == pytest.approx([side * FAR_AWAY] * 2 + [0.02, side * FAR_AWAY])
    assert found[:, 1] == pytest.approx([1e-3] * 4)
    assert np.isinf(folds.places(700.0, pair, 0.95, 3)).all()
    motions.ends_after = 2
    found = folds.places(700.0, pair, 0.5, 3)
    assert np.isfinite(found[:2]).all()
    assert np.isinf(found[2:]).all()


def test_the_lowest_place_of_a_window_is_where_the_parabola_is():
    folds = folds_of(Motions({7: (lambda rpm: 1e-3 * (rpm - 704.0), 0.4)}))
    assert folds.lowest(706.0, 7, 0.45, 0.2) == FoldPoint(
        pytest.approx(2e-3, abs=1e-12), pytest.approx(0.4, abs=1e-6), pytest.approx(1e-3)
    )
    assert folds.lowest(706.0, 7, 0.7, 0.2)[:2] == pytest.approx((2e-3 + 0.01, 0.5))  # at its end
    asked = [t for _, t, _ in folds.carried.asked]
    assert min(asked) >= 0.25 - 1e-12
    assert max(asked) <= 0.9 + 1e-12


@pytest.mark.parametrize(("mu", "turns", "span"), [(e, 1, 1.0), (-exp(0.7), 2, 1.4)])
@pytest.mark.parametrize("shift", [0.0, 0.5])
def test_all_folds_of_a_period_of_the_manifold_are_seen(mu, turns, span, shift):
    """t goes from the first start over ln |mu|, twice that where mu is negative."""
    last = 55 + int(turns * log(1e4) / log(abs(mu)))
    known = {
        3: (0.004, 0.21 * span), 11: (-0.002, 0.83 * span), last: (0.001, 0.52 * span),
        last + 1: (-0.01, 0.5 * span), 5: (0.06, 0.4 * span), 6: (0.001, 1.5 * span),
        8: (0.002, 0.6 * span),
    }  # fmt: skip
    heights = {k: (level(height), at) for k, (height, at) in known.items()}
    motions = Motions(heights, far_along=(8,))
    seen = folds_of(motions, mu, SAMPLING, turns).sample(702.0, shift)
    assert [(fold.n, fold.rpm) for fold in seen] == [(11, 702.0), (last, 702.0), (3, 702.0)]
    spacing = span / 40
    for fold in seen:
        height, at = known[fold.n]
        assert fold.eta == pytest.approx(height, abs=1e-6)
        assert fold.t == pytest.approx(at, abs=1e-3)
        assert fold.half == pytest.approx(0.5 * spacing)
    starts = [t for _, t, turns in motions.asked[:40]]
    assert starts == pytest.approx([spacing * (k + shift) for k in range(40)])
    assert {turns for *_, turns in motions.asked[:40]} == {last}


def test_a_fold_that_touches_first_is_the_crisis_and_its_error_is_told():
    """Heights sink by 1e-3 a rpm: to zero at 704.5, 703 and 707 rpm, and one never does."""
    zeros = {20: (704.5, 0.11), 21: (703.0, 0.52), 22: (707.0, 0.73), 23: (730.0, 0.93)}
    motions = Motions(
        {k: (lambda rpm, zero=zero: 1e-3 * (zero - rpm), at) for k, (zero, at) in zeros.items()},
        xi=1e-7,  # W^s is straight there
    )
    found = first_touch(folds_of(motions, sampling=Sampling(40, 3, 4)), 701.5)
    assert found.fold.n == 21
    assert found.fold.rpm == pytest.approx(703.0, abs=1e-5)
    assert found.fold.t == pytest.approx(0.52, abs=1e-3)
    # three tangencies are too few to tell: the distance to the next, or three lifetimes
    assert found.error == pytest.approx(1.5, abs=1e-3)
    motions.stays = 702.8
    found = first_touch(folds_of(motions, sampling=Sampling(40, 3, 4)), 701.5)
    assert found.error == pytest.approx(3.0 * 0.2, rel=1e-3)
    none = Motions({20: (level(0.01), 0.4)})
    assert first_touch(folds_of(none), 701.5) is None


def test_a_base_that_does_not_repel_has_no_manifold(monkeypatch):
    for mu, lost in ((1.0, True), (-1.0, True), (1.001, False), (-1.5, False)):
        monkeypatch.setattr(tangency, "Saddle", lambda *_, mu=mu: SimpleNamespace(mu=mu))
        folds = Folds(Motions({}), SimpleNamespace(), SimpleNamespace(), 1.0)
        if lost:
            with pytest.raises(LostError):
                folds.at(700.0)
        else:
            assert [one.mu for one in folds.at(700.0)] == [mu, mu]


@pytest.mark.parametrize(
    ("deg", "kind", "turn", "name"),
    [
        (160.0, IMPACT, 0, "c"),
        (160.0 + 5e-5, IMPACT, 3, "c"),  # 1e-6 rad are 5.7e-5 deg
        (160.0 + 6e-5, IMPACT, 3, None),
        (160.0, CHATTER, 0, None),
        (160.0, IMPACT, -1, None),  # before the strobe
    ],
)
def test_a_fold_at_a_corner_is_the_image_of_an_impact_there(deg, kind, turn, name):
    record = SimpleNamespace(
        kind=np.array([IMPACT, kind]), theta=np.radians([10.0, deg]), u=np.array([-1.0, -2.0]),
        period=np.array([0, turn]),
    )  # fmt: skip
    asked = []
    motions = Motions({}, system=chapter_system())
    motions.motion = lambda *given: asked.append(given) or record
    fold = tangency.Fold(703.0, 9, 0.25, 0.1, 0.0)
    found = folds_of(motions).corner(fold)
    assert (found and found.name) == name
    ((rpm, x, turns, events),) = asked
    assert (rpm, x.tolist(), turns, events) == (703.0, [0.25, 0.0], 9, True)


def test_the_inner_side_of_a_saddle_is_the_one_that_stays(monkeypatch):
    """Starts above the saddle along its first axis, and below, have so many states outside."""

    def side(above: int, below: int, mu: complex = 2.0 + 0j, at_speed=2.0) -> float:
        class Stub:
            def __init__(self, *_):
                self.mu = at_speed

            def leaf(self, t, first):
                assert 0.0 <= t < log(2.0)
                assert abs(first) == 1e-6
                return first

        asked = []

        def outside(_, rpm, x, turns):
            asked.append(x)
            assert (rpm, turns) == (700.0, 55 + int(3 * log(1e6) / log(2.0)))
            return above if x > 0.0 else below

        monkeypatch.setattr(saddles, "Saddle", Stub)
        monkeypatch.setattr(saddles, "_outside", outside)
        orbit = SimpleNamespace(multipliers=(mu, 0.1 + 0j), turns=3)
        found = saddles.inner_side(None, 700.0, orbit)
        assert asked in ([], [1e-6, -1e-6] * 60)
        return found

    assert side(0, 1) == 1.0  # 60 starts
    assert side(1, 0) == -1.0
    assert side(1, 11) == 1.0
    assert side(1, 10) == 0.0  # ten times as many are not clearly more
    assert side(0, 0) == 0.0
    assert side(0, 1, mu=-2.0 + 0j) == 0.0
    assert side(0, 1, mu=0.99 + 0j) == 0.0
    assert side(0, 1, mu=1.5 + 0.1j) == 0.0
    assert side(0, 1, at_speed=1.0) == 0.0
