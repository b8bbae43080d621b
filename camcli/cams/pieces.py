"""From smooth functions to the kernel's table of polynomial pieces (`kernel.profile.Cam`).

A cam kind gives its smooth parts as functions of theta in decimals; here each is interpolated
at Chebyshev nodes, cut into equal pieces until the last coefficients no longer matter.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cache
from math import factorial
from typing import Any, Protocol

from camcli.cams.decimals import DIGITS, Numbers, pi, sincos
from camcli.kernel.cam_table import ORDERS, TERMS

MOST_PIECES = 64
CUTS = 4  # cells of a piece in its bounds
ACCEL_TAIL = Decimal("1e-14")  # neglected part of c_thetatheta, relative to its size
LIFT_TAIL = Decimal("1e-18")  # neglected part of c, relative to its size
NOISE = Decimal("1e-36")  # a term of c below it, relative to c, is rounding: a ramp has no curve


@dataclass(frozen=True)
class Part:
    """A smooth part of the cam: c(theta) on [start, end], angles in rad; lift None is a dwell.

    `lift` must be analytic a little beyond both ends, since these are rounded to doubles.
    A part may bring `pieces` instead: equal polynomials with six continuous derivatives.
    """

    start: Any  # numbers of one kind, `Decimal` unless the maker was asked for others
    end: Any
    lift: Callable[[Any], Any] | None
    level: Any = Decimal(0)  # m, c of a dwell
    pieces: tuple[Piece, ...] = ()

    def edges(self) -> list[float]:
        """Boundaries of the part's own pieces, rad: the stretch around a cut must end there."""
        count = len(self.pieces)
        with localcontext() as context:
            context.prec = DIGITS
            width = (self.end - self.start) / max(1, count)
            return [float(self.start + width * k) for k in range(count)] + [float(self.end)]


class Shape(Protocol):
    """A kind of cam: it gives its smooth parts in the numbers asked for."""

    def parts(self, numbers: Numbers = ...) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi."""


@dataclass(frozen=True)
class Piece:
    """One polynomial: c = sum coefficients[j] (theta - center)^j on |theta - center| <= half."""

    center: float
    half: float
    coefficients: tuple[float, ...]

    def derivative(self, order: int) -> tuple[float, ...]:
        """Coefficients of the order-th derivative, padded to the same length."""
        values = [
            value * (factorial(j) // factorial(j - order))
            for j, value in enumerate(self.coefficients)
            if j >= order
        ]
        return tuple(values + [0.0] * order)

    def row(self) -> list[float]:
        """The kernel's row: centre, then the coefficients of each derivative."""
        return [self.center, *(x for order in range(ORDERS) for x in self.derivative(order))]

    def bounds(self, order: int, cuts: int = CUTS) -> tuple[float, float]:
        """Rigorous (low, high) of the order-th derivative on the piece, by power-sum bounds."""
        return _polynomial_bounds(self.derivative(order), self.half, cuts)


def _polynomial_bounds(coefficients: Sequence[float], half: float, cuts: int):
    """Bounds of a polynomial on [-half, half]: re-expand about the middle of `cuts` cells."""
    low, high = float("inf"), float("-inf")
    for cell in range(cuts):
        middle = half * ((2 * cell + 1) / cuts - 1)
        shifted = _shift(coefficients, middle)
        spread = 0.0
        for value in reversed(shifted[1:]):
            spread = (spread + abs(value)) * (half / cuts)
        spread *= 1.0 + 1e-12
        low, high = min(low, shifted[0] - spread), max(high, shifted[0] + spread)
    return low, high


def _shift(coefficients: Sequence[float], x: float) -> list[float]:
    """Coefficients about x by repeated synthetic division."""
    values = list(coefficients)
    for k in range(len(values) - 1):
        for j in range(len(values) - 2, k - 1, -1):
            values[j] += x * values[j + 1]
    return values


@cache
def _nodes() -> tuple[list[Decimal], list[list[Decimal]]]:
    """Chebyshev nodes on [-1, 1], and the matrix from values there to Chebyshev coefficients."""
    with localcontext() as context:
        context.prec = DIGITS
        step = pi() / (2 * TERMS)
        table = [sincos(step * j)[1] for j in range(4 * TERMS)]
        nodes = [table[2 * j + 1] for j in range(TERMS)]
        rows = [
            [2 * table[k * (2 * j + 1) % (4 * TERMS)] / TERMS for j in range(TERMS)]
            for k in range(TERMS)
        ]
        rows[0] = [value / 2 for value in rows[0]]
        return nodes, rows


@cache
def _chebyshev() -> list[list[int]]:
    """Power coefficients of T_0 .. T_{TERMS-1}, by T_{k+1} = 2 x T_k - T_{k-1}."""
    rows = [[1], [0, 1]]
    while len(rows) < TERMS:
        twice = [0] + [2 * value for value in rows[-1]]
        before = rows[-2] + [0] * (len(twice) - len(rows[-2]))
        rows.append([a - b for a, b in zip(twice, before, strict=True)])
    return rows


def _fit(part: Part, low: float, high: float) -> tuple[Piece, bool]:
    """The interpolating piece on [low, high], and whether its tail is negligible."""
    center, half = (low + high) / 2, (high - low) / 2
    nodes, rows = _nodes()
    middle, width = Decimal(center), Decimal(half)
    values = [part.lift(middle + width * node) for node in nodes]
    series = [sum(a * b for a, b in zip(row, values, strict=True)) for row in rows]
    size = max(map(abs, values))
    series = [value if abs(value) > NOISE * size else Decimal(0) for value in series]
    tail = max(abs(series[-1]), abs(series[-2]))
    # |T_n''| <= n^2 (n^2 - 1)/3 on [-1, 1]
    accel = [abs(value) * (k * k * (k * k - 1)) / 3 for k, value in enumerate(series)]
    good = tail <= LIFT_TAIL * size and max(accel[-2:]) <= ACCEL_TAIL * max(accel)
    powers = [Decimal(0)] * TERMS
    for value, chebyshev in zip(series, _chebyshev(), strict=True):
        for j, factor in enumerate(chebyshev):
            powers[j] += value * factor
    coefficients = tuple(float(value / width**j) for j, value in enumerate(powers))
    return Piece(center, half, coefficients), good


def compile_part(part: Part, low: float, high: float) -> list[Piece]:
    """Equal pieces of `part` on [low, high] rad, as few as double precision allows."""
    if part.pieces:
        return [
            piece
            for piece, (a, b) in zip(part.pieces, itertools.pairwise(part.edges()), strict=True)
            if a < high and b > low
        ]
    if part.lift is None:
        half = (high - low) / 2
        level = (float(part.level),) + (0.0,) * (TERMS - 1)
        return [Piece((low + high) / 2, half, level)]
    with localcontext() as context:
        context.prec = DIGITS
        count = 1
        while True:
            width = (high - low) / count
            edges = [low + width * j for j in range(count)] + [high]
            pieces = []
            for a, b in itertools.pairwise(edges):
                piece, good = _fit(part, a, b)
                if not good and count < MOST_PIECES:
                    break
                pieces.append(piece)
            else:
                return pieces
            count += 1 + count // 4
