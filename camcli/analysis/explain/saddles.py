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

    axes: columns a_1, a_2; to: its columns give (eta, xi) of a difference from x, as difference @
    to. Raises LostError where Newton's method fails, or the root is no motion.
    """

    def __init__(self, carried: CarriedAttractor, rpm: float, orbit: PeriodicOrbit):
        """orbit: the saddle at another speed."""
        old = orbit.root
        shooter = Shooter(carried.system, rpm)
        root = None if old is None else shooter.at_value(old.x, old.whole, old.turns, rpm)
        if root is None:
            raise LostError
        verdict, _, _ = shooter.verdict(root)
        self.orbit = from_root(carried.system, root, verdict)
        if not self.orbit.admissible:
            raise LostError
        self.x = np.array(self.orbit.states[0])
        size = np.abs(self.orbit.states).max(0)
        multipliers, vectors = np.linalg.eig(monodromy(carried, rpm, self.x, root.turns))
        largest_first = np.argsort(-np.abs(multipliers))
        self.mu = float(multipliers.real[largest_first[0]])
        directions = vectors.real[:, largest_first]
        self.axes = directions / np.linalg.norm(directions / size[:, None], axis=0)
        if abs(np.linalg.det(self.axes / size[:, None])) < PARALLEL:
            raise LostError  # one direction only: no saddle
        self.to = np.linalg.inv(self.axes).T

    def leaf(self, t: float, first: float = ON_MANIFOLD) -> np.ndarray:
        """The state at t along W^u: `first` e^t from the orbit; t to t + ln mu is all of a side."""
        return self.x + first * exp(t) * self.axes[:, 0]


def monodromy(carried: CarriedAttractor, rpm: float, x: np.ndarray, turns: int) -> np.ndarray:
    """Derivative of the map over so many turns at x: flights and saltation matrices in turn.

    x: a state at the strobe. Its determinant is r^2 for each impact times exp(-2 Z) for each rad.
    Raises LostError where the motion from x ends early or lies below the cam.
    """
    system = carried.system
    const = system.constants(rpm, 1e-9, 1)

    def over_flight(length: float) -> np.ndarray:
        """The derivative of (q, dq/dtheta) after so many rad of flight."""
        return np.reshape(flown(const, length, IDENTITY), (2, 2))

    try:
        record = carried.motion(rpm, x, turns, events=True)
    except StartError:
        raise LostError from None
    if record.periods < turns:
        raise LostError
    end = TURN * turns
    matrix = np.eye(2)
    last = 0.0  # rad since the strobe, of the last impact
    phases, rates, turns_of_impacts = (column.tolist() for column in impacts_of(record))
    for phase, rate, turn in zip(phases, rates, turns_of_impacts, strict=True):
        angle = since_first_strobe(system, turn, phase)
        if angle < end:
            impact = np.reshape(struck(system, const, phase, rate, IDENTITY), (2, 2))
            matrix = impact @ over_flight(angle - last) @ matrix
            last = angle
    return over_flight(end - last) @ matrix


def find_saddles(
    system: System, rpm: float, record: Record, size: np.ndarray
) -> list[PeriodicOrbit]:
    """Unstable orbits of up to LONGEST_SADDLE turns, solved from close returns of a record.

    The orbits are those at rpm; the record, with events, may be of another speed nearby. Orbits
    that it never comes near are not found. size: widths of its states.
    """
    saddles: list[PeriodicOrbit] = []
    shooter = Shooter(system, rpm)
    scaled_states = states_of(record) / size
    for turns in range(1, LONGEST_SADDLE + 1):
        for first_turn in _closest_returns(scaled_states, turns):
            window = range(first_turn, first_turn + turns)
            impacts = identify.impacts_of(record, window)
            root = identify.newton_from(shooter, impacts, turns)
            if root is None:
                continue
            verdict, _, _ = shooter.verdict(root)
            orbit = from_root(system, root, verdict)
            known = any(same_orbit(orbit, other) for other in saddles)
            if orbit.admissible and not orbit.stable and orbit.primitive and not known:
                saddles.append(orbit)
    return sorted(saddles, key=lambda orbit: (orbit.turns, abs(orbit.multipliers[0])))


def _closest_returns(states: np.ndarray, turns: int) -> np.ndarray:
    """First turns of the closest returns after so many turns, one in each cell, TRIES at most.

    states: at the strobes, over the attractor's size. The plane is divided into cells, CELLS for
    each unit. Returns nearer than SAME_STATE are those of an orbit at rest.
    """
    first_turns, distances = close_returns(states, turns, (1.0, 1.0), RETURN)
    order = np.argsort(distances)
    moving = order[distances[order] > SAME_STATE]
    closest_first = first_turns[moving]
    cells = states[closest_first] * CELLS // 1
    _, first_in_cell = np.unique(cells, axis=0, return_index=True)
    return closest_first[np.sort(first_in_cell)[:TRIES]]


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
    outside_above = 0  # states of the motions that begin above, and below, along the first axis
    outside_below = 0
    for k in range(SIDE_STARTS):
        t = k / SIDE_STARTS * log(saddle.mu)
        outside_above += _outside(carried, rpm, saddle.leaf(t, SMALL), turns)
        outside_below += _outside(carried, rpm, saddle.leaf(t, -SMALL), turns)
    least = min(outside_above, outside_below)
    if max(outside_above, outside_below) <= max(LEAST, CLEARLY * least):
        return 0.0
    return 1.0 if outside_above < outside_below else -1.0


def _outside(carried: CarriedAttractor, rpm: float, x: np.ndarray, turns: int) -> int:
    """How many states of the motion from x lie outside the box."""
    try:
        return carried.outside(carried.states(rpm, x, turns))
    except StartError:
        return 0
