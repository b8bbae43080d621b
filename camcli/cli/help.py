"""What `--help` shows of a command, and what its page of the guide tells.

The docstring of a command has a sentence, the blocks `Examples:` and `Files:`, and the rest. Help
shows the first three; the page of the guide, which `camcli.cli.reference` writes, has all of it and
the columns of every table, from the record of the command.
"""

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent

FULL = 92  # columns: a longer line of a docstring was broken because it was full
ENTRY = re.compile(r"\S.{0,24}?  +")  # NAME  what it is, in a docstring


@dataclass(frozen=True)
class Help:
    """The parts of a command's docstring; of examples and files the lines."""

    sentence: str
    examples: list[str]
    files: list[str]
    rest: str


def parts_of(docstring: str) -> Help:
    """A command's docstring in its parts: sentence, examples, files, and the rest."""
    # a block that begins with \b keeps its lines in the help; typer takes that mark, not the reader
    text = inspect.cleandoc(docstring).replace("\b\n", "")
    blocks = text.split("\n\n")
    named: dict[str, list[str]] = {"Examples:": [], "Files:": []}
    rest = []
    for block in blocks[1:]:
        heading, _, body = block.strip("\n").partition("\n")
        if heading in named:
            named[heading] = dedent(body).splitlines()
        else:
            rest.append(block)
    return Help(blocks[0], named["Examples:"], named["Files:"], "\n\n".join(rest))


def about_tables(name: str) -> str:
    """What the docstring of a command's API function, which is not run, says of all its tables.

    It is what its section Returns says after the first paragraph.
    """
    path = Path(__file__).parents[1] / "api" / f"{name}.py"
    tree = ast.parse(path.read_text(encoding="utf-8") if path.is_file() else "")
    docstring = ""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            docstring = (ast.get_docstring(node) or "").replace("``", "")
    _, _, from_returns = docstring.partition("\nReturns\n")
    returns = re.split(r"\n\n\w+\n---", from_returns)[0]  # up to the heading of the next section
    _, *paragraphs = returns.split("\n\n")
    return "\n\n".join(" ".join(text.split()) for text in paragraphs)


def filled_lines(text: str) -> Iterator[str]:
    """The lines of a docstring, those joined that were only broken because a line was full.

    A line goes on the one before it where it is indented, or where that one was full.
    """
    joined = ""
    last = ""
    for line in text.splitlines():
        first_word = line.split(" ", 1)[0]  # empty where the line is indented
        is_indented = not first_word
        last_was_full = len(f"{last} {first_word}") > FULL and not first_word.startswith("--")
        goes_on = is_indented or (last_was_full and not ENTRY.match(line))
        if line and last and goes_on:
            joined += " " + line.lstrip()
        else:
            if joined or last:
                yield joined
            joined = line
            if not line:
                yield ""
                joined = ""
        last = line
    if joined:
        yield joined
