"""Fixed phrases of `camcli.words`, whole, and the sentences around them, a case for each branch.

A phrase of a table belongs to one kind of thing. Here it is written once more, word for word: a
"not" that goes, or two phrases that change places, are seen.
"""

from __future__ import annotations

from math import acos, degrees, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.analysis.border_collision import Equal
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import (
    CriticalQuantity,
    CriticalSpeed,
    NoStatement,
    Reason,
    SpeedStatus,
)
from camcli.analysis.contact_loss.hold import Hold, HoldStatus, Obstacle
from camcli.analysis.explain.changes import CriticalEvent
from camcli.analysis.lobe import Face
from camcli.analysis.natural_speed import Basis
from camcli.analysis.orbits.all_orbits import Failure
from camcli.analysis.orbits.codim2 import PointKind
from camcli.analysis.orbits.codim2 import Test as Condition
from camcli.analysis.orbits.kinds import Kind
from camcli.errors import Status
from camcli.exact.shooting import ProofStep
from camcli.kernel.certify import Verdict
from camcli.quantities import MILLIMETRES
from camcli.scene import load_scene
from camcli.system import Follower, System
from camcli.words import (
    all_orbits,
    basins,
    bench,
    border_collision,
    codim2,
    cost,
    detach,
    explanations,
    explore,
    figures,
    lift_table,
    orbits,
    plan,
    proofs,
    rerun,
    simulate,
    speeds,
    statuses,
    sweep,
    verdict,
)

TABLES = [
    (statuses.CAUSES, {
        Status.LOG_FULL: "the event log was too small",
        Status.IMPACT_BUDGET: "one turn had as many impacts as run.impact_budget allows",
        Status.NO_RETURN: "the follower left the cam and nothing brings it back",
        Status.UNRESOLVED: "a contact is closer to grazing than double precision can tell",
        Status.PAUSED: "the work was interrupted",
        Status.WORK_BUDGET: "the budget of work was used up, and the rest is left out",
        Status.FAULT: "an exception that nobody foresaw cost this piece alone",
    }),
    (statuses.CURES, {
        Status.LOG_FULL: "this is a fault of the program",
        Status.IMPACT_BUDGET:
            "raise run.impact_budget, raise run.chatter_tolerance, or lower restitution",
        Status.NO_RETURN: "give the follower a spring, gravity or a preload",
        Status.UNRESOLVED:
            "move the speed by a relative 1e-12, or treat both outcomes as possible",
        Status.PAUSED: "run the same command again",
        Status.WORK_BUDGET: "raise run.work_budget",
        Status.FAULT: "this is a fault of camcli, please report it with run.json",
    }),
    (border_collision.KINDS, {
        "degenerate": "an equality holds within rounding: the linear parts do not decide",
        "dangerous": "a stable fixed point on both sides, yet its basin shrinks to nothing between",
        "robust-chaos":
            "a chaotic attractor on one side, and for all linear parts close to these",
        "no-attractor": "something attracts on one side, nothing bounded on the other",
        "nonsmooth-fold": "two fixed points are born on one side, there is none on the other",
        "border-period-doubling":
            "a fixed point on each side, and a cycle LR is born on one of them",
        "persistence": "a fixed point on each side, and no cycle LR is born",
    }),
    (border_collision.EQUALITIES, {
        Equal.PLUS_ONE: "a multiplier is +1",
        Equal.MINUS_ONE: "a multiplier is -1",
        Equal.UNIT_PAIR: "two multipliers on the unit circle",
    }),
    (border_collision.SIDES, {
        -1: "Where the normal form's parameter is below 0", 1: "Where it is above 0",
    }),
    (codim2.UNFOLDS, {
        PointKind.FOLD_GRAZING: "the curve of folds ends on the curve of grazing, tangent to it",
        PointKind.PERIOD_DOUBLING_GRAZING: "the curve of doublings ends on the curve of grazing",
        PointKind.CUSP: "two folds meet here and vanish",
        PointKind.CORNER_IMPACT_FOLD: "the curve of folds ends on the curve of corner impacts, "
            "tangent to it; its orbit is no motion beyond",
        PointKind.CORNER_IMPACT_PERIOD_DOUBLING: "the curve of doublings ends on the curve of "
            "corner impacts, and corner impacts of the doubled orbit begin here",
        PointKind.DOUBLE_CORNER_IMPACT: "two curves of corner impacts cross, each with a kink",
        PointKind.CORNER_IMPACT_GRAZING: "a curve of corner impacts meets one of grazing",
        PointKind.DOUBLE_GRAZING: "two curves of grazing cross",
        PointKind.CORNER_GRAZING: "the flight touches the cam at a corner: the curve of grazing "
            "has another square root on either side, and corner impacts of the grazing impact "
            "begin here",
        PointKind.CONSERVATIVE: "the curve ends where nothing is lost in an impact or in flight: "
            "there every orbit has the determinant 1",
    }),
    (all_orbits.FAILED, {
        Failure.FLIGHTS:
            "the spring rests above a part of the cam, so that flights may be long",
        Failure.STOP: "the stop presses too little, so that flights may be long: the clearance "
            "would have to lie below minus the amplitude of the motion without the stop",
        Failure.CAM: "the slope of the cam jumps, or the cam has no closed formula",
        Failure.BOXES:
            "more or smaller boxes would be needed, or orbits are born or not isolated here",
        Failure.WORK_BUDGET: "the work budget is spent",
        Failure.LOSSLESS: "with restitution 1 nothing bounds the rates of the impacts",
        Failure.PLASTIC: "with restitution 0 no impact leaves the cam at a rate above zero",
    }),
    (all_orbits.REASONS, {
        "order": "the other flight is longer",
        "flight": "no orbit has such a flight",
        "impact": "the rates of an impact do not agree",
        "newton": "a Newton step leads out of the box",
    }),
    (proofs.FAILED, {
        ProofStep.NO_ORBIT: "there is no orbit of these impacts where the numbers say",
        ProofStep.SINGULAR: "no box could be shown to hold exactly one orbit",
        ProofStep.ELSEWHERE: "an impact lies outside the smooth region it is said to be in",
        ProofStep.PASSES: "an impact passes an end of its part of the cam, the strobe or the angle "
            "zero there",
        ProofStep.STROBE: "an impact is so near to the strobe that the orbit, which exists, may "
            "have another label",
        ProofStep.PULLS: "an impact would have to pull",
        ProofStep.CONTACT: "the cam is met between two impacts",
        ProofStep.GRAZES: "a flight is too near to grazing to exclude a contact",
        ProofStep.NEUTRAL: "a multiplier is too near to the unit circle",
        ProofStep.CROSSING: "the crossing condition could not be shown",
        ProofStep.NUMBER: "the value lies outside the error that is claimed for it",
        ProofStep.BOXES: "more boxes would be needed than are tried",
        ProofStep.WORK_BUDGET: "the budget of work was used up",
        ProofStep.FAULT: "it failed in a way that nobody foresaw",
        ProofStep.NO_CHAIN: "no boxes were found about an unstable orbit with one impact and a "
            "chain of impacts that leaves it and comes back to it",
        ProofStep.COVERING: "a box was not shown to be mapped over another one",
        ProofStep.MODEL:
            "its contact, a rest or a graze, is of a kind that is not followed exactly",
        ProofStep.CAM: "the cam is not known in ball arithmetic over this number",
    }),
    (orbits.VERDICTS, {
        Verdict.ADMISSIBLE: "admissible",
        Verdict.EARLY: "virtual: penetrates the cam",
        Verdict.LATE: "virtual: an impact is missing",
        Verdict.PULLS: "virtual: an impact would have to pull",
        Verdict.DOUBTFUL: "nearer to grazing than double precision can tell",
    }),
    (orbits.CURVE_ENDS, {
        Kind.ANOTHER_CORNER: "an impact reaches a corner",
        Kind.NO_MOTION: "the orbit is no motion any more",
        Kind.SHORTER_ORBIT: "the orbit becomes one of fewer turns",
    }),
    (detach.PANELS, {
        "max_gap_m": "largest gap",
        "max_impact_m_per_s": "hardest impact",
        "springs": "force with other springs",
        "surge": "surge",
        "machines": "machines within their tolerances",
        "shares": "which tolerance matters",
    }),
    (detach.NO_STATEMENT, {
        NoStatement.LASH: "a certificate has no words for the seat of a cam with lash",
        NoStatement.FITTED: "the pieces fitted to a table meet only but for roundings, and where "
            "they do not the contact force of a follower at rest is not defined",
        NoStatement.KINKED: "the slope of this cam jumps, and there the contact force of a "
            "follower at rest is not defined",
        NoStatement.NO_SPEED: "there is no speed up to which contact holds and beyond which it is "
            "lost",
        NoStatement.INSIDE: "contact is first lost within a smooth part of this cam, and the "
            "statement of a certificate names an end of one as the place",
    }),
]  # fmt: skip


