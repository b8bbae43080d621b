"""From the text of a lift table to its rows on the turn, on texts and rows made by hand."""

from __future__ import annotations

from decimal import Decimal
from types import SimpleNamespace

import numpy as np
import pytest

from camcli.cams import lift_reading as reading
from camcli.cams.lift_reading import Cell, TurnRow, splitter
from camcli.errors import Fault, SceneError

INCH = 0.0254


def cam_of(**changes) -> SimpleNamespace:
    """What a scene says of a table whose columns are numbered."""
    usual = {
        "header": 1, "skip_lines": 0, "decimal": "point", "angle_column": 1, "lift_column": 2,
        "angle": "cam", "lift": "mm", "subtract": 0.0, "metres": 1e-3, "mirrored": False,
        "zero_deg": 0.0, "direction": "same",
    }  # fmt: skip
    return SimpleNamespace(**{**usual, **changes})


def cells_of(text: str, **changes) -> list[tuple]:
    """(place, angle, lift) of each row of a text."""
    rows = reading._cells(text, "t", cam_of(**changes))
    return [
        (angle.place, str(angle.value), str(lift.value))
        for angle, lift in zip(rows.angle, rows.lift, strict=True)
    ]


def refusal(run, *given, **named) -> list[str]:
    """The faults that a function raises, as text."""
    with pytest.raises(SceneError) as caught:
        run(*given, **named)
    return [str(fault) for fault in caught.value.faults]


def test_lines_are_numbered_as_in_the_file_whatever_is_left_out():
    text = "# a\r\nb #c\rd;e  \n  \nSEP=;\nsep=;;\n  f\n"
    lines = [(2, "b"), (3, "d;e"), (6, "sep=;;"), (7, "  f")]
    assert reading.text_lines(text, "t") == lines
    for skip in (1, 2, 3):
        assert reading.text_lines(text, "t", skip) == [line for line in lines if line[0] > skip]
    assert reading.text_lines("a" * 10_000, "t") == [(1, "a" * 10_000)]
    (fault,) = refusal(reading.text_lines, "b\n" + "a" * 10_001, "t")
    assert fault.startswith("t:2:1: file: found a line of 10001 characters")
    reading.refuse_too_many_rows(7, "t", most=7)
    (fault,) = refusal(reading.refuse_too_many_rows, 8, "t", "file", 7)
    assert fault == "t: file: found 8 rows, expected at most 7, thin the table out"


@pytest.mark.parametrize(
    ("row", "decimal", "quoted", "line", "cells"),
    [
        ("1,5;2\t3", "point", False, "1,5 ; 2\t3", [(1, "1,5"), (7, "2\t3")]),
        ("1,5\t2,3", "point", False, "1,5\t2,3", [(1, "1,5"), (5, "2,3")]),
        ("1,5", "point", False, " 1, 5", [(2, "1"), (5, "5")]),
        ("1,5", "comma", False, "1,5 2,3", [(1, "1,5"), (5, "2,3")]),
        ("1,5", "comma", True, "1,5 2,3", [(1, "1"), (3, "5 2"), (7, "3")]),
        ("1,5 2,25", "point", False, "3,1 4,1", [(1, "3,1"), (5, "4,1")]),
        ("1,5 2,25", "comma", True, "3,1 4,1", [(1, "3,1"), (5, "4,1")]),
        ("1, 2,", "point", False, "1, 2,", [(1, "1"), (4, "2"), (6, "")]),  # no decimal commas
        ("1,5 x", "point", False, "1,5 x", [(1, "1"), (3, "5 x")]),
        ('"a,b" "c"', "point", False, ' "a,b"  c', [(2, "a,b"), (9, "c")]),
        ('"a;b",c', "point", False, '"a,b", " c ",d', [(1, "a,b"), (8, "c"), (14, "d")]),
        ("1  2", "point", False, "  3 4,5", [(3, "3"), (5, "4,5")]),
    ],
)
def test_a_row_is_cut_as_the_first_one_has_to_be(row, decimal, quoted, line, cells):
    assert splitter(row, decimal, quoted)(line) == cells


