"""The peers of the bench on machines with closed forms: a ball on a plate, and on a turning circle.

What a peer is told of a machine, and what becomes of its flights, is worked out by hand here.
"""

from __future__ import annotations

from math import cos, inf, pi, sin, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.integrate

from camcli.analysis.bench import peers
from camcli.analysis.bench.peers import (
    BudgetError,
    FlightEnd,
    FlightState,
    Lift,
    PeerFlight,
    PeerImpact,
    PeerMachine,
    PeerRest,
    PeerState,
    follow,
    next_landing,
    runge_kutta_4,
    solve_ivp,
    wrapped,
)
from camcli.system import Follower

TURN = 2.0 * pi
G = 10.0
PLATE = Lift({"kind": "eccentric", "base": 0.25, "lift": 0.0})
ROUND = Lift({"kind": "eccentric", "base": -0.1, "lift": 0.3})  # c = 0.05 - 0.15 cos theta
DAMPED = Follower(mass=2.0, stiffness=30.0, damping=4.0, gravity=9.81, preload=6.0,
                  restitution=0.7)  # fmt: skip
BALL = Follower(mass=2.0, stiffness=0.0, gravity=G, restitution=0.5)
METHODS = {"fixed steps": runge_kutta_4(400), "steps as needed": solve_ivp("dop853", 1e-12)}


def machine(follower=BALL, lift=PLATE, omega=TURN, turns=2.0, chatter=1e-9, **more) -> PeerMachine:
    return PeerMachine(follower, lift, omega=omega, turns=turns, chatter=chatter, **more)


def test_what_a_peer_knows_of_a_machine():
    one = machine(DAMPED, ROUND, omega=8.0, turns=3.0, chatter=1e-3)
    assert (one.r, one.k, one.b, one.load) == (0.7, 15.0, 2.0, 9.81 + 3.0)
    assert (one.period, one.chatter_s) == pytest.approx((TURN / 8.0, 1e-3 * TURN / 8.0), rel=1e-15)
    assert (one.end(0), one.end(2)) == pytest.approx((3.0 * TURN, TURN))
    for theta in (0.3, 2.0, 4.5):
        c, c1, c2 = 0.05 - 0.15 * cos(theta), 0.15 * sin(theta), 0.15 * cos(theta)
        assert tuple(one.lift.at(theta)) == pytest.approx((c, c1, c2), rel=1e-13)
        wanted = -15.0 * c - 2.0 * 8.0 * c1 - 12.81 - 64.0 * c2
        assert one.pushed(0, theta) == pytest.approx(wanted, rel=1e-13)


@pytest.mark.parametrize(
    ("y", "u"), [(0.0, 3.0), (1.25, 0.0), (0.8, 2.0), (0.8, -2.0), (1e-9, -2.0)]
)
def test_how_long_a_fall_would_last(y, u):
    """y + u t - G t^2/2 = 0; a pull that depends on place and rate is that of the beginning."""
    seconds = machine().fall_time(PeerState(0, 0.5, y, u))
    assert seconds == pytest.approx((u + sqrt(u * u + 2.0 * G * y)) / G, rel=1e-7)
    one = machine(DAMPED, ROUND, omega=2.0)
    a = one.pushed(0, 0.5) - 15.0 * y - 2.0 * u
    assert a < 0.0
    seconds = one.fall_time(PeerState(0, 0.5, y, u))
    assert seconds == pytest.approx((u + sqrt(u * u - 2.0 * a * y)) / -a, rel=1e-7)


def test_nothing_falls_that_is_pulled_off_or_leaves_a_rest():
    free = machine(Follower(mass=1.0, stiffness=0.0))
    for one, state in (
        (machine(), PeerState(0, 0.5, 0.0, 0.0)), (free, PeerState(0, 0.5, 1.0, -1.0)),
    ):  # fmt: skip
        assert one.fall_time(state) == inf


