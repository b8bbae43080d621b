"""Until when a part of the bench goes on: what is left of its time is shared by what is left to do.

A piece of work is never stopped from outside: it is given seconds and keeps to them, and where none
are left it is not begun and says so (NOT_REACHED). So a part overruns by one piece at the most.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from time import monotonic

NOT_REACHED = "not-reached"  # status of a piece that the clock left no time for


@dataclass(frozen=True)
class Clock:
    """The end of a part in seconds of `time.monotonic`; inf: no end."""

    until: float = inf

    def left(self) -> float:
        """Seconds of wall time that are left, 0 beyond the end."""
        return max(0.0, self.until - monotonic())

    @property
    def over(self) -> bool:
        """True where nothing more may begin."""
        return self.left() <= 0.0

    def share(self, pieces: int) -> float:
        """Seconds for the next of so many pieces that are left, the same for each."""
        return self.left() / max(1, pieces)


@dataclass
class Schedule:
    """Clocks of parts that follow each other: what one does not use the next ones may.

    `seconds` of each part; inf: it takes what it takes, and nothing from the others.
    """

    seconds: Mapping[str, float]
    until: float = field(default_factory=monotonic)
    endless: float | None = None  # when a part without end began

    def clock(self, part: str) -> Clock:
        """The clock of a part that begins now."""
        now = monotonic()
        if self.endless is not None:
            self.until += now - self.endless
        self.endless = now if self.seconds[part] == inf else None
        if self.endless is not None:
            return Clock()
        self.until += self.seconds[part]
        return Clock(self.until)
