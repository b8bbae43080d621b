"""The folder of a run: whole artefacts, locks that end, pieces that stay until the commit."""

import errno
import fcntl
import json
import multiprocessing
import os
import stat
import subprocess
import sys
import threading
from hashlib import sha256
from math import inf, nan

import grimp
import pytest

from camcli.api import ANALYSES
from camcli.errors import SceneError
from camcli.output import program
from camcli.output.program import PICTURES, RESULTS, program_hash
from camcli.output.run_folder import (
    _locked,
    _name_of_pieces,
    _prepare,
    _remove,
    run_folder,
    unchanged,
)
from camcli.output.run_record import to_text
from camcli.parallel import Codec, Shard
from camcli.parallel.checkpoint import key_of
from camcli.piece_faults import PieceFault, fault_records
from tests.support.clocks import time_passes

KEY = {"command": "sweep", "scene": {"rpm": 700.0}}
PLAIN = Codec(lambda result: result, lambda stored: stored)


def content(folder) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def finished_run(folder, **files: str) -> None:
    """A run with a record, as every command writes it."""
    with run_folder(folder) as run:
        for name, text in files.items():
            run.write_text(name.replace("_", "."), [text])
        run.write_text("run.json", [json.dumps({"artefacts": run.hashes})])
        run.commit()


def test_what_is_on_disk_when_the_power_goes(tmp_path, monkeypatch):
    synced = []

    def fsync(handle: int) -> None:
        kept = len(list(tmp_path.glob(".*.pieces")))
        synced.append((stat.S_ISDIR(os.fstat(handle).st_mode), kept))

    monkeypatch.setattr(os, "fsync", fsync)
    time_passes(monkeypatch)
    with run_folder(tmp_path, KEY) as run:
        list(run.work.run(abs, [1, 2], PLAIN))
        assert synced == [(False, 1)] * 2
        run.write_text("a.csv", ["new"])
        run.commit()
    assert synced[2:] == [(False, 1), (True, 1)]  # the artefact, then the folder with its name


@pytest.fixture
def full_disk(monkeypatch):
    """A disk that has no room for the text `second`."""
    fsync = os.fsync

    def full(handle: int) -> None:
        if os.fstat(handle).st_size == len("second"):
            raise OSError(errno.ENOSPC, "No space left on device")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", full)


@pytest.mark.usefixtures("full_disk")
def test_what_the_disk_refuses_is_told_by_the_name_of_its_file(tmp_path):
    with run_folder(tmp_path) as run:
        for name, text in (("a.csv", "1st"), ("b.csv", "second"), ("c.csv", "3rd")):
            run.write_text(name, [text])
        assert run.names == ["a.csv", "b.csv", "c.csv"]
        with pytest.raises(SceneError, match=r"b\.csv could not be written \(No space left"):
            run.commit()
        assert list(run.hashes) == ["a.csv", "c.csv"]
        assert run.hashes["c.csv"] == sha256(b"3rd").hexdigest()
        assert not list(tmp_path.glob("*b.csv*"))
    assert not list(tmp_path.iterdir())  # nothing was committed


@pytest.mark.usefixtures("full_disk")
def test_a_second_record_waits_for_the_disk_as_well(tmp_path):
    with run_folder(tmp_path) as run:
        run.write_text("run.json", ["1st"])
        run.commit()
        with pytest.raises(SceneError, match=r"run\.json could not be written \(No space left"):
            run.replace_record("second")
        assert content(tmp_path) == {"run.json": "1st"}
        run.replace_record("3rd")
    assert content(tmp_path) == {"run.json": "3rd"}


def test_a_write_or_a_commit_that_fails_leaves_all_as_before(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "a.csv").write_text("old")

    def broken():
        yield "new"
        raise RuntimeError("stopped in the middle")

    def full(file):
        raise OSError(errno.ENOSPC, "No space left on device")

    with run_folder(tmp_path) as run:
        with pytest.raises(RuntimeError, match="stopped"):
            run.write_text("a.csv", broken())
        with pytest.raises(SceneError, match="No space left"):
            run.write("a.csv", full)
        run.write_text("folder", ["new"])
        run.write_text("a.csv", ["new"])
        with pytest.raises(SceneError, match="folder could not be written"):
            run.commit()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "folder"]
    assert (tmp_path / "a.csv").read_text() == "old"


