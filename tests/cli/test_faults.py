"""What a user gets for a mistake: one message per fault, the exit code, never a traceback."""

import io
import json
import os
import resource
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
QUICK = ("--no-plot", "--set", "run.transient=1", "--set", "run.record=2")


REFUSED = [
    ("sweep --rpm abc", "abc"),
    ("sweep --rpm 1:2:3", "1:2:3"),
    ("simulate --rpm 600:700", "cam sweep"),
    ("simulate --rpm nan", "nan"),
    ("simulate --set run.rpmm=3", "rpm"),
    ("simulate --set run.rpm", "="),
    ("simulate --threads 0", "--threads"),
    ("sweep --points 0", "--points"),
    ("sweep --points -3", "found '-3', expected a whole number above 0, e.g."),
    ("simulate -c absent.yaml", "absent.yaml"),
    ("simulate --rpm 700 --rpm 710", "--rpm: found it twice, expected it once, leave all but one"),
    ("sweep --points 3 --width 80mm --points=5 --points 4", "--points: found it 3 times"),
    ("detach -o here --out there", "-o: found it twice"),
    ("orbits --set orbits.checker=true", "found checker: true without prove"),
    ("orbits --set orbits.chaos=true --rpm 740:750", "orbits.chaos: found a range, expected one"),
    ("orbits --chaos --vary follower.mass=1:2", "--chaos: found it with a number that varies"),
    ("orbits --chaos --rpm 740:750", "--chaos: found it without one speed"),
    ("orbits --chaos --rpm 745 --parameter mass --range 1:2", "--chaos: found it with a number"),
    ("orbits --curve fold --in damping --in mass=1:2", "--in: found 'follower.damping', expected"),
    ("explore --with map --with basins", "--with: found it twice"),
    ("init lift.csv -o a -o b", "-o: found it twice"),
    ("merge a b -o c -o d", "-o: found it twice"),
    ("simulate -c a.yaml -c b.yaml", "-c: found it twice, expected one scene"),
    ("simulate --set run.start.q=0.05", "0.05 m below the cam"),
    ("simulate --set follower.mass=5e-324", "1e-15"),
    ("simulate --set cam.nose_center=0.2", "do not touch"),
    ("simulate --set cam.flank_radius=0.851", "0.001 m"),
    ("simulate --frobnicate", "--frobnicate"),
    ("frobnicate", "frobnicate"),
    ("sweep 660:760", "give a speed or a range as --rpm 660:760"),
    ("detach v.yaml", "(v.yaml), did you mean -c v.yaml?"),
    ("sweep 700.yml", "did you mean -c 700.yml?"),
    ("guide sweep v.yaml", "(v.yaml)\n"),
    ("sweep --rpm 700-800", "write a range with a colon, as 660:760"),
    ("sweep --rpm 700 --points 5", "give a range: --rpm LO:HI"),
    ("simulate -o ''", "found '', expected the name of a folder"),
    ("simulate --base-radius 2", "add --profile-only"),
    ("simulate --profile-only --base-radius nan", "--base-radius: simulate.base_radius: found"),
    ("simulate --profile-only --base-radius 1e7", "--base-radius: simulate.base_radius: found"),
    ("simulate --profile-only --set plot.panels=[snap]", "found 'snap', expected one"),
    ("sweep --vary follower.restitution=0.7:1.2", "found 1.2"),
    ("sweep --vary follower.restitution=0.7", "expected KEY=LO:HI"),
    ("sweep --vary follower.bounce=0:1", "follower.bounce"),
    ("sweep --vary sweep.rpm.num=2:3", "expected a number of follower, cam or run"),
    ("sweep --vary cam.kind=2:3", "cam"),
    ("sweep --vary follower.mass=1:2 --points 3,4", "--points"),
    ("sweep --vary follower.mass=1:2 --explain", "sweep.vary"),
    ("sweep --explain --set sweep.direction=up", "found up, expected fixed"),
    ("sweep --explain --rpm 700", "sweep.rpm"),
    ("sweep --rpm 739:740 --zoom 738:739.5", "within 739 to 740"),
    ("sweep --set sweep.phases_deg=[172,149]", "sweep.phases_deg: found [172, 149], expected"),
    ("sweep --set sweep.phases_deg=[149,361]", "sweep.phases_deg.1: found 361, expected"),
    ("sweep --rpm 739:740 --zoom x", "--zoom: found 'x', expected LO:HI"),
    ("sweep --set 'sweep.also=[{}, {q: 0.01}]'", "sweep.also.1.q: found q = 0.01 m, 0.09 m below"),
    ("sweep --vary run.rpm=700:701 --vary rpm=702:703", "name twice: 'run.rpm'"),
    ("detach --tolerance follower.mass=5%,follower.mass=4%", "twice: 'follower.mass'"),
    ("sweep --hold-to 100", "--hold-to"),
    ("detach --hold-to abc", "--hold-to"),
    ("detach --hold-to 100:200", "--hold-to"),
    ("detach --set detach.margin_n=-1", "margin_n"),
    ("detach --set detach.impact=3", "impacts"),
    ("detach --tolerance follower.mass=5% --tolerance follower.mass=4%", "twice: 'follower.mass'"),
    ("detach --tolerance follower.mass=5% --tolerance ''", "found '', expected KEY=PERCENT%"),
    ("detach --tolerance follower.mass=5", "expected KEY=PERCENT%"),
    ("detach --tolerance run.rpm=5%", "run.rpm"),
    ("detach --tolerance follower.mas=5%", "did you mean 'mass'?"),
    (
        "detach --tolerance mass=5%",
        "found the key 'mass', expected a number of follower or cam, did you mean follower.mass?",
    ),
    ("detach --tolerance stifness=5% --dry-run", "did you mean follower.stiffness?"),
    ("detach --tolerance cam.nose=5% --dry-run", "did you mean 'nose_center'?"),
    ("detach --tolerance spring.rocker=5%", "did you mean cam.rocker_ratio?"),
    (
        "sweep --vary spring.nose_load=1:2",
        "expected a number of follower, cam or run, did you mean follower.stiffness or "
        "follower.preload?",
    ),
    ("detach --tolerance spring.rate=5%", "did you mean follower.stiffness?"),
    ("detach --tolerance spring.preload=5%", "did you mean follower.preload?"),
    ("detach --tolerance =5%", "found the key '', expected a number of follower or cam"),
    ("detach --tolerance follower=5%", "follower: found a section"),
    ("detach --tolerance follower.mass.x=5%", "follower.mass: found a map"),
    ("detach --tolerance cam.kind=5%", "cam.kind: found 'arcs'"),
    ("detach --set 'detach.tolerance=[{key: mass, percent: 5}]'", "did you mean follower.mass?"),
    ("sweep --vary mass=1:2", "did you mean follower.mass?"),
    ("classify --vary nose_radius=0.1:0.2", "did you mean cam.nose_radius?"),
    ("basins --vary reccord=1:2", "did you mean run.record?"),
    ("detach --tolerance follower.gravity=5%", "a number of follower or cam"),
    ("orbits --vary cam.kind=0.1:0.2", "expected a number to follow: it is a text, 'arcs'"),
    ("orbits --vary cam.nose_radius=0:0.2", "expected a number greater than 0"),
    ("orbits --vary follower.mass=1:2 --parameter mass", "--parameter: found it with --vary"),
    ("orbits --vary follower.mass=1:2 --vary rpm=3:4", "expected one number"),
    ("orbits --label P(3;1:1)", "orbits.label"),
    ("orbits --label hello", "expected P(m;s1:...:sm)"),
    ("orbits --rpm 700 --parameter damping", "give one, e.g. --range 0:2"),
    ("orbits --range 3 --parameter mass", "expected two numbers LO:HI"),
    ("orbits --parameter restitution --range 0.5:1.5", "a number of at most 1"),
    ("orbits --parameter restitution --range 0.9:0.5", "exchange them"),
    ("orbits --rpm 710:720 --at 700", "found rpm = 700.0 where orbits are looked for"),
    ("orbits --curve fold --in rpm", "orbits.curve_in"),
    ("orbits --curve fold --parameter mass --range 1:2 --in rpm", "orbits.curve_in"),
    ("orbits --rpm 700:710 --at 699.9", "found rpm = 699.9 where orbits are looked for"),
    ("orbits --rpm 700:710 --at 710.1", "a value from 700.0 to 710.0"),
    ("orbits --curve fold --rpm 700", "give --rpm LO:HI"),
    ("orbits --all 3", "--all: found '3', expected two numbers N,M, e.g. 3,2"),
    ("orbits --all 3.5,2", "orbits.all.impacts: found 3.5, expected a whole number"),
    ("orbits --all 3,10", "orbits.all.turns: found 10, expected a number of at most 9"),
    ("orbits --all 3,2 --label P(1;1)", "--label: found it with --all"),
    ("orbits --all 3,2 --rpm 600:700", "--rpm: found it LO:HI with --all"),
    ("orbits --set orbits.all=3", "expected a map with the keys impacts, turns"),
    ("orbits --set orbits.all.turns=1 --set orbits.curve=fold", "found curve beside all"),
    ("orbits --set orbits.all.turns=1 --set orbits.label=P(1;1)", "found label beside all"),
    ("orbits --set orbits.all.turns=1 --set orbits.simulated=3", "found simulated beside all"),
    ("orbits --set orbits.all.turns=1 --vary follower.mass=1:2", "found vary beside all"),
    ("orbits --set plot.panels=[branch] --branches -1", "orbits.branches"),
    ("basins --cells true", "--cells: found 'true', expected N or NQ,NV"),
    ("basins --q n=0.1:0.9", "--q: found 'n=0.1:0.9', expected two numbers LO:HI"),
    ("basins --q 0.5", "--q: found '0.5', expected two numbers LO:HI"),
    ("basins --v 1e400:3", "--v: found '1e400:3', expected two numbers LO:HI"),
    ("basins --q 0.9:0.1", "found [0.9, 0.1], expected [low, high]"),
    ("basins --refine 11", "basins.refine"),
    ("basins --set basins.boundary=3", "basins.boundary"),
    ("classify --seed 3", "add --starts N"),
    ("classify --trace 1,2", "expected both --trace and --det"),
    ("classify --trace 1 --det 1,2", "expected two numbers L,R"),
    ("classify --trace 1,nan --det 1,2", "expected two numbers L,R"),
    ("classify --rpm 700 --explain", "expected a range"),
    ("classify --starts -3", "classify.starts"),
    ("bench speed", "expected one of precision, stability, scale, validation"),
    ("bench --rpm 700", "No such option"),
    ("bench --set bench.cases=[fast]", "bench.cases"),
    ("bench --set bench.methods=[]", "bench.methods"),
    ("explore --points 1001", "1001 speeds"),
    ("explore --with map", "found none"),
    ("explore --with map --vary cam.nose_radius=0.1:0.2", "constants of the follower"),
    ("explore --with maps", "expected basins or map"),
    ("explore --vary follower.mass=1:2", "without --with map"),
    ("sweep --set sweep.rpm.start=abc --rpm 660:700", "--set sweep.rpm.start=abc: "),
    ("simulate --set run.rpm=abc --rpm 700", "--set run.rpm=abc: "),
]


