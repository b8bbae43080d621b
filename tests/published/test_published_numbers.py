"""Numbers of the cam-follower example (Osorio, di Bernardo & Santini 2008), from whole runs."""

from math import pi

import pytest
from conftest import chapter_system

from camcli.analysis.classify import classify_at
from camcli.analysis.labels import label
from tests.kernel.helpers import run, settings, system

MACHINE = system(base_radius=0.4)


@pytest.mark.parametrize(
    ("rpm", "expected"),
    [
        (114.9, "contact"),
        (684.0, "P(1;1)"),
        (682.0, "aperiodic"),
        (361.0, "aperiodic"),
        (359.0, "P(3;3:3:2)"),
        (360.0, "P(6;3:3:2:3:3:2)"),
    ],
)
def test_attractors_from_rest(rpm, expected):
    assert label(run(rpm, MACHINE, record=200, transient=2000)) == expected


@pytest.mark.parametrize("rpm", [358.0, 358.5])
def test_the_three_turn_orbit_from_rest(rpm):
    """Where the exact motion goes; doubles alone cannot tell, they may close a cycle by rounding.

    The transient stretches errors beyond 1e13 in 30 turns. At 358.0 rpm even the 17th digit of the
    data decides, and most of what lies within it settles on this orbit.
    """
    assert (
        classify_at(chapter_system(), rpm, settings(record=400, transient=600)).label
        == "P(3;3:3:2)"
    )


@pytest.mark.parametrize("rpm", [358.0, 358.5, 359.0])
def test_the_coexisting_orbit_with_two_impacts(rpm):
    tape = run(rpm, MACHINE, record=100, transient=2000, q=0.546, v=32.48)
    assert label(tape) == "P(1;2)"
    if rpm == 358.5:
        assert tape.strobe_q[-1] == pytest.approx(0.546, abs=2e-3)
        assert float(tape.strobe_w[-1]) * rpm * pi / 30 == pytest.approx(32.48, abs=2e-2)
