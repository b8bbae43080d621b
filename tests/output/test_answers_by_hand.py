"""The answer before any table, from results made by hand: limits, the other of two, the first."""

from __future__ import annotations

from math import nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.analysis.contact_loss.detachment import CriticalQuantity, Reason
from camcli.analysis.contact_loss.hold import Hold, HoldStatus
from camcli.analysis.surge import own_frequency
from camcli.words import verdict
from tests.output.test_phrases import machine, past

STIFFNESS, PRELOAD = CriticalQuantity.HOLD_STIFFNESS, CriticalQuantity.HOLD_PRELOAD


def test_of_several_losses_at_every_speed_the_first_is_told():
    force = Made(reason=Reason.FORCE, theta=radians(250.0))
    kink = Made(reason=Reason.KINK, theta=radians(20.0))
    why = "Contact is lost at every speed: the spring does not press even at standstill at 250 deg."
    assert verdict._answer(machine(), Made(always=[force, kink], first=None), None) == [why]
    why = "Contact is lost at every speed: the cam's slope drops at 20 deg."
    assert verdict._answer(machine(), Made(always=[kink, force], first=None), None) == [why]


def test_there_are_no_details_where_no_speed_marks_a_loss():
    first = Made(rpm=705.0, theta=1.0)
    surge = {"strong": [], "limit": 0.12, "frequency_hz": 412.0}
    result = machine(summary={"surge": surge})
    assert len(list(verdict._details(result, Made(always=[], first=first)))) == 1
    for contact in (None, Made(always=[], first=None), Made(always=[1], first=first)):
        assert list(verdict._details(result, contact)) == []
    result.command = "sweep"  # which tells of landings alone
    assert list(verdict._details(result, Made(always=[], first=first))) == []


def test_the_width_of_a_range_says_how_many_decimals_a_speed_has():
    """0.4 rpm wide, two decimals; the speed is much nearer to the lower end."""
    assert verdict._speed(3352.1234, 3352.12, 3352.52, 0.0) == (
        "3352.12 rpm of the cam; its table leaves 3352.12 to 3352.52 rpm"
    )


def test_a_harmonic_that_meets_the_spring_just_there_is_below_the_speed():
    strong = [{"harmonic": n, "rpm": rpm, "factor": 0.2} for n, rpm in ((5, 700.0), (6, 650.0))]
    result = Made(summary={"surge": {"strong": strong}})
    assert [one["harmonic"] for one in verdict._strong_below(result, 700.0)] == [6, 5]
    assert [one["harmonic"] for one in verdict._strong_below(result, 699.9)] == [6]
    summary = {"surge": {"mass_kg": 0.06, "limit": 0.12, "strong": [strong[1]]}}
    spring = Hold(STIFFNESS, HoldStatus.OK, 64_000.0, 1.0)
    meets = 60.0 * own_frequency(64_000.0, 0.06) / 6
    for hold_to, told in ((meets, "these harmonics"), (np.nextafter(meets, 0.0), "no harmonics")):
        scene = Made(detach=Made(hold_to=hold_to))
        (said,) = verdict._surge_of_springs(Made(scene=scene, summary=summary), [spring])
        assert told in said


def test_at_one_speed_the_hardest_landings_count_and_no_departure():
    """The seat lies below 90 deg, and only the first landing there is hard."""

    def told(rows, contact=("sticking", "flight"), has_seat=True):
        names = "theta_deg", "u_minus_m_per_s"
        events = {name: [row[k] for row in rows] for k, name in enumerate(names)}
        system = Made(has_seat=has_seat, lash=0.0, is_seat=lambda theta: theta < pi / 2)
        tables = {"events": events, "trajectory": {"contact": contact}}
        scene = Made(run=Made(rpm=700.25))
        return verdict._at_one_speed(Made(tables=tables, system=system, scene=scene), 0.0)

    begin = "At 700.25 rpm of the cam contact "
    rows = [(10.0, -0.5), (60.0, -0.25), (80.0, 0.0), (100.0, -0.75), (200.0, 0.875)]
    lands = begin + "is lost: the follower lands at up to 0.75 m/s"
    assert told(rows) == f"{lands}, on its seat at up to 0.5 m/s."
    assert told(rows, has_seat=False) == f"{lands}."
    assert told(rows[3:]) == f"{lands}, and never on its seat."
    lost = begin + "is lost: the follower does not land in the turns recorded."
    assert told([(80.0, 0.0)]) == told([(200.0, 0.875)]) == lost


