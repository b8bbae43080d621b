"""Refinement: the same picture as the full grid, from few of its cells."""

import numpy as np

from camcli.analysis.basins.attractor_finder import BELOW
from camcli.analysis.basins.mapping import Question, basins
from camcli.analysis.basins.refine import leaves, refine
from camcli.analysis.basins.window import Window
from tests.conftest import settings

WINDOW = Window((0.1, 0.9), (-50.0, 50.0), 32, 32)


def test_refined_basins_are_those_of_the_full_grid(chapter):
    refined, _ = basins(chapter, 358.5, settings(), Question(WINDOW, refine=3))
    full, _ = basins(chapter, 358.5, settings(), Question(WINDOW.halved(3)))
    assert refined.window == full.window
    differ = (refined.codes != full.codes).mean()
    assert differ < 2e-3
    assert refined.computed < 0.16 * full.window.count
    assert abs(refined.fractions[1][0] - full.fractions[1][0]) < full.fractions[1][1]
    computed = refined.level == 3  # these are cells of the full grid
    assert (refined.codes == full.codes)[computed].all()


class Painted:
    """A census whose outcome is a function of the start, with the cam at q = 0.305."""

    class crew:  # noqa: N801
        lift = (0.305, 0.0)

    def __init__(self, outcome):
        self.outcome, self.asked = outcome, 0

    def settle(self, q, v, on_cells=None, share=False):
        self.asked += len(q)
        found = np.where(q < 0.305, BELOW, self.outcome(q, v)).astype(np.int16)
        return found, np.ones(len(q), dtype=np.int32)


def painted(outcome, levels=4):
    window = Window((0.0, 1.0), (0.0, 1.0), 16, 16)
    census = Painted(outcome)
    return census, *refine(census, window, levels, lambda cells: None)


def test_a_boundary_is_followed_where_the_coarse_cells_miss_it():
    """A stripe thinner than a coarse cell, met by one of its cells, is followed to its end."""

    def thin(q, v):
        return np.where(np.abs(v - 0.4 - 0.1 * q) < 0.012, 1, 0)

    census, fine, outcome, level, turns, computed = painted(thin)
    q, v = fine.centres(np.arange(fine.count))
    exact = np.where(q < 0.305, BELOW, thin(q, v))
    assert (outcome == exact).all()
    assert computed == census.asked == len(turns)
    assert computed < 0.3 * fine.count
    assert level.max() == 4


def test_the_cam_is_refined_and_leaves_cover_the_window_once():
    _, fine, outcome, level, _, _ = painted(lambda q, v: np.zeros(len(q), dtype=int), levels=3)
    q, _ = fine.centres(np.arange(fine.count))
    assert ((outcome == BELOW) == (q < 0.305)).all()
    sides = 8 >> level.ravel()[leaves(level, 3)].astype(int)
    assert (sides.astype(int) ** 2).sum() == fine.count


def test_nothing_to_refine_costs_nothing(chapter):
    result, _ = basins(chapter, 700.0, settings(), Question(WINDOW.with_cells(8, 8), refine=3))
    assert result.computed <= 64 + 3 * 8 * 64  # at most the cells along the cam
    assert (result.codes == 1).all()
