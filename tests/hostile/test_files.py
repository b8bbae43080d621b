"""Hostile scene files through the command: one clear line each, exit code 2, no waiting."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path

import pytest

from tests.hostile.bounds import command_line

ROOT = Path(__file__).parents[2]
VALID = (ROOT / "configs" / "eccentric.yaml").read_bytes()
LINE = re.compile(r"[^:]+(:\d+:\d+)?: ([\w.]+: )?.+")

SCENES = {  # bytes of the file, what its message says
    "empty": (b"", "scene.yaml:1:1: found nothing in this file, expected a map with the sections"),
    "nearest key": (VALID + b"sweeep: {}\n", "did you mean 'sweep'?"),
    "python tag": (b"run: !!python/object/apply:os.system [id]\n", "found the tag !!python/object"),
    "5000 digits": (b"run: {record: " + b"9" * 5000 + b"}\n", "found 99999"),
    "arabic digit": ("run: {rpm: ٣}\n".encode(), "found '٣', expected a number"),
    "cyrillic key": ("rυn: {rpm: 5}\n".encode(), "found the unknown key 'rυn'"),
    "escape codes": (b'"\\e[2J": 1\n', "found the unknown key '\\x1b[2J'"),
    "no command": (b"figure: {title: a, command: ''}\n", "found no command, expected a command"),
    "end of options": (b"figure: {title: a, command: sweep --}\n", "found '--' in 'sweep --'"),
    "too many motions": (
        b"classify: {rpm: {num: 10000000}, starts: 1000000}\n", "10000010000000 motions, expected",
    ),
}  # fmt: skip


def said_of(path: str | Path) -> list[str]:
    """Lines said of a scene that must be refused, each of the one form."""
    code, said = command_line(["simulate", "--dry-run", "-c", str(path)])
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
    ("path", "words"),
    [
        ("/dev/zero", "found a pipe, socket or device"),
        (".", "found a folder"),
        ("missing.yaml", "no such file"),
        ("x" * 5000, "cannot be read: file name too long"),
    ],
)
def test_what_is_no_file_is_refused(path, words):
    assert words in said_of(path)[0]


@pytest.mark.skipif(not Path("/proc/self/mem").exists(), reason="this system has no /proc")
def test_a_file_that_cannot_be_read_is_refused():
    assert "cannot be read" in said_of("/proc/self/mem")[0]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("words", [["sweep", "-c", "pipe.yaml"], ["figures", "--folder", "."]])
def test_no_place_of_a_scene_is_waited_for(tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.yaml")
    signal.alarm(30)  # waiting takes no time of the processor
    try:
        code, said = command_line(words)
    finally:
        signal.alarm(0)
    assert code == 2
    assert "pipe.yaml: found a pipe, socket or device, expected a YAML file" in said
