"""Attractors matched from speed to speed: a number stays with an attractor as the speed changes.

First by state: of one label, each the nearest to the other, and near. Then by motion: each, started
at the other's speed, ends on the other. What is left begins a branch of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import Census

NEAR = 0.3  # of the orbit's size
THINNED = 400  # states of an aperiodic attractor compared


@dataclass
class Branches:
    """The last known attractor of every branch; branch n is entry n - 1."""

    last: list[Attractor] = field(default_factory=list)
    present: list[int] = field(default_factory=list)  # branches at the speed before
    before: Census | None = None

    def number(self, attractors: tuple[Attractor, ...], census: Census) -> tuple[int, ...]:
        """Branch of each attractor of the next speed."""
        found = self._by_state(attractors)
        found = self._by_motion(attractors, census, found)
        for k, attractor in enumerate(attractors):
            if k not in found:
                self.last.append(attractor)
                found[k] = len(self.last) - 1
            self.last[found[k]] = attractor
        self.present = sorted(found.values())
        self.before = census
        return tuple(found[k] + 1 for k in range(len(attractors)))

    def _by_state(self, attractors) -> dict[int, int]:
        far = np.full((len(attractors), len(self.last)), np.inf)
        for k, new in enumerate(attractors):
            for n, old in enumerate(self.last):
                if new.label == old.label:
                    far[k, n] = distance(new, old)
        found = {}
        for k in range(len(attractors)):
            if not self.last or far[k].min() > NEAR:
                continue
            n = int(far[k].argmin())
            if int(far[:, n].argmin()) == k:
                found[k] = n
        return found

    def _by_motion(self, attractors, census: Census, found: dict[int, int]) -> dict[int, int]:
        """Carry what is unmatched to the other speed, in both directions."""
        found = dict(found)
        for n in self.present:
            if n in found.values():
                continue
            k = _index(attractors, carried(self.last[n], self.before, census))
            if k is None or k in found:
                continue
            back = carried(attractors[k], census, self.before)
            if back is not None and back is self._at_before(n):
                found[k] = n
        return found

    def _at_before(self, n: int) -> Attractor | None:
        return next((a for a in self.before.attractors if a is self.last[n]), None)


def carried(attractor: Attractor, own: Census, other: Census) -> Attractor | None:
    """The attractor of another speed on which this one's state ends, velocity kept."""
    q, w = attractor.states[0]
    return other.destination(q, w * own.crew.omega)


def distance(a: Attractor, b: Attractor) -> float:
    """Largest distance from a state of one to the nearest of the other, over the orbit's size."""
    p, q = _thin(a.shown()), _thin(b.shown())
    apart = np.abs(p[:, None, :] - q[None, :, :]).max(axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()) / max(a.size, b.size))


def _thin(points: np.ndarray) -> np.ndarray:
    return points[:: max(1, len(points) // THINNED)]


def _index(attractors, wanted: Attractor | None) -> int | None:
    return next((k for k, a in enumerate(attractors) if a is wanted), None)
