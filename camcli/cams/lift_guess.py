"""How a lift table in a file seems to be written, for `cam init`: a proposal that the user checks.

The table is the longest run of lines with the same number of cells, two of them numbers. What only
its maker knows is guessed from the titles and the sizes, and marked as a guess. A row that cannot
be read is refused by line and column, never skipped.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median
from typing import Any, NamedTuple

from camcli.cams.files import decoded, refused
from camcli.cams.lift_reading import (
    MAX_ROWS,
    has_quoted_comma,
    number,
    raise_each_cause,
    refuse_too_many_rows,
    splitter,
    text_lines,
    units_in_title,
)
from camcli.errors import Fault, SceneError, plural, shown
from camcli.quantities import LENGTHS, MM

LEAST_RUN = 8  # lines
MOST_HEADER = 3  # lines
NAME_AND_UNIT = re.compile(r"\w.*[\[(].*\S.*[\])]")  # Hub [mm], angle (deg)
ANGLE = r"deg|°|ang|winkel|grad|theta|phi|crank|cam|kw|nw|rot|pos"
CRANK = r"crank|kurbel|\bkw|°kw|\bca\b|\bcad\b|°ca"
LIFT = r"lift|hub|rise|valve|ventil|displ|hoehe|höhe|\bh\b|\by\b|\bs\b"
VALVE, LOBE = r"valve|ventil", r"lobe|nocken|tappet|lifter|stößel|stoessel|\bcam\b"
NO_LIFT = r"vel|acc|jerk|geschw|beschl|ruck|force|kraft|curv|error|dev|abw|tol|/ ?(deg|rad|°|s)"
HUNDREDTHS = r"(?<!\d)1/100 ?mm|(?<!\d)0?\.01 ?mm"  # of a millimetre
RADII = 0.05  # of the largest number: where the smallest is larger they are radii
BELOW = 0.02  # of the largest lift: lifts fall so far below zero at most
LOBE_HEIGHT, GROUND = 0.1, 0.02  # of the largest lift: a lobe rises above, and falls below
LEAST_MM = 1.0  # cams lift some mm, hardly less
LEAST_INCHES = 0.05  # and some hundredths of an inch; smaller numbers are m
LARGEST_MM, LARGEST_THOU = 120.0, 3000.0  # numbers above are no mm, and no thousandths of an inch
LARGE = 0.1  # m: a larger lift is doubted
FLAT_END = 0.05  # of the lift: a flank begins and ends with smaller steps
ALIKE = 0.01  # of the largest lift: columns that differ by less are of one lobe
LEAP = (
    0.5  # of a column's range: an angle that falls back by more goes through zero, or starts anew
)
MOST_LEAPS = 20
NEXT_ANGLE = 1.5  # spacings of the rows: how far the next angle may be


@dataclass
class Guess:
    """Keys of the section `cam` as they seem to be; `unsure`: why a key is only a guess.

    lobes: the same of other lobes in the file, by their columns.
    """

    keys: dict[str, Any]
    unsure: dict[str, str] = field(default_factory=dict)
    lobes: dict[str, Guess] = field(default_factory=dict)

    def doubt(self, key: str, why: str) -> None:
        """Add a reason for which a key is only a guess."""
        self.unsure[key] = f"{self.unsure[key]}; {why}" if key in self.unsure else why


class CutLine(NamedTuple):
    """A line cut into cells."""

    line: int  # of the file, from 1
    cells: list[tuple[int, str]]  # (column from 1, text)
    numbers: list[str]  # '' where a cell is none


class NumberRun(NamedTuple):
    """Lines of numbers with equally many cells, one after the other."""

    start: int  # index of its first line
    rows: list[CutLine]


def guess(data: bytes, name: str, most_rows: int = MAX_ROWS) -> Guess:
    """How the table in these bytes seems to be written; raises SceneError where there is none.

    name: of the file, for messages. It raises for more than `most_rows`, too, before it looks for a
    cam in them.
    """
    text = text_lines(decoded(data, name, table=True), name)
    cut_by = {decimal: _cut(text, decimal) for decimal in ("point", "comma")}
    decimal = max(cut_by, key=lambda decimal: len(_longest_run(cut_by[decimal]).rows))
    lines = cut_by[decimal]
    run = _longest_run(lines)
    if len(run.rows) < LEAST_RUN:
        raise _no_table(lines, name)
    refuse_too_many_rows(len(run.rows), name, most=most_rows)
    header = _header_of(lines, run)
    columns = _number_columns(run)
    angle = _angle_column(columns, header.words, name)
    lift, others = _lift_columns(columns, header.words, angle, name)
    table = GuessedTable(lines, run, angle, lift, name)
    table.refuse_what_cannot_be_read()

    def proposal(lift_column: int) -> Guess:
        """The keys of a scene whose lift is in a column."""
        guessed = Guess({"header": run.start - header.first})
        if header.first > 0:
            guessed.keys["skip_lines"] = lines[header.first].line - 1
            _doubt_what_is_skipped(guessed, lines[: header.first], table)
        if decimal == "comma":
            guessed.keys["decimal"] = decimal
        guessed.keys["angle_column"] = header.name_of(angle)
        guessed.keys["lift_column"] = header.name_of(lift_column)
        _angle_kind(guessed, columns[angle], header.words[angle])
        _lift_unit(guessed, columns[lift_column], header.words[lift_column])
        _radii(guessed, columns[lift_column])
        _one_flank(guessed, columns[lift_column])
        _rocker(guessed, header.words[lift_column])
        return guessed

    guessed = proposal(lift)
    for k in _other_lobes(guessed, columns, lift, [(k, header.title(k)) for k in others]):
        other = proposal(k)
        guessed.lobes[str(other.keys["lift_column"])] = other
    return guessed


# -- lines to a run of rows --------------------------------------------------------------------


class Header(NamedTuple):
    """The lines of titles above the rows.

    first: index of the first such line, that of the first row without any. titles: those of its
    first line, none without a header. words: all titles of each column, in small letters.
    """

    first: int
    titles: list[str]
    words: list[str]

    def title(self, column: int) -> str:
        """The title of a column, counted from 0; '' without a header."""
        return self.titles[column] if self.titles else ""

    def name_of(self, column: int) -> str | int:
        """How a scene names a column: by its title where no other has it, else by number from 1."""
        title = self.title(column)
        return title if title and self.titles.count(title) == 1 else column + 1


def _header_of(lines: list[CutLine], run: NumberRun) -> Header:
    """The titles above a run of rows."""
    first = _start_of_header(lines, run)
    rows = [[word for _, word in line.cells] for line in lines[first : run.start]]
    words = [" ".join(column).lower() for column in zip(*rows, strict=True)]
    width = len(run.rows[0].cells)
    return Header(first, rows[0] if rows else [], words or [""] * width)


def _number_columns(run: NumberRun) -> dict[int, list[float]]:
    """The columns of which more than half the cells are numbers: these numbers, by index from 0."""
    columns = {}
    for k in range(len(run.rows[0].cells)):
        numbers = [row.numbers[k] for row in run.rows if row.numbers[k]]
        if 2 * len(numbers) > len(run.rows):
            columns[k] = [float(number) for number in numbers]
    return columns


def _cut(text: list[tuple[int, str]], decimal: str) -> list[CutLine]:
    """The cells of every line, with decimal points or commas."""
    quoted = any(has_quoted_comma(line) for _, line in text)
    lines = []
    for n, line in text:
        cells = splitter(line, decimal, quoted)(line)
        lines.append(CutLine(n, cells, [number(word, decimal) for _, word in cells]))
    return lines


def _longest_run(lines: list[CutLine]) -> NumberRun:
    """The longest run of rows of numbers: lines with two numbers at least, and equally many cells.

    Of several as long the first.
    """
    best_start = 0
    best_end = 0
    start = 0  # of the run that the line is in
    for k, line in enumerate(lines):
        numbers = sum(bool(number) for number in line.numbers)
        if numbers < 2:
            start = k + 1
            continue
        if k > start and len(line.cells) != len(lines[start].cells):
            start = k
        if k + 1 - start > best_end - best_start:
            best_start = start
            best_end = k + 1
    return NumberRun(best_start, lines[best_start:best_end])


def _start_of_header(lines: list[CutLine], run: NumberRun) -> int:
    """Index of the first line of titles above the rows; that of the first row where there is none.

    A line of titles has as many cells as a row, two of them filled, and at most one is a number.
    One that names two columns with their units, as "Hub [mm]", is the only one: what stands above
    it is of the whole file, as a date is.
    """
    first = run.start
    while first > 0 and run.start - first < MOST_HEADER:
        above = lines[first - 1]
        filled = sum(bool(word) for _, word in above.cells)
        numbers = sum(map(bool, above.numbers))
        if len(above.cells) != len(run.rows[0].cells) or filled < 2 or numbers >= 2:
            break
        first -= 1
        if sum(bool(NAME_AND_UNIT.search(word)) for _, word in above.cells) >= 2:
            break
    return first


def _no_table(lines: list[CutLine], name: str) -> SceneError:
    """The fault of a file without a table; it names the first line that is nearly a row.

    That is one with a single number, and text where another number might stand.
    """
    found = f"found no {LEAST_RUN} rows of numbers one after the other"
    for line in lines:
        no_numbers = [k for k, number in enumerate(line.numbers) if not number]
        if not no_numbers or len(line.numbers) - len(no_numbers) != 1:
            continue
        _, text = line.cells[no_numbers[0]]
        if text:
            found += f", and '{shown(text, 40)}' in line {line.line}"
            break
    return refused(name, "", found, "expected a table of angles and lifts", "is it the file?")


class GuessedTable:
    """The rows of numbers, and which lines around them belong to them.

    angle, lift: which of a row's cells they are, from 0. angles: of the rows; where they fall in
    the file, they are taken with the sign -1, so that they rise. reach: how far the angle may fall
    back from a row to the next in one table.
    """

    def __init__(self, lines: list[CutLine], run: NumberRun, angle: int, lift: int, name: str):
        self.lines = lines
        self.run = run
        self.angle = angle
        self.lift = lift
        self.name = name
        self.width = len(run.rows[0].cells)
        angles = [float(row.numbers[angle]) for row in run.rows if self.is_row(row)]
        steps = [after - before for before, after in pairwise(angles)]
        rising = [step for step in steps if step > 0.0]
        self.sign = 1.0 if len(rising) > len(steps) / 2 else -1.0
        self.angles = [self.sign * angle for angle in angles]
        self.reach = NEXT_ANGLE * median(map(abs, steps))

    def refuse_what_cannot_be_read(self) -> None:
        """Raise SceneError where a row, or a line below the rows, cannot be read.

        A scene may skip lines above the table, or take them for its header, none below its first
        row. So a line that is no row is refused where rows of the same table, by their angles, are
        above it or below it. Rows that begin anew are another table, which a file must not hold.
        """
        begin = self.run.start
        top = min([k for k in range(begin) if self._is_before(k)], default=begin)
        below = self.lines[begin + len(self.run.rows) :]
        rows = [k for k, line in enumerate(below) if self.is_row(line)]
        continuing = [k for k in rows if self._is_behind(k, below[k])]
        again = min(set(rows) - set(continuing), default=len(below))
        if again < len(below) and not any(k < again for k in continuing):
            raise self._two_tables(below[again], "rows of numbers begin again")
        among = [*self.lines[top:begin], *self.run.rows, *below[:again]]
        raise_each_cause(self._fault(line) for line in among if not self.is_row(line))
        for k, (before, now) in enumerate(pairwise(self.angles), 1):
            if before - now > self.reach and now >= self.angles[0]:
                raise self._two_tables(self.run.rows[k], "the angle begins again")

    def is_row(self, line: CutLine) -> bool:
        """Whether both cells that count are numbers."""
        same = len(line.cells) == self.width
        return same and bool(line.numbers[self.angle] and line.numbers[self.lift])

    def _is_before(self, k: int) -> bool:
        """Whether the angle of a line above comes before the first row's, by so many rows."""
        angle = self._angle_of(self.lines[k])
        most = self.reach * (self.run.start - k)
        return angle is not None and 0.0 < self.angles[0] - angle <= most

    def _is_behind(self, k: int, line: CutLine) -> bool:
        """Whether the angle of a line, the k-th below the rows, follows theirs by so many rows."""
        angle = self._angle_of(line)
        last = self.angles[-1]
        if angle is None:
            return False
        turns = (0.0,) if angle >= self.angles[0] else (0.0, 360.0, 720.0)  # through zero
        return any(0.0 < angle + turn - last <= self.reach * (k + 1) for turn in turns)

    def _angle_of(self, line: CutLine) -> float | None:
        """The angle in a line, rising, where it has one."""
        if self.angle >= len(line.numbers) or not line.numbers[self.angle]:
            return None
        return self.sign * float(line.numbers[self.angle])

    def _fault(self, line: CutLine) -> Fault:
        """What is wrong with a line among the rows, or below them."""
        place = f"{self.name}:{line.line}"
        cure = "correct the row or remove it, or begin the line with # if it is a comment"
        if len(line.cells) != self.width:
            expected = f"expected {self.width} as in the rows beside it"
            return Fault(place, "", f"found {plural(len(line.cells), 'cell')}", expected, cure)
        bad = next(k for k in (self.angle, self.lift) if not line.numbers[k])
        column, text = line.cells[bad]
        found = f"found '{shown(text, 40)}'" if text else "found an empty cell"
        return Fault(f"{place}:{column}", "", found, "expected a number", cure)

    def _two_tables(self, line: CutLine, what: str) -> SceneError:
        """The fault of a file with a second table, which begins in a line."""
        found = f"{what} at {line.numbers[self.angle]}"
        expected = "expected one table in a file"
        cure = "cut the file there, a table of its own for each cam, and make a scene of each"
        return refused(f"{self.name}:{line.line}", "", found, expected, cure)


