"""Sentences on results made by hand: both sides of a limit, each of several, one and two things."""

from __future__ import annotations

from math import inf, nan, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.detachment import SpeedStatus
from camcli.analysis.contact_loss.hold import Hold, HoldStatus
from camcli.analysis.explain.changes import BASIN, MOST_CRISES, UNEXPLAINED
from camcli.analysis.explain.crisis import CrisisKind
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.errors import Status
from camcli.quantities import MILLIMETRES
from camcli.words import (
    basins,
    classify,
    detach,
    explanations,
    explore,
    figures,
    lift_table,
    machine,
    orbits,
    sweep,
)
from tests.output.test_phrases import of_orbits
from tests.output.test_whole_sentences import contact_loss, critical
from tests.output.test_words_of_proofs_and_basins import speed

# --- cam orbits


def test_each_end_of_a_branch_that_could_not_be_followed_is_told():
    """Lost at the first point and a fault at the last one, and the other way round."""
    points = (Made(value=701.25), Made(value=702.0), Made(value=703.75))
    ends = {4: (Kind.LOST, Kind.FAULT), 5: (Kind.FAULT, Kind.LOST)}
    both = [Made(number=k, ends=own, points=points) for k, own in ends.items()]
    event = Made(status=Bracket.UNRESOLVED, kind="fold", label="P(1;1)", value=700.125)
    found = Made(bifurcations=[Made(status=Bracket.OK), event], branches=both, every=None,
                 chaos=None, curves=[], question=Made(curve=None))  # fmt: skip
    told = orbits.notes(found)
    assert told[0] == "unresolved: fold of P(1;1) near 700.125 has no safe bracket"
    assert told[1] == "branch 4 could not be followed beyond 701.25, where it is unresolved"
    assert "on branch 4 beyond 703.75" in told[2]
    assert told[3] == "branch 5 could not be followed beyond 703.75, where it is unresolved"
    assert "on branch 5 beyond 701.25" in told[4]
    assert len(told) == 5
    found.bifurcations, found.branches, found.question = [], [], Made(curve="fold")
    found.curves = [Made(points=[]), Made(points=[1])]
    assert orbits.notes(found) == []


def branch(number, ranges, turns, largest=0.5):
    found = Made(number=number, turning_points=turns, points=[Made(det=0.1), Made(det=largest)])
    found.stable_ranges = lambda events: ranges
    return found


def test_without_verbose_a_branch_is_told_of_where_a_table_has_no_room():
    few = branch(1, [(700.0, 710.0)], [705.0, 706.0])
    many = branch(2, [(700.0, 710.0)], [705.0, 706.0, 707.0], largest=0.75)
    stable = branch(3, [(700.0 + k, 700.5 + k) for k in range(3)], [])
    found = of_orbits(branches=[few, many, stable])
    told = orbits.remarks(found, verbose=False)
    assert [line.partition(" is ")[0] for line in told] == ["branch 2", "branch 3"]
    told = orbits.remarks(found)
    assert [line.partition(" is ")[0] for line in told[:3]] == ["branch 1", "branch 2", "branch 3"]
    assert told[3].endswith("at most 0.75 on these branches, below 1")
    assert len(told) == 4
    many.points[1].det = 1.0
    assert orbits.remarks(found)[3] == orbits.NEUTRAL


def test_roots_that_are_no_motion_are_counted_from_the_first():
    one, two = (orbits.remarks(of_orbits(virtual=[0] * n))[0] for n in (1, 2))
    assert one.startswith("1 further root at 700.25 rpm is virtual: ")
    assert two.startswith("2 further roots at 700.25 rpm are virtual: ")


