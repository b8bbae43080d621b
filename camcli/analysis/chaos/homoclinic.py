"""Boxes about a saddle and a chain of impacts that leads from it back to it, sought with floats.

About the saddle A, an unstable orbit with one impact, the impact map P is linear, and (u, s) are
the coordinates along its unstable and its stable direction. Starts along the unstable one, over one
turn of its multiplier, are all of the unstable manifold. Where u changes its sign after n impacts,
the chain lands on the stable manifold (u = 0): a homoclinic chain. The box of A reaches so far in u
and in s; the chain is cut to what lies outside of it, and each of its impacts gets a box: along the
image of the unstable direction as long as it takes to cover the next one, along the stable one as
wide as the image of the box before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import log
from typing import NamedTuple

import numpy as np

from camcli.analysis.chaos.section import Chaos, Lands, SectionBox
from camcli.analysis.differences import since_first_strobe
from camcli.analysis.integrate import Orbit, Settings, Start, run_all, with_turns
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.orbit_loop import IMPACT
from camcli.system import System, omega_of

FIRST = 1e-3  # rad: the starts lie so far from the saddle, or up to a multiplier farther
STARTS = 400  # along each side of the unstable manifold
LONGEST_CHAIN = 16  # impacts of a chain until it is on the stable manifold
ONWARD = 6  # impacts of it from there on, towards the saddle
HALVINGS = 40  # of the start of a chain
NEXT = 3  # turns in which the next impact is looked for
DIFFERENCE = 1e-6  # rad and m/rad, of slopes
REACHES = (0.9, 0.75, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)  # of the saddle's box along u, of its room
WIDTHS = (1.0, 1.2, 0.8, 1.5, 0.6)  # of it along s, of its reach along u
CHAINS = 12  # tried, the shortest first
BEYOND = 1.1  # times its size: by so much a box is longer, or wider, than what it has to cover
SAMPLES = 9  # on each side of a box
THINNEST = 0.02  # of its length: width of a box at least
DIGITS = 6  # significant ones of a box


class Impact(NamedTuple):
    """An impact: phase (rad), relative rate at which it leaves (m/rad), stretch; its turn."""

    theta: float
    v: float
    stretch: int
    turn: int


Chain = list[Impact]  # of a motion that leaves a saddle and comes back to it


class Image(NamedTuple):
    """Points (theta, v), shape (2, n), on a stretch of the cam, so many turns after others."""

    points: np.ndarray
    stretch: int
    turn: int


class ImpactMap:
    """The impact map of a machine at a speed, in floats."""

    def __init__(self, system: System, rpm: float, settings: Settings):
        self.system = system
        self.rpm = rpm
        self.settings = settings

    def chains(self, points: np.ndarray, turns: int) -> list[list[Impact]]:
        """The impacts after each start (theta, v), shape (2, n), for so many turns.

        Turns count from that of the start, which begins at the angle zero of the cam.
        """
        omega = omega_of(self.rpm)
        settings = with_turns(self.settings, 0, turns)
        orbits = []
        for theta, v in points.T.tolist():
            phase = theta % TURN
            c, c1, _ = lift_at(self.system.cam, stretch_at(self.system.cam, phase), phase)
            start = Start(c, (c1 + v) * omega, phase)
            orbits.append(Orbit(self.system, self.rpm, settings, start))
        return [
            self._impacts(float(phase) % TURN, record)
            for phase, record in zip(points[0], run_all(orbits, strobes=False), strict=True)
        ]

    def simulated(self) -> np.ndarray:
        """Impacts (theta, v), shape (2, n), from the scene's start behind its transient."""
        record = Orbit(self.system, self.rpm, self.settings).run(strobes=False)
        cam = self.system.cam
        r = self.system.restitution
        impacts = [
            (theta, r(stretch_at(cam, theta)) * abs(u))
            for kind, period, theta, _, u in record.events()
            if kind == IMPACT and period >= 0
        ]
        return np.array(impacts).reshape(-1, 2).T

    def _impacts(self, start: float, record) -> list[Impact]:
        """The impacts of a record; a rest ends it."""
        impacts = []
        first = since_first_strobe(self.system, 0, start)
        first -= TURN if start != self.system.strobe else 0.0
        for kind, period, theta, _, u in record.events():
            if kind != IMPACT:
                break
            i = stretch_at(self.system.cam, theta)
            since = since_first_strobe(self.system, period, theta) - first
            turn = round((start + since - theta) / TURN)
            impacts.append(Impact(theta, self.system.restitution(i) * abs(u), i, turn))
        return impacts

    def image(self, points: np.ndarray) -> Image | None:
        """Where the flights from (theta, v), shape (2, n), land; None where not on one stretch."""
        chains = self.chains(points, NEXT)
        ends = [chain[0] for chain in chains if chain]
        places = {end[2:] for end in ends}
        if len(ends) < len(chains) or len(places) != 1:
            return None
        stretch, turn = places.pop()
        return Image(np.array([end[:2] for end in ends]).T, stretch, turn)

    def slopes(self, theta: float, v: float) -> np.ndarray | None:
        """The matrix of the map at a point by differences; None at an edge of it."""
        d = DIFFERENCE
        around = np.array([[theta + d, theta - d, theta, theta], [v, v, v + d, v - d]])
        image = self.image(around)
        if image is None:
            return None
        later, earlier, faster, slower = image.points.T
        return np.column_stack([later - earlier, faster - slower]) / (2.0 * d)


