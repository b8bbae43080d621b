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


@pytest.mark.parametrize(
    ("panels", "form", "height"),
    [
        # a panel with its numbers (11) and the edges of the heading and of the page (2 each)
        ({"a": {"height": 40.0}}, {}, 55.0),
        ({"a": {"height": 40.0}, "b": {"height": 30.0}}, {}, 96.0),
        # panels below one another that share numbers have them once
        ({"a": {"height": 40.0, "x": "rpm"}, "b": {"height": 30.0, "x": "rpm"}}, {}, 85.0),
        ({"a": {"height": 40.0, "x": "rpm"}, "b": {"height": 30.0, "x": "mass"}}, {}, 96.0),
        ({"a": {"height": 40.0, "above": 6.0}}, {}, 61.0),
        # two of 55 mm beside one another; the higher one counts
        ({"a": {"height": 40.0, "across": 2}, "b": {"height": 30.0, "across": 2}}, {"width": 110.0}, 55.0),
        ({"a": {"height": 40.0, "across": 2}, "b": {"height": 30.0, "across": 2}}, {"width": 109.0}, 96.0),
        # at most so many times as high as wide
        ({"a": {"height": 90.0, "shape": 0.5}}, {"width": 100.0}, 65.0),
        ({"a": {"height": 90.0, "shape": 0.5, "across": 2}, "b": {"height": 20.0, "across": 2}}, {"width": 120.0}, 45.0),
        # an A4 page, and what a picture may have in a column of a journal
        ({"a": {"height": 300.0}}, {"width": 91.0}, 230.0),
        ({"a": {"height": 300.0}}, {"width": 90.0}, 200.0),
        ({"a": {"height": 300.0}}, {"width": 90.0, "height": 90.0}, 90.0),
    ],
)  # fmt: skip
def test_a_page_is_as_high_as_its_panels_need(panels, form, height):
    made = {name: plain(**more) for name, more in panels.items()}
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
