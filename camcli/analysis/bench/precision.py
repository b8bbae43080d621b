"""Work and precision of ours and of general integrators: `cam bench precision`.

A case is a motion of whole turns with its reference, solved with many digits. A point is a method
with one setting; it is run on a case, compared with the reference, and timed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache, partial
from importlib.util import find_spec
from math import inf, isnan, nan, pi
from statistics import median
from time import perf_counter
from typing import NamedTuple

import numpy as np

from camcli.analysis.bench import peers
from camcli.analysis.bench.machine import Machines, orbit, reference
from camcli.analysis.bench.peers import Lift, PeerTrace
from camcli.kernel import backend
from camcli.kernel.orbit_loop import CHATTER, IMPACT
from camcli.system import Follower, System, omega_of

CORE, RK4, HEYOKA = "core", "rk4", "heyoka"
OK, OVER, MISSED, INVENTED = "ok", "over-bound", "missed", "invented"
GIVEN_UP, FAILED, ABSENT = "given-up", "failed", "not-installed"

# --- cases

OPTIONAL = 1e-3  # turns before an accumulation: impacts there are not asked of anybody
ULP = 2.0**-52
ALLOWANCE = 8  # roundings of ours in one event; how far one goes is `growth`, from the reference


class ReferenceEvent(NamedTuple):
    """An event of the reference: phase as two doubles (rad), our bound (turns)."""

    turn: int
    theta: float
    rest: float  # theta - its double
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
    rpm: float
    turns: int
    start: tuple[float | None, float | None]
    hits: Sequence[ReferenceEvent]
    rests: Sequence[ReferenceEvent]  # accumulations
    final: tuple[float, float, float]  # q, v, and our bound there


@cache
def case(name: str) -> Case:
    """A stored case."""
    data = reference(name)
    marks: dict[str, list[ReferenceEvent]] = {"impact": [], "chatter": [], "detachment": []}
    for e in reversed(data["events"]):
        exact = Decimal(e["theta"])
        rest = float(exact - Decimal(float(exact)))
        mark = ReferenceEvent(e["turn"], float(exact), rest, _bound(e["growth"]), False)
        near = any(0.0 <= end.at - mark.at < OPTIONAL for end in marks["chatter"])
        marks[e["kind"]].insert(0, mark._replace(optional=near))
    end = data["final"]
    return Case(
        title=data["title"],
        follower=Follower(**data["follower"]),
        cam=data["cam"],
        rpm=data["rpm"],
        turns=data["turns"],
        start=(data["start"]["q"], data["start"]["v"]),
        hits=marks["impact"],
        rests=marks["chatter"],
        final=(float(end["q"]), float(end["v"]), _bound(end["growth"])),
    )


def _bound(growth: float) -> float:
    """What is promised of ours: a few roundings in every event, as far as the motion takes them."""
    return ALLOWANCE * ULP * growth


# --- a run against the reference

WIDEST = 0.05  # turns: an impact further off is another one


@dataclass(frozen=True)
class Agreement:
    """How a run agrees with the reference; errors in turns, of the state q over the cam's top."""

    error: float
    missed: int
    extra: int
    excess: float  # largest error over its bound, of ours
    bound: float  # where the largest error is


def compare(case: Case, trace: PeerTrace, tolerance: float = 0.0) -> Agreement:
    """Errors of a run, and how they stand to the bound at a chatter tolerance (turns).

    An impact and one of the reference are the same where each is the nearest to the other. Impacts
    that a chatter map has replaced are not missed, and the last ones before an accumulation neither
    missed nor invented.
    """
    marks = np.array([mark.at for mark in case.hits])
    hits = np.array([turn + theta / (2.0 * pi) for turn, theta, _ in trace.hits])
    pairs = _pairs(marks, hits)
    errors = [(abs(case.hits[i].late(*trace.hits[j][:2])), case.hits[i].bound) for i, j in pairs]
    replaced = np.zeros(len(marks), bool)
    for mark in case.rests:
        late = min((mark.late(*rest) for rest in trace.rests), key=abs, default=inf)
        if abs(late) < WIDEST:
            errors.append((abs(late), tolerance + mark.bound))
            before = hits[hits <= mark.at + late]
            replaced |= (marks > (before[-1] if len(before) else 0.0)) & (marks <= mark.at)
    if trace.final is not None:
        q, v, bound = case.final
        top = abs(Lift(case.cam).top)  # q is measured by the lift, v by omega times it
        off = abs(trace.final[0] - q) / top, abs(trace.final[1] - v) / (omega_of(case.rpm) * top)
        errors.append((max(off), bound))
    lost = np.ones(len(marks), bool)
    lost[[i for i, _ in pairs]] = False
    if trace.given_up:
        lost[max((i + 1 for i, _ in pairs), default=0) :] = False
    new = np.ones(len(hits), bool)
    new[[j for _, j in pairs]] = False
    for mark in (*(m for m in case.hits if m.optional), *case.rests):
        new &= abs(hits - mark.at) >= OPTIONAL
    error, bound = max(errors, default=(nan, nan))
    return Agreement(
        error,
        int((lost & ~replaced & ~np.array([m.optional for m in case.hits], bool)).sum()),
        int(new.sum()),
        max((e / b for e, b in errors), default=nan),
        bound,
    )


