"""Where contact is lost: published speeds, simulations beside them, and the spring that holds."""

from dataclasses import replace
from math import degrees, inf, pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from camcli.analysis.bracketing import lowest
from camcli.analysis.contact_loss.bursts import Bursts, LiftOffKind, lift_off
from camcli.analysis.contact_loss.detachment import Reason, SpeedStatus, detachment
from camcli.analysis.contact_loss.force import Force
from camcli.analysis.contact_loss.hold import Need, Obstacle, hold_to, replaced
from camcli.analysis.contact_loss.study import motion_past
from camcli.analysis.integrate import Orbit
from camcli.analysis.loads import loads_of
from camcli.cams.compile import Part, phase_of
from camcli.cams.regions import regions
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.scene import load_scene
from camcli.system import Follower, System, omega_of
from camcli.words.verdict import verdict
from tests.conftest import chapter_system, settings
from tests.support.machines import Shape

OMEGA0 = 34.2319495767677805
B, E = 150.1793714951576, 209.8206285048424


def rpm_of(c, c2):
    """The undamped ratio, from values of the cam that were computed to 16 digits elsewhere."""
    return OMEGA0 * sqrt(c / -c2) * 30.0 / pi


def by_region(found):
    return {loss.region.name: loss for loss in found.losses}


def touches(system, rpm):
    return not Orbit(system, rpm, settings(0, 1)).run().rests_throughout


def lifts_off_at(system, low, high):
    """The lowest speed with lift-off, by simulations alone; within 1e-7 rpm."""
    assert not touches(system, low)
    assert touches(system, high)
    while high - low > 1e-7:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if touches(system, middle) else (middle, high)
    return 0.5 * (low + high)


def made(parts, strobe_deg=0.0, **follower):
    """A machine on a cam whose parts are functions of half a turn."""
    values = {"mass": 1.0, "stiffness": 1000.0, **follower}
    shape = Shape(lambda: parts(arb.pi()))
    return System.build(Follower(**values), shape, phase_of(strobe_deg))


def eccentric(base, lift, strobe_deg=0.0, **follower):
    base, half_lift = arb(str(base)), arb(str(lift)) / 2

    def parts(half):
        return [Part(arb(0), 2 * half, lambda x: base + half_lift * (1 - x.cos()))]

    return made(parts, strobe_deg, **follower)


def dwell(level, **follower):
    return made(lambda half: [Part(arb(0), 2 * half, None, arb(str(level)))], **follower)


def roof(**follower):
    """A lift that rises and falls in straight lines: one kink up at 0, one down at 180 deg."""

    def parts(half):
        low = arb("0.1")
        rise = Part(arb(0), half, lambda x: low + x / 100)
        return [rise, Part(half, 2 * half, lambda x: low + (2 * half - x) / 100)]

    return made(parts, **follower)


def test_the_example_loses_contact_first_at_b(chapter):
    found = detachment(chapter)
    first, regions = found.first, by_region(found)
    opens = rpm_of(0.2312555620189976, -1.869212582774405)
    fills = rpm_of(0.25393320723821, -1.491680113303188)
    assert (opens, fills) == pytest.approx((114.979326744, 134.872968058), abs=1e-9)
    assert first.rpm == pytest.approx(opens, abs=1e-9)
    assert (first.region, first.status) == ("A2", "ok")
    for name, begins, ends in (("A2", B, 160.0), ("A4", E, 200.0)):
        loss = regions[name]
        assert (loss.opens.rpm, loss.fills.rpm) == pytest.approx((opens, fills), abs=1e-9)
        phases = (degrees(loss.opens.theta), degrees(loss.fills.theta))
        assert phases == pytest.approx((begins, ends), abs=1e-9)
    for name in ("A1", "A3", "A5", "A6"):
        assert regions[name].opens.rpm == regions[name].fills.rpm == inf
        assert regions[name].opens.status == regions[name].fills.status == "never"
    assert first.low < first.rpm < first.high < first.low + 1e-9
    assert not touches(chapter, first.low)
    force = Force(chapter)
    assert force.weakest(first.low)[0] > 0.0 > force.weakest(first.high)[0]


