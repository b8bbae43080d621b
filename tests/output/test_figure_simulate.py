"""The picture of a simulation: made-up hops, every edge case."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import camcli
from camcli.analysis.simulate import simulate as run
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.mechanism import Outline, machine_panels
from camcli.plots.picture import Picture
from camcli.plots.simulate import Trace, draw_frames, draw_simulation
from camcli.scene import load_scene
from tests.conftest import settings
from tests.output.pictures import EVEN, bounce, count, pixels, tall


@pytest.mark.parametrize(("turns", "shown"), [(1, 1), (40, 40)])
def test_any_number_of_turns(turns, shown):
    image = pixels(draw_simulation(bounce(turns), EVEN, shown))
    for colour in (style.FLIGHT, style.STICKING, style.CHATTER, style.DETACHMENT):
        assert count(image, colour) > 50


@pytest.mark.parametrize("rows", [0, 17])
def test_a_run_that_stopped_early_says_so(rows):
    stopped = bounce(label="undecided", status=Status.IMPACT_BUDGET, rows=rows)
    picture = draw_simulation(stopped, EVEN, 3)
    assert count(pixels(picture), style.TROUBLE) > 10
    assert "impact-budget" in picture.words
    tall(picture)


@pytest.mark.parametrize("rpm", [190.0, 198.4])
def test_corners_are_kinks_in_the_relative_velocity(chapter, rpm):
    few, many = (
        Trace.of(run(chapter, rpm, settings(10, 1), samples), chapter, 1) for samples in (90, 3600)
    )
    inside = ~(few.sticks | np.isnan(few.u))
    exact = np.interp(few.angle[inside], many.angle, many.u)
    near = np.abs(few.angle[inside] - 209.8206285048424) < 4.0
    assert np.abs(few.u[inside] - exact)[near].max() < 5e-4
    if rpm == 190.0:
        assert few.u[inside][near].max() == pytest.approx(2.005, abs=6e-4)


# --- the machine


def test_the_outline_has_the_lift_and_touches_the_circles_of_the_cam(chapter):
    outline = Outline.of(chapter, 0.4, load_scene().cam)
    x, y = outline.place(180.0, outline.at(180.0), 180.0)
    assert (x, y) == pytest.approx((0.0, 0.55393320723821), abs=1e-12)
    for phase, circle in ((0.0, 0), (180.0, 1), (120.0, 2), (155.0, 3)):
        _, distance, direction, radius = outline.circles[circle]
        point, centre = (
            outline.place(phase, outline.at(phase), 0.0),
            outline.place(direction, distance, 0.0),
        )
        assert np.hypot(*np.subtract(point, centre)) == pytest.approx(radius, abs=1e-5)


def test_any_cam_can_be_drawn():
    outline = Outline.of(EVEN, None)
    assert outline.guessed
    assert np.ptp(outline.radius) == pytest.approx(0.02)
    panels = machine_panels(outline, {"at rest": (0.0, 0.0), "landing": (200.0, 0.01)})
    assert list(Picture("", panels).chosen(["turned", "outline"])) == ["turned", "outline"]
    tall(Picture("x", {name: replace(p, usual=True) for name, p in panels.items()}))


@pytest.mark.slow
def test_an_animation_moves_as_trajectory_csv_does(cam, tmp_path, monkeypatch):
    monkeypatch.setattr("camcli.plots.simulate.FRAMES", 6)
    values = {"run.rpm": 190, "run.transient": 10, "run.record": 2}
    sets = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
    done = cam("simulate --animate", *sets, "--no-plot -o here --json", code=0)
    written = json.loads(done.stdout)["artefacts"]
    assert ("simulate.mp4" in written) == (shutil.which("ffmpeg") is not None)
    with Image.open(tmp_path / "here" / "simulate.gif") as film:
        assert film.n_frames == 6  # one period
        assert film.info["loop"] == 0
    scene = camcli.load_scene(None, values)
    result = camcli.simulate(scene)
    rows = result.tables["trajectory"]
    turns = rows["t_s"] * 190 / 60
    outline = Outline.of(result.system, scene.cam.base_radius, scene.cam)
    for k, figure in enumerate(draw_frames(result.values, result.system, outline, 3)):
        machine, time = figure.axes
        ((_, q),) = time.lines[-1].get_xydata()
        assert q == pytest.approx(np.interp(1 + k / 6, turns, rows["q_m"]), abs=1e-4)
        (tip,) = [patch.get_xy()[0][1] for patch in machine.patches[1:]]
        assert tip == pytest.approx(q + 0.3, abs=1e-4)  # the cam's offset
