"""Finished pieces on disk: a plain file that is only appended to, a record for each piece.

    a line: CRC-32 of the rest, which begins with that of the run's key (see `_seed_of`); bytes of
            the arrays; [place, number, value] as JSON, see `pack`; as many spaces as make it a
            multiple of ALIGNED bytes
    the arrays of the value, as they are in memory

The first record says what the others belong to. A record is appended by one write, so that a kill
at any moment, a full disk or a power cut leaves whole records and at most one torn one at the end,
which is cut off when the file is opened again. A record that is damaged by anything else is passed
over: its piece is computed again. The newest record of a name counts. Pieces of the first QUICK
seconds wait for the next one after them, or for the end of a run that fails or is cut off.
"""

import errno
import json
import os
import re
from array import array
from collections.abc import Collection, Iterator
from functools import cache
from math import prod
from pathlib import Path
from stat import S_ISREG
from threading import Lock
from time import monotonic
from typing import Any, BinaryIO, NamedTuple
from zlib import crc32

from pydantic_core import from_json

from camcli.errors import Fault, SceneError
from camcli.interrupts import signals_held
from camcli.parallel.rows import Rows
from camcli.parallel.threads import memory

OUTLINE = {"dtype", "shape", "at"}  # of an array, in the JSON
DTYPES = ("<f8", "<i8", "<i4", "<i2", "|i1", "|b1", "|u1")
ALIGNED = 8  # bytes: an array begins at a multiple of so many in a record
MOST_KEY = 1 << 24  # bytes of the first line
SUM = 8  # bytes that a line begins with
HEAD = re.compile(rb"[0-9a-f]{8} ")  # of a line; a hole in a file is none, however long it is
SIZE = re.compile(rb"[0-9]{1,15}")
BEGINS = re.compile(rb"[0-9a-f]{8} [0-9]{1,15} \[")  # what a record begins with,
MOST_BEGIN = 26  # in so many bytes
MOST_SEARCHED = 1 << 26  # bytes of a file that are read to look for records behind damaged ones,
BLOCK = 1 << 16  # so many at a time
SHARE_OF_MEMORY = 0.25  # of this machine, that a line may take, and that arrays may
CAUTIOUS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
APPENDING = os.O_RDWR | os.O_CREAT | os.O_APPEND
QUICK = 1.0  # s: a run that takes no longer writes no pieces,
MOST_WAITING = 1 << 24  # unless their arrays take more bytes
NO_VALUE = (TypeError, OverflowError, RecursionError)  # of bytes that are not from `pack`
SYNC = 1.0  # s between two waits for the disk: what a power cut costs
FAR = 1 << 10  # rows of a table in which no piece need stand, beside as many as pieces
KEY, END = "key", "end"  # places of the first record, and of the one that completes a shard


class Stored(NamedTuple):
    """A record of a file: a piece by its place and number, its value, and where it stands.

    begin, end: bytes from the beginning of the file.
    """

    place: str
    number: int
    value: Any
    begin: int
    end: int


class _Index:
    """Where pieces are, by (place, number): file, begin and end.

    There may be a million of them. The pieces of a place are numbered from 0 on and come nearly in
    order, so that a piece has a row in the table of its place; one whose number is far beyond the
    rows so far, as a file of somebody else may hold, stands in a dict.
    """

    def __init__(self) -> None:
        self._tables: dict[str, array] = {}  # three whole numbers a row; a piece of no file has 0s
        self._far: dict[tuple[str, int], array] = {}
        self._counts: dict[str, int] = {}  # pieces of a place
        self._files: list[Path] = []

    def _row(self, name: tuple[str, int]) -> array:
        """Number of the file (from 1 on), begin and end of a piece; nothing, or 0s, without it."""
        place, number = name
        if number < 0 or name in self._far:
            return self._far.get(name, array("q"))
        return self._tables.get(place, array("q"))[3 * number : 3 * number + 3]

    def __contains__(self, name: tuple[str, int]) -> bool:
        """Whether a piece, (place, number), is in a file."""
        return any(self._row(name))

    def __getitem__(self, name: tuple[str, int]) -> tuple[Path, int, int]:
        """(file, begin, end) of a piece, (place, number)."""
        file, begin, end = self._row(name)
        return self._files[file - 1], begin, end

    def set(self, name: tuple[str, int], path: Path, begin: int, end: int) -> None:
        """Take note of where a piece is; the newest place counts."""
        if path not in self._files[-1:]:  # a file is read from its beginning to its end
            self._files.append(path)
        place, number = name
        if name not in self:
            self._counts[place] = self.count(place) + 1
        row = array("q", (len(self._files), begin, end))
        table = self._tables.setdefault(place, array("q"))
        if number < 0 or number > FAR + 2 * self.count(place) or name in self._far:
            self._far[name] = row
            return
        missing = number + 1 - len(table) // 3  # rows up to that of this piece
        table.extend([0] * (3 * missing))
        table[3 * number : 3 * number + 3] = row

    def count(self, place: str) -> int:
        """How many pieces there are of a place."""
        return self._counts.get(place, 0)

    def __len__(self) -> int:
        return sum(self._counts.values())

    def clear(self) -> None:
        """Forget all."""
        self._tables.clear()
        self._far.clear()
        self._counts.clear()