@pytest.mark.parametrize(
    ("system", "region"),
    [
        (chapter_system(damping=5.0, preload=20.0), "A4"),
        (chapter_system(damping=500.0, gravity=9.81), "A4"),
        (eccentric(0.1, 0.05, damping=150.0, preload=3.0, gravity=9.81), "A1"),
    ],
)
def test_damped_and_preloaded_followers_agree_with_simulations(system, region):
    first = detachment(system).first
    assert (first.region, first.status) == (region, "ok")
    assert first.rpm == pytest.approx(
        lifts_off_at(system, first.rpm * 0.99, first.rpm * 1.01), abs=1e-7
    )


def test_a_smooth_cam_loses_contact_inside_its_one_region():
    for strobe in (0.0, 180.0):
        system = eccentric(0.1, 0.05, strobe)
        (loss,) = detachment(system).losses
        assert loss.opens.rpm == pytest.approx(sqrt(1000.0 * 0.15 / 0.025) * 30 / pi, rel=1e-13)
        assert degrees(loss.opens.theta) == pytest.approx(180.0, abs=1e-5)
        assert (loss.region.name, loss.region.begins, loss.fills.rpm) == ("A1", "", inf)
    seen = lift_off(Bursts(system, "A1", loss.opens.theta, 10**6), loss)
    assert seen.kind is LiftOffKind.WITHIN
    assert degrees(seen.release) < 180.0 < degrees(seen.landing)


@pytest.mark.parametrize("strobe", [0.0, 180.0])
def test_a_force_that_is_zero_at_standstill_is_held_where_motion_presses(strobe):
    """N(0) = 0 at theta = 0 only, where c_thetatheta > 0: lost at the top from sqrt(2 k/m) on."""
    found = detachment(eccentric(0, 0.05, strobe))
    assert (found.always, found.first.status) == ((), "ok")
    assert found.first.rpm == pytest.approx(sqrt(2000.0) * 30 / pi, rel=1e-12)
    assert degrees(found.first.theta) == pytest.approx(180.0, abs=1e-5)
    below = detachment(eccentric(-0.001, 0.05, strobe))
    assert below.always[0].value == pytest.approx(-1.0)


def test_flight_at_b_is_told_from_the_release_at_e(chapter):
    losses = by_region(detachment(chapter))
    two, four = (
        lift_off(Bursts(chapter, name, losses[name].opens.theta, 10**6), losses[name])
        for name in ("A2", "A4")
    )
    for seen in (two, four):  # just above the loss
        assert 0.0 < seen.rpm / losses[seen.region].opens.rpm - 1.0 < 1e-3
    assert (two.kind, two.corner) == (LiftOffKind.FLIES_OFF, "b")
    assert degrees(two.release) == pytest.approx(B, abs=1e-12)
    assert B < degrees(two.landing) < degrees(two.rest) < B + 0.01
    assert (four.kind, four.corner) == (LiftOffKind.CAUGHT, "e")
    assert E - 1e-3 < degrees(four.release) < E - 1e-6
    assert E < degrees(four.landing) < E + 1e-6


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
    assert (found.first, found.never) == (None, False)
    place = found.always[0]
    assert (place.reason, degrees(place.theta)) == (reason, pytest.approx(theta_deg, abs=1e-9))
    assert place.value == pytest.approx(value, abs=1e-9)
    never = detachment(dwell(0.1))
    assert (never.first, never.never) == (None, True)


def test_damping_can_press_the_follower_again_at_speed():
    force = Force(eccentric(0.1, 0.05, damping=300.0))
    lost = {x / 100.0: force.lost(0, x / 100.0) for x in range(480, 620)}
    assert any(high < inf for _, high in lost.values())
    for x, (low, high) in lost.items():
        if high < inf:
            speeds = (0.99 * low, 0.5 * (low + high), 1.01 * high)
            assert [force.newton(0, x, omega) > 0.0 for omega in speeds] == [True, False, True]