def test_only_unchanged_artefacts_of_the_run_before_go(tmp_path):
    finished_run(tmp_path, a_csv="1", b_png="1", c_csv="1", d_csv="1")
    (tmp_path / "d.csv").write_text("changed by somebody")
    (tmp_path / "e.png").write_text("somebody's own")
    (tmp_path / ".x.part").write_text("somebody's download")
    finished_run(tmp_path, a_csv="2", c_csv="1")
    left = {"a.csv", "c.csv", "d.csv", "e.png", "run.json", ".x.part"}
    assert set(content(tmp_path)) == left
    with run_folder(tmp_path) as run:  # without a record of its own it replaces no run
        run.write_text("note.txt", ["x"])
        run.commit()
    assert set(content(tmp_path)) == {*left, "note.txt"}


def test_pictures_that_are_kept_stay_and_others_of_the_run_before_go(tmp_path):
    finished_run(tmp_path, a_csv="1", b_png="1", c_png="1")
    with run_folder(tmp_path) as run:
        run.write_text("a.csv", ["2"])
        run.write_text("run.json", ["{}"])
        run.commit(kept=["b.png"])
        assert run.removed == ["c.png"]
    assert content(tmp_path) == {"a.csv": "2", "b.png": "1", "run.json": "{}"}
    with run_folder(tmp_path) as run:
        run.write_text("d.csv", ["3"])
        run.commit()  # without a record nothing goes
        run.replace_record('{"x": 1}')
    left = {"a.csv": "2", "b.png": "1", "d.csv": "3", "run.json": '{"x": 1}'}
    assert content(tmp_path) == left


def test_a_link_to_the_same_bytes_is_no_artefact_and_a_record_may_be_alone(tmp_path):
    finished_run(tmp_path / "alone")
    with run_folder(tmp_path / "alone", names=["a.csv"]) as run:
        assert run.before == {}
    there = tmp_path / "there"
    finished_run(there, a_csv="1", b_csv="1")
    (there / "a.csv").unlink()
    (there / "a.csv").symlink_to("b.csv")
    with run_folder(there) as run:
        assert run.before == {"b.csv": sha256(b"1").hexdigest()}


def test_what_somebody_changes_while_a_run_is_at_work_stays(tmp_path):
    finished_run(tmp_path, a_csv="1", b_csv="2")
    with run_folder(tmp_path) as run:
        (tmp_path / "b.csv").write_text("of somebody")
        run.write_text("run.json", ["{}"])
        run.commit()
        assert run.removed == ["a.csv"]
    assert content(tmp_path) == {"b.csv": "of somebody", "run.json": "{}"}


def test_a_file_has_the_bytes_that_are_listed_under_its_own_name(tmp_path):
    hashes = {name: sha256(name.encode()).hexdigest() for name in "abc"}
    for name, text in (("a", "b"), ("b", "a"), ("c", "c")):
        (tmp_path / name).write_text(text)
    assert unchanged(tmp_path, hashes) == {"c": hashes["c"]}


def test_a_link_that_leads_nowhere_is_no_free_place(tmp_path):
    (tmp_path / "a.csv").symlink_to("nowhere")
    with (
        pytest.raises(SceneError, match=r"found a\.csv, which no run has left"),
        run_folder(tmp_path, names=["a.csv"]),
    ):
        pass


def test_folders_that_a_run_has_made_go_with_it_where_nothing_is_written(tmp_path):
    folder = tmp_path / "a" / "b"
    with run_folder(folder):
        assert folder.is_dir()
    assert list(tmp_path.iterdir()) == []
    assert _prepare(folder) == [folder, tmp_path / "a"]
    assert _prepare(folder) == []


def test_pieces_are_those_of_a_key_in_whatever_order_it_is_written(tmp_path):
    for key in (KEY, dict(reversed(KEY.items()))):
        with run_folder(tmp_path, key) as run:
            list(run.work.run(abs, [1], PLAIN))
        assert run.resumed == (0 if key is KEY else 1)
        assert len(list(tmp_path.glob(".sweep-*.pieces"))) == 1


def test_what_is_written_is_listed_with_its_hash_as_it_was_written_last(tmp_path):
    def refuse(file):
        file.write(b"half")
        raise OSError(errno.EIO, "of its own")

    with run_folder(tmp_path) as run:
        for name, text in (("b", "1"), ("a", "2"), ("c", "3"), ("b", "4")):
            run.write_text(name, [text, "ä"])
        assert run.names == ["a", "c", "b"]
        with pytest.raises(OSError, match="of its own"):  # not one of the folder
            run.write_whole("d", refuse)
        run.write_whole("e", lambda file: file.write(b"5"))
        written = {"a": "2ä", "c": "3ä", "b": "4ä", "e": "5"}
        hashes = {name: sha256(text.encode()).hexdigest() for name, text in written.items()}
        assert list(run.hashes.items()) == list(hashes.items())
        assert content(tmp_path).keys() == {f".{name}.cam-part" for name in written}
        run.commit()
    assert content(tmp_path) == written


