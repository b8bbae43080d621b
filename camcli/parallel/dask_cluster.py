"""Pieces on a Dask cluster: an existing scheduler, or processes of this machine.

Pieces travel in chunks of about a second, so that neither the milliseconds that a scheduler takes
for each matter nor much is lost: a worker that dies costs the chunks it was at, which the scheduler
hands to another one. The task travels with each chunk, since data left with a worker dies with it.
"""

from __future__ import annotations

import logging
import os
import signal
import warnings
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Sequence
from concurrent import futures
from contextlib import contextmanager, suppress
from time import monotonic, perf_counter
from typing import Any

from camcli.errors import CamError, Fault, SceneError, plural
from camcli.interrupts import signals_held
from camcli.parallel.threads import thread_count

LOCAL = "local"
TARGET = 1.0  # s, of a chunk
MOST_IN_CHUNK = 64
CHUNKS_PER_SLOT = 8  # at least, so that the slots end together
AHEAD = 4  # chunks per slot that are handed out
CONNECT = 8.0  # s
POLL, PATIENCE = 2.0, 60.0  # s: between looks; without any worker, before giving up
RESUME = "repeat the command: finished pieces are on disk"


class OtherProgramError(CamError):
    """A worker has another version of this program."""


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
            try:
                self.local = _local(distributed, thread_count(threads))
            except (OSError, RuntimeError, TimeoutError) as error:  # killed while they started, too
                found = f"the processes of this machine did not start ({error})"
                raise _fault(found, "ask for fewer --threads, or leave --cluster out") from None
        self.lonely = monotonic()  # since when no worker was seen
        try:
            self.client = distributed.Client(self.local or address, timeout=CONNECT)
        except (OSError, ValueError, TypeError, TimeoutError) as error:
            self._end_local()
            found = f"found no scheduler at '{address}' ({type(error).__name__})"
            raise _fault(found, "see dask scheduler", "expected HOST:PORT, or local") from None

    def __enter__(self) -> DaskCluster:
        return self

    def __exit__(self, *failure: object) -> None:
        """Let go of the scheduler; after a failure kill the workers of a local cluster at once."""
        with signals_held():  # an interrupt leaves no process behind
            if self.local is not None and failure[0] is not None:
                for nanny in self.local.workers.values():  # what they are at is not waited for
                    nanny.auto_restart = False
                    with suppress(OSError, TypeError):  # it has gone, or is not there yet
                        os.kill(nanny.pid, signal.SIGKILL)
            self.client.close(timeout=CONNECT)
            self._end_local()

    def _end_local(self) -> None:
        """End the processes of this machine, where they are ours."""
        if self.local is not None:
            self.local.close(timeout=CONNECT)

    def results(
        self, task: Callable, pieces: Sequence, keep: Callable[[int, Any], Any]
    ) -> Iterator:
        """Iterator of task(piece) in order; keep(k, result) as soon as piece k is here.

        Raises SceneError where the cluster fails; what it has computed is kept.
        """
        running: dict[Any, int] = {}  # future -> first piece of its chunk
        done: dict[int, list] = {}  # first piece of a chunk -> its results
        sent = 0  # pieces handed out
        turn = 0  # the piece whose result comes next
        size = 1  # of a chunk
        self.lonely = monotonic()
        while turn < len(pieces):
            with _faults_of_a_cluster():
                slots = self._slots()
                while sent < len(pieces) and len(running) + len(done) < AHEAD * slots:
                    chunk = list(pieces[sent : sent + size])
                    future = self.client.submit(_run, task, chunk, self.program, pure=False)
                    running[future] = sent
                    sent += len(chunk)
                arrived = [(future, *future.result()) for future in _finished(running)]
            for future, seconds, results in arrived:
                first = running.pop(future)
                done[first] = results
                for k, result in enumerate(results, first):
                    keep(k, result)
                size = _size_of_chunk(len(pieces), slots, len(results), seconds)
            while turn in done:
                results = done.pop(turn)
                turn += len(results)
                yield from results

    def _slots(self) -> int:
        """Threads of all workers, at least 1; raises SceneError after a while without any."""
        count = sum(self.client.nthreads().values())
        if count > 0:
            self.lonely = monotonic()
        elif monotonic() - self.lonely > PATIENCE:
            raise _fault(f"found no worker for {PATIENCE:g} s", f"start workers and {RESUME}")
        return max(1, count)


