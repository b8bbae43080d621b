"""Whole sentences of results made by hand: what a word says is held as well as each number.

`test_sentences.py` looks at the numbers of long sentences; here stands the text that a user reads,
a case for each branch. Numbers are such that each rounds another way.
"""

from __future__ import annotations

from math import inf, pi, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.chaos.section import Chaos
from camcli.analysis.contact_loss.bursts import LiftOff, LiftOffKind
from camcli.analysis.contact_loss.detachment import (
    AlwaysLost,
    CriticalQuantity,
    Reason,
    SpeedStatus,
)
from camcli.analysis.contact_loss.hold import Hold, HoldStatus, Obstacle
from camcli.analysis.orbits.proofs import ProofStep
from camcli.analysis.throw import Throw
from camcli.errors import Status
from camcli.words import (
    bench,
    border_collision,
    chaos,
    cost,
    detach,
    explanations,
    figures,
    lift_table,
    machine,
    orbits,
    plan,
    simulate,
    statuses,
    sweep,
    tolerance,
    verdict,
)
from camcli.words.explore import Machine, basin_shares, page_line
from camcli.words.followed import why_not_followed
from camcli.words.surge import surge_words

STIFFNESS = CriticalQuantity.HOLD_STIFFNESS
PRELOAD = CriticalQuantity.HOLD_PRELOAD
BOTH = CriticalQuantity.HOLD_BOTH


def critical(rpm=700.25, low=700.25, high=700.25, **more):
    own = {"rpm": rpm, "low": low, "high": high, "region": "A2", "theta": radians(123.5),
           "status": SpeedStatus.OK, "quantity": "detachment"}  # fmt: skip
    return Made(**{**own, **more})


def contact_loss(first=None, rpms=(650.0, 660.5), **more):
    loss = {"always": [], "never": False, "first": first, "losses": []}
    loss |= {key: more.pop(key) for key in list(more) if key in loss}
    own = {"detachment": Made(**loss), "speeds": [Made(rpm=rpm) for rpm in rpms], "holds": [],
           "lift_offs": [], "ended": [], "jumps": [], "critical_speeds": [],
           "completion": []}  # fmt: skip
    return Made(**{**own, **more})


# --- cam detach


@pytest.mark.parametrize(
    ("result", "said"),
    [
        (contact_loss(never=True),
         "contact is never lost: the contact force stays positive at every speed"),
        (contact_loss(critical()),
         "contact is held at every speed asked for, up to 660.5 rpm"),
        (contact_loss(critical(rpm=700.25, low=655.0, high=720.0)),
         "on the fitted cam contact is held at every speed asked for, up to 660.5 rpm; the error "
         "of its table leaves that open (655 to 720 rpm)"),
        (contact_loss(critical(), rpms=(710.0, 720.0)),
         "contact is lost at every speed asked for, 710 rpm and above"),
        (contact_loss(critical(rpm=700.25, low=655.0, high=715.0), rpms=(710.0, 720.0)),
         "on the fitted cam contact is lost at every speed asked for, 710 rpm and above; the error "
         "of its table leaves that open (655 to 715 rpm)"),
        (contact_loss(critical(rpm=700.25, low=655.0, high=705.0), rpms=(710.0, 720.0)),
         "contact is lost at every speed asked for, 710 rpm and above"),
        (contact_loss(critical(), rpms=(710.0,)),
         "contact is lost at every speed asked for, 710 rpm"),
        (contact_loss(always=[AlwaysLost(Reason.KINK, radians(30.0), 0.0125)]),
         "contact is lost at every speed: the cam's slope drops by 0.0125 m/rad at 30 deg and "
         "throws the follower off"),
        (contact_loss(always=[AlwaysLost(Reason.FORCE, radians(30.0), -4.5)]),
         "contact is not held even at standstill: the contact force is -4.5 N at 30 deg; give the "
         "follower more preload or weight"),
        (contact_loss(always=[AlwaysLost(Reason.FORCE, radians(30.0), 0.0)]),
         "contact is not held even at standstill: the contact force is zero at 30 deg; give the "
         "follower a preload, weight or a spring"),
        (contact_loss(critical(655.0), holds=[Hold(BOTH, HoldStatus.NOT_NEEDED),
                                              Hold(PRELOAD, HoldStatus.OK, 1.0, 2.0)]),
         "another spring: no spring is needed"),
    ],
)  # fmt: skip
def test_contact_always_or_never_lost(result, said):
    assert detach.plainly(result) == [said]


def lift_off(kind, landing=inf, rest=inf, corner="b"):
    """Released at 110 deg, 13.5 deg before the region opens; inf: not seen."""
    ends = (radians(x) if x < inf else inf for x in (110.0, landing, rest))
    return LiftOff("A2", kind, corner, 700.5, *ends)


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (lift_off(LiftOffKind.FLIES_OFF, 143.5),
         "the follower flies off at b, where the force drops: it lands 20 deg after b"),
        (lift_off(LiftOffKind.CAUGHT, 143.5, 183.5),
         "the follower is released 13.5 deg before b, where the force fades: it lands 20 deg after "
         "b, and rests again 60 deg after it"),
        (lift_off(LiftOffKind.WITHIN, 143.5, 183.5, corner=""),
         "the follower is released 13.5 deg before the weakest phase: it lands 20 deg after that "
         "phase, and rests again 60 deg after it"),
        (lift_off(LiftOffKind.FLIES_OFF),
         "the follower flies off at b, where the force drops: it does not land within two turns"),
        (lift_off(LiftOffKind.UNSEEN),
         "no lift-off was seen: contact is lost at no phase after a rest"),
    ],
)  # fmt: skip
def test_how_the_follower_is_released(one, said):
    """At 700.5 rpm, where the region A2 has opened at 123.5 deg and A3 never does."""
    opens = [Made(region=Made(name="A2"), opens=Made(rpm=700.25, theta=radians(123.5))),
             Made(region=Made(name="A3"), opens=Made(rpm=inf, theta=0.0)),
             Made(region=Made(name="A4"), opens=Made(rpm=inf, theta=0.0))]  # fmt: skip
    found = contact_loss(critical(), losses=opens, lift_offs=[one])
    assert detach.theory(found) == [
        "contact is never lost in A3, A4, at any speed",
        f"at 700.5 rpm, a little above the opening of A2, {said}",
    ]


