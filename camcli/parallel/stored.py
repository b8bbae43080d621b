"""What is read back from a file of pieces is what was stored: nobody knows who wrote the file.

Each check returns the value, in the form the program takes, or raises ValueError.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

import numpy as np

from camcli.errors import plural

MOST_INT = 2**62


def real(value: Any) -> float:
    """A finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        raise ValueError(f"found {value!r:.40}, expected a finite number")
    return value


def extended(value: Any) -> float:
    """A number that may be infinite."""
    if isinstance(value, bool) or not isinstance(value, int | float) or value != value:
        raise ValueError(f"found {value!r:.40}, expected a number")
    return value


def whole(value: Any) -> int:
    """A whole number that is not negative."""
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < MOST_INT:
        raise ValueError(f"found {value!r:.40}, expected a whole number")
    return value


def flag(value: Any) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise ValueError(f"found {value!r:.40}, expected true or false")
    return value


def text(value: Any) -> str:
    """A text of a few words."""
    if not isinstance(value, str) or len(value) > 200 or not value.isprintable():
        raise ValueError(f"found {value!r:.40}, expected a text")
    return value


def optional(check: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A check that takes what `check` takes, or None."""
    return lambda value: None if value is None else check(value)


def one_of(*known: Any) -> Callable[[Any], Any]:
    """A check that takes one of the values known, of the same type: True is not 1."""

    def check(value: Any) -> Any:
        """The value, if it is one of those known, of the same type; else ValueError."""
        if not any(value == one and type(value) is type(one) for one in known):
            raise ValueError(f"found {value!r:.40}, expected one of {len(known)} values")
        return value

    return check


def items(check: Callable[[Any], Any], count: int | None = None) -> Callable[[Any], list]:
    """A check that takes a list of what `check` takes; count: its length, where that is known."""

    def check_all(value: Any) -> list:
        """The list with each entry checked; ValueError where it is none, or of another length."""
        if not isinstance(value, list) or count not in (None, len(value)):
            raise ValueError(f"expected a list of {'values' if count is None else count}")
        return [check(one) for one in value]

    return check_all


def fields(value: Any, checks: Mapping[str, Callable[[Any], Any]]) -> dict[str, Any]:
    """A dict of just these names, each checked."""
    if not isinstance(value, dict) or value.keys() != checks.keys():
        raise ValueError(f"expected {', '.join(checks)}")
    checked = {}
    for name, check in checks.items():
        try:
            checked[name] = check(value[name])
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    return checked


def columns(wholes: int, reals: int) -> Callable[[Any], tuple]:
    """A check that takes two arrays: so many columns of whole numbers, and so many of finite ones.

    Each column is a row of its array, and all are of equal length. An array takes the place of its
    columns since a file is written and read by a step for each array.
    """

    def check(value: Any) -> tuple:
        """The columns, whole numbers first; ValueError where they are not as many, or no such."""
        if not isinstance(value, list) or len(value) != 2:
            raise ValueError("expected an array of whole numbers and one of others")
        counts, numbers = np.asarray(value[0]), np.asarray(value[1])
        if counts.ndim != 2 or numbers.ndim != 2 or (len(counts), len(numbers)) != (wholes, reals):
            wanted = plural(wholes, "column")
            raise ValueError(f"expected {wanted} of whole numbers and {reals} of others")
        if counts.shape[1] != numbers.shape[1]:
            raise ValueError("expected columns of equal length")
        if counts.dtype.kind != "i" or not _numeric(numbers):
            raise ValueError("expected columns of finite numbers")
        return (*counts, *numbers)

    return check


def table(value: Any, wide: int, kinds: str) -> Any:
    """An array of so many columns of finite numbers; kinds: of them, numpy's letters, as `fi`."""
    array = np.asarray(value)
    if array.ndim != 2 or array.shape[1] != wide or array.dtype.kind not in kinds:
        raise ValueError(f"expected an array of {plural(wide, 'column')}")
    if not _numeric(array):
        raise ValueError("expected finite numbers")
    return array


def _numeric(array: Any) -> bool:
    """Whether an array holds finite numbers, or nothing."""
    if array.size == 0 or array.dtype.kind in "iu":
        return True
    if array.dtype.kind != "f":
        return False
    # A finite sum of squares has finite terms only, and is quick. It may be infinite or NaN because
    # it overflows: then each number is looked at.
    sum_of_squares = np.vdot(array, array)
    return isfinite(sum_of_squares) or bool(np.isfinite(array).all())
