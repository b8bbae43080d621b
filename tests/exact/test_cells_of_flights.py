"""Flights between small cells of the cam, and the boxes that hold one orbit at most.

Prover and checker each have a `PhaseCover`; both are held here against the
closed form of a damped flight between two points of the example's cam, in plain doubles.
"""

from collections import Counter
from fractions import Fraction
from itertools import product
from math import cos, exp, pi, radians, sin, sqrt
from random import Random
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb, arb_mat

from camcli import check
from camcli.api.machine import machine_of
from camcli.cams.balls import precision
from camcli.cams.decimals import exact
from camcli.cams.formula import formula_of
from camcli.exact.machine import BallMachine
from camcli.exact.phase_cover import ImpactEquations, Impossible, Key, PhaseCover, Unknown
from camcli.scene import load_scene
from tests.support.all_orbits_oracle import lift

RPM = 700.0
LOADS = {"follower.damping": 20.0, "follower.preload": 30.0, "follower.gravity": 9.81}
DEPTH = 12  # cells of less than 0.03 deg


@pytest.fixture(scope="module")
def covers():
    """(follower, cover of the prover, cover of the checker) of the example with all loads."""
    system = machine_of(load_scene(None, {**LOADS, "run.rpm": RPM})).system
    known = {**vars(system.follower), "rpm": RPM}
    constants = {key: Fraction(exact(known[key])) for key in check.CONSTANTS}
    with precision(check.BITS):
        checker = check.PhaseCover(
            check.Machine(check.cam_of(formula_of(system.shape), ""), constants)
        )
        prover = PhaseCover(BallMachine(system.shape, system.follower, RPM))
        yield system.follower, prover, checker


def rates(follower, start: float, landing: float) -> tuple[float, float]:
    """(out, into) in m/rad of the flight from the cam at one phase to it at another, rad.

    m q'' + b q' + k q = -(m g + F0): about its rest the height is exp(-z s)(u cos f s + (v + z u)
    sin(f s)/f) after s rad, from the height u and the rate v.
    """
    omega = RPM * pi / 30.0
    m, k, b = follower.mass, follower.stiffness, follower.damping
    rest = -(m * follower.gravity + follower.preload) / k
    z = b / (2.0 * m) / omega
    f = sqrt(k / m - (b / (2.0 * m)) ** 2) / omega
    s = landing - start
    (c,), (c1,) = lift(np.array([start]))
    (d,), (d1,) = lift(np.array([landing]))
    u, end = c - rest, d - rest
    both = (end * exp(z * s) - u * cos(f * s)) * f / sin(f * s)  # v + z u
    v = both - z * u
    falls = exp(-z * s) * (both * cos(f * s) - u * f * sin(f * s)) - z * end
    return float(v - c1), float(falls - d1)


def cell_at(edges, phase: float, turn: int, depth: int = DEPTH):
    """The key of the small cell that holds a phase of a turn."""
    k = next(k for k, (_, end) in enumerate(edges) if phase < end)
    low, high = edges[k]
    return Key(k + turn * len(edges), depth, int((phase - low) / (high - low) * 2**depth))


@pytest.mark.parametrize(("start", "landing", "turns"), [
    (104.0, 104.0, 1), (155.0, 151.0, 1), (152.0, 95.0, 1), (154.0, 157.0, 1),
])  # fmt: skip
def test_the_slopes_of_a_flight_are_the_derivatives_of_its_rates(covers, start, landing, turns):
    follower, prover, checker = covers
    edges = [(float(one.start), float(one.end)) for one in prover.machine.stretches]
    keys = cell_at(edges, radians(start), 0), cell_at(edges, radians(landing), turns)
    a, b = (float(prover.cell(key).middle.phase) for key in keys)
    step = 1e-5
    wanted = [
        (rates(follower, a + da, b + db)[k] - rates(follower, a - da, b - db)[k]) / (2.0 * step)
        for k, (da, db) in product((0, 1), ((step, 0.0), (0.0, step)))
    ]
    detail, other = prover.between(*keys).detail, checker.known(*keys)
    for slopes, middle in ((detail.slopes, detail.middle),
                           (other.slopes, other.middle)):  # fmt: skip
        for ball, value in zip(slopes, wanted, strict=True):
            assert ball.overlaps(arb(value, 1e-7 * (1.0 + abs(value))))
            assert ball.rad() < 0.01 * (1.0 + abs(value))
        for ball, value in zip(middle, rates(follower, a, b), strict=True):
            assert abs(ball - value) < 1e-12


