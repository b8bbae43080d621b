"""Everything `cam orbits` asks: find orbits, follow them, classify what happens to them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby, pairwise
from math import isclose
from typing import TYPE_CHECKING

from camcli.analysis.border_collision import Side
from camcli.analysis.integrate import BudgetSpentError, Cost, Settings, spend
from camcli.analysis.labels import FEWEST_TURNS, Label
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import BranchSegment, both_ways, follow
from camcli.analysis.orbits.corner_impacts import CornerImpact, corner_impact
from camcli.analysis.orbits.curves import Curve, Plane, curve, passes
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Crossing, Located, doubled
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.same_orbit import same_orbit
from camcli.analysis.orbits.search import MOST_STARTS, find
from camcli.analysis.orbits.shooter import Root, Shooter, with_machine
from camcli.analysis.orbits.single_impact import Continuum
from camcli.analysis.orbits.sticking_orbits import BRACKETS, RUN, MotionChange, follow_sticking
from camcli.cams.regions import corner_list
from camcli.errors import NoMachineError
from camcli.kernel import backend
from camcli.kernel.backend import LITTLE_WORK
from camcli.piece_faults import piece
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.chaos.section import Chaos
    from camcli.analysis.orbits.all_orbits import AllOrbits
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.proofs import Proofs

SAME_CORNER = 1e-6  # rad: a departure so close to a corner is at it
SAME_VALUE = 1e-9  # relative: two values of a parameter that differ by less are one
SPEEDS = 24  # tried, spread over the range, where a label is not found at its own speed
FEW_STARTS = 8  # motions simulated at each
AROUND = 0.2  # relative range where none is given

Tick = Callable[[], None]


@dataclass(frozen=True)
class OrbitsQuestion:
    """What to find and follow.

    rpm: where orbits are looked for; parameter and span: what is varied (None: nothing); label:
    only this one; branches: how many that leave from events to follow; starts: motions simulated;
    stable: only those that are (True) or are not (False); curve: kind of bifurcation to continue
    in `plane`, whose first parameter is `parameter`; all_of: (impacts, turns) up to which all
    orbits are found, and no others.
    """

    rpm: float
    parameter: str = "rpm"
    span: Span | None = None
    label: Label | None = None
    branches: int = 3
    starts: int = 24
    stable: bool | None = None
    curve: str | None = None
    plane: Plane | None = None
    all_of: tuple[int, int] | None = None


@dataclass(frozen=True)
class Bifurcation:
    """One event on a branch.

    branch: its number; value: of the parameter, +- error; orbit: at the event; corner: name or
    empty; located: how it was found on a branch of bouncing orbits; corner_impact: both linear
    parts and the check by simulation; beyond: label behind a change of a resting orbit, empty where
    nothing was solved there; continues: number of the branch that leaves here, 0 for none.

    Of a corner impact left and right are trace and determinant on the sides before and behind the
    corner, classification is the border collision's kind, and agrees whether the simulations on
    both sides are as predicted (None where one cannot tell).
    """

    branch: int
    kind: Kind
    value: float
    error: float
    status: Bracket
    orbit: PeriodicOrbit
    corner: str = ""
    located: Located | None = None
    corner_impact: CornerImpact | None = None
    beyond: str = ""
    continues: int = 0

    @property
    def label(self) -> str:
        return self.orbit.label

    @property
    def left(self) -> Side | None:
        return None if self.corner_impact is None else self.corner_impact.left

    @property
    def right(self) -> Side | None:
        return None if self.corner_impact is None else self.corner_impact.right

    @property
    def agrees(self) -> bool | None:
        return None if self.corner_impact is None else self.corner_impact.agrees

    @property
    def classification(self) -> str:
        return "" if self.corner_impact is None else self.corner_impact.collision.kind


@dataclass(frozen=True)
class Branch:
    """Orbits in order along the branch; ends: what ends it at the first and at the last point.

    labels: those on the way, in order, without repetition.
    """

    number: int
    origin: str
    points: tuple[PeriodicOrbit, ...]
    ends: tuple[str, str]

    @property
    def labels(self) -> list[str]:
        return list(dict.fromkeys(orbit.label for orbit in self.points))

    @property
    def turning_points(self) -> list[float]:
        """Values of the parameter at which the branch turns round, in its order.

        Two turns at one value, but for rounding, are none: a corner has an orbit on each side.
        """
        values = [value for value, _ in groupby(orbit.value for orbit in self.points)]
        turns: list[float] = []
        for before, here, behind in zip(values, values[1:], values[2:], strict=False):
            if (before < here) != (here > behind):
                continue
            if turns and isclose(turns[-1], here, rel_tol=SAME_VALUE):
                turns.pop()
            else:
                turns.append(here)
        return turns

    def stable_ranges(self, bifurcations: Sequence[Bifurcation]) -> list[tuple[float, float]]:
        """Ranges (from, to) of the parameter over which the orbits are stable, in its order."""
        return [ends for _, ends in self.stable_stretches(bifurcations)]

    def stable_stretches(
        self, bifurcations: Sequence[Bifurcation]
    ) -> list[tuple[range, tuple[float, float]]]:
        """(indices of points one after the other, (from, to)) of the stable orbits, in its order.

        A range ends at the event beside its last stable point. At an event itself a multiplier has
        the modulus 1, so that rounding decides whether the orbit there counts as stable; one that
        lies between stable orbits does. bifurcations: of the whole study.
        """
        events = [b.value for b in bifurcations if b.branch == self.number]
        source = [b.value for b in bifurcations if b.continues == self.number]

        places = [point.value for point in self.points]
        stable = [point.stable for point in self.points]
        at_event = [False] * len(places)
        for index, value in enumerate(places):
            for event in events:
                if isclose(event, value, rel_tol=SAME_VALUE):
                    places[index] = event
                    at_event[index] = True
        for index in range(1, len(places) - 1):
            if at_event[index] and stable[index - 1] and stable[index + 1]:
                stable[index] = True
        ranges = []
        for attracts, run in groupby(range(len(places)), lambda index: stable[index]):
            if not attracts:
                continue
            indices = list(run)
            values = [places[index] for index in indices]
            beside = (indices[0] - 1, indices[-1] + 1)
            within = [index for index in beside if 0 <= index < len(places)]
            values += [places[index] for index in within if at_event[index]]
            if indices[0] == 0:
                values += source
            stretch = range(indices[0], indices[-1] + 1)
            ranges.append((stretch, (min(values), max(values))))
        return ranges


@dataclass(frozen=True)
class Limit:
    """A value of the parameter beyond which there is no machine, and why."""

    value: float
    reason: str


@dataclass(frozen=True)
class Absence:
    """A label that was not found at `rpm`, nor anywhere from `low` to `high` without an `orbit`.

    orbit: one with that label at the nearest speed that was tried; nearest: the speed closest to
    `rpm` that its branch reaches, and what ends it there. reached: the orbit at `rpm` itself, where
    the branch leads there: the search alone had missed it.
    """

    rpm: float
    low: float
    high: float
    orbit: PeriodicOrbit | None = None
    nearest: tuple[float, str] | None = None
    reached: PeriodicOrbit | None = None


@dataclass(frozen=True)
class OrbitsResult:
    """The orbits at question.rpm, the branches through them, and curves in two parameters.

    value: of the parameter where they were found; virtual: roots that penetrate the cam or would
    pull; absent: the label asked for does not exist at the speed asked for; continua: dwells at
    every phase of which there is an orbit; limits: where the range asked for leaves what is a
    machine; proofs: where they were asked for; codim2: the points of codimension two on the curves;
    every: the covers that show that the orbits are all, and chaos, proved or not, where that was
    asked for.
    """

    question: OrbitsQuestion
    value: float
    orbits: list[PeriodicOrbit]
    virtual: list[PeriodicOrbit]
    branches: list[Branch]
    bifurcations: list[Bifurcation]
    curves: list[Curve]
    cost: Cost
    absent: Absence | None = None
    continua: list[Continuum] = field(default_factory=list)
    limits: tuple[Limit, ...] = ()
    proofs: Proofs | None = None
    codim2: list[CodimTwo] = field(default_factory=list)
    every: AllOrbits | None = None
    chaos: Chaos | None = None

    @property
    def reach(self) -> tuple[float, float]:
        """The range of the parameter that was asked for, as far as there are machines."""
        span = self.question.span
        assert span is not None
        below = [limit.value for limit in self.limits if limit.value <= self.value]
        above = [limit.value for limit in self.limits if limit.value > self.value]
        return max([span.low, *below]), min([span.high, *above])


def orbits(
    system: System, settings: Settings, question: OrbitsQuestion, on_branch: Tick = lambda: None
) -> OrbitsResult:
    """Find, follow and classify; `on_branch` is called after each branch.

    Within an `integrate.Budget` that is spent, the rest is left out.
    """
    if question.all_of is not None:
        return _every(system, question, question.all_of, on_branch)
    starts = question.starts if question.label is None else max(question.starts, MOST_STARTS)
    backend.for_work((starts + 1) * (settings.transient + FEWEST_TURNS), 2 * LITTLE_WORK)
    found = find(system, question.rpm, settings, question.starts, question.label)
    absent = None
    if question.stable is not None:
        found.orbits = [orbit for orbit in found.orbits if orbit.stable == question.stable]
    elif question.label is not None and not found.orbits and not found.continua:
        absent = _absence(system, settings, question, question.label)
        if absent is not None and absent.reached is not None:
            found.orbits = [absent.reached]
            absent = None
        elif absent is not None and absent.orbit is not None and _speeds_asked(question):
            found.orbits = [absent.orbit]
            question = replace(question, rpm=absent.orbit.rpm)
    shooter = Shooter(system, question.rpm, question.parameter)
    span = question.span
    limits: tuple[Limit, ...] = ()
    if span is not None:
        span, limits = _with_machines(shooter, span)
    diagram = Diagram(shooter, settings, limits)
    if span is not None:
        with suppress(BudgetSpentError):
            _follow_all(diagram, found.orbits, span, question.branches, on_branch)
    curves = _curves(system, diagram.bifurcations, question)
    return OrbitsResult(
        question=question,
        value=shooter.value,
        orbits=found.orbits,
        virtual=found.virtual,
        branches=diagram.branches,
        bifurcations=diagram.bifurcations,
        curves=curves,
        cost=found.cost + shooter.cost,
        absent=absent,
        continua=found.continua,
        limits=limits,
    )


def _speeds_asked(question: OrbitsQuestion) -> tuple[float, float] | None:
    """The range of speeds that was asked for, None where it is no range of speeds."""
    if question.span is None or question.parameter != "rpm":
        return None
    return question.span.low, question.span.high


def _absence(
    system: System, settings: Settings, question: OrbitsQuestion, label: Label
) -> Absence | None:
    """Where a label is that was not found at its own speed; None where the search failed."""
    search = partial(_look_around, system, settings, question.rpm, label, _speeds_asked(question))
    with suppress(BudgetSpentError):
        return piece("the search at other speeds", search)
    return None


def _every(
    system: System, question: OrbitsQuestion, sizes: tuple[int, int], on_cover: Tick
) -> OrbitsResult:
    """All orbits of at most so many impacts and turns (sizes), and the covers that show it."""
    from camcli.analysis.orbits.all_orbits import all_orbits  # it imports ball arithmetic

    shooter = Shooter(system, question.rpm)
    impacts, turns = sizes
    every = all_orbits(shooter, question.rpm, impacts, turns, on_cover)
    return OrbitsResult(
        question=question,
        value=shooter.value,
        orbits=every.orbits,
        virtual=[],
        branches=[],
        bifurcations=[],
        curves=[],
        cost=shooter.cost,
        every=every,
    )


def _with_machines(shooter: Shooter, span: Span) -> tuple[Span, tuple[Limit, ...]]:
    """The part of a range in which there is a machine, and what limits it.

    The whole range where a budget is spent before that is known.
    """
    if shooter.family is None:
        return span, ()
    try:
        low, why_low = shooter.family.reach(span.low)
        high, why_high = shooter.family.reach(span.high)
    except BudgetSpentError:
        return span, ()
    limits = []
    if why_low:
        limits.append(Limit(low, why_low))
    if why_high:
        limits.append(Limit(high, why_high))
    return replace(span, low=low, high=high), tuple(limits)


def _follow_all(
    diagram: Diagram, orbits: Sequence[PeriodicOrbit], span: Span, most: int, on_branch: Tick
) -> None:
    """Branches through the orbits found, then up to `most` that leave from events on them."""
    # each point of a branch of resting orbits is a simulation
    runs = sum(orbit.resting for orbit in orbits) * (span.width / span.spacing + BRACKETS)
    backend.for_work(RUN * runs)
    for orbit in orbits:
        piece(f"the branch through {orbit.label}", partial(_follow_one, diagram, orbit, span))
        on_branch()
    through_orbits = len(diagram.branches)
    tried = 0
    while tried < len(diagram.branch_points) and len(diagram.branches) < through_orbits + most:
        index, event = diagram.branch_points[tried]
        source = diagram.bifurcations[index]
        name = f"the branch from the {source.kind} at {source.value:.10g}"
        piece(name, partial(diagram.switch, index, event, span))
        tried += 1
        on_branch()


def _follow_one(diagram: Diagram, orbit: PeriodicOrbit, span: Span) -> None:
    """The branch through an orbit that was found, unless it is one already followed."""
    shooter = diagram.shooter
    if orbit.root is None:
        diagram.add_sticking(replace(orbit, value=shooter.value), span)
        return
    root = shooter.moved(orbit.root, shooter.value)  # its tangent is in another parameter
    if root is not None and not diagram.holds(root):
        diagram.add_bouncing(both_ways(shooter, root, span), "found")


def _curves(
    system: System, bifurcations: Sequence[Bifurcation], question: OrbitsQuestion
) -> list[Curve]:
    """Every located bifurcation of the kind asked for, continued; the same curve only once.

    An event through which a curve of another one leads has none of its own.
    """
    curves: dict[tuple, Curve | None] = {}  # by the event; None where following it failed
    plane = question.plane
    if plane is None:
        return []

    def is_on_a_curve(located: Located) -> bool:
        """Whether a curve leads through an event."""
        followed = [known for known in curves.values() if known is not None]
        with suppress(BudgetSpentError, NoMachineError):
            return any(passes(system, known, located, plane) for known in followed)
        return False

    for event in bifurcations:
        if event.kind != question.curve or event.located is None:
            continue
        key = (event.label, event.corner, f"{event.value:.9g}")
        if key in curves or is_on_a_curve(event.located):
            continue
        follow_on = partial(curve, system, event.located, plane, event.label, event.corner)
        name = f"the curve of the {event.kind} at {event.value:.10g}"
        with suppress(BudgetSpentError, NoMachineError):
            curves[key] = piece(name, follow_on)
    continued = [one for one in curves.values() if one is not None]
    # an event without points of its own may lie on a curve that was followed after it
    return [
        one
        for one in continued
        if one.points or one.located is None or not is_on_a_curve(one.located)
    ]


class Diagram:
    """The branches and bifurcations found so far, numbered in the order of discovery.

    branch_points: (index of the bifurcation, its event) where another branch leaves.
    """

    def __init__(self, shooter: Shooter, settings: Settings, limits: Sequence[Limit] = ()):
        self.shooter = shooter
        self.settings = settings
        self.limits = {limit.value for limit in limits}
        self.branches: list[Branch] = []
        self.bifurcations: list[Bifurcation] = []
        self.branch_points: list[tuple[int, Located | Crossing]] = []
        self._corner_impacts: dict[tuple, CornerImpact | None] = {}

    def holds(self, root: Root) -> bool:
        """True where some branch passes through the root."""
        system = self.shooter.system
        orbit = from_root(system, root)
        for branch in self.branches:
            for a, b in pairwise(branch.points):
                if not min(a.value, b.value) <= root.value <= max(a.value, b.value):
                    continue
                for beside in (a.root, b.root):
                    if beside is None or beside.count != root.count:
                        continue
                    there = self.shooter.moved(beside, root.value)
                    if there is not None and same_orbit(from_root(system, there), orbit):
                        return True
        return False

    def switch(self, index: int, event: Located | Crossing, span: Span) -> None:
        """Follow the branch that leaves from an event, unless it is one already followed.

        index: of the event's bifurcation.
        """
        departure: tuple[Root, list[float]] | None  # a root beside it, and the direction away
        if isinstance(event, Crossing):  # a nonsmooth fold
            departure = event.far, event.ahead
        else:
            departure = doubled(self.shooter, event)
        if departure is None:
            return
        root, along = departure
        segment = follow(self.shooter, root, along, span)
        if len(segment.points) < 2:
            return
        with suppress(BudgetSpentError):  # what cannot be compared any more is kept
            if self.holds(segment.points[len(segment.points) // 2]):
                return
        source = self.bifurcations[index]
        self.add_bouncing([segment], source.kind)
        self.bifurcations[index] = replace(source, continues=len(self.branches))

    def add_bouncing(self, segments: Sequence[BranchSegment], origin: str) -> None:
        """A branch from one segment, or from two that begin at the same root, with its events.

        origin: what the branch begins at, the end of a single segment's first point.
        """
        number = len(self.branches) + 1
        if len(segments) == 2:
            down, up = segments
            roots = down.points[:0:-1] + up.points
            first_end: str = down.end
            last_end: str = up.end
        else:
            roots = segments[0].points
            first_end = origin
            last_end = segments[0].end
        points = tuple(from_root(self.shooter.system, root) for root in roots)
        ends = self._limited(first_end, points[0]), self._limited(last_end, points[-1])
        self.branches.append(Branch(number, origin, points, ends))
        for segment in segments:
            for located, crossing in segment.events:
                turned = crossing is not None and crossing is segment.turned
                self._add_bifurcation(number, located, crossing, turned)

    def _add_bifurcation(
        self, branch: int, located: Located, crossing: Crossing | None, turned: bool
    ) -> None:
        """Add an event on a branch, and note it where another branch leaves from it.

        turned: the crossing of a corner is a nonsmooth fold.
        """
        index = len(self.bifurcations)
        if located.kind == Kind.PERIOD_DOUBLING:
            self.branch_points.append((index, located))
        elif crossing is not None and turned:
            self.branch_points.append((index, crossing))
        event = Bifurcation(
            branch,
            located.kind,
            located.root.value,
            located.error,
            located.status,
            from_root(self.shooter.system, located.root),
            located=located,
        )
        if crossing is not None:
            impact = self._corner_impact(crossing)
            event = replace(event, corner=crossing.corner, corner_impact=impact)
        self.bifurcations.append(event)

    def _limited(self, end: str, point: PeriodicOrbit) -> str:
        """The end of a branch at a point: of the machine where it is no end of the range."""
        if end == Kind.END_OF_RANGE and point.value in self.limits:
            return Kind.NO_MACHINE
        return end

    def _corner_impact(self, crossing: Crossing) -> CornerImpact | None:
        """The study of a corner impact, made once for both branches that end in it."""
        key = (crossing.corner, crossing.left.count, f"{crossing.left.value:.11g}")
        if key not in self._corner_impacts:
            name = f"the corner impact at {crossing.corner}, {crossing.left.value:.10g}"
            study = partial(corner_impact, self.shooter, crossing, self.settings)
            with suppress(BudgetSpentError, NoMachineError):
                self._corner_impacts[key] = piece(name, study)
        return self._corner_impacts.get(key)

    def add_sticking(self, start: PeriodicOrbit, span: Span) -> None:
        """A branch of orbits that rest on the cam, both ways from one of them."""
        number = len(self.branches) + 1
        down = follow_sticking(self.shooter, self.settings, start, span, up=False)
        up = follow_sticking(self.shooter, self.settings, start, span, up=True)
        points = (*down.points[:0:-1], *up.points)
        ends = self._limited(down.end, points[0]), self._limited(up.end, points[-1])
        self.branches.append(Branch(number, "found", points, ends))
        for change in (*down.changes, *up.changes):
            corner = _corner_of(self._system_at(change.value), change)
            label_beyond = change.beyond.label if change.beyond else ""
            self.bifurcations.append(
                Bifurcation(
                    number,
                    change.kind,
                    change.value,
                    change.error,
                    Bracket.OK,
                    change.orbit,
                    corner=corner,
                    beyond=label_beyond,
                )
            )

    def _system_at(self, value: float) -> System:
        """The machine at a value of the parameter."""
        return with_machine(self.shooter.system, self.shooter.at(value))[0]


def _corner_of(system: System, change: MotionChange) -> str:
    """The corner at which the follower leaves the cam on one side of the change only.

    Where it leaves at the same phases on both sides: the first corner among these.
    """
    here = change.orbit.theta
    there = () if change.beyond is None else change.beyond.theta
    on_one_side = [theta for theta in here if not _is_among(theta, there)]
    on_one_side += [theta for theta in there if not _is_among(theta, here)]
    for corner in corner_list(system.cam):
        if _is_among(corner.theta, on_one_side or here):
            return corner.name
    return ""


def _is_among(theta: float, phases: Sequence[float]) -> bool:
    """Whether a phase (rad) is one of these to SAME_CORNER."""
    return any(abs(theta - other) < SAME_CORNER for other in phases)


def _look_around(
    system: System, settings: Settings, rpm: float, label: Label, ends: tuple[float, float] | None
) -> Absence:
    """Look for the label at other speeds, nearest first, and follow its branch towards `rpm`.

    ends: of the range of speeds; without one they lie AROUND to either side.
    """
    low, high = ends or (rpm * (1.0 - AROUND), rpm * (1.0 + AROUND))
    speeds = [low + (high - low) * (k / (SPEEDS - 1)) for k in range(SPEEDS)]
    for speed in sorted(speeds, key=lambda x: abs(x - rpm)):
        around = find(system, speed, settings, FEW_STARTS, label, FEW_STARTS)
        if around.orbits:
            orbit = around.orbits[0]
            nearest, end = _reach(system, settings, orbit, rpm)
            reached = nearest if nearest.value == rpm else None
            return Absence(rpm, low, high, orbit, (nearest.value, end), reached)
        spend(0)  # raises where the search at this speed did not come to its end
    return Absence(rpm, low, high)


def _reach(
    system: System, settings: Settings, orbit: PeriodicOrbit, rpm: float
) -> tuple[PeriodicOrbit, str]:
    """The orbit nearest to `rpm` on the orbit's branch with its label, and what ends it."""
    shooter = Shooter(system, orbit.rpm)
    up = rpm > orbit.rpm
    low = min(rpm, orbit.rpm)
    high = max(rpm, orbit.rpm)
    span = Span(low, high, (high - low) / SPEEDS)
    if orbit.root is None:
        sticking = follow_sticking(shooter, settings, orbit, span, up)
        points = sticking.points
        end = sticking.end
    else:
        tangent = orbit.root.tangent
        ahead = tangent if (tangent[-1] > 0.0) == up else [-x for x in tangent]
        segment = follow(shooter, orbit.root, ahead, span)
        points = [from_root(system, root) for root in segment.points]
        end = segment.end
    alike = (point for point in points if point.label == orbit.label)
    return min(alike, key=lambda point: abs(point.value - rpm)), end
