"""Panels of basins, maps, benches, detachment and cams, by hand: what stands where."""

from math import degrees, inf, nan, radians
from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from camcli.analysis.labels import Label
from camcli.analysis.lobe import Face
from camcli.errors import SceneError
from camcli.plots import (
    basins,
    bench,
    cam_profile,
    density,
    detach,
    mechanism,
    picture,
    style,
    sweep_map,
)
from camcli.plots.axes import _InUnit, draw_forces, per_degree_axis, strobe_axis
from camcli.plots.mechanism import Outline, Ring, _arcs, _geometry_rows, _stem_end
from camcli.plots.picture import Panel, Picture
from camcli.plots.simulate import Trace, _on_seat
from camcli.quantities import LOADS, METRES, MILLIMETRES
from camcli.scene.schema import Plot


@pytest.fixture
def axes():
    return Figure().subplots()


# --- basins


def window(share=None, branches=(3, 1), errors=0.0, **more):
    """The basins of one speed; attractor k has the branch branches[k - 1]."""
    fractions = {code: (value, errors) for code, value in (share or {}).items()}
    return Made(branches=list(branches), fractions=fractions, **more)


def test_a_share_is_that_of_the_code_of_its_branch():
    """A branch without an attractor in a window has no share there."""
    one = window({1: 0.25, 2: 0.5, 0: 0.25})
    other = window({1: 0.125}, branches=(1,))
    assert [basins._code(one, branch) for branch in (3, 1, 2)] == [1, 2, None]
    assert basins._fraction(one, 3) == 0.25
    assert basins._fraction(one, 1) == 0.5
    assert basins._shares([one, other], [1, None]) == ["25.0 %", ""]
    assert basins._shares([one, other], [2, 1]) == ["50.0 %", "12.5 %"]
    assert basins._shares([one, other], [0, 0]) == ["25.0 %", ""]
    assert basins._shares([window({1: 1 / 3}, errors=0.02)], [1]) == ["(33.33 ± 2.00) %"]
    alone, beside = ([basins._row(grids, "s", "m", "a name", ["1 %"] * len(grids))]
                     for grids in ([one], [one, other]))  # fmt: skip
    assert alone == [["s", "m", "a name", "1 %"]]
    assert beside == [["s", "m", "1 %", "1 %", "a name"]]


def test_a_saddle_counts_the_motions_of_all_windows():
    def saddle(label, led, tried):
        return Made(orbit=Made(label=label), led=led, tried=tried)

    grids = [
        Made(saddles=[saddle("P(1;1)", 3, 4), saddle("P(2;1:2)", 5, 5)]),
        Made(saddles=None),
        Made(saddles=[saddle("P(1;1)", 7, 10)]),
    ]
    ((head, first, second),) = basins._saddle_rows(grids)
    assert head == ["", "", "boundary: stable manifold of"]
    assert first[2] == "saddle P(1;1): 10 of 14 motions led to it"
    assert second[2] == "saddle P(2;1:2)"
    assert (first[0]["color"], first[1]["marker"]) == ("black", "x")
    assert basins._saddle_rows(grids[1:2]) == []


def test_an_ellipse_holds_what_its_form_says(monkeypatch):
    """A x^2 + B x y + C y^2 = 1 about each state; those from which nothing came back have none."""
    forms = [(4.0, 1.5, 9.0), (25.0, -6.0, 1.0)]
    own = Made(periodic=True, states=[(0.1, 2.0), (0.3, -1.0)])
    long = Made(periodic=True, states=[(0.1, 2.0)] * 13)
    lost = Made(periodic=True, states=[(5.0, 5.0)])
    regions = [Made(returns=True, forms=forms), None, Made(returns=True, forms=forms * 7),
               Made(returns=False, forms=forms[:1])]  # fmt: skip
    found = list(
        basins._ellipses(Made(attractors=[own, own, long, lost], regions=regions, rpm=300.0))
    )
    assert len(found) == 2
    omega = 10.0 * np.pi
    for (x, v), (a, b, c), (q, w) in zip(found, forms, own.states, strict=True):
        x, y = x - q, v / omega - w
        assert a * x * x + b * x * y + c * y * y == pytest.approx(np.ones(len(x)))
        assert np.hypot(np.diff(x), np.diff(y)).max() < 0.2  # all around
        assert (np.ptp(x) / 2.0) ** 2 == pytest.approx(c / (a * c - b * b / 4.0), rel=1e-2)


def test_the_bars_of_a_range_reach_half_way_to_the_next_value(axes):
    """The first and the last as far on either side; what no attractor takes is undecided."""
    shares = [{1: 0.25, 2: 0.5}, {1: 0.5, 2: 0.5}, {1: 0.75}]
    speeds = [
        window(share, branches=branches, value=value)
        for share, branches, value in zip(
            shares, ([3, 1], [1, 3], [3]), (600.0, 610.0, 640.0), strict=True
        )
    ]
    edges = np.array([595.0, 605.0, 625.0, 655.0])
    colours = {3: "#112233", 1: "#445566"}
    basins._draw_stack(axes, Made(speeds=speeds), edges, colours, "rpm")
    bars = [
        (round(bar.get_x(), 9), round(bar.get_width(), 9), round(bar.get_y(), 9),
         round(bar.get_height(), 9), to_hex(bar.get_facecolor()))
        for bar in axes.patches
    ]  # fmt: skip
    grey = style.UNDECIDED.lower()
    assert bars == [
        (595.0, 10.0, 0.0, 0.5, "#445566"), (605.0, 20.0, 0.0, 0.5, "#445566"),
        (625.0, 30.0, 0.0, 0.0, "#445566"),
        (595.0, 10.0, 0.5, 0.25, "#112233"), (605.0, 20.0, 0.5, 0.5, "#112233"),
        (625.0, 30.0, 0.0, 0.75, "#112233"),
        (595.0, 10.0, 0.75, 0.25, grey), (605.0, 20.0, 1.0, 0.0, grey),
        (625.0, 30.0, 0.75, 0.25, grey),
    ]  # fmt: skip
    assert (axes.get_xlim(), axes.get_ylim()) == ((595.0, 655.0), (0.0, 1.0))


def test_attractors_stand_at_the_value_and_not_at_the_speed(axes):
    """Dots of one that is not periodic are smaller, without an edge, and at most some 150."""

    def states(count, q):
        return np.column_stack([np.linspace(q, q + 1.0, count), np.zeros(count)])

    few = Made(periodic=True, states=[0] * 2, shown=lambda: states(2, 5.0))
    many = Made(periodic=False, states=[0], shown=lambda: states(450, 8.0))
    speed = Made(value=0.7, rpm=600.0, branches=[2, 1], attractors=[few, many])
    edges = np.array([0.6, 0.8])
    basins._draw_states(
        axes, Made(speeds=[speed]), edges, {1: "#112233", 2: "#445566"}, "rpm", METRES
    )
    first, second = axes.lines
    assert (list(first.get_xdata()), list(first.get_ydata())) == ([0.7, 0.7], [5.0, 6.0])
    assert len(second.get_xdata()) == 150
    assert second.get_ydata()[[0, 1, 149]] == pytest.approx(8.0 + np.array([0, 3, 447]) / 449.0)
    assert [to_hex(line.get_markerfacecolor()) for line in axes.lines] == ["#445566", "#112233"]
    assert [(line.get_markersize(), line.get_markeredgewidth()) for line in axes.lines] == [
        (3.0, 0.25), (1.6, 0.0)
    ]  # fmt: skip


