"""Multiple shooting for a periodic orbit with impacts: residual, Jacobian, bordered Newton step.

Unknowns: the phase theta_k and the outgoing relative rate v_k = -r u_k of every impact (r that of
the cam or of the seat), and one
parameter of the machine. Flight k leads from impact k to impact k + 1, the last one back to the
first; with s its length, A0 and A1 the relative accelerations at its ends, the equations are
    E1 = gap(s) = 0,       dE1 = -(v (1 - W^2 P) + B A0) dtheta + B dv + u dtheta',
    E2 = r u + v' = 0,     dE2 = r (W^2 B v - B' A0) dtheta + r B' dv + r A1 dtheta' + dv',
a prime meaning impact k + 1 and u its incoming rate. No difference of large numbers is left in
them. Every impact names the stretch of the cam it uses, also a little beyond the stretch's ends,
so that the equations stay smooth while an impact passes a corner. The parameter's column is a
central difference: it only steers.
"""

from typing import Any, NamedTuple

from camcli.errors import Status
from camcli.kernel.bordered import BLOCK, LEFT, RESIDUAL, RIGHT, put_pair, solve_bordered
from camcli.kernel.cam_table import TURN, lift, restitution_at
from camcli.kernel.contact_search import LONGEST_PHASE, NEAR, flight_at, gap_near
from camcli.kernel.flow import (
    DAMPING,
    MASS,
    RPM,
    SEAT_RESTITUTION,
    STIFFNESS,
    constants_of,
    flow,
)
from camcli.kernel.marks import entry, inlined, outlined
from camcli.kernel.variational import after_flight, after_impact, gap_accel

OK, UNRESOLVED = int(Status.OK), int(Status.UNRESOLVED)
MOST_STEPS = 25
CONVERGED = 4e-15  # a Newton step relative to the unknowns' sizes that rounding alone can make
STALLED = 1e-8  # a step that no longer shrinks, but small enough to be rounding
NO_TRACE = 1e300
LONGEST_STEP = 0.5  # rad, a Newton step beyond which the guess was no good
REACH = 0.9  # pieces: how far beyond its stretch an impact may lie while Newton's method steps
DIFFERENCE = 1e-5  # relative width of the parameter's difference
TRACE, STEP, STEPS_TAKEN = 0, 1, 2  # entries of `out`


class Border(NamedTuple):
    """The last equation, row (x - origin) = right: what fixes the place on the branch."""

    row: Any  # (2 n + 1,)
    origin: Any  # (2 n + 1,)
    right: float
    scale: float  # size of the parameter below which changes count as absolute
    rate: float  # the same for the rates, m/rad


@inlined
def _length(x, whole, turns, k, n):
    """rad of flight k."""
    j = k + 1
    if j < n:
        return (x[2 * j] - x[2 * k]) + TURN * (whole[2 * j + 1] - whole[2 * k + 1])
    return (x[0] - x[2 * k]) + TURN * (whole[1] + turns - whole[2 * k + 1])


@outlined
def arrival(cam, const, x, whole, turns, k, n):
    """(gap, rate) of flight k at impact k + 1, in relative coordinates where the hop is short."""
    j = (k + 1) % n
    s = _length(x, whole, turns, k, n)
    i, theta, v = whole[2 * k], x[2 * k], x[2 * k + 1]
    if 0.0 < s <= NEAR and whole[2 * j] == i and (const.W + 2.0 * const.Z) * s <= LONGEST_PHASE:
        f = flight_at(cam, const, i, theta, 0.0, v)
        gap, rate, _ = gap_near(cam, const, i, f, s)
        return gap, rate
    c, c1, _ = lift(cam, i, theta)
    end, end1, _ = lift(cam, whole[2 * j], x[2 * j])
    b, b1, p = flow(const, s)
    force = const.G + const.W2 * c
    w = c1 + v
    return (c - end) + (w * b - force * p), (w * b1 - force * b) - end1


@outlined
def fill_block(cam, const, x, whole, turns, k, n, blocks):
    """Fill block k: derivatives by (theta_k, v_k), by (theta_k+1, v_k+1), and the residual."""
    j = (k + 1) % n
    gap, u = arrival(cam, const, x, whole, turns, k, n)
    v = x[2 * k + 1]
    c, c1, c2 = lift(cam, whole[2 * k], x[2 * k])
    start = gap_accel(const, c, c1 + v, c2)
    c, c1, c2 = lift(cam, whole[2 * j], x[2 * j])
    stop = gap_accel(const, c, c1 + u, c2)
    b, b1, p = flow(const, _length(x, whole, turns, k, n))
    r = restitution_at(cam, const, whole[2 * j])
    block = BLOCK * k
    put_pair(blocks, block + LEFT, -(v * (1.0 - const.W2 * p) + b * start), b)
    put_pair(blocks, block + LEFT + 2, r * (const.W2 * b * v - b1 * start), r * b1)
    put_pair(blocks, block + RIGHT, u, 0.0)
    put_pair(blocks, block + RIGHT + 2, r * stop, 1.0)
    put_pair(blocks, block + RESIDUAL, gap, r * u + x[2 * j + 1])


