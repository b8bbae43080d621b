"""cam rerun: a record is run again, and the bytes are compared."""

import json
from hashlib import sha256
from pathlib import Path

import pytest
import yaml

import camcli
from camcli.words import rerun
from tests.conftest import refused

ROOT = Path(__file__).parents[2]
MACHINE = {
    "follower": {"mass": 1, "stiffness": 1000, "restitution": 0.5},
    "cam": {"kind": "eccentric", "base": 0.1, "lift": 0.1},
    "run": {"transient": 5, "record": 5},
    "orbits": {"starts": 0},
}
TURNS = "--set run.transient=10 --set run.record=10"
RUNS = {
    "sweep": f"sweep --rpm 690:745 --points 5 {TURNS} --no-plot",
    "simulate": f"simulate --rpm 700 {TURNS} --no-plot",
    "classify": f"classify --rpm 700:730 --points 2 {TURNS} --no-plot",
    "basins": "basins --cells 16 --no-plot",
    "detach": "detach --points 3 --no-plot",
    "orbits": "orbits --rpm 700 --no-plot",
    "explore": "explore --rpm 700:701 --points 2,2 --with map --vary follower.preload=0:5"
    f" --set orbits.starts=0 {TURNS}",
}


@pytest.fixture
def record(cam, tmp_path):
    assert cam(RUNS["sweep"], "-o here").returncode == 0
    return tmp_path / "here" / "run.json"


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n == "explore")) for n in RUNS]
)
def test_the_same_bytes_again(cam, tmp_path, name):
    assert cam(RUNS[name], "-o here").returncode == 0
    before = sorted(tmp_path.rglob("*"))
    done = cam("rerun here/run.json --json", code=0)
    result = json.loads(done.stdout)
    artefacts = json.loads((tmp_path / "here" / "run.json").read_text())["artefacts"]
    assert (result["same"], result["artefacts"]) == (True, dict.fromkeys(artefacts, "same bytes"))
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("stated", [True, False])
def test_a_working_speed_is_one_that_the_scene_states(cam, tmp_path, stated):
    """700 rpm is the default; written into the scene it is a speed like any other."""
    machine = {**MACHINE, "run": {"rpm": 700} if stated else {}}
    (tmp_path / "machine.yaml").write_text(yaml.safe_dump(machine))
    cam("detach -c machine.yaml --points 2 --no-plot -o here", code=0)
    cam("rerun here/run.json -o there", code=0)
    for folder in ("here", "there"):
        said = json.loads((tmp_path / folder / "run.json").read_text())
        assert ("working" in said["result"]) is stated
        lines = [line for line in said["verdict"] if "At the working speed, 700 rpm" in line]
        assert len(lines) == stated


