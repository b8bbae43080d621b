"""Saddles seen in a chaotic record, and the side of one whose unstable manifold leads out."""

from __future__ import annotations

from math import log

import numpy as np

from camcli.analysis.explain.crisis.manifold import Saddle
from camcli.analysis.explain.crisis.runs import LEAST, Carried, impacts_of, states_of
from camcli.analysis.integrate import StartError, Tape
from camcli.analysis.orbits.find import primitive, same_orbit
from camcli.analysis.orbits.identify import newton_from
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter

LONGEST = 8  # turns of the saddles looked for
TRIES = 40  # close returns tried for each number of turns
RETURN = 0.05  # sizes of the attractor: ends of a close return lie nearer
SAME_STATE = 1e-9  # sizes of the attractor: nearer ends are an orbit at rest
CELLS = 64  # of the attractor's size: one close return is tried in each cell
SMALL = 1e-6  # relative: first distance from the saddle of the starts along its W^u
STARTS = 60  # over one turn of the multiplier
AFTER = 55  # turns after a start has grown to the size of the attractor
CLEARLY = 10  # times as many states outside on the side that leads out


def find_saddles(carried: Carried, rpm: float, tape: Tape) -> list[PeriodicOrbit]:
    """Unstable orbits of up to LONGEST turns: Newton's method from close returns of a record.

    The orbits are those at rpm; the record, with events, may be of another speed nearby. Orbits
    that it never comes near are not found.
    """
    found: list[PeriodicOrbit] = []
    shooter, columns = Shooter(carried.system, rpm), impacts_of(tape)
    at = states_of(tape) / carried.size
    for turns in range(1, LONGEST + 1):
        for k in _close_returns(at, turns):
            orbit = _solved(carried, shooter, columns, k, turns)
            if orbit is not None and not any(same_orbit(orbit, other) for other in found):
                found.append(orbit)
    return sorted(found, key=lambda orbit: (orbit.turns, abs(orbit.multipliers[0])))


def _close_returns(at: np.ndarray, turns: int) -> np.ndarray:
    """First turns of the closest returns after so many turns, one in each cell."""
    distance = np.abs(at[turns:] - at[:-turns]).max(1)
    order = np.argsort(distance)
    order = order[(distance[order] < RETURN) & (distance[order] > SAME_STATE)]
    _, first = np.unique(at[order] * CELLS // 1, axis=0, return_index=True)
    return order[np.sort(first)[:TRIES]]


def _solved(carried: Carried, shooter: Shooter, columns, k: int, turns: int):
    """The unstable orbit near the impacts of the turns from k on, or None."""
    theta, u, period = columns
    window = slice(*np.searchsorted(period, (k, k + turns)))
    rows = (column[window].tolist() for column in (period, theta, u))
    root = newton_from(carried.system, shooter, list(zip(*rows, strict=True)), turns)
    if root is None:
        return None
    orbit = from_root(carried.system, root, shooter.verdict(root)[0])
    return orbit if orbit.admissible and not orbit.stable and primitive(orbit) else None


def crossed_one_way(orbit: PeriodicOrbit) -> bool:
    """True for a saddle with a real multiplier above 1: each side of its W^u keeps to itself."""
    mu = orbit.multipliers[0]
    return mu.imag == 0.0 and mu.real >= 1.0


def inner_side(carried: Carried, rpm: float, orbit: PeriodicOrbit) -> float:
    """+-1: the side of the saddle whose W^u stays in the box where the other one leads out.

    0 where neither does clearly, or the saddle attracts at this speed. Starts below the cam are no
    states and left out. Raises LostError where the saddle cannot be followed to this speed.
    """
    saddle = Saddle(carried, rpm, orbit)
    if saddle.mu <= 1.0:
        return 0.0
    above, below = (_leaving(carried, rpm, saddle, sign * SMALL) for sign in (1.0, -1.0))
    if max(above, below) <= max(LEAST, CLEARLY * min(above, below)):
        return 0.0
    return 1.0 if above < below else -1.0


def _leaving(carried: Carried, rpm: float, saddle: Saddle, first: float) -> int:
    """How many states of the motions that start along one side of W^u lie outside the box."""
    turns = AFTER + int(saddle.orbit.turns * log(1.0 / SMALL) / log(saddle.mu))
    count = 0
    for k in range(STARTS):
        x = saddle.leaf(k / STARTS * log(saddle.mu), first)
        try:
            count += carried.outside(carried.states(rpm, x, turns))
        except StartError:
            continue
    return count
