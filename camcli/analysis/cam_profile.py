"""The cam itself: lift and derivatives over a turn, contact force, radius of curvature.

The follower is assumed to move along a line through the cam's axis, so that q and c grow with the
distance from the axis: R(theta) = base_radius + c(theta) - lowest c. Then a flat face square to
that line touches a cam of radius of curvature rho = R + c_thetatheta, and a knife edge, or the
centre of a roller, runs along the curve of polar radius R, of curvature
    kappa = (R^2 + 2 R'^2 - R R'')/(R^2 + R'^2)^(3/2).

With a rocker c is the lift of the valve, and what runs on the cam lifts rocker_ratio times less:
c/rocker_ratio and its derivatives take the place of c in R, rho and kappa.
"""

from collections.abc import Callable
from dataclasses import dataclass

from camcli.analysis.contact_loss.detachment import CriticalSpeed, detachment
from camcli.analysis.contact_loss.force import Force, ForceCurve, polar_curvature
from camcli.cams.regions import SAME_PHASE, corner_list
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.system import System


@dataclass(frozen=True)
class Extreme:
    """A value and the phase it is taken at, rad."""

    value: float
    theta: float


@dataclass(frozen=True)
class Curvature:
    """Of the lobe under a flat face (less the base radius where that is unknown), and of a knife.

    `knife` is None without a base radius. `roller`: largest roller that follows the pitch curve,
    None where nothing limits it.
    """

    base_radius: float | None
    flat: list[float]  # m
    flat_least: Extreme  # m
    least_base_radius: float  # m, from which on a flat face is not undercut
    knife: list[float] | None  # 1/m
    roller: Extreme | None  # m

    @property
    def undercut(self) -> bool:
        """Whether a flat face is cut by the cam beside its contact."""
        return self.base_radius is not None and self.flat_least.value <= 0.0


@dataclass(frozen=True)
class Profile:
    """One turn: rad, m, m/rad, m/rad2; a corner has two rows, its left side first."""

    theta: list[float]
    c: list[float]
    c1: list[float]
    c2: list[float]
    corners: dict[str, float]  # rad, by letter
    ranges: dict[str, tuple[Extreme, Extreme]]  # lowest and highest by name
    force: ForceCurve
    first: CriticalSpeed | None
    curvature: Curvature


def profile(system: System, rpm: float, points: int, base_radius: float | None) -> Profile:
    """The cam at `points` phases and at every corner, and what follows from it at one speed."""
    force = Force(system)
    corners = corner_list(system.cam)
    names = {corner.name: corner.theta for corner in corners}
    rows = [
        (theta, *lift_at(system.cam, i, theta))
        for i, theta in _places(system, [corner.stretch for corner in corners], points)
    ]
    theta, c, c1, c2 = (list(column) for column in zip(*rows, strict=True))
    return Profile(
        theta, c, c1, c2, names,
        ranges={
            name: (_extreme(force, order, 1.0), _extreme(force, order, -1.0))
            for order, name in enumerate(("c", "c_theta", "c_thetatheta"))
        },
        force=force.curve(rpm),
        first=detachment(system).first,
        curvature=_curvature(force, base_radius, system.rocker_ratio, c, c1, c2),
    )  # fmt: skip


def _places(system: System, corners: list[int], points: int) -> list[tuple[int, float]]:
    """(stretch, phase) of every row in order; the last is the end of the turn."""
    starts = Force(system).starts
    ends = Force(system).ends
    last = len(system.cam.stretches) - 1
    places = [(i, starts[i], 1) for i in corners]
    places += [(i - 1, ends[i - 1], 0) for i in corners if i > 0]
    for k in range(points):
        theta = TURN * k / points
        if all(abs(theta - starts[i]) > SAME_PHASE for i in corners):
            places.append((stretch_at(system.cam, theta), theta, 1))
    places.append((last, ends[last], 0))
    return [(i, theta) for i, theta, _ in sorted(places, key=lambda row: (row[1], row[2]))]


def _extreme(force: Force, order: int, sign: float) -> Extreme:
    return _lowest(force, lambda *values: sign * values[order], sign)


def _lowest(force: Force, f: Callable[[float, float, float], float], sign: float = 1.0) -> Extreme:
    """Smallest f(c, c_theta, c_thetatheta) over the turn, times `sign`."""
    value, _, theta = force.lowest(lambda i, x: f(*lift_at(force.cam, i, x)))
    return Extreme(sign * value, theta)


def _curvature(force: Force, base: float | None, ratio: float, c, c1, c2) -> Curvature:
    """Of the lobe; c, c1, c2: lift of the follower and its derivatives, ratio times the lobe's."""
    lowest = _extreme(force, 0, 1.0).value / ratio
    radius = (base or 0.0) - lowest

    def flat(q: float, a: float) -> float:
        return q / ratio + radius + a / ratio

    def knife(q: float, v: float, a: float) -> float:
        return polar_curvature(q / ratio + radius, v / ratio, a / ratio)

    needed = -_lowest(force, lambda q, _, a: q / ratio - lowest + a / ratio).value
    sharpest = None
    if base is not None:
        sharp = _lowest(force, lambda q, v, a: -knife(q, v, a), -1.0)
        if sharp.value > 0.0:
            sharpest = Extreme(1.0 / sharp.value, sharp.theta)
    rows = list(zip(c, c1, c2, strict=True))
    return Curvature(
        base_radius=base,
        flat=[flat(q, a) for q, _, a in rows],
        flat_least=_lowest(force, lambda q, _, a: flat(q, a)),
        least_base_radius=max(0.0, needed),
        knife=None if base is None else [knife(q, v, a) for q, v, a in rows],
        roller=sharpest,
    )
