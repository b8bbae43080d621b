"""The rules by which a picture chooses its ranges, units, ticks, shades and names.

Each has its cases just inside and just outside, with the answer worked out by hand.
"""

from __future__ import annotations

from contextlib import nullcontext
from math import degrees
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.figure import Figure

from camcli.analysis.labels import Label
from camcli.plots import style
from camcli.plots.axes import (
    axis_name,
    draw_forces,
    gathered,
    length_axis,
    number_events,
    padded,
    phase_range,
    spread,
)
from camcli.plots.branch_lines import Strand, draw_real
from camcli.plots.density import Columns, _first_to_last
from camcli.plots.orbits import _over_parameter
from camcli.plots.picture import Panel, Picture, _rows, _title_lines
from camcli.plots.sweep import draw_sweep, enlarged_range
from camcli.scene.schema import Plot
from camcli.words.in_print import (
    label_text,
    newtons,
    number_text,
    one_of,
    pair,
    range_of,
    valued,
)
from tests.conftest import settings
from tests.support.picture_sizes import png, speed, sweep_of


@pytest.fixture
def axes():
    return Figure().add_subplot()


@pytest.mark.parametrize(
    ("values", "more", "wanted"),
    [
        ([], {}, (0.0, 1.0)),
        ([2.0, 12.0], {}, (1.6, 12.4)),
        ([-3.0, 7.0, 1.0], {}, (-3.4, 7.4)),
        ([50.0, 50.0], {}, (45.0, 55.0)),
        ([-50.0], {}, (-55.0, -45.0)),
        ([50.0, 50.00004], {}, (45.0, 55.00004)),  # less than a millionth is no width
        ([50.0, 50.0], {"constant": 2.0}, (48.0, 52.0)),
        ([0.0], {}, (-1.0, 1.0)),
        ([0.0], {"zero": 0.25}, (-0.25, 0.25)),
    ],
)
def test_ranges_have_a_margin(values, more, wanted):
    assert padded(values, **more) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize(
    ("values", "wanted"),
    [
        ([], (0.0, 360.0)),
        ([100.0, 200.0], (96.0, 204.0)),
        ([100.0, 211.0], (95.56, 215.44)),  # 119.88 wide with its margin
        ([100.0, 211.2], (0.0, 360.0)),
        ([1.0, 41.0], (0.0, 42.6)),
        ([320.0, 359.0], (318.44, 360.0)),
        ([30.0], (25.0, 35.0)),
    ],
)
def test_phases_close_together_fill_a_panel(values, wanted):
    assert phase_range(values) == pytest.approx(wanted)


def cloud(low, high):
    low, high = np.array(low, float), np.array(high, float)
    return Made(extremes=lambda: np.array([*low, *high]), ends=lambda: (low, high))


def test_phases_at_many_speeds_and_nowhere_else_are_enlarged():
    """At two fifths of the speeds, within half of 120 deg."""
    for many, wanted in ((16, (148.4, 191.6)), (15, None)):
        low = [150.0] * many + [10.0] * (40 - many)
        high = [190.0] * many + [350.0] * (40 - many)
        found = enlarged_range(cloud(low, high))
        assert found == (None if wanted is None else pytest.approx(wanted))
    assert enlarged_range(cloud([], [])) is None
    alike = cloud([150.0] * 9, [190.0] * 9)
    assert enlarged_range(alike) is None  # the panel shows no more
    assert enlarged_range(alike, [5.0, 355.0]) == pytest.approx((148.4, 191.6))  # orbits widen it
    apart = cloud([10.0] * 20 + [200.0] * 20, [60.0] * 20 + [250.0] * 20)
    assert enlarged_range(apart) is None  # from 10 to 250 deg
    wide = cloud([100.0] * 20 + [0.0] * 20, [160.5] * 20 + [350.0] * 20)
    assert enlarged_range(wide) is None


