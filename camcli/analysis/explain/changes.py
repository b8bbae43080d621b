"""Qualitative changes between neighbouring speeds of a diagram, each given its cause."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf

from camcli.analysis.classify import APERIODIC, COMPLETE, Motion
from camcli.analysis.explain.crisis import Crisis, find_crisis
from camcli.analysis.explain.events import Event, Events, find_events
from camcli.analysis.integrate import IMPACT, Cost, Settings
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch import DEG, Branch
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import follow_resting
from camcli.system import System

ENLARGED = 1.25  # ratio of the widths of the impact phases that counts as another attractor
LEAST_WIDTH = 2.0  # deg, and the least difference of widths
MOST_CRISES = 3  # searches of some seconds each
UNEXPLAINED = "unexplained"
BASIN = "basin"


@dataclass(frozen=True)
class Change:
    """Between two neighbouring speeds the motion changes from `before` to `after`.

    cause: a kind of event, `basin` (both attractors exist on both sides, the start changes basins)
    or `unexplained`; events: those inside; words: the sentence, with what was tried.
    """

    low: float
    high: float
    before: str
    after: str
    cause: str
    words: str
    events: tuple[Event, ...] = ()


@dataclass(frozen=True)
class Explanation:
    """All events of attractors in the range, and the changes of the diagram with their causes."""

    events: list[Event]
    changes: list[Change]
    found: Events
    cost: Cost


def explain(
    system: System,
    settings: Settings,
    motions: Sequence[Motion],
    on_change: Callable[[], None] = lambda: None,
) -> Explanation:
    """Walk the diagram of `motions` (ascending speeds) and explain each change."""
    motions = sorted(motions, key=lambda m: m.rpm)
    found = find_events(system, settings, motions)
    changes, extra, searches = [], [], 0
    for a, b in pairwise(motions):
        if not changes_between(a, b):
            continue
        change = _cause(system, settings, found, a, b, searches < MOST_CRISES)
        searches += change.cause in (BASIN, UNEXPLAINED) or "crisis" in change.cause
        changes.append(change)
        extra += [e for e in change.events if e not in found.events]
        on_change()
    events = sorted([*found.events, *extra], key=lambda e: e.rpm)
    return Explanation(events, changes, found, found.cost)


def changes_between(a: Motion, b: Motion) -> bool:
    """Another label, or a chaotic attractor of another size."""
    if a.label != b.label:
        return not (a.chatter == b.chatter == COMPLETE and a.period == b.period)
    return a.label == APERIODIC and enlarged(a, b)


def extent(motion: Motion) -> tuple[float, float]:
    """Least and largest impact phase of the record, deg."""
    thetas = [
        float(theta) * DEG
        for kind, theta in zip(motion.tape.kind, motion.tape.theta, strict=True)
        if kind == IMPACT
    ]
    return (min(thetas), max(thetas)) if thetas else (inf, -inf)


def enlarged(a: Motion, b: Motion) -> bool:
    """True where the impact phases of one fill a clearly wider range than those of the other."""
    widths = sorted(high - low for low, high in (extent(a), extent(b)))
    return widths[1] > ENLARGED * widths[0] and widths[1] - widths[0] > LEAST_WIDTH


def _cause(system, settings, found: Events, a: Motion, b: Motion, may_search: bool) -> Change:
    """The events inside the interval, else a rest's end, a crisis, coexistence, or unexplained."""
    ends = (a.rpm, b.rpm, a.label, b.label)
    inside = [e for e in found.events if a.rpm - e.error <= e.rpm <= b.rpm + e.error]
    relevant = [e for e in inside if _concerns(e, a, b)]
    if relevant:
        kinds = list(dict.fromkeys(e.kind for e in relevant))
        words = "; ".join(f"{e.kind} at {e.rpm:.10g} rpm ({e.label})" for e in relevant)
        return Change(*ends, "+".join(kinds), words, tuple(relevant))
    resting = _resting(system, settings, a, b)
    if resting is not None:
        return Change(*ends, resting.kind, resting.words, (resting,))
    persists = [m for m in (a, b) if m.orbit is not None and _persists(found.branches, m, a, b)]
    crisis = _crisis(system, settings, a, b) if may_search else None
    tried = "" if crisis is None else " ".join(crisis.words)
    if crisis is not None and crisis.kind != UNEXPLAINED:
        event = _event_of(crisis)
        return Change(*ends, event.kind, event.words, (event,))
    if persists:
        return Change(*ends, BASIN, _coexistence(found, persists))
    if crisis is not None and crisis.stays:
        words = f"the chaotic attractor lives on at both speeds, the start changes basins. {tried}"
        return Change(*ends, BASIN, words)
    words = "tried: bifurcations of solved branches, none lies in it; branches through it, none is"
    words += f" stable. {tried}" if tried else " stable"
    if not may_search:
        words += f"; crises are looked for in the first {MOST_CRISES} changes only"
    return Change(*ends, UNEXPLAINED, words)


