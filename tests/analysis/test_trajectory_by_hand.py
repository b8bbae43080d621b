"""The rows of a trajectory, of a record worked by hand: flights, an impact, hops, a rest.

c = 0.02 + 0.005 (1 - cos theta) m, on which a follower without a spring falls with 9.81 m/s2. The
strobe is at 2.25 rad, and there are four rows a turn besides those of the events.
"""

from __future__ import annotations

from math import copysign, cos, degrees, pi, sin
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from conftest import settings

from camcli.analysis import simulate as module
from camcli.analysis.integrate import Cost
from camcli.analysis.labels import Label
from camcli.analysis.simulate import Chatter, Simulation, _hopping, _Sampler, _Start
from camcli.cams.eccentric import EccentricCam
from camcli.errors import Status
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.system import Follower, System

TURN = 2.0 * pi
STROBE = 2.25
RPM = 240.0
OMEGA = RPM * pi / 30.0
R = 0.625
FALL = 9.81 / OMEGA**2  # m/rad2
FOLLOWER = Follower(mass=2.0, stiffness=0.0, gravity=9.81, restitution=R)


def machine() -> System:
    return System.build(FOLLOWER, EccentricCam(kind="eccentric", base=0.02, lift=0.01), STROBE)


def cam(s):
    """(c, c') so many rad after the strobe."""
    return 0.02 + 0.005 * (1.0 - cos(STROBE + s)), 0.005 * sin(STROBE + s)


def hop(chatter, s):
    """Hop after hop, each shorter and slower by the restitution; their lengths add up to all."""
    u, length, r = chatter
    begin, long = 0.0, (1.0 - r) * length
    while begin + long < s:
        begin, long, u = begin + long, r * long, r * u
    y = (s - begin) / long
    return u * long * y * (1.0 - y), u * (1.0 - 2.0 * y)


@pytest.mark.parametrize("s", [0.0, 0.1, 0.56, 0.57, 0.9, 1.25, 1.45])
def test_hops_of_a_chatter_shrink_until_its_end(s):
    chatter = Chatter(0.3, 1.5, R)
    assert _hopping(chatter, s) == pytest.approx(hop(chatter, s), rel=1e-9, abs=1e-15)
    assert _hopping(chatter, 1.5 + s) == (0.0, 0.0)


def event(kind, turn, s, u):
    """An event so many rad after the strobe."""
    return kind, turn, (STROBE + s) % TURN, cam(s)[0], u


EVENTS = [
    event(IMPACT, 0, 1.25, -0.005), event(IMPACT, 0, 2.75, -0.002), event(CHATTER, 0, 4.25, 0.0),
    event(DETACHMENT, 1, 6.0, 0.0), event(IMPACT, 2, 0.75, -0.004),
    event(IMPACT, 2, 2.0, -0.003),
]  # fmt: skip
STATES = [(0.03, 0.004), cam(0.0), (0.06, -0.003), (9.0, 9.0)]  # at the strobes


def sampler(status, events=EVENTS, states=STATES, periods=2):
    system = machine()
    orbit = Stub(system=system, const=system.constants(RPM, 1e-9, 1000), omega=OMEGA)
    q, w = np.array(states).T
    record = Stub(events=lambda: events, strobe_q=q, strobe_w=w, periods=periods, status=status)
    return _Sampler(system, orbit, record, 4), record, orbit


def row(turn, s, q, w, contact):
    c, c1 = cam(s)
    return ((TURN * turn + s) / OMEGA, degrees((STROBE + s) % TURN), c if q is None else q,
            w * OMEGA, c, c1 * OMEGA, contact)  # fmt: skip


def falling(turn, s, begin, state):
    q, w = state
    t = s - begin
    return row(turn, s, q + w * t - 0.5 * FALL * t * t, w - FALL * t, "flight")


def resting(turn, s):
    return row(turn, s, None, cam(s)[1], "sticking")


