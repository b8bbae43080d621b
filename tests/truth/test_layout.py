"""Where things stand on a page, in millimetres of it, and rules that hold for every picture.

The measures are those that were chosen, written down once more: a page is read back as somebody
measures it with a ruler, from its left and its upper edge.
"""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from camcli.plots.picture import Panel, Picture
from camcli.scene.schema import Plot

MM = 25.4  # of an inch


def plain(*sizes, **more):
    """A panel without data; there are numbers at its axes."""
    return Panel(lambda axes: axes.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0)), *sizes, **more)


def height_of(figure: Figure) -> float:
    """The height of a page, mm."""
    return figure.get_figheight() * MM


def place_of(figure: Figure, text: str) -> tuple[float, float]:
    """Left end and middle of words of the heading, mm from the upper left corner of the page."""
    found = [one for one in figure.axes[0].texts if one.get_text() == text]
    assert found, (text, [one.get_text() for one in figure.axes[0].texts])
    x, y = found[0].get_transform().transform(found[0].get_position())
    return x / figure.dpi * MM, height_of(figure) - y / figure.dpi * MM


HIGH, LOW = {"height": 40.0, "across": 2}, {"height": 30.0, "across": 2}
SQUARE = {"height": 90.0, "shape": 0.5}


@pytest.mark.parametrize(
    ("panels", "form", "height"),
    [
        # a panel with its numbers (11) and the edges of the heading and of the page (2 each)
        ([{"height": 40.0}], {}, 55.0),
        ([{"height": 40.0}, {"height": 30.0}], {}, 96.0),
        # panels below one another that share numbers have them once
        ([{"height": 40.0, "x": "rpm"}, {"height": 30.0, "x": "rpm"}], {}, 85.0),
        ([{"height": 40.0, "x": "rpm"}, {"height": 30.0, "x": "mass"}], {}, 96.0),
        ([{"height": 40.0, "above": 6.0}], {}, 61.0),
        # two of 55 mm beside one another; the higher one counts
        ([HIGH, LOW], {"width": 110.0}, 55.0),
        ([HIGH, LOW], {"width": 109.0}, 96.0),
        # at most so many times as high as wide
        ([SQUARE], {"width": 100.0}, 65.0),
        ([{**SQUARE, "across": 2}, {"height": 20.0, "across": 2}], {"width": 120.0}, 45.0),
        # an A4 page, and what a picture may have in a column of a journal
        ([{"height": 300.0}], {"width": 91.0}, 230.0),
        ([{"height": 300.0}], {"width": 90.0}, 200.0),
        ([{"height": 300.0}], {"width": 90.0, "height": 90.0}, 90.0),
    ],
)
def test_a_page_is_as_high_as_its_panels_need(panels, form, height):
    made = {str(k): plain(**more) for k, more in enumerate(panels)}
    figure = Picture("T", made, tall=200.0).figure(Plot(title=False, **form))
    assert height_of(figure) == pytest.approx(height, abs=1e-6)
    assert figure.get_figwidth() * MM == pytest.approx(form.get("width", 170.0))


@pytest.mark.parametrize(
    ("shared", "above", "fits", "lacks"),
    [
        ("", 0.0, 76.0, 75.9),  # 0.65 of 40 each, numbers of 11 twice, 2 above
        ("rpm", 0.0, 70.0, 69.9),  # numbers once, 5 between the panels
        ("rpm", 3.0, 76.0, 75.9),
    ],
)
def test_a_low_page_leaves_out_what_has_no_room(shared, above, fits, lacks):
    panels = {name: plain(40.0, x=shared, above=above) for name in ("one", "two")}
    for height, left_out in ((fits, []), (lacks, ["two"])):
        figure = Picture("T", panels).figure(Plot(title=False, height=height))
        assert (figure.left_out, figure.has_room) == (left_out, not left_out)
        assert height_of(figure) == pytest.approx(height)
        assert len(figure.axes) == 1 + len(panels) - len(left_out)
    asked = {**panels, "three": plain(40.0, asked=True)}
    assert Picture("T", asked).figure(Plot(title=False, height=80.0)).left_out == ["two"]