def path(follower, start: float, landing: float, shares) -> np.ndarray:
    """The gap (m) of the flight of `rates` at shares of its way."""
    omega = RPM * pi / 30.0
    m, k, b = follower.mass, follower.stiffness, follower.damping
    rest = -(m * follower.gravity + follower.preload) / k
    z = b / (2.0 * m) / omega
    f = sqrt(k / m - (b / (2.0 * m)) ** 2) / omega
    out, _ = rates(follower, start, landing)
    (c, *_), (c1, *_) = lift(np.array([start, landing]))
    s = (landing - start) * np.asarray(shares)
    u, v = c - rest, out + c1
    height = rest + np.exp(-z * s) * (u * np.cos(f * s) + (v + z * u) * np.sin(f * s) / f)
    return height - lift(start + s)[0]


PARTS_LOOKED_AT = np.arange(1, 8) / 8.0  # of a flight between cells
NEAR = 1e-3  # m/rad, or rad: nothing is asked of flights so near a limit; of the gap, m, 1e-4


@pytest.mark.parametrize("depth", [4, DEPTH])
def test_cells_have_the_flights_that_lead_between_them(covers, depth):
    """Flights of points of both cells: inside the bounds, and none where the cells have none.

    Left out are flights that are too fast for an orbit. Where cells are small, there are none as
    soon as one pulls, or is below the cam at one of the places of its way that are looked at.
    """
    follower, prover, checker = covers
    random = Random(depth)
    edges = [(float(one.start), float(one.end)) for one in prover.machine.stretches]
    corners = np.array([start for start, _ in edges])
    seen = Counter()
    for _ in range(70):
        start = random.uniform(0.0, 2.0 * pi)
        s = random.choice((random.uniform(0.0, 0.6), random.uniform(0.0, float(prover.longest))))
        turn, phase = divmod(start + s, 2.0 * pi)
        keys = cell_at(edges, start, 0, depth), cell_at(edges, phase, int(turn), depth)
        a, b = (prover.cell(key) for key in keys)
        ours, other = prover.between(*keys), checker.known(*keys)
        for share in (-0.9, 0.0, 0.9):
            one = float(a.x.mid() + share * a.h.rad())
            there = float(b.x.mid() - share * b.h.rad())
            big, _, p = prover.machine.flow(arb(max(there - one, NEAR)))
            too_fast = prover.machine.W2 * p > 1 and big < 1.01 * prover.least
            if there - one < NEAR or there - one > float(prover.longest) - NEAR or too_fast:
                continue
            out, into = rates(follower, one, there)
            in_turn = (one + (there - one) * PARTS_LOOKED_AT) % (2.0 * pi)
            clear = abs(in_turn[:, None] - corners).min(axis=1) > NEAR
            lowest = path(follower, one, there, PARTS_LOOKED_AT[clear]).min(initial=1.0)
            is_flight = out > 0.0 > into and lowest > 0.0
            is_clear = min(abs(out), abs(into)) > NEAR and abs(lowest) > NEAR / 10.0
            for found, none in ((ours, ours is Impossible), (other, other is None)):
                if not none and getattr(found, "out", None) is not None:
                    assert found.out.overlaps(arb(out, 1e-12))
                    assert found.into.overlaps(arb(into, 1e-12))
                if is_flight:
                    dense = path(follower, one, there, np.linspace(0.0, 1.0, 200)[1:-1])
                    assert not (none and dense.min() > 0.0)
                elif is_clear and depth == DEPTH:
                    assert none
            seen[is_flight, ours is Impossible] += 1
    assert min(seen[True, False], seen[False, True]) > 20


@pytest.mark.parametrize(("start", "landing", "turns"), [
    (104.0, 104.0, 1), (155.0, 151.0, 1), (152.0, 95.0, 1),
])  # fmt: skip
@pytest.mark.parametrize("part", [1, 4, 7])
def test_flights_are_below_the_cam_where_the_highest_of_them_is(
    covers, start, landing, turns, part, monkeypatch
):
    """The cam is put just below, and just above, the highest of four flights at one place.

    The four lead from an end of the first cell to an end of the other. In so small cells no flight
    is higher than they are, but for second orders.
    """
    follower, prover, checker = covers
    edges = [(float(one.start), float(one.end)) for one in prover.machine.stretches]
    keys = cell_at(edges, radians(start), 0, 9), cell_at(edges, radians(landing), turns, 9)
    a, b = (prover.cell(key) for key in keys)
    (at, to), (by_start, by_landing) = (
        [float(x) for x in both] for both in
        ((a.middle.phase, b.middle.phase), (a.h.rad(), b.h.rad()))
    )  # fmt: skip
    phase = at + (to - at) * part / 8.0
    heights = []
    for x, y in product((-by_start, by_start), (-by_landing, by_landing)):
        share = (phase - at - x) / (to + y - at - x)
        gap = path(follower, at + x, to + y, [share])[0]
        heights.append(gap + lift(np.array([phase]))[0][0])
    spread = max(heights) - min(heights)
    for above in (-0.02, 0.02):
        level = arb(max(heights) + above * spread)

        def cam(theta, level=level):
            return level if abs(theta - phase) < 1e-9 else arb(-1e9)

        monkeypatch.setattr(prover, "_lift", cam)
        monkeypatch.setattr(checker, "lift", cam)
        assert (prover.flight(a, b) is Impossible) is (above > 0)
        assert (checker.flight(*map(checker.cell, keys)) is None) is (above > 0)


