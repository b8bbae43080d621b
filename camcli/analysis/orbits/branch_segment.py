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
from camcli.errors import plural
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
    """The segments down and up from a root, by the parameter's sign.

    A period doubling at the root itself is an event of the second.
    """
    up = np.array(root.tangent if root.tangent[-1] >= 0.0 else [-x for x in root.tangent])
    doubling = doubling_at(shooter, root)
    begins_doubling = doubling is not None
    below = follow(shooter, root, -up, span, begins_doubling)
    above = follow(shooter, root, up, span, begins_doubling)
    if doubling is not None:
        above.events.insert(0, (doubling, None))
    return below, above


def follow(
    shooter: Shooter, root: Root, along: Vector, span: Span, begins_doubling: bool = False
) -> BranchSegment:
    """Follow a branch from `root` in the direction `along` to the end of range or of motion."""
    segment = BranchSegment(points=[root], begins_doubling=begins_doubling)
    size = f"{plural(root.count, 'impact')} in {plural(root.turns, 'turn')}"
    name = f"the branch of {size} from {root.value:.10g} on"
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
    there; `along` is the direction of the way, a change of all unknowns. A step on which an event
    happens twice (`twice_on`) is taken in two parts.
    """
    metric = Metric.of(root, span.width)
    most_points = POINTS_PER_SPACING * span.width / span.spacing
    while True:
        heading = metric.oriented(root, along)[-1]  # of the parameter
        at_end = not span.low < root.value < span.high
        if at_end and (root.value <= span.low) == (heading < 0.0):
            segment.close(Kind.END_OF_RANGE)
            return
        for step in steps(shooter, root, along, metric, span):
            if step is None or len(segment.points) > most_points:
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
    """Take a step up to the first thing that cuts it; closes the segment where the branch ends.

    That is a corner that an impact reaches, or before it a graze. Doublings and folds before these
    are events of the segment. Returns the crossing of a corner behind which the branch goes on.
    """
    if collapses(shooter, step.after):
        _born(shooter, segment, step)
        return None
    reaches_end = step.after.value in (span.low, span.high)
    corner = corner_on(shooter, step)
    if corner is not None:
        step = step.cut(corner.root)
        reaches_end = False
    if corner is not None and collapses(shooter, corner.root):
        # it shrinks to an orbit of a shorter period: the 2-cycle of that orbit's corner impact
        segment.close(Kind.CORNER_IMPACT)
        return None
    graze = graze_on(shooter, step)
    if graze is not None:
        step = step.cut(graze.root)
        reaches_end = False
        corner = None
    if not _take_smooth_events(shooter, segment, step, grazes=graze is not None):
        return None
    if step.length > 0.0:
        segment.points.append(step.after)
    if graze is not None:
        segment.close(Kind.GRAZING, (graze, None))
    elif reaches_end:
        segment.close(Kind.END_OF_RANGE)
    elif corner is not None:
        return _pass_corner(shooter, segment, corner)
    return None


def _take_smooth_events(
    shooter: Shooter, segment: BranchSegment, step: BranchStep, grazes: bool
) -> bool:
    """Add the doublings and folds on a step to its segment; False where the branch ends at one.

    It does at a fold that is the period doubling the branch was born at. grazes: the step was cut
    at a graze.
    """
    heading = step.metric.oriented(step.after, step.unit)[-1]  # of the parameter
    turned = (heading < 0.0) != (step.unit[-1] < 0.0)
    doubling_told = segment.begins_doubling and step.before is segment.points[0]
    events = smooth_events(shooter, step, turned, doubling_told)
    fold = next((event for event in events if event.kind == Kind.FOLD), None)
    if fold is not None:
        unresolved = fold.status != Bracket.OK and not grazes
        if collapses(shooter, fold.root) or unresolved:
            _born(shooter, segment, step)
            return False
    for event in events:
        parent = parent_of(shooter, event) if event.kind == Kind.FOLD else None
        segment.points.append(event.root)
        if parent is not None:
            segment.close(Kind.PERIOD_DOUBLING, (parent, None))
            return False
        segment.events.append((event, None))
    return True


def _born(shooter: Shooter, segment: BranchSegment, step: BranchStep) -> None:
    """Close a segment whose step led past the doubling where the branch was born.

    Beyond it the branch is the single orbit, gone through twice.
    """
    reach = 2.0 * abs(step.after.value - step.before.value)
    as_fold = Located(Kind.FOLD, step.after, step.length, 0.0, Bracket.OK)
    parent = parent_of(shooter, as_fold, within=reach)
    if parent is None:
        segment.close(Kind.PERIOD_DOUBLING)
    else:
        segment.close(Kind.PERIOD_DOUBLING, (parent, None))


def _pass_corner(shooter: Shooter, segment: BranchSegment, event: Located) -> Crossing | None:
    """Record a corner impact and go on behind it; a nonsmooth fold or a kink ends the branch.

    Returns the crossing where the branch goes on. Where the cam is smooth nothing is recorded.
    """
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
    """True where the step passes the first point again in the same direction.

    The first point lies ahead of the step's begin, no farther than its end, and much nearer to the
    line between them than the step is long.
    """
    first = segment.points[0]
    if len(segment.points) < 5 or step.after.whole != first.whole:
        return False
    away = np.subtract(first.x, step.before.x)
    along = step.metric.dot(away, step.unit)
    across_squared = step.metric.dot(away, away) - along * along
    return 0.0 < along <= step.length and across_squared < (0.1 * step.length) ** 2
