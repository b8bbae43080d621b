"""Basins over a window, by following every cell (orbit) or by a graph of cells (simple)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import BELOW, Census
from camcli.analysis.basins.cell_batches import Crew
from camcli.analysis.basins.cellmap import settle_by_cells
from camcli.analysis.basins.measures import fractions
from camcli.analysis.basins.region import Region
from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Cost, Settings
from camcli.kernel.cells import UNDECIDED
from camcli.parallel import Work
from camcli.system import System

ORBIT, SIMPLE = "orbit", "simple"
# Codes of cells: 1, 2, ... the attractors; and
UNDECIDED_CODE, BELOW_CODE = 0, -1  # kernel statuses (2, 3, 4) with a minus sign are trouble


@dataclass(frozen=True)
class Question:
    """What is asked at every speed; budget in turns."""

    window: Window
    method: str = ORBIT
    budget: int = 4000
    refine: int = 0


@dataclass(frozen=True)
class Basins:
    """Basins at one speed: a code per cell, row by row in v, and the attractors by number.

    With refinement `window` has the finest cells, `codes` are filled from the coarser ones, and
    `level` says at which level each was computed (0: the coarsest).
    """

    rpm: float
    window: Window
    method: str
    codes: np.ndarray  # (nv, nq) int16
    attractors: tuple[Attractor, ...]
    regions: tuple[Region | None, ...]
    stays: tuple[int, ...]  # turns in its boxes that decide, for aperiodic attractors
    turns: np.ndarray  # followed in each computed cell
    computed: int  # cells that were followed or mapped
    cost: Cost = field(default_factory=Cost)
    level: np.ndarray | None = None

    @cached_property
    def fractions(self) -> dict[int, tuple[float, float]]:
        """(fraction of the cells not below the cam, its standard error) by code."""
        return fractions(self.codes, [*range(1, len(self.attractors) + 1)])

    @property
    def undecided(self) -> int:
        """Cells that met no attractor within the budget."""
        return int((self.codes == UNDECIDED_CODE).sum())

    @property
    def troubled(self) -> dict[int, int]:
        """Number of cells by kernel status, where it is not ok."""
        found, counts = np.unique(self.codes[self.codes < BELOW_CODE], return_counts=True)
        return {-int(code): int(n) for code, n in zip(found, counts, strict=True)}


def basins(
    system: System,
    rpm: float,
    settings: Settings,
    question: Question,
    *,
    work: Work | None = None,
    on_cells: Callable[[int], None] = lambda cells: None,
) -> tuple[Basins, Census]:
    """Basins of one speed, and the census for further questions at it."""
    crew = Crew(system, rpm, settings, work or Work())
    census = Census(crew, question.budget)
    census.scout(question.window)
    window, level = question.window, None
    if question.method == SIMPLE:
        outcome, turns, computed = settle_by_cells(census, window, on_cells)
    elif question.refine:
        from camcli.analysis.basins.refine import refine

        window, outcome, level, turns, computed = refine(census, window, question.refine, on_cells)
    else:
        outcome, turns = census.settle(
            *window.centres(np.arange(window.count)), on_cells, share=True
        )
        computed = window.count
    codes = codes_of(census, outcome).reshape(window.nv, window.nq)
    ranked = np.argsort(census.ranks(), kind="stable").tolist()
    stays = census.boxes.stays if census.boxes else [0] * len(ranked)
    result = Basins(
        rpm,
        window,
        question.method,
        codes,
        tuple(census.attractors[k] for k in ranked),
        tuple(census.regions[k] for k in ranked),
        tuple(stays[k] for k in ranked),
        turns,
        computed,
        crew.cost,
        level,
    )
    return result, census


def codes_of(census: Census, outcome: np.ndarray) -> np.ndarray:
    """Codes of outcomes: attractors by their final number."""
    numbers = np.append(census.ranks(), np.int16(0))  # the last one never used
    known = numbers[np.clip(outcome, 0, len(numbers) - 1)]
    codes = np.where(outcome >= 0, known, outcome + 10)  # trouble: -10 - status
    codes = np.where(outcome == UNDECIDED, UNDECIDED_CODE, codes)
    return np.where(outcome == BELOW, BELOW_CODE, codes).astype(np.int16)
