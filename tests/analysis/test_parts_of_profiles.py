"""What is read off a cam and a record, part by part, from numbers that are written down here."""

from __future__ import annotations

from math import cos, inf, pi, sin
from types import SimpleNamespace as Stub

import pytest

from camcli.analysis import cam_profile as profile_module
from camcli.analysis import loads as loads_module
from camcli.analysis import lobe as lobe_module
from camcli.analysis.bracketing import lowest
from camcli.analysis.cam_profile import Curvature, Extreme, Runner, _curvature, _jerk_jumps, _places
from camcli.analysis.integrate import Cost
from camcli.analysis.loads import Loads, _closing_slope, _flat, loads_of
from camcli.analysis.lobe import Face, Found, lobe_of
from camcli.analysis.speeds import Chosen, Speed, SpeedColumns
from camcli.errors import Status

TURN = 2.0 * pi
H = 0.01


# -- loads


def measured(**more):
    known = {"max_gap": 0.25, "airborne": 3.0, "max_impact": 0.5, "min_force": 0.125,
             "max_force": 0.75, "lost": 1.0, "regained": 3.0, "landing": 2.5, "landing_c": 0.175,
             "shut_bounces": 6}  # fmt: skip
    return Stub(**{**known, **more})


def told(**more):
    """Of four turns at 60 rpm, strobed at 4 rad, of a lobe that is 0.125 m at its lowest."""
    system = Stub(follower=Stub(mass=2.0), strobe=4.0, lift_range=(0.125, 0.5), has_seat=False)
    return loads_of(system, 60.0, Stub(periods=4, loads=measured(**more)))


def test_the_loads_of_a_record_in_the_units_of_a_table():
    force = 2.0 * TURN**2
    assert told()._asdict() == {
        **Loads()._asdict(), "max_gap_m": 0.25,
        "airborne_fraction": pytest.approx(3.0 / (4.0 * TURN)),
        "max_impact_m_per_s": pytest.approx(0.5 * TURN),
        "min_contact_force_n": pytest.approx(0.125 * force),
        "max_contact_force_n": pytest.approx(0.75 * force), "contact_lost": 5.0,
        "contact_regained": pytest.approx(7.0 - TURN), "landing": 2.5,
        "landing_lift_m": pytest.approx(0.05), "shut_bounces_per_turn": 1.5,
    }  # fmt: skip
    assert told(min_force=-1e-9).min_contact_force_n == 0.0  # by rounding
    assert told(lost=0.0).contact_lost == 4.0
    assert told(lost=TURN - 4.0).contact_lost == 0.0
    nothing = told(min_force=inf, max_force=-inf, lost=-1.0, regained=-1.0, landing=-1.0)
    for name in ("min_contact_force_n", "max_contact_force_n", "contact_lost", "contact_regained",
                 "landing", "landing_lift_m"):  # fmt: skip
        assert getattr(nothing, name) is None
    assert told(landing=0.0).landing == 0.0
    assert loads_of(None, 60.0, Stub(periods=0)) == Loads()


def stretch(seat, end_c1=0.0, **more):
    return Stub(seat=seat, end_c1=end_c1, **more)


@pytest.mark.parametrize(
    ("stretches", "slope"),
    [
        ([stretch(0, 0.5), stretch(0, -0.25), stretch(1, -9.0), stretch(1, 9.0)], 0.25),
        ([stretch(1), stretch(0, -0.5), stretch(1), stretch(0, -0.75)], 0.75),  # round the turn
        ([stretch(0, 0.5), stretch(1)], 0.0),  # let down by a rise: that is no fall
        ([stretch(0, -0.5), stretch(0, -0.25)], 0.0),
    ],
)
def test_the_steepest_fall_onto_the_seat(stretches, slope):
    assert _closing_slope(Stub(stretches=stretches)) == slope


def test_how_much_of_a_turn_is_the_base_circle(monkeypatch):
    """Its dwells that are no higher, but for a millionth of the lift."""
    monkeypatch.setattr(loads_module, "lift_range", lambda cam: (0.25, 1.25))
    spans = [(0.0, 1.0, 1, 0.25), (1.0, 1.5, 0, 0.25), (1.5, 3.0, 1, 1.25),
             (3.0, 3.25, 1, 0.25 + 0.9e-6), (3.25, 4.0, 1, 0.25 + 1.1e-6)]  # fmt: skip
    stretches = [
        Stub(start=start, end=end, dwell=dwell, start_c=c) for start, end, dwell, c in spans
    ]
    assert _flat(Stub(stretches=stretches)) == pytest.approx(1.0 + 0.25)


# -- the cam itself


