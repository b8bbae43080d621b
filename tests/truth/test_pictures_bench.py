"""The pictures of the bench against precision.csv and stability.csv; the rows are made up."""

from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

import camcli
from camcli.analysis.bench import precision, stability
from camcli.analysis.bench.validation import ValidationRow
from camcli.api import validation
from camcli.api.bench import bench
from camcli.plots.bench import draw_stability
from camcli.scene.schema import Plot
from tests.support.picture_reader import COLOURS, Panel, dashes, hexed, read_page
from tests.support.picture_sizes import check_texts

CASES = {  # a title too long for a third of a page stands in two lines
    "periodic": "P(1;1) at 700 rpm", "chatter": "complete chatter,\n190 rpm",
    "incomplete": "incomplete chatter,\n198.7 rpm",
}  # fmt: skip
METHODS = {  # name, colour and mark
    "core": ("camcli", "black", "o"),
    "lsoda": ("LSODA", "measured", "^"),
    "rk4": ("RK4, fixed steps", "detachment", "h"),
    "dop853": ("DOP853", "period 1", "D"),
}
SIGNS = {  # status: mark and words
    "missed": ("x", "missed or invented impacts"),
    "invented": ("x", "missed or invented impacts"),
    "given-up": ("|", "given up, error until then"),
    "over-bound": ("*", "beyond the bound promised"),
}
STATUSES = ("ok", "missed", "invented", "given-up", "over-bound", "failed")


def measured(piece, **_):
    """A row with numbers of its own; of one method none can be drawn."""
    name, point = piece
    k = len(point.setting) + 3 * len(name) + 5 * len(point.method)
    seconds, error = 1e-4 * 1.2**k, 1e-15 * 1.5**k
    status = STATUSES[k % len(STATUSES)]
    if point.setting.endswith("1e-15"):
        error = 0.0
    if point.method == "dop853":  # was not measured, or has no error
        seconds, error = (np.nan, error) if "max_step" in point.setting else (seconds, np.nan)
    return precision.Measured(name, point.method, point.setting, seconds, error, status=status)


@pytest.fixture
def errors(monkeypatch):
    monkeypatch.setattr(precision, "measure", measured)
    values = {"bench.cases": [*CASES], "bench.methods": [*METHODS], "bench.quick": True}
    return bench(camcli.load_scene(None, {**values, "bench.part": "precision"}))


HOLLOW = "hollow: steps of at most 1/16 turn"


def test_a_panel_per_case_shows_the_rows_of_precision(errors):
    table = errors.tables["precision"]
    _, *axes = camcli.plot(errors).axes
    assert len(axes) == len(CASES)
    known = np.isfinite(table["seconds"]) & np.isfinite(table["error"])
    limits = set()
    for (case, title), one in zip(CASES.items(), axes, strict=True):
        panel = Panel(case, one)
        assert panel.title == title
        first = one.get_subplotspec().is_first_col()  # the others of its row share the axis
        assert panel.labels == ("time of a run (s)", "error (turns)" if first else "")
        assert (one.get_xscale(), one.get_yscale()) == ("log", "log")
        own = known & (table["case"] == case)
        signs, said = {}, set()
        for method, (name, colour, shape) in METHODS.items():
            for limited in (False, True):
                some = own & (table["method"] == method)
                some &= np.array(["max_step" in text for text in table["setting"]]) == limited
                if not some.any():
                    continue
                x, y = table["seconds"][some], np.maximum(table["error"][some], 1e-17)
                label = None if limited else name
                style, face = ("dashed", "white") if limited else ("solid", colour)
                panel.dots(x, y, shape, face, colour, label=label, style=style)
                for at in zip(x, y, table["status"][some], strict=True):
                    if at[2] in SIGNS:
                        signs.setdefault(SIGNS[at[2]], []).append(at[:2])
                if limited:
                    said.add(HOLLOW)
        hollow = panel.pick(Line2D, lambda a: a.get_label() == HOLLOW)
        assert {a.get_label() for a in hollow} == said
        assert [len(a.get_xdata()) for a in hollow] == [0] * len(said)  # in the legend alone
        for (shape, words), places in signs.items():
            marks = panel.pick(
                Line2D, lambda a, m=shape, w=words: (a.get_marker(), a.get_label()) == (m, w)
            )
            drawn = [tuple(at) for a in marks for at in zip(*a.get_data(), strict=True)]
            assert np.array(sorted(drawn)) == pytest.approx(np.array(sorted(places)))
            assert {hexed(a.get_color()) for a in marks} == {COLOURS["trouble"]}
            assert {dashes(a) for a in marks} == {"none"}
        panel.done()
        limits.add((one.get_xlim(), one.get_ylim()))
    assert len(limits) == 1
    figure = axes[0].get_figure()
    figure.draw_without_rendering()
    for one in axes:
        (words,) = [a for a in one.findobj(Text) if a.get_text().startswith("(")]
        assert words.get_window_extent().x1 <= figure.bbox.x1
    ((x, y),) = limits
    assert x[0] < table["seconds"][known].min() < table["seconds"][known].max() < x[1]
    assert y[0] < 1e-17 < table["error"][known].max() < y[1]
    for axis, apart in ((axes[0].yaxis, 1e4), (axes[0].xaxis, 100.0)):  # however few there are
        ticks = axis.get_major_locator().tick_values(1e-9, 10.0)
        assert ticks[1:] / ticks[:-1] == pytest.approx(np.full(len(ticks) - 1, apart))
    page = read_page(errors)
    assert page.texts == ["Work and precision: error against time, lower left is better"]
    check_texts(figure)


