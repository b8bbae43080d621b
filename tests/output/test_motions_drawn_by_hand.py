"""Pictures of one motion, by hand: its last turns from rows, rests, a passage, frames of a film."""

from __future__ import annotations

from math import degrees, inf, nan, pi, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.analysis.simulate import FLIGHT, STICKING
from camcli.plots import mechanism, simulate, style
from camcli.plots.simulate import Trace, _on_seat
from camcli.quantities import METRES, MILLIMETRES

OMEGA = 2.0 * pi  # rad/s, of 60 rpm


def lift(cam, theta):
    """c = 0.01 (1 - cos theta) and its two derivatives."""
    return 0.01 * np.array([1.0 - np.cos(theta), np.sin(theta), np.cos(theta)])


@pytest.fixture
def cam(monkeypatch):
    """A cam by a formula, on whose seat the follower is everywhere; its slope has no jump."""
    found = Made(slope_jump=[0.0, 0.0])
    monkeypatch.setattr(simulate, "lift", lift)
    monkeypatch.setattr(simulate, "column", lambda cam, name: getattr(found, name))
    monkeypatch.setattr(simulate, "_on_seat", lambda system, angle: np.full(len(angle), True))
    monkeypatch.setattr(simulate, "units_of", lambda system: METRES)
    return found


def motion(start=2.25):
    """Rows from a phase of 40 deg + 360 deg (t - 2) on, two of an impact at 3.5 s, then a rest."""
    times = [start, 2.5, 3.0, 3.5, 3.5, 4.0, 4.5, 5.0]
    contact = [FLIGHT] * 5 + [STICKING] * 3
    rows = []
    for k, (t, how) in enumerate(zip(times, contact, strict=True)):
        theta = radians(40.0) + OMEGA * (t - 2.0)
        c, slope, _ = lift(None, theta)
        gap = 1e-7 if how == STICKING else 0.001 * (1 + k)
        rows.append((t, degrees(theta), c + gap, slope * OMEGA + 0.1 * (k + 1), 0.0, 0.25 * k, how))
    events = [
        (2.4, 0.0, 0.0, "impact", 0.5, -0.9, 0.8), (3.5, 0.0, 0.0, "impact", 0.25, -0.5, 0.375),
        (3.75, 0.0, 0.0, "chatter", 0.125, 0.0, 0.0),
        (4.25, 0.0, 0.0, "impact", 0.0625, -0.25, 0.0),
    ]  # fmt: skip
    return Made(rpm=60.0, trajectory=rows, corners=[radians(100.0)], events=events)


def at_rows(trace: Trace, values: np.ndarray, *times: float) -> list[float]:
    """The values at the first point of a trace at each of these times (s)."""
    angles = [360.0 * t + 40.0 for t in times]
    return [values[int(np.argmin(np.abs(trace.angle - angle)))] for angle in angles]


def test_the_last_turns_of_a_record_are_whole_and_counted_from_its_strobe(cam):
    system = Made(cam=None, lash=0.0)
    trace = Trace.of(motion(), system, 2)
    assert trace.origin == 40.0  # deg, at time 0
    assert (trace.low, trace.high) == (3.0 * 360.0 + 40.0, 5.0 * 360.0 + 40.0)
    assert trace.angle[0] == pytest.approx(1120.0)
    assert trace.angle[-1] == pytest.approx(1840.0)
    assert {name: points.tolist() for name, points in trace.events.items()} == {
        "impact": [[1300.0, 0.25], [1570.0, 0.0625]], "chatter": [[1390.0, 0.125]]
    }  # fmt: skip
    assert trace.jumps.tolist() == [[-0.5, 0.375], [-0.25, 0.0]]
    rows = {row[0]: row for row in motion().trajectory}
    strobed = [[rows[t][2], rows[t][3]] for t in (3.0, 4.0, 5.0)]
    assert trace.section == pytest.approx(np.array(strobed))
    for turns in (3, 9):  # no more than there are, from the turn in which the record begins
        whole = Trace.of(motion(), system, turns)
        assert (whole.low, whole.high) == (2.0 * 360.0 + 40.0, 1840.0)
        assert whole.angle[0] == pytest.approx(2.25 * 360.0 + 40.0)
        assert len(whole.jumps) == 3
    assert (trace.units, trace.lobe is trace.cam) == (METRES, True)


