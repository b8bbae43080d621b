"""Rests on the way of cells: what the motion after each leads to, asked once and then known.

A rest: the follower stays on the cam for a while (sticking), after a complete chatter or an impact
from which it does not bounce. A departure is the end of a rest: the follower leaves the cam by
itself (detachment), or is struck where the cam's slope jumps.

A complete chatter erases all memory, so the state at the strobe after it depends on the departure
alone: a speed has few of them. Where doubles remember that departure until they meet a known
attractor, or the next rest, they are followed on. Where they forget it, the motion is followed in
ball arithmetic (`analysis.after_rest`), and all cells that come to that rest end where it does;
where that cannot be said they are undecided. A motion that comes to the same rest again goes
through a cycle, however long: it is never called aperiodic.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from camcli.analysis.after_rest import CYCLE, SETTLED, UNKNOWN, After, after_rest
from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import CellBatches
from camcli.analysis.integrate import Orbit, Record, with_turns
from camcli.analysis.labels import Label
from camcli.analysis.orbits.identify import TOO_LARGE, largest_growth
from camcli.kernel.cells import FORGOTTEN, GOES_ON, NEW_REST, Rest, Targets
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT

if TYPE_CHECKING:
    from camcli.analysis.basins.attractor_finder import AttractorFinder

SAME_OUTCOME = 1e-9  # of the cam's top (m, m/rad): two states after one departure differ less
SAME_DEPARTURE = 1e-9  # rad: departures from rest that round to the same multiple are one
AFTER = 3  # turns after a chatter in which a departure is looked for
MOST_RESTS = 64  # states after rests that are looked into; further ones are followed on

State = tuple[float, float, int]  # gap (m), rate (m/rad), mode of the kernel


@dataclass
class RestOutcomes:
    """The known states after a rest, in the order met, with the outcome of each."""

    finder: AttractorFinder
    states: list[tuple[float, float]] = field(default_factory=list)
    ends: list[int] = field(default_factory=list)
    followed: dict[int, After] = field(default_factory=dict)  # by departure

    @property
    def near(self) -> float:
        """m and m/rad within which two states are one."""
        return SAME_OUTCOME * max(abs(float(self.finder.batches.system.cam.top)), 1e-3)

    @property
    def decided(self) -> tuple[tuple[float, After], ...]:
        """Departures (rad) that were followed in ball arithmetic, with the motions after them."""
        return tuple((n * SAME_DEPARTURE, end) for n, end in sorted(self.followed.items()))

    def fill(self, targets: Targets) -> Targets:
        """The kernel's table with what is known."""
        known = [Rest(*state, end) for state, end in zip(self.states, self.ends, strict=True)]
        watch = int(len(known) < MOST_RESTS)
        return targets._replace(rests=known, watch_rests=watch, near=self.near)

    def learn(self, start: State, state: State, turns: int) -> None:
        """Find out what the state after a rest, met by a start after `turns`, leads to.

        The doubles are believed where they remember; else the motion after the rest is followed
        with many digits, and the attractor it ends on admitted.
        """
        gap, rate, _ = state
        for known_gap, known_rate in self.states:
            if abs(gap - known_gap) <= self.near and abs(rate - known_rate) <= self.near:
                return
        end = GOES_ON
        if not self._doubles_hold(start, state, turns):
            end = self._end_of(self._after(start, turns))
        self.states.append((gap, rate))
        self.ends.append(end)
        self.finder.targets = self.fill(self.finder.targets)

    def _doubles_hold(self, start: State, state: State, turns: int) -> bool:
        """True where the run in doubles on from a state after a rest may be believed.

        It may where errors of rounding grow by no more than TOO_LARGE from this rest until the run
        meets a known attractor, or until it is beyond the next rest, which may be the same.

        start, turns: the run began at `start`, and the chatter before the rest ended in its turn
        `turns`, counted from 1; state: at the strobe after that.
        """
        batches = self.finder.batches
        gap, rate, mode = start
        state_gap, state_rate, _ = state

        # Follow the start to an attractor or to another rest. This rest does not stop the run.
        this_rest = Rest(state_gap, state_rate, GOES_ON)
        targets = self.finder.targets._replace(rests=[this_rest], watch_rests=1, near=self.near)
        ends = batches.run([gap], [rate], targets, turns + self.finder.budget, [mode])
        last_turn = int(ends.turns[0])

        # The record counts its turns from 0, so the chatter before this rest ends in turns - 1.
        record = record_of(batches, start, 0, last_turn + AFTER)
        chatters = [turn for kind, turn, *_ in record.events() if kind == CHATTER]
        next_chatter = next((turn for turn in chatters if turn >= turns), last_turn)
        window = range(turns - 1, next_chatter + AFTER)
        return largest_growth(batches.system, batches.rpm, record, window) <= TOO_LARGE

    def _after(self, start: State, turns: int) -> After:
        """Where the motion ends after the rest of a start whose chatter ends in turn `turns`.

        It is followed once for each departure, by the multiple of SAME_DEPARTURE it rounds to.
        """
        batches = self.finder.batches
        theta = departure(batches, start, turns)
        if theta is None:
            return After(UNKNOWN)
        multiple = round(theta / SAME_DEPARTURE)
        if multiple not in self.followed:
            self.followed[multiple] = after_rest(batches.system, batches.rpm, theta)
        return self.followed[multiple]

    def _end_of(self, after: After) -> int:
        """The index of the attractor that a motion after a rest ends on, or FORGOTTEN.

        A cycle of rests is an attractor itself. Any other motion is followed on in doubles from the
        start that `after` gives, where it gives one.
        """
        finder = self.finder
        batches = finder.batches
        if after.kind == CYCLE:
            label = Label(after.symbols)
            cycle = Attractor.periodic_of(label, after.states, after.symbols, (0j, 0j))
            finder.admit(cycle)
            known = (k for k, other in enumerate(finder.attractors) if other.is_same(cycle))
            return next(known, FORGOTTEN)
        start = after.start(batches.system, batches.rpm)
        if start is None:
            return FORGOTTEN
        gap, rate = batches.states([start.q], [start.v])
        watch = int(after.kind != SETTLED)  # from one rest to the next there is no end
        for _ in range(2):  # an attractor that is not known yet is, at the second time
            targets = finder.targets._replace(watch_rests=watch)
            ends = batches.run(gap, rate, targets, finder.budget)
            if ends.outcome[0] >= 0:
                return int(ends.outcome[0])
            if ends.outcome[0] in (FORGOTTEN, NEW_REST):
                return FORGOTTEN
            finder.identify(float(ends.gap[0]), float(ends.rate[0]), float(ends.mode[0]))
        return FORGOTTEN


