"""Multiple shooting for a periodic orbit with impacts: residual, Jacobian, bordered Newton step.

Unknowns: the phase theta_k and the outgoing relative rate v_k = -r u_k of every impact (r that of
the cam or of the seat), and one parameter of the machine. Flight k leads from impact k to impact
k + 1, the last one back to the first; with s its length, A0 and A1 the relative accelerations at
its ends, the equations are
    E1 = gap(s) = 0,       dE1 = -(v (1 - W^2 P) + B A0) dtheta + B dv + u dtheta',
    E2 = r u + v' = 0,     dE2 = r (W^2 B v - B' A0) dtheta + r B' dv + r A1 dtheta' + dv',
a prime meaning impact k + 1 and u its incoming rate. No difference of large numbers is left in
them. Every impact names the stretch of the cam it uses, also a little beyond the stretch's ends,
so that the equations stay smooth while an impact passes a corner. The parameter's column is a
central difference: it only steers.

In code impacts are counted from 0 to n - 1. x is (theta_0, v_0, theta_1, v_1, ..., parameter), in
rad and m/rad, (2 n + 1,). whole is (stretch of impact 0, its turn from the first impact's, stretch
of impact 1, ...), (2 n,) ints. turns: how many the orbit takes.
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
    theta = x[2 * k]
    turn = whole[2 * k + 1]
    if k + 1 < n:
        return (x[2 * k + 2] - theta) + TURN * (whole[2 * k + 3] - turn)
    return (x[0] - theta) + TURN * (whole[1] + turns - turn)


@outlined
def arrival(cam, const, x, whole, turns, k, n):
    """(gap, rate) of flight k at impact k + 1, in relative coordinates where the hop is short.

    Else from the closed form (`flow`), q = c + w B - F P and q' = w B' - F B, with c and c_theta at
    impact k, w = c_theta + v_k and F = G + W^2 c.
    """
    j = (k + 1) % n
    s = _length(x, whole, turns, k, n)
    i = whole[2 * k]
    theta = x[2 * k]
    v = x[2 * k + 1]
    if 0.0 < s <= NEAR and whole[2 * j] == i and (const.W + 2.0 * const.Z) * s <= LONGEST_PHASE:
        f = flight_at(cam, const, i, theta, 0.0, v)
        gap, rate, _ = gap_near(cam, const, i, f, s)
        return gap, rate
    c, c1, _ = lift(cam, i, theta)
    c_end, c1_end, _ = lift(cam, whole[2 * j], x[2 * j])
    b, b1, p = flow(const, s)
    force = const.G + const.W2 * c
    w = c1 + v
    return (c - c_end) + (w * b - force * p), (w * b1 - force * b) - c1_end


@outlined
def fill_block(cam, const, x, whole, turns, k, n, blocks):
    """Fill block k: derivatives by (theta_k, v_k), by (theta_k+1, v_k+1), and the residual.

    They are those of the module's equations E1 and E2, a row each.
    """
    j = (k + 1) % n
    gap, u = arrival(cam, const, x, whole, turns, k, n)
    v = x[2 * k + 1]
    v_next = x[2 * j + 1]
    c, c1, c2 = lift(cam, whole[2 * k], x[2 * k])
    accel_start = gap_accel(const, c, c1 + v, c2)
    c, c1, c2 = lift(cam, whole[2 * j], x[2 * j])
    accel_end = gap_accel(const, c, c1 + u, c2)
    b, b1, p = flow(const, _length(x, whole, turns, k, n))
    r = restitution_at(cam, const, whole[2 * j])
    block = BLOCK * k
    put_pair(blocks, block + LEFT, -(v * (1.0 - const.W2 * p) + b * accel_start), b)
    put_pair(blocks, block + LEFT + 2, r * (const.W2 * b * v - b1 * accel_start), r * b1)
    put_pair(blocks, block + RIGHT, u, 0.0)
    put_pair(blocks, block + RIGHT + 2, r * accel_end, 1.0)
    put_pair(blocks, block + RESIDUAL, gap, r * u + v_next)


@inlined
def _by_parameter(cam, low, high, width, x, whole, turns, k, n):
    """(dE1, dE2) of flight k by the parameter: a difference between two machines.

    low, high: their constants; width: how far apart they are in the parameter.
    """
    j = (k + 1) % n
    gap_high, u_high = arrival(cam, high, x, whole, turns, k, n)
    gap_low, u_low = arrival(cam, low, x, whole, turns, k, n)
    v_next = x[2 * j + 1]
    r_high = restitution_at(cam, high, whole[2 * j])
    r_low = restitution_at(cam, low, whole[2 * j])
    e2_high = r_high * u_high + v_next
    e2_low = r_low * u_low + v_next
    return (gap_high - gap_low) / width, (e2_high - e2_low) / width


@inlined
def _difference(machine, parameter, value, scale):
    """(const, low, high, width): constants at `value`, and at both ends of a difference about it.

    parameter: the entry of the table `machine` that is varied, and set to `value`. scale: its size
    below which the width, DIFFERENCE of it, is absolute. Where the lower end means no machine, the
    difference is one-sided.
    """
    half = DIFFERENCE * max(abs(value), scale)
    low = value - half
    if not _meaningful(parameter, low):
        low = value
    machine[parameter] = value + half
    constants_high = constants_of(machine, 0.0, 0)
    machine[parameter] = low
    constants_low = constants_of(machine, 0.0, 0)
    machine[parameter] = value
    return constants_of(machine, 0.0, 0), constants_low, constants_high, (value + half) - low


@inlined
def _meaningful(parameter, value):
    """False for a constant no machine has, as a mass of 0: the iteration has left its range."""
    if parameter in (RPM, MASS):
        return value > 0.0
    return value >= 0.0 or parameter not in (STIFFNESS, DAMPING, SEAT_RESTITUTION)


@inlined
def fill_tables(cam, machine, parameter, n, turns, whole, x, scale, t):
    """Fill in the blocks of every flight at x, and the column of the parameter; see `_difference`.

    The entry `parameter` of the table `machine` becomes that of x.
    """
    const, low, high, width = _difference(machine, parameter, x[2 * n], scale)
    for k in range(n):
        fill_block(cam, const, x, whole, turns, k, n, t.blocks)
        e1, e2 = _by_parameter(cam, low, high, width, x, whole, turns, k, n)
        put_pair(t.columns, 2 * k, e1, e2)


@entry
def correct_orbit(cam, machine, parameter, n, turns, whole, x, border, rates, t, out):
    """Newton's method on the bordered equations from x, in place; OK or UNRESOLVED.

    n, turns, whole, x: an orbit of n impacts, see the module; machine: see `flow.constants_of`, its
    `parameter` entry is set; border: `Border`; t: `bordered.Tables`, whose t.tangent becomes the
    direction of the branch. rates (n,) become the impacts' incoming rates, m/rad. out (3,) becomes
    the trace of the monodromy matrix, the size of the last step and the number of steps, at TRACE,
    STEP and STEPS_TAKEN.
    """
    size_before = 1e300
    if not within_reach(cam, n, whole, x):
        return UNRESOLVED
    for count in range(MOST_STEPS):
        if not _meaningful(parameter, x[2 * n]):
            return UNRESOLVED
        fill_tables(cam, machine, parameter, n, turns, whole, x, border.scale, t)
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
        if size <= CONVERGED or (size <= STALLED and size > 0.5 * size_before):
            out[TRACE] = rates_and_trace(cam, machine, n, turns, whole, x, rates)
            return OK if out[TRACE] < NO_TRACE else UNRESOLVED
        if not within_reach(cam, n, whole, x):
            return UNRESOLVED
        size_before = size
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
    """Add the Newton step to x, and return its size.

    That is the largest of its entries: a phase in rad, a rate relative to the largest rate of the
    orbit, the parameter relative to itself.
    """
    step = t.step
    largest_rate = border.rate
    for k in range(n):
        incoming = t.blocks[BLOCK * k + RIGHT]  # dE1 / dtheta' is the incoming rate
        largest_rate = max(largest_rate, abs(x[2 * k + 1]), abs(incoming))
    parameter = x[2 * n]
    size = abs(step[2 * n]) / max(abs(parameter), abs(parameter + step[2 * n]), border.scale)
    for k in range(n):
        size = max(size, abs(step[2 * k]), abs(step[2 * k + 1]) / largest_rate)
    for j in range(2 * n + 1):
        x[j] += step[j]
    return size


@inlined
def rates_and_trace(cam, machine, n, turns, whole, x, rates):
    """The trace of the monodromy matrix; NO_TRACE where an impact's rate is zero.

    The incoming rates of all impacts are written into `rates`. The matrix [[qq, qw], [wq, ww]] is
    multiplied by that of each flight and of the impact behind it.
    """
    const = constants_of(machine, 0.0, 0)
    qq, qw, wq, ww = 1.0, 0.0, 0.0, 1.0
    for k in range(n):
        j = (k + 1) % n
        _, u = arrival(cam, const, x, whole, turns, k, n)
        rates[j] = u
        if u == 0.0:
            return NO_TRACE
        qq, qw, wq, ww = after_flight(const, _length(x, whole, turns, k, n), qq, qw, wq, ww)
        lifts = lift(cam, whole[2 * j], x[2 * j])
        r = restitution_at(cam, const, whole[2 * j])
        qq, qw, wq, ww = after_impact(const, r, lifts, u, qq, qw, wq, ww)
    return qq + ww
