"""Certificates of the loss of contact: the theorems, their checker, and what it refuses.

The judge of numbers is the oracle of mpmath, which knows nothing of the package.
"""

import json
import re
from copy import deepcopy
from fractions import Fraction
from random import Random

import pytest
from flint import arb
from mpmath import mp

import camcli
from camcli import check
from camcli.cams.formula import formula_of
from camcli.scene import load_scene
from tests.exact.test_certificates import FOLLOWER, at, both, changed, drop, law, put
from tests.support.oracle import ArcsCam
from tests.support.refusals import reasons

pytestmark = pytest.mark.slow
PROVED = {"detach.prove": True, "detach.rpm.start": 114.0, "detach.rpm.stop": 126.0,
          "detach.rpm.num": 13, "detach.impacts": 3}  # fmt: skip
HITS = "124.99829682080343025", "122.69931764156417777", "121.68587192213975812"  # by mpmath
KNOWN = "114.97932674399878183", *HITS


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    """The proof.json of the example's first detachment and of three corner hits."""
    folder = tmp_path_factory.mktemp("contact")
    camcli.detach(load_scene(None, PROVED)).save(folder, plot=False)
    return json.loads((folder / "proof.json").read_text())


def one_of(content, kind, impacts=0):
    """A statement by its kind and the number of impacts before the last."""
    return next(
        one
        for one in content["statements"]
        if one["kind"] == kind and len(one.get("impacts", ())) == impacts
    )


def test_the_example_is_confirmed_with_the_numbers_of_the_guide(content, checked):
    code, text = checked(content)
    assert code == 0
    assert content["uncovered"] == []
    assert text.endswith("4 of 4 statements are confirmed\n")
    for number in KNOWN:
        assert text.count(number[:-1]) == 2  # both ends of the range
    b, c = (mp.nstr(mp.degrees(x), 7).removesuffix(".0") for x in ArcsCam().breakpoints[1:3])
    assert text.count(f" at {b} deg (the start of stretch 2), and its impact ") == len(HITS)
    assert text.count(f" is at {c} deg (the end of stretch 2), for ") == len(HITS)


@pytest.mark.ci
def test_damping_and_the_cams_of_others_are_left_out_or_confirmed(checked, tmp_path):
    """With damping all is proved; of a fitted, a kinked or a loose cam nothing, with the reason."""
    damped = {**PROVED, "follower.damping": 0.5, "detach.impacts": 1}
    camcli.detach(load_scene(None, damped)).save(tmp_path / "damped", plot=False)
    content = json.loads((tmp_path / "damped/proof.json").read_text())
    assert content["uncovered"] == []
    code, text = checked(content)
    assert code == 0
    assert "2 of 2" in text
    ways = {"rise": {"start_deg": 90, "length_deg": 70, "law": "constant-velocity"},
            "fall": {"length_deg": 70, "law": "cycloidal"}}  # fmt: skip
    follower = {"mass": 1.221, "stiffness": 1430.8, "damping": 0, "gravity": 0, "preload": 0,
                "restitution": 0.8}  # fmt: skip
    cam = {"kind": "law", "base": 0.1, "lift": 0.15, "top_dwell_deg": 40, **ways}
    kinked = {"follower": follower, "cam": cam}
    few = {"detach.prove": True, "detach.impacts": 1, "detach.rpm.num": 2}
    for scene, why in (
        ("configs/lift-table.yaml", "the pieces fitted to a table meet only but for roundings"),
        ("configs/valve-lash.yaml", "a certificate has no words for the seat of a cam with lash"),
        (kinked, "the slope of this cam jumps, and there the contact force of a follower at rest"),
        ("configs/eccentric.yaml", "there is no speed up to which contact holds"),
        ("configs/bouncing-ball.yaml", "contact is first lost within a smooth part of this cam"),
    ):
        result = camcli.detach(load_scene(scene, few))
        assert result.summary["proved"]["statements"] == 0
        nothing = f"nothing was proved of the loss of contact: {why}"
        assert result.summary["proved"]["words"].startswith(nothing)
        assert not result.files


def other_end(one):
    """The corner is the end of the stretch before."""
    one["corner"]["stretch"] -= 1
    one["flights"][-1]["passages"].pop()


