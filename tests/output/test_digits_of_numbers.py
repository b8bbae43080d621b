"""How many digits the numbers of sentences have that few results reach.

Values have more digits than any sentence; what stands in it was rounded by hand. A speed that a
user gives has ten, so that he finds it again.
"""

from __future__ import annotations

import re
from math import inf, radians
from types import SimpleNamespace as Made

import pytest

from camcli.analysis.border_collision import Cycle, Inequality, Rule
from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.bursts import LiftOff, LiftOffKind
from camcli.analysis.contact_loss.detachment import (
    AlwaysLost,
    CriticalQuantity,
    CriticalSpeed,
    Reason,
    SpeedStatus,
)
from camcli.analysis.contact_loss.hold import Hold, HoldStatus
from camcli.analysis.explain.crisis import Crisis, CrisisKind, MetSaddle
from camcli.analysis.integrate import Cost
from camcli.analysis.lobe import Face
from camcli.analysis.natural_speed import Basis
from camcli.analysis.orbits.kinds import Kind
from camcli.analysis.orbits.locate import Bracket
from camcli.analysis.throw import Throw
from camcli.cams.eccentric import EccentricCam
from camcli.cli import orbits as cli_orbits
from camcli.exact.shooting import ProofStep
from camcli.quantities import MILLIMETRES
from camcli.system import Follower, System
from camcli.words import (
    basins,
    bench,
    border_collision,
    chaos,
    classify,
    cost,
    detach,
    events,
    explanations,
    explore,
    figures,
    in_print,
    lift_table,
    machine,
    proofs,
    simulate,
    speeds,
    surge,
    sweep,
    tolerance,
    verdict,
)
from camcli.words import orbits as words_of_orbits
from camcli.words.all_orbits import cover_heading
from tests.output.test_whole_sentences import accuracy, contact_loss, critical
from tests.output.test_words_of_proofs_and_basins import collision, speed

LABEL = re.compile(r"P\([^)]*\)")
NUMBER = re.compile(r"(?<![\w.])[-−+]?\d[\d.]*(?:e[-+]?\d+)?(?!\w)")
RPM, RPM_10 = 1234.5678912345, "1234.567891"
DEG = 123.45678912345


def numbers(text) -> list[str]:
    """The numbers of a text, in their order; those of labels such as P(2;1:1) are left out."""
    return [number.rstrip(".") for number in NUMBER.findall(LABEL.sub("", text))]


def lands(kind, rest=inf):
    """What is said of a follower released 3.456789 deg before, and back 12.345678 deg after it."""
    ends = (radians(110.0 + x) for x in (-3.456789, 12.345678))
    off = LiftOff("A2", kind, "b", RPM, *ends, inf if rest == inf else radians(110.0 + rest))
    opens = Made(opens=Made(rpm=RPM, theta=radians(110.0)), region=Made(name="A2"))
    return detach.theory(contact_loss(losses=[opens], lift_offs=[off]))


def on_crisis(kind):
    saddle = Made(label="P(1;1)", multipliers=(complex(2.3456789), 0.1))
    found = Crisis(
        kind, RPM, 0.004, (RPM, RPM + 0.0123456), RPM, 4000, Cost(),
        met=(MetSaddle(saddle, RPM, 0.00123),),
    )  # fmt: skip
    return explanations.crisis_sentences(found)


def of_grid(**more):
    return speed(**{"cells": 300, "computed": 37, "turns": (12, 345, 6789), **more})


def told_by_figures(by, reference):
    drift = Made(figure="ball", name="q", reference=reference, found=7, by=by, portability=False)
    return figures.drift_line(drift, False)


EXPONENTS = Made(defect=-0.000123456, largest=0.1, second=-0.2)
CHATTERS = Made(exponents=None, label="undecided", watched=None, chatters=7, value=RPM,
                record=Made(periods=8641), orbit=None)  # fmt: skip
WATCHED = Made(**{**vars(CHATTERS), "watched": 123})
COMPLEX = Cycle("LR", (complex(0.123456789, 0.987654321), complex(0.1, -0.9)), True, (), -1)
FAILS = (Inequality(Rule.BEYOND_ONE, "L", 1.5),
         Inequality(Rule.BEYOND_ONE, "R", 0.123456789, 0.987654321))  # fmt: skip
