"""The flight after a contact or in the air, up to its landing or the end of a stretch.

The cheap cases are told apart here: resting, accumulating, short hops and lift-off, each with the
inequality that makes the landing the only one; everything else is left to `search`.
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
from camcli.kernel.profile import END, JERK_MAX, RADIUS, ROW, SNAP_MAX, lift_at, third
from camcli.kernel.search import (
    ACCUMULATED,
    CLEAR,
    EVALUATIONS,
    LANDED,
    MEANING,
    MOST_REFINEMENTS,
    STUCK,
    land,
    search,
    to_end,
)

FREE, BOUNCED, RELEASED = 0, 1, 2  # how a flight begins: gap > 0, after an impact, from sticking


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

    radius = cam.rows[i * ROW + RADIUS]
    if begin == BOUNCED and accel >= 0.0 and 6.0 * rate > bound * radius * radius:
        # gap >= rate s - bound s^3/6 > 0 as far as a series reaches: no short hop to look for
        return search(
            cam, lane, turns, i, theta, gap, rate, q, w, force, q2, q3, c2, energy, end, work
        )
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
    return search(cam, lane, turns, i, theta, gap, rate, q, w, force, q2, q3, c2, energy, end, work)


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
    return search(cam, lane, turns, i, theta, 0.0, rate, q, w, force, q2, q3, c2, energy, end, work)


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
            return to_end(cam, lane, i, theta, gap, rate, q, w, force, hop, end, work)
        return land(cam, lane, i, theta, q, w, force, 0.0, reach, hop, work)
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
