"""Where the motion after a rest ends: against the oracle, cycles, and what cannot be said."""

from dataclasses import replace
from decimal import Decimal, localcontext

import pytest
from conftest import chapter_system, settings
from mpmath import mp

from camcli.analysis.classify import classify_at
from camcli.analysis.integrate import Orbit
from camcli.exact import after_rest as after
from camcli.exact.after_rest import CYCLE, SETTLED, UNKNOWN, WANDERS, After, after_rest, ends
from camcli.exact.drive import DIGITS
from camcli.exact.settled import repeats
from tests.analysis.test_rest_motion import oracle_of

RUN = settings(600, 400)


def record(system, rpm, turns=3):
    return Orbit(system, rpm, settings(0, turns)).run()


def turn_counts(oracle, first, turns):
    """Impacts in each of the oracle's turns from one on."""
    events = oracle.run(turns=first + turns)
    hits = [e.turn for e in events if e.kind == "impact"]
    return [hits.count(turn) for turn in range(first, first + turns)]


@pytest.mark.parametrize("rpm", [357.9, 358.2, 358.4, 358.5, 358.6, 358.8, 358.9, 359.0])
def test_the_end_is_the_oracles(chapter, rpm):
    found = ends(chapter, rpm, RUN, record(chapter, rpm))
    assert found.kind == SETTLED
    assert sorted(found.symbols) == [2.0, 3.0, 3.0]
    counts = turn_counts(oracle_of(chapter, rpm), found.turns - 3, 6)
    assert counts[:3] == counts[3:]
    assert [float(count) for count in counts[:3]] == list(found.symbols)
    assert classify_at(chapter, rpm, RUN).label == "P(3;3:3:2)"


def test_where_doubles_may_take_over(chapter):
    start = after_rest(chapter, 358.8, RUN, record(chapter, 358.8))
    tape = Orbit(chapter, 358.8, settings(60, 200), start).run()
    assert not any(tape.chatter)
    assert sorted(int(x) for x in tape.impacts[:3]) == [2, 3, 3]


def test_a_cycle_that_forgets_little_is_the_machines(chapter):
    found = ends(chapter, 190.0, RUN, record(chapter, 190.0))
    assert (found.kind, found.turns, found.symbols) == (CYCLE, 1, (mp.inf,))
    assert found.growth < 1e6
    assert found.start(chapter, 190.0) is None


def test_a_long_cycle_that_neighbours_share_is_an_orbit(chapter):
    """At 358.3 rpm an error grows by 4e13 in 28 turns: too much for doubles, not for the data."""
    found = ends(chapter, 358.3, RUN, record(chapter, 358.3))
    assert (found.kind, found.turns) == (CYCLE, 28)
    assert 7e10 < found.growth < 1e16
    motion = classify_at(chapter, 358.3, RUN)
    assert motion.period == 28
    assert motion.orbit.resting
    assert motion.label.startswith("P(28;inf:")
    events = oracle_of(chapter, 358.3).run(turns=58)
    kinds = [(e.kind, e.turn) for e in events if e.kind != "impact"]
    assert kinds == [
        ("detachment", 0), ("chatter", 28), ("detachment", 28), ("chatter", 56), ("detachment", 56),
    ]  # fmt: skip


def test_a_cycle_that_hangs_on_digits_no_scene_has_is_left(chapter, monkeypatch):
    """At 358.0 the very doubles close a cycle of 78 turns; speeds 1e-17 beside settle."""
    with localcontext() as context:
        context.prec = DIGITS
        cycle = after._one(chapter, 358.0, RUN, 2.621124501166232)
        beside = after._one(chapter, 358.0, RUN, 2.621124501166232, after.SHARES[0])
    assert (cycle.kind, cycle.turns) == (CYCLE, 78)
    assert cycle.growth > 1e17
    assert (beside.kind, beside.turns) != (CYCLE, 78)
    assert ends(chapter, 358.0, RUN, record(chapter, 358.0)).kind == SETTLED
    monkeypatch.setattr(after, "SHARES", ())
    assert ends(chapter, 358.0, RUN, record(chapter, 358.0)).kind == UNKNOWN


def test_neighbours_that_disagree_say_nothing(monkeypatch):
    cycle = After(CYCLE, 9, symbols=(1.0,), growth=1e20)
    one, two = (After(SETTLED, 50, ((q, 1.0),), (2.0,)) for q in (0.3, 0.4))
    for row, kind in (((one, one, one), SETTLED), ((one, two, one), UNKNOWN),
                      ((one, cycle, one), UNKNOWN), ((cycle, cycle, cycle), CYCLE),
                      ((one, one), UNKNOWN)):  # fmt: skip
        answers = iter([cycle, *row, *[replace(cycle, symbols=(7.0,))] * 9])
        monkeypatch.setattr(after, "_one", lambda *words, a=answers: next(a))
        assert after.follow(chapter_system(), 358.0, RUN, 2.6).kind == kind, row


def test_what_is_not_known_is_not_said(chapter):
    bare = replace(chapter, parts=None)
    assert ends(bare, 358.8, RUN, record(bare, 358.8)).kind == UNKNOWN
    assert after_rest(bare, 358.8, RUN, record(bare, 358.8)) is None
    assert classify_at(bare, 358.8, RUN).label == "undecided"
    chaos = ends(chapter, 745.0, RUN, record(chapter, 745.0))
    assert (chaos.kind, chaos.reason) == (UNKNOWN, "no digit is left")
    free = Orbit(chapter, 700.0, settings(600, 20)).run()
    assert ends(chapter, 700.0, RUN, free).kind == UNKNOWN  # no rest in it


def test_weak_chaos_wanders_and_gives_its_last_state(chapter):
    found = ends(chapter, 361.0, RUN, record(chapter, 361.0))
    assert (found.kind, found.turns) == (WANDERS, after.LONGEST)
    assert found.start(chapter, 361.0) is not None


def test_a_record_repeats_once_it_shrinks():
    def states(ratio, n=40):
        return [(1.0 + (k % 3) + 1e-3 * ratio**k, 2.0) for k in range(n)]

    symbols = [3.0, 3.0, 2.0] * 14
    assert repeats(states(0.6), symbols[:40]) == 3
    assert repeats(states(0.999), symbols[:40]) == 0
    assert repeats(states(0.6, 12), symbols[:12]) == 0
    assert repeats(states(0.6), [*symbols[:39], 9.0]) == 0
    assert repeats([], []) == 0


def test_nothing_is_imported_where_nothing_forgets():
    import subprocess
    import sys

    code = (
        "import sys; sys.path[:0] = ['.', 'tests']\n"
        "from tests.conftest import chapter_system, settings\n"
        "from camcli.analysis.classify import classify_at\n"
        "assert classify_at(chapter_system(), 190.0, settings(60, 100)).label == 'P(1;inf)'\n"
        "assert not any('analysis.rest' in name for name in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_shares_are_within_half_a_last_digit():
    assert all(Decimal(0) < abs(share) < Decimal("5.5e-17") for share in after.SHARES)
    assert len(set(after.SHARES)) == len(after.SHARES) >= 2 * after.ENOUGH
