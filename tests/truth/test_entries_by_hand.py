"""Entries of run.json of results made by hand.

Every number of a result is another one, so that none can stand in another's place.
"""

from math import degrees, inf, nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest

from camcli.analysis.contact_loss.force import Hertz
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.orbits.curve_proofs import CurveRange
from camcli.analysis.orbits.proofs import ProofStep
from camcli.api import basins, classify, detach, orbits, simulate, sweep
from camcli.errors import Status
from camcli.kernel.certify import Verdict
from camcli.words.codim2 import UNFOLDS
from camcli.words.orbits import end_words
from camcli.words.proofs import FAILED, LEFT

RPM = 600.0
OMEGA = 2.0 * pi * RPM / 60.0


def orbit(**more):
    own = {
        "label": "P(2;1:1)", "rpm": RPM, "value": 0.75, "stable": False, "verdict": Verdict.LATE,
        "theta": [radians(155.5), radians(160.25)], "regions": ["A1", "A2"], "rates": [0.5, 0.25],
        "states": [(0.125, 0.0625), (0.25, 0.375)], "multipliers": (0.5, -0.25), "trace": 0.25,
        "det": -0.125, "turns": 2,
    }  # fmt: skip
    return Made(**{**own, **more})


ORBIT = {
    "label": "P(2;1:1)", "rpm": RPM, "stable": False, "verdict": "virtual: an impact is missing",
    "theta_deg": pytest.approx([155.5, 160.25]), "regions": ["A1", "A2"],
    "u_minus_m_per_s": pytest.approx([0.5 * OMEGA, 0.25 * OMEGA]), "multipliers": (0.5, -0.25),
    "trace": 0.25, "det": -0.125,
}  # fmt: skip


def proof(**more):
    own = {
        "proved": True, "holds_for": "last-digit", "refuted": False, "step": None, "value": 1.5,
        "box": [[0.1, 0.2]], "axes": [[[1.0, 2.0], [3.0, 4.0]]],
        "starts": Made(area=0.75, share=0.3125), "signs": [(next(iter(LEFT)), -1)],
    }  # fmt: skip
    return Made(**{**own, **more})


PROVED = {
    "proved": True, "holds_for": "last-digit", "refuted": False, "failed_step": None, "value": 1.5,
    "box": [[0.1, 0.2]], "ellipses": [[[1.0, 2.0], [3.0, 4.0]]], "area_m2_per_s": 0.75,
    "share_of_window": 0.3125, "signs": [(next(iter(LEFT.values())), -1)],
}  # fmt: skip
NOT_PROVED = {
    **PROVED, "proved": False, "holds_for": None, "refuted": True, "value": None,
    "failed_step": FAILED[ProofStep.PULLS], "ellipses": None, "area_m2_per_s": None,
    "share_of_window": None, "signs": [],
}  # fmt: skip


def test_orbits_and_their_branches():
    """A branch has its values from its first to its last point, whichever way it goes."""
    assert orbits._orbit(orbit()) == ORBIT
    asked = []
    branch = Made(
        number=3, origin="doubling", labels=["P(2;1:1)", "P(1;1)"], ends=["a", "b"],
        points=[orbit(value=0.875), orbit(value=0.75), orbit(value=0.5)], turning_points=[0.8, 0.6],
        stable_ranges=lambda events: asked.append(events) or [(0.5, 0.75)],
    )  # fmt: skip
    events = ["first", "second"]
    assert orbits._branch(branch, events) == {
        "branch": 3, "origin": "doubling", "labels": ["P(2;1:1)", "P(1;1)"], "from": 0.875,
        "to": 0.5, "points": 3, "ends": ["a", "b"], "stable_ranges": [(0.5, 0.75)],
        "turning_points": [0.8, 0.6],
    }  # fmt: skip
    assert asked == [events]


def test_events_of_branches(monkeypatch):
    """An event of no corner has no inequalities; what is 0 or False is told as such."""
    monkeypatch.setattr(orbits, "event_words", lambda event: f"{event.kind} it is")
    monkeypatch.setattr(orbits, "inequality_record", lambda inequality: f"of {inequality}")
    event = Made(
        branch=2, label="P(1;1)", kind="corner-impact", value=700.5, error=0.0, status="ok",
        corner="b", classification="non-smooth-fold", continues=0, agrees=False,
        corner_impact=Made(collision=Made(inequalities=["x", "y"])),
    )  # fmt: skip
    wanted = {
        "branch": 2, "label": "P(1;1)", "kind": "corner-impact", "value": 700.5, "error": 0.0,
        "status": "ok", "corner": "b", "classification": "non-smooth-fold",
        "continues_as_branch": 0, "prediction_agrees": False, "words": "corner-impact it is",
        "inequalities": ["of x", "of y"],
    }  # fmt: skip
    assert orbits._event(event) == wanted
    event.corner_impact = None
    assert orbits._event(event) == {**wanted, "inequalities": []}


