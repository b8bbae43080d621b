"""What all pictures share: colours of one meaning, figures that leave matplotlib as it was."""

import os
import re
from itertools import combinations, pairwise
from math import inf
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from camcli.analysis.contact_loss.force import ForceCurve
from camcli.analysis.labels import Label
from camcli.api.explore_page import COLOURS, colour_name
from camcli.cli.options import _millimetres
from camcli.errors import SceneError
from camcli.plots import style, sweep_map
from camcli.plots.axes import draw_forces, length_axis
from camcli.plots.basins import area_colours
from camcli.plots.branch_lines import colours
from camcli.plots.density import palest
from camcli.plots.picture import Panel, Picture
from camcli.plots.sweep import draw_sweep
from camcli.scene.schema import Plot
from camcli.words.in_print import label_text, newtons
from tests.conftest import settings
from tests.support.picture_sizes import panel, png, speed, sweep_of

FOLDER = Path(style.__file__).parent
ROLES = (
    "FLIGHT", "STICKING", "IMPACT", "CHATTER", "DETACHMENT", "TROUBLE", "MEASURED", "LONGER",
    "CONTACT", "UNDECIDED", "SIMULATED", "CAM", "CAM_BODY", "GUIDE", "BAND", "DOUBT", "PULL",
)  # fmt: skip
MOTIONS = (
    *style.PERIODS,
    style.LONGER,
    style.STICKING,
    style.CONTACT,
    style.APERIODIC,
    style.UNDECIDED,
)
EVENTS = ("FLIGHT", "STICKING", "SLOWING", "IMPACT", "CHATTER", "DETACHMENT", "TROUBLE")
# Machado, Oliveira and Fernandes (2009), severity 1, linear RGB
EVERY_SIGHT = {
    "all cones": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "no L cones": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                   [-0.003882, -0.048116, 1.051998]],
    "no M cones": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                   [-0.011820, 0.042940, 0.968881]],
    "no S cones": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
                   [0.004733, 0.691367, 0.303900]],
}  # fmt: skip
# Brettel, Vienot and Mollon (1997): linear RGB on either side of a plane, and its normal; the
# numbers are those of the library daltonlens, for sRGB
HALVES = {
    "no L cones, halves": (
        [[0.14980, 1.19548, -0.34528], [0.10764, 0.84864, 0.04372], [0.00384, -0.00540, 1.00156]],
        [[0.14570, 1.16172, -0.30742], [0.10816, 0.85291, 0.03892], [0.00386, -0.00524, 1.00139]],
        [0.00048, 0.00393, -0.00441],
    ),
    "no M cones, halves": (
        [[0.36477, 0.86381, -0.22858], [0.26294, 0.64245, 0.09462], [-0.02006, 0.02728, 0.99278]],
        [[0.37298, 0.88166, -0.25464], [0.25954, 0.63506, 0.10540], [-0.01980, 0.02784, 0.99196]],
        [-0.00281, -0.00611, 0.00892],
    ),
    "no S cones, halves": (
        [[1.01277, 0.13548, -0.14826], [-0.01243, 0.86812, 0.14431], [0.07589, 0.80500, 0.11911]],
        [[0.93678, 0.18979, -0.12657], [0.06154, 0.81526, 0.12320], [-0.37562, 1.12767, 0.24796]],
        [0.03901, -0.02788, -0.01113],
    ),
}  # fmt: skip


def as_seen(linear, sight):
    """Linear RGB as somebody sees it."""
    if sight in EVERY_SIGHT:
        return np.array(EVERY_SIGHT[sight]) @ linear
    one, other, normal = HALVES[sight]
    return np.array(one if np.dot(linear, normal) >= 0.0 else other) @ linear


