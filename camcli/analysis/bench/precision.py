"""Work and precision of ours and of general integrators: `cam bench precision`.

A case is a motion of whole turns with its reference, solved with many digits. A point is a method
with one setting; it is run on a case, compared with the reference, and timed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, partial
from itertools import pairwise
from math import inf, isnan, nan, pi
from statistics import median
from time import perf_counter
from typing import NamedTuple

from camcli.analysis.bench.lifts import Lift, lift_of
from camcli.analysis.bench.machine import Machines, reference
from camcli.analysis.bench.peers import (
    Heyoka,
    Machine,
    Method,
    RungeKutta4,
    SolveIvp,
    Trace,
    follow,
)
from camcli.analysis.bench.pieces import FAILED, NOT_REACHED, OK
from camcli.analysis.integrate import Orbit, Settings, Start
from camcli.kernel import backend
from camcli.kernel.orbit_loop import CHATTER, IMPACT
from camcli.system import Follower, System, omega_of

CORE, RK4, HEYOKA = "core", "rk4", "heyoka"
OVER, MISSED, INVENTED = "over-bound", "missed", "invented"
GIVEN_UP, ABSENT = "given-up", "not-installed"

# --- cases

OPTIONAL = 1e-3  # turns before an accumulation: impacts there are not asked of anybody
ROUNDING = 2.0**-52
ALLOWANCE = 8  # roundings of ours in one event; how far one goes is `growth`, from the reference


class Mark(NamedTuple):
    """An event of the reference: phase as two doubles (rad), speed (m/s), our bound (turns)."""

    turn: int
    theta: float
    rest: float  # theta - its double
    u: float
    bound: float
    optional: bool

    @property
    def at(self) -> float:
        """Turns since the start, in a double."""
        return self.turn + self.theta / (2.0 * pi)

    def late(self, turn: int, theta: float) -> float:
        """Turns by which another phase comes after this one."""
        return (turn - self.turn) + ((theta - self.theta) - self.rest) / (2.0 * pi)


@dataclass(frozen=True)
class Case:
    """A motion of whole turns from (q, v) at theta = 0, None for rest, with its reference."""

    title: str
    follower: Follower
    cam: dict
    lift: Lift  # the cam in closed form, for the peers
    rpm: float
    turns: int
    start: tuple[float | None, float | None]
    hits: list[Mark]
    rests: list[Mark]  # accumulations
    final: tuple[float, float, float]  # q, v, and our bound there

    @property
    def omega(self) -> float:
        """Speed of the cam, rad/s."""
        return omega_of(self.rpm)


@cache
def case(name: str) -> Case:
    """A stored case."""
    data = reference(name)
    found: dict[str, list[Mark]] = {"impact": [], "chatter": [], "detachment": []}
    for e in reversed(data["events"]):
        exact = Decimal(e["theta"])
        theta = float(exact)
        rest = float(exact - Decimal(theta))
        mark = Mark(e["turn"], theta, rest, float(e["u"]), _bound(e["growth"]), False)
        near = any(0.0 <= end.at - mark.at < OPTIONAL for end in found["chatter"])
        found[e["kind"]].insert(0, mark._replace(optional=near))
    end = data["final"]
    return Case(
        title=data["title"],
        follower=Follower(**data["follower"]),
        cam=data["cam"],
        lift=lift_of(data["cam"]),
        rpm=data["rpm"],
        turns=data["turns"],
        start=(data["start"]["q"], data["start"]["v"]),
        hits=found["impact"],
        rests=found["chatter"],
        final=(float(end["q"]), float(end["v"]), _bound(end["growth"])),
    )


def _bound(growth: float) -> float:
    """What is promised of ours: a few roundings in every event, as far as the motion takes them."""
    return ALLOWANCE * ROUNDING * growth


# --- a run against the reference

CLOSEST = 1e-6  # turns: impacts closer than this are told apart by their speed too
WIDEST = 0.05  # turns: an impact further off is another one
MANY = 2000  # invented impacts beyond which they are not told apart
SAME_SPEED = 1.1  # ratio: bounces of a chatter differ by 1/r = 1.25 from one to the next


@dataclass(frozen=True)
class Agreement:
    """How a run agrees with the reference; errors in turns, and of the state as for `error`."""

    error: float
    missed: int
    extra: int
    excess: float  # largest error over its bound, of ours
    bound: float  # where the largest error is


def compare(case: Case, trace: Trace, tolerance: float = 0.0) -> Agreement:
    """Errors of a run, and how they stand to the bound at a chatter tolerance (turns)."""
    pairs = list(_pairs(case.hits, trace.hits))
    errors = [(abs(late), case.hits[i].bound) for i, _, late in pairs]
    closed = _closed(case, trace)
    errors += [(late, tolerance + mark.bound) for mark, late, _ in closed]
    if trace.final is not None:
        q, v, bound = case.final
        top = abs(case.lift.top)  # q is measured by the lift, v by omega times it
        off = (abs(trace.final[0] - q) / top, abs(trace.final[1] - v) / (case.omega * top))
        errors.append((max(off), bound))
    error, bound = max(errors, default=(nan, nan))
    missed = _missed(case, trace, {i for i, _, _ in pairs}, closed)
    extra = _extra(case, trace, {j for _, j, _ in pairs})
    return Agreement(error, missed, extra, max((e / b for e, b in errors), default=nan), bound)


def _pairs(marks: Sequence[Mark], hits: Sequence[tuple]) -> Iterator[tuple[int, int, float]]:
    """(i, j, late) of impacts that are the same one, in order: none beyond half its neighbours."""
    gaps = [WIDEST, *(b.at - a.at for a, b in pairwise(marks)), WIDEST]
    i = j = 0
    while i < len(marks) and j < len(hits):
        room = min(WIDEST, max(CLOSEST, 0.45 * min(gaps[i], gaps[i + 1])))
        late = marks[i].late(*hits[j][:2])
        ratio = hits[j][2] / marks[i].u if room <= CLOSEST and marks[i].u else 1.0
        if late > room or (abs(late) <= room and ratio < 1.0 / SAME_SPEED):
            i += 1
        elif late < -room or ratio > SAME_SPEED:
            j += 1
        else:
            yield i, j, late
            i, j = i + 1, j + 1


def _closed(case: Case, trace: Trace) -> list[tuple[Mark, float, float]]:
    """(accumulation, error, last impact followed before it) of every chatter closed, in turns."""
    found = []
    for mark in case.rests:
        late = min((mark.late(*rest) for rest in trace.rests), key=abs, default=inf)
        if abs(late) < WIDEST:
            before = [x for x in (mark.late(*hit[:2]) for hit in trace.hits) if x <= late]
            found.append((mark, abs(late), mark.at + before[-1] if before else 0.0))
    return found


def _missed(case: Case, trace: Trace, seen: set[int], closed) -> int:
    """Impacts not found, but for those that a chatter map has replaced."""
    last = max(seen, default=-1) if trace.given_up else len(case.hits) - 1
    lost = [mark for i, mark in enumerate(case.hits[: last + 1]) if i not in seen]
    return sum(
        not mark.optional and not any(after < mark.at <= end.at for end, _, after in closed)
        for mark in lost
    )


def _extra(case: Case, trace: Trace, seen: set[int]) -> int:
    """Impacts found that are not in the reference, those next to an accumulation apart."""
    others = [hit for j, hit in enumerate(trace.hits) if j not in seen]
    if len(others) > MANY:
        return len(others)
    marks = [m for m in case.hits if m.optional] + case.rests
    return sum(all(abs(m.late(*hit[:2])) >= OPTIONAL for m in marks) for hit in others)


# --- methods

MAX_TURN = 1.0 / 16.0  # largest step where there is a limit
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # rtol = atol; and ours for chatter
STEPS = (100, 400, 1600, 6400)  # per turn, of the fixed steps
FREE, LIMITED = (TOLERANCES, TOLERANCES), ((1e-3, 1e-8, 1e-13), (1e-8,))
SETTINGS = {  # tolerances without and with a limit of steps, of all points and of a quick run
    CORE: ((TOLERANCES, ()), ((1e-3, 1e-8, 1e-13), ())),
    "radau": (FREE, ((1e-3, 1e-6), (1e-6,))),  # order 5, implicit: beyond 1e-6 it takes seconds
    HEYOKA: ((TOLERANCES[1:], ()), ((1e-8, 1e-13), ())),
    RK4: ((STEPS, ()), ((100, 1600), ())),
}
TIGHTEST = 1e-9  # turns: the peers' chatter tolerance is their tolerance, at least this
MOST_IMPACTS = 20  # times those of the reference, before a run is given up


class Point(NamedTuple):
    """A method with one setting, and its chatter tolerance in turns."""

    method: str
    setting: str  # in words
    chatter: float
    value: float  # tolerance, or steps per turn
    max_turn: float = inf  # largest step, turns


def points(methods: Sequence[str], quick: bool) -> list[Point]:
    """All points of one case, in order."""
    found = []
    for method in methods:
        free, limited = SETTINGS.get(method, (FREE, LIMITED))[quick]
        for value, most in [*((x, inf) for x in free), *((x, MAX_TURN) for x in limited)]:
            if method == CORE:
                setting, chatter = f"chatter {value:.0e}", value
            elif method == RK4:
                setting, chatter = f"{value} steps per turn", max(float(value) ** -4, TIGHTEST)
            else:
                limit = "" if most == inf else " max_step 1/16 turn"
                setting, chatter = f"tol {value:.0e}{limit}", max(value, TIGHTEST)
            found.append(Point(method, setting, chatter, value, most))
    return found


def method_of(point: Point) -> Method:
    """The peer that a point stands for."""
    if point.method == RK4:
        return RungeKutta4(int(point.value))
    if point.method == HEYOKA:
        return Heyoka(point.value)
    return SolveIvp(point.method, point.value, point.max_turn)


def run_core(system: System, case: Case, tolerance: float) -> Trace:
    """Our own kernel at a chatter tolerance in turns, every event logged."""
    orbit = Orbit(system, case.rpm, Settings(0, case.turns, tolerance, 10**6, Start(*case.start)))
    record = orbit.run(strobes=False)
    q, w = orbit.position()
    rows = list(zip(record.kind, record.period, record.theta, record.u, strict=True))
    return Trace(
        hits=[(int(p), float(x), float(u) * orbit.omega) for k, p, x, u in rows if k == IMPACT],
        rests=[(int(p), float(x)) for k, p, x, _ in rows if k == CHATTER],
        final=(q, w * orbit.omega),
        evaluations=record.cost.evaluations,
    )


def run_peer(method: Method, case: Case, chatter: float, seconds: float = inf) -> Trace:
    """A peer on a case, within a budget of seconds."""
    most = 200 + MOST_IMPACTS * len(case.hits)
    machine = Machine(case.follower, case.lift, case.omega, case.turns, chatter, seconds, most)
    return follow(machine, method, *case.start)


# --- measurements

ALLOWED, QUICK_ALLOWED = 1.0, 0.25  # s at most for one run of a peer
COMPILING = 60.0  # s for heyoka's first call, which may have to compile
SHORT = 5e-3  # s: shorter calls are timed BATCH times more often
BATCH = 7
LONG = 0.2  # s: longer calls are repeated once


@dataclass(frozen=True)
class Measured:
    """A row of precision.csv: seconds, errors in turns, counts."""

    case: str
    method: str
    setting: str
    seconds: float = nan
    error: float = nan
    impacts: int = 0
    evaluations: int = 0
    missed: int = 0
    extra: int = 0
    first_call_s: float = nan
    bound: float = nan  # promised where the largest error is
    of_bound: float = nan  # largest error over its own bound
    status: str = NOT_REACHED

    @property
    def ours(self) -> bool:
        """Whether it is of this package."""
        return self.method == CORE


def measure(
    piece: tuple[str, Point],
    share: float,
    left: float,
    *,
    machines: Machines,
    most: float,
    repeats: int,
) -> list[Measured]:
    """The row of a case and a point, with its share of the seconds left, `most` for a run."""
    name, point = piece
    some, ours = case(name), point.method == CORE
    row = partial(Measured, name, point.method, point.setting)
    if left <= 0.0:
        return [row()]
    if point.method == HEYOKA and not heyoka_available():
        return [row(status=ABSENT)]
    allowed = min(most, share)
    began = perf_counter()
    try:
        call = _ready(some, point, machines)
        if point.method == HEYOKA:
            call(min(COMPILING, left))
        prepared = perf_counter()
        trace = call(allowed)
    except (ArithmeticError, ValueError):  # solve_ivp: step too small, bracket without a root
        return [row(status=FAILED)]
    first_call_s = perf_counter() - began
    seconds = began + first_call_s - prepared
    if not trace.given_up:
        seconds = repeated(call, repeats, seconds, allowed - seconds)
    found = compare(some, trace, point.chatter)
    return [
        row(
            seconds=seconds,
            error=found.error,
            impacts=len(trace.hits),
            evaluations=trace.evaluations,
            missed=found.missed,
            extra=found.extra,
            first_call_s=first_call_s,
            bound=found.bound if ours else nan,
            of_bound=found.excess if ours else nan,
            status=_status(found, trace, ours),
        )
    ]


def _ready(some: Case, point: Point, machines: Machines) -> Callable[[float], Trace]:
    """The run of a point as a function of the seconds allowed.

    What is done once is done here: imports, the cam's table, our compilation.
    """
    if point.method != CORE:
        if isinstance(method := method_of(point), SolveIvp):
            import scipy.integrate  # noqa: F401
        return lambda seconds: run_peer(method, some, point.chatter, seconds)
    system = machines.system(some.follower, some.cam)
    backend.compiled()
    return lambda _: run_core(system, some, point.chatter)


def _status(found: Agreement, trace: Trace, ours: bool) -> str:
    if ours and not found.excess <= 1.0:
        return OVER
    if trace.given_up:
        return GIVEN_UP
    return MISSED if found.missed else INVENTED if found.extra else OK


def repeated(call: Callable[[float], object], repeats: int, first: float, left: float) -> float:
    """Median time of further calls: more of them where one is short, one where it is long.

    `left` are the seconds that they may take; where they do not suffice for one, it is `first`.
    """
    wanted = repeats * BATCH if first < SHORT else repeats if first < LONG else 1
    times: list[float] = []
    while len(times) < wanted and sum(times) + first <= left:
        began = perf_counter()
        call(COMPILING)
        times.append(perf_counter() - began)
    return median(times or [first])


def heyoka_available() -> bool:
    """Whether heyoka is installed; it is not imported."""
    from importlib.util import find_spec

    return find_spec("heyoka") is not None


# --- what the rows say

EXACT = 1e-9  # turns: the error at which times are compared


@dataclass(frozen=True)
class Verdict:
    """Of one case: our tightest setting, the fastest peer to reach EXACT, the most exact one."""

    case: str
    seconds: float
    error_turns: float
    of_bound: float
    fastest_other: str | None
    ratio: float | None  # its time over ours
    most_exact_other: str | None
    its_error_turns: float | None


def verdicts(found: Sequence[Measured]) -> list[Verdict]:
    """One for each case that ours was measured in, in order; nan seconds: it was not."""
    told = []
    for name in dict.fromkeys(m.case for m in found):
        here = [m for m in found if m.case == name and not isnan(m.seconds)]
        ours = [m for m in here if m.ours]
        peers = [m for m in here if not m.ours and m.status == OK]
        fastest = min((m for m in peers if m.error <= EXACT), key=lambda m: m.seconds, default=None)
        best = min(peers, key=lambda m: m.error, default=None)
        if ours:
            told.append(
                Verdict(
                    name,
                    ours[-1].seconds,
                    ours[-1].error,
                    ours[-1].of_bound,
                    None if fastest is None else f"{fastest.method} {fastest.setting}",
                    None if fastest is None else fastest.seconds / ours[-1].seconds,
                    None if best is None else f"{best.method} {best.setting}",
                    None if best is None else best.error,
                )
            )
    return told


def failures(found: Sequence[Measured]) -> list[Measured]:
    """Points of ours that break a promise, or that could not be held to it."""
    return [m for m in found if m.ours and m.status != OK]
