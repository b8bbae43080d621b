"""The prover's equations of an orbit by differences, and its boxes on equations chosen by hand."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.cams.balls import UndecidedError
from camcli.exact import shooting as module
from camcli.exact.machine import BallMachine, BallStretch, Place
from camcli.exact.shooting import (
    Box,
    ImpactSlopes,
    NotProvedError,
    ProofStep,
    Shooting,
    StateSlopes,
    Touch,
    box_of,
)
from camcli.system import Follower

TURN = 2.0 * pi
FOLLOWER = Follower(1.5, 700.0, 11.0, 9.0, 13.0, 0.75, seat_restitution=0.2)
STEP = arb(2) ** -80
CLOSE = arb(2) ** -60
PLACES = (Place(1, 0), Place(0, 2), Place(1, 2))
Z = (4.5, 0.25, 0.75, 0.5, 3.75, 0.375)  # theta and v of each impact, of which the second is seated
TURNS = 3


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 256
    yield
    ctx.prec = before


def stretches() -> list[BallStretch]:
    def lobe(x):
        x = x - 3
        return (arb(2) + x * x - x * x * x / 4) / 64

    return [
        BallStretch(arb(0), arb(3), lambda x: arb(2) / 64 + 0 * x, None, seat=True),
        BallStretch(arb(3), 2 * arb.pi(), lobe, None),
    ]


def shooting(n: int = 3, parameter: str = "rpm", turns: int = TURNS) -> Shooting:
    made = Shooting(None, FOLLOWER, 300.0, parameter, PLACES[:n], turns)
    return made.with_stretches(stretches())


def unknowns(n: int, p) -> list[arb]:
    return [*map(arb, Z[: 2 * n]), arb(p)]


def test_how_long_the_flights_last_and_where_they_land():
    one = shooting()
    z = unknowns(3, 300)
    assert [float(one.span(z, k)) for k in range(3)] == pytest.approx(
        [0.75 - 4.5 + 2.0 * TURN, 3.75 - 0.75, 4.5 - 3.75 + TURN]
    )
    assert [one.landing(k) for k in range(3)] == [Place(0, 2), Place(1, 2), Place(1, 3)]
    assert one.n == 3
    assert one.passed(2) == [Place(1, 2), Place(0, 3), Place(1, 3)]
    assert one.passed(1) == [Place(0, 2), Place(1, 2)]
    later = Shooting(None, FOLLOWER, 300.0, "rpm", (Place(1, 1), Place(0, 2)), 3)
    assert [later.landing(k) for k in range(2)] == [Place(0, 2), Place(1, 4)]
    single = shooting(1)
    assert single.passed(0) == [Place(k % 2, k // 2) for k in range(1, 8)]
    assert float(single.span(unknowns(1, 300), 0)) == pytest.approx(3.0 * TURN)


@pytest.mark.parametrize(
    ("theta", "place"),
    [(0.5, Place(0, 4)), (3.5, Place(1, 4)), (0.5 + TURN, Place(0, 5)), (-0.5, Place(1, 3)),
     (3.5 - 2.0 * TURN, Place(1, 2))],
)  # fmt: skip
def test_the_place_of_an_angle_counted_on(theta, place):
    one = shooting()
    assert one.place(arb(theta), 4) == place
    other = Made(stretches=[Made(end=arb(0.25)), Made(end=2 * arb.pi())])
    in_turn = theta % TURN
    assert one.place(arb(theta), 4, other) == Place(int(in_turn > 0.25), place.turn)
    short = Made(stretches=[Made(end=arb(3))])
    if place.stretch == 1:
        with pytest.raises(UndecidedError):
            one.place(arb(theta), 4, short)


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize(
    ("parameter", "p"),
    [("rpm", 300), ("mass", 1.5), ("stiffness", 700), ("restitution", 0.75), ("preload", 13)],
)
def test_the_equations_have_the_derivatives_that_their_differences_have(n, parameter, p):
    """By every unknown. The values are the gaps at the ends of the flights, and what impacts lose.

    An impact on the seat has a restitution of its own.
    """
    one = shooting(n, parameter)
    z = unknowns(n, p)
    value, slopes = one.equations(z)
    assert (slopes.nrows(), slopes.ncols()) == (2 * n, 2 * n + 1)
    for j in range(2 * n + 1):
        low, high = (
            one.equations([x + side * STEP * (i == j) for i, x in enumerate(z)])[0]
            for side in (-1, 1)
        )
        for i in range(2 * n):
            slope = (high[i, 0] - low[i, 0]) / (2 * STEP)
            assert abs(slope - slopes[i, j]) < CLOSE * (1 + abs(slope)), (i, j)
    machine = BallMachine(stretches(), FOLLOWER, 300.0)
    for k, flight in enumerate(one.flights(one.machine(arb(p)), z)):
        after = (k + 1) % n
        c, c1 = machine.stretches[PLACES[k].stretch].derivatives(z[2 * k], 1)
        end = machine.stretches[PLACES[after].stretch].derivatives(z[2 * after], 2)
        moved = machine.move(c, c1 + z[2 * k + 1], one.span(z, k), 2)
        found = (flight.gap, flight.rate, flight.accel)
        for x, y, cam in zip(found, moved, end, strict=True):
            assert abs(x - (y - cam)) < CLOSE
        r = 0.2 if after == 1 else 0.75
        assert abs(flight.r - r) < 1e-12
        assert abs(value[2 * k, 0] - flight.gap) < CLOSE
        assert abs(value[2 * k + 1, 0] - (flight.r * flight.rate + z[2 * after + 1])) < CLOSE


@pytest.mark.parametrize("n", [2, 3])
def test_the_map_of_a_period_is_the_product_of_those_of_its_flights(n):
    """By the derivatives of the equations; of the determinant the losses and the damper count."""
    one = shooting(n)
    z = unknowns(n, 300)
    _, slopes = one.equations(z)
    machine = one.machine(arb(300))
    whole, losses = arb_mat([[1, 0], [0, 1]]), arb(1)
    for k, flight in enumerate(one.flights(machine, z)):
        rows = (2 * k, 2 * k + 1)
        there = (2 * ((k + 1) % n), 2 * ((k + 1) % n) + 1)
        before = arb_mat([[slopes[i, j] for j in rows] for i in rows])
        behind = arb_mat([[slopes[i, j] for j in there] for i in rows])
        of_flight = behind.inv() * before * -1
        whole = of_flight * whole
        losses = losses * flight.r * flight.r
        for found, factor in ((flight.slopes(), 1), (flight.slopes_times_rate(), flight.rate)):
            for x, y in zip(found, of_flight.entries(), strict=True):
                assert abs(x - factor * y) < CLOSE
    trace, det = one.trace_det(z)
    assert abs(trace - whole[0, 0] - whole[1, 1]) < CLOSE
    damper = (-arb(11) / (2 * arb(1.5)) / (10 * arb.pi()) * 2 * TURNS * 2 * arb.pi()).exp()
    assert abs(det - losses * damper) < CLOSE


def test_maps_follow_one_another():
    first, second = ImpactSlopes(1, 2, 3, 4), ImpactSlopes(5, 6, 7, 8)
    assert second.after(first) == (5 + 18, 10 + 24, 7 + 24, 14 + 32)
    assert first.trace == 1 + 4


def test_a_state_after_a_flight_moves_with_its_start():
    """By differences over the bent stretch, at a fixed phase."""
    machine = BallMachine(stretches(), FOLLOWER, 300.0)
    cam = machine.stretches[1]
    end = arb(5.5)

    def state(theta, v):
        c, c1 = cam.derivatives(theta, 1)
        return machine.move(c, c1 + v, end - theta, 2)[:2]

    theta, v = arb(4.5), arb(0.25)
    c, c1, c2 = cam.derivatives(theta, 2)
    accel = machine.move(c, c1 + v, arb(0), 2)[2] - c2
    found = StateSlopes.after(machine, end - theta, v, accel)
    by_theta, by_v = (
        [(b - a) / (2 * STEP) for a, b in zip(low, high, strict=True)]
        for low, high in (
            (state(theta - STEP, v), state(theta + STEP, v)),
            (state(theta, v - STEP), state(theta, v + STEP)),
        )
    )
    wanted = (by_theta[0], by_v[0], by_theta[1], by_v[1])
    assert all(abs(x - y) < CLOSE for x, y in zip(found, wanted, strict=True))


def test_the_gap_of_a_flight_is_that_to_a_stretch_in_its_turn():
    """Flight 2 of three begins in the turn 2; its gap and slopes over the stretch 0 of the next."""
    one = shooting()
    z = unknowns(3, 300)
    machine = one.machine(arb(300))
    gap = one.gap(machine, z, 2, Place(0, 3))
    s = arb(3)
    found = gap(s)
    c, c1 = machine.stretches[1].derivatives(z[4], 1)
    moved = machine.move(c, c1 + z[5], s, 2)
    assert abs(found[0] - (moved[0] - arb(2) / 64)) < CLOSE
    low, high = gap(s - STEP), gap(s + STEP)
    for k in (0, 1):
        assert abs((high[k] - low[k]) / (2 * STEP) - found[k + 1]) < CLOSE
    on = arb(0.25) + 2 * arb.pi()  # at 4 rad of the turn behind
    moved = machine.move(c, c1 + z[5], on, 2)
    beyond = one.gap(machine, z, 2, Place(1, 3))(on)[0]
    assert abs(beyond - (moved[0] - (arb(2) + 1 - arb(0.25)) / 64)) < CLOSE
    at_lobe = one.gap(machine, z, 2, Place(1, 2))(arb(1))[0]
    x = arb(3.75) + 1 - 3
    moved = machine.move(c, c1 + z[5], arb(1), 2)
    assert abs(at_lobe - (moved[0] - (2 + x * x - x * x * x / 4) / 64)) < CLOSE


# -- motions


def admitted(hull, *, ends=(), fading=None, touch=None, undecided=False, monkeypatch=None):
    """What is said of three impacts; and of which flights the gap is shown, with which touch."""
    asked = []

    class Flight:
        def __init__(self, shooting, machine, hull, k, fading):
            self.k, self.fading = k, fading

        def stays_off_the_cam(self, touched):
            asked.append((self.k, self.fading, touched))
            if undecided:
                raise UndecidedError

    monkeypatch.setattr(module, "FlightToShow", Flight)
    one = shooting()
    try:
        one.admissible([*map(arb, hull), arb(300)], ends, touch, fading)
    except NotProvedError as why:
        return (why.step, why.refuted), asked
    return None, asked


GOOD = (4.5, 0.25, 0.75, 0.5, 3.75, 0.375)


def changed(k: int, x) -> tuple:
    return (*GOOD[:k], x, *GOOD[k + 1 :])


@pytest.mark.parametrize(
    ("hull", "more", "said"),
    [
        (GOOD, {}, None),
        (changed(0, 2.9), {}, (ProofStep.ELSEWHERE, True)),
        (changed(0, 2.9), {"ends": (0,)}, None),
        (changed(0, 2.9), {"ends": (1, 2)}, (ProofStep.ELSEWHERE, True)),
        (changed(0, arb(3, 0.5)), {}, (ProofStep.ELSEWHERE, False)),
        (changed(2, 3.1), {}, (ProofStep.ELSEWHERE, True)),
        (changed(2, arb(3, 0.5)), {}, (ProofStep.ELSEWHERE, False)),
        (changed(4, 6.3), {}, (ProofStep.ELSEWHERE, True)),
        (changed(5, -0.1), {}, (ProofStep.PULLS, True)),
        (changed(5, arb(0, 0.1)), {}, (ProofStep.PULLS, False)),
        (changed(5, 0.0), {}, (ProofStep.PULLS, False)),
        (changed(5, 0.0), {"fading": 2}, None),
        (changed(5, 0.0), {"fading": 1}, (ProofStep.PULLS, False)),
        (GOOD, {"undecided": True}, (ProofStep.GRAZES, False)),
    ],
)
def test_impacts_of_a_motion_lie_on_their_stretches_and_bounce(hull, more, said, monkeypatch):
    found, asked = admitted(hull, monkeypatch=monkeypatch, **more)
    assert found == said
    if said is None:
        assert asked == [(k, more.get("fading"), None) for k in range(3)]


def test_only_the_flight_that_touches_is_asked_with_its_touch(monkeypatch):
    _, asked = admitted(GOOD, touch=Touch(1, arb(0.5)), monkeypatch=monkeypatch)
    assert asked == [(0, None, None), (1, None, arb(0.5)), (2, None, None)]


def test_a_touch_is_where_the_slope_of_the_gap_is_zero(monkeypatch):
    """Near 0.9, of (s - 1)^2 (1 + s/8) + 0.01, on the stretch that is there."""
    asked = []

    def gap(self, machine, hull, k, place):
        asked.append((k, place))

        def values(s):
            x = s - 1
            return [x * x * (1 + s / 8) + 0.01, 2 * x * (1 + s / 8) + x * x / 8,
                    2 * (1 + s / 8) + x / 2]  # fmt: skip

        return values

    monkeypatch.setattr(Shooting, "gap", gap)
    one = shooting()
    place, zero = one.touch(unknowns(3, 300), 2, arb(0.9))
    assert place == Place(1, 2)
    assert asked == [(2, place)]
    assert zero.contains(1)
    assert zero.rad() < 1e-60
    place, _ = one.touch(unknowns(3, 300), 0, arb(2.5))
    assert place == Place(0, 1)  # at 7 rad, in the turn behind
    monkeypatch.setattr(Shooting, "gap", lambda *given: lambda s: [s, arb(1) + s * s, arb(0, 1)])
    with pytest.raises(NotProvedError) as refused:
        one.touch(unknowns(3, 300), 2, arb(0.9))
    assert refused.value.step is ProofStep.GRAZES


# -- boxes


def box(**changes) -> Box:
    given = {"middle": [arb(1), arb(2), arb(3)], "tangent": [arb(4), arb(-5), arb(1)],
             "error": [arb(0, 0.125), arb(0, 0.25), arb(0)], "fixed": 2, "half": arb(0.5),
             "within": [arb(0, 0.5), arb(0, 0.75), arb(0)], "inverse": arb_mat(2, 2)}  # fmt: skip
    return Box(**{**given, **changes})


def test_the_hull_of_a_box_and_the_orbits_that_it_holds():
    one = box()
    hull = one.hull()
    for x, middle, radius in zip(hull, (1, 2, 3), (2.125, 2.75, 0.5), strict=True):
        assert x.mid() == middle
        assert abs(arb(x.rad()) - radius) < 1e-6
    at = one.orbit_at(arb(0.25))
    assert [float(x.mid()) for x in at] == [2.0, 0.75, 3.25]
    for off, holds in (((0.4, 0.7), True), ((0.6, 0.7), False), ((0.4, -0.8), False),
                       ((-0.4, -0.7), True)):  # fmt: skip
        for eta, near in ((0.5, True), (-0.5, True), (0.51, False)):
            orbit = [arb(1 + 4 * eta + off[0]), arb(2 - 5 * eta + off[1]), arb(3 + eta)]
            assert one.holds(orbit) is (holds and near)
    assert not one.holds([arb(1, 0.6), arb(2), arb(3)])
    assert not one.holds([arb(3), arb(-0.5), arb(3.5, 0.1)])  # it may lie beyond the half
    assert one.holds([arb(3), arb(-0.5), arb(3.5)])


def equations(z):
    """x y = p and x - y = 1, whose zeros are (3, 2) at p = 6, with the tangent (1/5, 1/5)."""
    x, y, p = z
    return (arb_mat([[x * y - p], [x - y - 1]]),
            arb_mat([[y, x, arb(-1)], [arb(1), arb(-1), arb(0)]]))  # fmt: skip


@pytest.mark.parametrize("fixed", [0, 1, 2])
@pytest.mark.parametrize("half", [0, 1e-4])
def test_a_box_is_found_about_a_zero_and_leans_along_the_branch(fixed, half):
    guess = [arb(3.01), arb(1.99), arb(6.02)]
    value = (3, 2, 6)[fixed]
    guess[fixed] = arb(value)
    one = box_of(equations, guess, fixed, half)
    assert (one.fixed, one.half) == (fixed, half)
    assert one.middle[fixed] == value
    tangents = [arb(1) / 5, arb(1) / 5, arb(1)]
    for t, by_p in zip(one.tangent, tangents, strict=True):
        assert abs(t - by_p / tangents[fixed]) < 1e-60
    assert one.tangent[fixed] == 1
    assert one.error[fixed] == 0
    for eta in (-half, 0.0, half):
        p = {0: lambda e: (3 + e) * (2 + e), 1: lambda e: (3 + e) * (2 + e), 2: lambda e: 6 + e}[
            fixed
        ](arb(eta))
        x = (1 + (1 + 4 * p).sqrt()) / 2
        exact = [x, x - 1, p]
        assert all(a.contains(b.mid()) for a, b in zip(one.orbit_at(arb(eta)), exact, strict=True))
    assert all(float(e.rad()) < max(10 * half * half, 1e-60) for e in one.error)
    for k, (inner, outer) in enumerate(zip(one.error, one.within, strict=True)):
        assert outer.contains(inner)
        assert k == fixed or inner.rad() < outer.rad()
    tight = box_of(equations, guess, fixed, half, 0.125)
    assert all(
        e.rad() <= 0.125001 * w.rad() for e, w in zip(tight.error, tight.within, strict=True)
    )
    # Y is near the inverse of E' by the free unknowns
    free = [k for k in range(3) if k != fixed]
    _, slopes = equations(one.middle)
    product = one.inverse * arb_mat([[slopes[i, k] for k in free] for i in range(2)])
    assert all(abs(product[i, j] - (i == j)) < 1e-9 for i in (0, 1) for j in (0, 1))


def test_where_there_is_no_zero_there_is_no_box():
    def none(z):
        return arb_mat([[z[0] * z[0] + 1]]), arb_mat([[2 * z[0], arb(0)]])

    def double(z):
        return arb_mat([[z[0] * z[0]]]), arb_mat([[2 * z[0], arb(0)]])

    def undecided(z):
        raise UndecidedError

    for wrong in (none, double, undecided):
        with pytest.raises(NotProvedError) as refused:
            box_of(wrong, [arb(0.5), arb(1)], 1)
        assert refused.value.step is ProofStep.SINGULAR
    with pytest.raises(NotProvedError):
        box_of(equations, [arb(3), arb(2), arb(6)], 2, 7.0)  # beyond the fold at -1/4


def test_of_a_box_over_a_number_of_the_cam_a_part_is_left_free(monkeypatch):
    asked = []
    monkeypatch.setattr(module, "box_of", lambda *given: asked.append(given[1:]))
    for parameter in ("rpm", "mass", "lift"):
        shooting(1, parameter).box("guess", 2, "half")
    assert asked == [("guess", 2, "half", 1), ("guess", 2, "half", 1), ("guess", 2, "half", 0.6)]


def on_branch(test, fixed=2, reach=None, guess=(3.01, 2.01, 6.05)):
    """`Shooting.zero` of a test function along the zeros of x y = p and x - y = 1."""

    class Known(Shooting):
        def equations(self, z):
            return equations(z)

    one = Known(None, FOLLOWER, 300.0, "rpm", PLACES[:1], 1)
    return one, one.zero([arb(x) for x in guess], fixed, test, reach)


@pytest.mark.parametrize("fixed", [0, 2])
def test_the_zero_of_a_test_function_is_enclosed_along_the_branch(fixed):
    """x + y = 5 at p = 6; the slopes of the unknowns by p are 1/5, 1/5 and 1."""
    one, (at, around) = on_branch(lambda z: z[0] + z[1] - 5, fixed)
    for ball, exact in zip(at.hull(), (3, 2, 6), strict=True):
        assert ball.contains(exact)
        assert ball.rad() < 1e-30
    assert at.half < around.half
    assert at.fixed == around.fixed == fixed
    series = one.along([arb(3), arb(2), arb(6)], fixed)
    by_p = [arb(1) / 5, arb(1) / 5, arb(1)]
    for x, value, slope in zip(series, (3, 2, 6), by_p, strict=True):
        assert x[0] == value
        assert abs(x[1] - slope / by_p[fixed]) < 1e-60
    _, (_, wide) = on_branch(lambda z: z[0] + z[1] - 5, fixed, arb(0.001))
    assert wide.half == arb(0.001).mid()


def test_a_zero_that_is_none_is_refused():
    """It has no slope, or none within the reach; or there is none at all."""
    for test, reach in (
        (lambda z: (z[2] - 6) * (z[2] - 6) + 1, None),
        (lambda z: (z[2] - 6) * (z[2] - arb("6.001")), arb(0.01)),
        (lambda z: arb_series([1, 1], 2) + 0 * z[2], arb(0.01)),
    ):
        with pytest.raises(NotProvedError):
            on_branch(test, reach=reach)


def test_the_first_half_that_holds():
    tried = []
    found = module._first_half(arb(1), lambda s: tried.append(float(s)) or s < 0.2)
    assert found == 0.125
    assert tried == [1.0, 0.5, 0.25, 0.125]
    with pytest.raises(UndecidedError):
        module._first_half(arb(1), lambda s: False)
    assert [module._spread_out([0] * 4, [0, 1, 3], [7, 8, 9])] == [[7, 8, 0, 9]]
    rows = arb_mat([[1, 2, 3], [4, 5, 6]])
    assert module._columns(rows, [2, 0]) == arb_mat([[3, 1], [6, 4]])


def test_a_touch_is_passed_where_the_gap_is_convex_about_it():
    """Of (s - 1)^2 (2 - s), convex up to 4/3; from 0.5 on it has no other zero."""

    def gap(s):
        x = s - 1
        return [x * x * (1 - x), 2 * x - 3 * x * x, 2 - 6 * x]

    behind = module._beyond_touch(gap, arb(0.5), arb(1), arb(0.25))
    assert behind == 1.25
    assert module._beyond_touch(gap, arb(0.5), arb(1), arb(0.5)) == 1.25

    def mirrored(s):
        x = s - 1
        return [x * x * (1 + x), 2 * x + 3 * x * x, 2 + 6 * x]

    assert module._beyond_touch(mirrored, arb(0.5), arb(1), arb(0.5)) == 1.25

    def before(s):  # zero at 0.3 and 0.5, too
        x = s - 1
        rest, slope = (s - 0.5) * (s - arb("0.3")), 2 * s - arb("0.8")
        return [x * x * rest, 2 * x * rest + x * x * slope, 2 * rest + 4 * x * slope + 2 * x * x]

    with pytest.raises(NotProvedError):
        module._beyond_touch(before, arb(0.25), arb(1), arb(0.0625))
    with pytest.raises(NotProvedError) as refused:
        module._show_no_zero(gap, arb(1.5), arb(2.5))
    assert (refused.value.step, refused.value.refuted) == (ProofStep.CONTACT, True)
    module._show_no_zero(gap, arb(1.5), arb(1.75))
    module._show_no_zero(gap, arb(2.5), arb(1.5))  # no way at all
