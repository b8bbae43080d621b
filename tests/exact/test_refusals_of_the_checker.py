"""Every refusal of the checker of certificates has something that is refused with its sentence.

Most of them stand in the tables of damaged certificates beside each kind of statement
(`test_certificates*.py`, `test_all_orbits.py`); here are those that need a case of their own, and
the check that no sentence is left out. Boxes of impacts are made by hand: a ball on a level plate
comes back after 2 v/G with the rate r v, so that its impact map is linear.
"""

from __future__ import annotations

import ast
import re
from copy import deepcopy
from fractions import Fraction
from math import pi
from pathlib import Path
from types import SimpleNamespace

import pytest
from flint import arb, arb_mat

from camcli import check
from camcli.cams.formula import formula_of
from camcli.scene import load_scene
from tests.support.refusals import reasons

LEVEL = {"end": "2*pi", "center": "0", "polynomial": ["1"], "wave": [], "circle": [],
         "seat": False}  # fmt: skip
PLATE = {"kind": "eccentric", "numbers": {}, "formulas": [], "stretches": [LEVEL],
         "seat_restitution": None}  # fmt: skip
# rpm 30, so that omega is pi, and gravity pi^2: so G is 1
BALL = {"rpm": "30", "mass": "1", "stiffness": "0", "damping": "0", "gravity": None,
        "preload": "0", "restitution": "0.5"}  # fmt: skip


def box_of_impacts(middle, axes, across: int) -> dict:
    """A box on the plate, cut along x; its flights rise before v rad and have landed after 2 v."""
    (theta, v), (a, b, c, d) = middle, axes
    flights = []
    for i in range(across):
        x = (2 * i + 1) / across - 1
        at, rate = theta + a * x, v + c * x
        slack = abs(a) / across + abs(b) + abs(c) / across + abs(d) + 0.01
        cuts = [at + rate - slack, at + rate + slack]
        lands = [at + 2 * rate - 2 * slack, at + 2 * rate + 2 * slack]
        flights.append({
            "low": f"{lands[0]:.6f}", "high": f"{lands[1]:.6f}", "rise": 1, "fall": 1,
            "passages": [{"stretch": 0, "turn": 0, "cuts": [f"{cut:.6f}" for cut in cuts]}],
        })  # fmt: skip
    return {"stretch": 0, "middle": [f"{x}" for x in middle], "axes": [f"{x}" for x in axes],
            "lands": {"stretch": 0, "turn": 0}, "cells": [across, 1],
            "flights": flights}  # fmt: skip


def boxes_on_a_plate() -> dict:
    """The first box is mapped across the second one, which covers none.

    x of the first is v - 1 in tenths. It lands at 1 + 2 v with v/2, so 0.2 x away from (3, 1/2)
    along (2, 1/2), which is twice as far as the x of the second one reaches.
    """
    boxes = [
        box_of_impacts((1.0, 1.0), (0.0, 0.01, 0.1, 0.0), 8),
        box_of_impacts((3.0, 0.5), (0.1, 0.0, 0.025, 0.02), 2),
    ]
    gravity = f"{pi**2:.15f}"
    return {"kind": "chaos", "parameter": "gravity", "low": gravity, "high": gravity,
            "constants": dict(BALL), "boxes": boxes, "coverings": [[0, 1]], "growth": "1.1",
            "weights": ["1", "1"]}  # fmt: skip


def on_a_plate(checked, change=lambda one: None) -> list[str]:
    """Why the checker does not confirm the boxes, changed."""
    one = boxes_on_a_plate()
    change(one)
    code, text = checked({"format": "camcli-proof-1", "cam": PLATE, "statements": [one],
                          "uncovered": []})  # fmt: skip
    assert code == 1
    return reasons(text)


def put(*path_and_value):
    """A change of one value of a statement."""
    *path, last, value = path_and_value

    def change(statement: dict) -> None:
        place = statement
        for key in path:
            place = place[key]
        place[last] = value

    return change


def along_the_map(statement: dict) -> None:
    """The first box lies along the direction in which it does not grow: both of its ends land in
    the middle of the second one."""
    statement["boxes"][0] = box_of_impacts((1.0, 1.0), (0.01, 0.0, 0.0, 0.01), 8)


