"""Work and precision: our own bound in every case, comparisons, budgets, and the peers' care."""

import pickle
from dataclasses import replace
from functools import partial
from math import inf, isnan, nan, pi
from time import monotonic

import pytest

from camcli.analysis.bench import methods
from camcli.analysis.bench import precision as precision_module
from camcli.analysis.bench.cases import OPTIONAL, case
from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.compare import compare
from camcli.analysis.bench.machine import Bench
from camcli.analysis.bench.peers import core, rk4, solve_ivp
from camcli.analysis.bench.peers.lifts import lift_of
from camcli.analysis.bench.peers.world import Trace
from camcli.analysis.bench.precision import (
    GIVEN_UP,
    OK,
    OVER,
    Measured,
    failures,
    measure_point,
    plan,
    precision,
)
from camcli.analysis.bench.verdicts import verdicts
from camcli.cli.bench_runs import parts_of
from camcli.scene.bench import CASES, METHODS
from tests import oracle


@pytest.fixture(scope="module")
def bench():
    return Bench(parts_of, lambda words: None)


def ours(bench, name, tolerance=1e-13):
    some = case(name)
    return some, core.run(some.system(bench), some.rpm, some.start, some.turns, tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8, 1e-13])
@pytest.mark.parametrize("name", CASES)
def test_our_errors_stay_within_their_bounds(bench, name, tolerance):
    some, trace = ours(bench, name, tolerance)
    found = compare(some, trace, tolerance)
    assert found.missed == found.extra == 0
    assert found.excess <= 1.0, found


@pytest.mark.parametrize("name", ["periodic", "p3", "eccentric", "critical"])
def test_a_careful_peer_agrees_with_the_reference(name):
    some = case(name)
    world = methods.world_of(some, 60.0, 1e-9)
    trace = solve_ivp.run(world, some.start, "dop853", 1e-11, 1.0 / 16.0)
    found = compare(some, trace)
    assert found.missed == found.extra == 0
    assert found.error < 1e-8
    assert trace.evaluations > 1000


def test_fixed_steps_converge_with_the_fourth_power():
    some = case("periodic")
    errors = [
        compare(some, rk4.run(methods.world_of(some, 60.0, 1e-9), some.start, n)).error
        for n in (50, 100)
    ]
    assert 12.0 < errors[0] / errors[1] < 20.0


@pytest.mark.parametrize("method", ["rk45", "lsoda", "radau"])
def test_every_method_bounces_and_sticks(method):
    some = case("chatter")
    trace = solve_ivp.run(methods.world_of(some, 60.0, 1e-6), some.start, method, 1e-6, 1 / 16)
    assert len(trace.rests) == 2
    assert compare(some, trace).error < 0.05


def test_a_run_ends_with_its_budget():
    some = case("chatter")
    assert rk4.run(methods.world_of(some, 0.0, 1e-9), some.start, 100).given_up
    world = methods.world_of(some, 60.0, 1e-9)
    world.most_impacts = 5
    assert rk4.run(world, some.start, 100).given_up
    assert len(world.trace.hits) == 6


def test_missed_and_invented_impacts_are_counted(bench):
    some, trace = ours(bench, "periodic")
    less = Trace(hits=trace.hits[:7] + trace.hits[9:], final=trace.final)
    more = Trace(hits=sorted([*trace.hits, (3, 0.1, -1.0)]), final=trace.final)
    assert compare(some, less).missed == 2
    assert compare(some, more).extra == 1
    assert compare(some, Trace()).missed == len(some.hits)
    late = Trace(hits=[(p, x + 2e-6 * pi, u) for p, x, u in trace.hits], final=trace.final)
    assert compare(some, late).error == pytest.approx(1e-6, rel=1e-6)
    assert compare(some, late).excess > 1.0


def test_impacts_that_a_chatter_map_replaces_are_not_missed(bench):
    some, trace = ours(bench, "chatter", 1e-3)
    assert len(trace.hits) < len(some.hits)
    assert compare(some, trace, 1e-3).missed == 0
    lost = Trace(trace.hits[:3] + trace.hits[4:], trace.rests, trace.final)
    assert compare(some, lost, 1e-3).missed == 1
    assert sum(mark.optional for mark in some.hits) > 20
    assert OPTIONAL == 1e-3


