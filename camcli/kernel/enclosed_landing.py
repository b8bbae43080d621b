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
    """A flight from its start, and what bounds its errors."""

    theta: float
    q: float
    w: float
    force: float  # F
    pull: float  # |G| + W^2 |q|
    rate: float
    fall: float  # -gap''
    energy: float  # E
    dtheta: float  # radii of the start
    drate: float
    dq: float
    dw: float
    dfall: float


class Gap(NamedTuple):
    """The gap after some flight, its first three derivatives, and the radius of each."""

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
    dflow: float  # relative to 1 of B', to s of B


@inlined
def _times(a, da, b, db):
    """Product of two numbers with radii."""
    c = a * b
    return c, SPARE * (abs(a) * db + da * abs(b) + da * db) + 2.0 * ULP * abs(c)


@inlined
def _leap(cam, const, room, i):
    """The flight that begins on the cam."""
    theta, rate = room[THETA], room[RATE]
    dtheta = room[THETA_RADIUS] + 4.0 * ULP * TURN
    c, c1, c2 = lift_at(cam, i, theta)
    q, w = c, c1 + rate
    drate = room[RATE_RADIUS]
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
    """The gap to stretch i after s rad, `wraps` times past 2 pi, and its derivatives."""
    stretch = cam.stretches[i]
    at = min(max((leap.theta + s) - TURN * wraps, stretch.start), stretch.end)
    dat = SPARE * (leap.dtheta + 8.0 * ULP * (leap.theta + s + TURN * (wraps + 1.0)))
    c, c1, c2 = lift_at(cam, i, at)
    c3 = derivative(cam, 3, i, at)
    b, b1, p = flow(const, s)
    q = leap.q + (leap.w * b - leap.force * p)
    w = leap.w * b1 - leap.force * b
    y = -const.G - const.W2 * q - 2.0 * const.Z * w
    flown = ROOM * (1.0 + (const.W + const.Z) * s)
    dq = leap.dq + s * leap.dw + flown * (abs(leap.q) + s * (abs(leap.w) + s * leap.pull))
    turned = min(const.W, const.W2 * s)
    dw = turned * leap.dq + leap.dw + flown * (abs(leap.w) + s * leap.pull)
    dy = const.W2 * dq + 2.0 * const.Z * dw
    dy += ROOM * (abs(const.G) + const.W2 * abs(q) + 2.0 * const.Z * abs(w))
    dz = 2.0 * const.Z * dy + const.W2 * dw
    dz += ROOM * (2.0 * const.Z * abs(y) + const.W2 * abs(w))
    dg = dq + room[ERROR] + room[SIZE + 1] * dat + ROOM * abs(c)
    du = dw + room[ERROR + 1] + room[SIZE + 2] * dat + ROOM * abs(c1)
    da = dy + room[ERROR + 2] + room[SIZE + 3] * dat + ROOM * abs(c2)
    djerk = dz + room[ERROR + 3] + room[SIZE + 4] * dat + ROOM * abs(c3)
    return Gap(
        q - c, SPARE * dg, w - c1, SPARE * du, y - c2, SPARE * da,
        -2.0 * const.Z * y - const.W2 * w - c3, SPARE * djerk, b, b1, flown,
    )  # fmt: skip


@inlined
def _stays_above(g, u, a, jerk, h):
    """True where a gap of at least g with such slopes is above zero up to h rad later."""
    least = min(u, u + h * (0.5 * a - jerk * h / 6.0))
    if g > 0.0:
        return g + h * min(0.0, SPARE * least) > 0.0
    return least > 0.0


