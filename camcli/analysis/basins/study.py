"""Basins of attraction at one speed or over a range of them: which attractor every start lands on.

The centre of every cell is followed to its end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, nan

import numpy as np

from camcli.analysis.after_rest import After
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import BELOW, AttractorFinder
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.basins.measures import Uncertainty, entropies, fractions, uncertainty
from camcli.analysis.basins.refinement import Refined, refine
from camcli.analysis.basins.region import CaptureRegion
from camcli.analysis.basins.saddles import BoundarySaddle, boundary_saddles
from camcli.analysis.basins.window import Window
from camcli.analysis.exponents import of_multiplier, of_record
from camcli.analysis.integrate import AtSpeeds, Cost, Orbit, Settings, Setup, Start, with_turns
from camcli.errors import Status
from camcli.kernel.cells import UNDECIDED
from camcli.parallel import ShardDone, Work
from camcli.piece_faults import PieceFault, attempt, piece
from camcli.system import System

# Codes of cells: 1, 2, ... the attractors; and
UNDECIDED_CODE, BELOW_CODE = 0, -1  # kernel statuses (2, 3, 4) with a minus sign are trouble
EXPONENT_RECORD = 4000  # turns of an aperiodic attractor
WINDOWS = 3  # speeds whose cells are kept, to be drawn beside one another
SAME_BRANCH = 0.3  # of an orbit's size: states of one attractor at neighbouring speeds are nearer
THINNED = 400  # states of an aperiodic attractor compared


@dataclass(frozen=True)
class BasinsQuestion:
    """What basins are asked for at every speed: a window of starts, turns to follow one, cuts."""

    window: Window
    budget: int = 4000
    refine: int = 0


@dataclass(frozen=True)
class Basins:
    """Basins at one speed: a code per cell, row by row in v, and the attractors by number.

    With refinement `window` has the finest cells, `codes` are filled from the coarser ones, and
    `level` says at which level each was computed (0: the coarsest).
    """

    rpm: float
    cam_q: float  # of the cam at the strobe, m
    window: Window
    codes: np.ndarray  # (nv, nq) int16; empty where there are more than WINDOWS speeds
    level: np.ndarray | None
    attractors: tuple[Attractor, ...]  # attractor k has code k + 1
    regions: tuple[CaptureRegion | None, ...]
    stays: tuple[int, ...]  # turns in its boxes that decide, for aperiodic attractors
    fractions: dict[int, tuple[float, float]]  # (fraction, standard error) by code
    undecided: int  # cells that met no attractor within the budget
    troubled: dict[int, int]  # number of cells by kernel status, where it is not ok
    entropies: dict[str, float | int]
    computed: int  # cells that were followed
    turns: tuple[int, int, int]  # a cell takes: median, 99 %, most
    cost: Cost
    branches: tuple[int, ...] = ()  # number of each attractor that stays from speed to speed
    uncertainty: Uncertainty | None = None
    exponents: tuple[float | None, ...] | None = None  # largest, per turn; None: not asked for
    rests: tuple[tuple[float, After], ...] = ()  # departures (rad) that doubles could not follow
    value: float = 0.0  # the speed (rpm), or that of what is varied instead
    faults: tuple[PieceFault, ...] = ()  # what cost blocks of cells, or the whole speed
    saddles: tuple[BoundarySaddle, ...] | None = None  # on the boundaries; None: not asked for

    @property
    def cells(self) -> int:
        """Number of cells of the window."""
        return self.window.count


@dataclass(frozen=True)
class Study:
    """All speeds in order."""

    speeds: tuple[Basins, ...]
    cost: Cost

    @property
    def grids(self) -> tuple[Basins, ...]:
        """The speeds, where they are few enough to have their cells."""
        return self.speeds if len(self.speeds) <= WINDOWS else ()

    @property
    def troubled(self) -> bool:
        """True where a cell's run ended in numerical trouble."""
        return any(speed.troubled for speed in self.speeds)


def study(
    system: System,
    values: Sequence[float],
    settings: Settings,
    question: BasinsQuestion,
    *,
    setup: Callable[[float], Setup] | None = None,
    boundary: bool = False,
    exponents: bool = False,
    saddles: bool = False,
    work: Work | None = None,
    on_cells: Callable[[int], None] = lambda cells: None,
    key: str = "rpm",
) -> Study:
    """Basins at every speed, with attractors numbered alike from speed to speed.

    The values are speeds (rpm), or what `setup` makes machines of. `boundary`, `exponents` and
    `saddles` ask for the uncertainty exponent, for Lyapunov exponents and for the saddles on the
    boundaries; `on_cells` is told of finished cells; key: of what is varied. A value that raises
    what nobody foresaw has no attractors, and cells of the status FAULT. Raises ShardDone where
    this is one shard of many.
    """
    work = work or Work()
    more = _More(Branches(), key, boundary, saddles, exponents)
    setup = setup or AtSpeeds(system, settings)
    speeds: list[Basins] = []
    is_shared = False

    def basins_at(value: float, work_here: Work) -> Basins:
        """The basins at one value; work_here: the work under the name of this value."""
        varied, rpm, runs = setup(value)
        speed, finder = basins(varied, rpm, runs, question, work=work_here, on_cells=on_cells)
        return more.answered(replace(speed, value=value), finder, question.window)

    for k, value in enumerate(values):
        try:
            result = attempt(f"{key} = {value!r}", partial(basins_at, value, work.within(str(k))))
        except ShardDone:
            is_shared = True
            continue
        if isinstance(result, PieceFault):
            speed = _failed(question, value, value if key == "rpm" else nan, result)
            speed = replace(
                speed, saddles=() if saddles else None, exponents=() if exponents else None
            )
        else:
            speed = result
        if len(values) > WINDOWS:
            speed = replace(speed, codes=speed.codes[:0], level=None)
        speeds.append(speed)
    if is_shared:
        raise ShardDone
    return Study(tuple(speeds), sum((speed.cost for speed in speeds), Cost()))