def test_curves_and_their_points():
    ends = list(end_words.__globals__["CURVE_ENDS"])[:2]
    curve = Made(kind="fold", label="P(1;1)", corner="b", points=[1, 2, 3], ends=ends,
                 limits=[0.5, 0.75])  # fmt: skip
    assert orbits._curve(curve, ("cusp", "")) == {
        "kind": "fold", "label": "P(1;1)", "corner": "b", "points": 3,
        "ends": [end_words(end) for end in ends], "limits": [0.5, 0.75], "end_points": ("cusp", ""),
    }  # fmt: skip
    kind = list(UNFOLDS)[2]
    point = Made(
        kind=kind, label="P(2;1:1)", first=700.5, second=0.75, corners=["a", "c"], curves=[2, 5],
        proof=None,
    )  # fmt: skip
    wanted = {
        "kind": kind, "label": "P(2;1:1)", "first": 700.5, "second": 0.75, "corners": ["a", "c"],
        "curves": [2, 5], "unfolds": "two folds meet here and vanish",
    }  # fmt: skip
    assert orbits._point(point) == wanted
    point.proof = Made(step=None)
    assert orbits._point(point) == {**wanted, "proved": True, "failed_step": None}
    point.proof = Made(step=ProofStep.PULLS)
    failed = FAILED[ProofStep.PULLS]
    assert orbits._point(point) == {**wanted, "proved": False, "failed_step": failed}


def test_what_is_proved_and_what_is_not():
    """Proofs of orbits, events, points of curves and of what lies between, each in its place."""
    failed = {
        "proved": False, "refuted": True, "step": ProofStep.PULLS, "value": 0.0, "axes": [],
        "starts": None, "signs": [],
    }  # fmt: skip
    assert orbits._proof(proof()) == PROVED
    assert orbits._proof(proof(**failed)) == NOT_PROVED
    between = CurveRange(1, 2, 3, ((1.0, 2.0), (3.0, 4.0)), 5)
    along = CurveRange(4, 5, 6, ((5.0, 6.0), (7.0, 8.0)), 9)
    found = Made(
        orbits=[proof(value=1.0)], events=[proof(value=2.0), proof(**failed)], ranges=[between],
        curves=[[proof(value=3.0), proof(value=4.0)], [proof(value=5.0)]], curve_ranges=[along],
        flank_excess=0.25,
    )  # fmt: skip
    told = orbits._proofs(found)
    assert told["orbits"] == [{**PROVED, "value": 1.0}]
    assert told["bifurcations"] == [{**PROVED, "value": 2.0}, NOT_PROVED]
    assert [[one["value"] for one in curve] for curve in told["curves"]] == [[3.0, 4.0], [5.0]]
    assert [part["curve"] for part in told["ranges"]] == [1]
    assert [part["curve"] for part in told["curve_ranges"]] == [4]
    assert told["flank_excess_m"] == 0.25


@pytest.mark.parametrize("proved", [True, False])
def test_chaos_that_is_proved_has_bounds_and_boxes_counted_from_one(proved):
    found = Made(
        proved=proved, step=None if proved else ProofStep.COVERING, label="P(1;1)",
        boxes=["x", "y", "z"], coverings=[(0, 1), (1, 2), (2, 0)], growth=1.5, per_impact=0.4,
        per_turn=0.8, per_second=9.5, flank_excess=0.125,
    )  # fmt: skip
    bounds = {
        "growth_per_impact": 1.5, "entropy_per_impact": 0.4, "entropy_per_turn": 0.8,
        "entropy_per_second": 9.5,
    }  # fmt: skip
    assert orbits._chaos(found) == {
        "proved": proved, "about": "P(1;1)", "boxes": 3, "coverings": [[1, 2], [2, 3], [3, 1]],
        "failed_step": None if proved else FAILED[ProofStep.COVERING], "flank_excess_m": 0.125,
        **(bounds if proved else dict.fromkeys(bounds)),
    }  # fmt: skip


def test_covers_of_all_orbits():
    covers = [
        Made(impacts=1, turns=2, boxes=30, known=["x", "y"], counts={"no root": 28}),
        Made(impacts=3, turns=1, boxes=7, known=[], counts={"pulls": 7}),
    ]
    told = orbits._all(Made(impacts=3, turns=2, failure=None, covers=covers))
    assert told == {
        "impacts": 3, "turns": 2, "failed": None, "covers": [
            {"impacts": 1, "turns": 2, "boxes": 30, "around_orbits": 2, "empty": {"no root": 28}},
            {"impacts": 3, "turns": 1, "boxes": 7, "around_orbits": 0, "empty": {"pulls": 7}},
        ],
    }  # fmt: skip


def test_the_summary_of_orbits_has_each_list_in_its_place(monkeypatch):
    """Optional entries are there where they were asked for, and only there."""
    monkeypatch.setattr(orbits, "remarks", lambda found, kind: [f"of {kind}"])
    for name in ("_branch", "_event", "_point", "_proofs", "_all", "_chaos", "_curve"):
        monkeypatch.setattr(orbits, name, lambda *given, name=name: (name, *given))
    ends = {(("c", "d"), ("p",)): [("cusp", ""), ("", "x")]}
    monkeypatch.setattr(
        orbits, "points_at_ends", lambda curves, points: ends[tuple(curves), tuple(points)]
    )
    found = Made(
        orbits=[orbit()], virtual=[orbit(rpm=2.0 * RPM)], limits=[], branches=["b"],
        continua=[Made(label="contact", start=radians(10.0), end=radians(35.0))],
        bifurcations=["e", "f"], curves=["c", "d"], codim2=["p"], question=Made(plane=None),
        proofs=None, every=None, chaos=None,
    )  # fmt: skip
    wanted = {
        "words": ["of arcs"], "orbits": [ORBIT],
        "continua": [{"label": "contact", "from_deg": pytest.approx(10.0),
                      "to_deg": pytest.approx(35.0)}],
        "virtual": [{**ORBIT, "rpm": 2.0 * RPM,
                     "u_minus_m_per_s": pytest.approx([OMEGA, 0.5 * OMEGA])}],
        "branches": [("_branch", "b", ["e", "f"])],
        "bifurcations": [("_event", "e"), ("_event", "f")],
        "curves": [("_curve", "c", ("cusp", "")), ("_curve", "d", ("", "x"))],
    }  # fmt: skip
    assert orbits._summary(found, "arcs") == wanted
    found.limits = [Made(value=0.5, reason="none"), Made(value=0.75, reason="other")]
    found.question.plane, found.proofs, found.every, found.chaos = "plane", "r", "a", "k"
    assert orbits._summary(found, "arcs") == {
        **wanted, "codim2": [("_point", "p")],
        "limits": [{"value": 0.5, "reason": "none"}, {"value": 0.75, "reason": "other"}],
        "proofs": ("_proofs", "r"), "all": ("_all", "a"), "chaos": ("_chaos", "k"),
    }  # fmt: skip