def test_labels_of_a_branch_are_told_as_they_change():
    names = ["P(1;1)", "P(1;1)", "P(2;2)", "P(1;1)", "P(4;inf)"]
    assert basins._branch_labels(names) == "P(1;1), P(2;2), P(4;∞)"
    more = [*names, "aperiodic", "contact"]
    assert basins._branch_labels(more) == "P(1;1), P(2;2), P(4;∞) and 2 more labels"
    speeds = [
        Made(branches=[2, 1], attractors=[Made(label="x"), Made(label="y")]),
        Made(branches=[1], attractors=[Made(label="z")]),
    ]
    assert basins._labels(speeds) == {2: ["x"], 1: ["y", "z"]}
    assert [basins._marker(k)["marker"] for k in (1, 2, 7, 8)] == ["o", "s", "X", "o"]


def test_the_list_of_windows_names_branches_then_what_has_no_attractor():
    """Undecided first, then troubles by their codes, then the cells below the cam."""
    own = Made(periodic=True, states=[0], shown=lambda: np.array([[0.5, 0.0]]), label="P(1;1)")
    far = Made(periodic=True, states=[0], shown=lambda: np.array([[2.0, 0.0]]), label="P(2;2)")
    long = Made(periodic=False, states=[0], shown=lambda: np.array([[0.5, 0.0]]), label="aperiodic")

    limits = Made(q=(0.0, 1.0), v=(-1.0, 1.0))

    def grid(value, codes, **more):
        return window(
            value=value, rpm=60.0, window=limits, codes=np.array(codes), saddles=None, **more
        )

    grids = [
        grid(
            600.0,
            [1, 2, basins.BELOW_CODE],
            share={1: 0.5, 0: 0.25, 2: 0.125, -3: 0.125},
            attractors=[own, far],
        ),
        grid(
            610.0,
            [1, 2],
            share={1: 0.75, 2: 0.25, -2: 0.0625},
            branches=(1, 2),
            attractors=[far, long],
        ),
    ]
    labels = {3: ["P(1;1)"], 1: ["P(2;2)", "P(2;2)"], 2: ["aperiodic"]}
    colours = {3: "#333333", 1: "#111111", 2: "#222222", 0: "#000000"}
    rows = basins._attractor_rows(grids, labels, colours, "rpm")
    assert [row[2:] for row in rows] == [
        ["600 rpm", "610 rpm", "basin of"],
        ["12.5 %", "75.0 %", "P(2;2)", "attractor outside the window"],
        ["", "25.0 %", "aperiodic", ""],
        ["50.0 %", "", "P(1;1)", ""],
        ["25.0 %", "", "undecided"],
        ["", "6.25 %", basins.status_name(2)],
        ["12.5 %", "", basins.status_name(3)],
        ["", "", "none: below the cam"],
    ]
    assert [row[0]["mfc"] for row in rows[1:7]] == [
        "#111111", "#222222", "#333333", "#000000", style.TROUBLE, style.TROUBLE
    ]  # fmt: skip
    marks = [row[1] and row[1]["marker"] for row in rows[1:4]]
    assert marks == ["", "", "^"]  # dots have none, and what is outside has none
    grids[1].branches, grids[1].attractors = [3, 1], [long, far]
    row = basins._attractor_row(grids, 3, ["P(1;1)", "aperiodic"], "#333333")
    assert row[1]["marker"] == "^"  # in one of the windows it has marks
    assert row[2:] == ["50.0 %", "75.0 %", "P(1;1), aperiodic", ""]


def test_the_pale_basin_is_the_largest_of_all_windows_together(monkeypatch):
    seen = []
    monkeypatch.setattr(
        basins,
        "area_colours",
        lambda labels, largest: seen.append((labels, largest)) or ["red"] * len(labels),
    )
    for name in ("window_words", "picture_title"):
        monkeypatch.setattr(basins, name, lambda *_: "")
    monkeypatch.setattr(basins, "kind_of_cam", lambda system: "")
    monkeypatch.setattr(basins, "_attractor_rows", lambda *_: [])
    own, other = Made(label="P(1;1)"), Made(label="P(2;2)")
    grids = [
        window(
            {1: 0.6, 2: 0.4}, branches=(4, 2), value=600.0, attractors=[own, other], saddles=None
        ),
        window({1: 0.9}, branches=(2,), value=610.0, attractors=[other], saddles=None),
    ]
    drawn = basins._windows(Made(grids=grids), None, None, "rpm")
    assert seen == [(["P(2;2)", "P(1;1)"], 0)]
    assert list(drawn.panels) == ["basins 600 rpm", "basins 610 rpm"]
    assert [panel.draw.keywords["named"] for panel in drawn.panels.values()] == [
        "600 rpm",
        "610 rpm",
    ]
    assert {(panel.height, panel.across, panel.y) for panel in drawn.panels.values()} == {
        (66.0, 2, "v")
    }
    seen.clear()
    drawn = basins._windows(Made(grids=grids[:1]), None, None, "rpm")
    assert seen == [(["P(2;2)", "P(1;1)"], 1)]
    assert list(drawn.panels) == ["basins"]
    assert drawn.panels["basins"].draw.keywords["named"] == ""


def test_a_range_lists_the_largest_branches_and_its_bars_meet_half_way(monkeypatch):
    """Twelve by their shares of all windows, in the order of their numbers, then how many more."""
    for name in ("windows_words", "picture_title"):
        monkeypatch.setattr(basins, name, lambda *_: "")
    for name in ("kind_of_cam", "units_of"):
        monkeypatch.setattr(basins, name, lambda system: "")
    numbers = [*range(13, 0, -1)]

    def at(value, own, shares, troubled=()):
        attractors = [Made(label=f"P({k};{k})") for k in own]
        share = dict(enumerate(shares, 1))
        return window(
            share, own, value=value, undecided=0, troubled=troubled, attractors=attractors
        )

    speeds = [
        at(600.0, numbers, [0.02 if k == 4 else 0.01 * (k + 2) for k in numbers]),
        at(610.0, [4, 1], [0.5, 0.001]),
        at(640.0, [1], [0.002], troubled={2: 1}),
    ]
    study = Made(speeds=speeds)
    picture_of = basins._range(study, Made(window=None), None, "rpm")
    edges = picture_of.panels["fractions"].draw.keywords["edges"]
    assert edges == pytest.approx([595.0, 605.0, 625.0, 655.0])
    ((head, *rows),) = picture_of.lists
    assert head == ["", "branch of attractors"]
    assert [row[1] for row in rows] == [
        *(f"{k}: P({k};{k})" for k in range(2, 14)),
        "1 further attractor, in repeated colours",
        "undecided, or numerical trouble",
    ]
    study.speeds = speeds[:2]
    assert [code for code, _ in basins._range_entries(study)] == [*range(2, 14), -1]
    speeds[0].undecided = 1
    assert basins._range_entries(study)[-1][0] == basins.UNDECIDED_CODE
    study.speeds = speeds[1:2]
    assert [code for code, _ in basins._range_entries(study)] == [1, 4]