def seen(colour, sight):
    """CIE Lab coordinates of a colour as somebody sees it."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    linear = np.clip(as_seen(linear, sight), 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    share = np.array(to_xyz) @ linear / [0.9505, 1.0, 1.089]
    f = np.where(share > (6 / 29) ** 3, np.cbrt(share), share * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_colours_are_named_in_one_place_only_and_pyplot_stays_out():
    colour = r"#[0-9A-Fa-f]{6}|\"(?:red|blue|green|orange|purple|gr[ae]y)\"|pyplot"
    for path in FOLDER.glob("*.py"):
        if path.name != "style.py":
            assert re.findall(colour, path.read_text(encoding="utf-8")) == []


def test_no_two_meanings_share_a_colour():
    own = [getattr(style, role) for role in ROLES]
    own += style.PERIODS
    assert len({colour.upper() for colour in own}) == len(own)


def least_distance(colours, sight):
    """The two of the colours that look most alike, and how far apart they are in CIE Lab."""
    places = {colour: seen(colour, sight) for colour in colours}
    away = {pair: np.linalg.norm(places[pair[0]] - places[pair[1]])
            for pair in combinations(places, 2)}  # fmt: skip
    return min((distance, pair) for pair, distance in away.items())


@pytest.mark.parametrize("sight", [*EVERY_SIGHT, *HALVES])
def test_motions_are_told_apart_by_everybody(sight):
    """In a diagram together with the solved orbits over them, and in a map."""
    distance, pair = least_distance([*MOTIONS, style.TROUBLE], sight)
    assert distance > 20.0, pair
    distance, pair = least_distance([style.AREAS[colour] for colour in MOTIONS], sight)
    assert distance > 20.0, pair


def ciede2000(one, other):
    """The distance of two colours in CIE Lab by CIE 142-2001, as Sharma, Wu and Dalal write it."""
    (light, a, b), (light_, a_, b_) = one, other
    mean_chroma = 0.5 * (np.hypot(a, b) + np.hypot(a_, b_))
    stretch = 1.5 - 0.5 * np.sqrt(mean_chroma**7 / (mean_chroma**7 + 25.0**7))
    chroma, chroma_ = np.hypot(stretch * a, b), np.hypot(stretch * a_, b_)
    hue = np.degrees(np.arctan2(b, stretch * a)) % 360.0
    hue_ = np.degrees(np.arctan2(b_, stretch * a_)) % 360.0
    turned = (hue_ - hue + 180.0) % 360.0 - 180.0 if chroma * chroma_ > 0.0 else 0.0
    middle = (hue + 0.5 * turned) % 360.0 if chroma * chroma_ > 0.0 else hue + hue_
    by_light = light_ - light
    by_chroma = chroma_ - chroma
    by_hue = 2.0 * np.sqrt(chroma * chroma_) * np.sin(np.radians(turned / 2.0))
    away = (0.5 * (light + light_) - 50.0) ** 2
    mean = 0.5 * (chroma + chroma_)
    weight = 1.0
    for share, times, lag in ((-0.17, 1, 30), (0.24, 2, 0), (0.32, 3, -6), (-0.20, 4, 63)):
        weight += share * np.cos(np.radians(times * middle - lag))
    by_light /= 1.0 + 0.015 * away / np.sqrt(20.0 + away)
    by_chroma /= 1.0 + 0.045 * mean
    by_hue /= 1.0 + 0.015 * mean * weight
    blue = np.radians(60.0 * np.exp(-(((middle - 275.0) / 25.0) ** 2)))
    turn = -2.0 * np.sqrt(mean**7 / (mean**7 + 25.0**7)) * np.sin(blue)
    return np.sqrt(by_light**2 + by_chroma**2 + by_hue**2 + turn * by_chroma * by_hue)


@pytest.mark.parametrize(
    ("one", "other", "wanted"),
    [  # of the table of Sharma, Wu and Dalal (2005)
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, -1.0, 2.0), (50.0, 0.0, 0.0), 2.3669),
        ((50.0, 2.49, -0.001), (50.0, -2.49, 0.0011), 7.2195),
        ((22.7233, 20.0904, -46.694), (23.0331, 14.973, -42.5619), 2.0373),
        ((90.8027, -2.0831, 1.441), (91.1528, -1.6435, 0.0447), 1.4441),
        ((2.0776, 0.0795, -1.135), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_ciede2000_is_that_of_the_literature(one, other, wanted):
    assert ciede2000(one, other) == pytest.approx(wanted, abs=1e-4)


RED_AND_GREEN = (
    "all cones",
    "no L cones",
    "no M cones",
    "no L cones, halves",
    "no M cones, halves",
)


@pytest.mark.parametrize("sight", RED_AND_GREEN)
def test_motions_are_15_apart_as_ciede2000_measures_it(sight):
    """But for two pairs told by their shape: points of rests, areas, lines with an edge."""
    by_shape = ({style.STICKING, style.CONTACT}, {style.STICKING, style.TROUBLE})
    for one, other in combinations([*MOTIONS, style.TROUBLE], 2):
        if {one, other} not in by_shape:
            assert ciede2000(seen(one, sight), seen(other, sight)) > 15.0, (one, other)


def test_lines_over_a_map_are_told_apart_in_print_without_colours():
    """The four colours of curves differ in lightness, with two widths they are eight."""
    lightness = {colour: seen(colour, "all cones")[0] for colour, _, _ in sweep_map.LINES}
    assert len(lightness) == 4
    for one, other in combinations(lightness.values(), 2):
        assert abs(one - other) > 15.0
    assert len({(colour, width) for colour, width, _ in sweep_map.LINES}) == len(sweep_map.LINES)


def test_distances_are_those_of_the_literature():
    """Between pure red and pure green, and from black to white."""
    red_green = np.linalg.norm(seen("#FF0000", "all cones") - seen("#00FF00", "all cones"))
    assert red_green == pytest.approx(170.6, abs=0.1)
    for sight in (*EVERY_SIGHT, *HALVES):
        assert np.linalg.norm(seen("#FFFFFF", sight) - seen("#000000", sight)) == pytest.approx(
            100.0, abs=0.1
        )


@pytest.mark.parametrize("sight", EVERY_SIGHT)
def test_contact_and_its_events_are_told_apart_by_everybody(sight):
    places = {role: seen(getattr(style, role), sight) for role in EVENTS}
    for one, other in combinations(EVENTS, 2):
        assert np.linalg.norm(places[one] - places[other]) > 20.0, (one, other)


def luminance(colour):
    """Relative luminance of a colour, from 0 to 1."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast_on_white(colour):
    """From 1 to 21."""
    return 1.05 / (luminance(colour) + 0.05)


