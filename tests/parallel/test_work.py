"""Work in pieces: order, names, what is kept, and how much of it in memory."""

import gc
import threading
import time
import weakref
from typing import ClassVar

import pytest

from camcli.errors import SceneError
from camcli.parallel import Checkpoint, Codec, Shard, ShardDone, Work

PLAIN = Codec(lambda result: result, lambda stored: stored)


@pytest.fixture
def checkpoint(tmp_path):
    opened = Checkpoint(tmp_path / "c", "work")
    yield opened
    opened.close()


class Counted:
    """A task that counts its calls."""

    def __init__(self, wrong=()):
        self.pieces, self.wrong, self.lock = [], wrong, threading.Lock()

    def __call__(self, piece):
        with self.lock:
            self.pieces.append(piece)
        if piece in self.wrong:
            raise OSError(f"piece {piece}")
        return piece * 10


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_results_come_in_the_order_of_the_pieces(threads):
    def task(k):
        time.sleep((k * 7919) % 20 / 20_000)
        return k

    assert list(Work(threads).run(task, range(60))) == list(range(60))


@pytest.mark.parametrize("threads", [1, 3])
def test_what_is_on_disk_is_not_computed(checkpoint, threads):
    first, second = Counted(), Counted()
    pieces = list(range(20))
    work = [Work(threads, checkpoint) for _ in range(3)]
    assert list(work[0].run(first, pieces[:7], PLAIN)) == [k * 10 for k in range(7)]
    assert list(work[1].run(second, pieces, PLAIN)) == [k * 10 for k in range(20)]
    assert sorted(second.pieces) == list(range(7, 20))
    assert list(work[2].run(Counted(pieces), pieces, PLAIN))[19] == 190


@pytest.mark.parametrize("kept", [False, True])
def test_collected_results_are_a_sequence(checkpoint, kept):
    seen = []
    work = Work(2, checkpoint if kept else None)
    found = work.collect(Counted(), range(5), PLAIN, seen.append)
    assert list(found) == seen == [0, 10, 20, 30, 40]
    assert (len(found), found[-1], found[1:3], found[::-2]) == (5, 40, [10, 20], [40, 20, 0])
    for wrong in (5, -6):
        with pytest.raises(IndexError):
            found[wrong]
    if kept:
        misfit = Codec(list, lambda stored: stored["x"])
        with pytest.raises(SceneError, match="0/0 holds no result"):
            Work(1, checkpoint).collect(Counted(), range(5), misfit)


def test_a_chain_goes_on_where_it_stopped(checkpoint):
    steps = []

    def step(before, piece):
        steps.append(piece)
        if len(steps) == 4:
            raise RuntimeError("stopped")
        return before * 2 + piece

    with pytest.raises(RuntimeError):
        Work(1, checkpoint).collect_chain(step, 1, range(6), PLAIN)
    found = Work(1, checkpoint).collect_chain(step, 1, range(6), PLAIN)
    assert list(found) == [2, 5, 12, 27, 58, 121]
    assert steps == [0, 1, 2, 3, 3, 4, 5]


@pytest.mark.parametrize("threads", [1, 4])
def test_a_piece_that_fails_leaves_the_others_on_disk(checkpoint, threads):
    got, fresh = [], Counted()
    with pytest.raises(OSError, match="piece 30"):
        got.extend(Work(threads, checkpoint).run(Counted({30}), range(2000), PLAIN))
    assert got == [k * 10 for k in range(30)]
    assert ("0", 30) not in checkpoint
    assert checkpoint.pieces < 2000  # the rest was cancelled
    assert len(list(Work(threads, checkpoint).run(fresh, range(2000), PLAIN))) == 2000
    assert not set(range(30)) & set(fresh.pieces)


@pytest.mark.parametrize("total", [1, 3, 40])
def test_shards_are_a_division(tmp_path, total):
    parts, asked = [], []
    for number in range(1, total + 1):
        parts.append(tmp_path / f"{number}")
        part, task = Checkpoint(parts[-1], "work"), Counted()
        with pytest.raises(ShardDone):
            Work(2, part, shard=Shard(number, total)).collect(task, range(30), PLAIN)
        part.put("end", 0, [number, total])
        part.close()
        asked += task.pieces
    assert sorted(asked) == list(range(30))
    merged, task = Checkpoint(tmp_path / "all", "work", tuple(parts)), Counted()
    assert list(Work(2, merged).collect(task, range(30), PLAIN)) == [k * 10 for k in range(30)]
    assert task.pieces == []


def test_a_shard_does_all_of_what_is_not_shared(checkpoint):
    work = Work(1, checkpoint, shard=Shard(2, 3))
    assert list(work.run(str, range(4), PLAIN)) == ["0", "1", "2", "3"]
    with pytest.raises(ShardDone):
        list(work.run(str, range(4), PLAIN, share=True))
    assert [("1", k) in checkpoint for k in range(4)] == [False, True, False, False]
    with pytest.raises(SceneError, match="--shard"):
        work.collect_chain(lambda before, piece: piece, None, [7], PLAIN)


class Result:
    """A result whose life can be watched."""

    alive: ClassVar = weakref.WeakSet()

    def __init__(self, value):
        self.value = value
        Result.alive.add(self)


@pytest.mark.parametrize("threads", [1, 2])
def test_few_of_many_results_are_in_memory(checkpoint, threads):
    most = 0

    def look(result):
        nonlocal most
        most = max(most, len(Result.alive))

    watched = Codec(lambda result: result.value, Result)
    found = Work(threads, checkpoint).collect(Result, range(3000), watched, look)
    gc.collect()
    assert most <= 16 * threads + 8
    assert len(Result.alive) <= 1
    assert [result.value for result in found] == list(range(3000))


class Backwards:
    """A cluster that finishes pieces from the last to the first."""

    def results(self, task, pieces, keep):
        """See `parallel.work.Cluster`."""
        done = {k: task(pieces[k]) for k in reversed(range(len(pieces)))}
        for k in done:
            keep(k, done[k])
        yield from (done[k] for k in range(len(pieces)))


def test_a_cluster_does_what_is_missing(checkpoint):
    list(Work(1, checkpoint).run(Counted(), range(4), PLAIN))
    work, task = Work(1, checkpoint, Backwards()), Counted()
    assert list(work.run(task, range(8), PLAIN)) == [k * 10 for k in range(8)]
    assert task.pieces == [7, 6, 5, 4]
    assert [checkpoint.get("0", k) for k in range(8)] == [k * 10 for k in range(8)]
