"""The reference for periodic orbits against closed forms, simulated runs and known numbers."""

import pytest
from mpmath import mp, mpf

from tests import oracle
from tests.orbit_oracle import (
    Machine,
    admissible,
    corner_rpm,
    finite_difference_monodromy,
    fold_rpm,
    gap_graze_rpm,
    period_doubling_rpm,
    solve,
    strobe_state,
)

CAM = oracle.ArcsCam()
CHAPTER = Machine(mass=1.221, stiffness=146 * 9.8, restitution=0.8)
OVERDAMPED = Machine(mass=0.7, stiffness=20, restitution=0.8, damping=18, preload=25)
SPRINGLESS = Machine(mass=0.5, stiffness=0, restitution=0.8, damping=4, preload=14)
CLOSED = CAM, CHAPTER.mass, CHAPTER.stiffness, CHAPTER.restitution
TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(60):
        yield


def rad(*degrees):
    return [mp.radians(mpf(x)) for x in degrees]


B, C = CAM.breakpoints[1:3]
STABLE, UNSTABLE = ([(rad(x)[0], u)] for x, u in ((155, 70), (104, 30)))
DOUBLED = [(rad(155.6)[0], 41.9), (rad(519.3)[0], 41.9)]
TWICE = [(rad(151)[0], 36.7), (rad(333)[0], 37.3)]  # P(1;2) at 358.5 rpm
GRAZE = rad(155.4)[0]  # where the flight of UNSTABLE touches the nose
THRICE = list(  # P(3;3:3:2) at 358.5 rpm
    zip(
        rad(71.3, 141.8, 301.4, 466.1, 633.8, 795.9, 906.3, 1009.8),
        [5.75, 7.27, 13.42, 12.49, 11.87, 9.49, 4.1, 7.18],
        strict=True,
    )
)


def close(value, expected, tol):
    assert abs(value - mpf(expected)) < tol, mp.nstr(value, 20)


def repeats(machine, rpm, orbit):
    """A run from the strobe state has the impacts of the orbit, two periods long."""
    data = {**machine._asdict(), "rpm": rpm}
    q, v = strobe_state(CAM, machine, rpm, orbit)
    events = oracle.Oracle(CAM, **data).run(q=q, v=v, turns=2 * orbit.turns)
    period = 2 * mp.pi * orbit.turns
    phases = [x - period * mp.floor(x / period) for x in orbit.thetas]
    expected = sorted(zip(phases, orbit.u_minus, strict=True))
    assert [e.kind for e in events] == ["impact"] * 2 * len(expected)
    for i, event in enumerate(events):
        lap, k = divmod(i, len(expected))
        psi = event.theta + 2 * mp.pi * (event.turn - lap * orbit.turns)
        assert abs(psi - expected[k][0]) < TINY
        assert abs(event.u_minus - expected[k][1]) < TINY * 1e3


def distance(matrix, other):
    return mp.mnorm(matrix - other) / mp.mnorm(other)


@pytest.mark.parametrize(
    ("guess", "piece", "phase", "trace"),
    [
        (STABLE, "A2", "155.3036856027", "0.6027216709"),
        (UNSTABLE, "A1", "104.1608293878", "1.9307756743"),
    ],
)
def test_single_impact_orbits_at_700_rpm(guess, piece, phase, trace):
    orbit = solve(CAM, CHAPTER, 700, guess, 1)
    (closed,) = oracle.single_impact_orbit(*CLOSED, 700, piece)
    assert orbit.pieces == [piece]
    assert admissible(CAM, CHAPTER, 700, orbit)
    degrees, r, omega = mp.degrees(orbit.thetas[0]), mpf(0.8), 700 * mp.pi / 30
    close(degrees, phase, 1e-10)
    close(orbit.trace, trace, 1e-10)
    assert abs(degrees - closed.phase_deg) < TINY
    assert abs(orbit.trace - closed.trace) < mpf(10) ** -30
    assert abs(orbit.det - r**2) < TINY
    assert abs(orbit.u_plus[0] - 2 * r / (1 - r) * omega * CAM.c1(orbit.thetas[0])) < TINY
    assert abs(orbit.u_plus[0] + r * orbit.u_minus[0]) < TINY
    x, y = orbit.multipliers
    assert abs(x + y - orbit.trace) + abs(x * y - orbit.det) < TINY


def test_corner_impact_of_the_single_impact_orbit():
    found = corner_rpm(CAM, CHAPTER, STABLE, 1, 0, B, 680)
    close(found.rpm, "673.2344450038120", 1e-12)
    assert abs(found.rpm - oracle.corner_impact_rpm(*CLOSED)) < TINY
    close(found.left.trace, "1.6418699", 1e-7)
    close(found.right.trace, "1.3714214", 1e-7)
    for orbit, piece in ((found.left, "A1"), (found.right, "A2")):
        assert orbit.pieces == [piece]
        close(orbit.det, "0.64", 1e-15)
        assert admissible(CAM, CHAPTER, found.rpm, orbit)


def test_period_doubling_of_the_single_impact_orbit():
    found = period_doubling_rpm(CAM, CHAPTER, STABLE, 1, 700, 745)
    close(found.rpm, "739.3197802160", 1e-10)
    assert abs(found.rpm - oracle.period_doubling_rpm(*CLOSED)) < 1e-18
    assert admissible(CAM, CHAPTER, found.rpm, found.orbit)
    assert abs(found.orbit.multipliers[1] + 1) < TINY
    with pytest.raises(ArithmeticError, match="no period doubling"):
        period_doubling_rpm(CAM, CHAPTER, STABLE, 1, 700, 730)


