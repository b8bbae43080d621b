"""Where chatter ends, corner hits, completion loss: published numbers and simulations."""

from math import degrees, inf, radians, tau
from types import SimpleNamespace

import pytest

from camcli.analysis.contact_loss.accumulation import scan_speeds
from camcli.analysis.contact_loss.bursts import Bursts
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.contact_loss.study import detach
from camcli.analysis.grid import rpm_grid
from camcli.analysis.integrate import Orbit
from camcli.kernel.orbit_loop import EventKind
from camcli.words.detach import bursts_text
from tests.conftest import chapter_system, settings

HITS = (124.998297, 122.699318, 121.685872, 121.106981, 120.735577, 120.481041, 120.299126,
        120.165355)  # fmt: skip


@pytest.fixture(scope="module")
def result(chapter):
    return detach(chapter, rpm_grid(110.0, 200.0, 181), settings(), settle=3)


def of_corner(rows, name):
    return [row for row in rows if row.region == name]


def ends_of(system, rpm, transient):
    """Where chatters end in one turn, deg, by simulation."""
    record = Orbit(system, rpm, settings(transient, 1, 1e-13)).run()
    return [
        degrees(x) for k, x in zip(record.kind, record.theta, strict=True) if k == EventKind.CHATTER
    ]


@pytest.mark.parametrize(("corner", "rpm", "phase"), [("c", 119.712, 160.0), ("d", 136.312, 200.0)])
def test_chatter_accumulates_at_a_corner(chapter, result, corner, rpm, phase):
    """A little below the speed a simulated end is short of the corner: some degrees per rpm."""
    (found,) = of_corner(result.accumulation, corner)
    assert int(found.rpm * 1000.0) / 1000.0 == rpm
    assert (found.status, found.burst) == ("ok", "A2")
    assert 0.0 < found.high - found.low <= 2e-10
    assert phase - 1e-3 < ends_of(chapter, found.low - 1e-7, 0)[0] < phase
    bursts = Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6)
    before, after = (degrees(bursts.at(rpm).end) for rpm in (found.low, found.high))
    assert phase - 1e-6 < before < phase <= after


def test_completion_is_lost(chapter, result):
    (found,) = result.completion
    assert found.rpm == pytest.approx(198.5605, abs=2e-4)
    assert (found.status, found.region) == ("ok", "A2")
    assert found.high - found.low <= 2e-10
    bursts = Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6)
    complete, lost = (bursts.at(rpm) for rpm in (found.low, found.high))
    assert -1e-3 < complete.end - complete.release - tau < 0.0
    assert lost.end > lost.release + tau


def test_impacts_land_on_corners_at_the_published_speeds(chapter, result):
    """The kernel's n-th impact from rest at 0 deg crosses the corner within the bracket."""
    assert [hit.rpm for hit in result.hits if hit.corner == "c"] == pytest.approx(HITS, abs=1e-6)
    assert {hit.corner for hit in result.hits} >= {"c", "d", "f"}
    corners = dict(zip("abcdef", map(degrees, chapter.corners), strict=True))
    for hit in result.hits:
        assert hit.high - hit.low <= 2e-10
        place = corners[hit.corner] + (0.0 if corners[hit.corner] > corners["b"] else 360.0)
        sides = []
        for rpm in (hit.low, hit.high):
            record = Orbit(chapter, rpm, settings(0, 2)).run()
            rows = zip(record.kind, record.period, record.theta, strict=True)
            times = [360.0 * p + degrees(x) for k, p, x in rows if k == EventKind.IMPACT]
            sides.append(times[hit.impact - 1] - place)
        assert sides[0] < 0.0 < sides[1] < sides[0] + 1e-3


def test_a_curve_of_hits_that_ends_says_where(chapter, result):
    ended = {hit.impact: hit for hit in result.ended if hit.corner == "e"}
    assert set(ended) == set(range(2, 9))
    assert not [hit for hit in result.hits if hit.corner == "e"]
    assert [c.region for c in result.jumps] == ["e"]
    burst = Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6)
    for hit in ended.values():
        assert hit.ends[0] < chapter.corners[4] < hit.ends[1]
        sides = [degrees(burst.at(rpm).impacts[hit.impact - 1]) for rpm in (hit.low, hit.high)]
        assert sides == pytest.approx([degrees(x) for x in hit.ends], abs=1e-3)


