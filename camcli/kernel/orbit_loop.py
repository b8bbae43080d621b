"""One orbit: find the next event, move there, reset; count and log what was asked for."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, NamedTuple

from camcli.errors import Status
from camcli.kernel.arithmetic import product_rest, sum_rest
from camcli.kernel.cam_table import derivative, lift_at, lift_parts, restitution_at
from camcli.kernel.contact_search import (
    ACCUMULATED,
    CONVERGED,
    EXACTLY,
    LANDED,
    LOST,
    MOST_REFINEMENTS,
    NEARLY,
    ROUGH,
    STUCK,
    flight_over,
    is_near,
)
from camcli.kernel.flight import BOUNCED, FREE, RELEASED, fly, leap
from camcli.kernel.flow import displacement
from camcli.kernel.marks import inlined, outlined
from camcli.kernel.sticking import SKIP, find_detachment


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
OK, LOG_FULL, IMPACT_BUDGET, NO_RETURN, UNRESOLVED, PAUSED, *_ = map(int, Status)

RESTING = 3  # a mode beside FREE, BOUNCED, RELEASED
# 2 pi in two parts, the first of 40 bits: its products with small integers are exact.
TURN_HIGH, TURN_LOW = 6.283185307176609, 2.9774189921946493e-12
SMALL = 1e-8  # rad, and in units of u/accel: a step for which Newton's is exact
MOST_STEPS_BETWEEN = 100_000  # without an impact or a corner
NEVER = 1 << 62  # a period that no orbit comes to
NOWHERE = -1.0  # m: a gap that no state has
LEAST_WAIT = 16  # turns that a state is kept, at least: a cycle of so many is seen
WAIT = 8  # it is kept for one part in so many of the turns so far


@dataclass(slots=True)
class State:
    """All of an orbit between two calls; m, rad."""

    theta: float = 0.0
    gap: float = 0.0
    gap_rate: float = 0.0
    mode: int = FREE
    stretch: int = 0
    period: int = 0  # numbered by strobes, negative in the transient
    impacts: int = 0  # of this period
    chattered: int = 0  # 1 where a complete chatter ended in this period
    logged: int = 0  # rows of the log in use
    idle: int = 0  # steps since the last impact or corner
    flown: int = 0  # steps of the present flight
    wraps: int = 0  # passages of theta = 0 in it
    from_stretch: int = 0  # where it began, and from_theta to from_rate
    from_theta: float = 0.0
    from_gap: float = 0.0
    from_rate: float = 0.0
    from_rest: float = 0.0  # rad, what from_theta leaves out
    from_known: int = 0  # 1 where level to slope_rest are of from_theta + from_rest
    rest: float = 0.0  # rad, what theta leaves out of a contact's phase
    known: int = 0  # 1 where level to slope_rest are of theta + rest
    level: float = 0.0  # level + gain is the cam's lift, m
    gain: float = 0.0
    slope: float = 0.0  # c_theta
    slope_rest: float = 0.0  # what it leaves out, and of the rate after an impact
    total_impacts: int = 0
    detachments: int = 0  # outside the transient


@dataclass(slots=True)
class Earlier:
    """The state at an earlier strobe, by which an orbit is seen to repeat itself bit for bit.

    An orbit is a function of its state alone: one that comes back to a state, in all its bits, goes
    through the same turns again. Kept is the state at one strobe, and again in `keep_in`, see
    `keep`. gap to slope_rest are as in `State`; theta and stretch are always those of the strobe.
    """

    cycle: int = 0  # turns between the state kept and the same one; 0: not seen
    first: int = 0  # the first period that was looked at
    keep_in: int = -NEVER  # the period that begins with the next state to be kept
    period: int = 0  # the one that begins with the state kept
    logged: int = 0  # rows of the log until then, total_impacts and detachments
    total_impacts: int = 0
    detachments: int = 0
    gap: float = NOWHERE
    gap_rate: float = 0.0
    mode: int = 0
    idle: int = 0
    flown: int = 0
    wraps: int = 0
    from_stretch: int = 0
    from_theta: float = 0.0
    from_gap: float = 0.0
    from_rate: float = 0.0
    from_rest: float = 0.0
    from_known: int = 0
    rest: float = 0.0
    known: int = 0
    level: float = 0.0
    gain: float = 0.0
    slope: float = 0.0
    slope_rest: float = 0.0


class Log(NamedTuple):
    """Columns of events; (capacity,) each."""

    kind: Any  # int, EventKind
    period: Any  # int
    theta: Any  # rad
    q: Any  # m
    u: Any  # relative rate before the event, m/rad
    capacity: int


class Strobe(NamedTuple):
    """Columns of the recorded periods; those of an orbit are so many rows from `first` on."""

    q: Any  # m, where the period begins
    w: Any  # dq/dtheta there, m/rad
    impacts: Any  # int
    chatter: Any  # int, 1 where a complete chatter ended in it
    rows: int
    first: int = 0


class Plan(NamedTuple):
    """How far to go: periods are numbered by strobes, negative ones are the transient."""

    log_from: int  # first period whose events are logged
    stop: int  # return when this period begins
    steps: int  # return PAUSED after so many steps


@inlined
def run(cam, const, flows, state, plan, log, strobe, work, earlier):
    """Advance one orbit to the start of period plan.stop; returns a `Status`.

    `state` holds everything, so the call can be repeated after PAUSED or LOG_FULL and
    gives the same bits as one long call. Where the orbit comes back to the state that `earlier`
    holds, earlier.cycle becomes the number of turns in between, and the orbit stops there (OK).
    """
    theta, gap, rate = state.theta, state.gap, state.gap_rate
    mode, i = state.mode, state.stretch
    steps = 0
    status = OK
    while True:
        if steps >= plan.steps:
            status = PAUSED
        elif state.logged >= log.capacity > 0:
            status = LOG_FULL
        elif state.idle > MOST_STEPS_BETWEEN:
            status = UNRESOLVED
        elif state.impacts >= const.impact_budget:
            status = IMPACT_BUDGET
        if status != OK or state.period >= plan.stop:
            break
        steps += 1
        state.idle += 1
        skipped = 0
        rested = False  # True where the follower rests up to the end of the stretch
        if mode != FREE or gap == 0.0 or state.flown == 0:
            begin_flight(state, i, theta, gap, rate)
        state.flown += 1
        if mode == FREE and theta == cam.stretches[i].start:
            skipped, gap, rate = leap(cam, const, flows, i, gap, rate, work)
        if skipped > 0:
            i += skipped
            if i >= len(cam.stretches):
                i -= len(cam.stretches)
                state.wraps += 1
            theta = cam.stretches[i].start
        else:
            if mode == RESTING:
                released, theta = find_detachment(cam, const, i, theta)
                if released:
                    detach(cam, state, plan, log, i, theta)
                    mode, gap, rate = RELEASED, 0.0, 0.0
                    continue
            else:
                if mode == BOUNCED and state.from_known:
                    c, c1 = state.level + state.gain, state.slope
                    c2 = derivative(cam, 2, i, theta)
                else:
                    c, c1, c2 = lift_at(cam, i, theta)
                f = flight_over(cam, const, i, theta, gap, rate, c, c1, c2)
                code, theta, gap, rate = fly(cam, const, flows, i, f, mode, work)
                if code == LOST:
                    status = UNRESOLVED
                    break
                if code in (LANDED, NEARLY, EXACTLY):
                    theta, rate = landing(cam, const, state, i, theta, rate, gap, code, work)
                    code, gap = LANDED, 0.0
                mode, theta, rate = after_contact(
                    cam, const, state, plan, log, i, theta, rate, mode, code
                )
            if theta < cam.stretches[i].end:
                continue
            rested = mode == RESTING
            i, theta, rate, mode = enter_stretch(cam, state, i, rate, mode)
        if i == cam.strobe:
            begin_period(cam, state, strobe, i, gap, rate)
        if rested and mode == FREE and rate > 0.0 and state.period < plan.stop:
            detach(cam, state, plan, log, i, theta)
        if i == cam.strobe:
            if mode == FREE and never_returns(cam, const, i, gap, rate):
                status = NO_RETURN
                break
            if gap == earlier.gap and rate == earlier.gap_rate and is_same(state, mode, earlier):
                earlier.cycle = state.period - earlier.period
                break
            if state.period >= earlier.keep_in:
                keep(state, gap, rate, mode, earlier)
    state.theta = theta
    state.gap = gap
    state.gap_rate = rate
    state.mode = mode
    state.stretch = i
    work.steps += steps
    return status


@inlined
def begin_flight(state, i, theta, gap, rate):
    """Keep where a flight begins, for `landing`."""
    state.flown = 0
    state.wraps = 0
    state.from_stretch = i
    state.from_theta = theta
    state.from_gap = gap
    state.from_rate = rate
    state.from_rest = state.rest
    state.from_known = state.known
    state.known = 0
    state.rest = 0.0


@inlined
def landing(cam, const, state, i, theta, rate, rest, code, work):
    """(theta, rate) of a landing, by Newton's method on the whole flight, in two doubles.

    theta, rate, rest (rad, in the place of the gap) and code are what `fly` returned, with a
    rounding for every stretch that it crossed. Solved is, from the flight's start (q, w),
        q + dq - c(theta) = 0,    u = w + dw - c_theta(theta),    (dq, dw) = `displacement`,
    where a number x goes on in x_rest. Then state.known = 1, the phase is theta + state.rest, and
    level to slope_rest are the lift and slope there, with which the next flight begins: an orbit
    multiplies what a landing leaves out. Too close to a graze, where a step would say nothing, and
    beyond the stretch the phase reached is returned in one double. A short hop keeps that of `fly`,
    in relative coordinates throughout, across corners too: the difference of two lifts, each known
    to some 1e-19 of its size, has fewer digits than a low hop has.
    """
    turns = TURN_HIGH * state.wraps
    hop = turns + (theta - state.from_theta)
    if code == EXACTLY or is_near(const, hop):
        state.rest = state.from_rest + rest
        return theta, rate
    if not state.from_known:
        level, gain, slope, bend, c2 = lift_parts(cam, state.from_stretch, state.from_theta)
        state.level = level
        state.gain = gain + (slope + bend) * state.from_rest
        state.slope = slope + bend
        state.slope_rest = sum_rest(slope, bend, state.slope) + c2 * state.from_rest
    gain0 = state.gain + state.from_gap
    q, w = state.level + gain0, state.slope + state.from_rate
    q_rest = sum_rest(state.level, gain0, q)
    w_rest = sum_rest(state.slope, state.from_rate, w) + state.slope_rest
    for _ in range(MOST_REFINEMENTS):
        work.evaluations += 1
        passed = theta - state.from_theta
        s = turns + passed
        s_rest = sum_rest(turns, passed, s) + sum_rest(theta, -state.from_theta, passed)
        s_rest += TURN_LOW * state.wraps - state.from_rest
        dq, dq_rest, dw, dw_rest = displacement(const, q, q_rest, w, w_rest, s, s_rest)
        level, gain, slope, bend, c2 = lift_parts(cam, i, theta)
        part = state.level - level
        gap = (part + dq) + (sum_rest(state.level, -level, part) + (gain0 - gain) + dq_rest)
        c1 = slope + bend
        c1_rest = sum_rest(slope, bend, c1)
        part = w - c1
        u = part + dw
        u_rest = sum_rest(part, dw, u) + sum_rest(w, -c1, part) + (w_rest - c1_rest + dw_rest)
        accel = -const.G - const.W2 * (q + dq) - 2.0 * const.Z * (w + dw) - c2
        if not (u < 0.0 and abs(gap * accel) <= ROUGH * u * u):
            return theta, rate
        step, jerk, c3 = -gap / u, 0.0, 0.0
        if abs(step) > SMALL or abs(step * accel) > SMALL * -u:
            step -= 0.5 * step * (step * (accel / u))
            c3 = derivative(cam, 3, i, theta)
            jerk = -2.0 * const.Z * (accel + c2) - const.W2 * (w + dw) - c3
        u_rest += step * (accel + 0.5 * step * jerk)
        rate = min(u + u_rest, 0.0)
        after = theta + step
        if not cam.stretches[i].start <= after <= cam.stretches[i].end:
            return min(max(after, cam.stretches[i].start), cam.stretches[i].end), rate
        if abs(step) <= CONVERGED:
            break
        theta = after
    state.level = level
    state.gain = gain + step * (c1 + 0.5 * step * c2)
    part = step * (c2 + 0.5 * step * c3)
    state.slope = c1 + part
    state.slope_rest = sum_rest(c1, part, state.slope) + c1_rest
    u_rest -= rate - u  # and what the reset leaves out
    r = restitution_at(cam, const, i)
    state.slope_rest -= product_rest(r, rate, r * rate) + r * u_rest
    state.known = 1
    state.rest = step - (after - theta)
    return after, rate


@inlined
def reset_map(r, u):
    """Newton's law of restitution in relative rates: u+ = -r u-."""
    return -r * u


