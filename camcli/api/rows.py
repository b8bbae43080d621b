"""Columns and rows that tables of several commands share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from camcli.analysis.orbits.kinds import Kind
from camcli.errors import Status
from camcli.output.tables import Block
from camcli.quantities import (
    BRANCH,
    CORNER,
    EXPONENT,
    EXPONENT_ERROR,
    HOLDS_FOR,
    LABEL,
    LOADS,
    RPM,
    SEAT,
    STATUS,
    THETA,
    TURN,
    U_MINUS,
    VARIED,
    WATCHED,
    Head,
    Q,
    Quantity,
    V,
)
from camcli.words.loads import load_row, seat_row

if TYPE_CHECKING:
    from camcli.analysis.orbits.study import Bifurcation
    from camcli.analysis.sweep import Speed, Sweep
    from camcli.scene import Scene

WAYS = {
    "carried both ways": (
        Quantity("direction", "", "direction", "how it was carried", "up, down"),
    ),
    "with sweep.also": (Quantity("start", "", "start", "which start", "0 is run.start"),),
}
WITH_LASH = "with cam.lash"
IMPACTS = Head("impacts", "the recorded impacts", (VARIED, TURN, THETA, Q, U_MINUS), WAYS)
STROBE = Head(
    "strobe",
    "the state at the start of each recorded turn",
    (
        VARIED, TURN, Q, V,
        Quantity("impacts", "", "impacts", "impacts in the turn"),
        Quantity("chatter", "", "chatter", "whether a complete chatter ended in it", "0 or 1"),
    ),
    WAYS,
)  # fmt: skip
SPEEDS = Head(
    "speeds",
    "a speed, or another value, each; loads are empty where the status is fault",
    (
        VARIED, LABEL, Quantity("impacts", "", "impacts", "recorded impacts"), EXPONENT, STATUS,
        *LOADS.values(), HOLDS_FOR, WATCHED, EXPONENT_ERROR,
    ),
    {WITH_LASH: tuple(SEAT.values()), **WAYS},
)  # fmt: skip
SIDES = tuple(
    Quantity(f"{name}_{side}", "", name, f"{words} on the {side} of the event")
    for side in ("left", "right")
    for name, words in (("trace", "trace of the monodromy matrix"), ("det", "its determinant"))
)
KIND = Quantity("kind", "", "kind", "kind of the event", "fold, corner-impact, ...")
BIFURCATIONS = Head(
    "bifurcations",
    "the events of all branches",
    (
        BRANCH, LABEL, KIND, RPM, Quantity("rpm_error", "rpm", "error", "how far off it may be"),
        CORNER, *SIDES,
        Quantity("classification", "", "classification", "what a border collision leads to"),
    ),
)  # fmt: skip
CORNERS = BIFURCATIONS._replace(
    name="corners", words="corner impacts of the solved branches (explain)"
)


def blocks(sweep: Sweep, sections: Sequence[str]) -> Iterator[list[Block | None]]:
    """The rows of the tables of these sections, a block of columns of each for each speed.

    sections: of `impacts` and `strobe`; None stands for a section in which a speed has no rows. The
    value of the speed comes first; direction or start, where a sweep has several, last.
    """
    for (value, found), way in zip(sweep.sections(sections), sweep.ways, strict=True):
        yield [(value, *columns, *way) if len(columns[0]) else None for columns in found]


def speed_row(speed: Speed, seat: bool = False) -> tuple:
    """A row of speeds.csv, in the order of SPEEDS, with the columns of a seat if there is one."""
    named = speed.label, speed.impact_count, speed.exponent, Status(speed.status).text
    more = seat_row(speed.loads) if seat else ()
    ends = speed.holds_for, speed.watched, speed.exponent_error
    return speed.value, *named, *load_row(speed.loads), *ends, *more


def seat_names(seat: bool) -> tuple[str, ...]:
    """The columns that tables of speeds have in addition where the follower has a seat."""
    return tuple(SEAT) if seat else ()


def has_seat(scene: Scene, keys: Iterable[str] = ()) -> bool:
    """Whether the follower of a scene has a seat, or of one in which these numbers vary."""
    return getattr(scene.cam, "lash", None) is not None or "cam.lash" in keys


def multiplier_columns(pair: tuple[complex, complex]) -> list[float]:
    """The entries of the columns MULTIPLIERS: real and imaginary part of each, 0 never as -0."""
    return [part for z in pair for part in (z.real + 0.0, z.imag + 0.0)]


def bifurcation_row(b: Bifurcation, parameter: str) -> list:
    """A row of bifurcations.csv, with value and error of another parameter at the end.

    Trace and determinant stand there for the left and for the right side of the event. Both sides
    are known of a corner impact that was studied, and are the same at a smooth event. Else the
    right side is empty: behind a graze, a corner impact that was not studied, or a change of a
    resting orbit there is another orbit.
    """
    left: list[float | None] = [b.orbit.trace, b.orbit.det]
    right = left
    if b.left is not None and b.right is not None:
        left = [b.left.trace, b.left.det]
        right = [b.right.trace, b.right.det]
    elif b.kind in (Kind.GRAZING, Kind.CORNER_IMPACT) or b.orbit.resting:
        right = [None, None]
    rpm_error = b.error if parameter == "rpm" else 0.0
    row = [b.branch, b.label, b.kind, b.orbit.rpm, rpm_error, b.corner]
    row += [*left, *right, b.classification]
    if parameter != "rpm":
        row += [b.value, b.error]
    return row
