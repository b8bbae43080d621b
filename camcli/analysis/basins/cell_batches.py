"""Blocks of starts at the strobe, through the kernel and over threads; no cell knows another."""

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.integrate import (
    USUAL_PORTIONS,
    Cost,
    Orbit,
    Record,
    Settings,
    Start,
    rounding_of,
)
from camcli.errors import Status, plural
from camcli.interrupts import raise_if_interrupted
from camcli.kernel import backend
from camcli.kernel.cells import CHATTERED_TURN, Cells, Point, Progress, Rest, Room, Targets, trouble
from camcli.kernel.contact_search import Tally
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import NEVER, RESTING, Earlier, State
from camcli.parallel import Codec, Work, stored
from camcli.piece_faults import PieceFault, attempt
from camcli.system import System, omega_of

BLOCK = 1024  # cells of one call; its arrays stay in the cache
LEAST = trouble(max(Status))  # the least outcome of a cell
FEW = 50  # cells below which plain Python is quicker than a compiler
FAILED = trouble(int(Status.FAULT))  # outcome of a cell


class BlockEnds(NamedTuple):
    """Where the cells of a block were left, a row each, and what they cost."""

    states: np.ndarray  # gap (m), rate (m/rad)
    outcomes: np.ndarray  # mode, outcome, turns, stay, symbol
    cost: list[int]  # the fields of `Cost`
    fault: PieceFault | None = None  # of the whole block


@dataclass(frozen=True)
class Ends:
    """Where cells were left: arrays with an entry per cell; m, m/rad."""

    gap: np.ndarray
    rate: np.ndarray
    mode: np.ndarray
    outcome: np.ndarray
    turns: np.ndarray
    stay: np.ndarray
    symbol: np.ndarray

    def states(self) -> np.ndarray:
        """Gap, rate and mode of each cell, (n, 3)."""
        return np.column_stack((self.gap, self.rate, self.mode))

    def replace_rows(self, cells: np.ndarray, others: "Ends") -> None:
        """Put the ends of some cells, followed again, in the places of these cells."""
        for name, column in vars(self).items():
            column[cells] = getattr(others, name)


@dataclass
class CellBatches:
    """One speed's constants and what runs cells on it; counts the work done."""

    system: System
    rpm: float
    settings: Settings
    work: Work = field(default_factory=Work)
    cost: Cost = field(default_factory=Cost)
    faults: list[PieceFault] = field(default_factory=list)  # of blocks
    block: int = BLOCK  # cells of one piece of work
    steps: int = USUAL_PORTIONS.compiled_steps  # of one call of the kernel

    @property
    def omega(self) -> float:
        """Angular speed of the cam, rad/s."""
        return omega_of(self.rpm)

    @property
    def lift(self) -> tuple[float, float]:
        """(c, c_theta) at the strobe; m, m/rad."""
        cam = self.system.cam
        strobe = cam.stretches[cam.strobe]
        return strobe.start_c, strobe.start_c1

    def states(self, q, v) -> tuple[np.ndarray, np.ndarray]:
        """(gap, rate) of positions (m) and velocities (m/s); a gap below zero is below the cam."""
        c, c1 = self.lift
        gap = np.asarray(q, dtype=float) - c
        gap = np.where(np.abs(gap) <= rounding_of(c), 0.0, gap)
        return gap, np.asarray(v, dtype=float) / self.omega - c1

    def passages(self, record: Record) -> np.ndarray:
        """(n, 2) states (gap, rate) at the strobes of a record."""
        return np.column_stack((record.strobe_q, record.strobe_w)) - np.array(self.lift)

    def start(self, gap: float, rate: float, mode: int) -> Start:
        """A state at the strobe as a start of `integrate.Orbit`."""
        c, c1 = self.lift
        state = None if mode == RESTING else (c + gap, c1 + rate)
        return Start.at_strobe(self.system, self.rpm, state)

    def record(self, orbit: Orbit, events: bool = True) -> Record:
        """The record of an orbit, whose work is counted here."""
        record = orbit.run(events=events)
        self.cost += record.cost
        return record

    def run(self, gap, rate, targets: Targets, budget: int, mode=None, share: bool = False) -> Ends:
        """Follow starts until a target or for `budget` turns; every gap must be >= 0.

        gap (m), rate (m/rad), mode (of the kernel, by default `mode_of`): of each start, (n,).
        share: whether the blocks of cells may be shared between shards. A block that raises what
        nobody foresaw has FAILED as the outcome of each cell. Raises ShardDone where the cells may
        be shared and this is one shard of many.
        """
        gap = np.asarray(gap, dtype=float)
        rate = np.asarray(rate, dtype=float)
        mode = mode_of(gap, rate) if mode is None else mode
        task = _Task(self.system, self.rpm, self.settings, targets, budget, len(gap), self.steps)
        slices = [slice(begin, begin + self.block) for begin in range(0, len(gap), self.block)]
        blocks = [(gap[cells], rate[cells], mode[cells]) for cells in slices]
        codec = Codec(  # how the ends of a block are kept on disk, and come back
            store=lambda ends: [ends.states, ends.outcomes, ends.cost],
            load=partial(_ends_of, targets),
            fits=lambda ends, block: len(ends.states) == len(block[0]),
            faults=lambda ends: () if ends.fault is None else (ends.fault,),
        )
        # the task's result for every block, in their order
        done: list[BlockEnds] = list(self.work.run(task, blocks, codec, share))
        for ends in done:
            self.cost += Cost(*ends.cost)
            if ends.fault is not None:
                self.faults.append(ends.fault)
        no_states = np.zeros((0, 2))
        no_outcomes = np.zeros((0, 5), np.int32)
        states = np.concatenate([no_states, *(ends.states for ends in done)])
        outcomes = np.concatenate([no_outcomes, *(ends.outcomes for ends in done)])
        gaps, rates = states.T
        modes, ends_at, turns, stays, symbols = outcomes.T
        return Ends(gaps, rates, modes, ends_at, turns, stays, symbols)


