"""Parts of a step of the kernel as plain Python, on cams and flights made by hand."""

from __future__ import annotations

from math import cos, exp, factorial, sin, sqrt
from types import SimpleNamespace as Made

import numpy as np
import pytest
from mpmath import mp

from camcli.kernel import cam_table, contact_search, flight, orbit_loop, sticking
from camcli.kernel import loads as loads_module
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.contact_search import CLEAR, DIPS, LANDED, LOST, NEARLY, UNKNOWN, Tally
from camcli.kernel.flight import BOUNCED, FREE, RELEASED
from camcli.kernel.flow import move
from camcli.kernel.loads import Loads
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT, RESTING, State
from tests.support.kernel_runs import system

CONST = Made(G=3.0, W2=4.0, W=2.0, Z=0.25, D=0.0625 - 4.0)
LEVEL = (0.5, -0.25, 0.75)  # c, c_theta and c_thetatheta


def flight_of(**values) -> contact_search.Flight:
    given = dict.fromkeys(contact_search.Flight._fields, 0.0)
    return contact_search.Flight(**{**given, **values})


def test_a_flight_has_the_derivatives_of_its_equation():
    """q'' = -G - W^2 q - 2 Z q' and q''' by the same equation, from the gap and its rate."""
    f = contact_search.flight_over(
        Made(stretches=[None, Made(end=5.0)]), CONST, 1, 2.0, 0.125, 0.375, *LEVEL
    )
    q, w = 0.625, 0.125
    q2 = -3.0 - 4.0 * q - 0.5 * w
    q3 = -4.0 * w - 0.5 * q2
    assert f == (2.0, 0.125, 0.375, q, w, 3.0 + 4.0 * q, q2, q3, 0.75, abs(q3) + 2.0 * abs(q2), 3.0)


# -- the search

ROUNDING = 2.0**-40  # of the sum of a phase and the way to the end, so to say


def searched(monkeypatch, verdicts, *, end=1.0, z=0.25, w=2.0, gap_end=0.5, theta=0.5):
    """What a search says whose steps are decided so; and the steps that were tried, in rad."""
    tried: list = []
    said = iter(verdicts)
    stretch = Made(start=0.0, end=theta + end + ROUNDING)
    const = Made(W=w, Z=z)
    f = flight_of(theta=theta, gap=0.25, rate=-0.5, q2=-7.0, c2=2.0, end=end)
    monkeypatch.setattr(contact_search, "gap_at", lambda cam, const, i, f, s, work: (
        gap_end, -0.75, 9.0))  # fmt: skip
    monkeypatch.setattr(contact_search, "lift_at", lambda cam, i, theta: (0.0, 0.0, 1.5))
    monkeypatch.setattr(contact_search, "_across", lambda *given: (gap_end, -0.875, 11.0))
    monkeypatch.setattr(contact_search, "accel_bounds", lambda cam, const, i, f, s, q2: (
        tried.append((s, q2)) or (-1.0, 1.0)))  # fmt: skip
    monkeypatch.setattr(contact_search, "decide", lambda *given: tried.append(given) or next(said))
    monkeypatch.setattr(contact_search, "guess", lambda *given: ("guess", *given))
    monkeypatch.setattr(contact_search, "land", lambda cam, const, i, f, s, first, work: (
        "land", s, first))  # fmt: skip
    monkeypatch.setattr(contact_search, "dip", lambda cam, const, i, f, s, stop, *more: (
        "dip", s, stop, *more[:2]))  # fmt: skip
    answer = contact_search.search(Made(stretches=[stretch]), const, "flows", 0, f, Tally())
    return answer, [row[0] for row in tried if len(row) == 2], tried


def test_a_step_is_cut_until_it_is_decided(monkeypatch):
    answer, steps, tried = searched(monkeypatch, [UNKNOWN, UNKNOWN, CLEAR], w=1.0)
    assert steps == [1.0, 0.5, 0.25]
    assert answer == (CLEAR, 0.75, 0.5, -0.75)
    assert tried[0][1] == 9.0 + 1.5  # q'' at the end, of the gap's and the cam's
    assert tried[1] == (0.25, -0.5, 0.5, -0.75, -1.0, 1.0, 1.0)
    answer, steps, _ = searched(monkeypatch, [CLEAR], w=1.0)
    assert answer == (CLEAR, 1.5 + ROUNDING, 0.5, -0.75)  # the end of the stretch itself
    answer, steps, _ = searched(monkeypatch, [CLEAR], w=1.0, gap_end=-1e-18)
    assert answer == (CLEAR, 1.5 + ROUNDING, 0.0, -0.75)
    _, steps, _ = searched(monkeypatch, [CLEAR], w=3.0)
    assert steps == [0.5]  # W s is at most 1.5
    _, steps, _ = searched(monkeypatch, [UNKNOWN] * 3 + [CLEAR], w=1.0, z=32.0)
    assert steps == [1.0, 0.125, 0.0625, 0.03125]  # an eighth where Z s is 8 or more
    answer, steps, tried = searched(monkeypatch, [CLEAR], w=1.0, theta=0.0)
    assert answer == (CLEAR, 1.0 + ROUNDING, 0.5, -0.875)  # from end to end by the table
    assert tried[0] == (1.0, 11.0)
    answer, steps, _ = searched(monkeypatch, [UNKNOWN, CLEAR], w=1.0, theta=0.0)
    assert answer == (CLEAR, 0.5, 0.5, -0.75)
    answer, steps, _ = searched(monkeypatch, [UNKNOWN] * 80, w=1.0)
    assert answer == (LOST, 0.5, 0.25, -0.5)
    assert 40 < len(steps) <= 60


def test_a_step_that_lands_or_dips_is_followed_there(monkeypatch):
    answer, _, _ = searched(monkeypatch, [UNKNOWN, LANDED], w=1.0)
    assert answer == ("land", 0.5, ("guess", 0.25, -0.5, -9.0, 0.5, 0.5, -0.75))
    answer, _, _ = searched(monkeypatch, [UNKNOWN, DIPS], w=1.0)
    assert answer == ("dip", 0.5, 1.0, 0.5, -0.75)
    answer, _, _ = searched(monkeypatch, [DIPS], w=1.0)
    assert answer == ("dip", 1.0, 1.5 + ROUNDING, 0.5, -0.75)


