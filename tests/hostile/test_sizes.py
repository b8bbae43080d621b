"""Absurd sizes are refused with the figure, before anything is allocated or run."""

from __future__ import annotations

import tracemalloc

import pytest

from tests.support.bounds import command_line

REFUSED = [
    ("basins --cells 1000000000000", "--cells: basins.cells.0: found 1000000000000, expected a"),
    ("basins --cells 5,0", "--cells: basins.cells.1: found 0, expected a number of at least 1"),
    ("basins --cells 16384,16384 --refine 10", "16384"),
    ("basins --points 0 --rpm 1:2", "--points: basins.rpm.num: found 0, expected a number of at"),
    ("sweep --points 1000000000", "--points: sweep.rpm.num: found 1000000000, expected a number"),
    ("sweep --points 10000000", "10000000"),
    ("sweep --set run.transient=1000000000000000", "found 1000000000000000, expected a number of"),
    ("sweep --threads 1000000000", "--threads: found 1000000000, expected 1 or more, at most 4096"),
    ("simulate --set run.record=1000000000", "1000000000"),
    ("orbits --branches 1000000000", "--branches: orbits.branches: found 1000000000, expected"),
    ("classify --points 10000000 --starts 1000000", "found 10000000 speeds x 1000001 starts, 1000"),
    (f"sweep --points {'9' * 5000}", "--points"),
]


@pytest.fixture(scope="module", autouse=True)
def _imported():
    """What has to be imported once is not counted."""
    for command in ("basins", "sweep", "simulate", "orbits", "classify"):
        command_line([command, "--dry-run", "--threads", "0"])
    command_line(["sweep", "--dry-run", "--points", "1", "--set", "run.record=1"])


@pytest.mark.parametrize(("line", "words"), REFUSED, ids=[line[:50] for line, _ in REFUSED])
def test_an_absurd_size_is_refused_at_once(line, words):
    tracemalloc.start()
    code, said = command_line(line.split())  # not --dry-run: it must not come to running
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert code == 2, said
    assert words in said
    assert peak < 20e6
