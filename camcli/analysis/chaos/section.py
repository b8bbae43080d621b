"""Boxes in the impact section, and the theorem that makes them chaos.

An impact is the point (theta, v): its phase (rad within the turn) and the relative rate at which it
leaves the cam (m/rad). A box holds the points middle + M (x, y) with |x| <= 1 and |y| <= 1. Along x
the impact map P stretches, along y it contracts. Box N covers box K, N => K, where in the
coordinates (x, y) of K

    |y| < 1 on all of P(N),   x < -1 on P of one end of N, x = -1 or 1,   x > 1 on that of the other

(one unstable and one stable direction of P. Zgliczynski and M. Gidea, Covering relations for
multidimensional dynamical systems, J. Differential Equations 202 (2004) 32). Then for every
sequence of boxes N_0 => N_1 => N_2 ... there is a motion whose impact k lies in N_k, and a
periodic one where the sequence is periodic. With disjoint boxes motions of
different sequences are different, so the topological entropy of P is at least the logarithm of the
growth of the number of sequences, the spectral radius of the matrix A of the coverings.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np

from camcli.exact.shooting import ProofStep

PARTS = 10**9  # of one, to which the growth is rounded down
WEIGHT = 10**12  # the largest
POWER_STEPS = 2000  # of the iteration for the weights


@dataclass(frozen=True)
class Lands:
    """Where all flights from a box land: on a stretch, so many turns later.

    low, high: phases (rad within the turn) between which they do, as samples tell.
    """

    stretch: int
    turn: int
    low: float
    high: float


@dataclass(frozen=True)
class SectionBox:
    """A box on a stretch of the cam; axes: M = ((a, b), (c, d)), in rad and m/rad.

    lands: where its flights do; cells: parts along x and y on which the covering was shown.
    """

    stretch: int
    middle: tuple[float, float]
    axes: tuple[tuple[float, float], tuple[float, float]]
    lands: Lands
    cells: tuple[int, int] = (1, 1)

    @property
    def matrix(self) -> np.ndarray:
        """M."""
        return np.array(self.axes)

    @property
    def reach(self) -> tuple[float, float]:
        """How far the box goes from its middle in theta (rad) and v (m/rad)."""
        (a, b), (c, d) = self.axes
        return abs(a) + abs(b), abs(c) + abs(d)

    def inside(self, points: np.ndarray) -> np.ndarray:
        """The coordinates (x, y), shape (2, n), of points (theta, v)."""
        return np.linalg.solve(self.matrix, points - np.array(self.middle)[:, None])


@dataclass(frozen=True)
class Chaos:
    """Boxes about a saddle with one impact, and about a chain of impacts from it back to it.

    coverings: pairs of box numbers, counted from 0. growth: a number below the spectral radius of
    their matrix A; weights: w with A w >= growth w, which show that. step: of the proof that
    failed, None where it holds. flights: of each box's cells, as a certificate has them.
    flank_excess: by how much the radius of the flank circle is larger than the scene's, m.
    """

    rpm: float
    label: str = ""
    boxes: tuple[SectionBox, ...] = ()
    coverings: tuple[tuple[int, int], ...] = ()
    growth: float = 1.0
    weights: tuple[int, ...] = ()
    step: ProofStep | None = None
    flights: tuple[tuple[dict[str, Any], ...], ...] = ()
    flank_excess: float = 0.0

    @property
    def proved(self) -> bool:
        """Whether the theorem holds."""
        return self.step is None

    @property
    def per_impact(self) -> float:
        """The lower bound of the entropy of the impact map."""
        return log(self.growth)

    @property
    def turns(self) -> int:
        """How often the angle zero passes between an impact and the next one, at most."""
        return max(box.lands.turn for box in self.boxes)

    @property
    def per_turn(self) -> float:
        """The bound for a turn: n impacts take some n times `turns`, or fewer."""
        return self.per_impact / max(1, self.turns)

    @property
    def per_second(self) -> float:
        """The bound for a second."""
        return self.per_turn * self.rpm / 60.0


@dataclass(frozen=True)
class ChaosView:
    """What a picture shows beside the boxes, points (theta, v) of shape (2, n).

    impacts: of a simulation from the scene's start; outlines: of the boxes, closed; images: where
    the flights from these land.
    """

    impacts: np.ndarray
    outlines: tuple[np.ndarray, ...] = ()
    images: tuple[np.ndarray, ...] = ()


def growth_of(count: int, coverings: tuple[tuple[int, int], ...]) -> tuple[float, tuple[int, ...]]:
    """(growth, weights): w >= 0 with A w >= growth w, so the spectral radius of A is no smaller.

    count: of the boxes; coverings: pairs of their numbers, where A has a one. w is near the
    eigenvector that the powers of 1 + A tend to, in whole numbers; the growth is rounded down.
    """
    a = np.zeros((count, count))
    for i, j in coverings:
        a[i, j] = 1.0
    w = np.ones(count)
    for _ in range(POWER_STEPS):
        w = w + a @ w
        w /= w.max()
    weights = [round(float(x) * WEIGHT) for x in w]
    of_covered = [sum(weights[j] for i, j in coverings if i == k) for k in range(count)]
    least = min(
        grown * PARTS // weight for grown, weight in zip(of_covered, weights, strict=True) if weight
    )
    return least / PARTS, tuple(weights)
