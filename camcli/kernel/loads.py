"""What an engineer reads off a record: the highest flight, time in the air, impacts, forces.

A record is a sequence of flights and rests between its events. In a flight the gap is the closed
form of `flow` minus the cam, at rest the contact force over m omega^2 is -a of `sticking`. An
extremum is looked for cell by cell, and a cell of h rad is left only when nothing can hide in it.
With f the gap or the contact force, values at both ends and |f'''| <= M between them,
    (f''(0) + f''(h) - M h)/2 <= f'' <= (f''(0) + f''(h) + M h)/2,
and one of these settles the cell: no value of it can exceed one seen before, f' has one sign, or
f'' has one sign, so that f' has at most one zero. Else the cell is halved.
"""

from dataclasses import dataclass
from math import sqrt

from camcli.kernel.cam_table import TURN, higher, lift_at, restitution_at, stretch_at
from camcli.kernel.contact_search import flight_at, gap_after
from camcli.kernel.marks import entry, inlined, outlined
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.kernel.sticking import contact_accel

SLIVER = 1e-12  # rad: a rest that ends at a corner ends before it
STEPS = 40  # of Newton's method or a bisection, at most
FLAT = 1e-9  # rad, or the share of a short flight: so near to an extremum its value is exact
BOUNCE = 0.1  # of the hardest impact of the record: a softer one is no bounce that counts
SHUT = 0.01  # of the whole lift: a cam that is lifted by no more counts as shut
MEMORY = 32  # events
SURELY = 1.0 - 1e-9  # of the largest gap: what stays below it by a bound does so computed, too
ROUNDING = 1e-14  # relative, of the bound
STIFF = 8.0  # Z h of a cell above which a damper's layer is thin in it


@dataclass(slots=True)
class Loads:
    """Of whole turns; m, rad, m/rad; forces over m omega^2, min above max where there is none."""

    max_gap: float = 0.0
    airborne: float = 0.0  # rad in the air
    max_impact: float = 0.0  # the hardest, as a positive rate
    min_force: float = 1.0
    max_force: float = 0.0
    lost: float = -1.0  # least phase after the strobe at which contact is lost; below 0: never
    regained: float = -1.0  # largest one at which it is regained
    landing: float = -1.0  # phase of the hardest impact; below 0: none
    landing_c: float = 0.0  # the cam's lift there
    shut_bounces: int = 0  # impacts at `bounce` or more on a cam no higher than `shut`
    seated: float = 0.0  # rad at rest on the seat of a cam with lash
    # the record
    turns: int = 0  # whole ones
    resting: int = 0  # 1: the follower rests where it ends
    shut: float = 0.0  # m
    bounce: float = 0.0
    lowest: float = 0.0  # of the cam, m
    has_seat: int = 0  # 1: the shut follower rests on its seat, not on the cam
    # the last event; at first, gap and rate of the first strobe
    place: float = 0.0  # rad since the first strobe
    phase: float = 0.0
    gap: float = 0.0
    rate: float = 0.0
    still: int = 0  # 1: at rest from there on
    struck: int = 0  # 1: an impact, after which it may rest


@entry
def measure_loads(cam, const, log, first, last, rows, loads):
    """Go on with loads[0] over the events of a log from `first` to `last`, of `rows` in all.

    In order, from any call to the next. The record in loads[0] is given, with gap and rate.
    """
    load = loads[0]
    if first == 0:
        begin(cam, log, 0, rows, load)
    add_events(cam, const, log, 0, first, last, load)
    if last == rows:
        end(cam, const, log, 0, rows, load)


@inlined
def measure_record(cam, const, log, first, last, load):
    """The same for a whole record, which stands in a log from `first` to `last`."""
    begin(cam, log, first, last, load)
    add_events(cam, const, log, first, first, last, load)
    end(cam, const, log, first, last, load)


@inlined
def begin(cam, log, first, last, load):
    """What the record says before its events are gone through: its hardest impact, a rest."""
    hardest = 0.0
    recorded = last  # the first event of the recorded turns
    for n in range(first, last):
        if log.period[n] < 0:
            continue
        recorded = min(recorded, n)
        if log.kind[n] == IMPACT and log.period[n] < load.turns:
            hardest = max(hardest, -log.u[n])
    load.bounce = BOUNCE * hardest
    load.lowest = cam.top
    for i in range(len(cam.stretches)):
        load.lowest = min(load.lowest, cam.stretches[i].c_min)
        if cam.stretches[i].seat:
            load.has_seat = 1
    load.phase = cam.stretches[cam.strobe].start
    load.still = 1 if begins_at_rest(cam, log, recorded, last, load) else 0