def test_the_bounds_of_an_acceleration_take_what_is_sharper():
    """The chord of q'' within its slack, or its size; the curvature of the cam, or its drift."""
    stretch = Made(jerk_max=2.0, accel_min=-1.0, accel_max=1.0)
    made = Made(stretches=[stretch])
    f = flight_of(q2=-5.0, w=0.5, c2=0.5, energy=8.0)
    s = 0.125
    slack = (0.5 + 2.0) * 8.0 * s * s / 8.0
    low, high = contact_search.accel_bounds(made, CONST, 0, f, s, -4.0)
    assert low == pytest.approx(-5.0 - slack - (0.5 + 0.25))
    assert high == pytest.approx(-4.0 + slack - (0.5 - 0.25))
    low, high = contact_search.accel_bounds(made, CONST, 0, f, s, -6.0)
    assert low == pytest.approx(max(-6.0 - slack, -(5.0 + 2.0 * 0.5)) - 0.75)
    wide = contact_search.accel_bounds(made, CONST, 0, f._replace(energy=1e9), 1.0, -4.0)
    assert wide == pytest.approx((-6.0 - 1.0, 6.0 + 1.0))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((1.0, 0.0, -0.5, -1.0, -2.0, -1.0, 1.0), LANDED),  # concave, and below at the end
        ((1.0, 0.0, 0.5, -1.0, -2.0, 0.0, 1.0), CLEAR),
        ((1.0, -2.0, -0.5, -1.0, 0.0, 1.0, 1.0), LANDED),  # convex, and falls from the start
        ((1.0, -2.0, -0.5, -1.0, 0.0, 3.0, 1.0), LANDED),
        ((1.0, -2.0, -0.5, -1.0, -1.0, 1.5, 1.0), LANDED),  # falls all along
        ((1.0, -0.5, 0.5, -0.5, 0.0, 1.0, 1.0), CLEAR),  # a line
        ((1.0, -1.0, -0.5, -1.0, -1.0, 1.5, 1.0), UNKNOWN),
        ((1.0, 0.5, -0.5, -1.0, -1.0, 1.5, 1.0), UNKNOWN),
        ((1.0, 0.5, 2.0, 1.5, 0.0, 1.0, 1.0), CLEAR),  # convex, and rises from the start
        ((1.0, -1.5, 0.1, -0.5, 0.0, 1.0, 1.0), CLEAR),  # falls up to the end
        ((1.0, -1.0, 1.0, 1.0, 0.0, 4.0, 1.0), CLEAR),  # its tangents meet at 1/2 above 1/2
        ((1.0, -3.0, 1.0, 3.0, 0.0, 9.0, 1.0), DIPS),  # below zero
        ((1.0, -0.25, 0.5, 0.0, -1.0, 3.0, 1.0), CLEAR),  # above the parabola 1 - s/4 - s^2/2
        ((1.0, -0.5, 0.5, 0.0, -1.0, 3.0, 1.0), CLEAR),  # above the chord less 3/8
        ((1.0, -0.5, 0.5, 0.0, -1.0, 4.0, 1.0), UNKNOWN),
        ((0.25, -0.5, 1.0, 0.0, -1.0, 3.0, 1.0), UNKNOWN),
    ],
)
def test_what_a_step_is_decided_to_be(given, said):
    assert contact_search.decide(*given) == said


@pytest.mark.parametrize(
    ("gap", "rate", "accel"),
    [(0.5, 1.0, -4.0), (0.5, -1.0, -4.0), (0.0, 1.0, -4.0), (0.5, -2.0, 1.0), (0.5, -2.0, 3.5)],
)
def test_a_landing_is_guessed_where_a_parabola_is_zero(gap, rate, accel):
    roots = np.roots([accel / 2.0, rate, gap])
    first = min(root for root in roots.real if root > 1e-12)
    assert contact_search.guess(gap, rate, accel, 5.0, -1.0, -2.0) == pytest.approx(first)


def test_a_landing_is_guessed_by_the_tangent_at_the_end_where_no_parabola_tells():
    """It has no zero, or one beyond the step; without a fall at the end it is the middle."""
    for start in ((0.5, -1.0, 4.0), (0.5, 1.0, 4.0), (9.0, 1.0, -1.0)):
        assert contact_search.guess(*start, 2.0, -0.25, -0.5) == 2.0 - 0.5
        assert contact_search.guess(*start, 2.0, -0.25, 0.0) == 1.0


def with_gap(monkeypatch, gap):
    """The kernel's gap is a polynomial of the rad of flight, lowest power first."""
    one = np.polynomial.Polynomial(gap)
    asked: list = []
    monkeypatch.setattr(contact_search, "gap_at", lambda cam, const, i, f, s, work: (
        asked.append(s) or tuple(float(one.deriv(k)(s)) if k else float(one(s)) for k in range(3))
    ))  # fmt: skip
    return asked


@pytest.mark.parametrize(
    ("gap", "rate", "lands"),
    [((0.99, -2.0, 1.0), -2.0, 0.9), ((1.01, -2.0, 1.0), -2.0, None),
     ((1.0, -3.0, 2.25), -3.0, 2.0 / 3.0), ((0.5, -0.125), -0.125, None),
     ((1.0, 0.0, 1.0), 0.0, None)],
)  # fmt: skip
def test_a_dip_is_followed_from_the_left_to_a_contact_or_past_its_minimum(
    monkeypatch, gap, rate, lands
):
    """(s - 1)^2 less and more 1/100; one that touches; a line that ends before its zero."""
    with_gap(monkeypatch, gap)
    f = flight_of(theta=3.0, gap=gap[0], rate=rate)
    code, theta, at, u = contact_search.dip(None, None, 0, f, 2.0, 5.0, 0.75, 0.625, None)
    if lands is None:
        assert (code, theta, at, u) == (CLEAR, 5.0, 0.75, 0.625)
    else:
        assert (code, at) == (LANDED, 0.0)
        assert theta == pytest.approx(3.0 + lands, abs=1e-6)
        assert u == pytest.approx(-0.2 if lands == 0.9 else 0.0, abs=1e-6)


@pytest.mark.parametrize("near", [True, False])
@pytest.mark.parametrize("first", [0.5, 1.9, 7.0, -1.0])
def test_a_landing_is_solved_in_its_bracket(monkeypatch, near, first):
    """(1 - s)(1 + s^2 + s/2): it falls through zero at 1 rad with the rate -2.5."""
    with_gap(monkeypatch, (1.0, -0.5, 0.5, -1.0))
    monkeypatch.setattr(contact_search, "is_near", lambda const, s: near)
    monkeypatch.setattr(contact_search, "lift_at", lambda cam, i, theta: (0.0, 0.0, 0.0))
    monkeypatch.setattr(contact_search, "derivative", lambda cam, order, i, theta: 6.0)
    made = Made(stretches=[Made(end=9.0, jerk_max=6.0)])
    const = Made(Z=0.0, W2=0.0)
    f = flight_of(theta=0.25, q=1.0)
    code, theta, rest, u = contact_search.land(made, const, 0, f, 2.25, first, None)
    assert code == (LANDED if near else NEARLY)
    assert theta + rest == pytest.approx(1.25, abs=1e-15 if near else 1e-3)
    assert u == pytest.approx(-2.5, abs=1e-14 if near else 1e-2)
    if not near:
        assert rest == 0.0
    short = Made(stretches=[Made(end=1.125, jerk_max=6.0)])
    _, theta, rest, _ = contact_search.land(short, const, 0, f, 2.25, first, None)
    assert theta == 1.125
    assert rest == pytest.approx(0.125 if near else 0.0, abs=1e-12)


def test_a_stretch_is_crossed_by_its_row_of_the_table():
    """The second of three: its row is behind the three of the first one."""
    made = Made(stretches=[None, Made(end_c=0.75, end_c1=-0.5), None])
    work = Tally()
    f = flight_of(q=2.0, w=3.0, force=7.0)
    flows = {3: Made(b=0.5, b1=0.25, p=0.125)}
    gap, rate, q2 = contact_search._across(made, CONST, flows, 1, f, work)
    q, w = 2.0 + 1.5 - 0.875, 0.75 - 3.5
    assert (gap, rate, q2) == (q - 0.75, w + 0.5, -3.0 - 4.0 * q - 0.5 * w)
    assert (work.crossings, work.evaluations) == (1, 0)


