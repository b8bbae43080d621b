"""Is a root of the shooting equations a motion? The same contact search as everywhere tells."""

from camcli.kernel.cam_table import END, KICK, ROW, START, TURN
from camcli.kernel.contact_search import LANDED, LOST, STUCK
from camcli.kernel.flight import BOUNCED, FREE, fly
from camcli.kernel.flow import flow, lane_of
from camcli.kernel.marks import inlined

ADMISSIBLE, EARLY, LATE, PULLS, DOUBTFUL = range(5)  # verdicts
NO_CHATTER_MAP = -1.0  # a tolerance below every error
SAME = 1e-6  # rad, a contact this close to the root's own impact is that impact
IMPACT_AT, PHASE = 0, 1  # entries of `found`
MOST_STEPS = 100_000


@inlined
def across_only(cam, lane, turns):
    """Fill the part of `turns` that crossing one stretch needs (see `entry_points.prepare`)."""
    n = cam.stretches
    for i in range(n):
        length = cam.rows[i * ROW + END] - cam.rows[i * ROW + START]
        o = 3 * n * i
        turns[o], turns[o + 1], turns[o + 2] = flow(lane, length)


@inlined
def next_contact(cam, lane, turns, i, theta, v, most, work):
    """(code, theta, turn) of the first contact after an impact at theta with outgoing rate v.

    `turn` counts strobe-independent turns (passages of theta = 0); at most `most` of them.
    """
    gap, rate, mode, turn = 0.0, v, BOUNCED, 0
    for _ in range(MOST_STEPS):
        code, theta, gap, rate = fly(cam, lane, turns, i, theta, gap, rate, mode, work)
        mode = FREE
        if code in (STUCK, LOST):
            return code, theta, turn
        if theta < cam.rows[i * ROW + END]:
            if code == LANDED:
                return code, theta, turn
            continue
        i += 1
        if i == cam.stretches:
            i = 0
            turn += 1
            if turn > most:
                return code, theta, turn
        theta = cam.rows[i * ROW + START]
        rate -= cam.rows[i * ROW + KICK]
    return LOST, theta, turn


@inlined
def certify(cam, machine, n, turns, whole, x, rates, table, found, work):
    """Verdict on the root x of the shooting equations; `found`: impact and phase it rests on.

    EARLY: a contact comes before the next impact, the root penetrates the cam. LATE: the flight
    misses the next impact. PULLS: an impact would have to pull. DOUBTFUL: nearer to grazing than
    doubles can tell.
    """
    lane = lane_of(machine, NO_CHATTER_MAP, 0)
    across_only(cam, lane, table)
    for k in range(n):
        found[IMPACT_AT], found[PHASE] = k, x[2 * k]
        if rates[k] >= 0.0:
            return PULLS
    for k in range(n):
        j = (k + 1) % n
        later = whole[2 * j + 1] - whole[2 * k + 1] + (turns if k == n - 1 else 0)
        code, theta, turn = next_contact(
            cam, lane, table, whole[2 * k], x[2 * k], x[2 * k + 1], later + 1, work
        )
        found[IMPACT_AT], found[PHASE] = k, theta
        if code == STUCK:
            return EARLY
        if code == LOST:
            return DOUBTFUL
        off = (theta - x[2 * j]) + TURN * (turn - later)
        if off < -SAME:
            return EARLY
        if off > SAME:
            return LATE
    return ADMISSIBLE
