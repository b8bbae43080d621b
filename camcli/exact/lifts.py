"""The cam in decimals, stretch by stretch as the kernel counts them.

A part gives c(theta) as a function, or as polynomials with double coefficients that are taken as
they are. Derivatives of a function are central differences of order 2 REACH at steps of h:
    c'  = sum over k of a_k (c(+k h) - c(-k h))/h,         a_k = (-1)^(k+1) (n!)^2/(k (n-k)! (n+k)!)
    c'' = sum over k of 2 a_k/k (c(+k h) + c(-k h) - 2 c)/h^2,                             n = REACH
They neglect (n!)^2/(2n+1)! h^(2n) times the derivative of order 2n + 1, that is (h/R)^12 5e5/R with
R rad to the nearest singularity, 1e-90 m/rad at R = 0.1, and lose 9 or 18 digits of c.
"""

from __future__ import annotations

from decimal import Decimal
from math import factorial

from camcli.cams.pieces import Part, Piece
from camcli.kernel.cam_table import END, ROW, START
from camcli.system import System

REACH = 6
STEP = Decimal("1e-9")  # rad, h


class Lifts:
    """c and its derivatives by stretch; m, rad."""

    def __init__(self, system: System):
        self.parts = [_part_of(system, i) for i in range(system.cam.stretches)]

    def edges(self, i: int) -> tuple[Decimal, Decimal]:
        """Ends of the smooth part that stretch i lies on, rad."""
        return self.parts[i].start, self.parts[i].end

    def c(self, i: int, theta: Decimal) -> Decimal:
        """Lift on stretch i, m."""
        part = self.parts[i]
        if part.pieces:
            return _polynomial(_piece(part, theta), theta, 0)
        return part.level if part.lift is None else part.lift(theta)

    def c1(self, i: int, theta: Decimal) -> Decimal:
        """c_theta on stretch i, m/rad."""
        part = self.parts[i]
        if part.pieces:
            return _polynomial(_piece(part, theta), theta, 1)
        if part.lift is None:
            return Decimal(0)
        pairs = ((part.lift(theta + x), part.lift(theta - x)) for x in _steps())
        return sum(a * (p - m) for a, (p, m) in zip(_weights(), pairs, strict=True)) / STEP

    def c2(self, i: int, theta: Decimal) -> Decimal:
        """c_thetatheta on stretch i, m/rad^2."""
        part = self.parts[i]
        if part.pieces:
            return _polynomial(_piece(part, theta), theta, 2)
        if part.lift is None:
            return Decimal(0)
        twice = 2 * part.lift(theta)
        total = Decimal(0)
        for k, (a, x) in enumerate(zip(_weights(), _steps(), strict=True), 1):
            total += 2 * a / k * (part.lift(theta + x) + part.lift(theta - x) - twice)
        return total / (STEP * STEP)


def _steps() -> list[Decimal]:
    return [k * STEP for k in range(1, REACH + 1)]


def _weights() -> list[Decimal]:
    """The a_k, with the digits of the context."""
    n = REACH
    return [
        Decimal((-1) ** (k + 1) * factorial(n) ** 2) / (k * factorial(n - k) * factorial(n + k))
        for k in range(1, n + 1)
    ]


def _part_of(system: System, i: int) -> Part:
    """The part that holds the middle of stretch i."""
    rows = system.cam.rows
    middle = Decimal(0.5 * (float(rows[i * ROW + START]) + float(rows[i * ROW + END])))
    return next(part for part in system.parts if part.start <= middle <= part.end)


def _piece(part: Part, theta: Decimal) -> Piece:
    """The piece that holds theta: they have equal widths."""
    width = (part.end - part.start) / len(part.pieces)
    k = int((theta - part.start) / width)
    return part.pieces[min(max(k, 0), len(part.pieces) - 1)]


def _polynomial(piece: Piece, theta: Decimal, order: int) -> Decimal:
    """The order-th derivative of sum a_j x^j, x = theta - center."""
    x = theta - Decimal(piece.center)
    total = Decimal(0)
    for j in range(len(piece.coefficients) - 1, order - 1, -1):
        factor = factorial(j) // factorial(j - order)
        total = total * x + factor * Decimal(piece.coefficients[j])
    return total
