"""YAML text to nodes, from the parser's events: no recursion, and a budget for everything.

Neither nesting nor aliases can make it use more than a bounded time and memory.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import yaml

from camcli.scene.nodes import Node
from camcli.scene.places import Finding, Mark, Path, Source, shown
from camcli.scene.scalars import resolve
from camcli.scene.syntax import syntax_finding

MAX_DEPTH = 32  # levels of maps and lists
MAX_NODES = 20_000  # values and keys, each alias counted as all it stands for

_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
_UNPRINTABLE = re.compile("[^\t\n\r -~\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class Tree(NamedTuple):
    """What was read: the root (None when reading had to stop) and the faults met on the way."""

    root: Node | None
    findings: tuple[Finding, ...]


def parse(text: str, source: Source) -> Tree:
    """Nodes of one YAML document; an empty one is a null."""
    builder = _Builder(source)
    try:
        for event in _events(text, source):
            builder.take(event)
    except _StopReading as stop:
        return Tree(None, (*builder.findings, stop.finding))
    except (yaml.YAMLError, ValueError, ArithmeticError) as error:  # the latter from escapes
        return Tree(None, (*builder.findings, syntax_finding(error, text, source)))
    return Tree(builder.root or Node(Mark(source, 1, 1), None), tuple(builder.findings))


class _StopReading(Exception):  # noqa: N818 - control flow inside this file
    def __init__(self, finding: Finding):
        self.finding = finding


def _events(text: str, source: Source) -> Iterator[yaml.Event]:
    strange = _UNPRINTABLE.search(text)
    if strange:
        before = text[: strange.start()]
        mark = Mark(source, before.count("\n") + 1, strange.start() - before.rfind("\n"))
        found = f"found the control character U+{ord(strange[0]):04X}"
        raise _StopReading(Finding(mark, (), found, "expected text", "is this a binary file?"))
    return yaml.parse(text, Loader=_LOADER)


class _Builder:
    """Takes events one by one and keeps the open maps and lists on a stack of its own."""

    def __init__(self, source: Source):
        self.source = source
        self.root: Node | None = None
        self.findings: list[Finding] = []
        self._open: list[Node] = []
        self._anchor_names: list[str | None] = []  # one per open node
        self._pending: list[tuple[str, Mark] | None] = []  # key whose value comes next
        self._anchors: dict[str, Node] = {}
        self._size = 0

    def take(self, event: yaml.Event) -> None:
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event)
        elif isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            self._start(event)
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            self._end()
        elif isinstance(event, yaml.AliasEvent):
            self._alias(event)
        elif isinstance(event, yaml.DocumentStartEvent) and self.root:
            found, cure = "found a second document", "remove this '---' and what follows"
            self._stop(event, found, "expected one document", cure)

    def _scalar(self, event: yaml.ScalarEvent) -> None:
        self._refuse_tag(event)
        written = event.style in (None, "")  # not quoted
        value = resolve(event.value) if written else event.value
        if not event.value.isascii() and _UNPRINTABLE.search(event.value):
            self._stop(event, "found an escape that is no character", "expected text")
        node = Node(self._mark(event), value, event.value if written else None)
        self._count(event, 1)
        self._complete(node, event.anchor, event.value)

    def _start(self, event: yaml.MappingStartEvent | yaml.SequenceStartEvent) -> None:
        self._refuse_tag(event)
        if self._expects_key():
            self._complex_key(event)
        self._count(event, 1)
        self._check_depth(event, 1)
        mapping = isinstance(event, yaml.MappingStartEvent)
        self._open.append(Node(self._mark(event), {} if mapping else []))
        self._anchor_names.append(event.anchor)
        self._pending.append(None)

    def _end(self) -> None:
        self._pending.pop()
        self._complete(self._open.pop(), self._anchor_names.pop(), None)

    def _alias(self, event: yaml.AliasEvent) -> None:
        name = shown(event.anchor)
        node = self._anchors.get(event.anchor)
        if node is None:
            cure = f"write &{name} before the value it stands for"
            self._stop(event, f"found *{name}", f"expected an anchor &{name} before it", cure)
        if self._expects_key() and isinstance(node.value, dict | list):
            self._complex_key(event)
        self._count(event, node.size)
        self._check_depth(event, node.height)
        key = node.text if node.text is not None else node.value
        self._complete(replace(node, mark=self._mark(event)), None, key)

    def _complete(self, node: Node, anchor: str | None, key: str | None) -> None:
        """Put a finished node where it belongs: the root, a list, a map's key or its value."""
        if anchor:
            self._anchors[anchor] = node
        if not self._open:
            self.root = node
            return
        parent = self._open[-1]
        parent.size += node.size
        if isinstance(parent.value, list):
            parent.value.append(node)
        elif self._pending[-1] is None:
            self._pending[-1] = (key, node.mark)
            return
        else:
            self._pair(parent, *self._pending[-1], node)
            self._pending[-1] = None
        parent.height = max(parent.height, node.height + 1)

    def _pair(self, parent: Node, key: str, mark: Mark, node: Node) -> None:
        if key not in parent.value:
            parent.value[key] = node
            parent.keys[key] = mark
            return
        first = parent.keys[key]
        lines = f"on lines {first.line} and {mark.line}" if mark.source.numbered else "twice"
        found = f"found key '{shown(key)}' {lines}"
        self._note(mark, found, "expected each key once", "keep one of the two")

    def _expects_key(self) -> bool:
        return (
            bool(self._open)
            and isinstance(self._open[-1].value, dict)
            and self._pending[-1] is None
        )

    def _complex_key(self, event: yaml.Event) -> None:
        found = "found a map or list as a key"
        self._stop(event, found, "expected a word", "write 'key: value' with a plain key")

    def _refuse_tag(self, event: yaml.NodeEvent) -> None:
        if event.tag is None:
            return
        tag = event.tag.replace("tag:yaml.org,2002:", "!!", 1)
        found = f"found the tag {shown(tag)}"
        self._note(self._mark(event), found, "expected a value without a tag", "remove the tag")

    def _count(self, event: yaml.Event, size: int) -> None:
        self._size += size
        if self._size > MAX_NODES:
            found = f"found more than {MAX_NODES} values (aliases count as all they stand for)"
            self._stop(event, found, "expected a scene", "is this the right file?")

    def _check_depth(self, event: yaml.Event, height: int) -> None:
        if len(self._open) + height > MAX_DEPTH:
            found = f"found maps and lists nested deeper than {MAX_DEPTH} levels"
            self._stop(event, found, "expected a scene", "is this the right file?")

    def _path(self) -> Path:
        path: list[str | int] = []
        for node, pending in zip(self._open, self._pending, strict=True):
            if isinstance(node.value, list):
                path.append(len(node.value))
            elif pending:
                path.append(pending[0])
        return tuple(path)

    def _note(self, mark: Mark, found: str, expected: str = "", cure: str = "") -> None:
        self.findings.append(Finding(mark, self._path(), found, expected, cure))

    def _stop(self, event: yaml.Event, found: str, expected: str = "", cure: str = "") -> None:
        raise _StopReading(Finding(self._mark(event), self._path(), found, expected, cure))

    def _mark(self, event: yaml.Event) -> Mark:
        return Mark(self.source, event.start_mark.line + 1, event.start_mark.column + 1)
