"""One certified step of a flight: no contact can hide in it.

Everything is in the gap q - c and its derivatives by theta. On a stretch the cam's
c_thetatheta and |c'''| are bounded; in flight y = q'' obeys y'' + 2 Z y' + W^2 y = 0, so the
energy y'^2 + W^2 y^2 never grows and for all later s
    |q'''(s)| <= E = |q'''(0)| + W |q''(0)|,     |q''''(s)| <= (2 Z + W) E,
and, q' obeying the same equation, |q''(s)| <= |q''(0)| + W |q'(0)|, which is what a stiff damper
leaves of the first. Hence gap'' stays between two computed numbers over a step s (chord of q'' at
both ends plus or minus (2 Z + W) E s^2/8, minus the range of c_thetatheta), and one of these
decides the step:
- concave (gap'' <= 0): positive at both ends means no contact, negative at the end exactly one;
- convex (gap'' >= 0): the tangents at both ends bound the gap from below; where they do not
  decide, Newton from the left never passes the first root, and a minimum is found as a minimum;
- otherwise a slope that stays negative, or a parabola below the gap decides, or the step is halved.
Contacts closer than the rounding of q - c (about 1e-16 of the lift) to a graze may fall either way.
"""

from math import sqrt
from typing import NamedTuple

from camcli.kernel.cam_table import (
    ACCEL_MAX,
    ACCEL_MIN,
    END,
    END0,
    END1,
    JERK_MAX,
    ROW,
    START,
    lift_at,
)
from camcli.kernel.flow import flow
from camcli.kernel.gap_series import LONGEST_PHASE, NEAR, gap_near
from camcli.kernel.marks import inlined, outlined

CLEAR, LANDED, ACCUMULATED, STUCK, LOST = 0, 1, 2, 3, 4  # how a step ends
EVALUATIONS, CROSSINGS, STEPS = 0, 1, 2  # counters in `work`

PHASE_CAP = 1.5  # largest W s of one step, so that one series covers it
MOST_HALVINGS = 60
MOST_REFINEMENTS = 80
MEANING = 4.0 * 2.220446049250313e-16
CONVERGED = 3e-6  # a Halley step this small, in units of u/accel, leaves less than one ulp


class Flight(NamedTuple):
    """A flight as it begins at theta within a stretch; derivatives by theta, m and rad."""

    theta: float
    gap: float  # q - c >= 0
    rate: float  # d gap/dtheta
    q: float
    w: float  # q'
    force: float  # G + W^2 q
    q2: float  # q'' = -force - 2 Z w
    q3: float
    c2: float  # c_thetatheta
    energy: float  # bound on the third derivative of q from here on
    end: float  # rad to the end of the stretch


@inlined
def flight_at(cam, lane, i, theta, gap, rate):
    """The flight that begins with (gap, rate) at theta of stretch i."""
    c, c1, c2 = lift_at(cam, i, theta)
    q = c + gap
    w = c1 + rate
    force = lane.G + lane.W2 * q
    q2 = -force - 2.0 * lane.Z * w
    q3 = -2.0 * lane.Z * q2 - lane.W2 * w
    energy = abs(q3) + lane.W * abs(q2)
    end = cam.rows[i * ROW + END] - theta
    return Flight(theta, gap, rate, q, w, force, q2, q3, c2, energy, end)


@inlined
def search(cam, lane, turns, i, f, work):
    """One certified step of a flight (see the module): CLEAR, LANDED or LOST."""
    row = i * ROW
    drift = cam.rows[row + JERK_MAX]
    curvature = (2.0 * lane.Z + lane.W) * f.energy * 0.125
    reach = abs(f.q2) + lane.W * abs(f.w)
    s = f.end
    if lane.W * s > PHASE_CAP:
        s = PHASE_CAP / lane.W
    for _ in range(MOST_HALVINGS):
        if s == f.end and f.theta == cam.rows[row + START]:
            g1, u1, y1 = _across(cam, lane, turns, i, f, work)
        else:
            g1, u1, a1 = gap_at(cam, lane, i, f, s, work)
            y1 = a1 + lift_at(cam, i, min(f.theta + s, cam.rows[row + END]))[2]
        slack = curvature * s * s
        lowest, highest = max(min(f.q2, y1) - slack, -reach), min(max(f.q2, y1) + slack, reach)
        low = lowest - min(cam.rows[row + ACCEL_MAX], f.c2 + drift * s)
        high = highest - max(cam.rows[row + ACCEL_MIN], f.c2 - drift * s)
        stop = cam.rows[row + END] if s == f.end else f.theta + s
        falls = f.rate < 0.0 and (low >= 0.0 or f.rate + high * s < 0.0)
        if (high <= 0.0 or falls) and g1 <= 0.0:
            return land(cam, lane, i, f, s, guess(f.gap, f.rate, f.q2 - f.c2, s, g1, u1), work)
        if high <= 0.0:
            return CLEAR, stop, g1, u1
        if low >= 0.0:
            if f.rate >= 0.0 or u1 <= 0.0:
                return CLEAR, stop, max(g1, 0.0), u1
            meet = (g1 - f.gap - u1 * s) / (f.rate - u1)
            if f.gap + f.rate * meet > 0.0:
                return CLEAR, stop, g1, u1
            return dip(cam, lane, i, f, s, stop, g1, u1, work)
        if g1 > 0.0 and f.gap + f.rate * s + 0.5 * low * s * s > 0.0:
            return CLEAR, stop, g1, u1
        if min(f.gap, g1) > 0.125 * high * s * s:
            return CLEAR, stop, g1, u1
        s *= 0.5 if lane.Z * s < 8.0 else 0.125  # a stiff damper's layer is thin
        if f.theta + s == f.theta:
            break
    return LOST, f.theta, f.gap, f.rate