@pytest.mark.ci
@pytest.mark.slow
def test_pictures_too_and_into_a_folder(cam, tmp_path):
    assert cam(RUNS["sweep"].removesuffix("--no-plot"), "-o here").returncode == 0
    done = cam("rerun here/run.json -o there --threads 1")
    assert (done.returncode, "the same" in done.stdout) == (0, True)
    for name in ("sweep.png", "speeds.csv"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


@pytest.mark.parametrize(
    ("name", "code"),
    [("speeds.csv", 3), ("gone.csv", 3), ("gone.json", 3),
     *((f"gone.{ending}", 0) for ending in ("png", "pdf", "svg", "gif", "mp4"))],
)  # fmt: skip
def test_other_bytes_and_another_version_are_said(cam, record, name, code):
    data = json.loads(record.read_text())
    data["artefacts"][name] = data["program_sha256"] = "0" * 64
    record.write_text(json.dumps(data))
    done = cam("rerun", str(record))
    told = ["the record is of another version of this program"]
    if code == 0:
        told.append("only pictures differ: their bytes are the same on the same installation alone")
    assert (done.returncode, done.stderr.splitlines()) == (code, told)
    assert "bytes differ" in " ".join(done.stdout.split())


def test_a_run_in_trouble_comes_out_again(cam):
    """The run ends with 3, as its rows say; its record is right, and the rerun ends with 0."""
    cam("sweep --rpm 180:200 --points 2 --set run.impact_budget=3 --no-plot -o here", code=3)
    done = cam("rerun here", code=0)
    assert "column status" in done.stderr
    assert "same bytes" in done.stdout


WHOLE = {"command": "sweep", "scene": {}, "options": {}, "artefacts": {"a.csv": "0"}}
WRONG = [
    {"artefacts": {}}, {"artefacts": {"../../x.csv": "0"}}, {"artefacts": {"[/red].csv": "0"}},
    {"artefacts": {"a.csv": 1}}, {"command": "x" * 100_000}, {"command": ["sweep"]},
    {"command": "bench"}, {"scene": {"cam": 3, "x": [None]}}, {"options": {"explain": 1}},
    {"options": {"profile_only": {}}}, {"scene": {"cam": [[[[[[[[[[[[[[]]]]]]]]]]]]]]}},
]  # fmt: skip
HOSTILE = [
    b"", b"{", b"\xff\xfe\x00", b"[]", b"[" * 200_000, b'{"scene":' * 900 + b"1" + b"}" * 900,
    b'{"scene": ' + b"9" * 10_000 + b"}", *(json.dumps(WHOLE | w).encode() for w in WRONG),
]  # fmt: skip


OTHERS = [  # (command, options of an earlier version, scene), and what is said
    ("simulate", {"proved": True}, {}, "options"),
    (
        "simulate",
        {"animate": True, "profile_only": True},
        {},
        "simulate.animate: found it with pro",
    ),
    ("simulate", {"profile_only": True, "base_radius": float("nan")}, {}, "simulate.base_radius"),
    ("simulate", {}, {"simulate": {"base_radius": 1}}, "found it without profile_only"),
    ("orbits", {}, {"orbits": {"prove": "perhaps"}}, "orbits.prove"),
    ("simulate", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("sweep", {}, {"run": {"record": 300_000_000}}, "GB of files"),
    ("classify", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("explore", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("basins", {}, {"basins": {"cells": [16384, 16384], "refine": 9}}, "GB of memory"),
    ("simulate", {}, {"run": {"record": float("inf")}}, "run.json: run.record: found inf"),
    (
        "simulate",
        {"profile_only": True},
        {"run": {"record": float("inf")}},
        "run.json: run.record: found inf",
    ),
    ("simulate", {}, {"plot": {"style": "absent.mplstyle"}}, "absent.mplstyle"),
    ("basins", {}, {"plot": {"width": 1000, "height": 1000}}, "memory to draw"),
]


@pytest.mark.parametrize(("command", "options", "scene", "said"), OTHERS)
def test_a_record_is_checked_like_a_command_line_before_any_work(
    cam, tmp_path, monkeypatch, command, options, scene, said
):
    """Nothing of it is computed: sizes, finite numbers, what means nothing together."""
    monkeypatch.setattr("camcli.cli.sizes.memory", lambda: 12e9)
    monkeypatch.setattr("camcli.cli.rerun.compute", None)
    machine = yaml.safe_load((ROOT / "configs" / "eccentric.yaml").read_text())
    artefacts = {"a.csv": "0", f"{command}.png": "0"} if "plot" in scene else {"a.csv": "0"}
    whole = {"command": command, "scene": machine | scene, "artefacts": artefacts}
    record = tmp_path / "run.json"
    record.write_text(json.dumps({**whole, "options": options}))
    refused(cam("rerun run.json"), said)
    assert list(tmp_path.iterdir()) == [record]


@pytest.mark.parametrize(
    "line",
    [
        "simulate --rpm 700 --profile-only --base-radius 0.4 --panels lift",
        "simulate --rpm 700 --profile-only --no-plot",
        "orbits --rpm 700 --prove --no-plot",
    ],
)
def test_what_was_asked_for_stands_in_the_scene(cam, tmp_path, line):
    """The record holds no options, the scene alone gives the same run, and its hash names it."""
    cam(line, "-o here", code=0)
    record = json.loads((tmp_path / "here" / "run.json").read_text())
    assert "options" not in record
    assert cam("rerun here --json").returncode == 0
    (tmp_path / "scene.yaml").write_text(json.dumps(record["scene"]))
    bare = "--no-plot" if "--no-plot" in line else ""
    cam(f"{record['command']} -c scene.yaml -o there {bare}", code=0)
    again = json.loads((tmp_path / "there" / "run.json").read_text())
    assert again["scene_sha256"] == record["scene_sha256"]
    assert again["artefacts"] == record["artefacts"]
    cam(f"{record['command']} --rpm 700 -o other --no-plot", code=0)
    other = json.loads((tmp_path / "other" / "run.json").read_text())
    assert other["scene_sha256"] != record["scene_sha256"]


def test_a_record_of_an_earlier_version_is_run_again(cam, tmp_path):
    """What stood beside the scene then goes into it."""
    cam("simulate --rpm 700 --profile-only --no-plot -o here", code=0)
    path = tmp_path / "here" / "run.json"
    record = json.loads(path.read_text())
    del record["scene"]["simulate"]["profile_only"]
    record["options"] = {"profile_only": True, "plot": False}
    path.write_text(json.dumps(record))
    assert json.loads(cam("rerun here --json", code=0).stdout)["same"] is True


def test_a_page_without_pictures_is_saved_and_run_again(cam, tmp_path):
    """Its record says that nothing was drawn, and there are no tables to compare."""
    result = camcli.explore({**MACHINE, "sweep": {"rpm": {"start": 100, "stop": 101, "num": 2}}})
    result.save(tmp_path / "here", plot=False)
    cam("rerun here", code=0)


def test_records_that_are_none_are_refused_in_words(cam, tmp_path):
    for data in HOSTILE:
        (tmp_path / "run.json").write_bytes(data)
        refused(cam("rerun run.json"))
    (tmp_path / "run.json").write_text(json.dumps(WHOLE | {"command": "bench"}))
    refused(cam("rerun run.json"), "repeat cam bench")
    refused(cam("rerun absent.json"), "absent.json", "no such file")
    (tmp_path / "empty").mkdir()
    refused(cam("rerun empty"), "run.json", "no such file")
    refused(cam("rerun /dev/zero"), "device")
    with open(tmp_path / "huge.json", "wb") as file:
        file.truncate(1 << 40)
    refused(cam("rerun huge.json"), "more than 64 MB")
    (tmp_path / "huge.json").unlink()


def test_a_file_that_was_changed_is_told_from_bytes_that_differ(cam, record):
    """As it was recorded, changed since, gone since, recorded with other bytes, and both."""
    data = json.loads(record.read_text())
    names = [name for name in data["artefacts"] if name.endswith(".csv")]
    assert len(names) >= 3
    changed, gone, other = names[:3]
    (record.parent / changed).write_text("rpm\n")
    (record.parent / gone).unlink()
    (record.parent / other).write_text("rpm\n")
    data["artefacts"][other] = sha256(b"rpm\n").hexdigest()
    record.write_text(json.dumps(data))
    told = json.loads(cam("rerun", str(record), "--json", code=3).stdout)["artefacts"]
    wanted = dict.fromkeys(data["artefacts"], rerun.SAME)
    assert told == wanted | {changed: rerun.CHANGED, other: rerun.OTHER}
    (record.parent / other).write_text("speed\n")
    told = json.loads(cam("rerun", str(record), "--json", code=3).stdout)["artefacts"]
    assert told[other] == rerun.OTHER
