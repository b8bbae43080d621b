"""Sentences from values made by hand: each number in them is another, and each branch has a case.

What is compared is the whole text, so a number in a wrong place, a unit, a plural or a left-out
half of a sentence is seen.
"""

from __future__ import annotations

import re
from math import inf, nan, pi, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.border_collision import (
    Collision,
    Cycle,
    Equal,
    Inequality,
    Prediction,
    Rule,
)
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import CriticalQuantity, CriticalSpeed, SpeedStatus
from camcli.analysis.contact_loss.hold import ABSURD, Hold, HoldStatus, Obstacle
from camcli.analysis.explain.changes import BASIN, UNEXPLAINED, CriticalEvent, LabelChange
from camcli.analysis.explain.crisis import Crisis, CrisisKind, MetSaddle
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.orbits.all_orbits import Failure
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.proofs import Proof, Proofs, ProofStep
from camcli.analysis.speeds import Speed
from camcli.analysis.sweep import Sweep
from camcli.api.sweep import ranges
from camcli.errors import Status
from camcli.kernel.certify import Verdict
from camcli.output.digest import Drift
from camcli.system import Follower
from camcli.words.after_rest import decided_notes
from camcli.words.all_orbits import all_notes, all_sentences, cover_heading, longest_flight
from camcli.words.border_collision import EQUALITIES, LEFT
from camcli.words.classify import exponent_text
from camcli.words.classify import remarks as of_motions
from camcli.words.detach import spring
from camcli.words.events import corner_line, event_words
from camcli.words.explanations import change_sentence, crisis_sentences, event_sentence
from camcli.words.figures import drift_line
from camcli.words.orbits import VERDICTS, branch_words, heading, notes, nothing_found
from camcli.words.orbits import remarks as of_orbits
from camcli.words.proofs import FAILED, proof_sentences
from camcli.words.speeds import speed_text
from camcli.words.statuses import CAUSES, CURES, counted, status_notes


@pytest.mark.parametrize(
    ("rpm", "error", "text"),
    [
        (740.106543, 0.004, "740.107"),
        (740.106543, 0.01, "740.11"),
        (740.106543, 0.00999, "740.107"),
        (740.106543, 1.0, "740"),
        (740.106543, 30.0, "740"),
        (740.106543, 2e-12, "740.106543000"),
        (740.106543, 0.0, "740.106543"),
        (740.106543, inf, "740.106543"),
        (740.106543, nan, "740.106543"),
    ],
)
def test_a_speed_has_the_decimals_of_its_error(rpm, error, text):
    assert speed_text(rpm, error) == text


@pytest.mark.parametrize(
    ("words", "values"),
    [
        (CAUSES, set(Status) - {Status.OK}),
        (CURES, set(Status) - {Status.OK}),
        (FAILED, set(ProofStep)),
        (VERDICTS, set(Verdict)),
        (EQUALITIES, set(Equal) - {Equal.TANGENCY}),
        (LEFT, set(Rule)),
    ],
)
def test_every_value_has_its_words(words, values):
    assert set(words) == values
    assert len(set(words.values())) >= len(values) - 3  # a cure or a formula may serve for two


SAYS = {  # what a step of a proof that failed has to do with, and what its sentence must say of it
    "no-orbit": "there is no orbit",
    "singular": "no box .* exactly one",
    "elsewhere": "impact lies outside",
    "passes": "passes an end of its part",
    "strobe": "near to the strobe",
    "pulls": "would have to pull",
    "contact": "is met between",
    "grazes": "too near to grazing",
    "neutral": "multiplier is too near to the unit circle",
    "crossing": "crossing .* could not",
    "number": "value lies outside",
    "boxes": "more boxes",
    "work-budget": "budget .* used up",
    "fault": "failed .* nobody foresaw",
    "model": "is not followed exactly",
    "cam": "cam is not known",
    "no-chain": "no boxes were found",
    "covering": "mapped over another",
}


@pytest.mark.parametrize("step", ProofStep)
def test_a_step_that_failed_is_told_by_what_it_is(step):
    assert re.search(SAYS[step.value], FAILED[step])
    assert [name for name, says in SAYS.items() if re.search(says, FAILED[step])] == [step.value]


def test_what_was_counted():
    assert counted([358.25], "rpm") == "1 speed (358.25 rpm)"
    assert counted([1.0, 2.5], "follower.mass") == "2 values of follower.mass (1, 2.5)"
    five = [1.0, 2.0, 3.0, 4.0, 5.0]
    assert counted(five, "rpm") == "5 speeds (1, 2, 3, 4, 5 rpm)"
    assert counted([*five, 6.0], "rpm") == "6 speeds (1, 2, 3, 4, 5, ... rpm)"