def test_in_a_journals_column_no_case_is_left_out_and_no_titles_touch(errors):
    figure = errors.pictures["precision"]().figure(Plot(width=85.0))
    check_texts(figure)
    assert not figure.left_out
    axes = figure.axes[1:]
    assert len(axes) == len(CASES)
    boxes = [one._left_title.get_window_extent() for one in axes]
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[k + 1 :])
        assert box.x1 <= figure.bbox.x1


def test_a_mark_per_extreme_case_is_at_the_time_it_took(monkeypatch):
    rows = {k: stability.ROWS[k] for k in (1, 3, 8, 19)}
    took = dict(zip([row.case for row in rows.values()], (2e-3, 0.7, 5e-4, 0.04), strict=True))
    wrong = rows[8].case

    def measure(row, machines):
        status = "failed" if row.case == wrong else "ok"
        return stability.RowOutcome(row.case, row.expected, "seen", status, took[row.case])

    monkeypatch.setattr(stability, "ROWS", rows)
    monkeypatch.setattr(stability, "measure", measure)
    result = bench(camcli.load_scene(None, {"bench.part": "stability"}))
    _, axes = camcli.plot(result).axes
    names = [text.get_text() for text in axes.get_yticklabels()]
    assert names == [name.replace("+-", "±") for name in took]
    assert list(axes.get_yticks()) == [0, 1, 2, 3]
    panel = Panel("cases", axes)
    fine = [k for k, name in enumerate(took) if name != wrong]
    seconds = list(took.values())
    panel.dots([seconds[k] for k in fine], fine, "o", "period 1", label="as expected")
    bad = [k for k in range(4) if k not in fine]
    panel.dots([seconds[k] for k in bad], bad, "X", "trouble", label="not as expected")
    for k, said in enumerate(("2 ms", "700 ms", "500 µs", "40 ms")):
        words = panel.words(said)
        assert words.xy == (seconds[k], k)
    panel.pick(Rectangle, count=2)  # every other row is shaded
    panel.done()
    low, high = axes.get_ylim()
    assert low > high  # the first case on top
    assert (axes.get_xscale(), axes.get_xlabel()) == ("log", "time (s)")
    assert read_page(result).texts == ["4 extreme cases, 1 not as expected"]
    for width in (85.0, 170.0):
        check_texts(camcli.plot(result, width=width))


def test_a_row_is_higher_where_the_name_of_its_case_takes_two_lines():
    """No name of a journal's column touches another, or ends beyond its row."""
    cases = [row.case for row in stability.ROWS.values()]
    rows = [stability.RowOutcome(case, "as", "as", "ok", 0.01) for case in cases]
    page = draw_stability(rows).figure(Plot(width=85.0))
    page.draw_without_rendering()
    _, axes = page.axes
    texts = axes.get_yticklabels()
    assert any("\n" in text.get_text() for text in texts)
    assert len({text.get_size() for text in texts}) == 1
    renderer = page.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in texts]
    for above, below in pairwise(boxes):
        assert above.y0 - below.y1 > 2.0  # pixels
    shades = [patch.get_window_extent(renderer) for patch in axes.patches]
    for box, shade in zip(boxes[1::2], shades, strict=True):
        assert shade.y0 < box.y0 < box.y1 < shade.y1


