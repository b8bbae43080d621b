"""First zeros of functions in balls, and bounds of a cam's table, by hand."""

from __future__ import annotations

from math import factorial
from types import SimpleNamespace as Made

import pytest
from flint import arb, arb_series, ctx

from camcli.cams.balls import UndecidedError
from camcli.exact import first_root, table_bounds
from camcli.exact.machine import BallStretch
from camcli.exact.table_bounds import HIGHEST, TERMS, TableBounds


@pytest.fixture(autouse=True)
def many_bits():
    before, ctx.prec = ctx.prec, 200
    yield
    ctx.prec = before


def polynomial(*coefficients):
    """x -> [value, slope, second derivative] of sum a_k x^k."""

    def values(x):
        rows = list(coefficients)
        found = []
        for _ in range(3):
            total = arb(0) * x
            for a in reversed(rows):
                total = total * x + arb(a)
            found.append(total)
            rows = [k * rows[k] for k in range(1, len(rows))] or [0]
        return found

    return values


@pytest.mark.parametrize(
    ("coefficients", "low", "high", "root"),
    [
        ((1, -1), 0, 3, 1.0), ((2, -3, 1), 0, 1.5, 1.0), ((-2, 3, -1), 1.5, 3, 2.0),
        ((2, -3, 1), 0, 3, 1.0), ((1, 1), 0, 3, None), ((1.01, -2, 1), 0, 3, None),
        ((0.99, -2, 1), 0, 3, 0.9), ((6, -11, 6, -1), 0.5, 4, 1.0),
    ],
)  # fmt: skip
def test_the_first_zero_is_found_and_none_is_invented(coefficients, low, high, root):
    """Also of functions that come near to zero, or have several."""
    found = first_root.first_root(polynomial(*coefficients), arb(low), arb(high))
    if root is None:
        assert found is None
        return
    assert abs(found - root) < 1e-15
    assert found.rad() < 1e-50
    for cut in (0.75, 1.125):
        if low < cut < high:
            again = first_root.first_root(polynomial(*coefficients), arb(low), arb(high), arb(cut))
            assert again.overlaps(found)


def test_a_zero_is_not_passed_over_where_little_is_known_of_the_curvature():
    """Of 1/10 - 5 (x - 1/2)^2, whose second derivative may have either sign, so to say."""

    def vague(x):
        y = x - arb(0.5)
        return [arb("0.1") - 5 * y * y, -10 * y, arb(-10, 11)]

    found = first_root.first_root(vague, arb(0.4), arb(0.65))
    assert found.overlaps(arb(0.5) + arb("0.02").sqrt())


def test_a_double_zero_is_left_open():
    for coefficients in ((1, -2, 1), (0, 1, -2, 1)):
        with pytest.raises(UndecidedError):
            first_root.first_root(polynomial(*coefficients), arb(0.25), arb(3))


def test_a_step_leads_to_the_zero_of_the_parabola():
    """Of (x - 1)(x - 3) from below one and from between: the zero at which it falls."""
    f = polynomial(3, -4, 1)
    for x in (0.0, 0.5, 1.25, 1.9):
        assert abs(first_root._step(*f(arb(x))) - (1 - arb(x))) < 1e-50


def test_a_zero_is_sharpened_to_all_digits_with_the_slope_there():
    """2 x - x^2 falls through zero at 2, with the slope -2."""
    f = polynomial(0, 2, -1)
    around = arb(2, 1e-6)
    slopes = [2 - 2 * around, arb(-2), arb(0)]
    zero, slope = first_root.sharpened(f, around, slopes)
    assert zero.contains(2)
    assert slope.contains(-2)
    assert zero.rad() < 1e-50
    assert slope.rad() < 1e-50
    for wrong in (arb(2.1, 1e-6), arb(1.9, 1e-6)):
        with pytest.raises(UndecidedError):
            first_root.sharpened(f, wrong, slopes)
    with pytest.raises(UndecidedError):
        first_root.sharpened(f, around, [arb(0, 1), arb(-2), arb(0)])


# -- tables


def test_what_terms_grow_to_is_bounded_derivative_by_derivative():
    """sum |t_k| h^k and its derivatives at h are the largest of sum t_k x^k for |x| <= h."""
    h = 0.375
    matrix = table_bounds._growth(h)
    assert (matrix.nrows(), matrix.ncols()) == (HIGHEST + 1, TERMS + 1)
    for order in range(HIGHEST + 1):
        for k in range(TERMS + 1):
            wanted = 0.0
            if k >= order:
                wanted = factorial(k) / factorial(k - order) * h ** (k - order)
            assert float(matrix[order, k]) == pytest.approx(wanted)


