"""Where something stands in the input, and how foreign text is shown to the user."""

from __future__ import annotations

from typing import NamedTuple

from camcli.errors import Fault, printable

Path = tuple[str | int, ...]  # keys and list indices from the root of the scene


class Source(NamedTuple):
    """One input: a file (rank 0), a `--set` or an option; faults are listed in rank order."""

    rank: int
    name: str
    numbered: bool = False  # whether line and column help: true for files


class Mark(NamedTuple):
    """A place in a source; line and column count from 1, line 0 means the source as a whole."""

    source: Source
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        if self.source.numbered and self.line:
            return f"{self.source.name}:{self.line}:{self.column}"
        return self.source.name


class Finding(NamedTuple):
    """A fault together with its mark, so that faults can be ordered before they are shown."""

    mark: Mark
    path: Path
    found: str
    expected: str = ""
    cure: str = ""

    def fault(self) -> Fault:
        return Fault(str(self.mark), dotted(self.path), self.found, self.expected, self.cure)


def dotted(path: Path) -> str:
    """`('run', 'start', 'q')` as `run.start.q`."""
    return shown(".".join(shown(str(key), 40) for key in path[:40]), 160)


def shown(text: str, limit: int = 60) -> str:
    """Text of the user, cut to `limit` characters and safe to print on any terminal."""
    cut = text if len(text) <= limit else text[: limit - 3] + "..."
    return printable(cut)
