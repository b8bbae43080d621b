"""Several orbits in one call, each to the end of its record, and what the record shows.

A call costs as much as some turns, and so does what Python makes of a record: so both are done for
a batch of orbits on one cam. Their records stand one after the other in a log and in the table of
strobes.

An orbit that has settled soon goes through the same states again and again, to the last bit: then
its turns are not flown any more. Those of the transient are left out and those of the record are
copied, so that the record has the bits that it would have had.
"""

from dataclasses import dataclass

from camcli.kernel.cam_table import lift_at
from camcli.kernel.flow import Constants, fill_flows
from camcli.kernel.loads import measure_record
from camcli.kernel.marks import entry, inlined, outlined
from camcli.kernel.orbit_loop import (
    LOG_FULL,
    NEVER,
    NOWHERE,
    OK,
    PAUSED,
    RESTING,
    Plan,
    Strobe,
    keep,
    run,
)
from camcli.kernel.returns import find_return


@dataclass(slots=True)
class Run:
    """One orbit of a batch: what is asked for, and what its record shows."""

    log_from: int = 0  # first period whose events are logged
    turns: int = 0  # to record
    strobe_first: int = 0  # first row in the table of strobes
    strobe_rows: int = 0
    wants_loads: int = 0  # 1: they are measured
    continues: int = 0  # 1: it begins where the orbit before it ends, see `continue_orbit`
    not_begun: int = 0  # 1: it was left out, as that one shows where the motion ends
    log_first: int = 0  # rows of the log
    log_last: int = 0
    status: int = 0
    periods: int = 0  # whole turns in the record
    impacts: int = 0  # in them
    chatters: int = 0  # of them, those in which a complete chatter ends
    resting: int = 0  # 1: the follower rests at the end
    repeats: int = 0  # see `returns.find_return`
    near: int = 0


@entry
def follow_orbits(
    cam, consts, flows, states, works, runs, earliers, loads, log, strobe, begin, steps
):
    """Follow the orbits of a batch, from number `begin` on, to the ends of their records.

    Returns the number of orbits, or that of the one at work where `steps` steps were done (PAUSED)
    or the log is full: another call goes on from there, and gives the same bits as one long call.
    consts: a table of `Constants`; flows: room for the table of `fill_flows`; earliers: a row of
    `Earlier` an orbit.
    """
    left = steps
    for n in range(begin, len(runs)):
        this_run = runs[n]
        state = states[n]
        work = works[n]
        row = consts[n]
        const = Constants(  # the functions of the kernel take a tuple, not a row of a table
            row.W, row.W2, row.Z, row.D, row.G, row.r, row.tolerance, row.impact_budget,
            row.W_rest, row.r_seat,
        )  # fmt: skip
        fill_flows(cam, const, flows)
        own_strobe = Strobe(
            strobe.q,
            strobe.w,
            strobe.impacts,
            strobe.chatter,
            this_run.strobe_rows,
            this_run.strobe_first,
        )
        earlier = earliers[n]
        this_run.status = OK
        if this_run.continues == 1:
            continue_orbit(cam, runs[n - 1], states[n - 1], this_run, state, own_strobe)
        going_on = this_run.not_begun == 0
        while going_on:
            if earlier.cycle > 0:
                this_run.status = repeat_turns(state, this_run, earlier, log, own_strobe)
            if this_run.status == OK:
                before = work.steps
                plan = Plan(this_run.log_from, this_run.turns, left)
                this_run.status = run(
                    cam, const, flows, state, plan, log, own_strobe, work, earlier
                )
                left -= work.steps - before
            going_on = this_run.status == OK and earlier.cycle > 0
        this_run.log_last = state.logged
        if this_run.status in (PAUSED, LOG_FULL):
            return n
        if this_run.not_begun == 0:
            finish(cam, const, state, this_run, log, own_strobe, loads[n])
        if n + 1 < len(runs):
            runs[n + 1].log_first = state.logged
            states[n + 1].logged = state.logged
    return len(runs)


@outlined
def continue_orbit(cam, run_before, state_before, this_run, state, strobe):
    """Begin where the orbit before ends, as that orbit, with its turns counted from 0.

    It is left out where the record of the one before repeats, has a rest or ended in trouble: then
    that record is the last of those that are asked for.
    """
    this_run.continues = 0  # it is done once, however often the orbit is interrupted
    ended = run_before.status != OK or run_before.repeats > 0 or run_before.chatters > 0
    if ended or run_before.not_begun == 1:
        this_run.not_begun = 1
        return
    copy_state(state_before, state)
    state.period = 0
    state.total_impacts = 0
    state.detachments = 0
    if strobe.rows > 0:
        c, c1, _ = lift_at(cam, state.stretch, state.theta)
        strobe.q[strobe.first] = c + state.gap
        strobe.w[strobe.first] = c1 + state.gap_rate


