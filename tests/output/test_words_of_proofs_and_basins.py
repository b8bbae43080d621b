"""Whole sentences on border collisions, proofs, basins and the page, of values made by hand.

Each branch of a sentence has its case; numbers are such that each rounds another way.
"""

from __future__ import annotations

from math import radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.border_collision import (
    THEOREM,
    Collision,
    Cycle,
    Equal,
    Inequality,
    Prediction,
    Rule,
)
from camcli.analysis.orbits.atlas import Atlas
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.proofs import Proof, Proofs, ProofStep
from camcli.analysis.orbits.starts import Starts
from camcli.errors import Status, plural
from camcli.quantities import METRES, MILLIMETRES
from camcli.words import basins, explore, proofs
from camcli.words.border_collision import (
    collision_words,
    equality_words,
    inequality_record,
    inequality_text,
)
from camcli.words.sweep import atlas_words

# --- border collisions


@pytest.mark.parametrize(
    ("rule", "side", "text", "left_is_greater"),
    [
        (Rule.PRODUCT_AT_ONE, "", "(1 - tau_L + delta_L)(1 - tau_R + delta_R) > 0", True),
        (Rule.PRODUCT_AT_MINUS_ONE, "", "(1 + tau_L + delta_L)(1 + tau_R + delta_R) < 0", False),
        (Rule.AT_ONE, "R", "1 - tau_R + delta_R > 0", True),
        (Rule.AT_MINUS_ONE, "L", "1 + tau_L + delta_L > 0", True),
        (Rule.DET_BELOW_ONE, "R", "delta_R < 1", False),
        (Rule.DET_POSITIVE, "L", "delta_L > 0", True),
        (Rule.GROWTH, "", "log growth per step at mu = 0 > 0.0015", True),
        (Rule.BEYOND_ONE, "L", "tau_L > 1 + delta_L", True),
        (Rule.BEYOND_MINUS_ONE, "R", "tau_R < -(1 + delta_R)", False),
        (Rule.TRAPPING, "L", "(l1 tau_R - delta_R)(l1 - 1) + l1^2 (1 - l2) > 0, l1 > l2 the "
         "multipliers of L", True),
        (Rule.TRAPPING, "R", "(l1 tau_L - delta_L)(l1 - 1) + l1^2 (1 - l2) > 0, l1 > l2 the "
         "multipliers of R", True),
    ],
)  # fmt: skip
def test_an_inequality_is_a_formula_that_holds_as_it_is_written(rule, side, text, left_is_greater):
    assert inequality_text(Inequality(rule, side, 0.0)) == text
    for left, right in ((1.25, 0.75), (0.75, 1.25)):
        assert inequality_record(Inequality(rule, side, left, right)) == {
            "text": text, "left": left, "right": right,
            "holds": left_is_greater == (left > right),
        }  # fmt: skip
    assert not Inequality(rule, side, 0.5, 0.5).holds


@pytest.mark.parametrize(
    ("where", "equality", "said"),
    [
        ("L", Equal.PLUS_ONE, "on L, a multiplier is +1"),
        ("R", Equal.MINUS_ONE, "on R, a multiplier is -1"),
        ("LR", Equal.UNIT_PAIR, "along LR, two multipliers on the unit circle"),
        ("L", Equal.TANGENCY,
         "the unstable manifold of a fixed point touches the stable one of the saddle"),
    ],
)  # fmt: skip
def test_an_equality_is_told_with_its_place(where, equality, said):
    assert equality_words(where, equality) == said


BELOW, ABOVE = "Where the normal form's parameter is below 0, ", "Where it is above 0, "
FIXED = "the fixed point R attracts."
PAIR = complex(0.25, 0.7512345), complex(0.25, -0.7512345)


