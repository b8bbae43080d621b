"""Saddles in a chaotic record: found, solved at a speed with their axes, and where they lead.

Near an orbit x the map over its period is linear: its unstable manifold W^u runs along the first
axis, its stable manifold W^s along the second. A state x + eta a_1 + xi a_2 lies on W^s where
eta = 0. The axes have relative size 1, so eta and xi are relative too.
"""

from math import exp, log

import numpy as np

from camcli.analysis.differences import IDENTITY, flown, since_first_strobe, struck
from camcli.analysis.explain.attractor import LEAST, CarriedAttractor, impacts_of, states_of
from camcli.analysis.integrate import Record, StartError
from camcli.analysis.orbits import identify
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.same_orbit import close_returns, same_orbit
from camcli.analysis.orbits.shooter import Shooter
from camcli.kernel.cam_table import TURN
from camcli.system import System

LONGEST_SADDLE = 8  # turns of the saddles looked for
TRIES = 40  # close returns tried for each number of turns
RETURN = 0.05  # sizes of the attractor: ends of a close return lie nearer
SAME_STATE = 1e-9  # sizes of the attractor: nearer ends are an orbit at rest
CELLS = 64  # of the attractor's size: one close return is tried in each cell
PARALLEL = 1e-9  # relative area between the two axes below which they are one
ON_MANIFOLD = 1e-4  # relative: distance from the orbit at which a start lies on W^u
SMALL = 1e-6  # relative: the same for starts that are only to leave on their own side
SIDE_STARTS = 60  # on each side, over one turn of the multiplier
AFTER = 55  # turns after a start has grown to the size of the attractor
CLEARLY = 10  # times as many states outside on the side that leads out


class LostError(Exception):
    """An orbit has no admissible, unstable continuation at a speed."""


class Saddle:
    """An unstable orbit solved again at `rpm`: x its state, mu the multiplier along W^u.

    axes: columns a_1, a_2; to: rows that give (eta, xi) of a difference from x. Raises LostError
    where Newton's method fails, or the root is no motion.
    """

    def __init__(self, carried: CarriedAttractor, rpm: float, orbit: PeriodicOrbit):
        old = orbit.root
        shooter = Shooter(carried.system, rpm)
        root = None if old is None else shooter.at_value(old.x, old.whole, old.turns, rpm)
        if root is None:
            raise LostError
        self.orbit = from_root(carried.system, root, shooter.verdict(root)[0])
        if not self.orbit.admissible:
            raise LostError
        self.x = np.array(self.orbit.states[0])
        size = np.abs(self.orbit.states).max(0)
        values, axes = np.linalg.eig(monodromy(carried, rpm, self.x, root.turns))
        order = np.argsort(-np.abs(values))
        self.mu = float(values.real[order[0]])
        axes = axes.real[:, order]
        self.axes = axes / np.linalg.norm(axes / size[:, None], axis=0)
        if abs(np.linalg.det(self.axes / size[:, None])) < PARALLEL:
            raise LostError  # one direction only: no saddle
        self.to = np.linalg.inv(self.axes).T

    def leaf(self, t: float, first: float = ON_MANIFOLD) -> np.ndarray:
        """The state at t along W^u: `first` e^t from the orbit; t to t + ln mu is all of a side."""
        return self.x + first * exp(t) * self.axes[:, 0]


def monodromy(carried: CarriedAttractor, rpm: float, x: np.ndarray, turns: int) -> np.ndarray:
    """Derivative of the map over so many turns at x: flights and saltation matrices in turn.

    Its determinant is r^2 for each impact times exp(-2 Z) for each rad. Raises LostError where the
    motion from x ends early or lies below the cam.
    """
    system = carried.system
    const = system.constants(rpm, 1e-9, 1)
    try:
        record = carried.motion(rpm, x, turns, True)
    except StartError:
        raise LostError from None
    if record.periods < turns:
        raise LostError
    theta, u, period = impacts_of(record)
    matrix = np.eye(2)
    last = 0.0
    for turn, phase, rate in zip(period.tolist(), theta.tolist(), u.tolist(), strict=True):
        angle = since_first_strobe(system, turn, phase)
        if angle < TURN * turns:
            flight = np.reshape(flown(const, angle - last, IDENTITY), (2, 2))
            impact = np.reshape(struck(system, const, phase, rate, IDENTITY), (2, 2))
            matrix = impact @ flight @ matrix
            last = angle
    return np.reshape(flown(const, TURN * turns - last, IDENTITY), (2, 2)) @ matrix


def find_saddles(
    system: System, rpm: float, record: Record, size: np.ndarray
) -> list[PeriodicOrbit]:
    """Unstable orbits of up to LONGEST_SADDLE turns, solved from close returns of a record.

    The orbits are those at rpm; the record, with events, may be of another speed nearby. Orbits
    that it never comes near are not found. size: widths of its states.
    """
    saddles: list[PeriodicOrbit] = []
    shooter = Shooter(system, rpm)
    at = states_of(record) / size
    for turns in range(1, LONGEST_SADDLE + 1):
        for k in _closest_returns(at, turns):
            impacts = identify.impacts_of(record, range(k, k + turns))
            root = identify.newton_from(shooter, impacts, turns)
            if root is None:
                continue
            orbit = from_root(system, root, shooter.verdict(root)[0])
            known = any(same_orbit(orbit, other) for other in saddles)
            if orbit.admissible and not orbit.stable and orbit.primitive and not known:
                saddles.append(orbit)
    return sorted(saddles, key=lambda orbit: (orbit.turns, abs(orbit.multipliers[0])))


def _closest_returns(at: np.ndarray, turns: int) -> np.ndarray:
    """First turns of the closest returns after so many turns, one in each cell."""
    returned, apart = close_returns(at, turns, (1.0, 1.0), RETURN)
    order = np.argsort(apart)
    order = returned[order[apart[order] > SAME_STATE]]
    _, first = np.unique(at[order] * CELLS // 1, axis=0, return_index=True)
    return order[np.sort(first)[:TRIES]]


def inner_side(carried: CarriedAttractor, rpm: float, orbit: PeriodicOrbit) -> float:
    """+-1: the side of the saddle whose W^u stays in the box where the other one leads out.

    0 where neither does clearly, or the orbit is no saddle with a real multiplier above 1, of which
    each side of W^u keeps to itself. Starts below the cam are no states and left out. Raises
    LostError where the saddle cannot be followed to this speed.
    """
    mu = orbit.multipliers[0]
    if mu.imag != 0.0 or mu.real < 1.0:
        return 0.0
    saddle = Saddle(carried, rpm, orbit)
    if saddle.mu <= 1.0:
        return 0.0
    turns = AFTER + int(orbit.turns * log(1.0 / SMALL) / log(saddle.mu))
    above, below = 0, 0
    for k in range(SIDE_STARTS):
        t = k / SIDE_STARTS * log(saddle.mu)
        above += _outside(carried, rpm, saddle.leaf(t, SMALL), turns)
        below += _outside(carried, rpm, saddle.leaf(t, -SMALL), turns)
    if max(above, below) <= max(LEAST, CLEARLY * min(above, below)):
        return 0.0
    return 1.0 if above < below else -1.0


def _outside(carried: CarriedAttractor, rpm: float, x: np.ndarray, turns: int) -> int:
    """How many states of the motion from x lie outside the box."""
    try:
        return carried.outside(carried.states(rpm, x, turns))
    except StartError:
        return 0
