"""A located bifurcation continued in two parameters: the curve on which it happens.

At every point one of the two parameters is given and the event is solved for the other: a corner
impact directly, a period doubling as a root of 1 + trace + det, a fold as the extremum of the
parameter along the branch, grazing as the zero of the gap where a flight comes nearest to the cam,
or of the rate of an impact that fades. The parameter that changes more is the one given, so that
the curve may turn round in either. Where the free one leaves its range, the last point is solved
again at the range's bound.

Another impact that reaches a corner ends a curve of folds or doublings: behind it the map is
another one. A curve of corner impacts or of grazing goes on with that impact in the next region,
with a kink, maybe backwards. A curve ends where its orbit becomes one of fewer turns, gone through
several times.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from math import isclose, sqrt, ulp
from typing import NamedTuple

from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import (
    Crossing,
    Located,
    collapses,
    cross,
    doubling_near,
    secant,
)
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Root, Shooter, machine_at, place_of, with_machine
from camcli.cams.regions import corner_list
from camcli.errors import NoMachineError
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.flow import move
from camcli.kernel.variational import gap_accel
from camcli.system import System

SMALLEST_SHARE = 1e-4  # of the spacing: a step below it ends the curve
LONGEST_CURVE = 40  # times the steps across the range: a curve longer than that is given up
NEAR_CORNER = 0.02  # of a whole step: so near another corner the curve goes on behind it
MOST_TOUCHES = 30  # Newton steps to where a flight comes nearest to the cam
LONGEST_TOUCH = 0.1  # rad, of one
BESIDE_GRAZE = (1e-9, 1e-7)  # relative distances of the parameter from a graze
BESIDE_FADING = (1e-7, 1e-5)  # from an impact that fades: nearer, its certificate is lost
SAME_POINT = 1e-9  # relative: a parameter at which a curve and an event are one
SAME_PHASE = 1e-5  # rad, of their impacts: at a fold these are known to the root of rounding
FADED = 1e-13  # of the largest rate: one that is zero but for rounding
AWAY = 3.0  # steps from its first point, from where a curve may come back to it
FREE_STEPS = 10.0  # steps by which the free parameter may change in one
MOST_TURNED = 0.5  # rad by which an impact may move in one step


@dataclass(frozen=True)
class CurvePoint:
    """One point: both parameters, the orbit, and at a corner impact the roots of both sides."""

    first: float
    second: float
    orbit: PeriodicOrbit
    crossing: Crossing | None = None

    @property
    def left(self) -> tuple[float, float] | None:
        """(trace, det) before the corner."""
        return None if self.crossing is None else _linear_part(self.crossing.left)

    @property
    def right(self) -> tuple[float, float] | None:
        """(trace, det) behind the corner."""
        return None if self.crossing is None else _linear_part(self.crossing.right)


class CurveLine(NamedTuple):
    """A curve as it is drawn: what it is of, and its points along both numbers.

    proved: whether it is proved from each of its points to the next; empty where none of it is.
    """

    kind: str
    label: str
    corner: str
    first: Sequence[float]
    second: Sequence[float]
    proved: Sequence[bool] = ()


@dataclass(frozen=True)
class Curve:
    """A curve of one kind of bifurcation.

    ends: why it stops on either side; limits: the parameter whose range ends there, or empty;
    located: the event it began with; beyond: the roots behind either end that were refused, which
    are no motions on this curve any more, or None.
    """

    kind: Kind
    label: str
    corner: str
    first: str
    second: str
    points: tuple[CurvePoint, ...]
    ends: tuple[Kind, Kind]
    limits: tuple[str, str] = ("", "")
    located: Located | None = None
    beyond: tuple[Root | None, Root | None] = (None, None)

    @property
    def line(self) -> CurveLine:
        """The curve as it is drawn."""
        first, second = [p.first for p in self.points], [p.second for p in self.points]
        return CurveLine(self.kind, self.label, self.corner, first, second)


@dataclass(frozen=True)
class Plane:
    """Names and ranges of both parameters, and the number of steps across them."""

    names: tuple[str, str]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    steps: int


def curve(system: System, located: Located, plane: Plane, label: str, corner: str) -> Curve:
    """Continue a bifurcation of a branch in one of plane.names through the plane."""
    tracer = _Tracer(system, located, plane)
    root = located.root
    free = 0 if root.parameter == place_of(system, plane.names[0]) else 1
    start = tracer.solve(root, root.x, free, tracer.values(root)[1 - free])
    if start is None:
        ends = (Kind.LOST, Kind.LOST)
        return Curve(located.kind, label, corner, *plane.names, (), ends, located=located)
    down, up = tracer.trace(start, -1.0), tracer.trace(start, 1.0)
    points = tuple(tracer.point(root) for root in [*reversed(down.roots), start, *up.roots])
    return Curve(
        located.kind, label, corner, *plane.names, points, (down.end, up.end),
        (down.limit, up.limit), located, (down.beyond, up.beyond),
    )  # fmt: skip


def passes(system: System, known: Curve, located: Located, plane: Plane) -> bool:
    """Whether a known curve leads through an event: the curve is solved there once more.

    The two are one if the parameter that is solved for and the phases of the impacts agree.
    """
    if known.located is None or known.kind != located.kind:
        return False
    root = located.root
    free = 0 if root.parameter == place_of(system, plane.names[0]) else 1
    tracer = _Tracer(system, known.located, plane)
    given = tracer.values(root)[1 - free]
    for before, after in pairwise(known.points):
        ends = [(point.first, point.second)[1 - free] for point in (before, after)]
        beside = (before if abs(ends[0] - given) <= abs(ends[1] - given) else after).orbit.root
        if not min(ends) <= given <= max(ends) or beside is None or beside.count != root.count:
            continue
        again = tracer.solve(beside, [*beside.x[:-1], tracer.values(beside)[free]], free, given)
        if again is not None and isclose(again.value, root.value, rel_tol=SAME_POINT):
            phases = zip(sorted(again.theta), sorted(root.theta), strict=True)
            if all(abs(a - b) < SAME_PHASE for a, b in phases):
                return True
    return False


def _linear_part(root: Root) -> tuple[float, float]:
    """Trace and determinant of a root's monodromy matrix."""
    return root.trace, root.det


