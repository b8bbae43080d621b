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

    It is the cam as it is drawn, or else what the follower rests on, with seat and lash; force and
    loss of contact are those of the follower, behind a lash where there is one.
    """
    pressed = Force(system)
    first = detachment(system).first
    system = system.as_drawn if drawn else system
    force = Force(system)
    corners = corner_list(system.cam)
    names = {corner.name: corner.theta for corner in corners}
    smooth = is_measured(system)
    jumps = {corner.stretch for corner in corners} | (set() if smooth else _jerk_jumps(system))
    places = _places(system, sorted(jumps), points)
    rows = [(theta, *lift_at(system.cam, i, theta)) for i, theta in places]
    theta, c, c1, c2 = (list(column) for column in zip(*rows, strict=True))
    ranges = {
        name: (_extreme(force, order, 1.0), _extreme(force, order, -1.0))
        for order, name in enumerate(("c", "c_theta", "c_thetatheta"))
    }
    ranges["c_thetathetatheta"] = _jerk_extreme(force, 1.0), _jerk_extreme(force, -1.0)
    return Profile(
        theta, c, c1, c2,
        [derivative(system.cam, 3, i, theta) for i, theta in places],
        names,
        ranges=ranges,
        force=pressed.curve(rpm),
        first=first,
        curvature=_curvature(force, base_radius, system.rocker_ratio, c, c1, c2),
        lobe=None if runner is None
        else lobe_of(system, runner.face, runner.base, runner.roller, places),
    )  # fmt: skip


def _jerk_jumps(system: System) -> set[int]:
    """Stretches at whose start the third derivative jumps."""
    cam = system.cam
    starts, ends = column(cam, "start"), column(cam, "end")
    least = SMALLEST_JERK_JUMP * max(column(cam, "jerk_max"))
    # before[i] is the value at the end of stretch i; that of the last, before[-1], meets the start
    # of stretch 0, which closes the turn
    before = [derivative(cam, 3, i, end) for i, end in enumerate(ends)]
    after = [derivative(cam, 3, i, start) for i, start in enumerate(starts)]
    return {i for i in range(len(starts)) if abs(after[i] - before[i - 1]) > least}


def _jerk_extreme(force: Force, sign: float) -> Extreme:
    """The smallest third derivative (sign 1), or the largest (-1), from within a stretch."""
    value, _, theta = force.lowest(lambda i, x: sign * derivative(force.cam, 3, i, x))
    return Extreme(sign * value, theta)


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
    """The curvature of the lobe; c, c1, c2: of the follower, which lifts `ratio` times as far."""
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
