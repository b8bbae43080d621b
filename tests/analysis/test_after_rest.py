"""Where the motion after a rest ends: cycles, orbits, wandering, and what cannot be said."""

import json
from math import inf, log2
from pathlib import Path
from types import SimpleNamespace

import pytest
from mpmath import mp, mpf

from camcli.analysis import after_rest as module
from camcli.analysis.after_rest import (
    CYCLE,
    SETTLED,
    TURNS_FOLLOWED,
    UNKNOWN,
    WANDERS,
    After,
    after_first_rest,
    after_rest,
)
from camcli.analysis.classify import classify, classify_at, own_end
from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits.identify import departures
from camcli.cams.arcs import ArcsCam
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import settings
from tests.support.kernel_runs import GEOMETRY
from tests.support.make_flights import CHAPTER
from tests.support.oracle import ArcsCam as OracleCam
from tests.support.oracle import Oracle

RUN = settings(600, 400)
CORNER_B = 2.621124501166232  # rad
FLIGHTS = json.loads((Path(__file__).parents[1] / "support/flights.json").read_text())


def ends(system, rpm):
    return after_first_rest(system, rpm, Orbit(system, rpm, settings(0, 3)).run())


def test_which_machines_an_answer_is_about(chapter, monkeypatch):
    """All whose speed reads so where errors grow little; else these data."""
    assert ends(chapter, 203.0).holds_for == "last-digit"
    assert ends(chapter, 358.0).holds_for == "exact-data"
    assert ends(chapter, 358.3).holds_for == "exact-data"
    assert ends(chapter, 745.0).holds_for is None
    one, other = (After(SETTLED, 50, ((q, 1.0),), (2.0,)) for q in (0.3, 0.4))
    for every, holds_for in ((one, "last-digit"), (other, "exact-data")):
        answers = iter([one, every])
        monkeypatch.setattr(module, "of_machine", lambda *words, a=answers, **more: next(a))
        assert after_rest(chapter, 358.0, 2.6).holds_for == holds_for


def test_speeds_are_not_followed_all_at_once_where_errors_have_grown_beyond_hope(
    chapter, monkeypatch
):
    """At 358.0 errors grow by 1e46: all speeds that round so cannot come back together."""
    motion = module.of_machine(chapter, 358.0, CORNER_B)
    assert motion.lost == pytest.approx(46 * log2(10.0), abs=8.0)
    assert module.of_machine(chapter, 358.0, CORNER_B, all_that_read_alike=True).kind == UNKNOWN
    asked = []
    follow = module.of_machine
    monkeypatch.setattr(
        module, "of_machine", lambda *words, **more: asked.append(more) or follow(*words, **more)
    )
    assert after_rest(chapter, 358.0, CORNER_B).holds_for == "exact-data"
    assert after_rest(chapter, 203.0, CORNER_B).holds_for == "last-digit"
    assert asked == [{}, {}, {"all_that_read_alike": True}]


@pytest.mark.parametrize("rpm", [347.81954887218046, 365.0375939849624])
def test_a_state_is_the_same_double_with_more_digits(rpm):
    """With 60 digits both come back to their rest, but with a state of some 10 digits."""
    scene = load_scene(None)
    follower = Follower(**scene.follower.model_dump())
    system = System.build(follower, scene.cam)
    _, theta = departures(Orbit(system, rpm, settings(0, 3)).run())[0]
    few, many = (
        module.followed(scene.cam, follower, 0.0, rpm, theta, False, False, digits)
        for digits in ((60, 180), (180,))
    )
    assert few.kind == CYCLE
    assert few == many


def test_a_motion_with_too_many_impacts_before_the_first_strobe_is_not_known():
    trail = SimpleNamespace(states=[], impacts=[None])
    assert module._until_it_repeats(SimpleNamespace(trail=trail), 1.0, most_impacts=1) == After(
        UNKNOWN
    )


@pytest.mark.parametrize("rpm", [357.9, 358.0, 358.5, 359.0])
def test_chaotic_transients_settle(chapter, rpm):
    """At 358.0 errors grow by 1e46 on the way: 40 digits of the cam's corners would not do."""
    found = ends(chapter, rpm)
    assert found.kind == SETTLED
    assert sorted(found.symbols) == [2.0, 3.0, 3.0]
    tape = Orbit(chapter, rpm, settings(60, 30), found.start(chapter, rpm)).run()
    assert not any(tape.chatter[:30])
    assert sorted(int(x) for x in tape.impacts[:3]) == [2, 3, 3]
    assert classify_at(chapter, rpm, RUN).label == "P(3;3:3:2)"


