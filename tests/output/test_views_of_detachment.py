"""Which speeds and phases the diagram of detachment shows, its ticks, lines, numbers and names.

Studies are made by hand: phases in deg, speeds in rpm.
"""

from __future__ import annotations

from math import inf, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.plots import detach
from camcli.plots.detach import _View

MM = 300.0 / 25.4


def axes_of(wide=100.0, high=50.0):
    """Axes so many mm wide and high."""
    figure = Figure(figsize=(wide / 20.32, high / 20.32), dpi=300)
    FigureCanvasAgg(figure)
    return figure.add_axes((0.1, 0.1, 0.8, 0.8))


def critical(rpm, deg, region="b", burst="A1"):
    return Made(rpm=rpm, theta=radians(deg), region=region, burst=burst)


def study(*, speeds=(100.0, 200.0), impacts=(), accumulation=(), completion=(), hits=(), ends=(),
          opens=(120.0, 90.0), first=True):  # fmt: skip
    """impacts, ends: (rpm, deg), the ends of the region A1; opens: rpm, deg of A1's opening."""
    every = []
    for rpm in sorted({*speeds, *(x for x, _ in (*impacts, *ends))}):
        bursts = [Made(region="A1", end=radians(deg)) for x, deg in ends if x == rpm]
        every.append(Made(rpm=rpm, impacts=[radians(deg) for x, deg in impacts if x == rpm],
                          bursts=bursts, other_rests=()))  # fmt: skip
    loss = Made(region=Made(name="A1"), opens=Made(rpm=opens[0], theta=radians(opens[1])))
    lost = Made(rpm=opens[0], theta=radians(opens[1]), region="A1", finite=True)
    return Made(
        speeds=every, accumulation=list(accumulation), completion=list(completion), hits=list(hits),
        detachment=Made(first=lost if first else None, losses=[loss]),
    )  # fmt: skip


def hit(rpm, impact, corner="b"):
    return Made(rpm=rpm, impact=impact, corner=corner)


# --- ranges


def test_all_speeds_and_one_turn_from_the_first_loss_of_contact_with_room_beside_them():
    (whole,) = detach._views(study())
    assert whole.rpm == pytest.approx((97.0, 203.0))
    assert (whole.low, whole.high) == pytest.approx((90.0 - 10.8, 450.0 + 10.8))
    assert whole.fold == pytest.approx(90.0 - 1e-6, abs=1e-9)
    assert whole.phase([90.0, 89.0, 0.0]) == pytest.approx([90.0, 449.0, 360.0])
    (alone,) = detach._views(study(speeds=(200.0,)))
    assert alone.rpm == pytest.approx((198.0, 202.0))
    (held,) = detach._views(study(first=False))
    assert (held.low, held.high, held.fold) == (0.0, 360.0, 0.0)


def enlarged(**more):
    """The first of two views; None where there is only one."""
    views = detach._views(study(**more))
    return views[0] if len(views) == 2 else None


def test_what_is_enlarged_reaches_from_the_opening_to_the_last_of_two_corners():
    """6 % below the opening, 15 % above the corner, 12 % beside the speeds, with those of hits."""
    corners = [critical(130.0, 100.0), critical(140.0, 190.0, "c"), critical(135.0, 100.0),
               critical(150.0, 250.0, "d"), critical(122.0, 300.0, "b", "A2")]  # fmt: skip
    view = enlarged(accumulation=corners)
    assert (view.low, view.high) == pytest.approx((90.0 - 6.0, 190.0 + 15.0))
    assert view.rpm == pytest.approx((120.0 - 2.4, 140.0 + 2.4))
    view = enlarged(accumulation=corners, hits=[hit(145.0, 1), hit(170.0, 1, "c")])
    assert view.rpm == pytest.approx((117.0, 148.0))


def test_what_happens_beyond_the_only_corner_belongs_to_it():
    view = enlarged(accumulation=[critical(130.0, 100.0)], ends=[(125.0, 140.0)])
    assert (view.low, view.high) == pytest.approx((90.0 - 3.0, 140.0 + 7.5))