def test_what_was_decided_after_a_rest():
    found = ["last-digit"] * 2 + ["exact-data"] * 3 + ["rounding"] * 4 + [None, ""]
    assert decided_notes(found, "speed") == [
        "ball arithmetic decided what follows a rest, of 5 speeds: 2 for every speed that rounds "
        "to the given one (proved), 3 for the data exactly as they are, not for every speed that "
        "rounds to them",
        "rounding chose what follows a rest, and so the attractor, of 4 speeds: the exact motion "
        "could not be followed so far",
    ]
    assert decided_notes(["rounding"], "point") == [
        "rounding chose what follows a rest, and so the attractor, of 1 point: the exact motion "
        "could not be followed so far"
    ]
    assert decided_notes([None], "point") == []


def test_troubles_are_told_kind_by_kind():
    met = [(3.0, Status.UNRESOLVED), (1.0, Status.IMPACT_BUDGET), (2.0, Status.IMPACT_BUDGET)]
    assert status_notes([*met, (4.0, Status.OK)]) == [
        f"impact-budget at 2 speeds (1, 2 rpm): {CAUSES[Status.IMPACT_BUDGET]}; "
        f"{CURES[Status.IMPACT_BUDGET]}",
        f"unresolved at 1 speed (3 rpm): {CAUSES[Status.UNRESOLVED]}; {CURES[Status.UNRESOLVED]}",
    ]


def speed(value: float, label: str, status: int = Status.OK) -> Speed:
    return Speed(value, value, label, 0, status, None, None, Cost())


def test_ranges_are_of_neighbours_alike_in_label_status_and_way():
    rows = [
        speed(1.0, "a"), speed(2.0, "a"), speed(3.0, "b"), speed(4.0, "b", Status.UNRESOLVED),
        speed(5.0, "a"), speed(6.0, "a"),
    ]  # fmt: skip
    ways = [("up",)] * 5 + [("down",)]
    found = Sweep(rows, "both", Cost(), bare=rows, ways=ways)
    told = [tuple(one)[:6] for one in ranges(found)]
    assert told == [
        ("a", "ok", ("up",), 1.0, 2.0, 2), ("b", "ok", ("up",), 3.0, 3.0, 1),
        ("b", "unresolved", ("up",), 4.0, 4.0, 1), ("a", "ok", ("up",), 5.0, 5.0, 1),
        ("a", "ok", ("down",), 6.0, 6.0, 1),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("measured", "text"),
    [
        ([], ""),
        ([(-0.223143551314, 0.0)], "-0.223144"),
        ([(0.5547356818, 0.0277)], "0.55 +- 0.03"),
        ([(0.5547356818, 0.00277)], "0.555 +- 0.003"),
        ([(12.25, 30.0)], "12 +- 30"),
        ([(-inf, 0.0)], "-inf"),
        ([(-inf, 0.0), (-0.25, 0.0)], "-inf to -0.25"),
        ([(0.25, 0.01), (0.2394, 0.01)], "0.2394 to 0.25"),
        ([(0.25, 0.01), (0.25, 0.02)], "0.25"),
    ],
)
def test_exponents_have_the_digits_that_their_errors_leave(measured, text):
    assert exponent_text(measured) == text


def motion(value, label="P(1;1)", **more):
    own = {
        "value": value, "label": label, "exponents": None, "holds_for": None, "orbit": object(),
        "status": Status.OK, "watched": None, "chatters": 0, "fault": None,
        "record": Made(periods=0),
    }  # fmt: skip
    return Made(**{**own, **more})


