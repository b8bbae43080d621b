"""Where chatter ends, corner hits, completion loss: published numbers and simulations."""

from math import inf

import pytest

from camcli.analysis.bracketing import bracket, lowest
from camcli.analysis.contact_loss.bursts import Bursts, settled
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.contact_loss.force import DEG
from camcli.analysis.contact_loss.study import detach
from camcli.analysis.integrate import Orbit
from camcli.analysis.sweep import rpm_grid
from camcli.kernel.orbit_loop import EventKind
from camcli.output.detach import bursts_text
from tests.conftest import chapter_system, settings

HITS = (124.998297, 122.699318, 121.685872, 121.106981, 120.735577, 120.481041, 120.299126,
        120.165355)  # fmt: skip


@pytest.fixture(scope="module")
def result(chapter):
    return detach(chapter, rpm_grid(110.0, 200.0, 181), settings(), settle=3)


def of_corner(result, name):
    return [c for c in result.accumulation if c.region == name]


@pytest.mark.parametrize(("corner", "rpm"), [("c", 119.712), ("d", 136.312)])
def test_chatter_accumulates_at_a_corner(result, corner, rpm):
    (found,) = of_corner(result, corner)
    assert int(found.rpm * 1000.0) / 1000.0 == rpm
    assert found.status == "ok"
    assert 0.0 < found.high - found.low <= 2e-10
    assert found.burst == "A2"


def test_the_end_of_the_chatter_comes_up_to_the_corner(chapter, result):
    """By simulation a little below and above: the slope is of the order of degrees per rpm."""
    for corner, phase in (("c", 160.0), ("d", 200.0)):
        (found,) = of_corner(result, corner)
        tape = Orbit(chapter, found.low - 1e-7, settings(0, 1, 1e-13)).run()
        ends = [
            x * DEG for k, x in zip(tape.kind, tape.theta, strict=True) if k == EventKind.CHATTER
        ]
        assert phase - 1e-3 < ends[0] < phase


def test_completion_is_lost(chapter, result):
    (found,) = result.completion
    assert found.rpm == pytest.approx(198.5605, abs=2e-4)
    assert (found.status, found.region) == ("ok", "A2")
    assert found.high - found.low <= 2e-10
    complete, lost = (
        Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6).at(found.rpm + side)
        for side in (-1e-6, 1e-6)
    )
    assert complete.end < complete.release + 360.0 / DEG
    assert complete.end == pytest.approx(complete.release + 360.0 / DEG, abs=1e-3)
    assert lost.end > lost.release + 360.0 / DEG


@pytest.mark.parametrize("n", range(1, 9))
def test_impact_n_lands_on_c(result, n):
    (found,) = [hit for hit in result.hits if hit.corner == "c" and hit.impact == n]
    assert found.rpm == pytest.approx(HITS[n - 1], abs=1e-6)
    assert found.status == "ok"
    assert found.high - found.low <= 2e-10


def test_every_hit_is_a_landing_by_simulation(chapter, result):
    """The kernel's n-th impact from rest at 0 deg crosses the corner within 1e-7 rpm."""
    corners = dict(zip("abcdef", chapter.corners_deg, strict=True))
    assert {hit.corner for hit in result.hits} >= {"c", "d", "f"}
    for hit in result.hits:
        sides = []
        for rpm in (hit.rpm - 1e-7, hit.rpm + 1e-7):
            tape = Orbit(chapter, rpm, settings(0, 2)).run()
            times = [
                360.0 * p + x * DEG
                for k, p, x in zip(tape.kind, tape.period, tape.theta, strict=True)
                if k == EventKind.IMPACT
            ]
            place = corners[hit.corner]
            place += 0.0 if place > corners["b"] else 360.0
            sides.append(times[hit.impact - 1] - place)
        assert sides[0] < 0.0 < sides[1]
        assert sides[1] - sides[0] < 1e-3


def test_a_curve_of_hits_that_ends_says_where(chapter, result):
    ended = {hit.impact: hit for hit in result.ended if hit.corner == "e"}
    assert set(ended) == set(range(2, 9))
    assert not [hit for hit in result.hits if hit.corner == "e"]
    for hit in ended.values():
        before, after = hit.ends_deg
        assert before < chapter.corners_deg[4] < after
        burst = Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6)
        sides = [burst.at(rpm).impacts[hit.impact - 1] * DEG for rpm in (hit.low, hit.high)]
        assert sides == pytest.approx([before, after], abs=1e-3)
    assert [c.region for c in result.jumps] == ["e"]


def test_hits_are_followed_to_any_number_and_close_in_on_the_accumulation(chapter):
    rpms = rpm_grid(118.0, 126.0, 41)
    found = detach(chapter, rpms, settings(), settle=2, impacts=55)
    (end,) = of_corner(found, "c")
    hits = [hit.rpm for hit in found.hits if hit.corner == "c"]
    assert len(hits) == 55
    assert hits == sorted(hits, reverse=True)
    assert end.rpm < hits[-1] < end.rpm + 1e-4
    x, y, z = hits[-3:]  # they close in geometrically: Aitken's limit
    assert end.rpm == pytest.approx(z - (z - y) * (z - y) / (z - 2.0 * y + x), abs=1e-8)


