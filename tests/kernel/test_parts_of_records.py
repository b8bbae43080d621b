"""Records of orbits, first contacts and enclosed steps as plain Python, on numbers made by hand."""

from __future__ import annotations

from copy import copy
from dataclasses import fields
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.errors import Status
from camcli.kernel import certify, enclosed_landing, flight, follow
from camcli.kernel.cam_table import TURN
from camcli.kernel.contact_search import (
    CLEAR,
    EXACTLY,
    LANDED,
    LOST,
    NEARLY,
    STUCK,
)
from camcli.kernel.enclosed_landing import Ball, Gap
from camcli.kernel.flight import BOUNCED, FREE
from camcli.kernel.follow import Run
from camcli.kernel.loads import Loads
from camcli.kernel.orbit_loop import NEVER, NOWHERE, RESTING, Earlier, State

OK, PAUSED, LOG_FULL = (int(x) for x in (Status.OK, Status.PAUSED, Status.LOG_FULL))


# -- the first contact behind an impact


def contact(monkeypatch, steps, *, i=1, most=1, gap=(0.5, -2.0, 0.0)):
    """What is told of flights that end so; and how each of them began."""
    asked: list = []
    said = iter(steps)
    ends = (1.0, 2.0, 4.0)
    made = Made(stretches=[Made(start=a, end=b, slope_jump=jump)
                           for a, b, jump in zip((0.0, *ends), ends, (0.125, 0.25, 0.5),
                                                 strict=False)])  # fmt: skip
    monkeypatch.setattr(certify, "flight_at", lambda cam, const, i, theta, gap, rate: Made(
        theta=theta, start=(i, theta, gap, rate)))  # fmt: skip

    def fly(cam, const, flows, i, f, mode, work):
        asked.append((*f.start, mode))
        return next(said)

    monkeypatch.setattr(certify, "fly", fly)
    monkeypatch.setattr(certify, "gap_at", lambda cam, const, i, f, s, work: gap)
    return certify.next_contact(made, None, None, i, 1.5, 0.75, most, None), asked


def test_a_contact_is_looked_for_from_stretch_to_stretch(monkeypatch):
    """Over the end of the turn; a jump of the slope changes the rate, and the gap goes on."""
    steps = [(CLEAR, 1.75, 0.5, 0.25), (CLEAR, 2.0, 0.75, 0.5), (CLEAR, 4.0, 0.625, -0.5),
             (LANDED, 0.5, 1e-18, -1.0)]  # fmt: skip
    found, asked = contact(monkeypatch, steps)
    assert found == (LANDED, 0.5, 1)
    assert asked == [
        (1, 1.5, 0.0, 0.75, BOUNCED), (1, 1.75, 0.5, 0.25, FREE), (2, 2.0, 0.75, 0.0, FREE),
        (0, 0.0, 0.625, -0.625, FREE),
    ]  # fmt: skip


@pytest.mark.parametrize("code", [STUCK, LOST])
def test_a_flight_that_ends_without_a_contact_is_told_as_it_is(monkeypatch, code):
    assert contact(monkeypatch, [(code, 1.75, 0.0, 0.0)])[0] == (code, 1.75, 0)


def test_a_contact_may_be_rough_or_exact_or_at_the_very_end(monkeypatch):
    assert contact(monkeypatch, [(EXACTLY, 1.75, 1e-18, -1.0)])[0] == (LANDED, 1.75, 0)
    found, _ = contact(monkeypatch, [(NEARLY, 1.5, 0.0, -1.0)], gap=(0.5, -2.0, 0.0))
    assert found == (LANDED, 1.75, 0)  # a step of Newton's method more
    found, asked = contact(monkeypatch, [(LANDED, 2.0, 1e-18, -1.0), (LANDED, 2.0, 0.0, -1.5)])
    assert found == (LANDED, 2.0, 0)  # the next stretch decides
    assert asked[1] == (2, 2.0, 0.0, -1.5, FREE)
    rough = contact(monkeypatch, [(NEARLY, 1.5, 0.0, -1.0), (STUCK, 2.0, 0.0, 0.0)],
                    gap=(2.0, -1.0, 0.0))[0]  # fmt: skip
    assert rough == (STUCK, 2.0, 0)  # beyond the end


def test_a_contact_is_looked_for_in_so_many_turns(monkeypatch):
    ends = [(CLEAR, 2.0, 1.0, 0.5), (CLEAR, 4.0, 1.0, 0.5), (CLEAR, 1.0, 1.0, 0.5)]
    for most in (0, 1, 2):
        found, asked = contact(monkeypatch, ends * 4, most=most)
        assert found == (CLEAR, 4.0, most + 1)
        assert len(asked) == 2 + 3 * most


