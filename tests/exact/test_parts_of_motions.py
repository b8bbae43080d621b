"""Parts of the motion after a rest in balls, on numbers chosen by hand; its quick steps as well."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import inf, pi
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_mat, arb_series, ctx

from camcli.cams.balls import UndecidedError
from camcli.exact import quick_motion
from camcli.exact.machine import BallMachine, BallStretch, Place
from camcli.exact.motion import BallMotion, EndlessError, Parallelogram, Trail
from camcli.exact.quick_motion import QuickMotion, StateSpread
from camcli.system import Follower

TURN = 2.0 * pi


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 200
    yield
    ctx.prec = before


def column(*rows) -> arb_mat:
    return arb_mat([[arb(x)] for x in rows])


def matrix(*rows) -> arb_mat:
    return arb_mat([[arb(x) for x in row] for row in rows])


# -- parallelograms


def test_a_parallelogram_about_two_balls_holds_them_and_no_more():
    one = Parallelogram.around(arb(3, 0.25), arb(-5, 0.5))
    x, y = one.hull()
    assert x.mid() == 3
    assert y.mid() == -5
    assert abs(arb(x.rad()) - 0.25) < 1e-6
    assert abs(arb(y.rad()) - 0.5) < 1e-6
    assert one.lean == column(0, 0)
    assert one.frame == matrix((1, 0), (0, 1))


def test_the_hull_of_a_parallelogram_is_all_that_its_parts_reach_together():
    one = Parallelogram(column(1, 2), column(0.125, -0.25), matrix((1, 2), (-3, 4)),
                        column(arb(0, 0.5), arb(0, 0.0625)))  # fmt: skip
    x, y = one.hull()
    assert abs(arb(x.rad()) - (0.125 + 0.5 + 0.125)) < 1e-6
    assert abs(arb(y.rad()) - (0.25 + 1.5 + 0.25)) < 1e-6
    assert (x.mid(), y.mid()) == (1, 2)


@pytest.mark.parametrize("sizes", [(0.5, 0.03125), (0.03125, 0.5)])
@pytest.mark.parametrize("wide", ["jacobian", "drift", "middle"])
def test_the_image_of_a_parallelogram_holds_the_image_of_its_corners(sizes, wide):
    """F(x, t) = F(m) + J (x - m) + d t with J and d in balls; the longer side keeps its direction.

    The frame is orthonormal in numbers over the unit ((1, 0), (2, -4)).
    """
    one = Parallelogram(column(1, 2), column(0.125, -0.25), matrix((1, 2), (-3, 4)),
                        column(arb(0, sizes[0]), arb(0, sizes[1])))  # fmt: skip
    of_jacobian = 1e-6 if wide == "jacobian" else 0.0
    of_drift, of_rest = (2.0 if wide == one else 0.0 for one in ("drift", "middle"))
    jacobian = matrix((2, arb(1, of_jacobian)), (arb(-1, of_jacobian), 3))
    drift = column(arb(0.5, of_drift), -1)
    of_middle = column(arb(7, of_rest), 9)
    unit = matrix((1, 0), (2, -4))
    image = one.image(of_middle, jacobian, drift, unit)
    assert image.middle == column(7, 9)
    lean = (2 * 0.125 - 0.25 + 0.5, -0.125 - 0.75 - 1.0)
    assert all(abs(x - y) < 1e-5 for x, y in zip(image.lean.entries(), lean, strict=True))
    for signs in product((-1, 1), repeat=3):
        e = column(signs[0] * sizes[0], signs[1] * sizes[1])
        start = one.lean * signs[2] + one.frame * e
        for side in (-0.99, 0.99):
            turned = side * of_jacobian
            true = matrix((2, 1 + turned), (-1 - turned, 3))
            end = true * start + column(0.5 + side * of_drift, -1) * signs[2]
            end += column(side * of_rest, 0)
            away = image.frame.inv() * (end - image.lean * signs[2])
            for x, ball in zip(away.entries(), image.error.entries(), strict=True):
                assert ball.contains(x.mid())
    scaled = (unit.inv() * image.frame).entries()
    a, b, c, d = scaled
    assert abs(a * a + c * c - 1) < 1e-9
    assert abs(a * b + c * d) < 1e-9
    sides = (jacobian * one.frame).mid()
    longer = 0 if sizes[0] > sizes[1] else 1
    x, y = (unit.inv() * column(sides[0, longer], sides[1, longer])).mid().entries()
    assert abs(x * c - y * a) < 1e-9
    with pytest.raises(UndecidedError):
        one.image(of_middle, matrix((arb(0, 9), arb(0, 9)), (arb(0, 9), arb(0, 9))), drift, unit)


# -- turns, symbols and strobes


def motion(**values) -> BallMotion:
    """A motion of which no more is known than these values."""
    one = object.__new__(BallMotion)
    one.turn = 2 * arb.pi()
    one.strobe = arb(-1)
    one.trail = Trail()
    for name, value in values.items():
        setattr(one, name, value)
    return one


def test_turns_are_counted_from_the_last_strobe_before_the_start():
    one = motion(strobe=arb(1) - 2 * arb.pi())
    assert [one.turn_of(arb(x)) for x in (0.9, 1.1, 1.0 + TURN - 0.1, 1.1 + TURN)] == [0, 1, 1, 2]
    with pytest.raises(UndecidedError):
        one.turn_of(arb(1, 0.1))
    assert one.phase(arb(1.5)) == pytest.approx(1.5)
    assert one.phase(arb(1.5 + 3.0 * TURN)) == pytest.approx(1.5)
    assert one.phase(arb(-0.5)) == pytest.approx(TURN - 0.5)
    one.trail.states = [("q", "w")] * 2
    assert float(one._next_strobe()) == pytest.approx(1.0 + 2.0 * TURN)


def test_the_symbol_of_a_turn_that_goes_on_as_another_one_did():
    """Three impacts so far, and those of the turn of phi behind it; or a chatter ends there."""
    hits = [(arb(x), arb(-1)) for x in (0.5, 2.0, 3.0, 3.0, 7.0)]
    one = motion(impacts=3, chattered=False)
    one.trail.impacts = hits
    assert one.symbol_of_turn(arb(1.5)) == 3 + 3  # at 2 and 3, of which one is there twice
    assert one.symbol_of_turn(arb(2.0)) == 3 + 3
    assert one.symbol_of_turn(arb(2.5)) == 3 + 2
    assert one.symbol_of_turn(arb(4.0)) == 3
    assert one.symbol_of_turn(arb(6.0)) == 3 + 1
    one.trail.chatters = [arb(4.5)]
    assert one.symbol_of_turn(arb(4.0)) == inf
    assert one.symbol_of_turn(arb(4.75)) == 3
    assert one.symbol_of_turn(arb(6.0)) == 3 + 1
    one.chattered = True
    assert one.symbol_of_turn(arb(6.0)) == inf


def stretch(start, end, *polynomial) -> BallStretch:
    """A stretch whose lift is a polynomial by the angle of the turn."""

    def lift(x):
        total = arb(0) * x
        for a in reversed(polynomial):
            total = total * x + arb(a)
        return total

    return BallStretch(arb(start), arb(end), lift, None)


def test_states_are_noted_at_every_strobe_up_to_an_angle():
    """In flight by the motion from here, at rest by the cam: at a corner by what begins there."""
    rows = [stretch(0, 2, 5, 1), stretch(2, 4, 3, 2), stretch(4, TURN, 0, 0)]
    moved = []
    machine = Made(
        stretches=rows, move=lambda q, w, s: moved.append((q, w, float(s))) or ["q", "w", "a"]
    )
    one = motion(machine=machine, resting=False, section=arb(2), strobe=arb(2) - 2 * arb.pi(),
                 q="q0", w="w0", phi=arb(1), impacts=4, chattered=False)  # fmt: skip
    one._strobes(arb(1.5))
    assert one.trail.states == []
    one._strobes(arb(2.5 + TURN))
    assert one.trail.states == [("q", "w")] * 2
    assert [(q, w) for q, w, _ in moved] == [("q0", "w0")] * 2
    assert [s for *_, s in moved] == pytest.approx([1.0, 1.0 + TURN])
    assert one.trail.symbols == [4.0, 0.0]
    assert (one.impacts, one.chattered) == (0, False)
    one.resting, one.chattered, one.impacts = True, True, 9
    one._strobes(arb(2.5 + 2.0 * TURN))
    q, w = one.trail.states[2]
    assert (q, w) == (7, 2)  # of the second stretch, 3 + 2 theta
    assert one.trail.symbols[2] == inf
    assert (one.impacts, one.chattered) == (0, False)


def test_an_impact_is_counted_and_noted():
    one = motion(impacts=2, phi=arb(3))
    one._struck(arb(-0.5))
    assert one.impacts == 3
    assert one.trail.impacts == [(arb(3), arb(-0.5))]


# -- from rest


def resting(forces, stretches=None, **more):
    """A follower that rests at 1 rad, on the first of three stretches; what its departure is.

    forces: of each stretch, from an angle to [N, N', N''].
    """
    rows = stretches or [stretch(0, 2, 5), stretch(2, 4, 5), stretch(4, TURN, 5)]
    calls = []
    machine = Made(stretches=rows, restitution=lambda k: arb(0.5) if k == 1 else arb(0),
                   force=lambda c: c)  # fmt: skip
    one = motion(machine=machine, phi=arb(1), place=Place(0, 0), bits=200, strobe=arb(0))
    real = BallMotion._cam.__get__(one)
    one._cam = lambda phi, place, order=2: (
        forces(place)(phi) if order == 4 else real(phi, place, order)
    )
    for name in ("_depart", "_strobes", "_struck"):
        setattr(one, name, lambda *given, name=name: calls.append((name, *given)))
    for name, value in more.items():
        setattr(one, name, value)
    try:
        one._leave()
    except EndlessError:
        calls.append(("endless",))
    return one, calls


def line(value, slope, middle):
    return lambda phi: [value + slope * (phi - middle), arb(slope), arb(0)]


def test_a_follower_lifts_off_where_the_force_falls_through_zero():
    one, ((name, phi, rate, order),) = resting(
        lambda place: line(1.0, -1.0, 1.75) if place.stretch == 1 else line(1.0, 0.0, 0.0)
    )
    assert (name, rate, order) == ("_depart", 0, 3)
    assert phi.contains(2.75)
    assert one.place == Place(1, 0)


def test_a_follower_leaves_at_a_corner_where_it_is_pressed_no_more():
    one, ((name, phi, rate, order),) = resting(
        lambda place: line(-1.0 if place.stretch == 2 else 1.0, 0.0, 0.0)
    )
    assert (name, rate, order) == ("_depart", 0, 2)
    assert phi == 4
    assert one.place == Place(2, 0)


def test_a_follower_that_is_pressed_rests_for_good():
    one, calls = resting(lambda place: line(1.0, 0.0, 0.0))
    assert calls == [("endless",)]
    assert 1.0 + TURN + 1.0 <= float(one.phi) < 1.0 + TURN + 4.0


@pytest.mark.parametrize(
    ("slopes", "expected"),
    [
        ((0, -0.25), [("_depart", 2, 0.25, 1)]),  # the cam falls away
        ((0, 0.25), [("_depart", 2, 0.125, 1), ("_struck", -0.25)]),  # it strikes, with r = 1/2
    ],
)
def test_a_follower_leaves_where_the_slope_of_the_cam_jumps(slopes, expected):
    rows = [stretch(0, 2, 5, slopes[0]), stretch(2, 4, 5 - 2 * slopes[1], slopes[1]),
            stretch(4, TURN, 5, 0)]  # fmt: skip
    one, calls = resting(lambda place: line(1.0, 0.0, 0.0), rows)
    assert [(name, *map(float, numbers)) for name, *numbers in calls] == expected
    assert one.place == Place(1, 0)


def test_a_blow_without_restitution_is_an_impact_and_the_rest_goes_on():
    """From the second stretch to the third, where r is zero; then the slope jumps back."""
    rows = [stretch(0, 2, 5), stretch(2, 4, 5), stretch(4, TURN, 1, 1)]
    one, calls = resting(lambda place: line(1.0, 0.0, 0.0), rows)
    assert [(name, *map(float, numbers)) for name, *numbers in calls][:2] == [
        ("_strobes", 4.0), ("_struck", -1.0),
    ]  # fmt: skip
    # at the end of the turn the cam falls away
    name, phi, rate, order = calls[2]
    assert (name, rate, order) == ("_depart", 1, 1)
    assert float(phi) == pytest.approx(TURN)
    assert one.place == Place(0, 1)


def test_a_departure_begins_a_flight_and_is_noted(monkeypatch):
    calls = []
    one = motion(resting=True)
    one._strobes = lambda phi: calls.append((float(phi), one.resting))
    one._begin_flight = lambda enclosure, order: calls.append((enclosure.hull(), order))
    one._depart(arb(3), arb(0.5), 1)
    assert calls == [(3.0, True), ((arb(3), arb(0.5)), 1)]
    assert one.trail.leaves == [3]
    assert one.resting is False


# -- chatter


def chattering(rate=0.01, r=0.5, fall=1.0, end=3.0, strobe=5.0, spread=0.0, w2=0.0):
    """Whether hops over a level cam at 1 rad end; of G the ball is so wide."""
    machine = Made(G=arb(fall, spread), W2=arb(w2), Z=arb(0), restitution=lambda k: arb(r),
                   stretches=[stretch(0, end, 0)])  # fmt: skip
    one = motion(machine=machine, phi=arb(1), rate=arb(rate), fall=arb(fall, spread),
                 place=Place(0, 0), strobe=arb(strobe) - 2 * arb.pi(), chattered=False)  # fmt: skip
    return one, one._accumulates()


def test_hops_that_shrink_end_where_all_of_them_have_their_length():
    """Of the rate v, r and the fall a they last 2 v/(a (1 - r)) together."""
    for r in (0.5, 0.25):
        one, ends = chattering(r=r)
        assert ends
        assert one.chattered
        (place,) = one.trail.chatters
        assert abs(place - (1.0 + 0.02 / (1.0 - r))) < 1e-12
        assert place.rad() < 1e-6
        assert float(one.phi) == pytest.approx(1.0 + 0.02 / (1.0 - r))


@pytest.mark.parametrize(
    ("given", "ends"),
    [
        ({}, True), ({"r": 1.0}, False),
        ({"end": 1.061}, True), ({"end": 1.059}, False),  # its reach is 3 v/(a (1 - r)) = 0.06
        ({"strobe": 1.061}, True), ({"strobe": 1.059}, False),
        ({"spread": 0.1}, True), ({"spread": 0.25}, True), ({"spread": 0.3}, False),
        ({"spread": 1.5}, False),
        ({"r": 0.9}, True), ({"r": 0.9, "spread": 0.3}, False),
    ],
)  # fmt: skip
def test_hops_end_where_it_is_certain_that_they_do(given, ends):
    one, said = chattering(**given)
    assert said is ends
    assert one.chattered is ends
    assert len(one.trail.chatters) == ends
    assert (float(one.phi) > 1.0) is ends


def test_hops_of_a_range_of_falls_end_between_the_shortest_and_the_longest_ones():
    """With a from 0.9 to 1.1 and r = 1/2, k = sqrt(11/9): 2 v/A/(1 - r/k) and 2 v/a/(1 - r k)."""
    one, _ = chattering(spread=0.1)
    (place,) = one.trail.chatters
    k = (11.0 / 9.0) ** 0.5
    shortest, longest = 0.02 / 1.1 / (1.0 - 0.5 / k), 0.02 / 0.9 / (1.0 - 0.5 * k)
    assert float(place.lower()) == pytest.approx(1.0 + shortest, rel=1e-6)
    assert float(place.upper()) == pytest.approx(1.0 + longest, rel=1e-6)
    assert float(one.phi) == pytest.approx(1.0 + longest, rel=1e-6)


# -- flights


def flying(rate=0.25, fall=1.0, order=1, end=3.0, gap=None):
    machine = Made(stretches=[stretch(0, end, 0)])
    return motion(machine=machine, phi=arb(0), rate=arb(rate), fall=arb(fall), order=order,
                  place=Place(0, 0), _gap=lambda place, order: gap)  # fmt: skip


def test_where_a_flight_is_looked_at_first():
    """A hop that is concave for 2.5 times v/a, so to say; else where the gap rises at first."""
    hop = lambda s: [0.25 * s - s * s / 2, 0.25 - s, arb(-1), arb(0)]  # noqa: E731
    assert [x and float(x) for x in flying(gap=hop)._opening()] == [0.0, 0.625]
    # a stretch that ends before: the gap rises for less than 0.25 rad
    low, cut = flying(gap=hop, end=0.5)._opening()
    assert cut is None
    assert 0.125 <= float(low) < 0.25
    # bent upwards: the gap rises from there on
    rises = lambda s: [s + s * s, 1 + 2 * s, arb(2), arb(0)]  # noqa: E731
    low, cut = flying(gap=rises)._opening()
    assert cut is None
    assert float(low) == pytest.approx(0.625)
    for order in (2, 3):
        lifts = lambda s: [s, s, 0.75 - s, 0.375 - s]  # noqa: E731
        low, cut = flying(gap=lifts, order=order)._opening()
        assert cut is None
        bound = {2: 0.75, 3: 0.375}[order]
        assert 0.4 * bound < float(low) < bound
    never = lambda s: [arb(0), arb(-1), arb(1), arb(0)]  # noqa: E731
    with pytest.raises(UndecidedError):
        flying(gap=never)._opening()


def test_the_next_contact_is_looked_for_stretch_by_stretch():
    """Over steps of the cam at 2 and 4 rad, from 1 rad on: it lands on the third one."""
    rows = [stretch(0, 2, 0), stretch(2, 4, 0), stretch(4, TURN, 0)]
    gaps = {0: lambda s: arb(1) + s, 1: lambda s: arb(2) + 0 * s, 2: lambda s: 4 - s}
    asked = []
    one = motion(machine=Made(stretches=rows), phi=arb(1), place=Place(0, 0), rate=arb(1))
    one._opening = lambda: (arb(0.5), None)
    one._clear = lambda s, place: (
        asked.append((place, float(s.lower()), float(s.upper()))) or (place.stretch == 1)
    )
    one._gap = lambda place: lambda s: [gaps[place.stretch](s), arb(-1), arb(0)]
    s, place = one._contact()
    assert s.contains(4)
    assert place == Place(2, 0)
    assert [row[0] for row in asked] == [Place(0, 0), Place(1, 0), Place(2, 0)]
    ends = [x for _, *x in asked]
    assert ends == [pytest.approx(x, abs=1e-6) for x in ([0.5, 1], [1, 3], [3, TURN - 1])]
    gaps[2] = lambda s: 2 - s  # below the cam as the stretch begins
    with pytest.raises(UndecidedError):
        one._contact()


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_a_landing_moves_with_its_start_as_the_closed_form_does(damping):
    """(phi, rate) after the impact by those before, by differences; over a cam that is bent."""
    follower = Follower(2.0, 700.0, damping, 9.81, 3.0, 0.75)
    machine = BallMachine([stretch(0, TURN, 0.001, -0.002, 0.003)], follower, 300.0)

    def started(phi, rate):
        one = motion(machine=machine, phi=phi, rate=rate, place=Place(0, 0))
        c = one._cam(phi, one.place)
        one.q, one.w = c[0], c[1] + rate
        one.fall = machine.G + machine.W2 * one.q + 2 * machine.Z * one.w + c[2]
        one.enclosure = Parallelogram.around(phi, rate)
        return one

    def landed(phi, rate, near=None):
        one = started(phi, rate)
        gap = one._gap(one.place, order=3)
        s = near
        for _ in range(12):
            value, slope = gap(s)[:2]
            s = (s - value / slope).mid()
        return s, gap(s)

    phi, rate = arb(1), arb(0.05)
    one = started(phi, rate)
    gap = one._gap(one.place, order=3)
    near = next(arb(k) / 16 for k in range(2, 60) if gap(arb(k) / 16)[0] < 0)
    s, values = landed(phi, rate, near)
    one._contact = lambda: (s, Place(0, 0))
    found = one._landing()
    assert found.place == Place(0, 0)
    assert found.s.contains(s)
    assert found.s.rad() < 1e-10
    for x, y in zip(found.slopes, values[1:], strict=True):
        assert x.overlaps(y)
    assert found.unit[1, 0].overlaps(values[2].mid() + arb(0, 1e-9))
    assert (found.unit[0, 0], found.unit[0, 1]) == (1, 0)
    h = arb(2) ** -60
    for j in (0, 1):
        ends = []
        for side in (-1, 1):
            a, b = phi + side * h * (j == 0), rate + side * h * (j == 1)
            flown, at = landed(a, b, s)
            ends.append((a + flown, -machine.r * at[1]))
        for i in (0, 1):
            slope = (ends[1][i] - ends[0][i]) / (2 * h)
            assert abs(slope - found.jacobian[i, j]) < 1e-8 * (1 + abs(slope))
    assert found.drift == column(0, 0)


# -- quick steps


def quick(**values) -> QuickMotion:
    one = object.__new__(QuickMotion)
    for name, value in values.items():
        setattr(one, name, value)
    return one


def test_the_stretch_of_a_phase_is_known_where_it_is_not_near_an_end():
    one = quick(starts_of_stretches=[0.0, 1.0, 3.0], ends_of_stretches=[1.0, 3.0, TURN])
    asked = [(0.5, 0.1), (0.05, 0.1), (0.95, 0.1), (1.05, 0.1), (2.0, 0.1), (2.95, 0.1), (3.2, 0.1),
             (TURN - 0.05, 0.1), (TURN - 0.2, 0.1), (1.0, 0.0)]  # fmt: skip
    assert [one._stretch(*x) for x in asked] == [0, -1, -1, -1, 1, -1, 2, -1, 2, -1]


def test_a_double_and_its_error_hold_a_ball():
    for x in (arb(0.75), arb(1) / 3, arb(-2, 0.125), arb("1e-30", "1e-40")):
        middle, error = quick_motion._double_and_error(x)
        assert arb(middle, error).contains(x)
        assert error <= 1.001 * float(x.rad()) + abs(middle) * 2.0**-49


@pytest.mark.parametrize("size", ["1", "3", "0.75", "1e-40", "1e30"])
def test_the_exponent_of_a_size(size):
    exponent = quick_motion._exponent(arb(size))
    assert 0.5 <= float(arb(size) / arb(2) ** exponent) < 1.0
    assert quick_motion._exponent(arb(0)) == -200


def test_a_step_of_newtons_method_with_derivatives_leaves_the_fourth_power():
    """Of g + u d + a d^2/2 + j d^3/6 with u = -2, a = 3 and j = 5."""
    left = []
    for k in (8, 9):
        g = arb(2) ** -k
        d = quick_motion._newton([g, arb(-2), arb(3)], 5.0)
        left.append(abs(g - 2 * d + 3 * d * d / 2 + 5 * d * d * d / 6))
    ratio = float(left[0] / left[1])
    assert 14.0 < ratio < 18.0


def test_bits_are_lost_and_no_more_are_used_than_are_known():
    one = quick(phi=arb(1, 2.0**-90), rate=arb(1, 2.0**-70), lost=5, bits=150)
    one._count_bits()
    assert 150 - 92 < one.lost < 150 - 88
    assert ctx.prec == 150
    one.phi, one.rate = arb(1, 2.0**-60), arb(1, 2.0**-65)
    one._count_bits()
    most = one.lost
    assert 150 - 67 < most < 150 - 63
    assert ctx.prec == 150 - most + 64
    one.phi = arb(1, 2.0**-110)
    one._count_bits()
    assert one.lost == most
    assert ctx.prec == 150


def test_a_free_oscillation_is_told_by_its_level_its_rate_and_its_distance():
    """q'' + W^2 q + G = 0 from (q, w): at s = 0 they are its own, and its level is -G/W^2."""
    center = Made(undamped=True, sprung=True, near_critical=False, G=arb(3), W2=arb(4),
                  frequency=arb(2))  # fmt: skip
    one = quick(machine=Made(center=center))
    one._fly_from(arb(5), arb(6))
    assert one.q_and_w == (5, 6)
    assert tuple(one.swing) == (arb(-0.75), arb(3), arb(5.75))
    for name in ("undamped", "sprung"):
        setattr(center, name, False)
        one._fly_from(arb(5), arb(6))
        assert one.swing is None
        setattr(center, name, True)
    center.near_critical = True
    one._fly_from(arb(5), arb(6))
    assert one.swing is None


def landing(**values) -> Made:
    given = {"angle": 0.5, "angle_radius": 1e-12, "u": -2.0, "u_radius": 1e-12, "accel": 3.0,
             "accel_radius": 1e-12, "phase": 1.5, "jacobian": (1.0, 2.0, 3.0, 4.0),
             "jacobian_error": (0.0, 0.0, 0.0, 0.0), "wraps": 1, "sliver": 1e-9}  # fmt: skip
    return Made(**{**given, **values})


def test_the_speeds_of_machines_spread_a_landing():
    """dq = 8 and dw = 10 after the flight: it lands 8/2 later, and 10 + 3 4 faster, times r."""
    asked = []
    machine = Made(drift=lambda q, w, s: asked.append((q, w, s)) or column(8, 10))
    one = quick(machine=machine, q="q", w="w", state_computed=True)
    (phase, phase_error), (rate, rate_error) = one._drift(landing(), arb(0.5))
    assert phase == pytest.approx(4.0, abs=phase_error)
    assert rate == pytest.approx(-0.5 * (10.0 + 12.0), abs=rate_error)
    assert max(phase_error, rate_error) < 1e-9
    (q, w, s) = asked[0]
    assert (q, w) == ("q", "w")
    assert s.contains(0.5)


@pytest.mark.parametrize(
    ("given", "may"),
    [
        ({}, True), ({"rate": 0.24}, True), ({"rate": 0.27}, False),
        ({"end": 1.6}, False), ({"strobe": 5.1}, False), ({"r": 1.0}, False),
        ({"r": 0.9}, False), ({"damping": 0.5, "rate": 0.35}, True),
    ],
)  # fmt: skip
def test_when_hops_may_end_in_the_stretch_and_the_turn(given, may):
    """With the fall 1, r = 1/2 and 1.5 rad to the end: 3 v/(a (1 - r)) is as much at v = 1/4."""
    known = {"rate": 0.2, "end": 3.0, "strobe": 9.0, "r": 0.5, "damping": 0.0, **given}
    one = quick(
        machine=Made(restitution=lambda k: arb(known["r"])), place=Place(0, 0),
        damping=known["damping"], ends_of_stretches=[known["end"]], phi=arb(5),
        rate=arb(known["rate"]),
    )  # fmt: skip
    at = landing(u=-1.0, accel=-1.0, phase=1.5)
    assert one._may_accumulate(at, known["strobe"]) is may


class Spread:
    """A spread whose image is told."""

    def __init__(self, told):
        self.told = told

    def image(self, jacobian, error, *, unit, rest, drift):
        self.told.append((jacobian, error, unit, rest, drift))
        return self

    def radii(self):
        return arb(0.125), arb(0.25)


def stepped(monkeypatch, **changes):
    """A quick step whose parts are given: the motion behind it, and what was asked."""
    told: list = []
    given = {"landed": Made(angle=arb(0.5, 1e-20), rate=arb(-4, 1e-18), c=arb(7), c1=arb(0.75)),
             "r": 0.5, "landing": landing(), "width": 0.0, "stretch": 2, "may": False,
             "fall": 1.0, "strobe": 99.0}  # fmt: skip
    given |= changes
    machine = Made(restitution=lambda k: told.append(("r", k)) or arb(given["r"]),
                   width=given["width"])  # fmt: skip
    one = quick(machine=machine, table=Made(enclosed=lambda *x: given["landing"]),
                phi=arb(8), rate=arb(9), turn=2 * arb.pi(), place=Place(1, 1),
                spread=Spread(told), middle=(arb(8), arb(9)), state_computed=True,
                fall=arb(given["fall"]), resting=False, lost=0, bits=200, trail=Trail(),
                impacts=0)  # fmt: skip
    one._stretch = lambda *x: given["stretch"]
    one._landed = lambda landing, place: told.append(("landed", place)) or given["landed"]
    one._drift = lambda landing, r: "drift"
    one._next_strobe = lambda: arb(given["strobe"])
    for name in ("_compute_state", "_count_bits", "_leave"):
        setattr(one, name, lambda name=name: told.append((name,)))
    one._strobes = lambda phi: told.append(("strobes", phi))
    one._fly_from = lambda q, w: told.append(("fly", q, w))
    one._may_accumulate = lambda landing, strobe: told.append(("may", strobe)) or given["may"]
    one._accumulates = lambda: True
    return one, one._quick_step(), told


def test_a_quick_step_goes_on_from_the_landing_of_its_middle(monkeypatch):
    """With the rest of both numbers of the middle, whose balls are 1e-20 and r 1e-18 wide."""
    one, done, told = stepped(monkeypatch)
    assert done
    (image,) = [row for row in told if row[0] == (1.0, 2.0, 3.0, 4.0)]
    assert image[2] == (3.0, -2.0)
    rests = [float(x) for x in image[3]]
    assert rests == pytest.approx([1e-20, 0.5e-18], rel=1e-6, abs=0.0)
    assert image[4] == ()
    assert one.place == Place(2, 2)
    assert ("landed", Place(2, 2)) in told
    assert ("fly", 7, arb(0.75) + 2) in told
    assert one.middle == (8.5, 2)
    assert one.phi.mid() == 8.5
    assert abs(arb(one.phi.rad()) - 0.125) < 1e-6
    assert one.rate.mid() == 2
    assert abs(arb(one.rate.rad()) - 0.25) < 1e-6
    assert one.state_computed is False
    ((phi, u),) = one.trail.impacts
    assert phi.mid() == 8.5
    assert u.mid() == -4
    assert ("may", 99.0) in told
    assert ("r", 2) in told
    assert not one.resting
    _, _, told = stepped(monkeypatch, width=1.0)
    assert [row[4] for row in told if row[0] == (1.0, 2.0, 3.0, 4.0)] == ["drift"]


@pytest.mark.parametrize(
    "changes", [{"landing": None}, {"stretch": -1}, {"r": 0.0}, {"landed": None}]
)
def test_a_step_that_is_not_quick_changes_nothing(monkeypatch, changes):
    one, done, told = stepped(monkeypatch, **changes)
    assert not done
    assert one.place == Place(1, 1)
    assert one.middle == (8, 9)
    assert (one.phi, one.rate, one.state_computed) == (8, 9, True)
    assert not one.trail.impacts
    assert not [row for row in told if row[0] in ("strobes", "fly", "may")]


@pytest.mark.parametrize(("strobe", "passes"), [(8.7, False), (8.6, True), (8.3, True)])
def test_a_quick_step_notes_the_strobes_that_it_may_pass(monkeypatch, strobe, passes):
    """It lands between 8.375 and 8.625; the state is computed before it is another one."""
    _, _, told = stepped(monkeypatch, strobe=strobe)
    names = [row[0] for row in told]
    assert ("strobes" in names) is passes
    if passes:
        assert names.index("_compute_state") < names.index("strobes") < names.index("fly")
        phi = next(row[1] for row in told if row[0] == "strobes")
        assert phi.mid() == 8.5


@pytest.mark.parametrize(
    ("may", "fall", "rests"),
    [(True, 1.0, True), (True, -1.0, False), (True, arb(0, 1), False), (False, 1.0, False)],
)
def test_a_quick_step_ends_in_a_rest_where_hops_accumulate(monkeypatch, may, fall, rests):
    one, done, told = stepped(monkeypatch, may=may, fall=fall)
    assert done
    assert one.resting is rests
    assert (("_leave",) in told) is rests


def test_a_step_is_quick_where_the_gap_rises_at_once_and_doubles_enclose_it(monkeypatch):
    calls = []
    monkeypatch.setattr(BallMotion, "step", lambda self: calls.append("balls"))
    balls = ["back", "balls"]
    for order, quick_enough, expected in (
        (1, True, ["quick"]), (1, False, ["quick", *balls]), (2, True, balls),
    ):  # fmt: skip
        one = quick(order=order)
        one._quick_step = lambda said=quick_enough: calls.append("quick") or said
        one._back_to_balls = lambda: calls.append("back")
        calls.clear()
        one.step()
        assert calls == expected


def test_the_state_of_the_start_is_computed_once():
    """-gap'' = G + W2 q + 2 Z w + c'' with the ball of the start over the cam."""
    machine = Made(G=arb(2), W2=arb(3), Z=arb(0.5), stretches=[stretch(0, TURN, 1, 2, 4)])
    one = quick(machine=machine, phi=arb(0.5) + 2 * arb.pi(), rate=arb(0.25), place=Place(0, 1),
                turn=2 * arb.pi(), state_computed=False)  # fmt: skip
    one._compute_state()
    assert abs(one.q - (1 + 1 + 1)) < 1e-30
    assert abs(one.w - (2 + 4 + 0.25)) < 1e-30
    assert abs(one.fall - (2 + 9 + 6.25 + 8)) < 1e-30
    assert one.state_computed
    one.q = "kept"
    one._compute_state()
    assert one.q == "kept"


# -- the machine


def test_places_follow_one_another_through_the_turns():
    places = [Place(0, 4)]
    for _ in range(4):
        places.append(places[-1].next(3))
    assert places == [Place(0, 4), Place(1, 4), Place(2, 4), Place(0, 5), Place(1, 5)]


def test_the_force_of_contact_and_its_derivatives():
    """N = G + W^2 c + 2 Z c' + c'', of which the cam alone changes."""
    machine = BallMachine([], Follower(2.0, 8.0, 4.0, 3.0, 6.0, 0.5, seat_restitution=0.25),
                          Fraction(30) / 1)  # fmt: skip
    omega2 = arb.pi() ** 2
    c = [arb(x) for x in (2, 3, 5, 7, 11)]
    z2 = 2 / arb.pi()
    wanted = [
        (3 + 3) / omega2 + 4 / omega2 * 2 + z2 * 3 + 5, 4 / omega2 * 3 + z2 * 5 + 7,
        4 / omega2 * 5 + z2 * 7 + 11,
    ]  # fmt: skip
    assert all(abs(x - y) < 1e-40 for x, y in zip(machine.force(c), wanted, strict=True))
    machine.stretches = [Made(seat=True), Made(seat=False)]
    assert [float(machine.restitution(k)) for k in (0, 1)] == [0.25, 0.5]
    q, w, s = arb(2), arb(3), arb(0.5)
    short, long = machine.move(q, w, s, 2), machine.move(q, w, s)
    assert len(short) == 3
    height, rate, acceleration, jerk = long
    assert abs(acceleration + (6 + 4 * height) / omega2 + z2 * rate) < 1e-40
    assert abs(jerk + 4 / omega2 * rate + z2 * acceleration) < 1e-40


def test_series_are_told_apart_from_balls_in_a_stretch():
    """A level stretch has no derivatives, and slopes that are known go before a lift."""
    level = BallStretch(arb(0), arb(1), None, arb(3))
    assert level.derivatives(arb(0.5), 2) == [3, 0, 0]
    known = BallStretch(arb(0), arb(1), lambda x: x * x * x, None,
                        slopes=lambda x: [arb(9), arb(8), arb(7), arb(6)])  # fmt: skip
    assert known.derivatives(arb(2), 0) == [8]
    assert known.derivatives(arb(2), 1) == [9, 8]
    assert known.derivatives(arb(2), 3) == [9, 8, 7, 6]
    assert [float(x) for x in known.derivatives(arb(2), 4)] == [8.0, 12.0, 12.0, 6.0, 0.0]
    varies = BallStretch(arb(0), arb(1), lambda x: x * x * arb_series([5, 7], 2), None, varies=True)
    found = varies.derivatives(arb(3), 2)
    assert [[float(x[0]), float(x[1])] for x in found] == [[45, 63], [30, 42], [10, 14]]


# -- spreads of a quick motion


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [((1.0, 0.25), 0), ((1.0, 0.5), 1), ((0.25, 1.0), 1), ((0.75, 0.25), 0), ((0.5, 0.25), 1)],
)
def test_the_longer_side_of_an_image_keeps_its_direction(sizes, kept):
    """The sides are (1, 0) and (1.8, 2.4), three times as long: rate = 2 x + 0.5 y."""
    accel, u = 2.0, 0.5
    image = (1.0, 1.8, accel, accel * 1.8 + u * 2.4)
    spread = StateSpread((0.0, 0.0), (1.0, 0.0, 0.0, 1.0), sizes, 0)
    x, y = ((1.0, 0.0), (0.6, 0.8))[kept]
    wanted = (x, -y, accel * x + u * y, u * x - accel * y)
    assert spread._frame(image, accel, u) == pytest.approx(wanted, abs=1e-15)


def test_an_image_without_sides_has_no_frame():
    spread = StateSpread((0.0, 0.0), (1.0, 0.0, 0.0, 1.0), (1.0, 1.0), 0)
    with pytest.raises(UndecidedError):
        spread._frame((0.0, 0.0, 0.0, 0.0), 2.0, 0.5)
