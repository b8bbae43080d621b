"""From the bytes of a lift table to one turn of lift: nothing is guessed, every fault named.

Text is UTF-8, or UTF-16 with a byte order mark, with any line ends; `#` begins a comment. The first
row says how cells are separated. Angles may fall or rise. Numbers are taken as written, in
decimals: the last digit of a table is its rounding.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from decimal import Decimal, localcontext
from math import degrees, gcd, sqrt
from statistics import median_low
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from camcli.cams.files import decoded, refused
from camcli.errors import Fault, SceneError, plural
from camcli.quantities import MM, SHAFTS

if TYPE_CHECKING:
    from camcli.cams.lift_table import TableCam

MAX_ROWS = 40_000  # every 0.01 deg of the cam, and some; read within a second
MAX_LINES = 2 * MAX_ROWS  # with comments
LONGEST_LINE = 10_000  # characters
LARGEST = Decimal(10) ** 9
MOST_DECIMALS = 40  # of a number
LEAST_ROWS = 16
LEAST_MOVING = 12  # rows off the dwells
DWELL_DEG = 10.0  # equal lifts over at least this are a dwell
MISSING_ROWS = 1.5  # spacings of the rows: in a wider gap rows are missing
WIDEST_GAP = 10.0  # deg of cam between two rows off a dwell
SMALLEST_LIFT, LARGEST_LIFT = 1e-4, 1.0  # m: beyond, the unit is wrong
END_ROWS = 20  # of an end, a quarter of all at most, by which it is judged to be on the base circle
END_NOISE = 5.0  # standard deviations by which such an end may be off it
MOST_END_NOISE = 0.005  # of the largest lift, likewise: where so few rows show more, it is no noise
SPIKE = 12.0  # last digits: a row further off its neighbours is refused
BACKGROUND = 8.0  # times the median deviation, likewise
PATTERN = 0.1  # deviation from the pattern of one wrong row, relative
DEG = degrees(1.0)  # in a radian
UNIT_WORDS = {  # of a title: what stands in a word of one is not looked for in a later one
    "um": re.compile(
        r"\bum\b|[µμ]m|micron|mikrom|microm"
        r"|(thousandths? of (a )?|1/1000 ?|(?<!\d)0?\.001 ?)(mm\b|millim)"
    ),
    "thou": re.compile(
        r"\bthou\b|\bmils?\b|thousandths?( of (an )?)?(in\b|inch|zoll|\")?"
        r"|(?<!\d)0?\.001 ?(\"|in)|1/1000 ?(\"|in|zoll)"
    ),
    "mm": re.compile(r"\bmm\b|millim"),
    # `in` with a word behind it is the English or German word, as of "lift in mm"
    "inch": re.compile(r"\bin(\.|(?= *([])},;:/]|$)))|\binch|zoll|\""),
    "m": re.compile(r"\bm\b|\bmet(er|re)"),
}
_QUOTED = re.compile(r'"[^"]*"')
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


class Dwell(NamedTuple):
    """Equal lifts from one phase to another, deg, start in [0, 360), end possibly beyond."""

    start: float
    end: float
    level: float  # m above the base


@dataclass(frozen=True)
class Turn:
    """One turn of measured lift, ascending in phase."""

    theta: np.ndarray = field(compare=False)  # (n,), deg in [0, 360)
    lift: np.ndarray = field(compare=False)  # (n,), m above the base
    line: np.ndarray = field(compare=False)  # (n,), of the file; 0 where a dwell was filled
    quantum: float  # m, step of the last digit
    spacing: float  # deg, median
    dwells: list[Dwell]

    def deviations(self, reach: int) -> tuple[np.ndarray, np.ndarray]:
        """(deviation of each row from the polynomial through its neighbours, their weights).

        The neighbours are `reach` rows, r, on either side. The deviation (n,) is the lift minus the
        sum of weights (2r, n) times the neighbours' lifts; a weight is Lagrange's, the product of
        x_other/(x_other - x) over the other neighbours, x being degrees ahead of the row.
        """
        n = len(self.lift)
        steps = [*range(-reach, 0), *range(1, reach + 1)]
        neighbours = np.arange(n) + np.array(steps)[:, None]  # (2r, n), as are the next two
        ahead = self.theta[neighbours % n] + 360.0 * (neighbours // n) - self.theta  # deg
        weights = np.ones(ahead.shape)
        deviation = self.lift.copy()
        with np.errstate(divide="ignore", invalid="ignore"):  # where two phases round to one
            for weight, x, rows in zip(weights, ahead, neighbours, strict=True):
                for other in ahead:
                    weight *= np.where(other != x, other / (other - x), 1.0)
                deviation -= weight * self.lift[rows % n]
        return deviation, weights


def read_turn(data: bytes, name: str, cam: TableCam) -> Turn:
    """The turn of a table's bytes; raises SceneError with every fault and its line."""
    turn = _one_turn(_rows(decoded(data, name, "file", table=True), name, cam), cam)
    _refuse_spikes(turn, name)
    return turn