@inlined
def after_contact(cam, const, state, plan, log, i, theta, rate, mode, code):
    """What follows the end of `fly`: (mode, theta, rate).

    A landing at the very end of a stretch is left to the next one, whose right-sided values rule.
    """
    if code == LANDED and theta < cam.stretches[i].end:
        if rate < 0.0:
            state.impacts += 1
            state.total_impacts += 1
            state.idle = 0
            log_event(cam, state, plan, log, IMPACT, i, theta, rate)
            rate = reset_map(restitution_at(cam, const, i), rate)
        return BOUNCED, theta, rate
    if code == ACCUMULATED:
        state.chattered = 1
        log_event(cam, state, plan, log, CHATTER, i, theta, 0.0)
        return RESTING, theta, rate
    if code == STUCK:
        if mode == RELEASED:
            theta = min(theta + SKIP, cam.stretches[i].end)
        return RESTING, theta, rate
    return FREE, theta, rate


@inlined
def log_event(cam, state, plan, log, kind, i, theta, u):
    """Log one event if a log was asked for and this period is in it."""
    n = state.logged
    if n < log.capacity and state.period >= plan.log_from:
        log.kind[n] = kind
        log.period[n] = state.period
        log.theta[n] = theta
        log.q[n] = lift_at(cam, i, theta)[0]
        log.u[n] = u
        state.logged = n + 1


