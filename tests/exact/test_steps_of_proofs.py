"""Steps of the proofs one by one, on orbits, machines and boxes that are made by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, exp, hypot, pi, sin, sqrt
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from flint import arb, ctx

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.integrate import BudgetSpentError
from camcli.analysis.orbits import (
    all_orbits,
    attraction,
    certificate,
    codim2,
    curve_proofs,
    proofs,
    starts,
)
from camcli.analysis.orbits.all_orbits import AllOrbits, Cover, Failure
from camcli.analysis.orbits.codim2 import Condition
from camcli.analysis.orbits.curve_proofs import CurveEvidence, CurveRange, OnCurve
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.proofs import Proof, Proofs, Range
from camcli.analysis.orbits.shooter import Root
from camcli.analysis.orbits.study import Branch
from camcli.cams.balls import UndecidedError
from camcli.cams.eccentric import EccentricCam
from camcli.exact.machine import BallMachine
from camcli.exact.phase_cover import Key
from camcli.exact.shooting import NotProvedError, Place, ProofStep, Touch
from camcli.kernel.certify import ADMISSIBLE
from camcli.system import Follower, System

TURN = 2.0 * pi


@pytest.fixture(autouse=True)
def eighty_bits():
    before, ctx.prec = ctx.prec, 80
    yield
    ctx.prec = before


def root_of(impacts, value=700.0, turns=1, parameter=0, machine=(700.0,), **more) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    given = {
        "rates": [-2.0 * v for _, v, _, _ in impacts],
        "tangent": [0.0] * len(x) + [1.0],
        "trace": 0.5,
        "step": 0.0,
        "steps": 2,
    }
    return Root([*x, value], whole, turns, machine, parameter, **{**given, **more})


# -- certificates


def located(kind: Kind, root: Root, **more) -> Located:
    return Located(kind, root, 0.0, 1e-9, Bracket.OK, **more)


@pytest.mark.parametrize("kind", Kind)
def test_only_a_corner_impact_is_told_with_its_impact_and_side(kind):
    event = certificate._event(located(kind, None, impact=2, side=-1))
    told = (2, -1) if kind == Kind.CORNER_IMPACT else (0, 0)
    assert event == {"event": kind.value, "impact": told[0], "side": told[1]}


@pytest.mark.parametrize("touched", [None, Place(4, 1)])
def test_the_flights_of_a_curve_are_those_of_its_machine(monkeypatch, touched):
    """Only the flight that grazes has a touch: its angle is the last unknown of the hull."""
    hull = ["theta 1", "v 1", "theta 2", "v 2", "theta 3", "v 3", "rpm", "mass", "angle"]
    flown = (Stub(n=3), ["the", "orbits"])
    asked = []
    condition = Stub(
        test=codim2.Test.GRAZE if touched else codim2.Test.FLIP, impact=1 if touched else -1, side=0
    )
    on = Stub(
        condition=condition, touched=touched, box="box of the curve",
        meeting=Stub(base="base", plane=Stub(names=("rpm", "mass"))),
        flown=lambda of: asked.append(of) or flown, values=lambda of: (arb(3), arb(4)),
    )  # fmt: skip
    monkeypatch.setattr(certificate, "_about", lambda *_: certificate.About(["rpm", "mass"], {}))
    monkeypatch.setattr(certificate, "_flights", lambda *of: [("all flights", of)])
    divided = lambda *of, touch: (of, touch)  # noqa: E731
    monkeypatch.setattr(certificate, "divided_flight", divided)

    def with_flights(evidence, box_at, flights_of):
        assert box_at == "box of the curve"
        return flights_of(hull), [Stub(hull=list), Stub(hull=list)]

    monkeypatch.setattr(certificate, "_with_flights", with_flights)
    monkeypatch.setattr(certificate, "_roomy", lambda box: box)
    monkeypatch.setattr(certificate, "_box", lambda box: "joint")
    part = Stub(evidence=Stub(on=on, boxes=(), bits=80))
    statement = certificate._curve_statement(part, "P(1;3)", 0.0)
    assert asked == [hull]
    if touched is None:
        assert statement["boxes"] == [("all flights", flown)]
        assert statement["event"] == {
            "event": "period-doubling",
            "impact": 0,
            "side": 0,
            "touch": None,
        }
    else:
        touches = [None, Touch(1, "angle"), None]
        assert statement["boxes"] == [((*flown, k), touches[k]) for k in range(3)]
        assert statement["event"] == {
            "event": "grazing", "impact": 1, "side": 0, "touch": {"stretch": 4, "turn": 1},
        }  # fmt: skip
    assert statement["joints"] == ["joint", "joint"]


# -- proofs of branches


def test_points_at_which_an_impact_passes_the_end_of_a_stretch_are_left_out():
    """The second impact passes from the stretch before 2 rad to the one behind; that is shifted
    with the machine. A point at an end whose neighbours are on the same stretches is kept."""

    def stretches_at(machine):
        shift = machine[0] - 700.0
        ends = (0.0, 2.0 + shift, 4.0, TURN)
        return Stub(cam=Stub(stretches=[Stub(start=a, end=b) for a, b in pairwise(ends)]))

    def point(theta, stretch, rpm=700.0):
        root = root_of([(0.5, 0.1, 0, 0), (theta, 0.2, stretch, 0)], rpm, machine=(rpm,))
        return Stub(root=root, value=rpm, label="P(1;2)", stable=True)

    inside = point(1.5, 0)
    before = point(701.0 - 700.0 + 2.0 - 0.9e-6, 0, 701.0)  # 0.9e-6 rad before its end
    behind = point(702.0 - 700.0 + 2.0 + 0.9e-6, 1, 702.0)
    far_behind = point(2.5, 1)
    almost = point(4.0 - 1.1e-6, 1)  # a little too far from its end to be at it
    almost_behind = point(4.0 + 1.1e-6, 2)
    at_an_end = point(TURN, 2)  # but not beside a passing
    resting = Stub(root=None, value=703.0)
    points = (
        inside, before, behind, far_behind, almost, almost_behind, point(5.0, 2), at_an_end,
        point(5.5, 2), resting,
    )  # fmt: skip
    branch = Branch(3, "found", points, ("lost", "fold"))
    found = proofs._off_the_ends(Stub(at=stretches_at), branch, [])
    kept = [one for one in points if one not in (before, behind)]
    assert list(found.points) == kept
    assert (found.number, found.ends) == (3, ("lost", "fold"))
    pairs = list(proofs._passings(branch, []))
    assert pairs == [(before, behind), (almost, almost_behind)]
    # an event at either point of the pair: there the impact passes a corner
    for one in (before, behind):
        event = Stub(value=one.value, located=Stub(root=one.root))
        assert list(proofs._passings(branch, [event])) == pairs[1:]
        assert before in proofs._off_the_ends(Stub(at=stretches_at), branch, [event]).points


def test_a_proof_without_its_evidence_says_the_same():
    """Orbits, events, curves, ranges and the parts of curves lose it; nothing else changes."""

    def proof(box):
        return Proof(ProofStep.GRAZES, box=(box,), value="[3 +/- 1]", evidence=f"of {box}")

    def part(number):
        return Range(number, "P(1;1)", True, "3", "4", 7, ProofStep.BOXES, f"of {number}")

    def of_curve(number):
        return CurveRange(number, 2, 5, ((1.0, 2.0), (3.0, 4.0)), 6, None, f"of {number}")

    whole = Proofs(
        orbits=[proof("a"), proof("b")], points=[[proof("c")], [proof("d"), proof("e")]],
        events=[proof("f"), proof("g")], ranges=[part(1), part(2)], flank_excess=0.25,
        curves=[[proof("h"), proof("i")], [proof("j")]], curve_ranges=[of_curve(1), of_curve(2)],
    )  # fmt: skip
    bare = whole.without_evidence()
    assert bare == whole  # evidence is not compared
    stripped = [
        *bare.orbits, *bare.events, *bare.ranges, *bare.curve_ranges, *bare.curves[0],
        *bare.curves[1],
    ]  # fmt: skip
    assert len(stripped) == 11
    assert {one.evidence for one in stripped} == {None}
    assert whole.orbits[1].evidence == "of b"


def test_each_thing_of_a_study_has_its_own_proof(monkeypatch):
    """In the study's order, each with the study's parameter; a fault costs its proof alone."""
    study = Stub(
        question=Stub(parameter="mass"),
        orbits=[Stub(label="P(1;1)", rpm=700.0), Stub(label="P(2;1:1)", rpm=700.0)],
        branches=[
            Stub(number=4, points=[Stub(value=1.0), Stub(value=2.0)]),
            Stub(number=5, points=[Stub(value=3.0)]),
        ],
        bifurcations=[
            Stub(kind="fold", value=9.0, branch=5),
            Stub(kind="grazing", value=8.0, branch=4),
            Stub(kind="fold", value=7.0, branch=5),
        ],
        curves=[Stub(points=[Stub(first=1.0, second=2.0)]),
                Stub(points=[Stub(first=3.0, second=4.0), Stub(first=5.0, second=6.0)])],
    )  # fmt: skip
    system = Stub(shape=Stub(flank_excess=0.125))
    monkeypatch.setattr(proofs, "prove_widely", lambda *of: Proof(value=repr(of)))
    monkeypatch.setattr(
        proofs, "prove_orbit", lambda *of: Proof(value=repr(of), evidence="is not kept")
    )
    monkeypatch.setattr(proofs, "prove_event", lambda *of: Proof(value=repr(of)))
    monkeypatch.setattr(proofs, "prove_on_curve", lambda *of: Proof(value=repr(of)))
    monkeypatch.setattr(proofs, "prove_ranges", lambda *of: [("range", *of), ("more", *of)])
    names = []
    monkeypatch.setattr(
        proofs, "piece", lambda name, of, without: (names.append((name, without)), of())[1]
    )
    found = proofs.prove(system, study)
    fault = Proof(ProofStep.FAULT)
    assert names == [
        *[(f"the proof of {what}", fault) for what in (
            "P(1;1) at 700.0 rpm", "P(2;1:1) at 700.0 rpm", "branch 4 at 1.0", "branch 4 at 2.0",
            "branch 5 at 3.0", "the fold at 9.0", "the grazing at 8.0", "the fold at 7.0",
        )],
        ("the proof of branch 4", []),
        ("the proof of branch 5", []),
        *[(f"the proof of curve {what}", fault) for what in (
            "1 at 1.0, 2.0", "2 at 3.0, 4.0", "2 at 5.0, 6.0",
        )],
    ]  # fmt: skip
    assert [one.value for one in found.orbits] == [repr((system, one)) for one in study.orbits]
    assert [[one.value for one in points] for points in found.points] == [
        [repr((system, point, "mass")) for point in branch.points] for branch in study.branches
    ]
    assert {one.evidence for points in found.points for one in points} == {None}
    assert [one.value for one in found.events] == [
        repr((system, event, "mass")) for event in study.bifurcations
    ]
    first, second, third = study.bifurcations
    own_first = {4: [second, first, third], 5: [first, third, second]}
    assert found.ranges == [
        (name, system, branch, own_first[branch.number])
        for branch in study.branches
        for name in ("range", "more")
    ]
    assert found.flank_excess == 0.125
    assert proofs.prove(Stub(shape=Stub()), study).flank_excess == 0.0
    assert [[one.value for one in points] for points in found.curves] == [
        [repr((system, curve, point)) for point in curve.points] for curve in study.curves
    ]


@pytest.mark.parametrize("stable", [True, False])
@pytest.mark.parametrize("evidence", ["narrow", None])
@pytest.mark.parametrize("steps", [(None, None), (None, ProofStep.GRAZES), (ProofStep.CAM, None)])
@pytest.mark.parametrize("axes", [((1.0, 2.0, 3.0, 4.0),), None])
def test_an_orbit_is_proved_for_its_speed_and_for_all_that_round_to_it(
    monkeypatch, stable, evidence, steps, axes
):
    """Ellipses are those of a stable orbit at its own speed; what is kept is the wider proof."""
    orbit = Stub(stable=stable, rpm=700.0)
    asked = []

    def prove_orbit(*of, **more):
        asked.append((of, more))
        step = steps[len(asked) - 1]
        if more:
            return Proof(step, box=("wide",), evidence="wide")
        return Proof(step, box=("narrow",), evidence=evidence)

    def axes_of(one):
        assert (one, stable, ctx.prec >= 60 * 3.3) == ("narrow", True, True)
        return axes

    monkeypatch.setattr(proofs, "prove_orbit", prove_orbit)
    monkeypatch.setattr(proofs, "attraction", axes_of)
    found = proofs.prove_widely("system", orbit)
    is_proved, is_proved_widely = (step is None for step in steps)
    # the doubles about 700 are 2^-43 apart
    calls = [(("system", orbit), {}), (("system", orbit), {"half": 2.0**-44})]
    assert asked == calls[: 1 + is_proved]
    assert (found.step, found.box) == (steps[0], ("narrow",))
    asked_for_axes = is_proved and stable and evidence is not None
    assert found.axes == ((axes or ()) if asked_for_axes else ())
    widely = is_proved and is_proved_widely
    assert found.evidence == ("wide" if widely else evidence)
    assert found.holds_for == (HoldsFor.LAST_DIGIT if widely else HoldsFor.EXACT_DATA)


# -- proofs of curves


@pytest.mark.parametrize("grazes", [False, True])
def test_the_unknowns_of_a_curve_end_with_where_it_grazes(monkeypatch, grazes):
    """Near another root of the curve the angle is that of this root."""
    seen = []
    near, other = root_of([(0.5, 0.1, 0, 0)]), root_of([(0.6, 0.2, 0, 0)])

    class Meeting:
        in_doubles: frozenset = frozenset()

        def __init__(self, system, plane, root, conditions):
            seen.append((system, plane, root))
            self.conditions = conditions
            self.n = 3
            self.grazes = [Stub(place=Place(7, 1))] if grazes else []

        def start(self, root, values):
            return [arb(k) for k in (*root.theta, *values, 99)]

    def condition_at(system, curve, plane, root):
        return Condition(
            codim2.Test.GRAZE if grazes else codim2.Test.FOLD, 1, angle=root.theta[0] + 10.0
        )

    monkeypatch.setattr(curve_proofs, "Meeting", Meeting)
    monkeypatch.setattr(curve_proofs, "condition_at", condition_at)
    on = OnCurve("system", "curve", "plane", near)
    assert seen == [("system", "plane", near)]
    assert on.place == 6
    assert on.condition == condition_at(None, None, None, near)
    assert on.touched == (Place(7, 1) if grazes else None)
    z = on.unknowns("system", "curve", "plane", other, (700.0, 3.0))
    assert [float(x) for x in z] == [0.6, 700.0, 3.0, 10.6 if grazes else 99.0]
    assert on.values(range(20)) == range(6, 8)
    hull = [arb(k) for k in range(9)]
    on.meeting.shooting = lambda values: Stub(rpm=sum(values))
    shooting, orbits = on.flown(hull)
    assert float(shooting.rpm) == 13.0
    assert [float(x) for x in orbits] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 13.0]
    Meeting.in_doubles = frozenset({"mass"})
    with pytest.raises(NotProvedError) as refused:
        OnCurve("system", "curve", "plane", near)
    assert refused.value.step == ProofStep.CAM


def test_parts_of_a_curve_are_joined_where_one_follows_the_other():
    first = CurveEvidence(80, Stub(touched=Place(1, 0)), ("a", "b"), ("1", "2", "3"))
    second = CurveEvidence(80, Stub(touched=Place(1, 0)), ("c",), ("3", "4"))
    both = first.then(second)
    assert (both.boxes, both.joints) == (("a", "b", "c"), ("1", "2", "3", "4"))
    assert both.on is first.on
    elsewhere = replace(second, on=Stub(touched=Place(1, 1)))
    assert first.then(elsewhere) is None
    one = CurveRange(3, 1, 4, ((1.0, 2.0), (3.0, 4.0)), 2, None, first)
    behind = CurveRange(3, 4, 6, ((3.0, 4.0), (5.0, 6.0)), 7, None, second)
    joined = one.joined(behind)
    assert joined == CurveRange(3, 1, 6, ((1.0, 2.0), (5.0, 6.0)), 9)
    assert joined.evidence == both
    assert one.joined(replace(behind, evidence=None)).evidence is None
    assert replace(one, evidence=None).joined(behind).evidence is None


# -- starts that certainly tend to an orbit

FOLLOWER = Follower(mass=2.0, stiffness=800.0, damping=30.0, gravity=9.81, preload=5.0)
OMEGA = 70.0
RPM = OMEGA * 30.0 / pi
SHAPE = System.build(FOLLOWER, EccentricCam(kind="eccentric", base=0.02, lift=0.01), 0.0).shape
IMPACTS = [(0.75, 0.02), (2.5, 0.03)]  # phase and rate; the flights end at 1.9 rad and 10.5 rad
ENDS = [1.9, 10.5]
AXES = ((3e-4, 1e-4, -2e-4, 4e-4), (1e-4, -2e-4, 3e-4, 5e-5))


def cam_at(x):
    """The lift and its slope."""
    return 0.02 + 0.005 * (1.0 - cos(x)), 0.005 * sin(x)


def flown_for(s, q, w):
    """(q, dq/dtheta) of a damped oscillator after s rad, in closed form."""
    z = 30.0 / (2.0 * 2.0 * OMEGA)
    w0 = sqrt(800.0 / 2.0) / OMEGA
    wd = sqrt(w0 * w0 - z * z)
    balance = -(2.0 * 9.81 + 5.0) / 800.0
    a, b = q - balance, (w + z * (q - balance)) / wd
    decay = exp(-z * s)
    height = decay * (a * cos(wd * s) + b * sin(wd * s))
    return (
        balance + height,
        -z * height + decay * wd * (b * cos(wd * s) - a * sin(wd * s)),
    )


def states_from(k: int, axes, phase: float, count: int = 360):
    """(q, v) at a phase after flights from the rim of ellipse k."""
    a, b, c, d = axes
    theta, v = IMPACTS[k]
    states = []
    for n in range(count):
        x, y = cos(TURN * n / count), sin(TURN * n / count)
        from_theta = theta + a * x + b * y
        lift, slope = cam_at(from_theta)
        q, w = flown_for(phase - from_theta, lift, slope + v + c * x + d * y)
        states.append((q, w * OMEGA))
    return states


def area_within(states) -> float:
    """Of the polygon with these corners."""
    around = zip(states, [*states[1:], states[0]], strict=True)
    return abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in around)) / 2.0


def two_flights(turns=(0, 0), landing_turns=(0, 1)):
    """The equations of `IMPACTS`, as far as flights from them are asked for."""
    machine = BallMachine(SHAPE, FOLLOWER, RPM)

    def lift(of_machine, place, theta):
        return 0.02 + 0.005 * (1 - theta.cos()), 0.005 * theta.sin(), 0.005 * theta.cos()

    return Stub(
        n=2, machine=lambda rpm: machine, lift=lift,
        places=[Place(0, turn) for turn in turns],
        landing=lambda k: Place(0, landing_turns[k]),
        span=lambda z, k: arb(ENDS[k]) - z[2 * k],
    )  # fmt: skip


def evidence_of(shooting) -> Evidence:
    hull = [arb(x) for impact in IMPACTS for x in impact] + [arb(RPM)]
    return Evidence(80, shooting, (Stub(hull=lambda: list(hull)),))


@pytest.mark.parametrize("strobe", [1.0, 3.0])
def test_states_at_the_strobe_are_those_of_flights_from_the_rim_of_an_ellipse(strobe):
    """At 1 rad the first flight passes it, and the second one in the next turn; at 3 rad only the
    second one, in its own turn and in the next one."""
    passed = [(0, 1.0), (1, 1.0 + TURN)] if strobe == 1.0 else [(1, 3.0), (1, 3.0 + TURN)]
    states = [states_from(k, AXES[k], phase) for k, phase in passed]
    area = sum(map(area_within, states))
    every = [state for one in states for state in one]
    (low_q, high_q), (low_v, high_v) = (
        (min(values), max(values)) for values in zip(*every, strict=True)
    )
    shooting = two_flights()
    evidence = evidence_of(shooting)
    wide_q, wide_v = high_q - low_q, high_v - low_v
    q, v = (low_q - wide_q, high_q + wide_q), (low_v - wide_v, high_v + wide_v)
    found = starts.starts(evidence, AXES, RPM, strobe, q, v)
    assert 0.99 * area < found.area < area * (1.0 + 1e-4)
    window = (q[1] - q[0]) * (v[1] - v[0])
    assert found.share == pytest.approx(found.area / window, rel=1e-5)
    # the window cuts off some of the states on each of its sides
    for side in range(4):
        cut = [*q, *v]
        cut[side] = (low_q, high_q, low_v, high_v)[side]
        beyond = starts.starts(evidence, AXES, RPM, strobe, tuple(cut[:2]), tuple(cut[2:]))
        assert beyond == (found.area, None)
    nowhere = two_flights(landing_turns=(0, 0))
    if strobe == 1.0:
        only = starts.starts(evidence_of(nowhere), AXES, RPM, strobe, q, v)
        assert only.area < area_within(states[0])
    assert starts.starts(evidence_of(nowhere), AXES, RPM, 2.2, q, v) is None


@pytest.mark.parametrize(("k", "phase"), [(0, 1.2), (1, 9.0)])
def test_balls_of_the_states_are_little_wider_than_the_states(k, phase):
    shooting = two_flights()
    z = [arb(x) for impact in IMPACTS for x in impact] + [arb(RPM)]
    wide = list(z)
    a, b, c, d = AXES[k]
    wide[2 * k] += arb(0, hypot(a, b))
    wide[2 * k + 1] += arb(0, hypot(c, d))
    ellipse = starts.Ellipse(k, z, wide, AXES[k])
    found = starts._states_at(shooting, shooting.machine(None), ellipse, arb(phase), arb(OMEGA))
    states = states_from(k, AXES[k], phase)
    assert float(found.area) == pytest.approx(area_within(states), rel=3e-3)
    for ball, values in zip((found.q, found.v), zip(*states, strict=True), strict=True):
        assert all(ball.contains(arb(x)) for x in values)
        assert float(ball.rad()) < 0.52 * (max(values) - min(values))
    assert starts.rounded_down(0.123456789, 4) == 0.1234
    assert starts.rounded_down(9.87654321e7, 3) == 9.87e7


# -- how far an orbit attracts

SHEAR = np.array([[0.2, 0.5], [-0.3, 0.4]])
STRETCH = np.array([[0.9, -0.1], [0.35, 0.3]])


def flight_by(matrix) -> Stub:
    """A flight with these derivatives."""
    names = "theta_by_theta", "theta_by_v", "v_by_theta", "v_by_v"
    slopes = dict(zip(names, (arb(float(x)) for x in matrix.ravel()), strict=True))
    return Stub(slopes=lambda: Stub(**slopes))


def mapped_by(*maps, admissible=lambda wide: None) -> Stub:
    return Stub(
        n=len(maps), machine=lambda rpm: "machine", admissible=admissible,
        flights=lambda machine, z: [flight_by(one) for one in maps],
    )  # fmt: skip


@pytest.mark.parametrize("maps", [(SHEAR,), (STRETCH,), (SHEAR, STRETCH), (STRETCH, SHEAR, SHEAR)])
def test_in_units_of_the_ellipses_each_flight_shrinks_alike(maps):
    """By the mean factor of a flight: rotated where multipliers are complex, else in one way."""
    whole = np.eye(2)
    for one in maps:
        whole = one @ whole
    mean = max(abs(np.linalg.eigvals(whole))) ** (1.0 / len(maps))
    axes = attraction._axes(list(maps))
    for k, jacobian in enumerate(maps):
        there = axes[(k + 1) % len(maps)]
        in_units = np.linalg.inv(there) @ jacobian @ axes[k]
        assert np.linalg.norm(in_units, 2) == pytest.approx(mean)


@pytest.mark.parametrize("refused", [None, (0, -1), (0, 1), (1, -1), (1, 1)])
def test_ellipses_hold_where_each_flight_brings_all_motions_nearer(monkeypatch, refused):
    axes = [np.array([[0.3, 0.1], [-0.2, 0.5]]), np.array([[0.4, -0.3], [0.1, 0.2]])]
    z = [arb(k) for k in (1, 2, 3, 4, 700)]
    admitted, asked = [], []
    monkeypatch.setattr(
        attraction, "_passes", lambda *of: asked.append(of[-2:]) or of[-2:] != refused
    )
    # by these factors the flight from one ellipse into the next has the norm 1
    inverse = [np.linalg.inv(one) for one in axes]
    full = [
        SHEAR / np.linalg.norm(inverse[1] @ SHEAR @ axes[0], 2),
        STRETCH / np.linalg.norm(inverse[0] @ STRETCH @ axes[1], 2),
    ]
    for first, second in ((0.99, 0.99), (1.01, 0.99), (0.99, 1.01), (100.0, 100.0)):
        shooting = mapped_by(first * full[0], second * full[1], admissible=admitted.append)
        holds = attraction._holds(shooting, z, axes)
        assert holds is (refused is None and first < 1.0 and second < 1.0)
    if refused is None:
        assert asked[:4] == [(0, -1), (0, 1), (1, -1), (1, 1)]
    reach = [hypot(0.3, 0.1), hypot(0.2, 0.5), hypot(0.4, 0.3), hypot(0.1, 0.2), 0.0]
    for ball, middle, radius in zip(admitted[0], (1, 2, 3, 4, 700), reach, strict=True):
        assert float(ball.mid()) == middle
        assert float(ball.rad()) == pytest.approx(radius, rel=1e-6)


@pytest.mark.parametrize("maps", [(SHEAR, STRETCH), (STRETCH, SHEAR)])
@pytest.mark.parametrize("failure", [None, NotProvedError(ProofStep.GRAZES), UndecidedError,
                                     ZeroDivisionError])  # fmt: skip
def test_the_largest_ellipses_that_hold_are_taken_a_size_smaller(monkeypatch, maps, failure):
    tried = []
    shooting = mapped_by(*maps)
    hull = [arb(k) for k in (1, 2, 3, 4, 700)]
    evidence = Evidence(80, shooting, (Stub(hull=lambda: hull),))

    def holds(of, z, axes):
        assert (of, z) == (shooting, hull)
        tried.append(axes)
        if len(tried) < 4 and failure is not None:
            raise failure
        return len(tried) == 4

    monkeypatch.setattr(attraction, "_holds", holds)
    found = attraction.attraction(evidence)
    widest = [max(hypot(*one[0]) for one in axes) for axes in tried]
    assert widest == pytest.approx([1.0, 0.8, 0.64, 0.512])
    for own, one in zip(attraction._axes(list(maps)), tried[0], strict=True):
        assert own * one[0, 0] == pytest.approx(one * own[0, 0])
    for one, matrix in zip(found, tried[-1], strict=True):
        assert one == pytest.approx(tuple(0.8 * matrix.ravel()), rel=1e-5)
        assert one == tuple(float(f"{x:.6g}") for x in one)
    tried.clear()
    monkeypatch.setattr(attraction, "_holds", lambda *of: tried.append(of))
    assert attraction.attraction(evidence) is None
    assert len(tried) == 60


# -- all orbits


def test_stable_orbits_come_first_and_the_covers_name_them_by_their_new_numbers():
    orbits = [
        Stub(stable=False, turns=1, symbols=(1.0,)),
        Stub(stable=True, turns=3, symbols=(1.0, 0.0, 0.0)),
        Stub(stable=False, turns=1, symbols=(0.0,)),
        Stub(stable=True, turns=2, symbols=(2.0, 1.0)),
        Stub(stable=True, turns=1, symbols=(3.0,)),
    ]
    covers = (
        Cover(1, 1, "oo", (0, 2), {}),
        Cover(2, 3, "1ooo", (1, 3, 1), {"flight": 2}, drawn=(((), "flight"),)),
    )
    unordered = AllOrbits(FOLLOWER, 2, 3, list(orbits), covers, Failure.BOXES)
    found = all_orbits._in_order(unordered)
    assert found.orbits == [orbits[4], orbits[3], orbits[1], orbits[2], orbits[0]]
    assert [cover.known for cover in found.covers] == [(4, 3), (2, 1, 2)]
    assert found.covers[1] == replace(covers[1], known=(2, 1, 2))
    assert replace(found, orbits=orbits, covers=covers) == unordered
    assert (found.covers[0].boxes, found.covers[1].boxes) == (2, 5)


def test_a_cam_is_smooth_where_no_slope_jumps_from_stretch_to_stretch(monkeypatch):
    """Also from the last stretch to the first one; a measured cam or a seat has no formula."""

    def stretch(begin, end):
        slopes = {"start": begin, "end": end}
        return Stub(start="start", end="end", derivatives=lambda x, n: [arb(9), arb(slopes[x])])

    shape = Stub(parts=lambda: [Stub(pieces=None, seat=False)] * 3)
    for ends, smooth in (
        ([(1, 2), (2, 3), (3, 1)], True),
        ([(1, 2), (2.5, 3), (3, 1)], False),
        ([(1, 2), (2, 3), (3, 1.5)], False),
        ([(1, 2), (2, 3), (3.5, 1)], False),
        ([(4, 4)], True),
        ([(4, 5)], False),
    ):
        monkeypatch.setattr(
            all_orbits, "stretches_of", lambda of, ends=ends: [stretch(*pair) for pair in ends]
        )
        assert all_orbits._smooth(shape) is smooth
    monkeypatch.setattr(all_orbits, "stretches_of", lambda of: [stretch(1, 1)])
    for pieces, seat in (("pieces", False), (None, True)):
        parts = [Stub(pieces=None, seat=False), Stub(pieces=pieces, seat=seat)]
        assert all_orbits._smooth(Stub(parts=lambda parts=parts: parts)) is False


@pytest.mark.parametrize(
    ("error", "kind", "failure"),
    [
        (None, "arcs", None),
        (UndecidedError, "arcs", Failure.FLIGHTS),
        (UndecidedError, "oscillator", Failure.STOP),
        (all_orbits._TooManyError, "oscillator", Failure.BOXES),
        (BudgetSpentError, "arcs", Failure.WORK_BUDGET),
    ],
)
def test_all_sizes_are_covered_until_one_fails(monkeypatch, error, kind, failure):
    """Fewer turns come first; the covers before the failure are kept."""
    ticks = []

    class Search:
        def __init__(self, shooter, rpm, orbits):
            assert rpm == 745.0
            self.orbits = orbits

        def cover(self, impacts, turns):
            if error is not None and (impacts, turns) == (1, 2):
                raise error
            self.orbits.append(Stub(stable=True, turns=turns, symbols=(impacts,)))
            return Cover(impacts, turns, "o", (len(self.orbits) - 1,), {})

    monkeypatch.setattr(all_orbits, "_CoverSearch", Search)
    monkeypatch.setattr(all_orbits, "_smooth", lambda shape: shape == "shape")
    monkeypatch.setattr(all_orbits, "kind_of_cam", lambda system: kind)
    follower = replace(FOLLOWER, restitution=0.5)
    shooter = Stub(system=Stub(shape="shape", follower=follower))
    found = all_orbits.all_orbits(shooter, 745.0, 3, 2, lambda: ticks.append(None))
    sizes = [(1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (3, 2)]
    made = sizes if error is None else sizes[:3]
    assert [(cover.impacts, cover.turns) for cover in found.covers] == made
    assert [(orbit.symbols[0], orbit.turns) for orbit in found.orbits] == made
    assert (found.failure, len(ticks)) == (failure, len(made))
    assert (found.follower, found.impacts, found.turns) == (follower, 3, 2)
    refused = {0.0: Failure.PLASTIC, 1.0: Failure.LOSSLESS}
    for restitution, reason in refused.items():
        shooter.system.follower = replace(FOLLOWER, restitution=restitution)
        none = all_orbits.all_orbits(shooter, 745.0, 3, 2)
        assert none == AllOrbits(shooter.system.follower, 3, 2, failure=reason)
    shooter.system.shape = "another"
    none = all_orbits.all_orbits(shooter, 745.0, 3, 2)
    assert none == AllOrbits(shooter.system.follower, 3, 2, failure=Failure.CAM)


def test_boxes_are_cut_until_each_holds_no_orbit_or_a_known_one():
    """Along one phase, from 0 to 8: an orbit alone in [4, 6], none in [0, 4] or [6, 8].

    The third box holds the same orbit as the first, and the cover says so of both.
    """
    whole = [((0, 8), "second"), ((0, 2), "second"), ((4, 6), "third")]
    asked = []

    def excluded(box, turns):
        asked.append((box[0], turns))
        return {(0, 4): "flight", (6, 8): "rate", (0, 2): "rate"}.get(box[0])

    def halves(box, k):
        assert k == 0
        (a, b), other = box
        return [((a + b) // 2, b), other], [(a, (a + b) // 2), other]

    search = Stub(
        _whole_boxes=lambda impacts, turns: whole,
        _count_box=lambda: None,
        space=Stub(excluded=excluded),
        _orbit=lambda box, turns: 6 if box[0] == (4, 6) else None,
        _widest=lambda box: 0,
        _ends=lambda box: ("ends of", box[0]),
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(all_orbits, "_halves", halves)
        cover = all_orbits._CoverSearch.cover(search, 2, 3)
        not_drawn = [all_orbits._CoverSearch.cover(search, impacts, 3) for impacts in (1, 3)]
        whole[:] = whole[1:2] * all_orbits.MOST_DRAWN
        most = all_orbits._CoverSearch.cover(search, 2, 3)
        whole.append(whole[0])
        too_many = all_orbits._CoverSearch.cover(search, 2, 3)
    boxes = ((0, 8), (0, 4), (4, 8), (4, 6), (6, 8), (0, 2), (4, 6))
    assert asked[:7] == [(ends, 3) for ends in boxes]
    assert (cover.impacts, cover.turns, cover.letters) == (2, 3, "1.1o..o")
    assert cover.known == (6, 6)
    assert cover.counts == {"flight": 1, "rate": 2}
    assert cover.boxes == 5
    assert cover.drawn == (
        (("ends of", (0, 4)), "flight"), (("ends of", (4, 6)), ""),
        (("ends of", (6, 8)), "rate"), (("ends of", (0, 2)), "rate"),
        (("ends of", (4, 6)), ""),
    )  # fmt: skip
    assert [other.drawn for other in (*not_drawn, too_many)] == [(), (), ()]
    assert [other.letters for other in not_drawn] == [cover.letters, cover.letters]
    assert len(most.drawn) == most.boxes == too_many.boxes - 1


def test_a_cut_box_is_two_with_the_later_half_first():
    box = (Key(3, 1, 1), Key(5, 2, 3), Key(6, 0, 0))
    later, earlier = all_orbits._halves(box, 1)
    assert later == (box[0], Key(5, 3, 7), box[2])
    assert earlier == (box[0], Key(5, 3, 6), box[2])
    with pytest.raises(all_orbits._TooManyError):
        all_orbits._halves((box[0], Key(5, all_orbits.DEEPEST, 3)), 1)


def test_phases_are_an_orbits_from_any_of_its_impacts_on():
    """Of an orbit of two impacts in two turns, gone through twice in four turns."""
    root = root_of([(1.0, 0.1, 0, 0), (0.5, 0.2, 0, 1)], turns=2)
    orbit = Stub(root=root, turns=2)
    first, second = 1.0, 0.5 + TURN
    for phases, turns, is_same in (
        ([first, second], 2, True),
        ([second, first + 2 * TURN], 2, True),
        ([second - TURN, first + TURN], 2, True),
        ([first, second + 2e-7], 2, False),
        ([first, second + 0.9e-7], 2, True),
        ([first, second + TURN], 2, False),
        ([first, second], 4, False),
        ([first, second, first + 2 * TURN, second + 2 * TURN], 4, True),
        ([second, first + 2 * TURN, second + 2 * TURN, first + 4 * TURN], 4, True),
        ([first, second, first + 2 * TURN, second + 2 * TURN], 3, False),
        ([second, first], 2, False),
    ):
        assert all_orbits._has_phases(orbit, phases, turns) is is_same, (phases, turns)


@pytest.mark.parametrize("change", [None, "no root", "elsewhere", "no motion", "repeats"])
def test_the_motion_of_a_box_is_solved_from_its_first_turn_on(monkeypatch, change):
    """Stretches are counted on over the turns: 3 to a turn, the impacts in turns 1 and 0 of two."""
    box = (Key(4, 2, 1), Key(8, 0, 0), Key(6, 1, 0))  # the last two are in turns 2 and 2: 0 of two
    solved = all_orbits._BoxRoot([2.5, 5.5, 0.5], [0.1, 0.2, 0.3])
    solved_for = []
    answer = root_of([(0.5, 0, 0, 0), (5.5 + (3e-7 if change == "elsewhere" else 5e-8), 0, 2, 0),
                      (2.5, 0, 1, 1)], turns=2)  # fmt: skip

    def at_value(*of):
        solved_for.append(of)
        return None if change == "no root" else answer

    made = Stub(admissible=change != "no motion", primitive=change != "repeats")
    monkeypatch.setattr(all_orbits, "from_root", lambda *of: made if of == wanted else None)
    monkeypatch.setattr(all_orbits, "stretch_at", lambda cam, phase: int(phase // (TURN / 3)))
    search = Stub(
        space=Stub(count=3), system=Stub(cam="cam"), rpm=745.0,
        shooter=Stub(at_value=at_value, verdict=lambda root: (ADMISSIBLE, 1, 2.0)),
    )  # fmt: skip
    wanted = (search.system, answer, ADMISSIBLE)
    found = all_orbits._CoverSearch._new(search, box, solved, 2)
    assert solved_for == [
        ([0.5, 0.3, 5.5, 0.2, 2.5, 0.1, 745.0], [0, 0, 2, 0, 1, 1], 2, 745.0),
    ]  # fmt: skip
    assert found is (made if change is None else None)


def test_the_search_begins_with_the_machine_at_its_speed(monkeypatch):
    monkeypatch.setattr(all_orbits, "BallMachine", lambda *of: ("machine", *of))
    monkeypatch.setattr(all_orbits, "PhaseCover", lambda machine: ("cover", machine))
    system = Stub(shape="shape", follower="follower")
    orbits = []
    search = all_orbits._CoverSearch(Stub(system=system), 745.0, orbits)
    assert search.space == ("cover", ("machine", "shape", "follower", 745.0))
    assert search.orbits is orbits
    assert (search.rpm, search.made, search.system) == (745.0, 0, system)