def test_a_trace_passes_through_its_rows_and_rests_upon_the_cam(cam):
    trace = Trace.of(motion(), Made(cam=None, lash=0.0), 2)
    angle = np.radians(trace.angle)
    c, _, bend = lift(None, angle)
    assert trace.cam == pytest.approx(c)
    assert trace.bend == pytest.approx(bend)
    assert trace.q == pytest.approx(trace.cam + trace.gap)
    assert at_rows(trace, trace.gap, 3.0, 4.0, 4.5, 5.0) == pytest.approx([0.003, 0.0, 0.0, 0.0])
    assert at_rows(trace, trace.u, 3.0, 4.0, 5.0) == pytest.approx([0.3, 0.0, 0.0])
    impact = np.flatnonzero(np.abs(trace.angle - 1300.0) < 1e-9)
    assert trace.u[impact] == pytest.approx([0.4, nan, 0.5], nan_ok=True) or len(impact) >= 2
    assert trace.u[impact[-1]] == pytest.approx(0.5)
    assert trace.gap[impact[0]] == pytest.approx(0.004)
    assert trace.gap[impact[-1]] == pytest.approx(0.005)
    assert not trace.sticks[trace.angle < 1479.0].any()
    assert trace.sticks[trace.angle > 1481.0].all()
    assert (trace.seated == trace.sticks).all()  # in flight nothing rests on the seat
    corners = [one for one in trace.angle if abs(one % 360.0 - 100.0) < 1e-6]
    assert len(corners) == 4  # on both sides, in each of the two turns
    # at a kink a row has the slope of its own side
    cam.slope_jump = [0.0, 0.5]
    kinked = Trace.of(motion(), Made(cam=None, lash=0.0), 2)
    rows = {row[0]: row for row in motion().trajectory}
    own = rows[3.0][3] - rows[3.0][5]
    assert at_rows(kinked, kinked.u, 3.0) == pytest.approx([own])
    assert trace.angle[1] < 1300.0  # between two rows
    assert kinked.u[1] == pytest.approx(trace.u[1])


def test_a_record_that_ends_beside_a_strobe_by_rounding_has_whole_turns(cam):
    """From a rounding before turn 3 to a rounding behind turn 5."""
    found = motion()
    rows = [list(row) for row in found.trajectory[2:]]
    rows[0][0] -= 1e-12
    rows[-1][0] += 1e-12
    found.trajectory = rows
    for turns in (2, 9):
        trace = Trace.of(found, Made(cam=None, lash=0.0), turns)
        assert (trace.low, trace.high) == (3.0 * 360.0 + 40.0, 5.0 * 360.0 + 40.0)
        assert trace.angle[0] == pytest.approx(1120.0)
        assert len(trace.section) == 3


def test_there_is_a_point_at_least_between_two_rows_however_many_there_are():
    for rows, parts in ((3, 8), (250_000, 2)):
        fine, segment = simulate._fine(np.arange(float(rows)), np.empty(0))
        assert len(fine) == (rows - 1) * parts + 1
        assert fine[:3] == pytest.approx([0.0, 1.0 / parts, 2.0 / parts])
        assert (segment[parts - 1], segment[parts], segment[-1]) == (0, 1, rows - 1)


def test_a_stretch_of_the_seat_begins_with_its_first_phase(monkeypatch):
    columns = {"start": [0.0, 1.0, 2.0], "seat": [1.0, 0.0, 0.0]}
    monkeypatch.setattr(simulate, "column", lambda cam, name: columns[name])
    found = _on_seat(Made(cam=None), np.array([0.0, 30.0, 60.0, 360.0, 390.0, 120.0]))
    assert found.tolist() == [True, True, False, True, True, False]


