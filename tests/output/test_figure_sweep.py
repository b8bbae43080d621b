"""The picture of a sweep: what it is made of, and sweeps that are larger than memory."""

import tracemalloc
from collections.abc import Sequence
from dataclasses import replace
from io import BytesIO
from math import inf, nan
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from PIL import Image

from camcli.analysis.explain.changes import CriticalEvent
from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.codim2 import PointKind
from camcli.analysis.orbits.curves import CurveLine
from camcli.analysis.sweep import Sweep
from camcli.analysis.sweep_map import Map
from camcli.errors import Status
from camcli.plots import density, style
from camcli.plots.axes import number_events
from camcli.plots.sweep import colour_of, draw_sweep
from camcli.plots.sweep_map import draw_map
from camcli.quantities import Units
from camcli.scene.schema import Plot
from tests.conftest import settings
from tests.support.picture_sizes import label_of, pixels, speed, sweep_of, tall, words


@pytest.fixture
def drawn(chapter):
    return lambda *speeds, **more: draw_sweep(sweep_of(*speeds), chapter, settings(), **more)


@pytest.mark.parametrize("direction", ["fixed", "up", "down"])
def test_a_sweep_one_way_does_not_say_which_points_were_carried_which_way(chapter, direction):
    speeds = [speed(700.0 + k, [150.0], [2.0]) for k in range(3)]
    found = replace(sweep_of(*speeds), direction=direction)
    legend = draw_sweep(found, chapter, settings()).figure().axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["aperiodic"]


def some(k):
    phases = np.array([140.0, 150.0 + k % 30, 190.0]) if k % 5 else np.array([1.0, 200.0, 359.0])
    status = Status.OK if k % 9 else Status.IMPACT_BUDGET
    return speed(700.0 + (7 * k) % 50, phases, [1.0, 2.0 + k % 3], status)


@pytest.mark.slow
@pytest.mark.parametrize("many", [0, 1, 4001])
def test_any_number_of_speeds(drawn, many):
    rpms = np.linspace(660.0, 760.0, many)
    picture = drawn(
        *(speed(rpm, [150.0 + k % 7], [1.0 + k % 3, nan, inf]) for k, rpm in enumerate(rpms))
    )
    tall(picture)
    assert sum(len(axes.images) for axes in picture.figure().axes) == 2 * (many > 0)


@pytest.mark.parametrize(
    ("phases", "limits"), [([0.1, 4.0], (0.0, 4.156)), ([356.0, 359.9], (355.844, 360.0))]
)
def test_phases_near_the_end_of_the_turn_are_shown_within_it(drawn, phases, limits):
    figure = drawn(speed(700.0, phases, None)).figure()
    assert figure.axes[1].get_ylim() == pytest.approx(limits)


def test_no_impacts_at_all_is_said_in_the_panel(drawn):
    said = "no impact at any of these speeds"
    assert said in words(drawn(speed(100.0, [], [0.1])))
    assert said not in words(drawn(speed(101.0, [7.0], [0.1])))


@pytest.mark.slow
def test_events_are_listed_and_make_the_picture_taller(drawn):
    speeds = speed(700.0, [150.0], [2.0]), speed(760.0, [151.0], [2.1])
    picture = drawn(*speeds, events=[CriticalEvent(739.3, 1e-10, "fold", "P(1;1)")])
    assert tall(picture) > drawn(*speeds).figure().get_figheight() * 25.4 + 5
    assert {"fold", "739.300000", "1"} <= set(words(picture))


# --- what the picture is made of


def shares_of(values, columns, low=0.0, high=1.0, height=8):
    image = density.Image(columns, low, high, height)
    for k, column in enumerate(values):
        image.take(k, np.array(column))
    cells, _ = image.shares()
    return cells


def test_speeds_that_share_a_column_are_counted_together():
    columns = density.Columns.of([4.0, 5.0, 1.0, 2.0, 3.0, 6.0], 4)  # two speeds meet twice
    values = [[150.0, 151.0, 149.0], [], [], [1.0, 359.0, 20.0, 30.0], [150.0], [7.0]]
    shares = shares_of(values, columns, 0.0, 360.0, 12)
    assert shares[:, 0].compressed().tolist() == [0.5, 0.5, 0.25, 0.25, 0.25]  # three cells thick
    assert shares[:, 2].compressed().tolist() == pytest.approx([1 / 3, 2 / 3, 2 / 3, 2 / 3])


