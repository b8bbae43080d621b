"""Simple cell mapping (Hsu): every cell goes where one turn takes its centre.

Cells become a graph with one arrow each; following the arrows ends in a cycle of cells. A cycle is
named by following the orbit of the centre of its first cell. Cells whose image leaves the window
are followed as orbits, as is what starts beside it. A cell cut by the cam is mapped from the cam
where its centre is below.
"""

from __future__ import annotations

import numpy as np

from camcli.analysis.basins.attractor_finder import BELOW, CHUNK, Census
from camcli.analysis.basins.cell_batches import NOTHING
from camcli.analysis.basins.window import Window
from camcli.kernel.cells import UNDECIDED
from camcli.parallel import ShardDone


def settle_by_cells(census: Census, window: Window, on_cells):
    """(outcome, turns, cells) of a window; turns counts those of each cell itself."""
    cells = np.arange(window.count)
    q, v = window.centres(cells)
    c, _ = census.crew.lift
    below = q < c
    half = 0.5 * (window.q[1] - window.q[0]) / window.nq
    mapped = q + half > c
    q = np.maximum(q, c)
    arrow, outcome = _arrows(census, window, q, v, mapped, on_cells)
    turns = mapped.astype(np.int32)
    out = np.flatnonzero(mapped & (arrow < 0) & (outcome == UNDECIDED))
    outcome[out], more = census.settle(q[out], v[out])
    turns[out] += more
    end = np.where(arrow < 0, cells, arrow)
    for _ in range(window.count.bit_length()):  # arrow of arrow: 2^k steps at once
        end = end[end]
    first = _first_of_cycle(arrow, np.unique(end[mapped & (arrow[end] >= 0)]))
    names = np.unique(first[first >= 0])
    outcome[names], more = census.settle(q[names], v[names])
    turns[names] += more
    outcome = np.where(first[end] >= 0, outcome[first[end]], outcome[end])
    return np.where(below, BELOW, outcome).astype(np.int16), turns, int(mapped.sum())


def _arrows(census: Census, window: Window, q, v, mapped, on_cells):
    """(cell after one turn, -1 outside the window; outcome where the turn met trouble)."""
    arrow = np.full(window.count, -1)
    outcome = np.full(window.count, UNDECIDED, dtype=np.int16)
    crew = census.crew
    c, c1 = crew.lift
    whole = np.flatnonzero(mapped)
    on_cells(window.count - len(whole))
    for begin in range(0, len(whole), CHUNK):
        some = whole[begin : begin + CHUNK]
        try:
            ends = crew.run(*crew.states(q[some], v[some]), NOTHING, 1, share=True)
        except ShardDone:
            continue
        arrow[some] = window.cell_of(c + ends.gap, (c1 + ends.rate) * crew.omega)
        outcome[some] = ends.outcome
        arrow[some[ends.outcome != UNDECIDED]] = -1
        on_cells(len(some))
    if crew.work.shard is not None:
        raise ShardDone
    return arrow, outcome


def _first_of_cycle(arrow: np.ndarray, on_cycle: np.ndarray) -> np.ndarray:
    """For every cell on a cycle its lowest cell, else -1."""
    first = np.full(len(arrow), -1)
    for begin in on_cycle.tolist():  # ascending: the first one met is the lowest
        cell = begin
        while first[cell] < 0:
            first[cell] = begin
            cell = int(arrow[cell])
    return first