def test_a_lobe_with_lash_is_drawn_below_the_seat(cam):
    system = Made(cam=None, lash=0.0005, as_drawn=Made(cam=None))
    trace = Trace.of(motion(), system, 1)
    assert trace.low == 4.0 * 360.0 + 40.0
    assert trace.lobe == pytest.approx(trace.cam - 0.0005)


def test_two_rows_make_a_cubic_and_a_single_one_is_itself():
    """t^3 - t from 1 to 3 s, with its slopes."""
    t, y, slope = np.array([1.0, 3.0]), np.array([0.0, 24.0]), np.array([2.0, 26.0])
    x = np.array([1.0, 1.5, 2.0, 3.0])
    values, slopes = simulate._cubic(t, y, slope, x, np.array([0, 0, 0, 1]))
    assert values == pytest.approx(x**3 - x)
    assert slopes == pytest.approx(3.0 * x**2 - 1.0)
    alone = simulate._cubic(t[:1], y[:1], slope[:1], x[:1], np.array([0]))
    assert [part.tolist() for part in alone] == [[0.0], [2.0]]
    # an impact: two rows at one time; the first point of each has its own slope, others a gap
    t, y, slope = np.array([1.0, 2.0, 2.0, 3.0]), np.full(4, 5.0), np.array([0.0, -3.0, 4.0, 0.0])
    x, segment = np.array([1.0, 2.0, 2.0, 2.0, 3.0]), np.array([0, 1, 1, 2, 3])
    values, slopes = simulate._cubic(t, y, slope, x, segment)
    assert values[1:4] == pytest.approx([5.0, 5.0, 5.0])
    assert slopes[1:4] == pytest.approx([-3.0, nan, 4.0], nan_ok=True)


def drawn(**more):
    """A trace of four segments: in flight, on the lobe, on the lobe slowing, on the seat."""
    own = {"angle": np.array([0.0, 10.0, 20.0, 30.0, 40.0]), "low": 0.0, "high": 360.0,
           "sticks": np.array([False, True, True, True, True]),
           "seated": np.array([False, False, False, True, True]),
           "bend": np.array([-2.0, 1.0, -1.0, -1.5, -1.5])}  # fmt: skip
    found = Made(**{**own, **more})
    found.during = lambda values, state: np.where(state, values, nan)
    return found


def test_rests_on_the_lobe_are_told_from_those_on_the_seat_and_from_slowing_ones():
    axes = Figure().subplots()
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    simulate._draw_contact(axes, drawn(), values, named=True)
    told = {line.get_label(): line.get_ydata().tolist() for line in axes.lines}
    assert told == {
        f"follower in {FLIGHT}": pytest.approx([1.0, nan, nan, nan, nan], nan_ok=True),
        "at rest on its seat": pytest.approx([nan, nan, nan, 4.0, 5.0], nan_ok=True),
        rf"{STICKING}, $\ddot{{c}} \geq 0$": pytest.approx([nan, 2.0, nan, nan, nan], nan_ok=True),
        rf"{STICKING}, $\ddot{{c}} < 0$": pytest.approx([nan, nan, 3.0, nan, nan], nan_ok=True),
    }
    axes = Figure().subplots()
    still = np.full(5, False)
    # a rounding below zero is no slowing
    bend = np.array([1.0, -0.9e-9, -1.1e-9, 1.0, 1.0])
    simulate._draw_contact(axes, drawn(seated=still, bend=bend), values)
    assert [line.get_color() for line in axes.lines] == [
        style.FLIGHT, style.STICKING, style.SLOWING
    ]  # fmt: skip
    assert axes.lines[2].get_ydata() == pytest.approx([nan, nan, 3.0, nan, nan], nan_ok=True)


