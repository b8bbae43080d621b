"""Why a lift table cannot be read, the whole line of it: place, what was found, what is expected.

`test_lift_table_faults.py` says where each fault is; here is every word of them, once.
"""

from __future__ import annotations

import os

import pytest

from camcli.errors import SceneError
from tests.support.lift_tables import Lobe, cycloidal, scene, table

TEXT = table(Lobe(cycloidal), 5, decimals=3)
FINE = table(Lobe(cycloidal), 1, decimals=4)
LINES = TEXT.splitlines()


def fault(folder, text, **changes):
    """The first fault of a table, as text, without the folder."""
    with pytest.raises(SceneError) as caught:
        scene(folder, text, **changes)
    return str(caught.value.faults[0]).replace(f"{folder}{os.sep}", "")


def line(number: int, new: str, text: str = TEXT) -> str:
    """The table with one line (from 1) replaced."""
    lines = text.splitlines()
    lines[number - 1] = new
    return "\n".join(lines) + "\n"


def without(first: int, last: int, text: str = FINE) -> str:
    lines = text.splitlines()
    return "\n".join(lines[: first - 1] + lines[last:]) + "\n"


def flank(*lifts: float) -> str:
    """Rows a degree apart."""
    return "deg,lift\n" + "".join(f"{k},{lift}\n" for k, lift in enumerate(lifts))


RIGHT = "is this the right file?"
COMMENT = "correct the cell, remove the row, or begin the line with # if it is a comment"
AGAIN = "remove the row or measure it again"
ANGLES = "expected angles that only rise or only fall"
UNIT = "is the unit in cam.lift the file's? And lift_column, rocker_ratio?"
FLAT = "a few steps of the last digit, expected a lift curve, write more decimals"
OPEN = (
    "expected one turn, or zero lift at both ends, measure down to zero lift, or set the ends to 0 "
    "if they are on the base circle; is cam.angle wrong (crank angles are halved)? Of one flank of "
    "a symmetric lobe write mirrored: true"
)
NOSE = (
    "expected it at one end: a flank from the base circle to the nose, leave cam.mirrored out "
    "where both flanks were measured"
)
HEADER = "in the file's header, expected one unit, correct either"
BESIDE = [float(FINE.splitlines()[deg + 1].split(",")[1]) for deg in (178, 179, 181, 182)]
SPIKE = 10.5 - (4.0 * (BESIDE[1] + BESIDE[2]) - BESIDE[0] - BESIDE[3]) / 6.0  # of the cubic there

