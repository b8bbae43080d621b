"""Measured lift tables: the fit against laws that are known, and the bound it prints."""

from itertools import pairwise
from math import pi

import pytest

from camcli.analysis.contact_loss.detachment import detachment, first_loss_range
from camcli.cams.compile import build, column, corners
from camcli.cams.lift_fit import at, basis
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.system import Follower, System
from tests.cams.lift_tables import (
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


def interpolated(lobe, step, unit, decimals):
    """Largest error of second differences of the table, m/rad2."""
    size = unit / 10**decimals
    rows = [round(lobe.at(k * step)[0] / size) * size for k in range(round(360 / step))]
    h = step * pi / 180
    return max(
        abs((rows[k - 1] - 2 * rows[k] + rows[(k + 1) % len(rows)]) / h**2 - lobe.at(k * step)[1])
        for k in range(len(rows))
    )


CASES = [
    pytest.param(Lobe(polynomial), 1, INCH, 4, id="345-inch"),
    pytest.param(Lobe(cycloidal), 1, INCH, 4, id="cycloidal-inch"),
    pytest.param(Lobe(smooth), 1, INCH, 4, id="4567-inch"),
    pytest.param(Lobe(polynomial, 60, 40), 1, INCH, 4, id="345-dwell-inch"),
    pytest.param(Lobe(cycloidal), 0.5, 1e-3, 3, id="cycloidal-mm3"),
    pytest.param(Lobe(cycloidal), 1, 1e-3, 2, id="cycloidal-mm2"),
    pytest.param(Lobe(smooth), 5, 1e-3, 2, id="4567-5deg"),
    pytest.param(Lobe(cycloidal, 60, 40), 0.1, 1e-3, 3, id="cycloidal-tenths"),
    pytest.param(Eccentric(), 1, 1e-3, 3, id="eccentric"),
    pytest.param(Lobe(cycloidal), 1, 1e-3, 9, id="cycloidal-exact"),
]


@pytest.mark.parametrize(("lobe", "step", "unit", "decimals"), CASES)
def test_the_second_derivative_is_within_the_bound_and_the_bound_is_no_idle_one(
    tmp_path, lobe, step, unit, decimals
):
    name = {INCH: "inch", 1e-3: "mm"}[unit]
    cam = scene(tmp_path, table(lobe, step, unit, decimals), lift=name).cam
    error, _ = worst_error(cam, build(cam.parts()), lobe)
    bound = cam.accuracy.bound
    assert cam.accuracy.quantum == pytest.approx(unit * 10**-decimals, rel=1e-12)
    assert error <= bound
    assert bound <= 6 * error  # 5, and what a lucky table is better than its bound


@pytest.mark.parametrize(("law", "gain"), [(polynomial, 3.5), (cycloidal, 5), (smooth, 12)])
def test_the_default_is_much_better_than_interpolation(tmp_path, law, gain):
    """A table to 0.0001 inch: second differences are wrong by tens of percent."""
    lobe = Lobe(law)
    cam = scene(tmp_path, table(lobe, 1, INCH, 4), lift="inch").cam
    error, size = worst_error(cam, build(cam.parts()), lobe)
    naive = interpolated(lobe, 1, INCH, 4)
    assert naive > 0.15 * size
    assert error * gain < naive


def test_the_worst_error_is_estimated_near_its_phase(tmp_path):
    """The local bound holds all over the turn."""
    lobe = Lobe(polynomial)
    cam = scene(tmp_path, table(lobe, 1, INCH, 4), lift="inch").cam
    compiled = build(cam.parts())
    for k in range(720):
        error = abs(values(compiled, k / 2)[2] - lobe.at(k / 2)[1])
        assert error <= cam.errors.bounds[k // 8] + 1e-9


def test_the_rounding_shows_in_the_residual(tmp_path):
    cam = scene(tmp_path, table(Lobe(smooth), 1, INCH, 4), lift="inch").cam
    rounding = cam.accuracy.quantum / 12**0.5
    assert cam.accuracy.noise == pytest.approx(rounding, rel=0.3)
    assert 0.5 * rounding < cam.accuracy.rms < 1.1 * rounding
    assert cam.accuracy.largest < 1.5 * cam.accuracy.quantum


def test_noise_beyond_the_rounding_is_noticed(tmp_path):
    import random

    rng = random.Random(3)
    lobe, noisy = Lobe(smooth), ["deg,lift"]
    for deg in range(360):
        lift = lobe.at(deg)[0] * 1e3
        noisy.append(f"{deg},{lift + (rng.gauss(0, 0.002) if lift else 0.0):.5f}")
    cam = scene(tmp_path, "\n".join(noisy)).cam
    assert 1.4e-6 < cam.accuracy.noise < 2.8e-6
    assert worst_error(cam, build(cam.parts()), lobe)[0] <= cam.accuracy.bound


def test_a_jump_of_the_second_derivative_is_suspected(tmp_path):
    parabola = Lobe(lambda x: (2 * x * x, 4) if x < 0.5 else (1 - 2 * (1 - x) ** 2, -4))
    cam = scene(tmp_path, table(parabola, 1, 1e-3, 4)).cam
    error, _ = worst_error(cam, build(cam.parts()), parabola)
    assert cam.accuracy.jump_deg is not None
    assert error <= cam.accuracy.bound


def test_dwells_are_exactly_flat(tmp_path):
    compiled = build(scene(tmp_path, table(Lobe(cycloidal, 60, 40), 1), base=0.25).cam.parts())
    for deg in (0, 30, 60, 90, 270, 300, 359.9):
        assert values(compiled, deg) == (0.25, 0, 0)
    for deg in (170, 180, 190):
        assert values(compiled, deg) == (0.25 + 10.0 / 1000, 0, 0)


def test_the_cam_is_smooth_across_knots_stretches_and_the_turn(tmp_path):
    """Six continuous derivatives, so no corner anywhere."""
    for lobe in (Lobe(polynomial), Eccentric()):
        compiled = build(scene(tmp_path, table(lobe, 2)).cam.parts(), 33.3)
        assert corners(compiled) == []
        for order in range(3):
            ends, starts = column(compiled, f"END{order}"), column(compiled, f"START{order}")
            size = max(map(abs, starts))
            for n in range(compiled.stretches):
                assert ends[n - 1] == pytest.approx(starts[n], abs=1e-11 * size)


@pytest.mark.parametrize("strobe", [0.0, 100.0, 150.5, 180.3, 359.9])
def test_a_strobe_phase_changes_nothing(tmp_path, strobe):
    parts = scene(tmp_path, table(Lobe(polynomial), 1)).cam.parts()
    whole, cut = build(parts), build(parts, strobe)
    assert column(cut, "START")[cut.strobe] == pytest.approx(strobe * pi / 180, abs=1e-15)
    for k in range(500):
        for a, b in zip(values(whole, 0.72 * k), values(cut, 0.72 * k), strict=True):
            assert a == pytest.approx(b, rel=1e-12, abs=1e-15)


def test_the_bounds_of_the_kernel_s_table_bind(tmp_path):
    compiled = build(scene(tmp_path, table(Lobe(polynomial), 1)).cam.parts())
    low, high = column(compiled, "ACCEL_MIN"), column(compiled, "ACCEL_MAX")
    for k in range(3600):
        theta = k * pi / 1800
        i = stretch_at(compiled, theta)
        assert low[i] - 1e-12 <= lift_at(compiled, i, theta)[2] <= high[i] + 1e-12


def test_the_spline_reproduces_polynomials():
    """The eight weights of an interval sum to one, their derivatives to zero."""
    for t in (0.0, 0.25, 0.5, 1.0):
        assert sum(basis(t)) == pytest.approx(1.0, abs=1e-15)
        assert sum(basis(t, 2)) == pytest.approx(0.0, abs=1e-14)


def test_the_compiled_pieces_are_the_fitted_spline(tmp_path):
    """To rounding, in the lift and both derivatives."""
    cam = scene(tmp_path, table(Lobe(polynomial), 2)).cam
    smoother, fit, _ = cam._fitted
    compiled, knot = build(cam.parts()), 2 * pi / smoother.count
    for i in range(smoother.count):
        for t in (0.125, 0.5, 0.875):
            theta = (i + t) * knot
            found = lift_at(compiled, stretch_at(compiled, theta), theta)
            for order in range(3):
                expected = at(fit.coefficients, i, basis(t, order)) / knot**order
                assert found[order] == pytest.approx(expected, abs=1e-16 / knot**order)


def same(a, b, tolerance=1e-12):
    """Two cams alike."""
    one, two = build(a.parts()), build(b.parts())
    for k in range(360):
        for x, y in zip(values(one, k + 0.5), values(two, k + 0.5), strict=True):
            assert x == pytest.approx(y, abs=tolerance)


def test_every_way_to_write_a_table_means_the_same(tmp_path):
    text = table(Lobe(cycloidal), 1)
    plain = scene(tmp_path, text).cam
    assert len(plain.sha256 or "") == 64
    same(plain, scene(tmp_path, "\ufeff# measured\r\n" + text.replace("\n", "\r\n")).cam)
    same(plain, scene(tmp_path, text.replace(",", ";")).cam)
    same(plain, scene(tmp_path, text.replace(",", " \t ")).cam)
    same(plain, scene(tmp_path, text.replace("\n", " # a comment\n\n")).cam)
    body = text.partition("\n")[2]
    same(plain, scene(tmp_path, body, header="false", angle_column=1, lift_column=2).cam)
    swapped = "\n".join(",".join([*line.split(",")[::-1], "7"]) for line in body.splitlines())
    same(plain, scene(tmp_path, swapped, header="false", angle_column=2, lift_column=1).cam)


def test_units_angles_and_directions(tmp_path):
    lobe = Lobe(polynomial)
    plain = scene(tmp_path, table(lobe, 1)).cam
    rows = [line.split(",") for line in table(lobe, 1).splitlines()[1:]]
    crank = "deg,lift\n" + "".join(f"{2 * float(a):g},{b}\n" for a, b in rows)
    same(plain, scene(tmp_path, crank, angle="crank").cam)
    metres = "deg,lift\n" + "".join(f"{a},{float(b) / 1000:.7f}\n" for a, b in rows)
    same(plain, scene(tmp_path, metres, lift="m").cam)
    share = "deg,lift\n" + "".join(f"{a},{float(b) / 10:.5f}\n" for a, b in rows)
    same(plain, scene(tmp_path, share, lift="fraction", max_lift=0.01).cam)
    same(plain, scene(tmp_path, share, lift="mm", rocker_ratio=10).cam)
    shifted = "deg,lift\n" + "".join(f"{float(a) - 200:g},{b}\n" for a, b in rows)
    same(plain, scene(tmp_path, shifted, zero_deg=200).cam)
    mirrored = build(scene(tmp_path, table(lobe, 1), direction="reversed", zero_deg=30).cam.parts())
    for deg in (120.0, 150.25, 200.0, 233.0):
        assert values(mirrored, (30 - deg) % 360)[0] == pytest.approx(lobe.at(deg)[0], abs=2e-7)


def test_a_table_of_the_lobe_alone(tmp_path):
    lobe = Lobe(cycloidal)
    whole = scene(tmp_path, table(lobe, 1)).cam
    same(whole, scene(tmp_path, table(lobe, 1, low=105, high=256)).cam, 1e-6)
    closed = table(lobe, 1) + "360,0.0000\n"
    same(whole, scene(tmp_path, closed).cam)


def test_a_stated_smoothing_is_the_rms_deviation(tmp_path):
    text = table(Lobe(cycloidal), 1, 1e-3, 3)
    for wanted in (2e-7, 5e-7, 2e-6, 1e-5):
        cam = scene(tmp_path, text, smoothing=wanted).cam
        assert cam.accuracy.rms == pytest.approx(wanted, rel=0.02)


def test_the_first_detachment_lies_in_its_range(tmp_path):
    """The true law's speed is between those that the bound allows."""
    follower = Follower(0.12, 42000.0, 12.0, 0.0, 260.0, 0.4)
    for law in (polynomial, smooth):
        lobe = Lobe(law)
        exact = scene(tmp_path, table(lobe, 0.5, 1e-3, 12)).cam
        truth = detachment(System.build(follower, exact.parts())).first.rpm
        cam = scene(tmp_path, table(lobe, 1, INCH, 4), lift="inch").cam
        system = System.build(follower, cam.parts())
        low, high = first_loss_range(system, cam.errors.bounds)
        assert low < truth < high
        assert low < detachment(system).first.rpm < high
        assert high - low < 0.2 * truth


def test_large_tables_keep_the_kernel_s_table_small(tmp_path):
    text = table(Lobe(cycloidal), 0.072, 1e-3, 4)
    parts = scene(tmp_path, text).cam.parts()
    assert len(text.splitlines()) == 5001
    assert sum(len(part.pieces) for part in parts) < 720


def test_the_kernel_s_pieces_are_those_of_one_stretch(tmp_path):
    """Equal pieces, each joined to the next."""
    for part in scene(tmp_path, table(Eccentric(), 1)).cam.parts():
        edges = part.edges()
        width = edges[1] - edges[0]
        for (a, b), piece in zip(pairwise(edges), part.pieces, strict=True):
            assert b - a == pytest.approx(width, rel=1e-11)
            assert piece.center == pytest.approx((a + b) / 2, abs=1e-15)
