"""Solved orbits against a dense scan, the multiple-precision oracle and simulated machines."""

import itertools
import random
from math import exp, pi

import numpy as np
import pytest
from conftest import solve_from
from mpmath import mp

from camcli.analysis.border_collision import multipliers
from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits.identify import RecordedImpact, newton_from
from camcli.analysis.orbits.orbit import from_root
from camcli.analysis.orbits.shooter import Shooter, _natural
from camcli.analysis.orbits.single_impact import _Equation, single_impact_roots
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.quantities import PARAMETERS
from camcli.system import omega_of
from tests.conftest import chapter_system, settings
from tests.support import oracle, orbit_oracle
from tests.support.orbit_oracle import DOUBLED, STABLE, THRICE, TWICE, UNSTABLE, Machine, solve

CAM = oracle.ArcsCam()
CHAPTER = {"mass": 1.221, "stiffness": 1430.8, "restitution": 0.8}
POINTS = 100_000
FOLLOWERS = [
    {},
    {"damping": 50.0},
    {"restitution": 0.0},
    {"restitution": 1.0, "damping": 2.0},
    {"restitution": 0.5, "damping": 2.0, "gravity": 9.81, "preload": -20.0},
]


def arcs(theta):
    """(c, c_theta) at every angle in [0, 2 pi) of an array, from the circles alone."""
    bounds = [float(x) for x in CAM.breakpoints]
    piece = np.searchsorted(bounds, theta, side="right") - 1
    c, c1 = np.empty_like(theta), np.empty_like(theta)
    for k, arc in enumerate(CAM.arcs):
        at = (piece % 6) == k
        K, rho, shift = float(arc.K), float(arc.rho), float(arc.offset)
        x = theta[at] - float(arc.origin)
        root = np.sqrt(rho * rho - (K * np.sin(x)) ** 2)
        c[at] = K * np.cos(x) + root - shift
        c1[at] = -K * np.sin(x) - K * K * np.sin(x) * np.cos(x) / root
    return c, c1


def closure(follower, rpm, turns, c, c1):
    """u+ + r u- for a flight from q = c back to q = c, by complex exponentials in time."""
    f, omega = follower, rpm * pi / 30
    time, z, w2 = 2 * pi * turns / omega, f.damping / 2 / f.mass, f.stiffness / f.mass
    root = np.sqrt(complex(z * z - w2))
    fast, slow = np.exp((-z - root) * time), np.exp((-z + root) * time)
    b, even = ((slow - fast) / (2 * root)).real, ((slow + fast) / 2).real
    x = c + (f.gravity + f.preload / f.mass) / w2
    v0 = (1 - even - z * b) * x / b
    v1 = -w2 * b * x + (even - z * b) * v0
    return (v0 - omega * c1 + f.restitution * (v1 - omega * c1)) * b


THETA = (np.arange(POINTS) + 0.5) * (2 * pi / POINTS)
LIFTS = arcs(THETA)