def folded(statement: dict) -> None:
    """The second box lies so far to the side that both ends of the first land on one side of it."""
    statement["boxes"][1] = box_of_impacts((3.35, 0.5875), (0.1, 0.0, 0.025, 0.02), 2)


def a_little_higher(statement: dict) -> None:
    """The second box is moved along its y, by a little more than itself."""
    statement["boxes"][1] = box_of_impacts((3.0, 0.525), (0.1, 0.0, 0.025, 0.02), 2)


def elsewhere(statement: dict) -> None:
    """The plate is cut in two, and the second box lies on the other half."""
    statement["boxes"][1]["stretch"] = 1


def at_rest(statement: dict) -> None:
    """The second box holds impacts without a rate, and nothing is said of where they land."""
    statement["boxes"][1]["middle"] = ["3", "0.01"]
    statement["coverings"] = []


SLOWLY = "the number of sequences may grow more slowly"
CROSSES = "a flight may begin or land outside its stretch of the cam"
OF_CHAOS = [  # what is wrong with the boxes on the plate
    (lambda one: None, SLOWLY),  # the second one covers none, but has a weight
    (put("weights", ["1", "0"]), SLOWLY),
    (put("weights", ["0", "0"]), "it has not its weights"),
    (put("weights", ["1"]), "it has not its weights"),
    (put("weights", ["1", "-1"]), "it has not its weights"),
    (put("growth", "1"), "the number of sequences does not grow"),
    (put("growth", "1.00000001"), SLOWLY),
    (put("high", "9.869604401"), "its range is empty"),
    (put("boxes", 1, "middle", ["3"]), "a box has not two numbers and four of its axes"),
    (put("boxes", 1, "axes", ["0.1", "0", "0.025"]),
     "a box has not two numbers and four of its axes"),
    (put("boxes", 1, "axes", ["0.1", "0.2", "0.1", "0.2"]), "box 2 is flat"),
    (put("boxes", 1, "middle", ["1.05", "1"]), "boxes 1 and 2 may overlap"),
    (put("coverings", [[0]]), "its coverings are no pairs of boxes"),
    (put("coverings", [[0, 2]]), "its coverings are no pairs of boxes"),
    (put("coverings", [[0, 1], [0, 1]]), "its coverings are no pairs of boxes"),
    (put("coverings", [[1, 0]]), "box 2 may be mapped beside box 1"),
    (elsewhere, "a flight lands on another box"),
    (put("boxes", 0, "cells", [8]), "a box is divided along both of its axes"),
    (put("boxes", 0, "cells", [8, 1, 1]), "a box is divided along both of its axes"),
    (put("boxes", 0, "cells", [8, 2]), "not every cell of a box has its flights"),
    (put("boxes", 0, "cells", [1, 1]), "not every cell of a box has its flights"),
    (put("boxes", 0, "middle", ["0.009", "1"]), CROSSES),
    (put("boxes", 0, "flights", 0, "high", "6.2832"), CROSSES),
    (put("boxes", 0, "flights", 0, "low", "-0.0001"), CROSSES),
    (at_rest, "an impact may not bounce"),
    (put("boxes", 0, "flights", 0, "low", "2.81"),
     "a flight may not land between the phases that are given"),
    (put("boxes", 0, "flights", 0, "high", "2.81"),
     "a flight may not land between the phases that are given"),
    (put("boxes", 0, "flights", 0, "rise", 0), "flight 1 does not rise first and fall last"),
    (put("boxes", 0, "flights", 0, "rise", 2), "flight 1 may meet the cam on its way"),
    (put("boxes", 0, "flights", 0, "fall", 2), "flight 1 may meet the cam on its way"),
    (along_the_map, "an end of box 1 may be mapped into box 2"),
    (folded, "box 1 is not mapped across box 2"),
    (a_little_higher, "box 1 may be mapped beside box 2"),
    (put("constants", "restitution", "0.6"), "box 1 may be mapped beside box 2"),
    (put("constants", "gravity", "9.8"), "exactly the parameter has to be left open"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "why"), OF_CHAOS)
def test_what_is_wrong_with_boxes_of_impacts(change, why, checked):
    assert on_a_plate(checked, change) == [why]


def test_a_landing_that_newtons_method_does_not_find(checked, monkeypatch):
    monkeypatch.setattr(check, "landing", lambda *asked: None)
    assert on_a_plate(checked) == ["no landing was found"]


# -- sentences of the other statements that have no case in the tables beside them

