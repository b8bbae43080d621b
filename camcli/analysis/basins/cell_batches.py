"""Blocks of starts at the strobe, through the kernel and over threads; no cell knows another."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from camcli.analysis.integrate import Cost, Settings, Start
from camcli.kernel import backend
from camcli.kernel.backend import Kernel
from camcli.kernel.cells import CELL, MODE_OF, OUTCOME, STAY, SYMBOL, TURNS, Cells, Room, Targets
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import RESTING, Log, Strobe
from camcli.parallel import Codec, Work
from camcli.system import System, omega_of

BLOCK = 1024  # cells of one call; its arrays stay in the cache
FEW = 50  # cells below which plain Python is quicker than a compiler


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


@dataclass
class CellBatches:
    """One speed's constants and what runs cells on it; counts the work done."""

    system: System
    rpm: float
    settings: Settings
    work: Work = field(default_factory=Work)
    cost: Cost = field(default_factory=Cost)
    turns: int = 0

    @property
    def omega(self) -> float:
        """rad/s."""
        return omega_of(self.rpm)

    @property
    def lift(self) -> tuple[float, float]:
        """(c, c_theta) at the strobe; m, m/rad."""
        cam = self.system.cam
        strobe = cam.stretches[cam.strobe]
        return strobe.start_c, strobe.start_c1

    @cached_property
    def lane(self):
        """The kernel's constants of this speed."""
        return self.system.constants(
            self.rpm, self.settings.chatter_tolerance, self.settings.impact_budget
        )

    def states(self, q, v) -> tuple[np.ndarray, np.ndarray]:
        """(gap, rate) of positions (m) and velocities (m/s); a gap below zero is below the cam."""
        c, c1 = self.lift
        return np.asarray(q, dtype=float) - c, np.asarray(v, dtype=float) / self.omega - c1

    def start(self, gap: float, rate: float, mode: int) -> Start:
        """A state at the strobe as a start of `integrate.Orbit`."""
        theta_deg = self.system.strobe * (180.0 / np.pi)
        if mode == RESTING:
            return Start(None, None, theta_deg)
        c, c1 = self.lift
        return Start(c + gap, (c1 + rate) * self.omega, theta_deg)

    def run(self, gap, rate, targets: Targets, budget: int, mode=None, share: bool = False) -> Ends:
        """Follow starts until a target or for `budget` turns; every gap must be >= 0.

        Raises ShardDone where the cells may be shared and this is one shard of many.
        """
        gap, rate = np.asarray(gap, dtype=float), np.asarray(rate, dtype=float)
        if mode is None:
            mode = np.where((gap > 0.0) | (rate < 0.0), FREE, BOUNCED)
        task = _Task(self.system, self.rpm, self.settings, targets, budget, len(gap))
        slices = [slice(begin, begin + BLOCK) for begin in range(0, len(gap), BLOCK)]
        blocks = [(gap[some], rate[some], mode[some]) for some in slices]
        done = list(self.work.run(task, blocks, PLAIN, share))
        tally = [sum(part[2][k] for part in done) for k in range(4)]
        self.cost += Cost(tally[0], tally[2], tally[3])
        self.turns += tally[1]
        real = np.concatenate([part[0] for part in done]) if done else np.zeros((0, 2))
        whole = np.concatenate([part[1] for part in done]) if done else np.zeros((0, CELL), int)
        columns = (whole[:, k] for k in (MODE_OF, OUTCOME, TURNS, STAY, SYMBOL))
        return Ends(real[:, 0], real[:, 1], *columns)


PLAIN = Codec(lambda result: result, lambda stored: stored)


@dataclass(frozen=True)
class _Task:
    """One block of cells, wherever it is followed."""

    system: System
    rpm: float
    settings: Settings
    targets: Targets
    budget: int
    count: int  # cells in all

    @cached_property
    def _tables(self):
        """(kernel, cam, lane, flows over stretches, targets in the kernel's form)."""
        settings, kernel = self.settings, backend.for_work(self.count, FEW)
        lane = self.system.constants(self.rpm, settings.chatter_tolerance, settings.impact_budget)
        cam = self.system.cam_for(kernel)
        return kernel, cam, lane, kernel.stretch_flows(cam, lane), _native(self.targets, kernel)

    def __call__(self, block) -> tuple[np.ndarray, np.ndarray, list[int]]:
        """(gap and rate, `Cells.whole`, (impacts, turns, evaluations, crossings)) of a block."""
        kernel, cam, lane, flows, known = self._tables
        gap, rate, mode = block
        whole = np.zeros((len(gap), CELL), dtype=np.int64)
        whole[:, MODE_OF] = mode
        real = kernel.numbers(np.column_stack((gap, rate)).ravel())
        cells, room = Cells(real, kernel.numbers(whole.ravel(), int), len(gap)), _room(kernel)
        kernel.settle_cells(cam, lane, flows, known, cells, self.budget, room)
        return (
            np.asarray(cells.real, dtype=float).reshape(-1, 2),
            np.asarray(cells.whole, dtype=np.int64).reshape(-1, CELL).astype(np.int32),
            [int(room.tally[0]), int(room.tally[1]), int(room.work[0]), int(room.work[1])],
        )


def _native(targets: Targets, kernel: Kernel) -> Targets:
    """The targets in the form of this kernel."""
    return targets._replace(
        real=kernel.numbers(list(targets.real)),
        whole=kernel.numbers(list(targets.whole), int),
        boxes=kernel.numbers(targets.boxes, int),
        stay=kernel.numbers(list(targets.stay), int),
        rest=kernel.numbers(list(targets.rest)),
        ends=kernel.numbers(list(targets.ends), int),
        near=kernel.numbers(list(targets.near)),
    )


def _room(kernel: Kernel) -> Room:
    log = Log(kernel.zeros(0, int), kernel.zeros(0), 0)
    strobe = Strobe(kernel.zeros(2), kernel.zeros(2, int), 1)
    return Room(
        kernel.zeros(3), kernel.zeros(9, int), log, strobe, kernel.zeros(3, int),
        kernel.zeros(2, int),
    )  # fmt: skip


# No attractor is known, and rests are of no interest.
NOTHING = Targets([], [], 0, [], [], 0.0, 0.0, 0.0, 0.0, 0, 0, [], [], -1, [0.0, 0.0])
