"""The speed at which a fold of W^u(B) touches W^s(p): min over t of eta(x_n(t; rpm)) = 0.

B is an orbit in the attractor, p a saddle. t runs along W^u(B), x_n(t) is the state n turns on and
eta(x_n(t)) its coordinate across W^s(p), positive on the side of the attractor. A fold is a minimum
over t of eta, smooth, or a kink that is the image of an impact at a corner. Secants solve for the
speed with a fixed n; then n grows by the period of p, which brings the fold nearer to p along W^s,
until W^s is straight there. Where the speed no longer moves, it is solved.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import copysign, inf, log
from typing import NamedTuple

import numpy as np

from camcli.analysis.bracketing import lowest
from camcli.analysis.explain.attractor import CarriedAttractor, impacts_of
from camcli.analysis.explain.saddles import AFTER, ON_MANIFOLD, LostError, Saddle
from camcli.analysis.integrate import StartError
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.cams.regions import Corner, corner_list

NEAR_SADDLE = 0.05  # relative: |eta| and |xi| within which coordinates about p mean something
REFINED = 60  # lowest minima among the starts that are refined
COARSE = 2  # samples of the window in which a minimum is refined at first
FOLD_SAMPLES = 12  # samples of the window in which a fold is followed
SECANTS = 150  # steps for one fold
TOUCH = 1e-6  # relative: an eta that counts as none
BELOW = -1e-7  # relative: a fold lower than this at a tangency has touched earlier
STRAIGHT = 1e-5  # relative: xi within which W^s is straight
SPEED_STEP = 1e-9  # of the speed: first step of the secants, and a step that ends them
MOST = 5.0  # times the last step: the longest next one
LEAST_GROWTH = 1.5  # by which the window shrinks at least when n grows by a period
RANK = 5  # tangencies that tell the error, counted from the earliest
UNSAMPLED = 4e-7  # of the speed: 9001 starts and 12 folds have found tangencies so much earlier
FEW = 4  # tangencies: fewer may be of neighbouring folds
DOUBT = 1.0 / 16.0  # of the errors do not hold
LIFETIMES = 3.0  # runs leave within so many mean lifetimes but for one in twenty (e^-3)
AT_CORNER = 1e-6  # rad: an impact so near a corner is at it


class Sampling(NamedTuple):
    """How thoroughly folds are looked for.

    starts: motions that begin along the whole of W^u(B); searches: samples of folds, each at the
    earliest tangency so far; solved: how many of the lowest folds are solved in each.
    """

    starts: int = 4000
    searches: int = 5
    solved: int = 6


USUAL = Sampling()


@dataclass(frozen=True)
class Fold:
    """A minimum of eta over t +- half, at t after n turns, seen at rpm; xi: along W^s there.

    slope: dt/drpm, its drift; left: secants that may still be spent on it.
    """

    rpm: float
    n: int
    t: float
    half: float
    eta: float
    xi: float = inf
    slope: float = 0.0
    left: int = SECANTS


@dataclass(frozen=True)
class Folds:
    """The folds of W^u(base) over W^s(saddle); side: +-1, the attractor's side of the saddle."""

    carried: CarriedAttractor
    base: PeriodicOrbit
    saddle: PeriodicOrbit
    side: float
    sampling: Sampling = USUAL

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
        """The REFINED lowest folds at this speed, the lowest first.

        Motions begin on the unstable manifold of the base, evenly spaced in t over one
        period of it (mu times as far from the base), or over two where mu is negative.
        A fold is where the height eta about the saddle has a minimum over t. `shift` moves all
        starts by a share of their spacing, so that another search sees other folds.
        """
        pair = self.at(rpm)
        mu = pair[0].mu
        periods = 1 if mu > 0.0 else 2
        gap = log(abs(mu)) * periods / self.sampling.starts
        n = AFTER + int(self.base.turns * log(1.0 / ON_MANIFOLD) / log(abs(mu)))
        t = gap * (np.arange(self.sampling.starts) + shift)
        places = np.array([self.places(rpm, pair, x, n) for x in t])
        eta = np.where((np.abs(places) < NEAR_SADDLE).all(2), places[..., 0], inf)
        low = (eta[1:-1] < inf) & (eta[1:-1] <= eta[:-2]) & (eta[1:-1] <= eta[2:])
        minima = [(int(k) + 1, int(turns)) for k, turns in np.argwhere(low)]
        folds = []
        for k, turns in sorted(minima, key=lambda at: (eta[at], at[1], at[0]))[:REFINED]:
            value, x, _ = self.lowest(rpm, turns, t[k], gap, COARSE)
            if abs(value) < NEAR_SADDLE:
                folds.append(Fold(rpm, turns, x, 0.5 * gap, value))
        return sorted(folds, key=lambda fold: (fold.eta, fold.n, fold.t))

    def lowest(
        self, rpm: float, n: int, t: float, half: float, samples: int = FOLD_SAMPLES
    ) -> tuple[float, float, float]:
        """(eta, t, xi) of the lowest eta within t +- half after n turns."""
        pair = self.at(rpm)

        def eta(y: float) -> float:
            return self.places(rpm, pair, t + half * y, n)[n, 0]

        value, y = lowest(eta, -1.0, 1.0, samples)
        at = t + half * y
        return float(value), at, float(self.places(rpm, pair, at, n)[n, 1])

    def corner(self, fold: Fold) -> Corner | None:
        """The corner whose image the fold is; None for a smooth fold."""
        base, _ = self.at(fold.rpm)
        record = self.carried.motion(fold.rpm, base.leaf(fold.t), fold.n, True)
        theta = impacts_of(record)[0]
        corners = corner_list(self.carried.system.cam)
        hit = [c for c in corners if np.abs(theta - c.theta).min(initial=inf) < AT_CORNER]
        return hit[0] if hit else None


