"""The picture of periodic orbits: same bytes, every kind of study, and the lines that matter."""

from dataclasses import replace
from io import BytesIO

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from camcli.analysis.integrate import Cost
from camcli.analysis.orbits.arclength import Span
from camcli.analysis.orbits.shooter import PARAMETERS
from camcli.analysis.orbits.study import Absence, OrbitsResult, Question, orbits
from camcli.plots import style
from camcli.plots.multipliers import FURTHEST, draw_paths, draw_plane, draw_real
from camcli.plots.orbit_keys import LONGEST, UNITS, draw_lists
from camcli.plots.orbit_lines import (
    MARKS,
    branch_colours,
    curved,
    draw,
    events,
    paths,
    phases,
    positions,
    strands,
)
from camcli.plots.orbit_zoom import zooms
from camcli.plots.orbits import NAMES, axis_name, draw_orbits, heading
from tests.conftest import settings
from tests.output import pictures
from tests.output.pictures import count

QUESTIONS = {
    "doubling": Question(700.0, span=Span(672.0, 756.0, 0.84)),
    "fold": Question(358.5, span=Span(350.0, 385.0, 0.6)),
    "resting": Question(190.0, span=Span(110.0, 205.0, 2.0)),
    "restitution": Question(700.0, parameter="restitution", span=Span(0.5, 1.0, 0.02)),
    "contact": Question(100.0, span=Span(90.0, 110.0, 2.0)),
    "one speed": Question(700.0),
    "eight impacts": Question(358.5),
    "at rest": Question(190.0),
}


@pytest.fixture(scope="module")
def found(chapter):
    return {name: orbits(chapter, settings(600), ask) for name, ask in QUESTIONS.items()}


@pytest.fixture(scope="module")
def corners(chapter):
    return style.corner_names(chapter.corners_deg)


def png(result, system):
    return pictures.png(draw_orbits(result, system))


def pixels(result, system):
    image = np.asarray(Image.open(BytesIO(png(result, system))).convert("RGB"))
    assert image.shape[1] == style.WIDTH
    return image


def colour(name):
    return tuple(round(255 * part) for part in to_rgb(name))


def panel():
    return Figure(figsize=(6, 6)).add_subplot()


def test_same_bytes_twice_whatever_the_user_set(chapter, found):
    first = png(found["doubling"], chapter)
    with matplotlib.rc_context({"font.size": 20, "savefig.dpi": 50, "axes.grid": True}):
        assert png(found["doubling"], chapter) == first
    assert b"Software" not in first


@pytest.mark.parametrize("name", QUESTIONS)
def test_every_kind_of_study_shows_its_colours(chapter, found, name):
    result = found[name]
    image = pixels(result, chapter)
    rests = any(orbit.resting for orbit in result.orbits)
    assert count(image, colour(style.STICKING if rests else style.FLIGHT)) > 100
    assert count(image, colour(style.FLIGHT if rests else style.STICKING)) == 0


@pytest.mark.parametrize("span", [None, Span(600.0, 700.0, 1.0)])
def test_a_study_without_orbits_says_so(chapter, span):
    nothing = OrbitsResult(Question(700.0, span=span), 700.0, [], [], [], [], Cost())
    assert pixels(nothing, chapter).shape[0] < 500


def test_where_an_absent_label_exists_is_said(chapter, found):
    ask = Question(700.0, label="P(4;1)")
    nothing = OrbitsResult(ask, 700.0, [], [], [], [], Cost(), Absence(700.0, 650.0, 750.0))
    near = Absence(700.0, 650.0, 750.0, None, (712.3, "corner-impact"))
    assert png(nothing, chapter) != png(replace(nothing, absent=near), chapter)
    assert "none at 700 rpm" in heading(replace(found["doubling"], absent=near))[1][0]


@pytest.mark.parametrize("parameter", PARAMETERS)
def test_every_parameter_has_a_name_and_a_unit(found, parameter):
    ask = replace(QUESTIONS["doubling"], parameter=parameter)
    changed = replace(found["doubling"], question=ask)
    assert axis_name(parameter) == f"{NAMES[parameter]} ({UNITS[parameter] or '-'})"
    assert NAMES[parameter] in heading(changed)[0][0] or parameter == "rpm"


def test_stable_parts_are_solid_and_unstable_ones_dashed(found):
    first = found["doubling"].branches[0]
    lines = strands(first.points, phases, 360.0)
    assert [line.stable for line in lines] == [True, False]
    assert lines[0].x[-1] == lines[1].x[0] == pytest.approx(739.31978, abs=1e-5)
    axes = panel()
    draw(axes, lines, style.FLIGHT)
    assert [line.get_linestyle() for line in axes.lines] == ["-", "--"]
    second = found["doubling"].branches[1]
    assert [line.stable for line in strands(second.points, positions)] == [False]


def test_a_line_per_impact_through_every_point(found):
    for branch in found["fold"].branches:
        lines = strands(branch.points, phases, 360.0)
        steps = sum(len(line.x) - 1 for line in lines)
        assert steps == (len(branch.points) - 1) * branch.points[0].impacts
        assert max(abs(np.diff(line.y)).max() for line in lines) < 10.0


