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
from itertools import groupby
from pathlib import Path

import pytest

from camcli import piece_faults

pytestmark = pytest.mark.ci
SHEET = Path(__file__).parent / "screens.toml"
CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = "--set run.transient=60 --set run.record=20"
TABLE = f"-c {CONFIGS / 'lift-table.yaml'}"
LASH = f"-c {CONFIGS / 'valve-lash.yaml'}"
LINES = {  # several commands where an earlier one leaves what the last one reads
    "simulate": [f"simulate --rpm 190 {SHORT}"],
    "simulate the cam": ["simulate --profile-only"],
    "simulate a table": [f"simulate {TABLE} {SHORT}"],
    "simulate a lash": [f"simulate {LASH} {SHORT}"],
    "sweep": [f"sweep --rpm 662:670 --points 3 {SHORT}"],
    "sweep a map": [
        f"sweep --vary rpm=660:760 --vary follower.restitution=0.5:0.9 --points 3,2 {SHORT}"
    ],
    "detach": ["detach --rpm 110:130 --points 5 --hold-to 300"],
    "detach a table": [
        f"detach {TABLE} --points 5 --hold-to 4000 --tolerance follower.mass=5% "
        "--set detach.machines=3 --verbose"
    ],
    "detach proved": ["detach --rpm 110:130 --points 2 --prove --verbose"],
    "orbits": ["orbits --rpm 665:690 --points 11 --verbose"],
    "orbits proved": ["orbits --rpm 700 --prove"],
    "orbits of a label": ["orbits --rpm 700 --label P(2;1:1) --set orbits.starts=2"],
    "orbits over a number": [
        "orbits --vary follower.restitution=0.8:0.82 --points 3 --set orbits.starts=2"
    ],
    "classify": ["classify --rpm 700:704 --points 2 --verbose"],
    "classify a map of lines": ["classify --trace=1.64,1.36 --det=0.64,0.63"],
    "basins": ["basins --rpm 358.5 --set basins.cells=[8,8] --verbose"],
    "explore": [f"explore --rpm 690:700 --points 2 --set orbits.starts=1 {SHORT} -o out"],
    "rerun": [
        f"simulate --rpm 700 {SHORT} --no-plot -o first", "rerun first/run.json",
    ],
    "merge": [
        f"sweep --rpm 700:702 --points 2 {SHORT} --no-plot --shard 1/1 -o parts", "merge parts",
    ],
    "a plan": [f"sweep --rpm 690:700 --points 3 {SHORT} --dry-run"],
}  # fmt: skip
AS_THEY_STAND = ("explore", "rerun", "a plan")
NUMBER = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+)?")
OF_ANY_TIME = re.compile(r"impacts in |this run took | GB| MB|^seconds ")


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
    """The names of all pieces that a run tries, in their order; those of threads are left out."""
    names: list[str] = []
    attempt = piece_faults.attempt

    def noted(name, call):
        names.append(name)
        return attempt(name, call)

    monkeypatch.setattr(piece_faults, "attempt", noted)
    return names


@pytest.mark.parametrize("name", LINES)
def test_the_words_on_the_screen_are_those_of_the_sheet(cam, tmp_path, pieces, name):
    *before, line = LINES[name]
    for earlier in before:
        cam(earlier, code=0)
    pieces.clear()
    done = cam(line if name in AS_THEY_STAND else f"{line} --no-plot -o out")
    assert done.returncode in (0, 3), done.stderr
    found = words_of(done.stdout, tmp_path) + words_of(done.stderr, tmp_path)
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
