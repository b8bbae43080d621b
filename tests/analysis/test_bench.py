"""The bench: our own bounds, the peers' care, the comparison, random flights, rows, and time."""

from dataclasses import dataclass, replace
from functools import partial
from math import inf, isnan, nan, pi

import numpy as np
import pytest

from camcli.analysis.bench import flights, precision, scenes, stability
from camcli.analysis.bench.lifts import lift_of
from camcli.analysis.bench.machine import STOPPED, reference
from camcli.analysis.bench.peers import Heyoka, RungeKutta4, SolveIvp, Trace
from camcli.analysis.bench.pieces import FAILED, NOT_REACHED, OK, measured
from camcli.analysis.bench.precision import case, compare, run_core, run_peer
from camcli.cli.bench_run import machines
from camcli.parallel import Work
from camcli.parallel.checkpoint import Checkpoint
from camcli.scene.bench import CASES, METHODS
from tests import oracle

# --- errors against the oracle's stored motions


def ours(name, tolerance=1e-13):
    some = case(name)
    return some, run_core(machines().system(some.follower, some.cam), some, tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8, 1e-13])
@pytest.mark.parametrize("name", CASES)
def test_our_errors_stay_within_their_bounds(name, tolerance):
    found = compare(*ours(name, tolerance), tolerance)
    assert found.missed == found.extra == 0
    assert found.excess <= 1.0, found


@pytest.mark.parametrize("name", ["periodic", "p3", "eccentric", "critical"])
def test_a_careful_peer_agrees_with_the_reference(name):
    some = case(name)
    trace = run_peer(SolveIvp("dop853", 1e-11, 1.0 / 16.0), some, 1e-9, 60.0)
    found = compare(some, trace)
    assert found.missed == found.extra == 0
    assert found.error < 1e-8
    assert trace.evaluations > 1000


def test_fixed_steps_converge_with_the_fourth_power():
    some = case("periodic")
    errors = [compare(some, run_peer(RungeKutta4(n), some, 1e-9)).error for n in (50, 100)]
    assert 12.0 < errors[0] / errors[1] < 20.0


@pytest.mark.parametrize("method", ["rk45", "lsoda", "radau"])
def test_every_method_bounces_and_sticks(method):
    some = case("chatter")
    trace = run_peer(SolveIvp(method, 1e-6, 1.0 / 16.0), some, 1e-6)
    assert len(trace.rests) == 2
    assert compare(some, trace).error < 0.05


@pytest.mark.parametrize("name", ["chatter", "eccentric"])
def test_the_taylor_integrator_is_exact(name):
    pytest.importorskip("heyoka")
    some = case(name)
    assert compare(some, run_peer(Heyoka(1e-13), some, 1e-9)).error < 1e-11


def test_a_run_ends_with_its_budget():
    some = case("chatter")
    assert run_peer(RungeKutta4(100), some, 1e-9, 0.0).given_up
    few = replace(some, hits=[])
    trace = run_peer(SolveIvp("rk45", 1e-3), replace(few, turns=40), 1e-9)
    assert trace.given_up
    assert len(trace.hits) == 201


def test_missed_and_invented_impacts_are_counted():
    some, trace = ours("periodic")
    less = replace(trace, hits=trace.hits[:7] + trace.hits[9:])
    more = replace(trace, hits=sorted([*trace.hits, (3, 0.1, -1.0)]))
    late = replace(trace, hits=[(p, x + 2e-6 * pi, u) for p, x, u in trace.hits])
    assert compare(some, less).missed == 2
    assert compare(some, more).extra == 1
    assert compare(some, Trace()).missed == len(some.hits)
    assert compare(some, late).error == pytest.approx(1e-6, rel=1e-6)
    assert compare(some, late).excess > 1.0


def test_impacts_that_a_chatter_map_replaces_are_not_missed():
    some, trace = ours("chatter", 1e-3)
    assert len(trace.hits) < len(some.hits)
    assert compare(some, trace, 1e-3).missed == 0
    lost = replace(trace, hits=trace.hits[:3] + trace.hits[4:])
    assert compare(some, lost, 1e-3).missed == 1


