"""Memory does not grow with the length of a sweep."""

import os
import subprocess
import sys

import pytest

ROOM = 10_000_000  # bytes: the records of the longer sweep take 77 MB more, beyond what is kept


def peak(folder, points: int) -> int:
    """Peak memory of a sweep, bytes."""
    words = f"sweep --rpm 690:735 --points {points} --quiet --no-plot --threads 1"
    turns = "--set run.transient=0 --set run.record=1600"
    command = [sys.executable, "-m", "camcli", *words.split(), *turns.split()]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@pytest.mark.soak
def test_twice_the_speeds_take_the_same_memory(tmp_path):
    assert peak(tmp_path, 1400) - peak(tmp_path, 700) < ROOM
