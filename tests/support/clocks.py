"""A clock for tests: work that takes no time as if it took long."""

from functools import partial
from itertools import count
from time import monotonic


def time_passes(monkeypatch):
    """Between one look of a checkpoint at the clock and the next two seconds pass."""
    clock = count(monotonic() + 2.0, 2.0)
    monkeypatch.setattr("camcli.parallel.checkpoint.monotonic", partial(next, clock))
