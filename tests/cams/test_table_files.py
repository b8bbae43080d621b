"""Lift tables as measuring machines, spreadsheets and cam grinders write them, through cam init."""

import json
import random
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from camcli.analysis.contact_loss.detachment import detachment
from camcli.api.lift_table import table_record
from camcli.cams.lift_guess import guess
from camcli.errors import SceneError
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import some_in_ci
from tests.support.lift_tables import Eccentric, Lobe, cycloidal, polynomial, smooth, table
from tests.support.lift_tables import scene as table_scene

LOBE, ROUND = Lobe(smooth), Eccentric()
THOU = 0.0254e-3
OTHER = Lobe(cycloidal)
WIDE = Lobe(polynomial, 60, 40)
FOLLOWER = Follower(0.12, 42000.0, 12.0, 0.0, 260.0, 0.4)


def rows(angles, lobe=LOBE, unit=1e-3, form="{:g},{:.4f}", scale=1.0, shift=0.0, noise=0.0):
    """A line for each angle (deg in the file): angle, and lift at angle * scale + shift."""
    rng = random.Random(5)
    lifts = [lobe.at(a * scale + shift)[0] / unit for a in angles]
    lifts = [x + rng.gauss(0, noise) * (x > 0) for x in lifts]
    return [form.format(a, x) for a, x in zip(angles, lifts, strict=True)]


def german(lines):
    return [line.replace(",", ";").replace(".", ",") for line in lines]


def quoted(lines):
    """A whole number without quotes, as they are needed only for a comma."""
    cells = [line.replace(".0000", "").split(",") for line in lines]
    cells = [[f'"{c}"'.replace(".", ",") if "." in c else c for c in row] for row in cells]
    return [",".join(row) for row in cells]


def two_lobes():
    other = Lobe(smooth, 60)
    for k in range(360):
        yield f"{k},{LOBE.at(k)[0] * 1e3:.4f},{other.at(k + 110)[0] * 1e3:.4f}"


class Radii(NamedTuple):
    """The lobe on a base circle of 18 mm."""

    base: float = 0.018

    def at(self, deg):
        return self.base + LOBE.at(deg)[0], 0.0


RADII = Radii()


