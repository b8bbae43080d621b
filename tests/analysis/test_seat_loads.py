"""Which impacts are on the seat, which are opening blows, and which are neither.

A cam whose seat ends at 1 rad and begins again at 3 rad, which turns by pi rad/s.
"""

from math import cos, hypot, sin, sqrt
from types import SimpleNamespace as Made

import pytest

from camcli.analysis import loads
from camcli.analysis.integrate import Orbit, run_all
from camcli.analysis.loads import _takes_over, seat_loads
from camcli.api.machine import machine_of
from camcli.cams.eccentric import EccentricCam
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.scene import load_scene
from camcli.system import Follower, System
from tests.conftest import settings

PI = 3.141592653589793
CAM = Made(
    stretches=[
        Made(start=0.0, end=1.0, seat=1, end_c1=0.0),
        Made(start=1.0, end=2.0, seat=0, end_c1=0.5),
        Made(start=2.0, end=3.0, seat=0, end_c1=-0.25),
        Made(start=3.0, end=2.0 * PI, seat=1, end_c1=0.0),
    ]
)


@pytest.mark.parametrize(
    ("stretch", "theta", "takes_over"),
    [(1, 1.0, True), (1, 1.0000001, False), (2, 2.0, False), (3, 3.0, False)],
)
def test_the_lobe_takes_over_where_the_seat_ends(stretch, theta, takes_over):
    assert _takes_over(CAM, stretch, theta) == takes_over


def found(monkeypatch, *events, turns=2, strobe=0.0):
    """The columns, and the flights whose heights are looked at; restitution 0.5, 0.25 on a seat."""
    flights = []

    def highest(system, rpm, those):
        flights.extend(those)
        return 0.125

    places = [0.0, 1.0, 2.0, 3.0]
    monkeypatch.setattr(
        loads, "stretch_at", lambda cam, theta: max(k for k in range(4) if places[k] <= theta)
    )
    monkeypatch.setattr(loads, "_highest", highest)
    monkeypatch.setattr(loads, "_open_as_drawn", lambda system: 1.75)
    record = Made(periods=turns, events=lambda: iter(events))
    system = Made(cam=CAM, strobe=strobe, lash=0.002,
                  restitution=lambda i: 0.25 if CAM.stretches[i].seat else 0.5)  # fmt: skip
    return seat_loads(system, 30.0, record, Made(seated=6.0, airborne=2.0)), flights


def impact(period, theta, u):
    return IMPACT, period, theta, 0.0, u


SEAT, LOBE = impact(0, 3.5, -0.5), impact(0, 1.5, -0.25)


@pytest.mark.parametrize(
    ("events", "opening"),
    [
        ([LOBE], None),
        ([SEAT, impact(1, 1.5, -0.25)], 0.25),
        ([impact(0, 1.0, -0.125)], 0.125),  # where the lobe takes over from a rest on the seat
        ([LOBE, impact(1, 1.0, -0.125)], 0.125),
        ([LOBE, impact(0, 2.0, -0.125)], None),
        ([SEAT, (CHATTER, 0, 3.6, 0.0, 0.0), impact(1, 1.5, -0.25)], 0.25),
        ([(CHATTER, 0, 1.2, 0.0, 0.0), impact(0, 1.5, -0.25)], None),
        ([(DETACHMENT, 0, 2.0, 0.0, 0.0), impact(0, 2.5, -0.25)], None),
        ([SEAT, impact(1, 1.5, -0.25), impact(1, 1.75, -0.75)], 0.25),
        ([SEAT, impact(1, 1.5, -0.25), impact(1, 3.5, -0.1), impact(2, 1.5, -9.0)], 0.25),
        ([impact(-1, 3.5, -9.0), impact(0, 1.5, -0.25)], None),
        ([SEAT, (DETACHMENT, 1, 1.5, 0.0, -0.5)], None),
    ],
)
def test_an_opening_blow_follows_the_seat_or_falls_where_it_ends(monkeypatch, events, opening):
    columns, _ = found(monkeypatch, *events)
    wanted = None if opening is None else pytest.approx(PI * opening)
    assert columns["seat_opening_velocity_m_per_s"] == wanted