@pytest.mark.parametrize(
    ("follower", "rpm"),
    [({}, 400.0), ({"damping": 8.0, "preload": 10.0}, 130.0), ({"damping": 40.0}, 400.0)],
)
def test_every_spring_holds_just_below_and_loses_just_above(follower, rpm):
    system = chapter_system(gravity=9.81, **follower)
    answers = hold_to(system, rpm, 0.0, 0.05)
    assert [hold.quantity for hold in answers] == ["hold_stiffness", "hold_preload", "hold_both"]
    for hold in answers:
        assert hold.status == "ok"
        assert hold.detaches == pytest.approx(rpm, rel=1e-12)
        assert hold.least_n == pytest.approx(0.0, abs=1e-9)
        other = replaced(system, hold.stiffness, hold.preload)
        assert not touches(other, rpm * (1.0 - 1e-9))
        assert touches(other, rpm * (1.0 + 1e-6))
    stiffness, preload, both = answers
    assert (stiffness.preload, preload.stiffness) == (
        system.follower.preload, system.follower.stiffness
    )  # fmt: skip
    assert both.preload == pytest.approx(0.05 * both.stiffness, rel=1e-15)
    other = replace(system, follower=replace(system.follower, stiffness=9.0))
    assert hold_to(other, rpm, 0.0, 0.05)[0].stiffness == stiffness.stiffness


def test_a_spring_is_measured_by_the_worst_speed_of_each_phase():
    """With damping, on a convex fall, that speed lies inside the range."""
    worst = []
    for theta, damping in ((1.7, 30.0), (2.7, 30.0), (3.0, 30.0), (3.9, 30.0), (3.9, 70.0)):
        system = chapter_system(damping=damping, gravity=9.81)
        need, force = Need(system, 300.0, 2.0), Force(system)
        i = stretch_at(system.cam, theta)
        wanted, c = need.at(i, theta)
        forces = [force.newton(i, theta, omega_of(0.1 * k)) for k in range(3001)]
        assert 2.0 - wanted == pytest.approx(min(forces) - 1430.8 * c, abs=1e-4)
        worst.append(forces.index(min(forces)) / 3000)
    assert any(0.0 < share < 0.5 for share in worst)
    assert any(0.5 < share < 1.0 for share in worst)


def test_a_spring_that_is_not_needed_and_one_that_cannot_hold():
    for hold in hold_to(chapter_system(stiffness=0.0, gravity=9.81), 20.0, 0.0, 0.05):
        assert (hold.status, hold.stiffness, hold.preload) == ("not-needed", 0.0, 0.0)
        assert hold.detaches > 20.0
    stiffness, preload, both = hold_to(dwell(-0.1), 100.0, 5.0, 0.05)
    assert stiffness.status == both.status == "impossible"
    assert stiffness.obstacle is both.obstacle is Obstacle.LIFT
    assert (stiffness.missing_n, both.missing_n, both.detaches) == (5.0, 5.0, None)
    assert (preload.preload, preload.least_n) == pytest.approx((105.0, 5.0))
    assert hold_to(dwell(-0.1), 100.0, 5.0, 0.2)[2].stiffness == pytest.approx(50.0)
    heavy = hold_to(dwell(-0.1, gravity=9.81), 100.0, 9.81 + 1e-5, 0.05)[0]
    assert (heavy.status, heavy.missing_n) == ("impossible", pytest.approx(1e-5))
    assert {hold.obstacle for hold in hold_to(roof(), 10.0, 0.0, 0.05)} == {Obstacle.KINK}


@pytest.mark.parametrize("damping", [0.0, 60.0, 150.0, 400.0])
def test_a_region_is_filled_where_all_of_it_is_lost_at_one_speed(damping):
    """Against the force on a grid of phases and speeds: damping may press again at higher ones."""
    system = chapter_system(damping=damping, gravity=9.81)
    follower, speeds = system.follower, np.geomspace(0.5, 1e5, 4000)
    omega = speeds * pi / 30
    for loss in detachment(system).losses:
        stretches = [(i, system.cam.stretches[i]) for i in loss.region.stretches]
        places = [(i, x) for i, s in stretches for x in np.linspace(s.start, s.end, 60)[1:-1]]
        c, c1, c2 = np.array([lift_at(system.cam, i, x) for i, x in places]).T[:, :, None]
        force = follower.stiffness * c + follower.mass * 9.81
        force = force + follower.damping * omega * c1 + follower.mass * omega**2 * c2
        lost = np.flatnonzero((force < 0.0).all(axis=0))
        expected = speeds[lost[0]] if lost.size else inf
        if expected < 5e4:
            assert loss.fills.rpm == pytest.approx(expected, rel=0.05)
        else:
            assert loss.fills.rpm > 4e4