@inlined
def detach(cam, state, plan, log, i, theta):
    """Count (outside the transient) and log a detachment."""
    if state.period >= 0:
        state.detachments += 1
    state.known = 0
    state.rest = cam.stretches[i].rest if theta == cam.stretches[i].start else 0.0
    log_event(cam, state, plan, log, DETACHMENT, i, theta, 0.0)


@inlined
def enter_stretch(cam, state, i, rate, mode):
    """Enter the next stretch: (i, theta, rate, mode); a jump of c_theta is a blow or a launch."""
    state.idle = 0
    state.known = 0
    i += 1
    if i == len(cam.stretches):
        i = 0
        state.wraps += 1
    theta = cam.stretches[i].start
    kick = cam.stretches[i].slope_jump
    if kick != 0.0:
        rate -= kick
        if mode == RESTING or rate < 0.0:
            mode = FREE
    return i, theta, rate, mode


@inlined
def begin_period(cam, state, strobe, i, gap, rate):
    """Count the period that ends in this strobe, and record the state that begins the next."""
    period = state.period
    if 0 <= period < strobe.rows:
        strobe.impacts[strobe.first + period] = state.impacts
        strobe.chatter[strobe.first + period] = state.chattered
    period += 1
    if 0 <= period < strobe.rows:
        strobe.q[strobe.first + period] = cam.stretches[i].start_c + gap
        strobe.w[strobe.first + period] = cam.stretches[i].start_c1 + rate
    state.period = period
    state.impacts = 0
    state.chattered = 0


