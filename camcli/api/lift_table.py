"""What a measured lift table is worth, as values and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from math import inf, isfinite, nan, sqrt
from typing import TYPE_CHECKING, Any

from camcli.errors import shown
from camcli.quantities import MM, UM
from camcli.system import is_measured, range_words

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.detachment import CriticalSpeed, Detachment
    from camcli.analysis.contact_loss.study import ContactLoss
    from camcli.cams.lift_fit import Accuracy
    from camcli.cams.lift_table import TableCam
    from camcli.scene import Scene
    from camcli.system import System

UNKNOWN = (nan, nan)  # a bracket
LONGEST_NAME = 500  # characters of a path in a note
MEANING = (
    "bound: 3 standard errors, and where smoothing changes more than they do what it may have "
    "changed; an estimate, since no table says what the cam does between its rows"
)


def accel_errors(cam: Any) -> Sequence[float]:
    """Bounds on the error of c_thetatheta, m/rad2, in equal parts of the turn; 0 of a law."""
    return cam.errors.bounds if cam.kind == "table" else (0.0,)


def lost_between(system: System) -> tuple[float, float] | None:
    """The rpm between which the error of a measured cam leaves the first loss; None of a law."""
    from camcli.analysis.contact_loss.detachment import loss_range
    from camcli.system import System

    if not is_measured(system):
        return None
    cam: Any = system.shape
    shape, table = cam.rougher
    return loss_range(system, cam.errors.bounds, System(system.follower, table, shape))


def widened(found: Detachment, system: System) -> Detachment:
    """The critical speeds with brackets as wide as the error of a measured cam leaves them.

    Its cam is smooth, so one region: it opens at the first detachment, and is never filled, since
    c_thetatheta is positive somewhere.
    """
    between = lost_between(system)
    if between is None:
        return found
    first = found.first and _between(found.first, between)
    losses = []
    for loss in found.losses:
        leading = found.first is not None and loss.region.name == found.first.region
        opens = _between(loss.opens, between if leading else UNKNOWN)
        fills = _between(loss.fills, UNKNOWN) if loss.fills.finite else loss.fills
        losses.append(replace(loss, opens=opens, fills=fills))
    return replace(found, first=first, losses=tuple(losses))


def with_ranges(found: ContactLoss, system: System) -> ContactLoss:
    """Everything about the loss of contact, with such brackets; NaN where only chatter tells.

    A chatter has more to do with the table than one phase, and how much more is not known.
    """
    if lost_between(system) is None:
        return found
    from camcli.analysis.contact_loss.hold import replaced

    holds = []
    for hold in found.holds:
        if hold.detaches_rpm is not None:
            with_spring = replaced(system, hold.stiffness or 0.0, hold.preload or 0.0)
            low, high = lost_between(with_spring) or UNKNOWN
            hold = replace(hold, low_rpm=low, high_rpm=high)
        holds.append(hold)
    return replace(
        found,
        detachment=widened(found.detachment, system),
        ends=tuple(_between(speed, UNKNOWN) for speed in found.ends),
        completion=tuple(_between(speed, UNKNOWN) for speed in found.completion),
        holds=tuple(holds),
    )


def _between(speed: CriticalSpeed, ends: tuple[float, float]) -> CriticalSpeed:
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


def fit_line(accuracy: Accuracy, file: str) -> str:
    """One line about the fit."""
    return (
        f"{file}: {accuracy.rows} rows, lift {MM * accuracy.lift:.5g} mm, last digit "
        f"{UM * accuracy.quantum:.3g} um; the cam is within {UM * accuracy.rms:.3g} um rms, "
        f"{UM * accuracy.largest:.3g} um at most (line {accuracy.line}), "
        f"smoothed over {accuracy.length_deg:.2g} deg"
    )


def cautions(accuracy: Accuracy) -> list[str]:
    """What to be warned of."""
    words = []
    rounding = accuracy.quantum / sqrt(12.0)
    if accuracy.noise > 1.5 * rounding:
        words.append(
            f"warning: the table scatters by {UM * accuracy.noise:.3g} um, "
            f"{accuracy.noise / rounding:.2g} times the rounding of its digits"
        )
    if accuracy.largest > 6.0 * accuracy.noise:
        words.append(
            f"warning: line {accuracy.line} of the table is {UM * accuracy.largest:.3g} um off the "
            f"cam, {accuracy.largest / accuracy.noise:.3g} times the noise of the rows"
        )
    if accuracy.jump_deg is not None:
        from camcli.cams.lift_jump import LEAST

        unit = "m/rad" if accuracy.jump_of == "c_theta" else "m/rad2"
        words.append(
            f"warning: {accuracy.jump_of} seems to jump near {accuracy.jump_deg:.4g} deg, by "
            f"{accuracy.jump:.2g} +- {accuracy.jump_error:.1g} {unit}; a change over {LEAST:g} deg "
            f"or more fits the rows worse, by {accuracy.jump_sure:.2g} standard errors; the smooth "
            "cam only approaches a jump"
        )
    return words


def bound_line(record: Mapping[str, Any]) -> str:
    """One line about what the table says of c_thetatheta and the first detachment."""
    low, high = (inf if rpm is None else rpm for rpm in record["first_detachment_rpm"])
    share = 100.0 * record["bound"] / record["accel"]
    text = (
        f"c_thetatheta of the table: within {record['bound']:.2g} m/rad2, {share:.2g} % of its "
        f"largest ({record['standard']:.2g} standard error of its noise, {record['bending']:.2g} "
        f"by smoothing; every digit at its worst: {record['worst']:.2g}); "
    )
    if low == inf:
        return text + "contact is never lost"
    return text + f"first detachment at {range_words(low, high)}"


def table_notes(scene: Scene) -> list[str]:
    """What a user should know of a measured cam before anything is computed."""
    if scene.cam.kind != "table":
        return []
    file, notes = shown(scene.cam.file, LONGEST_NAME), []
    if scene.cam.outside:
        where = shown(scene.cam.outside, LONGEST_NAME)
        notes.append(f"note: cam.file: reads {where}, outside the scene's folder")
    return [*notes, fit_line(scene.cam.accuracy, file), *cautions(scene.cam.accuracy)]
