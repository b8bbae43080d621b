"""Hostile scene files and lift tables, row by row: one clear line each, exit code 2, no waiting."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from math import cos, pi
from pathlib import Path

import pytest

from tests.hostile.bounds import command_line

ROOT = Path(__file__).parents[2]
VALID = (ROOT / "configs" / "eccentric.yaml").read_bytes()
TABLE = (ROOT / "configs" / "valve-lift.csv").read_text()
TABLE_SCENE = (ROOT / "configs" / "lift-table.yaml").read_text()
LINE = re.compile(r"[^:]+(:\d+:\d+)?: ([\w.]+: )?.+")

SCENES = {  # bytes of the file, what its message says
    "empty": (b"", "scene.yaml:1:1: found nothing in this file, expected a map with the sections"),
    "two documents": (VALID + b"---\na: 1\n", "found a second document, expected one document"),
    "list": (b"- follower\n- cam\n", "scene.yaml:1:1: found a list, expected a map"),
    "duplicate key": (VALID + b"run: {rpm: 1, rpm: 2}\n", "run.rpm: found key 'rpm' on lines"),
    "unknown key": (VALID + b"sweeep: {}\n", "unknown key 'sweeep', expected one of follower"),
    "nearest key": (VALID + b"sweeep: {}\n", "did you mean 'sweep'?"),
    "key of a number": (VALID + b"3: 1\n", "found the unknown key '3'"),
    "key of nothing": (VALID + b"~: 1\n", "found the unknown key '~'"),
    "key of a list": (VALID + b"? [a]\n: 1\n", "found a map or list as a key"),
    "base 60": (b"run: {rpm: 1:30}\n", "run.rpm: found '1:30', expected a number from"),
    "on": (b"run: {rpm: on}\n", "this word is plain text here, not a switch"),
    "no": (b"classify: {explain: no}\n", "found 'no', expected true or false"),
    "tab": (b"run:\n\trpm: 7\n", "scene.yaml:2:1: found a tab, expected YAML, indent with spaces"),
    "list for a map": (b"run: [rpm]\n", "run: found a list, expected a map with the keys"),
    "map for a list": (b"basins: {q: {a: 1}}\n", "found a map, expected a list of 2, each a num"),
    "short list": (b"basins: {q: [1]}\n", "found a list of 1 values, expected a list of 2"),
    "long list": (b"basins: {q: [1, 2, 3]}\n", "found a list of 3 values, expected a list of 2"),
    "falling window": (b"basins: {q: [1, 0]}\n", "found [1, 0], expected [low, high]"),
    "no cells": (b"basins: {cells: [0, 5]}\n", "0, expected a whole number from 1 to 16384"),
    "binary": (b"\x89PNG\r\n\x1a\n\x00\x00", "found byte 0x89, expected UTF-8 text"),
    "zeros": (bytes(64), "found the control character U+0000, expected text"),
    "latin-1": (b"# \xe9\n" + VALID, "scene.yaml:1:3: found byte 0xe9, expected UTF-8 text"),
    "utf-16": ("run: 1\n".encode("utf-16"), "found UTF-16 text, expected UTF-8 text"),
    "merge key": (b"run: {<<: {rpm: 1}}\n", "found a merge key '<<'"),
    "python tag": (b"run: !!python/object/apply:os.system [id]\n", "found the tag !!python/object"),
    "python name": (b"run: !!python/name:os.system\n", "found the tag !!python/name:os.system"),
    "own tag": (b"run: !include other.yaml\n", "found the tag !include, expected a value without"),
    "not a number": (b"run: {rpm: .nan}\n", "found .nan, expected a number from 1e-09"),
    "infinity": (b"run: {rpm: -.inf}\n", "found -.inf, expected a number from 1e-09"),
    "1e400": (b"follower: {mass: 1e400}\n", "found 1e400, expected a number from 1e-15"),
    "5000 digits": (b"run: {record: " + b"9" * 5000 + b"}\n", "from 1 to 1000000000"),
    "arabic digit": ("run: {rpm: ٣}\n".encode(), "found '٣', expected a number"),
    "wide digits": ("run: {rpm: ７００}\n".encode(), "found '７００', expected a number"),
    "unicode minus": ("run: {rpm: −5}\n".encode(), "write the minus sign as an ASCII -"),
    "cyrillic key": ("rυn: {rpm: 5}\n".encode(), "found the unknown key 'rυn'"),
    "escape codes": (b'"\\e[2J": 1\n', "found the unknown key '\\x1b[2J'"),
    "no title": (b"figure: {title: '', command: sweep}\n", "expected text of 1 to 200 characters"),
    "no command": (b"figure: {title: a, command: ''}\n", "found no command, expected a command"),
    "end of options": (b"figure: {title: a, command: sweep --}\n", "found '--' in 'sweep --'"),
    "too many motions": (
        b"classify: {rpm: {num: 10000000}, starts: 1000000}\n", "10000010000000 motions, expected",
    ),
}  # fmt: skip


def said_of(path: Path, *words: str) -> list[str]:
    """Lines said of a scene that must be refused, each of the one form."""
    code, said = command_line(["simulate", "--dry-run", "-c", str(path), *words])
    assert code == 2, said
    lines = said.splitlines()
    assert lines
    assert all(LINE.fullmatch(line) and line.isprintable() for line in lines)
    return lines


@pytest.mark.parametrize("name", SCENES)
def test_a_hostile_scene_is_one_clear_line(tmp_path, name):
    data, words = SCENES[name]
    path = tmp_path / "scene.yaml"
    path.write_bytes(data)
    assert any(words in line for line in said_of(path))


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 1e-3), ("-0.0", 0.0), ("-0", 0.0), ("&a 2", 2.0), ("5e-324", 5e-324)],
)
def test_what_is_odd_but_clear_is_read(tmp_path, text, value):
    from camcli.scene import load_scene

    path = tmp_path / "scene.yaml"
    lines = ["follower: {mass: 1, stiffness: 1, restitution: 1}", "cam: {kind: eccentric,",
             "  base: -1, lift: 1}", f"run: {{start: {{q: {text}}}}}", ""]  # fmt: skip
    path.write_bytes(b"\xef\xbb\xbf" + "\r\n".join(lines).encode())
    scene = load_scene(path)
    assert scene.run.start.q == value


@pytest.mark.parametrize("command", ["simulate", "sweep", "figures"])
def test_no_place_of_a_scene_is_waited_for(tmp_path, command):
    os.mkfifo(tmp_path / "pipe.yaml")
    given = ["--folder", str(tmp_path)] if command == "figures" else ["-c", "pipe.yaml"]
    run = subprocess.run(
        [sys.executable, "-m", "camcli", command, *given],
        capture_output=True, text=True, cwd=tmp_path, timeout=30, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert run.returncode == 2
    assert "pipe.yaml: found a pipe, socket or device, expected a YAML file" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("/dev/zero", "found a pipe, socket or device"),
        ("/dev/null", "found a pipe, socket or device"),
        (".", "found a folder"),
        ("missing.yaml", "no such file"),
        ("/proc/self/mem", "found byte 0x"),
        ("x" * 5000, "cannot be read: file name too long"),
    ],
)
def test_what_is_no_file_is_refused(path, words):
    if path == "/proc/self/mem":
        words = "cannot be read"
    assert words in said_of(Path(path))[0]


def test_a_file_that_became_a_pipe_since_it_was_looked_at_is_not_waited_for(tmp_path, monkeypatch):
    from camcli.cams import lift_text
    from camcli.scene import files

    usual = os.stat(__file__)
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.setattr(os, "stat", lambda *_, **__: usual)
    finding = files.read_text(tmp_path / "pipe", files.Source(0, "pipe"))
    assert finding.found == "found a pipe, socket or device"
    assert lift_text.read_bytes(tmp_path / "pipe", "pipe") == b""


APART = """
import json, sys, time
from pathlib import Path
from camcli.errors import SceneError
from camcli.scene import load_scene
from camcli.cams import CAMS
start, faults = time.process_time(), []
try:
    load_scene(Path(sys.argv[1]))
