"""Panels of stubs made by hand: what is drawn where, in which colour, and which of two it is."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.analysis.labels import Label
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.errors import Status
from camcli.plots import axes as own_axes
from camcli.plots import (
    basins,
    bench,
    branch_lines,
    cam_profile,
    chaos,
    classify,
    critical_speeds,
    density,
    detach,
    discs,
    mechanism,
    orbits,
    picture,
    proofs,
    style,
    sweep,
    sweep_map,
)
from camcli.plots.picture import Panel, Picture
from camcli.quantities import METRES, MILLIMETRES
from tests.output.test_views_of_detachment import axes_of, critical, hit, study


@pytest.fixture
def axes():
    return Figure().subplots()


# --- sweeps


class FakeImage:
    """An image of a cloud that notes what it is given."""

    made: list[FakeImage]

    def __init__(self, columns, low, high, height, thickness):
        self.limits, self.height, self.thickness = (low, high), height, thickness
        self.taken: list = []
        self.drawn: list = []
        self.made.append(self)

    def take(self, k, values):
        self.taken.append((k, list(values)))

    def draw(self, axes, colour, opaque=1.0):
        self.drawn.append((colour, opaque))


def cloud(low, high):
    found = density.Cloud(len(low))
    for k, ends in enumerate(zip(low, high, strict=True)):
        found.take(k, np.array(ends))
    return found


def swept(direction, ways, monkeypatch):
    """The panels of three speeds of two kinds, with their images."""
    FakeImage.made = []
    monkeypatch.setattr(sweep, "Image", FakeImage)
    monkeypatch.setattr(sweep, "cam_beside", lambda *how: (how,))
    monkeypatch.setattr(
        sweep, "strobe_axis", lambda axis, system, words: axis.set_label_text(words)
    )
    own = [([0, 1], [100.0 + k, 200.0]) for k in range(3)]
    speeds = [Made(impacts=own[k], strobe=([0], [0.001 * k])) for k in range(3)]
    survey = sweep.DrawnSpeeds(
        np.array([700.0, 710.0, 720.0]), np.zeros(3, int), ["aperiodic", "period 1", "aperiodic"],
        np.full(3, nan), cloud([100.0, 101.0, 102.0], [200.0] * 3),
        cloud([0.0, 0.001, 0.002], [0.0, 0.001, 0.002]),
    )  # fmt: skip
    found = Made(direction=direction, ways=[(way, 0) for way in ways], speeds=speeds, key="rpm")
    system = Made(lift=0.01, corners=[radians(90.0)])
    return sweep.cloud_panels(survey, found, system, zooms=[(705.0, 715.0)], shown_cam="below")


def test_each_kind_of_motion_and_each_way_has_an_image_of_its_own(monkeypatch):
    """What is carried down is drawn first, wide and pale."""
    panels = swept(sweep.BOTH, ["up", "down", "down"], monkeypatch)
    assert list(panels) == ["impacts", "strobe", "impacts zoom 1", "strobe zoom 1"]
    assert [(panel.x, panel.across, len(panel.beside)) for panel in panels.values()] == [
        ("rpm", 1, 1), ("rpm", 1, 0), ("", 2, 0), ("", 2, 0)
    ]  # fmt: skip
    assert panels["impacts"].beside[0][-2:] == ("", "below")
    first = FakeImage.made[:4]  # of period 1 and aperiodic, each down and up
    assert [image.thickness for image in first] == [7, 3, 7, 3]
    assert [image.taken for image in first] == [
        [(1, [101.0, 200.0])], [], [(2, [102.0, 200.0])], [(0, [100.0, 200.0])]
    ]  # fmt: skip
    axes = Figure().subplots()
    panels["impacts"].draw(axes)
    period_1, aperiodic = style.PERIODS[0], style.APERIODIC
    assert [image.drawn for image in first] == [
        [(period_1, 0.3)], [(period_1, 1.0)], [(aperiodic, 0.3)], [(aperiodic, 1.0)]
    ]  # fmt: skip
    legend = [line.get_label() for line in axes.lines if not line.get_label().startswith("_")]
    assert legend == ["period 1", "aperiodic", "carried up", "carried down"]
    panels = swept("up", ["up"] * 3, monkeypatch)
    assert [image.thickness for image in FakeImage.made[:2]] == [3, 3]
    panels["strobe"].draw(axes)
    assert FakeImage.made[2].drawn == [(period_1, 1.0)]
    swept("down", ["down"] * 3, monkeypatch)  # one way alone is drawn as usual
    assert {image.thickness for image in FakeImage.made} == {3}


def survey(strobe=None, impacts=None, count=12):
    return Made(impacts=impacts, strobe=strobe, values=np.linspace(600.0, 711.0, count))


def test_positions_are_enlarged_between_the_tenths_of_the_lowest_and_the_highest():
    """Of more than ten speeds, where that is less than three tenths of all."""
    low, high = np.full(12, 0.010), np.linspace(0.011, 0.0121, 12)
    high[-1] = 0.100
    views = sweep._views(survey(cloud(low, high)), (), 0.01, (), {})
    assert list(views) == ["strobe", "strobe enlarged"]
    inner = np.quantile(high, 0.9)
    room = 0.04 * (inner - 0.010)
    assert views["strobe enlarged"].limits == pytest.approx((0.010 - room, inner + room))
    assert views["strobe"].limits == pytest.approx((0.010 - 0.0036, 0.100 + 0.0036))
    few = sweep._views(survey(cloud(low[-10:], high[-10:]), count=10), (), 0.01, (), {})
    assert list(few) == ["strobe"]
    high[:] = np.linspace(0.011, 0.1, 12)
    assert list(sweep._views(survey(cloud(low, high)), (), 0.01, (), {})) == ["strobe"]


def test_phases_are_enlarged_where_most_have_few_of_them():
    own = cloud([100.0] * 8 + [0.0] * 4, [125.0] * 8 + [360.0] * 4)
    views = sweep._views(survey(impacts=own), (), 0.01, (), {})
    assert {name: (view.limits, view.height) for name, view in views.items()} == {
        "impacts": ((0.0, 360.0), 48.0), "enlarged": ((99.0, 126.0), 60.0)
    }  # fmt: skip
    whole = sweep._views(survey(impacts=cloud([0.0] * 12, [360.0] * 12)), (), 0.01, (), {})
    assert [(name, view.height) for name, view in whole.items()] == [("impacts", 72.0)]


def test_limits_that_are_given_hold_for_what_was_recorded_and_zooms_for_their_part():
    own = cloud(np.full(12, 0.010), np.full(12, 0.020))
    given = {"impacts": (10.0, 50.0), "strobe": (0.0, 0.5)}
    views = sweep._views(survey(own), (), 0.01, (), given)
    assert {name: view.limits for name, view in views.items()} == {"strobe": (0.0, 0.5)}
    solved = Made(values=[610.0, 700.0], q=[0.015, 0.5], phases=[[10.0, 20.0]])
    views = sweep._views(survey(own), [(600.0, 650.0)], 0.01, [solved], {"impacts": None})
    assert views["strobe"].limits == pytest.approx((0.010 - 0.0196, 0.5 + 0.0196))
    assert views["strobe zoom 1"].limits == pytest.approx((0.0096, 0.0204))
    assert sweep._views(survey(), (), 0.01, [solved], {}) == {}


def test_the_letter_of_a_band_stands_beside_it_on_either_side(axes, monkeypatch):
    places = []
    monkeypatch.setattr(sweep, "_write_beside_points", lambda a, b, some, d: places.append(some))
    sweep._band(axes, "(b)", "y", (10.0, 30.0))
    sweep._band(axes, "(b)", "x", (1.0, 3.0))
    assert places == [
        [(0.99, 30.0, "right", "bottom"), (0.99, 10.0, "right", "top"),
         (0.01, 30.0, "left", "bottom"), (0.01, 10.0, "left", "top")],
        [(3.0, 0.98, "left", "top"), (1.0, 0.98, "right", "top"),
         (3.0, 0.02, "left", "bottom"), (1.0, 0.02, "right", "bottom")],
    ]  # fmt: skip


def test_the_cam_beside_phases_is_in_the_units_of_the_machine_with_words_below_the_middle(
    monkeypatch,
):
    theta = np.array([0.0, 90.0])
    orders = [np.array([0.001, 0.002]), np.array([0.003, 0.004]), np.array([0.005, 0.006])]
    monkeypatch.setattr(sweep, "lift_curves", lambda cam, count: (theta, orders[:count]))
    monkeypatch.setattr(sweep, "units_of", lambda system: MILLIMETRES)
    draws = sweep.cam_beside(Made(cam=None, corners=[]), 0.0, 360.0, ", enlarged", "cam at 2 mm")
    notes, names = [], []
    for k, draw in enumerate(draws):
        axes = Figure().subplots()
        draw(axes)
        curve = next(line for line in axes.lines if len(line.get_xdata()) == 2)
        assert curve.get_xdata() == pytest.approx(1e3 * orders[k])
        assert list(curve.get_ydata()) == [0.0, 90.0]
        notes.append([text.get_text() for text in axes.texts])
        names.append(axes.get_ylabel())
    assert notes == [[], ["cam at 2 mm"], []]
    assert names[0].endswith(", enlarged")
    assert names[1:] == ["", ""]


def test_the_first_speed_of_a_part_counts_and_a_part_without_points_says_what_is_missing(
    monkeypatch,
):
    own = cloud([0.5, 0.1, 0.2], [0.6, 0.15, 0.25])
    three = Made(impacts=None, strobe=own, values=np.array([600.0, 650.0, 700.0]))
    views = sweep._views(three, [(600.0, 650.0)], 0.01, (), {})
    assert views["strobe zoom 1"].limits == pytest.approx((0.08, 0.62))
    FakeImage.made = []
    monkeypatch.setattr(sweep, "Image", FakeImage)
    words = []
    monkeypatch.setattr(sweep, "strobe_axis", lambda axis, system, more: words.append(more))
    nothing = sweep.DrawnSpeeds(three.values, np.zeros(3, int), ["aperiodic"] * 3, np.full(3, nan),
                                None, density.Cloud(3))  # fmt: skip
    found = Made(direction="up", ways=[], speeds=[Made(impacts=None, strobe=None)] * 3, key="rpm")
    panels = sweep.cloud_panels(nothing, found, Made(lift=0.01, corners=[]), [(600.0, 650.0)])
    for name in ("strobe", "strobe zoom 1"):
        panels[name].draw(axes := Figure().subplots())
        assert axes.texts[-1].get_text() == "no whole turn recorded at any of these speeds"
    assert words == ["", ""]
    monkeypatch.setattr(sweep, "_views", lambda *_: {
        "strobe enlarged": sweep._View("strobe", (0.0, 1.0), views["strobe"].columns, 60.0)
    })  # fmt: skip
    panels = sweep.cloud_panels(nothing, found, Made(lift=0.01, corners=[]))
    panels["strobe enlarged"].draw(Figure().subplots())
    assert words == ["", "", ", enlarged"]
    some = density.Cloud(3)
    some.take(1, np.array([0.5]))
    panels = sweep.cloud_panels(replace(nothing, strobe=some), found, Made(lift=0.01, corners=[]))
    panels["strobe enlarged"].draw(axes := Figure().subplots())
    assert not axes.texts  # one speed has a point


def test_a_single_position_is_left_out_where_phases_are_shown():
    FakeImage.made = []
    values = np.array([600.0, 650.0])
    one = cloud([0.01, 0.01], [0.01, 0.01])
    for impacts, usual in ((None, True), (cloud([10.0, 20.0], [30.0, 40.0]), False)):
        told = sweep.DrawnSpeeds(values, np.zeros(2, int), ["aperiodic"] * 2, values, impacts, one)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sweep, "Image", FakeImage)
            patch.setattr(sweep, "cam_beside", lambda *how: ())
            found = Made(direction="up", ways=[], key="rpm",
                         speeds=[Made(impacts=None, strobe=None)] * 2)  # fmt: skip
            panels = sweep.cloud_panels(told, found, Made(lift=0.01, corners=[]))
        assert panels["strobe"].usual is usual


@pytest.mark.parametrize(
    ("narrow", "wanted"),
    [((0.5, 20.5), (0.0, 21.3)), ((339.5, 359.5), (338.7, 360.0)), ((100.0, 120.0), (99.2, 120.8))],
)
def test_an_enlarged_range_stays_within_the_turn(narrow, wanted):
    """Its phases have 4 % of room."""
    low = [narrow[0]] * 6 + [0.0]
    high = [narrow[1]] * 6 + [360.0]
    assert sweep.enlarged_range(cloud(low, high)) == pytest.approx(wanted)
    assert sweep.enlarged_range(cloud([], [])) is None


def test_a_letter_stands_where_it_is_whole_and_free_else_at_the_first_place(axes, monkeypatch):
    free = [True]
    monkeypatch.setattr(sweep, "is_free", lambda axes, box: free[0])
    places = [(0.999, 0.5, "left", "top"), (0.5, 0.5, "left", "top"), (0.25, 0.5, "left", "top")]
    sweep._write_beside_points(axes, "(b)", places, axes.transAxes)
    assert axes.texts[-1].get_position() == (0.5, 0.5)
    free[0] = False
    sweep._write_beside_points(axes, "(b)", places, axes.transAxes)
    assert axes.texts[-1].get_position() == (0.999, 0.5)


def test_exponents_have_the_colours_of_their_own_motions(axes):
    kinds = ["aperiodic", "period 1", "contact", "period 2"]
    found = Made(values=np.array([600.0, 610.0, 620.0, 630.0]), kinds=kinds,
                 exponents=np.array([nan, -0.5, nan, 0.25]))  # fmt: skip
    sweep._draw_exponents(found, "speed", axes)
    (points,) = axes.collections
    assert points.get_offsets().tolist() == [[610.0, -0.5], [630.0, 0.25]]
    assert [to_hex(one).upper() for one in points.get_facecolors()] == list(style.PERIODS[:2])


def test_trouble_is_marked_within_the_range_of_each_panel(monkeypatch):
    """Speeds come in any order; exponents stand before the enlarged parts of the range."""
    marked, numbers = [], []
    monkeypatch.setattr(sweep, "trouble_ticks", lambda axes, x: marked.append(list(x)))
    monkeypatch.setattr(sweep, "number_events", lambda axes, x, named: numbers.append(named))
    monkeypatch.setattr(sweep, "kind_of_cam", lambda system: "")
    words, titled = [], []
    monkeypatch.setattr(sweep, "diagram_title", lambda *how: titled.append(how[1]) or "")
    monkeypatch.setattr(sweep, "diagram_words", lambda *how: words.append(how[4]) or "")

    def panel(low, high, **more):
        return Panel(lambda axes: axes.set_xlim(low, high), **more)

    panels = {"strobe": panel(600.0, 700.0), "impacts": panel(600.0, 700.0),
              "impacts zoom 1": panel(610.0, 650.0, across=2)}  # fmt: skip
    monkeypatch.setattr(sweep, "cloud_panels", lambda *_: dict(panels))
    rows = [(690.0, 2, nan), (620.0, 3, 0.5), (600.0, 1, nan), (640.0, 0, nan), (610.0, 4, nan)]
    speeds = [Made(value=value, status=status, exponent=exponent, label="aperiodic",
                   known=value > 620.0, impacts=None, strobe=None)
              for value, status, exponent in rows]  # fmt: skip
    found = Made(speeds=speeds, key="rpm")
    drawn = sweep.draw_sweep(found, None, None).panels
    assert list(drawn) == ["strobe", "impacts", "exponents", "impacts zoom 1"]
    assert words == [3]  # up to 620 rpm none is known
    assert titled == [[690.0, 620.0, 600.0, 640.0, 610.0]]
    for name in drawn:
        drawn[name].draw(Figure().subplots())
    inside = [600.0, 610.0, 620.0, 690.0]
    assert marked == [inside, inside, inside, [610.0, 620.0]]
    assert numbers == [True, False, False, False]


# --- clouds


def test_discs_have_the_share_of_their_speed_and_are_larger_where_they_are_to_be(axes, monkeypatch):
    """Speeds at 700, 710 and 740; that in the middle has no points."""
    made = []

    class Fake:
        def __init__(self, *how):
            made.append(how)

        def set_clip_path(self, path):
            self.clipped = path

    monkeypatch.setattr(density, "Discs", Fake)
    asked = []
    monkeypatch.setattr(
        density, "have_no_room", lambda *how: asked.append(how) or np.array([False] * 3)
    )
    monkeypatch.setattr(axes, "add_image", lambda image: None)
    image = density.Image(density.Columns.of([700.0, 710.0, 740.0]), 0.0, 10.0, 20, 7)
    image.take(0, np.array([1.1, 1.2, 7.25, 12.0, -1.0]))
    image.take(2, np.array([2.6]))
    image._draw_discs(axes, "#123456", lambda shares: shares, (0.5, 0.9))
    ((_, colour, places, opacity, shares, crowd, larger),) = made
    assert (colour, larger) == ("#123456", pytest.approx(7.0 / 3.0))
    assert places == pytest.approx(np.array([[700.0, 1.15], [700.0, 7.25], [740.0, 2.6]]))
    assert opacity == pytest.approx([0.5 + 0.4 * x for x in (0.4, 0.2, 1.0)])
    assert list(crowd) == [2, 2, 1]
    wide = image.columns.high - image.columns.low
    assert shares[:, 0] * wide == pytest.approx([10.0, 40.0, 30.0, 2.0 / 16.0 * wide])
    assert shares[:, 2] * wide == pytest.approx([30.0, 40.0, 30.0, 1.0 / 16.0 * wide])
    assert image._most == 5
    image.take(0, np.linspace(0.0, 10.0, 41))
    assert image._paper()[1][3].tolist() == [1.0, 0.0, 1.0 / 16.0]  # of sixteen bands


def test_full_columns_are_an_image_where_speeds_are_five_cells_apart_or_less(axes, monkeypatch):
    """A panel is 1200 cells wide."""
    monkeypatch.setattr(density, "have_no_room", lambda *how: np.full(len(how[0]), True))
    monkeypatch.setattr(axes, "add_image", lambda image: None)
    for count, full in ((260, True), (230, False)):  # 4.6 cells apart, and 5.2
        image = density.Image(density.Columns.of(np.arange(float(count))), 0.0, 1.0, 10)
        for k in range(count):
            image.take(k, np.array([0.5]))
        found = image._draw_discs(axes, "#123456", lambda x: x, (0.5, 0.9))
        assert (found.all(), found.any()) == (full, full)


@pytest.mark.parametrize(("pixels", "narrow"), [(922.0, True), (924.0, False)])
def test_a_cell_of_a_narrow_panel_is_two_by_two(axes, monkeypatch, pixels, narrow):
    """Where 1.3 pixels come on a cell of 1200 or more; there a point is two cells thinner."""
    asked = []
    monkeypatch.setattr(density, "seen_wide", lambda axes: pixels)
    monkeypatch.setattr(density, "pooled", lambda *how: asked.append("pooled") or how)
    image = density.Image(density.Columns.of([700.0, 710.0]), 0.0, 1.0, 10, 7)
    monkeypatch.setattr(image, "_draw_discs", lambda *how: True)
    shares = np.ma.masked_equal([[0.5]], 0.0), (0.0, 1.0, 0.0, 1.0)
    monkeypatch.setattr(image, "shares", lambda full, thickness: asked.append(thickness) or shares)
    image.draw(axes, "#123456")
    assert asked == ([5, "pooled"] if narrow else [7])


def test_columns_of_an_image_reach_two_and_a_half_about_a_speed_that_is_alone():
    """Speeds are counted up to both ends of a part."""
    columns = density.Columns.of([600.0, 700.0, 800.0], 50, (600.0, 700.0))
    assert columns.bin_of_speed.tolist() == [0, 1, -1]
    place = (np.array([600.0, 700.0]) - columns.low) / (columns.high - columns.low) * 50.0
    middles = np.arange(50) + 0.5
    for k in (0, 1):
        wanted = np.abs(middles - place[k]) <= 2.5
        assert ((columns.bin_of_column == k) == wanted).all()
    rising = np.array([0.0, 1.0, 2.5, 3.0, 4.75, 6.0, 7.0, 8.25, 9.0])
    dense = density.Columns.of(rising, 31)
    place = (rising - dense.low) / (dense.high - dense.low) * 31.0
    away = np.abs(np.arange(31)[:, None] + 0.5 - place)
    wanted = np.where(away.min(axis=1) > 2.5, -1, away.argmin(axis=1))
    assert dense.bin_of_column.tolist() == wanted.tolist()
    part = density.Columns.of(np.arange(200.0), 50, (10.0, 150.0))
    assert set(part.bin_of_speed[:10]) == set(part.bin_of_speed[151:]) == {-1}
    assert (part.bin_of_speed[10], part.bin_of_speed[150]) == (0, 49)
    crowded = density.Columns.of(np.arange(100.0), 50)
    assert (crowded.bins, len(crowded.place_of_bin)) == (50, 50)
    cell = (crowded.high - crowded.low) / 50.0
    assert crowded.place_of_bin[[0, 49]] == pytest.approx(
        [crowded.low + 0.5 * cell, crowded.high - 0.5 * cell]
    )


def test_cells_of_an_image_have_their_middles_and_words_keep_off_those_of_every_image():
    shown = np.ma.masked_equal([[0.0, 0.0, 1.0], [2.0, 0.0, 0.0]], 0.0)
    image = Made(get_array=lambda: shown, get_extent=lambda: (10.0, 16.0, 1.0, 5.0))
    x, y = density._filled_cells(image)
    assert (list(x), list(y)) == ([15.0, 11.0], [2.0, 4.0])
    nothing = Made(get_array=lambda: np.ma.masked_equal([[0.0]], 0.0),
                   get_extent=lambda: (0.0, 1.0, 0.0, 1.0))  # fmt: skip

    def free(*images, at):
        places = np.array([[at[0] - 0.5, at[1] - 0.5], [at[0] + 0.5, at[1] + 0.5]])
        data = Made(inverted=lambda: Made(transform=lambda points: points))
        page = Made(images=images, transData=data)
        return density.is_free(page, Made(get_points=lambda: places))

    assert free(nothing, image, at=(13.0, 3.0))
    for own in ((image, nothing), (nothing, image)):
        assert not free(*own, at=(15.0, 2.4))
        assert not free(*own, at=(11.4, 4.0))
        assert free(*own, at=(15.6, 2.0))


def test_what_is_left_of_an_image_ends_where_its_cells_do():
    image = density.Image(density.Columns.of(np.arange(600.0, 1801.0), 1200), 0.0, 10.0, 20)
    wide = (image.columns.high - image.columns.low) / 1200.0
    some = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0]])
    cells, ends = image._cropped(some, 4, 100)
    assert cells.tolist() == [[1.0], [2.0]]
    assert ends == pytest.approx(
        (image.columns.low + 101.0 * wide, image.columns.low + 102.0 * wide, 2.5, 3.5)
    )


@pytest.mark.parametrize(
    ("colour", "opacity"),
    [("#000000", 0.5), ("#FF0000", 0.5), ("#A9A9A9", 0.5), ("#B4B4B4", 1.0), ("#FFFFFF", 1.0)],
)
def test_a_light_colour_has_no_opacity_to_lose(colour, opacity):
    """The luminance of #A9A9A9 is 0.397, that of #B4B4B4 0.456."""
    assert density.palest(colour) == opacity
    assert style.luminance("#404040") == pytest.approx(0.0512695, rel=1e-5)
    assert style.luminance("#0A0A0A") == pytest.approx(10.0 / 255.0 / 12.92)


