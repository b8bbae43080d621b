"""Work in pieces: threads here, processes elsewhere, finished pieces in a checkpoint.

Pieces are independent and their results come back in the order of the pieces, so neither the number
of threads nor their timing can be seen in a result. A program that is deterministic asks for the
same pieces in the same order every time: a piece is known by where it is asked for (`within`), the
number of the call there and its own number, and is read from the checkpoint where it is in it.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

from camcli.errors import Fault, SceneError
from camcli.parallel.checkpoint import Checkpoint, refused
from camcli.parallel.threads import in_threads

IN_MEMORY = 1 << 26  # bytes of pieces on disk that are in memory too
MISFITS = (ValueError, TypeError, LookupError, AttributeError)  # of a piece that is no result


class Codec(NamedTuple):
    """How a result becomes plain values (see `checkpoint.pack`) and comes back.

    A result that is stored as None is not kept.
    """

    store: Callable[[Any], Any]
    load: Callable[[Any], Any]


class Cluster(Protocol):
    """Processes that run pieces."""

    def results(
        self, task: Callable, pieces: Sequence, keep: Callable[[int, Any], Any]
    ) -> Iterator:
        """Iterator of task(piece) in order; keep(k, result) as soon as piece k is done."""


class Shard(NamedTuple):
    """The part of the pieces that is ours: every total-th, from piece number - 1 on."""

    number: int
    total: int


class ShardDone(Exception):  # noqa: N818 - no error: there is no more to do here
    """The pieces of this shard are on disk; what comes after needs those of all."""


@dataclass
class Work:
    """How pieces are run, and where their results are kept: `Work()` keeps nothing."""

    threads: int | None = None
    checkpoint: Checkpoint | None = None
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
        return self._run(self._kept(codec, len(pieces)), task, pieces, share)

    def collect(
        self,
        task: Callable,
        pieces: Sequence,
        codec: Codec,
        on_result: Callable[[Any], None] = lambda result: None,
    ) -> Sequence:
        """All results; those in the checkpoint are read from it whenever they are asked for.

        `on_result` is called with each, in order. A shard does its own pieces: see `run`.
        """
        kept = self._kept(codec, len(pieces))
        return _collected(kept, self._run(kept, task, pieces, True), on_result)

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
        kept = self._kept(codec, len(pieces))

        def chain() -> Iterator:
            result = first
            for k, piece in enumerate(pieces):
                result = kept[k] if kept.has(k) else kept.put(k, step(result, piece))
                yield result

        return _collected(kept, chain(), on_result)

    def _kept(self, codec: Codec | None, count: int) -> Kept:
        """The place of the next call in the checkpoint."""
        number, self.calls = self.calls, self.calls + 1
        return Kept(self.checkpoint if codec else None, codec, f"{self.place}{number}", count)

    def _run(self, kept: Kept, task: Callable, pieces: Sequence, share: bool) -> Iterator:
        first, step = 0, 1
        if share and self.shard is not None:
            first, step = self.shard.number - 1, self.shard.total
        ours = range(first, len(pieces), step)
        missing = array("q", (k for k in ours if not kept.has(k)))
        if self.cluster is not None:
            todo = [pieces[k] for k in missing]
            fresh = self.cluster.results(task, todo, lambda n, found: kept.put(missing[n], found))
        else:
            fresh = in_threads(lambda k: kept.put(k, task(pieces[k])), missing, self.threads)
        nth = 0
        for k in ours:
            if nth < len(missing) and missing[nth] == k:
                nth += 1
                yield next(fresh)
            else:
                yield kept[k]
        if share and self.shard is not None:
            raise ShardDone


def _collected(kept: Kept, running: Iterator, on_result: Callable[[Any], None]) -> Sequence:
    results, store = [], kept.checkpoint
    for result in running:
        on_result(result)
        if store is None or store.size <= IN_MEMORY:
            results.append(result)
        else:
            results.clear()
    return results if len(results) == kept.length else kept


@dataclass(frozen=True)
class Kept(Sequence):
    """The results of one call in a checkpoint, read whenever they are asked for."""

    checkpoint: Checkpoint | None
    codec: Codec | None
    place: str
    length: int

    def __len__(self) -> int:
        return self.length

    def has(self, k: int) -> bool:
        """Whether the result of piece k is there."""
        return self.checkpoint is not None and (self.place, k) in self.checkpoint

    def __getitem__(self, k):
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(self.length))]
        k = range(self.length)[k]
        assert self.checkpoint is not None
        assert self.codec is not None
        try:
            return self.codec.load(self.checkpoint.get(self.place, k))
        except SceneError:
            raise
        except MISFITS as error:
            found = f"piece {self.place}/{k} holds no result ({error})"
            raise refused(self.checkpoint.path, found, "expected pieces of this run") from None

    def put(self, k: int, result: Any) -> Any:
        """Keep the result of piece k, and return it."""
        if self.checkpoint is not None and self.codec is not None:
            stored = self.codec.store(result)
            if stored is not None:
                self.checkpoint.put(self.place, k, stored)
        return result