@dataclass(frozen=True)
class _Side:
    """What lies on one side of a curve's first point.

    roots: behind it; end: why they end; limit: the parameter whose range ends there, or empty;
    beyond: the root that was refused there.
    """

    roots: list[Root]
    end: Kind
    limit: str = ""
    beyond: Root | None = None


class _Tracer:
    """One curve: the event solved for one parameter, the other being given."""

    def __init__(self, system: System, located: Located, plane: Plane):
        self.system = system
        self.located = located
        self.plane = plane
        self.spans = [high - low for low, high in plane.ranges]

    def values(self, root: Root) -> tuple[float, float]:
        """Both parameters of a root."""
        first, second = (root.machine[place_of(self.system, name)] for name in self.plane.names)
        return first, second

    def shooter(self, root: Root, free: int, value: float) -> Shooter:
        """A shooter that solves for parameter `free`, the other one being `value`."""
        machine = machine_at(self.system, root.machine, self.plane.names[1 - free], value)
        system, rpm = with_machine(self.system, machine)
        return Shooter(system, rpm, self.plane.names[free])

    def solve(self, root: Root, guess: list[float], free: int, value: float) -> Root | None:
        """The event near `guess` with the other parameter at `value`."""
        shooter = self.shooter(root, free, value)
        beside = replace(root, x=guess, parameter=shooter.parameter)
        match self.located.kind:
            case Kind.CORNER_IMPACT:
                return shooter.at_corner(beside, self.located.impact, self.located.side)
            case Kind.PERIOD_DOUBLING:
                return doubling_near(shooter, beside, 1e-6)
            case Kind.FOLD:
                return _fold(shooter, beside)
            case _:
                return _graze(shooter, beside, self.located)

    def trace(self, start: Root, sign: float) -> _Side:
        """The curve from its first point in one direction.

        The first step goes towards smaller (sign -1) or larger second parameters. Every step gives
        the parameter that changed more in the last one, and solves for the other one.
        """
        step = 1.0 / self.plane.steps
        roots = [start]
        slope = [0.0, sign]  # direction of the last step, in shares of the two ranges
        share = 1.0  # of a whole step
        refused = None
        while len(roots) < LONGEST_CURVE * self.plane.steps:
            given = 1 if abs(slope[1]) >= abs(slope[0]) else 0
            here = self.values(roots[-1])
            low, high = self.plane.ranges[given]
            way = share * step if slope[given] >= 0.0 else -share * step
            value = here[given] + way * self.spans[given]
            last = not low < value < high
            if last:
                value = high if slope[given] >= 0.0 else low
                if here[given] == value:
                    return _Side(roots[1:], Kind.END_OF_RANGE, self.plane.names[given])
            try:
                after, refusal = self._advance(roots, 1 - given, value, step)
                if refusal == Kind.ANOTHER_CORNER and after is not None:
                    back = here[given] - way * self.spans[given] if share < NEAR_CORNER else None
                    values = [value] if back is None else [value, back]
                    behind = self._behind_corner(after, 1 - given, values, share)
                    if behind is not None:
                        after = behind
                        refusal = None
                if refusal is not None or after is None:
                    refused = after or refused
                    share *= 0.5
                    if share < SMALLEST_SHARE:
                        end = refusal or Kind.LOST
                        return _Side(roots[1:], end, beyond=refused)
                    continue
                there = self.values(after)
                low, high = self.plane.ranges[1 - given]
                if not low <= there[1 - given] <= high:
                    bound = low if there[1 - given] < low else high
                    limit = self.plane.names[1 - given]
                    if here[1 - given] == bound:
                        return _Side(roots[1:], Kind.END_OF_RANGE, limit)
                    edge = self._at_bound(roots[-1], after, given, bound)
                    if edge is not None:
                        return _Side([*roots[1:], edge], Kind.END_OF_RANGE, limit)
                    share *= 0.5  # beyond the range there may be no machine
                    if share < SMALLEST_SHARE:
                        return _Side(roots[1:], Kind.END_OF_RANGE, limit)
                    continue
            except BudgetSpentError:
                return _Side(roots[1:], Kind.WORK_BUDGET)
            except NoMachineError:
                share *= 0.5
                if share < SMALLEST_SHARE:
                    return _Side(roots[1:], Kind.NO_MACHINE)
                continue
            refused = None
            share = min(1.0, 1.5 * share)
            roots.append(after)
            slope = [(b - a) / s for a, b, s in zip(here, there, self.spans, strict=True)]
            if last and self.values(after)[given] == value:
                return _Side(roots[1:], Kind.END_OF_RANGE, self.plane.names[given])
            if self._closes(roots, step):
                return _Side([*roots[1:], start], Kind.CLOSED)
        return _Side(roots[1:], Kind.LOST)

    def _closes(self, roots: Sequence[Root], step: float) -> bool:
        """True where the curve has been away, and has come back to its first point."""
        first, last = roots[0], roots[-1]
        if last.whole != first.whole or self._far(first, last) >= step:
            return False
        thetas = zip(first.theta, last.theta, strict=True)
        back = max(abs(a - b) for a, b in thetas) < MOST_TURNED * step
        return back and max(self._far(first, root) for root in roots) > AWAY * step

    def _far(self, one: Root, other: Root) -> float:
        """How far apart two points of the curve are, in shares of the ranges."""
        pairs = zip(self.values(one), self.values(other), self.spans, strict=True)
        return max(abs(a - b) / span for a, b, span in pairs)

    def _at_bound(self, last: Root, after: Root, free: int, bound: float) -> Root | None:
        """The point at which the curve leaves the range, between its last point and one beyond."""
        here, there = self.values(last), self.values(after)
        share = (bound - here[1 - free]) / (there[1 - free] - here[1 - free])
        guess = [a + share * (b - a) for a, b in zip(last.x[:-1], after.x[:-1], strict=True)]
        guess.append(here[free] + share * (there[free] - here[free]))
        root = self.solve(after, guess, free, bound) if after.whole == last.whole else None
        if root is None or self._refusal(root, self.shooter(root, free, bound)) is not None:
            return None
        low, high = self.plane.ranges[free]
        return root if low <= self.values(root)[free] <= high else None

    def _advance(
        self, roots: list[Root], free: int, value: float, step: float
    ) -> tuple[Root | None, Kind | None]:
        """The next point of the curve: (its root, None), or (a root or None, why it is refused).

        roots: the curve so far; free: which of the two parameters is solved for; value: of the
        other one; step: the length of a whole step, a share of a range. The guess is the last
        point, or lies on the line through the last two.
        """
        last = roots[-1]
        here = self.values(last)
        guess = [*last.x[:-1], here[free]]
        if len(roots) > 1 and roots[-2].whole == last.whole:
            before = self.values(roots[-2])
            moved = here[1 - free] - before[1 - free]
            share = (value - here[1 - free]) / moved if moved else 0.0
            if abs(share) <= 2.0:
                old = [*roots[-2].x[:-1], before[free]]
                guess = [a + share * (a - b) for a, b in zip(guess, old, strict=True)]
        after = self.solve(last, guess, free, value)
        if after is None:
            return None, Kind.LOST
        change = abs(self.values(after)[free] - here[free]) / self.spans[free]
        turned = max(abs(a - b) for a, b in zip(after.theta, last.theta, strict=True))
        if change > FREE_STEPS * step or turned > MOST_TURNED:
            return None, Kind.LOST
        return after, self._refusal(after, self.shooter(after, free, value))

    def _refusal(self, root: Root, shooter: Shooter) -> Kind | None:
        """Why a root is no point of the curve, or None."""
        if self._others_beyond(root, shooter):
            return Kind.ANOTHER_CORNER
        if collapses(shooter, root):
            return Kind.SHORTER_ORBIT
        if shooter.admits(root):
            return None
        if self.located.kind == Kind.GRAZING:
            # a contact at the graze itself is its own; a motion must lie close to one side of it
            size = abs(root.value) + shooter.scale
            widths = BESIDE_GRAZE if self.located.fading is None else BESIDE_FADING
            for width in widths:
                for side in (-1.0, 1.0):
                    beside = shooter.moved(root, root.value + side * width * size)
                    if beside is not None and shooter.admits(beside):
                        return None
        return Kind.NO_MOTION

    def _others_beyond(self, root: Root, shooter: Shooter) -> list[tuple[int, int]]:
        """(impact, side) of those beyond their stretch, but the one that is at its corner."""
        own = self.located.impact if self.located.kind == Kind.CORNER_IMPACT else -1
        return [(k, side) for _, k, side in shooter.beyond(root) if k != own]

    def _behind_corner(
        self, root: Root, free: int, values: Sequence[float], share: float
    ) -> Root | None:
        """The curve's next point with another impact in the next stretch, or None.

        root: with that impact beyond its stretch; values: of the given parameter, of which the
        first one with a point of the curve is taken.
        """
        shooter = self.shooter(root, free, values[0])
        others = self._others_beyond(root, shooter)
        if len(others) != 1:
            return None
        k, side = others[0]
        cam = shooter.system_of(root).cam
        stretches = cam.stretches
        turns, beside = divmod(root.whole[2 * k] + side, len(stretches))
        boundary = beside if side > 0 else root.whole[2 * k]
        if any(corner.stretch == boundary for corner in corner_list(cam)):
            same_map = self.located.kind in (Kind.CORNER_IMPACT, Kind.GRAZING)
            if not same_map or share >= NEAR_CORNER:
                return None
        whole = list(root.whole)
        whole[2 * k], whole[2 * k + 1] = beside, whole[2 * k + 1] + turns
        x = [*root.x[:-1], self.values(root)[free]]
        x[2 * k] -= turns * TURN
        there = replace(root, whole=tuple(whole), x=x)
        for value in values:
            after = self.solve(there, x, free, value)
            if after is not None and self._refusal(after, self.shooter(after, free, value)) is None:
                return after
        return None

    def point(self, root: Root) -> CurvePoint:
        """The root as a point of the curve, with both sides of a corner."""
        values = self.values(root)
        orbit = from_root(self.system, root)
        if self.located.kind == Kind.CORNER_IMPACT:
            free = 0 if place_of(self.system, self.plane.names[0]) == root.parameter else 1
            shooter = self.shooter(root, free, values[1 - free])
            crossing = None
            with suppress(BudgetSpentError, NoMachineError):
                crossing = cross(shooter, replace(self.located, root=root))
            return CurvePoint(*values, orbit, crossing)
        return CurvePoint(*values, orbit)


