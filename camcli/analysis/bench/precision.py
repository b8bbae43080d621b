"""Work and precision of ours and of general integrators: `cam bench precision`.

A case is a motion of whole turns with its reference, solved with many digits. A point is a case and
a method with one setting; it is run, compared with the reference, and timed. "Ours" is the kernel
of this package, a peer one of the general integrators of `peers`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from functools import cache, partial
from importlib.util import find_spec
from math import inf, isnan, nan, pi
from statistics import median
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from camcli.analysis.bench import peers
from camcli.analysis.bench.machine import Machines, orbit, reference
from camcli.analysis.bench.peers import Lift, PeerTrace
from camcli.analysis.integrate import ALL_FLOWN
from camcli.kernel import backend
from camcli.kernel.orbit_loop import CHATTER, IMPACT
from camcli.system import Follower, System, omega_of

CORE, RK4, HEYOKA = "core", "rk4", "heyoka"  # methods that are no name of solve_ivp
# the statuses of a row
OK = "ok"
OVER = "over-bound"  # an error of ours is larger than its bound
MISSED = "missed"  # an impact of the reference was not found
INVENTED = "invented"  # an impact was found that the reference has not
GIVEN_UP = "given-up"  # the budget of seconds or impacts was spent
FAILED = "failed"  # the method raised an error of its own
ABSENT = "not-installed"

# --- cases

OPTIONAL = 1e-3  # turns before an accumulation: impacts there are not asked of anybody
ULP = 2.0**-52
ALLOWANCE = 8  # roundings of ours in one event; how far one goes is `growth`, from the reference


class ReferenceEvent(NamedTuple):
    """An event of the reference: when it happens, and how far off ours may be.

    The phase is theta + rest, two doubles (rad), so that errors below one ulp can be seen.
    """

    turn: int
    theta: float
    rest: float  # what the double theta leaves of the phase
    bound: float  # of our error, turns
    optional: bool  # whether nobody is asked for it, since a chatter accumulates soon after it

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
    cam: dict  # a section `cam` of a scene
    rpm: float
    turns: int
    start: tuple[float | None, float | None]  # q (m), v (m/s)
    hits: Sequence[ReferenceEvent]
    rests: Sequence[ReferenceEvent]  # where chatters accumulate
    final: tuple[float, float, float]  # q (m), v (m/s), and our bound there (turns)


@cache
def case(name: str) -> Case:
    """A stored case, by its name in `camcli.scene.schema.CASES`."""
    data = reference(name)
    by_kind: dict[str, list[ReferenceEvent]] = {"impact": [], "chatter": [], "detachment": []}
    for stored in reversed(data["events"]):  # the chatters after an event are known before it
        exact = Decimal(stored["theta"])
        event = ReferenceEvent(
            turn=stored["turn"],
            theta=float(exact),
            rest=float(exact - Decimal(float(exact))),
            bound=_bound(stored["growth"]),
            optional=False,
        )
        near = any(0.0 <= end.at - event.at < OPTIONAL for end in by_kind["chatter"])
        by_kind[stored["kind"]].insert(0, event._replace(optional=near))
    end = data["final"]
    return Case(
        title=data["title"],
        follower=Follower(**data["follower"]),
        cam=data["cam"],
        rpm=data["rpm"],
        turns=data["turns"],
        start=(data["start"]["q"], data["start"]["v"]),
        hits=by_kind["impact"],
        rests=by_kind["chatter"],
        final=(float(end["q"]), float(end["v"]), _bound(end["growth"])),
    )


def _bound(growth: float) -> float:
    """The error that camcli promises: a few roundings in every event, grown as the motion does.

    growth: how much the motion has magnified the roundings of all events until then, from the
    reference (turns per unit of rounding).
    """
    return ALLOWANCE * ULP * growth


# --- a run against the reference

WIDEST = 0.05  # turns: an impact further off is another one


@dataclass(frozen=True)
class Agreement:
    """How a run agrees with the reference.

    Errors of events are in turns; those of the last state are shares of the cam's top.
    """

    error: float  # the largest one
    missed: int  # impacts of the reference that the run has not
    extra: int  # impacts of the run that the reference has not
    excess: float  # largest error over its bound, of ours
    bound: float  # where the largest error is


class BoundedError(NamedTuple):
    """An error and its bound, which is promised of ours; both in turns, or both shares."""

    error: float
    bound: float


def compare(case: Case, trace: PeerTrace, tolerance: float = 0.0) -> Agreement:
    """Errors of a run, and how they stand to the bound at a chatter tolerance (turns).

    An impact and one of the reference are the same where each is the nearest to the other. Impacts
    that a chatter map has replaced are not missed, and the last ones before an accumulation neither
    missed nor invented.
    """
    wanted = np.array([event.at for event in case.hits])  # turns since the start, as are hits
    hits = np.array([hit.turn + hit.theta / (2.0 * pi) for hit in trace.hits])
    pairs = _pairs(wanted, hits)
    errors = []
    for i, j in pairs:
        event = case.hits[i]
        late = event.late(trace.hits[j].turn, trace.hits[j].theta)
        errors.append(BoundedError(abs(late), event.bound))
    is_replaced = np.zeros(len(wanted), bool)  # by the map that has closed a chatter
    for rest in case.rests:
        lates = [rest.late(seen.turn, seen.theta) for seen in trace.rests]
        late = min(lates, key=abs, default=inf)
        if abs(late) < WIDEST:
            errors.append(BoundedError(abs(late), tolerance + rest.bound))
            hits_before = hits[hits <= rest.at + late]
            last_hit = hits_before[-1] if len(hits_before) else 0.0
            is_replaced |= (wanted > last_hit) & (wanted <= rest.at)
    if trace.final is not None:
        errors.append(_error_of_the_end(case, trace.final))
    largest = max(errors, default=BoundedError(nan, nan))
    return Agreement(
        error=largest.error,
        missed=int((_is_lost(case, trace, pairs) & ~is_replaced).sum()),
        extra=int(_is_new(case, hits, pairs).sum()),
        excess=max((error / bound for error, bound in errors), default=nan),
        bound=largest.bound,
    )


def _is_lost(case: Case, trace: PeerTrace, pairs: list[tuple[int, int]]) -> np.ndarray:
    """Which impacts of the reference the run has not, though it is asked for them; (hits,)."""
    is_lost = np.ones(len(case.hits), bool)
    is_lost[[i for i, _ in pairs]] = False
    if trace.given_up:  # what would have come later is not missed
        is_lost[max((i + 1 for i, _ in pairs), default=0) :] = False
    is_optional = np.array([event.optional for event in case.hits], bool)
    return is_lost & ~is_optional


def _is_new(case: Case, hits: np.ndarray, pairs: list[tuple[int, int]]) -> np.ndarray:
    """Which impacts of a run the reference has not; hits: in turns since the start, (n,).

    Those beside an accumulation, or beside an impact before one, are not counted.
    """
    is_new = np.ones(len(hits), bool)
    is_new[[j for _, j in pairs]] = False
    optional = [event for event in case.hits if event.optional]
    for event in (*optional, *case.rests):
        is_new &= abs(hits - event.at) >= OPTIONAL
    return is_new


def _error_of_the_end(case: Case, final: tuple[float, float]) -> BoundedError:
    """The error of the last state (q in m, v in m/s): the larger one of its two shares.

    The position is measured by the top of the cam, the velocity by omega times it.
    """
    exact_q, exact_v, bound = case.final
    q, v = final
    top = abs(Lift(case.cam).top)
    share_of_q = abs(q - exact_q) / top
    share_of_v = abs(v - exact_v) / (omega_of(case.rpm) * top)
    return BoundedError(max(share_of_q, share_of_v), bound)


def _pairs(wanted: np.ndarray, hits: np.ndarray) -> list[tuple[int, int]]:
    """(i, j) where wanted[i] and hits[j] (turns) are each the nearest to the other."""
    from scipy.spatial import KDTree

    if not len(wanted) or not len(hits):
        return []
    apart, nearest_hit = KDTree(hits[:, None]).query(wanted[:, None])
    nearest_wanted = KDTree(wanted[:, None]).query(hits[:, None])[1]
    return [
        (i, j)
        for i, j in enumerate(nearest_hit.tolist())
        if nearest_wanted[j] == i and apart[i] < WIDEST
    ]


# --- methods

MAX_TURN = 1.0 / 16.0  # largest step where there is a limit
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # rtol = atol; and ours, of chatter alone
STEPS = (100, 400, 1600, 6400)  # per turn, of the fixed steps


class SettingValues(NamedTuple):
    """The values that a method is run with: tolerances, or of RK4 steps per turn.

    free: with steps as long as the method takes them; limited: with none above MAX_TURN.
    """

    free: tuple[float, ...]
    limited: tuple[float, ...] = ()


class MethodValues(NamedTuple):
    """The values of a method: those of all points, and those of a quick run."""

    all: SettingValues
    quick: SettingValues


EVERY = SettingValues(TOLERANCES, TOLERANCES)
OTHERS = MethodValues(EVERY, SettingValues((1e-3, 1e-8, 1e-13), (1e-8,)))  # of solve_ivp
SETTINGS = {
    CORE: MethodValues(SettingValues((*TOLERANCES, 1e-15)), SettingValues((1e-3, 1e-8, 1e-15))),
    # order 5, implicit: beyond 1e-6 it takes seconds
    "radau": MethodValues(EVERY, SettingValues((1e-3, 1e-6), (1e-6,))),
    HEYOKA: MethodValues(SettingValues(TOLERANCES[1:]), SettingValues((1e-8, 1e-13))),
    RK4: MethodValues(SettingValues(STEPS), SettingValues((100, 1600))),
}
TIGHTEST = 1e-9  # turns: the peers' chatter tolerance is their tolerance, at least this
# A run is given up after FEW_IMPACTS and MOST_IMPACTS times those of the reference: a method that
# does not see where a chatter accumulates makes thousands.
FEW_IMPACTS = 200
MOST_IMPACTS = 20


class MethodSetting(NamedTuple):
    """A method with one setting, and its chatter tolerance in turns."""

    method: str
    setting: str  # in words
    chatter: float
    peer: peers.Method | None  # None: ours


def points(methods: Sequence[str], quick: bool) -> list[MethodSetting]:
    """All points of one case, in order: first those without a limit of the step."""
    settings = []
    for method in methods:
        values = SETTINGS.get(method, OTHERS)
        chosen = values.quick if quick else values.all
        settings += [_point(method, value, inf) for value in chosen.free]
        settings += [_point(method, value, MAX_TURN) for value in chosen.limited]
    return settings


def _point(method: str, value: float, limit: float) -> MethodSetting:
    """A method with one of its values; limit: turns of a step at most, inf for none.

    A peer closes a chatter at its own tolerance, but at TIGHTEST turns at the closest; of fixed
    steps of order four that tolerance is steps^-4.
    """
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
    record = ours.run(strobes=False, portions=ALL_FLOWN)
    q, w = ours.position()  # at the end of the run; w and u are per radian
    rows = record.events()
    return PeerTrace(
        hits=[
            peers.PeerImpact(turn, theta, u * ours.omega)
            for kind, turn, theta, _, u in rows
            if kind == IMPACT
        ],
        rests=[peers.PeerRest(turn, theta) for kind, turn, theta, *_ in rows if kind == CHATTER],
        final=(q, w * ours.omega),
        evaluations=record.cost.evaluations,
    )


def run_peer(method: peers.Method, case: Case, chatter: float, seconds: float = inf) -> PeerTrace:
    """A peer on a case, within a budget of seconds."""
    most = FEW_IMPACTS + MOST_IMPACTS * len(case.hits)
    lift = Lift(case.cam)
    omega = omega_of(case.rpm)
    machine = peers.PeerMachine(
        case.follower,
        lift,
        omega=omega,
        turns=case.turns,
        chatter=chatter,
        seconds=seconds,
        most_impacts=most,
    )
    return peers.follow(machine, method, *case.start)


# --- measurements

# Seconds of the processor. None of them changes a result: they bound how long the bench takes.
ALLOWED, QUICK_ALLOWED = 1.0, 0.25  # at most for one run of a peer
COMPILING = 60.0  # for a first call, which may import and compile
SHORT = 5e-3  # a call that takes less is timed BATCH times more often
BATCH = 7
LONG = 0.2  # a call that takes more is not repeated


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
        """Whether the method is of this package."""
        return self.method == CORE


class Point(NamedTuple):
    """What one row measures: a method with one setting on a case."""

    case: str
    setting: MethodSetting

    def row(self, **values: Any) -> Measured:
        """Its row, with these values; what is left out is not known."""
        return Measured(self.case, self.setting.method, self.setting.setting, **values)


def measure(point: Point, *, machines: Machines, allowed: float, repeats: int) -> Measured:
    """The row of a point.

    A run may take `allowed` seconds. The time is the median of `repeats` further runs, where one is
    short enough; the errors are those of the first.
    """
    method = point.setting.method
    if method == HEYOKA and find_spec("heyoka") is None:
        return point.row()
    call = _run_of(point, machines)
    try:
        if method in (CORE, HEYOKA):  # imports and compilation are not timed
            call(COMPILING)
        began = perf_counter()
        trace = call(allowed)
        seconds = perf_counter() - began
        if not trace.given_up:
            seconds = repeated(partial(call, COMPILING), repeats, seconds)
    except (ArithmeticError, ValueError):  # solve_ivp: step too small, bracket without a root
        return point.row(status=FAILED)
    agreement = compare(case(point.case), trace, point.setting.chatter)
    ours = method == CORE
    return point.row(
        seconds=seconds,
        error=agreement.error,
        impacts=len(trace.hits),
        evaluations=trace.evaluations,
        missed=agreement.missed,
        extra=agreement.extra,
        bound=agreement.bound if ours else nan,
        of_bound=agreement.excess if ours else nan,
        status=_status(trace, agreement, ours),
    )


def _status(trace: PeerTrace, agreement: Agreement, ours: bool) -> str:
    """The status of a row; a bound is promised of ours only."""
    if ours and not agreement.excess <= 1.0:
        return OVER
    if trace.given_up:
        return GIVEN_UP
    if agreement.missed:
        return MISSED
    if agreement.extra:
        return INVENTED
    return OK


def _run_of(point: Point, machines: Machines) -> Callable[[float], PeerTrace]:
    """A function that runs the point once, within the seconds it is called with.

    Ours takes no limit of time.
    """
    motion = case(point.case)
    setting = point.setting
    if setting.peer is not None:
        return partial(run_peer, setting.peer, motion, setting.chatter)
    system = machines.system(motion.follower, motion.cam)
    backend.compiled()
    return lambda _: run_core(system, motion, setting.chatter)


def repeated(call: Callable[[], object], repeats: int, first: float) -> float:
    """Median time (s) of further calls; first: the time of the first call.

    There are more of them where one is short, and none where the first was long: then that is it.
    """
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
    """One case: our tightest setting, the fastest peer within EXACT, the most exact peer."""

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
    cases = dict.fromkeys(row.case for row in measured)
    of_cases = (_verdict(name, [row for row in measured if row.case == name]) for name in cases)
    return [verdict for verdict in of_cases if verdict is not None]


def _verdict(name: str, rows: Sequence[Measured]) -> CaseVerdict | None:
    """What the rows of one case say; None where ours is not among them."""
    timed = [row for row in rows if not isnan(row.seconds)]
    ours = [row for row in timed if row.ours]
    if not ours:
        return None
    tightest = ours[-1]
    verdict = CaseVerdict(name, tightest.seconds, tightest.error, tightest.of_bound)
    peers = [row for row in timed if not row.ours and row.status == OK]
    if not peers:
        return verdict
    most_exact = min(peers, key=lambda row: row.error)
    verdict = replace(
        verdict,
        most_exact_other=f"{most_exact.method} {most_exact.setting}",
        its_error_turns=most_exact.error,
    )
    exact = [row for row in peers if row.error <= EXACT]
    if not exact:
        return verdict
    fastest = min(exact, key=lambda row: row.seconds)
    return replace(
        verdict,
        fastest_other=f"{fastest.method} {fastest.setting}",
        ratio=fastest.seconds / tightest.seconds,
    )
