"""What stored values, files of pieces, shards and clusters are refused with, word by word."""

from __future__ import annotations

import asyncio
import re
from concurrent import futures
from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.errors import SceneError
from camcli.parallel import Checkpoint, Shard, Work, stored
from camcli.parallel.checkpoint import key_of, pack, unpack
from camcli.parallel.work import Codec
from tests.parallel.test_checkpoint import written

ONE = {"n": stored.whole, "x": stored.real}
STORED = [  # check, what it refuses, and what it says
    (stored.real, inf, "found inf, expected a finite number"),
    (stored.extended, "inf", "found 'inf', expected a number"),
    (stored.whole, -1, "found -1, expected a whole number"),
    (stored.whole, "9" * 50, f"found '{'9' * 39}, expected a whole number"),  # forty characters
    (stored.flag, 1, "found 1, expected true or false"),
    (stored.text, 3, "found 3, expected a text"),
    (stored.one_of("up", 2), "down", "found 'down', expected one of 2 values"),
    (stored.items(stored.whole), 7, "expected a list of values"),
    (stored.items(stored.whole, 3), [1], "expected a list of 3"),
    (lambda value: stored.fields(value, ONE), {"n": 1}, "expected n, x"),
    (stored.columns(1, 1), [[[1]]], "expected an array of whole numbers and one of others"),
    (stored.columns(1, 2), [[[1]]] * 2, "expected 1 column of whole numbers and 2 of others"),
    (stored.columns(1, 1), [[[1]], [[1, 2]]], "expected columns of equal length"),
    (stored.columns(1, 1), [[[1]], [[inf]]], "expected columns of finite numbers"),
    (lambda value: stored.table(value, 3, "f"), [[1.0]], "expected an array of 3 columns"),
    (lambda value: stored.table(value, 1, "f"), [[inf]], "expected finite numbers"),
    (unpack, b'{"dtype":"<f8","shape":[-1],"at":0}', "found a shape below nothing"),
]


@pytest.mark.parametrize(("check", "value", "words"), STORED)
def test_a_stored_value(check, value, words):
    with pytest.raises(ValueError, match="^" + re.escape(words) + "$"):
        check(value)


@pytest.mark.parametrize(
    ("value", "words"),
    [(object(), "a object cannot be kept"), (np.array(["x"]), "an array of <U1 cannot be kept")],
)
def test_what_cannot_be_stored(value, words):
    with pytest.raises(TypeError, match="^" + re.escape(words) + "$"):
        pack(value)


CURE = "delete the file, or choose another folder"


def refusal(ask, *asked) -> str:
    with pytest.raises(SceneError) as caught:
        ask(*asked)
    (fault,) = caught.value.faults
    return str(fault)


def test_a_file_of_pieces(tmp_path):
    path = tmp_path / "c"
    written(path)
    words = f"{path}: found no pieces of this run, expected them, {CURE}"
    assert refusal(Checkpoint, path, "other") == words
    path.write_bytes(b"no pieces")
    words = f"{path}: found no pieces, expected a file of --shard I/N, {CURE}"
    assert refusal(key_of, path) == words


def test_a_piece_that_was_changed(tmp_path):
    path = tmp_path / "c"
    checkpoint = Checkpoint(path, "work", most_waiting=-1)
    checkpoint.put("0", 3, [1.5])
    path.write_bytes(path.read_bytes().replace(b"1.5", b"2.5"))
    found = "piece 0/3 was changed or damaged while the run was at work"
    words = f"{path}: found {found}, expected it whole, {CURE}".replace("found piece", "piece")
    assert refusal(checkpoint.get, "0", 3) == words
    checkpoint.discard()


def test_a_piece_of_another_result(tmp_path):
    """One that cannot be read as a result, and one that belongs to another piece."""
    whole = Codec(store=lambda result: result, load=stored.whole, faults=lambda result: (),
                  fits=lambda result, piece: result == piece)  # fmt: skip
    checkpoint = Checkpoint(tmp_path / "c", "work", most_waiting=-1)
    checkpoint.put("0", 0, "x")
    checkpoint.put("0", 1, 5)
    for pieces, why in (([1], "found 'x', expected a whole number"),
                        ([1, 7], "it is that of another piece")):  # fmt: skip
        k = len(pieces) - 1
        words = (f"{tmp_path / 'c'}: piece 0/{k} holds no result ({why}), expected pieces of this "
                 f"run, {CURE}")  # fmt: skip
        work = Work(1, checkpoint)
        if k == 1:
            checkpoint.put("0", 0, 1)
        assert refusal(lambda work=work, pieces=pieces: list(work.run(int, pieces, whole))) == words
    checkpoint.discard()


def test_a_shard_of_a_chain():
    work = Work(1, None, shard=Shard(1, 2))
    words = (
        "--shard: found a chain, each piece after the one before, expected parts, leave it out, or "
        "set sweep.direction=fixed"
    )
    chain = work.collect_chain
    assert refusal(chain, lambda before, piece: piece, None, [7], None) == words


