"""Atomic artefacts and CSV text."""

import pytest

from camcli.artefacts.store import Store
from camcli.artefacts.tables import number_rows
from camcli.errors import SceneError


def test_a_failed_write_leaves_the_old_file_and_no_litter(tmp_path):
    store = Store(tmp_path)
    store.write_text("a.csv", ["old\n"])

    def broken():
        yield "new\n"
        raise RuntimeError("stopped in the middle")

    with pytest.raises(RuntimeError):
        store.write_text("a.csv", broken())
    assert (tmp_path / "a.csv").read_text() == "old\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def test_full_disk_is_said_in_words(tmp_path):
    def full(file):
        raise OSError(28, "No space left on device")

    with pytest.raises(SceneError, match="No space left"):
        Store(tmp_path).write("a.csv", full)
    assert list(tmp_path.iterdir()) == []


def test_numbers_read_back_to_the_same_double():
    values = [0.1, 1e-300, 1 / 3, 5e22, -2.5, 1e16, 0.1]
    text = number_rows("700.5", [range(len(values)), values])
    back = [line.split(",") for line in text.splitlines()]
    assert [float(row[2]) for row in back] == values
    assert [row[:2] for row in back] == [["700.5", str(k)] for k in range(len(values))]


def test_no_rows_is_no_text():
    assert number_rows("1.0", [[], []]) == ""
