"""Blocks of starts at the strobe, through the kernel and over threads; no cell knows another."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from threading import RLock
from time import perf_counter

import numpy as np

from camcli.analysis.integrate import Cost, Settings, Start, _turns, compile_for
from camcli.kernel import backend, entry_points
from camcli.kernel.cam_table import ROW, START0, START1
from camcli.kernel.cells import CELL, MODE_OF, OUTCOME, STAY, SYMBOL, TURNS, Cells, Room, Targets
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.orbit_loop import RESTING, Log, Strobe
from camcli.parallel import Codec, Work
from camcli.system import System, omega_of

BLOCK = 1024  # cells of one call; its arrays stay in the cache
FEW = 50  # cells below which plain Python is quicker than a compiler
_warm = False  # True once numba has compiled the entry, or read it from its cache
_warming = RLock()


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
class Crew:
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
        row = cam.strobe * ROW
        return cam.rows[row + START0], cam.rows[row + START1]

    @cached_property
    def lane(self):
        """The kernel's constants of this speed."""
        return self.system.lane(
            self.rpm, self.settings.chatter_tolerance, self.settings.impact_budget
        )

    def states(self, q, v) -> tuple[np.ndarray, np.ndarray]:
        """(gap, rate) of positions (m) and velocities (m/s); a gap below zero is below the cam."""
        c, c1 = self.lift
        return np.asarray(q, dtype=float) - c, np.asarray(v, dtype=float) / self.omega - c1

    def start(self, gap: float, rate: float, mode: int) -> Start:
        """A state at the strobe as a start of `engine.Orbit`."""
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
        compiled = backend.is_compiled() or (len(gap) > FEW and backend.may_compile())
        task = _Task(self.system, self.rpm, self.settings, targets, budget, compiled)
        slices = [slice(begin, begin + BLOCK) for begin in range(0, len(gap), BLOCK)]
        blocks = [(gap[some], rate[some], mode[some]) for some in slices]
        if compiled:
            _compile(self.system)
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
    compiled: bool

    @cached_property
    def _tables(self):
        """(lane, flows over stretches, targets) as the kernel runs now."""
        settings = self.settings
        lane = self.system.lane(self.rpm, settings.chatter_tolerance, settings.impact_budget)
        return lane, _turns(self.system, lane), _native(self.targets)

    def __call__(self, block) -> tuple[np.ndarray, np.ndarray, list[int]]:
        """(gap and rate, `Cells.whole`, (impacts, turns, evaluations, crossings)) of a block."""
        if self.compiled:
            _compile(self.system)
        lane, turns, known = self._tables
        cells, room = _cells(*block), _room()
        entry_points.settle_cells(
            self.system.native_cam(), lane, turns, known, cells, self.budget, room
        )
        return (
            np.asarray(cells.real, dtype=float).reshape(-1, 2),
            np.asarray(cells.whole, dtype=np.int64).reshape(-1, CELL).astype(np.int32),
            [int(room.tally[0]), int(room.tally[1]), int(room.work[0]), int(room.work[1])],
        )


def _compile(system: System) -> None:
    """Compile the kernel, and have numba do this entry now, so that its time is known."""
    global _warm
    if backend.is_compiled() and _warm:
        return
    with _warming:
        compile_for(system)
        backend.announce("settle_cells")
        if _warm:
            return
        began, _warm = perf_counter(), True
        Crew(system, 600.0, Settings(0, 1, 1e-3, 100)).run([1.0], [0.0], NOTHING, 1)
        backend.compile_seconds += perf_counter() - began


def _native(targets: Targets) -> Targets:
    """The targets in the form of the kernel as it runs now."""
    return targets._replace(
        real=backend.numbers(list(targets.real)),
        whole=backend.numbers(list(targets.whole), int),
        boxes=backend.numbers(targets.boxes, int),
        stay=backend.numbers(list(targets.stay), int),
        rest=backend.numbers(list(targets.rest)),
        ends=backend.numbers(list(targets.ends), int),
        near=backend.numbers(list(targets.near)),
    )


def _cells(gap, rate, mode) -> Cells:
    real = np.column_stack((gap, rate)).ravel()
    whole = np.zeros((len(gap), CELL), dtype=np.int64)
    whole[:, MODE_OF] = mode
    whole = whole.ravel()
    if not backend.is_compiled():
        return Cells(real.tolist(), whole.tolist(), len(gap))
    return Cells(real, whole, len(gap))


def _room() -> Room:
    log = Log(backend.zeros(0, int), backend.zeros(0), 0)
    strobe = Strobe(backend.zeros(2), backend.zeros(2, int), 1)
    return Room(
        backend.zeros(3), backend.zeros(9, int), log, strobe, backend.zeros(3, int),
        backend.zeros(2, int),
    )  # fmt: skip


# No attractor is known, and rests are of no interest.
NOTHING = Targets([], [], 0, [], [], 0.0, 0.0, 0.0, 0.0, 0, 0, [], [], -1, [0.0, 0.0])