def test_a_comma_in_quotes_is_one_of_decimals():
    for row, quoted in {
        '1,"2,5"': True, '"a","2,5"': True, '"a","b"': False, "1,2,5": False, '"a,b': False,
    }.items():  # fmt: skip
        assert reading.has_quoted_comma(row) is quoted


@pytest.mark.parametrize(
    ("text", "decimal", "wanted"),
    [
        ("1,5", "comma", "1.5"), ("1.5", "comma", ""), ("1.000,5", "comma", ""),
        ("7", "comma", "7"), ("1,5", "point", ""), ("-.5", "point", "-.5"),
        ("+5.", "point", "+5."), (".", "point", ""),
        ("1e-3", "point", "1e-3"), ("1E+123", "point", "1E+123"), ("1e1234", "point", ""),
        ("1" * 60, "point", "1" * 60), ("1" * 61, "point", ""), ("", "point", ""),
    ],
)  # fmt: skip
def test_a_number_is_one_of_a_file_with_points_or_with_commas(text, decimal, wanted):
    assert reading.number(text, decimal) == wanted


def test_the_columns_of_a_table_with_lines_before_it():
    """Two lines are skipped, two are the header, whose first has the titles."""
    text = "1;2;3\n4;5;6\n deg ; n ;lift\n [-];-;mm\n10;7;2.5\n\n20;8;-1e-1\n"
    wanted = [("t:5:1", "10", "2.5"), ("t:7:1", "20", "-0.1")]
    by_name = {"skip_lines": 2, "header": 2, "angle_column": "deg", "lift_column": " lift "}
    assert cells_of(text, **by_name) == wanted
    assert cells_of(text, **{**by_name, "angle_column": 1, "lift_column": 3}) == wanted
    swapped = cells_of(text, **{**by_name, "angle_column": 3, "lift_column": 2})
    assert swapped == [("t:5:6", "2.5", "7"), ("t:7:6", "-0.1", "8")]
    for key, value in (("angle_column", 4), ("lift_column", 0)):
        (fault,) = refusal(cells_of, text, **{**by_name, key: value})
        assert f"{key}: found column {value}, expected 1 to 3" in fault
    (fault,) = refusal(cells_of, text.replace("lift", "deg"), **{**by_name, "lift_column": 3})
    assert "angle_column: found more than one column 'deg'" in fault


def test_a_header_has_titles_of_which_some_may_be_numbers():
    assert cells_of("deg,2024\n1,2\n") == [("t:2:1", "1", "2")]
    (fault,) = refusal(cells_of, "# a\n1,2\n3,4\n5,6\n", header=2)
    assert fault.startswith("t:2: header: found a header of numbers")
    assert cells_of("1,2\n", header=0) == [("t:1:1", "1", "2")]
    assert cells_of("deg,lift\n") == []
    (fault,) = refusal(cells_of, "deg,lift,x\n#\n1,2\n3,4\n", angle_column=3, lift_column=1)
    assert "found column 3, expected 1 to 2" in fault
    (fault,) = refusal(cells_of, "x,lift,deg\n#\n1,2\n3,4\n", angle_column="deg", lift_column=1)
    assert fault.startswith("t:3: file: found 2 cells in the first row, and 3 titles in the")


def test_decimal_commas_in_quotes_anywhere_make_the_others_separate_cells():
    text = 'a,b\n1,2\n3,"4,5"\n'
    assert cells_of(text, decimal="comma") == [("t:2:1", "1", "2"), ("t:3:1", "3", "4.5")]


@pytest.mark.parametrize(
    ("title", "lift", "refused"),
    [
        ("lift mm", "mm", False), ("lift mm", "um", True), ("lift mm", "fraction", False),
        ("lift mm (in)", "inch", False), ("lift mm (in)", "m", True), ("lift", "um", False),
        ("lift_mm", "um", True), ("thou_mm", "mm", False), ("lift in mils", "inch", True),
    ],
)  # fmt: skip
def test_a_title_may_not_name_another_unit_of_the_lift(title, lift, refused):
    text = f"inch,{title}\n1,2\n"
    if refused:
        (fault,) = refusal(cells_of, text, lift=lift)
        assert fault.startswith(f"t:1: lift: found '{lift}', and a lift in ")
    else:
        assert cells_of(text, lift=lift) == [("t:2:1", "1", "2")]


