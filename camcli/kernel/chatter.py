"""At the contact: the chatter map with its error, and the local Taylor series of the gap."""

from camcli.kernel.cam_table import RADIUS, ROW, higher
from camcli.kernel.marks import inlined

REFUSED = 1e300
LARGEST_CHANGE = 0.25  # relative change of the acceleration the error estimate covers
TAYLOR_PHASE = 0.02  # largest (W + 2 Z) s of the follower's own series of order 6


@inlined
def chatter_map(lane, u, accel, jerk, jerk_bound, snap_bound):
    """Phase left until impacts accumulate, after an impact with u > 0 and accel < 0: (tau, error).

    With alpha = -accel, p = 2 u/alpha the first hop, rho = jerk/alpha and
    kappa = 2 rho/3 - Z (1 + r), hops shrink as p' = r p (1 + kappa p + O(p^2)), so
        tau = p/(1 - r) + (rho/3 + r kappa/(1 - r)) p^2/(1 - r^2) + O(p^3).
    The first term is the classical 2 r |u-|/((1 - r)|a|). With L = p/(1 - r) and the bounds on the
    third and fourth derivative of the gap ahead, the neglected part is below
        L (eta^2 + delta L^2),  eta = (|gap'''|/alpha + 2 Z) L, delta = |gap''''|/alpha,
    while eta <= 1/4 (checked against an independent summation in the tests); else refused.
    Needs 0 < r < 1; the caller sees to it that tau does not jump over a corner.
    """
    alpha = -accel
    p = 2.0 * u / alpha
    left = 1.0 - lane.r
    length = p / left
    eta = (jerk_bound / alpha + 2.0 * lane.Z) * length
    if eta > LARGEST_CHANGE:
        return length, REFUSED
    rho = jerk / alpha
    kappa = 2.0 * rho / 3.0 - lane.Z * (1.0 + lane.r)
    second = (rho / 3.0 + lane.r * kappa / left) / (left * (1.0 + lane.r))
    error = length * (eta * eta + snap_bound / alpha * length * length)
    return length + second * p * p, error


@inlined
def taylor(cam, lane, i, theta, q2, q3, c2):
    """Second to sixth derivative of the gap over their factorials, at theta of stretch i.

    q2, q3 are q'' and q''' in flight; the rest follow from q'''' = -2 Z q''' - W^2 q'' and so on.
    """
    c3, c4, c5, c6 = higher(cam, i, theta)
    q4 = -2.0 * lane.Z * q3 - lane.W2 * q2
    q5 = -2.0 * lane.Z * q4 - lane.W2 * q3
    q6 = -2.0 * lane.Z * q5 - lane.W2 * q4
    return (
        (q2 - c2) * 0.5,
        (q3 - c3) * (1.0 / 6.0),
        (q4 - c4) * (1.0 / 24.0),
        (q5 - c5) * (1.0 / 120.0),
        (q6 - c6) * (1.0 / 720.0),
    )


@inlined
def taylor_holds(cam, lane, i, s):
    """True where the series of order 6 is more exact over s than q - c computed in doubles."""
    return s <= cam.rows[i * ROW + RADIUS] and (lane.W + 2.0 * lane.Z) * s <= TAYLOR_PHASE


@inlined
def series_gap(gap, rate, t, s):
    """(gap, gap_rate) at s from the coefficients of `taylor`."""
    t2, t3, t4, t5, t6 = t
    value = s * (t2 + s * (t3 + s * (t4 + s * (t5 + s * t6))))
    slope = s * (2.0 * t2 + s * (3.0 * t3 + s * (4.0 * t4 + s * (5.0 * t5 + s * 6.0 * t6))))
    return gap + s * (rate + value), rate + slope