def test_how_the_ends_of_bursts_change_with_the_speed():
    hit = Made(rpm=345.25, impact=3, burst="A2", corner="c", ends=(radians(211.5), radians(244.25)))
    jump = Made(rpm=350.5, burst="A4", region="A1")
    said = detach.theory(contact_loss(ended=[hit], jumps=[jump]))
    assert said == [
        "at 345.25 rpm impact 3 of the burst from A2 vanishes before it reaches c: it was at "
        "211.5 deg, and the next contact is at 244.25 deg",
        "at 350.5 rpm the end of the burst from A4 jumps over A1",
    ]
    speeds = [critical(status=SpeedStatus.UNRESOLVED, quantity="completion"), critical()]
    assert detach.unresolved_notes(contact_loss(critical_speeds=speeds)) == [
        "unresolved: completion A2 near 700.25 rpm has no safe bracket"
    ]


def no_spring(quantity, obstacle):
    return Hold(quantity, HoldStatus.IMPOSSIBLE, theta=radians(123.5), obstacle=obstacle,
                missing_n=321.5)  # fmt: skip


@pytest.mark.parametrize(
    ("hold", "said"),
    [
        (Hold(STIFFNESS, HoldStatus.OK, 1234.5, 60.25), "stiffness 1234.5 N/m, preload as it is"),
        (Hold(PRELOAD, HoldStatus.OK, 1234.5, 60.25), "preload 60.25 N, stiffness as it is"),
        (Hold(BOTH, HoldStatus.OK, 1234.5, 60.25), "stiffness 1234.5 N/m and preload 60.25 N"),
        (Hold(STIFFNESS, HoldStatus.NOT_NEEDED), "no stiffness is needed"),
        (Hold(BOTH, HoldStatus.ABSURD, nose_n=54321.0),
         "absurd: 5.432e+04 N at the highest lift, over 20 times the present spring's; is the "
         "speed of --hold-to right?"),
        (no_spring(BOTH, Obstacle.KINK),
         "impossible: at a downward kink the cam throws the follower off at any speed"),
        (no_spring(STIFFNESS, Obstacle.LIFT),
         "impossible with stiffness alone: 321.5 N are missing at 123.5 deg, where the cam's "
         "height is 0 or less and a spring does not press; take more preload"),
        (no_spring(BOTH, Obstacle.PULL),
         "impossible: the spring would pull at 123.5 deg, where c + precompression <= 0; raise "
         "detach.precompression_m"),
    ],
)  # fmt: skip
def test_a_spring_or_why_there_is_none(hold, said):
    assert detach.spring(hold) == said


@pytest.mark.parametrize(
    ("hold", "said", "short"),
    [
        (Hold(STIFFNESS, HoldStatus.OK, more=True),
         "a stiffer spring with the same preload", "stiffer spring"),
        (Hold(STIFFNESS, HoldStatus.OK, more=False),
         "a softer spring with the same preload", "softer spring"),
        (Hold(PRELOAD, HoldStatus.OK, more=True),
         "more preload on the same spring", "more preload"),
        (Hold(PRELOAD, HoldStatus.OK, more=False),
         "less preload on the same spring", "less preload"),
        (Hold(PRELOAD, HoldStatus.NOT_NEEDED), "the same spring without preload", "no preload"),
        (Hold(BOTH, HoldStatus.OK), "another spring", "another spring"),
    ],
)  # fmt: skip
def test_what_is_done_about_a_spring(hold, said, short):
    assert (detach.way(hold), detach.short_way(hold)) == (said, short)


def test_titles_of_a_loss_of_contact():
    assert detach.picture_title(contact_loss()) == "Detachment and chattering, 650.0 to 660.5 rpm"
    assert detach.picture_title(contact_loss(rpms=(650.0,))) == "Detachment and chattering, 650 rpm"
    found = contact_loss(critical(700.123456789, 690.0, 710.0), completion=[Made(rpm=345.67891)])
    assert detach.first_loss(found, measured=False) == (
        "contact is first lost at 700.123456789 rpm, 123.5 deg; chatter stops being complete at "
        "345.6789 rpm"
    )
    assert detach.first_loss(found, measured=True) == (
        "contact is first lost at 700.1 rpm, 123.5 deg (690 to 710 rpm by the error of the table); "
        "chatter stops being complete at 345.6789 rpm"
    )
    assert detach.first_loss(contact_loss(never=True), False) == "contact is never lost"
    assert detach.first_loss(contact_loss(), False) == "contact is lost at every speed"
    curve = Made(rpm=1234.567, lowest_n=-12.345, lowest_theta=radians(77.125))
    assert detach.force_name(curve, False) == "1234.57 rpm: least −12.35 N at 77.12 deg"
    assert detach.force_name(curve, True) == "1235 rpm: least −12.35 N at 77.12 deg"


# --- the machine


def doubted(cam=None, spring=None, contact=None, hold_to=None, rpm=None, **follower):
    own = {"mass": 0.1, "stiffness": 5000.0, "preload": 100.0}
    plain = Made(kind="law", lift=0.01, base=0.0)
    return list(machine.doubts(Made(
        follower=Made(**{**own, **follower}), cam=cam or plain, spring=spring,
        contact=contact, detach=Made(hold_to=hold_to), run=Made(rpm=rpm, crank=False),
    )))  # fmt: skip