@inlined
def copy_state(one, to):
    """Let `to` be the same state, but for `logged`, which counts rows of the log."""
    to.theta = one.theta
    to.gap = one.gap
    to.gap_rate = one.gap_rate
    to.mode = one.mode
    to.stretch = one.stretch
    to.period = one.period
    to.impacts = one.impacts
    to.chattered = one.chattered
    to.idle = one.idle
    to.flown = one.flown
    to.wraps = one.wraps
    to.from_stretch = one.from_stretch
    to.from_theta = one.from_theta
    to.from_gap = one.from_gap
    to.from_rate = one.from_rate
    to.from_rest = one.from_rest
    to.from_known = one.from_known
    to.rest = one.rest
    to.known = one.known
    to.level = one.level
    to.gain = one.gain
    to.slope = one.slope
    to.slope_rest = one.slope_rest
    to.total_impacts = one.total_impacts
    to.detachments = one.detachments


@outlined
def repeat_turns(state, this_run, earlier, log, strobe):
    """Go on without flying from a state that is an earlier one again; OK or LOG_FULL.

    The orbit is left less than a cycle before the end of the transient, or of the record. A cycle
    that began in the transient is not in the record yet: there it is flown once more.
    """
    if earlier.period >= 0:
        return copy_turns(state, this_run.turns, earlier, log, strobe)
    if state.period < 0:  # the turn that ends with the transient is flown, see `begin_period`
        left_out = (-1 - state.period) // earlier.cycle
        state.period += left_out * earlier.cycle
        state.total_impacts += left_out * (state.total_impacts - earlier.total_impacts)
    forget(earlier, 0)
    if state.period >= 0:
        keep(state, state.gap, state.gap_rate, state.mode, earlier)
    return OK


@inlined
def forget(earlier, keep_in):
    """Let no state be kept before the period `keep_in`."""
    earlier.cycle = 0
    earlier.gap = NOWHERE
    earlier.keep_in = keep_in


@outlined
def copy_turns(state, turns, earlier, log, strobe):
    """Copy the cycle that ends the record so far, up to the end of a record of `turns`.

    Returns OK, or LOG_FULL where the log has no room for all copies: with more room the rest of
    them follow.
    """
    cycle = earlier.cycle
    rows = state.logged - earlier.logged  # of the log, in the cycle; so are the next two
    impacts = state.total_impacts - earlier.total_impacts
    detachments = state.detachments - earlier.detachments
    copies = (turns - state.period) // cycle
    status = OK
    if rows * copies > log.capacity - state.logged:
        copies = (log.capacity - state.logged) // rows
        status = LOG_FULL
    for number in range(1, copies + 1):
        for row in range(earlier.logged, state.logged):
            copy_event(log, row, row + number * rows, number * cycle)
        for period in range(earlier.period, state.period):
            copy_period(strobe, period, period + number * cycle)
    state.period += copies * cycle
    state.logged += copies * rows
    state.total_impacts += copies * impacts
    state.detachments += copies * detachments
    earlier.period = state.period - cycle
    earlier.logged = state.logged - rows
    earlier.total_impacts = state.total_impacts - impacts
    earlier.detachments = state.detachments - detachments
    if status == OK:
        forget(earlier, NEVER)
    return status


@inlined
def copy_event(log, row, to, periods):
    """Log the event of a row again, so many periods later."""
    log.kind[to] = log.kind[row]
    log.period[to] = log.period[row] + periods
    log.theta[to] = log.theta[row]
    log.q[to] = log.q[row]
    log.u[to] = log.u[row]


@inlined
def copy_period(strobe, period, to):
    """Record a period again: what it counted, and the state at its end, which begins the next."""
    if to < strobe.rows:
        strobe.impacts[strobe.first + to] = strobe.impacts[strobe.first + period]
        strobe.chatter[strobe.first + to] = strobe.chatter[strobe.first + period]
    if to + 1 < strobe.rows:
        strobe.q[strobe.first + to + 1] = strobe.q[strobe.first + period + 1]
        strobe.w[strobe.first + to + 1] = strobe.w[strobe.first + period + 1]


@outlined
def finish(cam, const, state, this_run, log, strobe, load):
    """What the record of an orbit shows at its end."""
    this_run.periods = max(
        0, min(state.period, this_run.turns)
    )  # the period is below 0 in the transient
    this_run.resting = 1 if state.mode == RESTING or is_thrown_off(cam, state) else 0
    if strobe.rows == 0:  # nothing was recorded
        return
    for k in range(strobe.first, strobe.first + this_run.periods):
        this_run.impacts += strobe.impacts[k]
        this_run.chatters += 1 if strobe.chatter[k] != 0 else 0
    if this_run.periods > 0:
        this_run.repeats, this_run.near = find_return(strobe, this_run.periods)
        if this_run.wants_loads == 1:
            load.turns = this_run.periods
            load.resting = this_run.resting
            load.gap = strobe.q[strobe.first] - cam.stretches[cam.strobe].start_c
            load.rate = strobe.w[strobe.first] - cam.stretches[cam.strobe].start_c1
            measure_record(cam, const, log, this_run.log_first, this_run.log_last, load)


@inlined
def is_thrown_off(cam, state):
    """Whether a downward kink throws the follower off right now, out of a rest."""
    jump = cam.stretches[state.stretch].slope_jump
    at_start = state.theta == cam.stretches[state.stretch].start and state.gap == 0.0
    return at_start and state.gap_rate == -jump and jump < 0.0
