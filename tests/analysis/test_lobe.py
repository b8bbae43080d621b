"""The cam sheet: jerk, the lobe under a knife edge, a roller and a flat face, and its outline."""

from dataclasses import replace
from math import asin, degrees, pi, radians, sin

import numpy as np
import pytest

import camcli
from camcli.errors import SceneError
from camcli.quantities import MILLIMETRES
from camcli.words.simulate import closing_words
from tests.support.law_oracle import LAWS
from tests.support.lift_tables import scene as table_scene
from tests.support.machines import CHAPTER, ECCENTRIC, TABLE, VALVE

CIRCLES = {  # of the default cam: centre's direction (deg) and distance, radius; by the corners
    (90.0, 150.1793714951576): (270.0, 0.45, 0.85),
    (150.1793714951576, 160.0): (160.0, 0.40393320723821, 0.15),
    (160.0, 200.0): (0.0, 0.0, 0.55393320723821),
    (200.0, 209.8206285048424): (200.0, 0.40393320723821, 0.15),
    (209.8206285048424, 270.0): (90.0, 0.45, 0.85),
}


def sheet(machine, face, base, roller=None, **values):
    """The result of the cam sheet of a machine."""
    contact = {"face": face, "base_radius": base, "follower_radius": roller}
    return camcli.simulate(machine.load({"contact": contact, **values}), profile_only=True)


def inside(theta, ends):
    return (theta > ends[0] + 1e-9) & (theta < ends[1] - 1e-9)


@pytest.mark.parametrize("roller", [0.0, 0.06])
def test_the_lobe_of_circular_arcs_is_made_of_circles(roller):
    """The pitch curve is the default cam; a roller takes its radius off every circle."""
    face = "roller" if roller else "knife"
    result = sheet(CHAPTER, face, 0.4 - roller, roller or None)
    profile, outline = result.tables["profile"], result.tables["outline"]
    theta, x, y = (outline[name] for name in ("theta_deg", "x_m", "y_m"))
    for ends, (direction, distance, radius) in CIRCLES.items():
        own = inside(theta, ends)
        centre = distance * np.sin(np.radians(direction)), distance * np.cos(np.radians(direction))
        assert np.hypot(x[own] - centre[0], y[own] - centre[1]) == pytest.approx(
            radius - roller, abs=1e-14
        )
        assert profile["lobe_radius_m"][own] == pytest.approx(radius - roller, rel=1e-9)
        # sine rule in the triangle of axis, centre and roller
        wanted = np.arcsin(distance / radius * np.sin(np.radians(theta[own] - direction)))
        assert np.radians(profile["pressure_angle_deg"][own]) == pytest.approx(-wanted, abs=1e-13)
    base = (theta < 89.0) | (theta > 271.0)
    assert np.hypot(x[base], y[base]) == pytest.approx(0.4 - roller, abs=1e-15)
    lobe = result.summary["lobe"]
    assert lobe["least_radius_m"]["value"] == pytest.approx(0.15 - roller, rel=1e-12)
    assert lobe["sharpest_hollow_m"] is None
    assert lobe["undercut"] is False
    steepest = degrees(asin(0.45 / 0.85 * sin(radians(60.1793714951576))))
    assert lobe["largest_pressure_angle_deg"]["value"] == pytest.approx(steepest, rel=1e-12)
    assert lobe["least_pressure_angle_deg"]["value"] == pytest.approx(-steepest, rel=1e-12)
    assert lobe["closing_m"] < 1e-15


def test_an_eccentric_under_a_flat_face_is_a_circle_about_another_point():
    result = sheet(ECCENTRIC, "flat", 0.03)
    profile, outline = result.tables["profile"], result.tables["outline"]
    x, y, theta = outline["x_m"], outline["y_m"], np.radians(outline["theta_deg"])
    assert np.hypot(x, y + 0.01) == pytest.approx(0.04, abs=1e-16)
    assert profile["lobe_radius_m"] == pytest.approx(0.04, rel=1e-12)
    assert profile["eccentricity_m"] == pytest.approx(0.01 * np.sin(theta), abs=1e-16)
    seen = np.degrees(np.unwrap(np.arctan2(x, y)))
    assert outline["contact_angle_deg"] == pytest.approx(seen, abs=1e-10)
    lobe = result.summary["lobe"]
    assert lobe["largest_eccentricity_m"] == pytest.approx({"value": 0.01, "theta_deg": 90.0})
    assert (lobe["undercut"], lobe["largest_roller_m"], lobe["sharpest_hollow_m"]) == (
        False,
        None,
        None,
    )