def test_a_long_cycle_is_the_oracles():
    """Impacts in each of 28 turns, on the cam of `flights.json`."""
    shape = ArcsCam(kind="arcs", **GEOMETRY)
    system = System.build(Follower(**CHAPTER), shape)
    found = module.of_machine(system, 358.0, 2.621124501166232)
    assert (found.kind, found.turns) == (CYCLE, 28)
    events = FLIGHTS["long transient"]["events"]
    turns = [int(float(phi) / 6.283185307179586) for kind, phi, _ in events if kind == "impact"]
    counts = [float(turns.count(k)) for k in range(1, 28)]
    assert list(found.symbols[:27]) == counts
    assert found.symbols[27] == inf
    assert found.leaves == ((27, pytest.approx(2.621124501166232, abs=1e-15)),)


def test_the_end_of_the_own_start_is_the_oracles():
    """At 358.12 rpm doubles end on P(3;3:3:2), the machine on 22 turns through a chatter."""
    system = System.build(Follower(**CHAPTER), ArcsCam(kind="arcs", **GEOMETRY))
    oracle = Oracle(OracleCam(), **CHAPTER, rpm=358.12, digits=100)
    with mp.workdps(150):
        whole = 2 * mp.pi * 23
        found = oracle._run(mpf(0), whole, mpf("1e-22"), 0, oracle.rpm, oracle.r, None, None)
        events = [(event.kind, int(event.psi / (2 * mp.pi))) for event in found]
        leaves = float(next(event.psi for event in found if event.kind == "detachment"))
    counts = [sum(event == ("impact", k) for event in events) for k in range(1, 22)]
    assert [event for event in events if event[0] != "impact"] == [
        ("detachment", 0), ("chatter", 22), ("detachment", 22)
    ]  # fmt: skip
    own = own_end(system, RUN, classify_at(system, 358.12, RUN))
    assert own.label.symbols == (inf, *counts)
    assert (own.holds_for, own.chatter, own.transient) == ("exact-data", "complete", None)
    assert (own.orbit.label, own.orbit.resting, own.period) == (own.label, True, 22)
    assert own.orbit.theta == pytest.approx((leaves,), abs=1e-9)
    assert (own.impacts, own.exponents.largest, own.exponents.impacts) == (inf, -inf, inf)
    doubles = Orbit(system, 358.12, settings(600, 400)).run()
    assert not any(doubles.chatter)
    assert [m.label for m in classify(system, RUN, [358.12])] == [own.label]


@pytest.mark.parametrize(
    ("rpm", "label", "holds_for"),
    [
        (358.41, "P(3;3:3:2)", None),  # doubles remember the rest until the orbit is reached
        (358.236, "P(3;3:3:2)", "exact-data"),
        (359.57, "P(3;3:3:2)", "rounding"),  # not settled after TURNS_FOLLOWED turns
    ],
)
def test_a_row_says_whether_rounding_chose_its_attractor(rpm, label, holds_for):
    system = System.build(Follower(**CHAPTER), ArcsCam(kind="arcs", **GEOMETRY))
    (found,) = classify(system, RUN, [rpm])
    assert (found.label, found.holds_for) == (label, holds_for)
    ball = ends(system, rpm)
    assert ball.kind == (WANDERS if holds_for == "rounding" else SETTLED)


def test_cycles_are_orbits(chapter):
    assert (ends(chapter, 190.0).kind, ends(chapter, 190.0).symbols) == (CYCLE, (inf,))
    assert ends(chapter, 190.0).start(chapter, 190.0) is None
    motion = classify_at(chapter, 358.3, RUN)  # errors grow by 4e13 in its 28 turns
    assert motion.period == 28
    assert motion.orbit.resting
    assert motion.label.startswith("P(28;inf:")


def test_a_ball_without_spring_and_damper_comes_back_to_its_rest():
    """Found for these data, and by machines within the last digit of the speed as well."""
    scene = load_scene("configs/bouncing-ball.yaml")
    system = System.build(Follower(**scene.follower.model_dump()), scene.cam)
    found = ends(system, 1225.0)
    assert (found.kind, found.turns, found.holds_for) == (CYCLE, 25, "exact-data")
    assert found.symbols.count(inf) == 1


def test_what_is_not_known_is_not_said(chapter):
    free = Orbit(chapter, 700.0, settings(600, 20)).run()
    assert after_first_rest(chapter, 700.0, free).kind == UNKNOWN  # no rest in it


def test_chaos_wanders_and_gives_its_last_state(chapter):
    found = ends(chapter, 745.0)
    assert (found.kind, found.turns) == (WANDERS, TURNS_FOLLOWED)
    assert found.start(chapter, 745.0) is not None
