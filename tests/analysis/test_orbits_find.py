"""Labels of what is found at one speed, and what a label may look like."""

from functools import cache
from math import inf

import pytest

from camcli.analysis.labels import Label, label
from camcli.analysis.orbits.identify import identify, solve_from
from camcli.analysis.orbits.same_orbit import same_orbit
from camcli.analysis.orbits.search import find
from tests.conftest import chapter_system, settings


@cache
def found(rpm, name=None, transient=300, starts=2, strobe=0.0):
    wanted = None if name is None else Label.parse(name)
    return find(chapter_system(strobe), rpm, settings(transient=transient), starts, wanted)


def labels(result):
    return [orbit.label for orbit in result.orbits]


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [
        (358.5, "P(3;3:3:2)"),
        (360.0, "P(6;3:3:2:3:3:2)"),
        (739.35, "P(2;1:1)"),
        (700.0, "P(1;1)"),
        (190.0, "P(1;inf)"),
        (100.0, "contact"),
    ],
)
def test_what_the_machine_settles_on(rpm, expected):
    system = chapter_system()
    orbit = solve_from(system, rpm, settings(transient=300))
    assert orbit.label == expected
    assert orbit.stable
    assert orbit.admissible
    assert orbit.primitive
    assert labels(found(rpm))[0] == expected
    if orbit.resting:
        assert orbit.multipliers == (0, 0)


@pytest.mark.parametrize("rpm", [741.0, 745.0, 755.0])
def test_chaos_is_no_orbit(rpm):
    """What is left at such a speed is unstable."""
    assert solve_from(chapter_system(), rpm, settings(transient=300)) is None
    result = found(rpm)
    assert not any(orbit.stable for orbit in result.orbits)
    assert labels(result) == ["P(1;1)", "P(1;1)"]


@pytest.mark.parametrize(
    ("rpm", "name"),
    [
        (358.5, "P(1;2)"),
        (358.5, "P(3;3:3:2)"),
        (745.0, "P(1;1)"),
        (745.0, "P(2;1:1)"),
        (745.0, "P(3;1:1:1)"),
    ],
)
def test_an_orbit_is_found_by_its_label(rpm, name):
    result = found(rpm, name)
    assert set(labels(result)) == {name}
    for orbit in result.orbits:
        assert orbit.admissible
        assert orbit.primitive
        assert orbit.stable == (rpm == 358.5)
        assert orbit.impacts == sum(Label.parse(name).symbols)


def test_unstable_orbits_at_745_are_their_own():
    """P(2;1:1) and P(3;1:1:1) are not P(1;1) gone through twice or thrice."""
    for name in ("P(2;1:1)", "P(3;1:1:1)"):
        (orbit,) = found(745.0, name).orbits
        states = {round(q, 6) for q, _ in orbit.states}
        assert len(states) == orbit.turns
        assert abs(orbit.trace) > 1 + orbit.det


@pytest.mark.parametrize("name", ["P(2;2:0)", "P(1;3)", "P(4;2:1:2:1)"])
def test_a_label_nothing_has_is_not_found(name):
    result = find(chapter_system(), 700.0, settings(transient=30), 2, Label.parse(name), most=4)
    assert not result.orbits


def test_another_strobe_phase_rotates_the_label_only():
    """The same impacts; a turn that begins elsewhere holds other ones of them."""
    for rpm in (358.5, 700.0, 739.35, 190.0):
        one = found(rpm).orbits[0]
        for strobe in (120.0, 155.0):
            two = found(rpm, strobe=strobe).orbits[0]
            assert two.turns == one.turns
            assert sum(two.symbols) == sum(one.symbols)
            assert abs(two.trace - one.trace) < 1e-10 * (1 + abs(one.trace))
            for a, b in zip(sorted(one.theta), sorted(two.theta), strict=True):
                assert abs(a - b) < 1e-12


@pytest.mark.parametrize("rpm", [95.0, 150.0, 205.0, 300.0, 358.5, 420.0, 520.0, 690.0, 745.0])
def test_identify_agrees_with_the_label_of_the_record(rpm):
    from camcli.analysis.integrate import Orbit

    system = chapter_system()
    tape = Orbit(system, rpm, settings(transient=300, record=130)).run()
    orbit, name = identify(system, rpm, tape), label(tape)
    if orbit is None:
        assert name in ("aperiodic", "undecided") or "inf" in name
    else:
        assert orbit.label == name


def test_orbits_are_listed_once_and_stable_ones_first():
    result = found(700.0, starts=6)
    assert labels(result) == ["P(1;1)", "P(1;1)"]
    assert [orbit.stable for orbit in result.orbits] == [True, False]
    assert not same_orbit(*result.orbits)
    assert same_orbit(result.orbits[0], result.orbits[0])
    assert all(not orbit.admissible for orbit in result.virtual)
    assert all("virtual" in orbit.verdict for orbit in result.virtual)


@pytest.mark.parametrize(
    ("text", "symbols", "name"),
    [
        ("P(1;1)", (1.0,), "P(1;1)"),
        (" P(3;2:3:3) ", (2.0, 3.0, 3.0), "P(3;3:3:2)"),
        ("P(2;0:1)", (0.0, 1.0), "P(2;1:0)"),
        ("P(2;1:inf)", (1.0, inf), "P(2;inf:1)"),
        ("P(1;inf)", (inf,), "P(1;inf)"),
    ],
)
def test_labels_are_read(text, symbols, name):
    assert Label.parse(text) == Label(symbols) == name
    assert str(Label.parse(text)) == name


@pytest.mark.parametrize(
    "text",
    [
        "",
        "P",
        "P()",
        "P(;)",
        "P(1)",
        "P(1;)",
        "P(2;1)",
        "P(1;1:1)",
        "P(1;-1)",
        "P(1;1.5)",
        "P(1;x)",
        "P(x;1)",
        "P(0;)",
        "P(1;nan)",
        "p(1;1)",
        "P(1;1",
        "(1;1)",
        "P(65;" + ":".join("1" * 65) + ")",
        "P(1;-inf)",
    ],
)
def test_bad_labels_are_refused(text):
    with pytest.raises(ValueError):  # noqa: PT011
        Label.parse(text)
