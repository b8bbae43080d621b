"""Sentences on results made by hand: both sides of a limit, each of several, one and two things."""

from __future__ import annotations

from math import inf, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.contact_loss.detachment import SpeedStatus
from camcli.analysis.contact_loss.hold import Hold, HoldStatus
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.errors import Status
from camcli.quantities import MILLIMETRES
from camcli.words import detach, orbits
from tests.output.test_phrases import of_orbits
from tests.output.test_whole_sentences import contact_loss, critical

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