@pytest.mark.parametrize("damping", [0.0, 5.0])
@pytest.mark.parametrize("i", range(7))
def test_a_gap_is_the_same_by_differences_and_by_the_closed_form(damping, i):
    """Over 1/40 rad of each stretch of the example; over more, it is that of the closed form."""
    made = system(damping=damping, gravity=9.81)
    table, const = made.cam, made.constants(300.0, 0.0, 1)
    stretch = table.stretches[i]
    theta = 0.75 * stretch.start + 0.25 * stretch.end
    f = contact_search.flight_at(table, const, i, theta, 0.01, 0.002)
    z, square = const.Z, const.W2
    level = f.q + const.G / square
    omega = sqrt(square - z * z)
    for s in (0.025, 0.04):
        wave = level * cos(omega * s) + (f.w + z * level) / omega * sin(omega * s)
        turn = (f.w + z * level) * cos(omega * s) - omega * level * sin(omega * s)
        q = exp(-z * s) * wave - const.G / square
        w = exp(-z * s) * (turn - z * wave)
        c, c1, c2 = lift_at(table, i, theta + s)
        wanted = (q - c, w - c1, -const.G - square * q - 2.0 * z * w - c2)
        found = contact_search.gap_after(table, const, i, f, s)
        assert found == pytest.approx(wanted, abs=1e-12)
        near = contact_search.gap_near(table, const, i, f, s)
        assert near == pytest.approx(wanted, abs=1e-11)
    c, c1, _ = lift_at(table, i, theta)
    for s in (1e-3, 0.02, 0.3 * (stretch.end - stretch.start)):
        d, d1, _ = lift_at(table, i, theta + s)
        fall = contact_search.cam_fall(table, i, theta, s)
        assert fall == pytest.approx((d - c - c1 * s, d1 - c1), abs=1e-14)


# -- flights


@pytest.mark.parametrize("z", [0.0, 0.25])
def test_the_series_of_a_gap_has_the_derivatives_of_its_flight(monkeypatch, z):
    """q'' + 2 Z q' + W^2 q + G = 0 by mpmath, less the derivatives of the cam."""
    const = Made(Z=z, W2=4.0, W=2.0, G=3.0)
    monkeypatch.setattr(flight, "higher", lambda cam, i, theta: (5.0, 6.0, 7.0, 8.0))
    q0, w0 = 0.5, -0.75
    f = sqrt(4.0 - z * z)
    level = q0 + 0.75

    def q(s):
        wave = level * mp.cos(f * s) + (w0 + z * level) / f * mp.sin(f * s)
        return mp.exp(-z * s) * wave - mp.mpf(3) / 4

    derivatives = [float(mp.diff(q, 0, k)) for k in range(2, 7)]
    found = flight.taylor(None, const, 0, 1.0, derivatives[0], derivatives[1], 4.0)
    wanted = [
        (d - c) / factorial(k)
        for k, (d, c) in enumerate(zip(derivatives, (4.0, 5.0, 6.0, 7.0, 8.0), strict=True), 2)
    ]
    assert found == pytest.approx(wanted, rel=1e-9)
    gap, rate = flight.series_gap(0.25, -0.5, found, 0.375)
    poly = np.polynomial.Polynomial([0.25, -0.5, *found])
    assert gap == pytest.approx(poly(0.375), rel=1e-14)
    assert rate == pytest.approx(poly.deriv()(0.375), rel=1e-14)


@pytest.mark.parametrize("gravity", [3.0, 2.0])
@pytest.mark.parametrize(("gap", "rate"), [(0.0, 0.5), (0.25, 0.5), (0.25, -0.5), (0.25, 0.0)])
@pytest.mark.parametrize("w2", [0.0, 4.0])
def test_a_drop_onto_a_dwell_is_that_of_a_swing(gap, rate, w2, gravity):
    """By mpmath: the height is level cos W s + rate sin(W s)/W about its rest, as is the rate."""
    const = Made(G=gravity, W2=w2, W=sqrt(w2), W_rest=0.0)
    c = 0.5
    f = flight_of(theta=1.0, gap=gap, rate=rate, q=c + gap, force=gravity + w2 * (c + gap), end=9.0)
    code, theta, rest, u = flight._drop(Made(stretches=[Made(end=10.0)]), const, 0, f, Tally())
    s = theta + rest - 1.0
    if w2 == 0.0:
        height, speed = gap + rate * s - gravity * s * s / 2.0, rate - gravity * s
    else:
        level, w = gap + c + gravity / w2, sqrt(w2)
        height = level * cos(w * s) + rate / w * sin(w * s) - (c + gravity / w2)
        speed = rate * cos(w * s) - w * level * sin(w * s)
    small = gap == 0.0 and sqrt(w2) * s <= 0.5
    assert code == (contact_search.EXACTLY if small else NEARLY)
    assert height == pytest.approx(0.0, abs=1e-14)
    assert speed == pytest.approx(u, rel=1e-13)
    short = f._replace(end=0.5 * s)
    assert flight._drop(Made(stretches=[Made(end=10.0)]), const, 0, short, Tally()) == (
        CLEAR, 1.0, gap, rate,
    )  # fmt: skip
    if code == contact_search.EXACTLY:
        const.W_rest = 1e-10
        more = flight._drop(Made(stretches=[Made(end=10.0)]), const, 0, f, Tally())[2]
        share = w2 * c / (gravity + w2 * c)
        assert more - rest == pytest.approx(-2.0 * s * 1e-10 * share, rel=1e-4, abs=1e-14)


def test_a_drop_where_nothing_pulls_is_left_to_others():
    const = Made(G=-3.0, W2=4.0, W=2.0, W_rest=0.0)
    f = flight_of(theta=1.0, rate=0.5, q=0.5, force=-1.0, end=9.0)
    made = Made(stretches=[Made(end=10.0)])
    assert flight._drop(made, const, 0, f, Tally()) == (CLEAR, 1.0, 0.0, 0.5)
    # the spring pulls it where it is, and pushes it off where the cam is
    const = Made(G=-0.25, W2=0.25, W=0.5, W_rest=0.0)
    high = flight_of(theta=1.0, gap=2.0, rate=-1.0, q=2.5, force=0.375, end=9.0)
    assert flight._drop(made, const, 0, high, Tally()) == (CLEAR, 1.0, 2.0, -1.0)


def leapt(i=1, strobe=3, *, rate=0.5, gap=9.0, g=1.0, top=1.0, d=0.0):
    """From the start of stretch i of four, over a level cam of 1/2, a follower that only falls."""
    ends = [1.0, 2.0, 3.0, TURN]
    stretches = [Made(start=a, end=b, start_c=0.5, start_c1=0.0625 * k)
                 for k, (a, b) in enumerate(zip([0.0, *ends], ends, strict=False))]  # fmt: skip
    rows = []
    for k in range(4):
        s = 0.0
        for j in range(k, k + 4):
            s += stretches[j % 4].end - stretches[j % 4].start
            rows.append(Made(b=s, b1=1.0, p=0.5 * s * s))
    made = Made(stretches=stretches, top=top, strobe=strobe)
    const = Made(G=g, W2=0.0, Z=0.0, D=d)
    work = Tally()
    return flight.leap(made, const, rows, i, gap, rate, work), work.crossings


