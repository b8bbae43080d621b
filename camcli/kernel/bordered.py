"""The linear algebra of multiple shooting: a cyclic system in blocks of two, with a border.

    L_k d_k + R_k d_{k+1} + p_k dp = -E_k,  d_{n+1} = d_1,    row (d_1, ..., d_n, dp) = right
`_forward` eliminates impact by impact with pivoting among the four rows in hand (Wright, SIAM J.
Sci. Stat. Comput. 13 (1992) 742), which is stable however unstable the orbit is; the closing system
keeps the border row, so folds are regular. The work is proportional to n.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from camcli.kernel.marks import inlined, outlined

# A block, the numbers of an impact in `Tables.blocks`: two matrices, row by row, and a residual.
BLOCK = 10
LEFT, RIGHT, RESIDUAL = 0, 4, 8  # where L_k, R_k and E_k begin

# A row in hand: where the factors of d_1, d_k, d_k+1 (two each) and of the parameter stand, and the
# right side.
FIRST, HERE, NEXT, PARAMETER, GIVEN = 0, 2, 4, 6, 7
WIDE = 8

# The rows in hand: two carried along, two of the next flight, the border.
CARRIED, FLIGHT, BORDER = 0, 2, 4
ROWS = 5
LAST = 5 * 7  # the closing system: d_1, d_n and the parameter, with two right sides


class Tables(NamedTuple):
    """Room for the Newton steps of an orbit of n impacts; the caller allocates it once."""

    blocks: Any  # (n * BLOCK,)
    columns: Any  # (2 n,), derivatives by the parameter
    step: Any  # (2 n + 1,)
    tangent: Any  # (2 n + 1,)
    hand: Any  # (ROWS * WIDE,), the rows in hand
    store: Any  # (2 n * WIDE,), two rows an impact: what elimination has left of its equations
    last: Any  # (LAST,)


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
def put_pair(table, at, one, other):
    """Put two numbers at `at` and behind it."""
    table[at] = one
    table[at + 1] = other


@inlined
def _product(row, at, d, k):
    """Two factors that begin at `at`, times the two entries of d that begin at k."""
    return row[at] * d[k] + row[at + 1] * d[k + 1]


@outlined
def _swap(a, i, j, wide):
    """Exchange the rows i and j."""
    for column in range(wide):
        a[i * wide + column], a[j * wide + column] = a[j * wide + column], a[i * wide + column]


@outlined
def _eliminate(a, wide, column, pivot, rows, candidates):
    """Pivot on `column` at row `pivot`: the largest entry of the rows from there to `candidates`.

    False where all of these are zero, and nothing is changed.
    """
    best = pivot
    for i in range(pivot + 1, candidates):
        if abs(a[i * wide + column]) > abs(a[best * wide + column]):
            best = i
    if a[best * wide + column] == 0.0:
        return False
    if best != pivot:
        _swap(a, pivot, best, wide)
    for i in range(pivot + 1, rows):
        factor = a[i * wide + column] / a[pivot * wide + column]
        if factor != 0.0:
            for c in range(wide):
                a[i * wide + c] -= factor * a[pivot * wide + c]
    return True


@outlined
def _forward(n, blocks, columns, row, right, hand, store):
    """Eliminate impacts 2 .. n - 1; False where the system is singular.

    On return the carried rows and the border in `hand` have factors of d_1, d_n (where n > 1: in
    the place of d_k) and the parameter only. The eliminated rows stand in `store`.
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
        for c in range(2 * WIDE):  # the two pivots: the equations of d_k
            store[2 * WIDE * k + c] = hand[c]
        for c in range(2 * WIDE):  # the other two, free of d_k, are carried to the next impact
            hand[CARRIED * WIDE + c] = hand[FLIGHT * WIDE + c]
        _next_becomes_here(hand, CARRIED)
        _next_becomes_here(hand, CARRIED + 1)
        _next_becomes_here(hand, BORDER)
    return True


@inlined
def _put_flight(hand, first, blocks, columns, k, left, right):
    """Flight k in the rows first, first + 1: the factors L from column `left`, R from `right`."""
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

    t.step solves J d = -E, row d = right; t.tangent J d = 0, row d = 1. Both come from the closing
    system: d_1, d_n and the parameter (of one impact d_1 and the parameter), where the right side
    of the tangent stands behind that of the step.
    """
    hand, last = t.hand, t.last
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
    """A row in hand as row `target` of the closing system; tangent: its second right side."""
    at = target * (size + 2)
    for c in range(size - 1):
        last[at + c] = hand[source * WIDE + c]
    last[at + size - 1] = hand[source * WIDE + PARAMETER]
    last[at + size] = hand[source * WIDE + GIVEN]
    last[at + size + 1] = tangent


@outlined
def _back(n, last, size, side, store, d, share):
    """Back substitution into d.

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
    if n > 1:  # d_n to its place
        put_pair(d, 2 * n - 2, d[2], d[3])
    for k in range(n - 2, 0, -1):
        here = 2 * k
        for i in range(1, -1, -1):
            at = (2 * k + i) * WIDE
            value = share * store[at + GIVEN] - store[at + PARAMETER] * parameter
            value -= _product(store, at + FIRST, d, 0)
            value -= _product(store, at + NEXT, d, here + 2)
            if i == 0:  # the second row is free of the first entry of d_k, the first is not
                value -= store[at + HERE + 1] * d[here + 1]
            d[here + i] = value / store[at + HERE + i]
