"""Cells along boundaries cut in four, as often as asked for."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camcli.analysis.basins.attractor_finder import BELOW, AttractorFinder
from camcli.analysis.basins.measures import boundary
from camcli.analysis.basins.window import Window


class Refined(NamedTuple):
    """The outcomes of a window whose cells may have been cut.

    window has the finest cells; outcome (its cells,) is filled from the coarser ones. level (nv,
    nq): at which halving each cell was computed, 0 the coarsest; None where none was cut. turns: of
    every cell that was followed; computed: how many these are.
    """

    window: Window
    outcome: np.ndarray
    level: np.ndarray | None
    turns: np.ndarray
    computed: int


def refine(
    finder: AttractorFinder, window: Window, levels: int, on_cells: Callable[[int], None]
) -> Refined:
    """The outcomes of a window's cells, those along boundaries cut in four `levels` times.

    A cell is cut in four where one of its eight neighbours is different, or where the cam cuts it.
    Where a cut cell turns out different from an uncut neighbour, that one is cut too, and so on: a
    boundary once found is followed all along.
    """
    outcome, turns = finder.settle(*window.centres(np.arange(window.count)), on_cells, share=True)
    table = outcome.reshape(window.nv, window.nq)
    level = np.zeros(table.shape, dtype=np.uint8)
    turns_of_all = [turns]
    for step in range(1, levels + 1):
        fine = window.halved(step)
        is_cut = np.zeros(table.shape, dtype=bool)
        to_cut = boundary(_marks(table)) | _on_cam(finder, window.halved(step - 1))
        table = _halved(table)
        while to_cut.any():
            is_cut |= to_cut
            cells = _quarters(to_cut, fine)
            outcome, turns = finder.settle(*fine.centres(cells), on_cells)
            table.ravel()[cells] = outcome
            turns_of_all.append(turns)
            differs = boundary(_marks(table))
            # a cell is cut where one of its quarters is at a boundary
            to_cut = differs[::2, ::2] | differs[1::2, ::2]
            to_cut |= differs[::2, 1::2] | differs[1::2, 1::2]
            to_cut &= ~is_cut
        level = _halved(level)
        level[_halved(is_cut)] = step
    all_turns = np.concatenate(turns_of_all)
    return Refined(window.halved(levels), table.ravel(), level, all_turns, len(all_turns))


def _halved(table: np.ndarray) -> np.ndarray:
    """A table of cells with every cell as four."""
    return table.repeat(2, axis=0).repeat(2, axis=1)


def _quarters(cells: np.ndarray, fine: Window) -> np.ndarray:
    """Flat indices, in the window of half the size, of the four quarters of each marked cell."""
    rows, columns = np.nonzero(cells)
    first = 2 * rows * fine.nq + 2 * columns
    next_row = first + fine.nq
    return np.sort(np.concatenate([first, first + 1, next_row, next_row + 1]))


def leaves(level: np.ndarray, levels: int) -> np.ndarray:
    """Flat indices, in the finest grid, of the first corner of every cell that was not cut."""
    corners = []
    for k in range(levels + 1):
        side = 1 << (levels - k)
        rows, columns = np.nonzero(level[::side, ::side] == k)
        corners.append(rows * side * level.shape[1] + columns * side)
    return np.sort(np.concatenate(corners))


def _marks(table: np.ndarray) -> np.ndarray:
    """Outcomes as `boundary` reads them: -1 is below the cam."""
    return np.where(table == BELOW, np.int16(-1), table + np.int16(1))


def _on_cam(finder: AttractorFinder, window: Window) -> np.ndarray:
    """Cells that the cam cuts: it is a line of constant q at the strobe."""
    c, _ = finder.batches.lift
    half = 0.5 * (window.q[1] - window.q[0]) / window.nq
    columns = np.abs(window.q_of(np.arange(window.nq)) - c) < half
    return np.broadcast_to(columns, (window.nv, window.nq))
