"""The seam between plain Python and the compiled kernel: everybody above calls a `Kernel`.

Loading what is compiled costs about 0.1 s and compiling some seconds; plain Python does some ten
thousand impacts a second. So little work runs in plain Python, and `for_work` and `compiled` give a
`Kernel` of machine code where there is more. Both give the same bits; a kernel that is in hand
stays what it is, so nothing changes under a thread that uses it.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from copy import copy
from dataclasses import dataclass
from enum import Enum
from functools import cache
from operator import attrgetter
from threading import Lock
from time import perf_counter
from typing import Any, TypeVar

from camcli.kernel.cam_table import Cam, Stretch
from camcli.kernel.cells import settle_cells
from camcli.kernel.certify import certify_orbit
from camcli.kernel.code_cache import cache_dir, is_cached
from camcli.kernel.flow import Constants, Flow, fill_flows
from camcli.kernel.loads import measure_loads
from camcli.kernel.orbit_loop import Log, Strobe, advance
from camcli.kernel.shooting import correct_orbit
from camcli.kernel.variational import stretch_events

Row = TypeVar("Row")
LITTLE_WORK = 10_000  # turns in all that plain Python does before the kernel is compiled
LEAST_WORK = 500  # the same where compiled code only has to be read


@dataclass(frozen=True)
class Kernel:
    """The kernel's entries in one of their two forms, and tables in the form they take.

    In plain Python a column is a list of numbers (numpy's scalars are slow there) and a table a
    list of rows; compiled, both are arrays.
    """

    compiled: bool
    fill_flows: Callable
    advance: Callable
    correct_orbit: Callable
    certify_orbit: Callable
    settle_cells: Callable
    stretch_events: Callable
    measure_loads: Callable

    def numbers(self, values: Any, kind: type = float) -> Any:
        """A column of floats or ints; it may be `values` itself."""
        if not self.compiled:
            return values if isinstance(values, list) else [kind(value) for value in values]
        import numpy as np

        column = np.ascontiguousarray(values, np.float64 if kind is float else np.int64)
        return column if column.flags.writeable else column.copy()

    def zeros(self, count: int, kind: type = float) -> Any:
        """A column of zeros."""
        if not self.compiled:
            return [kind(0)] * count
        import numpy as np

        return np.zeros(count, np.float64 if kind is float else np.int64)

    def table(self, kind: type, rows: Sequence) -> Any:
        """A table of rows of `kind`, a class of float and int fields; it may be `rows` itself.

        What the kernel writes into a row is read as an attribute of table[n] in both forms.
        """
        if not self.compiled:
            return rows if isinstance(rows, list) else list(rows)
        import numpy as np

        values = list(map(attrgetter(*kind.__annotations__), rows))
        return np.array(values, _row_type(kind))

    def room(self, kind: type, count: int) -> Any:
        """A table of rows of zeros, for a kind whose defaults are zeros."""
        if not self.compiled:
            return [kind() for _ in range(count)]
        import numpy as np

        return np.zeros(count, _row_type(kind))

    def log(self, rows: int) -> Log:
        """Room for so many events."""
        kind, period = self.zeros(rows, int), self.zeros(rows, int)
        return Log(kind, period, self.zeros(rows), self.zeros(rows), self.zeros(rows), rows)

    def strobe(self, rows: int) -> Strobe:
        """Room for so many periods."""
        q, w = self.zeros(rows), self.zeros(rows)
        return Strobe(q, w, self.zeros(rows, int), self.zeros(rows, int), rows)

    def cam(self, cam: Cam) -> Cam:
        """The tables of a cam."""
        stretches = self.table(Stretch, cam.stretches)
        return cam._replace(stretches=stretches, pieces=self.numbers(cam.pieces))

    def stretch_flows(self, cam: Cam, constants: Constants) -> Any:
        """The table of `flow.fill_flows`, for a cam in this kernel's form."""
        flows = self.room(Flow, len(cam.stretches) ** 2)
        self.fill_flows(cam, constants, flows)
        return flows


def plain(values: Any) -> list:
    """A column as a list of Python's own numbers: reading numpy's one by one is slow."""
    return values.tolist() if hasattr(values, "tolist") else list(values)


def row_of(kind: type[Row], row: Any) -> Row:
    """A row of a `Kernel.table` as an object of plain numbers."""
    if isinstance(row, kind):
        return copy(row)
    return kind(*row.item())


@cache
def _row_type(kind: type) -> Any:
    """The type of an array of such rows; one object, which numba recognises quickly."""
    import numpy as np

    fields = [(name, np.dtype(of)) for name, of in kind.__annotations__.items()]
    return np.dtype((np.record, fields))


PLAIN = Kernel(
    False, fill_flows, advance, correct_orbit, certify_orbit, settle_cells, stretch_events,
    measure_loads,
)  # fmt: skip
_compiled: Kernel | None = None
_loading = Lock()


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
    disabled = os.environ.get("NUMBA_DISABLE_JIT", "0").strip().lower() in ("1", "true", "yes")
    return not disabled and os.environ.get("CAMCLI_KERNEL", "auto") != "python"


def must_compile() -> bool:
    """True where the user forces the compiled kernel even for little work."""
    return may_compile() and os.environ.get("CAMCLI_KERNEL", "auto") == "compiled"


class News(Enum):
    """What a user may want to know of the kernel's machine code."""

    COMPILING = "compiling"  # it is not on disk, and takes some seconds
    DAMAGED = "damaged"  # what was on disk is removed
    KILLED = "killed"  # what was on disk ended a process that tried it, and is removed
    NOT_OURS = "not-ours"  # others may write the folder on disk, so it is not used
    PUBLIC = "public"  # numba's public functions compile it, which makes each start slower


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
