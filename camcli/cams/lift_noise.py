"""Spikes in a measured lift, and noise beyond its rounding: each row against its neighbours.

A row is compared with the polynomial through `reach` rows on either side. One wrong row shows as a
pattern that a corner of the cam cannot make: it is off by e, and every neighbour by its weight
times -e.
"""

from __future__ import annotations

from math import sqrt
from statistics import median_low

from camcli.cams.lift_data import Turn
from camcli.cams.lift_text import MAX_FAULTS
from camcli.errors import Fault, SceneError

SPIKE = 12.0  # quanta: a row further off its neighbours is refused
BACKGROUND = 8.0  # times the median deviation, likewise
PATTERN = 0.1  # deviation from the pattern of one wrong row, relative
SAMPLE = 600  # rows that estimate the noise
NORMAL = 0.6745  # median of |x| of a normal distribution


def refuse_spikes(turn: Turn, name: str) -> None:
    """Raise SceneError with every row that is off all its neighbours."""
    n = len(turn.lift)
    rows = [_deviation(turn, k, 2) for k in range(n)]
    off = sorted(abs(d) for d, _ in rows if d != 0.0)
    floor = SPIKE * turn.quantum
    if off:
        floor = max(floor, BACKGROUND * median_low(off))
    faults = []
    for k, (d, _) in enumerate(rows):
        if abs(d) <= floor or not turn.line[k]:
            continue
        near = [(rows[(k + j) % n][0], rows[(k + j) % n][1][-j]) for j in (-2, -1, 1, 2)]
        slack = PATTERN * abs(d) + turn.quantum
        if all(abs(found + weight * d) <= slack for found, weight in near):
            found = f"found a spike: the row is {d:.6g} m off its neighbours"
            expected = f"expected at most {floor:.6g} m, {floor / turn.quantum:.3g} last digits"
            cure = "correct the row, or remove it"
            faults.append(Fault(f"{name}:{turn.line[k]}", "lift", found, expected, cure))
    if faults:
        raise SceneError(*faults[:MAX_FAULTS])


def noise(turn: Turn) -> float:
    """Standard deviation of the rows, m: of the rounding, or more where rows scatter more.

    The scatter is the least of three estimates from polynomials of rising degree: where the lift
    itself bends between rows, the higher ones see less of it.
    """
    moving = [k for k in range(len(turn.lift)) if turn.line[k] and _moves(turn, k)]
    stride = 1 + len(moving) // SAMPLE
    least = None
    for reach in (2, 3, 4):
        found = []
        for k in moving[::stride]:
            d, weights = _deviation(turn, k, reach)
            square = 1.0
            for j, weight in weights.items():
                square += weight * weight if j else 0.0
            found.append(abs(d) / sqrt(square))
        estimate = median_low(found) / NORMAL if found else 0.0
        least = estimate if least is None or estimate < least else least
    return max(turn.rounding, least or 0.0)


def _moves(turn: Turn, k: int) -> bool:
    n = len(turn.lift)
    return any(turn.lift[(k + j) % n] != turn.lift[k] for j in (-1, 1))


def _deviation(turn: Turn, k: int, reach: int) -> tuple[float, dict[int, float]]:
    """(lift minus what 2 reach neighbours say, their weights by offset)."""
    n = len(turn.lift)
    offsets = [j for j in range(-reach, reach + 1) if j]
    places = {j: _ahead(turn, k, j) for j in offsets}
    weights = {}
    value = turn.lift[k]
    for j in offsets:
        weight = 1.0
        for other in offsets:
            if other != j:
                weight *= places[other] / (places[other] - places[j])
        weights[j] = weight
        value -= weight * turn.lift[(k + j) % n]
    return value, weights


def _ahead(turn: Turn, k: int, j: int) -> float:
    """Angle from row k to row k + j, deg, round the turn."""
    n = len(turn.theta)
    turns, index = divmod(k + j, n)
    return turn.theta[index] + 360.0 * turns - turn.theta[k]
