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
from camcli.analysis.integrate import Orbit, Record, Settings, Start, run_all, with_turns
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


class LandedPoints(NamedTuple):
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

    def _impacts(self, start: float, record: Record) -> list[Impact]:
        """The impacts of a record that begins at a phase (rad); a rest ends it.

        Their turns count from that of the start. A record's angles count from its first strobe.
        """
        impacts = []
        first_strobe = since_first_strobe(self.system, 0, start)
        first_strobe -= TURN if start != self.system.strobe else 0.0
        for kind, period, theta, _, u in record.events():
            if kind != IMPACT:
                break
            stretch = stretch_at(self.system.cam, theta)
            since_start = since_first_strobe(self.system, period, theta) - first_strobe
            turn = round((start + since_start - theta) / TURN)
            v = self.system.restitution(stretch) * abs(u)
            impacts.append(Impact(theta, v, stretch, turn))
        return impacts

    def image(self, points: np.ndarray) -> LandedPoints | None:
        """Where the flights from (theta, v), shape (2, n), land; None where not on one stretch."""
        chains = self.chains(points, NEXT)
        landings = [chain[0] for chain in chains if chain]
        places = {(landing.stretch, landing.turn) for landing in landings}
        if len(landings) < len(chains) or len(places) != 1:
            return None
        stretch, turn = places.pop()
        landed = np.array([(landing.theta, landing.v) for landing in landings]).T
        return LandedPoints(landed, stretch, turn)

    def slopes(self, theta: float, v: float) -> np.ndarray | None:
        """The matrix of the map at a point by differences; None at an edge of it."""
        d = DIFFERENCE
        beside = np.array([[theta + d, theta - d, theta, theta], [v, v, v + d, v - d]])
        image = self.image(beside)
        if image is None:
            return None
        later, earlier, faster, slower = image.points.T
        return np.column_stack([later - earlier, faster - slower]) / (2.0 * d)


@dataclass(frozen=True)
class MapSaddle:
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


def saddle_of(impact_map: ImpactMap, orbit: PeriodicOrbit) -> MapSaddle | None:
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
    return MapSaddle(str(orbit.label), orbit.turns, at, tuple(values[order].tolist()), directions)


def homoclinic(impact_map: ImpactMap, saddle: MapSaddle) -> list[Chain]:
    """Chains from the saddle back to it, those first that come back after fewest impacts.

    Starts lie along the unstable manifold, over one turn of its multiplier mu on each side; where
    that is negative, over two on one side. Between two neighbours whose chains land on either side
    of the stable manifold after n impacts, one lands on it.
    """
    mu = saddle.multipliers[0]
    sides = (1.0,) if mu < 0.0 else (1.0, -1.0)
    span = log(abs(mu)) * (2.0 if mu < 0.0 else 1.0)
    room = _room(impact_map.system, saddle)
    turns = (LONGEST_CHAIN + ONWARD) * saddle.turns
    numbered: list[tuple[int, Chain]] = []  # each with its n
    for side in sides:
        starts = side * FIRST * np.exp(np.linspace(0.0, span, STARTS + 1))
        chains = impact_map.chains(_leaf(saddle, starts), turns)
        taken: set[int] = set()  # intervals between neighbours that have given a chain
        for n in range(2, LONGEST_CHAIN):
            for k in range(STARTS):
                if k in taken or not _changes(saddle, chains[k], chains[k + 1], n, room):
                    continue
                taken.add(k)
                start = _refined(impact_map, saddle, starts[k], starts[k + 1], n, turns)
                chain = _chain_from(impact_map, saddle, start, turns)
                numbered.append((n, chain[: 1 + n + ONWARD]))
    return [chain for _, chain in sorted(numbered, key=lambda pair: pair[0])][:CHAINS]


def _chain_from(impact_map: ImpactMap, saddle: MapSaddle, start: float, turns: int) -> Chain:
    """The chain from a start on the unstable manifold, which is its first impact."""
    near = _leaf(saddle, np.array([start]))
    theta, v = near[:, 0]
    first = Impact(float(theta), float(v), saddle.impact.stretch, 0)
    return [first, *impact_map.chains(near, turns)[0]]


def _leaf(saddle: MapSaddle, starts: np.ndarray) -> np.ndarray:
    """Points of the unstable manifold next to the saddle, shape (2, n)."""
    return saddle.at[:, None] + saddle.directions[:, :1] * starts


def _room(system: System, saddle: MapSaddle) -> float:
    """Distance (rad) from the saddle's phase to the nearer end of its stretch."""
    stretch = system.cam.stretches[saddle.impact.stretch]
    theta = saddle.impact.theta
    return min(theta - stretch.start, stretch.end - theta)


