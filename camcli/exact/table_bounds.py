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
from typing import NamedTuple

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
    """Errors of c and its derivatives in the table of a cam, then their sizes; m and rad.

    Both up to the derivative of order HIGHEST, as `kernel.enclosed_landing` takes them, the
    roundings of the table's evaluation among the errors. None where the table is not of these
    stretches, or nothing can be shown.
    """
    try:
        with precision(DIGITS), _long_series():
            stretches = stretches_of(shape)
            if not _matches(stretches, cam):
                return None
            bounds = _of_table(stretches, cam)
            jumps = _jumps(stretches, cam)
    except UndecidedError:
        return None
    errors = []
    sizes = []
    for order in range(HIGHEST + 1):
        rounding = ROOM * bounds.sizes[order]
        errors.append(bounds.errors[order] + jumps[order] + rounding)
        sizes.append(WIDER * bounds.sizes[order] + errors[order])
    return (*errors, *sizes)


class TableBounds(NamedTuple):
    """Bounds of c and its derivatives up to the order HIGHEST: of a table's errors, and sizes."""

    errors: list[float]
    sizes: list[float]

    def joined(self, other: TableBounds) -> TableBounds:
        """Bounds that hold where either of the two does."""
        return TableBounds(
            list(map(max, self.errors, other.errors)), list(map(max, self.sizes, other.sizes))
        )


def _of_table(stretches: Sequence[BallStretch], cam: Cam) -> TableBounds:
    """The bounds over all pieces of a table, but for jumps between stretches."""
    bounds = TableBounds([0.0] * (HIGHEST + 1), [0.0] * (HIGHEST + 1))
    for row in cam.stretches:
        for k in range(row.piece_count):
            begin = (row.first_piece + k) * PIECE
            piece = cam.pieces[begin : begin + PIECE]
            for of_cell in _of_piece(stretches, row, piece):
                bounds = bounds.joined(of_cell)
    return bounds


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
    for stretch in stretches:
        start = float(stretch.start)
        if min(abs(start - edge) for edge in edges) > EDGE:
            return False
        if not stretch.end - stretch.start > SLIVER:
            return False
    return True


def _of_piece(
    stretches: Sequence[BallStretch], row: Stretch, piece: Sequence[float]
) -> list[TableBounds]:
    """The bounds in each cell of a piece: one of CUTS equal parts of it.

    row: the stretch of the table that the piece is of; piece: its entry in `Cam.pieces`, which
    begins with the phase it is expanded about.
    """
    half_piece = (row.end - row.start) / (2 * row.piece_count)
    half = WIDER * half_piece / CUTS  # half the width of a cell
    growth = _growth(half)
    bounds_of_cells = []
    for cell in range(CUTS):
        middle = piece[0] + half_piece * ((2 * cell + 1) / CUTS - 1)
        stretch = next((one for one in stretches if one.start < middle < one.end), stretches[0])
        x = arb_series([middle, 1], TERMS + 1)
        x_of_cell = arb_series([arb(middle, half), 1], TERMS + 1)
        exact = _series(stretch, x)
        remainder = _series(stretch, x_of_cell)[TERMS]
        from_start = x - arb(piece[0])
        table = arb_series([0], TERMS + 1)
        for coefficient in reversed(piece[LIFT : LIFT + TERMS]):
            table = table * from_start + arb(coefficient)
        error = exact - table
        terms = [[error[k].abs_upper(), table[k].abs_upper()] for k in range(TERMS)]
        of_cell = growth * arb_mat([*terms, [remainder.abs_upper(), arb(0)]])
        errors = [_finite(of_cell[order, 0]) for order in range(HIGHEST + 1)]
        sizes = [_finite(of_cell[order, 1]) for order in range(HIGHEST + 1)]
        bounds_of_cells.append(TableBounds(errors, sizes))
    return bounds_of_cells


@lru_cache(maxsize=REMEMBERED)
def _growth(h: float) -> arb_mat:
    """The matrix that makes, of the sizes |t_k|, bounds of |sum t_k x^k| and of its derivatives.

    The bound of the derivative of order n, for |x| <= h, is the sum of k!/(k - n)! h^(k - n) |t_k|
    over k >= n: row n has the factor of |t_k| at column k.
    """
    powers = [arb(h) ** k for k in range(TERMS + 1)]
    rows = []
    for order in range(HIGHEST + 1):
        factors = [perm(k, order) * powers[k - order] for k in range(order, TERMS + 1)]
        rows.append([0] * order + factors)
    return arb_mat(rows)


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
    """Bounds of the jumps of c and its derivatives where stretches meet inside a table's stretch.

    Where the table has an end itself, there is no error.
    """
    starts = [row.start for row in cam.stretches]
    jumps = [0.0] * (HIGHEST + 1)
    for before, behind in pairwise(stretches):
        if min(abs(float(behind.start) - start) for start in starts) > EDGE:
            at_end = before.derivatives(behind.start, HIGHEST)
            at_start = behind.derivatives(behind.start, HIGHEST)
            sizes = [_finite(abs(x - y)) for x, y in zip(at_end, at_start, strict=True)]
            jumps = list(map(max, jumps, sizes))
    return jumps