def dask_setup(worker: object) -> None:
    """Called in a process of `--cluster local` (see `_local`): Ctrl-C is for the command."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _faults_of_a_cluster() -> Iterator[None]:
    """Raise SceneError where the cluster fails in the block, with what to do about it."""
    import distributed

    try:
        yield
    except distributed.KilledWorker as error:
        died = getattr(error, "allowed_failures", 0) + 1
        found = f"found pieces at which {plural(died, 'worker')} died"
        raise _fault(found, f"give the workers more memory and {RESUME}") from None
    except OtherProgramError:
        found = "found a worker with another version of this program"
        raise _fault(found, f"update the workers and {RESUME}") from None
    except ImportError as error:
        found = f"found a worker without {error.name}"
        raise _fault(found, "install camcli there") from None
    except (OSError, TimeoutError, CancelledError, futures.CancelledError) as error:
        raise _fault(f"lost the scheduler ({type(error).__name__})", RESUME) from None


def _size_of_chunk(pieces: int, slots: int, count: int, seconds: float) -> int:
    """How many pieces the next chunks have, so that one takes about TARGET seconds.

    pieces: of the whole work; slots: threads of all workers; count, seconds: of the chunk that has
    just come.
    """
    per_slot = pieces // (slots * CHUNKS_PER_SLOT)
    wanted = int(TARGET * count / max(seconds, 1e-6))
    return max(1, min(MOST_IN_CHUNK, per_slot, wanted))


def _run(task: Callable, chunk: Sequence, program: tuple | None) -> tuple[float, list]:
    """(seconds, results) of some pieces, in a worker.

    program: a function, and what it returned where the command runs. Raises OtherProgramError where
    it returns something else here.
    """
    if program is not None:
        hash_here, hash_there = program
        if hash_here() != hash_there:
            raise OtherProgramError
    began = perf_counter()
    results = [task(piece) for piece in chunk]
    return perf_counter() - began, results


def _finished(running: dict) -> list:
    """Futures that have come, none where none comes for a while."""
    import distributed

    try:
        return list(distributed.wait(list(running), POLL, return_when="FIRST_COMPLETED").done)
    except TimeoutError:
        return []


def _fault(found: str, cure: str, expected: str = "") -> SceneError:
    """A fault of --cluster."""
    return SceneError(Fault("--cluster", "", found, expected, cure))


def _silence() -> None:
    """Keep what `distributed` says of lost workers off the user's screen: we say what matters."""
    warnings.filterwarnings("ignore", module="distributed")
    for name in ("distributed", "tornado", "asyncio", *logging.root.manager.loggerDict):
        if name.split(".")[0] in ("distributed", "tornado", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def _local(distributed: Any, count: int) -> Any:
    """Processes of this machine, one thread each."""
    filters = os.environ.get("PYTHONWARNINGS")
    # for multiprocessing's own process, which speaks where an interrupt ends the start
    os.environ["PYTHONWARNINGS"] = "ignore:resource_tracker"
    try:
        return distributed.LocalCluster(
            n_workers=count, threads_per_worker=1, processes=True, dashboard_address=None,
            silence_logs=logging.CRITICAL + 1, preload=["camcli.parallel.dask_cluster"],
        )  # fmt: skip
    finally:
        os.environ.pop("PYTHONWARNINGS")
        if filters is not None:
            os.environ["PYTHONWARNINGS"] = filters