def departure(batches: CellBatches, start: State, turns: int) -> float | None:
    """Phase (rad) at which a start leaves its rest, whose chatter ends in turn `turns`.

    Turns count from 1. It leaves by itself (DETACHMENT), or is struck where the cam's slope jumps
    (IMPACT); None where it stays for AFTER turns.
    """
    record = record_of(batches, start, turns - 1, 1 + AFTER)
    events = record.events()
    first_turn = 0  # of the record, in which the chatter ends
    chatters = [k for k, event in enumerate(events) if event[:2] == (CHATTER, first_turn)]
    if not chatters or chatters[-1] + 1 == len(events):
        return None
    kind, _, theta, *_ = events[chatters[-1] + 1]
    return theta if kind in (DETACHMENT, IMPACT) else None


def record_of(batches: CellBatches, state: State, transient: int, record: int) -> Record:
    """The record of a cell's start, whose state is taken to the last bit.

    state: gap (m), its rate (m/rad) and the mode at the strobe; transient, record: turns. The state
    goes into the kernel's table as it is, since a start by position and velocity would round it.
    """
    gap, rate, mode = state
    settings = with_turns(batches.settings, transient, record)
    at_strobe = batches.start(gap=1.0, rate=0.0, mode=0)  # so phase, stretch and period are right
    orbit = Orbit(batches.system, batches.rpm, settings, at_strobe)
    begin = orbit.state
    begin.gap = float(gap)
    begin.gap_rate = float(rate)
    begin.mode = int(mode)
    return batches.record(orbit)