@pytest.mark.parametrize("name", METHODS)
def test_a_ball_on_a_plate_bounces_as_newton_says(name):
    """From 0.2 m: it lands after 0.2 s with 2 m/s, bounces with half of it, and so on."""
    trace = follow(machine(turns=1.0, chatter=1e-6), METHODS[name], 0.45, 0.0)
    time, u = 0.2, 2.0
    for hit in trace.hits:
        assert (hit.turn, hit.theta / TURN, hit.u) == pytest.approx((0, time, -u), rel=1e-6)
        time, u = time + u / G, 0.5 * u
    assert len(trace.hits) == 20
    rest = time - u / G  # the series 2 u/G (1 + 1/2 + ...) ends after 4 u/G, u behind the first
    (end,) = trace.rests
    assert (end.turn, end.theta / TURN) == pytest.approx((0, 0.6), abs=1e-6)
    assert abs(rest - 0.6) < 1e-5
    assert trace.final == pytest.approx((0.25, 0.0), abs=1e-12)
    assert not trace.given_up


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("v", [0.0, 4.0])
def test_a_flight_high_above_the_cam_is_one_parabola(name, v):
    """It is flown against a level there, and against the cam below it."""
    q, seconds = 1.5, 0.4
    one = machine(lift=ROUND, omega=TURN / seconds, turns=1.0)
    trace = follow(one, METHODS[name], q, v)
    assert trace.hits == []
    wanted = q + v * seconds - G * seconds**2 / 2.0, v - G * seconds
    assert trace.final == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("name", METHODS)
def test_where_it_lands_on_a_cam_that_turns(name):
    """From 0.6 m above the lowest place of the circle, dropped: 0.5 - 5 t^2 = 0.05 - 0.15 cos."""
    one = machine(lift=ROUND, omega=3.0, turns=1.0)
    landing = next_landing(one, METHODS[name], PeerState(0, 0.0, 0.6, 0.0))
    assert landing.contact
    t = landing.state.theta / 3.0
    assert 0.5 - 5.0 * t * t == pytest.approx(0.05 - 0.15 * cos(3.0 * t), abs=1e-9)
    assert landing.state.u == pytest.approx(-10.0 * t - 3.0 * 0.15 * sin(3.0 * t), rel=1e-9)
    assert (landing.state.turn, landing.state.y) == (0, 0.0)


def test_a_run_ends_between_two_landings():
    one = machine(turns=1.0, omega=TURN / 0.1)
    landing = next_landing(one, METHODS["fixed steps"], PeerState(0, 0.0, 0.2, 0.0))
    assert not landing.contact
    assert landing.state == pytest.approx((1, 0.0, 0.2 - G * 0.1**2 / 2.0, -G * 0.1), rel=1e-12)


def test_a_follower_that_rests_to_the_end_is_where_the_turn_begins():
    """On the circle, which turns slowly: it never leaves it."""
    trace = follow(machine(lift=ROUND, omega=0.5, turns=3.0), METHODS["fixed steps"], None, None)
    assert (trace.hits, trace.final) == ([], pytest.approx((-0.1, 0.0), abs=1e-15))


@pytest.mark.parametrize(("chatter", "closes"), [(0.19999, False), (0.20001, True)])
def test_a_chatter_is_closed_where_it_is_shorter_than_its_tolerance(chatter, closes):
    """2 r u/((1 - r) G) = 0.2 s after an impact at 1 m/s, in a turn of a second."""
    one = machine(chatter=chatter)
    state = one.rebound(0, 2.0, -1.0)
    assert one.trace.hits == [PeerImpact(0, 2.0, -1.0)]
    if closes:
        assert state is None  # the plate lets nothing go
        assert one.trace.rests == [PeerRest(0, pytest.approx(2.0 + 0.2 * TURN))]
    else:
        assert state == (0, 2.0, 0.0, 0.5)
        assert one.trace.rests == []