def first_touch(folds: Folds, rpm: float) -> tuple[Fold, float] | None:
    """(fold, error) of the earliest tangency seen from the near end; None where none touches.

    Each search samples other folds, and only those that have touched before the best speed so far.
    Raises LostError where B or p cannot be followed.
    """
    best = None
    change = inf
    solved = []

    def earlier(one: Fold, other: Fold) -> bool:
        return folds.carried.way(one.rpm) < folds.carried.way(other.rpm)

    searches = folds.sampling.searches
    for k in range(searches):
        seen = folds.sample(rpm, k / searches)
        if best is not None:
            seen = [fold for fold in seen if fold.eta < BELOW]
        tried = [touch(folds, fold) for fold in seen[: folds.sampling.solved]]
        tangencies = [pair for pair in tried if pair is not None]
        solved += [fold.rpm for fold, _ in tangencies]
        new = min(tangencies, key=lambda pair: folds.carried.way(pair[0].rpm), default=None)
        if best is None and new is None:
            break
        if new is not None and (best is None or earlier(new[0], best)):
            (best, change), rpm = new, new[0].rpm
    return None if best is None else (best, width(folds.carried, best.rpm, change, solved))


def touch(folds: Folds, fold: Fold) -> tuple[Fold, float] | None:
    """The fold where it touches W^s, and how far its last n moved that speed (rpm).

    None where it leaves p or the range of speeds first.
    """
    now = _secants(folds, fold)
    before = None
    while now is not None:
        goal = SPEED_STEP * now.rpm
        change = goal if before is None else abs(now.rpm - before)
        if abs(now.xi) <= STRAIGHT or (before is not None and change <= goal):
            return now, change
        before = now.rpm
        half = now.half / max(abs(folds.saddle.multipliers[0]), LEAST_GROWTH)
        now = _secants(folds, replace(now, n=now.n + folds.saddle.turns, half=half))
    return None


def _secants(folds: Folds, fold: Fold) -> Fold | None:
    """Solve eta = 0 for the speed after n turns; the fold is looked for where it drifts to."""
    carried = folds.carried
    n = fold.n
    half = fold.half
    slope = fold.slope
    rpm = fold.rpm
    step = copysign(SPEED_STEP * rpm, carried.far - carried.near)
    value, t, _ = folds.lowest(rpm, n, fold.t, half)
    for used in range(1, fold.left + 1):
        rpm = rpm + step
        last_value = value
        last_t = t
        value, t, xi = folds.lowest(rpm, n, t + slope * step, half)
        outside = (rpm - carried.near) * (rpm - carried.far) > 0.0
        if outside or abs(value) > NEAR_SADDLE or value == last_value:
            return None
        if abs(step) >= SPEED_STEP * rpm:
            slope = (t - last_t) / step
        most = MOST * abs(step)
        step = min(max(-value * step / (value - last_value), -most), most)
        if abs(value) <= TOUCH and abs(step) <= SPEED_STEP * rpm:
            return Fold(rpm, n, t, half, value, xi, slope, fold.left - used)
    return None


def width(carried: CarriedAttractor, rpm: float, change: float, solved: list[float]) -> float:
    """Error of the earliest tangency (rpm): how much earlier a fold not sampled may touch.

    A tangency that is solved is one, so the crisis is there or earlier. How much earlier, the
    others tell: the speeds at which folds touch end at the crisis, and those solved are the
    earliest of a sample of them. Folds are images of folds: across its leaves the attractor is a
    Cantor set of the dimension alpha = `carried.crowding`, so the share of folds nearer to the
    outermost one than d grows as d^alpha. Then of the distances d_1 < ... < d_n of a sample
    (d_1/d_n)^alpha is the least of n - 1 numbers spread evenly over 0 to 1, and
        d_1 > x (d_n - d_1)  with the probability  (1 - (x/(1 + x))^alpha)^(n - 1).
    x is such that this is one in sixteen, n at most RANK. Less than FEW may be of one bundle of
    folds, which tells nothing of the others. (The end of a distribution from its extremes, there
    with alpha = 1: D. S. Robson and J. H. Whitlock, Biometrika 51 (1964) 33.)

    At most LIFETIMES times the distance to the runs: when they first leave is known to a factor.
    Where there are less than FEW, the error is that or the distance to the next one where it is
    less, but at least UNSAMPLED: a measured value, not a derived one.
    Never less than the change by the last period of p, and the delay behind a run that has left
    before. An error with a probability, not a bound.
    """
    off = sorted(carried.way(other) for other in solved)
    apart = [b for a, b in pairwise(off) if b - a > SPEED_STEP * rpm][: RANK - 1]
    runs = max(abs(rpm - carried.stays), abs(rpm - carried.leaves))
    error = LIFETIMES * runs
    if 0 < len(apart) < FEW - 1:
        error = min(error, apart[0] - off[0])
    if len(apart) < FEW - 1:
        error = max(error, UNSAMPLED * rpm)
    if len(apart) + 1 >= FEW:
        share = (1.0 - DOUBT ** (1.0 / len(apart))) ** (1.0 / carried.crowding)  # x/(1 + x)
        error = min(error, share / (1.0 - share) * (apart[-1] - off[0]))
    late = carried.way(rpm) - carried.way(carried.leaves)
    return max(error, change, late)
