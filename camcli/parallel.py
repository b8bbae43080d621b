"""The one seam for work in pieces: threads over a kernel that holds no lock.

Pieces are independent and their results come back in the order of the pieces, so neither the
number of threads nor their timing can be seen in a result.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Piece = TypeVar("Piece")
Result = TypeVar("Result")


def thread_count(threads: int | None) -> int:
    """Threads to use: as asked, or one per processor this process may use."""
    if threads:
        return threads
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_pieces(
    function: Callable[[Piece], Result], pieces: Sequence[Piece], threads: int | None = None
) -> Iterator[Result]:
    """Yield function(piece) for every piece, in order; on an exception the rest is cancelled."""
    count = min(thread_count(threads), len(pieces))
    if count <= 1:
        yield from map(function, pieces)
        return
    with ThreadPoolExecutor(count) as pool:
        futures = [pool.submit(function, piece) for piece in pieces]
        try:
            for future in futures:
                yield future.result()
        finally:
            for future in futures:
                future.cancel()