@inlined
def begins_at_rest(cam, log, recorded, last, load):
    """Whether the follower rests on the cam at the first strobe, unless a detachment says so.

    On the cam at its velocity, to the last bit, it may still be in a hop lower than that: then the
    next event is a chatter, or an impact elsewhere than at an upward kink.
    """
    if load.gap != 0.0 or load.rate != 0.0:
        return False
    if recorded == last or log.kind[recorded] == DETACHMENT:
        return True
    i = stretch_at(cam, log.theta[recorded])
    at_kink = log.theta[recorded] == cam.stretches[i].start and cam.stretches[i].slope_jump > 0.0
    return log.kind[recorded] == IMPACT and at_kink


@inlined
def add_events(cam, const, log, oldest, first, last, load):
    """Go through events; `oldest` is the first one of the record.

    A rest ends with a detachment, or at a kink with an impact; it begins with a chatter, or with an
    impact after which nothing bounces.
    """
    for n in range(first, last):
        if log.period[n] < 0 or log.period[n] >= load.turns:
            continue
        kind = log.kind[n]
        theta = log.theta[n]
        u = log.u[n]
        since = since_strobe(cam, theta)
        at = TURN * log.period[n] + since
        if kind == DETACHMENT:
            _rest_since_impact(cam, load)
        span = at - load.place
        rested_on_seat = add_span(cam, span, load)
        if not adds_nothing(cam, const, log, oldest, n, span, load):
            _find_extremes(cam, const, span, load)
        i = stretch_at(cam, theta)
        left = load.still == 1 and kind != CHATTER
        if rested_on_seat or cam.stretches[i].seat:  # contact is that with the lobe
            left = False
        if left and (load.lost < 0.0 or since < load.lost):
            load.lost = since
        load.gap, load.rate = 0.0, 0.0
        load.still, load.struck = 0, 0
        if kind == IMPACT:
            load.rate, load.struck = -restitution_at(cam, const, i) * u, 1
            if -u > load.max_impact:
                load.max_impact = -u
                load.landing, load.landing_c = theta, lift_at(cam, i, theta)[0]
            shut = cam.stretches[i].seat or load.has_seat == 0
            if shut and -u >= load.bounce and lift_at(cam, i, theta)[0] <= load.shut:
                load.shut_bounces += 1
        elif kind == CHATTER:
            if not cam.stretches[i].seat:
                regain(load, at)
            load.still = 1
        elif theta == cam.stretches[i].start:  # a downward kink throws the follower off
            load.rate = max(-cam.stretches[i].slope_jump, 0.0)
        load.place, load.phase = at, theta
        if load.struck == 1 and load.rate == 0.0 and _is_pressed(cam, const, i, theta):
            _rest_since_impact(cam, load)


@inlined
def end(cam, const, log, first, last, load):
    """Go on from the last event to the end of the whole turns.

    A log may hold events of a turn that is not whole, at which the run broke off. The first of them
    tells whether the follower rests at the end of the whole turns: then it is a detachment. Where
    there is none, the record says it.
    """
    beyond = last  # the first event after the whole turns
    for n in range(last - 1, first - 1, -1):
        if log.period[n] < load.turns:
            break
        beyond = n
    if beyond < last:
        rests = log.kind[beyond] == DETACHMENT
    else:
        rests = load.resting == 1
    if rests:
        _rest_since_impact(cam, load)
    span = TURN * load.turns - load.place
    add_span(cam, span, load)
    _find_extremes(cam, const, span, load)


@inlined
def add_span(cam, span, load):
    """Count the `span` rad since the last event; whether it was a rest that ended on the seat."""
    if load.still == 0:
        load.airborne += span
        return False
    if load.has_seat == 0:
        return False
    return _rest_on_seat(cam, span, load)


@outlined
def _rest_on_seat(cam, span, load):
    """Add the part of a rest of `span` rad that was on the seat; whether the rest ended there.

    Where the lash is 0 a rest goes on from the seat to the lobe and back.
    """
    whole = 0.0  # rad of the seat in a whole turn
    for k in range(len(cam.stretches)):
        if cam.stretches[k].seat:
            whole += cam.stretches[k].end - cam.stretches[k].start
    turns = int(span / TURN)
    load.seated += turns * whole
    left = span - turns * TURN
    theta = load.phase
    i = stretch_at(cam, theta)
    on_seat = cam.stretches[i].seat != 0
    while left > SLIVER:
        step = min(cam.stretches[i].end - theta, left)
        on_seat = cam.stretches[i].seat != 0
        if on_seat:
            load.seated += step
        left -= step
        i += 1
        if i == len(cam.stretches):
            i = 0
        theta = cam.stretches[i].start
    return on_seat


