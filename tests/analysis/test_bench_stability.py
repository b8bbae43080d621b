"""Rows of extreme cases as outcomes; the rows themselves are run in tests/extremes."""

import pickle

from camcli.analysis.bench import stability
from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.row import FAILED, OK, Row, need
from camcli.analysis.bench.rows import damping


def test_a_row_that_fails_says_what_it_saw(monkeypatch):
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
    monkeypatch.setattr(stability, "ROWS", tuple(rows))
    bench, wanted = Bench(list, list), stability.numbers()
    outcomes = list(stability.stability(bench, wanted, on_row=lambda: seen.append(1)))
    assert [o.status for o in outcomes] == [FAILED, FAILED, OK]
    assert [o.observed for o in outcomes] == [
        "seven impacts", "ZeroDivisionError: division by zero", "6",
    ]  # fmt: skip
    assert len(seen) == 3
    late = list(stability.stability(bench, wanted, Clock(0.0)))
    assert [(o.case, o.status) for o in late] == [(r.case, NOT_REACHED) for r in rows]


def test_rows_can_be_sent_elsewhere():
    away = pickle.loads(pickle.dumps(stability.ROWS))
    assert [row.case for row in away] == [row.case for row in stability.ROWS]
    assert len(set(stability.numbers())) == len(stability.ROWS) == 24


def test_the_limit_of_a_height_grows_with_the_root_of_the_steps():
    rounding = 0.5 * 2.0**-54  # of heights from 0.25 to 0.5 m
    assert damping.height_limit(0) == 4.0 * rounding
    more, less = (damping.height_limit(n) - damping.height_limit(0) for n in (600, 150))
    assert abs(more / less - 2.0) < 1e-12
    assert abs(less - 6.0 * 10.0 * rounding) < 1e-28


def test_a_height_beyond_its_limit_fails_the_row(monkeypatch):
    monkeypatch.setattr(damping, "_against_oracle", lambda bench, name: (1e-14, 0.0, 150))
    (row,) = [row for row in damping.ROWS if row.case.startswith("7:")]
    assert stability.measure(row, Bench(list, list)).status == FAILED
