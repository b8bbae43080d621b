"""Cost of an impact, scaling over threads and Dask processes, and what a piece costs besides.

    python tests/bench/bench_scale.py [--only scaling pieces exponents shell rests tables]

Run it by hand on a quiet machine; scaling needs the extra `cluster`. All ratios are of times
measured in one run, interleaved: the least of REPEATS, of commands the median of several runs, with
the processor time beside the wall's. Commands find their modules compiled, as an installer leaves
them, whatever PYTHONDONTWRITEBYTECODE says here.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import Orbit, Settings, Start, run_all
from camcli.analysis.sweep import sweep
from camcli.kernel import backend
from camcli.parallel import Work
from camcli.parallel.checkpoint import Checkpoint
from camcli.parallel.dask_cluster import LOCAL, DaskCluster
from camcli.scene import load_scene
from camcli.system import Follower, System

REPEATS = 3
LONG = Settings(40_000, 100, 1e-9, 1_000_000)  # turns of a speed: the kernel is all that matters
DEFAULT, CHAOS = (660.0, 760.0), (745.0, 760.0)  # rpm; in chaos no turn is another one again
SHORT = Settings(0, 1, 1e-9, 1_000_000)  # one turn: what a piece costs besides
WHOLE = Settings(600, 400, 1e-9, 1_000_000)  # those of the default sweep
SPEEDS, PIECES, SWEPT, MANY = 200, 4_000, 401, 5_000
RUNS, LONG_RUNS = 5, 3  # of commands of a second or two, and of longer ones
SHELL = f"sweep --rpm 660:760 --points {SWEPT} --quiet"
RESTS = "sweep --rpm 340:370 --points 400 --quiet --no-plot"
LONGER = f"sweep --rpm 660:760 --points {MANY} --quiet --no-plot --set sweep.tables="


def main() -> None:
    """Measure and print what is asked for, or all."""
    parts = {
        "scaling": scaling, "pieces": pieces, "exponents": exponents, "shell": shell,
        "rests": rests, "tables": tables,
    }  # fmt: skip
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", choices=parts, default=list(parts))
    scene = load_scene(None)
    system = System.build(Follower(**scene.follower.model_dump()), scene.cam)
    backend.compiled()
    for name in parser.parse_args().only:
        parts[name](system)


def shell(_: System) -> None:
    """The default sweep as a user waits for it, without its picture and with it."""
    print_commands({"no picture": f"{SHELL} --no-plot", "with its picture": SHELL})


def rests(_: System) -> None:
    """Speeds at which most motions rest and are followed in balls, beside the default sweep."""
    lines = {"default sweep": f"{SHELL} --no-plot", "400 speeds of rests": RESTS}
    cpu = print_commands(lines, runs=1)
    ratio = cpu["400 speeds of rests"] / cpu["default sweep"]
    print(f"speeds of rests over the default sweep: {ratio:.1f}")


def tables(_: System) -> None:
    """What the tables of many speeds cost."""
    kinds = "none", "csv", "npz"
    cpu = print_commands({f"{MANY} speeds, {kind}": LONGER + kind for kind in kinds}, LONG_RUNS)
    none, csv, npz = (cpu[f"{MANY} speeds, {kind}"] for kind in kinds)
    print(f"npz over CSV, each less the run without tables: {(npz - none) / (csv - none):.2f}")


def print_commands(lines: dict[str, str], runs: int = RUNS) -> dict[str, float]:
    """Print the times of commands, the first run of each left out; returns their processor times.

    Each is the median of its runs.
    """
    times: dict[str, list] = {name: [] for name in lines}
    found = {}
    with TemporaryDirectory() as folder:
        compiled = {"PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": f"{folder}/compiled"}
        for _ in range(1 + runs):
            for name, line in lines.items():
                words = [sys.executable, "-m", "camcli", *line.split(), "-o", name.split(",")[-1]]
                before, began = os.times(), perf_counter()
                environment = {**os.environ, **compiled}
                subprocess.run(
                    words, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
                )
                wall, after = perf_counter() - began, os.times()
                cpu = after.children_user - before.children_user
                times[name].append((wall, cpu + after.children_system - before.children_system))
    for name, (_, *later) in times.items():
        wall, cpu = (median(column) for column in zip(*later, strict=True))
        print(f"{name}: {wall:.2f} s, of processors {cpu:.2f} s", flush=True)
        found[name] = cpu
    return found


def pieces(system: System) -> None:
    """One turn from a state, called alone, and 64 of them in a call of the kernel."""
    starts = [Start(0.15 + 1e-6 * k, 0.1) for k in range(PIECES)]

    def fly(at_once: int) -> tuple[float, int]:
        began = perf_counter()
        for k in range(0, PIECES, at_once):
            run_all([Orbit(system, 700.0, SHORT, start) for start in starts[k : k + at_once]])
        return perf_counter() - began, 0

    for at_once, (took, _) in best({1: 1, 64: 64}, fly).items():
        print(f"one turn, {at_once} in a call: {took / PIECES * 1e6:.0f} us each")


def exponents(system: System) -> None:
    """A sweep with exponents over one without."""
    for settings in (WHOLE, replace(WHOLE, patience=0)):
        for threads in (1, 2):
            work = Work(threads=threads)
            measure = partial(timed, system, work, settings, SWEPT)
            found = best({"without": False, "with": True}, measure)
            ratio = found["with"][0] / found["without"][0]
            print(f"exponents, {threads} threads, patience {settings.patience}: {ratio:.2f} times")


def scaling(system: System) -> None:
    """Long orbits, which are the kernel alone, and pieces of one turn, threads and processes."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        ways = {"1 thread": Work(threads=1), "2 threads": Work(threads=2)}
        for n in (1, 2, 4):
            cluster = stack.enter_context(DaskCluster(LOCAL, n))
            ways[f"{n} Dask process{'es' if n > 1 else ''}"] = Work(cluster=cluster)
        for work in ways.values():  # load the kernel everywhere
            timed(system, work, LONG, 20, ends=CHAOS)
        strong = best(ways, lambda work: timed(system, work, LONG, SPEEDS, ends=CHAOS))
        seconds, impacts = strong["1 thread"]
        each = seconds / impacts * 1e9
        print(f"one thread: {impacts} impacts in {seconds:.2f} s, {each:.0f} ns each")
        print(f"10^12 impacts on one thread: {seconds / impacts * 1e12 / 86400:.1f} days")
        for way, (took, _) in strong.items():
            print(f"strong, {way}: {seconds / took:.2f} times as fast")
        half = best(
            {"half": ways["1 thread"]},
            lambda work: timed(system, work, LONG, SPEEDS // 2, ends=CHAOS),
        )
        print(
            f"weak, 2 threads with twice the speeds: {strong['2 threads'][0] / half['half'][0]:.2f}"
        )
        short = best(ways, lambda work: timed(system, work, SHORT, PIECES))
        for way, (took, _) in short.items():
            print(f"a piece of one turn, {way}: {took / PIECES * 1e6:.0f} us")
        count = iter(range(1000))

        def kept_on_disk(_: Work) -> tuple[float, int]:
            checkpoint = Checkpoint(folder / f"{next(count)}", "bench")
            found = timed(system, Work(threads=1, checkpoint=checkpoint), SHORT, PIECES)
            checkpoint.discard()
            return found

        (kept, _), (plain, _) = (
            best({"kept": ways["1 thread"]}, kept_on_disk)["kept"],
            short["1 thread"],
        )
        print(f"kept on disk: {(kept - plain) / PIECES * 1e6:.0f} us more")


def timed(
    system: System,
    work: Work,
    settings: Settings,
    speeds: int,
    lyapunov: bool = False,
    ends: tuple[float, float] = DEFAULT,
) -> tuple[float, int]:
    """(seconds, impacts) of a sweep over so many speeds between two (rpm)."""
    rpms = rpm_grid(*ends, speeds)
    began = perf_counter()
    result = sweep(system, rpms, settings, impacts=False, lyapunov=lyapunov, work=work)
    return perf_counter() - began, result.cost.impacts


def best(ways: dict, measure) -> dict:
    """The least (seconds, impacts) of each way."""
    found: dict = {}
    for _ in range(REPEATS):
        for way, work in ways.items():
            result = measure(work)
            found[way] = min(found.get(way, result), result)
    return found


if __name__ == "__main__":
    main()