def collision(kind="persistence", below=None, cycle=None, chaos=(), growth=None, equal=()):
    fails = (Inequality(Rule.BEYOND_ONE, "L", 0.5, 1.5),)
    last = cycle or Cycle("LR", (0.5, 0.25), True)
    return Collision(
        kind, (), growth, tuple(chaos) or fails, tuple(equal), (last, last, last),
        below or Prediction("fixed-point", word="L"), Prediction("fixed-point", word="R"),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("below", "said"),
    [
        (Prediction("none"), "nothing bounded attracts"),
        (Prediction("fixed-point", 1, -0.25, "L"), "the fixed point L attracts"),
        (Prediction("cycle", 3, -0.25, "LLR"), "the cycle LLR of period 3 attracts"),
        (Prediction("chaos", 0, 0.123456, "", 0.0234),
         "there is a chaotic attractor, largest exponent 0.1235 +- 0.02 per step"),
        (Prediction("chaos"), "there is a chaotic attractor"),
        (Prediction("several", word="L, LLR"), "several attract: L, LLR"),
        (Prediction("undecided"),
         "what attracts is not decided: orbits stay bounded, without a period"),
        (Prediction("undecided", 64, -0.000987654, "LLR", 0.00456),
         "what attracts is not decided: orbits stay bounded, LLR, largest exponent "
         "-0.0009877 +- 0.005 per step"),
    ],
)  # fmt: skip
def test_what_attracts_on_a_side(below, said):
    assert collision_words(collision(below=below)) == [
        "persistence: a fixed point on each side, and no cycle LR is born.",
        f"{BELOW}{said}.",
        f"{ABOVE}{FIXED}",
    ]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"cycle": Cycle("LR", (-1.2345678, 0.5), False, (), 1)},
         [f"{ABOVE}the cycle LR exists and is unstable: larger multiplier -1.23457."]),
        ({"cycle": Cycle("LR", PAIR, True, (), -1)},
         [f"{BELOW}the cycle LR exists and is stable: multipliers 0.25 +- 0.751235 i."]),
        ({"chaos": [Inequality(Rule.BEYOND_ONE, "L", 2.0, 1.5),
                    Inequality(Rule.DET_BELOW_ONE, "R", 1.2345678, 1.0)]},
         ["The theorem on robust chaos does not apply: delta_R < 1 fails, 1.23457 against 1."]),
        ({"chaos": [Inequality(Rule.BEYOND_ONE, "L", 2.0, 1.5)] * (THEOREM - 2)
                   + [Inequality(Rule.TRAPPING, "R", -0.0312345678)]},
         ["The theorem on robust chaos does not apply: (l1 tau_L - delta_L)(l1 - 1) + l1^2 (1 - "
          "l2) > 0, l1 > l2 the multipliers of R fails, -0.0312346 against 0."]),
        ({"chaos": [Inequality(Rule.BEYOND_ONE, "L", 2.0, 1.5)] * (THEOREM - 1)
                   + [Inequality(Rule.BEYOND_ONE, "R", 0.5, 1.25)]},
         ["The theorem on robust chaos does not apply: tau_R > 1 + delta_R fails, 0.5 against "
          "1.25, which leaves it open whether a chaotic attractor exists."]),
        ({"chaos": [Inequality(Rule.BEYOND_ONE, "L", 2.0, 1.5)] * THEOREM}, []),
    ],
)  # fmt: skip
def test_what_follows_on_the_cycle_of_two_and_on_the_theorem(more, said):
    assert collision_words(collision(**more))[3:] == said


@pytest.mark.parametrize(
    ("growth", "doubtful"), [(0.0015, True), (-0.0015, True), (0.00151, False), (-0.00151, False)]
)
def test_what_is_equal_and_a_growth_that_decides_nothing(growth, doubtful):
    equal = ("L", Equal.PLUS_ONE), ("LR", Equal.UNIT_PAIR)
    found = collision("degenerate", growth=Inequality(Rule.GROWTH, "", growth), equal=equal)
    small = (
        f"The growth at the event, {growth} per step, is too small to exclude that the event is "
        "dangerous."
    )
    assert collision_words(found)[:-2] == [
        "degenerate: an equality holds within rounding: the linear parts do not decide.",
        "Equal within rounding: on L, a multiplier is +1.",
        "Equal within rounding: along LR, two multipliers on the unit circle.",
        *([small] if doubtful else []),
    ]


