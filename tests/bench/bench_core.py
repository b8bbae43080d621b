"""Throughput of long runs: the core, a kernel written by hand in C, and the peers of `cam bench`.

    python tests/bench/bench_core.py [--repeats 5] [--scale 1.0] [--methods core c heyoka ...]

`cam bench precision` compares errors on stretches short enough to have a reference; there a run of
ours is little more than the call. Here the core runs so many turns that only the kernel counts.
Every repeat runs all methods in turn, so that a ratio compares neighbours in time; the table quotes
medians. A method is called once beforehand on a few turns, which is where compilation goes. The C
kernel (plain.c) takes part where there is a C compiler.

The last table sets the core beside C at single speeds, from rest, in processor time of the thread,
whose ratio is the same on a machine at work. C's bound on the error of its chatter map is cruder,
so that it has more impacts in a turn at 190 rpm.
"""

from __future__ import annotations

import argparse
import ctypes
import platform
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from math import pi, sqrt
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, thread_time

import numpy as np

from camcli.analysis.bench.machine import orbit
from camcli.analysis.bench.peers import heyoka_taylor, solve_ivp
from camcli.analysis.bench.precision import Case, case, run_peer
from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import ALL_FLOWN, Settings
from camcli.analysis.sweep import sweep
from camcli.api.bench import machines
from camcli.kernel import backend
from camcli.kernel.orbit_loop import EventKind
from camcli.parallel import Work
from camcli.system import Follower

CHATTER = 1e-9  # turns, everybody's tolerance
TURNS = {  # of a repeat, whatever the scale
    "periodic": {"core": 400_000, "c": 400_000, "heyoka": 20_000, "dop853": 600, "rk45": 120},
    "chatter": {"core": 40_000, "c": 10_000, "heyoka": 200, "dop853": 11, "rk45": 7},
}
PEERS = {  # the published setting of RK45 on this cam has steps of 1 ms
    "heyoka": heyoka_taylor(1e-13),
    "dop853": solve_ivp("dop853", 1e-12, 1.0 / 16.0),
    "rk45": solve_ivp("rk45", 1e-12, 1.0 / 86.0),
}
METHODS = ("core", "c", *PEERS)
SPEEDS, SWEPT = 401, 1000  # of the sweep 660 to 760 rpm, and its turns
BESIDE_C = {190.0: 20_000, 700.0: 200_000, 745.0: 200_000}  # rpm: turns of a repeat
ROUNDS = 3  # of `beside_c`, for each of the repeats asked for
WHOLE = {"sweep": 1, "sweep 2": 2}  # threads of the whole sweep beside C's bare orbits


def c_kernel(folder: Path) -> Callable[..., int] | None:
    """The function of plain.c as (machine, rpm, turns, start) -> impacts, every impact logged."""
    compiler, source = shutil.which("cc"), Path(__file__).with_name("plain.c")
    if compiler is None:
        return None
    library = folder / "plain.so"
    options = "-O3", "-march=native", "-ffp-contract=off", "-shared", "-fPIC"
    subprocess.run([compiler, *options, "-o", library, source, "-lm"], check=True)
    function = ctypes.CDLL(str(library)).plain_orbit
    real, whole, place = ctypes.c_double, ctypes.c_long, ctypes.c_void_p
    function.argtypes = real, real, real, whole, real, real, place, whole, place
    function.restype = whole

    def follow(follower: Follower, rpm: float, turns: int, start: tuple) -> int:
        omega, rows = rpm * pi / 30.0, 100 * turns
        W = sqrt(follower.stiffness / follower.mass) / omega
        q, v = (value or 0.0 for value in start)
        log, end = np.empty((rows, 3)), np.empty(2)
        return function(
            W, follower.restitution, 2.0 * pi * CHATTER, turns, q, v / omega,
            log.ctypes.data, rows, end.ctypes.data,
        )  # fmt: skip

    return follow


def runner(method: str, some: Case, plain: Callable[..., int] | None) -> Callable[[int], int]:
    """Impacts as a function of the number of turns; every impact is logged."""
    if method == "core":
        system = machines().system(some.follower, some.cam)
        q, v = some.start

        def logged(turns: int) -> int:
            ours = orbit(system, some.rpm, turns, tolerance=CHATTER, q=q, v=v)
            kinds = np.asarray(ours.run(strobes=False, portions=ALL_FLOWN).kind)
            return int(np.count_nonzero(kinds == EventKind.IMPACT))

        return logged
    if method == "c":
        return lambda turns: plain(some.follower, some.rpm, turns, some.start)

    def call(turns: int) -> int:
        longer = replace(some, turns=turns, hits=range(10**6))  # as many impacts as it likes
        return len(run_peer(PEERS[method], longer, CHATTER).hits)

    return call