def test_pixels_of_an_image_are_whole_ones_within_the_panel():
    """Ten cells from 10.3 to 35.3: a cell has 2.5 pixels, four blank ones are on either side."""
    part = density._Pixels.of((10.3, 35.3), (0.4, 99.6), 10, 1.0)
    assert (part.begin, part.count) == (1, 44)  # from 0.3 up to 45.3
    assert part.first_cell == pytest.approx((1.0 - 0.3) / 2.5)
    assert part.last_cell == pytest.approx((45.0 - 0.3) / 2.5)
    part = density._Pixels.of((10.3, 35.3), (15.4, 20.6), 10, 2.0)
    assert (part.begin, part.count) == (31, 10)
    assert part.first_cell == pytest.approx((31.0 - 0.6) / 5.0)
    even = np.ma.masked_equal([[0.0, 2.0], [1.0, 0.0]], 0.0)
    cells, ends = density.pooled(even, (10.0, 16.0, 1.0, 4.0))
    assert (cells.tolist(), ends) == ([[2.0]], (10.0, 16.0, 1.0, 4.0))


def test_a_disc_at_the_very_end_of_a_panel_is_seen():
    at = np.array([[0.0, 0.0], [4.0, 3.0], [4.1, 1.0], [1.0, -0.1]])
    seen = discs._covered(at, np.full(4, 0.5), np.array([0.25, 0.5, 1.0, 1.0]), (4, 3))
    assert seen.shape == (3, 4)
    assert (seen > 0.0).sum() == 2
    assert seen[0, 0] == pytest.approx(0.25 * (1.0 - 0.5 * 2.0**0.5 + 0.0), abs=0.1)
    assert seen[2, 3] > 0.1


