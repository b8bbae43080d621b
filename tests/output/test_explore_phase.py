"""The phase plane of explore.html against trajectory.csv, in pixels."""

import re
import shlex
from itertools import pairwise

import numpy as np
import pytest

import camcli
from tests.output.test_explore import (
    FEW,
    browser,
    chromium,
    command_of,
    data_of,
    needs_browser,
    some_motions,
)

__all__ = ["browser", "chromium"]  # fixtures
pytestmark = [pytest.mark.slow, pytest.mark.browser, needs_browser]
MACHINE = ("cam", "follower")  # sections that a command needs again
SCENES = {
    "chapter at 190 rpm": (None, {"sweep.rpm": {"start": 189, "stop": 190, "num": 2}}),
    "valve-train with lash": (
        "configs/valve-train.yaml",
        {"sweep.rpm": {"start": 3300, "stop": 3400, "num": 2}, "orbits.at": 3300,
         "cam.lash": 2e-4, "follower.seat_restitution": 0.3},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_the_phase_plane_is_within_half_a_pixel_of_the_trajectory(
    name, request, browser, cam, tmp_path
):
    """It cut the corners of the cam, where u has a kink: 4.9 pixels at 190 rpm."""
    file, values = SCENES[name]
    path = None if file is None else str(request.config.rootpath / file)
    scene = camcli.load_scene(path, {**FEW, "orbits.starts": 2, "run.record": 20, **values})
    sets = [f"--set={key}={x}" for key, x in values.items() if key.partition(".")[0] in MACHINE]
    source = shlex.join([*([] if path is None else ["-c", path]), *sets])
    camcli.explore(scene, source=source).save(tmp_path / "page")
    data = data_of(tmp_path / "page")
    page = browser(tmp_path / "page", "#rpm=1&t=0")
    flown = 0
    for number in some_motions(data):
        motion = data["motions"][number]
        if motion["rpm"] != scene.sweep.rpm.stop:
            continue
        assert cam(*command_of(data, motion), "-o here").returncode in (0, 3)
        table = np.genfromtxt(
            tmp_path / "here/trajectory.csv",
            delimiter=",",
            names=True,
            dtype=None,
            encoding="utf-8",
        )
        table = table[table["contact"] == "flight"]
        if not len(table):
            continue
        page.evaluate("number => choose(motions[number])", number)
        path, (left, right), (low, high) = page.evaluate(
            """() => [$("flights").getAttribute("d") + $("jumps").getAttribute("d"),
                      [phase.X(0), phase.X(phase.factor)], [phase.Y(0), phase.Y(1)]]"""
        )
        gap, u = table["q_m"] - table["c_m"], table["v_m_per_s"] - table["c_dot_m_per_s"]
        points = np.array([left + gap * (right - left), low + u * (high - low)]).T
        assert far_from(path, points).max() < 0.5, (motion["label"], motion["rpm"])
        flown += len(points)
    assert flown > 50


def far_from(path, points):
    """Pixels from each point to the nearest line of an SVG path of M, L and V."""
    far = np.full(len(points), np.inf)
    for line in path.split("M")[1:]:
        if "V" in line:  # an impact
            line = line.replace("V", f" {line.split()[0]} ")
        corners = np.array(re.findall(r"[-\d.]+", line), float).reshape(-1, 2)
        for start, end in pairwise(corners):
            along = end - start
            share = (points - start) @ along / max(along @ along, 1e-30)
            nearest = start + np.clip(share, 0.0, 1.0)[:, None] * along
            far = np.minimum(far, np.hypot(*(points - nearest).T))
    return far
