"""Saddles on the boundaries of basins, by edge tracking.

Two starts on either side of a boundary are brought together by bisection until rounding ends it.
The motion between them stays on the boundary as long as rounding lets it, and is led to a saddle:
the boundary is the stable manifold of that saddle, which Newton's method solves from a close
return.

J. D. Skufca, J. A. Yorke and B. Eckhardt, Edge of chaos in a parallel shear flow, Physical Review
Letters 96, 174101 (2006).
"""

from dataclasses import dataclass

import numpy as np

from camcli.analysis.basins.attractor_finder import AttractorFinder
from camcli.analysis.basins.window import Window
from camcli.analysis.explain.attractor import states_of
from camcli.analysis.explain.saddles import find_saddles
from camcli.analysis.integrate import Orbit, with_turns
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.kernel.flight import FREE

STARTS = 24  # pairs of neighbouring cells, spread over all boundaries
START_HALVINGS = 60  # of the way between two starts: neighbouring doubles are reached before
TURNS = 100  # followed: a saddle with a multiplier of 1.4 lets go after as many
LED_TO = 1e-3  # relative: a motion that comes so near to a saddle was led to it


@dataclass(frozen=True)
class BoundarySaddle:
    """A saddle, and how many of the motions `tried` on the boundaries were led to it."""

    orbit: PeriodicOrbit
    led: int
    tried: int


def boundary_saddles(
    finder: AttractorFinder, window: Window, codes: np.ndarray
) -> list[BoundarySaddle]:
    """The saddles between the basins of attractors, codes 1, 2, ... of the cells of a window.

    Those to which most motions on the boundaries were led come first.
    """
    batches = finder.batches
    system = batches.system
    rpm = batches.rpm
    starts = _on_boundaries(finder, window, codes)
    orbits: list[PeriodicOrbit] = []
    led_to: list[int] = []  # indices of orbits, one for each motion that was led to one
    settings = with_turns(batches.settings, 0, TURNS)
    for gap, rate in zip(*batches.states(*starts.T), strict=True):
        record = batches.record(Orbit(system, rpm, settings, batches.start(gap, rate, FREE)))
        states = states_of(record)
        size = np.ptp(states, axis=0) + 1e-300
        nearest = _nearest(orbits, states / size, size)
        if nearest is None:
            orbits += find_saddles(system, rpm, record, size)
            nearest = _nearest(orbits, states / size, size)
        if nearest is not None:
            led_to.append(nearest)
    saddles = [
        BoundarySaddle(orbit, led_to.count(k), len(starts))
        for k, orbit in enumerate(orbits)
        if k in led_to
    ]
    return sorted(saddles, key=lambda saddle: -saddle.led)


def _on_boundaries(finder: AttractorFinder, window: Window, codes: np.ndarray) -> np.ndarray:
    """Starts on boundaries, but for rounding, (n, 2) of q (m) and v (m/s).

    Each lies between two neighbouring cells that end elsewhere: the way between them is halved, and
    the half kept whose ends still end elsewhere.
    """
    low, high = _pairs(window, codes)
    outcome_at_low, _ = finder.settle(*low.T)
    for _ in range(START_HALVINGS):
        middle = 0.5 * (low + high)
        outcome, _ = finder.settle(*middle.T)
        ends_as_low = (outcome == outcome_at_low)[:, None]
        low = np.where(ends_as_low, middle, low)
        high = np.where(ends_as_low, high, middle)
    return low


def _pairs(window: Window, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States on one side of boundaries and on the other, two arrays (n, 2) of q and v.

    They are the centres of neighbouring cells that lead to different attractors: at most STARTS
    such pairs, spread evenly over all of them.
    """
    cells = np.arange(codes.size).reshape(codes.shape)
    pairs = []
    beside = (np.s_[:, :-1], np.s_[:, 1:])  # a cell, and the next one in its row
    above = (np.s_[:-1], np.s_[1:])  # a cell, and the one in the next row
    for one, other in (beside, above):
        differ = (codes[one] != codes[other]) & (codes[one] > 0) & (codes[other] > 0)
        pairs.append(np.column_stack((cells[one][differ], cells[other][differ])))
    all_pairs = np.concatenate(pairs)
    count = min(STARTS, len(all_pairs))
    chosen = all_pairs[np.arange(count) * len(all_pairs) // max(1, count)]
    low = np.column_stack(window.centres(chosen[:, 0]))
    high = np.column_stack(window.centres(chosen[:, 1]))
    return low, high


def _nearest(orbits: list[PeriodicOrbit], states: np.ndarray, size: np.ndarray) -> int | None:
    """The index of the saddle that a motion comes closest to, None where none is within LED_TO.

    states: of the motion at the strobe, (n, 2), over `size`, (2,).
    """
    if not orbits:
        return None
    distances = [
        np.abs(states[:, None] - np.array(orbit.states) / size).max(2).min() for orbit in orbits
    ]
    nearest = int(np.argmin(distances))
    return nearest if distances[nearest] < LED_TO else None
