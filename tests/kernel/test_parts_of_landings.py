"""Parts of the enclosed landing as plain Python, on flights and errors made by hand."""

from __future__ import annotations

from types import SimpleNamespace as Made

import pytest

from camcli.kernel import enclosed_landing as landing
from camcli.kernel.enclosed_landing import COLUMNS, ERROR, SIZE, UNDECIDED, Ball, Gap, Leap

CONST = Made(G=3.0, W2=4.0, W=2.0, Z=0.25, D=0.0625 - 4.0)
LIFT = (0.5, -0.25, 0.75, -1.5)  # c to c'''
ERRORS = (0.001, 0.002, 0.004, 0.008, 0.016)  # of c and its derivatives
SIZES = (1.0, 2.0, 3.0, 5.0, 7.0)
DTHETA, DRATE = 0.03125, 0.0078125


def leap_of(**values) -> Leap:
    return Leap(**{**dict.fromkeys(Leap._fields, 0.0), **values})


def gap_of(**values) -> Gap:
    return Gap(**{**dict.fromkeys(Gap._fields, 0.0), **values})


def room_of(theta=0.5, rate=0.8) -> list[float]:
    room = [0.0] * COLUMNS
    room[ERROR : ERROR + 5], room[SIZE : SIZE + 5] = ERRORS, SIZES
    room[landing.THETA], room[landing.RATE] = theta, rate
    room[landing.THETA_RADIUS], room[landing.RATE_RADIUS] = DTHETA, DRATE
    return room


def way(monkeypatch, *, fall=4.0, dfall=1.0, jerk=5.9, end=3.0, start=0.0, below=True,
        rate=0.8, drate=0.1, theta=0.5, z=0.25, w2=4.0):  # fmt: skip
    """How the landing of a flight is looked for, and how far the first step goes."""
    leap = leap_of(rate=rate, drate=drate, fall=fall, dfall=dfall, dtheta=0.001)
    room = room_of(theta, rate)
    for name, answer in (
        ("constants_of", Made(Z=z, W2=w2)), ("stretch_at", 0), ("_leap", leap),
        ("_jerk_bound", jerk), ("_gap_after", gap_of(g=-1.0 if below else 1.0)),
    ):  # fmt: skip
        monkeypatch.setattr(landing, name, lambda *given, answer=answer: answer)
    monkeypatch.setattr(landing, "_sharpened", lambda *given: (
        "quick", room[landing.ANGLE], *given[-3:]))  # fmt: skip
    monkeypatch.setattr(landing, "_follow", lambda *given: ("steps", given[-2]))
    return landing.enclose_landing(Made(stretches=[Made(start=start, end=end)]), room)


def test_a_hop_is_sharpened_at_once_where_it_is_concave_up_to_its_end(monkeypatch):
    """A hop is tried up to 2.5 rate/fall = 1/2, where gap'' is below zero for certain."""
    quick = ("quick", pytest.approx(0.4), 0.0, 0.0, pytest.approx(0.5))
    steps = ("steps", pytest.approx(0.5))
    assert way(monkeypatch) == quick
    assert way(monkeypatch, jerk=6.1) == steps  # 1 + 6.1/2 is above 4
    assert way(monkeypatch, jerk=7.9, dfall=0.0) == quick
    assert way(monkeypatch, jerk=8.1, dfall=0.0) == steps
    assert way(monkeypatch, end=1.0005) == steps  # ends within the error of the start
    assert way(monkeypatch, end=1.002) == quick
    assert way(monkeypatch, below=False) == steps
    assert way(monkeypatch, end=0.75) == ("steps", 0.25)
    for dfall in (4.0, 4.5):
        assert way(monkeypatch, dfall=dfall) == ("steps", 2.5)  # up to the end of the stretch
    assert way(monkeypatch, fall=-4.0) == ("steps", 2.5)


@pytest.mark.parametrize("changes", [
    {"drate": 0.8}, {"drate": 0.9}, {"start": 0.4995}, {"end": 0.5005}, {"theta": -0.1},
    {"theta": 6.5, "end": 8.0}, {"theta": float("nan")}, {"z": -0.1}, {"w2": -0.1},
])  # fmt: skip
def test_nothing_is_said_of_a_start_that_may_be_another(monkeypatch, changes):
    assert way(monkeypatch, **changes) == UNDECIDED