# --- detachment


def test_what_is_enlarged_stays_within_the_speeds_and_counts_on_from_the_opening():
    """From 310 deg over the end of the turn to a corner at 20 deg, 70 deg further."""
    found = study(
        opens=(102.0, 310.0), accumulation=[critical(195.0, 20.0), critical(150.0, 340.0, "c")]
    )
    lead = found.detachment.losses[0]
    reached = detach._first_reached(found, "A1")
    assert [one.region for one in reached] == ["c", "b"]
    assert detach._speeds_reached(found, lead, reached, (97.0, 203.0)) == (97.0, 203.0)
    assert detach._speeds_reached(found, lead, reached, (0.0, 900.0)) == pytest.approx(
        (102.0 - 0.12 * 93.0, 195.0 + 0.12 * 93.0)
    )
    whole = detach._View(0.0, 0.0, 310.0 - 1e-6, (97.0, 203.0))
    assert detach._phases_reached(found, lead, reached, whole) == pytest.approx(
        (310.0 - 0.06 * 70.0, 380.0 + 0.15 * 70.0)
    )


def test_what_happens_beyond_corners_belongs_to_one_that_is_alone_and_to_its_region():
    corner, other = critical(195.0, 120.0), critical(150.0, 130.0, "c")
    for accumulation, region, high in (([corner], "A1", 140.0), ([corner, other], "A1", 130.0),
                                       ([corner], "A2", 120.0)):  # fmt: skip
        found = study(accumulation=accumulation, ends=[(125.0, 140.0)])
        for speed in found.speeds:
            for burst in speed.bursts:
                burst.region = region
        lead = found.detachment.losses[0]
        whole = detach._View(0.0, 0.0, 90.0 - 1e-6, (97.0, 203.0))
        reached = detach._first_reached(found, "A1")
        low, top = detach._phases_reached(found, lead, reached, whole)
        tall = high - 90.0
        assert (low, top) == pytest.approx((90.0 - 0.06 * tall, high + 0.15 * tall))


def test_corners_are_lines_in_both_turns_and_proofs_are_disks_at_their_phases(monkeypatch):
    lines = []
    monkeypatch.setattr(detach, "corner_lines", lambda axes, some, way: lines.append((some, way)))
    view = detach._View(80.0, 480.0, 90.0, (100.0, 200.0))
    axes = axes_of()
    detach._phase_axes(axes, view, {"b": 180.0, "a": 20.0})
    assert lines == [([("b", 180.0), ("b", 540.0), ("a", 380.0), ("a", 740.0)], "y")]
    detach._draw_proved(axes, view, study(opens=(120.0, 30.0)), {}, [120.0])
    (disk,) = axes.lines
    assert disk.get_xydata() == pytest.approx(np.array([[120.0, 390.0]]))
    assert disk.get_markersize() == 5.5 + 3.4  # about the larger of the two marks


def test_numbers_of_hits_stand_below_their_marks_where_there_is_room():
    """Speeds may fall; 16 pt from the bottom are 30.5 deg in a panel of 270 deg and 141.7 pt."""
    corners = {"b": 130.0, "c": 230.0}
    hits = [hit(180.0, 3, "c"), hit(178.0, 7, "c"), hit(150.0, 2, "c"), hit(120.0, 1, "b")]
    axes = axes_of(high=50.0)
    view = detach._View(100.0, 370.0, 100.0, (100.0, 200.0))
    detach._draw_hits(axes, view, study(hits=hits), corners)
    told = [(text.get_text(), text.get_va()) for text in axes.texts]
    assert told == [("3", "top"), ("2", "top"), ("1", "bottom")]


def test_machines_that_always_hold_are_in_no_bar(axes):
    speeds = [700.0 + k for k in range(36)] + [inf] * 400
    spread = Made(speeds=speeds, worst=690.0)
    detach._draw_machines(axes, spread, None)
    assert len(axes.patches) == 6
    assert axes.lines[0].get_xdata()[0] == 717.5


def test_all_that_a_panel_of_phases_shows_has_a_place():
    found = study(
        impacts=[(100.0, 10.0), (100.0, 20.0)], ends=[(110.0, 30.0)], opens=(120.0, 90.0),
        accumulation=[critical(130.0, 40.0)], completion=[critical(140.0, 50.0)],
        hits=[hit(150.0, 1), hit(160.0, 2, "no such"), hit(165.0, 3)],
    )  # fmt: skip
    found.speeds[0].bursts = [Made(region="A1", end=None), Made(region="A1", end=0.0)]
    system = Made(corners=[radians(5.0), radians(180.0)])
    assert sorted(detach._places(found, system)) == [
        pytest.approx(one) for one in (
            (100.0, 0.0), (100.0, 10.0), (100.0, 20.0), (110.0, 30.0), (120.0, 90.0),
            (130.0, 40.0), (140.0, 50.0), (150.0, 180.0),
            (165.0, 180.0),
        )
    ]  # fmt: skip