def test_the_heading_stands_in_its_lines():
    """Title, words and lists with the distances of a ruler; a sample of a line is 5 mm long."""
    line = {"color": "black", "ls": "-"}
    rows = [
        ["", "", "event"],
        [line, "12", "fold"],
        [{**line, "ls": "None", "marker": "o"}, "3", "cusp"],
    ]
    other = [["speed"], ["700 rpm"]]
    picture = Picture("Title", {"a": plain(40.0)}, words="first\nsecond", lists=[rows, other])
    figure = picture.figure(Plot())
    heading = figure.axes[0]

    def at(text):
        return place_of(figure, text)

    assert at("Title") == pytest.approx((2.0, 3.7))
    assert at("first") == pytest.approx((2.0, 8.77))
    assert at("second") == pytest.approx((2.0, 12.67))
    assert [at(word)[1] for word in ("event", "fold", "cusp")] == pytest.approx(
        [18.57, 21.97, 25.37]
    )
    assert [at(word)[1] for word in ("speed", "700 rpm")] == pytest.approx([18.57, 21.97])
    sample, mark = heading.lines
    assert list(sample.get_xdata()) == pytest.approx([2.0, 7.0])
    assert list(mark.get_xdata()) == pytest.approx([4.5])
    assert [one.get_ydata()[0] for one in (sample, mark)] == pytest.approx([21.97, 25.37])
    ends = {one.get_text(): one.get_window_extent().x1 / figure.dpi * MM for one in heading.texts}
    assert at("12")[0] == pytest.approx(9.0)  # 2 behind the samples
    assert at("fold")[0] == pytest.approx(ends["12"] + 2.0, abs=1e-3)
    assert at("speed")[0] == pytest.approx(
        max(ends["fold"], ends["event"], ends["cusp"]) + 4.0, abs=1e-3
    )
    assert height_of(figure) == pytest.approx(16.87 + 3 * 3.4 + 40.0 + 11.0 + 2.0)


def boxes(texts) -> list:
    """Where words stand, in dots."""
    return [text.get_window_extent() for text in texts if text.get_text()]


def test_a_list_stands_beside_the_one_before_it_or_below_where_the_page_ends():
    def lists_on(width, long):
        lists = [[["first"], ["x" * long]], [["second"], ["y" * 40]]]
        picture = Picture("", {"a": plain(40.0)}, lists=lists)
        figure = picture.figure(Plot(title=False, width=width))
        first, second = place_of(figure, "first"), place_of(figure, "second")
        longest = boxes(one for one in figure.axes[0].texts if one.get_text().startswith("x"))
        end = longest[0].x1 / figure.dpi * MM
        words = boxes(figure.axes[0].texts)
        assert max(box.x1 for box in words) <= figure.bbox.x1
        return first, second, end

    first, second, end = lists_on(170.0, 40)
    assert (first[0], first[1]) == pytest.approx((2.0, 3.7))
    assert second == pytest.approx((end + 4.0, 3.7), abs=1e-3)
    first, second, end = lists_on(100.0, 40)
    assert second == pytest.approx((2.0, 3.7 + 2 * 3.4 + 2.0))


def test_a_list_too_wide_has_its_last_words_below_and_in_two_columns_a_cut_end():
    wide = ["", "1", "fold at c", "7" * 12, "w" * 60]
    figure = Picture(
        "", {"a": plain(40.0)}, lists=[[["", "", "event", "rpm", "why"], wide]]
    ).figure(Plot(title=False, width=85.0))
    places = {word: place_of(figure, word) for word in ("fold at c", "7" * 12)}
    assert [y for _, y in places.values()] == pytest.approx(
        [3.7 + 2 * 3.4] * 2
    )  # its head is two rows too
    (below,) = [one for one in figure.axes[0].texts if one.get_text().startswith("www")]
    x, y = place_of(figure, below.get_text())
    assert (x, y) == pytest.approx((places["fold at c"][0], 3.7 + 3 * 3.4))
    assert below.get_text().endswith("…")
    room = (85.0 - 2.0 - x) / MM * figure.dpi
    width = below.get_window_extent().width
    one = width / len(below.get_text())
    assert room - 2.0 * one < width <= room


