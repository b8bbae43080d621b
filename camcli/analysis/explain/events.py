"""Critical speeds of attractors in a range, each from a solved quantity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camcli.analysis.classify import COMPLETE, Motion
from camcli.analysis.contact_loss.detachment import CriticalSpeed
from camcli.analysis.contact_loss.study import detach
from camcli.analysis.integrate import Cost, Settings
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch import Bifurcation, Writer
from camcli.analysis.orbits.branch_segment import both_ways
from camcli.analysis.orbits.crossing import Crossing
from camcli.analysis.orbits.locate import CORNER, FOLD, GRAZING, PERIOD_DOUBLING
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.study import continue_from, on_branches
from camcli.analysis.sweep import rpm_grid
from camcli.system import System

SIMPLE = 4  # impacts up to which an orbit is followed through the whole range
MOST_LEAVING = 8  # branches followed that leave from events on attractors
MOST_SEEDS = 12  # orbits followed; windows in chaos have no end
SETTLE = 3  # turns from rest before a burst is looked at
CORNER_HITS = 8  # impacts after lift-off whose landing on a corner is looked for
DETACHMENT, ACCUMULATION, COMPLETION, HIT = (
    "first-detachment",
    "accumulation-at-corner",
    "chatter-completion",
    "corner-hit",
)


@dataclass(frozen=True)
class Event:
    """One critical speed: rpm +- error, kind, the orbit it happens to, and the sentence.

    bifurcation: of a solved branch; None where it comes from the detachment study or a crisis.
    """

    rpm: float
    error: float
    kind: str
    label: str
    corner: str = ""
    classification: str = ""
    status: str = "ok"
    words: str = ""
    bifurcation: Bifurcation | None = None


@dataclass
class Events:
    """Events of attractors in ascending speed, all bifurcations found, and the branches."""

    events: list[Event]
    bifurcations: list[Bifurcation]
    branches: list
    cost: Cost


def find_events(system: System, settings: Settings, motions: Sequence[Motion]) -> Events:
    """Follow every attracting orbit among the motions; study detachment where there is rest."""
    low, high = min(m.rpm for m in motions), max(m.rpm for m in motions)
    spacing = (high - low) / max(1, len(motions) - 1)
    shooter = Shooter(system, 0.5 * (low + high))
    writer = Writer(shooter, settings)
    _follow(system, shooter, writer, motions, Span(low, high, max(spacing, (high - low) / 400)))
    events = [_event(b) for b in writer.bifurcations if of_attractor(b)]
    cost = shooter.cost
    if any(m.chatter == COMPLETE or m.label == "contact" for m in motions):
        more, extra = _resting(system, settings, low, high, len(motions))
        events, cost = events + more, cost + extra
    events = sorted(_distinct(events), key=lambda e: e.rpm)
    return Events(events, writer.bifurcations, writer.branches, cost)


def _follow(system, shooter: Shooter, writer: Writer, motions, span: Span) -> None:
    seeds = 0
    for motion in sorted(motions, key=lambda m: (m.impacts, m.rpm)):
        orbit = motion.orbit
        if orbit is None or orbit.root is None or seeds >= MOST_SEEDS:
            continue
        if on_branches(shooter, writer.branches, orbit.root):
            continue
        seeds += 1
        own = span if orbit.impacts <= SIMPLE else _near(orbit, span)
        writer.bouncing(list(both_ways(shooter, orbit.root, own)), "found")
    done, left = 0, MOST_LEAVING
    while done < len(writer.shoots) and left > 0:
        index, event = writer.shoots[done]
        done += 1
        source = writer.bifurcations[index]
        if isinstance(event, Crossing) or not of_attractor(source):
            continue
        left -= 1
        continue_from(shooter, writer, index, event, span)


def _near(orbit: PeriodicOrbit, span: Span) -> Span:
    """A few spacings around an orbit of many impacts: beyond, it is unstable soon."""
    reach = 4.0 * span.spacing
    low, high = max(span.low, orbit.rpm - reach), min(span.high, orbit.rpm + reach)
    return Span(low, high, (high - low) / 40)


def of_attractor(b: Bifurcation) -> bool:
    """True where an attracting orbit gains or loses something at the event."""
    if b.kind == CORNER and b.left is not None and b.right is not None:
        return b.left.stable or b.right.stable
    if b.kind in (PERIOD_DOUBLING, FOLD):
        return b.orbit.det < 1.0
    return b.orbit.stable


def _event(b: Bifurcation) -> Event:
    words = {
        PERIOD_DOUBLING: f"a multiplier of {b.label} passes -1",
        FOLD: f"{b.label} meets an unstable orbit and both vanish",
        CORNER: f"an impact of {b.label} reaches corner {b.corner}",
        GRAZING: f"{b.label} ceases to be a motion",
    }.get(b.kind, b.kind)
    return Event(
        b.value, b.error, b.kind, b.label, b.corner, b.classification, b.status,
        f"{words}: {' '.join(b.words)}" if b.words else words, b,
    )  # fmt: skip


def _resting(system: System, settings: Settings, low: float, high: float, count: int):
    """First detachment, accumulation at corners, corner hits and completion loss in the range."""
    rpms = rpm_grid(low, high, max(41, count))
    study = detach(system, rpms, settings, settle=SETTLE, impacts=CORNER_HITS)
    first = study.detachment.first
    events = []
    if first is not None:
        said = f"the contact force reaches zero at {first.theta_deg:.6g} deg"
        events.append(_critical(first, DETACHMENT, "contact", "", said))
    for c in study.accumulation:
        said = f"impacts accumulate exactly at corner {c.region}"
        events.append(_critical(c, ACCUMULATION, "P(1;inf)", c.region, said))
    for c in study.completion:
        said = "the chatter ends where the next one begins: it is complete no longer"
        events.append(_critical(c, COMPLETION, "P(1;inf)", c.region, said))
    events += [
        Event(
            h.rpm, 0.5 * (h.high - h.low), HIT, "P(1;inf)", h.corner, status=h.status,
            words=f"impact {h.impact} after lift-off lands on corner {h.corner}",
        )
        for h in study.hits
    ]  # fmt: skip
    return [e for e in events if low <= e.rpm <= high], study.cost


def _critical(c: CriticalSpeed, kind: str, label: str, corner: str, words: str) -> Event:
    return Event(c.rpm, 0.5 * (c.high - c.low), kind, label, corner, status=c.status, words=words)


def _distinct(events: list[Event]) -> list[Event]:
    """Each event once, though two branches may end in it."""
    kept: dict[tuple, Event] = {}
    for event in events:
        kept.setdefault((event.kind, event.label, event.corner, f"{event.rpm:.10g}"), event)
    return list(kept.values())