def test_every_bad_cell_is_counted_and_the_first_of_each_cause_is_told():
    text = "a,b\nx,1\n2,y\n3\n4,5,6\n7,1e10\n8,-1e10\n9,0e5\n10,NAN\n11,-Infinity\n12,+inf\n13,z\n"
    told = [fault.split(", expected")[0] for fault in refusal(cells_of, text)]
    assert told == [
        "t:2:1: file: found 'x'",
        "t:3:3: file: found 'y', and 1 more like it",
        "t:4: file: found 1 cell",
        "t:5: file: found 3 cells",
        "t:6:3: file: found 1e10, and 2 more like it",
        "t:9:4: file: found 'NAN', and 2 more like it",
    ]


@pytest.mark.parametrize(
    ("text", "decimal", "first", "header", "cure"),
    [
        ("x", "point", True, 0, "if this is a header, write header: true"),
        ("x", "point", True, 1, "if the table has 2 header lines, write header: 2"),
        ("x", "point", True, 3, "if the table has 4 header lines, write header: 4"),
        ("x", "point", False, 1, "correct the cell, remove the row, or begin the line with # if"),
        ("1,5", "point", True, 1, "write decimal: comma in the section cam"),
        ("1.5", "comma", True, 1, "write decimal: point in the section cam"),
        ("-INF", "point", True, 1, "remove the row or measure it again"),
        ("1e-41", "point", True, 1, "round it"),
        ("1e-40", "point", True, 1, ""),
        ("1e9", "point", True, 1, ""),
        ("-1000000000.1", "point", True, 1, "is it a number?"),
    ],
)
def test_the_cure_of_a_cell_that_is_no_number(text, decimal, first, header, cure):
    found = reading._cell("t:2:3", 2, text, cam_of(decimal=decimal, header=header), first)
    if cure:
        assert isinstance(found, Fault)
        assert found.where == "t:2:3"
        assert found.cure.startswith(cure)
    else:
        assert found == Cell("t:2:3", 2, text, Decimal(text))


def test_rows_fall_or_rise_and_go_through_zero_in_the_unit_of_the_angle():
    def angles(*written: int, **changes) -> list[int]:
        text = "a,b\n" + "".join(f"{k},{n}\n" for n, k in enumerate(written))
        rows = reading._rows(text, "t", cam_of(**changes))
        turn = 720 if changes else 360
        assert [int(cell.value) % turn for cell in rows.angle] == [
            written[int(cell.value)] % turn for cell in rows.lift
        ]
        return [int(cell.value) for cell in rows.angle]

    assert angles(350, 355, 5, 9, 12) == [350, 355, 5 + 360, 9 + 360, 12 + 360]
    assert angles(9, 5, 355, 350, 345) == [345, 350, 355, 365, 369]
    assert angles(3, 719, 710, 700, angle="crank") == [700, 710, 719, 723]
    assert angles(10, 300, 40, 50, angle="crank") == [10, 300, 40, 50]  # no turn of a crank
    assert angles(2, 1, 2, 3) == [2, 1, 2, 3]


def sizes(lifts: tuple[float, ...], quantum: float) -> list[str]:
    cells = [Cell(f"t:{k}", k, "", Decimal(0)) for k in range(len(lifts))]
    try:
        reading._check_sizes(cells, list(lifts), quantum)
    except SceneError as error:
        return [(fault.where, fault.found) for fault in error.faults]
    return []


