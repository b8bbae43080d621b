"""Which lines of a file are a lift table, its titles, or a fault, on lines made by hand."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from camcli.cams import lift_guess
from camcli.cams.lift_guess import CutLine, Guess, GuessedTable, NumberRun
from camcli.errors import SceneError

ANGLES = [5.0 * k for k in range(20)]
FLANK = [(k / 19) ** 3 * (10 - 15 * k / 19 + 6 * (k / 19) ** 2) for k in range(20)]


def cut(*lines: str, first: int = 1) -> list[CutLine]:
    """Lines of a file, the first of this number, cut at commas."""
    return lift_guess._cut(list(enumerate(lines, first)), "point")


def table_of(lines: list[CutLine], start: int, count: int, angle=0, lift=1) -> GuessedTable:
    return GuessedTable(lines, NumberRun(start, lines[start : start + count]), angle, lift, "t.csv")


def test_a_column_of_numbers_has_them_in_more_than_half_of_its_cells():
    rows = cut("1,x,5,", "2,7,6,", "3,y,z,1", "4,8,9,")
    assert lift_guess._number_columns(NumberRun(3, rows)) == {
        0: [1.0, 2.0, 3.0, 4.0], 2: [5.0, 6.0, 9.0]
    }  # fmt: skip


@pytest.mark.parametrize(
    ("lines", "start", "count"),
    [
        (("a,b", "1,2", "3,4", "x,5", "6,7", "8,9"), 1, 2),  # the first of two as long
        (("1,2", "3,4", "x", "6,7", "8,9", "0,1"), 3, 3),
        (("1,2", "3,4", "1,2,3", "4,5,6", "7,8,9"), 2, 3),
        (("1,2,3", "4,5,x", "7,8", "9,0"), 0, 2),  # a cell may be none, where two are numbers
        (("1,2,3", "4,,x", "7,8,9", "9,0,1"), 2, 2),
        (("a,b", "c"), 0, 0),
    ],
)
def test_the_longest_run_has_two_numbers_a_row_and_equally_many_cells(lines, start, count):
    run = lift_guess._longest_run(cut(*lines))
    assert (len(run.rows), run.start if count else 0) == (count, start)
    assert [row.line for row in run.rows] == list(range(start + 1, start + count + 1))


ROWS = "1,2,3", "4,5,6"


@pytest.mark.parametrize(
    ("above", "titles"),
    [
        ((), 0),
        (("a,b,c",), 1),
        (("a,b,c", "d,e,f", "g,h,i", "j,k,l"), 3),
        (("a,b,c", "d,,", "g,h,i"), 1),  # one cell of it is filled
        (("a,b,c", "d,,f", "g,h,i"), 3),
        (("a,b,c", "d,e", "g,h,i"), 1),
        (("a,b,c", "d,7,f", "g,h,i"), 3),  # one number
        (("a,b,c", "8,7,f", "g,h,i"), 1),
        (("a,b,c", "x [mm],y,z", "g,h,i"), 3),
        (("a,b,c", "x [mm],y (deg),z", "g,h,i"), 2),  # the last one: two units
    ],
)
def test_how_many_lines_above_the_rows_are_titles(above, titles):
    lines = cut(*above, *ROWS)
    run = NumberRun(len(above), lines[len(above) :])
    assert len(above) - lift_guess._start_of_header(lines, run) == titles
    header = lift_guess._header_of(lines, run)
    first = len(above) - titles
    assert header.first == first
    assert header.titles == (above[first].split(",") if titles else [])
    words = [line.split(",") for line in above[first:]]
    assert header.words == (
        [" ".join(line[k] for line in words) for k in range(3)] if titles else [""] * 3
    )


def test_a_column_is_named_by_its_title_where_no_other_has_it():
    lines = cut("Deg,Hub,Hub,", "1,2,3,4")
    header = lift_guess._header_of(lines, NumberRun(1, lines[1:]))
    assert [header.name_of(k) for k in range(4)] == ["Deg", 2, 3, 4]
    assert header.words == ["deg", "hub", "hub", ""]
    none = lift_guess._header_of(lines, NumberRun(0, lines))
    assert [none.name_of(k) for k in range(2)] == [1, 2]
    assert none.title(1) == ""


@pytest.mark.parametrize(
    ("lines", "shown"),
    [
        (("a,b", "1,2,c", "3,", "4,x,y", "5,z"), ", and 'x' in line 4"),
        (("a,b", "1,2,c", "3,"), ""),
        (("n,7,m",), ", and 'n' in line 1"),
    ],
)
def test_a_file_without_a_table_is_told_the_first_line_that_is_nearly_a_row(lines, shown):
    (fault,) = lift_guess._no_table(cut(*lines), "t.csv").faults
    assert fault.found == f"found no 8 rows of numbers one after the other{shown}"


@pytest.mark.parametrize(
    ("angles", "sign", "reach"),
    [
        ((0, 1, 2, 4, 10), 1.0, 2.25),  # steps of 1, 1, 2 and 6
        ((10, 9, 7, 6), -1.0, 1.5),
        ((355, 0, 5, 10), 1.0, 7.5),
        ((5, 0, 355, 350), -1.0, 7.5),
    ],
)
def test_the_angles_of_a_table_rise_and_the_next_may_be_one_and_a_half_steps_away(
    angles, sign, reach
):
    lines = cut(*(f"{angle},1" for angle in angles))
    table = table_of(lines, 0, len(lines))
    assert table.sign == sign
    assert table.angles == [sign * angle for angle in angles]
    assert table.reach == reach


def test_a_line_beside_the_rows_belongs_to_them_by_its_angle():
    """Steps of one degree: so many rows away the angle may be 1.5 deg for each off the end."""
    middle = [f"{k},1" for k in range(10, 15)]
    for texts, expected in {
        ("x,y", "10,1", "8.5,1"): [False, False, True],
        ("5.4,x", "7.0,x", "8.4,1"): [False, True, False],
        ("5.5,x", "6.9,x", "11,x"): [True, False, False],
        ("z", "8,1,7", "9"): [False, True, True],
    }.items():
        table = table_of(cut(*texts, *middle), 3, 5)
        assert [table._is_before(k) for k in range(3)] == expected
    table = table_of(cut(*middle), 0, 5)  # from 10 to 14
    for k, text, follows in (
        (0, "14,1", False), (0, "15.5,x", True), (0, "15.6,x", False), (1, "17,1", True),
        (1, "17.1,1", False), (0, "x,1", False), (0, "15,1,9", True),
    ):  # fmt: skip
        assert table._is_behind(k, cut(text)[0]) is follows
    through_zero = table_of(cut(*(f"{k},1" for k in range(350, 360))), 0, 10)
    twice = table_of(cut(*(f"{k},1" for k in range(700, 720))), 0, 20)  # a crank
    from_zero = table_of(cut(*(f"{k},1" for k in range(360))), 0, 360)
    second = table_of(cut(*(f"{k},x,1" for k in (3, 4, 5))), 0, 3, 0, 2)
    for table, text, follows in (
        (through_zero, "0,x", True), (through_zero, "1,x", False), (twice, "0,x", True),
        (twice, "360,x", True), (from_zero, "0,x", False), (from_zero, "360,x", True),
        (second, "6", True), (second, "", False),
    ):  # fmt: skip
        assert table._is_behind(0, CutLine(1, *cut(text)[0][1:])) is follows


def test_a_row_has_numbers_in_both_cells_that_count():
    table = table_of(cut("1,x,3", "2,y,4"), 0, 2, 0, 2)
    for text, is_row in (("5,z,6", True), ("5,6,z", False), ("z,5,6", False), ("5,6,7,8", False)):
        assert table.is_row(cut(text)[0]) is is_row


def refusal(lines: tuple[str, ...], start: int, count: int) -> list[tuple[str, str]]:
    """The faults of a table: where they are, and what is found."""
    try:
        table_of(cut(*lines), start, count).refuse_what_cannot_be_read()
    except SceneError as error:
        return [(fault.where, fault.found) for fault in error.faults]
    return []


TEN = tuple(f"{k},1" for k in range(20, 30))


@pytest.mark.parametrize(
    ("above", "below", "told"),
    [
        (("a,b",), (), []),
        (("x,1", "18,b", "19,c"), (), [("t.csv:2:4", "found 'b', and 1 more like it")]),
        (("10,b", "x,1"), (), []),  # too far off to be of this table
        ((), ("y,z", "30,x"), [("t.csv:11:1", "found 'y', and 1 more like it")]),
        ((), ("30,x", "31,2", "20,3", "21,y"), [("t.csv:11:4", "found 'x'")]),
        ((), ("y,z", "20,3", "32,2"), [("t.csv:12", "rows of numbers begin again at 20")]),
        ((), ("y,z", "21,3", "20,2"), [("t.csv:12", "rows of numbers begin again at 21")]),
        ((), ("30", "31,1"), [("t.csv:11", "found 1 cell")]),
        ((), (f"30,{'v' * 50}", "31,1"), [("t.csv:11:4", f"found '{'v' * 37}...'")]),
        ((), ("30,", "31,1"), [("t.csv:11:4", "found an empty cell")]),
    ],
)
def test_a_line_is_refused_where_rows_of_its_table_are_above_or_below(above, below, told):
    assert refusal((*above, *TEN, *below), len(above), len(TEN)) == told


@pytest.mark.parametrize(
    ("angles", "again"),
    [
        ((10, 11, 12, 10.9, 12, 13), None),  # back by less than one and a half steps
        ((10, 11, 12, 10, 11, 12), 4),
        ((10, 11, 12, 9, 10, 11), None),  # through zero
        ((13, 12, 11, 13, 12, 11), 4),
        ((10, 11, 12, 13, 11, 12, 10, 11), 5),
    ],
)
def test_a_second_table_begins_where_the_angle_falls_back_but_not_below_the_first(angles, again):
    lines = tuple(f"{angle},1" for angle in angles)
    where = f"the angle begins again at {angles[again - 1]}" if again else ""
    assert refusal(lines, 0, len(lines)) == ([(f"t.csv:{again}", where)] if again else [])


def test_another_table_above_has_eight_rows():
    def told(lines: int) -> dict[str, str]:
        guessed = Guess({})
        rows = [SimpleNamespace(line=3 * k, row=0 < k <= lines) for k in range(lines + 2)]
        table = SimpleNamespace(is_row=lambda line: line.row)
        lift_guess._doubt_what_is_skipped(guessed, rows, table)
        return guessed.unsure

    assert told(7) == {}
    assert told(8)["skip_lines"].startswith("lines 3 to 24 are another table")


@pytest.mark.parametrize(
    ("column", "steady"),
    [
        ([1, 2, 3], True),
        ([3, 2, 1], True),
        ([200, 300, 350, 0, 100], True),
        ([100, 0, 350, 300, 200], True),
        ([0, 10, 4.9, 10], True),
        ([0, 10, 5, 10], False),  # by half of the range
        ([100, 200, 300, 0, 50, 45, 99], False),  # one leap and a small step
        ([0, 0, 1], False),
    ],
)
def test_a_column_of_angles_is_steady_but_for_leaps_of_more_than_half_its_range(column, steady):
    assert lift_guess._steady(column) is steady


def test_a_column_of_lifts_falls_below_zero_by_a_fiftieth_and_is_not_constant():
    find = lift_guess._lift_columns
    hump = [7.0 * x for x in (*FLANK, *FLANK[-2::-1])]
    angles = [5.0 * k for k in range(len(hump))]
    words = ["deg", "", "", ""]
    for lowest, chosen in ((-0.139, 1), (-0.141, 2)):
        below = [x if x > 0.0 else lowest for x in hump]
        columns = {0: angles, 1: below, 2: hump}
        assert find(columns, words, 0, "t") == (chosen, [2] if chosen == 1 else [])
    columns = {0: ANGLES, 1: [5.0] * 20, 2: [0.0] * 20, 3: FLANK}
    assert find(columns, words, 0, "t") == (3, [])
    assert find({0: FLANK, 3: ANGLES}, words, 3, "t") == (0, [])
    assert not lift_guess._flank([5.0] * 20)


@pytest.mark.parametrize(
    ("top", "lift", "unit", "words"),
    [
        (5000, 3000.5, "um", "5000, too large for thousandths of an inch"),
        (5000, 3000, "thou", "5000: as thousandths of an inch a lift of 76.2 mm, as mm one of 3 m"),
        (500, 121, "thou",
         "500: as thousandths of an inch a lift of 3.073 mm, as mm one of 0.121 m"),
        (500, 120, "mm", "500"),
        (50, 1.1, "mm", "50"),
        (50, 1.0, "inch", "50"),
        (50, 0.051, "inch", "50"),
        (50, 0.05, "m", "50"),
    ],
)  # fmt: skip
def test_a_unit_is_guessed_by_the_lift_and_told_by_the_largest_number(top, lift, unit, words):
    """The lift of radii is what they differ by."""
    assert lift_guess._unit_by_size(top, lift) == (unit, f"the largest number is {words}")
    guessed = Guess({})
    lift_guess._lift_unit(guessed, [float(top - lift), float(top)], "")
    assert guessed.keys == {"lift": unit}
    assert guessed.unsure == {"lift": f"the largest number is {words}"}


@pytest.mark.parametrize(
    ("numbers", "title", "doubt"),
    [
        ([0.0, 100.0], "mm", None),  # 0.1 m is no doubt
        ([0.0, 101.0], "mm", "the title says mm, but that is a lift of 0.101 m"),
        ([150.0, 240.0], "mm", None),
        ([150.0, 260.0], "mm", "the title says mm, but that is a lift of 0.11 m"),
        ([4.0, 101.0], "mm", "the title says mm, but that is a lift of 0.101 m"),  # no radii
    ],
)
def test_a_unit_of_the_title_is_doubted_by_the_lift(numbers, title, doubt):
    guessed = Guess({})
    lift_guess._lift_unit(guessed, numbers, title)
    assert guessed.keys == {"lift": "mm"}
    assert guessed.unsure.get("lift") == doubt


@pytest.mark.parametrize(
    ("numbers", "keys", "wanted"),
    [
        ([5.0, 100.0], {"lift": "mm"}, None),  # a twentieth of the largest
        ([5.1, 100.0], {"lift": "mm"}, (5.1, 0.0051)),
        ([17.123456, 20.0, 17.5], {"lift": "inch"}, (17.123456, 0.4349357824)),
        ([1900.0, 1800.0], {"lift": "fraction", "max_lift": 1e-5}, (1800.0, 0.018)),
        ([0.1 + 0.2, 0.5], {"lift": "mm"}, (0.1 + 0.2, 0.0003)),  # no digits of rounding
    ],
)
def test_the_least_of_radii_is_the_base_circle(numbers, keys, wanted):
    guessed = Guess(dict(keys))
    lift_guess._radii(guessed, numbers)
    subtract, radius = (guessed.keys.get(key) for key in ("subtract", "base_radius"))
    assert (subtract, radius) == (wanted or (None, None))
    assert set(guessed.unsure) == ({"subtract"} if wanted else set())


@pytest.mark.parametrize(
    ("other", "factor"),
    [
        ([100.0, 110.0, 120.0, 110.0, 100.0], "2"),
        ([0.0, 5.09, 10.0, 5.0, 0.0], "1"),
        ([0.0, 4.91, 10.0, 5.0, 0.0], "1"),
        ([0.0, 5.11, 10.0, 5.0, 0.0], None),
        ([0.0, 4.89, 10.0, 5.0, 0.0], None),
        ([100.0, 110.0, 120.0, 110.0], None),  # of which a cell is empty
    ],
)
def test_a_column_like_the_lift_is_the_same_lobe_and_others_have_a_scene(other, factor):
    """Within a hundredth of the largest lift, up or down."""
    guessed = Guess({})
    columns = {1: [50.0, 55.0, 60.0, 55.0, 50.0], 4: other, 5: [0.0, 9.0, 4.0, 1.0, 0.0]}
    found = lift_guess._other_lobes(guessed, columns, 1, [(4, "b"), (5, "")])
    assert found == ([5] if factor else [4, 5])
    first, second = guessed.unsure["lift_column"].split("; ")
    assert first.startswith(
        f"column 5 'b' is {factor} times this one:" if factor else "column 5 'b' rises and falls"
    )
    assert second.startswith("column 6 rises and falls too")


def test_each_lobe_of_a_file_has_keys_of_its_own():
    """Another unit, radii, the valve's side, one flank, and titles of two lines."""
    hump = [*FLANK, *FLANK[-2::-1]]
    lines = ["cam angle,lobe lift,exhaust valve lift,third lobe", "deg,mm,inch,um"]
    lines += [
        f"{5 * k},{9 * x:.4f},{0.7 + 0.3 * hump[k - 7]:.5f},{8000 * x * x:.1f}"
        for k, x in enumerate(hump)
    ]
    text = "\n".join(["made on Monday", "", *lines])
    found = lift_guess.guess(text.encode(), "t.csv")
    usual = {"header": 2, "skip_lines": 2, "angle_column": "cam angle", "angle": "cam",
             "rocker_ratio": 1}  # fmt: skip
    one = {**usual, "lift_column": "lobe lift", "lift": "mm", "measured_at": "lobe"}
    assert found.keys == one
    of_others = {name: lobe.keys for name, lobe in found.lobes.items()}
    assert of_others == {
        "exhaust valve lift": {**usual, "lift_column": "exhaust valve lift", "lift": "inch",
                               "measured_at": "valve", "subtract": 0.7, "base_radius": 0.01778},
        "third lobe": {**one, "lift_column": "third lobe", "lift": "um"},
    }  # fmt: skip
    comments = "# one\n# two\n" + "\n".join(lines[2:])
    assert "skip_lines" not in lift_guess.guess(comments.encode(), "t.csv").keys


def test_a_flank_beside_a_lobe_from_nose_to_nose_is_told_of_the_flank_alone():
    dwell = [0.0] * 5
    nose = [*FLANK[::-1], *dwell, *FLANK]
    flank = [*dwell, *FLANK, *[1.0] * 20]
    rows = zip(nose, flank, strict=True)
    text = "\n".join(f"{5 * k},{9 * a:.4f},{7 * b:.4f}" for k, (a, b) in enumerate(rows))
    found = lift_guess.guess(text.encode(), "t.csv")
    assert "mirrored" not in found.keys
    assert found.lobes["3"].keys["mirrored"] is False
