"""What the pictures of orbits show: lines along a branch, paths of its multipliers, its events."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import degrees, inf, log10
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MultipleLocator
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from camcli.analysis.multipliers import multipliers
from camcli.analysis.orbits.arclength import Metric
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.shooter import Root
from camcli.analysis.orbits.study import Bifurcation
from camcli.plots import style
from camcli.plots.axes import DASHED, DOTTED, TURN_DEG
from camcli.words.in_print import number_text

NEAR_DEG = 20.0  # phases further apart do not continue one another
SAME = 1e-11  # relative distance of parameters at which two points are the two sides of a corner
JUMP = 1e-6  # relative change of the trace there that breaks the lines of the multipliers
PARTS = 12  # of a step, for the curved paths of the multipliers
FURTHEST = 1.5  # beyond, only a triangle at the border of the plane says where multipliers are
LINEAR = 4.0  # real parts up to this are drawn on a linear axis
LEAST = 1.2  # half width of the plane around the unit circle
ASIDE = 0.97  # of half the width of the plane, where words end
SHORT = 0.16  # of the half width, a path without an arrow
TINY = 0.03  # a path that is drawn as a point
NUMBERED = 0.12  # of the half width, between two pairs with their numbers, and above the real axis
NUMBER_ROOM = 17.0  # pt, from the middle of one of these numbers to the next


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
        """The value of the parameter at the mark."""
        return self.source.value

    @property
    def name(self) -> str:
        """Period doubling, corner impact at c, ..."""
        return self.words()

    def words(self, orbit: str = "") -> str:
        """Period doubling of an orbit, corner impact of an orbit at c, ..."""
        of = f" of {orbit}" if orbit else ""
        at = f" at {self.source.corner}" if self.source.corner else ""
        return self.source.kind.replace("-", " ") + of + at


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
    """One per branch, given its orbits: of their kind, in shades where several share it."""
    return style.apart([style.label_colour(orbits[0].label) for orbits in every])


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
        stable = steady(before, after)
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


def steady(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Stability between neighbours: that of the one further from the border."""
    return max(before, after, key=lambda orbit: abs(radius(orbit) - 1.0)).stable


def _links(a: Sequence[float], b: Sequence[float], turn: float) -> list[tuple[int, int]]:
    """Pairs (i, j) of values of neighbouring points: b[j] continues a[i].

    Phases (deg) are continued in their order unless one of them jumps; then, as other values are,
    by the nearest one that is still free. turn: 360 of phases, else 0.
    """
    jumps = False
    for x, y in zip(a, b, strict=False):
        if NEAR_DEG < abs(x - y) < turn - NEAR_DEG:
            jumps = True
    if turn and len(a) == len(b) and not jumps:
        return [(k, k) for k in range(len(a)) if abs(a[k] - b[k]) <= NEAR_DEG]

    distances = []
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            distances.append((abs(x - y), i, j))
    limit = NEAR_DEG if turn else inf
    links = []
    continued: set[int] = set()
    taken: set[int] = set()
    for distance, i, j in sorted(distances):
        if distance <= limit and i not in continued and j not in taken:
            links.append((i, j))
            continued.add(i)
            taken.add(j)
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
    trace, det = (
        getattr(before, name) + s * (getattr(after, name) - getattr(before, name))
        for name in ("trace", "det")
    )
    theta = tuple(x[:-1:2].tolist())
    return replace(before, value=float(x[-1]), theta=theta, trace=trace, det=det, root=None)


def draw_strands(
    axes: Axes, lines: Sequence[Strand], colour: str, view: Callable = np.asarray
) -> None:
    """All lines of a branch, unstable parts dashed; `view` makes the y of what a strand holds."""
    for line in lines:
        axes.plot(line.x, view(line.y), color=colour, zorder=3, **line_look(line.stable))


def line_look(stable: bool) -> dict[str, Any]:
    """Stable orbits have solid lines, unstable ones dashed and thinner."""
    return {"linewidth": 1.4} if stable else {"linewidth": 1.3, "linestyle": DASHED}


# --- multipliers