@pytest.mark.parametrize(
    ("lifts", "quantum", "told"),
    [
        ((0.0, 1.0, 0.5), 1e-3, []),
        ((0.0, 0.5, 1.1), 1e-3, [("t:2", "a largest lift of 1.1 m, suspiciously large")]),
        ((0.0, 1e-4, 0.0), 1e-6, []),
        ((0.0, 9e-5, 0.0), 1e-6, [("t:1", "a largest lift of 9e-05 m, suspiciously small")]),
        ((0.01, -0.00029, 0.0), 1e-4, []),  # a fiftieth and a last digit
        ((0.01, 0.0, -0.00031), 1e-4, [("t:2", "a lift of -0.31 mm, below the base circle")]),
        ((-0.002, -0.001), 1e-4, [("t:0", "a lift of -2 mm, below the base circle")]),
        ((0.002, 0.0012), 1e-4, []),
        ((0.0012, 0.002), 1.01e-4,
         [("t:1", "lifts that differ by 0.8 mm, a few steps of the last digit")]),
        ((0.0, 0.0), 0.0, [("t:0", "lifts that differ by 0 mm, a few steps of the last digit")]),
    ],
)  # fmt: skip
def test_a_lift_that_no_unit_explains_is_refused_where_it_is(lifts, quantum, told):
    assert sizes(lifts, quantum) == [(where, f"found {found}") for where, found in told]


def bump(k: int, first: int, count: int) -> int:
    """A parabola in last digits over rows from `first`, so many of them."""
    return (k - first + 1) * (first + count - k) if first <= k < first + count else 0


def turn_rows(thetas, first: int, count: int) -> list[TurnRow]:
    """Rows of a turn, in micrometres, of which those from `first` move."""
    return [
        TurnRow(float(theta), 1e-6 * bump(k, first, count), k + 2, bump(k, first, count))
        for k, theta in enumerate(thetas)
    ]


def test_a_table_of_the_lobe_alone_is_completed_by_rows_at_zero():
    """Every 10 deg from 130 to 280; the base circle is what is not more than 3 digits high."""
    table = turn_rows(range(130, 290, 10), 1, 14)
    table[0] = table[0]._replace(lift=-3e-6, steps=-3)
    table[-1] = table[-1]._replace(lift=2e-6, steps=2)
    turn = reading._turn("t", table, 1e-6, 10.0, False, 3.0)
    filled = turn.line == 0
    gap = 210.0  # deg from 280 to 130: 21 spacings
    assert sorted(turn.theta[filled]) == pytest.approx(
        sorted((280.0 + gap * j / 21) % 360.0 for j in range(1, 21))
    )
    assert np.all(turn.lift[filled] == 0.0)
    assert np.all(np.diff(turn.theta) > 0.0)
    assert turn.line[~filled].tolist() == list(range(2, 18))
    assert turn.lift[turn.line == 2] == [-3e-6]
    (dwell,) = turn.dwells
    assert (dwell.start, dwell.end) == (pytest.approx(290.0), pytest.approx(480.0))
    assert (turn.quantum, turn.spacing) == (1e-6, 10.0)
    for where, digits in ((0, -4), (-1, 4)):
        off = list(table)
        off[where] = off[where]._replace(steps=digits)
        (fault,) = refusal(reading._turn, "t", off, 1e-6, 10.0, False, 3.0)
        assert fault.startswith("t:17: angle: the rows of lines 17 and 2 are 210 deg apart")


def test_a_gap_between_equal_rows_of_a_whole_turn_is_filled_at_their_height():
    """Rows every 4 deg, of which those from 40 to 100 deg, low, are left out."""
    thetas = [*range(0, 41, 4), *range(100, 360, 4)]
    table = turn_rows(thetas, 20, 50)
    assert [table[k].theta for k in (10, 11)] == [40.0, 100.0]
    low = [row._replace(lift=2e-6, steps=2) if row.steps == 0 else row for row in table]
    turn = reading._turn("t", low, 1e-6, 4.0, True, 2.0)
    filled = turn.line == 0
    assert turn.theta[filled] == pytest.approx([40.0 + 60.0 * j / 15 for j in range(1, 15)])
    assert np.all(turn.lift[filled] == 2e-6)
    other = list(low)
    other[11] = other[11]._replace(steps=1)
    for rows, base in ((other, 2.0), (low, 1.0)):
        (fault,) = refusal(reading._turn, "t", rows, 1e-6, 4.0, True, base)
        assert fault.startswith("t:12: angle: the rows of lines 12 and 13 are 60 deg apart")


