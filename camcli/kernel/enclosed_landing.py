"""The first landing of a flight in doubles with a bound on every error, or no answer at all.

The machine is the one whose constants are these doubles exactly, or any whose speed is a rounding
away; its cam is the table's within given errors. A start is known to within radii. What is
returned holds for all of these: the flight meets the cam for the first time within the radius of
the phase given, and there the gap's derivatives lie within theirs. Where the bounds do not show
this, another arithmetic has to (`camcli.exact.motion`).

Bounds. With F = G + W^2 q0 a flight from (q0, w0) is q = q0 + w0 B - F P, w = w0 B' - F B (see
`kernel.flow`), where |B| <= s, |B'| <= 1, 0 <= P <= s^2/2, |dq/dq0| <= 1 and |dw/dq0| = W^2 B <=
min(W, W^2 s), since energy is never gained. The computed B, B' and P are some 10 roundings off,
times 1 + (W + Z) s for the phase of the sine: ROOM is several times that. All later derivatives of
q obey the flight's own equation, so that
    |q'''| <= E = |q'''(0)| + W |q''(0)|,    |q''''| <= (2 Z + W) E.
Hence h rad after a gap with derivatives g, u, a it is at least g + h k(h), where k(h) = u + a h/2 -
M h^2/6 and M = E + max |c'''|; k is concave, so that it is least at an end. The flight is followed
in steps that leave the gap above zero, up to where it certainly falls through.
"""

from typing import NamedTuple

from camcli.kernel.cam_table import TURN, derivative, lift_at, restitution_at, stretch_at
from camcli.kernel.flow import constants_of, flow
from camcli.kernel.marks import entry, inlined, outlined

ULP = 1.1102230246251565e-16  # largest relative error of one operation
ROOM = 64.0 * ULP
SPARE = 1.0 + 1e-10  # covers the roundings in a bound itself
LONGEST = 1e4  # (W + Z) s beyond which nothing is said
MOST_STEPS = 200
MOST_HALVINGS = 40
NEWTON_STEPS = 12
HOP = 2.5  # times rate/fall: a hop lasts about 2 of them
COARSEST = 2.0**-22  # of the flight: a phase of landing known worse is of no use
NO_CHATTER_MAP = -1.0

# The one column of `enclose_landing` begins with the table of `kernel.flow`. Then come errors of c
# and its derivatives in the table of the cam, up to the fourth (m, rad), and their largest sizes:
ERROR, SIZE = 8, 13
# The start:
THETA, RATE, THETA_RADIUS, RATE_RADIUS = range(18, 22)
# The landing: a middle and its radius, one after the other, but for the last four.
ANGLE, U, ACCEL, JERK, J11, J12, J21, J22 = range(22, 38, 2)
SNAP, PHASE, WRAPS, SLIVER = range(38, 42)
COLUMNS = 42

UNDECIDED, ENCLOSED = 0, 1


class Leap(NamedTuple):
    """A flight as it begins on the cam, and what bounds its errors; derivatives by theta."""

    theta: float
    q: float
    w: float  # q'
    force: float  # F
    pull: float  # |G| + W^2 |q|
    rate: float  # of the gap
    fall: float  # -gap''
    energy: float  # E
    dtheta: float  # radii of theta, rate, q, w and fall
    drate: float
    dq: float
    dw: float
    dfall: float


class Gap(NamedTuple):
    """The gap g after some flight, its derivatives u = g', a = g'' and g''', and their radii."""

    g: float
    dg: float
    u: float
    du: float
    a: float
    da: float
    jerk: float
    djerk: float
    b: float  # B and B' of the flight
    b1: float
    dflow: float  # their error: that of B', and that of B over s


class Ball(NamedTuple):
    """A number known to within a radius."""

    middle: float
    radius: float


@inlined
def _times(x, y):
    """Product of two balls."""
    middle = x.middle * y.middle
    radius = SPARE * (abs(x.middle) * y.radius + x.radius * abs(y.middle) + x.radius * y.radius)
    return Ball(middle, radius + 2.0 * ULP * abs(middle))


@inlined
def _plus(x, y):
    """Sum of two balls."""
    radius = SPARE * (x.radius + y.radius) + ULP * (abs(x.middle) + abs(y.middle))
    return Ball(x.middle + y.middle, radius)


@inlined
def _put(room, at, middle, radius):
    """Put a middle at `at`, and its radius behind it."""
    room[at] = middle
    room[at + 1] = radius