def test_an_event_that_branches_share_is_told_once_and_by_its_first_branch(monkeypatch):
    """Without --verbose a corner impact has its class alone; other events are told as with it."""
    monkeypatch.setattr(orbits, "event_words", lambda event: event.words)
    monkeypatch.setattr(orbits, "corner_line", lambda impact: f"class {impact.kind}")
    monkeypatch.setattr(
        orbits, "_rests_on", lambda event: "" if event.corner_impact is None else "!"
    )

    def event(number, value, words, impact=None, kind=Kind.CORNER_IMPACT):
        return Made(branch=number, value=value, words=words, corner_impact=impact, kind=kind,
                    label="P(1;1)")  # fmt: skip

    shared = Made(kind="persistence")
    events = [
        event(2, 710.5, ["of branch 2."], shared),
        event(1, 720.0, ["It rests.", "So it stays."]),
        event(1, 710.5, ["of branch 1."], shared),
        event(1, 705.0, [], kind=Kind.FOLD),
    ]
    found = Made(bifurcations=events)
    at = "corner-impact of P(1;1) at"
    assert orbits._on_events(found, verbose=True) == [
        f"{at} 710.5: of branch 1.!", f"{at} 720: It rests. So it stays.", orbits.SIDES
    ]  # fmt: skip
    assert orbits._on_events(found, verbose=False) == [
        f"{at} 710.5: class persistence", f"{at} 720: It rests. So it stays."
    ]  # fmt: skip
    found.bifurcations = [events[1]]
    assert orbits._on_events(found, verbose=True) == [f"{at} 720: It rests. So it stays."]
    kinds = [(one.branch, one.value) for one in orbits.in_order(events)]
    assert kinds == [(1, 705.0), (1, 710.5), (1, 720.0), (2, 710.5)]


def test_the_heading_of_another_number_has_its_value_and_not_the_end_of_its_range():
    ask = Made(rpm=700.25, span=Made(low=0.4, high=0.6), parameter="restitution", label=None,
               stable=None)  # fmt: skip
    study = Made(question=ask, orbits=[1], absent=Made(rpm=701.5), value=0.55)
    assert orbits.heading(study, "") == (
        "Periodic orbits, coefficient of restitution 0.4 to 0.6 at 700.25 rpm",
        "1 orbit found at coefficient of restitution 0.55, none at 701.5 rpm",
    )
    study.orbits = []  # what is absent is then told in the picture
    assert orbits.heading(study, "")[1] == "0 orbits found at coefficient of restitution 0.55"
    ask.span = None
    assert orbits.heading(study, "") == (
        "Periodic orbits at 700.25 rpm", "0 orbits found at 700.25 rpm"
    )  # fmt: skip


def test_the_two_sides_of_a_corner_have_their_own_linear_parts():
    before, after = Made(trace=-0.75, det=0.125), Made(trace=0.5, det=0.0625)
    left = (
        "impact before the corner (left): trace −0.75, determinant 0.125, multipliers −0.5, −0.25"
    )
    right = "impact after the corner (right): trace 0.5, determinant 0.0625, multipliers 0.25"
    assert orbits.side_words(Made(left=before, right=after)) == [left, right]
    assert orbits.side_words(Made(left=None, right=after)) == [right]
    assert orbits.side_words(Made(left=before, right=None)) == [left]


def test_long_labels_of_a_branch_are_cut_to_22_letters():
    long = "P(12;" + "1:" * 11 + "1)"
    one = Made(number=4, labels=[long, "P(1;1)", long], ends=("", ""),
               points=[Made(value=1.0, regions=["A1"])])  # fmt: skip
    assert orbits.branch_words(one, "rpm", 7, 99) == (
        "4   P(12;1:1:1:1:1:1:1:1…) to P(12;1:1:1:1:1:1:1:1…), from event 7"
    )


def test_both_ends_of_a_curve_are_told_also_where_they_are_alike():
    curves = [Made(ends=(Kind.NO_MOTION, Kind.NO_MOTION), limits=("", "")),
              Made(ends=(Kind.ANOTHER_CORNER, Kind.LOST), limits=("P(1;1)", "")),
              Made(ends=(Kind.LOST, Kind.END_OF_RANGE), limits=("", ""))]  # fmt: skip
    points = [Made(kind="cusp", ends=[(2, 0), (3, 0)])]
    found = of_orbits(curves=curves, codim2=points)
    assert orbits._on_curves(found, verbose=False) == [
        "curve 1 ends: the orbit is no motion any more; the orbit is no motion any more",
        "curve 2 ends: an impact reaches a corner of P(1;1) (cusp); it could not be followed "
        "further",
        "curve 3 ends: cusp; end-of-range",
    ]