def test_the_errors_of_a_start_add_up(monkeypatch):
    """q'' = -G - W^2 q - 2 Z q' and q''' = -2 Z q'' - W^2 q', with the errors of q and q'."""
    monkeypatch.setattr(landing, "lift_at", lambda cam, i, theta: LIFT[:3])
    leap = landing._leap(None, CONST, room_of(), 0)
    w = -0.25 + 0.8
    q2 = -3.0 - 4.0 * 0.5 - 0.5 * w
    dq = 0.001 + 2.0 * DTHETA
    dw = 0.002 + 3.0 * DTHETA + DRATE
    dq2 = 4.0 * dq + 0.5 * dw
    energy = abs(-0.5 * q2 - 4.0 * w) + 2.0 * abs(q2) + 2.5 * dq2 + 4.0 * dw
    expected = (0.5, 0.5, w, 5.0, 5.0, 0.8, -q2 + 0.75, energy, DTHETA, DRATE, dq, dw,
                dq2 + 0.004 + 5.0 * DTHETA)  # fmt: skip
    assert leap == pytest.approx(expected, rel=1e-9)
    assert all(leap[k] >= expected[k] for k in range(7, len(expected)))
    const = Made(**{**vars(CONST), "G": -3.0})
    assert landing._leap(None, const, room_of(), 0).pull == 5.0  # |G| + W^2 |q|


@pytest.mark.parametrize("s", [0.25, 1.0])
def test_the_errors_of_a_gap_are_those_of_its_start_and_of_the_cam(monkeypatch, s):
    """W^2 s bounds how q' depends on the start in a short flight, and W in a long one."""
    monkeypatch.setattr(landing, "lift_at", lambda cam, i, theta: LIFT[:3])
    monkeypatch.setattr(landing, "derivative", lambda cam, order, i, theta: LIFT[3])
    monkeypatch.setattr(landing, "flow", lambda const, s: (0.5, 0.25, 0.125))
    cam = Made(stretches=[Made(start=0.0, end=6.0)])
    leap = leap_of(theta=0.5, q=1.5, w=2.0, force=9.0, dtheta=DTHETA, dq=0.01, dw=0.02)
    gap = landing._gap_after(cam, CONST, room_of(), leap, 0, 0.0, s)
    q = 1.5 + 2.0 * 0.5 - 9.0 * 0.125
    w = 2.0 * 0.25 - 9.0 * 0.5
    q2 = -3.0 - 4.0 * q - 0.5 * w
    q3 = -0.5 * q2 - 4.0 * w
    dq = 0.01 + s * 0.02
    dw = min(2.0, 4.0 * s) * 0.01 + 0.02
    dq2 = 4.0 * dq + 0.5 * dw
    expected = {
        "g": q - 0.5, "u": w + 0.25, "a": q2 - 0.75, "jerk": q3 + 1.5, "b": 0.5, "b1": 0.25,
        "dg": dq + 0.001 + 2.0 * DTHETA, "du": dw + 0.002 + 3.0 * DTHETA,
        "da": dq2 + 0.004 + 5.0 * DTHETA,
        "djerk": 0.5 * dq2 + 4.0 * dw + 0.008 + 7.0 * DTHETA,
    }  # fmt: skip
    for name, value in expected.items():
        assert getattr(gap, name) == pytest.approx(value, rel=1e-9), name
    assert all(getattr(gap, name) > expected[name] for name in ("dg", "du", "da", "djerk"))


def test_a_gap_is_looked_at_on_its_stretch_in_its_turn(monkeypatch):
    asked = []
    monkeypatch.setattr(landing, "lift_at", lambda cam, i, theta: asked.append(theta) or LIFT[:3])
    monkeypatch.setattr(
        landing, "derivative", lambda cam, order, i, theta: asked.append(theta) or 0
    )
    cam = Made(stretches=[Made(start=1.0, end=2.0)])
    for theta, wraps in ((0.5, 0.0), (1.5, 0.0), (2.5, 0.0), (1.5 + landing.TURN, 1.0)):
        leap = leap_of(theta=theta - 0.25)
        landing._gap_after(cam, CONST, room_of(), leap, 0, wraps, 0.25)
    assert asked == pytest.approx([1.0, 1.0, 1.5, 1.5, 2.0, 2.0, 1.5, 1.5])