# -- records


def test_an_orbit_goes_on_as_the_one_before_with_its_own_turns(monkeypatch):
    monkeypatch.setattr(follow, "lift_at", lambda cam, i, theta: (10.0 * i, theta, 0.0))
    numbers = {field.name: k + 2 for k, field in enumerate(fields(State))}
    before = State(**{**numbers, "theta": 0.5, "gap": 0.25, "gap_rate": -0.125, "stretch": 3})
    columns = {name: [None] * 3 for name in ("q", "w", "impacts", "chatter")}
    strobe = Made(rows=2, first=1, **columns)
    this_run, state = Run(continues=1), State(logged=2)
    follow.continue_orbit(None, Run(status=OK), before, this_run, state, strobe)
    expected = copy(before)
    expected.period = expected.total_impacts = expected.detachments = 0
    expected.logged = 2
    assert state == expected
    assert (this_run.continues, this_run.not_begun) == (0, 0)
    assert (strobe.q[1], strobe.w[1]) == (30.25, 0.375)
    assert (strobe.q[0], strobe.q[2]) == (None, None)
    follow.continue_orbit(None, Run(), before, Run(), State(), Made(rows=0))
    for ended in (Run(status=PAUSED), Run(repeats=1), Run(chatters=1), Run(not_begun=1)):
        this_run, state = Run(continues=1), State()
        follow.continue_orbit(None, ended, before, this_run, state, strobe)
        assert (this_run.continues, this_run.not_begun) == (0, 1)
        assert state == State()


def cycle(capacity=20):
    """A cycle of two turns with three events, which ends at the turn 5 of a record."""
    log = Made(capacity=capacity, kind=list(range(20)), period=[0, 3, 3, 4, *[None] * 16],
               theta=[0.1 * k for k in range(20)], q=[0.2 * k for k in range(20)],
               u=[0.3 * k for k in range(20)])  # fmt: skip
    strobe = Made(rows=9, first=1, impacts=[None, *range(10, 20)], chatter=[None, *range(20, 30)],
                  q=[None, *range(30, 40)], w=[None, *range(40, 50)])  # fmt: skip
    state = State(period=5, logged=4, total_impacts=8, detachments=3)
    earlier = Earlier(cycle=2, period=3, logged=1, total_impacts=5, detachments=2, gap=0.5)
    return state, earlier, log, strobe


@pytest.mark.parametrize(("turns", "copies"), [(6, 0), (7, 1), (8, 1), (9, 2)])
def test_the_turns_of_a_cycle_are_copied_to_the_end_of_a_record(turns, copies):
    state, earlier, log, strobe = cycle()
    before = copy(strobe.impacts), copy(strobe.q)
    assert follow.copy_turns(state, turns, earlier, log, strobe) == OK
    assert (state.period, state.logged) == (5 + 2 * copies, 4 + 3 * copies)
    assert (state.total_impacts, state.detachments) == (8 + 3 * copies, 3 + copies)
    assert (earlier.period, earlier.logged) == (3 + 2 * copies, 1 + 3 * copies)
    assert (earlier.total_impacts, earlier.detachments) == (5 + 3 * copies, 2 + copies)
    assert (earlier.cycle, earlier.gap, earlier.keep_in) == (0, NOWHERE, NEVER)
    for number in range(1, copies + 1):
        rows = slice(1 + 3 * number, 4 + 3 * number)
        assert log.kind[rows] == [1, 2, 3]
        assert log.period[rows] == [3 + 2 * number, 3 + 2 * number, 4 + 2 * number]
        for name, step in (("theta", 0.1), ("q", 0.2), ("u", 0.3)):
            assert getattr(log, name)[rows] == pytest.approx([step, 2 * step, 3 * step])
    for period in range(5, 5 + 2 * copies):
        source = 3 + (period - 3) % 2
        assert strobe.impacts[1 + period] == before[0][1 + source]
        assert strobe.chatter[1 + period] == 20 + source
        if period + 1 < 9:
            assert strobe.q[2 + period] == before[1][2 + source]
            assert strobe.w[2 + period] == 41 + source
    untouched = 6 + 2 * copies
    assert strobe.impacts[untouched:] == before[0][untouched:]


def test_a_full_log_has_the_copies_that_it_holds():
    state, earlier, log, strobe = cycle(capacity=8)
    assert follow.copy_turns(state, 9, earlier, log, strobe) == LOG_FULL
    assert (state.period, state.logged) == (7, 7)
    assert (earlier.cycle, earlier.period, earlier.logged) == (2, 5, 4)
    exact = cycle(capacity=10)
    assert follow.copy_turns(exact[0], 9, *exact[1:]) == OK


