"""A branch with multipliers and events against brute force: `python tests/bench/bench_orbits.py`.

Both ways of looking at 673.3 to 756 rpm are timed in turns in one process: 200 points of the stable
P(1;1) followed, certified and with multipliers, and 200 speeds simulated for 300 turns each. Run it
with CAMCLI_KERNEL=python and CAMCLI_KERNEL=compiled.
"""

import os
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[2]))

from camcli.analysis.grid import rpm_grid
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.branch_segment import both_ways
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.sweep import sweep
from camcli.parallel import Work
from tests.conftest import chapter_system, settings

POINTS, TURNS, REPEATS = 200, 300, 5
LOW, HIGH = 673.3, 756.0


def branch(system) -> int:
    """Follow the stable branch; the number of points."""
    shooter = Shooter(system, 700.0)
    root = single_impact_roots(shooter, 700.0, 1)[1]
    legs = both_ways(shooter, root, Span(LOW, HIGH, (HIGH - LOW) / (POINTS - 20)))
    return sum(len(leg.points) for leg in legs)


def brute(system) -> int:
    """Simulate without logging impacts, one thread."""
    run = settings(transient=TURNS - 100, record=100)
    result = sweep(system, rpm_grid(LOW, HIGH, POINTS), run, impacts=False, work=Work(threads=1))
    return len(result.speeds)


def main() -> None:
    """Print the ratio."""
    system = chapter_system()
    points, _ = branch(system), brute(system)
    times = {branch: [], brute: []}
    for _ in range(REPEATS):
        for job, taken in times.items():
            began = perf_counter()
            job(system)
            taken.append(perf_counter() - began)
    a, b = (median(taken) for taken in times.values())
    kernel = os.environ.get("CAMCLI_KERNEL", "auto")
    print(
        f"kernel {kernel}: {points} points of a branch {a * 1e3:.1f} ms, {POINTS} speeds x {TURNS}"
    )
    print(f"turns {b * 1e3:.1f} ms; branch over brute force {a / b:.3f}")


if __name__ == "__main__":
    main()