# -- a cluster, whose workers are written down here


class Workers:
    """A client of a cluster of so many slots, whose pieces take so many seconds each.

    sizes: of the chunks that were handed out, and after how many of them came back.
    """

    def __init__(self, slots: int, seconds: float, error: Exception | None = None):
        self.slots, self.seconds, self.error = slots, seconds, error
        self.sizes: list[int] = []
        self.most_waiting = self.waiting = 0

    def nthreads(self):
        return {"worker": self.slots}

    def submit(self, run, task, chunk, program, pure):
        self.sizes.append(len(chunk))
        self.waiting += 1
        self.most_waiting = max(self.most_waiting, self.waiting)
        return Answer(self, task, chunk)


class Answer:
    """A future that is there as soon as it is asked for."""

    def __init__(self, workers: Workers, task, chunk):
        self.workers, self.task, self.chunk = workers, task, chunk

    def result(self):
        self.workers.waiting -= 1
        if self.workers.error is not None:
            raise self.workers.error
        return self.workers.seconds * len(self.chunk), [self.task(one) for one in self.chunk]


@pytest.fixture
def cluster(monkeypatch):
    """A cluster of these workers; the first chunk that was handed out comes back first."""
    distributed = pytest.importorskip("distributed")
    from camcli.parallel.dask_cluster import DaskCluster

    def first(futures, *asked, **more):
        return SimpleNamespace(done=futures[:1])

    monkeypatch.setattr(distributed, "wait", first)

    def of(workers: Workers) -> DaskCluster:
        made = DaskCluster.__new__(DaskCluster)
        made.client, made.program, made.local = workers, None, None
        return made

    return of


@pytest.mark.parametrize(
    ("slots", "seconds", "pieces", "size"),
    [
        (2, 0.02, 2000, 50),  # a second each
        (2, 0.001, 2000, 64),  # no more than so many
        (2, 0.001, 320, 20),  # eight chunks a slot
        (2, 5.0, 40, 1),
    ],
)
def test_chunks_take_a_second_and_keep_all_workers_busy(cluster, slots, seconds, pieces, size):
    workers, kept = Workers(slots, seconds), {}
    found = list(cluster(workers).results(lambda x: 10 * x, range(pieces), kept.__setitem__))
    assert found == [10 * k for k in range(pieces)]
    assert kept == dict(enumerate(found))
    assert workers.most_waiting == 4 * slots
    assert workers.sizes[: 4 * slots] == [1] * (4 * slots)  # nothing is known before
    assert set(workers.sizes[4 * slots : -1]) <= {size}


def killed():
    distributed = pytest.importorskip("distributed")
    return distributed.KilledWorker("task", None, 3)


def other_program():
    from camcli.parallel.dask_cluster import OtherProgramError

    return OtherProgramError()


AGAIN = "repeat the command: finished pieces are on disk"
LOST = [
    (killed, f"found pieces at which 4 workers died, give the workers more memory and {AGAIN}"),
    (other_program,
     f"found a worker with another version of this program, update the workers and {AGAIN}"),
    (lambda: ImportError("none", name="camcli"), "found a worker without camcli, install camcli "
                                                 "there"),
    (lambda: OSError("gone"), f"lost the scheduler (OSError), {AGAIN}"),
    (asyncio.CancelledError, f"lost the scheduler (CancelledError), {AGAIN}"),
    (futures.CancelledError, f"lost the scheduler (CancelledError), {AGAIN}"),
]  # fmt: skip


@pytest.mark.parametrize(("error", "words"), LOST)
def test_a_cluster_that_is_lost(cluster, error, words):
    results = cluster(Workers(1, 0.1, error())).results(str, range(3), lambda k, found: None)
    assert refusal(list, results) == f"--cluster: {words}"


def test_a_cluster_without_workers_is_waited_for(cluster, monkeypatch):
    """For a minute: then it is given up."""
    from camcli.parallel import dask_cluster

    clock = iter([0.0, 60.0, 60.001])
    monkeypatch.setattr(dask_cluster, "monotonic", lambda: next(clock))
    workers = Workers(0, 0.1)
    workers.submit = lambda *asked, **more: None  # nobody takes it
    results = cluster(workers).results(str, range(1), lambda k, found: None)
    monkeypatch.setattr(dask_cluster, "_finished", lambda *asked: [])
    words = f"--cluster: found no worker for 60 s, start workers and {AGAIN}"
    assert refusal(list, results) == words
    assert next(clock, None) is None


def test_no_scheduler_at_an_address():
    pytest.importorskip("distributed")
    from camcli.parallel.dask_cluster import DaskCluster

    words = (
        "--cluster: found no scheduler at 'nowhere:x' (ValueError), expected HOST:PORT, or local, "
        "see dask scheduler"
    )
    assert refusal(DaskCluster, "nowhere:x") == words
