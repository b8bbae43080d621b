"""What an engineer reads off a record: the highest flight, time in the air, impacts, forces.

A record is a sequence of flights and rests between its events. In a flight the gap is the closed
form of `flow` minus the cam, at rest the contact force over m omega^2 is -a of `sticking`. Both are
smooth on a stretch, so an extremum is where the derivative changes sign between two phases that are
a cell apart at most, CELL or an eighth of the follower's own period, or at an end.
"""

from dataclasses import dataclass
from math import inf, sqrt

from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.kernel.flow import move
from camcli.kernel.marks import entry, inlined, outlined
from camcli.kernel.orbit_loop import CHATTER, DETACHMENT, IMPACT
from camcli.kernel.sticking import contact_accel

CELL = TURN / 16.0
SLIVER = 1e-12  # rad: a rest that ends at a corner ends before it
STEPS = 40  # of Newton's method or a bisection, at most
GOES_ON, AIRBORNE, AT_REST = -1, 0, 1  # how a call ends
ROUNDING = 1e-12  # share of the terms of a bound, more than their rounding
FLAT = 1e-9  # rad: nearer to an extremum its value is exact to rounding
SHUT = 0.01  # of the whole lift: a cam that is lifted by no more counts as shut
BOUNCE = 0.1  # of the hardest impact before: a softer one is no bounce that counts


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
    landing_lift: float = 0.0  # above the lowest, at it
    shut_bounces: int = 0  # impacts on a cam that is shut
    # the last event
    place: float = 0.0  # rad since the first strobe
    phase: float = 0.0
    q: float = 0.0
    w: float = 0.0
    still: int = 0  # 1: at rest from there on
    struck: int = 0  # 1: an impact, after which it may rest


@entry
def measure_loads(cam, const, kind, period, theta, u, turns, ends, loads):
    """Go on with loads[0] over events of `turns` whole turns; in order, from any call to the next.

    A rest ends with a detachment or after a chatter; `ends`: GOES_ON where more events come, else
    AIRBORNE or AT_REST, how the last turn ends.
    """
    load = loads[0]
    strobe = cam.stretches[cam.strobe].start
    cell = CELL if const.W * CELL < TURN / 8.0 else TURN / 8.0 / const.W
    steepest = _largest_accel(cam, const)
    low = cam.top
    for i in range(len(cam.stretches)):
        low = min(low, cam.stretches[i].start_c)
    shut = low + SHUT * (cam.top - low)
    for n in range(len(kind)):
        if period[n] < 0 or period[n] >= turns:
            continue
        since = theta[n] - strobe + (TURN if theta[n] < strobe else 0.0)
        at = TURN * period[n] + since
        if kind[n] == DETACHMENT:
            if load.struck == 1:
                regain(load, load.place)
            load.still = 1
        _until(cam, const, at, steepest, cell, load)
        if load.still == 1 and kind[n] != CHATTER and (load.lost < 0.0 or since < load.lost):
            load.lost = since
        load.q, c1, _ = lift_at(cam, stretch_at(cam, theta[n]), theta[n])
        load.w = c1
        if kind[n] == IMPACT:
            load.w = c1 - const.r * u[n]
            if -u[n] > load.max_impact:
                load.max_impact = -u[n]
                load.landing, load.landing_lift = theta[n], load.q - low
            if load.q <= shut and -u[n] >= BOUNCE * load.max_impact:
                load.shut_bounces += 1
        elif kind[n] == CHATTER:
            regain(load, at)
        load.still = 1 if kind[n] == CHATTER else 0
        load.struck = 1 if kind[n] == IMPACT else 0
        load.place, load.phase = at, theta[n]
    if ends == AT_REST:
        if load.struck == 1:
            regain(load, load.place)
        load.still = 1
    if ends != GOES_ON:
        _until(cam, const, TURN * turns, steepest, cell, load)


@inlined
def _until(cam, const, at, steepest, cell, load):
    """The rest, or the flight, from the last event up to `at`."""
    if load.still == 1:
        _rest(cam, const, load.phase, at - load.place, load)
    else:
        _fly(cam, const, load.phase, load.q, load.w, at - load.place, steepest, cell, load)


@inlined
def regain(load, place):
    """Contact is regained at a place, rad since the first strobe."""
    since = place - TURN * int(place / TURN)
    if since > load.regained:
        load.regained = since