# --- cam detach


def test_contact_lost_at_the_very_end_of_the_range_is_lost_within_it():
    for rpms in ((650.0, 700.25), (700.25, 710.0)):
        assert detach.plainly(contact_loss(critical(), rpms=rpms)) == []


def test_where_contact_is_never_lost_no_region_is_told():
    never = [Made(region=Made(name="A3"), opens=Made(rpm=inf, theta=0.0))]
    assert detach.theory(contact_loss(None, never=True, losses=never)) == []
    assert detach.theory(contact_loss(critical(), losses=never)) == [
        "contact is never lost in A3, at any speed"
    ]


@pytest.mark.parametrize(("widths", "is_open"), [(3.9, False), (4.1, True)])
def test_the_width_of_a_computation_leaves_nothing_open(widths, is_open):
    half = 0.5 * widths * detach.NARROW * 700.0
    first = critical(rpm=700.0, low=700.0 - half, high=700.0 + half)
    assert detach._or_open("it holds", first, True).startswith("on the fitted cam") == is_open


def settled(rpm, *bursts, status=Status.OK):
    return Made(rpm=rpm, status=status, bursts=[Made(region=own, end=end) for own, end in bursts])


def test_speeds_with_the_same_bursts_make_a_range_with_their_count():
    """A burst that ends at the phase 0 is complete; what two bursts of a turn share stands once."""
    speeds = [
        settled(600.0, ("A2", 0.0), ("A4", None)),
        settled(601.0, ("A2", 1.0), ("A2", 2.0), ("A4", None)),
        settled(602.0),
        settled(603.0, ("", 1.5)),
        settled(604.0, ("A2", 1.0), status=Status.IMPACT_BUDGET),
        settled(605.0, ("A2", 1.0), status=Status.LOG_FULL),
        settled(606.5, ("A2", 1.0), status=Status.LOG_FULL),
    ]
    assert [tuple(one) for one in detach.burst_ranges(Made(speeds=speeds))] == [
        ("A2 complete, A4 incomplete", 600.0, 601.0, 2),
        ("none", 602.0, 602.0, 1),
        ("complete", 603.0, 603.0, 1),
        (Status.IMPACT_BUDGET.text, 604.0, 604.0, 1),
        (Status.LOG_FULL.text, 605.0, 606.5, 2),
    ]
    for status in Status:
        if status is not Status.OK:
            assert detach.bursts_text(settled(600.0, ("A2", 1.0), status=status)) == status.text


def test_the_sentence_of_a_title_has_the_first_speed_at_which_chatter_is_not_complete():
    study = contact_loss(critical(700.123456789123), completion=[critical(745.25), critical(730.5)])
    assert detach.first_loss(study, False) == (
        "contact is first lost at 700.123456789 rpm, 123.5 deg; chatter stops being complete at "
        "745.2500 rpm"
    )
    study.detachment.first = critical(700.1234, 690.0, 712.0, theta=radians(123.4567))
    study.completion = []
    assert detach.first_loss(study, True) == (
        "contact is first lost at 700.1 rpm, 123.5 deg (690 to 712 rpm by the error of the table)"
    )


def test_only_speeds_without_a_safe_bracket_are_noted():
    speeds = [critical(status=status, quantity="hit") for status in SpeedStatus]
    told = detach.unresolved_notes(contact_loss(critical_speeds=speeds))
    assert told == ["unresolved: hit A2 near 700.25 rpm has no safe bracket"]


def test_the_first_page_of_a_report_says_what_stands_on_the_second():
    """The tables of motions first, then the panels in their order."""
    said = detach.on_second_page(["surge", "max_gap_m"], motions=True)
    assert said == "On the second page: the motion past the loss of contact, surge, largest gap."
    assert detach.on_second_page(["shares", "machines"], motions=False) == (
        "On the second page: which tolerance matters, machines within their tolerances."
    )
    assert detach.on_second_page([], motions=True) == (
        "On the second page: the motion past the loss of contact."
    )
    assert detach.second_page("A title") == "A title (second page)"