ECCENTRIC = {"kind": "eccentric", "base": 0.0, "lift": 0.02}
OSCILLATOR = {"kind": "oscillator", "damping": 0.1, "amplitude": 0.6, "frequency": 4.0,
              "clearance": -0.5}  # fmt: skip
LASH = "configs/valve-lash.yaml"


@pytest.fixture(autouse=True)
def digits(bits):
    """The digits of the checker."""


def scene_of(source):
    """A scene with this cam, or in this file."""
    scene = {"cam": source} if isinstance(source, dict) else source
    if isinstance(scene, dict):
        scene["follower"] = {"restitution": 0.8}
        if source["kind"] != "oscillator":
            scene["follower"] |= {"mass": 1.0, "stiffness": 1.0}
    return load_scene(scene)


def cam_of(source) -> check.Cam:
    """The cam of a scene, as the checker reads it."""
    return check.cam_of(formula_of(scene_of(source).cam), "the file.cam")


def refused_in_a_file(checked, cam: dict, statement: dict) -> list[str]:
    """Why the checker does not confirm a statement on a cam."""
    code, text = checked({"format": "camcli-proof-1", "cam": cam, "statements": [statement],
                          "uncovered": []})  # fmt: skip
    assert code in (1, 2)
    return reasons(text)


def refused(ask, *asked, **more) -> str:
    """The sentence with which a part of the checker refuses."""
    with pytest.raises(check.RefusedError) as refusal:
        ask(*asked, **more)
    return str(refusal.value)


def constants(**changes) -> dict:
    """Those of a machine as a statement has them."""
    values = {"rpm": 400, "mass": 1, "stiffness": 30, "damping": 0, "gravity": 0, "preload": 0,
              "restitution": Fraction(4, 5)}  # fmt: skip
    return {key: None if x is None else Fraction(x) for key, x in {**values, **changes}.items()}


@pytest.mark.parametrize("many", [6, 7])
def test_few_impacts_only_may_lie_on_either_side_of_the_strobe(many):
    near = [arb(1, 1e-9), arb(1)] * many
    said = SimpleNamespace(
        impacts=[SimpleNamespace(turn=0)] * many, turns=1, strobe=Fraction("57.29577951308232")
    )
    if many == 6:
        assert check.labels(said, near) == ["P(1;6)"]
    else:
        why = "impacts may lie on either side of the strobe"
        assert refused(check.labels, said, near) == why


@pytest.mark.parametrize(("cam", "names", "why"), [
    (ECCENTRIC, ("cam.lift", "lift"), "its parameters are one number"),
    (ECCENTRIC, ("cam.lash",), "the cam has no such number"),
    (OSCILLATOR, ("cam.frequency", "rpm"), "an oscillator turns as fast as its force"),
    (OSCILLATOR, ("cam.frequency",), "the oscillator has other constants than its cam"),
    (LASH, ("cam.lift",), "the ends of the cam's stretches may vary with its numbers"),
])  # fmt: skip
def test_what_may_not_vary_together(cam, names, why):
    read = cam_of(cam)
    assert refused(check.left_open, read, constants(mass=2), names) == why


def test_all_numbers_of_a_cam_may_vary_at_once():
    cam = cam_of(ECCENTRIC)
    numbers = tuple(f"cam.{name}" for name in cam.numbers)
    assert len(numbers) == 2
    assert check.left_open(cam, constants(), numbers) == set()
    assert check.left_open(cam, constants(), (*numbers, "mass")) == {"mass"}


def test_the_ends_of_stretches_may_vary_where_a_number_is_enclosed_or_a_stretch_is_seat():
    """Each of both alone, on a cam that else has neither."""
    why = "the ends of the cam's stretches may vary with its numbers"
    for change in (lambda cam: cam.numbers.update(base=arb(0, 1e-60)),
                   lambda cam: setattr(cam.stretches[0], "seat", True)):  # fmt: skip
        cam = cam_of(ECCENTRIC)
        assert check.left_open(cam, constants(), ("cam.lift",)) == set()
        change(cam)
        assert refused(check.left_open, cam, constants(), ("cam.lift",)) == why