@pytest.mark.parametrize(("table", "said"), TABLES)
def test_a_table_of_phrases_says_of_each_thing_its_own(table, said):
    assert table == said


def test_phrases_that_stand_alone():
    assert orbits.SIDES == (
        "L, the left side of a corner impact, is the orbit whose impact lies before the corner; "
        "R, the right side, is the one behind it"
    )
    assert codim2.NO_PROOF == "there is no proof yet for points of this kind"
    assert proofs.NO_CERTIFICATE_OF_A_SEAT == (
        "proof.json has no statement on a lift table with lash, whose polynomials are rounded anew "
        "where they pass the seat: what is proved here was proved by camcli alone"
    )
    assert simulate.JERK_OF_A_FIT == (
        "the jerk is that of the fitted cam: where the jerk of the measured one jumps the fit goes "
        "over gradually, and a table cannot rule out a corner between its rows, where it is "
        "infinite"
    )
    assert simulate.ASSUMED == (
        "what runs on the cam moves along a line through the axis, at base_radius + (c - least "
        "c)/rocker_ratio"
    )
    assert detach.BURSTS_OF_THE_LOBE == (
        "The line follows bounces that begin where the force on the lobe is lost. Crosses are "
        "where those end that the opening blow or the seat begins"
    )
    assert detach.OTHER_ENDS == "end of the bounces of opening blow or seat"
    assert detach.second_page("A report") == "A report (second page)"
    assert rerun.rerun_title("sweep", True) == "cam sweep again: the same bytes"
    assert rerun.rerun_title("sweep", False) == "cam sweep again: bytes differ"
    assert (rerun.SAME, rerun.OTHER, rerun.MISSING) == ("same bytes", "other bytes", "not made")
    assert rerun.CHANGED == "same bytes, but not those of the file beside the record"
    assert rerun.OTHER_PROGRAM == "the record is of another version of this program"
    assert rerun.SAME_TROUBLE == (
        "some rows are in trouble, as they were in the run: their column status says which"
    )
    assert basins.CRITERION == (
        "a cell belongs to a periodic attractor when one whole period leads from ellipse to "
        "ellipse about its section points, with the attractor's impacts turn by turn, and the form "
        "of the ellipses shrinks by the factor given; to an aperiodic one when as many turns in a "
        "row as given lie in the boxes it visits; undecided when neither happens within the budget"
    )
    assert bench.NO_HEYOKA == (
        "heyoka is not installed, its points are left out: pip install 'camcli[bench]'"
    )
    assert cost.BOUND == (
        "bound for each event; a chaotic orbit multiplies it by its own stretching"
    )
    assert lift_table.MEANING == (
        "bound: 3 standard errors, and where smoothing changes more than they do what it may have "
        "changed; an estimate, since no table says what the cam does between its rows"
    )
    assert (explore.BASINS, explore.MAP) == ("Basins of attraction", "Map of motions")
    assert explore.DOUBLING == "Period doubling"
    assert figures.NO_REFERENCE == "there is no reference yet"
    assert figures.PORTABILITY == "portability broke"
    assert explore.NO_MOTION == (
        "no whole turn of any motion was recorded: there is no page to show"
    )
    assert rerun.ONLY_PICTURES == (
        "only pictures differ: their bytes are the same on the same installation alone"
    )


# --- what is said around them


def test_a_point_of_codimension_two_is_told_by_theory_where_it_was_to_be_proved():
    point = Made(kind=PointKind.CORNER_IMPACT_FOLD, label="P(1;1)", corners=("a",), first=376.3732,
                 second=0.7717172, meets=("fold", Condition.CORNER), proof=None)  # fmt: skip
    place = "corner-impact-fold of P(1;1) at rpm 376.3732, restitution 0.7717172 (fold & "
    unfolds = (
        "the curve of folds ends on the curve of corner impacts, tangent to it; its orbit is no "
        "motion beyond"
    )
    names = ("rpm", "restitution")
    where = f"{place}{Condition.CORNER} at a)"
    assert codim2.point_line(point, names) == f"{where}: {unfolds}"
    for step, proved in (
        (None, "proved to be one orbit with both"),
        (ProofStep.MODEL, "not proved: there is no proof yet for points of this kind"),
        (ProofStep.SINGULAR, "not proved: no box could be shown to hold exactly one orbit"),
    ):
        point.proof = Made(step=step)
        assert codim2.point_line(point, names) == f"{where}, {proved}: by theory, {unfolds}"


