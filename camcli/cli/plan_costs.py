"""Seconds and bytes of the parts of a command, measured once, on one machine, with nothing else.

A look at the work (plan_probe.py) tells how much slower another machine is at the moment; what a
part takes in proportion to the others is a property of the program.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from camcli.analysis.integrate import PLAIN_STEPS
from camcli.cli.plan_probe import COMPILED, Glance
from camcli.kernel import backend
from camcli.parallel import thread_count

START = 0.33  # s: start-up, and reading the scene
KERNEL = 0.4  # s: loading numba and the compiled kernel from its cache
DRAWING = 0.55  # s: loading matplotlib, a picture without points
POINT = 2e-7  # s per point of a picture
TEXT, AGAIN = 1.1e-8, 5e-9  # s per byte of a table: made, written and hashed; of a known number
PIECE = 6e-9  # s per byte of finished pieces: written once, read some times
SLOWEST = 4.0  # more is a hiccup of the look, not the pace of a machine
ENOUGH = 0.02  # s of work that tell the pace of a machine
MB = 1_000_000
PROCESS, COMPILER, PICTURE = 45 * MB, 130 * MB, 125 * MB  # bytes of memory
RECORD = 5_000  # bytes of run.json
COMPILING = "compiling the kernel for this machine comes on top, once: some 20 to 60 s"


@dataclass(frozen=True)
class Pace:
    """How fast this machine is: `slow` times the seconds above; turn: s in plain Python, there."""

    slow: float
    turn: float

    @classmethod
    def of(cls, seen: Sequence[Glance]) -> Pace:
        """From what was looked at."""
        nominal = sum(one.nominal for one in seen)
        slow = sum(one.plain for one in seen) / nominal if nominal > ENOUGH else 1.0
        return cls(min(SLOWEST, max(0.1, slow)), sum(one.turn for one in seen) / max(1, len(seen)))

    def kernel(self, turns: float, lanes: int, compiled: bool) -> float:
        """Seconds of so many turns, before `slow`; plain Python has one lane."""
        return self.turn * turns / (COMPILED * max(1, lanes) if compiled else 1.0)


def compiles(turns: int, little: int, steps_each: float) -> bool:
    """Whether a run of so many turns will use the compiled kernel."""
    if not backend.may_compile():
        return False
    return backend.must_compile() or turns > little or steps_each > PLAIN_STEPS


def lanes_of(threads: int | None, pieces: int) -> int:
    """Pieces that run at a time."""
    return max(1, min(thread_count(threads), pieces))


def digits(count: int) -> float:
    """Mean number of digits of 0, 1, ..., count - 1."""
    total, low, width = 0, 0, 1
    while low < count:
        high = min(count, 10**width)
        total += width * (high - low)
        low, width = high, width + 1
    return total / max(1, count)


def compile_note(compiled: bool, entries: Sequence[str] = ("advance",)) -> tuple[str, ...]:
    """A line where the run will have to compile first."""
    if not compiled or all(backend.is_cached(entry) for entry in entries):
        return ()
    return (COMPILING,)
