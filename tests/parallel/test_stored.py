"""What is read back from a file of pieces: a check takes what was stored, and nothing else."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest

from camcli.parallel import stored

TWO = {"n": stored.whole, "x": stored.optional(stored.real)}
CHECKS = [  # check, what it takes, what it refuses
    (stored.real, [0, -2.5, 1e308, 2**70], [inf, -inf, nan, True, "1", None, [1.0]]),
    (stored.extended, [0, -2.5, inf, -inf], [nan, False, "inf", None]),
    (stored.whole, [0, 7, 2**62 - 1], [-1, 2**62, 1.0, True, "3", None]),
    (stored.flag, [True, False], [0, 1, None, "true"]),
    (stored.text, ["", "a b", "ü" * 200], ["x" * 201, "a\nb", "\x1b[1m", 3, None]),
    (stored.optional(stored.whole), [None, 3], [-3, "", 3.0]),
    (stored.one_of("fixed", 2), ["fixed", 2], ["up", 2.0, 3, None, True]),
    (stored.one_of(0, 1), [0, 1], [True, False, 1.0, 0.0, "1"]),
    (stored.items(stored.whole), [[], [1, 2, 3]], [(1, 2), "12", [1, -1], None]),
    (stored.items(stored.whole, 2), [[1, 2]], [[], [1], [1, 2, 3]]),
    (lambda value: stored.fields(value, TWO), [{"n": 1, "x": None}, {"x": 0.5, "n": 0}],
     [{"n": 1}, {"n": 1, "x": 1.0, "y": 2}, {"n": -1, "x": 1.0}, [("n", 1), ("x", 1.0)]]),
]  # fmt: skip


@pytest.mark.parametrize("row", CHECKS, ids=range(len(CHECKS)))
def test_a_check_takes_its_values_and_no_others(row):
    check, taken, refused = row
    for value in taken:
        same = check(value)
        assert same == value
        assert type(same) is type(value)
    for value in refused:
        with pytest.raises(ValueError, match=r"found|expected"):
            check(value)


def test_columns_are_of_one_length_and_finite():
    check = stored.columns(1, 2)
    for wholes, reals in (
        ([[1, 2]], [[0.5, -1.0], [3.0, 4.0]]),
        ([[2**60]], [[1e300], [-1e300]]),
        (np.empty((1, 0), int), np.empty((2, 0))),
    ):
        taken = check([wholes, reals])
        assert [column.tolist() for column in taken] == [*map(list, wholes), *map(list, reals)]
    good = [[0.5, 1.0], [2.0, 3.0]]
    for refused in ([[[1, 2]]], [[[1, 2]], good, good], [[[1]], good], [[[1, 2], [3, 4]], good],
                    [[[1, 2]], good[:1]], [[[1.0, 2.0]], good], [[[1, 2]], [[1, inf], [1, 2]]],
                    [[[1]], [[nan], [0.0]]], [[[1, 2]], [[1e300, -inf], [1, 2]]],
                    [[[1]], [["a"], ["b"]]], [[1, 2], good], ([[1, 2]], good), None):  # fmt: skip
        with pytest.raises(ValueError, match="expected"):
            check(refused)


def test_an_array_is_so_wide_and_of_its_kind():
    taken = np.array([[1, 2, 3], [4, 5, 6]])
    assert stored.table(taken, 3, "i").tolist() == taken.tolist()
    assert stored.table(taken + 0.5, 3, "if").shape == (2, 3)
    for value, wide, kinds in (
        (taken, 2, "i"),
        (taken, 3, "f"),
        (taken[0], 3, "i"),
        (taken[None], 3, "i"),
        (np.full((2, 3), inf), 3, "f"),
        ([["a"]], 1, "U"),
    ):
        with pytest.raises(ValueError, match="expected"):
            stored.table(value, wide, kinds)


def test_a_fault_names_the_field():
    with pytest.raises(ValueError, match=r"^n: found -1, expected a whole number$"):
        stored.fields({"n": -1, "x": None}, TWO)
