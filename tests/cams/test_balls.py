"""Numbers in balls: how many digits are tried, what a ball tells, and what it leaves open."""

from __future__ import annotations

from fractions import Fraction

import pytest
from flint import arb, arb_series, ctx

from camcli.cams import balls
from camcli.cams.balls import UndecidedError


class Asked:
    """A question that is decided when it is asked for the n-th time."""

    def __init__(self, decided: int):
        self.decided = decided
        self.bits: list[int] = []

    def __call__(self) -> str:
        self.bits.append(ctx.prec)
        if len(self.bits) < self.decided:
            raise UndecidedError
        return "yes"


def bits_of(*digits: int) -> list[int]:
    """The bits that python-flint takes for so many digits."""
    bits = []
    for one in digits:
        with balls.precision(one):
            bits.append(ctx.prec)
    return bits


def test_a_precision_ends_with_its_block():
    before = ctx.prec
    with balls.precision(60):
        outer = ctx.prec
        with balls.precision(200):
            assert ctx.prec > 600
        assert ctx.prec == outer
    assert ctx.prec == before


def test_a_question_is_asked_with_more_and_more_digits():
    tried = (20, 40, 90)
    for decided in (1, 2, 3):
        question = Asked(decided)
        assert balls.decided(question, tried) == "yes"
        assert question.bits == bits_of(*tried[:decided])
    question = Asked(4)
    with pytest.raises(UndecidedError):
        balls.decided(question, tried)
    assert question.bits == bits_of(*tried)


def test_a_question_is_asked_coarsely_before_all_digits_are_taken():
    with balls.precision(60):
        full = ctx.prec
        for decided, bits in ((1, [64]), (2, [64, full])):
            question = Asked(decided)
            assert balls.coarsely(question) == "yes"
            assert question.bits == bits
            assert ctx.prec == full
    for few in (30, 64):
        before = ctx.prec
        try:
            ctx.prec = few
            question = Asked(2)
            with pytest.raises(UndecidedError):
                balls.coarsely(question)
            assert (question.bits, ctx.prec) == ([few], few)
        finally:
            ctx.prec = before


def test_which_of_two_balls_is_below():
    assert balls.below(arb(1), arb(2))
    assert not balls.below(arb(2), arb(1))
    for a, b in ((arb(1), arb(1)), (arb(1), arb(1, 0.1))):
        with pytest.raises(UndecidedError):
            balls.below(a, b)


def test_a_part_lasts_where_its_end_is_behind_its_start():
    """A rounding about zero is no length, a wider ball may be one; of a series its value counts."""
    for length, lasts in ((1, True), (-1, False), (0, False)):
        for width in (0, 1e-40):
            start, end = arb(2), arb(2 + length) + arb(0, width)
            assert balls.lasts(start, end) is lasts
            series = arb_series([start, -7], 2), arb_series([end, 3], 2)
            assert balls.lasts(*series) is lasts
    assert balls.lasts(arb(2), arb(1, 0.25)) is False
    with pytest.raises(UndecidedError):
        balls.lasts(arb(2), arb(2, 1e-20))


def test_numbers_are_balls_and_a_series_stays_one():
    series = arb_series([arb(2), arb(5)], 2)
    assert (balls.number(0.5), balls.number(3)) == (arb(1) / 2, 3)
    with balls.precision(60):
        assert abs(balls.number(Fraction(1, 3)) * 3 - 1) < 1e-50
        assert abs(balls.radians(60.0) * 3 - arb.pi()) < 1e-50
    assert balls.number(series) is series
    assert (balls.head(series), balls.slope(series)) == (2, 5)
    assert (balls.head(arb(7)), balls.slope(arb(7))) == (7, 0)


def test_an_angle_of_a_cosine_that_reaches_one_by_rounding():
    assert balls.acos(arb(1, 1e-20)) == 0
    assert balls.acos(arb(-1, 1e-20)).overlaps(arb.pi())
    assert (balls.acos(arb(1) / 2) * 3).overlaps(arb.pi())
    moved = balls.acos(arb_series([arb(0), arb(1)], 2))
    assert moved[0].overlaps(arb.pi() / 2)
    assert moved[1] == -1


def test_derivatives_by_power_series():
    found = balls.derivatives(lambda x: x * x * x, arb(2), 4)
    assert found == [8, 12, 12, 6, 0]
    assert balls.derivatives(lambda x: x * x * x, arb(2), 1) == [8, 12]
