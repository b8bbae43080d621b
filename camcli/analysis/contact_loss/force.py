"""The contact force of a follower that stays on the cam, as a function of phase and speed.

    N/m = A + B omega + C omega^2,
    A = g + F0/m + omega0^2 c,  B = 2 zeta c_theta,  C = c_thetatheta,

one quadratic in omega for each phase; contact is lost where N reaches zero. On the seat of a cam
with lash nothing accelerates: what is asked here of the lowest force is asked of the lobe alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, pi, sqrt
from typing import NamedTuple

from camcli.analysis.bracketing import TIE, lowest
from camcli.cams.compile import column
from camcli.cams.regions import Region, regions
from camcli.errors import SceneError
from camcli.kernel.cam_table import lift_at
from camcli.kernel.sticking import find_detachment
from camcli.system import System, omega_of

PER_PIECE = 48  # samples per polynomial piece, which is short enough for a minimum or two
FORCE_ROUNDING = 2.0**-49  # of A, B and C, relative: the table's lift is exact to some 4 ulp
CURVE = 720  # points of a force curve: half a degree, finer than any picture


@dataclass(frozen=True)
class ForceCurve:
    """N along one turn at one speed, one-sided on both sides of a corner; rad, N, Pa."""

    rpm: float
    theta: list[float]
    force_n: list[float]
    lowest_n: float
    lowest_theta: float
    pressure_pa: list[float] = field(default_factory=list)  # empty where it is not known

    def highest(self, values: list[float]) -> tuple[float, float]:
        """(largest, its phase in rad) of the forces or pressures."""
        return max(zip(values, self.theta, strict=True))


class LostBetween(NamedTuple):
    """Speeds, rad/s, between which contact is lost at a phase; see `Force.lost`."""

    lost: float
    regained: float


class Force:
    """Contact force of one machine; `i` is a stretch, theta a phase within it (rad)."""

    def __init__(self, system: System, error: Callable[[float], float] = lambda theta: 0.0):
        """error: what is added to c_thetatheta at a phase, m/rad2."""
        f = system.follower
        self.error = error
        self.system = system
        self.cam = system.cam
        self.mass = f.mass
        self.weight = f.gravity + f.preload / f.mass
        self.spring = f.stiffness / f.mass
        self.damper = f.damping / f.mass
        size = max(abs(c) for c in (system.cam.top, *column(system.cam, "c_min")))
        largest_accel = max(max(abs(s.accel_min), abs(s.accel_max)) for s in system.cam.stretches)
        # values of A, B and C no larger than these are zero but for rounding
        self.a_rounding = FORCE_ROUNDING * (abs(self.weight) + self.spring * size)
        self.b_rounding = FORCE_ROUNDING * self.damper * largest_accel
        self.c_rounding = FORCE_ROUNDING * largest_accel
        on_seat = column(self.cam, "seat")
        self.on_lobe = [i for i in range(len(on_seat)) if not on_seat[i]]
        lobe = set(self.on_lobe)  # a smooth region may lie on the lobe and on a seat without lash
        self.regions = [
            replace(region, stretches=tuple(i for i in region.stretches if i in lobe))
            for region in regions(system.cam)
            if lobe.intersection(region.stretches)
        ]
        self.starts = column(self.cam, "start")
        self.ends = column(self.cam, "end")
        self.counts = [int(n) for n in column(self.cam, "piece_count")]

    def terms(self, i: int, theta: float) -> tuple[float, float, float]:
        """(A, B, C) above."""
        c, c1, c2 = lift_at(self.cam, i, theta)
        return self.weight + self.spring * c, self.damper * c1, c2 + self.error(theta)

    def newton(self, i: int, theta: float, omega: float) -> float:
        """N in newton."""
        a, b, c = self.terms(i, theta)
        return self.mass * (a + omega * (b + omega * c))

    def lost(self, i: int, theta: float) -> LostBetween:
        """The speeds between which N <= 0: the roots of the quadratic.

        (0, inf) where contact is lost at standstill already, (inf, inf) where it is never lost.
        With C > 0 a fast cam presses the follower again, so that contact is regained at some speed.
        Where A is zero but for rounding, the terms of the motion decide whether contact is held.
        """
        a, b, c = self.terms(i, theta)
        if a <= self.a_rounding:
            b_presses = b > self.b_rounding
            c_presses = b >= -self.b_rounding and c > self.c_rounding
            if a < -self.a_rounding or not (b_presses or c_presses):
                return LostBetween(0.0, inf)
            return LostBetween(-b / c if c < -self.c_rounding else inf, inf)
        discriminant = b * b - 4.0 * a * c
        if discriminant < 0.0:
            return LostBetween(inf, inf)
        root = sqrt(discriminant) - b  # the roots are 2 a/root and root/(2 c): nothing cancels
        if root <= 0.0:
            return LostBetween(inf, inf)
        return LostBetween(2.0 * a / root, root / (2.0 * c) if c > 0.0 else inf)

    def lowest(
        self,
        f: Callable[[int, float], float],
        stretches: Sequence[int] | None = None,
        rounding: float = 0.0,
    ) -> tuple[float, int, float]:
        """(value, stretch, theta) of the smallest f(i, theta) on some stretches.

        The default is every stretch that is not a seat. Where several places have the smallest
        value but for TIE and `rounding`, the first of them is taken.
        """
        stretches = self.on_lobe if stretches is None else stretches
        best, best_stretch, best_theta = inf, stretches[0], self.starts[stretches[0]]
        for i in stretches:
            samples = PER_PIECE * self.counts[i]
            value, theta = lowest(partial(f, i), self.starts[i], self.ends[i], samples)
            if value < best and not value >= best - TIE * abs(best) - rounding:
                best, best_stretch, best_theta = value, i, theta
        return best, best_stretch, best_theta

    def weakest(self, rpm: float) -> tuple[float, int, float]:
        """(N, stretch, theta) where the force on the cam is smallest over a turn."""
        omega = omega_of(rpm)
        rounding_of_sum = self.a_rounding + omega * (self.b_rounding + omega * self.c_rounding)
        rounding = self.mass * rounding_of_sum
        return self.lowest(lambda i, x: self.newton(i, x, omega), rounding=rounding)

    def stays_positive(self, region: Region, rpm: float) -> bool:
        """True where the kernel's own certified step finds no zero of N in the region.

        False at a speed so low that the constants there are no doubles.
        """
        tolerance, impact_budget = 1e-9, 1  # of no account here
        try:
            const = self.system.constants(rpm, tolerance, impact_budget)
        except SceneError:
            return False
        for i in region.stretches:
            released, _ = find_detachment(self.cam, const, i, self.starts[i])
            if released:
                return False
        return True

    def region_of(self, stretch: int) -> Region:
        """The region that holds a stretch."""
        return next(region for region in self.regions if stretch in region.stretches)

    def curve(self, rpm: float, points: int = CURVE, hertz: Hertz | None = None) -> ForceCurve:
        """N over a turn, `points` per turn at least, and its minimum; with `hertz` the pressure."""
        omega = omega_of(rpm)
        points_per_rad = points / (self.ends[-1] - self.starts[0])
        thetas = []
        forces = []
        pressures = []
        for i, stretch in enumerate(self.cam.stretches):
            low = self.starts[i]
            high = self.ends[i]
            count = int((high - low) * points_per_rad) + 1
            for k in range(count + 1):
                theta = high if k == count else low + (high - low) * (k / count)
                force = self.newton(i, theta, omega)
                thetas.append(theta)
                forces.append(force)
                if hertz is not None and stretch.seat:
                    pressures.append(0.0)
                elif hertz is not None:
                    pressures.append(hertz.pressure(force, *lift_at(self.cam, i, theta)))
        value, _, at = self.weakest(rpm)
        return ForceCurve(rpm, thetas, forces, value, at, pressures)


@dataclass(frozen=True)
class Hertz:
    """A flat face or a roller on the cam, all in SI: the pressure of a line contact.

        p = sqrt(N E*/(pi w R)),  1/R = 1/(R_cam + c_thetatheta)  or  1/(r (1 - kappa r))

    of a face on the cam at distance R_cam from its axis, and of a roller of radius r on a pitch
    curve of curvature kappa (K. L. Johnson, Contact Mechanics, Cambridge University Press 1985,
    section 4.2). The follower moves along a line through the axis, as in `cam_profile`. With a
    rocker what runs on the cam lifts `ratio` times less than the valve and is pressed `ratio` times
    as hard.
    """

    width: float
    modulus: float  # E*
    base: float  # radius of the cam where c is zero
    roller: float | None = None
    ratio: float = 1.0  # lift of the follower per lift of the lobe

    def pressure(self, force: float, c: float, c1: float, c2: float) -> float:
        """Largest pressure, Pa; inf where the cam is undercut, 0 where it does not press.

        Of the contact force (N) and the lift (m, m/rad, m/rad2) of the follower.
        """
        force_on_lobe = force * self.ratio
        lobe_c = c / self.ratio
        lobe_c1 = c1 / self.ratio
        lobe_c2 = c2 / self.ratio
        if self.roller is None:
            radius = self.base + lobe_c + lobe_c2
        else:
            kappa = polar_curvature(self.base + self.roller + lobe_c, lobe_c1, lobe_c2)
            radius = self.roller * (1.0 - kappa * self.roller)
        if force_on_lobe <= 0.0:
            return 0.0
        if radius <= 0.0:
            return inf
        return sqrt(force_on_lobe * self.modulus / (pi * self.width * radius))


def polar_curvature(radius: float, slope: float, accel: float) -> float:
    """(R^2 + 2 R'^2 - R R'')/(R^2 + R'^2)^(3/2), 1/m, positive where the curve is convex."""
    square = radius * radius + slope * slope
    if square == 0.0:
        return inf
    return (square + slope * slope - radius * accel) / (square * sqrt(square))