@pytest.mark.parametrize(("measured", "speed"), [(True, "700.1"), (False, "700.123")])
def test_a_force_is_named_by_its_speed_and_its_least_value(measured, speed):
    curve = Made(rpm=700.1234, lowest_n=-12.3456, lowest_theta=radians(123.456))
    assert detach.force_name(curve, measured) == f"{speed} rpm: least −12.35 N at 123.5 deg"
    assert detach.spring_name(None, curve, MILLIMETRES) == "present spring: least −12.35 N"
    spring = Hold(detach.CriticalQuantity.HOLD_BOTH, HoldStatus.OK, 23456.7, 61.2345)
    assert detach.spring_name(spring, curve, MILLIMETRES) == (
        "23.46 N/mm, preload 61.23 N: least −12.35 N"
    )


# --- cam sweep


def swept(*known, rpm=700.5, holds_for=None, **more):
    """Motions of which it is told whether they are known, all at other speeds."""
    motions = [Made(known=one, holds_for=holds_for, rpm=rpm + k) for k, one in enumerate(known)]
    return Made(bare=motions, speeds=motions, **more)


def test_an_undecided_motion_counts_wherever_it_stands():
    for known in ((False, True), (True, False)):
        (note,) = sweep.sweep_notes(swept(*known))
        assert note.startswith("1 of 2 motions is undecided: ")
    decided = sweep.sweep_notes(swept(True, True, holds_for=HoldsFor.EXACT_DATA))
    assert len(decided) == 1
    assert sweep.map_notes(swept(True, True, holds_for=HoldsFor.EXACT_DATA), followed=True) == [
        decided[0].replace("speeds, ", "points, ").replace("of 2 speeds", "of 2 points")
    ]
    both = sweep.map_notes(swept(True, False, holds_for=HoldsFor.EXACT_DATA), followed=True)
    assert both[0] == "1 of 2 points is undecided: after a rest, rounding decides"
    assert len(both) == 2


def test_titles_have_the_speed_of_the_run_where_it_does_not_vary():
    found = swept(True, True, key="cam.lift")
    assert sweep.sweep_title(found, 2) == (
        "2 values of cam.lift at 700.5 rpm, 2 ranges of one label"
    )
    found.lines = [found.bare, found.bare[:1]]
    for keys, said in (
        (["cam.lift", "mass"], "cam.lift x mass: 3 points at 700.5 rpm"),
        (["cam.lift", "rpm"], "cam.lift x rpm: 3 points"),
        (["rpm", "cam.lift"], "rpm x cam.lift: 3 points"),
    ):
        found.keys = keys
        assert sweep.map_title(found) == said


def test_a_diagram_over_values_in_any_order_has_their_ends():
    found = Made(key="rpm", bare=[Made(rpm=700.5)])
    assert sweep.diagram_title(found, [710.0, 650.5, 700.0], "") == (
        "Bifurcation diagram, 650.5 to 710.0 rpm"
    )
    assert sweep.diagram_title(found, [], "") == "Bifurcation diagram"
    found.key = "restitution"
    assert sweep.diagram_title(found, [0.5, 0.25], "").endswith(
        "coefficient of restitution 0.25 to 0.50 at 700.5 rpm"
    )


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("cam.lift", 0.0125, "cam at lift of the cam 0.0125 m"),
        ("cam.lift", 2, "cam at lift of the cam 2 m"),
        ("cam.lift", "2 mm", "cam of the scene"),
        ("cam.lift", None, "cam of the scene"),
        ("follower.mass", 1.5, ""),
        ("rpm", 1.5, ""),
    ],
)
def test_the_cam_beside_a_diagram_is_named_where_its_numbers_vary(key, value, said):
    cam = Made(lift=value, mass=value, rpm=value)
    assert sweep.shown_cam(key, cam) == said


def test_what_stands_below_a_diagram_counts_each_kind_of_trouble():
    found = Made(key="rpm", direction="fixed", also=(), speeds=[1])
    settings = Made(transient=300, start=Made(q=None, v=None))
    how = "each speed started at rest on the cam, 300 turns of transient"
    codes = [0, Status.LOG_FULL, Status.NO_RETURN, Status.LOG_FULL, Status.LOG_FULL]
    values = [700.0, 710.0, 710.0, 720.0, 730.0]
    assert sweep.diagram_words(found, settings, values, codes, 2) == (
        f"{how}; 4 speeds; 4 not ok, marked at the bottom edge (log-full 3, no-return 1); "
        "2 undecided after rests, grey; darker where more points fall"
    )
    assert sweep.diagram_words(found, settings, values[:1], codes[:1], 0) == (
        f"{how}; 1 speed; darker where more points fall"
    )


