"""Finished pieces on disk: an append-only file of records, each with its sum.

    record   MAGIC, CRC-32 and length of the payload; payload: `pack([place, number, value])`

The first record says what the others belong to. A record is appended by one write, so that a kill
at any moment, a full disk or a power cut leaves whole records and at most one torn one at the end,
which is cut off when the file is opened again. The newest record of a name counts.

Why no database: pieces are large arrays (25 kB a speed), which SQLite writes twice and whose bits
it does not check; its locks fail on many network folders; and the sum and the codec below would be
needed all the same.
"""

from __future__ import annotations

import json
import os
import struct
from array import array
from collections.abc import Iterator
from math import prod
from pathlib import Path
from threading import Lock
from time import monotonic
from typing import Any, BinaryIO
from zlib import crc32

from camcli.errors import Fault, SceneError

MAGIC = b"camp"
HEAD = struct.Struct("<4sIQ")
DTYPES = ("<f8", "<i8", "<i4", "<i2", "|i1", "|b1", "|u1")
MOST_PIECES = 1 << 26  # numbers of one place: a damaged one must not ask for all memory
MOST_KEY = 1 << 24  # bytes of the first record
SYNC = 1.0  # s between two waits for the disk: what a power cut costs
KEY, END = "key", "end"  # places of the first record, and of the one that completes a shard


class Checkpoint:
    """Values by (place, number); `path` is appended to, `parts` (those of shards) are only read.

    Memory: eight bytes a piece, which say where it is. Threads may share one.
    """

    def __init__(self, path: Path, key: str, parts: tuple[Path, ...] = ()):
        """Open or create; raises SceneError for a file with pieces of another key, OSError."""
        self.path = path
        self.pieces = 0
        self._files = (path, *parts)
        self._found: dict[str, array] = {}  # place -> 1 + file + len(files) * offset, 0: none
        self._lock = Lock()
        for n, part in enumerate(parts, 1):
            with open(part, "rb") as file:
                self._read(file, key, n)
        self._file = open(path, "a+b", buffering=0)  # noqa: SIM115 - see close()
        try:
            with open(path, "rb") as file:
                end, size = self._read(file, key, 0), os.fstat(file.fileno()).st_size
            self.torn = size - end  # bytes
            self._file.truncate(end)
            if end == 0:
                self._file.write(_record(KEY, 0, key))
        except BaseException:
            self._file.close()
            raise
        self._synced = monotonic()
        self.resumed = self.pieces  # pieces there were at the beginning

    def _read(self, file: BinaryIO, key: str, n: int) -> int:
        """Take note of the whole records of a file; where they end."""
        end, first = 0, None
        for place, number, value, begin, after in records(file, MOST_KEY):
            if begin:
                self._take_note(place, number, n, begin)
            else:
                first = place, number, value
            end = after
        if first is None and n == 0:  # nothing, or a first record that was torn
            file.seek(0)
            if _record(KEY, 0, key).startswith(file.read(MOST_KEY)):
                return 0
        if first != (KEY, 0, key):
            raise refused(self._files[n], "found no pieces of this run", "expected them")
        return end

    def _take_note(self, place: str, number: int, n: int, begin: int) -> None:
        places = self._found.setdefault(place, array("q"))
        if number >= len(places):
            places.frombytes(bytes(places.itemsize * (number + 1 - len(places))))
        self.pieces += place != END and places[number] == 0
        places[number] = 1 + n + len(self._files) * begin

    def __contains__(self, name: tuple[str, int]) -> bool:
        place, number = name
        places = self._found.get(place, ())
        return number < len(places) and places[number] != 0

    def get(self, place: str, number: int) -> Any:
        """The value of a piece that is there; raises SceneError where it is damaged, OSError."""
        begin, n = divmod(self._found[place][number] - 1, len(self._files))
        with open(self._files[n], "rb") as file:
            file.seek(begin)
            for *name, value, _, _ in records(file):
                if name == [place, number]:
                    return value
                break
        raise refused(self._files[n], f"piece {place}/{number} was damaged", "expected it whole")

    def put(self, place: str, number: int, value: Any) -> None:
        """Append a piece; raises SceneError where there is no room, the file is then as before."""
        rest = memoryview(_record(place, number, value))
        with self._lock:
            begin = self._file.seek(0, os.SEEK_END)
            try:
                while rest:
                    rest = rest[self._file.write(rest) :]
                if monotonic() - self._synced > SYNC:
                    os.fsync(self._file.fileno())
                    self._synced = monotonic()
            except OSError as error:
                self._file.truncate(begin)
                found = f"could not be written ({error.strerror})"
                fault = Fault(str(self.path), "", found, "", "make room, then repeat the command")
                raise SceneError(fault) from None
            except BaseException:  # an interrupt
                self._file.truncate(begin)
                raise
            self._take_note(place, number, 0, begin)

    def close(self) -> None:
        """Close; a thread that is still at work puts nothing more. A file without a piece goes."""
        with self._lock:
            self._file.close()
        if not self._found:
            self.path.unlink(missing_ok=True)

    def discard(self) -> None:
        """Close and delete: the work is finished."""
        self._found.clear()
        self.close()