def test_what_the_progress_of_orbits_counts():
    """A branch through each of two orbits and as many as are wanted; covers of all sizes."""
    assert orbits._steps(Made(all_of=None, branches=7)) == ("branches", 9)
    assert orbits._steps(Made(all_of=(3, 5), branches=7)) == ("covers", 15)


# --- detach


def test_springs_that_hold(monkeypatch):
    monkeypatch.setattr(detach, "spring", lambda hold: f"{hold.quantity} it is")
    numbers = {
        "quantity": "hold_both", "status": "ok", "stiffness": 1.0, "preload": 2.0, "region": "A2",
        "least_n": 3.0, "obstacle": None, "missing_n": 4.0, "nose_n": 5.0, "more": 6.0,
    }  # fmt: skip
    hold = Made(**numbers, theta=radians(155.5), detaches=7.0, low=6.5, high=7.5)
    wanted = {
        **numbers, "theta_deg": pytest.approx(155.5), "detaches_rpm": 7.0, "low_rpm": 6.5,
        "high_rpm": 7.5, "words": "hold_both it is",
    }  # fmt: skip
    assert detach._hold(hold) == wanted
    hold.theta = None
    assert detach._hold(hold) == {**wanted, "theta_deg": None}


def speed(**more):
    own = {
        "quantity": "opens", "region": "A2", "theta": radians(155.5), "rpm": RPM, "low": 599.0,
        "high": 602.0, "status": "ok", "burst": "", "finite": True,
    }  # fmt: skip
    return Made(**{**own, **more})


def test_critical_speeds_and_the_corners_that_are_hit():
    critical = {
        "quantity": "opens", "region": "A2", "theta_deg": pytest.approx(155.5), "rpm": RPM,
        "low_rpm": 599.0, "high_rpm": 602.0, "status": "ok",
    }  # fmt: skip
    assert detach._critical(speed()) == critical
    assert detach._critical(speed(burst="second")) == {**critical, "burst": "second"}
    never = detach._critical(speed(rpm=inf, finite=False))
    assert never == {**critical, "rpm": inf, "theta_deg": None}
    numbers = {"impact": 3, "corner": "b", "rpm": RPM, "burst": 2, "status": "ok"}
    hit = Made(**numbers, low=599.0, high=602.0, ends=None)
    wanted = {**numbers, "low_rpm": 599.0, "high_rpm": 602.0}
    assert detach._hit(hit) == wanted
    for before, after in ((10.0, 35.0), (358.0, 363.0), (362.0, 355.0), (2.0, -3.0)):
        hit.ends = (radians(before), radians(after))  # one count of turns for both
        sides = {"before_deg": pytest.approx(before), "after_deg": pytest.approx(after)}
        assert detach._hit(hit) == {**wanted, **sides}


def test_lift_offs_forces_and_waves_of_a_spring(monkeypatch):
    place = {"region": "A2", "kind": "bounce", "corner": "b", "rpm": RPM}
    phases = {"release": radians(10.0), "landing": radians(35.0), "rest": radians(70.0)}
    assert detach._lift_off(Made(**place, **phases)) == {
        **place, "release_deg": pytest.approx(10.0), "landing_deg": pytest.approx(35.0),
        "rest_deg": pytest.approx(70.0),
    }  # fmt: skip
    curve = Made(
        rpm=RPM, lowest_n=-2.5, lowest_theta=radians(155.5), pressure_pa=(),
        highest=lambda pressures: (max(pressures), radians(20.0)),
    )  # fmt: skip
    least = {"rpm": RPM, "force_n": -2.5, "theta_deg": pytest.approx(155.5)}
    assert detach._least_force(curve) == least
    curve.pressure_pa = (1e6, 3e6, 2e6)
    largest = {"largest_pressure_pa": 3e6, "largest_pressure_deg": pytest.approx(20.0)}
    assert detach._least_force(curve) == {**least, **largest}

    monkeypatch.setattr(detach, "surge_words", lambda waves, first: [first])
    waves = [Made(number=k, amplitude=1.0 / k, rpm=100.0 * k, factor=0.1 * k) for k in (2, 3, 5)]
    asked = []
    found = Made(
        mass=0.25, hertz=400.0, harmonics=waves,
        strong_below=lambda rpm: asked.append(rpm) or waves[1:],
    )  # fmt: skip
    for first, told in ((speed(), RPM), (None, None), (speed(rpm=inf, finite=False), None)):
        assert detach._surge(found, Made(detachment=Made(first=first))) == {
            "mass_kg": 0.25, "frequency_hz": 400.0, "limit": 0.12, "words": [told], "strong": [
                {"harmonic": 3, "rpm": 300.0, "factor": pytest.approx(0.3)},
                {"harmonic": 5, "rpm": 500.0, "factor": pytest.approx(0.5)},
            ],
        }  # fmt: skip
    assert set(asked) == {inf}
    table = detach._surge_table(found)
    assert {name: table[name].tolist() for name in table.columns} == {
        "harmonic": [2, 3, 5], "amplitude_m": [0.5, 1.0 / 3.0, 0.2], "rpm": [200.0, 300.0, 500.0],
        "resonance_factor": pytest.approx([0.2, 0.3, 0.5]),
    }  # fmt: skip


