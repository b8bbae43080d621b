"""The cam as a table of polynomial pieces; the kernel knows no kind of cam.

The turn [0, 2 pi) is cut into *stretches* on which c is smooth: at every corner (jump of
c_thetatheta), at 0 and at the strobe phase. A stretch holds equal *pieces*, each a polynomial of
degree 13 in x = theta - centre, with its six derivatives in tables of the same shape.
At a corner the stretch decides the side: its start is right-sided, its end left-sided.
"""

from typing import Any, NamedTuple

from camcli.kernel.backend import kernel

TERMS = 14  # coefficients of a piece
ORDERS = 7  # c and its derivatives up to the sixth


class Cam(NamedTuple):
    """Tables of one cam; a row per stretch (n), a row per piece (k). Lengths in m, angles in rad."""

    start: Any  # (n,) rad
    end: Any  # (n,) rad, the next start; 2 pi for the last
    first: Any  # (n,) int, first piece
    count: Any  # (n,) int, number of pieces
    per_angle: Any  # (n,) pieces per rad
    start0: Any  # (n,) c, right-sided at the start
    start1: Any  # (n,) c_theta
    start2: Any  # (n,) c_thetatheta
    kick: Any  # (n,) jump of c_theta at the start, 0 where it is continuous
    end0: Any  # (n,) c, left-sided at the end
    end1: Any  # (n,)
    end2: Any  # (n,)
    accel_min: Any  # (n,) smallest c_thetatheta on the stretch
    accel_max: Any  # (n,) largest
    jerk_max: Any  # (n,) bound on |c'''|
    snap_max: Any  # (n,) bound on |c''''|
    radius: Any  # (n,) rad, how far a Taylor series of order 6 is exact to 2e-17 m
    low: Any  # (n,) smallest c
    slope_low: Any  # (n,) smallest c_theta
    center: Any  # (k,) rad
    c0: Any  # (k * TERMS,) coefficients of c, lowest power first
    c1: Any
    c2: Any
    c3: Any
    c4: Any
    c5: Any
    c6: Any
    top: float  # largest c of the turn
    strobe: int  # stretch that begins at the strobe phase


@kernel
def polynomial(table, o, x):
    """Sum of table[o + j] x^j for j < TERMS, as two interleaved Horner chains (half the latency)."""
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


@kernel
def piece_at(cam, i, theta):
    """Piece of stretch i that holds theta (clamped to the stretch)."""
    k = int((theta - cam.start[i]) * cam.per_angle[i])
    last = cam.count[i] - 1
    if k > last:
        k = last
    return cam.first[i] + k


@kernel
def lift(cam, i, theta):
    """(c, c_theta, c_thetatheta) at theta within stretch i."""
    k = piece_at(cam, i, theta)
    x = theta - cam.center[k]
    o = k * TERMS
    return polynomial(cam.c0, o, x), polynomial(cam.c1, o, x), polynomial(cam.c2, o, x)


@kernel
def lift_at(cam, i, theta):
    """`lift`, reading the stored values at the two ends of the stretch."""
    if theta == cam.start[i]:
        return cam.start0[i], cam.start1[i], cam.start2[i]
    if theta == cam.end[i]:
        return cam.end0[i], cam.end1[i], cam.end2[i]
    return lift(cam, i, theta)


@kernel
def higher(cam, i, theta):
    """Third to sixth derivative of c at theta within stretch i."""
    k = piece_at(cam, i, theta)
    x = theta - cam.center[k]
    o = k * TERMS
    return (
        polynomial(cam.c3, o, x),
        polynomial(cam.c4, o, x),
        polynomial(cam.c5, o, x),
        polynomial(cam.c6, o, x),
    )


@kernel
def stretch_at(cam, theta):
    """Index of the stretch that holds theta in [0, 2 pi); a boundary belongs to the right."""
    i = len(cam.start) - 1
    while cam.start[i] > theta:
        i -= 1
    return i
