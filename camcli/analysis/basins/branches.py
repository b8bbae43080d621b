"""Attractors matched from speed to speed: a number stays with an attractor as the speed changes.

First by state: of one label, each the nearest to the other, and near. Then by motion: each, started
at the other's speed, ends on the other. What is left begins a branch of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.attractor_finder import AttractorFinder

NEAR = 0.3  # of the orbit's size
THINNED = 400  # states of an aperiodic attractor compared


@dataclass
class Branches:
    """The last known attractor of every branch; branch n is entry n - 1."""

    last: list[Attractor] = field(default_factory=list)
    present: list[int] = field(default_factory=list)  # branches at the speed before
    before: AttractorFinder | None = None

    def number(self, attractors: tuple[Attractor, ...], finder: AttractorFinder) -> tuple[int, ...]:
        """Branch of each attractor of the next speed."""
        found = self._by_state(attractors)
        found = self._by_motion(attractors, finder, found)
        for k, attractor in enumerate(attractors):
            if k not in found:
                self.last.append(attractor)
                found[k] = len(self.last) - 1
            self.last[found[k]] = attractor
        self.present = sorted(found.values())
        self.before = finder
        return tuple(found[k] + 1 for k in range(len(attractors)))

    def _by_state(self, attractors: Sequence[Attractor]) -> dict[int, int]:
        if not self.last:
            return {}
        far = np.full((len(attractors), len(self.last)), np.inf)
        for k, new in enumerate(attractors):
            for n, old in enumerate(self.last):
                if new.label == old.label:
                    far[k, n] = distance(new, old)
        pairs = ((k, int(far[k].argmin())) for k in range(len(attractors)))
        return {k: n for k, n in pairs if far[k, n] <= NEAR and int(far[:, n].argmin()) == k}

    def _by_motion(
        self, attractors: Sequence[Attractor], finder: AttractorFinder, found: dict[int, int]
    ) -> dict[int, int]:
        """Carry what is unmatched to the other speed, in both directions."""
        found, before = dict(found), self.before
        for n in self.present:
            if n in found.values() or before is None:
                continue
            old = self.last[n]
            new = carried(old, before, finder)
            k = next((k for k, one in enumerate(attractors) if one is new), None)
            if k is not None and k not in found and carried(attractors[k], finder, before) is old:
                found[k] = n
        return found


def carried(attractor: Attractor, own: AttractorFinder, other: AttractorFinder) -> Attractor | None:
    """The attractor of another speed on which this one's state ends, velocity kept."""
    q, w = attractor.states[0]
    return other.destination(q, w * own.batches.omega)


def distance(a: Attractor, b: Attractor) -> float:
    """Largest distance from a state of one to the nearest of the other, over the orbit's size."""
    p, q = _thin(a.shown()), _thin(b.shown())
    apart = np.abs(p[:, None, :] - q[None, :, :]).max(axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()) / max(a.size, b.size))


def _thin(points: np.ndarray) -> np.ndarray:
    return points[:: max(1, len(points) // THINNED)]
