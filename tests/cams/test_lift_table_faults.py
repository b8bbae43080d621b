"""Lift tables that cannot be used: every fault says where, what and what to do."""

import os
from random import Random

import pytest

from camcli.cams.lift_reading import units_in_title
from camcli.errors import SceneError
from camcli.scene import load_scene, resolved, scene_hash
from camcli.words.lift_table import cautions
from tests.support.lift_tables import SCENE, Lobe, cycloidal, polynomial, scene, table

TEXT = table(Lobe(cycloidal), 5, decimals=3)
LINES = TEXT.splitlines()
FINE = table(Lobe(cycloidal), 1, decimals=4)


def fault(folder, text, **changes):
    """The first fault of a table, as text, without the folder."""
    with pytest.raises(SceneError) as caught:
        scene(folder, text, **changes)
    return str(caught.value.faults[0]).replace(f"{folder}{os.sep}", "")


def changed(line: int, new: str, text: str = TEXT) -> str:
    """The table with one line (from 1) replaced."""
    lines = text.splitlines()
    lines[line - 1] = new
    return "\n".join(lines) + "\n"


def without(first: int, last: int, text: str = FINE) -> str:
    lines = text.splitlines()
    return "\n".join(lines[: first - 1] + lines[last:]) + "\n"


@pytest.mark.parametrize(
    ("row", "column", "words"),
    [
        ("100,nan", 5, "found 'nan', expected a number, remove the row"),
        ("100, 1..2", 6, "found '1..2', expected a number"),
        ("abc,1.0", 1, "found 'abc', expected a number"),
        ("100,", 5, "found an empty cell, expected a number"),
        ("100,0x12", 5, "found '0x12'"),
        ("100,1_000", 5, "found '1_000'"),
        ("100,1e999", 5, "expected at most 1e9"),
        ("100,1e-99", 5, "expected at most 40 decimals"),
        ("100,٣", 5, "expected a number"),
        ("100", 1, "found 1 cell, expected 2 as in the first row"),
        ("100,1,25", 1, "is the comma a decimal comma?"),
        ("95,1.0", 1, "found the angle 95 again, expected angles that only"),
        ("90,1.0", 1, "found the angle 90 after 95, expected angles that only"),
    ],
)
def test_a_bad_row_is_named_by_line_and_column(tmp_path, row, column, words):
    found = fault(tmp_path, changed(22, row))
    assert found.startswith(f"lift.csv:22:{column}: cam.")
    assert words in found


