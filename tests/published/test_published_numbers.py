"""Numbers of the cam-follower example (Osorio, di Bernardo & Santini 2008), from whole runs."""

from math import pi

import pytest
from conftest import chapter_system

from camcli.analysis.classify import classify_at
from camcli.analysis.labels import label
from camcli.analysis.sweep import rpm_grid, sweep
from tests.kernel.helpers import ORACLE_CAM, events, run, settings, system

MACHINE = system(base_radius=0.4)
B, C, D = (float(ORACLE_CAM.breakpoints[k]) for k in (1, 2, 3))
CORNER_HITS = [
    124.998297, 122.699318, 121.685872, 121.106981,
    120.735577, 120.481041, 120.299126, 120.165355,
]  # fmt: skip


def rows(rpm, kind, record=1, tolerance=1e-15):
    """Phases of the events of one kind after a start from rest, rad from the start."""
    tape = run(rpm, MACHINE, record=record, tolerance=tolerance)
    return [row[2] + 2 * pi * row[1] for row in events(tape) if row[0] == kind]


def switch(low, high, before):
    """Speed where `before` turns false, to the last double."""
    assert before(low)
    assert not before(high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if before(middle) else (low, middle)
    return 0.5 * (low + high)


def test_first_detachment():
    rpm = switch(114.9, 115.1, lambda x: not rows(x, "detachment"))
    assert rpm == pytest.approx(114.979326744, abs=1e-9)
    assert rows(rpm + 1e-5, "detachment")[0] == pytest.approx(B, abs=1e-12)


@pytest.mark.parametrize("n", range(1, 9))
def test_the_nth_impact_lands_on_c(n):
    published = CORNER_HITS[n - 1]
    rpm = switch(published - 0.01, published + 0.01, lambda x: rows(x, "impact")[n - 1] < C)
    assert rpm == pytest.approx(published, abs=1e-6)


@pytest.mark.parametrize(("corner", "published"), [(C, 119.712), (D, 136.312)])
@pytest.mark.parametrize("tolerance", [1e-7, 1e-12])
def test_chatter_accumulates_on_a_corner(corner, published, tolerance):
    """Up to the speed the accumulation is before the corner, beyond it after or gone."""

    def before(rpm):
        found = [x for x in rows(rpm, "chatter", tolerance=tolerance) if x < corner]
        return bool(found)

    rpm = switch(published - 0.03, published + 0.03, before)
    assert rpm == pytest.approx(published, abs=5e-4)


def test_complete_chatter_becomes_incomplete():
    rpm = switch(198.5, 198.6, lambda x: bool(run(x, MACHINE, record=2).chatter[1]))
    assert rpm == pytest.approx(198.5605, abs=2e-4)
    ends = [x - 2 * pi for x in rows(198.5604, "chatter", record=2, tolerance=1e-9)]
    assert ends[-1] == pytest.approx(B, abs=2e-4)


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


@pytest.mark.parametrize("rpm", [358.0, 358.5])
def test_the_three_turn_orbit_from_nearby(rpm):
    """Carried over from 359 rpm, where the same orbit attracts."""
    tape = run(359.0, MACHINE, record=3, transient=3000)
    start = {"q": float(tape.strobe_q[0]), "v": float(tape.strobe_w[0]) * 359.0 * pi / 30}
    near = run(rpm, MACHINE, record=200, transient=500, **start)
    assert label(near) == "P(3;3:3:2)"


@pytest.mark.parametrize("rpm", [358.0, 358.5, 359.0])
def test_the_coexisting_orbit_with_two_impacts(rpm):
    tape = run(rpm, MACHINE, record=100, transient=2000, q=0.546, v=32.48)
    assert label(tape) == "P(1;2)"
    if rpm == 358.5:
        assert tape.strobe_q[-1] == pytest.approx(0.546, abs=2e-3)
        assert float(tape.strobe_w[-1]) * rpm * pi / 30 == pytest.approx(32.48, abs=2e-2)


def test_carried_down_the_single_impact_orbit_lives_until_its_corner_impact():
    speeds = [*rpm_grid(684.0, 674.0, 6), 673.3, 673.25, 673.22]
    found = sweep(MACHINE, speeds, settings(100, transient=1500), direction="down").speeds
    labels = [speed.label for speed in found]
    assert labels[:-1] == ["P(1;1)"] * (len(speeds) - 1)
    assert labels[-1] != "P(1;1)"