@inlined
def _leap(cam, const, room, i):
    """The flight that begins on stretch i of the cam, as `room` says."""
    theta = room[THETA]
    rate = room[RATE]
    dtheta = room[THETA_RADIUS] + 4.0 * ULP * TURN
    drate = room[RATE_RADIUS]
    c, c1, c2 = lift_at(cam, i, theta)
    q = c
    w = c1 + rate
    dq = room[ERROR] + room[SIZE + 1] * dtheta + ROOM * abs(q)
    dw = room[ERROR + 1] + room[SIZE + 2] * dtheta + drate + ROOM * (abs(c1) + abs(rate))
    force = const.G + const.W2 * q
    pull = abs(const.G) + const.W2 * abs(q)
    q2 = -force - 2.0 * const.Z * w
    q3 = -2.0 * const.Z * q2 - const.W2 * w
    dq2 = const.W2 * dq + 2.0 * const.Z * dw + ROOM * (pull + 2.0 * const.Z * abs(w))
    energy = abs(q3) + const.W * abs(q2) + (2.0 * const.Z + const.W) * dq2 + const.W2 * dw
    dfall = dq2 + room[ERROR + 2] + room[SIZE + 3] * dtheta + ROOM * abs(c2)
    return Leap(
        theta, q, w, force, pull, rate, -q2 + c2, SPARE * energy, dtheta, drate, dq, dw, dfall
    )


@inlined
def _gap_after(cam, const, room, leap, i, wraps, s):
    """The gap to stretch i after s rad, `wraps` times past 2 pi, and its derivatives.

    A radius adds up what the start's radii become, the errors of the flow and of the cam's table,
    and what the radius of the phase makes of the cam's next derivative.
    """
    stretch = cam.stretches[i]
    theta = min(max((leap.theta + s) - TURN * wraps, stretch.start), stretch.end)
    dtheta = SPARE * (leap.dtheta + 8.0 * ULP * (leap.theta + s + TURN * (wraps + 1.0)))
    c, c1, c2 = lift_at(cam, i, theta)
    c3 = derivative(cam, 3, i, theta)
    b, b1, p = flow(const, s)
    q = leap.q + (leap.w * b - leap.force * p)
    w = leap.w * b1 - leap.force * b
    q2 = -const.G - const.W2 * q - 2.0 * const.Z * w
    dflow = ROOM * (1.0 + (const.W + const.Z) * s)
    dq = leap.dq + s * leap.dw + dflow * (abs(leap.q) + s * (abs(leap.w) + s * leap.pull))
    w_by_q = min(const.W, const.W2 * s)  # bounds |dw/dq0|
    dw = w_by_q * leap.dq + leap.dw + dflow * (abs(leap.w) + s * leap.pull)
    dq2 = const.W2 * dq + 2.0 * const.Z * dw
    dq2 += ROOM * (abs(const.G) + const.W2 * abs(q) + 2.0 * const.Z * abs(w))
    dq3 = 2.0 * const.Z * dq2 + const.W2 * dw
    dq3 += ROOM * (2.0 * const.Z * abs(q2) + const.W2 * abs(w))
    dg = dq + room[ERROR] + room[SIZE + 1] * dtheta + ROOM * abs(c)
    du = dw + room[ERROR + 1] + room[SIZE + 2] * dtheta + ROOM * abs(c1)
    da = dq2 + room[ERROR + 2] + room[SIZE + 3] * dtheta + ROOM * abs(c2)
    djerk = dq3 + room[ERROR + 3] + room[SIZE + 4] * dtheta + ROOM * abs(c3)
    return Gap(
        q - c, SPARE * dg, w - c1, SPARE * du, q2 - c2, SPARE * da,
        -2.0 * const.Z * q2 - const.W2 * w - c3, SPARE * djerk, b, b1, dflow,
    )  # fmt: skip


@inlined
def _stays_above(g, u, a, jerk, h):
    """True where a gap with at least these derivatives is above zero up to h rad later.

    It is at least g + h k(h), see the module; jerk: M. A gap that begins at zero or below has to
    rise throughout.
    """
    least = min(u, u + h * (0.5 * a - jerk * h / 6.0))
    if g > 0.0:
        return g + h * min(0.0, SPARE * least) > 0.0
    return least > 0.0


