"""What the checker says of each kind of statement, word by word, on numbers chosen by hand.

Ranges of orbits are rounded inwards and those of events outwards: the numbers have more digits than
are printed, so that the last digit shows to which side.
"""

from __future__ import annotations

import json
from fractions import Fraction
from types import SimpleNamespace

import pytest
from flint import arb

from camcli import check
from camcli.cams.formula import formula_of
from camcli.scene import load_scene

ODD = "700.00000000000000000000000000049"  # 32 digits; 30 are printed
DOWN, UP = "700.000000000000000000000000000", "700.000000000000000000000000001"
EVEN = "710.5"
TURN = Fraction(1, 3)
THIRD = "0.333333333333333333333333333333"


def said(kind: str, **values) -> SimpleNamespace:
    """A statement of which no more is known than what is printed."""
    common = {"label": "P(2;3:1)", "parameter": "rpm", "low": Fraction(ODD), "high": Fraction(EVEN),
              "stable": True}  # fmt: skip
    return SimpleNamespace(kind=kind, **{**common, **values})


def end(parameter, second) -> SimpleNamespace:
    """An end of a curve: the ranges of both numbers."""
    ranges = [SimpleNamespace(low=Fraction(a), high=Fraction(b)) for a, b in (parameter, second)]
    return SimpleNamespace(parameter=ranges[0], second=ranges[1])


def boxes(*turns: int) -> list[SimpleNamespace]:
    """Boxes of impacts whose flights last so many turns."""
    return [SimpleNamespace(lands=SimpleNamespace(turn=turn)) for turn in turns]


def axes(*numbers) -> list[list[arb]]:
    return [[arb(x) for x in numbers]]


FOLD = SimpleNamespace(event="fold")
ALL = {"constants": {"rpm": Fraction("700.25")}, "impacts": 2, "turns": 1}
ONE = said("orbit", label="P(1;1)", stable=False)
CLAIMS = [
    (said("orbit"), f"P(2;3:1), stable, for every rpm from {UP} to 710.5: exactly one in its box"),
    (said("orbit", stable=False, low=Fraction(ODD), high=Fraction(ODD)),
     f"P(2;3:1), unstable, for every rpm from {ODD} to {ODD}: exactly one in its box"),
    (said("attractor", axes=axes("3e-4", "4e-4", "0.0016", "0.0012")),
     "every motion with an impact in an ellipse about impact 1 of P(2;3:1), 0.0286 deg and 0.00199 "
     f"m/rad to either side, tends to it, for every rpm from {UP} to 710.5"),
    (said("attractor", axes=[]),
     "every motion with an impact in an ellipse about impact 1 of P(2;3:1) tends to it, for every "
     f"rpm from {UP} to 710.5"),
    (said("event", event=FOLD, low=TURN, high=TURN, parameter="cam.lift"),
     f"fold of P(2;3:1), cam.lift from {THIRD} to {THIRD[:-1]}4"),
    (said("branch", low=[Fraction(1), Fraction(ODD)], high=[Fraction(ODD), Fraction(800)]),
     f"P(2;3:1) exists and is stable for all rpm between {UP} and {DOWN}"),
    (said("curve", event=FOLD, parameter="mass", second="cam.lift",
          begin=end(("1.25", "1.25"), (TURN, TURN + Fraction(1, 10**40))),
          end=end((Fraction("1.3"), Fraction(ODD)), ("2", "2"))),
     f"fold of P(2;3:1) all along a curve without a gap from mass = 1.25, cam.lift = [{THIRD}, "
     f"{THIRD[:-1]}4] to mass = [1.3, {UP}], cam.lift = 2"),
    (said("all-orbits", **ALL, orbits=[]),
     "at rpm = 700.25 the orbits without rest that have 1 to 2 impacts in 1 turn are 0: none"),
    (said("all-orbits", **{**ALL, "impacts": 1, "turns": 3}, orbits=[said("orbit"), ONE]),
     "at rpm = 700.25 the orbits without rest that have 1 impact in 1 to 3 turns are 2: P(2;3:1), "
     "stable; P(1;1), unstable"),
    (said("all-orbits", **{**ALL, "constants": {"rpm": None}}, orbits=[]),
     "at rpm = open the orbits without rest that have 1 to 2 impacts in 1 turn are 0: none"),
    (said("chaos", boxes=boxes(0, 1, 0), coverings=[[0, 1]], growth=Fraction(4, 3)),
     f"chaos for every rpm from {UP} to 710.5: 3 boxes of impacts with 1 coverings, so infinitely "
     "many periodic orbits and an entropy of the impact map of at least log(1."
     f"{'3' * 29}); from one impact to the next at most 1 turn passes"),
    (said("chaos", boxes=boxes(2, 1), coverings=[[0, 1], [1, 1]], growth=Fraction(3, 2)),
     f"chaos for every rpm from {UP} to 710.5: 2 boxes of impacts with 2 coverings, so infinitely "
     "many periodic orbits and an entropy of the impact map of at least log(1.5); from one impact "
     "to the next at most 2 turns pass"),
    (said("chaos", boxes=boxes(0, 0), coverings=[[0, 1]], growth=Fraction(3, 2),
          high=Fraction(UP) + Fraction(1, 10**32)),
     f"chaos for every rpm from {UP} to {UP}: 2 boxes of impacts with 1 coverings, so infinitely "
     "many periodic orbits and an entropy of the impact map of at least log(1.5); from one impact "
     "to the next at most 1 turn passes"),
    (said("first-detachment", low=TURN, high=Fraction(EVEN)),
     f"a follower that rests on the cam stays there at every rpm up to {THIRD}, and leaves it at "
     "710.5"),
    (said("corner-hit", start=2, corner=SimpleNamespace(stretch=0), impacts=[None, None], low=TURN,
          high=TURN),
     "a follower that rests on the cam leaves it at 160 deg (the start of stretch 2), and its "
     "impact 3 is at 90 deg (the end of stretch 0), for exactly one rpm from "
     f"{THIRD} to {THIRD[:-1]}4"),
    (said("corner-hit", start=9, corner=SimpleNamespace(stretch=9), impacts=[]),
     "a follower that rests on the cam leaves it at the start of stretch 9, and its impact 1 is at "
     f"the end of stretch 9, for exactly one rpm from {DOWN} to 710.5"),
]  # fmt: skip


