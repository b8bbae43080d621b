"""Pictures of basins: the right colours in the right places."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.study import Question, study
from camcli.analysis.basins.window import Window
from camcli.plots import style
from camcli.plots.basins import area_colours, branch_colours, draw_basins, percent
from tests.conftest import settings
from tests.output.pictures import count, pixels, words

QUESTION = Question(Window((0.1, 0.9), (-50.0, 50.0), 30, 30))


@pytest.fixture(scope="module")
def result(chapter):
    return study(chapter, [358.5], settings(), QUESTION)


def drawn(result, system, codes=None):
    if codes is not None:
        result = replace(result, speeds=(replace(result.grids[0], codes=codes.astype(np.int16)),))
    return draw_basins(result, QUESTION, system)


def test_cells_have_the_colour_of_their_attractor(result, chapter):
    picture = drawn(result, chapter)
    (image,) = picture.figure().axes[1].images
    areas = area_colours([a.label for a in result.speeds[0].attractors], largest=1)
    expected = np.array([to_rgb(colour) for colour in areas])[result.grids[0].codes - 1]
    assert np.abs(image.get_array() / 255.0 - expected).max() < 0.01
    assert image.get_extent() == [0.1, 0.9, -50.0, 50.0]
    shown = pixels(picture)
    assert all(count(shown, colour) > 100_000 for colour in areas)


def test_undecided_trouble_and_below_are_no_basins(result, chapter):
    codes = result.grids[0].codes.copy()
    codes[:, :10], codes[:, 10:20], codes[:, 20:] = -1, 0, -4
    shown = pixels(drawn(result, chapter, codes))
    others = style.CAM_BODY, style.UNDECIDED, style.TROUBLE
    assert all(count(shown, colour) > 100_000 for colour in others)


def luminance(colour):
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_two_basins_have_a_contrast_of_three_to_one():
    for labels, largest in ((["P(1;2)", "P(3;3:3:2)"], 1), (["P(1;1)", "aperiodic"], 0)):
        low, high = sorted(map(luminance, area_colours(labels, largest)))
        assert (high + 0.05) / (low + 0.05) >= 3.0


def test_percent_shows_what_the_error_leaves():
    assert percent((0.17965, 0.000131)) == "(17.965 ± 0.013) %"
    assert percent((1.0, 0.0)) == "100 %"
    assert percent((0.25, 0.0031)) == "(25.00 ± 0.31) %"


def test_aperiodic_attractors_are_dots_and_those_outside_the_window_are_said(result, chapter):
    spots = np.column_stack([np.linspace(0.2, 0.8, 900), np.zeros(900)])
    dots = Attractor("aperiodic", 0, (), points=spots)
    speed = result.speeds[0]
    away = replace(speed.attractors[1], states=((9.0, 0.0),), turns=1)
    changed = replace(speed, attractors=[dots, away, *speed.attractors[2:]])
    picture = drawn(replace(result, speeds=[changed]), chapter)
    lines = picture.figure().axes[1].lines
    assert max(len(line.get_xdata()) for line in lines) == 900
    assert sum("outside the window" in text for text in words(picture)) == 1


@pytest.mark.slow
def test_a_range_stacks_to_one(chapter):
    question = Question(QUESTION.window.with_cells(8, 8))
    result = study(chapter, [358.5, 359.0, 360.0, 361.0], settings(), question)
    picture = draw_basins(result, question, chapter)
    bars = picture.figure().axes[1].patches
    assert sum(bar.get_width() * bar.get_height() for bar in bars) == pytest.approx(3.25)
    image = pixels(picture)
    assert all(count(image, colour) > 20_000 for colour in branch_colours(result).values())
