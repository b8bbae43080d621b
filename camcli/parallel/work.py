"""Work in pieces: threads here, processes elsewhere, finished pieces in a checkpoint.

Pieces are independent and their results come back in the order of the pieces, so neither the number
of threads nor their timing can be seen in a result. A program that is deterministic asks for the
same pieces in the same order every time: a piece is known by where it is asked for (`within`), the
number of the call there and its own number, and is read from the checkpoint where it is in it.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

from camcli.errors import CamError, Fault, SceneError, shown
from camcli.parallel.checkpoint import Checkpoint, refused
from camcli.parallel.rows import Rows
from camcli.parallel.threads import AHEAD, in_threads, thread_count
from camcli.piece_faults import PieceFault

SHARES = 4  # calls of a thread, at least, where it takes several pieces in a call
IN_MEMORY = 1 << 26  # bytes of results that are on disk and in memory too
BESIDE = 1 << 12  # bytes of memory that a result takes beside what it takes on disk
MISFITS = (ValueError, TypeError, LookupError, AttributeError)  # of a piece that is no result


def _any(result: Any, piece: Any) -> bool:
    """Any result may be that of any piece."""
    return True


def _no_faults(_: Any) -> Sequence[PieceFault]:
    """A result that never carries a fault."""
    return ()


class Codec(NamedTuple):
    """How a result becomes plain values (see `checkpoint.pack`) and comes back.

    `load` raises ValueError for values that are no result (see `stored`), `fits` says whether a
    result is that of a piece: a file may hold all. faults: those that a result carries. One that
    has any is not kept on disk, so that it is tried again when the run goes on, and neither are
    pieces that may depend on it.
    """

    store: Callable[[Any], Any]
    load: Callable[[Any], Any]
    fits: Callable[[Any, Any], bool] = _any
    faults: Callable[[Any], Sequence[PieceFault]] = _no_faults


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


class ShardDone(CamError):  # noqa: N818 - no error: there is no more to do here
    """The pieces of this shard are on disk; what comes after needs those of all."""


@dataclass
class Work:
    """How pieces are run, and where their results are kept: `Work()` keeps nothing.

    faults: of the pieces that were run here, in their order; failed: whether one of this place
    was among them, so that what is asked for after it may depend on it.

    Examples
    --------
    >>> import camcli
    >>> speeds = {"sweep.rpm.start": 100, "sweep.rpm.stop": 120, "sweep.rpm.num": 3}
    >>> one_thread = camcli.Work(threads=1)
    >>> camcli.sweep(camcli.load_scene(None, speeds), work=one_thread).complete
    True
    """

    threads: int | None = None
    checkpoint: Checkpoint | None = None
    cluster: Cluster | None = None
    shard: Shard | None = None
    place: str = ""
    calls: int = 0
    faults: list[PieceFault] = field(default_factory=list)
    failed: bool = False
    in_memory: int = IN_MEMORY

    def within(self, name: str) -> Work:
        """This work for a part of the run: its pieces are counted anew and stored under `name`.

        So the pieces asked for in one place keep their numbers whatever is asked in another one.
        """
        return replace(self, place=f"{self.place}{name}/", calls=0)

    def run(
        self, task: Callable, pieces: Sequence, codec: Codec | None = None, share: bool = False
    ) -> Iterator:
        """Yield task(piece) for every piece, in order; on an exception the rest is cancelled.

        Without `codec` nothing is kept. Where `share` and this is a shard, the others' pieces are
        left out and ShardDone is raised at the end. A task for a cluster must pickle.
        """
        return self._run(self._kept(codec, pieces), task, pieces, share)

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
        kept = self._kept(codec, pieces)
        running = self._run(kept, task, pieces, True)
        return _collected(kept, running, on_result, self.in_memory)

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
        kept = self._kept(codec, pieces)

        def chain() -> Iterator:
            """The results in order; each that is on disk is taken from there, with no step."""
            result = first
            for k, piece in enumerate(pieces):
                if kept.has(k):
                    result = kept[k]
                else:
                    result = kept.put(k, step(result, piece), not self.failed)
                    self._note_faults(result, codec)
                yield result

        return _collected(kept, chain(), on_result, self.in_memory)

    def rows(self, width: int) -> Rows:
        """Rows of so many bytes each: on disk where the pieces are kept on disk."""
        return Rows(width) if self.checkpoint is None else self.checkpoint.rows(width)

    def _kept(self, codec: Codec | None, pieces: Sequence) -> Kept:
        """The place of the next call in the checkpoint."""
        number = self.calls
        self.calls += 1
        checkpoint = self.checkpoint if codec and not self.failed else None
        return Kept(checkpoint, codec, f"{self.place}{number}", pieces)

    def _note_faults(self, result: Any, codec: Codec | None) -> None:
        """Take note of the faults of a result that was computed here."""
        faults = codec.faults(result) if codec is not None else ()
        self.faults += faults
        self.failed = self.failed or bool(faults)

    def _run(self, kept: Kept, task: Callable, pieces: Sequence, share: bool) -> Iterator:
        """Results in the order of the pieces: from disk where they are there, else computed.

        share: whether a shard computes only its part of the pieces. It then ends with ShardDone.
        """
        first = 0
        step = 1
        if share and self.shard is not None:
            first = self.shard.number - 1
            step = self.shard.total
        ours = range(first, len(pieces), step)
        missing = array("q", (k for k in ours if not kept.has(k)))
        if self.cluster is not None:

            def keep(nth: int, result: Any) -> None:
                """Keep the result of the nth missing piece."""
                kept.put(missing[nth], result)

            missing_pieces = [pieces[k] for k in missing]
            computed = self.cluster.results(task, missing_pieces, keep)
        else:
            computed = _computed(kept, task, pieces, missing, self.threads)
        taken = 0  # of the missing pieces
        for k in ours:
            if taken < len(missing) and missing[taken] == k:
                taken += 1
                result = next(computed)
                self._note_faults(result, kept.codec)
                yield result
            else:
                yield kept[k]
        if share and self.shard is not None:
            raise ShardDone


def _computed(
    kept: Kept, task: Any, pieces: Sequence, missing: Sequence[int], threads: int | None
) -> Iterator:
    """The results of missing pieces, run in threads and kept as soon as they are there.

    missing: their numbers. A task that has `many` is given up to `at_once` pieces in a call of
    that, which returns their results; but so few that no thread is left without work.
    """
    at_once = getattr(task, "at_once", 1) if missing else 1
    share = -(-len(missing) // (SHARES * thread_count(threads)))  # rounded up
    count = max(1, min(at_once, share))

    def run_group(begin: int) -> list:
        """The results of `count` missing pieces from this place on, each of them kept."""
        numbers = missing[begin : begin + count]
        group = [pieces[k] for k in numbers]
        results = [task(group[0])] if len(group) == 1 else task.many(group)
        return [kept.put(k, result) for k, result in zip(numbers, results, strict=True)]

    groups = range(0, len(missing), count)
    for results in in_threads(run_group, groups, threads, AHEAD // count):
        yield from results


def _collected(
    kept: Kept, running: Iterator, on_result: Callable[[Any], None], in_memory: int
) -> Sequence:
    """All results, and `on_result` called with each.

    They are a list where all that is kept on disk and they themselves are going to take no more
    than `in_memory` bytes, as far as those so far tell; else they are read again from disk when
    they are asked for.
    """
    results = []
    checkpoint = kept.checkpoint
    have_room = True
    for result in running:
        on_result(result)
        if checkpoint is not None:
            size = checkpoint.expected_size(len(kept), BESIDE)
            have_room = have_room and size <= in_memory
        if have_room:
            results.append(result)
        else:
            results.clear()
    return results if have_room else kept


@dataclass(frozen=True)
class Kept(Sequence):
    """The results of one call in a checkpoint, read whenever they are asked for."""

    checkpoint: Checkpoint | None
    codec: Codec | None
    place: str
    pieces: Sequence
    unkept: dict[int, Any] = field(default_factory=dict)  # results that no file may have

    def __len__(self) -> int:
        return len(self.pieces)

    def __reduce__(self) -> tuple:
        """Pickled, the results are a list: the file is of this process."""
        return list, (list(self),)

    def has(self, k: int) -> bool:
        """Whether the result of piece k is there."""
        return self.checkpoint is not None and (self.place, k) in self.checkpoint

    def __getitem__(self, k):
        """The result of piece k, or a list of a slice of them.

        What could not be kept on disk is in memory; the rest is read, and must fit its piece.
        """
        if isinstance(k, slice):
            return [self[n] for n in range(*k.indices(len(self)))]
        k = range(len(self.pieces))[k]
        if k in self.unkept:
            return self.unkept[k]
        assert self.codec is not None
        codec = self.codec

        def load(stored: Any) -> Any:
            """The result that is on disk; raises ValueError where it belongs to another piece."""
            result = codec.load(stored)
            if not codec.fits(result, self.pieces[k]):
                raise ValueError("it is that of another piece")
            return result

        return self.part(k, load)

    def part(self, k: int, load: Callable[[Any], Any], names: Collection[str] | None = None) -> Any:
        """What `load` makes of the plain values of piece k; names: see `Checkpoint.get`."""
        assert self.checkpoint is not None
        try:
            return load(self.checkpoint.get(self.place, k, names))
        except SceneError:
            raise
        except MISFITS as error:
            found = f"piece {self.place}/{k} holds no result ({shown(str(error), 200)})"
            path = self.checkpoint.path_of(self.place, k)
            raise refused(path, found, "expected pieces of this run") from None

    def put(self, k: int, result: Any, sound: bool = True) -> Any:
        """Keep the result of piece k, and return it.

        It goes on disk where there is a checkpoint, unless it has a fault or is not sound, as it
        depends on one that has: then it stays in memory.
        """
        if self.checkpoint is not None and self.codec is not None:
            if sound and not self.codec.faults(result):
                self.checkpoint.put(self.place, k, self.codec.store(result))
            else:
                self.unkept[k] = result
        return result
