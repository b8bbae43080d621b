"""The quick motion is that in balls: the oracle's events, as many digits, as small errors."""

import json
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from flint import arb, arb_mat, ctx

from camcli.analysis.integrate import Orbit
from camcli.analysis.orbits.identify import departures
from camcli.cams.arcs import ArcsCam
from camcli.cams.balls import UndecidedError, precision
from camcli.exact.machine import BallMachine
from camcli.exact.motion import BallMotion
from camcli.exact.quick_motion import LandingTable, QuickMotion, StateSpread
from camcli.kernel.enclosed_landing import RATE, RATE_RADIUS, THETA, THETA_RADIUS
from camcli.kernel.forms import as_list
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import settings
from tests.support.kernel_runs import GEOMETRY, cam
from tests.support.make_flights import CHAPTER

FLIGHTS = json.loads((Path(__file__).parents[1] / "support/flights.json").read_text())
CORNER_B = 2.621124501166232  # rad
ARCS = ArcsCam(kind="arcs", **GEOMETRY)


class Counted(QuickMotion):
    """Counts the steps that doubles and balls do."""

    quick = slow = 0

    def _quick_step(self) -> bool:
        done = super()._quick_step()
        self.quick += done
        self.slow += not done
        return done


def quick(follower, rpm, shape=ARCS, theta=CORNER_B, machine=None) -> Counted:
    machine = machine or BallMachine(shape, follower, rpm)
    return Counted(machine, 0.0, theta, LandingTable(shape, follower, 0.0, rpm))


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_events_are_the_oracles(name):
    """As far as the first chatter: each impact and departure to 25 digits, and none between."""
    case = FLIGHTS[name]
    follower = Follower(**{**CHAPTER, **case["changes"]})
    with precision(200):
        motion = quick(follower, case["rpm"])
        theirs = [(arb(phi), arb(u)) for kind, phi, u in case["events"] if kind == "impact"]
        while len(motion.trail.states) < case["turns"]:
            motion.step()
        trail = motion.trail
        first = trail.chatters[0].lower() if trail.chatters else arb(1e9)
        mine = [hit for hit in trail.impacts if hit[0] < first][: len(theirs)]
        assert len(mine) >= 3
        for (phi, u), (their_phi, their_u) in zip(mine, theirs, strict=False):
            assert phi.rad() < 1e-40
            assert (phi + arb(0, "1e-25")).contains(their_phi)
            assert (u + arb(0, "1e-25")).contains(their_u)
    assert motion.quick > 3 * motion.slow


@pytest.mark.parametrize("digits", [60, 380])
@pytest.mark.parametrize("rpm", [190.0, 345.3, 358.0, 745.0])
def test_it_is_the_motion_in_balls(rpm, digits):
    """Impacts overlap in both, symbols and strobes are the same, and errors are as small."""
    with precision(digits):
        balls = BallMotion(BallMachine(ARCS, Follower(**CHAPTER), rpm), 0.0, CORNER_B)
        doubles = quick(Follower(**CHAPTER), rpm)
        for _ in range(45 if digits == 60 else 12):
            balls.step()
            doubles.step()
        same_trails(balls, doubles)
        assert doubles.phi.rad() < 1e3 * balls.phi.rad()
    assert doubles.quick > 3 * doubles.slow


def same_trails(balls, doubles):
    for name in ("impacts", "states"):
        pairs = zip(getattr(balls.trail, name), getattr(doubles.trail, name), strict=True)
        assert all(x.overlaps(y) for one, other in pairs for x, y in zip(one, other, strict=True))
    for name in ("leaves", "chatters"):
        pairs = zip(getattr(balls.trail, name), getattr(doubles.trail, name), strict=True)
        assert all(x.overlaps(y) for x, y in pairs)
    assert balls.trail.symbols == doubles.trail.symbols