def test_phases_of_some_speeds_count_where_others_fill_the_turn():
    def shown(low, high):
        return gathered(np.array(low, float), np.array(high, float)).tolist()

    few, whole = ([150.0] * 2, [210.0] * 2), ([0.0] * 3, [350.0] * 3)
    both = [few[k] + whole[k] for k in (0, 1)]
    assert shown(*both) == [150.0, 210.0]  # two fifths
    assert shown(few[0] + [0.0] * 4, few[1] + [350.0] * 4) == [0.0, 350.0]  # a third
    assert shown([150.0] * 2 + [0.0] * 3, [211.0] * 2 + [350.0] * 3) == [0.0, 350.0]  # 61 deg wide
    assert shown([100.0, 150.0], [105.0, 200.0]) == [100.0, 200.0]  # all fit
    assert shown([], []) == []


@pytest.mark.parametrize(
    ("largest", "ticks"),
    [
        (4.0, None),
        (40.0, [-10, -1, 0, 1, 10]),
        (5e3, [-1e3, -1e2, -10, -1, 0, 1, 10, 1e2, 1e3]),
        (2e7, [-1e6, -1e4, -1e2, -1, 0, 1, 1e2, 1e4, 1e6]),
    ],
)
def test_large_multipliers_have_powers_of_ten_beside_the_axis(axes, largest, ticks):
    draw_real(axes, [[Strand(True, [1.0, 2.0], [0.5 + 9e9j, -largest + 0j])]], ["#000000"])
    if ticks is None:
        assert axes.get_yscale() == "linear"
        return
    assert axes.get_yscale() == "asinh"
    assert axes.get_yticks().tolist() == ticks
    texts = [text.get_text() for text in axes.get_yticklabels()]
    assert [float(text.replace("−", "-")) for text in texts] == ticks
    assert axes.get_ylabel().endswith("(asinh scale)")


def test_a_range_of_one_value_has_room(axes):
    def limits(low, high):
        scene = Made(study=Made(question=Made(span=None)), every=lambda of: np.array([low, high]),
                     parameter="rpm", events=[])  # fmt: skip
        _over_parameter(axes, scene, False)
        return axes.get_xlim()

    low, high = limits(700.0, 720.0)
    assert 700.0 - low == pytest.approx(high - 720.0)
    assert 0.0 < 700.0 - low < 2.0
    assert limits(700.0, 700.0) == pytest.approx((693.0, 707.0))
    assert limits(0.0, 0.0) == pytest.approx((-1.0, 1.0))


def test_what_pulls_is_shaded_only_where_something_does(axes):
    angle = np.linspace(0.0, 360.0, 5)

    def drawn(*forces):
        axes.clear()
        draw_forces(axes, [Made(theta=np.radians(angle), force_n=force) for force in forces])
        return [patch.get_height() for patch in axes.patches], axes.get_ylim()[0]

    pressing, pulling = [0.0, 5.0, 9.0, 5.0, 0.0], [3.0, 5.0, -2.0, 5.0, 3.0]
    shades, low = drawn(pressing)
    assert shades == []
    assert low < 0.0  # matplotlib's margin
    for some in ((pulling,), (pressing, pulling)):
        (shade,), low = drawn(*some)
        assert shade == pytest.approx(-low)
        assert low < -2.0


@pytest.mark.parametrize(
    ("speeds", "room"),
    [
        (np.linspace(700.0, 800.0, 101), 0.5),  # half a step
        (np.linspace(700.0, 800.0, 26), 2.0),
        (np.linspace(700.0, 800.0, 11), 2.0),  # a fiftieth of the range at most
        ([700.0, 800.0], 2.0),
        ([700.0], 7.0),  # a hundredth
        ([0.0], 1e-6),
    ],
)
def test_points_of_the_first_and_the_last_speed_have_room_beside_them(speeds, room):
    columns = Columns.of(speeds)
    assert (columns.low, columns.high) == pytest.approx((speeds[0] - room, speeds[-1] + room))