def test_what_of_a_machine_is_probably_a_wrong_unit():
    assert doubted() == []
    assert doubted(cam=Made(kind="law", lift=9.25, base=0.0)) == [
        "warning: a lift of 9250 mm; is it in m, or is cam.lift the file's unit?"
    ]
    radii = Made(kind="table", measured=Made(lift=[0.0155, 0.025]), metres=1e-3, subtract=0.5,
                 base=0.0)  # fmt: skip
    assert doubted(cam=radii) == [
        "warning: the smallest lift of the table is 15.5 mm; if these are radii, write subtract: 16"
    ]
    assert doubted(cam=Made(kind="law", lift=0.01, base=0.0, base_radius=17.5)) == [
        "warning: a base radius of 17.5 m; is it in m?"
    ]
    assert doubted(spring=Made(solid_at=0.00925, mass=None)) == [
        "warning: the spring is solid at 9.25 mm, below the highest lift"
    ]
    assert doubted(preload=-12.5) == [
        "warning: a preload of -12.5 N pulls the follower off the cam at q = 0; a positive one "
        "presses"
    ]
    assert doubted(stiffness=25.0) == [
        "warning: a stiffness of 25 N/m adds 0.25 N over the lift to a preload of 100 N; is it in "
        "N/m?"
    ]
    assert doubted(mass=85.0) == [
        "warning: a mass of 85 kg weighs more than the 150 N of the spring at the highest lift; is "
        "it in kg?"
    ]
    assert doubted(spring=Made(mass=0.225)) == [
        "note: moving mass: 0.025 + 0.075 kg, a third of the spring",
        "warning: a spring of 0.225 kg is heavier than the 0.025 kg that it moves; is it in kg?",
    ]
    assert doubted(contact=Made(width=12.5)) == ["warning: a contact width of 12.5 m; is it in m?"]
    crank = Made(kind="law", lift=0.01, base=0.0, angle="crank")
    assert doubted(cam=crank, hold_to=6000.0, rpm=3000.0) == [
        "note: hold_to is 6000 rpm of the cam (12000 of the crank), twice run.rpm: was the crank "
        "meant?"
    ]


def test_what_a_machine_may_do_that_no_model_holds_for():
    assert machine.height_notes(Throw(9000.5, 12.5, 0.01)) == [
        "warning: at 9000.5 rpm the cam throws the follower 12.5 m up, 1.25e+03 times its lift: a "
        "model of rigid bodies means little there"
    ]
    scene = Made(follower=Made(restitution=1.0, damping=0.0))
    assert machine.lossless_notes(scene) == [
        "warning: restitution 1 and no damping: nothing dissipates, so no orbit attracts another"
    ]
    assert machine.report_title(Made(kind="eccentric")) == (
        "Contact of cam and follower: eccentric"
    )


def test_stops_of_the_page():
    plain = Machine("follower", "its weight", 0.75, valve=False)
    engine = Machine("valve train", "the spring", 0.5, valve=True)
    assert plain.contact(700.25) == (
        "At 700.2 rpm its weight keeps the follower on the cam all the way round: the push of the "
        "contact never comes to an end."
    )
    assert engine.lift_off(3400.5, 3352.123, "b") == (
        "Above 3352.12 rpm the cam turns away faster than the spring can push: at 3400 rpm the "
        "valve floats from b on; the contact arrow goes."
    )
    assert " (valve" not in plain.lift_off(1.0, 1.0, "b") + plain.chatter(1.0)
    assert engine.chatter(190.25) == (
        "At 190.2 rpm the valve train lands and bounces (valve bounce), each time 0.5 times as "
        "fast: infinitely often in a finite time, then it rests."
    )
    assert plain.corner_impact(673.123456, "P(2;inf:1)", "c") == (
        "At 673.1235 rpm the impact of P(2;∞:1) falls on corner c, where the cam's curvature "
        "jumps: there the motion changes at once, not little by little."
    )
    assert plain.doubling(739.31978, "P(1;inf)", "P(2;inf:inf)", 740.1234567) == (
        "At 739.3198 rpm P(1;∞) becomes unstable and its period doubles: at 740.123 rpm it is "
        "P(2;∞:∞), each turn unlike the one before."
    )
    assert plain.chaos(745.1234) == (
        "At 745.123 rpm the motion never repeats, though nothing is left to chance: two starts a "
        "hair apart soon have nothing in common."
    )
    assert plain.two_motions(355.5, "contact", "aperiodic") == (
        "At 355.5 rpm the same machine runs in two ways, always on the cam or chaos: how it was "
        "started settles which; the buttons below switch."
    )
    ball = Machine("ball", "its weight", 0.5, valve=False, cam="table")
    assert "two ways, always on the table or P(1;1):" in ball.two_motions(950, "contact", "P(1;1)")
    assert basin_shares(358.5, [("contact", 0.12345), ("P(1;1)", 0.5)]) == (
        "At 358.5 rpm: contact takes 12.3 %, P(1;1) takes 50 % of the starts."
    )
    assert page_line(2, 1, 3, written=True) == (
        "2 motions at 1 speed, 3 bifurcations of solved branches; open explore.html in a browser"
    )
    assert "open" not in page_line(2, 1, 3, written=False)


# --- measured cams


def accuracy(**more):
    """Rows rounded to 1 um: their rounding scatters by 1/sqrt(12) um."""
    own = {"rows": 181, "lift": 0.0123456, "quantum": 1e-6, "rms": 0.4e-6, "largest": 1.1e-6,
           "line": 77, "length_deg": 12.34, "noise": 0.3e-6, "bends_between_rows": False,
           "spacing_deg": 2.0, "jump_deg": None, "jump_of": "c_theta", "jump": 0.0125,
           "jump_error": 0.0003, "jump_sure": 8.25, "bound": 0.0025}  # fmt: skip
    return Made(**{**own, **more})