@pytest.mark.parametrize(("line", "said"), REFUSED)
def test_a_fault_is_named_with_exit_code_2_before_any_work(cam, tmp_path, line, said):
    done = cam(line)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_scene_that_asks_for_a_map_needs_no_option_for_it(cam):
    cam("explore --set explore.map=true --vary follower.mass=1:2 --points 2,2 --dry-run", code=0)


@pytest.mark.parametrize("command", ["sweep", "classify", "basins"])
def test_a_speed_that_a_command_does_not_use_is_told(cam, command):
    told = "note: --set run.rpm is not used"
    planned = f"{command} --set run.rpm=650 --dry-run"
    assert told in cam(planned, "--rpm 700", code=0).stderr
    varied = cam(planned, "--vary follower.restitution=0.7:0.8 --points 2", code=0)
    assert told not in varied.stderr


def test_every_option_given_twice_is_told_at_once(cam):
    done = cam("sweep --rpm 1:2 --points 3 --points 4 --rpm 5:6 --no-plot --no-plot --set a.b=1 "
               "--set a.c=2", code=2)  # fmt: skip
    assert [line.split(":")[0] for line in done.stderr.splitlines()] == ["--rpm", "--points"]


def test_every_fault_of_a_file_at_once_with_line_and_column(cam, tmp_path):
    (tmp_path / "bad.yaml").write_text(
        "follower: {mass: -1, stiffness: abc, restitution: 2}\n"
        "cam: {kind: arcs, base_radius: 0.4}\n"
        "run:\n  rpm: 0\n"
    )
    done = cam("simulate -c bad.yaml", code=2)
    lines = done.stderr.splitlines()
    assert len(lines) >= 5
    assert any(line.startswith("bad.yaml:1:18: follower.mass: ") for line in lines)
    assert any(line.startswith("bad.yaml:4:8: run.rpm: ") for line in lines)