class Checkpoint:
    """Values by (place, number); `path` is appended to, `parts` (those of shards) are only read.

    In memory is only where each piece is. Threads may share a checkpoint.
    """

    def __init__(
        self,
        path: Path,
        key: str,
        parts: tuple[Path, ...] = (),
        most_waiting: int = MOST_WAITING,
    ):
        """Open or create; raises SceneError for a file with pieces of another key, OSError.

        most_waiting: bytes of arrays of pieces that wait to be written while a run is young.
        """
        self.path = path
        self._seed = _seed_of(key)
        self._most_waiting = most_waiting
        self.size = 0  # bytes of all records
        self.damaged = 0  # bytes between them that are none
        self._on_disk = _Index()
        self._waiting: dict[tuple[str, int], Any] = {}  # values to be written
        self._waiting_bytes = 0
        self._lock = Lock()
        for part in parts:
            with open_pieces(part) as file:
                self._read(file, key, part)
        self._file = open_pieces(path, "ab")
        try:
            with open_pieces(path) as file:
                end = self._read(file, key, path)
            self.torn = self._file.seek(0, os.SEEK_END) - end  # bytes
            self._file.truncate(end)
            if end == 0:
                self._file.write(_record(KEY, 0, key, 0))
        except BaseException:
            self._file.close()
            raise
        self._begun = self._synced = monotonic()
        self.resumed = self.pieces  # pieces there were at the beginning

    def _read(self, file: BinaryIO, key: str, path: Path) -> int:
        """Take note of the whole records of a file; returns where they end, in bytes.

        Raises SceneError where its first record is not that of this key.
        """
        end = 0
        first: Stored | None = None
        for record in records(file):
            self.damaged += record.begin - end
            if record.begin == 0:
                first = record
            else:
                self._on_disk.set((record.place, record.number), path, record.begin, record.end)
            end = record.end
        self.size += end
        if first is None and path == self.path:
            file.seek(0)
            head = file.read(SUM)  # of nothing, of a first line that was cut, or of zeros
            if _record(KEY, 0, key, 0).startswith(head) or head == bytes(SUM):
                return 0
        if first is None or (first.place, first.number, first.value) != (KEY, 0, key):
            raise refused(path, "found no pieces of this run", "expected them")
        return end

    @property
    def pieces(self) -> int:
        """The number of pieces in the checkpoint, without the record that ends a shard."""
        on_disk = len(self._on_disk) - self._on_disk.count(END)
        waiting = [name for name in self._waiting if name not in self._on_disk]
        waiting_pieces = [name for name in waiting if name[0] != END]
        return on_disk + len(waiting_pieces)

    def expected_size(self, pieces: int, beside: int) -> float:
        """Bytes of all pieces once there are so many, the further ones like those so far.

        beside: bytes that are counted of a piece in addition.
        """
        count = len(self._on_disk) + len(self._waiting)
        size = self.size + self._waiting_bytes + beside * count
        return size * max(1.0, pieces / max(1, count))

    def __contains__(self, name: tuple[str, int]) -> bool:
        """Whether a piece, (place, number), is in the checkpoint."""
        return name in self._on_disk or name in self._waiting

    def get(self, place: str, number: int, names: Collection[str] | None = None) -> Any:
        """The value of a piece that is there; raises SceneError where it is damaged, OSError.

        names: of the entries that are wanted of a value that is a dict; None for all of it.
        """
        if (place, number) in self._waiting:
            with self._lock:
                self._write()
        path, begin, end = self._on_disk[place, number]
        data = self._bytes(path, begin, end)
        arrays_begin = data.find(b"\n") + 1
        arrays = memoryview(data)[arrays_begin:]
        parsed = _parsed(data[:arrays_begin], arrays, self._seed, names)
        if parsed is not None:
            its_place, its_number, value = parsed
            if (its_place, its_number) == (place, number):
                return value
        found = f"piece {place}/{number} was changed or damaged while the run was at work"
        raise refused(path, found, "expected it whole")

    def _bytes(self, path: Path, begin: int, end: int) -> bytes:
        """A part of a file; that of this run stays open, those of shards may be too many."""
        if path is self.path and not self._file.closed:
            return os.pread(self._file.fileno(), end - begin, begin)
        with open_pieces(path) as file:
            file.seek(begin)
            return file.read(end - begin)

    def rows(self, width: int) -> Rows:
        """Rows of so many bytes each, in a file beside this one."""
        return Rows(width, self.path.parent)

    def path_of(self, place: str, number: int) -> Path:
        """The file that holds a piece of the checkpoint."""
        return self._on_disk[place, number][0] if (place, number) in self._on_disk else self.path

    def put(self, place: str, number: int, value: Any) -> None:
        """Keep a piece; raises SceneError where there is no room, the file is then as before."""
        with self._lock:
            self._waiting[place, number] = value
            may_wait = monotonic() - self._begun <= QUICK and not self._file.closed
            if may_wait:
                self._waiting_bytes += _bytes_of(value)
            if not may_wait or self._waiting_bytes > self._most_waiting:
                self._write()

    def _write(self) -> None:
        """Append the pieces that wait to be written; raises SceneError where there is no room.

        A record that cannot be written whole is cut off again.
        """
        for name in list(self._waiting):
            place, number = name
            record = _record(place, number, self._waiting[name], self._seed)
            left = memoryview(record)
            begin = self._file.seek(0, os.SEEK_END)
            try:
                while left:
                    written = self._file.write(left)
                    left = left[written:]
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
            self._on_disk.set(name, self.path, begin, begin + len(record))
            self.size += len(record)
            del self._waiting[name]
        self._waiting_bytes = 0

    def close(self) -> None:
        """Write what waits, and close the file; it is removed where it holds nothing.

        A thread that is still at work puts nothing more.
        """
        with signals_held(), self._lock:
            try:
                if not self._file.closed:
                    self._write()
            finally:
                self._file.close()
                if not self._on_disk:
                    self.path.unlink(missing_ok=True)

    def discard(self) -> None:
        """Close and delete: the work is finished."""
        self._on_disk.clear()
        self._waiting.clear()
        self.close()