def test_a_follower_far_above_the_cam_leaps_over_its_stretches_up_to_the_strobe():
    (skipped, gap, rate), crossings = leapt()
    assert (skipped, crossings) == (2, 1)  # to the strobe at the start of the fourth one
    w = 0.5 + 0.0625
    assert gap == pytest.approx(9.5 + 2.0 * w - 2.0 - 0.5)
    assert rate == pytest.approx(w - 2.0 - 0.1875)
    (skipped, gap, rate), _ = leapt(2, 1, gap=40.0)
    assert skipped == 3  # through the end of the turn to the second one
    s = TURN - 2.0 + 1.0
    w = 0.5 + 0.125
    assert gap == pytest.approx(40.5 + w * s - 0.5 * s * s - 0.5)
    assert rate == pytest.approx(w - s - 0.0625)
    assert leapt(3, 3, gap=60.0)[0][0] == 4  # a whole turn
    # half a swing is pi/sqrt(-D): longer than to the end of the turn, or not
    assert [leapt(2, 0, gap=60.0, d=d)[0][0] for d in (-0.5, -0.6)] == [2, 0]
    (skipped, _, _), _ = leapt(0, 3, gap=2.9)
    assert skipped == 2  # behind the third the follower is no more above the top
    for given in ({"gap": 0.4}, {"g": -1.0}, {"gap": 1.0, "rate": -0.5}, {"i": 2, "strobe": 3}):
        (skipped, gap, rate), crossings = leapt(**given)
        assert (skipped, crossings) == (0, 0)
        assert (gap, rate) == (given.get("gap", 9.0), given.get("rate", 0.5))


# -- the loop


def test_a_flight_keeps_where_it_begins():
    state = State(flown=9, wraps=3, rest=1e-17, known=1)
    orbit_loop.begin_flight(state, 4, 2.5, 0.125, -0.5)
    assert (state.flown, state.wraps, state.known, state.rest) == (0, 0, 0, 0.0)
    assert (state.from_stretch, state.from_theta, state.from_gap, state.from_rate) == (
        4, 2.5, 0.125, -0.5,
    )  # fmt: skip
    assert (state.from_rest, state.from_known) == (1e-17, 1)
    assert orbit_loop.reset_map(0.5, -3.0) == 1.5


def logged(state, **more):
    made = Made(
        stretches=[Made(start=0.0, end=1.0, seat=0, rest=0.25), Made(start=1.0, end=3.0, seat=1,
                                                                     rest=0.5)],
        **more,
    )  # fmt: skip
    columns = {name: [None] * 3 for name in ("kind", "period", "theta", "q", "u")}
    return made, Made(capacity=3, **columns), Made(log_from=2)


@pytest.fixture
def lifted(monkeypatch):
    """The lift of the cam is ten times its phase."""
    monkeypatch.setattr(orbit_loop, "lift_at", lambda cam, i, theta: (10.0 * theta, 0.0, 0.0))


def test_what_follows_a_contact(lifted):
    const = Made(r=0.75, r_seat=0.5)
    contact = orbit_loop.after_contact
    state = State(period=2, idle=7)
    made, log, plan = logged(state)
    end = (made, const, state, plan, log)
    assert contact(*end, 1, 2.0, -4.0, FREE, LANDED) == (BOUNCED, 2.0, 2.0)
    assert (state.impacts, state.total_impacts, state.idle, state.logged) == (1, 1, 0, 1)
    assert [log.kind[0], log.period[0], log.theta[0], log.q[0], log.u[0]] == [
        IMPACT, 2, 2.0, 20.0, -4.0,
    ]  # fmt: skip
    state.idle = 7
    assert contact(*end, 0, 0.5, 0.0, FREE, LANDED) == (BOUNCED, 0.5, 0.0)  # no impact
    assert contact(*end, 1, 3.0, -4.0, FREE, LANDED) == (FREE, 3.0, -4.0)  # of the next stretch
    assert contact(*end, 1, 2.0, -4.0, BOUNCED, CLEAR) == (FREE, 2.0, -4.0)
    assert (state.impacts, state.total_impacts, state.idle, state.chattered) == (1, 1, 7, 0)
    accumulated = contact(*end, 1, 2.5, 0.0, BOUNCED, contact_search.ACCUMULATED)
    assert accumulated == (RESTING, 2.5, 0.0)
    assert state.chattered == 1
    assert [log.kind[1], log.theta[1], log.u[1]] == [CHATTER, 2.5, 0.0]
    stuck = contact_search.STUCK
    assert contact(*end, 1, 2.5, 0.0, BOUNCED, stuck) == (RESTING, 2.5, 0.0)
    assert contact(*end, 1, 2.5, 0.0, RELEASED, stuck) == (RESTING, 2.5 + 1e-8, 0.0)
    assert contact(*end, 1, 3.0 - 1e-9, 0.0, RELEASED, stuck) == (RESTING, 3.0, 0.0)
    assert state.logged == 2


def test_events_are_logged_from_a_period_on_while_there_is_room(lifted):
    state = State(period=1)
    made, log, plan = logged(state)
    orbit_loop.log_event(made, state, plan, log, IMPACT, 0, 0.5, -1.0)
    assert state.logged == 0
    state.period = 2
    for k in range(5):
        orbit_loop.log_event(made, state, plan, log, IMPACT, 0, 0.125 * k, -1.0)
    assert state.logged == 3
    assert log.theta == [0.0, 0.125, 0.25]


@pytest.mark.parametrize(("theta", "rest"), [(1.0, 0.5), (1.5, 0.0)])
@pytest.mark.parametrize("period", [-1, 0, 3])
def test_a_detachment_is_counted_outside_the_transient(lifted, theta, rest, period):
    state = State(period=period, known=1, rest=9.0)
    made, log, plan = logged(state)
    orbit_loop.detach(made, state, plan, log, 1, theta)
    assert state.detachments == (period >= 0)
    assert (state.known, state.rest) == (0, rest)
    assert state.logged == (period >= 2)
    if state.logged:
        assert [log.kind[0], log.theta[0], log.u[0]] == [DETACHMENT, theta, 0.0]


@pytest.mark.parametrize("mode", [FREE, BOUNCED, RESTING])
@pytest.mark.parametrize(
    ("jump", "free"), [(0.0, False), (0.25, False), (0.75, True), (-0.25, False)]
)
@pytest.mark.parametrize("i", [0, 2])
def test_a_jump_of_the_slope_is_a_blow_or_a_launch(mode, jump, free, i):
    state = State(idle=5, known=1, wraps=7)
    made = Made(stretches=[Made(start=k, slope_jump=jump) for k in (0.0, 1.0, 2.0)])
    rate = 0.0 if mode == RESTING else 0.5
    after = FREE if jump != 0.0 and (mode == RESTING or free) else mode
    entered = orbit_loop.enter_stretch(made, state, i, rate, mode)
    number = (i + 1) % 3
    assert entered == (number, float(number), rate - jump, after)
    assert (state.idle, state.known, state.wraps) == (0, 0, 7 + (i == 2))


