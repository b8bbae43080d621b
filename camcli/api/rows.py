"""Columns and rows that tables of several commands share."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from camcli.analysis.loads import Loads
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.sweep import Speed, Sweep, status_name
from camcli.output.tables import Block

if TYPE_CHECKING:
    from camcli.analysis.orbits.study import Bifurcation

# columns after the one of what is varied
IMPACTS = ("period", "theta_deg", "q_m", "u_minus_m_per_s")
STROBE = ("period", "q_m", "v_m_per_s", "impacts", "chatter")
SPEEDS = (
    "label",
    "impacts",
    "lyapunov_per_period",
    "status",
    *Loads._fields,
    "holds_for",
    "watched_turns",
)
MULTIPLIERS = ("multiplier_1_re", "multiplier_1_im", "multiplier_2_re", "multiplier_2_im")
BIFURCATIONS = (
    "branch", "label", "kind", "rpm", "rpm_error", "corner", "trace_left", "det_left",
    "trace_right", "det_right", "classification",
)  # fmt: skip


def blocks(found: Sweep, section: str) -> Iterator[Block]:
    """The rows of the table of a section."""
    for speed, way in zip(found.speeds, found.ways, strict=True):
        columns = getattr(speed, section)
        if len(columns[0]):
            yield speed.value, *columns, *way


def speed_row(speed: Speed) -> tuple:
    """A row of speeds.csv."""
    named = speed.label, speed.impact_count, speed.exponent, status_name(speed.status)
    return speed.value, *named, *speed.loads, speed.holds_for, speed.watched


def multiplier_columns(pair: tuple[complex, complex]) -> list[float]:
    """The entries of the columns MULTIPLIERS."""
    return [part for z in pair for part in (z.real + 0.0, z.imag + 0.0)]


def bifurcation_row(b: Bifurcation, parameter: str) -> list:
    """A row of bifurcations.csv, with value and error of another parameter at the end.

    One-sided traces and determinants; of a smooth event both sides are the same.
    """
    error, more = (b.error, []) if parameter == "rpm" else (0.0, [b.value, b.error])
    own = [b.orbit.trace, b.orbit.det]
    sides: list[float | None] = [*own, *own]
    if b.left is not None and b.right is not None:
        sides = [b.left.trace, b.left.det, b.right.trace, b.right.det]
    elif b.kind in (Kind.GRAZING, Kind.CORNER_IMPACT) or b.orbit.resting:
        sides = [*own, None, None]
    row = [b.branch, b.label, b.kind, b.orbit.rpm, error, b.corner, *sides, b.classification]
    return row + more
