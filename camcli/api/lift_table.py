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
    weakest: it has other noise (see `loss_range`).
    """
    from camcli.analysis.contact_loss.detachment import loss_range
    from camcli.system import System

    if not is_measured(system):
        return None
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
    between = lost_between(system)
    if between is None:
        return detachment
    first = detachment.first and _between(detachment.first, between)
    losses = []
    for loss in detachment.losses:
        leading = detachment.first is not None and loss.region.name == detachment.first.region
        opens = _between(loss.opens, between if leading else UNKNOWN)
        fills = _between(loss.fills, UNKNOWN) if loss.fills.finite else loss.fills
        losses.append(replace(loss, opens=opens, fills=fills))
    return replace(detachment, first=first, losses=tuple(losses))


def with_ranges(loss: ContactLoss, system: System) -> ContactLoss:
    """Everything about the loss of contact, with such brackets; NaN where only chatter tells.

    A chatter has more to do with the table than one phase, and how much more is not known.
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
        ends=tuple(_between(speed, UNKNOWN) for speed in loss.ends),
        completion=tuple(_between(speed, UNKNOWN) for speed in loss.completion),
        holds=tuple(holds),
    )


def _between(speed: CriticalSpeed, ends: tuple[float, float]) -> CriticalSpeed:
    """The critical speed with another bracket; ends: its ends in rpm."""
    return replace(speed, low=ends[0], high=ends[1])


def table_record(cam: TableCam, system: System) -> dict[str, Any]:
    """The fit of the lift table, and the speeds between which contact is first lost."""
    accuracy = cam.accuracy
    speeds = lost_between(system) or ()
    return {
        **asdict(accuracy),
        "bound": accuracy.bound,
        "units": "m, deg, m/rad2",
        "first_detachment_rpm": [rpm if isfinite(rpm) else None for rpm in speeds],
        "meaning": MEANING,
    }