@inlined
def _by_parameter(cam, low, high, width, x, whole, turns, k, n):
    """(dE1, dE2) of flight k by the parameter: a difference between two machines."""
    j = (k + 1) % n
    gap, u = arrival(cam, high, x, whole, turns, k, n)
    other, rate = arrival(cam, low, x, whole, turns, k, n)
    after = x[2 * j + 1]
    r_high = restitution_at(cam, high, whole[2 * j])
    r_low = restitution_at(cam, low, whole[2 * j])
    return (gap - other) / width, ((r_high * u + after) - (r_low * rate + after)) / width


@inlined
def _difference(machine, parameter, value, scale):
    """(const, low, high, width): the machine at `value` and at both ends of a difference."""
    width = DIFFERENCE * max(abs(value), scale)
    low = value - width
    if not _meaningful(parameter, low):
        low = value
    machine[parameter] = value + width
    high_end = constants_of(machine, 0.0, 0)
    machine[parameter] = low
    low_end = constants_of(machine, 0.0, 0)
    machine[parameter] = value
    return constants_of(machine, 0.0, 0), low_end, high_end, (value + width) - low


@inlined
def _meaningful(parameter, value):
    """False for constants no machine has: the iteration has left the range of the parameter."""
    if parameter in (RPM, MASS):
        return value > 0.0
    return value >= 0.0 or parameter not in (STIFFNESS, DAMPING, SEAT_RESTITUTION)


@entry
def correct_orbit(cam, machine, parameter, n, turns, whole, x, border, rates, t, out):
    """Newton's method on the bordered equations from x, in place; OK or UNRESOLVED.

    x: theta_1, v_1, ..., theta_n, v_n (rad, m/rad), parameter; whole: stretch and turn of each
    impact; machine: see `flow.constants_of`, its `parameter` entry is set. Leaves the incoming
    rates in `rates`, the tangent in t.tangent, and the trace, the last step and their number in
    `out`.
    """
    before = 1e300
    if not within_reach(cam, n, whole, x):
        return UNRESOLVED
    for count in range(MOST_STEPS):
        if not _meaningful(parameter, x[2 * n]):
            return UNRESOLVED
        const, low, high, width = _difference(machine, parameter, x[2 * n], border.scale)
        for k in range(n):
            fill_block(cam, const, x, whole, turns, k, n, t.blocks)
            columns = _by_parameter(cam, low, high, width, x, whole, turns, k, n)
            t.columns[2 * k], t.columns[2 * k + 1] = columns
        right = border.right
        for j in range(2 * n + 1):
            right -= border.row[j] * (x[j] - border.origin[j])
        if not solve_bordered(n, t, border.row, right):
            return UNRESOLVED
        size = take_step(n, x, t, border)
        out[STEP] = size
        out[STEPS_TAKEN] = count + 1.0
        if not size < LONGEST_STEP:
            return UNRESOLVED
        if size <= CONVERGED or (size <= STALLED and size > 0.5 * before):
            out[TRACE] = rates_and_trace(cam, machine, n, turns, whole, x, rates)
            return OK if out[TRACE] < NO_TRACE else UNRESOLVED
        if not within_reach(cam, n, whole, x):
            return UNRESOLVED
        before = size
    return UNRESOLVED


@inlined
def within_reach(cam, n, whole, x):
    """False where an impact lies so far beyond its stretch that the lift there means nothing.

    Beyond an end of the stretch its first or last piece, a polynomial, is followed for REACH of a
    piece. The stretch of impact k is whole[2 k], its phase x[2 k].
    """
    for k in range(n):
        stretch = cam.stretches[whole[2 * k]]
        phase = x[2 * k]
        beyond = REACH / stretch.per_angle
        if phase < stretch.start - beyond or phase > stretch.end + beyond:
            return False
    return True


@inlined
def take_step(n, x, t, border):
    """Add the step to x, and return its size: relative to 1 rad, largest rate and parameter."""
    step = t.step
    rate = border.rate
    for k in range(n):
        incoming = t.blocks[BLOCK * k + RIGHT]  # dE1 / dtheta' is the incoming rate
        rate = max(rate, abs(x[2 * k + 1]), abs(incoming))
    size = abs(step[2 * n]) / max(abs(x[2 * n]), abs(x[2 * n] + step[2 * n]), border.scale)
    for k in range(n):
        size = max(size, abs(step[2 * k]), abs(step[2 * k + 1]) / rate)
    for j in range(2 * n + 1):
        x[j] += step[j]
    return size


@inlined
def rates_and_trace(cam, machine, n, turns, whole, x, rates):
    """Incoming rates of all impacts, and the trace of the monodromy matrix, if no rate is zero."""
    const = constants_of(machine, 0.0, 0)
    qq, qw, wq, ww = 1.0, 0.0, 0.0, 1.0
    for k in range(n):
        j = (k + 1) % n
        u = arrival(cam, const, x, whole, turns, k, n)[1]
        rates[j] = u
        if u == 0.0:
            return NO_TRACE
        qq, qw, wq, ww = after_flight(const, _length(x, whole, turns, k, n), qq, qw, wq, ww)
        lifts = lift(cam, whole[2 * j], x[2 * j])
        r = restitution_at(cam, const, whole[2 * j])
        qq, qw, wq, ww = after_impact(const, r, lifts, u, qq, qw, wq, ww)
    return qq + ww