def test_remarks_on_motions():
    def grown(largest, second, defect):
        return Made(largest=largest, second=second, defect=defect)

    motions = [
        motion(1.0, exponents=grown(-0.5, -0.75, -3e-7)),
        motion(2.0, exponents=grown(0.25, -0.5, 2e-8)),
        motion(3.0, exponents=grown(-inf, -inf, nan), holds_for="last-digit"),
        motion(4.0, "aperiodic", orbit=None, watched=9000),
        motion(5.0, "aperiodic", orbit=None, watched=6001),
        motion(6.0, "undecided", orbit=None, watched=700, chatters=1),
        motion(7.5, "undecided", orbit=None, chatters=4, record=Made(periods=90)),
        motion(8.0, "undecided", orbit=None, fault=object(), status=Status.FAULT),
    ]
    assert of_motions(motions, "rpm") == [
        "both exponents of a motion add up to 2 ln r times its impacts per turn, less b T/m: "
        "within 3e-07 in 2 motions",
        "where the follower rests, both exponents are -inf: a rest wipes out every "
        "difference between two motions",
        "ball arithmetic decided what follows a rest, of 1 motion for every speed that rounds to "
        "the given one (proved)",
        "a motion called aperiodic was followed for 6001 turns or more, and neither settled nor "
        "rested: what would end it is rarer than once in 2000 turns (95 %)",
        "rpm = 6: the first complete chatter comes after 700 turns; after a rest the motion is "
        "always the same, and it could not be followed to the next rest",
        "rpm = 7.5: complete chatter in 4 of 90 turns, one in some 22.5; after a rest the motion "
        "is always the same, and it could not be followed to the next rest",
        "the motion at 2 speeds (6, 7.5 rpm) is undecided: no orbit up to 64 turns could be solved "
        "and no positive exponent be shown, or doubles lose the motion between one rest and the "
        "next",
    ]
    assert of_motions([motion(1.0)]) == []
    assert of_motions([motion(5.0, "aperiodic", orbit=None, watched=2)])[0].endswith(
        "once in 1 turn (95 %)"
    )


def orbits(kind="", **more):
    own = {
        "question": Made(label="P(2;1:1)", rpm=701.25, parameter="rpm", plane=None), "absent": None,
        "orbits": [], "continua": [], "virtual": [], "bifurcations": [], "branches": [],
        "curves": [], "proofs": None, "limits": [], "codim2": [], "every": None, "chaos": None,
    }  # fmt: skip
    return of_orbits(Made(**{**own, **more}), kind=kind)


def test_below_the_title_of_the_covers_stands_which_flights_and_orbits_are_drawn():
    """A follower of k/m = 10, b/2m = 1 swings by half in pi/3 s; the cam turns 60 deg a second."""
    orbits = [Made(label="P(1;1)", turns=1, symbols=(1.0,)),
              Made(label="P(2;2:1)", turns=2, symbols=(2.0, 1.0))]  # fmt: skip
    covers = [Made(impacts=2, turns=2, boxes=7, drawn=(1,)), Made(impacts=3, turns=2, boxes=5,
                                                                  drawn=())]  # fmt: skip
    follower = Follower(mass=2.0, stiffness=20.0, damping=4.0, gravity=0.0, preload=0.0)
    found = Made(impacts=3, turns=2, orbits=orbits, covers=covers, follower=follower)
    title, caption, words = cover_heading(Made(question=Made(rpm=10.0)), found)
    assert title == "All orbits with 1 to 3 impacts in 1 to 2 turns at 10 rpm"
    assert caption == (
        "boxes of the phases of two impacts; 5 boxes of other covers not drawn. The first flight "
        "is the longer one: it takes half of the turns or more. No flight is longer than π/f = "
        "62.8 deg"
    )
    assert words == "P(2;2:1) has 3 impacts and is not drawn."
    loose = Follower(mass=1.0, stiffness=0.0, damping=0.0, gravity=9.81, preload=0.0)
    words = cover_heading(Made(question=Made(rpm=10.0)), Made(**{**vars(found), "follower": loose}))
    assert "π/f" not in words[1]


def test_whether_the_orbits_are_all():
    solved = [Made(label="P(1;1)", rpm=701.25, stable=True), Made(label="P(1;2)", stable=False)]
    every = Made(impacts=3, turns=1, failure=None, covers=[Made(boxes=40), Made(boxes=2)])
    found = Made(question=Made(rpm=701.25), orbits=solved,
                 proofs=Made(orbits=[Made(proved=True), Made(proved=True)]))  # fmt: skip
    assert list(all_sentences(found, every)) == [
        "proved: the orbits without rest that have 1 to 3 impacts in 1 turn at 701.25 rpm are "
        "these 2: P(1;1) stable, P(1;2) unstable (42 boxes hold no other)"
    ]
    assert all_notes(found, every) == []
    found.proofs.orbits[1].proved = False
    why = "one of those found is not proved itself"
    assert list(all_sentences(found, every)) == [
        "not proved: the orbits with 1 to 3 impacts in 1 turn at 701.25 rpm are all found: " + why
    ]
    assert all_notes(found, every) == [f"it is not proved that the orbits are all: {why}"]
    every.failure = Failure.BOXES
    every.impacts, every.turns = 1, 2
    assert list(all_sentences(found, every)) == [
        "not proved: the orbits with 1 impact in 1 to 2 turns at 701.25 rpm are all found: more or "
        "smaller boxes would be needed, or orbits are born or not isolated here"
    ]


