"""From impacts of a record to an orbit: turns, counts of impacts and places are told apart."""

from dataclasses import replace
from math import pi
from types import SimpleNamespace as Made

import numpy as np
import pytest
from conftest import chapter_system, settings, solve_from

from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits import identify as module
from camcli.analysis.orbits.identify import (
    MOST_SOLVED,
    RecordedImpact,
    _bouncing,
    _in_order,
    _placed,
    _solved,
    departures,
    identify,
    impacts_of,
    newton_from,
)
from camcli.analysis.orbits.shooter import Shooter
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT

RPM, TURN = 358.5, 2.0 * pi
LANDINGS = {3: 8, 6: 16, 9: 24}  # impacts of P(3;3:3:2) in so many turns


@pytest.fixture(scope="module", params=[0.0, 251.0])
def motion(request):
    """(shooter, record) of P(3;3:3:2), with the strobe in two places."""
    system = chapter_system(request.param)
    return Shooter(system, RPM), Orbit(system, RPM, settings(600, 24)).run()


@pytest.mark.parametrize(("turns", "count"), LANDINGS.items())
def test_an_orbit_gone_through_several_times_is_solved_once(motion, turns, count):
    """Its impacts are those of the record, in phase, rate and turn since the first one."""
    shooter, record = motion
    impacts = impacts_of(record, range(24 - turns, 24))
    assert len(impacts) == count
    orbit = _solved(shooter, impacts, turns)
    assert (orbit.turns, orbit.impacts, str(orbit.label)) == (3, 8, "P(3;3:3:2)")
    root = orbit.root
    first = None
    for k, (period, theta, u) in enumerate(impacts[:8]):
        assert root.theta[k] == pytest.approx(theta, abs=1e-6)
        assert root.rates[k] == pytest.approx(u, rel=1e-5)
        since = TURN * period + (theta - shooter.system.strobe) % TURN
        first = since if first is None else first
        there = TURN * root.turn(k) + root.theta[k] - TURN * root.turn(0) - root.theta[0]
        assert there == pytest.approx(since - first, abs=1e-6)
    assert newton_from(shooter, impacts, turns).count == count


def test_an_orbit_that_clearly_repels_is_put_aside_at_once(monkeypatch):
    """In chaos a record is near many such orbits, and the states of long ones take long."""
    shooter = Shooter(chapter_system(), 745.0)
    record = Orbit(shooter.system, 745.0, settings(600, 400)).run()
    repelling = []
    for turns in range(2, 20):
        impacts = impacts_of(record, range(400 - turns, 400))
        root = newton_from(shooter, impacts, turns)
        if root is not None and abs(root.trace) > 2.0:
            repelling.append((impacts, turns))
    assert len(repelling) > 3
    monkeypatch.setattr(module, "section_states", None)  # asked for, it would raise
    assert [_solved(shooter, *motion) for motion in repelling] == [None] * len(repelling)


def test_impacts_and_symbols_of_the_record_must_be_those_of_the_orbit(motion):
    """In any rotation: of six turns twice those of three. The end must come near the orbit."""
    shooter, record = motion
    end = record.strobe_q[-1], record.strobe_w[-1]

    def found(turns, symbols, last=end, gap=0.0):
        impacts = impacts_of(record, range(24 - turns, 24))
        return _bouncing(shooter, impacts, turns, gap, last, symbols)

    for turns, symbols in ((3, (2, 3, 3)), (3, (3, 2, 3)), (6, (3, 3, 2, 3, 2, 3))):
        assert found(turns, symbols).turns == 3
    for turns, symbols in ((3, (3, 3, 3)), (3, (3, 3, 2, 0)), (6, (3, 3, 2)), (6, (3, 3, 2) * 3)):
        assert found(turns, symbols) is None
    off = end[0] + 1e-4, end[1]
    assert found(3, (3, 3, 2), off) is None
    assert found(3, (3, 3, 2), off, gap=1e-3).turns == 3


def test_a_repeated_pattern_is_needed_twice_in_a_row(motion):
    """Nothing is solved for turns whose counts of impacts are not those of the turns before."""
    shooter, record = motion
    assert identify(shooter.system, RPM, record).turns == 3
    for turn, turns in ((23, None), (20, None), (5, 3)):
        impacts = record.impacts.copy()
        impacts[turn] += 1
        found = identify(shooter.system, RPM, record._replace(impacts=impacts), longest=3)
        assert (found and found.turns) == turns


