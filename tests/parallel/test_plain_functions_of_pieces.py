"""Functions behind pieces of work, each asked alone: a cluster's chunks, sizes, kept results."""

from __future__ import annotations

import errno
import os
from contextlib import nullcontext
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.errors import SceneError
from camcli.parallel import Checkpoint, Work, checkpoint, dask_cluster, work
from camcli.parallel.dask_cluster import DaskCluster, OtherProgramError
from camcli.parallel.work import BESIDE, Codec, Kept
from camcli.piece_faults import PieceFault


class Future:
    """A chunk that a worker has done: so many seconds, and the results."""

    def __init__(self, seconds: float, results: list) -> None:
        self.result = lambda: (seconds, results)


class Workers:
    """A scheduler that runs what it is given at once."""

    def __init__(self, threads: dict[str, int]) -> None:
        self.threads = threads
        self.chunks = []

    def nthreads(self):
        return self.threads

    def submit(self, run, task, chunk, program, pure):
        assert pure is False
        self.chunks.append(chunk)
        _, results = run(task, chunk, program)
        return Future(0.05 * len(chunk), results)


def test_results_of_a_cluster_come_in_order_whichever_chunk_is_done_first(monkeypatch):
    """The last of the chunks that run is done first; each result is kept by its own number."""
    workers = Workers({"a": 2, "b": 1})
    monkeypatch.setattr(dask_cluster, "_finished", lambda running: list(running)[-1:])
    monkeypatch.setattr(dask_cluster, "_faults_of_a_cluster", nullcontext)
    cluster = DaskCluster.__new__(DaskCluster)
    cluster.client, cluster.program, cluster.lonely = workers, None, 0.0
    kept = []
    pieces = range(100, 300)
    results = cluster.results(lambda x: 3 * x, pieces, lambda k, result: kept.append((k, result)))
    assert next(results) == 300
    assert len(workers.chunks) == 12  # those that wait for their turn count, too
    assert list(results) == [3 * x for x in pieces[1:]]
    assert sorted(kept) == [(k, 3 * (100 + k)) for k in range(200)]
    assert kept != sorted(kept)
    assert workers.chunks[:12] == [[100 + k] for k in range(12)]  # four for each of three threads
    assert max(map(len, workers.chunks)) == 8  # 200 pieces for 3 threads, 8 chunks for each


def test_chunks_of_a_cluster_that_grows_slow_are_small_again(monkeypatch):
    workers = Workers({"a": 1})
    submit = workers.submit
    monkeypatch.setattr(dask_cluster, "_finished", lambda running: list(running)[:1])
    monkeypatch.setattr(dask_cluster, "_faults_of_a_cluster", nullcontext)

    def slower(run, task, chunk, program, pure):
        done = submit(run, task, chunk, program, pure)
        slow = chunk[0] >= 60
        return Future((3.0 if slow else 0.001) * len(chunk), done.result()[1])

    workers.submit = slower
    cluster = DaskCluster.__new__(DaskCluster)
    cluster.client, cluster.program, cluster.lonely = workers, None, 0.0
    assert list(cluster.results(str, range(160), lambda k, result: None)) == [
        str(k) for k in range(160)
    ]
    sizes = [len(chunk) for chunk in workers.chunks]
    assert (sizes[0], max(sizes), sizes[-1]) == (1, 20, 1)


def test_a_cluster_is_given_up_after_a_minute_without_workers(monkeypatch):
    cluster = DaskCluster.__new__(DaskCluster)
    cluster.client, cluster.lonely = Workers({"a": 2, "b": 3}), 0.0
    now = 100.0
    monkeypatch.setattr(dask_cluster, "monotonic", lambda: now)
    assert (cluster._slots(), cluster.lonely) == (5, 100.0)
    cluster.client = Workers({})
    now = 160.0
    assert (cluster._slots(), cluster.lonely) == (1, 100.0)
    now = 160.5
    with pytest.raises(SceneError, match="found no worker for 60 s") as refused:
        cluster._slots()
    (fault,) = refused.value.faults
    assert fault.cure == "start workers and repeat the command: finished pieces are on disk"