def test_the_boundaries_of_a_window_are_those_of_every_basin_but_the_last(axes, monkeypatch):
    """A saddle has a cross at each of its states, at the velocity there."""
    codes = []
    monkeypatch.setattr(
        axes, "contour", lambda q, v, some, *_, **__: codes.append((some * 1).tolist())
    )
    grid = Made(nq=3, nv=2, q_of=lambda k: 10.0 * k, v_of=lambda k: 100.0 * k)
    saddle = Made(orbit=Made(states=[(0.1, 0.5), (0.2, -0.25)]))
    one = Made(window=grid, codes=np.array([[1, 2, 0], [3, 1, -1]]), attractors=[1, 2, 3],
               saddles=[saddle], rpm=300.0)  # fmt: skip
    basins._draw_boundary(axes, one)
    assert len(codes) == 2
    assert codes[0][1][1] == 1
    assert codes[0][0][:2] == [1, 0]
    (cross,) = axes.lines
    assert list(cross.get_xdata()) == [0.1, 0.2]
    assert cross.get_ydata() == pytest.approx([5.0 * np.pi, -2.5 * np.pi])


# --- maps


def test_cells_reach_half_a_step_beyond_the_first_and_last_value():
    for values, wanted in (
        ([700.0, 600.0, 640.0], (575.0, 725.0)),
        ([-5.0], (-5.05, -4.95)),
        ([0.0], (-1e-6, 1e-6)),
    ):
        assert sweep_map.cell_edges(values) == pytest.approx(wanted)


def test_exponents_of_a_map_are_white_at_zero_and_what_has_none_is_grey(axes):
    found = Made(first=[2.0, 1.0, 3.0], second=[20.0, 10.0])
    values = np.array([[0.25, -0.5, nan], [0.125, 0.0, 0.375]])
    sweep_map._draw_values(found, values, "exponent", True, axes)
    (image,) = axes.images
    assert image.get_clim() == (-0.5, 0.5)
    shown = image.get_array()
    assert shown.filled(9.0).tolist() == [[0.0, 0.125, 0.375], [-0.5, 0.25, 9.0]]
    assert image.get_extent() == [0.5, 3.5, 5.0, 25.0]
    assert [line.get_label() for line in axes.lines] == ["no value"]
    assert to_hex(axes.get_facecolor()).upper() == axes.lines[0].get_color() == style.BLANK
    red, _, blue, _ = image.cmap(1.0)
    assert red > blue  # of what grows
    other = Figure().subplots()
    sweep_map._draw_values(found, np.abs(np.nan_to_num(values, nan=2.0)), "loft", False, other)
    assert other.images[0].get_clim() == (0.0, 2.0)
    assert not other.lines
    last = Figure().subplots()
    sweep_map._draw_values(found, np.full((2, 3), nan), "loft", False, last)
    assert last.get_title() == "loft"
    assert last.texts[0].get_text() == "no value at any of these points"


# --- the bench


def test_a_difference_is_a_share_of_what_was_published():
    row = Made(published="-4.0", ours=-4.5, independent="-4.25")
    assert bench._share(-0.5, row) == 0.125
    assert bench._share(0.0, row) == 1e-17
    assert bench._share(2.0, Made(published="0")) == 2.0 / 1e-300
    assert bench._off(row) == -0.25


def test_the_axes_of_a_bench_hold_the_points_of_all_cases(axes):
    points = [Made(seconds=t, error=e) for t, e in ((2e-3, 1e-9), (0.5, 0.0), (4e-2, 7.0))]
    bench._ranges(axes, points)
    assert axes.get_xlim() == pytest.approx((1e-3, 1.0))
    assert axes.get_ylim() == pytest.approx((0.25e-17, 21.0))
    bench._ranges(axes, points[:1])
    assert axes.get_ylim() == pytest.approx((0.25e-9, 3.0))  # a turn at least
    bench._ranges(axes, [])
    assert axes.get_xlim() == pytest.approx((0.5e-4, 2.0))
    assert bench._times_and_errors(points[1:]) == ([0.5, 4e-2], [1e-17, 7.0])


def test_a_long_name_of_a_case_takes_two_lines_on_a_narrow_page():
    name = "restitution 1 +- 1e-9 and x^n over a turn"
    assert bench._case_name(name, False) == "restitution 1 ± 1e-9 and xⁿ over a turn"
    assert bench._case_name(name, True).split("\n") == [
        "restitution 1 ± 1e-9",
        "and xⁿ over a turn",
    ]
    assert bench._case_name("r +- 1", True) == "r ± 1"


# --- detachment


def test_shares_of_the_variance_stand_with_the_largest_at_the_top(axes):
    shares = {"follower.mass": 0.6, "table_error": 0.3, "cam.base": 0.1}
    spread = Made(
        shares=shares, numbers={"follower.mass": -5.0, "table_error": 2.5, "cam.base": 1.0}
    )
    detach._draw_shares(axes, spread)
    assert [bar.get_width() for bar in axes.patches] == pytest.approx([10.0, 30.0, 60.0])
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names[1] == "error of the table\nworst +2.5 %"
    assert names[2].endswith("\nworst −5 %")
    assert axes.get_xlim() == (0.0, 100.0)
    assert axes.get_xlabel() == "share of the variance (%)"


def test_the_spread_of_machines_names_half_the_nominal_and_the_worst(axes):
    """Those that hold at any speed are not counted."""
    spread = Made(speeds=[5000.0, 5200.0, inf, 5900.0, 5100.0], worst=4700.0)
    detach._draw_machines(axes, spread, 5300.0)
    lines = {line.get_label(): line.get_xdata()[0] for line in axes.lines}
    assert lines == {
        "half of the machines": 5150.0, "the machine as given": 5300.0, "the worst machine": 4700.0
    }  # fmt: skip
    assert sum(bar.get_height() for bar in axes.patches) == 4
    for machines, worst, nominal in (([inf], 4700.0, 1.0), ([5000.0], inf, 1.0)):
        other = Figure().subplots()
        detach._draw_machines(other, Made(speeds=machines, worst=worst), nominal)
        assert other.texts[0].get_text() == "contact is never lost"
    for nominal in (None, inf):
        other = Figure().subplots()
        detach._draw_machines(other, spread, nominal)
        assert "the machine as given" not in [line.get_label() for line in other.lines]


