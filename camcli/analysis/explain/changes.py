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
from camcli.analysis.contact_loss.study import ContactLoss, detach
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
POINTS = 400  # of a branch in the whole range, at least
POINTS_OF_PART = 40  # in such a part of it
FEWEST = 41  # speeds of the study of detachment
CHATTER = "P(1;inf)"  # the motion whose bursts are studied
# kinds of events from the study of detachment
DETACHMENT = "first-detachment"
ACCUMULATION = "accumulation-at-corner"
COMPLETION = "chatter-completion"
HIT = "corner-hit"

ENLARGED = 1.25  # ratio of the widths of the impact phases that counts as another attractor
LEAST_WIDTH = 2.0 * pi / 180.0  # rad, and the least difference of widths
MOST_CRISES = 3  # searches of some seconds each
UNEXPLAINED = "unexplained"  # causes of a change that are no event
BASIN = "basin"


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
    low = min(motion.rpm for motion in motions)
    high = max(motion.rpm for motion in motions)
    spacing = (high - low) / max(1, len(motions) - 1)
    shooter = Shooter(system, 0.5 * (low + high))
    diagram = Diagram(shooter, settings)
    with suppress(BudgetSpentError):
        span = Span(low, high, max(spacing, (high - low) / POINTS))
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
        if study is not None:
            cost = cost + study.cost
            events += [e for e in _events_of_detachment(study) if low <= e.rpm <= high]
    once: dict[tuple, CriticalEvent] = {}  # two branches may end in the same event
    for event in events:
        once.setdefault((event.kind, event.label, event.corner, f"{event.rpm:.10g}"), event)
    in_order = sorted(once.values(), key=lambda e: e.rpm)
    return Events(in_order, diagram.bifurcations, diagram.branches, cost)


def _events_of_detachment(study: ContactLoss) -> list[CriticalEvent]:
    """The critical speeds of a study of detachment, and its landings on corners."""
    first = study.detachment.first
    events = [_critical(first, DETACHMENT, CONTACT, "")] if first else []
    events += [_critical(c, ACCUMULATION, CHATTER, c.region) for c in study.accumulation]
    events += [_critical(c, COMPLETION, CHATTER, c.region) for c in study.completion]
    events += [_critical(hit, HIT, CHATTER, hit.corner) for hit in study.hits]
    return events


def _critical(
    speed: CriticalSpeed | CornerHit, kind: str, label: str, corner: str
) -> CriticalEvent:
    """A critical speed of the study of detachment as an event, of the motion with a label."""
    error = 0.5 * (speed.high - speed.low)
    return CriticalEvent(speed.rpm, error, kind, label, corner, status=speed.status, source=speed)


def _follow(
    diagram: Diagram, motions: Sequence[ClassifiedMotion], span: Span, limits: Limits
) -> None:
    """The branches of the attracting orbits, and the branches that leave them at events.

    An orbit of many impacts is followed for a few spacings only.
    """
    seeds = 0
    for motion in sorted(motions, key=lambda m: (m.impacts, m.rpm)):
        orbit = motion.orbit
        if orbit is None or orbit.root is None or seeds >= limits.seeds:
            continue
        covered = partial(diagram.holds, orbit.root)
        if piece(f"the comparison of {orbit.label}", covered, instead=True):
            continue
        seeds += 1
        followed = span
        if orbit.impacts > FEW_IMPACTS:
            reach = FOLLOWED_SPACINGS * span.spacing
            low = max(span.low, orbit.rpm - reach)
            high = min(span.high, orbit.rpm + reach)
            followed = Span(low, high, (high - low) / POINTS_OF_PART)
        name = f"the branch through {orbit.label} at {orbit.rpm:.10g} rpm"
        piece(name, partial(_add_branch, diagram, orbit.root, followed))
    tried = 0
    left = limits.leaving
    while tried < len(diagram.branch_points) and left > 0:
        index, event = diagram.branch_points[tried]
        tried += 1
        source = diagram.bifurcations[index]
        named = 2 * source.orbit.turns <= LONGEST_PERIOD  # what doubles has a label
        if named and not isinstance(event, Crossing) and of_attractor(source):
            left -= 1
            name = f"the branch from the {source.kind} at {source.value:.10g} rpm"
            piece(name, partial(diagram.switch, index, event, span))


def _add_branch(diagram: Diagram, root: Root, span: Span) -> None:
    """The branch through an orbit."""
    diagram.add_bouncing(both_ways(diagram.shooter, root, span), "found")