def key_of(path: Path) -> tuple[str, list | None]:
    """(key, value of the record END or None) of a file of pieces; raises SceneError, OSError."""
    key, end = None, None
    with open(path, "rb") as file:
        for place, _, value, begin, _ in records(file, MOST_KEY):
            if begin == 0:
                key = value if place == KEY else None
            elif place == END:
                end = value
    if not isinstance(key, str):
        raise refused(path, "found no pieces", "expected a file of --shard I/N")
    return key, end


def records(
    file: BinaryIO, most_first: int | None = None
) -> Iterator[tuple[str, int, Any, int, int]]:
    """(place, number, value, begin, end) of each record from here, up to the first damaged one."""
    end, total = file.tell(), os.fstat(file.fileno()).st_size
    while len(head := file.read(HEAD.size)) == HEAD.size:
        begin = end
        magic, check, size = HEAD.unpack(head)
        end += HEAD.size + size
        if magic != MAGIC or end > total or (most_first and begin == 0 and size > most_first):
            return
        payload = file.read(size)
        if crc32(payload) != check:
            return
        try:
            named = unpack(payload)
        except ValueError:
            return
        match named:
            case [str(place), int(number), value] if 0 <= number < MOST_PIECES:
                yield place, number, value, begin, end
            case _:
                return


def _record(place: str, number: int, value: Any) -> bytes:
    payload = pack([place, number, value])
    return HEAD.pack(MAGIC, crc32(payload), len(payload)) + payload


def refused(path: Path, found: str, expected: str) -> SceneError:
    """The refusal of a file of pieces that is damaged, or not ours."""
    return SceneError(
        Fault(str(path), "", found, expected, "delete the file, or choose another folder")
    )


def pack(value: Any) -> bytes:
    """The bytes of a plain value: a line of JSON, then its arrays (little-endian, C order).

    In the JSON an array is {"dtype", "shape"}. Floats keep every bit (of a NaN outside an array,
    that it is one); tuples and ranges come back as lists, arrays as views that may not be written.
    Raises TypeError for what is none of this: nothing is pickled, nothing read can run code.
    """
    arrays: list[bytes] = []

    def outline(value: Any) -> Any:
        if isinstance(value, range):
            return list(value)
        if hasattr(value, "dtype") and value.ndim == 0:
            return value.item()
        if hasattr(value, "dtype"):
            little = value.astype(value.dtype.newbyteorder("<"), copy=False)
            if little.dtype.str in DTYPES:
                arrays.append(little.tobytes())
                return {"dtype": little.dtype.str, "shape": little.shape}
        raise TypeError(f"a {type(value).__name__} cannot be kept")

    text = json.dumps(value, default=outline, separators=(",", ":"))
    return b"".join([text.encode(), b"\n", *arrays])


def unpack(data: bytes) -> Any:
    """The value of these bytes; raises ValueError where they are not from `pack`."""
    end = data.index(b"\n")
    rest, at = memoryview(data)[end + 1 :], 0

    def array_of(outline: dict) -> Any:
        nonlocal at
        if outline.keys() != {"dtype", "shape"}:
            return outline
        import numpy as np

        name, shape = outline["dtype"], outline["shape"]
        if name not in DTYPES:
            raise ValueError(f"an array of {name!r}")
        dtype = np.dtype(name)
        size = prod(shape) * dtype.itemsize
        taken, at = rest[at : at + size], at + size
        return np.frombuffer(taken, dtype).reshape(shape)

    try:
        value = json.loads(data[:end], object_hook=array_of)
    except (TypeError, OverflowError, RecursionError) as error:
        raise ValueError(f"no value ({error})") from None
    if at != len(rest):
        raise ValueError("more or fewer bytes than its arrays take")
    return value
