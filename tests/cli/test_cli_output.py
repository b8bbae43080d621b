"""A stdout that fails costs no artefact."""

import os
import subprocess
import sys

import pytest

SWEEP = ("sweep", "--points", "3", "--no-plot", "--quiet")
TURNS = ("--set", "run.transient=5", "--set", "run.record=20")
MADE = {"impacts.csv", "strobe.csv", "speeds.csv", "run.json"}


def cam(folder, *words: str, **options) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "camcli", *words]
    return subprocess.run(command, cwd=folder, stderr=subprocess.PIPE, **options)


def made(folder):
    return {path.name for path in (folder / "out/sweep").iterdir()}


def test_a_reader_that_leaves(tmp_path):
    ours, theirs = os.pipe()
    os.close(ours)
    done = cam(tmp_path, *SWEEP, *TURNS, stdout=theirs)
    os.close(theirs)
    assert (done.returncode, done.stderr) == (0, b"")
    assert made(tmp_path) == MADE


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no full device here")
def test_a_full_disk_under_stdout(tmp_path):
    with open("/dev/full", "wb") as full:
        done = cam(tmp_path, *SWEEP, *TURNS, stdout=full)
    assert done.returncode == 2
    assert done.stderr.startswith(b"stdout: could not be written (No space left on device)")
    assert made(tmp_path) == MADE


@pytest.mark.parametrize("words", [SWEEP + TURNS, ("--help",)])
def test_no_stdout_at_all(tmp_path, words):
    done = cam(tmp_path, *words, preexec_fn=lambda: os.close(1))
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_folder_with_an_endless_name(tmp_path):
    done = cam(tmp_path, *SWEEP, "-o", "a" * 300, stdout=subprocess.DEVNULL)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert b"File name too long" in line