def test_the_summary_and_the_rows_of_detach(monkeypatch):
    for name in ("_critical", "_lift_off", "_hit", "_least_force", "_hold"):
        monkeypatch.setattr(detach, name, lambda one, name=name: (name, one))
    monkeypatch.setattr(detach, "sentences", lambda found: ["said"])
    monkeypatch.setattr(detach, "burst_ranges", lambda found: [Made(_asdict=lambda: "burst")])
    found = Made(
        critical_speeds=["a", "b"], lift_offs=["c"], hits=["d"], ended=["e", "f"], jumps=["g"],
        forces=["h"], holds=["i", "j"], margin=2.5,
    )  # fmt: skip
    wanted = {
        "words": ["said"], "critical_speeds": [("_critical", "a"), ("_critical", "b")],
        "just_above_opening": [("_lift_off", "c")], "corner_hits": [("_hit", "d")],
        "corner_hits_ended": [("_hit", "e"), ("_hit", "f")],
        "accumulation_jumps": [("_critical", "g")], "bursts": ["burst"],
        "least_force": [("_least_force", "h")], "hold": [("_hold", "i"), ("_hold", "j")],
        "hold_margin_n": 2.5,
    }  # fmt: skip
    assert detach._summary(found) == wanted
    found.holds = []
    assert detach._summary(found) == {**wanted, "hold": [], "hold_margin_n": None}

    hold = Made(quantity="hold_both", region="A3", theta=radians(20.0), detaches=900.0, low=875.5,
                high=nan)  # fmt: skip
    none = Made(quantity="hold_preload", detaches=None)
    always = Made(quantity="hold_stiffness", region="", theta=None, detaches=0.0, low=None,
                  high=0.5)  # fmt: skip
    found = Made(
        critical_speeds=[speed(), speed(rpm=inf, finite=False, low=nan, high=nan)],
        holds=[none, hold, always],
        speeds=[Made(rpm=1.0, ends=[radians(10.0), radians(35.0)]), Made(rpm=2.0, ends=[]),
                Made(rpm=3.0, ends=[radians(70.0)])],
        hits=[Made(impact=3, corner="b", rpm=RPM), Made(impact=4, corner="a", rpm=900.0)],
    )  # fmt: skip
    assert [list(row) for row in detach._critical_rows(found)] == [
        ["opens", "A2", pytest.approx(155.5), RPM, pytest.approx(OMEGA), 599.0, 602.0],
        ["opens", "A2", None, inf, inf, None, None],
        ["hold_both", "A3", pytest.approx(20.0), 900.0, pytest.approx(1.5 * OMEGA), 875.5, None],
        ["hold_stiffness", "", None, 0.0, 0.0, None, 0.5],
    ]
    ends = [(1.0, pytest.approx(10.0)), (1.0, pytest.approx(35.0)), (3.0, pytest.approx(70.0))]
    assert [*detach._chatter_end_rows(found)] == ends
    assert [*detach._corner_hit_rows(found)] == [(3, "b", RPM), (4, "a", 900.0)]


LANDED = {
    "max_impact_m_per_s": 1.5, "landing": radians(70.0), "landing_lift_m": 0.001,
    "seat_velocity_m_per_s": 0.25, "seat_bounces_per_turn": 2.0, "seat_bounce_height_m": 0.0005,
}  # fmt: skip
SEAT = {name: LANDED[name] for name in detach.AT_WORK_ON_SEAT}
HARDEST = {
    "max_impact_m_per_s": 1.5, "landing_deg": pytest.approx(70.0), "landing_lift_m": 0.001
}  # fmt: skip


@pytest.mark.parametrize(
    ("rpm", "kind", "seat", "is_open", "landed"),
    [
        (598.0, "table", False, False, False),  # contact holds
        (599.5, "table", False, True, False),  # it may be lost
        (601.0, "table", True, True, False),  # it may hold
        (603.0, "table", True, False, True),  # it is lost
        (598.0, "arcs", True, False, False),
        (600.0, "arcs", False, False, False),  # it is lost beyond that speed
        (601.0, "arcs", False, False, True),  # of a law the bracket leaves nothing open
    ],
)
def test_what_is_told_of_the_speed_at_work(monkeypatch, rpm, kind, seat, is_open, landed):
    """Landings are told where contact is lost for sure, the seat wherever there is one."""
    weakest = Made(weakest=lambda at: (-0.5 * at, 0, radians(155.5)))
    monkeypatch.setattr(detach, "Force", lambda system: weakest)
    machine = Made(system=Made(has_seat=seat), scene=Made(cam=Made(kind=kind)))
    found = Made(detachment=Made(first=speed()), at_work=Made(loads=Made(**LANDED)))
    told = detach._at_work(machine, found, rpm)
    assert told == {
        "rpm": rpm, "least_force_n": -0.5 * rpm, "theta_deg": pytest.approx(155.5),
        "open": is_open, **(HARDEST if landed else dict.fromkeys(HARDEST)),
        **(SEAT if seat else {}),
    }  # fmt: skip
    found.at_work.loads.landing = None
    assert detach._at_work(machine, found, rpm) == {**told, **dict.fromkeys(HARDEST)}
    found.at_work = None
    without = {**dict.fromkeys(HARDEST), **(dict.fromkeys(SEAT) if seat else {})}
    assert detach._at_work(machine, found, rpm) == {**told, **without}
    for first in (None, speed(rpm=inf, finite=False)):
        assert detach._at_work(machine, Made(detachment=Made(first=first)), rpm) is None


