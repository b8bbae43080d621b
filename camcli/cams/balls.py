"""Real numbers as balls: midpoint and radius, the true number certainly inside (Arb, python-flint).

F. Johansson, Arb: efficient arbitrary-precision midpoint-radius interval arithmetic, IEEE
Transactions on Computers 66 (2017) 1281-1292. A comparison of balls is True only where it holds for
all numbers in them. Where neither it nor its opposite does, more digits may help: `decided` asks
again with twice as many.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from math import factorial
from threading import RLock
from typing import Any, TypeVar

from flint import arb, arb_series, ctx

DIGITS = (380, 760, 1520)  # one after the other; 380 last for 400 turns of weak chaos
NO_LENGTH = 1e-30  # rad: a ball about zero no wider than this is a rounding
COARSE = 64  # bits that exclude contacts as surely as many, where they do
_alone = RLock()  # python-flint has one precision for all threads
Answer = TypeVar("Answer")


class UndecidedError(Exception):
    """The digits in use do not tell which way it goes."""


@contextmanager
def precision(digits: int) -> Iterator[None]:
    """Calculate with so many digits, one thread at a time."""
    with _alone:
        before = ctx.prec
        ctx.dps = digits
        try:
            yield
        finally:
            ctx.prec = before


def decided(question: Callable[[], Answer], tried: Sequence[int] = DIGITS) -> Answer:
    """What `question` returns, with the fewest decimal digits of those tried that decide it.

    `question` raises UndecidedError where the digits in use are too few; so does this, where the
    last of those tried are.
    """
    for digits in tried:
        try:
            with precision(digits):
                return question()
        except UndecidedError:
            if digits == tried[-1]:
                raise
    raise AssertionError


def coarsely(question: Callable[[], Answer]) -> Answer:
    """What `question` returns: with COARSE bits, or, where it is undecided, all that are in use.

    It costs a fraction of the time where the coarse answer suffices.
    """
    full = ctx.prec
    ctx.prec = min(COARSE, ctx.prec)
    try:
        return question()
    except UndecidedError:
        if full <= COARSE:
            raise
    finally:
        ctx.prec = full
    return question()


def below(a: Any, b: Any) -> bool:
    """Is a < b? Raises UndecidedError where the balls overlap."""
    if a < b:
        return True
    if a > b:
        return False
    raise UndecidedError


def number(value: Any) -> Any:
    """A double or a fraction as it is, balls and series too."""
    if isinstance(value, Fraction):
        return arb(value.numerator) / value.denominator
    return value if isinstance(value, arb_series) else arb(value)


def head(value: Any) -> arb:
    """The constant term of a series, or the ball itself."""
    return value[0] if isinstance(value, arb_series) else value


def slope(value: Any) -> arb:
    """The coefficient of a series' first power; 0 of a ball, which depends on no number."""
    return value[1] if isinstance(value, arb_series) else arb(0)


def acos(y: Any) -> Any:
    """acos y, rad, where y is a ball or a series.

    A ball that reaches 1 or -1, through rounding, is taken for that number: beyond it there is no
    angle.
    """
    if isinstance(y, arb_series) or abs(y) < 1:
        return y.acos()
    return arb(0) if y > 0 else arb.pi()


def lasts(start: Any, end: Any) -> bool:
    """Whether a part of a cam that goes from one angle to another (rad) has a length.

    A length that is zero but for rounding, within NO_LENGTH, is none. Raises UndecidedError where a
    wider ball leaves it open.
    """
    length = head(end) - head(start)
    if length > 0:
        return True
    if length < 0 or length.rad() < NO_LENGTH:
        return False
    raise UndecidedError


def radians(degrees: Any) -> Any:
    """Degrees to rad."""
    return number(degrees) * arb.pi() / 180


def derivatives(function: Callable[[Any], Any], x: arb, order: int) -> list[arb]:
    """The value of a function and its derivatives up to an order, by power series."""
    series = function(arb_series([x, 1], order + 1))
    return [series[k] * factorial(k) for k in range(order + 1)]
