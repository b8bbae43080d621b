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
    """Reading ends here, with this finding."""

    def __init__(self, mark: Mark, path: Path, found: str, expected: str, cure: str):
        self.finding = Finding(mark, path, found, expected, cure)


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
        depth = len(path)
        for level in range(1, depth):
            above = path[:level]
            if not isinstance(self.value(above), dict | list):
                self.places[above] = Place(mark, mark)
        self.data = _replaced(self.data, path, other.data)
        # all that was at the path or below it has gone
        kept = {known: place for known, place in self.places.items() if known[:depth] != path}
        new = {(*path, *below): place for below, place in other.places.items()}
        self.places = kept | new

    def read(self, node: yaml.Node, path: Path = (), key: Mark | None = None) -> Any:
        """Plain data of a YAML node and all below it; aliases are copied out.

        path: of the node; key: where its key stands, None for an item of a list and for the root.
        """
        mark = self._mark_of(node)
        self._count(mark, path)
        unquoted = isinstance(node, yaml.ScalarNode) and not node.style
        self.places[path] = Place(mark, key or mark, node.value if unquoted else None)
        self._note_tag(node, mark, path)
        if isinstance(node, yaml.ScalarNode):
            _refuse_surrogates(mark, path, node.value)
            return scalar(node.value) if unquoted else node.value
        if isinstance(node, yaml.SequenceNode):
            return [self.read(child, (*path, str(k))) for k, child in enumerate(node.value)]
        return self._read_map(node, path)

    def _read_map(self, node: yaml.Node, path: Path) -> dict[str, Any]:
        """Plain data of a map at a path; a key that comes again is a finding."""
        data: dict[str, Any] = {}
        for key_node, child in node.value:
            mark = self._mark_of(key_node)
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
            found = f"found key '{shown(name)}' {twice}"
            expected = "expected each key once"
            cure = "keep one of the two"
            self.findings.append(Finding(mark, (*path, name), found, expected, cure))
        return data

    def _mark_of(self, node: yaml.Node) -> Mark:
        """Where a node stands."""
        return self.places[()].value.at(node.start_mark)

    def _note_tag(self, node: yaml.Node, mark: Mark, path: Path) -> None:
        """A finding where a node has a tag other than that of its kind."""
        kind = {yaml.ScalarNode: "str", yaml.SequenceNode: "seq"}.get(type(node), "map")
        if node.tag != f"tag:yaml.org,2002:{kind}":
            tag = shown(node.tag.replace("tag:yaml.org,2002:", "!!", 1))
            expected = "expected a value without a tag"
            self.findings.append(Finding(mark, path, f"found the tag {tag}", expected, "remove it"))

    def plain(self, value: Any, path: Path = ()) -> Any:
        """Plain data of a Python value, numbers and arrays of NumPy too."""
        self._count(self.places[()].value, path)
        if hasattr(value, "tolist"):  # NumPy
            value = value.tolist()
        if isinstance(value, Mapping):
            data = {}
            for key, child in value.items():
                name = _text(str(key))
                data[name] = self.plain(child, (*path, name))
            return data
        if isinstance(value, Sequence) and not isinstance(value, str | bytes):
            return [self.plain(child, (*path, str(k))) for k, child in enumerate(value)]
        if value is None or isinstance(value, bool | int | float):
            return value
        return _text(str(value))

    def _count(self, mark: Mark, path: Path) -> None:
        """Count one more node; stop reading where there are too many, or they nest too deep."""
        self.size += 1
        excess = _excess(len(path), self.size)
        if excess:
            raise _StopReading(mark, path, excess, "expected a scene", "is this the right file?")


def _replaced(node: Any, path: Path, value: Any) -> Any:
    """A copy of plain data in which the value at a path is another one.

    A single value on the way becomes a map, and so does a list that has no such item.
    """
    if not path:
        return value
    key, *below = path
    if isinstance(node, list) and key.isdecimal() and int(key) < len(node):
        copy = list(node)
        copy[int(key)] = _replaced(node[int(key)], tuple(below), value)
        return copy
    section = node if isinstance(node, dict) else {}
    return {**section, key: _replaced(section.get(key), tuple(below), value)}


def document_of(value: object, mark: Mark) -> Document:
    """Document of a Python value, all of it at one mark."""
    document = Document(mark)
    try:
        document.data = document.plain(value)
    except _StopReading as stop:
        document.findings.append(stop.finding)
    return document


def parse(text: str, name: str, rank: int = 0, *, numbered: bool = True) -> Document:
    """Document of a YAML text.

    name, rank: of its marks; `numbered`: places are lines and columns of a file.
    """
    start = Mark(rank, name, 1, 1) if numbered else Mark(rank, name)
    document = Document(start)
    try:
        _refuse_control_characters(start, text)
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
    """The part of a fault that says which limit a document breaks; empty where it keeps to both."""
    if depth > MAX_DEPTH:
        return f"found maps and lists nested deeper than {MAX_DEPTH} levels"
    if values > MAX_VALUES:
        return f"found more than {MAX_VALUES} values (aliases count as all they stand for)"
    return ""


def _limit(text: str) -> None:
    """Refuse a text that is nested too deep, or too long, before it is made into nodes."""
    depth = 0
    nodes = 0
    documents = 0
    for event in yaml.parse(text, Loader=LOADER):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        if isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if isinstance(event, yaml.NodeEvent):
            nodes += 1
        if isinstance(event, yaml.DocumentStartEvent):
            documents += 1
        values = (nodes + 1) // 2  # at least: a value may have a key, which is a node too
        excess = _excess(depth - 1, values)
        if excess:
            raise yaml.MarkedYAMLError(problem=excess, problem_mark=event.start_mark)  # type: ignore[arg-type]  # or C's
        if documents > 1:
            return  # which is a fault of its own


def _refuse_control_characters(start: Mark, text: str) -> None:
    """Stop reading at a character that is no text; start: where the text begins."""
    strange = _UNPRINTABLE.search(text)
    if strange is None:
        return
    before = text[: strange.start()]
    line = before.count("\n") + 1
    column = strange.start() - before.rfind("\n")
    mark = start._replace(line=line, column=column)
    found = f"found the control character U+{ord(strange[0]):04X}"
    raise _StopReading(mark, (), found, "expected text", "is this a binary file?")


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
    (
        "maximum nesting depth",  # the parser's own, which it may reach as it reads ahead
        f"found maps and lists nested deeper than {MAX_DEPTH} levels",
        "is this the right file?",
    ),
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
    """Fault of a YAML error, at the place of the problem (falls back on the file's start).

    text: the whole; start: where it begins.
    """
    spot = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    context = getattr(error, "context", "")
    problem = getattr(error, "problem", "")
    message = " ".join(filter(None, (context, problem))) or str(error)
    if spot is not None and _has_tab(text, spot.line, spot.column):
        message = "found a tab"
    fitting = (row for row in _MEANINGS if re.search(row[0], message))
    _, meaning, cure = next(fitting)  # the last row fits any message
    found = meaning or shown(message, 120)
    return Finding(start.at(spot), (), found, "expected YAML", cure)


def _has_tab(text: str, line: int, column: int) -> bool:
    """Whether a tab stands at this place, or in the indentation of its line; both from 0."""
    lines = re.split("\r\n|[\r\n\x85\u2028\u2029]", text)
    if line >= len(lines):
        return False
    content = lines[line]
    indent = content[: len(content) - len(content.lstrip())]
    return "\t" in indent or content[column : column + 1] == "\t"


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
