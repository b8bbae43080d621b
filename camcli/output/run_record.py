"""run.json: what was run, with what, at which cost, and how exact it is."""

import json
import os
import platform
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from math import isfinite, isnan
from typing import Any

from camcli.analysis.integrate import Cost
from camcli.installed import version
from camcli.output.program import program_hash
from camcli.system import System
from camcli.words.cost import BOUND

PACKAGES = (
    "camcli", "numpy", "numba", "scipy", "pydantic", "matplotlib", "typer", "rich", "pyyaml",
    "python-flint",
)  # fmt: skip

LAST_DIGITS = 2.0**-50  # of a length: four roundings of the largest c in the sum of its polynomial


def cost_record(cost: Cost, seconds: float, from_disk: int = 0) -> dict[str, Any]:
    """Impacts, seconds and their ratio, and the evaluations behind them.

    No ratio where some of the work was found on disk.
    """
    return {
        "impacts": cost.impacts,
        "seconds": seconds,
        "impacts_per_s": cost.impacts / seconds if seconds > 0 and not from_disk else None,
        "gap_evaluations": cost.evaluations,
        "crossings": cost.crossings,
        "pieces_from_disk": from_disk,
    }


def error_record(tolerance: float, system: System) -> dict[str, Any]:
    """Bounds on the error of one event; the orbit's own stretching multiplies them."""
    highest = system.cam.top
    lowest = highest - system.lift
    return {
        "accumulation_phase_turns": tolerance,
        "contact_gap_m": LAST_DIGITS * max(abs(highest), abs(lowest)),
        "meaning": BOUND,
    }


def run_record(**parts: Any) -> dict[str, Any]:
    """The content of run.json: these parts, then the program, the versions and the machine.

    parts: command, scene, scene_sha256, cost, error, verdict, verdict_details, notes, result,
    piece_faults and artefacts (the SHA-256 of each file).
    """
    return {
        **parts,
        "program_sha256": program_hash(),
        "versions": {"python": platform.python_version(), **_versions()},
        "machine": {
            "system": platform.system(),
            "processor": platform.machine(),
            "processors": os.cpu_count(),
        },
    }


@cache
def _versions() -> dict[str, str]:
    """Versions of the packages by name."""
    versions = {}
    for package in PACKAGES:
        with suppress(ImportError):  # not installed
            versions[package] = version(package)
    return versions


def to_text(record: Mapping[str, Any]) -> str:
    """JSON text: infinities are "inf" and "-inf", NaN is null, a complex number [re, im]."""
    return json.dumps(as_json(record), indent=2, allow_nan=False) + "\n"


def as_json(value: Any) -> Any:
    """A value as JSON holds it: lists for tuples, and what `to_text` says of numbers."""
    if isinstance(value, Mapping):
        return {key: as_json(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [as_json(inner) for inner in value]
    if isinstance(value, complex):
        return [as_json(value.real), as_json(value.imag)]
    if isinstance(value, float) and not isfinite(value):
        if isnan(value):
            return None
        return "inf" if value > 0.0 else "-inf"
    return value