def test_lines_break_where_a_departure_appears_and_where_a_phase_wraps(found):
    lines = strands(found["resting"].branches[0].points, phases, 360.0)
    assert len(lines) == 2
    points = found["doubling"].branches[0].points[:60]
    wrapped = strands(points, lambda orbit: [(orbit.value * 15.0) % 360.0], 360.0)
    assert len(wrapped) > 1
    assert max(abs(np.diff(line.y)).max() for line in wrapped) < 180.0


def test_paths_of_multipliers_are_fine_and_break_at_corners(found):
    first, _, third = found["doubling"].branches
    complex_pairs = paths(first.points)[0]
    assert abs(np.diff(complex_pairs.y)).max() < 0.1
    before, after = paths(third.points)[0], paths(third.points)[-1]
    assert before.stable
    assert not after.stable
    assert before.x[-1] == pytest.approx(after.x[0], rel=1e-10)
    assert abs(before.y[-1] - after.y[0]) > 0.1


def test_arrows_point_to_the_rising_parameter(found):
    points = found["doubling"].branches[1].points  # its larger multiplier grows with the speed
    for order in (points, points[::-1]):
        axes = panel()
        draw_plane(axes, 3.0)
        draw_paths(axes, paths(order), style.FLIGHT, 0.5)
        larger = max(axes.texts, key=lambda arrow: arrow.xy[0])
        assert larger.xy[0] > larger.xyann[0]


def test_huge_multipliers_are_cut_in_the_plane_and_squeezed_beside_it(chapter, found):
    result = found["doubling"]
    points = [replace(p, trace=p.trace * 1e5, root=None) for p in result.branches[1].points]
    axes = panel()
    draw_plane(axes, 1e5)
    assert axes.get_xlim() == (-FURTHEST, FURTHEST)
    assert f"{FURTHEST:g}" in axes.get_xlabel()
    axes = panel()
    draw_real(axes, [paths(points)], [style.FLIGHT])
    assert axes.get_yscale() == "asinh"
    assert "asinh" in axes.get_ylabel()
    huge = [replace(result.branches[1], points=tuple(points))]
    pixels(replace(result, branches=huge, bifurcations=[]), chapter)


def test_events_are_listed_once_in_order_with_all_branches(found, corners):
    listed = events(found["doubling"].bifurcations, corners)
    assert [event.name for event in listed] == [
        "corner impact at b", "period doubling", "corner impact at c",
    ]  # fmt: skip
    assert [event.branches for event in listed] == [(1, 2), (1,), (3,)]
    assert listed[1].leaves == (3,)
    assert listed[2].phases == (corners["c"],)
    for result in found.values():
        assert {event.kind for event in result.bifurcations} <= set(MARKS)


def test_only_a_hidden_corner_impact_is_enlarged(chapter, found, corners):
    def close(name):
        result = found[name]
        return zooms(result.branches, events(result.bifurcations, corners), corners)

    (zoom,) = close("doubling")
    assert zoom.event.source.corner == "c"
    assert zoom.x[0] < 739.3198 < 739.3779 < zoom.x[1]
    assert [zoom.event.source.label for zoom in close("fold")] == ["P(2;2:2)"]
    assert not close("restitution")
    assert not close("resting")


def test_the_enlarged_fork_is_round(found):
    points = found["doubling"].branches[2].points
    fine = curved(points, 739.3, 739.45)
    assert len(fine) > len(points) + 10
    start, corner = points[0].value, 739.3779296
    inner = [p for p in fine if start < p.value < corner]
    share = [abs(phases(p)[0] - phases(points[0])[0]) / (p.value - start) ** 0.5 for p in inner[3:]]
    assert max(share) < 1.3 * min(share)


def test_many_branches_and_events_keep_to_the_page(chapter, found):
    result, last = found["fold"], found["fold"].branches[-1]
    branches = [replace(last, number=n, ends=("lost", "lost")) for n in range(1, 41)]
    more = [replace(b, value=b.value + 1e-3 * k) for k in range(4) for b in result.bifurcations]
    few = [replace(branch, points=branch.points[::20]) for branch in branches]
    image = pixels(replace(result, branches=few, bifurcations=more), chapter)
    assert image.shape[0] < 4000
    assert len(set(branch_colours(branches))) == 6
    figure = Figure(figsize=(style.WIDTH / style.DPI, 10), dpi=style.DPI)
    draw_lists(figure, 0, branches, branch_colours(branches), events(more, {}), "rpm")
    words = [text.get_text() for text in figure.axes[0].texts]
    assert f"and {40 - LONGEST} more, in the tables" in words


def test_lists_do_not_run_into_one_another(found, corners):
    for name in ("fold", "resting", "restitution"):
        result = found[name]
        figure = Figure(figsize=(style.WIDTH / style.DPI, 10), dpi=style.DPI)
        listed = events(result.bifurcations, corners)
        looks = branch_colours(result.branches)
        with matplotlib.rc_context(style.RC):
            draw_lists(figure, 0, result.branches, looks, listed, result.question.parameter)
            boxes = [text.get_window_extent() for text in figure.axes[0].texts if text.get_text()]
        clashes = [a for k, a in enumerate(boxes) for b in boxes[:k] if a.overlaps(b)]
        assert not [a for a in clashes if a.height]
        assert max(box.x1 for box in boxes) <= style.WIDTH
