"""What the pieces of a run are called, of which each may fail alone: a fault is told by this name.

Every piece that a command begins is written down here by a stand-in for what begins it.
`tests/cli/test_pieces.py` lets pieces fail.
"""

from __future__ import annotations

import pytest
from mpmath import mpf

import camcli
from camcli import piece_faults
from camcli.analysis import classify, motion_at_speed
from camcli.analysis.basins import study
from camcli.scene import load_scene
from tests.support import orbit_oracle


@pytest.fixture
def pieces(monkeypatch):
    """The names of the pieces of a run, each once, in the order in which they begin.

    Values of a sweep begin in any order, since threads take them.
    """
    names: dict[str, None] = {}
    real = piece_faults.attempt

    def begun(name, call):
        names[name] = None
        return real(name, call)

    def of(run, **values) -> list[str]:
        names.clear()
        run(load_scene(None, {key.replace("__", "."): x for key, x in values.items()}))
        return list(names)

    monkeypatch.setattr(piece_faults, "attempt", begun)
    for module in (study, classify, motion_at_speed):
        monkeypatch.setattr(module, "attempt", begun)
    return of


def axis(key: str, start: float, stop: float) -> dict:
    return {"key": key, "start": start, "stop": stop, "num": 3}


RANGE = {"start": 735.0, "stop": 741.0, "num": 3}
TABLES = ["proof.json", "the summary", "the notes", "branch.csv", "bifurcations.csv"]
SINGLE = [
    "the orbits of one impact in 1 turn at 737 rpm",
    *(f"the orbits of one impact in {m} turns at 737 rpm" for m in range(2, 7)),
]


def test_of_orbits(pieces):
    found = pieces(camcli.orbits, orbits__rpm=RANGE, orbits__starts=2, orbits__at=737.0)
    assert found == [
        "the orbit without impacts",
        *SINGLE,
        *(f"the motion from start {k} at 737 rpm" for k in range(3)),
        "the branch through P(1;1)",
        "the branch of 1 impact in 1 turn from 737 on",
        "the branch from the period-doubling at 739.3197802",
        "the branch of 2 impacts in 2 turns from 739.3198097 on",
        "the corner impact at c, 739.3779296",
        *TABLES[1:],
        "the orbits in time",
    ]


def test_of_an_unstable_orbit_that_is_sought(pieces):
    """64 motions are tried before: none of them ends on it."""
    found = pieces(camcli.orbits, orbits__rpm={"start": 742.0, "stop": 742.0, "num": 1},
                   orbits__at=742.0, orbits__label="P(2;1:1)", orbits__branches=0,
                   run__transient=20, run__record=10)  # fmt: skip
    assert found[:67] == [
        "the orbit without impacts",
        *(f"the motion from start {k} at 742 rpm" for k in range(65)),
        "the search for P(2;1:1) among close returns",
    ]


def test_of_a_branch_that_rests(pieces):
    label = {"orbits__label": "P(1;inf)", "orbits__starts": 0, "orbits__branches": 0}
    found = pieces(camcli.orbits, orbits__rpm={"start": 185.0, "stop": 195.0, "num": 3},
                   orbits__at=190.0, **label)  # fmt: skip
    assert "the branch of P(1;inf) from 190 up" in found
    assert "the branch of P(1;inf) from 190 down" in found


def test_of_a_curve_and_its_proofs(pieces):
    axes = [axis("rpm", 738.0, 741.0), axis("follower.restitution", 0.798, 0.802)]
    found = pieces(
        lambda scene: camcli.orbits(scene, prove=True), orbits__vary=axes, run__rpm=739.0,
        orbits__curve="period-doubling", orbits__label="P(1;1)", orbits__branches=0,
        orbits__starts=0, orbits__stability="stable",
    )  # fmt: skip
    assert found[:6] == [
        "the orbit without impacts",
        "the orbits of one impact in 1 turn at 739 rpm",
        "the branch through P(1;1)",
        "the branch of 1 impact in 1 turn from 739 on",
        "the curve of the period-doubling at 739.3197802",
        "the points of codimension two on curve 1",
    ]
    proofs = [name for name in found if name.startswith("the proof")]
    assert "the proof of branch 1 at 738.0" in proofs
    assert "the proof of the period-doubling at 739.3197802160017" in proofs
    assert "the proof of branch 1" in proofs
    assert "the proof of curve 1 at 739.3197802160017, 0.8" in proofs
    assert proofs[-1] == "the proof that curve 1 has no gap"
    assert found[-8:] == [*TABLES, "curve.csv", "codim2.csv", "the orbits in time"]