@pytest.mark.parametrize(
    ("first", "seat", "moved"),
    [(500.0, False, True), (700.0, False, False), (700.0, True, True), (600.0, False, False),
     (None, False, False), (None, True, True)],
)  # fmt: skip
def test_the_motion_at_work_is_followed_past_the_loss_or_on_a_seat(monkeypatch, first, seat, moved):
    monkeypatch.setattr(
        detach, "motion_past",
        lambda system, rpm, settings: Made(rpm=rpm, settings=settings, cost=Cost(1, 2, 4)),
    )  # fmt: skip
    monkeypatch.setattr(detach, "replace", lambda found, **more: Made(**{**vars(found), **more}))
    machine = Made(system=Made(has_seat=seat), settings="so")
    at = None if first is None else Made(rpm=first)
    found = Made(detachment=Made(first=at), at_work=None, cost=Cost(10, 30, 50))
    found = detach._moved_at_work(machine, found, 600.0)
    if moved:
        assert (found.at_work.rpm, found.at_work.settings) == (600.0, "so")
        assert found.cost == Cost(11, 32, 54)
    else:
        assert (found.at_work, found.cost) == (None, Cost(10, 30, 50))
    asked = detach._moved_as_asked(machine, found, 640.0)
    assert (asked.at_asked.rpm, asked.at_work) == (640.0, found.at_work)
    assert [b - a for a, b in zip(found.cost, asked.cost, strict=True)] == [1, 2, 4]


def test_the_contact_of_cam_and_follower(monkeypatch):
    """Under a rocker the lobe lifts so many times less: the radius where c = 0 is the lobe's."""
    monkeypatch.setattr(detach, "lift_range", lambda cam: (0.003, 0.012))
    contact = Made(width=0.01, modulus=2e11, follower_radius=0.004, base_radius=0.02)
    cam = Made(base_radius=0.03)
    machine = Made(scene=Made(contact=contact, cam=cam), system=Made(cam=None, rocker_ratio=2.0,
                   lash=0.001))  # fmt: skip
    hertz = detach._hertz(machine)
    radius = 0.02 - 0.001  # (3 mm - 1 mm of lash) / 2 lie between them
    assert vars(hertz) == vars(Hertz(0.01, 2e11, pytest.approx(radius), 0.004, 2.0))
    contact.base_radius = None
    assert detach._hertz(machine).base == pytest.approx(0.03 - 0.001)
    contact.width = None
    assert detach._hertz(machine) is None


# --- basins


def test_rests_attractors_and_cells_of_basins():
    """The number of an attractor stays from speed to speed, its place in the lists does not."""
    orbits_end = {basins.SETTLED: "P(2;inf:1)", basins.CYCLE: "P(2;inf:1)"}
    for kind, label in (*orbits_end.items(), ("open", None)):
        end = Made(kind=kind, holds_for="last-digit", symbols=(1.0, inf))
        told = basins._rest(radians(35.0), end)
        assert told == {
            "departure_deg": pytest.approx(35.0), "ends": kind, "holds_for": "last-digit",
            "label": label,
        }  # fmt: skip
    region = Made(
        radius=0.125, shrink=0.75, returns=True,
        half_widths=lambda: np.array([[0.5, 0.25], [0.0625, 2.0]]),
    )  # fmt: skip
    attractors = [
        Made(label="P(1;1)", turns=1, states=[(0.5, 0.25)], multipliers=None),
        Made(label="P(2;1:1)", turns=2, states=[(0.1, 0.2), (0.3, 0.4)], multipliers=(0.5, -0.25)),
    ]
    found = Made(
        value=0.75, rpm=RPM, attractors=attractors, regions=[None, region], branches=[7, 4],
        fractions={1: (0.25, 0.01), 2: (0.5, 0.02), 0: (0.125, 0.03), -4: (0.0625, 0.04)},
        stays=[31, 57], exponents=None, turns=(3.0, 20.0, 90.0), cells=200, computed=50,
        undecided=11, rests=[], troubled={4: 9}, entropies={"basin_entropy": 0.4}, saddles=[
            Made(orbit=orbit(), led=5, tried=8), Made(orbit=orbit(label="P(1;1)"), led=2, tried=3),
        ],
        uncertainty=Made(exponent=0.8, error=0.05, dimension=1.2, rows=6),
    )  # fmt: skip
    first, second = (basins._attractor(found, k) for k in (0, 1))
    assert first == {
        "attractor": 7, "label": "P(1;1)", "turns": 1, "multipliers": [],
        "states_q_m_v_m_per_s": [[0.5, pytest.approx(0.25 * OMEGA)]], "fraction": 0.25,
        "standard_error": 0.01, "turns_in_boxes": 31,
    }  # fmt: skip
    assert second == {
        "attractor": 4, "label": "P(2;1:1)", "turns": 2, "multipliers": [0.5, -0.25],
        "states_q_m_v_m_per_s": [[0.1, pytest.approx(0.2 * OMEGA)],
                                 [0.3, pytest.approx(0.4 * OMEGA)]],
        "fraction": 0.5, "standard_error": 0.02, "ellipse_radius_over_size": 0.125,
        "form_shrinks_by": 0.75, "ring_of_starts_returns": True,
        "half_widths_q_m_v_m_per_s": [[0.5, pytest.approx(0.25 * OMEGA)],
                                      [0.0625, pytest.approx(2.0 * OMEGA)]],
    }  # fmt: skip
    record = basins._record(found, None)
    assert record == {
        "value": 0.75, "rpm": RPM, "attractors": [first, second], "cells": 200, "computed": 50,
        "computed_share": 0.25, "undecided": 11, "rests": [],
        "troubled": {Status(4).text: 9}, "basin_entropy": 0.4,
        "turns_per_cell": {"median": 3.0, "percentile_99": 20.0, "most": 90.0},
        "saddles": [{"label": "P(2;1:1)", "led": 5, "tried": 8},
                    {"label": "P(1;1)", "led": 2, "tried": 3}],
        "uncertainty": {"exponent": 0.8, "standard_error": 0.05, "boundary_dimension": 1.2,
                        "error_share_count": 6},
    }  # fmt: skip
    found.regions[1] = None
    assert basins._attractor(found, 1)["turns_in_boxes"] == 57
    found.regions[1] = region
    found.saddles = found.uncertainty = None
    record |= {"saddles": [], "uncertainty": None}
    assert basins._record(found, None) == record
    summary = basins._summary(Made(speeds=[found, found]), Made(budget=77))
    assert (summary["budget_turns"], summary["speeds"]) == (77, [record, record])


