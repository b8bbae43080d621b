"""The picture of a map of two numbers against map.csv."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

import camcli
from camcli.plots import curve_numbers, sweep_map
from tests.conftest import some_in_ci
from tests.support.machines import CHAPTER, VALVE
from tests.support.picture_reader import check, dashes, hexed, read_page, usual
from tests.truth.test_pictures_sweep import kind_of

CASES = {
    "valve": (
        VALVE,
        [{"key": "rpm", "start": 3400, "stop": 2600, "num": 5},
         {"key": "follower.damping", "start": 0, "stop": 40, "num": 3}],
        {"sweep.lyapunov": True},
    ),
    "chapter": (
        CHAPTER,
        [{"key": "follower.restitution", "start": 0.7, "stop": 0.9, "num": 3},
         {"key": "run.strobe_deg", "start": 200, "stop": 20, "num": 4}],
        {"run.transient": 100, "run.record": 100, "run.rpm": 745, "sweep.direction": "up",
         "sweep.lyapunov": True},
    ),
    "many kinds": (
        CHAPTER,
        [{"key": "rpm", "start": 100, "stop": 760, "num": 12},
         {"key": "follower.restitution", "start": 0.6, "stop": 0.8, "num": 2}],
        {"run.transient": 200, "run.record": 100},
    ),
    "seat": (
        VALVE,
        [{"key": "rpm", "start": 2600, "stop": 3600, "num": 3},
         {"key": "cam.lash", "start": 0.0001, "stop": 0.0004, "num": 2}],
        {"run.transient": 10, "run.record": 10},
    ),
}  # fmt: skip
NAMES = {
    "rpm": "cam speed (rpm)", "follower.damping": "damping $b$ (N s/m)",
    "follower.restitution": "coefficient of restitution $r$ (-)",
    "run.strobe_deg": "phase of the strobe (deg)", "cam.lash": "lash (m)",
}  # fmt: skip
LOADS = {
    "exponents": ("lyapunov_per_period", "largest exponent (1/turn)"),
    "max_gap_m": ("max_gap_m", "largest gap"),
    "airborne_fraction": ("airborne_fraction", "share of the time in the air"),
    "max_impact_m_per_s": ("max_impact_m_per_s", "hardest impact (m/s)"),
    "min_contact_force_n": ("min_contact_force_n", "least contact force (N)"),
    "max_contact_force_n": ("max_contact_force_n", "largest contact force (N)"),
    "contact_lost_deg": ("contact_lost_deg", "contact first lost (deg)"),
    "contact_regained_deg": ("contact_regained_deg", "contact last regained (deg)"),
    "landing_deg": ("landing_deg", "phase of the hardest impact (deg)"),
    "landing_lift_m": ("landing_lift_m", "lift at the hardest impact"),
    "shut_bounces_per_turn": ("shut_bounces_per_turn", "bounces on the shut cam (1/turn)"),
}
SEAT = {
    "seat_velocity_m_per_s": ("seat_velocity_m_per_s", "seating velocity (m/s)"),
    "seat_ramp_velocity_m_per_s":
        ("seat_ramp_velocity_m_per_s", "velocity of the closing ramp (m/s)"),
    "seat_opening_velocity_m_per_s": ("seat_opening_velocity_m_per_s", "opening blow (m/s)"),
    "seat_bounces_per_turn": ("seat_bounces_per_turn", "impacts on the seat (1/turn)"),
    "seat_bounce_height_m": ("seat_bounce_height_m", "height of the bounces"),
    "seat_lift_lost_m": ("seat_lift_lost_m", "lift lost to lash"),
    "seat_open_deg": ("seat_open_deg", "open angle (deg)"),
    "seat_open_lash_deg": ("seat_open_lash_deg", "open angle with lash (deg)"),
    "seat_open_drawn_deg": ("seat_open_drawn_deg", "open angle as drawn (deg)"),
    "seat_lobe_fraction": ("seat_lobe_fraction", "share of the turn on the lobe"),
}  # fmt: skip
CURVES = (  # kind, label, corner, along both numbers, dashes, colour, width, name: made up
    ("period-doubling", "P(1;2)", "", [2700.0, 3100.0, 3500.0], [5.0, 15.0, 30.0], "dashed",
     "black", 0.9, "period doubling of P(1;2)"),
    ("corner-impact", "P(1;2)", "b", [2800.0, 2900.0], [35.0, 10.0], "solid",
     "#B2182B", 0.9, "corner impact at b of P(1;2)"),
    ("fold", "P(2;2:1)", "", [3000.0, 3050.0], [1.0, 39.0], "dotted",
     "#7FDCC0", 0.9, "fold of P(2;2:1)"),
    ("corner-impact", "P(2;2:1)", "c", [2900.0, 3000.0], [35.0, 10.0], "solid",
     "white", 0.9, "corner impact at c of P(2;2:1)"),
    ("corner-impact", "P(2;2:1)", "d", [3000.0, 3100.0], [35.0, 10.0], "solid",
     "black", 2.0, "corner impact at d of P(2;2:1)"),
)  # fmt: skip
AREAS = {  # of the colours in diagrams, those of the areas of a map
    "period 1": "#5382DE", "period 2": "#74CDFA", "period 3": "#F06080", "period 4": "#7D7F38",
    "longer periods": "#A55596", "with rests": "#E39B33", "contact": "#FBCEA7",
    "aperiodic": "#BFBFBF", "undecided": "#FFFFFF", "undecided after rests": "#FFFFFF",
}  # fmt: skip


@cache
def made(name, curves=None):
    machine, axes, values = CASES[name]
    more = {} if curves is None else {"sweep.curves": curves}
    return camcli.sweep(machine.load({"sweep.vary": axes, **values, **more}))


def checks(name, curves):
    machine, axes, _ = CASES[name]
    keys = [axis["key"] for axis in axes]
    table = made(name).tables["map"]
    x, y = (table[key] for key in keys)
    kinds = [kind_of(label)[0] for label in table["label"]]
    if name == "many kinds":  # all of them rest in some turns
        kinds = [{"undecided": "undecided after rests"}.get(kind, kind) for kind in kinds]
    kinds = [(kind, AREAS[kind]) for kind in kinds]

    def common(panel):
        for number, (*_, along, across, style, colour, width, _) in enumerate(curves, 1):
            panel.line(along, across, colour, style, width=width)
            where = panel.words(str(number)).xy
            assert any(where == pytest.approx(at) for at in zip(along, across, strict=True))
        for way, key, values in zip("xy", keys, (x, y), strict=True):
            assert getattr(panel.axes, f"get_{way}label")() == NAMES[key]
            limits = getattr(panel.axes, f"get_{way}lim")()
            half = 0.5 * np.diff(np.unique(values))[0]
            assert limits == pytest.approx((values.min() - half, values.max() + half))

    def kind(panel):
        (image,) = panel.images()
        assert image.values.shape == (len(set(y)), len(set(x)))
        for *place, (_, colour) in zip(x, y, kinds, strict=True):
            assert image.colour(*place) == colour
        panel.key(*sorted(set(kinds)))
        common(panel)

    def load(panel):
        column, words = {**LOADS, **SEAT}[panel.name]
        metres = column.endswith("_m")
        if not np.isfinite(table[column]).any():
            panel.words("no value at any of these points")
            assert panel.axes.get_title(loc="right").startswith(words)
            assert not panel.images()
            common(panel)
            return
        if not np.isfinite(table[column]).all():
            assert hexed(panel.axes.get_facecolor()) == "#808080"
            panel.key(("no value", "#808080"))
        (image,) = panel.images()
        shown = np.ma.filled(image.value(x, y).astype(float), np.nan)
        wanted = table[column] * (machine.per_m if metres else 1.0)
        wanted[~np.isfinite(wanted)] = np.nan  # blank: at rest, or it does not apply
        assert shown == pytest.approx(wanted, nan_ok=True)
        (bar,) = [axes for axes in panel.bars if axes.get_ylabel().startswith(words)]
        assert bar.get_ylabel() == (f"{words} ({machine.unit})" if metres else words)
        if np.isfinite(shown).any():
            low, high = image.artist.norm.vmin, image.artist.norm.vmax
            assert bar.get_ylim() == pytest.approx((low, high))
            if column == "lyapunov_per_period":  # white is zero, red is chaos
                assert low == -high
                assert high >= np.nanmax(np.abs(shown[np.isfinite(shown)]))
                red, _, blue = image.artist.cmap(1.0)[:3]
                assert red > 2.0 * blue
        common(panel)

    of_seat = SEAT if name == "seat" else {}
    return {"kind": kind, **dict.fromkeys({**LOADS, **of_seat}, load)}


def curves_table():
    """What `cam orbits --curve` would have written of the curves."""
    lines = ["curve,kind,label,corner,rpm,damping_n_s_per_m"]
    for number, (kind, label, corner, along, across, *_) in enumerate(CURVES, 1):
        named = f"{number},{kind},{label},{corner}"
        lines += [f"{named},{a},{b}" for a, b in zip(along, across, strict=True)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", some_in_ci(CASES, quick=["many kinds"]))
def test_every_panel_of_a_map_shows_the_rows_of_its_table(name, tmp_path):
    path, curves = None, ()
    if name == "valve":
        curves, path = CURVES, str(tmp_path / "curve.csv")
        (tmp_path / "curve.csv").write_text(curves_table())
    own = checks(name, curves)
    assert check(made(name, path), own) == {*own}


def test_curves_over_a_map_are_listed_and_no_two_neighbours_of_a_kind_look_alike(tmp_path):
    (tmp_path / "curve.csv").write_text(curves_table())
    page = read_page(made("valve", str(tmp_path / "curve.csv")))
    looks = []
    for number, (*_, style, colour, width, words) in enumerate(CURVES, 1):
        line, *_ = page.row(str(number), words)
        assert dashes(line) == style
        assert hexed(line.get_color()) == hexed(colour)
        assert line.get_linewidth() == width
        looks.append((style, colour, width))
    assert len(set(looks)) == len(CURVES)


def test_a_band_lies_along_the_parts_of_a_curve_that_are_proved(tmp_path):
    cells = {1: ("yes", "no", "yes", ""), 2: ("no", ""), 3: ("", "")}
    points = {1: (2700, 2900, 3100, 3300), 2: (2800, 2900), 3: (2650, 2700)}
    lines = ["curve,kind,label,corner,rpm,damping_n_s_per_m,proved_to_next"]
    for number, own in cells.items():
        kind = CURVES[number - 1][0] if number < 3 else "fold"
        named = f"{number},{kind},P({number};1),"
        lines += [f"{named},{x},{x / 100},{y}" for x, y in zip(points[number], own, strict=True)]
    (tmp_path / "curve.csv").write_text("\n".join(lines) + "\n")
    result = made("valve", str(tmp_path / "curve.csv"))
    page = read_page(result)
    row = page.row("proved without a gap")
    sample = row[row.index("proved without a gap") - 1]
    assert hexed(sample.get_color()) == "#FFE600"
    panel = page.figure.axes[1]
    bands = [one for one in panel.lines if hexed(one.get_color()) == "#FFE600"]
    assert [[*map(float, one.get_xdata())] for one in bands] == [[2700, 2900], [3100, 3300]]
    curves = [one for one in panel.lines if len(one.get_xdata()) and one not in bands]
    assert len(curves) == len(cells)
    assert all(one.get_zorder() > band.get_zorder() for one in curves for band in bands)
    (tmp_path / "plain.csv").write_text(curves_table())
    assert "proved without a gap" not in read_page(made("valve", str(tmp_path / "plain.csv"))).texts


def test_the_page_of_a_map_says_what_was_done():
    assert usual(made("chapter")) == ["kind", "exponents"]
    assert usual(made("valve")) == ["kind"]  # at rest everywhere: no finite exponent
    page = read_page(made("valve"))
    assert page.texts[0] == "Map of motions, 2600 to 3400 rpm, damping 0 to 40 N s/m"
    page.says("5 × 3 points")
    page = read_page(made("chapter"))
    page.says(
        "Map of motions, coefficient of restitution 0.7 to 0.9, phase of the strobe 20 to",
        "200 deg",
        "3 × 4 points at 745 rpm, the state carried up along the coefficient of restitution",
    )
    assert {*page.legend} == {kind_of(k)[0] for k in made("chapter").tables["map"]["label"]}


def test_eight_curves_in_a_row_look_different():
    """By colour and width; the edge tells each from a map of its own colour."""
    lines, colours = sweep_map.LINES, sweep_map.style
    assert len({(colour, width) for colour, width, _ in lines}) == len(lines) == 8
    assert {(colour, edge) for colour, _, edge in lines} == {
        ("black", "white"), ("white", "black"),
        (colours.CURVE_RED, "white"), (colours.CURVE_GREEN, "black"),
    }  # fmt: skip


def panel_with(lines, marks=()):
    """Axes of 80 by 60 mm from 0 to 1, and the spots of the numbers of curves in them."""
    figure = Figure(figsize=(100.0 / 25.4, 75.0 / 25.4), dpi=300)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    return axes, curve_numbers.spots_of(axes, lines, marks)


def boxes_of_numbers(axes, spots):
    """Where the numbers are on the page, pixels."""
    for number, spot in enumerate(spots, 1):
        curve_numbers.write_number(axes, number, spot)
    renderer = axes.figure.canvas.get_renderer()
    for text in axes.texts:
        text.update_positions(renderer)
    # of the words alone: the box of an annotation holds its line as well
    return [Text.get_window_extent(text, renderer) for text in axes.texts]


@pytest.mark.parametrize("place", [(x, y) for x in (0.0, 0.95, 1.0) for y in (0.0, 0.95, 1.0)])
def test_the_number_of_a_curve_at_an_edge_lies_within_the_panel(place):
    axes, spots = panel_with([([place[0]], [place[1]])])
    assert spots[0].place == place
    (box,) = boxes_of_numbers(axes, spots)
    assert axes.bbox.x0 <= box.x0 < box.x1 <= axes.bbox.x1
    assert axes.bbox.y0 <= box.y0 < box.y1 <= axes.bbox.y1


@pytest.mark.parametrize(("length", "beside"), [(0.9, False), (0.02, True)])
def test_a_point_of_codimension_two_does_not_lie_below_the_number_of_a_curve(length, beside):
    """The number stands elsewhere on the curve, or beside it where that is too short."""
    along = 0.5 + length * np.linspace(-0.5, 0.5, 101)
    axes, spots = panel_with([(along, [0.5] * 101)], [(0.5, 0.5)])
    assert (spots[0].way != (0.0, 0.0)) is beside
    (box,) = boxes_of_numbers(axes, spots)
    mark, height = axes.transData.transform((0.5, 0.5))
    radius = 0.5 * (5.5 + 1.1) / 72.0 * axes.figure.dpi
    over = box.x0 - radius < mark < box.x1 + radius and box.y0 - radius < height < box.y1 + radius
    assert not over
    assert bool(axes.texts[0].arrow_patch) is beside


def test_numbers_of_curves_that_run_along_each_other_do_not_lie_on_one_another():
    along = np.linspace(0.1, 0.9, 50)
    lines = [(along, 0.5 + 0.01 * k + 0.1 * along) for k in range(4)]
    axes, spots = panel_with(lines)
    for one, other in combinations(boxes_of_numbers(axes, spots), 2):
        assert not one.overlaps(other)


def test_a_curve_beside_the_panel_has_no_number():
    _, spots = panel_with([([2.0, 3.0], [0.5, 0.5]), ([], []), ([0.2, 0.8], [0.5, 0.5])])
    assert [spot is not None for spot in spots] == [False, False, True]