def test_a_worker_runs_the_pieces_of_a_chunk_in_order_with_the_same_program_alone():
    seconds, results = dask_cluster._run(str, [3, 1, 2], None)
    assert results == ["3", "1", "2"]
    assert 0.0 <= seconds < 1.0
    assert dask_cluster._run(str, [3], (lambda: "x", "x"))[1] == ["3"]
    with pytest.raises(OtherProgramError):
        dask_cluster._run(str, [3], (lambda: "x", "y"))


def test_the_newest_place_of_a_piece_counts_whatever_its_number(tmp_path):
    """Also of one whose number was far beyond the others when it came, and is no more."""
    index = checkpoint._Index()
    paths = tmp_path / "a", tmp_path / "b"
    index.set(("x", 1500), paths[0], 1, 2)
    index.set(("x", -1), paths[0], 2, 3)
    for number in range(300):
        index.set(("x", number), paths[0], 3 + number, 4 + number)
    index.set(("y", 2), paths[1], 5, 6)
    index.set(("x", 1500), paths[1], 7, 9)
    index.set(("x", 7), paths[1], 9, 11)
    assert index["x", 1500] == (paths[1], 7, 9)
    assert index["x", 7] == (paths[1], 9, 11)
    assert (index["x", 8], index["x", -1]) == ((paths[0], 11, 12), (paths[0], 2, 3))
    assert (index.count("x"), index.count("y"), len(index)) == (302, 1, 303)
    assert [name in index for name in (("x", 300), ("y", 0), ("y", 2), ("z", 0))] == [0, 0, 1, 0]
    index.clear()
    assert [name in index for name in (("x", 1500), ("x", 7), ("y", 2))] == [0, 0, 0]
    assert (len(index), index.count("x")) == (0, 0)


# -- pieces that are kept ----------------------------------------------------------------------


def test_the_bytes_of_arrays_are_counted_at_every_depth():
    three, five = np.zeros(3, "<i4"), np.zeros((5, 2), "<f8")
    assert checkpoint._bytes_of({"a": [three, (five, "text")], "b": 7, "c": {"d": three}}) == 104
    assert checkpoint._bytes_of("abc") == checkpoint._bytes_of([]) == 0


def test_the_size_of_a_run_is_told_from_its_pieces_so_far(tmp_path):
    kept = Checkpoint(tmp_path / "x.pieces", "key")
    assert kept.expected_size(10, 100) == 0.0
    kept.put("0", 0, np.zeros(4))  # 32 bytes, which wait in memory
    kept.put("0", 1, np.zeros(6))
    assert kept.expected_size(2, 100) == 80 + 200
    assert kept.expected_size(7, 100) == 3.5 * 280
    assert kept.expected_size(1, 100) == 280  # there are two
    assert kept.pieces == 2
    kept.put(checkpoint.END, 0, {})
    assert kept.pieces == 2
    kept.get("0", 0)
    assert kept.pieces == 2
    assert (("0", 1) in kept, ("0", 2) in kept, ("1", 0) in kept) == (True, False, False)
    on_disk = (tmp_path / "x.pieces").stat().st_size
    assert kept.size < on_disk  # the first record is nobody's piece
    assert kept.expected_size(3, 7) == kept.size + 3 * 7
    kept.discard()


def test_some_entries_of_a_piece_are_read_alone(tmp_path):
    kept = Checkpoint(tmp_path / "x.pieces", "key")
    value = {"a": np.arange(3), "b": [np.array([0.5, 1.5]), 7, {"x": 1}], "c": "text"}
    kept.put("0", 4, value)
    found = kept.get("0", 4, ["c", "b", "z"])
    assert list(found) == ["c", "b"]
    assert (found["b"][0].tolist(), found["b"][1:]) == ([0.5, 1.5], [7, {"x": 1}])
    assert kept.get("0", 4)["a"].tolist() == [0, 1, 2]
    kept.discard()


