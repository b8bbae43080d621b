"""What `cam bench` says of rows that are not as they should be."""

from collections.abc import Sequence

from camcli.analysis.bench.precision import Measured
from camcli.analysis.bench.stability import RowOutcome
from camcli.analysis.bench.validation import MISPRINT, ValidationRow
from camcli.errors import plural

NO_HEYOKA = "heyoka is not installed, its points are left out: pip install 'camcli[bench]'"


def precision_notes(bad: Sequence[Measured]) -> list[str]:
    """Our own points that failed, or miss their bounds."""
    return [
        f"{row.case}, {row.setting}: {row.status}: error {row.error:.2g} turns, "
        f"{row.of_bound:.3g} times its bound at most, {plural(row.missed, 'impact')} missed"
        for row in bad
    ]


def stability_notes(bad: Sequence[RowOutcome]) -> list[str]:
    """Extreme cases that came out otherwise."""
    return [f"row {row.case}: expected {row.expected}, but: {row.observed}" for row in bad]


def validation_notes(bad: Sequence[ValidationRow]) -> list[str]:
    """Sentences on computed numbers that differ from the published ones."""
    return [
        f"{row.problem}, {row.quantity}: published {row.published}, but ours is {row.ours:.17g}, "
        f"{abs(row.difference):.3g} off where {row.bound:.3g} is allowed"
        for row in bad
    ]


def validation_title(rows: Sequence[ValidationRow], failed: int) -> str:
    """The title of the published problems."""
    problems = len({row.problem for row in rows})
    wrong = sum(row.status == MISPRINT for row in rows)
    came_out = f"{failed} not reproduced" if failed else "all reproduced"
    if wrong:
        came_out += f", {wrong} less exact than printed"
    numbers = plural(len(rows), "published number")
    return f"{numbers} of {plural(problems, 'problem')}, {came_out}"


def in_seconds(seconds: float) -> str:
    """A time to two digits, in the unit that suits it."""
    if seconds >= 1.0:
        unit, size = "s", 1.0
    elif seconds >= 1e-3:
        unit, size = "ms", 1e-3
    else:
        unit, size = "µs", 1e-6
    rounded = float(f"{seconds / size:.2g}")
    return f"{rounded:g} {unit}"


def cases_title(cases: int, failed: int) -> str:
    """The title of the extreme cases."""
    came_out = f"{failed} not as expected" if failed else "all as expected"
    return f"{plural(cases, 'extreme case')}, {came_out}"
