"""Digest of a run: few numbers that change when anything of note in its tables does.

Three groups, each a flat map from a name to a number or a short text:
regular  tables straight from the kernel, of motions that repeat: exact
chaotic  the same of motions that do not: exact, and the most sensitive to a single bit
solved   everything else, where equations were solved: to TOLERANCE of a value
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from hashlib import sha256
from string import ascii_lowercase
from typing import Any

import numpy as np

from camcli.output.tables import Table

REGULAR, CHAOTIC, SOLVED = "regular", "chaotic", "solved"
TOLERANCE = 1e-8  # of a solved number
SLIGHT = 1e-9  # of a simulated number: a difference of rounding, not of the machine
ABSOLUTE = 1e-12
KERNEL = ("impacts.csv", "strobe.csv", "trajectory.csv", "events.csv")
CHAOS = ("aperiodic", "undecided")
WORDS = ("attractor", "branch", "stable", "chatter", "impact", "period")  # numbers that name
SKIPPED = ("rpm_error", "rpm_low", "rpm_high", "standard_error", "period",
           "lyapunov_error_per_period", "turns_round", "stable_from", "stable_to")  # fmt: skip
LEVELS = {"least": 0.0, "q05": 0.05, "q25": 0.25, "median": 0.5, "q75": 0.75, "q95": 0.95,
          "largest": 1.0}  # fmt: skip
MOST_ROWS = 40  # of a table that is kept whole
MOST_WORDS = 24  # different texts of a column that are counted one by one

Group = dict[str, Any]
Columns = dict[str, np.ndarray]  # doubles, or texts where a cell is none
Named = Iterator[tuple[str, Any]]  # (name, number or short text)


def digest(tables_of_run: Mapping[str, Table], result: Any) -> dict[str, Group]:
    """The digest of the tables of a run, whose names have no ending, and of its summary.

    result: the entry of run.json, None where there is none.
    """
    groups: dict[str, Group] = {REGULAR: {}, CHAOTIC: {}, SOLVED: {}}
    label = result.get("label", "") if isinstance(result, dict) else ""
    tables = {f"{name}.csv": _columns(tables_of_run[name]) for name in sorted(tables_of_run)}
    speeds = tables.get("speeds.csv", {"rpm": np.empty(0), "label": np.empty(0)})
    chaotic_speeds = speeds["rpm"][np.isin(speeds["label"], CHAOS)]
    for name, columns in tables.items():
        if name == "speeds.csv":
            groups[REGULAR] |= _speeds(columns)
        elif name not in KERNEL:
            groups[SOLVED] |= _solved(name, columns)
        elif "rpm" in columns:
            is_chaotic = np.isin(columns["rpm"], chaotic_speeds)
            groups[CHAOTIC] |= _exact(name, columns, is_chaotic)
            groups[REGULAR] |= _exact(name, columns, ~is_chaotic)
        else:  # of a single motion
            all_rows = np.ones(len(next(iter(columns.values()))), bool)
            groups[CHAOTIC if label in CHAOS else REGULAR] |= _exact(name, columns, all_rows)
    known = result if isinstance(result, dict) else {}
    groups[REGULAR] |= {k: known[k] for k in ("label", "rpm", "periods") if k in known}
    if len(tables.get("events.csv", {}).get("event", ())):
        groups[SOLVED] |= _events(tables["events.csv"], known)
    chaos = known.get("chaos")
    if chaos and chaos["proved"]:
        groups[SOLVED]["entropy per turn"] = chaos["entropy_per_turn"]
    return groups


def _columns(table: Table) -> Columns:
    """The columns of a table by name: doubles, or texts where a cell is no number."""
    return {name: _doubles(column) for name, column in table.arrays().items()}


def _doubles(column: np.ndarray) -> np.ndarray:
    """Numbers as doubles, also where they are written as texts; an empty text is no number."""
    if column.dtype.kind != "U":
        return column.astype(float)
    try:
        return np.array([float(cell) if cell else np.nan for cell in column.tolist()])
    except ValueError:
        return column


def _events(columns: Columns, result: Mapping[str, Any]) -> Named:
    """How often each event occurs in a turn; the phases of the rests, and corners at them.

    columns: of events.csv; result: the entry of run.json of `simulate`.
    """
    corners_deg = dict(zip(ascii_lowercase, result["corners_deg"], strict=False))
    for kind in sorted(set(columns["event"].tolist())):
        phases = columns["theta_deg"][columns["event"] == kind]
        yield f"{kind}s a turn", round(len(phases) / result["periods"], 6)
        always_one_phase = len({f"{phase:.6f}" for phase in phases}) == 1
        if always_one_phase:
            yield f"{kind} deg", float(phases[0])
            for name, corner in corners_deg.items():
                if abs(corner - phases[0]) < 1e-6:
                    yield f"{kind} corner", name


def _speeds(columns: Columns) -> Named:
    """How often each label occurs, and between which speeds."""
    labels = columns["label"]
    rpm = columns["rpm"]
    yield from _counts("speeds.csv status", columns["status"])
    counts = Counter(labels.tolist())
    yield "speeds.csv different labels", len(counts)
    for label, count in counts.most_common(MOST_WORDS):
        with_label = rpm[labels == label]
        name = f"speeds.csv {_short(label)}"
        yield f"{name} speeds", count
        yield f"{name} from rpm", float(with_label.min())
        yield f"{name} to rpm", float(with_label.max())


def _exact(name: str, columns: Columns, chosen: np.ndarray) -> Named:
    """Count, quantiles and bits of some rows of a table of the kernel; chosen: a bool for a row."""
    yield f"{name} rows", int(chosen.sum())
    if not chosen.any():
        return
    bits = sha256()
    for column in columns.values():
        cells = column[chosen]
        if cells.dtype.kind == "f":
            bits.update(cells.astype("<f8").tobytes())
        else:
            bits.update("\n".join(cells.tolist()).encode())
    not_speeds = {column: cells[chosen] for column, cells in columns.items() if column != "rpm"}
    yield from _quantiles(name, not_speeds)
    yield f"{name} bits", bits.hexdigest()[:16]


def _solved(name: str, columns: Columns) -> Named:
    """A small table cell by cell, a large one by quantiles.

    A cell is named by the table, the words of its row and its column; rows of the same words are
    counted: `branch.csv 1 P(1;1) #2 rpm`.
    """
    count = len(next(iter(columns.values())))
    yield f"{name} rows", count
    if count > MOST_ROWS:
        yield from _quantiles(name, columns)
        return
    wordy = [k for k, cells in columns.items() if cells.dtype.kind != "f" or k in WORDS]
    numbers = [k for k in columns if k not in wordy and k not in SKIPPED]
    rows_with_words: Counter[str] = Counter()
    for row in range(count):
        words = " ".join(filter(None, (_text(columns[column][row]) for column in wordy)))
        rows_with_words[words] += 1
        nth = rows_with_words[words]
        row_name = f"{name} {words} #{nth}" if nth > 1 else f"{name} {words}"
        for column in numbers:
            number = columns[column][row]
            if not np.isnan(number):
                yield f"{row_name} {column}", _number(number)


def _quantiles(name: str, columns: Columns) -> Named:
    """The LEVELS of each column of numbers, and how often each text of the others occurs."""
    for column, values in columns.items():
        if column in SKIPPED:
            continue
        if values.dtype.kind != "f" or column in WORDS:
            yield from _counts(f"{name} {column}", values)
            continue
        known = np.sort(values[~np.isnan(values)])
        if not len(known):
            continue
        for level, share in LEVELS.items():
            yield f"{name} {column} {level}", _number(known[round(share * (len(known) - 1))])


def _counts(name: str, values: np.ndarray) -> Named:
    """How often each of the MOST_WORDS commonest values occurs, and of how many there are."""
    counts = Counter(_text(value) for value in values.tolist())
    for word, count in counts.most_common(MOST_WORDS):
        yield f"{name} = {word}", count
    if len(counts) > MOST_WORDS:
        yield f"{name} different", len(counts)


def _number(value: np.floating) -> float | str:
    """A number in the form that JSON knows: an infinity is a text."""
    return float(value) if np.isfinite(value) else str(value)


def _text(value: Any) -> str:
    """A value as a word of a name."""
    return f"{value:g}" if isinstance(value, float | np.floating) else _short(str(value))


def _short(text: str) -> str:
    """The text; a long one by its beginning and a hash."""
    return text if len(text) <= 40 else f"{text[:28]}~{sha256(text.encode()).hexdigest()[:8]}"


# --- captions


def caption(text: str, values: Mapping[str, Any]) -> str:
    """A caption with its numbers: `{name|.2f}` is the value of this name in a digest.

    Raises KeyError where the run has no such value.
    """

    def value(match: re.Match[str]) -> str:
        """The number that the name in braces stands for, in its format."""
        name, _, form = match[1].partition("|")
        number = values[name.strip()]
        return f"{number:{form or '.10g'}}" if isinstance(number, float) else str(number)

    with_numbers = re.sub(r"\{([^{}]+)\}", value, text)
    return re.sub(r"\binf\b", "∞", with_numbers)


# --- comparison


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


def drifts(figure: str, old: Mapping[str, Group], new: Mapping[str, Group]) -> Iterator[Drift]:
    """Every number of a digest that differs from the reference.

    A solved number may differ by TOLERANCE.
    """
    for group in (REGULAR, CHAOTIC, SOLVED):
        for name in dict.fromkeys([*old[group], *new[group]]):
            was = old[group].get(name)
            now = new[group].get(name)
            if was == now:
                continue
            by = None
            slight = False
            if isinstance(was, int | float) and isinstance(now, int | float):
                by = now - was
                size = max(abs(was), abs(now))
                if group == SOLVED and abs(by) <= ABSOLUTE + TOLERANCE * size:
                    continue
                slight = abs(by) <= SLIGHT * size
            last_bits = group == REGULAR and (slight or name.endswith(" bits"))
            yield Drift(
                figure=figure,
                group=group,
                name=name,
                reference=was,
                found=now,
                by=by,
                portability=group == CHAOTIC or last_bits,
            )