@outlined
def _sharpened(cam, const, room, leap, i, wraps, low, high):
    """Enclose the only zero of the gap between low, where it is above zero or left, and high."""
    s = room[ANGLE]
    stretch = cam.stretches[i]
    jerk = SPARE * (leap.energy + stretch.jerk_max + room[ERROR + 3])
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
    bend = abs(gap.a) + gap.da + jerk * ds
    slowest = -gap.u - gap.du - bend * ds
    if not (slowest > 0.0 and SPARE * off <= ds * slowest and ds <= COARSEST * s):
        return UNDECIDED
    phase = (leap.theta + s) - TURN * wraps
    edge = ds + SPARE * (leap.dtheta + 16.0 * ULP * (leap.theta + s + TURN * (wraps + 1.0)))
    inside = stretch.start + edge < phase < stretch.end - edge
    if not (inside and low < s - ds and s + ds < high):
        return UNDECIDED
    snap = (2.0 * const.Z + const.W) * leap.energy + stretch.snap_max + room[ERROR + 4]
    room[ANGLE] = s
    room[ANGLE + 1] = ds
    room[U] = gap.u
    room[U + 1] = SPARE * (gap.du + bend * ds)
    room[ACCEL] = gap.a
    room[ACCEL + 1] = SPARE * (gap.da + (abs(gap.jerk) + gap.djerk + snap * ds) * ds)
    room[JERK] = gap.jerk
    room[JERK + 1] = SPARE * (gap.djerk + snap * ds)
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
    dphi). It lands at dphi = -dq/u later, its u different by dw + gap'' dphi.
    """
    s = room[ANGLE]
    u, du = room[U], room[U + 1]
    a, da = room[ACCEL], room[ACCEL + 1]
    db = SPARE * (gap.dflow * s + ds)
    db1 = SPARE * (gap.dflow + (2.0 * const.Z + const.W2 * s) * ds)
    damp = 2.0 * const.Z
    x, dx = gap.b1 + damp * gap.b, SPARE * (db1 + damp * db) + ROOM * (1.0 + damp * s)
    y, dy = -const.W2 * gap.b, SPARE * const.W2 * (db + ROOM * s)
    rate, drate = -leap.rate, leap.drate
    m, dm = _times(x, dx, rate, drate)
    n, dn = _times(gap.b, db, leap.fall, leap.dfall)
    q1, dq1 = m + n, SPARE * (dm + dn) + ULP * (abs(m) + abs(n))
    q2, dq2 = gap.b, db
    m, dm = _times(y, dy, rate, drate)
    n, dn = _times(gap.b1, db1, leap.fall, leap.dfall)
    w1, dw1 = m + n, SPARE * (dm + dn) + ULP * (abs(m) + abs(n))
    w2, dw2 = gap.b1, db1
    inverse = -1.0 / u
    dinverse = SPARE * du / (abs(u) * (abs(u) - du)) + 2.0 * ULP * abs(inverse)
    j11, dj11 = _times(q1, dq1, inverse, dinverse)
    j12, dj12 = _times(q2, dq2, inverse, dinverse)
    room[J11] = j11
    room[J11 + 1] = dj11
    room[J12] = j12
    room[J12 + 1] = dj12
    m, dm = _times(a, da, j11, dj11)
    room[J21] = -r * (m + w1)
    room[J21 + 1] = SPARE * (r * (dm + dw1) + 4.0 * ULP * (abs(m) + abs(w1)))
    m, dm = _times(a, da, j12, dj12)
    room[J22] = -r * (m + w2)
    room[J22 + 1] = SPARE * (r * (dm + dw2) + 4.0 * ULP * (abs(m) + abs(w2)))


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
    lasts = cam.stretches[i].end - theta
    if not (theta - cam.stretches[i].start > edge and lasts > edge):
        return UNDECIDED
    slowest = leap.rate - leap.drate
    if not slowest > 0.0:
        return UNDECIDED
    jerk = SPARE * (leap.energy + cam.stretches[i].jerk_max + room[ERROR + 3])
    hop = lasts
    if leap.fall > leap.dfall:  # concave up to the landing: there is one zero and no other
        hop = HOP * leap.rate / leap.fall
        if hop < lasts - edge and leap.dfall + jerk * hop < leap.fall:
            gap = _gap_after(cam, const, room, leap, i, 0.0, hop)
            if gap.g + gap.dg < 0.0:
                room[ANGLE] = 0.8 * hop
                return _sharpened(cam, const, room, leap, i, 0.0, 0.0, hop)
    wraps = 0.0
    s, g, u, a = 0.0, 0.0, slowest, -leap.fall - leap.dfall
    h = min(hop, lasts)
    for _ in range(MOST_STEPS):
        for _ in range(MOST_HALVINGS):
            if _stays_above(g, u, a, jerk, h):
                break
            h *= 0.5
        else:
            return UNDECIDED
        ends = s + h >= lasts
        s = lasts if ends else s + h
        if (const.W + const.Z) * s > LONGEST:
            return UNDECIDED
        gap = _gap_after(cam, const, room, leap, i, wraps, s)
        g, u, a = gap.g - gap.dg, gap.u - gap.du, gap.a - gap.da
        if ends:
            fastest = abs(leap.w) + s * leap.pull + leap.dw + room[SIZE + 1]
            edge = leap.dtheta + 16.0 * ULP * (leap.theta + s + TURN * (wraps + 2.0))
            if not g > 8.0 * fastest * edge:
                return UNDECIDED
            i += 1
            if i == len(cam.stretches):
                i = 0
                wraps += 1.0
            lasts = (cam.stretches[i].end - theta) + TURN * wraps
            jerk = SPARE * (leap.energy + cam.stretches[i].jerk_max + room[ERROR + 3])
            gap = _gap_after(cam, const, room, leap, i, wraps, s)
            g, u, a = gap.g - gap.dg, gap.u - gap.du, gap.a - gap.da
        if not g > 0.0:
            return UNDECIDED
        h = lasts - s
        top, bend = gap.u + gap.du, max(gap.a + gap.da, 0.0)
        if top < 0.0:
            fall = 2.0 * (gap.g + gap.dg) / -top
            if fall < h - edge and top + fall * (bend + 0.5 * jerk * fall) < 0.0:
                after = _gap_after(cam, const, room, leap, i, wraps, s + fall)
                if after.g + after.dg < 0.0:
                    room[ANGLE] = s + gap.g / -gap.u
                    return _sharpened(cam, const, room, leap, i, wraps, s, s + fall)
    return UNDECIDED