@pytest.mark.parametrize("name", ["law-cycloidal", "eccentric", "valve-train", "lift-table"])
def test_every_kind_of_cam_and_a_damped_follower(name):
    """Departures as the kernel finds them; doubles do most of the steps."""
    scene = load_scene(f"configs/{name}.yaml")
    follower = Follower(**scene.follower.model_dump())
    system = System.build(follower, scene.cam)
    rpm = {"valve-train": 6500.0, "lift-table": 5000.0}.get(name, 300.0)
    found = departures(Orbit(system, rpm, settings(0, 5)).run())
    assert found, "at this speed it leaves from rest"
    _, theta = found[0]
    with precision(60):
        balls = BallMotion(BallMachine(scene.cam, follower, rpm), 0.0, theta)
        doubles = quick(follower, rpm, scene.cam, theta)
        for _ in range(15):
            balls.step()
            doubles.step()
        same_trails(balls, doubles)
    assert doubles.quick > doubles.slow


@pytest.mark.parametrize("rpm", [198.7, 203.0, 345.3])
def test_all_machines_of_a_speed_hold_each_of_them(rpm):
    """Impacts of the speeds half a digit off lie in those of all speeds that round so."""
    follower = Follower(**CHAPTER)
    with precision(60):
        every = quick(follower, rpm, machine=BallMachine.within_last_digit(ARCS, follower, rpm))
        beside = [
            BallMotion(BallMachine(ARCS, follower, rpm, share), 0.0, CORNER_B)
            for share in (Fraction("5e-17"), Fraction("-5e-17"))
        ]
        for _ in range(25):
            every.step()
            for one in beside:
                one.step()
        for one in beside:
            for wide, sharp in zip(every.trail.impacts, one.trail.impacts, strict=True):
                assert all(a.contains(b) for a, b in zip(wide, sharp, strict=True))
        assert 1e-16 < float(every.phi.rad()) < 1e-9
        balls = BallMotion(BallMachine.within_last_digit(ARCS, follower, rpm), 0.0, CORNER_B)
        for _ in range(25):
            balls.step()
        assert every.phi.rad() < 2 * balls.phi.rad()


def test_no_landing_is_enclosed_of_a_start_that_rounding_may_put_on_another_stretch(monkeypatch):
    """On the top dwell; its start in doubles is off by 20 roundings of a turn, and by its own."""
    monkeypatch.setenv("CAMCLI_KERNEL", "python")
    table = LandingTable(ARCS, Follower(**CHAPTER), 0.0, 190.0)
    dwell = [one for one in cam().stretches if one.dwell][1]
    with precision(60):
        for off, known in ((1.2e-14, False), (2e-14, True)):
            start = arb(dwell.start) + arb(off)
            assert (table.enclosed(start, arb(0.01)) is not None) == known


class Interrupted(Counted):
    """Gives every third step, and those in a row behind the tenth, to the balls."""

    asked = 0

    def _quick_step(self) -> bool:
        self.asked += 1
        if self.asked % 3 == 0 or self.asked in (11, 12, 13):
            self.slow += 1
            return False
        return super()._quick_step()


@pytest.mark.parametrize("rpm", [198.7, 203.0, 345.3])
def test_the_spread_goes_on_where_doubles_leave_a_step_to_the_balls(rpm):
    """All machines of a speed hold each of them, in whichever way a step was made."""
    follower = Follower(**CHAPTER)
    with precision(60):
        every = BallMachine.within_last_digit(ARCS, follower, rpm)
        table = LandingTable(ARCS, follower, 0.0, rpm)
        mixed, balls = Interrupted(every, 0.0, CORNER_B, table), BallMotion(every, 0.0, CORNER_B)
        one = BallMotion(BallMachine(ARCS, follower, rpm, Fraction("5e-17")), 0.0, CORNER_B)
        for _ in range(25):
            for motion in (mixed, balls, one):
                motion.step()
        same_trails(balls, mixed)
        for wide, sharp in zip(mixed.trail.impacts, one.trail.impacts, strict=True):
            assert all(a.contains(b) for a, b in zip(wide, sharp, strict=True))
        assert mixed.phi.rad() < 4 * balls.phi.rad()
    assert min(mixed.quick, mixed.slow) >= 8