TURN, CRANK = range(360), range(0, 720, 2)
HALF = [k / 2 for k in range(720)]
FILES = {  # lines (or bytes), the law, zero of the file in deg of the cam, keys that are expected
    "plain csv": (["deg,lift", *rows(TURN)], LOBE, 0, {"header": 1, "lift_column": "lift"}),
    "no header": (rows(TURN), LOBE, 0, {"header": 0, "angle_column": 1}),
    "german spreadsheet": (
        ("\ufeff" + "\r\n".join(german(["Winkel NW,Hub mm", *rows(TURN)]))).encode(), LOBE, 0,
        {"decimal": "comma", "angle_column": "Winkel NW", "lift": "mm"}),
    "spreadsheet's unicode text": (
        "\r\n".join(["Winkel °KW\tHub (mm)", *rows(CRANK, scale=0.5, form="{:g}\t{:.4f}")])
        .replace(".", ",").encode("utf-16"), LOBE, 0, {"angle": "crank", "decimal": "comma"}),
    "letters of Windows": (
        "\r\n".join(["Prüfprotokoll;;", "Winkel (° NW);Hub (mm)", *german(rows(TURN))])
        .encode("cp1252"), LOBE, 0,
        {"decimal": "comma", "skip_lines": 1, "angle_column": "Winkel (° NW)"}),
    "separator told": (
        ["sep=;", *german(["angle cam,lift mm", *rows(TURN)])], LOBE, 0, {"skip_lines": 0}),
    "units in a second line": (
        ["Cam angle,Valve lift", "deg,mm", *rows(TURN)], LOBE, 0, {"header": 2, "lift": "mm"}),
    "comments": (["# gauge 3", "deg,lift # mm", *rows(TURN)], LOBE, 0, {"header": 1}),
    "protocol of a machine": (
        ["CAMSHAFT REPORT", "Part: 4711", "Date: 3.2.2021  12:30", "", "Angle  Lift",
         *rows(HALF, form="{:8.2f}  {:9.5f}")], LOBE, 0, {"header": 1, "skip_lines": 4}),
    "falling angles": (["deg,lift", *rows(range(359, -1, -1))], LOBE, 0, {}),
    "angles from elsewhere": (["deg,lift", *rows(range(-90, 270), shift=90)], LOBE, 90, {}),
    "angles through zero": (["deg,lift", *rows([*range(200, 360), *range(200)])], LOBE, 0, {}),
    "crank, both sides of the nose": (
        ["crank deg,lift", *rows(range(-360, 361, 2), scale=0.5, shift=180)], LOBE, 180,
        {"angle": "crank"}),
    "crank, closed": (["a,lift", *rows(range(0, 721, 2), scale=0.5)], LOBE, 0, {"angle": "crank"}),
    "the lobe alone": (["cam deg,lift", *rows(range(-75, 76), shift=180)], LOBE, 180, {}),
    "ten-thousandths of an inch": (
        ["deg,lift inch", *rows(TURN, unit=0.0254)], LOBE, 0, {"lift": "inch"}),
    "powers of ten": (rows(TURN, unit=1.0, form=" {:.4E}  {:.6E}"), LOBE, 0, {"lift": "m"}),
    "a counter before": (
        ["n,deg,lift", *(f"{n},{line}" for n, line in enumerate(rows(TURN)))], LOBE, 0,
        {"angle_column": "deg", "lift_column": "lift"}),
    "velocity behind": (
        ["deg,mm,mm/deg", *(f"{row},{k % 7 - 3}" for k, row in enumerate(rows(TURN)))], LOBE, 0,
        {"lift_column": "mm"}),
    "dial gauge": (["deg,lift", *rows(range(0, 360, 2), WIDE, form="{:g},{:.2f}")], WIDE, 0, {}),
    "noise": (["deg,lift", *rows(TURN, noise=0.001)], LOBE, 0, {}),
    "an eccentric": (["deg,lift", *rows(TURN, ROUND, form="{:g},{:.3f}")], ROUND, 0, {}),
    "quoted cells": (
        ['"deg","lift"', *rows(TURN, OTHER, form='"{:g}","{:.4f}"')], OTHER, 0,
        {}),
    "decimal commas in quotes": (  # as a spreadsheet writes them that separates by commas
        ['Winkel,"Hub, mm"', *quoted(rows(TURN))], LOBE, 0,
        {"decimal": "comma", "lift_column": "Hub, mm"}),
    "thousandths of an inch": (
        ["deg,lift (thou)", *rows(TURN, unit=THOU, form="{:g},{:.1f}")], LOBE, 0,
        {"lift": "thou"}),
    "thousandths by their size": (
        ["deg,lift", *rows(TURN, unit=THOU, form="{:g},{:.1f}")], LOBE, 0, {"lift": "thou"}),
    "micrometres": (["deg,lift", *rows(TURN, unit=1e-6, form="{:g},{:.0f}")], LOBE, 0,
                    {"lift": "um"}),
    "hundredths of a millimetre": (
        ["deg;Hub 1/100 mm", *german(rows(TURN, unit=1e-5, form="{:g},{:.1f}"))], LOBE, 0,
        {"lift": "fraction", "max_lift": 1e-5}),
    "two lobes": (["deg,Intake,Exhaust", *two_lobes()], LOBE, 0, {"lift_column": "Intake"}),
    "two units": (
        ["deg,inch,mm", *(f"{k},{LOBE.at(k)[0] / 0.0254:.5f},{LOBE.at(k)[0] * 1e3:.4f}"
                          for k in TURN)], LOBE, 0, {"lift": "inch"}),
    "radii": (["deg,R mm", *rows(TURN, RADII)], LOBE, 0, {"subtract": 18.0, "base_radius": 0.018}),
    "radii of the lobe alone": (
        ["cam deg,R inch", *rows(range(-75, 76), Radii(0.7 * 0.0254), shift=180, unit=0.0254)],
        LOBE, 180,
        {"lift": "inch", "subtract": 0.7}),
    "from the nose": (["deg,lift", *rows(TURN, shift=180)], LOBE, 180, {}),
    "of a valve": (["deg,Valve lift mm", *rows(TURN)], LOBE, 0, {"measured_at": "valve"}),
    "of a lobe": (["deg,Lobe lift mm", *rows(TURN)], LOBE, 0, {"measured_at": "lobe"}),
    "after another table": (
        ["deg,Exhaust", *rows(range(100, 260)), "deg,Intake mm", *rows(TURN)], LOBE, 0,
        {"skip_lines": 161, "lift_column": "Intake mm"}),
}  # fmt: skip