# --- proofs


def orbit(label="P(1;1)", **more):
    return Made(**{"label": label, "rpm": 30.0, "stable": True, "resting": False, **more})


def proved(orbits=(), orbit_proofs=(), **more):
    """The sentences on proofs; orbits at 30 rpm, whose cam turns by pi rad/s."""
    own = {"points": [], "events": [], "ranges": [], "curves": [], "curve_ranges": [],
           "flank_excess": 0.0, "orbits": list(orbit_proofs)}  # fmt: skip
    given = {"bifurcations": [], "branches": [], "plane": None}
    given.update({key: more.pop(key) for key in list(more) if key in given})
    question = Made(parameter="rpm", plane=given.pop("plane"))
    found = Made(question=question, orbits=list(orbits), proofs=Proofs(**{**own, **more}), **given)
    return list(proofs.proof_sentences(found))


@pytest.mark.parametrize(
    ("one", "holds_for", "said"),
    [
        (orbit(), HoldsFor.LAST_DIGIT,
         "proved: P(1;1), stable, rpm = 30.0 and every value that rounds to it"),
        (orbit(stable=False), HoldsFor.EXACT_DATA,
         "proved: P(1;1), unstable, rpm = 30.0, exactly these data"),
        (orbit("P(1;inf)", resting=True), HoldsFor.EXACT_DATA,
         "proved: P(1;inf), rpm = 30.0, exactly these data"),
    ],
)  # fmt: skip
def test_a_proof_of_an_orbit_says_which_machines_it_is_about(one, holds_for, said):
    assert proved([one], [Proof(holds_for=holds_for)]) == [said]


@pytest.mark.parametrize(
    ("starts", "more"),
    [
        (None, ""),
        (Starts(0.0123499, None),
         ", so that starts at the strobe on an area of at least 0.0123 m * m/s end there"),
        (Starts(0.5, 0.0123499), ", so that at least 1.23 % of the starts in the window of cam "
         "basins at 30.0 rpm end there"),
        (Starts(0.5, 0.0123999), ", so that at least 1.23 % of the starts in the window of cam "
         "basins at 30.0 rpm end there"),
    ],
)  # fmt: skip
def test_an_ellipse_has_half_widths_and_starts_that_are_never_said_larger(starts, more):
    """Rows (a, b) and (c, d) of the ellipse reach hypot(a, b) rad and hypot(c, d) m/rad."""
    axes = ((radians(3.0057), radians(4.0076), 0.60072, 0.80096),)  # 5.0095 deg, 3.1454 m/s
    said = proved([orbit()], [Proof(axes=axes, starts=starts)])
    assert said[1:] == [
        "proved: every motion with an impact in an ellipse about impact 1 of P(1;1), 5 deg and "
        f"3.14 m/s to either side, tends to it{more}"
    ]


@pytest.mark.parametrize(("excess", "way"), [(2.5e-16, "more"), (-2.5e-16, "less")])
def test_a_flank_that_is_closed_is_larger_or_smaller(excess, way):
    assert proofs.closed_flank(excess).endswith(
        f"2.5e-16 m {way} than the flank_radius of the scene"
    )
    assert proved(flank_excess=excess) == [proofs.closed_flank(excess)]


def test_what_is_proved_along_curves():
    step, why = ProofStep.GRAZES, "a flight is too near to grazing to exclude a contact"
    places = (376.37320000001, 0.7717171717171), (380.5, 0.8)
    where = "from rpm 376.3732, restitution 0.7717171717 to rpm 380.5, restitution 0.8"
    said = proved(
        plane=Made(names=("rpm", "follower.restitution")),
        curves=[[Proof(), Proof(step), Proof(step), Proof(step)]],
        curve_ranges=[CurveRange(2, 1, 5, places, 7), CurveRange(3, 1, 2, places, 0, step)],
    )
    assert said == [
        "proved: 1 of the 4 points of curve 1",
        f"not proved: a point of curve 1: {why}",
        f"proved: curve 2 has no gap {where}, where its bifurcation happens at every value between "
        "(7 boxes)",
        f"not proved: curve 3 has no gap {where}: {why}",
    ]
    assert proofs.place_of((2.5, 0.125), ("cam.lift", "stiffness")) == "lift 2.5, stiffness 0.125"


