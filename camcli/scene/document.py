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


def dotted(path: Sequence[str]) -> str:
    """`('run', 'start', 'q')` as `run.start.q`."""
    return shown(".".join(shown(key, 40) for key in path[:40]), 160)


class Document:
    """Plain data and the places of its values; `findings` are the faults met while reading.

    `data` is None, with a finding that says why, where reading had to stop.
    """

    def __init__(self, start: Mark, data: Any = None):
        self.data = data
        self.places: dict[Path, Place] = {(): Place(start, start)}
        self.findings: list[Finding] = []

    def value(self, path: Path) -> Any:
        """Value at a path, None where there is none."""
        node = self.data
        for key in path:
            if isinstance(node, list):
                node = node[int(key)] if key.isdecimal() and int(key) < len(node) else None
            else:
                node = node.get(key) if isinstance(node, dict) else None
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
        mark, size = other.places[()].key, len(path)
        for n in range(1, size):
            if not isinstance(self.value(path[:n]), dict | list):
                self.places[path[:n]] = Place(mark, mark)
        self.data = _replaced(self.data, path, other.data)
        self.places = {known: p for known, p in self.places.items() if known[:size] != path}
        self.places |= {(*path, *below): p for below, p in other.places.items()}


def _replaced(node: Any, path: Path, value: Any) -> Any:
    """Copy of plain data with the value at a path."""
    if not path:
        return value
    key, rest = path[0], path[1:]
    if isinstance(node, list) and key.isdecimal() and int(key) < len(node):
        k = int(key)
        return [*node[:k], _replaced(node[k], rest, value), *node[k + 1 :]]
    node = node if isinstance(node, dict) else {}
    return {**node, key: _replaced(node.get(key), rest, value)}


def document_of(value: object, mark: Mark) -> Document:
    """Document of a Python value (numbers and arrays of NumPy too), all of it at one mark."""
    document = Document(mark)
    try:
        document.data = _Builder(document).plain(value, (), 0)
    except _StopReading as stop:
        document.findings.append(stop.finding)
    return document


def parse(text: str, name: str, rank: int = 0, *, numbered: bool = True) -> Document:
    """Document of a YAML text; `numbered`: places are lines and columns of a file."""
    source = Mark(rank, name)
    document = Document(source._replace(line=1, column=1) if numbered else source)
    try:
        strange = _UNPRINTABLE.search(text)
        if strange:
            before = text[: strange.start()]
            column = strange.start() - before.rfind("\n")
            mark = source._replace(line=before.count("\n") + 1, column=column)
            found = f"found the control character U+{ord(strange[0]):04X}"
            cure = "is this a binary file?"
            raise _StopReading(Finding(mark, (), found, "expected text", cure))
        loader = _LOADER(text)
        try:
            root = loader.get_single_node()
        finally:
            loader.dispose()
        if root is not None:
            builder = _Builder(document)
            document.data = builder.value(root, (), 0)
    except _StopReading as stop:
        document.findings.append(stop.finding)
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # the latter from escapes
        document.findings.append(_syntax_finding(error, text, document.places[()].value))
    return document


# -- YAML nodes to plain data ------------------------------------------------------------------

_UNPRINTABLE = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class _StopReading(Exception):  # noqa: N818 - control flow inside this file
    def __init__(self, finding: Finding):
        self.finding = finding