COSTS = {"impacts": 1000, "seconds": 12.3456, "impacts_per_s": 4567.89, "pieces_from_disk": 0,
         "gap_evaluations": 12345}  # fmt: skip
ERRORS = {"contact_gap_m": 2.46e-16, "accumulation_phase_turns": 1.26e-9,
          "lift_table": {"rms": 4.5678e-7}}  # fmt: skip
NEAR = CriticalSpeed(CriticalQuantity.FIRST_DETACHMENT, "A2", radians(DEG), RPM, RPM, RPM,
                     SpeedStatus.UNRESOLVED)  # fmt: skip
CHANGE = Made(low=RPM, high=2.0 * RPM, cause="basin", persists=("P(1;1)",), crisis=None)
EVENT = Made(kind="fold", rpm=RPM, label="P(1;1)", error=0.0, source=NEAR)
KNOWN = Made(**{**vars(CHANGE), "cause": "fold", "persists": (), "events": [EVENT],
                "status": explanations.Status.OK})  # fmt: skip
HIT = CornerHit(3, "d", RPM, RPM, RPM, SpeedStatus.OK, "A2", (radians(DEG), radians(2.0 * DEG)))
MEASURED = accuracy(
    lift=0.0123456789, quantum=1.23456e-6, rms=3.45678e-7, largest=9.87654e-6, line=77,
    length_deg=12.3456, noise=2.34567e-6, spacing_deg=2.34567, jump_deg=DEG, jump=0.0123456,
    jump_error=0.000345678, jump_sure=8.7654, bound=0.00246802,
)  # fmt: skip
WORTH = {"bound": 0.00246802, "accel": 0.0543210, "standard": 0.000512345, "bending": 0.000787654,
         "worst": 0.0135791, "first_detachment_rpm": [None, None]}  # fmt: skip