def test_a_line_per_published_number_shows_what_it_may_be_off_and_is(monkeypatch):
    made = [  # problem, published, ours, bound, independent, status
        ("ball", "2.00", 2.001, 0.005, "", "ok"),
        ("ball", "1.00", 1.0, 0.005, "", "ok"),  # exactly: drawn at the edge
        ("cam", "-4.0", -4.5, 0.05, "-4.5000001", "published-off"),
        ("cam", "10.0", 12.0, 0.05, "", "failed"),
        ("ball", "3", 3.0, 0.0, "", "ok"),  # a count
    ]

    def measure(problem):
        return [
            ValidationRow(
                "who", f"q{k}", published, ours, ours - float(published), bound, "p. 1", "3",
                independent, status, 0.0, name,
            )
            for k, (name, published, ours, bound, independent, status) in enumerate(made)
        ]  # fmt: skip

    one = validation.Problem("ball", "who", lambda problem: iter(()), quick=True)
    monkeypatch.setattr(validation, "PROBLEMS", {"ball": one})
    monkeypatch.setattr(validation, "measure", measure)
    result = bench(camcli.load_scene(None, {"bench.part": "validation"}))
    _, axes = camcli.plot(result).axes
    panel = Panel("numbers", axes)
    order = [0, 1, 4, 2, 3]  # by problem, in the order of their first rows
    sizes = np.array([abs(float(made[k][1])) for k in order])
    bars = panel.pick(Rectangle, count=5)
    assert bars[0].get_label() == "half a last published digit and our error"
    bounds = np.maximum(np.array([made[k][3] for k in order]) / sizes, 1e-17)
    assert [bar.get_y() + 0.5 * bar.get_height() for bar in bars] == pytest.approx(range(5))
    assert [bar.get_x() for bar in bars] == [1e-17] * 5
    assert [bar.get_x() + bar.get_width() for bar in bars] == pytest.approx(bounds + 1e-17)
    off = np.array([abs(made[k][2] - float(made[k][1])) for k in order]) / sizes
    off = np.maximum(off, 1e-17)
    panel.dots(off[[0, 1, 2]], [0, 1, 2], "o", COLOURS["period 1"], label="ours less published")
    words = "the same, published less exactly than printed"
    panel.dots(off[[3]], [3], "D", COLOURS["measured"], label=words)
    panel.dots(off[[4]], [4], "x", COLOURS["trouble"], label="the same, not reproduced")
    there = [1e-7 / 4.0]
    label = "ours less independent"
    panel.dots(there, [3], "D", "#ffffff", COLOURS["measured"], label=label, close=1e-6)
    panel.guide("y", 2.5, COLOURS["guide"])
    panel.done()
    assert list(axes.get_yticks()) == [1.0, 3.5]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["ball", "cam"]
    assert panel.labels == ("off, as a share of the number\n(left edge: not at all)", "")
    for width in (85.0, 170.0):
        check_texts(camcli.plot(result, width=width))
    narrow = camcli.plot(result, width=60.0)
    narrow.draw_without_rendering()
    ticks = narrow.axes[1].get_xticklabels()
    spans = [text.get_window_extent() for text in ticks if 1e-17 <= text.get_position()[0] <= 10.0]
    assert len(spans) > 3
    assert all(one.x1 < other.x0 for one, other in pairwise(spans))
    page = read_page(result)
    wanted = "5 published numbers of 2 problems, 1 not reproduced, 1 less exact than printed"
    assert page.texts[0] == wanted


def test_the_record_counts_how_the_points_of_each_method_ended(errors):
    """The table has them all; ours that are not as they should be are named."""
    table = errors.tables["precision"]
    method, status = table["method"], table["status"]
    ends = Counter(zip(method, status, strict=True))
    record = errors.summary["precision"]
    counted = {(one["method"], one["status"]): one["points"] for one in record["points"]}
    assert len(counted) == len(record["points"]) > 4
    assert counted == ends
    ours = (method == precision.CORE) & (status != precision.OK)
    assert record["failed"] == [
        f"{case}, {setting}: {how}"
        for case, setting, how in zip(
            table["case"][ours], table["setting"][ours], status[ours], strict=True
        )
    ]
