"""cam rerun: a record is run again, and the bytes are compared."""

import json
from pathlib import Path

import pytest
import yaml

import camcli
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


@pytest.mark.slow
def test_pictures_too_and_into_a_folder(cam, tmp_path):
    assert cam(RUNS["sweep"].removesuffix("--no-plot"), "-o here").returncode == 0
    done = cam("rerun here/run.json -o there --threads 1")
    assert (done.returncode, "the same" in done.stdout) == (0, True)
    for name in ("sweep.png", "speeds.csv"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


@pytest.mark.parametrize(("name", "code"), [("speeds.csv", 3), ("gone.csv", 3), ("gone.png", 0)])
def test_other_bytes_and_another_version_are_said(cam, record, name, code):
    data = json.loads(record.read_text())
    data["artefacts"][name] = data["program_sha256"] = "0" * 64
    record.write_text(json.dumps(data))
    done = cam("rerun", str(record))
    assert (done.returncode, "another version" in done.stderr) == (code, True), done.stderr
    assert "bytes differ" in " ".join(done.stdout.split())


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


OTHERS = [  # (command, options, scene): what a record may hold, and what is said
    ("simulate", {"prove": True}, {}, "found prove of another command, expected animate"),
    ("sweep", {"animate": True}, {}, "found animate of another command, expected plot"),
    ("classify", {"with_map": True}, {}, "found with_map of another command"),
    ("detach", {"profile_only": True}, {}, "found profile_only of another command"),
    ("simulate", {"animate": True, "profile_only": True}, {}, "animate beside profile_only"),
    ("simulate", {"profile_only": True, "base_radius": float("nan")}, {}, "finite number"),
    ("simulate", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("sweep", {}, {"run": {"record": 300_000_000}}, "GB of files"),
    ("classify", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("explore", {}, {"run": {"record": 300_000_000}}, "GB of memory"),
    ("basins", {}, {"basins": {"cells": [16384, 16384], "refine": 9}}, "GB of memory"),
    ("simulate", {}, {"run": {"record": float("inf")}}, "run.record: found inf"),
    ("simulate", {"plot": True}, {"plot": {"style": "absent.mplstyle"}}, "absent.mplstyle"),
    ("basins", {"plot": True}, {"plot": {"width": 1000, "height": 1000}}, "memory to draw"),
]


@pytest.mark.parametrize(("command", "options", "scene", "said"), OTHERS)
def test_a_record_is_checked_like_a_command_line_before_any_work(
    cam, tmp_path, monkeypatch, command, options, scene, said
):
    """Nothing of it is computed: sizes, options of its own command, finite numbers."""
    monkeypatch.setattr("camcli.cli.sizes.memory", lambda: 12e9)
    monkeypatch.setattr("camcli.cli.rerun.compute", None)
    machine = yaml.safe_load((ROOT / "configs" / "eccentric.yaml").read_text())
    whole = {"command": command, "scene": machine | scene, "artefacts": {"a.csv": "0"}}
    record = tmp_path / "run.json"
    record.write_text(json.dumps({**whole, "options": {"plot": False, **options}}))
    refused(cam("rerun run.json"), said)
    assert list(tmp_path.iterdir()) == [record]


def test_a_page_without_pictures_is_saved_and_run_again(cam, tmp_path):
    """Its record says that nothing was drawn, and there are no tables to compare."""
    result = camcli.explore({**MACHINE, "sweep": {"rpm": {"start": 100, "stop": 101, "num": 2}}})
    result.save(tmp_path / "here", plot=False)
    cam("rerun here", code=0)


def test_records_that_are_none_are_refused_in_words(cam, tmp_path):
    for data in HOSTILE:
        (tmp_path / "run.json").write_bytes(data)
        refused(cam("rerun run.json"))
    refused(cam("rerun absent.json"), "absent.json", "no such file")
    (tmp_path / "empty").mkdir()
    refused(cam("rerun empty"), "run.json", "no such file")
    refused(cam("rerun /dev/zero"), "device")
    with open(tmp_path / "huge.json", "wb") as file:
        file.truncate(1 << 40)
    refused(cam("rerun huge.json"), "more than 64 MB")
    (tmp_path / "huge.json").unlink()
