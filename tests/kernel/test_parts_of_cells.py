"""Cells of starts, certificates, returns and the table of flows as plain Python, by stand-ins."""

from __future__ import annotations

from types import SimpleNamespace as Made

import pytest
from mpmath import mp, mpf, pi, sqrt

from camcli.errors import Status
from camcli.kernel import cells, certify, flow, returns
from camcli.kernel.cam_table import TURN
from camcli.kernel.cells import Progress
from camcli.kernel.contact_search import LANDED, LOST, STUCK, Tally
from camcli.kernel.orbit_loop import State


def point(gap, rate, a, b, c, *, following=0, symbol=1, turns=2, shrink=0.5, attractor=3) -> Made:
    return Made(gap=gap, rate=rate, a=a, b=b, c=c, following=following, symbol=symbol, turns=turns,
                shrink=shrink, attractor=attractor)  # fmt: skip


def targets(**values) -> Made:
    given = {
        "points": [point(1.0, 2.0, 4.0, 1.0, 9.0, following=1),
                   point(5.0, 6.0, 1.0, 0.0, 1.0, following=0, symbol=2)],
        "boxes": [0, 1, 2, 0, 0, 2], "stay": [4, 2], "gap": -1.0, "rate": 10.0, "per_gap": 2.0,
        "per_rate": 0.5, "columns": 3, "rows": 2, "near": 0.25, "watch_rests": 1,
        "rests": [Made(gap=0.5, rate=1.0, end=7), Made(gap=0.5, rate=9.0, end=8)],
    }  # fmt: skip
    return Made(**{**given, **values})


def test_the_form_of_an_ellipse_and_the_first_one_that_holds_a_state():
    known = targets()
    assert cells.form(known, 0, 1.25, 1.5) == 4.0 * 0.0625 + 1.0 * 0.25 * -0.5 + 9.0 * 0.25
    assert cells.containing_point(known, 1.25, 2.125) == 0
    assert cells.containing_point(known, 5.0, 7.0) == 1  # on its rim
    assert cells.containing_point(known, 5.0, 7.001) == -1
    both = targets(points=[point(0.0, 0.0, 1.0, 0.0, 1.0)] * 2)
    assert cells.containing_point(both, 0.0, 0.0) == 0


@pytest.mark.parametrize(
    ("gap", "rate", "box"),
    [(-1.0, 10.0, 0), (-0.4, 11.0, 1), (0.1, 10.5, 2), (0.49, 13.9, 2), (0.5, 12.0, 0),
     (-1.01, 10.0, 0), (0.1, 9.99, 0), (0.1, 14.0, 0), (-0.4, 12.5, 0)],
)  # fmt: skip
def test_the_box_that_a_state_visits(gap, rate, box):
    """Three boxes of 1/2 m from -1 m on, in two rows of 2 m/rad from 10 on."""
    assert cells.visited_box(targets(), gap, rate) == box
    assert cells.visited_box(targets(columns=0), gap, rate) == 0


def test_a_rest_is_known_by_both_of_its_numbers():
    known = targets()
    for state, end in (((0.7, 1.2), 7), ((0.75, 1.25), 7), ((0.3, 9.1), 8), ((0.5, 1.26), -4),
                       ((0.76, 1.0), -4), ((0.24, 1.0), -4)):  # fmt: skip
        assert cells.known_rest(known, *state) == end
    assert [cells.trouble(x) for x in (0, 4)] == [-10, -14]


def test_a_cell_looks_for_a_ring_where_it_begins():
    known = targets()
    cell = Progress(at=9, passed=9, first=9.0)
    cells.meet(known, 5.5, 6.25, cell)
    assert (cell.at, cell.passed, cell.first) == (1, 0, 0.25 + 0.0625)
    cells.meet(known, 50.0, 6.0, cell)
    assert (cell.at, cell.passed, cell.first) == (-1, 0, 0.0)


def test_a_cell_goes_once_round_its_ring_and_shrinks():
    """Two turns: from the first point with one impact to the second, with two from there back."""
    known = targets()

    def round_again(last, symbols=(1, 2), first=0.5):
        cell = Progress(at=0, passed=0, first=first, symbol=symbols[0])
        on_the_way = cells.follow_ring(known, 5.0, 6.5, cell)
        assert on_the_way == -1
        cell.symbol = symbols[1]
        return cells.follow_ring(known, 1.0 + last, 2.0, cell), cell

    attractor, cell = round_again(0.25)  # a form of 1/4 is half of the first
    assert attractor == 3
    attractor, cell = round_again(0.26)
    assert (attractor, cell.at, cell.passed) == (-1, 0, 0)
    assert cell.first == pytest.approx(4.0 * 0.26**2)
    assert round_again(4e-6, first=1e-12)[0] == 3  # so near that it need not shrink
    assert round_again(6e-6, first=1e-12)[0] == -1
    attractor, cell = round_again(0.25, symbols=(2, 2))
    assert (attractor, cell.at, cell.passed) == (-1, 0, 1)  # it left it, and met its second point
    attractor, cell = round_again(0.25, symbols=(1, 1))
    assert (attractor, cell.at, cell.passed) == (-1, 0, 0)
    attractor, cell = round_again(0.6)  # outside of the ellipse
    assert (attractor, cell.at) == (-1, -1)