def test_the_other_columns_of_a_seat(monkeypatch):
    """Of impacts on the seat alone; a bounce is a tenth as hard as the hardest, or harder."""
    events = [
        impact(-1, 4.0, -9.0), SEAT, impact(0, 4.0, -0.05), impact(0, 4.5, -0.049),
        impact(1, 0.75, -0.0625), impact(1, 1.5, -3.0), impact(1, 3.25, -0.25), impact(2, 4, -9.0),
    ]  # fmt: skip
    columns, flights = found(monkeypatch, *events)
    assert columns == {
        "seat_velocity_m_per_s": pytest.approx(0.5 * PI),
        "seat_ramp_velocity_m_per_s": pytest.approx(0.25 * PI),
        "seat_opening_velocity_m_per_s": pytest.approx(3.0 * PI),
        "seat_bounces_per_turn": 2.0,
        "seat_bounce_height_m": 0.125,
        "seat_lift_lost_m": 0.002,
        "seat_open": pytest.approx((4.0 * PI - 6.0) / 2.0),
        "seat_open_lash": pytest.approx(2.0),
        "seat_open_drawn": 1.75,
        "seat_lobe_fraction": pytest.approx((4.0 * PI - 8.0) / (4.0 * PI)),
    }
    rates, spans = zip(*flights, strict=True)
    assert rates == pytest.approx([0.125, 0.0125, 0.01225, 0.015625])
    assert spans == pytest.approx([0.5, 0.5, 2.0 * PI - 3.75, 0.75])
    nothing, _ = found(monkeypatch, LOBE)
    assert nothing["seat_velocity_m_per_s"] is None
    assert nothing["seat_bounces_per_turn"] == 0.0


def test_flights_from_the_seat_go_on_beyond_the_strobe(monkeypatch):
    """With the strobe at 3.75 rad the impact at 3.5 rad comes late in its turn."""
    _, flights = found(monkeypatch, impact(0, 3.5, -0.5), impact(1, 4.0, -0.1), strobe=3.75)
    assert flights == [(0.125, pytest.approx(0.5))]
    _, flights = found(monkeypatch, SEAT, impact(2, 4.0, -0.1), turns=3)  # longer than a turn
    assert flights == [(0.125, pytest.approx(4.0 * PI + 0.5))]


@pytest.mark.parametrize(
    ("flights", "highest"),
    [
        ([(0.002, 3.0)], "top of 0.002"),
        ([(0.001, 3.0), (0.002, 3.0), (0.0005, 3.0)], "top of 0.002"),
        ([(0.001, 3.0), (0.0005, 3.0), (0.002, 3.0)], "top of 0.002"),
        ([(0.002, 0.05)], "cut short"),
        ([(0.002, 1e-3), (0.001, 3.0)], "top of 0.001"),  # the lobe takes over at once
        ([(0.001, 3.0), (0.00101, 1e-3)], "top of 0.001"),
    ],
)
def test_the_height_of_a_bounce_is_that_of_a_harmonic_motion(flights, highest):
    """From the seat, the lowest of the cam (20 mm), about the balance of spring and weight."""
    follower = Follower(mass=2.0, stiffness=800.0, gravity=9.81, preload=5.0)
    cam = EccentricCam(kind="eccentric", base=0.02, lift=0.01)
    system = System.build(follower, cam, 0.5)
    w0 = sqrt(800.0 / 2.0) / (300.0 * PI / 30.0)
    reach = 0.02 + (2.0 * 9.81 + 5.0) / 800.0  # of the seat above the balance

    def height(rate, s):
        return reach * cos(w0 * s) + rate / w0 * sin(w0 * s) - reach

    known = {
        "top of 0.002": hypot(reach, 0.002 / w0) - reach,
        "top of 0.001": hypot(reach, 0.001 / w0) - reach,
        "cut short": height(0.002, 0.05),
    }
    assert loads._highest(system, 300.0, flights) == pytest.approx(known[highest], rel=1e-9)
    assert loads._highest(system, 300.0, []) is None


@pytest.mark.parametrize("strobe_deg", [0.0, 300.0])
@pytest.mark.parametrize("turns", [1, 3])
def test_a_rest_of_whole_turns_is_on_the_seat_as_long_as_the_cam_is_low(strobe_deg, turns):
    """Without lash, 60 rpm: the follower never leaves the cam, which is up for 130 deg.

    A strobe on the seat cuts it in two.
    """
    law = {
        "kind": "law", "base": 0.02, "lift": 0.004, "lash": 0.0, "top_dwell_deg": 10.0,
        "rise": {"start_deg": 90.0, "length_deg": 60.0, "law": "cycloidal"},
        "fall": {"length_deg": 60.0, "law": "cycloidal"},
    }  # fmt: skip
    follower = {"mass": 0.1, "stiffness": 5000.0, "restitution": 0.5, "seat_restitution": 0.3}
    scene = load_scene({"cam": law, "follower": follower, "run": {"strobe_deg": strobe_deg}})
    orbit = Orbit(machine_of(scene).system, 60.0, settings(1, turns))
    (record,) = run_all([orbit], loads=True)
    assert record.loads.airborne == 0.0
    assert record.loads.seated == pytest.approx(turns * 230.0 * PI / 180.0, rel=1e-12)