def test_a_budget_that_is_used_up_is_told_once_of_all_curves():
    """Of one part with its places, of more by the numbers of their curves."""
    names, places = ("rpm", "mass"), ((1.5, 2.5), (3.5, 4.5))
    why = "the budget of work was used up"
    own = [CurveRange(1, 1, 4, places, 7), CurveRange(2, 1, 2, places, 0, ProofStep.PASSES)]
    spent = [CurveRange(n, 2, 4, places, 0, ProofStep.WORK_BUDGET) for n in (2, 2, 3, 5)]

    def told(count: int) -> list[str]:
        """What is said where so many parts are left out."""
        return list(proofs.along_curves([*own, *spent[:count]], names))

    assert told(0) == [proofs.without_a_gap(part, names) for part in own]
    alone = f"not proved: curve 2 has no gap from rpm 1.5, mass 2.5 to rpm 3.5, mass 4.5: {why}"
    assert told(1) == [*told(0), alone]
    assert told(2) == [*told(0), f"not proved: parts of curve 2: {why}"]
    assert told(3) == [*told(0), f"not proved: parts of curves 2 and 3: {why}"]
    assert told(4) == [*told(0), f"not proved: parts of curves 2, 3 and 5: {why}"]


def test_what_is_proved_of_the_curves_on_a_map():
    """Curves of longer orbits by their turns; the flank where it differs."""
    places = (376.5, 0.75), (380.5, 0.875)
    turns = (1, 9, 7, 7)
    points = [[Made(orbit=Made(turns=one))] for one in turns]
    named = {
        "kind": "fold",
        "label": "",
        "corner": "",
        "ends": (Kind.CLOSED,) * 2,
        "limits": ("", ""),
    }
    atlas = Atlas(
        Made(names=("rpm", "follower.restitution")),
        curves=[Made(points=one, **named) for one in points],
        ranges=[CurveRange(1, 1, 3, places, 7)],
    )
    ends = [f"curve {n}, fold, ends: closed" for n in (1, 2, 3, 4)]
    own = (
        "proved: curve 1 has no gap from rpm 376.5, restitution 0.75 to rpm 380.5, restitution "
        "0.875, where its bifurcation happens at every value between (7 boxes)"
    )
    why = "sweep.prove_turns is 4"
    longer = [
        f"not tried: a proof of curves 3, 4, whose orbits have 7 turns: {why}",
        f"not tried: a proof of curve 2, whose orbits have 9 turns: {why}",
    ]
    assert atlas_words(atlas, 4, 0.0) == [*ends, own, *longer]
    assert atlas_words(atlas, 4, 1e-16) == [*ends, proofs.closed_flank(1e-16), own, *longer]
    assert atlas.not_tried == [2, 3, 4]
    atlas.ranges = []  # all of them have too many turns to be tried
    first = f"not tried: a proof of curve 1, whose orbits have 1 turn: {why}"
    assert atlas_words(atlas, 4, 1e-16) == [*ends, proofs.closed_flank(1e-16), first, *longer]
    atlas.ranges = None
    assert atlas_words(atlas, 4, 1e-16) == ends
    assert atlas.not_tried == []


def test_what_orbits_share_is_told_once_and_a_branch_may_be_proved_unstable():
    """Two unresolved orbits of one label; an event of two branches."""
    step = Proof(ProofStep.GRAZES)
    why = "a flight is too near to grazing to exclude a contact"
    event = Made(kind=Kind.FOLD, label="P(1;1)")
    told = proved([orbit(), orbit(rpm=31.0)], [step, step], bifurcations=[event, event],
                  events=[Proof(), Proof()])  # fmt: skip
    assert told == [f"not proved: P(1;1): {why}", "proved: fold of P(1;1)"]
    parts = [Made(low="1.5", high="2.5", branch=k, label="P(1;1)", stable=stable, boxes=k,
                  failed_step=failed)
             for k, stable, failed in ((1, True, None), (2, False, None),
                                       (3, True, ProofStep.GRAZES))]  # fmt: skip
    along = "for all rpm from 1.5 to 2.5 (branch"
    assert proved(ranges=parts) == [
        f"proved: P(1;1) exists and is stable {along} 1, 1 box)",
        f"proved: P(1;1) exists and is unstable {along} 2, 2 boxes)",
        f"not proved: P(1;1) {along} 3): {why}",
    ]


