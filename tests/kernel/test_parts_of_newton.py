"""Parts of a Newton step on an orbit, on an orbit of three impacts of which two are on the seat."""

from __future__ import annotations

from types import SimpleNamespace as Made

import numpy as np
import pytest
from mpmath import mp

from camcli.kernel import shooting
from camcli.kernel.bordered import BLOCK, LEFT, RESIDUAL, RIGHT
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.flow import (
    DAMPING,
    GRAVITY,
    MASS,
    PRELOAD,
    RESTITUTION,
    RPM,
    SEAT_RESTITUTION,
    STIFFNESS,
    constants_of,
)
from tests.conftest import chapter_system

TURNS, N = 3, 3
FOLLOWER = {"damping": 3.0, "gravity": 9.75, "preload": 20.0, "restitution": 0.75}


def machine_with(**changes) -> tuple:
    """(cam, machine): the last stretch of the cam is the seat, with a restitution of 1/2."""
    system = chapter_system(**{**FOLLOWER, **changes})
    stretches = [*system.cam.stretches[:-1], system.cam.stretches[-1]._replace(seat=1)]
    machine = list(system.machine(700.0))
    machine[SEAT_RESTITUTION] = 0.5
    return system.cam._replace(stretches=stretches), machine


def orbit(cam) -> tuple[list[float], list[int]]:
    """x and whole: impacts in the turns 2, 3 and 3, the last two on the seat."""
    seat = cam.stretches[-1]
    phases = (2.5, 0.5 * (seat.start + seat.end), seat.end - 0.25)
    x = [phases[0], 0.5, phases[1], 1.5, phases[2], 0.25, 700.0]
    whole = [v for theta, turn in zip(phases, (2, 3, 3), strict=True)
             for v in (stretch_at(cam, theta), turn)]  # fmt: skip
    return x, whole


def losses(cam, const, x, k) -> np.ndarray:
    """E1 and E2 of flight k by the exponential of its equation; r of the stretch it lands on."""
    j = (k + 1) % N
    spans = [x[2] - x[0] + TURN, x[4] - x[2], x[0] - x[4] + (TURNS - 1) * TURN]
    c, c1, _ = lift_at(cam, stretch_at(cam, x[2 * k]), x[2 * k])
    rates = mp.matrix([[0, 1, 0], [-(const.W**2), -2 * const.Z, -const.G], [0, 0, 0]])
    end = mp.expm(rates * spans[k]) * mp.matrix([c, c1 + x[2 * k + 1], 1])
    i = stretch_at(cam, x[2 * j])
    c, c1, _ = lift_at(cam, i, x[2 * j])
    r = const.r_seat if i == len(cam.stretches) - 1 else const.r
    return np.array([float(end[0]) - c, r * (float(end[1]) - c1) + x[2 * j + 1]])


@pytest.mark.parametrize("k", range(N))
def test_the_block_of_a_flight_has_its_losses_and_their_derivatives(k):
    cam, machine = machine_with()
    const = constants_of(machine, 0.0, 0)
    x, whole = orbit(cam)
    blocks = [0.0] * (BLOCK * N)
    shooting.fill_block(cam, const, x, whole, TURNS, k, N, blocks)
    block = blocks[BLOCK * k : BLOCK * (k + 1)]
    r = 0.5 if k < 2 else 0.75
    assert block[RESIDUAL:] == pytest.approx(losses(cam, const, x, k), abs=1e-12)
    for start, impact in ((LEFT, k), (RIGHT, (k + 1) % N)):
        for c in (0, 1):
            sides = []
            for h in (1e-5, -1e-5):
                moved = list(x)
                moved[2 * impact + c] += h
                sides.append(losses(cam, const, moved, k))
            slopes = (sides[0] - sides[1]) / 2e-5
            if start == RIGHT and c == 0:  # the acceleration there is that of a gap of zero
                slopes[1] += r * const.W2 * block[RESIDUAL]
            found = [block[start + c], block[start + 2 + c]]
            assert found == pytest.approx(list(slopes), rel=1e-6, abs=1e-6)


def test_the_column_of_a_parameter_holds_the_restitution_that_is_met():
    """That of the seat counts where an impact is on it, and that of the cam elsewhere."""
    cam, machine = machine_with()
    x, whole = orbit(cam)
    for parameter, value in ((RESTITUTION, 0.75), (SEAT_RESTITUTION, 0.5), (PRELOAD, 20.0)):
        given = [*x[:-1], value]
        t = Made(blocks=[0.0] * (BLOCK * N), columns=[0.0] * (2 * N))
        shooting.fill_tables(cam, machine, parameter, N, TURNS, whole, given, 1.0, t)
        h = 1e-4
        for k in range(N):
            sides = []
            for side in (1, -1):
                other = list(machine)
                other[parameter] = value + side * h
                sides.append(losses(cam, constants_of(other, 0.0, 0), x, k))
            slopes = (sides[0] - sides[1]) / (2 * h)
            assert t.columns[2 * k : 2 * k + 2] == pytest.approx(slopes, rel=1e-6, abs=1e-8)


