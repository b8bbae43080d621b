"""Many starts at once: the same orbits as one at a time, in plain Python and compiled."""

import numpy as np
import pytest

from camcli.analysis import integrate as engine
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches
from camcli.kernel import backend
from camcli.kernel.cells import CHATTERED_TURN, FORGOTTEN, GOES_ON, NEW_REST, UNDECIDED, Point, Rest
from camcli.kernel.forms import PLAIN
from camcli.kernel.orbit_loop import RESTING
from tests.conftest import settings
from tests.support.kernel_runs import system

STARTS = [(0.3, -1.0), (0.55, 32.0), (0.1, 5.0), (0.2, -40.0), (1.1, 12.0), (0.1, 0.0), (0.1, -3.0)]


def batches(rpm=358.5, machine=None, **changes):
    return CellBatches(machine or system(), rpm, settings(**changes))


def ends(team, turns, targets=NOTHING, starts=STARTS):
    q, v = np.array(starts).T
    return team.run(*team.states(q, v), targets, turns)


@pytest.mark.parametrize("rpm", [358.5, 190.0, 745.0])
def test_a_cell_is_the_orbit_of_its_start(rpm):
    team, impacts = batches(rpm), 0
    found = ends(team, 12)
    for k, (q, v) in enumerate(STARTS):
        orbit = engine.Orbit(system(), rpm, settings(record=12, q=q, v=v))
        tape = orbit.run(events=False)
        impacts += tape.cost.impacts
        assert (orbit.state.gap, orbit.state.gap_rate) == (found.gap[k], found.rate[k])
        chattered = tape.chatter[11]
        assert found.symbol[k] == (CHATTERED_TURN if chattered else tape.impacts[11])
        assert found.turns[k] == 12
        assert found.outcome[k] == UNDECIDED
    assert team.cost.impacts == impacts > 12


def known_orbit():
    """Targets of P(1;2) at 358.5 rpm, circles of 1e-3 about its point, to be halved in a turn."""
    point = batches().run([0.4459], [0.865], NOTHING, 2000)
    row = [float(point.gap[0]), float(point.rate[0]), 1e6, 0.0, 1e6, 0.5]
    return NOTHING._replace(points=[Point(*row, 0, 0, 2, 1)])


def test_an_attractor_is_met_after_a_whole_period_that_shrinks():
    targets = known_orbit()
    met = ends(batches(), 500, targets)
    assert met.outcome[1] == 0
    assert met.turns[1] < 40
    point = np.array(targets.points[0][:2])
    assert np.abs(np.array([met.gap[1], met.rate[1]]) - point).max() < 1e-3
    strict = targets._replace(
        points=[targets.points[0]._replace(shrink=0.0)]
    )  # never shrinks enough
    late = ends(batches(), 500, strict)
    assert late.outcome[1] == 0
    assert late.turns[1] > met.turns[1] + 5


@pytest.mark.parametrize("symbol", [1, 3, CHATTERED_TURN])
def test_other_impacts_are_another_orbit(symbol):
    targets = known_orbit()
    targets = targets._replace(points=[targets.points[0]._replace(symbol=symbol)])
    assert (ends(batches(), 300, targets).outcome == UNDECIDED).all()


@pytest.mark.parametrize("outcome", [0, FORGOTTEN, GOES_ON])
def test_known_states_after_a_rest_have_their_outcome(outcome):
    team = batches(190.0)
    first = ends(team, 20, NOTHING._replace(watch_rests=1))
    state = [float(first.gap[0]), float(first.rate[0])]
    known = NOTHING._replace(rests=[Rest(*state, outcome)], watch_rests=1, near=1e-9)
    found = ends(team, 20, known)
    same = (abs(first.gap - state[0]) <= 1e-9) & (abs(first.rate - state[1]) <= 1e-9)
    assert same[0]
    assert not same.all()
    if outcome == GOES_ON:
        assert (found.turns[same] > first.turns[same]).all()
    else:
        assert (found.outcome[same] == outcome).all()
        assert (found.turns[same] == first.turns[same]).all()
    assert (found.outcome[~same] == NEW_REST).all()


@pytest.mark.parametrize("rpm", [358.5, 190.0])
def test_plain_python_and_compiled_give_the_same_bits(rpm, monkeypatch):
    targets = known_orbit() if rpm == 358.5 else NOTHING
    assert backend.compiled().compiled
    compiled = ends(batches(rpm), 30, targets)
    monkeypatch.setattr(backend, "for_work", lambda *_: PLAIN)
    plain = ends(batches(rpm), 30, targets)
    for name in ("gap", "rate", "mode", "outcome", "turns", "stay", "symbol"):
        assert getattr(plain, name).tolist() == getattr(compiled, name).tolist(), name
    if rpm == 190.0:
        assert CHATTERED_TURN in plain.symbol
        stops = NOTHING._replace(watch_rests=1)
        assert ends(batches(rpm), 30, stops).outcome.tolist() == [NEW_REST] * len(STARTS)
    assert RESTING in ends(batches(100.0), 30).mode


def test_a_ring_of_two_ellipses_is_left_outside_the_smaller():
    """P(1;2) as two points in one place: a start in the wide ellipse misses the narrow one."""
    team = batches()
    before, settled = ends(team, 900), ends(team, 901)
    k = int(np.flatnonzero((before.symbol == 2) & (settled.symbol == 2))[0])
    gap, rate = settled.gap[k], settled.rate[k]
    start = (np.array([gap * 1.001]), np.array([rate]))
    first = team.run(*start, NOTHING, 1)
    off = abs(first.gap[0] - gap), abs(first.rate[0] - rate)
    wide = Point(gap, rate, 1e-15, 0.0, 1e-15, 0.9, 0, 1, 2, 2)
    for size, outcome in ((25.0, UNDECIDED), (0.5, 0)):  # of the next strobe in the narrow ellipse
        form = 0.5 * size / off[0] ** 2, 0.0, 0.5 * size / off[1] ** 2
        narrow = Point(gap, rate, *form, 0.9, 0, 0, 2, 2)
        targets = NOTHING._replace(points=[wide, narrow])
        assert team.run(*start, targets, 2).outcome[0] == outcome


def test_a_rest_is_known_by_gap_and_rate():
    team = batches(190.0)
    after = ends(team, 5, starts=STARTS[:1])
    assert after.symbol[0] == CHATTERED_TURN
    for rate, outcome in ((after.rate[0], FORGOTTEN), (after.rate[0] + 1e-3, NEW_REST)):
        rests = [Rest(after.gap[0], rate, FORGOTTEN)]
        targets = NOTHING._replace(rests=rests, watch_rests=1, near=1e-9)
        assert ends(team, 5, targets, STARTS[:1]).outcome[0] == outcome


def test_a_stay_is_in_the_boxes_of_one_attractor():
    """A motion to and fro between two boxes, at 740 rpm, one on either side of q = 1.3615."""
    team = batches(740.0)
    begin = engine.Orbit(system(), 740.0, settings(600, 1)).run()
    start = [(float(begin.strobe_q[0]), float(begin.strobe_w[0]) * team.omega)]
    lift = team.lift[0]
    table = NOTHING._replace(
        gap=1.3615 - lift - 0.5, per_gap=2.0, rate=-100.0, per_rate=0.005, columns=2, rows=1
    )
    for boxes, outcome in (([1, 2], UNDECIDED), ([1, 1], 0), ([2, 2], 1)):
        targets = table._replace(boxes=boxes, stay=[3, 3])
        assert ends(team, 12, targets, start).outcome[0] == outcome, boxes
