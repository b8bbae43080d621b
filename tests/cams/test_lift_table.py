"""Measured lift tables: the fit against laws that are known, and the bound it prints."""

import random
from math import pi

import numpy as np
import pytest

from camcli.analysis.contact_loss.detachment import detachment
from camcli.api.lift_table import table_record
from camcli.cams.compile import build, column, corners, phase_of
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.system import Follower, System
from tests.support.lift_tables import (
    Eccentric,
    Lobe,
    cycloidal,
    polynomial,
    scene,
    smooth,
    table,
    worst_error,
)

INCH = 0.0254


def values(cam, deg):
    """(c, c_theta, c_thetatheta) of a compiled cam."""
    theta = deg * pi / 180
    return lift_at(cam, stretch_at(cam, theta), theta)


CASES = [
    pytest.param(Lobe(polynomial), 1, INCH, 4, id="345-inch"),
    pytest.param(Lobe(smooth), 1, INCH, 4, id="4567-inch"),
    pytest.param(Lobe(cycloidal), 0.5, 1e-3, 3, id="cycloidal-mm3"),
    pytest.param(Lobe(cycloidal), 1, 1e-3, 2, id="cycloidal-mm2"),
    pytest.param(Lobe(smooth), 5, 1e-3, 2, id="4567-5deg"),
    pytest.param(Lobe(cycloidal, 60, 40), 0.1, 1e-3, 3, id="cycloidal-tenths"),
    pytest.param(Eccentric(), 2, 1e-3, 3, id="eccentric"),
    pytest.param(Lobe(cycloidal), 1, 1e-3, 9, id="cycloidal-exact"),
]


@pytest.mark.parametrize(("lobe", "step", "unit", "decimals"), CASES)
def test_the_second_derivative_is_within_the_bound_and_the_bound_is_no_idle_one(
    tmp_path, lobe, step, unit, decimals
):
    name = {INCH: "inch", 1e-3: "mm"}[unit]
    cam = scene(tmp_path, table(lobe, step, unit, decimals), lift=name).cam
    compiled = build(cam)
    error, size = worst_error(cam, compiled, lobe)
    bound = cam.accuracy.bound
    assert cam.accuracy.quantum == pytest.approx(unit * 10**-decimals, rel=1e-12)
    assert error <= bound
    assert bound <= 6 * error or bound < 0.2 * size  # a lucky table is better than its bound


@pytest.mark.parametrize(("lobe", "step"), [(Lobe(smooth), 5), (Eccentric(), 2)])
def test_the_third_derivative_is_within_the_bound_and_the_bound_is_no_idle_one(
    tmp_path, lobe, step
):
    """Both by differences of c_thetatheta, of laws whose third derivative has no jump."""
    cam = scene(tmp_path, table(lobe, step, 1e-3, 3)).cam
    compiled = build(cam)
    apart = 0.1  # deg, to either side
    ends = np.arange(0.0, 360.0, 1.0)[:, None] + (-apart, apart)
    truth = np.diff([[lobe.at(deg)[1] for deg in pair] for pair in ends])
    found = np.diff([[values(compiled, deg % 360.0)[2] for deg in pair] for pair in ends])
    error, size = (np.abs(x).max() / (2.0 * apart * pi / 180) for x in (found - truth, truth))
    bound = max(cam.errors.jerk.bounds)
    assert error <= bound
    assert bound <= 10 * error or bound < 0.2 * size


def test_rounding_noise_and_jumps_are_noticed(tmp_path):
    cam = scene(tmp_path, table(Lobe(smooth), 1, INCH, 4), lift="inch").cam
    rounding = cam.accuracy.quantum / 12**0.5
    assert cam.accuracy.noise == pytest.approx(rounding, rel=0.3)
    assert 0.5 * rounding < cam.accuracy.rms < 1.1 * rounding
    assert cam.accuracy.largest < 1.5 * cam.accuracy.quantum

    rng, lobe, noisy = random.Random(3), Lobe(smooth), ["deg,lift"]
    for deg in range(360):
        lift = lobe.at(deg)[0] * 1e3
        noisy.append(f"{deg},{lift + (rng.gauss(0, 0.002) if lift else 0.0):.5f}")
    cam = scene(tmp_path, "\n".join(noisy)).cam
    assert 1.4e-6 < cam.accuracy.noise < 2.8e-6
    assert worst_error(cam, build(cam), lobe)[0] <= cam.accuracy.bound
    assert cam.accuracy.jump_deg is None

    parabola = Lobe(lambda x: (2 * x * x, 4) if x < 0.5 else (1 - 2 * (1 - x) ** 2, -4))
    cam = scene(tmp_path, table(parabola, 1, 1e-3, 4)).cam
    assert cam.accuracy.jump_deg is not None
    assert worst_error(cam, build(cam), parabola)[0] <= cam.accuracy.bound


def test_dwells_are_exactly_flat(tmp_path):
    compiled = build(scene(tmp_path, table(Lobe(cycloidal, 60, 40), 1), base=0.25).cam)
    for deg in (0, 30, 60, 90, 270, 300, 359.9):
        assert values(compiled, deg) == (0.25, 0, 0)
    for deg in (170, 180, 190):
        assert values(compiled, deg) == (0.25 + 10.0 / 1000, 0, 0)


