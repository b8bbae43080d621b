"""When a motion after a rest repeats, and which cycle it closes, on states written down."""

from __future__ import annotations

from types import SimpleNamespace as Stub

import pytest
from flint import arb

from camcli.analysis import after_rest as module
from camcli.analysis.after_rest import CYCLE, SETTLED, UNKNOWN, WANDERS, After, repeats
from camcli.cams.balls import UndecidedError
from camcli.exact import machine as exact_machine
from camcli.exact import quick_motion
from camcli.exact.motion import EndlessError


class Ball(float):
    """A number, and how far off it may be."""

    def __new__(cls, value, off=0.0):
        found = super().__new__(cls, value)
        found.off = off
        return found

    def rad(self):
        return self.off


def beside(places, distances):
    """States that go round some places, each so far from its own."""
    return [
        (q + distance, w - distance)
        for (q, w), distance in zip(places * len(distances), distances, strict=False)
    ]


PLACES = [(0.5, -1.0), (0.25, 2.0)]


@pytest.mark.parametrize(
    ("away", "m"),
    [
        ([0.0] * 7, 2),
        ([0.0] * 6, 0),  # three periods and a state more are needed
        ([1e-9 * 0.5**k for k in range(7)], 2),  # each nearer than the one before
        ([1e-9 * 0.99**k for k in range(7)], 0),
        ([1e-9 * 1.5**k for k in range(7)], 0),
        ([1e-7 * 0.1**k for k in range(7)], 2),
        ([1e-3 * 0.7**k for k in range(7)], 0),  # too far
        ([0.0, 1e-9, 0.0, 2e-9, 0.0, 0.0, 0.0], 2),  # nothing is left at last
    ],
)
def test_states_repeat_where_each_period_is_nearer_to_the_one_before(away, m):
    states = beside(PLACES, away)
    symbols = [2.0, 3.0] * 4
    assert repeats(states, symbols[: len(states)], (0.5, 2.0)) == m
    if m:
        wrong = [*symbols[: len(states)]]
        wrong[-2] = 9.0
        assert repeats(states, wrong, (0.5, 2.0)) == 0


@pytest.mark.parametrize(
    ("steps", "does"),
    [((4.0, 2.0, 1.0), True), ((1.0, 2.0, 1.0), False), ((4.0, 2.0, 1.95), False),
     ((4.0, 3.9, 1.0), False), ((4.0, 3.79, 3.59), True)],
)  # fmt: skip
def test_both_of_the_last_two_steps_shrink(steps, does):
    """By a twentieth at least."""
    first, second, third = (1e-9 * step for step in steps)
    at = [0.0, first, first + second, first + second + third]
    states = [(0.5 + x, -1.0 + 2.0 * x) for x in at]
    assert repeats(states, [1.0] * 4, (0.5, 1.0)) == (1 if does else 0)


def test_one_state_alone_or_two_do_not_repeat():
    for n in (1, 2, 3):
        assert repeats([PLACES[0]] * n, [1.0] * n, (0.5, 1.0)) == 0
    assert repeats([PLACES[0]] * 4, [1.0] * 4, (0.5, 1.0)) == 1


def moving(states, *, per_step=1, leaves_at=(), symbols=None, impacts=1):
    """A motion with one state more, or some, at each step; it leaves a rest at some of them."""
    trail = Stub(states=[], symbols=[], leaves=[], impacts=[])
    motion = Stub(trail=trail, turn=arb(4), steps=0)
    of_turns = []

    def step():
        motion.steps += 1
        for _ in range(per_step):
            if len(trail.states) < len(states):
                k = len(trail.states)
                trail.states.append(states[k])
                of_turns.append(float(k) if symbols is None else symbols[k])
        trail.symbols = [*of_turns, 77.0]  # the last is of a turn that is not over
        trail.impacts += [None] * impacts
        if motion.steps in leaves_at:
            trail.leaves.append(motion.steps)

    motion.step = step
    return motion


def balls(states, off=0.0):
    return [(Ball(q, off), Ball(w, off)) for q, w in states]


def test_a_motion_settles_with_the_states_of_its_last_period():
    states = beside(PLACES, [1e-9 * 0.5**k for k in range(20)])
    motion = moving(balls(states), symbols=[2.0, 3.0] * 10)
    found = module._until_it_repeats(motion, 0.0)
    assert (found.kind, found.turns) == (SETTLED, 7)
    assert found.states == tuple(states[5:7])
    assert found.symbols == (3.0, 2.0)
    far = moving(balls(beside(PLACES, [0.01 * 0.5**k for k in range(40)])), symbols=[2.0] * 40)
    assert module._until_it_repeats(far, 0.0).turns > 20


@pytest.mark.parametrize(("off", "known"), [(1.9, True), (2.1, False)])
@pytest.mark.parametrize("which", [0, 1])
def test_a_state_is_known_relative_to_its_larger_number(off, known, which):
    """Within a fiftieth of 100, whichever of its numbers is the wide one."""
    state = [Ball(100.0), Ball(-0.5)]
    state[which] = Ball(float(state[which]), off)
    motion = moving([tuple(state)] * 9, symbols=[1.0] * 9)
    if known:
        assert module._until_it_repeats(motion, 0.02).kind == SETTLED
    else:
        with pytest.raises(UndecidedError):
            module._until_it_repeats(motion, 0.02)