def test_a_region_that_opens_again_before_all_of_it_is_lost_is_never_filled():
    """c_theta = -s/(1 + 9 theta) on the fall: 1 + 9 theta scales the speeds of every phase alike.

    With A = d^2 s/40 contact is lost from 0.038 to 0.073 times d (1 + 9 theta).
    """
    low, s, d = 0.1, 0.01, 20.0

    def parts(half):
        depth = (1 + 9 * half).log() * s / 9
        fall = Part(arb(0), half, lambda x: low - (1 + 9 * x).log() * s / 9)
        return [fall, Part(half, 2 * half, lambda x: low - depth * (2 * half - x) / half)]

    system = made(parts, stiffness=0.0, damping=d, gravity=d * d * s / 40)
    first = next(loss for loss in detachment(system).losses if 0 in loss.region.stretches)
    assert first.opens.rpm == pytest.approx(d / 18 * (1 - sqrt(0.1)) * 30 / pi, rel=1e-9)
    assert first.fills.rpm == inf


def test_a_speed_that_the_kernel_does_not_confirm_is_unresolved(monkeypatch):
    monkeypatch.setattr(Force, "stays_positive", lambda *_: False)
    opened = [loss.opens for loss in detachment(chapter_system()).losses if loss.opens.finite]
    assert {opens.status for opens in opened} == {SpeedStatus.UNRESOLVED}


def test_the_lowest_value_lies_inside_where_it_is_lower_by_more_than_rounding():
    """A minimum lower by 1e-10 than the end of the interval, and between two samples."""
    value, place = lowest(
        lambda x: 1.0 if x < 0.02 else (x - 0.37) ** 2 + (1 - 1e-10), 0.0, 1.0, 20
    )
    assert place == pytest.approx(0.37, abs=1e-6)
    assert value == 1 - 1e-10


@pytest.mark.parametrize(
    ("system", "why"),
    [
        (roof(), "the cam's slope drops at 180 deg"),
        (roof(preload=-200.0), "the cam's slope drops at 180 deg"),  # nor does the spring press
        (dwell(-0.1), "the spring does not press even at standstill at 0 deg"),
    ],
)
def test_a_verdict_names_the_first_reason_for_which_contact_is_always_lost(system, why):
    result = SimpleNamespace(command="detach", scene=load_scene(None), system=system)
    said = verdict(result, detachment(result.system), None)
    assert said.lines == [f"Contact is lost at every speed: {why}."]
    assert said.details == []


def test_the_motion_past_the_loss_is_measured_behind_its_transient(chapter):
    """Twenty turns from rest, and twenty that count: at 700 rpm they are unlike the first ones."""
    found = motion_past(chapter, 700.0, settings())
    for transient, same in ((20, True), (0, False)):
        record = Orbit(chapter, 700.0, settings(transient, 20)).run()
        assert (found.loads == loads_of(chapter, 700.0, record)) is same
        assert bool(found.impact_count == sum(record.impacts[:20])) is same


@pytest.mark.parametrize("strobe_deg", [0.0, 90.0])
def test_the_region_of_a_cam_with_one_corner_is_all_of_it(strobe_deg):
    """A single hump, whose slope drops from -1/20 to +1/20 at 0 alone."""

    def parts(half):
        return [Part(arb(0), 2 * half, lambda x: (x / 2).sin() / 10)]

    cam = made(parts, strobe_deg).cam
    (region,) = regions(cam)
    assert region.stretches == tuple(range(len(cam.stretches)))
    assert (region.begins, region.ends) == ("a", "a")
    assert (region.start, region.end) == pytest.approx((0.0, 2.0 * pi))
    assert (len(cam.stretches) > 1) == (strobe_deg > 0.0)


def test_what_else_is_known_of_a_machine_does_not_stand_for_its_detachment():
    system = roof()
    system.known["something else"] = "known"
    found = detachment(system)
    assert detachment(system) is found
    assert system.known["detachment"] is found


@pytest.mark.parametrize("spring", [(900.0, 0.0), (0.0, 7.0), (900.0, -3.0)])
def test_another_spring_replaces_both_of_its_numbers(spring):
    follower = replaced(dwell(0.1, stiffness=50.0, preload=20.0, damping=3.0), *spring).follower
    assert (follower.stiffness, follower.preload, follower.damping) == (*spring, 3.0)
