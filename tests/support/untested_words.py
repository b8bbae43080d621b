"""The texts of the package that stand, word for word, in no test.

    python -m tests.support.untested_words [words scene/schema.py]

A text is a piece of a string of two words or more, without docstrings; an f-string has one between
each two of its values. That a test has it does not say that it is compared, but what no test has
may lose its "not" unseen.
"""

from __future__ import annotations

import argparse
import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
SPACE = re.compile(r"\s+")
WORD = re.compile(r"[A-Za-z]{2,}")
ENDS = " .,:;"


def texts_of(source: str) -> Iterator[tuple[int, str]]:
    """Every text in a module's source, with its line."""
    tree = ast.parse(source)
    docstrings = {
        node.value for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    }  # fmt: skip
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
        if is_text and node not in docstrings:
            yield node.lineno, SPACE.sub(" ", node.value)


def pieces_of(text: str) -> Iterator[str]:
    """The pieces of a text between its `{values}` that have two words or more."""
    for piece in re.split(r"\{[^}]*\}", text):
        if len(WORD.findall(piece)) > 1 and " " in piece.strip(ENDS):
            yield piece.strip(ENDS)


def texts_of_tests() -> str:
    """All texts in the tests and on their sheets, one after the other."""
    found: list[str] = []
    for file in sorted((ROOT / "tests").rglob("test_*.py")):
        found += [text for _, text in texts_of(file.read_text(encoding="utf-8"))]
    for file in sorted((ROOT / "tests" / "truth").glob("*.toml")):
        found += in_values(tomllib.loads(file.read_text(encoding="utf-8")))
    return "\n".join(found)


def in_values(value: object) -> list[str]:
    """All texts in the values of a sheet."""
    if isinstance(value, str):
        return [SPACE.sub(" ", value)]
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [text for one in inner for text in in_values(one)]


def untested(folders: list[str]) -> Iterator[tuple[str, int, str]]:
    """(file, line, text) of each text in files or folders of the package that no test has."""
    known = texts_of_tests()
    for name in folders:
        place = ROOT / "camcli" / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            for line, text in texts_of(file.read_text(encoding="utf-8")):
                for piece in pieces_of(text):
                    if piece not in known:
                        yield str(file.relative_to(ROOT)), line, piece


def main() -> int:
    """List them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", default=["."], help="folders or files of the package")
    for file, line, text in untested(parser.parse_args().files):
        print(f"{file}:{line}: {text}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
