"""Functions behind pieces of work, each asked alone: a cluster's chunks, sizes, kept results."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace as Stub

import numpy as np
import pytest

from camcli.errors import SceneError
from camcli.parallel import Checkpoint, Work, checkpoint, dask_cluster
from camcli.parallel.dask_cluster import DaskCluster, OtherProgramError
from camcli.parallel.work import Codec
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