class _Composer(yaml.composer.Composer):
    """Composes nodes with their marks, within the limits; resolves no tags.

    Nothing is constructed: no text makes an object of Python.
    """

    depth = count = 0

    def compose_node(self, parent, index):
        """A node and all below it."""
        self.depth += 1
        self.count += 1
        if self.depth > MAX_DEPTH + 1 or self.count > 2 * MAX_VALUES:
            what = _TOO_DEEP if self.depth > MAX_DEPTH + 1 else _TOO_MANY
            raise yaml.MarkedYAMLError(problem=what, problem_mark=self.peek_event().start_mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        return node

    def resolve(self, kind, value, implicit):
        """No tag, so that one that was written can be told."""
        return ""


def limited(base: type) -> type:
    """A loader of the limited composer and the parser of a loader of PyYAML."""

    class Loader(_Composer, base):
        def __init__(self, text: str):
            base.__init__(self, text)  # type: ignore[misc]  # PyYAML's own way to join classes
            _Composer.__init__(self)

    return Loader


_LOADER = limited(getattr(yaml, "CBaseLoader", yaml.BaseLoader))
_TOO_DEEP = f"found maps and lists nested deeper than {MAX_DEPTH} levels"
_TOO_MANY = f"found more than {MAX_VALUES} values (aliases count as all they stand for)"


class _Builder:
    """Fills a document from YAML nodes or Python values; aliases are copied out."""

    def __init__(self, document: Document):
        self.document = document
        self.source = document.places[()].value
        self.size = 0

    def value(self, node: yaml.Node, path: Path, depth: int, key: Mark | None = None) -> Any:
        """Plain data of a node and all below it."""
        mark = self._mark(node)
        self._count(mark, path, depth)
        quoted = not isinstance(node, yaml.ScalarNode) or bool(node.style)
        self.document.places[path] = Place(mark, key or mark, None if quoted else node.value)
        if node.tag:
            tag = shown(node.tag.replace("tag:yaml.org,2002:", "!!", 1))
            self._note(mark, path, f"found the tag {tag}", "a value without a tag", "remove it")
        if isinstance(node, yaml.ScalarNode):
            self._refuse_surrogates(node, path)
            return node.value if quoted else scalar(node.value)
        if isinstance(node, yaml.SequenceNode):
            children = enumerate(node.value)
            return [self.value(child, (*path, str(k)), depth + 1) for k, child in children]
        data: dict[str, Any] = {}
        for key_node, child in node.value:
            mark = self._mark(key_node)
            if not isinstance(key_node, yaml.ScalarNode):
                cure = "write 'key: value' with a plain key"
                self._stop(mark, path, "found a map or list as a key", "a word", cure)
            self._refuse_surrogates(key_node, path)
            word = key_node.value
            self.size += 1
            if word not in data:
                data[word] = self.value(child, (*path, word), depth + 1, mark)
                continue
            first = self.document.places[(*path, word)].key
            twice = f"on lines {first.line} and {mark.line}" if mark.line else "twice"
            found = f"found key '{shown(word)}' {twice}"
            self._note(mark, (*path, word), found, "each key once", "keep one of the two")
        return data

    def plain(self, value: Any, path: Path, depth: int) -> Any:
        """Plain data of a Python value."""
        self._count(self.source, path, depth)
        if hasattr(value, "tolist"):  # NumPy
            value = value.tolist()
        if isinstance(value, Mapping):
            words = ((_text(str(key)), child) for key, child in value.items())
            return {word: self.plain(child, (*path, word), depth + 1) for word, child in words}
        if isinstance(value, Sequence) and not isinstance(value, str | bytes):
            children = enumerate(value)
            return [self.plain(child, (*path, str(k)), depth + 1) for k, child in children]
        if value is None or isinstance(value, bool | int | float):
            return value
        return _text(str(value))

    def _count(self, mark: Mark, path: Path, depth: int) -> None:
        self.size += 1
        if depth > MAX_DEPTH or self.size > MAX_VALUES:
            what = _TOO_DEEP if depth > MAX_DEPTH else _TOO_MANY
            self._stop(mark, path, what, "a scene", "is this the right file?")

    def _refuse_surrogates(self, node: yaml.ScalarNode, path: Path) -> None:
        if not node.value.isascii() and _UNPRINTABLE.search(node.value):
            found = "found an escape that is no character"
            self._stop(self._mark(node), path, found, "text", "remove it")

    def _note(self, mark: Mark, path: Path, found: str, expected: str, cure: str) -> None:
        self.document.findings.append(Finding(mark, path, found, f"expected {expected}", cure))

    def _stop(self, mark: Mark, path: Path, found: str, expected: str, cure: str) -> None:
        raise _StopReading(Finding(mark, path, found, f"expected {expected}", cure))

    def _mark(self, node: yaml.Node) -> Mark:
        if not self.source.line:
            return self.source
        spot = node.start_mark
        return self.source._replace(line=spot.line + 1, column=spot.column + 1)


def _text(text: str) -> str:
    """Text that validation can take: without halves of a character."""
    return text.encode("utf-8", "backslashreplace").decode()


# -- syntax errors in words --------------------------------------------------------------------

_LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")  # as YAML counts lines
_MEANINGS = (  # part of the parser's message (C or Python), what was found, what to do
    (_TOO_DEEP, _TOO_DEEP, "is this the right file?"),
    (_TOO_MANY, _TOO_MANY, "is this the right file?"),
    ("another document", "found a second document", "remove this '---' and what follows"),
    ("undefined alias", "found an alias (*) without its anchor (&)", "put the anchor before it"),
    (
        "mapping values are not allowed",
        "found a second ':'",
        "put the text in quotes, or start a new line",
    ),
    ("found unexpected end of stream", "a quote is not closed", "close it"),
    ("while scanning a quoted", "a quoted text is not readable", "check its quotes and escapes"),
    ("while parsing a flow", "a bracket is not closed, or a comma is missing", "close it"),
    ("did not find expected ',' or", "a bracket is not closed, or a comma is missing", "close it"),
    ("could not find expected ':'", "a key has no ':'", "write 'key: value'"),
    ("while parsing a block", "the indentation does not fit the lines above", "align the keys"),
    ("did not find expected key", "the indentation does not fit the lines above", "align the keys"),
)


def _syntax_finding(error: Exception, text: str, start: Mark) -> Finding:
    """Fault of a YAML error, at the place of the problem (falls back on the file's start)."""
    spot = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    mark = start
    if spot and start.line:
        mark = start._replace(line=spot.line + 1, column=spot.column + 1)
    parts = (getattr(error, "context", ""), getattr(error, "problem", ""))
    message = " ".join(part for part in parts if part)
    if _has_tab(text, spot) or " tab" in message:
        return Finding(mark, (), "found a tab", "expected YAML", "indent with spaces")
    for part, found, cure in _MEANINGS:
        if part in message:
            return Finding(mark, (), found, "expected YAML", cure)
    found = shown(message or str(error), 120)
    return Finding(mark, (), found, "expected YAML", "correct the text at this place")


def _has_tab(text: str, spot: Any) -> bool:
    """Whether a tab indents the line of an error, or stands at its place."""
    lines = _LINE_BREAK.split(text)
    if spot is None or spot.line >= len(lines):
        return False
    line = lines[spot.line]
    indent = line[: len(line) - len(line.lstrip())]
    return "\t" in indent or line[spot.column : spot.column + 1] == "\t"


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