@inlined
def since_strobe(cam, theta):
    """rad from the strobe before a phase."""
    strobe = cam.stretches[cam.strobe].start
    return theta - strobe + (TURN if theta < strobe else 0.0)


@inlined
def adds_nothing(cam, const, log, oldest, n, span, load):
    """Whether no new extreme can lie on the way to event n, a rest or flight of `span` rad."""
    if load.still == 0 and _stays_low(cam, const, span, load):
        return True
    return is_repeated(cam, log, oldest, n, span)


@inlined
def is_repeated(cam, log, oldest, n, span):
    """Whether the way to event n is one of the MEMORY ways before it again, to the last bit.

    An orbit that has settled goes through few ways in all.
    """
    for m in range(n - 1, max(oldest, n - MEMORY), -1):
        if log.theta[m] != log.theta[n] or log.theta[m - 1] != log.theta[n - 1]:
            continue
        if log.u[m - 1] != log.u[n - 1] or log.period[m - 1] < 0:
            continue
        if log.kind[m] != log.kind[n] or log.kind[m - 1] != log.kind[n - 1]:
            continue
        before = TURN * log.period[m - 1] + since_strobe(cam, log.theta[m - 1])
        if TURN * log.period[m] + since_strobe(cam, log.theta[m]) - before == span:
            return True
    return False


@outlined
def _is_pressed(cam, const, i, theta):
    """Whether the follower at rest on the cam is pressed to it, at theta of stretch i."""
    return contact_accel(cam, const, i, theta)[0] < 0.0


@inlined
def _rest_since_impact(cam, load):
    """The follower rests; since the last event where that was an impact."""
    if load.struck == 1 and not cam.stretches[stretch_at(cam, load.phase)].seat:
        regain(load, load.place)
    load.still = 1
    load.struck = 0


@inlined
def _find_extremes(cam, const, span, load):
    """Take the extremes of the rest or flight of `span` rad since the last event into the load."""
    if load.still == 1:
        _press_at_rest(cam, const, load.phase, span, load)
    else:
        _fly(cam, const, load.phase, load.gap, load.rate, span, load)


@outlined
def _stays_low(cam, const, span, load):
    """True where the flight of `span` rad from the last event cannot exceed the largest gap so far.

    With F = G + W^2 q at its start, the energy w^2/2 + F x + W^2 x^2/2 of a rise x never grows, so
        x <= w^2/(F + sqrt(F^2 + W^2 w^2))    for F > 0,
    above the lowest cam. A hop within a stretch is below gap + rate s + max(gap'') s^2/2.
    """
    i = stretch_at(cam, load.phase)
    f = flight_at(cam, const, i, load.phase, load.gap, load.rate)
    limit = SURELY * load.max_gap
    if f.force > 0.0:
        top = f.q + f.w * f.w / (f.force + sqrt(f.force * f.force + const.W2 * f.w * f.w))
        if top - load.lowest + ROUNDING * (abs(top) + abs(f.q)) <= limit:
            return True
    bend = abs(f.q2) + const.W * abs(f.w) - cam.stretches[i].accel_min
    rise = span * (max(f.rate, 0.0) + 0.5 * span * max(bend, 0.0))
    return span <= f.end and f.gap + rise <= limit


@inlined
def regain(load, place):
    """Contact is regained at a place, rad since the first strobe."""
    since = place - TURN * int(place / TURN)
    if since > load.regained:
        load.regained = since


@outlined
def _press_at_rest(cam, const, theta, span, load):
    """The force over a rest of `span` rad from theta; one turn of it is all."""
    left = min(span, TURN)
    i = stretch_at(cam, theta)
    while left > SLIVER:
        end = cam.stretches[i].end
        if end - theta > left:
            end = theta + left
        left -= end - theta
        if not cam.stretches[i].seat:  # its force is none of the cam's
            _press(cam, const, i, theta, end, load)
        i += 1
        if i == len(cam.stretches):
            i = 0
        theta = cam.stretches[i].start


