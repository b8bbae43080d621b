"""The rows of the bench's table of precision: which points there are, and what is told of one."""

from __future__ import annotations

from math import isnan
from types import SimpleNamespace

import pytest

from camcli.analysis.bench import precision
from camcli.analysis.bench.peers import PeerImpact, PeerTrace
from camcli.analysis.bench.precision import (
    CORE,
    FAILED,
    GIVEN_UP,
    HEYOKA,
    INVENTED,
    MISSED,
    OK,
    OVER,
    RK4,
    MethodSetting,
    Point,
    case,
    compare,
    measure,
    points,
    repeated,
    run_core,
)
from camcli.api.bench import machines


def told(method: str, quick: bool) -> list[tuple[str, float]]:
    found = points([method], quick)
    assert {one.method for one in found} == {method}
    assert {one.peer is None for one in found} == {method == CORE}
    return [(one.setting, one.chatter) for one in found]


def test_the_points_of_each_method():
    """A peer closes a chatter at its own tolerance, but at 1e-9 turns at the closest."""
    exponents = range(3, 14, 2)
    tolerances = [float(f"1e-{n}") for n in exponents]
    ours = [(f"chatter 1e-{n:02}", float(f"1e-{n}")) for n in (*exponents, 15)]
    assert told(CORE, quick=False) == ours
    assert told(CORE, quick=True) == [ours[0], ("chatter 1e-08", 1e-8), ours[-1]]
    free = [(f"tol 1e-{n:02}", max(x, 1e-9)) for n, x in zip(exponents, tolerances, strict=True)]
    limited = [(f"{words} max_step 1/16 turn", chatter) for words, chatter in free]
    for method in ("rk45", "dop853", "radau"):
        assert told(method, quick=False) == [*free, *limited]
    halfway = ("tol 1e-08 max_step 1/16 turn", 1e-8)
    assert told("dop853", quick=True) == [free[0], ("tol 1e-08", 1e-8), free[-1], halfway]
    loose = ("tol 1e-06", 1e-6)
    assert told("radau", quick=True) == [free[0], loose, (f"{loose[0]} max_step 1/16 turn", 1e-6)]
    steps = told(RK4, quick=True)
    assert steps == [("100 steps per turn", 1e-8), ("1600 steps per turn", 1e-9)]
    assert len(points([CORE, "rk45"], quick=True)) == 3 + 4


def point(peer=None, chatter=1e-8) -> Point:
    """Of ours, or of a method that is written down here."""
    setting = MethodSetting(CORE if peer is None else "own", "as it is", chatter, peer)
    return Point("periodic", setting)


def trace_of(change=lambda hits: hits, given_up=False) -> PeerTrace:
    """The right impacts, changed."""
    some = case("periodic")
    right = run_core(machines().system(some.follower, some.cam), some, 1e-12)
    return PeerTrace(change(right.hits), right.rests, right.final, 77, given_up)


def test_a_row_of_ours_has_its_bound():
    row = measure(point(), machines=machines(), allowed=1.0, repeats=1)
    some = case("periodic")
    right = compare(some, trace_of(), 1e-8)
    assert (row.case, row.method, row.setting, row.status) == ("periodic", CORE, "as it is", OK)
    assert row.ours
    assert 0.0 < row.seconds < 10.0
    assert row.impacts == len(some.hits)
    assert row.evaluations > row.impacts
    assert (row.missed, row.extra) == (0, 0)
    assert (row.error, row.bound) == pytest.approx((right.error, right.bound))
    assert row.of_bound == pytest.approx(right.excess)
    assert row.error <= row.bound