def reverse_cuts(one):
    """The parts of a stretch overlap, so that one of them goes backwards."""
    index = max(range(len(one["cuts"])), key=lambda k: len(one["cuts"][k]))
    cuts = one["cuts"][index]
    one["cuts"][index] = [*cuts, *cuts[:1]] if len(cuts) > 1 else [cuts[0], cuts[0]]


def beyond(one):
    """The range of speeds is the last thousandth of what it was, and the corner is met before."""
    with mp.workdps(60):
        low, high = (mp.mpf(one[key]) for key in ("low", "high"))
        one["low"] = mp.nstr(high - (high - low) / 1000, 50)


LIES = "impact {} may lie elsewhere"
MEETS = "flight {} may meet the cam on its way"
PASSES = "flight {} does not pass stretch after stretch from impact to impact"
RISES = "flight {} does not rise first and fall last"
WRONG = {
    ("first-detachment", 0): [
        (both(put("low", "115"), put("high", "116")), "the force may end at a lower speed"),
        (put("high", "114.9793267439987"), "its range is empty"),
        (both(put("low", "114"), put("high", "114.9")), "the force may not end"),
        (put("low", "0"), "its range is empty"),
        (put("stretch", 1), "the force may not end"),
        (put("at_end", True), "the force may not end"),
        (put("stretch", 7), "the cam has no such stretch"),
        (put("cuts", []), "not every stretch has its cuts"),
        (put("cuts", 2, []), "the force may end at a lower speed"),
        (reverse_cuts, "the cuts of a stretch do not follow one another"),
        (put("constants", "mass", "1.3"), "the force may end at a lower speed"),
        (put("constants", "mass", "-1"), "speed or mass is not positive"),
        (put("constants", "gravity", "-200"), "the force may end at a lower speed"),
        (put("constants", "preload", None), "exactly the parameter has to be left open"),
        (put("constants", "rpm", "114"), "exactly the parameter has to be left open"),
        (put("constants", "damping", "20"), "the force may end at a lower speed"),
    ],
    ("corner-hit", 2): [
        (put("low", "121.7"), "its range is empty"),
        (put("high", "121.9"), LIES.format(1)),
        (beyond, "the corner may not be met"),
        (both(put("low", "121.6"), put("high", "121.6000000000000001")), LIES.format(1)),
        (put("low", "-1"), "its range is empty"),
        (put("start", 1), "the follower may not leave there"),
        (put("start", 9), "the cam has no such stretch"),
        (put("corner", "stretch", 9), "the cam has no such stretch"),
        (put("corner", "turn", 1), PASSES.format(3)),
        (other_end, "flight 3 ends before it begins"),
        (put("impacts", 0, "low", "2.7"), LIES.format(1)),
        (put("impacts", 0, "stretch", 3), LIES.format(1)),
        (put("impacts", 0, "turn", 1), LIES.format(1)),
        (drop("impacts", 0), "not every impact has its flight"),
        (both(drop("impacts", 0), drop("flights", 0)), LIES.format(1)),
        (both(drop("impacts", 1), drop("flights", 1)), MEETS.format(2)),
        (put("flights", 0, "passages", 0, "cuts", []), RISES.format(1)),
        (put("flights", 1, "fall", 0), RISES.format(2)),
        (put("flights", 2, "passages", []), PASSES.format(3)),
        (put("constants", "restitution", "0.79"), LIES.format(2)),
        (put("constants", "restitution", "1.2"), "the restitution lies outside 0 to 1"),
        (put("constants", "stiffness", "1430"), LIES.format(1)),
    ],
}  # fmt: skip


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_wrong_is_refused_for_its_reason(kind, content, checked):
    assert checked({**content, "statements": [one_of(content, *kind)]})[0] == 0
    for change, why in WRONG[kind]:
        one = deepcopy(one_of(content, *kind))
        change(one)
        code, text = checked({**content, "statements": [one]})
        assert code == 1, (why, text)
        assert why in reasons(text)


