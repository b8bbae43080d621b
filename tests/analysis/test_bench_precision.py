"""The rows of the bench's table of precision: which points there are, and what is told of one."""

from __future__ import annotations

from decimal import Decimal
from math import isnan, nan, pi
from types import SimpleNamespace

import pytest

from camcli.analysis.bench import machine as machine_module
from camcli.analysis.bench import precision
from camcli.analysis.bench.peers import PeerImpact, PeerRest, PeerTrace
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
    Case,
    MethodSetting,
    Point,
    ReferenceEvent,
    case,
    compare,
    measure,
    points,
    repeated,
    run_core,
)
from camcli.analysis.bench.validation import COUNT, Claim, row_of
from camcli.analysis.integrate import ALL_FLOWN
from camcli.api.bench import machines
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.system import Follower, System


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
    assert set(calls[1:]) <= {(1e-5, precision.COMPILING)}  # what ended in time is not stopped then
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
    compared, compiled = [], []
    monkeypatch.setattr(precision, "compare", lambda *asked: compared.append(asked) or found)
    monkeypatch.setattr(precision.backend, "compiled", lambda: compiled.append(1))
    row = measure(point(), machines=machines(), allowed=1.0, repeats=1)
    assert row.status == status
    ((some, trace, tolerance),) = compared
    assert (some, len(trace.hits), tolerance) == (case("periodic"), row.impacts, 1e-8)
    assert compiled


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


TURN = 2.0 * pi
FOLLOWER = Follower(mass=2.0, stiffness=30.0, damping=4.0, restitution=0.7)
PLATE = {"kind": "eccentric", "base": 0.25, "lift": 0.0}


def test_how_a_stored_case_is_read(monkeypatch):
    """Nobody is asked for an impact less than a thousandth of a turn before an accumulation."""
    third = "1.333333333333333333333333333333"
    events = [
        {"kind": "impact", "turn": 0, "theta": third, "growth": 2.0},
        {"kind": "impact", "turn": 1, "theta": "2.0", "growth": 3.0},
        {"kind": "impact", "turn": 1, "theta": "2.001", "growth": 4.0},
        {"kind": "chatter", "turn": 1, "theta": "2.007", "growth": 5.0},
        {"kind": "impact", "turn": 1, "theta": "2.008", "growth": 6.0},
        {"kind": "detachment", "turn": 1, "theta": "2.5", "growth": 7.0},
        {"kind": "chatter", "turn": 2, "theta": "2.007", "growth": 8.0},
    ]
    stored = {
        "title": "one", "follower": vars(FOLLOWER), "cam": PLATE, "rpm": 77.0, "turns": 3,
        "start": {"q": 0.5, "v": -0.25}, "events": events,
        "final": {"q": "0.75", "v": "-1.5", "growth": 9.0},
    }  # fmt: skip
    monkeypatch.setattr(precision, "reference", lambda name: stored)
    some = case.__wrapped__("one")
    ulp = 2.0**-52
    assert [event.optional for event in some.hits] == [False, False, True, False]
    assert [event.bound for event in some.hits] == [8.0 * ulp * n for n in (2.0, 3.0, 4.0, 6.0)]
    assert [(event.turn, event.bound) for event in some.rests] == [(1, 40.0 * ulp), (2, 64.0 * ulp)]
    first = some.hits[0]
    assert (first.turn, first.theta) == (0, float(third))
    assert first.rest == float(Decimal(third) - Decimal(float(third))) != 0.0
    assert (some.turns, some.rpm, some.start) == (3, 77.0, (0.5, -0.25))
    assert some.final == (0.75, -1.5, 72.0 * ulp)


def reference_at(*ats, bound=1e-9, optional=False):
    """Events of a reference, so many turns after the start."""
    return [
        ReferenceEvent(int(at), at % 1.0 * TURN, 0.0, bound * (k + 1), optional)
        for k, at in enumerate(ats)
    ]


def made_up(hits, rests=()):
    return Case("one", FOLLOWER, PLATE, 60.0, 3, (None, None), hits, rests, (0.25, 0.0, 1e-3))


def seen_at(*hits, rests=(), given_up=False):
    """A run with events so many turns after the start."""
    return PeerTrace(
        [PeerImpact(int(at), at % 1.0 * TURN, -1.0) for at in hits],
        [PeerRest(int(at), at % 1.0 * TURN) for at in rests], None, 5, given_up,
    )  # fmt: skip


def test_the_largest_error_and_the_largest_share_of_a_bound():
    """They may be of two events: of bounds of 1e-9, 2e-9 and 3e-9 turns."""
    some = made_up(reference_at(0.1, 1.3, 2.6))
    found = compare(some, seen_at(0.1 + 4e-9, 1.3 - 7e-9, 2.6 + 9e-9))
    assert (found.error, found.bound) == pytest.approx((9e-9, 3e-9), rel=1e-5)
    assert found.excess == pytest.approx(4.0, rel=1e-5)
    assert (found.missed, found.extra) == (0, 0)
    late = some.hits[0]._replace(rest=1e-12 * TURN)  # of the phase, beside the double
    assert late.late(0, late.theta) == pytest.approx(-1e-12, rel=1e-9)


def test_an_impact_that_is_far_off_is_another_one():
    some = made_up(reference_at(0.1, 1.3))
    assert compare(some, seen_at(0.1, 1.345)).error == pytest.approx(0.045)
    found = compare(some, seen_at(0.1, 1.355))
    assert (found.missed, found.extra) == (1, 1)
    late = compare(some, seen_at(0.1, given_up=True))
    assert (late.missed, late.extra) == (0, 0)  # what would have come later


