"""Helper processes for work that only one thread of a process can do at a time.

Balls have one precision for all threads, and Python one lock. Results do not depend on who does
the work.

A helper is another Python that reads pickled calls and writes pickled results. It ends when its
input does or its parent, however this process ends. Where one fails, the work is done here.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from queue import SimpleQueue
from threading import Condition, Thread, get_ident
from time import perf_counter, sleep
from typing import IO, Any

from camcli.parallel.threads import thread_count

WORTH_HELPERS = 0.5  # s of work, some more than a helper takes to start
START = "import sys; sys.path[:] = {path!r}; from camcli.parallel.helpers import serve; serve()"
READY = b"camcli helper is ready\n"  # what it writes first; whatever Python printed stands before
LOOK = 0.5  # s between two looks whether the process that asks is still there
GRACE = 1.0  # s that a process has to leave what it does, with all that it cleans up then


class HelperFailedError(Exception):
    """A helper has ended, or what it was asked for raised something."""


class Helper:
    """A process that computes what it is asked for, one after the other."""

    def __init__(self) -> None:
        command = [sys.executable, "-c", START.format(path=sys.path)]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL)

    def wait_until_ready(self) -> None:
        """Wait until the process reads what it is asked for; raises HelperFailedError."""
        assert self.process.stdout is not None
        try:
            ready = any(line.endswith(READY) for line in self.process.stdout)
        except (OSError, ValueError):
            ready = False
        if not ready:
            raise HelperFailedError

    def call(self, function: Callable, *args: Any) -> Any:
        """function(*args) as the helper computes it; raises HelperFailedError."""
        self.ask(function, *args)
        return self.answer()

    def ask(self, function: Callable, *args: Any) -> None:
        """Ask for function(*args), which is one of the next answers; raises HelperFailedError."""
        assert self.process.stdin is not None
        try:
            pickle.dump((function, args), self.process.stdin)
            self.process.stdin.flush()
        except Exception:
            raise HelperFailedError from None

    def answer(self) -> Any:
        """The next result."""
        assert self.process.stdout is not None
        try:
            done, result = pickle.load(self.process.stdout)
        except Exception:
            raise HelperFailedError from None
        if not done:
            raise HelperFailedError
        return result

    def end(self) -> None:
        """End the process, whatever it does: nobody waits for its answers any more."""
        self.process.terminate()
        try:
            self.process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            with suppress(OSError):
                assert pipe is not None
                pipe.close()

    def let_go(self) -> None:
        """Let the process end by itself, where it waits to be asked; nobody waits for that."""
        assert self.process.stdin is not None
        with suppress(OSError):
            self.process.stdin.close()


def serve() -> None:
    """What a helper does: it reads calls from stdin and writes answers to stdout, until stdin ends.

    An interrupt from the keyboard is for the process that asks. A SIGTERM is an exit like others:
    files that are only for now are removed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit())
    Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    calls = sys.stdin.buffer
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a function prints goes to stderr: it is no answer
    with suppress(EOFError, OSError):  # who asks has ended
        answers.write(READY)
        answers.flush()
        while True:
            function, args = pickle.load(calls)
            try:
                result = function(*args)
            except Exception:
                _answer(answers, False, None)
            else:
                _answer(answers, True, result)


def _end_with(parent: int) -> None:
    """End this process soon after its parent has ended, whatever it does: nobody waits for it."""
    while os.getppid() == parent:
        sleep(LOOK)
    os.kill(os.getpid(), signal.SIGTERM)
    sleep(GRACE)
    os._exit(1)


def _answer(answers: IO[bytes], done: bool, result: Any) -> None:
    """Write an answer; done: whether the call returned, so that there is a result."""
    pickle.dump((done, result), answers)
    answers.flush()


