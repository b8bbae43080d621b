"""Exact numbers as text: the decimal number that a double, a fraction or an exact ball is."""

from decimal import Decimal
from fractions import Fraction

from flint import arb

SMALLEST = 1e-30  # a smaller double is written with an exponent


def exact(value: float) -> str:
    """The decimal number that a double is."""
    if value and abs(value) < SMALLEST:
        return decimal(Fraction(value))
    return f"{Decimal(float(value)):f}"


def decimal(value: Fraction) -> str:
    """A fraction whose denominator has no primes but 2 and 5, as a decimal number."""
    places = 0
    while value.denominator > 1:
        value *= 10
        places += 1
    return f"{value.numerator}e-{places}" if places else str(value.numerator)


def exactly(x: arb) -> str:
    """A ball without radius as the decimal number that it is."""
    fraction = x.mid().fmpq()
    return decimal(Fraction(int(fraction.p), int(fraction.q)))
