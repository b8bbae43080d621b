"""Critical speeds of attractors in a range, and every change of a diagram with its cause.

A critical speed is that of a solved quantity; a change lies between neighbouring speeds.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import pi

import numpy as np

from camcli.analysis.classify import COMPLETE, ClassifiedMotion
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import CriticalSpeed
from camcli.analysis.contact_loss.study import detach
from camcli.analysis.explain.attractor import impacts_of
from camcli.analysis.explain.crisis import Crisis, CrisisKind, find_crisis
from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import BudgetSpentError, Cost, Settings, spend
from camcli.analysis.labels import APERIODIC, CONTACT, LONGEST_PERIOD, UNDECIDED
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import both_ways
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Crossing
from camcli.analysis.orbits.shooter import Root, Shooter
from camcli.analysis.orbits.sticking_orbits import MotionChange, follow_sticking
from camcli.analysis.orbits.study import Bifurcation, Branch, Diagram
from camcli.errors import Status
from camcli.piece_faults import piece
from camcli.system import System

FEW_IMPACTS = 4  # up to which an orbit is followed through the whole range
FOLLOWED_SPACINGS = (
    4.0  # spacings that one of more impacts is followed: beyond, it is unstable soon
)
POINTS = (400, 40)  # in the whole range and in such a part of it
FEWEST = 41  # speeds of the study of detachment
CHATTER = "P(1;inf)"  # the motion whose bursts are studied
DETACHMENT, ACCUMULATION = "first-detachment", "accumulation-at-corner"
COMPLETION, HIT = "chatter-completion", "corner-hit"

ENLARGED = 1.25  # ratio of the widths of the impact phases that counts as another attractor
LEAST_WIDTH = 2.0 * pi / 180.0  # rad, and the least difference of widths
MOST_CRISES = 3  # searches of some seconds each
UNEXPLAINED, BASIN = "unexplained", "basin"


@dataclass(frozen=True)
class CriticalEvent:
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
    source: Bifurcation | CriticalSpeed | CornerHit | Crisis | MotionChange | None = None


@dataclass(frozen=True)
class Events:
    """Events of attractors in ascending speed, all bifurcations found, and the branches."""

    events: list[CriticalEvent]
    bifurcations: list[Bifurcation]
    branches: list[Branch]
    cost: Cost


@dataclass(frozen=True)
class Limits:
    """How much work an explanation may be."""

    seeds: int = 12  # orbits followed; windows in chaos have no end
    leaving: int = 8  # branches followed that leave from events on attractors
    crises: int = MOST_CRISES


USUAL_LIMITS = Limits()


def find_events(
    system: System,
    settings: Settings,
    motions: Sequence[ClassifiedMotion],
    limits: Limits = USUAL_LIMITS,
) -> Events:
    """Follow every attracting orbit among the motions; study detachment where there is rest."""
    low, high = min(m.rpm for m in motions), max(m.rpm for m in motions)
    spacing = (high - low) / max(1, len(motions) - 1)
    shooter = Shooter(system, 0.5 * (low + high))
    diagram = Diagram(shooter, settings)
    with suppress(BudgetSpentError):
        span = Span(low, high, max(spacing, (high - low) / POINTS[0]))
        _follow(diagram, motions, span, limits)
    events = [
        CriticalEvent(b.value, b.error, b.kind, b.label, b.corner, b.classification, b.status, b)
        for b in diagram.bifurcations
        if of_attractor(b)
    ]
    cost = shooter.cost
    if any(m.chatter == COMPLETE or m.label == CONTACT for m in motions):
        rpms = rpm_grid(low, high, max(FEWEST, len(motions)))
        study = piece("the study of detachment", lambda: detach(system, rpms, settings))
        more = []
        if study is not None:
            cost = cost + study.cost
            first = study.detachment.first
            more += [_critical(first, DETACHMENT, CONTACT, "")] if first else []
            more += [_critical(c, ACCUMULATION, CHATTER, c.region) for c in study.accumulation]
            more += [_critical(c, COMPLETION, CHATTER, c.region) for c in study.completion]
            more += [_critical(hit, HIT, CHATTER, hit.corner) for hit in study.hits]
        events += [e for e in more if low <= e.rpm <= high]
    once: dict[tuple, CriticalEvent] = {}  # two branches may end in the same event
    for event in events:
        once.setdefault((event.kind, event.label, event.corner, f"{event.rpm:.10g}"), event)
    in_order = sorted(once.values(), key=lambda e: e.rpm)
    return Events(in_order, diagram.bifurcations, diagram.branches, cost)


def _critical(c: CriticalSpeed | CornerHit, kind: str, label: str, corner: str) -> CriticalEvent:
    return CriticalEvent(
        c.rpm, 0.5 * (c.high - c.low), kind, label, corner, status=c.status, source=c
    )


def _follow(
    diagram: Diagram, motions: Sequence[ClassifiedMotion], span: Span, limits: Limits
) -> None:
    """The branches of the attracting orbits, and the branches that leave them at events."""
    seeds = 0
    for motion in sorted(motions, key=lambda m: (m.impacts, m.rpm)):
        orbit = motion.orbit
        if orbit is None or orbit.root is None or seeds >= limits.seeds:
            continue
        covered = partial(diagram.holds, orbit.root)
        if piece(f"the comparison of {orbit.label}", covered, instead=True):
            continue
        seeds += 1
        own = span
        if orbit.impacts > FEW_IMPACTS:
            reach = FOLLOWED_SPACINGS * span.spacing
            low, high = max(span.low, orbit.rpm - reach), min(span.high, orbit.rpm + reach)
            own = Span(low, high, (high - low) / POINTS[1])
        name = f"the branch through {orbit.label} at {orbit.rpm:.10g} rpm"
        piece(name, partial(_add_branch, diagram, orbit.root, own))
    done = 0
    left = limits.leaving
    while done < len(diagram.branch_points) and left > 0:
        index, event = diagram.branch_points[done]
        done += 1
        source = diagram.bifurcations[index]
        named = 2 * source.orbit.turns <= LONGEST_PERIOD  # what doubles has a label
        if named and not isinstance(event, Crossing) and of_attractor(source):
            left -= 1
            name = f"the branch from the {source.kind} at {source.value:.10g} rpm"
            piece(name, partial(diagram.switch, index, event, span))


def _add_branch(diagram: Diagram, root: Root, span: Span) -> None:
    """The branch through an orbit."""
    diagram.add_bouncing(both_ways(diagram.shooter, root, span), "found")


def of_attractor(b: Bifurcation) -> bool:
    """True where an attracting orbit gains or loses something at the event."""
    if b.kind == Kind.CORNER_IMPACT and b.left is not None and b.right is not None:
        return b.left.stable or b.right.stable
    if b.kind in (Kind.PERIOD_DOUBLING, Kind.FOLD):
        return b.orbit.det < 1.0
    return b.orbit.stable


@dataclass(frozen=True)
class LabelChange:
    """Between two neighbouring speeds (rpm) the motion changes from label `before` to `after`.

    cause: the kinds of its events with + between, `basin` (both attractors exist on both sides, the
    start changes basins) or `unexplained`; persists: labels of the orbits that attract on both
    sides; crisis: the search for one, None where there was none; may_search: False where there was
    none because MOST_CRISES were made; status: WORK_BUDGET where the search for a cause was cut.
    """

    low: float
    high: float
    before: str
    after: str
    cause: str
    events: tuple[CriticalEvent, ...] = ()
    persists: tuple[str, ...] = ()
    crisis: Crisis | None = None
    may_search: bool = True
    status: Status = Status.OK


@dataclass(frozen=True)
class Explanation:
    """Events of attractors in the range, the changes of the diagram, and all bifurcations found.

    status: WORK_BUDGET where something was left out.
    """

    events: list[CriticalEvent]
    changes: list[LabelChange]
    bifurcations: list[Bifurcation]
    cost: Cost
    status: Status = Status.OK


def explain(
    system: System,
    settings: Settings,
    motions: Sequence[ClassifiedMotion],
    on_change: Callable[[], None] = lambda: None,
    limits: Limits = USUAL_LIMITS,
) -> Explanation:
    """Every critical speed of the attractors among `motions`, and every change with its cause.

    Only the first changes are searched for a crisis (`Limits.crises`); on_change is called after
    each change. An undecided motion may be that of a neighbour: where it has two, these are
    compared. Within an `integrate.Budget` that is spent, causes are those found up to there.
    """
    motions = sorted(motions, key=lambda m: m.rpm)
    outer = motions[:1] + motions[-1:]
    known = [
        m
        for m in motions
        if m.label != UNDECIDED or m.status != Status.OK or any(m is o for o in outer)
    ]
    nearby = find_events(system, settings, motions, limits)
    changes: list[LabelChange] = []
    events = list(nearby.events)
    cost = nearby.cost
    searches = 0
    for a, b in pairwise(known):
        if not changes_between(a, b):
            continue
        ends = (a.rpm, b.rpm, a.label, b.label)
        may_search = searches < limits.crises
        cause = partial(_change, system, settings, nearby, a, b, may_search)
        unknown = LabelChange(*ends, UNEXPLAINED, status=Status.FAULT)
        try:
            change = piece(f"the change from {a.rpm!r} to {b.rpm!r} rpm", cause, unknown)
        except BudgetSpentError:
            change = LabelChange(*ends, UNEXPLAINED, status=Status.WORK_BUDGET)
        if change.crisis is not None:
            cost = cost + change.crisis.cost
            if change.crisis.kind not in (CrisisKind.STAYS, CrisisKind.NOT_CHAOTIC):
                searches += 1
        events += [e for e in change.events if e not in nearby.events]
        changes.append(change)
        on_change()
    return Explanation(sorted(events, key=lambda e: e.rpm), changes, nearby.bifurcations, cost)


def changes_between(a: ClassifiedMotion, b: ClassifiedMotion) -> bool:
    """Whether two motions differ: in their label, or in the size of a chaotic attractor."""
    if a.label != b.label:
        return not (a.chatter == b.chatter == COMPLETE and a.period == b.period)
    narrow, wide = sorted((_width(a), _width(b)))
    enlarged = wide > ENLARGED * narrow and wide - narrow > LEAST_WIDTH
    return a.label == APERIODIC and enlarged


def _width(motion: ClassifiedMotion) -> float:
    """Width of the range of impact phases of the record, rad."""
    theta = impacts_of(motion.record)[0]
    return float(np.ptp(theta)) if len(theta) else 0.0


def _change(
    system: System,
    settings: Settings,
    nearby: Events,
    a: ClassifiedMotion,
    b: ClassifiedMotion,
    may_search: bool,
) -> LabelChange:
    """The events inside the interval, else a rest's end, a crisis, coexistence, or unexplained.

    A chaotic attractor is carried from the speed where it is the smaller one, or where there is
    one.
    """
    ends = (a.rpm, b.rpm, a.label, b.label)
    inside = [e for e in nearby.events if a.rpm - e.error <= e.rpm <= b.rpm + e.error]
    relevant = tuple(e for e in inside if _concerns(e, a, b))
    if relevant:
        return LabelChange(*ends, "+".join(dict.fromkeys(e.kind for e in relevant)), relevant)
    resting = _rest_ends(system, settings, a, b)
    if resting is not None:
        return LabelChange(*ends, resting.kind, (resting,))
    spend(0)  # raises where branches may have been cut short
    persists = tuple(m.label for m in (a, b) if m.orbit is not None and _persists(nearby, m, a, b))
    chaotic = [m for m in (a, b) if m.label == APERIODIC]
    crisis = None
    if chaotic and may_search:
        near = min(chaotic, key=_width)
        crisis = find_crisis(system, settings, near.rpm, (b if near is a else a).rpm)
        if crisis.met:
            corner = crisis.corner.name if crisis.corner else ""
            label = f"chaos, {crisis.met[0].orbit.label}"
            event = CriticalEvent(
                crisis.rpm, crisis.error, crisis.kind, label, corner, source=crisis
            )
            return LabelChange(*ends, crisis.kind, (event,), persists, crisis)
    # Chaos that ends beside a stable orbit is no change of basins, unless it is seen to live on.
    if chaotic:
        lives = crisis is not None and crisis.kind is CrisisKind.STAYS
    else:
        lives = bool(persists)
    cause = BASIN if lives and UNDECIDED not in (a.label, b.label) else UNEXPLAINED
    return LabelChange(*ends, cause, (), persists, crisis, may_search)


def _rest_ends(
    system: System, settings: Settings, a: ClassifiedMotion, b: ClassifiedMotion
) -> CriticalEvent | None:
    """Where an orbit that rests on the cam ends, followed from either side into the interval."""
    for motion, other in ((a, b), (b, a)):
        orbit = motion.orbit
        if orbit is None or not orbit.resting or not orbit.theta:
            continue
        shooter = Shooter(system, motion.rpm)
        span = Span(a.rpm, b.rpm, b.rpm - a.rpm)
        leg = follow_sticking(shooter, settings, orbit, span, other.rpm > motion.rpm)
        for change in leg.changes[-1:]:
            return CriticalEvent(
                change.value, change.error, change.kind, orbit.label, source=change
            )
    return None


def _concerns(event: CriticalEvent, a: ClassifiedMotion, b: ClassifiedMotion) -> bool:
    """True where the event belongs to one of the two motions or to what doubles from it."""
    labels = {a.label, b.label}
    if event.label in labels or not isinstance(event.source, Bifurcation):
        return True
    orbit = event.source.orbit
    return any(m.orbit is not None and m.orbit.turns % orbit.turns == 0 for m in (a, b)) or (
        APERIODIC in labels and orbit.stable
    )


def _persists(
    events: Events, motion: ClassifiedMotion, a: ClassifiedMotion, b: ClassifiedMotion
) -> bool:
    """True where the motion's orbit exists and attracts on both sides of the interval."""
    for branch in events.branches:
        values = [p.value for p in branch.points if p.label == motion.label and p.stable]
        if values and min(values) <= a.rpm and max(values) >= b.rpm:
            return True
    return False