@pytest.mark.parametrize("name", ["periodic", "eccentric"])
def test_the_peers_cams_are_those_of_the_oracle(name):
    section = case(name).cam
    lift = lift_of(section)
    angles = np.linspace(0.0, 2.0 * pi, 200, endpoint=False)
    for theta in angles:
        law = lift.at(theta)
        if name == "periodic":
            assert law == pytest.approx([float(v) for v in oracle.ArcsCam().laws(theta)], abs=2e-14)
        else:
            half = 0.5 * section["lift"]
            c = section["base"] + half * (1.0 - np.cos(theta))
            assert law == pytest.approx((c, half * np.sin(theta), half * np.cos(theta)), abs=1e-15)
        assert lift.at(theta + 4.0 * pi)[0] == pytest.approx(law[0], abs=1e-14)


# --- points, rows and commands within their time


measure = partial(precision.measure, machines=machines(), most=0.25, repeats=1)


def test_points_are_measured_and_told():
    pieces = [("periodic", point) for point in precision.points(("core", "rk4"), True)]
    found = [row for piece in pieces for row in measure(piece, 60.0, 60.0)]
    assert [m.status for m in found] == [OK] * 5
    assert all(m.error <= m.bound for m in found if m.ours)
    (told,) = precision.verdicts(found)
    assert told.error_turns < 1e-12
    assert told.most_exact_other.startswith("rk4")


@pytest.mark.parametrize("quick", [True, False])
def test_every_method_has_its_points(quick):
    found = precision.points(METHODS, quick)
    assert {p.method for p in found} == set(METHODS)
    assert {p.max_turn for p in found if p.method == "radau"} == {inf, 1.0 / 16.0}
    assert len({(p.method, p.setting) for p in found}) == len(found)
    assert (len(found) < 30) == quick


def test_without_time_a_peer_gives_up_and_nothing_is_begun_after_the_end():
    (point, *_) = precision.points(("rk4",), True)
    (row,) = measure(("stiff", point), 0.0, 60.0)
    assert row.status == precision.GIVEN_UP
    (row,) = measure(("stiff", point), 60.0, 0.0)
    assert row.status == NOT_REACHED
    assert isnan(row.seconds)
    (row,) = stability.measure(stability.ROWS[1], machines(), 0.0)
    assert (row.status, row.observed) == (NOT_REACHED, "")
    (row,) = scenes.measure("cam --help", 3, 0.0, 0.0)
    assert row.status == NOT_REACHED
    (row,) = flights.fly_block(flights.Block(0, 5), machines(), 0.0)
    assert (row.asked, row.flights, row.status) == (5, 0, NOT_REACHED)


def test_long_calls_are_timed_once_where_time_is_short():
    calls = []
    assert precision.repeated(calls.append, 5, 0.1, 0.09) == 0.1
    assert calls == []
    assert precision.repeated(calls.append, 5, 0.1, inf) < 0.1
    assert len(calls) == 5


def test_a_command_is_repeated_while_its_share_lasts_and_stopped_at_its_limit(monkeypatch):
    assert scenes._run("cam --help", 1e-3)[1] == STOPPED
    runs, code = [], 0

    def ran(name, limit):
        runs.append(limit)
        return 2.0, code, 10, "numpy", 0.5

    monkeypatch.setattr(scenes, "_run", ran)
    (row,) = scenes.measure("detach", 5, 4.5, 9.0)
    assert (row.status, row.seconds, row.heavy, len(runs)) == (OK, 2.0, "numpy", 2)
    code = STOPPED
    assert scenes.measure("detach", 5, 1.0, 2.0)[0].status == NOT_REACHED
    assert runs[-1] <= 2.0 + scenes.GRACE
    assert scenes.measure("detach", 5, 1.0, 900.0)[0].status == FAILED
    pair = scenes.with_ratios([row, replace(row, seconds=3.0), scenes.Scene("late")])
    assert [s.ratio for s in pair][:2] == [1.0, 1.5]
    assert isnan(pair[2].ratio)


@dataclass(frozen=True)
class Kept:
    """A row of any table."""

    case: str
    status: str
    seconds: float = nan


