"""Rows of a measured lift table from the bytes of its file: nothing is guessed, every fault named.

Text is UTF-8 with or without a byte order mark, with any line ends; `#` begins a comment. The
first line with content says how cells are separated: `;` if it has one, else `,`, else white space.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal

from camcli.cams.files import decoded, refused
from camcli.errors import Fault, SceneError

MAX_ROWS = 50_000
MAX_LINES = 2 * MAX_ROWS  # with comments
LONGEST_LINE = 10_000  # characters
MAX_FAULTS = 20
LARGEST = Decimal(10) ** 9
SMALLEST = -40  # decimals of a number, at most

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?", re.ASCII)


@dataclass(frozen=True)
class Cell:
    """A number with the place it stands at; lines and columns count from 1."""

    line: int
    column: int
    value: Decimal
    scientific: bool = False  # written with a power of ten: its digits count, not its decimals


@dataclass(frozen=True)
class Rows:
    """The two columns of a table, as they were written."""

    name: str
    angle: list[Cell]
    lift: list[Cell]

    def fault(self, row: int, found: str, expected: str, cure: str, key: str = "lift") -> Fault:
        """A fault at a cell of a row."""
        cell = (self.angle if key == "angle" else self.lift)[row]
        return Fault(f"{self.name}:{cell.line}:{cell.column}", key, found, expected, cure)


def parse(data: bytes, name: str, angle: int | str, lift: int | str, header: bool) -> Rows:
    """The rows of the two columns, by number from 1 or by name; raises SceneError."""
    lines = _lines(data, name)
    split = _splitter(lines[0][1], name, lines[0][0])
    titles = [text.strip('"') for _, text in split(lines[0][1])] if header else []
    if titles and all(map(_NUMBER.fullmatch, titles)):
        found, cure = "found a header of numbers", "if it is the first row, write header: false"
        raise refused(f"{name}:{lines[0][0]}", "header", found, "", cure)
    body = lines[1:] if header else lines
    if len(body) > MAX_ROWS:
        found, expected = f"found {len(body)} rows", f"expected at most {MAX_ROWS}"
        raise refused(name, "file", found, expected, "thin the table out")
    width = len(titles) or (len(split(body[0][1])) if body else 0)
    wanted = [
        _column(key, chosen, titles, width, name)
        for key, chosen in (("angle_column", angle), ("lift_column", lift))
    ]
    if wanted[0] == wanted[1]:
        found = f"angle_column and lift_column are both column {wanted[0] + 1}"
        raise SceneError(Fault(name, "lift_column", found, "expected two columns", "name both"))
    return _rows(body, split, width, wanted, name, header)


def _lines(data: bytes, name: str) -> list[tuple[int, str]]:
    """(number, text) of the lines with content, comments cut off."""
    text = decoded(data, name, "file")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") > MAX_LINES:
        found, expected = f"found {text.count(chr(10))} lines", f"expected at most {MAX_LINES}"
        raise refused(name, "file", found, expected, "thin the table out")
    whole = text.split("\n")
    _short(whole, name)
    lines = [(n, line.partition("#")[0]) for n, line in enumerate(whole, 1)]
    lines = [(n, line) for n, line in lines if line.strip()]
    if not lines:
        found = "found nothing" if not whole[0] and len(whole) == 1 else "found no rows"
        cure = "is this the right file?"
        raise refused(name, "file", found, "expected rows of angle and lift", cure)
    return lines


def _short(lines: list[str], name: str) -> None:
    """Refuse lines that are no rows: a huge one would be cut into a huge number of cells."""
    faults = [
        Fault(f"{name}:{n}:1", "file", f"found a line of {len(line)} characters",
              f"expected at most {LONGEST_LINE}", "is this the right file?")
        for n, line in enumerate(lines, 1)
        if len(line) > LONGEST_LINE
    ]  # fmt: skip
    if faults:
        raise SceneError(*faults[:MAX_FAULTS])


def _splitter(first: str, name: str, line: int):
    """A function from a line to its cells as (column, text)."""
    words = first.split()
    if ";" in first:
        mark = ";"
    elif len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(w) or w.isdigit() for w in words):
        raise SceneError(_comma(name, line, 1, words[0]))
    elif "," in first:
        mark = ","
    else:
        return lambda text: [(m.start() + 1, m[0]) for m in re.finditer(r"\S+", text)]

    def split(text: str) -> list[tuple[int, str]]:
        cells, start = [], 0
        for raw in text.split(mark):
            lead = len(raw) - len(raw.lstrip())
            cells.append((start + lead + 1, raw.strip()))
            start += len(raw) + 1
        return cells

    return split


def _comma(name: str, line: int, column: int, text: str) -> Fault:
    found = f"found a decimal comma: '{text[:40]}'"
    cure = "write 1.25 for 1,25, and separate the columns by a semicolon or white space"
    return Fault(f"{name}:{line}:{column}", "file", found, "expected decimal points", cure)


def _column(key: str, chosen: int | str, titles: list[str], width: int, name: str) -> int:
    """Index of a column that the scene names or numbers."""
    if isinstance(chosen, int):
        if 1 <= chosen <= width:
            return chosen - 1
        found, expected = f"found column {chosen}", f"expected 1 to {width}, as the file has them"
        raise refused(name, key, found, expected, "columns count from 1")
    count = titles.count(chosen.strip())
    if count == 1:
        return titles.index(chosen.strip())
    if not titles:
        found = f"found the name '{chosen[:40]}' for a column of a file without header"
        cure = "number the column, from 1, or say header: true"
        raise refused(name, key, found, "", cure)
    found = f"found {'no' if count == 0 else 'more than one'} column '{chosen[:40]}'"
    names = ", ".join(f"'{title[:30]}'" for title in titles[:12])
    raise refused(name, key, found, f"expected one of {names}", "copy the name")


def _rows(body, split, width: int, wanted: list[int], name: str, header: bool) -> Rows:
    faults: list[Fault] = []
    columns: tuple[list[Cell], list[Cell]] = ([], [])
    for number, (line, text) in enumerate(body):
        cells = split(text)
        if len(cells) != width:
            found, expected = f"found {len(cells)} cells", f"expected {width} as in the first line"
            cure = "complete the row; is the comma a decimal comma?" if "," in text else "complete"
            faults.append(Fault(f"{name}:{line}", "file", found, expected, cure))
        else:
            for k, into in zip(wanted, columns, strict=True):
                column, word = cells[k]
                cell = _cell(name, line, column, word, not header and number == 0)
                (into if isinstance(cell, Cell) else faults).append(cell)
        if len(faults) >= MAX_FAULTS:
            break
    if faults:
        raise SceneError(*faults)
    return Rows(name, *columns)


def _cell(name: str, line: int, column: int, text: str, first: bool) -> Cell | Fault:
    """The number in a cell, or why there is none."""
    text = text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text
    where = f"{name}:{line}:{column}"
    if len(text) <= 60 and _NUMBER.fullmatch(text):
        value = Decimal(text)
        if abs(value) > LARGEST or (value.is_zero() and value.as_tuple().exponent > 0):
            return Fault(where, "file", f"found {text}", "expected at most 1e9", "is it a number?")
        if value.as_tuple().exponent < SMALLEST:
            found, expected = f"found {text}", f"expected at most {-SMALLEST} decimals"
            return Fault(where, "file", found, expected, "round it")
        return Cell(line, column, value, "e" in text.lower())
    if _DECIMAL_COMMA.fullmatch(text):
        return _comma(name, line, column, text)
    found = f"found '{text[:40]}'" if text else "found an empty cell"
    if text.lower().lstrip("+-") in ("nan", "inf", "infinity"):
        cure = "remove the row or measure it again"
    elif first:
        cure = "if this is a header, write header: true"
    else:
        cure = "correct the cell, remove the row, or begin the line with # if it is a comment"
    return Fault(where, "file", found, "expected a number", cure)