def test_what_a_lift_table_is_worth():
    assert lift_table.fit_line(accuracy(), "a.csv") == (
        "a.csv: 181 rows, lift 12.346 mm, last digit 1 um; the cam is within 0.4 um rms, 1.1 um "
        "at most (line 77), smoothed over 12 deg"
    )
    assert lift_table.cautions(accuracy()) == []
    assert lift_table.cautions(accuracy(noise=2e-6)) == [
        "warning: the table scatters by 2 um, 6.93 times the rounding of its digits"
    ]
    assert lift_table.cautions(accuracy(noise=2e-6, bends_between_rows=True)) == [
        "warning: the rows are 2 deg apart, too far for this cam: the lift bends between them, and "
        "the smooth cam is off by 2 um, 6.93 times the rounding of its digits; give more rows"
    ]
    assert lift_table.cautions(accuracy(largest=3e-6)) == [
        "warning: line 77 of the table is 3 um off the cam, 10 times the noise of the rows"
    ]
    for name, unit in (("c_theta", "m/rad"), ("c_thetatheta", "m/rad2")):
        assert lift_table.cautions(accuracy(jump_deg=40.5, jump_of=name)) == [
            f"warning: {name} seems to jump near 40.5 deg, by 0.013 +- 0.0003 {unit}; a change "
            "over 4 deg or more fits the rows worse, by 8.2 standard errors; the smooth cam only "
            "approaches a jump"
        ]
    record = {"bound": 0.0025, "accel": 0.05, "standard": 0.0005, "bending": 0.00075,
              "worst": 0.0125, "first_detachment_rpm": [3300.25, None]}  # fmt: skip
    said = (
        "the fit's second derivative is off by an estimated 0.0025 m/rad2 at most, 5 % of its "
        "largest (standard error of its noise 0.0005, smoothing 0.00075; with every digit at its "
        "worst 0.013); "
    )
    assert lift_table.bound_line(record).startswith(said + "first detachment at ")
    record["first_detachment_rpm"] = [None, None]
    assert lift_table.bound_line(record) == said + "contact is never lost"


# --- proofs, orbits, benches, costs


def test_what_is_proved_of_chaos():
    boxes = tuple(Made(lands=Made(turn=turn)) for turn in (0, 1, 2, 1, 0))
    found = Chaos(745.5, "P(1;1)", boxes, ((0, 1),) * 7, growth=2.0)
    said = list(chaos.chaos_sentences(found))
    assert said[0] == (
        "proved: chaos at 745.5 rpm and every value that rounds to it: there are 5 boxes of "
        "impacts about P(1;1) and along a chain of impacts that leaves it and comes back, and 7 "
        "pairs of them in which one covers the other (chaos.csv); for every sequence of boxes in "
        "which each covers the next there is a motion whose impacts lie in them in turn, a "
        "periodic one where the sequence is periodic"
    )
    # log 2 = 0.693147; half of it is 0.346573, and 745.5/60 of that 4.30617
    assert said[1] == (
        "so there are infinitely many periodic orbits, and the topological entropy is at least "
        "log(2.0), above 0.6931 per impact, 0.3465 per turn and 4.3061 per second"
    )
    assert said[2] == (
        "this does not say that the attractor is chaotic, nor that a start chosen at random ever "
        "follows one of these motions"
    )
    failed = Chaos(745.5, step=ProofStep.COVERING)
    assert list(chaos.chaos_sentences(failed)) == [
        "not proved: chaos at 745.5 rpm: a box was not shown to be mapped over another one"
    ]
    assert chaos.chaos_title(found) == "Chaos proved at 745.5 rpm"
    assert chaos.chaos_title(failed) == "Chaos not proved at 745.5 rpm"
    assert chaos.chaos_caption(failed) == ""
    assert chaos.chaos_caption(found) == (
        "5 boxes of impacts, of which 7 pairs cover one another: the topological entropy is at "
        "least 0.3465 per turn"
    )


def test_branches_that_were_lost_and_curves_that_were_not_found():
    points = (Made(value=701.25), Made(value=703.75))
    branch = Made(number=4, ends=(Made(), orbits.Kind.LOST), points=points)
    found = Made(bifurcations=[], branches=[branch], curves=[], every=None, chaos=None,
                 question=Made(curve="fold"))  # fmt: skip
    assert orbits.notes(found) == [
        "branch 4 could not be followed beyond 703.75, where it is unresolved",
        "no fold was located, so there is no curve to continue",
    ]
    found = Made(**{**vars(found), "branches": [], "question": Made(curve=None)})
    found.chaos = Made(step=None)  # proved
    assert orbits.notes(found) == []
    found.chaos = Made(step=ProofStep.NO_CHAIN)
    assert [note.partition(": ")[0] for note in orbits.notes(found)] == [
        "it is not proved that there is chaos"
    ]
    assert orbits.orbits_title(Made(question=Made(rpm=701.25))) == "Periodic orbits at 701.25 rpm"
    driven = orbits.orbits_title(Made(question=Made(rpm=0.8 * 30.0 / pi)), "oscillator")
    assert driven == "Periodic orbits at frequency 0.8 rad/s"
    curve = Made(kind="corner-impact", label="P(2;1:1)", corner="b")
    assert orbits.curve_title(2, curve) == "Curve 2: corner-impact of P(2;1:1) at b"
    curve = Made(kind="fold", label="P(2;1:1)", corner="")
    assert orbits.curve_title(2, curve) == "Curve 2: fold of P(2;1:1)"


def test_what_a_bench_found_otherwise():
    bad = Made(case="chatter", setting="rtol 1e-9", status="missed", error=0.0123, of_bound=12.345,
               missed=3)  # fmt: skip
    assert bench.precision_notes([bad]) == [
        "chatter, rtol 1e-9: missed: error 0.012 turns, 12.3 times its bound at most, 3 impacts "
        "missed"
    ]
    assert bench.stability_notes([Made(case="r = 1", expected="a rest", observed="none")]) == [
        "row r = 1: expected a rest, but: none"
    ]
    off = Made(problem="ball", quantity="speed", published="1.25", ours=1.5, difference=-0.25,
               bound=0.005, status="failed")  # fmt: skip
    assert bench.validation_notes([off]) == [
        "ball, speed: published 1.25, but ours is 1.5, 0.25 off where 0.005 is allowed"
    ]
    misprint = Made(problem="cam", status=bench.MISPRINT)
    assert bench.validation_title([off, off, misprint], 0) == (
        "3 published numbers of 2 problems, all reproduced, 1 less exact than printed"
    )
    assert bench.validation_title([off], 1) == "1 published number of 1 problem, 1 not reproduced"
    assert [bench.in_seconds(x) for x in (1.26, 0.0123, 1.27e-5)] == ["1.3 s", "12 ms", "13 µs"]
    assert bench.cases_title(4, 0) == "4 extreme cases, all as expected"
    assert bench.cases_title(4, 1) == "4 extreme cases, 1 not as expected"