# -- text to cells -----------------------------------------------------------------------------


class Cell(NamedTuple):
    """A number with the place it stands at; lines and columns count from 1."""

    place: str  # file:line:column
    line: int
    text: str
    value: Decimal

    def fault(self, found: str, expected: str, cure: str, key: str = "lift") -> Fault:
        return Fault(self.place, key, found, expected, cure)


@dataclass(frozen=True)
class _Rows:
    """The two columns of a table, as they were written, with ascending angles."""

    name: str
    angle: list[Cell]
    lift: list[Cell]


def raise_each_cause(faults: Iterable[Fault]) -> None:
    """Raise the faults, one for each cause: the first, and how many are like it."""
    causes: dict[tuple[str, ...], list[Fault]] = {}
    for fault in faults:
        causes.setdefault((fault.path, fault.expected, fault.cure), []).append(fault)
    firsts = []
    for first, *others in causes.values():
        if others:
            first = replace(first, found=f"{first.found}, and {len(others)} more like it")
        firsts.append(first)
    if firsts:
        raise SceneError(*firsts)


def units_in_title(title: str) -> list[str]:
    """The units of lift that a title names, as the key `lift` has them."""
    rest = title.lower().replace("_", " ")
    units = []
    for unit, words in UNIT_WORDS.items():
        if words.search(rest):
            units.append(unit)
            rest = words.sub("~", rest)  # so that the inch of 0.001 inch is no unit of its own
    return units


def _rows(text: str, name: str, cam: TableCam) -> _Rows:
    """The columns of angle and lift of one turn: ascending, through zero, both flanks.

    Rows may fall, an angle may go through zero once, and one flank may have to be mirrored.
    """
    rows = _cells(text, name, cam)
    steps = [b.value - a.value for a, b in itertools.pairwise(rows.angle)]
    if 2 * sum(step < 0 for step in steps) > len(steps):
        rows.angle.reverse()
        rows.lift.reverse()
    _unroll(rows, 360 / _angle_unit(cam))
    return _mirrored(rows) if cam.mirrored else rows


def _cells(text: str, name: str, cam: TableCam) -> _Rows:
    """The cells of the angle and the lift in the order of the file; every bad one is named."""
    lines = text_lines(text, name, cam.skip_lines)
    if not lines:
        found = "found no rows" if text else "found nothing"
        cure = "is this the right file?"
        raise refused(name, "file", found, "expected rows of angle and lift", cure)
    header = lines[: cam.header]  # header: true counts as one line
    body = lines[cam.header :]
    refuse_too_many_rows(len(body), name, "file")
    texts = [row for _, row in body or header]
    quoted = any(has_quoted_comma(row) for row in texts)
    split = splitter(texts[0], cam.decimal, quoted)
    titles: list[str] = []
    header_place = ""
    if header:
        line, row = header[0]
        header_place = f"{name}:{line}"
        titles = [word for _, word in split(row)]
    if titles and all(number(word, cam.decimal) for word in titles):
        found = "found a header of numbers"
        cure = "if it is the first row, write header: false"
        raise refused(header_place, "header", found, "", cure)
    width = len(split(texts[0]))
    angle = _column("angle_column", cam.angle_column, titles, width, name)
    lift = _column("lift_column", cam.lift_column, titles, width, name)
    chosen = (angle, lift)
    if angle == lift:
        found = f"angle_column and lift_column are both column {angle + 1}"
        raise refused(name, "lift_column", found, "expected two columns", "name both")
    if max(chosen) >= width:
        in_row = plural(width, "cell")
        in_header = plural(len(titles), "title")
        found = f"found {in_row} in the first row, and {in_header} in the header"
        cure = "complete either; is the comma a decimal comma?"
        raise refused(f"{name}:{body[0][0]}", "file", found, "expected as many of both", cure)
    if titles:
        _refuse_another_unit(titles[lift], cam, header_place)
    return _chosen_cells(body, split, width, chosen, name, cam)


