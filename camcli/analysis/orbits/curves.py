"""A located bifurcation continued in two parameters: the curve on which it happens.

At every point one of the two parameters is given and the event is solved for the other: a corner
impact directly, a period doubling as a root of 1 + trace + det, a fold as the extremum of the
parameter along the branch, grazing as the edge of the certificate. The parameter that changes more
is the one given, so that the curve may turn round in either.
"""

from contextlib import suppress
from dataclasses import dataclass, replace
from math import sqrt

from camcli.analysis.bracketing import bracket
from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import (
    MOST_SECANTS,
    Crossing,
    Located,
    cross,
    doubling_near,
    secant,
)
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import PLACES, Root, Shooter, with_machine
from camcli.system import System

SMALLEST_SHARE = 1e-4  # of the spacing: a step below it ends the curve
LONGEST_CURVE = 40  # times the steps across the range: a curve longer than that is given up
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


@dataclass(frozen=True)
class Plane:
    """Names and ranges of both parameters, and the number of steps across them."""

    names: tuple[str, str]
    ranges: tuple[tuple[float, float], tuple[float, float]]
    steps: int


def curve(system: System, located: Located, plane: Plane, label: str, corner: str) -> Curve:
    """Continue a bifurcation of a branch in plane.names[0] through the plane."""
    tracer = _Tracer(system, located, plane)
    start = tracer.solve(located.root, located.root.x, 0, tracer.values(located.root)[1])
    if start is None:
        return Curve(located.kind, label, corner, *plane.names, (), (Kind.LOST, Kind.LOST))
    down, up = tracer.trace(start, -1.0), tracer.trace(start, 1.0)
    points = tuple(tracer.point(root) for root in [*reversed(down.roots), start, *up.roots])
    return Curve(
        located.kind, label, corner, *plane.names, points, (down.end, up.end),
        (down.limit, up.limit), located, (down.beyond, up.beyond),
    )  # fmt: skip


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
        first, second = (root.machine[PLACES[name]] for name in self.plane.names)
        return first, second

    def shooter(self, root: Root, free: int, value: float) -> Shooter:
        """A shooter that solves for parameter `free`, the other one being `value`."""
        machine = list(root.machine)
        machine[PLACES[self.plane.names[1 - free]]] = value
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
                return _graze(shooter, beside)

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
            try:
                after, refusal = self._advance(roots, 1 - given, value, step)
            except BudgetSpentError:
                return _Side(roots[1:], Kind.WORK_BUDGET)
            if refusal is not None or after is None:
                refused = after or refused
                share *= 0.5
                if share < SMALLEST_SHARE:
                    end = refusal or Kind.LOST
                    return _Side(roots[1:], end, beyond=refused)
                continue
            refused = None
            share = min(1.0, 1.5 * share)
            roots.append(after)
            there = self.values(after)
            slope = [(b - a) / s for a, b, s in zip(here, there, self.spans, strict=True)]
            low, high = self.plane.ranges[1 - given]
            if last or not low <= there[1 - given] <= high:
                limit = self.plane.names[given if last else 1 - given]
                return _Side(roots[1:], Kind.END_OF_RANGE, limit)
        return _Side(roots[1:], Kind.LOST)

    def _advance(
        self, roots: list[Root], free: int, value: float, step: float
    ) -> tuple[Root | None, Kind | None]:
        """(the next root, None), or (what was found there or None, why it is refused)."""
        last = roots[-1]
        here = self.values(last)
        guess = [*last.x[:-1], here[free]]
        if len(roots) > 1:
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
        shooter = self.shooter(after, free, value)
        if any(k != self.located.impact for _, k, _ in shooter.beyond(after)):
            return after, Kind.ANOTHER_CORNER
        if self.located.kind != Kind.GRAZING and not shooter.admits(after):
            return after, Kind.NO_MOTION
        return after, None

    def point(self, root: Root) -> CurvePoint:
        """The root as a point of the curve, with both sides of a corner."""
        values = self.values(root)
        orbit = from_root(self.system, root)
        if self.located.kind == Kind.CORNER_IMPACT:
            free = 0 if PLACES[self.plane.names[0]] == root.parameter else 1
            shooter = self.shooter(root, free, values[1 - free])
            crossing = None
            with suppress(BudgetSpentError):
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


def _graze(shooter: Shooter, beside: Root) -> Root | None:
    """The last motion before the certificate is lost, looked for on both sides."""
    best: dict[float, Root] = {}

    def bad(value: float) -> float:
        """1 where the motion at this value is not certified, else -1, and it is kept in `best`."""
        root = shooter.moved(beside, value)
        if root is None or not shooter.admits(root):
            return 1.0
        best[value] = root
        return -1.0

    value = beside.value
    width = 1e-6 * (abs(beside.value) + shooter.scale)
    for _ in range(MOST_SECANTS):
        below, above = bad(value - width), bad(value + width)
        if below != above:
            break
        width *= 2.0
    else:
        return None
    sign = 1.0 if below < 0.0 else -1.0  # the motion is there below, else above: mirrored
    last, *_ = bracket(
        lambda x: bad(sign * x), sign * value - width, sign * value + width, -1.0, 1.0
    )
    return best.get(sign * last)