FITTED = ("dial gauge", "noise", "an eccentric", "quoted cells")  # one of each law
UNSURE = {"plain csv": True, "no header": True, "german spreadsheet": False, "comments": True,
          "units in a second line": False, "ten-thousandths of an inch": False}  # fmt: skip


OF_A_VALVE = ("of a valve", "units in a second line")
SAID = {  # CHECK lines; where a file is not here none but those of the unit and a rocker are
    "thousandths by their size": "CHECK lift: thou is a guess: the largest number is 393.7: as "
    "thousandths of an inch a lift of 10 mm, as mm one of 0.3937 m",
    "micrometres": "CHECK lift: um is a guess: the largest number is 10000, too large",
    "hundredths of a millimetre": "CHECK lift: fraction is a guess: hundredths of a millimetre",
    "two lobes": "CHECK lift_column: Intake is a guess: column 3 'Exhaust' rises and falls too, "
    "another lobe: it has a scene of its own",
    "two units": "CHECK lift_column: inch is a guess: column 3 'mm' is 25.4 times this one: the "
    "same lobe in another unit, or behind a rocker",
    "radii": "CHECK subtract: 18.0 is a guess: the numbers go from 18 to 28, so they are radii",
    "radii of the lobe alone": "CHECK subtract: 0.7 is a guess: the numbers go from 0.7 to "
    "1.0937, so they are radii",
    "after another table": "CHECK skip_lines: 161 is a guess: lines 2 to 161 are another table",
    "of a lobe": "CHECK rocker_ratio: 1 is a guess: taken without a rocker; if there is one",
    "plain csv": "CHECK rocker_ratio: 1 is a guess: taken without a rocker; if there is one",
}


def written(name, folder, cam):
    """(output, scene) of cam init for one of the files."""
    data, _, zero, _ = FILES[name]
    if not isinstance(data, bytes):
        data = ("\n".join(data) + "\n").encode()
    (folder / "cam.csv").write_bytes(data)
    done = cam("init cam.csv", "" if name == "plain csv" else "--no-plot", code=0)
    path = folder / "cam.yaml"
    path.write_text(path.read_text().replace("zero_deg: 0", f"zero_deg: {zero}"))
    return done.stdout, load_scene(path)


@pytest.fixture(scope="module")
def truth(tmp_path_factory):
    """First detachment (rpm) of a law, from a table of 12 digits every half degree."""

    @cache
    def solved(law):
        exact = table_scene(tmp_path_factory.mktemp("exact"), table(law, 0.5, 1e-3, 12)).cam
        return detachment(System.build(FOLLOWER, exact)).first.rpm

    return solved


