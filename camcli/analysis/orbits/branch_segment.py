"""One direction of a branch, from a known orbit to whatever ends it."""

from dataclasses import dataclass, field

import numpy as np

from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits.arclength import BranchStep, Metric, Span, steps
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import (
    Crossing,
    Located,
    collapses,
    corner_on,
    cross,
    doubling_at,
    graze_on,
    parent_of,
    smooth_events,
    twice_on,
)
from camcli.analysis.orbits.shooter import Root, Shooter, Vector
from camcli.piece_faults import piece

POINTS_PER_SPACING = 30  # times the range over the spacing: a branch longer than that is given up


@dataclass
class BranchSegment:
    """Points in order, events in order, and the reason for the end (a kind of event, or `lost`).

    turned: a nonsmooth fold, from which another branch leaves. begins_doubling: the first point is
    a period doubling, and has been told elsewhere.
    """

    points: list[Root] = field(default_factory=list)
    events: list[tuple[Located, Crossing | None]] = field(default_factory=list)
    end: Kind = Kind.LOST
    turned: Crossing | None = None
    begins_doubling: bool = False

    def close(self, end: Kind, *events: tuple[Located, Crossing | None]) -> None:
        """End the segment here, with the events at its end."""
        self.end = end
        self.events += events


def both_ways(shooter: Shooter, root: Root, span: Span) -> tuple[BranchSegment, BranchSegment]:
    """The segments down and up from a root, by the parameter's sign."""
    up = np.array(root.tangent if root.tangent[-1] >= 0.0 else [-x for x in root.tangent])
    here = doubling_at(shooter, root)
    below, above = (
        follow(shooter, root, along, span, begins_doubling=here is not None) for along in (-up, up)
    )
    if here is not None:
        above.events.insert(0, (here, None))
    return below, above


def follow(
    shooter: Shooter, root: Root, along: Vector, span: Span, begins_doubling: bool = False
) -> BranchSegment:
    """Follow a branch from `root` in the direction `along` to the end of range or of motion."""
    segment = BranchSegment(points=[root], begins_doubling=begins_doubling)
    name = f"the branch of {root.count} impacts in {root.turns} turns from {root.value:.10g} on"
    try:
        failed = piece(name, lambda: _follow(segment, shooter, root, along, span), instead=True)
    except BudgetSpentError:
        segment.close(Kind.WORK_BUDGET)
    else:
        if failed:
            segment.close(Kind.FAULT)
    return segment


def _follow(
    segment: BranchSegment, shooter: Shooter, root: Root, along: Vector, span: Span
) -> None:
    """Add points and events to a segment, step by step along the branch, until it ends.

    Where the branch goes on in another region of the cam, beyond a corner, it is followed from
    there; `along` is the direction of the way, a change of all unknowns.
    """
    metric = Metric.of(root, span.width)
    most = POINTS_PER_SPACING * span.width / span.spacing
    while True:
        heading = metric.oriented(root, along)[-1]
        if not span.low < root.value < span.high and (root.value <= span.low) == (heading < 0.0):
            segment.close(Kind.END_OF_RANGE)
            return
        for step in steps(shooter, root, along, metric, span):
            if step is None or len(segment.points) > most:
                return
            between = twice_on(shooter, step)
            if between is None:
                crossing = _advance(shooter, segment, step, span)
            else:
                crossing = _advance(shooter, segment, step.cut(between), span)
                if segment.end == Kind.LOST and crossing is None:
                    crossing = _advance(shooter, segment, step.rest(between), span)
            if segment.end == Kind.LOST and _closes(segment, step):
                segment.close(Kind.CLOSED)
            if segment.end != Kind.LOST:
                return
            if crossing is not None:
                root = crossing.far
                along = crossing.ahead
                break


def _advance(
    shooter: Shooter, segment: BranchSegment, step: BranchStep, span: Span
) -> Crossing | None:
    """Take a step up to the first thing that cuts it; closes the segment where the branch ends."""
    if collapses(shooter, step.after):
        _born(shooter, segment, step)
        return None
    reached = step.after.value in (span.low, span.high)
    corner = corner_on(shooter, step)
    if corner is not None:
        step = step.cut(corner.root)
        reached = False
    if corner is not None and collapses(shooter, corner.root):
        # it shrinks to an orbit of a shorter period: the 2-cycle of that orbit's corner impact
        segment.close(Kind.CORNER_IMPACT)
        return None
    graze = graze_on(shooter, step)
    if graze is not None:
        step = step.cut(graze.root)
        reached = False
        corner = None
    heading = step.metric.oriented(step.after, step.unit)[-1]
    turned = (heading < 0.0) != (step.unit[-1] < 0.0)
    known = segment.begins_doubling and step.before is segment.points[0]
    smooth = smooth_events(shooter, step, turned, known)
    fold = next((f for f in smooth if f.kind == Kind.FOLD), None)
    if fold is not None and (
        collapses(shooter, fold.root) or (fold.status != Bracket.OK and graze is None)
    ):
        _born(shooter, segment, step)
        return None
    for event in smooth:
        born = parent_of(shooter, event) if event.kind == Kind.FOLD else None
        segment.points.append(event.root)
        if born is not None:
            segment.close(Kind.PERIOD_DOUBLING, (born, None))
            return None
        segment.events.append((event, None))
    if step.length > 0.0:
        segment.points.append(step.after)
    if graze is not None:
        segment.close(Kind.GRAZING, (graze, None))
    elif reached:
        segment.close(Kind.END_OF_RANGE)
    elif corner is not None:
        return _pass_corner(shooter, segment, corner)
    return None


def _born(shooter: Shooter, segment: BranchSegment, step: BranchStep) -> None:
    """The step led past the period doubling where the branch was born, onto the single orbit."""
    far = 2.0 * abs(step.after.value - step.before.value)
    born = parent_of(shooter, Located(Kind.FOLD, step.after, step.length, 0.0, Bracket.OK), far)
    segment.close(Kind.PERIOD_DOUBLING, *([] if born is None else [(born, None)]))


def _pass_corner(shooter: Shooter, segment: BranchSegment, event: Located) -> Crossing | None:
    """Record a corner impact and go on behind it; a nonsmooth fold or a kink ends the branch."""
    crossing = cross(shooter, event)
    if crossing is not None and not crossing.corner:
        return crossing
    if crossing is None or crossing.turns_back or crossing.kink:
        segment.turned = crossing if crossing is not None and not crossing.kink else None
        segment.close(Kind.CORNER_IMPACT, (event, crossing))
        return None
    segment.events.append((event, crossing))
    segment.points.append(crossing.far)
    return crossing


def _closes(segment: BranchSegment, step: BranchStep) -> bool:
    """True where the step passes the first point again in the same direction."""
    first = segment.points[0]
    if len(segment.points) < 5 or step.after.whole != first.whole:
        return False
    away = np.subtract(first.x, step.before.x)
    along = step.metric.dot(away, step.unit)
    across = step.metric.dot(away, away) - along * along
    return 0.0 < along <= step.length and across < (0.1 * step.length) ** 2
