"""The closed-form free flight, for every damping, with gravity and preload.

With theta as the variable the follower in flight obeys
    q'' + 2 Z q' + W^2 q = -G,   W = omega0/omega, Z = zeta/omega, G = (g + F0/m)/omega^2.
From (q0, w0) at s = 0, with F = G + W^2 q0,
    q(s) = q0 + w0 B(s) - F P(s),    w(s) = w0 B'(s) - F B(s),
where B solves the homogeneous equation with B(0) = 0, B'(0) = 1 and P is its integral
(P'' + 2 Z P' + W^2 P = 1, P(0) = P'(0) = 0). This form needs no equilibrium position, so it
holds for stiffness 0 (the bouncing ball) and keeps q(s) - q0 relatively exact.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from camcli.kernel.arithmetic import cos_sin_series, exp_decay, one_minus_exp_ratio, sincos
from camcli.kernel.cam_table import TURN
from camcli.kernel.marks import entry, inlined, outlined

SERIES_LIMIT = 2.5  # largest |D s^2| that one series covers


class Constants(NamedTuple):
    """Dimensionless constants of one orbit; `W` to `G` per radian of cam angle."""

    W: float  # omega0 / omega
    W2: float  # W squared
    Z: float  # zeta / omega
    D: float  # Z^2 - W^2, computed as (Z - W)(Z + W)
    G: float  # (gravity + preload/mass) / omega^2, m/rad^2
    r: float  # restitution
    tolerance: float  # chatter tolerance, rad
    impact_budget: int  # impacts in one period


@dataclass(slots=True)
class Flow:
    """`flow` over whole stretches, a row of the table of `fill_flows`."""

    b: float = 0.0
    b1: float = 0.0
    p: float = 0.0


# Entries of a machine's table: SI, rpm. Any of them may be a bifurcation parameter.
RPM, MASS, STIFFNESS, DAMPING, GRAVITY, PRELOAD, RESTITUTION = range(7)
RAD_PER_S = 0.10471975511965977  # pi/30, rad/s per rpm


@inlined
def constants_of(machine, tolerance, impact_budget):
    """The constants of one orbit; `machine` is indexed by RPM to RESTITUTION, tolerance in rad."""
    omega = machine[RPM] * RAD_PER_S
    mass = machine[MASS]
    W = sqrt(machine[STIFFNESS] / mass) / omega
    Z = machine[DAMPING] / (2.0 * mass) / omega
    G = (machine[GRAVITY] + machine[PRELOAD] / mass) / omega / omega
    return Constants(
        W, W * W, Z, (Z - W) * (Z + W), G, machine[RESTITUTION], tolerance, impact_budget
    )


@inlined
def flow(const, s):
    """(B, B', P) after s >= 0 rad of flight; see the module's equations."""
    if const.Z == 0.0:
        return _flow_undamped(const.W, const.W2, s)
    return _flow_damped(const, s)


@inlined
def _flow_undamped(W, W2, s):
    t = -W2 * s * s
    if t >= -SERIES_LIMIT:
        v, b = cos_sin_series(t)
        return s * b, 1.0 + t * v, s * s * v
    sine, cosine = sincos(W * s)
    return sine / W, cosine, (1.0 - cosine) / W2


@outlined
def _flow_damped(const, s):
    zs = const.Z * s
    ws2 = const.W2 * s * s
    if 2.0 * zs + ws2 <= 1.0:
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
    """Taylor series of P by its own differential equation: no cancellation for short s."""
    if s == 0.0:
        return 0.0, 1.0, 0.0
    zs = 2.0 * const.Z * s
    ws2 = const.W2 * s * s
    before = 0.0
    term = 0.5 * s * s
    p = term
    b = 2.0 * term
    for n in range(3, 23):
        term, before = -(zs * term + ws2 * before / (n - 1)) / n, term
        p += term
        b += n * term
    b /= s
    return b, 1.0 - 2.0 * const.Z * b - const.W2 * p, p


@outlined
def _flow_overdamped(const, s):
    """Two real exponentials; the slow root as W^2/(Z + d), never by subtraction."""
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


@entry
def fill_flows(cam, const, flows):
    """Fill the table with `flow` from the start of stretch i over 1, 2, ... n whole stretches.

    flows: n^2 rows of Flow, the row n i + k for i and k + 1 stretches. With them neither crossing
    a stretch nor leaping over several needs a series.
    """
    n = len(cam.stretches)
    for i in range(n):
        for k in range(n):
            j = i + k
            stop = cam.stretches[j].end if j < n else TURN + cam.stretches[j - n].end
            row = flows[n * i + k]
            row.b, row.b1, row.p = flow(const, stop - cam.stretches[i].start)
