"""What becomes of an attractor behind a tangency, by motions that leave along the saddle.

The motions, the saddle and the tangency are written down here; the box of the attractor is |q| < 1.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from camcli.analysis.explain import crisis
from camcli.analysis.explain.crisis import CrisisKind, find_crisis
from camcli.analysis.explain.tangency import FirstTouch
from camcli.analysis.integrate import Cost, StartError

TURNS = 100  # of a motion, the second half of which counts
INSIDE, OUTSIDE = (0.5, 0.0), (2.0, 0.0)


class Carried:
    """An attractor carried from one speed to another, which leaves its box between them.

    It does between 704 and 705 rpm, as is known once that range has been narrowed.
    """

    ends, cost, size, turns = (1, 2), Cost(), (1.0, 1.0), TURNS
    stays, leaves = 700.0, 710.0
    has_left = staticmethod(bool)

    def __init__(self, motions):
        self.motions, self.begun, self.measured = motions, [], []

    def narrow(self):
        self.stays, self.leaves = 704.0, 705.0

    def measure(self, *at):
        self.measured.append(at)

    def run(self, rpm, events=False):
        return "run", rpm

    def way(self, rpm):
        return rpm

    def outside(self, states):
        return int((np.abs(states[:, 0]) > 1.0).sum())

    def states(self, rpm, state, turns):
        """The motion from a state, which may lie below the cam."""
        self.begun.append((rpm, state, turns))
        found = self.motions[len(self.begun) - 1]
        if found is None:
            raise StartError
        return np.array(found)


@pytest.fixture
def crisis_of(monkeypatch):
    """What is found, and the carried attractor that was asked."""

    def of(motions, run=(), side=1.0, touches=True):
        saddle = SimpleNamespace(leaf=lambda along, across: (along, across), orbit="p")
        folds = SimpleNamespace(
            carried=Carried(motions),
            side=side,
            at=lambda rpm: (None, saddle),
            corner=lambda fold: None,
        )
        orbit = SimpleNamespace(multipliers=(2.0 + 0j, 0.1 + 0j))
        for name, stub in {
            "CarriedAttractor": lambda *_: folds.carried, "Folds": lambda *_: folds,
            "first_touch": lambda *_: (
                FirstTouch(SimpleNamespace(rpm=704.5), 0.1) if touches else None),
            "label": lambda record: "aperiodic", "inner_side": lambda *_: side,
            "find_saddles": lambda *_: [orbit], "same_orbit": lambda a, b: a is b,
            "states_of": lambda record: np.array(run) if record == ("run", 705.0) else None,
        }.items():  # fmt: skip
            monkeypatch.setattr(crisis, name, stub)
        return find_crisis(None, None, 700.0, 710.0, TURNS), folds.carried

    return of


@pytest.fixture
def kind_of(crisis_of):
    """The kind that is found, and the starts that were tried: (rpm, eta, xi, turns)."""

    def of(motions, run=(), side=1.0):
        found, carried = crisis_of(motions, run, side)
        return found.kind, [(rpm, *state, turns) for rpm, state, turns in carried.begun]

    return of


def motion(returned: int) -> list:
    """A motion that leaves at once, and is so often back in the second half of its turns."""
    return [OUTSIDE] * (TURNS - returned) + [INSIDE] * returned


@pytest.mark.parametrize(
    ("returned", "kind"),
    [
        (0, CrisisKind.BOUNDARY), (16, CrisisKind.BOUNDARY),
        (17, CrisisKind.INTERIOR), (50, CrisisKind.INTERIOR),
    ],
)  # fmt: skip
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_comes_back_is_an_interior_crisis(kind_of, returned, kind, side):
    """From a little across the saddle, on the side that leads away from the attractor."""
    found, begun = kind_of([motion(returned)], side=side)
    assert found is kind
    assert begun == [(704.5, 0.0, -side * 1e-6, TURNS)]


def test_the_first_half_of_a_motion_does_not_count(kind_of):
    assert kind_of([motion(50)[::-1]])[0] is CrisisKind.BOUNDARY


def test_starts_below_the_cam_are_passed_over(kind_of):
    """The next one is nearer to the saddle; where all fail the run that left is asked."""
    found, begun = kind_of([None, None, motion(50)])
    assert found is CrisisKind.INTERIOR
    assert [across for _, _, across, _ in begun] == [-1e-6, -1e-8, -1e-10]
    for run, kind in ((motion(50), CrisisKind.INTERIOR), (motion(0), CrisisKind.BOUNDARY)):
        assert kind_of([None, None, None], run)[0] is kind


def test_what_is_said_of_a_crisis(crisis_of):
    """Saddles are looked for at four fifths of the way to where the attractor leaves."""
    found, carried = crisis_of([motion(0)])
    assert (found.bracket, found.near, found.turns) == ((704.0, 705.0), 700.0, TURNS)
    assert (found.rpm, found.error, found.corner) == (704.5, 0.1, None)
    assert [(one.rpm, one.error) for one in found.met] == [(704.5, 0.1)]
    assert (found.inside, found.beyond, found.unmet, found.lost) == (1, 1, (), 0)
    calm = 700.0 + 0.8 * 4.0
    assert carried.measured == [(calm, ("run", calm))]


def test_what_is_said_where_nothing_touches(crisis_of):
    found, _ = crisis_of([], touches=False)
    assert found.kind is CrisisKind.UNEXPLAINED
    assert (found.rpm, found.error, found.bracket) == (705.0, 1.0, (704.0, 705.0))
    assert (len(found.met), len(found.unmet)) == (0, 1)