@pytest.mark.parametrize("count", [0, 1, MOST_SOLVED, MOST_SOLVED + 1])
def test_how_many_impacts_are_solved_at_most(monkeypatch, count):
    tried = []
    system = Made(strobe=1.0, cam=None, restitution=lambda i: 0.5 + 0.25 * i)
    shooter = Made(system=system, value=RPM, at_value=lambda *given: tried.append(given))
    monkeypatch.setattr(module, "settled", lambda shooter, root: "settled")
    monkeypatch.setattr(module, "stretch_at", lambda cam, theta: int(theta > 1.5))
    rows = [(7, 2.0, -0.5), (7, 0.5, -0.25), (8, 1.0, -0.125)]
    impacts = [RecordedImpact(*row) for row in rows[:count]]
    impacts += [RecordedImpact(9, 1.0, -0.5)] * (count - len(impacts))
    solved = 0 < count <= MOST_SOLVED
    assert newton_from(shooter, impacts, 3) == ("settled" if solved else None)
    assert len(tried) == solved
    if count > 2:
        assert MOST_SOLVED == 2000
    if count == MOST_SOLVED:  # before the strobe at 1 rad the next turn of the cam has begun
        guess, whole, turns, value = tried[0]
        assert guess[:6] == [2.0, 0.375, 0.5, 0.125, 1.0, 0.0625]
        assert whole[:8] == [1, 0, 0, 1, 0, 1, 0, 2]
        assert (guess[-1], turns, value) == (RPM, 3, RPM)


def test_impacts_stay_in_their_turn_and_on_their_stretch():
    """An impact that has moved over the angle zero is in the turn beside, at the same place."""
    system = chapter_system()
    root = solve_from(system, RPM, settings(600)).root
    assert _placed(system, root) == (root.x, root.whole)
    ends = np.radians([0.0, 90.0, 150.1793714951576, 160.0, 200.0, 209.8206285048424, 270.0, 360.0])
    for k in range(root.count):
        for theta in (-0.25, TURN + 0.25, *(ends[:-1] + 1e-3)):
            x = [theta if j == 2 * k else value for j, value in enumerate(root.x)]
            moved, whole = _placed(system, replace(root, x=x))
            wanted = theta % TURN
            assert moved == [
                pytest.approx(wanted) if j == 2 * k else value for j, value in enumerate(root.x)
            ]
            stretch = int(np.searchsorted(ends, wanted)) - 1
            turn = root.turn(k) + int(theta // TURN)
            assert whole == (*root.whole[: 2 * k], stretch, turn, *root.whole[2 * k + 2 :])
        for theta in (-TURN - 0.25, 2.0 * TURN + 0.25):
            x = [theta if j == 2 * k else value for j, value in enumerate(root.x)]
            assert _placed(system, replace(root, x=x)) is None


@pytest.mark.parametrize(
    ("thetas", "turns_of", "turns", "in_order"),
    [
        ([1.0], [0], 1, True),
        ([1.0, 2.0], [0, 0], 1, True),
        ([2.0, 1.0], [0, 0], 1, False),
        ([2.0, 1.0], [0, 1], 1, True),
        ([2.0, 2.5], [0, 1], 1, False),
        ([2.0, 2.5], [0, 1], 2, True),
        ([2.0, 2.0], [0, 0], 1, False),
        ([1.0, 6.0, 1.5], [0, 0, 1], 1, False),
    ],
)
def test_impacts_follow_each_other_within_the_period(thetas, turns_of, turns, in_order):
    root = Made(theta=thetas, turn=turns_of.__getitem__, turns=turns)
    assert _in_order(root) == in_order


def test_where_the_follower_leaves_from_rest():
    """With a lift-off, or with an impact where it rested after a chatter, and not one of a hop."""
    kind = [IMPACT, CHATTER, IMPACT, IMPACT, CHATTER, DETACHMENT, IMPACT, DETACHMENT, CHATTER]
    period = [0, 0, 1, 1, 2, 3, 3, 4, 5]
    theta = [0.5 + 0.25 * k for k in range(9)]
    record = Made(kind=np.array(kind), period=np.array(period), theta=np.array(theta))
    assert departures(record) == [(1, 1.0), (3, 1.75), (4, 2.25)]
