"""Where and from which speed on contact is lost: exact, per smooth region of the cam.

The set of phases with N <= 0 opens in a region at the least omega*(theta) and fills it at the
largest, omega* being the smallest positive root of the quadratic in `detach_force`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

from camcli.analysis.contact_loss.force import DEG, Force
from camcli.cams.regions import Region
from camcli.kernel.cam_table import KICK, ROW
from camcli.system import System, omega_of

OK, NEVER, STANDSTILL, UNRESOLVED, JUMP = "ok", "never", "at-standstill", "unresolved", "jump"
SIDE = 1e-12  # relative distance of a bracket's ends
TIE = 1e-12  # relative difference of speeds that counts as none


@dataclass(frozen=True)
class Critical:
    """One critical speed: value and bracket in rpm (inf: never), phase in rad.

    `burst`: the region in which the burst begins whose end the speed is about, if any.
    """

    quantity: str
    region: str
    theta: float
    rpm: float
    low: float
    high: float
    status: str
    burst: str = ""

    @property
    def finite(self) -> bool:
        """True where there is such a speed."""
        return 0.0 < self.rpm < inf

    @property
    def theta_deg(self) -> float:
        """Phase within the turn, deg."""
        return self.theta * DEG


@dataclass(frozen=True)
class Loss:
    """When contact is lost in one region; `stretch` and opens.theta: where first."""

    region: Region
    stretch: int
    opens: Critical
    fills: Critical


@dataclass(frozen=True)
class Detachment:
    """`first` is None where no speed marks the beginning; `words` say why, `never` which way."""

    first: Critical | None
    losses: list[Loss]
    words: list[str]
    never: bool = False

    @property
    def first_loss(self) -> Loss | None:
        """The region of the first detachment."""
        if self.first is None:
            return None
        return next(loss for loss in self.losses if loss.region.name == self.first.region)


def detachment(system: System) -> Detachment:
    """First detachment, and opening and filling of every region."""
    force = Force(system)
    losses = [_loss(force, region) for region in force.regions]
    words = _always(force)
    finite = [loss for loss in losses if loss.opens.finite]
    if words:
        return Detachment(None, losses, words)
    if not finite:
        never = "contact is never lost: the contact force stays positive at every speed"
        return Detachment(None, losses, [never], True)
    least = min(loss.opens.rpm for loss in finite)
    opens = next(loss.opens for loss in finite if loss.opens.rpm <= least * (1.0 + TIE))
    first = Critical(
        "first_detachment", opens.region, opens.theta, opens.rpm, opens.low, opens.high,
        opens.status,
    )  # fmt: skip
    return Detachment(first, losses, [])


def _loss(force: Force, region: Region) -> Loss:
    omega, i, theta = force.lowest(lambda i, x: force.lost(i, x)[0], region.stretches)
    opens = _critical(force, "opens", region, i, theta, omega)
    late, j, place = force.lowest(lambda i, x: -force.lost(i, x)[0], region.stretches)
    back = force.lowest(lambda i, x: force.lost(i, x)[1], region.stretches)[0]
    late = -late if -late <= back else inf
    return Loss(region, i, opens, _critical(force, "fills", region, j, place, late))


def _critical(force: Force, quantity: str, region: Region, i: int, theta: float, omega: float):
    """The speed with N checked on both sides of it."""
    if omega == inf:
        return Critical(quantity, region.name, theta, inf, inf, inf, NEVER)
    if omega == 0.0:
        return Critical(quantity, region.name, theta, 0.0, 0.0, 0.0, STANDSTILL)
    rpm = omega * (30.0 / pi)
    low, high = rpm * (1.0 - SIDE), rpm * (1.0 + SIDE)
    below, above = (force.newton(i, theta, omega_of(side)) for side in (low, high))
    good = below > 0.0 >= above and (quantity != "opens" or force.held(region, low))
    return Critical(quantity, region.name, theta, rpm, low, high, OK if good else UNRESOLVED)


def _always(force: Force) -> list[str]:
    """Why contact is lost at any speed, empty where it is held at standstill."""
    words = []
    for corner in range(force.cam.stretches):
        kick = force.cam.rows[corner * ROW + KICK]
        if kick < 0.0:
            words.append(
                f"contact is lost at every speed: the cam's slope drops by {-kick:.6g} m/rad at "
                f"{force.starts[corner] * DEG:.10g} deg and throws the follower off"
            )
    weakest, _, theta = force.weakest(0.0)
    if weakest < 0.0:
        words.append(
            f"contact is not held even at standstill: the contact force is {weakest:.6g} N at "
            f"{theta * DEG:.10g} deg; give it more preload or weight"
        )
    elif weakest == 0.0:
        words.append(
            f"contact is not held even at standstill: the contact force is zero at "
            f"{theta * DEG:.10g} deg; give it a preload, weight or a spring"
        )
    return words
