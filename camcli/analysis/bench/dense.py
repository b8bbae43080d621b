"""First contact of a free flight by brute force: fine sampling of the gap and of its minima.

Independent of the kernel: the cam in closed form, the flight by textbook formulas, every dip of the
gap bisected. Lengths in m, angles in rad, velocities in m/rad.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from camcli.analysis.bench.peers.lifts import FLANK, NOSE, ROUND, Lift

TURN = 2.0 * pi
CELLS = 3000  # per turn
DOUBT = 1e-13  # m: a gap this small may count either way
BISECTIONS = 60


class Flight(NamedTuple):
    """A flight: W, Z, G of the machine at its speed, phase and state at the start."""

    W: float
    Z: float
    G: float
    theta: float
    q: float
    w: float


def lift_at(lift: Lift, theta):
    """(c, c_theta) of a cam of circular arcs at an array of unbounded angles."""
    x = np.mod(theta, TURN)
    which = np.searchsorted(np.array(lift.breaks), x, side="right")
    forms = np.array([r.form in (FLANK, NOSE) for r in lift.regions])[which]
    table = np.array([_numbers(r) for r in lift.regions])[which].T
    kappa, rho, centre, height = table
    sine, cosine = np.sin(x - centre), np.cos(x - centre)
    inside = np.sqrt(rho * rho - (kappa * sine) ** 2)
    c = kappa * cosine + inside - lift.offset
    slope = -kappa * sine - kappa * kappa * sine * cosine / inside
    return np.where(forms, c, height), np.where(forms, slope, 0.0)


def _numbers(region) -> tuple[float, float, float, float]:
    """(kappa, rho, centre, height) of a region; a round one has no circle of its own."""
    if region.form == ROUND:
        return 0.0, 1.0, 0.0, region.numbers[0]
    return (*region.numbers, region.centre, 0.0)


def flow(f: Flight, s):
    """(q, w) after s of flight, with the equilibrium subtracted (W > 0)."""
    rest = -f.G / f.W**2
    d = np.sqrt(complex(f.Z * f.Z - f.W * f.W))
    cosh, sinh = np.cosh(d * s), np.sinh(d * s) / d if d else s + 0j
    decay = np.exp(-f.Z * s)
    x, y = f.q - rest, f.w + f.Z * (f.q - rest)
    position = decay * (x * cosh + y * sinh).real
    slope = decay * (x * d * d * sinh + y * cosh).real - f.Z * position
    return rest + position, slope


def first_contact(lift: Lift, f: Flight, turns: float, contact: bool) -> tuple[float | None, bool]:
    """(s, doubtful): phase of the first contact within `turns`, None if there is none.

    doubtful: a graze closer than DOUBT comes first. `contact`: the flight starts on the cam.
    """
    first = np.geomspace(1e-7, TURN / CELLS, 400) if contact else np.zeros(1)
    s = np.concatenate([first, TURN / CELLS * np.arange(2, int(CELLS * turns) + 1)])

    def gap(at):
        position, slope = flow(f, at)
        c, c1 = lift_at(lift, f.theta + at)
        return position - c, slope - c1

    g, u = gap(s)
    below = np.flatnonzero(g <= 0)
    stop = below[0] if len(below) else len(s) - 1
    dips = np.flatnonzero((u[:stop] < 0) & (u[1 : stop + 1] >= 0) & (g[:stop] > 0))
    for j in dips:
        low = _bisect(lambda at: -gap(at)[1], s[j], s[j + 1])
        least = float(gap(low)[0])
        if abs(least) < DOUBT:
            return low, True
        if least < 0:
            return _bisect(lambda at: gap(at)[0], s[j], low), False
    if not len(below):
        return None, False
    if stop == 0:
        return None, True
    return _bisect(lambda at: gap(at)[0], s[stop - 1], s[stop]), False


def _bisect(f: Callable, low: float, high: float) -> float:
    """Where f, positive at low, becomes negative."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if f(middle) > 0:
            low = middle
        else:
            high = middle
    return float(0.5 * (low + high))
