"""First landings enclosed in doubles: mpmath and balls lie inside; near a graze nothing is said.

mpmath flies over the circles of the cam in closed form (`tests.support.oracle`) and knows nothing
of the package; the judge in balls knows every kind of cam.
"""

from fractions import Fraction
from itertools import product
from math import exp, factorial
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb, arb_series
from mpmath import mp, mpf

from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import Part, build
from camcli.exact import table_bounds as table_bounds_module
from camcli.exact.machine import BallMachine, BallStretch
from camcli.exact.table_bounds import _long_series, _of_piece, table_bounds
from camcli.kernel.cam_table import LIFT, PIECE, TERMS, derivative, lift_at, stretch_at
from camcli.kernel.enclosed_landing import (
    ACCEL,
    ANGLE,
    COLUMNS,
    ENCLOSED,
    J11,
    JERK,
    LONGEST,
    RATE,
    ROOM,
    THETA,
    ULP,
    UNDECIDED,
    Ball,
    Leap,
    U,
    _gap_after,
    _times,
    enclose_landing,
)
from camcli.kernel.flow import constants_of, flow
from camcli.system import Follower, System
from tests.support import oracle
from tests.support.kernel_runs import CHAPTER, ORACLE_CAM, machine
from tests.support.machines import Shape
from tests.support.random_flights import CAMS, cam_of, machine_on, true_contact

BOUNDS = {name: table_bounds(cam_of(name).shape, cam_of(name).cam) for name in CAMS}


def enclosed(system, rpm, theta, rate, radii=(0.0, 0.0), bounds=BOUNDS["chapter"]):
    """The code, and the column that `enclose_landing` leaves."""
    room = [*system.machine(rpm), *bounds, theta, rate, *radii]
    room += [0.0] * (COLUMNS - len(room))
    return enclose_landing(system.cam, room), room


def holds(room, column, value) -> bool:
    return abs(mpf(room[column]) - value) <= room[column + 1]


class Truth:
    """The map from one impact to the next on the chapter's cam, in mpmath."""

    def __init__(self, rpm, **changes):
        data = {"damping": 0.0, "gravity": 0.0, "preload": 0.0, **CHAPTER, **changes}
        self.r = mpf(data.pop("restitution"))
        self.omega = mpf(rpm) * mp.pi / 30
        self.follower = oracle.Follower.make(**data)

    def __call__(self, theta, rate):
        """(rad of flight, rate after, gap', gap'', gap''') in m and rad, or None."""
        c, c1, _ = ORACLE_CAM.laws(theta)
        flight = oracle.Flight(
            ORACLE_CAM, self.follower, self.omega, theta, c, self.omega * (c1 + rate)
        )
        hit = flight.first_contact(12 * mp.pi / self.omega, True)
        if hit is None:
            return None
        s, u = hit.t * self.omega, hit.g1 / self.omega

        def accel(x):
            arc = next(ORACLE_CAM.segments(theta + s, -1))
            return flight.at(x / self.omega, arc).g2 / self.omega**2

        return s, -self.r * u, u, accel(s), mp.diff(accel, s)


def true_flow(rpm, stiffness, damping, s):
    """B, B' and P of a follower of 1 kg after s rad, in 160 digits."""
    omega = mpf(rpm) * mp.pi / 30
    w2, z, s = mpf(stiffness) / omega**2, mpf(damping) / 2 / omega, mpf(s)
    root = mp.sqrt(abs(z * z - w2)) or mpf("1e-60")
    sine, cosine = (mp.sinh, mp.cosh) if z * z > w2 else (mp.sin, mp.cos)
    b = mp.exp(-z * s) * sine(root * s) / root
    b1 = mp.exp(-z * s) * cosine(root * s) - z * b
    return b, b1, (1 - b1 - 2 * z * b) / w2


def test_the_flow_is_better_than_its_room():
    """By five times, for any frequency and damping, near critical damping too."""
    rng, worst = np.random.default_rng(9), 0.0
    with mp.workdps(160):
        for _ in range(400):
            rpm, W = float(10 ** rng.uniform(0, 5)), 10 ** rng.uniform(-6, 3)
            near = W * (1 + rng.choice([-1, 1]) * 10 ** rng.uniform(-15, -3))
            Z = rng.choice([0.0, near, W * 10 ** rng.uniform(-6, 4)])
            omega, s = rpm * np.pi / 30, float(10 ** rng.uniform(-8, 2.5))
            stiffness, damping = float((W * omega) ** 2), float(2 * Z * omega)
            const = constants_of((rpm, 1.0, stiffness, damping, 0.0, 0.0, 0.5, -1.0), -1.0, 0)
            if (const.W + const.Z) * s > LONGEST:
                continue
            room = ROOM * (1.0 + (const.W + const.Z) * s)
            true = true_flow(rpm, stiffness, damping, s)
            for x, y, unit in zip(flow(const, s), true, (s, 1.0, s * s), strict=True):
                worst = max(worst, float(abs(x - y) / (room * unit)))
    assert 0.01 < worst < 0.2


