"""The region about an attractor that is captured, for turns that are linear maps.

What the differences, the ellipses and the rings of starts come to has a closed form then.
"""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.region import region_of, rings, size_of

LIFT = (0.5, 0.125)  # of the cam at the strobe, m and m/rad


class Turns:
    """Turns that map what is beside point j by a matrix to beside the next point.

    edge: a start of which one number is farther from its point than this, over the size, makes
    another number of impacts.
    """

    lift = LIFT

    def __init__(self, points, matrices, symbols, edge=inf):
        self.points, self.symbols, self.edge = np.array(points), np.array(symbols), edge
        self.matrices = np.array(matrices)
        self.size = np.abs(self.points + np.array(LIFT)).max()

    def run(self, gap, rate, targets, turns, mode=None):
        x = np.column_stack((gap, rate))
        symbol = np.zeros(len(x), dtype=int)
        for _ in range(turns):
            away = x[:, None] - self.points[None]
            j = np.abs(away).max(2).argmin(1)
            off = away[np.arange(len(x)), j]
            symbol = np.where(np.abs(off).max(1) > self.edge * self.size, 9, self.symbols[j])
            after = self.points[(j + 1) % len(self.points)]
            x = after + np.einsum("nik,nk->ni", self.matrices[j], off)
        return SimpleNamespace(gap=x[:, 0], rate=x[:, 1], mode=np.zeros(len(x), dtype=int),
                               symbol=symbol)  # fmt: skip


def region_for(points, matrices, symbols=None, edge=inf):
    """The region of an attractor with these points above the cam, and its turns."""
    counts = symbols or (1.0,) * len(points)
    turns = Turns(points, matrices, [int(s) for s in counts], edge)
    states = tuple(tuple(np.add(point, LIFT)) for point in points)
    attractor = Attractor("P", len(points), states, counts)
    return region_of(turns, attractor), turns


def series(factor: float, s: float) -> float:
    """1 + (factor/s)^2 + (factor/s)^4 + ..."""
    return 1.0 / (1.0 - (factor / s) ** 2)


@pytest.mark.parametrize(("grows", "other"), [(0.5, -0.25), (-0.8, 0.1), (0.1, 0.7)])
def test_the_ellipse_about_a_fixed_point(grows, other):
    """Along gap and rate: the sum of what all turns make of a circle, each time s larger."""
    found, turns = region_for([(0.25, -0.5)], [np.diag([grows, other])])
    rho = max(abs(grows), abs(other))
    s = 0.5 * (1.0 + rho)
    assert turns.size == 0.75
    assert found.rho == pytest.approx(rho, rel=1e-6)
    assert found.shrink == pytest.approx(0.5 * (1.0 + s * s), rel=1e-6)
    assert (found.radius, found.returns, found.symbols) == (0.25, True, (1,))
    assert found.points.tolist() == [[0.25, -0.5]]
    scale = 1.0 / (0.25 * turns.size) ** 2
    wanted = [series(grows, s) * scale, 0.0, series(other, s) * scale]
    assert found.forms[0] == pytest.approx(wanted, rel=1e-5, abs=1e-6)
    assert found.half_widths()[0] == pytest.approx([wanted[0] ** -0.5, wanted[2] ** -0.5], rel=1e-5)


@pytest.mark.parametrize("turned", [0.6, 2.0])
def test_a_turn_that_rotates_has_circles(turned):
    c, s = np.cos(turned), np.sin(turned)
    found, turns = region_for([(0.25, 0.5)], [0.9 * np.array([[c, -s], [s, c]])])
    wanted = series(0.9, 0.95) / (0.25 * turns.size) ** 2
    assert found.rho == pytest.approx(0.9, rel=1e-6)
    assert found.forms[0] == pytest.approx([wanted, 0.0, wanted], rel=1e-5, abs=1e-3)


def test_a_period_of_two_turns_has_an_ellipse_at_each():
    """diag(2, 0.1) and then diag(0.25, 0.5): one turn grows, both together shrink."""
    matrices = [np.diag([2.0, 0.1]), np.diag([0.25, 0.5])]
    found, turns = region_for([(0.25, 0.0), (0.5, 0.25)], matrices, (2.0, 1.0))
    assert found.rho == pytest.approx(0.5, rel=1e-6)
    assert found.shrink == pytest.approx(0.5 * (1.0 + 0.75**2), rel=1e-6)
    s = 0.75**0.5  # over a turn
    scale = 1.0 / (found.radius * turns.size) ** 2
    for form, (first, second) in zip(found.forms, (matrices, matrices[::-1]), strict=True):
        for entry, k in ((0, 0), (2, 1)):
            once = 1.0 + (first[k, k] / s) ** 2
            both = (first[k, k] * second[k, k] / s**2) ** 2
            assert form[entry] == pytest.approx(once / (1.0 - both) * scale, rel=1e-5)
    assert (found.symbols, found.returns) == ((2, 1), True)
    starts, point_of = rings(found)
    assert np.bincount(point_of).tolist() == [72, 72]
    sizes = size_of(found, point_of, *starts.T)
    assert np.unique(np.round(sizes, 12)).tolist() == [0.04, 0.36, 1.0]  # 0.2, 0.6 and 1 squared


@pytest.mark.parametrize("edge", [0.1, 0.02, 1e-4])
def test_the_largest_ellipse_that_holds_is_taken(edge):
    """Each radius is 0.8 of the one before; no start of the widest ring is beyond the edge."""
    found, turns = region_for([(0.75, 0.25)], [np.diag([0.5, 0.5])], edge=edge)
    steps = np.log(found.radius / 0.25) / np.log(0.8)
    assert steps == pytest.approx(round(steps), abs=1e-9)
    starts, _ = rings(found)
    farthest = np.abs(starts - turns.points[0]).max() / turns.size
    assert 0.799 * edge <= farthest <= edge
    wider, _ = rings(found.scaled(1.25))
    assert np.abs(wider - turns.points[0]).max() / turns.size > edge


def test_none_is_taken_where_the_orbit_repels_or_nothing_holds():
    assert region_for([(0.25, 0.5)], [np.diag([1.0001, 0.1])])[0] is None
    found, turns = region_for([(0.25, 0.5)], [np.diag([0.5, 0.2])], edge=1e-12)
    assert (found.returns, found.shrink, found.radius) == (False, 1.0, 1e-8)
    circle = 1e16 / turns.size**2
    assert found.forms[0] == pytest.approx([circle, 0.0, circle], rel=1e-9)


def test_a_state_at_rest_on_the_cam_has_no_starts_about_it():
    """What begins there is all one motion: its map is zero, and the orbit attracts at once."""
    found, _ = region_for([(0.0, 0.0)], [np.diag([3.0, 3.0])], (7.0,))
    assert found.rho == 0.0
    assert len(rings(found)[0]) == 0
    assert found.returns


def test_no_start_lies_below_the_cam():
    """Of a state low above it, the part of the rings that is above."""
    found, turns = region_for([(1e-3, 0.5)], [np.diag([0.5, 0.5])])
    starts, _ = rings(found)
    assert 0 < len(starts) < 72
    assert starts[:, 0].min() >= 0.0
    assert found.radius * turns.size > 1e-3