def test_bounds_are_joined_number_by_number_and_finite():
    joined = TableBounds([1.0, 5.0], [7.0, 2.0]).joined(TableBounds([3.0, 4.0], [6.0, 8.0]))
    assert joined == ([3.0, 5.0], [7.0, 8.0])
    assert 2.5 < table_bounds._finite(arb(2, 0.5)) < 2.500001
    with pytest.raises(UndecidedError):
        table_bounds._finite(arb("1e400"))


def test_a_series_of_the_lift_is_as_long_as_it_is_asked_for(monkeypatch):
    """One of a level stretch is its height; one that is shorter bounds nothing."""
    monkeypatch.setattr(ctx, "cap", TERMS + 1)
    found = table_bounds._series(level(0, 1), arb_series([0.5, 1]))
    assert found.prec == TERMS + 1
    assert [found[k] for k in range(TERMS + 1)] == [1] + [0] * TERMS
    for terms, fits in ((TERMS + 1, True), (TERMS, False)):
        one = Made(lift=lambda x, n=terms: arb_series(list(range(n)), n))
        if fits:
            found = table_bounds._series(one, arb_series([0.5, 1]))
            assert [found[k] for k in range(terms)] == list(range(terms))
        else:
            with pytest.raises(UndecidedError):
                table_bounds._series(one, arb_series([0.5, 1]))


def table(*rows) -> Made:
    """A table of stretches (start, end, pieces)."""
    return Made(stretches=[Made(start=a, end=b, piece_count=n) for a, b, n in rows])


def level(start, end) -> BallStretch:
    return BallStretch(arb(start), arb(end), None, arb(1))


def test_a_table_has_a_piece_where_each_stretch_begins():
    one = table((0.0, 2.0, 4), (2.0, 5.0, 2))
    assert table_bounds._edges(one) == [0.0, 0.5, 1.0, 1.5, 2.0, 3.5, 5.0]
    for starts, fits in (((0, 2), True), ((0, 1.5, 3.5), True), ((0, 1.5 + 1e-15), True),
                         ((0, 1.5 + 1e-14), False), ((0.25, 2), False)):  # fmt: skip
        ends = (*starts[1:], 5)
        stretches = [level(a, b) for a, b in zip(starts, ends, strict=True)]
        assert table_bounds._matches(stretches, one) is fits
    sliver = [level(0, 1.5), level(1.5, 1.5 + 1e-13), level(2, 5)]
    assert not table_bounds._matches(sliver, one)


def test_what_stretches_jump_by_inside_a_stretch_of_the_table_is_an_error():
    """At 1 rad and by less at 1.5, but not at 2 rad, where the table has an end itself."""

    def cubic(a, b, c, d):
        return lambda x: a + b * x + c * x * x + d * x * x * x

    stretches = [
        BallStretch(arb(0), arb(1), cubic(1, 2, 3, 4), None),
        BallStretch(arb(1), arb(1.5), cubic(2, 2, 3, 4.5), None),
        BallStretch(arb(1.5), arb(2), cubic(2.25, 2, 3, 4.5), None),
        BallStretch(arb(2), arb(3), cubic(90, 0, 0, 0), None),
    ]
    jumps = table_bounds._jumps(stretches, table((0.0, 2.0, 2), (2.0, 3.0, 1)))
    assert jumps == pytest.approx([1.5, 1.5, 3.0, 3.0, 0.0], abs=1e-6)
    assert table_bounds._jumps(stretches[:1], table((0.0, 1.0, 1))) == [0.0] * (HIGHEST + 1)


def test_a_series_of_a_lift_has_as_many_terms_as_are_asked_for():
    with table_bounds._long_series():
        x = arb_series([arb(0.5), 1], TERMS + 1)
        flat = table_bounds._series(level(0, 1), x)
        assert [float(flat[k]) for k in range(3)] == [1.0, 0.0, 0.0]
        square = BallStretch(arb(0), arb(1), lambda x: x * x, None)
        found = table_bounds._series(square, x)
        assert [float(found[k]) for k in range(4)] == [0.25, 1.0, 1.0, 0.0]
        short = BallStretch(arb(0), arb(1), lambda x: arb_series([1, 2], 2), None)
        with pytest.raises(UndecidedError):
            table_bounds._series(short, x)
