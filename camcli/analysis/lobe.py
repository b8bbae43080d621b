"""The lobe that gives a lift under a knife edge, a roller or a flat face: outline and curvature.

The follower moves along a line through the cam's axis. At the phase theta it stands at a distance
R from the axis: R = base + r + s, with s the lobe's lift above its lowest, r the radius of a roller
(0 of a knife edge or a flat face) and base the radius of the lobe's base circle. With u the unit
vector from the axis along that line, and t = du/dtheta square to it, the lobe is touched at

    flat face    R u + R' t,                  radius of curvature  R + R''
    knife edge   R u,                                              1/kappa
    roller       R u - r (R u - R' t)/w,                           1/kappa - r
    w = sqrt(R^2 + R'^2),  kappa = (w^2 + R'^2 - R R'')/w^3

and the force of a knife edge or a roller is inclined to the line by the pressure angle,
atan(R'/R); a flat face is pressed beside it, at the eccentricity R'. All of this is derived from
the geometry above. R. L. Norton, Cam Design and Manufacturing Handbook, treats the same things; the
formulas were not compared with the book.

With a rocker s is the lift of the lobe: rocker_ratio times less than that of the valve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cache, partial
from math import atan, atan2, cos, hypot, inf, sin

from camcli.analysis.contact_loss.force import Force, polar_curvature
from camcli.cams.compile import column
from camcli.kernel.cam_table import lift_at
from camcli.system import System

LARGEST_ROLLER = 1e3  # base radii: a roller that may be so large may be as large as one likes
ROUNDS = 30  # in the search for the largest roller, each for another phase
HALVINGS = 200
STRAIGHT = 1e-12  # of 1/base: a curvature below it is none
SAME = 1e-13  # relative: two radii that differ by less are one


class Face(StrEnum):
    """What runs on the lobe."""

    KNIFE = "knife"
    ROLLER = "roller"
    FLAT = "flat"


@dataclass(frozen=True)
class Touch:
    """Where the follower touches the lobe at a phase; m, rad."""

    theta: float
    along: float  # from the axis, along the line on which the follower moves
    beside: float  # from that line, positive towards growing theta; of a flat face its eccentricity
    angle: float  # pressure angle; 0 of a flat face
    radius: float  # of curvature, positive where the lobe is convex, inf where it is straight

    @property
    def place(self) -> tuple[float, float]:
        """(x, y) when the cam has not turned, m: y towards the follower, phases clockwise."""
        s, c = sin(self.theta), cos(self.theta)
        return self.along * s + self.beside * c, self.along * c - self.beside * s

    @property
    def direction(self) -> float:
        """Direction of the point from the axis, counted as theta is, rad."""
        return self.theta + atan2(self.beside, self.along)


@dataclass(frozen=True)
class Found:
    """A value of the lobe and the phase at which it is taken, m or rad."""

    value: float
    theta: float


@dataclass(frozen=True)
class Lobe:
    """The lobe of a machine for one follower; lengths in m, angles in rad.

    touches: at every row of a profile. least: radius of curvature where the lobe is most sharply
    convex, not above 0 where it is undercut. hollow: radius of its sharpest hollow, None where it
    has none; a grinding wheel must be smaller. largest_roller: on the same base circle, None where
    nothing limits it or where no roller runs on the lobe. least_base: from which radius of the base
    circle on a flat face is not undercut, None without a flat face. beside: the two extremes of
    the pressure angle (rad), of a flat face those of the eccentricity (m). closing: distance from
    the end of the outline to its beginning.
    """

    face: Face
    base: float
    roller: float
    touches: Sequence[Touch]
    least: Found
    hollow: Found | None
    undercut: bool
    largest_roller: Found | None
    least_base: float | None
    beside: tuple[Found, Found]
    closing: float


class _Geometry:
    """The lobe at a phase of a stretch, for a roller of any radius on the same base circle."""

    def __init__(self, system: System, face: Face, base: float):
        self.force = Force(system)
        self.cam = system.cam
        self.ratio = system.rocker_ratio
        self.face = face
        self.base = base
        self.lift = cache(partial(lift_at, self.cam))  # every search begins at the same phases
        self.lowest, _, _ = self.force.lowest(lambda i, x: self.lift(i, x)[0])

    def path(self, i: int, theta: float, roller: float) -> tuple[float, float, float]:
        """R and its two derivatives."""
        c, c1, c2 = self.lift(i, theta)
        lift = (c - self.lowest) / self.ratio
        return self.base + roller + lift, c1 / self.ratio, c2 / self.ratio

    def kappa(self, i: int, theta: float, roller: float) -> float:
        """Curvature of the curve along which a knife edge or the centre of a roller runs, 1/m."""
        return polar_curvature(*self.path(i, theta, roller))

    def touch(self, i: int, theta: float, roller: float) -> Touch:
        """Where the follower touches the lobe."""
        radius, slope, accel = self.path(i, theta, roller)
        if self.face is Face.FLAT:
            return Touch(theta, radius, slope, 0.0, radius + accel)
        kappa = polar_curvature(radius, slope, accel)
        reach = hypot(radius, slope)
        along = radius - roller * radius / reach
        beside = roller * slope / reach
        bent = inf if kappa == 0.0 else 1.0 / kappa - roller
        return Touch(theta, along, beside, atan(slope / radius), bent)

    def least(self, roller: float) -> Found:
        """The smallest radius of curvature where the lobe is convex."""
        if self.face is Face.FLAT:
            value, _, theta = self.force.lowest(lambda i, x: self.touch(i, x, roller).radius)
            return Found(value, theta)
        value, _, theta = self.force.lowest(lambda i, x: -self.kappa(i, x, roller))
        return Found(-1.0 / value - roller if value < 0.0 else inf, theta)


def lobe_of(
    system: System,
    face: Face,
    base: float,
    roller: float,
    places: Sequence[tuple[int, float]],
) -> Lobe:
    """The lobe under a follower; places: (stretch, phase in rad) at which it is wanted."""
    geometry = _Geometry(system, face, base)
    touches = [geometry.touch(i, theta, roller) for i, theta in places]
    least = geometry.least(roller)
    kinks = column(system.cam, "slope_jump")
    edged = face is not Face.KNIFE and any(kink < 0.0 for kink in kinks)
    first, last = touches[0].place, touches[-1].place
    flat = face is Face.FLAT
    return Lobe(
        face=face,
        base=base,
        roller=roller,
        touches=touches,
        least=least,
        hollow=None if flat else _hollow(geometry, roller, kinks),
        undercut=(face is not Face.KNIFE and least.value <= 0.0) or edged,
        largest_roller=_largest_roller(geometry) if face is Face.ROLLER else None,
        least_base=max(0.0, base - least.value) if flat else None,
        beside=(_beside(geometry, roller, 1.0), _beside(geometry, roller, -1.0)),
        closing=hypot(last[0] - first[0], last[1] - first[1]),
    )


def _beside(geometry: _Geometry, roller: float, sign: float) -> Found:
    """The least (sign 1) or largest (-1) pressure angle, rad; of a flat face eccentricity, m."""

    def value(i: int, theta: float) -> float:
        touch = geometry.touch(i, theta, roller)
        return sign * (touch.beside if geometry.face is Face.FLAT else touch.angle)

    found, _, theta = geometry.force.lowest(value)
    return Found(sign * found, theta)


def _hollow(geometry: _Geometry, roller: float, kinks: Sequence[float]) -> Found | None:
    """Radius of the sharpest hollow; where the slope jumps up it is the roller's own."""
    starts = geometry.force.starts
    rising = [start for kink, start in zip(kinks, starts, strict=True) if kink > 0.0]
    if rising:
        return Found(roller, rising[0])
    kappa, _, theta = geometry.force.lowest(lambda i, x: geometry.kappa(i, x, roller))
    straight = STRAIGHT / geometry.base
    return Found(roller - 1.0 / kappa, theta) if kappa < -straight else None


def _nearness(geometry: _Geometry, roller: float, i: int, theta: float) -> float:
    """-1 where the lobe of such a roller has a radius of 0, less where it is undercut."""
    return -roller * geometry.kappa(i, theta, roller)


def _largest_roller(geometry: _Geometry) -> Found | None:
    """The roller on this base circle with which the lobe is just not undercut; None: no limit.

    A phase bears rollers up to the radius at which 1/kappa = r. The phase that bears least is
    looked for with one radius, and the largest radius with that phase, in turn; both only fall.
    """
    radius = LARGEST_ROLLER * geometry.base
    theta = 0.0
    for _ in range(ROUNDS):
        value, i, worst = geometry.force.lowest(partial(_nearness, geometry, radius))
        if value > -1.0:
            return None if radius == LARGEST_ROLLER * geometry.base else Found(radius, theta)
        low, high = 0.0, radius
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if middle * geometry.kappa(i, worst, middle) < 1.0:
                low = middle
            else:
                high = middle
        theta = worst
        if low >= radius * (1.0 - SAME):
            return Found(low, theta)
        radius = low
    return Found(radius, theta)
