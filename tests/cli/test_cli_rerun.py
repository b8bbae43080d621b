"""cam rerun: a record is run again, and the bytes are compared."""

import json

import pytest

from tests.parallel.long_runs import cam as forked
from tests.parallel.long_runs import dying

TURNS = ("--set", "run.transient=10", "--set", "run.record=10", "--no-plot")
RUNS = {
    "sweep": ("sweep", "--rpm", "690:745", "--points", "5", *TURNS),
    "simulate": ("simulate", "--rpm", "700", *TURNS),
    "classify": ("classify", "--rpm", "700:730", "--points", "2", *TURNS),
    "basins": ("basins", "--cells", "16", "--no-plot"),
    "detach": ("detach", "--points", "3", "--no-plot"),
    "orbits": ("orbits", "--rpm", "700", "--no-plot"),
}


@pytest.fixture
def record(cam, tmp_path):
    assert cam(*RUNS["sweep"], "-o", "here").returncode == 0
    return tmp_path / "here" / "run.json"


def refused(done, *said: str) -> None:
    assert done.returncode == 2, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert "internal fault" not in done.stderr
    assert len(done.stderr) < 3000
    assert all(words in done.stderr for words in said), done.stderr


@pytest.mark.parametrize("name", RUNS)
def test_the_same_bytes_again(cam, tmp_path, name):
    assert cam(*RUNS[name], "-o", "here").returncode == 0
    before = sorted(tmp_path.rglob("*"))
    done = cam("rerun", "here/run.json", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["same"]
    artefacts = json.loads((tmp_path / "here" / "run.json").read_text())["artefacts"]
    assert result["artefacts"] == dict.fromkeys(artefacts, "same bytes")
    assert sorted(tmp_path.rglob("*")) == before


def test_pictures_too_and_into_a_folder(cam, tmp_path):
    words = ("sweep", "--rpm", "690:745", "--points", "3", *TURNS[:-1], "-o", "here")
    assert cam(*words).returncode == 0
    done = cam("rerun", "here/run.json", "-o", "there", "--threads", "1")
    assert (done.returncode, "the same" in done.stdout) == (0, True)
    for name in ("sweep.png", "speeds.csv"):
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes()


@pytest.mark.parametrize(("name", "code"), [("speeds.csv", 3), ("gone.csv", 3), ("gone.png", 0)])
def test_other_bytes_are_said(cam, record, name, code):
    data = json.loads(record.read_text())
    data["artefacts"][name] = "0" * 64
    record.write_text(json.dumps(data))
    done = cam("rerun", str(record))
    assert done.returncode == code, done.stderr
    assert "bytes differ" in " ".join(done.stdout.split())


def test_another_version_is_said(cam, record):
    data = json.loads(record.read_text())
    data["artefacts"]["speeds.csv"], data["program_sha256"] = "0" * 64, "0" * 64
    record.write_text(json.dumps(data))
    done = cam("rerun", str(record))
    assert (done.returncode, "another version" in done.stderr) == (3, True)


WHOLE = {"command": "sweep", "scene": {}, "options": {}, "artefacts": {"a.csv": "0"}}
HOSTILE = {
    "nothing": b"",
    "no json": b"{",
    "no text": b"\xff\xfe\x00",
    "a list": b"[]",
    "deep": b"[" * 200_000,
    "deeper": b'{"scene":' * 900 + b"1" + b"}" * 900,
    "a long number": b'{"scene": ' + b"9" * 10_000 + b"}",
    "no artefacts": json.dumps(WHOLE | {"artefacts": {}}).encode(),
    "a path": json.dumps(WHOLE | {"artefacts": {"../../x.csv": "0"}}).encode(),
    "markup": json.dumps(WHOLE | {"artefacts": {"[/red].csv": "0"}}).encode(),
    "a number for a hash": json.dumps(WHOLE | {"artefacts": {"a.csv": 1}}).encode(),
    "no such command": json.dumps(WHOLE | {"command": "x" * 100_000}).encode(),
    "a list for a command": json.dumps(WHOLE | {"command": ["sweep"]}).encode(),
    "a deep scene": json.dumps(WHOLE).encode().replace(
        b'"scene": {}', b'"scene": {"cam": ' + b"[" * 500 + b"]" * 500 + b"}"
    ),
    "no scene": json.dumps(WHOLE | {"scene": {"cam": 3, "x": [None]}}).encode(),
    "an option of another type": json.dumps(WHOLE | {"options": {"explain": 1}}).encode(),
    "cells": json.dumps(WHOLE | {"command": "basins", "options": {"cells": 3}}).encode(),
    "bench": json.dumps(WHOLE | {"command": "bench"}).encode(),
}  # fmt: skip


def test_hostile_records_are_refused_in_words(cam, tmp_path):
    for data in HOSTILE.values():
        (tmp_path / "run.json").write_bytes(data)
        refused(cam("rerun", "run.json"))


def test_no_record(cam, tmp_path):
    refused(cam("rerun", "absent.json"), "absent.json", "No such file")
    refused(cam("rerun", "."), "no file")
    refused(cam("rerun", "/dev/zero"), "no file")
    with open(tmp_path / "huge.json", "wb") as file:
        file.truncate(1 << 40)
    refused(cam("rerun", "huge.json"), "too large")
    (tmp_path / "huge.json").unlink()


def test_an_interrupt_promises_nothing_of_a_folder_that_goes(cam, record, tmp_path):
    code, said = forked(("rerun", str(record)), tmp_path, dying("put", 3, "SIGINT"))
    assert code == 130
    assert "interrupted" in said
    assert "on disk" not in said
