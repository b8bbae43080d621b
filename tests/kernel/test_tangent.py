"""Flight and saltation matrices against mpmath, simulated orbits and stroboscopic maps."""

from math import exp, pi

import pytest
from mpmath import mp

from camcli.analysis.integrate import Orbit
from camcli.kernel import backend
from camcli.kernel.cam_table import TURN, lift, stretch_at
from camcli.kernel.flow import constants_of
from camcli.kernel.orbit_loop import IMPACT, EventKind
from camcli.kernel.variational import (
    Growth,
    Pair,
    after_flight,
    after_impact,
    flight_tangent,
)
from tests.conftest import chapter_system, settings
from tests.oracle import ArcsCam
from tests.orbit_oracle import STABLE, THRICE, TWICE, Machine, solve, strobe_state

CAM = ArcsCam()
MACHINES = {
    "chapter": {},
    "damped": {"damping": 2.0},
    "gravity": {"gravity": 9.81},
    "preload": {"preload": 10.0},
    "all": {"damping": 2.0, "gravity": 9.81, "preload": 10.0, "restitution": 0.75},
}
REGIMES = {
    **MACHINES,
    "springless": {"stiffness": 0.0, "gravity": 9.81},
    "springless, damped": {"stiffness": 0.0, "damping": 5.0, "preload": 8.0},
    "critical": {"damping": 2.0 * (1430.8 * 1.221) ** 0.5},
    "overdamped": {"damping": 300.0},
    "elastic": {"restitution": 1.0},
    "plastic": {"restitution": 0.0},
}


def lane_at(rpm, **changes):
    return constants_of(chapter_system(**changes).machine(rpm), 0.0, 0)


def det(m):
    return m[0] * m[3] - m[1] * m[2]


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("rpm", [150.0, 3000.0])
def test_the_flight_matrix_is_the_exponential_of_its_equation(name, rpm):
    lane = lane_at(rpm, **REGIMES[name])
    for s in (1e-6, 0.01, 0.7, TURN, 3 * TURN):
        with mp.workdps(60):
            rates = mp.matrix([[0, 1], [-(mp.mpf(lane.W) ** 2), -2 * mp.mpf(lane.Z)]])
            exact = mp.expm(rates * s, method="taylor")
            found = mp.matrix([flight_tangent(lane, s)[:2], flight_tangent(lane, s)[2:]])
            for i in range(2):
                for j in range(2):
                    size = (1.0, 1.0 + lane.W, 1.0 + s)[i - j]  # of any motion
                    assert abs(found[i, j] - exact[i, j]) < 2e-15 * (1 + lane.W * s) * size


@pytest.mark.parametrize("name", REGIMES)
@pytest.mark.parametrize("s", [0.3, 2.0, TURN])
def test_determinants_of_flight_and_impact(name, s):
    lane = lane_at(520.0, **REGIMES[name])
    flight = flight_tangent(lane, s)
    size = abs(flight[0] * flight[3]) + abs(flight[1] * flight[2])
    assert abs(det(flight) - exp(-2.0 * lane.Z * s)) <= 4e-15 * (size + exp(-2.0 * lane.Z * s))
    impact = after_impact(lane, (0.2, 0.1, -0.3), -0.4, 1.0, 0.0, 0.0, 1.0)
    assert impact[1] == 0.0
    assert det(impact) == lane.r * lane.r


def strobed(system, rpm, turns, q, w):
    """(q, dq/dtheta) after whole turns from a state at the strobe, and the tape."""
    omega = rpm * (pi / 30)
    deg = system.strobe * 180 / pi
    tape = Orbit(system, rpm, settings(record=turns + 1, q=q, v=w * omega, theta_deg=deg)).run()
    return (float(tape.strobe_q[turns]), float(tape.strobe_w[turns])), tape


def differences(system, rpm, turns, q, w):
    """The stroboscopic map's matrix by central differences of simulated runs, extrapolated."""

    def at(h):
        columns = []
        for dq, dw in ((h, 0.0), (0.0, h)):
            (a, b), one = strobed(system, rpm, turns, q + dq, w + dw)
            (c, d), two = strobed(system, rpm, turns, q - dq, w - dw)
            assert list(one.impacts)[:turns] == list(two.impacts)[:turns]
            columns.append(((a - c) / (2 * h), (b - d) / (2 * h)))
        (qq, wq), (qw, ww) = columns
        return qq, qw, wq, ww

    fine, coarse = at(5e-7), at(1e-6)
    return [(4 * a - b) / 3 for a, b in zip(fine, coarse, strict=True)]


def product(system, rpm, tape, turns):
    """The same matrix from the kernel, along the impacts of a tape from the strobe at 0."""
    lane, m, now = constants_of(system.machine(rpm), 0.0, 0), (1.0, 0.0, 0.0, 1.0), 0.0
    for kind, period, theta, u in zip(tape.kind, tape.period, tape.theta, tape.u, strict=True):
        if kind != EventKind.IMPACT or period >= turns:
            continue
        place = TURN * period + float(theta)
        lifts = lift(system.cam, stretch_at(system.cam, float(theta)), float(theta))
        m = after_impact(lane, lifts, float(u), *after_flight(lane, place - now, *m))
        now = place
    return after_flight(lane, TURN * turns - now, *m)


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(
    ("rpm", "guess", "turns"),
    [(700, STABLE, 1), (358.5, TWICE, 1), (358.5, THRICE, 3)],
    ids=["P(1;1)", "P(1;2)", "P(3;3:3:2)"],
)
def test_the_trace_is_the_one_of_the_simulated_stroboscopic_map(name, rpm, guess, turns):
    """Kernel products, Newton's trace and central differences, one period long."""
    changes = MACHINES[name]
    chapter = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}
    if guess is not STABLE and name != "chapter":  # that orbit lives in a narrow range only
        shrink = 0.005 if guess is THRICE else 0.1
        changes = {k: v * shrink for k, v in changes.items() if k != "restitution"}
    machine = Machine(**{**chapter, **changes})
    orbit = solve(CAM, machine, rpm, guess, turns)
    system = chapter_system(**changes)
    q, v = (float(x) for x in strobe_state(CAM, machine, rpm, orbit))
    w = v / (rpm * (pi / 30))
    _, tape = strobed(system, rpm, turns, q, w)
    assert sum(list(tape.impacts)[:turns]) == len(orbit.thetas)
    exact = product(system, rpm, tape, turns)
    found = differences(system, rpm, turns, q, w)
    trace = exact[0] + exact[3]
    assert abs(trace - float(orbit.trace)) < 1e-10 * (1 + max(abs(x) for x in exact))
    assert abs(found[0] + found[3] - trace) < 1e-6 * (1 + max(abs(x) for x in exact))
    for a, b in zip(exact, found, strict=True):
        assert abs(a - b) < 1e-6 * (1 + max(abs(x) for x in exact))


def test_the_length_of_the_flights_of_a_log():
    """Phases count from the strobe, on which an impact may lie exactly."""
    system = chapter_system()
    entry, tables = backend.PLAIN.stretch_events, ([Pair()], [Growth()])
    const = system.constants(700.0, 1e-9, 1000)
    theta = [1.0, 0.0, 3.0]
    entry(system.cam, const, [IMPACT] * 3, [0, 1, 1], theta, [-1.0] * 3, *tables)
    assert tables[1][0].length == pytest.approx(TURN + 2.0, rel=1e-15)