@pytest.mark.parametrize(("names", "rows"), [(3, 1), (14, 2), (1, 1)])
def test_the_legend_stands_a_millimetre_below_the_heading_in_as_few_rows_as_fit(names, rows):
    def draw(axes):
        for k in range(names):
            axes.plot([0.0, 1.0], [k, k], label=f"curve {k:02d} of many")

    figure = Picture("T", {"a": Panel(draw, 40.0)}).figure(Plot())
    legend = figure.axes[0].get_legend()
    figure.canvas.draw()
    box = legend.get_window_extent()
    assert (figure.bbox.y1 - box.y1) / figure.dpi * MM == pytest.approx(2.0 + 5.07 + 1.0, abs=0.1)
    assert box.x0 / figure.dpi * MM == pytest.approx(2.0, abs=0.1)
    assert box.x1 <= figure.bbox.x1 - 2.0 / MM * figure.dpi
    words = [one.get_text() for one in legend.get_texts()]
    assert words == [f"curve {k:02d} of many" for k in range(names)]
    lines = {round(one.y0) for one in boxes(legend.get_texts())}
    assert len(lines) >= rows
    if len(lines) > 1:  # one more column would not fit
        columns = -(-names // len(lines))
        assert (columns + 1) * box.width / columns > (170.0 - 4.0) / MM * figure.dpi
    high = box.height / figure.dpi * MM
    assert height_of(figure) == pytest.approx(2.0 + 5.07 + 1.0 + high + 51.0 + 2.0, abs=0.1)


def test_names_of_a_legend_that_fit_below_one_another_are_not_broken():
    """Two do not fit side by side, but would if they were broken."""
    names = ["i" * 150, "l" * 150]

    def draw(axes):
        for name in names:
            axes.plot([0.0, 1.0], [0.0, 1.0], label=name)

    figure = Picture("T", {"a": Panel(draw, 40.0)}).figure(Plot())
    assert [one.get_text() for one in figure.axes[0].get_legend().get_texts()] == names


def test_narrow_curves_stand_beside_a_panel_on_a_page_and_not_in_a_column():
    def curve(axes):
        axes.plot([0.0, 1.0], [0.0, 1.0])
        axes.set(xlabel="lift")

    panels = {
        name: Panel(lambda axes: axes.set(ylabel="q"), 40.0, x="rpm", beside=(curve, curve))
        for name in ("up", "down")
    }
    figure = Picture("", panels).figure(Plot(title=False))
    figure.canvas.draw()
    _, up, *aside = figure.axes
    wide = up.get_position().width
    beside = [axes for axes in aside if axes.get_position().width < 0.5 * wide]
    assert len(beside) == 4
    for axes in beside:
        assert axes.get_position().width / wide == pytest.approx(0.085, rel=0.04)
        assert axes.get_position().x1 < up.get_position().x0
    assert [axes.get_xlabel() for axes in beside] == ["lift", "lift", "", ""]
    assert not up.yaxis.get_tick_params()["labelleft"]  # its numbers are those of the curves
    assert up.get_ylabel() == ""
    assert len(Picture("", panels).figure(Plot(title=False, width=110.0)).axes) == 1 + 2 + 4
    assert len(Picture("", panels).figure(Plot(title=False, width=109.0)).axes) == 1 + 2


def test_letters_stand_at_the_left_and_away_from_numbers_above_the_panel():
    """Beside the panel where an event's number is above its left end, else above it."""

    def numbered(share):
        def draw(axes):
            axes.set(xlim=(0.0, 100.0))
            look = {"xycoords": axes.get_xaxis_transform(), "arrowprops": {"arrowstyle": "-"}}
            axes.annotate("1", (0.0, 1.0), (100.0 * share, 1.1), **look)

        return Panel(draw, 40.0)

    shown = {"near": numbered(0.079), "far": numbered(0.081), "plain": plain(40.0)}
    figure = Picture("", shown).figure(Plot(title=False))
    titles = [axes._left_title for axes in figure.axes[1:]]
    assert [one.get_text() for one in titles] == ["(a)", "(b)", "(c)"]
    assert [one.get_fontsize() for one in titles] == [8.0] * 3
    assert [one.get_position()[0] for one in titles] == pytest.approx([-0.015, 0.0, 0.0])
    assert [one.get_horizontalalignment() for one in titles] == ["right", "left", "left"]


@pytest.mark.parametrize(
    ("low", "high", "step"),
    [(0.0, 1.0, 0.2), (660.0, 760.0, 20.0), (0.0, 360.0, 50.0), (-0.3, 0.25, 0.1)],
)
def test_ticks_stand_at_ones_twos_and_fives(low, high, step):
    panel = Panel(lambda axes: axes.set(xlim=(low, high), ylim=(low, high)), 60.0)
    figure = Picture("", {"a": panel}).figure(Plot(title=False, width=85.0))
    figure.canvas.draw()
    axes = figure.axes[1]
    for ticks in (axes.get_xticks(), axes.get_yticks()):
        inside = [x for x in ticks if low - 1e-9 <= x <= high + 1e-9]
        assert 3 <= len(inside) <= 10
        apart = inside[1] - inside[0]
        lead = float(f"{apart:.0e}".partition("e")[0])
        assert lead in (1.0, 2.0, 5.0)
    inside = [x for x in axes.get_xticks() if low - 1e-9 <= x <= high + 1e-9]
    assert inside[1] - inside[0] == pytest.approx(step)


def rows_shown(lists, **form) -> dict[float, list[str]]:
    """The words of each row of the lists of a page 120 mm high, by their place from above (mm)."""
    picture = Picture("", {"a": plain(40.0)}, lists=lists, tall=120.0)
    figure = picture.figure(Plot(title=False, **form))
    found: dict[float, list[str]] = {}
    for text in sorted(figure.axes[0].texts, key=lambda one: one.get_position()[0]):
        if text.get_text():
            found.setdefault(round(float(text.get_position()[1]), 3), []).append(text.get_text())
    return dict(sorted(found.items()))


def numbered(count: int, head: str = "event") -> list[list[str]]:
    """A list with a head and so many rows."""
    return [["", "", head], *(["", str(k), f"event {k}"] for k in range(count))]


@pytest.mark.parametrize(("count", "last"), [(13, "event 12"), (14, "and 2 more, in the tables")])
def test_a_list_ends_at_two_fifths_of_a_page_in_a_column(count, last):
    """(0.42 x 120 mm - 2 mm) / 3.4 mm are 14 rows with its head; a wide page has all of them."""
    shown = [*rows_shown([numbered(count)], width=90.0).values()]
    assert len(shown) == 14
    assert shown[-1][-1] == last
    assert len(rows_shown([numbered(40)], width=91.0)) == 41
    halves = [numbered(8)[:1] + numbered(16)[k : k + 8] for k in (1, 9)]
    joined = [*rows_shown(halves, width=90.0).values()]  # parts of one list are one in a column
    assert joined[0] == ["event"]
    assert joined[-1] == ["and 4 more, in the tables"]
    assert len(joined) == 14


def test_how_many_more_there_are_stands_below_the_names_of_a_list():
    """Not below the marks or the numbers in front of them."""
    line = {"color": "black", "ls": "-"}
    marked = [["", "", "event"], *([line, str(k), f"event {k}"] for k in range(40))]
    for rows in (numbered(40), marked):
        picture = Picture("", {"a": plain(40.0)}, lists=[rows], tall=120.0)
        figure = picture.figure(Plot(title=False, width=90.0))
        (more,) = [
            text.get_text() for text in figure.axes[0].texts if text.get_text().startswith("and ")
        ]
        assert more == "and 28 more, in the tables"
        assert place_of(figure, more)[0] == pytest.approx(place_of(figure, "event")[0])


def words_with(begin, shown) -> list[list[str]]:
    """Of each row those words that begin so; rows without any are left out."""
    rows = ([word for word in row if word.startswith(begin)] for row in shown.values())
    return [row for row in rows if row]


@pytest.mark.parametrize("words", [5, 6])
def test_beside_a_list_that_is_cut_marks_with_a_few_words_stand_in_pairs(words):
    marks = [["", "marks"], *(["", "m" * (k + 1)] for k in range(words))]
    shown = rows_shown([numbered(20), marks], width=90.0)
    pairs = words_with("m", shown)
    left = [row[0] for row in pairs[1:]]
    right = [row[1] for row in pairs[1:] if len(row) > 1]
    longest = ["m" * k for k in range(words, 0, -1)]
    assert pairs[0] == ["marks"]
    assert left == longest[:3]  # the longer ones at the left
    assert right == longest[3:]
    cut = words_with(("event", "and"), shown)
    assert len(cut) == 14 - 4
    assert cut[-1] == ["and 12 more, in the tables"]


def test_a_list_that_is_cut_keeps_four_rows():
    """A head, two rows, and how many more there are, however many other rows there are."""
    others = [["", "another", "x"], *(["", "1", "y"] for _ in range(13))]
    shown = rows_shown([numbered(20), others], width=90.0)
    kept = [row[0] for row in words_with(("event", "and"), shown)]
    assert kept == ["event", "event 0", "event 1", "and 18 more, in the tables"]


def test_a_panel_beside_another_has_no_numbers_where_they_share_an_axis():
    """Of the quantities q and q, u and v, and of two panels that share none."""

    def named(name):
        return lambda axes: axes.set(ylabel=name)

    quantities = ("q", "q", "u", "v", "", "")
    panels = {
        str(n): Panel(named(f"name {n}"), 40.0, x="rpm", y=quantity, across=2)
        for n, quantity in enumerate(quantities)
    }
    figure = Picture("", panels).figure(Plot(title=False))
    figure.canvas.draw()
    _, *drawn = figure.axes
    assert [axes.get_ylabel() for axes in drawn] == [
        "name 0", "", "name 2", "name 3", "name 4", "name 5",
    ]  # fmt: skip
    numbered = [axes.yaxis.get_tick_params().get("labelleft", True) for axes in drawn]
    assert numbered == [True, False, True, True, True, True]
