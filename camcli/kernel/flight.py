"""The flight after a contact or in the air, up to its landing or the end of a stretch.

The cheap cases are told apart here: resting, accumulating, short hops and lift-off, each with the
inequality that makes the landing the only one; everything else is left to `search`.
"""

from math import sqrt

from camcli.kernel.cam_table import END, JERK_MAX, RADIUS, ROW, SNAP_MAX, third
from camcli.kernel.chatter import (
    chatter_map,
    series_gap,
    taylor,
    taylor_holds,
)
from camcli.kernel.contact_search import (
    ACCUMULATED,
    CLEAR,
    EVALUATIONS,
    LANDED,
    MEANING,
    MOST_REFINEMENTS,
    STUCK,
    flight_at,
    gap_at,
    land,
    search,
)
from camcli.kernel.gap_series import LONGEST_PHASE, NEAR, gap_near
from camcli.kernel.marks import inlined, outlined

FREE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins: gap > 0, after an impact, from sticking


@inlined
def fly(cam, lane, turns, i, theta, gap, rate, begin, work):
    """Advance a flight within stretch i from theta: (code, theta, gap, rate).

    gap >= 0 and rate = d gap/dtheta at theta; `begin` says how the flight begins; `turns` is the
    table of `entry_points.prepare`. Codes: CLEAR (moved on, at most to the stretch's end), LANDED
    (contact; rate <= 0 is the relative velocity), ACCUMULATED (chatter ends at theta), STUCK (rests
    on the cam), LOST (the step shrank to nothing: closer to grazing than doubles can tell).
    """
    if gap <= 0.0 and begin == FREE:
        if rate < 0.0:
            return LANDED, theta, 0.0, rate
        begin = BOUNCED
    f = flight_at(cam, lane, i, theta, gap, rate)
    accel = f.q2 - f.c2
    bound = f.energy + cam.rows[i * ROW + JERK_MAX]
    radius = cam.rows[i * ROW + RADIUS]
    if begin == BOUNCED and accel >= 0.0 and 6.0 * rate > bound * radius * radius:
        # gap >= rate s - bound s^3/6 > 0 as far as a series reaches: no short hop to look for
        return search(cam, lane, turns, i, f, work)
    if (begin != FREE and accel >= 0.0) or begin == RELEASED:
        return _leave(cam, lane, turns, i, f, work)
    if begin == BOUNCED and rate <= 0.0:
        return STUCK, theta, 0.0, 0.0
    if accel < 0.0:
        if begin == BOUNCED and 0.0 < lane.r < 1.0:
            tau = _accumulation(cam, lane, i, f, accel, bound)
            if tau >= 0.0:
                return ACCUMULATED, theta + tau, 0.0, 0.0
        root = rate if gap == 0.0 else sqrt(rate * rate - 2.0 * accel * gap)
        hop = (rate + root) / -accel if rate >= 0.0 else 2.0 * gap / (root - rate)
        if bound * (1.5 * hop) <= -0.5 * accel:
            return _hop(cam, lane, i, f, hop, work)
    return search(cam, lane, turns, i, f, work)


@outlined
def _leave(cam, lane, turns, i, f, work):
    """Leave the cam with rate >= 0 and gap_accel >= 0 (or released by a zero of the force).

    With jerk < 0 and the fourth derivative below K the gap rises once and falls once while
    K s <= |jerk|/2, so a landing predicted by the cubic within that range is the only one. From
    rest with jerk > 0, gap = accel s^2/2 + jerk s^3/6 + ... stays positive for s <= 2 jerk/K.
    """
    accel = max(f.q2 - f.c2, 0.0)
    _t2, t3, t4, t5, t6 = taylor(cam, lane, i, f.theta, f.q2, f.q3, f.c2)
    t = (0.5 * accel, t3, t4, t5, t6)
    jerk = 6.0 * t3
    snap = (2.0 * lane.Z + lane.W) * f.energy + cam.rows[i * ROW + SNAP_MAX]
    if jerk < 0.0 and (accel > 0.0 or f.rate > 0.0):
        hop = 3.0 * (0.5 * accel + sqrt(0.25 * accel * accel - 2.0 / 3.0 * f.rate * jerk)) / -jerk
        reach = min(1.5 * hop, f.end)
        if snap * 1.5 * hop <= -0.5 * jerk and taylor_holds(cam, lane, i, reach):
            return _series(cam, i, f, t, hop, reach, work)
    if f.rate <= 0.0 and jerk <= 0.0 and accel <= 0.0:
        return STUCK, f.theta, 0.0, 0.0
    if f.rate <= 0.0 and jerk > 0.0:
        s = min(f.end, NEAR, 2.0 * jerk / snap if snap > 0.0 else f.end)
        if (lane.W + 2.0 * lane.Z) * s > LONGEST_PHASE:
            s = LONGEST_PHASE / (lane.W + 2.0 * lane.Z)
        work[EVALUATIONS] += 1
        gap, rate, _ = gap_near(cam, lane, i, f, s)
        return CLEAR, cam.rows[i * ROW + END] if s == f.end else f.theta + s, max(gap, 0.0), rate
    return search(cam, lane, turns, i, f, work)


@inlined
def _accumulation(cam, lane, i, f, accel, jerk_bound):
    """Phase until chatter accumulates; -1 where the map is too inexact or passes a corner."""
    if 2.0 * f.rate * jerk_bound > 0.25 * (1.0 - lane.r) * accel * accel:
        return -1.0
    snap_bound = (2.0 * lane.Z + lane.W) * f.energy + cam.rows[i * ROW + SNAP_MAX]
    jerk = f.q3 - third(cam, i, f.theta)
    tau, error = chatter_map(lane, f.rate, accel, jerk, jerk_bound, snap_bound)
    if error > lane.tolerance or tau + error >= f.end:
        return -1.0
    return tau


@inlined
def _hop(cam, lane, i, f, hop, work):
    """A flight that is concave up to its landing: gap'' <= accel/2 < 0 over 1.5 predicted hops.

    Then gap(1.5 hop) < 0 and the root is the only one. Short hops use the gap's own Taylor series,
    so that nothing cancels however small the hop is.
    """
    reach = min(1.5 * hop, f.end)
    if taylor_holds(cam, lane, i, reach):
        t = taylor(cam, lane, i, f.theta, f.q2, f.q3, f.c2)
        return _series(cam, i, f, t, hop, reach, work)
    if reach == f.end:
        g, u, _ = gap_at(cam, lane, i, f, reach, work)
        if g > 0.0:
            return CLEAR, cam.rows[i * ROW + END], g, u
    return land(cam, lane, i, f, reach, hop, work)


@inlined
def _series(cam, i, f, t, hop, reach, work):
    """Landing of a flight given by its Taylor series, known to be the only one within `reach`."""
    if reach == f.end:
        work[EVALUATIONS] += 1
        g, u = series_gap(f.gap, f.rate, t, f.end)
        if g > 0.0:
            return CLEAR, cam.rows[i * ROW + END], g, u
    low, high = 0.0, reach
    s = hop if hop < reach else 0.5 * reach
    for _ in range(MOST_REFINEMENTS):
        g, u = series_gap(f.gap, f.rate, t, s)
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
    g, u = series_gap(f.gap, f.rate, t, s)
    return LANDED, min(f.theta + s, cam.rows[i * ROW + END]), 0.0, u