@pytest.mark.parametrize(("start", "landing", "leaves"), [
    (146.7, 443.7, False), (153.0, 421.0, False), (205.6, 254.4, False),
    (280.0, 577.0, True), (339.0, 570.0, True), (63.0, 162.9, True),
])  # fmt: skip
def test_no_flight_starts_downwards_or_lands_upwards(covers, start, landing, leaves):
    """Though it is above the cam at every place of its way that is looked at."""
    follower, *both = covers
    edges = [(float(one.start), float(one.end)) for one in both[0].machine.stretches]
    at, to = radians(start), radians(landing)
    out, into = rates(follower, at, to)
    assert (out > 0.0, into > 0.0) == (leaves, leaves)
    assert path(follower, at, to, PARTS_LOOKED_AT).min() > NEAR
    turn, phase = divmod(to, 2.0 * pi)
    keys = cell_at(edges, at, 0), cell_at(edges, phase, int(turn))
    prover, checker = both
    assert prover.between(*keys) is Impossible
    assert checker.known(*keys) is None


# Derivatives D of the equations E in a box. There is one zero at most if |inverse of D's middle
# times D, less one| < 1, row by row: so no two points of the box have the same E.
def balls(*rows):
    return arb_mat([[x if isinstance(x, arb) else arb(x) for x in row] for row in rows])


ALONE = [
    (balls([arb(1, 0.99)]), True),
    (balls([arb(1, 1.01)]), False),
    (balls([arb(-2, 1.9)]), True),
    (balls([arb(1, 0.3), arb(0, 0.65)], [arb(0), arb(1)]), True),
    (balls([arb(1, 0.5), arb(0, 0.6)], [arb(0), arb(1)]), False),  # each is below 1, not their sum
    (balls([arb(1), arb(0)], [arb(0, 0.6), arb(1, 0.5)]), False),  # the last row counts too
    (balls([1, 1], [1, 1]), False),  # no inverse
    (None, False),  # nothing is known of a flight
]


@pytest.mark.parametrize(("slopes", "one_at_most"), ALONE)
def test_a_box_holds_one_orbit_at_most_only_where_its_slopes_say_so(
    covers, monkeypatch, slopes, one_at_most
):
    _, prover, checker = covers
    n = 1 if slopes is None else slopes.nrows()
    keys = [Key(1, 3, k) for k in range(n)]
    phases = [prover.cell(key).in_turn.mid() for key in keys]
    flight = SimpleNamespace(slopes=None if slopes is None else ())
    monkeypatch.setattr(PhaseCover, "flight", lambda *cells: Unknown)
    monkeypatch.setattr(
        PhaseCover,
        "newton",
        lambda *asked: None if slopes is None else ImpactEquations(arb_mat(n, 1), slopes),
    )
    monkeypatch.setattr(check.PhaseCover, "flight", lambda *cells: flight)
    monkeypatch.setattr(check.PhaseCover, "newton", lambda *asked: (None, slopes))
    assert prover.alone(keys, 1, phases) is one_at_most
    orbit = [(key[0], phase) for key, phase in zip(keys, phases, strict=True)]
    assert checker.alone(keys, 1, orbit) is one_at_most
    assert not checker.alone(keys, 1, [(2, phase) for phase in phases]), "another stretch"


