"""Every method with its settings: plain points, and the run of a case that one stands for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf
from time import process_time

from camcli.analysis.bench.cases import Case
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.peers import core, rk4, solve_ivp, taylor
from camcli.analysis.bench.peers.world import Trace, World
from camcli.analysis.integrate import compile_for
from camcli.kernel import backend

CORE, RK4, HEYOKA = "core", "rk4", "heyoka"
MAX_TURN = 1.0 / 16.0  # largest step where there is a limit
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # rtol = atol; and ours for chatter
STEPS = (100, 400, 1600, 6400)  # per turn, of the fixed steps
QUICK_CORE = (1e-3, 1e-8, 1e-13)
QUICK_FREE = (1e-3, 1e-8, 1e-13)  # without a step limit
QUICK_LIMITED = (1e-8,)
QUICK_RADAU = (1e-3, 1e-6)  # of order 5 and implicit: beyond these it takes seconds
QUICK_HEYOKA = (1e-8, 1e-13)
QUICK_STEPS = (100, 1600)
TIGHTEST = 1e-9  # turns: the peers' chatter tolerance is their tolerance, at least this
MOST_IMPACTS = 20  # times those of the reference, before a run is given up
COMPILING = 60.0  # s for heyoka's first call, which may have to compile


@dataclass(frozen=True)
class Point:
    """A method with one setting, in plain values."""

    method: str
    setting: str  # the same in words
    chatter: float  # its chatter tolerance, turns
    value: float  # tolerance, or steps per turn
    limit: float = inf  # largest step, turns


def points(methods: tuple[str, ...], quick: bool) -> list[Point]:
    """All points of one case, in order."""
    return [point for method in methods for point in _points(method, quick)]


def _points(method: str, quick: bool) -> list[Point]:
    if method == CORE:
        wanted = QUICK_CORE if quick else TOLERANCES
        return [Point(CORE, f"chatter {tol:.0e}", tol, tol) for tol in wanted]
    if method == RK4:
        return [_rk4(steps) for steps in (QUICK_STEPS if quick else STEPS)]
    if method == HEYOKA:
        return [_peer(HEYOKA, tol) for tol in (QUICK_HEYOKA if quick else TOLERANCES[1:])]
    free, limited = TOLERANCES, TOLERANCES
    if quick:
        free, limited = (QUICK_RADAU if method == "radau" else QUICK_FREE), QUICK_LIMITED
    if quick and method == "radau":
        limited = QUICK_RADAU[-1:]
    return [_peer(method, t) for t in free] + [_peer(method, t, MAX_TURN) for t in limited]


def _peer(method: str, tolerance: float, limit: float = inf) -> Point:
    words = "" if limit == inf else " max_step 1/16 turn"
    setting = f"tol {tolerance:.0e}{words}"
    return Point(method, setting, max(tolerance, TIGHTEST), tolerance, limit)


def _rk4(steps: int) -> Point:
    closed = max(float(steps) ** -4, TIGHTEST)
    return Point(RK4, f"{steps} steps per turn", closed, float(steps))


def world_of(case: Case, seconds: float, tolerance: float) -> World:
    """The peers' world of a case, with its budgets."""
    deadline = process_time() + seconds
    most = 200 + MOST_IMPACTS * len(case.hits)
    return World(case.follower, case.lift, case.omega, case.turns, tolerance, deadline, most)


def ready(case: Case, point: Point, bench: Bench) -> Callable[[float], Trace]:
    """The run of a case by a point, as a function of the seconds allowed.

    What is done once in a process is done here: imports, the cam's table, our compilation.
    """
    if point.method == CORE:
        system = bench.system(case.name, lambda: case.system(bench))
        if backend.may_compile():
            compile_for(system)
        return lambda _: core.run(system, case.rpm, case.start, case.turns, point.chatter)
    if point.method == RK4:
        run = partial(rk4.run, steps=int(point.value))
    elif point.method == HEYOKA:
        run = partial(taylor.run, tolerance=point.value)
    else:
        solve_ivp.load()
        run = partial(
            solve_ivp.run, method=point.method, tolerance=point.value, max_turn=point.limit
        )
    return lambda seconds: run(world_of(case, seconds, point.chatter), case.start)
