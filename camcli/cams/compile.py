"""A cam's smooth parts, and the kernel's table of them: `build(shape, strobe)`.

A kind of cam gives its parts as functions of theta in balls. Each is interpolated at Chebyshev
nodes and cut into equal pieces until the last coefficients no longer matter; the stretches of the
table (`kernel.cam_table.Cam`) are the parts, cut once more at the strobe phase.
"""

from __future__ import annotations

import itertools
from bisect import bisect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from math import factorial
from typing import Any, NamedTuple, Protocol

import numpy as np
from flint import arb, arb_mat, fmpz_poly

from camcli.cams.balls import precision, radians
from camcli.kernel.cam_table import (
    ORDERS,
    TERMS,
    TURN,
    Cam,
    Stretch,
    derivative,
    lift_at,
    polynomial,
)  # fmt: skip

DIGITS = 60  # from which coefficients round to the same doubles on every machine
MOST_PIECES = 64
MOST_UNIT_WAVES = 1024  # intervals on which cosine and sine are remembered
HIGHEST = 7  # derivative that is bounded
CUTS = 4  # cells of a piece in its bounds, at least
CELLS = 16  # of a stretch in its bounds, at least: a polynomial law is one piece
SAMPLES = 16  # places of a piece among which the lowest and the highest c are looked for
ACCEL_TAIL = 1e-14  # neglected part of c_thetatheta, relative to its size
LIFT_TAIL = 1e-18  # neglected part of c, relative to its size
NOISE = 1e-36  # a term of c below it, relative to c, is rounding: a ramp has no curve
TAYLOR_ERROR = 2e-17  # m/rad, allowed remainder of the slope of the gap's local series
SLIVER = 1e-12  # rad: a stretch shorter than this is left to its neighbour
SMALLEST_KICK = 1e-9  # m/rad: a jump of c_theta below it is rounding
SMALLEST_JUMP = 1e-9  # of c_thetatheta relative to its largest: below it is rounding


@dataclass(frozen=True)
class Part:
    """A smooth part of the cam: c(theta) on [start, end], angles in rad; lift None is a dwell.

    `lift` must be analytic a little beyond both ends, since these are rounded to doubles.
    A part may bring `pieces` instead: equal polynomials with six continuous derivatives. slopes:
    theta -> c and its first three derivatives, where that is faster than a power series. wave:
    (mean, along, across) where c is mean + along cos theta + across sin theta, which compiles
    faster. seat: whether it is the follower's seat (`lash`).
    """

    start: Any  # a ball; of a cam whose numbers vary it may be a series (`cams.varied`)
    end: Any
    lift: Callable[[Any], Any] | None  # of a ball, or of a power series of balls
    level: Any = 0  # m, c of a dwell
    pieces: tuple[Piece, ...] = ()
    slopes: Callable[[Any], list[Any]] | None = None
    wave: tuple[Any, Any, Any] | None = None
    seat: bool = False

    def edges(self) -> list[float]:
        """Boundaries of the part's own pieces, rad: the stretch around a cut must end there."""
        count = len(self.pieces)
        width = (self.end - self.start) / max(1, count)
        return [float(self.start + width * k) for k in range(count)] + [float(self.end)]


