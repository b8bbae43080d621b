"""What a measured lift table is worth, as values and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import isfinite, sqrt
from typing import TYPE_CHECKING, Any

from camcli.errors import shown
from camcli.system import decimals

if TYPE_CHECKING:
    from camcli.cams.lift_fit import Accuracy
    from camcli.cams.lift_table import TableCam
    from camcli.scene import Scene
    from camcli.system import System

UM = 1e6  # per m
LONGEST_NAME = 500  # characters of a path in a note
MEANING = (
    "bound: 3 standard errors, and where smoothing changes more than they do what it may have "
    "changed; an estimate, since no table says what the cam does between its rows"
)


def accel_errors(cam: Any) -> Sequence[float]:
    """Bounds on the error of c_thetatheta, m/rad2, in equal parts of the turn; 0 of a law."""
    return cam.errors.bounds if cam.kind == "table" else (0.0,)


def table_record(cam: TableCam, system: System) -> dict[str, Any]:
    """The fit of the lift table, and the speeds between which contact is first lost."""
    from camcli.analysis.contact_loss.detachment import loss_range
    from camcli.system import System

    accuracy, errors = cam.accuracy, cam.errors
    speeds = loss_range(system, errors.bounds, System.build(system.follower, cam.rougher))
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
        f"{file}: {accuracy.rows} rows, lift {1e3 * accuracy.lift:.5g} mm, last digit "
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
        words.append(
            f"warning: c_thetatheta seems to jump near {accuracy.jump_deg:.4g} deg; the smooth "
            "cam only approaches a jump"
        )
    return words


def bound_line(record: dict[str, Any]) -> str:
    """One line about what the table says of c_thetatheta and the first detachment."""
    low, high = record["first_detachment_rpm"]
    share = 100.0 * record["bound"] / record["accel"]
    text = (
        f"c_thetatheta of the table: within {record['bound']:.2g} m/rad2, {share:.2g} % of its "
        f"largest ({record['standard']:.2g} standard error of its noise, {record['bending']:.2g} "
        f"by smoothing; every digit at its worst: {record['worst']:.2g}); "
    )
    if low is None:
        return text + "contact is never lost"
    if high is None:
        return text + f"first detachment from {low:.4g} rpm on, or never"
    form = f".{decimals(high - low)}f"
    return text + f"first detachment between {low:{form}} and {high:{form}} rpm"


def table_notes(scene: Scene) -> list[str]:
    """What a user should know of a measured cam before anything is computed."""
    if scene.cam.kind != "table":
        return []
    file, notes = shown(scene.cam.file, LONGEST_NAME), []
    if scene.cam.outside:
        where = shown(scene.cam.outside, LONGEST_NAME)
        notes.append(f"note: cam.file: reads {where}, outside the scene's folder")
    return [*notes, fit_line(scene.cam.accuracy, file), *cautions(scene.cam.accuracy)]
