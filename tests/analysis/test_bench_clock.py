"""The time of the bench: clocks, what follows what, and that the parts fit into the promise."""

from math import inf
from time import monotonic

import pytest

from camcli.analysis.bench import budget, scenes
from camcli.analysis.bench.clock import NOT_REACHED, Clock, Schedule
from camcli.cli.bench_run import PIECES, Plan
from camcli.scene.bench import Bench

PARTS = tuple(PIECES)


def test_a_clock_shares_what_is_left():
    assert Clock().share(7) == inf
    assert not Clock().over
    clock = Clock(monotonic() + 100.0)
    assert clock.share(10) == pytest.approx(10.0, abs=0.1)
    assert clock.share(0) == pytest.approx(100.0, abs=1.0)
    past = Clock(monotonic() - 1.0)
    assert (past.left(), past.share(3), past.over) == (0.0, 0.0, True)


def test_parts_inherit_what_is_left_and_lend_nothing():
    began = monotonic()
    schedule = Schedule({"a": 5.0, "b": 7.0}, began)
    assert schedule.clock("a").until == began + 5.0
    assert schedule.clock("b").until == began + 12.0


def test_a_part_without_end_takes_nothing_from_the_others(monkeypatch):
    now = [100.0]
    monkeypatch.setattr("camcli.analysis.bench.clock.monotonic", lambda: now[0])
    schedule = Schedule({"a": 5.0, "b": inf, "c": 7.0}, 100.0)
    assert schedule.clock("a").until == 105.0
    now[0] = 103.0
    assert schedule.clock("b").until == inf
    now[0] = 1103.0
    assert schedule.clock("c").until == 1112.0


@pytest.mark.parametrize(("quick", "promised"), [(False, 600.0), (True, 60.0)])
def test_the_parts_fit_into_the_promise(quick, promised):
    plan = Plan(Bench(quick=quick), PARTS)
    assert set(plan.seconds) == set(budget.FULL) == set(budget.QUICK)
    assert sum(plan.seconds.values()) <= promised - max(5.0, 0.05 * promised)
    assert {name: entry["seconds"] for name, entry in plan.table().items()} == plan.seconds


def test_only_flights_asked_for_are_without_end():
    assert Plan(Bench(flights=201), PARTS).seconds[budget.FLIGHTS] == inf
    table = Plan(Bench(flights=10**6), PARTS).table()
    assert 600.0 < table[budget.FLIGHTS]["seconds"] < 60000.0
    assert Plan(Bench(flights=10**6, quick=True), PARTS).flights == 100
    assert Plan(Bench(flights=10**6, quick=True), PARTS, True).flights == 10**6


def test_commands_are_repeated_while_their_share_lasts(monkeypatch):
    monkeypatch.setattr(scenes, "_run", lambda words, limit: (2.0, (0, 10, ["numpy"], 0.5)))
    task = scenes.Task("a", ("x",), 5, 2)
    assert scenes.measure_scene(task, Clock()).seconds == 2.0
    runs = []
    monkeypatch.setattr(scenes, "_run", lambda *w: runs.append(1) or (2.0, (3, 10, [], None)))
    found = scenes.measure_scene(task, Clock(monotonic() + 9.0))
    assert (len(runs), found.status, found.code) == (2, scenes.FAILED, 3)
    late = scenes.measure_scene(task, Clock(0.0))
    assert (len(runs), late.status) == (2, NOT_REACHED)
    assert scenes.ratios([late])[0] != scenes.ratios([late])[0]


def test_a_command_that_the_clock_stops_is_not_reached(monkeypatch):
    limits = []

    def stopped(words, limit):
        limits.append(limit)
        return limit, (scenes.STOPPED, 0, [], None)

    monkeypatch.setattr(scenes, "_run", stopped)
    task = scenes.Task("a", ("x",), 5, 2)
    assert scenes.measure_scene(task, Clock(monotonic() + 2.0)).status == NOT_REACHED
    assert limits[0] <= 2.0 + scenes.GRACE
    assert scenes.measure_scene(task, Clock()).status == scenes.FAILED
    assert limits[1] == scenes.LONGEST


def test_a_process_beyond_its_limit_is_stopped():
    _, (code, *_) = scenes._run(("--help",), 1e-3)
    assert code == scenes.STOPPED


def test_a_quick_plan_is_a_subset_with_every_kind_of_command():
    full, quick = scenes.plan(3, False), scenes.plan(1, True)
    assert {t.name for t in quick} == set(scenes.QUICK) < {t.name for t in full}
    assert [t.left for t in quick] == [5, 4, 3, 2, 1]