def test_without_loss_or_pull_no_chatter_is_closed():
    """Of r = 1, and of a follower that is pulled off."""
    elastic = machine(Follower(mass=1.0, stiffness=0.0, gravity=G, restitution=1.0), chatter=9.0)
    assert elastic.rebound(0, 1.0, -1.0) == (0, 1.0, 0.0, 1.0)
    pulled = machine(Follower(mass=1.0, stiffness=0.0, gravity=-G, restitution=0.5), chatter=9.0)
    assert pulled.rebound(0, 1.0, -1.0) == (0, 1.0, 0.0, 0.5)


@pytest.mark.parametrize(("most", "given_up"), [(5, True), (6, False)])
def test_a_run_may_have_so_many_impacts(most, given_up):
    one = machine(turns=0.59, chatter=0.0, most_impacts=most)
    trace = follow(one, METHODS["fixed steps"], 0.45, 0.0)
    assert trace.given_up == given_up
    assert len(trace.hits) == 6  # at 0.2, 0.4, 0.5, 0.55, 0.575 and 0.5875 of the turn
    assert (trace.final is None) == given_up


def test_a_run_may_take_so_many_seconds(monkeypatch):
    monkeypatch.setattr(peers, "process_time", lambda: clock)
    clock = 50.0
    one = machine(seconds=100.0)
    clock = 149.0
    one.check()
    clock = 151.0
    with pytest.raises(BudgetError):
        one.check()
    late = PeerFlight(one, 0, 0.5, inf)
    for method, steps in ((runge_kutta_4(1), 1), (solve_ivp("rk45", 1e-9, 1e-3), peers.CHECKED)):
        with pytest.raises(BudgetError):  # while a long flight is integrated, too
            method(late, FlightState(0.0, 9.0, 0.0), 1.0, False)
        assert one.trace.evaluations < 4 * steps


def test_four_evaluations_make_a_step():
    """A flight of 0.1 s in steps of 1/400 turn, a second: forty steps."""
    one = machine(turns=1.0, omega=TURN)
    one.turns = 0.1
    trace = follow(one, METHODS["fixed steps"], 5.0, 0.0)
    assert trace.evaluations == 4 * 40


def test_an_angle_is_wrapped_into_its_turn():
    assert wrapped(3, TURN + 0.5) == (4, pytest.approx(0.5))
    assert wrapped(3, -0.5) == (2, pytest.approx(TURN - 0.5))
    assert wrapped(3, 0.0) == (3, 0.0)


@pytest.mark.parametrize(
    ("name", "most", "fall", "method", "longest"),
    [
        ("rk45", inf, 0.3, "RK45", 0.3),
        ("dop853", 1.0 / 16.0, 0.3, "DOP853", 0.25 / 16.0),
        ("radau", 1.0 / 16.0, 0.01, "Radau", 0.01),
        ("dop853", inf, inf, "DOP853", inf),
    ],
)
def test_what_scipy_is_asked_for(monkeypatch, name, most, fall, method, longest):
    """No step is longer than a fall, nor than so many turns of a quarter of a second."""
    asked = []

    def solve(derivative, span, state, method, **options):
        asked.append((span, state, method, options))
        return SimpleNamespace(
            nfev=7, status=0, t=np.array([span[0], span[1]]), y=np.array([[9.0, 0.5], [9.0, -3.0]]),
            t_events=[[], []], y_events=[[], []],
        )  # fmt: skip

    monkeypatch.setattr(scipy.integrate, "solve_ivp", solve)
    one = machine(omega=TURN / 0.25)
    one.trace.evaluations = 5
    flight = PeerFlight(one, 0, 0.5, fall)
    integrate = solve_ivp(name, 1e-7, most)
    for contacts in (False, True):
        end = integrate(flight, FlightState(0.1, 0.2, 0.3), 0.9, contacts)
        assert end == FlightEnd(0.9, 0.5, -3.0, contact=False)
        span, state, used, options = asked[-1]
        assert (span, state, used) == ((0.1, 0.9), (0.2, 0.3), method)
        assert (options["rtol"], options["atol"]) == (1e-7, 1e-7)
        assert options["max_step"] == longest
        if contacts:  # the gap falls through zero, and has a minimum
            landing, lowest = options["events"]
            assert (landing.terminal, landing.direction, lowest.direction) == (True, -1, 1)
            assert not hasattr(lowest, "terminal")
            assert (landing(0.0, (2.0, 3.0)), lowest(0.0, (2.0, 3.0))) == (2.0, 3.0)
        assert (options["events"] is not None) == contacts
    assert one.trace.evaluations == 5 + 2 * 7


