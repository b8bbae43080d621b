"""Rows of extreme cases as outcomes; the rows themselves are run in tests/extremes."""

from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import FAILED, OK, Row, need
from camcli.analysis.bench.stability import stability


def test_a_row_that_fails_says_what_it_saw():
    def wrong(_):
        need(False, "seven impacts")

    def broken(_):
        return 1 / 0

    rows = [
        Row("1: a", "six", wrong),
        Row("2: b", "six", broken),
        Row("3: c", "six", lambda _: "6"),
    ]
    seen = []
    outcomes = list(stability(Bench(list, list), rows, lambda: seen.append(1)))
    assert [o.status for o in outcomes] == [FAILED, FAILED, OK]
    assert [o.observed for o in outcomes] == [
        "seven impacts", "ZeroDivisionError: division by zero", "6",
    ]  # fmt: skip
    assert len(seen) == 3