CASES = {
    "all orbits": (
        lambda: cover_heading(Made(question=Made(rpm=RPM)), Made(
            impacts=2, turns=2, orbits=[], covers=[],
            follower=Made(mass=1.0, stiffness=0.0, damping=0.0)))[0],
        ["1", "2", "1", "2", RPM_10],
    ),
    "cells of a grid": (  # 37 of 300 are 12.333 %
        lambda: basins.grid_lines(of_grid(), verbose=False)[0],
        ["300", "37", "12.3", "12", "99", "345", "6789"],
    ),
    "cells of pictures": (  # 74 of 600
        lambda: basins.window_words([of_grid(level=2), of_grid(level=2)],
                                    Made(strobe=radians(DEG))).partition("starts")[2],
        ["123.4567891", "12.3"],
    ),
    "a published number": (
        lambda: bench.validation_notes([Made(
            problem="ball", quantity="speed", published="0.3", ours=1.0 / 3.0,
            difference=-0.0123456, bound=0.00987654)])[0],
        ["0.3", "0.33333333333333331", "0.0123", "0.00988"],
    ),
    "a cycle LR": (
        lambda: border_collision.collision_words(collision(cycle=COMPLEX))[-1],
        ["0", "0.123457", "0.987654"],
    ),
    "no robust chaos": (
        lambda: border_collision.collision_words(collision(chaos=FAILS))[-1].partition("fails")[2],
        ["0.123457", "0.987654"],
    ),
    "chaos": (lambda: chaos.chaos_title(Made(proved=True, rpm=RPM)), [RPM_10]),
    "exponents of several": (
        lambda: classify.exponent_text([(-0.123456, 0.0), (0.876543, 0.1)]), ["-0.1235", "0.8765"]
    ),
    "a sum rule": (
        lambda: classify._on_exponents([Made(exponents=EXPONENTS)])[0].partition("less")[2],
        ["0.0001", "1"],
    ),
    "chatters that are watched": (
        lambda: next(classify._unsolved_notes([WATCHED], "rpm")), [RPM_10, "123"]
    ),
    "chatters of a record": (  # 8641/7 = 1234.4
        lambda: next(classify._unsolved_notes([CHATTERS], "rpm")),
        [RPM_10, "7", "8641", "1.23e+03"],
    ),
    "a cost": (
        lambda: cost.cost_line(COSTS, ERRORS),
        ["1000", "12.3", "4570", "12", "2e-16", "0.46", "1e-09"],
    ),
    "contact held": (
        lambda: detach.plainly(contact_loss(critical(2.0 * RPM), rpms=(RPM / 2.0, RPM)))[0],
        [RPM_10],
    ),
    "contact lost": (
        lambda: detach.plainly(contact_loss(critical(RPM / 2.0), rpms=(RPM,)))[0], [RPM_10]
    ),
    "a lift-off": (
        lambda: lands(LiftOffKind.CAUGHT, 45.678912)[0], [RPM_10, "3.46", "12.3", "45.7"]
    ),
    "an impact that vanishes": (
        lambda: detach.theory(contact_loss(ended=[HIT]))[0], [RPM_10, "3", "123.457", "246.914"]
    ),
    "an end that jumps": (
        lambda: detach.theory(contact_loss(jumps=[Made(rpm=RPM, burst="A2", region="A4")]))[0],
        [RPM_10],
    ),
    "no safe bracket": (
        lambda: detach.unresolved_notes(contact_loss(critical_speeds=[NEAR]))[0], [RPM_10]
    ),
    "a drop of the slope": (
        lambda: detach._always(AlwaysLost(Reason.KINK, radians(DEG), 0.123456789)),
        ["0.123457", "123.4567891"],
    ),
    "a force at standstill": (
        lambda: detach._always(AlwaysLost(Reason.FORCE, radians(DEG), -12.3456789)),
        ["-12.3457", "123.4567891"],
    ),
    "a spring": (
        lambda: detach.spring(Hold(CriticalQuantity.HOLD_BOTH, HoldStatus.OK, 12345.678912345,
                                   12.345678912345)),
        ["12345.67891", "12.34567891"],
    ),
    "a speed that is lost": (
        lambda: explanations.event_sentence(EVENT), ["123.457"]
    ),
    "a cause with its own line": (
        lambda: explanations.change_sentence(KNOWN, [EVENT]), [RPM_10]
    ),
    "a change": (lambda: explanations.change_line(KNOWN, [EVENT]), [RPM_10, "2469.135782", RPM_10]),
    "an orbit beside a change": (
        lambda: explanations.change_sentence(CHANGE, [EVENT]), [RPM_10]
    ),
    "no crisis": (lambda: on_crisis(CrisisKind.NOT_CHAOTIC)[0], [RPM_10]),
    "a run that stays": (lambda: on_crisis(CrisisKind.STAYS)[0], [RPM_10, "4000", RPM_10]),
    "what a crisis meets": (  # known to 0.00123 rpm
        lambda: on_crisis(CrisisKind.INTERIOR)[2], ["2.346", "1234.568"]
    ),
    "starts of basins": (
        lambda: explore.basin_shares(RPM, [("contact", 0.123456)]), [RPM_10, "12.3"]
    ),
    "a number off its reference": (  # 1.23456789e-5/0.00345678 = 0.0035714
        lambda: told_by_figures(1.23456789e-5, 0.00345678).partition("off by")[2],
        ["1.23457e-05", "0.0036"],
    ),
    "a value in print": (lambda: in_print.number_text(-RPM), [f"−{RPM_10}"]),
    "a double multiplier": (lambda: in_print.pair(2.0 * 0.123456, 0.123456**2), ["0.1235"]),
    "a lift table": (
        lambda: lift_table.fit_line(MEASURED, "a"),
        ["181", "12.346", "1.23", "0.346", "9.88", "77", "12"],
    ),
    "a table that scatters": (  # its rounding scatters by 1.23456/sqrt(12) = 0.35639 um
        lambda: lift_table.cautions(MEASURED)[0], ["2.35", "6.58"]
    ),
    "a table that jumps": (
        lambda: lift_table.cautions(MEASURED)[-1], ["123.5", "0.012", "0.0003", "4", "8.8"]
    ),
    "a row that is off": (  # 98.7654/2.34567 = 42.1054
        lambda: lift_table.cautions(accuracy(noise=2.34567e-6, quantum=1.0, largest=9.87654e-5))[0],
        ["77", "98.8", "42.1"],
    ),
    "rows too far apart": (
        lambda: lift_table.cautions(
            accuracy(noise=2.34567e-6, spacing_deg=2.34567, bends_between_rows=True))[0],
        ["2.35", "2.35", "8.13"],  # of 1/sqrt(12) um
    ),
    "a second derivative": (  # 0.00246802 of 0.054321 are 4.5434 %
        lambda: lift_table.bound_line(WORTH),
        ["0.0025", "4.5", "0.00051", "0.00079", "0.014"],
    ),
    "a page of a smoothed cam": (
        lambda: lift_table.smoothed_cam(MEASURED, MILLIMETRES, (RPM, RPM), RPM),
        ["0.35", "2.5", "1234.57", "1235"],
    ),
    "a machine": (  # 1234.56789 N/m on 12.34567 to 35.80245 mm, with 97.65432 N
        lambda: [value for _, value in machine.machine(made_machine())],
        ["", "1.235 kg", "1.235 N/mm", "112.9 N", "141.9 N", "0.1235 N s/m", "0.123",
         "eccentric", "23.46 mm", "0.4568 kg", "roller of 6.789 mm", "18.77 mm", "9.877 mm"],
    ),
    "a large lift": (lambda: doubt(cam=law(9.8765432)), ["9877"]),
    "a large base radius": (
        lambda: doubt(cam=law(0.01, base_radius=17.654321)), ["17.65"]
    ),
    "a solid spring": (
        lambda: doubt(spring=Made(solid_at=0.0098765432, mass=None)), ["9.877"]
    ),
    "radii in a table": (  # 15.54321 mm and the half that was subtracted
        lambda: doubt(cam=Made(kind="table", measured=Made(lift=[0.015543210987, 0.025]),
                               metres=1e-3, subtract=0.5, base=0.0)),
        ["15.54", "16.04321099"],
    ),
    "a preload that pulls": (lambda: doubt(preload=-12.345678), ["-12.35", "0"]),
    "a soft spring": (  # 23.45678 N/m on 10 mm
        lambda: doubt(stiffness=23.45678, preload=98.7654321), ["23.46", "0.23", "98.77"]
    ),
    "a heavy mass": (  # 98.76543 N and 5000 N/m on 10 mm
        lambda: doubt(mass=87.654321, preload=98.7654321), ["87.65", "148.8"]
    ),
    "a heavy spring": (  # 0.1 kg with a third of 0.12345678 kg
        lambda: doubt(spring=Made(mass=0.12345678)), ["0.05885", "0.04115", "0.1235", "0.05885"]
    ),
    "a wide contact": (
        lambda: doubt(contact=Made(width=12.345678)), ["12.35"]
    ),
    "a speed of the crank": (
        lambda: doubt(hold_to=2.0 * RPM, rpm=RPM, crank=True), ["2469.135782", "4938.271565"]
    ),
    "a throw": (
        lambda: machine.height_notes(Throw(RPM, 12.345678, 0.0098765432))[0],
        [RPM_10, "12.3", "1.25e+03"],
    ),
    "an event without a bracket": (lambda: on_branches()[0], [RPM_10]),
    "a branch that is lost": (lambda: on_branches()[1], ["7", RPM_10]),
    "a branch of a fault": (lambda: on_branches()[2], ["7", RPM_10]),
    "an orbit elsewhere": (  # a speed to find it again at
        lambda: words_of_orbits._found_or_not(Made(
            absent=Made(rpm=RPM, nearest=(0.12345678912345678, "fold")), continua=(), orbits=(),
            every=None, question=Made(label="P(1;1)", rpm=RPM)), "")[0],
        [RPM_10, "0.1234567891235"],
    ),
    "a continuum": (
        lambda: words_of_orbits._found_or_not(Made(
            absent=None, orbits=(), every=None, question=Made(label=None, rpm=RPM),
            continua=[Made(label="P(1;1)", start=radians(DEG), end=radians(2.0 * DEG))]), "")[0],
        ["123.45679", "246.91358", "1"],
    ),
    "no Neimark-Sacker": (
        lambda: words_of_orbits._no_neimark_sacker(
            Made(branches=[Made(points=[Made(det=0.123456789)])])).partition("at most")[2],
        ["0.123457", "1"],
    ),
    "a limit of machines": (
        lambda: words_of_orbits.limit_sentences(Made(
            question=Made(parameter="rpm"), limits=[Made(value=RPM, reason="")]))[0],
        [RPM_10],
    ),
    "a branch": (
        lambda: words_of_orbits.branch_line(
            Made(number=7, stable_ranges=lambda _: [(RPM, 2.0 * RPM)], turning_points=[RPM]), ()),
        ["7", RPM_10, "2469.135782", RPM_10],
    ),
    "cells of a branch": (
        lambda: words_of_orbits.stable_cell(
            Made(stable_ranges=lambda _: [(RPM, 2.0 * RPM)]), ()) + " "
        + words_of_orbits.turns_cell(Made(turning_points=[RPM])),
        ["1234.568", "2469.136", "1234.568"],
    ),
    "what a class rests on": (
        lambda: words_of_orbits._rests_on(Made(corner_impact=Made(collision=Made(
            inequalities=[Inequality(Rule.BEYOND_ONE, "L", 0.123456789, 0.5)])))
        ).partition("fails")[2],
        ["0.123457"],
    ),
    "a side of a corner": (
        lambda: words_of_orbits._side(Made(trace=-0.323456789, det=0.0123456789)),
        ["−0.323457", "0.0123457", "−0.2792", "−0.04421"],
    ),
    "a value in a picture": (lambda: words_of_orbits.value_text(RPM, "rpm"), ["1234.56789"]),
    "places of a curve": (
        lambda: proofs.place_of((RPM, 0.7123456789123), ("rpm", "cam.base")),
        [RPM_10, "0.7123456789"],
    ),
    "points that are not proved": (
        lambda: list(proofs._on_points_of_branches(
            Made(question=Made(parameter="rpm"),
                 branches=[Made(number=7, points=[Made(value=RPM)])]),
            Made(points=[[Made(proved=False, step=ProofStep.WORK_BUDGET)]])))[1].split(": ")[1],
        ["1", "7", RPM_10],
    ),
    "a flank that closes": (
        lambda: proofs.closed_flank(-1.23456e-7), ["1.23e-07"]
    ),
    "an event of grazing": (
        lambda: events.event_words(Made(
            located=Made(fading=None, impact=2, phase=radians(DEG), root=None), kind="grazing",
            corner_impact=None, seen=None))[0],
        ["3", "123.45679"],
    ),
    "a range without an end": (
        lambda: speeds.range_words(RPM, inf) + " " + speeds.range_words(RPM, RPM),
        ["1235", "1234.57"],
    ),
    "a speed of an oscillator": (  # 60 rpm are 2 pi rad/s
        lambda: speeds.run_speed(60.0, "oscillator") + speeds.run_speed(RPM)
        + " " + speeds.run_speeds(60.0, 120.0, "oscillator") + " " + speeds.run_speeds(RPM, RPM),
        ["6.283185307", "6.28318531", "12.56637061", RPM_10],
    ),
    "speeds that were chosen": (
        lambda: speeds.chosen_speeds("sweep", Made(
            low=100.0, high=200.0, by=Made(basis=Basis.NATURAL, rpm=RPM))),
        ["100", "200", "1234.6"],
    ),
    "speeds by the first loss": (
        lambda: speeds.chosen_speeds("sweep", Made(
            low=100.0, high=100.0, by=Made(basis=Basis.FIRST_LOSS, rpm=RPM))),
        ["100", "1234.6"],
    ),
    "both shafts": (
        lambda: speeds.of_both_shafts(RPM, 2.0 * RPM) + " " + speeds.of_both_shafts(RPM, RPM),
        [RPM_10, "2469.135782", "2469.135782", "4938.271565", RPM_10, "2469.135782"],
    ),
    "surge": (
        lambda: surge.surge_words(made_surge(), None)[0].partition("over")[0],
        ["123.5", "12", "1235", "0.12", "7", "2469", "0.99"],
    ),
    "no surge": (
        lambda: surge.surge_words(made_surge(), 0.5 * RPM)[0] + surge.surge_title(made_surge()),
        ["123.5", f"{surge.LIMIT:g}", "617.3", "123.5"],
    ),
    "the worst machine": (
        lambda: tolerance.deviations({"follower.mass": 1.23456, "table_error": -12.3456})
        + " " + tolerance.worst_name("follower.mass", -1.23456),
        ["+1.23", "-12.3", "−1.23"],
    ),
    "a start": (  # as the user wrote it, to six digits
        lambda: sweep._place(Made(q=0.0123456789, v=-1.23456789), ""), ["0.0123457", "-1.23457"]
    ),
    "a lobe that cannot be made": (
        lambda: simulate.undercut_notes(Made(curvature=Made(
            undercut=True, flat_least=Made(value=-0.012345678, theta=radians(DEG)),
            least_base_radius=0.0234567)), made_machine().system)[0],
        ["-12.35", "123.46", "23.46"],
    ),
    "an event of an orbit": (
        lambda: words_of_orbits._on_events(Made(bifurcations=[Made(
            kind="fold", label="P(1;1)", value=RPM, branch=1, located=None, beyond="P(1;1)",
            corner_impact=None)]), False)[0],
        [RPM_10],
    ),
    "how far a face is touched aside": (
        lambda: simulate.beside_title(Made(
            face=Face.FLAT, beside=(Made(value=-0.0123456), Made(value=0.0234567))), MILLIMETRES),
        ["−12.35", "23.46"],
    ),
    "a rocker": (lambda: simulate.cam_words(None, False, 1.23456789), ["1.23457"]),
    "another spring": (
        lambda: verdict.spring_words(Hold(
            CriticalQuantity.HOLD_BOTH, HoldStatus.OK, 45123.456, 325.4567), MILLIMETRES),
        ["45.12", "325.5"],
    ),
    "the pace of a film": (  # 1234.5679 rpm of 3 s each: 61.728
        lambda: simulate.slowed(RPM, 3.0, 2.3456) + " " + simulate.slowed(6.5432, 3.0),
        ["61.7", "2.35", "3.06"],
    ),
}  # fmt: skip


