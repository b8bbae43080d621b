"""Finished pieces on disk: a plain file that is only appended to, a piece in each line.

    CRC-32 of the rest, [place, number, value] as JSON; see `pack`

The first line says what the others belong to. A line is appended by one write, so that a kill at
any moment, a full disk or a power cut leaves whole lines and at most one torn one at the end, which
is cut off when the file is opened again. The newest line of a name counts. Pieces of the first
QUICK seconds wait for the next one after them, or for the end of a run that fails or is cut off.
"""

import errno
import json
import os
import re
from binascii import a2b_base64, b2a_base64
from collections.abc import Iterator
from pathlib import Path
from stat import S_ISREG
from threading import Lock
from time import monotonic
from typing import Any, BinaryIO
from zlib import crc32

from camcli.errors import Fault, SceneError
from camcli.interrupts import held
from camcli.parallel.threads import memory

DTYPES = ("<f8", "<i8", "<i4", "<i2", "|i1", "|b1", "|u1")
MOST_KEY = 1 << 24  # bytes of the first line
SUM = 8  # bytes that a line begins with
HEAD = re.compile(rb"[0-9a-f]{8} ")  # of a line; a hole in a file is none, however long it is
SHARE_OF_MEMORY = 0.25  # of this machine, that a line may take
CAUTIOUS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
APPENDING = os.O_WRONLY | os.O_CREAT | os.O_APPEND
QUICK = 1.0  # s: a run that takes no longer writes no pieces,
MOST_WAITING = 1 << 26  # unless their arrays take more bytes
SYNC = 1.0  # s between two waits for the disk: what a power cut costs
KEY, END = "key", "end"  # places of the first line, and of the one that completes a shard


class Checkpoint:
    """Values by (place, number); `path` is appended to, `parts` (those of shards) are only read.

    In memory is only where each piece is. Threads may share a checkpoint.
    """

    def __init__(self, path: Path, key: str, parts: tuple[Path, ...] = ()):
        """Open or create; raises SceneError for a file with pieces of another key, OSError."""
        self.path = path
        self.size = 0  # bytes of all lines
        self._found: dict[tuple[str, int], tuple[Path, int]] = {}
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
                self._file.write(_line(KEY, 0, key))
        except BaseException:
            self._file.close()
            raise
        self._begun = self._synced = monotonic()
        self.resumed = self.pieces  # pieces there were at the beginning

    def _read(self, file: BinaryIO, key: str, path: Path) -> int:
        """Take note of the whole lines of a file; where they end."""
        end, first = 0, None
        for place, number, value, begin, after in records(file):
            if begin:
                self._found[place, number] = path, begin
            else:
                first = place, number, value
            end = after
        self.size += end
        if first is None and path == self.path:
            file.seek(0)
            head = file.read(SUM)  # of nothing, of a first line that was cut, or of zeros
            if _line(KEY, 0, key).startswith(head) or head == bytes(SUM):
                return 0
        if first != (KEY, 0, key):
            raise refused(path, "found no pieces of this run", "expected them")
        return end

    @property
    def pieces(self) -> int:
        """The number of pieces that there are."""
        return sum(place != END for place, _ in {**self._found, **self._waiting})

    def __contains__(self, name: tuple[str, int]) -> bool:
        return name in self._found or name in self._waiting

    def get(self, place: str, number: int) -> Any:
        """The value of a piece that is there; raises SceneError where it is damaged, OSError."""
        if (place, number) in self._waiting:
            with self._lock:
                self._write()
        path, begin = self._found[place, number]
        with open_pieces(path) as file:
            file.seek(begin)
            for *name, value, _, _ in records(file):
                if name == [place, number]:
                    return value
                break
        found = f"piece {place}/{number} was changed or damaged while the run was at work"
        raise refused(path, found, "expected it whole")

    def path_of(self, place: str, number: int) -> Path:
        """The file that holds a piece that is there."""
        return self._found[place, number][0] if (place, number) in self._found else self.path

    def put(self, place: str, number: int, value: Any) -> None:
        """Keep a piece; raises SceneError where there is no room, the file is then as before."""
        with self._lock:
            self._waiting[place, number] = value
            early = monotonic() - self._begun <= QUICK and not self._file.closed
            self._waiting_bytes += _bytes_of(value) if early else 0
            if not early or self._waiting_bytes > MOST_WAITING:
                self._write()

    def _write(self) -> None:
        """Append what waits."""
        for name in list(self._waiting):
            rest = memoryview(line := _line(*name, self._waiting[name]))
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
            self._found[name] = self.path, begin
            self.size += len(line)
            del self._waiting[name]
        self._waiting_bytes = 0

    def close(self) -> None:
        """Write what waits, and close the file; it is removed where it holds nothing.

        A thread that is still at work puts nothing more.
        """
        with held(), self._lock:
            try:
                if not self._file.closed:
                    self._write()
            finally:
                self._file.close()
                if not self._found:
                    self.path.unlink(missing_ok=True)

    def discard(self) -> None:
        """Close and delete: the work is finished."""
        self._found.clear()
        self._waiting.clear()
        self.close()