@pytest.mark.parametrize("seed", range(3))
def test_what_mpmath_finds_lies_within(seed):
    """Phase, rate, derivatives of the gap, and the derivatives of the map by its start."""
    rng, count = np.random.default_rng(seed), 0
    with mp.workdps(50):
        for _ in range(30):
            rpm = float(rng.uniform(100.0, 900.0))
            changes = {
                "damping": float(rng.choice([0.0, 20.0, 150.0])),
                "gravity": float(rng.choice([0.0, 9.81])),
                "restitution": float(rng.uniform(0.2, 1.0)),
            }
            system = machine(0.0).with_follower(**{**CHAPTER, **changes})
            theta, rate = float(rng.uniform(0.0, 6.28)), float(10 ** rng.uniform(-3, 0.3))
            code, room = enclosed(system, rpm, theta, rate)
            if code != ENCLOSED:
                continue
            count += 1
            truth = Truth(rpm, **changes)
            s, after, *gap = truth(mpf(theta), mpf(rate))
            assert holds(room, ANGLE, s)
            for column, value in zip((U, ACCEL, JERK), gap, strict=True):
                assert holds(room, column, value), column
            assert room[ANGLE + 1] < 1e-9
            step = mpf("1e-22")
            for k, (dtheta, drate) in enumerate(((step, 0), (0, step))):
                s1, after1, *_ = truth(theta + dtheta, rate + drate)
                assert holds(room, J11 + 2 * k, (s1 + dtheta - s) / step)
                assert holds(room, J11 + 2 * k + 4, (after1 - after) / step)
    assert count > 20


def test_it_holds_for_all_starts_within_their_radii():
    rng, count = np.random.default_rng(3), 0
    with mp.workdps(40):
        truth = Truth(358.0)
        for _ in range(12):
            theta, rate = float(rng.uniform(0.0, 6.28)), float(10 ** rng.uniform(-2, 0.3))
            radii = [float(10 ** rng.uniform(-12, -6)) for _ in range(2)]
            code, room = enclosed(machine(0.0), 358.0, theta, rate, radii)
            if code == ENCLOSED:
                count += 1
                for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                    start = (theta + signs[0] * mpf(radii[0]), rate + signs[1] * mpf(radii[1]))
                    s, _, *gap = truth(*start)
                    assert holds(room, ANGLE, s)
                    for column, value in zip((U, ACCEL, JERK), gap, strict=True):
                        assert holds(room, column, value), column
    assert count > 5


def judged(name, system, rpm, theta, rate) -> int:
    """The code of a flight, after a look at what balls say of its first contact."""
    code, room = enclosed(system, rpm, theta, rate, bounds=BOUNDS[name])
    if code == ENCLOSED and room[ANGLE] < 15.0:
        with precision(60):
            machine = BallMachine(system.shape, system.follower, rpm)
            i = next(k for k, part in enumerate(machine.stretches) if part.end > theta)
            w = machine.stretches[i].derivatives(arb(theta), 1)[1] + rate
            flight = SimpleNamespace(system=system, rpm=rpm, theta=theta, w=w, contact=True)
            s, u = true_contact(flight)
            assert abs(s - room[ANGLE]) < room[ANGLE + 1]
            assert abs(u - room[U]) < room[U + 1]
    return code


@pytest.mark.parametrize("name", CAMS)
def test_no_contact_is_missed_on_any_cam(name):
    rng, count = np.random.default_rng(11), 0
    for _ in range(60):
        system, rpm, lift = machine_on(name, rng)
        theta, rate = float(rng.uniform(0.0, 6.28)), lift * float(10 ** rng.uniform(-3, 1.0))
        count += judged(name, system, rpm, theta, rate) == ENCLOSED
    assert count > 20


