"""Where polynomials and functions pass the height of a seat, by hand."""

from fractions import Fraction
from math import pi, sqrt
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from camcli.cams import lash
from camcli.cams.balls import precision
from camcli.cams.compile import Part, Piece
from camcli.kernel.cam_table import TERMS


def piece(center: float, *coefficients: float) -> Piece:
    return Piece(center, 0.5, coefficients + (0.0,) * (TERMS - len(coefficients)))


def value(one: Piece, x: float) -> Fraction:
    """The polynomial of a piece in exact numbers."""
    off = Fraction(x) - Fraction(one.center)
    return sum(Fraction(a) * off**n for n, a in enumerate(one.coefficients))


def test_a_piece_between_two_of_its_angles_is_the_same_polynomial():
    one = piece(1.5, 0.3, -0.7, 1.1, 0.9, -2.0, 0.4)
    with precision(60):
        moved = lash._moved(one, arb(1.125), arb(1.375))
        assert float(lash._value(one, arb(1.2))) == pytest.approx(float(value(one, 1.2)), rel=1e-15)
    assert (moved.center, moved.half) == (1.25, 0.125)
    for x in (1.125, 1.2, 1.375):
        assert float(value(moved, x)) == pytest.approx(float(value(one, x)), rel=1e-14)
    shifted = np.polynomial.Polynomial(one.coefficients)(np.polynomial.Polynomial([-0.25, 1.0]))
    assert moved.coefficients[:6] == pytest.approx(shifted.coef[:6], rel=1e-14)
    assert moved.coefficients[6:] == (0.0,) * (TERMS - 6)


def lobe_in_pieces() -> Part:
    """On 2 to 9: below 0.5, rising through it, three times above, falling through it, above."""
    return Part(
        arb(2), arb(9), None,
        pieces=(
            piece(2.5, 0.2), piece(3.5, 0.7, 1.6, 0.3), piece(4.5, 1.9), piece(5.5, 2.9),
            piece(6.5, 3.9), piece(7.5, 0.4, -3.0), piece(8.5, 0.9, 0.1),
        ),
    )  # fmt: skip


def test_pieces_are_cut_where_they_pass_the_seat_and_stay_together_above_it():
    """The lash is 0.25 and the seat at 0.25: 0.7 + 1.6 x + 0.3 x^2 and 0.4 - 3 x are 0.5 there."""
    part = lobe_in_pieces()
    up = 3.5 + (-1.6 + sqrt(1.6**2 - 4 * 0.3 * 0.2)) / 0.6
    down = 7.5 - 0.1 / 3.0
    with precision(60):
        found = lash.with_lash([part], arb("0.25"), arb("0.25"))
        ends = [(float(one.start), float(one.end)) for one in found]
        levels = [float(one.level) for one in found if one.seat]
    wanted = [(2, up), (up, 4), (4, 7), (7, down), (down, 8), (8, 9)]
    assert ends == [pytest.approx(pair, abs=1e-14) for pair in wanted]
    assert [one.seat for one in found] == [True, False, False, False, True, False]
    assert levels == [0.25, 0.25]
    assert [len(one.pieces) for one in found] == [0, 1, 3, 1, 0, 1]
    for one, of in zip((*found[2].pieces, *found[5].pieces), (2, 3, 4, 6), strict=True):
        drawn = part.pieces[of]
        assert (one.center, one.half) == (drawn.center, 0.5)
        assert one.coefficients[0] == pytest.approx(drawn.coefficients[0] - 0.25, rel=1e-15)
        assert one.coefficients[1:] == drawn.coefficients[1:]
    for one, of in ((found[1], 1), (found[3], 5)):
        x = one.pieces[0].center + 0.1 * one.pieces[0].half
        assert float(value(one.pieces[0], x)) == pytest.approx(
            float(value(part.pieces[of], x)) - 0.25, rel=1e-14
        )
        assert one.pieces[0].half == pytest.approx(float(one.end - one.start) / 2, rel=1e-14)


