"""Numbers on the branches of a diagram and on paths of multipliers, arrows, and zooms.

Each distance that decides where they stand, or whether they do, has a case just within it and one
just beyond. Lengths are pt in panels whose data count points, or shares of half a plane.
"""

from __future__ import annotations

from types import SimpleNamespace as Made

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from camcli.analysis.orbits.kinds import Kind
from camcli.plots.axes import number_events, places_beside
from camcli.plots.branch_lines import (
    Strand,
    draw_outside,
    draw_paths,
    draw_plane,
    number_pairs,
    steady,
    strands,
)
from camcli.plots.orbits import _over_parameter, hidden, number_branches

WIDE, HIGH = 400.0, 300.0


def panel(wide=WIDE, high=HIGH):
    """Axes of so many pt whose data count points."""
    figure = Figure(figsize=(wide / 57.6, high / 57.6), dpi=300)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    axes.set(xlim=(0.0, wide), ylim=(0.0, high))
    return axes


# --- branches


def numbered(*lines, events=()):
    """Where the numbers of branches stand, each a line of places, by their number."""
    axes = panel()
    strands = [[Strand(True, *map(list, zip(*line, strict=True)))] for line in lines]
    branches = [Made(number=k + 1) for k in range(len(lines))]
    told = [Made(value=x, phases=(y,)) for x, y in events]
    number_branches(axes, strands, branches, ["#000000"] * len(lines), told)
    return {int(text.get_text()): text.get_position() for text in axes.texts}


def level(y, low=20.0, high=380.0, count=181):
    return [(x, y) for x in np.linspace(low, high, count)]


@pytest.mark.parametrize(("away", "found"), [(5.9, {}), (6.1, {1, 2})])
def test_a_branch_without_a_place_six_points_from_all_others_has_no_number(away, found):
    assert {*numbered(level(150.0), level(150.0 + away))} == {*found}


def test_a_number_stands_in_the_middle_of_its_branch_or_where_it_is_sixteen_points_clear():
    assert numbered(level(150.0))[1] == pytest.approx((200.0, 150.0), abs=1.0)
    beside = [(x, 150.0 + 12.0 + 0.05 * abs(x - 200.0)) for x, _ in level(0.0)]
    x, y = numbered(level(150.0), beside)[1]  # 16 pt away 80 pt from the middle and beyond
    assert y == pytest.approx(150.0)
    assert abs(x - 200.0) == pytest.approx(80.0, abs=3.0)
    far = [(x, y + 4.5) for x, y in beside]
    assert numbered(level(150.0), far)[1][0] == pytest.approx(200.0, abs=2.0)


@pytest.mark.parametrize(("away", "found"), [(10.9, {1}), (11.1, {1, 2})])
def test_a_number_needs_five_points_to_its_left_and_right(away, found):
    assert {*numbered([(200.0, 150.0)], [(200.0 + away, 150.0)])} == found
    assert {*numbered([(200.0, 150.0)], [(200.0 - away, 150.0)])} == found


@pytest.mark.parametrize(
    ("place", "found"),
    [((11.9, 150.0), {}), ((12.1, 150.0), {1}), ((388.1, 150.0), {}), ((387.9, 150.0), {1}),
     ((200.0, 8.9), {}), ((200.0, 9.1), {1}), ((200.0, 291.1), {}), ((200.0, 290.9), {1})],
)  # fmt: skip
def test_no_number_stands_within_three_hundredths_of_the_border(place, found):
    assert {*numbered([place])} == {*found}


@pytest.mark.parametrize(("away", "found"), [(5.9, {}), (6.1, {1})])
def test_a_number_stands_on_no_mark_of_an_event(away, found):
    assert {*numbered([(200.0, 150.0)], events=[(200.0, 150.0 + away)])} == {*found}


# --- pairs of multipliers: the plane is 3 wide, half of it 1.5


def plane(points=283.0, largest=9.0):
    """A plane of multipliers of so many pt on each side."""
    axes = panel(points, points)
    draw_plane(axes, largest)
    return axes