@pytest.mark.parametrize(
    ("period", "after"), [(-7, -1), (-6, -2), (-3, -1), (-2, -2), (-1, -1), (0, 0)]
)
def test_the_turns_of_a_transient_are_left_out(monkeypatch, period, after):
    """A cycle of two turns with three impacts: up to less than one before its end."""
    kept: list = []
    monkeypatch.setattr(follow, "keep", lambda *given: kept.append(given[1:4]))
    state = State(period=period, total_impacts=8, gap=0.25, gap_rate=0.5, mode=2)
    earlier = Earlier(cycle=2, period=-9, total_impacts=5, gap=0.5)
    assert follow.repeat_turns(state, Run(turns=9), earlier, None, None) == OK
    left_out = (after - period) // 2
    assert (state.period, state.total_impacts) == (after, 8 + 3 * left_out)
    assert (earlier.cycle, earlier.gap, earlier.keep_in) == (0, NOWHERE, 0)
    assert kept == ([(0.25, 0.5, 2)] if period >= 0 else [])
    calls: list = []
    monkeypatch.setattr(follow, "copy_turns", lambda *given: calls.append(given) or LOG_FULL)
    earlier = Earlier(cycle=2, period=0)
    assert follow.repeat_turns(state, Run(turns=9), earlier, "log", "strobe") == LOG_FULL
    assert calls == [(state, 9, earlier, "log", "strobe")]


@pytest.mark.parametrize(("period", "periods"), [(-3, 0), (2, 2), (3, 3), (9, 3)])
@pytest.mark.parametrize("wants", [0, 1])
def test_a_record_shows_its_whole_turns_and_what_it_repeats(monkeypatch, period, periods, wants):
    measured: list = []
    monkeypatch.setattr(follow, "find_return", lambda strobe, turns: (turns, 1))
    monkeypatch.setattr(follow, "measure_record", lambda cam, const, log, first, last, load: (
        measured.append((first, last, load.turns, load.resting, load.gap, load.rate))))  # fmt: skip
    made = Made(strobe=1, stretches=[Made(slope_jump=0.0, start=0.0),
                                     Made(start_c=0.5, start_c1=0.25)])  # fmt: skip
    strobe = Made(rows=3, first=1, impacts=[90, 1, 2, 4, 90], chatter=[9, 0, 1, 1, 9],
                  q=[9.0, 0.75, 9.0], w=[9.0, 0.125, 9.0])  # fmt: skip
    this_run = Run(turns=3, wants_loads=wants, log_first=5, log_last=8)
    state = State(period=period, mode=RESTING)
    follow.finish(made, None, state, this_run, "log", strobe, Loads())
    assert (this_run.periods, this_run.resting) == (periods, 1)
    assert this_run.impacts == {0: 0, 2: 3, 3: 7}[periods]
    assert this_run.chatters == {0: 0, 2: 1, 3: 2}[periods]
    assert (this_run.repeats, this_run.near) == ((periods, 1) if periods else (0, 0))
    assert measured == ([(5, 8, periods, 1, 0.25, -0.125)] if periods and wants else [])
    empty = Run(turns=3, wants_loads=1)
    follow.finish(made, None, State(period=2), empty, "log", Made(rows=0, first=0), Loads())
    assert (empty.periods, empty.impacts, empty.repeats) == (2, 0, 0)


@pytest.mark.parametrize(
    ("theta", "gap", "rate", "jump", "thrown"),
    [(1.0, 0.0, 0.5, -0.5, True), (1.1, 0.0, 0.5, -0.5, False), (1.0, 0.1, 0.5, -0.5, False),
     (1.0, 0.0, 0.4, -0.5, False), (1.0, 0.0, -0.5, 0.5, False), (1.0, 0.0, 0.0, 0.0, False)],
)  # fmt: skip
def test_a_kink_throws_a_follower_off_that_rested(theta, gap, rate, jump, thrown):
    made = Made(stretches=[None, Made(start=1.0, slope_jump=jump)])
    state = State(theta=theta, gap=gap, gap_rate=rate, stretch=1)
    assert follow.is_thrown_off(made, state) is thrown


# -- bounds of enclosed steps


def test_sums_and_products_hold_those_of_all_their_numbers():
    x, y = Ball(3.0, 0.5), Ball(-2.0, 0.25)
    total, product = enclosed_landing._plus(x, y), enclosed_landing._times(x, y)
    assert (total.middle, product.middle) == (1.0, -6.0)
    assert total.radius == pytest.approx(0.75, rel=1e-8)
    assert product.radius == pytest.approx(3.0 * 0.25 + 0.5 * 2.0 + 0.5 * 0.25, rel=1e-8)
    assert total.radius > 0.75
    assert product.radius > 1.875


