"""An attractor as basins know it: its label, its states on the section, and when two are one."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

from camcli.analysis.labels import APERIODIC, CONTACT, rotation
from camcli.analysis.orbits.same_orbit import same_states


@dataclass(frozen=True)
class Attractor:
    """One attractor at one speed; states (q m, w m/rad) at the strobe, in order of the turns.

    A periodic one begins where its label does; an aperiodic one holds recorded states instead,
    and `turns` is 0. `multipliers` are those of the whole period.
    """

    label: str
    turns: int
    states: tuple[tuple[float, float], ...]
    symbols: tuple[float, ...] = ()
    multipliers: tuple[complex, complex] | None = None
    points: np.ndarray | None = field(default=None, compare=False, repr=False)

    @classmethod
    def periodic_of(cls, label: str, states, symbols, multipliers=None) -> Attractor:
        """The attractor of a periodic orbit, whatever turn its states begin with."""
        states = tuple(states)
        symbols = tuple(symbols)
        k = rotation(symbols, lambda first: tuple(-x for x in states[first]))
        states = states[k:] + states[:k]
        symbols = symbols[k:] + symbols[:k]
        return cls(label, len(states), states, symbols, multipliers)

    @classmethod
    def aperiodic_of(cls, points: np.ndarray) -> Attractor:
        """The attractor of a motion that never repeats; points: recorded states."""
        return cls(APERIODIC, 0, (min(map(tuple, points.tolist())),), points=points)

    @property
    def periodic(self) -> bool:
        """False for an aperiodic attractor."""
        return self.turns > 0

    @property
    def size(self) -> float:
        """Largest coordinate of its states; lengths about it are relative to this."""
        return float(np.abs(self.shown()).max()) or 1.0

    def shown(self) -> np.ndarray:
        """(n, 2) states to compare and to draw."""
        return np.array(self.states) if self.points is None else self.points

    def is_same(self, other: Attractor) -> bool:
        """True where both are one periodic orbit."""
        return self.periodic and other.periodic and same_states(self.states, other.states)

    def order(self):
        """Sort key: contact, then by turns, impacts and state, aperiodic last."""
        rank = 2
        if self.label == CONTACT:
            rank = 0
        elif self.periodic:
            rank = 1
        symbols = tuple(-1.0 if s == inf else s for s in self.symbols)
        return rank, self.turns, symbols, self.states
