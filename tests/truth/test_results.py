"""Every field of the results that analyses return, recomputed by other means.

Tables and pictures show only part of a result; the rest decides what is said and done next. The
checks of a kind of result name all of its fields, so a new field without a check is a failure, and
so is a kind of result that an analysis returns and that has no checks here.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace
from functools import cache
from math import inf, log, radians
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import camcli
from camcli.analysis.classify import classify_at
from camcli.analysis.contact_loss.bursts import LiftOffKind
from camcli.analysis.contact_loss.detachment import SpeedStatus
from camcli.analysis.contact_loss.hold import HoldStatus, Obstacle
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.sticking_orbits import _settled_on
from camcli.analysis.orbits.study import _reach
from camcli.api.machine import machine_of
from camcli.errors import Status
from camcli.kernel.certify import Verdict
from tests.conftest import chapter_system, settings
from tests.support import orbit_oracle
from tests.support.mechanics import RAD, TURN, Machine
from tests.support.motion import Motion
from tests.support.orbits import multipliers
from tests.truth.test_columns import label_of, motion_of, region_at, same, scene_at

pytestmark = pytest.mark.slow
DETACH = {"rpm": {"start": 650.0, "stop": 1000.0, "num": 4}, "hold_to": 1500.0, "margin_n": 7.0,
          "impacts": 3, "settle": 3}  # fmt: skip
SPEEDS = (860.0, 1500.0, 1912.0, 2300.0, 2700.0)
TURNS = {1912.0: 3, 2300.0: 2}  # of the orbits there; else 1
ELSEWHERE = {  # kinds of results whose fields are columns, and are judged with these
    "Loss": "test_columns.critical_speeds", "Region": "test_columns.regions_of",
    "Detachment": "test_columns.critical_speeds", "Speed": "test_columns.of_sweep",
    "Record": "analysis/test_loads, kernel", "Root": "properties/test_branches",
    "Loads": "test_load_columns",
}  # fmt: skip


def every_field(one: Any, wanted: dict[str, Any], where: str, close: float = 1e-9) -> None:
    """Each field of a dataclass against its value or a check of it; none may be left out."""
    names = [field.name for field in fields(one)]
    assert sorted(names) == sorted(wanted), f"{where}: fields and checks differ"
    for name, value in wanted.items():
        same(getattr(one, name), value, f"{where}.{name}", close)


def kinds_in(value: Any) -> set[str]:
    """Names of the dataclasses in a result."""
    if is_dataclass(value):
        inner = (getattr(value, field.name) for field in fields(value))
        return {type(value).__name__}.union(*map(kinds_in, inner))
    return set().union(*map(kinds_in, value)) if isinstance(value, list | tuple) else set()


def near(angle: float, off: float = 1e-7) -> Any:
    """A check that an angle is this one but for whole turns (rad)."""
    return lambda found: abs((found - angle + np.pi) % TURN - np.pi) < off


@cache
def lost_contact() -> Any:
    return camcli.detach(camcli.load_scene(scene_at(900.0, detach=DETACH))).values


@cache
def motions() -> list[Any]:
    """What classify finds at SPEEDS, and the scene of each."""
    found = []
    for rpm in SPEEDS:
        one = {"rpm": {"start": rpm, "stop": rpm, "num": 1}, "starts": 0}
        settles = 200 if rpm == 1912.0 else 40
        scene = scene_at(rpm, run={"transient": settles, "record": 20}, classify=one)
        found.append((camcli.classify(camcli.load_scene(scene)).values[0][0], scene))
    return found


def test_every_kind_of_result_has_its_checks():
    here = {"ContactLoss", "CriticalSpeed", "LiftOff", "SettledMotion", "SettledBurst", "Hold",
            "ForceCurve", "Cost", "ClassifiedMotion", "PeriodicOrbit", "Exponents", "Start",
            }  # fmt: skip
    seen = kinds_in(lost_contact()).union(*(kinds_in(motion) for motion, _ in motions()))
    assert seen <= here | set(ELSEWHERE), seen - here - set(ELSEWHERE)


# -- contact that is lost -------------------------------------------------------------------------


def first_burst(rpm: float, begins_in: str) -> tuple[float, float, float]:
    """(release, first landing, end of the chatter) of the first burst from rest there, rad."""
    scene = scene_at(rpm, run={"transient": 0, "record": 2})
    events = motion_of(scene).events
    machine = Machine.of(scene)
    for k, event in enumerate(events):
        if event.kind == "detachment" and region_at(machine, event.theta) == begins_in:
            landing = next(e.theta for e in events[k:] if e.kind == "impact")
            end = next((e.theta for e in events[k:] if e.kind == "chatter"), inf)
            return event.theta, landing, end
    raise AssertionError


def test_lift_off_is_the_first_burst_above_the_speed_that_opens():
    """So small a burst has a closed form: the force is a parabola, or a line up to a corner."""
    found = lost_contact()
    opens = {loss.region.name: loss.opens for loss in found.detachment.losses}
    assert [one.region for one in found.lift_offs] == ["A1", "A2"]
    for one in found.lift_offs:
        place = opens[one.region].theta
        machine = Machine.of(scene_at(opens[one.region].rpm * (1.0 + 1e-6)))
        ends = place - 0.01, place - 1e-12
        release = brentq(lambda x, own=machine: own.force(x, -1)[0], *ends, xtol=1e-15)
        d = place - release
        if one.region == "A2":  # K (x - a)(b - x) from a on, 2 d wide: back after twice that
            landing, kind, corner = release + 4.0 * d, LiftOffKind.WITHIN, ""
        else:  # the gap is K d^3/6 with the rate K d^2/2 at the corner; behind it J presses
            growth = -machine.force(place - 1e-12, -1)[0] / d
            pressed = machine.force(place, 1)[0]
            height, rate = growth * d**3 / 6.0, growth * d**2 / 2.0
            s = (rate + np.sqrt(rate**2 + 2.0 * pressed * height)) / pressed
            landing, kind, corner = place + s, LiftOffKind.CAUGHT, "b"
        every_field(one, {
            "region": lambda name: name in opens, "rpm": machine.rpm, "kind": kind,
            "corner": corner, "release": near(release, 1e-3 * d),
            "landing": near(landing, 1e-2 * (landing - max(place, release))),
            "rest": lambda x, one=one, d=d: one.landing < x < one.landing + 10.0 * d,
        }, one.region)  # fmt: skip


@pytest.mark.ci
def test_a_speed_that_was_looked_at_has_the_bursts_of_one_turn():
    found = lost_contact()
    rpms = np.linspace(650.0, 1000.0, 4)
    for one, rpm in zip(found.speeds, rpms, strict=True):
        scene = scene_at(rpm, run={"transient": DETACH["settle"], "record": 2})
        machine, events = Machine.of(scene), motion_of(scene).events
        begin = TURN * DETACH["settle"]
        inside = [event for event in events if begin <= event.at < begin + TURN]
        phases = [event.theta for event in inside if event.kind == "impact"]
        ends = [event.theta for event in events if event.kind == "chatter" and event.at >= begin]
        released = [event.theta for event in inside if event.kind == "detachment"]
        rests = [event.theta for event in inside if event.kind == "chatter"]
        every_field(one, {
            "rpm": rpm,
            # only the softest before the end of a chatter are closed by its map
            "impacts": lambda found, phases=phases, ends=ends: (
                len(phases) - 60 * len(ends) <= len(found)
            ) and all(np.abs(np.subtract(phases, x)).min() < 1e-6 for x in found),
            "bursts": lambda found, released=released: len(found) == len(released),
            "rests": lambda found, rests=rests: found == pytest.approx(rests, abs=1e-7),
            "status": Status.OK,
            "cost": lambda cost, phases=phases: (cost.evaluations > 0) == bool(phases),
        }, f"{rpm} rpm")  # fmt: skip
        for burst, release, end in zip(one.bursts, released, ends, strict=False):
            every_field(burst, {"region": region_at(machine, release), "end": near(end)}, "burst")
        total = sum(event.kind == "impact" for event in events)
        assert total - 60 * len(ends) * 5 <= one.cost.impacts <= total
        assert one.cost.impacts >= 5 * len(one.impacts)  # of all turns, and not of one alone


def test_forces_and_springs_are_those_of_the_machine():
    found = lost_contact()
    machine = Machine.of(scene_at(900.0))
    by = {str(hold.quantity): hold for hold in found.holds}
    assert found.margin == DETACH["margin_n"]
    curves = [(None, curve) for curve in found.forces] + list(found.springs)
    assert len(found.springs) == 3  # the present one, and two that hold
    for hold, curve in curves:
        changes = {} if hold is None else {"stiffness": hold.stiffness, "preload": hold.preload}
        own = Machine(**{**vars_of(machine), "rpm": curve.rpm, **changes})
        least = own.extreme_force(0.0, TURN, -1)
        theta = np.array(curve.theta)
        inner = np.array([not own.is_edge(x) for x in theta])
        every_field(curve, {
            "rpm": lambda rpm, hold=hold: rpm == DETACH["hold_to"] if hold else rpm > 0.0,
            "theta": lambda x: x[0] == 0.0 and abs(x[-1] - TURN) < 1e-12,
            "force_n": lambda x, own=own, theta=theta, inner=inner: np.allclose(
                np.array(x)[inner], own.force(theta[inner]), rtol=1e-9, atol=1e-9),
            "lowest_n": lambda x, own=own: abs(x - own.extreme_force(0.0, TURN, -1)[0]) < 1e-6,
            "lowest_theta": lambda x, own=own, least=least: own.force(x)[0] < least[0] + 1e-6
            or own.force(x, -1)[0] < least[0] + 1e-6,
            "pressure_pa": [],
        }, "curve")  # fmt: skip
    highest = machine.lift.range[1]
    present = machine.stiffness * highest + machine.preload
    for name in ("hold_preload", "hold_both"):
        hold = by[name]
        own = Machine(**{**vars_of(machine), "stiffness": hold.stiffness, "preload": hold.preload})
        fast = Machine(**{**vars_of(own), "rpm": DETACH["hold_to"]})
        nose = hold.stiffness * highest + hold.preload
        assert nose < 20.0 * present
        every_field(hold, {
            "quantity": lambda x, name=name: str(x) == name, "status": HoldStatus.OK,
            "stiffness": lambda x: x >= machine.stiffness, "preload": lambda x: x > 0.0,
            "region": lambda x, own=own, hold=hold: x == region_at(own, hold.theta),
            "theta": lambda x, fast=fast: abs(fast.force(x)[0] - DETACH["margin_n"]) < 1e-6,
            "detaches": own.first_loss(), "least_n": fast.extreme_force(0.0, TURN, -1)[0],
            "obstacle": None, "missing_n": None, "nose_n": nose,
            "more": True,
            "low": lambda x, hold=hold: hold.detaches * (1 - 1e-11) < x <= hold.detaches,
            "high": lambda x, hold=hold: hold.detaches <= x < hold.detaches * (1 + 1e-11),
        }, name)  # fmt: skip
    # no stiffness alone: below zero lift a stiffer spring would pull
    assert machine.lift.range[0] < 0.0
    every_field(by["hold_stiffness"], {
        "quantity": lambda x: str(x) == "hold_stiffness", "status": HoldStatus.IMPOSSIBLE,
        "stiffness": None, "preload": None, "region": "A2", "obstacle": Obstacle.PULL,
        "theta": lambda x: machine.lift.at(x)[0][0] < 0.0, "detaches": None, "least_n": None,
        "missing_n": 0.0, "nose_n": None, "more": True, "low": None, "high": None,
    }, "hold_stiffness")  # fmt: skip


def vars_of(machine: Machine) -> dict[str, Any]:
    return {field.name: getattr(machine, field.name) for field in fields(machine)}


def test_a_chatter_that_ends_at_a_corner_does_so_at_its_speed():
    (one,) = lost_contact().ends
    assert one.status is SpeedStatus.OK
    ends = [first_burst(rpm, one.burst)[2] for rpm in (one.low * (1 - 1e-9), one.high * (1 + 1e-9))]
    goal = 40.0 * RAD  # where the rise begins
    assert near(goal, 1e-3)(ends[0])
    assert (ends[0] - goal + np.pi) % TURN - np.pi < 0.0  # it comes up from before
    every_field(one, {
        "quantity": lambda x: str(x) == "accumulation_at_corner", "region": "a", "burst": "A2",
        "theta": goal, "rpm": lambda x: one.low <= x <= one.high, "status": SpeedStatus.OK,
        "low": lambda x: x > 0.0, "high": lambda x: x - one.low < 1e-11 * x,
    }, "accumulation")  # fmt: skip


# -- motions that are named -----------------------------------------------------------------------


@pytest.mark.parametrize("k", range(len(SPEEDS)), ids=map(str, SPEEDS))
def test_a_classified_motion(k):
    found, scene = motions()[k]
    rpm, run = SPEEDS[k], scene["run"]
    motion = motion_of(scene)
    label = label_of(motion, run["transient"], run["record"])
    turns = int(label[2 : label.index(";")])
    assert turns == TURNS.get(rpm, 1)
    begin = TURN * (run["transient"] + run["record"] - turns)
    last = [event for event in motion.events if event.at >= begin]
    rests = any(event.kind == "chatter" for event in last)
    impacts = inf if rests else sum(event.kind == "impact" for event in last)
    machine, omega = motion.machine, motion.machine.omega
    states = np.array([motion.state(TURN * n)[:2] for n in range(run["transient"])])
    ends = np.array([motion.state(begin + TURN * n)[:2] for n in range(turns)])
    size = np.abs(ends).max(0)
    away = np.array([min(np.abs((state - end) / size).max() for end in ends) for state in states])

    def reached(turn: int) -> bool:
        """It is at its orbit from this turn on, and was not at the one before."""
        return away[turn:].max() < 1e-3 and (turn == 0 or away[turn - 1] > 1e-12)

    every_field(found, {
        "value": rpm, "rpm": rpm, "start": lambda x: (x.q, x.v, x.theta) == (None, None, 0.0),
        "label": lambda x: str(x) == label, "orbit": lambda x: x is not None,
        "exponents": lambda x: x is not None, "impacts": impacts,
        "chatter": "complete" if rests else "none", "transient": reached, "status": Status.OK,
        "cost": lambda x: x.impacts >= len(last) and x.evaluations > 0,
        "record": lambda x: x.periods >= run["record"], "holds_for": None, "watched": None,
        "fault": None,
    }, str(rpm))  # fmt: skip

    orbit, period = found.orbit, turns
    q, w = orbit.states[0]
    own = Motion(machine, period, machine.strobe / RAD, q, w * omega)
    if rests:  # the start of a resting orbit is on the cam
        own = Motion(machine, period, machine.strobe / RAD)
    kind = "detachment" if rests else "impact"
    events = [event for event in own.events if event.kind == kind]
    symbols = label[2:-1].partition(";")[2].split(":")
    matrix = multipliers(machine, own, period)
    every_field(orbit, {
        "rpm": rpm, "value": rpm, "turns": period, "symbols": [float(s) for s in symbols],
        "states": [[x[0], x[1] / omega] for x in (own.state(TURN * n) for n in range(period))],
        "theta": [event.theta for event in events],
        "rates": [] if rests else [event.u_minus / omega for event in events],
        "regions": [region_at(machine, event.theta) for event in events],
        "trace": np.trace(matrix), "det": np.linalg.det(matrix), "verdict": Verdict.ADMISSIBLE,
        "resting": rests, "root": lambda x: (x is None) == rests,
    }, f"orbit at {rpm}", 1e-6)  # fmt: skip
    sizes = sorted((abs(z) for z in np.linalg.eigvals(matrix)), reverse=True)
    large, small = (log(x) / period if x else -inf for x in sizes)
    rule = -machine.damping / machine.mass * TURN / omega
    each = inf if rests else impacts / period
    every_field(found.exponents, {
        "largest": large, "second": small, "spread": 0.0,
        "rule": -inf if rests else rule + 2.0 * log(machine.restitution) * each, "impacts": each,
    }, f"exponents at {rpm}", 1e-6)  # fmt: skip


@pytest.mark.parametrize(("rpm", "turns"), [(1211.1, 8), (1211.0, 12), (1210.9, 25)])
def test_an_orbit_through_a_rest_is_found_again_however_many_turns_it_has(rpm, turns):
    """A run from it settles on it, beside its speed too: it is logged for more than two periods."""
    scene = scene_at(rpm, run={"transient": 9, "record": 2 * turns})
    system = machine_of(camcli.load_scene(scene)).system
    orbit = classify_at(system, rpm, settings(100, 60)).orbit
    label = orbit.label
    assert orbit.turns == turns
    if turns == 8:
        assert label_of(motion_of(scene), 9, 2 * turns) == label
    branch = Shooter(system, rpm)
    for value in (rpm, rpm + 1e-9):
        again = _settled_on(branch, settings(), orbit, value)
        assert (again.label, again.turns, again.value) == (label, turns, value)


@cache
def solved() -> Any:
    """Both orbits P(1;1) of the example at 705 rpm, and their branches over its upper speeds."""
    values = {"orbits.rpm": {"start": 690.0, "stop": 741.0, "num": 11}, "orbits.at": 705.0,
              "orbits.starts": 0}  # fmt: skip
    return camcli.orbits(camcli.load_scene(None, values)).values


@pytest.mark.parametrize("beyond", [-6.0, 6.0, -15.0, 30.0])
def test_a_branch_is_followed_to_the_side_of_the_speed_asked_for(beyond):
    """Both orbits are there all the way: one's phase rises with the speed, the other's falls."""
    assert [orbit.stable for orbit in solved().orbits] == [True, False]
    for orbit in solved().orbits:
        assert str(orbit.label) == "P(1;1)"
        away = tuple(-x for x in orbit.root.tangent)
        for root in (orbit.root, replace(orbit.root, tangent=away)):
            asked = chapter_system(), settings(), replace(orbit, root=root), 705.0 + beyond
            reached, end = _reach(*asked)
            assert (reached.value, end) == (705.0 + beyond, Kind.END_OF_RANGE)


def test_events_of_branches_are_the_oracles():
    """The doubling of the stable orbit, and the corner impact of the doubled one."""
    doubling = orbit_oracle.period_doubling_rpm(
        orbit_oracle.CAM, orbit_oracle.CHAPTER, orbit_oracle.STABLE, 1, 700, 745
    )
    events = {event.kind: event for event in solved().bifurcations}
    assert sorted(events) == [Kind.CORNER_IMPACT, Kind.PERIOD_DOUBLING]
    numbers = {branch.number: branch for branch in solved().branches}
    doubled = next(b for b in numbers.values() if b.points[-1].turns == 2)
    every_field(events[Kind.PERIOD_DOUBLING], {
        "branch": lambda n: numbers[n].points[0].stable and numbers[n].points[0].turns == 1,
        "kind": Kind.PERIOD_DOUBLING, "value": float(doubling.rpm),
        "error": lambda x: abs(events[Kind.PERIOD_DOUBLING].value - doubling.rpm) <= x < 1e-8,
        "status": Bracket.OK,
        "orbit": lambda x: abs(1.0 + x.trace + x.det) < 1e-9 and x.det == pytest.approx(0.64),
        "corner": "", "located": lambda x: x.kind == Kind.PERIOD_DOUBLING and x.fading is None,
        "corner_impact": None, "beyond": "", "continues": doubled.number,
    }, "doubling", 1e-12)  # fmt: skip
    corner = radians(160.0)  # c, where the nose's arc begins: one impact of the two is there
    every_field(events[Kind.CORNER_IMPACT], {
        "branch": doubled.number, "kind": Kind.CORNER_IMPACT, "value": 739.3779296493,
        "error": lambda x: 0.0 < x < 1e-8, "status": Bracket.OK,
        "orbit": lambda x: min(abs(theta - corner) for theta in x.theta) < 1e-9,
        "corner": "c", "located": lambda x: x.kind == Kind.CORNER_IMPACT,
        "corner_impact": lambda x: x.agrees in (True, None), "beyond": "", "continues": 0,
    }, "corner impact", 1e-12)  # fmt: skip
    assert doubled.origin == Kind.PERIOD_DOUBLING
    for branch in numbers.values():
        assert all(orbit.turns == branch.points[0].turns for orbit in branch.points)
