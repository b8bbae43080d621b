"""Memory does not grow with the length of a sweep."""

import os
import subprocess
import sys

import pytest

ROOM = 10_000_000  # bytes: the records of the longer sweep take 77 MB more, beyond what is kept


def peak(folder, points: int, rpm: str = "690:735", record: int = 1600) -> int:
    """Peak memory of a sweep, bytes; record: turns."""
    words = f"sweep --rpm {rpm} --points {points} --quiet --no-plot --threads 1"
    words += f" --set run.transient=0 --set run.record={record} --set sweep.tables=npz"
    command = [sys.executable, "-m", "camcli", *words.split()]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


@pytest.mark.soak
def test_twice_the_speeds_take_the_same_memory(tmp_path):
    assert peak(tmp_path, 1400) - peak(tmp_path, 700) < ROOM


@pytest.mark.slow
@pytest.mark.ci
def test_a_speed_more_takes_some_tens_of_bytes(tmp_path):
    """Where its piece is, its value, its place in the order: 8 to 24 bytes each.

    Short motions of a follower that never leaves the cam, more than may be kept in memory. The room
    is for what the operating system counts besides; it was 1100 bytes, and where all pieces stay in
    memory it is 2300.
    """
    few, many = 15_000, 25_000
    growth = peak(tmp_path, many, "50:100", 2) - peak(tmp_path, few, "50:100", 2)
    assert growth < 300 * (many - few)
