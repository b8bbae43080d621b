"""A located bifurcation continued in two parameters: the curve on which it happens.

At every point one of the two parameters is given and the event is solved for the other: a corner
impact directly, a period doubling as a root of 1 + trace + det, a fold as the extremum of the
parameter along the branch, grazing as the edge of the certificate. The parameter that changes more
is the one given, so that the curve may turn round in either.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from camcli.analysis.bracketing import bracket
from camcli.analysis.orbits.arclength import beyond
from camcli.analysis.orbits.branch import Bifurcation
from camcli.analysis.orbits.collide import with_machine
from camcli.analysis.orbits.crossing import cross
from camcli.analysis.orbits.locate import (
    CORNER,
    FOLD,
    GRAZING,
    PERIOD_DOUBLING,
    Found,
    at_corner,
    flip_test,
    secant,
)
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import PARAMETERS, Root, Shooter
from camcli.kernel.certify import ADMISSIBLE
from camcli.system import System

KINDS = (PERIOD_DOUBLING, FOLD, CORNER, GRAZING)
MOST_SECANTS = 30
SMALLEST = 1e-4  # of the spacing: a step below it ends the curve
END_RANGE, END_CORNER, END_MOTION, END_LOST = (
    "end-of-range",
    "an impact reaches a corner",
    "the orbit is no motion any more",
    "lost",
)


@dataclass(frozen=True)
class CurvePoint:
    """One point: both parameters, the orbit, and at a corner impact the linear parts."""

    first: float
    second: float
    orbit: PeriodicOrbit
    left: tuple[float, float] | None = None
    right: tuple[float, float] | None = None


@dataclass(frozen=True)
class Curve:
    """A curve of one kind of bifurcation; ends: why it stops on either side."""

    kind: str
    label: str
    corner: str
    first: str
    second: str
    points: tuple[CurvePoint, ...]
    ends: tuple[str, str]


@dataclass(frozen=True)
class Bounds:
    """Ranges of both parameters, and the number of steps across them."""

    first: tuple[float, float]
    second: tuple[float, float]
    steps: int


def curve(
    system: System, bifurcation: Bifurcation, first: str, second: str, bounds: Bounds
) -> Curve:
    """Continue a bifurcation located in `first` through the plane of `first` and `second`."""
    tracer = _Tracer(system, bifurcation, first, second, bounds)
    start = tracer.begin()
    down, end_down = tracer.trace(start, -1.0)
    up, end_up = tracer.trace(start, 1.0)
    points = (*reversed(down), *([start] if start else []), *up)
    return Curve(
        bifurcation.kind, bifurcation.label, bifurcation.corner, first, second,
        tuple(tracer.point(root) for root in points), (end_down, end_up),
    )  # fmt: skip


class _Tracer:
    def __init__(self, system, bifurcation: Bifurcation, first: str, second: str, bounds: Bounds):
        self.system, self.kind = system, bifurcation.kind
        self.root = bifurcation.orbit.root
        self.names, self.bounds = (first, second), bounds
        self.impact, self.side = bifurcation.impact, bifurcation.side

    def values(self, root: Root) -> tuple[float, float]:
        """Both parameters of a root."""
        return tuple(root.machine[PARAMETERS[name]] for name in self.names)

    def shooter(self, root: Root, free: int, value: float) -> Shooter:
        """A shooter that solves for parameter `free`, the other one being `value`."""
        machine = list(root.machine)
        machine[PARAMETERS[self.names[1 - free]]] = value
        system, rpm = with_machine(self.system, machine)
        return Shooter(system, rpm, self.names[free])

    def begin(self) -> Root | None:
        """The bifurcation itself, solved again."""
        return self.solve(self.root, self.root.x, 0, self.values(self.root)[1])

    def solve(self, root: Root, guess: list[float], free: int, value: float) -> Root | None:
        """The event near `guess` with the other parameter at `value`."""
        shooter = self.shooter(root, free, value)
        near = replace(root, x=guess, parameter=shooter.parameter)
        solver = {
            CORNER: self._corner, PERIOD_DOUBLING: self._flip, FOLD: self._fold,
            GRAZING: self._graze,
        }[self.kind]  # fmt: skip
        return solver(shooter, near)

    def _corner(self, shooter: Shooter, near: Root) -> Root | None:
        return at_corner(shooter, near, self.impact, self.side)

    def _flip(self, shooter: Shooter, near: Root) -> Root | None:
        def at(value: float) -> tuple[float, Root | None]:
            root = shooter.at_value(near.x, near.whole, near.turns, value)
            return (0.0, None) if root is None else (flip_test(root), root)

        size = abs(near.x[-1]) + shooter.scale
        return secant(at, near.x[-1], 1e-6 * size, size)

    def _fold(self, shooter: Shooter, near: Root) -> Root | None:
        """Along the branch the parameter has an extremum: its part of the tangent is zero."""
        row = [*near.tangent[:-1], 0.0]
        length = sum(t * t for t in row) ** 0.5
        if length == 0.0:
            return None
        row = [t / length for t in row]

        def at(place: float) -> tuple[float, Root | None]:
            root = shooter.correct(near.x, near.whole, near.turns, row, near.x, place)
            return (0.0, None) if root is None else (root.tangent[-1], root)

        return secant(at, 0.0, 1e-5, 1.0)

    def _graze(self, shooter: Shooter, near: Root) -> Root | None:
        """The last motion before the certificate is lost, looked for on both sides."""
        best: dict[float, Root] = {}

        def bad(value: float) -> float:
            root = shooter.at_value(near.x, near.whole, near.turns, value)
            if root is None or shooter.verdict(root)[0] != ADMISSIBLE:
                return 1.0
            best[value] = root
            return -1.0

        value, width = near.x[-1], 1e-6 * (abs(near.x[-1]) + shooter.scale)
        for _ in range(MOST_SECANTS):
            low, high = bad(value - width), bad(value + width)
            if low != high:
                break
            width *= 2.0
        else:
            return None
        sign = 1.0 if low < high else -1.0
        ends = sorted((sign * (value - width), sign * (value + width)))
        low, _, _, _ = bracket(lambda x: bad(sign * x), ends[0], ends[1], -1.0, 1.0)
        return best.get(sign * low)

    def trace(self, start: Root | None, sign: float) -> tuple[list[Root], str]:
        """Roots from the start on, towards smaller (-1) or larger second parameters first."""
        if start is None:
            return [], END_LOST
        spans = [high - low for low, high in (self.bounds.first, self.bounds.second)]
        step = 1.0 / self.bounds.steps
        roots, slope, share = [start], [0.0, sign], 1.0
        while len(roots) < 40 * self.bounds.steps:
            given = 1 if abs(slope[1]) >= abs(slope[0]) else 0
            here = self.values(roots[-1])
            value, last = self._next(here, given, slope, spans, share * step)
            after = self._advance(roots, 1 - given, value, spans, step)
            if isinstance(after, str):
                share *= 0.5
                if share < SMALLEST:
                    return roots[1:], after
                continue
            share = min(1.0, 1.5 * share)
            roots.append(after)
            there = self.values(after)
            slope = [(b - a) / s for a, b, s in zip(here, there, spans, strict=True)]
            low, high = (self.bounds.first, self.bounds.second)[1 - given]
            if last or not low <= there[1 - given] <= high:
                return roots[1:], END_RANGE
        return roots[1:], END_LOST

    def _next(self, here, given: int, slope, spans, length: float) -> tuple[float, bool]:
        """The next value of the given parameter, and whether it is the end of its range."""
        low, high = (self.bounds.first, self.bounds.second)[given]
        up = slope[given] >= 0.0
        value = here[given] + (length if up else -length) * spans[given]
        if value >= high or value <= low:
            return (high if up else low), True
        return value, False

    def _advance(self, roots: list[Root], free: int, value: float, spans, step: float):
        """The next root, or the reason why there is none."""
        last, guess = roots[-1], list(roots[-1].x)
        guess[-1] = self.values(last)[free]
        if len(roots) > 1:
            before, here = self.values(roots[-2])[1 - free], self.values(last)[1 - free]
            share = (value - here) / (here - before) if here != before else 0.0
            if abs(share) <= 2.0:
                guess[:-1] = [
                    a + share * (a - b) for a, b in zip(last.x, roots[-2].x, strict=True)
                ][:-1]
                old = self.values(roots[-2])[free]
                guess[-1] += share * (guess[-1] - old)
        after = self.solve(last, guess, free, value)
        if after is None:
            return END_LOST
        moved = abs(self.values(after)[free] - self.values(last)[free]) / spans[free]
        if moved > 10.0 * step or max(map(abs, _difference(after, last))) > 0.5:
            return END_LOST
        shooter = self.shooter(after, free, value)
        outside = [k for _, k, _ in beyond(shooter, after) if k != self.impact]
        if outside:
            return END_CORNER
        if self.kind != GRAZING and shooter.verdict(after)[0] != ADMISSIBLE:
            return END_MOTION
        return after

    def point(self, root: Root) -> CurvePoint:
        """The root as a point of the curve, with both sides of a corner."""
        first, second = self.values(root)
        orbit = from_root(self.system, root)
        if self.kind != CORNER:
            return CurvePoint(first, second, orbit)
        free = 0 if PARAMETERS[self.names[0]] == root.parameter else 1
        shooter = self.shooter(root, free, (first, second)[1 - free])
        crossing = cross(shooter, Found(CORNER, root, 0.0, 0.0, "", self.impact, self.side))
        if crossing is None:
            return CurvePoint(first, second, orbit)
        sides = [(side.trace, side.det) for side in (crossing.left, crossing.right)]
        return CurvePoint(first, second, orbit, *sides)


def _difference(a: Root, b: Root) -> list[float]:
    return [x - y for x, y in zip(a.theta, b.theta, strict=True)]
