"""Work and precision of ours and of general integrators: `cam bench precision`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from math import nan
from statistics import median
from time import perf_counter

from camcli.analysis.bench.cases import Case, case
from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.compare import compare
from camcli.analysis.bench.kept import codec_of, one_by_one
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.methods import COMPILING, CORE, HEYOKA, Point, points, ready
from camcli.analysis.bench.peers import taylor
from camcli.analysis.bench.peers.world import Trace
from camcli.parallel import Work

OK, OVER, MISSED, INVENTED = "ok", "over-bound", "missed", "invented"
GIVEN_UP, ABSENT, FAILED = "given-up", "not-installed", "failed"
ALLOWED, QUICK_ALLOWED = 1.0, 0.25  # s at most for one run of a peer
SHORT = 5e-3  # s: shorter calls are timed BATCH times more often
BATCH = 7
LONG = 0.2  # s: longer calls are repeated once


@dataclass(frozen=True)
class Task:
    """One point to measure, in plain values; `left` counts the points from this one on."""

    case: str
    point: Point
    repeats: int
    most: float  # s allowed, however much time there is
    left: int


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


def plan(cases: Sequence[str], methods: Sequence[str], quick: bool, repeats: int) -> list[Task]:
    """Every point of every case."""
    wanted = [(name, point) for name in cases for point in points(tuple(methods), quick)]
    most = QUICK_ALLOWED if quick else ALLOWED
    left = range(len(wanted), 0, -1)
    return [Task(name, p, repeats, most, n) for (name, p), n in zip(wanted, left, strict=True)]


def precision(
    work: Sequence[Task],
    bench: Bench,
    clock: Clock | None = None,
    on_point: Callable[[], None] = lambda: None,
    keeping: Work | None = None,
) -> Iterator[Measured]:
    """Measure every point in order; `on_point` is called after each."""
    measure = partial(measure_point, bench=bench, clock=clock or Clock())
    return one_by_one(measure, work, CODEC, keeping, on_point)


def measure_point(task: Task, bench: Bench, clock: Clock) -> Measured:
    """Measure one point with its share of the time that is left, `task.most` at most."""
    some, point = case(task.case), task.point
    if clock.over:
        return _empty(task, NOT_REACHED)
    if point.method == HEYOKA and not taylor.available():
        return _empty(task, ABSENT)
    allowed = min(task.most, clock.share(task.left))
    began = perf_counter()
    try:
        call = ready(some, point, bench)
        if point.method == HEYOKA:
            call(min(COMPILING, clock.left()))  # its first call may have to compile
        prepared = perf_counter()
        trace = call(allowed)
    except (ArithmeticError, ValueError):  # solve_ivp: step too small, bracket without a root
        return _empty(task, FAILED)
    ended = perf_counter()
    seconds = ended - prepared
    if not trace.given_up:
        seconds = _repeated(call, task.repeats, seconds, allowed - seconds)
    return _point(some, point, trace, seconds, ended - began)


def _repeated(call: Callable, repeats: int, first: float, left: float) -> float:
    """Median time of further calls: more of them where one is short, one where it is long.

    `left` are the seconds that they may take; where they do not suffice for one, it is `first`.
    """
    wanted = repeats * BATCH if first < SHORT else repeats
    times: list[float] = []
    while len(times) < (wanted if first < LONG else 1) and sum(times) + first <= left:
        began = perf_counter()
        call(60.0)
        times.append(perf_counter() - began)
    return median(times or [first])


def _point(some: Case, point: Point, trace: Trace, seconds: float, first: float) -> Measured:
    found = compare(some, trace, point.chatter)
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


def _empty(task: Task, status: str) -> Measured:
    """A point without a measurement."""
    names = (task.case, task.point.method, task.point.setting)
    return Measured(*names, nan, nan, 0, 0, 0, 0, nan, nan, nan, status)


CODEC = codec_of(Measured, lambda m: m.status != NOT_REACHED)


def failures(found: Sequence[Measured]) -> list[Measured]:
    """Points of ours that break a promise, or that could not be held to it."""
    return [m for m in found if m.ours and m.status != OK]