@pytest.mark.parametrize("sound", [True, False])
@pytest.mark.parametrize("faulty", [True, False])
def test_a_result_with_a_fault_stays_in_memory_with_what_may_depend_on_it(tmp_path, sound, faulty):
    faults = [Stub()] if faulty else []
    codec = Codec(lambda x: x + 1, lambda x: x - 1, faults=lambda _: faults)
    with_file = Checkpoint(tmp_path / "x.pieces", "key")
    kept = Work(1, with_file).within("a").within("b")._kept(codec, "pqr")
    assert kept.place == "a/b/0"
    assert kept.put(1, 40, sound) == 40
    assert kept.has(1) == (sound and not faulty) == (1 not in kept.unkept)
    assert kept[1] == kept[-2] == 40
    assert len(kept) == 3
    with_file.discard()


def test_the_faults_of_a_place_are_told_of_the_whole_run():
    fault = PieceFault.__new__(PieceFault)
    codec = Codec(str, str, faults=lambda result: [fault] if result == "b" else [])
    work = Work(1)
    part = work.within("x")
    assert list(part.collect(str, "ab", codec)) == ["a", "b"]
    assert (part.failed, work.failed) == (True, False)
    assert work.faults == part.faults == [fault]
    assert (part.calls, work.calls) == (1, 0)
    assert part._kept(codec, "ab").place == "x/1"


def test_what_is_asked_for_after_a_fault_in_its_place_is_not_kept_on_disk(tmp_path):
    codec = Codec(str, str)
    with_file = Checkpoint(tmp_path / "x.pieces", "key")
    work = Work(1, with_file)
    part = work.within("x")
    assert part._kept(codec, "ab").checkpoint is with_file
    assert part._kept(None, "ab").checkpoint is None
    part.failed = True
    assert part._kept(codec, "ab").checkpoint is None
    assert work._kept(codec, "ab").checkpoint is with_file
    with_file.discard()


def test_a_part_of_a_run_counts_its_calls_anew():
    whole = Work(1, calls=5)
    part = whole.within("a")
    assert (part._kept(None, "p").place, part._kept(None, "p").place) == ("a/0", "a/1")
    assert (whole._kept(None, "p").place, whole.within("b").place) == ("5", "b/")


@pytest.mark.parametrize(
    ("at_once", "threads", "missing", "groups", "ahead"),
    [
        (5, 2, 20, range(0, 20, 3), 5),  # four calls of each thread: 20/8, rounded up
        (2, 2, 20, range(0, 20, 2), 8),
        (5, 1, 20, range(0, 20, 5), 3),
        (5, 3, 1, range(1), 16),
        (None, 2, 20, range(20), 16),
    ],
)
def test_pieces_are_taken_together_as_long_as_no_thread_is_without_work(
    monkeypatch, at_once, threads, missing, groups, ahead
):
    asked = []

    def in_threads(call, places, count, waiting):
        asked.append((places, count, waiting))
        return map(call, places)

    class Task:
        def __call__(self, piece):
            return [piece]

        def many(self, pieces):
            return [[piece] for piece in pieces]

    if at_once is not None:
        Task.at_once = at_once
    monkeypatch.setattr(work, "in_threads", in_threads)
    pieces = range(100, 133)
    numbers = [3 + k for k in range(missing)]
    found = work._computed(Kept(None, None, "0", pieces), Task(), pieces, numbers, threads)
    assert list(found) == [[103 + k] for k in range(missing)]
    assert asked == [(groups, threads, ahead)]


@pytest.mark.parametrize(
    ("sizes", "stay"), [([90, 100, 100], True), ([90, 101, 5], False), ([101, 5, 5], False)]
)
def test_results_that_were_once_too_many_are_read_from_disk(sizes, stay):
    """However few the later ones make them seem."""
    told = iter(sizes)
    asked = []
    kept = Kept(
        Stub(expected_size=lambda *given: asked.append(given) or next(told)), None, "0", "abcd"
    )
    seen = []
    found = work._collected(kept, iter("xyz"), seen.append, 100)
    assert found == ["x", "y", "z"] if stay else found is kept
    assert seen == ["x", "y", "z"]
    assert asked == [(4, BESIDE)] * 3


