"""Tables: named columns that become a CSV, an .npz or NumPy arrays; one writer for every CSV.

A number in a CSV is the shortest text that reads back to the same double. No text in a table holds
a comma, a quote or a backslash.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any, BinaryIO

from pydantic_core import to_json

if TYPE_CHECKING:
    import numpy as np

Block = Sequence[Any]  # one entry a column: a list, a range or an array; or one value for all rows
ROWS = 1 << 12  # rows that become a block at a time
KINDS = {float, int, str, type(None)}
SAME_FORM, EXPONENT = 1e-4, 1e16  # magnitudes between which JSON and Python write a number alike


@dataclass(frozen=True, repr=False)
class Table:
    """Named columns of equal length, made anew from the result each time they are read.

    ``table["rpm"]`` is a column as a NumPy array: numbers as float64 or int64, with NaN where a
    number is not known, texts as strings; columns of an empty table are float64.
    ``table.columns`` are the names, as in the CSV file.
    """

    columns: tuple[str, ...]
    blocks: Callable[[], Iterator[Block]]

    def __repr__(self) -> str:
        return f"Table({', '.join(self.columns)})"

    @classmethod
    def of_rows(cls, columns: Sequence[str], rows: Callable[[], Iterable[Sequence]]) -> Table:
        """A table given row by row; None is an empty entry."""

        def blocks() -> Iterator[Block]:
            found = iter(rows())
            while some := list(islice(found, ROWS)):
                yield list(zip(*some, strict=True))

        return cls(tuple(columns), blocks)

    def __getitem__(self, column: str) -> np.ndarray:
        """The column as an array; raises KeyError."""
        import numpy as np

        if column not in self.columns:
            raise KeyError(f"{column}; there are {', '.join(self.columns)}")
        k = self.columns.index(column)
        parts = [np.asarray(_missing(_spread(block, k))) for block in self.blocks()]
        found = np.concatenate(parts) if parts else np.empty(0)
        return found.astype(np.int64) if found.dtype.kind in "iu" else found

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def keys(self) -> tuple[str, ...]:
        """The names, so that ``dict(table)`` has every column."""
        return self.columns

    def __len__(self) -> int:
        return sum(_length(block) for block in self.blocks())

    def csv(self) -> Iterator[str]:
        """The text of the CSV file, a block at a time."""
        yield ",".join(self.columns) + "\n"
        for block in self.blocks():
            alike = next((k for k, entry in enumerate(block) if _is_column(entry)), 0)
            begin = to_json(_cells(block[:alike]))[1:-1] + b"," * (alike > 0)  # of each row
            width = len(block) - alike + 1
            cells = ["\n"] * (width * _length(block))
            for k, entry in enumerate(block[alike:]):
                own = _cells(entry) if _is_column(entry) else _cells([entry]) * _length(block)
                cells[k::width] = own
            if cells:  # JSON has the same shortest digits as Python, several times as fast
                text = (to_json(cells)[1:-1] + b",").replace(b',"\\n",', b"\n" + begin)
                text = begin + text[: len(text) - len(begin)]
                yield text.replace(b'"', b"").decode()

    def npz(self, file: BinaryIO) -> None:
        """Write the columns as numpy.load reads them; no time stands in the archive."""
        from zipfile import ZIP_STORED, ZipFile, ZipInfo

        import numpy as np

        count = len(self)
        with ZipFile(file, "w", ZIP_STORED) as archive:
            for k, name in enumerate(self.columns):
                first = next((_spread(block, k) for block in self.blocks()), ())
                kind = np.dtype("<i8" if np.asarray(first).dtype.kind == "i" else "<f8")
                if np.asarray(first).dtype.kind == "U":
                    texts = (text for block in self.blocks() for text in set(_spread(block, k)))
                    kind = np.dtype(f"<U{max(map(len, texts))}")
                header = {"descr": kind.str, "fortran_order": False, "shape": (count,)}
                with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                    np.lib.format.write_array_header_1_0(member, header)
                    for block in self.blocks():
                        member.write(np.asarray(_spread(block, k), dtype=kind).tobytes())


def _is_column(entry: Any) -> bool:
    return hasattr(entry, "__len__") and not isinstance(entry, str)


def _length(block: Block) -> int:
    return next((len(entry) for entry in block if _is_column(entry)), 1)


def _spread(block: Block, k: int) -> Any:
    """Column k of a block, a single value repeated."""
    return block[k] if _is_column(block[k]) else [block[k]] * _length(block)


def _missing(column: Any) -> Any:
    """None as NaN among numbers, and as an empty text among texts."""
    if hasattr(column, "dtype") or None not in column:
        return column
    empty = "" if any(isinstance(value, str) for value in column) else float("nan")
    return [empty if value is None else value for value in column]


def _cells(column: Any) -> list:
    """The entries of a column as JSON shall write them, as texts where its form is another.

    Raises TypeError for a value of another kind than Python's own numbers and texts.
    """
    values = column.tolist() if hasattr(column, "tolist") else list(column)
    if hasattr(column, "dtype") and column.dtype.kind == "f":
        size = abs(column)
        odd = (~((size >= SAME_FORM) & (size < EXPONENT))).nonzero()[0].tolist()
    else:
        kinds = set(map(type, values))
        if strange := [k.__name__ for k in kinds - KINDS if not issubclass(k, str)]:
            raise TypeError(f"a table cannot hold {', '.join(sorted(strange))}")
        odd = [
            k
            for k, x in enumerate(values if kinds != {int} else ())
            if x is None or (isinstance(x, float) and not SAME_FORM <= abs(x) < EXPONENT)
        ]
    for k in odd:
        values[k] = "" if values[k] is None else repr(values[k])
    return values
