"""Pages, lists and single panels by hand: what has room, and which of two stands where."""

from __future__ import annotations

from math import nan, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from camcli.analysis.orbits.codim2 import PointKind
from camcli.errors import SceneError
from camcli.plots import axes as own_axes
from camcli.plots import (
    basins,
    bench,
    cam_profile,
    chaos,
    critical_speeds,
    curve_numbers,
    density,
    orbits,
    picture,
    style,
    sweep_map,
)
from camcli.plots.picture import Panel, Picture
from camcli.quantities import METRES, MILLIMETRES
from camcli.scene.schema import Plot


@pytest.fixture
def axes():
    return Figure().subplots()


# --- pages


def test_all_panels_of_a_row_that_has_no_room_are_told():
    panels = {name: Panel(len, 60.0, across=across)
              for name, across in (("a", 1), ("b", 2), ("c", 2), ("d", 1))}  # fmt: skip
    rows, left_out = picture._rows_with_room(panels, Made(width=170.0), 60.0)
    assert [[name for name, _ in row] for row in rows] == [["a"]]
    assert left_out == ["d", "b", "c"]
    rows, left_out = picture._rows_with_room(panels, Made(width=170.0), 999.0)
    assert [[name for name, _ in row] for row in rows] == [["a"], ["b", "c"], ["d"]]
    # panels share their numbers with as many right below them
    over_speed = Panel(len, x="rpm")
    two, one = [("a", over_speed), ("b", over_speed)], [("c", over_speed)]
    assert picture._shared([two, one, one, two, two]) == [False, True, False, True]


def test_panels_of_a_column_have_one_letter_above_the_first_of_them():
    def titled(axes):
        axes.set_title("words", loc="left")

    page = picture.Page(layout=picture._Layout())
    rows = [[("a", Panel(titled, 30.0, column="left")), ("b", Panel(titled, 30.0, column="right"))],
            [("c", Panel(titled, 30.0, column="left")), ("d", Panel(titled, 30.0))]]  # fmt: skip
    picture._draw_rows(page, rows, Made(width=170.0))
    titles = [axes.get_title(loc="left") for axes in page.axes]
    assert titles == ["(a) words", "(b) words", "words", "(c) words"]
    assert picture._letters([Panel(len)] * 28)[25:] == ["(z)", "(a)", "(b)"]
    assert picture._letters([Panel(len, y="v")] * 2) == ["(a)", "(b)"]


def test_a_page_is_made_however_much_stands_above_its_panels():
    words = "\n".join(f"line {k}" for k in range(40))  # 156 mm
    own = Picture("T", {"a": Panel(lambda axes: None, 40.0)}, words=words)
    page = own.figure(Plot(height=60.0))
    assert page.get_figheight() * 25.4 == pytest.approx(60.0)
    assert not page.has_room


def test_positions_of_orbits_are_shown_with_those_of_simulated_motions(axes, monkeypatch):
    limits = []
    monkeypatch.setattr(
        orbits, "_draw_simulated", lambda axes, scene, section, span: limits.append((section, span))
    )
    for name in ("_over_parameter", "_draw_branches", "strobe_axis"):
        monkeypatch.setattr(orbits, name, lambda *_, **__: None)
    motions = [Made(strobe=([0], own)) for own in ([0.25, 0.5], [], [0.0])]
    scene = Made(every=lambda of: np.array([0.125]), simulated=Made(speeds=motions), events=[],
                 system=Made(lift=0.01))  # fmt: skip
    orbits._draw_positions(axes, scene)
    assert limits == [("strobe", pytest.approx((-0.02, 0.52)))]


@pytest.mark.parametrize(("place", "said", "aside"), [(607.9, "", True), (608.1, "", False),
                                                      (607.9, "words", False)])  # fmt: skip