def test_a_corner_that_may_be_met_twice_is_refused(content, checked, monkeypatch):
    """The gap at the corner has a slope by the speed that may be zero."""
    own = check.flown

    def turning(*asked):
        found = own(*asked)
        gap = check.sloped(check.value_of(found.gap), check.slope_of(found.gap) * arb(0, 1))
        return found._replace(gap=gap)

    one = one_of(content, "corner-hit", 2)
    monkeypatch.setattr(check, "flown", turning)
    code, text = checked({**content, "statements": [one]})
    assert code == 1
    assert reasons(text) == ["the corner may be met at several speeds"]


def test_another_cam_is_refused(content, checked):
    """One with kinks, one that is a fit, and one that is higher."""
    kinked = formula_of(load_scene({"follower": FOLLOWER, "cam": law("constant-velocity")}).cam)
    level = {"end": "2*pi", "center": "0", "polynomial": ["1"], "wave": [], "circle": [],
             "seat": False}  # fmt: skip
    fit = {**kinked, "kind": "pieces", "stretches": [level]}
    for cam, why in (
        (kinked, "the slope of the cam jumps"),
        (fit, "the pieces of a fitted cam do not meet exactly"),
    ):
        code, text = checked({**content, "cam": cam})
        assert code == 1
        assert reasons(text).count(why) == 4
    numbers = {**content["cam"]["numbers"], "nose_radius": "0.1500001"}
    code, text = checked({**content, "cam": {**content["cam"], "numbers": numbers}})
    assert (code, text.count("not confirmed")) == (1, 4)


def shapes(cam: dict) -> list[dict]:
    """The stretches of a cam without what makes no difference.

    A level one is the same about any centre. A circle is the same about a centre that lies whole
    turns on, and of its radius only the square counts.
    """
    found = []
    for stretch in cam["stretches"]:
        shape = dict(stretch)
        if len(shape["polynomial"]) == 1 and not shape["wave"] and not shape["circle"]:
            del shape["center"]
        if shape["circle"]:
            height, radius = shape["circle"]
            shape["circle"] = [height, radius.strip("-()")]
            if len(shape["polynomial"]) == 1 and not shape["wave"]:
                shape["center"] = re.sub(r"\b\d*[02468]\*pi", "2*pi", shape["center"])
        found.append(shape)
    return found


def still_true(content: dict, before: dict) -> bool:
    """Whether a changed certificate states no more than the numbers that are known without it.

    Its machine is the example's to 18 digits, and each range holds the known speed, to 17 digits
    after the point.
    """
    for one in content["statements"]:
        speed = Fraction(KNOWN[0] if one["kind"] == "first-detachment" else
                         HITS[len(one["impacts"])])  # fmt: skip
        slack = Fraction(2, 10**17)
        if not Fraction(one["low"]) - slack <= speed <= Fraction(one["high"]) + slack:
            return False
        if one["kind"] == "first-detachment":
            one["constants"].pop("restitution")  # without a meaning there
        old = next(x for x in before["statements"] if x["kind"] == one["kind"])
        pairs = [(one["constants"][key], old["constants"][key]) for key in one["constants"]]
        pairs += [
            (content["cam"]["numbers"][key], x) for key, x in before["cam"]["numbers"].items()
        ]
        if content["cam"]["formulas"] != before["cam"]["formulas"]:
            return False
        if shapes(content["cam"]) != shapes(before["cam"]):
            return False
        for x, y in pairs:
            if x != y and abs(Fraction(x) - Fraction(y)) > Fraction(1, 10**18):
                return False
    return True


@pytest.mark.ci
def test_a_hundred_random_changes_are_refused_unless_the_statement_is_still_true(content, checked):
    rng, refused = Random(39), 0
    for _ in range(100):
        after, what = changed(content, rng)
        code, text = checked(after)
        assert code in (0, 1, 2)
        assert "Traceback" not in text
        if code == 0:
            assert still_true(after, content), what
        refused += code != 0
    assert refused >= 50


def test_a_flight_that_lifts_may_not_be_any_flight(content, checked):
    """The second flight leaves at a rate, the first one from rest: their parts do not go over."""
    one = deepcopy(one_of(content, "corner-hit", 2))
    cuts = at(one, ["flights", 0, "passages", 0, "cuts"])
    cuts[0] = str(float(cuts[0]) + 0.2)
    code, text = checked({**content, "statements": [one]})
    assert code == 1
    assert "flight 1 " in text