def test_what_a_run_cost():
    costs = {"impacts": 400, "seconds": 1.2345, "impacts_per_s": 324.0, "pieces_from_disk": 0,
             "gap_evaluations": 5000}  # fmt: skip
    errors = {"contact_gap_m": 2.4e-16, "accumulation_phase_turns": 1e-9}
    assert cost.cost_line(costs, errors) == (
        "400 impacts in 1.23 s (324/s, 12 gap evaluations each); error of each event: contact "
        "within 2e-16 m, end of a chatter within 1e-09 turn"
    )
    kept = cost.cost_line({**costs, "pieces_from_disk": 3}, {**errors, "lift_table": {"rms": 4e-7}})
    assert kept == (
        "400 impacts, 3 pieces from disk, this run took 1.23 s (12 gap evaluations each); error of "
        "each event: contact within 2e-16 m of the fitted cam, which is within 0.4 um rms of its "
        "measured table, end of a chatter within 1e-09 turn"
    )
    from_disk = {**costs, "pieces_from_disk": 3, "impacts_per_s": None}  # not known
    assert cost.cost_line(from_disk, {**errors, "lift_table": {"rms": 4e-7}}) == kept
    for impacts, count, words in ((400, 399, "1 gap evaluation each"),
                                  (400, 404, "1 gap evaluation each"),
                                  (400, 440, "1.1 gap evaluations each"),
                                  (2, 5, "2.5 gap evaluations each"),
                                  (0, 7, "7 gap evaluations each")):  # fmt: skip
        some = {**costs, "impacts": impacts, "gap_evaluations": count}
        assert f"/s, {words})" in cost.cost_line(some, errors)


def test_what_figures_say_of_their_reference():
    assert figures.drift_verdict(0, 3, 0) == "every number is the reference's"
    assert figures.drift_verdict(2, 1, 0) == "2 numbers drifted in 1 figure"
    assert figures.drift_verdict(2, 2, 2) == (
        "2 numbers drifted in 2 figures: portability broke: only chaotic motions and last bits "
        "differ"
    )
    assert figures.drift_verdict(3, 2, 1) == (
        "3 numbers drifted in 2 figures, 1 of them where bits should agree on every machine "
        "(portability broke)"
    )
    assert figures.drift_verdict(0, 0, 0, 2) == (
        "2 figures have no reference to compare with: --update-reference makes one"
    )
    assert figures.more_drifts("1.2a", 4) == "1.2a: and 4 more (--json has all of them)"
    assert figures.computed_line("page", 2, 3, 1.2345) == "page: 2 of 3 figures computed in 1.23 s"
    assert figures.caption_lacks("x") == "(The caption names x, which this run does not have.)"


def test_bursts_have_their_region_and_their_end():
    bursts = [Made(region="A2", end=1.0), Made(region="A4", end=None), Made(region="", end=pi)]
    told = detach.bursts_text(Made(status=Status.OK, bursts=bursts))
    assert told == "A2 complete, A4 incomplete, complete"
    assert detach.bursts_text(Made(status=Status.OK, bursts=[])) == "none"
    assert detach.bursts_text(Made(status=Status.UNRESOLVED, bursts=bursts)) == (
        Status.UNRESOLVED.text
    )


# --- the verdict


def seated(*events, at=3000.5):
    """A follower with lash whose seat is below 90 deg; events: (kind, angle, before, after)."""
    names = "event", "theta_deg", "u_minus_m_per_s", "u_plus_m_per_s"
    table = {name: [event[k] for event in events] for k, name in enumerate(names)}
    system = Made(is_seat=lambda theta: theta < pi / 2, has_seat=True, lash=1e-4)
    scene = Made(run=Made(rpm=at))
    result = Made(command="simulate", tables={"events": table}, system=system, scene=scene)
    return verdict._at_one_speed(result, 2.0)


def test_what_a_follower_with_lash_does_at_one_speed():
    """The hardest impact on the seat and on the lobe, whatever comes after it."""
    begin = "At 3000.5 rpm of the cam (6001 of the crank) the follower "
    assert seated() == begin + "lands neither on lobe nor seat in the turns recorded."
    on_seat = [("impact", 10.0, -0.25, 0.1), ("impact", 20.0, -0.05, 0.02)]
    assert seated(*on_seat) == begin + (
        "bounces on the lobe and never rests on it: the lobe hits it with up to 0 m/s, and it "
        "comes to its seat with up to 0.25 m/s."
    )
    on_lobe = [("impact", 100.0, -0.75, 0.4), ("impact", 110.0, -0.5, 0.0)]
    assert seated(*on_lobe) == begin + (
        "keeps to the lobe once that has hit it: the lobe hits it with up to 0.75 m/s, and it does "
        "not come to its seat."
    )
    assert "keeps to the lobe" in seated(on_lobe[0], ("chatter", 120.0, -0.01, 0.0))
    assert seated(*on_seat, *on_lobe, ("detachment", 130.0, 0.0, 0.0)) == begin + (
        "leaves the lobe: the lobe hits it with up to 0.75 m/s, and it comes to its seat with up "
        "to 0.25 m/s."
    )


def test_what_a_follower_without_lash_does_at_one_speed():
    def told(u, contact=("sticking",), has_seat=False):
        events = {"u_minus_m_per_s": u, "theta_deg": [10.0] * len(u)}
        tables = {"events": events, "trajectory": {"contact": contact}}
        system = Made(has_seat=has_seat, lash=0.0, is_seat=lambda theta: True)
        scene = Made(run=Made(rpm=700.25))
        return verdict._at_one_speed(Made(tables=tables, system=system, scene=scene), 0.0)

    begin = "At 700.25 rpm of the cam contact "
    assert told([]) == begin + "holds in the turns recorded."
    assert told([0.0], ("flight",)) == (
        begin + "is lost: the follower does not land in the turns recorded."
    )
    assert told([0.0, -0.75, -0.25]) == begin + "is lost: the follower lands at up to 0.75 m/s."
    assert told([-0.75], has_seat=True) == (
        begin + "is lost: the follower lands at up to 0.75 m/s, on its seat at up to 0.75 m/s."
    )
    alone = Made(tables={}, scene=Made(run=Made(rpm=700.25)))
    assert verdict._at_one_speed(alone, 0.0) == (
        "This is the cam alone, with the contact force at 700.25 rpm of the cam."
    )


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ((None, None), "3352.12 rpm of the cam (6704.25 of the crank)"),
        ((3333.0, 3378.0),
         "3352 rpm of the cam (6704 of the crank); its table leaves 3333 to 3378 rpm"),
        ((3333.0, None), "3352.12 rpm of the cam (6704.25 of the crank); its table leaves from "
                         "3333 rpm on, or never"),
    ],
)  # fmt: skip
def test_a_speed_has_the_range_that_its_table_leaves(ends, said):
    assert verdict._speed(3352.123, *ends, 2.0) == said