@pytest.mark.parametrize(
    "name",
    some_in_ci(
        FILES,
        quick=[
            "german spreadsheet",
            "units in a second line",
            "the lobe alone",
            "dial gauge",
            "quoted cells",
            "two lobes",
            "radii",
            "after another table",
        ],
    ),
)
def test_a_table_is_read_as_it_was_written(name, tmp_path, cam, truth):
    """And the interval of the first detachment holds that of the law."""
    _, law, _, keys = FILES[name]
    said, scene = written(name, tmp_path, cam)
    read = scene.cam.model_dump()
    assert {key: read[key] for key in keys} == keys
    turn = scene.cam.measured
    true = np.array([law.at(theta)[0] for theta in turn.theta])
    assert np.abs(turn.lift - true).max() < (5e-6 if name == "noise" else 0.51 * turn.quantum)
    assert len(turn.lift) >= 150
    assert name not in UNSURE or ("CHECK lift:" in said) == UNSURE[name]
    assert SAID.get(name, "") in said
    checked = set(re.findall("CHECK ([a-z_]+)", said))
    usual = {"lift", "rocker_ratio", "measured_at", "angle"}
    assert checked <= usual | {SAID.get(name, "CHECK -").split()[1][:-1]}
    assert ("measured_at" in checked) == ("rocker_ratio" in checked)
    assert ("CHECK rocker_ratio" in said) != (name in OF_A_VALVE)
    marked = set(re.findall("  ([a-z_]+): .*# CHECK", (tmp_path / "cam.yaml").read_text()))
    assert marked == checked | {"rpm"}  # a working speed is made up for every machine
    if name == "plain csv":
        assert (tmp_path / "cam.png").read_bytes()[:4] == b"\x89PNG"
    if name in FITTED:
        system = System.build(FOLLOWER, scene.cam)
        low, high = table_record(scene.cam, system)["first_detachment_rpm"]
        assert low < truth(law) < high
        assert high - low < 0.14 * truth(law)


def stacked(*more):
    return ["deg,Intake", *rows(TURN), *more, *rows(TURN, Lobe(smooth, 60))]


def without(line, *new):
    """The plain table with a line (from 1) replaced."""
    lines = ["deg,lift", *rows(TURN)]
    return [*lines[: line - 1], *new, *lines[line:]]


