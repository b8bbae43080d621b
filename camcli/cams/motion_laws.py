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
from typing import Any, Literal

from camcli.cams import decimals
from camcli.cams.decimals import DIGITS, Numbers

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
    height: Callable[[Any], Any]


def named(name: str, numbers: Numbers = decimals) -> list[Segment]:
    """The segments of a law by its name."""
    if name in POLYNOMIALS:
        return [Segment(Decimal(0), Decimal(1), _polynomial(POLYNOMIALS[name]))]
    b, d = SCCA[name]
    return scca(Decimal(b), Decimal(d), numbers)


def _polynomial(terms: dict[int, int]) -> Callable[[Any], Any]:
    """s = sum terms[n] x^n."""

    def height(x: Any) -> Any:
        total = 0 * x
        for n in range(max(terms), -1, -1):
            total = total * x + terms.get(n, 0)
        return total

    return height


def peak(b: Any, d: Any, numbers: Numbers = decimals) -> Any:
    """C_a, the largest s'' of an SCCA law.

    C_a = 4 pi^2 / ((pi^2 - 8)(b^2 - d^2) - 2 pi (pi - 2) b + pi^2)
    """
    with localcontext() as context:
        context.prec = DIGITS + 5
        p = numbers.pi()
        return 4 * p * p / ((p * p - 8) * (b * b - d * d) - 2 * p * (p - 2) * b + p * p)


def scca(b: Decimal, d: Decimal, numbers: Numbers = decimals) -> list[Segment]:
    """The sine-constant-cosine acceleration law of widths b, c = 1 - b - d, d.

    s'' = C_a times: sin(pi x/b) up to b/2; 1 up to (1 - d)/2; cos(pi (x - (1 - d)/2)/d) up to
    (1 + d)/2; then the mirror image, s(x) = 1 - s(1 - x). Zones of no width are left out.
    """
    rise, flat, turn = b / 2, (1 - d) / 2, (1 + d) / 2
    wide = numbers.number(b), numbers.number(d)
    ca = peak(*wide, numbers)
    sine, constant = _sine(wide[0], ca, numbers), _constant(wide[0], ca, numbers)
    cosine = _cosine(*wide, ca, numbers)
    if b == d and b + d == 1:  # cycloidal: one sine throughout
        return [Segment(Decimal(0), Decimal(1), sine)]
    edges = (Decimal(0), rise, flat, turn, 1 - rise, Decimal(1))
    heights = (sine, constant, cosine, _mirrored(constant), _mirrored(sine))
    zones = zip(edges, edges[1:], heights, strict=False)
    return [Segment(start, end, height) for start, end, height in zones if end > start]


def _sine(b: Any, ca: Any, numbers: Numbers) -> Callable[[Any], Any]:
    """s = C_a (b/pi x - (b/pi)^2 sin(pi x/b)), zone 1."""

    def height(x: Any) -> Any:
        width = b / numbers.pi()
        return ca * width * (x - width * numbers.sincos(x / width)[0])

    return height


def _constant(b: Any, ca: Any, numbers: Numbers) -> Callable[[Any], Any]:
    """s = C_a (x^2/2 + b (1/pi - 1/2) x + b^2 (1/8 - 1/pi^2)), zone 2."""

    def height(x: Any) -> Any:
        width = b / numbers.pi()
        return ca * (x * x / 2 + (width - b / 2) * x + b * b / 8 - width * width)

    return height


def _cosine(b: Any, d: Any, ca: Any, numbers: Numbers) -> Callable[[Any], Any]:
    """Zone 3, with y = x - (1 - d)/2:

    s = C_a ((b/pi + c/2) x + (d/pi)^2 (1 - cos(pi y/d)) + b^2 (1/8 - 1/pi^2) - (1 - d)^2/8)
    """

    def height(x: Any) -> Any:
        wide, width = d / numbers.pi(), b / numbers.pi()
        wave = wide * wide * (1 - numbers.sincos((x - (1 - d) / 2) / wide)[1])
        level = b * b / 8 - width * width - (1 - d) * (1 - d) / 8
        return ca * ((width + (1 - b - d) / 2) * x + wave + level)

    return height


def _mirrored(height: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def mirrored(x: Any) -> Any:
        return 1 - height(1 - x)

    return mirrored
