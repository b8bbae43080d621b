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
from typing import TYPE_CHECKING

import numpy as np

from camcli.analysis.basins.attractor import Attractor
from camcli.analysis.basins.cell_batches import NOTHING, CellBatches
from camcli.kernel.arithmetic import exp_decay, natural_log
from camcli.kernel.cells import CHATTERED_TURN, Point, Targets

if TYPE_CHECKING:
    from camcli.analysis.basins.recurrence import Boxes

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
    """Ellipses A x^2 + B x y + C y^2 <= 1 about the m points of a periodic attractor.

    x and y are distances from the point along gap (m) and rate (m/rad).
    """

    points: np.ndarray  # (m, 2), gap and rate
    forms: np.ndarray  # (m, 3), A, B and C
    symbols: tuple[int, ...]  # impacts of the turn from each point, or CHATTERED_TURN
    shrink: float  # factor by which the form shrinks over a period, at least
    radius: float  # over the orbit's size
    rho: float  # spectral radius of the period's map
    returns: bool  # rings of starts were seen to come back

    def scaled(self, factor: float) -> CaptureRegion:
        """Ellipses smaller by a factor."""
        return replace(self, forms=self.forms / (factor * factor), radius=self.radius * factor)

    def half_widths(self) -> np.ndarray:
        """(m, 2) extents of the ellipses along gap and rate.

        They are sqrt(C/d) and sqrt(A/d) with d = A C - B^2/4.
        """
        a, _, c = self.forms.T
        d = _discriminant(self.forms)
        return np.sqrt(np.column_stack((c / d, a / d)))


def region_of(batches: CellBatches, attractor: Attractor) -> CaptureRegion | None:
    """The largest region that holds; None where the differences say that the orbit repels.

    Radii are tried from WIDEST down, each STEP times the one before, unless the ellipses are too
    long and thin for a ring of starts to show anything.
    """
    lift = np.array(batches.lift)
    points = np.array(attractor.states) - lift
    points[np.abs(points).max(axis=1) <= REST * attractor.size] = 0.0
    points[:, 0] = np.maximum(points[:, 0], 0.0)
    symbols = tuple(CHATTERED_TURN if s == inf else int(s) for s in attractor.symbols)
    maps = _turn_maps(batches, points, symbols, attractor.size)
    rho = _spectral_radius(maps)
    if not rho < 1.0:
        return None
    period_factor = 0.5 * (1.0 + rho)  # s^m
    shrink = 0.5 * (1.0 + period_factor**2)  # halfway to 1 from what the linear map would do
    s = exp_decay(-natural_log(period_factor) / len(points))
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
    """A C - B^2/4 of each form, (m,): positive where it is that of an ellipse."""
    a, b, c = forms.T
    return a * c - 0.25 * b * b


def _turn_maps(
    batches: CellBatches, points: np.ndarray, symbols: Sequence[int], size: float
) -> np.ndarray:
    """(m, 2, 2) one-turn maps by central differences; zero about a state at rest on the cam.

    points: (m, 2); symbols: of the turns that begin there; size: of the orbit. Entry [j, i, k] is
    the derivative of coordinate i after a turn by coordinate k at point j. The step is the largest
    of DIFFERENCES with which all starts have the impacts of the orbit, else the smallest.
    """
    in_flight = points[:, 0] > 0.0
    maps = np.zeros((len(points), 2, 2))
    for step in DIFFERENCES:
        h = np.where(points[:, 0] < step * size, 0.5 * points[:, 0], step * size)
        h = np.where(in_flight, h, 1.0)
        offset = np.where(in_flight, h, 0.0)  # at rest all four are the state itself
        starts = np.repeat(points, 4, axis=0)  # of each point four: gap + h, gap - h, rate + h, - h
        starts[0::4, 0] += offset
        starts[1::4, 0] -= offset
        starts[2::4, 1] += offset
        starts[3::4, 1] -= offset
        ends = batches.run(starts[:, 0], starts[:, 1], NOTHING, 1)
        image = np.column_stack((ends.gap, ends.rate)).reshape(-1, 4, 2)
        maps[:, :, 0] = (image[:, 0] - image[:, 1]) / (2.0 * h[:, None])
        maps[:, :, 1] = (image[:, 2] - image[:, 3]) / (2.0 * h[:, None])
        if np.array_equal(ends.symbol, np.repeat(symbols, 4)):
            break
    return maps


