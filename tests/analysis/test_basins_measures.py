"""Fractions, their errors, entropies and boundaries on grids whose answer is known."""

from math import log, pi, sqrt

import numpy as np
import pytest

from camcli.analysis.basins import uncertainty as uncertainty_module
from camcli.analysis.basins.measures import BOX, boundary, entropies, fractions
from camcli.analysis.basins.uncertainty import uncertainty
from camcli.analysis.basins.window import Window

UNIT = Window((0.0, 1.0), (0.0, 1.0), 10, 10)


def disk(n, shift=(0.0, 0.0), radius=0.31):
    x = (np.arange(n) + 0.5) / n - 0.5
    inside = (x[None, :] - shift[0]) ** 2 + (x[:, None] - shift[1]) ** 2 < radius**2
    return np.where(inside, 1, 2).astype(np.int16)


def test_fractions_are_of_the_cells_above_the_cam():
    codes = np.array([[-1, -1, 1, 2], [-1, 1, 0, -4]])
    found = fractions(codes, [1, 2, 3])
    assert {code: share for code, (share, _) in found.items()} == {
        1: 0.4, 2: 0.2, 3: 0.0, 0: 0.2, -4: 0.2,
    }  # fmt: skip
    assert fractions(np.full((3, 3), -1), [1])[1] == (0.0, 0.0)


def test_a_uniform_grid_has_no_error_and_no_entropy():
    codes = np.ones((10, 10), dtype=np.int16)
    assert fractions(codes, [1])[1] == (1.0, 0.0)
    assert entropies(codes)["basin_entropy"] == 0.0
    assert not boundary(codes).any()


@pytest.mark.parametrize("n", [50, 200])
def test_the_standard_error_is_that_of_a_disk(n):
    """Disks shifted under the grid: the scatter of their areas is as the estimate says."""
    rng = np.random.default_rng(5)
    areas, errors = [], []
    for shift in rng.uniform(-0.1, 0.1, (60, 2)):
        share, error = fractions(disk(n, shift), [1, 2])[1]
        areas.append(share)
        errors.append(error)
    true = pi * 0.31**2
    scatter = float(np.sqrt(np.mean((np.array(areas) - true) ** 2)))
    assert 0.2 < scatter / float(np.mean(errors)) < 1.5
    binomial = sqrt(true * (1.0 - true)) / n
    assert max(errors) < 0.5 * binomial


def test_entropies_of_boxes_with_known_shares():
    codes = np.ones((2 * BOX, 3 * BOX), dtype=np.int16)
    codes[:BOX, :BOX] = 0  # uniform, undecided
    codes[BOX, :BOX] = 2  # a fifth of a box
    codes[BOX:, BOX : 2 * BOX] = -1  # below the cam
    found = entropies(codes)
    box = -(0.2 * log(0.2) + 0.8 * log(0.8))
    assert found["boxes"] == 5
    assert found["boundary_boxes"] == 1
    assert found["boundary_entropy"] == pytest.approx(box)
    assert found["basin_entropy"] == pytest.approx(box / 5)


def test_the_cam_is_no_boundary():
    codes = np.array([[-1, 1, 1], [-1, 1, 2]])
    assert boundary(codes).tolist() == [[False, True, True], [False, True, True]]
    assert not boundary(codes[:, :2]).any()


class Painted:
    """A census whose outcome is a function of the start."""

    def __init__(self, outcome):
        self.outcome = outcome

    def settle(self, q, v):
        return np.asarray(self.outcome(q, v)), None


def test_a_smooth_boundary_has_exponent_one():
    found = uncertainty(Painted(lambda q, v: np.where(v < 0.3 + 0.2 * q, 0, 1)), UNIT)
    assert found.exponent == pytest.approx(1.0, abs=4.0 * found.error)
    assert found.dimension == pytest.approx(2.0 - found.exponent)


def test_a_cantor_boundary_has_its_dimension(monkeypatch):
    """Stripes over the gaps of the middle-third set: dimension 1 + log 2/log 3."""
    monkeypatch.setattr(uncertainty_module, "STARTS", 60_000)
    found = uncertainty(Painted(lambda q, v: _gap_level(q) % 2), UNIT)
    assert found.exponent == pytest.approx(1.0 - log(2.0) / log(3.0), abs=0.04)


def _gap_level(q):
    """Which generation of removed thirds holds each number."""
    x, level = np.mod(q, 1.0), np.zeros(len(q), dtype=int)
    open_ = np.ones(len(q), dtype=bool)
    for n in range(1, 16):
        x = 3.0 * x
        third = np.floor(x)
        x = x - third
        hit = open_ & (third == 1)
        level[hit] = n
        open_ &= ~hit
    return level


def test_no_boundary_no_exponent():
    assert uncertainty(Painted(lambda q, v: np.zeros(len(q), dtype=int)), UNIT) is None
    assert uncertainty(Painted(lambda q, v: np.full(len(q), -1)), UNIT) is None


def test_cells_and_centres_are_inverse():
    window = Window((0.1, 0.9), (-50.0, 50.0), 7, 11)
    cells = np.arange(window.count)
    assert window.cell_of(*window.centres(cells)).tolist() == cells.tolist()
    assert window.cell_of([0.05, 0.9, 0.5], [0.0, 0.0, 50.0]).tolist() == [-1, -1, -1]
    assert window.halved(2).count == 16 * window.count