@pytest.mark.parametrize("same", [True, False])
@pytest.mark.parametrize("key", ["mass", "stiffness", "damping"])
def test_an_oscillator_has_the_mass_the_spring_and_the_damper_of_its_cam(key, same):
    cam = cam_of(OSCILLATOR)
    own = {name: cam.numbers[name] for name in ("mass", "stiffness", "damping")}
    known = constants(**{**own, key: own[key] if same else own[key] + Fraction(1, 10**30)})
    if same:
        assert check.left_open(cam, known, ("cam.amplitude",)) == {"rpm"}
        assert check.left_open(cam, known, ("cam.amplitude", f"cam.{key}")) == {"rpm", key}
    else:
        why = "the oscillator has other constants than its cam"
        assert refused(check.left_open, cam, known, ("cam.amplitude",)) == why


def part(start, end, *polynomial, **more) -> check.Stretch:
    """A stretch of a cam, by powers of the angle from its start."""
    coefficients = [arb(x) for x in polynomial]
    return check.Stretch(arb(start), arb(end), arb(start), coefficients, **more)


SEAT, LOBE = part(0, 3, 1, seat=True), part(3, 6, 1, 0, "0.1")  # which begins with slope zero
SEATS = {
    "level": ([SEAT, LOBE], True),
    "none": ([LOBE], True),
    "in two parts": ([SEAT, LOBE, part(6, "6.2", 1, seat=True)], True),
    "of two levels": ([SEAT, LOBE, part(6, "6.2", "1.01", seat=True)], False),
    "of two levels, the first above": ([SEAT, LOBE, part(6, "6.2", "0.99", seat=True)], False),
    "of two levels but for roundings": (
        [part(0, 3, 0, seat=True), part(3, 6, 0, 0, "0.1"), part(6, 7, arb(2) ** -200, seat=True)],
        True,
    ),
    "inclined": ([part(0, 3, 1, "1e-9", seat=True), LOBE], False),
    "inclined below": ([SEAT, part(3, 4, 2), part(4, 5, 1, "-1e-9", seat=True)], False),
    "of a wave": ([part(0, 3, 1, seat=True, wave=(arb(0), arb("1e-9"), arb(2))), LOBE], False),
    "of a circle": ([part(0, 3, 0, seat=True, circle=(arb("1e-9"), arb(1))), LOBE], False),
    "above the cam": ([SEAT, part(3, 6, "0.99")], False),
    "above the cam somewhere": ([SEAT, part(3, 6, 1, "-0.01", "0.1")], False),
    "below the cam": ([SEAT, part(3, 6, "1.01")], True),
}


@pytest.mark.parametrize(("stretches", "said"), SEATS.values(), ids=SEATS)
def test_a_seat_is_level_and_nothing_is_below_it(stretches, said):
    assert check.above_seat(stretches) == said


@pytest.mark.parametrize("dwell", [arb(0), arb("0.001")])
def test_a_part_of_the_cam_that_vanishes_makes_it_another_one(dwell):
    cam = check.cam_of(formula_of(load_scene().cam), "")
    if dwell > 0:
        check.Machine(cam, constants(), {"cam.top_dwell_deg": dwell})
    else:
        why = "the cam has other parts there"
        assert refused(check.Machine, cam, constants(), {"cam.top_dwell_deg": dwell}) == why


def test_no_statement_on_rest_or_on_all_orbits_has_a_cam_with_a_seat_or_one_that_is_a_fit():
    said = SimpleNamespace(constants=constants(rpm=None), low=Fraction(1), high=Fraction(2))
    seat = cam_of(LASH)
    fit = check.cam_of({**PLATE, "kind": "pieces"}, "")
    for ask in (check.check_all, check.resting):
        assert refused(ask, seat, said) == "a cam with a seat has no such statement"
        assert refused(ask, fit, said) == "the pieces of a fitted cam do not meet exactly"


@pytest.mark.parametrize(
    ("preload", "why"),
    [
        ("0", "the follower may come to rest in flight, and flights may be long"),
        ("0.1", "a box of a cover may hold an orbit"),
    ],
)
def test_flights_may_be_long_where_the_spring_rests_above_the_cam(preload, why, checked):
    """The cam goes down to 0 and its spring, 30 N/m, is free there without a preload."""
    one = cover()
    one["constants"] |= {"rpm": "400", "stiffness": "30", "gravity": "0", "preload": preload}
    assert refused_in_a_file(checked, formula_of(scene_of(ECCENTRIC).cam), one) == [why]