@pytest.mark.parametrize(
    ("change", "given_up", "status", "missed", "extra"),
    [
        (lambda hits: hits, False, OK, 0, 0),
        (lambda hits: hits, True, GIVEN_UP, 0, 0),
        (lambda hits: hits[:5] + hits[7:], False, MISSED, 2, 0),
        (lambda hits: sorted([*hits, PeerImpact(3, 0.1, -1.0)]), False, INVENTED, 0, 1),
        (lambda hits: sorted([*hits[1:], PeerImpact(3, 0.1, -1.0)]), False, MISSED, 1, 1),
    ],
)
def test_a_row_of_a_peer(monkeypatch, change, given_up, status, missed, extra):
    """It promises no bound; a run that was given up is not repeated."""
    calls = []

    def run_peer(method, some, chatter, seconds):
        calls.append((chatter, seconds))
        return trace_of(change, given_up)

    monkeypatch.setattr(precision, "run_peer", run_peer)
    row = measure(point(peer=object(), chatter=1e-5), machines=machines(), allowed=0.5, repeats=2)
    assert (row.status, row.missed, row.extra) == (status, missed, extra)
    assert (row.method, row.evaluations, row.ours) == ("own", 77, False)
    assert row.impacts == len(trace_of(change).hits)
    assert isnan(row.bound)
    assert isnan(row.of_bound)
    assert row.seconds > 0.0
    assert calls[0] == (1e-5, 0.5)
    assert (len(calls) == 1) == (given_up or row.seconds >= precision.LONG)


@pytest.mark.parametrize("error", [ArithmeticError("step too small"), ValueError("no root")])
def test_a_run_that_fails_knows_nothing(monkeypatch, error):
    def run_peer(*asked):
        raise error

    monkeypatch.setattr(precision, "run_peer", run_peer)
    row = measure(point(peer=object()), machines=machines(), allowed=0.5, repeats=2)
    assert (row.status, row.impacts, row.evaluations) == (FAILED, 0, 0)
    assert isnan(row.seconds)
    assert isnan(row.error)


@pytest.mark.parametrize(("excess", "status"), [(1.0, OK), (1.0001, OVER), (float("nan"), OVER)])
def test_ours_may_not_be_off_by_more_than_it_promises(monkeypatch, excess, status):
    found = SimpleNamespace(missed=0, extra=0, error=1e-9, bound=1e-9, excess=excess)
    monkeypatch.setattr(precision, "compare", lambda *asked: found)
    row = measure(point(), machines=machines(), allowed=1.0, repeats=1)
    assert row.status == status


@pytest.mark.parametrize(
    ("first", "calls"), [(0.2, 0), (0.1999, 3), (0.005, 3), (0.00499, 21), (1e-6, 21)]
)
def test_short_runs_are_repeated_more_often(monkeypatch, first, calls):
    """Their median is told, and not the first time; a long run is not repeated."""
    clock = iter([x for k in range(calls) for x in (10.0 * k, 10.0 * k + (k % 3) + 1.0)])
    monkeypatch.setattr(precision, "perf_counter", lambda: next(clock))
    made = []
    assert repeated(lambda: made.append(1), 3, first) == (2.0 if calls else first)
    assert len(made) == calls


def test_a_method_that_is_not_installed_is_absent(monkeypatch):
    monkeypatch.setattr(precision, "find_spec", lambda name: None)
    one = Point("periodic", MethodSetting(HEYOKA, "tol 1e-08", 1e-8, None))
    row = measure(one, machines=machines(), allowed=1.0, repeats=1)
    assert (row.method, row.status) == (HEYOKA, precision.ABSENT)
    assert isnan(row.seconds)


@pytest.mark.parametrize(("method", "calls"), [
    (HEYOKA, [precision.COMPILING, 0.5]),
    ("rk45", [0.5]),
])  # fmt: skip
def test_compilation_is_not_timed(monkeypatch, method, calls):
    made = []

    def run_peer(peer, some, chatter, seconds):
        made.append(seconds)
        return trace_of(given_up=True)

    monkeypatch.setattr(precision, "run_peer", run_peer)
    monkeypatch.setattr(precision, "find_spec", lambda name: name)
    one = Point("periodic", MethodSetting(method, "tol 1e-08", 1e-8, object()))
    assert measure(one, machines=machines(), allowed=0.5, repeats=3).status == GIVEN_UP
    assert made == calls


def test_our_first_run_is_not_timed(monkeypatch):
    right, made = trace_of(), []
    monkeypatch.setattr(precision, "run_core", lambda *_: made.append(1) or right)
    measure(point(), machines=machines(), allowed=0.5, repeats=0)
    assert len(made) == 2