def test_the_file_of_a_shard_says_what_it_belongs_to_and_what_it_lacks(tmp_path):
    fault = PieceFault("a piece", "an error", "a place", "a traceback")
    with run_folder(tmp_path, KEY, shard=Shard(2, 3), about={"plan": "x", "shard": 0}) as run:
        run.work.faults.append(fault)
        run.work.collect(abs, [1, 2, 3], PLAIN)
    key, end = key_of(tmp_path / "sweep-2-of-3.pieces")
    assert json.loads(key) == {**KEY, "program_sha256": program_hash()}
    assert end == {"plan": "x", "shard": [2, 3], "piece_faults": fault_records([fault])}
    with run_folder(tmp_path, KEY, shard=Shard(1, 3)) as run:
        run.work.collect(abs, [1, 2, 3], PLAIN)
    assert key_of(tmp_path / "sweep-1-of-3.pieces") == (key, {"shard": [1, 3]})


def test_files_that_no_run_has_made_are_claimed_by_none(tmp_path):
    finished_run(tmp_path, a_csv="1", d_csv="1")
    (tmp_path / "d.csv").write_text("changed by somebody")
    (tmp_path / "e.png").symlink_to("a.csv")
    with run_folder(tmp_path, names=["a.csv", "f.csv"]):
        pass
    names = ["a.csv", "d.csv", "e.png"]
    with pytest.raises(SceneError) as caught, run_folder(tmp_path, names=names):
        raise AssertionError("not reached")
    assert [fault.found.split()[1] for fault in caught.value.faults] == ["d.csv,", "e.png,"]
    (tmp_path / "run.json").write_text("{}")
    with pytest.raises(SceneError, match=r"run\.json"), run_folder(tmp_path, names=["f.csv"]):
        raise AssertionError("not reached")


def test_a_record_that_lies_removes_nothing(tmp_path):
    out = tmp_path / "out"
    out.mkdir()
    (tmp_path / "precious").write_text("x")
    digest = sha256(b"x").hexdigest()
    (out / "deeper").mkdir()
    paths = {"../precious": digest, str(tmp_path / "precious"): digest, "deeper": digest, "..": ""}
    for text in (json.dumps({"artefacts": paths}), "[]", "[" * 100_000, '{"artefacts": 3}', ""):
        (out / "run.json").write_text(text)
        finished_run(out, a_csv="1")
    assert (tmp_path / "precious").exists()
    assert (out / "deeper").exists()


def test_one_run_at_a_time_has_the_folder_in_one_process(tmp_path):
    refused = []

    def second() -> None:
        with pytest.raises(SceneError, match="another run"), run_folder(tmp_path, KEY):
            pass
        refused.append(True)

    with run_folder(tmp_path, KEY):
        thread = threading.Thread(target=second)
        thread.start()
        thread.join()
        second()
    assert refused == [True, True]
    for _ in range(2):  # a run that has finished, or failed, has left no lock
        with pytest.raises(RuntimeError), run_folder(tmp_path, KEY):
            raise RuntimeError


OTHER = """
import os
from pathlib import Path
from camcli.output.run_folder import _prepare, run_folder, unchanged
with run_folder(Path({!r})) as run:
    run.write_text("a.csv", ["x"])
    os.kill(os.getpid(), {})
"""


