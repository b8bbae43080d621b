"""Pictures of basins: the right colours in the right places."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.study import BasinsQuestion, study
from camcli.analysis.basins.window import Window
from camcli.plots import style
from camcli.plots.basins import _in_lines, area_colours, draw_basins, percent
from tests.conftest import settings
from tests.support.picture_sizes import count, label_of, pixels, words

QUESTION = BasinsQuestion(Window((0.1, 0.9), (-50.0, 50.0), 30, 30))


@pytest.fixture(scope="module")
def result(chapter):
    return study(chapter, [358.5], settings(), QUESTION)


def drawn(result, system, codes=None):
    if codes is not None:
        result = replace(result, speeds=(replace(result.grids[0], codes=codes.astype(np.int16)),))
    return draw_basins(result, QUESTION, system)


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
        low, high = sorted(map(luminance, area_colours(list(map(label_of, labels)), largest)))
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
    regions = [None, None, *speed.regions[2:]]
    changed = replace(speed, attractors=[dots, away, *speed.attractors[2:]], regions=regions)
    picture = drawn(replace(result, speeds=[changed]), chapter)
    lines = picture.figure().axes[1].lines
    assert max(len(line.get_xdata()) for line in lines) == 900
    assert sum("outside the window" in text for text in words(picture)) == 1


def test_no_mark_and_no_ellipse_stands_outside_the_window(result, chapter):
    speed = result.speeds[0]
    window = Window((0.1, 0.3), (30.0, 50.0), speed.window.nq, speed.window.nv)
    picture = draw_basins(
        replace(result, speeds=(replace(speed, window=window),)), QUESTION, chapter
    )
    axes = picture.figure().axes[1]
    for line in axes.lines:
        if line.get_marker() not in ("None", "."):
            assert ((line.get_xdata() >= 0.1) & (line.get_xdata() <= 0.3)).all()
            assert ((line.get_ydata() >= 30.0) & (line.get_ydata() <= 50.0)).all()
    box = axes.get_tightbbox()
    assert box.x1 < axes.get_window_extent().x1 + 0.1 * axes.get_window_extent().width


@pytest.mark.parametrize(("labels", "lines"), [
    (["P(1;1)"], ["7: P(1;1)"]),
    (["P(1;1)", "P(1;2)", "P(1;1)"], ["7: P(1;1), P(1;2)"]),
    (["P(1;1)", "P(1;2)", "contact"], ["7: P(1;1), P(1;2)", "contact"]),
    (["P(1;1)", "P(1;2)", "contact", "P(1;3)"],
     ["7: P(1;1), P(1;2)", "contact and 1 more label"]),
    ([f"P(1;{k})" for k in range(1, 7)], ["7: P(1;1), P(1;2)", "P(1;3) and 3 more labels"]),
])  # fmt: skip
def test_the_labels_of_a_branch_stand_in_lines_of_two(labels, lines):
    assert _in_lines(7, labels) == lines