@pytest.mark.parametrize(
    ("g", "u", "a", "jerk", "h", "above"),
    [
        (1.0, -1.0, 0.0, 0.0, 0.99, True), (1.0, -1.0, 0.0, 0.0, 1.01, False),
        (1.0, 1.0, -3.0, 0.0, 1.2, True),  # 1 + h - 1.5 h^2 is zero at 1.215
        (1.0, 1.0, -3.0, 0.0, 1.23, False), (1.0, 1.0, 0.0, 6.0, 1.3, True),  # 1 + h - h^3
        (1.0, 1.0, 0.0, 6.0, 1.35, False), (0.0, 1.0, -1.0, 0.0, 1.9, True),
        (0.0, 1.0, -1.0, 0.0, 2.1, False), (0.0, -1.0, 3.0, 0.0, 1.0, False),
        (-0.1, 1.0, 0.0, 0.0, 0.5, True), (0.0, 0.0, 1.0, 0.0, 1.0, False),
    ],
)  # fmt: skip
def test_a_gap_stays_above_zero_over_a_step(g, u, a, jerk, h, above):
    """At least g + u h + a h^2/2 - jerk h^3/6; one that begins at zero rises throughout."""
    assert enclosed_landing._stays_above(g, u, a, jerk, h) is above
    found = enclosed_landing._certain_step(g, u, a, jerk, h)
    if above:
        assert found == h
    elif g > 0.0:
        assert found == h / 2.0
    elif u <= 0.0:
        assert found == -1.0


def gap_of(**values) -> Gap:
    return Gap(**{**dict.fromkeys(Gap._fields, 0.0), **values})


@pytest.mark.parametrize(
    ("values", "jerk", "most", "fall"),
    [
        ({}, 0.0, 9.0, 2.0 * 1.1 / 1.75), ({}, 0.0, 1.25, -1.0), ({"u": -0.1}, 0.0, 9.0, -1.0),
        ({"a": 1.0, "da": 0.3}, 0.0, 9.0, 2.0 * 1.1 / 1.75),
        ({"a": 1.0, "da": 0.5}, 0.0, 9.0, -1.0), ({"a": -9.0}, 2.0, 9.0, 2.0 * 1.1 / 1.75),
        ({"a": -9.0}, 2.3, 9.0, -1.0),
    ],
)  # fmt: skip
def test_a_gap_falls_for_twice_its_way_down_where_its_acceleration_lets_it(
    values, jerk, most, fall
):
    """From 1.1 with the rate -1.75 at least: the rate stays below zero for 2.2/1.75 rad or not."""
    gap = gap_of(**{"g": 1.0, "dg": 0.1, "u": -2.0, "du": 0.25, **values})
    assert enclosed_landing._certain_fall(gap, jerk, most) == pytest.approx(fall)
    assert enclosed_landing._is_below(gap_of(g=-1.0, dg=0.9))
    assert not enclosed_landing._is_below(gap_of(g=-1.0, dg=1.1))


def test_the_third_derivative_of_a_gap_has_its_bound():
    room = np.arange(60.0)
    made = Made(stretches=[None, Made(jerk_max=3.0)])
    found = enclosed_landing._jerk_bound(made, room, Made(energy=2.0), 1)
    assert found == pytest.approx(2.0 + 3.0 + enclosed_landing.ERROR + 3.0)


# -- chatter on the way


def accumulated(monkeypatch, *, error=1e-12, tau=0.5, end=1.0, rate=0.125, g=2.0, r=0.5, jerk=0.0):
    """The phase until hops accumulate, and what the map of a chatter is asked."""
    asked: list = []
    monkeypatch.setattr(flight, "higher", lambda cam, i, theta: (0.25, 0.75, 0.0, 0.0))
    monkeypatch.setattr(flight, "chatter_map", lambda *given: asked.append(given[1:]) or (
        tau, error))  # fmt: skip
    stretch = Made(jerk_max=jerk, snap_max=2.0 * jerk, crackle_max=4.0 * jerk)
    const = Made(G=g, W2=3.0, Z=0.5, D=0.25 - 3.0, tolerance=1e-9)
    f = Made(q=0.5, gap=0.25, w=0.375 + rate, rate=rate, c2=0.5, end=end, theta=1.0)
    return flight._accumulation(Made(stretches=[stretch]), const, r, 0, f), asked


