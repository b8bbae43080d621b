"""The gap over a short flight in relative coordinates: nothing cancels, however low the hop.

    gap(s) = gap + rate s + s^2 Q(s) - fall(s),   fall = c(theta + s) - c(theta) - c_theta(theta) s.
Within a piece of the cam, fall/s^2 is the second divided difference of its polynomial (two
synthetic divisions and a Horner sum in one loop); over several pieces the parts add up with the
slope gained before. The follower's part is Q = sum T_n/((n + 1)(n + 2)) with
    T_0 = q'', T_1 = q3 s, T_n = (-2 Z s T_{n-1} - W^2 s^2 T_{n-2}/(n - 1))/n,
from q'''' = -2 Z q''' - W^2 q''; the slope has sum T_n/(n + 1), the acceleration sum T_n.
"""

from camcli.kernel.cam_table import END, PER_ANGLE, PIECE, ROW, TERMS, lift_at, piece_at
from camcli.kernel.marks import outlined

NEAR = 0.03125  # rad, longest flight for which this is worth its cost
LONGEST_PHASE = 0.125  # (W + 2 Z) s that MOST_TERMS terms cover to rounding
MOST_TERMS = 10
INVERSE = (0.0, *(1.0 / n for n in range(1, MOST_TERMS + 2)))


@outlined
def gap_near(cam, lane, i, f, s):
    """(gap, gap_rate, gap_accel) after s > 0 of the flight f, s <= NEAR and within stretch i."""
    fall, slope = cam_fall(cam, i, f.theta, s)
    at = f.theta + s
    end = cam.rows[i * ROW + END]
    accel = lift_at(cam, i, at if at < end else end)[2]
    before, term = f.q2, f.q3 * s
    q_fall = 0.5 * before + term * INVERSE[6]
    q_slope = before + 0.5 * term
    q_accel = before + term
    spring, damper = lane.W2 * s * s, 2.0 * lane.Z * s
    for n in range(2, MOST_TERMS):
        after = -(damper * term + spring * before * INVERSE[n - 1]) * INVERSE[n]
        before, term = term, after
        q_accel += term
        q_slope += term * INVERSE[n + 1]
        q_fall += term * INVERSE[n + 1] * INVERSE[n + 2]
    gap = f.gap + (s * (f.rate + s * q_fall) - fall)
    return gap, f.rate + (s * q_slope - slope), q_accel - accel


@outlined
def cam_fall(cam, i, theta, s):
    """(c(theta + s) - c(theta) - c_theta(theta) s, c_theta(theta + s) - c_theta(theta))."""
    row = i * ROW
    o = piece_at(cam, i, theta)
    last = piece_at(cam, i, theta + s)
    width = 1.0 / cam.rows[row + PER_ANGLE]
    x = theta - cam.pieces[o]
    left = s
    fall, slope = 0.0, 0.0
    while True:
        step = left if o == last else min(left, max(0.5 * width - x, 0.0))
        second, first = divided_differences(cam, o, x, step)
        fall += step * (slope + step * second)
        slope += step * first
        left -= step
        if o == last:
            return fall, slope
        x = x + step + cam.pieces[o] - cam.pieces[o + PIECE]
        o += PIECE


@outlined
def divided_differences(cam, o, x, step):
    """(second of c, first of c_theta) between x and x + step from the centre of the piece at o."""
    y = x + step
    once, twice, second = 0.0, 0.0, 0.0
    for j in range(TERMS - 1, 1, -1):
        once = cam.pieces[o + 1 + j] + x * once
        twice = once + x * twice
        second = twice + y * second
    once, first = 0.0, 0.0
    for j in range(TERMS - 1, 0, -1):
        once = cam.pieces[o + 1 + TERMS + j] + x * once
        first = once + y * first
    return second, first
