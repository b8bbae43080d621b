"""How high a cam may throw its follower: whether a model of rigid bodies means anything."""

from math import inf, sqrt

from camcli.cams.compile import lift_range
from camcli.system import System, omega_of


def throw_height(system: System, rpm: float) -> float:
    """Height in m to which the cam, at its fastest, throws the follower.

    From the top with v = omega max |c_theta| to the height where v^2/2 is spent on spring, preload
    and weight; damping alone stops it after m v/b. Infinite where nothing stops it.
    """
    f = system.follower
    _, top = lift_range(system.cam)
    slope = lift_range(system.cam, 1)
    v = omega_of(rpm) * max(map(abs, slope))
    pull = f.gravity + f.preload / f.mass
    stiff = f.stiffness / f.mass
    pull += stiff * top
    slowed = pull + sqrt(max(0.0, pull * pull + stiff * v * v))
    height = v * v / slowed if slowed > 0.0 else inf
    return min(height, f.mass * v / f.damping) if f.damping else height