def test_a_chatter_accumulates_where_its_map_is_exact_and_the_stretch_goes_on(monkeypatch):
    """c = 1/4, c' = 3/8, c'' = 1/2: the force is 2 + 3/4 + 3/8 + 1/2."""
    force = 2.0 + 0.75 + 0.375 + 0.5
    hop = 2.0 * 0.125 / force
    slope, curve = 3.0 * 0.375 + 0.5 + 0.25, 1.5 + 0.25 + 0.75
    few = {"rate": 1e-6}
    found, asked = accumulated(monkeypatch, **few)
    assert found == 0.5
    ((r, length, by_slope, by_curve, drift),) = asked
    assert (r, drift) == (0.5, 0.0)
    assert length == pytest.approx(hop * 1e-6 / 0.125)
    assert by_slope == pytest.approx(slope / force)
    assert by_curve == pytest.approx(curve / force)
    _, asked = accumulated(monkeypatch, jerk=1e-3, **few)
    assert asked[0][-1] == pytest.approx((3.0 + 2.0 + 4.0) * 1e-3 / force)
    for given in ({"error": 2e-9}, {"tau": 1.0}, {"g": -3.0}):
        assert accumulated(monkeypatch, **few, **given)[0] == -1.0
    said, asked = accumulated(monkeypatch, rate=0.125, jerk=9.0)
    assert (said, asked) == (-1.0, [])  # the largest terms of the error refuse it before
    said, asked = accumulated(monkeypatch, rate=1e-6, end=1e-7)
    assert (said, asked) == (-1.0, [])


def followed(monkeypatch, runs, said, *, steps=100, begin=0):
    """The number that is returned; what the loop is asked, and which orbits are finished.

    said: for each call of the loop its status, the cycle that is seen then, and its steps.
    """
    asked: list = []
    ended: list = []
    ways = iter(said)
    n = len(runs)
    states, works, earliers = (
        [made() for _ in range(n)] for made in (State, lambda: Made(steps=5), Earlier)
    )
    monkeypatch.setattr(follow, "fill_flows", lambda cam, const, flows: asked.append(const.W))
    monkeypatch.setattr(follow, "continue_orbit", lambda cam, one, state, this_run, *more: (
        asked.append("continues")))  # fmt: skip
    monkeypatch.setattr(follow, "finish", lambda cam, const, state, this_run, log, strobe, load: (
        ended.append((runs.index(this_run), load, strobe.rows, strobe.first))))  # fmt: skip

    def run(cam, const, flows, state, plan, log, strobe, work, earlier):
        status, earlier.cycle, used = next(ways)
        asked.append(tuple(plan))
        work.steps += used
        state.logged += 3
        return int(status)

    monkeypatch.setattr(follow, "run", run)

    def repeat(state, this_run, earlier, log, strobe):
        asked.append("repeats")
        earlier.cycle = 0
        return OK

    monkeypatch.setattr(follow, "repeat_turns", repeat)
    names = ("W", "W2", "Z", "D", "G", "r", "tolerance", "impact_budget", "W_rest", "r_seat")
    consts = [Made(**dict.fromkeys(names, 10.0 * (k + 1))) for k in range(n)]
    strobe = Made(q=0, w=0, impacts=0, chatter=0)
    loads = [f"load {k}" for k in range(n)]
    number = follow.follow_orbits(
        None, consts, None, states, works, runs, earliers, loads, None, strobe, begin, steps
    )
    return number, asked, ended, states


def run_of(k: int, **more) -> Run:
    return Run(log_from=k, turns=10 + k, strobe_first=20 + k, strobe_rows=30 + k, **more)


def test_orbits_are_followed_one_after_the_other_within_all_their_steps(monkeypatch):
    """The second one is seen to repeat itself, and its turns are copied; the third goes on."""
    runs = [run_of(0), run_of(1), run_of(2, continues=1)]
    said = [(OK, 0, 30), (OK, 2, 20), (OK, 0, 10), (Status.NO_RETURN, 2, 1)]
    number, asked, ended, states = followed(monkeypatch, runs, said)
    assert number == 3
    assert asked == [
        10.0, (0, 10, 100), 20.0, (1, 11, 70), "repeats", (1, 11, 50), 30.0, "continues",
        (2, 12, 40),
    ]  # fmt: skip
    assert ended == [(k, f"load {k}", 30 + k, 20 + k) for k in range(3)]
    assert [one.status for one in runs] == [OK, OK, int(Status.NO_RETURN)]
    assert [(one.log_first, one.log_last) for one in runs] == [(0, 3), (3, 9), (9, 12)]
    assert [state.logged for state in states] == [3, 9, 12]


