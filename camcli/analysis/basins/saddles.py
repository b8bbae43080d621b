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
    """The saddles between the basins of attractors, codes 1, 2, ... of the cells of a window."""
    batches = finder.batches
    system = batches.system
    rpm = batches.rpm
    low, high = _pairs(window, codes)
    here = finder.settle(*low.T)[0]
    for _ in range(START_HALVINGS):
        middle = 0.5 * (low + high)
        same = (finder.settle(*middle.T)[0] == here)[:, None]
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    orbits: dict[int, PeriodicOrbit] = {}
    led: list[int] = []
    settings = with_turns(batches.settings, 0, TURNS)
    for gap, rate in zip(*batches.states(*low.T), strict=True):
        record = Orbit(system, rpm, settings, batches.start(gap, rate, FREE)).run(events=True)
        states = states_of(record)
        size = np.ptp(states, axis=0) + 1e-300
        known = _nearest(orbits, states / size, size)
        if known is None:
            for orbit in find_saddles(system, rpm, record, size):
                orbits[len(orbits)] = orbit
            known = _nearest(orbits, states / size, size)
        led += [] if known is None else [known]
    saddles = (BoundarySaddle(o, led.count(k), len(low)) for k, o in orbits.items() if k in led)
    return sorted(saddles, key=lambda saddle: -saddle.led)


def _pairs(window: Window, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States on one side of boundaries and on the other, two arrays (n, 2).

    They are the centres of neighbouring cells that lead to different attractors: at most STARTS
    such pairs, spread evenly over all of them.
    """
    cells = np.arange(codes.size).reshape(codes.shape)
    pairs = []
    beside = (np.s_[:, :-1], np.s_[:, 1:])
    above = (np.s_[:-1], np.s_[1:])
    for a, b in (beside, above):
        edge = (codes[a] != codes[b]) & (codes[a] > 0) & (codes[b] > 0)
        pairs.append(np.column_stack((cells[a][edge], cells[b][edge])))
    every = np.concatenate(pairs)
    count = min(STARTS, len(every))
    some = every[np.arange(count) * len(every) // max(1, count)]
    one, other = (np.column_stack(window.centres(some[:, k])) for k in (0, 1))
    return one, other


def _nearest(orbits: dict[int, PeriodicOrbit], at: np.ndarray, size: np.ndarray) -> int | None:
    """The saddle that relative states come closest to, None where none is near."""
    away = {
        k: np.abs(at[:, None] - np.array(orbit.states) / size).max(2).min()
        for k, orbit in orbits.items()
    }
    best = min(away, key=lambda k: away[k], default=None)
    return best if best is not None and away[best] < LED_TO else None