@pytest.mark.parametrize(("last", "found"), [(171.0, True), (171.8, False)])
def test_six_tenths_of_the_speeds_are_too_many_to_be_enlarged(last, found):
    """Of 106 rpm with the room beside them 63.6 with theirs: 1.24 times 51.29."""
    view = enlarged(accumulation=[critical(last, 190.0)])
    assert (view is not None) is found


@pytest.mark.parametrize(("deg", "found"), [(119.7, True), (119.9, False)])
def test_less_than_36_degrees_are_enlarged_at_all_speeds(deg, found):
    """1.21 times 29.75 deg from the opening at 90 deg."""
    view = enlarged(accumulation=[critical(190.0, deg)])
    assert (view is not None) is found
    if view is not None:
        assert view.rpm == pytest.approx((97.0, 203.0))


def shown(view=None, **more):
    """What is left of a view, of a machine with one corner at 180 deg."""
    system = Made(corners=[radians(180.0)])
    view = view or _View(79.2, 460.8, 90.0, (97.0, 203.0))
    return detach._without_empty(view, study(**more), system)


@pytest.mark.parametrize(("least", "slow"), [(112.8, 97.0), (113.0, 113.0 - 0.06 * 90.0)])
def test_speeds_without_anything_are_left_out(least, slow):
    """More than 15 of 106 rpm."""
    view = shown(impacts=[(least, 100.0)], opens=(150.0, 90.0))
    assert view.rpm == pytest.approx((slow, 203.0))