@pytest.mark.parametrize("status", [Status.PAUSED, Status.LOG_FULL])
def test_orbits_are_left_at_the_one_that_is_interrupted(monkeypatch, status):
    runs = [run_of(0), run_of(1), run_of(2)]
    number, asked, ended, _ = followed(monkeypatch, runs, [(status, 0, 30)], begin=1)
    assert (number, ended) == (1, [])
    assert asked == [20.0, (1, 11, 100)]
    assert runs[1].status == int(status)
    assert runs[1].log_last == 3
    assert runs[2].log_first == 0


def test_an_orbit_that_is_left_out_is_neither_flown_nor_finished(monkeypatch):
    runs = [run_of(0, not_begun=1), run_of(1)]
    number, asked, ended, _ = followed(monkeypatch, runs, [(OK, 0, 30)])
    assert number == 2
    assert asked == [10.0, 20.0, (1, 11, 100)]
    assert ended == [(1, "load 1", 31, 21)]
    assert runs[0].log_last == 0


def test_a_record_ends_at_rest_where_a_kink_throws_the_follower_off_just_then():
    made = Made(stretches=[Made(start=0.0, slope_jump=-0.5)])
    for rate, resting in ((0.5, 1), (0.25, 0)):
        this_run = Run(turns=3)
        state = State(period=2, gap_rate=rate)
        follow.finish(made, None, state, this_run, None, Made(rows=0, first=0), Loads())
        assert this_run.resting == resting


LIFT = (0.5, -0.25, 0.75, 0.125)  # c and three derivatives, wherever it is asked for
OWN = Made(G=3.0, W2=4.0, W=2.0, Z=0.25)


def room_of(**radii) -> list[float]:
    """Room with a start, the radii that are given, and the bounds of a table."""
    room = [0.0] * enclosed_landing.COLUMNS
    room[enclosed_landing.THETA], room[enclosed_landing.RATE] = 1.5, 0.375
    room[enclosed_landing.THETA_RADIUS] = radii.get("theta", 0.0)
    room[enclosed_landing.RATE_RADIUS] = radii.get("rate", 0.0)
    for k in range(5):
        room[enclosed_landing.ERROR + k] = radii.get(f"error{k}", 0.0)
        room[enclosed_landing.SIZE + k] = (9.0, 3.0, 5.0, 7.0, 11.0)[k]
    return room


@pytest.fixture
def constant_cam(monkeypatch):
    """A cam whose lift and derivatives are the same everywhere, in the turn from 1 to 2 rad."""
    monkeypatch.setattr(enclosed_landing, "lift_at", lambda cam, i, theta: LIFT[:3])
    monkeypatch.setattr(enclosed_landing, "derivative", lambda cam, order, i, theta: LIFT[3])
    return Made(stretches=[Made(start=1.0, end=2.0)])


RADII = [  # what is known badly, and by how much q, w and the fall at the start are then
    ("theta", (3.0, 5.0, 4.0 * 3.0 + 0.5 * 5.0 + 7.0)), ("rate", (0.0, 1.0, 0.5)),
    ("error0", (1.0, 0.0, 4.0)), ("error1", (0.0, 1.0, 0.5)), ("error2", (0.0, 0.0, 1.0)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "factors"), RADII)
def test_the_radii_of_a_start_are_those_of_all_that_it_depends_on(constant_cam, name, factors):
    """q'' = -G - 4 q - q'/2, from the cam's bounds 3, 5 and 7 of the first three derivatives."""
    leap = enclosed_landing._leap(constant_cam, OWN, room_of(**{name: 1e-3}), 0)
    q, w = 0.5, -0.25 + 0.375
    q2 = -3.0 - 4.0 * q - 0.5 * w
    q3 = -0.5 * q2 - 4.0 * w
    assert (leap.theta, leap.q, leap.w, leap.rate) == (1.5, q, w, 0.375)
    assert (leap.force, leap.pull) == (5.0, 5.0)
    assert leap.fall == pytest.approx(-q2 + 0.75)
    by_q, by_w, by_fall = (1e-3 * x for x in factors)
    assert (leap.dq, leap.dw, leap.dfall) == pytest.approx((by_q, by_w, by_fall), abs=1e-11)
    by_q2 = 4.0 * by_q + 0.5 * by_w
    energy = abs(q3) + 2.0 * abs(q2) + (0.5 * by_q2 + 4.0 * by_w) + 2.0 * by_q2
    assert leap.energy == pytest.approx(energy, rel=1e-9)
    assert leap.energy > energy


