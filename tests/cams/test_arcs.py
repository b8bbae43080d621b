"""The compiled table of the arcs cam against its closed form in many digits."""

import random
from fractions import Fraction
from math import factorial, log2, nextafter, pi, ulp

import pytest
from mpmath import mp
from pydantic import ValidationError

from camcli.cams.arcs import ArcsCam
from camcli.cams.compile import TAYLOR_ERROR, _radius, column
from camcli.kernel.cam_table import derivative, lift, stretch_at
from tests.support.kernel_runs import GEOMETRY, ORACLE_CAM, cam

CAM = cam()
CORNERS = [float(x) for x in ORACLE_CAM.breakpoints]
SEPARATE = 1e-15  # rad: closer to a corner the exact and the rounded corner may lie between


def angles(count):
    """Random angles of the turn, a third of them close to a corner."""
    rng = random.Random(20)
    anywhere = [rng.uniform(0, 2 * pi) for _ in range(count)]
    signs = [rng.choice([-1, 1]) * 10 ** rng.uniform(-14, -2) for _ in range(count // 2)]
    return anywhere + [rng.choice(CORNERS) + s for s in signs] + [0.0, nextafter(2 * pi, 0)]


def test_lift_to_a_few_ulp_slope_and_curvature_to_thirteen_digits_of_their_size():
    worst = [0.0, 0.0, 0.0]
    for theta in angles(800):
        if min(abs(theta - corner) for corner in ORACLE_CAM.breakpoints) < SEPARATE:
            continue
        exact = ORACLE_CAM.laws(theta)
        ours = lift(CAM, stretch_at(CAM, theta), theta)
        sizes = ulp(float(exact[0])), 0.2747, 1.87
        for n in range(3):
            worst[n] = max(worst[n], abs(float(ours[n] - exact[n])) / sizes[n])
    assert worst[0] <= 4.0
    assert max(worst[1:]) <= 1e-13


def test_every_bound_of_the_table_binds_and_is_not_idle():
    """c, its slope and its 2nd to 7th derivative, sampled with mpmath's own derivatives."""
    names = ["c_min", "slope_min", "accel_min", "accel_max", "jerk_max", "snap_max", "radius"]
    low, slope, least, most, jerk, snap, radius = (column(CAM, name) for name in names)
    for i, (start, end) in enumerate(zip(column(CAM, "start"), column(CAM, "end"), strict=True)):
        for k in range(21):
            theta = start + (end - start) * (0.002 + 0.996 * k / 20)
            with mp.workdps(60):
                d3, d4, d7 = (mp.diff(ORACLE_CAM.c2, theta, n) for n in (1, 2, 5))
            c, c1, c2 = (float(x) for x in ORACLE_CAM.laws(theta))
            assert low[i] <= c + 1e-16
            assert c <= CAM.top * (1 + 1e-15)
            assert slope[i] <= c1 + 1e-16
            assert least[i] <= c2 + 1e-15
            assert c2 - 1e-15 <= most[i]
            assert abs(d3) <= jerk[i] + 1e-12
            assert abs(d4) <= snap[i] + 1e-12
            assert derivative(CAM, 3, i, theta) == pytest.approx(float(d3), rel=1e-10, abs=1e-11)
            # within the radius the slope's series of six terms is exact to a rounding of 0.27
            assert abs(d7) * radius[i] ** 6 / factorial(6) <= 2e-17
    assert CAM.top == pytest.approx(0.25393320723821, rel=1e-4)
    assert min(least) == pytest.approx(-1.869212582774405, rel=1e-2)
    assert max(most) == pytest.approx(0.3415971000285428, rel=1e-2)


@pytest.mark.parametrize(
    ("change", "amount"),
    [
        ({"base_radius": 0.41}, "-0.01"),
        ({"base_radius": 0.4 + 2e-9}, "-2e-09"),
        ({"nose_radius": 0.9}, "0.05"),
        ({"nose_center": 0.2}, "0.05"),
        ({"nose_center": 1.2}, "0.05"),
        ({"top_dwell_deg": 221.0}, "1 deg"),
        ({"offset": float("nan")}, "finite"),
        ({"flank_center": float("inf")}, "finite|less"),
    ],
)
def test_circles_that_do_not_close_are_refused_with_the_amount(change, amount):
    with pytest.raises(ValidationError, match=amount):
        ArcsCam(kind="arcs", **{**GEOMETRY, **change})


def test_flanks_noses_and_top_dwell_may_fill_the_turn():
    """Then there is no dwell on the base circle. Angles are those of the triangle of centres."""
    usual = {"base_radius": 0.5, "flank_center": 0.5, "flank_radius": 1.0, "nose_center": 0.5,
             "nose_radius": 0.25, "offset": 0.0}  # fmt: skip
    flanks = float(2 * (180 - mp.degrees(mp.acos(-mp.mpf(1) / 8))))  # of sides 1/2, 1/2, 3/4
    whole = ArcsCam(kind="arcs", **usual, top_dwell_deg=360.0 - flanks)
    assert flanks + whole.top_dwell_deg == 360.0
    with pytest.raises(ValidationError, match="1e-08 deg too much"):
        ArcsCam(kind="arcs", **usual, top_dwell_deg=360.0 - flanks + 1e-8)


@pytest.mark.parametrize("seventh", [1e-6, 1.0, 12345.6, 1e9, 1e300])
def test_the_radius_of_a_series_is_the_largest_power_of_two_that_its_error_allows(seventh):
    """max|c^(7)| s^6/720 <= TAYLOR_ERROR, s at most 1/16 rad."""
    radius = _radius(seventh)
    exponent = log2(radius)
    assert exponent == int(exponent) <= -4
    assert seventh * radius**6 <= 720.0 * TAYLOR_ERROR
    assert radius == 1.0 / 16.0 or seventh * (2.0 * radius) ** 6 > 720.0 * TAYLOR_ERROR


@pytest.mark.parametrize(
    ("changes", "said"),
    [  # all numbers are doubles without rounding
        ({"nose_radius": 1.0}, "nose_radius is 0 m too large: it must be smaller"),
        ({"nose_center": 0.25}, "they miss by 0 m"),
        ({"nose_center": 1.25}, "they overlap by 0 m"),
        ({"nose_center": 0.25, "flank_radius": 1.0 - 2.0**-31}, "the nose does not rise above"),
        ({"flank_radius": 1.0 + 1e-4}, "the flank circle misses the base circle by"),
    ],
)
def test_circles_at_the_limit_of_what_makes_a_cam_are_none(changes, said):
    """Base 0.5, flank circle of 1 about 0.5, nose circle of 0.25: centres 0.75 apart."""
    usual = {"base_radius": 0.5, "flank_center": 0.5, "flank_radius": 1.0, "nose_center": 0.5,
             "nose_radius": 0.25, "top_dwell_deg": 10.0}  # fmt: skip
    assert ArcsCam(kind="arcs", **usual).nose_center == 0.5
    with pytest.raises(ValidationError, match=said):
        ArcsCam(kind="arcs", **{**usual, **changes})


def test_by_how_much_the_closed_flank_circle_is_larger_is_told_exactly():
    """0.4 + 0.45 less 0.85, of which the sum in doubles would be another double."""
    geometry = {**GEOMETRY, "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85}
    exact = Fraction(0.4) + Fraction(0.45) - Fraction(0.85)
    assert float(exact) != 0.4 + 0.45 - 0.85
    assert ArcsCam(kind="arcs", **geometry).flank_excess == float(exact)
