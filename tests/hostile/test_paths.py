"""No scene makes the program write outside the output folder, or run what it should only read."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.errors import SceneError
from camcli.scene import load_scene
from tests.hostile.bounds import command_line

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
TABLE_SCENE = (CONFIGS / "lift-table.yaml").read_text()
QUICK = ("--no-plot", "--set", "run.transient=0", "--set", "run.record=1")
LOADERS = {"load", "load_all", "full_load", "full_load_all", "unsafe_load", "unsafe_load_all",
           "Loader", "CLoader", "FullLoader", "CFullLoader", "UnsafeLoader", "CUnsafeLoader",
           "add_constructor", "YAMLObject"}  # fmt: skip


def names_of_yaml(source: str) -> set[str]:
    """Names that a source takes from PyYAML."""
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "yaml":
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == "yaml":
            found.add(node.attr)
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "getattr":
            words = [a.value for a in node.args if isinstance(a, ast.Constant)]
            found |= set(words) if ast.unparse(node.args[0]) == "yaml" else set()
    return found


def test_no_loader_of_yaml_that_makes_objects_is_used():
    used = {path: names_of_yaml(path.read_text()) for path in (ROOT / "camcli").rglob("*.py")}
    used = {path.relative_to(ROOT).as_posix(): names for path, names in used.items() if names}
    assert "camcli/scene/document.py" in used
    assert not {path: names & LOADERS for path, names in used.items() if names & LOADERS}
    assert names_of_yaml("import yaml\nyaml.load(x)\n") & LOADERS
    assert names_of_yaml("from yaml import full_load\n") & LOADERS
    assert names_of_yaml("getattr(yaml, 'CLoader')\n") & LOADERS


@pytest.mark.parametrize(
    "tag", ["object/apply:os.mkdir", "object/new:os.mkdir", "object:os.mkdir", "module:os", "tuple"]
)
def test_tags_of_python_make_nothing(tmp_path, tag):
    path, made = tmp_path / "scene.yaml", tmp_path / "made"
    path.write_text(f"follower: !!python/{tag} [{made}]\n")
    with pytest.raises(SceneError) as caught:
        load_scene(path, [f"run.rpm=!!python/{tag} [{made}]"])
    found = [str(fault) for fault in caught.value.faults]
    assert sum("found the tag !!python" in text for text in found) == 2
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


def table_scene(home: Path, file: str, **more) -> Path:
    """A scene in `in` that reads the table from this file."""
    lines = "".join(f"\n  {key}: {value}" for key, value in more.items())
    path = home / "in" / "scene.yaml"
    path.write_text(TABLE_SCENE.replace("file: valve-lift.csv", f"file: {file}{lines}"))
    return path


def simulated(home: Path, path: Path, *words: str) -> tuple[int, str, dict[str, bytes]]:
    """(exit code, stderr, files changed outside the output folder) of a run."""
    before = everything(home)
    code, said = command_line(["simulate", "-c", str(path), "-o", "out", *QUICK, *words])
    after = everything(home)
    changed = {k: v for k, v in after.items() if before.get(k) != v and not k.startswith("out/")}
    assert set(before) <= set(after)
    return code, said, changed


@pytest.mark.parametrize("file", ["../valve-lift.csv", "{home}/valve-lift.csv", "link.csv"])
def test_a_table_outside_the_scene_s_folder_is_said_and_recorded(home, file):
    (home / "in" / "link.csv").symlink_to(home / "valve-lift.csv")
    file = file.format(home=home)
    code, said, _ = simulated(home, table_scene(home, file))
    assert code == 2
    assert "found a file outside the scene's folder" in said

    path = table_scene(home, file, allow_outside="true")
    code, said, changed = simulated(home, path)
    assert (code, changed) == (0, {})
    (line,) = [line for line in said.splitlines() if line.startswith("note: ")]
    assert f"reads {home / 'valve-lift.csv'}, outside the scene's folder" in line
    record = json.loads((home / "out" / "run.json").read_text())
    digest = hashlib.sha256((home / "valve-lift.csv").read_bytes()).hexdigest()
    assert record["scene"]["cam"]["sha256"] == digest

    assert "note: " not in simulated(home, path, "--quiet")[1]


def test_a_table_beside_the_scene_needs_no_note(home):
    code, said, changed = simulated(home, table_scene(home, "valve-lift.csv"))
    assert (code, changed) == (0, {})
    assert "note: " not in said
    assert "note: " not in simulated(home, table_scene(home, "../in/valve-lift.csv"))[1]


@pytest.mark.parametrize(
    ("file", "words"),
    [("pipe", "found a pipe, socket or device"), ("/dev/zero", "outside the scene's folder"),
     (".", "found a folder"), ("'a\\0b'", "no such file"), ("'~/x'", "no such file"),
     ("$HOME/x", "no such file"), ("'|id'", "no such file"), ("x" * 990, "file name too long")],
)  # fmt: skip
def test_a_table_s_name_is_only_a_name(home, file, words):
    os.mkfifo(home / "in" / "pipe")
    path = table_scene(home, file)
    code, said = command_line(["simulate", "--dry-run", "-c", str(path)])
    assert code == 2
    assert words in said


def test_a_table_s_name_cannot_write_to_the_terminal(home):
    (home / "in" / "\x1b[2J.csv").write_bytes((home / "valve-lift.csv").read_bytes())
    code, said, _ = simulated(home, table_scene(home, '"\\e[2J.csv"'))
    assert code == 0
    assert "\x1b" not in said
    assert "\\x1b[2J.csv: " in said


FIGURE = (CONFIGS / "figures" / "3.5.yaml").read_text()


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("simulate -o ../../taken", "found --out"),
        ("simulate -qo../../taken", "found --out"),
        ("simulate -c /etc/passwd", "found --config"),
        ("simulate -- -o x", "found '--'"),
        ("figures -o ../../taken", "found the command 'figures'"),
        ("../../bin/sh", "found the command '../../bin/sh'"),
        ("simulate; touch taken", "found the command 'simulate;'"),
        ("simulate --help", "found --help"),
    ],
)
def test_a_figure_s_command_writes_nowhere_else(home, command, words):
    scenes = home / "scenes"
    scenes.mkdir()
    text = "\n".join(
        f"  command: '{command}'" if line.strip().startswith("command:") else line
        for line in FIGURE.splitlines()
    )
    (scenes / "1.yaml").write_text(text + "\n")
    before = everything(home)
    code, said = command_line(["figures", "--folder", str(scenes), "-o", "out"])
    assert code == 2, said
    assert words in said
    assert everything(home) == before


@pytest.mark.parametrize("name", ["...yaml", "..yaml"])
def test_a_scene_s_name_cannot_lead_out_of_the_figures_folder(home, name):
    scenes = home / "scenes"
    scenes.mkdir()
    (scenes / name).write_text(FIGURE)
    code, said = command_line(["figures", "--folder", str(scenes), "-o", "out/figures"])
    assert code == 2, said
    assert not (home / "out").exists()


def test_bytes_of_the_command_line_that_are_no_text_are_shown_as_such(home):
    run = subprocess.run(
        [sys.executable.encode(), b"-m", b"camcli", b"simulate", b"--set", b"run.\xff=1"],
        capture_output=True, check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.returncode == 2
    assert b"--set run.\\udcff=1: found bytes that are no UTF-8 text" in run.stderr
