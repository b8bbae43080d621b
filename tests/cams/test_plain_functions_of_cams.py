"""Small functions that compile, cut and bound a cam, on tables made by hand."""

from fractions import Fraction
from itertools import pairwise
from math import cos, factorial, pi, sin
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from camcli.cams import compile as compiling
from camcli.cams.balls import precision
from camcli.cams.compile import Cut, Lift, Part, Piece, build, corners, lift_range
from camcli.cams.decimals import decimal, exact, exactly
from camcli.cams.lift_jump import RowsAbout
from camcli.cams.regions import corner_list, regions
from camcli.kernel.cam_table import PIECE, TERMS, TURN

COUNTING = Piece(1.5, 0.5, tuple(range(1, TERMS + 1)), (3e-17, 5e-17))  # coefficients 1, 2, 3, ...


class Shape:
    """A cam of the given parts."""

    def __init__(self, *parts: Part):
        self._parts = list(parts)

    def parts(self):
        return self._parts


def test_a_column_counts_by_its_share_whatever_its_size():
    """What columns leave of a lift, by numpy's least squares; the fourth is no new one."""
    rng = np.random.default_rng(7)
    window = object.__new__(RowsAbout)
    window.lift = rng.normal(size=12)
    first, second = rng.normal(size=(2, 2, 12))
    combined = 3.0 * first - 2.0 * second
    third = combined + 1e-4 * rng.normal(size=(2, 12))  # 1e-8 of its square is its own
    expected = []
    for k in range(2):
        columns = np.stack((first[k], second[k], third[k]), axis=1)
        fitted = columns @ np.linalg.lstsq(columns, window.lift, rcond=None)[0]
        expected.append(((window.lift - fitted) ** 2).sum())
    for size in (1.0, 1e-9, 1e14):
        found = window._left(first, size * second, size * third, size * combined)
        assert found == pytest.approx(expected, rel=1e-6)
    nothing = np.zeros((2, 12))
    assert window._left(nothing) == pytest.approx([window.lift @ window.lift] * 2, rel=1e-14)


def test_a_piece_and_what_it_leaves_out_are_its_coefficients_to_thirty_digits():
    """mean + along cos theta + across sin theta on 0.1 rad, where Taylor's series is as good."""
    low, high = 0.7, 0.8
    with precision(60):
        mean, along, across = arb(1) / 3, arb(2) / 7, -arb(5) / 11
        center = arb((low + high) / 2)
        sine, cosine = center.sin_cos()
        height = mean + along * cosine + across * sine
        slope = across * cosine - along * sine
        wave, is_good = compiling._fit_wave((mean, along, across), low, high)
        plain, plain_is_good = compiling._fit(
            lambda theta: mean + along * theta.cos() + across * theta.sin(), low, high
        )
        assert is_good
        assert plain_is_good
        for piece in (wave, plain):
            for value, first, rest in zip(
                (height, slope), piece.coefficients, piece.rests, strict=False
            ):
                assert abs(float(value - first - arb(rest))) < 1e-30
                assert abs(rest) > 1e-19
            for n in range(2, 6):
                turned = float(center) + n * pi / 2
                wanted = float(along) * cos(turned) + float(across) * sin(turned)
                assert piece.coefficients[n] * factorial(n) == pytest.approx(wanted, rel=1e-9)


def test_the_terms_of_a_fit_that_are_rounding_and_those_that_matter():
    """A ramp has no curve; the last of the Chebyshev polynomials is a tail."""
    with precision(60):
        ramp, is_good = compiling._fit(lambda theta: 7 + theta / 3, 0.7, 0.8)
        assert is_good
        assert ramp.coefficients[:2] == pytest.approx((7.25, 1 / 3), rel=1e-15)
        assert set(ramp.coefficients[2:]) == {0.0}
        for n, is_good in ((TERMS - 3, True), (TERMS - 2, False), (TERMS - 1, False)):
            _, found = compiling._fit(lambda theta, n=n: (theta.acos() * n).cos(), -1.0, 1.0)
            assert found is is_good
        small = (arb(10) ** 30, arb("1e-8"), arb("1e-8"))
        assert compiling._fit_wave(small, 0.7, 0.8) is None
        piece, is_good = compiling._fit_wave((arb(1), arb(2), arb(3)), 0.0, 6.0)
        assert (piece, is_good) == (Piece(3.0, 3.0, ()), False)