def open_pieces(path: Path, mode: str = "rb") -> Any:
    """Open a file of pieces, and nothing else: no link is followed, no pipe waited for.

    mode: rb to read, ab to append, without a buffer. Raises OSError where it is no plain file.
    """
    reading = mode == "rb"
    handle = os.open(path, CAUTIOUS | (os.O_RDONLY if reading else APPENDING), 0o666)
    if not S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "no plain file")
    return open(handle, mode, buffering=-1 if reading else 0)


def key_of(path: Path) -> tuple[str, dict]:
    """(key, value of the record END or {}) of a file of pieces; raises SceneError, OSError."""
    key = None
    end = {}
    with open_pieces(path) as file:
        for record in records(file):
            if record.begin == 0:
                key = record.value if record.place == KEY else None
            elif record.place == END and isinstance(record.value, dict):
                end = record.value
    if not isinstance(key, str):
        raise refused(path, "found no pieces", "expected a file of --shard I/N")
    return key, end


def most_line() -> int:
    """The bytes of a line, or of arrays, that are read at most: a file may exceed any memory."""
    return int(SHARE_OF_MEMORY * memory())


def records(file: BinaryIO) -> Iterator[Stored]:
    """The records of a file from its beginning; what is damaged between two is passed over.

    Nothing is looked for behind a first record that is damaged: it says whose the others are.
    """
    reader = _Reader(file)
    begin = 0
    while True:
        record = reader.record_at(begin, MOST_KEY if begin == 0 else most_line())
        if record is None and begin > 0:
            record = reader.first_behind(begin)
        if record is None:
            return
        yield record
        begin = record.end


