"""Which tolerance explains how much of the spread of speeds: by machines that are made by hand."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace as Made

import pytest

from camcli.api.tolerances import _shares, _summary

CORNERS = [list(corner) for corner in product((-1.0, 1.0), repeat=2)] * 3  # 12 machines


def test_shares_are_those_of_the_squares_of_what_each_number_changes():
    """3 and 4 rpm for a deviation of each: 9 and 16 of 25, whatever its unit and its middle."""
    speeds = [700.0 + 3.0 * a - 4.0 * b for a, b in CORNERS]
    assert _shares(["a", "b"], CORNERS, speeds) == pytest.approx({"a": 0.36, "b": 0.64})
    scaled = [[5.0 + 1e-3 * a, 1e6 * b] for a, b in CORNERS]
    assert _shares(["a", "b"], scaled, speeds) == pytest.approx({"a": 0.36, "b": 0.64})


def test_what_straight_lines_leave_is_a_share_of_neither():
    """ab is uncorrelated with a and with b: of 9 + 16 + 25 it is a half."""
    speeds = [700.0 + 3.0 * a - 4.0 * b + 5.0 * a * b for a, b in CORNERS]
    assert _shares(["a", "b"], CORNERS, speeds) == pytest.approx({"a": 0.18, "b": 0.32})


@pytest.mark.parametrize(
    ("machines", "numbers", "told"),
    [(9, 2, False), (10, 2, True), (10, 5, True), (11, 6, False), (12, 6, True)],
)
def test_ten_machines_are_enough_or_two_for_each_number(machines, numbers, told):
    keys = [f"k{n}" for n in range(numbers)]
    made = [[float((3 * k + 7 * n * k) % 11) for n in range(numbers)] for k in range(machines)]
    assert bool(_shares(keys, made, [700.0 + row[0] for row in made])) is told


def test_no_share_where_the_speeds_do_not_vary_or_contact_is_never_lost():
    assert _shares(["a", "b"], CORNERS, [700.0] * 12) == {}
    assert _shares(["a", "b"], CORNERS, [*[700.0] * 11, float("inf")]) == {}


def test_chance_and_worst_case_are_those_of_the_machines_that_are_known():
    """Two corners first, which count for the worst case alone; a row with a gap counts for none."""
    springs = [Made(quantity="stiffness"), Made(quantity="preload")]
    section = Made(machines=7, hold_to=300.0)
    rows = [
        (180.0, 250.0, 299.0), (260.0, 330.0, 320.0),  # corners
        (200.0, 300.0, 310.0), (None, 10.0, 10.0), (220.0, 299.9, 300.0), (10.0, None, 10.0),
        (210.0, 310.0, 320.0), (250.0, 305.0, 299.9), (230.0, 400.0, 400.0),
    ]  # fmt: skip
    assert _summary(rows, 2, springs, section) == {
        "machines": 7, "worst_rpm": 180.0, "median_rpm": 220.0,
        "springs": {"stiffness": {"worst_rpm": 250.0, "chance": 0.8},
                    "preload": {"worst_rpm": 299.0, "chance": 0.8}},
    }  # fmt: skip
    assert _summary([*rows[:2], rows[3], rows[5]], 2, springs, section) is None
