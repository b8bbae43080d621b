"""Where and from which speed on contact is lost: exact, per smooth region of the cam.

The set of phases with N <= 0 opens in a region at the least omega*(theta) and fills it at the
largest, omega* being the smallest positive root of the quadratic in `force`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, partial
from math import inf

from camcli.analysis.bracketing import NARROW
from camcli.analysis.contact_loss.force import Force
from camcli.cams.regions import Region
from camcli.kernel.cam_table import TURN, stretch_at
from camcli.system import System, omega_of, rpm_of


class CriticalQuantity(StrEnum):
    """What a critical speed is about, as in detach.csv."""

    FIRST_DETACHMENT = "first_detachment"
    OPENS = "opens"
    FILLS = "fills"
    ACCUMULATION = "accumulation_at_corner"
    COMPLETION_LOSS = "completion_loss"
    HOLD_STIFFNESS = "hold_stiffness"
    HOLD_PRELOAD = "hold_preload"
    HOLD_BOTH = "hold_both"


class SpeedStatus(StrEnum):
    """What is known of a critical speed.

    OK: it lies in its bracket. NEVER: there is none. STANDSTILL: contact is lost without turning.
    UNRESOLVED: no bracket is safe. JUMP: the quantity jumps over its goal between the ends.
    """

    OK = "ok"
    NEVER = "never"
    STANDSTILL = "at-standstill"
    UNRESOLVED = "unresolved"
    JUMP = "jump"


@dataclass(frozen=True)
class CriticalSpeed:
    """One critical speed: value and bracket in rpm (inf: never), phase in rad.

    region: of the cam, in which contact is lost; of an accumulation the corner that it reaches.
    burst: the region in which the burst begins whose end the speed is about, if any.
    """

    quantity: CriticalQuantity
    region: str
    theta: float
    rpm: float
    low: float
    high: float
    status: SpeedStatus
    burst: str = ""

    @property
    def finite(self) -> bool:
        """True where contact is lost here at some speed."""
        return 0.0 < self.rpm < inf


@dataclass(frozen=True)
class Loss:
    """When contact is lost in one region; `stretch` and opens.theta: where first."""

    region: Region
    stretch: int
    opens: CriticalSpeed
    fills: CriticalSpeed


class NoStatement(StrEnum):
    """Why nothing about the loss of contact is a statement of a certificate."""

    LASH = "lash"
    FITTED = "fitted"  # the cam is known as polynomials that were fitted to a table
    KINKED = "kinked"  # the slope of the cam jumps
    NO_SPEED = "no-speed"  # contact is held at no speed, or at all
    INSIDE = "inside"  # it is first lost inside a smooth part of the cam


class Reason(StrEnum):
    """Why contact is lost at any speed."""

    KINK = "kink"  # c_theta drops, by `value` m/rad, and the follower goes on
    FORCE = "force"  # the force at standstill is `value` N, not above zero


@dataclass(frozen=True)
class AlwaysLost:
    """A phase (rad) where contact is lost at any speed."""

    reason: Reason
    theta: float
    value: float


@dataclass(frozen=True)
class Detachment:
    """`first` is None where contact is never lost, or lost at any speed: `always` says why."""

    first: CriticalSpeed | None
    losses: tuple[Loss, ...]
    always: tuple[AlwaysLost, ...]

    @property
    def never(self) -> bool:
        """True where contact is held at every speed."""
        return self.first is None and not self.always


def detachment(system: System) -> Detachment:
    """First detachment, and opening and filling of every region; computed once for a machine."""
    if "detachment" not in system.known:
        system.known["detachment"] = _detachment(system)
    return system.known["detachment"]


def _detachment(system: System) -> Detachment:
    """`detachment`, computed."""
    force = Force(system)
    losses = tuple(_loss(force, region) for region in force.regions)
    always = _always(force, losses)
    finite = [loss.opens for loss in losses if loss.opens.finite]
    if always or not finite:
        return Detachment(None, losses, always)
    least = min(opens.rpm for opens in finite)
    first = next(opens for opens in finite if opens.rpm <= least * (1.0 + NARROW))
    return Detachment(replace(first, quantity=CriticalQuantity.FIRST_DETACHMENT), losses, ())


def _loss(force: Force, region: Region) -> Loss:
    """The speeds (rpm) at which the lost set of a region opens, and at which it fills it.

    At a phase contact is lost from one speed on, and where a fast cam presses the follower again up
    to another (`Force.lost`). The set opens at the least of the first ones and fills the region at
    the largest, unless contact comes back somewhere before that.
    """
    speeds = cache(force.lost)  # it is asked for three times at the same samples
    opening, i, opens_at = force.lowest(lambda i, x: speeds(i, x).lost, region.stretches)
    minus_filling, j, fills_at = force.lowest(lambda i, x: -speeds(i, x).lost, region.stretches)
    regained, _, _ = force.lowest(lambda i, x: speeds(i, x).regained, region.stretches)
    filling = -minus_filling if -minus_filling <= regained else inf
    opens = _critical(force, CriticalQuantity.OPENS, region, i, opens_at, opening)
    fills = _critical(force, CriticalQuantity.FILLS, region, j, fills_at, filling)
    return Loss(region, i, opens, fills)


def _critical(
    force: Force, quantity: CriticalQuantity, region: Region, i: int, theta: float, omega: float
) -> CriticalSpeed:
    """The critical speed omega (rad/s) of a phase of stretch i, with N checked on both sides of it.

    Where N does not change its sign between both ends of the bracket, it is UNRESOLVED.
    """
    if omega in (0.0, inf):
        status = SpeedStatus.NEVER if omega == inf else SpeedStatus.STANDSTILL
        return CriticalSpeed(quantity, region.name, theta, omega, omega, omega, status)
    rpm = rpm_of(omega)
    low = rpm * (1.0 - NARROW)
    high = rpm * (1.0 + NARROW)
    force_below = force.newton(i, theta, omega_of(low))
    force_above = force.newton(i, theta, omega_of(high))
    is_bracketed = force_below > 0.0 >= force_above
    if quantity == CriticalQuantity.OPENS:
        is_bracketed = is_bracketed and force.stays_positive(region, low)
    status = SpeedStatus.OK if is_bracketed else SpeedStatus.UNRESOLVED
    return CriticalSpeed(quantity, region.name, theta, rpm, low, high, status)


def _always(force: Force, losses: Sequence[Loss]) -> tuple[AlwaysLost, ...]:
    """Why contact is lost at any speed: kinks where the slope drops, and a force at standstill.

    Empty where there is no such kink, and the follower presses at standstill.
    """
    drops = [-force.cam.stretches[i].slope_jump for i in range(len(force.cam.stretches))]
    kinks = [
        AlwaysLost(Reason.KINK, start, drop)
        for start, drop in zip(force.starts, drops, strict=True)
        if drop > 0.0
    ]
    if all(loss.opens.status is not SpeedStatus.STANDSTILL for loss in losses):
        return tuple(kinks)
    weakest, _, theta = force.weakest(0.0)
    if abs(weakest) <= force.a_rounding * force.mass:
        weakest = 0.0
    return (*kinks, AlwaysLost(Reason.FORCE, theta, weakest))


def first_loss(system: System, errors: Sequence[float] = (0.0,), share: float = 0.0) -> float:
    """The rpm at which contact is first lost; 0 at standstill, inf never.

    errors: bounds on the error of a measured c_thetatheta, m/rad2, in equal parts of the turn;
    share: by how much of them it is off, from -1, lost soonest, to 1.
    """
    force = Force(system, _shared(errors, share))
    omega, _, _ = force.lowest(partial(_lost_from, force))
    return rpm_of(omega)


def loss_range(system: System, errors: Sequence[float], rough: System) -> tuple[float, float]:
    """The rpm between which contact is first lost, with a measured cam within its error.

    rough: the machine with a rougher fit of the cam (`TableCam.rougher`).

    The upper end is a speed at which contact is lost at some phase, however much the error presses
    there. The least such speed of a noisy curve lies below that of the true one, the more so the
    flatter it is: so the phases are those where a rougher fit, whose noise is another, is weakest,
    both as it is and with the error that presses. Where the bound on the error is large, such as
    on a flank, the first of them may never lose contact, while the nose surely does.
    """
    pressed = Force(system, _shared(errors, 1.0))  # the error presses as much as it may
    omegas = []
    for share in (0.0, 1.0):
        rough_force = Force(rough, _shared(errors, share))
        _, _, weakest = rough_force.lowest(partial(_lost_from, rough_force))
        omegas.append(_lost_from(pressed, stretch_at(system.cam, weakest), weakest))
    return first_loss(system, errors, -1.0), rpm_of(min(omegas))


def _lost_from(force: Force, i: int, theta: float) -> float:
    """The speed (rad/s) from which contact is lost at theta on stretch i."""
    return force.lost(i, theta).lost


def _shared(errors: Sequence[float], share: float) -> Callable[[float], float]:
    """A function of phase (rad) that returns a share of the error there, m/rad2.

    errors: in equal parts of a turn.
    """
    last = len(errors) - 1
    return lambda theta: share * errors[min(int(theta / TURN * (last + 1)), last)]
