"""Faults as a user reads them, word by word: place, what was found, what is expected, what to do.

`test_faults.py` has a row for each fault and looks for its place and what was found; here stand
whole messages, since a cure that says another thing costs as much as a wrong place.
"""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import camcli
from camcli.cli.exit_codes import failure
from camcli.errors import SceneError
from camcli.output.run_folder import run_folder
from camcli.scene import load_scene
from camcli.scene.schema import PANELS

BRANCHES, OF_ORBITS = (", ".join(PANELS["orbits"][what]) for what in ("branches", "orbits"))
TABLE = Path(__file__).parents[2] / "configs" / "lift-table.yaml"
LOBE = {"length_deg": 180.0, "law": "cycloidal"}
LAW = {"follower": {"mass": 1.0, "stiffness": 1e3, "restitution": 0.5},
       "cam": {"kind": "law", "base": 0.1, "lift": 0.01, "top_dwell_deg": 0.0,
               "rise": {**LOBE, "start_deg": 0.0}, "fall": LOBE}}  # fmt: skip
STOP = {"follower": {"restitution": 0.5},
        "cam": {"kind": "oscillator", "frequency": 2.0, "amplitude": 0.5,
                "clearance": 0.5}}  # fmt: skip


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("simulate --rpm 700:710",
         "--rpm: found the range '700:710', expected one speed, use cam sweep"),
        ("sweep --vary rpm=1:2 --rpm 3:4",
         "--vary: sweep.vary: found the same name twice: 'run.rpm', expected each name once, keep "
         "one of the two"),
        ("orbits --vary rpm=1",
         "--vary: found 'rpm=1', expected KEY=LO:HI, e.g. follower.restitution=0.6:0.9"),
        ("detach --tolerance follower.mass",
         "--tolerance: found 'follower.mass', expected KEY=PERCENT%, e.g. "
         "follower.mass=5%,follower.stiffness=3%"),
        ("figures --folder . --set run.rpm=3 --update-reference",
         "--set: found it with --update-reference, it means nothing there, change the scenes "
         "instead"),
        ("figures --folder . --check --update-reference",
         "--check: found it with --update-reference, it means nothing there, leave it out: a "
         "reference just written always agrees"),
        ("figures --folder .",
         "one.yaml: figure: found no such section, expected title and command, add it"),
        ("figures --folder nowhere",
         "--folder: nowhere: found no such folder, expected *.yaml, name another"),
        ("basins --q 0.1", "--q: found '0.1', expected two numbers LO:HI, e.g. 0.1:0.9"),
        ("basins --v 3", "--v: found '3', expected two numbers LO:HI, e.g. -20:40"),
        ("orbits --all 3", "--all: found '3', expected two numbers N,M, e.g. 3,2"),
        ("sweep --shard 3",
         "--shard: found '3', expected I/N with 1 <= I <= N <= 100000, e.g. 3/16"),
        ("sweep --curves auto",
         "--curves: sweep.vary: found no map, expected two numbers, vary a second number: "
         "--vary KEY=LO:HI"),
        ("explore --with nosuch",
         "--with: found 'nosuch', expected basins or map, e.g. --with basins,map"),
        ("guide nosuch", "guide: found 'nosuch', expected a topic, cam guide lists them"),
        ("init nosuch.csv",
         "nosuch.csv: no such file, expected a table of angles and lifts, check the name"),
        ("merge out",
         "PART: out: cannot be read (No such file or directory), expected a file of --shard I/N, "
         "leave it out"),
        ("rerun out",
         "out: no such file, expected the run.json of a run, give that of a folder made with -o"),
        ("explore --points 0",
         "--points: sweep.rpm.num: found 0, expected a number of at least 1, change num (number of "
         "speeds)"),
        ("sweep --zoom 3:2",
         "--zoom: sweep.zoom: found a zoom from 3 to 2, expected two ends within 660 to 760, and "
         "no map, choose another part, or leave it out"),
        ("orbits --label P(1;2:3)",
         "orbits.label: found 'P(1;2:3)', expected P(m;s1:...:sm) with one count or inf for each "
         "of the m turns, quote it: 'P(3;3:3:2)'"),
        ("simulate 0",
         "cam: Got unexpected extra argument(s) (0), give a speed or a range as --rpm 0"),
        ("simulate scene.yaml",
         "cam: Got unexpected extra argument(s) (scene.yaml), did you mean -c scene.yaml?"),
        ("orbits --in rpm=3:4",
         "--in: found it without --curve, it means nothing there, add --curve KIND"),
        ("orbits --range 0.1:0.2",
         "--range: found it without a parameter, it means nothing there, add --parameter or "
         "--curve and --in"),
        ("orbits --parameter follower.restitution --vary follower.restitution=0.1:0.2",
         "--parameter: found it with --vary, it means nothing there, give the one or the other"),
        ("orbits --range 0.1:0.2 --curve fold",
         "orbits.range: found 0.1 to 0.2, expected a range that holds restitution = 0.8 of the"
         " scene, choose another range"),
        ("orbits --all 2,1 --rpm 660:700",
         "--rpm: found it LO:HI with --all, it means nothing there, give one speed: --rpm X"),
        ("orbits --chaos --rpm 660:700",
         "--chaos: found it without one speed, it means nothing there, give --rpm X"),
        ("orbits --with-checker",
         "--with-checker: found it without --prove, it means nothing there, add --prove"),
        ("orbits --at 700 --rpm 700",
         "--at: found it with one speed, it means nothing there, give --rpm LO:HI, or leave "
         "--at out"),
        ("orbits --range 1:2 --curve fold --in follower.restitution=0.5:0.6",
         "--range: found it with --in KEY=LO:HI, it means nothing there, give both numbers "
         "with --in"),
        ("orbits --curve fold --in follower.restitution",
         "--in: found 'follower.restitution', expected KEY=LO:HI, e.g. "
         "follower.restitution=0.6:0.9"),
        ("orbits --vary run.record=3:4",
         "orbits.vary: found run.record, expected a number to follow: it says how motions are "
         "simulated and recorded, no orbit depends on it, follow a number of follower or cam, "
         "or run.rpm"),
        ("simulate --panels geometry",
         "--panels: plot.panels: found 'geometry', expected one of motion, gap, phase, "
         "section, passage, add --profile-only"),
        ("sweep --panels force",
         "--panels: plot.panels: found 'force', expected one of impacts, enlarged, strobe, "
         "exponents, it is a panel of cam simulate"),
        ("detach --panels surge",
         "--panels: plot.panels: found 'surge', not measured, give spring.mass in kg"),
        ("basins --rpm 700 --panels fractions",
         "--panels: plot.panels: found 'fractions', expected one of basins, ask for more than "
         "three speeds"),
        ("classify --trace 0.5:0.5",
         "--trace: found '0.5:0.5', expected two numbers L,R, e.g. 1.64,1.37"),
        ("basins --cells a",
         "--cells: found 'a', expected N or NQ,NV, whole numbers, e.g. 400,300"),
        ("explore --with map",
         "--with map: sweep.vary: found none, expected the speed or constants of the follower,"
         " give --vary follower.restitution=LO:HI, or another one"),
        ("simulate -c one.yaml -c one.yaml",
         "-c: found it twice, expected one scene, give one scene, and what differs with --set"),
        ("simulate --width 3",
         "--width: plot.width: found 3.0, expected a number of at least 40, change width "
         "(width, mm)"),
        ("simulate --width 3furlong",
         "--width: found '3furlong', expected a number and one of mm, cm, in, pt, e.g. 85mm"),
        ("detach --hold-to fast",
         "--hold-to: found 'fast', expected a speed from 1e-09 to 1e+09 turns per minute, or a"
         " range LO:HI, write it as 700, 660:760 or 6000crank"),
        ("detach --hold-to 700:800",
         "--hold-to: found the range '700:800', expected one speed, e.g. --hold-to 3500, or "
         "--hold-to 7000crank"),
        ("sweep --vary follower.mass=1:2 --points 3,4",
         "--points: found '3,4', expected a whole number above 0, give one number for each "
         "that is varied"),
        ("sweep --vary follower.mass=1:2 --vary follower.damping=0:1 --points 3,4,5",
         "--points: found '3,4,5', expected a whole number above 0, or N,M, give one number "
         "for each that is varied"),
        ("sweep --points x",
         "--points: found 'x', expected a whole number above 0, e.g. --points 41"),
        ("sweep --rpm 1-2",
         "--rpm: found '1-2', expected a speed from 1e-09 to 1e+09 turns per minute, or a "
         "range LO:HI, write a range with a colon, as 660:760"),
        ("sweep --rpm 1:2:3",
         "--rpm: found '1:2:3', expected a speed from 1e-09 to 1e+09 turns per minute, or a "
         "range LO:HI, give the number of speeds with --points"),
        ("sweep --rpm 700kmh",
         "--rpm: found '700kmh', expected a speed from 1e-09 to 1e+09 turns per minute, or a "
         "range LO:HI, write the number without its unit"),
        ("sweep --rpm 1e10",
         "--rpm: found '1e10', expected a speed from 1e-09 to 1e+09 turns per minute, or a "
         "range LO:HI, give a speed in this range"),
        ("sweep --rpm x",
         "--rpm: found 'x', expected a speed from 1e-09 to 1e+09 turns per minute, or a range "
         "LO:HI, write it as 700, 660:760 or 6000crank"),
        ("sweep --rpm 5000crank:6000",
         "--rpm: found '5000crank:6000', expected a speed from 1e-09 to 1e+09 turns per "
         "minute, or a range LO:HI, write crank behind the second end, or behind both"),
        ("simulate --threads 0",
         "--threads: found 0, expected 1 or more, at most 4096, leave it out for all"),
        ("bench nosuch",
         "PART: bench.part: found 'nosuch', expected one of precision, stability, scale, "
         "validation, choose one of these (null: all of them)"),
        ("rerun nosuch",
         "nosuch: no such file, expected the run.json of a run, give that of a folder made "
         "with -o"),
        ("simulate --style nosuch",
         "nosuch: plot.style: no such file, expected a matplotlib style: its name, or a file "
         "of lines `key: value`, python -c 'import matplotlib.style; "
         "print(matplotlib.style.available)' lists the names"),
        ("sweep --branches nosuch.csv",
         "nosuch.csv: no such file, expected a branch.csv in rpm, see cam orbits"),
        ("detach --tolerance run.rpm=5%",
         "--tolerance: detach.tolerance.0: found the key 'run.rpm', expected a number of "
         "follower or cam, e.g. follower.mass"),
        ("sweep --vary cam.kind=3:4",
         "--vary: cam.kind: found 3.0, expected one of arcs, law, eccentric, table, "
         "oscillator, choose one of these"),
        ("simulate --points 0",
         "--points: simulate.samples: found 0, expected a number of at least 1, change samples"
         " (points per turn in trajectory.csv)"),
        ("simulate --set run.start.q=0.01",
         "run.start.q: found q = 0.01 m, 0.09 m below the cam, expected at least c = "
         "0.10000000000000003 m at 0.0 deg, raise it, or null for rest"),
        ("classify --seed 3",
         "--seed: found it without --starts, it means nothing there, add --starts N"),
        ("classify --trace 1,2 --det 0,0 --starts 2",
         "--starts: found it with --trace, it means nothing there, leave it out: no "
         "machine"),
        ("simulate --rpm 3 --rpm 4",
         "--rpm: found it twice, expected it once, leave all but one of them out"),
        ("simulate --rpm 3 --rpm 4 --rpm 5",
         "--rpm: found it 3 times, expected it once, leave all but one of them out"),
        ("orbits --parameter restitution --range 0.7:0.9 --rpm 660:700",
         "--parameter: found it with a range of speeds, it means nothing there, give one"
         " speed: --rpm X"),
        ("orbits --parameter seat_restitution --range 0.1:0.2",
         "orbits.parameter: found seat_restitution, expected a number to follow: without cam.lash "
         "the follower has no seat, no orbit depends on it, follow a number of follower or cam, "
         "or run.rpm"),
        ("orbits --curve fold --in seat_restitution",
         "orbits.curve_in: found seat_restitution, expected a number to follow: without "
         "cam.lash the follower has no seat, no orbit depends on it, follow a number of follower "
         "or cam, or run.rpm"),
        ("orbits --all 2,1 --label P(1;1)",
         "--label: found it with --all, it means nothing there, leave one of them out"),
        ("sweep --panels kind",
         "--panels: plot.panels: found 'kind', expected one of impacts, enlarged, "
         "strobe, exponents, vary two numbers: --vary KEY=LO:HI twice"),
        ("basins --rpm 700:710 --points 5 --panels basins",
         "--panels: plot.panels: found 'basins', expected one of fractions, attractors, "
         "ask for at most three speeds"),
        ("simulate --profile-only -c one.yaml --panels geometry",
         "--panels: plot.panels: found 'geometry', expected a cam under a tip that has "
         "no face of its own, ask for outline"),
        ("simulate --profile-only --panels radius",
         "--panels: plot.panels: found 'radius', not measured, give contact.face: knife,"
         " roller or flat"),
        ("sweep --vary rpm=660:700 --vary follower.restitution=0.5:0.6 --panels seat_open_deg",
         "--panels: plot.panels: found 'seat_open_deg', not measured, give "
         "cam.lash in m: without it there is no seat"),
        ("explore --vary follower.mass=1:2",
         "--vary: found it without --with map, it means nothing there, add --with map"),
        ("sweep --vary follower.mass=1:2 --vary follower.damping=0:1 --vary cam.lift=1:2",
         "--vary: found 3 numbers to vary, expected at most 2, give --rpm one speed, or "
         "fewer --vary"),
        ("orbits --rpm 660:700 --panels orbit",
         f"--panels: plot.panels: found 'orbit', expected one of {BRANCHES}, give one speed: "
         "--rpm X"),
        ("orbits --rpm 700 --panels phases",
         f"--panels: plot.panels: found 'phases', expected one of {OF_ORBITS}, give a range: "
         "--rpm LO:HI"),
        ("orbits --panels curves",
         f"--panels: plot.panels: found 'curves', expected one of {BRANCHES}, add --curve KIND"),
        ("orbits --panels cover",
         f"--panels: plot.panels: found 'cover', expected one of {BRANCHES}, add --all N,M"),
        ("orbits --panels boxes",
         f"--panels: plot.panels: found 'boxes', expected one of {BRANCHES}, add --chaos"),
        ("simulate --no-plot -o one.yaml",
         "-o: one.yaml: found a file where the folder should be, expected a writable "
         "folder, choose another"),
        ("simulate --profile-only -c one.yaml --set contact.face=flat",
         "contact.base_radius: found no radius of the base circle, expected it here or "
         "in the cam, give it in m"),
        ("sweep --explain --set sweep.direction=up",
         "--explain: sweep.direction: found up, expected fixed, leave --explain out, or "
         "set it to fixed"),
        ("sweep --set sweep.direction=both --vary rpm=660:700 --vary follower.restitution=0.5:0.6",
         "sweep.direction: found both, expected one way, choose one, e.g. "
         "sweep.direction=up"),
        ("detach --tolerance follower.damping=5%",
         "--tolerance: follower.damping: found 0.0, expected a number of follower or cam"
         " that is not zero, e.g. follower.mass=5%"),
        ("detach --tolerance follower=5%",
         "--tolerance: follower: found a section, expected a number of follower or cam "
         "that is not zero, e.g. follower.mass=5%"),
        ("orbits --set orbits.chaos=true --vary follower.mass=1:2",
         "orbits.chaos: found a number that varies, expected one speed, and no other "
         "number that varies, leave out what varies, or chaos"),
        ("explore --rpm 1e-5:1e-4",
         "sweep.rpm: found motions of 513479244 rows a turn at 1e-05 rpm, expected at "
         "most 250000 on a page, a follower so stiff moves too fast to be shown: raise "
         "the speeds"),
    ],
)  # fmt: skip
def test_a_line_that_is_refused(cam, tmp_path, line, said):
    one = "follower: {mass: 1, stiffness: 9, restitution: 0.5}\n"
    one += "cam: {kind: eccentric, base: 0.1, lift: 0.02}\n"
    (tmp_path / "one.yaml").write_text(one)
    assert cam(line.replace("(", "\\(").replace(";", "\\;").replace(")", "\\)"),
               code=2).stderr.strip() == said  # fmt: skip


