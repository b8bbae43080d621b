"""Every threshold of reading, guessing and trusting a lift table: just within it, and beyond.

A row is a text and what it is, at the threshold and past it; other faults a text may have are no
matter here. The thresholds are written here once more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi
from typing import NamedTuple

import pytest

from camcli.cams.lift_guess import guess
from camcli.cams.lift_reading import refuse_too_many_rows, text_lines
from camcli.errors import SceneError
from camcli.words.lift_table import cautions
from camcli.words.machine import doubts
from tests.support.lift_tables import Lobe, cycloidal, scene, smooth, table

FINE = table(Lobe(cycloidal), 1, decimals=4)
ROWS = [(float(a), float(b)) for a, b in (row.split(",") for row in FINE.split()[1:])]


class Threshold(NamedTuple):
    """What is said of a text; it is not of `within`, it is of `beyond`."""

    words: str
    within: str
    beyond: str


def written(rows, decimals: int = 4) -> str:
    """A table of (angle, lift) pairs; texts stay as they are."""
    cells = ((f"{a:g}", b if isinstance(b, str) else f"{b:.{decimals}f}") for a, b in rows)
    return "deg,lift\n" + "".join(f"{a},{b}\n" for a, b in cells)


def changed(number: int, lift: str) -> str:
    """The table with one lift replaced."""
    return written([(a, lift if k == number else b) for k, (a, b) in enumerate(ROWS)])


def scaled(top: float) -> str:
    """The table with another highest lift, which stands there exactly."""
    return written([(a, b * top / 10.0) for a, b in ROWS], 6)


def steps(most: int) -> str:
    """A hump of so many steps of the last digit."""
    return written([(a, round(b / 10.0 * most) / 10.0) for a, b in ROWS], 1)


def few(number: int) -> str:
    """A hump of so many rows round the turn."""
    return written([(360.0 / number * k, 5.0 * (1.0 - cos(2 * pi * k / number)))
                    for k in range(number)])  # fmt: skip


def lobe_of(number: int) -> str:
    """So many rows off a dwell."""
    inside = [(100.0 + 10.0 * k, 5.0 * (1.0 - cos(2 * pi * k / (number + 1))))
              for k in range(1, number + 1)]  # fmt: skip
    return written([*((5.0 * k, 0.0) for k in range(21)), *inside,
                    *((inside[-1][0] + 10.0 + 5.0 * k, 0.0) for k in range(10))])  # fmt: skip


def gap(first: int, last: int, step: float = 1.0) -> str:
    """The lobe without the rows between two on its flank."""
    rows = [(k * step, Lobe(cycloidal).at(k * step)[0] * 1e3) for k in range(round(360 / step))]
    return written([row for row in rows if not first < row[0] < last])


def shifted(by: float) -> str:
    """Rows every 8 deg, and one of the flank moved."""
    rows = [(8.0 * k, Lobe(cycloidal).at(8.0 * k)[0] * 1e3) for k in range(45)]
    del rows[18]
    rows[18] = (rows[18][0] + by - 16.0, rows[18][1])
    return written(rows)


def parabola(off: int) -> str:
    """Whole steps of the last digit on a parabola, which the neighbours give exactly, one off."""
    rows = [(float(k), (k * (360 - k) + (off if k == 100 else 0)) / 1e4) for k in range(360)]
    return written(rows)


READING = [
    Threshold("expected at most 40 decimals", changed(150, "3." + "1" * 40),
              changed(150, "3." + "1" * 41)),
    Threshold("expected at most 1e9", changed(150, "1000000000"), changed(150, "1000000001")),
    Threshold("expected at least 16", few(16), few(15)),
    Threshold("rows of moving lift, expected at least 12", lobe_of(12), lobe_of(11)),
    Threshold("deg apart, expected at most 10 deg", gap(130, 140), gap(130, 141)),
    Threshold("expected at most 10 deg of cam", shifted(12.0), shifted(12.25)),
    Threshold("suspiciously large", scaled(1000.0), scaled(1000.001)),
    Threshold("suspiciously small", scaled(0.1), scaled(0.099999)),
    Threshold("below the base circle", changed(20, "-0.2001"), changed(20, "-0.2002")),
    Threshold("a few steps of the last digit", steps(8), steps(7)),
    Threshold("too much, expected one turn", written([*ROWS, (360.25, 0.0)]),
              written([*ROWS, (360.26, 0.0)])),
    Threshold("found a spike", parabola(11), parabola(13)),  # 12 are equal but for rounding
    Threshold("found a spike", parabola(-11), parabola(-13)),
]  # fmt: skip


def faults(folder, text: str) -> str:
    try:
        scene(folder, text)
    except SceneError as error:
        return " ".join(str(fault) for fault in error.faults)
    return ""


@pytest.mark.parametrize("row", READING, ids=[row.words for row in READING])
def test_reading(tmp_path, row):
    assert row.words not in faults(tmp_path, row.within)
    assert row.words in faults(tmp_path, row.beyond)


@pytest.mark.parametrize(
    ("last", "rows"), [(359.76, 360), (359.75, 361), (360.0, 360), (360.25, 360), (359.5, 361)]
)
def test_a_row_a_quarter_of_a_spacing_from_the_turn_is_the_first_once_more(tmp_path, last, rows):
    found = scene(tmp_path, written([*ROWS, (last, 0.0)])).cam.measured
    assert len(found.theta) == rows


@pytest.mark.parametrize(("left_out", "open_end"), [(1, False), (1.5, False), (1.51, True)])
def test_a_table_that_lacks_more_than_a_row_and_a_half_is_of_the_lobe_alone(
    tmp_path, left_out, open_end
):
    """The lift goes on to fall through 360 deg: where the lobe alone is measured, it is open."""
    turned = [(a, (1.0 + cos((a - 200.0) * pi / 180.0)) * 5.0) for a, _ in ROWS]
    text = written([row for row in turned if row[0] < 359.0] + [(360.0 - left_out, 0.302)])
    assert ("an open end (" in faults(tmp_path, text)) is open_end


@pytest.mark.parametrize(
    ("within", "beyond", "read"),
    [
        ("\n" * 80_000, "\n" * 80_001, lambda text: text_lines(text, "t")),
        ("1" * 10_000, "1" * 10_001, lambda text: text_lines(text, "t")),
        (40_000, 40_001, lambda count: refuse_too_many_rows(count, "t")),
    ],
    ids=["lines", "characters", "rows"],
)
def test_sizes(within, beyond, read: Callable):
    read(within)
    with pytest.raises(SceneError, match="expected at most"):
        read(beyond)


def test_equal_lifts_over_ten_degrees_are_a_dwell(tmp_path):
    """A lobe with a top that is flat for so long, in fine digits."""
    for flat, dwells in ((10.0, 2), (9.5, 1)):
        text = table(Lobe(smooth, 60.0, flat), 0.5, decimals=9)
        assert len(scene(tmp_path, text).cam.measured.dwells) == dwells


def test_what_a_fit_is_warned_of(tmp_path):
    accuracy = scene(tmp_path, FINE).cam.accuracy
    calm = replace(accuracy, noise=accuracy.quantum / 12**0.5, largest=0.0, jump_deg=None)
    assert not cautions(calm)
    jump = {"jump_of": "c_theta", "jump": 0.1, "jump_error": 0.01, "jump_sure": 5.0}
    assert cautions(replace(calm, jump_deg=12.0, **jump))
    for key, unit, times in (
        ("noise", accuracy.quantum / 12**0.5, 1.5), ("largest", calm.noise, 6.0)
    ):  # fmt: skip
        assert not cautions(replace(calm, **{key: unit * times * (1.0 - 1e-9)}))
        assert cautions(replace(calm, **{key: unit * times * (1.0 + 1e-9)}))


def raised(least: float) -> str:
    """The lobe of 10 mm of lift, counted from elsewhere."""
    return written([(a, least + b * (10.0 - least) / 10.0) for a, b in ROWS])


def test_radii_are_doubted(tmp_path):
    for least, said in ((0.5, False), (0.5001, True)):
        found = list(doubts(scene(tmp_path, raised(least))))
        assert any("if these are radii" in text for text in found) == said


# -- what `cam init` guesses ---------------------------------------------------------------------


def guessed(rows, title: str = "lift") -> str:
    """The keys and the doubts of a table, as text."""
    text = "deg," + title + "\n" + "".join(f"{a:g},{b}\n" for a, b in rows)
    try:
        found = guess(text.encode(), "t.csv")
    except SceneError as error:
        return " ".join(str(fault) for fault in error.faults)
    return f"{found.keys} {found.unsure}"


def hump(top: float, least: float = 0.0, dip: float = 0.0):
    """Rows whose numbers go from `least` to `top`; one is as low as `dip`."""
    rows = [(a, least + b * (top - least) / 10.0) for a, b in ROWS]
    return [(a, dip if dip and k == 20 else round(b, 9)) for k, (a, b) in enumerate(rows)]


def two(second: float, between: float):
    """A lobe, and another one of a share of its height; between them it comes down so far."""
    rows = []
    for k in range(360):
        one = Lobe(cycloidal, 40.0).at(k + 60.0)[0] * 1e3
        other = Lobe(cycloidal, 40.0).at(k - 60.0)[0] * 1e3 * second
        rows.append((float(k), max(one, other, between * 10.0 if 120 <= k <= 240 else 0.0)))
    return rows


GUESSES = [
    ("'lift': 'mm'", hump(120.0), hump(120.01), True),
    ("'lift': 'thou'", hump(3000.0), hump(3000.1), True),
    ("'lift': 'inch'", hump(1.0), hump(1.001), True),
    ("'lift': 'm'", hump(0.05), hump(0.0501), True),
    ("they are radii", hump(10.0, 0.5), hump(10.0, 0.5001), False),
    ("no column that rises and falls", hump(10.0, dip=-0.2), hump(10.0, dip=-0.2001), False),
    ("comes back 2 times", two(0.1, 0.0), two(0.1001, 0.0), False),
    ("comes back 2 times", two(0.5, 0.02), two(0.5, 0.0199), False),
    ("no 8 rows of numbers", hump(10.0)[::46], hump(10.0)[::52], False),
]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "within", "beyond", "first"), GUESSES, ids=[row[0] for row in GUESSES]
)
def test_guesses(words, within, beyond, first):
    """first: whether it is said at the threshold, and no more beyond it, or the other way round."""
    assert (words in guessed(within)) == first
    assert (words in guessed(beyond)) != first


@pytest.mark.parametrize(
    ("above", "header", "skipped"),
    [
        ("", 0, 0),
        ("deg,lift", 1, 0),
        ("a,b\ndeg,lift", 2, 0),
        ("cam\ndeg,lift", 1, 1),  # fewer cells than a row
        ("a,b,c\ndeg,lift", 1, 1),  # more of them
        ("cam 7,\ndeg,lift", 1, 1),  # one of them empty
        ("500,lift\ndeg,lift", 2, 0),  # one number
        ("500,7\ndeg,lift", 1, 1),  # two: no titles
        ("a,b\nangle,lift [mm]", 2, 0),
        ("a,b\nangle [deg],lift [mm]", 1, 1),  # with their units: what is above is of the file
        ("\n".join(["a,b"] * 3), 3, 0),
        ("\n".join(["a,b"] * 4), 3, 1),
    ],
)
def test_lines_above_the_rows_are_titles_or_skipped(above, header, skipped):
    rows = "".join(f"{a:g},{b}\n" for a, b in hump(10.0))
    found = guess(f"{above}\n{rows}".encode() if above else rows.encode(), "t.csv")
    assert found.keys["header"] == header
    assert found.keys.get("skip_lines", 0) == skipped


@pytest.mark.parametrize(
    ("title", "numbers", "said"),
    [
        ("lift mm", 100.0, False), ("lift mm", 100.001, True),
        ("lift inch", 3.937, False), ("lift inch", 3.9371, True),
    ],
)  # fmt: skip
def test_a_lift_above_a_tenth_of_a_metre_is_doubted(title, numbers, said):
    assert ("but that is a lift of" in guessed(hump(numbers), title)) == said