def test_the_girth_of_a_flat_faces_lobe_is_the_integral_of_its_distance():
    """Cauchy: the perimeter of a convex body is that of its support function."""
    result = sheet(VALVE, "flat", 0.04, **{"simulate.samples": 20_000})
    outline = result.tables["outline"]
    steps = np.hypot(np.diff(outline["x_m"]), np.diff(outline["y_m"]))
    mean_lift = 0.010 * (20.0 + 0.5 * (70.0 + 60.0)) / 360.0
    assert steps.sum() == pytest.approx(2.0 * pi * (0.04 + mean_lift), rel=1e-7)


def test_undercut_and_the_base_a_flat_face_needs():
    needed = 0.005 * 9.0 - 0.010  # R'' at the nose of the shorter flank, less the lift there
    for base, undercut in ((needed * 0.999, True), (needed * 1.001, False)):
        result = sheet(VALVE, "flat", base)
        lobe = result.summary["lobe"]
        assert lobe["undercut"] is undercut
        assert lobe["least_base_radius_m"] == pytest.approx(needed, rel=1e-12)
        assert any("base radius must exceed 35 mm" in note for note in result.notes) is undercut


def test_detach_warns_of_an_undercut_lobe_where_its_pressure_is_asked_for():
    needed = 0.005 * 9.0 - 0.010
    values = {"detach.rpm": {"start": 2500.0, "stop": 2600.0, "num": 2}, "detach.settle": 0}
    for base, undercut in ((needed * 0.999, True), (needed * 1.001, False)):
        contact = {"width": 0.012, "base_radius": base}
        result = camcli.detach(VALVE.load({**values, "contact": contact}))
        assert any("base radius must exceed 35 mm" in note for note in result.notes) is undercut
        assert np.isinf(np.array(result.tables["force"]["pressure_pa"], float)).any() == undercut
        assert result.complete  # a warning is no lost piece


def harmonic_kappa(base, radius):
    """Curvatures of the pitch curve of VALVE, from its closed form at dense phases."""
    turn = VALVE.turn
    c, c1, c2 = VALVE.cam.lift(turn)
    R = base + radius + c + 0.002
    return (R * R + 2.0 * c1 * c1 - R * c2) / (R * R + c1 * c1) ** 1.5


def test_the_largest_roller_on_a_base_circle():
    """On the nose R' = 0: (B + r)^2 = r (B + r - R''), so r = B^2/(-R'' - B), B = base + lift."""
    base = 0.020
    nose = base + 0.010
    wanted = nose**2 / (0.045 - nose)
    lobe = sheet(VALVE, "roller", base, 0.01).summary["lobe"]
    assert lobe["largest_roller_m"]["value"] == pytest.approx(wanted, rel=1e-9)
    for share, undercut in ((0.999, False), (1.001, True)):
        assert (harmonic_kappa(base, share * wanted).max() * share * wanted > 1.0) is np.bool_(
            undercut
        )
        result = sheet(VALVE, "roller", base, share * wanted)
        assert result.summary["lobe"]["undercut"] is undercut
        assert any("at most 60 mm" in note for note in result.notes) is undercut
    assert sheet(VALVE, "roller", 0.0351, 0.01).summary["lobe"]["largest_roller_m"] is None


def test_the_sharpest_hollow_is_that_of_the_closed_form():
    lobe = sheet(VALVE, "roller", 0.02, 0.015).summary["lobe"]
    kappa = harmonic_kappa(0.02, 0.015)
    assert kappa.min() < 0.0
    assert lobe["sharpest_hollow_m"]["value"] == pytest.approx(0.015 - 1.0 / kappa.min(), rel=1e-6)
    assert lobe["least_radius_m"]["value"] == pytest.approx(1.0 / kappa.max() - 0.015, rel=1e-6)


