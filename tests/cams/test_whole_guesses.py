"""What `cam init` proposes for a lift table: every key of it, and every doubt word by word."""

from __future__ import annotations

from math import radians, sin
from typing import Any

import pytest

from camcli.cams.lift_guess import guess
from camcli.errors import SceneError

TURN = range(0, 360, 5)
DOUBTS = {
    "rocker_ratio": "taken without a rocker; if there is one, write its ratio (lift of the valve "
                    "per lift of the lobe)",
    "measured_at": "write valve if the table is of the valve and not of the lobe; beside a rocker "
                   "that matters",
}  # fmt: skip
RADII = (
    "so they are radii: the least one is taken for the base circle, and what is more for the lift; "
    "that is the lift of the follower only where the radii were measured with a follower like it "
    "(a roller, a flat face)"
)


def lift(deg: float, top: float = 10.0) -> float:
    """A lobe of 120 deg about 180 deg."""
    return top * sin(radians(1.5 * (deg - 120.0))) ** 2 if 120.0 < deg < 240.0 else 0.0


def rows(title: str, degrees=TURN, scale=1.0, digits=3, step=1.0, base=0.0) -> str:
    lines = (f"{step * k:g},{base + scale * lift(k):.{digits}f}\n" for k in degrees)
    return title + "".join(lines)


def columns(title: str, *more) -> str:
    """The lobe in mm, and further columns that are functions of the angle."""
    lines = (f"{k},{lift(k):.4f}" + "".join(f",{x(k):.5f}" for x in more) for k in TURN)
    return title + "".join(f"{one}\n" for one in lines)


def keys(angle_column: int | str, lift_column: int | str, **more: Any) -> dict[str, Any]:
    """The keys of most tables, and others of one."""
    usual = {"header": 1, "angle": "cam", "lift": "mm", "rocker_ratio": 1, "measured_at": "lobe"}
    return {**usual, "angle_column": angle_column, "lift_column": lift_column, **more}


