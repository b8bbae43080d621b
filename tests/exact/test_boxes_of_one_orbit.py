"""What is asked of the box of one orbit, by equations that are stand-ins with values by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.analysis.labels import Label
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.locate import Located
from camcli.analysis.orbits.shooter import Root
from camcli.cams.balls import UndecidedError
from camcli.exact.motion import EndlessError
from camcli.exact.shooting import Box, NotProvedError, Place, ProofStep
from camcli.system import CONSTANTS, Follower


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 120
    yield
    ctx.prec = before


def root_of(impacts, value=700.0, turns=3, parameter=0, machine=(700.0,)) -> Root:
    """A root from (phase, rate, stretch, turn) of each impact."""
    x = [number for theta, v, _, _ in impacts for number in (theta, v)]
    whole = tuple(number for _, _, stretch, turn in impacts for number in (stretch, turn))
    rates = [-2.0 * v for _, v, _, _ in impacts]
    return Root([*x, value], whole, turns, machine, parameter, rates, [1.0] * (len(x) + 1),
                0.5, 0.0, 2)  # fmt: skip


def box_of(middle, tangent=None, error=0.0, fixed=-1, half=0.0) -> Box:
    tangent = tangent or [0.0] * len(middle)
    errors = [arb(0, error)] * len(middle)
    return Box(list(map(arb, middle)), list(map(arb, tangent)), errors, fixed % len(middle),
               arb(half), errors, arb_mat(1, 1))  # fmt: skip


def refused(proof, *of) -> ProofStep | None:
    try:
        proof(*of)
    except NotProvedError as failed:
        return failed.step
    return None


# -- the equations


@dataclass(frozen=True)
class Equations:
    """Equations that only note where they are asked for a place."""

    shape: object
    follower: object
    rpm: float
    parameter: str
    places: tuple
    turns: int

    def place(self, at, turn):
        return float(at), turn


def test_impacts_are_asked_for_a_little_inside_their_stretches(monkeypatch):
    """By a billionth of a radian, or by a quarter of a stretch that is shorter than that."""
    ends = [(0.0, 1.0), (1.0, 2.0), (2.0, 2.0 + 2e-9), (3.0, 4.0)]
    stretches = [Stub(start=start, end=end) for start, end in ends]
    asked = []

    def with_machine(system, machine):
        asked.append((system, machine))
        return Stub(shape="shape", follower="follower", cam=Stub(stretches=stretches)), 650.0

    monkeypatch.setattr(proofs, "with_machine", with_machine)
    monkeypatch.setattr(proofs, "Shooting", Equations)
    monkeypatch.setattr(proofs, "can_vary", lambda shape, name: name == "cam.base")
    root = root_of([(0.9, 0.5, 1, 0), (2.5, 0.5, 1, 1), (1.25, 0.5, 1, 2), (2.0, 0.5, 2, 0),
                    (2.1, 0.5, 2, 1), (3.0, 0.5, 3, 4), (4.0, 0.5, 3, 5)])  # fmt: skip
    names = Stub(family=Stub(names=("cam.lift", "cam.base")))
    found = proofs.shooting_of(Stub(member=names), root)
    assert asked == [(Stub(member=names), (700.0,))]
    assert (found.shape, found.follower, found.rpm) == ("shape", "follower", 650.0)
    assert (found.parameter, found.turns) == ("rpm", 3)
    thetas = [1.0 + 1e-9, 2.0 - 1e-9, 1.25, 2.0 + 5e-10, 2.0 + 1.5e-9, 3.0 + 1e-9, 4.0 - 1e-9]
    assert [theta for theta, _ in found.places] == pytest.approx(thetas, rel=0.0, abs=5e-13)
    assert [turn for _, turn in found.places] == [0, 1, 2, 0, 1, 4, 5]

    # a number of the cam, where that is known in balls; and no more impacts than asked for
    of_base = replace(root, parameter=CONSTANTS + 1)
    assert proofs.shooting_of(Stub(member=names), of_base, 7).parameter == "cam.base"
    assert refused(proofs.shooting_of, Stub(member=names), of_base, 6) == ProofStep.MODEL
    of_lift = replace(root, parameter=CONSTANTS)
    assert refused(proofs.shooting_of, Stub(member=names), of_lift) == ProofStep.CAM
    assert proofs.shooting_of(Stub(member=None), replace(root, parameter=2)).parameter == (
        "stiffness"
    )


# -- an orbit that bounces


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("side", [1, -1])
def test_the_numbers_of_an_orbit_are_those_in_its_box(monkeypatch, k, side):
    """To 1e-10 rad or of the largest rate, and to 1e-13 of the parameter's way."""
    root = root_of([(1.0, 0.5, 0, 0), (4.0, -8.0, 1, 1)], 700.0)
    tangent = [3.0, -5.0, 0.5, 7.0, 1.0]
    sizes = (1.0, 8.0, 1.0, 8.0)
    allowed = 1e-10 * sizes[k] + 1e-13 * 700.0 * abs(tangent[k])
    called = []
    monkeypatch.setattr(proofs, "_prove_stability", lambda *of: called.append(of))
    monkeypatch.setattr(proofs, "prove_label", lambda *of: called.append(of))
    for share in (0.999, 1.001):
        middle = list(root.x)
        middle[k] += side * share * allowed
        box = box_of(middle, tangent)
        guesses = []
        shooting = Stub(
            box=lambda guess, fixed, half, box=box, guesses=guesses: (
                guesses.append((guess, fixed, half)),
                box,
            )[1],
            admissible=lambda hull: called.append(hull),
        )
        monkeypatch.setattr(proofs, "shooting_of", lambda *of, made=shooting: made)
        called.clear()
        bounces = (Stub(strobe=0.25), root, "stable", 0.125, "P(1;1)")
        if share > 1.0:
            assert refused(proofs._bouncing, *bounces) == ProofStep.NO_ORBIT
            assert called == []
            continue
        proof = proofs._bouncing(*bounces)
        assert guesses == [(root.x, 4, 0.125)]
        hull = [float(x.mid()) for x in called[0]]
        assert hull == middle
        assert called[1:] == [(shooting, box, "stable"), (shooting, box, 0.25, "P(1;1)")]
        assert proof.proved
        assert [float(arb(x)) for x in proof.box] == pytest.approx(middle[:4])
        evidence = proof.evidence
        assert (evidence.bits, evidence.shooting, evidence.boxes) == (120, shooting, (box,))
        assert evidence == Evidence(120, shooting, (box,))