def law(lift, **more):
    return Made(**{"kind": "law", "lift": lift, "base": 0.0, **more})


def doubt(cam=None, spring=None, contact=None, hold_to=None, rpm=None, crank=False, **follower):
    """The doubts in one text; of a follower of 0.1 kg on a cam of 10 mm, if nothing else is."""
    own = {"mass": 0.1, "stiffness": 5000.0, "preload": 98.7654321, **follower}
    return " ".join(machine.doubts(Made(
        follower=Made(**own), cam=cam or law(0.01), spring=spring, contact=contact,
        detach=Made(hold_to=hold_to), run=Made(rpm=rpm, crank=crank),
    )))  # fmt: skip


def made_machine():
    """An eccentric valve in mm, with a spring and a roller."""
    cam = EccentricCam(kind="eccentric", base=0.01234567, lift=0.02345678)
    follower = Follower(1.23456, 1234.56789, damping=0.123456, preload=97.65432,
                        restitution=0.123456)  # fmt: skip
    contact = Made(follower_radius=0.0067891, face=None, base_radius=0.0187654, width=0.0098765)
    scene = Made(cam=cam, spring=Made(mass=0.4567891), contact=contact)
    return Made(system=System.build(follower, cam), scene=scene)


def made_surge():
    strong = [Made(number=12, rpm=RPM, factor=0.123456), Made(number=7, rpm=2.0 * RPM,
                                                             factor=0.987654)]  # fmt: skip
    return Made(hertz=123.456789,
                strong_below=lambda rpm: [one for one in strong if one.rpm <= rpm])  # fmt: skip