def test_a_chain_stays_in_memory_as_far_as_its_work_may_have(tmp_path):
    for room, kind in ((0, Kept), (10**9, list)):
        with_file = Checkpoint(tmp_path / f"{room}.pieces", "key")
        chained = Work(1, with_file, in_memory=room).collect_chain(
            lambda before, piece: before + piece, 1, [10, 200], Codec(int, int)
        )
        assert type(chained) is kind
        assert list(chained) == [11, 211]
        with_file.discard()


@pytest.mark.parametrize("shard", [None, (2, 3)])
def test_a_cluster_runs_the_pieces_that_are_not_on_disk(tmp_path, shard):
    """Each result is kept by the number of its piece, whichever is done first."""
    with_file = Checkpoint(tmp_path / "x.pieces", "key")
    codec = Codec(lambda x: x + 1, lambda x: x - 1)
    for k in (1, 4):
        with_file.put("0", k, 1000 + k)
    asked = []

    def results(task, pieces, keep):
        asked.append(pieces)
        for nth in reversed(range(len(pieces))):
            keep(nth, task(pieces[nth]))
        return map(task, pieces)

    part = None if shard is None else work.Shard(*shard)
    whole = Work(None, with_file, Stub(results=results), part)
    found = []
    running = whole.run(lambda piece: 10 * piece, range(20, 27), codec, share=True)
    try:
        found.extend(running)
    except work.ShardDone:
        found.append("done")
    if shard is None:
        assert asked == [[20, 22, 23, 25, 26]]
        assert found == [200, 1000, 220, 230, 1003, 250, 260]
        assert [with_file.get("0", k) for k in (0, 2, 6)] == [201, 221, 261]
    else:
        assert asked == [[]]
        assert found == [1000, 1003, "done"]
    with_file.discard()


def test_a_piece_that_is_no_result_is_told_with_its_file(tmp_path):
    """That may be one of a shard; what is put comes back as it was."""
    part = Checkpoint(tmp_path / "part.pieces", "key")
    part.put("0", 1, 7)
    part.close()
    own = Checkpoint(tmp_path / "own.pieces", "key", (tmp_path / "part.pieces",))
    kept = Work(1, own)._kept(Codec(lambda x: 0, lambda x: [][x]), "abc")
    value = object()
    assert kept.put(2, value) is value
    for k, name in ((1, "part"), (2, "own")):
        with pytest.raises(SceneError, match=f"{name}.pieces: piece 0/{k} holds no result"):
            kept[k]
    own.discard()


class Parts:
    """A file that takes at most so many bytes at a time, and fails once after so many times."""

    def __init__(self, file, most: int, times: int, error: BaseException | None) -> None:
        self.file, self.most, self.times, self.error = file, most, times, error

    def write(self, data: memoryview) -> int:
        self.times -= 1
        if self.times == 0 and self.error is not None:
            raise self.error
        return self.file.write(bytes(data[: self.most]))

    def __getattr__(self, name: str):
        return getattr(self.file, name)


@pytest.mark.parametrize(
    "error", [None, OSError(errno.ENOSPC, "No space left"), KeyboardInterrupt()]
)
def test_a_record_that_is_written_in_parts_is_whole_or_not_there(tmp_path, monkeypatch, error):
    """One that fails is cut off, and is written by the next call."""
    clock = iter(range(0, 1000, 9))
    monkeypatch.setattr(checkpoint, "monotonic", lambda: next(clock))  # a run that takes long
    path = tmp_path / "x.pieces"
    kept = Checkpoint(path, "key")
    kept.put("0", 0, np.arange(5.0))
    before = path.stat().st_size
    kept._file = Parts(kept._file, 11, 3, error)
    if error is None:
        kept.put("0", 1, np.arange(50.0))
        assert path.stat().st_size == kept.size + 32 > before + 400  # with the record of the key
    else:
        with pytest.raises(type(error) if error.args == () else SceneError):
            kept.put("0", 1, np.arange(50.0))
        assert path.stat().st_size == before
        assert ("0", 1) in kept
    kept.close()
    again = Checkpoint(path, "key")
    assert (again.resumed, again.torn, again.damaged) == (2, 0, 0)
    assert again.get("0", 1).tolist() == list(range(50))
    again.discard()