@outlined
def _sharpened(cam, const, room, leap, i, wraps, low, high):
    """Enclose the only zero of the gap between low, where it is above zero or left, and high.

    Newton's method, with the curvature, begins at room[ANGLE], rad after the start. Around the
    phase s that it comes to, the gap off by `off` has to cross zero within ds: its rate is no
    smaller than `slowest` there. What is found is written into `room`: ENCLOSED, or UNDECIDED.
    """
    s = room[ANGLE]
    stretch = cam.stretches[i]
    jerk = _jerk_bound(cam, room, leap, i)
    gap = _gap_after(cam, const, room, leap, i, wraps, s)
    for _ in range(NEWTON_STEPS):
        if not gap.u < 0.0:
            return UNDECIDED
        step = -gap.g / gap.u
        step -= 0.5 * step * step * gap.a / gap.u
        if abs(step) <= 4.0 * ULP * s:
            break
        s += step
        if not low < s < high:
            return UNDECIDED
        gap = _gap_after(cam, const, room, leap, i, wraps, s)
    if not gap.u < 0.0:
        return UNDECIDED
    off = SPARE * (abs(gap.g) + gap.dg)
    ds = 2.0 * off / -gap.u
    accel_bound = abs(gap.a) + gap.da + jerk * ds
    slowest = -gap.u - gap.du - accel_bound * ds
    if not (slowest > 0.0 and SPARE * off <= ds * slowest and ds <= COARSEST * s):
        return UNDECIDED
    phase = (leap.theta + s) - TURN * wraps
    edge = ds + SPARE * (leap.dtheta + 16.0 * ULP * (leap.theta + s + TURN * (wraps + 1.0)))
    inside = stretch.start + edge < phase < stretch.end - edge
    if not (inside and low < s - ds and s + ds < high):
        return UNDECIDED
    snap = (2.0 * const.Z + const.W) * leap.energy + stretch.snap_max + room[ERROR + 4]
    jerk_at_landing = abs(gap.jerk) + gap.djerk + snap * ds
    _put(room, ANGLE, s, ds)
    _put(room, U, gap.u, SPARE * (gap.du + accel_bound * ds))
    _put(room, ACCEL, gap.a, SPARE * (gap.da + jerk_at_landing * ds))
    _put(room, JERK, gap.jerk, SPARE * (gap.djerk + snap * ds))
    room[SNAP] = SPARE * snap
    room[PHASE] = phase
    room[WRAPS] = wraps
    room[SLIVER] = edge
    _derivatives(const, restitution_at(cam, const, i), leap, gap, ds, room)
    return ENCLOSED


@inlined
def _derivatives(const, r, leap, gap, ds, room):
    """d(angle, rate after) / d(angle, rate before), of the angle and of the rate off the cam.

    At equal phase a start (dphi, drate) beside is a difference (dq, dw) = (-rate dphi, drate + fall
    dphi), which the flight multiplies by [[B' + 2 Z B, B], [-W^2 B, B']]. It lands at dphi = -dq/u
    later, its u different by dw + gap'' dphi. The four entries, J11 to J22, are written into
    `room`. ds: the radius of the flight's length; r: the restitution where it lands.
    """
    s = room[ANGLE]
    u = room[U]
    du = room[U + 1]
    accel = Ball(room[ACCEL], room[ACCEL + 1])
    db = SPARE * (gap.dflow * s + ds)
    db1 = SPARE * (gap.dflow + (2.0 * const.Z + const.W2 * s) * ds)
    damp = 2.0 * const.Z
    q_by_q = Ball(gap.b1 + damp * gap.b, SPARE * (db1 + damp * db) + ROOM * (1.0 + damp * s))
    w_by_q = Ball(-const.W2 * gap.b, SPARE * const.W2 * (db + ROOM * s))
    b = Ball(gap.b, db)  # q by w
    b1 = Ball(gap.b1, db1)  # w by w
    dq_start = Ball(-leap.rate, leap.drate)  # by the angle of the start
    dw_start = Ball(leap.fall, leap.dfall)
    q_by_angle = _plus(_times(q_by_q, dq_start), _times(b, dw_start))
    w_by_angle = _plus(_times(w_by_q, dq_start), _times(b1, dw_start))
    inverse = -1.0 / u
    dinverse = SPARE * du / (abs(u) * (abs(u) - du)) + 2.0 * ULP * abs(inverse)
    later = Ball(inverse, dinverse)
    angle_by_angle = _times(q_by_angle, later)
    angle_by_rate = _times(b, later)
    rate_by_angle = _rate_after(r, _times(accel, angle_by_angle), w_by_angle)
    rate_by_rate = _rate_after(r, _times(accel, angle_by_rate), b1)
    _put(room, J11, angle_by_angle.middle, angle_by_angle.radius)
    _put(room, J12, angle_by_rate.middle, angle_by_rate.radius)
    _put(room, J21, rate_by_angle.middle, rate_by_angle.radius)
    _put(room, J22, rate_by_rate.middle, rate_by_rate.radius)


@inlined
def _rate_after(r, by_landing, by_flight):
    """-r (by_landing + by_flight): how much the rate after an impact changes, a ball."""
    middle = -r * (by_landing.middle + by_flight.middle)
    rounding = 4.0 * ULP * (abs(by_landing.middle) + abs(by_flight.middle))
    radius = SPARE * (r * (by_landing.radius + by_flight.radius) + rounding)
    return Ball(middle, radius)


