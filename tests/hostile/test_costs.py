"""What hostile scenes and lift tables cost: never more than a second and 200 MB, then a fault."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from math import cos, pi
from pathlib import Path

import pytest

from camcli.cams.lift_guess import guess
from camcli.errors import SceneError
from camcli.scene.load import MAX_BYTES
from tests.support.bounds import limited

ROOT = Path(__file__).parents[2]
TABLE = (ROOT / "configs" / "valve-lift.csv").read_text()
TABLE_SCENE = (ROOT / "configs" / "lift-table.yaml").read_text()
GIGABYTE = 2**30  # a file of it is sparse and takes no room

CHILD = """
import json, sys, time
from pathlib import Path
from camcli.errors import SceneError
from camcli.scene import load_scene
try:
    load_scene(Path("missing.yaml"))  # what has to be imported once
except SceneError:
    pass
for name in sys.argv[1:]:
    start, faults = time.process_time(), []
    try:
        load_scene(Path(name))
    except SceneError as error:
        faults = [str(fault) for fault in error.faults]
    seconds = time.process_time() - start
    status = Path("/proc/self/status").read_text().split()
    print(json.dumps([seconds, int(status[status.index("VmHWM:") + 1]) / 1024, faults]))
"""


def laughs(wide):
    """Each line holds the one before `wide` times."""
    lines = (f"a{i}: &a{i} [" + f"*a{i - 1}," * wide + "]" for i in range(1, 40))
    return "\n".join(["a0: &a0 [" + "x," * wide + "]", *lines])


SCENES = {  # text of the file, what its message says
    "laughs": (laughs(9), "more than 20000 values"),
    "laughs in pairs": (laughs(2), "more than 20000 values"),
    "itself": ("run: &r {start: *r}", "nested deeper than 32"),
    "brackets": ("[" * 100_000, "nested deeper than 32"),
    "braces": ("{a: " * 60_000, "nested deeper than 32"),
    "braces in lines": ("{a:\n " * 50_000, "nested deeper than 32"),
    "dashes": ("- " * 125_000, "nested deeper than 32"),
    "questions": ("? " * 125_000, "nested deeper than 32"),
    "staircase": ("\n".join(" " * i + "a:" for i in range(700)), "nested deeper than 32"),
    "flat": ("[" + "1," * 120_000 + "]", "more than 20000 values"),
    "unknown keys": ("\n".join(f"follower{i}: {i}" for i in range(9000)), "further faults"),
    "duplicate keys": ("a: 1\n" * 9000, "further faults"),
    "wrong items": ("sweep: {sections: [" + "x," * 19_000 + "]}", "further faults"),
    "same items": ("sweep: {sections: [" + "strobe," * 19_000 + "]}", "the same name twice"),
    "digits": ("run: {rpm: " + "1" * 250_000 + "}", "run.rpm: found 111"),
    "long text": ("run: {rpm: " + "x" * 250_000 + "}", "run.rpm: found 'xxx"),
    "long key": ("? " + "k" * 250_000 + "\n: 1", "unknown key 'kkk"),
    "escapes": ('a: "' + "\\x1b" * 60_000 + '"', "unknown key 'a'"),
    "unclosed quote": ("a: '" + "''" * 125_000, "a quote is not closed"),
    "documents": ("---\n" * 60_000, "a second document"),
    "comments": ("#\n" * 125_000, "found nothing"),
    "gigabyte": (GIGABYTE, "found more than 256 kB"),
}
HEAD = "crank_deg,lift_inch\n"
FINE = [f"{k / 50:.2f},{0.2 * (1 - cos(k * pi / 18_000)):.5f}\n" for k in range(36_000)]
TABLES = {  # the same of the lift table a scene names
    "gigabyte": (GIGABYTE, "found more than 10 MB"),
    "empty": ("", "found nothing, expected rows"),
    "only lines": ("\n" * 9_000_000, "found 9000000 lines, expected at most 80000"),
    "short rows": (HEAD + "1,2\n" * 2_400_000, "found 2400001 lines, expected at most"),
    "huge line": (HEAD + "1," * 4_900_000, ".csv:2:1: cam.file: found a line of 9800000"),
    "huge header": ("a," * 4_900_000 + "\n1,2\n", ".csv:1:1: cam.file: found a line of"),
    "huge cell": (HEAD + "1," + "9" * 9_000, "found '9999999"),
    "no numbers": (HEAD + "x,y\n" * 39_000, "found 'x'"),
    "falling": (
        HEAD + "".join(f"{-k % 7},0\n" for k in range(39_000)),
        "expected angles that only rise or only fall",
    ),
    "too wide": (HEAD + "".join(f"{k},{k % 9 / 9:.4f}\n" for k in range(39_000)), "too much"),
    "spike": (HEAD + "".join(FINE[:18_000]) + "360.00,0.5\n" + "".join(FINE[18_001:]), "a spike"),
    "control": (TABLE.replace("-100,", "-100\x1b,"), "control character 0x1b"),
}


def write(path: Path, text: str | int) -> None:
    """Write a text, or a sparse file of this size."""
    if isinstance(text, int):
        with open(path, "wb") as file:
            os.truncate(file.fileno(), text)
    else:
        path.write_text(text)


def costs(paths: list[Path]) -> list[tuple[float, float, list[str]]]:
    """(seconds of the processor, MB of the process so far, faults) of loading each scene."""
    command = [sys.executable, "-c", CHILD, *map(str, paths)]
    run = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=True)
    return [json.loads(line) for line in run.stdout.splitlines()]


@pytest.mark.ci
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory is read from /proc")
@pytest.mark.parametrize("which", ["scenes", pytest.param("tables", marks=pytest.mark.slow)])
def test_hostile_files_cost_little_and_are_refused(tmp_path, which):
    cases, paths = SCENES if which == "scenes" else TABLES, []
    for number, (text, _) in enumerate(cases.values()):
        path = tmp_path / f"{number}.yaml"
        if which == "scenes":
            assert isinstance(text, int) or len(text) <= MAX_BYTES  # or its size would hide it
            write(path, text)
        else:
            write(tmp_path / f"{number}.csv", text)
            path.write_text(TABLE_SCENE.replace("valve-lift.csv", f"{number}.csv"))
        paths.append(path)
    for (name, (_, words)), cost in zip(cases.items(), costs(paths), strict=True):
        seconds, megabytes, faults = cost
        assert seconds < 1, name
        assert megabytes < 200, name
        assert any(words in fault for fault in faults), (name, faults)
        assert all(len(fault) < 800 and fault.isprintable() for fault in faults), name


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.parametrize("name", [*TABLES, "more rows than are read"])
def test_looking_at_a_table_costs_little(name):
    """In seconds of the processor; a time that grows with the square of the rows takes ten."""
    text = TABLES.get(name, (HEAD + 2 * "".join(FINE), ""))[0]
    if not isinstance(text, int):
        with limited(6.0), suppress(SceneError):
            guess(text.encode(), "lift.csv")
