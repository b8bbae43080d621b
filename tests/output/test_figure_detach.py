"""The picture of detachment: same bytes, every edge case, and the marks that matter."""

from io import BytesIO

import matplotlib
import numpy as np
import pytest
from PIL import Image

from camcli.analysis.contact_loss.study import detach
from camcli.plots import style
from camcli.plots.detach import draw_detach
from tests.analysis.test_detach import dwell, eccentric
from tests.conftest import chapter_system, settings
from tests.output import pictures

PURPLE, GREEN, BLACK = (0xCC, 0x79, 0xA7), (0x00, 0x9E, 0x73), (0, 0, 0)


def found(system, rpms, **question):
    return detach(system, list(rpms), settings(), settle=1, **question)


def png(result, system):
    return pictures.png(draw_detach(result, system))


def pixels(result, system):
    image = np.asarray(Image.open(BytesIO(png(result, system))).convert("RGB"))
    assert image.shape[1] == style.WIDTH
    return image


def count(image, colour):
    return int((image == colour).all(axis=2).sum())


@pytest.fixture(scope="module")
def result(chapter):
    return found(chapter, np.linspace(112.0, 180.0, 41), impacts=2)


def test_same_bytes_twice_whatever_the_user_set(chapter, result):
    first = png(result, chapter)
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "axes.grid": True}):
        assert png(result, chapter) == first
    assert b"Software" not in first


def test_curve_marks_and_first_detachment_are_drawn(chapter, result):
    image = pixels(result, chapter)
    assert count(image, PURPLE) > 500
    assert count(image, GREEN) > 50
    bare = found(chapter, [100.0, 105.0])
    assert count(pixels(bare, chapter), PURPLE) < count(image, PURPLE) / 2


def test_the_first_chattering_range_is_enlarged_only_where_it_is_small(chapter, result):
    close = found(chapter, np.linspace(112.0, 138.0, 41), impacts=2)
    assert pixels(result, chapter).shape[0] > pixels(close, chapter).shape[0] + 400
    flat = found(chapter, np.linspace(114.0, 126.0, 41), impacts=2)
    assert pixels(flat, chapter).shape[0] > pixels(close, chapter).shape[0] + 400


def test_hold_to_adds_a_panel(chapter, result):
    more = found(chapter, [112.0, 116.0], hold_rpm=150.0)
    less = found(chapter, [112.0, 116.0])
    assert pixels(more, chapter).shape[0] > pixels(less, chapter).shape[0] + 400


@pytest.mark.parametrize("rpms", [[150.0], [200.0, 110.0], [50.0, 60.0]])
def test_any_range(chapter, rpms):
    pixels(found(chapter, rpms), chapter)


@pytest.mark.parametrize(
    "system",
    [dwell(0.1), eccentric(0.1, 0.05), chapter_system(preload=-200.0), chapter_system(damping=9.0)],
    ids=["never", "no corners", "always", "damped"],
)
def test_any_machine(system):
    pixels(found(system, [500.0, 800.0], hold_rpm=900.0), system)


def test_no_force_curves(chapter):
    pixels(found(chapter, [112.0, 116.0], force_rpm=()), chapter)
