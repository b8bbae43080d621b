"""Each way in which a proof ends without one: the step that is told, and what is kept then.

The machine is an eccentric cam c = a - s cos(theta) with a follower of unit mass and stiffness. Its
orbit of one impact, its fold, its balance and its first loss of contact have closed forms.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import cos, hypot, log2, nextafter, pi, sin
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, ctx

from camcli.analysis.integrate import budgeted
from camcli.analysis.labels import CONTACT
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.orbit import PeriodicOrbit, free_orbit, from_root
from camcli.analysis.orbits.proofs import Proof, prove_event, prove_orbit, prove_ranges
from camcli.analysis.orbits.shooter import Shooter
from camcli.analysis.orbits.single_impact import single_impact_roots
from camcli.analysis.orbits.study import Bifurcation, Branch
from camcli.cams.balls import UndecidedError, precision
from camcli.cams.eccentric import EccentricCam
from camcli.exact.motion import BallMotion
from camcli.exact.shooting import Box, NotProvedError, ProofStep
from camcli.system import Follower, System

MIDDLE, SIZE = 0.5, 0.25  # m: a and s, both doubles
TOP = MIDDLE + SIZE
R = 0.8
CAM = EccentricCam(kind="eccentric", base=MIDDLE - SIZE, lift=2.0 * SIZE)
MACHINE = System.build(Follower(mass=1.0, stiffness=1.0, restitution=R), CAM)
MORE_DIGITS = {ProofStep.SINGULAR, ProofStep.GRAZES, ProofStep.NEUTRAL}


def event_of(orbit, value: float, error: float = 0.0, kind=Kind.DEPARTURE, located=None):
    return Bifurcation(1, kind, value, error, Bracket.OK, orbit, located=located)


def bits(digits: int) -> int:
    with precision(digits):
        return ctx.prec


def bouncing(system: System, value: float, parameter: str = "rpm", rpm: float = 20.0):
    """The orbit of one impact that is a motion: it leaves the cam."""
    roots = single_impact_roots(Shooter(system, rpm, parameter), value, 1)
    (root,) = [root for root in roots if root.x[1] > 0.0 and root.theta[0] < pi]
    return from_root(system, root)


@pytest.mark.parametrize("refuted", [True, False])
@pytest.mark.parametrize("step", list(ProofStep))
def test_an_orbit_is_tried_with_more_digits_where_these_may_decide(monkeypatch, step, refuted):
    """Each try is counted as a box for each impact; its last refusal is told."""
    tried = []

    def refused(*_):
        tried.append(ctx.prec)
        raise NotProvedError(step, refuted)

    def at_last(*_):
        return Proof(value="proved") if tried else refused()

    monkeypatch.setattr(proofs, "_bouncing", refused)
    orbit = Made(root="root", theta=(1.0, 2.0, 3.0), stable=True, label="P(1;3)")
    with budgeted(10**9, lambda *_: None) as budget:
        assert prove_orbit(MACHINE, orbit) == Proof(step, refuted)
    again = step in MORE_DIGITS and not refuted
    assert tried == [bits(60), bits(240)][: 1 + again]
    assert budget.done == 3 * 20_000 * len(tried)
    tried.clear()
    monkeypatch.setattr(proofs, "_bouncing", at_last)
    wanted = Proof(value="proved") if again else Proof(step, refuted)
    assert prove_orbit(MACHINE, orbit) == wanted


@pytest.mark.parametrize("refuted", [True, False])
@pytest.mark.parametrize(("name", "located", "digits"), [
    ("_located", "located", 60), ("_change", None, 150),
])  # fmt: skip
def test_an_event_that_is_refused_says_at_which_step(monkeypatch, name, located, digits, refuted):
    tried = []

    def refused(*asked):
        tried.append((ctx.prec, asked[1:]))
        raise NotProvedError(ProofStep.CROSSING, refuted)

    monkeypatch.setattr(proofs, name, refused)
    event = event_of(Made(theta=()), 700.0, located=located)
    with budgeted(10**9, lambda *_: None) as budget:
        assert prove_event(MACHINE, event, "mass") == Proof(ProofStep.CROSSING, refuted)
    assert tried == [(bits(digits), (event, located if located else "mass"))]
    assert budget.done == 20_000  # of an orbit without impacts, too
    with budgeted(20_000, lambda *_: None):
        assert prove_event(MACHINE, event).step == ProofStep.WORK_BUDGET
    assert len(tried) == 1


@pytest.mark.parametrize(("height", "step", "refuted"), [
    (TOP, ProofStep.GRAZES, False),
    (nextafter(TOP, 1.0), None, False),
    (nextafter(TOP, 0.0), ProofStep.CONTACT, True),
])  # fmt: skip
def test_a_follower_that_may_touch_the_top_of_the_cam_is_not_proved_free(height, step, refuted):
    """The balance is at a double, and so is the top, half a turn from where a stretch begins."""
    damped = MACHINE.with_follower(damping=0.5, preload=-2.0)
    orbit = free_orbit(damped, 20.0)
    proof = prove_orbit(MACHINE.with_follower(damping=0.5, preload=-height), orbit)
    assert (proof.step, proof.refuted) == (step, refuted)
    assert (proof.box == ()) == (step is not None)


def test_the_end_of_a_free_orbit_is_enclosed_where_it_may_be_decided():
    """It ends at preload = -TOP, k = 1: there the balance is at the top of the cam.

    At the very value nothing can be decided, so that the bracket stays as it is.
    """
    free = free_orbit(MACHINE.with_follower(preload=-2.0 * TOP, damping=0.5), 20.0)
    at_a_double = prove_event(MACHINE, event_of(free, -TOP), "preload")
    assert at_a_double.step is None
    assert at_a_double.low < -TOP < at_a_double.high
    assert Fraction(at_a_double.high) - Fraction(at_a_double.low) < 1e-14
    loaded = MACHINE.with_follower(preload=-0.7)
    end = Fraction(0.7) / Fraction(TOP)  # of the stiffness, no double
    for shift in (3e-13, -3e-13):
        proof = prove_event(loaded, event_of(free, float(end) * (1.0 + shift)), "stiffness")
        assert proof.step is None
        assert proof.low < end < proof.high
        assert Fraction(proof.high) - Fraction(proof.low) < 1e-15
        with precision(60):
            assert arb(proof.value).overlaps(arb(end.numerator) / end.denominator)
            assert arb(proof.value).rad() < 1e-20
    near, far = (event_of(free, -TOP * (1.0 + shift), error) for shift, error in (
        (1e-7, 0.0), (1e-7, 1e-6),
    ))  # fmt: skip
    assert prove_event(MACHINE, near, "preload").step == ProofStep.NUMBER
    assert prove_event(MACHINE, far, "preload").step is None
    away = event_of(free, -TOP * 1.01)
    assert prove_event(MACHINE, away, "preload").step == ProofStep.CROSSING


@pytest.mark.parametrize("preload", [-TOP, -2.0 * TOP, -0.5 * TOP])
def test_an_orbit_does_not_end_where_nothing_changes(preload):
    """The balance does not depend on the mass: it is at the top, above or below it everywhere."""
    free = free_orbit(MACHINE.with_follower(preload=-2.0 * TOP, damping=0.5), 20.0)
    system = MACHINE.with_follower(preload=preload)
    assert prove_event(system, event_of(free, 1.0), "mass").step == ProofStep.CROSSING


REST = PeriodicOrbit(20.0, 20.0, 1, (0.0,), ((MIDDLE - SIZE, 0.0),), resting=True)
# N = m omega^2 s cos(theta) + k (a - s cos(theta)) + F is zero at pi where omega = 2 rad/s:
PRESSED = MACHINE.with_follower(preload=3.0 * SIZE - MIDDLE)
LOSS = 60.0 / pi  # rpm of two rad/s


@pytest.mark.parametrize(("theta", "kind", "below", "above"), [
    ((), Kind.DETACHMENT, True, False), ((), Kind.ITINERARY, True, False),
    ((1.0,), Kind.DETACHMENT, False, True), ((1.0,), Kind.ITINERARY, False, None),
])  # fmt: skip
def test_a_follower_rests_for_good_up_to_the_first_loss(theta, kind, below, above):
    """An orbit with a departure is there from the first loss on, one without it up to there."""
    orbit = replace(REST, theta=theta)
    with precision(60):
        loss = 60 / arb.pi()
        assert proofs._keeps(PRESSED, "rpm", orbit, loss * (1 - arb(1e-20)), kind) is below
        if above is not None:
            assert proofs._keeps(PRESSED, "rpm", orbit, loss * (1 + arb(1e-20)), kind) is above
        if not theta:
            with pytest.raises(UndecidedError):
                proofs._keeps(PRESSED, "rpm", orbit, loss, kind)


def test_contact_is_proved_refuted_or_undecided(monkeypatch):
    """The first loss itself is enclosed in balls only, in which nothing can be decided."""
    assert REST.label == CONTACT
    assert prove_orbit(PRESSED, replace(REST, rpm=0.999 * LOSS)) == Proof()
    refuted = Proof(ProofStep.CONTACT, refuted=True)
    assert prove_orbit(PRESSED, replace(REST, rpm=1.001 * LOSS)) == refuted
    on_mass = prove_orbit(PRESSED, replace(REST, value=1.0), "mass", half=1e-16)
    assert on_mass == Proof(ProofStep.MODEL)  # widely at a speed only

    def at_the_loss(machine, strobe, start):
        return BallMotion(proofs.BallMachine(CAM, PRESSED.follower, 60 / arb.pi()), strobe, start)

    monkeypatch.setattr(proofs, "BallMotion", at_the_loss)
    assert prove_orbit(PRESSED, REST) == Proof(ProofStep.GRAZES)


@pytest.mark.parametrize(("theta", "after", "wanted"), [
    ((), None, Proof(ProofStep.MODEL)),
    ((1.0,), Made(kind="unknown"), Proof(ProofStep.MODEL)),
    ((1.0,), Made(kind="cycle", symbols=(2.0,)), Proof(ProofStep.NO_ORBIT, refuted=True)),
    ((1.0,), Made(kind="cycle", symbols=(1.0,), leaves=[(0, 1.5), (0, 0.25)]),
     Proof(box=("1.5", "0.25"))),
])  # fmt: skip
def test_a_motion_behind_a_rest_must_come_back_with_its_label(monkeypatch, theta, after, wanted):
    monkeypatch.setattr(proofs, "of_machine", lambda system, rpm, start, widely: after)
    assert prove_orbit(MACHINE, replace(REST, symbols=(1.0,), theta=theta)) == wanted


def fold_at(rpm: float) -> float:
    """The preload at the fold of the orbit of one impact a turn.

    K F = (1 + r) B c_theta with F = G + W^2 c, c = a - s cos(theta): a sine of theta of amplitude
    s |(K W^2, (1 + r) B)| equals K (G + W^2 a), and has one zero where these are the same.
    """
    omega = rpm * pi / 30.0
    w = 1.0 / omega
    b, slope, p = sin(2 * pi * w) / w, cos(2 * pi * w), (1.0 - cos(2 * pi * w)) / w**2
    k = p * (1.0 + R * slope) - R * b * b
    return omega**2 * (SIZE * hypot(k * w * w, (1.0 + R) * b) / k - w * w * MIDDLE)


def test_an_event_where_the_label_changes_is_proved_without_a_statement():
    rpm = 20.0
    fold = fold_at(rpm)
    inside = fold - 1e-3 * abs(fold)
    roots = single_impact_roots(Shooter(MACHINE, rpm, "preload"), inside, 1)
    assert len(roots) == 2
    assert single_impact_roots(Shooter(MACHINE, rpm, "preload"), 2 * fold - inside, 1) == []
    root = max(roots, key=lambda root: root.x[1])
    located = Located(Kind.FOLD, root, 0.0, 0.0, Bracket.OK, impact=0)
    orbit = from_root(MACHINE, root)
    event = event_of(orbit, inside, 0.01 * abs(fold), Kind.FOLD, located)
    named = prove_event(MACHINE, event, "preload")
    assert named.step is None
    assert abs(arb(named.value) - fold) < 1e-12 * abs(fold)
    assert named.evidence.ends == (located,)
    other = replace(event, orbit=replace(orbit, symbols=(2.0,)))
    unnamed = prove_event(MACHINE, other, "preload")
    assert (unnamed.step, unnamed.evidence) == (None, None)
    assert (unnamed.value, unnamed.box) == (named.value, named.box)


BALANCED = MACHINE.with_follower(preload=-MIDDLE)  # the force is zero in the middle of the lift


def branch_over(speeds) -> Branch:
    points = tuple(bouncing(BALANCED, rpm) for rpm in speeds)
    return Branch(3, "found", points, ("end-of-range", "end-of-range"))


def test_a_section_that_cannot_be_asked_for_is_one_range_without_a_proof():
    """It is named after the orbit in its middle; orbits of more than 64 impacts have no proof."""
    root = Made(whole=(0, 0), count=65, theta=[1.0])
    points = [
        Made(root=root, value=value, label=f"P({k})", stable=k == 2)
        for k, value in enumerate((700.0, 701.0, 702.0, 703.5))
    ]
    branch = Branch(7, "found", tuple(points), ("lost", "lost"))
    (part,) = prove_ranges(MACHINE, branch, [])
    assert part == proofs.Range(7, "P(2)", True, "700.0", "703.5", 0, ProofStep.MODEL)
    few = [Made(**{**vars(point), "root": Made(whole=(0, 0), count=64)}) for point in points]
    with pytest.raises(AttributeError):  # so many are asked for
        list(prove_ranges(MACHINE, replace(branch, points=tuple(few)), []))


@pytest.mark.parametrize("refused", [(), (0,), (-1,), (0, -1)])
def test_a_range_ends_one_point_earlier_where_its_end_is_refused(monkeypatch, refused):
    """Where an end has another label, say; what is left there is a range that is not proved."""
    branch = branch_over((20.0, 20.25, 20.5, 20.75, 21.0))
    places = [branch.points[k].value for k in refused]
    real = proofs.prove_label

    def prove_label(shooting, box, strobe, label):
        if any(box.hull()[-1].overlaps(arb(place)) for place in places):
            raise NotProvedError(ProofStep.STROBE)
        real(shooting, box, strobe, label)

    monkeypatch.setattr(proofs, "prove_label", prove_label)
    whole, *rest = prove_ranges(BALANCED, branch, [])
    low = "20.25" if 0 in refused else "20.0"
    high = "20.75" if -1 in refused else "21.0"
    assert (whole.low, whole.high, whole.failed_step) == (low, high, None)
    assert whole.boxes == len(whole.evidence.boxes) > 0
    wanted = {0: ("20.0", "20.25"), -1: ("20.75", "21.0")}
    assert [(one.low, one.high, one.failed_step) for one in rest] == [
        (*wanted[k], ProofStep.STROBE) for k in refused
    ]
    assert {(one.branch, one.label, one.stable) for one in (whole, *rest)} == {(3, "P(1;1)", True)}


def box_at(p: arb, half=0) -> Box:
    """A box of a phase, a rate and the parameter, of which the parameter is given."""
    middle = [arb(0), arb(1), arb(p).mid()]
    return Box(middle, [arb(0), arb(0), arb(1)], [arb(0)] * 3, 2, arb(half), [arb(0)] * 3,
               arb_mat(0, 0))  # fmt: skip


class NearEvent:
    """What boxes about an event at p = 700 are asked for: they are proved up to a half width."""

    def __init__(self, widest: float, trace: float = -1.5):
        self.widest, self.trace = widest, trace
        self.tried: list[float] = []
        self.admitted: list[float] = []  # half widths of the parameter

    def zero(self, guess, fixed, test, width):
        self.tried.append(float(width))
        if width > self.widest:
            step = ProofStep.CROSSING if len(self.tried) < 6 else ProofStep.GRAZES
            raise NotProvedError(step)
        return box_at(arb(700)), box_at(arb(700), width)

    def box(self, guess, fixed, half=0):
        return box_at(guess[fixed])

    def admissible(self, hull, *asked):
        self.admitted.append(float(hull[-1].rad()))

    def trace_det(self, z):
        return arb(self.trace), arb(0.5)


def about(shooting: NearEvent, inner: float) -> proofs.End:
    root = Made(x=[0.0, 1.0, 700.0], whole=(0, 0), count=1)
    located = Located(Kind.PERIOD_DOUBLING, root, 0.0, 0.0, Bracket.OK)
    return proofs._about(shooting, root, Made(x=[0.0, 1.0, inner]), located, True)


REACHES = (0.3, 0.1, 1e-2, 1e-3, 1e-4, 1e-5)


@pytest.mark.parametrize("inner", [704.0, 696.0])
@pytest.mark.parametrize("number", range(6))
def test_smaller_and_smaller_boxes_about_an_event_are_tried(inner, number):
    """The range begins in the middle between the event and the box's end, on its own side."""
    shooting = NearEvent(4.0 * REACHES[number] * 1.001)
    end = about(shooting, inner)
    assert shooting.tried == pytest.approx([4.0 * reach for reach in REACHES[: number + 1]])
    assert float(end.text) == 700.0
    side = 1.0 if inner > 700.0 else -1.0
    beside = float(end.beside.middle[2]) - 700.0
    assert beside == pytest.approx(side * 2.0 * REACHES[number], rel=1e-6)
    assert float(end.around.half) == pytest.approx(4.0 * REACHES[number])
    assert shooting.admitted == pytest.approx([4.0 * REACHES[number]])  # all of the box


