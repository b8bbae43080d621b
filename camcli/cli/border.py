"""cam classify --trace L,R --det L,R: the border-collision calculator; it needs no scene."""

from __future__ import annotations

import json
from math import isfinite
from typing import Any

from camcli.analysis.border_collision import Collision, Cycle, Side, classify
from camcli.cli.exit_codes import DONE
from camcli.cli.options import Request
from camcli.cli.report import table
from camcli.errors import Fault, SceneError
from camcli.plots.event_words import collision_words


def run(request: Request) -> int:
    """Print the class, the inequalities and what attracts on each side."""
    traces, dets = _pair(request, "trace"), _pair(request, "det")
    left, right = (Side(t, d) for t, d in zip(traces, dets, strict=True))
    result = classify(left, right)
    if request.json:
        print(json.dumps(_record(left, right, result), indent=2))
    else:
        _show(left, right, result)
    return DONE


def _pair(request: Request, name: str) -> list[float]:
    text = request.extra[name]
    option = f"--{name}"
    cure = "e.g. --trace 1.64,1.37 --det 0.64,0.64"
    if text is None:
        found = f"found no {option}"
        raise SceneError(Fault(option, "", found, "expected both --trace and --det", cure))
    try:
        values = [float(word) for word in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 2 or not all(isfinite(value) for value in values):
        found = f"found '{text}'"
        raise SceneError(Fault(option, "", found, "expected two numbers L,R", cure))
    return values


def _show(left: Side, right: Side, result: Collision) -> None:
    rows = [
        [name, f"{s.trace:.10g}", f"{s.det:.10g}", _multipliers(s.multipliers), s.kind]
        for name, s in (("L", left), ("R", right))
    ]
    table(f"Border collision: {result.kind}", ["side", "trace", "det", "multipliers", "is"], rows)
    rows = [
        [i.text, f"{i.left:.9g}", f"{i.right:.9g}", "holds" if i.holds else "fails"]
        for i in result.inequalities
    ]
    table("Inequalities", ["inequality", "left", "right", ""], rows)
    table(
        "Fixed points and the 2-cycle",
        ["word", "exists for", "stable", "multipliers"],
        [_cycle(cycle) for cycle in result.cycles],
    )
    for line in collision_words(result):
        print(f"- {line}")


def _cycle(cycle: Cycle) -> list[str]:
    where = {1: "mu > 0", -1: "mu < 0", 0: "never"}[cycle.exists_for]
    return [cycle.word, where, "yes" if cycle.stable else "no", _multipliers(cycle.multipliers)]


def _multipliers(pair) -> str:
    first, second = pair
    if isinstance(first, complex) and first.imag:
        return f"{first.real:.9g} +- {abs(first.imag):.9g} i"
    return f"{complex(first).real:.9g}, {complex(second).real:.9g}"


def _record(left: Side, right: Side, result: Collision) -> dict[str, Any]:
    return {
        "kind": result.kind,
        "sides": {
            name: {"trace": s.trace, "det": s.det, "kind": s.kind, "stable": s.stable,
                   "multipliers": [_complex(z) for z in s.multipliers]}
            for name, s in (("L", left), ("R", right))
        },
        "inequalities": [vars(i) for i in result.inequalities],
        "cycles": [
            {"word": c.word, "stable": c.stable, "exists_for_mu": c.exists_for,
             "multipliers": [_complex(z) for z in c.multipliers],
             "points": [list(point) for point in c.points]}
            for c in result.cycles
        ],
        "below": vars(result.below), "above": vars(result.above), "words": collision_words(result),
    }  # fmt: skip


def _complex(z) -> list[float]:
    return [complex(z).real, complex(z).imag]
