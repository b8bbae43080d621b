"""The cam itself: lift and derivatives over a turn, contact force, radius of curvature.

The follower is assumed to move along a line through the cam's axis, so that q and c grow with the
distance from the axis: R(theta) = base_radius + c(theta) - lowest c. Then a flat face square to
that line touches a cam of radius of curvature rho = R + c_thetatheta, and a knife edge, or the
centre of a roller, runs along the curve of polar radius R, of curvature
    kappa = (R^2 + 2 R'^2 - R R'')/(R^2 + R'^2)^(3/2).
With a follower that is known, `lobe` has the outline and all radii of its lobe.

With a rocker c is the lift of the valve, and what runs on the cam lifts rocker_ratio times less:
c/rocker_ratio and its derivatives take the place of c in R, rho and kappa.
"""

from collections.abc import Callable
from dataclasses import dataclass

from camcli.analysis.contact_loss.detachment import CriticalSpeed, detachment
from camcli.analysis.contact_loss.force import Force, ForceCurve, polar_curvature
from camcli.analysis.lobe import Face, Lobe, lobe_of
from camcli.cams.compile import column
from camcli.cams.regions import SAME_PHASE, corner_list
from camcli.kernel.cam_table import TURN, derivative, lift_at, stretch_at
from camcli.system import System, is_measured

SMALLEST_JERK_JUMP = 1e-6  # of the largest third derivative: below it is rounding


@dataclass(frozen=True)
class Extreme:
    """A value and the phase it is taken at, rad."""

    value: float
    theta: float


