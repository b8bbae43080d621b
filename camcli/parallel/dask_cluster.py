"""Pieces on a Dask cluster: an existing scheduler, or processes of this machine.

Pieces travel in chunks of about a second, so that neither the milliseconds that a scheduler takes
for each matter nor much is lost: a worker that dies costs the chunks it was at, which the scheduler
hands to another one. The task travels with each chunk, since data left with a worker dies with it.
"""

from __future__ import annotations

import logging
import pickle
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from time import monotonic, perf_counter
from typing import Any

from camcli.errors import Fault, SceneError
from camcli.parallel.threads import thread_count

LOCAL = "local"
TARGET = 1.0  # s, of a chunk
MOST_IN_CHUNK = 64
CHUNKS_PER_SLOT = 8  # at least, so that the slots end together
AHEAD = 4  # chunks per slot that are handed out
CONNECT = 8.0  # s
POLL, PATIENCE = 2.0, 60.0  # s: between looks; without any worker, before giving up
RESUME = "repeat the command: finished pieces are on disk"


class WorkerError(Exception):
    """A worker that would not compute what we would."""


class DaskCluster:
    """The workers of a scheduler; use it as a context."""

    def __init__(
        self, address: str, threads: int | None = None, program: Callable[[], str] | None = None
    ):
        """Connect to `address`, or start processes where it is `local`; raises SceneError.

        `program` is called here and in the workers: one that finds another value is refused.
        """
        try:
            import distributed
        except ImportError:
            cure = "pip install 'camcli[cluster]'"
            raise _fault("found no package `distributed`", cure, "expected it") from None
        _silence()
        self.program = (program, program()) if program is not None else None
        self.local = None
        if address == LOCAL:
            self.local = _local(distributed, thread_count(threads))
        try:
            self.client = distributed.Client(self.local or address, timeout=CONNECT)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            self._end_local()
            found = f"found no scheduler at '{address}' ({type(error).__name__})"
            raise _fault(found, "see dask scheduler", "expected HOST:PORT, or local") from None

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *failure: object) -> None:
        self.client.close(timeout=CONNECT)
        self._end_local()

    def results(
        self, task: Callable, pieces: Sequence, keep: Callable[[int, Any], Any]
    ) -> Iterator:
        """Iterator of task(piece) in order; keep(k, result) as soon as piece k is here."""
        packed = zlib.compress(pickle.dumps(task), 1)
        running: dict[Any, int] = {}  # future -> first piece of its chunk
        done: dict[int, list] = {}  # first piece -> results
        sent = turn = 0
        size = 1
        while turn < len(pieces):
            slots = max(1, self._slots())
            while sent < len(pieces) and len(running) + len(done) < AHEAD * slots:
                some = list(pieces[sent : sent + size])
                running[self._submit(packed, some)] = sent
                sent += len(some)
            for future in self._finished(running):
                first = running.pop(future)
                seconds, done[first] = self._result(future)
                for k, result in enumerate(done[first], first):
                    keep(k, result)
                size = _size(seconds / len(done[first]), len(pieces) // (slots * CHUNKS_PER_SLOT))
            while turn in done:
                found = done.pop(turn)
                turn += len(found)
                yield from found

    def _submit(self, packed: bytes, some: list) -> Any:
        return self.client.submit(_chunk, packed, some, self.program, pure=False)

    def _finished(self, running: dict) -> list:
        """Those that have come; raises SceneError where no worker is left to bring any."""
        import distributed

        lonely = monotonic()
        while True:
            try:
                found = distributed.wait(list(running), POLL, return_when="FIRST_COMPLETED")
                return list(found.done)
            except TimeoutError:
                if self._slots():
                    lonely = monotonic()
                elif monotonic() - lonely > PATIENCE:
                    words = f"found no worker for {PATIENCE:g} s"
                    raise _fault(words, f"start workers and {RESUME}") from None
            except _lost() as error:
                raise _scheduler_lost(error) from None

    def _result(self, future: Any) -> tuple[float, list]:
        """(seconds, results) of a chunk; raises SceneError for what the cluster has done wrong."""
        import distributed

        try:
            return future.result()
        except distributed.KilledWorker as error:
            found = f"found pieces at which {_attempts(error)} workers died"
            raise _fault(found, f"give the workers more memory and {RESUME}") from None
        except WorkerError as error:
            raise _fault(f"found {error}", f"update the workers and {RESUME}") from None
        except ImportError as error:
            raise _fault(f"found a worker without {error.name}", "install camcli there") from None
        except _lost() as error:
            raise _scheduler_lost(error) from None

    def _slots(self) -> int:
        try:
            return sum(self.client.nthreads().values())
        except (*_lost(), TimeoutError, OSError) as error:
            raise _scheduler_lost(error) from None

    def _end_local(self) -> None:
        if self.local is not None:
            self.local.close(timeout=CONNECT)


def _chunk(packed: bytes, pieces: Sequence, program: tuple | None) -> tuple[float, list]:
    """(seconds, results) of some pieces, in a worker."""
    if program is not None and program[0]() != program[1]:
        raise WorkerError("a worker with another version of this program")
    task, began = _unpacked(packed), perf_counter()
    results = [task(piece) for piece in pieces]
    return perf_counter() - began, results


@lru_cache(maxsize=4)
def _unpacked(packed: bytes) -> Callable:
    return pickle.loads(zlib.decompress(packed))


def _size(seconds: float, most: int) -> int:
    """Pieces of the next chunks, where one takes so long."""
    return max(1, min(MOST_IN_CHUNK, most, int(TARGET / max(seconds, 1e-6))))


def _lost() -> tuple[type[BaseException], ...]:
    """What says that scheduler or network are gone."""
    from asyncio import CancelledError as Cancelled
    from concurrent.futures import CancelledError

    from distributed.comm import CommClosedError

    return (CommClosedError, CancelledError, Cancelled)


def _scheduler_lost(error: BaseException) -> SceneError:
    return _fault(f"lost the scheduler ({type(error).__name__})", RESUME)


def _attempts(error: Any) -> Any:
    return getattr(error, "allowed_failures", 0) + 1


def _fault(found: str, cure: str, expected: str = "") -> SceneError:
    return SceneError(Fault("--cluster", "", found, expected, cure))


def _silence() -> None:
    """Keep what `distributed` says of lost workers off the user's screen: we say what matters."""
    warnings.filterwarnings("ignore", module="distributed")
    for name in ("distributed", "tornado", "asyncio", *logging.root.manager.loggerDict):
        if name.split(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _local(distributed, count: int):
    """Processes of this machine, one thread each."""
    return distributed.LocalCluster(
        n_workers=count, threads_per_worker=1, processes=True, dashboard_address=None,
        silence_logs=logging.CRITICAL + 1, preload=["camcli.parallel.worker"],
    )  # fmt: skip