def test_the_heading_of_a_map_has_both_ranges_and_along_which_the_state_is_carried():
    found = Made(keys=("restitution", "rpm"), first=[0.75, 0.5, 0.25], second=[700.0, 650.0],
                 direction="fixed", lines=[[Made(rpm=600.0)]])  # fmt: skip
    title = "Map of motions, coefficient of restitution 0.25 to 0.75, 650 to 700 rpm"
    assert sweep.map_heading(found, "") == (title, "3 × 2 points")
    found.direction = "up"
    assert sweep.map_heading(found, "") == (
        title, "3 × 2 points, the state carried up along the coefficient of restitution"
    )  # fmt: skip
    found.keys, found.direction = ("restitution", "mass"), "fixed"
    assert sweep.map_heading(found, "")[1] == "3 × 2 points at 600 rpm"


# --- changes of a diagram, crises


def crisis(**more):
    own = {"kind": CrisisKind.STAYS, "near": 700.25, "rpm": 712.5, "turns": 4000,
           "bracket": (701.5, 701.25), "inside": 3, "beyond": 2, "lost": 0, "met": [],
           "unmet": [], "corner": None}  # fmt: skip
    return Made(**{**own, **more})


def test_a_search_for_a_crisis_has_its_speeds_in_the_digits_of_their_errors():
    leaves = next(kind for kind in CrisisKind if kind.name not in ("STAYS", "NOT_CHAOTIC"))
    assert explanations.crisis_sentences(crisis()) == [
        "Nothing leaves the attractor carried from 700.25 rpm: a run of 4000 turns stays in its "
        "range at 712.5 rpm."
    ]
    assert explanations.crisis_sentences(crisis(kind=CrisisKind.NOT_CHAOTIC)) == [
        "The motion carried from 700.25 rpm is not chaotic."
    ]
    first, later = (
        Made(rpm=rpm, error=error, orbit=Made(label=label, multipliers=(size + 0j, 0.1 + 0j)))
        for rpm, error, label, size in (
            (701.26, 0.02, "P(1;1)", -2.3456789), (701.3, 0.003, "P(3;3)", 5.0)
        )
    )  # fmt: skip
    unmet = [Made(label="P(2;2)")]
    found = crisis(kind=leaves, lost=1, unmet=unmet)
    begin = [
        "Runs of 4000 turns carried from 700.25 rpm first leave the attractor's range at 701.2 "
        "rpm.",
        "Saddles seen: 3 in the attractor, 2 beyond it.",
    ]
    assert explanations.crisis_sentences(found) == [
        *begin,
        "1 of them could not be followed and is left out.",
        "P(2;2) leads out, but no fold was seen to touch its stable manifold.",
    ]
    found = crisis(kind=leaves, met=[first, later], unmet=unmet, corner=Made(name="b"))
    assert explanations.crisis_sentences(found) == [
        *begin,
        "The attractor meets the stable manifold of P(1;1) (larger multiplier -2.346) at 701.26 "
        "rpm.",
        "P(3;3) would be met later, at 701.300 rpm.",
        "P(2;2) leads out, but no fold was seen to touch its stable manifold.",
        "What touches the manifold is the image of an impact at corner b.",
    ]
    found.corner, found.met = None, [first]
    assert explanations.crisis_sentences(found)[-1] == "What touches the manifold is a smooth fold."


def change(**more):
    own = {"low": 700.5, "high": 701.25, "cause": UNEXPLAINED, "persists": (), "crisis": None,
           "status": Status.OK, "events": [], "may_search": True}  # fmt: skip
    return Made(**{**own, **more})


