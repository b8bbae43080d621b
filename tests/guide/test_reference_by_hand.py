"""The reference and the help, function by function: pages of commands and scenes made by hand."""

from __future__ import annotations

import json
from inspect import cleandoc
from types import SimpleNamespace as Made

import pytest

from camcli.cli import help as help_module
from camcli.cli import reference
from camcli.cli.exit_codes import MEANING
from camcli.cli.help import Help, about_tables, filled_lines, parts_of
from camcli.errors import Status
from camcli.words.statuses import CAUSES, CURES

DOCSTRING = """Do it.

    Examples:
      cam do --it                              done
        indented

    Files:
      a.csv            rows

    \b
    a.csv   what it is
    More of it.

    Last: words.
"""


def test_a_docstring_in_its_parts():
    assert parts_of(DOCSTRING) == Help(
        "Do it.",
        ["cam do --it                              done", "  indented"],
        ["a.csv            rows"],
        "a.csv   what it is\nMore of it.\n\nLast: words.",
    )
    assert parts_of("Do it.") == Help("Do it.", [], [], "")


def test_lines_that_were_full_are_joined():
    """A line goes on where it is indented, or where the one before had no room for its word."""
    full = "w " * 42 + "ww"  # 86 columns: with a next word of six letters beyond 92
    text = "\n".join([
        "short", "next", "NAME   what it is", "       and more", full, "worded behind it",
        full, "abcde", full, "--option sets it", full, "KEYWORD  what", "", "  indented", "end",
    ])  # fmt: skip
    assert [*filled_lines(text)] == [
        "short", "next", "NAME   what it is and more", f"{full} worded behind it", full, "abcde",
        full, "--option sets it", full, "KEYWORD  what", "", "  indented", "end",
    ]  # fmt: skip
    assert [*filled_lines("")] == []
    assert [*filled_lines(f"{full} a\nbcdef g")] == [f"{full} a bcdef g"]


def test_what_is_said_of_all_tables_of_a_command(tmp_path, monkeypatch):
    """Behind the first paragraph of Returns, up to the next section."""
    path = tmp_path / "cli" / "help.py"
    monkeypatch.setattr(help_module, "__file__", str(path))
    (tmp_path / "api").mkdir()
    (tmp_path / "api" / "do.py").write_text(
        cleandoc('''
        def other():
            """x

            Returns
            -------
            Result
                Other.

                None of it.
            """

        def do():
            """Do.

            Parameters
            ----------
            a
                A.

            Returns
            -------
            Result
                Its tables.

                A ``row`` is
                one.

                Another is two.

            Raises
            ------
            Error
                Never.
            """

        def last():
            """x

            Returns
            -------
            Result
                Other.

                None of it.
            """
        ''')
    )
    assert about_tables("do") == "A row is one.\n\nAnother is two."
    assert about_tables("missing") == ""


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ({}, ""), ({"default": None}, ""), ({"default": 0}, "`0`"), ({"default": True}, "`true`"),
        ({"default": "None|x"}, "`None\\|x`"), ({"default": []}, "`[]`"), ({"default": ""}, "``"),
        ({"default": "True"}, "`True`"),
    ],
)  # fmt: skip
def test_a_default_as_code(entry, told):
    assert reference._default(entry) == told


def test_the_keys_of_a_section_are_those_of_each_form():
    defs = {
        "A": {"properties": {"kind": {"const": "a"}, "x": {}}},
        "B": {"properties": {"kind": {"const": "b"}, "y": {}}},
        "C": {"properties": {"z": {"default": 1}}},
    }
    a = ("kind: a", {"kind": {"const": "a"}, "x": {}})
    b = ("kind: b", {"kind": {"const": "b"}, "y": {}})
    c = ("", {"z": {"default": 1}})

    def sections(value):
        return [*reference._sections(value, defs)]

    ref_a, ref_b, ref_c = ({"$ref": f"#/$defs/{name}"} for name in "ABC")
    assert sections({"oneOf": [ref_a, ref_b]}) == [a, b]
    assert sections({"anyOf": [ref_c, {"type": "null"}]}) == [c]
    assert sections({"allOf": [ref_c, {"title": "x"}], "default": {}}) == sections(ref_c) == [c]
    assert sections({"type": "number"}) == []


