"""No scene makes the program write outside the output folder, or run what it should only read."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene
from tests.support.bounds import command_line

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
TABLE_SCENE = (CONFIGS / "lift-table.yaml").read_text()
QUICK = ("--no-plot", "--set", "run.transient=0", "--set", "run.record=1")


@pytest.mark.parametrize("tag", ["object/apply:os.mkdir", "object/new:os.mkdir", "module:os"])
def test_tags_of_python_make_nothing(tmp_path, tag):
    path, made = tmp_path / "scene.yaml", tmp_path / "made"
    path.write_text(f"follower: !!python/{tag} [{made}]\n")
    with pytest.raises(SceneError) as caught:
        load_scene(path, [f"run.rpm=!!python/{tag} [{made}]"])
    assert str(caught.value).count("found the tag !!python") == 2
    assert not made.exists()


def everything(folder: Path) -> dict[str, bytes]:
    """Path and content of every file below a folder."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder `in` with a scene, a lift table above it, and a folder for the artefacts."""
    inner = tmp_path / "in"
    inner.mkdir()
    for folder in (tmp_path, inner):
        (folder / "valve-lift.csv").write_bytes((CONFIGS / "valve-lift.csv").read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def table_scene(home: Path, file: str, more: str = "") -> Path:
    """A scene in `in` that reads the table from this file."""
    path = home / "in" / "scene.yaml"
    path.write_text(TABLE_SCENE.replace("file: valve-lift.csv", f"file: {file}{more}"))
    return path


def simulated(home: Path, path: Path, *words: str) -> tuple[str, list[str]]:
    """(stderr, its notes) of a run that changes no file outside the output folder."""
    before = everything(home)
    code, said = command_line(["simulate", "-c", str(path), "-o", "out", *QUICK, *words])
    after = everything(home)
    assert code == 0, said
    for path in {*before, *after}:
        assert path.startswith("out/") or before.get(path) == after.get(path)
    return said, [line for line in said.splitlines() if line.startswith("note: ")]


@pytest.mark.ci
@pytest.mark.parametrize("file", ["../valve-lift.csv", "link.csv"])
def test_a_table_outside_the_scene_s_folder_needs_permission_and_is_recorded(home, file):
    (home / "in" / "link.csv").symlink_to(home / "valve-lift.csv")
    file = file.format(home=home)
    code, said = command_line(["simulate", "-c", str(table_scene(home, file)), *QUICK])
    assert code == 2
    assert "found a file outside the scene's folder" in said

    own = table_scene(home, file, "\n  allow_outside: true")
    code, said = command_line(["simulate", "-c", str(own), *QUICK])
    assert (code, "cam.allow_outside: found true in the scene itself" in said) == (2, True)

    path, allowed = table_scene(home, file), ("--set", "cam.allow_outside=true")
    _, (note,) = simulated(home, path, *allowed)
    assert f"reads {home / 'valve-lift.csv'}, outside the scene's folder" in note
    record = json.loads((home / "out" / "run.json").read_text())
    digest = hashlib.sha256((home / "valve-lift.csv").read_bytes()).hexdigest()
    assert record["scene"]["cam"]["sha256"] == digest
    code, said = command_line(["rerun", "out/run.json"])
    assert (code, "say with --folder where it is" in said) == (2, True)
    assert command_line(["rerun", "out/run.json", "--folder", "in"])[0] == 0
    secret = home / "valve-lift.csv"
    secret.write_text("root:x:secret\n" * 9)
    code, said = command_line(["simulate", "-c", str(path), *QUICK, *allowed])
    assert (code, "not shown" in said, "secret" in said) == (2, True, False)
    secret.write_bytes((CONFIGS / "valve-lift.csv").read_bytes())
    if file == "link.csv":
        assert not simulated(home, path, "--quiet", *allowed)[1]
        for beside in ("valve-lift.csv", "../in/valve-lift.csv"):
            assert not simulated(home, table_scene(home, beside))[1]


@pytest.mark.parametrize(
    ("file", "words"),
    [("pipe", "found a pipe, socket or device"), ("/dev/zero", "outside the scene's folder"),
     (".", "found a folder"), ("'a\\0b'", "no such file"), ("'~/x'", "no such file"),
     ("$HOME/x", "no such file"), ("'|id'", "no such file"), ("x" * 990, "file name too long")],
)  # fmt: skip
def test_a_table_s_name_is_only_a_name(home, file, words):
    os.mkfifo(home / "in" / "pipe")
    code, said = command_line(["simulate", "--dry-run", "-c", str(table_scene(home, file))])
    assert code == 2
    assert words in said


FIGURE = (CONFIGS / "figures" / "3.5.yaml").read_text()


@pytest.mark.parametrize(
    ("name", "command", "words"),
    [
        ("1", "simulate -o ../../taken", "found options in"),
        ("1", "simulate -qo../../taken", "found options in"),
        ("1", "simulate -c /etc/passwd", "found options in"),
        ("1", "sweep --cluster 203.0.113.7:8786", "found options in"),
        ("1", "sweep --shard 1/2", "found options in"),
        ("1", "explore --open", "found options in"),
        ("1", "figures -o ../../taken", "found options in"),
        ("1", "../../bin/sh", "found the command '../../bin/sh'"),
        ("1", "simulate; touch taken", "found options in"),
        ("1", "simulate --help", "found options in"),
        ("..", "simulate", ""),
        (".", "simulate", ""),
    ],
)
def test_a_figure_s_command_and_name_write_nowhere_else(home, name, command, words):
    scenes = home / "scenes"
    scenes.mkdir()
    text = "\n".join(
        f"  command: '{command}'" if line.strip().startswith("command:") else line
        for line in FIGURE.splitlines()
    )
    (scenes / f"{name}.yaml").write_text(text + "\n")
    before = everything(home)
    code, said = command_line(["figures", "--folder", str(scenes), "-o", "out"])
    assert code == 2, said
    assert words in said
    assert everything(home) == before


def test_bytes_of_the_command_line_that_are_no_text_are_shown_as_such(home):
    run = subprocess.run(
        [sys.executable.encode(), b"-m", b"camcli", b"simulate", b"--set", b"run.\xff=1"],
        capture_output=True, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.returncode == 2
    assert b"--set run.\\udcff=1: found bytes that are no UTF-8 text" in run.stderr


@pytest.mark.parametrize("words", [["sweep", "-c", "pipe.yaml"], ["figures", "--folder", "."]])
def test_no_place_of_a_scene_is_waited_for(home, words):
    os.mkfifo("pipe.yaml")
    signal.alarm(30)  # waiting takes no time of the processor
    try:
        code, said = command_line(words)
    finally:
        signal.alarm(0)
    assert code == 2
    assert "pipe.yaml: found a pipe, socket or device, expected a YAML file" in said