@pytest.mark.parametrize(("shift", "piece"), [("-1e-6", "A2"), ("1e-6", "A3")])
def test_only_the_orbit_on_the_piece_it_hits_is_one_of_the_cam(shift, piece):
    """The doubled orbit goes over c upwards in speed; left to itself the piece follows."""
    at = corner_rpm(CAM, CHAPTER, DOUBLED, 2, 1, C, 739.37)
    rpm = at.rpm + mpf(shift)
    on = {p: solve(CAM, CHAPTER, rpm, DOUBLED, 2, [None, p]) for p in ("A2", "A3")}
    assert {p: admissible(CAM, CHAPTER, rpm, on[p]) for p in on} == {p: p == piece for p in on}
    free = solve(CAM, CHAPTER, rpm, DOUBLED, 2)
    assert free.pieces == ["A2", piece]
    assert abs(free.thetas[1] - on[piece].thetas[1]) < TINY
    side = {"A2": at.left, "A3": at.right}[piece]
    assert abs(free.trace - side.trace) < 1e-5
    repeats(CHAPTER, rpm, free)


def test_a_graze_in_closed_form():
    """The low orbit scrapes the nose at 786.7 rpm: q = c cos(w0 (t - T/2)) / cos(w0 T/2)."""
    gap = gap_graze_rpm(CAM, CHAPTER, UNSTABLE, 1, 0, 780, GRAZE)
    (theta,) = gap.orbit.thetas
    w0 = mp.sqrt(mpf(CHAPTER.stiffness) / mpf(CHAPTER.mass))
    t = w0 * 30 / (gap.rpm * mp.pi)  # w0/omega, spring angle per cam angle
    x = t * (gap.theta - theta - mp.pi)
    level, (c, c1, _) = CAM.c(theta) / mp.cos(t * mp.pi), CAM.laws(gap.theta)
    assert abs(level * mp.cos(x) - c) < TINY
    assert abs(-level * t * mp.sin(x) - c1) < TINY
    below, above = (gap.rpm + sign * mpf("1e-9") for sign in (-1, 1))
    orbits = [(rpm, solve(CAM, CHAPTER, rpm, gap.orbit.impacts, 1)) for rpm in (below, above)]
    assert [admissible(CAM, CHAPTER, *pair) for pair in orbits] == [True, False]


@pytest.mark.parametrize(
    ("guess", "turns", "count", "trace"),
    [(THRICE, 3, 8, "-0.203909178529236"), (TWICE, 1, 2, "0.0346508876895966")],
)
def test_orbits_of_many_impacts_at_358_rpm(guess, turns, count, trace):
    orbit = solve(CAM, CHAPTER, 358.5, guess, turns)
    assert admissible(CAM, CHAPTER, 358.5, orbit)
    close(orbit.trace, trace, 1e-14)
    assert abs(orbit.det - mpf(0.8) ** (2 * count)) < TINY
    repeats(CHAPTER, 358.5, orbit)
    assert distance(finite_difference_monodromy(CAM, CHAPTER, 358.5, orbit), orbit.matrix) < 1e-30


def test_fold_and_period_doubling_of_the_orbit_of_three_turns():
    """Where it begins and ends; the run at the lower speed no longer has an orbit to find."""
    fold = fold_rpm(CAM, CHAPTER, THRICE, 3, 358)
    close(fold.rpm, "357.798305863640", 1e-11)
    assert abs(1 - fold.orbit.trace + fold.orbit.det) < TINY
    assert admissible(CAM, CHAPTER, fold.rpm, fold.orbit)
    with pytest.raises(ArithmeticError, match="no orbit"):
        solve(CAM, CHAPTER, fold.rpm - mpf("1e-3"), fold.orbit.impacts, 3)
    flip = period_doubling_rpm(CAM, CHAPTER, THRICE, 3, 358.5, 361, steps=2)
    close(flip.rpm, "359.620525597971", 1e-11)
    assert abs(1 + flip.orbit.trace + flip.orbit.det) < TINY


@pytest.mark.parametrize(
    ("machine", "rpm", "degrees"),
    [
        (CHAPTER._replace(restitution=1, damping=5), 700, 155),
        (CHAPTER._replace(damping=2, gravity=9.81, preload=10, restitution=0.7), 720, 155),
        (OVERDAMPED, 250, 129.8),
        (SPRINGLESS, 150, 137.6),
    ],
    ids=str,
)
def test_the_monodromy_is_the_derivative_of_simulated_runs(machine, rpm, degrees):
    orbit = solve(CAM, machine, rpm, [(mp.radians(degrees), 50 if rpm > 500 else 5)], 1)
    assert admissible(CAM, machine, rpm, orbit)
    repeats(machine, rpm, orbit)
    assert distance(finite_difference_monodromy(CAM, machine, rpm, orbit), orbit.matrix) < 1e-30
    decay = mpf(machine.damping) * mpf(60) / rpm / mpf(machine.mass)
    assert abs(orbit.det - mpf(machine.restitution) ** 2 * mp.exp(-decay)) < TINY
