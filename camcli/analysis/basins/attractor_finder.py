"""The attractors of one speed, found on the way: cells are followed, those that fit none looked at.

A start that meets no known attractor within its budget is undecided; some of these are then
identified, from where they were left, in the order of their states. A periodic orbit counts once
the solver has it, it attracts, and starts about it are seen to come back; an aperiodic one by
recurrence over a long record. Then the undecided are followed again. Which attractors are known
and what a cell is called depends on the set of starts alone, not on their order.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from camcli.analysis.basins import recurrence
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches, Ends, mode_of
from camcli.analysis.basins.region import CaptureRegion, parted, region_of, targets_of
from camcli.analysis.basins.rest_outcomes import RestOutcomes
from camcli.analysis.basins.window import Window
from camcli.analysis.integrate import Orbit, Start, with_turns
from camcli.analysis.labels import FEWEST_TURNS, LONGEST_PERIOD
from camcli.analysis.orbits.identify import identify
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.errors import Status
from camcli.kernel.cells import FORGOTTEN, NEW_REST, UNDECIDED, Targets
from camcli.parallel import ShardDone

CHUNK = 1 << 17  # cells in memory with their states
FIRST_STARTS = 10  # along each side of the window
FIRST_TURNS = 200
CANDIDATES = 16  # undecided states looked at in one round
ROUNDS = 64
ATTRACTOR_SETTLE = 2_000  # turns before a period is looked for
APERIODIC_TURNS = 32_768  # turns of an aperiodic record
TRIAL = 1_000  # turns of a trial from a box
BELOW = -9  # outcome of a cell below the cam; further ones are the kernel's


@dataclass
class AttractorFinder:
    """Attractors of one speed in the order they were found, and what the kernel knows of them."""

    batches: CellBatches
    budget: int
    attractors: list[Attractor] = field(default_factory=list)
    regions: list[CaptureRegion | None] = field(default_factory=list)
    targets: Targets = NOTHING
    boxes: recurrence.Boxes | None = None
    chunk: int = CHUNK  # cells in memory with their states
    aperiodic_turns: int = APERIODIC_TURNS  # of a record that may be aperiodic

    def __post_init__(self):
        self.rests = RestOutcomes(self)
        if self.dissipates:
            self.targets = self.rests.fill(self.targets)

    @property
    def dissipates(self) -> bool:
        """False where nothing loses energy, so that no orbit attracts another."""
        follower = self.batches.system.follower
        return follower.restitution < 1.0 or follower.damping > 0.0

    def look_around(self, window: Window) -> None:
        """Look for attractors from a few starts all over the window and from rest."""
        few = window.with_cells(FIRST_STARTS, FIRST_STARTS)
        q, v = few.centres(np.arange(few.count))
        c, c1 = self.batches.lift
        q = np.append(q, c)
        v = np.append(v, c1 * self.batches.omega)
        above = q >= c
        self._settle(q[above], v[above], FIRST_TURNS, lambda cells: None)

    def settle(
        self, q, v, on_cells: Callable[[int], None] = lambda cells: None, share: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """(outcome, turns) of starts: an index of `attractors`, BELOW, UNDECIDED or trouble.

        q, v: position (m) and velocity (m/s) of each start, (n,). on_cells is told how many more
        are done. share: whether the starts may be shared between shards; raises ShardDone where
        they may and this is one shard of many.
        """
        q = np.asarray(q, dtype=float)
        v = np.asarray(v, dtype=float)
        gap, _ = self.batches.states(q, v)
        above = gap >= 0.0
        outcome = np.full(len(gap), BELOW, dtype=np.int16)
        turns = np.zeros(len(gap), dtype=np.int32)
        on_cells(len(gap) - int(above.sum()))
        budget = self.budget if self.dissipates else 1  # else there is nothing to meet
        outcome[above], turns[above] = self._settle(q[above], v[above], budget, on_cells, share)
        return outcome, turns

    def destination(self, q: float, v: float) -> Attractor | None:
        """The known attractor one start ends on, or None; nothing new is looked for."""
        gap, rate = self.batches.states([q], [v])
        ends = self._run(np.maximum(gap, 0.0), rate, self.budget)
        return self.attractors[ends.outcome[0]] if ends.outcome[0] >= 0 else None

    def _settle(
        self,
        q: np.ndarray,
        v: np.ndarray,
        budget: int,
        on_cells: Callable[[int], None],
        share: bool = False,
    ) -> tuple[np.ndarray, np.ndarray]:
        """`settle` for starts above the cam: (outcome, turns), in at most `budget` turns each.

        They are followed a chunk at a time; what is undecided then is resolved together, so that
        the result does not depend on the chunks.
        """
        outcome = np.empty(len(q), dtype=np.int16)
        turns = np.empty(len(q), dtype=np.int32)
        undecided_cells = []
        undecided_states = []  # gap, rate, mode of each
        for begin in range(0, len(q), self.chunk):
            some = slice(begin, begin + self.chunk)
            gap, rate = self.batches.states(q[some], v[some])
            try:
                ends = self._run(gap, rate, budget, share=share)
            except ShardDone:
                continue
            outcome[some] = ends.outcome
            turns[some] = ends.turns
            undecided = np.flatnonzero(ends.outcome == UNDECIDED)
            undecided_cells.append(begin + undecided)
            undecided_states.append(ends.states()[undecided])
            on_cells(len(ends.gap))
        if share and self.batches.work.shard is not None:
            raise ShardDone
        if undecided_cells:
            cells = np.concatenate(undecided_cells)
            states = np.concatenate(undecided_states)
            self._resolve(cells, states, budget, outcome, turns)
        outcome[outcome == FORGOTTEN] = UNDECIDED
        return outcome, turns

    def _run(
        self,
        gap: np.ndarray,
        rate: np.ndarray,
        budget: int,
        mode: np.ndarray | None = None,
        share: bool = False,
    ) -> Ends:
        """Follow starts to their ends, each for at most `budget` turns.

        gap (m), rate (m/rad) and the kernel's mode of each start, (n,). None ends at a rest that is
        not known: a start that stops at one is followed again once what comes after it is learned.
        """
        mode = mode_of(gap, rate) if mode is None else mode
        ends = self.batches.run(gap, rate, self.targets, budget, mode, share)
        stopped = np.flatnonzero(ends.outcome == NEW_REST)
        while len(stopped):
            new_states = np.column_stack((ends.gap, ends.rate))[stopped]
            _, first_of_state = np.unique(new_states, axis=0, return_index=True)
            for k in stopped[first_of_state].tolist():
                start = float(gap[k]), float(rate[k]), int(mode[k])
                state = float(ends.gap[k]), float(ends.rate[k]), int(ends.mode[k])
                self.rests.learn(start, state, int(ends.turns[k]))
            again = self.batches.run(
                gap[stopped], rate[stopped], self.targets, budget, mode[stopped]
            )
            ends.replace_rows(stopped, again)
            stopped = np.flatnonzero(ends.outcome == NEW_REST)
        return ends

    def _resolve(
        self,
        cells: np.ndarray,
        states: np.ndarray,
        budget: int,
        outcome: np.ndarray,
        turns: np.ndarray,
    ) -> None:
        """Identify attractors from undecided states and follow these on, until nothing is new.

        cells: indices of the undecided in `outcome` and `turns`, which are changed in place;
        states: gap, rate and mode of each, (n, 3).
        """
        for _ in range(ROUNDS):
            if len(cells) == 0 or not self._discover(states):
                return
            gap, rate, mode = states.T
            ends = self._run(gap, rate, budget, mode.astype(np.int64))
            outcome[cells] = ends.outcome
            turns[cells] += ends.turns.astype(np.int32)
            undecided = ends.outcome == UNDECIDED
            cells = cells[undecided]
            states = ends.states()[undecided]

    def _discover(self, states: np.ndarray) -> bool:
        """Identify the attractors of some undecided states; True once something new is known.

        states: gap, rate and mode of each, (n, 3). Of the different ones in ascending order
        CANDIDATES are looked at, evenly spread, until one has brought something new.
        """
        if not self.dissipates:
            return False
        ranked = np.unique(states, axis=0)
        count = min(CANDIDATES, len(ranked))
        picks = [k * (len(ranked) - 1) // max(1, count - 1) for k in range(count)]
        return any(self.identify(*ranked[k].tolist()) for k in dict.fromkeys(picks))

    def identify(self, gap: float, rate: float, mode: float) -> bool:
        """Solve the orbit that a state settles on, or recognise chaos; True where it is new."""
        start = self.batches.start(gap, rate, int(mode))
        orbit = self._orbit_from(start)
        if orbit is None:
            return self._recognise(gap, rate, int(mode))
        return self._admit_orbit(orbit)

    def _orbit_from(self, start: Start) -> PeriodicOrbit | None:
        """The stable orbit to which a start comes close in ATTRACTOR_SETTLE turns."""
        batches = self.batches
        settings = with_turns(batches.settings, ATTRACTOR_SETTLE, 2 * LONGEST_PERIOD + 2)
        record = batches.record(Orbit(batches.system, batches.rpm, settings, start))
        return identify(batches.system, batches.rpm, record)

    def _admit_orbit(self, orbit: PeriodicOrbit) -> bool:
        """`admit` a solved orbit."""
        attractor = Attractor.periodic_of(
            orbit.label, orbit.states, orbit.symbols, orbit.multipliers
        )
        return self.admit(attractor)

    def admit(self, attractor: Attractor) -> bool:
        """Take up a periodic attractor; True where it is.

        It is not where it is known, where differences say that it repels (`region_of`), or where
        its region cannot be parted from that of another.
        """
        if any(attractor.is_same(known) for known in self.attractors):
            return False
        region = region_of(self.batches, attractor)
        if region is None:
            return False
        regions = parted(self.regions, region)
        if regions is None:
            return False
        self.attractors.append(attractor)
        self.regions = regions
        self._rebuild()
        return True

    def _recognise(self, gap: float, rate: float, mode: int) -> bool:
        """Take up an aperiodic attractor, or add to a known one, from a long record.

        True where something new is known. None whose motion rests: what comes to a rest repeats
        itself from there on. One that has settled meanwhile is taken up as the orbit that it is on.
        """
        batches = self.batches
        patience = max(self.aperiodic_turns, batches.settings.patience)
        ends = batches.run([gap], [rate], self.targets, patience, [mode])
        if ends.outcome[0] != UNDECIDED:
            return False
        settings = with_turns(batches.settings, 0, self.aperiodic_turns)
        start = batches.start(float(ends.gap[0]), float(ends.rate[0]), int(ends.mode[0]))
        run = Orbit(batches.system, batches.rpm, settings, start)
        record = batches.record(run, events=False)
        points = batches.passages(record)[: record.periods]
        if record.status != Status.OK or any(record.chatter[: record.periods]):
            return False
        further = batches.record(run.go_on(0, FEWEST_TURNS))
        orbit = identify(batches.system, batches.rpm, further)
        if orbit is not None:
            return self._admit_orbit(orbit)
        return recurrence.is_recurrent(points) and self.take_up(points)

    def take_up(self, points: np.ndarray) -> bool:
        """Add an aperiodic record, joined to the attractor whose boxes it meets; True where done.

        points: its states (gap, rate) at the strobe, (n, 2). False, and nothing is added, where
        only a stay of more than MOST_STAY turns in the boxes of an aperiodic attractor would tell
        that a motion is on it.
        """
        lift = np.array(self.batches.lift)
        before = list(self.attractors), list(self.regions), self.boxes, self.targets
        for k, known in enumerate(self.attractors):
            if known.points is not None and recurrence.meet(known.points - lift, points):
                both = np.concatenate((known.points - lift, points))
                self.attractors[k] = Attractor.aperiodic_of(both + lift)
                break
        else:
            self.attractors.append(Attractor.aperiodic_of(points + lift))
            self.regions.append(None)
        stays = self._rebuild()
        of_aperiodic = [
            stay for stay, known in zip(stays, self.attractors, strict=True) if not known.periodic
        ]
        if max(of_aperiodic) > recurrence.MOST_STAY:
            self.attractors, self.regions, self.boxes, self.targets = before
            return False
        return True

    def _rebuild(self) -> list[int]:
        """Make the kernel's table of all that is known.

        Returns how many turns in its boxes decide, for each attractor; none without aperiodic ones.
        """
        lift = np.array(self.batches.lift)
        records = {
            k: known.points - lift
            for k, known in enumerate(self.attractors)
            if known.points is not None
        }
        self.boxes = None
        if records:
            boxes = recurrence.boxes_of(records, self.regions, len(self.attractors))
            self.boxes = replace(boxes, stays=self._stays(boxes))
        self.targets = self.rests.fill(targets_of(self.regions, self.boxes))
        return self.boxes.stays if self.boxes else []

    def _stays(self, boxes: recurrence.Boxes) -> list[int]:
        """How many turns in its boxes decide, for each attractor: a start from every box tells.

        A trial belongs to the attractor in whose box it is left, or, left in none, to that of the
        box it began in; one that ended elsewhere, at a periodic attractor, belongs to none (0).
        """
        tried = np.flatnonzero(boxes.owner)
        targets = targets_of(self.regions, boxes)
        gap, rate = boxes.grid.centres(tried).T
        ends = self.batches.run(gap, rate, targets, TRIAL)
        owner_at_end = boxes.owner[boxes.grid.boxes(np.column_stack((ends.gap, ends.rate)))]
        belongs = np.where(owner_at_end == 0, boxes.owner[tried], owner_at_end)
        belongs = np.where(ends.outcome == UNDECIDED, belongs, 0)
        return recurrence.stays_of(boxes, tried, belongs, ends.stay)

    def ranks(self) -> np.ndarray:
        """Number (1, 2, ...) of each attractor in the order that does not depend on the search."""
        in_order = sorted(range(len(self.attractors)), key=lambda k: self.attractors[k].order())
        numbers = np.zeros(len(in_order), dtype=np.int16)
        numbers[in_order] = np.arange(1, len(in_order) + 1)
        return numbers
