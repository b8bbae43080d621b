"""What a scene does not need costs nothing: time and modules of whole commands.

Each is a process of its own. `seconds` is the wall time of the process, `modules` how many modules
it had imported at its end, `heavy` the large libraries among them.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

HEAVY = ("matplotlib", "numba", "numpy", "pydantic", "rich", "scipy", "yaml")
PROBE = """
import json, os, sys
import camcli.cli.panel as panel
from camcli.cli.app import app
code = panel.guarded(lambda: app({words!r}, standalone_mode=False))
sys.stdout.flush()
path = os.path.join({words!r}[-1], "run.json")
spent = None
if os.path.exists(path):
    with open(path) as file:
        spent = json.load(file)["cost"]["seconds"]
heavy = [name for name in {heavy!r} if name in sys.modules]
print(json.dumps([code, len(sys.modules), heavy, spent]), file=sys.stderr)
"""
SHORT = ("--set", "run.transient=10", "--set", "run.record=5")
DAMPED = ("--set", "follower.damping=20")
RANGE = ("sweep", "--rpm", "660:760", "--points", "101")
BARE = ("--no-plot",)
STROBE = ("--set", "sweep.sections=[strobe]")

SCENES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("cam --help", ("--help",)),
    ("simulate, contact", ("simulate", "--rpm", "100", *SHORT, *BARE)),
    ("simulate, impacts", ("simulate", "--rpm", "700", *SHORT, *BARE)),
    ("simulate, chatter", ("simulate", "--rpm", "190", *SHORT, *BARE)),
    ("simulate, damping", ("simulate", "--rpm", "700", *DAMPED, *SHORT, *BARE)),
    ("simulate, picture", ("simulate", "--rpm", "700", *SHORT)),
    ("sweep, no log", (*RANGE, *STROBE, *BARE)),
    ("sweep, log", (*RANGE, *BARE)),
    ("sweep, log, damping", (*RANGE, *DAMPED, *BARE)),
    ("sweep, log, picture", RANGE),
    ("sweep, exponents", (*RANGE, "--set", "sweep.lyapunov=true", *BARE)),
    ("detach", ("detach", "--points", "31", *BARE)),
    ("orbits", ("orbits", "--rpm", "700", *BARE)),
    ("classify, exponents", ("classify", "--rpm", "700", *BARE)),
    ("basins", ("basins", "--cells", "24", *BARE)),
    ("basins, picture", ("basins", "--cells", "24")),
)  # fmt: skip
QUICK = ("cam --help", "simulate, contact", "simulate, chatter", "simulate, picture", "sweep, log")


@dataclass(frozen=True)
class Scene:
    """A command that has been run: medians of wall time, and what it imported."""

    name: str
    words: tuple[str, ...]
    code: int
    seconds: float
    compute_s: float | None  # as its own run.json says
    modules: int
    heavy: tuple[str, ...]


def scenes(
    repeats: int, quick: bool, on_scene: Callable[[], None] = lambda: None
) -> Iterator[Scene]:
    """Run every command; `on_scene` is called after each."""
    for name, words in SCENES:
        if not quick or name in QUICK:
            yield _measured(name, words, repeats)
            on_scene()


def ratios(found: Sequence[Scene]) -> list[float]:
    """Times over that of the cheapest."""
    least = min(scene.seconds for scene in found)
    return [scene.seconds / least for scene in found]


def _measured(name: str, words: tuple[str, ...], repeats: int) -> Scene:
    runs = [_run(words) for _ in range(max(1, repeats))]
    seconds, (code, modules, heavy, spent) = median(time for time, _ in runs), runs[-1][1]
    return Scene(name, words, code, seconds, spent, modules, tuple(heavy))


def _run(words: tuple[str, ...]) -> tuple[float, tuple]:
    """(seconds, what the probe says) of one process in an empty folder."""
    import json

    with TemporaryDirectory(prefix="cam-bench-") as folder:
        given = words if "--help" in words else (*words, "-q", "-o", "out")
        began = perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", PROBE.format(words=list(given), heavy=list(HEAVY))],
            cwd=folder,
            env={**os.environ, "NO_COLOR": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        seconds = perf_counter() - began
    try:
        said = json.loads(done.stderr.splitlines()[-1])
    except (IndexError, ValueError):
        said = [done.returncode or 1, 0, [], None]
    return seconds, tuple(said)