def test_the_trace_is_that_of_the_product_of_the_maps(monkeypatch):
    """By differences of the losses: d_(k+1) = -R^-1 L d_k, and at equal phase the same trace."""
    cam, machine = machine_with()
    const = constants_of(machine, 0.0, 0)
    x, whole = orbit(cam)
    blocks = [0.0] * (BLOCK * N)
    rates = [0.0] * N
    # Each flight is given the end that it has on an orbit, where v' = -r u and the gap is zero.
    ends = {}
    for k in range(N):
        j = (k + 1) % N
        on_seat = whole[2 * j] == len(cam.stretches) - 1
        ends[k] = (0.0, -x[2 * j + 1] / (0.5 if on_seat else 0.75))
    monkeypatch.setattr(shooting, "arrival", lambda cam, const, x, whole, turns, k, n: ends[k])
    product = np.eye(2)
    for k in range(N):
        shooting.fill_block(cam, const, x, whole, TURNS, k, N, blocks)
        left = np.reshape(blocks[BLOCK * k + LEFT : BLOCK * k + LEFT + 4], (2, 2))
        right = np.reshape(blocks[BLOCK * k + RIGHT : BLOCK * k + RIGHT + 4], (2, 2))
        product = -np.linalg.inv(right) @ left @ product
    trace = shooting.rates_and_trace(cam, machine, N, TURNS, whole, x, rates)
    assert trace == pytest.approx(np.trace(product), rel=1e-9)
    assert rates == [ends[N - 1][1], ends[0][1], ends[1][1]]
    ends[1] = (0.0, 0.0)
    assert shooting.rates_and_trace(cam, machine, N, TURNS, whole, x, rates) == shooting.NO_TRACE


@pytest.mark.parametrize(("parameter", "below", "zero"), [
    (RPM, False, False), (MASS, False, False), (STIFFNESS, False, True), (DAMPING, False, True),
    (SEAT_RESTITUTION, False, True), (GRAVITY, True, True), (PRELOAD, True, True),
])  # fmt: skip
def test_which_values_a_machine_may_have(parameter, below, zero):
    assert shooting._meaningful(parameter, 1e-300)
    assert shooting._meaningful(parameter, 0.0) == zero
    assert shooting._meaningful(parameter, -1e-300) == below
    _, machine = machine_with()
    half = 1e-5 * 2.0
    given = list(machine)
    value = half / 2  # nearer to zero than the difference is wide
    _, low, high, width = shooting._difference(given, parameter, value, 2.0)
    assert given[parameter] == value
    assert width == pytest.approx(2 * half if below else half, rel=1e-9)
    for const, at in ((low, value - half if below else value), (high, value + half)):
        assert const == constants_of([*machine[:parameter], at, *machine[parameter + 1 :]], 0.0, 0)
    large = shooting._difference(given, parameter, 300.0, 2.0)
    assert large[3] == pytest.approx(2 * 300.0 * 1e-5)


def test_an_impact_may_lie_beyond_its_stretch_by_nine_tenths_of_a_piece():
    rows = [Made(start=0.0, end=9.0, per_angle=0.1), Made(start=1.0, end=2.0, per_angle=4.0)]
    cam = Made(stretches=rows)
    for phase, within in ((0.776, True), (0.774, False), (2.224, True), (2.226, False)):
        assert shooting.within_reach(cam, 1, [1, 0], [phase, 0.0]) == within
        assert shooting.within_reach(cam, 2, [0, 0, 1, 0], [5.0, 0.0, phase, 0.0]) == within


@pytest.mark.parametrize(("step", "size"), [
    ([0.25, 0, 0, 0, 0], 0.25), ([0, 0, -0.25, 0, 0], 0.25), ([0, 2.0, 0, 0, 0], 0.25),
    ([0, 0, 0, -2.0, 0], 0.25), ([0, 0, 0, 0, 25.0], 0.2), ([0, 0, 0, 0, -25.0], 0.25),
    ([0.125, 2.0, 0.5, -1.0, 5.0], 0.5),
])  # fmt: skip
def test_a_step_is_as_large_as_its_largest_entry(step, size):
    """A rate counts against the largest one, 8, be it outgoing, incoming or the border's."""
    for outgoing, incoming, rate in ((8.0, -1.0, 1.0), (-8.0, 1.0, 1.0), (1.0, -8.0, 1.0),
                                     (1.0, -1.0, 8.0)):  # fmt: skip
        x = [1.0, 0.5, 2.0, outgoing, 100.0]
        t = Made(step=step, blocks=[0.0] * (2 * BLOCK))
        t.blocks[RIGHT], t.blocks[BLOCK + RIGHT] = -0.5, incoming
        before = list(x)
        border = Made(rate=rate, scale=1.0)
        assert shooting.take_step(2, x, t, border) == pytest.approx(size)
        assert x == [a + b for a, b in zip(before, step, strict=True)]
    x = [1.0, 0.5, 2.0, 1.0, 0.5]
    t.step = [0.0, 0.0, 0.0, 0.0, 0.25]
    assert shooting.take_step(2, x, t, Made(rate=1.0, scale=2.0)) == 0.125