@pytest.mark.parametrize("name", ["periodic", "eccentric"])
def test_the_peers_cams_are_those_of_the_oracle(name):
    section = case(name).data["cam"]
    lift = lift_of(section)
    exact = oracle.ArcsCam()
    for k in range(200):
        theta = 2.0 * pi * k / 200.0
        law = lift.law(lift.region(theta), theta)
        if name == "periodic":
            wanted = [float(x) for x in exact.laws(theta)]
            assert law == pytest.approx(wanted, abs=2e-14)
        assert lift.height(theta + 4.0 * pi) == pytest.approx(law[0], abs=1e-14)


def test_points_of_a_run(bench):
    work = plan(("periodic",), ("core", "rk4"), True, 1)
    seen = []
    found = list(precision(work, bench, on_point=lambda: seen.append(1)))
    assert len(found) == len(work) == len(seen) == 5
    assert all(m.status == OK for m in found)
    assert all(m.error <= m.bound for m in found if m.ours)
    (told,) = verdicts(found)
    assert told.ours.method == "core"
    assert told.best.method == "rk4"


@pytest.mark.parametrize("quick", [True, False])
def test_a_plan_has_every_case_and_method_in_plain_values(quick):
    work = plan(CASES, METHODS, quick, 3)
    assert {(t.case, t.point.method) for t in work} == {(c, m) for c in CASES for m in METHODS}
    assert {t.point.limit for t in work if t.point.method == "radau"} == {inf, 1.0 / 16.0}
    assert [t.left for t in work] == list(range(len(work), 0, -1))
    assert len({(t.case, t.point.method, t.point.setting) for t in work}) == len(work)
    assert pickle.loads(pickle.dumps(work)) == work
    assert all(isinstance(x, str | float) for t in work for x in vars(t.point).values())


def test_a_measured_point_does_not_depend_on_the_process(bench):
    task = plan(("periodic",), ("core",), True, 1)[0]
    away = pickle.loads(pickle.dumps(partial(measure_point, bench=Bench(parts_of, print))))
    other, own = (f(task, clock=Clock()) for f in (away, partial(measure_point, bench=bench)))
    timed = ("seconds", "first_call_s")
    assert [v for k, v in vars(other).items() if k not in timed] == [
        v for k, v in vars(own).items() if k not in timed
    ]


def test_a_peer_without_time_is_given_up(bench):
    (task,) = plan(("stiff",), ("rk4",), True, 1)[:1]
    point = measure_point(replace(task, most=0.0), bench, Clock())
    assert point.status == GIVEN_UP
    assert isnan(point.error) or point.error >= 0.0


def test_what_is_left_is_shared_by_the_points_that_are_left(bench):
    (task,) = plan(("stiff",), ("rk4",), True, 1)[:1]
    point = measure_point(replace(task, most=60.0, left=10**9), bench, Clock(monotonic() + 60.0))
    assert point.status == GIVEN_UP


def test_points_after_the_end_are_not_reached(bench):
    work = plan(("periodic",), ("core", "rk4"), True, 1)
    found = list(precision(work, bench, Clock(0.0)))
    assert {m.status for m in found} == {NOT_REACHED}
    assert len(failures(found)) == 3
    assert all(isnan(m.seconds) for m in found)


def test_long_calls_are_timed_once_where_time_is_short():
    calls = []
    first = precision_module._repeated(lambda s: calls.append(s), 5, 0.1, 0.09)
    assert (first, calls) == (0.1, [])
    assert precision_module._repeated(lambda s: calls.append(s), 5, 0.1, inf) < 0.1
    assert len(calls) == 5


def test_a_broken_promise_is_a_failure():
    data = ("p3", "core", "tol", 1.0, 1e-9, 8, 20, 0, 0, 0.1, 1e-12, 1e3)
    bad = Measured(*data, OVER)
    theirs = Measured("p3", "rk4", "100", 1.0, inf, 0, 0, 9, 0, 0.1, nan, nan, OVER)
    assert failures([bad, theirs]) == [bad]
