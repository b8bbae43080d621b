"""The settled motion over a range of speeds: its impacts, and where each burst accumulates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import inf

from camcli.analysis.contact_loss.burst import timeline
from camcli.analysis.contact_loss.force import DEG, Force
from camcli.analysis.integrate import Cost, Orbit, Settings, Start
from camcli.errors import OK
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.system import System

RECORD = 2  # turns: bursts of the first are looked at, and may end in the second
COMPLETE, INCOMPLETE, NONE = "complete", "incomplete", "none"


@dataclass(frozen=True)
class Settled:
    """One speed after its settling turns; phases in deg within the turn.

    `bursts`: (region it begins in, "" where it goes on from before; complete or incomplete).
    `ends`: phases at which a complete chatter ends, one per burst. `impacts`: of one turn.
    """

    rpm: float
    bursts: list[tuple[str, str]]
    ends: list[float]
    impacts: list[float]
    status: int
    cost: Cost

    @property
    def words(self) -> str:
        """A2 complete, A4 complete; none where the follower stays on the cam."""
        said = [f"{region} {outcome}".strip() for region, outcome in self.bursts]
        return ", ".join(dict.fromkeys(said)) or NONE


def settled(
    system: System,
    rpms: Sequence[float],
    settings: Settings,
    on_speed: Callable[[Settled], None] = lambda speed: None,
) -> list[Settled]:
    """Every speed from rest: settings.transient turns, then one turn looked at."""
    force = Force(system)
    result = []
    for rpm in rpms:
        result.append(_at(system, force, rpm, settings))
        on_speed(result[-1])
    return result


def _at(system: System, force: Force, rpm: float, settings: Settings) -> Settled:
    turns = Settings(
        settings.transient, RECORD, settings.chatter_tolerance, settings.impact_budget, Start()
    )
    orbit = Orbit(system, rpm, turns)
    tape = orbit.run(strobes=False)
    bursts: list[list] = []  # region, phase it begins at, phase it ends at
    turn = []
    landed = inf
    for kind, theta, phase in timeline(system, orbit, tape):
        if kind == DETACHMENT:
            if bursts and bursts[-1][2] == inf:  # it rested unseen, below the kernel's resolution
                bursts[-1][2] = landed
            bursts.append([_region(force, theta), phase, inf])
        elif kind == CHATTER and bursts and bursts[-1][2] == inf:
            bursts[-1][2] = phase
        elif kind == IMPACT and not bursts:
            bursts.append(["", phase, inf])
        if kind == IMPACT:
            landed = phase
            turn += [theta * DEG] if phase < TURN else []
    if tape.status == OK:
        bursts = _of_one_turn(bursts)
    offset = system.strobe
    return Settled(
        rpm,
        [(name, COMPLETE if end < inf else INCOMPLETE) for name, _, end in bursts],
        [((end + offset) % TURN) * DEG for _, _, end in bursts if end < inf],
        turn,
        tape.status,
        tape.cost,
    )


def _of_one_turn(bursts: list[list]) -> list[list]:
    """Bursts that begin in the first turn; one that came from before only if none does."""
    begun = [burst for burst in bursts if burst[0] and burst[1] < TURN]
    return begun or bursts[:1]


def _region(force: Force, theta: float) -> str:
    return force.region_of(stretch_at(force.cam, theta)).name


def ranges(speeds: Sequence[Settled]) -> list[tuple[str, float, float, int]]:
    """(bursts in words, from rpm, to rpm, speeds) of neighbouring speeds that behave alike."""
    found = []
    for words, group in groupby(speeds, lambda speed: speed.words):
        rpms = [speed.rpm for speed in group]
        found.append((words, rpms[0], rpms[-1], len(rpms)))
    return found
