"""The attractors of one speed, found on the way: cells are followed, those that fit none looked at.

A start that meets no known attractor within its budget is undecided; some of these are then
identified, from where they were left, in the order of their states. A periodic orbit counts once
the solver has it, it attracts, and starts about it are seen to come back; an aperiodic one by
recurrence over a long record. Then the undecided are followed again. Which attractors are known
and what a cell is called depends on the set of starts alone, not on their order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from camcli.analysis.basins import recurrence
from camcli.analysis.basins.attractor import (
    APERIODIC,
    Attractor,
    begin_where_label_does,
    is_one,
    order,
)
from camcli.analysis.basins.cell_batches import NOTHING, Crew, Ends
from camcli.analysis.basins.decided_rests import follow_cells
from camcli.analysis.basins.region import Region, region_of, targets_of
from camcli.analysis.basins.rests import Rests
from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Orbit, with_turns
from camcli.analysis.orbits.identify import solve_from
from camcli.errors import Status
from camcli.kernel.cells import FORGOTTEN, UNDECIDED, Targets
from camcli.parallel import ShardDone

CHUNK = 1 << 17  # cells in memory with their states
SCOUTS = 10  # along each side of the window
SCOUT_TURNS = 200
INSEPARABLE = 1e-11  # radius, over the size, at which two regions are one
CANDIDATES = 16  # undecided states looked at in one round
ROUNDS = 64
SETTLE = 2_000  # turns before a period is looked for
RECORD = 32_768  # turns of an aperiodic record
TRIAL = 1_000  # turns of a trial from a box
BELOW = -9  # outcome of a cell below the cam; further ones are the kernel's


@dataclass
class Census:
    """Attractors of one speed in the order they were found, and what the kernel knows of them."""

    crew: Crew
    budget: int
    attractors: list[Attractor] = field(default_factory=list)
    regions: list[Region | None] = field(default_factory=list)
    targets: Targets = NOTHING
    boxes: recurrence.Boxes | None = None

    def __post_init__(self):
        self.rests = Rests(self.crew)
        if self.dissipates:
            self.targets = self.rests.fill(self.targets)

    @property
    def dissipates(self) -> bool:
        """False where nothing loses energy, so that no orbit attracts another."""
        follower = self.crew.system.follower
        return follower.restitution < 1.0 or follower.damping > 0.0

    def scout(self, window: Window) -> None:
        """Look for attractors from a few starts all over the window and from rest."""
        few = window.with_cells(SCOUTS, SCOUTS)
        q, v = few.centres(np.arange(few.count))
        c, c1 = self.crew.lift
        q, v = np.append(q, c), np.append(v, c1 * self.crew.omega)
        keep = q >= c
        self._settle(q[keep], v[keep], SCOUT_TURNS, lambda cells: None)

    def settle(
        self, q, v, on_cells: Callable[[int], None] = lambda cells: None, share: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """(outcome, turns) of starts: an index of `attractors`, BELOW, UNDECIDED or trouble.

        Raises ShardDone where the starts may be shared and this is one shard of many.
        """
        q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)
        gap, _ = self.crew.states(q, v)
        above = gap >= 0.0
        outcome = np.full(len(gap), BELOW, dtype=np.int16)
        turns = np.zeros(len(gap), dtype=np.int32)
        on_cells(len(gap) - int(above.sum()))
        budget = self.budget if self.dissipates else 1  # else there is nothing to meet
        outcome[above], turns[above] = self._settle(q[above], v[above], budget, on_cells, share)
        return outcome, turns

    def destination(self, q: float, v: float) -> Attractor | None:
        """The known attractor one start ends on, or None; nothing new is looked for."""
        gap, rate = self.crew.states([q], [v])
        ends = self._run(np.maximum(gap, 0.0), rate, self.budget)
        return self.attractors[ends.outcome[0]] if ends.outcome[0] >= 0 else None

    def _settle(self, q, v, budget: int, on_cells, share=False) -> tuple[np.ndarray, np.ndarray]:
        outcome = np.empty(len(q), dtype=np.int16)
        turns = np.empty(len(q), dtype=np.int32)
        left, states = [], []
        for begin in range(0, len(q), CHUNK):
            some = slice(begin, begin + CHUNK)
            begun = self.crew.states(q[some], v[some])
            try:
                ends = self._run(*begun, budget, share=share)
            except ShardDone:
                continue
            outcome[some], turns[some] = ends.outcome, ends.turns
            open_ = np.flatnonzero(ends.outcome == UNDECIDED)
            left.append(begin + open_)
            states.append(np.column_stack((ends.gap, ends.rate, ends.mode))[open_])
            on_cells(len(ends.gap))
        if share and self.crew.work.shard is not None:
            raise ShardDone
        if left:
            self._resolve(np.concatenate(left), np.concatenate(states), budget, outcome, turns)
        outcome[outcome == FORGOTTEN] = UNDECIDED
        return outcome, turns

    def _run(self, gap, rate, budget: int, mode=None, share: bool = False) -> Ends:
        """Follow starts, and those that stop at an unknown rest again once that is known."""
        return follow_cells(self, gap, rate, budget, mode, share)

    def _resolve(self, cells, states, budget: int, outcome, turns) -> None:
        """Identify attractors from undecided states and follow these on, until nothing is new."""
        for _ in range(ROUNDS):
            if len(cells) == 0 or not self._discover(states):
                return
            ends = self._run(states[:, 0], states[:, 1], budget, states[:, 2].astype(np.int64))
            outcome[cells] = ends.outcome
            turns[cells] += ends.turns.astype(np.int32)
            open_ = ends.outcome == UNDECIDED
            cells = cells[open_]
            states = np.column_stack((ends.gap, ends.rate, ends.mode))[open_]

    def _discover(self, states: np.ndarray) -> bool:
        """Look at some of the states in their own order; True once something new is known."""
        if not self.dissipates:
            return False
        ranked = np.unique(states, axis=0)
        count = min(CANDIDATES, len(ranked))
        picks = [k * (len(ranked) - 1) // max(1, count - 1) for k in range(count)]
        return any(self._identify(*ranked[k].tolist()) for k in dict.fromkeys(picks))

    def _identify(self, gap: float, rate: float, mode: float) -> bool:
        crew = self.crew
        settings = with_turns(crew.settings, SETTLE, 1)
        found = solve_from(crew.system, crew.rpm, settings, crew.start(gap, rate, int(mode)))
        if found is None:
            return self._recognise(gap, rate, int(mode))
        if not found.stable or found.verdict != "admissible":
            return False
        states, symbols = begin_where_label_does(tuple(found.states), tuple(found.symbols))
        return self._admit(Attractor(found.label, found.turns, states, symbols, found.multipliers))

    def _admit(self, attractor: Attractor) -> bool:
        """Take up a periodic attractor unless it is known or starts about it do not come back."""
        if any(is_one(attractor, known) for known in self.attractors):
            return False
        region = region_of(self.crew, attractor)
        if region is None:
            return False
        parted = _parted([*self.regions, region])
        if parted is None:
            return False
        self.attractors.append(attractor)
        self.regions = parted
        self._rebuild()
        return True

    def _recognise(self, gap: float, rate: float, mode: int) -> bool:
        """Take up an aperiodic attractor, or add to a known one, from a long record."""
        crew = self.crew
        ends = crew.run([gap], [rate], self.targets, RECORD, [mode])
        if ends.outcome[0] != UNDECIDED:
            return False
        settings = with_turns(crew.settings, 0, RECORD)
        start = crew.start(float(ends.gap[0]), float(ends.rate[0]), int(ends.mode[0]))
        tape = Orbit(crew.system, crew.rpm, settings, start).run(events=False)
        n = tape.periods
        points = np.column_stack((tape.strobe_q[:n], tape.strobe_w[:n]))
        points = points - np.array(crew.lift)
        if tape.status != Status.OK or not recurrence.is_recurrent(points):
            return False
        return self._take_up(points)

    def _take_up(self, points: np.ndarray) -> bool:
        """Add an aperiodic record, joined to the attractors whose boxes it meets."""
        lift = np.array(self.crew.lift)
        before = list(self.attractors), list(self.regions), self.boxes, self.targets
        for k, known in enumerate(self.attractors):
            if not known.periodic and recurrence.meet(known.points - lift, points):
                self.attractors[k] = _aperiodic(np.concatenate((known.points - lift, points)), lift)
                break
        else:
            self.attractors.append(_aperiodic(points, lift))
            self.regions.append(None)
        self._rebuild()
        if max(self.boxes.stays[k] for k in self._aperiodic()) > recurrence.MOST_STAY:
            self.attractors, self.regions, self.boxes, self.targets = before
            return False
        return True

    def _aperiodic(self) -> list[int]:
        return [k for k, a in enumerate(self.attractors) if not a.periodic]

    def _rebuild(self) -> None:
        """The kernel's table of all that is known."""
        aperiodic = self._aperiodic()
        self.boxes = None
        if aperiodic:
            lift = np.array(self.crew.lift)
            records = {k: self.attractors[k].points - lift for k in aperiodic}
            self.boxes = recurrence.boxes_of(records, self.regions, len(self.attractors))
            self._try_boxes()
        self.targets = self.rests.fill(targets_of(self.regions, self.boxes))

    def _try_boxes(self) -> None:
        """Follow a start from every box, to learn how long a stay in the boxes decides."""
        boxes = self.boxes
        boxes.stays = [1 << 40] * len(self.attractors)
        tried = np.flatnonzero(boxes.owner)
        centres = boxes.grid.centres(tried)
        ends = self.crew.run(*centres.T, targets_of(self.regions, boxes), TRIAL)
        at = boxes.owner[boxes.grid.boxes(np.column_stack((ends.gap, ends.rate)))]
        ended = np.where(ends.outcome == UNDECIDED, at, 0)
        ended = np.where((ends.outcome == UNDECIDED) & (at == 0), boxes.owner[tried], ended)
        boxes.stays = recurrence.stays_of(boxes, tried, ended, ends.stay)

    def ranks(self) -> np.ndarray:
        """Number (1, 2, ...) of each attractor in the order that does not depend on the search."""
        ranked = sorted(range(len(self.attractors)), key=lambda k: order(self.attractors[k]))
        numbers = np.zeros(len(ranked), dtype=np.int16)
        numbers[ranked] = np.arange(1, len(ranked) + 1)
        return numbers


def _aperiodic(points: np.ndarray, lift: np.ndarray) -> Attractor:
    """An aperiodic attractor; the state it is listed with is its lowest."""
    states = points + lift
    lowest = min(map(tuple, states.tolist()))
    return Attractor(APERIODIC, 0, (lowest,), points=states)


def _parted(regions: list[Region | None]) -> list[Region | None] | None:
    """The regions, the last and those it overlaps shrunk until apart; None where they stay one."""
    regions = list(regions)
    for k, other in enumerate(regions[:-1]):
        while other is not None and overlap(other, regions[-1]):
            other, regions[-1] = other.scaled(0.5), regions[-1].scaled(0.5)
            if min(other.radius, regions[-1].radius) < INSEPARABLE:
                return None
            regions[k] = other
    return regions


def overlap(a: Region, b: Region) -> bool:
    """True where the boxes around two regions' ellipses meet."""
    apart = np.abs(a.points[:, None, :] - b.points[None, :, :])
    reach = a.half_widths()[:, None, :] + b.half_widths()[None, :, :]
    return bool((apart <= reach).all(axis=2).any())
