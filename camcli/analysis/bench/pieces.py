"""Pieces of the bench, measured one after the other within the time there is.

A piece of work is never stopped from outside: it is given seconds and keeps to them, and where none
are left it is not begun and says so (NOT_REACHED). So a part overruns by one piece at the most.
Measured pieces are kept where there is a checkpoint, as the timings they are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple
from time import monotonic
from typing import Any

from camcli.parallel import Codec, Work

OK, FAILED = "ok", "failed"
NOT_REACHED = "not-reached"  # status of what the clock left no time for


def measured(
    kind: type,
    measure: Callable[[Any, float, float], list],
    pieces: Sequence,
    work: Work,
    seconds: float,
) -> Iterator[list]:
    """Yield measure(piece, its share, what is left) for every piece in order: rows of `kind`.

    Time is counted from now, in seconds; a share is what is left over the pieces that are left.
    Rows that were not reached are not kept.
    """
    until = monotonic() + seconds

    def timed(k: int) -> list:
        left = max(0.0, until - monotonic())
        return measure(pieces[k], left / (len(pieces) - k), left)

    def store(rows: list) -> list | None:
        reached = all(row.status != NOT_REACHED for row in rows)
        return [list(astuple(row)) for row in rows] if reached else None

    codec = Codec(store, lambda stored: [kind(*values) for values in stored])
    return work.run(timed, range(len(pieces)), codec)
