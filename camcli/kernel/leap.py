"""Leap over the quiet part of a high flight."""

from camcli.kernel.cam_table import END, ROW, START, START0, START1, TURN
from camcli.kernel.contact_search import CROSSINGS
from camcli.kernel.marks import inlined

HALF_PERIOD = 9.8  # just below pi squared


@inlined
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