@pytest.mark.ci
def test_of_the_curves_of_a_map(pieces):
    machine = orbit_oracle.CHAPTER._replace(restitution=mpf("0.7995"))
    guess = orbit_oracle.STABLE, 1, 700, 745
    doubling = orbit_oracle.period_doubling_rpm(orbit_oracle.CAM, machine, *guess).rpm
    axes = [axis("rpm", 738.0, 740.5), axis("follower.restitution", 0.7995, 0.8005)]
    found = pieces(
        camcli.sweep, sweep__vary=axes, sweep__curves="auto", run__transient=2, run__record=2,
        run__patience=0, sweep__prove=True,
    )  # fmt: skip
    edges = [name for name in found if name.startswith("the edge")]
    assert edges == [
        "the edge of the map at restitution = 0.7995",
        "the edge of the map at restitution = 0.8005",
        "the edge of the map at rpm = 738.0",
        "the edge of the map at rpm = 740.5",
    ]
    points = {f"follower.restitution = {r}, rpm = {rpm}" for r in (0.7995, 0.8, 0.8005)
              for rpm in (738.0, 739.25, 740.5)}  # fmt: skip
    assert points <= set(found)
    assert "the orbits at rpm = 738.05" in found  # a fiftieth of the edge
    assert "the branch through P(1;1) at rpm = 738.05" in found
    assert f"the branch from the period-doubling at {float(doubling):.10g}" in found
    assert "the orbits at restitution = 0.79952" in found
    assert f"the curve of the period-doubling at {float(doubling):.10g}" in found
    assert "the points of codimension two on curve 1" in found
    assert "the proof that curve 1 has no gap" in found
    assert {"the sentences", "the summary of proofs", "proof.json"} <= set(found)


def test_of_an_explanation(pieces):
    found = pieces(camcli.classify, classify__rpm=RANGE, classify__explain=True,
                   run__transient=200, run__record=100)  # fmt: skip
    assert sorted(found[:3]) == ["rpm = 735.0", "rpm = 738.0", "rpm = 741.0"]
    assert found[3:] == [
        "the explanation",
        "the comparison of P(1;1)",
        "the branch through P(1;1) at 735 rpm",
        "the branch of 1 impact in 1 turn from 735 on",
        "the branch from the period-doubling at 739.3197802 rpm",
        "the branch of 2 impacts in 2 turns from 739.3198097 on",
        "the corner impact at c, 739.3779296",
        "the change from 738.0 to 741.0 rpm",
        "the summary",
    ]


def test_of_an_explanation_of_what_comes_to_rest(pieces):
    found = pieces(camcli.classify, classify__rpm={"start": 110.0, "stop": 120.0, "num": 2},
                   classify__explain=True, run__transient=20, run__record=10)  # fmt: skip
    assert "the study of detachment" in found
    assert "the change from 110.0 to 120.0 rpm" in found


def test_of_basins(pieces, monkeypatch):
    """What is asked for beside the cells is not computed here: it takes seconds."""
    monkeypatch.setattr(study, "uncertainty", lambda *asked: None)
    monkeypatch.setattr(study, "boundary_saddles", lambda *asked: [])
    found = pieces(camcli.basins, basins__rpm={"start": 700.0, "stop": 700.0, "num": 1},
                   basins__cells=[3, 3], basins__saddles=True, basins__boundary=True,
                   basins__exponents=True)  # fmt: skip
    assert [name for name in found if "cells at 700 rpm" not in name and name] == [
        "rpm = 700.0",
        "the boundary at rpm = 700.0",
        "the saddles at rpm = 700.0",
        "the exponent of P(1;1) at rpm = 700.0",
        "the summary",
    ]


def test_of_a_loss_of_contact(pieces):
    found = pieces(camcli.detach, detach__rpm={"start": 650.0, "stop": 700.0, "num": 2},
                   detach__hold_to=1500.0, detach__settle=3)  # fmt: skip
    past = [name for name in found if name.endswith("past the loss of contact")]
    assert [past[0], past[-1], len(past)] == [
        "the motion at 650.0 rpm, past the loss of contact",
        "the motion at 700.0 rpm, past the loss of contact",
        16,
    ]
    assert {"rpm = 650.0", "rpm = 700.0"} <= set(found)
    assert "the chatter from region A2" in found
    assert [name for name in found if "force" in name or "springs" in name] == [
        "the springs that hold to 1500 rpm",
        "the contact force with other springs",
        "the contact force at 650 rpm",
        "the contact force at 700 rpm",
        "the contact force at 1500 rpm",
    ]
