"""YAML syntax errors as one fault in words a person understands."""

from __future__ import annotations

import re

from camcli.scene.places import Finding, Mark, Source, shown

_LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")  # as YAML counts lines

_MEANINGS = (  # part of the parser's message (C or Python), what was found, what to do
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


def syntax_finding(error: Exception, text: str, source: Source) -> Finding:
    """Fault of a YAML error, at the place of the problem (falls back on the file's start)."""
    spot = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
    line, column = (spot.line, spot.column) if spot else (0, 0)
    mark = Mark(source, line + 1, column + 1)
    message = " ".join(
        part for part in (getattr(error, "context", ""), getattr(error, "problem", "")) if part
    )
    if _tab(text, line, column) or " tab" in message:
        return Finding(mark, (), "found a tab", "expected YAML", "indent with spaces")
    for part, found, cure in _MEANINGS:
        if part in message:
            return Finding(mark, (), found, "expected YAML", cure)
    found = shown(message or str(error), 120)
    return Finding(mark, (), found, "expected YAML", "correct the text at this place")


def _tab(text: str, line: int, column: int) -> bool:
    """Whether a tab indents the line of an error, or stands at its place."""
    lines = _LINE_BREAK.split(text)
    if line >= len(lines):
        return False
    content = lines[line]
    indent = content[: len(content) - len(content.lstrip())]
    return "\t" in indent or content[column : column + 1] == "\t"
