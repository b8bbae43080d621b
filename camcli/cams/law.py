"""`kind: law`: base dwell, rise, top dwell and fall, each motion by a standard law s(x).

With h = lift and x the angle since the motion's start over its length beta:
    rise  c = base + h s(x)          fall  c = base + h (1 - s(x))
    c_theta = +-h/beta s'(x),        c_thetatheta = +-h/beta^2 s''(x)
The rest of the turn is base dwell. Angles are taken as written, exactly, so that 100.1 + 259.9
is 360; the rise may begin anywhere, also so that the lobe passes through theta = 0.

s goes from 0 at x = 0 to 1 at x = 1. Formulas: R. L. Norton, Cam Design and Manufacturing Handbook,
2nd edition (2009), chapters 3 (SCCA family) and 4 (polynomials). Largest s', s'':
    constant-velocity      1,       -         constant-acceleration  2,      4
    harmonic               1.57080, 4.93480   cycloidal              2,      6.28319
    modified-sine          1.75960, 5.52796   modified-trapezoid     2,      4.88812
    3-4-5                  1.875,   5.77350   4-5-6-7                2.1875, 7.51318
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Annotated, Any, Literal

from flint import arb, fmpq
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, model_validator

from camcli.cams.balls import UndecidedError, below, head, number, radians
from camcli.cams.compile import Part
from camcli.cams.lash import LashedCam

LawName = Literal[
    "harmonic", "cycloidal", "3-4-5", "4-5-6-7", "modified-trapezoid", "modified-sine",
    "constant-acceleration", "constant-velocity",
]  # fmt: skip
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
Height = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Lift = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
CLOSURE = 1e-9  # deg, and share of a law: a sum this close to its bound meets it
TURN = 360  # deg


class Widths(BaseModel):
    """Widths of the sine, constant and cosine parts of the acceleration; b + c + d = 1."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    b: Share = Field(description="share with a sine, half of it at each end, -")
    c: Share = Field(description="share with constant acceleration, half before the middle, -")
    d: Share = Field(description="share with a cosine, in the middle, -")

    @model_validator(mode="after")
    def _whole(self) -> Widths:
        rest = self.b + self.c + self.d - 1.0
        if abs(rest) > CLOSURE:
            raise ValueError(f"b + c + d = {self.b + self.c + self.d:.10g}: the sum must be 1")
        return self

    def with_width(self, name: str, value: Any) -> Widths:
        """The widths where one of them is a double, a ball or a series; the sum stays 1.

        The constant part c goes along, and with c the sine's b. A width of 0 stays 0, so that the
        law keeps its parts: then it is the third one that goes along.
        """
        others = [other for other in ("c", "b", "d") if other != name]
        not_zero = [other for other in others if getattr(self, other) != 0.0]
        goes_along = (not_zero or others)[0]
        stays = others[1] if goes_along == others[0] else others[0]
        width_that_stays = written(getattr(self, stays))
        if isinstance(value, float | int):
            rest = float(1 - written(value) - width_that_stays)
        else:
            rest = 1 - value - number(width_that_stays)
        return self.model_copy(update={name: value, goes_along: rest})


class SccaLaw(BaseModel):
    """A law of the SCCA family with widths of one's own."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    scca: Widths = Field(description="widths b, c, d of sine, constant, cosine acceleration")


Length = Annotated[
    float, Field(ge=1e-6, le=360, allow_inf_nan=False, description="length of the motion, deg")
]
Law = Annotated[
    Annotated[LawName, Tag("name")] | Annotated[SccaLaw, Tag("scca")],
    Discriminator(lambda value: "scca" if isinstance(value, dict | SccaLaw) else "name"),
    Field(description="law of motion: a name, or {scca: {b: ..., c: ..., d: ...}}"),
]


class Rise(BaseModel):
    """A rise: where it begins, its length and law."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    start_deg: float = Field(
        ge=-360, le=360, allow_inf_nan=False, description="where the rise begins, deg"
    )
    length_deg: Length
    law: Law


