"""Qualitative changes between neighbouring speeds of a diagram, each given its cause."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, pi

from camcli.analysis.classify import COMPLETE, Motion
from camcli.analysis.explain.crisis import Crisis, CrisisKind, find_crisis
from camcli.analysis.explain.events import Event, Events, find_events
from camcli.analysis.integrate import Cost, Settings
from camcli.analysis.labels import APERIODIC
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import follow_sticking
from camcli.analysis.orbits.study import Bifurcation
from camcli.kernel.orbit_loop import IMPACT
from camcli.system import System

ENLARGED = 1.25  # ratio of the widths of the impact phases that counts as another attractor
LEAST_WIDTH = 2.0  # deg, and the least difference of widths
MOST_CRISES = 3  # searches of some seconds each
DEG = 180.0 / pi
UNEXPLAINED, BASIN = "unexplained", "basin"


@dataclass(frozen=True)
class Change:
    """Between two neighbouring speeds (rpm) the motion changes from label `before` to `after`.

    cause: the kinds of its events with + between, `basin` (both attractors exist on both sides, the
    start changes basins) or `unexplained`; persists: labels of the orbits that attract on both
    sides; crisis: the search for one, None where there was none; may_search: False where there was
    none because MOST_CRISES were made.
    """

    low: float
    high: float
    before: str
    after: str
    cause: str
    events: tuple[Event, ...] = ()
    persists: tuple[str, ...] = ()
    crisis: Crisis | None = None
    may_search: bool = True


@dataclass(frozen=True)
class Explanation:
    """Events of attractors in the range, the changes of the diagram, and all bifurcations found."""

    events: list[Event]
    changes: list[Change]
    bifurcations: list[Bifurcation]
    cost: Cost


def explain(
    system: System,
    settings: Settings,
    motions: Sequence[Motion],
    on_change: Callable[[], None] = lambda: None,
) -> Explanation:
    """Every critical speed of the attractors among `motions`, and every change with its cause.

    At most MOST_CRISES changes are searched for a crisis; on_change is called after each change.
    """
    motions = sorted(motions, key=lambda m: m.rpm)
    found = find_events(system, settings, motions)
    changes: list[Change] = []
    cost, searches = found.cost, 0
    for a, b in pairwise(motions):
        if not changes_between(a, b):
            continue
        change = _change(system, settings, found, a, b, searches < MOST_CRISES)
        if change.crisis is not None:
            cost, searches = cost + change.crisis.cost, searches + 1
        changes.append(change)
        on_change()
    extra = [e for change in changes for e in change.events if e not in found.events]
    events = sorted([*found.events, *extra], key=lambda e: e.rpm)
    return Explanation(events, changes, found.bifurcations, cost)


def changes_between(a: Motion, b: Motion) -> bool:
    """Another label, or a chaotic attractor of another size."""
    if a.label != b.label:
        return not (a.chatter == b.chatter == COMPLETE and a.period == b.period)
    return a.label == APERIODIC and enlarged(a, b)


def extent(motion: Motion) -> tuple[float, float]:
    """Least and largest impact phase of the record, deg."""
    thetas = [
        float(theta) * DEG
        for kind, theta in zip(motion.record.kind, motion.record.theta, strict=True)
        if kind == IMPACT
    ]
    return (min(thetas), max(thetas)) if thetas else (inf, -inf)


def enlarged(a: Motion, b: Motion) -> bool:
    """True where the impact phases of one fill a clearly wider range than those of the other."""
    widths = sorted(high - low for low, high in (extent(a), extent(b)))
    return widths[1] > ENLARGED * widths[0] and widths[1] - widths[0] > LEAST_WIDTH


def _change(
    system: System, settings: Settings, found: Events, a: Motion, b: Motion, may_search: bool
) -> Change:
    """The events inside the interval, else a rest's end, a crisis, coexistence, or unexplained."""
    ends = (a.rpm, b.rpm, a.label, b.label)
    inside = [e for e in found.events if a.rpm - e.error <= e.rpm <= b.rpm + e.error]
    relevant = tuple(e for e in inside if _concerns(e, a, b))
    if relevant:
        return Change(*ends, "+".join(dict.fromkeys(e.kind for e in relevant)), relevant)
    resting = _rest_ends(system, settings, a, b)
    if resting is not None:
        return Change(*ends, resting.kind, (resting,))
    persists = tuple(m.label for m in (a, b) if m.orbit is not None and _persists(found, m, a, b))
    crisis = _crisis(system, settings, a, b) if may_search else None
    if crisis is not None and crisis.explained:
        label = "chaotic attractor" if crisis.orbit is None else f"chaos, {crisis.orbit.label}"
        corner = crisis.corner.name if crisis.corner else ""
        event = Event(crisis.rpm, crisis.error, crisis.kind, label, corner, source=crisis)
        return Change(*ends, crisis.kind, (event,), persists, crisis)
    stays = crisis is not None and crisis.kind is CrisisKind.STAYS
    cause = BASIN if persists or stays else UNEXPLAINED
    return Change(*ends, cause, (), persists, crisis, may_search)


def _rest_ends(system: System, settings: Settings, a: Motion, b: Motion) -> Event | None:
    """Where an orbit that rests on the cam ends, followed from either side into the interval."""
    for motion, other in ((a, b), (b, a)):
        orbit = motion.orbit
        if orbit is None or not orbit.resting or not orbit.theta:
            continue
        shooter = Shooter(system, motion.rpm)
        span = Span(a.rpm, b.rpm, b.rpm - a.rpm)
        leg = follow_sticking(shooter, settings, orbit, span, other.rpm > motion.rpm)
        for change in leg.changes[-1:]:
            return Event(change.value, change.error, change.kind, orbit.label, source=change)
    return None


def _concerns(event: Event, a: Motion, b: Motion) -> bool:
    """True where the event belongs to one of the two motions or to what doubles from it."""
    labels = {a.label, b.label}
    if event.label in labels or not isinstance(event.source, Bifurcation):
        return True
    orbit = event.source.orbit
    return any(m.orbit is not None and m.orbit.turns % orbit.turns == 0 for m in (a, b)) or (
        APERIODIC in labels and orbit.stable
    )


def _persists(found: Events, motion: Motion, a: Motion, b: Motion) -> bool:
    """True where the motion's orbit exists and attracts on both sides of the interval."""
    for branch in found.branches:
        own = [p for p in branch.points if p.label == motion.label and p.stable]
        if own and min(p.value for p in own) <= a.rpm and max(p.value for p in own) >= b.rpm:
            return True
    return False


def _crisis(system: System, settings: Settings, a: Motion, b: Motion) -> Crisis | None:
    """A crisis of the chaotic attractor between the two speeds, if there is such an attractor.

    It is carried from the speed where it is the smaller one, or where there is one.
    """
    chaotic = [m for m in (a, b) if m.label == APERIODIC]
    if not chaotic:
        return None
    smaller = min(chaotic, key=lambda m: extent(m)[1] - extent(m)[0])
    return find_crisis(system, settings, a.rpm, b.rpm, "lower" if smaller is a else "upper")