@pytest.mark.parametrize(
    ("lift", "preload", "stiffness", "told"),
    [
        (0.0299, 60.0, 5000.0, "valve train"),
        (0.03, 60.0, 5000.0, "follower"),
        (0.0299, 0.0, 5000.0, "follower"),
        (0.0299, 60.0, 0.0, "follower"),
    ],
)
def test_a_machine_is_a_valve_train_by_its_lift_and_its_spring(lift, preload, stiffness, told):
    """The lift is counted from the lowest place, wherever that is."""
    follower = Made(preload=preload, stiffness=stiffness, gravity=9.81, restitution=0.5)
    system = Made(cam=Made(stretches=[Made(start_c=c) for c in (0.5, 0.5 + lift)]))
    if lift == 0.03:
        system = Made(cam=Made(stretches=[Made(start_c=c) for c in (0.0, lift)]))
    scene = Made(follower=follower, cam=Made(kind="law"), run=Made(crank=False))
    found = Machine.of(scene, system)
    assert found.follower == told
    assert found.pull == ("the spring" if stiffness else "its weight")
    follower.gravity = 0.0
    if not stiffness:
        assert Machine.of(scene, system).pull == "the preload"


# --- surge, tolerances, plans, sweeps, records


NO_SURGE = (
    "surge itself is not simulated, and that the limit counts in inches is inferred, not published"
)


def harmonic(number, rpm, factor):
    return Made(number=number, rpm=rpm, factor=factor)


def test_harmonics_that_meet_the_spring():
    """The slowest of those over the limit, and the strongest where that is another one."""
    two = [harmonic(9, 2500.4, 0.125), harmonic(7, 3200.4, 0.325)]

    def told(strong, holds_to):
        asked = []
        found = Made(hertz=412.345, strong_below=lambda top: asked.append(top) or strong)
        (said,) = surge_words(found, holds_to)
        return said, asked[0]

    own = "The spring's own frequency is 412.3 Hz: "
    assert told([], 3352.1) == (
        own + f"no harmonic of the cam over 0.12 meets it below 3352 rpm; {NO_SURGE}",
        3352.1,
    )
    assert told([], None) == (
        own + f"no harmonic of the cam over 0.12 meets it; {NO_SURGE}", inf
    )  # fmt: skip
    rest = f", over the usual 0.12: there the spring surges and presses less; {NO_SURGE}"
    assert told(two[1:], None)[0] == own + "harmonic 7 meets it at 3200 rpm with 0.33" + rest
    assert told(two, None)[0] == (
        own + "harmonic 9 meets it at 2500 rpm with 0.12, harmonic 7 at 3200 rpm with 0.33" + rest
    )


def test_what_gives_first():
    first = Made(rpm=3300.0, theta=radians(196.816))
    place = "at 196.8 deg it presses too little"
    strong = [{"harmonic": 7, "rpm": 3200.4, "factor": 0.325},
              {"harmonic": 9, "rpm": 2500.4, "factor": 0.129},
              {"harmonic": 5, "rpm": 4400.0, "factor": 0.95}]  # fmt: skip

    def told(*some):
        surge = {"frequency_hz": 412.345, "limit": 0.12, "strong": list(some)}
        result = Made(summary={"surge": surge}, scene=pressed_by(stiffness=1430.8))
        return [verdict._first_to_give(result, first), *verdict._on_surge(result, first)]

    def pressed_by(stiffness=0.0, preload=0.0):
        return Made(follower=Made(stiffness=stiffness, preload=preload))

    silent = Made(summary={}, scene=pressed_by(preload=50.0))
    assert verdict._first_to_give(silent, first) == f"What gives first is the spring: {place}"
    fallen = Made(summary={}, scene=pressed_by())
    assert verdict._first_to_give(fallen, first) == f"What gives first is the weight: {place}"
    assert not list(verdict._on_surge(silent, first))
    assert told(strong[2]) == [
        f"What gives first is the spring: {place}",
        f"no harmonic of the cam over 0.12 meets the spring's 412 Hz below that speed; {NO_SURGE}",
    ]
    begin = "What gives first may be surge, which is not simulated: harmonic"
    without = (
        "surge is not simulated, and that the limit counts in inches is inferred, not published; "
        f"without surge the spring gives: {place}"
    )
    assert told(strong[1], strong[2]) == [
        f"{begin} 9 at 2500 rpm",
        "harmonic 9 meets the spring's 412 Hz at 2500 rpm with a factor of 0.13, over the usual "
        "0.12",
        without,
    ]
    assert told(*strong) == [
        f"{begin} 7 at 3200 rpm",
        "2 harmonics of the cam over the usual 0.12 meet the spring's 412 Hz below that speed, "
        "from 2500 rpm; the strongest is 7, at 3200 rpm with a factor of 0.33",
        without,
    ]


