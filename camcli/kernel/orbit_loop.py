"""One orbit: find the next event, move there, reset; count and log what was asked for."""

from enum import IntEnum
from typing import Any, NamedTuple

from camcli.errors import Status
from camcli.kernel.cam_table import END, KICK, ROW, START, START0, START1, lift_at
from camcli.kernel.contact_search import ACCUMULATED, LANDED, LOST, STEPS, STUCK
from camcli.kernel.flight import BOUNCED, FREE, RELEASED, fly
from camcli.kernel.leap import leap
from camcli.kernel.marks import inlined, outlined
from camcli.kernel.sticking import SKIP, slide


class EventKind(IntEnum):
    """What a row of the log is."""

    IMPACT = 1
    CHATTER = 2  # a complete chatter accumulates
    DETACHMENT = 3

    @property
    def text(self) -> str:
        """The kind as it stands in a CSV."""
        return self.name.lower()


# numba compiles ints, not members of an enum.
IMPACT, CHATTER, DETACHMENT = (int(kind) for kind in EventKind)
OK, LOG_FULL, IMPACT_BUDGET, NO_RETURN, UNRESOLVED, PAUSED = (int(status) for status in Status)

RESTING = 3  # further `mode` beside FREE, BOUNCED, RELEASED
MOST_STEPS_BETWEEN = 100_000  # without an impact or a corner

THETA, GAP, RATE = 0, 1, 2  # entries of `state`
MODE, STRETCH, PERIOD, IMPACTS, CHATTERED, LOGGED, IDLE, TOTAL, LEAVES = range(9)  # `count`


class Log(NamedTuple):
    """Events, `capacity` rows; two flat tables."""

    whole: Any  # (rows * 2,) int: event kind, period
    real: Any  # (rows * 3,): theta (rad), q (m), u (m/rad) before the event
    capacity: int


class Strobe(NamedTuple):
    """State at the start of each recorded period, and what happened during it."""

    state: Any  # (rows * 2,): q (m), dq/dtheta (m/rad)
    events: Any  # (rows * 2,) int: impacts; 1 where a complete chatter ended in it
    rows: int


class Plan(NamedTuple):
    """How far to go: periods are numbered by strobes, negative ones are the transient."""

    log_from: int  # first period whose events are logged
    stop: int  # return when this period begins
    steps: int  # return PAUSED after so many steps


@inlined
def run(cam, lane, turns, state, count, plan, log, strobe, work):
    """Advance one orbit to the start of period plan.stop; returns a status (camcli.errors).

    `state` and `count` hold everything, so the call can be repeated after PAUSED or LOG_FULL and
    gives the same bits as one long call.
    """
    theta, gap, rate = state[THETA], state[GAP], state[RATE]
    mode, i = count[MODE], count[STRETCH]
    steps = 0
    status = OK
    while True:
        if steps >= plan.steps:
            status = PAUSED
        elif count[LOGGED] >= log.capacity > 0:
            status = LOG_FULL
        elif count[IDLE] > MOST_STEPS_BETWEEN:
            status = UNRESOLVED
        elif count[IMPACTS] >= lane.impact_budget:
            status = IMPACT_BUDGET
        if status != OK or count[PERIOD] >= plan.stop:
            break
        steps += 1
        count[IDLE] += 1
        skipped = 0
        if mode == FREE and theta == cam.rows[i * ROW + START]:
            skipped, gap, rate = leap(cam, lane, turns, i, gap, rate, work)
        if skipped > 0:
            i += skipped
            if i >= cam.stretches:
                i -= cam.stretches
            theta = cam.rows[i * ROW + START]
        else:
            if mode == RESTING:
                released, theta = slide(cam, lane, i, theta)
                if released:
                    detach(cam, count, plan, log, i, theta)
                    mode, gap, rate = RELEASED, 0.0, 0.0
                    continue
            else:
                code, theta, gap, rate = fly(cam, lane, turns, i, theta, gap, rate, mode, work)
                if code == LOST:
                    status = UNRESOLVED
                    break
                mode, theta, rate = settle(cam, lane, count, plan, log, i, theta, rate, mode, code)
            if theta < cam.rows[i * ROW + END]:
                continue
            i, theta, rate, mode = cross(cam, count, plan, log, i, gap, rate, mode)
        if i == cam.strobe:
            begin_period(cam, count, plan, strobe, i, gap, rate)
            if mode == FREE and gone(cam, lane, i, gap, rate):
                status = NO_RETURN
                break
    state[THETA], state[GAP], state[RATE] = theta, gap, rate
    count[MODE], count[STRETCH] = mode, i
    work[STEPS] += steps
    return status