@pytest.mark.parametrize("count", [3, 4])
def test_points_without_a_proof_are_named_up_to_three(count):
    points = [Proof(ProofStep.PULLS)] * count
    branch = Made(number=2, points=[Made(value=700.123456789012 + n) for n in range(count)])
    end = "701.1234568, 702.1234568" + (", ..." if count > 3 else "")
    said = proved(points=[points], branches=[branch])
    assert said[1] == (
        f"not proved: {count} points of branch 2, rpm = 700.1234568, {end}: an impact would have "
        "to pull"
    )
    assert said[0] == f"proved: 0 of the {count} points of branch 2"
    points = [Proof(), *points[1:-1], Proof(ProofStep.GRAZES)]
    said = proved(points=[points], branches=[branch])
    assert said[0] == f"proved: 1 of the {count} points of branch 2"
    assert said[1].startswith(f"not proved: {plural(count - 2, 'point')} of branch 2")
    assert said[2].startswith("not proved: 1 point of branch 2")


def test_a_branch_that_was_not_computed_is_no_gap_of_a_proof():
    assert list(proofs.proof_sentences(Made(proofs=None))) == []


# --- basins


def speed(**more):
    """25 cells, of which 20 were computed."""
    own = {
        "rpm": 358.25, "value": 358.25, "computed": 20, "cells": 25, "undecided": 0, "troubled": {},
        "rests": [], "turns": (12, 345, 6789), "saddles": None, "uncertainty": None, "level": None,
        "window": Made(nq=5, nv=4, q=(0.0125, 0.5), v=(-1.25, 2.5)),
        "entropies": {"basin_entropy": 0.123456, "boundary_entropy": 0.654321,
                      "boundary_boxes": 3, "boxes": 8},
    }  # fmt: skip
    return Made(**{**own, **more})


def test_notes_on_basins():
    def said(*speeds):
        return basins.basins_notes(Made(speeds=speeds), 4000)

    assert said(speed(), speed(computed=0)) == []
    assert said(speed(computed=0), speed(computed=0)) == [
        "no start of this window lies above the cam: raise basins.q"
    ]
    rests = [(0, Made(holds_for=HoldsFor.ROUNDING))]
    assert said(
        speed(undecided=3, troubled={int(Status.NO_RETURN): 2}, rests=rests),
        speed(undecided=4, troubled={int(Status.NO_RETURN): 5, int(Status.UNRESOLVED): 1}),
    ) == [
        "rounding chose what follows a rest, and so the attractor, of 1 departure: the exact "
        "motion could not be followed so far",
        "7 of 50 cells are undecided: they met no attractor within 4000 turns; raise "
        "basins.budget, unless the motion has no attractor",
        f"{Status.NO_RETURN.text} in 7 cells: the follower left the cam and nothing brings it "
        "back; give the follower a spring, gravity or a preload",
        f"{Status.UNRESOLVED.text} in 1 cell: a contact is closer to grazing than double "
        "precision can tell; move the speed by a relative 1e-12, or treat both outcomes as "
        "possible",
    ]