def test_motions_show_on_white():
    assert contrast_on_white("black") == pytest.approx(21.0)
    for colour in MOTIONS:
        area = colour == style.CONTACT  # never a line or a point
        assert contrast_on_white(colour) > (1.5 if area else 2.0), colour
        pale = style.mixed(colour, 1.0 - palest(colour))  # as it looks where points are few
        assert area or contrast_on_white(pale) > 1.4, pale
    for colour in area_colours(["aperiodic", "undecided", "P(1;1)", "P(2;1:1)", "P(3;1:1:1)"]):
        assert contrast_on_white(colour) > 1.5, colour


def test_black_lines_and_numbers_show_on_every_area_of_a_map():
    for colour in MOTIONS:
        assert 21.0 / contrast_on_white(style.AREAS[colour]) > 4.0, colour


def test_a_motion_has_the_colour_of_its_kind_in_every_picture():
    def orbit(turns, impacts=1.0):
        return [SimpleNamespace(label=Label((impacts,) * turns))]

    wanted = [*(style.PERIODS[k] for k in (1, 0, 2)), style.LONGER, style.STICKING]
    orbits = [orbit(2), orbit(1), orbit(3), orbit(9), orbit(1, inf)]
    assert colours(orbits) == wanted
    assert [style.label_colour(own.label) for (own,) in orbits] == wanted
    names = ["period2", "period1", "period3", "longer", "rests"]
    assert [colour_name(own.label) for (own,) in orbits] == names
    shown = {name: colour for name, colour in COLOURS.items() if name in names}
    assert [shown[name] for name in names] == wanted
    assert style.label_colour("aperiodic") == style.APERIODIC
    several = colours([orbit(1)] * 5)
    assert several[0] == style.PERIODS[0]
    assert len(set(several)) == 5


@pytest.mark.parametrize(("force", "shaded"), [([1.0, -2.0, 1.0], True), ([1.0, 0.0, 1.0], False)])
def test_negative_force_is_shaded(force, shaded):
    axes = panel()
    draw_forces(axes, [ForceCurve(100.0, [0.0, 180.0, 360.0], force, min(force), 180.0)])
    found = [patch for patch in axes.patches if patch.get_facecolor()[:3] == to_rgb(style.PULL)]
    assert len(found) == shaded
    assert all(patch.get_y() < -1.0 for patch in found)
    assert all(patch.get_y() + patch.get_height() == 0.0 for patch in found)
    assert newtons(-66.4691, 6) == "−66.4691 N"
    assert newtons(-1e-12, 6) == "0 N"


def test_labels_for_print():
    assert label_text("P(1;inf)") == "P(1;∞)"
    long = label_text("P(47;" + ":".join(["3"] * 47) + ")")
    assert len(long) <= 32
    assert long.endswith("…)")


# --- figures


@pytest.fixture(scope="module")
def drawn(chapter):
    speeds = speed(700.0, [150.0], [2.0]), speed(701.0, [151.0, 155.0], [2.1])
    return lambda: draw_sweep(sweep_of(*speeds), chapter, settings())


