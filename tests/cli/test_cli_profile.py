"""cam simulate --profile-only, and the commands on a measured lift table."""

import csv
import json
import subprocess
import sys
from itertools import pairwise
from math import cos, pi, sin, sqrt
from pathlib import Path

import pytest

from camcli.analysis.cam_profile import bend

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
TABLE = str(CONFIGS / "lift-table.yaml")
KINDS = ["chapter", "law-cycloidal", "law-harmonic", "eccentric", "lift-table"]
COLUMNS = ["theta_deg", "c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2", "force_n"]
ONLY = ("simulate", "--profile-only", "-o", "here")


def read(path: Path) -> list[list[float]]:
    with open(path, newline="") as file:
        lines = list(csv.reader(file))
    assert lines[0] == COLUMNS
    return [[float(text) for text in line] for line in lines[1:]]


def size(path: Path) -> tuple[int, int]:
    """Width and height of a PNG."""
    data = path.read_bytes()
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_cam_is_written_and_drawn(cam, tmp_path, name):
    done = cam(*ONLY, "-c", str(CONFIGS / f"{name}.yaml"))
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in (tmp_path / "here").iterdir()) == [
        "profile.csv", "profile.png", "run.json",
    ]  # fmt: skip
    assert size(tmp_path / "here/profile.png")[0] == 1340
    rows = read(tmp_path / "here/profile.csv")
    assert rows[0][0] == 0.0
    assert rows[-1][0] == pytest.approx(360.0, abs=1e-12)
    assert all(a[0] <= b[0] for a, b in pairwise(rows))
    assert rows[0][1:3] == pytest.approx(rows[-1][1:3], abs=1e-12)
    record = json.loads((tmp_path / "here/run.json").read_text())
    corners = record["result"]["corners_deg"].values()
    twice = [a[0] for a, b in pairwise(rows) if a[0] == b[0]]
    assert twice == pytest.approx([phase for phase in corners if phase > 0.0], abs=1e-9)
    lowest = min(row[4] for row in rows)
    least, span = record["result"]["least_force_n"]["value"], max(row[4] for row in rows) - lowest
    assert lowest - 3e-3 * span <= least <= lowest + 1e-9 * abs(lowest)


def test_the_rows_of_a_corner_are_its_two_sides(cam, tmp_path):
    cam(*ONLY, "--no-plot", "--points", "8")
    rows = read(tmp_path / "here/profile.csv")
    assert len(rows) == 8 + 1 + 2 * 6 - 2  # grid, end, corners; a and f are on the grid
    left, right = (row for row in rows if abs(row[0] - 150.179) < 1e-3)
    assert left[3] == pytest.approx(0.3415971000285428, rel=1e-12)
    assert right[3] == pytest.approx(-1.869212582774405, rel=1e-12)
    assert left[1] == pytest.approx(right[1], rel=1e-15)


def test_derivatives_belong_to_the_lift(cam, tmp_path):
    cam(*ONLY, "--no-plot", "--points", "3600", "-c", TABLE)
    rows = read(tmp_path / "here/profile.csv")
    h = 3.141592653589793 / 1800
    for a, b, c in zip(rows, rows[1:], rows[2:], strict=False):
        if abs(c[0] - a[0] - 0.2) < 1e-9:
            assert (c[1] - a[1]) / (2 * h) == pytest.approx(b[2], abs=1e-6)
            assert (c[2] - a[2]) / (2 * h) == pytest.approx(b[3], abs=1e-5)


def test_a_flat_face_that_is_undercut_is_warned_of(cam, tmp_path):
    done = cam(*ONLY, "--no-plot", "-c", TABLE, "--set", "cam.base_radius=0.018")
    assert "warning: a flat-faced follower undercuts this cam" in done.stderr
    assert "the base radius must exceed 0.03341 m" in done.stderr
    enough = cam(*ONLY, "--no-plot", "-c", TABLE, "--base-radius", "0.0335")
    assert "undercuts" not in enough.stderr
    flat = json.loads((tmp_path / "here/run.json").read_text())["result"]["flat_faced"]
    assert flat["undercut"] is False
    assert flat["least_radius_m"]["value"] == pytest.approx(0.0335 - flat["least_base_radius_m"])


def test_the_radius_of_curvature_of_circles_is_theirs(cam, tmp_path):
    """The chapter's nose circle limits a roller; its centre limits no flat face."""
    cam(*ONLY, "--no-plot")
    result = json.loads((tmp_path / "here/run.json").read_text())["result"]
    assert result["largest_roller_radius_m"]["value"] == pytest.approx(0.15, rel=1e-9)
    assert result["flat_faced"]["least_radius_m"]["value"] < 0


def test_the_bend_of_a_circle_off_the_axis_is_that_of_a_circle():
    radius, off = 0.3, 0.1
    for k in range(24):
        theta = k * pi / 12
        root = sqrt(radius**2 - (off * sin(theta)) ** 2)
        slope = -off * sin(theta) * (1 + off * cos(theta) / root)
        distance = off * cos(theta) + root
        step = 1e-5
        near = [
            off * cos(theta + s) + sqrt(radius**2 - (off * sin(theta + s)) ** 2)
            for s in (-step, step)
        ]
        accel = (near[0] - 2 * distance + near[1]) / step**2
        assert bend(distance, slope, accel) == pytest.approx(1 / radius, rel=1e-4)