def test_loads_of_a_report_begin_where_contact_is_lost_in_the_units_of_the_machine(monkeypatch):
    """A valve lands on its seat below that speed too: its loads begin with the first motion."""
    drawn = {name: Panel(len) for name in ("forces", "springs", "surge", "machines", "shares")}
    monkeypatch.setattr(detach, "draw_detach", lambda *_: Picture("", drawn))
    monkeypatch.setattr(detach, "machine_panels", lambda *_: {"outline": Panel(len, usual=False)})
    monkeypatch.setattr(detach, "units_of", lambda system: MILLIMETRES)
    loads = [Made(max_gap_m=gap, max_impact_m_per_s=u) for gap, u in ((2e-3, 0.5), (None, 0.75))]
    past = [Made(rpm=rpm, loads=own) for rpm, own in zip((610.0, 620.0), loads, strict=True)]
    first = Made(rpm=605.0)
    study = Made(detachment=Made(first=first), forces=[1, 2], springs=[1, 2, 3])

    def points(seat, past=past):
        panels = detach.report_panels(study, Made(has_seat=seat), None, past)
        names = "max_gap_m", "max_impact_m_per_s"
        return panels, [panels[name].draw.keywords["points"] for name in names]

    panels, (gaps, velocities) = points(seat=False)
    unit, scale = MILLIMETRES.shown(LOADS["max_impact_m_per_s"].unit)
    assert gaps == [(605.0, 0.0), (610.0, 2.0), (620.0, 0.0)]
    assert velocities == [(605.0, 0.0), (610.0, 0.5 * scale), (620.0, 0.75 * scale)]
    assert panels["max_gap_m"].draw.keywords["said"].endswith("(mm)")
    assert panels["max_impact_m_per_s"].draw.keywords["said"].endswith(f"({unit})")
    assert points(seat=True)[1][0] == gaps[1:]
    assert points(seat=False, past=[])[1] == [[], []]
    above = {name: panel.above for name, panel in panels.items() if panel.above}
    assert above == {"forces": pytest.approx(10.8), "springs": pytest.approx(14.2)}
    assert list(panels)[:2] == ["outline", "forces"]
    assert {panel.across for panel in panels.values()} == {2}
    assert (panels["outline"].usual, panels["outline"].height) == (True, 50.0)


def test_the_axis_of_phases_begins_where_most_chatters_that_reach_a_corner_do():
    first = Made(region="A2")
    losses = [Made(region=Made(name=name)) for name in ("A1", "A2", "A4")]
    study = Made(detachment=Made(first=first, losses=losses), accumulation=[])
    assert detach._leading(study) is losses[1]
    study.accumulation = [Made(burst=name) for name in ("A2", "A4", "A4")]
    assert detach._leading(study) is losses[2]
    study.detachment.first = None
    assert detach._leading(study) is None


def test_forces_and_springs_stand_abreast_where_more_follows(monkeypatch):
    """Legends above them have the room that their names take."""
    whole = detach._View(0.0, 360.0, 0.0, (500.0, 600.0))
    monkeypatch.setattr(detach, "_views", lambda study: [whole])
    monkeypatch.setattr(detach, "_without_empty", lambda view, study, system: view)
    for name in ("is_measured", "units_of"):
        monkeypatch.setattr(detach, name, lambda system: None)
    for name in ("force_name", "spring_name", "picture_title", "first_loss"):
        monkeypatch.setattr(detach, name, lambda *_: "")
    surge, spread = Made(), Made()
    curve = Made(rpm=600.0)

    def drawn(forces, springs, *more, seat=False):
        study = Made(forces=[curve] * forces, springs=[(None, curve)] * springs,
                     detachment=Made(first=Made(rpm=550.0)))  # fmt: skip
        found = detach.draw_detach(study, Made(corners=[], has_seat=seat), *more)
        panels = {name: (one.across, round(one.above, 6)) for name, one in found.panels.items()}
        del panels["phases"]
        return panels, found.caption

    assert drawn(2, 3)[0] == {"forces": (1, 0.0), "springs": (1, 0.0)}
    assert drawn(2, 3, surge)[0] == {"forces": (2, 10.8), "springs": (2, 14.2), "surge": (1, 0.0)}
    assert drawn(2, 0, surge)[0] == {"forces": (1, 0.0), "surge": (1, 0.0)}
    assert drawn(0, 1, None, spread)[0] == {
        "springs": (1, 0.0), "machines": (2, 0.0), "shares": (2, 0.0)
    }  # fmt: skip
    assert drawn(0, 0, surge, spread)[0] == {
        "surge": (3, 0.0), "machines": (3, 0.0), "shares": (3, 0.0)
    }  # fmt: skip
    captions = [
        drawn(0, 0, *more, seat=seat)[1] for more in ((), (surge,)) for seat in (False, True)
    ]
    assert [("Crosses" in words, "simulated" in words) for words in captions] == [
        (False, False), (True, False), (False, True), (True, True)
    ]  # fmt: skip


# --- cams


def test_the_outline_is_known_beyond_the_turn_and_the_rim_of_a_lobe_in_every_direction():
    theta = np.array([0.0, 1.0, 2.0, 4.0, 2.0 * np.pi])
    radius, corners = np.array([3.0, 5.0, 4.0, 3.5, 3.0]), {"b": 100.0, "c": 250.0, "a": 30.0}
    own = Outline(theta, radius, corners, [], False, False, METRES, True)
    assert own.at(degrees(1.5)) == pytest.approx(4.5)
    assert own.at(360.0 + degrees(0.5)) == pytest.approx(4.0)
    assert own.at(degrees(3.0) - 720.0) == pytest.approx(3.75)
    assert own.rim(degrees(0.5)) == own.at(degrees(0.5))
    assert own.touched(degrees(1.5)) == (degrees(1.5), pytest.approx(4.5))
    assert own.place(90.0, 2.0, 60.0) == pytest.approx((1.0, 3.0**0.5))
    assert _arcs(own) == [(100.0, 250.0), (250.0, 390.0), (30.0, 100.0)]
    touches = [
        Made(theta=radians(phase), place=(r * np.sin(at), r * np.cos(at)), direction=at,
             along=r * 0.6, beside=-r * 0.8)
        for phase, at, r in ((10.0, 0.1, 2.0), (120.0, 1.6, 3.0), (250.0, -1.5, 4.0))
    ]  # fmt: skip
    lobe = Made(touches=touches)
    own = Outline(theta, own.radius, {}, [], False, False, METRES, True, lobe=lobe)
    assert own.touched(200.0) == (pytest.approx(degrees(-1.5)), pytest.approx(4.0))
    assert own.touched(20.0) == (pytest.approx(degrees(0.1)), pytest.approx(2.0))
    assert own.rim(degrees(0.85)) == pytest.approx(2.5)
    between = 2.0 * np.pi - 1.5 - 1.6  # behind the axis, from the second to the third
    assert own.rim(180.0) == pytest.approx(3.0 + (np.pi - 1.6) / between)


