"""What a person sees who watches a terminal: lines broken between words, and nothing swallowed."""

from __future__ import annotations

import re
from io import StringIO
from types import SimpleNamespace

import pytest

from camcli.cli import guide
from camcli.cli.exit_codes import note
from camcli.cli.report import say, table

CELLS = [["[red]fold", "[/]"], ["a :b: c", "[1, 2]"], ["\\[x]", ""]]


class Screen(StringIO):
    """A stream that a person watches."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.fixture
def screen(monkeypatch):
    """What a terminal of a width shows, without colours."""

    def of(columns, show):
        found = Screen()
        with monkeypatch.context() as patch:
            patch.setattr("sys.stdout", found)
            patch.setattr("sys.stderr", found)
            patch.setenv("TERM", "xterm")
            patch.setenv("COLUMNS", str(columns))
            show()
        plain = re.sub(r"\x1b\[[0-9;]*m", "", found.getvalue())
        return [line.rstrip() for line in plain.splitlines()]

    return of


def test_a_note_is_broken_between_words_and_a_long_name_stays_whole(screen):
    text = "note: it-is-in/a-folder-whose-name-is-long/scene.yaml now, so read it\nsecond line"
    assert screen(24, lambda: note(text)) == [
        "note:",
        "  it-is-in/a-folder-whose-name-is-long/scene.yaml",
        "  now, so read it",
        "second line",
    ]


@pytest.mark.parametrize(
    ("mark", "width", "lines"),
    [
        ("", 24,
         ["the spring has", "  12.5 N/mm, holds to", "  4000 rpm, so well-made", "  springs do"]),
        ("- ", 21,
         ["- the spring has", "  12.5 N/mm, holds to", "  4000 rpm, so", "  well-made springs",
          "  do"]),
        ("10. ", 24,
         ["10. the spring has", "    12.5 N/mm, holds to", "    4000 rpm, so",
          "    well-made springs do"]),
    ],
)  # fmt: skip
def test_a_sentence_keeps_numbers_by_their_units(screen, mark, width, lines):
    text = "the spring has 12.5 N/mm, holds to 4000 rpm, so well-made springs do"
    assert screen(width, lambda: say(text, mark)) == lines


def test_a_sentence_in_a_file_is_one_line(capsys):
    text = "the spring has 12.5 N/mm and " + 30 * "holds well, "
    say(text, "- ")
    assert capsys.readouterr().out == f"- {text}\n"


def test_brackets_and_colons_are_no_colours_in_a_table(screen):
    """A name of the user's may have them: a figure is called as its file."""
    shown = screen(60, lambda: table("of [bold] and :smile:", ["[b]", "c"], CELLS))
    rows = [f"{first:<9}  {second or '-':>6}" for first, second in [["[b]", "c"], *CELLS]]
    wanted = ["", "of [bold] and :smile:", *rows]
    assert [line for line in shown if "─" not in line and "━" not in line] == wanted


@pytest.mark.parametrize(
    ("columns", "label"),
    [(33, "P(4;3:3:3:2:3:3:3:2:3)"), (32, "P(4;3:3:3:2:3:3:3:2:…"), (19, "P(4;3:3…")],
)
def test_a_label_is_cut_where_the_screen_has_no_room(screen, columns, label):
    """The numbers take 9 columns, the gap 2."""
    row = ["P(4;3:3:3:2:3:3:3:2:3)", "123456789"]
    shown = screen(columns, lambda: table("labels", ["label", "rpm"], [row], cut="label"))
    assert next(line for line in shown if line.startswith("P(")).split()[0] == label


def test_the_other_columns_stay_whole_beside_a_label_that_is_cut(screen):
    """Of 42 columns they take 31 and the gap 2: nine letters are left."""
    other = "abc def ghi jkl mno pqr stu vwx"
    row = ["P(4;3:3:3:2:3:3:3:2:3)", other]
    shown = screen(42, lambda: table("labels", ["label", "what"], [row], cut="label"))
    assert shown[-1] == f"P(4;3:3:…  {other}"
    assert screen(42, lambda: table("none", ["label", "what"], [], cut="label")) == ["", "none"]


def test_a_range_of_numbers_is_not_broken_where_words_are(screen):
    """All of them take 36 columns; an empty cell is no other word."""
    rows = [["P(1;1)", "abc def ghi", "500.5 to 600.25"], ["P(2;2)", "abc", ""]]
    shown = screen(30, lambda: table("labels", ["label", "words", "range"], rows))
    assert any(line.endswith("500.5 to 600.25") for line in shown)
    assert not any("abc def ghi" in line for line in shown)
    rows[1][2] = "never"
    shown = screen(30, lambda: table("labels", ["label", "words", "range"], rows))
    assert not any("500.5 to 600.25" in line for line in shown)


@pytest.mark.parametrize(
    ("rows", "of_more"), [(40, ""), (41, ", the first 40 (all of them in a.csv)")]
)
def test_a_long_table_is_shown_in_part(capsys, rows, of_more):
    table("numbers", ["n"], [[str(n)] for n in range(rows)], "a.csv")
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert lines[1] == f"numbers{of_more}"
    assert lines[4:] == [str(n) for n in range(40)]


@pytest.mark.parametrize(
    ("out", "into", "paged"),
    [(False, False, False), (True, False, False), (False, True, False), (True, True, True)],
)
def test_a_page_of_the_guide_is_paged_where_a_person_can_press_a_key(
    capsys, monkeypatch, out, into, paged
):
    """Where either side is a file or another program, a pager would wait for ever."""
    pages: list[str] = []
    monkeypatch.setattr("sys.stdout.isatty", lambda: out)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: into))
    monkeypatch.setattr("rich.pager.SystemPager.show", lambda self, text: pages.append(text))
    guide._show("# Head\n\nSome *words*.\n")
    said = capsys.readouterr().out
    assert (said == "# Head\n\nSome *words*.\n") is not paged
    assert len(pages) == paged
    assert not paged or "*words*" not in pages[0]