def test_what_a_chatter_map_replaces_lies_between_the_last_impact_and_the_accumulation():
    """Of two chatters; one accumulates 0.005 turns early, and an impact is found behind that."""
    rests = reference_at(0.43, 1.6, bound=1e-12)
    some = made_up(reference_at(0.1, 0.3, 0.35, 0.4, 0.7, 1.5, 1.55), rests)
    trace = seen_at(0.1, 0.3, 0.427, 1.5, rests=(0.425, 1.6 + 2e-4))
    found = compare(some, trace, tolerance=1e-2)
    assert found.missed == 1  # 0.7
    assert found.error == pytest.approx(0.027, rel=1e-6)  # of the impact that is found there
    without = compare(some, seen_at(0.1, 0.3, 1.5), tolerance=1e-2)
    assert without.missed == 4
    closer = compare(made_up(some.hits[:4], rests[:1]), seen_at(0.1, 0.3, rests=(0.425,)), 1e-2)
    assert (closer.missed, closer.extra) == (0, 0)
    assert closer.error == pytest.approx(0.005, rel=1e-9)
    assert closer.excess == pytest.approx(0.5, rel=1e-9)  # of the tolerance, and a rounding


def test_impacts_beside_an_accumulation_are_not_counted():
    """Neither missed nor invented; further off they are."""
    optional = reference_at(0.42, bound=1.0, optional=True)
    some = made_up([*reference_at(0.1), *optional], reference_at(0.8))
    assert compare(some, seen_at(0.1)).missed == 0
    beside = (0.4195, 0.4206, 0.7996, 0.8007)
    assert compare(some, seen_at(0.1, *beside)).extra == 0
    assert compare(some, seen_at(0.1, *beside, 0.4185, 0.8015)).extra == 2


def test_a_peer_is_given_the_motion_and_its_budget(monkeypatch):
    """Two hundred impacts, and twenty for each of the reference."""
    some = made_up(reference_at(0.1, 1.3, 2.6))
    given = []
    monkeypatch.setattr(precision.peers, "follow", lambda *asked: given.append(asked))
    monkeypatch.setattr(precision.peers, "process_time", lambda: 100.0)
    method = object()
    precision.run_peer(method, some, 1e-4, seconds=7.0)
    ((one, used, q, v),) = given
    assert (used, q, v) == (method, None, None)
    assert (one.most_impacts, one.deadline, one.turns) == (260, 107.0, 3)
    assert (one.r, one.k, one.b) == (0.7, 15.0, 2.0)
    assert (one.omega, one.chatter_s) == pytest.approx((TURN, 1e-4))
    assert one.lift.top == 0.25


def test_ours_flies_every_turn_as_the_others_do(monkeypatch):
    """And its rates are in rad: a velocity is omega times as large."""
    asked = []
    rows = [
        (IMPACT, 0, 1.5, 0.3, -0.25), (CHATTER, 1, 2.5, 0.3, 0.0), (DETACHMENT, 1, 3.5, 0.3, 0.0),
        (IMPACT, 2, 4.5, 0.3, -0.5),
    ]  # fmt: skip
    record = SimpleNamespace(events=lambda: rows, cost=SimpleNamespace(evaluations=9, impacts=2))

    def run(**how):
        asked.append(how)
        return record

    def started(system, rpm, record, **more):
        asked.append((system, rpm, record, more))
        return SimpleNamespace(run=run, position=lambda: (0.75, 2.0), omega=8.0)

    monkeypatch.setattr(precision, "orbit", started)
    some = case("periodic")
    trace = run_core("machine", some, 1e-5)
    start = {"tolerance": 1e-5, "q": some.start[0], "v": some.start[1]}
    assert asked == [
        ("machine", some.rpm, some.turns, start), {"strobes": False, "portions": ALL_FLOWN},
    ]  # fmt: skip
    assert trace.hits == [PeerImpact(0, 1.5, -2.0), PeerImpact(2, 4.5, -4.0)]
    assert trace.rests == [PeerRest(1, 2.5)]
    assert (trace.final, trace.evaluations, trace.given_up) == ((0.75, 16.0), 9, False)
    assert not ALL_FLOWN.copies_turns


def test_a_machine_of_the_bench_is_made_once_for_each_cam_and_strobe(monkeypatch):
    """The follower is that of the last call."""
    made = []

    def build(follower, shape, strobe):
        made.append((shape, strobe))
        return System.__new__(System)

    monkeypatch.setattr(machine_module.System, "build", build)
    monkeypatch.setattr(
        machine_module, "replace", lambda system, follower: (made[-1], follower.mass)
    )
    bench = machine_module.Machines(lambda section: section["name"])
    light, heavy = Follower(mass=1.0, stiffness=2.0), Follower(mass=3.0, stiffness=2.0)
    one, other = {"name": "one", "base": 0.1}, {"base": 0.1, "name": "one"}
    assert bench.system(light, one) == (("one", 0.0), 1.0)
    assert bench.system(heavy, other) == (("one", 0.0), 3.0)
    assert bench.system(heavy, one, 0.5) == (("one", 0.5), 3.0)
    bench.system(light, {**one, "name": "two"})
    assert made == [("one", 0.0), ("one", 0.5), ("two", 0.0)]


def test_a_number_that_is_none_or_a_count_that_is_off_has_failed():
    """A count is exact, whatever is known of it elsewhere."""
    told = {"source": "who", "problem": "scene", "seconds": 0.0}
    ours = Claim("x", "there", published="1.36", ours=nan, error=1e-3)
    assert row_of(ours, **told).status == FAILED
    count = Claim("n", "there", published="5", ours=5.1, error=0.2, independent="5", kind=COUNT)
    assert row_of(count, **told).status == FAILED
    near = Claim("x", "there", published="1.36", ours=1.365, error=0.0)  # by a rounding
    assert row_of(near, **told).status == OK