class Shape(Protocol):
    """A kind of cam."""

    def __hash__(self) -> int: ...

    def parts(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi, in the digits in use."""


@dataclass(frozen=True)
class Piece:
    """One polynomial: c = sum coefficients[j] (theta - center)^j on |theta - center| <= half."""

    center: float
    half: float
    coefficients: tuple[float, ...]
    rests: tuple[float, float] = (0.0, 0.0)  # what the first two coefficients leave out

    def derivative(self, order: int) -> tuple[float, ...]:
        """Coefficients of the order-th derivative, padded to the same length."""
        kept = zip(self.coefficients[order:], _factors(order), strict=False)
        return tuple([value * factor for value, factor in kept] + [0.0] * order)

    def row(self) -> list[float]:
        """The kernel's row: centre, the coefficients of each derivative, the rests."""
        values = [x for order in range(ORDERS) for x in self.derivative(order)]
        return [self.center, *values, *self.rests]


@cache
def _factors(order: int) -> list[int]:
    """The factors of the powers in a derivative of that order: of x^order, x^(order + 1), ...

    x^j has j (j - 1) .. (j - order + 1). They go up to j = TERMS.
    """
    return [factorial(j) // factorial(j - order) for j in range(order, TERMS + 1)]


class _Chebyshev(NamedTuple):
    """Interpolation by Chebyshev polynomials T_k at TERMS nodes on [-1, 1]."""

    nodes: list[arb]
    to_series: arb_mat  # values at the nodes -> coefficients a_k of sum a_k T_k
    to_powers: arb_mat  # a_k -> coefficients of the powers of x


@cache
def _chebyshev() -> _Chebyshev:
    """The nodes cos((2 j + 1) pi/(2 TERMS)) and both matrices, in the digits in use."""
    step = arb.pi() / (2 * TERMS)
    terms = range(TERMS)
    nodes = [((2 * j + 1) * step).cos() for j in terms]
    # a_k = (2/TERMS) sum_j value_j T_k(node_j), half of it where k is 0
    to_series = [
        [(k * (2 * j + 1) * step).cos() * min(k + 1, 2) / TERMS for j in terms] for k in terms
    ]
    to_powers = [[fmpz_poly.chebyshev_t(k)[j] for k in terms] for j in terms]
    return _Chebyshev(nodes, arb_mat(to_series), arb_mat(to_powers))


def _tail_is_negligible(sizes: Sequence[float], size: float) -> bool:
    """Whether the last two terms of a Chebyshev series matter neither to c nor to c_thetatheta.

    sizes: |a_k| of the series. size: the largest |c|, m. The second derivative of T_k is at most
    k^2 (k^2 - 1)/3 on [-1, 1].
    """
    accel = [value * (k * k * (k * k - 1)) / 3 for k, value in enumerate(sizes)]
    return max(sizes[-2:]) <= LIFT_TAIL * size and max(accel[-2:]) <= ACCEL_TAIL * max(accel)


def _fit(lift: Callable[[Any], Any], low: float, high: float) -> tuple[Piece, bool]:
    """(the piece that interpolates on [low, high] rad, whether its tail is negligible)."""
    center = (low + high) / 2
    half = (high - low) / 2
    chebyshev = _chebyshev()
    values = [lift(center + half * node) for node in chebyshev.nodes]
    series = (chebyshev.to_series * arb_mat([[value] for value in values])).entries()
    size = max(abs(float(value)) for value in values)
    series = [value if abs(float(value)) > NOISE * size else arb(0) for value in series]
    good = _tail_is_negligible([abs(float(value)) for value in series], size)
    powers = (chebyshev.to_powers * arb_mat([[value] for value in series])).entries()
    exact = [value / arb(half) ** j for j, value in enumerate(powers)]  # of x = half times [-1, 1]
    return _rounded_piece(center, half, exact), good


def _rounded_piece(center: float, half: float, exact: Sequence[arb]) -> Piece:
    """The piece of these coefficients in doubles, and what the doubles of the first two leave."""
    return Piece(center, half, tuple(map(float, exact)), (_rest(exact[0]), _rest(exact[1])))


@dataclass(frozen=True)
class _UnitWaves:
    """Cosine and sine interpolated on an interval; each entry is a pair (cosine, sine)."""

    at_nodes: list[tuple[float, float]]  # their values at the Chebyshev nodes
    series: list[tuple[float, float]]  # their coefficients of T_k
    powers: list[tuple[arb, arb]]  # their coefficients of x^j


@lru_cache(maxsize=MOST_UNIT_WAVES)
def _unit_waves(low: float, high: float) -> _UnitWaves:
    """Cosine and sine on the interval from low to high, rad, in DIGITS digits."""
    center = (low + high) / 2
    half = (high - low) / 2
    chebyshev = _chebyshev()
    values = [(center + half * node).sin_cos()[::-1] for node in chebyshev.nodes]
    series = chebyshev.to_series * arb_mat(values)
    scaled = chebyshev.to_powers * series
    exact = [[scaled[j, i] / arb(half) ** j for i in (0, 1)] for j in range(TERMS)]
    return _UnitWaves(
        [(float(cosine), float(sine)) for cosine, sine in values],
        [(float(series[k, 0]), float(series[k, 1])) for k in range(TERMS)],
        [(cosine, sine) for cosine, sine in exact],
    )


def _fit_wave(wave: tuple[arb, arb, arb], low: float, high: float) -> tuple[Piece, bool] | None:
    """`_fit` of mean + along cos theta + across sin theta, where `wave` is (mean, along, across).

    The interpolation of cosine and sine is remembered for the interval, so this takes two products
    a coefficient. None where a term is so small beside the mean that it might be rounding. A piece
    whose tail matters comes without coefficients, as nobody will use it.
    """
    unit = _unit_waves(low, high)
    mean, along, across = map(float, wave)
    size = max(abs(mean + along * cosine + across * sine) for cosine, sine in unit.at_nodes)
    sizes = [abs(along * cosine + across * sine) for cosine, sine in unit.series]
    if min(sizes[1:]) <= NOISE * size:
        return None
    center = (low + high) / 2
    half = (high - low) / 2
    if not _tail_is_negligible(sizes, size):
        return Piece(center, half, ()), False
    exact_mean, exact_along, exact_across = wave
    exact = [exact_along * cosine + exact_across * sine for cosine, sine in unit.powers]
    exact[0] += exact_mean
    return _rounded_piece(center, half, exact), True


def _rest(value: arb) -> float:
    """The part of a ball's middle that its double leaves out."""
    return float(value - float(value))


def _compile(part: Part, low: float, high: float) -> list[Piece]:
    """Equal pieces of `part` on [low, high] rad, as few as double precision allows."""
    if part.pieces:
        spans = itertools.pairwise(part.edges())
        return [
            piece
            for piece, (start, end) in zip(part.pieces, spans, strict=True)
            if start < high and end > low
        ]
    if part.lift is None:
        half = (high - low) / 2
        level = (float(part.level),) + (0.0,) * (TERMS - 1)
        return [Piece((low + high) / 2, half, level, (_rest(arb(part.level)), 0.0))]
    count = 1
    while True:
        pieces = _equal_pieces(part, low, high, count)
        if pieces is not None:
            return pieces
        count += 1 + count // 4


def _equal_pieces(part: Part, low: float, high: float, count: int) -> list[Piece] | None:
    """So many equal pieces of a part that moves, on [low, high] rad.

    None where they are too few: the tail of one of them matters. MOST_PIECES are never too few.
    """
    assert part.lift is not None
    width = (high - low) / count
    edges = [low + width * j for j in range(count)] + [high]
    pieces = []
    for start, end in itertools.pairwise(edges):
        fitted = None
        if part.wave is not None and count < MOST_PIECES:
            fitted = _fit_wave(part.wave, start, end)
        piece, good = fitted or _fit(part.lift, start, end)
        if not good and count < MOST_PIECES:
            return None
        pieces.append(piece)
    return pieces


class Cut(NamedTuple):
    """A stretch of the table: a part of the cam, or some of it, from low to high, rad."""

    part: Part
    low: float
    high: float


class Lift(NamedTuple):
    """c in m, c_theta in m/rad and c_thetatheta in m/rad2 at a phase."""

    c: float
    slope: float
    accel: float


def phase_of(degrees: float) -> float:
    """Degrees as the double of rad that is nearest."""
    with precision(DIGITS):
        return float(radians(degrees))


def build(shape: Shape, strobe: float = 0.0) -> Cam:
    """Compile one turn, cut at the parts' ends and at the strobe phase (rad), as lists."""
    with precision(DIGITS):
        cuts, strobe = _cuts(shape.parts(), strobe)
        groups = [_compile(cut.part, cut.low, cut.high) for cut in cuts]  # pieces of each stretch
        rests = [_rest(cut.part.start) if cut.low == float(cut.part.start) else 0.0 for cut in cuts]
    starts = [_values(group[0], cut.low) for group, cut in zip(groups, cuts, strict=True)]
    ends = [_values(group[-1], cut.high) for group, cut in zip(groups, cuts, strict=True)]
    _meet_the_seat(cuts, starts, ends)
    bounds = _bounds(groups)
    rows = []
    first_piece = 0
    for n, (cut, group) in enumerate(zip(cuts, groups, strict=True)):
        jump = starts[n].slope - ends[n - 1].slope
        of_c, of_slope, of_accel, *of_higher = bounds[n]  # of_higher: third derivative and on
        rows.append(
            Stretch(
                start=cut.low,
                end=cut.high,
                first_piece=first_piece,
                piece_count=len(group),
                per_angle=len(group) / (cut.high - cut.low),
                start_c=starts[n].c,
                start_c1=starts[n].slope,
                start_c2=starts[n].accel,
                end_c=ends[n].c,
                end_c1=ends[n].slope,
                end_c2=ends[n].accel,
                slope_jump=jump if abs(jump) > SMALLEST_KICK else 0.0,
                accel_min=of_accel.low,
                accel_max=of_accel.high,
                jerk_max=of_higher[0].largest,
                snap_max=of_higher[1].largest,
                crackle_max=of_higher[2].largest,
                radius=_radius(bounds[n][7].largest),
                c_min=of_c.low,
                slope_min=of_slope.low,
                dwell=int(of_c.low == of_c.high),
                rest=rests[n],
                seat=int(cut.part.seat),
            )
        )
        first_piece += len(group)
    return Cam(
        stretches=rows,
        pieces=[value for group in groups for piece in group for value in piece.row()],
        strobe=[row.start for row in rows].index(strobe),
        top=max(of_stretch[0].high for of_stretch in bounds),
    )


def _meet_the_seat(cuts: Sequence[Cut], starts: list[Lift], ends: list[Lift]) -> None:
    """Give the lobe the height of the seat where they meet: a solved phase leaves a rounding.

    starts, ends: the lift at both ends of each cut, which are changed in place.
    """
    for n, cut in enumerate(cuts):
        before = cuts[n - 1]
        if cut.part.seat and not before.part.seat:
            ends[n - 1] = ends[n - 1]._replace(c=starts[n].c)
        elif before.part.seat and not cut.part.seat:
            starts[n] = starts[n]._replace(c=ends[n - 1].c)


def lift_range(cam: Cam, order: int = 0) -> tuple[float, float]:
    """(lowest, highest) c, m, or derivative of that order.

    Of SAMPLES places in every piece and both ends of every stretch, and where the slope is zero
    beside the lowest and the highest of them.
    """
    samples: list[_Sample] = []
    for i, stretch in enumerate(cam.stretches):
        count = SAMPLES * int(stretch.piece_count)
        size = stretch.end - stretch.start
        thetas = [stretch.start + size * (k / count) for k in range(count)] + [stretch.end]
        samples += [_Sample(lift_at(cam, i, x)[order], i, x, size / count) for x in thetas]
    lowest = min(samples)
    highest = max(samples)
    return (
        min(lowest.value, _flat_value(cam, order, lowest)),
        max(highest.value, _flat_value(cam, order, highest)),
    )


class _Sample(NamedTuple):
    """c, m, or one of its derivatives, at a phase (rad); samples are compared by their values."""

    value: float
    stretch: int
    theta: float
    step: float  # rad to the next sample


def _flat_value(cam: Cam, order: int, sample: _Sample) -> float:
    """c, or its derivative of that order, where its slope is zero within a step of a sample.

    The value at the sample itself where the slope does not change its sign there.
    """
    stretch = cam.stretches[sample.stretch]
    low = max(sample.theta - sample.step, stretch.start)
    high = min(sample.theta + sample.step, stretch.end)

    def slope(theta: float) -> float:
        return derivative(cam, order + 1, sample.stretch, theta)

    theta = sample.theta
    slope_at_low = slope(low)
    if slope_at_low * slope(high) < 0.0:
        theta = 0.5 * (low + high)
        while low < theta < high:  # bisection, to neighbouring doubles
            if slope(theta) * slope_at_low > 0.0:
                low = theta
            else:
                high = theta
            theta = 0.5 * (low + high)
    return lift_at(cam, sample.stretch, theta)[order]


def column(cam: Cam, name: str) -> list[float]:
    """One field of all stretches (`kernel.cam_table.Stretch`)."""
    return [getattr(stretch, name) for stretch in cam.stretches]


def _cuts(parts: Sequence[Part], strobe: float) -> tuple[list[Cut], float]:
    """(every stretch in order, the strobe phase as it is cut), rad, in doubles.

    The first stretch begins at 0, the last ends at 2 pi. The strobe is the start of one of them.
    """
    whole = _without_slivers(parts)
    strobe = _at_an_edge(whole, strobe)
    cuts = []
    for cut in whole:
        if cut.low < strobe < cut.high:
            places = [cut.low, *_around(cut.part, strobe), cut.high]
            cuts += [Cut(cut.part, a, b) for a, b in itertools.pairwise(places) if b > a]
        else:
            cuts.append(cut)
    return cuts, strobe


def _without_slivers(parts: Sequence[Part]) -> list[Cut]:
    """The parts that are wider than SLIVER, with their ends in doubles.

    A part that is narrower is left out, and the part before it reaches to the next one.
    """
    cuts = [Cut(part, float(part.start), min(float(part.end), TURN)) for part in parts]
    wide = [cut for cut in cuts if cut.high - cut.low > SLIVER]
    starts = [0.0, *(cut.low for cut in wide[1:])]
    ends = [*starts[1:], TURN]
    return [Cut(cut.part, low, high) for cut, low, high in zip(wide, starts, ends, strict=True)]


def _at_an_edge(cuts: Sequence[Cut], strobe: float) -> float:
    """The strobe; where it is less than two slivers away from an edge of a piece, that edge."""
    if strobe > TURN - 2.0 * SLIVER:
        return 0.0
    edges = [x for cut in cuts for x in (cut.low, cut.high, *cut.part.edges()[1:-1])]
    near = min(edges, key=lambda edge: abs(edge - strobe))
    return near if abs(near - strobe) < 2.0 * SLIVER else strobe


def _around(part: Part, strobe: float) -> list[float]:
    """The cuts that a strobe phase within a part needs, rad: the strobe, and where the part has
    pieces of its own both ends of the piece that it divides.

    A stretch holds whole pieces, so the two halves of a divided piece are stretches of their own.
    No piece is divided where the strobe is at the end of one.
    """
    edges = part.edges()
    if not part.pieces or strobe in edges:
        return [strobe]
    k = bisect(edges, strobe)
    return [edges[k - 1], strobe, edges[k]]


def _values(piece: Piece, theta: float) -> Lift:
    """The lift of a piece at theta (rad), by the kernel's own arithmetic."""
    x = theta - piece.center
    return Lift(*(polynomial(piece.derivative(order), 0, x) for order in range(3)))


class Bounds(NamedTuple):
    """Between these lies c (m), or one of its derivatives (m/rad^order), on a stretch."""

    low: float
    high: float

    @property
    def largest(self) -> float:
        """Bound on the absolute value."""
        return max(abs(self.low), abs(self.high))


def _bounds(groups: Sequence[Sequence[Piece]]) -> list[list[Bounds]]:
    """Rigorous bounds of c and of its derivatives up to HIGHEST, of every stretch.

    groups: the pieces of each stretch. The result holds a list for each stretch, by the order of
    the derivative. Each piece is divided into equal cells. About the middle of a cell a derivative
    is again a polynomial, sum a_j (x - middle)^j: its value there is a_0, and elsewhere in the cell
    it differs from that by no more than sum |a_j| r^j over j > 0, with r half a cell's width.
    """
    cells_of_piece = [max(CUTS, CELLS // len(group)) for group in groups]
    pieces = [piece for group in groups for piece in group]
    counts = np.repeat(cells_of_piece, [len(group) for group in groups])  # cells of every piece
    cell_in_piece = np.concatenate([np.arange(count) for count in counts])
    # from here on one column for each cell
    cells = np.repeat(counts, counts)
    half = np.repeat([piece.half for piece in pieces], counts)
    middle = half * ((2 * cell_in_piece + 1) / cells - 1)
    coefficients = np.array([piece.coefficients for piece in pieces]).T
    terms = _derivative_terms(np.repeat(coefficients, counts, axis=1), middle)
    spread = np.zeros(terms[0].shape)
    for term in terms[:0:-1]:
        spread = (spread + np.abs(term)) * (half / cells)
    spread *= 1.0 + 1e-12  # roundings of these sums
    cells_of_stretch = [
        len(group) * count for group, count in zip(groups, cells_of_piece, strict=True)
    ]
    first_cells = np.cumsum([0, *cells_of_stretch[:-1]])
    low = np.minimum.reduceat(terms[0] - spread, first_cells, axis=1).T.tolist()
    high = np.maximum.reduceat(terms[0] + spread, first_cells, axis=1).T.tolist()
    return [
        [Bounds(*ends) for ends in zip(lows, highs, strict=True)]
        for lows, highs in zip(low, high, strict=True)
    ]


def _derivative_terms(coefficients: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """Coefficients of polynomials and of their derivatives by powers of x - middle.

    coefficients: (TERMS, n), of n polynomials by powers of x. middle: (n,). The result is
    (TERMS, HIGHEST + 1, n): by power, by order of the derivative, by polynomial.
    """
    terms = np.zeros((TERMS, HIGHEST + 1, len(middle)))
    for order in range(HIGHEST + 1):
        for j, factor in enumerate(_factors(order)[: TERMS - order], order):
            terms[j - order, order] = coefficients[j] * factor
    for k in range(TERMS - 1):  # synthetic division by x - middle, once for each power
        for j in range(TERMS - 2, k - 1, -1):
            terms[j] += middle * terms[j + 1]
    return terms


def _radius(seventh: float) -> float:
    """Largest power of two s <= 1/16 rad with seventh s^6/720 <= TAYLOR_ERROR.

    seventh: bound on the seventh derivative of c, m/rad^7. Up to that step s the Taylor series of
    c_theta of order 6 is exact to TAYLOR_ERROR.
    """
    s = 1.0 / 16.0
    while seventh * s * s * s * s * s * s > 720.0 * TAYLOR_ERROR:
        s *= 0.5
    return s


def corners(cam: Cam) -> list[int]:
    """Indices of the stretches that begin with a jump of c_theta or c_thetatheta, ascending."""
    stretches = cam.stretches
    size = max(max(abs(stretch.accel_min), abs(stretch.accel_max)) for stretch in stretches)
    result = []
    for n, stretch in enumerate(stretches):
        accel_jump = abs(stretch.start_c2 - stretches[n - 1].end_c2)
        if stretch.slope_jump != 0.0 or accel_jump > SMALLEST_JUMP * size:
            result.append(n)
    return result