def test_of_a_cam_whose_slope_jumps_no_flights_are_covered(checked):
    way = {"length_deg": 70, "law": "constant-velocity"}
    cam = scene_of({"kind": "law", "base": 0.1, "lift": 0.15, "top_dwell_deg": 40,
                    "rise": {"start_deg": 90, **way}, "fall": way}).cam  # fmt: skip
    assert refused_in_a_file(checked, formula_of(cam), cover()) == ["the slope of the cam jumps"]


# -- the form of the file: which value is refused, where, and what is expected there


def orbit() -> dict:
    """A statement of the right form, of which nothing is true."""
    place = {"stretch": 0, "turn": 0}
    box = {"middle": ["1"], "tangent": ["1"], "error": ["0"], "fixed": 0, "half": "0",
           "inverse": [], "flights": [{"rise": 0, "fall": 0, "passages": [
               {**place, "cuts": ["1"]}]}]}  # fmt: skip
    return {"kind": "orbit", "label": "P(1;1)", "parameter": "gravity", "constants": dict(BALL),
            "turns": 1, "strobe": "0", "impacts": [place], "low": "1", "high": "1",
            "stable": True, "box": box}  # fmt: skip


def event(**more) -> dict:
    """Another one."""
    one = {**orbit(), "kind": "event", "signs": [0],
           "event": {"event": "fold", "impact": 0, "side": 0}}  # fmt: skip
    del one["stable"]
    return one


def cover(**more) -> dict:
    """A third one."""
    return {"kind": "all-orbits", "constants": {**BALL, "gravity": "1"}, "strobe": "0",
            "impacts": 1, "turns": 1, "orbits": [],
            "covers": [{"impacts": 1, "turns": 1, "boxes": ".", "orbits": []}]}  # fmt: skip


def from_to(first: int, last: int) -> str:
    return f"expected a whole number from {first} to {last}"


KINDS = "orbit, attractor, event, branch, curve, all-orbits, chaos, first-detachment, corner-hit"
NUMBER = 'expected a number as text, like "0.85"'
IN_BOX = "box.flights[0].passages[0]"
FORMS = [  # statement, path, the values that it may just have, those beyond, what is expected
    (orbit, ("turns",), (1, 1000), (0, 1001, True, "1"), from_to(1, 1000)),
    (orbit, ("impacts", 0, "stretch"), (0, 1000000), (-1, 1000001), from_to(0, 1000000)),
    (orbit, ("impacts", 0, "turn"), (0, 1000), (-1, 1001), from_to(0, 1000)),
    (orbit, ("box", "fixed"), (0, 1000000), (-1, 1000001), from_to(0, 1000000)),
    (orbit, ("box", "flights", 0, "rise"), (0, 1000000), (-1, 1.0), from_to(0, 1000000)),
    (orbit, ("box", "flights", 0, "fall"), (0, 1000000), (-1, None), from_to(0, 1000000)),
    (orbit, ("box", "flights", 0, "passages", 0, "turn"), (0, 2000), (2001,), from_to(0, 2000)),
    (event, ("event", "side"), (-1, 0, 1), (-2, 2), from_to(-1, 1)),
    (event, ("signs", 0), (-1, 1), (-2, 2), from_to(-1, 1)),
    (event, ("event", "impact"), (0, 1000000), (-1, 1000001), from_to(0, 1000000)),
    (cover, ("impacts",), (1, 9), (0, 10), from_to(1, 9)),
    (cover, ("covers", 0, "turns"), (1, 9), (0, 10), from_to(1, 9)),
    (boxes_on_a_plate, ("boxes", 0, "cells", 0), (1, 1000), (0, 1001), from_to(1, 1000)),
    (boxes_on_a_plate, ("coverings", 0, 0), (0, 1000000), (1000001,), from_to(0, 1000000)),
    (cover, ("covers", 0, "boxes"), (".", "o", "1..", "9"), ("", "0", "x"),
     "expected the letters of a cover"),
    (orbit, ("label",), ("", "x" * 400), ("x" * 401, "a\nb", 1),
     "expected a short text in one line"),
    (orbit, ("stable",), (True, False), (0, None), "expected true or false"),
    (orbit, ("kind",), (), ("theorem", None), f"expected one of {KINDS}"),
    (event, ("event", "event"), ("fold", "corner-impact", "period-doubling", "multipliers-meet"),
     ("grazing",), "expected one of period-doubling, fold, corner-impact, multipliers-meet"),
    (orbit, ("parameter",), ("rpm", "mass", "stiffness", "damping", "gravity", "preload",
                             "restitution", "cam.x", "cam." + "x" * 41),
     ("speed",), "expected one of rpm, mass, stiffness, damping, gravity, preload, restitution"),
    (orbit, ("parameter",), (), ("cam.1", "cam.", "cam." + "x" * 42), "expected a name"),
    (orbit, ("low",), ("1" * 400, "-0.5", "1e-999", "2e9", "1." + "1" * 1200),
     ("1" * 401, "1." + "1" * 1201, "1e1000", "1e+9", ".5", "1.", 1, None, ""), NUMBER),
    (orbit, ("impacts",), ([],), ({}, None, "x"), "expected a list"),
    (orbit, ("impacts", 0), (), ({"stretch": 0}, [], {"stretch": 0, "turn": 0, "more": 0}),
     "expected an object with the keys stretch, turn"),
]  # fmt: skip