def test_hits_close_in_on_the_accumulation(chapter, result):
    found = detach(chapter, rpm_grid(118.0, 126.0, 41), settings(), settle=2, impacts=55)
    (end,) = of_corner(found.accumulation, "c")
    assert end.rpm == pytest.approx(of_corner(result.accumulation, "c")[0].rpm, abs=1e-9)
    hits = [hit.rpm for hit in found.hits if hit.corner == "c"]
    assert len(hits) == 55
    assert hits == sorted(hits, reverse=True)
    x, y, z = hits[-3:]  # geometrically: Aitken's limit
    assert end.rpm == pytest.approx(z - (z - y) * (z - y) / (z - 2.0 * y + x), abs=1e-8)


@pytest.mark.ci
@pytest.mark.slow
def test_without_restitution_the_first_landing_ends_the_burst_and_without_loss_none_does():
    dead = chapter_system(restitution=0.0)
    found = detach(dead, rpm_grid(110.0, 130.0, 41), settings(), settle=1, impacts=3)
    assert of_corner(found.accumulation, "c")[0].rpm == pytest.approx(HITS[0], abs=1e-6)
    assert bursts_text(found.speeds[-1]) == "A2 complete, A4 complete"
    lossless = chapter_system(restitution=1.0)
    found = detach(lossless, [116.0], settings(), settle=0, impacts=1)
    assert not any(speed.ends for speed in found.speeds)
    assert found.ends + found.completion == ()


@pytest.mark.parametrize(
    ("bursts", "opens", "scanned"),
    [
        ("......", 150.0, []),
        ("..xxx.", 250.0, ["just above", 300.0, 400.0, 500.0, 600.0]),  # and the speed after it
        ("..xxx.", 200.0, ["just above", 300.0, 400.0, 500.0, 600.0]),
        ("..xxx.", 199.0, [300.0, 400.0, 500.0, 600.0]),  # it was open at the speed before
        ("..xxx.", 300.0, [300.0, 400.0, 500.0, 600.0]),  # nothing lies between
        ("..xxxx", 250.0, ["just above", 300.0, 400.0, 500.0, 600.0]),
        ("x.xx..", 250.0, ["just above", 300.0, 400.0, 500.0]),  # the longest row
        ("xx.x..", 50.0, [100.0, 200.0, 300.0]),  # no speed before it
        ("xx.xx.", 50.0, [100.0, 200.0, 300.0]),  # the first of two as long
        (".o.x..", 350.0, ["just above", 400.0, 500.0]),  # one of another region
        (".i.x..", 350.0, ["just above", 400.0, 500.0]),  # one that does not accumulate
    ],
)
@pytest.mark.parametrize("falling", [False, True])
def test_which_speeds_are_scanned_for_changes_of_bursts(bursts, opens, scanned, falling):
    kinds = {"x": [("A1", 1.0)], "o": [("A2", 1.0)], "i": [("A1", None)], ".": []}
    speeds = [
        SimpleNamespace(rpm=100.0 * k, bursts=[SimpleNamespace(region=region, end=end)
                                               for region, end in kinds[letter]])
        for k, letter in enumerate(bursts, 1)
    ]  # fmt: skip
    found = scan_speeds(opens, "A1", speeds[::-1] if falling else speeds)
    assert found == [opens * (1.0 + 1e-6) if rpm == "just above" else rpm for rpm in scanned]


def test_a_burst_begins_with_a_rest_at_any_phase_before_it(chapter):
    """Also at phase zero, half a degree before a phase at which contact is not lost at all."""
    usual = Bursts(chapter, "A2", detachment(chapter).first.theta, 10**6).at(125.0)
    early = Bursts(chapter, "A2", radians(0.5), 10**6).at(125.0)
    assert early.release == usual.release < inf
    assert early.impacts == usual.impacts
