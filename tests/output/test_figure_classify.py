"""The picture of classified motions: every kind, events numbered where they belong."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from camcli.analysis.classify import classify_at
from camcli.analysis.explain.changes import CriticalEvent
from camcli.analysis.exponents import Exponents
from camcli.analysis.labels import Label
from camcli.plots import style
from camcli.plots.axes import CROWDED, number_events
from camcli.plots.classify import ALL_FORGET, FORGETS, STRONG, _draw_labels, _name, draw_classify
from camcli.plots.critical_speeds import MOST, SINGLE, event_lists, numbered
from camcli.plots.picture import COMPACT, Panel, Picture
from camcli.scene.schema import Plot
from tests.conftest import settings
from tests.support.picture_sizes import count, overlaps, panel, pixels, tall, words

RPMS = [100.0, 190.0, 358.5, 700.0, 750.0]  # contact, a rest, three turns, one turn, chaos


@pytest.fixture(scope="module")
def motions(chapter):
    return [classify_at(chapter, rpm, settings(600, 200)) for rpm in RPMS]


def event(rpm, kind="corner-hit", label="P(1;inf)", error=1e-10, **more):
    return CriticalEvent(rpm, error, kind, label, **more)


def test_a_motion_that_is_not_solved_is_undecided(motions):
    unsolved = replace(motions[2], orbit=None, exponents=None, label="undecided")
    picture = draw_classify([unsolved])
    assert count(pixels(picture), style.UNDECIDED) > 100
    assert picture.caption == "undecided (1); exponent not known for 1 of 1 motion"


def test_exponents_have_bars_and_minus_infinity_has_words(motions):
    spread = replace(motions[3], exponents=Exponents(0.5, -1.0, 0.2, 0.0, 1.0))
    forgets = replace(motions[1], exponents=Exponents(-np.inf, -np.inf, np.inf, 0.0, 1.0))
    picture = draw_classify([spread, forgets])
    axes = picture.figure().axes[2]
    low, high = axes.get_ylim()
    assert low < 0.0 < 0.7 < high < 1.0
    (bar,) = [path for c in axes.collections for path in c.get_paths()]
    assert bar.vertices[:, 1] == pytest.approx([0.3, 0.7])
    assert FORGETS in words(picture)
    assert FORGETS not in words(draw_classify([spread]))


def test_marks_of_minus_infinity_stand_below_all_exponents(motions):
    forgets = replace(motions[1], exponents=Exponents(-np.inf, -np.inf, np.inf, 0.0, 1.0))
    low = replace(motions[3], exponents=Exponents(-0.223, -0.3, 0.0, 0.0, 1.0))
    axes = draw_classify([forgets, low, motions[4]]).figure().axes[2]
    (marks,) = [line for line in axes.lines if line.get_label() == FORGETS]
    place = axes.transData.inverted().transform(axes.transAxes.transform((0.5, 0.03)))[1]
    assert set(marks.get_ydata()) == {0.03}
    assert place < -0.223 - 0.02 * np.ptp(axes.get_ylim())


def test_exponents_without_a_finite_one_are_told_and_not_drawn(motions):
    forgets = replace(motions[1], exponents=Exponents(-np.inf, -np.inf, np.inf, 0.0, 1.0))
    picture = draw_classify([forgets])
    assert list(picture.chosen(None)) == ["phases", "labels"]
    assert picture.caption.endswith(ALL_FORGET)
    assert picture.chosen(["exponents"])
    assert list(draw_classify([forgets, motions[3]]).chosen(None)) == [
        "phases", "exponents", "labels",
    ]  # fmt: skip


def test_the_legend_has_each_kind_once_in_the_order_of_a_sweep(motions):
    figure = draw_classify(motions[::-1]).figure(Plot(width=85.0))
    names = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert names[:5] == ["contact", "period 1", "period 3", "with rests", "aperiodic"]
    assert figure.get_figheight() * 25.4 <= COMPACT + 0.1


def test_a_label_stands_above_the_foot_of_its_own_rectangle(motions):
    """Also where one speed has several motions, on one another."""
    above, below = motions[3], replace(motions[4], value=motions[3].value, rpm=motions[3].rpm)
    axes = panel()
    draw_classify([motions[1], above, below]).panels["labels"].draw(axes)
    texts = {text.get_text(): text.get_position() for text in axes.texts}
    assert len(texts) == 3
    heights = {motions[1].label: (0.0, 1.0), above.label: (0.5, 1.0), below.label: (0.0, 0.5)}
    for label, (low, high) in heights.items():
        middle = 0.5 * (low + STRONG * (high - low) + high)
        assert texts[label.replace("inf", "∞")][1] == pytest.approx(middle)


# --- events


@pytest.mark.slow
def test_beyond_the_list_minor_events_lose_their_numbers_first(motions):
    many = [event(100.0 + k) for k in range(MOST + 5)]
    found = numbered([event(200.0, "fold", "P(1;1)"), *many])
    assert [number for number, _ in found if number] == list(range(1, MOST + 1))
    assert found[-1][0] == MOST
    assert sum(number is None for number, _ in found) == 6
    picture = draw_classify(motions, None, [one for _, one in found])
    assert draw_classify(motions).figure().get_figheight() * 25.4 + 40 < tall(picture)
    assert any(text.startswith("and 6 more") for text in words(picture))


@pytest.mark.parametrize(
    ("times_wide", "times_high", "said"),
    [(1.31, 1.11, "P(1;∞)"), (1.29, 1.11, "1"), (1.31, 1.09, ""), (0.01, 9.0, "")],
)
def test_a_label_stands_where_it_has_a_margin(motions, times_wide, times_high, said):
    """Of three tenths of its width and a tenth of its height; else the period, else nothing."""
    axes = panel()  # the range is 0 to 1 both ways
    text = axes.text(0.5, 0.5, "P(1;∞)", size=style.NOTE, va="center_baseline")
    box, frame = text.get_window_extent(), axes.get_window_extent()
    text.remove()
    wide, high = times_wide * box.width / frame.width, times_high * box.height / frame.height
    _name(axes, motions[1], (0.2, 0.3), wide, high)
    assert [text.get_text() for text in axes.texts] == ([said] if said else [])
    for text in axes.texts:
        assert text.get_position() == pytest.approx((0.2 + 0.5 * wide, 0.3 + 0.5 * high))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("many", "verdict"), [(SINGLE, "border-period-doubling"), (SINGLE + 1, ""), (MOST + 9, "")]
)
def test_the_list_does_not_run_into_itself(many, verdict):
    long = "P(96;" + ":".join(["3"] * 96) + ")"
    more = {"corner": "f", "classification": verdict}
    rpms = [111.111 + 33.3 * k for k in range(many)]
    events = numbered([event(rpm, "accumulation-at-corner", long, **more) for rpm in rpms])
    blank = {"x": Panel(lambda axes: None)}
    figure = Picture("title", blank, "words " * 40, lists=event_lists(events)).figure()
    figure.canvas.draw()
    shown = [text for text in figure.axes[0].texts if text.get_text()]
    assert not overlaps(shown)
    assert max(text.get_window_extent().x1 for text in shown) <= figure.bbox.x1


@pytest.mark.parametrize(("count", "halves"), [(SINGLE, [20]), (SINGLE + 1, [11, 10])])
def test_a_row_for_each_event_in_one_list_or_in_two(count, halves):
    """Number, name, speed and motion, and the class of its own cell or cut behind the motion."""
    more = {"corner": "b", "classification": "border-period-doubling"}
    events = numbered([event(700.0 + k, "corner-impact", "P(1;1)", **more) for k in range(count)])
    lists = event_lists(events)
    wide = count == SINGLE
    assert [rows[0] for rows in lists] == [["", "event", "rpm", "motion"] + [""] * wide] * len(
        halves
    )
    assert [len(rows) - 1 for rows in lists] == halves
    told = ["P(1;1)", "border period doubling"] if wide else ["P(1;1), border period do"]
    assert [row for rows in lists for row in rows[1:]] == [
        [str(k + 1), "corner impact at b", f"{700 + k}.000000", *told] for k in range(count)
    ]
    beside = event(650.0, "fold", "contact", status="unresolved")
    (rows,) = event_lists([(1, beside), (None, event(660.0, "fold", "contact"))])[:1]
    assert rows[1][4] == "unresolved"


@pytest.mark.parametrize("rpms", [
    np.linspace(0.0, 1e-3, 9), np.linspace(0.99, 1.0, 20), np.linspace(0.0, 0.2, MOST),
    np.linspace(0.4, 1.0, CROWDED + 1), [0.5],
])  # fmt: skip
def test_numbers_stay_apart_and_within_the_panel(rpms):
    with style.look():
        axes = panel(0.0, 1.0, 1500)
        number_events(axes, list(enumerate(rpms, 1)), named=True)
        boxes = [text.get_window_extent() for text in axes.texts]
        assert len(boxes) == len(rpms)
        inside = axes.get_window_extent()
        assert min(box.x0 for box in boxes) >= inside.x0 - 20
        assert max(box.x1 for box in boxes) <= inside.x1 + 20
        places = [text.xyann for text in axes.texts]
        assert len(set(places)) == len(places)


@pytest.mark.parametrize(
    ("kinds", "wide"),
    [
        ("aaa", [3]),
        ("aab", [2, 1]),  # another label
        ("aarr", [2, 2]),  # the same label, of an orbit that rests on the cam
        ("arra", [1, 2, 1]),
        ("acca", [4]),  # rests for good: no departure
        ("anna", [4]),  # no orbit was solved
    ],
)
def test_speeds_of_one_label_share_a_rectangle_unless_only_some_of_them_rest(kinds, wide):
    """The speeds are 1 rpm apart; the edges of rectangles lie in the middle between them."""
    orbits = {
        "a": SimpleNamespace(resting=False, theta=(1.0,)),
        "b": SimpleNamespace(resting=False, theta=(1.0,)),
        "r": SimpleNamespace(resting=True, theta=(1.0,)),
        "c": SimpleNamespace(resting=True, theta=()),
        "n": None,
    }
    motions = [
        SimpleNamespace(label=Label((2.0,) if kind == "b" else (1.0,)), period=1,
                        orbit=orbits[kind])
        for kind in kinds
    ]  # fmt: skip
    axes = Figure().subplots()
    axes.set_xlim(-0.5, len(kinds) - 0.5)
    _draw_labels(axes, SimpleNamespace(x=list(range(len(kinds))), motions=motions))
    tall_ones = [patch for patch in axes.patches if patch.get_height() == 1.0]
    assert [patch.get_width() for patch in tall_ones] == wide
    lefts = [sum(wide[:k]) - 0.5 for k in range(len(wide))]
    assert [patch.get_x() for patch in tall_ones] == lefts