def test_a_part_is_cut_finer_until_its_tails_do_not_matter(monkeypatch):
    asked = []

    def equal_pieces(part, low, high, count):
        asked.append(count)
        return ["piece"] * count if count >= 9 else None

    monkeypatch.setattr(compiling, "_equal_pieces", equal_pieces)
    found = compiling._compile(Part(arb(0), arb(1), lambda theta: theta), 0.0, 1.0)
    assert asked == [1, 2, 3, 4, 6, 8, 11]
    assert found == ["piece"] * 11


def test_no_part_has_more_than_64_pieces_and_the_last_resort_is_no_wave(monkeypatch):
    """A wave whose tail matters comes without coefficients."""
    monkeypatch.setattr(compiling, "_fit", lambda lift, low, high: (("fit", low, high), False))
    part = Part(arb(0), arb(1), lambda theta: theta, wave=(1, 2, 3))
    waves = [(Piece(0.5, 0.5, ()), False)]
    monkeypatch.setattr(compiling, "_fit_wave", lambda wave, low, high: waves[0])
    assert compiling._equal_pieces(part, 0.0, 1.0, 63) is None
    pieces = compiling._equal_pieces(part, 0.0, 1.0, 64)
    assert pieces == [("fit", k / 64, (k + 1) / 64) for k in range(64)]
    waves[0] = ("wave", True)
    assert compiling._equal_pieces(part, 0.0, 1.0, 2) == ["wave", "wave"]
    waves[0] = None
    assert compiling._equal_pieces(part, 0.0, 1.0, 2) is None


def test_a_kink_of_a_rounding_is_none_and_a_sliver_is_left_to_its_neighbour():
    for kink, told in ((5e-10, 0.0), (2e-9, 2e-9), (-2e-9, -2e-9)):
        with precision(60):
            shape = Shape(
                Part(arb(0), arb(2), lambda theta: theta),
                Part(arb(2), 2 * arb.pi(), lambda theta, k=kink: theta + k * (theta - 2)),
            )
        assert build(shape).stretches[1].slope_jump == pytest.approx(told, rel=1e-6)
    edges = (0.0, 5e-13, 2.0, 2.0 + 5e-13, 2.0 + 4e-12, TURN - 5e-13, TURN)
    parts = [Part(arb(a), arb(b), None, arb(k)) for k, (a, b) in enumerate(pairwise(edges))]
    cuts = compiling._without_slivers(parts)
    assert [int(float(cut.part.level)) for cut in cuts] == [1, 3, 4]
    assert [(cut.low, cut.high) for cut in cuts] == [
        (0.0, 2.0 + 5e-13), (2.0 + 5e-13, 2.0 + 4e-12), (2.0 + 4e-12, TURN)
    ]  # fmt: skip


def test_bounds_are_no_looser_beside_a_stretch_of_many_pieces():
    pieces = [Piece(0.1 * k, 0.05, (0.3, -0.7, 1.1) + (0.2,) * (TERMS - 3)) for k in range(9)]
    alone = compiling._bounds([pieces[:1]])[0]
    assert compiling._bounds([pieces[1:], pieces[:1]])[1] == alone
    many = compiling._bounds([pieces[1:]])[0]
    assert compiling._bounds([pieces[:1], pieces[1:]])[1] == many  # nor tighter beside one of few
    assert alone[1].low < -0.7 < alone[1].high
    assert compiling.Bounds(-3.0, 2.0).largest == 3.0
    assert compiling.Bounds(-1.0, 2.0).largest == 2.0


@pytest.mark.parametrize(("seventh", "power"), [(0.0, 4), (1e-7, 4), (1.0, 8), (1e9, 13)])
def test_the_radius_of_a_local_series_is_a_power_of_two(seventh, power):
    """seventh s^6/720 is 2e-17 at most, and more at twice the step."""
    s = compiling._radius(seventh)
    assert s == 0.5**power
    assert seventh * s**6 / 720.0 <= 2e-17
    assert power == 4 or seventh * (2.0 * s) ** 6 / 720.0 > 2e-17


