"""What happens to a small difference between two orbits, and what it grows to.

A difference (dq, dw) at equal theta, w = dq/dtheta, is carried by a flight of s rad by
    [[1 - W^2 P, B], [-W^2 B, B']],              determinant exp(-2 Z s),
and by an impact with relative rate u < 0 by the saltation matrix (Aizerman & Gantmakher 1958;
Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, chapter 7)
    [[-r, 0], [(r a- + a+)/u, -r]],              determinant r^2,
with the relative accelerations a = q'' - c_thetatheta just before and after, and r that of the
stretch. While the follower rests on the cam its state is the cam's: a sticking phase, and with it a
complete chatter, maps every difference to zero.

Lyapunov exponents: after each impact the pair of differences is made orthogonal again (Benettin et
al., Meccanica 15 (1980) 9). The lengths multiply up; powers of 2^64 are split off, so that no
logarithm, and with it no rounding, is needed on the way.
"""

from dataclasses import dataclass
from math import sqrt

from camcli.kernel.arithmetic import LN2, natural_log
from camcli.kernel.cam_table import TURN, lift_at, restitution_at, stretch_at
from camcli.kernel.flow import flow
from camcli.kernel.marks import entry, inlined
from camcli.kernel.orbit_loop import CHATTER, IMPACT

LARGE, SMALL = 1.8446744073709552e19, 5.421010862427522e-20  # 2^64 and its inverse


@dataclass(slots=True)
class Pair:
    """Two differences just after an impact, (qq, wq) and (qw, ww), each a (dq, dw)."""

    qq: float = 1.0
    qw: float = 0.0
    wq: float = 0.0
    ww: float = 1.0
    theta: float = 0.0  # of the impact
    period: int = 0
    seen: int = 0  # 0 before the first impact, and after a complete chatter


@dataclass(slots=True)
class Growth:
    """What a stretch of a log did to a pair; a factor is value * 2^(64 twos)."""

    first: float = 1.0  # factor of the first difference's length
    first_twos: int = 0
    area: float = 1.0  # factor of the area between the two
    area_twos: int = 0
    impacts: int = 0
    length: float = 0.0  # rad of flight
    chatters: int = 0  # complete ones: they map every difference to zero
    first_log: float = 0.0  # logarithms of the two factors, 0 where a factor is none
    area_log: float = 0.0


@inlined
def flight_tangent(const, s):
    """(qq, qw, wq, ww), the matrix of a flight of s rad."""
    b, b1, p = flow(const, s)
    return 1.0 - const.W2 * p, b, -const.W2 * b, b1


@inlined
def gap_accel(const, c, w, c2):
    """q'' - c_thetatheta on the cam at height c with velocity w (m/rad)."""
    return -(const.G + const.W2 * c) - 2.0 * const.Z * w - c2


@inlined
def saltation_entry(const, r, lifts, u):
    """Lower left entry of the saltation matrix of an impact with relative rate u < 0.

    lifts: (c, c_theta, c_thetatheta) at the contact; at a corner the caller chooses the side.
    """
    c, c1, c2 = lifts
    before = gap_accel(const, c, c1 + u, c2)
    after = gap_accel(const, c, c1 - r * u, c2)
    return (r * before + after) / u


@inlined
def after_flight(const, s, qq, qw, wq, ww):
    """The flight's matrix times [[qq, qw], [wq, ww]]."""
    a, b, c, d = flight_tangent(const, s)
    return a * qq + b * wq, a * qw + b * ww, c * qq + d * wq, c * qw + d * ww


@inlined
def after_impact(const, r, lifts, u, qq, qw, wq, ww):
    """The impact's saltation matrix times [[qq, qw], [wq, ww]]."""
    s = saltation_entry(const, r, lifts, u)
    return -r * qq, -r * qw, s * qq - r * wq, s * qw - r * ww


@entry
def stretch_events(cam, const, kind, period, theta, u, pairs, growths):
    """Carry pairs[0] through logged events; lengths and area multiply into the growths.

    kind, period, theta, u: columns of the events. pairs: a table of one `Pair`. growths: a table of
    `Growth`; growths[k] is of the k-th of as many equal parts of the events, and what is left over
    belongs to the last. The logarithms of all factors are renewed at the end.
    """
    pair = pairs[0]
    size = len(kind) // len(growths)
    for n in range(len(kind)):
        growth = growths[min(n // size, len(growths) - 1) if size > 0 else 0]
        if kind[n] == CHATTER:
            growth.chatters += 1
            pair.seen = 0
        elif kind[n] == IMPACT:
            if pair.seen == 0:
                pair.qq, pair.qw, pair.wq, pair.ww = 1.0, 0.0, 0.0, 1.0
            else:
                _carry(cam, const, theta[n], period[n], u[n], pair, growth)
            pair.seen = 1
            pair.theta = theta[n]
            pair.period = period[n]
    for k in range(len(growths)):
        growth = growths[k]
        growth.first_log = log_factor(growth.first, growth.first_twos)
        growth.area_log = log_factor(growth.area, growth.area_twos)


@inlined
def _carry(cam, const, theta, period, u, pair, growth):
    """Carry a pair of differences on: the flight to the impact at theta, the impact, a new pair.

    What the first difference's length and the area between both are multiplied by goes into
    `growth`. The new pair is orthogonal, its lengths 1, the first one in the first one's direction.
    Periods begin at the strobe, so the turn between two phases is counted from there.
    """
    strobe = cam.stretches[cam.strobe].start
    since_strobe = theta - strobe + (TURN if theta < strobe else 0.0)
    since_strobe_before = pair.theta - strobe + (TURN if pair.theta < strobe else 0.0)
    s = (since_strobe - since_strobe_before) + TURN * (period - pair.period)
    i = stretch_at(cam, theta)
    lifts = lift_at(cam, i, theta)
    r = restitution_at(cam, const, i)
    qq, qw, wq, ww = after_flight(const, s, pair.qq, pair.qw, pair.wq, pair.ww)
    qq, qw, wq, ww = after_impact(const, r, lifts, u, qq, qw, wq, ww)
    length = sqrt(qq * qq + wq * wq)
    area = qq * ww - qw * wq
    if area < 0.0:
        area = -area
    growth.first, twos = _normed(growth.first * length)
    growth.first_twos += twos
    growth.area, twos = _normed(growth.area * area)
    growth.area_twos += twos
    growth.impacts += 1
    growth.length += s
    pair.qq = qq / length
    pair.wq = wq / length
    pair.qw = -wq / length
    pair.ww = qq / length


@inlined
def _normed(value):
    """(value * 2^(-64 twos), twos) with the product between 2^-64 and 2^64, or zero."""
    twos = 0
    while value > LARGE:
        value *= SMALL
        twos += 1
    while 0.0 < value < SMALL:
        value *= LARGE
        twos -= 1
    return value, twos


@inlined
def log_factor(value, twos):
    """Logarithm of a factor of `Growth`, 0 for one that is zero."""
    if not value > 0.0:
        return 0.0
    return natural_log(value) + twos * (64.0 * LN2)
