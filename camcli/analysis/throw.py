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

    From the top of the cam with v = omega max |c_theta| it rises by h until v^2/2 is spent on
    spring, preload and weight: with F the force per mass at the top and K = k/m,
        v^2/2 = F h + K h^2/2,    h = v^2/(F + sqrt(F^2 + K v^2)).
    Damping alone stops it after m v/b. Infinite where nothing stops it.
    """
    follower = system.follower
    low, top = lift_range(system.cam)
    slopes = lift_range(system.cam, 1)  # lowest and highest c_theta
    v = omega_of(rpm) * max(map(abs, slopes))
    stiffness = follower.stiffness / follower.mass
    pull = follower.gravity + follower.preload / follower.mass
    pull += stiffness * top
    divisor = pull + sqrt(max(0.0, pull * pull + stiffness * v * v))
    height = v * v / divisor if divisor > 0.0 else inf
    if follower.damping:
        height = min(height, follower.mass * v / follower.damping)
    return Throw(rpm, height, top - low)