def test_a_period_is_recorded_with_what_it_ends_in_and_what_begins_the_next(lifted):
    made = Made(stretches=[None, Made(start_c=0.5, start_c1=0.25)])
    columns = {name: [None] * 5 for name in ("q", "w", "impacts", "chatter")}
    strobe = Made(rows=3, first=1, **columns)
    state = State(period=-2)
    for period in range(-2, 4):
        state.impacts, state.chattered = 10 + period, period % 2
        orbit_loop.begin_period(made, state, strobe, 1, 0.125 * period, 0.0625 * period)
        assert (state.period, state.impacts, state.chattered) == (period + 1, 0, 0)
    assert strobe.impacts == [None, 10, 11, 12, None]
    assert strobe.chatter == [None, 0, 1, 0, None]
    assert strobe.q == [None, 0.5 - 0.125, 0.5, 0.5 + 0.125, None]
    assert strobe.w == [None, 0.25 - 0.0625, 0.25, 0.25 + 0.0625, None]


@pytest.mark.parametrize(
    ("const", "gap", "rate", "said"),
    [
        ((0.0, 0.0, 0.0), 1.0, 0.0, True), ((0.0, 0.0, 0.0), 1.0, -0.5, False),
        ((1.0, 0.0, 0.0), 1.0, 0.5, False), ((0.0, 1.0, 0.0), 1.0, 0.5, False),
        ((0.0, 0.0, 0.0), 0.4, 0.5, False), ((0.0, 0.0, 0.5), 1.0, -0.3, True),
        ((0.0, 0.0, 0.5), 1.0, -0.8, False), ((0.0, -1.0, 0.0), 1.0, 0.5, True),
    ],
)  # fmt: skip
def test_a_follower_above_the_cam_never_returns_where_nothing_pulls(const, gap, rate, said):
    """W^2, G and Z; on a cam of 1/2 at its start that reaches 1: a damper stops it w/(2 Z) on."""
    w2, g, z = const
    made = Made(stretches=[Made(start_c=0.5, start_c1=0.0)], top=1.0)
    assert orbit_loop.never_returns(made, Made(W2=w2, G=g, Z=z), 0, gap, rate) is said


# -- rest


def test_the_acceleration_in_contact_has_its_slope_and_its_size(monkeypatch):
    monkeypatch.setattr(sticking, "lift_at", lambda cam, i, theta: (2.0, -3.0, 5.0))
    monkeypatch.setattr(sticking, "derivative", lambda cam, order, i, theta: 7.0 * (order == 3))
    a, slope, size = sticking.contact_accel(None, CONST, 0, 1.0)
    assert a == -(3.0 + 8.0 - 1.5) - 5.0
    assert slope == -(4.0 * -3.0 + 0.5 * 5.0) - 7.0
    assert size == 3.0 + 8.0 + 1.5 + 5.0


@pytest.mark.parametrize(
    ("accel", "released"),
    [
        ((-1.0, 1.0), 1.0), ((-1.0, -1.0), None), ((-4.0, 0.0, 1.0), 2.0), ((0.5,), 0.0),
        ((0.0, 1.0), 0.0), ((-2.0, 2.0, -1.0), None), ((-1.0, 0.5, 0.5), 1.0),
        ((0.0, -1.0, 0.5), 2.0),
    ],
)  # fmt: skip
def test_a_follower_detaches_where_its_acceleration_rises_through_zero(
    monkeypatch, accel, released
):
    """Polynomials of the phase from 0 to 5 rad; one comes near zero, one falls from it."""
    one = np.polynomial.Polynomial(accel)
    monkeypatch.setattr(
        sticking, "contact_accel",
        lambda cam, const, i, theta: (float(one(theta)), float(one.deriv()(theta)), 1.0),
    )  # fmt: skip
    curve = float(np.abs(one.deriv(2)(np.linspace(0.0, 5.0, 50))).max())
    stretch = Made(end=5.0, c_min=0.0, slope_min=0.0, accel_min=-9.0, accel_max=9.0, jerk_max=0.0,
                   snap_max=curve)  # fmt: skip
    made, const = Made(stretches=[stretch]), Made(G=0.0, W2=0.0, Z=0.0)
    found, theta = sticking.find_detachment(made, const, 0, 0.0)
    assert found is (released is not None)
    assert theta == pytest.approx(5.0 if released is None else released, abs=1e-7)
    stretch.accel_min = 0.25  # the force is above zero all over
    assert sticking.find_detachment(made, const, 0, 0.0) == (False, 5.0)
    const.G = -1.0
    assert sticking.find_detachment(made, const, 0, 0.0)[0] is (released is not None)


# -- loads


def turned(*, strobe=0, seats=(0, 0, 0), jumps=(0.0, 0.0, 0.0)) -> Made:
    """Three stretches that begin at 0, 2 and 4 rad."""
    ends = (2.0, 4.0, TURN)
    starts = (0.0, 2.0, 4.0)
    return Made(strobe=strobe, top=9.0, stretches=[
        Made(start=a, end=b, seat=seat, slope_jump=jump, c_min=3.0 + a)
        for a, b, seat, jump in zip(starts, ends, seats, jumps, strict=True)
    ])  # fmt: skip


def log_of(*rows) -> Made:
    """Events by kind, period, phase and rate."""
    kind, period, theta, u = ([row[k] for row in rows] for k in range(4))
    return Made(kind=kind, period=period, theta=theta, u=u)


def test_a_record_begins_with_its_hardest_impact_and_its_lowest_cam(monkeypatch):
    asked: list = []
    monkeypatch.setattr(loads_module, "begins_at_rest", lambda cam, log, recorded, last, load: (
        asked.append((recorded, last)) or True))  # fmt: skip
    log = log_of((IMPACT, -1, 1.0, -90.0), (IMPACT, 0, 1.0, -5.0), (CHATTER, 0, 1.5, -70.0),
                 (IMPACT, 1, 1.0, -20.0), (IMPACT, 2, 1.0, -80.0))  # fmt: skip
    load = Loads(turns=2)
    loads_module.begin(turned(strobe=2), log, 0, 5, load)
    assert load.bounce == pytest.approx(0.1 * 20.0)
    assert (load.lowest, load.has_seat, load.phase, load.still) == (3.0, 0, 4.0, 1)
    assert asked == [(1, 5)]
    load = Loads(turns=2)
    loads_module.begin(turned(seats=(0, 1, 0)), log, 0, 1, load)
    assert (load.has_seat, load.bounce) == (1, 0.0)
    assert asked[1] == (1, 1)


@pytest.mark.parametrize(
    ("row", "state", "rests"),
    [
        ((DETACHMENT, 0, 1.0, 0.0), (0.0, 0.0), True),
        ((DETACHMENT, 0, 1.0, 0.0), (0.1, 0.0), False),
        ((DETACHMENT, 0, 1.0, 0.0), (0.0, 0.1), False), ((CHATTER, 0, 1.0, 0.0), (0.0, 0.0), False),
        ((IMPACT, 0, 2.0, -1.0), (0.0, 0.0), True), ((IMPACT, 0, 4.0, -1.0), (0.0, 0.0), False),
        ((IMPACT, 0, 2.5, -1.0), (0.0, 0.0), False), (None, (0.0, 0.0), True),
    ],
)  # fmt: skip
def test_a_record_begins_at_rest_where_nothing_says_otherwise(row, state, rests):
    """The slope jumps upwards at 2 rad and downwards at 4."""
    made = turned(jumps=(0.0, 0.5, -0.5))
    log = log_of((IMPACT, -1, 1.0, -1.0), *([row] if row else []))
    load = Loads(gap=state[0], rate=state[1])
    assert loads_module.begins_at_rest(made, log, 1, len(log.kind), load) is rests