def test_a_cycle_is_looked_for_where_the_motion_has_left_a_rest(monkeypatch):
    asked = []
    closed = After(CYCLE, 3)

    def cycle(motion):
        asked.append(motion.steps)
        return closed if len(asked) == 2 else None

    monkeypatch.setattr(module, "cycle", cycle)
    states = balls([(0.1 * k * k, 1.0) for k in range(50)])
    assert module._until_it_repeats(moving(states, leaves_at=(2, 5, 9)), 0.0) is closed
    assert asked == [2, 5]


@pytest.mark.parametrize(
    ("per_step", "most", "kind", "count"),
    [(1, 1000, WANDERS, 400), (7, 1000, WANDERS, 406), (1, 4, UNKNOWN, 3), (1, 401, WANDERS, 400),
     (1, 400, UNKNOWN, 399)],
)  # fmt: skip
def test_a_motion_that_does_not_repeat_has_its_last_state(per_step, most, kind, count):
    """Until four hundred turns were followed, or so many impacts."""
    states = [(0.1 * k * k, 1.0 + k) for k in range(450)]
    found = module._until_it_repeats(moving(balls(states), per_step=per_step), 0.0, most)
    assert found == After(kind, count, (states[count - 1],), (count - 1.0,))


def test_a_cycle_goes_from_one_departure_to_the_next_at_its_phase():
    """In turns of 4 rad: the last departure is two turns after the second one."""
    leaves = [arb(0.25), arb(2.5), arb(7.75), arb(10.5)]
    states = [(float(k), -float(k)) for k in range(3)]
    trail = Stub(leaves=leaves, states=states, symbols=[5.0, 6.0, 7.0])
    motion = Stub(
        trail=trail, turn=arb(4), turn_of=lambda phi: int(float(phi) // 4),
        phase=lambda phi: float(phi) % 4.0, symbol_of_turn=lambda phi: 10.0 * float(phi),
    )  # fmt: skip
    found = module.cycle(motion)
    assert (found.kind, found.turns) == (CYCLE, 2)
    assert found.states == ((1.0, -1.0), (2.0, -2.0))
    assert found.symbols == (7.0, 25.0)  # the turn of the earlier departure is that of the last
    assert found.leaves == ((1 - 2, 3.75), (2 - 2, 2.5))
    trail.leaves = leaves[:3]
    assert module.cycle(motion) is None
    trail.leaves = leaves[:1]
    assert module.cycle(motion) is None


@pytest.mark.parametrize(
    ("kind", "state"),
    [(SETTLED, (0.25, 2.0)), (WANDERS, (0.25, 2.0)), (CYCLE, None), (UNKNOWN, None)],
)  # fmt: skip
def test_doubles_go_on_from_the_last_state(kind, state):
    system = Stub(strobe=0.75)
    found = After(kind, 7, tuple(PLACES)).start(system, 60.0)
    if state is None:
        assert found is None
    else:
        assert (found.q, found.theta) == (0.25, 0.75)
        assert found.v == pytest.approx(2.0 * 6.283185307179586)


def test_the_first_departure_of_a_record_is_followed(monkeypatch):
    leaves = []
    monkeypatch.setattr(module, "departures", lambda record: leaves)
    monkeypatch.setattr(module, "after_rest", lambda *given: given)
    assert module.after_first_rest("system", 700.0, "record") == After(UNKNOWN)
    leaves += [(3, 1.5), (4, 2.5)]
    assert module.after_first_rest("system", 700.0, "record") == ("system", 700.0, 1.5)


@pytest.mark.parametrize("fails", [None, UndecidedError, EndlessError])
@pytest.mark.parametrize("alike", [False, True])
def test_of_which_machine_a_motion_is_followed(monkeypatch, alike, fails):
    """That of the very data with digits that are asked for, or all that read alike with few."""
    seen = []

    def make(*given):
        return "exact", *given

    def until_it_repeats(motion, widest):
        seen.append((motion.given, widest))
        if fails is not None:
            raise fails
        return After(SETTLED, 3)

    make.within_last_digit = lambda *given: ("alike", *given)
    monkeypatch.setattr(exact_machine, "BallMachine", make)
    monkeypatch.setattr(quick_motion, "LandingTable", lambda *given: ("table", *given))
    monkeypatch.setattr(quick_motion, "QuickMotion", lambda *given: Stub(given=given, lost=7))
    monkeypatch.setattr(module, "_until_it_repeats", until_it_repeats)
    monkeypatch.setattr(module, "decided", lambda work, digits: seen.append(digits) or work())
    found = module.followed("shape", "follower", 0.5, 700.0, 1.25, alike, False, (9, 18))
    machine = "alike" if alike else "exact", "shape", "follower", 700.0
    table = "table", "shape", "follower", 0.5, 700.0
    width = module.CLOSE if alike else module.KNOWN
    assert seen == [(60,) if alike else (9, 18), ((machine, 0.5, 1.25, table), width)]
    assert found == (After(SETTLED, 3) if fails is None else After(UNKNOWN))
    assert found.lost == (7 if fails is None else 0)