def _changes(
    saddle: MapSaddle, chain: Sequence[Impact], other: Sequence[Impact], n: int, room: float
) -> bool:
    """Whether two chains land on either side of the stable manifold after n impacts.

    Up to there they land on the same stretches in the same turns, and at last nearer than `room` to
    the saddle.
    """
    if min(len(chain), len(other)) <= n:
        return False
    pairs = zip(chain[: n + 1], other[: n + 1], strict=True)
    alike = all((a.stretch, a.turn) == (b.stretch, b.turn) for a, b in pairs)
    u, s = saddle.coordinates(chain[n].theta, chain[n].v)
    other_u, other_s = saddle.coordinates(other[n].theta, other[n].v)
    near = max(abs(u), abs(other_u), abs(s), abs(other_s)) < room
    return bool(alike and u * other_u <= 0.0 and near)


def _refined(
    impact_map: ImpactMap, saddle: MapSaddle, low: float, high: float, n: int, turns: int
) -> float:
    """The start between two whose chain lands on the stable manifold after n impacts."""

    def across(start: float) -> float:
        """The coordinate u of impact n, zero on the stable manifold."""
        chain = impact_map.chains(_leaf(saddle, np.array([start])), turns)[0]
        if len(chain) <= n:
            return 0.0
        u, _ = saddle.coordinates(chain[n].theta, chain[n].v)
        return float(u)

    at_low = across(low)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if across(middle) * at_low > 0.0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


class Frame(NamedTuple):
    """The directions of an impact of a chain, as columns, and how the map stretches the first.

    The first one is the image of the saddle's unstable direction, the second one is mapped to its
    stable direction.
    """

    axes: np.ndarray
    stretch: float


def frames(impact_map: ImpactMap, saddle: MapSaddle, chain: Chain) -> list[Frame] | None:
    """The frame of each impact of a chain; None where an impact lies at an edge of the map.

    The unstable direction is mapped along the chain, the stable one backwards from its end.
    """
    matrices = []  # of the map at each impact but the last
    for impact in chain[:-1]:
        slopes = impact_map.slopes(impact.theta, impact.v)
        if slopes is None:
            return None
        matrices.append(slopes)
    unstable = [saddle.directions[:, 0]]
    for slopes in matrices:
        image = slopes @ unstable[-1]
        unstable.append(image / image[0])
    stable = [saddle.directions[:, 1]]  # from the last impact to the first
    for slopes in reversed(matrices):
        image = np.linalg.solve(slopes, stable[-1])
        stable.append(image / np.linalg.norm(image))
    axes = [np.column_stack(pair) for pair in zip(unstable, reversed(stable), strict=True)]
    result = []
    for k, slopes in enumerate(matrices):
        in_next_axes = np.linalg.solve(axes[k + 1], slopes @ axes[k])
        result.append(Frame(axes[k], float(in_next_axes[0, 0])))
    return [*result, Frame(axes[-1], 0.0)]


class Loop(NamedTuple):
    """A chain with its frames, and the saddle's box that cuts it.

    along, across: half lengths of that box in u and s; cut: the impacts of the chain outside of it.
    """

    chain: Chain
    frames: list[Frame]
    along: float
    across: float
    cut: range


def candidates(impact_map: ImpactMap, saddle: MapSaddle) -> Iterator[Chaos]:
    """Boxes that cover one another as far as samples tell, those of the shortest loops first.

    Of each chain the saddle's box is tried in several sizes, among as short loops the largest
    first.
    """
    chains = homoclinic(impact_map, saddle)
    with_frames = [(chain, frames(impact_map, saddle, chain)) for chain in chains]
    room = _room(impact_map.system, saddle)
    tried: list[tuple[int, float, Loop]] = []
    for (chain, its_frames), reach, width in product(with_frames, REACHES, WIDTHS):
        if its_frames is None or (1.0 + width) * reach >= 1.0:
            continue
        along = reach * room
        across = reach * width * room
        cut = _cut(saddle, chain, along, across)
        if cut is not None:
            loop = Loop(chain, its_frames, along, across, cut)
            tried.append((len(cut), -reach, loop))
    for _, _, loop in sorted(tried, key=lambda one: one[:2]):
        chaos = _boxes(impact_map, saddle, loop)
        if chaos is not None:
            yield chaos