def _doubt_what_is_skipped(guessed: Guess, lines: list[CutLine], table: GuessedTable) -> None:
    """Tell the user where another table stands above the one that is read."""
    rows = [line.line for line in lines if table.is_row(line)]
    if len(rows) >= LEAST_RUN:
        guessed.doubt(
            "skip_lines",
            f"lines {rows[0]} to {rows[-1]} are another table, which is not read; for a scene of "
            "it put it into a file of its own",
        )


# -- what the columns are ----------------------------------------------------------------------


def _angle_column(columns: dict[int, list[float]], words: list[str], name: str) -> int:
    """The column that only rises or only falls; where several do, by title and span."""
    steady = [k for k, column in columns.items() if _steady(column)]
    if not steady:
        found = "found no column that only rises or only falls"
        cure = "is the angle in the file?"
        raise refused(name, "", found, "expected a column of angles", cure)
    wide = [k for k in steady if abs(columns[k][-1] - columns[k][0]) > 30.0]
    titled = [k for k in steady if re.search(ANGLE, words[k])]
    titled_and_wide = [k for k in titled if k in wide]
    return (titled_and_wide or titled or wide or steady)[0]


def _steady(column: list[float]) -> bool:
    """Whether the numbers only rise or only fall, but for a few leaps back by half their range."""
    steps = [after - before for before, after in pairwise(column)]
    not_rising = [step for step in steps if step <= 0.0]
    not_falling = [step for step in steps if step >= 0.0]
    against = min((not_rising, not_falling), key=len)  # the direction of the column
    leap = LEAP * (max(column) - min(column))
    return len(against) <= MOST_LEAPS and all(abs(step) > leap for step in against)