@pytest.mark.parametrize("lobe", [Lobe(polynomial), Eccentric()])
@pytest.mark.parametrize("strobe", [33.3, 180.3])
def test_the_cam_is_smooth_and_a_strobe_phase_changes_nothing(tmp_path, lobe, strobe):
    """Six continuous derivatives, so no corner anywhere; the table's bounds bind."""
    cam = scene(tmp_path, table(lobe, 2)).cam
    assert sum(len(part.pieces) for part in cam.parts()) <= 180
    whole, cut = build(cam), build(cam, phase_of(strobe))
    assert corners(cut) == []
    for order in range(3):
        ends, starts = (column(cut, f"{side}_c{order or ''}") for side in ("end", "start"))
        size = max(map(abs, starts))
        assert [ends[-1], *ends[:-1]] == pytest.approx(starts, abs=1e-11 * size)
    assert column(cut, "start")[cut.strobe] == pytest.approx(strobe * pi / 180, abs=1e-15)
    low, high = column(cut, "accel_min"), column(cut, "accel_max")
    for k in range(500):
        theta = 0.72 * k * pi / 180
        i = stretch_at(cut, theta)
        ours = lift_at(cut, i, theta)
        assert ours == pytest.approx(values(whole, 0.72 * k), rel=1e-12, abs=1e-15)
        assert low[i] - 1e-12 <= ours[2] <= high[i] + 1e-12


def same(a, b, tolerance=1e-12):
    """Two cams alike."""
    one, two = build(a), build(b)
    for k in range(120):
        assert values(one, 3 * k + 0.5) == pytest.approx(values(two, 3 * k + 0.5), abs=tolerance)


@pytest.mark.ci
def test_units_angles_and_directions(tmp_path):
    lobe = Lobe(polynomial)
    plain = scene(tmp_path, table(lobe, 2)).cam
    rows = [line.split(",") for line in table(lobe, 2).splitlines()[1:]]

    def written(turned, scaled, **changes):
        lines = (f"{turned(float(a)):g},{scaled(b)}\n" for a, b in rows)
        same(plain, scene(tmp_path, "deg,lift\n" + "".join(lines), **changes).cam)

    written(lambda a: 2 * a, str, angle="crank")
    falling = [f"{a},{b}\n" for a, b in rows[::-1]]
    for first in (0, 60, 170):  # the rows begin elsewhere, so that the angle falls through zero
        text = "deg,lift\n" + "".join(falling[first:] + falling[:first])
        same(plain, scene(tmp_path, text).cam)
    written(lambda a: a - 200, str, zero_deg=200)
    written(lambda a: a, lambda b: f"{float(b) / 1000:.7f}", lift="m")
    written(lambda a: a, lambda b: f"{float(b) / 10:.5f}", lift="fraction", max_lift=0.01)
    written(lambda a: a, lambda b: f"{float(b) / 10:.5f}", rocker_ratio=10)
    written(lambda a: a, str, rocker_ratio=10, measured_at="valve")
    written(lambda a: a, lambda b: f"{float(b) * 1000:.1f}", lift="um")
    written(lambda a: a, lambda b: f"{float(b) / 0.0254:.12f}", lift="thou")
    written(lambda a: a, lambda b: f"{float(b) + 18:.4f}", subtract=18)
    mirrored = build(scene(tmp_path, table(lobe, 1), direction="reversed", zero_deg=30).cam)
    for deg in (120.0, 150.25, 200.0, 233.0):
        assert values(mirrored, (30 - deg) % 360)[0] == pytest.approx(lobe.at(deg)[0], abs=2e-7)


@pytest.mark.parametrize("wanted", [5e-7, 2e-6, 1e-5])
def test_a_stated_smoothing_is_the_rms_deviation(tmp_path, wanted):
    cam = scene(tmp_path, table(Lobe(cycloidal), 2, 1e-3, 3), smoothing=wanted).cam
    assert cam.accuracy.rms == pytest.approx(wanted, rel=0.02)


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "decimals"),
    [
        pytest.param(polynomial, 2, marks=pytest.mark.soak),
        pytest.param(cycloidal, 3, marks=pytest.mark.soak),
        (smooth, 2),
    ],
)
def test_the_first_detachment_lies_in_its_range_of_some_three_errors(tmp_path, law, decimals):
    """True errors are those of a law measured with its phase shifted; 12 tables tell 3 from 5."""
    follower, lobe = Follower(0.12, 42000.0, 12.0, 0.0, 260.0, 0.4), Lobe(law, 60, 40)
    exact = scene(tmp_path, table(lobe, 0.5, 1e-3, 12)).cam
    truth = detachment(System.build(follower, exact)).first.rpm
    errors, widths = [], []
    for k in range(12):
        cam = scene(tmp_path, table(lobe, 2, 1e-3, decimals, low=k / 6)).cam
        system = System.build(follower, cam)
        low, high = table_record(cam, system)["first_detachment_rpm"]
        found = detachment(system).first.rpm
        assert low < truth < high
        assert low < found < high
        errors.append(found - truth)
        widths.append((high - low) / 2)
    assert np.mean(widths) < 4.2 * np.sqrt(np.mean(np.square(errors)))


def test_a_factor_on_the_lift_is_one_on_the_cam_and_on_its_error(tmp_path):
    text = table(Lobe(cycloidal), 1, 1e-3, 3)
    cams = [scene(tmp_path, text, lift="mm", lift_scale=scale).cam for scale in (1.0, 1.25)]
    one, other = map(build, cams)
    for deg in (100.0, 150.0, 180.0, 200.0, 270.0):
        for own, scaled in zip(values(one, deg), values(other, deg), strict=True):
            assert scaled == pytest.approx(1.25 * own, rel=1e-9, abs=1e-9)
    assert cams[1].accuracy.bound == pytest.approx(1.25 * cams[0].accuracy.bound, rel=1e-6)
