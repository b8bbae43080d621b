"""Pieces in threads: how many wait for the one whose turn it is, and what an exception leaves."""

from __future__ import annotations

import os
from contextvars import ContextVar
from threading import Event, Lock, Thread, get_ident
from time import monotonic, sleep

import pytest

from camcli import interrupts
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


def test_the_memory_of_a_machine_that_does_not_tell_it(monkeypatch):
    for error in (ValueError, OSError, AttributeError):

        def fails(_, error=error):
            raise error

        monkeypatch.setattr(os, "sysconf", fails)
        assert memory() == 4e9
    told = {"SC_PAGE_SIZE": 3, "SC_PHYS_PAGES": 7}
    monkeypatch.setattr(os, "sysconf", told.get)
    assert memory() == 21.0


def test_one_piece_is_done_by_who_asks():
    assert list(in_threads(lambda _: get_ident(), [1], 4)) == [get_ident()]
    assert get_ident() not in in_threads(lambda _: get_ident(), [1, 2], 4)


@pytest.mark.parametrize("threads", [1, 3])
def test_after_an_interrupt_no_further_piece_is_begun(monkeypatch, threads):
    begun = []
    monkeypatch.setattr(interrupts, "_came", True)
    with pytest.raises(KeyboardInterrupt):
        list(in_threads(begun.append, range(5), threads))
    assert begun == []


def test_pieces_that_wait_are_not_begun_after_one_has_failed():
    may_end = Event()
    begun = []

    def piece(k):
        begun.append(k)
        if k == 0:
            raise ZeroDivisionError
        may_end.wait(20.0)

    with pytest.raises(ZeroDivisionError):
        list(in_threads(piece, range(30), 2))
    may_end.set()
    sleep(0.05)
    assert len(begun) <= 4
