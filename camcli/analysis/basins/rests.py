"""Rests on the way of cells: what the motion after each leads to, asked once and then known.

A complete chatter erases all memory, so the state at the strobe after it depends on the departure
alone: a speed has few of them. Where the doubles run on from it to a known attractor, to no further
rest, or to the next rest while remembering enough, they are followed on. Where they forget between
two rests, the motion is followed with many digits (`analysis.rest`), and all cells that come to
that rest end where it does; where that cannot be said they are undecided.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from camcli.analysis.basins.cell_batches import Crew
from camcli.analysis.integrate import Orbit, Tape, with_turns
from camcli.analysis.orbits.error_growth import TOO_LARGE as DIGITS_GONE
from camcli.analysis.orbits.error_growth import largest_growth
from camcli.kernel.cam_table import TURN
from camcli.kernel.cells import FORGOTTEN, NEW_REST, Targets
from camcli.kernel.flight import FREE
from camcli.kernel.orbit_loop import MODE, PERIOD, EventKind

SAME = 1e-9  # of the cam's top (m, m/rad): two states after one departure differ less
AFTER = 3  # turns after a chatter in which a departure is looked for
SPREAD = 1e-13  # from one start beside a state after a rest to the next, relative
EXCURSIONS = 512  # such starts
LONGEST = 2_000  # turns to the next rest
MOST_RESTS = 64  # states after rests that are looked into; further ones are followed on


@dataclass
class Rests:
    """The known states after a rest, in the order met, with the outcome of each."""

    crew: Crew
    states: list[tuple[float, float]] = field(default_factory=list)
    ends: list[int] = field(default_factory=list)
    followed: dict = field(default_factory=dict)  # `rest.after.After` by departure

    @property
    def near(self) -> float:
        """m and m/rad within which two states are one."""
        return SAME * max(abs(float(self.crew.system.cam.top)), 1e-3)

    def fill(self, targets: Targets) -> Targets:
        """The kernel's table with what is known."""
        flat = [x for state in self.states for x in state]
        count = len(self.states) if len(self.states) < MOST_RESTS else -1
        return targets._replace(rest=flat, ends=self.ends, rests=count, near=[self.near] * 2)

    def is_known(self, gap: float, rate: float) -> bool:
        """True where the kernel would recognise the state."""
        near = self.near
        return any(abs(gap - g) <= near and abs(rate - r) <= near for g, r in self.states)

    def add(self, gap: float, rate: float, end: int) -> None:
        """Keep what a state leads to."""
        self.states.append((gap, rate))
        self.ends.append(end)

    def doubles_hold(self, targets: Targets, budget: int, gap, rate, mode) -> bool:
        """True where the run in doubles on from a state after a rest may be believed.

        `targets`: the known attractors. It reaches one, or no further rest within the budget, or
        remembers its start up to and beyond the next rest.
        """
        crew, stops = self.crew, targets._replace(rest=[], ends=[], rests=0, near=[0.0, 0.0])
        ends = crew.run([gap], [rate], stops, budget, [mode])
        if ends.outcome[0] != NEW_REST:
            return True
        turns = 2 * int(ends.turns[0]) + AFTER
        tape = exact(crew, gap, rate, mode, 0, turns)
        grown = largest_growth(crew.system, crew.rpm, tape, range(turns))
        return grown <= DIGITS_GONE


def departure(crew: Crew, gap, rate, mode, turns: int) -> float | None:
    """Phase (rad) at which a start leaves its rest, whose chatter ends in turn `turns`."""
    tape = exact(crew, gap, rate, mode, turns - 1, 1 + AFTER)
    events = list(zip(tape.kind, tape.period, tape.theta, strict=True))
    chatters = [k for k, event in enumerate(events) if event[:2] == (EventKind.CHATTER, 0)]
    if not chatters or chatters[-1] + 1 == len(events):
        return None
    kind, _, theta = events[chatters[-1] + 1]
    return float(theta) if kind in (EventKind.DETACHMENT, EventKind.IMPACT) else None


def exact(crew: Crew, gap: float, rate: float, mode: int, transient: int, record: int) -> Tape:
    """The record of a cell's start to the last bit."""
    settings = with_turns(crew.settings, transient, record)
    orbit = Orbit(crew.system, crew.rpm, settings, crew.start(1.0, 0.0, 0))
    orbit.state = [crew.system.strobe % TURN, float(gap), float(rate)]
    orbit.count[MODE], orbit.count[PERIOD] = int(mode), -transient
    return orbit.run()


def excursions(crew: Crew, targets: Targets, state, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(outcomes, states at strobes) of starts a little beside one after a rest, to the next rest.

    `state`: (gap, rate, mode); `count`: states wanted.
    """
    tape = exact(crew, *state, 0, AFTER)
    low = np.array(crew.lift)
    ahead = np.column_stack((tape.strobe_q, tape.strobe_w)) - low
    free = ahead[ahead[:, 0] > crew.system.cam.top * SPREAD]
    if len(free) == 0:
        return np.array([FORGOTTEN]), np.zeros((0, 2))
    starts = free[0] * (1.0 + SPREAD * np.arange(1, EXCURSIONS + 1))[:, None]
    stops = targets._replace(rest=[], ends=[], rests=0, near=[0.0, 0.0])
    ends = crew.run(*starts.T, stops, LONGEST)
    found = []
    for start, turns in zip(starts, ends.turns.tolist(), strict=True):
        tape = exact(crew, *start, FREE, 0, turns)
        found.append(np.column_stack((tape.strobe_q, tape.strobe_w))[:turns] - low)
        if sum(map(len, found)) >= count:
            break
    return ends.outcome, np.concatenate(found)