def of_orbits(**more):
    """A study of orbits of which nothing is to be told."""
    none = {"absent": None, "every": None, "orbits": [1], "continua": [], "limits": [],
            "virtual": [], "branches": [], "bifurcations": [], "proofs": None, "chaos": None,
            "curves": [], "codim2": [],
            "question": Made(rpm=700.25, plane=None, parameter="rpm")}  # fmt: skip
    return Made(**{**none, **more})


def test_where_a_machine_ends_and_what_is_left_out():
    limit = Made(value=1.25, reason="the lift would be negative")
    found = of_orbits(limits=[limit], question=Made(rpm=700.25, parameter="lift", plane=None))
    assert orbits.remarks(found) == [
        "there is no machine beyond lift = 1.25, where branches end (no-machine): the lift would "
        "be negative"
    ]
    point = Made(kind=PointKind.CUSP, label="P(1;1)", corners=(), first=1.0, second=2.0,
                 meets=("fold", "fold"), proof=None, ends=())  # fmt: skip
    question = Made(rpm=700.25, plane=Made(names=("rpm", "mass")), parameter="rpm")
    found = of_orbits(codim2=[point] * 8, question=question)
    said = orbits.remarks(found, verbose=False)
    assert said[:-1] == [codim2.point_line(point, ("rpm", "mass"))] * 6
    assert said[-1] == "2 further points of codimension two (codim2.csv)"
    assert len(orbits.remarks(found, verbose=True)) == 8


def test_a_branch_with_many_ranges_names_the_first_five():
    ranges, turns = [(700.0 + k, 700.5 + k) for k in range(7)], [800.0 + k for k in range(8)]
    branch = Made(number=3, turning_points=turns, stable_ranges=lambda events: ranges)
    assert orbits.branch_line(branch, []) == (
        "branch 3 is stable from 700 to 700.5, 701 to 701.5, 702 to 702.5, 703 to 703.5, 704 to "
        "704.5, in 2 further ranges (run.json); it turns round at 800, 801, 802, 803, 804, 3 "
        "further values (run.json)"
    )
    del ranges[5:], turns[5:]
    assert "further" not in orbits.branch_line(branch, [])
    assert orbits.stable_cell(branch, []) == "700 to 700.5, 701 to 701.5, ..."
    assert orbits.more_than_a_table_tells(branch, [])
    del ranges[2:], turns[2:]
    assert orbits.stable_cell(branch, []) == "700 to 700.5, 701 to 701.5"
    assert orbits.turns_cell(branch) == "800, 801"
    assert not orbits.more_than_a_table_tells(branch, [])
    del ranges[:], turns[:]
    assert orbits.branch_line(branch, []) == "branch 3 is nowhere stable"
    assert (orbits.stable_cell(branch, []), orbits.turns_cell(branch)) == ("nowhere", "")


def test_the_heading_of_branches_says_which_were_asked_for():
    ask = Made(rpm=700.25, span=Made(low=650.5, high=750.0), parameter="rpm", label="P(1;1)",
               stable=False)  # fmt: skip
    study = Made(question=ask, orbits=[1, 2], absent=Made(rpm=701.5), value=700.25)
    assert orbits.heading(study, "") == (
        "Periodic orbits, 650.5 to 750.0 rpm",
        "2 orbits found at 700.25 rpm, only P(1;1) asked for, only unstable ones followed, none at "
        "701.5 rpm",
    )
    ask.stable, ask.label, study.absent, study.orbits = True, None, None, [1]
    assert orbits.heading(study, "")[1] == "1 orbit found at 700.25 rpm, only stable ones followed"


def speed(quantity, region="B7"):
    return CriticalSpeed(
        quantity, region, radians(123.5), 711.0, 710.0, 712.0, SpeedStatus.OK
    )  # fmt: skip


@pytest.mark.parametrize(
    ("source", "said"),
    [
        (CornerHit(3, "d", 711.0, 710.0, 712.0, SpeedStatus.OK, "A2"),
         "impact 3 after lift-off lands on corner d"),
        (speed(CriticalQuantity.FIRST_DETACHMENT), "the contact force reaches zero at 123.5 deg"),
        (speed(CriticalQuantity.ACCUMULATION), "impacts accumulate exactly at corner B7"),
        (speed(CriticalQuantity.COMPLETION_LOSS),
         "the chatter ends where the next one begins: it is no longer complete"),
        (Made(beyond=None),
         "P(2;3) ends (grazing), and what a run beyond it settles on is not known"),
        (Made(beyond=Made(label="P(5;4)")),
         "P(2;3) ends (grazing), and a run beyond it settles on P(5;4)"),
        (None, "grazing"),
    ],
)  # fmt: skip
def test_what_happens_at_a_critical_speed(source, said):
    event = CriticalEvent(711.0, 0.5, Kind.GRAZING, "P(2;3)", source=source)
    assert explanations.event_sentence(event) == said


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (Kind.PERIOD_DOUBLING, "a multiplier of P(2;1:1) passes -1"),
        (Kind.FOLD, "P(2;1:1) meets an unstable orbit and both vanish"),
        (Kind.CORNER_IMPACT, "an impact of P(2;1:1) reaches corner b"),
        (Kind.GRAZING, "P(2;1:1) ceases to be a motion"),
        (Kind.LOST, str(Kind.LOST)),
    ],
)
def test_what_happens_to_an_orbit(kind, said):
    event = Made(kind=kind, label="P(2;1:1)", corner="b", corner_impact=None, located=None)
    event.beyond, event.continues, event.orbit = "", 0, Made(thetas=(), regions=())
    assert explanations._bifurcation(event).split(": ")[0] == said


def test_events_without_a_number():
    assert explanations.unnumbered(3) == "and 3 more, drawn without a number, listed in run.json"


# --- plans


def asked(**sections):
    off = {"animate": False, "explain": False, "adaptive": False, "curves": "off", "tolerance": [],
           "machines": 0, "refine": 0, "count": 1, "prove": False}  # fmt: skip
    names = ("simulate", "sweep", "detach", "basins", "classify")
    return Made(**{name: Made(**{**off, **sections.get(name, {})}) for name in names})


