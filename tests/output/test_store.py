"""Atomic artefacts and CSV text."""

import subprocess
import sys
from hashlib import sha256

import pytest

from camcli.errors import SceneError
from camcli.output.run_folder import Store
from camcli.output.tables import number_rows


def test_a_failed_write_leaves_the_old_file_and_no_litter(tmp_path):
    store = Store(tmp_path)
    store.write_text("a.csv", ["old\n"])
    store.commit()

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


LOCK = "import sys; from pathlib import Path; from camcli.output.run_folder import Store\n"


def other(folder, code: str) -> subprocess.CompletedProcess:
    """Python that has the folder's store as `s`, in another process."""
    code = LOCK + f"s = Store(Path({str(folder)!r}))\n{code}"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


def test_one_process_at_a_time_has_the_folder(tmp_path):
    with Store(tmp_path):
        done = other(tmp_path, "")
        assert done.returncode == 1
        assert "another run at work here" in done.stderr
        with pytest.raises(SceneError, match="another run"):
            Store(tmp_path)
    assert other(tmp_path, "").returncode == 0


def test_a_lock_ends_with_its_process(tmp_path):
    assert other(tmp_path, "import os; os.kill(os.getpid(), 9)").returncode == -9
    Store(tmp_path).close()


def test_nothing_is_in_its_place_before_the_commit(tmp_path):
    (tmp_path / "b.csv").write_text("old")
    (tmp_path / "c.png").write_text("old")
    with Store(tmp_path) as store:
        store.write_text("a.csv", ["new"])
        store.write_text("b.csv", ["first"])
        store.write_text("b.csv", ["new"])
        store.remove("c.png")
        store.remove("absent.png")
        assert {p.name: p.read_text() for p in tmp_path.glob("[a-z]*")} == {
            "b.csv": "old", "c.png": "old",
        }  # fmt: skip
        store.commit()
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"a.csv": "new", "b.csv": "new"}
    assert store.hashes["b.csv"] == sha256(b"new").hexdigest()


def test_without_a_commit_all_is_as_before(tmp_path):
    (tmp_path / "b.csv").write_text("old")
    with Store(tmp_path) as store:
        store.write_text("b.csv", ["new"])
        store.remove("b.csv")
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"b.csv": "old"}


def test_leftovers_of_a_killed_run_go(tmp_path):
    code = "s.write_text('a.csv', ['x'])\nimport os; os.kill(os.getpid(), 9)"
    assert other(tmp_path, code).returncode == -9
    assert [p.name for p in tmp_path.iterdir()] == [".a.csv.part"]
    Store(tmp_path).close()
    assert list(tmp_path.iterdir()) == []


def test_a_commit_that_cannot_be_is_said_in_words(tmp_path):
    with Store(tmp_path) as store:
        store.write_text("a.csv", ["new"])
        store.remove("folder")
        (tmp_path / "folder").mkdir()
        with pytest.raises(SceneError, match="folder could not be written"):
            store.commit()
    with Store(tmp_path) as store:
        store.write_text("folder", ["new"])
        with pytest.raises(SceneError, match="folder could not be written"):
            store.commit()
    assert [p.name for p in tmp_path.iterdir()] == ["folder"]