@pytest.mark.parametrize(
    ("status", "minima", "ends", "contact"),
    [
        (1, [], [0.9], True),
        (0, [], [0.9], False),
        (0, [(0.5, 1e-3), (0.6, 2e-3)], [0.9], False),  # none of them is below the cam
        (0, [(0.5, 1e-3), (0.6, -1e-9), (0.7, -1.0)], [0.9, 0.6], False),
        (0, [(0.9, -1.0)], [0.9], False),  # there it ends already
    ],
)
def test_scipy_is_asked_again_up_to_the_first_minimum_below_the_cam(
    monkeypatch, status, minima, ends, contact
):
    asked = []

    def solve(derivative, span, state, method, **options):
        asked.append(span[1])
        below = [(t, (y, 0.0)) for t, y in minima] if span[1] == 0.9 else []
        return SimpleNamespace(
            nfev=1, status=status, t=np.array([0.0, span[1]]), y=np.array([[1.0, 2.0], [3.0, 4.0]]),
            t_events=[[], [t for t, _ in below]], y_events=[[], [state for _, state in below]],
        )  # fmt: skip

    monkeypatch.setattr(scipy.integrate, "solve_ivp", solve)
    flight = PeerFlight(machine(), 0, 0.5, 0.3)
    end = solve_ivp("rk45", 1e-6)(flight, FlightState(0.0, 1.0, 3.0), 0.9, True)
    assert asked == ends
    assert end == FlightEnd(ends[-1], 2.0, 4.0, contact)


def test_what_scipy_gives_up_is_no_flight(monkeypatch):
    failed = SimpleNamespace(nfev=3, status=-1, message="step too small")
    monkeypatch.setattr(scipy.integrate, "solve_ivp", lambda *_, **__: failed)
    one = machine()
    with pytest.raises(ArithmeticError, match="step too small"):
        solve_ivp("rk45", 1e-6)(PeerFlight(one, 0, 0.5, 0.3), FlightState(0.0, 1.0, 3.0), 0.9, True)
    assert one.trace.evaluations == 3


def test_one_fixed_step_is_the_classical_one_of_order_four():
    """Of the vector (y, u), on a circle that turns, under a spring and a damper."""
    one = machine(DAMPED, ROUND, omega=8.0)
    flight = PeerFlight(one, 0, 0.7, inf)

    def rates(t, state):
        return np.array([state[1], flight.accel(t, *state)])

    t, state, h = 0.05, np.array([0.4, -0.6]), one.period / 10.0
    k1 = rates(t, state)
    k2 = rates(t + h / 2.0, state + h / 2.0 * k1)
    k3 = rates(t + h / 2.0, state + h / 2.0 * k2)
    k4 = rates(t + h, state + h * k3)
    wanted = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    end = runge_kutta_4(10)(flight, FlightState(t, *state.tolist()), t + h, False)
    assert end == pytest.approx((t + h, *wanted, False), rel=1e-12)
    assert one.trace.evaluations == 4