def test_remarks_on_orbits_of_an_oscillator_name_the_frequency_of_its_force():
    minute = 30.0 / pi  # rpm at 1 rad/s
    question = Made(label="P(2;1:1)", rpm=0.8 * minute, parameter="cam.amplitude", plane=None)
    own = {"kind": "oscillator", "question": question}
    assert orbits(**own) == ["no periodic orbit was found at frequency 0.8 rad/s"]
    absent = Made(rpm=0.8 * minute, low=0.64 * minute, high=0.96 * minute, nearest=None)
    assert orbits(absent=absent, **own) == [
        "P(2;1:1) was not found at frequency 0.8 rad/s, nor at 24 frequencies from 0.64 to 0.96 "
        "rad/s"
    ]
    absent.nearest = (0.75 * minute, "period-doubling")
    assert orbits(absent=absent, **own) == [
        "P(2;1:1) was not found at frequency 0.8 rad/s; the nearest place at which it was found is "
        "frequency 0.75 rad/s, where it ends: period doubling"
    ]
    found = Made(label="P(1;1)", rpm=0.8 * minute)
    assert orbits(orbits=[found], virtual=[1, 2], **own) == [
        "2 further roots at frequency 0.8 rad/s are virtual: another contact lies on their way, or "
        "an impact would have to pull (run.json)"
    ]


@pytest.mark.parametrize(
    ("parameter", "title"),
    [
        ("cam.amplitude", "Periodic orbits, amplitude of the force 0.4 to 0.6 N at "
                          "frequency 0.8 rad/s"),
        ("cam.frequency", "Periodic orbits, circular frequency of the force 0.4 to 0.6 rad/s"),
    ],
)  # fmt: skip
def test_the_title_of_a_picture_of_an_oscillator_names_its_frequency_once(parameter, title):
    span = Made(low=0.4, high=0.6)
    asked = {"rpm": 0.8 * 30.0 / pi, "parameter": parameter, "span": span, "label": None}
    study = Made(question=Made(**asked, stable=None), orbits=[], value=0.5, absent=None)
    assert heading(study, "oscillator")[0] == title
    assert " rpm" not in heading(study, "oscillator")[1]


def test_a_label_that_an_oscillator_does_not_have_is_named_with_its_frequencies():
    minute = 30.0 / pi  # rpm at 1 rad/s
    absent = Made(low=0.64 * minute, high=0.96 * minute, nearest=None)
    study = Made(absent=absent, question=Made(label="P(2;1:1)"))
    assert nothing_found(study, "oscillator") == "no P(2;1:1) was found from 0.64 to 0.96 rad/s"
    absent.nearest = (0.75 * minute, "period-doubling")
    assert nothing_found(study, "oscillator") == (
        "no P(2;1:1) here; the nearest is at frequency 0.75 rad/s: period doubling"
    )
    study.question.label = absent.nearest = None
    assert nothing_found(study, "oscillator") == "no orbit was found from 0.64 to 0.96 rad/s"


def test_a_flight_is_at_most_half_a_swing_of_the_damped_spring():
    """At 1 rad/s, by hand: stiffness 25 and damping 6 of 1 kg swing at 4 rad/s; 10 is critical."""
    rpm = 30.0 / pi
    for stiffness, damping, mass, most in ((25.0, 6.0, 1.0, 45.0), (50.0, 12.0, 2.0, 45.0),
                                           (25.0, 12.0, 1.0, None), (0.0, 1.0, 1.0, None),
                                           (0.0, 0.0, 1.0, None)):  # fmt: skip
        follower = Made(stiffness=stiffness, damping=damping, mass=mass)
        for times in (1.0, 2.0):  # at twice the speed it lasts twice as many degrees
            longest = longest_flight(follower, times * rpm)
            assert longest == (most if most is None else pytest.approx(times * most))