NOT_CHAOTIC = "The motion carried from 700.25 rpm is not chaotic."
NO_BRANCH = (
    "no bifurcation of a solved branch lies between them, and no branch through both is stable"
)
BESIDE = "at both speeds; whether the chaos beside lives on at both is not known"
FIRST_ONLY = f"; crises are looked for in the first {MOST_CRISES} changes only"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({}, NO_BRANCH),
        ({"may_search": False}, NO_BRANCH + FIRST_ONLY),
        ({"crisis": crisis(kind=CrisisKind.NOT_CHAOTIC)}, f"{NO_BRANCH}. {NOT_CHAOTIC}"),
        (
            {"persists": ("P(1;1)",), "crisis": crisis(kind=CrisisKind.NOT_CHAOTIC),
             "may_search": False},
            f"P(1;1) attracts {BESIDE}. {NOT_CHAOTIC}{FIRST_ONLY}",
        ),
        ({"persists": ("P(1;1)", "P(2;2)")}, f"P(1;1) and P(2;2) attract {BESIDE}"),
        (
            {"cause": BASIN, "crisis": crisis(kind=CrisisKind.NOT_CHAOTIC)},
            "the chaotic attractor lives on at both speeds: the start changes basins. "
            + NOT_CHAOTIC,
        ),
        (
            {"status": Status.NO_RETURN, "crisis": crisis(kind=CrisisKind.NOT_CHAOTIC)},
            "no-return: the follower left the cam and nothing brings it back",
        ),
    ],
)  # fmt: skip
def test_why_a_diagram_changes_or_what_was_tried(more, said):
    assert explanations.change_sentence(change(**more), []) == said


def test_an_orbit_that_persists_has_its_own_events_and_those_of_a_change_have_their_errors():
    events = [Made(kind=kind, rpm=rpm, label=label, error=error, source=source)
              for kind, rpm, label, error, source in (
                  ("fold", 650.123456, "P(1;1)", 0.02, None),
                  ("fold", 660.5, "P(1;1) of another", 0.0, None),
                  ("corner-hit", 670.25, "P(1;1)", 0.3, CornerHit.__new__(CornerHit)))]  # fmt: skip
    found = change(cause=BASIN, persists=("P(1;1)", "P(2;2)"))
    assert explanations.change_sentence(found, events) == (
        "P(1;1) exists and attracts at both speeds: the start changes basins; P(1;1) changes at: "
        "fold at 650.123456 rpm, corner-hit at 670.25 rpm; P(2;2) exists and attracts at both "
        "speeds: the start changes basins; P(2;2) does not change in the range"
    )
    found = change(cause="fold+corner-hit", events=[events[0], events[2]])
    assert explanations.change_sentence(found, []) == ("fold; corner-hit at 670.25 rpm (P(1;1))")
    assert explanations.change_line(found, [], verbose=False) == (
        "700.50 to 701.25 rpm: fold+corner-hit; at 650.12 rpm, P(1;1); at 670.2 rpm, P(1;1)"
    )
    assert explanations.change_line(found, []) == (
        "700.50 to 701.25 rpm, fold+corner-hit: fold; corner-hit at 670.25 rpm (P(1;1))"
    )


# --- cam classify


def motion(label="P(1;1)", largest=-0.5, second=-0.75, defect=0.0, **more):
    own = {"label": label, "value": 700.0, "rpm": 600.0, "status": Status.OK, "fault": None,
           "holds_for": None, "orbit": Made(resting=False, theta=[1.0]), "watched": None,
           "exponents": Made(largest=largest, second=second, defect=defect),
           "chatters": 0, "record": Made(periods=40)}  # fmt: skip
    return Made(**{**own, **more})


def test_an_exponent_of_several_motions_is_the_range_of_what_is_shown():
    assert classify.exponent_text([]) == ""
    assert classify.exponent_text([(0.12345, 0.02)]) == "0.12 +- 0.02"
    assert classify.exponent_text([(0.12341, 0.0), (0.12344, 0.5)]) == "0.1234"
    assert classify.exponent_text([(0.25, 0.0), (-0.5, 0.0), (0.125, 0.0)]) == "-0.5 to 0.25"