def test_a_letter_stands_aside_of_a_number_above_the_left_end(axes, place, said, aside):
    """Within 8 of 100 rpm, and where the panel has no words there."""
    axes.set_xlim(600.0, 700.0)
    axes.annotate("1", (place, 1.0), (place, 11), textcoords=("data", "offset points"),
                  arrowprops={"arrowstyle": "-"})  # fmt: skip
    axes.annotate("no arrow", (600.0, 0.0))
    axes.set_title(said, loc="left")
    picture._name(axes, "(b)")
    title = axes._left_title
    assert title.get_text() == ("(b) words" if said else "(b)")
    assert (title.get_ha() == "right") is aside
    assert (title.get_position()[0] < 0.0) is aside


def test_a_heading_takes_its_room_from_the_lists():
    """In a column of a journal, 42 % of its height, rows of 3.4 mm."""
    rows = [["", "event"], *([str(k), "x" * k] for k in range(1, 40))]
    for top, count in ((2.0, 14), (22.4, 8)):
        (cut,) = picture._Heading._listed(Made(wide=90.0, top=top), [rows], 120.0)
        assert len(cut) == count


def heading(wide=200.0):
    """A heading without a title on a page so many mm wide."""
    page = picture.Page(figsize=(wide / 25.4, 2.0), layout=picture._Layout())
    FigureCanvasAgg(page)
    whole = page.add_axes((0.0, 0.0, 1.0, 1.0))
    return picture._Heading(whole, Picture("T", {}), Made(width=wide, title=False), 230.0)


def test_a_title_has_shorter_lines_where_any_of_them_is_wider_than_the_page():
    """Lines of 51 letters, and of 44 where one has wide ones; numbers stay with their units."""
    wide = " ".join(["W" * 10] * 4)
    for title, lines in ((f"{wide} and i iiii iiii iiii", [wide, "and i iiii iiii iiii"]),
                         ("i" * 40 + " and iii iii", ["i" * 40 + " and iii", "iii"])):  # fmt: skip
        with style.look():
            page = picture.Page(figsize=(100.0 / 25.4, 2.0), layout=picture._Layout())
            FigureCanvasAgg(page)
            whole = page.add_axes((0.0, 0.0, 1.0, 1.0))
            own = picture._Heading(whole, Picture(title, {}), Made(width=100.0, title=True), 230.0)
        assert [text.get_text() for text in own.axes.texts] == lines
    narrow = Figure(figsize=(0.9, 1.0), dpi=100).add_axes((0.1, 0.1, 0.8, 0.8))
    narrow.set_title("it is at 700 rpm", loc="right", size=8)
    picture._fold_title(narrow)
    assert narrow.get_title(loc="right") == "it is at\n700 rpm"