@pytest.mark.parametrize(("widest", "trace", "step"), [
    (0.0, -1.5, ProofStep.GRAZES), (10.0, 1.5, ProofStep.NEUTRAL),
])  # fmt: skip
def test_an_event_without_a_box_is_refused_at_the_last_step(widest, trace, step):
    """No box is proved, or in each of them the other multiplier may be +1."""
    shooting = NearEvent(widest, trace)
    with pytest.raises(NotProvedError) as refused:
        about(shooting, 704.0)
    assert refused.value.step == step
    assert len(shooting.tried) == 6


@pytest.mark.parametrize("way", [1.0, -3.0])
def test_a_chain_ends_where_the_narrowest_box_fails(way):
    """From a sixteenth of the way down to 1e-12 of it, and at the step of the last refusal."""
    asked = []

    def box(guess, fixed, half=0):
        if half != 0:
            asked.append(float(half))
            raise NotProvedError(ProofStep.CONTACT)
        return box_at(guess[2])

    ends = [proofs.End("", box_at(p), box_at(p)) for p in (arb(700), arb(700 + way))]
    with precision(60), pytest.raises(NotProvedError) as refused:
        proofs._chain(Made(n=1, box=box), *ends, 2, True, lambda box: None)
    assert refused.value.step == ProofStep.CONTACT
    halves = [1.01 * abs(way) / 32.0 / 2.0**k for k in range(len(asked))]
    assert asked == pytest.approx(halves)
    assert len(asked) == 1 + int(log2(1e12 / 16.0))