class Fall(BaseModel):
    """A fall: its length and law; it begins where the top dwell ends."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    length_deg: Length
    law: Law


class LawCam(LashedCam):
    """A dwell-rise-dwell-fall cam; lengths in m, angles in deg.

    Examples
    --------
    >>> import camcli
    >>> from camcli.cams import LawCam
    >>> cam = LawCam(
    ...     kind="law", base=0.0, lift=0.01,
    ...     rise={"law": "cycloidal", "start_deg": 90, "length_deg": 90},
    ...     fall={"law": "cycloidal", "length_deg": 90},
    ... )
    >>> system = camcli.System.build(camcli.Follower(mass=1.2, stiffness=1430.8), cam)
    >>> [abs(round(c, 12)) for c in system.lift_range]
    [0.0, 0.01]
    """

    kind: Literal["law"]
    base: Height = Field(description="c on the base dwell, any sign, m")
    lift: Lift = Field(description="c on the top dwell minus base, m")
    rise: Rise = Field(description="from base to top")
    top_dwell_deg: float = Field(
        default=0.0, ge=0, lt=360, allow_inf_nan=False, description="top dwell, deg"
    )
    fall: Fall = Field(description="from top to base, after the top dwell")

    @model_validator(mode="after")
    def _fits(self) -> LawCam:
        """Refuse a rise, a top dwell and a fall that take more than a turn together."""
        lobe = written(self.rise.length_deg) + written(self.top_dwell_deg)
        lobe += written(self.fall.length_deg)
        if lobe > TURN + written(CLOSURE):
            raise ValueError(
                f"rise, top dwell and fall take {float(lobe):.10g} deg, "
                f"{float(lobe - TURN):.10g} deg too much: "
                "with the base dwell they share one turn of 360 deg"
            )
        return self

    @property
    def base_level(self) -> Any:
        """c on the base circle, m."""
        return number(self.base)

    def lobe(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi.

        They follow one another from the start of the rise on, and are then put in order of phase.
        """
        start = within_turn(degrees(self.rise.start_deg))
        rise = degrees(self.rise.length_deg)
        dwell = degrees(self.top_dwell_deg)
        fall = _smaller(degrees(self.fall.length_deg), TURN - rise - dwell)
        top = start + rise
        low = number(self.base)
        lift = number(self.lift)
        parts = [
            *_motion(self.rise.law, start, rise, low, lift),
            *_dwell(top, top + dwell, dwell, low + lift),
            *_motion(self.fall.law, top + dwell, fall, low + lift, -lift),
            *_dwell(top + dwell + fall, start + TURN, TURN - rise - dwell - fall, low),
        ]
        return sorted(parts, key=lambda part: float(head(part.start).mid()))


def written(value: float) -> Fraction:
    """The decimal number that a person wrote: 0.1, not the double nearest to it."""
    return Fraction(repr(float(value)))


def degrees(value: Any) -> Any:
    """The exact number that an angle was written as; an angle that varies is returned as it is."""
    return _rational(written(value)) if isinstance(value, float | int) else value


def _rational(value: Any) -> Any:
    """A fraction as a number that adds to balls and to series; these are returned as they are."""
    return fmpq(value.numerator, value.denominator) if isinstance(value, Fraction) else value


def within_turn(angle: Any) -> Any:
    """The same angle from 0 to 360 deg."""
    if isinstance(angle, fmpq):
        return angle - TURN * (angle / TURN).floor()
    return angle - TURN * (head(angle) / TURN).mid().floor()


def _below(a: Any, b: Any) -> bool:
    """Whether one angle is certainly smaller than another one; UndecidedError where it is open."""
    if isinstance(a, fmpq) and isinstance(b, fmpq):
        return bool(a < b)
    difference = head(number(b) - number(a))
    if difference == 0:
        return False
    return below(0, difference)


def _smaller(a: Any, b: Any) -> Any:
    """The smaller one of two angles."""
    return b if _below(b, a) else a


def _larger(a: Any, b: Any) -> Any:
    """The larger one of two angles."""
    return b if _below(a, b) else a


def _motion(law: str | SccaLaw, start: Any, length: Any, low: Any, step: Any) -> Iterator[Part]:
    """Parts of a motion from c = low to low + step, m, in the `length` deg behind `start`."""

    def lift_on_turn(segment: LawSegment, turn: int) -> Callable[[Any], Any]:
        """c = low + step s((theta - start)/length) on the turn that begins at `turn` deg."""
        origin = radians(start - turn)
        beta = radians(length)
        return lambda theta: low + step * segment.height((theta - origin) / beta)

    for segment in _segments(law):
        begin = start + length * _rational(segment.start)
        end = start + length * _rational(segment.end)
        yield from _folded(begin, end, arb(0), partial(lift_on_turn, segment))


def _dwell(start: Any, end: Any, length: Any, level: Any) -> Iterator[Part]:
    """Parts of a dwell at `level`, m, of `length` deg from start to end; none where it is zero.

    length: end - start, given as well because the balls of two ends that vary alike do not tell
    that the ends are the same.
    """
    is_empty = length == 0
    if not is_empty:
        yield from _folded(start, end, level)


def _folded(
    low: Any,
    high: Any,
    level: Any,
    lift_on_turn: Callable[[int], Callable[[Any], Any]] | None = None,
) -> Iterator[Part]:
    """Parts of the turn, 0 to 360 deg, from an interval within two turns, 0 to 720 deg.

    lift_on_turn: returns c(theta) for the first turn (0) and for the second one (360), theta in rad
    from the turn's beginning; None for a dwell at `level`, m.
    """
    for turn in (0, TURN):
        start = _larger(low - turn, fmpq(0))
        end = _smaller(high - turn, fmpq(TURN))
        if _below(start, end):
            lift = None if lift_on_turn is None else lift_on_turn(turn)
            yield Part(radians(start), radians(end), lift, level)


