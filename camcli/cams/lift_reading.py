"""From the bytes of a lift table to one turn of lift: nothing is guessed, every fault named.

Text is UTF-8 with or without a byte order mark, with any line ends; `#` begins a comment. The
first line with content says how cells are separated: `;` if it has one, else `,`, else white space.
Numbers are taken as written, in decimals: the last digit of a table is its rounding.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from decimal import Decimal, localcontext
from math import gcd, sqrt
from statistics import median_low

from camcli.cams.files import decoded, refused
from camcli.errors import Fault, SceneError

MAX_ROWS = 40_000  # every 0.01 deg of the cam, and some; read within a second
MAX_LINES = 2 * MAX_ROWS  # with comments
LONGEST_LINE = 10_000  # characters
MAX_FAULTS = 20
LARGEST = Decimal(10) ** 9
MOST_DECIMALS = 40  # of a number
LEAST_ROWS = 16
LEAST_MOVING = 12  # rows off the dwells
DWELL_DEG = 10.0  # equal lifts over at least this are a dwell
WIDEST_GAP = 10.0  # deg of cam between two rows off a dwell
SMALLEST_LIFT, LARGEST_LIFT = 1e-4, 1.0  # m: beyond, the unit is wrong
SPIKE = 12.0  # last digits: a row further off its neighbours is refused
BACKGROUND = 8.0  # times the median deviation, likewise
PATTERN = 0.1  # deviation from the pattern of one wrong row, relative
DEG = 57.29577951308232

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?", re.ASCII)


@dataclass(frozen=True)
class Reading:
    """How the scene says the table is to be read: m per unit of lift, deg per unit of angle."""

    angle_column: int | str  # number from 1, or name
    lift_column: int | str
    header: bool
    lift_unit: float
    angle_unit: Decimal  # 1 for cam degrees, 1/2 for crank degrees
    zero_deg: float
    reversed: bool


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

    def deviation(self, k: int, reach: int) -> tuple[float, list[float]]:
        """Lift of row k minus the polynomial through `reach` rows on either side; their weights."""
        n, here = len(self.lift), self.theta[k]
        rows = [*range(k - reach, k), *range(k + 1, k + reach + 1)]
        places = [self.theta[j % n] + 360.0 * (j // n) - here for j in rows]
        weights, value = [], self.lift[k]
        for j, place in zip(rows, places, strict=True):
            weight = 1.0
            for there in places:
                if there != place:
                    weight *= there / (there - place)
            weights.append(weight)
            value -= weight * self.lift[j % n]
        return value, weights


def read_turn(data: bytes, name: str, reading: Reading) -> Turn:
    """The turn of a table's bytes; raises SceneError with every fault and its line."""
    rows = _rows(decoded(data, name, "file"), name, reading)
    turn = _one_turn(rows, reading)
    _refuse_spikes(turn, name)
    return turn


# -- text to cells -----------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cell:
    """A number with the place it stands at; lines and columns count from 1."""

    line: int
    column: int
    value: Decimal
    decimals: int  # digits after the point, negative for 1e3
    scientific: bool  # written with a power of ten: its digits count, not its decimals


@dataclass(frozen=True)
class _Rows:
    """The two columns of a table, as they were written."""

    name: str
    angle: list[_Cell]
    lift: list[_Cell]

    def fault(self, row: int, found: str, expected: str, cure: str, key: str = "lift") -> Fault:
        """A fault at a cell of a row."""
        cell = (self.angle if key == "angle" else self.lift)[row]
        return Fault(f"{self.name}:{cell.line}:{cell.column}", key, found, expected, cure)


def _raise(faults: list[Fault]) -> None:
    if faults:
        raise SceneError(*faults[:MAX_FAULTS])