def test_relative_positions_have_room_above_and_below_their_marks():
    axes = Figure().subplots()
    trace = drawn(gap=np.array([0.0, 1.0, 2.0, 3.0, 4.0]),
                  events={"impact": np.array([[10.0, 0.5], [30.0, 0.25]])})  # fmt: skip
    simulate._draw_gap(axes, trace, None)
    impacts = next(line for line in axes.lines if line.get_marker() == "o")
    assert impacts.get_xydata().tolist() == [[10.0, 0.0], [30.0, 0.0]]
    assert axes.get_ylabel() == "relative position $q - c$ (m)"
    assert axes.margins() == (axes.margins()[0], simulate.ROOM_OF_MARKS)
    assert axes.get_ylim()[0] < -0.1


def test_small_gaps_are_counted_in_the_unit_of_the_largest():
    axes = Figure().subplots()
    trace = drawn(gap=np.array([0.0, 0.0, 0.0, 0.0, 0.03]), events={})
    simulate._draw_gap(axes, trace, None)
    assert axes.get_ylabel() == "relative position $q - c$ (m)"  # 6 mm on average


def test_corners_have_a_line_in_each_turn_and_a_name_in_the_first(monkeypatch):
    lines = []
    monkeypatch.setattr(
        simulate, "corner_lines", lambda axes, some, way: lines.append([at for _, at in some])
    )
    flat = np.full(5, 0.01)
    trace = drawn(low=40.0, high=760.0, cam=flat, q=flat + 0.01, lobe=flat, origin=40.0, events={},
                  units=METRES)  # fmt: skip
    axes = Figure().subplots()
    simulate._draw_motion(axes, trace, Made(corners=[radians(30.0), radians(100.0)], rpm=600.0))
    assert lines == [[pytest.approx(100.0), pytest.approx(460.0)],
                     [pytest.approx(390.0), pytest.approx(750.0)]]  # fmt: skip
    assert [text.get_text() for text in axes.texts] == ["b", "a"]


def test_a_picture_shows_the_turns_that_were_asked_for(monkeypatch):
    """Not the period of a motion that repeats earlier; without rows it says so."""
    asked = []
    monkeypatch.setattr(
        simulate.Trace, "of", lambda found, system, turns: asked.append(turns) or "trace"
    )
    monkeypatch.setattr(simulate, "kind_of_cam", lambda system: "")
    for name in ("_draw_motion", "_draw_gap", "_draw_phase", "_draw_passage", "_draw_section"):
        monkeypatch.setattr(simulate, name, lambda *how, own=name: asked.append((own, *how[1:])))
    found = Made(trajectory=[1], repeats=1, rpm=600.0, label="P(1;1)", status=0)
    picture = simulate.draw_simulation(found, None, 4)
    assert asked == [4]
    assert [(name, panel.across, panel.usual) for name, panel in picture.panels.items()] == [
        ("motion", 1, True), ("gap", 2, True), ("phase", 2, True), ("passage", 1, False),
        ("section", 2, False),
    ]  # fmt: skip
    for panel in picture.panels.values():
        panel.draw(None)
    assert asked[1:] == [(f"_draw_{name}", "trace", found) for name in picture.panels]
    found.trajectory = []
    axes = Figure().subplots()
    simulate.draw_simulation(found, None, 4).panels["gap"].draw(axes)
    assert axes.texts[0].get_text() == "no trajectory was sampled"


def test_a_lobe_is_clear_of_its_follower_beyond_a_billionth_of_the_lift():
    """5e-10 m are much on a lift of 10 mm; 5e-12 m are rounding."""
    for gap, labels in ((5e-10, {"lobe less lash, or seat", "lobe, clear of the follower"}),
                        (5e-12, {"cam"})):  # fmt: skip
        cam_at = np.array([0.0, 0.005, 0.01, 0.005, 0.0])
        trace = drawn(cam=cam_at, q=cam_at, lobe=cam_at - gap * np.array([0, 0, 0, 0, 1]),
                      origin=0.0, events={}, units=METRES)  # fmt: skip
        axes = Figure().subplots()
        simulate._draw_motion(axes, trace, Made(corners=[], rpm=600.0))
        told = {line.get_label() for line in axes.lines if not line.get_label().startswith("_")}
        assert {label for label in told if "lobe" in label or label == "cam"} == labels