def mode_of(gap: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The kernel's mode of starts: free, or just bounced where they lie on the cam."""
    return np.where((gap > 0.0) | (rate < 0.0), FREE, BOUNCED)


@dataclass(frozen=True)
class _Task:
    """One block of cells, wherever it is followed."""

    system: System
    rpm: float
    settings: Settings
    targets: Targets
    budget: int
    count: int  # cells in all
    steps: int  # of one call of the kernel

    @cached_property
    def _tables(self):
        """(kernel, cam, const, flows over stretches, targets in the kernel's form)."""
        settings = self.settings
        kernel = backend.for_work(self.count, FEW)
        const = self.system.constants(self.rpm, settings.chatter_tolerance, settings.impact_budget)
        cam = self.system.cam_for(kernel)
        known = self.targets._replace(
            points=kernel.table(Point, self.targets.points),
            boxes=kernel.numbers(self.targets.boxes, int),
            stay=kernel.numbers(self.targets.stay, int),
            rests=kernel.table(Rest, self.targets.rests),
        )
        return kernel, cam, const, kernel.stretch_flows(cam, const), known

    def __call__(self, block) -> BlockEnds:
        """The ends of a block of cells; where it fails, they are FAILED where they began."""
        gap, rate, mode = (np.asarray(column) for column in block)
        place = f"{self.rpm:.10g} rpm, from {gap[0]:.10g} m above the cam on"
        name = f"{plural(len(gap), 'cell')} at {place}"
        followed = attempt(name, lambda: self._followed(gap, rate, mode))
        if not isinstance(followed, PieceFault):
            return followed
        outcomes = np.zeros((len(gap), 5), np.int32)
        outcomes[:, 0] = mode
        outcomes[:, 1] = FAILED
        return BlockEnds(np.column_stack((gap, rate)), outcomes, [0, 0, 0], followed)

    def _followed(self, gaps: np.ndarray, rates: np.ndarray, modes: np.ndarray) -> BlockEnds:
        """Follow a block of starts to their targets.

        The kernel writes where each cell is left over its start; a call does some steps of work and
        returns the cell at which the next one goes on.
        """
        kernel, cam, const, flows, targets = self._tables
        count = len(gaps)
        columns = (kernel.zeros(count, int) for _ in range(5))  # outcome to impacts
        cells = Cells(
            kernel.numbers(gaps.tolist()),
            kernel.numbers(rates.tolist()),
            kernel.numbers(modes.tolist(), int),
            *columns,
        )
        room = Room(
            states=kernel.room(State, 1),
            cell=kernel.room(Progress, 1),
            works=kernel.room(Tally, 1),
            log=kernel.log(0),
            strobe=kernel.strobe(1),
            earliers=kernel.table(Earlier, [Earlier(keep_in=NEVER)]),
        )
        begin = 0
        while begin < count:
            raise_if_interrupted()
            begin = kernel.settle_cells(
                cam, const, flows, targets, cells, begin, self.budget, self.steps, room
            )
        work = room.works[0]
        outcomes = (cells.mode, cells.outcome, cells.turns, cells.stay, cells.symbol)
        return BlockEnds(
            np.column_stack((cells.gap, cells.rate)),
            np.column_stack(outcomes).astype(np.int32),
            [int(sum(cells.impacts)), int(work.evaluations), int(work.crossings)],
        )


def _ends_of(targets: Targets, value: Any) -> BlockEnds:
    """What a `_Task` returned, read back; raises ValueError where it is something else."""
    states, outcomes, cost = stored.items(lambda part: part, 3)(value)
    states = stored.table(states, 2, "f")
    outcomes = stored.table(outcomes, 5, "i")
    cost = stored.items(stored.whole, 3)(cost)
    mode, outcome, turns, stay, symbol = outcomes.T
    if len(states) != len(outcomes):
        raise ValueError("expected as many states as outcomes")
    known = [point.attractor for point in targets.points] + [rest.end for rest in targets.rests]
    most = max([*known, len(targets.stay) - 1, max(targets.boxes, default=0) - 1])
    within = (
        (states[:, 0] >= 0.0, "gaps"),
        ((mode >= FREE) & (mode <= RESTING), "modes"),
        ((outcome >= LEAST) & (outcome <= most), "outcomes"),
        ((turns >= 0) & (stay >= 0), "turns"),
        (symbol >= CHATTERED_TURN, "symbols"),
    )
    for holds, what in within:
        if not holds.all():
            raise ValueError(f"expected other {what}")
    return BlockEnds(states, outcomes, cost)


# No attractor is known, and rests are of no interest.
NOTHING = Targets([], [], [], 0.0, 0.0, 0.0, 0.0, 0, 0, [], 0, 0.0)