def test_lengths_have_a_unit_that_suits_them(axes):
    def unit(largest):
        length_axis(axes.xaxis, "gap", largest)
        axes.set_xlim(0.0, largest)
        return axes.get_xlabel()

    assert "(m)" in unit(0.02)
    assert "(mm)" in unit(0.0199)
    assert "(mm)" in unit(2e-5)
    assert "(µm)" in unit(1.99e-5)


def test_names_beside_an_axis_stand_apart():
    assert spread([1.0, 5.0, 9.0], 2.0, 0.0, 10.0) == [1.0, 5.0, 9.0]
    assert spread([4.0, 5.0, 6.0], 2.0, 0.0, 10.0) == [3.0, 5.0, 7.0]
    assert spread([1.0, 5.0, 5.0], 2.0, 0.0, 10.0) == [1.0, 4.0, 6.0]
    assert spread([0.0, 0.5, 9.9, 10.0], 2.0, 0.0, 10.0) == pytest.approx([0.0, 2.0, 8.0, 10.0])
    assert spread([5.0] * 3, 99.0, 0.0, 10.0) == [0.0, 5.0, 10.0]  # no room for so much
    assert spread([], 2.0, 0.0, 10.0) == []


def test_names_and_numbers():
    assert axis_name("rpm") == axis_name("run.rpm") == "cam speed (rpm)"
    assert axis_name("follower.restitution") == "coefficient of restitution $r$ (-)"
    assert axis_name("follower.mass") == "mass $m$ (kg)"
    assert axis_name("cam.lift") == "lift of the cam (m)"
    assert axis_name("cam.mass") == "mass of the oscillator $m$ (kg)"
    assert valued("rpm", "700") == "700 rpm"
    assert valued("follower.restitution", "0.8") == "coefficient of restitution 0.8"
    assert valued("follower.mass", "2", 700.5) == "mass 2 kg at 700.5 rpm"
    assert [one_of(key) for key in ("run.rpm", "follower.mass")] == ["speed", "value"]
    assert [newtons(x, 4) for x in (12.3456, -0.5, -1e-9)] == ["12.35 N", "−0.5 N", "0 N"]
    assert pair(1.0, 0.25) == "0.5"
    assert pair(-2.5, 1.0) == "−2, −0.5"
    assert pair(0.6, 0.25) == "0.3 ± 0.4i"
    assert number_text(-198.56) == "−198.56"
    assert label_text("P(1;inf)") == "P(1;∞)"
    assert label_text("P(3;3:3:2)", 10) == "P(3;3:3:2)"
    assert label_text("P(3;3:3:2)", 9) == "P(3;3:3…)"
    assert style.corner_names([1.5, 0.5, 1.0]) == {
        "a": degrees(0.5),
        "b": degrees(1.0),
        "c": degrees(1.5),
    }


def test_shades():
    assert style.mixed("#000000", 0.25) == "#404040"
    assert style.mixed("#FF0000", 0.5, "black") == "#800000"
    red, blue = "#FF0000", "#0000FF"
    found = style.apart([red, blue, red, red, blue])
    assert found[:2] == [red, blue]
    assert len(set(found)) == 5
    assert found[2] == style.mixed(red, 0.45)
    assert found[4] == style.mixed(blue, 0.45)
    assert style.label_colour(Label((1.0,) * 4)) == style.PERIODS[3]
    assert style.label_colour(Label((1.0,) * 5)) == style.LONGER