def pairs(*multipliers, points=600.0):
    """The numbers at these multipliers, one after another along a path; and where they stand."""
    axes = plane(points)
    before = len(axes.lines)
    values = [float(k) for k in range(len(multipliers))]
    line = Strand(True, [*values, 99.0], [*multipliers, multipliers[-1]])
    said = number_pairs(axes, [[line]], values)
    assert said == bool(axes.texts)
    dots = [complex(*line.get_xydata()[0]) for line in axes.lines[before:]]
    assert len(dots) == len(axes.texts)
    return {
        int(text.get_text()): (dot, complex(*text.xyann))
        for dot, text in zip(dots, axes.texts, strict=True)
    }


@pytest.mark.parametrize(("high", "found"), [(0.179, []), (0.181, [0]), (-0.5, [])])
def test_pairs_are_numbered_above_the_real_axis(high, found):
    assert [*pairs(0.5 + high * 1j)] == found


@pytest.mark.parametrize(("size", "away"), [(0.5, 1.15), (1.2, 1.35)])
def test_the_number_of_a_pair_stands_outside_the_unit_circle_and_beside_its_dot(size, away):
    mu = size * np.exp(0.7j)
    ((dot, number),) = pairs(mu).values()
    assert dot == pytest.approx(mu)
    assert number == pytest.approx(away * np.exp(0.7j))


@pytest.mark.parametrize(("away", "found"), [(0.179, [0]), (0.181, [0, 1])])
def test_pairs_nearer_than_a_number_is_wide_have_one_number(away, found):
    """0.18 between dots, however far apart their numbers, in a large plane."""
    mu = 0.2 * np.exp(1j * np.pi / 2.0)
    beside = mu + away * np.exp(0.4j)
    assert [*pairs(mu, beside, points=3000.0)] == found


@pytest.mark.parametrize(("away", "found"), [(16.8, [0]), (17.2, [0, 1])])
def test_numbers_of_pairs_are_seventeen_points_apart_in_a_small_plane(away, found):
    """They stand at 1.15 of the way outwards, 100 pt are 3."""
    way = away / 100.0 * 3.0
    turn = 2.0 * np.arcsin(0.5 * way / 1.15)
    assert [*pairs(np.exp(1.2j), np.exp(1j * (1.2 + turn)), points=100.0)] == found


# --- paths of multipliers


def path(*multipliers, stable=True, rising=True):
    """What is drawn of a path: dots, lines, arrows (tail and head)."""
    axes = plane()
    before = len(axes.lines)
    x = [float(k) for k in range(len(multipliers))]
    draw_paths(axes, [Strand(stable, x if rising else x[::-1], list(multipliers))], "#123456")
    lines = axes.lines[before:]
    dots = [line for line in lines if line.get_marker() == "o"]
    arrows = [(complex(*a.xyann), complex(*a.xy)) for a in axes.texts]
    return dots, [line for line in lines if line not in dots], arrows


@pytest.mark.parametrize(("long", "dot"), [(0.029, True), (0.031, False)])
def test_a_path_too_short_to_be_seen_is_a_dot(long, dot):
    for stable, face in ((True, "#123456"), (False, "white")):
        dots, lines, arrows = path(0.5j, 0.5j + long, stable=stable)
        assert (len(dots), len(lines), arrows) == ((1, 0, []) if dot else (0, 1, []))
        assert [one.get_markerfacecolor() for one in dots] == [face] * dot


@pytest.mark.parametrize(("long", "arrows"), [(0.239, 0), (0.241, 1)])
def test_a_path_of_sixteen_hundredths_of_half_the_plane_has_an_arrow(long, arrows):
    assert len(path(0.5j, 0.5j + long)[2]) == arrows
    assert len(path(1.4, 1.4 + long, 9.0)[2]) == 0  # hardly any of it is in the plane


def test_an_arrow_stands_half_way_and_points_along_a_rising_parameter():
    along = [complex(0.01 * k, 0.5) for k in range(101)]
    ((tail, head),) = path(*along)[2]
    assert 0.0 < (head - tail).real < 0.02
    assert head.real == pytest.approx(0.5, abs=0.02)
    ((tail, head),) = path(*along, rising=False)[2]
    assert -0.02 < (head - tail).real < 0.0


