"""Columns and rows that tables of several commands share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from camcli.analysis.orbits.kinds import Kind
from camcli.errors import Status
from camcli.output.npz import Form
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
    from camcli.analysis.speeds import Speed
    from camcli.analysis.sweep import Sweep
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
KINDS = {  # dtypes of the columns of IMPACTS and of STROBE, behind the varied value
    "impacts": ("<i8", "<f8", "<f8", "<f8"),
    "strobe": ("<i8", "<f8", "<f8", "<i8", "<i8"),
}
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


def blocks(sweep: Sweep, names: Sequence[str]) -> Iterator[list[Block | None]]:
    """The rows of some tables of a sweep: for each speed a block of each of these tables.

    names: `impacts`, `strobe` or both. None stands for a table in which a speed has no rows. In a
    block the value of the speed comes first; the direction or the start, where a sweep has several,
    comes last.
    """
    for (value, sections), way in zip(sweep.sections(names), sweep.ways, strict=True):
        blocks_of_speed: list[Block | None] = []
        for columns in sections:
            has_rows = len(columns[0]) > 0
            blocks_of_speed.append((value, *columns, *way) if has_rows else None)
        yield blocks_of_speed


def form(sweep: Sweep, name: str) -> Form:
    """How many rows the table of a section of a sweep will have, and the dtypes of its columns.

    name: of the section, impacts or strobe. A table without rows has numbers in all its columns.
    """
    counts = sweep.row_counts[name]
    rows = sum(counts)
    kinds = ["<f8", *KINDS[name]]
    listed = {way for way, count in zip(sweep.ways, counts, strict=True) if count}
    for of_way in zip(*listed, strict=True):
        texts = [len(value) for value in of_way if isinstance(value, str)]
        kinds.append(f"<U{max(texts)}" if texts else "<i8")
    if rows == 0:
        kinds = ["<f8"] * (len(kinds) + len(sweep.way_names))
    return Form(rows, kinds)


def speed_row(speed: Speed, seat: bool = False) -> tuple:
    """A row of speeds.csv, in the order of SPEEDS, with the columns of a seat if there is one."""
    return (
        speed.value,
        speed.label,
        speed.impact_count,
        speed.exponent,
        Status(speed.status).text,
        *load_row(speed.loads),
        speed.holds_for,
        speed.watched,
        speed.exponent_error,
        *(seat_row(speed.loads) if seat else ()),
    )


def seat_names(seat: bool) -> tuple[str, ...]:
    """The columns that tables of speeds have in addition where the follower has a seat."""
    return tuple(SEAT) if seat else ()


def has_seat(scene: Scene, keys: Iterable[str] = ()) -> bool:
    """Whether the follower of a scene has a seat, or of one in which these numbers vary."""
    return getattr(scene.cam, "lash", None) is not None or "cam.lash" in keys


def multiplier_columns(pair: tuple[complex, complex]) -> list[float]:
    """The entries of the columns MULTIPLIERS: real and imaginary part of each, 0 never as -0."""
    return [part for z in pair for part in (z.real + 0.0, z.imag + 0.0)]


def bifurcation_row(event: Bifurcation, parameter: str) -> list:
    """A row of bifurcations.csv.

    parameter: what varies along the branch. Where that is not rpm its value and error are appended.

    Trace and determinant stand in the row for the left and for the right side of the event. Both
    sides are known of a corner impact that was studied, and are the same at a smooth event. Else
    the right side is empty: behind a graze, a corner impact that was not studied, or a change of a
    resting orbit there is another orbit.
    """
    left: list[float | None] = [event.orbit.trace, event.orbit.det]
    right = left
    if event.left is not None and event.right is not None:
        left = [event.left.trace, event.left.det]
        right = [event.right.trace, event.right.det]
    elif event.kind in (Kind.GRAZING, Kind.CORNER_IMPACT) or event.orbit.resting:
        right = [None, None]
    rpm_error = event.error if parameter == "rpm" else 0.0
    row = [event.branch, event.label, event.kind, event.orbit.rpm, rpm_error, event.corner]
    row += [*left, *right, event.classification]
    if parameter != "rpm":
        row += [event.value, event.error]
    return row