def test_an_outline_is_on_the_cams_side_of_a_rocker(monkeypatch):
    """Its radius is the base radius and the lift above the lowest; behind its lash it is lower."""
    shape = np.linspace(0.0, 1.0, len(mechanism.TURN))
    lifts = {"runs on": 0.002 + 0.006 * shape, "drawn": 0.001 + 0.008 * shape, "flat": 0.0 * shape}
    monkeypatch.setattr(mechanism, "lift", lambda cam, theta: (lifts[cam], None, None))
    monkeypatch.setattr(mechanism, "units_of", lambda system: MILLIMETRES)
    machine = Made(cam="runs on", rocker_ratio=2.0, lash=0.0005, corners=[2.0, 1.0],
                   follower=Made(stiffness=3.0), as_drawn=Made(cam="drawn"))  # fmt: skip
    own = Outline.of_lift(machine, 0.02)
    assert own.radius == pytest.approx(0.02 + 0.003 * shape)
    assert own.zero == pytest.approx(0.019)
    assert own.lowered == pytest.approx(0.019 + (0.0005 + 0.008 * shape) / 2.0)
    assert (own.lash, own.ratio, own.guessed, own.sprung) == (0.00025, 2.0, False, True)
    assert own.rings[0].radius == pytest.approx(0.02)
    assert list(own.corners.values()) == pytest.approx([degrees(1.0), degrees(2.0)])
    guessed = Outline.of_lift(machine, None)
    assert guessed.guessed
    assert guessed.radius.min() == pytest.approx(0.0045)  # 1.5 lifts of the lobe
    machine.cam, machine.lash, machine.follower.stiffness = "flat", 0.0, 0.0
    flat = Outline.of_lift(machine, None)
    assert flat.radius.min() == pytest.approx(1.5e-9)
    assert (flat.lowered, flat.sprung) == (None, False)
    machine.cam = "runs on"
    lobe = Made(base=0.02, roller=0.004, face=Face.ROLLER)
    rolled = Outline.of_lobe(machine, lobe)
    assert rolled.radius == pytest.approx(0.024 + 0.003 * shape)
    assert (rolled.rings[0].radius, rolled.flat, rolled.ratio) == (0.02, False, 2.0)
    assert Outline.of_lobe(machine, Made(base=0.02, roller=0.0, face=Face.FLAT)).flat


def test_circles_of_arcs_stand_in_the_directions_of_their_centres():
    cam = Made(top_dwell_deg=40.0, flank_center=0.05, flank_radius=0.08, nose_center=0.02,
               nose_radius=0.01)  # fmt: skip
    top, flank, nose = mechanism._circles_of_arcs(
        cam, Made(as_drawn=Made(corners=[radians(x) for x in (250.0, 110.0, 150.0)])), 0.04
    )
    assert (top.centre, top.distance, top.radius) == ("O", 0.0, 0.04)
    assert (flank.centre, flank.distance, flank.direction, flank.radius) == (
        "O₁", 0.05, pytest.approx(-70.0), 0.08
    )  # fmt: skip
    assert (nose.centre, nose.distance, nose.direction, nose.radius) == ("O₂", 0.02, 160.0, 0.01)


def test_the_lengths_beside_a_drawing_are_named_by_their_symbols():
    rings = [
        Ring("O", 0.0, 0.0, 0.020012345, "rho_0", "base circle"),
        Ring("O", 0.0, 0.0, 0.030023456, "rho_3", "top"),
        Ring("O₁", 0.051034567, -70.0, 0.080045678, "rho_1", "flanks"),
        Ring("O₂", 0.012056789, 160.0, 0.014062345, "rho_2", "nose"),
    ]
    corners = dict(zip("abcdef", (110.0, 140.0, 165.0, 195.0, 220.0, 250.0), strict=True))
    own = Made(rings=rings, units=MILLIMETRES, guessed=False, corners=corners)
    assert _geometry_rows(own) == [
        ("rho_0", "20.01 mm", "base circle, A6, around O"), ("rho_1", "80.05 mm", "flanks A1, A5"),
        (r"$\kappa_1$", "51.03 mm", "from O to O₁"), ("rho_2", "14.06 mm", "nose A2, A4"),
        (r"$\kappa_2$", "12.06 mm", "from O to O₂"),
        ("rho_3", "30.02 mm", "top dwell A3, around O"),
        (r"$\theta_1$", r"30$\degree$", "of A1, A5, at O"),
        (r"$\theta_2$", r"25$\degree$", "of A2, A4, at O"),
        (r"$\theta_3$", r"30$\degree$", "of A3, at O"),
    ]  # fmt: skip
    own.rings, own.guessed = rings[:1], True
    assert _geometry_rows(own) == [("rho_0", "1.5 lifts", "base circle, around O; not given")]


def test_a_gap_by_lash_is_drawn_as_wide_as_can_be_seen_but_not_beyond_half_the_base():
    theta = np.linspace(0.0, 2.0 * np.pi, 5)
    radius = np.array([0.02, 0.03, 0.05, 0.03, 0.02])
    rings = [Ring("O", 0.0, 0.0, 0.02, "r", "base circle")]

    def over(lash, base, ratio=2.0):
        own = Outline(theta, radius, {}, rings, False, False, METRES, True, ratio=ratio,
                      lobe=Made(base=base))  # fmt: skip
        return own.over_lash(lash, lambda below: Made(base=base - below)), own

    seen, _ = over(0.0002, 0.02)
    assert (seen.lash, seen.widened) == pytest.approx((0.0001, 40.0))
    assert (seen.lobe.base, seen.rings[0].radius) == pytest.approx((0.016, 0.016))
    seen, _ = over(0.0002, 0.006)
    assert (seen.widened, seen.lobe.base) == pytest.approx((30.0, 0.003))
    seen, _ = over(0.012, 0.02)
    assert (seen.lash, seen.widened, seen.lobe.base) == pytest.approx((0.006, 1.0, 0.014))
    seen, own = over(0.0, 0.02)
    assert seen is own


def test_the_stem_ends_between_the_tip_and_the_frame():
    own = Made(radius=np.array([0.6, 1.0]))
    assert _stem_end(own, 0.7, 2.15) == pytest.approx(1.5 + 0.0999)
    assert _stem_end(own, 0.6, 1.5) == pytest.approx(1.32)
    low = Made(radius=np.array([1.9, 2.0]))
    assert _stem_end(low, 2.9, 4.3) == pytest.approx(4.3 - 0.36)
    assert _stem_end(Made(radius=np.array([0.1, 1.0])), 1.4, 9.0) == pytest.approx(
        1.5 + 1.3 * 0.999
    )


