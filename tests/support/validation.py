"""Write the guide's page of validation from the rows of `cam bench validation`.

python tests/support/validation.py
"""

from __future__ import annotations

from pathlib import Path

from camcli.analysis.bench.validation import FORMULA, MISPRINT, ValidationRow
from camcli.api import validation

PAGE = Path(__file__).parents[2] / "camcli" / "guide" / "explanation" / "validation.md"
BEGIN, END = "<!-- rows -->\n", "<!-- end of rows -->\n"


def digits(row: ValidationRow) -> str:
    """Ours, with two digits more than published, as far as a double has them."""
    places = sum(sign.isdigit() for sign in row.published.lstrip("-0."))
    return f"{row.ours:.{min(16, places + 2)}g}"


def line(row: ValidationRow) -> str:
    """A row of the page's tables."""
    remark = ""
    if row.status == MISPRINT:
        remark = f"exact: {row.independent}"
    elif row.digits == FORMULA:
        remark = "formula"
    cells = (
        row.quantity, row.place, row.published, digits(row), f"{row.difference:.1e}",
        f"{row.bound:.1e}", remark,
    )  # fmt: skip
    return f"| {' | '.join(cells)} |\n"


def table(problem: validation.Problem) -> str:
    """The table of a problem, its source above it."""
    text = f"\n**`configs/validation/{problem.scene}.yaml`**: {problem.source}.\n\n"
    text += "| quantity | place | published | ours | difference | bound | |\n"
    text += "|---|---|---|---|---|---|---|\n"
    return text + "".join(map(line, validation.measure(problem)))


def page() -> str:
    """The page as it should be: its words as they are, its tables anew."""
    head, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    tables = "".join(map(table, validation.PROBLEMS.values()))
    return f"{head}{BEGIN}{tables}\n{END}{rest.partition(END)[2]}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
