"""What a measured lift table is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from math import isfinite, nan
from typing import TYPE_CHECKING, Any

from camcli.system import is_measured
from camcli.words.lift_table import MEANING

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.detachment import CriticalSpeed, Detachment
    from camcli.analysis.contact_loss.study import ContactLoss
    from camcli.cams.lift_table import TableCam
    from camcli.system import System

UNKNOWN = (nan, nan)  # a bracket


def accel_errors(cam: Any) -> Sequence[float]:
    """Bounds on the error of c_thetatheta, m/rad2, in equal parts of the turn; 0 of a law."""
    return cam.errors.bounds if cam.kind == "table" else (0.0,)


def lost_between(system: System) -> tuple[float, float] | None:
    """The rpm between which contact is first lost, as far as a measured cam tells; None of a law.

    c_thetatheta of a measured cam is known up to an error, and so is the speed of the first loss.
    A second fit of the same rows, smoothed over longer lengths, says at which phases the force is
    weakest: it has other noise (see `loss_range`). Computed once for a machine.
    """
    if not is_measured(system):
        return None
    if "lost_between" not in system.known:
        system.known["lost_between"] = _lost_between(system)
    return system.known["lost_between"]


def _lost_between(system: System) -> tuple[float, float]:
    """`lost_between` of a measured cam, computed."""
    from camcli.analysis.contact_loss.detachment import loss_range
    from camcli.system import System

    cam: Any = system.shape
    rougher_shape, rougher_cam = cam.rougher
    rougher = System(system.follower, rougher_cam, rougher_shape)
    return loss_range(system, cam.errors.bounds, rougher)


def widened(detachment: Detachment, system: System) -> Detachment:
    """The critical speeds with brackets as wide as the error of a measured cam leaves them.

    A region of the cam opens at the speed at which contact is first lost in it, and is filled where
    contact is lost all over it. Only the first detachment of all has a known range; what else is
    finite (there are more regions where the strobe or a lash cuts the cam) has an unknown one.
    """
    first_loss_range = lost_between(system)
    if first_loss_range is None:
        return detachment
    first = detachment.first
    losses = []
    for loss in detachment.losses:
        is_first = first is not None and loss.region.name == first.region
        opens = _with_bracket(loss.opens, first_loss_range if is_first else UNKNOWN)
        fills = _with_bracket(loss.fills, UNKNOWN) if loss.fills.finite else loss.fills
        losses.append(replace(loss, opens=opens, fills=fills))
    if first is not None:
        first = _with_bracket(first, first_loss_range)
    return replace(detachment, first=first, losses=tuple(losses))


def with_ranges(loss: ContactLoss, system: System) -> ContactLoss:
    """The study of the loss of contact, its brackets as wide as the error of a measured cam.

    The brackets of speeds that hang on a chatter are NaN: a chatter depends on more of the table
    than on one phase, and how far it is off is not known.
    """
    if lost_between(system) is None:
        return loss
    from camcli.analysis.contact_loss.hold import replaced

    holds = []
    for hold in loss.holds:
        if hold.detaches is not None:
            with_spring = replaced(system, hold.stiffness or 0.0, hold.preload or 0.0)
            low, high = lost_between(with_spring) or UNKNOWN
            hold = replace(hold, low=low, high=high)
        holds.append(hold)
    return replace(
        loss,
        detachment=widened(loss.detachment, system),
        ends=tuple(_with_bracket(speed, UNKNOWN) for speed in loss.ends),
        completion=tuple(_with_bracket(speed, UNKNOWN) for speed in loss.completion),
        holds=tuple(holds),
    )


def _with_bracket(speed: CriticalSpeed, bracket: tuple[float, float]) -> CriticalSpeed:
    """The critical speed with another bracket; bracket: (low, high) in rpm."""
    low, high = bracket
    return replace(speed, low=low, high=high)


def table_record(cam: TableCam, system: System) -> dict[str, Any]:
    """The entry of run.json: the fit of the lift table, and the range of the first loss (rpm)."""
    accuracy = cam.accuracy
    first_loss_range = lost_between(system) or ()
    return {
        **asdict(accuracy),
        "bound": accuracy.bound,
        "units": "m, deg, m/rad2",
        "first_detachment_rpm": [rpm if isfinite(rpm) else None for rpm in first_loss_range],
        "meaning": MEANING,
    }