@pytest.mark.ci
@pytest.mark.slow
def test_same_bytes_whatever_the_user_set_and_his_settings_stay(drawn):
    first = png(drawn())
    own = {"font.size": 20, "savefig.dpi": 50, "axes.grid": True, "savefig.bbox": "tight"}
    with matplotlib.rc_context(own):
        before = dict(matplotlib.rcParams)
        assert png(drawn()) == first
        assert dict(matplotlib.rcParams) == before
    assert b"Software" not in first
    assert b"tIME" not in first


# --- forms


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pdf", "svg"])
def test_every_form_has_the_same_bytes_twice_its_width_and_no_date(drawn, kind):
    form = Plot(width=85.0, title=False)
    first = png(drawn(), kind, form)
    assert png(drawn(), kind, form) == first
    assert not re.search(
        rb"matplotlib.v|20\d\d-\d\d-\d\dT|CreationDate", first.split(b"<defs>")[0][:2000]
    )
    figure = drawn().figure(form)
    assert figure.get_figwidth() * 25.4 == pytest.approx(85.0)
    if kind == "pdf":
        assert b"/Image" in first  # clouds of points
        assert b"/FontFile2" in first or b"/Type42" in first or b"/CIDFontType2" in first
    else:  # text that can be searched and changed
        texts = re.findall(r"<text[^>]*>(?:<tspan[^>]*>)?([^<]+)", first.decode())
        assert "period 1" in " ".join(texts) or "aperiodic" in " ".join(texts)
        assert "cam speed (rpm)" in texts
        assert "DejaVuSans-" not in first.decode()  # outlines of letters


def test_no_text_is_smaller_than_six_points(drawn):
    for form in (Plot(), Plot(width=85.0)):
        figure = drawn().figure(form)
        sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text()]
        assert min(sizes) >= 6.0


def test_fonts_and_styles_are_named_or_refused(drawn, tmp_path, capfd, caplog):
    serif = drawn().figure(Plot(font="DejaVu Serif"))
    assert serif.axes[0].texts[0].get_fontname() == "DejaVu Serif"
    serif.axes[1].set_title(r"$\theta$")
    serif.savefig(tmp_path / "serif.png")
    assert not caplog.messages  # matplotlib would warn of families that it does not find
    sheet = tmp_path / "mine.mplstyle"
    sheet.write_text('axes.linewidth: 3  # mm\n\ngrid.color: "#ff0000"  # "red"\n')
    assert drawn().figure(Plot(style=str(sheet))).axes[1].spines["left"].get_linewidth() == 3
    assert drawn().figure(Plot(style="ggplot"))
    foreign, pipe = tmp_path / "passwd", tmp_path / "pipe"
    foreign.write_text("secret:x:0\n")
    os.mkfifo(pipe)
    for form, said in (
        (Plot(font="Nonesuch"), "plot.font: found 'Nonesuch', .*, name another: any installed one"),
        (Plot(font="dejavu serf"), "expected an installed font, did you mean DejaVu Serif"),
        (Plot(style="nonesuch"), "plot.style: no such file"),
        (Plot(style=str(foreign)), "passwd:1: plot.style: found no setting of matplotlib"),
        (Plot(style=str(pipe)), "plot.style: found a pipe"),
        (Plot(style="http://127.0.0.1:9/x"), "plot.style: no such file"),
    ):
        with pytest.raises(SceneError, match=said) as fault:
            drawn().figure(form)
        assert "secret" not in str(fault.value) + "".join(capfd.readouterr())


def test_a_list_wider_than_the_page_has_its_last_words_below():
    rows = [["", "", "event", "rpm"], ["", "1", "corner impact at c", "739.377929649", "x" * 28]]
    picture = Picture("x", {"one": Panel(lambda axes: None)}, lists=[rows])
    for width, lines in ((170.0, 2), (85.0, 3)):
        figure = picture.figure(Plot(width=width))
        heading = [text for text in figure.axes[0].texts if text.get_text() in rows[1][1:]]
        figure.canvas.draw()
        boxes = [text.get_window_extent() for text in heading]
        assert max(box.x1 for box in boxes) <= figure.bbox.x1
        assert len({round(text.get_position()[1], 3) for text in heading}) == lines - 1


