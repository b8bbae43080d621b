"""Cells of the window: simple cell mapping, and refinement along boundaries.

Simple cell mapping (C. S. Hsu, Cell-to-Cell Mapping, 1987): every cell goes where one turn takes
its centre, so that cells are a graph with one arrow each, and following the arrows ends in a cycle
of cells. A cycle is named by following the orbit of the centre of its first cell. Cells whose image
leaves the window are followed as orbits, as is what starts beside it. A cell cut by the cam is
mapped from the cam where its centre is below.
"""

from collections.abc import Callable

import numpy as np

from camcli.analysis.basins.attractor_finder import BELOW, CHUNK, AttractorFinder
from camcli.analysis.basins.cell_batches import NOTHING
from camcli.analysis.basins.measures import boundary
from camcli.analysis.basins.window import Window
from camcli.kernel.cells import UNDECIDED
from camcli.parallel import ShardDone


def settle_by_cells(finder: AttractorFinder, window: Window, on_cells: Callable[[int], None]):
    """(outcome, turns, cells) of a window; turns counts those of each cell itself."""
    cells = np.arange(window.count)
    q, v = window.centres(cells)
    c, _ = finder.batches.lift
    below = q < c
    half = 0.5 * (window.q[1] - window.q[0]) / window.nq
    mapped = q + half > c
    q = np.maximum(q, c)
    arrow, outcome = _arrows(finder, window, q, v, mapped, on_cells)
    turns = mapped.astype(np.int32)
    out = np.flatnonzero(mapped & (arrow < 0) & (outcome == UNDECIDED))
    outcome[out], more = finder.settle(q[out], v[out])
    turns[out] += more
    end, lowest = np.where(arrow < 0, cells, arrow), cells
    for _ in range(window.count.bit_length()):  # arrow of arrow: 2^k steps at once
        end, lowest = end[end], np.minimum(lowest, lowest[end])
    first = lowest[end]  # of the cycle that a cell ends on, or the cell from which no arrow leads
    names = np.unique(first[arrow[first] >= 0])
    outcome[names], more = finder.settle(q[names], v[names])
    turns[names] += more
    return np.where(below, BELOW, outcome[first]).astype(np.int16), turns, int(mapped.sum())


def _arrows(finder: AttractorFinder, window: Window, q, v, mapped, on_cells):
    """(cell after one turn, -1 outside the window; outcome where the turn met trouble)."""
    arrow = np.full(window.count, -1)
    outcome = np.full(window.count, UNDECIDED, dtype=np.int16)
    batches = finder.batches
    c, c1 = batches.lift
    whole = np.flatnonzero(mapped)
    on_cells(window.count - len(whole))
    for begin in range(0, len(whole), CHUNK):
        some = whole[begin : begin + CHUNK]
        try:
            ends = batches.run(*batches.states(q[some], v[some]), NOTHING, 1, share=True)
        except ShardDone:
            continue
        arrow[some] = window.cell_of(c + ends.gap, (c1 + ends.rate) * batches.omega)
        outcome[some] = ends.outcome
        arrow[some[ends.outcome != UNDECIDED]] = -1
        on_cells(len(some))
    if batches.work.shard is not None:
        raise ShardDone
    return arrow, outcome


def refine(finder: AttractorFinder, window: Window, levels: int, on_cells: Callable[[int], None]):
    """(finest window, outcome, level of each cell, turns, cells computed), after `levels` halvings.

    A cell is cut in four where one of its eight neighbours is different, or where the cam cuts it.
    Where a cut cell turns out different from an uncut neighbour, that one is cut too, and so on: a
    boundary once found is followed all along.
    """
    outcome, turns = finder.settle(*window.centres(np.arange(window.count)), on_cells, share=True)
    table = outcome.reshape(window.nv, window.nq)
    level = np.zeros(table.shape, dtype=np.uint8)
    every, computed = [turns], window.count
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
    found = []
    for k in range(levels + 1):
        side = 1 << (levels - k)
        rows, columns = np.nonzero(level[::side, ::side] == k)
        found.append(rows * side * level.shape[1] + columns * side)
    return np.sort(np.concatenate(found))


def _marks(table: np.ndarray) -> np.ndarray:
    """Outcomes as `boundary` reads them: -1 is below the cam."""
    return np.where(table == BELOW, np.int16(-1), table + np.int16(1))


def _on_cam(finder: AttractorFinder, window: Window) -> np.ndarray:
    """Cells that the cam cuts: it is a line of constant q at the strobe."""
    c, _ = finder.batches.lift
    half = 0.5 * (window.q[1] - window.q[0]) / window.nq
    columns = np.abs(window.q_of(np.arange(window.nq)) - c) < half
    return np.broadcast_to(columns, (window.nv, window.nq))