def test_only_what_was_not_reached_is_measured_again(tmp_path):
    def run(found):
        asked, checkpoint = [], Checkpoint(tmp_path / "j", "bench")

        def measure(piece, share, left):
            asked.append(piece)
            assert 0.0 < share <= left <= 60.0
            return [Kept(f"case {piece}", found[piece])]

        rows = list(
            measured(Kept, measure, [1, 2, 3], Work(threads=1, checkpoint=checkpoint), 60.0)
        )
        checkpoint.close()
        return rows, asked

    first, asked = run({1: OK, 2: NOT_REACHED, 3: FAILED})
    assert asked == [1, 2, 3]
    rows, asked = run({2: OK})
    assert asked == [2]
    assert [row[0].status for row in rows] == [OK, OK, FAILED]
    assert rows[0][0].case == first[0][0].case


def test_a_row_that_fails_says_what_it_saw():
    def wrong(_):
        stability.need(False, "seven impacts")

    for check, said in ((wrong, "seven impacts"), (lambda _: 1 / 0, "ZeroDivisionError: division")):
        (outcome,) = stability.measure(stability.Row("1: a", "six", check), machines())
        assert outcome.status == FAILED
        assert outcome.observed.startswith(said)


def test_a_height_beyond_the_rounding_of_its_steps_fails_the_row(monkeypatch):
    rounding = 0.5 * 2.0**-54  # of heights from 0.25 to 0.5 m
    assert stability.height_limit(0) == 4.0 * rounding
    assert stability.height_limit(150) == pytest.approx((4.0 + 6.0 * 10.0) * rounding, rel=1e-12)
    monkeypatch.setattr(stability, "against_oracle", lambda m, name: (1e-14, 0.0, 150))
    assert stability.measure(stability.ROWS[7], machines())[0].status == FAILED


# --- random flights


def test_ours_misses_nothing_and_invents_nothing():
    (row,) = flights.fly_block(flights.Block(0, 60), machines())
    assert (row.flights, row.missed, row.invented) == (60, 0, 0)
    assert row.compared > 40


def test_blocks_are_whole_but_for_the_last():
    assert flights.blocks(0) == []
    blocks = flights.blocks(2 * flights.BLOCK + 5)
    assert [(b.seed, b.flights) for b in blocks] == [(0, 1000), (1, 1000), (2, 5)]
    total = flights.total([flights.Flights("core", 10, 9, 8), flights.Flights("core", 5, 5, 4)])
    assert (total.asked, total.flights, total.compared, total.status) == (15, 14, 12, NOT_REACHED)


def test_a_flight_is_the_same_however_many_are_asked_for(monkeypatch):
    def drawn(seed, count):
        seen = []
        decide = flights.verdict
        with monkeypatch.context() as patch:
            patch.setattr(flights, "verdict", lambda *a: seen.append(a[0]) or decide(*a))
            flights.fly_block(flights.Block(seed, count), machines())
        return [f[1:] for f in seen]

    assert drawn(3, 9)[:4] == drawn(3, 4)
    assert drawn(3, 4) != drawn(4, 4)


def test_a_contact_elsewhere_is_missed_or_invented():
    rng = np.random.default_rng(5)
    drawn = iter(partial(flights.random_flight, rng, machines()), None)
    f, found = next(
        (f, x) for f in drawn if flights.verdict(f, x := flights.first_impact(f))[0] == "right"
    )
    outcomes = [flights.verdict(f, x)[0] for x in (None, found + 0.1, found - 0.01)]
    assert outcomes == ["missed", "missed", "invented"]


def test_the_true_contact_is_the_oracles():
    """A start on the cam after an impact of the stored motion lands where the next one is."""
    some = case("p3")
    system, omega = machines().system(some.follower, some.cam), some.omega
    hits = [e for e in reference("p3")["events"] if e["kind"] == "impact"]
    before, after = hits[1], hits[2]
    theta, u = float(before["theta"]), -0.8 * float(before["u"])
    w = some.lift.at(theta)[1] + u / omega
    f = flights.Flight(system, some.rpm, theta * 180.0 / pi, 0.0, w, True)
    s = float(after["theta"]) - theta + 2.0 * pi * (after["turn"] - before["turn"])
    assert flights.verdict(f, s) == ("right", pytest.approx(s, abs=1e-13))
    assert flights.verdict(f, s + 1e-9)[0] == "missed"