def test_a_dwell_is_lowered_by_the_lash_or_is_the_seat():
    parts = [
        Part(arb(0), arb(1), None, arb(3)), Part(arb(1), arb(2), None, arb("2.5")),
        Part(arb(2), arb(3), None, arb(1)), Part(arb(3), arb(4), None, arb(4)),
    ]  # fmt: skip
    for varies in (False, True):
        found = lash.with_lash(parts, arb("0.75"), arb(2), varies)
        told = [(float(one.start), float(one.end), float(one.level), one.seat) for one in found]
        assert told == [(0, 1, 2.25, False), (1, 3, 2.0, True), (3, 4, 3.25, False)]
    wide = [Part(arb(0), arb(1), None, arb("2.75") + arb(0, 0.1))]
    with pytest.raises(lash.UndecidedError):
        lash.with_lash(wide, arb("0.75"), arb(2), True)


def test_without_clearance_only_dwells_on_the_base_circle_are_the_seat():
    parts = [
        Part(arb(0), arb(1), None, arb(1) + arb(0, 1e-40)), Part(arb(1), arb(2), None, arb(2)),
        Part(arb(2), arb(3), lambda theta: theta, arb(1)),
        Part(arb(3), arb(4), None, arb(1), pieces=(piece(3.5, 1.0),)),
    ]  # fmt: skip
    found = lash.seated_on_the_base(parts, arb(1))
    assert [one.seat for one in found] == [True, False, False, False]
    for told, seats in (((True, True), (True, True)), ((True, False), (True, False)), (
        (False, True), (False, False)
    )):  # fmt: skip
        cam = SimpleNamespace(
            lash=0.1, parts=lambda seats=seats: [SimpleNamespace(seat=seat) for seat in seats]
        )
        comes, rises = told[0], not all(seats)
        assert lash.comes_to_its_seat(cam) is comes
        assert lash.rises_off_its_seat(cam) is rises


def test_zeros_of_a_height_are_found_in_their_order_however_close():
    with precision(60):
        found = lash._zeros(lambda x: (x - 1) ** 2 - arb("1e-8"), arb(0), arb(3))
        assert [float(zero) for zero in found] == pytest.approx([1 - 1e-4, 1 + 1e-4], rel=1e-15)
        found = lash._zeros(lambda x: x.sin() - arb("0.5"), arb(-1), arb(10))
        wanted = [pi / 6, 5 * pi / 6, 13 * pi / 6, 17 * pi / 6]
        assert [float(zero) for zero in found] == pytest.approx(wanted, rel=1e-15)
        assert lash._zeros(lambda x: (x - 1) ** 2, arb(0), arb(3)) == []
        assert lash._zeros(lambda x: x * x + 1, arb(0), arb(3)) == []


@pytest.mark.parametrize(
    ("level", "zero"), [(1, 1.0), (9, 3.0), (2, sqrt(2.0)), ("0.5", None), (10, None)]
)
def test_a_zero_of_a_monotone_height_may_be_either_end(level, zero):
    """x^2 from 1 to 3."""
    with precision(60):
        for sign in (1, -1):
            found = lash._zero(
                lambda x, sign=sign: sign * (x * x - arb(level)), arb(1), arb(3), arb(2, 1)
            )
            assert (found is None) == (zero is None)
            if zero is not None:
                assert float(found) == pytest.approx(zero, rel=1e-15)
                assert found.rad() < 1e-30


def test_spans_with_the_same_answer_side_by_side_are_one(monkeypatch):
    """A height that is -1, 1, 2 and -2 between angles that are given as its zeros."""
    monkeypatch.setattr(lash, "_zeros", lambda height, start, end: [arb(1), arb(3), arb(6)])
    heights = (-1, 1, 2, -2)

    def height(theta: arb) -> arb:
        return arb(heights[sum(float(theta) > edge for edge in (1, 3, 6))])

    found = lash._spans(height, Part(arb(0), arb(10), None))
    spans = [(float(low), float(high), above) for low, high, above in found]
    assert spans == [(0, 1, False), (1, 6, True), (6, 10, False)]
