"""Folds of the unstable manifold of an orbit B in the attractor over the stable one of a saddle p.

t runs along W^u(B), x_n(t) is the state n turns on and eta(x_n(t)) its coordinate across W^s(p),
positive on the side of the attractor. A fold is a minimum over t of eta, smooth, or a kink that is
the image of an impact at a corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, log

import numpy as np

from camcli.analysis.bracketing import lowest
from camcli.analysis.explain.crisis.manifold import FIRST, LostError, Saddle
from camcli.analysis.explain.crisis.runs import Carried
from camcli.analysis.explain.crisis.saddles import AFTER
from camcli.analysis.integrate import StartError
from camcli.analysis.orbits.orbit import PeriodicOrbit

STARTS = 4000  # along the whole of W^u(B)
NEAR = 0.05  # relative: |eta| and |xi| within which coordinates about p mean something
REFINED = 60  # lowest minima among the starts that are refined
COARSE = 2  # samples of the window in which a minimum is refined at first
WINDOW = 12  # samples of the window in which a fold is followed


@dataclass(frozen=True)
class Fold:
    """A minimum eta at t after n turns, alone within t +- half."""

    eta: float
    n: int
    t: float
    half: float


@dataclass(frozen=True)
class Folds:
    """The folds of W^u(base) over W^s(saddle); side: +-1, the attractor's side of the saddle."""

    carried: Carried
    base: PeriodicOrbit
    saddle: PeriodicOrbit
    side: float

    def at(self, rpm: float) -> tuple[Saddle, Saddle]:
        """B and p at this speed; raises LostError where either cannot be followed to it."""
        base = Saddle(self.carried, rpm, self.base)
        if abs(base.mu) <= 1.0:
            raise LostError
        return base, Saddle(self.carried, rpm, self.saddle)

    def places(self, rpm: float, pair: tuple[Saddle, Saddle], t: float, n: int) -> np.ndarray:
        """(eta, xi) about p after 0, ..., n turns from t; inf where there is no such motion."""
        base, saddle = pair
        result = np.full((n + 1, 2), inf)
        try:
            x = self.carried.states(rpm, base.leaf(t), n)[: n + 1]
        except StartError:
            return result
        result[: len(x)] = (x - saddle.x) @ saddle.to * (self.side, 1.0)
        return result

    def sample(self, rpm: float, shift: float) -> list[Fold]:
        """Folds among STARTS starts, refined, lowest first; `shift` moves them by part of a gap."""
        pair = self.at(rpm)
        mu = pair[0].mu
        gap = log(abs(mu)) * (1 if mu > 0.0 else 2) / STARTS
        n = AFTER + int(self.base.turns * log(1.0 / FIRST) / log(abs(mu)))
        t = gap * (np.arange(STARTS) + shift)
        tips = []
        for k, turns in self._minima(np.array([self.places(rpm, pair, x, n) for x in t])):
            eta, x, _ = self.lowest(rpm, turns, t[k], gap, COARSE)
            if abs(eta) < NEAR:
                tips.append(Fold(eta, turns, x, 0.5 * gap))
        return sorted(tips, key=lambda fold: (fold.eta, fold.n, fold.t))

    def _minima(self, places: np.ndarray) -> list[tuple[int, int]]:
        """(start, turns) of the REFINED lowest minima of eta from start to start."""
        eta = np.where((np.abs(places) < NEAR).all(2), places[..., 0], inf)
        low = (eta[1:-1] < inf) & (eta[1:-1] <= eta[:-2]) & (eta[1:-1] <= eta[2:])
        found = [(int(k) + 1, int(n)) for k, n in np.argwhere(low)]
        return sorted(found, key=lambda at: (eta[at], at[1], at[0]))[:REFINED]

    def lowest(self, rpm: float, n: int, t: float, half: float, samples: int = WINDOW):
        """(eta, t, xi) of the lowest eta within t +- half after n turns."""
        pair = self.at(rpm)

        def eta(y: float) -> float:
            return self.places(rpm, pair, t + half * y, n)[n, 0]

        value, y = lowest(eta, -1.0, 1.0, samples)
        t = t + half * y
        return float(value), t, float(self.places(rpm, pair, t, n)[n, 1])