def _pairs(marks: np.ndarray, hits: np.ndarray) -> list[tuple[int, int]]:
    """(i, j) where marks[i] and hits[j] are each the nearest to the other."""
    from scipy.spatial import KDTree

    if not len(marks) or not len(hits):
        return []
    apart, there = KDTree(hits[:, None]).query(marks[:, None])
    back = KDTree(marks[:, None]).query(hits[:, None])[1]
    pairs = enumerate(there.tolist())
    return [(i, j) for i, j in pairs if back[j] == i and apart[i] < WIDEST]


# --- methods

MAX_TURN = 1.0 / 16.0  # largest step where there is a limit
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # rtol = atol; and ours, of chatter alone
STEPS = (100, 400, 1600, 6400)  # per turn, of the fixed steps
BOTH = (TOLERANCES, TOLERANCES), ((1e-3, 1e-8, 1e-13), (1e-8,))
SETTINGS = {  # values without and with a limit of steps, of all points and of a quick run
    CORE: (((*TOLERANCES, 1e-15), ()), ((1e-3, 1e-8, 1e-15), ())),
    "radau": (
        (TOLERANCES, TOLERANCES),
        ((1e-3, 1e-6), (1e-6,)),
    ),  # order 5, implicit: beyond 1e-6 it takes seconds
    HEYOKA: ((TOLERANCES[1:], ()), ((1e-8, 1e-13), ())),
    RK4: ((STEPS, ()), ((100, 1600), ())),
}
TIGHTEST = 1e-9  # turns: the peers' chatter tolerance is their tolerance, at least this
MOST_IMPACTS = 20  # times those of the reference, before a run is given up


class MethodSetting(NamedTuple):
    """A method with one setting, and its chatter tolerance in turns."""

    method: str
    setting: str  # in words
    chatter: float
    peer: peers.Method | None  # None: ours


def points(methods: Sequence[str], quick: bool) -> list[MethodSetting]:
    """All points of one case, in order."""
    return [
        _point(method, value, limit)
        for method in methods
        for limit, values in zip((inf, MAX_TURN), SETTINGS.get(method, BOTH)[quick], strict=True)
        for value in values
    ]


def _point(method: str, value: float, limit: float) -> MethodSetting:
    if method == CORE:
        return MethodSetting(method, f"chatter {value:.0e}", value, None)
    if method == RK4:
        chatter = max(float(value) ** -4, TIGHTEST)
        return MethodSetting(
            method, f"{value} steps per turn", chatter, peers.runge_kutta_4(int(value))
        )
    setting = f"tol {value:.0e}"
    chatter = max(value, TIGHTEST)
    if method == HEYOKA:
        return MethodSetting(method, setting, chatter, peers.heyoka_taylor(value))
    setting += "" if limit == inf else " max_step 1/16 turn"
    return MethodSetting(method, setting, chatter, peers.solve_ivp(method, value, limit))


def run_core(system: System, case: Case, tolerance: float) -> PeerTrace:
    """Our own kernel at a chatter tolerance in turns, every event logged."""
    q, v = case.start
    ours = orbit(system, case.rpm, case.turns, tolerance=tolerance, q=q, v=v)
    record = ours.run(strobes=False)
    q, w = ours.position()
    rows = record.events()
    return PeerTrace(
        hits=[(p, x, u * ours.omega) for k, p, x, _, u in rows if k == IMPACT],
        rests=[(p, x) for k, p, x, *_ in rows if k == CHATTER],
        final=(q, w * ours.omega),
        evaluations=record.cost.evaluations,
    )