@pytest.fixture
def cam(bits) -> check.Cam:
    """A cam that dwells to 90 deg, rises to 160, dwells to 200 and falls to 270."""
    way = {"length_deg": 70, "law": "harmonic"}
    scene = {
        "follower": {"mass": 1, "stiffness": 1, "restitution": 0.5},
        "cam": {"kind": "law", "base": 0.1, "lift": 0.15, "top_dwell_deg": 40,
                "rise": {"start_deg": 90, **way}, "fall": way},
    }  # fmt: skip
    return check.cam_of(formula_of(load_scene(scene).cam), "")


@pytest.mark.parametrize(("statement", "words"), CLAIMS)
def test_what_is_said_of_a_statement(statement, words, cam):
    assert check.claim(statement, cam) == words


def resting(low: str, high: str) -> dict:
    """A follower of 1 kg under 1 N rests on c = 1 - cos theta up to 1 rad/s, 9.5493 rpm.

    The force 1 + omega^2 cos theta is least at pi, where the second stretch begins.
    """
    constants = {**dict.fromkeys(check.CONSTANTS, "0"), "mass": "1", "gravity": "1",
                 "restitution": "0.5", "rpm": None}  # fmt: skip
    return {"kind": "first-detachment", "low": low, "high": high, "stretch": 1, "at_end": False,
            "cuts": [["0.5", "3.05"], ["3.23", "5.8"]], "constants": constants}  # fmt: skip


def half(end: str) -> dict:
    """A stretch of that cam."""
    return {"end": end, "center": "0", "polynomial": ["1"], "wave": ["-1", "0", "1"], "circle": [],
            "seat": False}  # fmt: skip


def test_what_is_printed_of_a_file(checked):
    """A line for each statement, one for how many are confirmed, one for each without a proof."""
    cam = {"kind": "eccentric", "numbers": {}, "formulas": [], "seat_restitution": None,
           "stretches": [half("pi"), half("2*pi")]}  # fmt: skip
    known, early, late = (resting(*x) for x in (("9.5", "9.55"), ("9", "9.5"), ("9.55", "9.6")))
    content = {"format": "camcli-proof-1", "cam": cam, "uncovered": ["a", "b"],
               "statements": [known, early, late, known]}  # fmt: skip
    stays = "a follower that rests on the cam stays there at every rpm up to"
    assert checked(content) == (1, "\n".join([
        f"confirmed: {stays} 9.5, and leaves it at 9.55",
        f"not confirmed: {stays} 9, and leaves it at 9.5: the force may not end",
        f"not confirmed: {stays} 9.55, and leaves it at 9.6: the force may end at a lower speed",
        f"confirmed: {stays} 9.5, and leaves it at 9.55",
        "2 of 4 statements are confirmed",
        "without a certificate: a",
        "without a certificate: b",
    ]) + "\n")  # fmt: skip
    code, text = checked({**content, "statements": [known], "uncovered": []})
    assert code == 0
    assert text.endswith(" 9.55\n1 of 1 statement is confirmed\n")


def test_without_a_file_the_checker_says_what_it_is(capsys):
    for arguments, code in (([], 2), (["a", "b"], 2), (["-x"], 2), (["-h"], 0), (["--help"], 0)):
        assert check.main(arguments) == code
        printed = capsys.readouterr()
        assert printed.out == f"{check.__doc__}\n"
        assert printed.err == ""


def test_a_file_of_another_program_is_told_in_one_line(tmp_path, capsys):
    """What Python says of a text that has no end."""
    (tmp_path / "a").write_text(json.dumps("x" * 1000)[:-1])
    assert check.main([str(tmp_path / "a")]) == 2
    text = capsys.readouterr().err
    assert text == (
        f"{tmp_path / 'a'}: no certificate: JSONDecodeError: Unterminated string starting at: "
        "line 1 column 1 (char 0)\n"
    )
