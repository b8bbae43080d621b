"""What a notebook shows of a result: its sentences, a picture, the beginnings of its tables."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from io import BytesIO
from itertools import islice
from typing import TYPE_CHECKING, Any

from camcli.errors import plural

if TYPE_CHECKING:
    from camcli.output.tables import Table

ROWS = 8  # of a table that are shown


def table_html(table: Table, caption: str = "") -> str:
    """The first rows of a table as HTML, and how many there are."""
    columns = {name: table[name] for name in table.columns}
    count = table.rows
    head = "".join(f"<th>{escape(name)}</th>" for name in columns)
    first_rows = islice(zip(*columns.values(), strict=True), ROWS)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in first_rows)
    rows = plural(count, "row")
    title = escape(f"{caption}: {rows}" if caption else rows)
    return (
        f"<table><caption>{title}</caption><thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table>"
    )


def result_html(sentences: Iterable[str], figure: Any, tables: dict[str, Table]) -> str:
    """Sentences, a matplotlib figure (None: none), and each table folded away."""
    parts = [f"<p>{escape(sentence)}</p>" for sentence in sentences]
    if figure is not None:
        file = BytesIO()
        figure.savefig(file, format="png", dpi=110)
        picture = b64encode(file.getvalue()).decode()
        parts.append(f'<img alt="" src="data:image/png;base64,{picture}">')
    for name, table in tables.items():
        summary = f"<summary>{escape(name)}</summary>"
        parts.append(f"<details>{summary}{table_html(table, name)}</details>")
    return "\n".join(parts)


def _cell(value: Any) -> str:
    """A value as a cell of a table in HTML."""
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"<td>{escape(text)}</td>"