def _rows(text: str, name: str, reading: Reading) -> _Rows:
    """The cells of the angle and the lift, row by row."""
    lines = _lines(text, name)
    first_line, first = lines[0]
    split = _splitter(first, name, first_line)
    titles = [word.strip('"') for _, word in split(first)] if reading.header else []
    if titles and all(map(_NUMBER.fullmatch, titles)):
        found, cure = "found a header of numbers", "if it is the first row, write header: false"
        raise refused(f"{name}:{first_line}", "header", found, "", cure)
    body = lines[1:] if reading.header else lines
    if len(body) > MAX_ROWS:
        found, expected = f"found {len(body)} rows", f"expected at most {MAX_ROWS}"
        raise refused(name, "file", found, expected, "thin the table out")
    width = len(titles) or (len(split(body[0][1])) if body else 0)
    angle = _column("angle_column", reading.angle_column, titles, width, name)
    lift = _column("lift_column", reading.lift_column, titles, width, name)
    if angle == lift:
        found = f"angle_column and lift_column are both column {angle + 1}"
        raise refused(name, "lift_column", found, "expected two columns", "name both")
    faults: list[Fault] = []
    rows = _Rows(name, [], [])
    for number, (line, row) in enumerate(body):
        cells = split(row)
        if len(cells) != width:
            found, expected = f"found {len(cells)} cells", f"expected {width} as in the first line"
            cure = "complete the row; is the comma a decimal comma?" if "," in row else "complete"
            faults.append(Fault(f"{name}:{line}", "file", found, expected, cure))
        else:
            for k, into in ((angle, rows.angle), (lift, rows.lift)):
                column, word = cells[k]
                cell = _cell(name, line, column, word, not reading.header and number == 0)
                if isinstance(cell, Fault):
                    faults.append(cell)
                else:
                    into.append(cell)
        if len(faults) >= MAX_FAULTS:
            break
    _raise(faults)
    return rows