def swept(method: str, some: Case, plain: Callable[..., int] | None) -> Callable[[int], int]:
    """The same for a sweep from rest; turns are those of all its speeds."""
    speeds = [
        replace(some, rpm=float(x), start=(None, None)) for x in np.linspace(660, 760, SPEEDS)
    ]
    calls = [runner(method, one, plain) for one in speeds]
    return lambda turns: sum(call(turns // SPEEDS) for call in calls)


def whole_sweep(threads: int) -> Callable[[int], int]:
    """The same with all that `cam sweep` makes of it: records, labels and every column of loads.

    Without patience, which is turns that C does not run.
    """
    system = machines().system(case("periodic").follower, case("periodic").cam)
    speeds, work = rpm_grid(660.0, 760.0, SPEEDS), Work(threads=threads)

    def run(turns: int) -> int:
        each = turns // SPEEDS
        settings = Settings(each - each * 2 // 5, each * 2 // 5, CHATTER, 1_000_000, patience=0)
        return sweep(system, speeds, settings, work=work).cost.impacts

    return run


def measure(
    title: str, calls: dict[str, Callable[[int], int]], turns: dict[str, int], repeats: int
) -> None:
    """Print the table of a case."""
    first, times, impacts = {}, {m: [] for m in calls}, {}
    for method, call in calls.items():
        began = perf_counter()
        call(2)
        first[method] = perf_counter() - began
    for _ in range(repeats):
        for method, call in calls.items():
            began = perf_counter()
            impacts[method] = call(turns[method])
            times[method].append((perf_counter() - began) / turns[method])
    base = next(iter(calls))
    head = f"{'method':8}{'first call s':>14}{'impacts/s':>12}{'turns/s':>12}{'x ' + base:>9}"
    print(f"\n{title}\n{head}")
    for method in calls:
        one = median(times[method])
        rate = impacts[method] / turns[method] / one
        ratio = median(a / b for a, b in zip(times[method], times[base], strict=True))
        print(f"{method:8}{first[method]:14.2f}{rate:12.0f}{1.0 / one:12.0f}{ratio:9.2f}")


def beside_c(plain: Callable[..., int], repeats: int, scale: float) -> None:
    """Print impacts a second of the core and of C at single speeds, and the ratio of the two.

    times C: how much faster the core is by impacts, and by turns; medians of neighbours in time.
    """
    title = "the core beside C at single speeds, by processor time"
    head = f"{'core':>20}{'C':>24}{'times C':>23}\n{'rpm':8}"
    head += f"{'a turn':>12}{'impacts/s':>12}" * 2 + f"{'impacts':>10}{'turns':>8}"
    print(f"\n{title}\n{head}")
    for rpm, usual in BESIDE_C.items():
        some = replace(case("periodic"), rpm=rpm, start=(None, None))
        turns = max(10, round(usual * scale))
        calls = {method: runner(method, some, plain) for method in ("core", "c")}
        impacts, times = {}, {"core": [], "c": []}
        for _ in range(ROUNDS * repeats):
            for method, call in calls.items():
                began = thread_time()
                impacts[method] = call(turns)
                times[method].append(thread_time() - began)
        line = f"{rpm:<8.0f}"
        for method in calls:
            rate = impacts[method] / median(times[method])
            line += f"{impacts[method] / turns:12.2f}{rate:12.0f}"
        by_turns = median(c / core for core, c in zip(times["core"], times["c"], strict=True))
        by_impacts = by_turns * impacts["core"] / impacts["c"]
        print(f"{line}{by_impacts:10.2f}{by_turns:8.2f}")


def main() -> None:
    """Measure and print both cases, a sweep, and single speeds beside C."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--scale", type=float, default=1.0, help="multiplies all numbers of turns")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    options = parser.parse_args()
    print(f"Python {platform.python_version()}, {platform.machine()}, {options.repeats} repeats")
    backend.compiled()
    with TemporaryDirectory() as folder:
        plain = c_kernel(Path(folder))
        there = {"c": plain is not None, "heyoka": find_spec("heyoka")}
        methods = [method for method in options.methods if there.get(method, True)]
        for name in TURNS:
            some = case(name)
            turns = {m: max(1, round(TURNS[name][m] * options.scale)) for m in methods}
            calls = {method: runner(method, some, plain) for method in methods}
            measure(some.title, calls, turns, options.repeats)
        some, fast = case("periodic"), [method for method in methods if method in ("core", "c")]
        turns = dict.fromkeys(fast, SPEEDS * max(1, round(SWEPT * options.scale)))
        calls = {method: swept(method, some, plain) for method in fast}
        measure(f"sweep of {SPEEDS} speeds from rest", calls, turns, options.repeats)
        turns |= dict.fromkeys(WHOLE, SPEEDS * max(5, round(SWEPT * options.scale)))
        calls = {m: call for m, call in calls.items() if m == "c"}
        calls |= {name: whole_sweep(threads) for name, threads in WHOLE.items()}
        title = f"the whole sweep of {SPEEDS} speeds, all columns, over bare orbits in C"
        measure(title, calls, turns, options.repeats)
        if plain is not None and {"core", "c"} <= set(methods):
            beside_c(plain, options.repeats, options.scale)


if __name__ == "__main__":
    main()