def test_the_plane_reaches_as_far_as_its_multipliers_but_not_beyond_one_and_a_half():
    for largest, half in ((0.3, 1.2), (1.13, 1.2), (1.2, 1.272), (1.5, 1.5), (9.0, 1.5)):
        axes = plane(largest=largest)
        assert axes.get_xlim() == pytest.approx((-half, half))
        assert axes.get_ylim() == axes.get_xlim()
        beyond = f" (triangle: beyond ±{half:g})" if largest > half else ""
        assert axes.get_xlabel() == rf"Re $\mu$" + beyond  # noqa: F541
    axes = panel()
    draw_plane(axes, 1.0, [0.64, 0.5])
    (words,) = axes.texts
    assert words.get_text() == r"dotted: $|\mu|$ = 0.5, 0.64"
    assert words.get_position() == pytest.approx((0.97 * 1.2, -0.97 * 1.2))
    assert [np.hypot(*line.get_xydata().T).max() for line in axes.lines[2:]] == pytest.approx(
        [0.64, 0.5]
    )


def test_a_triangle_at_the_border_shows_the_way_to_a_multiplier_beyond():
    axes = plane()
    before = len(axes.lines)
    beyond = [3.0, -6.0, 2.0 + 4.0j, 1.0 - 3.0j, 4.0, 1.4, 1.4j]
    draw_outside(axes, beyond, "#123456")
    drawn = {line.get_marker(): complex(*line.get_xydata()[0]) for line in axes.lines[before:]}
    assert drawn == pytest.approx({">": 1.5, "<": -1.5, "^": 0.75 + 1.5j, "v": 0.5 - 1.5j})
    assert len(axes.lines) == before + 4
    for line in axes.lines[before:]:
        assert not line.get_clip_on()
        assert line.get_markersize() == 6.0


def test_a_step_is_as_stable_as_the_end_that_is_further_from_the_border():
    def orbit(size, stable):
        return Made(multipliers=(size, 0.1), stable=stable)

    assert steady(orbit(0.99, True), orbit(1.2, False)) is False
    assert steady(orbit(0.8, True), orbit(1.1, False)) is True


# --- zooms, ranges, and numbers above a panel


def event(number, value, phases, kind=Kind.FOLD, corner="", left="left"):
    source = Made(kind=kind, corner=corner, left=left)
    return Made(number=number, value=value, phases=phases, source=source)


def zooms(*events, low=600.0, high=700.0):
    scene = Made(
        every=lambda of: np.array([low, high]), events=events, corners={"b": 50.0, "c": 90.0}
    )
    return hidden(scene)


@pytest.mark.parametrize(("away", "found"), [(0.499, 1), (0.501, 0), (-0.499, 1), (0.0, 0)])
def test_a_corner_impact_within_half_a_hundredth_of_the_range_is_enlarged(away, found):
    corner = event(1, 650.0, (50.0,), Kind.CORNER_IMPACT, "b")
    assert len(zooms(corner, event(2, 650.0 + away, (53.0,)))) == found


def test_a_zoom_shows_the_nearest_event_and_its_phase_on_both_sides():
    corner = event(1, 650.0, (50.0,), Kind.CORNER_IMPACT, "b")
    (zoom,) = zooms(corner, event(2, 650.1, (80.0, 53.0)), event(3, 650.3, (51.0,)))
    assert (zoom.event.number, zoom.corner_deg) == (1, 50.0)
    assert zoom.aside == pytest.approx(1.8 * 0.1)
    assert zoom.reach == pytest.approx(2.2 * 3.0)
    (zoom,) = zooms(corner, event(2, 650.1, (50.01,)))
    assert zoom.reach == pytest.approx(2.2 * 0.05)
    for other in (
        event(1, 650.0, (50.0,), Kind.FOLD, "b"),
        event(1, 650.0, (50.0,), Kind.CORNER_IMPACT, "no such"),
        event(1, 650.0, (50.0,), Kind.CORNER_IMPACT, "b", left=None),
    ):
        assert zooms(other, event(2, 650.1, (53.0,))) == []


def test_the_two_that_are_hardest_to_see_are_enlarged_in_their_order():
    pairs = []
    for k, (value, away) in enumerate([(690.0, 0.1), (610.0, 0.3), (650.0, 0.2)]):
        pairs.append(event(2 * k + 1, value, (50.0,), Kind.CORNER_IMPACT, "b"))
        pairs.append(event(2 * k + 2, value + away, (53.0,)))
    assert [zoom.event.value for zoom in zooms(*pairs)] == [650.0, 690.0]


