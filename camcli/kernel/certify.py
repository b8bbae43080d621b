"""Is a root of the shooting equations a motion? The same contact search as everywhere tells."""

from enum import IntEnum

from camcli.kernel.cam_table import TURN
from camcli.kernel.contact_search import EXACTLY, LANDED, LOST, NEARLY, STUCK, flight_at, gap_at
from camcli.kernel.flight import BOUNCED, FREE, fly
from camcli.kernel.flow import constants_of, flow
from camcli.kernel.marks import entry, inlined


class Verdict(IntEnum):
    """On a root of the shooting equations."""

    ADMISSIBLE = 0
    EARLY = 1  # a contact comes before the next impact: the root penetrates the cam
    LATE = 2  # the flight misses the next impact
    PULLS = 3  # an impact would have to pull
    DOUBTFUL = 4  # nearer to grazing than doubles can tell


ADMISSIBLE, EARLY, LATE, PULLS, DOUBTFUL = (int(verdict) for verdict in Verdict)
NO_CHATTER_MAP = -1.0  # a tolerance below every error
SAME = 1e-6  # rad, a contact this close to the root's own impact is that impact
IMPACT_AT, PHASE = 0, 1  # entries of `found`
MOST_STEPS = 100_000


@inlined
def fill_crossings(cam, const, flows):
    """Fill the rows of the table of `flow.fill_flows` that crossing one stretch needs.

    The flow over the whole of stretch i alone is row n i, n the number of stretches.
    """
    n = len(cam.stretches)
    for i in range(n):
        row = flows[n * i]
        row.b, row.b1, row.p = flow(const, cam.stretches[i].end - cam.stretches[i].start)


@inlined
def next_contact(cam, const, flows, i, theta, v, most, work):
    """(code, theta, turn) of the first contact after an impact at theta with outgoing rate v.

    i: the stretch of theta. turn: how often theta = 0 was passed, at most `most` times. Codes are
    those of `contact_search`: LANDED with the contact's phase; STUCK where the follower rests; LOST
    where doubles cannot tell; CLEAR, or whatever the last flight came to, after `most` turns.
    """
    gap = 0.0
    rate = v
    mode = BOUNCED
    turn = 0
    for _ in range(MOST_STEPS):
        f = flight_at(cam, const, i, theta, gap, rate)
        code, theta, gap, rate = fly(cam, const, flows, i, f, mode, work)
        mode = FREE
        if code in (STUCK, LOST):
            return code, theta, turn
        if code == NEARLY:  # one step of Newton's method more
            gap, rate, _ = gap_at(cam, const, i, f, theta - f.theta, work)
            theta = min(theta - gap / rate, cam.stretches[i].end)
            code = LANDED
        if code in (LANDED, EXACTLY):
            code = LANDED
            gap = 0.0
        if theta < cam.stretches[i].end:
            if code == LANDED:
                return code, theta, turn
            continue
        i += 1  # also of a landing at the very end, which the next stretch decides
        if i == len(cam.stretches):
            i = 0
            turn += 1
            if turn > most:
                return code, theta, turn
        theta = cam.stretches[i].start
        rate -= cam.stretches[i].slope_jump
    return LOST, theta, turn


@entry
def certify_orbit(cam, machine, n, turns, whole, x, rates, flows, found, works):
    """The `Verdict` on a root x of the shooting equations: whether it is a motion.

    machine, n, turns, whole, x, rates: as in `shooting.correct_orbit`, of n impacts in `turns`
    turns. flows: room for the table of `flow.fill_flows`. found: becomes (the impact on which the
    verdict rests, from 0, and a phase, rad). works: one `Tally`.
    """
    const = constants_of(machine, NO_CHATTER_MAP, 0)
    work = works[0]
    fill_crossings(cam, const, flows)
    for k in range(n):
        found[IMPACT_AT] = k
        found[PHASE] = x[2 * k]
        if rates[k] >= 0.0:
            return PULLS
    for k in range(n):
        j = (k + 1) % n  # the next impact
        stretch = whole[2 * k]
        theta_k = x[2 * k]
        rate_k = x[2 * k + 1]
        turns_between = whole[2 * j + 1] - whole[2 * k + 1] + (turns if k == n - 1 else 0)
        code, theta, turn = next_contact(
            cam, const, flows, stretch, theta_k, rate_k, turns_between + 1, work
        )
        found[IMPACT_AT] = k
        found[PHASE] = theta
        if code == STUCK:
            return EARLY
        if code == LOST:
            return DOUBTFUL
        off = (theta - x[2 * j]) + TURN * (turn - turns_between)
        if off < -SAME:
            return EARLY
        if off > SAME:
            return LATE
    return ADMISSIBLE