@pytest.mark.parametrize(
    ("across", "named", "width", "rows"),
    [
        ((2, 2, 2), False, 110.0, [2, 1]),  # 55 mm each
        ((2, 2, 2), False, 109.0, [1, 1, 1]),
        ((2, 2, 2), True, 54.0, [2, 1]),  # numbers of its own are left out: 27 mm
        ((2, 2, 2), True, 53.0, [1, 1, 1]),
        ((1, 3, 3, 3, 3, 1), False, 165.0, [1, 3, 1, 1]),
        ((3, 3, 3), False, 164.0, [2, 1]),
        ((2, 3, 3), False, 300.0, [1, 2]),
        ((2, 2), False, 20.0, [1, 1]),
    ],
)
def test_narrow_panels_stand_side_by_side(across, named, width, rows):
    panels = {k: Made(across=n, y="q" if named else "", number=k) for k, n in enumerate(across)}
    found = _rows(panels, width)
    assert [len(row) for row in found] == rows
    assert [panel.number for row in found for _, panel in row] == list(range(len(across)))
    assert [name for row in found for name, _ in row] == list(range(len(across)))


def test_a_panel_that_is_left_out_is_shown_in_no_other():
    """Not even where one that was asked for stands behind it, and stays."""

    def band(axes, letter):
        axes.text(0.5, 0.5, letter)

    panels = {
        "one": Panel(lambda axes: None, 60.0),
        "left out": Panel(lambda axes: None, 60.0, shown_in={"one": band}),
        "asked": Panel(lambda axes: None, 60.0, asked=True),
    }
    low = Picture("Title", panels).figure(Plot(width=170.0, height=130.0))
    assert low.left_out == ["left out"]
    assert [text.get_text() for text in low.axes[1].texts] == []
    high = Picture("Title", panels).figure(Plot(width=170.0, height=230.0))
    assert [text.get_text() for text in high.axes[1].texts] == ["(b)"]


def test_a_legend_has_rows_that_are_as_full_as_they_can_be():
    """Seven names that need two rows stand in four columns: none of them alone in its row."""

    def draw(axes):
        for number in range(7):
            axes.plot([], [], label=f"name of line {number}")

    page = Picture("Title", {"one": Panel(draw, 60.0)}).figure(Plot(width=170.0))
    page.draw_without_rendering()
    texts = page.axes[0].get_legend().get_texts()
    tops = [text.get_window_extent(page.canvas.get_renderer()).y1 for text in texts]
    in_first_row = [max(tops) - top < 10.0 for top in tops]
    assert in_first_row == [True, False] * 3 + [True]


def test_several_panels_have_letters_in_reading_order_and_one_has_none():
    def titled(axes):
        axes.set_title("event 3", loc="left")

    plain = Panel(lambda axes: None, 30.0)
    half = Panel(titled, 30.0, across=2)

    def letters(panels, width=170.0):
        figure = Picture("Title", panels).figure(Plot(width=width))
        return [axes.get_title(loc="left") for axes in figure.axes[1:]]

    assert letters({"one": plain}) == [""]
    assert letters({"one": half}) == ["event 3"]
    assert letters({"one": plain, "two": plain}) == ["(a)", "(b)"]
    several = {"one": plain, "two": plain, "three": half, "four": half}
    assert letters(several) == ["(a)", "(b)", "(c) event 3", "(d) event 3"]


def test_ticks_that_are_kept_are_those_that_would_be_made_again(monkeypatch):
    """The layout makes panels smaller, so that other ticks have room, and moves their numbers."""

    def powers(axes):
        axes.loglog([1.0, 3e7], [1e-9, 3.0])
        axes.set(xlabel="many", ylabel="powers of ten", title="above\nit")

    def beside(axes):
        axes.plot([1.0, 1e5], [1e-9, 3.0])
        axes.set_yscale("log")
        axes.tick_params(axis="x", top=True, labeltop=True, labelrotation=90)
        axes.set_title("beside", loc="center")

    panels = {
        "one": Panel(powers, 60.0, beside=(beside, beside)),
        "two": Panel(lambda axes: axes.plot([0.0, 123456.0], [0.0, 1e-6]), 30.0, across=2),
        "three": Panel(lambda axes: axes.set(aspect="equal", xlabel="x"), 30.0, across=2),
    }
    kept = png(Picture("Title", panels))
    monkeypatch.setattr("camcli.plots.picture._ticks_made_once", nullcontext)
    assert kept == png(Picture("Title", panels))