def _fold(shooter: Shooter, beside: Root) -> Root | None:
    """Along the branch the parameter has an extremum: its part of the tangent is zero."""
    row = [*beside.tangent[:-1], 0.0]
    square = 0.0
    for t in row:
        square += t * t
    if square == 0.0:
        return None
    row = [t / sqrt(square) for t in row]

    def at(place: float) -> tuple[float, Root | None]:
        root = shooter.correct(beside.x, beside.whole, beside.turns, row, beside.x, place)
        return (0.0, None) if root is None else (root.tangent[-1], root)

    return secant(at, 0.0, 1e-5, 1.0)


def _graze(shooter: Shooter, beside: Root, located: Located) -> Root | None:
    """Along the branch the gap where a flight comes nearest to the cam is zero, or a rate."""
    here = shooter.moved(beside, beside.value) or beside
    square = 0.0
    for t in here.tangent:
        square += t * t
    if square == 0.0:
        return None
    row = [t / sqrt(square) for t in here.tangent]
    faded: list[Root] = []  # an impact without a rate is none, so that its orbit may not be solved

    def at(place: float) -> tuple[float, Root | None]:
        root = shooter.correct(here.x, here.whole, here.turns, row, here.x, place)
        if root is None:
            return 0.0, None
        if located.fading is None:
            return touch_near(shooter, root, located)[0], root
        rate = root.rates[located.fading]
        if abs(rate) <= FADED * max(map(abs, root.rates)):
            faded.append(root)
        return rate, root

    return secant(at, 0.0, 1e-6, 1.0) or next(iter(faded), None)


