"""Absurd sizes are refused with the figure, before anything is allocated or run."""

from __future__ import annotations

import time
import tracemalloc

import pytest

from tests.hostile.bounds import command_line

REFUSED = [
    ("basins --cells 1000000000000", "--cells: basins.cells: found '1000000000000', expected N or"),
    ("basins --cells 0", "--cells: basins.cells: found '0', expected N or NQ,NV, whole num"),
    ("basins --cells -3", "found '-3', expected N or NQ,NV, whole numbers from 1 to 16384"),
    ("basins --cells 5,0", "found '5,0', expected N or NQ,NV, whole numbers from 1 to 16384"),
    ("basins --cells 5,5,5", "found '5,5,5', expected N or NQ,NV"),
    ("basins --cells ٣", "found '٣', expected N or NQ,NV"),
    ("basins --cells 1_0", "found '1_0', expected N or NQ,NV"),
    ("basins --cells nan", "found 'nan', expected N or NQ,NV"),
    ("basins --cells true", "found 'true', expected N or NQ,NV"),
    ("basins --cells 16384,16384 --refine 10", "16384"),
    ("basins --q 1:0", "--q: basins.q: found [1, 0], expected [low, high], two different ends"),
    ("basins --q 1:1", "found [1, 1], expected [low, high], two different ends, give a window of"),
    ("basins --q nan:1", "--q: basins.q.0: found nan, expected a finite number"),
    ("basins --v 1e400:3", "--v: basins.v.0: found inf, expected a finite number"),
    ("basins --q 1_0:2_0", "--q: found '1_0:2_0', expected LO:HI, two numbers"),
    ("basins --q true:2", "--q: found 'true:2', expected LO:HI, two numbers"),
    ("basins --points 0 --rpm 1:2", "--points: basins.rpm.num: found 0, expected a number of at least 1"),
    ("sweep --points 1000000000", "sweep.rpm.num: found 1000000000, expected a number of at most 1000"),
    ("sweep --points 10000000", "10000000"),
    ("sweep --points 0", "--points: sweep.rpm.num: found 0, expected a number of at least 1"),
    ("sweep --set run.transient=1000000000000000", "expected a number of at most 1000000000"),
    ("sweep --set run.record=1000000000", "1000000000"),
    ("sweep --threads 1000000000", "--threads: found 1000000000, expected 1 or more, at most 4096"),
    ("sweep --threads 0", "--threads: found 0, expected 1 or more, at most 4096"),
    ("figures --threads 1000000000", "--threads: found 1000000000, expected 1 or more, at most"),
    ("simulate --points 1000000000", "--points: simulate.samples: found 1000000000, expected a"),
    ("simulate --set run.record=1000000000", "1000000000"),
    ("orbits --points 1000000000", "orbits.rpm.num: found 1000000000, expected a number of at most 100"),
    ("orbits --set orbits.starts=1000000000", "orbits.starts: found 1000000000, expected a number of at most 100"),
    ("orbits --branches 1000000000", "--branches: orbits.branches: found 1000000000, expected"),
    ("classify --points 10000000 --starts 1000000", "found 10000000 speeds x 1000001 starts, 1000"),
    ("bench --flights 1000000000", "bench.flights: found 1000000000, expected a number of at most 10"),
    ("sweep --explain --points 1", "--explain: sweep.rpm: found one speed, 660.0, expected a"),
    ("simulate --set follower.mass=1e300", "found 1e300, expected a number of at most 1e+15"),
    ("simulate --set run.start.v=1e300", "found 1e300, expected a number of at most 1000000000000"),
    (f"sweep --points {'9' * 5000}", "--points"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "words"), REFUSED, ids=[line[:50] for line, _ in REFUSED])
def test_an_absurd_size_is_refused_at_once(line, words):
    command_line(["schema"])  # what has to be imported once
    command_line([line.split()[0], "--dry-run", "--threads", "0"])
    tracemalloc.start()
    began = time.process_time()
    code, said = command_line(line.split())  # not --dry-run: it must not come to running
    seconds = time.process_time() - began
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert code == 2, said
    assert words in said
    assert seconds < 1
    assert peak < 20e6


@pytest.mark.parametrize(
    "line",
    ["sweep --rpm 760:660", "sweep --rpm 700:700", "sweep --points 1", "basins --cells 1",
     "sweep --threads 4096 --points 1", "simulate --set run.start.theta_deg=-1e9"],
)  # fmt: skip
def test_what_is_only_odd_is_planned(line):
    code, said = command_line([*line.split(), "--dry-run", "--set", "run.record=1"])
    assert code == 0, said
