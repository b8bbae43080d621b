"""The critical numbers of the cam-follower example, proved, as the guide prints them.

Every enclosure is found in ball arithmetic from the example's numbers as doubles; the published
digits lie in it or beside it within their own rounding.
"""

from pathlib import Path

import pytest
from conftest import chapter_system
from flint import arb

import camcli
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.proofs import prove_event
from camcli.cams.balls import UndecidedError, below, precision
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion
from camcli.scene import load_scene
from tests.support.kernel_runs import ORACLE_CAM

pytestmark = pytest.mark.slow

SYSTEM = chapter_system()
GUIDE = Path(__file__).parents[2] / "camcli" / "guide"
PRINTED = (GUIDE / "explanation" / "proofs.md").read_text(encoding="utf-8")
DIGITS = 20
B, C = (float(ORACLE_CAM.breakpoints[k]) for k in (1, 2))
HITS = {1: 124.998297, 8: 120.165355}  # rpm at which so many impacts end on corner c


def events(low, high, at, **section):
    """The events of the branches followed through a range."""
    values = {"rpm.start": low, "rpm.stop": high, "rpm.num": 40, "at": at, "starts": 0, **section}
    scene = load_scene(None, {f"orbits.{key}": value for key, value in values.items()})
    return camcli.orbits(scene).values.bifurcations


@pytest.fixture(scope="module")
def found():
    """Every event by kind, label and corner."""
    ranges = [
        events(672.0, 741.0, 700.0),
        events(354.0, 378.0, 358.5, label="P(1;2)", branches=0),
        events(357.0, 360.0, 358.5, label="P(3;3:3:2)", branches=0),
        events(110.0, 199.0, 190.0),
    ]
    return {(b.kind, b.label, b.corner): b for some in ranges for b in some}


def printed(ball):
    """The digits of a ball that are certain, 20 at most."""
    return ball.str(DIGITS, radius=False)


LOCATED = {
    ("corner-impact", "P(1;1)", "b"): 673.2344450038,
    ("period-doubling", "P(1;1)", ""): 739.3197802160,
    ("corner-impact", "P(2;1:1)", "c"): 739.3779296493,
    ("corner-impact", "P(1;2)", "b"): 355.1545237,
    ("period-doubling", "P(1;2)", ""): 377.1688395,
    ("fold", "P(3;3:3:2)", ""): 357.7983059,
    ("period-doubling", "P(3;3:3:2)", ""): 359.6205256,
    ("detachment", "P(1;inf)", "b"): 114.979326744,
}


@pytest.mark.parametrize("name", LOCATED)
def test_events_of_branches(found, name):
    proof = prove_event(SYSTEM, found[name])
    assert proof.proved
    with precision(proofs.DIGITS[0]):
        value = arb(proof.value)
        assert float(value) == pytest.approx(LOCATED[name], abs=6e-8)
        assert value.rad() < 1e-17
        assert printed(value) in PRINTED


def test_the_chatter_that_is_no_longer_complete(found):
    """Below it every chatter of P(1;inf) ends before corner b, above it no orbit closes there."""
    proof = prove_event(SYSTEM, found["chatter-completion", "P(1;inf)", "b"])
    assert proof.proved
    with precision(proofs.DIGITS[0]):
        value = arb(proof.value)
        assert abs(value - arb("198.560511432")) < 1e-9
        assert printed(value) in PRINTED


def test_the_multipliers_turn_real():
    """trace^2 = 4 det, where both multipliers meet: a simple zero along the branch."""
    scene = load_scene(None, {"orbits.rpm.start": 738.7, "orbits.rpm.stop": 738.7})
    orbit = next(o for o in camcli.orbits(scene).values.orbits if o.stable)
    with precision(proofs.DIGITS[0]):
        shooting = proofs.shooting_of(SYSTEM, orbit.root)

        def apart(z):
            trace, det = shooting.trace_det(z)
            return trace * trace - 4 * det

        box, _ = shooting.zero([arb(x) for x in orbit.root.x], 2, apart)
        value = box.hull()[-1]
        assert abs(value - arb("738.7743752")) < 6e-8
        assert printed(value) in PRINTED


def phase_of_hit(n, rpm):
    """Phase of the n-th impact after the first departure, rad."""
    motion = BallMotion(BallMachine(SYSTEM.shape, SYSTEM.follower, rpm), SYSTEM.strobe, B)
    while len(motion.trail.impacts) < n:
        motion.step()
    return motion.trail.impacts[n - 1][0]


@pytest.mark.parametrize("n", HITS)
def test_the_nth_impact_lands_on_c(n):
    """Before it the n-th impact comes before the corner, after it later: certain at both ends."""
    with precision(proofs.DIGITS[0]):
        corner = next(s.end for s in BallMachine(SYSTEM.shape, SYSTEM.follower, 1.0).stretches
                      if abs(s.end - C) < 1e-9)  # fmt: skip
        low, high = (arb(HITS[n]) + side * arb("1e-6") for side in (-1, 1))
        assert phase_of_hit(n, low) < corner < phase_of_hit(n, high)
        for _ in range(60):
            middle = (low + (high - low) * 5 / 11).mid()
            try:
                before = below(phase_of_hit(n, middle), corner)
            except UndecidedError:
                break
            low, high = (middle, high) if before else (low, middle)
        value = low.union(high)
        assert value.rad() < 1e-17
        assert printed(value) in PRINTED
