"""The table of extreme cases, run: `cam bench stability`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.kept import codec_of, one_by_one
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import Outcome, Row, left_out, measure
from camcli.analysis.bench.rows import damping, restitution, scaling, speeds, starts
from camcli.parallel import Work


def _number(row: Row) -> int:
    return int(row.case.split(":")[0])


ROWS: tuple[Row, ...] = tuple(
    sorted(
        [*restitution.ROWS, *damping.ROWS, *scaling.ROWS, *speeds.ROWS, *starts.ROWS], key=_number
    )
)


def numbers() -> list[int]:
    """The rows by their numbers, in order."""
    return [_number(row) for row in ROWS]


def measure_row(number: int, bench: Bench, clock: Clock) -> Outcome:
    """Run the row of a number, unless the clock is over."""
    row = next(row for row in ROWS if _number(row) == number)
    return left_out(row) if clock.over else measure(row, bench)


def stability(
    bench: Bench,
    wanted: Sequence[int],
    clock: Clock | None = None,
    on_row: Callable[[], None] = lambda: None,
    keeping: Work | None = None,
) -> Iterator[Outcome]:
    """Run the rows of these numbers in order; `on_row` is called after each."""
    measure = partial(measure_row, bench=bench, clock=clock or Clock())
    return one_by_one(measure, wanted, CODEC, keeping, on_row)


CODEC = codec_of(Outcome, lambda outcome: outcome.status != NOT_REACHED)