def test_the_sum_rule_is_told_of_the_worst_of_those_with_two_finite_exponents():
    motions = [motion(defect=2e-9), motion(defect=-3.3e-8), motion(second=-inf, defect=0.5),
               motion(exponents=None)]  # fmt: skip
    (said,) = classify.remarks(motions)
    assert said.endswith("less b T/m: within 3e-08 in 2 motions")
    rest = motion(largest=-inf, second=-inf, defect=nan)
    (rests,) = classify.remarks([rest])
    assert rests.startswith("where the follower rests, both exponents are -inf")
    assert classify.remarks([motions[0], rest])[1:] == [rests]
    assert classify.remarks([*motions, rest], verbose=False) == []


def test_what_is_not_solved_is_told_with_verbose_alone_and_what_is_undecided_always():
    chaos = motion("aperiodic", orbit=None, exponents=None)
    motions = [
        motion("aperiodic", orbit=None, exponents=None, watched=950),
        motion("aperiodic", orbit=None, exponents=None, watched=800, chatters=2, value=710.5),
        motion("aperiodic", orbit=None, exponents=None, watched=700, status=Status.NO_RETURN),
        motion("undecided", orbit=None, exponents=None, chatters=3, value=720.25),
        motion("undecided", orbit=None, exponents=None, watched=600, value=730.25),
        motion("undecided", orbit=None, exponents=None, fault=1, status=Status.FAULT),
    ]
    followed, first, complete, undecided = classify.remarks(motions)
    assert followed.startswith("a motion called aperiodic was followed for 800 turns or more")
    assert followed.endswith("rarer than once in 266 turns (95 %)")
    assert first.startswith("rpm = 710.5: the first complete chatter comes after 800 turns; ")
    assert complete.startswith(
        "rpm = 720.25: complete chatter in 3 of 40 turns, one in some 13.3; after a rest"
    )
    assert undecided.startswith("the motion at 2 speeds (720.25, 730.25 rpm) is undecided: ")
    assert classify.remarks(motions, verbose=False) == [undecided]
    assert classify.remarks([chaos]) == []
    (seldom,) = classify.remarks([motion("aperiodic", orbit=None, exponents=None, watched=2)])
    assert seldom.endswith("once in 1 turn (95 %)")


def test_motions_are_counted_by_kind_and_trouble_and_where_no_exponent_is_known():
    resting = Made(resting=True, theta=[1.0])
    motions = [
        motion(), motion("P(1;inf)", orbit=resting), motion("P(2;2)", orbit=None, exponents=None),
        motion("contact", orbit=Made(resting=True, theta=[])), motion("aperiodic", orbit=None),
        motion("undecided", orbit=None, exponents=None, status=Status.LOG_FULL),
        motion("undecided", orbit=None, exponents=None, status=Status.NO_RETURN),
        motion(exponents=None),
    ]  # fmt: skip
    assert classify.kinds_words(motions) == (
        "aperiodic (1); contact (1); periodic (2); periodic with rests (1); undecided (3); "
        "not ok: log-full (1); not ok: no-return (1); exponent not known for 4 of 8 motions"
    )
    assert [classify.rests(one) for one in motions[:4]] == [False, True, False, False]
    ends = [motion(value=0.25), motion(value=0.5), motion(value=0.75)]
    assert classify.range_text(ends, "restitution", "") == (
        "coefficient of restitution 0.25 to 0.75 at 600 rpm"
    )
    assert classify.motions_title(ends, "restitution", 1) == (
        "3 motions over restitution at 600 rpm, 1 range of one label"
    )


# --- basins, lift tables, drifts, the page


def test_the_share_of_cells_computed_counts_every_window():
    system = Made(strobe=radians(33.25))
    words = basins.window_words([speed(level=0, cells=25), speed(cells=75, computed=5)], system)
    assert words.endswith(", 25 % of the cells computed (boundaries refined)")
    grids = [speed(value=0.5, rpm=700.0), speed(value=0.25, rpm=650.0)]
    assert (
        basins.picture_title("Basins", grids, "mass") == "Basins, mass 0.25 to 0.50 kg at 700 rpm"
    )


def table(**more):
    """A table with a last digit of 10 um, of which a rounding is 2.8868 um rms."""
    own = {"quantum": 1e-5, "noise": 4e-6, "rms": 3e-6, "largest": 2e-5, "line": 17,
           "bends_between_rows": False, "spacing_deg": 4.0, "jump_deg": None}  # fmt: skip
    return Made(**{**own, **more})


