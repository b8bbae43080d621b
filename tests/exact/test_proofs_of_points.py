"""Points of codimension two in numbers of the cam: their boxes hold what mpmath has."""

from math import pi

import pytest
from mpmath import mp, mpf

from camcli import load_scene, orbits
from camcli.analysis.orbits.codim2 import prove
from tests.support.followed import Machines, Wave, arcs, meeting
from tests.support.orbit_oracle import at_corner, touching, with_multiplier

pytestmark = pytest.mark.slow

SPRUNG = {"mass": 1, "stiffness": 1, "damping": 0.1}
CHAPTER = {"mass": 1.221, "stiffness": 1430.8}


def impacts_of(point) -> list:
    """(unrolled phase, outgoing velocity) of every impact, in four digits."""
    root = point.orbit.root
    speed = point.orbit.rpm * pi / 30
    return [
        (mpf(f"{theta:.4g}") + 2 * mp.pi * turn, mpf(f"{v * speed:.4g}"))
        for theta, turn, v in zip(root.theta, root.whole[1::2], root.x[1:-1:2], strict=True)
    ]


def lies_in_its_box(proof, exact):
    """The point is proved, and both of its numbers have narrow enclosures that hold the exact."""
    assert proof.proved
    for number, (low, high) in enumerate((proof.first, proof.second)):
        assert low < exact[number] < high, (number, low, exact[number], high)
        assert high - low < 1e-14 * abs(high)


@pytest.mark.ci
def test_a_fold_meets_grazing_of_an_oscillator_in_clearance_and_frequency():
    """Both numbers move the cam, and the frequency the speed as well."""
    axes = [{"key": "cam.clearance", "start": -0.5, "stop": -0.2, "num": 21},
            {"key": "cam.frequency", "start": 2.0, "stop": 2.3, "num": 21}]  # fmt: skip
    cam = {"kind": "oscillator", "damping": 0.1, "amplitude": 1.0, "frequency": 2.1}
    scene = {"follower": {"restitution": 0.8}, "cam": {**cam, "clearance": -0.3}}
    overrides = {"orbits.vary": axes, "orbits.curve": "grazing", "orbits.label": "P(1;1)"}
    result = orbits(load_scene(scene, {**overrides, "orbits.branches": 0}), prove=True)
    point = next(p for p in result.values.codim2 if p.kind == "fold-grazing")
    graze = point.conditions[0]

    def stop(clearance, frequency) -> Wave:
        spring, damper = 1 - frequency**2, mpf(0.1) * frequency
        share = 1 / (spring**2 + damper**2)
        return Wave(-clearance, spring * share, damper * share)

    def machines(clearance) -> Machines:
        return Machines(
            lambda w: dict(SPRUNG), lambda w: w * 30 / mp.pi, lambda w: [stop(clearance, w)]
        )

    def conditions(clearance, frequency) -> list:
        return [touching(0, stop(clearance, frequency)), with_multiplier(1)]

    touch = mpf(f"{point.orbit.root.theta[0] + graze.angle:.4g}")
    numbers = mpf(f"{point.first:.5g}"), mpf(f"{point.second:.5g}")
    exact = meeting(machines, conditions, impacts_of(point), 1, numbers, [touch])
    lies_in_its_box(point.proof, exact)
    rows, row = result.tables["codim2"], result.values.codim2.index(point)
    assert rows["proved"][row] == "yes"
    ends = [rows[f"{key}_{end}"][row] for key in ("cam.clearance", "cam.frequency")
            for end in ("low", "high")]  # fmt: skip
    assert ends == [*point.proof.first, *point.proof.second]


@pytest.mark.ci
def test_two_impacts_at_corners_in_restitution_and_nose():
    """Of P(2;1:1) at 739 rpm: at b and at c, the corners of a nose that varies."""
    axes = [{"key": "follower.restitution", "start": 0.6, "stop": 0.81, "num": 21},
            {"key": "cam.nose_radius", "start": 0.149, "stop": 0.156, "num": 21}]  # fmt: skip
    overrides = {"orbits.vary": axes, "orbits.curve": "corner-impact", "run.rpm": 739.0}
    result = orbits(load_scene(None, overrides))
    point = next(p for p in result.values.codim2 if p.kind == "double-corner-impact")
    guess = impacts_of(point)
    cam_at = arcs(nose_radius=lambda nose: nose)

    def machines(r) -> Machines:
        return Machines(
            lambda nose: {**CHAPTER, "restitution": r},
            lambda nose: mpf(739),
            lambda nose: [arc_of(cam_at(nose), theta) for theta, _ in guess],
        )

    def conditions(r, nose) -> list:
        corners = dict(zip("abcdef", cam_at(nose).breakpoints, strict=True))
        return [
            at_corner(one.impact, corners[name] + 2 * mp.pi * point.orbit.root.turn(one.impact))
            for one, name in zip(point.conditions, point.corners, strict=True)
        ]

    def arc_of(cam, theta):
        """The nose circle before the top dwell, in the turn of an impact."""
        arc = cam.arcs[1]
        return arc._replace(origin=arc.origin + 2 * mp.pi * int(theta / (2 * mp.pi)))

    numbers = mpf(f"{point.first:.5g}"), mpf(f"{point.second:.5g}")
    exact = meeting(machines, conditions, guess, 2, numbers)
    lies_in_its_box(prove(point), exact)
