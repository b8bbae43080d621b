"""The reference of the guide, written from the program's own tables.

    python -m camcli.cli.reference

writes `camcli/guide/reference/*.md`: a page for each command, and those of the scene, the statuses
and the exit codes. A test says when they are out of date.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from itertools import groupby
from typing import Any

from camcli.api.command import Command, columns_of, command_of
from camcli.cli.app import COMMANDS
from camcli.cli.exit_codes import MEANING
from camcli.cli.help import ENTRY, about_tables, filled_lines, parts_of
from camcli.errors import Status
from camcli.guide import FOLDER
from camcli.scene import json_schema
from camcli.words.statuses import CAUSES, CURES

CODE = re.compile(  # an option, a key of the scene, a file, a column
    r"(?<![\w`.])((?:--[a-z][\w-]*|[a-z]+\.(?:csv|png|json|pdf|npz)|"
    r"(?:run|follower|cam|simulate|sweep|detach|orbits|basins|classify|explore|bench|plot)"
    r"\.[a-z]\w*|[A-Za-z]\w*_\w+))(?!\w)"
)


EMPTY = "What does not apply is empty; of numbers the library has NaN there."


def written() -> dict[str, str]:
    """The text of each page, by its topic."""
    pages = {name: command_page(name) for name in COMMANDS}
    return {**pages, "scene": scene_page(), "statuses": status_page(), "exit-codes": exit_page()}


def command_page(name: str) -> str:
    """Sentence, examples, options, files with their columns, and what there is to know."""
    import typer

    from camcli.cli.app import application

    help_text = parts_of(getattr(import_module(f"camcli.cli.{name}"), name).__doc__)
    lines = [f"# cam {name}", "", help_text.sentence, ""]
    lines += ["```text", *help_text.examples, "```", ""]
    group: Any = typer.main.get_command(application(name))
    command = group.commands[name]
    context = command.context_class(command, info_name=name)
    lines += ["## Options", "", "| option | |", "|---|---|"]
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None:
            lines.append(f"| `{_cell(record[0])}` | {_cell(record[1])} |")
    if find_spec(f"camcli.api.{name}") is not None:
        lines += table_lines(command_of(name))
    about = about_tables(name)
    if about:
        lines += ["", *_listed(about)]
    if help_text.rest:
        lines += ["", "## More", "", *_listed(help_text.rest)]
    return _page(lines)


def table_lines(command: Command) -> Iterator[str]:
    """Every table of a command with its columns, their units and what they are."""
    words = {head.name: head.words for head in command.tables}
    if words:
        yield from ("", "## Tables", "", EMPTY)
    for table, columns in groupby(columns_of(command), lambda column: column.table):
        yield from ("", f"### `{table}.csv`", "", f"{_plain(words[table])}", "")
        yield from ("| column | unit | |", "|---|---|---|")
        for column in columns:
            when = f"{column.when}: " if column.when else ""
            meaning = _plain(_cell(when + column.meaning))
            yield f"| `{column.column}` | {_plain(column.unit)} | {meaning} |"


def scene_page() -> str:
    """Every key of a scene with its meaning, limits and default."""
    schema = json_schema()
    lines = [
        "# The scene", "",
        "A scene is a YAML file. `cam schema` prints its JSON Schema for editors; the files in",
        "`configs/` comment every key. What a scene leaves out has the default.", "",
    ]  # fmt: skip
    for name, value in schema["properties"].items():
        lines += [f"## {name}", "", value.get("description", ""), ""]
        for title, keys in _sections(value, schema["$defs"]):
            lines += [f"### {title}", ""] if title else []
            lines += ["| key | meaning | default |", "|---|---|---|"]
            for key, entry in keys.items():
                default = _default(entry)
                meaning = entry.get("description", "")
                lines.append(f"| `{name}.{key}` | {_cell(meaning)} | {default} |")
            lines.append("")
    return _page(lines)


def status_page() -> str:
    """What each status says, and what to do."""
    lines = ["# Statuses", "", "The column `status` says of each row whether it may be used.", ""]
    lines += ["| status | what happened | what to do |", "|---|---|---|"]
    for status in Status:
        if status not in (Status.LOG_FULL, Status.PAUSED):  # never in a table
            cause = CAUSES.get(status, "all is well")
            cure = CURES.get(status, "")
            lines.append(f"| `{status.text}` | {cause} | {cure} |")
    return _page(lines)


CHECKER_CODES = """
`python -m camcli.check proof.json`, which confirms a proof without the rest of camcli, ends with 0
where every statement is confirmed, with 1 where one is not, with 2 where the file is none of its
files, and with 3 where the file holds no statement, so that nothing is confirmed.
""".strip()


def exit_page() -> str:
    """What each exit code says."""
    lines = ["# Exit codes", "", "| code | meaning |", "|---|---|"]
    lines += [f"| {code} | {words} |" for code, words in MEANING.items()]
    return _page([*lines, "", CHECKER_CODES])


def notebook() -> str:
    """The page `notebook` as a notebook: its text and its blocks of Python in cells."""
    text = (FOLDER / "how-to" / "notebook.md").read_text(encoding="utf-8")
    cells: list[dict[str, Any]] = []
    words_and_block = r"(.*?)(?:```(\w+)\n(.*?)```|\Z)"  # a block has its language behind ```
    for words, kind, block in re.findall(words_and_block, text, re.DOTALL):
        if words.strip():
            cells.append({"cell_type": "markdown", "metadata": {}, "source": words.strip()})
        if kind == "python":
            code_cell = {"execution_count": None, "outputs": [], "source": block.rstrip("\n")}
            cells.append({"cell_type": "code", "metadata": {}, **code_cell})
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    content = {
        "cells": cells,
        "metadata": {"kernelspec": kernel},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    return json.dumps(content, indent=1) + "\n"


def _sections(value: dict, defs: dict) -> Iterator[tuple[str, dict]]:
    """(title, keys) of a section of the JSON Schema; of the cam one for each kind.

    value: of the section; defs: the models by name. A key has its entry in the schema.
    """
    for form in value.get("oneOf") or value.get("anyOf") or [value]:
        first_part = (form.get("allOf") or [{}])[0]
        reference = form.get("$ref") or first_part.get("$ref", "")  # #/$defs/MODEL
        model = defs.get(reference.rpartition("/")[2], {})
        keys = dict(model.get("properties", {}))
        kind = keys.get("kind", {}).get("const", "")
        if keys:
            yield (f"kind: {kind}" if kind else "", keys)


def _default(entry: dict) -> str:
    """The default of a key as code, empty where there is none."""
    if "default" not in entry or entry["default"] is None:
        return ""
    text = str(entry["default"])
    if isinstance(entry["default"], bool):
        text = text.lower()
    return f"`{_cell(text)}`"


def _listed(text: str) -> Iterator[str]:
    """Lines of a docstring in Markdown; `NAME  what it is` becomes an item of a list."""
    in_list = False
    for line in filled_lines(text):
        entry = ENTRY.match(line)
        if entry:
            yield f"- `{entry.group().strip()}` {_plain(line[entry.end() :])}"
        elif line:
            if in_list:
                yield ""
            yield from (_plain(line), "")
        else:
            yield ""
        in_list = entry is not None


def _plain(text: str) -> str:
    """Text of a docstring with its options, keys, columns and files set as code."""
    return CODE.sub(r"`\1`", text.replace("*", "\\*"))


def _cell(text: str) -> str:
    """Text as a cell of a table in Markdown."""
    return text.replace("|", "\\|").replace("\n", " ")


def _page(lines: list[str]) -> str:
    """Lines as a page: no two empty ones in a row."""
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).strip() + "\n"


def main() -> None:
    """Write every page."""
    for topic, text in written().items():
        (FOLDER / "reference" / f"{topic}.md").write_text(text, encoding="utf-8")
    (FOLDER / "how-to" / "notebook.ipynb").write_text(notebook(), encoding="utf-8")


if __name__ == "__main__":
    main()