@pytest.mark.parametrize(
    ("base", "least", "undercut"),
    [(0.03, 0.0, True), (0.03, -1e-9, True), (0.03, 1e-9, False), (None, -1.0, False)],
)
def test_a_flat_face_is_undercut_where_no_radius_is_left(base, least, undercut):
    found = Curvature(base, [], Extreme(least, 0.0), 0.0, None, None)
    assert found.undercut is undercut


@pytest.mark.parametrize("ratio", [1.0, 1.5])
@pytest.mark.parametrize("base", [None, 0.03, 0.001])
def test_the_curvature_of_the_lobe_of_an_eccentric(monkeypatch, ratio, base):
    """R = base + h (1 - cos theta)/2 with h = H/ratio: R + R'' is base + h/2 everywhere."""
    h = H / ratio
    thetas = [TURN * k / 120 for k in range(120)]

    def lift(cam, i, theta):
        return 0.02 + 0.5 * H * (1.0 - cos(theta)), 0.5 * H * sin(theta), 0.5 * H * cos(theta)

    monkeypatch.setattr(profile_module, "lift_at", lift)
    force = Stub(cam="cam", lowest=lambda f: min((f(0, x), 0, x) for x in thetas))
    rows = [lift("cam", 0, theta) for theta in thetas]
    found = _curvature(force, base, ratio, *(list(one) for one in zip(*rows, strict=True)))
    radius = (base or 0.0) + 0.5 * h
    assert found.flat == pytest.approx([radius] * 120, rel=1e-9)
    assert found.flat_least.value == pytest.approx(radius, rel=1e-9)
    assert (found.base_radius, found.least_base_radius) == (base, 0.0)
    if base is None:
        assert (found.knife, found.roller) == (None, None)
        return
    kappas = []
    for theta in thetas:
        r, r1, r2 = radius - 0.5 * h * cos(theta), 0.5 * h * sin(theta), 0.5 * h * cos(theta)
        kappas.append((r * r + 2.0 * r1 * r1 - r * r2) / (r * r + r1 * r1) ** 1.5)
    assert found.knife == pytest.approx(kappas, rel=1e-9)
    assert found.roller.value == pytest.approx(1.0 / max(kappas), rel=1e-9)
    assert found.roller.theta in (thetas[k] for k in range(120) if kappas[k] > 0.999 * max(kappas))


def test_the_base_that_a_flat_face_needs(monkeypatch):
    """At a radius of 0 the least of c + c'' is that far below zero."""
    force = Stub(cam="cam", lowest=lambda f: min((f(0, x), 0, x) for x in (0.0, 1.0)))
    lifts = {0.0: (0.25, 0.5, 1.0), 1.0: (0.75, 0.25, -2.0)}
    monkeypatch.setattr(profile_module, "lift_at", lambda cam, i, x: lifts[x])
    found = _curvature(force, 0.5, 1.0, [], [], [])
    assert found.least_base_radius == pytest.approx(2.0 - 0.5)  # 0.75 - 0.25 - 2 = -1.5
    assert found.flat_least == Extreme(pytest.approx(0.5 + 0.75 - 0.25 - 2.0), 1.0)
    lifts[1.0] = (0.75, 0.25, -0.25)
    assert _curvature(force, 0.5, 1.0, [], [], []).least_base_radius == 0.0
    lifts |= {
        0.0: (0.25, 0.0, 9.0),
        1.0: (0.75, 0.0, 9.0),
    }  # nowhere convex: of no roller too large
    assert _curvature(force, 0.5, 1.0, [], [], []).roller is None


def test_where_the_third_derivative_jumps(monkeypatch):
    """By more than a millionth of the largest, up or down, also from the end of the turn."""
    at_start = [5.0, 2.0, 2.0 + 3e-6, -1.0]
    at_end = [2.0 + 5e-7, 2.0, 4.0, 5.0]
    stretches = [Stub(start=float(k), end=k + 0.5) for k in range(4)]
    monkeypatch.setattr(
        profile_module, "column", lambda cam, name: [1.0, 0.5] * (name == "jerk_max")
    )
    monkeypatch.setattr(
        profile_module, "derivative",
        lambda cam, order, i, x: (at_start if x == i else at_end)[i] if order == 3 else None,
    )  # fmt: skip
    system = Stub(cam=Stub(stretches=stretches))
    assert _jerk_jumps(system) == {2, 3}
    at_end[3] = 4.0
    assert _jerk_jumps(system) == {0, 2, 3}