@pytest.mark.parametrize(
    ("command", "more", "said"),
    [
        ("simulate", {"animate": True}, ["drawing the animation comes on top, some 10 to 20 s"]),
        ("sweep", {"explain": True},
         ["how long --explain takes is not known before the run: 5 to 15 s for many a change"]),
        ("sweep", {"adaptive": True},
         ["how many speeds --adaptive adds is not known before the run"]),
        ("sweep", {"curves": "auto"},
         ["how many curves --curves auto follows is not known before the run"]),
        ("sweep", {"prove": True}, ["a proof of --prove takes 0.2 to 5 s for each curve"]),
        ("detach", {"tolerance": [1], "machines": 250},
         ["250 machines of --tolerance come on top, 0.1 s each"]),
        ("basins", {"refine": 2}, ["what --refine adds at boundaries is not known before the run"]),
        ("basins", {"count": 2},
         ["a speed in the middle stands for all, but speeds with chaos take many times as long"]),
        ("classify", {"explain": True},
         ["how long --explain takes is not known before the run: 5 to 15 s for many a change"]),
    ],
)  # fmt: skip
def test_what_a_plan_cannot_know(command, more, said):
    tell = getattr(plan, command)
    assert tell(asked(**{command: more})) == said
    assert tell(asked()) == []


def test_what_no_plan_of_orbits_or_of_a_page_knows():
    assert plan.orbits(asked()) == [
        "how many branches there are, and so the time, is not known before the run"
    ]
    assert plan.explore(asked()) == [
        "the orbits come on top: how many are solved is not known before the run"
    ]
    assert plan.LESS_OF_A_SWEEP == "--set sweep.tables=npz writes less"
    assert plan.turns_of_a_motion(60, 720) == "60 recorded turns x 720 samples"
    assert plan.speeds_of_a_sweep(41, 360, 60) == "41 speeds of 360 turns, 60 recorded"
    assert plan.motions_at_speeds(5, 3, 60) == "5 speeds x 3 starts x 60 recorded turns"
    assert plan.cells_of_a_window(24, 36, 2) == "24 x 36 cells, refined 2 times"
    assert plan.parts_of_a_page(11, 0, 0) == "11 speeds of 3 sweeps"
    assert plan.parts_of_a_page(11, 576, 81) == (
        "11 speeds of 3 sweeps, 576 cells, 81 points of a map"
    )
    assert plan.of_a_shard(2, 7) == "shard 2 of 7: pieces only, no tables"
    assert plan.cut_off(12.5) == (
        "a small part took 12.5 s: how long it takes is not known before the run"
    )
    assert plan.budget_ends(5000, 12.4) == "run.work_budget = 5000 ends it after some 12 s"


# --- the cam and its lobe


def lobe(**more):
    own = {"undercut": True, "least": Made(value=-0.0012345, theta=radians(123.456)),
           "face": Face.ROLLER, "least_base": 0.0234567, "largest_roller": Made(value=0.0087654),
           "hollow": None, "roller": 0.01, "closing": 0.0,
           "touches": [Made(along=0.02)]}  # fmt: skip
    return Made(**{**own, **more})


def test_a_lobe_that_cannot_be_made():
    begin = (
        "warning: the lobe is undercut: its radius of curvature would be -1.234 mm at 123.46 deg; "
    )
    roller = begin + "on this base circle a roller may have at most 8.765 mm"
    assert simulate.lobe_notes(lobe(), MILLIMETRES) == [roller]
    assert simulate.lobe_notes(lobe(face=Face.FLAT), MILLIMETRES) == [
        begin + "the base radius must exceed 23.46 mm"
    ]
    assert simulate.lobe_notes(lobe(largest_roller=None), MILLIMETRES) == [
        "warning: the lobe is undercut: the slope of the lift drops at a corner"
    ]
    assert simulate.lobe_notes(lobe(face=Face.KNIFE, least_base=None), MILLIMETRES) == [roller]
    assert simulate.lobe_notes(lobe(undercut=False), MILLIMETRES) == []
    assert simulate.pressure_notes(lobe(), MILLIMETRES) == [
        roller + "; where it is undercut the Hertz pressure is infinite"
    ]


def test_titles_of_a_lobe():
    assert simulate.radius_title(lobe(), MILLIMETRES) == (
        "undercut, -1.234 mm, largest roller 8.765 mm"
    )
    fine = lobe(undercut=False, least=Made(value=0.0012345, theta=0.0), largest_roller=None,
                hollow=Made(value=-0.04))  # fmt: skip
    assert simulate.radius_title(fine, MILLIMETRES) == "least 1.234 mm, hollow -40 mm"
    fine.face = Face.FLAT
    assert simulate.radius_title(fine, MILLIMETRES) == (
        "least 1.234 mm; needs a base radius above 23.46 mm"
    )
    assert simulate.lobe_title(lobe(), MILLIMETRES) == "roller of 10 mm"
    assert simulate.lobe_title(lobe(face=Face.KNIFE), MILLIMETRES) == "knife edge"
    assert simulate.lobe_title(lobe(face=Face.FLAT), MILLIMETRES) == "flat face"
    touches = [Made(along=x) for x in (0.01, 0.02, 0.015)]
    rounded = lobe(closing=2e-14, touches=touches)  # 1e-12 of the largest radius
    assert simulate.closing_words(rounded, MILLIMETRES) == "closes to rounding"
    assert simulate.closing_words(lobe(closing=2.1e-14), MILLIMETRES) == (
        "does not close: 2.1e-11 mm are missing"
    )
    beside = lobe(beside=(Made(value=-0.0123456), Made(value=0.25)))
    assert simulate.beside_title(beside, MILLIMETRES) == "−0.71 to 14.32 deg"
    beside.face = Face.FLAT
    assert simulate.beside_title(beside, MILLIMETRES) == "−12.3 to 250.0 mm"
    beside.beside = (Made(value=-0.25), Made(value=-0.0123456))
    assert simulate.beside_title(beside, MILLIMETRES) == "−250.0 to −12.3 mm"
    # a kink cuts a lobe whose radius of curvature is nowhere below zero
    kinked = lobe(least=Made(value=0.002), largest_roller=None)
    assert simulate.radius_title(kinked, MILLIMETRES) == "undercut, 2 mm"
    for undercut, face in ((True, "flat face: undercut"), (False, "flat face")):
        bent = Made(undercut=undercut, least_base_radius=0.0123456)
        said = simulate.flat_face_title(bent, MILLIMETRES)
        assert said == f"{face}, needs a base radius above 12.35 mm"