def test_phases_are_counted_from_the_strobe_and_regained_contact_within_its_turn():
    made = turned(strobe=1)
    assert [loads_module.since_strobe(made, x) for x in (2.0, 5.0, 1.0)] == [0.0, 3.0, TURN - 1.0]
    load = Loads()
    for place, regained in ((1.0, 1.0), (2.0 * TURN + 0.5, 1.0), (TURN + 1.5, 1.5)):
        loads_module.regain(load, place)
        assert load.regained == pytest.approx(regained)


@pytest.mark.parametrize(
    ("phase", "span", "seated", "ends_on_seat"),
    [
        (2.5, 1.0, 1.0, True), (1.0, 1.5, 0.5, True), (3.0, 2.0, 1.0, False),
        (4.5, 1.0, 0.0, False),
        (2.0, 2.0 * TURN, 4.0, True), (1.0, TURN + 2.0, 3.0, True), (5.0, TURN, 2.0, False),
        (3.0, 1.0, 1.0, True),
    ],
)  # fmt: skip
def test_a_rest_is_on_the_seat_for_as_long_as_it_passes_it(phase, span, seated, ends_on_seat):
    """The seat goes from 2 to 4 rad; the strobe is elsewhere."""
    load = Loads(phase=phase, still=1, has_seat=1)
    said = loads_module.add_span(turned(seats=(0, 1, 0)), span, load)
    assert load.seated == pytest.approx(seated)
    assert load.airborne == 0.0
    if span % TURN:
        assert bool(said) is ends_on_seat
    load = Loads(phase=phase, has_seat=1)
    assert loads_module.add_span(turned(seats=(0, 1, 0)), span, load) is False
    assert (load.airborne, load.seated) == (span, 0.0)
    load = Loads(phase=phase, still=1)
    assert loads_module.add_span(turned(), span, load) is False
    assert (load.airborne, load.seated) == (0.0, 0.0)


def test_a_way_is_repeated_where_all_of_it_is_the_same_again():
    made = turned()
    rows = [(IMPACT, 0, 1.0, -2.0), (CHATTER, 0, 3.0, 0.0), (IMPACT, 1, 1.0, -2.0),
            (CHATTER, 1, 3.0, 0.0)]  # fmt: skip
    assert loads_module.is_repeated(made, log_of(*rows), 0, 3, 2.0)
    assert not loads_module.is_repeated(made, log_of(*rows), 2, 3, 2.0)  # of another record
    assert not loads_module.is_repeated(made, log_of(*rows), 0, 3, 2.0 + TURN)
    for k, column, value in ((1, 2, 3.5), (0, 2, 1.5), (0, 3, -3.0), (0, 1, -1), (1, 0, IMPACT),
                             (0, 0, CHATTER)):  # fmt: skip
        changed = [list(row) for row in rows]
        changed[k][column] = value
        assert not loads_module.is_repeated(made, log_of(*changed), 0, 3, 2.0)


def test_no_way_from_before_the_record_is_one_of_its_own():
    rows = [(IMPACT, -1, 5.0, -2.0), (CHATTER, 0, 1.0, 0.0), (IMPACT, 0, 5.0, -2.0),
            (CHATTER, 1, 1.0, 0.0)]  # fmt: skip
    span = 1.0 - (-TURN + 5.0)
    assert not loads_module.is_repeated(turned(), log_of(*rows), 0, 3, span)
    rows[0], rows[1] = (IMPACT, 0, 5.0, -2.0), (CHATTER, 1, 1.0, 0.0)
    assert loads_module.is_repeated(turned(), log_of(*rows), 0, 3, TURN + 1.0 - 5.0)


def added(monkeypatch, rows, made=None, *, pressed=False, lift=5.0, **load):
    """The loads after some events, and the ways whose extremes are looked for."""
    ways: list = []
    monkeypatch.setattr(loads_module, "adds_nothing", lambda *given: False)
    monkeypatch.setattr(loads_module, "_find_extremes", lambda cam, const, span, load: (
        ways.append((load.phase, load.gap, load.rate, load.still, span))))  # fmt: skip
    monkeypatch.setattr(loads_module, "_is_pressed", lambda *given: pressed)
    monkeypatch.setattr(loads_module, "lift_at", lambda cam, i, theta: (lift, 0.0, 0.0))
    made = made or turned()
    one = Loads(**{"turns": 3, "bounce": 1.0, "shut": 6.0, "gap": 0.5, "rate": 0.25, **load})
    const = Made(r=0.5, r_seat=0.25)
    loads_module.add_events(made, const, log_of(*rows), 0, 0, len(rows), one)
    return one, ways


def test_flights_and_rests_follow_one_another(monkeypatch):
    rows = [(IMPACT, -1, 9.0, -9.0), (IMPACT, 0, 1.0, -4.0), (CHATTER, 0, 3.0, 0.0),
            (DETACHMENT, 1, 2.5, 0.0), (IMPACT, 1, 5.0, -0.5), (IMPACT, 3, 1.0, -9.0)]  # fmt: skip
    load, ways = added(monkeypatch, rows)
    assert ways == [
        (0.0, 0.5, 0.25, 0, 1.0), (1.0, 0.0, 2.0, 0, 2.0),
        (3.0, 0.0, 0.0, 1, pytest.approx(TURN - 0.5)), (2.5, 0.0, 0.0, 0, 2.5),
    ]  # fmt: skip
    assert load.airborne == pytest.approx(1.0 + 2.0 + 2.5)
    assert (load.max_impact, load.landing, load.landing_c) == (4.0, 1.0, 5.0)
    assert load.lost == 2.5
    assert load.regained == 3.0
    assert load.shut_bounces == 1  # the other is softer
    assert (load.place, load.phase, load.rate) == (pytest.approx(TURN + 5.0), 5.0, 0.25)
    assert (load.still, load.struck) == (0, 1)
    assert added(monkeypatch, rows, lift=6.5)[0].shut_bounces == 0


def test_an_impact_that_does_not_bounce_is_a_rest(monkeypatch):
    rows = [(IMPACT, 0, 1.0, 0.0)]
    for pressed in (False, True):
        load, _ = added(monkeypatch, rows, pressed=pressed)
        assert (load.still, load.struck) == ((1, 0) if pressed else (0, 1))
        assert load.regained == (1.0 if pressed else -1.0)
    load, _ = added(monkeypatch, [(IMPACT, 0, 1.0, -4.0)], pressed=True)
    assert (load.still, load.struck) == (0, 1)  # it bounces
    on_seat = turned(seats=(0, 1, 0))
    load, _ = added(monkeypatch, [(IMPACT, 0, 3.0, 0.0)], on_seat, pressed=True, has_seat=1)
    assert (load.still, load.regained) == (1, -1.0)