@pytest.mark.parametrize("per", [0.0, 1e-300])
def test_a_spread_holds_the_image_of_all_its_points(per):
    """Of a map with errors, below what doubles can hold; `per`: change by a parameter t."""
    with precision(400):
        small = arb(2) ** -1200
        jacobian, error = (1.0, 36.7, -0.2, 5.9), (1e-3, 1e-2, 1e-2, 1e-3)
        spread = StateSpread((per, -0.25 * per), (1.0, 0.0, 0.0, 1.0), (1.0, 0.25), -1200)
        ends = [(x * small, y * small / 4, t) for x in (-1, 1) for y in (-1, 1) for t in (-1, 1)]
        points = [(x + t * arb(per), y - t * arb(0.25 * per), t) for x, y, t in ends]
        rest, off = (small * 9, small * 7), arb(1e-10 * per)
        drift = ((2.0 * per, 1e-10 * per), (per, 1e-10 * per)) if per else ()
        for signs in product((-1, 1), repeat=6):
            true = [arb(j) + n * arb(e) for n, j, e in zip(signs, jacobian, error, strict=False)]
            x_off, y_off = signs[4] * rest[0], signs[5] * rest[1]
            points = [
                (
                    true[0] * x + true[1] * y + t * (arb(2.0 * per) + off) + x_off,
                    true[2] * x + true[3] * y + t * (arb(per) - off) + y_off,
                    t,
                )
                for x, y, t in points
            ]
            spread = spread.image(jacobian, error, (0.3, 0.5), rest, drift)
            frame = arb_mat([spread.frame[:2], spread.frame[2:]])
            scale = arb(2) ** spread.exponent
            for x, y, t in points:
                away = arb_mat([[x - t * arb(spread.lean[0])], [y - t * arb(spread.lean[1])]])
                for e, size in zip((frame.inv() * away).entries(), spread.sizes, strict=True):
                    assert abs(e) <= scale * size
                assert abs(x) <= spread.radii()[0]
                assert abs(y) <= spread.radii()[1]
        assert 0.5 <= max(spread.sizes) < 1.0
        with pytest.raises(UndecidedError):
            spread.image((0.0, 0.0, 0.0, 0.0), error, (0.3, 0.5), rest, drift)


@pytest.mark.parametrize("entry", range(4))
def test_each_error_of_a_map_widens_its_image(entry):
    """Of [[3, 0], [0, 1]] with one entry off by a half, in the unit square."""
    error = [0.5 if k == entry else 0.0 for k in range(4)]
    spread = StateSpread((0.0, 0.0), (1.0, 0.0, 0.0, 1.0), (1.0, 1.0), 0)
    image = spread.image((3.0, 0.0, 0.0, 1.0), tuple(error), (0.0, 1.0), (arb(0), arb(0)), ())
    widths = [float(radius) for radius in image.radii()]
    expected = [3.0 + sum(error[:2]), 1.0 + sum(error[2:])]
    assert widths == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("exponent", [-60, -8, 0, 3])
def test_the_balls_of_a_spread_hold_its_corners_and_hardly_more(exponent):
    """|p| + |Q| sizes 2^exponent about the middle, in both numbers."""
    motion = quick(Follower(**CHAPTER), 358.0)
    middle = arb(2.5), arb(0.75)
    motion.middle = middle
    motion.spread = StateSpread((0.125, -0.5), (0.75, -0.5, 0.25, 1.5), (0.375, 0.0625), exponent)
    motion._back_to_balls()
    scale = 2.0**exponent
    wanted = (
        0.125 + scale * (0.75 * 0.375 + 0.5 * 0.0625),
        0.5 + scale * (0.25 * 0.375 + 1.5 * 0.0625),
    )
    for ball, at, radius in zip(motion.enclosure.hull(), middle, wanted, strict=True):
        assert ball.contains(at - radius)
        assert ball.contains(at + radius)
        assert ball.rad() < 1.000001 * radius
    assert motion.spread is None


@pytest.mark.parametrize("radius", ["0", "1e-40", "1e-17", "3e-4"])
@pytest.mark.parametrize("rate", ["0.7312345678901234567", "1e-9", "33.3333333333333333333"])
def test_doubles_begin_with_all_that_balls_hold(radius, rate):
    """A phase and a rate, rounded to doubles: what rounding took is in the radius, and no more."""
    table = LandingTable(ARCS, Follower(**CHAPTER), 0.0, 358.0)
    with precision(60):
        theta = arb("2.6211245011662321234567") + arb(0, arb(radius))
        speed = arb(rate) * (1 + arb(0, arb(radius)))
        table.enclosed(theta, speed)
        room = [float(x) for x in as_list(table.column)]
        for ball, middle, reach in ((theta, THETA, THETA_RADIUS), (speed, RATE, RATE_RADIUS)):
            assert arb(room[middle], room[reach]).contains(ball)
            size = float(ball.rad()) + abs(float(ball)) * 2.0**-49
            assert room[reach] <= 1.001 * size