def test_the_highest_of_many_waves_is_found():
    """Eleven of them on another one; a sixth power has no seventh derivative."""
    with precision(60):
        wave = Shape(
            Part(arb(0), 2 * arb.pi(), lambda theta: (theta * 11).sin() + (theta - 1).sin() / 5)
        )
        power = Shape(Part(arb(0), 2 * arb.pi(), lambda theta: theta**6 * 1000))
    theta = np.linspace(0.0, TURN, 20_001)
    lift = np.sin(11.0 * theta) + np.sin(theta - 1.0) / 5.0
    assert lift_range(build(wave)) == pytest.approx((lift.min(), lift.max()), abs=3e-6)
    assert build(power).stretches[0].radius == 1.0 / 16.0


def test_the_derivatives_of_a_piece_are_as_long_as_the_piece():
    assert COUNTING.derivative(0) == COUNTING.coefficients
    for order in (1, 2, 6):
        wanted = [
            (j + 1) * factorial(j) // factorial(j - order) for j in range(order, TERMS)
        ]  # of (j + 1) x^j
        assert COUNTING.derivative(order) == (*wanted, *[0] * order)
    row = COUNTING.row()
    assert len(row) == PIECE
    assert row[:3] == [1.5, 1, 2]
    assert row[1 + TERMS] == 2
    assert row[-2:] == [3e-17, 5e-17]


def test_the_stretches_of_a_dwell_and_a_fifth_power():
    """c = 1/3, and theta^5/120 from a quarter turn on, cut by the strobe at 4 rad."""
    with precision(60):
        corner = arb.pi() / 2
        level = arb(1) / 3
        left_out = float(corner - float(corner))
        level_left_out = float(level - float(level))
        shape = Shape(
            Part(arb(0), corner, None, level),
            Part(corner, 2 * arb.pi(), lambda theta: theta**5 / 120),
        )
    cam = build(shape, 4.0)
    assert cam.strobe == 2
    assert cam.top == pytest.approx(TURN**5 / 120, rel=1e-9)
    first, second, third = cam.stretches
    quarter = float(pi / 2)
    assert [(one.start, one.end) for one in cam.stretches] == [
        (0.0, quarter), (quarter, 4.0), (4.0, TURN)
    ]  # fmt: skip
    assert [one.rest for one in cam.stretches] == [0.0, left_out, 0.0]
    assert left_out != 0.0
    assert [one.dwell for one in cam.stretches] == [1, 0, 0]
    assert cam.pieces[PIECE - 2 : PIECE] == [level_left_out, 0.0]
    assert level_left_out != 0.0
    assert first.slope_jump == pytest.approx(-(TURN**4) / 24, rel=1e-12)
    assert second.slope_jump == pytest.approx(quarter**4 / 24, rel=1e-12)
    assert third.slope_jump == 0.0
    for one in (second, third):
        ends = [(n, x) for n in range(3) for x in (one.start, one.end)]
        told = [one.start_c, one.end_c, one.start_c1, one.end_c1, one.start_c2, one.end_c2]
        assert told == pytest.approx([x ** (5 - n) / factorial(5 - n) for n, x in ends], rel=1e-12)
        bounds = [one.accel_max, one.jerk_max, one.snap_max, one.crackle_max]
        assert bounds == pytest.approx([one.end ** (3 - n) / factorial(3 - n) for n in range(4)])
        for n, low in ((0, one.c_min), (1, one.slope_min), (2, one.accel_min)):
            at_start = one.start ** (5 - n) / factorial(5 - n)
            assert 0.7 * at_start < low <= at_start
        assert one.radius == 1.0 / 16.0
        assert one.per_angle == pytest.approx(one.piece_count / (one.end - one.start))
    assert corners(cam) == [0, 1]


def test_the_lobe_has_the_height_of_the_seat_on_either_side():
    cuts = [Cut(SimpleNamespace(seat=seat), 0.0, 1.0) for seat in (True, False, False, True)]
    starts = [Lift(10.0 + n, 20.0 + n, 30.0 + n) for n in range(4)]
    ends = [Lift(40.0 + n, 50.0 + n, 60.0 + n) for n in range(4)]
    compiling._meet_the_seat(cuts, starts, ends)
    assert [lift.c for lift in starts] == [10.0, 40.0, 12.0, 13.0]
    assert [lift.c for lift in ends] == [40.0, 41.0, 13.0, 43.0]
    assert [lift.slope for lift in starts + ends] == [*range(20, 24), *range(50, 54)]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("turns_at", "extreme"), [(1.99, 1e-4), (3.03, 0.0), (4.01, 1e-4)])