@inlined
def _largest_accel(cam, const):
    """Upper bound of the second derivative of the gap while it grows, m/rad2."""
    c, c2 = abs(cam.top), 0.0
    for i in range(len(cam.stretches)):
        c = max(c, abs(cam.stretches[i].c_min))
        c2 = max(c2, abs(cam.stretches[i].accel_min), abs(cam.stretches[i].accel_max))
    return abs(const.G) + const.W2 * c + 2.0 * const.Z * TURN * c2 + c2


@outlined
def _rest(cam, const, theta, span, load):
    """The force over a rest of `span` rad from theta; one turn of it is all."""
    left, i = min(span, TURN), stretch_at(cam, theta)
    while left > SLIVER:
        size = min(cam.stretches[i].end - theta, left)
        cells = int(size / CELL) + 1
        a, slope, _ = contact_accel(cam, const, i, theta)
        _force(load, -a)
        for k in range(cells):
            low = theta + size * (k / cells)
            high = theta + size * ((k + 1) / cells)
            if k + 1 == cells and size < left:
                high = cam.stretches[i].end
            a, after, _ = contact_accel(cam, const, i, high)
            _force(load, -a)
            if slope * after < 0.0:
                for _ in range(STEPS):
                    if high - low <= FLAT:
                        break
                    middle = 0.5 * (low + high)
                    a, bend, _ = contact_accel(cam, const, i, middle)
                    if slope * bend > 0.0:
                        low = middle
                    else:
                        high = middle
                _force(load, -a)
            slope = after
        left -= size
        i += 1
        if i == len(cam.stretches):
            i = 0
        theta = cam.stretches[i].start


@inlined
def _force(load, force):
    if load.min_force > load.max_force:
        load.min_force = load.max_force = force
    if force < load.min_force:
        load.min_force = force
    if force > load.max_force:
        load.max_force = force


@outlined
def _fly(cam, const, theta, q, w, span, steepest, cell, load):
    """The gap over a flight of `span` rad from (q, w) at theta.

    It is left out where u s + steepest s^2/2, which no flight exceeds, is below a gap seen before,
    and so is a stretch above which even the highest point of the flight would be.
    """
    load.airborne += span
    flown, i = 0.0, stretch_at(cam, theta)
    c, c1, _ = lift_at(cam, i, theta)
    if (q - c) + (max(w - c1, 0.0) + 0.5 * steepest * span) * span <= load.max_gap:
        return
    highest = _highest(const, q, w)
    while flown < span:
        size = min(cam.stretches[i].end - theta, span - flown)
        cells = int(size / cell) + 1 if highest - cam.stretches[i].c_min > load.max_gap else 0
        rate = 0.0
        if cells > 0:
            rate, _ = _gap(cam, const, i, theta, q, w, flown, load)
        for k in range(cells):
            low, high = size * (k / cells), size * ((k + 1) / cells)
            after, _ = _gap(cam, const, i, theta + high, q, w, flown + high, load)
            if rate > 0.0 > after:
                x = 0.5 * (low + high)
                for _ in range(STEPS):
                    now, accel = _gap(cam, const, i, theta + x, q, w, flown + x, load)
                    if now > 0.0:
                        low = x
                    else:
                        high = x
                    step = -now / accel if accel < 0.0 else high - low
                    x = x + step if low < x + step < high else 0.5 * (low + high)
                    if abs(step) <= FLAT or high - low <= FLAT:
                        break
            rate = after
        flown += size
        i += 1
        if i == len(cam.stretches):
            i = 0
        theta = cam.stretches[i].start


@inlined
def _highest(const, q, w):
    """No less than any q of a flight from (q, w): w^2 + W^2 q^2 + 2 G q never grows."""
    spring, fall = w * w + const.W2 * q * q, const.G + const.W2 * q
    root = const.G + sqrt(fall * fall + const.W2 * w * w)
    if const.G < 0.0 or root <= 0.0:
        return inf
    weight = 2.0 * const.G * q
    return (spring + weight + ROUNDING * (spring + abs(weight))) / root


@inlined
def _gap(cam, const, i, theta, q, w, s, load):
    """(rate, accel) of the gap after s rad of flight; one larger than any before is kept."""
    q, w = move(const, q, w, s)
    c, c1, c2 = lift_at(cam, i, theta)
    load.max_gap = max(load.max_gap, q - c)
    return w - c1, -(const.G + const.W2 * q + 2.0 * const.Z * w) - c2