def test_the_picture_of_detachment_shows_what_is_left_of_its_views(monkeypatch):
    """The part enlarged stands above where it is small; names of forces have the digits of data."""
    curve = Made(rpm=700.1234, lowest_n=12.3, lowest_theta=1.0)
    found = study()
    found.forces, found.springs = [curve], [(None, curve)]
    small, large, whole, left = (detach._View(0.0, 360.0, 0.0, (100.0, x))
                                 for x in (130.0, 195.0, 200.0, 199.0))  # fmt: skip
    for name in ("first_loss", "picture_title"):
        monkeypatch.setattr(detach, name, lambda *_: "")
    monkeypatch.setattr(detach, "units_of", lambda system: METRES)
    monkeypatch.setattr(detach, "_without_empty", lambda view, *_: left)
    system = Made(corners=[1.0], has_seat=False)
    for measured, rpm in ((True, "700.1 rpm"), (False, "700.123 rpm")):
        monkeypatch.setattr(detach, "is_measured", lambda system, told=measured: told)
        for views, names in (([small, whole], ["enlarged", "phases"]), ([large, whole], ["phases"]),
                             ([whole], ["phases"])):  # fmt: skip
            monkeypatch.setattr(detach, "_views", lambda study, told=views: told)
            panels = detach.draw_detach(found, system).panels
            assert list(panels) == [*names, "forces", "springs"]
            assert panels["phases"].draw.keywords["view"] is left
            if "enlarged" in names:
                assert panels["enlarged"].draw.keywords["view"] is small
            assert panels["forces"].draw.keywords["names"][0].startswith(rpm)
            assert panels["springs"].draw.keywords["where"] == "at 700.1234 rpm"


@pytest.mark.parametrize(
    ("names", "wide"),
    [(("springs", "surge"), {"springs": 2, "surge": 2}), (("springs",), {"springs": 1}),
     (("surge",), {"surge": 1}), (("machines", "shares"), {"machines": 2, "shares": 2})],
)  # fmt: skip
def test_springs_and_surge_of_a_report_stand_abreast_where_both_are_there(monkeypatch, names, wide):
    panels = {name: Panel(len, across=3) for name in ("forces", *names)}
    monkeypatch.setattr(detach, "draw_detach", lambda *_: Made(panels=panels))
    monkeypatch.setattr(detach, "units_of", lambda system: METRES)
    monkeypatch.setattr(detach, "machine_panels", lambda *_: {"outline": Panel(len, usual=False)})
    monkeypatch.setattr(detach, "load", lambda loads, name: loads[name])
    found = study()
    found.forces, found.springs = [1, 2], [1, 2, 3]
    past = [Made(rpm=130.0, value=0.5, loads={"max_gap_m": 0.25, "max_impact_m_per_s": None})]
    drawn = detach.report_panels(found, Made(has_seat=False), None, past)
    own = {name: drawn[name].across for name in names}
    assert own == wide
    assert drawn["outline"].usual
    assert drawn["forces"].above == pytest.approx(4.0 + 2 * 3.4)
    if "springs" in names:
        assert drawn["springs"].above == pytest.approx(4.0 + 3 * 3.4)
    if "surge" in names:
        assert drawn["surge"].above == 0.0
    points = {name: drawn[name].draw.keywords["points"] for name in past[0].loads}
    assert points == {"max_gap_m": [(120.0, 0.0), (130.0, 0.25)],
                      "max_impact_m_per_s": [(120.0, 0.0), (130.0, 0.0)]}  # fmt: skip


def test_a_chart_of_surge_is_as_high_as_what_it_shows():
    axes = axes_of()
    harmonics = [
        Made(rpm=rpm, factor=factor, strong=factor > 0.12, number=3)
        for rpm, factor in ((100.0, 0.05), (150.0, 0.4), (900.0, 5.0))
    ]
    found = Made(harmonics=harmonics, hertz=400.0)
    detach._draw_surge(axes, found, study())
    assert axes.get_ylim() == pytest.approx((0.0, 1.2 * 0.4))
    harmonics[1].factor = 0.01
    low = axes_of()
    detach._draw_surge(low, found, study())
    assert low.get_ylim() == pytest.approx((0.0, 1.2 * detach.LIMIT))


def test_a_line_of_ends_goes_on_from_its_latest_speed():
    """At 102 rpm two lines end at 101, and one at 100: the nearest of the two goes on."""
    ends = [(100.0, 50.0), (100.0, 70.0), (101.0, 60.0), (101.0, 72.0), (102.0, 69.0)]
    lines = detach.joined(ends, [100.0, 101.0, 102.0])
    assert lines == [[(100.0, 50.0), (101.0, 60.0)],
                     [(100.0, 70.0), (101.0, 72.0), (102.0, 69.0)]]  # fmt: skip
    lines = detach.joined([(100.0, 71.0), (101.0, 85.0), (100.0, 80.0), (102.0, 74.0)])
    assert lines == [[(100.0, 71.0)], [(100.0, 80.0), (101.0, 85.0), (102.0, 74.0)]]
    lines = detach.joined([(100.0, 69.0), (101.0, 88.0), (101.0, 60.0), (102.0, 70.0)])
    assert lines == [[(100.0, 69.0), (101.0, 60.0), (102.0, 70.0)], [(101.0, 88.0)]]


def test_hits_of_one_corner_in_view_are_numbered_above_the_panel(monkeypatch):
    """Those of another corner beside the view do not count."""
    above = []
    monkeypatch.setattr(detach, "number_events", lambda axes, x, named: above.append((x, named)))
    found = study(hits=[hit(150.0, 1), hit(160.0, 2), hit(190.0, 3, "c"), hit(155.0, 4, "d")])
    corners = {"b": 180.0, "c": 200.0, "d": 300.0}
    view = detach._View(100.0, 250.0, 90.0, (140.0, 180.0))
    axes = axes_of()
    detach._draw_hits(axes, view, found, corners)
    assert above == [([(1, 150.0), (2, 160.0)], True)]
    assert not axes.texts
    detach._draw_hits(axes, detach._View(100.0, 250.0, 90.0, (140.0, 195.0)), found, corners)
    assert len(above) == 1
    assert [text.get_text() for text in axes.texts] == ["1", "2", "3"]


# --- orbits and their lines


def test_phases_of_orbits_are_shown_with_those_of_simulated_motions(axes, monkeypatch):
    seen = []
    for name in ("_draw_simulated", "phase_axis", "_over_parameter", "number_branches"):
        monkeypatch.setattr(orbits, name, lambda *_, **__: None)
    monkeypatch.setattr(orbits, "_draw_branches", lambda *_: [])
    monkeypatch.setattr(
        orbits, "phase_range", lambda values: seen.append(sorted(values)) or (0.0, 360.0)
    )
    motions = [Made(impacts=([0], own)) for own in ([150.0, 120.0], [], [170.0])]
    scene = Made(
        branches=[], events=[], corners={}, colours=[], every=lambda of: np.array([140.0]),
        simulated=Made(speeds=motions),
    )  # fmt: skip
    orbits._draw_phases(axes, scene)
    assert seen == [[120.0, 140.0, 170.0]]


def test_events_of_a_list_have_the_numbers_above_the_panel():
    source = Made(classification="", status=Bracket.OK, label="P(1;1)", kind=Kind.FOLD, corner="",
                  value=700.0)  # fmt: skip
    events = [branch_lines.Event(number, source, (1,), (), (), ()) for number in (3, 8)]
    _, told = orbits.lists_of([], [], events, "rpm")
    assert [row[1] for row in told[1:]] == ["3", "8"]


def test_the_plane_of_several_orbits_reaches_the_largest_multiplier(axes, monkeypatch):
    planes = []
    monkeypatch.setattr(orbits, "draw_plane", lambda axes, largest: planes.append(largest))
    monkeypatch.setattr(orbits, "draw_outside", lambda *_: None)
    three = [Made(multipliers=own, stable=True) for own in ((0.5, 0.1), (0.3 + 2j, -3.0), (1.2, 1))]
    orbits._draw_multipliers(axes, three, ["red", "green", "blue"])
    assert planes == [3.0]
    assert [line.get_xdata().tolist() for line in axes.lines] == [
        [0.5, 0.1],
        [0.3, -3.0],
        [1.2, 1.0],
    ]
    assert axes.lines[1].get_ydata().tolist() == [2.0, 0.0]


@pytest.mark.parametrize(
    ("multipliers", "largest"), [((0.3 + 0.4j, 0.3 - 0.4j), 0.5), ((-3.0, 1.0), 3.0)]
)
def test_the_radius_of_an_orbit_is_that_of_its_largest_multiplier(multipliers, largest):
    assert branch_lines.radius(Made(multipliers=multipliers)) == pytest.approx(largest)


def test_phases_are_those_of_the_root_in_its_order():
    solved = Made(theta=[9.0], root=Made(theta=[radians(30.0), radians(-20.0), radians(400.0)]))
    assert branch_lines.phases(solved) == pytest.approx((30.0, 340.0, 40.0))
    assert branch_lines.phases(Made(theta=[radians(50.0)], root=None)) == pytest.approx((50.0,))


def test_a_path_that_comes_back_is_a_line_and_one_that_stays_a_dot(axes):
    """A path is as stable as its steps: it begins anew where that changes."""
    axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
    strand = branch_lines.Strand
    lines = [strand(True, [1.0, 2.0, 3.0], [0.5 + 0j, 0.52 + 0.5j, 0.5 + 0j]),
             strand(False, [1.0, 2.0, 3.0], [0.1 + 0j, 0.12 + 0j, 0.11 + 0j])]  # fmt: skip
    branch_lines.draw_paths(axes, lines, "#112233")
    path, dot = axes.lines
    assert (path.get_marker(), len(path.get_xdata())) == ("None", 3)
    assert (dot.get_marker(), dot.get_xdata().tolist()) == ("o", [0.1])
    assert dot.get_markerfacecolor() == "white"
    around = [strand(True, [1.0, 2.0, 3.0], [0.5 + 0j, 0.52 + 0j, 0.48 + 0j])]
    branch_lines.draw_paths(axes, around, "#112233")  # within 0.03 of where it begins
    assert axes.lines[-1].get_marker() == "o"
    # an arrow stands half-way along what is seen, up to 1.5 upwards too
    before = len(axes.texts)
    far = [strand(True, [1.0, 2.0, 3.0, 4.0, 5.0], [0j, 0.5j, 1.0j, 1.4j, 900j])]
    branch_lines.draw_paths(axes, far, "#112233")
    assert [(one.xyann, one.xy) for one in axes.texts[before:]] == [((0.0, 0.5), (0.0, 1.0))]
    branch_lines.draw_paths(axes, [strand(True, far[0].x, far[0].y[::-1])], "#112233")
    assert axes.texts[-1].xy == (0.0, 0.5)
    points = [
        Made(value=value, trace=0.1, det=0.5, stable=size < 1.0, multipliers=(size, 0.1))
        for value, size in ((0.0, 0.5), (1.0, 0.6), (2.0, 2.0))
    ]
    found = branch_lines.paths(points)
    assert [(one.stable, one.x[0], one.x[-1]) for one in found] == [
        (True, 0.0, 1.0), (True, 0.0, 1.0), (False, 1.0, 2.0), (False, 1.0, 2.0)
    ]  # fmt: skip