def _chosen_cells(
    body: list[tuple[int, str]],
    split: Callable[[str], list[tuple[int, str]]],
    width: int,
    chosen: tuple[int, int],
    name: str,
    cam: TableCam,
) -> _Rows:
    """The cells of two columns, angle and lift; raises SceneError with every bad one.

    body: (line, text) of the rows; split: cuts a row into cells (`splitter`); width: cells that
    each must have; chosen: indices of the columns, from 0.
    """
    faults: list[Fault] = []
    rows = _Rows(name, [], [])
    for n, (line, row) in enumerate(body):
        cells = split(row)
        if len(cells) != width:
            found = f"found {plural(len(cells), 'cell')}"
            expected = f"expected {width} as in the first row"
            cure = "complete the row; is the comma a decimal comma?" if "," in row else "complete"
            faults.append(Fault(f"{name}:{line}", "file", found, expected, cure))
            continue
        for k, cells_of_column in zip(chosen, (rows.angle, rows.lift), strict=True):
            column, word = cells[k]
            cell = _cell(f"{name}:{line}:{column}", line, word, cam, n == 0)
            if isinstance(cell, Fault):
                faults.append(cell)
            else:
                cells_of_column.append(cell)
    raise_each_cause(faults)
    return rows


def _refuse_another_unit(title: str, cam: TableCam, place: str) -> None:
    """Raise SceneError where the title of the lift names units, and the scene has another."""
    named = units_in_title(title)
    if named and cam.lift not in {*named, "fraction"}:
        units = " or ".join(f"'{unit}'" for unit in named)
        found = f"found '{cam.lift}', and a lift in {units} in the file's header"
        raise refused(place, "lift", found, "expected one unit", "correct either")


def _unroll(rows: _Rows, turn: Decimal) -> None:
    """Add a turn to the angles behind the place where they go through zero, which is one at most.

    turn: 360 deg in the unit of the angles.
    """
    for k, (before, now) in enumerate(itertools.pairwise(rows.angle.copy()), 1):
        if before.value - now.value > turn / 2:
            rows.angle[k:] = [c._replace(value=c.value + turn) for c in rows.angle[k:]]
            break


def _mirrored(rows: _Rows) -> _Rows:
    """One flank, and its mirror image beyond the nose, which must be at one end of the table."""
    lifts = [cell.value for cell in rows.lift]
    top = max(lifts)
    last = len(lifts) - 1
    nose_ends = [k for k in (0, last) if lifts[k] == top]
    if len(nose_ends) != 1:
        highest = rows.lift[lifts.index(top)]
        found = f"found the largest lift {highest.text} inside the table"
        if len(nose_ends) == 2:
            found = f"found the largest lift {highest.text} at both ends of the table"
        expected = "expected it at one end: a flank from the base circle to the nose"
        cure = "leave cam.mirrored out where both flanks were measured"
        raise SceneError(highest.fault(found, expected, cure, "mirrored"))
    nose = rows.angle[nose_ends[0]].value
    mirror_angle = [cell._replace(value=2 * nose - cell.value) for cell in reversed(rows.angle)]
    mirror_lift = list(reversed(rows.lift))
    if nose_ends[0] == 0:
        return _Rows(rows.name, [*mirror_angle[:-1], *rows.angle], [*mirror_lift[:-1], *rows.lift])
    return _Rows(rows.name, [*rows.angle, *mirror_angle[1:]], [*rows.lift, *mirror_lift[1:]])


