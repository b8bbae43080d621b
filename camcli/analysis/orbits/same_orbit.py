"""When two states on the stroboscopic section are one, and two orbits the same.

A state is (q m, dq/dtheta m/rad). Distances are relative: each coordinate's to its largest value
among the states of the orbit, and the larger of the two counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from camcli.kernel.returns import SAME

if TYPE_CHECKING:
    from camcli.analysis.orbits.orbit import PeriodicOrbit

State = Sequence[float]


def size_of(states: Sequence[State]) -> tuple[float, float]:
    """Largest |q| and |dq/dtheta| among the states; 1 where that is zero."""
    q, w = (max(map(abs, column)) or 1.0 for column in zip(*states, strict=True))
    return q, w


def distance(a: State, b: State, size: State) -> float:
    """The relative distance of two states, sizes as of `size_of`."""
    return max(abs(a[0] - b[0]) / size[0], abs(a[1] - b[1]) / size[1])


def distances(a: np.ndarray, b: np.ndarray, size: State) -> np.ndarray:
    """`distance` of each state of one array from the state beside it in another."""
    return (np.abs(a - b) / np.asarray(size)).max(axis=1)


def close_returns(
    states: np.ndarray, turns: int, size: State, within: float
) -> tuple[np.ndarray, np.ndarray]:
    """From which states a motion comes back after `turns` turns, and how near it comes.

    states: (n, 2), of consecutive turns. Returns the indices of the states whose relative distance
    from the state `turns` later is at most `within`, and these distances.
    """
    apart = distances(states[turns:], states[:-turns], size)
    first = np.flatnonzero(apart <= within)
    return first, apart[first]


def distance_to(state: State, states: Sequence[State]) -> float:
    """The relative distance of a state from the nearest state of an orbit."""
    size = size_of(states)
    return min(distance(state, other, size) for other in states)


def shortest_period(states: Sequence[State]) -> int:
    """The least number of turns after which the states of an orbit repeat."""
    turns = len(states)
    shifts = (m for m in range(1, turns) if turns % m == 0)
    return next((m for m in shifts if same_states(states, [*states[m:], *states[:m]])), turns)


def same_states(a: Sequence[State], b: Sequence[State]) -> bool:
    """True where two orbits pass the section at the same states in the same order."""
    size = size_of(a)
    return len(a) == len(b) and all(distance(p, q, size) <= SAME for p, q in zip(a, b, strict=True))


def same_orbit(a: PeriodicOrbit, b: PeriodicOrbit) -> bool:
    """True for the same impacts in the same turns, and the same states on the section."""
    alike = a.symbols == b.symbols and len(a.theta) == len(b.theta)
    return alike and same_states(a.states, b.states)
