"""The speed at which a fold of W^u(B) touches W^s(p): min over t of eta(x_n(t; rpm)) = 0.

Secants in the speed for a fixed n; then n grows by the period of p, which brings the fold nearer
to p along W^s, until W^s is straight there. Where the speed no longer moves, it is solved.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from camcli.analysis.explain.crisis.folds import NEAR, Fold, Folds

SEARCHES = 5  # samples of folds, each at the earliest tangency so far
FOLDS = 6  # lowest folds solved in each
SECANTS = 150  # steps for one fold
TOUCH = 1e-6  # relative: an eta that counts as none
BELOW = -1e-7  # relative: a fold lower than this at a tangency has touched earlier
STRAIGHT = 1e-5  # relative: xi within which W^s is straight
CLOSE = 1e-9  # of the speed: a step that ends the secants; nearer folds count as one
STEP = 1e-9  # of the speed: first step of the secants
MOST = 5.0  # times the last step: the longest next one
LEAST_GROWTH = 1.5  # by which the window shrinks at least when n grows by a period
UNSAMPLED = 4e-7  # of the speed: 9001 starts and 12 folds have found tangencies so much earlier
LIFETIMES = 3.0  # runs leave within so many mean lifetimes but for one in twenty (e^-3)


@dataclass(frozen=True)
class Tangency:
    """A fold that touches W^s at `rpm`, at t after n turns; change: by the last period of p, rpm.

    It is alone within t +- half and drifts by dt/drpm = slope. error (rpm): see `width`; inf until
    several folds are compared.
    """

    rpm: float
    n: int
    t: float
    change: float
    half: float
    slope: float
    error: float = inf


@dataclass(frozen=True)
class _Root:
    """The speed solved for one n: t and xi of the fold, its drift dt/drpm, secants left."""

    rpm: float
    t: float
    xi: float
    slope: float
    left: int


def touch(folds: Folds, rpm: float, fold: Fold) -> Tangency | None:
    """Where a fold seen at `rpm` touches; None where it leaves p or the range of speeds first."""
    n, half, solved = fold.n, fold.half, None
    root = _Root(rpm, fold.t, inf, 0.0, SECANTS)
    while True:
        root = _secants(folds, root, n, half)
        if root is None:
            return None
        goal = CLOSE * root.rpm
        change = goal if solved is None else abs(root.rpm - solved)
        if abs(root.xi) <= STRAIGHT or (solved is not None and change <= goal):
            return Tangency(root.rpm, n, root.t, change, half, root.slope)
        solved = root.rpm
        n += folds.saddle.turns
        half /= max(abs(folds.saddle.multipliers[0]), LEAST_GROWTH)


def _secants(folds: Folds, start: _Root, n: int, half: float) -> _Root | None:
    """Solve eta = 0 for the speed after n turns; the fold is looked for where it drifts to."""
    carried, slope = folds.carried, start.slope
    rpm, step = start.rpm, STEP * start.rpm * carried.ahead
    value, t, _ = folds.lowest(rpm, n, start.t, half)
    for used in range(1, start.left + 1):
        rpm, last_value, last_t = rpm + step, value, t
        value, t, xi = folds.lowest(rpm, n, t + slope * step, half)
        outside = (rpm - carried.near) * (rpm - carried.far) > 0.0
        if outside or abs(value) > NEAR or value == last_value:
            return None
        if abs(step) >= STEP * rpm:
            slope = (t - last_t) / step
        most = MOST * abs(step)
        step = min(max(-value * step / (value - last_value), -most), most)
        if abs(value) <= TOUCH and abs(step) <= CLOSE * rpm:
            return _Root(rpm, t, xi, slope, start.left - used)
    return None


def first_touch(folds: Folds, rpm: float) -> Tangency | None:
    """The earliest tangency seen from the near end; None where no fold solved touches.

    Each search samples other folds, and only those that have touched before the best speed so far.
    Raises LostError where B or p cannot be followed.
    """
    best, solved = None, []
    for k in range(SEARCHES):
        seen = folds.sample(rpm, k / SEARCHES)
        if best is not None:
            seen = [fold for fold in seen if fold.eta < BELOW]
        tried = [touch(folds, rpm, fold) for fold in seen[:FOLDS]]
        found = [tangency for tangency in tried if tangency is not None]
        solved += found
        new = min(found, key=lambda x: folds.carried.way(x.rpm), default=None)
        if new is None or (best and folds.carried.way(new.rpm) >= folds.carried.way(best.rpm)):
            break
        best, rpm = new, new.rpm
    if best is None:
        return None
    error = width(folds, best, [x.rpm for x in solved])
    return replace(best, error=error)


def width(folds: Folds, best: Tangency, solved: list[float]) -> float:
    """Error of the earliest tangency (rpm): how much earlier a fold not sampled may touch.

    The scatter, that is the distance to the next fold solved and UNSAMPLED at least, or LIFETIMES
    times the distance to the runs where that is less: when they first leave is known to a factor.
    Never less than the change by the last period of p, nor than the delay behind a run that has
    left before. An estimate, not a bound: folds that let almost nothing through may touch earlier.
    """
    off = [abs(rpm - best.rpm) for rpm in solved]
    scatter = min((x for x in off if x > CLOSE * best.rpm), default=inf)
    scatter = max(scatter, UNSAMPLED * best.rpm)
    stays, leaves = folds.carried.bracket
    runs = max(abs(best.rpm - stays), abs(best.rpm - leaves))
    late = folds.carried.way(best.rpm) - folds.carried.way(leaves)
    return max(best.change, min(scatter, LIFETIMES * runs), late)
