"""The bifurcations that bound a map: curves in two parameters, followed from the map's edges.

Along each of the four edges one parameter varies, and the other one is at an end of its range.
There orbits are looked for at some places, their branches are followed along the whole edge, and
every event located on them is continued through the map (`curves`). A curve that reaches another
edge is met there again: it is followed once. Orbits that rest on the cam have no such curves, and a
curve that lies inside of the map altogether is not found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from camcli.analysis.integrate import Cost, Settings
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import both_ways
from camcli.analysis.orbits.corner_impacts import CornerImpact
from camcli.analysis.orbits.curves import Curve, Plane, curve
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Crossing
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.search import find
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.study import Bifurcation, Diagram
from camcli.errors import NoMachineError
from camcli.piece_faults import piece
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.curve_proofs import CurveRange

PLACES_ON_AN_EDGE = (0.02, 0.27, 0.5, 0.73, 0.98)  # shares of it at which orbits are looked for
POINTS_ON_AN_EDGE = 60  # of a branch, at least
STARTS = 6  # motions simulated at each place
STEPS_OF_A_CURVE = 60  # across the map
SAME_END = 1e-6  # of the ranges: an event so near to the end of a curve is on it
MOST_TURNS = 4  # of an orbit whose curve is begun where two bifurcations meet
MOST_CURVES = 40  # after which no more are followed
FOLLOWED = (Kind.PERIOD_DOUBLING, Kind.FOLD, Kind.CORNER_IMPACT, Kind.GRAZING)

STAGES = 5  # steps of the work that are told
At = Callable[[float, float], tuple[System, float]]  # the machine and its speed, rpm


@dataclass
class Atlas:
    """What was found: curves, the points of codimension two on them, and the work it took.

    ranges: the parts of the curves that were tried to be proved, proved or not, None where no proof
    was asked for; a curve without any was not tried.
    """

    plane: Plane
    curves: list[Curve] = field(default_factory=list)
    points: list[CodimTwo] = field(default_factory=list)
    cost: Cost = field(default_factory=Cost)
    ranges: list[CurveRange] | None = None

    @property
    def not_tried(self) -> list[int]:
        """The numbers of the curves whose proof was not tried, their orbits being too long."""
        if self.ranges is None:
            return []
        tried = {part.curve for part in self.ranges}
        return [n for n in range(1, len(self.curves) + 1) if n not in tried]


class Edge(NamedTuple):
    """An edge of the map: parameter `varied` (0 or 1) along it, the other one at `end`."""

    varied: int
    end: float

    def values(self, along: float) -> tuple[float, float]:
        """Both parameters where the one along the edge has a value."""
        return (along, self.end) if self.varied == 0 else (self.end, along)


class _EdgeDiagram(Diagram):
    """Branches along an edge: what a corner impact leads to is not asked."""

    def _corner_impact(self, crossing: Crossing) -> CornerImpact | None:
        return None


def add_curves(
    at: At, settings: Settings, atlas: Atlas, branches: int, on_edge: Callable[[], None]
) -> None:
    """Add the curves that meet the edges of the map, and the points of codimension two on them.

    at: the machine at a value of each parameter; branches: how many that leave from events are
    followed on each edge, those of fewer turns first, and so are curves. on_edge is called STAGES
    times: after each edge, and after the curves. What is there when a `Budget` is spent may be
    used. An edge, or a curve, with a fault costs itself alone.
    """
    plane = atlas.plane
    events: list[tuple[Edge, Bifurcation]] = []
    for varied in (0, 1):
        for end in plane.ranges[1 - varied]:
            edge = Edge(varied, end)
            name = f"the edge of the map at {plane.names[1 - varied]} = {end!r}"
            events_on = partial(_events_on, at, settings, atlas, edge, branches)
            events += [(edge, event) for event in piece(name, events_on, [])]
            on_edge()
    points_left_from = 0  # from so many the curve of the other bifurcation has been looked for
    for edge, event in sorted(events, key=lambda pair: pair[1].orbit.turns):
        curves_before = len(atlas.curves)
        _follow(at, atlas, edge, event)
        _add_points(at, atlas, curves_before)
        for number in range(points_left_from, len(atlas.points)):
            for condition in (0, 1):
                curves_before = len(atlas.curves)
                _follow_from(at, atlas, atlas.points[number], condition)
                _add_points(at, atlas, curves_before)
            points_left_from = number + 1
    on_edge()


def _add_points(at: At, atlas: Atlas, known: int) -> None:
    """Add the points of codimension two on the curves behind the first ones, known already."""
    from camcli.analysis.orbits.codim2 import add_points  # it imports ball arithmetic

    if len(atlas.curves) > known:
        point = atlas.curves[known].points[0]
        system, _ = at(point.first, point.second)
        add_points(system, atlas.curves, atlas.plane, atlas.points, known)


def prove_atlas(at: At, atlas: Atlas, most_turns: int, on_curve: Callable[[], None]) -> None:
    """Prove the curves, and the points on them, of orbits of so many turns at most.

    at: as in `add_curves`; on_curve is called after each curve. A budget that is spent, or a fault,
    is the reason why the rest is not proved.
    """
    from camcli.analysis.orbits.codim2 import PointProof, prove  # they import ball arithmetic
    from camcli.analysis.orbits.curve_proofs import CurveRange, prove_curve
    from camcli.exact.shooting import ProofStep

    atlas.ranges = []
    for number, one in enumerate(atlas.curves, 1):
        first = one.points[0]
        last = one.points[-1]
        if first.orbit.turns <= most_turns:
            system, _ = at(first.first, first.second)
            places = (first.values, last.values)
            fault = CurveRange(number, 1, len(one.points), places, 0, ProofStep.FAULT)
            proof = partial(prove_curve, system, one, number, atlas.plane)
            atlas.ranges += piece(f"the proof that curve {number} has no gap", proof, [fault])
        on_curve()
    for index, point in enumerate(atlas.points):
        if point.orbit.turns <= most_turns:
            name = f"the proof of the {point.kind} at {point.first!r}, {point.second!r}"
            proof_of_point = piece(name, partial(prove, point), PointProof(ProofStep.FAULT))
            atlas.points[index] = replace(point, proof=proof_of_point)


def _follow_from(at: At, atlas: Atlas, point: CodimTwo, condition: int) -> None:
    """The curve of one of the two bifurcations that meet at a point, unless it is there already.

    condition: which of the two, 0 or 1.
    """
    from camcli.analysis.orbits.codim2 import event_at

    located, corner = event_at(point, condition)
    if located is None or point.orbit.turns > MOST_TURNS or len(atlas.curves) >= MOST_CURVES:
        return
    if any(_is_of(atlas.curves[n - 1], located.kind, corner) for n in point.curves):
        return
    values = point.first, point.second
    for one in atlas.curves:  # one that ends at this place was followed from elsewhere
        alike = _is_of(one, located.kind, corner) and one.label == point.label
        if alike and _ends_at(one, values, atlas.plane):
            return
    system, _ = at(point.first, point.second)
    name = f"the curve of the {located.kind} from {point.first:.10g}, {point.second:.10g}"
    continued = piece(name, partial(curve, system, located, atlas.plane, point.label, corner))
    if continued is not None and len(continued.points) > 2:
        atlas.curves.append(continued)


def _is_of(one: Curve, kind: Kind, corner: str) -> bool:
    """True for a curve of this kind, at this corner."""
    return (one.kind, one.corner) == (kind, corner)


def _events_on(
    at: At, settings: Settings, atlas: Atlas, edge: Edge, branches: int
) -> list[Bifurcation]:
    """Every event on the branches along an edge.

    branches: so many that leave from events are followed, too, those of fewer turns first.
    """
    low, high = atlas.plane.ranges[edge.varied]
    span = Span(low, high, (high - low) / POINTS_ON_AN_EDGE)
    name = atlas.plane.names[edge.varied]
    diagram: _EdgeDiagram | None = None
    for share in PLACES_ON_AN_EDGE:
        value = low + share * (high - low)
        try:
            system, rpm = at(*edge.values(value))
        except NoMachineError:
            continue
        shooter = Shooter(system, rpm, name)
        diagram = diagram or _EdgeDiagram(shooter, settings)
        diagram.shooter = shooter
        where = f"{name} = {value:.6g}"
        orbits_there = piece(f"the orbits at {where}", partial(find, system, rpm, settings, STARTS))
        if orbits_there is None:
            continue
        atlas.cost += orbits_there.cost
        for orbit in orbits_there.orbits:
            what = f"the branch through {orbit.label} at {where}"
            piece(what, partial(_follow_branch, diagram, orbit, span))
        atlas.cost += shooter.cost
    if diagram is None:  # there is no machine on the whole edge
        return []
    _follow_from_events(diagram, branches, span)
    return diagram.bifurcations


def _follow_from_events(diagram: Diagram, branches: int, span: Span) -> None:
    """Follow up to so many branches that leave from events, those of fewer turns first."""
    followed: set[int] = set()  # indices of the events
    for _ in range(branches):  # a branch may add to the points from which others leave
        waiting = [pair for pair in diagram.branch_points if pair[0] not in followed]
        if not waiting:
            break
        index, event = min(waiting, key=lambda pair: diagram.bifurcations[pair[0]].orbit.turns)
        source = diagram.bifurcations[index]
        what = f"the branch from the {source.kind} at {source.value:.10g}"
        piece(what, partial(diagram.switch, index, event, span))
        followed.add(index)


def _follow_branch(diagram: Diagram, orbit: PeriodicOrbit, span: Span) -> None:
    """Add the branch through an orbit to the diagram; no orbit at rest, and no branch twice."""
    shooter = diagram.shooter
    if orbit.root is None:
        return
    root = shooter.moved(orbit.root, shooter.value)  # its tangent is in another parameter
    if root is not None and not diagram.holds(root):
        diagram.add_bouncing(both_ways(shooter, root, span), "found")


def _follow(at: At, atlas: Atlas, edge: Edge, event: Bifurcation) -> None:
    """Add the curve of an event on an edge to the atlas, unless it is one already followed.

    at: makes the machine at values of the two parameters. Nothing is added where the event is of a
    kind that is not followed, where no machine can be made, or where a curve is a single point.
    """
    if event.kind not in FOLLOWED or event.located is None or len(atlas.curves) >= MOST_CURVES:
        return
    values = edge.values(event.value)
    for one in atlas.curves:
        if _is_of(one, event.kind, event.corner) and _ends_at(one, values, atlas.plane):
            return
    name = f"the curve of the {event.kind} at {event.value:.10g}"
    continued = None
    with suppress(NoMachineError):  # where a curve would begin beside the last machine
        system, _ = at(*values)
        follow_on = partial(curve, system, event.located, atlas.plane, event.label, event.corner)
        continued = piece(name, follow_on)
    if continued is not None and len(continued.points) > 1:
        atlas.curves.append(continued)


def _ends_at(one: Curve, values: Sequence[float], plane: Plane) -> bool:
    """Whether one end of a curve is at these values of the two parameters."""
    for point in (one.points[0], one.points[-1]):
        pairs = zip((point.first, point.second), values, plane.ranges, strict=True)
        if all(abs(a - b) <= SAME_END * (high - low) for a, b, (low, high) in pairs):
            return True
    return False