def paths(points: Sequence[PeriodicOrbit]) -> list[Strand]:
    """Both multipliers along a branch, finely; broken where they jump at a corner."""
    out: list[Strand] = []
    going: list[Strand] = []
    for before, after in pairwise(points):
        aside = abs(after.value - before.value) <= SAME * abs(before.value)
        if aside and abs(after.trace - before.trace) > JUMP * (1.0 + abs(before.trace)):
            going = []
            continue
        stable = steady(before, after)
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
    meet = np.roots([0.25 * dt * dt, 0.5 * t * dt - dd, 0.25 * t * t - d])
    shares = [part / PARTS for part in range(1, PARTS + 1)]
    return sorted([*shares, *(s.real for s in meet if not s.imag and 0.0 < s.real < 1.0)])


def draw_plane(axes: Axes, largest: float, sizes: Collection[float] = ()) -> None:
    """The unit circle, circles on which complex pairs lie, and equal axes."""
    half = min(max(LEAST, 1.06 * largest), FURTHEST)
    around = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.fill(np.cos(around), np.sin(around), fc=style.CAM_BODY, ec=style.CAM, lw=0.8, zorder=0)
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=1)
    for size in sizes:
        ring: dict[str, Any] = {"color": style.GUIDE, "linewidth": 0.6, "linestyle": DOTTED}
        axes.plot(size * np.cos(around), size * np.sin(around), zorder=1, **ring)
    if sizes:
        words = rf"dotted: $|\mu|$ = {', '.join(f'{size:.4g}' for size in sorted(sizes))}"
        look: dict[str, Any] = {"ha": "right", "va": "bottom", "color": style.CAM}
        axes.text(ASIDE * half, -ASIDE * half, words, size=style.NOTE, **look)
    axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(1.0))
    beyond = f" (triangle: beyond ±{half:g})" if largest > half else ""
    axes.set(xlabel=r"Re $\mu$" + beyond, ylabel=r"Im $\mu$")


def draw_outside(axes: Axes, multipliers: Sequence[complex], colour: str) -> None:
    """A triangle at each border of the plane beyond which some of the multipliers lie."""
    half = axes.get_xlim()[1]
    seen = set()
    for mu in multipliers:
        size = max(abs(mu.real), abs(mu.imag))
        if size <= half:
            continue
        if abs(mu.real) == size:
            marker = ">" if mu.real > 0.0 else "<"
        else:
            marker = "^" if mu.imag > 0.0 else "v"
        if marker not in seen:
            seen.add(marker)
            border = mu / size * half
            look: dict[str, Any] = {"color": colour, "ms": 6.0, "mew": 0.0, "ls": "None"}
            axes.plot([border.real], [border.imag], marker, clip_on=False, zorder=6, **look)


def draw_paths(axes: Axes, lines: Sequence[Strand], colour: str) -> None:
    """Paths in the plane, each with an arrow half-way that points along a rising parameter.

    A path that does not move is a dot; one too short in what is seen of it has no arrow.
    """
    half = axes.get_xlim()[1]
    draw_outside(axes, [mu for line in lines for mu in line.y], colour)
    for line in lines:
        mu = np.asarray(line.y)
        if np.abs(mu - mu[0]).max() < TINY:
            face = colour if line.stable else "white"
            axes.plot(mu.real[:1], mu.imag[:1], "o", color=colour, ms=4.0, mfc=face, zorder=4)
            continue
        axes.plot(mu.real, mu.imag, color=colour, zorder=3, **line_look(line.stable))
        seen = np.flatnonzero((abs(mu.real) < half) & (abs(mu.imag) < half))
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(mu[seen])))])
        if way[-1] > SHORT * half:
            k = seen[min(int(np.searchsorted(way, 0.5 * way[-1])), len(seen) - 1)]
            tip, tail = (k, k - 1) if line.x[-1] >= line.x[0] else (k - 1, k)
            head, end = ((mu[i].real, mu[i].imag) for i in (tip, tail))
            look: dict[str, Any] = {"arrowstyle": "-|>,head_width=0.26,head_length=0.5"}
            look |= {"color": colour, "linewidth": 0.0, "shrinkA": 0.0, "shrinkB": 0.0}
            axes.annotate("", head, end, arrowprops=look, zorder=5)