@pytest.mark.parametrize(("fall", "steps"), [(inf, 5), (0.4, 5), (0.16, 10), (0.08, 20)])
def test_a_short_flight_has_eight_fixed_steps_at_least(fall, steps):
    """Steps of 1/25 s over 0.2 s, or of an eighth of the fall; none of rounding errors."""
    one = machine(omega=TURN)
    flight = PeerFlight(one, 0, 0.5, fall)
    end = runge_kutta_4(25)(flight, FlightState(0.1, 5.0, 0.0), 0.3, True)
    assert end == pytest.approx((0.3, 5.0 - G * 0.02, -G * 0.2, False), rel=1e-12)
    assert end.t == 0.3
    assert one.trace.evaluations == 4 * steps


@pytest.mark.parametrize(("v", "given"), [(None, False), (-3.0, True)])
def test_a_start_without_a_velocity_is_a_rest(v, given):
    """On the plate: it rests to the end, and 0.05 m above the plate it lands in a while."""
    trace = follow(machine(turns=1.0), METHODS["fixed steps"], 0.3, v)
    assert bool(trace.hits) == given
    assert given or trace.final == (0.25, 0.0)


@pytest.mark.parametrize(
    ("y", "turns", "until", "end"),
    [
        (0.0, 3.0, 0.25, (1, 1.0)),  # a region that has no end is flown over for a turn at most
        (0.0, 1.0, 0.25 * (1.0 - 1.0 / TURN), (1, 0.0)),  # or to the end of the run
        (5.0, 3.0, 0.25, (1, 1.0)),  # as high above the cam, where there are no regions
    ],
)
def test_how_far_one_integration_goes(y, turns, until, end):
    """From one rad on, in turns of a quarter of a second; a gap below zero by rounding is none."""
    asked = []

    def method(flight, begin, until, contacts):
        asked.append((flight.region, begin, until, contacts))
        return FlightEnd(until, -1e-18, 2.0, contact=False)

    one = machine(omega=TURN / 0.25, turns=turns)
    landing = peers._over_region(one, method, PeerState(0, 1.0, y, -1.0))
    assert [contacts for *_, contacts in asked] == ([False, True] if y == 0.0 else [True])
    assert asked[-1][2] == pytest.approx(until, rel=1e-12)
    assert asked[-1][0] == (1 if y else 0)
    assert landing.contact is False
    assert landing.state[:2] == pytest.approx(end, abs=1e-12)
    assert landing.state.u == 2.0
    assert landing.state.y == (0.0 if y == 0.0 else pytest.approx(peers.CLEAR, abs=1e-15))


@pytest.mark.parametrize(
    ("outcome", "end"), [(-1, 0.375), (-4, 0.5)]
)  # -1: stopped by a contact; -4: heyoka's word for having reached the end
def test_what_a_taylor_integrator_is_given_and_how_its_flight_ends(monkeypatch, outcome, end):
    own = machine(DAMPED, ROUND)
    own.trace.evaluations = 40
    taylor = SimpleNamespace(time=0.0)
    state, pars, asked = np.zeros(2), np.zeros(9), []

    def propagate_until(until):
        asked.append((until, taylor.time, state.tolist(), pars.tolist()))
        taylor.time = 0.375
        state[:] = (0.0625, -0.75)
        return outcome, 0.0, 0.0, 7, None

    taylor.propagate_until = propagate_until
    taylor.reset_cooldowns = lambda: asked.append("cooldowns")
    monkeypatch.setattr(peers, "_taylor_integrator", lambda *_: (taylor, state, pars))
    integrate = peers.heyoka_taylor(1e-12)
    flight = PeerFlight(own, 0, 1.25, 9.0)
    found = integrate(flight, FlightState(0.125, 0.5, -0.25), 0.5, True)
    assert found == (end, 0.0625, -0.75, outcome == -1)
    assert own.trace.evaluations == 40 + 7
    a, b, d, offset, centre, _ = own.lift.regions[0]
    values = [own.k, own.b, own.load, own.omega, 1.25 - centre, a, b, d, offset]
    assert asked == ["cooldowns", (0.5, 0.125, [0.5, -0.25], values)]
    asked.clear()
    integrate(flight, FlightState(0.0, 0.0, 0.0), 0.5, False)
    assert "cooldowns" not in asked
