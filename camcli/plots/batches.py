"""Columns of values seen in batches: no Python per value, and no more than a batch in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

BATCH = 1 << 18  # values held at a time


class Batches:
    """Columns of values, one or more per speed, handed on some at a time.

    `take(owner, values)` gets finite values, and the index of the speed of each; it must not keep
    them.
    """

    def __init__(self, take: Callable[[np.ndarray, np.ndarray], None]) -> None:
        self._take = take
        self._owners: list[int] = []
        self._sizes: list[int] = []
        self._values = np.empty(BATCH)
        self._held = 0

    def add(self, owner: int, values) -> None:
        """A column (list or array) of the speed `owner`; nothing keeps hold of it."""
        begin = 0
        while begin < len(values):
            part = values[begin : begin + BATCH - self._held]
            self._values[self._held : self._held + len(part)] = part
            self._owners.append(owner)
            self._sizes.append(len(part))
            self._held += len(part)
            begin += len(part)
            if self._held == BATCH:
                self.flush()

    def flush(self) -> None:
        """Hand on what is held; call it at the end."""
        values = self._values[: self._held]
        owner = np.repeat(np.array(self._owners, dtype=np.int64), self._sizes)
        self._owners, self._sizes, self._held = [], [], 0
        finite = np.isfinite(values)
        if not finite.all():
            values, owner = values[finite], owner[finite]
        if len(values):
            self._take(owner, values)


def add_all(columns: Iterable, take: Callable[[np.ndarray, np.ndarray], None]) -> None:
    """Hand on one column of values per speed."""
    batches = Batches(take)
    for owner, values in enumerate(columns):
        batches.add(owner, values)
    batches.flush()