def darkness(wide, high, speeds, points):
    """Of the pixels of a panel of so many mm: (rows, columns), 0 to 1; points: a function of k.

    speeds: how many from 0 to 1 in even steps, or which.
    """
    values = np.linspace(0.0, 1.0, speeds) if isinstance(speeds, int) else speeds
    figure = Figure(figsize=(wide / 25.4, high / 25.4), dpi=style.DPI)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    image = density.Image(density.Columns.of(values), 0.0, 1.0, 600)
    for k in range(len(values)):
        image.take(k, np.asarray(points(k)))
    image.draw(axes)
    figure.savefig(file := BytesIO(), dpi=style.DPI)
    return 1.0 - np.asarray(Image.open(file).convert("L"), dtype=float) / 255.0


def runs(dark):
    """Mean length of what is dark without a gap, along the last axis, in pixels."""
    edges = np.count_nonzero(np.diff(np.pad(dark, ((0, 0), (1, 1))).astype(int), axis=1) == 1)
    return np.count_nonzero(dark) / edges


@pytest.mark.parametrize("speeds", [11, 51, 101, 151, 201, 301, 601, 1201, 2000])
def test_close_speeds_make_a_line_and_few_are_dots(speeds):
    columns = darkness(65.0, 40.0, speeds, lambda k: [0.4 + 0.2 * k / speeds]).max(axis=0)
    seen = columns[20:-20] > 0.6
    assert seen.all() == (speeds > 101)
    if speeds <= 101:
        assert 0.05 < seen.mean() < 0.8


def test_a_line_over_two_grids_of_speeds_is_nearly_as_thick_everywhere():
    """As of a zoom, whose speeds lie between those of the whole range: 0.14 to 0.43 mm apart."""
    grids = np.concatenate([np.linspace(0.0, 1.0, 91), np.linspace(0.0, 1.0, 151)])
    dark = darkness(64.0, 40.0, np.unique(grids.round(6)), lambda _: [0.5])[:, 20:-20]
    thick = np.count_nonzero(dark > 0.5, axis=0)
    assert thick.min() > 0.5 * thick.max()


@pytest.mark.parametrize("speeds", [101, 121, 141])
def test_points_that_make_no_line_leave_as_much_white_as_a_third_of_their_way(speeds):
    columns = darkness(70.0, 40.0, speeds, lambda _: [0.5]).max(axis=0)[20:-20]
    assert (columns < 0.1).mean() > 0.2
    assert (columns < 0.5).mean() > 1.0 / 3.0