def test_the_side_of_a_triangle_is_that_of_the_larger_part(axes):
    axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
    branch_lines.draw_outside(axes, [1.5 + 0j, 1.5j, 2.0 + 1.8j, -2.0 - 1.9j], "#112233")
    drawn = {line.get_marker(): complex(*line.get_xydata()[0]) for line in axes.lines}
    assert drawn == pytest.approx({">": 1.5 + 1.35j, "<": -1.5 - 1.425j})


def test_two_sides_of_a_corner_are_as_near_as_their_values_are_large():
    def point(value, trace):
        return Made(value=value, trace=trace, det=0.5, stable=True, multipliers=(0.5, 0.1))

    for aside, lines in ((5e-9, 4), (9e-9, 2)):
        points = [point(699.0, 0.1), point(700.0, 0.2), point(700.0 + aside, 0.9), point(701.0, 1)]
        assert len(branch_lines.paths(points)) == lines
        assert len(branch_lines.paths(points[::-1])) == lines


def test_positions_go_on_however_far_apart_and_phases_around_the_turn_do_not():
    def lines(turn, *steps):
        points = [Made(value=float(k), multipliers=(0.5,), stable=True) for k in range(len(steps))]
        found = branch_lines.strands(points, lambda point: steps[int(point.value)], turn)
        return [line.y for line in found]

    assert lines(0.0, [0.0], [50.0]) == [[0.0, 50.0]]
    assert lines(360.0, [0.0], [50.0]) == []
    assert lines(360.0, [2.0, 358.0], [4.0, 3.0]) == [[2.0, 4.0]]  # in their order


def test_a_branch_is_curved_where_it_is_seen_and_its_impacts_are_the_same(monkeypatch):
    made = []
    monkeypatch.setattr(
        branch_lines, "_between", lambda before, a, after, b, s: made.append(s) or s
    )
    root, other = Made(whole=(1,)), Made(whole=(2,))
    points = [Made(value=x, root=own) for x, own in (
        (5.0, root), (4.0, root), (3.0, root), (2.0, other), (1.0, None), (0.0, root))]  # fmt: skip
    assert len(branch_lines.curved(points, 3.2, 3.8)) == 6 + 11
    assert made == pytest.approx([k / 12.0 for k in range(1, 12)])
    assert len(branch_lines.curved(points[::-1], 3.2, 3.8)) == 6 + 11
    assert len(branch_lines.curved(points, 4.0, 4.5)) == 6 + 22  # a step that ends there counts
    assert branch_lines.curved(points, 0.0, 2.5) == points


def test_a_point_between_two_is_on_a_cubic_of_its_phases_and_its_value(monkeypatch):
    """Phases 1 and 2 rad at value 10, 1.5 and 4 at -14; the metric counts all alike."""
    scales = []

    class Metric:
        @staticmethod
        def of(root, scale):
            scales.append(scale)
            return Metric()

        def dot(self, a, b):
            return float(np.dot(a, b))

        def oriented(self, root, way):
            return np.array(root.tangent)

    monkeypatch.setattr(branch_lines, "Metric", Metric)
    monkeypatch.setattr(branch_lines, "replace", lambda before, **more: Made(**more))
    a = Made(x=[1.0, 0.5, 2.0, 0.25, 10.0], tangent=[1.0, 0.0, 0.0, 0.0, 0.0])
    b = Made(x=[1.5, 0.5, 4.0, 0.25, -14.0], tangent=[0.0, 0.0, 1.0, 0.0, 0.0])
    before, after = Made(value=10.0, trace=1.0, det=0.5), Made(value=-14.0, trace=3.0, det=0.25)
    found = branch_lines._between(before, a, after, b, 0.25)
    length = (0.25 + 4.0 + 576.0) ** 0.5
    smooth = 0.25**2 * (3.0 - 0.5)  # of the way
    bent = length * 0.25 * 0.75
    assert scales == [14.0]
    assert found.theta == pytest.approx(
        (1.0 + 0.5 * smooth + bent * 0.75, 2.0 + 2.0 * smooth - bent * 0.25)
    )
    assert found.value == pytest.approx(10.0 - 24.0 * smooth)
    assert (found.trace, found.det, found.root) == (1.5, pytest.approx(0.4375), None)


def test_numbers_of_pairs_are_17_points_apart_in_the_shorter_side_of_a_plane():
    """100 mm wide and 50 high: 141.7 pt are twice 1.5, so that 17 pt are 0.36.

    The numbers stand outside the unit circle, about 1.23 times as far apart as their pairs.
    """
    for away, count in ((0.25, 1), (0.35, 2)):
        axes = axes_of(wide=100.0, high=50.0)
        axes.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5))
        line = branch_lines.Strand(True, [1.0, 2.0], [0.2 + 0.9j, 0.2 - away + 0.9j])
        assert branch_lines.number_pairs(axes, [[line]], [1.0, 2.0])
        assert len(axes.texts) == count


@pytest.mark.parametrize(
    ("largest", "ticks"), [(4.0, None), (4.1, [-1, 0, 1]), (10.0, [-10, -1, 0, 1, 10])]
)
def test_an_axis_of_asinh_has_the_powers_up_to_the_largest_part(axes, largest, ticks):
    lines = [[branch_lines.Strand(True, [1.0, 2.0], [0.5 + 0j, -largest + 0j])]]
    branch_lines.draw_real(axes, lines, ["#000000"])
    assert axes.get_yscale() == ("linear" if ticks is None else "asinh")
    if ticks is not None:
        assert axes.get_yticks().tolist() == ticks


def ranged(low, high, stable=True, failed=None):
    return Made(low=low, high=high, stable=stable, failed_step=failed)


def test_a_range_is_proved_on_the_only_way_that_has_points_at_both_its_ends():
    """A branch that turns round at 8 and at 6; values of a millionth, and ones beyond 0."""

    def steps(values, *ranges, stable=True):
        points = [Made(value=x, multipliers=(0.5,), stable=stable) for x in values]
        return proofs.proved_steps(points, ranges)

    way = [5.0, 6.0, 7.0, 8.0, 7.0, 6.0, 7.0, 9.0]
    assert steps(way, ranged("5.0", "8.0")) == [True] * 3 + [False] * 4
    assert steps(way, ranged("6.0", "8.0")) == [False] * 7  # two ways have both ends
    assert steps(way, ranged("7.0", "9.0")) == [False] * 6 + [True]
    assert steps(way, ranged("5.0", "6.5")) == [False] * 7  # no point is at its end
    assert steps(way, ranged("5.0", "8.0", failed=1), ranged("7.0", "9.0")) == [False] * 6 + [True]
    assert steps(way, ranged("5.0", "8.0", stable=False)) == [False] * 7
    assert steps(way, ranged("5.0", "8.0", stable=False), stable=False)[:3] == [True] * 3
    # the ends are those of the points to a part in 1e11
    far = [1e6, 2e6, 3e6]
    assert steps(far, ranged("[1000000.000001 +/- 1e-9]", "2999999.99999")) == [True, True]
    assert steps([1e-13, 2e-13, 3e-13], ranged("2e-13", "3e-13")) == [False, True]
    sides = [1e6, 1.5e6, 1.5e6 - 1e-6, 2e6]  # a corner: it does not turn round there
    assert proofs._ways([Made(value=x) for x in sides]) == [0, 0, 0]


def test_the_rates_of_an_attraction_are_those_of_its_own_speed(axes):
    one = Made(rpm=600.0, value=0.5, theta=[1.0], root=None, label="P(1;1)")
    proofs.draw_attraction(axes, one, [(0.0, 0.1, 0.25, 0.0)], "#112233", "restitution")
    (patch,) = axes.patches
    assert patch.get_xy()[0] == pytest.approx((0.0, 0.25 * 20.0 * np.pi))


# --- chaos, basins, maps


def test_a_covered_box_has_its_own_colour_and_the_image_that_of_the_other(axes):
    boxes = [Made(inside=lambda points, k=k: (points[0] + k, points[1])) for k in range(3)]
    images = [np.array([[0.1 * k, 0.2], [0.3, 0.4]]) for k in range(3)]
    found = Made(boxes=boxes, coverings=[(0, 2), (1, 0)])
    chaos._draw_coverings(axes, found, Made(images=images))
    shades = chaos._shades(found)
    squares = [patch for patch in axes.patches if len(patch.get_xy()) == 5]
    assert [to_hex(one.get_edgecolor()).upper() for one in squares] == [shades[2], shades[0]]
    assert [to_hex(one.get_facecolor()).upper() for one in squares] == [
        style.mixed(shades[k], 0.75) for k in (2, 0)
    ]
    assert [line.get_color() for line in axes.lines] == [shades[0], shades[1]]
    assert [line.get_xdata().tolist() for line in axes.lines] == [
        pytest.approx([2.0, 2.2]), pytest.approx([7.1, 7.2])
    ]  # fmt: skip
    assert [text.get_text() for text in axes.texts] == ["1 to 3", "2 to 1"]
    assert axes.get_xlim() == (-3.5, 10.5)


