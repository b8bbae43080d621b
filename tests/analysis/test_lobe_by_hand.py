"""The lobe of an eccentric, from points of its pitch curve and their differences.

The lift is h (1 - cos theta)/2, with h = 10 mm. A flat face runs on a circle of radius base + h/2.
"""

from __future__ import annotations

from math import cos, hypot, inf, pi, sin

import numpy as np
import pytest

from camcli.analysis.lobe import Face, _Geometry, lobe_of
from camcli.cams.eccentric import EccentricCam
from camcli.system import Follower, System

H = 0.01
BASE = 0.03
TURN = 2.0 * pi
ENDS = [(0, 0.0), (0, 1.0), (0, 2.5), (0, 5.0), (0, 6.0)]


def machine() -> System:
    follower = Follower(mass=2.0, stiffness=800.0, preload=90.0)
    return System.build(follower, EccentricCam(kind="eccentric", base=0.02, lift=H), 0.0)


def pitch(theta, roller, ratio=1.0):
    """(x, y) of the centre of a roller, or of a knife edge, when the cam has not turned."""
    away = BASE + roller + 0.5 * H * (1.0 - cos(theta)) / ratio
    return np.array([away * sin(theta), away * cos(theta)])


@pytest.mark.parametrize("ratio", [1.0, 1.5])
@pytest.mark.parametrize("roller", [0.0, 0.012])
@pytest.mark.parametrize("theta", [0.4, 2.0, 4.5])
def test_a_roller_touches_the_lobe_inwards_from_its_pitch_curve(theta, roller, ratio):
    geometry = _Geometry(machine(), Face.ROLLER if roller else Face.KNIFE, BASE)
    geometry.ratio = ratio
    touch = geometry.touch(0, theta, roller)
    step = 1e-4
    before, here, after = (pitch(theta + k * step, roller, ratio) for k in (-1, 0, 1))
    dx, dy = (after - before) / (2.0 * step)
    speed = hypot(dx, dy)
    outwards = np.array([-dy, dx]) / speed
    assert outwards @ here > 0.0
    assert touch.place == pytest.approx(here - roller * outwards, abs=1e-9)
    inclined = np.arctan2(*outwards) - theta  # from the line on which the follower moves
    assert abs(touch.angle) == pytest.approx(abs((inclined + pi) % TURN - pi), abs=1e-6)
    assert (touch.angle > 0.0) == (theta < pi)  # the cam lifts
    ddx, ddy = (after - 2.0 * here + before) / step**2
    curvature = (dy * ddx - dx * ddy) / speed**3
    assert touch.radius == pytest.approx(1.0 / abs(curvature) - roller, rel=1e-5)
    x, y = touch.place
    assert touch.direction % TURN == pytest.approx(np.arctan2(x, y) % TURN)


@pytest.mark.parametrize("theta", [0.4, 2.0, 4.5])
def test_a_flat_face_touches_a_circle_beside_the_line(theta):
    touch = _Geometry(machine(), Face.FLAT, BASE).touch(0, theta, 0.0)
    assert touch.radius == pytest.approx(BASE + 0.5 * H)
    assert touch.beside == pytest.approx(0.5 * H * sin(theta))
    assert touch.angle == 0.0
    x, y = touch.place
    assert hypot(x, y + 0.5 * H) == pytest.approx(BASE + 0.5 * H)  # its centre, opposite the nose


def test_the_lobe_of_a_flat_face():
    lobe = lobe_of(machine(), Face.FLAT, BASE, 0.0, ENDS)
    assert (lobe.face, lobe.base, lobe.roller, lobe.undercut) == (Face.FLAT, BASE, 0.0, False)
    assert [touch.theta for touch in lobe.touches] == [theta for _, theta in ENDS]
    assert lobe.least.value == pytest.approx(BASE + 0.5 * H)
    assert lobe.least_base == pytest.approx(0.0, abs=1e-12)
    assert (lobe.hollow, lobe.largest_roller) == (None, None)
    least, largest = lobe.beside
    assert (least.value, least.theta) == pytest.approx((-0.5 * H, 1.5 * pi), abs=1e-6)
    assert (largest.value, largest.theta) == pytest.approx((0.5 * H, 0.5 * pi), abs=1e-6)
    (x0, y0), (x1, y1) = lobe.touches[0].place, lobe.touches[-1].place
    assert lobe.closing == pytest.approx(hypot(x1 - x0, y1 - y0))
    under = lobe_of(machine(), Face.FLAT, -0.6 * H, 0.0, ENDS)
    assert under.undercut
    assert under.least_base == 0.0
    assert under.least.value == pytest.approx(-0.1 * H)


@pytest.mark.parametrize("roller", [0.0, 0.012])
def test_the_lobe_of_a_roller_has_its_extremes_where_samples_have_them(roller):
    """A knife edge is never undercut, and asks for no roller; nor does a convex lobe."""
    face = Face.ROLLER if roller else Face.KNIFE
    lobe = lobe_of(machine(), face, BASE, roller, ENDS)
    geometry = _Geometry(machine(), face, BASE)
    phases = np.linspace(0.0, TURN, 2001).tolist()
    touches = [geometry.touch(0, theta, roller) for theta in phases]
    sharpest = min((touch for touch in touches if touch.radius > -roller), key=lambda t: t.radius)
    assert lobe.least.value == pytest.approx(sharpest.radius, rel=1e-5)
    at, there = (min(one.theta, TURN - one.theta) for one in (lobe.least, sharpest))
    assert at == pytest.approx(there, abs=0.01)  # the lobe is symmetric
    angles = [touch.angle for touch in touches]
    least, largest = lobe.beside
    assert (least.value, largest.value) == pytest.approx((min(angles), max(angles)), rel=1e-5)
    assert least.theta == pytest.approx(phases[int(np.argmin(angles))], abs=0.01)
    assert largest.theta == pytest.approx(phases[int(np.argmax(angles))], abs=0.01)
    assert (lobe.undercut, lobe.least_base, lobe.hollow) == (False, None, None)
    assert lobe.roller == roller
    assert lobe.largest_roller is None
    assert geometry.least(roller).value < inf