def test_lines_of_a_docstring_in_markdown():
    text = "a.csv   what *it* is\n        and more\nb.csv   two\nWords about run.rpm.\n\nLast."
    assert [*reference._listed(text)] == [
        "- `a.csv` what \\*it\\* is and more", "- `b.csv` two", "", "Words about `run.rpm`.", "",
        "", "Last.", "",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("--rpm and --dry-run, a.csv", "`--rpm` and `--dry-run`, `a.csv`"),
        ("run.rpm, theta_deg (q_m)", "`run.rpm`, `theta_deg` (`q_m`)"),
        ("e.g. x.y, a.txt 3*4", "e.g. x.y, a.txt 3\\*4"),
        ("`a_b` as it is", "`a_b` as it is"),
    ],
)
def test_names_in_a_text_are_set_as_code(text, plain):
    assert reference._plain(text) == plain


def test_cells_and_pages():
    assert reference._cell("a|b\nc") == "a\\|b c"
    assert reference._page(["", "# a", "", "", "", "b", ""]) == "# a\n\nb\n"


def test_the_tables_of_a_command_with_their_columns(monkeypatch):
    """Each table once, with what it is; a column may be there in some runs only."""
    columns = [
        Made(table="a", column="x_m", unit="m", when="", meaning="of a|b"),
        Made(table="a", column="n", unit="", when="--all", meaning="how many"),
        Made(table="b", column="y", unit="N*m", when="", meaning="a force"),
    ]
    monkeypatch.setattr(reference, "columns_of", lambda command: columns)
    tables = [Made(name="a", words="rows of x_m"), Made(name="b", words="others")]
    head = ["| column | unit | |", "|---|---|---|"]
    assert [*reference.table_lines(Made(tables=tables))] == [
        "", "## Tables", "", reference.EMPTY, "", "### `a.csv`", "", "rows of `x_m`", "", *head,
        "| `x_m` | m | of a\\|b |", "| `n` |  | `--all`: how many |", "", "### `b.csv`", "",
        "others", "", *head, "| `y` | N\\*m | a force |",
    ]  # fmt: skip
    monkeypatch.setattr(reference, "columns_of", lambda command: columns[2:])
    assert [*reference.table_lines(Made(tables=tables[1:]))][:6] == [
        "", "## Tables", "", reference.EMPTY, "", "### `b.csv`"
    ]  # fmt: skip
    monkeypatch.setattr(reference, "columns_of", lambda command: [])
    assert [*reference.table_lines(Made(tables=[]))] == []


def test_the_page_of_a_scene(monkeypatch):
    schema = {
        "properties": {
            "cam": {"description": "The cam.", "oneOf": [{"$ref": "#/$defs/A"}]},
            "run": {"$ref": "#/$defs/B"},
        },
        "$defs": {
            "A": {"properties": {"kind": {"const": "a", "description": "its kind"}}},
            "B": {
                "properties": {
                    "rpm": {"default": 7, "description": "speed|rpm"},
                    "n": {"default": None},
                }
            },
        },
    }
    monkeypatch.setattr(reference, "json_schema", lambda: schema)
    page = reference.scene_page()
    head = "| key | meaning | default |\n|---|---|---|\n"
    assert page.endswith(
        f"\n\n## cam\n\nThe cam.\n\n### kind: a\n\n{head}| `cam.kind` | its kind |  |\n\n"
        f"## run\n\n{head}| `run.rpm` | speed\\|rpm | `7` |\n| `run.n` |  |  |\n"
    )
    assert page.startswith("# The scene\n\nA scene is a YAML file.")