def test_a_cam_without_bounds_is_left_to_balls():
    with precision(60):
        motion = quick(Follower(**CHAPTER), 358.0)
        motion.table.known = False
        balls = BallMotion(BallMachine(ARCS, Follower(**CHAPTER), 358.0), 0.0, CORNER_B)
        for _ in range(6):
            motion.step()
            balls.step()
        assert motion.quick == 0
        same_trails(balls, motion)


def test_digits_in_use_shrink_with_what_is_known():
    with precision(200):
        motion = quick(Follower(**CHAPTER), 345.3)
        for _ in range(60):
            motion.step()
        assert 400 < ctx.prec < 690


def exactly_mapped(rows, vector):
    return [sum(Fraction(a) * b for a, b in zip(row, vector, strict=True)) for row in rows]


@pytest.mark.parametrize("thin", [1.0, 1e-9, 1e-17, 1e-25, 0.0])
@pytest.mark.parametrize(
    ("leaning", "drifts"),
    [((0.0, 0.0), False), ((1.0, 1.0), True), ((1.0, 1.0), False), ((1.0, 0.0), False),
     ((0.0, 1.0), False)],
    ids=["one machine", "all machines", "no drift", "phases alone", "rates alone"],
)  # fmt: skip
def test_a_spread_holds_its_image_in_exact_numbers(thin, leaning, drifts):
    """Corners of the box under corners of the map, in fractions: roundings of doubles are covered.

    Of thin boxes what the map makes of the long side is nearly all; a rounding of it is more than
    the thin side, in whose direction the new box must hold it. What leans goes on to lean without a
    drift; the bounds of phase and rate are what box and lean reach together.
    """
    leans = any(leaning)
    random = np.random.default_rng(99)
    for _ in range(2 if leans and not drifts else 6):
        angle, length = random.uniform(0.0, 6.3), 10.0 ** random.uniform(-3.0, 3.0)
        frame = (np.cos(angle), -length * np.sin(angle), np.sin(angle), length * np.cos(angle))
        frame = tuple(map(float, frame))
        jacobian = tuple(map(float, random.normal(size=4) * 10.0 ** random.uniform(-2, 2, 4)))
        error = tuple(abs(x) * random.choice([0.0, 1e-20, 1e-12]) for x in jacobian)
        lean = tuple(float(x) * k for x, k in zip(random.normal(size=2), leaning, strict=True))
        drift = [(float(random.normal()), 1e-19) for _ in range(2)] if drifts else []
        spread = StateSpread(lean, frame, (0.7, 0.7 * thin), -3)
        for k, radius in enumerate(spread.radii()):
            sides = [
                abs(Fraction(x)) * Fraction(size) / 8
                for x, size in zip(frame[2 * k : 2 * k + 2], spread.sizes, strict=True)
            ]
            reach = sum(sides) + abs(Fraction(lean[k]))
            assert reach <= Fraction(float(radius.upper())) <= reach * (1 + Fraction(1, 10**6))
        unit = float(random.normal()), float(-1.0 - random.random())
        image = spread.image(jacobian, error, unit, (arb(0), arb(0)), drift)
        p, q, r, s = map(Fraction, image.frame)
        det = p * s - q * r
        for signs in product((-1, 1), repeat=7 if drifts else 5 if leans else 4):
            e = [Fraction(size) * sign / 8 for size, sign in zip(spread.sizes, signs, strict=False)]
            t = Fraction(signs[-1]) if leans else Fraction(0)
            off = [Fraction(x) * signs[2 + k // 2] for k, x in enumerate(error)]
            rows = [[Fraction(jacobian[2 * k + n]) + off[2 * k + n] for n in (0, 1)]
                    for k in (0, 1)]  # fmt: skip
            start = exactly_mapped((frame[:2], frame[2:]), e)
            start = [x + Fraction(a) * t for x, a in zip(start, lean, strict=True)]
            end = exactly_mapped(rows, start)
            for k, (value, radius) in enumerate(drift):
                end[k] += (Fraction(value) + Fraction(radius) * signs[4 + k]) * t
            end = [x - Fraction(a) * t for x, a in zip(end, image.lean, strict=True)]
            first = (s * end[0] - q * end[1]) / det
            second = (p * end[1] - r * end[0]) / det
            scale = Fraction(2) ** image.exponent
            assert abs(first) <= Fraction(image.sizes[0]) * scale
            assert abs(second) <= Fraction(image.sizes[1]) * scale


def test_what_a_product_leaves_out_covers_every_state_of_the_spread():
    """By sampling the corners, for frames with entries of either sign."""
    error = (0.25, 0.5, 0.125, 1.0)
    for signs in product((1.0, -1.0), repeat=4):
        frame = tuple(s * x for s, x in zip(signs, (0.75, 0.5, 0.25, 2.0), strict=True))
        spread = StateSpread((0.0, 0.0), frame, (0.5, 0.75), 0)
        left_out = spread._left_out((0.0,) * 4, error, (0.0,) * 4)
        for x, y in product((-0.5, 0.5), (-0.75, 0.75)):
            state = abs(frame[0] * x + frame[1] * y), abs(frame[2] * x + frame[3] * y)
            assert left_out[0] >= error[0] * state[0] + error[1] * state[1]
            assert left_out[1] >= error[2] * state[0] + error[3] * state[1]


@pytest.mark.parametrize(
    ("digits", "steps"),
    [(40, "c"), (60, "c"), (100, "n"), (200, "ncc"), (240, "ncc"), (420, "nnc")],
)
def test_a_landing_is_solved_to_half_of_the_bits_before_it_is_enclosed(monkeypatch, digits, steps):
    """By chords and Newton's steps, of as few bits as they may have, and no more than are needed.

    A double has 45 bits of the landing and some 40 of the slope there. A step of Newton's method
    makes three times the bits and those 45 of them, and gives twice of them to the slope: 170 and
    130, then 540 and 380; a chord adds those of the slope and costs a third of a step. The last
    step of all, which encloses the landing, adds half of the slope's bits more.
    """
    left = []
    done: list[tuple[str, int]] = []
    solve, at, gap_at = QuickMotion._near_landing, QuickMotion._at, QuickMotion._gap_at

    def counted(kind, function):
        def evaluated(*args):
            done.append((kind, ctx.prec))
            return function(*args)

        return evaluated

    def solved(self, landing, stretch, theta):
        with monkeypatch.context() as patch:
            done.clear()
            patch.setattr(QuickMotion, "_at", counted("n", at))
            patch.setattr(QuickMotion, "_gap_at", counted("c", gap_at))
            x = solve(self, landing, stretch, theta)
        assert "".join(kind for kind, _ in done) == steps
        bits = [bits for _, bits in done]
        assert bits == sorted(bits)
        assert bits[-1] <= ctx.prec // 2 + 6
        (gap, slope, _), _ = self._at(x, stretch, theta)
        left.append(abs(gap / slope) * arb(2) ** (ctx.prec // 2))
        return x

    monkeypatch.setattr(QuickMotion, "_near_landing", solved)
    with precision(digits):
        motion = quick(Follower(**CHAPTER), 745.0)
        for _ in range(12):
            motion.step()
    assert len(left) >= 10
    assert max(float(x.upper()) for x in left) < 64.0  # six bits less


@pytest.mark.parametrize("damping", [0.0, 5.0])
@pytest.mark.parametrize("preload", [0.0, 20.0])
def test_gap_and_slopes_of_a_flight_are_derivatives_of_one_another(damping, preload):
    """By differences over 1e-15 rad, in a free oscillation about a level and with a damper."""
    follower = Follower(**{**CHAPTER, "damping": damping, "preload": preload})
    with precision(60):
        motion = quick(follower, 300.0)
        motion._fly_from(arb("0.7"), arb("0.1"))
        stretch = motion.machine.stretches[0]
        s, h, theta = arb("0.3"), arb("1e-15"), arb("0.2")
        before, at, behind = (motion._at(s + x, stretch, theta)[0] for x in (-h, arb(0), h))
        assert at[0].overlaps(motion._gap_at(s, stretch, theta))
        for k in (0, 1):
            slope = (behind[k] - before[k]) / (2 * h)
            assert abs(slope - at[k + 1]) < 1e-25
