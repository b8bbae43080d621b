"""The certificate of a root: every verdict checked by sampling the closed-form flights densely."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camcli.analysis.orbits.identify import solve_from
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.certify import ADMISSIBLE, EARLY, LATE, PULLS
from camcli.kernel.flow import constants_of, move
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import chapter_system, settings

SAMPLES = 1000
MACHINES = {
    "chapter": {},
    "damped": {"damping": 2.0},
    "gravity": {"gravity": 9.81},
    "preload": {"preload": 25.0},
    "pulled": {"preload": -200.0},
    "lively": {"restitution": 0.95},
    "dull": {"restitution": 0.3, "damping": 5.0},
}


def gaps(system, root, k):
    """Gap and phase on a grid strictly inside flight k of a root."""
    lane, n = constants_of(root.machine, 0.0, 0), root.count
    j = (k + 1) % n
    later = root.whole[2 * j + 1] - root.whole[2 * k + 1] + (root.turns if k == n - 1 else 0)
    s = root.theta[j] - root.theta[k] + TURN * later
    c, c1, _ = lift(system.cam, root.whole[2 * k], root.theta[k])
    places = np.linspace(0.0, s, SAMPLES + 2)[1:-1]
    found = []
    for x in places:
        theta = (root.theta[k] + x) % TURN
        height = lift(system.cam, stretch_at(system.cam, theta), theta)[0]
        found.append(move(lane, c, c1 + root.x[2 * k + 1], float(x))[0] - height)
    return np.array(found), places


@pytest.mark.parametrize("name", MACHINES)
def test_every_verdict_on_a_single_impact_root_is_true(name):
    """PULLS, EARLY and ADMISSIBLE seen in the gap itself, over 1 to 3 turns."""
    system, seen = chapter_system(**MACHINES[name]), set()
    for rpm in (250.0, 520.0, 700.0, 820.0):
        shooter = Shooter(system, rpm)
        for turns in (1, 2, 3):
            for root in single_impact_roots(shooter, rpm, turns):
                code, _, phase = shooter.verdict(root)
                seen.add(code)
                assert (code == PULLS) == (root.rates[0] >= 0.0)
                if code == PULLS:
                    continue
                gap, places = gaps(system, root, 0)
                if code == ADMISSIBLE:
                    assert gap.min() > 0.0, (rpm, turns)
                else:
                    assert code == EARLY
                    assert gap.min() < 0.0, (rpm, turns)
                    first = places[np.argmax(gap < 0.0)]
                    reached = (phase - root.theta[0]) % TURN
                    assert abs((first - reached + pi) % TURN - pi) < 2 * places[0] + 1e-2
    assert EARLY in seen
    if name != "pulled":
        assert ADMISSIBLE in seen


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
    at_b = system.corners_deg[1] * pi / 180
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
    b = system.corners_deg[1] * pi / 180
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
