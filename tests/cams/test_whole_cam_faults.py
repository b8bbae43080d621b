"""Why a cam, its file or its machine cannot be: the whole line, with numbers worked out here."""

from __future__ import annotations

import hashlib
import os
from math import acos, degrees, inf

import pytest

from camcli.analysis.labels import from_plain
from camcli.cams.eccentric import EccentricCam
from camcli.errors import SceneError
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.support.lift_tables import Lobe, cycloidal, scene, table

FINE = table(Lobe(cycloidal), 1, decimals=4)
FOLLOWER = {"mass": 1.0, "stiffness": 1.0, "restitution": 0.5}
BOUNCES = {"restitution": 0.5}
ARCS = {"kind": "arcs", "base_radius": 0.4, "flank_center": 0.45, "flank_radius": 0.85,
        "nose_center": 0.4, "nose_radius": 0.15, "top_dwell_deg": 40.0}  # fmt: skip
WAY = {"length_deg": 70, "law": "cycloidal"}
LAW = {"kind": "law", "base": 0.1, "lift": 0.1, "top_dwell_deg": 40,
       "rise": {"start_deg": 90, **WAY}, "fall": WAY}  # fmt: skip
WIDTHS = {"scca": {"b": 0.3, "c": 0.3, "d": 0.5}}
OSCILLATOR = {"kind": "oscillator", "damping": 0.0, "frequency": 1.0, "clearance": 0.0}
# the flank turns by as much as the angle at the flank's centre leaves of a half turn
TO_TOP = 180.0 - degrees(acos((0.45**2 + 0.4**2 - 0.7**2) / (2.0 * 0.45 * 0.4)))
WHOLE = 2.0 * TO_TOP + 300.0
SHAPES = [
    (ARCS | {"nose_center": 0.2}, FOLLOWER,
     "flank and nose circle do not touch, they miss by 0.05 m: flank_center + nose_center must "
     "exceed flank_radius - nose_radius"),
    (ARCS | {"nose_center": 1.2}, FOLLOWER,
     "flank and nose circle do not touch, they overlap by 0.05 m: |flank_center - nose_center| "
     "must be below flank_radius - nose_radius"),
    (ARCS | {"flank_radius": 0.9}, FOLLOWER,
     "the flank circle misses the base circle by 0.05 m: flank_radius must equal flank_center + "
     "base_radius"),
    (ARCS | {"flank_radius": 0.85 - 5e-10, "nose_center": 0.25 - 1e-10}, FOLLOWER,  # by rounding
     "the nose does not rise above the base circle: no lift"),
    (ARCS | {"nose_radius": 0.9}, FOLLOWER,
     "nose_radius is 0.05 m too large: it must be smaller than flank_radius"),
    (ARCS | {"top_dwell_deg": 300.0}, FOLLOWER,
     f"flanks, noses and top dwell take {WHOLE:.6g} deg, {WHOLE - 360.0:.6g} deg too much"),
    (LAW | {"top_dwell_deg": 250}, FOLLOWER,
     "rise, top dwell and fall take 390 deg, 30 deg too much: with the base dwell they share one "
     "turn of 360 deg"),
    (OSCILLATOR, BOUNCES,
     "without damping the oscillator has no steady motion where frequency^2 = stiffness/mass"),
    (OSCILLATOR | {"damping_ratio": 0.1, "damping": 0.1}, BOUNCES,
     "found damping and damping_ratio: leave one of them out"),
    (OSCILLATOR | {"amplitude": 1e9, "frequency": 1.001}, BOUNCES,  # 1e9/(1.001^2 - 1)
     "its motion without the stop is 4.998e+11 m high: at most 1e6 m"),
]  # fmt: skip


def faults(load) -> list[str]:
    with pytest.raises(SceneError) as caught:
        load()
    return [str(fault) for fault in caught.value.faults]


@pytest.mark.parametrize(("cam", "follower", "words"), SHAPES)
def test_numbers_that_make_no_cam(cam, follower, words):
    told = faults(lambda: load_scene({"follower": follower, "cam": cam}))
    assert told == [f"scene: cam: {words}, change the values of cam"]


def test_widths_of_a_law_are_shares_of_one():
    cam = {**LAW, "rise": {"start_deg": 90, "length_deg": 70, "law": WIDTHS}}
    told = faults(lambda: load_scene({"follower": FOLLOWER, "cam": cam}))
    key = "cam.rise.law.scca"
    words = "b + c + d = 1.1: the sum must be 1"
    assert told == [f"scene: {key}: {words}, change the values of {key}"]


def test_a_file_that_is_no_lift_table_of_the_scene(tmp_path):
    """Each cause with its cure; what lies outside the scene's folder is not shown."""
    folder = tmp_path / "scene"
    folder.mkdir()
    os.mkfifo(folder / "pipe")
    (tmp_path / "lift.csv").write_text("secret")
    digest = hashlib.sha256(FINE.encode()).hexdigest()
    expected = "expected a table of angles and lifts"
    for changes, words in (
        ({"sha256": "0" * 64},
         f"lift.csv: cam.sha256: found a file with the SHA-256 {digest}, expected {'0' * 64}, this "
         "is not the file the scene was made for; remove sha256 to use it"),
        ({"file": "../lift.csv"},
         "../lift.csv: cam.file: found a file outside the scene's folder, expected a file beside "
         "the scene, copy it beside the scene, or add --set cam.allow_outside=true"),
        ({"file": "../lift.csv", "allow_outside": "true"},
         "../lift.csv: cam.angle_column: found what is no lift table (not shown: it lies outside "
         "the scene's folder)"),
        ({"file": "none.csv"},
         f"none.csv: cam.file: no such file, {expected}, check the name; it is looked for beside "
         "the scene"),
        ({"file": "pipe"},
         f"pipe: cam.file: found a pipe, socket or device, {expected}, save it as a file first"),
    ):  # fmt: skip
        assert faults(lambda c=changes: scene(folder, FINE, **c)) == [f"{folder}{os.sep}{words}"]
    told = faults(lambda: scene(folder, FINE, file="."))
    assert told == [f"{folder}: cam.file: found a folder, {expected}, name the file in it"]


def test_constants_beyond_all_doubles_are_a_fault_of_the_follower():
    cam = EccentricCam(kind="eccentric", base=0.0, lift=0.02)
    system = System.build(Follower(mass=1.0, stiffness=1e300), cam)
    told = faults(lambda: system.constants(1e-10, 1e-9, 1000))
    assert told == [  # omega0/omega = 1e150/(pi/30 1e-10)
        "follower: found omega0/omega = 9.5493e+160, zeta/omega = 0 at 1e-10 rpm, expected finite "
        "squares of both, check mass, stiffness, damping, preload and rpm"
    ]


@pytest.mark.parametrize(
    ("stored", "words"),
    [
        ("P(1;1)", "found the label 'P(1;1)'"),
        ([], "expected a label"),
        (3, "expected a label"),
        ([1.0, -1.0], "expected a label of counts of impacts"),
        ([1.5], "expected a label of counts of impacts"),
        ([1.0, "2"], "expected a label of counts of impacts"),
    ],
)
def test_what_is_stored_as_a_label(stored, words):
    with pytest.raises(ValueError, match=r"label") as refused:
        from_plain(stored)
    assert str(refused.value) == words
    assert from_plain([2.0, inf, 0.0]) == "P(3;inf:0:2)"
