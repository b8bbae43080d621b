"""One certified step of a flight: no contact can hide in it.

Everything is in the gap q - c and its derivatives by theta. On a stretch the cam's
c_thetatheta and |c'''| are bounded; in flight y = q'' obeys y'' + 2 Z y' + W^2 y = 0, so the
energy y'^2 + W^2 y^2 never grows and for all later s
    |q'''(s)| <= E = |q'''(0)| + W |q''(0)|,     |q''''(s)| <= (2 Z + W) E.
Hence gap'' stays between two computed numbers over a step s (chord of q'' at both ends plus or
minus (2 Z + W) E s^2/8, minus the range of c_thetatheta), and one of these decides the step:
- concave (gap'' <= 0): positive at both ends means no contact, negative at the end exactly one;
- convex (gap'' >= 0): the tangents at both ends bound the gap from below; where they do not
  decide, Newton from the left never passes the first root, and a minimum is found as a minimum;
- otherwise a parabola below the gap decides, or the step is halved.
Contacts closer than the rounding of q - c (about 1e-16 of the lift) to a graze may fall either way.
"""

from math import sqrt

from camcli.kernel.backend import kernel, outlined
from camcli.kernel.flight import flow
from camcli.kernel.profile import (
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

CLEAR, LANDED, ACCUMULATED, STUCK, LOST = 0, 1, 2, 3, 4  # how a step ends
EVALUATIONS, CROSSINGS, STEPS = 0, 1, 2  # counters in `work`

PHASE_CAP = 1.5  # largest W s of one step, so that one series covers it
MOST_HALVINGS = 60
MOST_REFINEMENTS = 80
MEANING = 4.0 * 2.220446049250313e-16
CONVERGED = 3e-6  # a Halley step this small, in units of u/accel, leaves less than one ulp


@kernel
def search(cam, lane, turns, i, theta, gap, rate, q, w, force, q2, q3, c2, energy, end, work):
    """One certified step of a flight (see the module): CLEAR, LANDED or LOST."""
    drift = cam.rows[i * ROW + JERK_MAX]
    curvature = (2.0 * lane.Z + lane.W) * energy * 0.125
    s = end
    if lane.W * s > PHASE_CAP:
        s = PHASE_CAP / lane.W
    for _ in range(MOST_HALVINGS):
        if s == end and theta == cam.rows[i * ROW + START]:
            work[CROSSINGS] += 1
            o = 3 * cam.stretches * i
            b, b1, p = turns[o], turns[o + 1], turns[o + 2]
            x = q + (w * b - force * p)
            v = w * b1 - force * b
            g1 = x - cam.rows[i * ROW + END0]
            u1 = v - cam.rows[i * ROW + END1]
            y1 = -lane.G - lane.W2 * x - 2.0 * lane.Z * v
        else:
            g1, u1, a1 = gap_at(cam, lane, i, theta, q, w, force, s, work)
            y1 = a1 + lift_at(cam, i, min(theta + s, cam.rows[i * ROW + END]))[2]
        slack = curvature * s * s
        low = min(q2, y1) - slack - min(cam.rows[i * ROW + ACCEL_MAX], c2 + drift * s)
        high = max(q2, y1) + slack - max(cam.rows[i * ROW + ACCEL_MIN], c2 - drift * s)
        stop = cam.rows[i * ROW + END] if s == end else theta + s
        if high <= 0.0:
            if g1 > 0.0:
                return CLEAR, stop, g1, u1
            return land(
                cam,
                lane,
                i,
                theta,
                q,
                w,
                force,
                0.0,
                s,
                guess(gap, rate, q2 - c2, s, g1, u1),
                work,
            )
        if low >= 0.0:
            if rate >= 0.0 or (gap > 0.0 and u1 <= 0.0 and g1 > 0.0):
                return CLEAR, stop, max(g1, 0.0), u1
            if g1 <= 0.0:
                return land(
                    cam,
                    lane,
                    i,
                    theta,
                    q,
                    w,
                    force,
                    0.0,
                    s,
                    guess(gap, rate, q2 - c2, s, g1, u1),
                    work,
                )
            if u1 <= 0.0:
                return CLEAR, stop, g1, u1
            meet = (g1 - gap - u1 * s) / (rate - u1)
            if gap + rate * meet > 0.0:
                return CLEAR, stop, g1, u1
            return dip(cam, lane, i, theta, gap, rate, q, w, force, s, stop, g1, u1, work)
        if g1 > 0.0 and gap >= 0.0 and gap + rate * s + 0.5 * low * s * s > 0.0:
            return CLEAR, stop, g1, u1
        if min(gap, g1) > 0.125 * high * s * s:
            return CLEAR, stop, g1, u1
        s *= 0.5
        if theta + s == theta:
            break
    return LOST, theta, gap, rate


@kernel
def to_end(cam, lane, i, theta, gap, rate, q, w, force, hop, end, work):
    """A concave flight whose predicted landing is near the stretch's end: look there first."""
    g, u, _ = gap_at(cam, lane, i, theta, q, w, force, end, work)
    if g > 0.0:
        return CLEAR, cam.rows[i * ROW + END], g, u
    return land(cam, lane, i, theta, q, w, force, 0.0, end, hop, work)


@kernel
def gap_at(cam, lane, i, theta, q, w, force, s, work):
    """(gap, gap_rate, gap_accel) after s of flight from (q, w) at theta, within stretch i."""
    work[EVALUATIONS] += 1
    at = theta + s
    if at > cam.rows[i * ROW + END]:
        at = cam.rows[i * ROW + END]
    c, c1, c2 = lift_at(cam, i, at)
    b, b1, p = flow(lane, s)
    x = q + (w * b - force * p)
    v = w * b1 - force * b
    return x - c, v - c1, -lane.G - lane.W2 * x - 2.0 * lane.Z * v - c2


@kernel
def land(cam, lane, i, theta, q, w, force, low, high, guess, work):
    """Root of the gap between low (gap >= 0) and high (gap <= 0) where it is the only one.

    Halley's iteration kept inside the bracket. A step below CONVERGED u/accel leaves an error of
    its cube, less than one rounding, so the last evaluation is spared.
    """
    s = guess if low < guess < high else 0.5 * (low + high)
    u = 0.0
    for _ in range(MOST_REFINEMENTS):
        g, u, a = gap_at(cam, lane, i, theta, q, w, force, s, work)
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
            if abs(step) <= MEANING * (theta + s):
                break
            after = 0.5 * (low + high)
            step = after - s
            if after in (low, high):
                break
        elif abs(step) * abs(a) <= CONVERGED * -u and abs(step) <= CONVERGED:
            s = after
            u += a * step
            break
        s = after
    if u > 0.0:
        u = 0.0
    return LANDED, min(theta + s, cam.rows[i * ROW + END]), 0.0, u


@kernel
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
def dip(cam, lane, i, theta, gap, rate, q, w, force, end, stop, g_end, u_end, work):
    """A convex gap with its minimum inside the step: Newton from the left, contact or minimum.

    Every iterate is left of the first root, if there is one (the tangent lies below the gap); a
    positive slope means that the minimum was passed without contact.
    """
    s = 0.0
    g, u = gap, rate
    for _ in range(MOST_REFINEMENTS):
        if u >= 0.0:
            return CLEAR, stop, g_end, u_end
        step = -g / u
        if s + step == s or g <= 0.0:
            return LANDED, theta + s, 0.0, u
        s += step
        if s >= end:
            return CLEAR, stop, g_end, u_end
        g, u, _ = gap_at(cam, lane, i, theta, q, w, force, s, work)
    return LANDED, theta + s, 0.0, u
