"""Cost of an impact, scaling over threads and Dask processes, and what a piece costs besides.

Run it by hand on a quiet machine: `python tests/bench/bench_scale.py` (extra `cluster`). All ratios
are of times measured in one run, the least of REPEATS, interleaved.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import rpm_grid, sweep
from camcli.kernel import backend
from camcli.parallel import Work
from camcli.parallel.checkpoint import Checkpoint
from camcli.parallel.dask_cluster import LOCAL, DaskCluster
from camcli.scene import load_scene
from camcli.system import Follower, System

REPEATS = 3
LONG = Settings(40_000, 100, 1e-9, 1_000_000)  # turns of a speed: the kernel is all that matters
SHORT = Settings(0, 1, 1e-9, 1_000_000)  # one turn: what a piece costs besides
SPEEDS, PIECES = 200, 4_000


def main() -> None:
    scene = load_scene(None)
    system = System.build(Follower(**scene.follower.model_dump()), scene.cam)
    backend.compiled()
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        ways = {"1 thread": Work(threads=1), "2 threads": Work(threads=2)}
        for n in (1, 2, 4):
            cluster = stack.enter_context(DaskCluster(LOCAL, n))
            ways[f"{n} Dask process{'es' if n > 1 else ''}"] = Work(cluster=cluster)
        for work in ways.values():  # load the kernel everywhere
            timed(system, work, LONG, 20)
        strong = best(ways, lambda work: timed(system, work, LONG, SPEEDS))
        seconds, impacts = strong["1 thread"]
        each = seconds / impacts * 1e9
        print(f"one thread: {impacts} impacts in {seconds:.2f} s, {each:.0f} ns each")
        print(f"10^12 impacts on one thread: {seconds / impacts * 1e12 / 86400:.1f} days")
        for way, (took, _) in strong.items():
            print(f"strong, {way}: {seconds / took:.2f} times as fast")
        half = best({"half": ways["1 thread"]}, lambda work: timed(system, work, LONG, SPEEDS // 2))
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


def timed(system: System, work: Work, settings: Settings, speeds: int) -> tuple[float, int]:
    """(seconds, impacts) of a sweep."""
    began = perf_counter()
    result = sweep(system, rpm_grid(660.0, 760.0, speeds), settings, impacts=False, work=work)
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