def test_an_arrow_shows_the_way_of_time_where_a_wide_flight_turns_back():
    """Not at a small one, not at the begin or the end of a rest."""
    gap = np.array([0.0, 1.0, 0.9, 0.29, 0.28, 0.5, 0.4, 0.5, 0.4])
    u = np.array([2.0, 1.0, -1.0, 0.5, -0.5, 0.5, 0.0, 0.5, -0.5])
    sticks = np.array([False, False, False, False, False, False, True, True, False])
    axes = Figure().subplots()
    simulate._draw_ways(axes, Made(gap=gap, u=u, sticks=sticks))
    (arrow,) = axes.texts
    assert (arrow.xyann, arrow.xy) == ((1.0, 1.0), (0.9, -1.0))


def passage(detachments, repeats=2, before=1.0):
    """Two turns with rows every 2 deg whose gap is the share of its turn in thousandths.

    before: times as much before 170 deg.
    """
    angle = np.arange(720.0, 1440.0, 2.0)
    events = {"impact": np.array([[884.0, 0.0], [1245.0, 0.0], [1290.0, 0.0]])}
    if detachments:
        events["detachment"] = np.array([[x, 0.0] for x in detachments])
    still = np.full(len(angle), False)
    gap = (angle % 360.0) / 360.0 * 1e-3 * np.where(angle % 360.0 < 170.0, before, 1.0)
    trace = Made(angle=angle, gap=gap, sticks=still, events=events,
                 high=1440.0)  # fmt: skip
    trace.during = lambda values, state: np.where(state, values, nan)
    axes = Figure().subplots()
    simulate._draw_passage(axes, trace, Made(repeats=repeats, corners=[]))
    return axes


def test_a_passage_is_about_the_last_detachment_and_shows_both_turns():
    axes = passage([900.0, 1250.0])  # the last one at 170 deg
    assert axes.get_xlim() == pytest.approx((162.0, 174.0))
    impacts = [line for line in axes.lines if line.get_marker() == "o"]
    assert [(line.get_label(), line.get_xdata().tolist()) for line in impacts] == [
        ("impact", [pytest.approx(164.0)]), ("impact of every second turn", [pytest.approx(165.0)])
    ]  # fmt: skip
    # as high as 0.4 of the largest gap before it, that at 168 deg
    assert axes.get_ylim()[1] == pytest.approx(0.4 * 168.0 / 360.0 * 1e-3)
    (one,) = (line for line in passage([890.0], 1).lines if line.get_marker() == "o")
    assert one.get_xdata() == pytest.approx([164.0, 165.0])  # of both, where they are alike
    at_rest = passage([890.0], 1, before=0.0)  # as high as the largest gap behind it
    assert at_rest.get_ylim()[1] == pytest.approx(0.4 * 2.5 * 172.0 / 360.0 * 1e-3)
    assert passage([]).get_xlim() == pytest.approx((1432.0 % 360.0 - 8.0, 1432.0 % 360.0 + 4.0))


