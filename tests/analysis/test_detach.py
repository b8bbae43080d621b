"""First detachment, opening and filling, words, and what the follower does at b and at e."""

from decimal import Decimal
from math import inf, pi, sqrt

import pytest

from camcli.analysis.contact_loss.bursts import Bursts, LiftOffKind, lift_off
from camcli.analysis.contact_loss.detachment import Reason, detachment
from camcli.analysis.contact_loss.force import Force
from camcli.analysis.integrate import Orbit
from camcli.cams.decimals import pi as decimal_pi
from camcli.cams.decimals import sincos
from camcli.cams.pieces import Part
from camcli.cams.regions import regions
from camcli.system import Follower, System
from tests.conftest import chapter_system, settings

OMEGA0 = 34.2319495767677805
B, E = 150.1793714951576, 209.8206285048424


def rpm_of(c, c2):
    """The undamped ratio, from values of the cam that were computed to 16 digits elsewhere."""
    return OMEGA0 * sqrt(c / -c2) * 30.0 / pi


def by_region(found):
    return {loss.region.name: loss for loss in found.losses}


def touches(system, rpm, theta_deg=0.0):
    return Orbit(system, rpm, settings(0, 3, theta_deg=theta_deg)).run().touches


def brute_force(system, low, high, theta_deg=0.0):
    """The lowest speed with lift-off, by simulations alone; within 1e-8 rpm."""
    assert not touches(system, low, theta_deg)
    assert touches(system, high, theta_deg)
    while high - low > 1e-8:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if touches(system, middle, theta_deg) else (middle, high)
    return 0.5 * (low + high)


def made(parts, strobe_deg=0.0, **follower):
    values = {"mass": 1.0, "stiffness": 1000.0, **follower}
    return System.build(Follower(**values), parts, strobe_deg)


def eccentric(base, lift, strobe_deg=0.0, **follower):
    base, half = Decimal(str(base)), Decimal(str(lift)) / 2
    part = Part(Decimal(0), 2 * decimal_pi(), lambda x: base + half * (1 - sincos(x)[1]))
    return made([part], strobe_deg, **follower)


def dwell(level, **follower):
    return made([Part(Decimal(0), 2 * decimal_pi(), None, Decimal(str(level)))], **follower)


def roof(**follower):
    """A lift that rises and falls in straight lines: one kink up at 0, one down at 180 deg."""
    half, low = decimal_pi(), Decimal("0.1")
    rise = Part(Decimal(0), half, lambda x: low + x / 100)
    fall = Part(half, 2 * half, lambda x: low + (2 * half - x) / 100)
    return made([rise, fall], **follower)


def test_first_detachment_of_the_chapter(chapter):
    first = detachment(chapter).first
    assert first.rpm == pytest.approx(114.979326744, abs=1e-9)
    assert first.rpm == pytest.approx(rpm_of(0.2312555620189976, -1.869212582774405), abs=1e-9)
    assert (first.region, first.status) == ("A2", "ok")
    assert first.theta_deg == pytest.approx(B, abs=1e-10)


def test_bracket_holds_below_and_loses_above(chapter):
    first = detachment(chapter).first
    assert 0.0 < first.high - first.low < 1e-9
    assert first.low < first.rpm < first.high
    assert not touches(chapter, first.low)
    force = Force(chapter)
    assert force.weakest(first.low)[0] > 0.0 > force.weakest(first.high)[0]


def test_regions_open_and_fill(chapter):
    found = by_region(detachment(chapter))
    fill = rpm_of(0.25393320723821, -1.491680113303188)
    assert fill == pytest.approx(134.872968058, abs=1e-9)
    for name, opens_at, fills_at in (("A2", B, 160.0), ("A4", E, 200.0)):
        loss = found[name]
        assert loss.opens.rpm == pytest.approx(114.979326744, abs=1e-9)
        assert loss.fills.rpm == pytest.approx(fill, abs=1e-9)
        assert loss.opens.theta_deg == pytest.approx(opens_at, abs=1e-9)
        assert loss.fills.theta_deg == pytest.approx(fills_at, abs=1e-9)
    for name in ("A1", "A3", "A5", "A6"):
        assert found[name].opens.rpm == found[name].fills.rpm == inf
        assert found[name].opens.status == found[name].fills.status == "never"


def test_regions_run_through_zero_and_the_strobe():
    plain, cut = chapter_system(), chapter_system(strobe_deg=155.0)
    names = [(r.name, r.begins, r.ends) for r in regions(plain.cam)]
    assert names[0] == ("A1", "a", "b")
    assert names[-1] == ("A6", "f", "a")
    assert [(r.name, r.begins, r.ends) for r in regions(cut.cam)] == names
    assert len(regions(cut.cam)[1].stretches) == 2
    one, two = detachment(plain), detachment(cut)
    assert one.first.rpm == pytest.approx(two.first.rpm, rel=1e-14)
    fills = [by_region(found)["A2"].fills.rpm for found in (one, two)]
    assert fills[0] == pytest.approx(fills[1], rel=1e-14)