def test_under_a_rocker_the_lobe_lifts_less():
    """A table of the valve on a rocker of 2: the law of the lobe is half of the valve's."""
    values = {"cam.rocker_ratio": 2.0, "cam.measured_at": "valve", "simulate.samples": 90}
    table = sheet(TABLE, "flat", 0.02, **values).tables["profile"]
    slope = TABLE.cam.lift(table["theta_deg"])[1]
    assert table["eccentricity_m"] == pytest.approx(slope / 2.0, abs=1e-5)
    assert max(table["lift_mm"]) == pytest.approx(10.16, abs=2e-3)


@pytest.mark.parametrize("law", ["3-4-5", "4-5-6-7", "cycloidal", "modified-sine"])
def test_the_jerk_of_a_law_is_that_of_its_handbook(law):
    scene = VALVE.scene
    rise = {"start_deg": 100, "length_deg": 70, "law": law}
    cam = {**scene["cam"], "rise": rise, "fall": {"length_deg": 60, "law": law}}
    result = camcli.simulate(camcli.load_scene({**scene, "cam": cam}), profile_only=True)
    table = result.tables["profile"]
    theta, jerk = table["theta_deg"], table["c_thetathetatheta_m_per_rad3"]
    span, places = radians(70.0), [101.0, 117.0, 135.0, 150.0, 168.0]
    for place in places:
        wanted = float(LAWS[law].derivative((place - 100.0) / 70.0, 3)) * 0.010 / span**3
        found = jerk[np.flatnonzero(theta == place)]
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)
    assert table["jerk_mm_per_deg3"] == pytest.approx(1000.0 * jerk * radians(1.0) ** 3, rel=1e-12)
    assert result.summary["jerk_infinite_deg"] == []


def test_the_jerk_has_two_values_where_it_jumps_and_is_infinite_at_corners():
    scene = VALVE.scene
    cam = {**scene["cam"], "rise": {**scene["cam"]["rise"], "law": "3-4-5"}}
    result = camcli.simulate(camcli.load_scene({**scene, "cam": cam}), profile_only=True)
    table = result.tables["profile"]
    at = np.flatnonzero(abs(table["theta_deg"] - 100.0) < 1e-9)
    left, right = table["c_thetathetatheta_m_per_rad3"][at]
    assert (left, right) == (0.0, pytest.approx(60.0 * 0.010 / radians(70.0) ** 3, rel=1e-12))
    assert result.summary["jerk_infinite_deg"] == pytest.approx([190.0, 250.0])
    assert np.isfinite(table["c_thetathetatheta_m_per_rad3"]).all()


LOBE = 65.0, 0.010  # deg of a flank, m of lift


def jerk_of(law: str, deg: float) -> float:
    """Of a lobe of two flanks about 180 deg, m/rad3."""
    flank, height = LOBE
    x = 1.0 - abs(deg - 180.0) / flank
    sign = 1.0 if deg < 180.0 else -1.0
    if x <= 0.0:
        return 0.0
    return sign * float(LAWS[law].derivative(x, 3)) * height / radians(flank) ** 3