def test_the_third_derivative_of_a_gap_is_bounded_by_the_energy_and_the_cam():
    cam = Made(stretches=[Made(jerk_max=50.0), Made(jerk_max=3.0)])
    bound = landing._jerk_bound(cam, room_of(), leap_of(energy=7.0), 1)
    assert bound == pytest.approx(7.0 + 3.0 + 0.008)
    assert landing._is_below(gap_of(g=-1.0, dg=0.9))
    assert not landing._is_below(gap_of(g=-1.0, dg=1.1))


@pytest.mark.parametrize(("g", "u", "a", "jerk", "h", "stays"), [
    (1.0, -1.0, 0.0, 0.0, 0.9, True), (1.0, -1.0, 0.0, 0.0, 1.1, False),
    (0.0, 1.0, -1.0, 0.0, 1.9, True), (0.0, 1.0, -1.0, 0.0, 2.1, False),
    (0.0, 1.0, 0.0, 6.0, 0.9, True), (0.0, 1.0, 0.0, 6.0, 1.1, False),
    (0.0, 0.0, 1.0, 0.0, 1.0, False), (-1.0, 9.0, 0.0, 0.0, 1.0, True),
    (1.0, -1.0, 2.0, 0.0, 1.1, False),  # it may be as low as at its first rate
    (1.0, 2.0, -2.0, 6.0, 1.0, True), (0.25, 0.5, -2.0, 6.0, 1.0, False),
])  # fmt: skip
def test_a_gap_stays_above_zero(g, u, a, jerk, h, stays):
    """It is at least g + h (u + a h/2 - M h^2/6)."""
    assert landing._stays_above(g, u, a, jerk, h) == stays


def test_a_step_is_halved_until_it_is_certain():
    assert landing._certain_step(1.0, -1.0, 0.0, 0.0, 6.0) == 0.75
    assert landing._certain_step(1.0, 1.0, 0.0, 0.0, 6.0) == 6.0
    assert landing._certain_step(0.0, -1.0, 0.0, 0.0, 6.0) == -1.0


@pytest.mark.parametrize(("changes", "jerk", "most", "fall"), [
    ({}, 0.0, 9.0, 1.5), ({}, 0.0, 1.4, -1.0), ({"u": -0.5}, 0.0, 9.0, -1.0),
    ({"a": 0.5}, 0.0, 9.0, 1.5), ({"a": 0.5, "da": 0.25}, 0.0, 9.0, -1.0),
    ({"a": -9.0}, 0.8, 9.0, 1.5), ({"a": -9.0}, 1.0, 9.0, -1.0), ({}, 0.8, 9.0, 1.5),
])  # fmt: skip
def test_a_gap_falls_for_twice_as_long_as_it_needs_to_come_down(changes, jerk, most, fall):
    """2 (1/2 + 1/4) / (3/2 - 1/2) = 3/2, over which gap'' and gap''' may not turn it."""
    gap = gap_of(**{"g": 0.5, "dg": 0.25, "u": -1.5, "du": 0.5, **changes})
    assert landing._certain_fall(gap, jerk, most) == fall


def test_sums_of_balls_and_the_rate_after_an_impact_hold_all_numbers():
    total = landing._plus(Ball(1.0, 0.25), Ball(-3.0, 0.5))
    assert total.middle == -2.0
    assert 0.75 < total.radius < 0.7501
    after = landing._rate_after(0.5, Ball(1.0, 0.25), Ball(-3.0, 0.5))
    assert after.middle == 1.0
    assert 0.375 < after.radius < 0.3751
    exact = landing._plus(Ball(1.0, 0.0), Ball(2.0**-60, 0.0))
    assert exact.radius >= 2.0**-60