def test_what_a_grid_says():
    plain = "cells 25, computed 20 (80 %); turns per cell: median 12, 99 % 345, most 6789"
    assert basins.grid_lines(speed(), verbose=False) == [plain]
    saddles = [Made(orbit=Made(label="P(3;" + "2:" * 20 + "1)"), led=7, tried=8)]
    doubt = Made(exponent=0.12345, error=0.00678, dimension=1.87655)
    assert basins.grid_lines(speed(saddles=saddles, uncertainty=doubt), verbose=True) == [
        plain,
        "basin entropy 0.1235, boundary entropy 0.6543 (3 of 8 boxes of 5 x 5 cells)",
        "saddle P(3;2:2:2:2:2:2:2:2:2:2:2:2... on the boundary: 7 of 8 motions there are led to it",
        "uncertainty exponent 0.123 +- 0.007, boundary dimension 1.877",
    ]
    counts = [(1, 8, "1 of 8 motions there is led"), (0, 1, "0 of 1 motion there are led")]
    for led, tried, words in counts:
        saddle = Made(orbit=Made(label="P(1;1)"), led=led, tried=tried)
        assert basins.grid_lines(speed(saddles=[saddle]), verbose=False) == [
            plain, f"saddle P(1;1) on the boundary: {words} to it"
        ]  # fmt: skip
    assert basins.fraction_text(0.3641975, 0.0083) == "36.4 +- 0.8 %"
    assert basins.fraction_text(0.3641975, 0.083) == "36 +- 8 %"
    assert basins.fraction_text(1.0, 0.0) == "100 %"
    assert basins.share_words(4, "P(1;1)", 0.123456) == "4: P(1;1) 12.3 %"
    assert basins.grid_title(speed(rpm=358.123456789)) == "358.1234568 rpm"


def test_titles_and_captions_of_basins():
    three = [speed(value=x) for x in (-0.75, 0.5, 0.25)]
    one = speed(value=0.5)
    assert basins.picture_title("Basins", three, "follower.restitution") == (
        "Basins, coefficient of restitution −0.75 to 0.50 at 358.25 rpm"
    )
    assert basins.picture_title("Basins", [one, one], "rpm") == "Basins, 0.5 rpm"
    study = Made(speeds=three)
    assert basins.grids_title(study, "rpm") == "3 speeds"
    assert basins.grids_title(study, "follower.mass") == "3 values at 358.25 rpm"
    window = one.window
    assert basins.windows_words(study, window, MILLIMETRES, "rpm") == (
        "3 speeds, 5 × 4 starts each, q from 12.5 to 500.0 mm, v from −1.25 to 2.50 m/s"
    )
    assert basins.windows_words(study, window, METRES, "follower.mass").startswith(
        "3 values, 5 × 4 starts each, q from 0.0125 to 0.5000 m, "
    )


def test_what_stands_below_basins():
    system = Made(strobe=radians(-77.25))
    start = "5 × 4 starts (q, v) at θ = −77.25 deg"
    assert basins.window_words([speed()], system) == (
        f"{start}; basin entropy 0.123, boundary entropy 0.654"
    )
    refined = [speed(level=2), speed(computed=5)]
    assert basins.window_words(refined, system) == (
        f"{start}, 50 % of the cells computed (boundaries refined)"
    )
    no_boundary = {"basin_entropy": 0.0, "boundary_entropy": 0.5, "boundary_boxes": 0}
    doubt = Made(exponent=0.12345, error=0.00678, dimension=1.87655)
    assert basins.window_words([speed(entropies=no_boundary, uncertainty=doubt)], system) == (
        f"{start}; basin entropy 0, boundary dimension 1.877 ± 0.007"
    )
    assert basins.saddle_words("P(1;2)", 8, 8) == "saddle P(1;2)"
    assert basins.saddle_words("P(1;2)", 7, 8) == "saddle P(1;2): 7 of 8 motions led to it"
    assert basins.further_words(3) == "3 further attractors, in repeated colours"


# --- the page