def test_the_range_of_a_lift_ends_within_its_stretches(sign, turns_at, extreme):
    """A parabola from 2 to 4 rad between dwells; where it turns beyond them, its end counts."""
    with precision(60):
        shape = Shape(
            Part(arb(0), arb(2), None, arb(2 * sign)),
            Part(arb(2), arb(4), lambda theta: sign * (theta - arb(turns_at)) ** 2),
            Part(arb(4), 2 * arb.pi(), None, arb(3 * sign)),
        )
    cam = build(shape)
    farthest = max(3.0, (2.0 - turns_at) ** 2, (4.0 - turns_at) ** 2)
    wanted = sorted((sign * extreme, sign * farthest))
    assert lift_range(cam) == pytest.approx(wanted, abs=1e-12)
    slopes = sorted((0.0, 2 * sign * (2.0 - turns_at), 2 * sign * (4.0 - turns_at)))
    assert lift_range(cam, 1) == pytest.approx([slopes[0], slopes[-1]], abs=1e-12)


def in_pieces(start: float, end: float, count: int) -> Part:
    return Part(arb(start), arb(end), None, pieces=(COUNTING,) * count)


def test_a_strobe_beside_an_edge_is_laid_on_it():
    """An edge of a part, one of a piece within it, and the end of the turn."""
    cuts = [Cut(in_pieces(0.0, 2.0, 4), 0.0, 2.0), Cut(in_pieces(2.0, TURN, 1), 2.0, TURN)]
    for edge in (0.5, 1.5, 2.0):
        for sign in (1, -1):
            assert compiling._at_an_edge(cuts, edge + sign * 1.5e-12) == edge
            assert compiling._at_an_edge(cuts, edge + sign * 2.5e-12) == edge + sign * 2.5e-12
    assert compiling._at_an_edge(cuts, 1.5e-12) == 0.0
    assert compiling._at_an_edge(cuts, TURN - 1.5e-12) == 0.0
    assert compiling._at_an_edge(cuts, TURN - 2.5e-12) == TURN - 2.5e-12
    assert compiling._at_an_edge(cuts, 1.3) == 1.3


def test_a_strobe_within_a_piece_makes_stretches_of_both_its_halves():
    part = in_pieces(0.0, 2.0, 4)
    rest = in_pieces(2.0, TURN, 1)
    cuts, strobe = compiling._cuts([part, rest], 0.7)
    assert strobe == 0.7
    places = [0.0, 0.5, 0.7, 1.0, 2.0, TURN]
    assert [(cut.low, cut.high) for cut in cuts] == list(pairwise(places))
    assert [cut.part is part for cut in cuts] == [True] * 4 + [False]
    cuts, _ = compiling._cuts([part, rest], 1.0)
    assert [cut.low for cut in cuts] == [0.0, 1.0, 2.0]
    dwell = Part(arb(0), arb(2), None, arb(1))
    cuts, _ = compiling._cuts([dwell, rest], 0.7)
    assert [cut.low for cut in cuts] == [0.0, 0.7, 2.0]


def test_the_pieces_of_a_stretch_are_those_that_it_covers():
    pieces = tuple(Piece(0.25 + 0.5 * k, 0.25, (float(k),) * TERMS) for k in range(4))
    part = Part(arb(0), arb(2), None, pieces=pieces)
    for low, high, wanted in ((0.0, 2.0, [0, 1, 2, 3]), (0.5, 1.5, [1, 2]), (1.5, 1.7, [3])):
        found = compiling._compile(part, low, high)
        assert [piece.coefficients[0] for piece in found] == wanted


