"""The picture of classified motions: same bytes, every kind, events numbered where they belong."""

from dataclasses import replace
from io import BytesIO

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from camcli.analysis.classify import attractors, classify_at
from camcli.analysis.explain.changes import explain
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
from camcli.plots.sweep import draw_sweep
from tests.conftest import settings
from tests.output import pictures
from tests.output.pictures import count
from tests.output.test_figure_orbits import colour
from tests.output.test_figures import speed, sweep

RPMS = [100.0, 190.0, 358.5, 700.0, 750.0]  # contact, a rest, three turns, one turn, chaos
KINDS = ["always in contact", "periodic with rest on the cam", "periodic", "periodic", "aperiodic"]


@pytest.fixture(scope="module")
def motions(chapter):
    return [classify_at(chapter, rpm, settings(600, 200)) for rpm in RPMS]


@pytest.fixture(scope="module")
def explained(chapter):
    run = settings(600, 200)
    found = [classify_at(chapter, rpm, run) for rpm in np.linspace(700.0, 750.0, 6)]
    return found, explain(chapter, run, found).events


def event(rpm, kind="corner-hit", label="P(1;inf)", error=1e-10, **more):
    return Event(rpm, error, kind, label, **more)


def png(motions, events=(), system=None):
    return pictures.png(draw_classify(motions, system, events))


def pixels(*args):
    image = np.asarray(Image.open(BytesIO(png(*args))).convert("RGB"))
    assert image.shape[1] == style.WIDTH
    return image


def sheet(inches):
    figure = Figure(figsize=(style.WIDTH / style.DPI, inches), dpi=style.DPI)
    FigureCanvasAgg(figure)
    return figure


def panel(low, high, wide=1140, tall=300):
    axes = style.place(sheet(3.0), 140, 100, wide, tall)
    axes.set_xlim(low, high)
    return axes


def words(axes):
    return [text.get_text() for text in axes.texts]


def test_same_bytes_twice_whatever_the_user_set(chapter, explained):
    first = png(*explained, chapter)
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "axes.grid": True}):
        assert png(*explained, chapter) == first
    assert b"Software" not in first


def test_every_kind_has_its_colour(chapter, motions):
    assert [kind(motion) for motion in motions] == KINDS
    for name, motion in zip(KINDS, motions, strict=True):
        image = pixels([motion], (), chapter)
        if name != CONTACT:
            assert count(image, colour(COLOURS[name])) > 100
        others = [COLOURS[other] for other in set(KINDS) - {name, CONTACT}]
        for other in set(others) - {style.IMPACT, strip_colour(motion)}:
            assert count(image, colour(other)) == 0


def test_a_motion_that_is_not_solved_is_undecided(motions):
    unsolved = replace(motions[2], orbit=None, exponents=None, label="undecided")
    assert count(pixels([unsolved]), colour(COLOURS["undecided"])) > 100
    assert remark([], 1) == "not known for 1 of 1 motions"


def test_any_order_is_the_ascending_picture(motions):
    assert png(motions[::-1]) == png(motions)


def test_several_motions_at_one_speed_and_at_every_speed(chapter):
    run = settings(600, 200)
    found = {rpm: attractors(chapter, rpm, run, 24, 0) for rpm in (358.5, 371.0)}
    assert min(map(len, found.values())) > 1
    pixels(found[358.5], (), chapter)
    pixels([motion for some in found.values() for motion in some], (), chapter)
    axes = panel(355.0, 375.0)
    draw_strip(axes, found[358.5], [365.0] * len(found[358.5]))
    heights = [patch.get_height() for patch in axes.patches]
    assert heights == pytest.approx([1.0 / len(heights)] * len(heights))


def test_a_record_that_ended_early_is_marked(motions):
    red = colour(style.TROUBLE)
    assert count(pixels(motions), red) == 0
    assert (
        count(pixels([*motions, replace(motions[0], rpm=400.0, status=Status.IMPACT_BUDGET)]), red)
        > 10
    )


# --- exponents


def test_exponents_have_bars_and_minus_infinity_has_words():
    def growth(x, largest, spread):
        return Growth(x, Exponents(largest, -1.0, spread, 0.0, 1.0), style.FLIGHT)

    axes = panel(0.0, 4.0)
    known = [growth(1.0, 0.5, 0.2), growth(2.0, -0.25, 0.0), growth(3.0, -np.inf, 0.0)]
    draw_growth(axes, known)
    assert words(axes) == [FORGETS]
    assert axes.get_yticklabels()[0].get_text() == "−∞"
    low, high = axes.get_ylim()
    assert low < -0.25 < 0.7 < high
    assert [0.3, 0.7] in [list(line.get_ydata()) for line in axes.lines]
    assert remark(known, 3) == "bars: ± one standard error"
    axes = panel(0.0, 4.0)
    draw_growth(axes, [*known[:2], growth(3.0, 0.1, np.inf)])
    assert words(axes) == []
    draw_growth(panel(0.0, 4.0), [])
    draw_growth(panel(0.0, 4.0), known[2:])


# --- labels