def of_attractor(bifurcation: Bifurcation) -> bool:
    """True where an attracting orbit gains or loses something at the event.

    At a corner impact the orbit is stable on one side at least; at a doubling or a fold the other
    multiplier is inside the unit circle.
    """
    left = bifurcation.left
    right = bifurcation.right
    if bifurcation.kind == Kind.CORNER_IMPACT and left is not None and right is not None:
        return left.stable or right.stable
    if bifurcation.kind in (Kind.PERIOD_DOUBLING, Kind.FOLD):
        return bifurcation.orbit.det < 1.0
    return bifurcation.orbit.stable


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
    inner = motions[1:-1]
    compared = [
        motion
        for motion in motions
        if motion.label != UNDECIDED
        or motion.status != Status.OK
        or not any(motion is one for one in inner)
    ]
    all_events = find_events(system, settings, motions, limits)
    changes: list[LabelChange] = []
    events = list(all_events.events)
    cost = all_events.cost
    searches = 0  # for a crisis, that found one or failed
    for below, above in pairwise(compared):
        if not changes_between(below, above):
            continue
        ends = (below.rpm, above.rpm, below.label, above.label)
        may_search = searches < limits.crises
        explained = partial(_change, system, settings, all_events, below, above, may_search)
        fault = LabelChange(*ends, UNEXPLAINED, status=Status.FAULT)
        try:
            change = piece(f"the change from {below.rpm!r} to {above.rpm!r} rpm", explained, fault)
        except BudgetSpentError:
            change = LabelChange(*ends, UNEXPLAINED, status=Status.WORK_BUDGET)
        if change.crisis is not None:
            cost = cost + change.crisis.cost
            if change.crisis.kind not in (CrisisKind.STAYS, CrisisKind.NOT_CHAOTIC):
                searches += 1
        events += [event for event in change.events if event not in all_events.events]
        changes.append(change)
        on_change()
    return Explanation(sorted(events, key=lambda e: e.rpm), changes, all_events.bifurcations, cost)


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
    all_events: Events,
    a: ClassifiedMotion,
    b: ClassifiedMotion,
    may_search: bool,
) -> LabelChange:
    """What happens between two neighbouring motions, the likeliest cause first.

    The events inside the interval, else a rest's end, a crisis, coexistence, or unexplained.
    all_events: those of the whole range, and its branches; may_search: for a crisis. A chaotic
    attractor is carried from the speed where it is the smaller one, or where there is one.
    """
    ends = (a.rpm, b.rpm, a.label, b.label)
    inside = [e for e in all_events.events if a.rpm - e.error <= e.rpm <= b.rpm + e.error]
    relevant = tuple(e for e in inside if _concerns(e, a, b))
    if relevant:
        kinds = "+".join(dict.fromkeys(e.kind for e in relevant))
        return LabelChange(*ends, kinds, relevant)
    rest_ends = _rest_ends(system, settings, a, b)
    if rest_ends is not None:
        return LabelChange(*ends, rest_ends.kind, (rest_ends,))
    spend(0)  # raises where branches may have been cut short
    persists = tuple(
        m.label for m in (a, b) if m.orbit is not None and _persists(all_events, m, a, b)
    )
    chaotic = [m for m in (a, b) if m.label == APERIODIC]
    crisis = None
    if chaotic and may_search:
        smaller = min(chaotic, key=_width)
        other = b if smaller is a else a
        crisis = find_crisis(system, settings, smaller.rpm, other.rpm)
        if crisis.met:
            event = _event_of(crisis)
            return LabelChange(*ends, crisis.kind, (event,), persists, crisis)
    # Chaos that ends beside a stable orbit is no change of basins, unless it is seen to live on.
    if chaotic:
        lives_on = crisis is not None and crisis.kind is CrisisKind.STAYS
    else:
        lives_on = bool(persists)
    cause = BASIN if lives_on and UNDECIDED not in (a.label, b.label) else UNEXPLAINED
    return LabelChange(*ends, cause, (), persists, crisis, may_search)


def _event_of(crisis: Crisis) -> CriticalEvent:
    """A crisis in which the attractor meets a saddle, as an event."""
    corner = crisis.corner.name if crisis.corner else ""
    label = f"chaos, {crisis.met[0].orbit.label}"
    return CriticalEvent(crisis.rpm, crisis.error, crisis.kind, label, corner, source=crisis)


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
        up = other.rpm > motion.rpm
        segment = follow_sticking(shooter, settings, orbit, span, up)
        if segment.changes:
            change = segment.changes[-1]
            return CriticalEvent(
                change.value, change.error, change.kind, orbit.label, source=change
            )
    return None


def _concerns(event: CriticalEvent, a: ClassifiedMotion, b: ClassifiedMotion) -> bool:
    """True where the event belongs to one of the two motions or to what doubles from it.

    An event of a branch does where its orbit has the label of one of them, or a divisor of its
    period; beside chaos every event of a stable orbit counts.
    """
    labels = {a.label, b.label}
    if event.label in labels or not isinstance(event.source, Bifurcation):
        return True
    orbit = event.source.orbit
    for motion in (a, b):
        if motion.orbit is not None and motion.orbit.turns % orbit.turns == 0:
            return True
    return APERIODIC in labels and orbit.stable


def _persists(
    events: Events, motion: ClassifiedMotion, a: ClassifiedMotion, b: ClassifiedMotion
) -> bool:
    """True where the motion's orbit exists and attracts on both sides of the interval."""
    for branch in events.branches:
        values = [p.value for p in branch.points if p.label == motion.label and p.stable]
        if values and min(values) <= a.rpm and max(values) >= b.rpm:
            return True
    return False
