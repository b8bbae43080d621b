"""The high-precision reference against closed forms and independently known numbers."""

import pytest
from mpmath import mp, mpf

from tests.support.oracle import ArcsCam, Oracle, first_detachment_rpm, region_filling_rpm

MASS, STIFFNESS, R = 1.221, 146 * 9.8, 0.8
CAM = ArcsCam()


def chapter(rpm, **changes):
    data = {"mass": MASS, "stiffness": STIFFNESS, "restitution": R, "rpm": rpm}
    return Oracle(CAM, **{**data, **changes})


def degrees(event):
    return float(mp.degrees(event.theta))


def close(value, expected, tol):
    assert abs(value - mpf(expected)) < tol, mp.nstr(value, 20)


def test_breakpoints_follow_from_the_tangency():
    expected = [90, "150.1793714951576", 160, 200, "209.8206285048424", 270]
    for angle, value in zip(CAM.breakpoints, expected, strict=True):
        close(mp.degrees(angle), value, 2e-12)


@pytest.mark.parametrize(
    ("corner", "side", "c", "c1", "c2"),
    [
        (0, 1, "0.1", 0, "0.2117647058823529"),
        (1, -1, "0.2312555620189976", "0.2747021271326710", "0.3415971000285428"),
        (1, 1, "0.2312555620189976", "0.2747021271326710", "-1.869212582774405"),
        (2, -1, "0.25393320723821", 0, "-1.491680113303188"),
        (2, 1, "0.25393320723821", 0, 0),
        (4, -1, "0.2312555620189976", "-0.2747021271326710", "-1.869212582774405"),
        (5, 1, "0.1", 0, 0),
    ],
)
def test_cam_law_at_the_corners(corner, side, c, c1, c2):
    angle = CAM.breakpoints[corner]
    close(CAM.c(angle, side), c, 1e-14)
    close(CAM.c1(angle, side), c1, 1e-13)
    close(CAM.c2(angle, side), c2, 1e-12)


def test_cam_law_is_smooth_where_it_should_be():
    """c and c_theta are continuous at every corner, and the derivatives are derivatives."""
    with mp.workdps(60):
        for angle in CAM.breakpoints:
            assert abs(CAM.c(angle) - CAM.c(angle, -1)) < mpf(10) ** -55
            assert abs(CAM.c1(angle) - CAM.c1(angle, -1)) < mpf(10) ** -55
        for x in (1, 2, mpf("2.7"), 3, mpf("3.6"), 4, 5, -1, 9):
            h = mpf(10) ** -20
            up, mid, down = (CAM.laws(x + s * h) for s in (1, 0, -1))
            for i in (0, 1):
                assert abs((up[i] - down[i]) / (2 * h) - mid[i + 1]) < mpf(10) ** -35


def test_speeds_of_detachment():
    close(first_detachment_rpm(CAM, MASS, STIFFNESS), "114.979326744", 1e-9)
    close(region_filling_rpm(CAM, MASS, STIFFNESS), "134.872968058", 1e-9)


@pytest.mark.parametrize(("n", "rpm"), [(1, 124.998297), (8, 120.165355)])
def test_the_nth_impact_after_lift_off_lands_on_c(n, rpm):
    events = chapter(rpm).run(impacts=n)
    assert [e.kind for e in events] == ["detachment"] + ["impact"] * n
    assert degrees(events[-1]) == pytest.approx(160, abs=1e-5)


def test_ball_dropped_on_a_dwell():
    """Impacts at sqrt(2h/g) (1 + 2r + ... + 2r^(n-1)), rest after (1+r)/(1-r) sqrt(2h/g)."""
    ball = chapter(1, mass=1, stiffness=0, gravity=9.81)
    with mp.workdps(60):
        events = ball.run(q=CAM.c(0) + 1, v=0, turns=0.25)
    *impacts, rest = events
    assert [e.kind for e in impacts] == ["impact"] * len(impacts)
    assert rest.kind == "chatter"
    with mp.workdps(60):
        g, r, omega = mpf(9.81), mpf(0.8), mp.pi / 30
        fall = mp.sqrt(2 / g)
        close(rest.theta / omega, "4.06371277", 1e-8)
        close(rest.theta / omega, fall * (1 + r) / (1 - r), 1e-20)
        for n, event in enumerate(impacts):
            hops = 2 * r * (1 - r**n) / (1 - r)
            assert abs(event.theta / omega - fall * (1 + hops)) < mpf(10) ** -45
            assert abs(event.u_minus / (g * fall * r**n) + 1) < mpf(10) ** -20
            assert abs(event.u_plus + r * event.u_minus) < mpf(10) ** -50
            assert event.stretching == 1


@pytest.mark.parametrize(("shift", "hits"), [("1e-30", 1), ("-1e-30", 0)])
def test_a_double_contact_is_not_missed(shift, hits):
    """A straight flight along the tangent of the nose, shifted into it or away by 1e-30 m."""
    with mp.workdps(80):
        omega, delta = mpf(700) * mp.pi / 30, mpf(shift)
        start, touch = mp.radians(140), mp.radians(155)
        c, c1, c2 = CAM.laws(touch)
        straight = chapter(700, stiffness=0)
        q = c - c1 * (touch - start) - delta
        events = straight.run(q=q, v=omega * c1, theta=start, turns=0.1, impacts=1)
        assert len([e for e in events if e.u_minus < 0]) >= hits
        assert bool(events) == bool(hits)
        if hits:
            depth = mp.sqrt(2 * delta / -c2)
            assert abs((touch - events[0].theta) / depth - 1) < mpf(10) ** -10


B_CRITICAL = 2 * mp.sqrt(mpf(STIFFNESS) * mpf(MASS))


@pytest.mark.parametrize("stiffness", [0, STIFFNESS])
@pytest.mark.parametrize("damping", [0, 5, B_CRITICAL, 400])
def test_the_flow_solves_the_equation_of_motion(stiffness, damping):
    data = {"stiffness": stiffness, "damping": damping, "gravity": 9.81, "preload": 7}
    follower = chapter(700, **data)
    with mp.workdps(60):
        t, h = mpf("0.037"), mpf(10) ** -15
        (_, lo), (q, v), (_, hi) = (follower.flow(t + s * h, 0.3, -2) for s in (-1, 0, 1))
        force = mpf(MASS) * (hi - lo) / (2 * h) + mpf(damping) * v + mpf(stiffness) * q
        close(force, -mpf(MASS) * mpf(9.81) - 7, mpf(10) ** -18)
        close(follower.flow(2 * t, 0.3, -2)[0], follower.flow(t, q, v)[0], mpf(10) ** -55)
    assert follower.flow(0, 0.3, -2) == (mpf(0.3), -2)


@pytest.mark.slow
def test_stretching_is_the_sensitivity_to_the_data():
    """A chaotic run against one at a speed 1e-12 higher."""
    base, other = (chapter(x).run(impacts=20) for x in (361.5, mpf(361.5) * (1 + mpf("1e-12"))))
    for e, f in zip(base, other, strict=True):
        assert e.kind == f.kind
        assert abs(e.theta - f.theta) / (2 * mp.pi) < 1.01e-12 * e.stretching
    assert base[-1].stretching > 100
