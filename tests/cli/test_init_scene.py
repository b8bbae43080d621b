"""The scene that `cam init` writes from a table, word by word: a user goes by its comments."""

import shutil
from math import cos, pi
from pathlib import Path

import pytest
import yaml

from camcli.cli import init
from camcli.errors import Fault, SceneError

CONFIGS = Path(__file__).parents[2] / "configs"
WRITTEN = """\
follower:
  mass: 0.12345        # kg, FILL IN: valve, retainer, tappet and a third of the spring
  stiffness: 41234.5   # N/m, FILL IN: the spring; 1 N/mm is 1000 N/m
  preload: 245.67      # N, FILL IN: force of the spring at zero lift
  damping: 20          # N s/m, CHECK: a guess for oil and friction; 0 to leave it out
  gravity: 0           # m/s2, 9.81 where the weight presses on the cam
  restitution: 0.4     # -, 0..1: speed after an impact over speed before; oiled steel 0.3 to 0.6
# in the place of stiffness and preload, loads of the spring on the shut and on the open valve, N:
# spring: {seat_load: 250, nose_load: 650, solid_at: 0.012}   # m, lift at which it is solid
# with the mass of the spring its surge is looked at; in_follower: a third of it is in mass already:
# spring: {mass: 0.06, in_follower: true}   # kg
# contact: {width: 0.012, base_radius: 0.017, follower_radius: null}   # m: for the Hertz pressure
# with lash, in the section cam: lash: 0.0002   # m, clearance at the valve (cam guide lash)

cam:
  kind: "table"
  file: "table.csv"
  header: 1                    # lines that name the columns
  angle_column: "crank_deg"    # name, or number from 1
  lift_column: "lift_inch"     # name, or number from 1
  angle: "crank"               # cam | crank: a crank turns twice as fast as the cam
  lift: "inch"                 # m | mm | um | inch | thou (0.001 inch) | fraction (of max_lift)
  rocker_ratio: 1              # CHECK: taken without a rocker; if there is one, write its ratio (lift of the valve per lift of the lobe)
  measured_at: "lobe"          # CHECK: write valve if the table is of the valve and not of the lobe; beside a rocker that matters
  zero_deg: 0                  # deg of the cam where the table's angle is zero; turns all phases
  direction: "same"            # same | reversed: whether the cam's angle rises or falls with the table's
  base: 0                      # m, the follower's height at zero lift

run:
  rpm: 2900            # CHECK: the working speed, rpm of the cam; of a crank: 6000 crank
"""  # noqa: E501
RADII = """\
  kind: "table"
  file: "a.csv"
  header: 1                    # lines that name the columns
  skip_lines: 2                # lines of the file before the header
  decimal: "comma"             # point | comma
  angle_column: "Winkel [deg]" # name, or number from 1
  lift_column: "Radius [mm]"   # name, or number from 1
  angle: "cam"                 # CHECK: 120 deg of the cam, or of a crank that turns twice as fast?
  lift: "mm"                   # m | mm | um | inch | thou (0.001 inch) | fraction (of max_lift)
  subtract: 17.0               # CHECK: the numbers go from 17 to 26, so they are radii: the least one is taken for the base circle, and what is more for the lift; that is the lift of the follower only where the radii were measured with a follower like it (a roller, a flat face)
  base_radius: 0.017           # m, of the base circle; only for the shape of the lobe
  mirrored: false              # CHECK: the lift only rises or only falls, so this is one flank: write true if the lobe is symmetric, else measure the other flank too
  rocker_ratio: 1              # CHECK: taken without a rocker; if there is one, write its ratio (lift of the valve per lift of the lobe)
  measured_at: "lobe"          # CHECK: write valve if the table is of the valve and not of the lobe; beside a rocker that matters
  zero_deg: 0                  # deg of the cam where the table's angle is zero; turns all phases
  direction: "same"            # same | reversed: whether the cam's angle rises or falls with the table's
  base: 0                      # m, the follower's height at zero lift
"""  # noqa: E501


def test_the_scene_of_a_table_is_written_with_what_to_fill_in_and_to_check(cam, tmp_path):
    shutil.copy(CONFIGS / "valve-lift.csv", tmp_path / "table.csv")
    done = cam("init table.csv --no-plot", code=0)
    assert (tmp_path / "table.yaml").read_text() == WRITTEN
    assert done.stdout.splitlines() == [
        "table.csv: header 1, angle_column crank_deg, lift_column lift_inch, angle crank, lift "
        "inch, rocker_ratio 1, measured_at lobe",
        "CHECK rocker_ratio: 1 is a guess: taken without a rocker; if there is one, write its "
        "ratio (lift of the valve per lift of the lobe)",
        "CHECK measured_at: lobe is a guess: write valve if the table is of the valve and not of "
        "the lobe; beside a rocker that matters",
        "table.yaml: fill in mass and spring, then: cam detach -c table.yaml",
    ]


def test_a_flank_of_radii_as_a_german_spreadsheet_writes_it(cam, tmp_path):
    """From 17 mm on the base circle to 26 mm on the nose, below a name and a date."""
    rows = ["Nocke 7;;", "Datum;1.2.2024;", "Winkel [deg];Radius [mm];x"]
    radii = ((k, 17.0 + 4.5 * (1.0 - cos(pi * k / 120))) for k in range(121))
    rows += [f"{k};{radius:.3f};".replace(".", ",") for k, radius in radii]
    (tmp_path / "a.csv").write_text("\n".join(rows) + "\n")
    cam("init a.csv --no-plot", code=0)
    assert (tmp_path / "a.yaml").read_text().partition("cam:\n")[2] == RADII


@pytest.mark.parametrize(
    ("name", "written"),
    [
        ("Öffnung [°]", '"Öffnung [°]"'),  # as it reads
        ("Winkel 角", '"Winkel 角"'),
        ("a\N{NO-BREAK SPACE}b", r'"a\u00a0b"'),  # what cannot be seen
        ("a\N{RIGHT-TO-LEFT OVERRIDE}ö", r'"a\u202e\u00f6"'),
    ],
)
def test_the_name_of_a_column_stands_in_a_scene_as_it_reads(name, written):
    """Signs that do not show are written by their numbers; either is read as the same name."""
    text = init._scene(Path("ö.csv"), {"header": 1, "angle_column": name}, {"header": "unsure"})
    (line,) = [line for line in text.splitlines() if line.startswith("  angle_column:")]
    assert line == f"  angle_column: {written}".ljust(30) + " # name, or number from 1"
    cam = yaml.safe_load(text)["cam"]
    assert (cam["file"], cam["angle_column"], cam["header"]) == ("ö.csv", name, 1)
    assert (cam["kind"], cam["zero_deg"], cam["direction"], cam["base"]) == ("table", 0, "same", 0)
    assert "  header: 1                    # CHECK: unsure" in text


def test_a_picture_that_cannot_be_drawn_leaves_the_scene(cam, tmp_path, monkeypatch):
    """The fault may be one that is corrected there, and a note says so before the fault."""
    shutil.copy(CONFIGS / "valve-lift.csv", tmp_path / "table.csv")

    def refuse(*args, **more):
        raise SceneError(Fault("scene", "cam", "found it", "expected another", "change it"))

    monkeypatch.setattr("camcli.api.simulate.simulate", refuse)
    done = cam("init table.csv", code=2)
    assert done.stderr.splitlines() == [
        "note: table.yaml is written; what the fault is about may be corrected there",
        "scene: cam: found it, expected another, change it",
    ]
    assert (tmp_path / "table.yaml").is_file()
    assert not (tmp_path / "table.png").exists()
