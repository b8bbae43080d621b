"""How a lift table in a file seems to be written, for `cam init`: a proposal that the user checks.

The table is the longest run of lines with the same number of cells, two of them numbers. What only
its maker knows is guessed from the titles and the sizes, and marked as a guess.
"""

import re
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from camcli.cams.files import decoded, refused
from camcli.cams.lift_reading import UNIT_WORDS, number, splitter, text_lines

LEAST_RUN = 8  # lines
MOST_HEADER = 3  # lines
ANGLE = r"deg|°|ang|winkel|grad|theta|phi|crank|cam|kw|nw|rot|pos"
CRANK = r"crank|kurbel|\bkw|°kw|\bca\b|\bcad\b|°ca"
LIFT = r"lift|hub|rise|valve|ventil|displ|hoehe|höhe|\bh\b|\by\b|\bs\b"


@dataclass
class Guess:
    """Keys of the section `cam` as they seem to be; `unsure`: why a key is only a guess."""

    keys: dict[str, Any]
    unsure: dict[str, str] = field(default_factory=dict)


def guess(data: bytes, name: str) -> Guess:
    """How the table in these bytes seems to be written; raises SceneError where there is none."""
    lines = text_lines(decoded(data, name, table=True), name)
    decimal, start, rows = max(
        ((decimal, *_longest_run(lines, decimal)) for decimal in ("point", "comma")),
        key=lambda run: len(run[2]),
    )
    if len(rows) < LEAST_RUN:
        what = f"found no {LEAST_RUN} rows of numbers one after the other"
        raise refused(name, "", what, "expected a table of angles and lifts", "is it the file?")
    split, width = splitter(lines[start][1], decimal), len(rows[0])
    first = start
    while first > 0 and start - first < MOST_HEADER:
        cells = [word for _, word in split(lines[first - 1][1])]
        if len(cells) != width or sum(map(bool, cells)) < 2:
            break
        first -= 1
    titles = [[word for _, word in split(line)] for _, line in lines[first:start]]
    words = [" ".join(column).lower() for column in zip(*titles, strict=True)] or [""] * width
    columns = {
        k: [float(number(row[k], decimal)) for row in rows]
        for k in range(width)
        if all(number(row[k], decimal) for row in rows)
    }
    found = Guess({"header": start - first})
    if first > 0 and lines[first][0] > 1:
        found.keys["skip_lines"] = lines[first][0] - 1
    if decimal == "comma":
        found.keys["decimal"] = decimal
    angle = _angle_column(columns, words, name)
    lift = _lift_column(columns, words, angle, name)
    names = titles[0] if titles else []
    for key, k in (("angle_column", angle), ("lift_column", lift)):
        named = names and names[k] and names.count(names[k]) == 1
        found.keys[key] = names[k] if named else k + 1
    _angle_kind(found, columns[angle], words[angle])
    _lift_unit(found, columns[lift], words[lift])
    return found


def _longest_run(lines: list[tuple[int, str]], decimal: str) -> tuple[int, list[list[str]]]:
    """(first line, cells) of the longest run of rows of numbers."""
    best: tuple[int, list[list[str]]] = (0, [])
    run: list[list[str]] = []
    for k, (_, line) in enumerate(lines):
        cells = [word for _, word in splitter(line, decimal)(line)]
        if sum(bool(number(word, decimal)) for word in cells) < 2:
            run = []
            continue
        run = [*run, cells] if run and len(run[0]) == len(cells) else [cells]
        if len(run) > len(best[1]):
            best = k + 1 - len(run), run
    return best


def _angle_column(columns: dict[int, list[float]], words: list[str], name: str) -> int:
    """The column that only rises or only falls; by its title where there are several."""
    steady = [k for k, column in columns.items() if _steady(column)]
    if not steady:
        found, cure = "found no column that only rises or only falls", "is the angle in the file?"
        raise refused(name, "", found, "expected a column of angles", cure)
    spans = [k for k in steady if abs(columns[k][-1] - columns[k][0]) > 30.0]
    titled = [k for k in steady if re.search(ANGLE, words[k])]
    return next(iter([k for k in titled if k in spans] or titled or spans or steady))


def _steady(column: list[float]) -> bool:
    """Whether the numbers only rise or only fall, but for one leap back by a turn."""
    steps = [b - a for a, b in pairwise(column)]
    against = min(([s for s in steps if s <= 0.0], [s for s in steps if s >= 0.0]), key=len)
    return not against or (len(against) == 1 and abs(against[0]) > 180.0)


def _lift_column(columns: dict[int, list[float]], words: list[str], angle: int, name: str) -> int:
    """A column that rises and falls again; by its title where there are several."""
    others = {k: column for k, column in columns.items() if k != angle}
    humps = [k for k, c in others.items() if max(c) > max(abs(c[0]), abs(c[-1])) and min(c) > -0.1]
    titled = [k for k in humps if re.search(LIFT, words[k])]
    if not humps:
        found, cure = "found no column that rises and falls again", "is the lift in the file?"
        raise refused(name, "", found, "expected a column of lifts", cure)
    return next(iter(titled or humps))


def _angle_kind(found: Guess, angles: list[float], title: str) -> None:
    span = abs(angles[-1] - angles[0])
    crank = span > 400.0 or bool(re.search(CRANK, title))
    found.keys["angle"] = "crank" if crank else "cam"
    if not crank and not re.search(r"cam|nocken|\bnw", title) and span < 340.0:
        found.unsure["angle"] = f"{span:g} deg of the cam, or of a crank that turns twice as fast?"


def _lift_unit(found: Guess, lifts: list[float], title: str) -> None:
    unit = next((unit for words, unit in UNIT_WORDS.items() if re.search(words, title)), None)
    top = max(lifts)
    if unit is None:
        unit = "mm" if top > 1.0 else "inch" if top > 0.05 else "m"
        found.unsure["lift"] = f"the largest number is {top:g}"
    found.keys["lift"] = unit