TOO_WIDE = (arb(0, 3), arb(0, 3))


@pytest.mark.parametrize(
    ("hull", "middle", "slopes", "certain"),
    [
        ((0.5, 0.25), None, None, True),
        ((1.5, 0.25), None, None, False),
        ((-1.5, 0.25), None, None, False),
        ((0.5, 1.25), None, None, False),
        (TOO_WIDE, (0.75, 0.25), (4.0, 0.0), True),  # at most 1.15, of 1.25
        (TOO_WIDE, (0.75, 0.25), (6.0, 0.0), None),
        (TOO_WIDE, (0.75, 0.25), (-6.0, 0.0), None),
        (TOO_WIDE, (0.75, 0.5), (0.0, 4.0), True),  # at most 0.9, of 1
        (TOO_WIDE, (0.75, 0.5), (0.0, 6.0), None),
        (TOO_WIDE, (2.0, 0.5), (4.0, 0.0), False),  # at least 1.6, of 1.5
        (TOO_WIDE, (2.0, 0.5), (6.0, 0.0), None),
        (TOO_WIDE, (-2.0, 0.5), (4.0, 0.0), False),
        (TOO_WIDE, (0.0, 1.5), (0.0, 4.0), False),
    ],
)
def test_stability_is_that_of_all_orbits_of_a_box(hull, middle, slopes, certain):
    """Of a box of half width 0.1, whose multipliers change along the branch by their slopes."""
    box = Stub(half=arb(0.1), fixed=6, hull=lambda: "hull", orbit_at=lambda eta: ("at", eta))

    def trace_det(z):
        if z == "hull":
            return [arb(x) for x in hull]
        if z == "along":
            return [arb_series([9, slope], 2) for slope in slopes]
        assert z == ("at", 0)
        return [arb(x) for x in middle]

    def along(z, fixed):
        assert (z, fixed) == ("hull", 6)
        return "along"

    shooting = Stub(trace_det=trace_det, along=along)
    for stable in (True, False):
        if certain is stable:
            proofs._prove_stability(shooting, box, stable)
            continue
        with pytest.raises(NotProvedError) as failed:
            proofs._prove_stability(shooting, box, stable)
        assert failed.value.step == ProofStep.NEUTRAL
        assert failed.value.refuted is (certain is not None)


