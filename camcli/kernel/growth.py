"""Lyapunov exponents of an orbit from its logged impacts: what two small differences grow to.

Between two impacts a difference is carried by the flight's matrix, at an impact by the saltation
matrix (`tangent`); after each the pair is made orthogonal again (Benettin et al., Meccanica 15
(1980) 9). The lengths multiply up; powers of two are split off so that no logarithm, and with it
no library's rounding, is needed on the way. A complete chatter maps every difference to zero.
"""

from math import sqrt

from camcli.kernel.cam_table import ROW, START, TURN, lift_at, stretch_at
from camcli.kernel.marks import inlined, outlined
from camcli.kernel.orbit_loop import CHATTER, IMPACT
from camcli.kernel.variational import after_flight, after_impact

QQ, QW, WQ, WW, THETA, PERIOD, SEEN = range(7)  # entries of `pair`
FIRST, FIRST_TWOS, AREA, AREA_TWOS, COUNT, LENGTH, ZEROS = range(7)  # entries of `growth`
LARGE, SMALL = 1.8446744073709552e19, 5.421010862427522e-20  # 2^64 and its inverse
LN2 = 0.6931471805599453


@inlined
def stretch_log(cam, lane, whole, real, rows, pair, growth):
    """Carry the pair through `rows` logged events; lengths and area multiply into `growth`.

    pair: the two differences as columns, and where the last impact was (SEEN is 0 before the
    first); growth: factor and power of 2^64 for the first difference and for the area, impacts and
    turns in between, and the number of complete chatters.
    """
    for n in range(rows):
        kind = whole[2 * n]
        theta = real[3 * n]
        if kind == CHATTER:
            growth[ZEROS] += 1.0
            pair[SEEN] = 0.0
        elif kind == IMPACT:
            if pair[SEEN] == 0.0:
                pair[QQ], pair[QW], pair[WQ], pair[WW] = 1.0, 0.0, 0.0, 1.0
            else:
                _carry(cam, lane, theta, whole[2 * n + 1], real[3 * n + 2], pair, growth)
            pair[SEEN], pair[THETA], pair[PERIOD] = 1.0, theta, float(whole[2 * n + 1])


@inlined
def _carry(cam, lane, theta, period, u, pair, growth):
    """The flight to the impact at theta, the impact, and a new orthogonal pair.

    Periods begin at the strobe, so the turn between two phases is counted from there.
    """
    strobe = cam.rows[cam.strobe * ROW + START]
    since = theta - strobe + (TURN if theta < strobe else 0.0)
    before = pair[THETA] - strobe + (TURN if pair[THETA] < strobe else 0.0)
    s = (since - before) + TURN * (period - pair[PERIOD])
    lifts = lift_at(cam, stretch_at(cam, theta), theta)
    qq, qw, wq, ww = after_flight(lane, s, pair[QQ], pair[QW], pair[WQ], pair[WW])
    qq, qw, wq, ww = after_impact(lane, lifts, u, qq, qw, wq, ww)
    length = sqrt(qq * qq + wq * wq)
    area = qq * ww - qw * wq
    if area < 0.0:
        area = -area
    _multiply(growth, FIRST, length)
    _multiply(growth, AREA, area)
    growth[COUNT] += 1.0
    growth[LENGTH] += s
    pair[QQ], pair[WQ] = qq / length, wq / length
    pair[QW], pair[WW] = -wq / length, qq / length


@inlined
def _multiply(growth, k, factor):
    """growth[k] times factor, with powers of 2^64 counted in growth[k + 1]."""
    value = growth[k] * factor
    while value > LARGE:
        value *= SMALL
        growth[k + 1] += 1.0
    while 0.0 < value < SMALL:
        value *= LARGE
        growth[k + 1] -= 1.0
    growth[k] = value


@outlined
def natural_log(x):
    """ln x for x > 0 to about 1 ulp, by 2 atanh((x - 1)/(x + 1)) of x/2^n in [0.7, 1.5)."""
    twos = 0
    while x >= 1.5:
        x *= 0.5
        twos += 1
    while x < 0.7:
        x *= 2.0
        twos -= 1
    z = (x - 1.0) / (x + 1.0)
    y = z * z
    total = 0.0
    for k in range(23, 0, -2):
        total = total * y + 1.0 / k
    return 2.0 * z * total + twos * LN2


@inlined
def log_growth(growth, k):
    """Logarithm of a factor of `growth` with its powers."""
    return natural_log(growth[k]) + growth[k + 1] * (64.0 * LN2)
