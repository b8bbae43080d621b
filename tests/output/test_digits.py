"""How many digits each number of a sentence, a table or a picture has.

The sheet `digits.toml` has every number that is written with a form of its own, by the module that
writes it: what is written, and in which form. The sentences of the tests hold numbers that are
short, so that a digit more or less is seen in few of them. Whoever changes digits on purpose writes
the sheet anew (`CAMCLI_LOOKS=1 pytest -n 0 tests/output/test_digits.py`).
"""

from __future__ import annotations

import ast
import os
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import camcli

PACKAGE = Path(camcli.__file__).parent
SHEET = Path(__file__).parent / "digits.toml"
FOLDERS = ("api", "cli", "output", "plots", "scene", "words")


def forms_in(text: str) -> Iterator[str]:
    """What is written with a number of digits, and its form, in the order of a module."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FormattedValue) and node.format_spec is not None:
            form = ast.unparse(node.format_spec)[2:-1]
            if re.search(r"\d", form) or "{" in form:
                yield f"{ast.unparse(node.value)} as {form}"


def found() -> dict[str, list[str]]:
    """The forms of every module that has some."""
    modules = {}
    for folder in FOLDERS:
        for path in sorted((PACKAGE / folder).rglob("*.py")):
            forms = sorted(forms_in(path.read_text(encoding="utf-8")))
            if forms:
                modules[path.relative_to(PACKAGE).as_posix()] = forms
    return modules


def written(modules: dict[str, list[str]]) -> str:
    parts = ["# The digits of numbers, by module; see tests/output/test_digits.py.\n"]
    for name, forms in modules.items():
        rows = "".join(f"  '''{form}''',\n" for form in forms)
        parts.append(f'"{name}" = [\n{rows}]\n')
    return "\n".join(parts)


def test_each_number_has_the_digits_that_it_deserves():
    modules = found()
    if "CAMCLI_LOOKS" in os.environ:
        SHEET.write_text(written(modules), encoding="utf-8")
    sheet = tomllib.loads(SHEET.read_text(encoding="utf-8"))
    assert modules.keys() == sheet.keys()
    for name, forms in modules.items():
        assert forms == sheet[name], name


def test_forms_are_read_from_a_module():
    text = "said = f'{x:.3g} of {n} at {theta * 2:.{digits}g}, {y!r:>8} {z:,}'\n"
    assert [*forms_in(text)] == ["x as .3g", "theta * 2 as .{digits}g", "y as >8"]
