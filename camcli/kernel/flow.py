"""The closed-form free flight, for every damping, with gravity and preload.

With theta as the variable the follower in flight obeys
    q'' + 2 Z q' + W^2 q = -G,   W = omega0/omega, Z = zeta/omega, G = (g + F0/m)/omega^2.
From (q0, w0) at s = 0, with F = G + W^2 q0,
    q(s) = q0 + w0 B(s) - F P(s),    w(s) = w0 B'(s) - F B(s),
where B solves the homogeneous equation with B(0) = 0, B'(0) = 1 and P is its integral
(P'' + 2 Z P' + W^2 P = 1, P(0) = P'(0) = 0). This form needs no equilibrium position, so it
holds for stiffness 0 (the bouncing ball) and keeps q(s) - q0 relatively exact.

Where a double is too short, a number is the sum of two: x, and x_rest, which x leaves out.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from camcli.kernel.arithmetic import (
    cos_sin_series,
    exp_decay,
    one_minus_exp_ratio,
    product_rest,
    sincos,
    sine_versine,
    sum_rest,
)
from camcli.kernel.cam_table import TURN
from camcli.kernel.marks import entry, inlined, outlined

SERIES_LIMIT = 2.5  # largest |D s^2| that one series covers
SLOW = 1e-3  # W below which `flow` is as exact, and the equilibrium may be far away
SHORT = 3.0  # largest 2 Z s + W^2 s^2 of the Taylor series of P


class Constants(NamedTuple):
    """Dimensionless constants of one orbit; `W` to `G` per radian of cam angle."""

    W: float  # omega0 / omega
    W2: float  # W squared
    Z: float  # zeta / omega
    D: float  # Z^2 - W^2, computed as (Z - W)(Z + W)
    G: float  # (gravity + preload/mass) / omega^2, m/rad^2
    r: float  # restitution on the cam
    tolerance: float  # chatter tolerance, rad
    impact_budget: int  # impacts in one period
    W_rest: float = 0.0  # relative: omega0/omega is W (1 + W_rest)
    r_seat: float = 0.0  # restitution on the seat


@dataclass(slots=True)
class Flow:
    """`flow` over whole stretches, a row of the table of `fill_flows`."""

    b: float = 0.0
    b1: float = 0.0
    p: float = 0.0


# Entries of a machine's table: SI, rpm. Any of them may be a bifurcation parameter.
RPM, MASS, STIFFNESS, DAMPING, GRAVITY, PRELOAD, RESTITUTION, SEAT_RESTITUTION = range(8)
AS_ON_THE_CAM = -1.0  # entry SEAT_RESTITUTION: that of the cam
RAD_PER_S = 0.10471975511965977  # pi/30 in doubles, rad/s per rpm
RAD_PER_S_REST = 8.70808526642933e-18  # what it leaves out


@inlined
def constants_of(machine, tolerance, impact_budget):
    """The constants of one orbit; `machine` is indexed as above, tolerance in rad."""
    omega = machine[RPM] * RAD_PER_S
    mass = machine[MASS]
    W = sqrt(machine[STIFFNESS] / mass) / omega
    Z = machine[DAMPING] / (2.0 * mass) / omega
    G = (machine[GRAVITY] + machine[PRELOAD] / mass) / omega / omega
    W_rest = _rest_of_frequency(machine[RPM], omega, machine[STIFFNESS], mass, W)
    r = machine[RESTITUTION]
    r_seat = machine[SEAT_RESTITUTION]
    if r_seat < 0.0:
        r_seat = r
    return Constants(W, W * W, Z, (Z - W) * (Z + W), G, r, tolerance, impact_budget, W_rest, r_seat)


@inlined
def _rest_of_frequency(rpm, omega, stiffness, mass, W):
    """The rounding of W, relative to it: omega0/omega = W (1 + this), to first order.

    W is sqrt(stiffness/mass) / (rpm pi/30) in doubles, and each of its operations leaves something
    out. All landings of an orbit would be off in the same direction by it.
    """
    if not W > 0.0:
        return 0.0
    ratio = stiffness / mass
    omega0 = sqrt(ratio)
    rest = -product_rest(ratio, mass, stiffness) / stiffness
    rest -= product_rest(omega0, omega0, ratio) / ratio
    rest = 0.5 * rest - product_rest(W, omega, omega0) / omega0
    rest -= (product_rest(rpm, RAD_PER_S, omega) + rpm * RAD_PER_S_REST) / omega
    return rest if abs(rest) < 1e-14 else 0.0  # an under- or overflow


@inlined
def flow(const, s):
    """(B, B', P) after s >= 0 rad of flight; see the module's equations."""
    if const.Z == 0.0:
        return _flow_undamped(const.W, const.W2, s)
    return _flow_damped(const, s)


@inlined
def _flow_undamped(W, W2, s):
    """`flow` without damping: B = sin(W s)/W, B' = cos(W s), P = (1 - cos(W s))/W^2.

    W, W2: natural frequency and its square, per rad of the cam. Where the angle is short, and 1 -
    cos would cancel, they come from series in -(W s)^2 (`cos_sin_series`), which take W = 0 too.
    """
    t = -W2 * s * s
    if t >= -SERIES_LIMIT:
        v, b = cos_sin_series(t)
        return s * b, 1.0 + t * v, s * s * v
    sine, cosine = sincos(W * s)
    return sine / W, cosine, (1.0 - cosine) / W2


@outlined
def _flow_damped(const, s):
    """`flow` with damping: underdamped, critical or overdamped by the sign of D = Z^2 - W^2.

    With C and S the cosine and sine of sqrt(-D) s, hyperbolic where D > 0,
        B = exp(-Z s) S/sqrt(|D|),    B' = exp(-Z s) C - Z B,    P = (1 - exp(-Z s) C - Z B)/W^2.
    Where this would cancel, at short angles and far overdamped, other formulas take over.
    """
    zs = const.Z * s
    ws2 = const.W2 * s * s
    if 2.0 * zs + ws2 <= SHORT:
        return _flow_short(const, s)
    t = const.D * s * s
    if t > SERIES_LIMIT or (t > 0.05 and ws2 < 0.25):  # (1 - position)/W2 would cancel
        return _flow_overdamped(const, s)
    decay = exp_decay(zs)
    if t >= -SERIES_LIMIT:
        v, b = cos_sin_series(t)
        c = 1.0 + t * v
        b = s * b
    else:
        frequency = sqrt(-const.D)
        sine, c = sincos(frequency * s)
        b = sine / frequency
    position = decay * (c + const.Z * b)
    return decay * b, decay * (c - const.Z * b), (1.0 - position) / const.W2


@outlined
def _flow_short(const, s):
    """Taylor series of P by its own differential equation: no cancellation for short s.

    P = (s^2/2) sum T_n, n = 2, 3, ...: T_2 = 1, and from P'' + 2 Z P' + W^2 P = 1
        T_n = -(2 Z s T_{n-1} + W^2 s^2 T_{n-2}/(n - 1))/n.
    B = P' has n T_n in the sum, over s, and B' = P'' has n (n - 1) T_n, over s^2.
    """
    zs = 2.0 * const.Z * s
    ws2 = const.W2 * s * s
    before = 0.0  # T_{n-2}
    term = 1.0  # T_{n-1}
    share_before = 0.5  # 1/(n - 1)
    b = 1.0
    b1 = 1.0
    p = 1.0
    for n in range(3, 33):
        share = 1.0 / n
        after = -(zs * term + ws2 * before * share_before) * share
        before = term
        term = after
        share_before = share
        p += term
        b += 0.5 * n * term
        b1 += 0.5 * n * (n - 1) * term
        if abs(term) + abs(before) <= 1e-20:
            break
    return b * s, b1, 0.5 * p * s * s


@outlined
def _flow_overdamped(const, s):
    """`flow` from two real exponentials, which decay at the rates Z + d and Z - d, d = sqrt(D).

    With E(x) = (1 - exp(-x))/x,
        B = (exp(-slow s) - exp(-fast s))/(2 d),    P = s (E(slow s) - E(fast s))/(2 d).
    The slow rate is W^2/(Z + d), never a difference.
    """
    d = sqrt(const.D)
    fast = const.Z + d
    slow = const.W2 / fast
    e_fast = exp_decay(fast * s)
    e_slow = exp_decay(slow * s)
    b = (e_slow - e_fast) / (2.0 * d)
    b1 = (fast * e_fast - slow * e_slow) / (2.0 * d)
    p = (one_minus_exp_ratio(slow * s) - one_minus_exp_ratio(fast * s)) * s / (2.0 * d)
    return b, b1, p


@inlined
def move(const, q, w, s):
    """Position and velocity (q, dq/dtheta) after s rad of flight from (q, w)."""
    b, b1, p = flow(const, s)
    force = const.G + const.W2 * q
    return q + (w * b - force * p), w * b1 - force * b


@inlined
def displacement(const, q, q_rest, w, w_rest, s, s_rest):
    """Change of position and velocity (q, dq/dtheta) in s rad of flight, each in two parts.

    (dq, dq_rest, dw, dw_rest). The start is q + q_rest, w + w_rest, the length s + s_rest, and
    omega0/omega = W (1 + e), e = W_rest, which for Z = 0 acts, to first order, as s (1 + e) and
        dq: -e (w B - 2 G P),    dw: e (G - W^2 q) B.
    The error is about 1e-17 (q + w/W) and a few roundings of G/W^2 without damping, else that of
    `flow`.
    """
    s_rest += const.W_rest * s
    if const.Z == 0.0 and const.W > SLOW:
        return _swing(const, q, q_rest, w, w_rest, s, s_rest)
    b, b1, p = flow(const, s)
    force = const.G + const.W2 * q
    rise = w * b
    drop = force * p
    pull = force * b
    dq = rise - drop
    w_end = w * b1 - pull
    accel_end = -force - const.W2 * dq - 2.0 * const.Z * w_end
    dq_rest = sum_rest(rise, -drop, dq) + product_rest(w, b, rise) - product_rest(force, p, drop)
    dq_rest += w_rest * b - const.W2 * q_rest * p + w_end * s_rest
    dq_rest -= const.W_rest * (rise - 2.0 * const.G * p)
    dw = w_end - w
    dw_rest = w_rest * (b1 - 1.0) + accel_end * s_rest
    dw_rest += const.W_rest * (2.0 * const.G * b - pull)
    return dq, dq_rest, dw, dw_rest + sum_rest(w_end, -w, dw)


@inlined
def _swing(const, q, q_rest, w, w_rest, s, s_rest):
    """`displacement` without damping, about the equilibrium -G/W^2.

    With y = q + G/W^2 and the angle x = W s,
        dq = (w/W) sin x - y (1 - cos x),    dw = -(W y sin x + w (1 - cos x)).
    Each product and each sum is made in two parts, the rest of a factor to first order.
    """
    y = q
    y_rest = q_rest
    if const.G != 0.0:
        from_rest = const.G / const.W2
        y = q + from_rest
        y_rest += sum_rest(q, from_rest, y)
    W = const.W
    x = W * s
    sine, sine_rest, fall, fall_rest = sine_versine(x, product_rest(W, s, x) + W * s_rest)
    inverse = 1.0 / W
    r = w * inverse
    r_rest = (w_rest - product_rest(W, r, w)) * inverse - const.W_rest * r
    rise = r * sine
    drop = y * fall
    dq = rise - drop
    dq_rest = sum_rest(rise, -drop, dq) + product_rest(r, sine, rise) - product_rest(y, fall, drop)
    dq_rest += (r * sine_rest + r_rest * sine) - (y * fall_rest + y_rest * fall)
    g = y * sine
    g_rest = product_rest(y, sine, g) + (y * sine_rest + y_rest * sine)
    pull = W * g
    brake = w * fall
    dw = pull + brake
    dw_rest = sum_rest(pull, brake, dw) + product_rest(W, g, pull) + product_rest(w, fall, brake)
    dw_rest += W * g_rest + const.W_rest * pull + (w * fall_rest + w_rest * fall)
    return dq, dq_rest, -dw, -dw_rest


@entry
def fill_flows(cam, const, flows):
    """Fill the table with `flow` from the start of stretch i over 1, 2, ... n whole stretches.

    flows: n^2 rows of Flow, the row n i + k for i and k + 1 stretches. With them neither crossing
    a stretch nor leaping over several needs a series.
    """
    n = len(cam.stretches)
    for i in range(n):
        start = cam.stretches[i].start
        for k in range(n):
            last = i + k  # from n on it is in the next turn
            end = cam.stretches[last].end if last < n else TURN + cam.stretches[last - n].end
            row = flows[n * i + k]
            row.b, row.b1, row.p = flow(const, end - start)
