"""A rocker between lobe and valve: what is said of the lobe is of the lobe, against closed forms.

The lobe is a circle of radius CIRCLE whose centre is ECCENTRICITY off the axis. A flat face on it
lifts e (1 - cos theta); a knife edge sqrt(r^2 - e^2 sin^2 theta) - e cos theta - (r - e).
"""

import json
from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest

import camcli
from camcli.analysis.simulate import simulate
from camcli.plots.mechanism import Outline
from camcli.plots.simulate import draw_frames
from tests.conftest import settings

CIRCLE, ECCENTRICITY, RATIO = 0.018, 0.004, 1.6
BASE = CIRCLE - ECCENTRICITY
SCENE = {
    "follower": {"mass": 0.12, "stiffness": 42000.0, "preload": 260.0, "restitution": 0.4},
    "contact": {"width": 0.012, "modulus": 1.1e11},
    "detach": {"rpm": {"start": 3000.0, "stop": 3000.0, "num": 1}, "settle": 0},
    "run": {"rpm": 500.0},
}


def flat_face(deg):
    return ECCENTRICITY * (1 - cos(radians(deg)))


def knife_edge(deg):
    across = ECCENTRICITY * sin(radians(deg))
    return sqrt(CIRCLE**2 - across**2) - ECCENTRICITY * cos(radians(deg)) - BASE


@pytest.fixture
def machine(tmp_path):
    """A scene whose table has the lift of the lobe, or of the valve behind the rocker."""

    def made(lobe, measured_at, base=0.0, **contact):
        scale = 1e3 * (RATIO if measured_at == "valve" else 1.0)
        rows = "".join(f"{deg},{scale * lobe(deg):.12f}\n" for deg in range(0, 360, 2))
        (tmp_path / "lift.csv").write_text(rows)
        cam = {"kind": "table", "file": "lift.csv", "header": False, "angle_column": 1,
               "lift_column": 2, "angle": "cam", "lift": "mm", "zero_deg": 0, "direction": "same",
               "base": base, "base_radius": BASE, "rocker_ratio": RATIO}  # fmt: skip
        cam |= {} if measured_at == "lobe" else {"measured_at": measured_at}
        scene = {**SCENE, "cam": cam, "contact": {**SCENE["contact"], **contact}}
        path = tmp_path / "scene.yaml"
        path.write_text(json.dumps(scene))
        return camcli.load_scene(path)

    return made


SIDES = pytest.mark.parametrize("measured_at", ["lobe", "valve"])


@SIDES
def test_a_flat_face_needs_a_base_circle_for_the_lobe_and_not_for_the_valve(machine, measured_at):
    """Three humps of the lobe: R + R'' = base + e (1 + 8 cos 3 theta), at least base - 7 e."""
    scene = machine(lambda deg: ECCENTRICITY * (1 - cos(3 * radians(deg))), measured_at)
    bent = camcli.simulate(scene, profile_only=True).values.curvature
    assert bent.least_base_radius == pytest.approx(7.0 * ECCENTRICITY, rel=1e-4)


@SIDES
def test_a_flat_face_sees_the_radius_of_the_circle(machine, measured_at):
    scene = machine(flat_face, measured_at)
    found = camcli.simulate(scene, profile_only=True)
    bent = found.values.curvature
    assert bent.flat == pytest.approx([CIRCLE] * len(bent.flat), rel=1e-6)
    assert found.summary["flat_faced"]["least_radius_m"]["value"] == pytest.approx(CIRCLE, rel=1e-6)
    assert bent.least_base_radius == pytest.approx(0.0, abs=1e-8)
    assert not bent.undercut
    assert found.notes == ()
    lift = found.tables["profile"]["c_m"]
    assert max(lift) == pytest.approx(RATIO * 2 * ECCENTRICITY, rel=1e-9)  # of the valve
    assert found.summary["rocker_ratio"] == RATIO


@SIDES
def test_a_knife_edge_sees_the_circle_and_the_largest_roller_is_as_large(machine, measured_at):
    found = camcli.simulate(machine(knife_edge, measured_at, base=0.1), profile_only=True)
    bent = found.values.curvature
    assert bent.knife == pytest.approx([1 / CIRCLE] * len(bent.knife), rel=1e-6)
    assert bent.roller.value == pytest.approx(CIRCLE, rel=1e-6)


