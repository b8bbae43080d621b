"""The speed by which ranges are chosen for a machine whose scene leaves them open."""

from dataclasses import dataclass
from enum import StrEnum
from math import sqrt

from camcli.analysis.contact_loss.detachment import detachment
from camcli.system import System, rpm_of


class Basis(StrEnum):
    """What happens at the speed of a `NaturalSpeed`."""

    FIRST_LOSS = "first-loss"  # contact is first lost
    NATURAL = "natural-frequency"  # the cam turns as often as the follower swings on its spring
    FALL = "fall"  # the cam accelerates as the follower falls


@dataclass(frozen=True)
class NaturalSpeed:
    """A speed that belongs to a machine, and what happens there."""

    rpm: float
    basis: Basis


@dataclass(frozen=True)
class Chosen:
    """The speeds that were chosen for a section; by: None where they are that of `run.rpm`."""

    low: float
    high: float
    by: NaturalSpeed | None


def natural_speed(system: System) -> NaturalSpeed:
    """The first loss of contact; where contact is never or always lost, another speed.

    That is the follower's own frequency on its spring, or without a spring the speed omega at which
    omega^2 lift equals what pulls it down. Zero where nothing presses it.
    """
    first = detachment(system).first
    follower = system.follower
    if first is not None:
        return NaturalSpeed(first.rpm, Basis.FIRST_LOSS)
    if follower.stiffness > 0.0:
        return NaturalSpeed(rpm_of(sqrt(follower.stiffness / follower.mass)), Basis.NATURAL)
    pull = max(0.0, follower.gravity + follower.preload / follower.mass)
    low, high = system.lift_range
    lift = (high - low) or 1.0
    return NaturalSpeed(rpm_of(sqrt(pull / lift)), Basis.FALL)
