"""Fractions, their errors, entropies, boundaries, refinement on grids whose answer is known."""

from math import log, pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.basins.attractor_finder import BELOW
from camcli.analysis.basins.measures import BOX, boundary, entropies, fractions, uncertainty
from camcli.analysis.basins.refinement import _on_cam, leaves, refine
from camcli.analysis.basins.saddles import _nearest
from camcli.analysis.basins.window import Window

UNIT = Window((0.0, 1.0), (0.0, 1.0), 16, 16)


class Painted:
    """A finder whose outcome is a function of the start, with the cam at q = 0.305."""

    class batches:  # noqa: N801
        lift = (0.305, 0.0)

    def __init__(self, outcome, below=False):
        self.outcome, self.below, self.asked = outcome, below, 0

    def settle(self, q, v, on_cells=None, share=False):
        self.asked += len(q)
        found = np.asarray(self.outcome(q, v)).astype(np.int16)
        found = np.where(self.below & (q < 0.305), np.int16(BELOW), found)
        return found, np.ones(len(q), dtype=np.int32)


def test_fractions_are_of_the_cells_above_the_cam():
    codes = np.array([[-1, -1, 1, 2], [-1, 1, 0, -4]])
    shares = {code: share for code, (share, _) in fractions(codes, [1, 2, 3]).items()}
    assert shares == {1: 0.4, 2: 0.2, 3: 0.0, 0: 0.2, -4: 0.2}
    assert fractions(np.full((3, 3), -1), [1])[1] == (0.0, 0.0)
    uniform = np.ones((10, 10), dtype=np.int16)
    assert fractions(uniform, [1])[1] == (1.0, 0.0)
    assert entropies(uniform)["basin_entropy"] == 0.0
    assert not boundary(uniform).any()
    codes = np.array([[-1, -1, -1, -1, -1], [-1, -1, 1, 1, 1], [1, 1, 1, 1, 2]])
    assert boundary(codes).astype(int).tolist() == [[0] * 5, [0, 0, 0, 1, 1], [0, 0, 0, 1, 1]]


@pytest.mark.parametrize("n", [50, 200])
def test_the_standard_error_is_that_of_a_disk(n):
    """Disks shifted under the grid: the scatter of their areas is as the estimate says."""
    rng, x = np.random.default_rng(5), (np.arange(n) + 0.5) / n - 0.5
    found = []
    for dx, dy in rng.uniform(-0.1, 0.1, (60, 2)):
        inside = (x[None, :] - dx) ** 2 + (x[:, None] - dy) ** 2 < 0.31**2
        found.append(fractions(np.where(inside, 1, 2).astype(np.int16), [1, 2])[1])
    areas, errors = np.array(found).T
    true = pi * 0.31**2
    assert 0.2 < np.sqrt(np.mean((areas - true) ** 2)) / errors.mean() < 1.5
    assert errors.max() < 0.5 * sqrt(true * (1.0 - true)) / n  # well below the binomial one


def test_entropies_of_boxes_with_known_shares():
    codes = np.ones((2 * BOX, 3 * BOX), dtype=np.int16)
    codes[:BOX, :BOX] = 0  # uniform, undecided
    codes[BOX, :BOX] = 2  # a fifth of a box
    codes[BOX:, BOX : 2 * BOX] = -1  # below the cam
    found = entropies(codes)
    box = -(0.2 * log(0.2) + 0.8 * log(0.8))
    assert (found["boxes"], found["boundary_boxes"]) == (5, 1)
    assert found["boundary_entropy"] == pytest.approx(box)
    assert found["basin_entropy"] == pytest.approx(box / 5)


def test_entropies_box_by_box():
    """By the definition: cells below the cam (-1) do not count, trouble (-2) does, as a code."""
    random = np.random.default_rng(11)
    codes = random.choice(
        [-2, -1, 0, 1, 2], (3 * BOX + 2, 2 * BOX + 1), p=[0.1, 0.4, 0.1, 0.2, 0.2]
    )
    codes[:BOX, :BOX] = -1
    codes[BOX : 2 * BOX, :BOX] = np.where(codes[BOX : 2 * BOX, :BOX] == -1, -1, 2)
    codes[: BOX - 1, BOX : 2 * BOX] = -2
    sizes = []
    for row in range(3):
        for column in range(2):
            box = codes[row * BOX : (row + 1) * BOX, column * BOX : (column + 1) * BOX]
            cells = [int(code) for code in box.ravel() if code != -1]
            shares = [cells.count(code) / len(cells) for code in set(cells)]
            sizes += [-sum(p * log(p) for p in shares)] if cells else []
    mixed = [size for size in sizes if size > 0.0]
    assert (len(sizes), len(mixed)) == (5, 4)
    found = entropies(codes)
    assert (found["boxes"], found["boundary_boxes"]) == (5, 4)
    assert found["basin_entropy"] == pytest.approx(sum(sizes) / 5)
    assert found["boundary_entropy"] == pytest.approx(sum(mixed) / 4)


