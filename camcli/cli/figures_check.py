"""Comparison of figures with the reference digests stored beside their scenes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from camcli.cli.figures_plan import Figure, state_of
from camcli.errors import Fault, SceneError
from camcli.output.digest import CHAOTIC, REGULAR, SOLVED, digest
from camcli.output.run_folder import run_folder

FOLDER = "reference"
TOLERANCE = 1e-8  # of a solved number
SLIGHT = 1e-9  # of a simulated number: a difference of rounding, not of the machine
ABSOLUTE = 1e-12
PORTABILITY = "portability broke"
REST = 12  # drifts of a figure shown to people


@dataclass(frozen=True)
class Drift:
    """A number that is not the reference's. `by` is None where they cannot be subtracted."""

    figure: str
    group: str
    name: str
    reference: Any
    found: Any
    by: float | None
    portability: bool

    def __str__(self) -> str:
        where = f"{self.figure}: {self.name}" + (" (chaotic)" if self.group == CHAOTIC else "")
        text = f"{where}: reference {_plain(self.reference)}, found {_plain(self.found)}"
        if self.by is not None:
            text += f", off by {self.by:.6g}"
            if self.reference:
                text += f" ({abs(self.by / self.reference):.2g} of it)"
        return text + (f": {PORTABILITY}" if self.portability else "")


def reference_path(figure: Figure) -> Path:
    """Where the figure's reference is kept."""
    return figure.path.parent / FOLDER / f"{figure.name}.json"


def update(figures: Sequence[Figure], known: Sequence[Figure], out: Path) -> int:
    """Write the references of these figures; remove those of no known one; their total size."""
    folder = figures[0].path.parent / FOLDER
    with run_folder(folder) as store:
        for figure in figures:
            groups = digest(out / figure.name)
            seconds = round((state_of(out / figure.name) or {}).get("seconds", 0.0), 1)
            hashes = {key: figure.hashes[key] for key in ("scene", "data")}
            text = {**hashes, "seconds": seconds, **groups}
            store.write_text(f"{figure.name}.json", [json.dumps(text, indent=0) + "\n"])
        store.commit()
        for path in folder.glob("*.json"):
            if path.stem not in {figure.name for figure in known}:
                path.unlink()
        return sum(path.stat().st_size for path in folder.glob("*.json"))


def check(figure: Figure, out: Path) -> list[Drift]:
    """All numbers of a figure that are not the reference's."""
    path = reference_path(figure)
    try:
        reference = json.loads(path.read_text())
        groups = {group: dict(reference[group]) for group in (REGULAR, CHAOTIC, SOLVED)}
    except FileNotFoundError:
        return [Drift(figure.name, SOLVED, str(path), None, "no such file", None, False)]
    except (OSError, ValueError, KeyError, TypeError) as error:
        found = f"cannot be read ({type(error).__name__}: {error})"
        cure = "restore it, or cam figures --update-reference"
        expected = "expected a digest written by --update-reference"
        raise SceneError(Fault(str(path), "", found, expected, cure)) from None
    drifts = []
    for key in ("scene", "data"):
        if reference.get(key) != figure.hashes[key]:
            was, now = str(reference.get(key))[:12], figure.hashes[key][:12]
            drifts.append(Drift(figure.name, REGULAR, f"hash of the {key}", was, now, None, False))
    same = not drifts
    found = digest(out / figure.name)
    for group, old in groups.items():
        drifts += _compare(figure.name, group, old, found[group], same)
    return drifts


def _compare(figure: str, group: str, old: dict, new: dict, same_scene: bool) -> list[Drift]:
    drifts = []
    for name in [*old, *(name for name in new if name not in old)]:
        was, now = old.get(name), new.get(name)
        by = now - was if _number(was) and _number(now) else None
        allowed = 0.0
        if by is not None and group == SOLVED:
            allowed = ABSOLUTE + TOLERANCE * max(abs(was), abs(now))
        if was == now or (by is not None and abs(by) <= allowed):
            continue
        slight = by is not None and abs(by) <= SLIGHT * max(abs(was), abs(now))
        bits = name.endswith(" bits")
        portability = same_scene and (group == CHAOTIC or (group == REGULAR and (slight or bits)))
        drifts.append(Drift(figure, group, name, was, now, by, portability))
    return drifts


def verdict(drifts: Sequence[Drift]) -> str:
    """One line on what the drifts mean together."""
    if not drifts:
        return "every number is the reference's"
    figures = len({drift.figure for drift in drifts})
    words = f"{len(drifts)} numbers drifted in {figures} figure" + ("s" if figures > 1 else "")
    broken = sum(drift.portability for drift in drifts)
    if broken == len(drifts):
        words += f": {PORTABILITY}: only chaotic motions and last bits differ"
    elif broken:
        words += f", {broken} of them where bits should agree on every machine ({PORTABILITY})"
    return words


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _plain(value: Any) -> str:
    return "nothing" if value is None else repr(value) if isinstance(value, float) else str(value)
