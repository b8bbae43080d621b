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
    def values(self) -> tuple[float, float]:
        """Both parameters."""
        return self.first, self.second

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
        first = [point.first for point in self.points]
        second = [point.second for point in self.points]
        return CurveLine(self.kind, self.label, self.corner, first, second)


@dataclass(frozen=True)
class Plane:
    """Names and ranges of both parameters, and the number of steps across them."""

    names: tuple[str, str]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    steps: int


def curve(system: System, located: Located, plane: Plane, label: str, corner: str) -> Curve:
    """Continue a bifurcation of a branch in one of plane.names through the plane.

    label: of its orbits; corner: the name of the corner that it happens at, or empty.
    """
    tracer = _Tracer(system, located, plane)
    root = located.root
    free = 0 if root.parameter == place_of(system, plane.names[0]) else 1
    start = tracer.solve(root, root.x, free, tracer.values(root)[1 - free])
    first_name, second_name = plane.names
    if start is None:
        ends = (Kind.LOST, Kind.LOST)
        return Curve(
            located.kind, label, corner, first_name, second_name, (), ends, located=located
        )
    down = tracer.trace(start, -1.0)
    # one that comes back to its first point is whole
    up = _Side([], Kind.CLOSED) if down.end == Kind.CLOSED else tracer.trace(start, 1.0)
    roots = [*reversed(down.roots), start, *up.roots]
    return Curve(
        kind=located.kind,
        label=label,
        corner=corner,
        first=first_name,
        second=second_name,
        points=tuple(tracer.point(root) for root in roots),
        ends=(down.end, up.end),
        limits=(down.limit, up.limit),
        located=located,
        beyond=(down.beyond, up.beyond),
    )


def passes(system: System, known: Curve, located: Located, plane: Plane) -> bool:
    """Whether a known curve leads through an event: the curve is solved there once more.

    The two are one if the parameter that is solved for and the phases of the impacts agree.
    """
    if known.located is None or known.kind != located.kind:
        return False
    root = located.root
    free = 0 if root.parameter == place_of(system, plane.names[0]) else 1
    tracer = _Tracer(system, known.located, plane)
    values = tracer.values(root)
    given = values[1 - free]
    for before, behind in pairwise(known.points):
        given_before = before.values[1 - free]
        given_behind = behind.values[1 - free]
        if not min(given_before, given_behind) <= given <= max(given_before, given_behind):
            continue
        nearer = before if abs(given_before - given) <= abs(given_behind - given) else behind
        beside = nearer.orbit.root
        if beside is None or beside.count != root.count:
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


class _Advance(NamedTuple):
    """A step along a curve: the root it leads to, and why that is no point of it, or None.

    root: None where nothing was solved.
    """

    root: Root | None
    refusal: Kind | None


class _Target(NamedTuple):
    """Where the next point of a curve is looked for.

    given: the parameter (0 or 1) that has a value there, the other one is solved for; way: from the
    last point to there, in shares of the range; at_end: whether the value is an end of the range.
    """

    given: int
    value: float
    way: float
    at_end: bool


class _Attempt(NamedTuple):
    """A step of a curve, tried: the root of the next point, or how the curve ends.

    shorter_may_do: the end is one only if no shorter step leads on.
    """

    root: Root | None = None
    end: _Side | None = None
    shorter_may_do: bool = False


def _phases_apart(first: Root, second: Root) -> float:
    """How far apart the impacts of two points of a curve are at most, rad."""
    return max(abs(a - b) for a, b in zip(first.theta, second.theta, strict=True))


def is_same_motion(apart: float, moved: float, step: float) -> bool:
    """Whether a curve that comes by its first point passes it with the same motion.

    Both parameters are a step or less from there; another motion may have its event there as well.
    The impacts of one motion are no farther apart than two steps move them.

    apart: how far the impacts are from those of the first point, rad; moved: how far the last step
    has moved them, rad; step: the length of a whole step, a share of a range.

    Impacts that move by 0.1 rad in a step are 0.08 rad from those of the first point where the
    curve comes by; those of another motion are half a radian away:

    >>> is_same_motion(0.08, 0.1, 0.02), is_same_motion(0.5, 0.1, 0.02)
    (True, False)
    """
    return apart < max(MOST_TURNED * step, 2.0 * moved)