def test_which_harmonics_meet_the_springs_that_would_hold():
    """Of 60 g: 36 N/mm have 387.298 Hz, 23238 rpm of harmonic 1; 64 N/mm have 30984 rpm."""
    strong = [{"harmonic": n, "rpm": 0.0, "factor": 0.2} for n in (8, 9, 5)]
    scene = Made(detach=Made(hold_to=2910.0))
    summary = {"surge": {"mass_kg": 0.06, "limit": 0.12, "strong": strong}}
    holds = [Hold(STIFFNESS, HoldStatus.OK, 64_000.0, 1.0),
             Hold(PRELOAD, HoldStatus.OK, 36_000.0, 2.0)]  # fmt: skip
    assert list(verdict._surge_of_springs(Made(scene=scene, summary=summary), holds)) == [
        "stiffer spring: up to 2910 rpm no harmonics over 0.12 meet it, if it is as heavy as the "
        "present spring",
        "more preload: up to 2910 rpm these harmonics over 0.12 meet it: 9 at 2582 rpm, 8 at "
        "2905 rpm, if it is as heavy as the present spring",
    ]
    scene.detach.hold_to = 2900.0
    _, said = verdict._surge_of_springs(Made(scene=scene, summary=summary), holds)
    assert said.endswith(" meet it: 9 at 2582 rpm, if it is as heavy as the present spring")
    assert not list(verdict._surge_of_springs(Made(scene=scene, summary=summary), []))
    assert not list(verdict._surge_of_springs(Made(scene=scene, summary={}), holds))


def test_clauses_on_other_springs_are_those_of_surge_and_of_a_solid_spring():
    """Unless the present one holds: then less preload would do, and none of them is needed."""
    surge = {"mass_kg": 0.06, "limit": 0.12, "strong": []}
    scene = Made(detach=Made(hold_to=2910.0), cam=Made(kind="arcs"), spring=Made(solid_at=0.012))
    solid = "where a spring of another rate is solid is not known: solid_at is the present one's"
    meets = "up to 2910 rpm no harmonics over 0.12 meet it, if it is as heavy as the present spring"

    def told(*holds):
        result = Made(scene=scene, summary={"surge": surge}, values=Made(holds=holds))
        return list(verdict._on_springs(result))

    found = Hold(STIFFNESS, HoldStatus.OK, 64_000.0, 1.0)
    none = Hold(BOTH, HoldStatus.IMPOSSIBLE)
    less = Hold(PRELOAD, HoldStatus.OK, 36_000.0, 2.0, more=False)
    assert told(found, none) == [f"stiffer spring: {meets}", solid]
    assert told(found, less) == [solid]
    assert told() == []
    scene.spring.solid_at = None
    assert told(found) == [f"stiffer spring: {meets}"]


def test_what_lies_within_tolerances():
    worst = {"follower.mass": 5.0, "table_error": -2.25}
    assert tolerance.deviations(worst) == "follower.mass +5 %, the error of the table -2.25 %"
    assert tolerance.share_words(0.234, 999) == "about 20 % of the variance"
    assert tolerance.share_words(0.234, 1000) == "23 % of the variance"
    assert tolerance.worst_name("follower.mass", -5.0) == "mass\nworst −5 %"
    assert tolerance.worst_name("table_error", 2.5) == "error of the table\nworst +2.5 %"
    assert tolerance.spread_title(3333.3) == "the worst up to 3333 rpm"


def test_what_a_plan_leaves_open():
    def section(**more):
        return Made(**more)

    unknown = "is not known before the run"
    assert plan.simulate(Made(simulate=section(animate=True))) == [
        "drawing the animation comes on top, some 10 to 20 s"
    ]
    assert plan.simulate(Made(simulate=section(animate=False))) == []
    everything = section(explain=True, adaptive=True, curves="auto", prove=True)
    assert plan.sweep(Made(sweep=everything)) == [
        f"how long --explain takes {unknown}: 5 to 15 s for many a change",
        f"how many speeds --adaptive adds {unknown}",
        f"how many curves --curves auto follows {unknown}",
        "a proof of --prove takes 0.2 to 5 s for each curve",
    ]
    nothing = section(explain=False, adaptive=0, curves="file", prove=False)
    assert plan.sweep(Made(sweep=nothing)) == []
    assert plan.detach(Made(detach=section(tolerance=[1], machines=250))) == [
        "250 machines of --tolerance come on top, 0.1 s each"
    ]
    assert plan.detach(Made(detach=section(tolerance=[], machines=250))) == []
    assert plan.orbits(Made()) == [f"how many branches there are, and so the time, {unknown}"]
    assert plan.basins(Made(basins=section(refine=2, count=3))) == [
        f"what --refine adds at boundaries {unknown}",
        "a speed in the middle stands for all, but speeds with chaos take many times as long",
    ]
    assert plan.basins(Made(basins=section(refine=0, count=1))) == []
    assert plan.classify(Made(classify=section(explain=False))) == []
    assert plan.explore(Made()) == [f"the orbits come on top: how many are solved {unknown}"]
    assert plan.of_a_shard(2, 5) == "shard 2 of 5: pieces only, no tables"
    assert plan.cut_off(20.0) == (
        "a small part took 20 s: how long it takes is not known before the run"
    )
    assert plan.budget_ends(5000, 12.34) == "run.work_budget = 5000 ends it after some 12 s"
    assert plan.motions_at_speeds(2, 3, 4) == "2 speeds x 3 starts x 4 recorded turns"
    assert plan.speeds_of_a_sweep(2, 3, 4) == "2 speeds of 3 turns, 4 recorded"
    assert plan.cells_of_a_window(2, 3, 4) == "2 x 3 cells, refined 4 times"
    assert plan.parts_of_a_page(2, 3, 4) == "2 speeds of 3 sweeps, 3 cells, 4 points of a map"
    assert plan.parts_of_a_page(2, 0, 0) == "2 speeds of 3 sweeps"