def refuse_too_many_rows(count: int, name: str, key: str = "", most: int = MAX_ROWS) -> None:
    """Raise SceneError where a table has more rows than are read."""
    if count > most:
        found = f"found {count} rows"
        expected = f"expected at most {most}"
        raise refused(name, key, found, expected, "thin the table out")


def text_lines(text: str, name: str, skip: int = 0) -> list[tuple[int, str]]:
    """(number, text) of the lines with content behind the first `skip`, comments cut off.

    A line `sep=;`, as spreadsheets write it first, is none: the rows show how they are separated.
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    count = text.count("\n")
    if count > MAX_LINES:
        found = f"found {count} lines"
        expected = f"expected at most {MAX_LINES}"
        raise refused(name, "file", found, expected, "thin the table out")
    lines = []
    for n, line in enumerate(text.split("\n"), 1):
        if len(line) > LONGEST_LINE:  # it would be cut into a huge number of cells
            found = f"found a line of {len(line)} characters"
            expected = f"expected at most {LONGEST_LINE}"
            cure = "is this the right file?"
            raise refused(f"{name}:{n}:1", "file", found, expected, cure)
        content = line.partition("#")[0].rstrip()
        if n > skip and content.strip() and not re.fullmatch("sep=.", content, re.IGNORECASE):
            lines.append((n, content))
    return lines


def has_quoted_comma(row: str) -> bool:
    """Whether a cell in quotes holds a comma: then a comma outside of quotes separates cells."""
    return '"' in row and any("," in text for text in _QUOTED.findall(row))


def splitter(
    row: str, decimal: str, quoted: bool = False
) -> Callable[[str], list[tuple[int, str]]]:
    """A function that cuts a line into cells (column, text) the way this row has to be cut.

    At semicolons if it has one, else at tabs, else at commas unless they are or seem decimal, else
    at white space. A cell in quotes is not cut. quoted: some cell of the table has a comma in
    quotes, so that commas are decimal there and separate elsewhere.
    """
    bare = _QUOTED.sub("", row)
    words = bare.split()
    seem_decimal = len(words) > 1 and all(
        number(word, "comma") and not word.endswith(",") for word in words
    )
    decimal_commas = seem_decimal or (decimal == "comma" and not quoted)
    separators = [";", "\t"] if decimal_commas else [";", "\t", ","]
    mark = next((mark for mark in separators if mark in bare), "")
    cell = rf'\s*"[^"]*"\s*(?={mark}|$)|[^{mark}]*'
    pattern = re.compile(f"(?:^|(?<={mark}))(?:{cell})" if mark else r'"[^"]*"|\S+')

    def split(line: str) -> list[tuple[int, str]]:
        """The cells of a row: (column of the first character, from 1; text without quotes)."""
        cells = []
        for match in pattern.finditer(line):
            raw = match[0]
            spaces = len(raw) - len(raw.lstrip())
            cells.append((match.start() + spaces + 1, raw.strip().strip('"').strip()))
        return cells

    return split


def number(text: str, decimal: str) -> str:
    """The number of a cell with a decimal point, or '' where it is none."""
    if decimal == "comma":
        text = text.replace(",", ".") if "." not in text else ""
    return text if len(text) <= 60 and _NUMBER.fullmatch(text) else ""


def _column(key: str, chosen: int | str, titles: list[str], width: int, name: str) -> int:
    """Index of a column that the scene names or numbers."""
    if isinstance(chosen, int):
        if 1 <= chosen <= width:
            return chosen - 1
        found = f"found column {chosen}"
        expected = f"expected 1 to {width}, as the file has them"
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


def _cell(place: str, line: int, text: str, cam: TableCam, first: bool) -> Cell | Fault:
    """The number in a cell, or why there is none."""
    found = f"found '{text[:40]}'" if text else "found an empty cell"
    expected = "expected a number"
    plain = number(text, cam.decimal)
    if plain:
        cell = Cell(place, line, plain, Decimal(plain))
        found = f"found {text}"
        if abs(cell.value) > LARGEST or (not cell.value and _decimals(cell) < 0):
            expected = "expected at most 1e9"
            cure = "is it a number?"
        elif _decimals(cell) > MOST_DECIMALS:
            expected = f"expected at most {MOST_DECIMALS} decimals"
            cure = "round it"
        else:
            return cell
    elif number(text, "comma"):
        found = f"found a decimal comma: '{text[:40]}'"
        expected = "expected decimal points"
        cure = "write decimal: comma in the section cam"
    elif number(text, "point"):
        found = f"found a decimal point: '{text[:40]}'"
        expected = "expected decimal commas"
        cure = "write decimal: point in the section cam"
    elif text.lower().lstrip("+-") in ("nan", "inf", "infinity"):
        cure = "remove the row or measure it again"
    elif first:
        lines = cam.header + 1
        cure = f"if the table has {lines} header lines, write header: {lines}"
        cure = "if this is a header, write header: true" if lines == 1 else cure
    else:
        cure = "correct the cell, remove the row, or begin the line with # if it is a comment"
    return Fault(place, "file", found, expected, cure)


def _angle_unit(cam: TableCam) -> Decimal:
    """Degrees of the cam in one of the table."""
    return Decimal(SHAFTS[cam.angle])


def _decimals(cell: Cell) -> int:
    """Digits after the point, negative for 1e3."""
    return -int(cell.value.as_tuple().exponent)


# -- cells to one turn -------------------------------------------------------------------------


def _one_turn(rows: _Rows, cam: TableCam) -> Turn:
    """Check angles and cover of the table and lay it on the turn."""
    if len(rows.angle) < LEAST_ROWS:
        found = f"found {plural(len(rows.angle), 'row')}"
        expected = f"expected at least {LEAST_ROWS}"
        raise refused(rows.name, "file", found, expected, "measure more rows")
    with localcontext() as context:
        context.prec = 60  # LARGEST with MOST_DECIMALS, and more
        angles = [cell.value * _angle_unit(cam) for cell in rows.angle]
        raise_each_cause(
            _not_ascending(before, now)
            for before, now in itertools.pairwise(rows.angle)
            if not now.value > before.value
        )
        subtract = Decimal(repr(cam.subtract))
        last_digit, steps = _quantum(rows.lift, subtract)
        quantum = float(last_digit) * cam.metres
        lifts = [float(cell.value - subtract) * cam.metres for cell in rows.lift]
        _check_sizes(rows.lift, lifts, quantum)
        spacing = median_low([after - before for before, after in itertools.pairwise(angles)])
        noise = max(_base_circle(steps), _base_circle(steps[::-1]))
        count, covered = _cover(rows, angles, spacing, steps, lifts, noise, cam)
        sign = -1 if cam.direction == "reversed" else 1
        zero = Decimal(repr(cam.zero_deg))
        phases = [_phase(zero + sign * angle) for angle in angles[:count]]
    in_order = sorted((phase, k) for k, phase in enumerate(phases))
    table = [TurnRow(phase, lifts[k], rows.lift[k].line, steps[k]) for phase, k in in_order]
    step = max(1, gcd(*steps))
    is_noisy = not covered and max(abs(steps[0]), abs(steps[-1])) > step
    base = noise if is_noisy else step
    return _turn(rows.name, table, quantum, float(spacing), covered, base)


def _phase(angle: Decimal) -> float:
    """An angle of the cam in degrees as a double from 0, below 360."""
    phase = float(angle % 360 + 0)  # the remainder has the angle's sign
    if phase < 0.0:
        phase += 360.0
    return phase if phase < 360.0 else 0.0


def _not_ascending(before: Cell, now: Cell) -> Fault:
    """The fault of an angle that repeats the one before it, or turns back."""
    if now.value == before.value:
        found = f"found the angle {now.value} again"
        cure = "remove one of the two rows"
    else:
        found = f"found the angle {now.value} after {before.value}"
        cure = "sort the rows; add a full turn to angles that go through zero"
    return now.fault(found, "expected angles that only rise or only fall", cure, "angle")


def _quantum(lift: list[Cell], zero: Decimal) -> tuple[Decimal, list[int]]:
    """(step of the last digit in the file's unit, lifts above `zero` as whole numbers of such).

    The whole numbers count units of the last decimal place that the file has; their greatest common
    divisor is the step, as where a table rounds to 0.002. `zero` is rounded to
    that place. Numbers written with a power of ten have a step each; theirs is the root mean
    square.
    """
    values = [cell.value for cell in lift]
    places = max(map(_decimals, lift))
    steps = [int((value - zero).scaleb(places).to_integral_value()) for value in values]
    if any("e" in cell.text.lower() for cell in lift):
        digits = max(len(value.as_tuple().digits) for value in values)
        sizes = [Decimal(10) ** (value.adjusted() - digits + 1) for value in values if value]
        squares = sum((size * size for size in sizes), Decimal(0))
        return (squares / max(1, len(sizes))).sqrt(), steps
    return Decimal(gcd(*steps) or 1).scaleb(-places), steps


def _check_sizes(cells: list[Cell], lifts: list[float], quantum: float) -> None:
    """Refuse lifts (m) that no unit explains.

    cells: where they stand in the file; quantum: step of the last digit, m.
    """
    top = max(lifts)
    bottom = min(lifts)
    at = lifts.index(top)
    if top > LARGEST_LIFT or 0.0 < top < SMALLEST_LIFT:
        size = "large" if top > LARGEST_LIFT else "small"
        found = f"found a largest lift of {top:.6g} m, suspiciously {size}"
        expected = f"expected {SMALLEST_LIFT:g} to {LARGEST_LIFT:g} m"
        cure = "is the unit in cam.lift the file's? And lift_column, rocker_ratio?"
    elif bottom < -0.02 * abs(top) - quantum:
        at = lifts.index(bottom)
        found = f"found a lift of {MM * bottom:.6g} mm, below the base circle"
        expected = "expected lifts from zero up"
        cure = "is lift_column the right column, and cam.subtract right?"
    elif top == bottom or top - bottom < 8.0 * quantum:  # all of them zero where the unit is tiny
        differ = f"found lifts that differ by {MM * (top - bottom):.6g} mm"
        found = f"{differ}, a few steps of the last digit"
        expected = "expected a lift curve"
        cure = "write more decimals"
    else:
        return
    raise SceneError(cells[at].fault(found, expected, cure))


def _cover(
    rows: _Rows,
    angles: list[Decimal],
    spacing: Decimal,
    steps: list[int],
    lifts: list[float],
    noise: float,
    cam: TableCam,
) -> tuple[int, bool]:
    """(rows that count, whether they go round the turn); an open end is a fault.

    angles, spacing: deg of the cam; steps, lifts: of the rows, in last digits and m; noise: up to
    which step the first and the last row are on the base circle. Where the last row is one turn
    after the first, it is the first once more, and does not count.
    """
    span = angles[-1] - angles[0]
    missing = 360 - span
    last = len(angles) - 1
    step = max(1, gcd(*steps))
    if span > 360 + spacing / 4:
        found = f"the table covers {float(span):.10g} deg of cam, {float(span - 360):.6g} too much"
        cure = "is cam.angle right (crank angles are halved)? Cut the table after one turn"
        raise SceneError(rows.angle[last].fault(found, "expected one turn", cure, "angle"))
    if missing < spacing / 4:
        if abs(steps[-1] - steps[0]) > 2 * step + abs(steps[1] - steps[0]) // 4:
            found = f"the last row is one turn after the first, its lift is {rows.lift[-1].value}"
            expected = f"expected {rows.lift[0].value} as in the first row"
            raise SceneError(rows.lift[last].fault(found, expected, "correct one of the two"))
        return last, True
    if missing <= spacing * 3 / 2:
        return last + 1, True
    raise_each_cause(
        _open_end(rows, k, verb, lifts[k], missing, cam)
        for k, verb in ((0, "begins"), (last, "ends"))
        if abs(steps[k]) > noise
    )
    return last + 1, False


def _open_end(
    rows: _Rows, k: int, verb: str, lift: float, missing: Decimal, cam: TableCam
) -> Fault:
    """The fault of a table that begins or ends, at row k, with a lift (m) off the base circle.

    missing: deg of the turn that it does not cover.
    """
    return rows.lift[k].fault(
        f"the table {verb} at {rows.angle[k].value} deg with a lift of {_lift_words(lift, cam)}, "
        f"an open end ({float(missing):.6g} deg of cam are missing)",
        "expected one turn, or zero lift at both ends",
        "measure down to zero lift, or set the ends to 0 if they are on the base circle; is "
        "cam.angle wrong (crank angles are halved)? Of one flank of a symmetric lobe write "
        "mirrored: true",
    )


def _lift_words(lift: float, cam: TableCam) -> str:
    """A lift (m) of the table as measured, and what is left where a number is subtracted."""
    if cam.subtract == 0.0:
        return f"{MM * lift:.6g} mm"
    measured = lift + cam.subtract * cam.metres
    return f"{MM * measured:.6g} mm ({MM * lift:.6g} mm after subtract: {cam.subtract:.10g})"


def _base_circle(steps: list[int]) -> float:
    """Up to which step the first of the rows is on the base circle: its last digit, or noise.

    steps: lifts in last digits, from the end of the table inwards. Rows that only rise or only fall
    are a flank, however they scatter about it. Else the scatter is that of the second differences
    of the rows beside the first, which a ramp does not change; their variance is six times that of
    a row, 1 + 4 + 1.
    """
    last_digit = max(1, gcd(*steps))
    rows = steps[: min(END_ROWS, len(steps) // 4)]
    inwards = list(itertools.pairwise(rows))
    only_rises = all(outer <= inner for outer, inner in inwards)
    only_falls = all(outer >= inner for outer, inner in inwards)
    if only_rises or only_falls:
        return last_digit
    bends = [a - 2 * b + c for a, b, c in zip(rows[1:], rows[2:], rows[3:], strict=False)]
    scatter = sqrt(sum(bend * bend for bend in bends) / (6 * len(bends)))
    noise = min(END_NOISE * scatter, MOST_END_NOISE * max(map(abs, steps)))
    return max(last_digit, noise)


class TurnRow(NamedTuple):
    """A row of a table laid on the turn."""

    theta: float  # deg
    lift: float  # m
    line: int  # of the file, from 1; 0 of a row that is filled in
    steps: int  # the lift in last decimals of the file


def _turn(
    name: str,
    table: list[TurnRow],
    quantum: float,
    spacing: float,
    covered: bool,
    base: float,
) -> Turn:
    """The turn of the rows of a table, with its base dwell filled.

    Rows of zero lift are laid where the table leaves them out: behind the ends of a table of the
    lobe alone, and between two rows of equal zero lift. A gap elsewhere is a fault.

    table: in order of phase; quantum: last digit, m; spacing: of the rows, deg; covered: whether
    they go round the turn; base: last decimals up to which a lift is that of the base circle.
    """
    filled: list[TurnRow] = []
    faults = []
    for k, row in enumerate(table):
        after = table[(k + 1) % len(table)]
        gap = after.theta - row.theta
        if k + 1 == len(table):
            gap += 360.0
        filled.append(row)
        rows_lack = gap > MISSING_ROWS * spacing
        both_low = abs(row.steps) <= base and abs(after.steps) <= base
        if rows_lack and both_low and (not covered or row.steps == after.steps):
            level = row if covered else TurnRow(0.0, 0.0, 0, 0)
            count = int(gap / spacing)
            for j in range(1, count):
                theta = (row.theta + gap * j / count) % 360.0
                filled.append(level._replace(theta=theta, line=0))
        elif rows_lack and gap > WIDEST_GAP:
            found = f"the rows of lines {row.line} and {after.line} are {gap:.6g} deg apart"
            expected = f"expected at most {WIDEST_GAP:g} deg of cam where the lift moves"
            cure = "measure the rows between"
            faults.append(Fault(f"{name}:{row.line}", "angle", found, expected, cure))
    raise_each_cause(faults)
    filled.sort(key=lambda row: row.theta)
    thetas = [row.theta for row in filled]
    lifts = [row.lift for row in filled]
    lines = np.array([row.line for row in filled])
    dwells = _dwells(name, thetas, lifts, [row.steps for row in filled], quantum)
    return Turn(np.array(thetas), np.array(lifts), lines, quantum, spacing, dwells)


def _dwells(
    name: str, theta: list[float], lift: list[float], steps: list[int], quantum: float
) -> list[Dwell]:
    """Runs of equal lifts too long to be a rounded nose.

    theta (deg) and lift (m) of the rows, in order of phase; steps: the lifts in last digits, whole
    numbers that are equal where the rows are; quantum: the last digit, m.
    """
    n = len(steps)
    starts = [k for k in range(n) if steps[k] != steps[k - 1]]  # a run of equal rows begins here
    runs = []
    moving = 360.0  # deg that are in no run
    for first, after in itertools.pairwise([*starts, starts[0] + n]):
        length = (theta[(after - 1) % n] - theta[first]) % 360.0
        if length >= DWELL_DEG and after - first >= 5:
            runs.append(_EqualRows(first, after - first, length))
            moving -= length
    # A parabola as high as the lift over half of what moves: it is flat within a last digit for
    # 2 sqrt(quantum / curvature).
    half = 0.5 * moving / DEG
    curvature = 2.0 * (max(lift) - min(lift)) / (half * half)
    nose = 4.0 * sqrt(quantum / curvature) * DEG  # twice that
    runs = [run for run in runs if run.length >= nose]
    off = n - sum(run.rows for run in runs)
    if off < LEAST_MOVING:
        found = f"found {plural(off, 'row')} of moving lift"
        expected = f"expected at least {LEAST_MOVING}"
        raise refused(name, "file", found, expected, "measure more rows")
    return [Dwell(theta[run.first], theta[run.first] + run.length, lift[run.first]) for run in runs]


class _EqualRows(NamedTuple):
    """Rows side by side with one lift."""

    first: int  # index of the first
    rows: int  # how many
    length: float  # deg from the first to the last


def _refuse_spikes(turn: Turn, name: str) -> None:
    """Refuse rows that are off all their neighbours.

    One wrong row shows as a pattern that a corner of the cam cannot make: it is off by e, and every
    neighbour by its weight times -e.
    """
    reach = 2  # rows on either side
    off, weights = turn.deviations(reach)
    sizes = np.sort(np.abs(off[off != 0.0]))
    least = SPIKE * turn.quantum
    if len(sizes):
        median = float(sizes[(len(sizes) - 1) // 2])
        least = max(least, BACKGROUND * median)
    is_spike = (np.abs(off) > least) & (turn.line > 0)
    slack = PATTERN * np.abs(off) + turn.quantum
    for weight, step in zip(weights, (-2, -1, 1, 2), strict=True):
        # of the row that has this row as its neighbour at `step`, which is the one at -step
        off_there = np.roll(off, step)
        weight_of_this = np.roll(weight, step)
        is_spike &= np.abs(off_there + weight_of_this * off) <= slack
    raise_each_cause(
        Fault(
            f"{name}:{turn.line[k]}",
            "lift",
            f"found a spike: the row is {MM * off[k]:.6g} mm off its neighbours",
            f"expected at most {MM * least:.6g} mm, {least / turn.quantum:.3g} last digits",
            "correct the row, or remove it",
        )
        for k in np.flatnonzero(is_spike)
    )
