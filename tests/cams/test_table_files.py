"""Lift tables as measuring machines, spreadsheets and cam grinders write them, through cam init."""

import random
from functools import cache

import numpy as np
import pytest

from camcli.analysis.contact_loss.detachment import detachment
from camcli.api.lift_table import table_record
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.cams.lift_tables import Eccentric, Lobe, cycloidal, polynomial, smooth, table
from tests.cams.lift_tables import scene as table_scene

LOBE, ROUND = Lobe(smooth), Eccentric()
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
}  # fmt: skip


FITTED = ("dial gauge", "noise", "an eccentric", "quoted cells")  # one of each law
UNSURE = {"plain csv": True, "no header": True, "german spreadsheet": False, "comments": True,
          "units in a second line": False, "ten-thousandths of an inch": False}  # fmt: skip


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
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in FITTED[1:3])) for n in FILES]
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
    assert name not in UNSURE or ("CHECK lift" in said) == UNSURE[name]
    if name == "plain csv":
        assert (tmp_path / "cam.png").read_bytes()[:4] == b"\x89PNG"
    if name in FITTED:
        system = System.build(FOLLOWER, scene.cam)
        low, high = table_record(scene.cam, system)["first_detachment_rpm"]
        assert low < truth(law) < high
        assert high - low < 0.14 * truth(law)