def test_what_a_sweep_or_a_map_could_not_tell():
    def speeds(*known):
        return [Made(known=one, holds_for=None, rpm=700.5) for one in known]

    found = Made(bare=speeds(True, False, False), speeds=[1, 2, 3], key="rpm")
    assert sweep.sweep_notes(found) == [
        "2 of 3 motions are undecided: the follower comes to rest, rounding decides what follows, "
        "and ball arithmetic could not tell (cam guide labels)"
    ]
    one = Made(bare=speeds(True, False), speeds=[1, 2], key="rpm")
    assert sweep.sweep_notes(one)[0].startswith("1 of 2 motions is undecided: ")
    assert sweep.sweep_title(found, 1) == "3 speeds, 1 range of one label"
    found.key = "follower.mass"
    assert sweep.sweep_title(found, 2) == (
        "3 values of follower.mass at 700.5 rpm, 2 ranges of one label"
    )
    own = "1 of 2 points is undecided: after a rest, rounding decides"
    there = Made(speeds=speeds(True, False))
    assert sweep.map_notes(there, followed=True) == [own]
    assert sweep.map_notes(there, followed=False) == [
        own + "; sweep.decide (--decide) follows each beyond rounding, which takes some seconds"
    ]
    lines = [speeds(True), speeds(True, True)]
    keys = ["follower.mass", "follower.restitution"]
    assert sweep.map_title(Made(lines=lines, keys=keys)) == (
        "follower.mass x follower.restitution: 3 points at 700.5 rpm"
    )


def test_how_far_a_record_can_be_trusted():
    rest = (
        " on, this is one of many motions that rounding allows: an error of the last digit has "
        "grown beyond five digits of a turn (the label is that of the true motion, where that "
        "could be told)"
    )
    assert simulate.rounding_notes(None) == []
    assert simulate.rounding_notes(7) == ["from turn 7 of the record" + rest]
    assert simulate.rounding_notes(0) == ["from turn 0 of the record" + rest]
    assert simulate.rounding_notes(-1) == ["from 1 turn before the record" + rest]

    def ends(**more):
        own = {"watched": 900, "orbit": None, "chatters": 0}
        return simulate.end_notes(Made(ends=Made(**{**own, **more}), label="P(2;1:1)"))

    begin = "the record shows "
    assert ends() == [begin + "no period; it was followed for 900 turns"]
    assert ends(chatters=1) == [
        begin + "no period, and after 900 turns a rest: what follows is not known"
    ]
    assert ends(orbit=1) == [
        begin + "a transient: followed for 900 turns, the motion has settled on P(2;1:1)"
    ]
    assert ends(watched=0, chatters=1) == [
        begin + "no period, and after 0 turns a rest: what follows is not known"
    ]
    assert ends(watched=None) == []
    assert simulate.end_notes(Made(ends=None)) == []


def test_why_a_number_cannot_be_followed():
    def why(path, kind="law", value=1.5, known=True):
        return why_not_followed(path, kind, value, known)

    assert why("follower.mass") == ""
    assert why("run.rpm") == (
        "it says how motions are simulated and recorded, no orbit depends on it"
    )
    assert why("cam.base_radius", "table") == (
        "only pictures of the lobe need it, no orbit depends on it"
    )
    assert why("cam.smoothing", "table") == (
        "it says how the table is smoothed, which is no number of a machine"
    )
    assert why("a", value=True) == "it is a switch"
    assert why("a", value="b") == "it is a text, 'b'"
    assert why("a", value={}) == "it is a section, name a number in it"
    assert why("a", value=3) == "it is a whole number"
    assert why("a", value=None) == (
        "the scene leaves it out, so that a branch has nowhere to begin"
    )
    assert why("a", value=None, known=False) == ""


def phrases(of, *parts):
    """Each row of a table of words has its own part, and no other row has."""
    assert len(parts) == len(of)
    for (key, text), part in zip(of.items(), parts, strict=True):
        assert part in text, key
        assert [own for own, words in of.items() if part in words] == [key]


def test_words_that_stand_in_a_table():
    """A row's text by what it has to say; statuses in the order of their numbers."""
    phrases(
        statuses.CAUSES, "event log was too small", "as many impacts as run.impact_budget allows",
        "left the cam and nothing brings it back", "closer to grazing than double precision",
        "was interrupted", "budget of work was used up", "nobody foresaw cost this piece alone",
    )  # fmt: skip
    phrases(
        statuses.CURES, "fault of the program",
        "raise run.impact_budget, raise run.chatter_tolerance, or lower restitution",
        "give the follower a spring, gravity or a preload",
        "move the speed by a relative 1e-12, or treat both outcomes as possible",
        "run the same command again", "raise run.work_budget",
        "please report it with run.json",
    )  # fmt: skip
    phrases(
        border_collision.KINDS, "holds within rounding: the linear parts do not decide",
        "fixed point on both sides, yet its basin shrinks to nothing",
        "chaotic attractor on one side, and for all linear parts close",
        "attracts on one side, nothing bounded on the other",
        "two fixed points are born on one side, there is none on the other",
        "each side, and a cycle LR is born on one of them", "and no cycle LR is born",
    )  # fmt: skip
    phrases(border_collision.EQUALITIES, "is +1", "is -1", "two multipliers on the unit circle")
    assert border_collision.SIDES == {
        -1: "Where the normal form's parameter is below 0", 1: "Where it is above 0"
    }  # fmt: skip


@pytest.mark.parametrize(
    ("rpm", "error", "said"),
    [
        (740.1065432, 1e-9, "740.106543"),
        (40.1065432, 1e-9, "40.1065432"),
        (740.1065432, 0.00234, "740.107 ± 0.002"),
        (740.1065432, 0.234, "740.1 ± 0.2"),
        (740.1065432, 2.34, "740 ± 2"),
        (740.1065432, inf, "740.106543"),
        (740.1065432, 1e-6, "740.106543 ± 0.000001"),
        (740.1065432, 12.0, "740 ± 12"),
    ],
)
def test_the_speed_of_an_event_has_the_digits_of_its_error(rpm, error, said):
    assert explanations.event_speed(Made(rpm=rpm, error=error)) == said


@pytest.mark.parametrize(
    ("kind", "corner", "said"),
    [
        ("period-doubling", "", "period doubling"),
        ("corner-impact", "b", "corner impact at b"),
        ("detachment", "A2", "detachment A2"),
        ("fold+grazing", "", "fold, grazing"),
        ("chatter", "B", "chatter B"),  # a region without a number
        ("accumulation-at-corner", "c", "accumulation at corner c"),
    ],
)
def test_the_name_of_an_event_in_a_picture(kind, corner, said):
    assert explanations.event_name(Made(kind=kind, corner=corner)) == said