def test_remarks_on_orbits():
    dwell = Made(label="P(1;1)", start=0.5, end=0.75)
    absent = Made(rpm=702.5, low=640.0, high=760.0, nearest=None)
    assert orbits() == ["no periodic orbit was found at 701.25 rpm"]
    assert orbits(absent=absent) == [
        "P(2;1:1) was not found at 702.5 rpm, nor at 24 speeds from 640 to 760 rpm"
    ]
    absent.nearest = (739.125, "period-doubling")
    assert orbits(absent=absent) == [
        "P(2;1:1) was not found at 702.5 rpm; the nearest speed at which it was found is 739.125 "
        "rpm, where it ends: period doubling"
    ]
    assert orbits(continua=[dwell]) == [  # orbits there are, though none by itself
        "P(1;1) exists with its impact anywhere from 28.64789 to 42.971835 deg, a dwell: a "
        "continuum of orbits, of which none is isolated and none attracts (both multipliers are 1)"
    ]
    solved = Made(label="P(1;1)", rpm=701.25)
    assert orbits(orbits=[solved], virtual=[1, 2, 3]) == [
        "3 further roots at 701.25 rpm are virtual: another contact lies on their way, or an "
        "impact would have to pull (run.json)"
    ]
    branches = [Made(number=n, points=[Made(det=0.25 * n), Made(det=0.125)]) for n in (1, 2, 3)]
    for branch in branches:
        branch.stable_ranges = lambda events: []
        branch.turning_points = []
    branches[0].stable_ranges = lambda events: [(640.5, 700.0), (710.0, 720.25)]
    branches[1].turning_points = [640.5, 720.25]
    where = [
        "branch 1 is stable from 640.5 to 700, 710 to 720.25",
        "branch 2 is nowhere stable; it turns round at 640.5, 720.25",
        "branch 3 is nowhere stable",
    ]
    assert orbits(orbits=[solved], branches=branches) == [
        *where,
        "Neimark-Sacker bifurcations are impossible: det = r^(2 impacts) exp(-b T/m) is at most "
        "0.75 on these branches, below 1",
    ]
    branches[1].points[1].det = 1.0
    assert orbits(orbits=[solved], branches=branches) == [
        *where,
        "det reaches 1 where nothing dissipates: orbits are centres or saddles, none attracts",
    ]
    curves = [
        Made(ends=("end-of-range", "corner"), limits=("", "b")),
        Made(ends=("lost", "end-of-range"), limits=("", "")),
    ]
    assert orbits(orbits=[solved], curves=curves) == [
        "curve 1 ends: end-of-range; corner of b",
        "curve 2 ends: it could not be followed further; end-of-range",
    ]
    points = [Made(kind="cusp", ends=((2, 0), (1, 1)), place=None)]
    met = [
        "curve 1 ends: end-of-range; corner of b (cusp)", "curve 2 ends: cusp; end-of-range",
    ]  # fmt: skip
    assert orbits(orbits=[solved], curves=curves, codim2=points) == met


def test_remarks_on_proofs():
    step, text = ProofStep.NUMBER, "the value lies outside the error that is claimed for it"
    solved = [
        Made(label="P(1;1)", rpm=701.25, stable=False, resting=False),
        Made(label="P(1;2)", rpm=701.25),
    ]
    range_ = Made(branch=4, label="P(1;1)", stable=True, low="[1]", high="[2]", boxes=7,
                  failed_step=None)  # fmt: skip
    lost = Made(**{**vars(range_), "failed_step": step, "branch": 5})
    signs = (Rule.PRODUCT_AT_ONE, 1), (Rule.PRODUCT_AT_MINUS_ONE, -1)
    proofs = Proofs(
        orbits=[Proof(), Proof(step, refuted=True)],
        points=[[Proof(), Proof(step), Proof(), *[Proof(ProofStep.NEUTRAL)] * 4]],
        events=[
            Proof(value="[700 +/- 1]", signs=signs), Proof(step)
        ],
        ranges=[range_, lost],
        flank_excess=-2.5e-16,
    )  # fmt: skip
    events = [
        Made(kind=kind, label="P(1;1)", value=3.0, corner_impact=None, located=None)
        for kind in ("one", "two")
    ]
    branch = Made(number=9, points=[Made(value=0.5 * n) for n in range(7)])
    found = Made(question=Made(parameter="rpm", plane=None), orbits=solved, proofs=proofs,
                 bifurcations=events, branches=[branch])  # fmt: skip
    said = list(proof_sentences(found))
    assert said == [
        "all proofs are about the cam whose circles close: its flank circle has the radius "
        "base_radius + flank_center, 2.5e-16 m less than the flank_radius of the scene",
        "proved: P(1;1), unstable, rpm = 701.25, exactly these data",
        f"refuted: P(1;2): {text}",
        "proved: one of P(1;1), rpm = [700 +/- 1], (1 - tau_L + delta_L)(1 - tau_R + delta_R) > 0, "
        "(1 + tau_L + delta_L)(1 + tau_R + delta_R) < 0",
        f"not proved: two of P(1;1): {text}",
        "proved: 2 of the 7 points of branch 9",
        f"not proved: 1 point of branch 9, rpm = 0.5: {text}",
        "not proved: 4 points of branch 9, rpm = 1.5, 2, 2.5, ...: a multiplier is too near to the "
        "unit circle",
        "proved: P(1;1) exists and is stable for all rpm from [1] to [2] (branch 4, 7 boxes)",
        f"not proved: P(1;1) for all rpm from [1] to [2] (branch 5): {text}",
    ]