def test_a_band_about_a_measured_cam_has_the_bound_of_each_share_of_the_turn(axes):
    profile = Made(theta=np.radians([0.0, 119.0, 121.0, 300.0, 360.0]))
    cam_profile._doubt(axes, profile, [1.0, 2.0, 3.0, 4.0, 5.0], [0.1, 0.2, 0.4], "bound")
    (band,) = axes.collections
    assert band.get_label() == "bound"
    corners = {(round(x), round(y, 6)) for x, y in band.get_paths()[0].vertices}
    for x, low, high in (
        (0, 0.9, 1.1),
        (119, 1.9, 2.1),
        (121, 2.8, 3.2),
        (300, 3.6, 4.4),
        (360, 4.6, 5.4),
    ):
        assert {(x, low), (x, high)} <= corners


def test_radii_beyond_ten_of_the_base_circle_are_as_good_as_straight(axes, monkeypatch):
    monkeypatch.setattr(cam_profile, "radius_title", lambda lobe, units: "title")
    touches = [Made(radius=x) for x in (0.2, -0.3, 0.299, -0.299, 0.31)]
    drawn = Made(
        profile=Made(theta=np.radians([0.0, 90.0, 180.0, 270.0, 360.0]),
                     lobe=Made(base=0.03, undercut=False, touches=touches)),
        units=METRES,
    )  # fmt: skip
    cam_profile._draw_radius(axes, drawn)
    shown = axes.lines[-1].get_ydata()
    assert shown == pytest.approx([0.2, nan, 0.299, -0.299, nan], nan_ok=True)
    assert axes.lines[-1].get_color() == style.CAM
    drawn.profile.lobe.undercut = True
    cam_profile._draw_radius(axes, drawn)
    assert axes.lines[-1].get_color() == axes.title.get_color() == style.TROUBLE


# --- axes


def test_the_axis_of_positions_names_the_phase_where_it_is_not_zero(axes):
    class Machine:
        strobe = radians(37.5)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("camcli.plots.axes.units_of", lambda system: MILLIMETRES)
        strobe_axis(axes.yaxis, Machine(), ", enlarged")
        assert axes.get_ylabel() == r"stroboscopic $q$ (mm), $\theta$ = 37.5 deg, enlarged"
        strobe_axis(axes.yaxis, Made(strobe=0.0), ", enlarged")
        assert axes.get_ylabel() == "stroboscopic $q$ (mm), enlarged"


@pytest.mark.parametrize(("panel", "order"), [("velocity", 1), ("acceleration", 2), ("jerk", 3)])
def test_the_axis_at_the_right_counts_millimetres_and_degrees(axes, panel, order):
    axes.set_ylim(0.0, 0.5)
    per_degree_axis(axes, panel)
    (right,) = axes.child_axes
    right._set_lims()
    assert right.get_ylim()[1] == pytest.approx(500.0 * (np.pi / 180.0) ** order)


def test_contact_forces_are_darker_and_then_dashed(axes):
    """Of one curve alone the second colour; below zero is shaded where any of them pulls."""
    curves = [Made(theta=[0.0, 1.0], force_n=[k, k + 1.0]) for k in range(1, 13)]
    draw_forces(axes, curves, [f"curve {k}" for k in range(12)])
    lines = axes.lines[:12]
    assert [line.get_color() for line in lines] == [*style.FORCES, *style.FORCES, *style.FORCES[:2]]
    dashes = [line._unscaled_dash_pattern[1] for line in lines]
    assert [None if one is None else list(one) for one in dashes] == (
        [None] * 5 + [[5, 1.5]] * 5 + [[1.5, 1]] * 2
    )
    assert [line.get_label() for line in lines] == [f"curve {k}" for k in range(12)]
    assert not axes.patches
    other = Figure().subplots()
    draw_forces(other, [curves[0], Made(theta=[0.0, 1.0], force_n=[-1.0, 5.0])])
    assert len(other.patches) == 1
    alone = Figure().subplots()
    draw_forces(alone, curves[:1])
    assert alone.lines[0].get_color() == style.FORCES[1]


def test_numbers_of_an_axis_have_no_minus_before_a_zero():
    numbers = _InUnit(1e-3)
    numbers.set_locs([-2e-3, -1e-16, 0.0, 2.5e-3])
    assert [numbers(x) for x in (-2e-3, -1e-16, 0.0, 2.5e-3)] == ["−2.0", "0.0", "0.0", "2.5"]


# --- simulations


def test_a_state_holds_from_a_point_to_the_next():
    state = np.array([False, True, False, False, True, True])
    shown = Trace.during(None, np.arange(6.0), state)
    assert shown == pytest.approx([nan, 1.0, 2.0, nan, 4.0, 5.0], nan_ok=True)


def test_a_follower_is_on_its_seat_in_the_stretches_of_the_seat(monkeypatch):
    columns = {"start": [0.0, 1.0, 2.0, 5.0], "seat": [1.0, 0.0, 0.0, 1.0]}
    monkeypatch.setattr("camcli.plots.simulate.column", lambda cam, name: columns[name])
    at = np.degrees([0.0, 0.5, 1.0, 1.5, 4.9, 5.0, 6.0]) + 720.0
    found = _on_seat(Made(cam=None), at + 1e-9)
    assert list(found) == [True, True, False, False, False, True, True]


# --- the page


def test_a_picture_has_the_panels_that_are_asked_for_and_says_which_have_no_room():
    names = ["phases", "event 3", "event 12", "events", "event"]
    panels = {name: Panel(len, usual=name != "events") for name in names}
    one = Picture("title", panels, caption="first words")
    assert list(one.chosen(["event"])) == ["event 3", "event 12", "event"]
    assert list(one.chosen(["events", "phases"])) == ["events", "phases"]
    assert list(one.chosen(["nothing"])) == ["phases", "event 3", "event 12", "event"]
    assert one.lacking(["event", "phase", "even", "events"]) == ["phase", "even"]
    assert one.lacking(None) == []
    assert one._caption([]) == "First words."
    both = one._caption(["phases"])
    assert both.startswith("First words. ")
    assert both.endswith(".")
    assert "phases" in both
    assert Picture("title", panels)._caption([]) == ""


def test_letters_are_shared_by_a_column_and_rows_are_as_high_as_their_highest_panel():
    panels = [Panel(len, 30.0, column=name) for name in ("left", "right", "left", "", "right", "")]
    assert picture._letters(panels) == ["(a)", "(b)", "(a)", "(c)", "(b)", "(d)"]
    rows = [
        [("x", Panel(len, 30.0, above=2.0)), ("y", Panel(len, 45.0, above=7.0, shape=0.4))],
        [("z", Panel(len, 50.0, x="speed", above=1.0))],
        [("w", Panel(len, 20.0, x="speed"))],
    ]
    page = Made(width=100.0)
    assert picture._above(rows) == 8.0
    assert picture._height(rows, page) == 100.0  # 30, as 20 is all the shape allows; 50; 20
    assert picture._shared(rows) == [False, True]
    assert picture._least(rows, page) == pytest.approx(65.0 + 8.0 + 22.0 + 5.0)
    asked = [("asked", Panel(len, asked=True))]
    assert picture._least_asked([rows[0], rows[1], asked]) is rows[1]
    assert picture._least_asked([rows[0], asked]) is asked