def test_rows_of_cells_have_the_number_that_stays():
    """Blocks of basins.csv of whole grids: line by line of v, the varied value where it belongs."""
    window = basins.Window((0.0, 3.0), (10.0, 14.0), 3, 2)
    codes = np.array([[1, 2, 0], [-1, -4, 2]])
    grids = [Made(window=window, codes=codes, level=None, branches=[7, 4], value=value)
             for value in (0.5, 0.75)]  # fmt: skip
    lines = [(11.0, [7, 4, 0]), (13.0, [-1, -4, 4])]

    def plain(blocks):
        return [[np.asarray(one).tolist() for one in block] for block in blocks]

    q = [0.5, 1.5, 2.5]
    alone = [[q, v, numbers] for v, numbers in lines]
    assert plain(basins._cell_blocks(grids[:1], 0, "rpm")) == alone
    assert plain(basins._cell_blocks(grids, 0, "rpm")) == [
        [*line, value] for value in (0.5, 0.75) for line in alone
    ]
    assert plain(basins._cell_blocks(grids, 0, "run.x")) == [
        [value, *line] for value in (0.5, 0.75) for line in alone
    ]
    # a refined grid of 2 x 4 finest cells: a whole cell, and another one that was cut in four
    fine = basins.Window((0.0, 2.0), (10.0, 14.0), 2, 4)
    level = np.array([[0, 0], [0, 0], [1, 1], [1, 1]])
    codes = np.array([[2, 2], [2, 2], [1, 0], [-1, 1]])
    cut = Made(window=fine, codes=codes, level=level, branches=[7, 4], value=0.5)
    (block,) = plain(basins._cell_blocks([cut], 1, "rpm"))
    rows = sorted(zip(*block, strict=True))
    assert rows == [
        (0.5, 12.5, 7), (0.5, 13.5, -1), (1.0, 11.0, 4), (1.5, 12.5, 0), (1.5, 13.5, 7)
    ]  # fmt: skip


def test_rows_of_saddles_and_columns_of_growth():
    saddle = Made(orbit=orbit(), led=5, tried=8)
    study = Made(speeds=[Made(value=0.75, rpm=RPM, saddles=[saddle]), Made(saddles=None)])
    (row,) = basins._saddle_rows(study)
    head = [0.75, "P(2;1:1)", 0.125, pytest.approx(0.0625 * OMEGA)]
    assert [*row] == [*head, 0.5, 0.0, -0.25, 0.0, 5, 8]
    exponents = Made(
        exponents=[0.25, -0.5], attractors=[Made(multipliers=None), Made(multipliers=(0.5, -0.25))]
    )
    assert basins._growth(exponents, 0) == [None] * 4 + [0.25]
    assert basins._growth(exponents, 1) == [0.5, 0.0, -0.25, 0.0, -0.5]
    assert basins._growth(exponents, None) == [None] * 5
    assert basins._growth(Made(exponents=None), 1) == []


# --- sweep and classify


def motion(value, label, **more):
    own = {
        "value": value, "rpm": 2.0 * value, "label": label, "status": Status.OK, "exponent": None,
        "exponent_error": None, "holds_for": "", "watched": None, "impact_count": None,
        "loads": "l",
    }  # fmt: skip
    return Made(**{**own, **more})