def _lines(text: str, name: str) -> list[tuple[int, str]]:
    """(number, text) of the lines with content, comments cut off."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    count = text.count("\n")
    if count > MAX_LINES:
        found, expected = f"found {count} lines", f"expected at most {MAX_LINES}"
        raise refused(name, "file", found, expected, "thin the table out")
    whole = text.split("\n")
    for n, line in enumerate(whole, 1):
        if len(line) > LONGEST_LINE:  # it would be cut into a huge number of cells
            found, expected = f"found a line of {len(line)} characters", f"at most {LONGEST_LINE}"
            cure = "is this the right file?"
            raise refused(f"{name}:{n}:1", "file", found, f"expected {expected}", cure)
    lines = [(n, line.partition("#")[0]) for n, line in enumerate(whole, 1)]
    lines = [(n, line) for n, line in lines if line.strip()]
    if not lines:
        found = "found no rows" if text else "found nothing"
        cure = "is this the right file?"
        raise refused(name, "file", found, "expected rows of angle and lift", cure)
    return lines


def _splitter(first: str, name: str, line: int) -> Callable[[str], list[tuple[int, str]]]:
    """A function from a line to its cells as (column, text)."""
    words = first.split()
    if ";" in first:
        mark = ";"
    elif len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(w) or w.isdigit() for w in words):
        raise SceneError(_comma(name, line, 1, words[0]))
    elif "," in first:
        mark = ","
    else:
        return lambda text: [(m.start() + 1, m[0]) for m in re.finditer(r"\S+", text)]

    def split(text: str) -> list[tuple[int, str]]:
        cells, start = [], 0
        for raw in text.split(mark):
            lead = len(raw) - len(raw.lstrip())
            cells.append((start + lead + 1, raw.strip()))
            start += len(raw) + 1
        return cells

    return split


def _comma(name: str, line: int, column: int, text: str) -> Fault:
    found = f"found a decimal comma: '{text[:40]}'"
    cure = "write 1.25 for 1,25, and separate the columns by a semicolon or white space"
    return Fault(f"{name}:{line}:{column}", "file", found, "expected decimal points", cure)


def _column(key: str, chosen: int | str, titles: list[str], width: int, name: str) -> int:
    """Index of a column that the scene names or numbers."""
    if isinstance(chosen, int):
        if 1 <= chosen <= width:
            return chosen - 1
        found, expected = f"found column {chosen}", f"expected 1 to {width}, as the file has them"
        raise refused(name, key, found, expected, "columns count from 1")
    count = titles.count(chosen.strip())
    if count == 1:
        return titles.index(chosen.strip())
    if not titles:
        found = f"found the name '{chosen[:40]}' for a column of a file without header"
        raise refused(name, key, found, "", "number the column, from 1, or say header: true")
    found = f"found {'no' if count == 0 else 'more than one'} column '{chosen[:40]}'"
    names = ", ".join(f"'{title[:30]}'" for title in titles[:12])
    raise refused(name, key, found, f"expected one of {names}", "copy the name")


def _cell(name: str, line: int, column: int, text: str, first: bool) -> _Cell | Fault:
    """The number in a cell, or why there is none."""
    text = text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text
    found, expected = f"found {text}", "expected a number"
    if len(text) <= 60 and _NUMBER.fullmatch(text):
        value = Decimal(text)
        decimals = -int(value.as_tuple().exponent)
        if abs(value) > LARGEST or (value.is_zero() and decimals < 0):
            expected, cure = "expected at most 1e9", "is it a number?"
        elif decimals > MOST_DECIMALS:
            expected, cure = f"expected at most {MOST_DECIMALS} decimals", "round it"
        else:
            return _Cell(line, column, value, decimals, "e" in text.lower())
    elif _DECIMAL_COMMA.fullmatch(text):
        return _comma(name, line, column, text)
    else:
        found = f"found '{text[:40]}'" if text else "found an empty cell"
        cure = "correct the cell, remove the row, or begin the line with # if it is a comment"
        if text.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            cure = "remove the row or measure it again"
        elif first:
            cure = "if this is a header, write header: true"
    return Fault(f"{name}:{line}:{column}", "file", found, expected, cure)


# -- cells to one turn -------------------------------------------------------------------------


def _one_turn(rows: _Rows, reading: Reading) -> Turn:
    """Check angles and cover of the table and lay it on the turn."""
    if len(rows.angle) < LEAST_ROWS:
        found, expected = f"found {len(rows.angle)} rows", f"expected at least {LEAST_ROWS}"
        raise refused(rows.name, "file", found, expected, "measure more rows")
    with localcontext() as context:
        context.prec = 60  # LARGEST with MOST_DECIMALS, and more
        angles = [cell.value * reading.angle_unit for cell in rows.angle]
        _raise(list(itertools.islice(_not_ascending(rows), MAX_FAULTS)))
        quantum, steps = _quantum(rows)
        step = float(quantum) * reading.lift_unit
        _check_sizes(rows, reading, step)
        spacing = median_low([b - a for a, b in itertools.pairwise(angles)])
        count, covered = _cover(rows, angles, spacing, steps, reading)
        sign = -1 if reading.reversed else 1
        zero = Decimal(repr(reading.zero_deg))
        phases = [float((zero + sign * angle) % 360 + 0) for angle in angles[:count]]
    phases = [x + 360.0 if x < 0.0 else x for x in phases]  # the remainder has the angle's sign
    order = sorted(range(count), key=phases.__getitem__)
    theta = [phases[k] if phases[k] < 360.0 else 0.0 for k in order]
    lift = [float(rows.lift[k].value) * reading.lift_unit for k in order]
    turn = Turn(theta, lift, [rows.lift[k].line for k in order], step, float(spacing), [])
    turn, steps = _filled(rows, turn, [steps[k] for k in order], covered)
    return replace(turn, dwells=_dwells(rows, turn, steps))


def _not_ascending(rows: _Rows) -> Iterator[Fault]:
    for k in range(1, len(rows.angle)):
        before, now = rows.angle[k - 1].value, rows.angle[k].value
        if now > before:
            continue
        found = f"found the angle {now} " + ("again" if now == before else f"after {before}")
        cure = "remove one of the two rows"
        if now < before:
            cure = "sort the rows; add a full turn to angles that go through zero"
        yield rows.fault(k, found, "expected ascending angles", cure, "angle")


def _quantum(rows: _Rows) -> tuple[Decimal, list[int]]:
    """(step of the last digit in the file's unit, lifts as whole numbers of the last decimal).

    Numbers written with a power of ten have a step each; theirs is the root mean square.
    """
    values = [cell.value for cell in rows.lift]
    most = max(cell.decimals for cell in rows.lift)
    steps = [int(value.scaleb(most)) for value in values]
    if any(cell.scientific for cell in rows.lift):
        digits = max(len(value.as_tuple().digits) for value in values)
        sizes = [Decimal(10) ** (v.adjusted() - digits + 1) for v in values if v]
        total = sum((size * size for size in sizes), Decimal(0))
        return (total / max(1, len(sizes))).sqrt(), steps
    return Decimal(gcd(*steps) or 1).scaleb(-most), steps


def _check_sizes(rows: _Rows, reading: Reading, step: float) -> None:
    """Refuse lifts that no unit explains."""
    lifts = [float(cell.value) * reading.lift_unit for cell in rows.lift]
    top, bottom = max(lifts), min(lifts)
    at, fault = lifts.index(top), None
    if top > LARGEST_LIFT or 0.0 < top < SMALLEST_LIFT:
        size = "large" if top > LARGEST_LIFT else "small"
        fault = (
            f"found a largest lift of {top:.6g} m, suspiciously {size}",
            f"expected {SMALLEST_LIFT:g} to {LARGEST_LIFT:g} m",
            "is the unit in cam.lift the file's? And lift_column, rocker_ratio?",
        )
    elif bottom < -0.02 * abs(top) - step:
        at = lifts.index(bottom)
        fault = (
            f"found a lift of {bottom:.6g} m, below the base circle",
            "expected lifts from zero up",
            "is lift_column the right column? Subtract the base if the file has radii",
        )
    elif top - bottom < 8.0 * step:
        fault = (
            f"found lifts that differ by {top - bottom:.6g} m, a few steps of the last digit",
            "expected a lift curve",
            "write more decimals",
        )
    if fault:
        raise SceneError(rows.fault(at, *fault))


def _cover(
    rows: _Rows, angles: list[Decimal], spacing: Decimal, steps: list[int], reading: Reading
) -> tuple[int, bool]:
    """(rows that count, whether they go round the turn); an open end is a fault."""
    span, last = angles[-1] - angles[0], len(angles) - 1
    quantum = max(1, gcd(*steps))
    if span > 360 + spacing / 4:
        found = f"the table covers {float(span):.10g} deg of cam, {float(span - 360):.6g} too much"
        cure = "is cam.angle right (crank angles are halved)? Cut the table after one turn"
        raise SceneError(rows.fault(last, found, "expected one turn", cure, "angle"))
    if 360 - span < spacing / 4:
        if abs(steps[-1] - steps[0]) > 2 * quantum + abs(steps[1] - steps[0]) // 4:
            found = f"the last row is one turn after the first, its lift is {rows.lift[-1].value}"
            expected = f"expected {rows.lift[0].value} as in the first row"
            raise SceneError(rows.fault(last, found, expected, "correct one of the two"))
        return last, True
    if 360 - span <= spacing * 3 / 2:
        return last + 1, True
    faults, expected = [], "expected one turn, or zero lift at both ends"
    for k, end in ((0, "begins"), (last, "ends")):
        if abs(steps[k]) > quantum:
            found = (
                f"the table {end} at {rows.angle[k].value} deg with a lift of "
                f"{float(rows.lift[k].value) * reading.lift_unit:.6g} m, an open end "
                f"({float(360 - span):.6g} deg of cam are missing)"
            )
            cure = "measure down to zero lift, or is cam.angle wrong (crank angles are halved)?"
            faults.append(rows.fault(k, found, expected, cure))
    _raise(faults)
    return last + 1, False


def _filled(rows: _Rows, turn: Turn, steps: list[int], covered: bool) -> tuple[Turn, list[int]]:
    """The turn with rows of zero lift laid where the table leaves a base dwell out.

    That is behind the ends of a table of the lobe alone, and between two rows of equal zero lift.
    A gap elsewhere is a fault.
    """
    quantum = max(1, gcd(*steps))
    found: list[tuple[float, float, int, int]] = []  # theta, lift, line, step
    faults: list[Fault] = []
    for k, phase in enumerate(turn.theta):
        after = (k + 1) % len(steps)
        gap = turn.theta[after] - phase + (0.0 if after else 360.0)
        found.append((phase, turn.lift[k], turn.line[k], steps[k]))
        low = abs(steps[k]) <= quantum and abs(steps[after]) <= quantum
        if gap > 1.5 * turn.spacing and low and (not covered or steps[k] == steps[after]):
            level = (turn.lift[k], 0, steps[k]) if covered else (0.0, 0, 0)
            count = int(gap / turn.spacing)
            found += [((phase + gap * j / count) % 360.0, *level) for j in range(1, count)]
        elif gap > WIDEST_GAP and gap > 1.5 * turn.spacing:
            ends = f"{turn.line[k]} and {turn.line[after]}"
            text = f"the rows of lines {ends} are {gap:.6g} deg apart"
            expected = f"expected at most {WIDEST_GAP:g} deg of cam where the lift moves"
            where = f"{rows.name}:{turn.line[k]}"
            faults.append(Fault(where, "angle", text, expected, "measure the rows between"))
    _raise(faults)
    found.sort(key=lambda row: row[0])
    filled = replace(
        turn,
        theta=[theta for theta, _, _, _ in found],
        lift=[lift for _, lift, _, _ in found],
        line=[line for _, _, line, _ in found],
    )
    return filled, [step for _, _, _, step in found]


def _dwells(rows: _Rows, turn: Turn, steps: list[int]) -> list[Dwell]:
    """Runs of equal lifts too long to be a rounded nose."""
    n = len(steps)
    breaks = [k for k in range(n) if steps[k] != steps[k - 1]]  # a run begins here
    runs, moving = [], 360.0
    for first, after in itertools.pairwise([*breaks, breaks[0] + n]):
        length = (turn.theta[(after - 1) % n] - turn.theta[first]) % 360.0
        if length >= DWELL_DEG and after - first >= 5:
            runs.append((first, after - first, length))
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


def _refuse_spikes(turn: Turn, name: str) -> None:
    """Refuse rows that are off all their neighbours.

    One wrong row shows as a pattern that a corner of the cam cannot make: it is off by e, and every
    neighbour by its weight times -e.
    """
    n = len(turn.lift)
    rows = [turn.deviation(k, 2) for k in range(n)]
    off = sorted(abs(d) for d, _ in rows if d != 0.0)
    floor = max([SPIKE * turn.quantum, *([BACKGROUND * median_low(off)] if off else [])])
    faults = []
    for k, (d, _) in enumerate(rows):
        if abs(d) <= floor or not turn.line[k]:
            continue
        slack = PATTERN * abs(d) + turn.quantum
        near = [rows[(k + j) % n] for j in (2, 1, -1, -2)]  # by the weight that they give row k
        if all(abs(e + weights[w] * d) <= slack for w, (e, weights) in enumerate(near)):
            found = f"found a spike: the row is {d:.6g} m off its neighbours"
            expected = f"expected at most {floor:.6g} m, {floor / turn.quantum:.3g} last digits"
            cure = "correct the row, or remove it"
            faults.append(Fault(f"{name}:{turn.line[k]}", "lift", found, expected, cure))
    _raise(faults)
