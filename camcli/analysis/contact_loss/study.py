"""Everything `cam detach` answers for one machine and one range of speeds, in one result."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf

from camcli import errors
from camcli.analysis.contact_loss.accumulation import (
    completion_loss,
    corners_ahead,
    reaching,
    scan_speeds,
)
from camcli.analysis.contact_loss.accumulation_hits import Hit, corner_hits
from camcli.analysis.contact_loss.accumulation_range import Settled, settled
from camcli.analysis.contact_loss.burst import Bursts
from camcli.analysis.contact_loss.detachment import (
    JUMP,
    OK,
    STANDSTILL,
    Critical,
    Detachment,
    detachment,
)
from camcli.analysis.contact_loss.follow import Follow, follow
from camcli.analysis.contact_loss.force import Force, ForceCurve
from camcli.analysis.contact_loss.hold import Hold, hold_to, replaced
from camcli.analysis.integrate import Cost, Settings, compile_for
from camcli.analysis.sweep import rpm_grid
from camcli.kernel import backend
from camcli.system import System

FEWEST = 41  # speeds of the scan for changes
LITTLE_WORK = 4000  # turns in all that plain Python does before the kernel would be compiled
LEAST_WORK = 500  # the same where a compiled kernel only has to be read


@dataclass(frozen=True)
class Question:
    """What is asked beside the range: impacts to follow, force curves, and the spring to find."""

    impacts: int = 8
    force_rpm: Sequence[float] | None = None
    hold_to: float | None = None
    margin: float = 0.0
    precompression: float = 0.05


@dataclass(frozen=True)
class Study:
    """The answers. `hits` are landings on a corner, `ended` curves of hits that end in a graze.

    `jumps`: changes of the burst's end that pass a corner without reaching it. `springs`: curves
    at the speed of --hold-to, (name, curve), the present spring first.
    """

    detachment: Detachment
    follows: list[Follow]
    accumulation: list[Critical]
    jumps: list[Critical]
    completion: list[Critical]
    hits: list[Hit]
    ended: list[Hit]
    speeds: list[Settled]
    forces: list[ForceCurve]
    holds: list[Hold]
    springs: list[tuple[str, ForceCurve]]
    cost: Cost

    @property
    def criticals(self) -> list[Critical]:
        """Critical speeds in the order of detach.csv; standstill is no speed."""
        d = self.detachment
        rows = [d.first] if d.first else []
        rows += [c for loss in d.losses for c in (loss.opens, loss.fills)]
        return [c for c in rows + self.accumulation + self.completion if c.status != STANDSTILL]

    @property
    def troubled(self) -> list[tuple[float, int]]:
        """(rpm, status) of the speeds whose simulation could not be finished."""
        return [(speed.rpm, speed.status) for speed in self.speeds if speed.status != errors.OK]


def study(
    system: System,
    rpms: list[float],
    settings: Settings,
    question: Question,
    on_speed: Callable[[], None] = lambda: None,
) -> Study:
    """Answer `question`; settings.transient turns settle each of the speeds from rest."""
    turns = len(rpms) * (settings.transient + 2)
    worth = turns > LITTLE_WORK or (turns > LEAST_WORK and backend.is_cached())
    if backend.must_compile() or (backend.may_compile() and worth):
        compile_for(system)
    found = detachment(system)
    speeds = settled(system, rpms, settings, lambda speed: on_speed())
    scan = _scan(system, rpms, settings) if 1 < len(rpms) < FEWEST else speeds
    events, cost = _events(system, found, scan, settings.impact_budget, question.impacts)
    holds, springs = _springs(system, question)
    force = Force(system)
    return Study(
        detachment=found,
        **events,
        speeds=speeds,
        forces=[force.curve(rpm) for rpm in _force_speeds(found, rpms, question.force_rpm)],
        holds=holds,
        springs=springs,
        cost=sum((speed.cost for speed in speeds), cost),
    )


def _scan(system: System, rpms: list[float], settings: Settings) -> list[Settled]:
    """The settled motion at FEWEST speeds, where fewer were asked for."""
    return settled(system, rpm_grid(min(rpms), max(rpms), FEWEST), settings)


def _events(system: System, found: Detachment, scan, budget: int, impacts: int):
    """Release, accumulation at corners, completion loss and corner hits of every burst."""
    follows: list[Follow] = []
    reached: list[Critical] = []
    completion: list[Critical] = []
    hits: list[Hit] = []
    cost = Cost()
    for loss in found.losses if found.first is not None else ():
        if not loss.opens.finite:
            continue
        bursts = Bursts(system, loss.region.name, loss.opens.theta, budget)
        follows.append(follow(bursts, loss))
        speeds = scan_speeds(loss.opens.rpm, loss.region.name, scan)
        for goal in corners_ahead(bursts):
            changes = reaching(bursts, goal, speeds)
            reached += changes
            if changes:
                hits += corner_hits(bursts, goal, changes[0].low, speeds[-1], impacts)
        completion += completion_loss(bursts, speeds)
        cost = cost + bursts.cost
    events = {
        "follows": follows,
        "accumulation": [c for c in reached if c.status != JUMP],
        "jumps": [c for c in reached if c.status == JUMP],
        "completion": completion,
        "hits": [hit for hit in hits if hit.status == OK],
        "ended": [hit for hit in hits if hit.status != OK],
    }
    return events, cost


def _springs(system: System, question: Question) -> tuple[list[Hold], list]:
    rpm = question.hold_to
    if rpm is None:
        return [], []
    holds = hold_to(system, rpm, question.margin, question.precompression)
    springs = [("present spring", Force(system).curve(rpm))]
    for hold in holds:
        if hold.stiffness is not None and hold.preload is not None:
            other = replaced(system, hold.stiffness, hold.preload)
            springs.append((hold.words, Force(other).curve(rpm)))
    return holds, springs


def _force_speeds(found: Detachment, rpms: list[float], asked) -> list[float]:
    """The speeds asked for, else the ends of the range, first detachment and filling."""
    if asked is not None:
        return list(dict.fromkeys(asked))
    low, high = min(rpms), max(rpms)
    telling = [found.first, found.first_loss.fills if found.first_loss else None]
    between = [c.rpm for c in telling if c is not None and low < c.rpm < min(high, inf)]
    return sorted({low, *between, high})
