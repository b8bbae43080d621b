"""CSV text of `cam bench`."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isnan

from camcli.analysis.bench.flights import Flights
from camcli.analysis.bench.precision import Measured
from camcli.analysis.bench.row import Outcome
from camcli.analysis.bench.scenes import Scene, ratios
from camcli.output.tables import header, mixed_rows

STABILITY = ("case", "expected", "observed", "status", "seconds")
PRECISION = (
    "case", "method", "setting", "seconds", "error", "impacts", "evaluations", "missed", "extra",
    "first_call_s", "bound", "of_bound", "status",
)  # fmt: skip
SCENES = ("scene", "status", "seconds", "ratio", "compute_s", "modules", "heavy")
FLIGHTS = ("method", "asked", "flights", "compared", "missed", "invented", "seconds")


def stability_csv(outcomes: Iterable[Outcome]) -> Iterator[str]:
    """stability.csv: a row per extreme case."""
    yield header(STABILITY)
    for o in outcomes:
        words = [_cell(text) for text in (o.case, o.expected, o.observed)]
        yield from mixed_rows([[*words, o.status, _number(o.seconds)]])


def precision_csv(found: Iterable[Measured]) -> Iterator[str]:
    """precision.csv: a row per point; what could not be measured is empty."""
    yield header(PRECISION)
    for point in found:
        yield from mixed_rows([[_number(getattr(point, name)) for name in PRECISION]])


def scenes_csv(found: Sequence[Scene]) -> Iterator[str]:
    """scenes.csv: a row per command."""
    yield header(SCENES)
    for s, ratio in zip(found, ratios(found), strict=True):
        spent = "" if s.compute_s is None else s.compute_s
        times = [_number(s.seconds), _number(ratio), spent]
        yield from mixed_rows([[_cell(s.name), s.status, *times, s.modules, " ".join(s.heavy)]])


def flights_csv(found: Iterable[Flights]) -> Iterator[str]:
    """flights.csv: a row per method."""
    yield header(FLIGHTS)
    yield from mixed_rows([getattr(f, name) for name in FLIGHTS] for f in found)


def _number(value):
    return "" if isinstance(value, float) and isnan(value) else value


def _cell(text: str) -> str:
    """Text that needs no quotes."""
    return " ".join(text.replace(",", ";").replace('"', "'").split())
