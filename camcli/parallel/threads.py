"""Threads over a kernel that holds no lock; results in the order of the pieces.

A thread sees the context variables of who asked for the pieces.
"""

import os
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

from camcli.interrupts import raise_if_interrupted

Piece = TypeVar("Piece")
Result = TypeVar("Result")
AHEAD = 16  # pieces per thread that may wait


def thread_count(threads: int | None) -> int:
    """Threads to use: as asked, or one per processor this process may use."""
    if threads:
        return threads
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory() -> float:
    """Bytes of memory of this machine."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return 4e9


def in_threads(
    function: Callable[[Piece], Result],
    pieces: Sequence[Piece],
    threads: int | None = None,
    ahead: int = AHEAD,
) -> Iterator[Result]:
    """Yield function(piece) for every piece, in order; on an exception the rest is cancelled.

    ahead: pieces per thread that may wait for the one whose turn it is, 2 at least.
    """
    count = min(thread_count(threads), len(pieces))

    def call(piece: Piece) -> Result:
        """The result of a piece; KeyboardInterrupt instead, once the run was interrupted."""
        raise_if_interrupted()
        return function(piece)

    if count <= 1:
        yield from map(call, pieces)
        return
    pool = ThreadPoolExecutor(count)
    running: deque[Future] = deque()
    try:
        for piece in pieces:
            running.append(pool.submit(copy_context().run, call, piece))
            if len(running) >= max(2, ahead) * count:
                yield running.popleft().result()
        while running:
            yield running.popleft().result()
    finally:
        pool.shutdown(wait=not running, cancel_futures=True)
