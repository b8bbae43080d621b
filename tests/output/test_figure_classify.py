"""The picture of classified motions: every kind, events numbered where they belong."""

from dataclasses import replace

import numpy as np
import pytest

from camcli.analysis.classify import classify_at
from camcli.analysis.explain.changes import Event
from camcli.analysis.exponents import Exponents
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import CROWDED, number_events
from camcli.plots.classify import FORGETS, draw_classify, kind
from camcli.plots.critical_speeds import MOST, SINGLE, event_lists, numbered
from camcli.plots.picture import Panel, Picture
from tests.conftest import settings
from tests.output.pictures import count, overlaps, panel, pixels, tall, words

RPMS = [100.0, 190.0, 358.5, 700.0, 750.0]  # contact, a rest, three turns, one turn, chaos
KINDS = ["contact", "periodic with rest on the cam", "periodic", "periodic", "aperiodic"]


@pytest.fixture(scope="module")
def motions(chapter):
    return [classify_at(chapter, rpm, settings(600, 200)) for rpm in RPMS]


def event(rpm, kind="corner-hit", label="P(1;inf)", error=1e-10, **more):
    return Event(rpm, error, kind, label, **more)


def test_every_kind_is_counted_and_every_label_has_its_colour(chapter, motions):
    assert [kind(motion) for motion in motions] == KINDS
    picture = draw_classify(motions, chapter)
    shown, image = words(picture), pixels(picture)
    assert picture.words.startswith("aperiodic (1); contact (1); periodic (2); periodic with rest")
    for label in ("contact", "P(3;3:3:2)", "P(1;1)", "aperiodic"):
        assert label in shown
        assert count(image, style.label_colour(label)) > 10_000
    assert {"hatched: rests on the cam", FORGETS, "period 3"} <= set(shown)


def test_a_motion_that_is_not_solved_is_undecided(motions):
    unsolved = replace(motions[2], orbit=None, exponents=None, label="undecided")
    picture = draw_classify([unsolved])
    assert count(pixels(picture), style.UNDECIDED) > 100
    assert picture.words == "undecided (1); exponent not known for 1 of 1 motions"


@pytest.mark.slow
def test_any_order_is_the_ascending_picture_and_trouble_is_marked(motions):
    first = draw_classify(motions)
    image = pixels(first)
    assert (pixels(draw_classify(motions[::-1])) == image).all()
    assert count(image, style.TROUBLE) == 0
    bad = draw_classify([*motions, replace(motions[0], value=400.0, status=Status.IMPACT_BUDGET)])
    assert count(pixels(bad), style.TROUBLE) > 10
    assert bad.words.endswith("not ok: impact-budget (1)")


def labels_panel(motions):
    return draw_classify(motions).figure().axes[3]


def test_the_strip_joins_equal_labels(motions):
    contact, _, three, one, chaos = motions
    speeds = [10.0, 40.0, 49.0, 51.0, 98.0]
    some = [one, one, three, chaos, contact]
    axes = labels_panel(
        [replace(m, rpm=rpm, value=rpm) for m, rpm in zip(some, speeds, strict=True)]
    )
    first, second = axes.patches[:2]
    assert first.get_x() + first.get_width() == pytest.approx(44.5)
    assert (second.get_x(), second.get_width()) == pytest.approx((44.5, 5.5))
    assert [text.get_text() for text in axes.texts] == ["P(1;1)", "3", "aperiodic", "contact"]


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