LIFTS = "deg,mm\n" + "".join(
    f"{deg},{1e-6 * max(deg - 90, 0) ** 2 * max(270 - deg, 0) ** 2 / 10:.3f}\n"
    for deg in range(360)
)
FILES = {
    "one.yaml": "follower: {mass: 1, stiffness: 9, restitution: 0.5}\n"
                "cam: {kind: eccentric, base: 0.1, lift: 0.02}\n",
    "stop.yaml": "follower: {restitution: 0.5}\n"
                 "cam: {kind: oscillator, frequency: 2.0, amplitude: 0.5, clearance: 0.5}\n",
    "empty.csv": "",
    "odd.csv": "a,b\n1,2\n",
    "curve.csv": "curve,kind,rpm,restitution\n1,fold,700,x\n",
    "branch.csv": "branch,rpm,stable,q_m,theta1_deg\n1,inf,1,0.1,3\n",
    "empty/a.txt": "", "odd/...yaml": "a: 1\n", "mine/events.csv": "x", "text.pieces": "no",
    "table.yaml": LIFTS, "lift.csv": LIFTS, "lift.png": "no picture",
    "bench.json": '{"command": "bench", "scene": {}, "artefacts": {"a.csv": "0"}}',
    "none.json": '{"command": "sweep", "scene": {}, "artefacts": {}}',
}  # fmt: skip
MAP = "--vary run.rpm=660:700 --vary follower.restitution=0.5:0.6 --points 3,3"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sweep --vary cam.kind=1:2 --vary rpm=600:700 --points 3,3 --curves auto",
         "--curves auto: sweep.vary: found cam.kind, expected a number to follow: it is a "
         "text, 'arcs', leave --curves out, or give it a curve.csv"),
        ("sweep --vary rpm=700:700 --vary follower.restitution=0.5:0.6 --points 3,3 --curves auto",
         "--curves auto: sweep.vary: found one value of rpm, expected a range, give LO:HI"),
        (f"sweep {MAP} --curves empty.csv",
         "--curves: empty.csv:0: found no such table (nothing in it), expected a curve.csv in "
         "run.rpm and follower.restitution, see cam orbits --curve, or give auto"),
        (f"sweep {MAP} --curves odd.csv",
         "--curves: odd.csv:1: found no column run.rpm, expected a curve.csv in run.rpm and "
         "follower.restitution, see cam orbits --curve, or give auto"),
        (f"sweep {MAP} --curves curve.csv",
         "--curves: curve.csv:2: found no such table (could not convert string to float: 'x'),"
         " expected a curve.csv in run.rpm and follower.restitution, see cam orbits --curve, "
         "or give auto"),
        ("sweep --branches empty.csv",
         "--branches: empty.csv:0: found no such table (nothing in it), expected a branch.csv "
         "in rpm, see cam orbits"),
        ("sweep --branches odd.csv",
         "--branches: odd.csv:1: found no column rpm, expected a branch.csv in rpm, see cam "
         "orbits"),
        ("sweep --branches branch.csv",
         "--branches: branch.csv:1: found no column theta_deg, expected a branch.csv in rpm, "
         "see cam orbits"),
        ("detach -c stop.yaml",
         "cam.kind: found an oscillator, whose cam changes with its speed, for cam detach, "
         "expected a cam that turns at any speed, use cam sweep, cam classify, cam basins, cam"
         " orbits or cam simulate"),
        ("explore -c stop.yaml",
         "cam.kind: found an oscillator, whose cam changes with its speed, for cam explore, "
         "expected a cam that turns at any speed, use cam sweep, cam classify, cam basins, cam"
         " orbits or cam simulate"),
        ("classify --explain --rpm 700",
         "--explain: classify.rpm: found one speed, 700.0, expected a range, give --rpm LO:HI "
         "and --points"),
        ("classify --explain --vary follower.mass=1:2",
         "--explain: classify.vary: found follower.mass, expected none, leave --explain out, "
         "or vary the speed (--rpm LO:HI)"),
        ("sweep --explain --vary follower.mass=1:2 --points 5",
         "--explain: sweep.vary: found follower.mass, expected none, leave --explain out, or "
         "vary the speed (--rpm LO:HI)"),
        ("orbits --vary follower.mass=1:2 --vary follower.damping=0:1",
         "orbits.vary: found follower.mass and follower.damping, expected one number along a "
         "branch, leave one out (--rpm X is one speed), or add --curve KIND"),
        ("orbits --vary follower.masss=1:2",
         "orbits.vary: found follower.masss, expected a constant of the follower: mass, "
         "stiffness, damping, gravity, preload, restitution, seat_restitution, name one of "
         "these"),
        ("orbits --vary follower.mass=9:9",
         "orbits.vary: found 9.0 to 9.0, expected the lower end first, two different ends, give "
         "a range LO:HI"),
        ("orbits --parameter restitution --range 0.9:0.5",
         "orbits.range: found 0.9 to 0.5, expected the lower end first, two different ends, "
         "exchange them"),
        ("orbits --vary follower.restitution=0.7:1.5",
         "orbits.vary: found 0.7 to 1.5, expected of restitution a number of at most 1, "
         "correct the range"),
        ("orbits --vary follower.restitution=0.5:0.6",
         "orbits.vary: found 0.5 to 0.6, expected a range that holds restitution = 0.8 of the "
         "scene, choose another range"),
        ("orbits --curve fold --rpm 700",
         "orbits.rpm: found one speed, expected a range for a curve, give --rpm LO:HI"),
        ("orbits -c stop.yaml --curve fold --vary cam.clearance=0.4:0.6",
         "orbits.rpm: found one speed, expected a range for a curve, add another number of the "
         "oscillator: --vary cam.frequency=LO:HI"),
        ("orbits --curve fold --in rpm --range 3:4",
         "orbits.curve_in: found rpm as the second parameter, expected a constant of the "
         "follower, another one than rpm"),
        ("orbits --curve fold --in damping",
         "orbits.range: found no range for damping, which is 0, expected LO:HI, give one, e.g."
         " --range 0:2"),
        ("orbits --at 800 --rpm 660:700",
         "orbits.at: found rpm = 800.0 where orbits are looked for, expected a value from "
         "660.0 to 700.0, the range followed, choose another range, or --at"),
        ("orbits --chaos --vary follower.mass=9:11",
         "--chaos: found it with a number that varies, it means nothing there, give --rpm X "
         "alone"),
        ("orbits --set orbits.chaos=true --rpm 600:650",
         "orbits.chaos: found a range, expected one speed, and no other number that varies, "
         "give --rpm X, or leave chaos out"),
        ("orbits -c stop.yaml --set orbits.at=3",
         "--set orbits.at=3: orbits.at: found 3.0 rpm for an oscillator, expected none: its "
         "speed is its frequency, write it under cam; a range is --vary cam.frequency=LO:HI"),
        ("orbits --vary cam.nose_radius=0.1:0.1",
         "orbits.vary: found 0.1 to 0.1, expected two different ends, give a range LO:HI"),
        ("orbits --vary cam.nose_radius=0.1:0.12",
         "orbits.vary: found 0.1 to 0.12, expected a range that holds cam.nose_radius = 0.15 "
         "of the scene, choose another range"),
        ("figures --folder empty",
         "--folder: empty: found no scenes, expected *.yaml, name another"),
        ("figures --folder odd",
         "odd/...yaml: found a scene named '...yaml', expected a name with a letter, "
         "rename it: the folder has its name"),
        ("simulate --no-plot -o mine",
         "-o: mine: found events.csv, which no run has left there as it is, expected no "
         "such file, move it away, or choose another folder"),
        ("init table.yaml",
         "table.yaml: found that the scene would be written over the table, expected "
         "files of their own, rename the table, e.g. to end in .csv"),
        ("init lift.csv",
         "lift.png: found a file of this name that is no PNG, expected none, move it "
         "away, or choose another -o DIR"),
        ("merge empty",
         "PART: empty: found no parts, expected files COMMAND-I-of-N.pieces, made by "
         "--shard I/N, name the folder they are in"),
        ("merge text.pieces",
         "text.pieces: found no pieces, expected a file of --shard I/N, delete the file,"
         " or choose another folder"),
        ("rerun bench.json",
         "bench.json: cannot be read (command: a bench measures seconds, which are "
         "others each time: repeat cam bench), expected the run.json of a run, give that"
         " of a folder made with -o"),
        ("rerun none.json",
         "none.json: found no artefacts in it, expected the run.json of a run, give that"
         " of a folder made with -o"),
    ],
)  # fmt: skip
def test_a_line_whose_file_or_range_is_refused(cam, tmp_path, line, said):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    assert cam(line, code=2).stderr.strip() == said


