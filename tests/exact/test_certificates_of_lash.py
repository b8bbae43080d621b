"""Certificates on a cam with lash: an impact on the seat, and which changes are refused."""

import json
import re
from copy import deepcopy

import numpy as np
import pytest
from flint import arb, ctx
from mpmath import mp, mpf, pi, sin

import camcli
from camcli import check
from camcli.cams.formula import formula_of
from camcli.scene import load_scene
from tests.exact.test_certificates import BOX
from tests.support.refusals import reasons

pytestmark = pytest.mark.slow
WAY = {"length_deg": 70, "law": "cycloidal"}
CAM = {"kind": "law", "base": 0.1, "lift": 0.15, "lash": 0.01, "top_dwell_deg": 40,
       "rise": {"start_deg": 90, **WAY}, "fall": WAY}  # fmt: skip
SCENE = {"follower": {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8, "preload": 50.0,
                      "seat_restitution": 0.5}, "cam": CAM}  # fmt: skip
RANGE = {"orbits.rpm.start": 418.0, "orbits.rpm.stop": 422.0, "orbits.rpm.num": 3,
         "orbits.at": 420.0, "orbits.label": "P(1;2)", "orbits.starts": 2,
         "orbits.branches": 0}  # fmt: skip


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    """The proof.json of an orbit with one impact on the cam and one on its seat, and its branch."""
    folder = tmp_path_factory.mktemp("lash")
    camcli.orbits(load_scene(SCENE, RANGE), prove=True).save(folder, plot=False)
    return json.loads((folder / "proof.json").read_text())


def lifted(theta):
    """max(c - lash, base) of the cycloidal cam, at an angle in rad, by its closed formula."""
    deg = theta * 180 / pi
    since = (deg - 90) / 70 if deg < 180 else (270 - deg) / 70
    x = min(max(since, mpf(0)), mpf(1))
    c = mpf(0.1) + mpf(0.15) * (x - sin(2 * pi * x) / (2 * pi)) - mpf(0.01)
    return max(c, mpf(0.1))


def test_an_orbit_with_an_impact_on_the_seat_is_confirmed(content, checked):
    code, text = checked(content)
    assert code == 0, text
    assert text.count("confirmed: P(1;2)") == 2
    assert content["uncovered"] == []
    stretches = content["cam"]["stretches"]
    on_seat = [stretches[one["stretch"]]["seat"] for one in content["statements"][0]["impacts"]]
    assert sorted(on_seat) == [False, True]


def test_the_cam_of_the_certificate_is_the_higher_one_of_cam_and_seat(content):
    before = ctx.prec
    ctx.prec = check.BITS
    try:
        stretches = check.cam_of(content["cam"], "cam").stretches
        with mp.workdps(40):
            for theta in np.linspace(0.001, 6.28, 200):
                phase = arb(float(theta))
                one = next(x for x in stretches if x.start < phase and phase < x.end)
                found = mpf(one.derivatives(phase, 0)[0].mid().str(30, radius=False))
                assert abs(found - lifted(mpf(float(theta)))) < mpf("1e-25")
    finally:
        ctx.prec = before


def stretch(number, **values):
    return lambda cam: cam["stretches"][number].update(values)


def number(name, value):
    return lambda cam: cam["numbers"].update({name: value})


