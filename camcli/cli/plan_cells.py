"""What cells of a window need, from a coarse grid of them followed in plain Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import log2

from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Settings
from camcli.cli.plan_probe import Glance, glance
from camcli.kernel.cam_table import ROW, START0, START1
from camcli.system import System, omega_of

SIDE = 10  # cells along each side of the coarse grid; half of them come first
SLICE, MOST_TURNS = 32, 160  # turns followed at a time, and in all
NEAR = 0.01  # relative distance at which a period of one turn is taken as reached
LONGEST = 12  # turns of a period that is looked for
STAYING = 60  # turns of a cell that ends on an aperiodic attractor, in the mean
FEWEST = 0.9  # exponent of the boundary where nothing better is known


@dataclass(frozen=True)
class Cell:
    """One cell: turns until it is settled; the motion it ends on, None: not periodic so far."""

    turns: int
    end: tuple | None
    period: int
    seen: tuple[Glance, ...]


@dataclass(frozen=True)
class Look:
    """A coarse grid at one speed.

    below: share of the cells that are below the cam; edges: share at a boundary, of a grid with
    `side` cells along a side; it shrinks with the cells to the power of `exponent`.
    """

    below: float
    cells: tuple[Cell, ...]
    edges: float
    side: int
    exponent: float

    @property
    def seen(self) -> list[Glance]:
        """All that was followed."""
        return [one for cell in self.cells for one in cell.seen]

    @property
    def aperiodic(self) -> float:
        """Share of the cells that reached no period."""
        return sum(cell.end is None for cell in self.cells) / max(1, len(self.cells))

    @property
    def periods(self) -> int:
        """Points of all periodic attractors together."""
        return sum({cell.end: cell.period for cell in self.cells if cell.end}.values())

    def turns(self, budget: int) -> float:
        """Turns of a cell that is not below the cam, in the mean."""
        each = [STAYING if cell.end is None else cell.turns for cell in self.cells]
        return sum(min(n, budget) for n in each) / max(1, len(each))

    def impacts(self) -> float:
        """Impacts per turn."""
        seen = self.seen
        return sum(sum(one.impacts) for one in seen) / max(1, sum(one.turns for one in seen))

    def at_boundary(self, side: int) -> float:
        """Share of the cells at a boundary where there are `side` of them along a side."""
        return min(1.0, self.edges * (self.side / max(side, self.side)) ** self.exponent)


def look(system: System, rpm: float, settings: Settings, window: Window, seconds: float) -> Look:
    """Follow the cells of a coarse grid, every other one first, while the work is little.

    `seconds` bound the work, counted as the machine of all constants would take for it.
    """
    q, v = window.with_cells(SIDE, SIDE).centres(range(SIDE * SIDE))
    c, c1 = _lift(system)
    omega = omega_of(rpm)
    begins = sorted(product(range(SIDE), range(SIDE)), key=lambda at: at[0] % 2 + at[1] % 2 > 0)
    known: dict[tuple[int, int], Cell | None] = {}
    spent = 0.0
    for row, column in begins:
        if spent > seconds and len(known) >= 2:
            break
        n = row * SIDE + column
        if q[n] < c:
            known[row, column] = None
            continue
        cell = _follow(system, rpm, settings, (float(q[n]) - c, float(v[n]) / omega - c1))
        spent += sum(one.nominal for one in cell.seen)
        known[row, column] = cell
    cells = tuple(cell for cell in known.values() if cell is not None)
    below = 1.0 - len(cells) / len(known)
    return Look(below, cells, *_edges(known))


def _lift(system: System) -> tuple[float, float]:
    """(c, c_theta) at the strobe; m, m/rad."""
    row = system.cam.strobe * ROW
    return system.cam.rows[row + START0], system.cam.rows[row + START1]


def _follow(system: System, rpm: float, settings: Settings, begin) -> Cell:
    """Follow one start, a slice of turns at a time, until its states repeat."""
    c, c1 = _lift(system)
    seen: list[Glance] = []
    states: list[tuple[float, float]] = []
    impacts: list[int] = []
    while len(impacts) < MOST_TURNS:
        one = glance(system, rpm, settings, SLICE, 100 * SLICE, begin)
        seen.append(one)
        states += one.states if not states else one.states[1:]
        impacts += one.impacts
        for n in range(max(1, len(impacts) - one.turns), len(impacts) + 1):
            period = _period(states, impacts, n)
            if period:
                word = _word(impacts[n - period : n])
                return Cell(n, word, len(word), tuple(seen))
        if one.ended or one.turns < SLICE:
            return Cell(max(1, len(impacts)), ("trouble",), 0, tuple(seen))
        begin = states[-1][0] - c, states[-1][1] - c1
    return Cell(len(impacts), None, 0, tuple(seen))


def _period(states: Sequence, impacts: Sequence[int], n: int) -> int:
    """Turns after which the state at strobe n is seen to have repeated, twice; 0 where not."""
    for period in range(1, min(LONGEST, n // 2) + 1):
        near = NEAR / period**1.5
        if impacts[n - period : n] != impacts[n - 2 * period : n - period]:
            continue
        if all(_apart(states[k], states[k - period]) <= near for k in (n, n - period)):
            return period
    return 0


def _apart(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Largest relative difference of two states."""
    return max(abs(x - y) / (max(abs(x), abs(y)) + 1e-9) for x, y in zip(a, b, strict=True))


def _word(turns: Sequence[int]) -> tuple[int, ...]:
    """Impacts of the turns of a period, wherever it was begun and however often it was seen."""
    n = len(turns)
    whole = next(k for k in range(1, n + 1) if n % k == 0 and turns[:k] * (n // k) == turns)
    return min(tuple(turns[k:whole]) + tuple(turns[:k]) for k in range(whole))


def _edges(known: dict) -> tuple[float, int, float]:
    """(share of cells at a boundary, side of the grid, exponent) of a whole grid or of half."""
    half = {at: cell for at, cell in known.items() if not (at[0] % 2 or at[1] % 2)}
    coarse = _at_boundary(half, 2)
    if len(known) < SIDE * SIDE:
        return coarse, SIDE // 2, FEWEST
    fine = _at_boundary(known, 1)
    grown = log2(coarse / fine) if fine and coarse else FEWEST
    return fine, SIDE, 0.5 * (min(1.0, max(0.0, grown)) + FEWEST)


def _at_boundary(known: dict, step: int) -> float:
    """Share of cells one of whose neighbours ends elsewhere."""
    ends = {at: None if cell is None else (cell.end,) for at, cell in known.items()}
    edges = 0
    for (row, column), end in ends.items():
        around = product((row - step, row, row + step), (column - step, column, column + step))
        edges += any(ends.get(at, end) != end for at in around)
    return edges / max(1, len(ends))