@pytest.mark.parametrize(
    ("scene", "values", "said"),
    [
        (TABLE, {"cam.lift": "fraction"},
         "cam: lift: fraction and max_lift belong together: give both, or neither, change the "
         "values of cam"),
        (TABLE, {"cam.lift_column": "crank_deg"},
         "cam.lift_column: angle_column and lift_column are both column 1, expected two columns, "
         "name both"),
        (TABLE, {"cam.lift_column": 7},
         "cam.lift_column: found column 7, expected 1 to 2, as the file has them, columns count "
         "from 1"),
        (TABLE, {"cam.header": False},
         "cam.angle_column: found the name 'crank_deg' for a column of a file without header, "
         "number the column, from 1, or say header: true"),
        (TABLE, {"cam.file": "../nosuch.csv"},
         "cam.file: found a file outside the scene's folder, expected a file beside the scene, "
         "copy it beside the scene, or add --set cam.allow_outside=true"),
        (STOP, {"cam.damping": 0.1, "cam.damping_ratio": 0.1},
         "cam: found damping and damping_ratio: leave one of them out, change the values of cam"),
        (STOP, {"cam.damping": 0.0, "cam.amplitude": 1e7},  # 1e7/|1 - 2^2|
         "cam: its motion without the stop is 3.333e+06 m high: at most 1e6 m, change the values "
         "of cam"),
        (LAW, {"spring.mass": 0.1, "spring.in_follower": True, "follower.stiffness": 0.0},
         "spring.mass: found a mass of a spring, expected a stiffness above 0 beside it, give "
         "follower.stiffness"),
        (LAW, {"contact.face": "roller", "contact.width": 0.012},
         "contact: found face: roller without follower_radius, expected the radius of the roller, "
         "m, give contact.follower_radius"),
        (LAW, {"basins.q": [0.5, 0.1]},
         "basins.q: found [0.5, 0.1], expected [low, high], two different ends, exchange the two"),
        (LAW, {"cam.rise.length_deg": 200.0},
         "cam: rise, top dwell and fall take 380 deg, 20 deg too much: with the base dwell they "
         "share one turn of 360 deg, change the values of cam"),
    ],
)  # fmt: skip
def test_a_scene_that_is_refused(scene, values, said):
    with pytest.raises(SceneError) as refused:
        load_scene(scene, values)
    (fault,) = refused.value.faults
    assert str(fault).endswith(said), str(fault)
    where = str(fault).removesuffix(said)
    assert where in ("overrides: ", "scene: ") or where.endswith(("yaml:12:1: ", ".csv: "))


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "cam: out of memory, ask for fewer speeds, recorded turns or --threads "
                        "(cam ... --dry-run)"),
        (RuntimeError("nothing ran: can't start new thread here"),
         "cam: out of memory, ask for fewer speeds, recorded turns or --threads (cam ... "
         "--dry-run)"),
        (OSError(errno.EMFILE, "Too many open files"),
         "cam: Too many open files, raise ulimit -n, or ask for fewer --threads"),
        (OSError(errno.EACCES, "Permission denied", "scene.yaml"),
         "cam: scene.yaml: Permission denied, see what the system allows, then repeat the command"),
    ],
)  # fmt: skip
def test_what_the_system_refuses(error, said):
    code, (fault,) = failure(error)
    assert (code, str(fault)) == (2, said)


