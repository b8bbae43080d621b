"""Functions that are executed only by tests which execute much else: the net is widest there.

    python -m tests.support.broadly_tested --map FOLDER [--more 1000] [analysis api/orbits.py]

FOLDER has a map of which tests execute which line (`tests/support/line_map.py`). Of each function
the narrowest test is taken, that which executes the fewest lines of the package; those are listed
whose narrowest test executes more lines than `--more`. A test of a whole command sees what such a
function does to the numbers of one scene; a change that shows in another one passes it.
"""

from __future__ import annotations

import argparse
import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from tests.support.line_map import LineMap
from tests.support.random_mutants import PACKAGE, python_files

FEWEST_LINES = 4  # of a function that is looked at


class Reached(NamedTuple):
    """A function, and the narrowest test that executes it; lines: that this test executes."""

    lines: int
    file: str
    name: str
    length: int
    test: str


def functions(file: Path) -> Iterator[tuple[str, range]]:
    """The name of each function of a module, and the lines of its body without a docstring."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.FunctionDef):
            continue
        body = node.body[1:] if ast.get_docstring(node) else node.body
        if body:
            yield node.name, range(body[0].lineno, body[-1].end_lineno + 1)


def reached(files: list[Path], executed: LineMap) -> list[Reached]:
    """What reaches each function, the broadest first; a function without a test is left out."""
    sizes = executed.sizes()
    found = []
    for file in files:
        short = str(file.relative_to(PACKAGE))
        for name, lines in functions(file):
            tests = executed.tests_of(short, lines)
            if len(lines) >= FEWEST_LINES and tests:
                narrowest = min(tests, key=lambda test: (sizes.get(test, 0), test))
                size = sizes.get(narrowest, 0)
                found.append(Reached(size, short, name, len(lines), narrowest))
    return sorted(found, reverse=True)


def main() -> int:
    """List the functions whose narrowest test is broad, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", help="folders or files of the package")
    parser.add_argument("--map", type=Path, required=True, help="folder of the map")
    parser.add_argument("--more", type=int, default=1000, help="lines that a test executes")
    asked = parser.parse_args()
    every = reached(python_files(asked.files), LineMap(asked.map.resolve()))
    broad = [one for one in every if one.lines > asked.more]
    for one in broad:
        print(f"{one.lines:6} {one.file}: {one.name} ({one.length} lines)  {one.test}")
    print(f"{len(broad)} of {len(every)} functions")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