def test_rows_off_the_base_circle_are_at_most_ten_degrees_apart():
    """Where fewer are missing than one and a half spacings, whatever the spacing is, none is."""
    thetas = [*range(0, 180, 4), 186, *range(190, 360, 4)]
    table = turn_rows(thetas, 10, 70)
    assert 0 not in reading._turn("t", table, 1e-6, 4.0, True, 1.0).line
    near = [row._replace(theta=186.5) if row.theta == 186 else row for row in table]
    (fault,) = refusal(reading._turn, "t", near, 1e-6, 4.0, True, 1.0)
    assert "lines 46 and 47 are 10.5 deg apart" in fault
    wide = turn_rows([*range(0, 180, 11), *(k + 5.5 for k in range(187, 350, 11))], 4, 24)
    assert [wide[k].theta for k in (16, 17)] == [176.0, 192.5]
    assert 0 not in reading._turn("t", wide, 1e-6, 11.0, True, 1.0).line
    at_both_ends = turn_rows(range(9, 356, 4), 10, 70)  # 16 deg round the end of the turn
    turn = reading._turn("t", at_both_ends, 1e-6, 4.0, True, 1.0)
    assert turn.theta[turn.line == 0] == pytest.approx([1.0, 5.0, 357.0])


def dwells(steps: list[int], theta: list[float], base: int = 0) -> list[tuple]:
    lifts = [1e-6 * (step + base) for step in steps]
    return [tuple(one) for one in reading._dwells("t", theta, lifts, steps, 1e-9)]


def test_a_dwell_is_five_equal_rows_over_ten_degrees():
    """Rows every 2.5 deg, so five go over ten; one dwell goes through the end of the turn."""
    theta = [2.5 * k + 1.0 for k in range(144)]
    steps = [k + 7 for k in range(144)]
    steps[20:25] = [3] * 5
    steps[40:44] = [4] * 4
    steps[-2:] = steps[:4] = [9] * 2 + [9] * 2
    steps[:4] = [9] * 4
    found = dwells(steps, theta)
    assert found == [(51.0, 61.0, 3e-6), (356.0, pytest.approx(356.0 + 12.5), 9e-6)]
    theta[24] = 60.9  # it goes over less than ten
    assert [one[2] for one in dwells(steps, theta)] == [9e-6]
    theta[24], theta[43], theta[40] = 61.0, 109.0, 98.9  # ten degrees, and four rows
    assert [one[2] for one in dwells(steps, theta)] == [3e-6, 9e-6]


def test_the_height_of_all_rows_has_no_share_in_what_a_dwell_is():
    theta = [float(k) for k in range(360)]
    steps = [abs(k - 180) for k in range(360)]
    steps[170:191] = [0] * 21
    assert dwells(steps, theta) == [(170.0, 190.0, 0.0)]
    digit = 1.001e-6 * 2.0 * 180.0 / (340.0 / 2.0) ** 2 * (20.0 / 4.0) ** 2
    for base in (0, 5000):
        lifts = [1e-6 * (step + base) for step in steps]
        assert reading._dwells("t", theta, lifts, steps, digit) == []


@pytest.mark.parametrize(("moving", "enough"), [(11, False), (12, True)])
def test_twelve_rows_move_at_least(moving, enough):
    theta = [float(k) for k in range(360)]
    steps = [(k + 1) ** 2 if k < moving else 0 for k in range(360)]
    if enough:
        assert len(dwells(steps, theta)) == 1
    else:
        (fault,) = refusal(dwells, steps, theta)
        assert fault.startswith("t: file: found 11 rows of moving lift, expected at least 12")


def table_text(angles, lifts) -> reading._Rows:
    columns = [
        [Cell(f"t:{n}", n, str(x), Decimal(str(x))) for n, x in enumerate(numbers, 2)]
        for numbers in (angles, lifts)
    ]
    return reading._Rows("t", *columns)