def test_other_processes_are_refused_and_those_killed_leave_nothing(tmp_path):
    def other(signal: int) -> subprocess.CompletedProcess:
        code = OTHER.format(str(tmp_path), signal)
        return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)

    with run_folder(tmp_path):
        done = other(0)
        assert (done.returncode, "another run at work here" in done.stderr) == (1, True)
    assert other(9).returncode == -9
    assert [path.name for path in tmp_path.iterdir()] == [".a.csv.cam-part"]
    with run_folder(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_only_ends_like_an_unfinished_one_is_somebody_elses(tmp_path):
    """What a run that was killed has left begins with a dot, too."""
    for name in ("mine.cam-part", ".of a run.cam-part"):
        (tmp_path / name).write_text("x")
    with run_folder(tmp_path):
        assert content(tmp_path) == {"mine.cam-part": "x"}


@pytest.mark.parametrize("shard", [None, Shard(1, 2)])
def test_a_folder_in_the_place_of_the_pieces_is_told(tmp_path, shard):
    key = json.dumps({**KEY, "program_sha256": program_hash()}, sort_keys=True)
    name = _name_of_pieces("sweep", key, shard)
    (tmp_path / name).mkdir()
    refused = pytest.raises(SceneError, match=rf"{name}.*\(Is a directory\)")
    with refused, run_folder(tmp_path, KEY, shard=shard):
        raise AssertionError("not reached")


def test_a_lock_is_not_asked_of_what_has_none_nor_of_what_is_gone(tmp_path, monkeypatch):
    """A file system may know no locks; what another run has removed meanwhile is not locked."""

    def none_here(handle: int, how: int) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    with _locked(tmp_path / "gone") as still_there:
        assert not still_there
    with _locked(tmp_path) as still_there:
        assert still_there
    monkeypatch.setattr(fcntl, "flock", none_here)
    with _locked(tmp_path) as still_there:
        assert still_there
    _remove(tmp_path / "gone")


def test_a_shard_ends_early_and_shards_share_a_folder(tmp_path):
    with run_folder(tmp_path, KEY, shard=Shard(1, 2)) as one:
        with run_folder(tmp_path, KEY, shard=Shard(2, 2)) as two:
            two.work.collect(abs, [1, 2, 3], PLAIN)
        again = run_folder(tmp_path, KEY, shard=Shard(1, 2))
        with pytest.raises(SceneError, match="another run"), again:
            pass
        one.work.collect(abs, [1, 2, 3], PLAIN)
        raise AssertionError("not reached")
    assert one.shard_done
    assert two.shard_done
    parts = tuple(sorted(tmp_path.iterdir()))
    assert [path.name for path in parts] == ["sweep-1-of-2.pieces", "sweep-2-of-2.pieces"]
    with run_folder(tmp_path / "all", KEY, parts=parts) as run:
        assert run.resumed == 3


def test_the_program_is_what_can_change_a_number():
    import camcli

    folders = {name for name in RESULTS if not name.endswith(".py")}
    package = os.path.dirname(camcli.__file__)
    assert all(os.path.exists(os.path.join(package, name)) for name in (*RESULTS, *PICTURES))
    assert {"kernel", "cams", "analysis", "exact", "parallel"} <= folders
    assert not {"cli", "plots", "output"} & folders
    assert program_hash() != program_hash(pictures=True)
    graph = grimp.build_graph("camcli", exclude_type_checking_imports=True)
    used = set()
    for command in ANALYSES:
        used |= graph.find_upstream_modules(f"camcli.api.{command}")
    parts = {name.split(".")[1] for name in used if "." in name}
    known = {name.removesuffix(".py") for name in (*RESULTS, *PICTURES)}
    # one only ends a run, the other says in run.json what is installed
    assert parts - known == {"interrupts", "installed"}


def test_every_source_counts_in_the_hash_of_the_program(tmp_path, monkeypatch):
    """In a package of few files: each of them changed, one more, one under another name."""
    folders = [name for name in RESULTS if not name.endswith(".py")]
    numbers = [name for name in RESULTS if name.endswith(".py")]
    for folder in folders:
        numbers += [f"{folder}/{name}" for name in ("__init__.py", "a.py", "part/b.py", "z.py")]
    drawn = [f"{name}/{file}" for name in PICTURES for file in ("a.py", "b.mplstyle")]
    others = ["cli/a.py", "guide/a.md", f"{folders[0]}/a.txt", f"{folders[0]}/__pycache__/a.py"]
    for name in (*numbers, *drawn, *others):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(program, "__file__", str(tmp_path / "output/program.py"))

    def hashes():
        return program_hash.__wrapped__(), program_hash.__wrapped__(pictures=True)

    before = hashes()
    for name in (*numbers, *drawn, *others):
        (tmp_path / name).write_text("changed")
        changed = tuple(new != old for new, old in zip(hashes(), before, strict=True))
        assert changed == (name in numbers, name in (*numbers, *drawn)), name
        (tmp_path / name).write_text(name)
    assert hashes() == before
    last = tmp_path / folders[-1] / "z.py"
    for folder in folders:
        more = tmp_path / folder / "more.py"
        more.touch()
        assert hashes() != before
        more.unlink()
    last.rename(last.with_name("y.py"))
    assert hashes()[0] != before[0]


PAIRS, RUNS = 150, 3


def racer(folder, barrier, results) -> None:
    """Runs that begin at once with others, each pair in a new folder; some fail at once."""
    for pair in range(PAIRS):
        place = folder / str(pair) / "new"
        barrier.wait()
        try:
            with run_folder(place) as run:
                if pair % 3 == 2:
                    raise ValueError("nothing was written")
                run.write_text("a.csv", ["whole"])
                run.write_text("run.json", [json.dumps({"artefacts": run.hashes})])
                run.commit()
            results.put((pair, "whole"))
        except SceneError as error:
            results.put((pair, error.faults[0].found))
        except ValueError:
            results.put((pair, "failed"))
        except Exception as error:
            results.put((pair, repr(error)))


def test_of_runs_that_begin_at_once_in_a_new_folder_one_is_whole(tmp_path):
    """Each of the others is refused, or comes after it: nobody's folder is removed under him."""
    fork = multiprocessing.get_context("fork")
    barrier, results = fork.Barrier(RUNS), fork.Queue()
    runs = [
        fork.Process(target=racer, args=(tmp_path, barrier, results), daemon=True)
        for _ in range(RUNS)
    ]
    for run in runs:
        run.start()
    ends: dict[int, list[str]] = {}
    for _ in range(RUNS * PAIRS):
        pair, end = results.get(timeout=60)
        ends.setdefault(pair, []).append(end)
    for run in runs:
        run.join()
    for pair, found in ends.items():
        there = tmp_path / str(pair) / "new"
        wanted = "failed" if pair % 3 == 2 else "whole"
        assert wanted in found
        assert set(found) <= {wanted, "found another run at work here"}
        if wanted == "whole":
            assert sorted(path.name for path in there.iterdir()) == ["a.csv", "run.json"]


def test_a_picture_is_kept_only_with_the_same_numbers_of_the_same_scene(tmp_path):
    with run_folder(tmp_path) as run:
        run.write_text("a.csv", ["1"])
        run.write_text("b.png", ["drawn"])
        record = {"artefacts": run.hashes, "scene_sha256": "scene-of-1"}
        run.write_text("run.json", [json.dumps(record)])
        run.commit()
    drawn = sha256(b"drawn").hexdigest()
    for number, scene, kept in (("1", "scene-of-1", {"b.png": drawn}), ("2", "scene-of-1", {}),
                                ("1", "scene-of-2", {})):  # fmt: skip
        with run_folder(tmp_path) as run:
            run.write_text("a.csv", [number])
            assert run.keep_pictures(["b.png"], scene) == kept


def test_what_a_run_left_that_was_killed_in_its_commit_is_told(tmp_path):
    """Its record was written beside: what it lists and the one before does not is mixed in."""
    finished_run(tmp_path, a_csv="1", b_csv="1")
    (tmp_path / "b.csv").write_text("2")
    (tmp_path / "c.csv").write_text("2")
    made = {"a.csv": b"1", "b.csv": b"2", "c.csv": b"2", "d.csv": b"2"}
    hashes = {name: sha256(text).hexdigest() for name, text in made.items()}
    part = ".run.json.cam-part"
    (tmp_path / part).write_text(json.dumps({"artefacts": hashes}))
    with run_folder(tmp_path, names=["a.csv", "b.csv", "c.csv"]) as run:
        assert run.mixed == ["b.csv", "c.csv"]
        assert set(run.before) == {"a.csv"}


def test_the_text_of_a_record_has_every_number_in_the_form_that_json_knows():
    record = {"a": (1, [inf, -inf, nan]), "b": 0.5 - 2j, "c": {"d": None, "e": complex(inf, 0)}}
    text = to_text(record)
    assert text.endswith("\n}\n")
    assert text.splitlines()[1].startswith('  "a": [')
    assert json.loads(text) == {
        "a": [1, ["inf", "-inf", None]],
        "b": [0.5, -2.0],
        "c": {"d": None, "e": ["inf", 0.0]},
    }


def test_only_hidden_files_of_a_run_that_was_killed_are_removed(tmp_path):
    for name in (".a.csv.cam-part", "mine.cam-part", ".cam-part-notes"):
        (tmp_path / name).write_text("begun")
    finished_run(tmp_path, b_csv="whole")
    assert {path.name for path in tmp_path.iterdir()} >= {
        "mine.cam-part", ".cam-part-notes", "b.csv", "run.json",
    }  # fmt: skip
    assert not (tmp_path / ".a.csv.cam-part").exists()
