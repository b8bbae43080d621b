"""Work and precision of ours and of general integrators: `cam bench precision`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import nan
from statistics import median
from time import perf_counter

from camcli.analysis.bench.cases import Case, case
from camcli.analysis.bench.compare import compare
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.methods import CORE, HEYOKA, Point, points
from camcli.analysis.bench.peers import taylor
from camcli.analysis.bench.peers.world import Trace

OK, OVER, MISSED, INVENTED = "ok", "over-bound", "missed", "invented"
GIVEN_UP, ABSENT, FAILED = "given-up", "not-installed", "failed"
ALLOWED, QUICK_ALLOWED = 1.0, 0.25  # s for one run of a peer
SHORT = 5e-3  # s: shorter calls are timed BATCH times more often
BATCH = 7
LONG = 0.2  # s: longer calls are repeated once


@dataclass(frozen=True)
class Measured:
    """One point of the diagram: seconds, errors in turns, counts."""

    case: str
    method: str
    setting: str
    seconds: float
    error: float
    impacts: int
    evaluations: int
    missed: int
    extra: int
    first_call_s: float
    bound: float  # promised where the largest error is
    of_bound: float  # largest error over its own bound
    status: str

    @property
    def ours(self) -> bool:
        """Whether it is of this package."""
        return self.method == CORE


def plan(
    cases: Sequence[str], methods: Sequence[str], quick: bool, bench: Bench
) -> list[tuple[Case, Point]]:
    """Every point of every case."""
    wanted = points(tuple(methods), quick, bench)
    return [(case(name), point) for name in cases for point in wanted]


def precision(
    work: Sequence[tuple[Case, Point]],
    repeats: int,
    quick: bool,
    on_point: Callable[[], None] = lambda: None,
) -> Iterator[Measured]:
    """Measure every point; `on_point` is called after each."""
    for some, point in work:
        yield _measured(some, point, repeats, QUICK_ALLOWED if quick else ALLOWED)
        on_point()


def _measured(some: Case, point: Point, repeats: int, allowed: float) -> Measured:
    if point.method == HEYOKA and not taylor.available():
        return _empty(some, point, ABSENT)
    began = perf_counter()
    compiling = 60.0 if point.method == HEYOKA else 0.0  # a first call may have to compile
    try:
        trace = point.call(some, allowed + compiling)
    except (ArithmeticError, ValueError):  # solve_ivp: step too small, bracket without a root
        return _empty(some, point, FAILED)
    first = perf_counter() - began
    seconds = first
    if not trace.given_up:
        seconds = _repeated(some, point, repeats, first)
    return _point(some, point, trace, seconds, first)


def _repeated(some: Case, point: Point, repeats: int, first: float) -> float:
    """Median time of further calls: more of them where one is short, one where it is long."""
    wanted = repeats * BATCH if first < SHORT else repeats
    times: list[float] = []
    while len(times) < (wanted if first < LONG else 1):
        began = perf_counter()
        point.call(some, 60.0)
        times.append(perf_counter() - began)
    return median(times)


def _point(some: Case, point: Point, trace: Trace, seconds: float, first: float) -> Measured:
    found = compare(some, trace, point.tolerance)
    ours = point.method == CORE
    status = OK
    if trace.given_up:
        status = GIVEN_UP
    elif found.missed:
        status = MISSED
    elif found.extra:
        status = INVENTED
    if ours and not found.excess <= 1.0:
        status = OVER
    return Measured(
        some.name,
        point.method,
        point.setting,
        seconds,
        found.error,
        len(trace.hits),
        trace.evaluations,
        found.missed,
        found.extra,
        first,
        found.bound if ours else nan,
        found.excess if ours else nan,
        status,
    )


def _empty(some: Case, point: Point, status: str) -> Measured:
    return Measured(
        some.name, point.method, point.setting, nan, nan, 0, 0, 0, 0, nan, nan, nan, status
    )


def failures(found: Sequence[Measured]) -> list[Measured]:
    """Points of ours that break a promise."""
    return [m for m in found if m.ours and m.status != OK]