def test_a_window_draws_what_lies_in_it_at_the_velocities_of_its_speed(axes, monkeypatch):
    """The cam turns by 2 pi rad/s: a rate of 0.5 m/rad is a velocity of pi m/s."""
    window = Made(q=(0.0, 1.0), v=(-4.0, 4.0), nq=2, nv=2)
    states = np.array([[0.5, 0.5], [1.5, 0.0], [0.25, 1.0], [-0.5, 0.1], [0.75, -1.0]])
    periodic = Made(periodic=True, states=states, label="P(5;5)", shown=lambda: states)
    cloud_of = np.array([[0.5, 0.25], [0.5, 2.0]])
    chaotic = Made(periodic=False, states=cloud_of, label="aperiodic", shown=lambda: cloud_of)
    one = Made(window=window, codes=np.array([[1, 2], [0, -2]]), branches=(4, 2), saddles=None,
               attractors=(periodic, chaotic), rpm=60.0, cam_q=0.25, regions=())  # fmt: skip
    colours = {4: "#111111", 2: "#222222", 0: "#333333"}
    monkeypatch.setattr(basins, "unit_axis", lambda *_: None)
    monkeypatch.setattr(basins, "units_of", lambda system: METRES)
    basins._draw_window(axes, one, colours, "named", None)
    marks, dots, cam = axes.lines
    assert marks.get_xydata() == pytest.approx(np.array([[0.5, np.pi]]))
    assert dots.get_xydata() == pytest.approx(np.array([[0.5, 0.5 * np.pi]]))
    assert cam.get_xdata()[0] == 0.25
    pixels = [[to_hex(pixel / 255.0) for pixel in row] for row in axes.images[0].get_array()]
    assert pixels[0] == ["#111111", "#222222"]
    assert [one.upper() for one in pixels[1]] == ["#333333", style.TROUBLE]
    assert (axes.get_xlim(), axes.get_ylim()) == ((0.0, 1.0), (-4.0, 4.0))
    inside = basins._in_window(
        one, np.array([0.0, 1.0, 0.5, 0.5, 1.1]), np.array([-4.0, 4.0, 4.1, -4.1, 0])
    )
    assert inside.tolist() == [True, True, False, False, False]
    for c, seen in ((0.0, True), (1.0, True), (-0.01, False), (1.01, False)):
        edge = Figure().subplots()
        basins._draw_window(edge, Made(**{**vars(one), "cam_q": c}), colours, "named", None)
        labels = [line.get_label() for line in edge.lines if line.get_xdata()[0] == c]
        assert labels == ["cam, $q = c$"] * seen, c
    rings = [(np.array([q, q + 0.1]), np.array([0.0, 1.0])) for q in (2.0, 0.4, 0.6, 0.8)]
    monkeypatch.setattr(basins, "_ellipses", lambda *_: rings)
    proved = Figure().subplots()
    basins._draw_window(proved, one, colours, "named", None)
    assert len(proved.lines) == 3 + 3  # the first one is outside
    assert proved.get_legend_handles_labels()[1].count(basins.IN_ELLIPSE) == 1


def test_undecided_cells_have_no_boundary(axes, monkeypatch):
    some = []
    monkeypatch.setattr(axes, "contour", lambda q, v, cells, *_, **__: some.append(cells.tolist()))
    grid = Made(nq=3, nv=1, q_of=lambda k: k, v_of=lambda k: k)
    one = Made(window=grid, codes=np.array([[1, 0, 2]]), attractors=[1, 2], saddles=[], rpm=60.0)
    basins._draw_boundary(axes, one)
    assert some == [[[True, None, False]]]


def test_the_palest_basin_is_the_largest_by_the_sum_of_its_shares(monkeypatch):
    chosen = []
    monkeypatch.setattr(
        basins, "area_colours", lambda labels, largest: chosen.append(largest) or ["red"] * 2
    )
    for name in ("window_words", "picture_title", "kind_of_cam"):
        monkeypatch.setattr(basins, name, lambda *_: "")
    monkeypatch.setattr(basins, "_attractor_rows", lambda *_: [])
    two = [Made(label="P(1;1)"), Made(label="P(2;2)")]

    def window(first, second, value):
        return Made(fractions={1: (first, 0.0), 2: (second, 0.0)}, branches=(1, 2), value=value,
                    attractors=two, saddles=None)  # fmt: skip

    grids = [window(0.6, 0.4, 600.0), window(0.05, 0.5, 610.0)]
    basins._windows(Made(grids=grids), None, None, "rpm")
    assert chosen == [1]  # 0.9 of two windows, and never 0.6 of one


def test_numbers_of_curves_keep_away_from_points_of_codimension_two(axes, monkeypatch):
    asked, written = [], []
    spots = ["first", None, "third"]
    monkeypatch.setattr(sweep_map, "spots_of", lambda axes, *how: asked.append(how) or spots)
    monkeypatch.setattr(sweep_map, "write_number", lambda axes, *how: written.append(how))
    curves = [Made(first=[float(k)], second=[10.0 * k]) for k in range(3)]
    sweep_map._number_curves(axes, curves, [Made(first=1.5, second=2.5)])
    ((lines, marks),) = asked
    assert marks == [(1.5, 2.5)]
    assert lines == [([0.0], [0.0]), ([1.0], [10.0]), ([2.0], [20.0])]
    assert written == [(1, "first", "black", "white"), (3, "third", style.CURVE_GREEN, "black")]


def test_curves_over_a_map_have_numbers_where_there_are_several_and_thin_ones_stand_above(
    monkeypatch,
):
    numbered = []
    monkeypatch.setattr(
        sweep_map, "_number_curves", lambda axes, curves, points: numbered.append(len(curves))
    )
    monkeypatch.setattr(sweep_map, "_draw_kinds", lambda *_: None)
    monkeypatch.setattr(sweep_map, "_value", lambda speed, name: nan)
    monkeypatch.setattr(sweep_map, "map_heading", lambda *_: ("", ""))
    found = Made(lines=[[1], [2]], first=[1.0, 2.0], second=[3.0, 4.0], keys=("rpm", "mass"))
    own = Made(
        first=[1.0, 2.0], second=[3.0, 4.0], proved=[False], kind="fold", label="", corner=""
    )
    for count, numbers in ((1, []), (6, [6])):
        numbered.clear()
        axes = Figure().subplots()
        drawn = sweep_map.draw_map(found, METRES, [own] * count)
        drawn.panels["kind"].draw(axes)
        assert numbered == numbers
        widths = [line.get_linewidth() for line in axes.lines]
        assert [line.get_zorder() for line in axes.lines] == pytest.approx(
            [5.0 - 0.4 * wide for wide in widths]
        )
    assert len(set(widths)) == 2
    assert [panel.usual for panel in drawn.panels.values()][:2] == [True, False]


# --- motions, cases of the bench


def test_a_picture_of_motions_counts_speeds_and_not_motions(monkeypatch):
    asked = []
    monkeypatch.setattr(classify, "picture_title", lambda *how: asked.append(how[0]) or "")
    monkeypatch.setattr(classify, "kinds_words", lambda motions: "")
    monkeypatch.setattr(classify, "range_text", lambda *_: "here")

    def motions(*values):
        return [Made(value=x, exponents=None, rpm=x) for x in values]

    classify.draw_classify(motions(700.0, 710.0, 700.0))
    classify.draw_classify(motions(700.0, 700.0))
    assert asked == [2, 0]


def test_impacts_of_motions_are_clouds_of_their_kinds_at_their_speeds(axes, monkeypatch):
    """Two motions share the second speed; the last two are in trouble."""
    FakeImage.made = []
    marked, limits = [], []
    monkeypatch.setattr(classify, "Image", lambda *how: FakeImage(*how, 3))
    monkeypatch.setattr(classify, "impacts_of", lambda record: (np.radians(record), None))
    monkeypatch.setattr(classify, "trouble_ticks", lambda axes, x: marked.append(x))
    monkeypatch.setattr(classify, "phase_axis", lambda axes, *ends: limits.append(ends))
    labels = [Label((1.0,)), "aperiodic", "aperiodic", "aperiodic"]
    records = [[110.0], [120.0, 490.0], [115.0], []]
    status = [Status.OK, Status.OK, Status.LOG_FULL, Status.NO_RETURN]
    motions = [Made(label=label, record=own, status=told)
               for label, own, told in zip(labels, records, status, strict=True)]  # fmt: skip
    scene = Made(motions=motions, x=[700.0, 710.0, 710.0, 720.0], columns=None, system=None)
    classify._draw_phases(axes, scene)
    period_1, aperiodic = FakeImage.made
    assert [(k, pytest.approx(own)) for k, own in period_1.taken] == [(0, [110.0])]
    assert [(k, pytest.approx(own)) for k, own in aperiodic.taken] == [
        (1, [120.0, 130.0]), (1, [115.0]), (2, [])
    ]  # fmt: skip
    assert period_1.drawn + aperiodic.drawn == [(style.PERIODS[0], 1.0), (style.APERIODIC, 1.0)]
    assert marked == [[710.0, 720.0]]
    assert limits == [pytest.approx((109.2, 130.8))]
    assert [line.get_label() for line in axes.lines] == ["period 1", "aperiodic"]
    assert not axes.texts
    still = Made(motions=motions[3:], x=[720.0], columns=None, system=None)
    monkeypatch.setattr(classify, "phase_range", lambda every: (0.0, 360.0))
    classify._draw_phases(axes, still)
    assert [text.get_text() for text in axes.texts] == ["no impact at any of these speeds"]


def test_exponents_have_bars_of_one_standard_error_and_rests_a_mark_below_them():
    """What has no finite exponent is passed over, wherever it stands."""

    def drawn(*exponents):
        axes = Figure().subplots()
        axes.set_xlim(690.0, 740.0)
        motions = [Made(label="aperiodic", exponents=own and Made(largest=own[0], spread=own[1]))
                   for own in exponents]  # fmt: skip
        x = [700.0 + 10.0 * k for k in range(len(exponents))]
        classify._draw_exponents(axes, Made(motions=motions, x=x))
        bars = [bar.get_segments()[0] for bar in axes.collections]
        return axes, [(float(bar[0][0]), *bar[:, 1].tolist()) for bar in bars]

    axes, bars = drawn(None, (-inf, 0.0), (0.5, 0.25), (-1.0, nan), (inf, 0.0))
    assert bars == [(720.0, 0.25, 0.75), (730.0, -1.0, -1.0)]
    room = 0.04 * 1.75
    low, high = -1.0 - room, 0.75 + room
    assert axes.get_ylim() == pytest.approx((low - 0.12 * (high - low), high))
    (rests,) = (line for line in axes.lines if line.get_marker() == "v")
    assert rests.get_xydata().tolist() == [[710.0, 0.03]]
    assert axes.get_ylabel().endswith(",\n± standard error")
    axes, bars = drawn((0.5, 0.0), (-1.0, inf))
    assert axes.get_ylim() == pytest.approx((-1.06, 0.56))
    assert "standard error" not in axes.get_ylabel()
    axes, _ = drawn((-1.0, 0.5), (0.5, 0.0))
    assert axes.get_ylim() == pytest.approx((-1.58, 0.58))
    assert "standard error" in axes.get_ylabel()


