"""CSV text of `cam bench`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import astuple
from math import isnan
from typing import Any

from camcli.output.tables import header, mixed_rows


def rows_csv(columns: Sequence[str], rows: Sequence[Any]) -> Iterator[str]:
    """A table whose columns are the first fields of dataclasses; what is unknown is empty."""
    yield header(columns)
    yield from mixed_rows([_cell(value) for value in astuple(r)[: len(columns)]] for r in rows)


def _cell(value: Any) -> Any:
    """Text that needs no quotes, a number, or nothing."""
    if isinstance(value, str):
        return " ".join(value.replace(",", ";").replace('"', "'").split())
    return "" if value is None or (isinstance(value, float) and isnan(value)) else value