def test_frames_have_the_gap_on_the_side_of_the_cam_and_the_highest_place(monkeypatch):
    """A film of one turn that begins in the second one; the lobe is under a rocker of 2."""
    angle = np.array([400.0, 490.0, 580.0, 760.0])
    gap = np.array([0.0, 0.008, 0.002, 0.0])
    still = np.array([True, False, False, True])
    trace = Made(low=400.0, high=760.0, angle=angle, gap=gap, q=gap + 0.01,
                 cam=np.array([0.01, 0.02, 0.01, 0.01]),
                 sticks=still, seated=np.full(4, False), units=MILLIMETRES, events={},
                 jumps=np.empty((0, 2)))  # fmt: skip
    trace.during = lambda values, state: np.where(state, values, nan)
    asked, machines = [], []
    monkeypatch.setattr(
        simulate.Trace, "of", lambda found, system, turns: asked.append(turns) or trace
    )
    monkeypatch.setattr(simulate, "kind_of_cam", lambda system: "law")
    monkeypatch.setattr(simulate, "FigureCanvasAgg", lambda figure: None)  # nothing is drawn
    monkeypatch.setattr(simulate, "draw_machine", lambda axes, outline, *how: machines.append(how))
    places = np.array([40.0, 130.0, 140.0, 220.0, 310.0])  # one more than four a turn
    monkeypatch.setattr(simulate, "frame_angles", lambda *how: asked.append(how) or places)
    trace.events = {"impact": np.array([[490.0, 0.0]])}
    trace.jumps = np.array([[-1.0, 0.5]])
    outline = Made(ratio=2.0, radius=np.array([0.02, 0.03]))
    found = Made(rpm=600.0, repeats=1, label="P(1;1)")
    for figure in simulate.draw_frames(found, None, outline, 3, frames=4, near_frames=12):
        _, course = figure.axes
    assert course.get_xlim() == (40.0, 400.0)
    assert tuple(figure.get_size_inches()) == (9.6, 5.4)
    body = course.collections[0].get_paths()[0].vertices[:, 1]
    assert (body.min(), body.max()) == (0.01, 0.02)  # from the lowest place of the cam
    assert course.xaxis.get_major_locator()._edge.step == 60.0
    # 4/30 s a turn that takes 0.1 s
    assert course.get_title("right").endswith("\n1.33 times slower, 3 times that near impacts")
    assert asked[0] == 1  # of three turns the one that repeats
    low, high, impacts, *frames = asked[1]
    assert (low, high, list(impacts), frames) == (40.0, 400.0, [130.0], [4, 12])
    assert [how[1] for how in machines] == places.tolist()
    assert [how[0] for how in machines] == pytest.approx([0.0, 0.004, 0.0036667, 0.001, 0.0005],
                                                         abs=1e-6)  # fmt: skip
    assert [how[2] for how in machines] == pytest.approx([0.034] * 5)
    marker = course.lines[-1]
    assert to_hex(marker.get_color()).upper() == style.FLIGHT
    assert [float(x[0]) for x in marker.get_data()] == pytest.approx([310.0, 0.011])


# --- the machine


def outline(**more):
    """A cam with a base circle of 20 mm and a lift of 10 mm."""
    theta = np.linspace(0.0, 2.0 * pi, 721)
    own = {"theta": theta, "radius": 0.02 + 0.01 * (1.0 - np.cos(theta)) / 2.0, "corners": {},
           "rings": [mechanism._base_circle(0.02)], "guessed": False, "flat": False,
           "units": MILLIMETRES, "sprung": True}  # fmt: skip
    return mechanism.Outline(**{**own, **more})


@pytest.mark.parametrize(
    ("more", "turned", "title", "loc"),
    [
        ({}, 0.0, r"$\theta$ = 0 deg", "center"),
        ({"guessed": True}, 0.0,
         "base radius not given: 1.5 lifts\n" r"$\theta$ = 0 deg", "center"),
        ({"guessed": True}, 180.0, r"$\theta$ = 180 deg", "center"),
        ({"guessed": True, "at_rest_deg": 12.0}, 12.0,
         "base radius not given: 1.5 lifts\n" r"$\theta$ = 12 deg", "center"),
        # 0.4 mm at the lobe are 0.6 mm at the valve, and 0.02 of the largest radius are 0.6 mm
        ({"lash": 4e-4, "ratio": 1.5}, 0.0,
         "lash 0.6 mm; too thin to see\n" r"$\theta$ = 0 deg", "left"),
        ({"lash": 6.1e-4, "ratio": 1.5}, 0.0, "lash 0.915 mm\n" r"$\theta$ = 0 deg", "left"),
        ({"lash": 4e-4, "widened": 6.0}, 0.0,
         "lash 0.4 mm, drawn 6 times as wide\n" r"$\theta$ = 0 deg", "left"),
        ({"lash": 4e-4, "widened": 6.0}, 180.0, r"$\theta$ = 180 deg", "left"),
    ],
)  # fmt: skip
def test_the_title_of_an_outline_says_what_of_it_is_not_true(monkeypatch, more, turned, title, loc):
    for name in ("_body", "_draw_circles", "_draw_corners", "_follower"):
        monkeypatch.setattr(mechanism, name, lambda *_: None)
    axes = Figure().subplots()
    mechanism._draw_outline(axes, outline(**more), turned, "")
    assert axes.get_title(loc=loc) == title
    mechanism._draw_outline(other := Figure().subplots(), outline(**more), turned, "the cam B")
    assert other.get_title(loc="left") == "the cam B"


