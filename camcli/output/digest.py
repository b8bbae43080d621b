"""Digest of a run's tables: few numbers that change when anything of note does.

Three groups, each a flat map from a name to a number or a short text:
regular  tables straight from the kernel, of motions that repeat: exact
chaotic  the same of motions that do not: exact, and the most sensitive to a single bit
solved   everything else, where equations were solved: to SOLVED of a value
"""

from __future__ import annotations

import csv
import json
import re
from collections import Counter
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

REGULAR, CHAOTIC, SOLVED = "regular", "chaotic", "solved"
KERNEL = ("impacts.csv", "strobe.csv", "trajectory.csv", "events.csv", "speeds.csv")
CHAOS = ("aperiodic", "undecided")
WORDS = ("attractor", "branch", "stable", "chatter", "impact", "period")  # numbers that name
SKIPPED = ("rpm_error", "standard_error", "period")
LEVELS = {"least": 0.0, "q05": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "q95": 0.95,
          "largest": 1.0}  # fmt: skip
MOST_ROWS = 40  # of a table that is kept whole
PIECE = 1 << 24  # bytes of a large table read at a time
MOST_WORDS = 24  # different texts of a column that are counted one by one

Group = dict[str, Any]


def digest(folder: Path) -> dict[str, Group]:
    """The digest of the artefacts in a folder."""
    groups: dict[str, Group] = {REGULAR: {}, CHAOTIC: {}, SOLVED: {}}
    record = json.loads((folder / "run.json").read_text())
    label = record["result"].get("label", "") if isinstance(record["result"], dict) else ""
    chaotic = _chaotic_speeds(folder / "speeds.csv")
    for path in sorted(folder.glob("*.csv")):
        columns = _columns(path)
        if path.name == "speeds.csv":
            _speeds(groups[REGULAR], columns)
        elif path.name not in KERNEL:
            _solved(groups[SOLVED], path.name, columns)
        elif "rpm" in columns:
            rows = np.isin(columns["rpm"], chaotic)
            _exact(groups[CHAOTIC], path.name, columns, rows)
            _exact(groups[REGULAR], path.name, columns, ~rows)
        else:
            every = np.ones(len(next(iter(columns.values()))), bool)
            group = groups[CHAOTIC if label in CHAOS else REGULAR]
            _exact(group, path.name, columns, every)
    if label:
        groups[REGULAR]["label"] = label
    return groups


def _columns(path: Path) -> dict[str, np.ndarray]:
    """Columns by name: doubles, or texts where a cell is none."""
    with open(path, encoding="utf-8", newline="") as file:
        names = file.readline().strip().split(",")
        first = file.readline()
        if not first:
            return {name: np.empty(0) for name in names}
    if re.fullmatch(r"[-+0-9.e,]+", first.strip()) and ",," not in first:
        found = _numbers(path, len(names))
        if found is not None:
            return dict(zip(names, found.T, strict=True))
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))[1:]
    return {name: _column([row[k] for row in rows]) for k, name in enumerate(names)}


def _numbers(path: Path, count: int) -> np.ndarray | None:
    """A table of numbers only, piece by piece; None where it is not one."""
    pieces = []
    with open(path, "rb") as file:
        file.readline()
        while lines := file.readlines(PIECE):
            text = b",".join(lines).replace(b"\n", b"")
            try:
                values = np.fromstring(text, sep=",")
            except ValueError:
                return None
            if len(values) != count * len(lines):
                return None
            pieces.append(values.reshape(-1, count))
    return np.concatenate(pieces)


def _column(cells: list[str]) -> np.ndarray:
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells)


def _chaotic_speeds(path: Path) -> np.ndarray:
    if not path.is_file():
        return np.empty(0)
    columns = _columns(path)
    return columns["rpm"][np.isin(columns["label"], CHAOS)]


def _speeds(group: Group, columns: dict[str, np.ndarray]) -> None:
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


def _exact(group: Group, name: str, columns: dict[str, np.ndarray], rows: np.ndarray) -> None:
    """Count, bits and quantiles of some rows of a table of the kernel."""
    group[f"{name} rows"] = int(rows.sum())
    if not rows.any():
        return
    bits = sha256()
    for column in columns.values():
        mine = column[rows]
        bits.update(np.ascontiguousarray(mine, "<f8") if mine.dtype.kind == "f" else _join(mine))
    _quantiles(group, name, {k: v[rows] for k, v in columns.items() if k != "rpm"})
    group[f"{name} bits"] = bits.hexdigest()[:16]


def _join(texts: np.ndarray) -> bytes:
    return "\n".join(texts.tolist()).encode()


def _solved(group: Group, name: str, columns: dict[str, np.ndarray]) -> None:
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
            value = values[row]
            if column not in texts and column not in SKIPPED and not np.isnan(value):
                group[f"{key} {column}"] = float(value) if np.isfinite(value) else str(value)


def _quantiles(group: Group, name: str, columns: dict[str, np.ndarray]) -> None:
    for column, values in columns.items():
        if column in SKIPPED:
            continue
        if values.dtype.kind != "f" or column in WORDS:
            _counts(group, f"{name} {column}", values)
            continue
        known = np.sort(values[~np.isnan(values)])
        for level, share in LEVELS.items():
            if len(known):
                value = float(known[round(share * (len(known) - 1))])
                group[f"{name} {column} {level}"] = value if np.isfinite(value) else str(value)


def _counts(group: Group, name: str, values: np.ndarray) -> None:
    counts = Counter(_text(value) for value in values.tolist())
    for word, count in counts.most_common(MOST_WORDS):
        group[f"{name} = {word}"] = count
    if len(counts) > MOST_WORDS:
        group[f"{name} different"] = len(counts)


def _text(value: Any) -> str:
    if isinstance(value, float | np.floating):
        return f"{value:g}"
    return _short(str(value))


def _short(text: str) -> str:
    """The text; a long one by its beginning and a hash."""
    return text if len(text) <= 40 else f"{text[:28]}~{sha256(text.encode()).hexdigest()[:8]}"