def _spectral_radius(maps: np.ndarray) -> float:
    """The spectral radius of the map over the whole period, from those of single turns.

    It is the larger |z| of z^2 - trace z + det = 0: sqrt(det) of a complex pair.
    """
    period = [[1.0, 0.0], [0.0, 1.0]]
    for turn in maps.tolist():
        period = _times(turn, period)
    (xx, xy), (yx, yy) = period
    trace = xx + yy
    det = xx * yy - xy * yx
    discriminant = 0.25 * trace * trace - det
    if discriminant < 0.0:
        return sqrt(det)
    return abs(0.5 * trace) + sqrt(discriminant)


def _times(a, b):
    """Product of 2 x 2 matrices, lists of rows, by IEEE arithmetic."""
    rows = range(2)
    return [[a[i][0] * b[0][k] + a[i][1] * b[1][k] for k in rows] for i in rows]


def _forms(maps: np.ndarray, s: float) -> np.ndarray:
    """(m, 3) coefficients of the adapted forms P_j = A x^2 + B x y + C y^2 (see the module).

    maps: of one turn, (m, 2, 2). The term k of the sum is |M (x, y)|^2, with M = s^-k A_(j+k-1) ...
    A_j; the sum begins with the form x^2 + y^2, and ends where a term has become small beside it.
    """
    m = len(maps)
    turns = maps.tolist()
    forms = []
    for j in range(m):
        a = 0.0
        b = 0.0
        c = 0.0
        product = [[1.0, 0.0], [0.0, 1.0]]  # M
        for k in range(MOST_TERMS):
            (xx, xy), (yx, yy) = product
            term_a = xx * xx + yx * yx
            term_b = 2.0 * (xx * xy + yx * yy)
            term_c = xy * xy + yy * yy
            a += term_a
            b += term_b
            c += term_c
            if term_a + term_c <= 1e-12 * (a + c):
                break
            next_turn = turns[(j + k) % m]
            product = [[value / s for value in row] for row in _times(next_turn, product)]
        forms.append((a, b, c))
    return np.array(forms)


def _holds(
    batches: CellBatches,
    region: CaptureRegion,
    home: float = HOME,
    most_turns: int = MOST_RETURN,
) -> bool:
    """True where rings of starts in every ellipse stay, shrink over a period and come home.

    They stay where each turn leads them into the next ellipse with the impacts of the orbit. They
    are home where the form, 1 on an ellipse, is at most `home`; they have `most_turns` for that.
    """
    m = len(region.points)
    symbols = np.array(region.symbols)
    starts, point_of = rings(region)
    if len(starts) == 0:
        return True
    gap = starts[:, 0]
    rate = starts[:, 1]
    mode = None
    size_before = size_of(region, point_of, gap, rate)
    for turn in range(m):
        ends = batches.run(gap, rate, NOTHING, 1, mode)
        gap = ends.gap
        rate = ends.rate
        mode = ends.mode
        next_point = (point_of + turn + 1) % m
        symbol_of_orbit = symbols[(point_of + turn) % m]
        size = size_of(region, next_point, gap, rate)
        if not ((ends.symbol == symbol_of_orbit) & (size <= 1.0)).all():
            return False
    if not (size <= region.shrink * size_before).all():
        return False
    periods = 0
    expected = 1.0  # size after so many periods, each of which shrinks it
    while expected > home and periods * m < most_turns:
        periods = periods + 1
        expected = expected * region.shrink
    ends = batches.run(gap, rate, NOTHING, periods * m, mode)
    sizes = size_of(region, point_of, ends.gap, ends.rate)
    return bool((sizes <= max(home, expected)).all())


