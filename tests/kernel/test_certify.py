"""The certificate of a root: what is nearly a motion is none.

That no verdict is wrong, of any machine, `tests/exact/test_proofs.py` shows in ball arithmetic.
"""

from dataclasses import replace

import pytest
from conftest import solve_from

from camcli.analysis.orbits.shooter import Shooter
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.certify import ADMISSIBLE, EARLY, LATE, PULLS
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import chapter_system, settings


def root_at(system, rpm, guess, turns=1):
    shooter = Shooter(system, rpm)
    whole = tuple(v for x in guess[::2] for v in (stretch_at(system.cam, x % TURN), 0))
    root = shooter.at_value([*guess, rpm], whole, turns, rpm)
    assert root is not None
    return shooter, root


def test_a_missing_impact():
    """The unstable orbit on A1 continued beyond b, where the cam is A2: no impact there."""
    system = chapter_system()
    shooter = Shooter(system, 673.0)
    at_b = system.corners[1]
    i = stretch_at(system.cam, at_b - 1e-9)
    x = [at_b + 0.003, 8 * lift(system.cam, i, at_b + 0.003)[1], 673.2]
    root = shooter.correct(x, (i, 0), 1, [1.0, 0.0, 0.0], x)
    assert root is not None
    assert root.theta[0] > system.cam.stretches[i].end
    assert shooter.verdict(root)[0] in (EARLY, LATE)


@pytest.mark.parametrize("k", [0, 1])
def test_the_flight_that_fails_is_named(k):
    """An impact with its rate changed by hand: its flight lands early, or late."""
    system = chapter_system()
    shooter, root = root_at(system, 358.5, [2.6354469, 0.978, 5.8108811, 0.994])
    for change, code in ((0.99, EARLY), (1.01, LATE)):
        x = list(root.x)
        x[2 * k + 1] *= change
        verdict = shooter.verdict(replace(root, x=x))
        assert verdict[:2] == (code, k)
        j = (k + 1) % 2
        assert (verdict[2] - root.theta[j] < 0) == (code == EARLY)


def test_what_is_nearly_a_motion_is_none():
    """A rate of zero pulls, a follower that rests is early, a contact 1e-4 rad away is another."""
    shooter, root = root_at(chapter_system(), 358.5, [2.6354469, 0.978, 5.8108811, 0.994])
    assert shooter.verdict(replace(root, rates=[0.0, *root.rates[1:]]))[0] == PULLS
    x = list(root.x)
    x[2] += 1e-4
    assert shooter.verdict(replace(root, x=x))[:2] == (EARLY, 0)
    x = list(root.x)
    x[3] = 0.0  # on the base circle, where the spring presses
    assert shooter.verdict(replace(root, x=x))[:2] == (EARLY, 1)


def test_an_orbit_that_flies_over_kinks_is_certified():
    """Rise and fall with constant velocity: c_theta jumps at four places of the turn."""
    laws = {"cam.rise.law": "constant-velocity", "cam.fall.law": "constant-velocity"}
    scene = load_scene("configs/law-harmonic.yaml", laws)
    follower = Follower(**scene.follower.model_dump())
    orbit = solve_from(System.build(follower, scene.cam), 700.0, settings(600, 40))
    assert orbit.label == "P(1;1)"
    assert orbit.admissible


def test_an_impact_exactly_at_a_corner_is_admissible_on_both_sides():
    system = chapter_system()
    b = system.corners[1]
    sides = {}
    for side in (-1, 1):
        shooter = Shooter(system, 673.0)
        i = stretch_at(system.cam, b + side * 1e-6)
        corner = system.cam.stretches[i].end if side < 0 else system.cam.stretches[i].start
        x = [corner, 8 * lift(system.cam, i, corner)[1], 673.2]  # 2 r/(1 - r) c_theta
        root = shooter.correct(x, (i, 0), 1, [1.0, 0.0, 0.0], x)
        assert root.theta[0] == corner
        assert shooter.verdict(root)[0] == ADMISSIBLE
        sides[side] = root
    assert abs(sides[-1].value - sides[1].value) < 1e-11
    assert abs(sides[-1].trace - 1.6418699364) < 1e-9
    assert abs(sides[1].trace - 1.3714214414) < 1e-9