FILES = [
    ("", "found nothing, expected rows of angle and lift"),
    ("# only\n#comments\n\n", "found no rows"),
    ("\n".join(LINES[:9]), "found 8 rows, expected at least 16"),
    (b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR", "found byte 0x89, expected UTF-8 text, is this a bin"),
    (b"deg,lift\n1,\x00\x01", "lift.csv:2:3: cam.file: found the control character 0x00"),
    (TEXT.replace(",", ";").replace(".", ","), "lift.csv:2:3: cam.file: found a decimal comma: '0"),
    (TEXT.replace(",", " ").replace(".", ","), "write decimal: comma in the section cam"),
    (
        TEXT.replace("deg,lift", "n,deg,lift"),
        "lift.csv:2:1: cam.file: found 2 cells in the first row, and 3 titles in the header",
    ),
    (without(170, 300), "the rows of lines 169 and 170 are 132 deg apart"),
    (without(2, 150), "begins at 149 deg with a lift of 6.1307 mm, an open end"),
    (without(200, 362), "lift.csv:199:5: cam.lift: the table ends at 197 deg with a lift of"),
    (FINE + "361,0\n", "lift.csv:362:1: cam.angle: the table covers 361 deg of cam, 1 too much"),
    (FINE + "360,0.3\n", "the last row is one turn after the first, its lift is 0.3"),
    ("deg,lift\n" + "".join(f"{k},0.0\n" for k in range(360)), "a few steps of the last digit"),
    (changed(22, "20,-1.5", FINE), "found a lift of -1.5 mm, below the base circle"),
    (b"1,2\n" * 2_500_001, "more than 10 MB"),
    ("deg,lift\n" + "1,2\n" * 40_001, "found 40001 rows"),
]


@pytest.mark.parametrize(("text", "words"), FILES, ids=[words[:24] for _, words in FILES])
def test_a_file_that_is_no_table_is_refused(tmp_path, text, words):
    assert words in fault(tmp_path, text)


def test_ends_of_a_table_may_be_off_by_its_last_digit(tmp_path):
    """Of the lobe alone its ends may show one digit; of a whole turn the last row two more."""
    rows = [row.split(",") for row in FINE.splitlines()[1:]]
    lobe = [(int(deg), lift) for deg, lift in rows if float(lift) > 2e-4]
    for digits, refused in ((1, False), (2, True)):
        ends = (lobe[0][0] - 1, f"{digits / 1e4:.4f}"), (lobe[-1][0] + 1, "0.0000")
        text = "deg,lift\n" + "".join(f"{a},{c}\n" for a, c in (ends[0], *lobe, ends[1]))
        if refused:
            assert "an open end" in fault(tmp_path, text)
        else:
            scene(tmp_path, text)
    flank = "deg,lift\n" + "".join(f"{k},{rows[(k + 140) % 360][1]}\n" for k in range(360))
    begin = [round(1e4 * float(row.split(",")[1])) for row in flank.splitlines()[1:3]]
    slope = (begin[1] - begin[0]) // 4  # the angle may be off by a quarter of a row
    assert slope > 20
    for text, first, most in ((FINE, 0, 2), (flank, begin[0], 2 + slope)):
        scene(tmp_path, text + f"360,{(first + most) / 1e4:.4f}\n")
        found = fault(tmp_path, text + f"360,{(first + most + 1) / 1e4:.4f}\n")
        assert "the last row is one turn after the first" in found


def noisy_lobe(first: float, begin: int = 40) -> str:
    """A lobe alone, rows of 2 um scatter from `begin` deg; first: the lift of its first row, mm."""
    random, lobe = Random(7), Lobe(cycloidal)
    rows = [lobe.at(deg)[0] * 1e3 + random.gauss(0.0, 2e-3) for deg in range(begin, 321)]
    rows[0] = first
    return "deg,lift\n" + "".join(f"{begin + k},{lift:.4f}\n" for k, lift in enumerate(rows))


def test_ends_on_the_base_circle_may_scatter_as_their_neighbours_do(tmp_path):
    """Five standard deviations of the rows beside them: 5 um are within, 30 um are not."""
    flank = next(k for k in range(360) if Lobe(cycloidal).at(k)[0] > 1e-3)
    top = Lobe(cycloidal).at(flank)[0] * 1e3
    for text in (noisy_lobe(0.005), noisy_lobe(-0.005)):
        cam = scene(tmp_path, text).cam
        assert abs(max(cam.measured.lift) - Lobe(cycloidal).at(180)[0]) < 8e-6
        between = [q for deg, q in zip(cam.measured.theta, cam.measured.lift, strict=True)
                   if deg > 320 or deg < 40]  # fmt: skip
        assert len(between) == 79
        assert not any(between)
    for text in (noisy_lobe(0.03), noisy_lobe(top, flank)):
        found = fault(tmp_path, text)
        assert "an open end" in found
        assert "or set the ends to 0 if they are on the base circle" in found


def test_an_open_end_is_told_as_measured(tmp_path):
    rows = [f"{deg},{Lobe(cycloidal).at(deg)[0] * 1e3:.4f}" for deg in range(130, 231)]
    first, last = (float(row.split(",")[1]) for row in (rows[0], rows[-1]))
    rows[-1] = f"230,{last + 0.0016:.4f}"
    found = fault(tmp_path, "deg,lift\n" + "\n".join(rows), subtract=first)
    told = f"with a lift of {last + 0.0016:.6g} mm ({last + 0.0016 - first:.6g} mm after subtract"
    assert told in found


def test_bad_rows_of_one_cause_are_one_fault(tmp_path):
    rows = [f"{line.split(',')[0]},x" for line in LINES[1:]]
    rows[7] = "35,nan"
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, "\n".join([LINES[0], *rows]))
    first, others, nan = (fault.found for fault in caught.value.faults)
    assert (first, others, nan) == ("found 'x'", "found 'x', and 69 more like it", "found 'nan'")