def test_bursts_per_speed(result):
    said = {speed.rpm: bursts_text(speed) for speed in result.speeds}
    assert said[114.5] == "none"
    assert said[115.0] == said[136.0] == "A2 complete, A4 complete"
    assert said[137.0] == said[198.5] == "A2 complete"
    assert "incomplete" in said[200.0]


def test_the_curve_has_a_row_per_complete_burst(chapter, result):
    for speed in result.speeds:
        complete = sum(burst.end_deg is not None for burst in speed.bursts)
        assert len(speed.ends) == complete
        if speed.rpm in (120.0, 150.0):
            tape = Orbit(chapter, speed.rpm, settings(20, 1, 1e-13)).run()
            ends = [
                x * DEG
                for k, x in zip(tape.kind, tape.theta, strict=True)
                if k == EventKind.CHATTER
            ]
            assert speed.ends == pytest.approx(ends, abs=1e-6)


def test_events_of_the_burst_that_lives_are_found_where_the_fall_loses_first():
    system = chapter_system(damping=5.0, preload=20.0)
    found = detach(system, rpm_grid(110.0, 220.0, 111), settings(), settle=3, impacts=2)
    assert found.detachment.first.region == "A4"
    assert [f.kind for f in found.lift_offs] == ["flies-off", "released-and-caught"]
    (c,) = of_corner(found, "c")
    assert c.burst == "A2"
    (lost,) = found.completion
    below, above = settled(system, [lost.rpm - 1e-3, lost.rpm + 1e-3], settings(), 20)
    assert bursts_text(below) == "A2 complete"
    assert "complete" not in bursts_text(above).split() or bursts_text(above) != bursts_text(below)


def test_few_speeds_find_the_same_events(chapter, result):
    few = detach(chapter, [110.0, 200.0], settings(), settle=3, impacts=1)
    assert of_corner(few, "c")[0].rpm == pytest.approx(of_corner(result, "c")[0].rpm, abs=1e-9)
    assert few.completion[0].rpm == pytest.approx(result.completion[0].rpm, abs=1e-9)
    assert [speed.rpm for speed in few.speeds] == [110.0, 200.0]


def test_without_restitution_the_first_landing_ends_the_burst():
    system = chapter_system(restitution=0.0)
    found = detach(system, rpm_grid(110.0, 130.0, 41), settings(), settle=1, impacts=3)
    assert of_corner(found, "c")[0].rpm == pytest.approx(HITS[0], abs=1e-6)
    assert bursts_text(found.speeds[-1]) == "A2 complete, A4 complete"


def test_without_loss_nothing_accumulates():
    system = chapter_system(restitution=1.0)
    found = detach(system, [116.0, 117.0], settings(), settle=0, impacts=1)
    assert not any(speed.ends for speed in found.speeds)
    assert not found.accumulation
    assert not found.completion


def test_no_events_where_contact_is_held_or_never(chapter):
    held = detach(chapter, [100.0, 110.0], settings(), settle=1)
    assert held.ends + held.completion + held.landings == ()
    assert {bursts_text(speed) for speed in held.speeds} == {"none"}
    lost = detach(chapter_system(preload=-200.0), [100.0, 110.0], settings(), settle=1)
    assert lost.ends + lost.completion + lost.landings + lost.lift_offs == ()


def test_a_bracket_closes_on_a_root_and_on_a_jump():
    calls = []

    def cubic(x):
        calls.append(x)
        return x * x * x - 2.0

    low, high, below, above = bracket(cubic, 1.0, 2.0, -1.0, 6.0)
    assert low <= 2.0 ** (1 / 3) <= high
    assert high - low <= 1e-12 * high
    assert below < 0.0 <= above
    assert len(calls) < 15
    low, high, *_ = bracket(lambda x: -1.0 if x < 1.7 else 1e9, 1.0, 2.0, -1.0, 1e9)
    assert low < 1.7 <= high
    assert high - low <= 2e-12
    low, high, *_ = bracket(lambda x: -1.0 if x < 1.7 else inf, 1.0, 2.0, -1.0, inf)
    assert low < 1.7 <= high


def test_lowest_finds_ends_and_interior_and_passes_infinities():
    assert lowest(lambda x: x, 1.0, 2.0, 8) == (1.0, 1.0)
    assert lowest(lambda x: -x, 1.0, 2.0, 8) == (-2.0, 2.0)
    value, place = lowest(lambda x: (x - 1.3) * (x - 1.3) + 5.0, 1.0, 2.0, 8)
    assert value == pytest.approx(5.0, abs=1e-15)
    assert place == pytest.approx(1.3, abs=1e-7)
    assert lowest(lambda x: inf if x < 1.5 else x, 1.0, 2.0, 8)[0] == pytest.approx(1.5)
    assert lowest(lambda x: inf, 1.0, 2.0, 8)[0] == inf