@inlined
def settle(cam, lane, count, plan, log, i, theta, rate, mode, code):
    """What follows the end of `fly`: (mode, theta, rate) after the reset map u+ = -r u-.

    A landing at the very end of a stretch is left to the next one, whose right-sided values rule.
    """
    if code == LANDED and theta < cam.rows[i * ROW + END]:
        if rate < 0.0:
            count[IMPACTS] += 1
            count[TOTAL] += 1
            count[IDLE] = 0
            write(cam, count, plan, log, IMPACT, i, theta, rate)
            rate = -lane.r * rate
        return BOUNCED, theta, rate
    if code == ACCUMULATED:
        count[CHATTERED] = 1
        write(cam, count, plan, log, CHATTER, i, theta, 0.0)
        return RESTING, theta, rate
    if code == STUCK:
        if mode == RELEASED:
            theta = min(theta + SKIP, cam.rows[i * ROW + END])
        return RESTING, theta, rate
    return FREE, theta, rate


@inlined
def write(cam, count, plan, log, kind, i, theta, u):
    """Log one event if a log was asked for and this period is in it."""
    n = count[LOGGED]
    if n < log.capacity and count[PERIOD] >= plan.log_from:
        log.whole[2 * n] = kind
        log.whole[2 * n + 1] = count[PERIOD]
        log.real[3 * n] = theta
        log.real[3 * n + 1] = lift_at(cam, i, theta)[0]
        log.real[3 * n + 2] = u
        count[LOGGED] = n + 1


@inlined
def detach(cam, count, plan, log, i, theta):
    """Count (outside the transient) and log a detachment."""
    if count[PERIOD] >= 0:
        count[LEAVES] += 1
    write(cam, count, plan, log, DETACHMENT, i, theta, 0.0)


@inlined
def cross(cam, count, plan, log, i, gap, rate, mode):
    """Enter the next stretch: (i, theta, rate, mode); a jump of c_theta is a blow or a launch."""
    count[IDLE] = 0
    i += 1
    if i == cam.stretches:
        i = 0
    theta = cam.rows[i * ROW + START]
    kick = cam.rows[i * ROW + KICK]
    if kick != 0.0:
        rate -= kick
        if mode == RESTING and rate != 0.0:
            if rate > 0.0:
                detach(cam, count, plan, log, i, theta)
            mode = FREE
        elif mode != FREE and rate < 0.0:
            mode = FREE
    return i, theta, rate, mode


@inlined
def begin_period(cam, count, plan, strobe, i, gap, rate):
    """Count the period that ends in this strobe, and record the state that begins the next."""
    period = count[PERIOD]
    if 0 <= period < strobe.rows:
        strobe.events[2 * period] = count[IMPACTS]
        strobe.events[2 * period + 1] = count[CHATTERED]
    period += 1
    if 0 <= period < strobe.rows:
        strobe.state[2 * period] = cam.rows[i * ROW + START0] + gap
        strobe.state[2 * period + 1] = cam.rows[i * ROW + START1] + rate
    count[PERIOD] = period
    count[IMPACTS] = 0
    count[CHATTERED] = 0


@outlined
def gone(cam, lane, i, gap, rate):
    """True where nothing brings the follower back: no spring, no weight, above for good."""
    if lane.W2 > 0.0 or lane.G > 0.0:
        return False
    q = cam.rows[i * ROW + START0] + gap
    w = cam.rows[i * ROW + START1] + rate
    if q <= cam.top:
        return False
    if lane.Z == 0.0:
        return w >= 0.0
    return q + 0.5 * w / lane.Z > cam.top