def _resting(system: System, settings: Settings, a: Motion, b: Motion) -> Event | None:
    """Where an orbit that rests on the cam ends, followed from either side into the interval."""
    for motion, other in ((a, b), (b, a)):
        orbit = motion.orbit
        if orbit is None or not orbit.resting or not orbit.theta:
            continue
        shooter = Shooter(system, motion.rpm)
        span = Span(a.rpm, b.rpm, b.rpm - a.rpm)
        leg = follow_resting(shooter, settings, orbit, span, other.rpm > motion.rpm)
        for change in leg.changes[-1:]:
            after = "nothing found" if change.beyond is None else change.beyond.label
            words = f"{orbit.label} ends ({change.kind}), beyond it a run settles on {after}"
            return Event(change.value, change.error, change.kind, orbit.label, words=words)
    return None


def _concerns(event: Event, a: Motion, b: Motion) -> bool:
    """True where the event belongs to one of the two motions or to what doubles from it."""
    labels = {a.label, b.label}
    if event.label in labels or event.bifurcation is None:
        return True
    orbit = event.bifurcation.orbit
    return any(m.orbit is not None and m.orbit.turns % orbit.turns == 0 for m in (a, b)) or (
        APERIODIC in labels and orbit.stable
    )


def _persists(branches: Sequence[Branch], motion: Motion, a: Motion, b: Motion) -> bool:
    """True where the motion's orbit exists and attracts on both sides of the interval."""
    for branch in branches:
        own = [p for p in branch.points if p.label == motion.label and p.stable]
        if own and min(p.value for p in own) <= a.rpm and max(p.value for p in own) >= b.rpm:
            return True
    return False


def _coexistence(found: Events, persists: Sequence[Motion]) -> str:
    """The orbit exists on both sides: what changes is the basin; and where it really ends."""
    said = []
    for motion in persists:
        label = motion.label
        ends = [e for e in found.events if e.label == label]
        where = ", ".join(f"{e.kind} at {e.rpm:.10g} rpm" for e in ends) or "nowhere in the range"
        said.append(
            f"{label} exists and attracts on both sides, the start changes basins; {label} changes "
            f"at: {where}"
        )
    return "; ".join(said)


def _crisis(system: System, settings: Settings, a: Motion, b: Motion) -> Crisis | None:
    """A crisis of the chaotic attractor between the two speeds, if there is such an attractor.

    It is carried from the speed where it is the smaller one, or where there is one.
    """
    chaotic = [m for m in (a, b) if m.label == APERIODIC]
    if not chaotic:
        return None
    smaller = min(chaotic, key=lambda m: extent(m)[1] - extent(m)[0])
    return find_crisis(system, settings, a.rpm, b.rpm, "lower" if smaller is a else "upper")


def _event_of(crisis: Crisis) -> Event:
    orbit = crisis.orbit
    label = "chaotic attractor" if orbit is None else f"chaos, {orbit.label}"
    words = " ".join(crisis.words)
    return Event(crisis.rpm, crisis.error, crisis.kind, label, crisis.corner, words=words)
