"""A stdout that fails costs no artefact."""

import os
import subprocess
import sys

import pytest

SWEEP = [sys.executable, "-m", "camcli", "sweep", "--points", "3", "--no-plot", "--quiet"]
TURNS = ["--set", "run.transient=5", "--set", "run.record=20"]
MADE = {"impacts.csv", "strobe.csv", "speeds.csv", "run.json"}


def made(folder):
    return {path.name for path in (folder / "out/sweep").iterdir()}


def test_a_reader_that_leaves(tmp_path):
    ours, theirs = os.pipe()
    os.close(ours)
    done = subprocess.run([*SWEEP, *TURNS], cwd=tmp_path, stdout=theirs, stderr=subprocess.PIPE)
    os.close(theirs)
    assert (done.returncode, done.stderr) == (0, b"")
    assert made(tmp_path) == MADE


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no full device here")
def test_a_full_disk_under_stdout(tmp_path):
    with open("/dev/full", "wb") as full:
        done = subprocess.run([*SWEEP, *TURNS], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE)
    assert done.returncode == 2
    assert done.stderr.startswith(b"stdout: could not be written (No space left on device)")
    assert made(tmp_path) == MADE


@pytest.mark.parametrize("words", [SWEEP[3:] + TURNS, ["schema"], ["--help"]])
def test_no_stdout_at_all(tmp_path, words):
    command = [sys.executable, "-m", "camcli", *words]
    done = subprocess.run(
        command, cwd=tmp_path, stderr=subprocess.PIPE, preexec_fn=lambda: os.close(1)
    )
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_folder_with_an_endless_name(tmp_path):
    command = [*SWEEP, "-o", "a" * 300]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "File name too long" in line