class _Reader:
    """Reads records of a file.

    seed: of the check sums, see `_seed_of`, known once the first record has been read; left: bytes
    that may still be read to look for records behind damaged ones.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._size = file.seek(0, os.SEEK_END)
        self._seed = 0
        self._left = MOST_SEARCHED

    def record_at(self, begin: int, most: int) -> Stored | None:
        """The record that begins here (bytes), its line and its arrays of at most so many bytes.

        None where none does, or a damaged one, or one of another run.
        """
        if begin >= self._size:
            return None
        self._file.seek(begin)
        head = self._file.read(SUM + 1)  # the check sum and a space
        if not HEAD.fullmatch(head):
            return None
        line = head + self._file.readline(most)
        arrays_begin = begin + len(line)
        size = _size_of_arrays(line)
        if size is None or size > min(most, self._size - arrays_begin):
            return None
        parsed = _parsed(line, self._file.read(size), self._seed)
        if parsed is None:
            return None
        place, number, value = parsed
        if begin == 0:
            self._seed = _seed_of(value)
        return Stored(place, number, value, begin, arrays_begin + size)

    def first_behind(self, begin: int) -> Stored | None:
        """The first whole record behind one that is damaged and begins here; None: none is found.

        It is looked for at what looks like one, and at last where the damaged one says that it
        ends.
        """
        for place in self._what_looks_like_one(begin + 1):
            record = self.record_at(place, self._left)
            self._left -= self._file.tell() - place
            if record is not None:
                return record
        self._file.seek(begin)
        line = self._file.readline(most_line())
        size = _size_of_arrays(line)
        return None if size is None else self.record_at(begin + len(line) + size, most_line())

    def _what_looks_like_one(self, begin: int) -> Iterator[int]:
        """Where in the file something begins as a record does, from here on (bytes)."""
        while self._left > 0:
            self._file.seek(begin)
            block = self._file.read(BLOCK)
            self._left -= len(block)
            for like_one in BEGINS.finditer(block):
                if self._left <= 0:
                    return
                yield begin + like_one.start()
            if len(block) < BLOCK:
                return
            begin += len(block) - MOST_BEGIN  # one that is cut here is whole in the next block


def _seed_of(key: Any) -> int:
    """What the check sums of a run's pieces begin with, so that no other run's are taken for them.

    key: the value of the first record, whose own check sum begins with 0.
    """
    return crc32(key.encode()) if isinstance(key, str) else 0


def _record(place: str, number: int, value: Any, seed: int) -> bytes:
    """The bytes of a record: its line, see the head of this file, and the arrays behind it.

    seed: of its check sum.
    """
    data, arrays = pack([place, number, value])
    rest = b"%d %s" % (len(arrays), data)  # of the line, behind the check sum and a space
    size_of_line = SUM + len(b" ") + len(rest) + len(b"\n")
    rest += b" " * (-size_of_line % ALIGNED) + b"\n"
    return b"".join([_check(rest, arrays, seed), b" ", rest, arrays])


def _size_of_arrays(line: bytes) -> int | None:
    """What a line says of the arrays that follow it; None where it is no whole line."""
    size = line[SUM + 1 :].partition(b" ")[0]
    return int(size) if SIZE.fullmatch(size) and line.endswith(b"\n") else None


def _parsed(
    line: bytes, arrays: bytes | memoryview, seed: int, names: Collection[str] | None = None
) -> tuple[str, int, Any] | None:
    """Place, number and value of a record, see `Checkpoint.get`; None where it is damaged."""
    rest = line[SUM + 1 :]
    if line[:SUM] != _check(rest, arrays, seed):
        return None
    _size, _, data = rest.partition(b" ")
    try:
        record = unpack(data, arrays) if names is None else from_json(data)
        match record:
            case [str(place), int(number), value]:
                if names is not None:
                    value = _entries(value, names, arrays)
                return place, number, value
    except (ValueError, *NO_VALUE):
        pass
    return None


def _entries(value: Any, names: Collection[str], arrays: bytes | memoryview) -> Any:
    """These entries of a dict whose arrays are outlines still; another value as it is.

    Raises ValueError for outlines of no array.
    """
    if not isinstance(value, dict):
        return value
    entries = {name: value[name] for name in names if name in value}
    for name, entry in entries.items():
        if isinstance(entry, list):
            entries[name] = [
                _array(item, arrays) if isinstance(item, dict) else item for item in entry
            ]
    return entries


def _bytes_of(value: Any) -> int:
    """What the arrays in a value take."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return sum(map(_bytes_of, value))
    return getattr(value, "nbytes", 0)