def test_target_that_is_a_file(cam, tmp_path):
    (tmp_path / "taken").write_text("keep me")
    done = cam("simulate", *QUICK, "-o taken", code=2)
    assert "file where the folder should be" in done.stderr
    assert (tmp_path / "taken").read_text() == "keep me"


def test_numerical_trouble_keeps_the_rows_and_exits_3(cam, tmp_path):
    words = ("follower.stiffness=0", "run.start.q=1", "run.start.v=1")
    sets = [word for pair in zip(["--set"] * 3, words, strict=True) for word in pair]
    done = cam("sweep --rpm 100:200 --points 2", *QUICK, *sets, code=3)
    assert "no-return" in done.stderr
    text = (tmp_path / "out/sweep/speeds.csv").read_text()
    assert text.count("no-return") == 2


def test_impact_budget_keeps_what_was_found(cam, tmp_path):
    few = "--rpm 190 --set run.impact_budget=5 --set run.transient=0"
    done = cam("simulate", *QUICK, few, code=3)
    assert "impact-budget" in done.stderr
    record = json.loads((tmp_path / "out/simulate/run.json").read_text())
    assert record["result"]["status"] == "impact-budget"
    assert (tmp_path / "out/simulate/events.csv").read_text().count("impact") >= 5


def test_a_fault_is_an_object_under_json_too(cam):
    for words in (("simulate", "--set", "run.rpm=-1", "--set", "run.x=3"), ("sweep", "--frob")):
        done = cam(*words, "--json")
        found = json.loads(done.stdout)
        assert (done.returncode, found["exit_code"]) == (2, 2)
        assert len(found["faults"]) == len(done.stderr.splitlines()) == len(words) // 2
        assert set(found["faults"][0]) == {"where", "path", "found", "expected", "cure"}
    assert "--frob" in found["faults"][0]["found"]


