"""Tables: named columns that become a CSV, an .npz or NumPy arrays; one writer for every CSV.

A number in a CSV is the shortest text that reads back to the same double. No text in a table holds
a comma, a quote or a backslash.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any, BinaryIO, NoReturn

from pydantic_core import to_json

from camcli.output.npz import Form, Npz

if TYPE_CHECKING:
    import numpy as np

    Columns = Mapping[str, np.ndarray]
else:

    class Columns(Mapping, dict):
        """A Mapping that is a dict besides; the dict itself stays empty."""


Block = Sequence[Any]  # one entry a column: a list, a range or an array; or one value for all rows
ROWS = 1 << 10  # rows that become a block at a time
ROWS_TOGETHER = 1 << 14  # rows of small blocks that go into an archive at a time
KINDS = {float, int, str, type(None)}  # of values in a table; of str also what derives from it
TEXTS = frozenset(  # columns that are text in every table that has them
    [
        "case", "classification", "contact", "corner", "direction", "event", "expected",
        "holds_for", "kind", "label", "method", "observed", "proved", "quantity", "region",
        "status",
    ]
)  # fmt: skip
MAY_BE_EMPTY = frozenset({"stable", "watched_turns"})  # whole numbers, NaN where not known
SAME_FORM, EXPONENT = 1e-4, 1e16  # magnitudes between which JSON and Python write a number alike
LINE_END = "\n"  # stands for the end of a line among the cells of a block


class Table(Columns):
    """Named columns of equal length, made anew from the result each time they are read.

    ``table["rpm"]`` is a column as a NumPy array: numbers as float64 or int64, with NaN where a
    number is not known, texts as strings. What a column is does not depend on what is in it: a
    label is a string and a flag that may be empty, as ``stable``, is float64 in an empty table too;
    other columns of an empty table are float64.
    ``table.columns`` are the names, as in the CSV file, and ``table.rows`` is how many rows it has.
    ``table.shared`` says with which other tables its rows can be read, see `SharedRows`.

    It is a Mapping of these columns, so that ``dict(table)`` has them all, and a dict because
    pandas.DataFrame reads no other mapping: what would write to the dict, copy it or compare it is
    replaced. A table cannot be changed.
    """

    def __init__(
        self,
        columns: Sequence[str],
        blocks: Callable[[], Iterator[Block]],
        shared: tuple[SharedRows, str] | None = None,
    ):
        self.columns = tuple(columns)
        self.blocks = blocks
        self.shared = shared

    def __repr__(self) -> str:
        return f"Table({', '.join(self.columns)})"

    def _repr_html_(self) -> str:
        """The first rows, in a notebook."""
        from camcli.output.notebook import table_html

        return table_html(self)

    def __reduce__(self) -> tuple:
        """Pickled, a table is its values: what makes them may be a function of another process."""
        return Table, (self.columns, partial(iter, list(self.blocks())))

    __eq__, __ne__, __hash__ = object.__eq__, object.__ne__, object.__hash__

    @classmethod
    def of_rows(cls, columns: Sequence[str], rows: Callable[[], Iterable[Sequence]]) -> Table:
        """A table given row by row; None is an empty entry."""

        def blocks() -> Iterator[Block]:
            """The rows, ROWS of them at a time, as columns."""
            left = iter(rows())
            while some_rows := list(islice(left, ROWS)):
                yield list(zip(*some_rows, strict=True))

        return cls(tuple(columns), blocks)

    def __getitem__(self, column: str) -> np.ndarray:
        """The column as an array; raises KeyError."""
        if column not in self.columns:
            raise unknown("column", column, self.columns)
        k = self.columns.index(column)
        parts = [_array(_spread(block, k)) for block in self.blocks()]
        return _typed(column, _joined(parts))

    def arrays(self, *names: str) -> dict[str, np.ndarray]:
        """These columns as arrays, or all; the rows are made once, not once for each column."""
        parts = self._parts(names or self.columns)
        return {column: _typed(column, _joined(arrays)) for column, arrays in parts.items()}

    def _parts(self, names: Sequence[str]) -> dict[str, list[np.ndarray]]:
        """Of each of these columns, an array for each block."""
        parts: dict[str, list[np.ndarray]] = {column: [] for column in names}
        for block in self.blocks():
            for column, arrays in parts.items():
                arrays.append(_array(_spread(block, self.columns.index(column))))
        return parts

    def __contains__(self, column: object) -> bool:
        return column in self.columns

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __reversed__(self) -> Iterator[str]:
        return reversed(self.columns)

    def __len__(self) -> int:
        """The number of columns."""
        return len(self.columns)

    @property
    def rows(self) -> int:
        """The number of rows."""
        return sum(_length(block) for block in self.blocks())

    def copy(self) -> dict[str, np.ndarray]:
        """All columns, in a dict that may be changed."""
        return self.arrays()

    def __or__(self, other: Mapping) -> dict:
        return {**self, **other}

    def __ror__(self, other: Mapping) -> dict:
        return {**other, **self}

    def _fixed(self, *_: object, **__: object) -> NoReturn:
        raise TypeError("a table cannot be changed; dict(table) can")

    __setitem__ = __delitem__ = __ior__ = _fixed
    update = setdefault = pop = popitem = clear = _fixed

    def csv(self) -> Iterator[str]:
        """The text of the CSV file, a block at a time."""
        return (chunk.decode() for chunk in self._csv())

    def _csv(self) -> Iterator[bytes]:
        """Its bytes."""
        yield _header(self.columns)
        for block in self.blocks():
            yield _lines(block)

    def write_csv(self, file: BinaryIO) -> None:
        """Write the CSV file."""
        file.writelines(self._csv())

    def npz(self, file: BinaryIO) -> None:
        """Write the columns as numpy.load reads them; no time stands in the archive."""
        if self.shared is not None:
            rows, _ = self.shared
            rows.write_npz([self], [file])
            return
        columns = [_joined(parts) for parts in self._parts(self.columns).values()]
        kinds = [_kind(column) for column in columns]
        archive = Npz(file, self.columns, Form(len(columns[0]), kinds))
        archive.add(columns)
        archive.close()


@dataclass(frozen=True, eq=False)
class SharedRows:
    """The rows of several tables that are read together, as the sections of a sweep are.

    read: given the names of some of these tables, it yields a block for each of them, again and
    again; None stands for a table that has no row at that place. form: of the table of a name.
    """

    read: Callable[[Sequence[str]], Iterator[Sequence[Block | None]]]
    form: Callable[[str], Form]

    def table(self, name: str, columns: Sequence[str]) -> Table:
        """The table of this name; it can be read without the others."""
        return Table(columns, partial(self._blocks_of, name), (self, name))

    def _blocks_of(self, name: str) -> Iterator[Block]:
        """The blocks of one table."""
        for (block,) in self.read([name]):
            if block is not None:
                yield block

    def write_npz(self, tables: Sequence[Table], files: Sequence[BinaryIO]) -> None:
        """Write each of these tables, which share these rows, as `Table.npz` does."""
        names = _names(tables)
        forms = [self.form(name) for name in names]
        archives = [
            _Collector(Npz(file, table.columns, form), form)
            for table, file, form in zip(tables, files, forms, strict=True)
        ]
        for blocks in self.read(names):
            for archive, block in zip(archives, blocks, strict=True):
                if block is not None:
                    archive.add(block)
        for archive in archives:
            archive.close()

    def write_csv(self, tables: Sequence[Table], files: Sequence[BinaryIO]) -> None:
        """Write each of these tables, which share these rows, as `Table.write_csv` does."""
        for table, file in zip(tables, files, strict=True):
            file.write(_header(table.columns))
        for blocks in self.read(_names(tables)):
            for file, block in zip(files, blocks, strict=True):
                if block is not None:
                    file.write(_lines(block))


def _names(tables: Iterable[Table]) -> list[str]:
    """The names of the tables that share their rows."""
    return [table.shared[1] for table in tables if table.shared is not None]


def _header(columns: Sequence[str]) -> bytes:
    """The first line of a CSV file."""
    return (",".join(columns) + "\n").encode()


def _lines(block: Block) -> bytes:
    """The lines of a CSV file for the rows of a block.

    All cells of the block go through one call of `to_json`, row after row: JSON has the same
    shortest digits as Python, several times as fast. The values that all rows begin with are
    written once, and put before each row; where but one column changes from row to row, as in a
    motion that repeats each turn, those behind it are written once, too.
    """
    row_count = _length(block)
    if row_count == 0:
        return b""
    block = [_once(entry) for entry in block]
    changing = [k for k, entry in enumerate(block) if _is_column(entry)]
    if not changing:
        return (_text(block) + b"\n") * row_count
    first, last = changing[0], changing[-1]
    line_start = b"".join(_text([value]) + b"," for value in block[:first])
    if first == last:
        line_end = b"".join(b"," + _text([value]) for value in block[last + 1 :]) + b"\n"
        changing_text = _text(block[first])
        return line_start + changing_text.replace(b",", line_end + line_start) + line_end

    columns = block[first:]
    width = len(columns) + 1  # cells of a row: one a column, and the mark of the line's end
    cells = [LINE_END] * (width * row_count)
    for k, entry in enumerate(columns):
        cells[k::width] = _cells(entry) if _is_column(entry) else _cells([entry]) * row_count
    text = to_json(cells)[1:-1] + b","
    text = line_start + text.replace(b"," + to_json(LINE_END) + b",", b"\n" + line_start)
    text = text[: len(text) - len(line_start)]  # no line begins behind the last one
    return text.replace(b'"', b"")


def _once(entry: Any) -> Any:
    """What an array holds in each of its rows, to the last bit; else the entry itself."""
    if not hasattr(entry, "tobytes") or len(entry) < 2 or entry[0] != entry[-1]:
        return entry
    first = entry[:1]
    return first.tolist()[0] if entry.tobytes() == first.tobytes() * len(entry) else entry


def _text(column: Any) -> bytes:
    """The cells of a column with commas between them."""
    return to_json(_cells(column))[1:-1].replace(b'"', b"")  # [1:-1]: no brackets


class _Collector:
    """Puts small blocks together on their way into an archive: a column takes many rows at once."""

    def __init__(self, archive: Npz, form: Form):
        self._archive = archive
        self._kinds = form.kinds
        self._rows = 0  # that are not in the archive yet
        self._make_room(min(form.rows, ROWS_TOGETHER))

    def _make_room(self, rows: int) -> None:
        """Make columns with room for so many rows."""
        import numpy as np

        self._room = rows
        self._columns = [np.empty(rows, kind) for kind in self._kinds]

    def add(self, block: Block) -> None:
        """Add the rows of a block."""
        count = _length(block)
        if self._rows + count > self._room:
            self._into_archive()
        if count > self._room:
            self._make_room(count)
        rows = slice(self._rows, self._rows + count)
        for column, entry in zip(self._columns, block, strict=True):
            as_it_is = hasattr(entry, "dtype") or not _is_column(entry)
            column[rows] = entry if as_it_is else _array(entry)
        self._rows += count

    def _into_archive(self) -> None:
        """Give the archive the rows that were collected."""
        self._archive.add([column[: self._rows] for column in self._columns])
        self._rows = 0

    def close(self) -> None:
        """Write what was collected, and the end of the archive."""
        self._into_archive()
        self._archive.close()


class Named(dict[str, Any]):
    """A dict whose error for a wrong name says which names there are.

    kind: the word for one of them, e.g. `table`.
    """

    def __init__(self, kind: str, content: Mapping[str, Any]):
        super().__init__(content)
        self.kind = kind

    def __missing__(self, name: str) -> NoReturn:
        raise unknown(self.kind, name, self)


def unknown(kind: str, name: object, known: Iterable[str]) -> KeyError:
    """The error for a name that is not one of those known."""
    return KeyError(f"found no {kind} {name!r}; there are {', '.join(known) or 'none'}")


def _typed(column: str, values: np.ndarray) -> np.ndarray:
    """Values with the type that their column always has."""
    import numpy as np

    if column in TEXTS and values.dtype.kind == "f":  # no row has a text
        return np.full(len(values), "")
    if column in MAY_BE_EMPTY:
        return values.astype(float)
    return values


def _joined(arrays: Sequence[np.ndarray]) -> np.ndarray:
    """The arrays of a column's blocks as one; whole numbers as int64.

    An array of NaN alone becomes one of empty texts where another has texts. Raises TypeError where
    numbers and texts are mixed.
    """
    import numpy as np

    if not arrays:
        return np.empty(0)
    # the dtype of an array without entries says nothing, unless there is no other array
    filled = [array for array in arrays if len(array)] or arrays[:1]
    if any(array.dtype.kind == "U" for array in filled):
        filled = [_as_texts(array) for array in filled]
    column = np.concatenate(filled)
    return column.astype(np.int64) if column.dtype.kind in "iu" else column


def _as_texts(array: np.ndarray) -> np.ndarray:
    """An array of a column of texts; one of NaN alone becomes one of empty texts."""
    import numpy as np

    if array.dtype.kind == "U":
        return array
    if not np.isnan(array).all():
        raise TypeError("a column of a table holds numbers or texts, not both")
    return np.full(len(array), "")


def _is_column(entry: Any) -> bool:
    """Whether an entry of a block has a value for each row, and not one for all rows."""
    return hasattr(entry, "__len__") and not isinstance(entry, str)


def _length(block: Block) -> int:
    """The number of rows of a block; 1 where no entry of it is a column."""
    return next((len(entry) for entry in block if _is_column(entry)), 1)


def _kind(column: np.ndarray) -> str:
    """The dtype of a column in an archive, which has no other numbers than float64 and int64."""
    if column.dtype.kind == "U":
        return column.dtype.str
    return "<i8" if column.dtype.kind == "i" and len(column) else "<f8"


def _spread(block: Block, k: int) -> Any:
    """Column k of a block, a single value repeated."""
    return block[k] if _is_column(block[k]) else [block[k]] * _length(block)


def _array(column: Any) -> np.ndarray:
    """A column as an array; None becomes NaN among numbers, and an empty text among texts."""
    import numpy as np

    if isinstance(column, range):
        return np.arange(column.start, column.stop, column.step)
    if hasattr(column, "dtype") or None not in column:
        return np.asarray(column)
    empty = "" if any(isinstance(value, str) for value in column) else float("nan")
    return np.array([empty if value is None else value for value in column])


def _cells(column: Any) -> list:
    """The entries of a column as JSON shall write them.

    A number that JSON writes in another form than Python is replaced by its text, and None by an
    empty one. Raises TypeError for a value of another kind than Python's own numbers and texts.
    """
    values = column.tolist() if hasattr(column, "tolist") else list(column)
    number_kind = column.dtype.kind if hasattr(column, "dtype") else ""
    if isinstance(column, range) or number_kind == "i":
        return values
    if number_kind == "f":
        size = abs(column)
        same_form = (size >= SAME_FORM) & (size < EXPONENT)  # False of NaN
        other_form = (~same_form).nonzero()[0].tolist()
    else:
        other_form = _without_json_form(values)
    for k in other_form:
        values[k] = "" if values[k] is None else repr(values[k])
    return values


def _without_json_form(values: list) -> list[int]:
    """The indices of None, and of floats that JSON writes in another form than Python.

    Raises TypeError for a value that no table can hold.
    """
    kinds = set(map(type, values))
    strange = [kind.__name__ for kind in kinds - KINDS if not issubclass(kind, str)]
    if strange:
        raise TypeError(f"a table cannot hold {', '.join(sorted(strange))}")
    if kinds == {int}:
        return []
    return [
        k
        for k, value in enumerate(values)
        if value is None or (isinstance(value, float) and not SAME_FORM <= abs(value) < EXPONENT)
    ]