@dataclass(frozen=True)
class Saddle:
    """A saddle with one impact: its place, multipliers, and directions as columns, of theta 1."""

    label: str
    turns: int
    impact: Impact
    multipliers: tuple[float, float]
    directions: np.ndarray

    @property
    def at(self) -> np.ndarray:
        """(theta, v)."""
        return np.array(self.impact[:2])

    def coordinates(self, theta: float, v: float) -> np.ndarray:
        """(u, s) of an impact."""
        return np.linalg.solve(self.directions, np.array([theta, v]) - self.at)


def saddle_of(impact_map: ImpactMap, orbit: PeriodicOrbit) -> Saddle | None:
    """The orbit as a saddle; None where it is none, or has more impacts than one."""
    root = orbit.root
    if root is None or root.count != 1 or orbit.stable:
        return None
    theta, v = root.x[:2]
    slopes = impact_map.slopes(theta, v)
    if slopes is None:
        return None
    values, vectors = np.linalg.eig(slopes)
    if np.iscomplexobj(values) or not max(abs(values)) > 1.0 > min(abs(values)):
        return None
    order = np.argsort(-np.abs(values))
    directions = vectors[:, order] / vectors[0, order]
    at = Impact(theta, v, stretch_at(impact_map.system.cam, theta), 0)
    return Saddle(str(orbit.label), orbit.turns, at, tuple(values[order].tolist()), directions)


def homoclinic(impact_map: ImpactMap, saddle: Saddle) -> list[Chain]:
    """Chains from the saddle back to it, those first that come back after fewest impacts."""
    mu = saddle.multipliers[0]
    sides = (1.0,) if mu < 0.0 else (1.0, -1.0)
    span = log(abs(mu)) * (2.0 if mu < 0.0 else 1.0)
    room = _room(impact_map.system, saddle)
    turns = (LONGEST_CHAIN + ONWARD) * saddle.turns
    found: list[tuple[int, Chain]] = []
    for side in sides:
        starts = side * FIRST * np.exp(np.linspace(0.0, span, STARTS + 1))
        chains = impact_map.chains(_leaf(saddle, starts), turns)
        seen: set[int] = set()
        for n in range(2, LONGEST_CHAIN):
            for k in range(STARTS):
                if k in seen or not _changes(saddle, chains[k], chains[k + 1], n, room):
                    continue
                seen.add(k)
                start = _refined(impact_map, saddle, starts[k], starts[k + 1], n, turns)
                impacts = impact_map.chains(_leaf(saddle, np.array([start])), turns)[0]
                near = _leaf(saddle, np.array([start]))[:, 0]
                first = Impact(float(near[0]), float(near[1]), saddle.impact.stretch, 0)
                found.append((n, [first, *impacts[: n + ONWARD]]))
    return [chain for _, chain in sorted(found, key=lambda one: one[0])][:CHAINS]