def test_words_of_lists_and_legends_end_where_the_page_does():
    rows = [["", "event", "rpm", "motion"], ["1", "fold", "677.0188", "P(56;" + "2:1:" * 20]]

    def draw(axes):
        axes.plot([0.0], [0.0], label="the follower rests, which forgets every difference")

    picture = Picture("x", {"one": Panel(draw)}, lists=[rows])
    for width in (85.0, 170.0):
        figure = picture.figure(Plot(width=width))
        figure.canvas.draw()
        heading = figure.axes[0]
        words = [*heading.texts, *heading.get_legend().get_texts()]
        assert max(text.get_window_extent().x1 for text in words) <= figure.bbox.x1
        said = " ".join(text.get_text() for text in words).replace("\n", " ")
        assert "which forgets every difference" in said
        assert ("…" in said) == (width == 85.0)


def test_a_width_in_any_unit_is_that_of_the_picture(cam, tmp_path):
    widths = {"85": 85.0, "85mm": 85.0, " 8.5 cm": 85.0, "3in": 76.2, "144 pt": 50.8}
    assert {text: _millimetres(text, "width") for text in widths} == pytest.approx(widths)
    cam("simulate --set run.transient=0 --set run.record=1 --format svg --width 3in -o .", code=0)
    (points,) = re.findall(r'<svg [^>]*width="([\d.]+)pt"', (tmp_path / "simulate.svg").read_text())
    assert float(points) == pytest.approx(3.0 * 72.0, rel=1e-6)


def test_a_list_of_two_columns_stays_in_its_rows():
    rows = [["", "branch of attractors"], ["1", "P(3;3:3:2) " * 12], ["2", "P(1;2)"]]
    picture = Picture("x", {"one": Panel(lambda axes: None)}, lists=[rows])
    heading = picture.figure(Plot(width=85.0)).axes[0]
    lines = {round(text.get_position()[1], 6) for text in heading.texts if text.get_text()}
    assert len(lines) == 1 + len(rows)
    assert [text.get_text().endswith("…") for text in heading.texts if text.get_text()].count(
        1
    ) == 1


def test_a_list_beside_another_begins_where_its_long_title_ends():
    lists = [[["a title that is longer than its columns"], ["a", "b"], ["1", "2"]],
             [["another"], ["c", "d"], ["3", "4"]]]  # fmt: skip
    figure = Picture("x", {"one": Panel(lambda axes: None)}, lists=lists).figure()
    places = {
        text.get_text(): text.get_window_extent() for axes in figure.axes for text in axes.texts
    }
    long, other = places[lists[0][0][0]], places["another"]
    assert long.x1 < other.x0 or other.y1 < long.y0


def test_a_value_of_a_style_may_stand_in_quotes(tmp_path):
    sheet = tmp_path / "it.mplstyle"
    sheet.write_text('text.color : "red"  # of words\n\nfont.size: 8\n')
    settings = style._sheet(str(sheet))
    assert (settings["text.color"], settings["font.size"]) == ("red", 8.0)
    assert list(style._read(str(sheet))) == [(1, "text.color", "red"), (3, "font.size", "8")]


@pytest.mark.parametrize(
    ("ends", "shown"),
    [
        ((0.0, 1e-4), ["0.00", "0.02", "0.04", "0.06", "0.08", "0.10"]),
        ((-1e-3, 1e-3), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]),
        ((0.0, 4e-3), ["0", "1", "2", "3", "4"]),
    ],
)
def test_numbers_of_an_axis_in_millimetres_have_equal_decimals(ends, shown):
    axes = Figure().add_subplot()
    axes.set_ylim(ends)
    length_axis(axes.yaxis, "gap", 1e-3)
    ticks = np.linspace(*ends, len(shown))
    assert axes.yaxis.get_major_formatter().format_ticks(ticks) == shown


@pytest.mark.parametrize("ends", [(672.9, 673.6), (739.198, 739.502), (660.0, 760.0), (0.0, 3e5)])
@pytest.mark.parametrize("width", [85.0, 170.0])
def test_numbers_below_a_panel_stand_apart(ends, width):
    """By 4.5 pt, nearly a digit; there are three or more, however long they are."""
    side = Panel(lambda axes: axes.set_xlim(ends), 40.0, across=2)
    figure = Picture("", {"left": side, "right": side}).figure(Plot(width=width))
    figure.canvas.draw()
    for axes in figure.axes[1:]:  # the first has the heading
        inside = [
            label.get_window_extent()
            for label, tick in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
            if ends[0] <= tick <= ends[1]
        ]
        assert len(inside) >= 3
        for left, right in pairwise(inside):
            assert right.x0 - left.x1 > 4.5 / 72.0 * figure.dpi
