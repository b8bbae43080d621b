"""What is asked of the box of one orbit, by equations that are stand-ins with values by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace as Stub

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.evidence import Evidence
from camcli.analysis.orbits.shooter import Root
from camcli.exact.shooting import Box, NotProvedError, Place, ProofStep
from camcli.system import CONSTANTS


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