@pytest.mark.parametrize(("made", "path", "inside", "outside", "expected"), FORMS)
def test_the_form_of_a_statement(made, path, inside, outside, expected, checked):
    """The limits of each number and text from both sides: a statement of this form may be false."""
    where = "the file.statements[0]"
    where += "".join(f".{x}" if isinstance(x, str) else f"[{x}]" for x in path)
    for value in inside:
        one = deepcopy(made())
        put(*path, value)(one)
        told = refused_in_a_file(checked, PLATE, one)
        assert not any("expected" in why for why in told)
    for value in outside:
        one = deepcopy(made())
        put(*path, value)(one)
        assert refused_in_a_file(checked, PLATE, one) == [f"{where}: {expected}"]


@pytest.mark.parametrize(("content", "why"), [
    ("{", "JSONDecodeError: Expecting property name enclosed in double quotes: line 1 column 2 "
          "(char 1)"),
    ("[]", "the file: expected an object with the keys format, cam, statements, uncovered"),
    ('{"a": NaN}', "found NaN"),
    ('{"a": -Infinity}', "found -Infinity"),
    ('{"a": 1, "a": 2}', "an object: expected each key once"),
    ({"format": "camcli-proof-2", "cam": None, "statements": [], "uncovered": []},
     "the file.format: expected one of camcli-proof-1"),
    ({"format": "camcli-proof-1", "cam": None, "statements": [orbit()], "uncovered": []},
     "the file.cam: expected a cam, as there are statements"),
])  # fmt: skip
def test_what_is_no_certificate_is_told_why(content, why, checked):
    code, text = checked(content)
    assert code == 2
    assert reasons(text) == [why]
    assert text.endswith(f"changed.json: no certificate: {why}\n")


def test_a_file_that_cannot_be_read_is_told_how_one_is_made(tmp_path, capsys):
    assert check.main([str(tmp_path / "nowhere")]) == 2
    assert capsys.readouterr().err == (
        f"{tmp_path / 'nowhere'}: no certificate: cannot be read (No such file or directory); "
        "`cam orbits --prove` writes out/orbits/proof.json\n"
    )


@pytest.mark.ci
def test_a_file_of_more_than_400_mb_is_not_read(tmp_path, capsys):
    with (tmp_path / "large.json").open("wb") as file:
        file.truncate(400_000_001)
    assert check.main([str(tmp_path / "large.json")]) == 2
    assert reasons(capsys.readouterr().err) == ["the file: expected a smaller one"]


# -- no sentence is left out