@pytest.mark.parametrize("ends", [(0.0, 100.0), (100.0, 0.0)])
def test_ticks_along_an_axis_have_room_for_their_numbers_down_to_two_steps(ends):
    """Also on an axis that falls; a number has a letter of room beside it."""
    counts = []
    for inches in (4.0, 1.0, 0.25):
        axes = Figure(figsize=(inches, 1.0), dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set_xlim(*ends)
        axes.xaxis.set_major_locator(locator := picture._Apart())
        ticks = [x for x in locator() if 0.0 <= x <= 100.0]
        counts.append(len(ticks))
        letters = max(len(f"{x:g}") for x in ticks) + 1
        step = (ticks[1] - ticks[0]) / 100.0 * inches * 72.0
        size = axes.xaxis.get_major_ticks(1)[0].label1.get_size()
        assert inches < 0.5 or letters * 0.64 * size <= step
    assert counts == [6, 3, 3]


def test_panels_have_no_small_ticks_on_either_axis():
    page = picture.Page()
    axes = picture._new_axes(page, page.add_gridspec(1, 1)[0])
    assert vars(axes.xaxis)["minorTicks"] == vars(axes.yaxis)["minorTicks"] == []


def test_a_list_is_as_wide_as_its_last_column_and_as_a_title_above_all():
    with style.look():
        own = heading()

        def end(*rows):
            return own._list(2.0, [list(row) for row in rows])

        narrow, wide = "i", "a very long cell of a list"
        short = end(("", "a"), ("1", narrow))
        assert end(("", "a"), ("1", wide)) > short + 20.0
        assert end(("", wide), ("1", narrow)) > short + 20.0  # the head is a cell as others are
        # words alone in a row reach over what is beside them, and do not push it away
        over = end(("", "a", "b"), ("1", narrow, narrow), (wide,))
        assert own.axes.texts[-1].get_position()[0] < 20.0
        assert over > short + 20.0


def test_a_legend_has_the_most_columns_that_fit():
    """Five words in 5, 3, 2 or 1 columns: rows are as full as they can be."""
    found = {}
    with style.look():
        for wide in (50.0, 110.0):
            own = heading(wide)
            handles = {f"{k} some words here": own.axes.plot([], [])[0] for k in range(5)}
            own.finish(handles)
            found[wide] = own.axes.get_legend()._ncols
        own = heading(400.0)
        own.finish({f"{k} some words here": own.axes.plot([], [])[0] for k in range(5)})
        whole = own.axes.get_legend().get_window_extent().width / style.DPI * 25.4
        for more, columns in ((3.8, 3), (4.2, 5)):  # 2 mm on either side
            own = heading(whole + more)
            own.finish({f"{k} some words here": own.axes.plot([], [])[0] for k in range(5)})
            assert own.axes.get_legend()._ncols == columns
    assert found == {50.0: 1, 110.0: 3}


# --- cams


def cam(units=MILLIMETRES, beside=False, corners=0, **more):
    names = {f"c{k}": 0.1 * k for k in range(corners)}
    own = {"theta": [0.0, 1.0], "c": [0.0, 0.1], "c3": [0.0, 5.0], "corners": names,
           "force": Made(rpm=700.0, force_n=[1.0, 2.0], lowest_n=1.0, theta=[0.0, 1.0]),
           }  # fmt: skip
    return Made(profile=Made(**own), units=units, beside=beside, measured=False, **more)


@pytest.mark.parametrize(
    ("units", "panel", "beside", "second"),
    [
        (MILLIMETRES, "velocity", False, True), (MILLIMETRES, "velocity", True, False),
        (MILLIMETRES, "lift", False, False), (METRES, "velocity", False, False),
    ],
)  # fmt: skip
def test_a_cam_alone_has_a_second_axis_in_millimetres(axes, units, panel, beside, second):
    cam_profile._name(axes, cam(units, beside), panel)
    assert bool(axes.child_axes) is second


@pytest.mark.parametrize(("count", "below"), [(0, ""), (1, "\n"), (26, "\n"), (27, "")])
def test_a_title_above_names_of_corners_has_a_line_for_them(axes, count, below):
    cam_profile._draw_force(axes, cam(corners=count))
    title = axes.get_title(loc="right") or axes.get_title()
    assert title == f"at 700 rpm, least 1 N{below}"


def test_the_jerk_of_a_measured_cam_has_the_error_of_its_own(axes, monkeypatch):
    doubted = []
    monkeypatch.setattr(cam_profile, "_doubt", lambda *how: doubted.append(how[2:]))
    errors = Made(bounds=[1.0, 2.0], jerk=Made(bounds=[30.0, 70.0, 50.0]))
    one = cam(METRES, cam=Made(errors=errors))
    one.measured = True
    cam_profile._draw_jerk(axes, one)
    assert doubted == [([0.0, 5.0], [30.0, 70.0, 50.0], None)]
    titles = axes.get_title() + axes.get_title(loc="right")
    assert "up to 70 m/rad³" in titles


def test_cams_side_by_side_are_compared_panel_by_panel(monkeypatch):
    """Of the second cam and of others only what is compared is shown, the outline among it."""
    names = ["outline", "turned", "lift", "jerk", "force"]
    made = []

    def panels(cam, among):
        made.append((cam.beside, len(among)))
        return {name: Panel(len, float(cam.number)) for name in names}

    monkeypatch.setattr(cam_profile, "_panels", panels)
    monkeypatch.setattr(
        cam_profile, "replace", lambda cam, beside: Made(**{**vars(cam), "beside": beside})
    )
    monkeypatch.setattr(cam_profile, "cam_words", lambda *_: "")
    monkeypatch.setattr(cam_profile, "cam_name", lambda cam: cam)
    cams = [Made(number=k, measured=False, cam=f"cam {k}", units=METRES, outline=Made(ratio=1.0),
                 profile=Made(first=None, ranges={"c": (Made(value=0.5), Made(value=0.75))}))
            for k in (1, 2, 3)]  # fmt: skip
    drawn = cam_profile.draw_profiles(cams)
    assert {name: panel.height for name, panel in drawn.panels.items()} == {
        "outline": 1.0, "outline 2": 2.0, "outline 3": 3.0, "turned": 1.0, "lift": 1.0,
        "lift 2": 2.0, "lift 3": 3.0, "jerk": 1.0, "force": 1.0, "force 2": 2.0, "force 3": 3.0,
    }  # fmt: skip
    assert drawn.title == "Cams side by side: cam 1, cam 2, cam 3"
    assert made == [(True, 3)] * 3
    made.clear()
    alone = cam_profile.draw_profiles(cams[:1])
    assert (list(alone.panels), made) == (names, [(False, 0)])
    assert alone.title == "Cam with a lift of 0.25 m"


# --- basins


def test_labels_of_a_branch_are_counted_once_each():
    labels = ["P(1;1)"] * 5 + ["P(2;2)", "P(1;1)"]
    assert basins._in_lines(4, labels) == ["4: P(1;1), P(2;2)"]
    assert basins._branch_labels(labels) == "P(1;1), P(2;2)"
    many = [f"P({k};{k})" for k in range(1, 6)]
    assert basins._in_lines(4, many) == ["4: P(1;1), P(2;2)", "P(3;3) and 2 more labels"]
    assert basins._branch_labels(many) == "P(1;1), P(2;2), P(3;3) and 2 more labels"


@pytest.mark.parametrize(
    ("share", "told"),
    [
        ((0.123456, 0.00096), "(12.35 ± 0.10) %"), ((0.123456, 0.00094), "(12.346 ± 0.094) %"),
        ((0.5, 0.0), "50 %"), ((0.5, 1e-12), "(50.00000000 ± 0.00000000) %"),
        ((0.5, 0.012), "(50.00 ± 1.20) %"),
    ],
)  # fmt: skip
def test_a_share_has_the_digits_that_its_error_leaves(share, told):
    assert basins.percent(share) == told


def window(**more):
    own = {"window": Made(q=(0.0, 1.0), v=(-4.0, 4.0), nq=2, nv=1), "saddles": None, "rpm": 60.0,
           "codes": np.array([[1, 1]]), "branches": (2,), "cam_q": 0.25, "regions": ()}  # fmt: skip
    return Made(**{**own, **more})


def seen(monkeypatch, basin, axes):
    monkeypatch.setattr(basins, "unit_axis", lambda *_: None)
    monkeypatch.setattr(basins, "units_of", lambda system: METRES)
    basins._draw_window(axes, basin, {2: "#112233"}, "", None)
    return axes.lines


def test_a_window_shows_part_of_an_ellipse_a_few_dots_and_a_cam_that_is_in_it(axes, monkeypatch):
    states = np.column_stack([np.linspace(0.0, 1.0, 9000), np.zeros(9000)])
    chaos_of = Made(periodic=False, states=states, label="aperiodic", shown=lambda: states)
    part = np.array([0.9, 1.1]), np.array([0.0, 0.0])
    beside = np.array([1.2, 1.1]), np.array([0.0, 0.0])
    monkeypatch.setattr(basins, "_ellipses", lambda basins: [beside, part])
    dots, ellipse, cam_line = seen(monkeypatch, window(attractors=(chaos_of,)), axes)
    assert len(dots.get_xdata()) == 3000
    assert dots.get_xdata()[1] == pytest.approx(3.0 / 8999.0)
    assert (ellipse.get_xdata().tolist(), ellipse.get_label()) == ([0.9, 1.1], basins.IN_ELLIPSE)
    assert cam_line.get_xdata()[0] == 0.25
    for below in (-0.1, 1.1):
        lines = seen(monkeypatch, window(attractors=(chaos_of,), cam_q=below), Figure().subplots())
        assert len(lines) == 2


def test_what_is_left_of_the_window_is_grey_however_little(axes):
    speeds = [Made(branches=(1,), fractions={1: (share, 0.0)}) for share in (0.995, 1.0)]
    basins._draw_stack(axes, Made(speeds=speeds), np.array([0.0, 1.0, 3.0]), {1: "#112233"}, "rpm")
    heights = [bar.get_height() for bar in axes.patches]
    assert heights == pytest.approx([0.995, 1.0, 0.005, 0.0])


def test_an_attractor_has_a_row_by_the_windows_it_is_in(monkeypatch):
    monkeypatch.setattr(basins, "_inside", lambda speed, attractor: np.array([attractor.inside]))
    rows = []
    for first, second in ((True, False), (False, True), (False, False)):
        two = [Made(periodic=True, states=[1], inside=one) for one in (first, second)]
        grids = [Made(branches=(3,), attractors=(one,), fractions={1: (0.5, 0.0)}) for one in two]
        rows.append(basins._attractor_row(grids, 3, ["P(1;1)"], "#112233"))
    assert [row[-1] for row in rows] == ["", "", "attractor outside the window"]
    assert [bool(row[1]) for row in rows] == [True, True, False]


# --- the bench, chaos, maps, curves


@pytest.mark.parametrize(("wide", "end"), [(54.0, ",\n700 rpm"), (56.0, " at 700 rpm")])
def test_a_long_title_of_a_case_is_broken_in_a_narrow_panel(monkeypatch, wide, end):
    monkeypatch.setattr(bench, "case", lambda name: Made(title="a long title of a case at 700 rpm"))
    figure = Figure(figsize=(wide / 25.4, 1.0), dpi=300)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    bench._name_case(axes, "case")
    assert axes.get_title(loc="left") == "a long title of a case" + end
    assert axes.get_xlabel().startswith("time of a run")


def test_cases_that_take_no_time_are_shown_and_all_but_the_expected_count(monkeypatch):
    told = []
    monkeypatch.setattr(bench, "cases_title", lambda *how: told.append(how) or "")
    told_of = {0.0: "ok", 0.5: "crashed", 2.0: "failed"}
    rows = [Made(case="a case", seconds=own, status=status) for own, status in told_of.items()]
    bench.draw_stability(rows)
    assert told == [(3, 2)]
    axes = Figure(figsize=(6.0, 3.0), dpi=300).subplots()
    bench._draw_rows(axes, rows)
    assert axes.get_xlim() == pytest.approx((0.4e-5, 24.0))


def test_the_section_of_chaos_holds_boxes_and_their_images(axes):
    outline = np.radians([[10.0, 20.0], [0.0, 0.0]]) * [[1.0], [0.0]] + [[0.0], [0.5]]
    image = np.radians([[40.0, 90.0], [0.0, 0.0]]) * [[1.0], [0.0]] + [[0.0], [2.5]]
    view = Made(impacts=np.array([[0.0], [0.1]]), outlines=[outline], images=[image])
    box = Made(middle=(radians(15.0), 0.5))
    found = Made(boxes=[box], rpm=60.0)
    chaos._draw_boxes(axes, found, view)
    assert axes.get_xlim() == pytest.approx((10.0 - 3.2, 90.0 + 3.2))
    assert axes.get_ylim() == pytest.approx((np.pi - 0.16 * np.pi, 5.0 * np.pi + 0.16 * np.pi))
    assert axes.texts[-1].xy == pytest.approx((15.0, np.pi))
    nothing = Made(boxes=[], rpm=60.0)
    chaos._draw_boxes(other := Figure().subplots(), nothing, Made(**{**vars(view), "outlines": [],
                                                                     "images": []}))  # fmt: skip
    assert other.get_ylim() == pytest.approx((0.18 * np.pi, 0.22 * np.pi))


def test_a_map_has_exponents_where_any_is_known_and_loads_in_the_units_of_the_machine(monkeypatch):
    monkeypatch.setattr(sweep_map, "map_heading", lambda *_: ("", ""))
    monkeypatch.setattr(sweep_map, "_value", lambda speed, name: speed)
    drawn = []
    monkeypatch.setattr(
        sweep_map, "_draw_values", lambda found, values, *more: drawn.append(values.tolist())
    )
    found = Made(lines=[[0.5, nan], [nan, 0.25]], first=[1.0, 2.0], second=[3.0, 4.0],
                 keys=("rpm", "mass"))  # fmt: skip
    panels = sweep_map.draw_map(found, MILLIMETRES).panels
    assert [name for name, panel in panels.items() if panel.usual] == ["kind", "exponents"]
    panels["max_gap_m"].draw(Figure().subplots())
    (values,) = drawn
    assert values[0][0] == 500.0
    found.lines = [[nan, nan], [nan, nan]]
    panels = sweep_map.draw_map(found, METRES).panels
    assert [name for name, panel in panels.items() if panel.usual] == ["kind"]


def test_points_of_codimension_two_have_the_mark_of_their_kind(axes):
    kinds = list(PointKind)
    points = [Made(kind=kinds[k], first=1.0 + n, second=2.0 + n)
              for n, k in enumerate((3, 1, 3))]  # fmt: skip
    own_axes.mark_points(axes, points)
    assert [(line.get_label(), line.get_xydata().tolist()) for line in axes.lines] == [
        (kinds[3].replace("-", " "), [[1.0, 2.0], [3.0, 4.0]]),
        (kinds[1].replace("-", " "), [[2.0, 3.0]]),
    ]
    marks = [line.get_marker() for line in axes.lines]
    assert marks == [own_axes.POINT_MARKS[3], own_axes.POINT_MARKS[1]]
    own_axes.mark_points(other := Figure().subplots(), points, named=False)
    assert all(line.get_label().startswith("_") for line in other.lines)


def test_what_is_drawn_of_curves_is_all_there_when_their_numbers_are_placed(monkeypatch):
    """A curve is no obstacle for its own number alone, and one beside the panel has none."""
    inks = []

    class Noted(curve_numbers._Ink):
        def __init__(self, size):
            super().__init__(size)
            inks.append(self)

    monkeypatch.setattr(curve_numbers, "_Ink", Noted)
    figure = Figure(figsize=(500.0 / 72.0, 400.0 / 72.0), dpi=300)
    axes = figure.add_axes((0.1, 0.1, 400.0 / 500.0, 300.0 / 400.0))
    axes.set(xlim=(0.0, 400.0), ylim=(0.0, 300.0))
    curves = [([50.0, 350.0], [50.0, 60.0]), ([500.0, 600.0], [100.0, 100.0]),
              ([50.0, 350.0], [250.0, 240.0])]  # fmt: skip
    spots = curve_numbers.spots_of(axes, curves)
    assert [spot is None for spot in spots] == [False, True, False]
    (ink,) = inks
    for x, y in (curves[0], curves[2]):
        line = curve_numbers._in_points(axes, np.column_stack([x, y]), np.array([400.0, 300.0]))
        cells = ink.cells_of(line)
        assert (ink._count.ravel()[cells] >= 1).mean() > 0.95  # but for roundings of halves


def test_a_list_of_events_is_one_up_to_twenty_numbered_ones():
    def event(k):
        return Made(kind="fold", corner="", rpm=700.0 + k, error=0.0, label="P(1;1)", status="ok",
                    classification="")  # fmt: skip

    for count, lists in ((20, 1), (21, 2)):
        events = [(k, event(k)) for k in range(1, count + 1)]
        assert len(critical_speeds.event_lists(events)) == lists
        found = critical_speeds.event_lists([*events, (None, event(99)), (None, event(98))])
        assert len(found) == lists + 1
        assert found[-1] == [["and 2 more, drawn without a number, listed in run.json"]]
        assert sum(len(rows) - 1 for rows in found[:-1]) == count
    two = critical_speeds.event_lists([(k, event(k)) for k in range(1, 22)])
    assert [rows[1][0] for rows in two] == ["1", "12"]


def test_orbits_of_one_speed_are_drawn_over_their_own_periods(monkeypatch):
    asked = []
    monkeypatch.setattr(
        orbits.Trace, "of", lambda period, system, turns: asked.append((period, turns)) or period
    )
    three = [Made(label="P(1;1)", turns=k, stable=True, theta=[0.1], root=None, resting=False,
                  trace=0.5, det=0.06) for k in (3, 1, 2)]  # fmt: skip
    study = Made(orbits=three, proofs=None)
    panels, (rows,) = orbits._single(study, None, ["first", "second"])
    assert asked == [("first", 3), ("second", 1)]
    assert list(panels)[:3] == ["motion", "orbit", "plane"]
    assert len(rows) == 4
    panels, _ = orbits._single(study, None, [])
    assert next(iter(panels)) == "plane"
    assert [name for name, panel in panels.items() if panel.usual] == ["plane"]


# --- styles and images


def test_a_line_of_a_style_without_a_key_is_refused_and_an_empty_one_is_not(tmp_path):
    sheet = tmp_path / "it.mplstyle"
    sheet.write_text('# a comment\n\n: 5\nfont.size: "9" # pt\nlines.color: "#112233"\n')
    assert list(style._read(str(sheet))) == [
        (3, "", "5"), (4, "font.size", "9"), (5, "lines.color", "#112233")
    ]  # fmt: skip
    with pytest.raises(SceneError):
        style._sheet(str(sheet))


def test_a_font_in_capitals_is_near_to_one_in_small_letters():
    with pytest.raises(SceneError) as refused:
        style._refuse_unknown("DEJAVU SAN")
    (fault,) = refused.value.faults
    assert fault.cure.startswith("did you mean DejaVu Sans")


def test_an_image_begins_at_the_same_place_at_every_magnification():
    """Cells from 20 to 60 pixels: with four blank ones about them from 0 to 80."""
    figure = Figure(figsize=(1.0, 1.0), dpi=100)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.2, 0.2, 0.4, 0.4))
    axes.set(xlim=(0.0, 8.0), ylim=(0.0, 8.0))
    shades = LinearSegmentedColormap.from_list("points", [(0, 0, 0, 0.5), (0, 0, 0, 1.0)])
    image = density._Points(axes, extent=(0.0, 8.0, 0.0, 8.0), origin="lower", cmap=shades,
                            norm=density._Given(0.1, 1.0, clip=True))  # fmt: skip
    image.set_data(np.ma.masked_equal(np.eye(8), 0.0))
    axes.add_image(image)
    for times in (1.0, 2.0):
        pixels, left, bottom, _ = image.make_image(None, times)
        assert (left, bottom) == (20.0, 20.0)
        assert pixels.shape == (int(40 * times), int(40 * times), 4)
        assert pixels[..., 3].max() > 200