def _lift_columns(
    columns: dict[int, list[float]], words: list[str], angle: int, name: str
) -> tuple[int, list[int]]:
    """(the column that rises and falls again, others like it); by its title where there are more.

    columns: numbers by index; words: titles; angle: index of its column. One that begins and ends
    at its nose counts too, where there is no other, and then one that only rises or only falls: a
    flank.
    """
    candidates = {
        k: column
        for k, column in columns.items()
        if k != angle and min(column) > -BELOW * max(column) - 1e-9
    }
    humps = [
        k for k, lifts in candidates.items() if max(lifts) > max(abs(lifts[0]), abs(lifts[-1]))
    ]
    if not humps:
        uneven = {k: lifts for k, lifts in candidates.items() if max(lifts) > min(lifts)}
        humps = [k for k, lifts in uneven.items() if not _steady(lifts)]
    if not humps:
        humps = [k for k, lifts in candidates.items() if _flank(lifts)]
    if not humps:
        found = "found no column that rises and falls again"
        cure = "is the lift in the file?"
        raise refused(name, "", found, "expected a column of lifts", cure)
    not_excluded = [k for k in humps if not re.search(NO_LIFT, words[k])]
    titled = [k for k in not_excluded if re.search(LIFT, words[k])]
    chosen = (titled or not_excluded or humps)[0]
    return chosen, [k for k in not_excluded if k != chosen]


