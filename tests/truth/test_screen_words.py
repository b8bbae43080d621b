"""What every command shows and says, against a sheet: its words, the digits of its numbers, pieces.

Numbers are held elsewhere against values computed another way. Here each digit is a 0, so that a
number shows how many digits it is printed with; in times, which are others in each run, a number is
a #. The sheet `tests/truth/screens.toml` has each line that a command prints, in its order, and the
names of the pieces into which the run is divided: of these a user reads where one fails. Whoever
changes a word reads it there: `CAMCLI_LOOKS=1 CAMCLI_NO_SKIPS=1 pytest -n 0
tests/truth/test_screen_words.py` writes the sheet anew.
"""

from __future__ import annotations

import os
import re
import tomllib
from importlib import import_module
from itertools import groupby
from math import pi, sin
from pathlib import Path

import pytest

from camcli import piece_faults

SHEET = Path(__file__).parent / "screens.toml"
PACKAGE = Path(piece_faults.__file__).parent
CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = "--set run.transient=60 --set run.record=20"
TABLE = f"-c {CONFIGS / 'lift-table.yaml'}"
LASH = f"-c {CONFIGS / 'valve-lash.yaml'}"
ROLLER = (
    f"-c {CONFIGS / 'valve-train.yaml'} "
    "--set 'contact={face: roller, follower_radius: 0.01, base_radius: 0.018}'"
)
FLAT = f"-c {CONFIGS / 'law-smooth.yaml'} --set 'contact={{face: flat, base_radius: 0.02}}'"
FIGURES = "figures --folder scenes -o out"
LINES = {  # the commands of an entry, in their order
    "simulate": [f"simulate --rpm 190 {SHORT} --no-plot -o out"],
    "simulate the cam": ["simulate --profile-only --no-plot -o out"],
    "simulate a lobe": [
        f"simulate --profile-only {ROLLER} --no-plot -o out",
        f"simulate --profile-only {FLAT} --no-plot -o flat",
    ],
    "simulate a table": [f"simulate {TABLE} {SHORT} --no-plot -o out"],
    "simulate a lash": [f"simulate {LASH} {SHORT} --no-plot -o out"],
    "sweep": [f"sweep --rpm 662:670 --points 3 {SHORT} --no-plot -o out"],
    "sweep a map": [
        f"sweep --vary rpm=660:760 --vary follower.restitution=0.5:0.9 --points 3,2 {SHORT} "
        "--no-plot -o out"
    ],
    "detach": ["detach --rpm 110:130 --points 5 --hold-to 300 --no-plot -o out"],
    "detach a table": [
        f"detach {TABLE} --points 5 --hold-to 4000 --tolerance follower.mass=5% "
        "--set detach.machines=3 --verbose --no-plot -o out"
    ],
    "detach proved": ["detach --rpm 110:130 --points 2 --prove --verbose --no-plot -o out"],
    "orbits": ["orbits --rpm 665:690 --points 11 --verbose --no-plot -o out"],
    "orbits proved": ["orbits --rpm 700 --prove --no-plot -o out"],
    "orbits of a label": [
        "orbits --rpm 700 --label P(2;1:1) --set orbits.starts=2 --no-plot -o out"
    ],
    "orbits over a number": [
        "orbits --vary follower.restitution=0.8:0.82 --points 3 --set orbits.starts=2 --no-plot "
        "-o out"
    ],
    "classify": ["classify --rpm 700:704 --points 2 --verbose --no-plot -o out"],
    "classify a map of lines": ["classify --trace=1.64,1.36 --det=0.64,0.63 -o out"],
    "basins": ["basins --rpm 358.5 --set basins.cells=[8,8] --verbose --no-plot -o out"],
    "explore": [f"explore --rpm 690:700 --points 2 --set orbits.starts=1 {SHORT} -o out"],
    "rerun": [
        f"simulate --rpm 700 {SHORT} --no-plot -o first -q", "rerun first/run.json",
        "rerun first -o again",
    ],
    "merge": [
        f"sweep --rpm 700:702 --points 2 {SHORT} --no-plot --shard 1/2 -o parts", "merge parts",
        f"sweep --rpm 700:702 --points 2 {SHORT} --no-plot --shard 2/2 -o parts", "merge parts",
    ],
    "a plan": [f"sweep --rpm 690:700 --points 3 {SHORT} --dry-run"],
    "figures": [
        f"{FIGURES} --dry-run", FIGURES, f"{FIGURES} --check", f"{FIGURES} --update-reference",
        FIGURES, f"{FIGURES} --check", f"{FIGURES} none",
    ],
    "init": [
        "init lift.csv", "init lift.csv", "init lift.csv --force", "init -o new", "init -o new",
    ],
    "guide": ["guide"],
}  # fmt: skip
DEAR = (
    "simulate a table", "sweep", "detach", "detach a table", "detach proved", "orbits of a label",
    "basins", "explore", "figures", "init",
)  # fmt: skip
FILES = {
    "scenes/1.2.yaml": (CONFIGS / "eccentric.yaml").read_text().partition("figure:")[0]
    + "\nfigure: {title: An eccentric, command: simulate}\nsimulate: {profile_only: true}\n",
    "lift.csv": "deg,mm\n"
    + "".join(
        f"{k},{5.0 * sin(pi * max(0, min(k - 90, 180)) / 180) ** 4:.3f}\n" for k in range(360)
    ),
}
NUMBER = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+)?")
OF_ANY_TIME = re.compile(
    r"impacts in |this run took | [GM]B$|^seconds |computed in | An eccentric |(new|check), "
)


