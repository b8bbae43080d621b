"""A record begins with nothing in it: each of its numbers is zero but for those that stand here.

Of every record of the kernel, the cams, the exact motion and the analyses, the values that a field
has where none is given. What is not nothing stands in BEGINNINGS once more, with its reason.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from math import inf, isnan, nan
from typing import Any

import numpy as np

import camcli
from camcli.errors import Status

BEGINNINGS = {  # what is not zero, empty or None
    # a resting force may be 0 and more; the least is the smallest of what comes
    "kernel.loads.Loads": {"min_force": 1.0, "lost": -1.0, "regained": -1.0, "landing": -1.0},
    "kernel.orbit_loop.Earlier": {"keep_in": -(2**62), "gap": -1.0},  # at once; no gap is below 0
    "kernel.variational.Pair": {"qq": 1.0, "ww": 1.0},  # the identity
    "kernel.variational.Growth": {"first": 1.0, "area": 1.0},  # a factor of one
    "analysis.basins.attractor_finder.AttractorFinder": {
        "chunk": 131_072, "aperiodic_turns": 32_768,
    },
    "analysis.basins.cell_batches.CellBatches": {"block": 1024, "steps": 200_000},
    "analysis.basins.recurrence.Grid": {"side": 100},  # 96 boxes and two spare ones at each edge
    "analysis.basins.study.BasinsQuestion": {"budget": 4000},
    "analysis.bench.precision.Measured": {
        "seconds": nan, "error": nan, "bound": nan, "of_bound": nan, "status": "not-installed",
    },
    "analysis.chaos.section.SectionBox": {"cells": (1, 1)},
    "analysis.chaos.section.Chaos": {"growth": 1.0},
    "analysis.contact_loss.bursts.Burst": {"end": inf},  # it does not accumulate
    "analysis.contact_loss.force.Hertz": {"ratio": 1.0},
    "analysis.contact_loss.hold.Hold": {"more": True},
    "analysis.explain.changes.Limits": {"seeds": 12, "leaving": 8, "crises": 3},
    "analysis.explain.changes.CriticalEvent": {"status": "ok"},
    "analysis.explain.changes.LabelChange": {"may_search": True},
    "analysis.explain.tangency.Sampling": {"starts": 4000, "searches": 5, "solved": 6},
    "analysis.explain.tangency.Fold": {"xi": inf, "left": 150},
    "analysis.explain.tangency.Folds": {"sampling": (4000, 5, 6)},
    "analysis.integrate.Portions": {
        "plain_steps": 20_000, "compiled_steps": 200_000, "first_rows": 256,
        "most_rows": 1_048_576, "copies_turns": True,
    },
    "analysis.integrate.Start": {"place": "run.start"},
    "analysis.integrate.Settings": {"patience": 20_000},
    "analysis.motion_at_speed.SpeedTask": {"follow": True},
    "analysis.orbits.branch_segment.BranchSegment": {"end": "lost"},
    "analysis.orbits.codim2.Condition": {"impact": -1},
    "analysis.orbits.curves.Curve": {"limits": ("", ""), "beyond": (None, None)},
    "analysis.orbits.locate.Located": {"impact": -1},
    "analysis.orbits.proofs.Proof": {"holds_for": "exact-data"},
    "analysis.orbits.sticking_orbits.StickingSegment": {"end": "end-of-range"},
    "analysis.orbits.study.OrbitsQuestion": {"parameter": "rpm", "branches": 3, "starts": 24},
    "analysis.speeds.Speed": {"known": True},
    "analysis.sweep.Sweep": {"key": "rpm"},
    "cams.compile.Piece": {"rests": (0.0, 0.0)},
    "system.Follower": {"restitution": 0.8},
}  # fmt: skip


def records() -> Iterator[tuple[str, type]]:
    """(name, class) of every dataclass and named tuple of the numerical packages."""
    for module in pkgutil.walk_packages(camcli.__path__, "camcli."):
        place = module.name.removeprefix("camcli.")
        if place.split(".")[0] not in ("analysis", "cams", "check", "exact", "kernel", "system"):
            continue
        for name, one in vars(importlib.import_module(module.name)).items():
            own = isinstance(one, type) and one.__module__ == module.name
            if own and (is_dataclass(one) or hasattr(one, "_field_defaults")):
                yield f"{place}.{name}", one


def beginnings(record: type) -> dict[str, Any]:
    """The value of each field that has one where none is given."""
    if not is_dataclass(record):
        return dict(record._field_defaults)
    found = {}
    for field in fields(record):
        if field.default is not MISSING:
            found[field.name] = field.default
        elif field.default_factory is not MISSING:
            found[field.name] = field.default_factory()
    return found


def is_nothing(value: Any) -> bool:
    """Zero, empty, None, OK, or a record of nothing else."""
    if value is None or value is Status.OK:
        return True
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return all(map(is_nothing, value))
    if is_dataclass(value):
        return True  # its own fields are looked at where it is defined
    return not np.any(value) if isinstance(value, np.ndarray) else not value


def test_every_record_begins_with_nothing_but_what_stands_here():
    others: dict[str, dict[str, Any]] = {}
    for name, record in records():
        here = {key: value for key, value in beginnings(record).items() if not is_nothing(value)}
        if here:
            others[name] = here
    assert sorted(others) == sorted(BEGINNINGS)
    for name, wanted in BEGINNINGS.items():
        assert sorted(others[name]) == sorted(wanted), name
        for key, value in wanted.items():
            found = others[name][key]
            same = isnan(found) if isinstance(value, float) and isnan(value) else found == value
            assert same, (name, key, found)