def test_a_file_is_closed_also_where_its_last_pieces_find_no_room(tmp_path):
    """Without any piece it goes, with one it stays."""
    full = OSError(errno.ENOSPC, "No space left")
    for name, keeps in (("a", False), ("b", True)):
        path = tmp_path / name
        kept = Checkpoint(path, "key")
        kept.put("0", 0, 1)
        if keeps:
            kept.get("0", 0)  # which is read from the file
            kept.put("0", 1, 2)
        kept._file = Parts(kept._file, 1000, 1, full)
        with pytest.raises(SceneError, match=r"could not be written \(No space left\)"):
            kept.close()
        assert kept._file.closed
        assert path.exists() is keeps
    kept = Checkpoint(tmp_path / "c", "key")
    kept.put("0", 0, 1)
    kept.discard()
    assert not (tmp_path / "c").exists()
    kept.close()


def test_the_disk_is_waited_for_once_a_second(tmp_path, monkeypatch):
    clock = [10.0]
    waits = []
    monkeypatch.setattr(checkpoint, "monotonic", lambda: clock[0])
    monkeypatch.setattr(os, "fsync", lambda handle: waits.append(clock[0]))
    kept = Checkpoint(tmp_path / "x.pieces", "key")
    for number, now in enumerate((10.5, 11.001, 11.9, 12.0, 12.5, 13.4, 14.0)):
        clock[0] = now
        kept.put("0", number, 1)
    assert waits == [11.001, 12.5, 14.0]
    kept.discard()


def test_what_stands_in_the_files_of_all_parts_is_counted(tmp_path):
    """Bytes of records and between them; of our own file alone what is torn at its end."""
    for name, lost in (("one", b"a" * 40), ("two", b"b" * 24), ("own", b"c" * 16)):
        with_pieces = Checkpoint(tmp_path / name, "key")
        with_pieces.put(name, 0, 1)
        with_pieces.close()
        data = (tmp_path / name).read_bytes()
        end = data.index(b"\n") + 1
        (tmp_path / name).write_bytes(data[:end] + lost + data[end:] + b"torn" * (name == "own"))
    parts = (tmp_path / "one", tmp_path / "two")
    kept = Checkpoint(tmp_path / "own", "key", parts)
    sizes = [(tmp_path / name).stat().st_size for name in ("one", "two", "own")]
    assert (kept.damaged, kept.torn, kept.pieces) == (80, 4, 3)
    assert kept.size == sum(sizes)
    kept.put("one", 0, 2)
    assert kept.pieces == 3  # the same piece once more
    kept.close()
    assert [kept.get(name, 0) for name in ("one", "two", "own")] == [2, 1, 1]
    (tmp_path / "two").write_bytes(data[:12])
    with pytest.raises(SceneError, match="found no pieces of this run"):
        Checkpoint(tmp_path / "own", "key", parts)


def test_a_shard_without_a_piece_leaves_its_end_and_the_last_end_counts(tmp_path):
    path = tmp_path / "x.pieces"
    for end in ({"shard": [2, 7]}, {"shard": [3, 7]}, "no end"):
        kept = Checkpoint(path, "own key")
        assert kept.pieces == 0
        kept.put(checkpoint.END, 0, end)
        kept.close()
    assert checkpoint.key_of(path) == ("own key", {"shard": [3, 7]})
    path.write_bytes(checkpoint._record("other", 0, "own key", 0))
    with pytest.raises(SceneError, match="found no pieces"):
        checkpoint.key_of(path)
    empty = Checkpoint(tmp_path / "empty.pieces", "own key")
    empty.close()
    assert not (tmp_path / "empty.pieces").exists()