@pytest.mark.parametrize(
    ("rpm", "seconds", "near", "said"),
    [
        (600.0, 2.0, 1.0, "20 times slower"),
        (30.0, 2.0, 1.0, "1 times slower"),
        (15.0, 2.0, 3.0, "2 times faster, 3 times that near impacts"),
        (600.0, 2.0, 0.5, "20 times slower, 0.5 times that near impacts"),
    ],
)
def test_how_an_animation_compares_with_the_machine(rpm, seconds, near, said):
    assert simulate.slowed(rpm, seconds, near) == said


def test_a_record_that_ends_early_says_why_whatever_the_status():
    for status in Status:
        said = simulate.stopped(Made(status=int(status)))
        told = f"stopped ({status.text}): {statuses.CAUSES.get(status)}"
        assert said == ("" if status is Status.OK else told)


def test_titles_of_a_jerk_and_of_the_first_detachment():
    assert simulate.jerk_title({}) == "infinite nowhere"
    assert simulate.jerk_title({"a": 1.0, "b": 2.0}) == "infinite at a, b"
    corners = {f"c{k}": float(k) for k in range(12)}
    assert simulate.jerk_title(corners) == f"infinite at {', '.join(corners)}"
    assert simulate.jerk_title({**corners, "d": 0.0}) == "infinite at 13 corners"
    assert simulate.cam_words(None, False, 1.0) == "no speed marks a first detachment"
    first = Made(finite=True, theta=radians(196.81612), rpm=3352.1234, low=3333.0, high=3378.0)
    assert simulate.cam_words(first, False, 1.25) == (
        "first detachment at 3352.12 rpm, 196.816 deg; outline and curvature are those of the lobe "
        "under a rocker of 1.25"
    )
    assert simulate.cam_words(first, True, 1.0) == (
        "first detachment at 3352 rpm, 196.8 deg (3333 to 3378 rpm by the error of the table)"
    )
    assert simulate.cam_words(None, False, 0.75).endswith(
        "; outline and curvature are those of the lobe under a rocker of 0.75"
    )
    first.finite = False
    assert simulate.cam_words(first, False, 1.0) == "no speed marks a first detachment"


def test_what_the_page_says_of_a_measured_cam():
    accuracy = Made(rms=1.23e-7, bound=0.01234)
    said = (
        "The cam is a smoothed lift table, right to 0.12 µm rms and, by estimate, to "
        "12 mm/rad² in its second derivative: contact is first lost at 3333 to 3378 "
        "rpm{}. Motions and bifurcations are those of the smoothed cam."
    )
    between = (3333.0, 3378.0)
    assert lift_table.smoothed_cam(accuracy, MILLIMETRES, between, None) == said.format("")
    assert lift_table.smoothed_cam(accuracy, MILLIMETRES, between, 3352.12) == said.format(
        " (3352 by the fit)"
    )


def test_what_was_proved_of_the_loss_of_contact():
    hit = CornerHit(3, "d", 711.25, 710.0, 712.0, SpeedStatus.OK, "A2")
    first = speed(CriticalQuantity.FIRST_DETACHMENT)
    names = [detach.proof_name(one) for one in (hit, first)]
    assert names == ["impact 3 on corner d at 711.25 rpm", "the first detachment at 711 rpm"]
    assert detach.proved_words(1, []) == "proved: 1 statement, with certificates in proof.json"
    assert detach.proved_words(2, names) == (
        "proved: 2 statements, with certificates in proof.json; not proved: impact 3 on corner d "
        "at 711.25 rpm, the first detachment at 711 rpm"
    )
    assert detach.proved_words(0, []) == "nothing was proved of the loss of contact"
    assert detach.proved_words(0, names[1:], NoStatement.LASH) == (
        "nothing was proved of the loss of contact: a certificate has no words for the seat of a "
        "cam with lash; not proved: the first detachment at 711 rpm"
    )


def test_a_spring_that_would_be_solid():
    hold = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.IMPOSSIBLE, 1000.0, 50.0)
    hold = Hold(**{**vars_of(hold), "obstacle": Obstacle.SOLID, "missing_n": 0.00123456})
    assert detach.spring(hold) == (
        "impossible: the spring, compressed so far, is solid 1.23 mm before the highest lift"
    )


def vars_of(one):
    return {name: getattr(one, name) for name in type(one).__dataclass_fields__}


@pytest.mark.parametrize(
    ("by", "ends", "said"),
    [
        (None, (700.0, 700.0), "it is 700 rpm of the cam, as run.rpm is"),
        (Made(basis=Basis.FIRST_LOSS, rpm=3352.123), (100.0, 350.0),
         "it is 100 to 350 rpm of the cam, chosen from the first loss of contact at 3352.1 rpm"),
        (Made(basis=Basis.NATURAL, rpm=3352.123), (100.0, 350.0),
         "it is 100 to 350 rpm of the cam, chosen from the natural frequency, 3352.1 per minute"),
        (Made(basis=Basis.FALL, rpm=3352.123), (100.0, 350.0),
         "it is 100 to 350 rpm of the cam, where the cam accelerates as the follower falls"),
    ],
)  # fmt: skip
def test_speeds_that_were_chosen(by, ends, said):
    chosen = Made(low=ends[0], high=ends[1], by=by)
    assert speeds.chosen_speeds("sweep", chosen) == f"note: sweep.rpm is not given: {said}"


def test_how_a_sweep_was_started():
    start = Made(q=None, v=None)
    own = {"key": "rpm", "also": (), "speeds": (Made(value=700.5), Made(value=710.0))}
    settings = Made(transient=300, start=start)

    def told(direction, **more):
        return sweep.start_words(Made(**{**own, "direction": direction, **more}), settings)

    assert told("fixed") == "each speed started at rest on the cam, 300 turns of transient"
    assert told("up") == (
        "carried up from 700.5 rpm, started there at rest on the cam; 300 turns of transient at "
        "each speed"
    )
    assert told("both", also=(Made(q=0.25, v=None),)) == (
        "carried up, then down, started at rest on the cam, and at q = 0.25 m, the cam's v; 300 "
        "turns of transient at each speed"
    )
    settings.start = Made(q=None, v=-0.5)
    assert told("fixed", key="follower.mass") == (
        "each value started on the cam, v = -0.5 m/s, 300 turns of transient"
    )
    assert told("up", speeds=()) == told("fixed")  # nothing was carried
    settings.start = Made(q=0.25, v=0.0)
    assert told("fixed") == "each speed started at q = 0.25 m, v = 0 m/s, 300 turns of transient"
    settings.start = Made(q=None, v=-0.5)
    said = sweep.start_words(Made(**own, direction="fixed"), settings, "oscillator")
    assert said == "each speed started at the stop, v = -0.5 m/s, 300 turns of transient"