def test_landings_past_a_loss_are_told_as_closely_as_the_speeds_of_the_run_stand():
    """At 705 rpm itself contact still holds: what is seen there is not past it."""
    rpm = {"rpm": [705.0, 710.25, 710.5, 735.75]}
    lands, _ = past(max_impact_m_per_s=[0.9, 0.1234, 0.0, 0.2], **rpm)
    assert lands[0].startswith("Past it, from 710.25 to 735.75 rpm, it ")
    falling, _ = past(rpm=[705.0, 735.75, 710.5, 710.25])
    assert falling[0].startswith("Past it, from 710.25 to 735.75 rpm, it ")
    (_, seated), (*_, bounces) = past(True, 1e-4, **rpm)
    assert seated == "It seats with up to 0.057 m/s (the ramp alone: 0.035)"
    assert bounces == "on its seat it bounces up to 0.0235 mm"
    empty = {name: [] for name in (
        "rpm", "max_impact_m_per_s", "landing_deg", "landing_lift_m", "max_gap_m",
        "shut_bounces_per_turn", "seat_velocity_m_per_s", "seat_ramp_velocity_m_per_s",
        "seat_bounce_height_m",
    )}  # fmt: skip
    assert past(True, **empty) == ([], [])
    never = [nan] * 4
    (_, seated), told = past(True, 1e-4, seat_velocity_m_per_s=never, seat_bounce_height_m=never)
    assert seated == "It never lands on its seat"
    assert len(told) == 1


@pytest.mark.parametrize(
    ("quantity", "status", "more", "holds"),
    [
        (PRELOAD, HoldStatus.OK, False, True),
        (PRELOAD, HoldStatus.NOT_NEEDED, False, True),
        (PRELOAD, HoldStatus.OK, True, False),
        (STIFFNESS, HoldStatus.OK, False, False),  # a softer one may need more preload
    ],
)
def test_the_present_spring_holds_where_less_preload_would_do(quantity, status, more, holds):
    others = [Hold(STIFFNESS, HoldStatus.OK, 9.0, 1.0, more=False)]
    hold = Hold(quantity, status, 36_000.0, 25.0, more=more)
    assert verdict._present_holds([*others, hold]) is holds
    result = machine(values=Made(holds=[hold], margin=2.5, springs=[]))
    result.scene.detach = Made(hold_to=4000.0)
    (said,) = verdict._springs(result, 3300.0)
    assert said.startswith("The present spring holds" if holds else "To hold up to 4000 rpm")


def test_each_spring_found_has_its_own_chance_among_machines_in_tolerance():
    """That without one is left out, wherever it stands."""
    summary = {
        "machines": 2000, "worst": {"follower.mass": 5.0}, "shares": {},
        "springs": {STIFFNESS: {"chance": 0.98765, "worst_rpm": 3987.654}},
    }  # fmt: skip
    holds = [Hold(PRELOAD, HoldStatus.OK, 36_000.0, 325.0),
             Hold(STIFFNESS, HoldStatus.OK, 45_000.0, 60.0)]  # fmt: skip
    result = machine(summary={"tolerance": summary}, values=Made(holds=holds))
    result.scene.detach = Made(tolerance=[], hold_to=4000.0)
    told = list(verdict._on_tolerances(result))
    assert told[-1].startswith("with a stiffer spring with the same preload 98.8 % of them hold")


def test_what_the_error_of_a_table_leaves_open_is_told_before_what_the_fitted_cam_does():
    work = {"rpm": 3500.5, "open": True, "least_force_n": 12.3456, "theta_deg": 196.816,
            "max_impact_m_per_s": 0.5, "landing_deg": 20.0, "landing_lift_m": 0.001}  # fmt: skip
    (said,) = verdict._at_work(machine(summary={"working": work}), 0.0)
    assert said.endswith("leaves open whether contact holds: on the fitted cam the least force is "
                         "12.3 N at 196.8 deg")  # fmt: skip


def test_every_answer_has_the_range_of_the_table_and_what_is_past_the_loss_itself(monkeypatch):
    """What comes first, springs, working speed and tolerances are told by `cam detach` alone."""
    asked = []
    for name, told in (
        ("_past_the_loss", "past"), ("_first_to_give", "first"), ("_at_work", "work"),
        ("_springs", "springs"), ("_tolerances", "tolerances"),
    ):  # fmt: skip

        def said(result, *more, told=told):
            asked.append((told, *more))
            return "first" if told == "first" else [told]

        monkeypatch.setattr(verdict, name, said)
    first = Made(rpm=700.25, theta=1.0)
    table = {"first_detachment_rpm": (690.0, 712.0)}
    contact = Made(always=[], first=first)
    holds = "Contact holds up to 700 rpm of the cam; its table leaves 690 to 712 rpm."
    result = machine(command="sweep", kind="table")
    assert verdict._answer(result, contact, table) == [holds, "past."]
    assert asked == [("past", 700.25)]
    result.command = "detach"
    assert verdict._answer(result, contact, table) == [
        holds, "first.", "past.", "work.", "springs.", "tolerances."
    ]  # fmt: skip
    assert asked[1:] == [
        ("first", first), ("past", 700.25), ("work", 0.0), ("springs", 700.25), ("tolerances",)
    ]  # fmt: skip
    assert verdict._answer(result, contact, None)[0] == "Contact holds up to 700.25 rpm of the cam."
