"""cam simulate --profile-only, and the commands on a measured lift table."""

import csv
import json
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from camcli import load_scene, plot, simulate

CONFIGS = Path(__file__).parents[2] / "configs"
TABLE = str(CONFIGS / "lift-table.yaml")
KINDS = ["chapter", "law-cycloidal", "eccentric", "lift-table"]
COLUMNS = ["theta_deg", "c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2", "force_n",
           "c_thetathetatheta_m_per_rad3", "lift_mm", "velocity_mm_per_deg",
           "acceleration_mm_per_deg2", "jerk_mm_per_deg3"]  # fmt: skip
ONLY = ("simulate", "--profile-only", "-o", "here", "--no-plot")


def read(path: Path) -> list[list[float]]:
    with open(path, newline="") as file:
        lines = list(csv.reader(file))
    assert lines[0] == COLUMNS
    return [[float(text or "nan") for text in line] for line in lines[1:]]


def profiled(cam, folder: Path, *words: str) -> tuple[list[list[float]], dict]:
    """(rows of profile.csv, result of run.json)"""
    cam(*ONLY, *words, code=0)
    result = json.loads((folder / "here/run.json").read_text())["result"]
    return read(folder / "here/profile.csv"), result


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_cam_is_written_over_a_whole_turn(cam, tmp_path, name):
    rows, result = profiled(cam, tmp_path, "-c", str(CONFIGS / f"{name}.yaml"))
    assert sorted(p.name for p in (tmp_path / "here").iterdir()) == ["profile.csv", "run.json"]
    assert (rows[0][0], rows[-1][0]) == (0.0, pytest.approx(360.0, abs=1e-12))
    assert all(a[0] <= b[0] for a, b in pairwise(rows))
    assert rows[0][1:3] == pytest.approx(rows[-1][1:3], abs=1e-12)
    twice = [a[0] for a, b in pairwise(rows) if a[0] == b[0]]
    corners = [phase for phase in result["corners_deg"].values() if phase > 0.0]
    if name == "law-cycloidal":  # only the third derivative jumps where its rise and fall end
        corners = [90.0, 160.0, 200.0, 270.0]
    assert twice == pytest.approx(corners, abs=1e-9)
    forces = [row[4] for row in rows]
    lowest, span = min(forces), max(forces) - min(forces)
    least = result["least_force_n"]["value"]
    assert lowest - 3e-3 * span <= least <= lowest + 1e-9 * abs(lowest)


def test_the_rows_of_a_corner_are_its_two_sides(cam, tmp_path):
    rows, result = profiled(cam, tmp_path, "--points", "8")
    assert len(rows) == 8 + 1 + 2 * 6 - 2  # grid, end, corners; a and f are on the grid
    left, right = (row for row in rows if abs(row[0] - 150.179) < 1e-3)
    assert left[3] == pytest.approx(0.3415971000285428, rel=1e-12)
    assert right[3] == pytest.approx(-1.869212582774405, rel=1e-12)
    assert left[1] == pytest.approx(right[1], rel=1e-15)
    # the nose circle limits a roller, its centre no flat face
    assert result["largest_roller_radius_m"]["value"] == pytest.approx(0.15, rel=1e-9)
    assert result["flat_faced"]["least_radius_m"]["value"] < 0
    assert result["first_detachment_rpm"] == pytest.approx(114.979, 1e-5)


@pytest.mark.ci
def test_a_flat_face_that_is_undercut_is_warned_of(cam, tmp_path):
    done = cam(*ONLY, "-c", TABLE, "--set cam.base_radius=0.018")
    assert "warning: a flat-faced follower undercuts this cam" in done.stderr
    needed = done.stderr.partition("the base radius must exceed ")[2].split()[0]
    law = 33.22801  # mm; c_thetatheta of the table is bounded to 2.4 %
    assert float(needed) == pytest.approx(law, rel=0.01)
    _, result = profiled(cam, tmp_path, "-c", TABLE, "--base-radius", "0.0335")
    flat = result["flat_faced"]
    assert flat["undercut"] is False
    assert flat["least_radius_m"]["value"] == pytest.approx(0.0335 - flat["least_base_radius_m"])


def test_an_eccentric_needs_a_base_radius_for_the_knife_edge(cam, tmp_path):
    scene = str(CONFIGS / "eccentric.yaml")
    _, result = profiled(cam, tmp_path, "-c", scene)
    assert result["base_radius_m"] is result["largest_roller_radius_m"] is None
    _, result = profiled(cam, tmp_path, "-c", scene, "--base-radius", "2")
    assert result["largest_roller_radius_m"]["value"] > 0


@pytest.mark.slow
def test_only_the_panels_asked_for_are_drawn_and_an_old_picture_is_removed(cam, tmp_path):
    heights, picture = [], tmp_path / "here/profile.png"
    for panels in ("[lift]", "[force,lift]"):
        words = ("--set", f"plot.panels={panels}", "-q")
        assert cam(*ONLY[:-1], *words).returncode == 0
        heights.append(int.from_bytes(picture.read_bytes()[20:24], "big"))
    assert heights[0] < heights[1]
    assert cam(*ONLY).returncode == 0
    assert not picture.exists()


