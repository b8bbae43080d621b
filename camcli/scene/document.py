"""YAML text and Python values as plain data, with the place of every value and key.

Unquoted words mean what a person means (YAML 1.2): `1e-3` is a number; `1:30`, `010` and `yes`
stay text, so that validation can say what is wrong with them, or take `yes` where a switch is
asked for. Size, nesting and aliases are limited while the text is read, so that no text costs more
than a bounded time and memory.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import yaml

from camcli.errors import Fault, shown

MAX_DEPTH = 32  # levels of maps and lists
MAX_VALUES = 20_000  # values and keys, each alias counted as all it stands for
LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # constructs nothing, resolves no words

Path = tuple[str, ...]  # keys from the root of the scene, places in a list as text


class Mark(NamedTuple):
    """A place: a file (rank 0, line and column from 1), `--set ...` or an option (line 0).

    Marks sort as faults are listed: those of the file first, then of the command line.
    """

    rank: int
    name: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.name}:{self.line}:{self.column}" if self.line else self.name

    def at(self, spot: yaml.Mark | None) -> Mark:
        """The place of a mark of PyYAML in the file; on the command line there are no lines."""
        if spot is None or not self.line:
            return self
        return self._replace(line=spot.line + 1, column=spot.column + 1)


class Place(NamedTuple):
    """Where a value and its key stand, and the value as it was written (unquoted scalars)."""

    value: Mark
    key: Mark
    text: str | None = None


class Finding(NamedTuple):
    """A fault with its mark, so that faults can be ordered before they are shown."""

    mark: Mark
    path: Path
    found: str
    expected: str = ""
    cure: str = ""

    def fault(self) -> Fault:
        """The fault as it is shown."""
        return Fault(str(self.mark), dotted(self.path), self.found, self.expected, self.cure)


class _StopReading(Exception):  # noqa: N818 - control flow inside this file
    def __init__(self, *finding: Any):
        self.finding = Finding(*finding)


def dotted(path: Sequence[str]) -> str:
    """`('run', 'start', 'q')` as `run.start.q`."""
    return shown(".".join(shown(key, 40) for key in path[:40]), 160)


class Document:
    """Plain data and the places of its values; `findings` are the faults met while reading.

    `data` is None, with a finding that says why, where reading had to stop.
    """

    def __init__(self, start: Mark):
        """An empty document; start: where its first line is."""
        self.data: Any = None
        self.places: dict[Path, Place] = {(): Place(start, start)}
        self.findings: list[Finding] = []
        self.size = 0

    def value(self, path: Path) -> Any:
        """Value at a path, None where there is none."""
        node = self.data
        for key in path:
            try:
                node = node[int(key)] if isinstance(node, list) else node[key]
            except (LookupError, TypeError, ValueError):
                return None
        return node

    def place(self, path: Path) -> Place:
        """Place of a path, or of the closest map or list around it that was written."""
        while path not in self.places:
            path = path[:-1]
        return self.places[path]

    def put(self, path: Path, other: Document) -> None:
        """Put another document at a path; missing maps on the way are made.

        A single value that stands in the way gives way: validation then says what belongs there.
        """
        mark = other.places[()].key
        size = len(path)
        for n in range(1, size):
            if not isinstance(self.value(path[:n]), dict | list):
                self.places[path[:n]] = Place(mark, mark)
        self.data = _replaced(self.data, path, other.data)
        self.places = {known: p for known, p in self.places.items() if known[:size] != path}
        self.places |= {(*path, *below): p for below, p in other.places.items()}

    def read(self, node: yaml.Node, path: Path = (), key: Mark | None = None) -> Any:
        """Plain data of a YAML node and all below it; aliases are copied out."""
        mark = self.places[()].value.at(node.start_mark)
        self._count(mark, path)
        plain = isinstance(node, yaml.ScalarNode) and not node.style
        self.places[path] = Place(mark, key or mark, node.value if plain else None)
        kind = {yaml.ScalarNode: "str", yaml.SequenceNode: "seq"}.get(type(node), "map")
        if node.tag != f"tag:yaml.org,2002:{kind}":
            tag = shown(node.tag.replace("tag:yaml.org,2002:", "!!", 1))
            expected = "expected a value without a tag"
            self.findings.append(Finding(mark, path, f"found the tag {tag}", expected, "remove it"))
        if isinstance(node, yaml.ScalarNode):
            _refuse_surrogates(mark, path, node.value)
            return scalar(node.value) if plain else node.value
        if isinstance(node, yaml.SequenceNode):
            return [self.read(child, (*path, str(k))) for k, child in enumerate(node.value)]
        data: dict[str, Any] = {}
        for key_node, child in node.value:
            mark = self.places[()].value.at(key_node.start_mark)
            if not isinstance(key_node, yaml.ScalarNode):
                cure = "write 'key: value' with a plain key"
                found = "found a map or list as a key"
                raise _StopReading(mark, path, found, "expected a word", cure)
            name = key_node.value
            _refuse_surrogates(mark, path, name)
            self.size += 1
            if name not in data:
                data[name] = self.read(child, (*path, name), mark)
                continue
            first = self.places[(*path, name)].key
            twice = f"on lines {first.line} and {mark.line}" if mark.line else "twice"
            found, expected = f"found key '{shown(name)}' {twice}", "expected each key once"
            cure = "keep one of the two"
            self.findings.append(Finding(mark, (*path, name), found, expected, cure))
        return data

    def plain(self, value: Any, path: Path = ()) -> Any:
        """Plain data of a Python value, numbers and arrays of NumPy too."""
        self._count(self.places[()].value, path)
        if hasattr(value, "tolist"):  # NumPy
            value = value.tolist()
        if isinstance(value, Mapping):
            words = ((_text(str(key)), child) for key, child in value.items())
            return {word: self.plain(child, (*path, word)) for word, child in words}
        if isinstance(value, Sequence) and not isinstance(value, str | bytes):
            return [self.plain(child, (*path, str(k))) for k, child in enumerate(value)]
        known = value is None or isinstance(value, bool | int | float)
        return value if known else _text(str(value))

    def _count(self, mark: Mark, path: Path) -> None:
        """Count one more node; stop reading where there are too many, or they nest too deep."""
        self.size += 1
        what = _excess(len(path), self.size)
        if what:
            raise _StopReading(mark, path, what, "expected a scene", "is this the right file?")


def _replaced(node: Any, path: Path, value: Any) -> Any:
    """A copy of plain data in which the value at a path is another one."""
    if not path:
        return value
    key = path[0]
    rest = path[1:]
    if isinstance(node, list) and key.isdecimal() and int(key) < len(node):
        k = int(key)
        return [*node[:k], _replaced(node[k], rest, value), *node[k + 1 :]]
    node = node if isinstance(node, dict) else {}
    return {**node, key: _replaced(node.get(key), rest, value)}


def document_of(value: object, mark: Mark) -> Document:
    """Document of a Python value, all of it at one mark."""
    document = Document(mark)
    try:
        document.data = document.plain(value)
    except _StopReading as stop:
        document.findings.append(stop.finding)
    return document


def parse(text: str, name: str, rank: int = 0, *, numbered: bool = True) -> Document:
    """Document of a YAML text; `numbered`: places are lines and columns of a file."""
    start = Mark(rank, name, 1, 1) if numbered else Mark(rank, name)
    document = Document(start)
    try:
        if strange := _UNPRINTABLE.search(text):
            before = text[: strange.start()]
            line, column = before.count("\n") + 1, strange.start() - before.rfind("\n")
            mark = start._replace(line=line, column=column)
            found = f"found the control character U+{ord(strange[0]):04X}"
            raise _StopReading(mark, (), found, "expected text", "is this a binary file?")
        _limit(text)
        root = yaml.compose(text, Loader=LOADER)
        if root is not None:
            document.data = document.read(root)
    except _StopReading as stop:
        document.findings.append(stop.finding)
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # the latter from escapes
        document.findings.append(_syntax_finding(error, text, start))
    return document


_UNPRINTABLE = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def _excess(depth: int, values: int) -> str:
    """What is too much of a document, in words; empty where nothing is."""
    if depth > MAX_DEPTH:
        return f"found maps and lists nested deeper than {MAX_DEPTH} levels"
    if values > MAX_VALUES:
        return f"found more than {MAX_VALUES} values (aliases count as all they stand for)"
    return ""


def _limit(text: str) -> None:
    """Refuse a text that is nested too deep, or too long, before it is made into nodes."""
    depth = count = documents = 0
    for event in yaml.parse(text, Loader=LOADER):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        count += isinstance(event, yaml.NodeEvent)
        documents += isinstance(event, yaml.DocumentStartEvent)
        what = _excess(depth - 1, (count + 1) // 2)  # a value may have a key, which is a node too
        if what:
            raise yaml.MarkedYAMLError(problem=what, problem_mark=event.start_mark)  # type: ignore[arg-type]  # or C's
        if documents > 1:
            return  # which is a fault of its own


def _refuse_surrogates(mark: Mark, path: Path, text: str) -> None:
    """Stop reading at a text with half a character, which no file could be written with."""
    if not text.isascii() and _UNPRINTABLE.search(text):
        found = "found an escape that is no character"
        raise _StopReading(mark, path, found, "expected text", "remove it")


def _text(text: str) -> str:
    """Text that validation can take: without halves of a character."""
    return text.encode("utf-8", "backslashreplace").decode()


# -- syntax errors in words --------------------------------------------------------------------

_MEANINGS = (  # part of the parser's message (C or Python), what was found, what to do
    (" tab|\\\\t", "found a tab", "indent with spaces"),
    ("nested|more than", "", "is this the right file?"),
    ("another document", "found a second document", "remove this '---' and what follows"),
    ("undefined alias", "found an alias (*) without its anchor (&)", "put the anchor before it"),
    ("mapping values", "found a second ':'", "put the text in quotes, or start a new line"),
    ("unexpected end of stream", "a quote is not closed", "close it"),
    (
        "(scanning|parsing) a quoted",
        "a quoted text is not readable",
        "check its quotes and escapes",
    ),
    ("a flow|expected ',' or", "a bracket is not closed, or a comma is missing", "close it"),
    ("expected ':'", "a key has no ':'", "write 'key: value'"),
    ("a block|expected key", "the indentation does not fit the lines above", "align the keys"),
    ("start any token", "a word begins with a character of YAML's own", "put it in quotes"),
    ("", "", "correct the text at this place"),
)


def _syntax_finding(error: Exception, text: str, start: Mark) -> Finding:
    """Fault of a YAML error, at the place of the problem (falls back on the file's start)."""
    spot = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    parts = (getattr(error, "context", ""), getattr(error, "problem", ""))
    message = " ".join(part for part in parts if part) or str(error)
    if spot is not None:  # a tab in the indentation, or at the place itself
        lines = re.split("\r\n|[\r\n\x85\u2028\u2029]", text)[: spot.line + 1]
        line = lines[spot.line] if spot.line < len(lines) else ""
        indent = line[: len(line) - len(line.lstrip())]
        if "\t" in indent or line[spot.column : spot.column + 1] == "\t":
            message = "found a tab"
    meaning, cure = next((m, c) for part, m, c in _MEANINGS if re.search(part, message))
    found = meaning or shown(message, 120)
    return Finding(start.at(spot), (), found, "expected YAML", cure)


# -- unquoted words ----------------------------------------------------------------------------

_INTEGER = re.compile(r"[+-]?(?:0|[1-9][0-9]*)")
_FLOAT = re.compile(
    r"[+-]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+)"
)
_NOT_FINITE = re.compile(r"[+-]?\.?(?:nan|inf|infinity)", re.IGNORECASE)
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}
_LONGEST_INTEGER = 18  # digits; above, no field takes it and int() of 10^5 digits is slow
_ODDITIES = (
    (r"[+-]?\d+(:\d+)+(\.\d*)?", "base 60 is not read, write a decimal number"),
    (r"[+-]?0[xobXOB][0-9a-fA-F_]+", "write the number in decimal"),
    (r"[+-]?0\d+", "write the number without leading zeros (it could mean octal)"),
    (r"[+-]?[\d.]+(_[\d.]+)+", "leave out the underscores"),
    (r"[+-]?\d+(,\d+)+", "write a decimal point, and no separators between thousands"),
    (r"[+-]?[\d.]+[dD][+-]?\d+", "write the exponent with e"),
    (r"[−–]\s*[\d.]+.*", "write the minus sign as an ASCII -"),
    (r"(?i:[\d.]+\s*(rpm)?\s*crank.*)", "only a speed may be the crank's, written as 6000 crank"),
    (r"[+-]?[\d.]+([eE][+-]?\d+)?\s*[^\W\d].*", "write the number without its unit"),
    (r"[+-]?[\d.]+\s*[-+*/^].*", "write the value out, expressions are not evaluated"),
)


def scalar(text: str) -> bool | int | float | str | None:
    """Value of an unquoted word: null, true or false, a number, or the text itself."""
    if len(text) <= 5 and text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if _INTEGER.fullmatch(text):
        return int(text) if len(text) <= _LONGEST_INTEGER else float(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text


def oddity(text: str) -> str:
    """What to do about a text that stands where a number is expected ('' when unknown)."""
    if not isinstance(scalar(text), str):
        return "remove the quotes" if text else "give a value"
    for pattern, cure in _ODDITIES:
        if len(text) <= 100 and re.fullmatch(pattern, text.strip()):
            return cure
    return ""