def test_beside_a_graze_the_earlier_contact_is_found_or_nothing_said():
    """The rate at which the first landing jumps, to its last digit, and beside it."""
    system, told, grazes = machine(0.0), 0, 0
    for theta in np.linspace(1.6, 4.6, 40):
        rates = np.linspace(0.02, 0.6, 25)
        ends = [enclosed(system, 358.0, float(theta), float(rate))[1][ANGLE] for rate in rates]
        for low, high, before, after in zip(rates, rates[1:], ends, ends[1:], strict=False):
            if before == 0.0 or after == 0.0 or abs(after - before) < 0.3:
                continue
            while low < (middle := 0.5 * (low + high)) < high:
                room = enclosed(system, 358.0, float(theta), float(middle))[1]
                nearer = abs(room[ANGLE] - before) < abs(room[ANGLE] - after)
                low, high = (middle, high) if nearer else (low, middle)
            grazes += 1
            for off in (0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-10, 1e-8):
                for sign in (-1.0, 1.0):
                    code = judged("chapter", system, 358.0, float(theta), float(low + sign * off))
                    told += code == ENCLOSED
    assert grazes > 3
    assert told > 5 * grazes


@pytest.mark.parametrize("column", [THETA, RATE])
def test_nothing_is_said_where_nothing_is_shown(column):
    """A start on a corner, one that does not rise, one known too badly, and no number at all."""
    system = machine(0.0)
    assert enclosed(system, 358.0, system.corners[1], 0.2)[0] == UNDECIDED
    assert enclosed(system, 358.0, 2.0, 0.0)[0] == UNDECIDED
    assert enclosed(system, 358.0, 2.0, -0.1)[0] == UNDECIDED
    radii = (1e-3, 0.0) if column == THETA else (0.0, 1e-3)
    assert enclosed(system, 358.0, 2.0, 0.2, radii)[0] == UNDECIDED
    start = [2.0, 0.2]
    start[column - THETA] = float("nan")
    assert enclosed(system, 358.0, *start)[0] == UNDECIDED


def test_the_bounds_hold_where_the_table_is_compared_with_mpmath():
    """c to c''' at random phases of the circles, and a coefficient changed is seen."""
    rng, system = np.random.default_rng(5), machine(0.0)
    errors, sizes = BOUNDS["chapter"][:5], BOUNDS["chapter"][5:]
    with mp.workdps(40):
        for theta in map(float, rng.uniform(0.0, 6.28, 60)):
            i = stretch_at(system.cam, theta)
            c = [*lift_at(system.cam, i, theta)]
            c.append(derivative(system.cam, 3, i, theta))
            true = [*ORACLE_CAM.laws(theta)]
            true.append(mp.diff(lambda x: ORACLE_CAM.laws(x)[2], mpf(theta), h=mpf("1e-15")))
            for k in range(4):
                assert abs(mpf(c[k]) - true[k]) <= errors[k] + mpf("1e-16") * sizes[k] * k
                assert abs(c[k]) <= sizes[k]
    assert errors[0] < 1e-14
    table = build(system.shape)
    pieces = list(table.pieces)
    pieces[system.cam.stretches[1].first_piece * PIECE + LIFT + 3] += 1e-9  # of x^3
    half = (table.stretches[1].end - table.stretches[1].start) / 16.0
    off = table_bounds(system.shape, table._replace(pieces=pieces))[0]
    assert 0.9e-9 * half**3 < off - errors[0] < 1.1e-9 * half**3


def test_what_a_polynomial_leaves_out_is_bounded():
    """Of exp on [-1, 1] by its first 14 terms: e - sum 1/k! there, and its derivatives."""
    terms = [1.0 / factorial(k) for k in range(TERMS)]
    piece = [0.0, *terms, *[0.0] * (PIECE - 1 - TERMS)]
    row = SimpleNamespace(start=-1.0, end=1.0, piece_count=1)
    with precision(40), _long_series():
        stretch = BallStretch(arb(-1), arb(1), lambda theta: theta.exp(), arb(0))
        cells = _of_piece([stretch], row, piece)
    for order in range(5):
        left_out = sum(1.0 / factorial(k) for k in range(TERMS - order, 40))
        largest = max(errors[order] for errors, _ in cells)
        assert left_out * 0.999 < largest < 1.2 * left_out
        assert exp(1.0) * 0.999 < max(sizes[order] for _, sizes in cells) < exp(1.0) * 1.05
    with precision(40), pytest.raises(UndecidedError):
        _of_piece([stretch], row, piece)


def test_what_lies_beyond_the_order_of_a_polynomial_is_bounded():
    """Of x^20 on [-1, 1] by nothing: 1 and 20 at its end."""
    row = SimpleNamespace(start=-1.0, end=1.0, piece_count=1)
    with precision(40), _long_series():
        stretch = BallStretch(arb(-1), arb(1), lambda theta: theta**20, arb(0))
        cells = _of_piece([stretch], row, [0.0] * PIECE)
    for order, largest in enumerate((1.0, 20.0)):
        assert largest <= max(errors[order] for errors, _ in cells) < 1.1 * largest