class _Tracer:
    """One curve: the event solved for one parameter, the other being given."""

    def __init__(self, system: System, located: Located, plane: Plane):
        self.system = system
        self.located = located
        self.plane = plane
        self.spans = [high - low for low, high in plane.ranges]
        self.step = 1.0 / plane.steps  # the length of a whole step, a share of a range

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
        the parameter that changed more in the last one, and solves for the other one; one that
        fails is halved.
        """
        roots = [start]
        slope = (0.0, sign)  # direction of the last step, in shares of the two ranges
        share = 1.0  # of a whole step
        refused = None  # the last root that is no point of the curve
        while len(roots) < LONGEST_CURVE * self.plane.steps:
            here = self.values(roots[-1])
            target = self._target(here, slope, share)
            name = self.plane.names[target.given]
            if target.at_end and here[target.given] == target.value:
                return _Side(roots[1:], Kind.END_OF_RANGE, name)
            attempt = self._attempt(roots, target, share, refused)
            if attempt.end is not None:
                share *= 0.5
                if not attempt.shorter_may_do or share < SMALLEST_SHARE:
                    return attempt.end
                refused = attempt.end.beyond or refused
            if attempt.root is None:
                continue
            refused = None
            share = min(1.0, 1.5 * share)
            roots.append(attempt.root)
            there = self.values(attempt.root)
            first, second = ((b - a) / s for a, b, s in zip(here, there, self.spans, strict=True))
            slope = (first, second)
            if target.at_end and there[target.given] == target.value:
                return _Side(roots[1:], Kind.END_OF_RANGE, name)
            if self._closes(roots):
                return _Side([*roots[1:], start], Kind.CLOSED)
        return _Side(roots[1:], Kind.LOST)

    def _target(self, here: Sequence[float], slope: Sequence[float], share: float) -> _Target:
        """Where the next point is looked for, a share of a step ahead, or at the end of the range.

        here: both parameters of the last point; slope: direction of the last step.
        """
        given = 1 if abs(slope[1]) >= abs(slope[0]) else 0
        low, high = self.plane.ranges[given]
        upward = slope[given] >= 0.0
        way = share * self.step if upward else -share * self.step
        value = here[given] + way * self.spans[given]
        if low < value < high:
            return _Target(given, value, way, at_end=False)
        return _Target(given, high if upward else low, way, at_end=True)

    def _attempt(
        self, roots: list[Root], target: _Target, share: float, refused: Root | None
    ) -> _Attempt:
        """Try the step to a target; refused: a root behind the last point that was none before."""
        try:
            root, refusal = self._next(roots, target, share)
            if root is not None and refusal is None:
                return self._within_range(roots, root, target.given)
            end = _Side(roots[1:], refusal or Kind.LOST, beyond=root or refused)
        except BudgetSpentError:
            return _Attempt(end=_Side(roots[1:], Kind.WORK_BUDGET))
        except NoMachineError:
            end = _Side(roots[1:], Kind.NO_MACHINE)
        return _Attempt(end=end, shorter_may_do=True)

    def _next(self, roots: list[Root], target: _Target, share: float) -> _Advance:
        """The root at a target; where another impact passes a corner on the way, behind that.

        Very near the corner (share of a step) the curve may turn back there: then the parameter is
        given a step back, too.
        """
        free = 1 - target.given
        advance = self._advance(roots, free, target.value)
        if advance.refusal != Kind.ANOTHER_CORNER or advance.root is None:
            return advance
        values = [target.value]
        if share < NEAR_CORNER:
            here = self.values(roots[-1])[target.given]
            values.append(here - target.way * self.spans[target.given])
        behind = self._behind_corner(advance.root, free, values, share)
        return advance if behind is None else _Advance(behind, None)

    def _within_range(self, roots: list[Root], root: Root, given: int) -> _Attempt:
        """The root as the next point if the parameter solved for is in its range.

        Else the curve ends at the range's bound, where it is solved again.
        """
        free = 1 - given
        low, high = self.plane.ranges[free]
        value = self.values(root)[free]
        if low <= value <= high:
            return _Attempt(root)
        bound = low if value < low else high
        end = _Side(roots[1:], Kind.END_OF_RANGE, self.plane.names[free])
        if self.values(roots[-1])[free] == bound:
            return _Attempt(end=end)
        edge = self._at_bound(roots[-1], root, given, bound)
        if edge is not None:
            return _Attempt(end=replace(end, roots=[*roots[1:], edge]))
        return _Attempt(end=end, shorter_may_do=True)  # beyond the range there may be no machine

    def _closes(self, roots: Sequence[Root]) -> bool:
        """True where the curve has been away, and has come back to its first point."""
        first = roots[0]
        last = roots[-1]
        if last.whole != first.whole or self._far(first, last) >= self.step:
            return False
        moved = _phases_apart(roots[-2], last) if roots[-2].whole == last.whole else 0.0
        if not is_same_motion(_phases_apart(first, last), moved, self.step):
            return False
        return max(self._far(first, root) for root in roots) > AWAY * self.step

    def _far(self, first: Root, second: Root) -> float:
        """How far apart two points of the curve are, in shares of the ranges."""
        pairs = zip(self.values(first), self.values(second), self.spans, strict=True)
        return max(abs(a - b) / span for a, b, span in pairs)

    def _at_bound(self, last: Root, after: Root, free: int, bound: float) -> Root | None:
        """The point at which the curve leaves the range of a parameter, given there.

        It lies between the curve's last point and a root `after` beyond the bound; free: the other
        parameter, solved for. None where nothing is solved, or what is has left the range, too.
        """
        given = 1 - free
        here = self.values(last)
        there = self.values(after)
        share = (bound - here[given]) / (there[given] - here[given])
        guess = [a + share * (b - a) for a, b in zip(last.x[:-1], after.x[:-1], strict=True)]
        guess.append(here[free] + share * (there[free] - here[free]))
        root = self.solve(after, guess, free, bound) if after.whole == last.whole else None
        if root is None or self._refusal(root, self.shooter(root, free, bound)) is not None:
            return None
        low, high = self.plane.ranges[free]
        return root if low <= self.values(root)[free] <= high else None

    def _advance(self, roots: list[Root], free: int, value: float) -> _Advance:
        """The next root of the curve, if one is solved without too large a step.

        roots: the curve so far; free: which of the two parameters is solved for; value: of the
        other one. The guess is the last point, or lies on the line through the last two.
        """
        given = 1 - free
        last = roots[-1]
        here = self.values(last)
        guess = [*last.x[:-1], here[free]]
        if len(roots) > 1 and roots[-2].whole == last.whole:
            before = self.values(roots[-2])
            moved = here[given] - before[given]
            share = (value - here[given]) / moved if moved else 0.0
            if abs(share) <= 2.0:
                old = [*roots[-2].x[:-1], before[free]]
                guess = [a + share * (a - b) for a, b in zip(guess, old, strict=True)]
        after = self.solve(last, guess, free, value)
        if after is None:
            return _Advance(None, Kind.LOST)
        change = abs(self.values(after)[free] - here[free]) / self.spans[free]
        if change > FREE_STEPS * self.step or _phases_apart(after, last) > MOST_TURNED:
            return _Advance(None, Kind.LOST)
        return _Advance(after, self._refusal(after, self.shooter(after, free, value)))

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
        first one with a point of the curve is taken; share: of a step. Where the stretch ends at a
        corner of the cam, only a curve on which the map goes on, and only very near to it.
        """
        shooter = self.shooter(root, free, values[0])
        others = self._others_beyond(root, shooter)
        if len(others) != 1:
            return None
        k, side = others[0]
        cam = shooter.system_of(root).cam
        turns, stretch_behind = divmod(root.stretch(k) + side, len(cam.stretches))
        boundary = stretch_behind if side > 0 else root.stretch(k)  # the stretch that begins there
        if any(corner.stretch == boundary for corner in corner_list(cam)):
            goes_on = self.located.kind in (Kind.CORNER_IMPACT, Kind.GRAZING)
            if not goes_on or share >= NEAR_CORNER:
                return None
        x = [*root.x[:-1], self.values(root)[free]]
        x[2 * k] -= turns * TURN
        beside = replace(root.landing_on(k, stretch_behind, root.turn(k) + turns), x=x)
        for value in values:
            after = self.solve(beside, x, free, value)
            if after is not None and self._refusal(after, self.shooter(after, free, value)) is None:
                return after
        return None

    def point(self, root: Root) -> CurvePoint:
        """The root as a point of the curve, with both sides of a corner."""
        first, second = self.values(root)
        crossing = None
        if self.located.kind == Kind.CORNER_IMPACT:
            free = 0 if place_of(self.system, self.plane.names[0]) == root.parameter else 1
            shooter = self.shooter(root, free, (first, second)[1 - free])
            with suppress(BudgetSpentError, NoMachineError):
                crossing = cross(shooter, replace(self.located, root=root))
        return CurvePoint(first, second, from_root(self.system, root), crossing)


