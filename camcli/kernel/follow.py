"""Several orbits in one call, each to the end of its record, and what the record shows.

A call costs as much as some turns, and so does what Python makes of a record: so both are done for
a batch of orbits on one cam. Their records stand one after the other in a log and in the table of
strobes.

An orbit that has settled soon goes through the same states again and again, to the last bit: then
its turns are not flown any more. Those of the transient are left out and those of the record are
copied, so that the record has the bits that it would have had.
"""

from dataclasses import dataclass

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
        one = runs[n]
        state = states[n]
        work = works[n]
        row = consts[n]
        const = Constants(  # the functions of the kernel take a tuple, not a row of a table
            row.W, row.W2, row.Z, row.D, row.G, row.r, row.tolerance, row.impact_budget,
            row.W_rest, row.r_seat,
        )  # fmt: skip
        fill_flows(cam, const, flows)
        own = Strobe(
            strobe.q, strobe.w, strobe.impacts, strobe.chatter, one.strobe_rows, one.strobe_first
        )
        earlier = earliers[n]
        one.status = OK
        going_on = True
        while going_on:
            if earlier.cycle > 0:
                one.status = repeat_turns(state, one, earlier, log, own)
            if one.status == OK:
                before = work.steps
                plan = Plan(one.log_from, one.turns, left)
                one.status = run(cam, const, flows, state, plan, log, own, work, earlier)
                left -= work.steps - before
            going_on = one.status == OK and earlier.cycle > 0
        one.log_last = state.logged
        if one.status in (PAUSED, LOG_FULL):
            return n
        finish(cam, const, state, one, log, own, loads[n])
        if n + 1 < len(runs):
            runs[n + 1].log_first = state.logged
            states[n + 1].logged = state.logged
    return len(runs)


@outlined
def repeat_turns(state, one, earlier, log, strobe):
    """Take an orbit that has come back to an earlier state to its end, but for part of a cycle.

    A cycle that begins in the transient is only left out: once more, in the record, it is flown.
    Returns OK, or LOG_FULL where the log has no room for all copies: with more room the rest of
    them follow.
    """
    cycle = earlier.cycle
    rows = state.logged - earlier.logged  # of the log, in the cycle; so are the next two
    impacts = state.total_impacts - earlier.total_impacts
    detachments = state.detachments - earlier.detachments
    if earlier.period < 0:
        if state.period < 0:  # the turn that ends with the transient is flown, see `begin_period`
            left_out = (-1 - state.period) // cycle
            state.period += left_out * cycle
            state.total_impacts += left_out * impacts
        earlier.cycle = 0
        earlier.gap = NOWHERE
        earlier.keep_in = 0
        if state.period >= 0:
            keep(state, state.gap, state.gap_rate, state.mode, earlier)
        return OK
    copies = (one.turns - state.period) // cycle
    status = OK
    if rows * copies > log.capacity - state.logged:
        copies = (log.capacity - state.logged) // rows
        status = LOG_FULL
    for number in range(1, copies + 1):
        for row in range(earlier.logged, earlier.logged + rows):
            copied = row + number * rows
            log.kind[copied] = log.kind[row]
            log.period[copied] = log.period[row] + number * cycle
            log.theta[copied] = log.theta[row]
            log.q[copied] = log.q[row]
            log.u[copied] = log.u[row]
        for period in range(earlier.period, earlier.period + cycle):
            copied = period + number * cycle
            if copied < strobe.rows:
                strobe.impacts[strobe.first + copied] = strobe.impacts[strobe.first + period]
                strobe.chatter[strobe.first + copied] = strobe.chatter[strobe.first + period]
            if copied + 1 < strobe.rows:
                strobe.q[strobe.first + copied + 1] = strobe.q[strobe.first + period + 1]
                strobe.w[strobe.first + copied + 1] = strobe.w[strobe.first + period + 1]
    state.period += copies * cycle
    state.logged += copies * rows
    state.total_impacts += copies * impacts
    state.detachments += copies * detachments
    earlier.period = state.period - cycle
    earlier.logged = state.logged - rows
    earlier.total_impacts = state.total_impacts - impacts
    earlier.detachments = state.detachments - detachments
    if status == OK:
        earlier.cycle = 0
        earlier.gap = NOWHERE
        earlier.keep_in = NEVER
    return status


@outlined
def finish(cam, const, state, one, log, strobe, load):
    """What the record of an orbit shows at its end."""
    one.periods = max(0, min(state.period, one.turns))  # the period is below 0 in the transient
    one.resting = 1 if state.mode == RESTING or is_thrown_off(cam, state) else 0
    if strobe.rows == 0:  # nothing was recorded
        return
    for k in range(strobe.first, strobe.first + one.periods):
        one.impacts += strobe.impacts[k]
        one.chatters += 1 if strobe.chatter[k] != 0 else 0
    if one.periods > 0:
        one.repeats, one.near = find_return(strobe, one.periods)
        if one.wants_loads == 1:
            load.turns = one.periods
            load.resting = one.resting
            load.gap = strobe.q[strobe.first] - cam.stretches[cam.strobe].start_c
            load.rate = strobe.w[strobe.first] - cam.stretches[cam.strobe].start_c1
            measure_record(cam, const, log, one.log_first, one.log_last, load)


@inlined
def is_thrown_off(cam, state):
    """Whether a downward kink throws the follower off right now, out of a rest."""
    jump = cam.stretches[state.stretch].slope_jump
    at_start = state.theta == cam.stretches[state.stretch].start and state.gap == 0.0
    return at_start and state.gap_rate == -jump and jump < 0.0