REFUSED = {
    "a bad lift": (without(101, "99,x1.2"), "cam.csv:101:4: found 'x1.2', expected a number, corr"),
    "a bad angle": (without(101, "9g,1.2"), "cam.csv:101:1: found '9g', expected a number"),
    "an empty lift": (without(101, "99,"), "cam.csv:101:4: found an empty cell"),
    "two bad rows": (without(101, "99,-", "99.5,-"), "found '-', and 1 more like it, expected"),
    "a row of words": (without(101, "n/a,n/a"), "cam.csv:101:1: found 'n/a'"),
    "a bad row near the end": (without(359, "357,?"), "cam.csv:359:5: found '?'"),
    "a bad row near the beginning": (without(3, "1,?"), "cam.csv:3:3: found '?'"),
    "the first row": (without(2, "0,---"), "cam.csv:2:3: found '---'"),
    "the last row": (without(361, "359,n/a"), "cam.csv:361:5: found 'n/a'"),
    "a longer row": (without(101, "99,1,2"), "cam.csv:101: found 3 cells, expected 2"),
    "with a counter": (
        ["n,deg,lift", *(f"{k},{'99,' if k == 99 else row}" for k, row in enumerate(rows(TURN)))],
        "cam.csv:101:7: found an empty cell"),
    "falling": (["deg,lift", *rows(range(359, 200, -1)), "200,x", *rows(range(199, -1, -1))],
                "cam.csv:161:5: found 'x'"),
    "through zero": (["deg,lift", *rows(range(200, 360)), "0,x", *rows(range(1, 200))],
                     "cam.csv:162:3: found 'x'"),
    "a footer": ([*rows(TURN), "Ende"], "cam.csv:361: found 1 cell, expected 2"),
    "another table below": (
        stacked("deg,Exhaust"), "cam.csv:363: rows of numbers begin again at 0, expected"),
    "another table without a title": (
        stacked(), "cam.csv:362: the angle begins again at 0, expected one table in a file"),
    "another lobe below": (
        ["deg,lift", *rows(range(110, 250)), *rows(range(110, 250))],
        "cam.csv:142: the angle begins again at 110"),
    "no numbers": ([f"a{row}" for row in rows(TURN)], "and 'a0' in line 1, expected a table of"),
    "thousands": (  # of what a person cannot tell
        ["deg,lift", *(f'{k},"6,798.3"' for k in TURN)], "and '6,798.3' in line 2, expected"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_row_that_cannot_be_read_is_named_and_nothing_is_written(name, tmp_path, cam):
    lines, said = REFUSED[name]
    (tmp_path / "cam.csv").write_text("\n".join(lines) + "\n")
    done = cam("init cam.csv --no-plot")
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["cam.csv"]


def test_what_stands_above_the_titles_is_no_title(tmp_path, cam):
    """A spreadsheet with a name and a date above titles that have their units in brackets."""
    lines = ["Messprotokoll 4711;;", "Datum;12.03.2024;", "Nockenwinkel [deg];Hub [mm];Bemerkung"]
    lines += [f"{line};" for line in german(rows(range(360)))]
    (tmp_path / "lobe.csv").write_text("\n".join(lines))
    keys = json.loads(cam("init lobe.csv --no-plot --json", code=0).stdout)["keys"]
    assert {key: keys[key] for key in ("header", "skip_lines", "angle_column", "lift_column")} == {
        "header": 1, "skip_lines": 2, "angle_column": "Nockenwinkel [deg]",
        "lift_column": "Hub [mm]",
    }  # fmt: skip


def test_two_lobes_in_one_column_are_seen(tmp_path, cam):
    pair = [LOBE.at(k)[0] + LOBE.at(k + 150)[0] for k in TURN]
    text = "deg,lift mm\n" + "".join(f"{k},{1e3 * x:.4f}\n" for k, x in enumerate(pair))
    (tmp_path / "cam.csv").write_text(text)
    done = cam("init cam.csv --no-plot", code=0)
    said = "CHECK lift_column: lift mm is a guess: it rises from zero and comes back 2 times"
    assert said in done.stdout


@pytest.mark.ci
def test_a_run_tells_of_guesses_that_nobody_has_looked_at(tmp_path, cam):
    (tmp_path / "cam.csv").write_text("\n".join(["deg,lift", *rows(TURN)]) + "\n")
    cam("init cam.csv --no-plot", code=0)
    path = tmp_path / "cam.yaml"
    lines = path.read_text().splitlines()
    numbers = ", ".join(str(k) for k, line in enumerate(lines, 1) if "CHECK" in line)
    done = cam("simulate --dry-run -c cam.yaml", code=0)
    assert f"note: cam.yaml: lines {numbers}: CHECK: guesses of cam init; correct" in done.stderr
    path.write_text(path.read_text().replace("CHECK", "seen"))
    assert "CHECK" not in cam("simulate --dry-run -c cam.yaml", code=0).stderr


FILLED = {"mass": 0.12, "stiffness": 42000, "preload": 260, "damping": 12}


@pytest.mark.ci
def test_a_table_of_the_lobe_is_not_taken_for_the_valve_s_without_a_word(tmp_path, cam, truth):
    """A lobe of 0.3 inch under a rocker of 1.6."""
    lobe = Lobe(smooth, 60, 0, 0.3 * 0.0254)
    lines = ["deg,lift inch", *rows(TURN, lobe, unit=0.0254)]
    (tmp_path / "cam.csv").write_text("\n".join(lines) + "\n")
    said = cam("init cam.csv --no-plot", code=0).stdout
    assert "CHECK rocker_ratio: 1 is a guess: taken without a rocker; if there is one" in said
    path = tmp_path / "cam.yaml"
    spring = " ".join(f"--set follower.{k}={v}" for k, v in FILLED.items())
    detach = f"detach -c cam.yaml --no-plot --points 2 --rpm 2000:2100 {spring}"

    def first(words):
        return float(cam(words, code=0).stdout.split("up to ")[1].split()[0])

    wrong = first(detach)
    path.write_text(path.read_text().replace("rocker_ratio: 1 ", "rocker_ratio: 1.6 "))
    right = first(detach)
    assert right == pytest.approx(truth(Lobe(smooth, 60, 0, 1.6 * 0.3 * 0.0254)), rel=0.02)
    assert wrong > 1.1 * right


@pytest.mark.parametrize(("content", "code"), [(None, 0), (b"deg,lift\n", 2), (b"", 2)])
def test_a_copy_of_the_table_is_written_over_no_other_file(tmp_path, cam, content, code):
    data = ("\n".join(["deg,lift", *rows(TURN)]) + "\n").encode()
    (tmp_path / "cam.csv").write_bytes(data)
    there = tmp_path / "new" / "cam.csv"
    there.parent.mkdir()
    there.write_bytes(data if content is None else content)
    done = cam("init cam.csv --no-plot -o new --force")
    assert done.returncode == code, done.stderr
    assert ("that is no copy of the table" in done.stderr) == (code == 2)
    assert there.read_bytes() == (data if content is None else content)


@pytest.mark.parametrize(("off", "alike"), [(0.008, True), (0.012, False), (0.05, False)])
def test_a_column_that_differs_by_a_hundredth_of_the_lift_is_another_lobe(
    tmp_path, cam, off, alike
):
    lift = [1e3 * LOBE.at(k)[0] for k in TURN]
    top = max(lift)
    other = [x + off * 4.0 * x * (top - x) / top for x in lift]  # off at half the lift, of all
    lines = [f"{k},{a:.4f},{3 * b:.4f}" for k, a, b in zip(TURN, lift, other, strict=True)]
    (tmp_path / "cam.csv").write_text("\n".join(["deg,Intake,Exhaust", *lines]) + "\n")
    said = cam("init cam.csv --no-plot", code=0).stdout
    assert ("column 3 'Exhaust' is 3 times this one" in said) == alike
    assert ("column 3 'Exhaust' rises and falls too, another lobe" in said) != alike


def test_every_doubt_about_a_key_is_told(tmp_path, cam):
    """Three columns of lift: two others that this scene leaves out."""
    lines = [f"{k},{1e3 * LOBE.at(k)[0]:.4f},{1e3 * LOBE.at(k - 40)[0]:.4f},"
             f"{1e3 * LOBE.at(k + 40)[0]:.4f}" for k in TURN]  # fmt: skip
    (tmp_path / "cam.csv").write_text("\n".join(["deg,one,two,three", *lines]) + "\n")
    said = cam("init cam.csv --no-plot", code=0).stdout
    for name in ("column 3 'two'", "column 4 'three'"):
        assert f"{name} rises and falls too, another lobe" in said


def test_two_lobes_in_a_file_have_a_scene_each(tmp_path, cam):
    (tmp_path / "cam.csv").write_text("\n".join(["deg,Intake mm,Exhaust mm", *two_lobes()]) + "\n")
    done = cam("init cam.csv --no-plot", code=0)
    assert "cam-exhaust-mm.yaml: fill in mass and spring" in done.stdout
    intake, exhaust = (
        load_scene(tmp_path / name).cam for name in ("cam.yaml", "cam-exhaust-mm.yaml")
    )
    assert (intake.lift_column, exhaust.lift_column) == ("Intake mm", "Exhaust mm")
    for own, column in ((intake, 1), (exhaust, 2)):
        wanted = [float(row.split(",")[column]) for row in two_lobes()]
        assert max(own.measured.lift) == pytest.approx(1e-3 * max(wanted))
    checks = [
        {line.split(":")[0].strip() for line in text.splitlines() if "# CHECK" in line}
        for text in ((tmp_path / name).read_text() for name in ("cam.yaml", "cam-exhaust-mm.yaml"))
    ]
    assert checks[0] - checks[1] == {"lift_column"}  # the scene of the other lobe is of no choice
    assert "rocker_ratio" in checks[1]
    again = cam("init cam.csv --no-plot")
    assert again.returncode == 2
    assert "found a file of this name" in again.stderr
    assert json.loads(cam("init cam.csv --no-plot --force --json", code=0).stdout)["files"] == [
        "cam.yaml", "cam-exhaust-mm.yaml",
    ]  # fmt: skip


@pytest.mark.parametrize("rising", [True, False])
def test_one_flank_is_mirrored_only_where_that_is_told(tmp_path, cam, rising):
    half = list(range(-75, 1)) if rising else list(range(76))
    lines = [f"{k + 20},{1e3 * LOBE.at(k + 180)[0]:.4f}" for k in half]
    (tmp_path / "cam.csv").write_text("\n".join(["cam deg,lobe lift mm", *lines]) + "\n")
    done = cam("init cam.csv --no-plot", code=0)
    assert "CHECK mirrored: False is a guess: the lift only rises or only falls" in done.stdout
    path = tmp_path / "cam.yaml"
    refused = cam("simulate -c cam.yaml --dry-run", code=2)
    assert "Of one flank of a symmetric lobe write mirrored: true" in refused.stderr
    path.write_text(path.read_text().replace("mirrored: false", "mirrored: true "))
    turn = load_scene(path, {"cam.zero_deg": 160.0}).cam.measured
    true = np.array([LOBE.at(theta)[0] for theta in turn.theta])
    assert np.abs(turn.lift - true).max() < 0.51 * turn.quantum
    assert (turn.line > 0).sum() == 2 * 76 - 1


def test_a_whole_lobe_is_not_mirrored(tmp_path, cam):
    (tmp_path / "cam.csv").write_text("\n".join(["deg,lift mm", *rows(TURN)]) + "\n")
    cam("init cam.csv --no-plot", code=0)
    done = cam("simulate -c cam.yaml --dry-run --set cam.mirrored=true", code=2)
    assert "inside the table, expected it at one end: a flank" in done.stderr
    assert "cam.mirrored" in done.stderr


@pytest.mark.parametrize(("rows", "read"), [(200, True), (201, False)])
def test_a_file_of_too_many_rows_is_not_guessed(rows, read):
    """Before it is looked at as a cam; lines that are no rows do not count."""
    text = "made on Monday\nangle,lift\n"
    text += "\n".join(f"{k},{max(0, 60 - abs(k - 100)) / 10}" for k in range(rows))
    if read:
        assert guess(text.encode(), "t.csv", 200)
    else:
        with pytest.raises(SceneError, match="found 201 rows, expected at most 200"):
            guess(text.encode(), "t.csv", 200)


def test_a_link_beside_the_scene_that_leads_elsewhere_is_a_file_elsewhere(tmp_path):
    """And a folder that is itself a link holds its own files."""
    configs = Path(__file__).parents[2] / "configs"
    home, away = tmp_path / "home", tmp_path / "away"
    home.mkdir()
    away.mkdir()
    for folder in (home, away):
        (folder / "lift.csv").write_text((configs / "valve-lift.csv").read_text())
    (home / "link.csv").symlink_to(away / "lift.csv")
    (tmp_path / "door").symlink_to(home)
    text = (configs / "lift-table.yaml").read_text()
    for folder in (home, tmp_path / "door"):
        (folder / "scene.yaml").write_text(text.replace("valve-lift.csv", "lift.csv"))
        assert load_scene(folder / "scene.yaml").cam.kind == "table"
    (home / "scene.yaml").write_text(text.replace("valve-lift.csv", "link.csv"))
    with pytest.raises(SceneError, match="found a file outside the scene's folder"):
        load_scene(home / "scene.yaml")
