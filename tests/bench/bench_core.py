"""Throughput of long runs: the core against the peers of `cam bench`, side by side.

    python tests/bench/bench_core.py [--repeats 5] [--scale 1.0] [--methods core rk45 ...]

`cam bench precision` compares errors on stretches short enough to have a reference; there a run of
ours is little more than the call. Here the core runs so many turns that only the kernel counts.
Every repeat runs all methods in turn, so that a ratio compares neighbours in time; the table quotes
medians. A method is called once beforehand on a few turns, which is where compilation goes.
"""

from __future__ import annotations

import argparse
import platform
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from statistics import median
from time import perf_counter

import numpy as np

from camcli.analysis.bench.machine import orbit
from camcli.analysis.bench.peers import heyoka_taylor, solve_ivp
from camcli.analysis.bench.precision import Case, case, run_peer
from camcli.cli.bench_run import machines
from camcli.kernel import backend
from camcli.kernel.orbit_loop import EventKind

CHATTER = 1e-9  # turns, everybody's tolerance
TURNS = {  # of a repeat, whatever the scale
    "periodic": {"core": 400_000, "heyoka": 20_000, "dop853": 600, "rk45": 120},
    "chatter": {"core": 10_000, "heyoka": 200, "dop853": 11, "rk45": 7},
}
PEERS = {  # the published setting of RK45 on this cam has steps of 1 ms
    "heyoka": heyoka_taylor(1e-13),
    "dop853": solve_ivp("dop853", 1e-12, 1.0 / 16.0),
    "rk45": solve_ivp("rk45", 1e-12, 1.0 / 86.0),
}
METHODS = ("core", *PEERS)


def runner(method: str, some: Case) -> Callable[[int], int]:
    """Impacts as a function of the number of turns; every impact is logged."""
    if method == "core":
        system = machines().system(some.follower, some.cam)
        backend.compiled()
        q, v = some.start

        def logged(turns: int) -> int:
            ours = orbit(system, some.rpm, turns, tolerance=CHATTER, q=q, v=v)
            kinds = np.asarray(ours.run(strobes=False).kind)
            return int(np.count_nonzero(kinds == EventKind.IMPACT))

        return logged

    def call(turns: int) -> int:
        longer = replace(some, turns=turns, hits=range(10**6))  # as many impacts as it likes
        return len(run_peer(PEERS[method], longer, CHATTER).hits)

    return call


def measure(name: str, options: argparse.Namespace) -> None:
    """Print the table of a case."""
    some = case(name)
    calls = {m: runner(m, some) for m in options.methods if m != "heyoka" or find_spec("heyoka")}
    turns = {m: max(1, round(TURNS[name][m] * options.scale)) for m in calls}
    first, times, impacts = {}, {m: [] for m in calls}, {}
    for method, call in calls.items():
        began = perf_counter()
        call(2)
        first[method] = perf_counter() - began
    for _ in range(options.repeats):
        for method, call in calls.items():
            began = perf_counter()
            impacts[method] = call(turns[method])
            times[method].append((perf_counter() - began) / turns[method])
    head = f"{'method':8}{'first call s':>14}{'impacts/s':>12}{'turns/s':>12}{'x core':>9}"
    print(f"\n{some.title}\n{head}")
    for method in calls:
        one = median(times[method])
        rate = impacts[method] / turns[method] / one
        base = times.get("core", times[method])
        ratio = median(a / b for a, b in zip(times[method], base, strict=True))
        print(f"{method:8}{first[method]:14.2f}{rate:12.0f}{1.0 / one:12.0f}{ratio:9.1f}")


def main() -> None:
    """Measure and print both cases."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--scale", type=float, default=1.0, help="multiplies all numbers of turns")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    options = parser.parse_args()
    print(f"Python {platform.python_version()}, {platform.machine()}, {options.repeats} repeats")
    for name in TURNS:
        measure(name, options)


if __name__ == "__main__":
    main()