@pytest.mark.parametrize("name", ["dq", "dw", "dtheta", *(f"error{k}" for k in range(4))])
@pytest.mark.parametrize("s", [0.25, 1.0])
def test_the_radii_of_a_gap_are_those_of_all_that_it_depends_on(monkeypatch, constant_cam, name, s):
    """After s rad: q by q0 and s w0, its rate by w0 and the smaller one of W and W^2 s of q0."""
    monkeypatch.setattr(enclosed_landing, "flow", lambda const, s: (0.2, 0.8, 0.03))
    given = {key: 1e-3 if key == name else 0.0 for key in ("dq", "dw", "dtheta")}
    leap = enclosed_landing.Leap(
        theta=1.5, q=0.5, w=0.125, force=5.0, pull=5.0, rate=0.375, fall=6.0, energy=1.0,
        drate=0.0, dfall=0.0, **given,
    )  # fmt: skip
    room = room_of(**{name: 1e-3})
    gap = enclosed_landing._gap_after(constant_cam, OWN, room, leap, 0, 0.0, s)
    q, w = 0.5 + 0.125 * 0.2 - 5.0 * 0.03, 0.125 * 0.8 - 5.0 * 0.2
    q2 = -3.0 - 4.0 * q - 0.5 * w
    assert (gap.g, gap.u, gap.a) == pytest.approx((q - 0.5, w + 0.25, q2 - 0.75))
    assert gap.jerk == pytest.approx(-0.5 * q2 - 4.0 * w - 0.125)
    by_q = given["dq"] + s * given["dw"]
    by_w = min(2.0, 4.0 * s) * given["dq"] + given["dw"]
    by_q2 = 4.0 * by_q + 0.5 * by_w
    by_q3 = 0.5 * by_q2 + 4.0 * by_w
    for k, (found, by_flight) in enumerate(
        zip((gap.dg, gap.du, gap.da, gap.djerk), (by_q, by_w, by_q2, by_q3), strict=True)
    ):
        table = 1e-3 * (name == f"error{k}")
        phase = given["dtheta"] * (3.0, 5.0, 7.0, 11.0)[k]
        assert found == pytest.approx(by_flight + table + phase, abs=1e-11)
        assert found >= by_flight + table + phase


def test_a_phase_a_little_outside_of_its_stretch_is_taken_at_the_end(monkeypatch, constant_cam):
    asked: list = []
    monkeypatch.setattr(enclosed_landing, "lift_at", lambda cam, i, theta: (
        asked.append(theta) or LIFT[:3]))  # fmt: skip
    monkeypatch.setattr(enclosed_landing, "flow", lambda const, s: (0.0, 1.0, 0.0))
    leap = enclosed_landing.Leap(*[1.5] * 13)
    for s, wraps in ((0.25, 0.0), (0.75, 0.0), (-0.75, 0.0), (0.25 + TURN, 1.0)):
        enclosed_landing._gap_after(constant_cam, OWN, room_of(), leap, 0, wraps, s)
    assert asked == [1.75, 2.0, 1.0, pytest.approx(1.75)]


def sharpened(monkeypatch, *, stretch_end=9.0, du=0.0, low=0.0, high=2.0, wraps=0.0, **errors):
    """What is written of a zero at 1 rad, of -(s - 1) - (s - 1)^2/4, that is known to 1e-7."""
    derived: list = []

    def gap_after(cam, const, room, leap, i, wraps, s):
        x = s - 1.0
        return gap_of(g=-x - 0.25 * x * x, dg=1e-7, u=-1.0 - 0.5 * x, du=du, a=-0.5, jerk=0.25)

    monkeypatch.setattr(enclosed_landing, "_gap_after", gap_after)
    monkeypatch.setattr(enclosed_landing, "restitution_at", lambda cam, const, i: 0.75)
    monkeypatch.setattr(enclosed_landing, "_derivatives", lambda *given: derived.append(given[1]))
    stretch = Made(start=0.0, end=stretch_end, jerk_max=3.0, snap_max=40.0)
    room = room_of(**errors)
    room[enclosed_landing.ANGLE] = 1.1
    leap = Made(theta=1.5, energy=8.0, dtheta=0.0)
    code = enclosed_landing._sharpened(
        Made(stretches=[stretch]), OWN, room, leap, 0, wraps, low, high
    )
    return code, room, derived