@SIDES
def test_the_pressure_is_that_of_the_force_on_the_lobe(machine, measured_at):
    """N at the valve, RATIO N on the lobe; a flat face on the circle, then a roller on it."""
    force = camcli.detach(machine(flat_face, measured_at)).tables["force"]
    on_lobe = RATIO * np.maximum(force["force_n"], 0.0)
    wanted = np.sqrt(on_lobe * 1.1e11 / (pi * 0.012 * CIRCLE))
    assert force["pressure_pa"] == pytest.approx(wanted, rel=1e-6)
    roller = 0.005  # its centre runs on the circle, which is that of the cam and the roller
    scene = machine(knife_edge, measured_at, follower_radius=roller, base_radius=BASE - roller)
    force = camcli.detach(scene).tables["force"]
    on_lobe = RATIO * np.maximum(force["force_n"], 0.0)
    sharp = 1 / roller + 1 / (CIRCLE - roller)
    wanted = np.sqrt(on_lobe * 1.1e11 * sharp / (pi * 0.012))
    assert force["pressure_pa"] == pytest.approx(wanted, rel=1e-6)


@pytest.mark.ci
@SIDES
def test_the_lobe_is_drawn_and_what_runs_on_it_moves_as_little(machine, measured_at):
    scene = machine(knife_edge, measured_at, base=0.1)
    result = camcli.simulate(scene, profile_only=True)
    outline = Outline.of_lift(result.system, BASE, scene.cam)
    wanted = [BASE + knife_edge(np.degrees(theta)) for theta in outline.theta]
    assert outline.radius == pytest.approx(wanted, rel=1e-8)
    x, y = outline.body
    assert np.hypot(x, y + ECCENTRICITY) == pytest.approx(np.full(len(x), CIRCLE), rel=1e-6)
    motion = simulate(result.system, 9000.0, settings(2, 1, q=0.13), 90)
    for figure in draw_frames(motion, result.system, outline, 1, 5, 5):
        machine_axes, time = figure.axes
        ((_, q),) = time.lines[-1].get_xydata()
        (tip,) = [patch.get_xy()[0][1] for patch in machine_axes.patches[1:]]
        assert tip == pytest.approx(BASE + (q - 0.1) / RATIO, abs=2e-5)
        assert machine_axes.get_ylim()[1] > tip


@pytest.mark.ci
def test_a_page_draws_the_lobe_too(machine):
    from camcli.api.explore_page import machine_data
    from camcli.api.machine import machine_of

    drawn = machine_data(machine_of(machine(knife_edge, "lobe", base=0.1)))["outline"]
    assert drawn["ratio"] == RATIO
    top = np.hypot(drawn["x"], drawn["y"]).max()
    valve = 0.1 + RATIO * 2 * ECCENTRICITY
    assert valve / drawn["ratio"] + drawn["rise"] == pytest.approx(top, rel=1e-8)


@pytest.mark.ci
def test_the_motion_is_that_of_the_valve_wherever_the_table_is_from(machine):
    """And a table of the lobe that is taken for the valve's has another first detachment."""

    def first(scene):
        return camcli.detach(scene).values.detachment.first.rpm

    one, other = (first(machine(flat_face, side)) for side in ("lobe", "valve"))
    assert one == pytest.approx(other, rel=1e-6)
    accel = RATIO * ECCENTRICITY  # N = F0 + k (A - A cos) + m A w^2 cos, least at 180 deg
    exact = sqrt((260 + 2 * 42000 * accel) / (0.12 * accel)) * 30 / pi
    assert one == pytest.approx(exact, rel=1e-6)


@pytest.mark.ci
def test_what_is_of_the_lobe_is_called_so(cam, machine, tmp_path):
    machine(flat_face, "lobe")
    done = cam("simulate --profile-only --no-plot -c scene.yaml", code=0)
    assert "least radius of curvature of the lobe (rocker 1.6), flat face (mm)" in done.stdout
    done = cam("detach --no-plot -c scene.yaml", code=0)
    assert "Contact force at the valve, kept on the cam (lobe: 1.6 times)" in done.stdout