def test_stops_of_the_page_of_the_other_machine():
    """Each stop of a valve train and of a plain follower, as `test_stops_of_the_page` has half."""
    plain = explore.Machine("follower", "its weight", 0.75, valve=False)
    engine = explore.Machine("valve train", "the spring", 0.5, valve=True)
    assert engine.contact(700.25).startswith("At 700.2 rpm the spring keeps the valve train on ")
    assert plain.lift_off(3400.5, 3352.123, "30°") == (
        "Above 3352.12 rpm the cam turns away faster than its weight can push: at 3400 rpm the "
        "follower leaves it at 30°; the contact arrow goes."
    )
    assert plain.chatter(190.25).startswith(
        "At 190.2 rpm the follower lands and bounces, each time 0.75 times as fast: "
    )
    assert engine.two_motions(355.1234567, "P(1;inf)", "P(2;1:1)") == (
        "At 355.123 rpm the same machine runs in two ways, P(1;∞) or P(2;1:1): how it was "
        "started settles which; the buttons below switch."
    )
    assert explore.angle(123.456) == "123.5°"
    assert explore.lift_off("b") == "Lift-off at b"
    assert explore.corner_impact("c") == "Impact at corner c"
    stops = explore.IN_CONTACT, explore.CHATTER, explore.CHAOS, explore.TWO_MOTIONS
    assert stops == ("Contact", "Chatter", "Chaos", "Two motions")
    assert explore.BASIN_AXES == ["position q at the strobe (m)", "velocity v at the strobe (m/s)"]


def test_stops_of_an_engine_are_told_of_both_shafts():
    engine = explore.Machine("valve train", "the spring", 0.5, valve=True, crank=2.0)
    assert engine.contact(2933.4).startswith("At 2933 rpm (5866 of the crank) the spring keeps ")
    assert engine.lift_off(3454.1, 3258.477, "186°") == (
        "Above 3258.48 rpm (6516.96 of the crank) the cam turns away faster than the spring can "
        "push: at 3454 rpm the valve floats from 186° on; the contact arrow goes."
    )
    assert engine.chatter(5028.2).startswith("At 5028 rpm (10056 of the crank) the valve train ")
    assert engine.lash(2800.0, 2.5e-4, 1.2862, 1.284) == (
        "At 2800 rpm (5600 of the crank) the cam takes up the lash of 0.25 mm and strikes the "
        "valve train at 1.29 m/s; as it shuts, that strikes the seat at 1.28 m/s."
    )
    assert engine.hard_landing(4000.0, 4.4912) == (
        "At 4000 rpm (8000 of the crank) the valve train lands hardest, at 4.49 m/s: such blows "
        "wear out the cam and all that runs on it."
    )


def test_stops_of_a_ball_and_of_a_follower_without_rest():
    ball = explore.Machine("ball", "its weight", 0.5, valve=False, cam="table")
    assert ball.contact(851.2).startswith(
        "At 851.2 rpm its weight keeps the ball on the table all "
    )
    assert ball.lift_off(1002.5, 945.77, "152.8°") == (
        "Above 945.77 rpm the table drops away faster than the ball falls: at 1002 rpm the ball "
        "leaves it at 152.8°; the contact arrow goes."
    )
    plain = explore.Machine("follower", "the spring", 0.8, valve=False)
    assert plain.once_a_turn(22.25, "P(1;1)") == (
        "At 22.25 rpm the follower bounces once a turn, each turn like the one before: P(1;1), a "
        "period of one turn with one impact."
    )


@pytest.mark.parametrize(
    ("kind", "stiffness", "crank", "wanted"),
    [
        (
            "table",
            1e4,
            False,
            explore.Machine("valve train", "the spring", 0.375, True, "cam", 2.0),
        ),
        ("law", 0.0, False, explore.Machine("follower", "its weight", 0.375, False)),
        ("law", 0.0, True, explore.Machine("follower", "its weight", 0.375, False, "cam", 2.0)),
        ("eccentric", 0.0, False, explore.Machine("ball", "its weight", 0.375, False, "table")),
    ],
)
def test_what_a_scene_is_called_on_the_page(kind, stiffness, crank, wanted):
    follower = Made(stiffness=stiffness, preload=250.0, gravity=9.81, restitution=0.375)
    system = Made(cam=Made(stretches=[Made(start_c=0.0), Made(start_c=0.009)]))
    scene = Made(follower=follower, cam=Made(kind=kind), run=Made(crank=crank))
    assert explore.Machine.of(scene, system) == wanted