def test_one_panel_has_room_where_it_is_as_high_as_it_must_be():
    """At 0.65 of 200 mm and 11 mm below, with 2 mm above."""
    one = Picture("T", {"a": Panel(lambda axes: None, 200.0)})
    for height, has_room in ((143.5, True), (142.5, False)):
        page = one.figure(Plot(title=False, height=height))
        assert (page.has_room, list(page.left_out)) == (has_room, [])


def test_words_below_a_title_have_room_below_them_only_where_a_list_follows():
    panels = {"a": Panel(lambda axes: None, 40.0)}
    for lists, more in (([], 0.0), ([[["list"], ["row"]]], 2.0 + 2 * 3.4)):
        page = Picture("T", panels, words="words", lists=lists).figure(Plot())
        assert page.get_figheight() * 25.4 == pytest.approx(2.0 + 5.07 + 3.9 + 40.0 + 13.0 + more)


def test_words_about_a_panel_of_equal_axes_may_stand_a_pixel_out_of_its_place():
    engine = Made(get=lambda: {"rect": (0.0, 0.1, 1.0, 0.7)})  # of 1000 pixels: from 100 to 800
    for aspect, low, high, out in (
        (1.0, 99.5, 800.5, False), (1.0, 98.5, 700.0, True), (1.0, 200.0, 801.5, True),
        ("auto", 50.0, 900.0, False),
    ):  # fmt: skip
        box = Made(y0=low, y1=high)
        own = Made(get_aspect=lambda aspect=aspect: aspect, get_tightbbox=lambda box=box: box)
        page = Made(bbox=Made(height=1000.0), axes=[own])
        assert picture._Layout._is_outgrown(engine, page) == out


def test_the_longest_list_is_cut_and_others_stand_in_pairs_wherever_they_are():
    marks = [["", "marks"], *(["", "m" * k] for k in range(1, 5))]
    long = [["", "event", "at"], *(["", f"event {k}", f"{k}"] for k in range(20))]
    for lists in ([marks, long], [long, marks]):
        shown = picture._Heading._listed(Made(wide=90.0, top=2.0), lists, 120.0)
        assert [len(rows) for rows in shown] == [3 if rows is marks else 11 for rows in lists]
        (cut,) = [rows for rows in shown if len(rows) == 11]
        assert cut[-1] == ["", "and 11 more, in the tables"]


def test_a_title_too_wide_for_its_panel_is_broken_unless_it_is_a_formula():
    """Into lines of twelve letters at least; a line that was left free below it stays free."""
    for words, wanted in (
        ("some words of a title", "some words\nof a title"),
        ("some words of a title\n", "some words\nof a title\n"),
        ("some $words$ of a title", "some $words$ of a title"),
        ("short", "short"),
    ):
        own = Figure(figsize=(0.9, 1.0), dpi=100).add_axes((0.1, 0.1, 0.8, 0.8))
        own.set_title(words, loc="right", size=8)
        picture._fold_title(own)
        assert own.get_title(loc="right") == wanted


def test_cells_two_by_two_are_as_full_as_the_fullest():
    shares = np.ma.masked_equal([[0.0, 2.0, 3.0], [1.0, 0.0, 0.0], [4.0, 0.0, 0.0]], 0.0)
    cells, ends = density.pooled(shares, (10.0, 16.0, 1.0, 4.0))
    assert cells.filled(0.0).tolist() == [[2.0, 3.0], [4.0, 0.0]]
    assert ends == (10.0, 18.0, 1.0, 5.0)
    assert density._nearest(np.array([1.0, 4.0, 6.0, 11.0])) == pytest.approx([3.0, 2.0, 2.0, 5.0])
    rising = np.array([0.0, 7.0, 8.0, 10.0, 13.0, 14.0, 16.0])
    assert density._widest(rising) == pytest.approx([7.0, 7.0, 7.0, 3.0, 3.0, 3.0, 2.0])
    raised = density._raised(np.array([[5.0, 0.0, 0.0, 1.0, 0.0, 0.0]]), 5)
    assert raised.tolist() == [[5.0, 5.0, 5.0, 1.0, 1.0, 1.0]]


def test_styles_say_how_many_dots_an_inch_has_and_fonts_have_one_that_is_always_there(tmp_path):
    sheet = tmp_path / "own.mplstyle"
    for lines, wanted in (
        ("figure.dpi: 77\nsavefig.dpi: figure\n", 77.0),
        ("figure.dpi: 77\nsavefig.dpi: 120\n", 120.0),
    ):
        sheet.write_text(lines)
        assert style.dpi_of(str(sheet)) == wanted
    assert style.dpi_of(None) == 300.0
    settings = style._ours("DejaVu Serif", {"font.family": ["serif"], "lines.linewidth": 7.0})
    assert settings["font.family"] == ["DejaVu Serif", "DejaVu Sans"]
    assert settings["lines.linewidth"] == 7.0
    assert [settings[f"mathtext.{kind}"] for kind in ("fontset", "rm", "it", "cal")] == [
        "custom", "DejaVu Serif", "DejaVu Serif:italic", "DejaVu Serif"
    ]  # fmt: skip


def test_a_font_is_named_by_those_that_are_most_like_it_in_whatever_letters():
    for wrong, right, others in (
        ("stixgeneral", "STIXGeneral", 0),
        ("dejavu san", "DejaVu Sans", 2),
    ):
        with pytest.raises(SceneError) as refused:
            style._refuse_unknown(wrong)
        (fault,) = refused.value.faults
        first, *more = fault.cure.removeprefix("did you mean ").removesuffix("?").split(" or ")
        assert first == right
        assert len(more) >= others
    style._refuse_unknown("STIXGeneral")


def test_a_number_too_large_for_a_style_is_told_with_what_it_may_be(tmp_path):
    sheet = tmp_path / "own.mplstyle"
    for line, most in (("agg.path.chunksize: 2000000", "1e+06"), ("lines.linewidth: 1001", "1000")):
        sheet.write_text(f"font.size: 7\n\n{line}\n")
        with pytest.raises(SceneError) as refused:
            style._sheet(str(sheet))
        (fault,) = refused.value.faults
        assert fault.expected == f"expected finite numbers of at most {most}"
        assert fault.where == f"{sheet}:3"