def test_quiet_says_nothing(cam):
    done = cam("simulate", *QUICK, "-q --set follower.restitution=1")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_version_and_short_help(cam):
    import camcli

    assert cam("--version").stdout == f"cam {camcli.__version__}\n"
    assert cam("sweep -h").stdout == cam("sweep --help").stdout


def test_a_scene_from_stdin_and_one_that_is_a_record(cam, tmp_path, monkeypatch):
    text = "follower: {mass: 1, stiffness: 1000, restitution: 0.5}\n"
    text += "cam: {kind: eccentric, base: 0.1, lift: 0.1}\nrun: {rpm: 100}\n"
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    done = cam("simulate -c -", *QUICK, "--json")
    assert json.loads(done.stdout)["scene"]["follower"]["stiffness"] == 1000
    done = cam("simulate -c out/simulate/run.json")
    assert (done.returncode, "found the run.json of a run" in done.stderr) == (2, True)
    assert cam("rerun out/simulate").returncode == 0
    record = tmp_path / "out/simulate/run.json"
    record.write_text(record.read_text().replace('"mass": 1.0', '"mass": "heavy"'))
    fault = cam("rerun out/simulate", code=2).stderr
    assert fault.startswith("out/simulate/run.json: follower.mass: found 'heavy', expected a num")


def test_a_scene_from_a_closed_stdin(cam, monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)  # as Python finds it in `cam ... -c - <&-`
    done = cam("simulate -c -", code=2)
    said = "stdin: found it closed, expected a scene, pipe one into it, or name a file\n"
    assert done.stderr == said


@pytest.mark.slow
def test_a_deleted_working_folder_and_a_foreign_backend(tmp_path):
    (tmp_path / "gone").mkdir()
    words = [sys.executable, "-m", "camcli", "simulate", *QUICK[1:], "-o", "out"]
    gone = f"cd gone && rmdir ../gone && exec {shlex.join(words)}"
    path = {**os.environ, "PYTHONPATH": os.environ.get("PYTHONPATH", str(ROOT))}
    done = subprocess.run(
        ["sh", "-c", gone], cwd=tmp_path, capture_output=True, text=True, env=path
    )
    assert (done.returncode, "found no working folder" in done.stderr) == (2, True), done.stderr
    env = {**path, "MPLBACKEND": "nonsense"}
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env=env)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "simulate.png").exists()


def low_memory() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (700 << 20, 700 << 20))


def few_files() -> None:
    resource.setrlimit(resource.RLIMIT_NOFILE, (12, 12))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limit", "words"),
    [
        (low_memory, ("sweep", "--points", "9", "--no-plot", "--threads", "64")),
        (few_files, ("sweep", "--points", "9", "--shard", "1/2", "--no-plot")),
    ],
    ids=["memory", "files"],
)
def test_a_limit_of_the_system_is_no_fault_of_the_program(tmp_path, limit, words):
    command = [sys.executable, "-m", "camcli", *words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, preexec_fn=limit)
    assert done.returncode in (0, 2), done.stderr
    assert "internal fault" not in done.stderr
    assert "Traceback" not in done.stderr