@pytest.mark.parametrize("below", [True, False])
@pytest.mark.parametrize("half", [1e-13, 1e-11, 20.0])
def test_what_is_not_decided_is_within_the_bracket_of_a_change(monkeypatch, below, half):
    """The orbit is there on one side of the zone only; one of 40 rpm is wider than any bracket."""

    def keeps(system, parameter, orbit, p, kind):
        if abs(p - 700) <= half:
            raise UndecidedError
        return below if p < 700 else not below

    monkeypatch.setattr(proofs, "_keeps", keeps)
    for shift in (-0.7 * half, 0.0, 0.7 * half):
        event = event_of(Made(theta=()), 700.0 + shift, 1e-9)
        proof = prove_event(MACHINE, event)
        if half == 20.0:
            assert proof == Proof(ProofStep.CROSSING)
            continue
        assert proof.step is None
        assert proof.low <= 700.0 - half < 700.0 + half <= proof.high
        assert proof.high - proof.low < 8.1e-9
    assert prove_event(MACHINE, event_of(Made(theta=()), 700.0 + 1e-6, 1e-9)).step in (
        ProofStep.CROSSING, ProofStep.NUMBER,
    )  # fmt: skip


@pytest.mark.parametrize("values", [(700.0, 701.0), (701.0, 700.0)])
def test_what_passes_an_end_without_an_event_is_a_range_from_low_to_high(monkeypatch, values):
    """Whichever way the branch is followed."""
    pair = tuple(Made(value=value, label="P(1;1)", stable=True) for value in values)
    monkeypatch.setattr(proofs, "_off_the_ends", lambda system, branch, events: branch)
    monkeypatch.setattr(proofs, "_sections", lambda branch, events: [])
    monkeypatch.setattr(proofs, "_passings", lambda branch, events: [pair])
    (part,) = prove_ranges(MACHINE, Made(number=7), [])
    assert part == proofs.Range(7, "P(1;1)", True, "700.0", "701.0", 0, ProofStep.PASSES)
