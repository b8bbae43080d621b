"""`kind: law` and `kind: eccentric`: handbooks, joints, the compiled table against closed forms."""

import random
from fractions import Fraction
from itertools import pairwise
from math import pi, ulp
from typing import get_args

import pytest
from flint import arb
from mpmath import cos, mp, mpf
from pydantic import ValidationError

from camcli.cams.balls import precision
from camcli.cams.compile import Part, _without_slivers, build, column, corners, phase_of
from camcli.cams.eccentric import EccentricCam
from camcli.cams.law import POLYNOMIALS, LawCam, LawName
from camcli.cams.regions import corner_list
from camcli.kernel.cam_table import higher, lift, lift_at, stretch_at
from tests.support.law_oracle import LAWS, OWN, OWN_LAW

BASE, LIFT = -0.013, 0.05  # m
RISE, DWELL, FALL = 100.0, 40.0, 120.0  # deg
EVERY = {**LAWS, "scca": OWN_LAW}
SCCA = {"scca": OWN}


def test_every_law_has_its_oracle_and_rises_by_one():
    assert {*get_args(LawName)} == {*LAWS}
    assert all(sum(map(Fraction, terms.values())) == 1 for terms in POLYNOMIALS.values())


CORNERS = {  # deg after the start of the rise
    "constant-velocity": [0, 100, 140, 260],
    "constant-acceleration": [0, 50, 100, 140, 200, 260],
    "harmonic": [0, 100, 140, 260],
}
PEAKS = {  # largest velocity and acceleration, in h/beta and h/beta^2
    "constant-acceleration": (2, 4),
    "harmonic": (1.5708, 4.9348),
    "cycloidal": (2, 6.2832),
    "3-4-5": (1.875, 5.7735),
    "4-5-6-7": (2.1875, 7.5132),
    "modified-trapezoid": (2, 4.88812),
    "modified-sine": (1.75960, 5.52796),
}


def law_cam(law="cycloidal", falls=None, start=60.0, **changes):
    """A cam with the lengths above; `changes` replace its fields."""
    motions = {
        "rise": {"start_deg": start, "length_deg": RISE, "law": law},
        "fall": {"length_deg": FALL, "law": falls or law},
    }
    fields = {"base": BASE, "lift": LIFT, "top_dwell_deg": DWELL, **motions, **changes}
    return LawCam(kind="law", **fields)


def table(name, start=60.0):
    """The compiled cam of a law by its name, `scca` for widths of its own."""
    return build(law_cam(SCCA if name == "scca" else name, start=start))


def exact(name, theta, start=60.0, side=1):
    """c and its six derivatives by theta (rad), from the oracle."""
    law, x = EVERY[name], (mpf(theta) * 180 / mp.pi - mpf(start)) % 360
    if side < 0 and x < mpf(10) ** -9:
        x += 360  # the end of the base dwell
    for low, length, up in ((0, RISE, 1), (RISE + DWELL, FALL, -1)):
        share = (x - low) / mpf(length)
        if 0 <= share < 1 or (side < 0 and 0 < share <= 1):
            beta = mpf(length) * mp.pi / 180
            values = [law.derivative(share, n, side) / beta**n for n in range(7)]
            level = BASE if up > 0 else mpf(BASE) + mpf(LIFT)
            return [mpf(level) + up * LIFT * values[0], *(up * LIFT * v for v in values[1:])]
    top = RISE <= x <= RISE + DWELL
    return [mpf(BASE) + (mpf(LIFT) if top else 0)] + [mpf(0)] * 6


def sizes(name):
    """Largest |derivative| of each order: what errors are measured by."""
    law = EVERY[name]
    beta = mpf(RISE) * mp.pi / 180
    grid = [mpf(k) / 64 for k in range(1, 64)]
    return [
        LIFT * float(max(abs(law.derivative(x, n)) for x in grid) / beta**n) or 1.0
        for n in range(7)
    ]


