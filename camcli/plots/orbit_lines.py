"""What the pictures of orbits show: lines along a branch, their look, and the events on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import degrees, inf
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from camcli.analysis.orbits.arclength import Metric
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import Root, multipliers
from camcli.analysis.orbits.study import Bifurcation
from camcli.plots import style
from camcli.plots.axes import DASHED, TURN_DEG

NEAR_DEG = 20.0  # phases further apart do not continue one another
SAME = 1e-11  # relative distance of parameters at which two points are the two sides of a corner
JUMP = 1e-6  # relative change of the trace there that breaks the lines of the multipliers
PARTS = 12  # of a step, for the curved paths of the multipliers


@dataclass
class Strand:
    """A line over the parameter, all of it stable or all of it unstable."""

    stable: bool
    x: list[float] = field(default_factory=list)
    y: list[Any] = field(default_factory=list)


@dataclass(frozen=True)
class Event:
    """One or more equal bifurcations: where the marks are, on which branches, what leaves."""

    number: int
    source: Bifurcation
    branches: tuple[int, ...]
    leaves: tuple[int, ...]
    phases: tuple[float, ...]
    positions: tuple[float, ...]

    @property
    def value(self) -> float:
        """The parameter there."""
        return self.source.value

    @property
    def name(self) -> str:
        """Period doubling, corner impact at c, ..."""
        words = self.source.kind.replace("-", " ")
        return f"{words} at {self.source.corner}" if self.source.corner else words


def events_of(bifurcations: Sequence[Bifurcation], corners: dict[str, float]) -> list[Event]:
    """In ascending order, what several branches share but once."""
    groups: dict[tuple, list[Bifurcation]] = {}
    for one in sorted(bifurcations, key=lambda one: (one.value, one.branch)):
        groups.setdefault((one.kind, one.corner, f"{one.value:.9g}"), []).append(one)
    out = []
    for number, group in enumerate(groups.values(), 1):
        first = group[0]
        at = (corners[first.corner],) if first.corner in corners else phases(first.orbit)
        on = tuple(sorted({one.branch for one in group}))
        leaves = tuple(dict.fromkeys(one.continues for one in group if one.continues))
        out.append(Event(number, first, on, leaves, at, positions(first.orbit)))
    return out


def phases(orbit: PeriodicOrbit) -> tuple[float, ...]:
    """Impact phases in degrees, in an order that does not change along a branch."""
    theta = orbit.theta if orbit.root is None else orbit.root.theta
    return tuple(degrees(x) % TURN_DEG for x in theta)


def positions(orbit: PeriodicOrbit) -> tuple[float, ...]:
    """Stroboscopic positions."""
    return tuple(q for q, _ in orbit.states)


def radius(orbit: PeriodicOrbit) -> float:
    """The larger |multiplier|."""
    return max(abs(mu) for mu in orbit.multipliers)


def colours(every: Sequence[Sequence[PeriodicOrbit]]) -> list[str]:
    """One per branch, given its orbits: by period and stability, apart where two share those."""
    wanted: dict[int, str] = {}
    for rests in (False, True):
        mine = [k for k, orbits in enumerate(every) if any(o.resting for o in orbits) == rests]
        some = [style.STICKING if rests else _bouncing(every[k]) for k in mine]
        series = style.RESTING if rests else style.SERIES
        wanted.update(zip(mine, style.apart(some, series), strict=True))
    return [wanted[k] for k in range(len(every))]


def _bouncing(orbits: Sequence[PeriodicOrbit]) -> str:
    stable = [orbit for orbit in orbits if orbit.stable]
    return style.period_colour(stable[0].turns) if stable else style.SADDLE


# --- lines over the parameter


def strands(
    points: Sequence[PeriodicOrbit],
    of: Callable[[PeriodicOrbit], Sequence[float]],
    turn: float = 0.0,
) -> list[Strand]:
    """Lines through the values `of` neighbouring points; `turn`: values wrap round there."""
    out: list[Strand] = []
    ends: dict[int, Strand] = {}
    for before, after in pairwise(points):
        stable = _steady(before, after)
        reached: dict[int, Strand] = {}
        a, b = of(before), of(after)
        for i, j in _links(a, b, turn):
            strand = ends.get(i)
            if strand is None or strand.stable != stable:
                strand = Strand(stable, [before.value], [a[i]])
                out.append(strand)
            strand.x.append(after.value)
            strand.y.append(b[j])
            reached[j] = strand
        ends = reached
    return out


def _steady(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Stability between neighbours: that of the one further from the border."""
    return max(before, after, key=lambda orbit: abs(radius(orbit) - 1.0)).stable


