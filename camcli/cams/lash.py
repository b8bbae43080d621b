"""Lash: clearance between the follower and the base circle of its cam, and the seat it rests on.

A valve that is shut does not rest on its cam but on its seat, with the lash h between. What keeps
the follower from falling is then

    max(c(theta) - h, seat),    seat = c on the base circle,

all at the follower: behind a rocker of ratio rho a clearance x at the lobe is h = rho x. Where the
lobe takes over and where it lets go are two corners more, at which the slope of that jumps up; the
seat is a dwell with a restitution of its own (`follower.seat_restitution`). On opening the ramp
hits the resting follower, on closing the follower comes to its seat with the ramp's velocity.

A lash of 0, as a hydraulic tappet has it, leaves the cam as it is drawn; the seat is then where the
lobe is on its base circle.

Where a number p of the cam is a ball or a series (`cams.varied`), a corner theta, at which
h = c - lash - seat is zero, is a ball that holds it for all values in the ball, and as a series it
has the derivative -h_p/h_theta.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from math import comb
from typing import Annotated, Any, NamedTuple, Self

from flint import arb, arb_series
from pydantic import BaseModel, ConfigDict, Field

from camcli.cams.balls import UndecidedError, derivatives, head, number, precision, slope
from camcli.cams.compile import DIGITS, Part, Piece
from camcli.cams.taylor import Taylor

NARROWEST = 1e-7  # rad: a lobe that only touches the height of the seat does not leave it
MOST_CELLS = 400  # of a part of many cams at once, before it is given up
MOST_STEPS = 40  # of Newton's method on a ball, which doubles its digits in each
Height = Callable[[Any], Any]  # c of a ball or of a power series


class LashedCam(BaseModel):
    """A cam that may have lash: every kind but the oscillator's."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    lash: Annotated[float, Field(ge=0, le=1e6, allow_inf_nan=False)] | None = Field(
        None,
        description="clearance on the base circle, at the follower (behind a rocker: at the "
        "valve), m; 0: none, and the base circle is the seat; null: no lash and no seat",
    )

    @property
    @abstractmethod
    def base_level(self) -> Any:
        """c on the base circle, m: the height of the seat."""

    @abstractmethod
    def lobe(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi of the cam as it is drawn."""

    def as_drawn(self) -> Self:
        """The same cam without lash and seat."""
        return self.model_copy(update={"lash": None})

    def parts(self) -> list[Part]:
        """The smooth parts of what the follower rests on: the cam, or with lash cam and seat."""
        if self.lash is None:
            return self.lobe()
        if self.lash == 0.0:
            return seated_on_the_base(self.lobe(), self.base_level)
        return with_lash(self.lobe(), number(self.lash), self.base_level, _varies(self))


def _varies(model: BaseModel) -> bool:
    """Whether a number of a cam, or of a section within it, is a ball or a series."""
    for _, value in model:
        if isinstance(value, arb | arb_series):
            return True
        if isinstance(value, BaseModel) and _varies(value):
            return True
    return False


def rises_off_its_seat(cam: LashedCam) -> bool:
    """Whether the lobe lifts by more than the lash; true without lash."""
    if cam.lash is None:
        return True
    with precision(DIGITS):
        return not all(part.seat for part in cam.parts())


def comes_to_its_seat(cam: LashedCam) -> bool:
    """Whether the follower has a seat somewhere in a turn; true without lash."""
    if cam.lash is None:
        return True
    with precision(DIGITS):
        return any(part.seat for part in cam.parts())


def seated_on_the_base(parts: Sequence[Part], base: Any) -> list[Part]:
    """The same parts; those that stay on the base circle are the seat."""
    return [
        replace(part, seat=part.lift is None and not part.pieces and on_base(part, base))
        for part in parts
    ]


def on_base(part: Part, base: Any) -> bool:
    """Whether a dwell is at the height of the base circle."""
    return bool(head(part.level - base).contains(0))


def with_lash(parts: Sequence[Part], lash: Any, seat: Any, varies: bool = False) -> list[Part]:
    """The parts of max(c - lash, seat), heights in m; neighbours on the seat become one part.

    varies: whether the cam is one of many, in balls or series; raises UndecidedError where they
    do not tell where the seat begins and ends.
    """
    result: list[Part] = []
    for drawn in parts:
        for part in _clipped(drawn, lash, seat, varies):
            if result and result[-1].seat and part.seat:
                result[-1] = replace(result[-1], end=part.end)
            else:
                result.append(part)
    return result


def _clipped(part: Part, lash: Any, seat: Any, varies: bool) -> Iterator[Part]:
    """A part of the cam, lowered by the lash and cut where it passes the seat."""
    if part.pieces:
        yield from _clipped_pieces(part, lash, seat)
    elif part.lift is None:
        level = part.level - lash
        above = _is_above(head(level - seat)) if varies else level > seat
        yield replace(part, level=level if above else seat, seat=not above)
    else:
        yield from _clipped_function(part, lash, seat, varies)


def _clipped_function(part: Part, lash: Any, seat: Any, varies: bool) -> Iterator[Part]:
    """`_clipped` of a part whose c is a function."""
    lift = part.lift
    assert lift is not None
    slopes = part.slopes
    lowered = replace(
        part,
        lift=lambda theta: lift(theta) - lash,
        slopes=None if slopes is None else _lowered_slopes(slopes, lash),
        wave=None,
    )
    spans_of = _spans_of_many if varies else _spans
    for span in spans_of(lambda theta: lift(theta) - lash - seat, part):
        if span.above:
            yield replace(lowered, start=span.low, end=span.high)
        else:
            yield Part(span.low, span.high, None, seat, seat=True)


def _lowered_slopes(slopes: Callable[[Any], list[Any]], lash: arb) -> Callable[[Any], list[Any]]:
    """A function like `slopes` whose height is lower by the lash; derivatives are equal."""

    def lowered(theta: Any) -> list[Any]:
        level, *more = slopes(theta)
        return [level - lash, *more]

    return lowered


def _clipped_pieces(part: Part, lash: arb, seat: arb) -> Iterator[Part]:
    """The pieces of a part, lowered by the lash and cut where it reaches the seat.

    Pieces side by side that stay above the seat throughout remain one part, as they are equal.
    """
    count = len(part.pieces)
    width = (part.end - part.start) / count
    whole: list[Piece] = []  # those above the seat throughout, since `start`
    start = part.start
    for k, piece in enumerate(part.pieces):
        low = part.start + width * k
        high = part.start + width * (k + 1)
        level, *slopes = piece.coefficients
        lower = replace(piece, coefficients=(float(level - lash), *slopes))
        spans = list(_spans(_height_above(lower, seat), Part(low, high, None)))
        if len(spans) == 1 and spans[0].above:
            if not whole:
                start = low
            whole.append(lower)
            continue
        if whole:
            yield replace(part, start=start, end=low, pieces=tuple(whole))
            whole = []
        for span in spans:
            if span.above:
                pieces = (_moved(lower, span.low, span.high),)
                yield replace(part, start=span.low, end=span.high, pieces=pieces)
            else:
                yield Part(span.low, span.high, None, seat, seat=True)
    if whole:
        yield replace(part, start=start, end=part.end, pieces=tuple(whole))


def _height_above(piece: Piece, seat: arb) -> Height:
    """A function that returns how far a piece is above the seat at an angle, m."""
    return lambda theta: _value(piece, theta) - seat


def _value(piece: Piece, theta: Any) -> Any:
    """The polynomial with the doubles that it has, at a ball or a power series."""
    x = theta - arb(piece.center)
    total = arb(0)
    for coefficient in reversed(piece.coefficients):
        total = total * x + arb(coefficient)
    return total


def _moved(piece: Piece, low: arb, high: arb) -> Piece:
    """The piece between two of its angles, its polynomial by powers from their middle."""
    center = float((low + high) / 2)
    shift = arb(center) - arb(piece.center)
    coefficients = [arb(coefficient) for coefficient in piece.coefficients]
    count = len(coefficients)
    moved = []
    for j in range(count):  # (x + shift)^n holds the binomial of n over j times shift^(n - j) x^j
        terms = (coefficients[n] * comb(n, j) * shift ** (n - j) for n in range(j, count))
        moved.append(float(sum(terms, arb(0))))
    return Piece(center, float((high - low) / 2), tuple(moved))


class Span(NamedTuple):
    """Angles from low to high, rad, between which the cam is above its seat, or not."""

    low: Any  # a ball, or a series
    high: Any
    above: bool


def _spans(height: Height, part: Part) -> Iterator[Span]:
    """The spans of a part of one cam; height: how far it is above the seat at an angle, m."""
    edges = [part.start, *_zeros(height, part.start, part.end), part.end]
    intervals = [(low, high) for low, high in pairwise(edges) if low < high]
    above = [bool(height((low + high) / 2) > 0) for low, high in intervals]
    begin = part.start
    for k, (_, high) in enumerate(intervals):
        if k + 1 == len(intervals) or above[k + 1] != above[k]:
            yield Span(begin, high, above[k])
            begin = high


def _is_above(height: arb) -> bool:
    """Whether a height above the seat is positive; UndecidedError where the ball leaves it open."""
    if height > 0:
        return True
    if height < 0:
        return False
    raise UndecidedError


class Slope(NamedTuple):
    """Angles from low to high, rad, at which a height has a slope that is not zero, m/rad."""

    low: arb
    high: arb
    rate: arb


def _spans_of_many(height: Height, part: Part) -> Iterator[Span]:
    """`_spans` of a cam whose numbers are balls or series; raises UndecidedError."""

    def above_at(theta: arb) -> bool:
        """Whether every one of the cams is above the seat there."""
        return _is_above(head(height(theta)))

    begin = part.start
    above = above_at(head(part.start))
    for slope_there in _slopes_through_zero(height, head(part.start), head(part.end)):
        if above_at(slope_there.low) != above_at(slope_there.high):
            corner = _corner(height, slope_there)
            yield Span(begin, corner, above)
            begin = corner
            above = not above
    yield Span(begin, part.end, above)


def _slopes_through_zero(height: Height, start: arb, end: arb) -> list[Slope]:
    """The parts of an interval in which a height may be zero, each as wide as it is monotone.

    The interval is halved until in each cell the height has a sign, or its slope has one. Raises
    UndecidedError where it may be zero and flat at once.
    """
    slopes: list[Slope] = []
    cells = [(start, end)]  # still to be looked at, the next one last
    for _ in range(MOST_CELLS):
        if not cells:
            return slopes
        low, high = cells.pop()
        cell = low.union(high)
        middle = arb(((low + high) / 2).mid())
        value, rate = map(head, _value_and_slope(height, cell))
        by_slope = head(height(middle)) + rate * (cell - middle)  # the mean value theorem
        if value > 0 or value < 0 or by_slope > 0 or by_slope < 0:
            continue
        if not (rate > 0 or rate < 0):
            cells += [(middle, high), (low, middle)]
        elif slopes and slopes[-1].high == low:  # both slopes hold that at their common angle
            before = slopes.pop()
            slopes.append(Slope(before.low, high, before.rate.union(rate)))
        else:
            slopes.append(Slope(low, high, rate))
    raise UndecidedError


def _value_and_slope(height: Height, theta: arb) -> tuple[Any, Any]:
    """A height of a cam whose numbers are balls or series, and its derivative by the angle."""
    value, rate = height(Taylor.variable(theta, 1)).derivatives()
    return value, rate


def _corner(height: Height, there: Slope) -> Any:
    """The only zero of a height on a slope, by Newton's method on the ball that holds it.

    With p the number in which a height is a series, the zero is a series too: its derivative by p
    is -h_p/h_theta. Raises UndecidedError where the ball is so wide that the height may be flat in
    it.
    """
    cell = there.low.union(there.high)
    rate = there.rate  # holds the derivative by the angle throughout the cell
    for _ in range(MOST_STEPS):
        middle = arb(cell.mid())
        smaller = (middle - head(height(middle)) / rate).intersection(cell)
        if not smaller.rad() < cell.rad() / 2:
            break
        cell = smaller
        _, rate_in_cell = _value_and_slope(height, cell)
        rate = head(rate_in_cell).intersection(rate)
    value, _ = _value_and_slope(height, cell)
    if not isinstance(value, arb_series):
        return cell
    by_number = slope(value)
    return arb_series([cell, -by_number / rate], 2)


def _zeros(height: Height, start: arb, end: arb) -> list[arb]:
    """The angles in ascending order at which a height changes its sign, each in a ball.

    The interval is halved until in each cell the height has a sign, or its slope has one, or the
    cell is narrower than NARROWEST: there the height only touches zero, as far as it matters.
    """
    zeros: list[arb] = []
    cells = [(start, end)]  # still to be looked at, the next one last
    while cells:
        low, high = cells.pop()
        cell = low.union(high)
        value, rate = derivatives(height, cell, 1)
        if value > 0 or value < 0:
            continue
        middle = ((low + high) / 2).mid()
        if rate > 0 or rate < 0:
            zero = _zero(height, low, high, cell)
            if zero is not None:
                zeros.append(zero)
        elif high - low > NARROWEST:
            cells += [(middle, high), (low, middle)]
    return zeros


def _zero(height: Height, low: arb, high: arb, cell: arb) -> arb | None:
    """The only zero from low to high of a monotone height, by Newton's method on a ball.

    cell: the ball of all angles from low to high. A zero at an end, as far as the digits in use
    tell, is that end. None where the height has the same sign at both ends.
    """
    before = height(low)
    after = height(high)
    if before.contains(0):
        return low
    if after.contains(0):
        return high
    if bool(before > 0) == bool(after > 0):
        return None
    for _ in range(MOST_STEPS):
        middle = cell.mid()
        rate = derivatives(height, cell, 1)[1]
        newton = arb(middle) - height(arb(middle)) / rate
        smaller = newton.intersection(cell)
        if not smaller.rad() < cell.rad() / 2:
            break
        cell = smaller
    return cell
