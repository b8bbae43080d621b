"""The picture of classified motions: every kind, events numbered where they belong."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from camcli.analysis.classify import classify_at
from camcli.analysis.explain.events import Event
from camcli.analysis.exponents import Exponents
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import CROWDED, event_numbers
from camcli.plots.classify import (
    COLOURS,
    CONTACT,
    FORGETS,
    Growth,
    draw_classify,
    draw_growth,
    kind,
    remark,
)
from camcli.plots.event_list import MOST, SINGLE, Numbered, draw_list, list_height, numbered
from camcli.plots.label_strip import OTHERS, draw_strip, strip_colour
from tests.conftest import settings
from tests.output.pictures import count, overlaps, panel, pixels, png, tall, words

RPMS = [100.0, 190.0, 358.5, 700.0, 750.0]  # contact, a rest, three turns, one turn, chaos
KINDS = [CONTACT, "periodic with rest on the cam", "periodic", "periodic", "aperiodic"]


@pytest.fixture(scope="module")
def motions(chapter):
    return [classify_at(chapter, rpm, settings(600, 200)) for rpm in RPMS]


def event(rpm, kind="corner-hit", label="P(1;inf)", error=1e-10, **more):
    return Event(rpm, error, kind, label, **more)


def texts(axes):
    return [text.get_text() for text in axes.texts]


def test_every_kind_has_its_colour(chapter, motions):
    assert [kind(motion) for motion in motions] == KINDS
    contact, rest, *others = motions
    figure = draw_classify([contact, rest], chapter)
    image = pixels(figure)
    assert count(image, COLOURS[KINDS[1]]) > 100
    assert count(image[:700], COLOURS["periodic"]) == 0  # the strip below is coloured by period
    assert {f"{CONTACT} (1)", "periodic with rest on the cam (1)"} <= set(words(figure))
    image = pixels(draw_classify(others, chapter))
    assert count(image, COLOURS["periodic"]) > 100
    assert count(image, COLOURS["aperiodic"]) > 10_000
    assert count(image, COLOURS[KINDS[1]]) == 0


def test_a_motion_that_is_not_solved_is_undecided(motions):
    unsolved = replace(motions[2], orbit=None, exponents=None, label="undecided")
    assert count(pixels(draw_classify([unsolved])), COLOURS["undecided"]) > 100
    assert remark([], 1) == "not known for 1 of 1 motions"


def test_any_order_is_the_ascending_picture_and_trouble_is_marked(motions):
    first = draw_classify(motions)
    assert png(draw_classify(motions[::-1])) == png(first)
    assert count(pixels(first), style.TROUBLE) == 0
    bad = replace(motions[0], rpm=400.0, status=Status.IMPACT_BUDGET)
    assert count(pixels(draw_classify([*motions, bad])), style.TROUBLE) > 10


def test_several_motions_at_one_speed_and_at_every_speed(motions):
    here, there = ([replace(motion, rpm=rpm) for motion in motions[:3]] for rpm in (1.0, 2.0))
    pixels(draw_classify(here))
    pixels(draw_classify([*here, *there]))
    axes = panel(0.0, 2.0)
    draw_strip(axes, here, [1.0] * 3)
    heights = [patch.get_height() for patch in axes.patches if not patch.get_hatch()]
    assert heights == pytest.approx([1.0 / 3.0] * 3)


# --- exponents


def test_exponents_have_bars_and_minus_infinity_has_words():
    def growth(x, largest, spread):
        return Growth(x, Exponents(largest, -1.0, spread, 0.0, 1.0), style.FLIGHT)

    axes = panel(0.0, 4.0)
    known = [growth(1.0, 0.5, 0.2), growth(2.0, -0.25, 0.0), growth(3.0, -np.inf, 0.0)]
    draw_growth(axes, known)
    assert texts(axes) == [FORGETS]
    assert axes.get_yticklabels()[0].get_text() == "−∞"
    low, high = axes.get_ylim()
    assert low < -0.25 < 0.7 < high
    assert [0.3, 0.7] in [list(line.get_ydata()) for line in axes.lines]
    assert remark(known, 3) == "bars: ± one standard error"
    axes = panel(0.0, 4.0)
    draw_growth(axes, [*known[:2], growth(3.0, 0.1, np.inf)])
    assert texts(axes) == []
    draw_growth(panel(0.0, 4.0), [])
    draw_growth(panel(0.0, 4.0), known[2:])


# --- labels


def test_the_strip_joins_equal_labels_and_names_wide_ones(motions):
    contact, rest, three, one, chaos = motions
    axes = panel(0.0, 100.0)
    draw_strip(axes, [one, one, three, chaos, rest, contact], [10.0, 40.0, 49.0, 51.0, 53.0, 98.0])
    first, second = axes.patches[:2]
    assert (first.get_x(), first.get_width()) == pytest.approx((0.0, 44.5))
    assert strip_colour(one) == style.PERIODS[0]
    assert second.get_facecolor()[:3] == pytest.approx(matplotlib.colors.to_rgb(style.PERIODS[2]))
    assert texts(axes) == ["P(1;1)", "3", "P(1;∞)", "contact"]
    assert strip_colour(chaos) == OTHERS["aperiodic"]


@pytest.mark.parametrize(
    ("wide", "expected"), [(200, ["P(3;3:3:2)"]), (95, ["period 3"]), (30, ["3"]), (16, [])]
)
def test_a_label_too_wide_for_its_place_gives_way_to_the_period(motions, wide, expected):
    with style.look():
        axes = panel(0.0, 1.0, wide)
        draw_strip(axes, [motions[2]], [0.5])
    assert texts(axes) == expected


# --- events


def test_names_and_digits():
    one = Numbered(1, event(151.51, "accumulation-at-corner", corner="f", status="unresolved"))
    assert (one.name, one.verdict) == ("accumulation at corner f", "unresolved")
    assert Numbered(1, event(198.5605114, "chatter-completion", corner="A2")).speed == "198.560511"
    assert Numbered(1, event(740.1, "interior-crisis", corner="c")).name == "interior crisis at c"
    assert Numbered(1, event(198.5605114, error=0.02)).speed == "198.56 ± 0.02"
    assert Numbered(1, event(1198.5605114, error=30.0)).speed == "1199 ± 30"
    assert Numbered(1, event(1e-3, error=np.inf)).speed == "0.00100000000"


def test_beyond_the_list_minor_events_lose_their_numbers_first(motions):
    many = [event(100.0 + k) for k in range(MOST + 5)]
    found = numbered([event(200.0, "fold", "P(1;1)"), *many])
    assert [one.number for one in found if one.number] == list(range(1, MOST + 1))
    assert found[-1].number == MOST
    assert sum(one.number is None for one in found) == 6
    figure = draw_classify(motions, None, [one.source for one in found])
    assert tall(draw_classify(motions)) + 100 < tall(figure) < tall(draw_classify(motions)) + 1000
    assert any(text.startswith("and 6 more") for text in words(figure))


@pytest.mark.parametrize("many", [1, SINGLE, SINGLE + 1, MOST + 9])
@pytest.mark.parametrize("verdict", ["", "border-period-doubling"])
def test_the_list_does_not_run_into_itself(many, verdict):
    long = "P(96;" + ":".join(["3"] * 96) + ")"
    more = {"corner": "f", "classification": verdict}
    rpms = [111.111 + 33.3 * k for k in range(many)]
    events = numbered([event(rpm, "accumulation-at-corner", long, **more) for rpm in rpms])
    with style.look():
        figure = style.page(2400)
        draw_list(figure, 10, events)
        shown = [text for text in figure.axes[0].texts if text.get_text()]
        boxes = [text.get_window_extent() for text in shown]
        assert not overlaps(shown)
    assert max(box.x1 for box in boxes) <= style.WIDTH
    assert min(box.y0 for box in boxes) >= 2400 - 10 - list_height(events)


@pytest.mark.parametrize("rpms", [
    np.linspace(0.0, 1e-3, 9), np.linspace(0.99, 1.0, 20), np.linspace(0.0, 0.2, MOST),
    np.linspace(0.4, 1.0, CROWDED + 1), [0.5],
])  # fmt: skip
def test_numbers_stay_apart_and_within_the_panel(rpms):
    with style.look():
        axes = panel(0.0, 1.0, 900)
        event_numbers(axes, list(enumerate(rpms, 1)))
        boxes = [text.get_window_extent() for text in axes.texts]
        assert not overlaps(axes.texts)
    assert len(boxes) == len(rpms)
    inside = axes.get_window_extent()
    assert min(box.x0 for box in boxes) >= inside.x0 - 20
    assert max(box.x1 for box in boxes) <= inside.x1 + 20