def sentences() -> dict[int, str]:
    """What the checker says where it refuses, by line: a pattern for what is put in."""
    found = {}
    tree = ast.parse(Path(check.__file__).read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        name = getattr(getattr(node, "func", None), "id", "")
        if name not in ("need", "expect", "RefusedError", "NoCertificateError") or not node.args:
            continue
        said = node.args[-1]
        parts = said.values if isinstance(said, ast.JoinedStr) else [said]
        texts = [re.escape(x.value) if isinstance(x, ast.Constant) else ".+" for x in parts]
        found[node.lineno] = "".join(texts)
    return found


def texts_of_tests() -> set[str]:
    """All texts in the tests of this folder, without the signs that begin and end a pattern."""
    found = set()
    for file in Path(__file__).parent.glob("test_*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.add(node.value.strip("^$"))
    return found


UNMET = {  # no certificate is known that is refused so
    re.escape("the slopes of a branch are not enclosed"),
}


def test_every_refusal_stands_whole_in_a_test():
    """So that a sentence whose meaning changes is noticed: alone, or behind where it is said."""
    told = {line: said for line, said in sentences().items() if re.search("[a-z]", said)}
    assert len(told) > 110
    texts = texts_of_tests()
    for line, said in told.items():
        alone = re.compile(rf"(?:.*(?:: |expected ))?{said}")
        assert said in UNMET or any(map(alone.fullmatch, texts)), f"check.py:{line}: {said}"


@pytest.mark.parametrize(
    ("landings", "rates", "refusal"),
    [
        ((1.5, 2.5), (0.2, 0.2), None),
        ((1.5, 3.5), (0.2, 0.2), "impact 2 may lie outside its stretch of the cam"),
        ((1.5, 1.5), (0.2, 0.2), "impact 2 may lie outside its stretch of the cam"),
        ((0.5, 2.5), (0.2, 0.2), "impact 1 may lie outside its stretch of the cam"),
        ((2.5, 2.5), (0.2, 0.2), "impact 1 may lie outside its stretch of the cam"),
        ((1.5, arb(2.5, 0.6)), (0.2, 0.2), "impact 2 may lie outside its stretch of the cam"),
        ((1.5, 2.5), (0.0, 0.2), "impact 1 may not bounce"),
        ((1.5, 2.5), (0.2, -0.1), "impact 2 may not bounce"),
    ],
)
def test_impacts_before_a_corner_lie_on_their_own_stretches(monkeypatch, landings, rates, refusal):
    """From the start of the first stretch, by an impact on the second and one on the third.

    Its flights and its gap at the corner are given: it is above zero at the lower speed.
    """
    ends = (1.0, 2.0, 3.0, 4.0)
    stretches = [SimpleNamespace(start=arb(end - 1.0), end=arb(end)) for end in ends]
    asked = []
    orbit = SimpleNamespace(
        n=4, machine=lambda rpm: "machine", clear=lambda z, k, cuts, lifts: asked.append((k, lifts))
    )
    unknowns = [arb(0), arb(0), *(arb(x) for x in (1.5, rates[0], 2.5, rates[1], 3.0, 0.0))]
    monkeypatch.setattr(check, "resting", lambda *_: None)
    monkeypatch.setattr(check, "lifts_off", lambda *_: None)
    monkeypatch.setattr(check, "Orbit", lambda *_: orbit)
    monkeypatch.setattr(check, "value_of", lambda gap: 121.0 - gap)
    monkeypatch.setattr(check, "slope_of", lambda gap: arb(1))
    monkeypatch.setattr(check, "flown", lambda orbit, statement, rpm: SimpleNamespace(
        unknowns=unknowns, landings=[*map(arb, landings), arb(3)], gap=rpm))  # fmt: skip
    impacts = [SimpleNamespace(stretch=1, turn=0), SimpleNamespace(stretch=2, turn=0)]
    statement = SimpleNamespace(
        start=0, corner=SimpleNamespace(stretch=3, turn=0), impacts=impacts, flights=["cuts"] * 3,
        constants={}, low=Fraction(120), high=Fraction(122),
    )  # fmt: skip
    cam = SimpleNamespace(stretches=stretches)
    if refusal is None:
        check.check_corner_hit(cam, statement)
        assert asked == [(0, True), (1, False), (2, False)]
        return
    with pytest.raises(check.RefusedError, match=refusal):
        check.check_corner_hit(cam, statement)


@pytest.mark.parametrize("value", [False, 0, "", [], {}])
@pytest.mark.parametrize(
    "reads", [check.place_or_none, check.exact_or_none, check.cam_of, check.event_at_end]
)
def test_nothing_but_null_says_that_there_is_none(reads, value):
    assert reads(None, "here") is None
    with pytest.raises(check.NoCertificateError):
        reads(value, "here")


def spread_cell(x, y, end, by_x, by_y):
    """A cell that lands at (x, y), with the slopes of x and y by the box's coordinates."""
    slopes = arb_mat([[by_x[0], by_y[0]], [by_x[1], by_y[1]]])
    return check.CellOfBox([end], (arb(x), arb(y)), slopes, [arb(0, 1), arb(0, 1)])


@pytest.mark.parametrize(
    ("right", "why"),
    [
        ((1.0, 0.1, 1, (2.0, 0.4), (1.5, 0.4)), None),  # x from 1.5, |y| up to 0.9
        ((1.0, 0.1, 1, (2.0, 0.4), (2.25, 0.4)), "an end of box 1 may be mapped into box 2"),
        ((1.0, 0.1, 1, (0.75, 0.4), (1.5, 0.4)), "an end of box 1 may be mapped into box 2"),
        ((1.0, 0.1, 1, (2.0, 0.6), (1.5, 0.4)), "box 1 may be mapped beside box 2"),
        ((1.0, 0.1, 1, (2.0, 0.4), (1.5, 0.6)), "box 1 may be mapped beside box 2"),
        ((1.0, 0.3, 1, (2.0, 0.4), (1.5, 0.4)), "box 1 may be mapped beside box 2"),
        ((-1.0, 0.1, 1, (-2.0, 0.4), (1.5, 0.4)), "box 1 is not mapped across box 2"),
    ],
)
def test_a_box_covers_another_wherever_its_cells_may_land(monkeypatch, right, why):
    """The other box is the unit square; both ends lie beyond it, each on its own side."""
    left = spread_cell(-1.0, 0.0, -1, (2.0, 0.4), (1.5, 0.4))
    monkeypatch.setattr(check, "Orbit", lambda *_: None)
    monkeypatch.setattr(check, "cells", lambda *_: [left, spread_cell(*right)])
    here = SimpleNamespace(stretch=0, turn=0)
    unit = SimpleNamespace(axes=arb_mat([[1, 0], [0, 1]]), middle=(arb(0), arb(0)), stretch=0,
                           lands=here)  # fmt: skip
    monkeypatch.setattr(check, "inverse", lambda axes: axes)
    monkeypatch.setattr(check, "ball_of", arb)
    statement = SimpleNamespace(
        boxes=[unit, unit], parameter="rpm", constants={}, low="1", high="1"
    )
    if why is None:
        check.check_covers(None, statement, 0, [1])
        return
    with pytest.raises(check.RefusedError, match=why):
        check.check_covers(None, statement, 0, [1])


@pytest.mark.parametrize(
    ("stretch", "side", "moved", "turn_after", "back"),
    [(2, 1, 0, 5, 1), (0, -1, 2, 3, -1), (1, 1, 2, 4, 0), (1, -1, 0, 4, 0)],
)
def test_on_the_other_side_of_the_end_of_a_turn_an_impact_has_another_phase(
    monkeypatch, stretch, side, moved, turn_after, back
):
    """Of three stretches the first follows the last one, a turn later: its phase counts from there.

    The signs are those of the products of both sides, (1 - 3 + 1) (1 - 4 + 1) and 5 times 6.
    """
    asked = []

    def trace_det(z):
        places = [(place.stretch, place.turn) for place in orbit.places]
        asked.append((places, [float(x) for x in z]))
        return arb(len(asked) + 2), arb(1), None

    here = SimpleNamespace(stretch=stretch, turn=4)
    other = SimpleNamespace(stretch=1, turn=0)
    orbit = SimpleNamespace(cam=SimpleNamespace(stretches=[0, 1, 2]), places=[other, here],
                            trace_det=trace_det)  # fmt: skip
    monkeypatch.setattr(check, "kink", lambda *_: False)
    hull = [arb(1), arb(2), arb("2.5"), arb(3), arb(700)]
    statement = SimpleNamespace(box=SimpleNamespace(hull=hull), event=SimpleNamespace(side=side),
                                signs=[1, 1])  # fmt: skip
    check.check_signs(orbit, statement, 1)
    assert asked[0] == ([(1, 0), (stretch, 4)], [1.0, 2.0, 2.5, 3.0, 700.0])
    places, z = asked[1]
    assert places == [(1, 0), (moved, turn_after)]
    assert z == pytest.approx([1.0, 2.0, 2.5 - 2.0 * pi * back, 3.0, 700.0])
    assert orbit.places == [other, here]
    for signs in ([1, -1], [-1, 1], [0, 1]):
        statement.signs = signs
        asked.clear()
        with pytest.raises(check.RefusedError, match="a sign of a corner impact"):
            check.check_signs(orbit, statement, 1)
