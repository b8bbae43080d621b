"""Cells along boundaries cut in four, as often as asked for."""

from collections.abc import Callable

import numpy as np

from camcli.analysis.basins.attractor_finder import BELOW, AttractorFinder
from camcli.analysis.basins.measures import boundary
from camcli.analysis.basins.window import Window


def refine(finder: AttractorFinder, window: Window, levels: int, on_cells: Callable[[int], None]):
    """(finest window, outcome, level of each cell, turns, cells computed), after `levels` halvings.

    A cell is cut in four where one of its eight neighbours is different, or where the cam cuts it.
    Where a cut cell turns out different from an uncut neighbour, that one is cut too, and so on: a
    boundary once found is followed all along.
    """
    outcome, turns = finder.settle(*window.centres(np.arange(window.count)), on_cells, share=True)
    table = outcome.reshape(window.nv, window.nq)
    level = np.zeros(table.shape, dtype=np.uint8)
    every = [turns]
    computed = window.count
    for step in range(1, levels + 1):
        fine = window.halved(step)
        cut = np.zeros(table.shape, dtype=bool)
        todo = boundary(_marks(table)) | _on_cam(finder, window.halved(step - 1))
        table = table.repeat(2, axis=0).repeat(2, axis=1)
        while todo.any():
            cut |= todo
            rows, columns = np.nonzero(todo)
            corner = 2 * rows * fine.nq + 2 * columns
            below = corner + fine.nq
            cells = np.sort(np.concatenate([corner, corner + 1, below, below + 1]))
            outcome, turns = finder.settle(*fine.centres(cells), on_cells)
            table.ravel()[cells] = outcome
            every.append(turns)
            computed += len(cells)
            parts = boundary(_marks(table))
            todo = parts[::2, ::2] | parts[1::2, ::2] | parts[::2, 1::2] | parts[1::2, 1::2]
            todo &= ~cut
        level = level.repeat(2, axis=0).repeat(2, axis=1)
        level[cut.repeat(2, axis=0).repeat(2, axis=1)] = step
    return window.halved(levels), table.ravel(), level, np.concatenate(every), computed


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