AT_THE_VALVE = "cam deg,valve lift mm\n"
NAMED = "cam deg", "lift mm"
HUNDREDTHS = {"lift": "hundredths of a millimetre by the title, 10 mm of lift"}
READ = {  # text, keys, doubts beside those of a rocker
    "plain": (rows("deg,lift\n"), keys("deg", "lift"), {"lift": "the largest number is 10"}),
    "no titles": (rows(""), keys(1, 2, header=0), {"lift": "the largest number is 10"}),
    "titles twice": (rows("cam mm,cam mm\n"), keys(1, 2), {}),
    "crank by title": (rows("crank deg,lift mm\n"), keys("crank deg", "lift mm", angle="crank"),
                       {}),
    "crank by span": (rows("deg,lift mm\n", step=2), keys("deg", "lift mm", angle="crank"), {}),
    "cam by span": (rows("deg,lift mm\n", range(0, 341, 5)), keys("deg", "lift mm"), {}),
    "less than a turn": (
        rows("angle,lift mm\n", range(0, 336, 5)), keys("angle", "lift mm"),
        {"angle": "335 deg of the cam, or of a crank that turns twice as fast?"}),
    "just more than a turn": (rows("deg,lift mm\n", range(0, 401, 5)), keys("deg", "lift mm"), {}),
    "hundredths": (
        rows("deg,hub 0.01 mm\n", scale=100), keys("deg", "hub 0.01 mm", lift="fraction",
                                                   max_lift=1e-5), HUNDREDTHS),
    "inches by size": (rows("deg,lift\n", scale=0.04, digits=4), keys("deg", "lift", lift="inch"),
                       {"lift": "the largest number is 0.4"}),
    "metres by size": (rows("deg,lift\n", scale=0.001, digits=6), keys("deg", "lift", lift="m"),
                       {"lift": "the largest number is 0.01"}),
    "thousandths by size": (  # 400 of 0.0254 mm
        rows("deg,lift\n", scale=40), keys("deg", "lift", lift="thou"),
        {"lift": "the largest number is 400: as thousandths of an inch a lift of 10.16 mm, as mm "
                 "one of 0.4 m"}),
    "micrometres by size": (
        rows("deg,lift\n", scale=1000), keys("deg", "lift", lift="um"),
        {"lift": "the largest number is 10000, too large for thousandths of an inch"}),
    "a title against the size": (
        rows("deg,lift inch\n"), keys("deg", "lift inch", lift="inch"),
        {"lift": "the title says inch, but that is a lift of 0.254 m"}),
    "radii": (
        rows("cam deg,lift mm\n", base=18.0), keys(*NAMED, subtract=18.0, base_radius=0.018),
        {"subtract": f"the numbers go from 18 to 28, {RADII}"}),
    "radii in hundredths": (
        rows("cam deg,lift 0.01 mm\n", base=1800.0, scale=100),
        keys("cam deg", "lift 0.01 mm", lift="fraction", max_lift=1e-5, subtract=1800.0,
             base_radius=0.018),
        {**HUNDREDTHS, "subtract": f"the numbers go from 1800 to 2800, {RADII}"}),
    "a flank": (
        rows("cam deg,lift mm\n", range(100, 181, 2)), keys(*NAMED, mirrored=False),
        {"mirrored": "the lift only rises or only falls, so this is one flank: write true if the "
                     "lobe is symmetric, else measure the other flank too"}),
    "the same lobe": (
        columns("deg,lift mm,lift in\n", lambda k: lift(k) / 25.4), keys("deg", "lift mm"),
        {"lift_column": "column 3 'lift in' is 0.03937 times this one: the same lobe in another "
                        "unit, or behind a rocker"}),
    "two lobes": (
        columns("deg,lift mm,lift b\n", lambda k: lift((k + 100) % 360)), keys("deg", "lift mm"),
        {"lift_column": "column 3 'lift b' rises and falls too, another lobe: it has a scene of "
                        "its own"}),
    "two in one": (
        "cam deg,lift mm\n" + "".join(f"{k},{lift(2 * k % 360):.4f}\n" for k in TURN), keys(*NAMED),
        {"lift_column": "it rises from zero and comes back 2 times: if these are 2 cams, cut the "
                        "file, a table for each, and make a scene of each"}),
    "a table above": (
        "1,2\n" * 8 + "other\n" + rows("cam deg,lift mm\n"), keys(*NAMED, skip_lines=9),
        {"skip_lines": "lines 1 to 8 are another table, which is not read; for a scene of it put "
                       "it into a file of its own"}),
    "seven rows above": ("1,2\n" * 7 + "other\n" + rows("cam deg,lift mm\n"),
                         keys(*NAMED, skip_lines=8), {}),
    "decimal commas": (rows("cam deg;lift mm\n").replace(",", ";").replace(".", ","),
                       keys(*NAMED, decimal="comma"), {}),
    "a tappet of a valve": (rows("cam deg,valve tappet lift mm\n"),
                            keys("cam deg", "valve tappet lift mm"), {}),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_a_proposal_is_made_key_by_key_and_doubted_word_by_word(name):
    text, wanted, doubts = READ[name]
    found = guess(text.encode(), "t.csv")
    assert found.keys == wanted
    assert found.unsure == {**DOUBTS, **doubts}
    others = {"lift b": {**wanted, "lift_column": "lift b"}} if name == "two lobes" else {}
    assert {column: lobe.keys for column, lobe in found.lobes.items()} == others


def test_a_table_of_the_valve_leaves_nothing_open():
    found = guess(rows(AT_THE_VALVE).encode(), "t.csv")
    assert found.keys == keys("cam deg", "valve lift mm", measured_at="valve")
    assert found.unsure == {}


ROW = "correct the row or remove it, or begin the line with # if it is a comment"
ONE = (
    "expected one table in a file, cut the file there, a table of its own for each cam, and make a "
    "scene of each"
)
NONE = "found no 8 rows of numbers one after the other"
REFUSED = {
    "few rows": (rows("deg,lift\n", range(0, 35, 5)),
                 f"t.csv: {NONE}, expected a table of angles and lifts, is it the file?"),
    "nearly a row": (
        "deg,lift\n" + "1,x\n" * 20,
        f"t.csv: {NONE}, and 'x' in line 2, expected a table of angles and lifts, is it the file?"),
    "falls back twenty times": ("a,b\n" + "".join(f"{k % 3},{k % 2}\n" for k in range(63)),
                                f"t.csv:5: the angle begins again at 0, {ONE}"),
    "falls back more often": (
                 "a,b\n" + "".join(f"{k % 3},{k % 2}\n" for k in range(64)),
                 "t.csv: found no column that only rises or only falls, expected a column of "
                 "angles, is the angle in the file?"),
    "no lift": ("a,b\n" + "".join(f"{k},{-k}\n" for k in range(60)),
                "t.csv: found no column that rises and falls again, expected a column of lifts, is "
                "the lift in the file?"),
    "no number": (rows("deg,lift\n").replace("150,5.000", "150,x"),
                  f"t.csv:32:5: found 'x', expected a number, {ROW}"),
    "no cell": (rows("deg,lift\n").replace("150,5.000", "150,"),
                f"t.csv:32:5: found an empty cell, expected a number, {ROW}"),
    "cells": (rows("deg,lift\n").replace("150,5.000", "150,5.000,7"),
              f"t.csv:32: found 3 cells, expected 2 as in the rows beside it, {ROW}"),
    "again": (rows("deg,lift\n") + "end\n" + rows(""),
              f"t.csv:75: rows of numbers begin again at 0, {ONE}"),
    "begins": (rows("deg,lift\n") + rows(""), f"t.csv:74: the angle begins again at 0, {ONE}"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_table_is_told_word_by_word(name):
    text, words = REFUSED[name]
    with pytest.raises(SceneError) as caught:
        guess(text.encode(), "t.csv")
    assert [str(fault) for fault in caught.value.faults] == [words]