def run_peer(method: peers.Method, case: Case, chatter: float, seconds: float = inf) -> PeerTrace:
    """A peer on a case, within a budget of seconds."""
    most = 200 + MOST_IMPACTS * len(case.hits)
    lift = Lift(case.cam)
    omega = omega_of(case.rpm)
    machine = peers.PeerMachine(case.follower, lift, omega, case.turns, chatter, seconds, most)
    return peers.follow(machine, method, *case.start)


# --- measurements

ALLOWED, QUICK_ALLOWED = 1.0, 0.25  # s at most for one run of a peer
COMPILING = 60.0  # s for a first call, which may import and compile
SHORT = 5e-3  # s: shorter calls are timed BATCH times more often
BATCH = 7
LONG = 0.2  # s: longer calls are not repeated


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
    bound: float = nan  # promised where the largest error is
    of_bound: float = nan  # largest error over its own bound
    status: str = ABSENT

    @property
    def ours(self) -> bool:
        """Whether it is of this package."""
        return self.method == CORE


def measure(
    piece: tuple[str, MethodSetting], *, machines: Machines, allowed: float, repeats: int
) -> Measured:
    """The row of a case and a point, `allowed` seconds for a run."""
    name, point = piece
    some = case(name)
    row = partial(Measured, name, point.method, point.setting)
    if point.method == HEYOKA and find_spec("heyoka") is None:
        return row()
    call: Callable[[float], PeerTrace]
    if point.peer is None:
        system = machines.system(some.follower, some.cam)
        backend.compiled()
        call = lambda _: run_core(system, some, point.chatter)  # noqa: E731
    else:
        call = partial(run_peer, point.peer, some, point.chatter)
    try:
        if point.method in (CORE, HEYOKA):  # imports and compilation are not timed
            call(COMPILING)
        began = perf_counter()
        trace = call(allowed)
        seconds = perf_counter() - began
        if not trace.given_up:
            seconds = repeated(partial(call, COMPILING), repeats, seconds)
    except (ArithmeticError, ValueError):  # solve_ivp: step too small, bracket without a root
        return row(status=FAILED)
    comparison = compare(some, trace, point.chatter)
    ours = point.peer is None
    if ours and not comparison.excess <= 1.0:
        status = OVER
    elif trace.given_up:
        status = GIVEN_UP
    else:
        status = MISSED if comparison.missed else INVENTED if comparison.extra else OK
    return row(
        seconds=seconds,
        error=comparison.error,
        impacts=len(trace.hits),
        evaluations=trace.evaluations,
        missed=comparison.missed,
        extra=comparison.extra,
        bound=comparison.bound if ours else nan,
        of_bound=comparison.excess if ours else nan,
        status=status,
    )


def repeated(call: Callable[[], object], repeats: int, first: float) -> float:
    """Median time of further calls, more of them where one is short; a long one's is `first`."""
    if first >= LONG:
        return first
    times = []
    for _ in range(repeats * BATCH if first < SHORT else repeats):
        began = perf_counter()
        call()
        times.append(perf_counter() - began)
    return median(times)


# --- what the rows say

EXACT = 1e-9  # turns: the error at which times are compared


@dataclass(frozen=True)
class CaseVerdict:
    """Of one case: our tightest setting, the fastest peer to reach EXACT, the most exact one."""

    case: str
    seconds: float
    error_turns: float
    of_bound: float
    fastest_other: str | None = None
    ratio: float | None = None  # its time over ours
    most_exact_other: str | None = None
    its_error_turns: float | None = None


def verdicts(measured: Sequence[Measured]) -> list[CaseVerdict]:
    """One for each case that ours was measured in, in order."""
    results = []
    for name in dict.fromkeys(m.case for m in measured):
        here = [m for m in measured if m.case == name and not isnan(m.seconds)]
        peers = [m for m in here if not m.ours and m.status == OK]
        fastest = min((m for m in peers if m.error <= EXACT), key=lambda m: m.seconds, default=None)
        best = min(peers, key=lambda m: m.error, default=None)
        for ours in [m for m in here if m.ours][-1:]:
            others: dict = {}
            if fastest is not None:
                others["fastest_other"] = f"{fastest.method} {fastest.setting}"
                others["ratio"] = fastest.seconds / ours.seconds
            if best is not None:
                others["most_exact_other"] = f"{best.method} {best.setting}"
                others["its_error_turns"] = best.error
            results.append(CaseVerdict(name, ours.seconds, ours.error, ours.of_bound, **others))
    return results