def expected():
    """The rows of two whole turns, and of a third one up to its last impact."""
    quarter = [k * pi / 2.0 for k in range(4)]
    lift_off = 6.0
    chatter = Chatter(R * 0.002, 1.5, R)
    gap, rate = hop(chatter, quarter[2] - 2.75)
    c, c1 = cam(quarter[2])
    bounced = cam(1.25)[0], cam(1.25)[1] + R * 0.005
    whole = [
        falling(0, 0.0, 0.0, STATES[0]),
        row(0, 1.25, None, cam(1.25)[1] - 0.005, "flight"),
        row(0, 1.25, None, bounced[1], "flight"),
        falling(0, quarter[1], 1.25, bounced),
        row(0, 2.75, None, cam(2.75)[1] - 0.002, "flight"),
        row(0, 2.75, None, cam(2.75)[1] + R * 0.002, "flight"),
        row(0, quarter[2], c + gap, c1 + rate, "flight"),
        resting(0, 4.25), resting(0, quarter[3]),
        *(resting(1, s) for s in quarter),
        row(1, lift_off, None, cam(lift_off)[1], "flight"),
    ]  # fmt: skip
    cut = [
        falling(2, 0.0, 0.0, STATES[2]),
        row(2, 0.75, None, cam(0.75)[1] - 0.004, "flight"),
        row(2, 0.75, None, cam(0.75)[1] + R * 0.004, "flight"),
        falling(2, quarter[1], 0.75, (cam(0.75)[0], cam(0.75)[1] + R * 0.004)),
        row(2, 2.0, None, cam(2.0)[1] - 0.003, "flight"),
        row(2, 2.0, None, cam(2.0)[1] + R * 0.003, "flight"),
    ]
    return whole, cut


def same(found, wanted):
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        assert one[:-1] == pytest.approx(other[:-1], rel=1e-11, abs=1e-15)
        assert one[-1] == other[-1]


@pytest.mark.parametrize("status", [Status.OK, Status.IMPACT_BUDGET])
def test_the_rows_of_a_record(status):
    """A turn that is cut off has rows up to its last event, if the run ended in trouble there."""
    whole, cut = expected()
    found = list(sampler(status)[0].rows(_Start(STROBE, 0.0, 0.0)))
    same(found, whole if status == Status.OK else [*whole, *cut])


@pytest.mark.parametrize("at_rest", [True, False])
def test_the_rows_before_the_first_strobe(at_rest):
    """The run starts more than a quarter of a turn before it, at rest or above the cam.

    The first whole turn begins at rest where its state is that of the cam.
    """
    begin = 1.4 * pi
    lift_off = 4.6
    events = [event(DETACHMENT, -1, lift_off, 0.0)]
    theta = (STROBE + begin) % TURN
    one, record, _ = sampler(Status.OK, events, [cam(0.0)] * 2, 1)
    _, start_c, start_c1 = one._lift(begin)
    start = _Start(theta, start_c if at_rest else start_c + 0.01, start_c1)
    rows = list(one.rows(start))
    left = cam(lift_off)
    same(rows[:2], [row(-1, lift_off, None, left[1], "flight"),
                    falling(-1, 1.5 * pi, lift_off, left)])  # fmt: skip
    _, strobe_c, strobe_c1 = one._lift(0.0)
    record.strobe_q[:], record.strobe_w[:] = strobe_c, strobe_c1
    rows = list(one.rows(start))
    assert [one_row[-1] for one_row in rows[2:]] == ["sticking"] * 4
    assert one._rested(module._Node(begin, start.q, start.w, False)).sticking is at_rest
    off = module._Node(begin, start.q, start.w + 1e-9, True)
    assert not one._rested(off).sticking