def test_ranges_and_rows_of_a_sweep(monkeypatch):
    """A range ends where label, status or the way changes; its exponents are those known."""
    bare = [
        motion(1.0, "P(1;1)", exponent=-0.5, exponent_error=0.25, holds_for="last-digit"),
        motion(1.5, "P(1;1)"),
        motion(2.0, "P(1;1)", status=Status.NO_RETURN, exponent=0.5, holds_for="last-digit"),
        motion(2.5, "undecided", holds_for="rounding"),
        motion(2.5, "undecided"),
        motion(2.25, "undecided"),
    ]
    ways = [("up",)] * 4 + [("down",)] * 2
    found = Made(bare=bare, ways=ways, way_names=["direction"], direction="both")
    none = Status.NO_RETURN.text
    told = [
        (one.label, one.status, one.way, one.first, one.last, one.speeds, one.exponents)
        for one in sweep.ranges(found)
    ]
    assert told == [
        ("P(1;1)", "ok", ("up",), 1.0, 1.5, 2, ((-0.5, 0.25),)),
        ("P(1;1)", none, ("up",), 2.0, 2.0, 1, ((0.5, 0.0),)),
        ("undecided", "ok", ("up",), 2.5, 2.5, 1, ()),
        ("undecided", "ok", ("down",), 2.5, 2.25, 2, ()),
    ]
    summary = sweep._summary(found)
    assert (summary["direction"], summary["undecided"]) == ("both", 3)
    assert summary["holds_for"] == {"last-digit": 2, "rounding": 1}
    assert summary["ranges"][0] == {
        "label": "P(1;1)", "status": "ok", "from_rpm": 1.0, "to_rpm": 1.5, "speeds": 2,
        "direction": "up",
    }  # fmt: skip

    monkeypatch.setattr(sweep, "load_row", lambda loads: [f"load {loads}"])
    monkeypatch.setattr(sweep, "seat_row", lambda loads: [f"seat {loads}"])
    lines = [
        [motion(1.0, Label.parse("P(3;3:2:1)"), impact_count=6, exponent=0.5, exponent_error=0.25,
                holds_for="last-digit", watched=40)],
        [motion(2.0, "contact", impact_count=0), motion(3.0, "aperiodic", loads="m")],
    ]  # fmt: skip
    for seat in (False, True):
        rows = [[*row] for row in sweep._map_rows(Made(second=[0.1, 0.2], lines=lines), 4, seat)]
        ends = [[f"seat {name}"] if seat else [] for name in "llm"]
        first = [1.0, 0.1, "P(3;3:2:1)", 3, 1.5, 0.5, "load l", "ok", "last-digit", 40, 0.25]
        others = ["ok", "", None, None]
        assert rows == [
            [*first, *ends[0]],
            [2.0, 0.2, "contact", 1, 0.0, None, "load l", *others, *ends[1]],
            [3.0, 0.2, "aperiodic", None, None, None, "load m", *others, *ends[2]],
        ]


def test_a_classified_motion_in_its_row_and_its_entry():
    exponents = Made(largest=0.5, second=-0.25, spread=0.125, rule=0.0625, defect=0.03)
    start = Made(q=0.1, v=0.2, theta=radians(35.0), place="run.start")
    whole = {
        "value": 1.5, "rpm": RPM, "label": "P(2;1:1)", "period": 2, "impacts": 1.25, "chatter":
        "none", "stable": True, "status": Status.NO_RETURN, "holds_for": "last-digit",
        "watched": 40, "fault": None, "transient": 17, "start": start, "chatters": 3,
        "record": Made(periods=100), "orbit": Made(multipliers=(0.5, -0.25)),
        "exponents": exponents,
    }  # fmt: skip
    status = Status.NO_RETURN.text
    row = (1.5, "P(2;1:1)", 2, 1.25, "none", 1, 0.5, status, "last-digit", 40, 0.125)
    assert classify._row(Made(**whole)) == row
    lost = Made(**{**whole, "fault": "x", "stable": None, "exponents": None})
    assert classify._row(lost) == (
        1.5, "P(2;1:1)", 2, None, "none", None, None, status, "last-digit", 40, None
    )  # fmt: skip
    assert classify._row(Made(**{**whole, "stable": False}))[5] == 0
    entry = {
        "value": 1.5, "rpm": RPM, "label": "P(2;1:1)", "period": 2, "impacts": 1.25,
        "chatter": "none", "stable": True, "transient_turns": 17, "status": status,
        "start": {"q": 0.1, "v": 0.2, "theta_deg": pytest.approx(35.0), "place": "run.start"},
        "holds_for": "last-digit", "watched_turns": 40, "turns": 100, "complete_chatters": 3,
        "multipliers": (0.5, -0.25), "exponents": {
            "largest": 0.5, "second": -0.25, "standard_error": 0.125, "sum_rule": 0.0625,
            "defect": 0.03,
        },
    }  # fmt: skip
    assert classify._motion_record(Made(**whole)) == entry
    bare = Made(**{**whole, "exponents": None, "orbit": None})
    assert classify._motion_record(bare) == {**entry, "exponents": None, "multipliers": None}


# --- simulate --profile-only


@pytest.mark.parametrize("lash", [0.0, 0.001])
def test_rows_of_a_profile(lash):
    """N = k q + b q' + m q'' + m g + F0; with lash q = c - lash, or the seat, at rest, above it."""
    follower = Made(mass=2.0, gravity=9.5, preload=30.0, stiffness=400.0, damping=5.0)
    system = Made(follower=follower, lash=lash, lift_range=(0.0005, 0.01))
    profile = Made(
        theta=[radians(10.0), radians(35.0)], c=[0.0012, 0.008], c1=[0.003, -0.004],
        c2=[0.02, 0.05], c3=[0.7, 0.9], ranges={"c": (Made(value=0.0001), Made(value=0.009))},
        lobe=None,
    )  # fmt: skip
    rows = [*simulate._profile_rows(profile, system, RPM)]
    standing = 2.0 * 9.5 + 30.0
    forces = [standing + 400.0 * (c - lash) + 5.0 * OMEGA * c1 + 2.0 * OMEGA**2 * c2
              for c, c1, c2 in zip(profile.c, profile.c1, profile.c2, strict=True)]  # fmt: skip
    if lash:
        forces[0] = standing + 400.0 * 0.0005  # the cam lies below the seat
    rad = pi / 180.0
    for k, (row, force) in enumerate(zip(rows, forces, strict=True)):
        c, c1, c2, c3 = profile.c[k], profile.c1[k], profile.c2[k], profile.c3[k]
        per_degree = [1e3 * (c - 0.0001), 1e3 * c1 * rad, 1e3 * c2 * rad**2, 1e3 * c3 * rad**3]
        assert row == pytest.approx(
            [degrees(profile.theta[k]), c, c1, c2, force, c3, *per_degree], rel=1e-12
        )
    touch = Made(radius=0.02, beside=0.003, angle=radians(20.0))
    assert simulate._of_lobe("flat", touch) == (0.02, 0.003)
    assert simulate._of_lobe("roller", touch) == (0.02, pytest.approx(20.0))


