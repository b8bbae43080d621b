"""First contact of a free flight with the cam, certified: no contact can hide before it.

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
from camcli.kernel.contact import (
    TAYLOR_PHASE,
    chatter_map,
    series_gap,
    taylor,
    taylor_holds,
)
from camcli.kernel.flight import flow
from camcli.kernel.profile import (
    ACCEL_MAX,
    ACCEL_MIN,
    END,
    END0,
    END1,
    JERK_MAX,
    RADIUS,
    ROW,
    SNAP_MAX,
    START,
    START0,
    START1,
    TURN,
    lift_at,
    third,
)

CLEAR, LANDED, ACCUMULATED, STUCK, LOST = 0, 1, 2, 3, 4
FREE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins: gap > 0, after an impact, from sticking

PHASE_CAP = 1.5  # largest W s of one step, so that one series covers it
MOST_HALVINGS = 60
MOST_REFINEMENTS = 80
MEANING = 4.0 * 2.220446049250313e-16
HALF_PERIOD = 9.8  # just below pi squared
CONVERGED = 3e-6  # a Halley step this small, in units of u/accel, leaves less than one ulp

EVALUATIONS, CROSSINGS, STEPS = 0, 1, 2  # counters in `work`


@kernel
def fly(cam, lane, turns, i, theta, gap, rate, begin, work):
    """Advance a flight within stretch i from theta: (code, theta, gap, rate).

    gap >= 0 and rate = d gap/dtheta at theta; `begin` says how the flight begins; `turns` is the
    table of `lanes.prepare`. Codes: CLEAR (moved on, at most to the stretch's end), LANDED
    (contact; rate <= 0 is the relative velocity), ACCUMULATED (chatter ends at theta), STUCK (rests
    on the cam), LOST (the step shrank to nothing: closer to grazing than doubles can tell).
    """
    if gap <= 0.0 and begin == FREE:
        if rate < 0.0:
            return LANDED, theta, 0.0, rate
        begin = BOUNCED
    c, c1, c2 = lift_at(cam, i, theta)
    q = c + gap
    w = c1 + rate
    force = lane.G + lane.W2 * q
    q2 = -force - 2.0 * lane.Z * w
    q3 = -2.0 * lane.Z * q2 - lane.W2 * w
    accel = q2 - c2
    energy = abs(q3) + lane.W * abs(q2)
    bound = energy + cam.rows[i * ROW + JERK_MAX]
    end = cam.rows[i * ROW + END] - theta

    if (begin != FREE and accel >= 0.0) or begin == RELEASED:
        return _leave(cam, lane, turns, i, theta, rate, q, w, force, q2, q3, c2, energy, end, work)
    if begin == BOUNCED and rate <= 0.0:
        return STUCK, theta, 0.0, 0.0

    if accel < 0.0:
        alpha = -accel
        if begin == BOUNCED and 0.0 < lane.r < 1.0:
            tau = _accumulation(cam, lane, i, theta, rate, q2, q3, c2, accel, energy, end)
            if tau >= 0.0:
                return ACCUMULATED, theta + tau, 0.0, 0.0
        root = sqrt(rate * rate + 2.0 * alpha * gap)
        hop = (rate + root) / alpha if rate >= 0.0 else 2.0 * gap / (root - rate)
        reach = 1.5 * hop
        if bound * reach <= 0.5 * alpha:
            return _hop(cam, lane, i, theta, gap, rate, q, w, force, q2, q3, c2, hop, end, work)
    return _search(
        cam, lane, turns, i, theta, gap, rate, q, w, force, q2, q3, c2, energy, end, work
    )


@outlined
def _leave(cam, lane, turns, i, theta, rate, q, w, force, q2, q3, c2, energy, end, work):
    """Leave the cam with rate >= 0 and gap_accel >= 0 (or released by a zero of the force).

    With jerk < 0 and the fourth derivative below K the gap rises once and falls once while
    K s <= |jerk|/2, so a landing predicted by the cubic within that range is the only one. From
    rest with jerk > 0, gap = accel s^2/2 + jerk s^3/6 + ... stays positive for s <= 2 jerk/K.
    """
    accel = max(q2 - c2, 0.0)
    _t2, t3, t4, t5, t6 = taylor(cam, lane, i, theta, q2, q3, c2)
    t = (0.5 * accel, t3, t4, t5, t6)
    jerk = 6.0 * t3
    snap = (2.0 * lane.Z + lane.W) * energy + cam.rows[i * ROW + SNAP_MAX]
    if jerk < 0.0 and (accel > 0.0 or rate > 0.0):
        hop = 3.0 * (0.5 * accel + sqrt(0.25 * accel * accel - 2.0 / 3.0 * rate * jerk)) / -jerk
        reach = min(1.5 * hop, end)
        if snap * 1.5 * hop <= -0.5 * jerk and taylor_holds(cam, lane, i, reach):
            return _series(cam, i, theta, 0.0, rate, t, hop, reach, end, work)
    if rate <= 0.0 and jerk <= 0.0 and accel <= 0.0:
        return STUCK, theta, 0.0, 0.0
    if rate <= 0.0 and jerk > 0.0:
        s = min(end, cam.rows[i * ROW + RADIUS], 2.0 * jerk / snap if snap > 0.0 else end)
        if (lane.W + 2.0 * lane.Z) * s > TAYLOR_PHASE:
            s = TAYLOR_PHASE / (lane.W + 2.0 * lane.Z)
        work[EVALUATIONS] += 1
        gap, rate = series_gap(0.0, 0.0, t, s)
        return CLEAR, cam.rows[i * ROW + END] if s == end else theta + s, gap, rate
    return _search(
        cam, lane, turns, i, theta, 0.0, rate, q, w, force, q2, q3, c2, energy, end, work
    )


@kernel
def _accumulation(cam, lane, i, theta, u, q2, q3, c2, accel, energy, end):
    """Phase until chatter accumulates; -1 where the map is too inexact or passes a corner."""
    jerk_bound = energy + cam.rows[i * ROW + JERK_MAX]
    if 2.0 * u * jerk_bound > 0.25 * (1.0 - lane.r) * accel * accel:
        return -1.0
    snap_bound = (2.0 * lane.Z + lane.W) * energy + cam.rows[i * ROW + SNAP_MAX]
    jerk = q3 - third(cam, i, theta)
    tau, error = chatter_map(lane, u, accel, jerk, jerk_bound, snap_bound)
    if error > lane.tolerance or tau + error >= end:
        return -1.0
    return tau


@kernel
def _hop(cam, lane, i, theta, gap, rate, q, w, force, q2, q3, c2, hop, end, work):
    """A flight that is concave up to its landing: gap'' <= accel/2 < 0 over 1.5 predicted hops.

    Then gap(1.5 hop) < 0 and the root is the only one. Short hops use the gap's own Taylor series,
    so that nothing cancels however small the hop is.
    """
    reach = min(1.5 * hop, end)
    if not taylor_holds(cam, lane, i, reach):
        if reach == end:
            return _to_end(cam, lane, i, theta, gap, rate, q, w, force, hop, end, work)
        return _land(cam, lane, i, theta, q, w, force, 0.0, reach, hop, work)
    t = taylor(cam, lane, i, theta, q2, q3, c2)
    return _series(cam, i, theta, gap, rate, t, hop, reach, end, work)


@kernel
def _series(cam, i, theta, gap, rate, t, hop, reach, end, work):
    """Landing of a flight given by its Taylor series, known to be the only one within `reach`."""
    if reach == end:
        work[EVALUATIONS] += 1
        g, u = series_gap(gap, rate, t, end)
        if g > 0.0:
            return CLEAR, cam.rows[i * ROW + END], g, u
    low, high = 0.0, reach
    s = hop if hop < reach else 0.5 * reach
    for _ in range(MOST_REFINEMENTS):
        g, u = series_gap(gap, rate, t, s)
        work[EVALUATIONS] += 1
        if g > 0.0:
            low = s
        else:
            high = s
        step = -g / u if u < 0.0 else reach
        after = s + step
        if abs(step) <= MEANING * s:
            break
        if not low < after < high:
            after = 0.5 * (low + high)
            if after in (low, high):
                break
        s = after
    g, u = series_gap(gap, rate, t, s)
    if u > 0.0:
        u = 0.0
    return LANDED, min(theta + s, cam.rows[i * ROW + END]), 0.0, u


@kernel
def _to_end(cam, lane, i, theta, gap, rate, q, w, force, hop, end, work):
    """A concave flight whose predicted landing is near the stretch's end: look there first."""
    g, u, _ = _gap_at(cam, lane, i, theta, q, w, force, end, work)
    if g > 0.0:
        return CLEAR, cam.rows[i * ROW + END], g, u
    return _land(cam, lane, i, theta, q, w, force, 0.0, end, hop, work)


@kernel
def _gap_at(cam, lane, i, theta, q, w, force, s, work):
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
def _land(cam, lane, i, theta, q, w, force, low, high, guess, work):
    """Root of the gap between low (gap >= 0) and high (gap <= 0) where it is the only one.

    Halley's iteration kept inside the bracket. A step below CONVERGED u/accel leaves an error of
    its cube, less than one rounding, so the last evaluation is spared.
    """
    s = guess if low < guess < high else 0.5 * (low + high)
    u = 0.0
    for _ in range(MOST_REFINEMENTS):
        g, u, a = _gap_at(cam, lane, i, theta, q, w, force, s, work)
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
def _search(cam, lane, turns, i, theta, gap, rate, q, w, force, q2, q3, c2, energy, end, work):
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
            g1, u1, a1 = _gap_at(cam, lane, i, theta, q, w, force, s, work)
            y1 = a1 + lift_at(cam, i, min(theta + s, cam.rows[i * ROW + END]))[2]
        slack = curvature * s * s
        low = min(q2, y1) - slack - min(cam.rows[i * ROW + ACCEL_MAX], c2 + drift * s)
        high = max(q2, y1) + slack - max(cam.rows[i * ROW + ACCEL_MIN], c2 - drift * s)
        stop = cam.rows[i * ROW + END] if s == end else theta + s
        if high <= 0.0:
            if g1 > 0.0:
                return CLEAR, stop, g1, u1
            return _land(
                cam,
                lane,
                i,
                theta,
                q,
                w,
                force,
                0.0,
                s,
                _guess(gap, rate, q2 - c2, s, g1, u1),
                work,
            )
        if low >= 0.0:
            if rate >= 0.0 or (gap > 0.0 and u1 <= 0.0 and g1 > 0.0):
                return CLEAR, stop, max(g1, 0.0), u1
            if g1 <= 0.0:
                return _land(
                    cam,
                    lane,
                    i,
                    theta,
                    q,
                    w,
                    force,
                    0.0,
                    s,
                    _guess(gap, rate, q2 - c2, s, g1, u1),
                    work,
                )
            if u1 <= 0.0:
                return CLEAR, stop, g1, u1
            meet = (g1 - gap - u1 * s) / (rate - u1)
            if gap + rate * meet > 0.0:
                return CLEAR, stop, g1, u1
            return _dip(cam, lane, i, theta, gap, rate, q, w, force, s, stop, g1, u1, work)
        if g1 > 0.0 and gap >= 0.0 and gap + rate * s + 0.5 * low * s * s > 0.0:
            return CLEAR, stop, g1, u1
        if min(gap, g1) > 0.125 * high * s * s:
            return CLEAR, stop, g1, u1
        s *= 0.5
        if theta + s == theta:
            break
    return LOST, theta, gap, rate


@kernel
def _guess(gap, rate, accel, s, g1, u1):
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
def _dip(cam, lane, i, theta, gap, rate, q, w, force, end, stop, g_end, u_end, work):
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
        g, u, _ = _gap_at(cam, lane, i, theta, q, w, force, s, work)
    return LANDED, theta + s, 0.0, u


@kernel
def leap(cam, lane, turns, i, gap, rate, work):
    """Skip whole stretches while the follower is above the cam's top: (stretches, gap, gap_rate).

    From the start of stretch i, at most to the strobe. Where q lies above the top at both ends and
    q'' < 0 between, q is concave and stays above. y = q'' has no two zeros closer than half a
    period of y'' + 2 Z y' + W^2 y = 0, so within that y < 0 at both ends is enough.
    """
    q = cam.rows[i * ROW + START0] + gap
    if not q > cam.top:
        return 0, gap, rate
    w = cam.rows[i * ROW + START1] + rate
    force = lane.G + lane.W2 * q
    if -force - 2.0 * lane.Z * w >= 0.0:
        return 0, gap, rate
    n = cam.stretches
    o = 3 * n * i
    most = (cam.strobe - i - 1) % n + 1
    skipped = 0
    x = q
    while skipped < most:
        after = q + (w * turns[o] - force * turns[o + 2])
        if not after > cam.top:
            break
        x = after
        o += 3
        skipped += 1
    if skipped < 2:
        return 0, gap, rate
    v = w * turns[o - 2] - force * turns[o - 3]
    j = i + skipped
    length = cam.rows[(j - 1) * ROW + END] if j <= n else TURN + cam.rows[(j - n - 1) * ROW + END]
    length -= cam.rows[i * ROW + START]
    if -lane.D * length * length > HALF_PERIOD or -lane.G - lane.W2 * x - 2.0 * lane.Z * v >= 0.0:
        return 0, gap, rate
    work[CROSSINGS] += 1
    if j >= n:
        j -= n
    return skipped, x - cam.rows[j * ROW + START0], v - cam.rows[j * ROW + START1]
