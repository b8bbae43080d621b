"""Pictures of basins: the right colours in the right places, bytes that repeat."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from matplotlib import image
from matplotlib.colors import to_rgb

from camcli.analysis.basins.mapping import Question, basins
from camcli.analysis.basins.study import study
from camcli.analysis.basins.window import Window
from camcli.plots import basins as figure
from camcli.plots import style
from camcli.plots.basins import area_colours, branch_colours, draw_basins, percent
from tests.conftest import settings
from tests.output.pictures import png

QUESTION = Question(Window((0.1, 0.9), (-50.0, 50.0), 30, 30))


@pytest.fixture(scope="module")
def result(chapter):
    return study(chapter, [358.5], settings(), QUESTION)


def drawn(result, system, grid=None):
    return png(draw_basins(replace(result, grid=grid or result.grid), QUESTION, system))


def window_of(png):
    """Pixels of the window: the picture without margins and legend."""
    pixels = image.imread(BytesIO(png))[:, :, :3]
    return pixels[-figure.BOTTOM - figure.HIGH : -figure.BOTTOM, figure.LEFT : -figure.RIGHT]


def test_cells_have_the_colour_of_their_attractor(result, chapter):
    pixels = window_of(drawn(result, chapter))
    areas = area_colours([attractor.label for attractor in result.speeds[0].attractors])
    for row, column in ((3, 20), (15, 25), (28, 2), (20, 5)):
        y = figure.HIGH - int((row + 0.5) / 30 * figure.HIGH)
        x = int((column + 0.5) / 30 * pixels.shape[1])
        colour = to_rgb(areas[int(result.grid.codes[row, column]) - 1])
        assert np.abs(pixels[y, x] - colour).max() < 0.01


def test_same_bytes_every_time(result, chapter):
    assert drawn(result, chapter) == drawn(result, chapter)


def test_undecided_trouble_and_below_differ_from_every_basin(result, chapter):
    codes = result.grid.codes.copy()
    codes[:, :10], codes[:, 10:20], codes[:, 20:] = -1, 0, -4
    pixels = window_of(drawn(result, chapter, replace(result.grid, codes=codes)))
    found = [pixels[100, 200 + 400 * k] for k in range(3)]
    for k, colour in enumerate((figure.BELOW, figure.UNDECIDED, figure.TROUBLE)):
        assert np.abs(found[k] - to_rgb(colour)).max() < 0.01
        assert colour not in (*style.SERIES, style.STICKING, style.CONTACT, style.APERIODIC_AREA)


def test_cells_smaller_than_pixels_are_averaged(result, chapter):
    codes = np.indices((1800, 2400)).sum(axis=0) % 2 + 1
    grid = replace(result.grid, codes=codes.astype(np.int16))
    picture = figure._pixels(grid, result.speeds[0], 1170, 900)
    assert picture.shape == (900, 1170, 3)
    areas = area_colours([attractor.label for attractor in result.speeds[0].attractors])
    mean = (np.array(to_rgb(areas[0])) + to_rgb(areas[1])) * 127.5
    assert np.abs(picture.reshape(-1, 3).mean(axis=0) - mean).max() < 1.0


def test_colours_can_be_told_apart_in_grey_and_by_marker():
    """Neighbouring periods differ in luminance, and all in the shape drawn on them."""
    light = np.array([np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722)) for colour in style.PERIODS])
    assert np.abs(np.diff(light)).min() > 0.15
    assert len(set(figure.SHAPES)) > len(style.SERIES) == len(set(style.SERIES))


def test_percent_shows_what_the_error_leaves():
    assert percent((0.17965, 0.000131)) == "(17.965 ± 0.013) %"
    assert percent((1.0, 0.0)) == "100 %"
    assert percent((0.25, 0.0031)) == "(25.00 ± 0.31) %"


def test_attractor_outside_the_window_is_said(chapter):
    result = study(chapter, [700.0], settings(), Question(QUESTION.window.with_cells(6, 6)))
    assert len(drawn(result, chapter)) > 10_000


def test_an_aperiodic_attractor_is_drawn_as_dots(chapter):
    result = study(chapter, [361.0], settings(), Question(QUESTION.window.with_cells(12, 12)))
    png = drawn(result, chapter)
    assert (window_of(png).max(axis=2) < 0.2).sum() > 300


def test_a_refined_grid_is_drawn(chapter):
    question = Question(QUESTION.window.with_cells(12, 12), refine=2)
    result = study(chapter, [358.5], settings(), question)
    assert result.grid.codes.shape == (48, 48)
    assert len(drawn(result, chapter)) > 10_000


def test_a_range_stacks_to_one(chapter):
    question = Question(QUESTION.window.with_cells(8, 8))
    result = study(chapter, [358.5, 359.0, 360.0], settings(), question)
    first, second = (png(draw_basins(result, question, chapter)) for _ in range(2))
    assert first == second
    pixels = image.imread(BytesIO(first))[:, :, :3]
    for colour in branch_colours(result).values():
        close = np.abs(pixels - np.array(to_rgb(colour))).max(axis=2) < 0.01
        assert close.sum() > 20_000


def test_basins_has_the_numbers_of_the_grid(result, chapter):
    again, _ = basins(chapter, 358.5, settings(), QUESTION)
    assert again.fractions == result.speeds[0].fractions
