"""Rows of equal size by their number, for what a run keeps of each of its many pieces."""

from __future__ import annotations

import os
from pathlib import Path
from tempfile import TemporaryFile
from weakref import finalize

from camcli.errors import Fault, SceneError

NEWEST = 1 << 16  # bytes of rows that wait in memory to be written


class Rows:
    """Rows of `width` bytes, appended by one thread; they pickle, as rows in memory.

    In a folder they are in a file without a name, which is gone when nobody holds the rows any
    more; only the newest are in memory. Without a folder all are.
    """

    def __init__(self, width: int, folder: Path | None = None):
        self._width = width
        self._folder = folder
        self._handle: int | None = None  # of the file, which the first row that is written makes
        self._written = 0  # bytes in the file
        self._newest = bytearray()

    def __len__(self) -> int:
        return (self._written + len(self._newest)) // self._width

    def append(self, row: bytes) -> None:
        """Add a row; raises SceneError where the disk has no room for it."""
        self._newest += row
        if self._folder is not None and len(self._newest) >= NEWEST:
            self._write(self._folder)

    def __getitem__(self, k: int) -> bytes | bytearray:
        """Row k, for k from 0 on."""
        begin = k * self._width - self._written
        if begin >= 0:
            return self._newest[begin : begin + self._width]
        assert self._handle is not None
        return os.pread(self._handle, self._width, k * self._width)

    def _write(self, folder: Path) -> None:
        """Write the newest rows to the file; raises SceneError where there is no room."""
        try:
            if self._handle is None:
                file = TemporaryFile(buffering=0, dir=folder)  # noqa: SIM115 - see finalize
                finalize(self, file.close)
                self._handle = file.fileno()
            while self._newest:
                written = os.write(self._handle, self._newest)
                del self._newest[:written]
                self._written += written
        except OSError as error:
            found = f"the rows of a table could not be written ({error.strerror})"
            cure = "make room, then repeat the command"
            raise SceneError(Fault(str(folder), "", found, "", cure)) from None

    def __reduce__(self) -> tuple:
        return _in_memory, (self._width, b"".join(self[k] for k in range(len(self))))


def _in_memory(width: int, content: bytes) -> Rows:
    """Rows that have been pickled."""
    rows = Rows(width)
    rows.append(content)
    return rows
