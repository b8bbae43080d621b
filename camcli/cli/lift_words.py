"""What a measured lift table is worth, in words, and for run.json."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite, sqrt
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camcli.cams.lift_fit import Accuracy
    from camcli.cli.setup import Setup

MEANING = (
    "bound: 4 standard errors of rounding plus what smoothing may have changed; an estimate, "
    "since no table says what the cam does between its rows"
)


def table_record(setup: Setup) -> dict[str, Any] | None:
    """The fit of a lift table for run.json, None for other kinds of cam."""
    if setup.scene.cam.kind != "table":
        return None
    from camcli.analysis.contact_loss.detachment import first_loss_range

    accuracy: Accuracy = setup.scene.cam.accuracy
    speeds = first_loss_range(setup.system, setup.scene.cam.errors.bounds)
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
        f"{accuracy.quantum:.3g} m; the cam is within "
        f"{accuracy.rms:.2g} m rms, {accuracy.largest:.2g} m at most (line {accuracy.line}), "
        f"smoothed over {accuracy.length_deg:.2g} deg"
    )


def cautions(accuracy: Accuracy) -> list[str]:
    """What to be warned of."""
    words = []
    rounding = accuracy.quantum / sqrt(12.0)
    if accuracy.noise > 1.5 * rounding:
        words.append(
            f"warning: the table scatters by {accuracy.noise:.2g} m, "
            f"{accuracy.noise / rounding:.2g} times the rounding of its digits"
        )
    if accuracy.largest > 6.0 * accuracy.noise:
        words.append(
            f"warning: line {accuracy.line} of the table is {accuracy.largest:.2g} m off the cam, "
            f"{accuracy.largest / accuracy.noise:.3g} times the noise of the rows"
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
        f"largest ({record['standard']:.2g} standard error of rounding, {record['bending']:.2g} "
        f"by smoothing; every digit at its worst: {record['worst']:.2g}); "
    )
    if low is None:
        return text + "contact is never lost"
    if high is None:
        return text + f"first detachment from {low:.6g} rpm on, or never"
    return text + f"first detachment between {low:.6g} and {high:.6g} rpm"
