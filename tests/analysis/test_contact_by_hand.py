"""The parts of a certificate of contact, on cams of polynomials and straight lines worked by hand.

On a straight flank that falls by S m/rad a follower without a spring leaves at the rate S beyond
the cam and lands with the same rate: the impacts follow one another by the restitution alone.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import isfinite, pi
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from flint import arb
from mpmath import mp, mpf

from camcli.analysis.contact_loss import certificate as module
from camcli.analysis.contact_loss.certificate import (
    DIGITS,
    Hits,
    _at_start,
    _end,
    _force_cuts,
    _force_ends,
    _impacts,
    _is_smooth,
    _nearest_end,
    _phase,
    _place,
    _speed_of_hit,
    _text,
    corner_statement,
    detachment_statement,
    no_statement,
)
from camcli.analysis.contact_loss.detachment import NoStatement
from camcli.cams.balls import UndecidedError, precision
from camcli.exact.machine import BallMachine, BallStretch
from camcli.exact.motion import EndlessError
from camcli.exact.shooting import NotProvedError
from camcli.system import Follower

ENDS = (2.0, 3.5, 2.0 * pi)  # of three stretches, the last one as a double


@pytest.fixture(autouse=True)
def digits():
    with precision(DIGITS):
        yield


def cubic(start, end, *slopes) -> BallStretch:
    """A stretch whose lift has these derivatives, from c to c''', where it starts."""
    c, c1, c2, c3 = (arb(x) for x in slopes)
    return BallStretch(
        arb(start), end if isinstance(end, arb) else arb(end),
        lambda theta: c + (x := theta - start) * (c1 + x * (c2 / 2 + x * c3 / 6)), None,
    )  # fmt: skip


def three(first, second, third) -> list[BallStretch]:
    """A cam of three cubics; each has its derivatives where it starts."""
    return [
        cubic(0.0, ENDS[0], *first), cubic(ENDS[0], ENDS[1], *second),
        cubic(ENDS[1], 2 * arb.pi(), *third),
    ]  # fmt: skip


FOLLOWER = Follower(mass=2.0, stiffness=96.0, damping=1.5, gravity=9.81, preload=3.0)


def force(slopes, rpm, follower=FOLLOWER):
    """m omega^2 c'' + omega b c' + k c + m g + F0, N, of [c, c', c'']."""
    omega = mpf(rpm) * mp.pi / 30
    spring = follower.stiffness * slopes[0] + follower.mass * mpf(follower.gravity)
    return (
        follower.mass * omega**2 * slopes[2] + omega * follower.damping * slopes[1]
        + spring + follower.preload
    )  # fmt: skip


def at(slopes, x):
    """[c, c', c''] of a cubic x rad behind its start."""
    c, c1, c2, c3 = (mpf(one) for one in slopes)
    return [c + c1 * x + c2 * x**2 / 2 + c3 * x**3 / 6, c1 + c2 * x + c3 * x**2 / 2, c2 + c3 * x]


# -- where the force ends

HIGH = (0.5, 0.25, 0.375, -0.125)  # pressed at any speed of these tests
FALLS = (0.25, 0.125, 0.5, -0.75)  # c'' falls from 0.5 to -1, or to -0.625 after 1.5 rad
RISES = (0.375, 0.25, -0.875, 0.75)  # c'' rises from -0.875


@pytest.mark.parametrize("slopes", [FALLS, RISES, (0.25, 0.5, -0.125, -0.25)])
@pytest.mark.parametrize("at_end", [False, True])
def test_the_force_ends_at_the_speed_of_a_quadratic(slopes, at_end):
    machine = BallMachine(three(HIGH, slopes, HIGH), FOLLOWER, 1.0)
    rpm = _force_ends(machine, 1, at_end)
    with mp.workdps(50):
        there = at(slopes, mpf(1.5) if at_end else mpf(0))
        assert (rpm is not None) == (there[2] < 0)
        if rpm is not None:
            found = mpf(rpm.str(50, radius=False))
            assert abs(force(there, found)) < mpf(10) ** -40
            assert force(there, found * (1 - mpf(10) ** -9)) > 0
            assert force(there, found * (1 + mpf(10) ** -9)) < 0


@pytest.mark.parametrize(
    ("slopes", "is_lost"),
    [
        ((-1.0, 0.5, -0.125, 0.0), False),  # pulled at rest, and too little damping
        ((-1.0, -40.0, -0.125, 0.0), False),  # it would end at two speeds below zero
        ((-1.0, 40.0, -0.125, 0.0), True),  # the damping presses between two speeds
        ((0.5, -40.0, 0.125, 0.0), False),  # where the cam bends upwards it counts nowhere
    ],
)
def test_where_the_force_ends_at_no_speed(slopes, is_lost):
    machine = BallMachine(three(slopes, HIGH, HIGH), FOLLOWER, 1.0)
    assert (_force_ends(machine, 0, False) is not None) == is_lost


def first_at(theta, rpm=100.0):
    return Stub(theta=theta, rpm=rpm, finite=isfinite(rpm))


@pytest.mark.parametrize(
    ("cam", "theta", "lost"),
    [
        ((HIGH, FALLS, RISES), ENDS[1], (2, False)),  # sooner behind the corner than before it
        ((HIGH, (0.25, 0.125, 0.5, -1.0), RISES), ENDS[1], (1, True)),
        ((HIGH, FALLS, HIGH), ENDS[1], (1, True)),  # only before it
        ((HIGH, RISES, HIGH), ENDS[0], (1, False)),
        ((RISES, HIGH, HIGH), 0.0, (0, False)),
        ((HIGH, HIGH, (0.25, 0.125, 0.5, -0.5)), 0.0, (2, True)),  # the last one is before it
        ((HIGH, HIGH, HIGH), ENDS[1], None),
        ((HIGH, FALLS, RISES), 3.25, None),  # no corner
        ((RISES, HIGH, (0.375, 0.25, -0.75, 0.75)), ENDS[1], None),  # lost elsewhere before
    ],
)
def test_contact_holds_up_to_the_lower_speed_of_both_sides_of_a_corner(cam, theta, lost):
    system = Stub(shape=three(*cam), follower=FOLLOWER)
    found = detachment_statement(system, first_at(theta))
    assert (found is not None) == (lost is not None)
    if lost is None:
        return
    assert (found["kind"], found["stretch"], found["at_end"]) == ("first-detachment", *lost)
    lengths = [2.0, 1.5, 2.0 * pi - 3.5]
    stretch, at_end = lost
    with mp.workdps(50):
        low, high = mpf(found["low"]), mpf(found["high"])
        end = 2 * mp.pi - mpf(3.5) if stretch == 2 else mpf(lengths[stretch])
        there = at(cam[stretch], end if at_end else mpf(0))
        assert force(there, low) > 0 > force(there, high)
        assert abs((high - low) / (low + high) - mpf(10) ** -27) < mpf(10) ** -33
        assert len(found["cuts"]) == 3
        for slopes, length in zip(cam, lengths, strict=True):
            assert min(force(at(slopes, mpf(x)), low) for x in np.linspace(0, length, 60)) > 0
    numbers = {"mass": "2", "stiffness": "96", "damping": "1.5", "preload": "3", "rpm": None}
    assert numbers.items() <= found["constants"].items()
    assert Fraction(found["constants"]["gravity"]) == Fraction(9.81)


def random_lift(rng):
    """(a stretch from 0.5 to 2.5, its lift as a polynomial, damping and spring of the force)."""
    terms = rng.uniform(-1.0, 1.0, 6)
    lift = np.polynomial.Polynomial(terms)

    def ball(theta):
        total = arb(0)
        for term in terms[::-1]:
            total = total * theta + arb(float(term))
        return total

    z2, w2 = rng.uniform(0.5, 3.0, 2)
    return BallStretch(arb(0.5), arb(2.5), ball, None), lift, float(z2), float(w2)


@pytest.mark.parametrize("seed", range(12))
def test_a_stretch_is_cut_where_the_force_is_above_zero_and_else_not(seed):
    """The weight makes the least force of all a little more than zero, or a little less."""
    stretch, lift, z2, w2 = random_lift(np.random.default_rng(seed))
    rest = lift.deriv(2) + z2 * lift.deriv(1) + w2 * lift
    inside = [x.real for x in rest.deriv().roots() if abs(x.imag) < 1e-9 and 0.5 < x.real < 2.5]
    least = min(rest(x) for x in (0.5, 2.5, *inside))
    above = Stub(Z2=arb(z2), W2=arb(w2), G=arb(float(-least + 1e-3)))
    cuts = _force_cuts(above, stretch)
    ends = [0.5, *(float(text) for text in cuts), 2.5]
    assert all(a < b for a, b in pairwise(ends))
    assert len(cuts) < 40
    below = Stub(Z2=arb(z2), W2=arb(w2), G=arb(float(-least - 1e-6)))
    with pytest.raises(UndecidedError):
        _force_cuts(below, stretch)


def test_a_force_that_rises_or_falls_needs_no_cuts_and_ends_where_it_is_zero():
    """c = x^3/6 from 1 to 2: the force is x + G, or with the sign changed G - x."""
    for sign, weight, is_held in (
        (1, -0.999, True), (1, -1.001, False), (1, -2.5, False),
        (-1, 2.001, True), (-1, 1.999, False), (-1, 0.5, False),
    ):  # fmt: skip
        stretch = BallStretch(arb(1), arb(2), lambda x, sign=sign: sign * x**3 / 6, None)
        machine = Stub(Z2=arb(0), W2=arb(0), G=arb(weight))
        if is_held:
            assert _force_cuts(machine, stretch) == []
        else:
            with pytest.raises(UndecidedError):
                _force_cuts(machine, stretch)


# -- whether there is a statement

SMOOTH = (0.5, 0.25, -0.25, 0.0), (0.75, -0.25, 0.5, 0.0), (0.125, 0.5, 0.0, 0.0)


def test_a_cam_is_smooth_whose_slope_jumps_at_no_corner():
    """Slopes from 0.25 to -0.25, from there to 0.5, and from there to 0.25 at last."""
    last = (0.125, 0.5, -0.25 / (2 * pi - 3.5), 0.0)

    def stretches(*shift):
        parts = [
            (c, c1 + more, c2, c3)
            for (c, c1, c2, c3), more in zip((*SMOOTH[:2], last), shift, strict=True)
        ]
        cam = three(*parts)
        exactly = arb(-0.25) / (2 * arb.pi() - ENDS[1])
        theta_3 = arb(ENDS[1])
        slope = arb(0.5 + shift[2])
        cam[2] = BallStretch(
            theta_3, 2 * arb.pi(),
            lambda x: slope * (x - theta_3) + exactly * (x - theta_3) ** 2 / 2, None,
        )  # fmt: skip
        return Stub(shape=cam, follower=FOLLOWER)

    assert _is_smooth(stretches(0, 0, 0))
    assert _is_smooth(stretches(0.125, 0.125, 0.125))
    for shift in ((1e-9, 0, 0), (0, 1e-9, 0), (0, 0, -1e-9)):
        assert not _is_smooth(stretches(*shift))
    for shift in ((0, 1e-9, 1e-9), (1e-9, 1e-9, 0), (1e-9, 0, 1e-9)):  # one corner only is smooth
        assert not _is_smooth(stretches(*shift))


def test_why_there_is_no_statement_of_the_first_detachment(monkeypatch):
    smooth = [True]
    monkeypatch.setattr(module, "_is_smooth", lambda system: smooth[0])
    system = Stub(shape=three(HIGH, FALLS, RISES), follower=FOLLOWER)
    plain = {"kind": "arcs", "stretches": [{"seat": False}, {"seat": False}]}
    seated = {"kind": "arcs", "stretches": [{"seat": False}, {"seat": True}]}
    fitted = {"kind": "pieces", "stretches": [{"seat": False}]}
    corner, inside = first_at(3.5), first_at(3.4)

    def why(first, cam=plain):
        return no_statement(system, Stub(first=first), cam)

    assert why(corner) is None
    assert why(first_at(0.0)) is None
    assert why(corner, None) is NoStatement.LASH
    assert why(corner, seated) is NoStatement.LASH
    assert why(corner, {**seated, "kind": "pieces"}) is NoStatement.LASH
    assert why(corner, fitted) is NoStatement.FITTED
    assert why(inside) is NoStatement.INSIDE
    assert why(None) is NoStatement.NO_SPEED
    assert why(first_at(3.4, float("inf"))) is NoStatement.NO_SPEED
    smooth[0] = False
    assert why(corner) is why(None) is why(inside) is NoStatement.KINKED
    assert why(corner, fitted) is NoStatement.FITTED
    assert why(corner, seated) is NoStatement.LASH


# -- numbers and places


def test_texts_have_fewer_digits_than_are_known():
    for x, value in (
        (arb(1) / 3, Fraction(1, 3)), (arb(-2) / 7 * 10**70, Fraction(-2, 7) * 10**70),
        (arb(5) / 9 / 10**30, Fraction(5, 9) / 10**30), (arb(0.375), Fraction(3, 8)),
    ):  # fmt: skip
        text = _text(x)
        assert "+" not in text
        assert "[" not in text
        assert abs(Fraction(text) / value - 1) < Fraction(1, 10**49)
        assert len(text.strip("-").split("e")[0].replace(".", "").lstrip("0")) <= 50


def test_the_ends_of_a_range_of_speeds_lie_on_either_side():
    rpm = arb(700) / 3
    for side in (1, -1):
        end = _end(rpm, side)
        assert end.is_exact()
        assert abs(float((end - rpm) / rpm) - side * 1e-27) < 1e-36


def corners(*ends):
    """Stretches from 0 to each end in turn."""
    return [
        Stub(start=arb(a), end=b if isinstance(b, arb) else arb(b))
        for a, b in pairwise((0.0, *ends))
    ]


def test_the_stretch_that_starts_at_a_phase():
    stretches = corners(1.0, 2.5, 2 * arb.pi())
    for k, start in enumerate((0.0, 1.0, 2.5)):
        for off in (0.0, 0.9e-9, -0.9e-9):
            assert _at_start(stretches, start + off) == k
        for off in (1.1e-9, -1.1e-9):
            assert _at_start(stretches, start + off) is None
    assert _at_start(stretches, 2.0 * pi) is None


@pytest.mark.parametrize(
    ("phase", "end"),
    [
        (0.9, (0, 0)), (1.7, (0, 0)), (1.8, (1, 0)), (2.6, (1, 0)), (5.0, (2, 0)),
        (2 * pi + 0.2, (2, 0)), (2 * pi + 0.6, (0, 1)), (2 * pi + 2.4, (1, 1)),
        (4 * pi - 0.1, (2, 1)), (4 * pi + 0.1, (2, 1)), (6 * pi + 1.1, (0, 3)),
    ],
)  # fmt: skip
def test_the_end_of_a_stretch_that_is_next_to_a_phase(phase, end):
    """Ends at 1, 2.5 and 2 pi, which the first stretch of the next turn follows."""
    stretches = corners(1.0, 2.5, 2 * arb.pi())
    found = _nearest_end(stretches, phase)
    assert found == end
    where = (1.0, 2.5, 2.0 * pi)[end[0]] + 2.0 * pi * end[1]
    assert float(_phase(stretches, found)) == pytest.approx(where, rel=1e-15)


def test_the_stretch_that_holds_a_phase():
    stretches = corners(1.0, 2.5, 2 * arb.pi())
    for k, phase in enumerate((0.4, 1.9, 5.5)):
        for turn in (0, 1, 3, -1):
            assert _place(stretches, arb(phase, 0.3) + 2 * arb.pi() * turn) == (k, turn)
    for phase in (arb(1), arb(0.9, 0.2), arb(2.6, 0.2), arb(1.7, 2), arb(0), 2 * arb.pi()):
        with pytest.raises(UndecidedError):
            _place(stretches, phase)


# -- impacts on a straight flank

S = 0.25  # m/rad: how fast the flank falls
BALL = Follower(mass=2.0, gravity=9.81, restitution=1.25, stiffness=0.0, damping=0.0, preload=0.0)


def flank(start: int) -> list[BallStretch]:
    """Stretches with ends at 2, 3.5 and 2 pi; straight from the start of one of them on.

    From stretch 2 on the flank goes on in the next turn, over stretch 0.
    """
    ends = [arb(2), arb(3.5), 2 * arb.pi()]
    starts = [arb(0), *ends[:2]]

    def straight(k, turns):
        return BallStretch(
            starts[k], ends[k],
            lambda x: arb(2) - S * (x + 2 * arb.pi() * turns - starts[start]), None,
        )  # fmt: skip

    if start == 1:
        return [BallStretch(starts[0], ends[0], None, arb(2)), straight(1, 0), straight(2, 0)]
    low = arb(2) - S * (2 * arb.pi() - 1.5)  # where stretch 0 ends
    return [straight(0, 1), BallStretch(starts[1], ends[1], None, low), straight(2, 0)]


def landings(rpm, count):
    """Angles from the lift-off to each impact: the flights last 2 S r^k omega^2/g."""
    omega2 = (mpf(rpm) * mp.pi / 30) ** 2
    first = 2 * S * omega2 / mpf(9.81)
    return [first * sum(mpf(1.25) ** j for j in range(k + 1)) for k in range(count)]


def speed_of(angle, impact):
    """rpm at which so many impacts take so many rad."""
    share = sum(mpf(1.25) ** j for j in range(impact))
    return mp.sqrt(mpf(9.81) * angle / (2 * S * share)) * 30 / mp.pi


@pytest.mark.parametrize("start", [1, 2])
def test_impacts_of_a_follower_that_leaves_at_a_corner(start):
    system = Stub(follower=BALL, strobe=0.0)
    found = _impacts(system, flank(start), start, arb(30), 3)
    assert (len(found.theta), len(found.v)) == (3, 3)
    with mp.workdps(50):
        wanted = [ENDS[start - 1] + angle for angle in landings(30, 3)]
        for theta, exact in zip(found.theta, wanted, strict=True):
            assert abs(mpf(theta.str(50, radius=False)) - exact) < mpf(10) ** -40
    for k, v in enumerate(found.v):
        assert float(v) == pytest.approx(S * 1.25 ** (k + 1), rel=1e-12)


@pytest.mark.parametrize("blind", [0.0, 1e-25])
def test_the_speed_at_which_the_last_impact_meets_a_corner(blind):
    """theta = 0.3 + (rpm/100)^2: 3.5 in the next turn; near to it the balls may see nothing."""
    exact = 100 * (arb(3.2) + arb("0") + 2 * arb.pi()).sqrt()
    goal = arb(3.5) - arb(3.2)
    tried = []

    def impacts(rpm):
        tried.append(rpm)
        if blind and abs(rpm - exact) < blind:
            raise UndecidedError
        return Hits([arb(9), goal + (rpm / 100) ** 2], [arb(1), arb(2)])

    stretches = corners(2.0, 3.5, 2 * arb.pi())
    corner, rpm = _speed_of_hit(stretches, impacts, Stub(rpm=float(exact) * (1 + 3e-7)))
    assert corner == (1, 1)
    assert abs(rpm - exact) < max(blind, 1e-37)
    assert rpm.is_exact()
    assert len(tried) < 12


@pytest.mark.parametrize(
    ("start", "impact", "corner", "angle"),
    [(1, 1, (1, 0), 1.5), (1, 3, (1, 0), 1.5), (2, 2, (0, 1), None)],
)
def test_an_impact_on_a_corner_is_stated(monkeypatch, start, impact, corner, angle):
    """Through all flights: what each begins with, and that only the first one lifts off."""
    flights = []

    def divided(shooting, hull, k, lifts):
        flights.append((shooting, hull, k, lifts))
        return f"flight {k}"

    monkeypatch.setattr(module, "divided_flight", divided)
    monkeypatch.setattr(module, "Shooting", lambda **given: Stub(**given))
    system = Stub(shape=flank(start), follower=BALL, strobe=0.0)
    with mp.workdps(50):
        angle = mpf(angle) if angle else 2 * mp.pi + 2 - mpf(3.5)
        rpm = speed_of(angle, impact)
        angles = landings(rpm, impact)
        hit = Stub(rpm=float(rpm) * (1 + 1e-10), impact=impact)
        found = corner_statement(system, hit, ENDS[start - 1])
        assert mpf(found["low"]) < rpm < mpf(found["high"])
        assert mpf(found["high"]) / mpf(found["low"]) - 1 < mpf(10) ** -26
        assert (found["kind"], found["start"]) == ("corner-hit", start)
        assert found["corner"] == {"stretch": corner[0], "turn": corner[1]}
        assert len(found["impacts"]) == impact - 1
        for row, way in zip(found["impacts"], angles, strict=False):
            phase = ENDS[start - 1] + way
            turn = int(phase // (2 * mp.pi))
            stretch = sum(phase - 2 * mp.pi * turn > end for end in ENDS)
            assert (row["stretch"], row["turn"]) == (stretch, turn)
            within = phase - 2 * mp.pi * turn
            assert within - mpf(row["low"]) == pytest.approx(1e-12, rel=1e-3)
            assert mpf(row["high"]) - within == pytest.approx(1e-12, rel=1e-3)
        assert found["flights"] == [f"flight {k}" for k in range(impact)]
        assert [(k, lifts) for _, _, k, lifts in flights] == [(k, k == 0) for k in range(impact)]
        shooting, hull = flights[-1][:2]
        assert len(hull) == 2 * impact + 3
        assert hull[0].contains(arb(ENDS[start - 1]))
        for k, way in enumerate(angles):
            place = shooting.places[k + 1]
            phase = ENDS[start - 1] + way - 2 * mp.pi * place.turn
            assert float(hull[2 * k + 2]) == pytest.approx(float(phase), rel=1e-9)
            rate = 0.0 if k == impact - 1 else S * 1.25 ** (k + 1)
            assert float(hull[2 * k + 3].mid()) == pytest.approx(rate, abs=1e-10)
        assert hull[1] == 0
        assert hull[-1].contains(arb(mp.nstr(rpm, 50)).mid())
    assert (shooting.places[0], shooting.places[-1]) == ((start, 0), corner)
    assert (shooting.parameter, shooting.rpm, shooting.turns) == ("rpm", None, corner[1] + 1)
    assert (shooting.shape, shooting.follower) == (system.shape, BALL)
    assert (found["constants"]["rpm"], found["constants"]["restitution"]) == (None, "1.25")


def test_an_impact_that_is_not_stated(monkeypatch):
    """No corner to leave at, a seat of its own, or a proof that fails in any way that is known."""
    asked = []

    def stated(system, stretches, start, hit):
        asked.append((start, hit))
        if isinstance(hit, Exception):
            raise hit
        return "stated"

    monkeypatch.setattr(module, "_corner_statement", stated)
    seated = Follower(mass=2.0, stiffness=0.0, seat_restitution=0.5)
    system = Stub(shape=flank(1), follower=BALL)
    assert corner_statement(system, "hit", 3.5) == "stated"
    assert corner_statement(system, "hit", 3.4) is None
    assert corner_statement(Stub(shape=flank(1), follower=seated), "hit", 3.5) is None
    assert asked == [(2, "hit")]
    for failed in (UndecidedError(), NotProvedError("step"), EndlessError(), ZeroDivisionError()):
        assert corner_statement(system, failed, 2.0) is None
    with pytest.raises(KeyError):
        corner_statement(system, KeyError("unknown"), 2.0)