def touch_near(shooter: Shooter, root: Root, located: Located) -> tuple[float, float]:
    """(gap m, rad of flight) where the flight of a graze comes nearest to the cam.

    The graze that was located has a phase only: in a flight of several turns the flight passes that
    phase more than once, and the passage with the smallest |gap| counts. Where the flight ends
    before it reaches the phase, the gap there is that of the flight continued.
    """
    k = located.impact
    const = root.const
    cam = shooter.system_of(root).cam
    theta, v = root.x[2 * k], root.x[2 * k + 1]
    c, c1, _ = lift(cam, root.stretch(k), theta)

    def gap(s: float) -> tuple[float, float, float]:
        """The gap after s rad of flight, and two derivatives."""
        q, w = move(const, c, c1 + v, s)
        phase = (theta + s) % TURN
        there = lift(cam, stretch_at(cam, phase), phase)
        return q - there[0], w - there[1], gap_accel(const, q, w, there[2])

    flight_length = root.flight_length(k)
    touches = []
    s = (located.phase - theta) % TURN
    while s < flight_length:
        touches.append(_lowest(gap, s, flight_length))
        s += TURN
    return min(touches, key=lambda touch: abs(touch[0]), default=(gap(s)[0], s))


def _lowest(
    gap: Callable[[float], tuple[float, float, float]], s: float, flight_length: float
) -> tuple[float, float]:
    """(gap, s) at the lowest place of a flight near s, by Newton's method on the gap's slope."""
    for _ in range(MOST_TOUCHES):
        _, slope, bend = gap(s)
        if not bend > 0.0:
            break
        change = min(max(-slope / bend, -LONGEST_TOUCH), LONGEST_TOUCH)
        if not 0.0 < s + change < flight_length or abs(change) <= 4.0 * ulp(s):
            break
        s += change
    return gap(s)[0], s