def test_uncertainty_exponents_of_a_line_and_of_a_cantor_set():
    """Stripes over the gaps of the middle-third set: dimension 1 + log 2/log 3."""
    smooth = uncertainty(Painted(lambda q, v: np.where(v < 0.3 + 0.2 * q, 0, 1)), UNIT)
    assert smooth.exponent == pytest.approx(1.0, abs=4.0 * smooth.error)
    assert smooth.dimension == pytest.approx(2.0 - smooth.exponent)
    x, y, weight = (np.array(column) for column in zip(*smooth.rows, strict=True))
    x, y = np.log(x), np.log(y)  # the line of least squares, weighted by the starts in doubt
    middle = np.average(x, weights=weight), np.average(y, weights=weight)
    square = (weight * (x - middle[0]) ** 2).sum()
    slope = (weight * (x - middle[0]) * (y - middle[1])).sum() / square
    assert smooth.exponent == pytest.approx(slope, rel=1e-9)
    assert smooth.error == pytest.approx(1.0 / sqrt(square), rel=1e-9)  # 1/sqrt(n) of log n
    for nothing in (0, -1):  # no boundary; nothing decided
        assert uncertainty(Painted(lambda q, v, n=nothing: np.full(len(q), n)), UNIT) is None
    cantor = uncertainty(Painted(lambda q, v: gap_level(q) % 2), UNIT, 60_000)
    assert cantor.exponent == pytest.approx(1.0 - log(2.0) / log(3.0), abs=0.04)


def gap_level(q):
    """Which generation of removed thirds holds each number."""
    x, level = np.mod(q, 1.0), np.zeros(len(q), dtype=int)
    for n in range(1, 16):
        third = np.floor(3.0 * x)
        x = 3.0 * x - third
        level[(level == 0) & (third == 1)] = n
    return level


def test_a_boundary_is_followed_where_the_coarse_cells_miss_it():
    """A stripe thinner than a coarse cell, met by one of its cells, is followed to its end."""

    def thin(q, v):
        return np.where(np.abs(v - 0.4 - 0.1 * q) < 0.012, 1, 0)

    finder = Painted(thin, below=True)
    fine, outcome, level, turns, computed = refine(finder, UNIT, 4, lambda cells: None)
    q, v = fine.centres(np.arange(fine.count))
    assert (outcome == np.where(q < 0.305, BELOW, thin(q, v))).all()
    assert computed == finder.asked == len(turns)
    assert computed < 0.3 * fine.count
    assert level.max() == 4
    sides = 16 >> level.ravel()[leaves(level, 4)].astype(int)
    assert (sides.astype(int) ** 2).sum() == fine.count  # the cells not cut cover it once


@pytest.mark.parametrize(("off", "led"), [(0.9e-3, True), (1.1e-3, False)])
@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, -1.0), (-1.0, 1.0)])
def test_a_motion_was_led_to_a_saddle_where_both_of_its_numbers_come_near(off, led, way):
    """To any state of the saddle, within a thousandth of the sizes; alike in one is not near."""
    size, states = np.array([0.02, 0.5]), ((0.01, 0.2), (0.03, 0.9))
    saddle = SimpleNamespace(states=states)
    other = SimpleNamespace(states=((0.011, 0.9), (0.5, 0.5)))
    far = np.array([[0.01, 0.9], [0.03, 0.2], [5.0, 5.0]]) / size
    near = np.array(states[1]) / size + off * np.array(way)
    for at in (np.vstack((far, near)), np.vstack((near, far))):
        assert _nearest([saddle, other], at, size) == (0 if led else None)
        assert _nearest([other, saddle], at, size) == (1 if led else None)
    assert _nearest([saddle], far, size) is None
    assert _nearest([], far, size) is None


@pytest.mark.parametrize(("c", "cut"), [(0.33, [3]), (0.3999, [3]), (0.4001, [4]), (1.2, [])])
def test_the_cam_cuts_the_one_column_of_cells_that_it_lies_in(c, cut):
    """Ten columns from 0 to 1, four rows."""
    window = Window((0.0, 1.0), (-1.0, 1.0), 10, 4)
    finder = SimpleNamespace(batches=SimpleNamespace(lift=(c, 0.0)))
    found = _on_cam(finder, window)
    assert found.shape == (4, 10)
    assert [np.flatnonzero(row).tolist() for row in found] == [cut] * 4