def _fold(shooter: Shooter, beside: Root) -> Root | None:
    """The fold near a root: along the branch the parameter's part of the tangent is zero there.

    Roots are solved on planes across the direction of the branch without its parameter's part.
    """
    row = _unit([*beside.tangent[:-1], 0.0])
    if row is None:
        return None

    def at(place: float) -> tuple[float, Root | None]:
        root = shooter.correct(beside.x, beside.whole, beside.turns, row, beside.x, place)
        return (0.0, None) if root is None else (root.tangent[-1], root)

    return secant(at, 0.0, 1e-5, 1.0)


def _unit(direction: Sequence[float]) -> list[float] | None:
    """The direction with length 1, None where it has none; squares are added up in order."""
    square = 0.0
    for component in direction:
        square += component * component
    if square == 0.0:
        return None
    return [component / sqrt(square) for component in direction]


def _graze(shooter: Shooter, beside: Root, located: Located) -> Root | None:
    """The graze near a root: along the branch the gap where the flight comes nearest is zero there.

    Where an impact fades its rate is zero instead.
    """
    here = shooter.moved(beside, beside.value) or beside
    row = _unit(here.tangent)
    if row is None:
        return None
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
    theta = root.x[2 * k]
    v = root.x[2 * k + 1]
    start_c, start_c1, _ = lift(cam, root.stretch(k), theta)

    def gap(s: float) -> tuple[float, float, float]:
        """The gap after s rad of flight, and two derivatives."""
        q, w = move(const, start_c, start_c1 + v, s)
        phase = (theta + s) % TURN
        c, c1, c2 = lift(cam, stretch_at(cam, phase), phase)
        return q - c, w - c1, gap_accel(const, q, w, c2)

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