def _flank(lifts: list[float]) -> bool:
    """Whether the lifts only rise from the base circle to a nose, or only fall from it.

    On a base circle and on a nose the cam is flat: the first and the last step have to be small.
    """
    steps = [after - before for before, after in pairwise(lifts)]
    one_way = all(step >= 0.0 for step in steps) or all(step <= 0.0 for step in steps)
    size = max(lifts) - min(lifts)
    largest_end = max(abs(steps[0]), abs(steps[-1]))
    return one_way and largest_end < FLAT_END * size


def _one_flank(guessed: Guess, lifts: list[float]) -> None:
    """Say so where the table seems to be one flank: nobody but its maker knows the other."""
    if not _flank(lifts):
        return
    guessed.keys["mirrored"] = False
    guessed.doubt(
        "mirrored",
        "the lift only rises or only falls, so this is one flank: write true if the lobe is "
        "symmetric, else measure the other flank too",
    )


def _angle_kind(guessed: Guess, angles: list[float], title: str) -> None:
    """Guess whether the angles (deg) are of cam or crank, and say where that is doubtful."""
    span = abs(angles[-1] - angles[0])
    crank = span > 400.0 or bool(re.search(CRANK, title))
    guessed.keys["angle"] = "crank" if crank else "cam"
    if not crank and not re.search(r"cam|nocken|\bnw", title) and span < 340.0:
        guessed.doubt("angle", f"{span:g} deg of the cam, or of a crank that turns twice as fast?")