# -- labels


def label_of(impacts, label, turns=3, strobe=2.0, error=0.0) -> ProofStep | None:
    """Why impacts (phase, turn) are not shown to have a label, None where they are."""
    places = tuple(Place(0, turn) for _, turn in impacts)
    shooting = Stub(n=len(impacts), turns=turns, places=places)
    middle = [number for theta, _ in impacts for number in (theta, 9.0)]
    return refused(proofs.prove_label, shooting, box_of([*middle, 700.0], error=error), strobe,
                   label)  # fmt: skip


def test_a_label_counts_the_impacts_of_each_turn_after_the_strobe():
    """What lies before the strobe is of the turn before, the first one's being the last."""
    impacts = [(1.0, 0), (3.0, 0), (3.5, 0), (1.5, 2), (4.0, 0)]
    assert label_of(impacts, "P(3;3:1:1)") is None
    assert label_of(impacts, "P(3;4:1:0)") == ProofStep.STROBE
    assert label_of([(1.0, 0), (1.5, 1), (1.75, 1), (3.0, 3)], "P(3;3:0:1)") is None
    # of one turn, an impact at the strobe may be on either side of it; of two as well, if alone
    assert label_of([(2.0, 0)], "P(1;1)", turns=1) is None
    assert label_of([(2.0, 0)], "P(2;1:0)", turns=2) is None
    assert label_of([(2.0, 0), (3.0, 0)], "P(2;2:0)", turns=2) == ProofStep.STROBE
    assert label_of([(2.0, 0), (3.0, 0)], "P(2;1:1)", turns=2) == ProofStep.STROBE
    many = [(2.0, 0)] * 7
    assert label_of(many[:6], "P(1;6)", turns=1) is None
    assert label_of(many, "P(1;7)", turns=1) == ProofStep.STROBE


@pytest.mark.parametrize(("side", "label"), [(1, "P(2;2:0)"), (-1, "P(2;1:1)")])
def test_a_box_beside_the_strobe_is_taken_wider_than_it_is(side, label):
    """It is 1.02 times as wide, and the strobe itself is known to 1e-12 rad."""
    impacts = [(2.0 + side * 1e-11, 0), (3.0, 0)]
    assert label_of(impacts, label, turns=2, error=8.8e-12) is None
    assert label_of(impacts, label, turns=2, error=8.9e-12) == ProofStep.STROBE


# -- which proof


