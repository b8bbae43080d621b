"""Hostile files: never more than a second of work and 200 MB, and never anything but a fault."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from camcli.scene.load import MAX_BYTES

ROOT = Path(__file__).parents[2]
STATUS = Path("/proc/self/status")

CODE = """
import json, sys, time
from pathlib import Path
from camcli.errors import SceneError
from camcli.scene import load_scene
start, faults = time.process_time(), []
try:
    load_scene(Path(sys.argv[1]))
except SceneError as error:
    faults = [str(fault) for fault in error.faults]
seconds = time.process_time() - start
status = Path("/proc/self/status").read_text().split()
print(json.dumps([seconds, int(status[status.index("VmHWM:") + 1]) / 1024, faults]))
"""


def laughs(wide):
    """Each line holds the one before `wide` times."""
    lines = (f"a{i}: &a{i} [" + f"*a{i - 1}," * wide + "]" for i in range(1, 40))
    return "\n".join(["a0: &a0 [" + "x," * wide + "]", *lines])


HOSTILE = {
    "laughs": (laughs(9), "more than 20000 values"),
    "laughs in pairs": (laughs(2), "more than 20000 values"),
    "itself": ("run: &r {start: *r}", "nested deeper than 32"),
    "brackets": ("[" * 100_000, "nested deeper than 32"),
    "braces": ("{a: " * 60_000, "nested deeper than 32"),
    "braces in lines": ("{a:\n " * 50_000, "nested deeper than 32"),
    "dashes": ("- " * 125_000, "nested deeper than 32"),
    "questions": ("? " * 125_000, "nested deeper than 32"),
    "staircase": ("\n".join(" " * i + "a:" for i in range(700)), "nested deeper than 32"),
    "unknown keys": ("\n".join(f"follower{i}: {i}" for i in range(9000)), "further faults"),
    "duplicate keys": ("a: 1\n" * 9000, "further faults"),
    "wrong items": ("sweep: {sections: [" + "x," * 19_000 + "]}", "further faults"),
    "same items": ("sweep: {sections: [" + "strobe," * 19_000 + "]}", "the same name twice"),
    "digits": ("run: {rpm: " + "1" * 250_000 + "}", "run.rpm: found 111"),
    "long text": ("run: {rpm: " + "x" * 250_000 + "}", "run.rpm: found 'xxx"),
    "long key": ("? " + "k" * 250_000 + "\n: 1", "unknown key 'kkk"),
    "escapes": ('a: "' + "\\x1b" * 60_000 + '"', "unknown key 'a'"),
    "unclosed quote": ("a: '" + "''" * 125_000, "a quote is not closed"),
    "documents": ("---\n" * 60_000, "a second document"),
    "comments": ("#\n" * 125_000, "found nothing"),
}


def load_apart(path):
    """(seconds, MB, faults) of loading a file in a process of its own."""
    command = [sys.executable, "-c", CODE, str(path)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    return json.loads(run.stdout)


@pytest.mark.skipif(not STATUS.exists(), reason="memory is read from /proc")
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_file(tmp_path, name):
    text, words = HOSTILE[name]
    assert len(text) <= MAX_BYTES  # else the size check would hide what is tested
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    seconds, megabytes, faults = load_apart(path)
    assert seconds < 1
    assert megabytes < 200
    assert any(words in fault for fault in faults)
    assert max(map(len, faults)) < 800


@pytest.mark.skipif(not STATUS.exists(), reason="memory is read from /proc")
def test_a_file_of_a_gigabyte_is_not_read(tmp_path):
    path = tmp_path / "scene.yaml"
    with open(path, "wb") as file:
        os.truncate(file.fileno(), 2**30)  # sparse: takes no room
    seconds, megabytes, faults = load_apart(path)
    assert seconds < 0.1
    assert megabytes < 100
    assert "found more than 256 kB" in faults[0]