def test_numbers_of_a_style_have_limits_on_both_sides():
    for key, value, taken in (
        ("lines.linewidth", 1000.0, True), ("lines.linewidth", 1001.0, False),
        ("xtick.major.pad", -1000.0, True), ("xtick.major.pad", -1001.0, False),
        ("agg.path.chunksize", 1_000_000, True), ("agg.path.chunksize", 1_000_001, False),
        ("figure.dpi", 20.0, True), ("figure.dpi", 19.9, False), ("savefig.dpi", 1200.0, True),
        ("savefig.dpi", 1201.0, False), ("figure.figsize", [5.0, 2000.0], False),
        ("text.usetex", True, True), ("lines.linestyle", "--", True),
    ):  # fmt: skip
        assert style._within(key, value) == taken, (key, value)


def test_corners_are_named_in_the_order_of_their_phases():
    assert style.corner_names([3.0, 1.0, 2.0]) == {
        "a": pytest.approx(degrees(1.0)), "b": pytest.approx(degrees(2.0)),
        "c": pytest.approx(degrees(3.0)),
    }  # fmt: skip
    assert len(style.corner_names(range(26))) == 26
    assert style.corner_names(range(27)) == {}
    assert style.kind_of_label(Label((1.0, inf))) == "with rests"
    assert style.kind_of_label(Label((1.0, 2.0, 3.0, 4.0))) == "period 4"
    assert style.kind_of_label(Label((1.0, 2.0, 3.0, 4.0, 5.0))) == "longer periods"
    five = style.apart(["#000000"] * 5)
    assert five == ["#000000", "#737373", "#000000", "#B2B2B2", "#000000"]
    reds = style.apart(
        ["#FF0000", "#00FF00", "#FF0000", "#FF0000", "#FF0000", "#FF0000", "#FF0000"]
    )
    assert reds == ["#FF0000", "#00FF00", "#FF7373", "#8C0000", "#FFB2B2", "#CC0000", "#FF0000"]


def test_loads_over_speed_begin_at_zero_and_other_chatters_end_in_crosses(axes):
    detach._draw_load(axes, [(600.0, 0.0), (610.0, 2.5), (620.0, 1.0)], "loft (mm)")
    assert axes.lines[0].get_xydata().tolist() == [[600.0, 0.0], [610.0, 2.5], [620.0, 1.0]]
    assert (axes.get_ylabel(), axes.get_ylim()[0]) == ("loft (mm)", 0.0)
    other = Figure().subplots()
    detach._draw_load(other, [], "loft (mm)")
    assert other.texts[0].get_text() == "contact holds over the whole range"
    last = Figure().subplots()
    rests = ([radians(10.0), radians(300.0)], [], [radians(200.0)])
    speeds = [Made(rpm=600.0 + k, other_rests=own) for k, own in enumerate(rests)]
    view = detach._View(90.0, 450.0, 100.0, (500.0, 700.0))
    detach._draw_other_ends(last, view, Made(speeds=speeds))
    (crosses,) = last.lines
    assert crosses.get_xydata().tolist() == [
        [600.0, pytest.approx(370.0)], [600.0, pytest.approx(300.0)], [602.0, pytest.approx(200.0)]
    ]  # fmt: skip
    assert (crosses.get_marker(), crosses.get_linestyle()) == ("x", "None")
    detach._draw_other_ends(last, view, Made(speeds=speeds[1:2]))
    assert len(last.lines) == 1


@pytest.mark.parametrize(("theta_deg", "drawn"), [(30.0, 390.0), (200.0, 200.0), (90.0, 450.0)])
def test_impacts_and_the_first_detachment_stand_above_the_fold(monkeypatch, theta_deg, drawn):
    """A panel that begins at 100 deg shows 30 deg of the next turn, for points and for the mark."""
    for name in ("_phase_axes", "_draw_ends", "_draw_critical_ends", "_draw_hits", "_draw_proved"):
        monkeypatch.setattr(detach, name, lambda *_: None)
    marks = []
    monkeypatch.setattr(
        detach, "mark", lambda axes, kind, x, y, **_: marks.append((kind, x, list(y)))
    )
    first = Made(rpm=612.0, theta=radians(theta_deg))
    speeds = [Made(rpm=600.0, impacts=[radians(theta_deg), radians(150.0)]),
              Made(rpm=650.0, impacts=[radians(40.0)])]  # fmt: skip
    study = Made(speeds=speeds, detachment=Made(first=first))
    axes = Figure().add_subplot()
    view = detach._View(90.0, 460.0, 100.0, (500.0, 700.0))
    detach._draw_phases(axes, view, study, {}, False, ())
    assert marks == [("detachment", [612.0], [pytest.approx(drawn)])]
    (points,) = axes.lines
    assert points.get_xdata().tolist() == [600.0, 600.0, 650.0]
    assert points.get_ydata() == pytest.approx([drawn, 150.0, 400.0])


@pytest.mark.parametrize("undercut", [True, False])
@pytest.mark.parametrize("base", [None, 0.02])
def test_a_flat_face_and_a_knife_see_curves_of_their_own(undercut, base):
    """An undercut one is a warning; radii begin at the axis where the base circle is known."""
    bent = Made(undercut=undercut, base_radius=base, flat=[0.01, 0.03], knife=[5.0, 7.0],
                least_base_radius=0.005, roller=None)  # fmt: skip
    drawn = Made(profile=Made(theta=[0.0, 1.0], curvature=bent), units=METRES)
    cam_profile._draw_flat(axes := Figure().subplots(), drawn)
    assert axes.lines[1].get_ydata().tolist() == [0.01, 0.03]
    colour = style.TROUBLE if undercut else style.CAM
    assert axes.lines[1].get_color() == axes.title.get_color() == colour
    assert ("less the base radius" in axes.get_ylabel()) is (base is None)
    cam_profile._draw_knife(axes := Figure().subplots(), drawn)
    assert axes.lines[1].get_ydata().tolist() == [5.0, 7.0]


def test_the_doubt_of_an_acceleration_is_that_of_each_part_of_the_turn():
    """Four parts: the largest bound stands in the title only."""
    theta = np.radians([45.0, 135.0, 225.0, 315.0, 360.0])
    cam = Made(accuracy=Made(bound=0.5), errors=Made(bounds=[0.1, 0.2, 0.3, 0.4]))
    profile = Made(theta=theta, c2=np.array([1.0, 2.0, 3.0, 4.0, 5.0]))
    drawn = Made(profile=profile, units=METRES, beside=True, measured=True, cam=cam)
    cam_profile._draw_acceleration(axes := Figure().subplots(), drawn)
    assert axes.get_title().startswith("error below 0.5 m/rad")
    corners = {(round(x), round(y, 6)) for x, y in axes.collections[0].get_paths()[0].vertices}
    bounds = zip((45, 135, 225, 315, 360), profile.c2, (0.1, 0.2, 0.3, 0.4, 0.4), strict=True)
    for x, middle, bound in bounds:
        assert {(x, round(middle - bound, 6)), (x, round(middle + bound, 6))} <= corners