@pytest.mark.parametrize("bounces", [True, False])
@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("parameter", ["rpm", "mass"])
@pytest.mark.parametrize("half", [0.0, 0.125])
def test_an_orbit_is_proved_by_its_equations_or_by_its_motion(
    monkeypatch, bounces, free, parameter, half
):
    """Without equations it is the machine at the orbit's value, and widely at a speed only."""
    for name in ("_bouncing", "_free", "_resting"):
        monkeypatch.setattr(
            proofs, name, lambda *of, name=name, **more: Stub(name=name, of=of, more=more)
        )
    monkeypatch.setattr(proofs, "table_of", lambda system, rpm: ("table", system, rpm))
    monkeypatch.setattr(proofs, "machine_at", lambda *of: ("at", *of))
    monkeypatch.setattr(proofs, "with_machine", lambda *of: (("system", *of), 9.0))
    orbit = Stub(theta=(1.0,), rpm=700.0, value=2.5, root="root" if bounces else None, free=free,
                 stable="stable", label="P(1;1)")  # fmt: skip
    found = proofs.prove_orbit("given", orbit, parameter, half)
    if bounces:
        assert found.name == "_bouncing"
        assert found.of == ("given", "root", "stable", half, "P(1;1)")
        return
    if half and parameter == "mass":
        assert found == proofs.Proof(ProofStep.MODEL)
        return
    table = ("table", "given", 700.0)
    there = ("system", "given", ("at", "given", table, "mass", 2.5))
    assert found.name == ("_free" if free else "_resting")
    assert (found.of, found.more) == (
        ("given" if parameter == "rpm" else there, orbit), {"widely": half > 0.0},
    )  # fmt: skip


@pytest.mark.parametrize("kind", [Kind.GRAZING, Kind.FOLD])
@pytest.mark.parametrize("fading", [None, 1])
def test_a_point_of_a_curve_is_an_event_of_its_own_root(monkeypatch, kind, fading):
    """A graze is looked for from the place where this flight comes nearest to the cam."""
    root = root_of([(1.0, 0.5, 0, 0), (4.0, 0.25, 1, 1)], 650.0)
    located = Located(kind, root_of([(9.0, 0.5, 0, 0)]), 0.5, 0.25, Bracket.OK, impact=1,
                      phase=3.0, fading=fading)  # fmt: skip
    curve = Stub(kind=kind, located=located, corner="b")
    monkeypatch.setattr(proofs, "with_machine", lambda *of: ("changed", of))
    monkeypatch.setattr(proofs, "Shooter", lambda *of: ("shooter", *of))
    monkeypatch.setattr(proofs, "prove_event", lambda *of: of)
    asked = []
    monkeypatch.setattr(proofs, "touch_near", lambda *of: (asked.append(of), (7.0, 0.125))[1])
    point = Stub(orbit=Stub(root=root))
    system = Stub(member=None)
    of_system, event, name = proofs.prove_on_curve(system, curve, point)
    assert (of_system, name, event.value, event.kind) == (system, "rpm", 650.0, kind)
    assert (event.orbit, event.corner, event.error) == (point.orbit, "b", 0.0)
    moved = kind == Kind.GRAZING and fading is None
    shooter = ("shooter", "changed", (system, (700.0,)), "rpm")
    assert asked == ([(shooter, root, replace(located, root=root))] if moved else [])
    assert event.located == replace(located, root=root, phase=4.125 if moved else 3.0)
    for nothing in (Stub(kind=kind, located=None), curve):
        gone = Stub(orbit=Stub(root=None if nothing is curve else root))
        assert proofs.prove_on_curve(system, nothing, gone) == proofs.Proof(ProofStep.MODEL)


# -- an orbit without impacts


@pytest.mark.parametrize("widely", [True, False])
def test_a_machine_is_that_of_a_speed_or_of_all_that_round_to_it(monkeypatch, widely):
    class Made:
        def __init__(self, *of):
            self.of = of

        @classmethod
        def within_last_digit(cls, *of):
            return cls("widely", *of)

    monkeypatch.setattr(proofs, "BallMachine", Made)
    machine = proofs._machine(Stub(shape="shape", follower="follower"), 700.0, widely)
    assert machine.of == (*(["widely"] if widely else []), "shape", "follower", 700.0)