@pytest.mark.parametrize("lift", [lambda x: x.log(), lambda x: arb_series([x[0], 1], 5)])
def test_a_cam_of_which_nothing_can_be_shown_has_no_bounds(lift, monkeypatch):
    """Its series is no number on some cells, or too short."""
    system = cam_of("eccentric")
    shown = BallStretch(arb(0), 2 * arb.pi(), lift, arb(0))
    monkeypatch.setattr(table_bounds_module, "stretches_of", lambda shape: [shown])
    assert table_bounds(system.shape, system.cam) is None


def test_a_table_of_another_cam_has_no_bounds():
    other = System.build(Follower(**CHAPTER), cam_of("law-smooth").shape)
    assert table_bounds(machine(0.0).shape, other.cam) is None


def test_a_product_of_numbers_with_radii_holds_every_product():
    """In fractions, of the ends of both; radii may be as large as the numbers, or none."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        a, b = (float(x) for x in rng.normal(size=2))
        da, db = (abs(x) * float(rng.choice([0.0, 1e-16, 0.5, 1.0, 4.0])) for x in (a, b))
        middle, radius = _times(Ball(a, da), Ball(b, db))
        for x, y in product((Fraction(a) - Fraction(da), Fraction(a) + Fraction(da)),
                            (Fraction(b) - Fraction(db), Fraction(b) + Fraction(db))):  # fmt: skip
            assert abs(x * y - Fraction(middle)) <= Fraction(radius)
        assert radius >= ULP * abs(middle)


def test_every_addend_of_a_gap_and_its_derivatives_adds_its_rounding():
    """The largest addend is another one in each of these machines, which are of any size."""
    rng, system = np.random.default_rng(6), machine(0.0)
    for _ in range(400):
        k, b, g = (float(10 ** rng.uniform(-4, 6)) for _ in range(3))
        const = constants_of((600.0, 1.0, k, b, g, 0.0, 0.5, -1.0), -1.0, 0)
        theta, s = float(rng.uniform(0.1, 6.0)), float(10 ** rng.uniform(-7, -2))
        q, w = (float(10 ** rng.uniform(-7, 3)) for _ in range(2))
        force = const.G + const.W2 * q
        leap = Leap(theta, q, w, force, abs(force), 1.0, 1.0, *[0.0] * 6)
        i = stretch_at(system.cam, theta)
        if not theta + s < system.cam.stretches[i].end:
            continue
        gap = _gap_after(system.cam, const, [0.0] * COLUMNS, leap, i, 0.0, s)
        lift = (*lift_at(system.cam, i, theta + s), derivative(system.cam, 3, i, theta + s))
        q, w, y = gap.g + lift[0], gap.u + lift[1], gap.a + lift[2]
        addends = (
            (gap.dg, q, lift[0]),
            (gap.du, w, lift[1]),
            (gap.da, const.G, const.W2 * q, 2.0 * const.Z * w, lift[2]),
            (gap.djerk, 2.0 * const.Z * y, const.W2 * w, lift[3]),
        )
        for radius, *parts in addends:
            assert radius >= 8.0 * ULP * max(map(abs, parts)), (radius, parts)


@pytest.mark.parametrize("rate", [0.005, 0.02, 0.025])
def test_a_bump_behind_a_level_stretch_is_met(rate):
    """Without a force the gap to the level part is rate s, and nothing there tells of the bump."""
    long = 2 * arb.pi() - 2

    def bump(theta):
        y = (theta - 2) / long
        return (4 * y * (1 - y)) ** 20 / 10

    parts = [Part(arb(0), arb(2), None), Part(arb(2), 2 * arb.pi(), bump)]
    system = System.build(Follower(mass=1.0, stiffness=0.0), Shape(lambda: parts))
    bounds = table_bounds(system.shape, system.cam)
    code, room = enclosed(system, 300.0, 0.5, rate, bounds=bounds)
    assert code == ENCLOSED
    with mp.workdps(30):
        length = 2 * mp.pi - 2
        cam = lambda x: (4 * (x - 2) / length * (1 - (x - 2) / length)) ** 20 / 10  # noqa: E731
        x = mp.findroot(lambda x: rate * (x - mpf("0.5")) - cam(x), (3.2, 4.1), solver="anderson")
        assert x < 2 + length / 2
        assert holds(room, ANGLE, x - mpf("0.5"))