def test_the_lift_is_that_of_the_phase_in_its_turn_and_unknown_beside_a_corner(covers):
    """Where the ball of a phase may lie on either side of one."""
    _, _, checker = covers
    for phase in (0.3, 1.9, 2.7, 3.2, 4.0, 6.2):
        for turn in (-1, 0, 3):
            c = checker.lift(arb(phase) + 2 * arb.pi() * turn)
            assert c.overlaps(arb(float(lift(np.array([phase]))[0][0]), 1e-14))
    for corner in [one.start for one in checker.stretches[1:]]:
        for turn in (0, 2):
            assert checker.lift(corner + 2 * arb.pi() * turn) is None
            assert checker.lift(corner + 2 * arb.pi() * turn + arb("1e-12")) is not None


@pytest.mark.parametrize("depths", [(2, 2), (2, 7), (7, 2)])
@pytest.mark.parametrize("at", list(product((-1.01, -0.99, 0.0, 0.99, 1.01), repeat=2)))
def test_cells_of_any_size_are_empty_only_where_the_zero_lies_beside_one_of_them(
    covers, monkeypatch, depths, at
):
    """E is what the phases are off their cells' middles, less `at` times the cells' half widths."""
    _, prover, checker = covers
    edges = [(float(one.start), float(one.end)) for one in prover.machine.stretches]
    phases = zip((0.5, 3.9), depths, strict=True)
    keys = [cell_at(edges, phase, 0, depth) for phase, depth in phases]
    values = arb_mat(
        [[-part * prover.cell(key).h.rad()] for part, key in zip(at, keys, strict=True)]
    )
    slopes = balls([1, 0], [0, 1])
    flight = SimpleNamespace(out=None, into=None, slopes=())
    monkeypatch.setattr(PhaseCover, "between", lambda *asked: Unknown)
    monkeypatch.setattr(PhaseCover, "newton", lambda *asked: ImpactEquations(values, slopes))
    monkeypatch.setattr(check.PhaseCover, "known", lambda *asked: flight)
    monkeypatch.setattr(check.PhaseCover, "newton", lambda *asked: (values, slopes))
    outside = max(map(abs, at)) > 1.0
    assert (prover.excluded(keys, 1) is not None) == outside
    assert checker.empty(keys, 1) == outside


@pytest.mark.parametrize(("restitution", "preload"), [(0.8, 40.0), (0.3, 5.0), (0.95, 400.0)])
def test_how_long_a_flight_may_be_and_how_small_b(restitution, preload):
    """On c = (1 - cos)/50 its height above the spring's rest goes from G/W2 to 0.04 m more.

    The steepest slope is 0.02; bounds of the cells are wider, so that both are on the safe side.
    """
    values = {"mass": 2.0, "stiffness": 300.0, "preload": preload, "restitution": restitution}
    cam = {"kind": "eccentric", "base": 0.0, "lift": 0.04}
    system = machine_of(load_scene({"follower": values, "cam": cam})).system
    w2 = 300.0 / 2.0 / (RPM * pi / 30.0) ** 2
    low = preload / 300.0
    fastest = 2.0 * 0.02 + sqrt(w2 * ((low + 0.04) ** 2 - low**2))
    least = low / (fastest * restitution / (1.0 - restitution) + 0.02)
    known = {**vars(system.follower), "rpm": RPM}
    constants = {key: Fraction(exact(known[key])) for key in check.CONSTANTS}
    with precision(check.BITS):
        shape = formula_of(system.shape)
        checker = check.PhaseCover(check.Machine(check.cam_of(shape, ""), constants))
        prover = PhaseCover(BallMachine(system.shape, system.follower, RPM))
        for cover in (prover, checker):
            assert cover.longest.overlaps(arb(pi / sqrt(w2), 1e-12))
            assert 0.999 * least < float(cover.least) <= least


def test_nothing_is_said_of_flights_that_may_last_for_no_time_or_for_a_whole_swing(covers):
    """B = exp(-Z s) sin(f s)/f is not above zero on the whole ball of their lengths s."""
    _, prover, checker = covers
    n, unclear = len(checker.stretches), 0
    for i, more in product(range(n), range(n + 1)):
        a, b = Key(i, 0, 0), Key(i + more, 0, 0)
        s = checker.cell(b).x - checker.cell(a).x
        if s > 0 and not s >= checker.longest and not checker.machine.flow(s)[0] > 0:
            unclear += 1
            assert checker.known(a, b) == check.CellFlight()
            assert prover.between(a, b) is Unknown
    assert unclear == 5


def accelerations(follower, start: float, landing: float) -> np.ndarray:
    """Second derivatives of the gap (m/rad^2) at places of the flight of `path`, by differences."""
    step = 0.02
    shares = np.linspace(0.05, 0.95, 3)
    low, at, high = (path(follower, start, landing, shares + away) for away in (-step, 0.0, step))
    return (low - 2.0 * at + high) / (step * (landing - start)) ** 2


