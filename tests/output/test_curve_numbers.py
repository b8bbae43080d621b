"""Where the numbers of curves stand: what each distance and each cost decides, by two places.

Lengths are pt. A number is written 7 pt high; what it keeps away from and how far is written down
here once more, and each has a case just within and just beyond it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from camcli.plots import curve_numbers
from camcli.plots.curve_numbers import Spot, spots_of, write_number

Curve = tuple[Sequence[float], Sequence[float]]
WIDE, HIGH = 400.0, 300.0
A, B, FAR = (100.0, 100.0), (300.0, 200.0), 1e3


def panel() -> Axes:
    """Axes of 400 by 300 pt whose data count points."""
    figure = Figure(figsize=(500.0 / 72.0, 400.0 / 72.0), dpi=300)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, WIDE / 500.0, HIGH / 400.0))
    axes.set(xlim=(0.0, WIDE), ylim=(0.0, HIGH))
    return axes


def spots(curves: Sequence[Curve], marks: Sequence[tuple[float, float]] = ()) -> list[Spot | None]:
    """The spots of the numbers of curves in such a panel."""
    return spots_of(panel(), curves, marks)


def beside(place: tuple[float, float], away: float) -> Curve:
    """A curve of one point, so far to the right of a place."""
    return [place[0] + away], [place[1]]


def chosen(
    others: Sequence[Curve], marks: Sequence[tuple[float, float]], numbered: Sequence[Curve]
) -> str:
    """The end of a curve from A to B at which its number stands.

    The curve has no other points, and its number stands at A if both are as good. others: without
    a number so far; numbered: with one.
    """
    curve = [A[0], B[0]], [A[1], B[1]]
    spot = spots([*numbered, curve, *others], marks)[len(numbered)]
    assert spot is not None
    return "A" if spot.place == A else "B"


@pytest.fixture
def on_the_curve(monkeypatch):
    """No number may stand beside its curve."""
    monkeypatch.setattr(curve_numbers, "_ways", lambda: [(0.0, 0.0)])


@pytest.mark.usefixtures("on_the_curve")
@pytest.mark.parametrize(
    ("others", "marks", "numbered", "end"),
    [
        ([], [], [], "A"),
        # another curve 10 pt away or less might be the one that is meant
        ([beside(A, 9.9)], [], [], "B"),
        ([beside(A, 10.1)], [], [], "A"),
        # at both ends something is nearer than that; a curve hides the number from 6 pt on
        ([beside(A, 6.3), beside(B, 6.1)], [], [], "A"),
        ([beside(A, 5.7), beside(B, 5.5)], [], [], "A"),
        ([beside(A, 5.0)], [(B[0] + 5.3, B[1])], [], "A"),  # 0.5 + 0.167 here, 0.47 + 0.34 there
        ([beside(A, 4.0)], [(B[0] + 5.3, B[1])], [], "B"),  # 0.6 + 0.333 here
        # a mark from 8 pt on
        ([beside(B, 8.5)], [(A[0] + 9.0, A[1])], [], "A"),  # 0.1 here, 0.15 there
        ([beside(B, 6.5)], [(A[0] + 7.0, A[1])], [], "B"),  # 0.3 + 0.125 here, 0.35 there
        # another number from 11 pt on: that of a curve of one point stands there
        ([], [], [beside(A, 10.9)], "B"),
        ([], [], [beside(A, 11.1)], "A"),
        # to stand on a number is four times as bad as to stand on a curve: 4 x 3/11 + 0.2 here,
        # or 4 x 5/11 + 0.4, and 5/6 + 0.9 there
        ([beside(B, 1.0)], [], [beside(A, 8.0)], "A"),
        ([beside(B, 1.0)], [], [beside(A, 6.0)], "B"),
    ],
)
def test_a_number_stands_at_the_end_that_is_clearer(others, marks, numbered, end):
    assert chosen(others, marks, numbered) == end


def along(count: int = 41, length: float = 200.0, y: float = 150.0) -> Curve:
    """A level line through the middle of the panel."""
    return (200.0 + length * np.linspace(-0.5, 0.5, count)).tolist(), [y] * count


@pytest.mark.parametrize(("away", "way"), [(4.9, 0.0), (4.4, 11.0), (9.0, 0.0)])
def test_a_number_stands_beside_its_curve_where_another_would_hide_it(away, way):
    """To stand 11 pt beside it costs 0.22, another curve at 4.68 pt as much: 1 - 4.68/6."""
    spot, _ = spots([along(), along(length=400.0, y=150.0 - away)])
    assert np.hypot(*spot.way) == pytest.approx(way)
    assert spot.way[1] >= 0.0  # on the side where the other is not


@pytest.mark.parametrize(("radius", "way"), [(3.0, 11.0), (9.0, 16.0), (14.0, 24.0)])
def test_a_number_stands_as_near_to_its_curve_as_it_is_clear_of_others(radius, way):
    """Around a place all is full within so many pt, but for a way out for the line to a number."""
    rings = []
    for ring in np.arange(1.0, radius + 0.1, 1.0):
        begin = np.arcsin(min(2.5 / ring, 1.0))
        turn = np.linspace(begin, 2.0 * np.pi - begin, 100)
        rings.append((200.0 + ring * np.cos(turn), 150.0 + ring * np.sin(turn)))
    spot = spots([([200.0], [150.0]), *rings])[0]
    assert spot.way == pytest.approx((way, 0.0))


def test_the_line_of_a_number_crosses_no_other_curve():
    """Another curve runs 7.5 pt above, and below there is no room; then it is the curve itself."""
    own, above = along(y=8.0), along(length=400.0, y=15.5)
    marks = [(x, 8.0) for x in own[0]]
    spot, _ = spots([own, above], marks)
    assert spot.way[1] < 3.0


@pytest.mark.parametrize(("away", "way"), [(3.0, (24.0, 0.0)), (5.0, (0.0, 24.0))])
def test_the_line_of_a_number_stays_clear_of_marks(monkeypatch, away, way):
    """A mark is four points wide on either side; another curve lies on the place of the number."""
    monkeypatch.setattr(curve_numbers, "_ways", lambda: [(0.0, 0.0), (0.0, 24.0), (24.0, 0.0)])
    place = [200.0], [150.0]
    spot, _ = spots([place, place], [(200.0 + away, 160.0)])
    assert spot.way == way


def test_the_line_of_a_number_crosses_no_curve_with_or_without_its_own_number(monkeypatch):
    monkeypatch.setattr(curve_numbers, "_ways", lambda: [(0.0, 0.0), (0.0, 24.0), (24.0, 0.0)])
    place = [200.0], [150.0]
    for begin, way in ((195.0, (24.0, 0.0)), (205.0, (0.0, 24.0))):
        level = np.linspace(begin, 395.0, 41).tolist(), [162.0] * 41
        assert spots([level, place, place])[1].way == way
        assert spots([place, level, place])[0].way == way


@pytest.mark.parametrize(("away", "way"), [(5.0, (24.0, 0.0)), (8.0, (0.0, 24.0))])
def test_the_line_of_a_number_stays_clear_of_every_other_number(monkeypatch, away, way):
    """A number is five and a half points wide on either side; the first one stands far away."""
    monkeypatch.setattr(curve_numbers, "_ways", lambda: [(0.0, 0.0), (0.0, 24.0), (24.0, 0.0)])
    place = [200.0], [150.0]
    near, far = ([200.0 + away], [162.0]), ([50.0], [50.0])
    for numbered in ([far, near], [near, far]):
        found = spots([*numbered, place, place])
        assert [spot.way for spot in found[:3]] == [(0.0, 0.0), (0.0, 0.0), way]


def test_a_number_beside_its_curve_does_not_stand_on_it():
    """Both points in view are covered; along the line it hides a number, above another does half.

    The line goes from one side of the panel to the other.
    """
    curve = [-100.0, 100.0, 300.0, 500.0], [150.0] * 4
    ends = [([x], [150.0]) for x in (100.0, 300.0)]
    others = [([x], [164.0]) for x in (100.0, 300.0)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(curve_numbers, "_ways", lambda: [(0.0, 0.0), (11.0, 0.0), (0.0, 11.0)])
        spot = spots([curve, *ends, *others])[0]
    assert spot.way == (0.0, 11.0)


@pytest.mark.parametrize("gap_deg", [30.0, 90.0, 210.0, 330.0])
def test_a_number_stands_in_the_one_direction_that_is_free(gap_deg):
    """Twelve directions are tried; others fill all but 50 deg."""
    rays = []
    for angle in np.radians(np.arange(gap_deg + 50.0, gap_deg + 311.0, 10.0)):
        reach = np.array([1.0, 40.0])
        rays.append((200.0 + reach * np.cos(angle), 150.0 + reach * np.sin(angle)))
    spot = spots([([200.0], [150.0]), *rays])[0]
    assert np.degrees(np.arctan2(*spot.way[::-1])) % 360.0 == pytest.approx(gap_deg)


@pytest.mark.parametrize(("away", "middle"), [(6.5, True), (4.0, False)])
def test_a_number_leaves_the_middle_of_its_curve_for_a_reason_only(away, middle):
    """Nine tenths of a line have another beside them: at 6.5 pt for 0.35, at 4 pt for 0.93.

    At an end it would cost 0.6, and beside the line 0.22 + 0.6 as well.
    """
    spot, _ = spots([along(401), along(401, length=182.0, y=150.0 - away)])
    share = abs(spot.place[0] - 200.0) / 100.0
    assert (share < 0.1) if middle else (share > 0.9)
    assert middle or spot.way == (0.0, 0.0)


def test_the_one_clear_place_of_a_long_curve_is_found():
    """Forty places of a curve are tried: each of four parts of a line in turn is clear."""
    length = 390.0
    for k in range(4):
        begin = 5.0 + (k + 0.6) * length / 4.4 - 12.0
        parts = [(5.0, begin), (begin + 24.0, 395.0)]
        ways = [(list(np.linspace(*part, 60)), [151.0] * 60) for part in parts]
        spot = spots([along(200, length), *ways])[0]
        assert begin + 7.0 <= spot.place[0] <= begin + 17.0, k
        assert spot.way == (0.0, 0.0)


@pytest.mark.parametrize("end", [6.2, 5.8])
@pytest.mark.parametrize("side", ["left", "right", "below", "above"])
def test_the_middle_of_a_number_is_six_points_from_the_border(side, end):
    """A curve of one point at a border has its number there, or else within the panel."""
    place = {"left": (end, 150.0), "right": (WIDE - end, 150.0), "below": (200.0, end),
             "above": (200.0, HIGH - end)}[side]  # fmt: skip
    (spot,) = spots([([place[0]], [place[1]])])
    assert (spot.way == (0.0, 0.0)) == (end > 6.0)
    middle = np.add(spot.place, spot.way)
    assert (middle >= 6.0).all()
    assert (middle <= np.array([WIDE, HIGH]) - 6.0).all()


def test_points_of_a_curve_that_others_keep_away_from_are_three_points_apart():
    """At most, and not much less: each is compared with every place of every number."""
    size = np.array([WIDE, HIGH])
    line = np.array([[10.0, 10.0], [390.0, 290.0], [390.0, 20.0]])
    steps = np.hypot(*np.diff(curve_numbers._dense(line, size), axis=0).T)
    assert 2.5 < steps.min() <= steps.max() <= 3.0
    crossing = np.array([[-5000.0, 150.0], [5000.0, 150.0]])
    seen = curve_numbers._dense(crossing, size)
    assert seen[:, 0].min() < 6.0
    assert seen[:, 0].max() > WIDE - 6.0
    assert (np.diff(seen[:, 0]) <= 10.1).all()  # no more than a thousand of a step
    assert (seen >= -6.0).all()
    assert (seen <= size + 6.0).all()


def black_of(draw: Callable[[Axes], object], around: float = 3.5) -> tuple[int, int]:
    """Black and all pixels of a black page within some pt of the middle, after something is drawn.

    What is white around letters shows on black.
    """
    axes = panel()
    axes.set_facecolor("black")
    axes.set_axis_off()
    axes.figure.set_facecolor("black")
    draw(axes)
    axes.figure.canvas.draw()
    shown = np.asarray(axes.figure.canvas.buffer_rgba())[:, :, :3].max(axis=2)
    x, y = axes.transData.transform((200.0, 150.0))
    near = round(around * 300.0 / 72.0)
    row, column = len(shown) - round(y), round(x)
    part = shown[row - near : row + near, column - near : column + near]
    return int((part < 60).sum()), part.size


def test_a_number_can_be_read_on_a_dark_map():
    """It has a white seam of a point on either side of its strokes, which are black."""
    black, every = black_of(lambda axes: write_number(axes, 8, Spot((200.0, 150.0), (0.0, 0.0))))
    assert 0.1 < black / every < 0.7
    plain, _ = black_of(lambda axes: None)
    assert plain == every
    axes = panel()
    write_number(axes, 8, Spot((200.0, 150.0), (0.0, 0.0)))
    (seam,) = axes.texts[0].get_path_effects()
    assert 0.7 <= seam._gc["linewidth"] / 2.0 <= 1.5
    assert seam._gc["foreground"] == "white"


def test_the_line_of_a_number_ends_at_its_curve_and_begins_at_the_number():
    axes = panel()
    write_number(axes, 3, Spot((200.0, 150.0), (0.0, 24.0)))
    axes.figure.draw_without_rendering()
    (text,) = axes.texts
    line = text.arrow_patch
    assert (line.shrinkA, line.shrinkB) == (1.0, 0.0)
    points = line.get_transform().transform_path(line.get_path()).vertices
    ends = axes.transData.inverted().transform(points)
    low, high = ends[ends[:, 1].argmin()], ends[ends[:, 1].argmax()]
    assert low == pytest.approx((200.0, 150.0), abs=0.2)
    letters = axes.transData.inverted().transform(super(type(text), text).get_window_extent())
    assert 0.0 <= letters[0, 1] - high[1] <= 4.0
    assert letters[:, 1].mean() == pytest.approx(174.0, abs=0.6)
    assert text.get_fontsize() == 7.0
    assert 0.3 <= line.get_linewidth() <= 1.0


@pytest.mark.parametrize(("away", "end"), [(8.0, "B"), (12.0, "A")])
def test_a_number_keeps_clear_of_a_curve_that_has_its_number_elsewhere(away, end):
    """The other one goes up from beside A, and has its number half-way."""
    other = [A[0] + away] * 3, [A[1], A[1] + 75.0, A[1] + 150.0]
    assert chosen([], [], [other]) == end


def test_a_number_stands_in_the_middle_of_what_is_seen_of_its_curve():
    """From 50 pt to 400, where the panel ends, and on to 1000; from below the panel too."""
    along = np.arange(50.0, 1001.0, 10.0)
    flat, steep = spots(
        [(along, np.full(96, 150.0)), (np.full(40, 40.0), np.arange(-90.0, 310.0, 10.0))]
    )
    assert flat is not None
    assert abs(flat.place[0] - 225.0) <= 10.0
    assert steep is not None
    assert abs(steep.place[1] - 150.0) <= 10.0


def test_a_line_has_the_cells_around_it_and_a_place_those_within_its_radius():
    ink = curve_numbers._Ink(np.array([40.0, 30.0]))
    assert len(ink.cells_about([np.array([20.2, 10.4])], 1.0)) == 9
    assert len(ink.cells_about([np.array([0.0, 0.0])], 1.0)) == 4  # in the corner of a panel
    line = ink.cells_of(np.array([[10.0, 10.0], [14.0, 10.0]]))
    assert len(line) == 3 * 7
    # a point that is very far away costs no more memory than another
    ink.cells_of(np.array([[10.0, 10.0], [1e15, 10.0]]))
    twice = ink.cells_about([np.array([5.0, 5.0]), np.array([5.0, 5.0])], 1.0)
    assert len(twice) == 9
