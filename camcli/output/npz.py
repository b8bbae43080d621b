"""An .npz file that numpy.load reads, whose columns are filled side by side.

It is a ZIP archive without compression, with a .npy file for each column; no time stands in it.
The rows come a block at a time, but in the archive a column is in one piece. How many rows there
will be, and what the columns are, is known before: so each column has its place from the beginning,
and is written there and nowhere else.

Source: PKWARE, APPNOTE.TXT, 4.3 (the records below) and 4.5.3 (64 bits). The bytes are those that
Python's zipfile writes.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from struct import Struct
from typing import TYPE_CHECKING, BinaryIO, NamedTuple
from zlib import crc32

if TYPE_CHECKING:
    import numpy as np

LOCAL = Struct("<4s5H3L2H")  # before a file in the archive
SIZES = Struct("<2H2Q")  # behind its name: the number of this field, its length, and two sizes
CENTRAL = Struct("<4s6H3L5H2L")  # of a file, in the directory at the end
END_64 = Struct("<4sQ2H2L4Q")  # of the directory, where the archive is large
LOCATOR = Struct("<4sLQL")  # of END_64
END = Struct("<4s4H2LH")  # of the archive
VERSION = 45  # of ZIP, the first with sizes of 64 bits
UNIX = 3 << 8  # beside the version that made it: where the access rights are those of Unix
RIGHTS = 0o600 << 16
DATE = (1 << 5) | 1  # 1980-01-01, the first there is
ELSEWHERE = 0xFFFFFFFF  # in the place of a number of 32 bits that stands in a field of 64
LARGE = (1 << 31) - 1  # bytes; more stand in a field of 64 bits


class Form(NamedTuple):
    """What is known of a table before it is read: how many rows it has, and of each column a dtype.

    kinds: names of dtypes as <f8, <i8 or, of 5 characters, <U5.
    """

    rows: int
    kinds: Sequence[str]


class Npz:
    """An archive that is being written into a file, which can seek, from where it stands at 0."""

    def __init__(self, file: BinaryIO, columns: Sequence[str], form: Form):
        self._file = file
        self._columns: list[_Column] = []
        self._end = 0  # of the columns, bytes
        for name, kind in zip(columns, form.kinds, strict=True):
            column = _Column(name, kind, form.rows, self._end)
            self._columns.append(column)
            self._end = column.end

    def add(self, values: Sequence[np.ndarray]) -> None:
        """Add rows: the next entries of each column."""
        for column, entries in zip(self._columns, values, strict=True):
            column.add(self._file, entries)

    def close(self) -> None:
        """Write what stands around the columns; raises ValueError where rows are missing."""
        for column in self._columns:
            column.write_head(self._file)
        directory = b"".join(column.entry() for column in self._columns)
        count = len(self._columns)
        begin, size = self._end, len(directory)
        self._file.seek(begin)
        self._file.write(directory)
        if begin > LARGE:
            rest = END_64.size - 12  # bytes behind the signature and this number
            self._file.write(
                END_64.pack(b"PK\6\6", rest, VERSION, VERSION, 0, 0, count, count, size, begin)
            )
            self._file.write(LOCATOR.pack(b"PK\6\7", 0, begin + size, 1))
            begin = min(begin, ELSEWHERE)
        self._file.write(END.pack(b"PK\5\6", 0, 0, count, count, size, begin, 0))


class _Column:
    """A column in an archive: where it begins and ends (bytes), and where the next entries go."""

    def __init__(self, name: str, kind: str, rows: int, begin: int):
        import numpy as np

        self._name = f"{name}.npy".encode("ascii")
        self._kind = np.dtype(kind)
        head = BytesIO()
        shape = {"descr": kind, "fortran_order": False, "shape": (rows,)}
        np.lib.format.write_array_header_1_0(head, shape)
        self._head = head.getvalue()
        self._begin = begin
        self._size = len(self._head) + rows * self._kind.itemsize  # of the .npy file
        self._check = crc32(self._head)
        self._next = begin + LOCAL.size + len(self._name) + SIZES.size + len(self._head)
        self.end = self._next + rows * self._kind.itemsize

    def add(self, file: BinaryIO, entries: np.ndarray) -> None:
        """Add entries; raises ValueError for more than there are rows."""
        import numpy as np

        data = np.ascontiguousarray(entries, self._kind).view(np.uint8).data
        if self._next + data.nbytes > self.end:
            raise ValueError("found more rows than were counted")
        file.seek(self._next)
        file.write(data)
        self._check = crc32(data, self._check)
        self._next += data.nbytes

    def write_head(self, file: BinaryIO) -> None:
        """Write what stands before the entries; raises ValueError where some are missing."""
        if self._next != self.end:
            raise ValueError("found fewer rows than were counted")
        local = LOCAL.pack(
            b"PK\3\4", VERSION, 0, 0, 0, DATE, self._check, ELSEWHERE, ELSEWHERE,
            len(self._name), SIZES.size,
        )  # fmt: skip
        file.seek(self._begin)
        file.write(local + self._name + SIZES.pack(1, 16, self._size, self._size) + self._head)

    def entry(self) -> bytes:
        """What stands in the directory at the end."""
        large = []
        size, begin = self._size, self._begin
        if size > LARGE:
            large += [size, size]
            size = ELSEWHERE
        if begin > LARGE:
            large.append(begin)
            begin = ELSEWHERE
        field = Struct(f"<2H{len(large)}Q").pack(1, 8 * len(large), *large) if large else b""
        central = CENTRAL.pack(
            b"PK\1\2", UNIX | VERSION, VERSION, 0, 0, 0, DATE, self._check, size, size,
            len(self._name), len(field), 0, 0, 0, RIGHTS, begin,
        )  # fmt: skip
        return central + self._name + field