@inlined
def _across(cam, lane, turns, i, f, work):
    """(gap, gap_rate, q'') at the end of stretch i of a flight from its start, by the table."""
    work[CROSSINGS] += 1
    o = 3 * cam.stretches * i
    b, b1, p = turns[o], turns[o + 1], turns[o + 2]
    x = f.q + (f.w * b - f.force * p)
    v = f.w * b1 - f.force * b
    y = -lane.G - lane.W2 * x - 2.0 * lane.Z * v
    return x - cam.rows[i * ROW + END0], v - cam.rows[i * ROW + END1], y


@inlined
def gap_at(cam, lane, i, f, s, work):
    """(gap, gap_rate, gap_accel) after s rad of the flight, within stretch i.

    From the closed form of q and c, or where s is short in relative coordinates: q - c of two large
    numbers would drown a low hop.
    """
    work[EVALUATIONS] += 1
    if s <= NEAR and (lane.W + 2.0 * lane.Z) * s <= LONGEST_PHASE:
        return gap_near(cam, lane, i, f, s)
    at = f.theta + s
    if at > cam.rows[i * ROW + END]:
        at = cam.rows[i * ROW + END]
    c, c1, c2 = lift_at(cam, i, at)
    b, b1, p = flow(lane, s)
    x = f.q + (f.w * b - f.force * p)
    v = f.w * b1 - f.force * b
    return x - c, v - c1, -lane.G - lane.W2 * x - 2.0 * lane.Z * v - c2


@inlined
def land(cam, lane, i, f, high, first, work):
    """Root of the gap between 0 and `high` (gap <= 0) where it is the only one; first: a guess.

    Halley's iteration kept inside the bracket. A step below CONVERGED u/accel leaves an error of
    its cube, less than one rounding, so the last evaluation is spared; the velocity after it takes
    the jerk from the accelerations of the last two places.
    """
    low = 0.0
    s = first if low < first < high else 0.5 * high
    u = 0.0
    last, accel = 0.0, f.q2 - f.c2
    for _ in range(MOST_REFINEMENTS):
        g, u, a = gap_at(cam, lane, i, f, s, work)
        if g > 0.0:
            low = s
        else:
            high = s
        step = high - low
        if u < 0.0:
            newton = -g / u
            curve = newton * a / u
            step = newton / (1.0 + 0.5 * curve) if abs(curve) < 0.5 else newton
        after = s + step
        if not low < after < high:
            if abs(step) <= MEANING * (f.theta + s):
                break
            after = 0.5 * (low + high)
            if after in (low, high):
                break
        elif abs(step) * abs(a) <= CONVERGED * -u and abs(step) <= CONVERGED:
            u += step * (a + 0.5 * step * ((a - accel) / (s - last)))
            s = after
            break
        last, accel, s = s, a, after
    return LANDED, min(f.theta + s, cam.rows[i * ROW + END]), 0.0, u


@inlined
def guess(gap, rate, accel, s, g1, u1):
    """Landing predicted by the parabola at the start, else by the tangent at the end."""
    square = rate * rate - 2.0 * accel * gap
    if square > 0.0:
        root = sqrt(square)
        if accel < 0.0:
            hop = (rate + root) / -accel if rate >= 0.0 else 2.0 * gap / (root - rate)
        else:
            hop = 2.0 * gap / (root - rate) if rate < 0.0 else s
        if 0.0 < hop < s:
            return hop
    return s - g1 / u1 if u1 < 0.0 else 0.5 * s


@outlined
def dip(cam, lane, i, f, end, stop, g_end, u_end, work):
    """A convex gap with its minimum inside the step: Newton from the left, contact or minimum.

    Every iterate is left of the first root, if there is one (the tangent lies below the gap); a
    positive slope means that the minimum was passed without contact.
    """
    s = 0.0
    g, u = f.gap, f.rate
    for _ in range(MOST_REFINEMENTS):
        if u >= 0.0:
            return CLEAR, stop, g_end, u_end
        step = -g / u
        if s + step == s or g <= 0.0:
            return LANDED, f.theta + s, 0.0, u
        s += step
        if s >= end:
            return CLEAR, stop, g_end, u_end
        g, u, _ = gap_at(cam, lane, i, f, s, work)
    return LANDED, f.theta + s, 0.0, u