@pytest.mark.parametrize(
    ("trace", "stable", "z", "clears", "step"),
    [
        (1.35, True, 0.25, True, None),  # the determinant is exp(-1) = 0.368
        (-1.35, True, 0.25, True, None),
        (1.4, True, 0.25, True, ProofStep.NEUTRAL),
        (-1.4, True, 0.25, True, ProofStep.NEUTRAL),
        (1.35, False, 0.25, True, ProofStep.NEUTRAL),
        (0.5, True, 0.0, True, ProofStep.NEUTRAL),  # undamped
        (1.35, True, 0.25, False, ProofStep.CONTACT),
        (1.35, True, 0.25, None, ProofStep.GRAZES),
    ],
)
def test_a_follower_that_never_lands_has_the_multipliers_of_its_flight(
    monkeypatch, trace, stable, z, clears, step
):
    def flow(turn):
        assert turn == 2
        return "b", arb(trace) + 1, arb(4)  # trace = 1 - 4/2 + b'

    def clear(machine, follower):
        if clears is None:
            raise UndecidedError
        return clears

    machine = Stub(flow=flow, turn=arb(2), W2=arb(0.5), Z=arb(z))
    asked = []
    monkeypatch.setattr(proofs, "_machine", lambda *of: (asked.append(of), machine)[1])
    monkeypatch.setattr(proofs, "_clears", clear)
    follower = Stub(mass=2.0, gravity=8.0, preload=-26.0, stiffness=4.0)
    system = Stub(follower=follower)
    orbit = Stub(rpm=700.0, stable=stable)
    if step is not None:
        with pytest.raises(NotProvedError) as failed:
            proofs._free(system, orbit, widely="widely")
        assert failed.value.step == step
        assert failed.value.refuted is (step == ProofStep.CONTACT)
    else:
        (height,) = proofs._free(system, orbit, widely="widely").box
        assert float(arb(height)) == 2.5  # (26 - 2 8)/4
    assert asked == [(system, 700.0, "widely")]


# -- the end of an orbit that rests


class Motion:
    """A motion whose steps a test writes: each passes a strobe (s) or leaves the cam (l)."""

    def __init__(self, steps, starts):
        self.steps, self.starts = list(steps), starts
        self.trail = Stub(states=["first"], leaves=[])

    def __call__(self, *of):
        self.starts.append(of)
        return self

    def step(self):
        kind = self.steps.pop(0)
        (self.trail.states if kind == "s" else self.trail.leaves).append(kind)


CLOSED = Stub(symbols=(1.0, 0.0), leaves=["a", "b"])


@pytest.mark.parametrize(
    ("steps", "closed", "keeps"),
    [
        ("lsl", {2: CLOSED}, True),
        ("slsll", {3: CLOSED}, True),  # of three states, at the beginnings and the end of two turns
        ("sslsl", {2: CLOSED}, False),
        ("sss", {}, False),
        ("ll", {2: Stub(symbols=(0.0, 1.0), leaves=["a", "b"])}, True),  # from another turn on
        ("ll", {2: Stub(symbols=(1.0, 1.0), leaves=["a", "b"])}, False),
        ("ll", {2: Stub(symbols=(1.0, 0.0), leaves=["a"])}, False),
        ("l", {1: Stub(symbols=(1.0, 0.0), leaves=["a", "b", "c"])}, False),
    ],
)
def test_an_orbit_that_rests_is_kept_where_its_motion_repeats(monkeypatch, steps, closed, keeps):
    """After a departure it is asked whether it has closed; no more than a turn beyond its own."""
    starts = []
    motion = Motion(steps, starts)
    monkeypatch.setattr(proofs, "_with_parameter", lambda *of: ("shape", "follower", "rpm"))
    monkeypatch.setattr(proofs, "BallMachine", lambda *of: of)
    monkeypatch.setattr(proofs, "BallMotion", motion)
    asked = []

    def cycle(of):
        asked.append(len(of.trail.leaves))
        return closed.get(len(of.trail.leaves))

    monkeypatch.setattr(proofs, "cycle", cycle)
    orbit = Stub(rpm=700.0, free=False, theta=(1.5, 2.5), turns=2, label=Label((1.0, 0.0)))
    system = Stub(strobe=0.25)
    assert proofs._keeps(system, "mass", orbit, "p", Kind.ITINERARY) is keeps
    assert starts == [(("shape", "follower", "rpm"), 0.25, 1.5)]
    assert asked == list(range(1, len(motion.trail.leaves) + 1))
    assert len(motion.trail.states) <= 4