def test_turns_in_the_boxes_of_one_attractor_are_counted():
    known = targets()
    cell = Progress(box=0)
    first, second, none = (-0.4, 11.0), (0.1, 10.5), (9.0, 9.0)
    way = (first, first, first, second, second, none, first, second, second, second)
    stays = [
        (cells.count_stay(known, *state, cell), cell.stay, cell.box, cell.longest) for state in way
    ]
    assert stays == [
        (-1, 0, 1, 0), (-1, 1, 1, 1), (-1, 2, 1, 2), (-1, 0, 2, 2), (-1, 1, 2, 2), (-1, 0, 0, 2),
        (-1, 0, 1, 2), (-1, 0, 2, 2), (-1, 1, 2, 2), (1, 2, 2, 2),
    ]  # fmt: skip


def test_a_cell_begins_with_its_own_state_and_nothing_else():
    known = targets()
    made = Made(strobe=1, stretches=[None, Made(start=2.5)])
    rows = Made(gap=[9.0, 5.5], rate=[9.0, 6.25], mode=[7, 3])
    names = ("impacts", "chattered", "idle", "total_impacts", "flown", "period", "known")
    state = State(**dict.fromkeys(names, 9), rest=9.0)
    cell = Progress(used=9, stay=9, longest=9, symbol=9, box=9)
    cells.begin_cell(made, known, rows, 1, state, cell)
    assert (state.theta, state.gap, state.gap_rate, state.mode, state.stretch) == (
        2.5, 5.5, 6.25, 3, 1,
    )  # fmt: skip
    assert [getattr(state, name) for name in (*names, "rest")] == [0] * 8
    assert (cell.begun, cell.used, cell.stay, cell.longest, cell.symbol) == (1, 0, 0, 0, 0)
    assert (cell.box, cell.at, cell.first) == (0, 1, 0.3125)


def settled(monkeypatch, turns, budget=5, stop=100, **more):
    """The outcome of a cell whose turns are given: (status, chatter, impacts, ring, stay)."""
    rows = iter(turns)
    asked: list = []
    strobe = Made(chatter=[0], impacts=[0])
    room = Made(states=[State()], cell=[Progress()], strobe=strobe, works=[Tally(steps=30)],
                log="log", earliers=["earlier"])  # fmt: skip
    now: list = []

    def run(cam, const, flows, state, plan, log, strobe, work, earlier):
        now[:] = next(rows)
        asked.append((tuple(plan), state.period))
        state.period = 1
        strobe.chatter[0], strobe.impacts[0] = now[1:3]
        return int(now[0])

    monkeypatch.setattr(cells, "run", run)
    monkeypatch.setattr(cells, "follow_ring", lambda targets, gap, rate, cell: now[3])
    monkeypatch.setattr(cells, "count_stay", lambda targets, gap, rate, cell: now[4])
    monkeypatch.setattr(cells, "known_rest", lambda targets, gap, rate: now[5])
    outcome = cells.settle_cell(None, None, None, targets(**more), budget, stop, room)
    return outcome, room.cell[0], asked


def turn(status=Status.OK, chatter=0, impacts=2, ring=-1, stay=-1, rest=-3) -> tuple:
    return status, chatter, impacts, ring, stay, rest


