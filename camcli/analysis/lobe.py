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
        sine = sin(self.theta)
        cosine = cos(self.theta)
        x = self.along * sine + self.beside * cosine
        y = self.along * cosine - self.beside * sine
        return x, y

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
        """R and its first two derivatives by theta, m; roller: its radius, m."""
        c, c1, c2 = self.lift(i, theta)
        lift = (c - self.lowest) / self.ratio
        return self.base + roller + lift, c1 / self.ratio, c2 / self.ratio

    def kappa(self, i: int, theta: float, roller: float) -> float:
        """Curvature of the curve along which a knife edge or the centre of a roller runs, 1/m."""
        return polar_curvature(*self.path(i, theta, roller))

    def touch(self, i: int, theta: float, roller: float) -> Touch:
        """Where the follower touches the lobe at theta of stretch i; roller: its radius, m."""
        r, r1, r2 = self.path(i, theta, roller)
        if self.face is Face.FLAT:
            return Touch(theta, along=r, beside=r1, angle=0.0, radius=r + r2)
        kappa = polar_curvature(r, r1, r2)
        w = hypot(r, r1)
        return Touch(
            theta,
            along=r - roller * r / w,
            beside=roller * r1 / w,
            angle=atan(r1 / r),
            radius=inf if kappa == 0.0 else 1.0 / kappa - roller,
        )

    def least(self, roller: float) -> Found:
        """The smallest radius of curvature where the lobe is convex, m; inf where it is nowhere."""
        if self.face is Face.FLAT:
            value, _, theta = self.force.lowest(lambda i, x: self.touch(i, x, roller).radius)
            return Found(value, theta)
        value, _, theta = self.force.lowest(lambda i, x: -self.kappa(i, x, roller))
        sharpest = -value
        return Found(1.0 / sharpest - roller if sharpest > 0.0 else inf, theta)


def lobe_of(
    system: System,
    face: Face,
    base: float,
    roller: float,
    places: Sequence[tuple[int, float]],
) -> Lobe:
    """The lobe under a follower; lengths in m.

    base: radius of the base circle; roller: radius of the roller, 0 of another face; places:
    (stretch, phase in rad) at which it is wanted, from the start of the turn to its end. It is
    undercut where the follower would need a lobe with a radius of curvature below zero, or runs
    into a corner that the slope turns down at.
    """
    geometry = _Geometry(system, face, base)
    touches = [geometry.touch(i, theta, roller) for i, theta in places]
    least = geometry.least(roller)
    slope_jumps = column(system.cam, "slope_jump")
    is_flat = face is Face.FLAT
    undercut = face is not Face.KNIFE and (
        least.value <= 0.0 or any(jump < 0.0 for jump in slope_jumps)
    )
    first_x, first_y = touches[0].place
    last_x, last_y = touches[-1].place
    return Lobe(
        face=face,
        base=base,
        roller=roller,
        touches=touches,
        least=least,
        hollow=None if is_flat else _hollow(geometry, roller, slope_jumps),
        undercut=undercut,
        largest_roller=_largest_roller(geometry) if face is Face.ROLLER else None,
        least_base=max(0.0, base - least.value) if is_flat else None,
        beside=(_beside(geometry, roller, 1.0), _beside(geometry, roller, -1.0)),
        closing=hypot(last_x - first_x, last_y - first_y),
    )


def _beside(geometry: _Geometry, roller: float, sign: float) -> Found:
    """The least (sign 1) or largest (-1) pressure angle, rad; of a flat face eccentricity, m."""

    def signed(i: int, theta: float) -> float:
        touch = geometry.touch(i, theta, roller)
        return sign * (touch.beside if geometry.face is Face.FLAT else touch.angle)

    value, _, theta = geometry.force.lowest(signed)
    return Found(sign * value, theta)


def _hollow(geometry: _Geometry, roller: float, slope_jumps: Sequence[float]) -> Found | None:
    """Radius of the sharpest hollow, m; where the slope jumps up it is the roller's own.

    slope_jumps: of c_theta at the starts of the stretches. None where the lobe has no hollow.
    """
    starts = geometry.force.starts
    rising = [start for jump, start in zip(slope_jumps, starts, strict=True) if jump > 0.0]
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
    most = LARGEST_ROLLER * geometry.base
    radius = most
    theta = 0.0
    for _ in range(ROUNDS):
        value, stretch, worst = geometry.force.lowest(partial(_nearness, geometry, radius))
        if value > -1.0:
            return None if radius == most else Found(radius, theta)
        low = 0.0
        high = radius
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if middle * geometry.kappa(stretch, worst, middle) < 1.0:
                low = middle
            else:
                high = middle
        theta = worst
        if low >= radius * (1.0 - SAME):
            return Found(low, theta)
        radius = low
    return Found(radius, theta)
