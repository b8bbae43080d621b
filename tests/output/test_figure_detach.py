"""The picture of detachment: every edge case, and the marks that matter."""

from math import radians
from types import SimpleNamespace

import numpy as np
import pytest

import camcli
from camcli.analysis.contact_loss.study import detach
from camcli.plots import style
from camcli.plots.detach import _views, draw_detach, joined
from camcli.scene.schema import Plot
from tests.analysis.test_detach import dwell, eccentric
from tests.conftest import chapter_system, settings
from tests.support.picture_sizes import count, pixels, tall


def drawn(system, rpms, **question):
    return draw_detach(detach(system, list(rpms), settings(1, 2), settle=1, **question), system)


@pytest.mark.slow
def test_curve_marks_and_first_detachment_are_drawn_and_the_first_range_enlarged(chapter):
    picture = drawn(chapter, np.linspace(112.0, 180.0, 41), impacts=2)
    image = pixels(picture)
    assert count(image, style.CHATTER) > 500
    assert count(image, style.DETACHMENT) > 50
    assert "first lost at 114.979326744 rpm" in picture.caption
    assert "enlarged" in picture.panels
    assert "enlarged" not in drawn(chapter, np.linspace(112.0, 138.0, 14), impacts=2).panels
    assert "enlarged" in drawn(chapter, np.linspace(114.0, 126.0, 14), impacts=2).panels


@pytest.mark.slow
@pytest.mark.parametrize(
    ("system", "said"),
    [
        (dwell(0.1), "contact is never lost"),
        (eccentric(0.1, 0.05), "contact is first lost"),
        (chapter_system(preload=-200.0), "contact is lost at every speed"),
        (chapter_system(damping=9.0), "contact is first lost"),
    ],
    ids=["never", "no corners", "always", "damped"],
)
def test_any_machine(system, said):
    picture = drawn(system, [500.0, 800.0], hold_speed=900.0)
    assert picture.caption.startswith(said)
    tall(picture)


def test_hold_to_adds_a_panel_and_no_force_leaves_one_out(chapter):
    for question, last in (
        ({}, "forces"),
        ({"hold_speed": 150.0}, "springs"),
        ({"force_speeds": ()}, "phases"),
    ):
        assert list(drawn(chapter, [112.0, 116.0], **question).panels)[-1] == last


def test_the_enlarged_part_reaches_the_first_time_a_burst_ends_at_a_corner():
    """Later bursts may end there again: those of c at 190 rpm and of f are not shown."""
    speeds = [SimpleNamespace(rpm=float(rpm), bursts=()) for rpm in range(100, 301, 10)]
    opens = SimpleNamespace(theta=radians(150.0), rpm=106.0)
    lead = SimpleNamespace(region=SimpleNamespace(name="A2"), opens=opens)
    marks = [("c", 190.0, 160.0), ("d", 137.0, 200.0), ("c", 112.0, 160.0), ("f", 240.0, 270.0)]
    study = SimpleNamespace(
        speeds=speeds, hits=[SimpleNamespace(corner="c", rpm=118.0)],
        detachment=SimpleNamespace(first=SimpleNamespace(region="A2"), losses=[lead]),
        accumulation=[SimpleNamespace(region=region, rpm=rpm, theta=radians(theta), burst="A2")
                      for region, rpm, theta in marks],
    )  # fmt: skip
    enlarged, whole = _views(study)
    assert enlarged.rpm == pytest.approx((106.0 - 0.12 * 31.0, 137.0 + 0.12 * 31.0))
    assert whole.rpm[0] < 100.0 < 300.0 < whole.rpm[1]
    assert enlarged.low < 150.0 < 200.0 < enlarged.high < 215.0


def test_ends_of_several_bursts_of_a_turn_are_lines_of_their_own():
    """Each goes on to the phase next to its last one; one that jumps too far begins another."""
    ends = [(1.0, 10.0), (1.0, 50.0), (2.0, 49.0), (2.0, 12.0), (3.0, 11.0), (4.0, 31.5)]
    assert joined(ends) == [
        [(1.0, 10.0), (2.0, 12.0), (3.0, 11.0)],
        [(1.0, 50.0), (2.0, 49.0), (4.0, 31.5)],
    ]
    assert joined([(1.0, 10.0), (2.0, 30.5)]) == [[(1.0, 10.0)], [(2.0, 30.5)]]


@pytest.mark.parametrize(("between", "lines"), [([1.5], 1), ([1.3, 1.6], 2)])
def test_a_line_of_ends_of_bursts_does_not_go_over_two_speeds_that_have_none(between, lines):
    ends = [(1.0, 10.0), (2.0, 12.0)]
    found = joined(ends, [1.0, *between, 2.0])
    assert found == ([ends] if lines == 1 else [[end] for end in ends])


def test_proved_speeds_are_marked():
    """A disk for each speed of which a proof says something, and no other; none without proofs."""

    def marked(picture):
        figure = picture.figure(Plot(panels=["phases"]))
        return [
            point
            for line in figure.axes[-1].lines
            if line.get_label() == "proved"
            for point in line.get_xydata().tolist()
        ]

    speeds = {"start": 114.0, "stop": 126.0, "num": 3}
    scene = camcli.load_scene(None, {"detach.rpm": speeds, "detach.impacts": 2})
    proved = camcli.detach(scene, prove=True)
    hits = proved.tables["corner_hits"]
    critical = proved.tables["detach"]
    first = critical["rpm"][list(critical["quantity"]).index("first_detachment")]
    wanted = [*hits["rpm"], first]
    shown = marked(proved.pictures["detach"]())
    assert sorted(rpm for rpm, _ in shown) == pytest.approx(sorted(wanted))
    assert marked(draw_detach(proved.values, proved.system)) == []
    one = marked(draw_detach(proved.values, proved.system, proved=[hits["rpm"][0]]))
    assert one == [pytest.approx([hits["rpm"][0], 160.0])]