@pytest.mark.parametrize("speeds", [51, 301, 1201])
@pytest.mark.parametrize(("wide", "high"), [(65.0, 60.0), (65.0, 30.0), (140.0, 40.0)])
def test_a_point_is_as_wide_as_high(speeds, wide, high):
    """Within a pixel, of 0.3 to 0.6 mm, in a panel of any size and among any number of speeds."""
    dark = darkness(wide, high, speeds, lambda k: [0.5] if k == speeds // 2 else []) > 0.5
    sizes = [np.count_nonzero(dark.any(axis=k)) for k in (0, 1)]
    assert 0.3 < min(sizes) / style.DPI * 25.4 <= max(sizes) / style.DPI * 25.4 < 0.6
    assert max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(("wide", "high"), [(65.0, 75.0), (65.0, 30.0), (115.0, 60.0)])
@pytest.mark.parametrize("points", [15, 60, 120])
def test_scattered_points_are_no_dashes(wide, high, points):
    random = np.random.default_rng(1)
    dark = darkness(wide, high, 801, lambda _: random.uniform(size=points)) > 0.25
    if dark.mean() < 0.5:
        assert 0.5 < runs(dark) / runs(dark.T) < 1.5


def test_a_line_has_no_steps():
    """In each column of pixels its middle is where it belongs, to a quarter of a pixel."""
    dark = darkness(65.0, 40.0, 801, lambda k: [0.45 + 0.05 * k / 800])[:, 20:-20]
    rows, columns = dark.shape
    middle = dark.T @ (np.arange(rows) + 0.5) / dark.sum(axis=0)
    speed = (np.arange(columns) + 20.5) / (columns + 40)
    seen = density.Columns.of(np.linspace(0.0, 1.0, 801))
    wanted = rows * (1.0 - 0.45 - 0.05 * (seen.low + (seen.high - seen.low) * speed))
    assert np.abs(middle - wanted).max() < 0.25


def test_a_cloud_looks_the_same_whether_speeds_share_columns_or_not():
    random = np.random.default_rng(1)
    shades = [
        darkness(65.0, 40.0, speeds, lambda _: random.beta(2.0, 2.0, size=400)).mean()
        for speeds in (1101, 2201)
    ]
    assert shades[1] == pytest.approx(shades[0], rel=0.15)


def weights(box, cells, begin, pixels):
    """How much of each cell along an axis each pixel shows, by a Hamming window.

    box: where the cells begin and end, in pixels; begin: of the first pixel.
    """
    start, end = box
    cell = (end - start) / cells
    centres = start + (np.arange(cells) + 0.5) * cell
    away = (centres - (begin + np.arange(pixels)[:, None] + 0.5)) / max(cell, 1.0)
    window = np.sinc(away) * (0.54 + 0.46 * np.cos(np.pi * away)) * (np.abs(away) < 1.0)
    return window / window.sum(axis=1)[:, None]


@pytest.mark.parametrize("larger", [1.0, 2.0, 3.7])
def test_shades_between_cells_are_interpolated_and_the_colour_stays(larger):
    """Within what is rounded, once along each axis; `larger`: more pixels, as in an SVG."""
    axes = Figure(figsize=(6.0, 2.0), dpi=100).add_axes((0.1, 0.1, 0.8, 0.8))
    image = density.Image(density.Columns.of(np.linspace(0.0, 1.0, 301)), 0.0, 1.0, 300)
    for k in range(301):
        image.take(k, np.linspace(0.0, 1.0, 200 + k % 17) ** 2)
    image.draw(axes, "#0072B2", 0.8)
    (ours,) = axes.images  # all are too full for discs
    pixels, left, low, _ = ours.make_image(None, larger)
    cells = ours.get_array()
    rows, columns = cells.shape
    levels = np.pad(ours.to_rgba(cells, bytes=True)[..., 3].astype(float), 9)  # blank on all sides
    box = ours.get_window_extent()
    wide, high = box.width / columns * larger, box.height / rows * larger
    across = box.intervalx * larger + np.array([-9.0, 9.0]) * wide
    upwards = box.intervaly * larger + np.array([-9.0, 9.0]) * high
    right = weights(across, columns + 18, left * larger, pixels.shape[1])
    up = weights(upwards, rows + 18, low * larger, len(pixels))
    opacity = pixels[..., 3]
    assert np.abs(opacity - up @ levels @ right.T).max() <= 1.5
    assert len(np.unique(opacity)) > 50
    assert {tuple(pixel) for pixel in pixels[opacity > 0][:, :3]} == {(0x00, 0x72, 0xB2)}
    assert pixels.shape[1] == pytest.approx(480 * larger, abs=1)  # all of the panel is there


def test_an_image_of_points_is_there_on_an_axis_that_is_turned_round():
    axes = Figure(figsize=(3.0, 2.0), dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
    image = density.Image(density.Columns.of(np.linspace(0.0, 1.0, 301)), 0.0, 1.0, 300)
    for k in range(100):  # in the left third
        image.take(k, np.linspace(0.0, 1.0, 300))
    image.draw(axes)
    axes.invert_xaxis()
    (ours,) = axes.images
    pixels, left, _, _ = ours.make_image(None)
    assert pixels[..., 3].any()
    assert left > 190.0


def test_a_column_with_many_points_stays_as_wide_as_its_speed():
    """So that a window between two ranges of chaos does not close."""
    columns = density.Columns.of(np.linspace(0.0, 1.0, 1201), 1200)
    image = density.Image(columns, 0.0, 1.0, 600)
    image.take(600, np.linspace(0.0, 1.0, 300))
    cells, _ = image.shares()
    assert np.count_nonzero((~np.ma.getmaskarray(cells)).any(axis=0)) == 1


@pytest.mark.parametrize("width", [85.0, 170.0])
def test_a_line_of_many_speeds_has_no_gap_even_with_few_pixels(drawn, width):
    """At 60 dots per inch, every column of pixels between its ends has some of the line."""
    rpms = np.linspace(660.0, 760.0, 301)
    figure = drawn(*(speed(x, None, [1.0 + 0.003 * (x - 660.0)]) for x in rpms)).figure(
        Plot(width=width)
    )
    figure.savefig(file := BytesIO(), dpi=60)
    shown = np.asarray(Image.open(file).convert("L"), dtype=float)
    box = figure.axes[1].get_position()
    high, wide = shown.shape
    rows = slice(int((1.0 - box.y1) * high) + 4, int((1.0 - box.y0) * high) - 4)
    columns = slice(int(box.x0 * wide) + 5, int(box.x1 * wide) - 5)
    assert shown[rows, columns].min(axis=0).max() < 225.0  # of 255: white


def test_a_zoom_shows_the_few_phases_of_many_speeds_where_others_fill_the_turn(drawn):
    turn = np.linspace(0.5, 359.5, 200)
    speeds = [speed(670.0 + k, turn, None) for k in range(10)]
    speeds += [speed(680.0 + k, [150.0 + 0.2 * k], None) for k in range(10)]

    def limits(span):
        axes = drawn(*speeds, zooms=[span]).figure().axes
        (found,) = [one.get_ylim() for one in axes[1:] if one.get_xlim()[0] >= span[0] - 0.5]
        return found

    assert limits((674.0, 684.0)) == pytest.approx((149.968, 150.832))  # 5 of 11
    assert limits((672.0, 682.0)) == (0.0, 360.0)  # 3 of 11


def test_phases_and_positions_asked_for_are_those_drawn(drawn):
    speeds = [speed(670.0 + k, [150.0 + k, 300.0], [1.0, 2.0 + k]) for k in range(5)]
    picture = drawn(*speeds, limits={"impacts": (149.0, 172.0), "strobe": None})
    first, second, *_ = (axes.get_ylim() for axes in picture.figure(Plot(width=85.0)).axes[1:])
    assert first == (149.0, 172.0)
    assert second == pytest.approx((0.8, 6.2))
    assert list(picture.panels) == ["impacts", "strobe"]
    picture = drawn(*speeds, limits={"strobe": (1.5, 4.0)})
    assert picture.figure(Plot(panels=["strobe"])).axes[1].get_ylim() == (1.5, 4.0)


def test_one_position_of_all_speeds_is_told_and_not_drawn(drawn):
    one, other = speed(670.0, [150.0], [1.0]), speed(671.0, [151.0], [1.0])
    assert list(drawn(one, other).chosen(None)) == ["impacts"]
    assert "always the same, and is not drawn" in drawn(one, other).caption
    for speeds in ([one], [one, speed(671.0, [151.0], [1.001])]):
        assert list(drawn(*speeds).chosen(None)) == ["impacts", "strobe"]
        assert "always the same" not in drawn(*speeds).caption
    assert drawn(one, other).chosen(["strobe"])


def test_exponents_have_room_in_a_column_before_what_was_not_asked_for(drawn):
    """Phases far apart at a fifth of the speeds: whole turn, enlarged, positions, exponents."""
    speeds = [some(k)._replace(exponent=-0.2, value=700.0 + k) for k in range(50)]
    page = drawn(*speeds).figure(Plot(width=85.0))
    assert "exponents" not in page.left_out
    assert "strobe" in page.left_out


def test_a_range_shown_enlarged_has_the_letter_of_its_panel_if_that_has_room(drawn):
    speeds = [speed(670.0 + k, [150.0 + 0.2 * k], [1.0 + 0.1 * k]) for k in range(20)]
    picture = drawn(*speeds, zooms=[(675.0, 680.0)])

    def bands(width):
        first = picture.figure(Plot(width=width)).axes[1]
        own = [patch for patch in first.patches if to_hex(patch.get_facecolor()) == "#f3eedf"]
        return len(own), [text.get_text() for text in first.texts if "(" in text.get_text()]

    assert bands(170.0) == (1, ["(c)"])
    assert bands(85.0) == (0, [])


@pytest.mark.parametrize(("phase", "at"), [
    (lambda rpm: 200.0, ("left", "top")),
    (lambda rpm: 347.0 if rpm > 680.0 else 200.0, ("right", "top")),
    (lambda rpm: 347.0, ("left", "bottom")),
])  # fmt: skip
def test_the_letter_of_a_zoom_stands_beside_its_band_where_no_points_are(drawn, phase, at):
    speeds = [speed(670.0 + 0.1 * k, [1.0, 180.0, phase(670.0 + 0.1 * k)]) for k in range(201)]
    speeds[100] = speed(680.0, [180.0])
    axes = drawn(*speeds, zooms=[(679.9, 680.1)]).figure(Plot(panels=["impacts"]))
    (letter,) = [text for text in axes.axes[1].texts if text.get_text() == "(b)"]
    assert (letter.get_ha(), letter.get_va()) == at


# --- sweeps that are larger than memory


class Lazy(Sequence):
    """Speeds made whenever they are asked for, as from a disk; counts how often."""

    def __init__(self, make, many):
        self.make, self.many, self.made = make, many, 0

    def __len__(self):
        return self.many

    def __getitem__(self, k):
        if not 0 <= k < self.many:
            raise IndexError(k)
        self.made += 1
        return self.make(k)


def of(speeds, system):
    return draw_sweep(Sweep(speeds, "fixed", Cost()), system, settings())


@pytest.mark.slow
def test_a_lazy_sweep_is_read_twice_and_order_does_not_matter(chapter):
    lazy = Lazy(some, 50)
    speeds = [some(k) for k in range(50)]
    first = pixels(of(lazy, chapter))
    assert lazy.made == 100
    assert (pixels(of(sorted(speeds, key=lambda one: one.rpm), chapter)) == first).all()


def test_the_points_are_never_all_in_memory(chapter):
    points = np.linspace(100.0, 300.0, 10_000)
    lazy = Lazy(lambda k: speed(700.0 + k / 10.0, points, points), 2000)
    of(Lazy(some, 5), chapter)
    tracemalloc.start()
    of(lazy, chapter)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 100e6  # a column of all points is 160 MB


def test_a_motion_has_the_colour_of_its_kind(drawn):
    """Two periods, chaos and an undecided motion: an image each, named in the legend."""
    named = {"P(1;1)": "period 1", "P(2;1:1)": "period 2", "aperiodic": "aperiodic"}
    speeds = [speed(700.0 + k, [150.0])._replace(label=label_of(x)) for k, x in enumerate(named)]
    speeds.append(speed(705.0, [151.0])._replace(label="undecided", known=False))
    kinds = [*named.values(), "undecided after rests"]
    picture = drawn(*speeds)
    found = [t for axes in picture.figure().axes for t in axes.get_legend_handles_labels()[1]]
    assert set(kinds) <= set(found)
    assert colour_of("period 1") == style.label_colour(label_of("P(1;1)"))
    assert "1 undecided after rests, grey" in picture.caption


def test_a_narrow_picture_has_no_cam_beside_its_panels_but_the_same_axes(drawn):
    picture = drawn(speed(700.0, [150.0, 10.0], [2.0]))
    wide, narrow = picture.figure(), picture.figure(Plot(width=85.0))
    assert len(wide.axes) == len(narrow.axes) + 3
    for figure in (wide, narrow):
        labels = [axes.get_ylabel() for axes in figure.axes]
        assert sum("impact phase" in label for label in labels) == 1


def test_a_curve_without_points_has_no_number_and_moves_none():
    """Its number had a place at 0, 0, from which those of other curves kept away."""
    lines = [[speed(float(k), (90.0,)) for k in range(-1, 2)] for _ in range(3)]
    found = Map(("rpm", "restitution"), (-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0), lines, "fixed", Cost())
    shares = [k / 50 - 1.0 for k in range(101)]
    across = CurveLine("fold", "P(1;1)", "", shares, [0.0] * 101)
    empty = CurveLine("fold", "P(1;1)", "", [], [])

    def numbers(*curves):
        axes = Figure().add_subplot()
        draw_map(found, Units("m", 1.0, "N/m"), curves).panels["kind"].draw(axes)
        return {text.get_text(): text.xy for text in axes.texts}

    first = numbers(across, empty)["1"]
    assert numbers(empty, across) == {"2": first}


def test_events_at_one_place_may_have_a_number_or_none():
    """A place with and without a number, in any order, raised a TypeError."""
    axes = Figure().add_subplot(xlim=(0.0, 2.0))
    number_events(axes, [(3, 1.0), (None, 1.0), (1, 0.5), (2, 9.0)], named=True)
    assert [text.get_text() for text in axes.texts] == ["1", "3"]
    assert [line.get_xdata()[0] for line in axes.lines] == [0.5, 1.0, 1.0]


def test_a_sweep_of_the_cam_says_at_which_value_its_cam_is_drawn(drawn):
    texts = [
        text.get_text()
        for axes in drawn(speed(700.0, [150.0, 10.0]), shown_cam="cam at lift 2").figure().axes
        for text in axes.texts
    ]
    assert texts.count("cam at lift 2") == 1


def test_eight_curves_of_one_kind_look_different():
    lines = [[speed(float(k), (90.0,)) for k in range(3)] for _ in range(3)]
    found = Map(("rpm", "restitution"), (0.0, 1.0, 2.0), (0.0, 1.0, 2.0), lines, "fixed", Cost())
    curves = [CurveLine("fold", "P(1;1)", "", [0.0, 2.0], [k / 4, k / 4]) for k in range(8)]
    axes = Figure().add_subplot()
    draw_map(found, Units("m", 1.0, "N/m"), curves).panels["kind"].draw(axes)
    drawn = [line for line in axes.lines if len(line.get_xdata())]
    assert len({(line.get_color(), line.get_linewidth()) for line in drawn}) == len(curves) == 8


@pytest.mark.parametrize(("count", "more"), [(11, []), (50, ["and 39 more, in the tables"])])
def test_a_map_of_many_curves_is_no_taller_than_a_column_allows(count, more):
    """It lists eleven curves and six kinds of points; of more the list is cut."""
    lines = [[speed(float(k), (90.0,)) for k in range(3)] for _ in range(3)]
    found = Map(("rpm", "restitution"), (0.0, 1.0, 2.0), (0.0, 1.0, 2.0), lines, "fixed", Cost())
    curves = [CurveLine("fold", "P(9;1:1)", "", [0.0, 2.0], [k / 6, k / 6]) for k in range(count)]
    points = [SimpleNamespace(kind=kind, first=1.0, second=1.0) for kind in list(PointKind)[:6]]
    picture = draw_map(found, Units("m", 1.0, "N/m"), curves, points)
    page = picture.figure(Plot(width=85.0))
    page.draw_without_rendering()
    assert page.get_figheight() * 25.4 <= 170.0 + 1e-9
    panel = page.axes[1].get_window_extent().height / page.dpi * 25.4
    assert panel >= 55.0
    words = [text.get_text() for text in page.axes[0].texts]
    assert [word for word in words if word.startswith("and ")] == more
    whole = picture.figure(Plot(width=170.0)).axes[0].texts
    cut = [text.get_text() for text in whole if text.get_text().startswith("and ")]
    assert cut == (["and 8 more, in the tables"] if more else [])


@pytest.mark.parametrize("panels", [("impacts", "enlarged"), ("enlarged",)])
def test_scales_of_the_cam_stand_above_its_first_curves(drawn, panels):
    """Beside the enlarged panel too, where it is alone; never twice."""
    speeds = [speed(660.0 + k, [150.0 + 0.1 * k, 155.0], [1.0, 2.0]) for k in range(20)]
    speeds.append(speed(690.0, [10.0, 350.0], [1.0, 2.0]))
    figure = drawn(*speeds).figure(Plot(width=170.0, panels=panels))
    heads = [axes.get_title(loc="center") for axes in figure.axes[1:]]
    assert [head for head in heads if head] == ["$c$", r"$c_\theta$", r"$c_{\theta\theta}$"]
    named = [axes.get_xlabel() for axes in figure.axes[1:] if axes.get_title(loc="center")]
    assert named == ["m", "m/rad", "m/rad²"]