@pytest.mark.parametrize("departures", [(), (1.5,)])
@pytest.mark.parametrize("kind", [Kind.DETACHMENT, Kind.ITINERARY])
@pytest.mark.parametrize("endless", [True, False])
def test_a_follower_that_rests_for_good_has_no_departure(monkeypatch, departures, kind, endless):
    """At a detachment it is followed from the angle zero on."""
    starts = []

    def motion(*of):
        starts.append(of[1:])
        if endless:
            raise EndlessError
        return Stub(trail=Stub(states=[0] * 9, leaves=[]))

    monkeypatch.setattr(proofs, "_with_parameter", lambda *of: ("shape", "follower", "rpm"))
    monkeypatch.setattr(proofs, "BallMachine", lambda *of: of)
    monkeypatch.setattr(proofs, "BallMotion", motion)
    orbit = Stub(rpm=700.0, free=False, theta=departures, turns=2, label=Label((1.0, 0.0)))
    kept = proofs._keeps(Stub(strobe=0.25), "mass", orbit, "p", kind)
    start = departures[0] if departures and kind == Kind.ITINERARY else 0.0
    assert starts == [(0.25, start)]
    if endless:
        assert kept is (not departures)
    else:
        assert kept is (kind == Kind.DETACHMENT and bool(departures))


def test_a_free_orbit_is_kept_where_the_cam_stays_below_it(monkeypatch):
    asked = []
    monkeypatch.setattr(
        proofs, "_with_parameter", lambda *of: (asked.append(of), ("shape", "follower", "rpm"))[1]
    )
    monkeypatch.setattr(proofs, "BallMachine", lambda *of: of)
    monkeypatch.setattr(proofs, "_clears", lambda *of: of)
    orbit = Stub(rpm=700.0, free=True)
    found = proofs._keeps("system", "mass", orbit, "p", Kind.GRAZING)
    assert found == (("shape", "follower", "rpm"), "follower")
    assert asked == [("system", 700.0, "mass", "p")]


def test_a_parameter_is_the_speed_a_constant_or_a_number_of_the_cam(monkeypatch):
    follower = Follower(mass=1.0, stiffness=2.0, damping=0.25, gravity=3.0, restitution=0.5)
    system = Stub(shape="shape", follower=follower)
    assert proofs._with_parameter(system, 700.0, "rpm", 650.0) == ("shape", follower, 650.0)
    shape, changed, rpm = proofs._with_parameter(system, 700.0, "stiffness", 4.0)
    assert (shape, changed, rpm) == ("shape", replace(follower, stiffness=4.0), 700.0)
    monkeypatch.setattr(proofs, "can_vary", lambda shape, name: name == "cam.base")
    monkeypatch.setattr(proofs, "varied_machine", lambda *of: of)
    found = proofs._with_parameter(system, 700.0, "cam.base", 0.5)
    assert found == ("shape", follower, 700.0, "cam.base", 0.5)
    assert refused(proofs._with_parameter, system, 700.0, "cam.lift", 0.5) == ProofStep.CAM


@pytest.mark.parametrize("widely", [True, False])
def test_a_motion_behind_a_rest_is_followed_from_its_first_departure(monkeypatch, widely):
    asked = []
    after = Stub(kind=proofs.CYCLE, symbols=(1.0, 0.0), leaves=[(0, 1.5), (1, 0.25)])
    monkeypatch.setattr(proofs, "of_machine", lambda *of: (asked.append(of), after)[1])
    orbit = Stub(label=Label((1.0, 0.0)), theta=(1.5, 0.25), rpm=700.0)
    assert proofs._resting("system", orbit, widely).box == ("1.5", "0.25")
    assert asked == [("system", 700.0, 1.5, widely)]