def test_a_ball_flies_above_a_table_that_stays_below():
    axes = Figure().subplots()
    mechanism._follower(axes, outline(flat=True, sprung=False), 0.004, 0.0)
    (ball,) = axes.patches
    (table,) = axes.lines
    assert table.get_ydata() == pytest.approx([0.02, 0.02])
    assert ball.center[1] - ball.radius == pytest.approx(0.024)
    assert to_hex(ball.get_facecolor()).upper() == style.FLIGHT
    on_it = Figure().subplots()
    mechanism._follower(on_it, outline(flat=True, sprung=False), 0.0, 180.0)
    assert to_hex(on_it.patches[0].get_facecolor()).upper() == style.STICKING
    assert on_it.patches[0].center[1] - on_it.patches[0].radius == pytest.approx(0.03)


def test_words_beside_a_cam_name_its_base_circle_and_its_corners_in_two_halves():
    axes = Figure().subplots()
    corners = {"a": 10.0, "b": 20.5, "c": 123.4567}
    mechanism._write_geometry(axes, outline(corners=corners))
    lines = [text.get_text() for text in axes.texts]
    assert lines[-2:] == [
        r"corners: a 10$\degree$, b 20.5$\degree$", r"c 123.46$\degree$"
    ]  # fmt: skip
    assert lines[:3] == [r"$\rho_0$", "20 mm", "base circle, around O"]
    rings = [mechanism.Ring("O", 0.0, 0.0, 0.02, r"$\rho_0$", "base circle"),
             mechanism.Ring("O", 0.0, 0.0, 0.03, r"$\rho_3$", "top dwell"),
             mechanism.Ring("O₁", 0.05, 300.0, 0.07, r"$\rho_1$", "flanks"),
             mechanism.Ring("O₂", 0.011, 170.0, 0.019, r"$\rho_2$", "nose")]  # fmt: skip
    phases = dict(zip("abcdefg", (95.0, 130.0, 160.0, 200.0, 230.0, 265.0, 300.0), strict=True))
    rows = mechanism._geometry_rows(outline(corners=phases, rings=rings, guessed=True))
    assert rows == [
        (r"$\rho_0$", "1.5 lifts", "base circle, A7, around O; not given"),
        (r"$\rho_1$", "70 mm", "flanks A1, A5"),
        (r"$\kappa_1$", "50 mm", "from O to O₁"),
        (r"$\rho_2$", "19 mm", "nose A2, A4"),
        (r"$\kappa_2$", "11 mm", "from O to O₂"),
        (r"$\rho_3$", "30 mm", "top dwell A3, around O"),
        (r"$\theta_1$", r"35$\degree$", "of A1, A5, at O"),
        (r"$\theta_2$", r"30$\degree$", "of A2, A4, at O"),
        (r"$\theta_3$", r"40$\degree$", "of A3, at O"),
    ]


def test_names_of_corners_stand_apart_in_the_directions_of_their_own():
    """In whatever order they are given: at 20 and 22 deg they are moved to 18 and 24."""
    axes = Figure().subplots()
    mechanism._draw_corners(axes, outline(corners={"a": 300.0, "c": 22.0, "b": 20.0}), 0.0)
    found = {text.get_text(): np.degrees(np.arctan2(*text.get_position())) % 360.0
             for text in axes.texts}  # fmt: skip
    assert found == {"a": pytest.approx(300.0), "b": pytest.approx(18.0), "c": pytest.approx(24.0)}
    dots = [line for line in axes.lines if line.get_marker() == "o"]
    away = [np.degrees(np.arctan2(*line.get_xydata()[0])) % 360.0 for line in dots]
    assert away == pytest.approx([20.0, 22.0, 300.0])