def test_an_atlas_without_curves():
    assert sweep.atlas_words(Made(curves=[], points=[]), 2, 0.0) == [
        "no bifurcation of an orbit that bounces meets the edges of the map"
    ]


# --- the verdict


def machine(lift=0.01, has_seat=False, lash=0.0, kind="law", **more):
    """A result of a cam whose lowest lift is not zero; `more` are its other fields."""
    system = Made(lift=lift, lift_range=(0.002, 0.002 + lift), has_seat=has_seat, lash=lash,
                  is_seat=lambda theta: theta < pi / 2)  # fmt: skip
    scene = Made(run=Made(rpm=700.25, crank=False), cam=Made(kind=kind), spring=None)
    own = {"command": "detach", "system": system, "scene": scene, "tables": {}, "summary": {},
           "values": Made(holds=(), margin=0.0)}  # fmt: skip
    return Made(**{**own, **more})


def test_contact_that_is_never_held_or_never_lost():
    at = radians(123.456)
    for reason, why in (
        (Reason.KINK, "the cam's slope drops"),
        (Reason.FORCE, "the spring does not press even at standstill"),
    ):
        found = Made(always=[Made(reason=reason, theta=at)], first=None)
        assert verdict._answer(machine(), found, None) == [
            f"Contact is lost at every speed: {why} at 123.5 deg."
        ]
    never = Made(always=[], first=None)
    assert verdict._answer(machine(), never, None) == ["Contact holds at every speed."]
    assert verdict._answer(machine(kind="oscillator"), never, None) == []


def test_what_a_mass_before_a_stop_does():
    def told(u, contact):
        tables = {"events": {"u_minus_m_per_s": u}, "trajectory": {"contact": contact}}
        return verdict._of_an_oscillator(Made(tables=tables))

    assert verdict._of_an_oscillator(Made(tables={})) == (
        "This is the stop alone, seen from the steady motion that the mass has without it."
    )
    assert told([-0.123, -0.456, 0.0], ["flight"]) == "The mass hits the stop at up to 0.46 m/s."
    assert told([0.0], ["flight", "flight"]) == (
        "The mass does not hit the stop in the turns recorded."
    )
    assert told([], ["sticking"]) == "The mass stays at the stop in the turns recorded."


@pytest.mark.parametrize(
    ("lift", "has_seat", "kind", "said"),
    [
        (1.01e-5, False, "law", "0.0101 mm above its lowest"),
        (0.99e-5, True, "law", "just above its seat"),
        (0.99e-5, False, "law", "on the base circle"),
        (0.99e-5, False, "table", "on the base circle"),
        (0.99e-5, False, "arcs", "on the base circle"),
        (0.99e-5, False, "harmonic", "at its lowest"),
    ],
)
def test_a_height_above_the_lowest(lift, has_seat, kind, said):
    """A thousandth of the lift, 1e-5 m, is told as none."""
    assert verdict.height(machine(has_seat=has_seat, kind=kind), lift) == said


@pytest.mark.parametrize(
    ("theta_deg", "has_seat", "said"),
    [
        (45.25, True, "45.25 deg, on its seat"),
        (90.0, True, "90 deg, the opening blow of the lobe"),
        (91.0, True, "91 deg, 5 mm above its lowest"),
        (45.25, False, "45.25 deg, 5 mm above its lowest"),
    ],
)
def test_where_the_follower_lands(theta_deg, has_seat, said):
    """The seat is below 90 deg."""
    assert verdict._place(machine(has_seat=has_seat), theta_deg, 0.005) == said


class Rows:
    """A table of columns."""

    def __init__(self, **columns):
        self.all = {name: np.array(values, dtype=float) for name, values in columns.items()}
        self.columns = tuple(self.all)

    def arrays(self, *names):
        return {name: self.all[name] for name in names}


def past(has_seat=False, lash=0.0, **changed):
    """The sentences on four speeds of which contact is lost beyond 705 rpm."""
    nan = float("nan")
    columns = {
        "rpm": [700.0, 710.6, 721.0, 731.6], "max_impact_m_per_s": [0.9, 0.1234, 0.4567, 0.2],
        "landing_deg": [10.0, 20.0, 123.456, 40.0], "landing_lift_m": [0.0, 0.0, 0.0012345, 0.0],
        "max_gap_m": [0.009, 0.001, 0.0005, 0.0023456],
        "shut_bounces_per_turn": [9.0, 0.0, 1.234, 0.5],
        "seat_velocity_m_per_s": [0.8, nan, 0.0567, 0.0123],
        "seat_ramp_velocity_m_per_s": [0.7, nan, 0.0346, 0.0123],
        "seat_bounce_height_m": [0.008, nan, 2.346e-5, 1e-6],
    }  # fmt: skip
    result = machine(
        has_seat=has_seat, lash=lash, tables={"speeds": Rows(**{**columns, **changed})}
    )
    return list(verdict._past_the_loss(result, 705.0)), list(verdict._on_landings(result, 705.0))


def test_what_is_seen_past_the_loss_of_contact():
    """The row at 700 rpm, below the loss, has the largest numbers, and none of them is told."""
    range_of_speeds = "Past it, from 711 to 732 rpm, it "
    hardest = "the hardest landing is at 123.5 deg, 1.23 mm above its lowest"
    assert past() == (
        [range_of_speeds + "flies 2.35 mm and lands at 0.46 m/s at most"],
        [hardest, "it bounces on the shut cam, 1.2 times a turn at most"],
    )
    assert past(shut_bounces_per_turn=[9.0, 0.0, 0.0, 0.0])[1] == [hardest]
    assert past(max_gap_m=[0.1, 0.0, 0.99e-5, 2e-6])[0] == [
        range_of_speeds + "hardly flies and lands at 0.46 m/s at most"
    ]
    assert past(max_gap_m=[0.1, 0.0, 1.01e-5, 2e-6])[0] == [
        range_of_speeds + "flies 0.0101 mm and lands at 0.46 m/s at most"
    ]
    assert past(max_impact_m_per_s=[12.0, 0.0, 23.456, 0.0])[0] == [
        "Past it, at 721 rpm, it flies 0.5 mm and lands at 23 m/s at most"
    ]
    assert past(max_impact_m_per_s=[1.0, 0.0, 0.0, 0.0]) == ([], [])