def test_motions_of_one_speed_are_counted_below_their_panels_unless_there_is_one():
    for values, ticks, said in (([700.0], [], "motion at here"),
                                ([700.0] * 3, [1.0, 2.0, 3.0], "motions, numbered, at here"),
                                ([700.0, 710.0], None, None)):  # fmt: skip
        axes = Figure().subplots()
        scene = Made(motions=[Made(value=x) for x in values], x=[1.0, 2.0, 3.0][: len(values)],
                     columns=Made(low=0.5, high=3.5), events=[], key="rpm",
                     speeds="here")  # fmt: skip
        classify._draw(axes, scene, lambda *_: None)
        if ticks is not None:
            assert (axes.get_xticks().tolist(), axes.get_xlabel()) == (ticks, said)
        else:
            assert axes.get_xlabel() == own_axes.axis_name("rpm")


def test_a_label_that_has_no_room_is_its_period_and_what_has_none_is_nothing():
    figure = Figure(figsize=(4.0, 1.0), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, 400.0), ylim=(0.0, 1.0))  # a pixel each
    with style.look():
        for label, period, wide in (("P(2;1:1)", 2, 300.0), ("P(2;1:1)", 2, 25.0),
                                    ("aperiodic", 0, 25.0), ("P(2;1:1)", 2, 2.0)):  # fmt: skip
            classify._name(axes, Made(label=label, period=period), (0.0, 0.0), wide, 1.0)
        classify._name(axes, Made(label="P(1;1)", period=1), (0.0, 0.0), 300.0, 0.02)
    assert [text.get_text() for text in axes.texts] == ["P(2;1:1)", "2"]
    assert [text.get_position() for text in axes.texts] == [(150.0, 0.5), (12.5, 0.5)]


def test_marks_of_the_bench_are_named_where_cases_differ_and_times_stand_on_their_shade():
    def drawn(*statuses):
        rows = [Made(case=f"case {k}", seconds=0.1 * (k + 1), status=status)
                for k, status in enumerate(statuses)]  # fmt: skip
        axes = Figure(figsize=(6.0, 3.0), dpi=300).subplots()
        bench._draw_rows(axes, rows)
        return axes

    axes = drawn("ok", "failed", "ok", "ok")
    named = [line.get_label() for line in axes.lines if line.get_linestyle() == "None"]
    assert named == ["as expected", "not as expected"]
    edges = [text.get_path_effects()[0]._gc["foreground"] for text in axes.texts]
    assert edges == ["white", style.CAM_BODY] * 2
    shaded = [patch.get_y() for patch in axes.patches]
    assert shaded == pytest.approx([0.5, 2.5])
    assert [text.get_text() for text in axes.texts] == ["100 ms", "200 ms", "300 ms", "400 ms"]
    alike = [line for line in drawn("ok", "ok").lines if line.get_linestyle() == "None"]
    assert [line.get_label().startswith("_") for line in alike] == [True]


# --- the cam


def test_a_measured_cam_shows_the_rows_of_its_file_where_the_cam_is(axes, monkeypatch):
    """Rows that were put into a dwell have the line 0; lifts are counted from the base."""
    monkeypatch.setattr(cam_profile, "_name", lambda *_: None)
    measured = Made(line=np.array([0, 12, 13]), theta=np.array([5.0, 10.0, 20.0]),
                    lift=np.array([0.5, 0.001, 0.002]))  # fmt: skip
    one = Made(profile=Made(theta=[0.0, 1.0], c=[0.01, 0.02]), measured=True,
               cam=Made(measured=measured, base=0.25))  # fmt: skip
    cam_profile._draw_lift(axes, one)
    assert axes.lines[1].get_xydata() == pytest.approx(np.array([[10.0, 0.251], [20.0, 0.252]]))


def test_cams_side_by_side_share_their_ranges_and_many_corners_have_no_names(monkeypatch):
    turns = []
    monkeypatch.setattr(
        cam_profile, "turn_axis", lambda axes, corners, named: turns.append(len(corners))
    )

    def cam(*values, corners=3):
        names = {f"c{k}": 0.1 * k for k in range(corners)}
        return Made(profile=Made(c=list(values), c1=[0.0], corners=names))

    two = [cam(0.0, 1.0), cam(-0.5, 2.0)]
    draw = cam_profile._draw_lift
    monkeypatch.setitem(cam_profile.VALUES, draw, lambda profile: profile.c)
    for one, limits in ((two[0], (-0.6, 2.1)), (two[1], (-0.6, 2.1))):
        axes = Figure().subplots()
        cam_profile._draw(axes, lambda *_: None, one, two)  # of which no values are known
        assert axes.get_ylim() == (0.0, 1.0)
        monkeypatch.setitem(cam_profile.VALUES, NOTHING, lambda profile: profile.c)
        cam_profile._draw(axes, NOTHING, one, two)
        assert axes.get_ylim() == pytest.approx(limits)
    for count, named in ((26, 26), (27, 0)):
        turns.clear()
        cam_profile._draw(Figure().subplots(), NOTHING, cam(0.0, corners=count), ())
        assert turns == [named]


def NOTHING(axes, cam):  # noqa: N802
    """What draws nothing."""


@pytest.mark.parametrize(
    ("lobe", "knife", "among", "unusual"),
    [
        (None, [1.0], False, {"turned", "outline", "geometry", "geometry in words", "mechanism"}),
        (None, None, False, {"turned", "outline", "geometry", "geometry in words", "mechanism",
                             "curvature of the pitch curve"}),
        (Made(), [1.0], False, {"turned", "mechanism", "curvature",
                                "curvature of the pitch curve"}),
        (None, [1.0], True, {"turned", "outline", "geometry", "geometry in words", "mechanism",
                             "jerk"}),
    ],
)  # fmt: skip
def test_which_panels_of_a_cam_are_usual_and_where_its_follower_flies(
    monkeypatch, lobe, knife, among, unusual
):
    """The follower flies half-way from the largest to the least slope, over the end of a turn."""
    asked = []
    real = mechanism.machine_panels
    monkeypatch.setattr(cam_profile, "machine_panels", lambda *how: asked.append(how) or real(*how))
    monkeypatch.setattr(cam_profile, "cam_name", lambda cam: "the cam")
    theta = np.radians([0.0, 40.0, 300.0, 350.0])
    profile = Made(theta=theta, c1=[0.0, -2.0, 3.0, 1.0], lobe=lobe, curvature=Made(knife=knife))
    outline = Made(radius=np.array([0.02, 0.03, 0.025]), flat=False, lobe=lobe, at_rest_deg=0.0)
    one = Made(profile=profile, outline=outline, cam=None)
    panels = cam_profile._panels(one, [Made(), one] if among else ())
    assert {name for name, panel in panels.items() if not panel.usual} == unusual
    ((_, moments, name),) = asked
    assert name == ("the cam" if among else "")
    assert moments == {
        "at rest": (0.0, 0.0), "in flight": (pytest.approx(350.0), pytest.approx(0.004)),
        "landing": (pytest.approx(40.0), 0.0),
    }  # fmt: skip
    columns = {name: panel.column for name, panel in panels.items() if panel.column}
    compared = dict.fromkeys(cam_profile.COMPARED, "cam 1")
    assert columns == (compared if among else {})


# --- marks, colours, lists and pages


def test_phases_within_a_third_of_the_turn_are_all_shown(axes):
    """Also where those of one speed are wider than of others; a whole turn has a tick at 60 deg."""
    low, high = np.array([100.0, 102.0, 101.0]), np.array([110.0, 111.0, 190.0])
    assert own_axes.gathered(low, high).tolist() == [100.0, 190.0]
    high[2] = 300.0
    assert own_axes.gathered(low, high).tolist() == [100.0, 111.0]
    low[1], high[1] = 0.0, 360.0  # one of three is too few
    assert own_axes.gathered(low, high).tolist() == [0.0, 360.0]
    assert own_axes.gathered(np.empty(0), np.empty(0)).tolist() == []
    own_axes.phase_axis(axes, 0.0, 360.0, "departure")
    assert set(np.diff(axes.get_yticks())) == {60.0}
    assert axes.get_ylabel() == r"departure phase $\theta$ (deg)"
    own_axes.phase_axis(other := Figure().subplots(), 10.0, 100.0)
    assert set(np.diff(other.get_yticks())) != {60.0}


@pytest.mark.parametrize(
    ("units", "unit", "name", "texts"),
    [
        (MILLIMETRES, "m", "q (mm)", ["1.0", "2.5"]), (METRES, "m", "q (m)", None),
        (MILLIMETRES, "m/rad2", "q (mm/rad²)", ["1.0", "2.5"]),
        (MILLIMETRES, "N/m", "q (N/mm)", ["0.0000010", "0.0000025"]),
    ],
)  # fmt: skip
def test_numbers_of_an_axis_are_in_the_units_of_the_machine(axes, units, unit, name, texts):
    own_axes.unit_axis(axes.yaxis, "q", units, unit)
    assert axes.get_ylabel() == name
    if texts is not None:
        form = axes.yaxis.get_major_formatter()
        form.set_locs([0.001, 0.0025])
        assert [form(x) for x in (0.001, 0.0025)] == texts


