"""sin, cos, acos and pi in 40-digit decimals: cam tables with the same bits on every machine.

Python's `decimal` rounds correctly on every platform, a C library or LAPACK does not. The module is
the `Numbers` that a cam's `parts` are made of by default; `exact.balls` is another.
"""

from decimal import Decimal, localcontext
from functools import cache
from typing import Any, Protocol

DIGITS = 40


class Numbers(Protocol):
    """Real numbers to make a cam of: they add, multiply, divide and have a method `sqrt`."""

    def number(self, value: float | Decimal, /) -> Any:
        """A number of the data, exactly."""

    def pi(self) -> Any:
        """pi."""

    def sincos(self, x: Any, /) -> tuple[Any, Any]:
        """(sin x, cos x)."""

    def acos(self, y: Any, /) -> Any:
        """acos y, rad."""

    def radians(self, degrees: Decimal, /) -> Any:
        """Degrees to rad."""


def number(value: float | Decimal) -> Decimal:
    """A double, or a decimal as written, in all its digits."""
    return Decimal(value)


@cache
def pi() -> Decimal:
    """pi by Machin's formula, 16 atan(1/5) - 4 atan(1/239)."""
    with localcontext() as context:
        context.prec = DIGITS + 5

        def atan_inverse(n: int) -> Decimal:
            power = total = Decimal(1) / n
            k = 1
            while abs(power) > Decimal(10) ** -(DIGITS + 5):
                power /= -n * n
                k += 2
                total += power / k
            return total

        return 16 * atan_inverse(5) - 4 * atan_inverse(239)


def sincos(x: Decimal) -> tuple[Decimal, Decimal]:
    """(sin x, cos x) for moderate x: Taylor series after halving to |x| < 0.1, then doubling."""
    with localcontext() as context:
        context.prec = DIGITS + 8
        halvings = 0
        while abs(x) > Decimal("0.1"):
            x /= 2
            halvings += 1
        square = -x * x
        sine = term = x
        versine = other = -square / 2
        k = 2
        while abs(term) > Decimal(10) ** -(DIGITS + 8):
            term *= square / (k * (k + 1))
            sine += term
            other *= square / ((k + 1) * (k + 2))
            versine += other
            k += 2
        for _ in range(halvings):
            sine, versine = 2 * sine * (1 - versine), 2 * sine * sine
        return sine, 1 - versine


def acos(y: Decimal) -> Decimal:
    """acos y for |y| <= 1: bisection-safe Newton on cos x = y from the float guess."""
    from math import acos as guess

    with localcontext() as context:
        context.prec = DIGITS + 8
        if abs(y) >= 1:
            return Decimal(0) if y > 0 else +pi()
        x = Decimal(guess(float(y)))
        for _ in range(6):
            sine, cosine = sincos(x)
            if sine == 0:
                break
            x += (cosine - y) / sine
        return x


def radians(degrees: Decimal) -> Decimal:
    """Degrees to radians in full digits."""
    with localcontext() as context:
        context.prec = DIGITS + 5
        return degrees * pi() / 180