@pytest.mark.parametrize(
    ("span", "wanted"), [(None, (598.0, 702.0)), ((500.0, 700.0), (496.0, 704.0))]
)
def test_a_parameter_has_a_fiftieth_of_its_range_as_room(span, wanted):
    axes = panel()
    asked = None if span is None else Made(low=span[0], high=span[1])
    scene = Made(study=Made(question=Made(span=asked)), parameter="rpm", events=[],
                 every=lambda of: np.array([600.0, 700.0]))  # fmt: skip
    _over_parameter(axes, scene, False)
    assert axes.get_xlim() == pytest.approx(wanted)


@pytest.mark.parametrize(
    ("way", "room", "apart"), [("x", 1.0, 7.2), ("y", 1.0, 7.8), ("x", 1.5, 10.8)]
)
def test_names_beside_a_panel_are_a_letter_apart(way, room, apart):
    """6 pt along x and 6.5 upwards, and a fifth more: the panel is made smaller afterwards."""
    places = places_beside(panel(), [100.0, 101.0, 102.0], way, room)
    assert np.diff(places) == pytest.approx([apart, apart])
    assert places[1] == pytest.approx(101.0)


@pytest.mark.parametrize(("count", "heights"), [(20, {11.0}), (21, {11.0, 19.0})])
def test_more_than_twenty_numbers_above_a_panel_stand_in_two_rows(count, heights):
    axes = panel()
    events = [(k, 10.0 + 18.0 * k) for k in range(count)]
    number_events(axes, events, named=True)
    assert [text.get_text() for text in axes.texts] == [str(k) for k in range(count)]
    assert {text.xyann[1] for text in axes.texts} == heights
    assert [text.xy[0] for text in axes.texts] == pytest.approx([value for _, value in events])
    if len(heights) == 2:
        assert [text.xyann[1] for text in axes.texts[:4]] == [11.0, 19.0, 11.0, 19.0]
    some = panel()  # what is outside takes no room
    number_events(some, [*events[:2], *((k, 1e4 + k) for k in range(count))], named=True)
    assert [text.xyann[1] for text in some.texts] == [11.0, 11.0]
    crowd = [(k, 200.0 + 0.1 * k) for k in range(count)]
    axes = panel()
    number_events(axes, crowd, named=True)
    apart = np.diff([text.xyann[0] for text in axes.texts])
    wanted = 1.2 * 6.0 * (0.8 if len(heights) == 2 else 1.5)
    assert apart == pytest.approx([wanted] * (count - 1))


# --- lines along a branch


def lines(*steps):
    """Lines through phases (deg) of neighbouring points, each as its values."""
    points = [Made(value=float(k), multipliers=(0.5,), stable=True) for k in range(len(steps))]
    return [line.y for line in strands(points, lambda point: steps[int(point.value)], 360.0)]


@pytest.mark.parametrize(
    ("steps", "wanted"),
    [
        (([10.0], [29.9]), [[10.0, 29.9]]),
        (([10.0], [30.1]), []),  # 20 deg and more is another impact
        (([10.0], [350.5]), []),  # a phase that passes 0 begins a line of its own
        (([10.0, 200.0], [12.0, 202.0]), [[10.0, 12.0], [200.0, 202.0]]),
        (([10.0, 15.0], [14.0, 9.0]), [[10.0, 14.0], [15.0, 9.0]]),  # in their order
        (([10.0, 200.0], [201.0, 11.0]), [[10.0, 11.0], [200.0, 201.0]]),  # one of them jumps
        (
            ([10.0, 200.0], [201.0, 11.0], [12.0, 202.0]),
            [[10.0, 11.0, 12.0], [200.0, 201.0, 202.0]],
        ),
        (([10.0, 15.0], [14.0]), [[15.0, 14.0]]),  # the nearer one goes on
        (([10.0, 15.0], [14.0, 18.0, 90.0]), [[15.0, 14.0], [10.0, 18.0]]),
        (([10.0, 15.0], [14.0, 45.0, 90.0]), [[15.0, 14.0]]),
    ],
)
def test_phases_go_on_in_their_order_or_to_the_nearest_within_twenty_degrees(steps, wanted):
    assert sorted(lines(*steps)) == sorted(wanted)
