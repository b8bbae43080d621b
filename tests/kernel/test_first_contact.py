"""Impacts of whole orbits against the high-precision reference."""

import random
from math import acos, atan2, cos, hypot, pi, radians, sin, sqrt

import pytest

from camcli.cams.law import LawCam
from camcli.system import Follower, System
from tests.support.kernel_runs import ORACLE_CAM, events, reference, run, system, worst_phase_error

CRITICAL = 2 * sqrt(1430.8 * 1.221)
TINY = 1e-16  # chatter tolerance, so that the hops of a chatter are flown one by one
SCENES = {
    "chapter at 700 rpm": (700.0, {}, {}),
    "chapter at 190 rpm": (190.0, {}, {}),
    "chapter at 358.5 rpm": (358.5, {}, {}),
    "chapter at 745 rpm": (745.0, {}, {}),
    "just above detachment": (115.0, {}, {}),
    "incomplete chatter": (199.0, {}, {}),
    "underdamped": (400.0, {"damping": 20.0}, {}),
    "critical": (700.0, {"damping": CRITICAL}, {}),
    "overdamped": (900.0, {"damping": 300.0}, {}),
    "strongly overdamped": (130.0, {"damping": 2000.0}, {}),
    "gravity": (500.0, {"gravity": 9.81}, {}),
    "gravity and preload": (300.0, {"gravity": 9.81, "preload": 50.0}, {}),
    "stiff and fast": (50000.0, {"stiffness": 1e8}, {}),
    "elastic": (500.0, {"restitution": 1.0}, {}),
    "nearly elastic": (300.0, {"restitution": 0.99}, {}),
    "plastic": (500.0, {"restitution": 0.0}, {}),
    "no spring": (200.0, {"stiffness": 0.0, "gravity": 9.81}, {}),
    "no spring, damped": (200.0, {"stiffness": 0.0, "gravity": 9.81, "damping": 1.0}, {}),
    "thrown": (500.0, {}, {"q": 0.7, "v": 3.0}),
    "thrown down": (250.0, {"damping": 5.0}, {"q": 0.3, "v": -4.0}),
}


def both(rpm, changes, start, impacts=12):
    """Events of the package and of the oracle."""
    theirs = reference(rpm, impacts=impacts, cut=1e-18, start=start, **changes)
    turns = max(event.turn for event in theirs) + 2
    ours = events(run(rpm, system(**changes), record=turns, tolerance=TINY, **start))
    return ours, theirs


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_a_dozen_impacts(scene):
    """Phases within 1e-12 turns of the event's stretching; the first on the cam, at its rate."""
    rpm, changes, start = SCENES[scene]
    ours, theirs = both(rpm, changes, start)
    assert len(ours) >= len(theirs) - 1
    worst, compared = worst_phase_error(ours, theirs)
    assert compared >= (6 if "no spring" in scene else 12)
    assert worst < 1e-12
    for (kind, _, theta, q, u), event in zip(ours[:10], theirs, strict=False):
        if event.stretching > 1e6:
            break
        assert abs(q - float(ORACLE_CAM.c(theta))) < 1e-15
        if kind == "impact":
            assert abs(u * rpm * pi / 30 - event.u_minus) < 1e-9 * abs(event.u_minus)


HEAVY = {"mass": 1.0, "stiffness": 1.935, "damping": 370.0, "gravity": 14.5, "restitution": 0.5}


@pytest.mark.parametrize("changes", [{"gravity": 9.81}, HEAVY], ids=["light", "heavy"])
@pytest.mark.parametrize("corner", [0, 2])
@pytest.mark.parametrize("before", [1e-15, 1e-14, 1e-12, 1e-8])
@pytest.mark.parametrize("u", [1e-6, 1e-2])
def test_a_bounce_just_before_a_corner_is_a_bounce(changes, corner, before, u):
    """However near the corner, a follower that leaves with u > 0 flies on."""
    theta = float(ORACLE_CAM.breakpoints[corner]) - before
    rpm = 400.0
    v = rpm * pi / 30 * (float(ORACLE_CAM.c1(theta)) + u)
    degrees = theta * 180 / pi
    tape = run(rpm, system(**changes), record=2, tolerance=TINY, theta_deg=degrees, v=v)
    there = {"theta": degrees * (pi / 180), "v": v}
    (first,) = reference(rpm, impacts=1, cut=1e-18, start=there, **changes)
    kind, turn, theta, _, _ = events(tape, 1)[0]
    assert (kind, turn) == (first.kind, first.turn)
    assert abs(theta - float(first.theta)) < 1e-6


def test_a_landing_on_a_corner_flies_on_with_the_slope_beyond_it():
    """Thrown to land where a dwell ends in a fall steeper than its own: it flies on,
    and lands on the lower dwell where the closed form from the corner does.
    """
    low, high, length = 0.05, 0.13, 20.0
    law = {"length_deg": length, "law": "constant-velocity"}
    rise = {**law, "start_deg": 60}
    cam = LawCam(kind="law", base=low, lift=high - low, top_dwell_deg=150, rise=rise, fall=law)
    corner, omega = radians(230), 100 * pi / 30
    draw, compared = random.Random(0), 0
    for _ in range(60):
        W, back = draw.uniform(0.9, 1.2), draw.uniform(0.6, 0.7)
        u = (low - high) / radians(length) * draw.uniform(0.4, 0.8)
        follower = Follower(mass=1.0, stiffness=(W * omega) ** 2, restitution=0.5)
        q = high * cos(W * back) - u / W * sin(W * back)
        w = high * W * sin(W * back) + u * cos(W * back)
        start = {"q": q, "v": w * omega, "theta_deg": 230 - back * 180 / pi}
        *_, theta, _, _ = events(run(100.0, System.build(follower, cam), **start))[0]
        if theta < corner + radians(length):  # rounding let it touch the upper dwell before
            continue
        true = acos(low / hypot(high, u / W)) + atan2(u / W, high)
        assert abs(corner + true / W - theta) < 2e-14
        compared += 1
    assert compared > 20