def test_how_the_follower_seats_past_the_loss_of_contact():
    seats = "It seats with up to 0.057 m/s"
    (_, seated), told = past(True)
    assert seated == seats
    assert told == [
        "the hardest landing is at 123.5 deg, 1.23 mm above its lowest",
        "on its seat it bounces up to 0.0235 mm",
    ]
    assert past(True, 1e-4)[0][1] == seats + " (the ramp alone: 0.035)"
    none = [0.8, float("nan"), 0.0, 0.0]
    never = "It never lands on its seat"
    assert past(True, 1e-4, seat_velocity_m_per_s=none)[0][1] == never
    set_down = f"{never}: without lash the lobe sets it down"
    assert past(True, seat_velocity_m_per_s=none)[0][1] == set_down
    # without a landing past the loss the seating of all speeds is told
    assert past(True, max_impact_m_per_s=[0.0] * 4) == (
        ["It seats with up to 0.8 m/s"],
        ["on its seat it bounces up to 8 mm"],
    )


def test_where_no_speed_varies_nothing_is_told_of_landings():
    rows = Rows(**{"cam.lash": [1e-4], "max_impact_m_per_s": [0.1]})
    result = machine(has_seat=True, lash=1e-4, tables={"speeds": rows})
    assert (
        list(verdict._past_the_loss(result, 705.0))
        == list(verdict._on_landings(result, 705.0))
        == []
    )


def test_a_seating_velocity_has_the_range_that_its_table_leaves():
    entry = {"seat_velocity_m_per_s": 1.23456, "seat_velocity_low_m_per_s": 1.2011,
             "seat_velocity_high_m_per_s": 1.2681}  # fmt: skip
    summary = {"seating": [entry], "working": {"seat_velocity_m_per_s": 1.23456}}
    result = Made(summary=summary)
    told = "1.23 m/s, 1.20 to 1.27 by its table"
    assert verdict._with_range(result, 1.23456) == told
    assert verdict._with_range(result, 1.3) == "1.3 m/s"
    assert list(verdict._on_working_seat(result)) == [f"at the working speed it seats with {told}"]
    assert list(verdict._on_working_seat(Made(summary={"working": None}))) == []
    no_table = Made(summary={"working": {"seat_velocity_m_per_s": 1.23456}})
    assert list(verdict._on_working_seat(no_table)) == []  # told with what happens there


@pytest.mark.parametrize(
    ("high", "told"),
    [(2.5, "2.0 m/s, 1.5 to 2.5 by its table"),
     (2.6, "2.0 m/s, which its table hardly tells: 1.5 to 2.6")],
)  # fmt: skip
def test_a_range_as_wide_as_half_the_seating_velocity_is_said_to_be_wide(high, told):
    entry = {"seat_velocity_m_per_s": 2.0, "seat_velocity_low_m_per_s": 1.5,
             "seat_velocity_high_m_per_s": high}  # fmt: skip
    assert verdict._with_range(Made(summary={"seating": [entry]}), 2.0) == told


def test_what_happens_at_the_working_speed():
    work = {"rpm": 3500.5, "open": False, "least_force_n": 12.3456, "theta_deg": 196.816,
            "max_impact_m_per_s": None, "landing_deg": None, "landing_lift_m": None}  # fmt: skip

    def told(has_seat=False, **more):
        result = machine(has_seat=has_seat, summary={"working": {**work, **more}})
        (said,) = verdict._at_work(result, 2.0)
        return said

    begin = "At the working speed, 3500.5 rpm of the cam (7001 of the crank), "
    assert told() == (begin + "contact holds: the cam is pressed with at least 12.3 N at 196.8 deg")
    seat = "; the follower comes to its seat with 0.12 m/s"
    assert told(seat_velocity_m_per_s=0.1234) == (
        begin + "contact holds: the cam is pressed with at least 12.3 N at 196.8 deg" + seat
    )
    assert told(open=True, seat_velocity_m_per_s=0.1234) == (
        begin + "the error of the table leaves open whether contact holds: on the fitted cam the "
        "least force is 12.3 N at 196.8 deg" + seat
    )
    lost = {"max_impact_m_per_s": 0.4567, "landing_deg": 123.456, "landing_lift_m": 0.0012345}
    assert told(**lost) == (
        begin + "contact is lost: the follower lands at up to 0.46 m/s (123.5 deg, 1.23 mm above "
        "its lowest)"
    )
    on_seat = {**lost, "landing_deg": 60.0, "seat_velocity_m_per_s": 0.1234}
    assert told(has_seat=True, **on_seat).endswith("lands at up to 0.46 m/s (60 deg, on its seat)")
    on_lobe = {**on_seat, "landing_deg": 101.0}  # 101 rad are on the seat
    assert told(has_seat=True, **on_lobe).endswith("(101 deg, 1.23 mm above its lowest)" + seat)
    assert list(verdict._at_work(machine(), 2.0)) == []


def test_which_spring_to_take():
    stiff = Hold(CriticalQuantity.HOLD_STIFFNESS, HoldStatus.OK, 45_000.0, 60.0)
    more = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.OK, 36_000.0, 325.0)
    both = Hold(CriticalQuantity.HOLD_BOTH, HoldStatus.OK, 40_000.0, 100.0)

    def result_of(*holds, kind="law", solid_at=None):
        result = machine(kind=kind, values=Made(holds=holds, margin=2.5, springs=[]))
        result.scene.detach = Made(hold_to=4000.0)
        result.scene.spring = None if solid_at is None else Made(solid_at=solid_at)
        return result

    def told(*holds, first=3300.0, kind="law"):
        return list(verdict._springs(result_of(*holds, kind=kind), first))

    asked = "up to 4000 rpm of the cam with 2.5 N to spare"
    rate, load = "45 N/mm", "325 N"
    words = [verdict.spring_words(hold, MILLIMETRES) for hold in (stiff, more, both)]
    assert all(part in said for part, said in zip((rate, load, "40 N/mm"), words, strict=True))
    assert told(stiff) == [f"To hold {asked} it takes {words[0]}"]
    assert told(stiff, more, both) == [
        f"To hold {asked} it takes {words[0]}, {words[1]} or {words[2]}"
    ]
    none = Hold(CriticalQuantity.HOLD_STIFFNESS, HoldStatus.IMPOSSIBLE, 1.0, 1.0)
    assert told(none) == [f"To hold {asked}, no spring can be named, see below"]
    assert list(verdict._on_springs(result_of(none, solid_at=0.02))) == [
        "where a spring of another rate is solid is not known: solid_at is the present one's"
    ]
    assert list(verdict._on_springs(result_of(none))) == []
    softer = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.OK, 36_000.0, 25.0, more=False)
    assert told(softer, stiff) == [f"The present spring holds {asked}"]
    assert told(stiff, first=4000.5)[0] == (
        "The present spring holds beyond 4000 rpm, but not with 2.5 N to spare: that margin asks "
        "for another"
    )
    assert told(stiff, first=4000.5, kind="table")[0] == (
        "On the fitted cam the present spring holds beyond 4000 rpm, but not with 2.5 N to spare "
        "whatever the error of its table: margin and error ask for another"
    )
    assert told(stiff, first=4000.0)[0].startswith("To hold")
    assert told() == []


