"""The table of extreme cases, run: `cam bench stability`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import Outcome, Row, measure
from camcli.analysis.bench.rows import damping, restitution, scaling, speeds, starts


def _number(row: Row) -> int:
    return int(row.case.split(":")[0])


ROWS: tuple[Row, ...] = tuple(
    sorted(
        [*restitution.ROWS, *damping.ROWS, *scaling.ROWS, *speeds.ROWS, *starts.ROWS], key=_number
    )
)


def stability(
    bench: Bench, rows: Sequence[Row] = ROWS, on_row: Callable[[], None] = lambda: None
) -> Iterator[Outcome]:
    """Run the rows in order; `on_row` is called after each."""
    for row in rows:
        yield measure(row, bench)
        on_row()
