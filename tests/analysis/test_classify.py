"""Naming a motion: the model's labels, slow multipliers, chaos, and honest doubt."""

from types import SimpleNamespace

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import classify as module
from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.classify import (
    _chatter,
    _order,
    attractors,
    classify,
    classify_at,
    with_transient,
)
from camcli.analysis.integrate import Orbit
from camcli.kernel.orbit_loop import DETACHMENT, IMPACT

RUN = settings(600, 400)


def test_a_multiplier_of_minus_one_minus_a_hair_is_told_from_the_doubled_orbit(chapter):
    # the doubling lies at 739.31978022 rpm: 1e-5 relative on both sides nothing has settled yet
    below, above = (classify_at(chapter, rpm, RUN) for rpm in (739.3197, 739.3199))
    assert below.label == "P(1;1)"
    assert above.label == "P(2;1:1)"
    assert -1e-3 < below.exponents.largest < 0.0


def test_a_cycle_that_rounding_closed_gives_way_to_the_true_motion(chapter):
    # from rest, differences grow beyond all digits: in doubles it closes a cycle by accident
    tape = Orbit(chapter, 358.294, RUN).run()
    assert any(tape.chatter)
    assert classify_at(chapter, 358.294, RUN).label == "P(3;3:3:2)"


def test_coexisting_attractors_from_a_cloud_in_a_fixed_order(chapter):
    found = attractors(chapter, 358.5, settings(600, 150), 20, 0)
    assert [m.label for m in found] == ["P(1;2)", "P(3;3:3:2)"]
    speeds = classify(chapter, settings(600, 150), [358.5, 359.0], 20, threads=2)
    assert [(m.rpm, m.label) for m in speeds] == [
        (358.5, "P(1;2)"), (358.5, "P(3;3:3:2)"), (359.0, "P(1;2)"), (359.0, "P(3;3:3:2)"),
    ]  # fmt: skip


def test_solved_motions_stand_before_the_others_each_by_period_label_and_state():
    def motion(label, period=0, *state):
        orbit = SimpleNamespace(states=(state,)) if state else None
        return SimpleNamespace(orbit=orbit, period=period, label=label)

    in_order = [
        motion("P(1;1)", 1, 0.1, 0.2), motion("P(1;1)", 1, 0.1, 0.3), motion("P(1;1)", 1, 0.2, 0.1),
        motion("P(1;2)", 1, 0.0, 0.0), motion("P(2;1:1)", 2, 0.0, 0.0),
        motion("aperiodic"), motion("undecided"), motion("contact", 1),
    ]  # fmt: skip
    assert sorted([*in_order[5:], *in_order[2:5], *in_order[:2]], key=_order) == in_order


def test_the_transient_ends_where_the_orbit_is_reached(chapter):
    motion = with_transient(chapter, RUN, classify_at(chapter, 700.0, RUN))
    # |multiplier| 0.8 per turn: from the order of a metre to 1e-7 takes some 72 turns
    assert 50 < motion.transient < 120
    assert with_transient(chapter, RUN, classify_at(chapter, 100.0, RUN)).transient == 0
    short = settings(20, 400)  # less than the transient: it is followed for longer than asked
    fresh = classify_at(chapter, 700.0, RUN)
    assert with_transient(chapter, short, fresh).transient == motion.transient


@pytest.mark.parametrize(
    ("rates", "chatters", "found"),
    [
        ([1.0] * 30, [0, 0], "none"),  # equal ones are no burst
        ([*[0.9**k for k in range(9)], 1.0], [0, 0], "incomplete"),
        ([*[0.9**k for k in range(7)], 1.0] * 4, [0, 0], "none"),  # eight that fall, not nine
        ([*[0.9**-k for k in range(30)]], [0, 0], "none"),  # they grow
        ([1.0], [0, 1], "complete"),
        ([1.0], [0, 0, 1], "none"),  # in a turn that was cut
    ],
)
def test_a_burst_of_weaker_and_weaker_impacts_is_an_incomplete_chatter(rates, chatters, found):
    events = [(IMPACT, -rate) for rate in rates]
    between = [event for one in events for event in (one, (DETACHMENT, 0.0))]
    for rows in (events, between):
        kind, u = map(np.array, zip(*rows, strict=True))
        record = SimpleNamespace(periods=2, chatter=np.array(chatters), kind=kind, u=u)
        assert _chatter(record) == found


def test_a_record_without_impacts_has_no_chatter():
    nothing = np.empty(0)
    record = SimpleNamespace(periods=2, chatter=np.zeros(2), kind=nothing, u=nothing)
    assert _chatter(record) == "none"


@pytest.mark.parametrize("same", [True, False])
def test_the_end_of_a_start_that_doubles_lose_takes_the_place_of_theirs(chapter, monkeypatch, same):
    """Its orbit with all that belongs to it; how long it took to get there is not known."""
    mine = classify_at(chapter, 700.0, settings(600, 130))
    other = mine if same else classify_at(chapter, 190.0, settings(100, 130))
    after = module._AfterRest(other.orbit, other.exponents, other.record, HoldsFor.EXACT_DATA)
    monkeypatch.setattr(module, "_after_rest", lambda *_: after)
    for growth, found in ((1e10, mine), (1e11, other)):
        monkeypatch.setattr(module, "largest_growth", lambda *_, value=growth: value)
        end = module.own_end(chapter, settings(600, 130), mine)
        assert (end.label, end.chatter, end.impacts) == (found.label, found.chatter, found.impacts)
        assert end.orbit.states == found.orbit.states
        assert (end.transient is None) == (found is other and not same)
        assert end.holds_for == (None if growth < 7e10 else HoldsFor.EXACT_DATA)
    assert mine.chatter != other.chatter or same