def test_a_cell_is_followed_turn_by_turn_until_it_is_settled(monkeypatch):
    outcome, cell, asked = settled(monkeypatch, [turn(impacts=k) for k in range(5)])
    assert (outcome, cell.used, cell.symbol) == (-1, 5, 4)
    assert asked == [((0, 1, 70), 0)] * 5
    outcome, cell, _ = settled(monkeypatch, [turn(), turn(ring=4)])
    assert (outcome, cell.used) == (4, 2)
    outcome, cell, _ = settled(monkeypatch, [turn(), turn(stay=6)])
    assert (outcome, cell.used) == (6, 2)
    assert settled(monkeypatch, [turn(ring=0, stay=6)])[0] == 0
    assert settled(monkeypatch, [turn(stay=0)])[0] == 0
    outcome, cell, _ = settled(monkeypatch, [turn(), turn(chatter=1, rest=7)])
    assert (outcome, cell.used, cell.symbol) == (7, 2, -1)
    outcome, cell, _ = settled(monkeypatch, [turn(chatter=1, rest=-3)] * 5)
    assert (outcome, cell.used) == (-1, 5)
    outcome, *_ = settled(monkeypatch, [turn(chatter=1, rest=-4)])
    assert outcome == -4
    outcome, *_ = settled(monkeypatch, [turn(chatter=1, rest=7)] * 5, watch_rests=0)
    assert outcome == -1
    outcome, cell, _ = settled(monkeypatch, [turn(), turn(Status.PAUSED)])
    assert (outcome, cell.used) == (-10 - Status.PAUSED, 1)
    outcome, cell, _ = settled(monkeypatch, [turn(), turn(Status.NO_RETURN, ring=4)])
    assert (outcome, cell.used) == (-10 - Status.NO_RETURN, 2)


def test_cells_are_settled_one_after_the_other_and_go_on_where_they_stopped(monkeypatch):
    outcomes = iter([5, -10 - Status.PAUSED, 6, 7])
    begun: list = []
    monkeypatch.setattr(cells, "begin_cell", lambda cam, targets, rows, n, state, cell: (
        begun.append(n) or setattr(cell, "begun", 1)))  # fmt: skip
    stops: list = []

    def settle(cam, const, flows, targets, budget, stop, room):
        stops.append((budget, stop))
        room.works[0].steps += 10
        return next(outcomes)

    monkeypatch.setattr(cells, "settle_cell", settle)
    state = State(gap=0.5, gap_rate=0.25, mode=2, total_impacts=8)
    cell = Progress(used=3, longest=4, symbol=6)
    names = ("gap", "rate", "mode", "outcome", "turns", "stay", "symbol", "impacts")
    rows = Made(**{name: [0, 0, 0] for name in names})
    room = Made(states=[state], cell=[cell], works=[Tally(steps=100)])
    told = (None, None, None, None, rows)
    assert cells.settle_cells(*told, 0, 9, 50, room) == 1
    assert [getattr(rows, name)[0] for name in names] == [0.5, 0.25, 2, 5, 3, 4, 6, 8]
    assert rows.outcome == [5, 0, 0]
    assert cells.settle_cells(*told, 1, 9, 50, room) == 3
    assert rows.outcome == [5, 6, 7]
    assert begun == [0, 1, 2]
    assert stops == [(9, 150), (9, 150), (9, 170), (9, 170)]