def on_branches():
    """Notes on an event, a branch that is lost, and one that has a fault."""
    event = Made(status=Bracket.UNRESOLVED, kind="fold", label="P(1;1)", value=RPM)
    ends = [Made(number=7, ends=(kind, None), points=[Made(value=RPM)])
            for kind in (Kind.LOST, Kind.FAULT)]  # fmt: skip
    return words_of_orbits.notes(Made(bifurcations=[event], branches=ends, every=None, chaos=None,
                                      question=Made(curve=None), curves=()))  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_numbers_have_the_digits_that_they_are_worth(name):
    sentence, wanted = CASES[name]
    found = sentence()
    assert (numbers(found) if isinstance(found, str) else found) == wanted


def test_points_of_codimension_two_have_thirteen_digits_on_the_screen(capsys):
    """Twelve that are proved, and one more."""
    point = Made(kind="fold-grazing", label="P(1;1)", first=1234.56789123456, corners=(),
                 second=0.7123456789123456, curves=[1, 2], meets=("fold", "grazing"))  # fmt: skip
    plane = Made(names=("rpm", "cam.base"))
    cli_orbits._show_points(Made(question=Made(plane=plane), codim2=[point]), True)
    lines = capsys.readouterr().out.splitlines()
    (row,) = [line.split() for line in lines if "fold-grazing" in line]
    assert row[2:4] == ["1234.567891235", "0.7123456789123"]
    assert row[4:] == ["1,", "2", "fold", "&", "grazing"]