except SceneError as error:
    faults = [str(fault) for fault in error.faults]
seconds = time.process_time() - start
status = Path("/proc/self/status").read_text().split()
print(json.dumps([seconds, int(status[status.index("VmHWM:") + 1]) / 1024, faults]))
"""
HEAD = "crank_deg,lift_inch\n"
FINE = [f"{k / 62.5:.3f},{0.2 * (1 - cos(k * pi / 22_500)):.5f}\n" for k in range(45_000)]
TABLES = {  # text of the file, what its message says; a number is the size of a sparse file
    "gigabyte": (2**30, "found more than 10 MB"),
    "empty": ("", "found nothing, expected rows"),
    "only lines": ("\n" * 9_000_000, "found 9000000 lines, expected at most 100000"),
    "short rows": (HEAD + "1,2\n" * 2_400_000, "found 2400001 lines, expected at most"),
    "huge line": (HEAD + "1," * 4_900_000, "valve-lift.csv:2:1: cam.file: found a line of 9800000"),
    "huge header": ("a," * 4_900_000 + "\n1,2\n", "valve-lift.csv:1:1: cam.file: found a line of"),
    "huge cell": (HEAD + "1," + "9" * 9_000, "found '9999999"),
    "no numbers": (HEAD + "x,y\n" * 49_000, "found 'x', expected a number"),
    "falling": (HEAD + "".join(f"{-k},0\n" for k in range(49_000)), "found the angle -1 after 0"),
    "too wide": (HEAD + "".join(f"{k},{k % 9 / 9:.4f}\n" for k in range(49_000)), "too much"),
    "spike": (HEAD + "".join(FINE[:22_500]) + "360.004,0.5\n" + "".join(FINE[22_501:]), "a spike"),
    "comma": (TABLE.replace(",", ";").replace(".", ","), "found a decimal comma"),
    "semicolons": (TABLE.replace(",", ";"), ""),
    "header twice": (TABLE.replace("-144,", "crank_deg,lift_inch\n-144,"), "found 'crank_deg'"),
    "other header": (TABLE.replace("lift_inch", "lift_mm"), "found no column 'lift_inch'"),
    "same names": (TABLE.replace("crank_deg", "lift_inch"), "found no column 'crank_deg'"),
    "control": (TABLE.replace("-100,", "-100\x1b,"), "control character 0x1b"),
}  # fmt: skip


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
@pytest.mark.parametrize("name", TABLES)
def test_a_hostile_table_costs_little(tmp_path, name):
    text, words = TABLES[name]
    with open(tmp_path / "valve-lift.csv", "wb") as file:
        if isinstance(text, int):
            os.truncate(file.fileno(), text)
        else:
            file.write(text.encode())
    path = tmp_path / "scene.yaml"
    path.write_text(TABLE_SCENE)
    command = [sys.executable, "-c", APART, str(path)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    seconds, megabytes, faults = json.loads(run.stdout)
    assert seconds < (1 if len(faults) else 2)
    assert megabytes < 200
    assert not words or words in faults[0]
    assert bool(faults) == bool(words)
    assert all(len(fault) < 800 and fault.isprintable() for fault in faults)