def number_pairs(axes: Axes, every: Sequence[Sequence[Strand]], values: Sequence[float]) -> bool:
    """Dots with numbers where complex pairs are at these values of the parameter.

    Only the multiplier above the real axis has them, and none where another is too close. Returns
    whether there is any.

    every: the paths of each branch, from `paths`.
    """
    half = axes.get_xlim()[1]
    points = min(axes.get_window_extent().size) / style.DPI * 72.0  # of the plane, 2 half wide
    room = max(NUMBERED * half, NUMBER_ROOM / points * 2.0 * half)
    dots: list[complex] = []
    numbers: list[complex] = []  # where they stand: outside the unit circle
    for line in (line for lines in every for line in lines):
        for value in values:
            mu = _multiplier_at(line, value)
            if mu is None or mu.imag < NUMBERED * half:
                continue
            outside = mu / abs(mu) * (max(abs(mu), 1.0) + 0.1 * half)
            near_dot = any(abs(mu - other) < NUMBERED * half for other in dots)
            near_number = any(abs(outside - other) < room for other in numbers)
            if near_dot or near_number:
                continue
            dots.append(mu)
            numbers.append(outside)
            dot: dict[str, Any] = {"mfc": "white", "mec": style.CAM, "ms": 3.4, "mew": 0.7}
            axes.plot([mu.real], [mu.imag], "o", zorder=6, **dot)
            axes.annotate(
                number_text(float(f"{value:.10g}")), (mu.real, mu.imag),
                (outside.real, outside.imag), color=style.CAM, zorder=6, size=style.NOTE,
                ha="center", va="center",
            )  # fmt: skip
    return bool(dots)


def _multiplier_at(line: Strand, value: float) -> complex | None:
    """The multiplier where a path first has this value of the parameter, None where it never has.

    Between two points of the path it is on the line from one to the other.
    """
    mu = np.asarray(line.y)
    x = np.asarray(line.x)
    steps = np.flatnonzero((x[:-1] - value) * (x[1:] - value) <= 0.0)
    if not len(steps):
        return None
    k = int(steps[0])
    share = (value - x[k]) / (x[k + 1] - x[k]) if x[k + 1] != x[k] else 0.0
    return complex(mu[k] + share * (mu[k + 1] - mu[k]))


def turning_real(points: Sequence[PeriodicOrbit]) -> list[float]:
    """Parameters at which a complex pair of multipliers becomes real, or the other way round.

    There trace^2 - 4 det is zero: between the two points where it changes its sign, on the
    polynomial through these and two more on either side. At a corner, where two points share a
    parameter, it is not smooth, and a line takes the place of the polynomial.
    """
    x, gap = np.array([(p.value, p.trace**2 - 4.0 * p.det) for p in points]).T
    found = []
    for k in np.flatnonzero(gap[1:] * gap[:-1] < 0.0):
        near = slice(max(0, k - 2), k + 4)
        steps = np.diff(x[near])
        if x[k] == x[k + 1]:
            found.append(float(x[k]))
            continue
        smooth = (steps > 0.0).all() or (steps < 0.0).all()
        some = near if smooth else slice(k, k + 2)
        curve = BarycentricInterpolator(x[some], gap[some])
        found.append(float(brentq(curve, x[k], x[k + 1])))
    return found


def draw_real(axes: Axes, every: Sequence[Sequence[Strand]], shades: Sequence[str]) -> None:
    """Real parts over the parameter; where they are large the axis is one of asinh."""
    for level in (-1.0, 1.0):
        axes.axhline(level, color=style.CAM, linewidth=0.8, zorder=1)
    axes.axhspan(-1.0, 1.0, color=style.CAM_BODY, linewidth=0, zorder=0)
    for lines, colour in zip(every, shades, strict=True):
        draw_strands(axes, lines, colour, np.real)
    largest = max((abs(mu.real) for lines in every for line in lines for mu in line.y), default=0)
    axes.set_ylabel(r"Re $\mu$")
    if largest > LINEAR:
        axes.set_yscale("asinh", linear_width=1.0)
        axes.minorticks_off()
        step = 10 ** max(1, round(log10(largest)) // 3)
        tens = [tick for tick in (step**k for k in range(4)) if tick <= largest]
        ticks = [*(-tick for tick in reversed(tens)), 0, *tens]
        axes.set_yticks(ticks, [f"{tick:g}".replace("-", "−") for tick in ticks])
        axes.set_ylabel(r"Re $\mu$ (asinh scale)")