def refined(f, low, high):
    """A sign change narrowed by bisection to rounding."""
    below = f(low) < 0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (f(middle) < 0) == below else (low, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize("changes", FOLLOWERS, ids=str)
def test_single_impact_roots_are_those_of_a_dense_scan(changes):
    """As many as sign changes of the closure equation, each at its place."""
    system, total = chapter_system(**changes), 0
    for rpm in (300.0, 520.0, 739.5, 1100.0, 5000.0):
        shooter = Shooter(system, rpm)
        for turns in (1, 2, 3):

            def h(theta, rpm=rpm, turns=turns):
                return closure(system.follower, rpm, turns, *arcs(np.array([theta])))[0]

            scan = closure(system.follower, rpm, turns, *LIFTS)
            cells = np.nonzero(np.sign(scan[1:]) != np.sign(scan[:-1]))[0]
            found = sorted(r.theta[0] for r in single_impact_roots(shooter, rpm, turns))
            assert len(found) == len(cells), (rpm, turns)
            total += len(cells)
            for theta, cell in zip(found, cells, strict=True):
                exact = refined(h, THETA[cell], THETA[cell + 1])
                assert abs(theta - exact) < 1e-9, (rpm, turns)
    assert total


def test_a_root_on_the_boundary_of_two_stretches_is_found_once():
    """The strobe phase is a boundary of the table: put it exactly on the orbit's impact."""
    roots = single_impact_roots(Shooter(chapter_system(), 700.0), 700.0, 1)
    (plain,) = [r for r in roots if r.trace < 1]
    for shift in (0.0, 1e-15, -1e-15, 1e-13):
        system = chapter_system((plain.theta[0] + shift) * 180 / pi)
        roots = single_impact_roots(Shooter(system, 700.0), 700.0, 1)
        assert len({round(r.theta[0], 9) for r in roots}) == 2


@pytest.mark.parametrize(("stiffness", "gravity"), [(1430.8, 0.0), (0.0, 9.81)])
def test_an_elastic_undamped_follower_has_no_isolated_orbit(stiffness, gravity):
    """r = 1, b = 0: a flight is as fast at its end as at its start, so c_theta = 0 at the impact.

    That is so on the dwells, where every phase solves the closure equation and none is isolated.
    """
    system = chapter_system(restitution=1.0, stiffness=stiffness, gravity=gravity)
    assert single_impact_roots(Shooter(system, 700.0), 700.0, 1) == []


ORACLE_CASES = {
    "P(1;1)": (700, STABLE, 1),
    "P(1;1) unstable": (700, UNSTABLE, 1),
    "P(2;1:1)": (739.35, DOUBLED, 2),
    "P(3;3:3:2)": (358.5, THRICE, 3),
    "P(1;2)": (358.5, TWICE, 1),
}


def solved(system, rpm, orbit):
    """The package's orbit from the oracle's impacts, phases rounded to a degree's hundredth."""
    impacts = []
    for theta, u in zip(orbit.thetas, orbit.u_minus, strict=True):
        turn, phase = divmod(float(theta), 2 * pi)
        u_by_angle = float(u) / (rpm * pi / 30)
        impacts.append(RecordedImpact(int(turn), round(phase, 4), u_by_angle))
    return newton_from(Shooter(system, rpm), sorted(impacts), orbit.turns)


def close(value, exact, relative=1e-11):
    assert abs(complex(value) - complex(exact)) <= relative * abs(complex(exact))


@pytest.mark.parametrize("name", ORACLE_CASES)
@pytest.mark.parametrize(
    "changes", [{}, {"damping": 0.02, "gravity": 0.05, "preload": 0.1}], ids=str
)
def test_orbits_agree_with_the_oracle(name, changes):
    rpm, guess, turns = ORACLE_CASES[name]
    machine, system = Machine(**CHAPTER, **changes), chapter_system(**changes)
    exact = solve(CAM, machine, rpm, guess, turns)
    root = solved(system, float(rpm), exact)
    assert Shooter(system, float(rpm)).admits(root)
    orbit, omega = from_root(system, root), mp.mpf(rpm) * mp.pi / 30
    close(orbit.trace, exact.trace)
    close(orbit.det, exact.det, 1e-13)
    theirs = sorted(exact.multipliers, key=lambda z: (-abs(z), -mp.im(z)))
    for mine, other in zip(orbit.multipliers, theirs, strict=True):
        close(mine, other)
    pairs = sorted(zip(root.theta, root.rates, root.x[1::2], strict=False))
    theirs = sorted(
        (th - 2 * mp.pi * mp.floor(th / (2 * mp.pi)), um, up)
        for th, um, up in zip(exact.thetas, exact.u_minus, exact.u_plus, strict=True)
    )
    for (theta, u, v), (th, um, up) in zip(pairs, theirs, strict=True):
        close(theta, th)
        close(u, um / omega)
        close(v, up / omega)
    q, w = orbit_oracle.strobe_state(CAM, machine, rpm, exact)
    away = [max(abs(s[0] - float(q)), abs(s[1] - float(w / omega))) for s in orbit.states]
    assert min(away) < 1e-11


def test_multipliers_are_the_roots_without_cancellation():
    traces = (-1e8, -4.0910731, -1.7, -1e-9, 0.0, 0.3, 1.6418699, 2.5, 1e8)
    for trace, det in itertools.product(traces, (0.0, 1e-12, 0.4096, 0.64, 1.0)):
        with mp.workdps(60):
            half = mp.mpf(trace) / 2
            root = mp.sqrt(half**2 - mp.mpf(det))
            exact = sorted((half + root, half - root), key=lambda z: (-abs(z), -mp.im(z)))
            loose = float(1 + abs(half / root)) if root != 0 else 1.0
            for found, value in zip(multipliers(trace, det), exact, strict=True):
                assert abs(mp.mpc(found) - value) <= 4e-16 * loose * abs(value), (trace, det)


def test_what_is_solved_repeats_under_simulation():
    """Two periods from the strobe state: the same states, and the counts of the label."""
    rng, solved = random.Random(1), 0
    while solved < 8:  # a quarter of the machines
        rpm, restitution = rng.uniform(500.0, 760.0), rng.uniform(0.3, 0.95)
        ends = {"damping": (0.0, 5.0), "gravity": (0.0, 20.0), "preload": (-5.0, 30.0)}
        loads = {name: rng.choice([0.0, rng.uniform(*span)]) for name, span in ends.items()}
        system = chapter_system(restitution=restitution, **loads)
        orbit = solve_from(system, rpm, settings(transient=120))
        if orbit is not None and not orbit.resting:
            repeats(system, rpm, orbit)
            solved += 1


def repeats(system, rpm, orbit):
    """Checks an orbit against its label, its multipliers and two simulated periods."""
    omega = omega_of(rpm)
    assert orbit.stable
    assert orbit.admissible
    lam, mu = orbit.multipliers
    assert abs(lam * mu - orbit.det) <= 1e-13 * max(orbit.det, abs(lam) ** 2 * 1e-3)
    assert abs(lam + mu - orbit.trace) <= 1e-13 * (1 + abs(orbit.trace))
    decay = exp(-system.follower.damping / system.follower.mass * TURN * orbit.turns / omega)
    expected = system.follower.restitution ** (2 * orbit.impacts) * decay
    assert abs(orbit.det - expected) <= 1e-12 * expected
    assert sum(orbit.symbols) == orbit.impacts == len(orbit.theta)
    q, w = orbit.states[0]
    tape = Orbit(system, rpm, settings(record=2 * orbit.turns, q=q, v=w * omega)).run()
    assert [float(x) for x in list(tape.impacts)[: 2 * orbit.turns]] == [*orbit.symbols] * 2
    for j, column in enumerate((tape.strobe_q, tape.strobe_w)):
        size = max(abs(s[j]) for s in orbit.states)
        for k in range(2 * orbit.turns):
            assert abs(float(column[k]) - orbit.states[k % orbit.turns][j]) < 1e-10 * size


@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_the_rate_where_every_flight_is_back(restitution):
    """At half a natural period a turn, w_out = -w_in: c' + v = -(c' - v/r), v = 2 r c'/(1 - r)."""
    system = chapter_system(restitution=restitution)
    f = system.follower
    equation = _Equation(Shooter(system, 700.0), 2.0 * (f.stiffness / f.mass) ** 0.5 * 30 / pi, 1)
    assert abs(equation.B) < 1e-12
    for deg in (100.0, 130.0, 155.0):
        i = stretch_at(system.cam, deg * pi / 180.0)
        _, slope, _ = lift_at(system.cam, i, deg * pi / 180.0)
        wanted = 2.0 * restitution * slope / (1.0 - restitution)
        assert equation.rate(i, deg * pi / 180.0) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "size"),
    [("stiffness", 18.0), ("damping", 6.0), ("gravity", 9.0), ("preload", 18.0),
     ("restitution", 1.0), ("seat_restitution", 1.0), ("mass", 0.0)],
)  # fmt: skip
def test_the_size_of_a_number_is_that_of_inertia_at_a_metre(name, size):
    """Of 2 kg at 3 rad/s: m w^2 for forces and stiffness, m w for damping, w^2 for gravity."""
    assert _natural([*PARAMETERS].index(name), 2.0, 3.0) == size
