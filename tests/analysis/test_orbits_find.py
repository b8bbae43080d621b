"""Which orbits are found at one speed, and when a record is one of them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from camcli.analysis.integrate import Orbit
from camcli.analysis.labels import Label
from camcli.analysis.orbits.identify import identify, solve_from
from camcli.analysis.orbits.same_orbit import same_orbit, same_states, shortest_period
from camcli.analysis.orbits.search import find
from tests.conftest import chapter_system, settings


@cache
def found(rpm, name=None, strobe=0.0):
    wanted = None if name is None else Label.parse(name)
    return find(chapter_system(strobe), rpm, settings(transient=300), 2, wanted)


def labels(result):
    return [orbit.label for orbit in result.orbits]


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [
        (358.5, "P(3;3:3:2)"),
        (360.0, "P(6;3:3:2:3:3:2)"),
        (739.35, "P(2;1:1)"),
        (190.0, "P(1;inf)"),
        (100.0, "contact"),
    ],
)
def test_what_the_machine_settles_on(rpm, expected):
    orbit = solve_from(chapter_system(), rpm, settings(transient=300))
    assert orbit.label == expected
    assert orbit.stable
    assert orbit.admissible
    assert orbit.primitive
    assert not orbit.resting or orbit.multipliers == (0, 0)
    assert same_orbit(found(rpm).orbits[0], orbit)


def test_chaos_is_no_orbit_and_what_is_left_is_unstable():
    assert solve_from(chapter_system(), 745.0, settings(transient=300)) is None
    assert labels(found(745.0)) == ["P(1;1)", "P(1;1)"]
    assert not any(orbit.stable for orbit in found(745.0).orbits)


@pytest.mark.parametrize(
    ("rpm", "name"), [(358.5, "P(1;2)"), (745.0, "P(2;1:1)"), (745.0, "P(3;1:1:1)")]
)
def test_an_orbit_is_found_by_its_label(rpm, name):
    """At 745 rpm they are unstable, and not P(1;1) gone through twice or thrice."""
    result = found(rpm, name)
    assert set(labels(result)) == {name}
    for orbit in result.orbits:
        assert orbit.admissible
        assert orbit.primitive
        assert orbit.stable == (rpm == 358.5)
        assert orbit.impacts == sum(Label.parse(name).symbols)
        assert len({round(q, 6) for q, _ in orbit.states}) == orbit.turns


@pytest.mark.parametrize("rpm", [358.5, 739.35, 190.0])
def test_another_strobe_phase_rotates_the_label_only(rpm):
    """The same impacts; a turn that begins elsewhere holds other ones of them."""
    one, two = found(rpm).orbits[0], found(rpm, strobe=155.0).orbits[0]
    assert (two.turns, sum(two.symbols)) == (one.turns, sum(one.symbols))
    assert two.trace == pytest.approx(one.trace, rel=1e-10, abs=1e-10)
    assert sorted(two.theta) == pytest.approx(sorted(one.theta), abs=1e-12)


def test_states_that_differ_by_more_than_rounding_are_two():
    states = [(0.2, 1.0), (0.3, -1.0)]
    assert same_states(states, [(q * (1 + 1e-9), w) for q, w in states])
    assert not same_states(states, [(q * (1 + 1e-6), w) for q, w in states])
    assert shortest_period(states[:1] * 4) == 1
    assert shortest_period(states * 2) == 2
    assert shortest_period([*states, states[0], (0.3 + 1e-6, -1.0)]) == 4


def test_a_record_that_does_not_come_near_the_orbit_is_not_on_it():
    """Its passages close, and Newton's method finds an orbit, but another one."""
    system = chapter_system()
    tape = Orbit(system, 700.0, settings(transient=300, record=10)).run()
    assert identify(system, 700.0, tape) is not None
    elsewhere = replace(tape, strobe_q=tape.strobe_q + 1e-3)
    assert identify(system, 700.0, elsewhere) is None


def test_a_cycle_through_a_rest_closes_to_rounding_or_is_none():
    system = chapter_system()
    tape = Orbit(system, 190.0, settings(transient=20, record=10)).run()
    assert identify(system, 190.0, tape).label == "P(1;inf)"
    ends = tape.strobe_w + 1e-9 * (-1) ** np.arange(10)
    assert identify(system, 190.0, replace(tape, strobe_w=ends), longest=1) is None