def crisis(kind, **more):
    own = {
        "rpm": 740.25, "error": 0.004, "bracket": (740.125, 740.375), "near": 730.5,
        "turns": 4000, "cost": Cost(), "inside": 3, "beyond": 2,
    }  # fmt: skip
    return Crisis(kind, **{**own, **more})


def test_crises():
    said = crisis_sentences
    assert said(crisis(CrisisKind.NOT_CHAOTIC)) == [
        "The motion carried from 730.5 rpm is not chaotic."
    ]
    assert said(crisis(CrisisKind.STAYS)) == [
        "Nothing leaves the attractor carried from 730.5 rpm: a run of 4000 turns stays in its "
        "range at 740.25 rpm."
    ]
    runs = [
        "Runs of 4000 turns carried from 730.5 rpm first leave the attractor's range at 740.4 rpm.",
        "Saddles seen: 3 in the attractor, 2 beyond it.",
    ]
    assert said(crisis(CrisisKind.UNEXPLAINED)) == runs
    first, later, never = (
        Made(label=f"P({n};1)", multipliers=(complex(n + 0.5), 0j)) for n in (1, 2, 3)
    )
    meetings = MetSaddle(first, 740.25, 0.004), MetSaddle(later, 740.3125, 0.02)
    met = crisis(CrisisKind.INTERIOR, met=meetings, unmet=(never,), lost=1)
    tail = [
        "1 of them could not be followed and is left out.",
        "The attractor meets the stable manifold of P(1;1) (larger multiplier 1.5) at 740.250 rpm.",
        "P(2;1) would be met later, at 740.31 rpm.",
        "P(3;1) leads out, but no fold was seen to touch its stable manifold.",
    ]
    assert said(met) == [*runs, *tail, "What touches the manifold is a smooth fold."]
    corner = crisis(CrisisKind.INTERIOR, met=meetings[:1], corner=Made(name="c"))
    assert said(corner)[-1] == "What touches the manifold is the image of an impact at corner c."
    assert event_sentence(CriticalEvent(1.0, 0.1, "interior-crisis", "x", source=met)) == " ".join(
        said(met)
    )


def test_changes():
    ends = (700.0, 702.0, "P(1;1)", "aperiodic")
    events = [
        CriticalEvent(700.5, 0.1, "fold", "P(1;1)"),
        CriticalEvent(701.5, 0.1, "grazing", "P(2;2)"),
    ]
    stays = crisis(CrisisKind.STAYS)
    stayed = crisis_sentences(stays)[0]

    def told(cause, **more):
        return change_sentence(LabelChange(*ends, cause, **more), events)

    assert told(BASIN, persists=("P(1;1)", "P(3;1)")) == (
        "P(1;1) exists and attracts at both speeds: the start changes basins; P(1;1) changes at: "
        "fold at 700.5 rpm; P(3;1) exists and attracts at both speeds: the start changes basins; "
        "P(3;1) does not change in the range"
    )
    lives = "the chaotic attractor lives on at both speeds: the start changes basins."
    assert told(BASIN) == lives
    assert told(BASIN, crisis=stays) == f"{lives} {stayed}"
    assert told(UNEXPLAINED, status=Status.WORK_BUDGET) == (
        f"work-budget: {CAUSES[Status.WORK_BUDGET]}"
    )
    tried = (
        "no bifurcation of a solved branch lies between them, and no branch through both is stable"
    )
    first = "; crises are looked for in the first 3 changes only"
    assert told(UNEXPLAINED) == tried
    assert told(UNEXPLAINED, may_search=False) == tried + first
    assert told(UNEXPLAINED, crisis=stays) == f"{tried}. {stayed}"
    assert told(UNEXPLAINED, persists=("P(1;1)", "P(3;1)")) == (
        "P(1;1) and P(3;1) attract at both speeds; whether the chaos beside lives on at both is "
        "not known"
    )
    assert told("fold+grazing", events=tuple(events)) == "fold; grazing"


def event(kind, located=None, **more):
    return Made(**{"kind": kind, "located": located, "beyond": "", "corner_impact": None, **more})


