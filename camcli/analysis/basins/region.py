"""How near is near enough: ellipses about a periodic attractor from which starts come back.

The one-turn maps about the m points are taken by differences. With rho the spectral radius of the
period's map and s^m = (1 + rho)/2, the forms
    P_j = sum over k of s^(-2k) (A_(j+k-1) ... A_j)^T (A_(j+k-1) ... A_j)
satisfy |A_j x| <= s |x| from one point's form to the next: the linear map leads each ellipse
x^T P_j x <= R^2 into the next one, however large the turn's own stretching is. R is the largest
radius at which the true map does so too: rings of starts in every ellipse are mapped and must stay
within the next ellipse with the same impacts, shrink over a period, and end at the orbit. Where no
radius holds, circles of NARROWEST take the place of the ellipses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches
from camcli.kernel.arithmetic import exp_decay, natural_log
from camcli.kernel.cells import CHATTERED_TURN, Point

WIDEST, NARROWEST = 0.25, 1e-8  # radius over the orbit's size
DIFFERENCES = (1e-7, 1e-8, 1e-9, 1e-10)  # steps of the difference quotients, of the orbit's size
RINGS = (1.0, 0.6, 0.2)
DIRECTIONS = 24  # starts on a ring, a multiple of 8
STEP = 0.8  # from one radius tried to the next
ROUND = 1e-9  # least squared ratio of an ellipse's axes
REST = 1e-12  # of the size: a state this near to the cam at rest is at rest
HOME = 1e-3  # form (squared distance over the ellipse's) at which a start has come back
INSEPARABLE = 1e-11  # radius, over the size, at which two regions are one
MOST_TERMS = 20_000
MOST_RETURN = 2_000  # turns


@dataclass(frozen=True)
class CaptureRegion:
    """Ellipses about the points: columns gap, rate (m, m/rad), A, B, C of the form, per point."""

    points: np.ndarray  # (m, 2)
    forms: np.ndarray  # (m, 3)
    symbols: tuple[int, ...]
    shrink: float
    radius: float  # over the orbit's size
    rho: float
    returns: bool  # rings of starts were seen to come back

    def scaled(self, factor: float) -> CaptureRegion:
        """Ellipses smaller by a factor."""
        return replace(self, forms=self.forms / (factor * factor), radius=self.radius * factor)

    def half_widths(self) -> np.ndarray:
        """(m, 2) extents of the ellipses along gap and rate."""
        a, _, c = self.forms.T
        det = _discriminant(self.forms)
        return np.sqrt(np.column_stack((c / det, a / det)))


def region_of(batches: CellBatches, attractor: Attractor) -> CaptureRegion | None:
    """The largest region that holds; None where the differences say that the orbit repels."""
    c, c1 = batches.lift
    points = np.array(attractor.states) - np.array([c, c1])
    points[np.abs(points).max(axis=1) <= REST * attractor.size] = 0.0
    points[:, 0] = np.maximum(points[:, 0], 0.0)
    symbols = tuple(CHATTERED_TURN if s == inf else int(s) for s in attractor.symbols)
    maps = _turn_maps(batches, points, symbols, attractor.size)
    rho = _spectral_radius(maps)
    if not rho < 1.0:
        return None
    shrink = 0.5 * (1.0 + (0.5 * (1.0 + rho)) ** 2)
    s = exp_decay(-natural_log(0.5 * (1.0 + rho)) / len(points))
    forms = _forms(maps, s) / attractor.size**2
    region = CaptureRegion(points, forms, symbols, shrink, 1.0, rho, False)
    with np.errstate(over="ignore", invalid="ignore"):  # of a cycle that stretches beyond all
        round_enough = _discriminant(forms) > ROUND * forms[:, 0] * forms[:, 2]
    radius = WIDEST if round_enough.all() else 0.0
    while radius >= NARROWEST:
        tried = region.scaled(radius)
        if _holds(batches, tried):
            return replace(tried, returns=True)
        radius *= STEP
    circles = np.tile([1.0, 0.0, 1.0], (len(points), 1)) / attractor.size**2
    return replace(region, forms=circles, shrink=1.0).scaled(NARROWEST)


def _discriminant(forms: np.ndarray) -> np.ndarray:
    a, b, c = forms.T
    return a * c - 0.25 * b * b


def _turn_maps(batches: CellBatches, points: np.ndarray, symbols, size: float) -> np.ndarray:
    """(m, 2, 2) one-turn maps by central differences; zero about a state at rest on the cam."""
    free = points[:, 0] > 0.0
    maps = np.zeros((len(points), 2, 2))
    for step in DIFFERENCES:
        h = np.where(points[:, 0] < step * size, 0.5 * points[:, 0], step * size)
        h = np.where(free, h, 1.0)
        starts = np.repeat(points, 4, axis=0)
        for k, (axis, sign) in enumerate(((0, 1), (0, -1), (1, 1), (1, -1))):
            starts[k::4, axis] += sign * np.where(free, h, 0.0)
        ends = batches.run(starts[:, 0], starts[:, 1], NOTHING, 1)
        image = np.column_stack((ends.gap, ends.rate)).reshape(-1, 4, 2)
        maps[:, :, 0] = (image[:, 0] - image[:, 1]) / (2.0 * h[:, None])
        maps[:, :, 1] = (image[:, 2] - image[:, 3]) / (2.0 * h[:, None])
        if np.array_equal(ends.symbol, np.repeat(symbols, 4)):
            break
    return np.where(free[:, None, None], maps, 0.0)


def _spectral_radius(maps: np.ndarray) -> float:
    """The spectral radius of the map over the whole period, from those of single turns."""
    whole = [[1.0, 0.0], [0.0, 1.0]]
    for a in maps.tolist():
        whole = _times(a, whole)
    trace = whole[0][0] + whole[1][1]
    det = whole[0][0] * whole[1][1] - whole[0][1] * whole[1][0]
    disc = 0.25 * trace * trace - det
    return sqrt(det) if disc < 0.0 else abs(0.5 * trace) + sqrt(disc)


def _times(a, b):
    """Product of 2 x 2 matrices by IEEE arithmetic."""
    rows = range(2)
    return [[a[i][0] * b[0][k] + a[i][1] * b[1][k] for k in rows] for i in rows]


def _forms(maps: np.ndarray, s: float) -> np.ndarray:
    """(m, 3) coefficients of the adapted forms P_j = A x^2 + B x y + C y^2 (see the module).

    maps: of one turn, (m, 2, 2). The sum begins with the form x^2 + y^2, and ends where a term has
    become small beside it.
    """
    m = len(maps)
    turns = maps.tolist()
    forms = []
    for j in range(m):
        a = 0.0
        b = 0.0
        c = 0.0
        product = [[1.0, 0.0], [0.0, 1.0]]  # s^-k A_(j+k-1) ... A_j
        for k in range(MOST_TERMS):
            (xx, xy), (yx, yy) = product
            more_a = xx * xx + yx * yx
            more_b = 2.0 * (xx * xy + yx * yy)
            more_c = xy * xy + yy * yy
            a += more_a
            b += more_b
            c += more_c
            if more_a + more_c <= 1e-12 * (a + c):
                break
            step = turns[(j + k) % m]
            product = [[value / s for value in row] for row in _times(step, product)]
        forms.append((a, b, c))
    return np.array(forms)


def _holds(
    batches: CellBatches,
    region: CaptureRegion,
    home: float = HOME,
    most_turns: int = MOST_RETURN,
) -> bool:
    """True where rings of starts in every ellipse stay, shrink over a period and come home.

    They are home where the form, 1 on an ellipse, is at most `home`; they have `most_turns`.
    """
    m = len(region.points)
    starts, at = rings(region)
    if len(starts) == 0:
        return True
    gap = starts[:, 0]
    rate = starts[:, 1]
    mode = None
    before = size_of(region, at, gap, rate)
    for turn in range(m):
        ends = batches.run(gap, rate, NOTHING, 1, mode)
        gap = ends.gap
        rate = ends.rate
        mode = ends.mode
        now = (at + turn + 1) % m
        wanted = np.array(region.symbols)[(at + turn) % m]
        size = size_of(region, now, gap, rate)
        if not ((ends.symbol == wanted) & (size <= 1.0)).all():
            return False
    if not (size <= region.shrink * before).all():
        return False
    periods = 0
    left = 1.0
    while left > home and periods * m < most_turns:
        periods = periods + 1
        left = left * region.shrink
    ends = batches.run(gap, rate, NOTHING, periods * m, mode)
    return bool((size_of(region, at, ends.gap, ends.rate) <= max(home, left)).all())


def rings(region: CaptureRegion) -> tuple[np.ndarray, np.ndarray]:
    """(starts, their points' indices): deterministic rings in every ellipse, not below the cam."""
    side = (np.arange(DIRECTIONS // 4) + 0.5) / (DIRECTIONS // 8) - 1.0
    one = np.ones_like(side)
    square = np.concatenate(
        [np.column_stack(p) for p in ((one, side), (-side, one), (-one, -side), (side, -one))]
    )
    found = []
    owner = []
    for j, (a, b, c) in enumerate(region.forms):
        low = sqrt(c - 0.25 * b * b / a)
        across = square[:, 1] / low  # the form is a (x + b y/2a)^2 + low^2 y^2
        along = square[:, 0] / sqrt(a) - 0.5 * b / a * across
        length = np.sqrt(square[:, 0] ** 2 + square[:, 1] ** 2)
        for ring in RINGS:
            offset = np.column_stack((along, across)) * (ring / length)[:, None]
            found.append(region.points[j] + offset)
            owner.append(np.full(len(offset), j))
    starts = np.concatenate(found)
    at = np.concatenate(owner)
    keep = (starts[:, 0] >= 0.0) & (region.points[at, 0] > 0.0)
    return starts[keep], at[keep]


def size_of(region: CaptureRegion, at, gap, rate):
    """The form about points `at` of states."""
    x, y = gap - region.points[at, 0], rate - region.points[at, 1]
    a, b, c = region.forms[at].T
    return (a * x + b * y) * x + c * y * y


def targets_of(regions, boxes=None):
    """The kernel's table of regions (attractor k is regions[k]) and of aperiodic boxes."""
    points: list[Point] = []
    for k, region in enumerate(regions):
        m = len(region.points) if region is not None else 0
        first = len(points)
        for j in range(m):
            place = region.points[j].tolist()
            form = region.forms[j].tolist()
            link = k, first + (j + 1) % m, region.symbols[j], m
            points.append(Point(*place, *form, region.shrink, *link))
    targets = NOTHING._replace(points=points)
    return targets if boxes is None else boxes.fill(targets)


def parted(
    regions: Sequence[CaptureRegion | None], new: CaptureRegion
) -> list[CaptureRegion | None] | None:
    """All regions, the new one and those it overlaps shrunk until apart; None where they are one.

    Numbers do not change: entry k is region k, the last entry the new one.
    """
    apart = list(regions)
    for k, other in enumerate(regions):
        while other is not None and overlap(other, new):
            apart[k] = other = other.scaled(0.5)
            new = new.scaled(0.5)
            if min(other.radius, new.radius) < INSEPARABLE:
                return None
    return [*apart, new]


def overlap(a: CaptureRegion, b: CaptureRegion) -> bool:
    """True where the boxes around two regions' ellipses meet."""
    apart = np.abs(a.points[:, None, :] - b.points[None, :, :])
    reach = a.half_widths()[:, None, :] + b.half_widths()[None, :, :]
    return bool((apart <= reach).all(axis=2).any())
