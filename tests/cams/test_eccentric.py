"""`kind: eccentric`: a harmonic table without corners, whatever the sign of c."""

import random
from math import pi, ulp

import pytest
from mpmath import cos, mp, mpf
from pydantic import ValidationError

from camcli.cams.compile import build, column, corners
from camcli.cams.eccentric import EccentricCam
from camcli.cams.regions import regions
from camcli.kernel.cam_table import higher, lift, stretch_at

SHAPES = [(0.0, 0.02), (-1.0, 2.0), (-5.0, 0.5), (3.0, 1e-6), (-1 / 3, 2 / 3)]


def eccentric(base, lift_m, strobe=0.0):
    return build(EccentricCam(kind="eccentric", base=base, lift=lift_m).parts(), strobe)


def exact(base, lift_m, theta):
    """c and six derivatives by theta."""
    half = mpf(lift_m) / 2
    waves = [-half * cos(mpf(theta) + n * mp.pi / 2) for n in range(7)]
    return [mpf(base) + half + waves[0], *waves[1:]]


@pytest.mark.parametrize(("base", "lift_m"), SHAPES)
@pytest.mark.parametrize("strobe", [0.0, 217.3])
def test_the_table_is_the_formula(base, lift_m, strobe):
    cam, rng = eccentric(base, lift_m, strobe), random.Random(3)
    unit = ulp(max(abs(base), abs(base + lift_m)))
    for _ in range(200):
        theta = rng.uniform(0, 2 * pi)
        i = stretch_at(cam, theta)
        values = [*lift(cam, i, theta), *higher(cam, i, theta)]
        theirs = exact(base, lift_m, theta)
        assert abs(float(values[0] - theirs[0])) <= 4 * unit
        for n, tolerance in enumerate((1e-14, 1e-13, 1e-11, 1e-9, 1e-7, 1e-6), 1):
            assert abs(float(values[n] - theirs[n])) <= tolerance * lift_m / 2, (n, theta)


@pytest.mark.parametrize(("base", "lift_m"), SHAPES)
def test_there_are_no_corners_and_one_region(base, lift_m):
    for strobe in (0.0, 90.0):
        cam = eccentric(base, lift_m, strobe)
        assert corners(cam) == []
        assert not any(column(cam, "KICK"))
        (region,) = regions(cam)
        assert (region.name, region.begins, region.ends) == ("A1", "", "")


def test_it_closes_after_a_turn():
    cam = eccentric(-1.0, 2.0)
    for n in range(3):
        start, end = column(cam, f"START{n}")[0], column(cam, f"END{n}")[-1]
        assert abs(start - end) <= 4e-16
    assert column(cam, "START0")[0] == -1.0
    assert 1.0 <= cam.top <= 1.01


@pytest.mark.parametrize(
    ("base", "lift_m"), [(0.0, 0.0), (0.0, -1.0), (float("inf"), 1.0), (0.0, float("nan"))]
)
def test_bad_sizes_are_refused(base, lift_m):
    with pytest.raises(ValidationError):
        EccentricCam(kind="eccentric", base=base, lift=lift_m)
