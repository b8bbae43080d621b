"""Finished pieces on disk: one file, appended to, each record checked.

    record   MAGIC, lengths of name and payload, CRC-32 of all else; name; payload (`codec`)

The first record, without a name, says what the others belong to. A record is appended by one write,
so a kill at any moment leaves whole records and at most one torn one at the end, which is cut off
when the file is opened again. A write that fails (a full disk) is cut off at once.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import Any, BinaryIO
from zlib import crc32

from camcli.parallel.codec import pack, unpack
from camcli.parallel.index import Index

MAGIC = b"CAMp"
HEAD = struct.Struct("<4sIQI")
SIZES = struct.Struct("<4sIQ")  # what the CRC covers of it
MOST_NAME = 1 << 12  # bytes
MOST_HEADER = 1 << 24  # bytes of what the pieces belong to
BLOCK = 1 << 20
PATIENCE = 5.0  # s: for a thread that is writing, before the file is closed all the same
HEADER = ""  # name of the first record


class JournalError(Exception):
    """The file is no journal, or belongs to other work."""


class Journal:
    """Records by name; `path` is appended to, `parts` (journals of shards) are only read."""

    def __init__(self, path: Path, header: str, parts: tuple[Path, ...] = ()):
        """Open or create; raises JournalError for a file with another header, OSError."""
        self.path = path
        self.index = Index()  # file 0 is our own, then the parts
        self.parts = parts
        self._lock = Lock()
        for number, part in enumerate(parts, 1):
            self._read_part(part, header, number)
        self._file = open(path, "a+b", buffering=0)  # noqa: SIM115 - see close()
        try:
            self._open_own(header)
        except BaseException:
            self.close()
            raise
        self.found = len(self.index)  # pieces there were at the beginning

    def _read_part(self, part: Path, header: str, number: int) -> None:
        with open(part, "rb", buffering=0) as file:
            if self._take(file, header, number) == 0:
                raise JournalError(f"{part} holds no pieces")

    def _open_own(self, header: str) -> None:
        """Index what is whole, cut off what is torn."""
        end, size = self._take(self._file, header, 0), self._file.seek(0, os.SEEK_END)
        if end == 0 and not _record(HEADER, header).startswith(_read(self._file, 0, size)):
            raise JournalError(f"{self.path} is no journal")
        self.torn = size - end
        self._file.truncate(end)
        if end == 0:
            self._append(HEADER, header)

    def _take(self, file: BinaryIO, header: str, number: int) -> int:
        """Index the whole records; the end of the last one, 0 where there is not even a header."""
        expected, end = pack(header), 0
        for name, offset, size, after in records(file):
            if end:
                self.index.put(name, number, end)
            elif name != HEADER or size != len(expected) or _read(file, offset, size) != expected:
                where = self.parts[number - 1] if number else self.path
                raise JournalError(f"{where} belongs to other work")
            end = after
        return end

    def __contains__(self, name: str) -> bool:
        return name in self.index

    def get(self, name: str) -> Any:
        """The value of a record; raises KeyError, OSError, and ValueError where it holds none."""
        number, at = self.index.get(name)
        if number == 0:
            with self._lock:
                return unpack(_payload(self._file, at))
        with open(self.parts[number - 1], "rb", buffering=0) as file:
            return unpack(_payload(file, at))

    def put(self, name: str, value: Any) -> None:
        """Append a record; raises OSError, the file then ends where it did before."""
        with self._lock:
            self.index.put(name, 0, self._append(name, value))

    def _append(self, name: str, value: Any) -> int:
        """Write a record at the end; returns where it begins."""
        end = self._file.seek(0, os.SEEK_END)
        rest = memoryview(_record(name, value))
        try:
            while len(rest):
                rest = rest[self._file.write(rest) :]
        except BaseException:  # an interrupt too
            self._file.truncate(end)
            raise
        return end

    def close(self) -> None:
        """Close; what was put stays. A thread that is still at work puts nothing more."""
        free = self._lock.acquire(timeout=PATIENCE)
        self._file.close()
        if free:
            self._lock.release()

    def discard(self) -> None:
        """Close and delete: the work is finished."""
        self.close()
        self.path.unlink(missing_ok=True)


def header_of(path: Path) -> str:
    """What the pieces in a file belong to; raises JournalError, OSError."""
    with open(path, "rb", buffering=0) as file:
        for name, offset, size, _ in records(file, MOST_HEADER):
            header = value_of(file, offset, size) if name == HEADER else None
            if isinstance(header, str):
                return header
            break
    raise JournalError(f"{path} holds no pieces")


def one_of(path: Path, wanted: str) -> Any:
    """The value of the last record of this name, None without; raises OSError."""
    found = None
    with open(path, "rb", buffering=0) as file:
        for name, offset, size, _ in records(file):
            if name == wanted:
                found = value_of(file, offset, size)
    return found


def value_of(file: BinaryIO, offset: int, size: int) -> Any:
    """The value of a payload, None where it holds none or a giant."""
    try:
        return unpack(_read(file, offset, size)) if size <= MOST_HEADER else None
    except ValueError:
        return None


def records(file: BinaryIO, most: int | None = None) -> Iterator[tuple[str, int, int, int]]:
    """(name, offset of the payload, its bytes, end) of each whole record, to the first bad one.

    One with a payload of more than `most` bytes is bad.
    """
    total, at = file.seek(0, os.SEEK_END), 0
    while at + HEAD.size <= total:
        magic, label_size, size, check = HEAD.unpack(_read(file, at, HEAD.size))
        offset = at + HEAD.size + label_size
        if magic != MAGIC or label_size > MOST_NAME or offset + size > total:
            return
        if most is not None and size > most:
            return
        label = _read(file, offset - label_size, label_size)
        value = crc32(label, crc32(SIZES.pack(magic, label_size, size)))
        for begin in range(0, size, BLOCK):
            value = crc32(_read(file, offset + begin, min(BLOCK, size - begin)), value)
        if value != check:
            return
        at = offset + size
        yield label.decode(errors="replace"), offset, size, at


def _record(name: str, value: Any) -> bytes:
    label, data = name.encode(), pack(value)
    sizes = SIZES.pack(MAGIC, len(label), len(data))
    check = crc32(data, crc32(label, crc32(sizes)))
    return b"".join([HEAD.pack(MAGIC, len(label), len(data), check), label, data])


def _payload(file: BinaryIO, at: int) -> bytes:
    """The payload of the record that begins here; raises ValueError where there is none."""
    head = _read(file, at, HEAD.size)
    if len(head) < HEAD.size:
        raise ValueError("the file has become shorter")
    _, label_size, size, _ = HEAD.unpack(head)
    return _read(file, at + HEAD.size + label_size, size)


def _read(file: BinaryIO, offset: int, size: int) -> bytes:
    file.seek(offset)
    data = file.read(size) or b""
    while len(data) < size and (more := file.read(size - len(data))):
        data += more
    return data
