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
CUTS = 4  # cells of a piece in its bounds
CELLS = 16  # of a stretch in its bounds, at least
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
    """j (j - 1) .. (j - order + 1) for j = order, order + 1, .. TERMS: of x^j, derived so often."""
    return [factorial(j) // factorial(j - order) for j in range(order, TERMS + 1)]


@cache
def _chebyshev() -> tuple[list[arb], arb_mat, arb_mat]:
    """Chebyshev nodes on [-1, 1], and matrices: values there to sum a_k T_k, a_k to powers of x."""
    step = arb.pi() / (2 * TERMS)
    terms = range(TERMS)
    rows = [[(k * (2 * j + 1) * step).cos() * min(k + 1, 2) / TERMS for j in terms] for k in terms]
    powers = [[fmpz_poly.chebyshev_t(k)[j] for k in terms] for j in terms]
    return [((2 * j + 1) * step).cos() for j in terms], arb_mat(rows), arb_mat(powers)


def _fit(lift: Callable[[Any], Any], low: float, high: float) -> tuple[Piece, bool]:
    """The interpolating piece on [low, high], and whether its tail is negligible."""
    center = (low + high) / 2
    half = (high - low) / 2
    nodes, rows, powers = _chebyshev()
    values = [lift(center + half * node) for node in nodes]
    series = (rows * arb_mat([[value] for value in values])).entries()
    size = max(abs(float(value)) for value in values)
    series = [value if abs(float(value)) > NOISE * size else arb(0) for value in series]
    sizes = [abs(float(value)) for value in series]
    # |T_n''| <= n^2 (n^2 - 1)/3 on [-1, 1]
    accel = [value * (k * k * (k * k - 1)) / 3 for k, value in enumerate(sizes)]
    good = max(sizes[-2:]) <= LIFT_TAIL * size and max(accel[-2:]) <= ACCEL_TAIL * max(accel)
    scaled = (powers * arb_mat([[value] for value in series])).entries()
    exact = [value / arb(half) ** j for j, value in enumerate(scaled)]
    return Piece(center, half, tuple(map(float, exact)), (_rest(exact[0]), _rest(exact[1]))), good


@dataclass(frozen=True)
class _UnitWaves:
    """Cosine and sine interpolated on an interval: at the nodes, and their coefficients."""

    at_nodes: list[tuple[float, float]]
    series: list[tuple[float, float]]  # of T_k
    powers: list[tuple[arb, arb]]  # of x^j


@lru_cache(maxsize=MOST_UNIT_WAVES)
def _unit_waves(low: float, high: float) -> _UnitWaves:
    """Those on an interval, rad, in DIGITS digits."""
    center = (low + high) / 2
    half = (high - low) / 2
    nodes, rows, powers = _chebyshev()
    values = [(center + half * node).sin_cos()[::-1] for node in nodes]
    series = rows * arb_mat(values)
    scaled = powers * series
    exact = [[scaled[j, i] / arb(half) ** j for i in (0, 1)] for j in range(TERMS)]
    return _UnitWaves(
        [(float(cosine), float(sine)) for cosine, sine in values],
        [(float(series[k, 0]), float(series[k, 1])) for k in range(TERMS)],
        [(cosine, sine) for cosine, sine in exact],
    )


def _fit_wave(wave: tuple[arb, arb, arb], low: float, high: float) -> tuple[Piece, bool] | None:
    """`_fit` of mean + along cos theta + across sin theta, from cosine and sine; see `_fit`.

    None where a term is so small beside the mean that it might be rounding.
    """
    unit = _unit_waves(low, high)
    mean, along, across = map(float, wave)
    size = max(abs(mean + along * cosine + across * sine) for cosine, sine in unit.at_nodes)
    sizes = [abs(along * cosine + across * sine) for cosine, sine in unit.series]
    if min(sizes[1:]) <= NOISE * size:
        return None
    accel = [value * (k * k * (k * k - 1)) / 3 for k, value in enumerate(sizes)]
    good = max(sizes[-2:]) <= LIFT_TAIL * size and max(accel[-2:]) <= ACCEL_TAIL * max(accel)
    center = (low + high) / 2
    half = (high - low) / 2
    if not good:
        return Piece(center, half, ()), False
    exact = [wave[1] * cosine + wave[2] * sine for cosine, sine in unit.powers]
    exact[0] += wave[0]
    return Piece(center, half, tuple(map(float, exact)), (_rest(exact[0]), _rest(exact[1]))), True


def _rest(value: arb) -> float:
    """The part of a ball's middle that its double leaves out."""
    return float(value - float(value))


def _compile(part: Part, low: float, high: float) -> list[Piece]:
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
        return [Piece((low + high) / 2, half, level, (_rest(arb(part.level)), 0.0))]
    count = 1
    while True:
        width = (high - low) / count
        edges = [low + width * j for j in range(count)] + [high]
        pieces = []
        for a, b in itertools.pairwise(edges):
            fitted = None
            if part.wave is not None and count < MOST_PIECES:
                fitted = _fit_wave(part.wave, a, b)
            piece, good = fitted or _fit(part.lift, a, b)
            if not good and count < MOST_PIECES:
                break
            pieces.append(piece)
        else:
            return pieces
        count += 1 + count // 4


Cut = tuple[Part, float, float]  # a part, from an angle to another, rad


def phase_of(degrees: float) -> float:
    """Degrees as the double of rad that is nearest."""
    with precision(DIGITS):
        return float(radians(degrees))


def build(shape: Shape, strobe: float = 0.0) -> Cam:
    """Compile one turn, cut at the parts' ends and at the strobe phase (rad), as lists."""
    with precision(DIGITS):
        cuts, strobe = _cuts(shape.parts(), strobe)
        stretches = [_compile(part, low, high) for part, low, high in cuts]
        rests = [_rest(part.start) if low == float(part.start) else 0.0 for part, low, _ in cuts]
    pieces = [piece for group in stretches for piece in group]
    first = [sum(len(group) for group in stretches[:n]) for n in range(len(stretches))]
    starts = [_values(pieces[k], low) for k, (_, low, _) in zip(first, cuts, strict=True)]
    lasts = [k + len(group) - 1 for k, group in zip(first, stretches, strict=True)]
    ends = [_values(pieces[k], high) for k, (_, _, high) in zip(lasts, cuts, strict=True)]
    _meet_the_seat(cuts, starts, ends)
    bounds = _bounds(stretches)
    jumps = [starts[n][1] - ends[n - 1][1] for n in range(len(starts))]
    rows = [
        Stretch(
            start=low,
            end=high,
            first_piece=first[n],
            piece_count=len(group),
            per_angle=len(group) / (high - low),
            start_c=starts[n][0],
            start_c1=starts[n][1],
            start_c2=starts[n][2],
            end_c=ends[n][0],
            end_c1=ends[n][1],
            end_c2=ends[n][2],
            slope_jump=jumps[n] if abs(jumps[n]) > SMALLEST_KICK else 0.0,
            accel_min=bounds[n][2][0],
            accel_max=bounds[n][2][1],
            jerk_max=_largest(bounds[n][3]),
            snap_max=_largest(bounds[n][4]),
            crackle_max=_largest(bounds[n][5]),
            radius=_radius(_largest(bounds[n][7])),
            c_min=bounds[n][0][0],
            slope_min=bounds[n][1][0],
            dwell=int(bounds[n][0][0] == bounds[n][0][1]),
            rest=rests[n],
            seat=int(cuts[n][0].seat),
        )
        for n, (group, (_, low, high)) in enumerate(zip(stretches, cuts, strict=True))
    ]
    return Cam(
        stretches=rows,
        pieces=[value for piece in pieces for value in piece.row()],
        strobe=[row.start for row in rows].index(strobe),
        top=max(row[0][1] for row in bounds),
    )


def _meet_the_seat(cuts: Sequence[Cut], starts: list, ends: list) -> None:
    """Give the lobe the height of the seat where they meet: a solved phase leaves a rounding."""
    for n, (part, _, _) in enumerate(cuts):
        before = cuts[n - 1][0]
        if part.seat and not before.seat:
            ends[n - 1] = (starts[n][0], *ends[n - 1][1:])
        elif before.seat and not part.seat:
            starts[n] = (ends[n - 1][0], *starts[n][1:])


def lift_range(cam: Cam, order: int = 0) -> tuple[float, float]:
    """(lowest, highest) c, m, or derivative of that order.

    Of 16 places in every piece and both ends of every stretch, and where the slope is zero beside
    the lowest and the highest of them.
    """
    samples: list[_Sample] = []
    for i, stretch in enumerate(cam.stretches):
        places = 16 * int(stretch.piece_count)
        size = stretch.end - stretch.start
        thetas = [stretch.start + size * (k / places) for k in range(places)] + [stretch.end]
        samples += [_Sample(lift_at(cam, i, x)[order], i, x, size / places) for x in thetas]
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
    _, i, theta, step = sample
    a = max(theta - step, cam.stretches[i].start)
    b = min(theta + step, cam.stretches[i].end)
    before = derivative(cam, order + 1, i, a)
    if before * derivative(cam, order + 1, i, b) < 0.0:
        while a < (theta := 0.5 * (a + b)) < b:
            if derivative(cam, order + 1, i, theta) * before > 0.0:
                a = theta
            else:
                b = theta
    return lift_at(cam, i, theta)[order]


def column(cam: Cam, name: str) -> list[float]:
    """One field of all stretches (`kernel.cam_table.Stretch`)."""
    return [getattr(stretch, name) for stretch in cam.stretches]


def _cuts(parts: Sequence[Part], strobe: float) -> tuple[list[Cut], float]:
    """Every stretch in order, in doubles; the last ends at 2 pi; and the strobe as it is cut."""
    cuts = []
    whole = _without_slivers(parts)
    strobe = _at_an_edge(whole, strobe)
    for part, low, high in whole:
        if low < strobe < high:
            places = [low, *_around(part, strobe), high]
            cuts += [(part, a, b) for a, b in itertools.pairwise(places) if b > a]
        else:
            cuts.append((part, low, high))
    return cuts, strobe


def _without_slivers(parts: Sequence[Part]) -> list[Cut]:
    """The parts that are wider than SLIVER, with their ends in doubles.

    A part that is narrower is left out, and the part before it reaches to the next one.
    """
    ends = [(part, float(part.start), min(float(part.end), TURN)) for part in parts]
    wide = [cut for cut in ends if cut[2] - cut[1] > SLIVER]
    starts = [0.0, *(low for _, low, _ in wide[1:])]
    stops = [*starts[1:], TURN]
    return [(cut[0], low, high) for cut, low, high in zip(wide, starts, stops, strict=True)]


def _at_an_edge(cuts: Sequence[Cut], strobe: float) -> float:
    """The strobe; where it is less than two slivers away from an edge of a piece, that edge."""
    if strobe > TURN - 2.0 * SLIVER:
        return 0.0
    edges = [x for part, low, high in cuts for x in (low, high, *part.edges()[1:-1])]
    near = min(edges, key=lambda edge: abs(edge - strobe))
    return near if abs(near - strobe) < 2.0 * SLIVER else strobe


def _around(part: Part, strobe: float) -> list[float]:
    """The strobe as a cut within the part, and with it the ends of the piece that it divides.

    A part that brings no pieces of its own, or whose piece ends at the strobe, needs the cut alone.
    """
    edges = part.edges()
    if not part.pieces or strobe in edges:
        return [strobe]
    k = bisect(edges, strobe)
    return [edges[k - 1], strobe, edges[k]]


def _values(piece: Piece, theta: float) -> tuple[float, ...]:
    """c, c_theta, c_thetatheta of a piece at theta, by the kernel's own arithmetic."""
    x = theta - piece.center
    return tuple(polynomial(piece.derivative(order), 0, x) for order in range(3))


def _bounds(groups: Sequence[Sequence[Piece]]) -> list[list[tuple[float, float]]]:
    """Rigorous (low, high) of c and of each of its derivatives, of every stretch.

    Each piece is expanded again about the middle of each of its cells, where the sum of the powers'
    sizes bounds what the constant leaves out.
    """
    sizes = [max(CUTS, CELLS // len(group)) for group in groups]  # a polynomial law is one piece
    pieces = [
        (piece, cuts) for group, cuts in zip(groups, sizes, strict=True) for piece in group
    ]  # fmt: skip
    cells = [cell for _, cuts in pieces for cell in range(cuts)]
    whole = np.array([piece.coefficients for piece, _ in pieces]).T  # of a power, of all pieces
    count = [cuts for _, cuts in pieces]
    cuts = np.repeat(count, count)
    half = np.repeat([piece.half for piece, _ in pieces], count)
    middle = half * ((2 * np.array(cells) + 1) / cuts - 1)
    values = np.zeros((TERMS, HIGHEST + 1, len(cells)))
    repeated = np.repeat(whole, count, axis=1)
    for order in range(HIGHEST + 1):
        for j, factor in enumerate(_factors(order)[: TERMS - order], order):
            values[j - order, order] = repeated[j] * factor
    for k in range(TERMS - 1):  # synthetic division: powers of x - middle
        for j in range(TERMS - 2, k - 1, -1):
            values[j] += middle * values[j + 1]
    spread = np.zeros(values[0].shape)
    for value in values[:0:-1]:
        spread = (spread + np.abs(value)) * (half / cuts)
    spread *= 1.0 + 1e-12  # roundings of these sums
    first = np.cumsum([0, *(len(g) * c for g, c in zip(groups, sizes, strict=True))][:-1])
    low = np.minimum.reduceat(values[0] - spread, first, axis=1).T.tolist()
    high = np.maximum.reduceat(values[0] + spread, first, axis=1).T.tolist()
    return [list(zip(*ends, strict=True)) for ends in zip(low, high, strict=True)]


def _largest(bounds: tuple[float, float]) -> float:
    return max(abs(bounds[0]), abs(bounds[1]))


def _radius(seventh: float) -> float:
    """Largest power of two s <= 1/16 rad with max|c^(7)| s^6/720 <= TAYLOR_ERROR."""
    s = 1.0 / 16.0
    while seventh * s * s * s * s * s * s > 720.0 * TAYLOR_ERROR:
        s *= 0.5
    return s


def corners(cam: Cam) -> list[int]:
    """Stretches that begin with a jump of c_theta or c_thetatheta."""
    size = max(abs(value) for name in ("accel_min", "accel_max") for value in column(cam, name))
    starts = column(cam, "start_c2")
    ends = column(cam, "end_c2")
    kicks = column(cam, "slope_jump")
    return [
        n
        for n in range(len(cam.stretches))
        if kicks[n] != 0.0 or abs(starts[n] - ends[n - 1]) > SMALLEST_JUMP * size
    ]
