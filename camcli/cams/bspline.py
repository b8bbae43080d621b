"""Periodic splines of degree 7 on equal knots: six continuous derivatives, as the kernel wants.

Angles are in knot spacings, u = theta K/(2 pi). Interval i holds u in [i, i + 1] and depends on the
coefficients i, ..., i + 7 (modulo K); coefficient j weighs most at u = j - 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache

from camcli.cams.decimals import DIGITS, pi
from camcli.cams.pieces import Piece
from camcli.kernel.cam_table import TERMS

DEGREE = 7
WIDTH = DEGREE + 1  # coefficients of an interval
CENTER = 3  # coefficient j weighs most at u = j - CENTER


@cache
def weights() -> tuple[tuple[Fraction, ...], ...]:
    """Power coefficients in t = u - i of the weight of coefficient i + k, k = 0 ... 7."""
    pieces = [[Fraction(1)]]  # of degree 0; piece r of a basis function holds [r, r + 1]
    for p in range(1, WIDTH):
        raised = [[Fraction(0)] * (p + 1) for _ in range(p + 1)]
        for r, old in enumerate(pieces):
            for j, value in enumerate(old):
                raised[r][j] += value * r / p
                raised[r][j + 1] += value / p
                raised[r + 1][j] += value * (p - r) / p
                raised[r + 1][j + 1] -= value / p
        pieces = raised
    return tuple(tuple(piece) for piece in reversed(pieces))


@cache
def _floats(order: int) -> tuple[tuple[float, ...], ...]:
    """`weights` derived `order` times by u, in floats, highest power first."""
    rows = []
    for row in weights():
        for _ in range(order):
            row = tuple(value * j for j, value in enumerate(row))[1:]
        rows.append(tuple(float(value) for value in reversed(row)))
    return tuple(rows)


def basis(t: float, order: int = 0) -> list[float]:
    """Weights of the eight coefficients at t in [0, 1] of an interval, or of a derivative by u."""
    result = []
    for row in _floats(order):
        value = 0.0
        for factor in row:
            value = value * t + factor
        result.append(value)
    return result


def at(coefficients: Sequence[float], i: int, row: Sequence[float]) -> float:
    """The spline (or a derivative) in interval i with the weights `row`."""
    count = len(coefficients)
    value = 0.0
    for k in range(WIDTH):
        value += row[k] * coefficients[(i + k) % count]
    return value


def piece(coefficients: Sequence[float], i: int, base: float = 0.0) -> Piece:
    """Interval i, plus a base, as a piece of the kernel's table, rounded once from 40 digits."""
    count = len(coefficients)
    with localcontext() as context:
        context.prec = DIGITS
        width = 2 * pi() / count
        low, high = float(width * i), float(width * (i + 1))
        center = (low + high) / 2
        powers = [Decimal(0)] * WIDTH
        for k, row in enumerate(_integers()):
            value = Decimal(coefficients[(i + k) % count])
            for j, factor in enumerate(row):
                powers[j] += value * factor
        powers[0] += Decimal(base) * _scale()
        t = Decimal(center) / width - i  # about a half: the centre in doubles
        for k in range(DEGREE):  # synthetic division: powers of t - center
            for j in range(DEGREE - 1, k - 1, -1):
                powers[j] += t * powers[j + 1]
        values = [float(value / _scale() / width**j) for j, value in enumerate(powers)]
    return Piece(center, (high - low) / 2, tuple(values + [0.0] * (TERMS - WIDTH)))


@cache
def _scale() -> int:
    """The common denominator of `weights`, 7!."""
    return max(value.denominator for row in weights() for value in row)


@cache
def _integers() -> tuple[tuple[int, ...], ...]:
    return tuple(tuple(int(value * _scale()) for value in row) for row in weights())