REFUSED, NO_CERTIFICATE = 1, 2
STEP = "the file.cam: these numbers make no cam, it has a step"
LEVEL = "the file.cam: expected a seat that is level, and nothing below it"
SHARE = "the file.cam: expected a restitution from 0 to 1 on the seat"
NAMES = "the file.cam.numbers: expected numbers by their names, not pi"
NUMBER = 'the file.cam.numbers.edge4: expected a number as text, like "0.85"'
FLAG = "the file.cam.stretches[4].seat: expected true or false"
CHANGES = {
    "another restitution on the seat": (
        lambda cam: cam.update(seat_restitution="0.51"), REFUSED, BOX),
    "the restitution of the cam on the seat": (
        lambda cam: cam.update(seat_restitution=None), REFUSED, BOX),
    "a seat that throws": (
        lambda cam: cam.update(seat_restitution="1.01"), NO_CERTIFICATE, SHARE),
    "a seat that keeps all": (
        lambda cam: cam.update(seat_restitution="0"), NO_CERTIFICATE, SHARE),
    "the seat is cam": (stretch(4, seat=False), REFUSED, BOX),
    "the cam is seat": (stretch(1, seat=True), NO_CERTIFICATE, LEVEL),
    "the top is seat": (stretch(2, seat=True), NO_CERTIFICATE, LEVEL),
    "a higher seat": (stretch(4, polynomial=["base + lash/1000"]), NO_CERTIFICATE, STEP),
    "a seat that leans": (stretch(4, polynomial=["base", "0"]), NO_CERTIFICATE, LEVEL),
    "another lash": (number("lash", "0.0101"), NO_CERTIFICATE, STEP),
    "a pi of its own": (number("pi", "3"), NO_CERTIFICATE, NAMES),
    "an edge elsewhere": (number("edge4", "4.44 +/- 1e-66"), NO_CERTIFICATE, STEP),
    "an edge anywhere": (number("edge4", "4.44 +/- 1e-2"), NO_CERTIFICATE, STEP),
    "an edge without an error": (number("edge4", "4.44 +/- "), NO_CERTIFICATE, NUMBER),
    "a flag that is none": (stretch(4, seat=1), NO_CERTIFICATE, FLAG),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_what_is_wrong_with_the_seat_is_refused(name, content, checked):
    change, wanted, why = CHANGES[name]
    other = deepcopy(content)
    change(other["cam"])
    code, text = checked(other)
    assert code == wanted, text
    assert why in reasons(text)
    assert "\nconfirmed" not in text
    assert not text.startswith("confirmed")


def test_an_impact_on_the_wrong_stretch_is_refused(content, checked):
    other = deepcopy(content)
    for one in other["statements"]:
        for impact in one["impacts"]:
            impact["stretch"] = {4: 3, 1: 2}[impact["stretch"]]
    code, text = checked(other)
    assert code == 1
    assert "confirmed: " in text
    assert text.endswith(f"0 of {len(other['statements'])} statements are confirmed\n")


def test_nothing_of_the_cam_lies_below_its_seat(content, checked):
    """Dips that end where they begin, and so make no step."""
    other = deepcopy(content)
    dip = ["base", "-lash", "lash/pi"]  # -x lash (1 - x/pi), zero again at x = pi
    other["cam"]["stretches"] = [
        {"end": "pi", "center": "0", "polynomial": dip, "wave": [], "circle": [], "seat": False},
        {"end": "2*pi", "center": "0", "polynomial": ["base"], "wave": [], "circle": [],
         "seat": True},
    ]  # fmt: skip
    code, text = checked(other)
    assert code == 2
    assert LEVEL in reasons(text)


def test_without_lash_the_base_circle_is_the_seat(checked, tmp_path):
    """Lash zero: the dwell on the base circle has the restitution of the seat."""
    scene = {**SCENE, "cam": {**CAM, "lash": 0.0}}
    cam = formula_of(load_scene(scene).cam, 0.5)
    assert [one["seat"] for one in cam["stretches"]] == [True, False, False, False, True]
    assert formula_of(load_scene(scene).cam)["seat_restitution"] is None


@pytest.mark.parametrize("law", ["cycloidal", "modified-sine", "4-5-6-7", "harmonic"])
def test_a_cam_that_leaves_its_seat_with_slope_zero_is_read(law):
    """Without lash; up to the third derivative may be zero there. A cam that falls is refused."""
    way = {"length_deg": 70, "law": law}
    rise = {"start_deg": 90, **way}
    cam = {**CAM, "lash": 0.0, "rise": rise, "fall": way}
    made = formula_of(load_scene({**SCENE, "cam": cam}).cam, 0.5)
    before = ctx.prec
    ctx.prec = check.BITS
    try:
        found = check.cam_of(made, "cam")
        upside_down = {**made, "numbers": {**made["numbers"], "lift": "-0.15"}}
        with pytest.raises(check.NoCertificateError, match=f"^{re.escape(LEVEL)}$"):
            check.cam_of(upside_down, "the file.cam")
    finally:
        ctx.prec = before
    assert [one.seat for one in found.stretches][:: len(found.stretches) - 1] == [True, True]


def test_a_lift_table_with_lash_has_no_formulas():
    assert formula_of(load_scene("configs/lift-table.yaml", {"cam.lash": 1e-4}).cam) is None