def _check(rest: bytes, arrays: bytes | memoryview, seed: int) -> bytes:
    """The check sum of a record: CRC-32 from this seed on, in SUM hexadecimal digits."""
    return b"%08x" % crc32(arrays, crc32(rest, seed))


def refused(path: Path, found: str, expected: str) -> SceneError:
    """The refusal of a file of pieces that is damaged, or not ours."""
    return SceneError(
        Fault(str(path), "", found, expected, "delete the file, or choose another folder")
    )


def pack(value: Any) -> tuple[bytes, bytes]:
    """JSON of a plain value, and the bytes of the arrays in it.

    In the JSON an array is {"dtype", "shape", "at"}; `at` is where it begins in these bytes.
    Floats keep every bit (of a NaN outside an array, that it is one); tuples and ranges come back
    as lists, arrays as views that may not be written. Raises TypeError for what is none of this:
    nothing is pickled, nothing read can run code.
    """
    arrays: list[bytes] = []
    size = 0  # of all arrays so far, a multiple of ALIGNED

    def outline(value: Any) -> Any:
        """What stands in the JSON for a value that JSON has no form for."""
        nonlocal size
        if isinstance(value, range):
            return list(value)
        if not hasattr(value, "dtype"):
            raise TypeError(f"a {type(value).__name__} cannot be kept")
        if value.ndim == 0:
            return value.item()
        dtype = value.dtype.str
        if dtype not in DTYPES:  # of a machine with another order of bytes, or none of ours
            value = value.astype(value.dtype.newbyteorder("<"))
            dtype = value.dtype.str
        if dtype not in DTYPES:
            raise TypeError(f"an array of {value.dtype} cannot be kept")
        begin = size
        data = value.tobytes()
        padding = bytes(-len(data) % ALIGNED)
        arrays.extend((data, padding))
        size += len(data) + len(padding)
        return {"dtype": dtype, "shape": value.shape, "at": begin}

    text = json.dumps(value, default=outline, separators=(",", ":"))
    return text.encode(), b"".join(arrays)


@cache
def _dtypes() -> dict[str, Any]:
    """The dtypes of arrays by their names: numpy reads a name anew each time it is given one."""
    import numpy as np

    return {name: np.dtype(name) for name in DTYPES}


def _array(outline: dict, arrays: bytes | memoryview) -> Any:
    """The array that a dict of the JSON stands for; another dict as it is.

    Raises ValueError for a shape that these bytes have no room for, or below nothing.
    """
    import numpy as np

    if outline.keys() != OUTLINE:
        return outline
    name = outline["dtype"]
    shape = outline["shape"]
    at = outline["at"]
    if name not in DTYPES or not isinstance(shape, list) or not isinstance(at, int):
        return outline
    if shape and min(shape) < 0:
        raise ValueError("found a shape below nothing")
    return np.frombuffer(arrays, _dtypes()[name], prod(shape), at).reshape(shape)


def unpack(data: bytes, arrays: bytes | memoryview = b"") -> Any:
    """The value of these bytes; raises ValueError where they are not from `pack`."""

    def array(outline: dict) -> Any:
        """The array that a dict of the JSON stands for; another dict as it is."""
        return _array(outline, arrays)

    try:
        return json.loads(data, object_hook=array)
    except NO_VALUE as error:
        raise ValueError(f"no value ({error})") from None
