"""Periodic orbits and their bifurcations in 30 digits: shooting equations, saltation matrices.

An orbit of n impacts is (at, up) for each: rad after the strobe, relative velocity after it.
Nothing comes from the package; what it found is only where Newton's method begins.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from mpmath import matrix, mp, mpf

from tests.support.mechanics import TURN, Machine
from tests.support.motion import DIGITS, Motion


class Exact:
    """A machine at a speed of its own, in the digits in use."""

    def __init__(self, machine: Machine, rpm):
        self.machine, self.omega = machine, mpf(rpm) * mp.pi / 30
        self.r, self.mass = mpf(machine.restitution), mpf(machine.mass)

    def cam(self, at, side: int = 1):
        """(c, velocity, acceleration) so many rad after the strobe."""
        c, c1, c2 = self.machine.lift.exactly(mpf(self.machine.strobe) + at, side)
        return c, c1 * self.omega, c2 * self.omega**2

    def flow(self, s, q, v):
        """(q, v) after s rad of flight."""
        return self.machine._exact.flow(s / self.omega, q, v)

    def flight(self, at, up, s):
        """(gap, rate of the gap) s rad after an impact."""
        c, c1, _ = self.cam(at)
        q, v = self.flow(s, c, c1 + up)
        c, c1, _ = self.cam(at + s)
        return q - c, v - c1

    def matrix(self, s):
        """Derivative of the flow."""
        zero, one, two = (self.flow(s, *x) for x in ((0, 0), (1, 0), (0, 1)))
        return matrix([[one[k] - zero[k], two[k] - zero[k]] for k in (0, 1)])

    def saltation(self, at, up, side: int = 1):
        """Derivative across an impact, c_thetatheta from one side of its phase.

        In the gap y and its rate, time apart by -dy/u: dy -> -r dy,
        dy' -> -r dy' + (r a- + a+) dy/u, a-+ the acceleration of the gap in flight.
        """
        own, (c, c1, c2) = self.machine, self.cam(at, side)
        u, load = -up / self.r, mpf(own.gravity) + mpf(own.preload) / self.mass
        still = -mpf(own.stiffness) / self.mass * c - load - c2
        before, after = (
            still - mpf(own.damping) / self.mass * (c1 + x) for x in (u, up)
        )  # fmt: skip
        return matrix([[-self.r, 0], [(self.r * before + after) / u, -self.r]])

    def monodromy(self, at: Sequence, up: Sequence, turns: int, side: int = 1):
        """From strobe to strobe over so many turns, (q, v)."""
        found, last = matrix([[1, 0], [0, 1]]), mpf(0)
        for x, rate in zip(at, up, strict=True):
            found = self.saltation(x, rate, side) * self.matrix(x - last) * found
            last = x
        return self.matrix(2 * mp.pi * turns - last) * found

    def shooting(self, at: Sequence, up: Sequence, turns: int) -> list:
        """The gap at each next impact, and what its rebound misses of the next start."""
        ends = [*at, at[0] + 2 * mp.pi * turns]
        found = []
        for k, (a, b) in enumerate(pairwise(ends)):
            gap, u = self.flight(a, up[k], b - a)
            found += [gap, -self.r * u - up[(k + 1) % len(up)]]
        return found


def impacts_of(motion: Motion, turns: int) -> tuple[list[float], list[float]]:
    """(angles in rad, rates after impact) of the impacts of the first turns of a motion."""
    own = [e for e in motion.events if e.kind == "impact" and 0.0 <= e.at < TURN * turns]
    return [event.at for event in own], [event.u_plus for event in own]


def multipliers(machine: Machine, motion: Motion, turns: int, side: int = 1) -> np.ndarray:
    """(2, 2) derivative of the map over so many turns from the strobe; zero where it rests."""
    if any(event.kind == "chatter" for event in motion.events):
        return np.zeros((2, 2))
    with mp.workdps(DIGITS):
        found = Exact(machine, machine.rpm).monodromy(*impacts_of(motion, turns), turns, side)
        return np.array(found.tolist(), float)


def event(machine: Machine, kind: str, motion: Motion, turns: int, corner: float | None = None):
    """(rpm, [(trace, det) left, right of a corner], phases in deg) of a bifurcation nearby.

    The speed solves the shooting equations with det(M + 1) = 0 (period-doubling), det(M - 1) = 0
    (fold), an impact at the corner (rad), or a flight that touches the cam (grazing).
    """
    at, up = impacts_of(motion, turns)
    n = len(at)
    with mp.workdps(DIGITS):
        scales = [1.0] * n + [abs(x) for x in up] + [machine.rpm]
        guess = [*at, *up, machine.rpm]
        graze = 0
        if kind == "grazing":
            graze, place = lowest_flight(machine, at, up, turns)
            guess, scales = [*guess, place], [*scales, 1.0]
        nearest = None
        if corner is not None:
            apart = [abs((x + machine.strobe - corner + np.pi) % TURN - np.pi) for x in at]
            nearest = int(np.argmin(apart))

        def residual(*x):
            """What is zero at the bifurcation: shooting equations, and the condition of its kind.

            x: angles of the impacts, rates after them, the speed, and of a grazing the angle where
            it touches; each over its scale.
            """
            x = [value * scale for value, scale in zip(x, scales, strict=True)]
            own = Exact(machine, x[2 * n])
            found = own.shooting(x[:n], x[n : 2 * n], turns)
            if kind == "grazing":
                return [*found, *own.flight(x[graze], x[n + graze], x[-1])]
            if nearest is not None:
                turn = mp.nint((x[nearest] + machine.strobe - corner) / (2 * mp.pi))
                apart = x[nearest] + mpf(machine.strobe) - mpf(corner) - 2 * mp.pi * turn
                return [*found, apart]
            whole, sign = own.monodromy(x[:n], x[n : 2 * n], turns), {"fold": -1}.get(kind, 1)
            trace, det = whole[0, 0] + whole[1, 1], mp.det(whole)
            return [*found, 1 + sign * trace + det]

        begin = [value / scale for value, scale in zip(guess, scales, strict=True)]
        root = mp.findroot(residual, begin, tol=1e-30, maxsteps=30)
        x = [value * scale for value, scale in zip(root, scales, strict=True)]
        own = Exact(machine, x[2 * n])
        sides = []
        for side in (-1, 1):
            whole = own.monodromy(x[:n], x[n : 2 * n], turns, side)
            sides.append((float(whole[0, 0] + whole[1, 1]), float(mp.det(whole))))
        return float(x[2 * n]), sides, [machine.phase_deg(float(y)) for y in x[:n]]


def lowest_flight(machine: Machine, at, up, turns) -> tuple[int, float]:
    """(flight, rad after its impact) where the gap of an orbit is lowest between its impacts."""
    own, best = Exact(machine, machine.rpm), (mp.inf, 0, 0.0)
    for k, (a, b) in enumerate(pairwise([*at, at[0] + TURN * turns])):
        places = np.linspace(0.0, b - a, 721)[36:-36]
        gaps = [own.flight(a, up[k], s)[0] for s in places]
        low = min(range(1, len(gaps) - 1), key=lambda j: gaps[j])
        best = min(best, (gaps[low], k, places[low]))
    return best[1], best[2]