@pytest.mark.parametrize("direction", ["same", "reversed"])
def test_a_table_is_laid_on_the_turn_of_the_cam(direction):
    """Crank degrees, inches above 0.25 through a rocker, zero at 30.5 deg of the cam.

    There is a row more on the lobe, and one less; the last row is the first once more.
    """
    angles = [*range(0, 251, 10), 255, *range(260, 301, 10), *range(320, 721, 10)]
    digits = [100 * bump(round(angle / 5), 40, 60) for angle in angles]
    lifts = [f"{0.25 + step * 1e-4:.4f}" for step in digits]
    cam = cam_of(
        angle="crank", lift="inch", subtract=0.25, metres=0.15 * INCH, zero_deg=30.5,
        direction=direction,
    )  # fmt: skip
    turn = reading._one_turn(table_text(angles, lifts), cam)
    sign = -1 if direction == "reversed" else 1
    places = [(30.5 + sign * angle / 2) % 360.0 for angle in angles[:-1]]
    order = sorted(range(len(places)), key=places.__getitem__)
    assert turn.theta.tolist() == [places[k] for k in order]
    assert turn.line.tolist() == [k + 2 for k in order]
    assert turn.lift == pytest.approx([1e-4 * digits[k] * INCH * 0.15 for k in order], abs=1e-15)
    assert turn.spacing == 5.0  # the median
    assert turn.quantum == pytest.approx(2 * 1e-2 * INCH * 0.15)


LEVEL, NOISY = [0] * 19, [-6, 5, 5, -7, 6] * 4
LOBE = [300 * bump(k, 0, 40) + 1 for k in range(40)]


def ends_of(steps: list[int], step: int = 2, gap: int = 0) -> int | str:
    """How many rows are filled in, or the fault; from row 3 on rows are a gap later."""
    angles = [100 + step * k + gap * (k > 2) for k in range(len(steps))]
    rows = table_text(angles, [f"{one / 1000:.3f}" for one in steps])
    try:
        return int((reading._one_turn(rows, cam_of()).line == 0).sum())
    except SceneError as error:
        return str(error.faults[0]).split(" deg")[0]


def test_the_ends_of_a_noisy_table_of_the_lobe_are_on_its_base_circle():
    """Either end may scatter; where the ends are not off it, rows between are none of it."""
    for at_start, at_end in ((NOISY, LEVEL), (LEVEL, NOISY), (NOISY, NOISY)):
        steps = [*at_start, *LOBE, *at_end[::-1]]
        assert ends_of(steps) == (360 - 2 * (len(steps) - 1)) // 2 - 1
    quiet = [0, *NOISY, *LOBE, 0]
    assert ends_of(quiet, gap=12) == "t:4: angle: the rows of lines 4 and 5 are 14"
    beside_noise = [1, *NOISY, *LOBE, 2]
    assert ends_of(beside_noise, gap=12) == 6 + (360 - 2 * 61 - 12) // 2 - 1
    round_the_turn = [-6, *NOISY, *LOBE, *NOISY, *NOISY, *NOISY[:17]]
    assert ends_of(round_the_turn, 3, 6) == 0
    assert ends_of(round_the_turn[:-2], 3, 12) == "t:4: angle: the rows of lines 4 and 5 are 15"


def test_faults_are_of_one_cause_by_path_expectation_and_cure():
    faults = [
        Fault("t:1", "a", "found 1", "x", "y"), Fault("t:2", "b", "found 2", "x", "y"),
        Fault("t:3", "a", "found 3", "z", "y"), Fault("t:4", "a", "found 4", "x", "z"),
        Fault("t:5", "a", "found 5", "x", "y"), Fault("t:6", "a", "found 6", "x", "y"),
    ]  # fmt: skip
    found = refusal(reading.raise_each_cause, faults)
    assert found == [
        "t:1: a: found 1, and 2 more like it, x, y", "t:2: b: found 2, x, y",
        "t:3: a: found 3, z, y", "t:4: a: found 4, x, z",
    ]  # fmt: skip
    reading.raise_each_cause(iter(()))