def test_the_rows_of_a_profile(monkeypatch):
    """Eight steps of a turn; two rows at a corner, one at a corner with which the turn begins."""
    starts, ends = [0.0, 1.0, pi / 2.0], [1.0, pi / 2.0, TURN]
    monkeypatch.setattr(profile_module, "Force", lambda system: Stub(starts=starts, ends=ends))
    monkeypatch.setattr(
        profile_module, "stretch_at", lambda cam, x: max(k for k in range(3) if starts[k] <= x)
    )
    system = Stub(cam=Stub(stretches=[0, 0, 0]))
    eighth = pi / 4.0
    rest = [(2, k * eighth) for k in range(3, 8)] + [(2, TURN)]
    assert _places(system, [2], 8) == [
        (0, 0.0), (0, eighth), (1, pi / 2.0), (2, pi / 2.0), *rest,
    ]  # fmt: skip
    assert _places(system, [0, 1], 8) == [
        (0, 0.0), (0, eighth), (0, 1.0), (1, 1.0), (2, pi / 2.0), *rest,
    ]  # fmt: skip


@pytest.mark.parametrize("drawn", [True, False])
@pytest.mark.parametrize("is_measured", [True, False])
@pytest.mark.parametrize("runner", [None, Runner(Face.ROLLER, 0.03, 0.01)])
def test_which_cam_a_profile_is_of(monkeypatch, drawn, is_measured, runner):
    """The force and the loss of contact are the follower's; all else is the cam's as it is drawn,
    if that is asked for. A fit has no jumps of its third derivative."""
    own = Stub(cam="own", rocker_ratio=1.5)
    own.as_drawn = Stub(cam="drawn", rocker_ratio=1.5)
    shown = own.as_drawn if drawn else own
    asked = []
    corners = [Stub(stretch=4, name="a", theta=1.5)]
    places = [(0, 0.5), (4, 1.5)]
    for name, stub in {
        "detachment": lambda of: Stub(first=("first of", of)),
        "Force": lambda of: Stub(of=of, curve=lambda rpm: ("force of", of, rpm)),
        "corner_list": lambda cam: corners if cam == shown.cam else None,
        "is_measured": lambda of: is_measured if of is shown else None,
        "_jerk_jumps": lambda of: {7} if of is shown else None,
        "_places": lambda of, jumps, points: asked.append((of, jumps, points)) or places,
        "lift_at": lambda cam, i, theta: (theta, cam, i),
        "_extreme": lambda force, order, sign: (force.of, order, sign),
        "_jerk_extreme": lambda force, sign: (force.of, 3, sign),
        "derivative": lambda cam, order, i, theta: (cam, order, i, theta),
        "_curvature": lambda force, *more: (force.of, *more),
        "lobe_of": lambda *given: given,
    }.items():
        monkeypatch.setattr(profile_module, name, stub)
    found = profile_module.profile(own, 60.0, 8, 0.25, runner, drawn)
    assert asked == [(shown, [4] if is_measured else [4, 7], 8)]
    assert found.force == ("force of", own, 60.0)
    assert found.first == ("first of", own)
    assert (found.theta, found.c, found.c1, found.c2) == (
        [0.5, 1.5], [0.5, 1.5], [shown.cam] * 2, [0, 4],
    )  # fmt: skip
    assert found.c3 == [(shown.cam, 3, 0, 0.5), (shown.cam, 3, 4, 1.5)]
    assert found.corners == {"a": 1.5}
    names = ("c", "c_theta", "c_thetatheta", "c_thetathetatheta")
    assert found.ranges == {
        name: ((shown, order, 1.0), (shown, order, -1.0)) for order, name in enumerate(names)
    }
    assert found.curvature == (shown, 0.25, 1.5, found.c, found.c1, found.c2)
    wanted = None if runner is None else (shown, Face.ROLLER, 0.03, 0.01, places)
    assert found.lobe == wanted


# -- lobes


