"""The picture of chaos against boxes and images that were made by hand."""

import numpy as np
import pytest
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.text import Annotation, Text

from camcli.analysis.chaos.section import Chaos, ChaosView, Lands, SectionBox
from camcli.exact.shooting import ProofStep
from camcli.plots.chaos import NEAR, draw_chaos
from camcli.scene.schema import Plot
from tests.support.picture_reader import Panel
from tests.support.picture_sizes import check_texts

RPM = 600.0
OMEGA = 20.0 * np.pi
UNIT = np.array([[-1.0, 1.0, 1.0, -1.0], [-1.0, -1.0, 1.0, 1.0]])
MIDDLES = np.array([[2.0, 0.5], [2.5, 0.4]])
AXES = (((0.1, 0.02), (-0.03, 0.05)), ((0.05, 0.0), (0.0, 0.01)))
IMPACTS = np.array([[2.0, 2.4], [0.5, 0.45]])
STRETCHED = np.array([[5.0], [0.5]])  # of the second box's half widths


def made() -> tuple[Chaos, ChaosView]:
    """Two boxes, of which the first one covers the second, far beyond its ends."""
    lands = Lands(2, 1, 2.0, 2.6)
    boxes = tuple(
        SectionBox(2, (theta, v), axes, lands)
        for (theta, v), axes in zip(MIDDLES.tolist(), AXES, strict=True)
    )
    chaos = Chaos(RPM, "P(1;1)", boxes, ((0, 1),), growth=1.5)
    outlines = [
        middle[:, None] + np.array(m) @ UNIT for middle, m in zip(MIDDLES, AXES, strict=True)
    ]
    image = MIDDLES[1][:, None] + np.array(AXES[1]) @ (UNIT * STRETCHED)
    return chaos, ChaosView(IMPACTS, tuple(outlines), (image, outlines[1]))


def panels(chaos: Chaos, view: ChaosView) -> list[Panel]:
    """The two panels of the picture."""
    figure = draw_chaos(chaos, view).figure()
    drawn = [axes for axes in figure.axes if axes.get_xlabel() or axes.get_ylabel()]
    return [Panel(name, axes) for name, axes in zip(("boxes", "coverings"), drawn, strict=True)]


def shown(points) -> np.ndarray:
    """Points (theta, v) in deg and m/s, a row each."""
    return np.column_stack([np.degrees(points[0]), points[1] * OMEGA])


def test_boxes_images_and_simulated_impacts_stand_where_they_are():
    chaos, view = made()
    panel = panels(chaos, view)[0]
    found = panel.pick(Polygon, count=2)
    for polygon, outline in zip(found, view.outlines, strict=True):
        assert polygon.get_xy()[:4] == pytest.approx(shown(outline))
    lines = panel.pick(Line2D, count=5)
    for line, points in zip(lines, (IMPACTS, *view.images), strict=False):
        assert np.array(line.get_xydata()) == pytest.approx(shown(points))
    assert [line.get_label() for line in (lines[0], *lines[3:])] == [
        "simulated impacts",
        "boxes (filled)",
        "images: where flights land (outline)",
    ]
    assert not any(len(line.get_xdata()) for line in lines[3:])
    above = [lines[0].get_zorder() > other.get_zorder() for other in (*found, *lines[1:3])]
    assert all(above)  # the attractor is seen within the boxes
    numbers = panel.pick(Annotation, count=2)
    assert [(one.get_text(), one.xy) for one in numbers] == [
        (str(k + 1), pytest.approx(tuple(shown(middle)[0]))) for k, middle in enumerate(MIDDLES)
    ]
    panel.reads("x", r"cam angle $\theta$ (deg)")
    panel.reads("y", "rebound velocity (m/s)")
    panel.done()


def test_a_covering_is_drawn_in_the_coordinates_of_the_covered_box_and_cut():
    panel = panels(*made())[1]
    (square,) = panel.pick(Polygon, count=1)
    assert np.array(square.get_xy())[:4] == pytest.approx(UNIT.T)
    (line,) = panel.pick(Line2D, count=1)
    assert np.array(line.get_xydata()) == pytest.approx((UNIT * STRETCHED).T)
    bounds = panel.axes.transData.inverted().transform_bbox(line.clipbox)
    assert (bounds.x0, bounds.x1) == pytest.approx((-NEAR, NEAR))
    assert [text.get_text() for text in panel.pick(Text)] == ["1 to 2"]
    panel.reads("x", "x (expanding) from −1 to 1 in each box")
    panel.reads("y", "y (contracting)")
    panel.done()


def test_without_boxes_the_picture_says_so():
    chaos = Chaos(RPM, step=ProofStep.NO_CHAIN)
    picture = draw_chaos(chaos, ChaosView(IMPACTS))
    assert picture.title == "Chaos not proved at 600 rpm"
    texts = [text.get_text() for axes in picture.figure().axes for text in axes.texts]
    assert "no boxes were found" in texts


def test_the_section_is_taller_than_its_coverings():
    heights = {name: panel.height for name, panel in draw_chaos(*made()).panels.items()}
    assert heights == {"boxes": 95.0, "coverings": 55.0}  # mm


@pytest.mark.parametrize("width", [85.0, 170.0])
def test_no_two_texts_overlap_and_none_leaves_the_page(width):
    for picture in (
        draw_chaos(*made()),
        draw_chaos(Chaos(RPM, step=ProofStep.NO_CHAIN), ChaosView(IMPACTS)),
    ):
        check_texts(picture.figure(Plot(width=width)))