@pytest.mark.parametrize(
    ("size", "last", "before_last", "negligible"),
    [
        (1.0, 5e-19, 7e-19, True),
        (1.0, 2e-18, 0.0, False),
        (1.0, 0.0, 2e-18, False),
        (1e6, 1e-16, 3e-16, True),
        (1e6, 3e-16, 0.0, False),
        (1e6, 0.0, 6e-16, False),
    ],
)
def test_a_tail_matters_to_the_lift_or_to_its_second_derivative(
    size, last, before_last, negligible
):
    """T_2, T_4 and T_5 bend by k^2 (k^2 - 1)/3 = 4, 80 and 200; 1e-14 of the most is the limit."""
    assert compiling._tail_is_negligible([2, 3, 1, 0, before_last, last], size) is negligible


def stretch(start_c2: float, end_c2: float, low=-1.0, high=1.0, slope_jump=0.0, start=0.0):
    return SimpleNamespace(
        start_c2=start_c2, end_c2=end_c2, accel_min=low, accel_max=high, slope_jump=slope_jump,
        start=start,
    )  # fmt: skip


@pytest.mark.parametrize(("low", "high"), [(-100.0, 1.0), (-1.0, 100.0)])
def test_a_corner_is_a_jump_beyond_rounding_of_the_largest_second_derivative(low, high):
    """1e-9 of 100 m/rad2; the third has a kink, the last ends otherwise than the first begins."""
    table = [
        stretch(0.0, 1.0, low, high), stretch(1.0 + 5e-8, 3.0), stretch(3.0, 4.0, slope_jump=1e-3),
        stretch(4.0 - 2e-7, 5.0),
    ]  # fmt: skip
    assert corners(SimpleNamespace(stretches=table)) == [0, 2, 3]


def cornered(count: int, *, at: tuple[int, ...]) -> SimpleNamespace:
    """So many stretches, each 0.1 rad behind the other, with kinks where `at` tells."""
    return SimpleNamespace(
        stretches=[
            stretch(0.0, 0.0, slope_jump=float(n in at), start=0.1 * n) for n in range(count)
        ]
    )


def test_corners_have_letters_and_beyond_them_numbers():
    found = corner_list(cornered(30, at=tuple(range(1, 30))))
    assert [corner.name for corner in found[:3]] == ["a", "b", "c"]
    assert [corner.name for corner in found[25:]] == ["z", "corner27", "corner28", "corner29"]
    assert [corner.stretch for corner in found] == [*range(1, 30)]
    assert [corner.theta for corner in found] == [0.1 * n for n in range(1, 30)]


@pytest.mark.parametrize(
    ("at", "wanted"),
    [
        ((), [("A1", 0.0, TURN, "", "", (0, 1, 2, 3, 4, 5))]),
        ((2,), [("A1", 0.2, 0.2 + TURN, "a", "a", (2, 3, 4, 5, 0, 1))]),
        ((0,), [("A1", 0.0, TURN, "a", "a", (0, 1, 2, 3, 4, 5))]),
        (
            (1, 4, 5),
            [
                ("A1", 0.1, 0.4, "a", "b", (1, 2, 3)),
                ("A2", 0.4, 0.5, "b", "c", (4,)),
                ("A3", 0.5, 0.1 + TURN, "c", "a", (5, 0)),
            ],
        ),
    ],
)
def test_regions_go_from_corner_to_corner_and_through_zero(at, wanted):
    found = [
        (one.name, one.start, one.end, one.begins, one.ends, one.stretches)
        for one in regions(cornered(6, at=at))
    ]
    assert found == wanted


@pytest.mark.parametrize(
    "value", [0.0, 0.1, -0.1, 1e22, -12345.0, 2e-30, -2e-30, 3e-31, -3e-31, 5e-324, -5e-324]
)
def test_a_double_is_written_as_the_decimal_number_that_it_is(value):
    text = exact(value)
    mantissa, _, power = text.partition("e")
    assert Fraction(mantissa) * Fraction(10) ** int(power or 0) == Fraction(value)
    assert bool(power) == (0.0 < abs(value) < 1e-30)
    assert len(text) < 1200


def test_fractions_and_balls_are_written_as_decimal_numbers():
    assert decimal(Fraction(-3, 40)) == "-75e-3"
    assert decimal(Fraction(12)) == "12"
    assert decimal(Fraction(1, 5)) == "2e-1"
    assert exactly(arb(-7) / 8) == "-875e-3"
    assert exactly(arb(40)) == "40"
