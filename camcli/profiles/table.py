"""The kernel's table of one cam from its smooth parts: `build(parts, strobe)`."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal

from camcli.kernel.backend import numbers
from camcli.kernel.profile import TERMS, Cam, polynomial
from camcli.profiles.digits import radians
from camcli.profiles.pieces import Part, Piece, compile_part, derivative_tables

TURN = 6.283185307179586  # rad, 2 pi as a double
TAYLOR_ERROR = 2e-17  # m, allowed remainder of the local series of the gap
SMALLEST_KICK = 1e-9  # m/rad: a jump of c_theta below it is rounding


def build(parts: Sequence[Part], strobe_deg: float = 0.0) -> Cam:
    """Compile one turn, cut at the parts' ends and at the strobe phase, in lists of floats."""
    strobe = float(radians(Decimal(strobe_deg))) if strobe_deg else 0.0
    cuts = _cuts(parts, strobe)
    stretches = [compile_part(part, low, high) for part, low, high in cuts]
    pieces = [piece for group in stretches for piece in group]
    tables = derivative_tables(pieces)
    first = [sum(len(group) for group in stretches[:n]) for n in range(len(stretches))]
    starts = [_values(tables, pieces, k, low) for k, (_, low, _) in zip(first, cuts, strict=True)]
    lasts = [k + len(group) - 1 for k, group in zip(first, stretches, strict=True)]
    ends = [_values(tables, pieces, k, high) for k, (_, _, high) in zip(lasts, cuts, strict=True)]
    bounds = [[_bounds(group, order) for order in range(5)] for group in stretches]
    starts_at = [low for _, low, _ in cuts]
    return Cam(
        start=starts_at,
        end=[high for _, _, high in cuts],
        first=first,
        count=[len(group) for group in stretches],
        per_angle=[
            len(group) / (high - low) for group, (_, low, high) in zip(stretches, cuts, strict=True)
        ],
        start0=[row[0] for row in starts],
        start1=[row[1] for row in starts],
        start2=[row[2] for row in starts],
        kick=[_kick(starts[n][1] - ends[n - 1][1]) for n in range(len(starts))],
        end0=[row[0] for row in ends],
        end1=[row[1] for row in ends],
        end2=[row[2] for row in ends],
        accel_min=[row[2][0] for row in bounds],
        accel_max=[row[2][1] for row in bounds],
        jerk_max=[_largest(row[3]) for row in bounds],
        snap_max=[_largest(row[4]) for row in bounds],
        radius=[_radius(group) for group in stretches],
        low=[row[0][0] for row in bounds],
        slope_low=[row[1][0] for row in bounds],
        center=[piece.center for piece in pieces],
        **{f"c{order}": table for order, table in enumerate(tables)},
        top=max(row[0][1] for row in bounds),
        strobe=starts_at.index(strobe),
    )


def _cuts(parts: Sequence[Part], strobe: float) -> list[tuple[Part, float, float]]:
    """(part, low, high) of every stretch in order, in doubles; the last ends at 2 pi."""
    cuts = []
    for part in parts:
        low, high = float(part.start), min(float(part.end), TURN)
        if low < strobe < high:
            cuts += [(part, low, strobe), (part, strobe, high)]
        elif high > low:
            cuts.append((part, low, high))
    return cuts


def _values(tables, pieces: Sequence[Piece], k: int, theta: float) -> tuple[float, ...]:
    """c, c_theta, c_thetatheta of piece k at theta, by the kernel's own arithmetic."""
    x = theta - pieces[k].center
    return tuple(polynomial(tables[order], k * TERMS, x) for order in range(3))


def _kick(jump: float) -> float:
    return jump if abs(jump) > SMALLEST_KICK else 0.0


def _bounds(group: Sequence[Piece], order: int) -> tuple[float, float]:
    rows = [piece.bounds(order) for piece in group]
    return min(low for low, _ in rows), max(high for _, high in rows)


def _largest(bounds: tuple[float, float]) -> float:
    return max(abs(bounds[0]), abs(bounds[1]))


def _radius(group: Sequence[Piece]) -> float:
    """Largest power of two s <= 1/16 rad with max|c^(7)| s^7/5040 <= TAYLOR_ERROR."""
    seventh = _largest(_bounds(group, 7))
    s = 1.0 / 16.0
    while seventh * s * s * s * s * s * s * s > 5040.0 * TAYLOR_ERROR:
        s *= 0.5
    return s


def corners(cam: Cam) -> list[int]:
    """Stretches that begin with a jump of c_theta or c_thetatheta."""
    size = max(_largest((low, high)) for low, high in zip(cam.accel_min, cam.accel_max, strict=True))
    return [
        n
        for n in range(len(cam.start))
        if cam.kick[n] != 0.0 or abs(cam.start2[n] - cam.end2[n - 1]) > 1e-9 * size
    ]


INTEGERS = {"first", "count"}


def native(cam: Cam) -> Cam:
    """The table in the form the running kernel wants (lists, or arrays once it is compiled)."""
    columns = {
        name: value
        if isinstance(value, int | float)
        else numbers(value, int if name in INTEGERS else float)
        for name, value in cam._asdict().items()
    }
    return Cam(**columns)