@pytest.mark.parametrize("name", PEAKS)
def test_peak_velocity_and_acceleration_are_those_of_the_handbooks(name):
    cam, beta = table(name), RISE * pi / 180
    start = column(cam, "start")[1]
    rows = [start + beta * k / 1500 for k in range(1501)]
    values = [lift_at(cam, stretch_at(cam, theta), theta) for theta in rows]
    velocity = max(abs(v[1]) for v in values) * beta / LIFT
    acceleration = max(abs(v[2]) for v in values) * beta**2 / LIFT
    assert velocity == pytest.approx(PEAKS[name][0], rel=4e-5)
    assert acceleration == pytest.approx(PEAKS[name][1], rel=1e-5)
    peak = PEAKS[name][1] * LIFT / beta**2  # the bounds hold and are not idle
    assert peak * 0.9999 <= max(column(cam, "accel_max")) <= peak * 1.05
    assert BASE + LIFT <= cam.top <= BASE + LIFT * 1.005


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("start", [300.0, -47.25])
def test_the_table_is_the_formula_to_a_few_roundings(name, start):
    """c to 4 ulp of its size, c' to 1e-14, c'' to 1e-13, the 3rd to the 6th to 1e-11 .. 1e-6."""
    cam, size, rng = table(name, start), sizes(name), random.Random(7)
    unit = ulp(max(abs(BASE), abs(BASE + LIFT)))
    tolerances = [4 * unit, *(t * s for t, s in zip((1e-14, 1e-13), size[1:3], strict=True))]
    tolerances += [t * s for t, s in zip((1e-11, 1e-9, 1e-7, 1e-6), size[3:], strict=True)]
    starts = column(cam, "start")
    for _ in range(60):
        theta = rng.uniform(0, 2 * pi)
        i = stretch_at(cam, theta)
        assert min(abs(theta - joint) for joint in starts) > 1e-12
        values = [*lift(cam, i, theta), *higher(cam, i, theta)]
        for n, (ours, theirs) in enumerate(zip(values, exact(name, theta, start), strict=True)):
            assert abs(float(ours - theirs)) <= tolerances[n], (theta, n)


@pytest.mark.parametrize("name", EVERY)
def test_the_values_at_joints_are_one_sided(name):
    """Every zone of a law is cut exactly; there each side has its own derivatives."""
    cam, size, law = table(name), sizes(name), EVERY[name]
    starts = column(cam, "start")
    joints = [60 + RISE * x for x in law.joints] + [200 + FALL * x for x in law.joints]
    assert starts == pytest.approx([0.0, *(float(x) * pi / 180 for x in joints)], abs=1e-15)
    for k, degrees in enumerate(joints, 1):
        for side, prefix, row in ((1, "start_c", k), (-1, "end_c", k - 1)):
            theirs = exact(name, mpf(degrees) * mp.pi / 180 + mpf(10) ** -25 * side, side=side)
            for n in range(3):
                ours = column(cam, f"{prefix}{n or ''}")[row]
                assert abs(ours - float(theirs[n])) <= 1e-13 * max(size[n], 0.05), (degrees, n)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("start", [60.0, 300.0])
def test_corners_are_where_the_law_has_them(name, start):
    cam = table(name, start)
    found = [column(cam, "start")[n] * 180 / pi for n in corners(cam)]
    expected = sorted((x + start) % 360 for x in CORNERS.get(name, []))
    assert found == pytest.approx(expected, abs=1e-12)
    assert [corner.name for corner in corner_list(cam)] == list("abcdef")[: len(expected)]


def test_only_constant_velocity_has_kinks_and_it_has_no_acceleration_at_all():
    for name in EVERY:
        kicks = [k for k in column(table(name), "slope_jump") if k]
        if name == "constant-velocity":
            up, down = LIFT / (RISE * pi / 180), LIFT / (FALL * pi / 180)
            assert kicks == pytest.approx([up, -up, -down, down], rel=1e-15)
        else:
            assert kicks == []
    ramp = table("constant-velocity")
    assert set(column(ramp, "accel_max")) == set(column(ramp, "accel_min")) == {0.0}
    assert column(ramp, "piece_count") == [1.0] * 5