def test_a_moment_is_named_by_the_phase_within_its_turn():
    axes = Figure().subplots()
    moments = {"at rest": (0.0, 0.0), "in flight": (380.25, 0.002)}
    mechanism._draw_mechanism(axes, outline(corners={"a": 30.0}, ratio=1.5), moments)
    said = [text.get_text().replace("\n", " ") for text in axes.texts]
    assert [text for text in said if "deg" in text] == [
        r"at rest, $\theta$ = 0 deg", r"in flight, $\theta$ = 20.25 deg"
    ]  # fmt: skip
    assert [text for text in said if "(t)" in text] == ["$c(t)$/1.5", "$q(t)$/1.5"]


def test_positions_are_named_beside_a_plain_cam_alone():
    moments = {"in flight": (90.0, 0.002)}
    lobe = Made(roller=0.0, touches=[], beside=())
    x, y = np.array([0.0, 0.02, 0.0]), np.array([0.02, 0.0, -0.02])
    touches = [Made(place=place, theta=0.0, direction=0.0, along=0.02, beside=0.0)
               for place in zip(x, y, strict=True)]  # fmt: skip
    lobe.touches = touches
    for own, named in (({}, True), ({"flat": True}, False), ({"lobe": lobe}, False)):
        axes = Figure().subplots()
        mechanism._draw_mechanism(axes, outline(**own), moments)
        assert any("(t)" in text.get_text() for text in axes.texts) is named


def test_a_cam_that_is_very_low_where_it_begins_is_drawn():
    """The mark of its phase zero would be wider than the cam is there."""
    theta = np.linspace(0.0, 2.0 * pi, 721)
    low = outline(radius=0.002 + 0.028 * np.sin(theta / 2.0), corners={"a": 90.0})
    mechanism._draw_geometry(axes := Figure().subplots(), low)
    assert r"$\theta$ = 0" in [text.get_text() for text in axes.texts]


def test_the_follower_of_a_lobe_has_a_foot_as_wide_as_its_contact_wanders():
    """A flat face reaches the farthest contact on either side; a roller is a circle."""

    def foot(*beside):
        lobe = Made(roller=0.0, beside=[Made(value=x) for x in beside])
        axes = Figure().subplots()
        mechanism._follower(axes, outline(flat=True, lobe=lobe), 0.001, 0.0)
        return float(np.abs(axes.patches[0].get_xy()[:, 0]).max())

    assert foot(-0.012, 0.010) == pytest.approx(0.012)
    assert foot(-0.010, 0.013) == pytest.approx(0.013)
    assert foot(-0.001, 0.001) == pytest.approx(3.0 * 0.09 * 0.03)
    axes = Figure().subplots()
    rolling = Made(roller=0.004, beside=())
    mechanism._follower(axes, outline(lobe=rolling), 0.001, 180.0)
    (roller,) = axes.patches
    assert (roller.radius, roller.center) == (0.004, pytest.approx((0.0, 0.031)))


def test_the_point_touched_is_that_of_the_nearest_row_of_a_lobe():
    rows = [(10.0, 12.0, 0.02, 0.001), (20.0, 25.0, 0.03, -0.04), (30.0, 24.0, 0.05, 0.0)]
    touches = [Made(theta=radians(a), direction=radians(b), along=c, beside=d)
               for a, b, c, d in rows]  # fmt: skip
    found = outline(lobe=Made(touches=touches))
    assert found.touched(21.0) == pytest.approx((25.0, 0.05))
    assert found.touched(25.5) == pytest.approx((24.0, 0.05))
    assert outline().touched(180.0) == pytest.approx((180.0, 0.03))
    assert inf > found.touched(0.0)[1] > 0.02