@pytest.mark.parametrize(("law", "held"), [("4-5-6-7", 0.98), ("3-4-5", 0.95)])
def test_the_jerk_of_a_measured_cam_is_that_of_its_fit_within_its_estimate(tmp_path, law, held):
    """Of rows of a tenth of a micrometre; the jerk of 3-4-5 jumps at the ends of its flanks."""
    flank, height = LOBE
    lifts = (
        1e3 * height * float(LAWS[law].derivative(max(0.0, 1.0 - abs(deg - 180.0) / flank), 0))
        for deg in range(360)
    )
    text = "deg,lift\n" + "".join(f"{deg},{lift:.4f}\n" for deg, lift in enumerate(lifts))
    loaded = table_scene(tmp_path, text)
    result = camcli.simulate(loaded, profile_only=True)
    table, bounds = result.tables["profile"], np.array(loaded.cam.errors.jerk.bounds)
    theta, jerk = table["theta_deg"], table["c_thetathetatheta_m_per_rad3"]
    inside = np.minimum((theta / 360.0 * len(bounds)).astype(int), len(bounds) - 1)
    truth = np.array([jerk_of(law, deg) for deg in theta])
    moves = (truth != 0.0) | (bounds[inside] > 0.0)
    assert (abs(jerk - truth) <= bounds[inside])[moves].mean() >= held
    assert table["jerk_mm_per_deg3"] == pytest.approx(1000.0 * jerk * radians(1.0) ** 3, rel=1e-12)
    assert result.summary["jerk_error_m_per_rad3"] == bounds.max()
    assert "cannot rule out a corner" in result.summary["jerk_unknown"]
    assert result.summary["jerk_infinite_deg"] is None


def test_the_jerk_of_a_fit_is_the_derivative_of_its_accelerations():
    fine = camcli.load_scene("configs/lift-table.yaml", {"simulate.samples": 7200})
    table = camcli.simulate(fine, profile_only=True).tables["profile"]
    theta, accel = np.radians(table["theta_deg"]), table["c_thetatheta_m_per_rad2"]
    jerk = table["c_thetathetatheta_m_per_rad3"]
    across = (accel[2:] - accel[:-2]) / (theta[2:] - theta[:-2])
    assert abs(across - jerk[1:-1]).max() < 1e-3 * abs(jerk).max()
    assert abs(jerk).max() == pytest.approx(0.24, abs=0.02)


def test_an_outline_that_does_not_close_is_said_so():
    lobe = sheet(VALVE, "roller", 0.02, 0.015).values.lobe
    assert closing_words(lobe, MILLIMETRES) == "closes to rounding"
    words = closing_words(replace(lobe, closing=1e-5), MILLIMETRES)
    assert words == "does not close: 0.01 mm are missing"


@pytest.mark.parametrize(
    ("contact", "told"),
    [
        ({"face": "roller", "base_radius": 0.02}, "without follower_radius"),
        ({"face": "flat", "follower_radius": 0.01}, "with follower_radius 0.01"),
        ({"face": "knife", "width": 0.01}, "with width 0.01"),
        ({"base_radius": 0.01}, "found neither face nor width"),
        ({"face": "mushroom"}, "mushroom"),
        ({"face": "flat", "base_radius": -1.0}, "-1"),
    ],
)
def test_a_follower_that_does_not_fit_is_refused(contact, told):
    with pytest.raises(SceneError) as fault:
        camcli.load_scene({**VALVE.scene, "contact": contact})
    assert told in str(fault.value)
    assert len(fault.value.faults) == 1


def test_a_lobe_without_a_base_circle_is_refused():
    with pytest.raises(SceneError, match="no radius of the base circle"):
        sheet(VALVE, "flat", None)


def test_a_face_without_a_width_has_no_hertz_pressure():
    contact = {"face": "roller", "follower_radius": 0.01, "base_radius": 0.02}
    values = {"detach.rpm": {"start": 2500.0, "stop": 2600.0, "num": 2}}
    pressures = []
    for more in ({}, {"width": 0.01}):
        result = camcli.detach(VALVE.load({**values, "contact": {**contact, **more}}))
        pressures.append(np.array(result.tables["force"]["pressure_pa"], float))
    assert np.isnan(pressures[0]).all()
    assert pressures[1].max() > 1e6


def test_a_lobe_that_is_round_anyway_needs_no_base_circle():
    """Under a flat face an eccentric circle of lift 2 e has the radius base + e all round."""
    lift = ECCENTRIC.scene["cam"]["lift"]
    lobe = sheet(ECCENTRIC, "flat", 0.03).summary["lobe"]
    assert lobe["least_radius_m"]["value"] == pytest.approx(0.03 + lift / 2.0, rel=1e-12)
    assert lobe["least_base_radius_m"] == 0.0