@pytest.mark.parametrize(
    ("lengths", "count"),
    [
        ((100.1, 0.0, 259.9), 3),  # 360 as written, less in doubles
        ((120.0, 120.0, 120.0), 4),
        ((0.1, 359.8, 0.1), 4),
        ((100.1, 0.0, 259.9 + 8e-10), 3),  # more than a turn by less than is allowed
    ],
)
def test_a_lobe_may_take_the_whole_turn(lengths, count):
    """Sums are those of the written decimals; without a base dwell there is no part for it."""
    rise, dwell, fall = lengths
    motion = {"start_deg": 10.0, "length_deg": rise, "law": "4-5-6-7"}
    cam = law_cam(rise=motion, top_dwell_deg=dwell, fall={"length_deg": fall, "law": "3-4-5"})
    with precision(40):
        parts = cam.parts()
    assert len(parts) == len(build(cam).stretches) == count
    assert (parts[0].start, float(parts[-1].end)) == (0, 2 * pi)
    assert all(a.end.overlaps(b.start) for a, b in pairwise(parts))


@pytest.mark.parametrize(
    ("changes", "amount"),
    [
        ({"top_dwell_deg": 140.5}, r"360\.5 deg, 0\.5 deg too much"),
        ({"top_dwell_deg": 140.00001}, "1e-05 deg too much"),
        ({"fall": {"length_deg": 0.0, "law": "harmonic"}}, "0.000001"),
        ({"lift": 0.0}, "greater than 0"),
        ({"base": float("nan")}, "finite"),
        ({"rise": {"start_deg": 400, "length_deg": 90, "law": "3-4-5"}}, "360"),
        ({"rise": {"start_deg": 0, "length_deg": 90, "law": "3-5"}}, "cycloidal"),
    ],
)
def test_lengths_that_do_not_fit_are_refused_with_the_amount(changes, amount):
    with pytest.raises(ValidationError, match=amount):
        law_cam(**changes)


@pytest.mark.parametrize(("base", "lift_m"), [(-1.0, 2.0), (3.0, 1e-6), (-1 / 3, 2 / 3)])
@pytest.mark.parametrize("strobe", [0.0, 217.3])
def test_an_eccentric_is_a_cosine_without_corners(base, lift_m, strobe):
    cam = build(EccentricCam(kind="eccentric", base=base, lift=lift_m), phase_of(strobe))
    rng, unit = random.Random(3), ulp(max(abs(base), abs(base + lift_m)))
    half = mpf(lift_m) / 2
    for _ in range(100):
        theta = rng.uniform(0, 2 * pi)
        i = stretch_at(cam, theta)
        values = [*lift(cam, i, theta), *higher(cam, i, theta)]
        waves = [-half * cos(mpf(theta) + n * mp.pi / 2) for n in range(7)]
        assert abs(float(values[0] - (mpf(base) + half + waves[0]))) <= 4 * unit
        for n, tolerance in enumerate((1e-14, 1e-13, 1e-11, 1e-9, 1e-7, 1e-6), 1):
            assert abs(float(values[n] - waves[n])) <= tolerance * lift_m / 2, (n, theta)
    assert corners(cam) == []
    assert not any(column(cam, "slope_jump"))
    for n in range(3):  # it closes after a turn
        start, end = (column(cam, f"{side}_c{n or ''}") for side in ("start", "end"))
        assert abs(start[0] - end[-1]) <= 4 * unit


def test_a_part_that_is_too_short_is_left_to_the_one_before_it():
    """Parts of 5e-13 rad in the middle and at the end of a turn; the first is there at least."""
    sliver = 5e-13
    ends = [0.0, 1.0, 1.0 + sliver, 4.0, 2.0 * pi - sliver, 2.0 * pi]
    parts = [Part(arb(a), arb(b), None) for a, b in pairwise(ends)]
    cuts = _without_slivers(parts)
    assert [cut.part for cut in cuts] == [parts[0], parts[2], parts[3]]
    wanted = [(0.0, 1.0 + sliver), (1.0 + sliver, 4.0), (4.0, 2.0 * pi)]
    assert [(cut.low, cut.high) for cut in cuts] == wanted
