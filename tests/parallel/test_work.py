"""Work in pieces: order, names, what is kept, and how much of it in memory."""

import pickle
import threading
import weakref
from contextlib import closing

import pytest

from camcli.errors import SceneError
from camcli.parallel import Checkpoint, Codec, Shard, ShardDone, Work
from tests.support.clocks import time_passes

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


@pytest.mark.parametrize(("kept", "room"), [(False, 0), (True, 1 << 20), (True, 80), (True, 0)])
def test_collected_results_are_a_sequence(checkpoint, kept, room, monkeypatch):
    time_passes(monkeypatch)
    seen = []
    work = Work(2, checkpoint if kept else None, in_memory=room)
    found = work.collect(Counted(), range(5), PLAIN, seen.append)
    assert list(found) == seen == [0, 10, 20, 30, 40]
    assert isinstance(found, list) == (not kept or room > checkpoint.size)
    if kept:  # of the pieces; the first line of the file says whose they are
        lines = checkpoint.path.read_bytes().splitlines(keepends=True)
        assert checkpoint.size == sum(map(len, lines[1:]))
        assert len(lines) == 6
    assert pickle.loads(pickle.dumps(found)) == list(found)
    assert (len(found), found[-1], found[1:3], found[::-2]) == (5, 40, [10, 20], [40, 20, 0])
    for wrong in (5, -6):
        with pytest.raises(IndexError):
            found[wrong]
    if kept:
        misfit = Codec(list, lambda stored: stored["x"])
        with pytest.raises(SceneError, match="0/0 holds no result"):
            Work(1, checkpoint).collect(Counted(), range(5), misfit)
        others = Codec(lambda x: x, lambda x: x, lambda result, piece: result == 10 * piece)
        assert list(Work(1, checkpoint).collect(Counted(), range(5), others)) == list(found)
        with pytest.raises(SceneError, match="it is that of another piece"):
            list(Work(1, checkpoint).collect(Counted(), range(1, 6), others))


def test_each_part_of_a_run_finds_its_own_pieces_again(checkpoint):
    """Speed 0 and speed 1 of a range, what each of them asks for, and the run itself."""
    parts = {("0",): (1, 2), ("1",): (3, 4), ("1", "0"): (5,), (): (6, 7)}

    def results(task):
        found = {}
        for names, pieces in parts.items():
            work = Work(1, checkpoint)
            for name in names:
                work = work.within(name)
            found[names] = list(work.run(task, pieces, PLAIN))
        return found

    again = Counted()
    first = results(Counted())
    assert first == {names: [10 * piece for piece in pieces] for names, pieces in parts.items()}
    assert results(again) == first
    assert again.pieces == []


class Large(list):
    """A result of which one can see whether it is still in memory."""


@pytest.mark.parametrize(("room", "last"), [(9 * 4096, 1), (100_000, 1), (1 << 21, 9)])
def test_no_results_stay_in_memory_once_there_is_no_room(checkpoint, monkeypatch, room, last):
    """Nine results like the first have room in 100 000 bytes; the last ones take 10 000 or more.

    Each takes 4096 bytes beside those on disk.
    """
    time_passes(monkeypatch)
    kept, alive = [], []

    def look(result):
        kept.append(weakref.ref(result))
        alive.append(sum(one() is not None for one in kept))

    codec = Codec(list, Large)
    work = Work(1, checkpoint, in_memory=room)
    work.collect(lambda piece: Large([1] * (1000 * piece)), range(9), codec, look)
    assert alive[-1] == last
    assert (max(alive) > 1) == (room > 9 * 4096)


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


def test_a_shard_does_all_of_what_is_not_shared(checkpoint):
    work = Work(1, checkpoint, shard=Shard(2, 3))
    assert list(work.run(str, range(4), PLAIN)) == ["0", "1", "2", "3"]
    with pytest.raises(ShardDone):
        list(work.run(str, range(4), PLAIN, share=True))
    assert [("1", k) in checkpoint for k in range(4)] == [False, True, False, False]
    with pytest.raises(SceneError, match="--shard"):
        work.collect_chain(lambda before, piece: piece, None, [7], PLAIN)


@pytest.mark.parametrize("total", [1, 2, 3, 7])
def test_shards_together_do_every_piece_once(tmp_path, total):
    done = []
    for number in range(1, total + 1):
        task = Counted()
        own = Checkpoint(tmp_path / f"{number}", "work")
        with closing(own), pytest.raises(ShardDone):
            Work(1, own, shard=Shard(number, total)).collect(task, range(5), PLAIN)
        done += task.pieces
    assert sorted(done) == [0, 1, 2, 3, 4]


class Batches(Counted):
    """A task that takes up to seven pieces at once, and notes how many it is given."""

    at_once = 7

    def __init__(self):
        super().__init__()
        self.sizes = []

    def many(self, pieces):
        self.sizes.append(len(pieces))
        return [self(piece) for piece in pieces]


@pytest.mark.parametrize("threads", [1, 4])
@pytest.mark.parametrize("count", [0, 1, 5, 100, 1000])
def test_pieces_that_are_run_together_come_back_in_order(checkpoint, threads, count):
    """Those that are on disk are left out, and no thread goes without."""
    list(Work(threads, checkpoint).run(Counted(), range(count // 3), PLAIN))
    task = Batches()
    work = Work(threads, checkpoint)
    found = list(work.run(task, range(count), PLAIN))
    assert found == [k * 10 for k in range(count)]
    assert all(("0", k) in checkpoint for k in range(count))
    assert all(2 <= size <= 7 for size in task.sizes)
    assert len(task.sizes) >= (4 * threads if count > 100 else 0)
