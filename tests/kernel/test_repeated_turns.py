"""Turns that are earlier ones again, to the last bit, are copied: as if each had been flown."""

import itertools
import random
from dataclasses import fields, replace

import pytest

import camcli
from camcli.analysis.integrate import ALL_FLOWN, Orbit, Portions
from camcli.api.machine import machine_of
from camcli.kernel.orbit_loop import NEVER, Earlier, State, is_same, keep
from tests.conftest import settings
from tests.support.kernel_runs import run, system

COLUMNS = (
    "kind", "period", "theta", "q", "u", "strobe_q", "strobe_w", "impacts", "chatter",
)  # fmt: skip
FACTS = ("periods", "detachments", "resting", "status", "hits", "chatters", "repeats", "near")


LASH = {"cam.lash": 0.004, "follower.seat_restitution": 0.3, "follower.preload": 80.0}


def both(orbit, other, portions=ALL_FLOWN):
    """The records of two equal orbits: the first may copy turns, of the other all are flown."""
    return orbit.run(portions=portions), other.run(portions=ALL_FLOWN)


def compare(made, flown, orbit, other):
    """That two records and the ends of their orbits have the same bits."""
    for name in COLUMNS:
        assert getattr(made, name).tobytes() == getattr(flown, name).tobytes(), name
    for name in FACTS:
        assert getattr(made, name) == getattr(flown, name), name
    assert made.cost.impacts == flown.cost.impacts
    assert orbit.state == other.state


MACHINES = {
    "no damping": {},
    "damping, gravity, preload": {"damping": 3.0, "gravity": 9.81, "preload": 5.0},
    "all lost in an impact": {"restitution": 0.0},
    "a ball": {"stiffness": 0.0, "gravity": 9.81, "restitution": 0.3},
}


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("strobe_deg", [0.0, 155.0])
def test_a_record_has_the_bits_of_one_that_is_flown(name, strobe_deg):
    """Speeds with orbits of one and more impacts and turns, with chatter, chaos and contact."""
    machine = system(strobe_deg, **MACHINES[name])
    chance = random.Random(name)
    saved = 0
    for rpm in (90.0, 118.0, 130.0, 190.0, 250.0, 358.5, 500.0, 682.5, 700.0, 737.5, 745.0):
        wanted = settings(chance.choice([0, 1, 17, 300]), chance.choice([1, 3, 64, 200]))
        orbit, other = Orbit(machine, rpm, wanted), Orbit(machine, rpm, wanted)
        made, flown = both(orbit, other, Portions())
        compare(made, flown, orbit, other)
        saved += flown.cost.evaluations - made.cost.evaluations
    assert saved > 0


@pytest.mark.parametrize("most_rows", [1, 7, 64])
@pytest.mark.parametrize("steps", [1, 50, 200_000])
def test_nor_does_it_matter_how_it_is_cut(most_rows, steps):
    """In logs that are full at any place, and in calls of the kernel of few steps."""
    portions = Portions(compiled_steps=steps, first_rows=1, most_rows=most_rows)
    for rpm, transient in ((190.0, 0), (130.0, 2), (700.0, 330), (358.5, 220)):
        wanted = settings(transient, 60)
        orbit, other = Orbit(system(), rpm, wanted), Orbit(system(), rpm, wanted)
        compare(*both(orbit, other, portions), orbit, other)


def test_neither_on_a_seat_nor_where_a_kink_throws_the_follower_off_at_the_strobe():
    """Both are events that begin a turn."""
    for overrides, rpm in (
        (LASH, 150.0),
        ({"run.strobe_deg": 90.0}, 130.0),
        ({"run.strobe_deg": 150.1793714951576}, 130.0),
        (LASH | {"run.strobe_deg": 117.0}, 180.0),
    ):
        machine = machine_of(camcli.load_scene(None, overrides))
        wanted = replace(machine.settings, transient=5, record=40)
        orbit = Orbit(machine.system, rpm, wanted)
        other = Orbit(machine.system, rpm, wanted)
        compare(*both(orbit, other, Portions()), orbit, other)


def test_a_settled_orbit_is_not_flown_again():
    """A turn of the transient and one of the record, of a motion that rests in every turn."""
    few, many = (run(190.0, record=n, transient=n) for n in (10, 4000))
    assert many.cost.evaluations == few.cost.evaluations
    assert many.hits == 400 * few.hits


def test_a_copied_orbit_goes_on_as_a_flown_one():
    """From the end of its record, which is in the middle of a cycle."""
    wanted = settings(300, 101)  # 737.5 rpm: a cycle of several turns of P(1;1)
    orbit, other = Orbit(system(), 737.5, wanted), Orbit(system(), 737.5, wanted)
    both(orbit, other, Portions())
    compare(*both(orbit.go_on(3, 50), other.go_on(3, 50), Portions()), orbit, other)


SAME = [field.name for field in fields(Earlier) if field.name in {f.name for f in fields(State)}]
COUNTED = {"period", "logged", "total_impacts", "detachments"}  # which no later turn depends on
GIVEN = {"gap", "gap_rate", "mode"}  # compared by `run`, or given beside the state


def test_a_state_is_the_same_in_every_number_that_a_later_turn_depends_on():
    """All of a state but its place, the strobe, and what is only counted."""
    left_out = {"theta", "stretch", "impacts", "chattered"}  # at the strobe these are always alike
    assert {field.name for field in fields(State)} - left_out == set(SAME)
    state = State(gap=0.25, gap_rate=-0.5)
    for place, name in enumerate(SAME, 1):
        if name not in GIVEN:
            setattr(state, name, type(getattr(state, name))(place))
    earlier = Earlier()
    keep(state, state.gap, state.gap_rate, state.mode, earlier)
    assert all(getattr(earlier, name) == getattr(state, name) for name in SAME)
    assert is_same(state, state.mode, earlier)
    assert not is_same(state, state.mode + 1, earlier)
    for name in SAME:
        changed = replace(state, **{name: getattr(state, name) + 1})
        assert is_same(changed, state.mode, earlier) == (name in COUNTED | GIVEN), name


def test_a_state_is_kept_for_an_eighth_of_the_turns_so_far():
    """But for sixteen turns at least; the first one at the first strobe."""
    earlier = Earlier()
    times = []
    for period in range(-100, 400):
        if period >= earlier.keep_in:
            keep(State(period=period), 0.1, 0.0, 1, earlier)
            times.append(period)
    assert times[:9] == [-100, -84, -68, -52, -36, -20, -4, 12, 28]
    assert all(b - a == max(16, (a + 100) // 8) for a, b in itertools.pairwise(times))
    assert Earlier(keep_in=NEVER).keep_in > 10**18


@pytest.mark.parametrize(("transient", "flown"), [(0, 2), (1, 2), (5, 4)])
def test_no_turn_is_flown_that_repeats_the_one_before(transient, flown):
    """From rest at the strobe each turn is like the first, after which a state is kept.

    It is seen again a turn later. Where that is in the transient, its last turn is flown, and one
    of the record.
    """
    once = Orbit(system(), 130.0, settings(0, 1)).run(portions=ALL_FLOWN).cost.evaluations
    many = Orbit(system(), 130.0, settings(transient, 100)).run(portions=Portions())
    assert many.periods == 100
    assert many.cost.evaluations == flown * once > 0