@dataclass(frozen=True)
class _More:
    """What is asked beside the cells at every speed; see `study`."""

    branches: Branches
    key: str
    boundary: bool
    saddles: bool
    exponents: bool

    def answered(self, speed: Basins, finder: AttractorFinder, window: Window) -> Basins:
        """The basins of one speed with the answers; each is a piece that may fail alone.

        Attractors are numbered after the boundary, which may find more of them, and the cost is
        read at the end. window: as it was asked for, without refinement.
        """
        name = f"{self.key} = {speed.value!r}"
        batches = finder.batches
        if self.boundary:
            measure = partial(uncertainty, finder, window)
            speed = replace(speed, uncertainty=piece(f"the boundary at {name}", measure))
        speed = replace(speed, branches=self.branches.number(speed.attractors, finder))
        if self.saddles:
            search = partial(boundary_saddles, finder, speed.window, speed.codes)
            speed = replace(speed, saddles=tuple(piece(f"the saddles at {name}", search, [])))
        if self.exponents:
            exponents = []
            for attractor in speed.attractors:
                ask = partial(largest_exponent, batches, attractor)
                exponents.append(piece(f"the exponent of {attractor.label} at {name}", ask))
            speed = replace(speed, exponents=tuple(exponents))
        return replace(speed, cost=batches.cost, faults=tuple(batches.faults))


def _failed(question: BasinsQuestion, value: float, rpm: float, fault: PieceFault) -> Basins:
    """Basins of which nothing is known."""
    status = int(Status.FAULT)
    window = question.window.halved(question.refine)
    codes = np.full((window.nv, window.nq), -status, np.int16)
    return Basins(
        rpm=rpm,
        cam_q=nan,
        window=window,
        codes=codes,
        level=np.zeros(codes.shape, np.uint8) if question.refine else None,
        attractors=(),
        regions=(),
        stays=(),
        fractions={-status: (1.0, 0.0)},
        undecided=0,
        troubled={status: window.count},
        entropies=entropies(codes),
        computed=0,
        turns=(0, 0, 0),
        cost=Cost(),
        value=value,
        faults=(fault,),
    )