@pytest.mark.parametrize(("wide", "cut"), [(269.9, True), (270.1, False)])
def test_a_gap_of_a_quarter_turn_between_phases_is_left_out(wide, cut):
    """With 6 % of what is left as room on either side."""
    impacts = [(110.0, 5.0 + share * wide) for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
    view = shown(impacts=impacts)
    if cut:
        assert (view.low, view.high) == pytest.approx((5.0 - 0.06 * wide, 5.0 + 1.06 * wide))
        assert view.fold == pytest.approx(5.0 - 0.5 * (360.0 - wide))
    else:
        assert (view.low, view.high, view.fold) == (79.2, 460.8, 90.0)
    turns = [(rpm, deg + turn) for (rpm, deg), turn in
             zip(impacts, (0.0, 360.0, -360.0, 720.0, 0.0), strict=True)]  # fmt: skip
    later = shown(impacts=turns)  # the turn in which something happens does not count
    assert (later.low, later.high, later.fold) == pytest.approx((view.low, view.high, view.fold))
    whole = shown(impacts=impacts, completion=[critical(150.0, 90.0)])
    assert (whole.low, whole.high) == (79.2, 460.8)


def test_phases_that_are_close_have_four_degrees_of_room():
    view = shown(impacts=[(110.0, 100.0)], opens=(120.0, 90.0))
    assert (view.low, view.high) == pytest.approx((86.0, 104.0))


# --- axes, lines, marks


@pytest.mark.parametrize(
    ("wide", "step"),
    [(9.0, 1), (9.1, 2), (18.1, 5), (45.1, 10), (90.1, 20), (180.1, 60), (382.0, 60)],
)
def test_there_are_at_most_nine_ticks_of_phases(wide, step):
    axes = axes_of()
    detach._phase_axes(axes, _View(350.0, 350.0 + wide, 350.0, (1.0, 2.0)), {})
    ticks = [x for x in axes.get_yticks() if 350.0 <= x <= 350.0 + wide]
    assert set(np.diff(ticks)) == {step}
    assert axes.yaxis.get_major_formatter()(370.0, 0) == "10"
    further = axes.get_ylabel().endswith(",\non into the next turn")
    assert further == (350.0 + wide > 360.0)


@pytest.mark.parametrize(("jump", "lines"), [(20.0, 1), (20.1, 2), (-20.0, 1), (-20.1, 2)])
def test_ends_of_chatters_more_than_20_degrees_apart_are_no_line(jump, lines):
    assert len(detach.joined([(100.0, 90.0), (101.0, 90.0 + jump)])) == lines


@pytest.mark.parametrize(("between", "lines"), [(0, 1), (1, 1), (2, 2)])
def test_a_line_of_ends_goes_over_one_speed_without_one(between, lines):
    speeds = [100.0 + k for k in range(between + 2)]
    ends = [(speeds[0], 90.0), (speeds[-1], 91.0)]
    assert len(detach.joined(ends, speeds)) == lines


@pytest.mark.parametrize(("off", "found"), [(0.9e-9, 1), (1.1e-9, 0)])
def test_a_speed_is_that_of_a_proof_within_a_billionth(off, found):
    axes = axes_of()
    view = _View(0.0, 360.0, 0.0, (100.0, 200.0))
    told = study(hits=[hit(150.0, 1)], opens=(120.0, 90.0))
    detach._draw_proved(axes, view, told, {"b": 180.0}, [150.0 * (1.0 + off)])
    assert len(axes.lines) == found
    for line in axes.lines:
        assert (line.get_xdata()[0], line.get_ydata()[0]) == (150.0, 180.0)
        assert 2.0 <= line.get_markersize() - 5.5 <= 5.0  # a rim of 1 to 2.5 pt around the mark


@pytest.mark.parametrize(("away", "numbers"), [(3.9, ["1"]), (4.1, ["1", "2"])])
def test_numbers_of_hits_of_one_corner_are_four_millimetres_apart(away, numbers):
    """In a panel of 100 mm for 100 rpm; those of another corner do not count."""
    axes = axes_of(100.0)
    view = _View(0.0, 360.0, 0.0, (100.0, 200.0))
    hits = [hit(150.0, 1), hit(150.0 + away, 2), hit(151.0, 7, "c"), hit(99.0, 8), hit(201.0, 9)]
    detach._draw_hits(axes, view, study(hits=hits), {"b": 180.0, "c": 90.0})
    assert [text.get_text() for text in axes.texts] == [*numbers, "7"]
    only = axes_of(100.0)
    only.set_xlim(100.0, 200.0)
    detach._draw_hits(only, view, study(hits=hits[:2]), {"b": 180.0, "c": 90.0})
    assert [text.get_text() for text in only.texts] == ["1", "2"]  # above the panel, moved apart


@pytest.mark.parametrize(("deg", "drawn", "name"), [
    (90.0, 450.0, "on a corner"), (80.0, 440.0, "where contact is lost"),
])  # fmt: skip
def test_a_chatter_of_a_whole_turn_ends_a_turn_after_the_loss_of_contact(deg, drawn, name):
    """Of a cam whose loss of contact stays at its corner, and of one where it comes earlier."""
    axes = axes_of()
    found = study(completion=[critical(150.0, deg)])
    view = _View(79.2, 460.8, 90.0 - 1e-6, (97.0, 203.0))
    detach._draw_critical_ends(axes, view, found, {"b": 90.0})
    (mark,) = axes.lines
    assert mark.get_label() == f"the chatter ends {name}"
    assert mark.get_xydata().tolist() == [[150.0, pytest.approx(drawn)]]


def test_what_is_enlarged_is_a_small_part_of_what_is_left():
    """Of speeds, six tenths at most, or less than 36 deg."""
    whole = _View(0.0, 360.0, 0.0, (100.0, 200.0))
    for part, small in (((100.0, 159.0), True), ((100.0, 161.0), False)):
        assert detach._is_small_part(_View(0.0, 200.0, 0.0, part), whole) is small
    assert detach._is_small_part(_View(0.0, 35.0, 0.0, (100.0, 200.0)), whole)


def test_an_end_without_a_line_is_a_larger_point():
    axes = axes_of()
    found = study(ends=[(100.0, 100.0), (101.0, 101.0), (150.0, 200.0)])
    detach._draw_ends(axes, _View(0.0, 360.0, 0.0, (90.0, 200.0)), found)
    line, alone = axes.lines
    assert line.get_xydata().tolist() == pytest.approx(np.array([[100.0, 100.0], [101.0, 101.0]]))
    assert alone.get_xydata().tolist() == pytest.approx(np.array([[150.0, 200.0]]))
    assert alone.get_markersize() > line.get_markersize()


# --- surge, machines, forces


def harmonic(number, rpm, factor, strong=False):
    return Made(number=number, rpm=rpm, factor=factor, strong=strong)


def surge_of(*harmonics, wide=100.0, **more):
    axes = axes_of(wide)
    study_ = study(speeds=(50.0, 200.0), **more)
    detach._draw_surge(axes, Made(harmonics=harmonics, surge_rpm=900.0, hz=15.0), study_)
    return axes


@pytest.fixture
def _no_title(monkeypatch):
    monkeypatch.setattr(detach, "surge_title", lambda surge: "surge")


@pytest.mark.usefixtures("_no_title")
def test_harmonics_are_shown_up_to_a_quarter_beyond_the_fastest_speed():
    axes = surge_of(harmonic(3, 249.0, 4.0), harmonic(2, 251.0, 9.0), harmonic(9, 60.0, 20.0, True))
    stems = {tuple(line.get_xdata()): line for line in axes.lines if len(line.get_xdata()) == 2}
    assert (249.0, 249.0) in stems
    assert (251.0, 251.0) not in stems
    assert axes.get_ylim() == pytest.approx((0.0, 1.2 * max(detach.LIMIT, 20.0)))
    strong, weak = (to_hex(stems[x, x].get_color()).upper() for x in (60.0, 249.0))
    assert (strong, weak) == ("#CC5E0F", "#4D4D4D")
    beyond = surge_of(harmonic(2, 374.0, 9.0), opens=(300.0, 90.0))
    assert any(list(line.get_xdata()) == [374.0, 374.0] for line in beyond.lines)


@pytest.mark.usefixtures("_no_title")
@pytest.mark.parametrize(("away", "numbers"), [(4.9, ["2"]), (5.1, ["2", "3"])])
def test_numbers_of_harmonics_are_five_millimetres_apart_the_strong_ones_first(away, numbers):
    low, high = surge_of(harmonic(3, 100.0, 4.0), harmonic(2, 150.0, 9.0)).get_xlim()
    room = away * (high - low) / 100.0
    axes = surge_of(harmonic(4, 100.0, 1.0), harmonic(3, 150.0 - room, 4.0),
                    harmonic(2, 150.0, 9.0))  # fmt: skip
    found = [text.get_text() for text in axes.texts]
    assert sorted(found) == sorted([*numbers, "4"])


@pytest.mark.parametrize(("count", "bins"), [(4, 5), (40, 6), (100, 10), (900, 30), (2500, 30)])
def test_machines_are_counted_in_as_many_bars_as_the_root_of_their_number(count, bins):
    speeds = [100.0 + k / count for k in range(count)]
    axes = axes_of()
    spread = Made(speeds=[*speeds, inf], worst=99.0)
    detach._draw_machines(axes, spread, 103.0)
    assert len(axes.patches) == bins
    assert sum(patch.get_height() for patch in axes.patches) == count
    lines = {line.get_label(): line.get_xdata()[0] for line in axes.lines}
    assert lines == pytest.approx({
        "half of the machines": np.median(speeds), "the machine as given": 103.0,
        "the worst machine": 99.0,
    })  # fmt: skip


@pytest.mark.parametrize(("wide", "columns"), [(109.0, 1), (111.0, 2)])
def test_names_of_forces_stand_in_two_columns_in_a_wide_panel(wide, columns):
    axes = axes_of(wide)
    curves = [Made(theta=np.array([0.0, 6.0]), force_n=np.array([1.0, 2.0]), rpm=9.0, lowest_n=1.0)]
    detach._draw_forces(axes, curves * 2, ["one", "other"], {"b": 200.0})
    legend = axes.get_legend()
    assert legend._ncols == columns
    axes.figure.draw_without_rendering()
    names = [text for text in axes.texts if text.get_text() == "b"]
    foot = legend.get_window_extent().y0
    assert 0.0 <= (foot - axes.bbox.y1) / MM <= 0.15 * 50.0  # above the corners' names, near
    assert all(text.get_window_extent().y1 <= foot + 1.0 for text in names)


def test_names_above_a_panel_have_room():
    assert [detach._room_for(names) for names in (0, 1, 4)] == pytest.approx([0.0, 7.4, 17.6])
