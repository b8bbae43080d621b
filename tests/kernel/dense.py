"""First contact of a free flight by brute force: fine sampling of the gap and of its minima."""

from math import pi

import numpy as np

from tests.kernel.helpers import ORACLE_CAM

TURN = 2 * pi
CELLS = 3000  # per turn
DOUBT = 1e-13  # m: a gap this small may count either way
BREAKS = np.array([float(x) for x in ORACLE_CAM.breakpoints])
ARCS = [tuple(float(x) for x in arc[:4]) for arc in ORACLE_CAM.arcs]


def lift(theta):
    """(c, c_theta) of the chapter's cam at an array of unbounded angles."""
    x = np.mod(theta, TURN)
    which = (np.searchsorted(BREAKS, x, side="right") - 1) % 6
    K, rho, origin, offset = np.array(ARCS)[which].T
    sine, cosine = np.sin(x - origin), np.cos(x - origin)
    inside = np.sqrt(rho * rho - (K * sine) ** 2)
    return K * cosine + inside - offset, -K * sine - K * K * sine * cosine / inside


def flow(W, Z, G, q, w, s):
    """(q, w) after s of flight, by textbook formulas with the equilibrium subtracted (W > 0)."""
    rest = -G / W**2
    d = np.sqrt(complex(Z * Z - W * W))
    cosh, sinh = np.cosh(d * s), np.sinh(d * s) / d if d else s + 0j
    decay = np.exp(-Z * s)
    x, y = q - rest, w + Z * (q - rest)
    position = decay * (x * cosh + y * sinh).real
    slope = decay * (x * d * d * sinh + y * cosh).real - Z * position
    return rest + position, slope


def first_contact(W, Z, G, theta, q, w, turns, contact):
    """(s, doubtful): phase of the first contact within `turns`, None if there is none.

    doubtful: a graze closer than DOUBT comes first. `contact`: the flight starts on the cam.
    """
    first = np.geomspace(1e-7, TURN / CELLS, 400) if contact else np.zeros(1)
    s = np.concatenate([first, TURN / CELLS * np.arange(2, int(CELLS * turns) + 1)])

    def gap(at):
        position, slope = flow(W, Z, G, q, w, at)
        c, c1 = lift(theta + at)
        return position - c, slope - c1

    g, u = gap(s)
    below = np.flatnonzero(g <= 0)
    stop = below[0] if len(below) else len(s) - 1
    dips = np.flatnonzero((u[:stop] < 0) & (u[1 : stop + 1] >= 0) & (g[:stop] > 0))
    for j in dips:
        low = _bisect(lambda at: -gap(at)[1], s[j], s[j + 1])
        least = gap(low)[0]
        if abs(least) < DOUBT:
            return low, True
        if least < 0:
            return _bisect(lambda at: gap(at)[0], s[j], low), False
    if not len(below):
        return None, False
    if stop == 0:
        return None, True
    return _bisect(lambda at: gap(at)[0], s[stop - 1], s[stop]), False


def _bisect(f, low, high):
    """Where f, positive at low, becomes negative."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        if f(middle) > 0:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
