"""The linear algebra of multiple shooting: a cyclic system in blocks of two, with a border.

    L_k d_k + R_k d_{k+1} + p_k dp = -E_k,  d_{n+1} = d_1,    row (d_1, ..., d_n, dp) = right
`_forward` eliminates impact by impact with pivoting among the four rows in hand (Wright, SIAM J.
Sci. Stat. Comput. 13 (1992) 742), which is stable however unstable the orbit is; the closing system
keeps the border row, so folds are regular. The work is proportional to n.
"""

from typing import Any, NamedTuple

from camcli.kernel.marks import outlined

BLOCK = 10  # numbers an impact takes in `Tables.blocks`: L (4), R (4), E (2)
WIDE = 8  # columns of a row in hand: d_1 (2), d_k (2), d_k+1 (2), parameter, right side
ROWS = 5  # rows in hand: two carried, two of the next flight, the border


class Tables(NamedTuple):
    """Room for the Newton steps of an orbit of n impacts; the caller allocates it once."""

    blocks: Any  # (n * BLOCK,)
    columns: Any  # (2 n,), derivatives by the parameter
    step: Any  # (2 n + 1,)
    tangent: Any  # (2 n + 1,)
    hand: Any  # (ROWS * WIDE,)
    store: Any  # (2 n * WIDE,)
    last: Any  # (5 * 7,)


@outlined
def _swap(a, i, j, wide):
    for column in range(wide):
        a[i * wide + column], a[j * wide + column] = a[j * wide + column], a[i * wide + column]


@outlined
def _eliminate(a, wide, column, pivot, rows, candidates):
    """Pivot on `column` at row `pivot`, the largest among the first `candidates` rows below it."""
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
def _forward(n, blocks, columns, row, right, a, store):
    """Eliminate impacts 2 .. n - 1; rows in hand: [pivot, pivot, carried, carried, border].

    On return `a` holds the two carried rows and the border in d_1, d_n, parameter, right side.
    """
    for c in range(WIDE):
        for i in range(ROWS):
            a[i * WIDE + c] = 0.0
    _put(a, 0, blocks, 0, columns, 0, 2)
    a[4 * WIDE], a[4 * WIDE + 1] = row[0], row[1]
    a[4 * WIDE + 6], a[4 * WIDE + 7] = row[2 * n], right
    if n > 1:
        a[4 * WIDE + 2], a[4 * WIDE + 3] = row[2], row[3]
    for k in range(1, n - 1):
        _put(a, 2, blocks, k, columns, 2, 4)
        a[4 * WIDE + 4], a[4 * WIDE + 5] = row[2 * k + 2], row[2 * k + 3]
        for column in range(2):
            if not _eliminate(a, WIDE, 2 + column, column, ROWS, 4):
                return False
        for c in range(2 * WIDE):
            store[2 * WIDE * k + c] = a[c]
        for i in range(3):
            source = (2 + i) * WIDE
            target = (i if i < 2 else 4) * WIDE
            for c in range(WIDE):
                a[target + c] = a[source + c]
            a[target + 2], a[target + 3] = a[target + 4], a[target + 5]
            a[target + 4], a[target + 5] = 0.0, 0.0
    return True


@outlined
def _put(a, first, blocks, k, columns, left, right):
    """Rows first, first + 1 of `a`: flight k with L in columns `left`, R in columns `right`."""
    o = BLOCK * k
    for i in range(2):
        at = (first + i) * WIDE
        for c in range(WIDE):
            a[at + c] = 0.0
        for c in range(2):
            a[at + left + c] += blocks[o + 2 * i + c]
            a[at + right + c] += blocks[o + 4 + 2 * i + c]
        a[at + 6] = columns[2 * k + i]
        a[at + 7] = -blocks[o + 8 + i]


@outlined
def solve_bordered(n, t, row, right):
    """Newton step and tangent of the bordered system; False where it is singular.

    t.step solves J d = -E, row d = right; t.tangent J d = 0, row d = 1.
    """
    a, last, blocks, columns = t.hand, t.last, t.blocks, t.columns
    if not _forward(n, blocks, columns, row, right, a, t.store):
        return False
    size = 3 if n == 1 else 5
    wide = size + 2
    for i in range(size - 1):
        for c in range(wide):
            last[i * wide + c] = 0.0
    if n == 1:  # the flight closes on itself: L + R in one pair of columns
        for i in range(2):
            last[i * wide] = a[i * WIDE] + a[i * WIDE + 2]
            last[i * wide + 1] = a[i * WIDE + 1] + a[i * WIDE + 3]
            last[i * wide + 2], last[i * wide + 3] = a[i * WIDE + 6], a[i * WIDE + 7]
    else:
        for i in range(2):
            for c in range(4):
                last[i * wide + c] = a[i * WIDE + c]
            last[i * wide + 4], last[i * wide + 5] = a[i * WIDE + 6], a[i * WIDE + 7]
        _put(a, 2, blocks, n - 1, columns, 2, 0)
        for i in range(2):
            for c in range(4):
                last[(2 + i) * wide + c] = a[(2 + i) * WIDE + c]
            last[(2 + i) * wide + 4] = a[(2 + i) * WIDE + 6]
            last[(2 + i) * wide + 5] = a[(2 + i) * WIDE + 7]
    border = (size - 1) * wide
    for c in range(size - 1):
        last[border + c] = a[4 * WIDE + c]
    last[border + size - 1], last[border + size] = a[4 * WIDE + 6], a[4 * WIDE + 7]
    for i in range(size):
        last[i * wide + size + 1] = 1.0 if i == size - 1 else 0.0
    for column in range(size):
        if not _eliminate(last, wide, column, column, size, size):
            return False
    _back(n, last, size, size, t.store, t.step, 1.0)
    _back(n, last, size, size + 1, t.store, t.tangent, 0.0)
    return True


@outlined
def _back(n, last, size, side, store, d, share):
    """Back substitution; `side`: the column of the right side, `share` of the stored ones."""
    wide = size + 2
    for i in range(size - 1, -1, -1):
        value = last[i * wide + side]
        for c in range(i + 1, size):
            value -= last[i * wide + c] * d[c]
        d[i] = value / last[i * wide + i]
    d[2 * n] = d[size - 1]
    if n > 1:
        d[2 * n - 2], d[2 * n - 1] = d[2], d[3]
    for k in range(n - 2, 0, -1):
        o = 2 * WIDE * k
        for i in range(1, -1, -1):
            at = o + i * WIDE
            value = share * store[at + 7] - store[at + 6] * d[2 * n]
            value -= store[at] * d[0] + store[at + 1] * d[1]
            value -= store[at + 4] * d[2 * k + 2] + store[at + 5] * d[2 * k + 3]
            if i == 0:
                value -= store[at + 3] * d[2 * k + 1]
            d[2 * k + i] = value / store[at + 2 + i]