@pytest.mark.parametrize("line", [120, 182, 300])
@pytest.mark.parametrize("off", [0.02, -0.02, 0.5])
def test_a_spike_is_named_and_a_smaller_one_warned_of(tmp_path, line, off):
    deg, lift = FINE.splitlines()[line - 1].split(",")
    found = fault(tmp_path, changed(line, f"{deg},{float(lift) + off:.4f}", FINE))
    assert found.startswith(f"lift.csv:{line}:1: cam.lift: found a spike: the row is ")
    assert float(found.split("the row is ")[1].split()[0]) == pytest.approx(off, rel=0.02)
    if line == 182:
        cam = scene(tmp_path, changed(line, f"{deg},{float(lift) + 0.0009:.4f}", FINE)).cam
        assert any(f"line {line} of the table" in text for text in cautions(cam.accuracy))


@pytest.mark.parametrize("law", [polynomial, cycloidal])
@pytest.mark.parametrize(("step", "um"), [(5, 0), (6, 0), (1, 10), (3, 10), (5, 50)])
def test_rows_too_far_apart_are_told_from_rows_that_scatter(tmp_path, law, step, um):
    """Exact rows of a flank of 70 deg, or rows with normal noise."""
    rng, lobe = Random(2), Lobe(law)
    rows = [(deg, 1e3 * lobe.at(deg)[0]) for deg in range(0, 360, step)]
    text = "deg,lift\n" + "\n".join(
        f"{deg},{lift + (rng.gauss(0.0, 1e-3 * um) if lift else 0.0):.4f}" for deg, lift in rows
    )
    (said,) = (words for words in cautions(scene(tmp_path, text).cam.accuracy) if "times" in words)
    if um:
        assert said.startswith("warning: the table scatters by ")
        assert float(said.split()[5]) == pytest.approx(um, rel=0.4)
    else:
        assert said.startswith(f"warning: the rows are {step} deg apart, too far for this cam")


@pytest.mark.parametrize("law", [polynomial, cycloidal, lambda x: (x, 0.0), lambda x: (x * x, 2.0)])
@pytest.mark.parametrize(("step", "decimals"), [(1, 2), (1, 4), (0.5, 6), (5, 3)])
def test_corners_of_a_cam_are_no_spikes(tmp_path, law, step, decimals):
    """Jumps of c_thetatheta, and even of c_theta, between rows and at rows."""
    for flank in (70.0, 66.63):
        scene(tmp_path, table(Lobe(law, flank, 20.0), step, decimals=decimals))


NO_HEADER = {"header": "false"}
KEYS = [
    ({"lift": "m"}, "found a largest lift of 10 m, suspiciously large, expected 0.0001 to 1 m"),
    ({"rocker_ratio": 0.001}, "found a largest lift of 1e-05 m, suspiciously small"),
    ({"angle": "crank"}, "expected one turn, or zero lift at both ends"),
    ({"lift_column": 3}, "lift.csv: cam.lift_column: found column 3, expected 1 to 2"),
    ({"lift_column": "hub"}, "found no column 'hub', expected one of 'deg', 'lift', copy the name"),
    ({"lift_column": "deg"}, "angle_column and lift_column are both column 1"),
    (NO_HEADER, "found the name 'deg' for a column of a file without header"),
    ({**NO_HEADER, "angle_column": 1, "lift_column": 2}, "write header: true"),
    ({"sha256": "0" * 64}, "this is not the file the scene was made for"),
    ({"lift": "fraction"}, "lift: fraction and max_lift belong together"),
    ({"max_lift": 0.01}, "lift: fraction and max_lift belong together"),
    ({"lift": "cm"}, "found 'cm', expected one of m, mm, um, inch, thou, fraction"),
    ({"smoothing": -1}, "expected a number of at least 0"),
]


