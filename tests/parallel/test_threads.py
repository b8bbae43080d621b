"""Pieces in threads: how many wait for the one whose turn it is, and what an exception leaves."""

from __future__ import annotations

import os
from contextvars import ContextVar
from threading import Event, Lock, Thread
from time import monotonic, sleep

import pytest

from camcli.parallel.threads import in_threads, memory, thread_count

WHO = ContextVar("who", default="nobody")


class FirstIsLast:
    """Pieces of which the first one does not end before it may."""

    def __init__(self):
        self.may_end, self.begun, self.lock = Event(), [], Lock()

    def __call__(self, piece):
        with self.lock:
            self.begun.append(piece)
        if piece == 0:
            self.may_end.wait(20.0)
        return piece * piece


@pytest.mark.parametrize(("threads", "ahead", "waiting"), [(2, 3, 6), (2, 1, 4), (3, 4, 12)])
def test_so_many_pieces_are_begun_before_the_first_has_ended(threads, ahead, waiting):
    """That many a thread, two at least: a memory has room for no more of their results."""
    pieces = FirstIsLast()
    found = []
    running = Thread(
        target=lambda: found.extend(in_threads(pieces, range(50), threads, ahead)), daemon=True
    )
    running.start()
    end = monotonic() + 10.0
    while len(pieces.begun) < waiting and monotonic() < end:
        sleep(0.005)
    sleep(0.05)
    assert sorted(pieces.begun) == list(range(waiting))
    pieces.may_end.set()
    running.join(20.0)
    assert found == [k * k for k in range(50)]


@pytest.mark.parametrize("threads", [1, 3])
def test_a_piece_sees_the_context_of_who_asked(threads):
    token = WHO.set("the caller")
    try:
        assert set(in_threads(lambda piece: WHO.get(), range(6), threads)) == {"the caller"}
    finally:
        WHO.reset(token)


@pytest.mark.parametrize("threads", [1, 4])
def test_a_piece_that_fails_ends_the_rest(threads):
    begun = []

    def piece(k):
        begun.append(k)
        if k == 3:
            raise ZeroDivisionError
        return k

    got = []
    with pytest.raises(ZeroDivisionError):
        got.extend(in_threads(piece, range(10_000), threads))
    assert got == [0, 1, 2]
    assert len(begun) < 200


def test_threads_and_memory_of_this_machine():
    assert thread_count(5) == 5
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    assert thread_count(None) == thread_count(0) == own
    assert 1e8 < memory() < 1e15
    assert list(in_threads(str, [], 4)) == []


def test_one_thread_for_each_processor_that_this_process_may_use(monkeypatch):
    """Not for those that are there; where nobody can tell which it may use, for all, else one."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {1, 3, 6}, raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    assert thread_count(None) == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    assert thread_count(None) == 8
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert thread_count(None) == 1
    assert thread_count(5) == 5
