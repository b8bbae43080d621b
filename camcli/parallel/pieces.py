"""The one seam for work in pieces: threads here, processes elsewhere, finished pieces on disk.

Pieces are independent and their results come back in the order of the pieces, so neither the number
of threads nor their timing can be seen in a result. A program that is deterministic asks for the
same pieces in the same order every time: a piece is known by where it is asked for (`within`), the
number of the call there and its own number, and is taken from the journal where it is in it.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

from camcli.errors import Fault, SceneError
from camcli.parallel.journal import Journal, JournalError
from camcli.parallel.threads import in_threads

BROKEN = (ValueError, TypeError, LookupError, AttributeError)  # what a strange piece may raise
END = "end"  # name of the record that says that a shard is complete


class Codec(NamedTuple):
    """How a result becomes plain values (see `codec.pack`) and comes back; None is not kept."""

    store: Callable[[Any], Any]
    load: Callable[[Any], Any]


class Cluster(Protocol):
    """Processes that run pieces."""

    def results(self, task: Callable, pieces: Sequence, keep: Callable[[int, Any], None]):
        """Iterator of task(piece) in order; keep(k, result) as soon as piece k is done."""


class Shard(NamedTuple):
    """The part of the pieces that is ours: every count-th, from piece number - 1 on."""

    number: int
    count: int


class ShardDone(Exception):  # noqa: N818 - no error: there is no more to do here
    """The pieces of this shard are on disk; what comes after needs those of all."""


@dataclass
class Work:
    """How pieces are run, and where their results are kept."""

    threads: int | None = None
    journal: Journal | None = None
    cluster: Cluster | None = None
    shard: Shard | None = None
    place: str = ""
    calls: int = 0

    def within(self, name: str) -> Work:
        """The same, with a count of calls of its own: what is asked there is called `name`."""
        return replace(self, place=f"{self.place}{name}/", calls=0)

    def run(
        self, task: Callable, pieces: Sequence, codec: Codec | None = None, share: bool = False
    ) -> Iterator:
        """Yield task(piece) for every piece, in order; on an exception the rest is cancelled.

        Without `codec` nothing is kept. Where `share` and this is a shard, the others' pieces are
        left out and ShardDone is raised at the end. A task for a cluster must pickle.
        """
        return self._call(codec).run(task, pieces, self.shard if share else None)

    def collect(
        self,
        task: Callable,
        pieces: Sequence,
        codec: Codec,
        on_result: Callable[[Any], None] = lambda result: None,
    ) -> Sequence:
        """All results; those in the journal are read from it whenever they are asked for.

        `on_result` is called with each, in order. A shard does its own pieces: see `run`.
        """
        call = self._call(codec)
        return call.collected(call.run(task, pieces, self.shard), len(pieces), on_result)

    def collect_chain(
        self,
        step: Callable[[Any, Any], Any],
        first: Any,
        pieces: Sequence,
        codec: Codec,
        on_result: Callable[[Any], None] = lambda result: None,
    ) -> Sequence:
        """All results of step(result before, piece), one after the other; `first` before all.

        Raises SceneError in a shard: there is no part of it that could be done alone.
        """
        if self.shard is not None:
            found, expected = "found a chain, each piece after the one before", "expected parts"
            cure = "leave it out, or set sweep.direction=fixed"
            raise SceneError(Fault("--shard", "", found, expected, cure))
        call = self._call(codec)
        return call.collected(call.chain(step, first, pieces), len(pieces), on_result)

    def _call(self, codec: Codec | None) -> _Call:
        number, self.calls = self.calls, self.calls + 1
        journal = self.journal if codec is not None else None
        return _Call(self, journal, codec, f"{self.place}{number}/")


@dataclass(frozen=True)
class _Call:
    """One call for pieces, and their place in the journal."""

    work: Work
    journal: Journal | None
    codec: Codec | None
    place: str

    def has(self, k: int) -> bool:
        return self.journal is not None and f"{self.place}{k}" in self.journal

    def load(self, k: int) -> Any:
        name = f"{self.place}{k}"
        try:
            return self.codec.load(self.journal.get(name))
        except BROKEN as error:
            where = self.journal.path.parent
            raise JournalError(f"{where}: piece {name} holds no result ({error})") from None

    def keep(self, k: int, result: Any) -> Any:
        stored = None if self.journal is None else self.codec.store(result)
        if stored is not None:
            self.journal.put(f"{self.place}{k}", stored)
        return result

    def run(self, task: Callable, pieces: Sequence, shard: Shard | None) -> Iterator:
        count = len(pieces)
        ours = range(count) if shard is None else range(shard.number - 1, count, shard.count)
        missing = array("q", (k for k in ours if not self.has(k)))
        fresh, nth = self._fresh(task, missing, pieces), 0
        for k in ours:
            if nth < len(missing) and missing[nth] == k:
                nth += 1
                yield next(fresh)
            else:
                yield self.load(k)
        if shard is not None:
            raise ShardDone

    def chain(self, step: Callable, first: Any, pieces: Sequence) -> Iterator:
        result = first
        for k, piece in enumerate(pieces):
            result = self.load(k) if self.has(k) else self.keep(k, step(result, piece))
            yield result

    def collected(self, running: Iterator, count: int, on_result: Callable) -> Sequence:
        results = []
        for result in running:
            on_result(result)
            if self.journal is None:
                results.append(result)
        return results if self.journal is None else Kept(self, count)

    def _fresh(self, task: Callable, missing: Sequence[int], pieces: Sequence) -> Iterator:
        """Results of the missing pieces in order; each is on disk as soon as it is known."""
        cluster = self.work.cluster
        if cluster is not None:

            def keep(n: int, result: Any) -> None:
                self.keep(missing[n], result)

            return cluster.results(task, [pieces[k] for k in missing], keep)
        return in_threads(lambda k: self.keep(k, task(pieces[k])), missing, self.work.threads)


class Kept(Sequence):
    """Results in a journal, read whenever they are asked for."""

    def __init__(self, call: _Call, count: int):
        self._at, self._count = call, count

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(self._count))]
        if not -self._count <= k < self._count:
            raise IndexError(k)
        return self._at.load(k % self._count)

    def __iter__(self) -> Iterator:
        return map(self._at.load, range(self._count))