def test_statuses_and_exit_codes_have_a_row_each():
    """Of the statuses those that stand in a table."""
    rows = [line for line in reference.status_page().splitlines() if line.startswith("| `")]
    lost, budget = Status.NO_RETURN, Status.WORK_BUDGET
    assert [row.split("`")[1] for row in rows] == [
        "ok", "impact-budget", "no-return", "unresolved", "work-budget", "fault"
    ]  # fmt: skip
    assert rows[0] == "| `ok` | all is well |  |"
    assert rows[2] == f"| `no-return` | {CAUSES[lost]} | {CURES[lost]} |"
    assert rows[4] == f"| `work-budget` | {CAUSES[budget]} | {CURES[budget]} |"
    codes = "".join(f"| {code} | {MEANING[code]} |\n" for code in (0, 1, 2, 3, 130))
    assert reference.exit_page() == (
        f"# Exit codes\n\n| code | meaning |\n|---|---|\n{codes}\n{reference.CHECKER_CODES}\n"
    )


def test_the_page_of_a_command_has_its_options_tables_and_the_rest(monkeypatch):
    """Of a command without tables of its own there are none; an option without help is left out."""

    def do():
        pass

    do.__doc__ = DOCSTRING
    records = [("--it A|B", "how\nmuch"), None, ("-x", "")]
    parameters = [Made(get_help_record=lambda context, record=record: record) for record in records]
    command = Made(context_class=lambda command, info_name: info_name,
                   get_params=lambda context: parameters if context == "do" else [])  # fmt: skip
    monkeypatch.setattr(
        reference, "import_module", lambda name: Made(do=do) if name.endswith("cli.do") else None
    )
    monkeypatch.setattr("typer.main.get_command", lambda made: Made(commands={made: command}))
    monkeypatch.setattr("camcli.cli.app.application", lambda name: name)
    monkeypatch.setattr(reference, "find_spec", lambda name: name if name == has_tables else None)
    monkeypatch.setattr(reference, "command_of", lambda name: name)
    monkeypatch.setattr(reference, "table_lines", lambda name: ["", f"tables of {name}"])
    monkeypatch.setattr(reference, "about_tables", lambda name: f"About {name}.")
    has_tables = "camcli.api.do"
    head = (
        "# cam do\n\nDo it.\n\n```text\ncam do --it                              done\n"
        "  indented\n```\n\n## Options\n\n| option | |\n|---|---|\n| `--it A\\|B` | how much |\n"
        "| `-x` |  |\n"
    )
    rest = "\n## More\n\n- `a.csv` what it is\n\nMore of it.\n\nLast: words.\n"
    assert reference.command_page("do") == f"{head}\ntables of do\n\nAbout do.\n{rest}"
    has_tables = "none"
    monkeypatch.setattr(reference, "about_tables", lambda name: "")
    assert reference.command_page("do") == f"{head}{rest}"
    do.__doc__ = "Do it.\n\nExamples:\n  a\n  b\n  c\n  d\n"
    monkeypatch.setattr(reference, "about_tables", lambda name: "About.")
    page = reference.command_page("do")
    assert "```text\na\nb\nc\nd\n```" in page
    assert page.endswith("| `-x` |  |\n\nAbout.\n")


def test_a_page_as_a_notebook(monkeypatch, tmp_path):
    """Words and blocks of Python in their order; blocks of other languages are left out."""
    (tmp_path / "how-to").mkdir()
    text = "# A\n\nwords\n\n```python\n\na = 1\n\nb\n```\n```sh\nls\n```\n\n"
    text += "more\n```python\nc\n```\nend\n"
    (tmp_path / "how-to" / "notebook.md").write_text(text)
    monkeypatch.setattr(reference, "FOLDER", tmp_path)
    made = json.loads(reference.notebook())
    assert [(cell["cell_type"], cell["source"], cell["id"]) for cell in made["cells"]] == [
        ("markdown", "# A\n\nwords", "cell-0"), ("code", "\na = 1\n\nb", "cell-1"),
        ("markdown", "more", "cell-2"), ("code", "c", "cell-3"), ("markdown", "end", "cell-4"),
    ]  # fmt: skip
    assert made["cells"][1]["outputs"] == []
    assert (made["nbformat"], made["metadata"]["kernelspec"]["name"]) == (4, "python3")
