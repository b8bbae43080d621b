"""The seam for work in pieces: order, names, what is kept, and how much of it in memory."""

import gc
import threading
import time
import weakref
from typing import ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camcli.parallel import Codec, Shard, ShardDone, Work, in_threads
from camcli.parallel.journal import Journal, JournalError

PLAIN = Codec(lambda result: result, lambda stored: stored)


@pytest.fixture
def journal(tmp_path):
    opened = Journal(tmp_path / "j", "work")
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


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(0, 20), max_size=60), st.integers(1, 5))
def test_results_come_in_the_order_of_the_pieces(delays, threads):
    def task(k):
        time.sleep(delays[k] / 20_000)
        return k

    assert list(Work(threads).run(task, range(len(delays)))) == list(range(len(delays)))


@pytest.mark.parametrize("threads", [1, 3])
def test_what_is_in_the_journal_is_not_computed(journal, threads):
    first, second = Counted(), Counted()
    pieces = list(range(20))
    assert list(Work(threads, journal).run(first, pieces[:7], PLAIN)) == [k * 10 for k in range(7)]
    assert list(Work(threads, journal).run(second, pieces, PLAIN)) == [k * 10 for k in range(20)]
    assert sorted(second.pieces) == list(range(7, 20))
    assert list(Work(threads, journal).run(Counted(pieces), pieces, PLAIN))[19] == 190


def test_places_tell_calls_apart(journal):
    work = Work(1, journal)
    list(work.run(str, [1, 2], PLAIN))
    list(work.run(str, [3], PLAIN))
    inner = work.within("speed7")
    list(inner.run(str, [4], PLAIN))
    list(inner.within("x").run(str, [5], PLAIN))
    list(inner.run(str, [6], PLAIN))
    work.collect_chain(lambda before, piece: piece, None, [7], PLAIN)
    found = {name: journal.get(name) for name in journal.index}
    assert found == {
        "0/0": "1", "0/1": "2", "1/0": "3", "speed7/0/0": "4", "speed7/x/0/0": "5",
        "speed7/1/0": "6", "2/0": 7,
    }  # fmt: skip


def test_without_a_codec_nothing_is_kept_but_the_call_counts(journal):
    work = Work(1, journal)
    assert list(work.run(str, [1])) == ["1"]
    list(work.run(str, [2], PLAIN))
    assert list(journal.index) == ["1/0"]


@pytest.mark.parametrize("kept", [False, True])
def test_collected_results_are_a_sequence(journal, kept):
    seen = []
    work = Work(2, journal if kept else None)
    found = work.collect(Counted(), range(5), PLAIN, seen.append)
    assert list(found) == seen == [0, 10, 20, 30, 40]
    assert (len(found), found[-1], found[1:3], found[::-2]) == (5, 40, [10, 20], [40, 20, 0])
    for wrong in (5, -6):
        with pytest.raises(IndexError):
            found[wrong]


def test_a_chain_goes_on_where_it_stopped(journal):
    steps = []

    def step(before, piece):
        steps.append(piece)
        if len(steps) == 4:
            raise RuntimeError("stopped")
        return before * 2 + piece

    with pytest.raises(RuntimeError):
        Work(1, journal).collect_chain(step, 1, range(6), PLAIN)
    found = Work(1, journal).collect_chain(step, 1, range(6), PLAIN)
    assert list(found) == [2, 5, 12, 27, 58, 121]
    assert steps == [0, 1, 2, 3, 3, 4, 5]


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_a_piece_that_fails_leaves_the_others_on_disk(journal, threads):
    work, got = Work(threads, journal), []
    with pytest.raises(OSError, match="piece 30"):
        got.extend(work.run(Counted({30}), range(2000), PLAIN))
    assert got == [k * 10 for k in range(30)]
    assert {f"0/{k}" for k in range(30)} <= set(journal.index)
    assert "0/30" not in journal
    assert len(journal.index) < 2000  # the rest was cancelled
    fresh = Counted()
    assert len(list(Work(threads, journal).run(fresh, range(2000), PLAIN))) == 2000
    assert not set(range(30)) & set(fresh.pieces)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 40])
def test_shards_are_a_division(tmp_path, count):
    names = []
    for number in range(1, count + 1):
        journal = Journal(tmp_path / f"{number}", "work")
        work = Work(2, journal, shard=Shard(number, count))
        with pytest.raises(ShardDone):
            work.collect(Counted(), range(30), PLAIN)
        names += list(journal.index)
        journal.close()
    assert sorted(names) == sorted(f"0/{k}" for k in range(30))
    parts = tuple(tmp_path / f"{number}" for number in range(1, count + 1))
    merged, task = Journal(tmp_path / "all", "work", parts), Counted()
    assert list(Work(2, merged).collect(task, range(30), PLAIN)) == [k * 10 for k in range(30)]
    assert task.pieces == []


def test_a_shard_does_all_of_what_is_not_shared(journal):
    work = Work(1, journal, shard=Shard(2, 3))
    assert list(work.run(str, range(4), PLAIN)) == ["0", "1", "2", "3"]
    with pytest.raises(ShardDone):
        list(work.run(str, range(4), PLAIN, share=True))
    assert [name for name in journal.index if name[0] == "1"] == ["1/1"]


class Result:
    """A result whose life can be watched."""

    alive: ClassVar = weakref.WeakSet()

    def __init__(self, value):
        self.value = value
        Result.alive.add(self)


WATCHED = Codec(lambda result: result.value, Result)


@pytest.mark.parametrize("threads", [1, 2])
def test_few_of_many_results_are_in_memory(journal, threads):
    most = 0

    def look(result):
        nonlocal most
        most = max(most, len(Result.alive))

    found = Work(threads, journal).collect(Result, range(10_000), WATCHED, look)
    gc.collect()
    assert most <= 16 * threads + 8
    assert len(Result.alive) <= 1
    assert [result.value for result in found] == list(range(10_000))


def test_a_piece_that_holds_no_result_is_said(journal):
    journal.put("0/0", "text")
    with pytest.raises(JournalError, match="0/0 holds no result"):
        Work(1, journal).collect(Counted(), range(3), Codec(list, lambda stored: stored["x"]))


def test_an_end_in_the_middle_cancels_the_rest():
    task = Counted()
    results = in_threads(task, range(100_000), 2)
    assert next(results) == 0
    results.close()
    time.sleep(0.05)
    assert len(task.pieces) < 1000


class Eager:
    """A cluster that finishes pieces from the last to the first."""

    def results(self, task, pieces, keep):
        """See `parallel.work.Cluster`."""
        done = {k: task(pieces[k]) for k in reversed(range(len(pieces)))}
        for k in done:
            keep(k, done[k])
        yield from (done[k] for k in range(len(pieces)))


def test_a_cluster_does_what_is_missing(journal):
    list(Work(1, journal).run(Counted(), range(4), PLAIN))
    work, task = Work(1, journal, Eager()), Counted()
    assert list(work.run(task, range(8), PLAIN)) == [k * 10 for k in range(8)]
    assert task.pieces == [7, 6, 5, 4]
    assert [journal.get(f"0/{k}") for k in range(8)] == [k * 10 for k in range(8)]