def test_what_is_written_of_a_landing_holds_over_all_of_its_room(monkeypatch):
    """The zero lies within 2e-7 rad: by what slope, acceleration and jerk are off there."""
    code, room, derived = sharpened(monkeypatch, error4=2.0)
    assert code == enclosed_landing.ENCLOSED
    ds, snap = 2e-7, 2.5 * 8.0 + 40.0 + 2.0
    wanted = {"ANGLE": (1.0, ds), "U": (-1.0, 0.5 * ds), "ACCEL": (-0.5, 0.25 * ds),
              "JERK": (0.25, snap * ds)}  # fmt: skip
    for name, (middle, radius) in wanted.items():
        at = getattr(enclosed_landing, name)
        assert room[at] == pytest.approx(middle)
        assert room[at + 1] == pytest.approx(radius, rel=1e-3)
        assert room[at + 1] >= radius
    assert room[enclosed_landing.SNAP] == pytest.approx(snap)
    assert room[enclosed_landing.PHASE] == pytest.approx(2.5)
    assert room[enclosed_landing.WRAPS] == 0.0
    assert ds < room[enclosed_landing.SLIVER] < 1.01 * ds
    assert derived == [0.75]
    _, room, _ = sharpened(monkeypatch, wraps=1.0, stretch_end=9.0, low=0.5)
    assert room[enclosed_landing.WRAPS] == 0.0  # before the turn begins: nothing is written


@pytest.mark.parametrize(
    "given",
    [{"stretch_end": 2.5 + 1e-8}, {"du": 0.6}, {"low": 1.0 - 1e-8}, {"high": 1.0 + 1e-8},
     {"high": 0.9}],
)  # fmt: skip
def test_nothing_is_written_of_a_landing_beside_an_end(monkeypatch, given):
    code, _, derived = sharpened(monkeypatch, **given)
    assert code == enclosed_landing.UNDECIDED
    assert derived == []
    assert sharpened(monkeypatch, stretch_end=2.5 + 1e-6)[2] == [0.75]


def followed_up(monkeypatch, gaps, falls, *, step=None):
    """What an enclosed flight from 5 rad on is asked on its way: over the end of the turn."""
    asked: list = []
    heights, ways = iter(gaps), iter(falls)

    def gap_after(cam, const, room, leap, i, wraps, s):
        asked.append((i, wraps, round(s, 6)))
        return gap_of(g=next(heights), u=-0.5)

    monkeypatch.setattr(enclosed_landing, "_gap_after", gap_after)
    monkeypatch.setattr(enclosed_landing, "_certain_step", lambda g, u, a, jerk, h: (
        h if step is None else step))  # fmt: skip
    monkeypatch.setattr(enclosed_landing, "_certain_fall", lambda gap, jerk, most: next(ways))
    monkeypatch.setattr(enclosed_landing, "_sharpened", lambda cam, const, room, leap, i, wraps, *
                        ends: ("sharpened", i, wraps, *ends))  # fmt: skip
    rows = [Made(start=a, end=b, jerk_max=1.0) for a, b in ((0.0, 3.0), (3.0, TURN))]
    leap = Made(theta=5.0, energy=1.0, rate=0.5, drate=0.0, fall=1.0, dfall=0.0, dtheta=0.0,
                w=0.5, pull=1.0, dw=0.0)  # fmt: skip
    room = room_of()
    room[enclosed_landing.THETA] = 5.0
    found = enclosed_landing._follow(Made(stretches=rows), OWN, room, leap, 1, TURN - 5.0, 1e-14)
    return found, asked, room


def test_an_enclosed_flight_goes_on_over_the_end_of_the_turn(monkeypatch):
    first = round(TURN - 5.0, 6)
    found, asked, room = followed_up(monkeypatch, [1.0, 1.0, -1.0], [0.75])
    assert asked == [(1, 0.0, first), (0, 1.0, first), (0, 1.0, round(first + 0.75, 6))]
    assert found == ("sharpened", 0, 1.0, TURN - 5.0, TURN - 5.0 + 0.75)
    assert room[enclosed_landing.ANGLE] == pytest.approx(TURN - 5.0 + 2.0)  # g over -u
    # not yet below: on to the end of the next stretch, and of the one behind
    found, asked, _ = followed_up(
        monkeypatch, [1.0, 1.0, 0.5, 1.0, 1.0, -1.0], [0.75, 0.25], step=None
    )
    assert [row[:2] for row in asked] == [
        (1, 0.0),
        (0, 1.0),
        (0, 1.0),
        (0, 1.0),
        (1, 1.0),
        (1, 1.0),
    ]
    assert found[1:3] == (1, 1.0)


@pytest.mark.parametrize("gaps", [[1e-12], [1.0, 0.0], [1.0, -1.0], [1.0, 1.0, 0.5, 1e-12]])
def test_nothing_is_said_of_a_flight_that_is_low_where_a_stretch_ends(monkeypatch, gaps):
    found, *_ = followed_up(monkeypatch, gaps, [0.75, -1.0])
    assert found == enclosed_landing.UNDECIDED
    found, *_ = followed_up(monkeypatch, [1e-11, 1.0, -1.0], [0.75])
    assert found[0] == "sharpened"
    assert followed_up(monkeypatch, [1.0], [], step=-1.0)[0] == enclosed_landing.UNDECIDED