@entry
def enclose_landing(cam, room):
    """Enclose the first landing of a flight that leaves the cam: ENCLOSED or UNDECIDED.

    room: a column as named above, which is read and written.
    """
    const = constants_of(room, NO_CHATTER_MAP, 0)
    theta = room[THETA]
    if not (0.0 <= theta < TURN and const.Z >= 0.0 and const.W2 >= 0.0):
        return UNDECIDED
    i = stretch_at(cam, theta)
    leap = _leap(cam, const, room, i)
    edge = leap.dtheta + 16.0 * ULP * TURN
    to_end = cam.stretches[i].end - theta
    if not (theta - cam.stretches[i].start > edge and to_end > edge):
        return UNDECIDED
    if not leap.rate - leap.drate > 0.0:
        return UNDECIDED
    hop = to_end
    if leap.fall > leap.dfall:  # where it is concave up to the landing, there is one zero only
        hop = HOP * leap.rate / leap.fall
        jerk = _jerk_bound(cam, room, leap, i)
        is_concave = hop < to_end - edge and leap.dfall + jerk * hop < leap.fall
        if is_concave and _is_below(_gap_after(cam, const, room, leap, i, 0.0, hop)):
            room[ANGLE] = 0.8 * hop
            return _sharpened(cam, const, room, leap, i, 0.0, 0.0, hop)
    return _follow(cam, const, room, leap, i, min(hop, to_end), edge)


@inlined
def _jerk_bound(cam, room, leap, i):
    """M, a bound on |gap'''| over stretch i."""
    return SPARE * (leap.energy + cam.stretches[i].jerk_max + room[ERROR + 3])


@inlined
def _is_below(gap):
    """True where the gap is certainly below zero."""
    return gap.g + gap.dg < 0.0


@inlined
def _follow(cam, const, room, leap, i, h, edge):
    """`enclose_landing` in steps, each of which leaves the gap above zero.

    h: the first step to be tried, rad; edge: how far from the end of a stretch, rad, a phase is
    certainly in it. At the end of a stretch the follower has to be so high that it does not matter
    where exactly the next one begins.
    """
    theta = room[THETA]
    wraps = 0.0  # times past 2 pi
    to_end = cam.stretches[i].end - theta  # of stretch i, rad from the start of the flight
    jerk = _jerk_bound(cam, room, leap, i)
    # after s rad the gap and its derivatives are at least these
    s = 0.0
    g = 0.0
    u = leap.rate - leap.drate
    a = -leap.fall - leap.dfall
    for _ in range(MOST_STEPS):
        h = _certain_step(g, u, a, jerk, h)
        if h < 0.0:
            return UNDECIDED
        ends = s + h >= to_end
        s = to_end if ends else s + h
        if (const.W + const.Z) * s > LONGEST:
            return UNDECIDED
        gap = _gap_after(cam, const, room, leap, i, wraps, s)
        if ends:
            fastest = abs(leap.w) + s * leap.pull + leap.dw + room[SIZE + 1]
            edge = leap.dtheta + 16.0 * ULP * (leap.theta + s + TURN * (wraps + 2.0))
            if not gap.g - gap.dg > 8.0 * fastest * edge:
                return UNDECIDED
            i += 1
            if i == len(cam.stretches):
                i = 0
                wraps += 1.0
            to_end = (cam.stretches[i].end - theta) + TURN * wraps
            jerk = _jerk_bound(cam, room, leap, i)
            gap = _gap_after(cam, const, room, leap, i, wraps, s)
        g = gap.g - gap.dg
        u = gap.u - gap.du
        a = gap.a - gap.da
        if not g > 0.0:
            return UNDECIDED
        h = to_end - s
        fall = _certain_fall(gap, jerk, h - edge)
        if fall > 0.0 and _is_below(_gap_after(cam, const, room, leap, i, wraps, s + fall)):
            room[ANGLE] = s + gap.g / -gap.u
            return _sharpened(cam, const, room, leap, i, wraps, s, s + fall)
    return UNDECIDED


@inlined
def _certain_step(g, u, a, jerk, h):
    """h, halved until a gap with at least these derivatives stays above zero over it; else -1."""
    for _ in range(MOST_HALVINGS):
        if _stays_above(g, u, a, jerk, h):
            return h
        h *= 0.5
    return -1.0


@inlined
def _certain_fall(gap, jerk, most):
    """A length below `most`, rad, over which the gap certainly falls; -1 where none is found.

    It is twice what the gap needs to come down at its present rate.
    """
    rate = gap.u + gap.du
    if not rate < 0.0:
        return -1.0
    accel = max(gap.a + gap.da, 0.0)
    fall = 2.0 * (gap.g + gap.dg) / -rate
    if fall < most and rate + fall * (accel + 0.5 * jerk * fall) < 0.0:
        return fall
    return -1.0