# -- normalised laws of motion -----------------------------------------------------------------


@dataclass(frozen=True)
class LawSegment:
    """A smooth part of a law, start <= x <= end; `height` is s(x), analytic beyond both."""

    start: Any  # a fraction, or where a width of the law varies a ball or a series
    end: Any
    height: Callable[[Any], Any]


def _segments(law: str | SccaLaw) -> list[LawSegment]:
    """The smooth parts of a law on 0 <= x <= 1."""
    if isinstance(law, SccaLaw):
        return _scca(*_widths(law.scca))
    if law in SCCA:
        b, d = map(Fraction, SCCA[law])
        return _scca(b, 1 - b - d, d)
    terms = POLYNOMIALS[law]

    def height(x: Any) -> Any:
        """sum terms[n] x^n, by Horner's scheme."""
        total = 0 * x
        for n in range(max(terms), -1, -1):
            total = total * x + terms.get(n, 0)
        return total

    return [LawSegment(Fraction(0), Fraction(1), height)]


def _widths(given: Widths) -> tuple[Any, Any, Any]:
    """(b, c, d) of a law: the decimal numbers that were written, or balls or series that vary.

    Of decimal numbers b and d count, and c is what they leave.
    """
    widths = (given.b, given.c, given.d)
    if any(not isinstance(width, float) for width in widths):
        b, c, d = (_as_it_varies(width) for width in widths)
        return b, c, d
    sine = written(given.b)
    cosine = min(written(given.d), 1 - sine)
    return sine, 1 - sine - cosine, cosine


def _as_it_varies(width: Any) -> Any:
    """The exact number that a width was written as; a width that varies is returned as it is."""
    return written(width) if isinstance(width, float) else width


def _scca(b: Any, c: Any, d: Any) -> list[LawSegment]:
    """The sine-constant-cosine acceleration law of widths b, c, d: fractions, balls or series.

    s'' = C_a times: sin(pi x/b) up to b/2; 1 up to (1 - d)/2; cos(pi (x - (1 - d)/2)/d) up to
    (1 + d)/2; then the mirror image, s(x) = 1 - s(1 - x). Zones of no width are left out.
    C_a = 4 pi^2 / ((pi^2 - 8)(b^2 - d^2) - 2 pi (pi - 2) b + pi^2) is the largest s''.
    """
    pi = arb.pi()
    beta = number(b)
    delta = number(d)
    curved = (pi * pi - 8) * (beta * beta - delta * delta) - 2 * pi * (pi - 2) * beta
    ca = 4 * pi * pi / (curved + pi * pi)
    width = beta / pi
    wide = delta / pi

    def sine(x: Any) -> Any:
        """C_a (b/pi x - (b/pi)^2 sin(pi x/b)), zone 1."""
        return ca * width * (x - width * (x / width).sin())

    def constant(x: Any) -> Any:
        """C_a (x^2/2 + b (1/pi - 1/2) x + b^2 (1/8 - 1/pi^2)), zone 2."""
        return ca * (x * x / 2 + (width - beta / 2) * x + beta * beta / 8 - width * width)

    def cosine(x: Any) -> Any:
        """Zone 3, with y = x - (1 - d)/2:

        C_a ((b/pi + c/2) x + (d/pi)^2 (1 - cos(pi y/d)) + b^2 (1/8 - 1/pi^2) - (1 - d)^2/8)
        """
        wave = wide * wide * (1 - ((x - (1 - delta) / 2) / wide).cos())
        level = beta * beta / 8 - width * width - (1 - delta) * (1 - delta) / 8
        return ca * ((width + (1 - beta - delta) / 2) * x + wave + level)

    def mirrored(height: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda x: 1 - height(1 - x)

    is_cycloidal = isinstance(b, Fraction) and b == d and c == 0
    if is_cycloidal:  # one sine throughout
        return [LawSegment(Fraction(0), Fraction(1), sine)]
    edges = (Fraction(0), b / 2, (1 - d) / 2, (1 + d) / 2, 1 - b / 2, Fraction(1))
    lengths = (b / 2, c / 2, d, c / 2, b / 2)
    heights = (sine, constant, cosine, mirrored(constant), mirrored(sine))
    zones = zip(pairwise(edges), lengths, heights, strict=True)
    return [
        LawSegment(start, end, height)
        for (start, end), length, height in zones
        if _has_a_length(length)
    ]


def _has_a_length(width: Any) -> bool:
    """Whether a zone of this width is there; UndecidedError where a ball leaves it open."""
    if isinstance(width, Fraction):
        return width > 0
    is_there = bool(head(width) > 0)
    if not is_there:
        raise UndecidedError
    return True
