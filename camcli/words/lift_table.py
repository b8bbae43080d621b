"""What a measured lift table is worth, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, sqrt
from typing import TYPE_CHECKING, Any

from camcli.errors import plural, shown
from camcli.quantities import MM, UM, Units
from camcli.words.speeds import range_words

if TYPE_CHECKING:
    from camcli.cams.lift_fit import Accuracy
    from camcli.scene import Scene

LONGEST_NAME = 500  # characters of a path in a note
NOISY = 1.5  # times the rounding of the digits: more scatter than that is not from rounding alone
OUTLIER = 6.0  # times the noise: a row so far off is probably a mistake
MEANING = (
    "bound: 3 standard errors, and where smoothing changes more than they do what it may have "
    "changed; an estimate, since no table says what the cam does between its rows"
)


def fit_line(accuracy: Accuracy, file: str) -> str:
    """One line about the fit of a lift table; file: its name."""
    return (
        f"{file}: {plural(accuracy.rows, 'row')}, lift {MM * accuracy.lift:.5g} mm, last digit "
        f"{UM * accuracy.quantum:.3g} um; the cam is within {UM * accuracy.rms:.3g} um rms, "
        f"{UM * accuracy.largest:.3g} um at most (line {accuracy.line}), "
        f"smoothed over {accuracy.length_deg:.2g} deg"
    )


def cautions(accuracy: Accuracy) -> list[str]:
    """Warnings where the table scatters, a row is far off, or the cam seems to jump."""
    warnings = []
    rounding = accuracy.quantum / sqrt(12.0)  # rms of an error up to half a quantum
    if accuracy.noise > NOISY * rounding:
        off = f"by {UM * accuracy.noise:.3g} um"
        times = f"{accuracy.noise / rounding:.3g} times the rounding of its digits"
        if accuracy.bends_between_rows:
            warnings.append(
                f"warning: the rows are {accuracy.spacing_deg:.3g} deg apart, too far for this "
                f"cam: the lift bends between them, and the smooth cam is off {off}, {times}; give "
                "more rows"
            )
        else:
            warnings.append(f"warning: the table scatters {off}, {times}")
    if accuracy.largest > OUTLIER * accuracy.noise:
        warnings.append(
            f"warning: line {accuracy.line} of the table is {UM * accuracy.largest:.3g} um off the "
            f"cam, {accuracy.largest / accuracy.noise:.3g} times the noise of the rows"
        )
    if accuracy.jump_deg is not None:
        from camcli.cams.lift_jump import LEAST

        unit = "m/rad" if accuracy.jump_of == "c_theta" else "m/rad2"
        warnings.append(
            f"warning: {accuracy.jump_of} seems to jump near {accuracy.jump_deg:.4g} deg, by "
            f"{accuracy.jump:.2g} +- {accuracy.jump_error:.1g} {unit}; a change over {LEAST:g} deg "
            f"or more fits the rows worse, by {accuracy.jump_sure:.2g} standard errors; the smooth "
            "cam only approaches a jump"
        )
    return warnings


def bound_line(record: Mapping[str, Any]) -> str:
    """One line about what the table says of the second derivative and the first detachment.

    record: as run.json has it, see `api.lift_table.table_record`.
    """
    low, high = (inf if rpm is None else rpm for rpm in record["first_detachment_rpm"])
    share = 100.0 * record["bound"] / record["accel"]
    text = (
        f"the fit's second derivative is off by an estimated {record['bound']:.2g} m/rad2 at most, "
        f"{share:.2g} % of its largest (standard error of its noise {record['standard']:.2g}, "
        f"smoothing {record['bending']:.2g}; with every digit at its worst {record['worst']:.2g}); "
    )
    if low == inf:
        return text + "contact is never lost"
    return text + f"first detachment at {range_words(low, high)}"


def table_notes(scene: Scene) -> list[str]:
    """What a user should know of a measured cam before anything is computed."""
    if scene.cam.kind != "table":
        return []
    file = shown(scene.cam.file, LONGEST_NAME)
    notes = []
    if scene.cam.outside:
        where = shown(scene.cam.outside, LONGEST_NAME)
        notes.append(f"note: cam.file: reads {where}, outside the scene's folder")
    return [*notes, fit_line(scene.cam.accuracy, file), *cautions(scene.cam.accuracy)]


def smoothed_cam(
    accuracy: Accuracy, units: Units, between: tuple[float, float], first_rpm: float | None
) -> str:
    """What the page of explore says of a measured cam.

    between: the speeds between which contact is first lost; first_rpm: where the fitted cam loses
    it, None where it never does.
    """
    by_the_fit = "" if first_rpm is None else f" ({first_rpm:.4g} by the fit)"
    return (
        f"The cam is a smoothed lift table, right to {accuracy.rms * UM:.2g} µm rms and, by "
        f"estimate, to {units.lengths(accuracy.bound, 2)}/rad² in its second derivative: contact "
        f"is first lost at {range_words(*between)}{by_the_fit}. Motions and bifurcations are those "
        "of the smoothed cam."
    )
