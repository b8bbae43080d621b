"""What every run says: its tables, where its files are, what it cost and how exact it is."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from textwrap import fill
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camcli.api.result import Progress

Row = Sequence[str]
FILE_WIDTH = 140  # columns of a table that no person watches
SHOWN = 40  # rows of one that may be long
GAP = 2  # between columns
LEAST_CUT = 8  # characters that stay of a text that is cut: P(1;inf)
UNITS = "rpm|N|N/mm|N/m|mm|um|m|m/s|deg|%|Hz|kg"
RANGE = re.compile(r"-?[\d.]+ to -?[\d.]+")  # two numbers of one cell
NUMBER = re.compile(rf"(?<=\d) (?=(?:{UNITS})(?:[\s.,;:)]|$))")  # between a number and its unit
RICH_SETTINGS = {"COLUMNS", "FORCE_COLOR", "TTY_COMPATIBLE", "JUPYTER_COLUMNS"}  # it reads them
SIMPLE = re.compile(r"[ -Z\^-~]*")  # plain ASCII without brackets, which rich reads as colours
OF_THE_BUDGET = "of run.work_budget"  # what a budget of work is called where it is counted
MORE = "(more: --verbose, or run.json)"


def table(
    title: str,
    columns: Sequence[str],
    rows: Sequence[Row],
    whole: str = "",
    hidden: int = 0,
    cut: str = "",
) -> None:
    """A table for people on stdout, without its last, `hidden` columns; without rows its title.

    whole: the file that has all rows of one that may be long. cut: the column whose texts end in
    dots where the screen is too narrow for all columns.
    """
    if whole and len(rows) > SHOWN:
        title = f"{title}, the first {SHOWN} (all of them in {whole})"
        rows = rows[:SHOWN]
    if _print_wide(title, columns[: len(columns) - hidden], rows):
        return
    from rich import box
    from rich.console import Console
    from rich.table import Table

    width_is_known = Console().is_terminal or os.environ.get("COLUMNS", "").isdecimal()
    console = Console(width=None if width_is_known else FILE_WIDTH, markup=False, emoji=False)
    grid = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    shown_columns = columns[: len(columns) - hidden]
    cut_width = _room_to_cut(shown_columns, rows, cut, console.width)
    for k, column in enumerate(shown_columns):
        cells = [row[k] for row in rows if row[k]]
        has_ranges_only = bool(cells) and all(RANGE.fullmatch(cell) for cell in cells)
        grid.add_column(
            column,
            justify="left" if k == 0 else "right",
            overflow="ellipsis" if column == cut else "fold",
            max_width=cut_width if column == cut else None,
            no_wrap=has_ranges_only,
        )
    for row in rows:
        grid.add_row(*(cell or "-" for cell in row[: len(shown_columns)]))
    console.print(f"\n{title}", style="bold", highlight=False)
    if rows:
        console.print(grid)


def _print_wide(title: str, columns: Sequence[str], rows: Sequence[Row]) -> bool:
    """Print a table that needs neither colours nor broken lines, as rich does; False for others.

    Importing rich takes 18 ms, and most tables are read by a program or from a file.
    """
    encoding = (sys.stdout.encoding or "").lower()
    if sys.stdout.isatty() or RICH_SETTINGS & set(os.environ) or encoding not in ("utf-8", "utf8"):
        return False
    cells_of_rows = [[cell or "-" for cell in row[: len(columns)]] for row in rows]
    lines = [list(columns), *cells_of_rows]
    if not all(SIMPLE.fullmatch(text) for text in (title, *chain(*lines))):
        return False
    widths = [max(len(cell) for cell in column) for column in zip(*lines, strict=True)]
    total_width = sum(widths) + GAP * (len(widths) - 1)
    if max(total_width, len(title)) > FILE_WIDTH:
        return False
    print(f"\n{title}")
    if not rows:
        return True
    for k, line in enumerate(lines):
        cells = [line[0].ljust(widths[0])]
        for cell, width in zip(line[1:], widths[1:], strict=True):
            cells.append(cell.rjust(width))
        print((" " * GAP).join(cells))
        if k == 0:  # below the heads
            print("\N{BOX DRAWINGS LIGHT HORIZONTAL}" * total_width)
    return True


def _room_to_cut(columns: Sequence[str], rows: Sequence[Row], cut: str, width: int) -> int | None:
    """The characters that the other columns leave to the one that is cut, at least LEAST_CUT.

    width: of the screen, in characters. None where no column of this name is shown.
    """
    if cut not in columns:
        return None
    others = 0
    for k, column in enumerate(columns):
        if column != cut:
            others += GAP + max(len(cell) for cell in (column, *(row[k] for row in rows)))
    return max(LEAST_CUT, width - others)


def say(text: str, mark: str = "") -> None:
    """Print a sentence; on a terminal its lines are broken between words, indented by the mark."""
    if not sys.stdout.isatty():
        print(f"{mark}{text}")
        return
    from rich.console import Console

    together = NUMBER.sub("\N{NO-BREAK SPACE}", text)  # no line ends between number and unit
    lines = fill(
        together,
        Console().width,
        initial_indent=mark,
        subsequent_indent=" " * (len(mark) or 2),
        break_long_words=False,
        break_on_hyphens=False,
    )
    print(lines.replace("\N{NO-BREAK SPACE}", " "))


def pair(values: Sequence[complex], digits: int) -> str:
    """Two multipliers, or a complex pair of them."""
    first, second = map(complex, values)
    if first.imag:
        return f"{first.real:.{digits}g} +- {abs(first.imag):.{digits}g} i"
    return f"{first.real:.{digits}g}, {second.real:.{digits}g}"


@contextmanager
def progress_bar(quiet: bool) -> Iterator[Progress | None]:
    """A bar on stderr for each thing that is counted, or None where no person watches.

    A budget is seldom used up: its bar shows how much of it is spent, and no time left.
    """
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress as Bars

    with Bars(console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, Any] = {}

        def show(what: str, done: int, total: int) -> None:
            """Show how many of what is counted are done, on a bar of its own."""
            if what == OF_THE_BUDGET:
                words = f"at work, {100.0 * done / total:.0f} % {what}"
                end_of_bar = None
            else:
                words = what
                end_of_bar = total
            if what not in tasks:
                tasks[what] = bars.add_task(words, total=end_of_bar)
            bars.update(tasks[what], description=words, completed=done, total=end_of_bar)

        yield show