@outlined
def is_same(state, mode, earlier):
    """Whether a state that has the gap and the rate of the earlier one is the same in all else."""
    return (
        mode == earlier.mode
        and state.idle == earlier.idle
        and state.flown == earlier.flown
        and state.wraps == earlier.wraps
        and state.from_stretch == earlier.from_stretch
        and state.from_theta == earlier.from_theta
        and state.from_gap == earlier.from_gap
        and state.from_rate == earlier.from_rate
        and state.from_rest == earlier.from_rest
        and state.from_known == earlier.from_known
        and state.rest == earlier.rest
        and state.known == earlier.known
        and state.level == earlier.level
        and state.gain == earlier.gain
        and state.slope == earlier.slope
        and state.slope_rest == earlier.slope_rest
    )


@outlined
def keep(state, gap, rate, mode, earlier):
    """Keep the state at the strobe at which state.period has just begun.

    The next one is kept after an eighth of the turns so far, or LEAST_WAIT where that is more: a
    cycle is seen at most so many turns after it has begun, and one more round of it (R. P. Brent,
    An improved Monte Carlo factorization algorithm, BIT 20, 1980, section 2, with other steps).
    """
    if earlier.keep_in == -NEVER:
        earlier.first = state.period
    earlier.keep_in = state.period + max(LEAST_WAIT, (state.period - earlier.first) // WAIT)
    earlier.period = state.period
    earlier.logged = state.logged
    earlier.total_impacts = state.total_impacts
    earlier.detachments = state.detachments
    earlier.gap = gap
    earlier.gap_rate = rate
    earlier.mode = mode
    earlier.idle = state.idle
    earlier.flown = state.flown
    earlier.wraps = state.wraps
    earlier.from_stretch = state.from_stretch
    earlier.from_theta = state.from_theta
    earlier.from_gap = state.from_gap
    earlier.from_rate = state.from_rate
    earlier.from_rest = state.from_rest
    earlier.from_known = state.from_known
    earlier.rest = state.rest
    earlier.known = state.known
    earlier.level = state.level
    earlier.gain = state.gain
    earlier.slope = state.slope
    earlier.slope_rest = state.slope_rest


@outlined
def never_returns(cam, const, i, gap, rate):
    """True where nothing brings the follower back: no spring, no weight, above for good."""
    if const.W2 > 0.0 or const.G > 0.0:
        return False
    q = cam.stretches[i].start_c + gap
    w = cam.stretches[i].start_c1 + rate
    if q <= cam.top:
        return False
    if const.Z == 0.0:
        return w >= 0.0
    return q + 0.5 * w / const.Z > cam.top