# -- certificates of orbits


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        ((LANDED, 2.5, 2), "ADMISSIBLE"), ((LANDED, 2.4, 2), "EARLY"), ((LANDED, 2.6, 2), "LATE"),
        ((LANDED, 2.5, 1), "EARLY"), ((LANDED, 2.5, 3), "LATE"), ((STUCK, 2.5, 2), "EARLY"),
        ((LOST, 2.5, 2), "DOUBTFUL"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("k", [0, 1])
def test_every_flight_of_a_root_ends_at_its_next_impact(monkeypatch, contact, said, k):
    """Two impacts in five turns, at 1.5 rad of turn 1 and at 2.5 rad of turn 3."""
    x, whole = [1.5, 0.25, 2.5, 0.5], [4, 1, 6, 3]
    if k == 1:  # the flight that is asked for is the last one, to 2.5 rad
        x, whole = [2.5, 0.5, 1.5, 0.25], [6, 0, 4, 3]
    asked: list = []

    def next_contact(cam, const, flows, stretch, theta, rate, most, work):
        asked.append((stretch, theta, rate, most))
        return contact if len(asked) == k + 1 else (LANDED, 1.5, 3)

    monkeypatch.setattr(certify, "next_contact", next_contact)
    monkeypatch.setattr(certify, "constants_of", lambda *given: "const")
    monkeypatch.setattr(certify, "fill_crossings", lambda *given: None)
    found = [None, None]
    verdict = certify.certify_orbit(None, None, 2, 5, whole, x, [-1.0, -2.0], None, found, [None])
    assert verdict == getattr(certify, said)
    assert asked[0] == (whole[0], x[0], x[1], (2 if k == 0 else 3) + 1)
    if said == "ADMISSIBLE":
        assert asked[1] == (whole[2], x[2], x[3], (3 if k == 0 else 2) + 1)
    else:
        assert len(asked) == k + 1
        assert found[certify.IMPACT_AT] == k
        assert found[certify.PHASE] == contact[1]
    for rates, number in (([-1.0, 0.5], 1), ([0.0, -1.0], 0)):
        verdict = certify.certify_orbit(None, None, 2, 5, whole, x, rates, None, found, [None])
        assert verdict == certify.PULLS
        assert (found[certify.IMPACT_AT], found[certify.PHASE]) == (number, x[2 * number])


# -- returns


def strobe_of(rows, first=0) -> Made:
    """Rows of (q, w, impacts, chatter)."""
    q, w, impacts, chatter = ([row[k] for row in rows] for k in range(4))
    return Made(q=q, w=w, impacts=impacts, chatter=chatter, first=first)


def test_states_are_as_far_apart_as_the_farther_one_of_their_numbers():
    strobe = strobe_of([(1.0, 2.0, 1, 0), (1.5, 2.25, 1, 0), (1.0, 3.0, 1, 0)])
    assert returns.distance(strobe, 0, 1, 2.0, 4.0) == 0.25
    assert returns.distance(strobe, 0, 2, 2.0, 4.0) == 0.25
    assert returns.distance(strobe, 1, 0, 5.0, 1.0) == 0.25


def test_turns_are_alike_as_long_as_impacts_and_chatters_are():
    rows = [(0.0, 0.0, n, c) for n, c in ((1, 0), (9, 1), (2, 0), (1, 0), (5, 1), (2, 0))]
    strobe = strobe_of(rows)
    assert returns.count_alike(strobe, 5, 3, 3) == 3  # however many impacts a chatter has
    assert returns.count_alike(strobe, 5, 3, 2) == 2
    assert returns.count_alike(strobe, 5, 1, 3) == 0
    rows[1] = (0.0, 0.0, 5, 0)
    assert returns.count_alike(strobe_of(rows), 5, 3, 3) == 1
    rows[1], rows[2] = (0.0, 0.0, 9, 1), (0.0, 0.0, 3, 0)
    assert returns.count_alike(strobe_of(rows), 5, 3, 3) == 0
    states = [(x, 2.0 * x, 1, 0) for x in (1.0, 2.0, 3.0, 1.0, 2.0, 3.0)]
    same = strobe_of(states)
    assert returns.count_same(same, 5, 3, 3, 3.0, 6.0) == 3
    states[1] = (2.0, 4.5, 1, 0)
    assert returns.count_same(strobe_of(states), 5, 3, 3, 3.0, 6.0) == 1


# -- flows


MACHINE = (300.0, 1.5, 700.0, 11.0, 9.0, 13.0, 0.75, 0.5)


def test_the_constants_of_a_machine_are_those_of_its_equation():
    """omega is 10 pi rad/s; W in doubles and what it leaves out are W to 1e-30."""
    found = flow.constants_of(MACHINE, 1e-9, 77)
    with mp.workdps(40):
        omega = 10 * pi
        w = sqrt(mpf(700) / mpf("1.5")) / omega
        assert abs(mpf(found.W) * (1 + mpf(found.W_rest)) / w - 1) < 1e-30
        assert abs(found.Z / (11 / (3 * omega)) - 1) < 1e-15
        assert abs(found.G / ((9 + 13 / mpf("1.5")) / omega**2) - 1) < 1e-15
        assert abs(found.D / ((11 / (3 * omega)) ** 2 - w**2) - 1) < 1e-14
    assert (found.r, found.r_seat, found.tolerance, found.impact_budget) == (0.75, 0.5, 1e-9, 77)
    assert found.W2 == found.W * found.W
    same = flow.constants_of((*MACHINE[:7], flow.AS_ON_THE_CAM), 1e-9, 77)
    assert same.r_seat == 0.75
    free = flow.constants_of((300.0, 1.5, 0.0, *MACHINE[3:]), 1e-9, 77)
    assert (free.W, free.W2, free.W_rest) == (0.0, 0.0, 0.0)
    assert flow.constants_of((*MACHINE[:7], 0.0), 1e-9, 77).r_seat == 0.0


def test_the_table_has_the_flow_over_every_row_of_stretches(monkeypatch):
    monkeypatch.setattr(flow, "flow", lambda const, s: (s, 2.0 * s, 3.0 * s))
    ends = [1.0, 3.0, TURN]
    made = Made(stretches=[Made(start=a, end=b) for a, b in zip([0.0, *ends], ends, strict=False)])
    rows = [flow.Flow() for _ in range(9)]
    flow.fill_flows(made, None, rows)
    lengths = [1.0, 2.0, TURN - 3.0]
    for i in range(3):
        for k in range(3):
            s = sum(lengths[j % 3] for j in range(i, i + k + 1))
            row = rows[3 * i + k]
            assert (row.b, row.b1, row.p) == pytest.approx((s, 2.0 * s, 3.0 * s))
