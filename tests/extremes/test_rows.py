"""The table of extreme cases: one test per row, the rows `cam bench stability` runs."""

import pytest

from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import OK, measure
from camcli.analysis.bench.stability import ROWS
from camcli.cli.bench_runs import command, parts_of


@pytest.fixture(scope="module")
def bench():
    return Bench(parts_of, command)


@pytest.mark.parametrize("row", ROWS, ids=[row.case for row in ROWS])
def test_row(row, bench):
    outcome = measure(row, bench)
    assert outcome.status == OK, outcome.observed


def test_every_numerical_row_is_there_once():
    numbers = [int(row.case.split(":")[0]) for row in ROWS]
    assert numbers == [1, 2, 3, *range(5, 26)]