@outlined
def _press(cam, const, i, theta, end, load):
    """The force from theta to `end`, within stretch i (see the module)."""
    third = const.W2 * cam.stretches[i].jerk_max + 2.0 * const.Z * cam.stretches[i].snap_max
    third += cam.stretches[i].crackle_max
    force, slope, curve = _force(cam, const, i, theta, load)
    step = end - theta
    while theta < end:
        step = min(step, end - theta)
        after = end if step == end - theta else theta + step
        force1, slope1, curve1 = _force(cam, const, i, after, load)
        low = 0.5 * (curve + curve1 - third * step)
        high = 0.5 * (curve + curve1 + third * step)
        down = min(low, 0.0)
        up = max(high, 0.0)
        bulge = 0.125 * step * step
        within = max(force, force1) - down * bulge <= load.max_force
        within = within and min(force, force1) - up * bulge >= load.min_force
        rises = slope + down * step >= 0.0 or slope1 - up * step >= 0.0
        falls = slope + up * step <= 0.0 or slope1 - down * step <= 0.0
        settled = within or rises or falls or low >= 0.0 or high <= 0.0 or step <= FLAT
        if not settled:
            step *= 0.5
            continue
        if slope * slope1 < 0.0 and not within:
            _turning_force(cam, const, i, theta, after, slope, load)
        theta, force, slope, curve = after, force1, slope1, curve1
        step *= 2.0


@inlined
def _turning_force(cam, const, i, low, high, slope, load):
    """Count the force where its slope is zero between two phases, `slope` at the lower one."""
    x = 0.5 * (low + high)
    for _ in range(STEPS):
        _, here, curve = _force(cam, const, i, x, load)
        if here * slope > 0.0:
            low = x
        else:
            high = x
        step = -here / curve if curve != 0.0 else high - low
        x = x + step if low < x + step < high else 0.5 * (low + high)
        if abs(step) <= FLAT or high - low <= FLAT:
            break


@inlined
def _force(cam, const, i, theta, load):
    """(force, its first and second derivative) in contact at theta of stretch i; it is counted."""
    a, slope, _ = contact_accel(cam, const, i, theta)
    c2 = lift_at(cam, i, theta)[2]
    c3, c4, _, _ = higher(cam, i, theta)
    if load.min_force > load.max_force:
        load.min_force = load.max_force = -a
    load.min_force = min(load.min_force, -a)
    load.max_force = max(load.max_force, -a)
    return -a, -slope, const.W2 * c2 + 2.0 * const.Z * c3 + c4


@outlined
def _fly(cam, const, theta, gap, rate, span, load):
    """The gap over a flight of `span` rad from (gap, rate) at theta."""
    i = stretch_at(cam, theta)
    left = span
    flat = FLAT * min(span, 1.0)
    step = span
    while left > 0.0:
        f = flight_at(cam, const, i, theta, gap, rate)
        step, gap, rate = _climb(cam, const, i, f, min(step, f.end, left), flat, load)
        left -= step
        if step < f.end:
            theta += step
            step *= 2.0
        else:
            i += 1
            if i == len(cam.stretches):
                i = 0
            theta = cam.stretches[i].start
            step = left
            rate -= cam.stretches[i].slope_jump


@inlined
def _climb(cam, const, i, f, step, flat, load):
    """Count the gap over a cell from the start of f on, `step` rad or less, within stretch i.

    (step, gap, rate) at its end. As of the module, M by the flight's own energy (`contact_search`).
    """
    third = f.energy + cam.stretches[i].jerk_max
    accel = f.q2 - f.c2
    load.max_gap = max(load.max_gap, f.gap)
    while True:
        gap, rate, accel1 = gap_after(cam, const, i, f, step)
        load.max_gap = max(load.max_gap, gap)
        low = 0.5 * (accel + accel1 - third * step)
        high = 0.5 * (accel + accel1 + third * step)
        down = min(low, 0.0)
        up = max(high, 0.0)
        if max(f.gap, gap) - 0.125 * down * step * step <= load.max_gap:
            break
        if f.rate + down * step >= 0.0 or rate - up * step >= 0.0:
            break
        if f.rate + up * step <= 0.0 or rate - down * step <= 0.0:
            break
        if high <= 0.0:
            if f.rate > 0.0 > rate:
                _highest_gap(cam, const, i, f, step, flat, load)
            break
        if step <= flat:
            break
        step *= 0.5 if const.Z * step < STIFF else 0.125
    return step, gap, rate


@inlined
def _highest_gap(cam, const, i, f, high, flat, load):
    """Count the gap where its rate is zero, between the start of f and `high` rad after it."""
    low, x = 0.0, 0.5 * high
    for _ in range(STEPS):
        gap, rate, accel = gap_after(cam, const, i, f, x)
        load.max_gap = max(load.max_gap, gap)
        if rate > 0.0:
            low = x
        else:
            high = x
        step = -rate / accel if accel < 0.0 else high - low
        x = x + step if low < x + step < high else 0.5 * (low + high)
        if abs(step) <= flat or high - low <= flat:
            break
