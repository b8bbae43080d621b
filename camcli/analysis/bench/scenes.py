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
from functools import partial
from math import nan
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from camcli.analysis.bench.clock import NOT_REACHED, Clock
from camcli.analysis.bench.kept import codec_of, one_by_one
from camcli.parallel import Work

OK, FAILED = "ok", "failed"
LONGEST = 60.0  # s, beyond which a command is stopped and has failed
STOPPED = 124  # its exit code then
GRACE = 3.0  # s that a command begun in time may take beyond the end
HEAVY = ("matplotlib", "numba", "numpy", "pydantic", "rich", "scipy", "yaml")
PROBE = """
import json, os, sys
import camcli.cli.exit_codes as panel
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
class Task:
    """A command to run, in plain values; `left` counts the commands from this one on."""

    name: str
    words: tuple[str, ...]
    repeats: int
    left: int


@dataclass(frozen=True)
class Scene:
    """A command that has been run: medians of wall time, and what it imported."""

    name: str
    words: tuple[str, ...]
    status: str
    code: int | None
    seconds: float
    compute_s: float | None  # as its own run.json says
    modules: int
    heavy: tuple[str, ...]


def plan(repeats: int, quick: bool) -> list[Task]:
    """Every command wanted."""
    wanted = [(name, words) for name, words in SCENES if not quick or name in QUICK]
    left = range(len(wanted), 0, -1)
    return [Task(*scene, max(1, repeats), n) for scene, n in zip(wanted, left, strict=True)]


def scenes(
    work: Sequence[Task],
    clock: Clock | None = None,
    on_scene: Callable[[], None] = lambda: None,
    keeping: Work | None = None,
) -> Iterator[Scene]:
    """Run every command in order; `on_scene` is called after each."""
    measure = partial(measure_scene, clock=clock or Clock())
    return one_by_one(measure, work, CODEC, keeping, on_scene)


CODEC = codec_of(Scene, lambda scene: scene.status != NOT_REACHED)


def ratios(found: Sequence[Scene]) -> list[float]:
    """Times over that of the cheapest; nan where there is none."""
    least = min((s.seconds for s in found if s.status == OK), default=nan)
    return [scene.seconds / least for scene in found]


def measure_scene(task: Task, clock: Clock) -> Scene:
    """Run a command once, and again as often as wanted while its share of the time lasts."""
    if clock.over:
        return Scene(task.name, task.words, NOT_REACHED, None, nan, None, 0, ())
    share, limit = clock.share(task.left), min(LONGEST, clock.left() + GRACE)
    runs = [_run(task.words, limit)]
    if runs[0][1][0] == STOPPED and limit < LONGEST:
        return Scene(task.name, task.words, NOT_REACHED, None, nan, None, 0, ())
    while len(runs) < task.repeats and sum(time for time, _ in runs) + runs[0][0] <= share:
        runs.append(_run(task.words, LONGEST))
    seconds, (code, modules, heavy, spent) = median(time for time, _ in runs), runs[-1][1]
    status = OK if code == 0 else FAILED
    return Scene(task.name, task.words, status, code, seconds, spent, modules, tuple(heavy))


def _run(words: tuple[str, ...], limit: float) -> tuple[float, tuple]:
    """(seconds, what the probe says) of one process in an empty folder, stopped at the limit."""
    import json

    with TemporaryDirectory(prefix="cam-bench-") as folder:
        given = words if "--help" in words else (*words, "-q", "-o", "out")
        began = perf_counter()
        try:
            done = subprocess.run(
                [sys.executable, "-c", PROBE.format(words=list(given), heavy=list(HEAVY))],
                cwd=folder,
                env={**os.environ, "NO_COLOR": "1"},
                capture_output=True,
                text=True,
                check=False,
                timeout=limit,
            )
        except subprocess.TimeoutExpired:
            return perf_counter() - began, (STOPPED, 0, [], None)
        seconds = perf_counter() - began
    try:
        said = json.loads(done.stderr.splitlines()[-1])
    except (IndexError, ValueError):
        said = [done.returncode or 1, 0, [], None]
    return seconds, tuple(said)