def basins(
    system: System,
    rpm: float,
    settings: Settings,
    question: BasinsQuestion,
    *,
    work: Work | None = None,
    on_cells: Callable[[int], None] = lambda cells: None,
) -> tuple[Basins, AttractorFinder]:
    """(basins of one speed, the finder for further questions at it)."""
    batches = CellBatches(system, rpm, settings, work or Work())
    finder = AttractorFinder(batches, question.budget)
    finder.look_around(question.window)
    if question.refine:
        refined = refine(finder, question.window, question.refine, on_cells)
    else:
        window = question.window
        cells = np.arange(window.count)
        outcome, turns = finder.settle(*window.centres(cells), on_cells, share=True)
        refined = Refined(window, outcome, None, turns, window.count)
    window = refined.window
    codes = codes_of(finder, refined.outcome).reshape(window.nv, window.nq)
    in_order = np.argsort(finder.ranks(), kind="stable").tolist()  # index of attractor 1, 2, ...
    stays = finder.boxes.stays if finder.boxes else [0] * len(in_order)
    trouble, counts = np.unique(codes[codes < BELOW_CODE], return_counts=True)
    turns_taken = sorted(refined.turns[refined.turns > 0].tolist()) or [0]
    last = len(turns_taken) - 1
    result = Basins(
        rpm=rpm,
        cam_q=batches.lift[0],
        window=window,
        codes=codes,
        level=refined.level,
        attractors=tuple(finder.attractors[k] for k in in_order),
        regions=tuple(finder.regions[k] for k in in_order),
        stays=tuple(stays[k] for k in in_order),
        fractions=fractions(codes, [*range(1, len(in_order) + 1)]),
        undecided=int((codes == UNDECIDED_CODE).sum()),
        troubled={-int(code): int(n) for code, n in zip(trouble, counts, strict=True)},
        entropies=entropies(codes),
        computed=refined.computed,
        turns=(turns_taken[last // 2], turns_taken[last * 99 // 100], turns_taken[last]),
        cost=batches.cost,
        rests=finder.rests.decided,
    )
    return result, finder


def codes_of(finder: AttractorFinder, outcome: np.ndarray) -> np.ndarray:
    """The code of each outcome: 1, 2, ... for attractors by their final number.

    UNDECIDED_CODE and BELOW_CODE for what these say; trouble, an outcome of -10 - status, becomes
    -status.
    """
    numbers = np.append(finder.ranks(), np.int16(0))  # the last one is never used
    of_attractor = numbers[np.clip(outcome, 0, len(numbers) - 1)]
    codes = np.where(outcome >= 0, of_attractor, outcome + 10)
    codes = np.where(outcome == UNDECIDED, UNDECIDED_CODE, codes)
    return np.where(outcome == BELOW, BELOW_CODE, codes).astype(np.int16)


def largest_exponent(batches: CellBatches, attractor: Attractor) -> float | None:
    """Largest Lyapunov exponent per turn: ln |multiplier|/m, or from a record; -inf after a rest.

    None where a record shows too little.
    """
    if attractor.multipliers is not None:
        return of_multiplier(attractor.multipliers[0], attractor.turns)
    if attractor.periodic:
        return -inf
    system = batches.system
    rpm = batches.rpm
    start = Start.at_strobe(system, rpm, attractor.states[0])
    settings = with_turns(batches.settings, 0, EXPONENT_RECORD)
    record = batches.record(Orbit(system, rpm, settings, start))
    exponents = of_record(system, rpm, record) if record.status == Status.OK else None
    return None if exponents is None else exponents.largest


# --- from speed to speed


@dataclass
class Branches:
    """Attractors matched from speed to speed: a number stays with one as the speed changes.

    First by state: of one label, each the nearest to the other, and near. Then by motion: each,
    started at the other's speed, ends on the other. What is left begins a branch of its own.
    `last` is the last known attractor of every branch; branch n is entry n - 1.
    """

    last: list[Attractor] = field(default_factory=list)
    present: list[int] = field(default_factory=list)  # branches at the speed before
    before: AttractorFinder | None = None

    def number(self, attractors: tuple[Attractor, ...], finder: AttractorFinder) -> tuple[int, ...]:
        """The branch of each attractor of the next speed, counted from 1; finder: of that speed."""
        branch_of = self._by_state(attractors)
        branch_of = self._by_motion(attractors, finder, branch_of)
        for k, attractor in enumerate(attractors):
            if k not in branch_of:
                self.last.append(attractor)
                branch_of[k] = len(self.last) - 1
            self.last[branch_of[k]] = attractor
        self.present = sorted(branch_of.values())
        self.before = finder
        return tuple(branch_of[k] + 1 for k in range(len(attractors)))

    def _by_state(self, attractors: Sequence[Attractor]) -> dict[int, int]:
        """Which branch each attractor goes on, by its states: {attractor's index: branch's index}.

        A pair of the same label counts where each is the other's nearest, within SAME_BRANCH.
        """
        if not self.last:
            return {}
        far = np.full((len(attractors), len(self.last)), np.inf)
        for k, new in enumerate(attractors):
            for n, old in enumerate(self.last):
                if new.label == old.label:
                    far[k, n] = distance(new, old)
        pairs = ((k, int(far[k].argmin())) for k in range(len(attractors)))
        return {k: n for k, n in pairs if far[k, n] <= SAME_BRANCH and int(far[:, n].argmin()) == k}

    def _by_motion(
        self, attractors: Sequence[Attractor], finder: AttractorFinder, branch_of: dict[int, int]
    ) -> dict[int, int]:
        """`branch_of`, as of `_by_state`, with those that motions match added.

        The last attractor of an unmatched branch, started at the next speed, has to end on one that
        is unmatched too, and that one, started at the speed before, on the first.
        """
        branch_of = dict(branch_of)
        before = self.before
        for n in self.present:
            if n in branch_of.values() or before is None:
                continue
            old = self.last[n]
            new = carried(old, before, finder)
            k = next((k for k, attractor in enumerate(attractors) if attractor is new), None)
            if k is None or k in branch_of:
                continue
            if carried(attractors[k], finder, before) is old:
                branch_of[k] = n
        return branch_of


def carried(
    attractor: Attractor, finder: AttractorFinder, other: AttractorFinder
) -> Attractor | None:
    """The attractor of another speed on which this one's state ends, velocity kept.

    finder, other: of this one's speed, and of the other. None where it ends on none that is known.
    """
    q, w = attractor.states[0]
    return other.destination(q, w * finder.batches.omega)


def distance(a: Attractor, b: Attractor) -> float:
    """Largest distance from a state of one to the nearest of the other, over the orbit's size.

    That is the Hausdorff distance of the two sets of states; of many states some are taken.
    """
    states_a = _thin(a.shown())
    states_b = _thin(b.shown())
    apart = np.abs(states_a[:, None, :] - states_b[None, :, :]).max(axis=2)  # of every pair
    from_a = apart.min(axis=1).max()
    from_b = apart.min(axis=0).max()
    return float(max(from_b, from_a) / max(a.size, b.size))


def _thin(points: np.ndarray) -> np.ndarray:
    return points[:: max(1, len(points) // THINNED)]
