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


class FoldPoint(NamedTuple):
    """The lowest eta in a window of t: eta there, where it is, and xi there."""

    eta: float
    t: float
    xi: float


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


class Tangency(NamedTuple):
    """A fold where it touches W^s, at its speed.

    change: how far its last n moved that speed, rpm.
    """

    fold: Fold
    change: float


class FirstTouch(NamedTuple):
    """The earliest tangency seen, and how much earlier one that was not sampled may be, rpm."""

    fold: Fold
    error: float


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
        """(eta, xi) about p after 0, ..., n turns from t, shape (n + 1, 2).

        pair: B and p at that speed. inf where there is no such motion.
        """
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
        base, _ = pair
        periods = 1 if base.mu > 0.0 else 2
        log_mu = log(abs(base.mu))
        spacing = log_mu * periods / self.sampling.starts
        n = AFTER + int(self.base.turns * log(1.0 / ON_MANIFOLD) / log_mu)
        t = spacing * (np.arange(self.sampling.starts) + shift)
        places = np.array([self.places(rpm, pair, x, n) for x in t])  # by start, turn, (eta, xi)
        near_saddle = (np.abs(places) < NEAR_SADDLE).all(2)
        eta = np.where(near_saddle, places[..., 0], inf)
        inner = eta[1:-1]
        lower_than_beside = (inner < inf) & (inner <= eta[:-2]) & (inner <= eta[2:])
        minima = [(int(k) + 1, int(turns)) for k, turns in np.argwhere(lower_than_beside)]
        lowest_first = sorted(minima, key=lambda at: (eta[at], at[1], at[0]))
        folds = []
        for k, turns in lowest_first[:REFINED]:
            point = self.lowest(rpm, turns, t[k], spacing, COARSE)
            if abs(point.eta) < NEAR_SADDLE:
                folds.append(Fold(rpm, turns, point.t, 0.5 * spacing, point.eta))
        return sorted(folds, key=lambda fold: (fold.eta, fold.n, fold.t))

    def lowest(
        self, rpm: float, n: int, t: float, half: float, samples: int = FOLD_SAMPLES
    ) -> FoldPoint:
        """The lowest eta within t +- half after n turns."""
        pair = self.at(rpm)

        def eta(share: float) -> float:
            """eta at a share, from -1 to 1, of the window."""
            return self.places(rpm, pair, t + half * share, n)[n, 0]

        value, share = lowest(eta, -1.0, 1.0, samples)
        at = t + half * share
        xi = self.places(rpm, pair, at, n)[n, 1]
        return FoldPoint(float(value), at, float(xi))

    def corner(self, fold: Fold) -> Corner | None:
        """The corner whose image the fold is; None for a smooth fold."""
        base, _ = self.at(fold.rpm)
        record = self.carried.motion(fold.rpm, base.leaf(fold.t), fold.n, True)
        theta = impacts_of(record)[0]
        corners = corner_list(self.carried.system.cam)
        hit = [c for c in corners if np.abs(theta - c.theta).min(initial=inf) < AT_CORNER]
        return hit[0] if hit else None


def first_touch(folds: Folds, rpm: float) -> FirstTouch | None:
    """The earliest tangency seen from the near end; None where none touches.

    Each search samples other folds, and only those that have touched before the best speed so far.
    The first one samples them at rpm. Raises LostError where B or p cannot be followed.
    """
    way = folds.carried.way
    best: Tangency | None = None
    solved_speeds = []
    searches = folds.sampling.searches
    for k in range(searches):
        seen = folds.sample(rpm, k / searches)
        if best is not None:
            seen = [fold for fold in seen if fold.eta < BELOW]
        tried = [touch(folds, fold) for fold in seen[: folds.sampling.solved]]
        tangencies = [tangency for tangency in tried if tangency is not None]
        solved_speeds += [tangency.fold.rpm for tangency in tangencies]
        earliest = min(tangencies, key=lambda one: way(one.fold.rpm), default=None)
        if best is None and earliest is None:
            break
        if earliest is not None and (best is None or way(earliest.fold.rpm) < way(best.fold.rpm)):
            best = earliest
            rpm = earliest.fold.rpm
    if best is None:
        return None
    error = width(folds.carried, best.fold.rpm, best.change, solved_speeds)
    return FirstTouch(best.fold, error)


def touch(folds: Folds, fold: Fold) -> Tangency | None:
    """Where a fold touches W^s: the speed is solved for n turns, then for a period of p more.

    It is solved where W^s is straight from the fold to p, or where the speed no longer moves. None
    where the fold leaves p or the range of speeds first.
    """
    solved = _secants(folds, fold)
    rpm_before = None
    while solved is not None:
        small = SPEED_STEP * solved.rpm
        change = small if rpm_before is None else abs(solved.rpm - rpm_before)
        still = rpm_before is not None and change <= small
        if abs(solved.xi) <= STRAIGHT or still:
            return Tangency(solved, change)
        rpm_before = solved.rpm
        half = solved.half / max(abs(folds.saddle.multipliers[0]), LEAST_GROWTH)
        longer = replace(solved, n=solved.n + folds.saddle.turns, half=half)
        solved = _secants(folds, longer)
    return None


def _secants(folds: Folds, fold: Fold) -> Fold | None:
    """Solve eta = 0 for the speed after n turns; the fold is looked for where it drifts to.

    None where it leaves p or the range of speeds, or too many secants are spent on it.
    """
    carried = folds.carried
    n = fold.n
    half = fold.half
    slope = fold.slope
    rpm = fold.rpm
    step = copysign(SPEED_STEP * rpm, carried.far - carried.near)
    here = folds.lowest(rpm, n, fold.t, half)
    for used in range(1, fold.left + 1):
        rpm = rpm + step
        before = here
        here = folds.lowest(rpm, n, before.t + slope * step, half)
        outside = (rpm - carried.near) * (rpm - carried.far) > 0.0
        if outside or abs(here.eta) > NEAR_SADDLE or here.eta == before.eta:
            return None
        if abs(step) >= SPEED_STEP * rpm:
            slope = (here.t - before.t) / step
        longest = MOST * abs(step)
        secant = -here.eta * step / (here.eta - before.eta)
        step = min(max(secant, -longest), longest)
        if abs(here.eta) <= TOUCH and abs(step) <= SPEED_STEP * rpm:
            return Fold(rpm, n, here.t, half, here.eta, here.xi, slope, fold.left - used)
    return None


def width(carried: CarriedAttractor, rpm: float, change: float, solved: list[float]) -> float:
    """Error of the earliest tangency (rpm): how much earlier a fold not sampled may touch.

    change: of its speed with its last n; solved: the speeds of all tangencies.

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
    ways = sorted(carried.way(other) for other in solved)  # from the near end
    earliest = ways[0]
    # the ways of the next tangencies, where they are not the same as the one before
    others = [b for a, b in pairwise(ways) if b - a > SPEED_STEP * rpm][: RANK - 1]
    to_runs = max(abs(rpm - carried.stays), abs(rpm - carried.leaves))
    error = LIFETIMES * to_runs
    count = len(others) + 1  # n
    if count < FEW:
        if others:
            error = min(error, others[0] - earliest)
        error = max(error, UNSAMPLED * rpm)
    else:
        share = (1.0 - DOUBT ** (1.0 / len(others))) ** (1.0 / carried.crowding)  # x/(1 + x)
        x = share / (1.0 - share)
        error = min(error, x * (others[-1] - earliest))
    delay = carried.way(rpm) - carried.way(carried.leaves)
    return max(error, change, delay)