def side(kind, **more):
    """Of a corner impact: what is predicted, and what a simulation shows."""
    first = {"period": 3, "word": "LLR", "label": "P(7;1)", "stays": True, "agrees": True, **more}
    period, word = first.pop("period"), first.pop("word")
    return Made(predicted=Prediction(kind, period, None, word), **first)


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (
            event(Kind.DETACHMENT, beyond="P(2;1:1)"),
            ["a simulation just beyond it settles on P(2;1:1)."],
        ),
        (
            event(Kind.ITINERARY),
            ["no periodic orbit was found in a simulation just beyond it."],
        ),
        (
            event(Kind.GRAZING, Made(fading=None, impact=2, phase=radians(360.0 + 123.456789))),
            ["beyond it the flight after impact 3 has a further impact, at 123.45679 deg."],
        ),
        (
            event(
                Kind.GRAZING,
                Made(fading=1, root=Made(theta=[1.0, radians(234.5678912), 2.0]), impact=7),
            ),
            ["the impact at 234.56789 deg fades to zero velocity."],
        ),
        (
            event(Kind.GRAZING, Made(fading=0, root=Made(theta=[radians(12.5), 2.0]), impact=7)),
            ["the impact at 12.5 deg fades to zero velocity."],
        ),
        (event(Kind.FOLD, Made()), []),
        (event(Kind.CORNER_IMPACT, Made()), []),
    ],
)
def test_an_event_is_told_with_what_lies_beyond_it(one, said):
    assert event_words(one) == said


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (side("none"), "stays near it on P(7;1), as predicted (nothing attracts nearby)"),
        (
            side("fixed-point", stays=False),
            "leaves for P(7;1), as predicted (an orbit of the same period)",
        ),
        (
            side("cycle", agrees=False),
            "stays near it on P(7;1), NOT as predicted (an orbit of 3 times the period)",
        ),
        (side("chaos", label="aperiodic"), "stays near it on aperiodic, as predicted (chaos)"),
        (
            side("several", agrees=None),
            "stays near it on P(7;1), which the prediction (several: LLR) does not decide",
        ),
        (
            side("undecided", agrees=None, stays=False),
            "leaves for P(7;1), which the prediction (not decided) does not decide",
        ),
    ],
)
def test_a_corner_impact_is_told_with_its_class_and_both_sides(one, said):
    other = side("none", label="contact", stays=False)
    gone = "leaves for contact, as predicted (nothing attracts nearby)"
    fixed, chaos = Prediction("fixed-point", word="L"), Prediction("chaos", 0, 0.1234567, "", 0.002)
    pair = complex(-0.25, 0.75), complex(-0.25, -0.75)
    cycles = Cycle("L", (), True), Cycle("R", (), True), Cycle("LR", pair, True, (), -1)
    first = (Inequality(Rule.BEYOND_ONE, "L", 0.5, 1.5),)
    small = Inequality(Rule.GROWTH, "", 0.00123)
    collision = Collision("persistence", (), small, first, (), cycles, fixed, chaos)
    for below, above in ((one, other), (other, one)):
        impact = Made(collision=collision, below=below, above=above)
        words = event_words(event(Kind.CORNER_IMPACT, Made(), corner_impact=impact))
        texts = {id(one): said, id(other): gone}
        assert words == [
            "persistence: a fixed point on each side, and no cycle LR is born.",
            "The growth at the event, 0.0012 per step, is too small to exclude that the event is "
            "dangerous.",
            "Where the normal form's parameter is below 0, the fixed point L attracts.",
            "Where it is above 0, there is a chaotic attractor, largest exponent 0.1235 +- 0.002 "
            "per step.",
            "Where the normal form's parameter is below 0, the cycle LR exists and is stable: "
            "multipliers -0.25 +- 0.75 i.",
            f"Just below it a simulation {texts[id(below)]}.",
            f"Just above it a simulation {texts[id(above)]}.",
        ]
    for agrees, seen in (
        (True, "; simulations on both sides agree"),
        (False, "; a simulation does NOT agree"),
        (None, ""),
    ):
        line = corner_line(Made(collision=collision, agrees=agrees))
        assert line == f"persistence, a fixed point on each side, and no cycle LR is born{seen}"


def numbers(text: str) -> list[float]:
    """Of a sentence, in its order."""
    return [float(x) for x in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]\d+)?", text)]


def critical(quantity: CriticalQuantity) -> CriticalSpeed:
    return CriticalSpeed(quantity, "B7", radians(123.5), 711.0, 710.0, 712.0, SpeedStatus.OK)