class Helpers:
    """So many helpers for calls that take long; each does one at a time.

    As many threads may call as there are helpers. What a helper has failed in, and all that it
    would have done later, is done by the thread that asks.
    """

    def __init__(self, count: int):
        """Start them; where no process can be started there are fewer, or none."""
        self._ended = False
        self._started: list[Helper] = []
        self._ready: set[Helper] = set()
        self._free: SimpleQueue[Helper | None] = SimpleQueue()  # None: done by who asks
        for _ in range(count):
            helper = None
            with suppress(OSError):
                helper = Helper()
                self._started.append(helper)
            self._free.put(helper)

    def call(self, function: Callable, *args: Any) -> Any:
        """function(*args) by the next helper that is free.

        A helper imports the function by its name, and everything else is pickled. Raises
        HelperFailedError after `end`.
        """
        helper = self._free.get()
        try:
            if helper is not None:
                try:
                    if helper not in self._ready:
                        helper.wait_until_ready()
                        self._ready.add(helper)
                    return helper.call(function, *args)
                except HelperFailedError:
                    helper.end()
                    helper = None
            if self._ended:
                raise HelperFailedError
            return function(*args)
        finally:
            self._free.put(helper)

    def end(self) -> None:
        """End the helpers, whatever they do."""
        self._ended = True
        for helper in self._started:
            helper.end()


class Turns:
    """Threads take turns at some work here, until there is enough of it for helpers to do it all.

    Enough: the threads, more than one, have done it for longer than a helper takes to start. From
    then on this process does none: who waits for Python's lock would wait until it is done.
    """

    def __init__(self, most: int | None = None, enough: float = WORTH_HELPERS):
        """most: helpers, one per processor unless given; enough: s."""
        self.most = thread_count(None) if most is None else most
        self.enough = enough
        self.helpers: list[Helper] = []  # those that have started
        self._free: list[Helper] = []  # of them those that have nothing to do
        self._busy_here = False  # whether this process does some of the work now
        self._asked_for = False  # whether helpers are to be started
        self._spent_here = 0.0  # s
        self._threads: set[int] = set()  # that have done work here
        self._change = Condition()

    def call(self, function: Callable, *args: Any) -> Any:
        """function(*args), as soon as it is somebody's turn.

        A helper imports the function by its name, and everything else is pickled.
        """
        helper = self._take()
        if helper is None:
            begun = perf_counter()
            try:
                return function(*args)
            finally:
                self._done_here(perf_counter() - begun)
        try:
            result = helper.call(function, *args)
        except HelperFailedError:
            self._lose(helper)
            return self.call(function, *args)
        except BaseException:  # an interrupt, between a question and its answer
            self._lose(helper)
            raise
        with self._change:
            self._free.append(helper)
            self._change.notify_all()
        return result

    def _take(self) -> Helper | None:
        """Wait for a turn: a free helper does the work, or None: this process does it.

        This process does it while there is no helper, one thread at a time.
        """

        def has_turn() -> bool:
            """Whether a helper is free, or there is none and nobody works here."""
            return bool(self._free) or not (self.helpers or self._busy_here)

        with self._change:
            self._change.wait_for(has_turn)
            if self._free:
                return self._free.pop()
            self._busy_here = True
            return None

    def _done_here(self, seconds: float) -> None:
        """Let the next thread have its turn; start helpers where there is enough work for them."""
        with self._change:
            self._busy_here = False
            self._spent_here += seconds
            self._threads.add(get_ident())
            self._change.notify_all()
            is_enough = self._spent_here > self.enough and len(self._threads) > 1
            if self._asked_for or not is_enough:
                return
            self._asked_for = True
        if self.most > 1:
            for _ in range(self.most):
                Thread(target=self._start, daemon=True).start()

    def _start(self) -> None:
        """Start a helper, and let it work as soon as it is ready."""
        try:
            helper = Helper()
        except (OSError, TypeError):  # no more processes; no Python to start
            return
        try:
            helper.wait_until_ready()
        except HelperFailedError:
            helper.end()
            return
        atexit.register(helper.end)
        with self._change:
            self.helpers.append(helper)
            self._free.append(helper)
            self._change.notify_all()

    def _lose(self, helper: Helper) -> None:
        """End a helper that has failed; the others, or this process, do what is left."""
        with self._change:
            self.helpers.remove(helper)
            self._change.notify_all()
        atexit.unregister(helper.end)
        helper.end()