def test_an_eccentric_needs_a_base_radius_for_the_knife_edge(cam, tmp_path):
    scene = str(CONFIGS / "eccentric.yaml")
    cam(*ONLY, "--no-plot", "-c", scene)
    result = json.loads((tmp_path / "here/run.json").read_text())["result"]
    assert result["base_radius_m"] is None
    assert result["largest_roller_radius_m"] is None
    cam(*ONLY, "--no-plot", "-c", scene, "--base-radius", "2")
    result = json.loads((tmp_path / "here/run.json").read_text())["result"]
    assert result["largest_roller_radius_m"]["value"] > 0


@pytest.mark.parametrize("radius", ["0", "-1", "nan", "inf", "1e7"])
def test_a_base_radius_that_is_none_is_refused(cam, radius):
    done = cam(*ONLY, "--base-radius", radius)
    assert done.returncode == 2
    assert "--base-radius: found" in done.stderr


def test_without_a_plot_an_old_one_is_removed(cam, tmp_path):
    (tmp_path / "here").mkdir()
    (tmp_path / "here/profile.png").write_text("old")
    cam(*ONLY, "--no-plot")
    assert not (tmp_path / "here/profile.png").exists()


def test_dry_run_and_json(cam, tmp_path):
    assert cam(*ONLY, "--dry-run").returncode == 0
    assert not (tmp_path / "here").exists()
    done = cam(*ONLY, "--json", "--no-plot")
    assert json.loads(done.stdout)["result"]["first_detachment_rpm"] == pytest.approx(114.979, 1e-5)


def test_the_example_table_is_that_of_its_program():
    done = subprocess.run(
        [sys.executable, ROOT / "tests" / "cams" / "valve_lift.py"],
        capture_output=True,
        check=True,
    )
    assert done.stdout == (CONFIGS / "valve-lift.csv").read_bytes()


SMALL = ("--no-plot", "-c", TABLE, "-o", "here", "--rpm", "3500")
COMMANDS = [
    ("simulate",),
    ("sweep",),
    ("detach", "--points", "3"),
    ("orbits", "--set", "orbits.starts=2"),
    ("classify",),
    ("basins", "--set", "basins.cells=[4,4]"),
]


@pytest.mark.parametrize("words", COMMANDS, ids=[words[0] for words in COMMANDS])
def test_every_command_runs_on_a_table_and_says_what_it_is_worth(cam, tmp_path, words):
    short = ("--set", "run.transient=20", "--set", "run.record=8")
    extra = ("--rpm", "3400:3600") if words[0] == "detach" else ()
    done = cam(*words, *SMALL, *short, *extra)
    assert done.returncode == 0, done.stderr
    assert "valve-lift.csv: 145 rows, lift 10.16 mm, last digit 2.54e-06 m" in done.stderr
    assert "first detachment between 33" in done.stdout
    table = json.loads((tmp_path / "here/run.json").read_text())["error"]["lift_table"]
    assert table["bound"] == pytest.approx(0.00099, rel=0.01)
    low, high = table["first_detachment_rpm"]
    assert low < 3353 < high


def test_quiet_says_nothing_about_the_table(cam):
    assert cam(*ONLY, "-q", "--no-plot", "-c", TABLE).stderr == ""


def test_the_bytes_do_not_depend_on_how_the_kernel_runs(cam, tmp_path):
    found = set()
    for kernel in ("python", "compiled"):
        words = ("--set", "run.transient=30", "--set", "run.record=5", "--rpm", "3700")
        done = cam("simulate", *SMALL, *words, "-q", env={"CAMCLI_KERNEL": kernel})
        assert done.returncode == 0, done.stderr
        found.add((tmp_path / "here/trajectory.csv").read_bytes())
    assert len(found) == 1


def test_a_fault_of_the_table_is_one_line_and_exit_code_two(cam, tmp_path):
    (tmp_path / "valve-lift.csv").write_text("crank_deg,lift_inch\n0,0\n1,x\n2,nan\n")
    (tmp_path / "scene.yaml").write_text((CONFIGS / "lift-table.yaml").read_text())
    done = cam("simulate", "-c", "scene.yaml")
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "valve-lift.csv:3:3: cam.file: found 'x', expected a number, correct the cell, remove the "
        "row, or begin the line with # if it is a comment",
        "valve-lift.csv:4:3: cam.file: found 'nan', expected a number, remove the row or measure "
        "it again",
    ]


def test_help_and_other_kinds_import_nothing_for_tables():
    probe = (
        "import sys, camcli.cli.exit_codes as p; from camcli.cli.app import app\n"
        "p.guarded(lambda: app(['simulate', '--no-plot', '--profile-only', '-o', sys.argv[1]],"
        " standalone_mode=False))\n"
        "print([m for m in ('scipy', 'numba', 'matplotlib') if m in sys.modules], file=sys.stderr)"
    )
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", probe, folder], capture_output=True, text=True, check=True
        )
    assert done.stderr.splitlines()[-1] == "[]"


def test_only_the_panels_asked_for(cam, tmp_path):
    heights = []
    for panels in ("[lift]", "[force, lift]", "[curvature]"):
        words = ("--profile-only", "--set", f"simulate.profile_panels={panels}", "-q")
        assert cam("simulate", *words).returncode == 0
        data = (tmp_path / "out/simulate/profile.png").read_bytes()
        heights.append(int.from_bytes(data[20:24], "big"))
    assert heights[0] < heights[1] < 1000
    assert heights[2] > heights[0]
    done = cam("simulate", "--profile-only", "--set", "simulate.profile_panels=[jerk]")
    assert done.returncode == 2
    (fault,) = done.stderr.splitlines()
    assert "found 'jerk', expected one of lift, velocity, acceleration, force, curvature" in fault
