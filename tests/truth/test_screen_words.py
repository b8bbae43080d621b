"""The words on the screen of every command, against a sheet: what is said, not the numbers in it.

Numbers are held elsewhere against values computed another way, and stand as # here. The sheet
`tests/truth/screens.toml` has each line that a command prints, in its order. Whoever changes a word
reads it there: `CAMCLI_LOOKS=1 CAMCLI_NO_SKIPS=1 pytest -n 0 tests/truth/test_screen_words.py`
writes the sheet anew.
"""

from __future__ import annotations

import os
import re
import tomllib
from itertools import groupby
from pathlib import Path

import pytest

pytestmark = pytest.mark.ci
SHEET = Path(__file__).parent / "screens.toml"
CONFIGS = Path(__file__).parents[2] / "configs"
SHORT = "--set run.transient=60 --set run.record=20"
TABLE = f"-c {CONFIGS / 'lift-table.yaml'}"
LINES = {
    "simulate": f"simulate --rpm 190 {SHORT}",
    "simulate the cam": "simulate --profile-only",
    "simulate a table": f"simulate {TABLE} {SHORT}",
    "sweep": f"sweep --rpm 662:670 --points 3 {SHORT}",
    "sweep a map": "sweep --vary rpm=660:760 --vary follower.restitution=0.5:0.9 --points 3,2 "
                   + SHORT,
    "detach": "detach --rpm 110:130 --points 5 --hold-to 300",
    "detach a table": f"detach {TABLE} --points 5 --hold-to 4000 --tolerance follower.mass=5% "
                      "--set detach.machines=3",
    "orbits": "orbits --rpm 665:690 --points 11",
    "orbits proved": "orbits --rpm 700 --prove",
    "classify": "classify --rpm 700:704 --points 2",
    "basins": "basins --rpm 358.5 --set basins.cells=[8,8]",
}  # fmt: skip
NUMBER = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+)?")


def words_of(text: str, folder: Path) -> list[str]:
    """The lines of a screen without numbers, folders, rules and the width of columns."""
    plain = text.replace(f"{CONFIGS}/", "").replace(f"{folder}/", "")
    plain = re.sub(r"[─━┄-]{2,}", "--", NUMBER.sub("#", plain))
    lines = [" ".join(line.split()) for line in plain.splitlines()]
    kept = [line for line in lines if line and "kernel" not in line]
    return [line for line, _ in groupby(kept)]  # rows of a table that differ in numbers alone


@pytest.mark.parametrize("name", LINES)
def test_the_words_on_the_screen_are_those_of_the_sheet(cam, tmp_path, name):
    done = cam(f"{LINES[name]} --no-plot -o out")
    assert done.returncode in (0, 3), done.stderr
    found = words_of(done.stdout, tmp_path) + words_of(done.stderr, tmp_path)
    sheet = {}
    if SHEET.exists():
        sheet = tomllib.loads(SHEET.read_text(encoding="utf-8"))
    if "CAMCLI_LOOKS" in os.environ:
        sheet[name] = found
        SHEET.write_text(written(sheet), encoding="utf-8")
    assert found == sheet[name]


def written(sheet: dict[str, list[str]]) -> str:
    parts = ["# What commands print, numbers as #; see tests/truth/test_screen_words.py.\n"]
    for name, lines in sheet.items():
        rows = "".join(
            '  "{}",\n'.format(line.replace("\\", "\\\\").replace('"', '\\"')) for line in lines
        )
        parts.append(f'"{name}" = [\n{rows}]\n')
    return "\n".join(parts)
