"""The kernel's table of one cam from its smooth parts: `build(parts, strobe)`."""

from __future__ import annotations

import itertools
from bisect import bisect
from collections.abc import Sequence
from decimal import Decimal

from camcli.cams.decimals import radians
from camcli.cams.pieces import CUTS, Part, Piece, compile_part
from camcli.kernel.cam_table import COLUMNS, ROW, TURN, Cam, polynomial

Cut = tuple[Part, float, float]  # a part, from an angle to another, rad
TAYLOR_ERROR = 2e-17  # m/rad, allowed remainder of the slope of the gap's local series
CELLS = 16  # of a stretch in its bounds, at least
SLIVER = 1e-12  # rad: a stretch shorter than this is left to its neighbour
SMALLEST_KICK = 1e-9  # m/rad: a jump of c_theta below it is rounding


def build(parts: Sequence[Part], strobe_deg: float = 0.0) -> Cam:
    """Compile one turn, cut at the parts' ends and at the strobe phase, in lists of floats."""
    strobe = float(radians(Decimal(strobe_deg))) if strobe_deg else 0.0
    cuts, strobe = _cuts(parts, strobe)
    stretches = [compile_part(part, low, high) for part, low, high in cuts]
    pieces = [piece for group in stretches for piece in group]
    first = [sum(len(group) for group in stretches[:n]) for n in range(len(stretches))]
    starts = [_values(pieces[k], low) for k, (_, low, _) in zip(first, cuts, strict=True)]
    lasts = [k + len(group) - 1 for k, group in zip(first, stretches, strict=True)]
    ends = [_values(pieces[k], high) for k, (_, _, high) in zip(lasts, cuts, strict=True)]
    bounds = [[_bounds(group, order) for order in range(5)] for group in stretches]
    starts_at = [low for _, low, _ in cuts]
    columns = {
        "START": starts_at,
        "END": [high for _, _, high in cuts],
        "FIRST": first,
        "COUNT": [len(group) for group in stretches],
        "PER_ANGLE": [
            len(group) / (high - low) for group, (_, low, high) in zip(stretches, cuts, strict=True)
        ],
        "KICK": [_kick(starts[n][1] - ends[n - 1][1]) for n in range(len(starts))],
        "ACCEL_MIN": [row[2][0] for row in bounds],
        "ACCEL_MAX": [row[2][1] for row in bounds],
        "JERK_MAX": [_largest(row[3]) for row in bounds],
        "SNAP_MAX": [_largest(row[4]) for row in bounds],
        "RADIUS": [_radius(group) for group in stretches],
        "LOW": [row[0][0] for row in bounds],
        "SLOPE_LOW": [row[1][0] for row in bounds],
    }
    for order in range(3):
        columns[f"START{order}"] = [row[order] for row in starts]
        columns[f"END{order}"] = [row[order] for row in ends]
    return Cam(
        rows=[float(columns[name][n]) for n in range(len(cuts)) for name in COLUMNS],
        pieces=[value for piece in pieces for value in piece.row()],
        stretches=len(cuts),
        strobe=starts_at.index(strobe),
        top=max(row[0][1] for row in bounds),
    )


def column(cam: Cam, name: str) -> list[float]:
    """One column of the stretch table, by the name in `kernel.profile.COLUMNS`."""
    return [float(value) for value in cam.rows[COLUMNS.index(name) :: ROW]]


def _cuts(parts: Sequence[Part], strobe: float) -> tuple[list[Cut], float]:
    """Every stretch in order, in doubles; the last ends at 2 pi; and the strobe as it is cut."""
    cuts, whole = [], _without_slivers(parts)
    strobe = _at_an_edge(whole, strobe)
    for part, low, high in whole:
        if low < strobe < high:
            places = [low, *_around(part, strobe), high]
            cuts += [(part, a, b) for a, b in itertools.pairwise(places) if b > a]
        else:
            cuts.append((part, low, high))
    return cuts, strobe


def _without_slivers(parts: Sequence[Part]) -> list[Cut]:
    """The parts that doubles can tell from nothing; what lies before a sliver reaches over it."""
    ends = [(part, float(part.start), min(float(part.end), TURN)) for part in parts]
    wide = [cut for cut in ends if cut[2] - cut[1] > SLIVER]
    starts = [0.0, *(low for _, low, _ in wide[1:])]
    stops = [*starts[1:], TURN]
    return [(cut[0], low, high) for cut, low, high in zip(wide, starts, stops, strict=True)]


def _at_an_edge(cuts: Sequence[Cut], strobe: float) -> float:
    """The strobe; where it is less than two slivers away from an edge of a piece, that edge."""
    if strobe > TURN - 2.0 * SLIVER:
        return 0.0
    edges = [x for part, low, high in cuts for x in (low, high, *part.edges()[1:-1])]
    near = min(edges, key=lambda edge: abs(edge - strobe))
    return near if abs(near - strobe) < 2.0 * SLIVER else strobe


def _around(part: Part, strobe: float) -> list[float]:
    """The strobe, between the ends of the piece that holds it where a part brings its pieces."""
    edges = part.edges()
    if not part.pieces or strobe in edges:
        return [strobe]
    k = bisect(edges, strobe)
    return [edges[k - 1], strobe, edges[k]]


def _values(piece: Piece, theta: float) -> tuple[float, ...]:
    """c, c_theta, c_thetatheta of a piece at theta, by the kernel's own arithmetic."""
    x = theta - piece.center
    return tuple(polynomial(piece.derivative(order), 0, x) for order in range(3))


def _kick(jump: float) -> float:
    return jump if abs(jump) > SMALLEST_KICK else 0.0


def _bounds(group: Sequence[Piece], order: int) -> tuple[float, float]:
    cuts = max(CUTS, CELLS // len(group))  # a polynomial law is one wide piece
    rows = [piece.bounds(order, cuts) for piece in group]
    return min(low for low, _ in rows), max(high for _, high in rows)


def _largest(bounds: tuple[float, float]) -> float:
    return max(abs(bounds[0]), abs(bounds[1]))


def _radius(group: Sequence[Piece]) -> float:
    """Largest power of two s <= 1/16 rad with max|c^(7)| s^6/720 <= TAYLOR_ERROR."""
    seventh = _largest(_bounds(group, 7))
    s = 1.0 / 16.0
    while seventh * s * s * s * s * s * s > 720.0 * TAYLOR_ERROR:
        s *= 0.5
    return s


def corners(cam: Cam) -> list[int]:
    """Stretches that begin with a jump of c_theta or c_thetatheta."""
    size = max(abs(value) for name in ("ACCEL_MIN", "ACCEL_MAX") for value in column(cam, name))
    starts, ends, kicks = column(cam, "START2"), column(cam, "END2"), column(cam, "KICK")
    return [
        n
        for n in range(cam.stretches)
        if kicks[n] != 0.0 or abs(starts[n] - ends[n - 1]) > 1e-9 * size
    ]
