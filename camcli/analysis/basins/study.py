"""Basins at one speed or over a range of them, as plain results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.branches import Branches
from camcli.analysis.basins.growth import largest_exponent
from camcli.analysis.basins.mapping import Basins, Question, basins
from camcli.analysis.basins.measures import entropies
from camcli.analysis.basins.region import Region
from camcli.analysis.basins.uncertainty import Uncertainty, uncertainty
from camcli.analysis.integrate import Cost, Settings
from camcli.parallel import ShardDone, Work
from camcli.system import System


@dataclass(frozen=True)
class Speed:
    """One speed: its attractors, the branch of each, and what the grid says in numbers."""

    rpm: float
    attractors: tuple[Attractor, ...]
    branches: tuple[int, ...]
    regions: tuple[Region | None, ...]
    stays: tuple[int, ...]
    fractions: dict[int, tuple[float, float]]  # by code; attractor k has code k + 1
    undecided: int
    troubled: dict[int, int]
    entropies: dict[str, float | int]
    uncertainty: Uncertainty | None
    cells: int
    computed: int
    turns: tuple[int, int, int]  # a cell takes: median, 99 %, most
    cost: Cost
    exponents: tuple[float | None, ...] | None = None  # largest, per turn; None: not asked for


@dataclass(frozen=True)
class Study:
    """All speeds in order; the grid itself only where there is one speed."""

    speeds: list[Speed]
    grid: Basins | None
    cost: Cost

    @property
    def troubled(self) -> bool:
        """True where a cell's run ended in numerical trouble."""
        return any(speed.troubled for speed in self.speeds)


def study(
    system: System,
    rpms: Sequence[float],
    settings: Settings,
    question: Question,
    *,
    boundary: bool = False,
    exponents: bool = False,
    work: Work | None = None,
    on_cells: Callable[[int], None] = lambda cells: None,
) -> Study:
    """Basins at every speed, with attractors numbered alike from speed to speed.

    Raises ShardDone where this is one shard of many.
    """
    branches, speeds, grid, cost = Branches(), [], None, Cost()
    work, shared = work or Work(), False
    for k, rpm in enumerate(rpms):
        here = work.within(str(k))
        try:
            grid, census = basins(system, rpm, settings, question, work=here, on_cells=on_cells)
        except ShardDone:
            shared = True
            continue
        doubt = uncertainty(census, question.window) if boundary else None
        numbers = branches.number(grid.attractors, census)
        speed = _summary(grid, numbers, doubt, census.crew.cost)
        if exponents:
            found = [largest_exponent(system, rpm, settings, a) for a in speed.attractors]
            speed = replace(speed, exponents=tuple(found))
        speeds.append(speed)
        cost = cost + census.crew.cost
    if shared:
        raise ShardDone
    return Study(speeds, grid if len(rpms) == 1 else None, cost)


def _summary(grid: Basins, numbers: tuple[int, ...], doubt, cost: Cost) -> Speed:
    ranked = sorted(grid.turns[grid.turns > 0].tolist()) or [0]
    last = len(ranked) - 1
    return Speed(
        rpm=grid.rpm,
        attractors=grid.attractors,
        branches=numbers,
        regions=grid.regions,
        stays=grid.stays,
        fractions=grid.fractions,
        undecided=grid.undecided,
        troubled=grid.troubled,
        entropies=entropies(grid.codes),
        uncertainty=doubt,
        cells=grid.window.count,
        computed=grid.computed,
        turns=(ranked[last // 2], ranked[last * 99 // 100], ranked[last]),
        cost=cost,
    )