def _leaf(saddle: Saddle, starts: np.ndarray) -> np.ndarray:
    """Points of the unstable manifold next to the saddle, shape (2, n)."""
    return saddle.at[:, None] + saddle.directions[:, :1] * starts


def _room(system: System, saddle: Saddle) -> float:
    """Distance (rad) from the saddle's phase to the nearer end of its stretch."""
    stretch = system.cam.stretches[saddle.impact.stretch]
    theta = saddle.impact.theta
    return min(theta - stretch.start, stretch.end - theta)


def _changes(
    saddle: Saddle, one: Sequence[Impact], other: Sequence[Impact], n: int, room: float
) -> bool:
    """Whether two chains of the same stretches land on either side of the stable manifold."""
    if min(len(one), len(other)) <= n:
        return False
    alike = all(a[2:] == b[2:] for a, b in zip(one[: n + 1], other[: n + 1], strict=True))
    (u, s), (u1, s1) = (saddle.coordinates(*chain[n][:2]) for chain in (one, other))
    return bool(alike and u * u1 <= 0.0 and max(abs(u), abs(u1), abs(s), abs(s1)) < room)


def _refined(
    impact_map: ImpactMap, saddle: Saddle, low: float, high: float, n: int, turns: int
) -> float:
    """The start between two whose chain lands on the stable manifold after n impacts."""

    def across(start: float) -> float:
        chain = impact_map.chains(_leaf(saddle, np.array([start])), turns)[0]
        return float(saddle.coordinates(*chain[n][:2])[0]) if len(chain) > n else 0.0

    at_low = across(low)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        value = across(middle)
        if value * at_low > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


class Frame(NamedTuple):
    """The directions of an impact of a chain, as columns, and how the map stretches the first."""

    axes: np.ndarray
    stretch: float


def frames(impact_map: ImpactMap, saddle: Saddle, chain: Chain) -> list[Frame] | None:
    """The images of the unstable direction, and the preimages of the stable one, along a chain.

    None where an impact lies at an edge of the map.
    """
    slopes = []
    for impact in chain[:-1]:
        one = impact_map.slopes(*impact[:2])
        if one is None:
            return None
        slopes.append(one)
    forward = [saddle.directions[:, 0]]
    for one in slopes:
        image = one @ forward[-1]
        forward.append(image / image[0])
    backward = [saddle.directions[:, 1]]
    for one in reversed(slopes):
        image = np.linalg.solve(one, backward[-1])
        backward.append(image / np.linalg.norm(image))
    axes = [np.column_stack(pair) for pair in zip(forward, reversed(backward), strict=True)]
    result = []
    for here, there, one in zip(axes, axes[1:], slopes, strict=False):
        result.append(Frame(here, float(np.linalg.solve(there, one @ here)[0, 0])))
    return [*result, Frame(axes[-1], 0.0)]


def candidates(impact_map: ImpactMap, saddle: Saddle) -> Iterator[Chaos]:
    """Boxes that cover one another as far as samples tell, those of the shortest loops first."""
    chains = homoclinic(impact_map, saddle)
    framed = [(chain, frames(impact_map, saddle, chain)) for chain in chains]
    room = _room(impact_map.system, saddle)
    tried: list[tuple[int, float, Chain, list[Frame], float, float]] = []
    for (chain, frame), reach, width in product(framed, REACHES, WIDTHS):
        along, across = reach * room, reach * width * room
        if frame is None or (1.0 + width) * reach >= 1.0:
            continue
        cut = _cut(saddle, chain, along, across)
        if cut is not None:
            tried.append((len(cut), -reach, chain, frame, along, across))
    tried.sort(key=lambda one: one[:2])
    for _, _, chain, frame, along, across in tried:
        found = _boxes(impact_map, saddle, chain, frame, along, across)
        if found is not None:
            yield found


def _cut(saddle: Saddle, chain: Chain, along: float, across: float) -> range | None:
    """The impacts of a chain between leaving the saddle's box and coming back to it."""
    inside = []
    for impact in chain:
        u, s = saddle.coordinates(*impact[:2])
        same = impact.stretch == saddle.impact.stretch
        inside.append(bool(same and abs(u) < along and abs(s) < across))
    if not inside[0] or all(inside):
        return None
    leaves = inside.index(False)
    if True not in inside[leaves:]:
        return None
    return range(leaves, inside.index(True, leaves))


