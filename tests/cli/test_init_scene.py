"""The scene that `cam init` writes from a table, word by word: a user goes by its comments."""

import shutil
from pathlib import Path

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
