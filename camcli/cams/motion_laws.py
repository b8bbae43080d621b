"""Normalised laws of motion s(x): from s = 0 at x = 0 to s = 1 at x = 1, in decimals.

x is the angle over the length beta of the rise, s the height over its lift h; velocity is h/beta
s'(x), acceleration h/beta^2 s''(x). Formulas: R. L. Norton, Cam Design and Manufacturing Handbook,
2nd edition (2009), chapters 3 (SCCA family) and 4 (polynomials). Largest s', s'':
    constant-velocity      1,       -         constant-acceleration  2,      4
    harmonic               1.57080, 4.93480   cycloidal              2,      6.28319
    modified-sine          1.75960, 5.52796   modified-trapezoid     2,      4.88812
    3-4-5                  1.875,   5.77350   4-5-6-7                2.1875, 7.51318
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cache
from typing import Literal

from camcli.cams.decimals import DIGITS, pi, sincos

LawName = Literal[
    "harmonic",
    "cycloidal",
    "3-4-5",
    "4-5-6-7",
    "modified-trapezoid",
    "modified-sine",
    "constant-acceleration",
    "constant-velocity",
]
POLYNOMIALS = {
    "constant-velocity": {1: 1},
    "3-4-5": {3: 10, 4: -15, 5: 6},
    "4-5-6-7": {4: 35, 5: -84, 6: 70, 7: -20},
}
SCCA = {  # (b, d); c = 1 - b - d
    "constant-acceleration": ("0", "0"),
    "harmonic": ("0", "1"),
    "modified-trapezoid": ("0.25", "0.25"),
    "modified-sine": ("0.25", "0.75"),
    "cycloidal": ("0.5", "0.5"),
}


@dataclass(frozen=True)
class Segment:
    """A smooth part of a law, start <= x <= end; `height` is analytic beyond both."""

    start: Decimal
    end: Decimal
    height: Callable[[Decimal], Decimal]


def named(name: str) -> list[Segment]:
    """The segments of a law by its name."""
    if name in POLYNOMIALS:
        return [Segment(Decimal(0), Decimal(1), _polynomial(POLYNOMIALS[name]))]
    return scca(*map(Decimal, SCCA[name]))


def _polynomial(terms: dict[int, int]) -> Callable[[Decimal], Decimal]:
    """s = sum terms[n] x^n."""

    def height(x: Decimal) -> Decimal:
        return sum((factor * x**n for n, factor in terms.items()), Decimal(0))

    return height


@cache
def peak(b: Decimal, d: Decimal) -> Decimal:
    """C_a, the largest s'' of an SCCA law.

    C_a = 4 pi^2 / ((pi^2 - 8)(b^2 - d^2) - 2 pi (pi - 2) b + pi^2)
    """
    with localcontext() as context:
        context.prec = DIGITS + 5
        p = pi()
        return 4 * p * p / ((p * p - 8) * (b * b - d * d) - 2 * p * (p - 2) * b + p * p)


def scca(b: Decimal, d: Decimal) -> list[Segment]:
    """The sine-constant-cosine acceleration law of widths b, c = 1 - b - d, d.

    s'' = C_a times: sin(pi x/b) up to b/2; 1 up to (1 - d)/2; cos(pi (x - (1 - d)/2)/d) up to
    (1 + d)/2; then the mirror image, s(x) = 1 - s(1 - x). Zones of no width are left out.
    """
    ca, rise, flat, turn = peak(b, d), b / 2, (1 - d) / 2, (1 + d) / 2
    sine, constant, cosine = _sine(b, ca), _constant(b, ca), _cosine(b, d, ca)
    if b == d and b + d == 1:  # cycloidal: one sine throughout
        return [Segment(Decimal(0), Decimal(1), sine)]
    edges = (Decimal(0), rise, flat, turn, 1 - rise, Decimal(1))
    heights = (sine, constant, cosine, _mirrored(constant), _mirrored(sine))
    zones = zip(edges, edges[1:], heights, strict=False)
    return [Segment(start, end, height) for start, end, height in zones if end > start]


def _sine(b: Decimal, ca: Decimal) -> Callable[[Decimal], Decimal]:
    """s = C_a (b/pi x - (b/pi)^2 sin(pi x/b)), zone 1."""

    def height(x: Decimal) -> Decimal:
        width = b / pi()
        return ca * width * (x - width * sincos(x / width)[0])

    return height


def _constant(b: Decimal, ca: Decimal) -> Callable[[Decimal], Decimal]:
    """s = C_a (x^2/2 + b (1/pi - 1/2) x + b^2 (1/8 - 1/pi^2)), zone 2."""

    def height(x: Decimal) -> Decimal:
        width = b / pi()
        return ca * (x * x / 2 + (width - b / 2) * x + b * b / 8 - width * width)

    return height


def _cosine(b: Decimal, d: Decimal, ca: Decimal) -> Callable[[Decimal], Decimal]:
    """Zone 3, with y = x - (1 - d)/2:

    s = C_a ((b/pi + c/2) x + (d/pi)^2 (1 - cos(pi y/d)) + b^2 (1/8 - 1/pi^2) - (1 - d)^2/8)
    """

    def height(x: Decimal) -> Decimal:
        wide, width = d / pi(), b / pi()
        wave = wide * wide * (1 - sincos((x - (1 - d) / 2) / wide)[1])
        level = b * b / 8 - width * width - (1 - d) * (1 - d) / 8
        return ca * ((width + (1 - b - d) / 2) * x + wave + level)

    return height


def _mirrored(height: Callable[[Decimal], Decimal]) -> Callable[[Decimal], Decimal]:
    def mirrored(x: Decimal) -> Decimal:
        return 1 - height(1 - x)

    return mirrored
