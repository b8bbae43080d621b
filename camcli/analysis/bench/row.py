"""A row of the table of extreme cases: what is expected, and a check that says what was seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from time import perf_counter

from camcli.analysis.bench.clock import NOT_REACHED
from camcli.analysis.bench.machine import Bench

OK, FAILED = "ok", "failed"


class MismatchError(Exception):
    """What was seen is not what is expected."""


@dataclass(frozen=True)
class Row:
    """One extreme case; `check` returns what was observed or raises MismatchError."""

    case: str
    expected: str
    check: Callable[[Bench], str]


@dataclass(frozen=True)
class Outcome:
    """A row that has been run."""

    case: str
    expected: str
    observed: str
    status: str
    seconds: float


def need(holds: bool, seen: str) -> None:
    """Raise MismatchError with what was seen unless it is as expected."""
    if not holds:
        raise MismatchError(seen)


def measure(row: Row, bench: Bench) -> Outcome:
    """Run a row; whatever it raises is an outcome too."""
    began = perf_counter()
    try:
        observed, status = row.check(bench), OK
    except MismatchError as mismatch:
        observed, status = str(mismatch), FAILED
    except Exception as error:
        observed, status = f"{type(error).__name__}: {error}", FAILED
    return Outcome(row.case, row.expected, observed, status, perf_counter() - began)


def left_out(row: Row) -> Outcome:
    """The outcome of a row that the clock left no time for."""
    return Outcome(row.case, row.expected, "", NOT_REACHED, nan)