def test_a_downward_kink_throws_the_follower_off(monkeypatch):
    made = turned(jumps=(0.0, -0.75, 0.5))
    for theta, rate in ((2.0, 0.75), (4.0, 0.0), (3.0, 0.0)):
        load, _ = added(monkeypatch, [(DETACHMENT, 0, theta, 0.0)], made, still=1)
        assert (load.rate, load.still, load.lost) == (rate, 0, theta)
    load, _ = added(monkeypatch, [(DETACHMENT, 0, 3.0, 0.0), (DETACHMENT, 1, 1.0, 0.0)], still=1)
    assert load.lost == 1.0
    load, _ = added(monkeypatch, [(CHATTER, 0, 3.0, 0.0)], still=1)
    assert load.lost == -1.0


def test_on_its_seat_a_follower_is_shut_and_out_of_contact_with_the_lobe(monkeypatch):
    made = turned(seats=(0, 1, 0))
    for theta, on_seat in ((1.0, False), (3.0, True)):
        load, _ = added(monkeypatch, [(IMPACT, 0, theta, -4.0)], made, has_seat=1)
        assert load.rate == (1.0 if on_seat else 2.0)
        assert load.shut_bounces == on_seat
        load, _ = added(monkeypatch, [(CHATTER, 0, theta, 0.0)], made, has_seat=1)
        assert load.regained == (-1.0 if on_seat else theta)
        assert load.still == 1
        rows = [(DETACHMENT, 0, theta, 0.0)]
        load, _ = added(monkeypatch, rows, made, has_seat=1, still=1)
        assert load.lost == (-1.0 if on_seat else theta)
    start = {"place": 1.0, "phase": 1.0, "still": 1, "has_seat": 1}
    load, _ = added(monkeypatch, [(DETACHMENT, 0, 2.0, 0.0)], made, **start)
    assert load.lost == -1.0  # where the seat begins


@pytest.mark.parametrize(
    ("rows", "resting", "rests"),
    [
        ([(IMPACT, 0, 1.0, -1.0), (DETACHMENT, 1, 2.0, 0.0)], 0, True),
        ([(IMPACT, 0, 1.0, -1.0), (IMPACT, 1, 2.0, -1.0), (DETACHMENT, 1, 2.5, 0.0)], 1, False),
        ([(IMPACT, 0, 1.0, -1.0)], 1, True), ([(DETACHMENT, 0, 1.0, 0.0)], 0, False), ([], 1, True),
    ],
)  # fmt: skip
def test_a_record_ends_with_a_rest_where_the_follower_detaches_next(
    monkeypatch, rows, resting, rests
):
    ways: list = []
    monkeypatch.setattr(loads_module, "_find_extremes", lambda cam, const, span, load: (
        ways.append((load.still, span))))  # fmt: skip
    load = Loads(turns=1, resting=resting, place=2.0, phase=2.0, struck=1)
    loads_module.end(turned(), None, log_of(*rows), 0, len(rows), load)
    assert ways == [(int(rests), TURN - 2.0)]
    assert load.airborne == (0.0 if rests else TURN - 2.0)
    assert load.regained == (2.0 if rests else -1.0)


def test_the_whole_log_is_gone_through_in_pieces(monkeypatch):
    calls: list = []
    for name in ("begin", "add_events", "end"):
        monkeypatch.setattr(
            loads_module, name, lambda *given, name=name: calls.append((name, *given[2:-1]))
        )
    for first, last in ((0, 2), (2, 5), (5, 7)):
        loads_module.measure_loads("cam", "const", "log", first, last, 7, ["load"])
    names = [(call[0], *(x for x in call[1:] if isinstance(x, int))) for call in calls]
    assert names == [
        ("begin", 0, 7), ("add_events", 0, 0, 2), ("add_events", 0, 2, 5), ("add_events", 0, 5, 7),
        ("end", 0, 7),
    ]  # fmt: skip
    calls.clear()
    loads_module.measure_record("cam", "const", "log", 3, 6, "load")
    names = [(call[0], *(x for x in call[1:] if isinstance(x, int))) for call in calls]
    assert names == [("begin", 3, 6), ("add_events", 3, 3, 6), ("end", 3, 6)]


# -- extremes of flights and rests, by samples on the example's cam


def sampled(table, const, theta, q, w, span, count=600):
    """The gaps of a flight, whether it meets the cam or not."""
    gaps = []
    for k in range(count + 1):
        s = span * k / count
        height, _ = move(const, q, w, s)
        phase = (theta + s) % TURN
        gaps.append(height - lift_at(table, stretch_at(table, phase), phase)[0])
    return gaps


FLIGHTS = [  # phase, gap and rate at the start, span, and the damping
    (0.5, 0.0, 0.05, 1.0, 0.0), (2.0, 0.01, 0.1, 3.0, 5.0), (5.0, 0.02, -0.05, 4.0, 0.0),
    (2.7, 0.0, 0.3, 6.0, 5.0), (2.3, 0.0, -0.02, 0.5, 0.0), (6.0, 0.001, 0.002, 0.1, 5.0),
]  # fmt: skip


@pytest.mark.parametrize(("theta", "gap", "rate", "span", "damping"), FLIGHTS)
def test_the_highest_gap_of_a_flight_is_that_of_samples(theta, gap, rate, span, damping):
    """Over the corners of the cam; and where it is said to stay low it does."""
    made = system(damping=damping, gravity=9.81)
    table, const = made.cam, made.constants(300.0, 0.0, 1)
    c, c1, _ = lift_at(table, stretch_at(table, theta), theta)
    gaps = sampled(table, const, theta, c + gap, c1 + rate, span)
    load = Loads()
    loads_module._fly(table, const, theta, gap, rate, span, load)
    assert load.max_gap >= max(gaps) - 1e-12
    assert load.max_gap == pytest.approx(max(gaps), abs=1e-5)
    before = Loads(phase=theta, gap=gap, rate=rate, lowest=0.1)
    for highest in (0.5 * max(gaps), 0.999 * max(gaps)):
        before.max_gap = highest
        assert not loads_module._stays_low(table, const, span, before)
    before.max_gap = 1.0
    assert loads_module._stays_low(table, const, span, before)


@pytest.mark.parametrize("damping", [0.0, 20.0])
@pytest.mark.parametrize(("theta", "span"), [(0.5, 1.0), (2.0, 3.0), (5.0, 2.5), (1.0, 9.0)])
def test_the_forces_of_a_rest_are_those_of_samples(theta, span, damping):
    """One turn of it is all; a part of the cam that is seat has none."""
    made = system(damping=damping, gravity=9.81, preload=30.0)
    table, const = made.cam, made.constants(300.0, 0.0, 1)

    def force(phase):
        i = stretch_at(table, phase)
        c, c1, c2 = lift_at(table, i, phase)
        return const.G + const.W2 * c + 2.0 * const.Z * c1 + c2

    phases = [(theta + min(span, TURN) * k / 3000) % TURN for k in range(1, 3000)]
    forces = [force(phase) for phase in phases]
    load = Loads()
    loads_module._press_at_rest(table, const, theta, span, load)
    size = max(map(abs, forces))
    assert load.max_force == pytest.approx(max(forces), abs=2e-3 * size)
    assert load.min_force == pytest.approx(min(forces), abs=2e-3 * size)
    assert load.max_force >= max(forces) - 1e-12 * size
    assert load.min_force <= min(forces) + 1e-12 * size