def test_heights_of_a_cam_are_those_of_the_piece_in_which_a_phase_lies(monkeypatch):
    """The second stretch, from 1 to 3 rad, has two pieces: 5 + 2 d and 7 - 3 d + d^2."""
    columns = {"start": [0.0, 1.0], "end": [1.0, 3.0], "first_piece": [0.0, 1.0],
               "piece_count": [1.0, 2.0]}  # fmt: skip
    monkeypatch.setattr(own_axes, "column", lambda cam, name: columns[name])
    pieces = np.zeros((3, own_axes.PIECE))
    pieces[:, 0] = 0.0, 1.0, 2.0
    pieces[1, 1:3] = 5.0, 2.0
    pieces[2, 1:4] = 7.0, -3.0, 1.0
    pieces[1:, 1 + own_axes.TERMS] = 11.0, 12.0  # of the slope
    pieces[1:, 1 + 2 * own_axes.TERMS] = 21.0, 22.0
    x = np.array([1.5, 2.0, 2.5, 3.0])
    found = own_axes._values(Made(pieces=pieces.ravel()), np.array([1, 1, 1, 1]), x)
    assert found == pytest.approx(
        np.array([[6.0, 7.0, 5.75, 5.0], [11.0, 12.0, 12.0, 12.0], [21.0, 22.0, 22.0, 22.0]])
    )


def test_names_of_a_cam_s_axes_and_of_corners_at_the_ends_of_a_turn(axes):
    names = []
    for panel in ("lift", "velocity", "acceleration"):
        own_axes.lift_axis(axes.yaxis, panel, METRES)
        names.append(axes.get_ylabel().partition("$")[0])
    assert names == ["lift ", "velocity\n", "acceleration\n"]
    axes.set_xlim(0.0, 360.0)
    own_axes.corner_lines(axes, [("b", 360.0), ("c", 360.1), ("a", 0.0)], "x")
    assert [line.get_xdata()[0] for line in axes.lines] == [0.0, 360.0]
    assert [text.get_text() for text in axes.texts] == ["a", "b"]
    picture._calm_ticks(axes)
    assert type(axes.xaxis.get_major_locator()) is picture._Apart
    assert type(axes.yaxis.get_major_locator()) is not picture._Apart


def test_marks_with_a_white_edge_have_a_thin_one():
    for kind, (marker, face, edge, size) in own_axes.MARKS.items():
        assert own_axes.mark_look(kind) == {
            "marker": marker, "ms": size, "mfc": face, "mec": edge, "ls": "None",
            "mew": 0.5 if edge == "white" else 0.8,
        }  # fmt: skip
    assert own_axes.mark_look("no such")["marker"] == "X"


def test_curves_of_a_cam_have_two_hundred_points_a_radian(monkeypatch):
    """From the first to the last phase of each stretch, with a gap behind it."""
    ends = {"start": [0.0, 1.5], "end": [1.5, 1.75]}
    monkeypatch.setattr(own_axes, "column", lambda cam, name: ends[name])
    monkeypatch.setattr(
        own_axes, "_values", lambda cam, stretch, x: np.array([x, 2.0 * x, 3.0 + stretch])
    )
    theta, (c, slope) = own_axes.lift_curves(None, 2)
    assert len(theta) == 302 + 1 + 52 + 1
    assert np.flatnonzero(np.isnan(theta)).tolist() == [302, 355]
    assert theta[[0, 301, 303, 354]] == pytest.approx(np.degrees([0.0, 1.5, 1.5, 1.75]))
    good = ~np.isnan(theta)
    assert c[good] == pytest.approx(np.radians(theta[good]))
    assert slope[good] == pytest.approx(2.0 * np.radians(theta[good]))


def test_periods_up_to_four_have_a_colour_each():
    assert [style.period_colour(k) for k in range(1, 7)] == [*style.PERIODS, *[style.LONGER] * 2]
    rests = [Label((inf, 1.0)), Label((1.0, inf)), Label((2.0, 1.0))]
    assert [style.kind_of_label(label) for label in rests] == [
        style.RESTS, style.RESTS, "period 2"
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "refused"),
    [
        ("cycler('color', ['r']) * 9", True), ("9*['r']", True), ("9 * ('r',)", True),
        ("2**9", True), ("['r'] * 3", True), ("('r',) * 3", True), ("'r' *3", True),
        ("3* 'r'", True), ("12345", True), ("9 * 9 * cycler('color', 'r')", True),
        ("9 * cycler('color', 'r')", False), ("cycler('lw', [1234]) * cycler('color', 'r')", False),
    ],
)  # fmt: skip
def test_arithmetic_in_a_cycle_of_properties_is_refused(value, refused):
    """A number times one cycle is no more than 9999 times as long."""
    told = False
    try:
        style._refuse_formula("axes.prop_cycle", value)
    except ValueError:
        told = True
    assert told is refused
    style._refuse_formula("axes.titlepad", value)


def test_a_caption_begins_with_a_capital_and_keeps_all_other_letters():
    own = Picture("title", {}, caption="orbits of P(1;1) in mm, Newton's law")
    assert own._caption([]) == "Orbits of P(1;1) in mm, Newton's law."


def test_last_words_of_a_row_stand_below_it_unless_there_are_none():
    row = ["1", "event", "words"]
    assert picture._folded(row, 3) == [["1", "event"], ["", "", "words"]]
    assert picture._folded(["1", "event", ""], 3) == [["1", "event", ""]]
    assert picture._folded(row, 4) == [row]


def test_marks_without_words_are_not_set_in_pairs():
    head, mark = ["", "marks"], {"ls": "None"}
    rows = [head, [mark, "a"], [mark, "longest"], [mark, "long"]]
    assert picture._in_pairs(rows) == [
        head, [mark, "longest", mark, "a"], [mark, "long", "", ""]
    ]  # fmt: skip
    for other in ([mark, mark], [mark, "a", "b"], [mark]):
        assert picture._in_pairs([*rows, other]) == [*rows, other]


def test_parts_of_one_list_are_one_in_a_column_however_many_they_are():
    head = ["", "event"]
    parts = [[head, *([str(k), "x" * k] for k in own)] for own in ((1, 2), (3,), (4, 5))]
    (joined,) = picture._Heading._listed(Made(wide=90.0, top=2.0), parts, 120.0)
    assert joined == [head, *([str(k), "x" * k] for k in range(1, 6))]
    apart = picture._Heading._listed(Made(wide=90.1, top=2.0), parts, 120.0)
    assert apart == parts


def test_ticks_are_made_anew_where_their_panel_has_moved_or_its_range():
    made = []
    bbox = Made(bounds=(0.0, 0.0, 9.0, 5.0), size=(9.0, 5.0))
    axis = Made(axes=Made(bbox=bbox), get_view_interval=lambda: limits,
                _update_ticks=lambda: made.append(1) or [len(made)],
                _get_ticklabel_bboxes=lambda ticks, renderer: ([list(ticks)], []))  # fmt: skip
    limits = (0.0, 1.0)
    kept = picture._Ticks(axis)
    assert (kept.ticks(), kept.ticks()) == ([1], [1])
    boxes = kept.boxes(kept.ticks(), None)
    assert kept.boxes(kept.ticks(), None) is boxes
    bbox.bounds = (1.0, 0.0, 9.0, 5.0)
    assert kept.ticks() == [2]
    assert kept.boxes(kept.ticks(), None) == ([[2]], [])
    limits = (0.0, 2.0)
    assert kept.ticks() == [3]
    assert kept.boxes([7], None) == ([[7]], [])  # others than its own


def test_curves_stand_beside_panels_from_110_mm_on(monkeypatch):
    """Names of panels are in a line where a row has one panel, or where a row shares its axis."""
    aligned = []
    monkeypatch.setattr(picture.Page, "align_ylabels", lambda page, some: aligned.append(len(some)))

    def named(axes):
        axes.set_ylabel("name")

    beside = Panel(named, 30.0, beside=(named, named))
    row = [("b", Panel(named, 30.0)), ("c", Panel(named, 30.0))]
    shared = [("d", Panel(named, 30.0, y="v")), ("e", Panel(named, 30.0, y="v"))]
    mixed = [("f", Panel(named, 30.0, y="v")), ("g", Panel(named, 30.0, y="w"))]
    for width, curves in ((110.0, 2), (109.9, 0)):
        page = picture.Page(layout=picture._Layout())
        picture._draw_rows(page, [[("a", beside)]], Made(width=width))
        assert len(page.axes) == 1 + curves
    for more, count, names in ((row, 1, 2), (shared, 2, 1), (mixed, 2, 2)):
        page = picture.Page(layout=picture._Layout())
        picture._draw_rows(page, [[("a", Panel(named, 30.0))], more], Made(width=200.0))
        assert aligned[-1] == count
        assert [axes.get_ylabel() for axes in page.axes[1:]].count("name") == names


def test_a_legend_of_one_column_is_folded_to_eight_tenths_of_the_page():
    with style.look():
        page = picture.Page(figsize=(60.0 / 25.4, 2.0), layout=picture._Layout())
        picture.FigureCanvasAgg(page)
        axes = page.add_axes((0.0, 0.0, 1.0, 1.0))
        heading = picture._Heading(axes, Picture("T", {}), Made(width=60.0, title=False), 200.0)
        words = "words of a legend " * 6
        above = heading.top
        height = heading.finish({words.strip(): axes.plot([], [])[0]})
        folded = axes.get_legend().get_window_extent().height / style.DPI * 25.4
    (text,) = axes.get_legend().get_texts()
    assert folded > 4.0 * style.NOTE / 72.0 * 25.4  # several lines, each higher than its letters
    assert height == heading.top == axes.get_ylim()[0]
    assert height == pytest.approx(above + 1.0 + folded, abs=0.1)
    assert max(map(len, text.get_text().split("\n"))) <= int(0.8 * 0.64 * 60.0)
    assert " ".join(text.get_text().split()) == words.strip()


# --- critical speeds


def test_events_are_numbered_by_speed_and_minor_ones_lose_their_numbers_first():
    events = [Made(rpm=700.0 - k, kind="fold" if k % 2 else "itinerary") for k in range(50)]
    found = critical_speeds.numbered(events)
    assert [event.rpm for _, event in found] == sorted(event.rpm for event in events)
    numbers = [number for number, _ in found if number is not None]
    assert numbers == list(range(1, 45))
    without = [event for number, event in found if number is None]
    assert [event.rpm for event in without] == [690.0, 692.0, 694.0, 696.0, 698.0, 700.0]
    assert {event.kind for event in without} == {"itinerary"}
    assert Status.OK.text == "ok"
