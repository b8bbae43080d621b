"""Pictures of basins: the right colours in the right places."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.study import Question, study
from camcli.analysis.basins.window import Window
from camcli.plots import basins as picture
from camcli.plots import style
from camcli.plots.basins import area_colours, branch_colours, draw_basins, percent
from tests.conftest import settings
from tests.output.pictures import count, pixels, words

QUESTION = Question(Window((0.1, 0.9), (-50.0, 50.0), 30, 30))


@pytest.fixture(scope="module")
def result(chapter):
    return study(chapter, [358.5], settings(), QUESTION)


def window_of(figure):
    """Pixels of the window: the picture without margins and legend."""
    low, right = style.BOTTOM, style.RIGHT
    return pixels(figure)[-low - picture.HIGH : -low, style.LEFT : -right] / 255.0


def drawn(result, system, codes=None):
    if codes is not None:
        result = replace(result, speeds=(replace(result.grid, codes=codes.astype(np.int16)),))
    return draw_basins(result, QUESTION, system)


def test_cells_have_the_colour_of_their_attractor(result, chapter):
    window = window_of(drawn(result, chapter))
    areas = area_colours([attractor.label for attractor in result.speeds[0].attractors])
    for row, column in ((3, 20), (15, 25), (28, 2), (20, 5)):
        y = picture.HIGH - int((row + 0.5) / 30 * picture.HIGH)
        x = int((column + 0.5) / 30 * window.shape[1])
        colour = to_rgb(areas[int(result.grid.codes[row, column]) - 1])
        assert np.abs(window[y, x] - colour).max() < 0.01


def test_undecided_trouble_and_below_differ_from_every_basin(result, chapter):
    codes = result.grid.codes.copy()
    codes[:, :10], codes[:, 10:20], codes[:, 20:] = -1, 0, -4
    window = window_of(drawn(result, chapter, codes))
    for k, colour in enumerate((picture.BELOW, picture.UNDECIDED, picture.TROUBLE)):
        assert np.abs(window[100, 200 + 400 * k] - to_rgb(colour)).max() < 0.01
        assert colour not in (*style.SERIES, style.STICKING, style.CONTACT, style.APERIODIC_AREA)


def test_cells_smaller_than_pixels_are_averaged(result, chapter):
    codes = np.indices((1800, 2400)).sum(axis=0) % 2 + 1  # as of a grid that was refined
    window = window_of(drawn(result, chapter, codes))
    areas = area_colours([attractor.label for attractor in result.speeds[0].attractors])
    mean = (np.array(to_rgb(areas[0])) + to_rgb(areas[1])) / 2.0
    assert np.abs(np.median(window.reshape(-1, 3), axis=0) - mean).max() < 0.01


def test_colours_can_be_told_apart_in_grey_and_by_marker():
    """Neighbouring periods differ in luminance, and all in the shape drawn on them."""
    light = np.array([np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722)) for colour in style.PERIODS])
    assert np.abs(np.diff(light)).min() > 0.15
    assert len(set(picture.SHAPES)) > len(style.SERIES) == len(set(style.SERIES))


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
    figure = drawn(replace(result, speeds=[changed]), chapter)
    assert (window_of(figure).max(axis=2) < 0.2).sum() > 300
    assert sum("outside the window" in text for text in words(figure)) == 1


def test_a_range_stacks_to_one(chapter):
    question = Question(QUESTION.window.with_cells(8, 8))
    result = study(chapter, [358.5, 359.0, 360.0], settings(), question)
    image = pixels(draw_basins(result, question, chapter))
    shown = list(branch_colours(result).values())
    assert all(count(image, colour) > 20_000 for colour in shown)
    stack = picture.STACK * style.WIDE
    assert sum(count(image, colour) for colour in shown) > 0.98 * stack
