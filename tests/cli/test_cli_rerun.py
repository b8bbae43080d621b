"""cam rerun: a record is run again, and the bytes are compared."""

import json

import pytest

from tests.conftest import refused

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
