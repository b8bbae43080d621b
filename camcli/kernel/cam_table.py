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

# A piece in the table: its centre; the coefficients of the lift and of its derivatives, TERMS each;
# what the constants of lift and slope leave out.
PIECE = 3 + ORDERS * TERMS
LIFT, SLOPE, CURVATURE, THIRD, FOURTH, FIFTH, SIXTH = (1 + order * TERMS for order in range(ORDERS))
LIFT_REST, SLOPE_REST = PIECE - 2, PIECE - 1


class Stretch(NamedTuple):
    """A row of the table: m, rad, derivatives by theta.

    Values at the start are right-sided and belong to this stretch, those at the end left-sided.
    """

    start: float
    end: float  # the next start; 2 pi for the last
    first_piece: int
    piece_count: int
    per_angle: float  # pieces per rad
    start_c: float
    start_c1: float  # c_theta
    start_c2: float  # c_thetatheta
    end_c: float
    end_c1: float
    end_c2: float
    slope_jump: float  # of c_theta at the start, 0 where it is continuous
    accel_min: float  # bounds of c_thetatheta on the stretch
    accel_max: float
    jerk_max: float  # bound on the third derivative
    snap_max: float  # bound on the fourth
    crackle_max: float  # bound on the fifth
    radius: float  # how far a Taylor series of order 6 is exact to 2e-17 m/rad
    c_min: float  # lower bounds of c and c_theta
    slope_min: float
    dwell: int  # 1 where c is constant
    rest: float  # rad, what `start` leaves out of the corner's phase
    seat: int = 0  # 1 where the follower rests on its seat, with a restitution of its own


class Cam(NamedTuple):
    """Tables of one cam."""

    stretches: Any  # table of Stretch
    pieces: Any  # (pieces * PIECE,), coefficients lowest power first; flat: a row is too long
    strobe: int  # stretch that begins at the strobe phase
    top: float  # largest c of the turn, m


@inlined
def polynomial(table, o, x):
    """Sum of table[o + j] x^j for j < TERMS; o: offset of the coefficients in the table."""
    return table[o] + polynomial_gain(table, o, x)


@inlined
def polynomial_gain(table, o, x):
    """`polynomial` without its constant, as two Horner chains at half the latency."""
    y = x * x
    even = y * (
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
    k = int((theta - cam.stretches[i].start) * cam.stretches[i].per_angle)
    last = cam.stretches[i].piece_count - 1
    if k > last:
        k = last
    return (cam.stretches[i].first_piece + k) * PIECE


@inlined
def lift(cam, i, theta):
    """(c, c_theta, c_thetatheta) at theta within stretch i."""
    if cam.stretches[i].dwell:  # the same values, without their polynomials
        return cam.stretches[i].start_c, 0.0, 0.0
    piece = piece_at(cam, i, theta)
    x = theta - cam.pieces[piece]
    return (
        polynomial(cam.pieces, piece + LIFT, x),
        polynomial(cam.pieces, piece + SLOPE, x),
        polynomial(cam.pieces, piece + CURVATURE, x),
    )


@inlined
def lift_parts(cam, i, theta):
    """(level, gain, slope, bend, c_thetatheta): c = level + gain and c_theta = slope + bend.

    level and slope are values at the centre of the piece, as doubles; gain and bend what comes to
    them up to theta, and what these doubles leave out. Both sums are exact to about 1e-17.
    """
    if cam.stretches[i].dwell:
        piece = PIECE * cam.stretches[i].first_piece
        level = cam.pieces[piece + LIFT]
        gain = cam.pieces[piece + LIFT_REST]
        return level, gain, 0.0, cam.pieces[piece + SLOPE_REST], 0.0
    piece = piece_at(cam, i, theta)
    x = theta - cam.pieces[piece]
    level = cam.pieces[piece + LIFT]
    slope = cam.pieces[piece + SLOPE]
    gain = polynomial_gain(cam.pieces, piece + LIFT, x) + cam.pieces[piece + LIFT_REST]
    bend = polynomial_gain(cam.pieces, piece + SLOPE, x) + cam.pieces[piece + SLOPE_REST]
    return level, gain, slope, bend, polynomial(cam.pieces, piece + CURVATURE, x)


@inlined
def lift_at(cam, i, theta):
    """`lift`, reading the stored values at the two ends of the stretch."""
    if theta == cam.stretches[i].start:
        return cam.stretches[i].start_c, cam.stretches[i].start_c1, cam.stretches[i].start_c2
    if theta == cam.stretches[i].end:
        return cam.stretches[i].end_c, cam.stretches[i].end_c1, cam.stretches[i].end_c2
    return lift(cam, i, theta)


@inlined
def derivative(cam, order, i, theta):
    """Derivative of c of an order >= 1 at theta within stretch i."""
    if cam.stretches[i].dwell:
        return 0.0
    piece = piece_at(cam, i, theta)
    return polynomial(cam.pieces, piece + LIFT + order * TERMS, theta - cam.pieces[piece])


@inlined
def higher(cam, i, theta):
    """Third to sixth derivative of c at theta within stretch i."""
    piece = piece_at(cam, i, theta)
    x = theta - cam.pieces[piece]
    return (
        polynomial(cam.pieces, piece + THIRD, x),
        polynomial(cam.pieces, piece + FOURTH, x),
        polynomial(cam.pieces, piece + FIFTH, x),
        polynomial(cam.pieces, piece + SIXTH, x),
    )


@inlined
def restitution_at(cam, const, i):
    """The coefficient of restitution on stretch i: that of the cam, or that of its seat."""
    if cam.stretches[i].seat:
        return const.r_seat
    return const.r


@inlined
def stretch_at(cam, theta):
    """Index of the stretch that holds theta in [0, 2 pi); a boundary belongs to the right."""
    i = len(cam.stretches) - 1
    while cam.stretches[i].start > theta:
        i -= 1
    return i
