"""The seam between plain Python and the compiled kernel: everybody above calls a `Kernel`.

Loading what is compiled costs about 0.1 s and compiling some seconds; plain Python does some ten
thousand impacts a second. So little work runs in plain Python, and `for_work` and `compiled` give a
`Kernel` of machine code where there is more. Both give the same bits; a kernel that is in hand
stays what it is, so nothing changes under a thread that uses it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from threading import Lock
from time import perf_counter

from camcli.kernel.code_cache import News, cache_dir, is_cached
from camcli.kernel.forms import PLAIN, Kernel

LITTLE_WORK = 10_000  # turns in all that plain Python does before the kernel is compiled
LEAST_WORK = 500  # the same where compiled code only has to be read
# The same of Newton's method for orbits, in impacts times steps: some 0.05 ms each in plain Python.
LITTLE_NEWTON, LEAST_NEWTON = 5_000, 500
NEWTON = "correct_orbit", "certify_orbit"  # its entries
PYTHON, COMPILED = "python", "compiled"  # values of CAMCLI_KERNEL


_compiled: Kernel | None = None
_loading = Lock()
_plain_newton = 0  # see `count_plain_newton`
_newton_found = False  # True: its code was found on disk


def current() -> Kernel:
    """The compiled kernel if a run of this process has loaded it, else plain Python."""
    return _compiled or PLAIN


def for_work(turns: float, enough: float = LITTLE_WORK) -> Kernel:
    """The kernel for so many turns: compiled where there are more than `enough`, else `current`.

    Where compiled code is on disk, LEAST_WORK is enough.
    """
    if _compiled is not None or not may_compile():
        return current()
    much = turns > enough or must_compile() or (turns > LEAST_WORK and is_cached())
    return compiled() if much else PLAIN


def for_newton() -> Kernel:
    """The kernel for Newton's method: compiled where that is quicker from here on.

    Its code is read where it is on disk and this process has loaded the kernel or done some of that
    work, and compiled where plain Python has done a lot of it; see `count_plain_newton`.
    """
    wanted = _wanted()
    if wanted == PYTHON:
        return PLAIN
    if wanted == COMPILED or _plain_newton > LITTLE_NEWTON:
        return compiled()
    worth_reading = _compiled is not None or _plain_newton > LEAST_NEWTON
    return compiled() if worth_reading and _newton_is_cached() else PLAIN


def count_plain_newton(steps: int) -> None:
    """Count Newton's steps, each times its impacts, that this process has done in plain Python."""
    global _plain_newton
    _plain_newton += steps


def _newton_is_cached() -> bool:
    """Whether the code of Newton's method is on disk; read once, as it is loaded then."""
    global _newton_found
    _newton_found = _newton_found or all(map(is_cached, NEWTON))
    return _newton_found


def compiled() -> Kernel:
    """The compiled kernel; plain Python where the user forbids it. Thread-safe."""
    global _compiled
    if not may_compile():
        return PLAIN
    if _compiled is None:
        with _waiting(), _loading:
            if _compiled is None:
                from camcli.kernel.compiled import compile_entries

                entries = compile_entries(cache_dir(), _waiting, _tell)
                _compiled = Kernel(compiled=True, **entries)
    return _compiled


def may_compile() -> bool:
    """False where the user forces plain Python (CAMCLI_KERNEL=python or NUMBA_DISABLE_JIT=1)."""
    return _wanted() != PYTHON


def must_compile() -> bool:
    """True where the user forces the compiled kernel even for little work."""
    return _wanted() == COMPILED


def _wanted() -> str:
    """PYTHON or COMPILED where the environment asks for it; anything else leaves the choice."""
    disabled = os.environ.get("NUMBA_DISABLE_JIT", "0").strip().lower() in ("1", "true", "yes")
    return PYTHON if disabled else os.environ.get("CAMCLI_KERNEL", "auto")


Notice = Callable[[News], None]


class Stopwatch:
    """The seconds of a run, without those in which it waited for the kernel to be compiled."""

    def __init__(self, notice: Notice | None, outer: Stopwatch | None = None):
        self.outer, self._began = outer, perf_counter()
        self.seconds = 0.0
        self.compile_seconds = 0.0
        self.notice, self._lock = notice, Lock()
        self._waiting, self._since = 0, 0.0

    def passed(self) -> float:
        """The seconds so far."""
        with self._lock:
            until = self._since if self._waiting else perf_counter()
            return until - self._began - self.compile_seconds

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Count the time in which at least one thread of the run waits."""
        outer = nullcontext() if self.outer is None else self.outer.waiting()
        with self._lock:
            if self._waiting == 0:
                self._since = perf_counter()
            self._waiting += 1
        try:
            with outer:
                yield
        finally:
            with self._lock:
                self._waiting -= 1
                if self._waiting == 0:
                    self.compile_seconds += perf_counter() - self._since


_stopwatch: ContextVar[Stopwatch | None] = ContextVar("stopwatch", default=None)


@contextmanager
def stopwatch(notice: Notice | None = None) -> Iterator[Stopwatch]:
    """Time a run; `notice` is called with each `News`, once or more often.

    Without one, that of the run around it is taken. The watch belongs to this context and the
    threads that are started in it (`parallel.in_threads`).
    """
    outer = _stopwatch.get()
    watch = Stopwatch(outer.notice if notice is None and outer is not None else notice, outer)
    token = _stopwatch.set(watch)
    try:
        yield watch
    finally:
        watch.seconds = watch.passed()
        _stopwatch.reset(token)


def _waiting():
    """The context of whoever waits for the compiler."""
    watch = _stopwatch.get()
    return nullcontext() if watch is None else watch.waiting()


def _tell(news: News) -> None:
    """Tell the run that is timed of something about the machine code."""
    watch = _stopwatch.get()
    if watch is not None and watch.notice is not None:
        watch.notice(news)