@pytest.mark.parametrize(
    ("face", "least", "jumps", "undercut"),
    [
        (Face.FLAT, 0.5, (0.0, 0.25), False), (Face.FLAT, 0.5, (0.0, -0.25, 1.0), True),
        (Face.FLAT, 0.0, (0.0,), True), (Face.ROLLER, -0.5, (0.0,), True),
        (Face.ROLLER, 0.5, (0.0, -0.25), True), (Face.ROLLER, 0.5, (0.0, 0.25), False),
        (Face.KNIFE, -0.5, (-0.25,), False),  # it runs along any lobe
    ],
)  # fmt: skip
@pytest.mark.parametrize("base", [1.0, 0.25])
def test_which_lobe_is_undercut(monkeypatch, face, least, jumps, undercut, base):
    ends = [Stub(place=(0.5, 1.0)), Stub(place=(9.0, 9.0)), Stub(place=(0.5 + 3e-3, 1.0 - 4e-3))]
    geometry = Stub(
        touch=lambda i, theta, roller: ends[i], least=lambda roller: Found(least, 1.5),
        force=Stub(starts=[0.0, 1.0, 2.0]),
    )  # fmt: skip
    monkeypatch.setattr(lobe_module, "_Geometry", lambda *given: geometry)
    monkeypatch.setattr(lobe_module, "column", lambda cam, name: jumps)
    monkeypatch.setattr(lobe_module, "_hollow", lambda *given: ("hollow", given[1:]))
    monkeypatch.setattr(lobe_module, "_largest_roller", lambda of: "largest")
    monkeypatch.setattr(lobe_module, "_beside", lambda of, roller, sign: (roller, sign))
    found = lobe_of(Stub(cam="cam"), face, base, 0.125, [(0, 0.0), (1, 1.0), (2, TURN)])
    assert (found.undercut, found.least, found.touches) == (undercut, Found(least, 1.5), ends)
    assert found.closing == pytest.approx(5e-3)
    assert (found.face, found.base, found.roller) == (face, base, 0.125)
    assert found.beside == ((0.125, 1.0), (0.125, -1.0))
    is_flat = face is Face.FLAT
    assert found.hollow == (None if is_flat else ("hollow", (0.125, jumps)))
    assert found.least_base == (max(0.0, base - least) if is_flat else None)
    assert found.largest_roller == ("largest" if face is Face.ROLLER else None)


@pytest.mark.parametrize(
    ("jumps", "kappa", "hollow"),
    [
        ((0.0, 0.5, 0.25), -4.0, Found(0.125, 1.0)),  # at the first corner it is the roller's
        ((0.0, -0.5, 0.25), -4.0, Found(0.125, 2.0)), ((0.0, 0.0, 0.0), -4.0, Found(0.375, 2.5)),
        ((0.0, -1.0, 0.0), 0.5, None), ((0.0, 0.0, 0.0), -1e-13, None),  # it is straight
    ],
)  # fmt: skip
def test_the_sharpest_hollow(jumps, kappa, hollow):
    force = Stub(starts=[0.0, 1.0, 2.0], lowest=lambda f: (f(2, 2.5), 2, 2.5))
    geometry = Stub(force=force, base=1.0, kappa=lambda i, x, roller: kappa)
    assert lobe_module._hollow(geometry, 0.125, jumps) == hollow


# -- speeds, and the lowest place


def test_a_count_of_nothing_comes_back_from_a_row():
    """And what is not known comes back as that."""
    columns = SpeedColumns(few=0)
    speeds = [
        Speed(k, 2.0, "P(1;1)", count, Status.OK, None, None, Cost(1, 2, 3), watched=watched)
        for k, (count, watched) in enumerate([(0, 0), (None, None), (7, 9)])
    ]
    for one in speeds:
        columns.append(one)
    assert [(one.impact_count, one.watched) for one in columns] == [(0, 0), (None, None), (7, 9)]
    assert list(columns) == speeds
    assert columns.cost == Cost(3, 6, 9)


@pytest.mark.parametrize(("few", "kept"), [(2, True), (1, False)])
def test_many_speeds_are_read_when_they_are_asked_for(few, kept):
    columns = SpeedColumns(few=few)
    for k in range(1 if kept else 3):
        columns.append(Speed(float(k), 2.0, "contact", 0, Status.OK, None, None, Cost()))
    order = [0, 0] if kept else [2, 0]
    found = columns.chosen(order)
    assert isinstance(found, list) is kept
    assert isinstance(found, Chosen) is not kept
    assert [one.value for one in found] == [float(k) for k in order]


def test_a_place_inside_may_be_lower_by_as_little_as_it_likes():
    """But where the least sample is an end it is lower by more than a rounding, or the end is it.

    Nothing is refined where the samples are all alike.
    """
    inside = lowest(lambda x: 1.0 + 4e-15 * (10.0 * (x - 0.55)) ** 2, 0.0, 1.0, 10)
    assert inside == (1.0, pytest.approx(0.55, abs=0.05))
    assert inside[1] not in (0.5, 0.6)

    def beside(depth):
        return lambda x: 1.0 if x < 0.05 else 1.0 + 2e-9 - (2e-9 + depth) * (abs(x - 0.55) < 0.04)

    assert lowest(beside(1e-15), 0.0, 1.0, 10) == (1.0, 0.0)
    calls = []
    assert lowest(lambda x: calls.append(x) or 2.0, 0.0, 1.0, 10) == (2.0, 0.0)
    assert len(calls) == 11