def test_the_example_table_is_that_of_its_program():
    program = CONFIGS.parent / "tests" / "support" / "valve_lift.py"
    done = subprocess.run([sys.executable, program], capture_output=True, check=True)
    assert done.stdout == (CONFIGS / "valve-lift.csv").read_bytes()


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", "--rpm", "3500"),
        ("detach", "--points", "3", "--rpm", "3400:3600"),
        ("orbits", "--rpm", "3500", "--set", "orbits.starts=2"),
        ("basins", "--rpm", "3500", "--set", "basins.cells=[4,4]"),
    ],
    ids=lambda words: words[0],
)
def test_every_command_runs_on_a_table_and_says_what_it_is_worth(cam, tmp_path, words):
    short = "--set run.transient=20 --set run.record=8 --no-plot -o here"
    done = cam(words[0], "-c", TABLE, short, *words[1:], code=0)
    assert "valve-lift.csv: 145 rows, lift 10.16 mm, last digit 2.54 um" in done.stderr
    assert "first detachment at 33" in done.stdout
    table = json.loads((tmp_path / "here/run.json").read_text())["error"]["lift_table"]
    assert 0.0 < table["bound"] < 0.2 * table["accel"]
    low, high = table["first_detachment_rpm"]
    assert low < 3345.4 < high


@pytest.mark.parametrize(
    ("name", "unit", "per_m"), [("lift-table", "mm", 1e3), ("chapter", "m", 1)]
)
def test_a_small_cam_is_drawn_in_mm(name, unit, per_m):
    cam = simulate(load_scene(CONFIGS / f"{name}.yaml"), profile_only=True)
    for panel, named in (("lift", f"({unit})"), ("acceleration", f"({unit}/rad²)")):
        axes = plot(cam, panels=[panel]).axes[1]
        assert axes.get_ylabel().endswith(named)
        axes.figure.canvas.draw()
        for at, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True):
            assert float(label.get_text().replace("−", "-")) == pytest.approx(at * per_m)


def test_cams_side_by_side_share_their_axes(cam, tmp_path):
    law = {"kind": "law", "base": 0.1, "lift": 0.3, "top_dwell_deg": 40,
           "rise": {"start_deg": 90, "length_deg": 70, "law": "harmonic"},
           "fall": {"length_deg": 70, "law": "harmonic"}}  # fmt: skip
    cam(f"simulate --profile-only --no-plot --set 'simulate.beside=[{json.dumps(law)}]'", code=0)
    first, second = (
        read(tmp_path / "out/simulate" / f"{name}.csv") for name in ("profile", "profile_2")
    )
    assert max(row[1] for row in first) == pytest.approx(0.25393320723821)
    assert max(row[1] for row in second) == pytest.approx(0.4)
    result = simulate(load_scene(None, {"simulate.beside": [law]}), profile_only=True)
    figure = plot(result, panels=["lift", "acceleration"])
    one, other, three, four = figure.axes[1:]
    assert one.get_ylim() == other.get_ylim() != three.get_ylim() == four.get_ylim()
    assert one.get_ylim()[0] < 0.1 < 0.4 < one.get_ylim()[1]
    assert not other.get_ylabel()
    assert one.get_position().y0 == other.get_position().y0


@pytest.mark.ci
@pytest.mark.parametrize(("name", "digits", "of_jerk"), [("chapter", 6, 6), ("lift-table", 4, 2)])
def test_the_screen_has_the_digits_that_a_cam_deserves(name, digits, of_jerk, cam, tmp_path):
    """A measured cam has fewer, and of its jerk, which is an estimate, two.

    The least lift of a measured cam has none: the table calls it the base circle.
    """
    done = cam(*ONLY, "-c", str(CONFIGS / f"{name}.yaml"), code=0)
    last = [row[5] for row in read(tmp_path / "here/profile.csv")]
    shown = {False: [], True: []}
    for line in done.stdout.splitlines():
        if words := re.fullmatch(r"(least|largest) (c\w*|velocity|acceleration|jerk) "
                                 r"\((\S+)\) +(\S+) +\S+", line):  # fmt: skip
            jerk = words[2] in ("c_thetathetatheta", "jerk")
            shown[jerk].append(len(words[4].lstrip("-0.").replace(".", "").rstrip("0")))
            if words[2] == "c_thetathetatheta":
                found = float(words[4]) / (1e3 if words[3].startswith("mm") else 1.0)
                extreme = min(last) if words[1] == "least" else max(last)
                assert found == pytest.approx(extreme, rel=10.0 ** (1 - of_jerk))
    assert (max(shown[False]), max(shown[True])) == (digits, of_jerk)
    assert done.stdout.count("base circle  ") == (name == "lift-table")
    assert len(shown[False]) + done.stdout.count("base circle  ") == 10
    assert len(shown[True]) == 4


def test_a_profile_alone_is_not_animated(cam, tmp_path):
    said = cam(*ONLY, "--animate", code=2).stderr
    assert "--animate: simulate.animate: found it with profile_only" in said
    assert not (tmp_path / "here").exists()