def open_pieces(path: Path, mode: str = "rb") -> Any:
    """Open a file of pieces, and nothing else: no link is followed, no pipe waited for."""

    handle = os.open(path, CAUTIOUS | (os.O_RDONLY if mode == "rb" else APPENDING), 0o666)
    if not S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise OSError(errno.EINVAL, "no plain file")
    return open(handle, mode, buffering=-1 if mode == "rb" else 0)


def key_of(path: Path) -> tuple[str, dict]:
    """(key, value of the line END or {}) of a file of pieces; raises SceneError, OSError."""
    key, end = None, {}
    with open_pieces(path) as file:
        for place, _, value, begin, _ in records(file):
            if begin == 0:
                key = value if place == KEY else None
            elif place == END and isinstance(value, dict):
                end = value
    if not isinstance(key, str):
        raise refused(path, "found no pieces", "expected a file of --shard I/N")
    return key, end


def most_line() -> int:
    """The bytes of a line that are read at most: a file may be longer than any memory."""
    return int(SHARE_OF_MEMORY * memory())


def records(file: BinaryIO) -> Iterator[tuple[str, int, Any, int, int]]:
    """(place, number, value, begin, end) of each line from here, up to the first damaged one."""
    end = file.tell()
    while HEAD.fullmatch(head := file.read(SUM + 1)):
        line = file.readline(MOST_KEY if end == 0 else most_line())
        begin, end = end, end + len(head) + len(line)
        data = line[:-1]
        if line[-1:] != b"\n" or head[:SUM] != _check(data):
            return
        try:
            named = unpack(data)
        except ValueError:
            return
        match named:
            case [str(place), int(number), value]:
                yield place, number, value, begin, end
            case _:
                return


def _line(place: str, number: int, value: Any) -> bytes:
    data = pack([place, number, value])
    return _check(data) + b" " + data + b"\n"


def _bytes_of(value: Any) -> int:
    """What the arrays in a value take."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return sum(map(_bytes_of, value))
    return getattr(value, "nbytes", 0)


def _check(data: bytes) -> bytes:
    return b"%08x" % crc32(data)


def refused(path: Path, found: str, expected: str) -> SceneError:
    """The refusal of a file of pieces that is damaged, or not ours."""
    return SceneError(
        Fault(str(path), "", found, expected, "delete the file, or choose another folder")
    )


def pack(value: Any) -> bytes:
    """JSON of a plain value; an array in it is {"dtype", "shape", "base64"}.

    Floats keep every bit (of a NaN outside an array, that it is one); tuples and ranges come back
    as lists, arrays as views that may not be written. Raises TypeError for what is none of this:
    nothing is pickled, nothing read can run code.
    """
    return json.dumps(value, default=_outline, separators=(",", ":")).encode()


def _outline(value: Any) -> Any:
    if isinstance(value, range):
        return list(value)
    if hasattr(value, "dtype") and value.ndim == 0:
        return value.item()
    if hasattr(value, "dtype"):
        little = value.astype(value.dtype.newbyteorder("<"), copy=False)
        if little.dtype.str in DTYPES:
            text = b2a_base64(little.tobytes(), newline=False).decode()
            return {"dtype": little.dtype.str, "shape": little.shape, "base64": text}
    raise TypeError(f"a {type(value).__name__} cannot be kept")


def unpack(data: bytes) -> Any:
    """The value of these bytes; raises ValueError where they are not from `pack`."""
    try:
        return json.loads(data, object_hook=_array)
    except (TypeError, OverflowError, RecursionError) as error:
        raise ValueError(f"no value ({error})") from None


def _array(outline: dict) -> Any:
    match outline:
        case {"dtype": str(name), "shape": list(shape), "base64": str(text)} if name in DTYPES:
            import numpy as np

            return np.frombuffer(a2b_base64(text, strict_mode=True), name).reshape(shape)
    return outline