WHOLE = {  # text of the table, what the scene says of it otherwise, and the fault
    "no number": (line(22, "100,1..2"), {},
        f"lift.csv:22:5: cam.file: found '1..2', expected a number, {COMMENT}"),
    "nan": (line(22, "100,nan"), {},
        f"lift.csv:22:5: cam.file: found 'nan', expected a number, {AGAIN}"),
    "-inf": (line(22, "100,-inf"), {},
        f"lift.csv:22:5: cam.file: found '-inf', expected a number, {AGAIN}"),
    "empty": (line(22, "100,"), {},
        f"lift.csv:22:5: cam.file: found an empty cell, expected a number, {COMMENT}"),
    "too large": (line(22, "100,1e10"), {},
        "lift.csv:22:5: cam.file: found 1e10, expected at most 1e9, is it a number?"),
    "just too large": (line(22, "100,1000000000.1"), {},
        "lift.csv:22:5: cam.file: found 1000000000.1, expected at most 1e9, is it a number?"),
    "too fine": (line(22, "100,1e-41"), {},
        "lift.csv:22:5: cam.file: found 1e-41, expected at most 40 decimals, round it"),
    "decimal comma": (TEXT.replace(",", ";").replace(".", ","), {},
        "lift.csv:2:3: cam.file: found a decimal comma: '0,000', and 71 more like it, expected "
        "decimal points, write decimal: comma in the section cam"),
    "decimal point": (TEXT.replace(",", ";"), {"decimal": "comma"},
        "lift.csv:2:3: cam.file: found a decimal point: '0.000', and 71 more like it, expected "
        "decimal commas, write decimal: point in the section cam"),
    "one header more": ("deg,lift\n" + TEXT, {},
        "lift.csv:2:1: cam.file: found 'deg', and 1 more like it, expected a number, if the table "
        "has 2 header lines, write header: 2"),
    "a header where none is": (TEXT, {"header": "false", "angle_column": 1, "lift_column": 2},
        "lift.csv:1:1: cam.file: found 'deg', and 1 more like it, expected a number, if this is a "
        "header, write header: true"),
    "few cells": (line(22, "100"), {},
        "lift.csv:22:1: cam.file: found 1 cell, expected 2 as in the first row, complete"),
    "many cells": (line(22, "100,1,25"), {},
        "lift.csv:22:1: cam.file: found 3 cells, expected 2 as in the first row, complete the row; "
        "is the comma a decimal comma?"),
    "again": (line(22, "95,1.0"), {},
        f"lift.csv:22:1: cam.angle: found the angle 95 again, {ANGLES}, remove one of the two "
        "rows"),
    "back": (line(22, "90,1.0"), {},
        f"lift.csv:22:1: cam.angle: found the angle 90 after 95, {ANGLES}, sort the rows; add a "
        "full turn to angles that go through zero"),
    "nothing": ("", {},
        f"lift.csv: cam.file: found nothing, expected rows of angle and lift, {RIGHT}"),
    "comments": ("# only\n", {},
        f"lift.csv: cam.file: found no rows, expected rows of angle and lift, {RIGHT}"),
    "few rows": ("\n".join(LINES[:16]), {},
        "lift.csv: cam.file: found 15 rows, expected at least 16, measure more rows"),
    "header of numbers": (TEXT.partition("\n")[2], {"angle_column": 1, "lift_column": 2},
        "lift.csv:1:1: cam.header: found a header of numbers, if it is the first row, write "
        "header: false"),
    "titles": (TEXT.replace("deg,lift", "n,deg,lift"), {},
        "lift.csv:2:1: cam.file: found 2 cells in the first row, and 3 titles in the header, "
        "expected as many of both, complete either; is the comma a decimal comma?"),
    "no column": (TEXT, {"lift_column": "hub"},
        "lift.csv: cam.lift_column: found no column 'hub', expected one of 'deg', 'lift', copy the "
        "name"),
    "two columns": (TEXT.replace("deg,lift", "lift,lift"), {"angle_column": 1},
        "lift.csv: cam.lift_column: found more than one column 'lift', expected one of 'lift', "
        "'lift', copy the name"),
    "no header to name": (TEXT, {"header": "false"},
        "lift.csv: cam.angle_column: found the name 'deg' for a column of a file without header, "
        "number the column, from 1, or say header: true"),
    "no such number": (TEXT, {"lift_column": 3},
        "lift.csv: cam.lift_column: found column 3, expected 1 to 2, as the file has them, columns "
        "count from 1"),
    "one column": (TEXT, {"lift_column": "deg"},
        "lift.csv: cam.lift_column: angle_column and lift_column are both column 1, expected two "
        "columns, name both"),
    "another unit": (TEXT.replace("deg,lift", "deg,lift um"), {"lift_column": "lift um"},
        f"lift.csv:1:1: cam.lift: found 'mm', and a lift in 'um' {HEADER}"),
    "two units": (
        TEXT.replace("deg,lift", "deg,lift mm (in)"), {"lift_column": "lift mm (in)", "lift": "um"},
        f"lift.csv:1:1: cam.lift: found 'um', and a lift in 'mm' or 'inch' {HEADER}"),
    "too many rows": ("deg,lift\n" + "1,2\n" * 40_001, {},
        "lift.csv: cam.file: found 40001 rows, expected at most 40000, thin the table out"),
    "too many lines": ("deg,lift\n" + "#\n" * 80_000, {},
        "lift.csv: cam.file: found 80001 lines, expected at most 80000, thin the table out"),
    "as many lines": ("#\n" * 80_000, {},
        f"lift.csv: cam.file: found no rows, expected rows of angle and lift, {RIGHT}"),
    "a long line": ("deg,lift\n" + "1" * 10_001, {},
        "lift.csv:2:1: cam.file: found a line of 10001 characters, expected at most 10000, "
        f"{RIGHT}"),
    "large": (FINE, {"lift": "m"},
        "lift.csv:182:5: cam.lift: found a largest lift of 10 m, suspiciously large, expected "
        f"0.0001 to 1 m, {UNIT}"),
    "small": (FINE, {"rocker_ratio": 0.009},
        "lift.csv:182:5: cam.lift: found a largest lift of 9e-05 m, suspiciously small, expected "
        f"0.0001 to 1 m, {UNIT}"),
    "below": (line(22, "20,-1.5", FINE), {},
        "lift.csv:22:4: cam.lift: found a lift of -1.5 mm, below the base circle, expected lifts "
        "from zero up, is lift_column the right column, and cam.subtract right?"),
    "flat": (flank(*[0.0, 0.1] * 180), {},
        f"lift.csv:3:3: cam.lift: found lifts that differ by 0.1 mm, {FLAT}"),
    "seven steps": (flank(*[0.0, 0.1] * 170, *[round(0.1 * k, 1) for k in range(8)]), {},
        f"lift.csv:349:5: cam.lift: found lifts that differ by 0.7 mm, {FLAT}"),
    "eight steps": (flank(*[0.0, 0.1] * 170, *[round(0.1 * k, 1) for k in range(9)]), {},
        "lift.csv:350:5: cam.lift: the table ends at 348 deg with a lift of 0.8 mm, an open end "
        f"(12 deg of cam are missing), {OPEN}"),
    "too long": (FINE + "361,0\n", {},
        "lift.csv:362:1: cam.angle: the table covers 361 deg of cam, 1 too much, expected one "
        "turn, is cam.angle right (crank angles are halved)? Cut the table after one turn"),
    "another end": (FINE + "360,0.3\n", {},
        "lift.csv:362:5: cam.lift: the last row is one turn after the first, its lift is 0.3, "
        "expected 0.0000 as in the first row, correct one of the two"),
    "begins": (without(2, 150), {},
        "lift.csv:2:5: cam.lift: the table begins at 149 deg with a lift of 6.1307 mm, an open end "
        f"(150 deg of cam are missing), {OPEN}"),
    "ends": (without(200, 362), {},
        "lift.csv:199:5: cam.lift: the table ends at 197 deg with a lift of 9.1614 mm, an open end "
        f"(163 deg of cam are missing), {OPEN}"),
    "subtracted": (without(200, 362), {"subtract": -1.5},
        "lift.csv:2:3: cam.lift: the table begins at 0 deg with a lift of 0 mm (1.5 mm after "
        "subtract: -1.5), an open end (163 deg of cam are missing), and 1 more like it, "
        f"{OPEN}"),
    "a gap": (without(170, 300), {},
        "lift.csv:169:1: cam.angle: the rows of lines 169 and 170 are 132 deg apart, expected at "
        "most 10 deg of cam where the lift moves, measure the rows between"),
    "a spike": (line(182, "180,10.5", FINE), {},
        f"lift.csv:182:1: cam.lift: found a spike: the row is {SPIKE:.6g} mm off its "
        "neighbours, expected at most 0.0012 mm, 12 last digits, correct the row, or remove it"),
    "inside": (FINE, {"mirrored": "true"},
        "lift.csv:182:5: cam.mirrored: found the largest lift 10.0000 inside the table, "
        f"{NOSE}"),
    "both ends": (flank(*[1.5, *[1.0] * 30, 1.5]), {"mirrored": "true"},
        "lift.csv:2:3: cam.mirrored: found the largest lift 1.5 at both ends of the table, "
        f"{NOSE}"),
    "hardly moving": (flank(*[0.0] * 170, 0.37, 1.5, 3.1, 4.4, 5.01, 4.4, 3.1, 1.5, 0.37,
                            *[0.0] * 180), {},
        "lift.csv: cam.file: found 9 rows of moving lift, expected at least 12, measure more rows"),
}  # fmt: skip


@pytest.mark.parametrize("name", WHOLE)
def test_a_fault_is_told_word_by_word(tmp_path, name):
    text, changes, words = WHOLE[name]
    assert fault(tmp_path, text, **changes) == words