@pytest.mark.parametrize(
    ("source", "said", "told"),
    [
        (CornerHit(3, "d", 711.0, 710.0, 712.0, SpeedStatus.OK, "A2"), [3.0], "corner d"),
        (critical(CriticalQuantity.FIRST_DETACHMENT), [123.5], "zero"),
        (critical(CriticalQuantity.ACCUMULATION), [], "corner B7"),
        (critical(CriticalQuantity.COMPLETION_LOSS), [], "complete"),
        (Made(beyond=None), [], "P(2;inf:3) ends (grazing)"),
        (Made(beyond=Made(label="P(5;4)")), [], "settles on P(5;4)"),
        (None, [], "grazing"),
    ],
)
def test_what_happens_at_a_critical_speed(source, said, told):
    text = event_sentence(CriticalEvent(711.0, 0.5, Kind.GRAZING, "P(2;inf:3)", source=source))
    assert told in text
    if said:
        assert numbers(text) == said


def test_notes_on_orbits_name_the_end_that_was_lost():
    """The first point where the beginning was lost, the last where the end was."""
    points = (Made(value=701.25), Made(value=702.5), Made(value=703.75))
    events = [
        Made(status=status, kind="fold", label="P(1;2)", value=700.125 + k)
        for k, status in enumerate((Bracket.OK, Bracket.UNRESOLVED))
    ]
    branches = [
        Made(number=4, ends=(Kind.LOST, Kind.FOLD), points=points),
        Made(number=5, ends=(Kind.FOLD, Kind.LOST), points=points),
        Made(number=6, ends=(Kind.FAULT, Kind.FOLD), points=points),
        Made(number=7, ends=(Kind.FOLD, Kind.FAULT), points=points),
        Made(number=8, ends=(Kind.FOLD, Kind.FOLD), points=points),
    ]
    for curves, more in (([], 1), ([Made(points=())], 1), ([Made(points=points)], 0)):
        found = Made(bifurcations=events, branches=branches, curves=curves, every=None, chaos=None,
                     question=Made(curve="fold"))  # fmt: skip
        said = notes(found)
        assert "701.125" in said[0]
        assert "P(1;2)" in said[0]
        seen = [set(numbers(text)) for text in said[1:]]
        ends = [{4.0, 701.25}, {5.0, 703.75}, {6.0, 701.25}, {7.0, 703.75}]
        assert all(any(end <= some for some in seen) for end in ends)
        assert not any(8.0 in some for some in seen)
        assert sum("curve to continue" in text for text in said) == more


@pytest.mark.parametrize(
    ("hold", "said", "told"),
    [
        ({"obstacle": Obstacle.SOLID, "missing_n": 0.00125}, [1.25], "mm before"),
        ({"obstacle": Obstacle.LIFT, "missing_n": 321.5}, [321.5, 123.5, 0.0], "N are missing"),
        ({"obstacle": Obstacle.PULL, "missing_n": 321.5}, [123.5, 0.0], "would pull"),
        ({"status": HoldStatus.ABSURD, "nose_n": 54321.0}, [54320.0, ABSURD], "highest lift"),
        ({"status": HoldStatus.NOT_NEEDED}, [], "no preload is needed"),
    ],
)
def test_why_no_spring_is_named(hold, said, told):
    """Of more preload; of stiffness alone it says that no preload helps."""
    of = {"status": HoldStatus.IMPOSSIBLE, "theta": radians(123.5), **hold}
    text = spring(Hold(CriticalQuantity.HOLD_PRELOAD, **of))
    assert told in text
    assert numbers(text)[: len(said)] == said
    alone = spring(Hold(CriticalQuantity.HOLD_STIFFNESS, **of))
    assert ("stiffness alone" in alone) == ("N are" in told or "pull" in told)


def test_a_drift_is_told_with_its_share_of_the_reference():
    drift = Drift("3.1", "solved", "rpm", 200.0, 201.0, by=1.0)
    assert drift_line(drift, False) == (
        "3.1: rpm: reference 200.0, found 201.0, off by 1 (0.005 of it)"
    )


def test_a_branch_lost_at_both_ends_is_told_with_the_speed_of_its_first():
    points = [Made(value=value, regions=("A2",)) for value in (700.0, 705.0, 710.0)]
    label = Label((1.0,))
    for ends, at in (((Kind.LOST, Kind.LOST), "700"), ((Kind.FOLD, Kind.LOST), "710")):
        branch = Made(number=2, labels=[label], points=points, ends=ends)
        said = branch_words(branch, "rpm", 3, 200)
        assert f"lost at {at}" in said
        assert said.startswith("2   P(1;1), from event 3")