def test_a_fault_of_the_program_and_a_folder_that_is_gone(tmp_path, monkeypatch):
    code, (fault,) = failure(ZeroDivisionError("nobody foresaw this"))
    assert code == 1
    assert str(fault) == (
        "cam: internal fault: ZeroDivisionError: nobody foresaw this (), this is a fault of "
        "camcli, please report it; CAMCLI_TRACEBACK=1 shows the traceback"
    )
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    code, (fault,) = failure(FileNotFoundError(errno.ENOENT, "No such file or directory"))
    said = "cam: found no working folder: it was deleted, cd to another"
    assert (code, str(fault)) == (2, said)


def test_parts_that_are_not_those_of_one_run(cam, tmp_path, monkeypatch):
    def shard(folder, number, more=""):
        turns = "--set run.transient=2 --set run.record=3 --set run.patience=0"
        cam(f"sweep --rpm 700:702 --points 2 {turns} {more} --shard {number} -o {folder}", code=0)
        return tmp_path / folder / f"sweep-{number.replace('/', '-of-')}.pieces"

    def merged(*folders):
        return cam("merge", *folders, code=2).stderr.strip().replace(f"{tmp_path}/", "")

    first, other = shard("a", "1/2"), shard("b", "2/2", "--set run.start.theta_deg=3")
    cure = "merge each on its own; every shard needs the same scene, options and version"
    assert merged("a", "b") == (
        f"PART: b/{other.name}: found pieces of other work than in a/{first.name} (another "
        f"scene), {cure}"
    )
    assert merged("a") == (
        "PART: found 1 of 2 parts, not there: 2, expected all, run --shard of those too"
    )
    with monkeypatch.context() as patch:
        patch.setattr("camcli.cli.merge.program_hash", lambda: "another")
        assert merged("a") == (
            f"PART: a/{first.name}: found pieces of another version of this program, merge with "
            "the version that computed the parts"
        )
    first.write_bytes(first.read_bytes()[:-3])
    assert merged("a") == (
        f"PART: a/{first.name}: found a part not complete, run the same command again, it goes on"
    )


