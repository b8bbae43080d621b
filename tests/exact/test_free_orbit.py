"""The orbit that never meets the cam: where it stands, how it attracts, what is proved of it."""

from __future__ import annotations

from dataclasses import replace
from math import ulp
from types import SimpleNamespace

import pytest
from conftest import chapter_system
from flint import arb
from mpmath import cos, exp, matrix, mp, mpf, sin, sqrt

from camcli.analysis.labels import CONTACT
from camcli.analysis.orbits import proofs
from camcli.analysis.orbits.orbit import free_orbit
from camcli.analysis.orbits.proofs import prove_orbit, prove_widely
from camcli.cams.balls import UndecidedError, precision
from camcli.exact.machine import BallMachine
from camcli.exact.shooting import ProofStep
from camcli.system import System

RPM = 700.0
SYSTEM = chapter_system()
TOP = max(SYSTEM.cam.top, 0.0)  # m, at or above the highest point of the cam


def standing(height: float, **changes) -> System:
    """The example's machine with a spring that is in balance with the loads at this height, m."""
    follower = replace(SYSTEM.follower, **changes)
    load = follower.mass * follower.gravity
    return SYSTEM.with_follower(**changes, preload=-follower.stiffness * height - load)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_it_stands_at_the_balance_and_its_flight_is_one_turn_long(gravity):
    system = standing(1.5 * TOP, damping=2.0, gravity=gravity)
    orbit = free_orbit(system, RPM)
    assert (orbit.free, orbit.turns, orbit.rpm, orbit.stable) == (True, 1, RPM, True)
    ((q, v),) = orbit.states
    assert (q, v) == (pytest.approx(1.5 * TOP, rel=1e-12), 0.0)
    with mp.workdps(40):
        f = system.follower
        z = mpf(f.damping) / (2 * mpf(f.mass))  # 1/s
        w = sqrt(mpf(f.stiffness) / mpf(f.mass) - z * z)
        turn = 60 / mpf(RPM)
        decay = exp(-z * turn)
        c, s = cos(w * turn), sin(w * turn)
        carried = decay * matrix([
            [c + z / w * s, s / w], [-(w + z * z / w) * s, c - z / w * s]
        ])  # fmt: skip
        assert orbit.trace == pytest.approx(float(carried[0, 0] + carried[1, 1]), abs=1e-12)
        assert orbit.det == pytest.approx(float(exp(-2 * z * turn)), rel=1e-12)
    for proof, held in ((prove_orbit(system, orbit), "exact-data"),
                        (prove_widely(system, orbit), "last-digit")):  # fmt: skip
        assert proof.proved
        assert proof.holds_for == held
        (box,) = proof.box
        assert abs(arb(box) - q) < 1e-12


@pytest.mark.parametrize(("height", "changes", "step", "refuted"), [
    (1.5 * TOP, {"damping": 0.0}, ProofStep.NEUTRAL, False),  # nothing is lost
    (0.5 * TOP, {"damping": 2.0}, ProofStep.CONTACT, True),
])  # fmt: skip
def test_it_is_not_proved_where_it_does_not_attract_or_meets_the_cam(
    height, changes, step, refuted
):
    orbit = free_orbit(standing(1.5 * TOP, damping=2.0), RPM)
    proof = prove_orbit(standing(height, **changes), orbit)
    assert (proof.step, proof.refuted) == (step, refuted)


def test_there_is_none_where_the_cam_reaches_it_or_no_spring_holds_it():
    assert free_orbit(standing(0.999 * TOP, damping=2.0), RPM) is None
    assert free_orbit(standing(1.001 * TOP, damping=2.0), RPM) is not None
    loose = SYSTEM.with_follower(stiffness=0.0, preload=-1.0)
    assert free_orbit(loose, RPM) is None


@pytest.mark.parametrize("kind", ["free", "contact", "resting"])
@pytest.mark.parametrize("widely", [True, False])
def test_a_proof_for_all_that_reads_alike_is_about_all_these_machines(monkeypatch, kind, widely):
    """The speeds 0.4 ulp to either side are in the machine that is asked, or the double alone."""
    asked: list[BallMachine] = []

    def looked_at(machine, *more):
        asked.append(machine)
        raise UndecidedError

    def followed(system, rpm, theta, all_that_read_alike=False):
        rather = BallMachine.within_last_digit if all_that_read_alike else BallMachine
        looked_at(rather(system.shape, system.follower, rpm))

    for name, stub in {
        "_clears": looked_at,
        "BallMotion": looked_at,
        "of_machine": followed,
    }.items():
        monkeypatch.setattr(proofs, name, stub)
    labels = {"free": "P(1;0)", "contact": CONTACT, "resting": "P(1;inf)"}
    orbit = SimpleNamespace(root=None, theta=(1.0,), free=kind == "free", rpm=RPM, value=RPM,
                            label=labels[kind])  # fmt: skip
    half = ulp(RPM) / 2 if widely else 0.0
    if kind == "resting":
        with pytest.raises(UndecidedError):
            prove_orbit(SYSTEM, orbit, half=half)
    else:
        assert not prove_orbit(SYSTEM, orbit, half=half).proved
    f = SYSTEM.follower
    for machine in asked:
        with precision(60):
            for share in (-0.4, 0.0, 0.4):
                omega = (arb(RPM) + arb(share) * arb(ulp(RPM))) * arb.pi() / 30
                of_speed = arb(f.stiffness) / arb(f.mass) / omega**2
                assert machine.W2.overlaps(of_speed) == (widely or share == 0.0)
    assert asked