def test_a_sweep_in_a_column_of_a_journal_is_at_most_120_mm_tall(chapter):
    speeds = [speed(660.0 + k, [100.0 + 10.0 * k], [1.0 + k]) for k in range(20)]
    picture = draw_sweep(sweep_of(*speeds), chapter, settings())
    for width in (70, 85, 90):
        assert picture.figure(Plot(width=width)).get_figheight() * 25.4 <= 120.0 + 1e-9
    assert picture.figure(Plot(width=170)).get_figheight() * 25.4 > 120.0


def test_the_whole_phases_of_a_sweep_are_shorter_above_the_enlarged_ones(chapter):
    few = [speed(660.0 + k, [150.0, 190.0] if k else [10.0, 350.0], [1.0]) for k in range(20)]
    heights = {name: panel.height for name, panel in drawn(few, chapter).items()}
    assert heights["impacts"] < heights["enlarged"]
    alone = drawn([speed(660.0 + k, [100.0 + k], [1.0]) for k in range(20)], chapter)
    assert "enlarged" not in alone
    assert alone["impacts"].height > heights["enlarged"]


def drawn(speeds, system):
    return draw_sweep(sweep_of(*speeds), system, settings()).panels


def test_events_at_the_very_ends_of_an_axis_are_numbered_and_those_beyond_are_not(axes):
    axes.set_xlim(700.0, 720.0)
    number_events(axes, [(3, 720.0), (1, 700.0), (2, 699.9), (4, 720.1), (None, 710.0)], True)
    assert [line.get_xdata()[0] for line in axes.lines] == [700.0, 710.0, 720.0]
    assert [(text.get_text(), text.xy[0]) for text in axes.texts] == [("1", 700.0), ("3", 720.0)]
    axes.clear()
    axes.set_xlim(700.0, 720.0)
    number_events(axes, [(3, 720.0), (1, 700.0)], False)
    assert (len(axes.lines), len(axes.texts)) == (2, 0)


def test_no_line_of_a_title_begins_with_the_unit_of_a_number():
    title = "Bifurcation diagram, nose radius 0.1 to 0.2 m at 700 rpm"
    assert _title_lines(title, 44) == [
        "Bifurcation diagram, nose radius",
        "0.1 to 0.2 m at 700 rpm",
    ]
    assert _title_lines("Detachment and chattering, 3000 to 4000 rpm", 37) == [
        "Detachment and chattering,",
        "3000 to 4000 rpm",
    ]
    assert _title_lines("Cam at 3 N/m or 2 minutes", 14) == ["Cam at 3 N/m", "or 2 minutes"]
    assert _title_lines("Cam at 3 N/m or 2 minutes", 9) == ["Cam at", "3 N/m or", "2 minutes"]


@pytest.mark.parametrize(
    ("seen", "aside", "kept"),
    [
        ([3, 5], 0, (3, 6)), ([3, 5], 2, (1, 8)), ([1, 8], 2, (0, 10)), ([0], 0, (0, 1)),
        ([9], 1, (8, 10)), ([], 0, (0, 0)), ([], 3, (0, 0)), (range(10), 1, (0, 10)),
    ],
)  # fmt: skip
def test_what_is_kept_of_an_image_reaches_so_far_beyond_what_is_seen(seen, aside, kept):
    found = np.zeros(10, dtype=bool)
    found[list(seen)] = True
    assert _first_to_last(found, aside) == slice(*kept)


@pytest.mark.parametrize(
    ("ends", "told"),
    [
        ((660.0, 760.0), "660 to 760"), ((-5.0, -3.0), "−5 to −3"), ((-5.0, 3.0), "−5 to 3"),
        ((7.0, 7.0), "7"), ((-7.0, -7.0), "−7"),
    ],
)  # fmt: skip
def test_a_range_in_print_has_a_minus_sign_at_either_end(ends, told):
    assert range_of(*ends) == told
