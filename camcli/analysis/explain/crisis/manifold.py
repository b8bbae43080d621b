"""A saddle at one speed with the axes of its map: starts along W^u, coordinates across W^s.

Near the orbit x the map over its period is linear: its unstable manifold W^u runs along the first
axis, its stable manifold W^s along the second. A state x + eta a_1 + xi a_2 lies on W^s where
eta = 0. The axes have relative size 1, so eta and xi are relative too.
"""

from __future__ import annotations

from math import exp

import numpy as np

from camcli.analysis.explain.crisis.runs import Carried
from camcli.analysis.integrate import StartError
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter

PARALLEL = 1e-9  # relative area between the two axes below which they are one
NUDGE = 1e-7  # relative: differences that give the linear map
FIRST = 1e-4  # relative: distance from the orbit at which a start lies on W^u


class LostError(Exception):
    """An orbit has no admissible, unstable continuation at a speed."""


class Saddle:
    """An unstable orbit solved again at `rpm`: x its state, mu the multiplier along W^u.

    axes: columns a_1, a_2; to: rows that give (eta, xi) of a difference from x. Raises LostError
    where Newton's method fails, or the root is no motion.
    """

    def __init__(self, carried: Carried, rpm: float, orbit: PeriodicOrbit):
        old, shooter = orbit.root, Shooter(carried.system, rpm)
        root = shooter.at_value(old.x, old.whole, old.turns, rpm)
        if root is None:
            raise LostError
        self.orbit = from_root(carried.system, root, shooter.verdict(root)[0])
        if not self.orbit.admissible:
            raise LostError
        self.x = np.array(self.orbit.states[0])
        size = np.abs(self.orbit.states).max(0)
        values, axes = np.linalg.eig(_linear_map(carried, rpm, self.x, size, old.turns))
        order = np.argsort(-np.abs(values))
        self.mu = float(values.real[order[0]])
        axes = axes.real[:, order]
        self.axes = axes / np.linalg.norm(axes / size[:, None], axis=0)
        if abs(np.linalg.det(self.axes / size[:, None])) < PARALLEL:
            raise LostError  # one direction only: no saddle
        self.to = np.linalg.inv(self.axes).T

    def leaf(self, t: float, first: float = FIRST) -> np.ndarray:
        """The state at t along W^u: `first` e^t from the orbit; t to t + ln mu is all of a side."""
        return self.x + first * exp(t) * self.axes[:, 0]


def _linear_map(carried: Carried, rpm: float, x, size, turns: int) -> np.ndarray:
    """Derivative of the map over the period at x; one-sided where a nudge goes below the cam."""
    columns = []
    for axis, nudge in enumerate(np.diag(NUDGE * size)):
        ends, width = [], 0.0
        for jump in (nudge, -nudge):
            try:
                states = carried.states(rpm, x + jump, turns)
            except StartError:
                ends.append(x)
                continue
            if len(states) <= turns:  # the motion ends early
                raise LostError
            ends.append(states[turns])
            width += NUDGE
        if width == 0.0:
            raise LostError
        columns.append((ends[0] - ends[1]) / (width * size[axis]))
    return np.array(columns).T
