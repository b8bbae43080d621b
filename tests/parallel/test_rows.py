"""Rows of equal size come back as they were put in, and do not stay in memory."""

import errno
import os
import pickle
import tracemalloc

import pytest

from camcli.errors import SceneError
from camcli.parallel import Work
from camcli.parallel import rows as rows_module
from camcli.parallel.checkpoint import Checkpoint
from camcli.parallel.rows import NEWEST, Rows

WIDTH = 24


def row(k: int) -> bytes:
    return k.to_bytes(WIDTH, "big")


def filled(rows: Rows, count: int) -> Rows:
    for k in range(count):
        rows.append(row(k))
    return rows


@pytest.mark.parametrize("in_folder", [True, False])
@pytest.mark.parametrize("count", [0, 1, NEWEST // WIDTH, 3 * NEWEST // WIDTH + 2])
def test_each_row_comes_back(tmp_path, in_folder, count):
    rows = filled(Rows(WIDTH, tmp_path if in_folder else None), count)
    for found in (rows, pickle.loads(pickle.dumps(rows))):
        assert len(found) == count
        assert [bytes(found[k]) for k in range(count)] == list(map(row, range(count)))
    assert not list(tmp_path.iterdir())  # the file has no name


def test_all_rows_of_a_folder_are_in_one_file_on_its_disk(tmp_path, monkeypatch):
    """The disk of temporary files may be a part of the memory."""
    made = []
    create = rows_module.TemporaryFile
    monkeypatch.setattr(
        rows_module, "TemporaryFile", lambda **how: made.append(how["dir"]) or create(**how)
    )
    filled(Rows(WIDTH, tmp_path), 3 * NEWEST // WIDTH)
    assert made == [tmp_path]
    filled(Rows(WIDTH), 3 * NEWEST // WIDTH)
    assert made == [tmp_path]


def test_rows_of_a_run_with_pieces_are_on_disk(tmp_path):
    """Ten times as many take no more memory."""
    count = 4 * NEWEST // WIDTH
    checkpoint = Checkpoint(tmp_path / "x.pieces", "key")
    taken = []
    for times in (1, 10):
        tracemalloc.start()
        rows = filled(Work(checkpoint=checkpoint).rows(WIDTH), times * count)
        taken.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        assert bytes(rows[times * count - 1]) == row(times * count - 1)
    checkpoint.close()
    assert taken[1] < taken[0] + NEWEST


def test_a_full_disk_is_told(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(SceneError) as told:
        filled(Rows(WIDTH, tmp_path), NEWEST // WIDTH + 1)
    assert "could not be written (No space left on device)" in str(told.value)
    assert "make room" in str(told.value)


@pytest.mark.parametrize("most", [1000, WIDTH * 41, 60_001])
def test_a_system_that_writes_a_part_at_a_time_loses_no_row(tmp_path, monkeypatch, most):
    """A part may end within a row; the next one begins behind it."""
    write = os.write
    parts = []

    def in_parts(handle: int, data: bytearray) -> int:
        parts.append(len(data))
        return write(handle, bytes(data[: most + len(parts)]))

    monkeypatch.setattr(os, "write", in_parts)
    count = 2 * NEWEST // WIDTH + 7
    rows = filled(Rows(WIDTH, tmp_path), count)
    assert len(rows) == count
    assert [bytes(rows[k]) for k in range(count)] == list(map(row, range(count)))
    assert len(parts) >= 4