def test_the_strip_joins_equal_labels_and_names_wide_ones(motions):
    contact, rest, three, one, chaos = motions
    axes = panel(0.0, 100.0)
    draw_strip(axes, [one, one, three, chaos, rest, contact], [10.0, 40.0, 49.0, 51.0, 53.0, 98.0])
    first, second = axes.patches[:2]
    assert (first.get_x(), first.get_width()) == pytest.approx((0.0, 44.5))
    assert colour(strip_colour(one)) == colour(style.PERIODS[0])
    assert second.get_facecolor()[:3] == pytest.approx(matplotlib.colors.to_rgb(style.PERIODS[2]))
    assert words(axes) == ["P(1;1)", "3", "P(1;∞)", "contact"]
    assert strip_colour(chaos) == OTHERS["aperiodic"]


@pytest.mark.parametrize(
    ("wide", "expected"), [(200, ["P(3;3:3:2)"]), (95, ["period 3"]), (30, ["3"]), (16, [])]
)
def test_a_label_too_wide_for_its_place_gives_way_to_the_period(motions, wide, expected):
    with matplotlib.rc_context(style.RC):
        axes = panel(0.0, 1.0, wide)
        draw_strip(axes, [motions[2]], [0.5])
    assert words(axes) == expected


# --- events


def test_events_are_listed_in_order_with_nine_digits(explained):
    *exact, crisis = numbered(explained[1][::-1])
    rows = [(e.number, e.name, e.speed, e.verdict) for e in exact]
    assert rows == [
        (1, "period doubling", "739.319780", ""),
        (2, "corner impact at c", "739.377930", "border period doubling"),
    ]
    assert (crisis.number, crisis.name) == (3, "interior crisis at c")
    speed, error = crisis.speed.split(" ± ")  # of an estimate: as many digits as its error has
    assert len(speed.partition(".")[2]) == len(error.partition(".")[2])
    assert abs(float(speed) - 740.10648) < float(error) < 1e-2


def test_names_and_digits():
    one = Numbered(1, event(151.51, "accumulation-at-corner", corner="f", status="unresolved"))
    assert (one.name, one.verdict) == ("accumulation at corner f", "unresolved")
    assert Numbered(1, event(198.5605114, "chatter-completion", corner="A2")).speed == "198.560511"
    assert Numbered(1, event(198.5605114, error=0.02)).speed == "198.56 ± 0.02"
    assert Numbered(1, event(1198.5605114, error=30.0)).speed == "1199 ± 30"
    assert Numbered(1, event(1e-3, error=np.inf)).speed == "0.00100000000"


def test_beyond_the_list_minor_events_lose_their_numbers_first():
    many = [event(100.0 + k) for k in range(MOST + 5)]
    major = event(200.0, "fold", "P(1;1)")
    found = numbered([*many, major])
    assert [one.number for one in found if one.number] == list(range(1, MOST + 1))
    assert found[-1].number == MOST
    assert sum(one.number is None for one in found) == 6


@pytest.mark.parametrize("many", [1, 3, SINGLE, SINGLE + 1, MOST, MOST + 9])
@pytest.mark.parametrize("verdict", ["", "border-period-doubling"])
def test_the_list_does_not_run_into_itself(many, verdict):
    long = "P(96;" + ":".join(["3"] * 96) + ")"
    events = [
        event(
            111.111 + 33.3 * k, "accumulation-at-corner", long, corner="f", classification=verdict
        )
        for k in range(many)
    ]
    figure = sheet(12.0)
    with matplotlib.rc_context(style.RC):
        draw_list(figure, 10, numbered(events))
        texts = [text for text in figure.axes[0].texts if text.get_text()]
        boxes = [text.get_window_extent() for text in texts]
    assert not [a for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
    assert max(box.x1 for box in boxes) <= style.WIDTH
    assert min(box.y0 for box in boxes) >= 12 * style.DPI - 10 - list_height(numbered(events))
    assert ("and 9 more" in texts[-1].get_text()) == (many > MOST)


@pytest.mark.parametrize("rpms", [
    np.linspace(0.0, 1e-3, 9), np.linspace(0.99, 1.0, 20), np.linspace(0.0, 0.2, MOST),
    np.linspace(0.4, 1.0, CROWDED + 1), [0.5],
])  # fmt: skip
def test_numbers_stay_apart_and_within_the_panel(rpms):
    axes = panel(0.0, 1.0, 900)
    with matplotlib.rc_context(style.RC):
        event_numbers(axes, list(enumerate(rpms, 1)))
        boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == len(rpms)
    assert not [a for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
    inside = axes.get_window_extent()
    assert min(box.x0 for box in boxes) >= inside.x0 - 20
    assert max(box.x1 for box in boxes) <= inside.x1 + 20


def test_events_make_the_picture_taller_and_dotted(chapter, explained):
    motions, events = explained
    assert pixels(motions, events).shape[0] > pixels(motions).shape[0] + 100
    assert pixels(motions, events * 40).shape[0] < pixels(motions).shape[0] + 1000


# --- a sweep with events


def test_a_sweep_without_events_is_the_picture_it_was(chapter):
    it = sweep(speed(700.0, [150.0], [2.0]), speed(760.0, [151.0], [2.1]))
    drawn = [
        pictures.png(draw_sweep(it, chapter, settings(), some)) for some in ((), [event(739.3)])
    ]
    assert drawn[0] == pictures.png(draw_sweep(it, chapter, settings()))
    tall = [Image.open(BytesIO(data)).size[1] for data in drawn]
    assert tall[1] > tall[0] + 100
