"""The cam as a table of polynomial pieces; the kernel knows no kind of cam.

The turn [0, 2 pi) is cut into *stretches* on which c is smooth: at every corner (jump of
c_thetatheta), at 0 and at the strobe phase. A stretch holds equal *pieces*, each a polynomial of
degree 13 in x = theta - centre, with its six derivatives in tables of the same shape.
At a corner the stretch decides the side: its start is right-sided, its end left-sided.
"""

from typing import Any, NamedTuple

from camcli.kernel.marks import inlined

TURN = 6.283185307179586  # rad, 2 pi as a double
TERMS = 14  # coefficients of a piece
ORDERS = 7  # c and its derivatives up to the sixth

# Columns of `Cam.rows`, a row per stretch. Lengths in m, angles in rad, derivatives by theta.
COLUMNS = (
    "START",  # right-sided values here belong to this stretch
    "END",  # the next start; 2 pi for the last
    "FIRST",  # first piece
    "COUNT",  # number of pieces
    "PER_ANGLE",  # pieces per rad
    "START0",  # c, right-sided at the start
    "START1",  # c_theta
    "START2",  # c_thetatheta
    "END0",  # c, left-sided at the end
    "END1",
    "END2",
    "KICK",  # jump of c_theta at the start, 0 where it is continuous
    "ACCEL_MIN",  # bounds of c_thetatheta on the stretch
    "ACCEL_MAX",
    "JERK_MAX",  # bound on the third derivative
    "SNAP_MAX",  # bound on the fourth
    "RADIUS",  # how far a Taylor series of order 6 is exact to 2e-17 m/rad
    "LOW",  # lower bound of c
    "SLOPE_LOW",  # lower bound of c_theta
)
ROW = len(COLUMNS)
START, END, FIRST, COUNT, PER_ANGLE = 0, 1, 2, 3, 4
START0, START1, START2, END0, END1, END2, KICK = 5, 6, 7, 8, 9, 10, 11
ACCEL_MIN, ACCEL_MAX, JERK_MAX, SNAP_MAX, RADIUS, LOW, SLOPE_LOW = 12, 13, 14, 15, 16, 17, 18
PIECE = 1 + ORDERS * TERMS  # a piece: its centre, then the coefficients of each derivative


class Cam(NamedTuple):
    """Tables of one cam. Two flat tables only: every array costs at every call."""

    rows: Any  # (stretches * ROW,)
    pieces: Any  # (pieces * PIECE,), coefficients lowest power first
    stretches: int
    strobe: int  # stretch that begins at the strobe phase
    top: float  # largest c of the turn, m


@inlined
def polynomial(table, o, x):
    """Sum of table[o + j] x^j for j < TERMS, as two Horner chains at half the latency."""
    y = x * x
    even = table[o] + y * (
        table[o + 2]
        + y
        * (
            table[o + 4]
            + y * (table[o + 6] + y * (table[o + 8] + y * (table[o + 10] + y * table[o + 12])))
        )
    )
    odd = table[o + 1] + y * (
        table[o + 3]
        + y
        * (
            table[o + 5]
            + y * (table[o + 7] + y * (table[o + 9] + y * (table[o + 11] + y * table[o + 13])))
        )
    )
    return even + x * odd


@inlined
def piece_at(cam, i, theta):
    """Offset in cam.pieces of the piece of stretch i that holds theta (clamped to the stretch)."""
    row = i * ROW
    k = int((theta - cam.rows[row + START]) * cam.rows[row + PER_ANGLE])
    last = int(cam.rows[row + COUNT]) - 1
    if k > last:
        k = last
    return (int(cam.rows[row + FIRST]) + k) * PIECE


@inlined
def lift(cam, i, theta):
    """(c, c_theta, c_thetatheta) at theta within stretch i."""
    o = piece_at(cam, i, theta)
    x = theta - cam.pieces[o]
    return (
        polynomial(cam.pieces, o + 1, x),
        polynomial(cam.pieces, o + 1 + TERMS, x),
        polynomial(cam.pieces, o + 1 + 2 * TERMS, x),
    )


@inlined
def lift_at(cam, i, theta):
    """`lift`, reading the stored values at the two ends of the stretch."""
    row = i * ROW
    if theta == cam.rows[row + START]:
        return cam.rows[row + START0], cam.rows[row + START1], cam.rows[row + START2]
    if theta == cam.rows[row + END]:
        return cam.rows[row + END0], cam.rows[row + END1], cam.rows[row + END2]
    return lift(cam, i, theta)


@inlined
def third(cam, i, theta):
    """Third derivative of c at theta within stretch i."""
    o = piece_at(cam, i, theta)
    return polynomial(cam.pieces, o + 1 + 3 * TERMS, theta - cam.pieces[o])


@inlined
def higher(cam, i, theta):
    """Third to sixth derivative of c at theta within stretch i."""
    o = piece_at(cam, i, theta)
    x = theta - cam.pieces[o]
    return (
        polynomial(cam.pieces, o + 1 + 3 * TERMS, x),
        polynomial(cam.pieces, o + 1 + 4 * TERMS, x),
        polynomial(cam.pieces, o + 1 + 5 * TERMS, x),
        polynomial(cam.pieces, o + 1 + 6 * TERMS, x),
    )


@inlined
def stretch_at(cam, theta):
    """Index of the stretch that holds theta in [0, 2 pi); a boundary belongs to the right."""
    i = cam.stretches - 1
    while cam.rows[i * ROW + START] > theta:
        i -= 1
    return i
