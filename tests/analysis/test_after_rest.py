"""Where the motion after a rest ends: cycles, orbits, wandering, and what cannot be said."""

import json
from dataclasses import replace
from decimal import Decimal
from math import inf
from pathlib import Path

import pytest

from camcli.analysis import after_rest as module
from camcli.analysis.after_rest import (
    CYCLE,
    ENOUGH,
    LONGEST,
    SETTLED,
    SHARES,
    UNKNOWN,
    WANDERS,
    After,
    after_first_rest,
    after_rest,
)
from camcli.analysis.classify import classify_at
from camcli.analysis.integrate import Orbit
from camcli.cams.arcs import ArcsCam
from camcli.system import Follower, System
from tests.conftest import settings
from tests.exact.make_flights import CHAPTER
from tests.kernel.helpers import GEOMETRY

RUN = settings(600, 400)
FLIGHTS = json.loads((Path(__file__).parents[1] / "exact/flights.json").read_text())


def ends(system, rpm):
    return after_first_rest(system, rpm, Orbit(system, rpm, settings(0, 3)).run())


def test_which_machines_an_answer_is_about(chapter, monkeypatch):
    """All whose speed reads so where errors grow little; else these data, or some neighbours."""
    assert ends(chapter, 203.0).holds_for == "last-digit"
    assert ends(chapter, 358.0).holds_for == "exact-data"
    assert ends(chapter, 358.3).holds_for == "sampled"
    assert ends(chapter, 745.0).holds_for is None
    one, other = (After(SETTLED, 50, ((q, 1.0),), (2.0,)) for q in (0.3, 0.4))
    for every, holds_for in ((one, "last-digit"), (other, "exact-data")):
        answers = iter([one, every])
        monkeypatch.setattr(module, "of_machine", lambda *words, a=answers: next(a))
        assert after_rest(chapter, 358.0, 2.6).holds_for == holds_for


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


def test_cycles_that_neighbours_share_are_orbits(chapter):
    assert (ends(chapter, 190.0).kind, ends(chapter, 190.0).symbols) == (CYCLE, (inf,))
    assert ends(chapter, 190.0).start(chapter, 190.0) is None
    motion = classify_at(chapter, 358.3, RUN)  # errors grow by 4e13 in its 28 turns
    assert motion.period == 28
    assert motion.orbit.resting
    assert motion.label.startswith("P(28;inf:")


def test_neighbours_that_disagree_say_nothing(chapter, monkeypatch):
    cycle = After(CYCLE, 9, symbols=(1.0,))
    one, two = (After(SETTLED, 50, ((q, 1.0),), (2.0,)) for q in (0.3, 0.4))
    for row, kind in (((one, one, one), SETTLED), ((one, two, one), UNKNOWN),
                      ((one, cycle, one), UNKNOWN), ((cycle, cycle, cycle), CYCLE),
                      ((one, one), UNKNOWN), ((), UNKNOWN)):  # fmt: skip
        answers = iter([cycle, After(UNKNOWN), *row, *[replace(cycle, symbols=(7.0,))] * 9])
        monkeypatch.setattr(module, "of_machine", lambda *words, a=answers: next(a))
        found = after_rest(chapter, 358.0, 2.6)
        assert found.kind == kind, row
        assert found.holds_for == (None if kind == UNKNOWN else "sampled")
    assert all(0 < abs(share) < Decimal("5.5e-17") for share in SHARES)  # within half a digit
    assert len(set(SHARES)) == len(SHARES) >= 2 * ENOUGH


def test_what_is_not_known_is_not_said(chapter):
    free = Orbit(chapter, 700.0, settings(600, 20)).run()
    assert after_first_rest(chapter, 700.0, free).kind == UNKNOWN  # no rest in it


def test_chaos_wanders_and_gives_its_last_state(chapter):
    found = ends(chapter, 745.0)
    assert (found.kind, found.turns) == (WANDERS, LONGEST)
    assert found.start(chapter, 745.0) is not None