def test_short_hops_are_below_what_they_may_rise_to_on_their_stretch():
    """Where no weight pulls: gap + rate s + most gap'' s^2/2, within the stretch alone."""
    made = Made(stretches=[Made(start=0.0, end=2.0, accel_min=-1.0, start_c=0.5, start_c1=0.0,
                                start_c2=0.0, slope_jump=0.0, dwell=1)])  # fmt: skip
    const = Made(G=0.0, W2=0.0, W=0.0, Z=0.0)
    for rate, span, most, low in ((0.25, 0.5, 0.251, True), (0.25, 0.5, 0.249, False),
                                  (-0.25, 0.5, 0.126, True), (-0.25, 0.5, 0.124, False),
                                  (0.0, 2.5, 9.0, False), (0.0, 2.0, 2.1, True)):  # fmt: skip
        load = Loads(phase=0.0, gap=0.0009765625, rate=rate, max_gap=most + 0.0009765625)
        assert loads_module._stays_low(made, const, span, load) is low


@pytest.mark.parametrize(("still", "stays", "repeated"), [
    (0, True, False), (0, False, True), (0, False, False), (1, True, False), (1, True, True),
])  # fmt: skip
def test_a_way_adds_nothing_where_it_stays_low_or_is_repeated(monkeypatch, still, stays, repeated):
    """A rest has no height."""
    monkeypatch.setattr(loads_module, "_stays_low", lambda *given: stays)
    monkeypatch.setattr(loads_module, "is_repeated", lambda *given: repeated)
    load = Loads(still=still)
    nothing = loads_module.adds_nothing(None, None, None, 0, 1, 2.0, load)
    assert nothing is (repeated or (stays and not still))
    calls: list = []
    monkeypatch.setattr(loads_module, "_press_at_rest", lambda *given: calls.append(given[2:4]))
    monkeypatch.setattr(loads_module, "_fly", lambda *given: calls.append(given[2:6]))
    load.phase, load.gap, load.rate = 1.0, 0.25, 0.5
    loads_module._find_extremes(None, None, 2.0, load)
    assert calls == ([(1.0, 2.0)] if still else [(1.0, 0.25, 0.5, 2.0)])


def test_a_rest_presses_on_what_is_cam_and_a_flight_goes_on_over_its_kinks(monkeypatch):
    """From 1 rad on; the seat goes from 2 to 4 rad, and the slope jumps where a stretch begins."""
    pressed: list = []
    monkeypatch.setattr(loads_module, "_press", lambda cam, const, i, theta, end, load: (
        pressed.append((i, theta, end))))  # fmt: skip
    made = turned(seats=(0, 1, 0), jumps=(0.125, 0.25, 0.5))
    loads_module._press_at_rest(made, None, 1.0, 4.0, Loads())
    assert pressed == [(0, 1.0, 2.0), (2, 4.0, 5.0)]
    pressed.clear()
    loads_module._press_at_rest(made, None, 5.0, 9.0, Loads())
    ends = [(2, 5.0, TURN), (0, 0.0, 2.0), (2, 4.0, pytest.approx(5.0))]
    assert pressed == ends  # one turn of it is all
    flown: list = []
    monkeypatch.setattr(loads_module, "flight_at", lambda cam, const, i, theta, gap, rate: Made(
        end=cam.stretches[i].end - theta, start=(i, theta, gap, rate)))  # fmt: skip
    cells = iter([0.25, 0.75, 2.0, 1.0])

    def climb(cam, const, i, f, step, flat, load):
        size = next(cells)
        flown.append((*f.start, step))
        return size, f.start[2] + 1.0, 0.5

    monkeypatch.setattr(loads_module, "_climb", climb)
    loads_module._fly(made, None, 1.0, 0.0, 0.75, 4.0, Loads())
    assert flown == [
        (0, 1.0, 0.0, 0.75, 1.0), (0, 1.25, 1.0, 0.5, 0.5), (1, 2.0, 2.0, 0.25, 2.0),
        (2, 4.0, 3.0, 0.0, 1.0),
    ]  # fmt: skip


# -- tables


@pytest.mark.parametrize("x", [0.0, 0.25, -0.375])
def test_the_table_of_a_cam_has_its_polynomials_one_behind_the_other(x):
    """Two pieces of one rad of random numbers; about their middles, with what doubles leave out."""
    random = np.random.default_rng(3)
    rows = random.normal(size=(2, cam_table.PIECE))
    rows[:, 0] = (1.5, 2.5)
    one = Made(start=1.0, end=3.0, per_angle=1.0, piece_count=2, first_piece=0, dwell=0)
    made = Made(stretches=[one], pieces=list(rows.ravel()))
    for k, row in enumerate(rows):
        theta = row[0] + x

        def of(order, row=row):
            first = cam_table.LIFT + order * cam_table.TERMS
            coefficients = row[first : first + cam_table.TERMS]
            return float(np.polynomial.Polynomial(coefficients)(x)), float(coefficients[0])

        assert cam_table.piece_at(made, 0, theta) == k * cam_table.PIECE
        assert cam_table.lift(made, 0, theta) == pytest.approx([of(n)[0] for n in range(3)])
        assert cam_table.higher(made, 0, theta) == pytest.approx([of(n)[0] for n in range(3, 7)])
        for order in range(1, 7):
            found = cam_table.derivative(made, order, 0, theta)
            assert found == pytest.approx(of(order)[0])
        level, gain, slope, bend, c2 = cam_table.lift_parts(made, 0, theta)
        assert (level, slope) == (of(0)[1], of(1)[1])
        assert gain == pytest.approx(of(0)[0] - level + row[cam_table.LIFT_REST])
        assert bend == pytest.approx(of(1)[0] - slope + row[cam_table.SLOPE_REST])
        assert c2 == pytest.approx(of(2)[0])
    assert cam_table.piece_at(made, 0, 3.0) == cam_table.PIECE  # its end is in the last one
    one.dwell, one.start_c = 1, 0.75
    assert cam_table.lift(made, 0, 2.0) == (0.75, 0.0, 0.0)
    assert cam_table.derivative(made, 3, 0, 2.0) == 0.0
    first = rows[0]
    parts = (first[cam_table.LIFT], first[cam_table.LIFT_REST], 0.0, first[cam_table.SLOPE_REST])
    assert cam_table.lift_parts(made, 0, 2.0) == (*parts, 0.0)


def test_a_boundary_belongs_to_the_stretch_that_begins_there():
    made = turned()
    found = [stretch_at(made, theta) for theta in (0.0, 1.9, 2.0, 3.9, 4.0, 6.2)]
    assert found == [0, 0, 1, 1, 2, 2]
    ends = Made(start=1.0, end=2.0, dwell=1, start_c=9.0)
    for side, numbers in (("start", (1.0, 2.0, 3.0)), ("end", (4.0, 5.0, 6.0))):
        for name, number in zip(("c", "c1", "c2"), numbers, strict=True):
            setattr(ends, f"{side}_{name}", number)
    one = Made(stretches=[ends])
    assert [lift_at(one, 0, x)[0] for x in (1.0, 1.5, 2.0)] == [1.0, 1.0, 4.0]
    assert lift_at(one, 0, 2.0) == (4.0, 5.0, 6.0)