@dataclass(frozen=True)
class Curvature:
    """Curvature of the lobe under a flat face, and of the pitch curve under a knife or a roller.

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
    """One turn: rad, m, m/rad, m/rad2, m/rad3; a corner has two rows, its left side first.

    So has a phase at which only the third derivative jumps. Of a measured cam it is that of the
    fitted one, which has neither jumps nor corners.
    """

    theta: list[float]
    c: list[float]
    c1: list[float]
    c2: list[float]
    c3: list[float]
    corners: dict[str, float]  # rad, by letter
    ranges: dict[str, tuple[Extreme, Extreme]]  # lowest and highest by name
    force: ForceCurve
    first: CriticalSpeed | None
    curvature: Curvature
    lobe: Lobe | None = None  # where the follower that runs on it is known


@dataclass(frozen=True)
class Runner:
    """What runs on the lobe; lengths in m."""

    face: Face
    base: float  # radius of the lobe's base circle
    roller: float = 0.0


def profile(
    system: System,
    rpm: float,
    points: int,
    base_radius: float | None,
    runner: Runner | None = None,
    drawn: bool = True,
) -> Profile:
    """The cam at `points` phases and at every corner, and what follows from it at one speed.

    base_radius: of the cam, m, None where it is not known; runner: the follower that runs on it,
    None likewise. drawn: the cam as it is drawn, or else what the follower rests on, with seat and
    lash. Force and loss of contact are in any case those of the follower, behind a lash where there
    is one.
    """
    force_on_follower = Force(system)
    first = detachment(system).first
    system = system.as_drawn if drawn else system
    force = Force(system)
    corners = corner_list(system.cam)
    jumps = {corner.stretch for corner in corners}
    if not is_measured(system):
        jumps |= _jerk_jumps(system)
    places = _places(system, sorted(jumps), points)
    lifts = [lift_at(system.cam, i, theta) for i, theta in places]
    c, c1, c2 = (list(column) for column in zip(*lifts, strict=True))
    ranges = {
        name: (_extreme(force, order, 1.0), _extreme(force, order, -1.0))
        for order, name in enumerate(("c", "c_theta", "c_thetatheta"))
    }
    ranges["c_thetathetatheta"] = _jerk_extreme(force, 1.0), _jerk_extreme(force, -1.0)
    lobe = None
    if runner is not None:
        lobe = lobe_of(system, runner.face, runner.base, runner.roller, places)
    return Profile(
        theta=[theta for _, theta in places],
        c=c,
        c1=c1,
        c2=c2,
        c3=[derivative(system.cam, 3, i, theta) for i, theta in places],
        corners={corner.name: corner.theta for corner in corners},
        ranges=ranges,
        force=force_on_follower.curve(rpm),
        first=first,
        curvature=_curvature(force, base_radius, system.rocker_ratio, c, c1, c2),
        lobe=lobe,
    )


def _jerk_jumps(system: System) -> set[int]:
    """Stretches at whose start the third derivative jumps."""
    cam = system.cam
    least = SMALLEST_JERK_JUMP * max(column(cam, "jerk_max"))
    jumps = set()
    for i, stretch in enumerate(cam.stretches):
        before = i - 1 if i > 0 else len(cam.stretches) - 1  # the last closes the turn
        at_end_before = derivative(cam, 3, before, cam.stretches[before].end)
        at_start = derivative(cam, 3, i, stretch.start)
        if abs(at_start - at_end_before) > least:
            jumps.add(i)
    return jumps


def _jerk_extreme(force: Force, sign: float) -> Extreme:
    """The smallest third derivative (sign 1), or the largest (-1), from within a stretch."""
    value, _, theta = force.lowest(lambda i, x: sign * derivative(force.cam, 3, i, x))
    return Extreme(sign * value, theta)


def _places(system: System, corners: list[int], points: int) -> list[tuple[int, float]]:
    """(stretch, phase) of every row of a profile in order; the last is the end of the turn.

    corners: stretches that begin with a jump, at which there are two rows: the end of the stretch
    before, then the start of this one. The other rows are `points` equal steps of a turn.
    """
    starts = Force(system).starts
    ends = Force(system).ends
    last = len(system.cam.stretches) - 1
    ending, starting = 0, 1  # at one phase the end of a stretch comes first
    places = [(starts[i], starting, i) for i in corners]
    places += [(ends[i - 1], ending, i - 1) for i in corners if i > 0]
    for k in range(points):
        theta = TURN * k / points
        if all(abs(theta - starts[i]) > SAME_PHASE for i in corners):
            places.append((theta, starting, stretch_at(system.cam, theta)))
    places.append((ends[last], ending, last))
    return [(i, theta) for theta, _, i in sorted(places)]


def _extreme(force: Force, order: int, sign: float) -> Extreme:
    """The smallest c, or derivative of that order, over the turn (sign 1), or the largest (-1)."""
    return _lowest(force, lambda *lifts: sign * lifts[order], sign)


def _lowest(force: Force, f: Callable[[float, float, float], float], sign: float = 1.0) -> Extreme:
    """The smallest f(c, c_theta, c_thetatheta) over the turn; its value is multiplied by `sign`."""
    value, _, theta = force.lowest(lambda i, x: f(*lift_at(force.cam, i, x)))
    return Extreme(sign * value, theta)


def _curvature(
    force: Force,
    base: float | None,
    ratio: float,
    c: list[float],
    c1: list[float],
    c2: list[float],
) -> Curvature:
    """The curvature of the lobe; c, c1, c2: of the follower, which lifts `ratio` times as far.

    base: radius of the base circle, m, None where it is not known. The lobe's distance R from the
    axis is c/ratio + `radius`.
    """
    lowest = _extreme(force, 0, 1.0).value / ratio
    radius = (base or 0.0) - lowest

    def flat(c: float, c2: float) -> float:
        """Radius of curvature of the lobe under a flat face, R + R'', m."""
        return c / ratio + radius + c2 / ratio

    def knife(c: float, c1: float, c2: float) -> float:
        """Curvature of the curve along which a knife edge runs, 1/m."""
        return polar_curvature(c / ratio + radius, c1 / ratio, c2 / ratio)

    needed = -_lowest(force, lambda c, c1, c2: c / ratio - lowest + c2 / ratio).value
    largest_roller = None
    if base is not None:
        sharpest = _lowest(force, lambda c, c1, c2: -knife(c, c1, c2), -1.0)
        if sharpest.value > 0.0:
            largest_roller = Extreme(1.0 / sharpest.value, sharpest.theta)
    rows = list(zip(c, c1, c2, strict=True))
    return Curvature(
        base_radius=base,
        flat=[flat(lift, accel) for lift, _, accel in rows],
        flat_least=_lowest(force, lambda c, c1, c2: flat(c, c2)),
        least_base_radius=max(0.0, needed),
        knife=None if base is None else [knife(*row) for row in rows],
        roller=largest_roller,
    )