@pytest.mark.parametrize("thrown", [0.0, 0.25])
def test_the_events_of_a_record(monkeypatch, thrown):
    """A follower that departs may be thrown off, here with 0.25 m/rad."""
    monkeypatch.setattr(module, "thrown_off", lambda cam, theta: thrown)
    _, record, orbit = sampler(Status.OK)
    found = list(module._events(record, orbit, STROBE))
    for one, (kind, turn, theta, q, u) in zip(found, EVENTS, strict=True):
        s = (theta - STROBE) % TURN
        left = {IMPACT: -R * u, CHATTER: 0.0, DETACHMENT: thrown}
        assert one.seconds == pytest.approx((TURN * turn + s) / OMEGA)
        assert (one.turn, one.q) == (turn, q)
        assert one.phase == pytest.approx(degrees(theta))
        assert one.u_before == pytest.approx(u * OMEGA)
        assert one.u_after == pytest.approx(left[kind] * OMEGA)
    assert [one.kind for one in found] == [
        "impact", "impact", "chatter", "detachment", "impact", "impact",
    ]  # fmt: skip


@pytest.mark.parametrize("label", ["contact", "aperiodic", "P(1;1)"])
@pytest.mark.parametrize("forgets", [True, False])
def test_a_record_that_cannot_tell_is_followed(monkeypatch, label, forgets):
    """What a record further on and the motion cost is counted, not the record that is there."""
    first, last = Stub(cost=Cost(9, 9, 9)), Stub(cost=Cost(1, 2, 4))
    ends = Stub(label="P(2;1:1)", cost=Cost(10, 20, 40))
    monkeypatch.setattr(module, "classify_at", lambda *given: ends if given == (1, 2, 3) else None)
    for by, cost in ((last, Cost(1, 2, 4)), (first, Cost())):
        monkeypatch.setattr(module, "named_on", lambda *given, by=by: (label, None, by))
        monkeypatch.setattr(
            module, "forgets_too_much", lambda record, by=by: forgets and record is by
        )
        found = module._named(1, 2, 3, "orbit", first)
        if label == "aperiodic" or forgets:
            assert found == ("P(2;1:1)", ends, cost + ends.cost)
        else:
            assert found == (label, None, cost)


def test_an_event_at_a_phase_of_the_grid_has_the_row_of_the_grid_behind_it():
    """A record that ends with one has no row of the grid there."""
    quarter = pi / 2.0
    events = [event(IMPACT, 0, quarter, -0.005), event(IMPACT, 1, quarter, -0.004)]
    states = [(0.03, 0.004), (0.06, -0.003)]
    one, _, _ = sampler(Status.IMPACT_BUDGET, events, [*states, (9.0, 9.0)], 1)
    bounced = cam(quarter)[0], cam(quarter)[1] + R * 0.005
    cut = cam(quarter)[1] + R * 0.004
    same(list(one.rows(_Start(STROBE, 0.0, 0.0))), [
        falling(0, 0.0, 0.0, states[0]),
        row(0, quarter, None, cam(quarter)[1] - 0.005, "flight"),
        row(0, quarter, None, bounced[1], "flight"),
        *(falling(0, k * quarter, quarter, bounced) for k in (1, 2, 3)),
        falling(1, 0.0, 0.0, states[1]),
        row(1, quarter, None, cam(quarter)[1] - 0.004, "flight"),
        row(1, quarter, None, cut, "flight"),
    ])  # fmt: skip


def test_the_phase_of_a_whole_turn_is_zero():
    one, _, _ = sampler(Status.OK)
    one.strobe = pi
    assert one._lift(pi)[0] == 0.0
    assert one._lift(0.0)[0] == pi
    assert module._since(STROBE, STROBE) == 0.0
    assert module._since(0.25, STROBE) == pytest.approx(TURN - 2.0)


