"""The table of extreme cases: one test per row, the rows `cam bench stability` runs."""

import pytest

from camcli.analysis.bench.stability import OK, ROWS, measure
from camcli.api.bench import machines


@pytest.mark.parametrize("number", ROWS)
def test_row(number):
    outcome = measure(ROWS[number], machines())
    assert outcome.status == OK, outcome.observed


def test_every_numerical_row_is_there_once():
    assert list(ROWS) == [1, 2, 3, *range(5, 26)]
    assert all(row.case.startswith(f"{number}: ") for number, row in ROWS.items())