@pytest.mark.parametrize(("depth", "most"), [(1, 3.3), (2, 3.3), (5, 1.9)])
def test_short_flights_are_bounded_by_their_acceleration_and_not_by_much_more(covers, depth, most):
    """The rates are s/2 times means of the gap's second derivative, of which the ball has them all.

    A ball is at most so many times as wide as what samples of both cells span, from no flight at
    all to the longest; where there are none, no flight from cell to cell is above the cam.
    """
    follower, prover, checker = covers
    parts, n = 2**depth, len(prover.machine.stretches)
    seen = Counter()
    last = parts - 1
    pairs = {(0, 0, 0), (0, 0, min(1, last)), (last, 0, last), (0, 0, last), (last, 1, 0),
             (last, 1, parts // 2), (last, 1, last), (0, 1, 0)}  # fmt: skip
    for stretch, (part, more, landing) in product(range(n), sorted(pairs)):
        keys = Key(stretch, depth, part), Key(stretch + more, depth, landing)
        a, b = (prover.cell(key) for key in keys)
        s = b.x - a.x
        ours = Unknown if s <= 0 else prover._short(a, b, s)
        one, two = (checker.cell(key) for key in keys)
        theirs = checker.short(one, two, two.x - one.x)
        if ours is Unknown:
            assert s.upper() > 0.6 or s <= 0
            continue
        ends = [np.linspace(float(x.lower()), float(x.upper()), 3) for x in (a.x, b.x)]
        flights = [pair for pair in product(*ends) if pair[1] - pair[0] > NEAR]
        of_flights = [rates(follower, *pair) for pair in flights]
        bends = np.concatenate([accelerations(follower, *pair) for pair in flights])
        seen[ours is Impossible, more] += 1
        if ours is Impossible:
            assert theirs is None
            assert max(out for out, _ in of_flights) < 0.0 < min(bends)
            continue
        halves = [max(0.0, ends[1][0] - ends[0][-1]) / 2.0, (ends[1][-1] - ends[0][0]) / 2.0]
        spans = [half * bend for half in halves for bend in (bends.min(), bends.max())]
        span = (max(spans) - min(spans)) / 2.0
        on_a_dwell = keys[0] == keys[1] and stretch in (0, 3, 6)
        widest = 1.3 if on_a_dwell else most  # there the lift, and all but the load, is one number
        if depth == 5 and not a.x.overlaps(b.x):
            widest = np.inf  # a flight may end just behind a corner, of which samples know nothing
        for found in (ours, theirs):
            for out, into in of_flights:
                assert found.out.overlaps(arb(out, 1e-9))
                assert found.into.overlaps(arb(into, 1e-9))
            assert 0.9 * span < float(found.out.rad()) < widest * span
            assert 0.9 * span < float(found.into.rad()) < widest * span
    assert min(seen[False, 0], seen[False, 1], seen[True, 0]) >= 3


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("crosses", [False, True])
def test_the_acceleration_of_short_flights_is_that_on_all_of_their_way(covers, order, crosses):
    """The slope, or the curvature, is 500 times the phase: at each phase of both cells and between.

    The cells go from 1 to 1.05 rad and from 1.2 to 1.25, and a stretch may end at 1.1. What holds
    with the value at any of these phases everywhere is held, and hardly more than all of it.
    """
    _, prover, checker = covers

    def bounds(derivative):
        def derivatives(theta, most):
            return [derivative(theta) if k == order else arb(0) for k in range(most + 1)]

        stretch = SimpleNamespace(start=arb("1.1"), end=arb("1.1"), derivatives=derivatives)
        low, high = arb(1).union(arb("1.05")), arb("1.2").union(arb("1.25"))
        a, b = (
            SimpleNamespace(index=k and int(crosses), stretch=stretch, in_turn=x, x=x, c=arb("0.1"))
            for k, x in enumerate((low, high))
        )
        s = b.x - a.x
        return prover._short(a, b, s), checker.short(a, b, s)

    wide = bounds(lambda theta: 500 * theta)
    at_phases = [bounds(lambda theta, at=at: arb(500 * at)) for at in (1.0, 1.1, 1.2, 1.25)]
    for which, found in enumerate(wide):
        for name in ("out", "into"):
            ball = getattr(found, name)
            parts = [getattr(one[which], name) for one in at_phases]
            assert all(ball.contains(part) for part in parts)
            hull = parts[0].union(parts[-1])
            assert ball.rad() < 1.12 * hull.rad()