def line_in_shape(line: str) -> str:
    """A line without the values of its numbers."""
    if OF_ANY_TIME.search(line):
        return NUMBER.sub("#", line)
    return NUMBER.sub(lambda number: re.sub(r"\d", "0", number[0]), line)


def words_of(text: str, folder: Path) -> list[str]:
    """The lines of a screen without values, folders, rules and the width of columns."""
    plain = text.replace(f"{CONFIGS}/", "").replace(f"{folder}/", "")
    plain = re.sub(r"[─━┄-]{2,}", "--", plain)
    lines = [line_in_shape(" ".join(line.split())) for line in plain.splitlines()]
    kept = [line for line in lines if line and "kernel" not in line]
    return [line for line, _ in groupby(kept)]  # rows of a table that differ in values alone


@pytest.fixture
def pieces(monkeypatch):
    """The names of all pieces that a run tries, in their order; those of threads are left out.

    Modules that use `attempt` itself are imported before, so that they keep the real one.
    """
    names: list[str] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        if "attempt" in path.read_text(encoding="utf-8") and path.name != "piece_faults.py":
            import_module(".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts))
    attempt = piece_faults.attempt

    def noted(name, call):
        names.append(name)
        return attempt(name, call)

    monkeypatch.setattr(piece_faults, "attempt", noted)
    return names


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.ci] * (name in DEAR)) for name in LINES]
)
def test_the_words_on_the_screen_are_those_of_the_sheet(cam, tmp_path, pieces, name):
    for place, text in FILES.items():
        (tmp_path / place).parent.mkdir(exist_ok=True)
        (tmp_path / place).write_text(text)
    found = []
    for line in LINES[name]:
        done = cam(line)
        found += words_of(done.stdout, tmp_path) + words_of(done.stderr, tmp_path)
        found.append(f"exit code {done.returncode}")
    found += dict.fromkeys(f"piece: {line_in_shape(piece)}" for piece in pieces)
    sheet = {}
    if SHEET.exists():
        sheet = tomllib.loads(SHEET.read_text(encoding="utf-8"))
    if "CAMCLI_LOOKS" in os.environ:
        sheet[name] = found
        SHEET.write_text(written(sheet), encoding="utf-8")
    assert found == sheet[name]


def written(sheet: dict[str, list[str]]) -> str:
    parts = ["# What commands print, digits as 0; see tests/truth/test_screen_words.py.\n"]
    for name in (name for name in LINES if name in sheet):
        rows = "".join(
            '  "{}",\n'.format(line.replace("\\", "\\\\").replace('"', '\\"'))
            for line in sheet[name]
        )
        parts.append(f'"{name}" = [\n{rows}]\n')
    return "\n".join(parts)
