"""Signals that end a run: never lost, seen within a second, and kept waiting over a commit.

A handler that only raises can lose its signal: what is raised inside a callback of a C library is
swallowed there. So the handler also makes a note, which is looked at between calls of the kernel,
none of which takes longer than half a second. A thread ends the process where the main thread is
kept in a call that nobody can cut: a pass of the compiler, a picture with many points. While the
kernel is compiled or loaded nothing is raised at all: LLVM crashes where an exception leaves its
objects half made.
"""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from threading import Thread
from time import sleep
from typing import Any, NoReturn

ENDING = (signal.SIGINT, signal.SIGTERM)
EXIT_CODE = 130
PATIENCE = 0.6  # s that the main thread has to come to its end

_leftovers: set[str] = set()  # see `unfinished`

_came = False  # a signal has come
_ending = False  # the interrupt has reached the end of the command, see `interrupt_arrived`
# An entry for each thread that is in `signals_held` or `compiling`: a number may miscount threads.
_holding: list[None] = []
_compiling: list[None] = []


def install() -> None:
    """Take over the signals of this process, which must be a command's; ignored ones stay so.

    A signal that came to an earlier command of this process is forgotten. Python writes the number
    of each signal into a pipe as well, which a thread reads: see `_watch`.
    """
    global _came, _ending
    _came = False
    _ending = False
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _handle)
    sys.unraisablehook = _unraisable
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    Thread(target=_watch, args=(reader,), daemon=True).start()


def _handle(number: int, frame: object) -> None:
    """Note the signal; raise an interrupt, or end the process where the compiler is at work."""
    global _came
    _came = True
    if _compiling and not _holding:
        _end()
    raise_if_interrupted()


class CutOffError(BaseException):
    """The time of a `cut_off_when` is over; no `except Exception` takes it for a fault."""


_over: ContextVar[Callable[[], bool] | None] = ContextVar("over", default=None)


@contextmanager
def cut_off_when(over: Callable[[], bool]) -> Iterator[None]:
    """Raise CutOffError in the block, or in its threads, at the first check that finds `over()`."""
    token = _over.set(over)
    try:
        yield
    finally:
        _over.reset(token)


def raise_if_interrupted() -> None:
    """Raise KeyboardInterrupt where a signal has come that may not have been seen.

    Once the interrupt has reached the end of the command (see `interrupt_arrived`) it is not raised
    again: a further signal says nothing new. Raises CutOffError where the time of a `cut_off_when`
    is over.
    """
    if _came and not _holding and not _ending:
        raise KeyboardInterrupt
    over = _over.get()
    if over is not None and over():
        raise CutOffError


def signal_came() -> bool:
    """Whether a signal has come: the cause of any error that follows, whatever the error says."""
    return _came


def interrupt_arrived() -> None:
    """Say that the interrupt has reached the end of the command: nobody has swallowed it."""
    global _ending
    _ending = True


def _unraisable(args: Any) -> None:
    """Print what Python could not raise, except an interrupt that a callback has swallowed."""
    if args.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(args)


@contextmanager
def signals_held() -> Iterator[None]:
    """Let signals wait until the block is left."""
    _holding.append(None)
    try:
        yield
    finally:
        _holding.pop()
    raise_if_interrupted()


@contextmanager
def compiling() -> Iterator[None]:
    """Let a signal end the process at once, without an exception in the block."""
    _compiling.append(None)
    try:
        yield
    finally:
        _compiling.pop()


def _watch(reader: int) -> None:
    """End the process where a signal has come and the main thread does not end it.

    It runs in a thread of its own. reader: the pipe into which Python writes the number of each
    signal. The main thread has PATIENCE seconds, and as long as signals are held.
    """
    while os.read(reader, 1)[0] not in ENDING:
        pass
    sleep(PATIENCE)
    while _holding:
        sleep(0.01)
    if not _ending:
        _end()


def unfinished(path: str | os.PathLike[str]) -> None:
    """Note a file, or a folder of files, that is removed where the process is ended at once."""
    _leftovers.add(os.fspath(path))


def finished(path: str | os.PathLike[str]) -> None:
    """Forget a file or folder that was noted: it may stay, or has gone."""
    _leftovers.discard(os.fspath(path))


@contextmanager
def removed_if_ended(path: str | os.PathLike[str]) -> Iterator[None]:
    """Within the block: if a signal ends the process at once, a file or folder is removed.

    At the end of the block it stays; who made it removes it.
    """
    unfinished(path)
    try:
        yield
    finally:
        finished(path)


def _end() -> None:
    """Say that the process ends, and end it at once, from any thread."""
    with suppress(OSError, ValueError, AttributeError, RuntimeError):
        sys.stderr.write("interrupted\n")
        sys.stderr.flush()
    leave()


def leave() -> NoReturn:
    """End the process at once, without an exception anywhere, and without waiting for threads."""
    for path in tuple(_leftovers):
        with suppress(OSError):
            _remove(path)
    os._exit(EXIT_CODE)


def _remove(path: str) -> None:
    """Remove a file, or a folder of files."""
    if not os.path.isdir(path):
        os.unlink(path)
        return
    for name in os.listdir(path):
        os.unlink(os.path.join(path, name))
    os.rmdir(path)
