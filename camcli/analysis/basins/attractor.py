"""An attractor as basins know it: its label, its states on the section, and when two are one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from camcli.analysis.labels import APERIODIC, CONTACT, rotation
from camcli.analysis.orbits.same_orbit import same_states


@dataclass(frozen=True)
class Attractor:
    """One attractor at one speed; states (q m, w m/rad) at the strobe, in order of the turns.

    A periodic one begins where its label does; symbols: impacts of each turn, inf where a chatter
    is completed. An aperiodic one holds recorded states in `points` instead, and `turns` is 0.
    `multipliers` are those of the whole period.
    """

    label: str
    turns: int
    states: tuple[tuple[float, float], ...]
    symbols: tuple[float, ...] = ()
    multipliers: tuple[complex, complex] | None = None
    points: np.ndarray | None = field(default=None, compare=False, repr=False)

    @classmethod
    def periodic_of(
        cls,
        label: str,
        states: Sequence[tuple[float, float]],
        symbols: Sequence[float],
        multipliers: tuple[complex, complex] | None = None,
    ) -> Attractor:
        """The attractor of a periodic orbit, whatever turn its states begin with.

        states, symbols: of its turns, one each. They are rotated to the turn with which its label
        begins: the largest symbols in lexical order, and of equal ones the least state.
        """
        states = tuple(states)
        symbols = tuple(symbols)
        first = rotation(symbols, lambda turn: tuple(-x for x in states[turn]))
        states = states[first:] + states[:first]
        symbols = symbols[first:] + symbols[:first]
        return cls(label, len(states), states, symbols, multipliers)

    @classmethod
    def aperiodic_of(cls, points: np.ndarray) -> Attractor:
        """The attractor of a motion that never repeats; points: recorded states."""
        least_state = min(map(tuple, points.tolist()))
        return cls(APERIODIC, 0, (least_state,), points=points)

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

    def order(self) -> tuple:
        """Sort key: contact, then by turns, impacts and state, aperiodic last."""
        rank = 2
        if self.label == CONTACT:
            rank = 0
        elif self.periodic:
            rank = 1
        symbols = tuple(-1.0 if symbol == inf else symbol for symbol in self.symbols)
        return rank, self.turns, symbols, self.states