def test_folders_that_cannot_be_written(tmp_path, monkeypatch):
    def said(folder, files=()):
        def at_work():
            with run_folder(tmp_path / folder) as run:
                for name in files:
                    run.write_text(name, ["a"])
                assert len(run.hashes) == len(files)

        with pytest.raises(SceneError) as refused:
            at_work()
        return str(refused.value).replace(f"{tmp_path}/", "")

    cure = "expected a writable folder, choose another"
    with run_folder(tmp_path / "a"):
        assert said("a") == (
            "-o: a: found another run at work here, expected it free, wait for it, or choose "
            "another"
        )
    (tmp_path / "b" / ".x.cam-part").mkdir(parents=True)
    reason = os.strerror(errno.EISDIR)
    assert said("b") == f"-o: b: .x.cam-part could not be removed ({reason}), {cure}"

    def full(handle):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("os.fsync", full)
    reason = os.strerror(errno.ENOSPC)
    assert said("c", ["y.csv"]) == f"-o: c: y.csv could not be written ({reason}), {cure}"
    monkeypatch.setattr("os.access", lambda *_: False)
    assert said("c") == f"-o: c: found a folder that may not be written, {cure}"


def test_what_a_function_of_the_library_is_refused():
    scene = camcli.load_scene(None, {"run.transient": 2, "run.record": 2, "orbits.starts": 0})
    for given in (3, (1, 2, 3), (1,)):
        with pytest.raises(SceneError) as refused:
            camcli.orbits(scene, all=given)
        assert str(refused.value) == (
            f"orbits.all: found {given!r}, expected two numbers (impacts, turns), write e.g. "
            "all=(3, 2)"
        )
    result = camcli.simulate(scene)
    with pytest.raises(SceneError) as refused:
        camcli.plot(result, panels=["motion", "gap"], axes=Figure().add_subplot())
    assert str(refused.value) == (
        "axes: found 2 panels and 1 axes, expected axes for each panel, give more axes: _, axes = "
        "plt.subplots(len(panels)); or name fewer panels"
    )


def test_a_system_without_locks_writes_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fcntl", None)
    with run_folder(tmp_path / "out") as run:
        run.write_text("a.csv", ["a"])
        run.commit()
    assert (tmp_path / "out" / "a.csv").read_text() == "a"


def test_a_folder_that_others_remove_again_and_again(tmp_path, monkeypatch):
    """Each time it was locked it is another one, or none."""
    monkeypatch.setattr("os.path.samestat", lambda *_: False)

    def at_work():
        with run_folder(tmp_path / "out"):
            pass

    with pytest.raises(SceneError) as refused:
        at_work()
    assert str(refused.value).replace(f"{tmp_path}/", "") == (
        "-o: out: found no way to create it (it is not there, or removed again and again), "
        "expected a writable folder, choose another"
    )