@pytest.mark.parametrize("face", ["flat", "knife", "roller"])
def test_the_entry_of_a_lobe(face):
    """Angles of a tip or a roller, the eccentricity of a flat face; null for what is not there."""

    def found(value, deg):
        return Made(value=value, theta=radians(deg))

    def at(value, deg):
        return {"value": value, "theta_deg": pytest.approx(deg)}

    lobe = Made(
        face=face, base=0.02, roller=0.004, least=found(inf, 10.0), undercut=True,
        hollow=found(0.05, 20.0), largest_roller=None, least_base=0.03, closing=1e-9,
        beside=(found(-0.25, 35.0), found(0.5, 70.0)),
    )  # fmt: skip
    if face == "flat":
        names, scale = ("least_eccentricity_m", "largest_eccentricity_m"), 1.0
    else:
        names, scale = ("least_pressure_angle_deg", "largest_pressure_angle_deg"), 180.0 / pi
    values = (pytest.approx(-0.25 * scale), pytest.approx(0.5 * scale))
    assert simulate._lobe_summary(lobe) == {
        "face": face, "base_radius_m": 0.02, "least_radius_m": at(None, 10.0), "undercut": True,
        "roller_radius_m": 0.004 if face == "roller" else None, "sharpest_hollow_m": at(0.05, 20.0),
        "largest_roller_m": None, "least_base_radius_m": 0.03, "closing_m": 1e-9,
        names[0]: at(values[0], 35.0), names[1]: at(values[1], 70.0),
    }  # fmt: skip


@pytest.mark.parametrize("measured", [False, True])
def test_the_summary_of_a_profile(measured):
    """Of a measured cam its jerk is a guess with a bound; without a base circle no curvature."""

    def extreme(value, deg):
        return Made(value=value, theta=radians(deg))

    def at(value, deg):
        return {"value": value, "theta_deg": pytest.approx(deg)}

    errors = Made(jerk=Made(bounds=(0.5, 2.5, 1.5)))
    cam = Made(kind="table" if measured else "arcs", errors=errors)
    curvature = Made(
        base_radius=0.02, flat_least=extreme(0.01, 20.0), undercut=False, least_base_radius=0.015,
        roller=extreme(0.006, 30.0),
    )  # fmt: skip
    profile = Made(
        force=Made(rpm=RPM, lowest_n=-2.5, lowest_theta=radians(155.5)), curvature=curvature,
        first=speed(), corners={"a": radians(10.0), "b": radians(35.0)}, lobe=None,
        ranges={"c": (extreme(0.001, 40.0), extreme(0.009, 50.0))},
    )  # fmt: skip
    told = simulate._profile_summary(profile, 1.5, cam)
    (lift,) = told.pop("ranges").items()
    assert lift == ("c (m)", [at(0.001, 40.0), at(0.009, 50.0)])
    assert told.pop("assumed")
    assert bool(told.pop("jerk_unknown")) is measured
    corners = {"a": pytest.approx(10.0), "b": pytest.approx(35.0)}
    wanted = {
        "rpm": RPM, "corners_deg": corners, "least_force_n": at(-2.5, 155.5),
        "first_detachment_rpm": RPM, "first_detachment_between_rpm": [599.0, 602.0],
        "base_radius_m": 0.02, "largest_roller_radius_m": at(0.006, 30.0), "rocker_ratio": 1.5,
        "flat_faced": {"least_radius_m": at(0.01, 20.0), "undercut": False,
                       "least_base_radius_m": 0.015},
        "jerk_infinite_deg": None if measured else [*corners.values()],
        "jerk_error_m_per_rad3": 2.5 if measured else None,
    }  # fmt: skip
    assert told == wanted
    curvature.base_radius = curvature.roller = None
    profile.first = speed(rpm=inf, low=inf, high=inf, finite=False)
    told = simulate._profile_summary(profile, 1.5, cam)
    assert (told["first_detachment_rpm"], told["largest_roller_radius_m"]) == (None, None)
    assert told["first_detachment_between_rpm"] == [inf, inf]
    assert told["flat_faced"] == {
        "least_radius_m": None, "undercut": None, "least_base_radius_m": 0.015
    }  # fmt: skip
    profile.first = None
    told = simulate._profile_summary(profile, 1.5, cam)
    assert (told["first_detachment_rpm"], told["first_detachment_between_rpm"]) == (None, None)


def test_the_base_circle_that_is_typed_comes_before_those_of_contact_and_cam():
    """The scene's own cam has the one of --base-radius; others without one have the first known."""

    def cam(radius):
        return Made(base_radius=radius)

    def runner(typed, of_contact, of_cam):
        contact = Made(face="roller", base_radius=of_contact, follower_radius=0.004)
        scene = Made(contact=contact, simulate=Made(base_radius=typed))
        return simulate._runner(scene, of_cam)

    assert runner(0.01, 0.02, 0.03).base == 0.01
    assert runner(None, 0.02, 0.03).base == 0.02
    found = runner(None, None, 0.03)
    assert (found.base, found.face, found.roller) == (0.03, "roller", 0.004)
    assert simulate._runner(Made(contact=None), 0.03) is None
    assert simulate._runner(Made(contact=Made(face=None)), 0.03) is None
