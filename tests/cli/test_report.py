"""A table that is printed without rich is the one that rich prints."""

import re
import sys
from io import StringIO
from random import Random

import pytest

from camcli import load_scene, orbits
from camcli.cli.report import FILE_WIDTH, RICH_SETTINGS, progress_bar, table

LETTERS = "abcdefghijkl (;:)/%.,-+0123456789P"


def printed(capsys, *args, **options) -> str:
    table(*args, **options)
    return capsys.readouterr().out


def some_table(random: Random) -> tuple[str, list[str], list[list[str]]]:
    """Title, heads and rows; most fit a file's width, some are wider or have other letters."""

    def text(most: int) -> str:
        said = "".join(random.choices(LETTERS, k=random.randint(0, most))).strip()
        return said + random.choice([""] * 30 + ["×", "…", "[m]"])

    columns = random.randint(1, 7)
    heads = [text(12) or "head" for _ in range(columns)]
    rows = [[text(random.choice([8, 14, 40])) for _ in heads] for _ in range(random.randint(0, 5))]
    return text(60) or "title", heads, rows


def test_a_table_in_a_file_is_the_same_with_and_without_rich(capsys, monkeypatch):
    for name in RICH_SETTINGS:
        monkeypatch.delenv(name, raising=False)
    random = Random(1)
    for _ in range(150):
        title, heads, rows = some_table(random)
        hidden = random.randint(0, len(heads) - 1)
        plain = printed(capsys, title, heads, rows, hidden=hidden)
        with monkeypatch.context() as patch:
            patch.setenv("COLUMNS", str(FILE_WIDTH))
            assert printed(capsys, title, heads, rows, hidden=hidden) == plain


@pytest.mark.parametrize("name", sorted(RICH_SETTINGS))
def test_rich_is_imported_where_a_look_is_asked_for(capsys, monkeypatch, name):
    for other in RICH_SETTINGS:
        monkeypatch.delenv(other, raising=False)
    monkeypatch.setitem(sys.modules, "rich", None)
    assert printed(capsys, "two", ["a", "b"], [["1", "22"], ["", "3"]]) == (
        "\ntwo\na   b\n─────\n1  22\n-   3\n"
    )
    monkeypatch.setenv(name, "80")
    with pytest.raises(ImportError):
        table("two", ["a", "b"], [["1", "2"]])


class Screen(StringIO):
    """A stderr that a person watches."""

    def isatty(self):
        return True


def test_no_time_is_left_of_a_budget(monkeypatch):
    """Of eight minutes of work that were allowed a run may need seconds."""
    monkeypatch.setattr("sys.stderr", screen := Screen())
    monkeypatch.setenv("TERM", "xterm")
    scene = load_scene(None, {"orbits.rpm": {"start": 699.0, "stop": 701.0, "num": 2}})
    with progress_bar(quiet=False) as show:
        orbits(scene, progress=show)
        show("of run.work_budget", 30, 1000)
    lines = re.sub(r"\x1b\[[0-9;?]*\w", "", screen.getvalue()).splitlines()
    budget = [line for line in lines if "run.work_budget" in line]
    assert budget[-1].startswith("at work, 3 % of run.work_budget")
    assert not any(re.search(r"\d:\d\d", line) for line in budget)
    assert any(re.search(r"^branches .* \d+% ", line) for line in lines)


def test_each_thing_that_is_counted_has_a_bar(monkeypatch):
    """Of a budget it tells the share that is spent; nobody but a person sees any."""
    done: list = []

    class Bars:
        def __init__(self, console, transient):
            assert (console.stderr, transient) == (True, True)

        def __enter__(self):
            return self

        def __exit__(self, *failure):
            done.append("end")

        def add_task(self, words, total):
            done.append((words, total))
            return len(done)

        def update(self, task, description, completed, total):
            done.append((task, description, completed, total))

    monkeypatch.setattr("rich.progress.Progress", Bars)
    monkeypatch.setattr("sys.stderr", Screen())
    with progress_bar(quiet=False) as show:
        show("speeds", 1, 4)
        show("of run.work_budget", 30, 1000)
        show("speeds", 2, 5)
        show("of run.work_budget", 260, 1000)
    budget = "at work, {} % of run.work_budget"
    assert done == [
        ("speeds", 4), (1, "speeds", 1, 4),
        (budget.format(3), None), (3, budget.format(3), 30, None),
        (1, "speeds", 2, 5), (3, budget.format(26), 260, None), "end",
    ]  # fmt: skip
    with progress_bar(quiet=True) as show:
        assert show is None
    monkeypatch.setattr("sys.stderr", StringIO())
    with progress_bar(quiet=False) as show:
        assert show is None
