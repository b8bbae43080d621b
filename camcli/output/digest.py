"""Digest of a run's tables: few numbers that change when anything of note does.

Three groups, each a flat map from a name to a number or a short text:
regular  tables straight from the kernel, of motions that repeat: exact
chaotic  the same of motions that do not: exact, and the most sensitive to a single bit
solved   everything else, where equations were solved: to TOLERANCE of a value
"""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

REGULAR, CHAOTIC, SOLVED = "regular", "chaotic", "solved"
TOLERANCE = 1e-8  # of a solved number
SLIGHT = 1e-9  # of a simulated number: a difference of rounding, not of the machine
ABSOLUTE = 1e-12
KERNEL = ("impacts.csv", "strobe.csv", "trajectory.csv", "events.csv", "speeds.csv")
CHAOS = ("aperiodic", "undecided")
WORDS = ("attractor", "branch", "stable", "chatter", "impact", "period")  # numbers that name
SKIPPED = ("rpm_error", "standard_error", "period")
LEVELS = {"least": 0.0, "q05": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "q95": 0.95,
          "largest": 1.0}  # fmt: skip
MOST_ROWS = 40  # of a table that is kept whole
MOST_WORDS = 24  # different texts of a column that are counted one by one

Group = dict[str, Any]
Columns = dict[str, np.ndarray]  # doubles, or texts where a cell is none


def digest(folder: Path) -> dict[str, Group]:
    """The digest of the artefacts in a folder."""
    groups: dict[str, Group] = {REGULAR: {}, CHAOTIC: {}, SOLVED: {}}
    result = json.loads((folder / "run.json").read_text())["result"]
    label = result.get("label", "") if isinstance(result, dict) else ""
    tables = {path.name: _columns(path) for path in sorted(folder.glob("*.csv"))}
    speeds = tables.get("speeds.csv", {"rpm": np.empty(0), "label": np.empty(0)})
    chaotic = speeds["rpm"][np.isin(speeds["label"], CHAOS)]
    for name, columns in tables.items():
        if name == "speeds.csv":
            _speeds(groups[REGULAR], columns)
        elif name not in KERNEL:
            _solved(groups[SOLVED], name, columns)
        elif "rpm" in columns:
            rows = np.isin(columns["rpm"], chaotic)
            _exact(groups[CHAOTIC], name, columns, rows)
            _exact(groups[REGULAR], name, columns, ~rows)
        else:
            every = np.ones(len(next(iter(columns.values()))), bool)
            _exact(groups[CHAOTIC if label in CHAOS else REGULAR], name, columns, every)
    if label:
        groups[REGULAR]["label"] = label
    return groups


def _columns(path: Path) -> Columns:
    """The columns of a table by name."""
    with open(path, encoding="utf-8", newline="") as file:
        names = file.readline().strip().split(",")
        body = file.tell()
        if not file.readline():
            return {name: np.empty(0) for name in names}
        file.seek(body)
        try:
            found = np.loadtxt(file, delimiter=",", comments=None, ndmin=2)
            return dict(zip(names, found.T, strict=True))
        except ValueError:  # a cell that is empty or text
            file.seek(body)
            cells = zip(*csv.reader(file), strict=True)
            return {name: _column(column) for name, column in zip(names, cells, strict=True)}


def _column(cells: Sequence[str]) -> np.ndarray:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def _speeds(group: Group, columns: Columns) -> None:
    """How often each label occurs, and between which speeds."""
    labels, rpm = columns["label"], columns["rpm"]
    _counts(group, "speeds.csv status", columns["status"])
    counts = Counter(labels.tolist())
    group["speeds.csv different labels"] = len(counts)
    for label, count in counts.most_common(MOST_WORDS):
        mine = rpm[labels == label]
        name = f"speeds.csv {_short(label)}"
        group[f"{name} speeds"] = count
        group[f"{name} from rpm"], group[f"{name} to rpm"] = float(mine.min()), float(mine.max())


def _exact(group: Group, name: str, columns: Columns, rows: np.ndarray) -> None:
    """Count, bits and quantiles of some rows of a table of the kernel."""
    group[f"{name} rows"] = int(rows.sum())
    if not rows.any():
        return
    bits = sha256()
    for column in columns.values():
        mine = column[rows]
        text = mine.dtype.kind != "f"
        bits.update("\n".join(mine.tolist()).encode() if text else mine.astype("<f8").tobytes())
    _quantiles(group, name, {k: v[rows] for k, v in columns.items() if k != "rpm"})
    group[f"{name} bits"] = bits.hexdigest()[:16]


def _solved(group: Group, name: str, columns: Columns) -> None:
    """A small table cell by cell, a large one by quantiles."""
    count = len(next(iter(columns.values())))
    group[f"{name} rows"] = count
    if count > MOST_ROWS:
        _quantiles(group, name, columns)
        return
    texts = [k for k, v in columns.items() if v.dtype.kind != "f" or k in WORDS]
    seen: Counter[str] = Counter()
    for row in range(count):
        key = " ".join(filter(None, (_text(columns[k][row]) for k in texts)))
        seen[key] += 1
        key = f"{name} {key}" + (f" #{seen[key]}" if seen[key] > 1 else "")
        for column, values in columns.items():
            if column not in texts and column not in SKIPPED and not np.isnan(values[row]):
                group[f"{key} {column}"] = _number(values[row])


def _quantiles(group: Group, name: str, columns: Columns) -> None:
    for column, values in columns.items():
        if column in SKIPPED:
            continue
        if values.dtype.kind != "f" or column in WORDS:
            _counts(group, f"{name} {column}", values)
            continue
        known = np.sort(values[~np.isnan(values)])
        for level, share in LEVELS.items() if len(known) else ():
            group[f"{name} {column} {level}"] = _number(known[round(share * (len(known) - 1))])


def _counts(group: Group, name: str, values: np.ndarray) -> None:
    counts = Counter(_text(value) for value in values.tolist())
    for word, count in counts.most_common(MOST_WORDS):
        group[f"{name} = {word}"] = count
    if len(counts) > MOST_WORDS:
        group[f"{name} different"] = len(counts)


def _number(value: np.floating) -> float | str:
    """As JSON knows it: infinities are texts."""
    return float(value) if np.isfinite(value) else str(value)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float | np.floating) else _short(str(value))


def _short(text: str) -> str:
    """The text; a long one by its beginning and a hash."""
    return text if len(text) <= 40 else f"{text[:28]}~{sha256(text.encode()).hexdigest()[:8]}"


@dataclass(frozen=True)
class Drift:
    """A number that is not the reference's; `by` is None where they cannot be subtracted."""

    figure: str
    group: str
    name: str
    reference: Any
    found: Any
    by: float | None = None
    portability: bool = False  # the bits of another machine would explain it, and nothing else


def drifts(figure: str, old: Mapping[str, Group], new: Mapping[str, Group]) -> list[Drift]:
    """All numbers of a digest that are not the reference's."""
    found = []
    for group in (REGULAR, CHAOTIC, SOLVED):
        for name in dict.fromkeys([*old[group], *new[group]]):
            was, now = old[group].get(name), new[group].get(name)
            if was == now:
                continue
            by, slight = None, False
            if isinstance(was, int | float) and isinstance(now, int | float):
                by, size = now - was, max(abs(was), abs(now))
                if group == SOLVED and abs(by) <= ABSOLUTE + TOLERANCE * size:
                    continue
                slight = abs(by) <= SLIGHT * size
            bits = group == REGULAR and (slight or name.endswith(" bits"))
            found.append(Drift(figure, group, name, was, now, by, group == CHAOTIC or bits))
    return found
