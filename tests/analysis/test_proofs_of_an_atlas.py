"""Which curves and points of an atlas are proved: those of orbits of so few turns."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from camcli.analysis.orbits import codim2, curve_proofs
from camcli.analysis.orbits.atlas import Atlas, prove_atlas
from camcli.exact.shooting import ProofStep
from camcli.piece_faults import gathering


@dataclass(frozen=True)
class Point:
    """A point of codimension two as the proofs ask it."""

    orbit: object
    first: float
    second: float = 0.5
    kind: str = "fold-flip"
    proof: object = None


def curve(turns: int, begin: float):
    """A curve of orbits of so many turns, of three points."""
    points = [
        SimpleNamespace(
            orbit=SimpleNamespace(turns=turns), first=begin + k, second=0.1, values=(begin + k, 0.1)
        )
        for k in range(3)
    ]
    return SimpleNamespace(points=points)


@pytest.mark.parametrize(("most", "proved"), [(0, []), (1, [1]), (2, [1, 3]), (3, [1, 2, 3])])
def test_curves_and_points_of_few_turns_are_proved(monkeypatch, most, proved):
    asked = []

    def prove_curve(system, one, number, plane):
        asked.append((system, one, number, plane))
        return [f"part of {number}", f"another of {number}"]

    monkeypatch.setattr(curve_proofs, "prove_curve", prove_curve)
    monkeypatch.setattr(codim2, "prove", lambda point: f"of {point.first}")
    turns = (1, 3, 2)
    atlas = Atlas("plane", [curve(n, 10.0 * k) for k, n in enumerate(turns, 1)])
    atlas.points = [Point(SimpleNamespace(turns=n), float(k)) for k, n in enumerate(turns, 1)]
    steps = []
    prove_atlas(lambda *at: (f"machine at {at}", None), atlas, most, lambda: steps.append(1))
    assert atlas.ranges == [part for n in proved for part in (f"part of {n}", f"another of {n}")]
    assert [point.proof for point in atlas.points] == [
        f"of {float(n)}" if n in proved else None for n in (1, 2, 3)
    ]
    assert len(steps) == 3
    assert asked == [
        (f"machine at {(10.0 * n, 0.1)}", atlas.curves[n - 1], n, "plane") for n in proved
    ]


def test_a_fault_is_the_reason_of_a_proof_that_there_is_not(monkeypatch):
    def fails(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(curve_proofs, "prove_curve", fails)
    monkeypatch.setattr(codim2, "prove", fails)
    atlas = Atlas("plane", [curve(1, 10.0)], [Point(SimpleNamespace(turns=1), 1.0)])
    with gathering() as faults:
        prove_atlas(lambda *at: ("machine", None), atlas, 1, lambda: None)
    ((part,), (point,)) = (atlas.ranges, atlas.points)
    places = ((10.0, 0.1), (12.0, 0.1))
    assert part == curve_proofs.CurveRange(1, 1, 3, places, 0, ProofStep.FAULT)
    assert point.proof.step is ProofStep.FAULT
    assert len(faults) == 2
    assert atlas.not_tried == []