@pytest.mark.parametrize(
    ("follower", "region"),
    [
        ({"damping": 5.0, "preload": 20.0}, "A4"),
        ({"damping": 60.0, "preload": 30.0, "gravity": 9.81}, "A4"),
        ({"damping": 500.0, "gravity": 9.81}, "A4"),
    ],
)
def test_damped_and_preloaded_follower_agrees_with_simulations(follower, region):
    system = chapter_system(**follower)
    first = detachment(system).first
    assert first.region == region
    assert first.status == "ok"
    found = brute_force(system, first.rpm * 0.9, first.rpm * 1.1)
    assert first.rpm == pytest.approx(found, abs=1e-7)


def test_a_smooth_cam_loses_contact_inside_its_one_region():
    for strobe in (0.0, 180.0):
        system = eccentric(0.1, 0.05, strobe)
        first = detachment(system).first
        expected = sqrt(1000.0 * 0.15 / 0.025) * 30.0 / pi
        assert first.rpm == pytest.approx(expected, rel=1e-13)
        assert first.theta_deg == pytest.approx(180.0, abs=1e-5)
        assert first.status == "ok"
        loss = detachment(system).losses[0]
        assert (loss.region.name, loss.region.begins, loss.fills.rpm) == ("A1", "", inf)
    seen = lift_off(Bursts(system, "A1", loss.opens.theta, 10**6), loss)
    assert seen.kind is LiftOffKind.WITHIN
    assert seen.release_deg < 180.0 < seen.landing_deg


@pytest.mark.parametrize("damping", [0.0, 20.0, 150.0])
def test_a_damped_smooth_cam_agrees_with_simulations(damping):
    system = eccentric(0.1, 0.05, damping=damping, preload=3.0, gravity=9.81)
    first = detachment(system).first
    assert first.rpm == pytest.approx(
        brute_force(system, 0.9 * first.rpm, 1.1 * first.rpm), abs=1e-7
    )
    assert (first.theta_deg > 185.0) == (damping > 0.0)


def test_flight_at_b_is_told_from_the_release_at_e(chapter):
    found = by_region(detachment(chapter))
    seen = {
        name: lift_off(Bursts(chapter, name, found[name].opens.theta, 10**6), found[name])
        for name in ("A2", "A4")
    }
    assert (seen["A2"].kind, seen["A2"].corner) == (LiftOffKind.FLIES_OFF, "b")
    assert seen["A2"].release_deg == pytest.approx(B, abs=1e-12)
    assert B < seen["A2"].landing_deg < seen["A2"].rest_deg < B + 0.01
    assert (seen["A4"].kind, seen["A4"].corner) == (LiftOffKind.CAUGHT, "e")
    assert E - 1e-3 < seen["A4"].release_deg < E - 1e-6
    assert E < seen["A4"].landing_deg < E + 1e-6


def test_never():
    found = detachment(dwell(0.1))
    assert found.first is None
    assert found.never


@pytest.mark.parametrize(
    ("system", "reason", "theta_deg", "value"),
    [
        (dwell(-0.1), Reason.FORCE, 0.0, -100.0),
        (dwell(0.0), Reason.FORCE, 0.0, 0.0),
        (chapter_system(stiffness=0.0), Reason.FORCE, 0.0, 0.0),
        (chapter_system(preload=-200.0), Reason.FORCE, 0.0, -56.92),
        (roof(), Reason.KINK, 180.0, 0.02),
    ],
)
def test_contact_lost_at_any_speed_has_a_reason_and_no_speed(system, reason, theta_deg, value):
    found = detachment(system)
    assert found.first is None
    assert not found.never
    place = found.always[0]
    assert (place.reason, place.theta_deg) == (reason, pytest.approx(theta_deg, abs=1e-9))
    assert place.value == pytest.approx(value, abs=1e-9)


def test_damping_can_press_the_follower_again_at_speed():
    force = Force(eccentric(0.1, 0.05, damping=300.0))
    lost = [force.lost(0, x / 100.0) for x in range(480, 620)]
    finite = [(low, high) for low, high in lost if high < inf]
    assert finite
    for k, (low, high) in enumerate(lost):
        if high < inf:
            x = (480 + k) / 100.0
            assert force.newton(0, x, 0.5 * (low + high)) < 0.0
            assert force.newton(0, x, 1.01 * high) > 0.0
            assert force.newton(0, x, 0.99 * low) > 0.0


def test_force_curve_has_both_sides_of_a_corner_and_its_minimum(chapter):
    curve = Force(chapter).curve(110.0)
    assert curve.lowest_n == pytest.approx(min(curve.force_n), rel=1e-13)
    assert curve.lowest_n == pytest.approx(28.0379, abs=1e-4)
    at_b = [n for x, n in zip(curve.theta_deg, curve.force_n, strict=True) if abs(x - B) < 1e-9]
    assert len(at_b) == 2
    assert at_b[0] - at_b[1] == pytest.approx(
        1.221 * (110 * pi / 30) ** 2 * (0.3415971000285428 + 1.869212582774405), rel=1e-9
    )
    assert (curve.theta_deg[0], curve.theta_deg[-1]) == (0.0, pytest.approx(360.0))