def test_what_becomes_of_a_follower_at_an_event(monkeypatch):
    """Thrown off where the slope jumps down; without a bounce it rests, where it is pressed."""
    one, _, _ = sampler(Status.OK)
    monkeypatch.setattr(module, "thrown_off", lambda cam, theta: 0.125)
    _, c, c1 = one._lift(1.25)
    left = one._after((DETACHMENT, 0, STROBE + 1.25, c, 0.0), None)
    assert (left.s, left.q, left.w) == pytest.approx((1.25, c, c1 + 0.125))
    assert (left.sticking, left.chatter) == (False, None)
    for r, u, pressed, rests in (
        (0.0, -0.5, -1.0, True), (0.0, -0.5, 0.0, False), (0.0, -0.5, 1.0, False),
        (0.5, 0.0, -1.0, True), (0.5, -0.5, -1.0, False),
    ):  # fmt: skip
        monkeypatch.setattr(module, "restitution", lambda cam, const, theta, r=r: r)
        monkeypatch.setattr(module, "contact_accel", lambda *_, pressed=pressed: (pressed, 0, 0))
        struck = one._after((IMPACT, 0, STROBE + one.grid[1], one.lifts[1][1], u), None)
        assert struck.w == pytest.approx(one.lifts[1][2] - r * u)
        assert struck.sticking is rests


def test_a_follower_is_thrown_off_where_a_stretch_begins_with_a_fall(monkeypatch):
    """By the fall of the slope; a rise throws nothing, and nothing is no number below zero."""
    stretches = [Stub(start=0.5, slope_jump=-0.25), Stub(start=1.5, slope_jump=0.75),
                 Stub(start=2.5, slope_jump=0.0)]  # fmt: skip
    monkeypatch.setattr(module, "stretch_at", lambda cam, theta: int(theta - 0.5))
    for theta, rate in ((0.5, 0.25), (0.75, 0.0), (1.5, 0.0), (2.5, 0.0), (2.75, 0.0)):
        found = module.thrown_off(Stub(stretches=stretches), theta)
        assert found == rate
        assert copysign(1.0, found) == 1.0


def test_an_impact_without_a_rate_leaves_with_none():
    """Not with one of minus zero."""
    _, record, orbit = sampler(Status.OK, [event(IMPACT, 0, 1.25, 0.0)])
    (found,) = module._events(record, orbit, STROBE)
    assert (found.u_after, copysign(1.0, found.u_after)) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("label", "ends", "repeats", "turns"),
    [
        (Label((2.0, 1.0)), None, 2, [3, 4]), (Label((2.0, 1.0)), "ends", 0, [0, 1, 2, 3, 4]),
        ("aperiodic", None, 0, [0, 1, 2, 3, 4]), ("contact", None, 1, [4]),
    ],
)  # fmt: skip
def test_the_events_of_the_last_period(label, ends, repeats, turns):
    """All of them where the record does not repeat, whatever it leads to."""
    events = [Stub(turn=turn) for turn in range(5)]
    found = Simulation(700.0, [], events, label, 0, 5, [], None, None, ends)
    assert found.repeats == repeats
    assert [one.turn for one in found.last_period] == turns


@pytest.mark.parametrize("at_rest", [True, False])
def test_a_trajectory_begins_with_the_state_of_its_start(chapter, at_rest):
    """Before the first strobe: on the cam up to the corner, or in flight on its spring."""
    start = {"theta_deg": 100.0} if at_rest else {"theta_deg": 100.0, "q": 0.5, "v": 2.0}
    rpm = 190.0
    found = module.simulate(chapter, rpm, settings(0, 1, **start), 16, follow=False)
    rows = found.trajectory[:2]
    omega = rpm * pi / 30.0
    pull = (chapter.follower.stiffness / chapter.follower.mass) ** 0.5
    for (seconds, theta, q, v, c, c_dot, contact), phase in zip(rows, (112.5, 135.0), strict=True):
        assert theta == pytest.approx(phase)
        t = seconds + (TURN - 100.0 * pi / 180.0) / omega  # the first strobe is at zero
        if at_rest:
            assert (q, v, contact) == (c, c_dot, "sticking")
        else:
            assert q == pytest.approx(0.5 * cos(pull * t) + 2.0 / pull * sin(pull * t))
            assert v == pytest.approx(2.0 * cos(pull * t) - 0.5 * pull * sin(pull * t))
            assert contact == "flight"
