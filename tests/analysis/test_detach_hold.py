"""--hold-to: the spring that holds contact up to a speed, verified by simulation."""

from dataclasses import replace

import pytest

from camcli.analysis.contact_loss.force import Force
from camcli.analysis.contact_loss.hold import Obstacle, _Need, hold_to, replaced
from camcli.analysis.integrate import Orbit
from camcli.kernel.cam_table import stretch_at
from camcli.system import omega_of
from tests.analysis.test_detach import dwell, roof
from tests.conftest import chapter_system, settings


def touches(system, rpm):
    return Orbit(system, rpm, settings(0, 3)).run().touches


@pytest.mark.parametrize(
    "follower", [{}, {"damping": 8.0, "preload": 10.0}, {"gravity": 9.81, "damping": 40.0}]
)
@pytest.mark.parametrize("rpm", [130.0, 400.0])
def test_every_spring_holds_just_below_and_loses_just_above(follower, rpm):
    system = chapter_system(**follower)
    answers = hold_to(system, rpm, 0.0, 0.05)
    assert [hold.quantity for hold in answers] == ["hold_stiffness", "hold_preload", "hold_both"]
    for hold in answers:
        other = replaced(system, hold.stiffness, hold.preload)
        assert hold.status == "ok"
        assert hold.detaches_rpm == pytest.approx(rpm, rel=1e-12)
        assert hold.least_n == pytest.approx(0.0, abs=1e-9)
        assert not touches(other, rpm * (1.0 - 1e-9))
        assert touches(other, rpm * (1.0 + 1e-6))
    assert answers[0].preload == system.follower.preload
    assert answers[1].stiffness == system.follower.stiffness
    assert answers[2].preload == pytest.approx(0.05 * answers[2].stiffness, rel=1e-15)


def test_the_margin_is_kept_up_to_the_speed_and_not_more_than_needed(chapter):
    for hold in hold_to(chapter, 180.0, 25.0, 0.05):
        other = replaced(chapter, hold.stiffness, hold.preload)
        assert Force(other).weakest(180.0)[0] == pytest.approx(25.0, abs=1e-9)
        assert hold.least_n == pytest.approx(25.0, abs=1e-9)
        assert hold.detaches_rpm > 180.0
        less = replaced(chapter, hold.stiffness * 0.999, hold.preload * 0.999)
        assert Force(less).weakest(180.0)[0] < 25.0


def test_the_force_asked_for_is_that_of_the_worst_speed():
    """With damping, on a convex fall, that speed lies below the one asked for."""
    system = chapter_system(damping=30.0, gravity=9.81)
    need, force = _Need(system, 300.0, 2.0), Force(system)
    spring = system.follower.stiffness
    inside = 0
    for theta in (1.7, 2.0, 2.7, 3.0, 3.55, 3.7, 3.9, 4.2, 4.6):
        i = stretch_at(system.cam, theta)
        wanted, c = need.at(i, theta)
        speeds = [omega_of(300.0) * k / 3000 for k in range(3001)]
        forces = [force.newton(i, theta, omega) for omega in speeds]
        least = min(range(3001), key=forces.__getitem__)
        inside += 0 < least < 3000
        assert 2.0 - wanted == pytest.approx(forces[least] - spring * c, abs=1e-4)
    assert inside >= 3


def test_a_spring_that_is_not_needed_is_said():
    for hold in hold_to(chapter_system(stiffness=0.0, gravity=9.81), 20.0, 0.0, 0.05):
        assert hold.status == "not-needed"
        assert (hold.stiffness, hold.preload) == (0.0, 0.0)
        assert hold.detaches_rpm > 20.0


def test_a_spring_below_its_rest_length_cannot_press():
    stiffness, preload, both = hold_to(dwell(-0.1), 100.0, 5.0, 0.05)
    assert stiffness.status == both.status == "impossible"
    assert stiffness.obstacle is both.obstacle is Obstacle.LIFT
    assert (stiffness.missing_n, both.missing_n) == (5.0, 5.0)
    assert stiffness.detaches_rpm is None
    assert preload.preload == pytest.approx(105.0)
    assert preload.least_n == pytest.approx(5.0)
    both = hold_to(dwell(-0.1), 100.0, 5.0, 0.2)[2]
    assert both.stiffness == pytest.approx(50.0)


def test_a_kink_cannot_be_held_by_any_spring():
    assert {hold.status for hold in hold_to(roof(), 10.0, 0.0, 0.05)} == {"impossible"}


def test_the_answer_does_not_depend_on_the_spring_it_replaces(chapter):
    other = replace(chapter, follower=replace(chapter.follower, stiffness=9.0))
    a, b = (hold_to(system, 200.0, 0.0, 0.05)[0].stiffness for system in (chapter, other))
    assert a == b