def _links(a: Sequence[float], b: Sequence[float], turn: float) -> list[tuple[int, int]]:
    """Which value continues which: phases in their order unless they jump, else the nearest."""
    far = [NEAR_DEG < abs(x - y) < turn - NEAR_DEG for x, y in zip(a, b, strict=False)]
    if turn and len(a) == len(b) and not any(far):
        return [(k, k) for k in range(len(a)) if abs(a[k] - b[k]) <= NEAR_DEG]
    limit = NEAR_DEG if turn else inf
    near = sorted((abs(x - y), i, j) for i, x in enumerate(a) for j, y in enumerate(b))
    links: list[tuple[int, int]] = []
    for away, i, j in near:
        if away <= limit and all(i != k and j != n for k, n in links):
            links.append((i, j))
    return links


def curved(points: Sequence[PeriodicOrbit], low: float, high: float) -> list[PeriodicOrbit]:
    """The points with more between them, by their tangents, where the parameter is in a range."""
    out = list(points[:1])
    for before, after in pairwise(points):
        seen = min(before.value, after.value) <= high and max(before.value, after.value) >= low
        a, b = before.root, after.root
        if seen and a is not None and b is not None and a.whole == b.whole:
            out += [_between(before, a, after, b, part / PARTS) for part in range(1, PARTS)]
        out.append(after)
    return out


def _between(
    before: PeriodicOrbit, a: Root, after: PeriodicOrbit, b: Root, s: float
) -> PeriodicOrbit:
    """A point of the cubic through two roots with their tangents; the trace on a line."""
    way = np.subtract(b.x, a.x)
    metric = Metric.of(a, max(abs(before.value), abs(after.value)) or 1.0)
    length = metric.dot(way, way) ** 0.5
    x = np.array(a.x)
    if length:
        start, end = metric.oriented(a, way), metric.oriented(b, way)
        x += s * s * (3.0 - 2.0 * s) * way
        x += length * s * (1.0 - s) * ((1.0 - s) * start - s * end)
    return replace(
        before,
        value=float(x[-1]),
        theta=tuple(x[:-1:2].tolist()),
        trace=before.trace + s * (after.trace - before.trace),
        det=before.det + s * (after.det - before.det),
        root=None,
    )


# --- paths of the multipliers


def paths(points: Sequence[PeriodicOrbit]) -> list[Strand]:
    """Both multipliers along a branch, finely; broken where they jump at a corner."""
    out: list[Strand] = []
    going: list[Strand] = []
    for before, after in pairwise(points):
        aside = abs(after.value - before.value) <= SAME * abs(before.value)
        if aside and abs(after.trace - before.trace) > JUMP * (1.0 + abs(before.trace)):
            going = []
            continue
        stable = _steady(before, after)
        if not going or going[0].stable != stable:
            going = [Strand(stable, [before.value], [mu]) for mu in before.multipliers]
            out += going
        first = np.array([before.value, before.trace, before.det])
        last = np.array([after.value, after.trace, after.det])
        for share in _shares(before, after):
            value, trace, det = (first + share * (last - first)).tolist()
            for strand, mu in zip(going, multipliers(trace, det), strict=True):
                strand.x.append(value)
                strand.y.append(mu)
    return out


def _shares(before: PeriodicOrbit, after: PeriodicOrbit) -> list[float]:
    """Parts of a step, and where two real multipliers meet on it: (trace/2)^2 = det."""
    t, dt, d, dd = before.trace, after.trace - before.trace, before.det, after.det - before.det
    shares = [part / PARTS for part in range(1, PARTS + 1)]
    a, b, c = 0.25 * dt * dt, 0.5 * t * dt - dd, 0.25 * t * t - d
    disc = b * b - 4.0 * a * c
    if a > 0.0 and disc > 0.0:
        shares += [(-b + sign * disc**0.5) / (2.0 * a) for sign in (-1.0, 1.0)]
    return sorted(share for share in shares if 0.0 < share <= 1.0)


def line_look(stable: bool) -> dict[str, Any]:
    """Stable orbits have solid lines, unstable ones dashed and thinner."""
    return {"linewidth": 1.4} if stable else {"linewidth": 1.1, "linestyle": DASHED}


def draw_strands(
    axes: Axes, lines: Sequence[Strand], colour: str, view: Callable = np.asarray
) -> None:
    """All lines of a branch; `view` makes the y of what a strand holds."""
    for stable in (True, False):
        mine = [line for line in lines if line.stable == stable]
        if mine:
            x = [value for line in mine for value in (*line.x, np.nan)]
            y = [value for line in mine for value in (*view(line.y), np.nan)]
            axes.plot(x, y, color=colour, zorder=3, **line_look(stable))
