"""The reference for periodic orbits against closed forms and simulated runs."""

import pytest
from mpmath import mp, mpf

from tests.support.orbit_oracle import (
    CAM,
    CHAPTER,
    DIGITS,
    DOUBLED,
    GRAZE,
    STABLE,
    THRICE,
    UNSTABLE,
    B,
    C,
    Machine,
    admissible,
    corner_rpm,
    finite_difference_monodromy,
    gap_graze_rpm,
    period_doubling_rpm,
    solve,
)

OVERDAMPED = Machine(mass=0.7, stiffness=20, restitution=0.8, damping=18, preload=25)
TINY = mpf(10) ** -40


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(DIGITS):
        yield


@pytest.mark.parametrize(("guess", "piece"), [(STABLE, "A2"), (UNSTABLE, "A1")])
def test_single_impact_orbits_at_700_rpm(guess, piece):
    """The closed form, where the flight is a cosine: W = w0/omega, u+ = -r u-,

    c = (1 + r)/(1 - r) cot(pi W) c_theta/W,   trace = -2 r C - (1 + r)(c_thetatheta + W^2 c)/u- S/W
    """
    orbit = solve(CAM, CHAPTER, 700, guess, 1)
    r, omega = mpf(CHAPTER.restitution), mpf(700) * mp.pi / 30
    W = mp.sqrt(mpf(CHAPTER.stiffness) / mpf(CHAPTER.mass)) / omega
    c, c1, c2 = CAM.laws(orbit.thetas[0])
    S, C, u = mp.sin(2 * mp.pi * W), mp.cos(2 * mp.pi * W), orbit.u_minus[0] / omega
    assert orbit.pieces == [piece]
    assert admissible(CAM, CHAPTER, 700, orbit)
    assert abs(c - (1 + r) / (1 - r) * mp.cot(mp.pi * W) * c1 / W) < TINY
    assert abs(orbit.trace + 2 * r * C + (1 + r) * (c2 + W * W * c) / u * S / W) < TINY
    assert abs(orbit.det - r**2) < TINY


def test_published_bifurcations():
    """Of P(1;1): the corner impact at b, real multipliers from trace^2 = 4 det on, the doubling."""
    corner = corner_rpm(CAM, CHAPTER, STABLE, 1, 0, B, 680).rpm
    assert abs(corner - mpf("673.2344450038120")) < 1e-12
    assert abs(solve(CAM, CHAPTER, "738.7743752", STABLE, 1).trace + mpf("1.6")) < 1e-8
    doubling = period_doubling_rpm(CAM, CHAPTER, STABLE, 1, 700, 745).rpm
    assert abs(doubling - mpf("739.3197802160")) < 1e-9


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
    assert abs(free.trace - {"A2": at.left, "A3": at.right}[piece].trace) < 1e-5


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


@pytest.mark.parametrize(
    ("machine", "rpm", "guess", "turns"),
    [(CHAPTER, 358.5, THRICE, 3), (OVERDAMPED, 250, [(mp.radians(129.8), 5)], 1)],
    ids=["P(3;3:3:2)", "overdamped"],
)
def test_the_monodromy_is_the_derivative_of_simulated_runs(machine, rpm, guess, turns):
    orbit = solve(CAM, machine, rpm, guess, turns)
    assert admissible(CAM, machine, rpm, orbit)
    found = finite_difference_monodromy(CAM, machine, rpm, orbit)
    assert mp.mnorm(found - orbit.matrix) < mpf(10) ** -30 * mp.mnorm(orbit.matrix)
