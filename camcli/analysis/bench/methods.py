"""Every method with its settings, as a function from a case to a run."""

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
from camcli.analysis.engine import compile_for
from camcli.kernel import backend
from camcli.system import System

CORE, RK4, HEYOKA = "core", "rk4", "heyoka"
MAX_TURN = 1.0 / 16.0  # largest step where there is a limit
TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13)  # rtol = atol; and ours for chatter
STEPS = (100, 400, 1600, 6400)  # per turn, of the fixed steps
QUICK_TOLERANCES = (1e-3, 1e-8, 1e-13)
QUICK_STEPS = (100, 1600)
TIGHTEST = 1e-9  # turns: the peers' chatter tolerance is their tolerance, at least this
MOST_IMPACTS = 20  # times those of the reference, before a run is given up


@dataclass(frozen=True)
class Point:
    """A method with one setting; `tolerance` is that of chatter, in turns."""

    method: str
    setting: str
    tolerance: float
    call: Callable[[Case, float], Trace]  # seconds allowed


def points(methods: tuple[str, ...], quick: bool, bench: Bench) -> list[Point]:
    """All points of one case, in order."""
    tolerances = QUICK_TOLERANCES if quick else TOLERANCES
    found: list[Point] = []
    for method in methods:
        if method == CORE:
            found += [_core(tolerance, bench) for tolerance in tolerances]
        elif method == HEYOKA:
            found += [_heyoka(tolerance) for tolerance in tolerances[1:]]
        elif method == RK4:
            found += [_rk4(steps) for steps in (QUICK_STEPS if quick else STEPS)]
        else:
            found += [_scipy(method, t, most) for most in (inf, MAX_TURN) for t in tolerances]
    return found


def world_of(case: Case, seconds: float, tolerance: float) -> World:
    """The peers' world of a case, with its budgets."""
    deadline = process_time() + seconds
    most = 200 + MOST_IMPACTS * len(case.hits)
    return World(case.follower, case.lift, case.omega, case.turns, tolerance, deadline, most)


def _core(tolerance: float, bench: Bench) -> Point:
    known: dict[str, System] = {}

    def call(case: Case, seconds: float) -> Trace:
        if case.name not in known:
            known[case.name] = case.system(bench)
            if backend.may_compile():
                compile_for(known[case.name])
        return core.run(known[case.name], case.rpm, case.start, case.turns, tolerance)

    return Point(CORE, f"chatter {tolerance:.0e}", tolerance, call)


def _peer(method: str, setting: str, tolerance: float, run: Callable) -> Point:
    closed = max(tolerance, TIGHTEST)

    def call(case: Case, seconds: float) -> Trace:
        return run(world_of(case, seconds, closed), case.start)

    return Point(method, setting, closed, call)


def _scipy(method: str, tolerance: float, most: float) -> Point:
    limit = "" if most == inf else " max_step 1/16 turn"
    run = partial(solve_ivp.run, method=method, tolerance=tolerance, max_turn=most)
    return _peer(method, f"tol {tolerance:.0e}{limit}", tolerance, run)


def _heyoka(tolerance: float) -> Point:
    return _peer(
        HEYOKA, f"tol {tolerance:.0e}", tolerance, partial(taylor.run, tolerance=tolerance)
    )


def _rk4(steps: int) -> Point:
    run = partial(rk4.run, steps=steps)
    return _peer(RK4, f"{steps} steps per turn", float(steps) ** -4, run)