def _boxes(
    impact_map: ImpactMap,
    saddle: Saddle,
    chain: Chain,
    frame: list[Frame],
    along: float,
    across: float,
) -> Chaos | None:
    """The boxes of a chain about a saddle's box of these half lengths; None where they fail.

    The first box lies about the saddle. Each further one lies about an impact of the chain and
    holds the image of the box before it: across by the image's width, and along by what makes the
    next image long enough. None where a box has no image, or does not cover the next one.
    """
    cut = _cut(saddle, chain, along, across)
    assert cut is not None
    lengths = {}
    length = along
    for k in reversed(cut):
        length *= BEYOND / abs(frame[k].stretch)
        lengths[k] = length
    around = saddle.directions * np.array([along, across])
    box = _placed(impact_map, saddle.impact.stretch, saddle.at, around)
    boxes = [box]
    for k in cut:
        image = None if box is None else impact_map.image(_grid(box)[1])
        if image is None:
            return None
        impact = chain[k]
        place = np.array(impact[:2])
        axes = frame[k].axes
        _, off_axis = np.linalg.solve(axes, image.points - place[:, None])
        half = max(BEYOND * 0.5 * float(np.ptp(off_axis)), THINNEST * lengths[k])
        middle = place + axes[:, 1] * 0.5 * (off_axis.min() + off_axis.max())
        box = _placed(impact_map, impact.stretch, middle, axes * np.array([lengths[k], half]))
        boxes.append(box)
    placed = [box for box in boxes if box is not None]
    count = len(boxes)
    pairs = ((0, 0), *((k, (k + 1) % count) for k in range(count)))
    if len(placed) < count or not all(_covers(impact_map, placed[i], placed[j]) for i, j in pairs):
        return None
    return Chaos(impact_map.rpm, saddle.label, tuple(placed), pairs)


def _grid(box: SectionBox) -> tuple[np.ndarray, np.ndarray]:
    """(coordinates (x, y), points (theta, v)) over a box, shape (2, n) each."""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, SAMPLES), np.linspace(-1.0, 1.0, SAMPLES))
    places = np.array([x.ravel(), y.ravel()])
    return places, np.array(box.middle)[:, None] + box.matrix @ places


def _placed(
    impact_map: ImpactMap, stretch: int, middle: np.ndarray, axes: np.ndarray
) -> SectionBox | None:
    """A box of rounded numbers, with where its flights land; None where that is not one stretch."""
    a, b, c, d = (_rounded(float(x), DIGITS) for x in axes.ravel())
    theta, v = (_rounded(float(x), DIGITS + 2) for x in middle)
    box = SectionBox(stretch, (theta, v), ((a, b), (c, d)), Lands(0, 0, 0.0, 0.0))
    image = None
    if _holds(impact_map, stretch, theta - box.reach[0], theta + box.reach[0]):
        image = impact_map.image(_grid(box)[1])
    if image is None:
        return None
    low, high = float(image.points[0].min()), float(image.points[0].max())
    if not _holds(impact_map, image.stretch, low, high):
        return None
    return replace(box, lands=Lands(image.stretch, image.turn, low, high))


def _rounded(x: float, digits: int) -> float:
    """A number with so many significant digits."""
    return float(f"{x:.{digits}g}")


def _holds(impact_map: ImpactMap, stretch: int, low: float, high: float) -> bool:
    """Whether phases from low to high lie inside a stretch of the cam."""
    there = impact_map.system.cam.stretches[stretch]
    return bool(there.start < low < high < there.end)


def _covers(impact_map: ImpactMap, one: SectionBox, other: SectionBox) -> bool:
    """Whether the samples of a box are mapped over another one."""
    places, points = _grid(one)
    image = impact_map.image(points)
    if image is None or image.stretch != other.stretch:
        return False
    x, y = other.inside(image.points)
    left, right = x[places[0] == -1.0], x[places[0] == 1.0]
    apart = left.max() < -1.0 < 1.0 < right.min() or right.max() < -1.0 < 1.0 < left.min()
    return bool(apart and np.abs(y).max() < 1.0)
