"""One direction of a branch, from a known orbit to whatever ends it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from camcli.analysis.orbits.arclength import Metric, Span, Step, oriented, walk
from camcli.analysis.orbits.crossing import Crossing, cross
from camcli.analysis.orbits.locate import (
    CLOSED,
    CORNER,
    FOLD,
    GRAZING,
    LOST,
    OK,
    PERIOD_DOUBLING,
    RANGE,
    Found,
    corners_on,
    doubling_at,
    graze_on,
    parent_of,
    smooth_events,
)
from camcli.analysis.orbits.orbit import section_states, shortest_period
from camcli.analysis.orbits.shooter import Root, Shooter

POINTS_PER_SPACING = 30  # times the range over the spacing: a branch longer than that is given up


@dataclass
class Leg:
    """Points in order, events in order, and the reason for the end (a kind of event, or `lost`)."""

    points: list[Root] = field(default_factory=list)
    events: list[tuple[Found, Crossing | None]] = field(default_factory=list)
    end: str = LOST
    turned: Crossing | None = None  # a nonsmooth fold: another branch leaves from here


def follow(shooter: Shooter, root: Root, along: Sequence[float], span: Span) -> Leg:
    """Follow a branch from `root` in the direction `along` to the end of range or of motion."""
    leg = Leg(points=[root])
    metric = Metric.of(root, span.width)
    most = POINTS_PER_SPACING * span.width / span.spacing
    while True:
        if _leaves(root, oriented(metric, root, along)[-1], span):
            leg.end = RANGE
            return leg
        for step in walk(shooter, root, along, metric, span):
            if step is None or len(leg.points) > most:
                return leg
            crossing = _advance(shooter, leg, step, span)
            if leg.end != LOST:
                return leg
            if _closes(leg, metric, step):
                leg.end = CLOSED
                return leg
            if crossing is not None:
                root, along = crossing.far, crossing.ahead
                break


def _leaves(root: Root, heading: float, span: Span) -> bool:
    """True at an end of the range, heading out of it."""
    return (root.value <= span.low and heading < 0.0) or (root.value >= span.high and heading > 0.0)


def _advance(shooter: Shooter, leg: Leg, step: Step, span: Span) -> Crossing | None:
    """Take a step up to the first thing that cuts it; sets leg.end where the branch ends."""
    if _collapses(shooter, step.after):
        return _born(shooter, leg, step)
    reached = step.after.value in (span.low, span.high)
    corner = next(iter(corners_on(shooter, step)), None)
    if corner is not None:
        step, reached = step.cut(corner.root), False
    if corner is not None and _collapses(shooter, corner.root):
        leg.end = CORNER  # it shrinks to an orbit of a shorter period: the 2-cycle of its corner
        return None
    graze = graze_on(shooter, step)
    if graze is not None:
        step, reached, corner = step.cut(graze.root), False, None
    heading = oriented(step.metric, step.after, step.unit)[-1]
    turned = (heading < 0.0) != (step.unit[-1] < 0.0)
    smooth = smooth_events(shooter, step, turned and graze is None)
    fold = next((f for f in smooth if f.kind == FOLD), None)
    if turned and graze is None and (fold is None or _collapses(shooter, fold.root)):
        return _born(shooter, leg, step)
    for found in smooth:
        born = parent_of(shooter, found) if found.kind == FOLD else None
        if born is not None:
            leg.events.append((born, None))
            leg.points.append(found.root)
            leg.end = PERIOD_DOUBLING
            return None
        leg.events.append((found, None))
        leg.points.append(found.root)
    if step.length > 0.0:
        leg.points.append(step.after)
    if graze is not None:
        leg.events.append((graze, None))
        leg.end = GRAZING
    elif reached:
        leg.end = RANGE
    elif corner is not None:
        return _pass_corner(shooter, leg, corner)
    return None


def _born(shooter: Shooter, leg: Leg, step: Step) -> None:
    """The step led past the period doubling where the branch was born, onto the single orbit."""
    leg.end = PERIOD_DOUBLING
    far = 2.0 * abs(step.after.value - step.before.value)
    born = parent_of(shooter, Found(FOLD, step.after, step.length, 0.0, OK), far)
    if born is not None:
        leg.events.append((born, None))


def _collapses(shooter: Shooter, root: Root) -> bool:
    """True for an orbit that is another one gone through several times."""
    return shortest_period(section_states(shooter.system, root)[0]) < root.turns


def _pass_corner(shooter: Shooter, leg: Leg, found: Found) -> Crossing | None:
    """Record a corner impact and go on behind it; a nonsmooth fold or a kink ends the branch."""
    crossing = cross(shooter, found)
    if crossing is None:
        leg.end = CORNER
        leg.events.append((found, None))
        return None
    if crossing.corner:
        leg.events.append((found, crossing))
        if crossing.turns_back or crossing.kink:
            leg.end = CORNER
            leg.turned = None if crossing.kink else crossing
            return None
        leg.points.append(crossing.far)
    return crossing


def _closes(leg: Leg, metric: Metric, step: Step) -> bool:
    """True where the step passes the first point again in the same direction."""
    first = leg.points[0]
    if len(leg.points) < 5 or step.after.whole != first.whole:
        return False
    away = [a - b for a, b in zip(first.x, step.before.x, strict=True)]
    along = metric.dot(away, step.unit)
    across = metric.dot(away, away) - along * along
    return 0.0 < along <= step.length and across < (0.1 * step.length) ** 2


def both_ways(shooter: Shooter, root: Root, span: Span) -> Iterator[Leg]:
    """The legs down and up from a root, by the parameter's sign."""
    up = root.tangent if root.tangent[-1] >= 0.0 else [-x for x in root.tangent]
    yield follow(shooter, root, [-x for x in up], span)
    leg = follow(shooter, root, up, span)
    here = doubling_at(shooter, root)
    if here is not None:
        leg.events.insert(0, (here, None))
    yield leg
