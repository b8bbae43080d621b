"""An attractor as basins know it: its label, its states on the section, and when two are one."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import numpy as np

SAME = 1e-6  # of the size of an orbit: states closer than this are one orbit
APERIODIC = "aperiodic"
CONTACT = "contact"


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


def begin_where_label_does(states, symbols):
    """Both rotated so that the symbols are the lexically largest, ties by the lowest state."""
    turns = range(len(symbols))
    rotations = [(symbols[k:] + symbols[:k], states[k:] + states[:k]) for k in turns]
    best = max(rotation[0] for rotation in rotations)
    return min((r[1], r[0]) for r in rotations if r[0] == best)


def is_one(a: Attractor, b: Attractor) -> bool:
    """True where two periodic attractors are the same orbit."""
    if not (a.periodic and a.turns == b.turns):
        return False
    near = SAME * max(a.size, b.size)

    def close(k: int) -> bool:
        pairs = zip(a.states, b.states[k:] + b.states[:k], strict=True)
        return all(abs(p[0] - q[0]) <= near and abs(p[1] - q[1]) <= near for p, q in pairs)

    return any(close(k) for k in range(b.turns))


def order(attractor: Attractor):
    """Sort key: contact, then by turns, impacts and state, aperiodic last."""
    rank = 0 if attractor.label == CONTACT else 1 if attractor.periodic else 2
    symbols = tuple(-1.0 if s == inf else s for s in attractor.symbols)
    return rank, attractor.turns, symbols, attractor.states
