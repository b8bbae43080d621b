"""One piece of a run may fail: the others are computed all the same, and the failure is told.

A piece is whatever the rest does not need: a speed, a block of cells, a branch, a picture. What
fails in a way that somebody foresaw has an error of its own (`CamError`, errors of the system) and
ends the run as before; anything else is a fault of this program, and costs its piece alone.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from camcli.errors import CamError
from camcli.interrupts import signal_came

T = TypeVar("T")

PACKAGE = Path(__file__).parent
FRAMES = 40  # of a traceback, the innermost
MOST_TEXT = 200  # characters of an exception's message on the screen
# what the system says where it has no room for another thread, or for a library
SHORTAGES = ("can't start new thread", "failed to map segment")


@dataclass(frozen=True)
class PieceFault:
    """An exception that nobody foresaw, and the piece of the run that it has cost.

    piece: which one, as a user knows it; error: type and message of the exception; place: file,
    line and function in this package where it was raised; traceback: the whole of it.
    """

    piece: str
    error: str
    place: str
    traceback: str

    @classmethod
    def of(cls, error: Exception, piece: str) -> PieceFault:
        """The fault of a piece that has raised this exception.

        Its place is the innermost frame of this package; without any, the innermost of all.
        """
        frames = traceback.extract_tb(error.__traceback__)
        of_package = [frame for frame in frames if Path(frame.filename).is_relative_to(PACKAGE)]
        place = ""
        if frames:
            last = (of_package or frames)[-1]
            path = Path(last.filename)
            name = path.relative_to(PACKAGE.parent) if of_package else path.name
            place = f"{name}:{last.lineno}, {last.name}"
        text = "".join(traceback.format_exception(error, limit=-FRAMES))
        return cls(piece, f"{type(error).__name__}: {error}".rstrip(": "), place, text)


def is_foreseen(error: Exception) -> bool:
    """True for an exception that is no fault of this program.

    An error raised on purpose, one of the system, a package that is not there, or whatever a
    library makes of a signal.
    """
    on_purpose = isinstance(error, CamError | OSError | MemoryError | ImportError)
    return on_purpose or signal_came() or any(words in str(error) for words in SHORTAGES)


def attempt(piece: str, call: Callable[[], T]) -> T | PieceFault:
    """What `call` returns, or the fault where it raises what nobody foresaw."""
    try:
        return call()
    except Exception as error:
        if is_foreseen(error):
            raise
        return PieceFault.of(error, piece)


_gathered: ContextVar[list[PieceFault] | None] = ContextVar("gathered", default=None)


@contextmanager
def gathering() -> Iterator[list[PieceFault]]:
    """Gather the faults of the pieces of the block, see `piece`, in the list that it gives."""
    faults: list[PieceFault] = []
    token = _gathered.set(faults)
    try:
        yield faults
    finally:
        _gathered.reset(token)


def piece(name: str, call: Callable[[], T], instead: Any = None) -> T | Any:
    """What `call` returns, or `instead` where it raises what nobody foresaw.

    The fault goes to the `gathering` around it; where there is none, the exception is raised. In
    threads and in other processes the order of faults is not that of the pieces, so what runs there
    uses `attempt`, and returns the fault.
    """
    faults = _gathered.get()
    if faults is None:
        return call()
    result = attempt(name, call)
    if isinstance(result, PieceFault):
        faults.append(result)
        return instead
    return result


def gather(faults: Iterable[PieceFault]) -> None:
    """Add faults that results carry to those of the `gathering` around it, if there is one."""
    gathered = _gathered.get()
    if gathered is not None:
        gathered += faults


def fault_records(faults: Iterable[PieceFault]) -> list[dict[str, Any]]:
    """Faults as plain values: those with one kind of error at one place as one.

    Each with the pieces that it has cost, in their order, and the error and traceback of the first.
    """
    groups: dict[tuple[str, str], list[PieceFault]] = {}
    for fault in faults:
        kind = fault.error.partition(":")[0]
        groups.setdefault((kind, fault.place), []).append(fault)
    return [
        {
            "pieces": [fault.piece for fault in group],
            "error": group[0].error,
            "place": group[0].place,
            "traceback": group[0].traceback,
        }
        for group in groups.values()
    ]