def _lift_unit(guessed: Guess, numbers: list[float], title: str) -> None:
    """The unit by the title, else by the size of the numbers."""
    top = max(numbers)
    lift = top - min(numbers) if min(numbers) > RADII * top else top
    if re.search(HUNDREDTHS, title):
        guessed.keys |= {"lift": "fraction", "max_lift": 1e-5}
        guessed.doubt(
            "lift", f"hundredths of a millimetre by the title, {lift / 100:.4g} mm of lift"
        )
        return
    units = units_in_title(title)
    if units:
        unit = units[0]
        guessed.keys["lift"] = unit
        if lift * LENGTHS[unit] > LARGE:
            reason = f"the title says {unit}, but that is a lift of {lift * LENGTHS[unit]:.4g} m"
            guessed.doubt("lift", reason)
        return
    unit, reason = _unit_by_size(top, lift)
    guessed.keys["lift"] = unit
    guessed.doubt("lift", reason)


def _unit_by_size(top: float, lift: float) -> tuple[str, str]:
    """(the unit, why it is doubtful), from the largest number and the lift in that unit."""
    if lift > LARGEST_THOU:
        return "um", f"the largest number is {top:g}, too large for thousandths of an inch"
    if lift > LARGEST_MM:
        as_thou = f"as thousandths of an inch a lift of {lift * LENGTHS['thou'] * MM:.4g} mm"
        return "thou", f"the largest number is {top:g}: {as_thou}, as mm one of {lift / MM:.4g} m"
    unit = "m"
    if lift > LEAST_MM:
        unit = "mm"
    elif lift > LEAST_INCHES:
        unit = "inch"
    return unit, f"the largest number is {top:g}"