def test_a_table_is_warned_of_by_its_rounding_and_its_noise():
    assert lift_table.cautions(table()) == []
    assert lift_table.cautions(table(noise=4.33e-6)) == []
    assert lift_table.cautions(table(noise=4.34e-6)) == [
        "warning: the table scatters by 4.34 um, 1.5 times the rounding of its digits"
    ]
    (said,) = lift_table.cautions(table(noise=8.66e-6, bends_between_rows=True))
    assert said.startswith("warning: the rows are 4 deg apart, too far for this cam: ")
    assert "is off by 8.66 um, 3 times the rounding of its digits" in said
    assert lift_table.cautions(table(largest=2.39e-5)) == []
    assert lift_table.cautions(table(largest=2.8e-5)) == [
        "warning: line 17 of the table is 28 um off the cam, 7 times the noise of the rows"
    ]


def test_a_drift_has_its_share_of_what_the_reference_says():
    def line(reference, found, by, portability=False, chaotic=False):
        drift = Made(figure="fig-3", name="rpm", reference=reference, found=found, by=by,
                     portability=portability)  # fmt: skip
        return figures.drift_line(drift, chaotic)

    begin = "fig-3: rpm: reference "
    assert line(-4.0, 0.0, 4.0) == begin + "-4.0, found 0.0, off by 4 (1 of it)"
    assert line(-4.0, -5.0, -1.0) == begin + "-4.0, found -5.0, off by -1 (0.25 of it)"
    assert line(0.0, 0.5, 0.5) == begin + "0.0, found 0.5, off by 0.5"
    assert line(0, None, None) == begin + "0, found nothing"
    assert line(None, "a", None, True, True) == (
        f"fig-3: rpm (chaotic): reference nothing, found a: {figures.PORTABILITY}"
    )


def test_speeds_and_lengths_of_the_page_have_their_digits():
    own = explore.Machine("follower", "the spring", 0.5, valve=False)
    begin = "At 1234.57 rpm the follower "
    assert own.once_a_turn(1234.5678, "P(1;1)").startswith(begin)
    assert own.hard_landing(1234.5678, 2.0).startswith(begin)
    assert own.lash(1234.5678, 1.2346e-4, 1.0, 2.0).startswith(
        "At 1234.57 rpm the cam takes up the lash of 0.1235 mm and strikes the valve train at 1 m/s"
    )
    assert own.chaos(1234.5678).startswith("At 1234.57 rpm the motion never repeats")
    shares = [("P(1;1)", 0.5), ("P(2;2)", 0.25), ("P(3;3)", 0.12345)]
    assert explore.basin_shares(1234.5678, iter(shares)) == (
        "At 1234.5678 rpm: P(1;1) takes 50 %, P(2;2) takes 25 %, P(3;3) takes 12.3 % of the starts."
    )


# --- the machine


def test_a_solid_spring_a_heavy_mass_and_a_throw_without_an_end():
    """A spring is doubted where it is solid below the top; a mass where a spring presses it."""

    def told(solid_at=None, preload=0.0, stiffness=1000.0):
        follower = Made(mass=2.0, stiffness=stiffness, preload=preload)
        scene = Made(follower=follower, cam=Made(kind="law", lift=0.012, base=-0.002),
                     spring=Made(solid_at=solid_at, mass=None), contact=None,
                     detach=Made(hold_to=None), run=Made(rpm=None, crank=False))  # fmt: skip
        return [text.partition(" of ")[0] for text in machine.doubts(scene)]

    assert told(stiffness=3000.0) == []
    assert told() == ["warning: a mass"]  # 10 N press 19.62 N
    assert told(preload=-20.0) == ["warning: a preload"]  # the spring presses nowhere
    assert told(0.01, stiffness=3000.0) == []
    assert len(told(0.00999, stiffness=3000.0)) == 1
    for height, count in ((9.9, 0), (10.1, 1), (inf, 0)):
        assert len(machine.height_notes(Made(lift=0.01, height=height, rpm=700.0))) == count
