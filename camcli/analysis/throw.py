"""How high a cam may throw its follower: whether a model of rigid bodies means anything."""

from dataclasses import dataclass
from math import inf, sqrt

from camcli.cams.compile import lift_range
from camcli.system import System, omega_of


@dataclass(frozen=True)
class Throw:
    """A speed, the height to which the cam throws the follower there, and its lift, m."""

    rpm: float
    height: float
    lift: float


def throw(system: System, rpm: float) -> Throw:
    """The height in m to which the cam, at its fastest, throws the follower.

    From the top with v = omega max |c_theta| to the height where v^2/2 is spent on spring, preload
    and weight; damping alone stops it after m v/b. Infinite where nothing stops it.
    """
    f = system.follower
    low, top = lift_range(system.cam)
    slope = lift_range(system.cam, 1)
    v = omega_of(rpm) * max(map(abs, slope))
    pull = f.gravity + f.preload / f.mass
    stiff = f.stiffness / f.mass
    pull += stiff * top
    slowed = pull + sqrt(max(0.0, pull * pull + stiff * v * v))
    height = v * v / slowed if slowed > 0.0 else inf
    if f.damping:
        height = min(height, f.mass * v / f.damping)
    return Throw(rpm, height, top - low)