def test_a_header_with_another_unit_than_the_scene_is_refused(tmp_path):
    text = FINE.replace("deg,lift", "deg,lift_inch", 1)
    said = "cam.lift: found 'mm', and a lift in 'inch' in the file's header"
    assert said in fault(tmp_path, text, lift_column="lift_inch")
    with pytest.raises(SceneError, match=r"suspiciously|largest"):  # the unit itself is agreed on
        scene(tmp_path, text, lift_column="lift_inch", lift="inch", rocker_ratio=1000)


TITLES = {
    "lift in mm": ["mm"], "hub in um": ["um"], "Hub in mm": ["mm"], "lift in [mm]": ["mm"],
    "lift_in": ["inch"], "lift (in)": ["inch"], "lift, in.": ["inch"], "lift in": ["inch"],
    "lift in inches": ["inch"], 'lift in 0.001 "': ["thou"], "lift .001 in": ["thou"],
    "thousandths of an inch": ["thou"], "millimeter": ["mm"], "micrometre": ["um"],
    "metres": ["m"], "1/1000 mm": ["um"], "thousandths of a millimetre": ["um"],
    "lift 0.001 mm": ["um"], "lift 10.001 mm": ["mm"],
    "lift mm (in)": ["mm", "inch"], "lift in thou": ["thou"],
    "lift": [], "lift in file": [], "parameter": [],
}  # fmt: skip


@pytest.mark.parametrize("title", TITLES)
def test_a_title_names_the_unit_that_a_reader_finds_in_it(title):
    assert units_in_title(title) == TITLES[title]


def test_inches_of_a_title_that_says_in_mm_are_refused(tmp_path):
    said = "cam.lift: found 'inch', and a lift in 'mm' in the file's header"
    text = FINE.replace("deg,lift", "deg,lift in mm", 1)
    assert said in fault(tmp_path, text, lift_column="lift in mm", lift="inch")
    text = FINE.replace("deg,lift", "deg,lift mm (in)", 1)
    said = "cam.lift: found 'um', and a lift in 'mm' or 'inch' in the file's header"
    assert said in fault(tmp_path, text, lift_column="lift mm (in)", lift="um")


@pytest.mark.parametrize(("changes", "words"), KEYS, ids=[str(changes) for changes, _ in KEYS])
def test_a_scene_that_reads_the_table_wrongly_is_refused(tmp_path, changes, words):
    lobe = table(Lobe(cycloidal), 1, low=130, high=230) if "angle" in changes else FINE
    assert words in fault(tmp_path, lobe, **changes)


def test_nothing_is_guessed_that_the_scene_leaves_out(tmp_path):
    (tmp_path / "lift.csv").write_text(TEXT)
    (tmp_path / "scene.yaml").write_text(SCENE.partition("  kind: table")[0] + "  kind: table\n")
    with pytest.raises(SceneError) as caught:
        load_scene(tmp_path / "scene.yaml")
    assert {f.found: f.cure.partition(" (")[0] for f in caught.value.faults} == {
        f"no key '{key}'": f"add '{key}: ...'"
        for key in ("file", "header", "angle_column", "lift_column", "angle", "lift", "zero_deg",
                    "direction", "base")
    }  # fmt: skip
    body = TEXT.partition("\n")[2]
    found = fault(tmp_path, body, angle_column=1, lift_column=2)
    assert "lift.csv:1:1: cam.header: found a header of numbers" in found


def test_the_scene_s_hash_depends_on_the_file(tmp_path):
    one = scene(tmp_path, TEXT)
    two = scene(tmp_path, TEXT + "# a word\n")
    assert scene_hash(one) != scene_hash(two)
    assert resolved(one)["cam"]["sha256"] == one.cam.sha256
    assert scene_hash(scene(tmp_path, TEXT, sha256=one.cam.sha256)) == scene_hash(one)
