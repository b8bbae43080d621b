"""How far the kernel's table of a cam may be from the cam itself, proved in balls.

The table is polynomials with doubles for coefficients (`kernel.cam_table`). About the middle m of a
cell of a piece, c - p = sum d_k x^k for |x| <= h. For k < TERMS, d_k is the difference of two power
series at m. From there on p has no terms, and c's own coefficient of order TERMS over the whole
cell is the remainder (Lagrange).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import pairwise
from math import isfinite, perm

from flint import arb, arb_mat, arb_series, ctx

from camcli.cams.balls import UndecidedError, precision
from camcli.cams.compile import CUTS, Shape
from camcli.exact.machine import BallStretch, stretches_of
from camcli.kernel.cam_table import LIFT, PIECE, TERMS, Cam, Stretch
from camcli.kernel.enclosed_landing import ROOM
from camcli.system import cam_of

DIGITS = 40
HIGHEST = 4  # derivative that is bounded
EDGE = 2e-15  # rad: ends of stretches are rounded, and no further apart in the table
SLIVER = 1e-12  # rad: a shorter stretch may be missing in the table
WIDER = 1.0 + 1e-9  # a cell, so that roundings of an angle stay in it
REMEMBERED = 64


@lru_cache(maxsize=REMEMBERED)
def table_and_bounds(shape: Shape, strobe: float) -> tuple[Cam, tuple[float, ...] | None]:
    """The table of a cam, and its `table_bounds`."""
    cam = cam_of(shape, strobe)
    return cam, table_bounds(shape, cam)


def table_bounds(shape: Shape, cam: Cam) -> tuple[float, ...] | None:
    """Errors, then sizes, of c and its derivatives, as `kernel.enclosed_landing` takes them.

    Of what the table says of the cam (m, rad), with the roundings of its evaluation. None where
    the table is not of these stretches, or nothing can be shown.
    """
    try:
        with precision(DIGITS), _long_series():
            stretches = stretches_of(shape)
            if not _matches(stretches, cam):
                return None
            errors, sizes = _of_table(stretches, cam)
            jumps = _jumps(stretches, cam)
    except UndecidedError:
        return None
    errors = [x + y + ROOM * z for x, y, z in zip(errors, jumps, sizes, strict=True)]
    sizes = [WIDER * x + y for x, y in zip(sizes, errors, strict=True)]
    return (*errors, *sizes)


def _of_table(stretches: Sequence[BallStretch], cam: Cam) -> tuple[list[float], list[float]]:
    """(errors, sizes) of c and its derivatives in all pieces."""
    errors = [0.0] * (HIGHEST + 1)
    sizes = [0.0] * (HIGHEST + 1)
    for row in cam.stretches:
        for k in range(row.piece_count):
            piece = cam.pieces[(row.first_piece + k) * PIECE :][:PIECE]
            for own, size in _of_piece(stretches, row, piece):
                errors = [max(x, y) for x, y in zip(errors, own, strict=True)]
                sizes = [max(x, y) for x, y in zip(sizes, size, strict=True)]
    return errors, sizes


def _edges(cam: Cam) -> list[float]:
    """Where the pieces of the table begin, and 2 pi."""
    edges = [
        row.start + (row.end - row.start) * (k / row.piece_count)
        for row in cam.stretches
        for k in range(row.piece_count)
    ]
    return [*edges, cam.stretches[-1].end]


def _matches(stretches: Sequence[BallStretch], cam: Cam) -> bool:
    """Whether each stretch begins where a piece of the table does, and none is a sliver."""
    edges = _edges(cam)
    at_edges = all(min(abs(float(one.start) - edge) for edge in edges) <= EDGE for one in stretches)
    return at_edges and all(one.end - one.start > SLIVER for one in stretches)


def _of_piece(
    stretches: Sequence[BallStretch], row: Stretch, piece: Sequence[float]
) -> list[tuple[list[float], list[float]]]:
    """(errors, sizes) of c and its derivatives in each cell of a piece."""
    half = (row.end - row.start) / (2 * row.piece_count)
    h = WIDER * half / CUTS
    growth = _growth(h)
    found = []
    for cell in range(CUTS):
        middle = piece[0] + half * ((2 * cell + 1) / CUTS - 1)
        own = next((one for one in stretches if one.start < middle < one.end), stretches[0])
        x = arb_series([middle, 1], TERMS + 1)
        wide = arb_series([arb(middle, h), 1], TERMS + 1)
        exact = _series(own, x)
        rest = _series(own, wide)[TERMS]
        from_start = x - arb(piece[0])
        table = arb_series([0], TERMS + 1)
        for coefficient in reversed(piece[LIFT : LIFT + TERMS]):
            table = table * from_start + arb(coefficient)
        error = exact - table
        rows = [[error[k].abs_upper(), table[k].abs_upper()] for k in range(TERMS)]
        bounds = growth * arb_mat([*rows, [rest.abs_upper(), arb(0)]])
        errors = [_finite(bounds[order, 0]) for order in range(HIGHEST + 1)]
        sizes = [_finite(bounds[order, 1]) for order in range(HIGHEST + 1)]
        found.append((errors, sizes))
    return found


@lru_cache(maxsize=REMEMBERED)
def _growth(h: float) -> arb_mat:
    """The matrix that makes bounds of |sum t_k x^k| and of its derivatives of the sizes |t_k|.

    Row n, for the derivative of order n and |x| <= h, holds k!/(k - n)! h^(k - n) at column k.
    """
    powers = [arb(h) ** k for k in range(TERMS + 1)]
    return arb_mat(
        [
            [perm(k, order) * powers[k - order] if k >= order else 0 for k in range(TERMS + 1)]
            for order in range(HIGHEST + 1)
        ]
    )


def _finite(x: arb) -> float:
    """A double above x; raises UndecidedError where there is none."""
    bound = WIDER * float(x.upper())
    if not isfinite(bound):
        raise UndecidedError
    return bound


def _series(stretch: BallStretch, x: arb_series) -> arb_series:
    """c about an angle; raises UndecidedError where it is shorter than it was asked for."""
    if stretch.lift is None:
        return arb_series([stretch.level], TERMS + 1)
    series = arb_series(stretch.lift(x))
    if series.prec < TERMS + 1:
        raise UndecidedError
    return series


@contextmanager
def _long_series() -> Iterator[None]:
    """Let series have as many terms as are needed here: python-flint cuts all at `ctx.cap`."""
    before = ctx.cap
    ctx.cap = max(before, TERMS + 1)
    try:
        yield
    finally:
        ctx.cap = before


def _jumps(stretches: Sequence[BallStretch], cam: Cam) -> list[float]:
    """The jumps of c and its derivatives at ends of stretches that the table has no end at."""
    starts = [row.start for row in cam.stretches]
    jumps = [0.0] * (HIGHEST + 1)
    for before, after in pairwise(stretches):
        if min(abs(float(after.start) - start) for start in starts) > EDGE:
            left = before.derivatives(after.start, HIGHEST)
            right = after.derivatives(after.start, HIGHEST)
            sizes = [_finite(abs(x - y)) for x, y in zip(left, right, strict=True)]
            jumps = [max(x, y) for x, y in zip(jumps, sizes, strict=True)]
    return jumps
