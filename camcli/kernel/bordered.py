"""The linear algebra of multiple shooting: a cyclic system in blocks of two, with a border.

    L_k d_k + R_k d_{k+1} + p_k dp = -E_k,  k = 1 .. n,  d_{n+1} = d_1,
    row (d_1, ..., d_n, dp) = right

Two unknowns d_k for each of n impacts, and one, dp, of the parameter; L_k and R_k are 2 x 2, p_k
and E_k have two entries. `_forward` eliminates impact by impact with pivoting among four rows
(Wright, SIAM J. Sci. Stat. Comput. 13 (1992) 742), which is stable however unstable the orbit is;
the closing system keeps the border row, so folds are regular. The work is proportional to n.

In code k counts from 0. A matrix is a flat column, row by row: entry (i, c) of one that is `wide`
entries wide stands at i wide + c.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from camcli.kernel.marks import inlined, outlined

# A block, the numbers of an impact in `Tables.blocks`: two matrices, row by row, and a residual.
BLOCK = 10
LEFT, RIGHT, RESIDUAL = 0, 4, 8  # where L_k, R_k and E_k begin

# The columns of an equation while impact k is eliminated: the factors of d_1, of d_k and of d_k+1,
# two each, then that of the parameter, and the right side.
FIRST, HERE, NEXT, PARAMETER, GIVEN = 0, 2, 4, 6, 7
WIDE = 8

# The equations at work, which are the rows of `hand`: two carried on from the impacts before, two
# of the flight from impact k to k + 1, and the border.
CARRIED, FLIGHT, BORDER = 0, 2, 4
ROWS = 5
LAST = 5 * 7  # entries of the closing system, see `solve_bordered`


class Tables(NamedTuple):
    """Room for the Newton steps of an orbit of n impacts; the caller allocates it once."""

    blocks: Any  # (n * BLOCK,), L_k, R_k and E_k
    columns: Any  # (2 n,), p_k
    step: Any  # (2 n + 1,), (d_1, ..., d_n, dp) of the step
    tangent: Any  # (2 n + 1,), and of the tangent
    hand: Any  # (ROWS * WIDE,), the equations at work
    store: Any  # (2 n * WIDE,), two equations an impact, from which `_back` finds its d_k
    last: Any  # (LAST,), the closing system


def tables_for(n: int, zeros: Callable[[int], Any]) -> Tables:
    """The tables of an orbit of n impacts; zeros(count) allocates numbers."""
    return Tables(
        blocks=zeros(n * BLOCK),
        columns=zeros(2 * n),
        step=zeros(2 * n + 1),
        tangent=zeros(2 * n + 1),
        hand=zeros(ROWS * WIDE),
        store=zeros(2 * n * WIDE),
        last=zeros(LAST),
    )


@inlined
def put_pair(table, at, first, second):
    """Put two numbers at `at` and behind it."""
    table[at] = first
    table[at + 1] = second


@inlined
def _product(table, at, d, k):
    """table[at] d[k] + table[at + 1] d[k + 1]."""
    return table[at] * d[k] + table[at + 1] * d[k + 1]


@outlined
def _swap(matrix, i, j, wide):
    """Exchange rows i and j of a matrix that is `wide` entries wide."""
    for column in range(wide):
        upper = i * wide + column
        lower = j * wide + column
        matrix[upper], matrix[lower] = matrix[lower], matrix[upper]


@outlined
def _eliminate(matrix, wide, column, pivot, rows, candidates):
    """Make a column of a matrix zero below row `pivot`, up to row `rows`, by Gauss.

    The row with the largest entry in the column, of those from `pivot` up to `candidates`, takes
    the place of row `pivot`. False where all of these entries are zero; nothing is changed then.
    """
    best = pivot
    for i in range(pivot + 1, candidates):
        if abs(matrix[i * wide + column]) > abs(matrix[best * wide + column]):
            best = i
    if matrix[best * wide + column] == 0.0:
        return False
    if best != pivot:
        _swap(matrix, pivot, best, wide)
    for i in range(pivot + 1, rows):
        factor = matrix[i * wide + column] / matrix[pivot * wide + column]
        if factor != 0.0:
            for c in range(wide):
                matrix[i * wide + c] -= factor * matrix[pivot * wide + c]
    return True


@outlined
def _forward(n, blocks, columns, row, right, hand, store):
    """Eliminate impacts 2 .. n - 1; False where the system is singular.

    row (2 n + 1,), right: the border's equation. On return the carried equations and the border in
    `hand` have factors of d_1, of d_n (where n > 1: in the columns HERE) and of the parameter only.
    The equations that an eliminated impact leaves behind stand in `store`.
    """
    for i in range(ROWS * WIDE):
        hand[i] = 0.0
    _put_flight(hand, CARRIED, blocks, columns, 0, FIRST, HERE)
    border = BORDER * WIDE
    put_pair(hand, border + FIRST, row[0], row[1])
    hand[border + PARAMETER] = row[2 * n]
    hand[border + GIVEN] = right
    if n > 1:
        put_pair(hand, border + HERE, row[2], row[3])
    for k in range(1, n - 1):
        _put_flight(hand, FLIGHT, blocks, columns, k, HERE, NEXT)
        put_pair(hand, border + NEXT, row[2 * k + 2], row[2 * k + 3])
        for column in range(2):
            if not _eliminate(hand, WIDE, HERE + column, CARRIED + column, ROWS, BORDER):
                return False
        # The upper two equations are now those of d_k, and the lower two are free of it.
        for c in range(2 * WIDE):
            store[2 * WIDE * k + c] = hand[CARRIED * WIDE + c]
        for c in range(2 * WIDE):
            hand[CARRIED * WIDE + c] = hand[FLIGHT * WIDE + c]
        _next_becomes_here(hand, CARRIED)
        _next_becomes_here(hand, CARRIED + 1)
        _next_becomes_here(hand, BORDER)
    return True


@inlined
def _put_flight(hand, first, blocks, columns, k, left, right):
    """Put the equations of flight k, L_k d_k + R_k d_k+1 + p_k dp = -E_k, into two rows of `hand`.

    They are the rows `first` and first + 1; L_k is added from column `left` on, R_k from `right`.
    """
    block = BLOCK * k
    for i in range(2):
        at = (first + i) * WIDE
        for c in range(WIDE):
            hand[at + c] = 0.0
        for c in range(2):
            hand[at + left + c] += blocks[block + LEFT + 2 * i + c]
            hand[at + right + c] += blocks[block + RIGHT + 2 * i + c]
        hand[at + PARAMETER] = columns[2 * k + i]
        hand[at + GIVEN] = -blocks[block + RESIDUAL + i]


@inlined
def _next_becomes_here(hand, row):
    """Go on to the next impact: the factors of d_k+1 in a row become those of d_k."""
    at = row * WIDE
    put_pair(hand, at + HERE, hand[at + NEXT], hand[at + NEXT + 1])
    put_pair(hand, at + NEXT, 0.0, 0.0)


@outlined
def solve_bordered(n, t, row, right):
    """Newton step and tangent of the bordered system; False where it is singular.

    t: `Tables`. With J the matrix of the flights' equations, t.step solves J d = -E, row d = right,
    and t.tangent solves J d = 0, row d = 1. Both come from the closing system in t.last. Its
    unknowns are d_1, d_n and the parameter (of one impact d_1 and the parameter); behind its `size`
    columns stand the right sides of the step and of the tangent.
    """
    hand = t.hand
    last = t.last
    if not _forward(n, t.blocks, t.columns, row, right, hand, t.store):
        return False
    if n == 1:  # the only flight closes on itself: L and R are both factors of d_1
        size = 3
        for i in range(2):
            for c in range(2):
                hand[i * WIDE + FIRST + c] += hand[i * WIDE + HERE + c]
    else:
        size = 5
        _put_flight(hand, FLIGHT, t.blocks, t.columns, n - 1, HERE, FIRST)
    for i in range(size - 1):
        _close(hand, i, last, i, size, 0.0)
    _close(hand, BORDER, last, size - 1, size, 1.0)
    for column in range(size):
        if not _eliminate(last, size + 2, column, column, size, size):
            return False
    _back(n, last, size, size, t.store, t.step, 1.0)
    _back(n, last, size, size + 1, t.store, t.tangent, 0.0)
    return True


@inlined
def _close(hand, source, last, target, size, tangent):
    """Copy an equation, row `source` of `hand`, to row `target` of the closing system.

    Its factors of d_1 and d_n come first, then the parameter's, then the right side of the step,
    then that of the tangent, which is given.
    """
    at = target * (size + 2)
    for c in range(size - 1):
        last[at + c] = hand[source * WIDE + c]
    last[at + size - 1] = hand[source * WIDE + PARAMETER]
    last[at + size] = hand[source * WIDE + GIVEN]
    last[at + size + 1] = tangent


@outlined
def _back(n, last, size, side, store, d, share):
    """Back substitution into d = (d_1, ..., d_n, dp), (2 n + 1,).

    First the closing system, which is upper triangular and gives d_1, d_n and dp; then from the
    last impact to the second one the equations in `store`.

    side: the column of the right side in the closing system; share: how much of the right sides in
    `store` counts, 1 for the step and 0 for the tangent.
    """
    wide = size + 2
    for i in range(size - 1, -1, -1):
        value = last[i * wide + side]
        for c in range(i + 1, size):
            value -= last[i * wide + c] * d[c]
        d[i] = value / last[i * wide + i]
    parameter = d[size - 1]
    d[2 * n] = parameter
    if n > 1:  # d_n, the second pair of the closing system, to its place
        put_pair(d, 2 * n - 2, d[2], d[3])
    for k in range(n - 2, 0, -1):
        here = 2 * k  # of d_k in d
        for i in range(1, -1, -1):
            at = (2 * k + i) * WIDE
            value = share * store[at + GIVEN] - store[at + PARAMETER] * parameter
            value -= _product(store, at + FIRST, d, 0)
            value -= _product(store, at + NEXT, d, here + 2)
            if i == 0:  # the second row is free of the first entry of d_k, the first is not
                value -= store[at + HERE + 1] * d[here + 1]
            d[here + i] = value / store[at + HERE + i]
