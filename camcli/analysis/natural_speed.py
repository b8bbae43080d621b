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

    Zero where the follower has neither a spring nor anything else that presses it.
    """
    first = detachment(system).first
    f = system.follower
    if first is not None:
        return NaturalSpeed(first.rpm, Basis.FIRST_LOSS)
    if f.stiffness > 0.0:
        return NaturalSpeed(rpm_of(sqrt(f.stiffness / f.mass)), Basis.NATURAL)
    pull = max(0.0, f.gravity + f.preload / f.mass)
    low, high = system.lift_range
    lift = (high - low) or 1.0
    return NaturalSpeed(rpm_of(sqrt(pull / lift)), Basis.FALL)