def _radii(guessed: Guess, numbers: list[float]) -> None:
    """Where all numbers are far from zero they are radii: the lift is what is more than the least.

    They are the follower's lift only if what ran on the cam was a follower like the machine's.
    """
    least = min(numbers)
    top = max(numbers)
    if least <= RADII * top:
        return
    guessed.keys["subtract"] = least
    unit = guessed.keys.get("max_lift") or LENGTHS[guessed.keys["lift"]]
    guessed.keys["base_radius"] = float(f"{least * unit:.12g}")
    guessed.doubt(
        "subtract",
        f"the numbers go from {least:g} to {top:g}, so they are radii: the least one is taken for "
        "the base circle, and what is more for the lift; that is the lift of the follower only "
        "where the radii were measured with a follower like it (a roller, a flat face)",
    )


def _rocker(guessed: Guess, title: str) -> None:
    """On which side of a rocker the table may be from."""
    valve = bool(re.search(VALVE, title)) and not re.search(LOBE, title)
    guessed.keys["rocker_ratio"] = 1
    guessed.keys["measured_at"] = "valve" if valve else "lobe"
    if not valve:
        guessed.doubt(
            "rocker_ratio",
            "taken without a rocker; if there is one, write its ratio (lift of the valve per lift "
            "of the lobe)",
        )
        guessed.doubt(
            "measured_at",
            "write valve if the table is of the valve and not of the lobe; beside a rocker that "
            "matters",
        )


# -- what else the file holds ------------------------------------------------------------------


def _other_lobes(
    guessed: Guess, columns: dict[int, list[float]], lift: int, others: Sequence[tuple[int, str]]
) -> list[int]:
    """The columns beside the lift that hold other lobes; the user is told of them.

    others: (index, title) of the columns that may. The user is told too where one is the same lobe
    in another unit, and where the lift rises and falls twice in its own column.
    """
    lobes = []
    lifts = columns[lift]
    size = max(lifts) - min(lifts)
    for k, title in others:
        column = columns[k]
        scale = max(column) - min(column)
        name = f"column {k + 1}" + (f" '{shown(title, 40)}'" if title else "")
        pairs = zip(_shares(lifts), _shares(column), strict=False)
        differ = max(abs(share - other_share) for share, other_share in pairs)
        if len(lifts) == len(column) and differ < ALIKE:
            reason = f"{name} is {scale / size:.4g} times this one"
            guessed.doubt(
                "lift_column", f"{reason}: the same lobe in another unit, or behind a rocker"
            )
        else:
            lobes.append(k)
            reason = f"{name} rises and falls too, another lobe: it has a scene of its own"
            guessed.doubt("lift_column", reason)
    count = _lobes(lifts)
    if count > 1:
        guessed.doubt(
            "lift_column",
            f"it rises from zero and comes back {count} times: if these are {count} cams, cut the "
            "file, a table for each, and make a scene of each",
        )
    return lobes


def _shares(lifts: list[float]) -> list[float]:
    """How far each lift is from the lowest, over the highest, from 0 to 1."""
    low = min(lifts)
    size = max(lifts) - low
    return [(lift - low) / size for lift in lifts]


def _lobes(lifts: list[float]) -> int:
    """How often the lift rises from its lowest and comes back, round the turn.

    A row is on a lobe above LOBE_HEIGHT, and off it below GROUND; those between do not count.
    """
    shares = [share for share in _shares(lifts) if share > LOBE_HEIGHT or share < GROUND]
    on_lobe = [share > LOBE_HEIGHT for share in shares]
    round_the_turn = [on_lobe[-1], *on_lobe]
    return sum(now and not before for before, now in pairwise(round_the_turn))