def _cut(saddle: MapSaddle, chain: Chain, along: float, across: float) -> range | None:
    """The impacts of a chain between leaving the saddle's box and coming back to it.

    along, across: half lengths of that box in u and s. None where the chain does not do both.
    """
    inside = []
    for impact in chain:
        u, s = saddle.coordinates(impact.theta, impact.v)
        on_stretch = impact.stretch == saddle.impact.stretch
        inside.append(bool(on_stretch and abs(u) < along and abs(s) < across))
    if not inside[0] or all(inside):
        return None
    leaves = inside.index(False)
    if True not in inside[leaves:]:
        return None
    return range(leaves, inside.index(True, leaves))


def _boxes(impact_map: ImpactMap, saddle: MapSaddle, loop: Loop) -> Chaos | None:
    """The boxes along a loop; None where one has no image, or does not cover the next one.

    The first box lies about the saddle. Each further one lies about an impact of the chain and
    holds the image of the box before it: across by the image's width, and along by what makes the
    next image long enough.
    """
    lengths = {}  # half lengths along, by the impact's number: from the last one backwards
    length = loop.along
    for k in reversed(loop.cut):
        length *= BEYOND / abs(loop.frames[k].stretch)
        lengths[k] = length
    saddle_axes = saddle.directions * np.array([loop.along, loop.across])
    box = _placed(impact_map, saddle.impact.stretch, saddle.at, saddle_axes)
    boxes = [] if box is None else [box]
    for k in loop.cut:
        image = None if box is None else impact_map.image(_grid(box)[1])
        if image is None:
            return None
        box = _box_over(impact_map, loop.chain[k], loop.frames[k].axes, lengths[k], image)
        boxes += [] if box is None else [box]
    if box is None:
        return None
    count = len(boxes)
    coverings = ((0, 0), *((k, (k + 1) % count) for k in range(count)))
    if not all(_covers(impact_map, boxes[i], boxes[j]) for i, j in coverings):
        return None
    return Chaos(impact_map.rpm, saddle.label, tuple(boxes), coverings)


def _box_over(
    impact_map: ImpactMap, impact: Impact, axes: np.ndarray, length: float, image: LandedPoints
) -> SectionBox | None:
    """The box about an impact, of a half length along its first axis, that holds an image across.

    None where its flights do not land on one stretch.
    """
    place = np.array([impact.theta, impact.v])
    _, off_axis = np.linalg.solve(axes, image.points - place[:, None])
    half_width = max(BEYOND * 0.5 * float(np.ptp(off_axis)), THINNEST * length)
    middle = place + axes[:, 1] * 0.5 * (off_axis.min() + off_axis.max())
    return _placed(impact_map, impact.stretch, middle, axes * np.array([length, half_width]))


def _grid(box: SectionBox) -> tuple[np.ndarray, np.ndarray]:
    """(coordinates (x, y), points (theta, v)) over a box, shape (2, n) each."""
    side = np.linspace(-1.0, 1.0, SAMPLES)
    x, y = np.meshgrid(side, side)
    coordinates = np.array([x.ravel(), y.ravel()])
    return coordinates, np.array(box.middle)[:, None] + box.matrix @ coordinates


def _placed(
    impact_map: ImpactMap, stretch: int, middle: np.ndarray, axes: np.ndarray
) -> SectionBox | None:
    """A box of rounded numbers, with where its flights land; None where that is not one stretch.

    middle: (theta, v); axes: M.
    """
    a, b, c, d = (_rounded(float(x), DIGITS) for x in axes.ravel())
    theta, v = (_rounded(float(x), DIGITS + 2) for x in middle)
    box = SectionBox(stretch, (theta, v), ((a, b), (c, d)), Lands(0, 0, 0.0, 0.0))
    reach_in_theta, _ = box.reach
    if not _holds(impact_map, stretch, theta - reach_in_theta, theta + reach_in_theta):
        return None
    image = impact_map.image(_grid(box)[1])
    if image is None:
        return None
    phases = image.points[0]
    low = float(phases.min())
    high = float(phases.max())
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


def _covers(impact_map: ImpactMap, box: SectionBox, other: SectionBox) -> bool:
    """Whether the samples of a box are mapped over another one.

    All have |y| < 1 there, and those of its ends, x = -1 and 1, lie on either side of |x| <= 1.
    """
    coordinates, points = _grid(box)
    image = impact_map.image(points)
    if image is None or image.stretch != other.stretch:
        return False
    x, y = other.inside(image.points)
    of_left_end = x[coordinates[0] == -1.0]
    of_right_end = x[coordinates[0] == 1.0]
    kept_order = of_left_end.max() < -1.0 < 1.0 < of_right_end.min()
    turned_round = of_right_end.max() < -1.0 < 1.0 < of_left_end.min()
    return bool((kept_order or turned_round) and np.abs(y).max() < 1.0)
