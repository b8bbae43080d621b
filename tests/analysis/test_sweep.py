"""Sweeps: directions, sections, independence of threads and order."""

from itertools import pairwise
from types import SimpleNamespace

import pytest
from conftest import settings

from camcli.analysis import sweep as module
from camcli.analysis.classify import classify_at
from camcli.analysis.grid import rpm_grid
from camcli.analysis.orbits.same_orbit import distance_to
from camcli.analysis.patience import forgets_too_much
from camcli.analysis.sweep import sweep
from camcli.errors import Status
from camcli.system import omega_of


def test_grid_hits_both_ends():
    grid = rpm_grid(660.0, 760.0, 401)
    assert (grid[0], grid[-1], len(grid)) == (660.0, 760.0, 401)
    assert rpm_grid(3.0, 1.0, 3) == [3.0, 2.0, 1.0]
    assert rpm_grid(5.0, 9.0, 1) == [5.0]


def test_an_orbit_still_settling_is_named_after_it(chapter):
    """Stable up to the doubling at 739.3198 rpm: a multiplier near -1, or a record too short."""
    for rpm, turns in ((700.0, (30, 20)), (739.3164, (600, 400))):
        named = [sweep(chapter, [rpm], settings(*turns), lyapunov=on).speeds[0] for on in (0, 1)]
        assert [speed.label for speed in named] == ["P(1;1)", "P(1;1)"]
        assert named[0].exponent is None
        assert named[1].exponent < 0.0


@pytest.mark.slow
def test_after_a_chatter_the_motion_is_the_machines_not_one_of_rounding(chapter):
    """Labels and points of 357.8 to 359.6 rpm, where a fifth of the records close by accident."""
    run = settings(600, 130)
    found = sweep(chapter, rpm_grid(357.8, 359.6, 361)[3::36], run)
    assert {s.label for s in found.speeds} > {"P(3;3:3:2)"}
    for speed in found.speeds:
        motion = classify_at(chapter, speed.rpm, run)
        assert speed.label == motion.label
        omega = omega_of(speed.rpm)
        for q, v in zip(*speed.strobe[1:3], strict=True):
            assert distance_to((q, v / omega), motion.orbit.states) < 1e-3


def test_a_record_with_rests_that_are_no_cycle_is_replaced_by_the_motion(chapter):
    """At 357.82 rpm doubles go through rests for ever; the orbit has none."""
    (speed,) = sweep(chapter, [357.82], settings(600, 100)).speeds
    assert (speed.label, sum(speed.strobe[4])) == ("P(3;3:3:2)", 0)


def test_an_adaptive_sweep_adds_speeds_where_the_motion_changes(chapter):
    """From rest P(1;1) begins near 682.2 rpm: steps there are finer than a column."""
    coarse = rpm_grid(680.0, 730.0, 6)
    found = sweep(chapter, coarse, settings(100, 30), adaptive=True)
    rpms = [s.rpm for s in found.speeds]
    assert rpms == sorted(rpms)
    assert set(coarse) < set(rpms)
    steps = [(b.rpm - a.rpm, a.label == b.label) for a, b in pairwise(found.speeds)]
    assert max(step for step, same in steps if not same) <= 50.0 / 1200
    assert max(step for step, same in steps if same) >= 5.0


@pytest.mark.parametrize(("chatters", "forgets"), [(0, False), (3, False), (2, True), (1, True)])
def test_a_rest_forgets_where_other_turns_have_none(chatters, forgets):
    record = SimpleNamespace(chatters=chatters, periods=3, status=Status.OK)
    assert forgets_too_much(record) == forgets
    record.status = Status.IMPACT_BUDGET
    assert not forgets_too_much(record)


@pytest.mark.parametrize("carried", [True, False])
def test_a_motion_is_watched_on_from_where_it_began(monkeypatch, carried):
    """In a sweep that is carried on that is the end of the motion at the speed before."""
    bare = [SimpleNamespace(end=f"end {n}") for n in range(6)]
    task = SimpleNamespace(start="the scene's")
    rows = SimpleNamespace(task=task, at=[2, 3, 4], watched=bytearray(3),
                           carried_from=2 if carried else None)  # fmt: skip
    found = []

    def collect(task, pieces, *others):
        found.append((task, pieces))
        found_by.bare.extend(pieces)
        return "part"

    found_by = SimpleNamespace(
        bare=bare, looks=None, parts=[], _take=None, _ranked=lambda at: None,
        values=[700.0, 701.0, 702.0, 703.0, 704.0, 705.0], work=SimpleNamespace(collect=collect),
    )  # fmt: skip
    found_by._start = lambda rows, row: module._SweepRows._start(found_by, rows, row)
    todo = iter(([2, 0, 1], []))
    monkeypatch.setattr(module, "replace", lambda task, patient: ("patient", patient, task))
    monkeypatch.setattr(module, "_WatchedFrom", lambda task: task)
    monkeypatch.setattr(module, "_ranges_of_chaos", lambda *_: ["a range"])
    monkeypatch.setattr(module, "_unwatched", lambda *_: next(todo))
    module._SweepRows._watch_ends(found_by, rows)
    starts = ["the scene's", "end 2", "end 3"] if carried else ["the scene's"] * 3
    pieces = list(zip((702.0, 703.0, 704.0), starts, strict=True))
    assert found == [(("patient", True, task), pieces)]
    assert (rows.at, list(rows.watched)) == ([6, 7, 8], [True] * 3)
