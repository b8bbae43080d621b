"""What a scene does not need costs nothing: time and modules of whole commands.

Each is a process of its own. `seconds` is the wall time of the process, `modules` how many modules
it had imported at its end, `heavy` the large libraries among them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import nan
from statistics import median
from time import perf_counter

from camcli.analysis.bench.machine import LONGEST, STOPPED, command
from camcli.analysis.bench.pieces import FAILED, NOT_REACHED, OK

GRACE = 3.0  # s that a command begun in time may take beyond the end
PROBE = """
import json, os, sys
from camcli.cli.app import app
from camcli.cli.exit_codes import guarded
code = guarded(lambda: app(sys.argv[1:], standalone_mode=False))
sys.stdout.flush()
spent = None
if os.path.exists("out/run.json"):
    with open("out/run.json") as file:
        spent = json.load(file)["cost"]["seconds"]
heavy = ("matplotlib", "numba", "numpy", "pydantic", "rich", "scipy", "yaml")
heavy = " ".join(name for name in heavy if name in sys.modules)
print(json.dumps([code, len(sys.modules), heavy, spent]), file=sys.stderr)
"""
SIMULATE = "simulate --rpm {} --set run.transient=10 --set run.record=5"
SWEEP = "sweep --rpm 660:760 --points 101"
DAMPED = "--set follower.damping=20"
SCENES = {
    "cam --help": "--help",
    "simulate, contact": f"{SIMULATE.format(100)} --no-plot",
    "simulate, impacts": f"{SIMULATE.format(700)} --no-plot",
    "simulate, chatter": f"{SIMULATE.format(190)} --no-plot",
    "simulate, damping": f"{SIMULATE.format(700)} {DAMPED} --no-plot",
    "simulate, picture": SIMULATE.format(700),
    "sweep, no log": f"{SWEEP} --set sweep.sections=[strobe] --no-plot",
    "sweep, log": f"{SWEEP} --no-plot",
    "sweep, log, damping": f"{SWEEP} {DAMPED} --no-plot",
    "sweep, log, picture": SWEEP,
    "sweep, exponents": f"{SWEEP} --set sweep.lyapunov=true --no-plot",
    "detach": "detach --points 31 --no-plot",
    "orbits": "orbits --rpm 700 --no-plot",
    "classify, exponents": "classify --rpm 700 --no-plot",
    "basins": "basins --cells 24 --no-plot",
    "basins, picture": "basins --cells 24",
}
QUICK = ("cam --help", "simulate, contact", "simulate, chatter", "simulate, picture", "sweep, log")


@dataclass(frozen=True)
class Scene:
    """A row of scenes.csv: medians of wall time, and what the command imported."""

    scene: str
    status: str = NOT_REACHED
    seconds: float = nan
    ratio: float = nan  # of seconds over those of the cheapest
    compute_s: float | None = None  # as its own run.json says
    modules: int = 0
    heavy: str = ""
    exit_code: int | None = None


def with_ratios(found: Sequence[Scene]) -> list[Scene]:
    """The rows with their times over that of the cheapest."""
    least = min((s.seconds for s in found if s.status == OK), default=nan)
    return [replace(s, ratio=s.seconds / least) for s in found]


def measure(name: str, repeats: int, share: float, left: float) -> list[Scene]:
    """Run a command once, and again as often as wanted while its share of the time lasts."""
    limit = min(LONGEST, left + GRACE)
    runs = [_run(name, limit)] if left > 0.0 else []
    if not runs or (runs[0][1] == STOPPED and limit < LONGEST):
        return [Scene(name)]
    while len(runs) < repeats and sum(run[0] for run in runs) + runs[0][0] <= share:
        runs.append(_run(name, LONGEST))
    _, code, modules, heavy, spent = runs[-1]
    seconds = median(run[0] for run in runs)
    status = OK if code == 0 else FAILED
    return [Scene(name, status, seconds, nan, spent, modules, heavy, code)]


def _run(name: str, limit: float) -> tuple[float, int, int, str, float | None]:
    """Seconds of one process stopped at the limit, and what the probe says at its end."""
    words = SCENES[name].split()
    words += [] if name == "cam --help" else ["-q", "-o", "out"]
    began = perf_counter()
    done = command(words, limit, ("-c", PROBE))
    seconds = perf_counter() - began
    try:
        return seconds, *json.loads(done.stderr.splitlines()[-1])
    except (IndexError, ValueError):
        return seconds, done.returncode or 1, 0, "", None
