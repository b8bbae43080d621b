"""Critical speeds of attractors in a range, each from a solved quantity."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from camcli.analysis.classify import COMPLETE, Motion
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import CriticalSpeed
from camcli.analysis.contact_loss.study import detach
from camcli.analysis.explain.crisis import Crisis
from camcli.analysis.integrate import BudgetSpentError, Cost, Settings
from camcli.analysis.labels import CONTACT
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import both_ways
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Crossing
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import Change as RestChange
from camcli.analysis.orbits.study import Bifurcation, Branch, Diagram
from camcli.analysis.sweep import rpm_grid
from camcli.system import System

FEW_IMPACTS = 4  # up to which an orbit is followed through the whole range
REACH = 4.0  # spacings that one of more impacts is followed: beyond, it is unstable soon
POINTS = (400, 40)  # in the whole range and in such a part of it
MOST_LEAVING = 8  # branches followed that leave from events on attractors
MOST_SEEDS = 12  # orbits followed; windows in chaos have no end
FEWEST = 41  # speeds of the study of detachment
CHATTER = "P(1;inf)"  # the motion whose bursts are studied
DETACHMENT, ACCUMULATION = "first-detachment", "accumulation-at-corner"
COMPLETION, HIT = "chatter-completion", "corner-hit"


@dataclass(frozen=True)
class Event:
    """One critical speed: rpm +- error, the kind of event, and the motion it happens to.

    source: what was solved. A bifurcation of a branch, a critical speed or a landing on a corner of
    the study of detachment, a crisis, or the end of an orbit that rests on the cam.
    """

    rpm: float
    error: float
    kind: str
    label: str
    corner: str = ""
    classification: str = ""
    status: str = "ok"
    source: Bifurcation | CriticalSpeed | CornerHit | Crisis | RestChange | None = None


@dataclass(frozen=True)
class Events:
    """Events of attractors in ascending speed, all bifurcations found, and the branches."""

    events: list[Event]
    bifurcations: list[Bifurcation]
    branches: list[Branch]
    cost: Cost


def find_events(system: System, settings: Settings, motions: Sequence[Motion]) -> Events:
    """Follow every attracting orbit among the motions; study detachment where there is rest."""
    low, high = min(m.rpm for m in motions), max(m.rpm for m in motions)
    spacing = (high - low) / max(1, len(motions) - 1)
    shooter = Shooter(system, 0.5 * (low + high))
    diagram = Diagram(shooter, settings)
    with suppress(BudgetSpentError):
        _follow(diagram, motions, Span(low, high, max(spacing, (high - low) / POINTS[0])))
    events = [
        Event(b.value, b.error, b.kind, b.label, b.corner, b.classification, b.status, b)
        for b in diagram.bifurcations
        if of_attractor(b)
    ]
    cost = shooter.cost
    if any(m.chatter == COMPLETE or m.label == CONTACT for m in motions):
        study = detach(system, rpm_grid(low, high, max(FEWEST, len(motions))), settings)
        cost = cost + study.cost
        first = study.detachment.first
        more = [_critical(first, DETACHMENT, CONTACT, "")] if first else []
        more += [_critical(c, ACCUMULATION, CHATTER, c.region) for c in study.accumulation]
        more += [_critical(c, COMPLETION, CHATTER, c.region) for c in study.completion]
        more += [_critical(hit, HIT, CHATTER, hit.corner) for hit in study.hits]
        events += [e for e in more if low <= e.rpm <= high]
    once: dict[tuple, Event] = {}  # two branches may end in the same event
    for event in events:
        once.setdefault((event.kind, event.label, event.corner, f"{event.rpm:.10g}"), event)
    found = sorted(once.values(), key=lambda e: e.rpm)
    return Events(found, diagram.bifurcations, diagram.branches, cost)


def _critical(c: CriticalSpeed | CornerHit, kind: str, label: str, corner: str) -> Event:
    return Event(c.rpm, 0.5 * (c.high - c.low), kind, label, corner, status=c.status, source=c)


def _follow(diagram: Diagram, motions: Sequence[Motion], span: Span) -> None:
    """The branches of the attracting orbits, and those that leave them at events."""
    seeds = 0
    for motion in sorted(motions, key=lambda m: (m.impacts, m.rpm)):
        orbit = motion.orbit
        if orbit is None or orbit.root is None or seeds >= MOST_SEEDS:
            continue
        if diagram.holds(orbit.root):
            continue
        seeds += 1
        own = span
        if orbit.impacts > FEW_IMPACTS:
            reach = REACH * span.spacing
            low, high = max(span.low, orbit.rpm - reach), min(span.high, orbit.rpm + reach)
            own = Span(low, high, (high - low) / POINTS[1])
        diagram.add_bouncing(both_ways(diagram.shooter, orbit.root, own), "found")
    done, left = 0, MOST_LEAVING
    while done < len(diagram.branch_points) and left > 0:
        index, event = diagram.branch_points[done]
        done += 1
        if not isinstance(event, Crossing) and of_attractor(diagram.bifurcations[index]):
            left -= 1
            diagram.switch(index, event, span)


def of_attractor(b: Bifurcation) -> bool:
    """True where an attracting orbit gains or loses something at the event."""
    if b.kind == Kind.CORNER_IMPACT and b.left is not None and b.right is not None:
        return b.left.stable or b.right.stable
    if b.kind in (Kind.PERIOD_DOUBLING, Kind.FOLD):
        return b.orbit.det < 1.0
    return b.orbit.stable