def rings(region: CaptureRegion) -> tuple[np.ndarray, np.ndarray]:
    """(starts (n, 2), index of the point about which each lies (n,)), none below the cam.

    About every point that is not at rest lie ellipses like its own, smaller by the factors RINGS,
    each with DIRECTIONS starts.
    """
    along_side = (np.arange(DIRECTIONS // 4) + 0.5) / (DIRECTIONS // 8) - 1.0
    one = np.ones_like(along_side)
    sides = ((one, along_side), (-along_side, one), (-one, -along_side), (along_side, -one))
    square = np.concatenate([np.column_stack(side) for side in sides])  # (DIRECTIONS, 2)
    starts_of = []
    points_of = []
    for j, (a, b, c) in enumerate(region.forms):
        # the form is a (x + b y/2a)^2 + low^2 y^2; it turns a circle into an ellipse
        low = sqrt(c - 0.25 * b * b / a)
        y = square[:, 1] / low
        x = square[:, 0] / sqrt(a) - 0.5 * b / a * y
        length = np.sqrt(square[:, 0] ** 2 + square[:, 1] ** 2)
        for ring in RINGS:
            offset = np.column_stack((x, y)) * (ring / length)[:, None]
            starts_of.append(region.points[j] + offset)
            points_of.append(np.full(len(offset), j))
    starts = np.concatenate(starts_of)
    point_of = np.concatenate(points_of)
    keep = (starts[:, 0] >= 0.0) & (region.points[point_of, 0] > 0.0)
    return starts[keep], point_of[keep]


def size_of(
    region: CaptureRegion, point_of: np.ndarray, gap: np.ndarray, rate: np.ndarray
) -> np.ndarray:
    """The form of states, each about the point of its index, (n,): 1 on that point's ellipse."""
    x = gap - region.points[point_of, 0]
    y = rate - region.points[point_of, 1]
    a, b, c = region.forms[point_of].T
    return (a * x + b * y) * x + c * y * y


def targets_of(regions: Sequence[CaptureRegion | None], boxes: Boxes | None = None) -> Targets:
    """The kernel's table of regions and of aperiodic boxes.

    regions: that of attractor k is regions[k], None of an aperiodic one.
    """
    points: list[Point] = []
    for k, region in enumerate(regions):
        if region is None:
            continue
        m = len(region.points)
        first = len(points)
        for j in range(m):
            gap, rate = region.points[j].tolist()
            a, b, c = region.forms[j].tolist()
            points.append(
                Point(
                    gap=gap, rate=rate, a=a, b=b, c=c, shrink=region.shrink, attractor=k,
                    following=first + (j + 1) % m, symbol=region.symbols[j], turns=m,
                )
            )  # fmt: skip
    targets = NOTHING._replace(points=points)
    return targets if boxes is None else boxes.fill(targets)


def parted(
    regions: Sequence[CaptureRegion | None], new: CaptureRegion
) -> list[CaptureRegion | None] | None:
    """All regions, the new one and those it overlaps shrunk until apart; None where they are one.

    Numbers do not change: entry k is region k, the last entry the new one.
    """
    apart = list(regions)
    for k, region in enumerate(regions):
        other = region
        while other is not None and overlap(other, new):
            other = other.scaled(0.5)
            new = new.scaled(0.5)
            if min(other.radius, new.radius) < INSEPARABLE:
                return None
        apart[k] = other
    return [*apart, new]


def overlap(a: CaptureRegion, b: CaptureRegion) -> bool:
    """True where the boxes around two regions' ellipses meet."""
    apart = np.abs(a.points[:, None, :] - b.points[None, :, :])
    reach = a.half_widths()[:, None, :] + b.half_widths()[None, :, :]
    return bool((apart <= reach).all(axis=2).any())