def test_springs_that_hold_for_every_cam_of_a_table():
    """The least force of the springs found, 7.654 N, is 5.154 N more than the margin."""
    stiff = Hold(CriticalQuantity.HOLD_STIFFNESS, HoldStatus.OK, 45_000.0, 60.0)
    more = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.OK, 36_000.0, 325.0)

    def told(*forces, kind="table", margin=2.5):
        curves = list(zip((None, stiff, more), map(curve, forces), strict=False))
        result = machine(kind=kind, values=Made(springs=curves, margin=margin))
        return list(verdict._for_the_table(result, found))

    found = [stiff]  # the other spring, which presses less, is not of them

    def curve(newtons):
        return Made(lowest_n=newtons)

    assert told(-3.0, 7.654, 1.0) == [
        "the springs hold for every cam that the table leaves: on the fitted one they press with "
        "at least 7.65 N, 5.2 N of it for the error of the table"
    ]
    assert told(-3.0, 7.654, kind="law") == []
    assert told(-3.0, 2.5) == []
    found = [stiff, more]
    assert told(-3.0, 7.654, 1.0) == []
    for forces in ((7.654, 9.0), (9.0, 7.654)):
        assert "at least 7.65 N, 5.2 N of it" in told(-3.0, *forces)[0]
    assert told(-3.0) == []


def test_machines_within_their_tolerances():
    stiff = Hold(CriticalQuantity.HOLD_STIFFNESS, HoldStatus.OK, 45_000.0, 60.0)
    more = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.OK, 36_000.0, 325.0)
    summary = {
        "median_rpm": 3352.123, "worst_rpm": 3101.456, "machines": 2000,
        "worst": {"follower.mass": 5.0, "table_error": -2.25},
        "shares": {"follower.mass": 0.234, "follower.stiffness": 0.567},
        "springs": {CriticalQuantity.HOLD_STIFFNESS: {"chance": 0.98765, "worst_rpm": 3987.654}},
    }  # fmt: skip
    result = machine(kind="table", summary={"tolerance": summary})
    result.values = Made(holds=[stiff, more])
    off = [Made(key="follower.mass", percent=5.0), Made(key="follower.stiffness", percent=2.5)]
    result.scene.detach = Made(tolerance=off, hold_to=4000.0)
    assert list(verdict._tolerances(result)) == [
        "Half of the machines in tolerance hold up to 3352 rpm, the worst up to 3101"
    ]
    assert list(verdict._on_tolerances(result)) == [
        "the tolerances are follower.mass 5 %, follower.stiffness 2.5 %, the error of the table",
        "in the worst machine they are follower.mass +5 %, the error of the table -2.25 %",
        "what matters most is follower.stiffness: 57 % of the variance",
        f"with {detach.way(stiff)} 98.8 % of them hold up to 4000 rpm, the worst up to 3988 rpm",
    ]
    summary["shares"], summary["springs"], result.scene.cam.kind = {}, {}, "law"
    assert list(verdict._on_tolerances(result)) == [
        "the tolerances are follower.mass 5 %, follower.stiffness 2.5 %",
        "in the worst machine they are follower.mass +5 %, the error of the table -2.25 %",
    ]
    result.summary = {}
    assert list(verdict._tolerances(result)) == list(verdict._on_tolerances(result)) == []


@pytest.mark.parametrize(("share", "told"), [(0.099, True), (0.101, False)])
def test_a_rate_that_is_asked_for_near_the_foot_of_the_lobe(share, told):
    """On c = 0.1 + 0.01 (1 - cos theta): a tenth of the lift is reached where cos theta = 0.8."""
    eccentric = load_scene(
        {"follower": {"mass": 1.0, "stiffness": 9.0, "restitution": 0.5},
         "cam": {"kind": "eccentric", "base": 0.1, "lift": 0.02}}
    )  # fmt: skip
    theta = acos(1.0 - 2.0 * share)
    system = System.build(Follower(1.0, 9.0), eccentric.cam)
    hold = Hold(CriticalQuantity.HOLD_STIFFNESS, HoldStatus.OK, 45_000.0, 60.0, theta=theta)
    said = list(verdict._at_the_foot(Made(system=system), [hold]))
    where = f"{degrees(theta):.4g} deg, {20.0 * share:.3g} mm above the lowest"
    sentence = (
        f"The rate of the spring with the same preload is asked for at {where}: there preload "
        "presses, and rate hardly does"
    )
    assert said == ([sentence] if told else [])
    preload = Hold(CriticalQuantity.HOLD_PRELOAD, HoldStatus.OK, 45_000.0, 60.0, theta=theta)
    assert list(verdict._at_the_foot(Made(system=system), [preload])) == []


def test_a_table_outside_the_folder_of_its_scene_is_told():
    cam = Made(kind="table", file="lift.csv", outside="/data/lift.csv", accuracy=None)
    with_notes = Made(cam=cam)
    said = lift_table.table_notes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(lift_table, "fit_line", lambda accuracy, file: f"the fit of {file}")
        patch.setattr(lift_table, "cautions", lambda accuracy: ["a caution"])
        assert said(with_notes) == [
            "note: cam.file: reads /data/lift.csv, outside the scene's folder",
            "the fit of lift.csv",
            "a caution",
        ]
        cam.outside = None
        assert said(with_notes) == ["the fit of lift.csv", "a caution"]
    cam.kind = "law"
    assert said(with_notes) == []
