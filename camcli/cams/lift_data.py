"""From the rows of a lift table to one turn of measured lift: phases, metres, rounding, dwells."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from math import gcd, sqrt
from statistics import median_low

from camcli.cams.files import refused
from camcli.cams.lift_text import MAX_FAULTS, Rows
from camcli.errors import Fault, SceneError

LEAST_ROWS = 16
LEAST_MOVING = 12  # rows off the dwells
DWELL_DEG = 10.0  # equal lifts over at least this are a dwell
WIDEST_GAP = 10.0  # deg of cam between two rows off a dwell
SMALLEST_LIFT, LARGEST_LIFT = 1e-4, 1.0  # m: beyond, the unit is wrong
DEG = 57.29577951308232
COVER = "expected one turn, or zero lift at both ends"


@dataclass(frozen=True)
class Dwell:
    """Equal lifts from one phase to another, deg, start in [0, 360), end possibly beyond."""

    start: float
    end: float
    level: float  # m above the base


@dataclass(frozen=True)
class Turn:
    """One turn of measured lift, ascending in phase."""

    theta: list[float]  # deg in [0, 360)
    lift: list[float]  # m above the base
    line: list[int]  # of the file; 0 where a dwell was filled
    quantum: float  # m, step of the last digit
    spacing: float  # deg, median
    dwells: list[Dwell]

    @property
    def rounding(self) -> float:
        """Standard deviation of rounding to the quantum, m."""
        return self.quantum / sqrt(12.0)


@dataclass(frozen=True)
class Reading:
    """How the scene says the table is to be read: m per unit of lift, deg per unit of angle."""

    lift_unit: float
    angle_unit: Decimal  # 1 for cam degrees, 1/2 for crank degrees
    zero_deg: float
    reversed: bool


def one_turn(rows: Rows, reading: Reading) -> Turn:
    """Check angles and cover of the table and lay it on the turn; raises SceneError."""
    if len(rows.angle) < LEAST_ROWS:
        found, expected = f"found {len(rows.angle)} rows", f"expected at least {LEAST_ROWS}"
        raise refused(rows.name, "file", found, expected, "measure more rows")
    with localcontext() as context:
        context.prec = 60
        angles = [cell.value * reading.angle_unit for cell in rows.angle]
        _ascending(rows)
        quantum, whole = _quantum(rows)
        step = float(quantum) * reading.lift_unit
        _sizes(rows, reading, step)
        gaps = [b - a for a, b in itertools.pairwise(angles)]
        spacing = median_low(gaps)
        count, covered = _cover(rows, angles, spacing, whole, reading)
        sign = -1 if reading.reversed else 1
        zero = Decimal(repr(reading.zero_deg))
        phases = [float((zero + sign * angle) % 360 + 0) for angle in angles[:count]]
    phases = [x + 360.0 if x < 0.0 else x for x in phases]  # the remainder has the angle's sign
    order = sorted(range(count), key=phases.__getitem__)
    theta = [phases[k] if phases[k] < 360.0 else 0.0 for k in order]
    lift = [float(rows.lift[k].value) * reading.lift_unit for k in order]
    turn = Turn(theta, lift, [rows.lift[k].line for k in order], step, float(spacing), [])
    turn, whole = _filled(rows, turn, [whole[k] for k in order], covered)
    return replace(turn, dwells=_dwells(rows, turn, whole))


def _ascending(rows: Rows) -> None:
    faults = []
    for k in range(1, len(rows.angle)):
        before, now = rows.angle[k - 1].value, rows.angle[k].value
        if now > before:
            continue
        if now == before:
            found, cure = f"found the angle {now} again", "remove one of the two rows"
        else:
            found = f"found the angle {now} after {before}"
            cure = "sort the rows; add a full turn to angles that go through zero"
        faults.append(rows.fault(k, found, "expected ascending angles", cure, "angle"))
        if len(faults) >= MAX_FAULTS:
            break
    if faults:
        raise SceneError(*faults)


def _quantum(rows: Rows) -> tuple[Decimal, list[int]]:
    """(step of the last digit in the file's unit, lifts as whole numbers of the last decimal).

    Numbers written with a power of ten have a step each; theirs is the root mean square.
    """
    values = [cell.value for cell in rows.lift]
    least = min(value.as_tuple().exponent for value in values)
    whole = [int(value.scaleb(-least)) for value in values]
    if any(cell.scientific for cell in rows.lift):
        digits = max(len(value.as_tuple().digits) for value in values)
        steps = [Decimal(10) ** (v.adjusted() - digits + 1) for v in values if v]
        total = Decimal(0)
        for step in steps:
            total += step * step
        return (total / max(1, len(steps))).sqrt(), whole
    return Decimal(gcd(*whole) or 1).scaleb(least), whole


def _sizes(rows: Rows, reading: Reading, step: float) -> None:
    """Refuse lifts that no unit explains."""
    lifts = [float(cell.value) * reading.lift_unit for cell in rows.lift]
    top, bottom = max(lifts), min(lifts)
    k, least = lifts.index(top), lifts.index(bottom)
    if top > LARGEST_LIFT or 0.0 < top < SMALLEST_LIFT:
        size = "large" if top > LARGEST_LIFT else "small"
        found = f"found a largest lift of {top:.6g} m, suspiciously {size}"
        expected = f"expected {SMALLEST_LIFT:g} to {LARGEST_LIFT:g} m"
        cure = "is the unit in cam.lift the file's? And lift_column, rocker_ratio?"
        raise SceneError(rows.fault(k, found, expected, cure))
    if bottom < -0.02 * abs(top) - step:
        found = f"found a lift of {bottom:.6g} m, below the base circle"
        cure = "is lift_column the right column? Subtract the base if the file has radii"
        raise SceneError(rows.fault(least, found, "expected lifts from zero up", cure))
    if top - bottom < 8.0 * step:
        found = f"found lifts that differ by {top - bottom:.6g} m, a few steps of the last digit"
        raise SceneError(rows.fault(k, found, "expected a lift curve", "write more decimals"))


def _cover(rows, angles, spacing, whole, reading) -> tuple[int, bool]:
    """(rows that count, whether they go round the turn); an open end is a fault."""
    span, last = angles[-1] - angles[0], len(angles) - 1
    if span > 360 + spacing / 4:
        found = f"the table covers {float(span):.10g} deg of cam, {float(span - 360):.6g} too much"
        cure = "is cam.angle right (crank angles are halved)? Cut the table after one turn"
        raise SceneError(rows.fault(last, found, "expected one turn", cure, "angle"))
    quantum = max(1, gcd(*whole))
    if 360 - span < spacing / 4:
        jump = abs(whole[-1] - whole[0])
        if jump > 2 * quantum + abs(whole[1] - whole[0]) // 4:
            found = f"the last row is one turn after the first, its lift is {rows.lift[-1].value}"
            expected = f"expected {rows.lift[0].value} as in the first row"
            raise SceneError(rows.fault(last, found, expected, "correct one of the two"))
        return last, True
    if 360 - span <= spacing * 3 / 2:
        return last + 1, True
    faults = []
    for k, end in ((0, "begins"), (last, "ends")):
        if abs(whole[k]) > quantum:
            found = (
                f"the table {end} at {rows.angle[k].value} deg with a lift of "
                f"{float(rows.lift[k].value) * reading.lift_unit:.6g} m, an open end "
                f"({float(360 - span):.6g} deg of cam are missing)"
            )
            cure = "measure down to zero lift, or is cam.angle wrong (crank angles are halved)?"
            faults.append(rows.fault(k, found, COVER, cure))
    if faults:
        raise SceneError(*faults)
    return last + 1, False


def _filled(rows: Rows, turn: Turn, whole: list[int], covered: bool) -> tuple[Turn, list[int]]:
    """The turn with rows of zero lift laid where the table leaves a base dwell out.

    That is behind the ends of a table of the lobe alone, and between two rows of equal zero lift.
    A gap elsewhere is a fault.
    """
    theta, lift, line, steps = [], [], [], []
    quantum, faults = max(1, gcd(*whole)), []
    for k, phase in enumerate(turn.theta):
        after = (k + 1) % len(whole)
        gap = turn.theta[after] - phase + (0.0 if after else 360.0)
        theta.append(phase)
        lift.append(turn.lift[k])
        line.append(turn.line[k])
        steps.append(whole[k])
        low = abs(whole[k]) <= quantum and abs(whole[after]) <= quantum
        if gap > 1.5 * turn.spacing and low and (not covered or whole[k] == whole[after]):
            count = int(gap / turn.spacing)
            level = turn.lift[k] if covered else 0.0
            for j in range(1, count):
                theta.append(phase + gap * j / count)
                lift.append(level)
                line.append(0)
                steps.append(whole[k] if covered else 0)
        elif gap > WIDEST_GAP and gap > 1.5 * turn.spacing:
            found = (
                f"the rows of lines {turn.line[k]} and {turn.line[after]} are {gap:.6g} deg apart"
            )
            expected = f"expected at most {WIDEST_GAP:g} deg of cam where the lift moves"
            where = f"{rows.name}:{turn.line[k]}"
            faults.append(Fault(where, "angle", found, expected, "measure the rows between"))
    if faults:
        raise SceneError(*faults[:MAX_FAULTS])
    order = sorted(range(len(theta)), key=lambda k: theta[k] % 360.0)
    return replace(
        turn,
        theta=[theta[k] % 360.0 for k in order],
        lift=[lift[k] for k in order],
        line=[line[k] for k in order],
    ), [steps[k] for k in order]


def _dwells(rows: Rows, turn: Turn, whole: list[int]) -> list[Dwell]:
    """Runs of equal lifts too long to be a rounded nose."""
    n = len(whole)
    breaks = [k for k in range(n) if whole[k] != whole[k - 1]]  # a run begins here
    runs = []
    for first, after in zip(breaks, [*breaks[1:], breaks[0] + n], strict=True):
        last = (after - 1) % n
        length = (turn.theta[last] - turn.theta[first]) % 360.0
        if length >= DWELL_DEG and after - first >= 5:
            runs.append((first, after - first, length))
    moving = 360.0
    for _, _, length in runs:
        moving -= length
    half = 0.5 * moving / DEG
    curvature = 2.0 * (max(turn.lift) - min(turn.lift)) / (half * half)
    nose = 4.0 * sqrt(turn.quantum / curvature) * DEG  # twice what rounds flat on a parabola
    dwells, off = [], n
    for first, count, length in runs:
        if length >= nose:
            start = turn.theta[first]
            dwells.append(Dwell(start, start + length, turn.lift[first]))
            off -= count
    if off < LEAST_MOVING:
        found, expected = f"found {off} rows of moving lift", f"expected at least {LEAST_MOVING}"
        raise refused(rows.name, "file", found, expected, "measure more rows")
    return dwells
