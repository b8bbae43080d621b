"""What `cam bench` prints: tables for people, and the same as plain values for run.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from camcli.analysis.bench.flights import Flights
from camcli.analysis.bench.precision import Measured, failures
from camcli.analysis.bench.row import OK, Outcome
from camcli.analysis.bench.scenes import Scene, ratios
from camcli.analysis.bench.verdicts import EXACT, Verdict, verdicts
from camcli.cli.report import table


def show_stability(outcomes: Sequence[Outcome]) -> None:
    """The rows."""
    rows = [[o.case, o.observed, o.status, f"{o.seconds:.2g}"] for o in outcomes]
    table("Extreme cases", ["case", "observed", "status", "s"], rows)


def stability_faults(outcomes: Sequence[Outcome]) -> list[str]:
    """A line per failed row."""
    bad = [o for o in outcomes if o.status != OK]
    return [f"stability: row {o.case}: expected {o.expected}: {o.observed}" for o in bad]


def show_precision(found: Sequence[Measured], flown: Sequence[Flights]) -> None:
    """A line per case, how the points ended, and the flights."""
    rows = [_verdict(v) for v in verdicts(found)]
    columns = ["case", "camcli s", "error", "of bound", f"fastest to {EXACT:g}", "x camcli"]
    if rows:
        table("Work and precision", [*columns, "most exact other", "its error"], rows)
    tally = Counter((m.method, m.status) for m in found)
    lines = [[method, status, str(n)] for (method, status), n in tally.items()]
    table("Points", ["method", "status", "points"], lines)
    if flown:
        rows = [[f.method, *map(str, (f.flights, f.compared, f.missed, f.invented))] for f in flown]
        table("Random flights", ["method", "flights", "compared", "missed", "invented"], rows)


def _verdict(v: Verdict) -> list[str]:
    ours = [v.case, f"{v.ours.seconds:.2g}", f"{v.ours.error:.1e}", f"{v.ours.of_bound:.2g}"]
    fast = ["-", "-"] if v.fastest is None else [_named(v.fastest), f"{v.ratio:.3g}"]
    best = ["-", "-"] if v.best is None else [_named(v.best), f"{v.best.error:.1e}"]
    return [*ours, *fast, *best]


def _named(m: Measured) -> str:
    return f"{m.method} {m.setting}"


def precision_faults(found: Sequence[Measured], flown: Sequence[Flights]) -> list[str]:
    """A line per broken promise of ours."""
    lines = [
        f"precision: {m.case}, {m.setting}: {m.status}: error {m.error:.2g} turns, "
        f"{m.of_bound:.3g} times its bound at most, {m.missed} impacts missed"
        for m in failures(found)
    ]
    lines += [
        f"precision: random flights: {f.missed} contacts missed, {f.invented} invented by ours"
        for f in flown[:1]
        if f.missed or f.invented
    ]
    return lines


def precision_summary(found: Sequence[Measured], flown: Sequence[Flights]) -> dict[str, Any]:
    """For run.json."""
    cases = [
        {
            "case": v.case,
            "seconds": v.ours.seconds,
            "error_turns": v.ours.error,
            "of_bound": v.ours.of_bound,
            "fastest_other": None if v.fastest is None else _named(v.fastest),
            "ratio": v.ratio,
            "most_exact_other": None if v.best is None else _named(v.best),
            "its_error_turns": None if v.best is None else v.best.error,
        }
        for v in verdicts(found)
    ]
    tally = Counter((m.method, m.status) for m in found)
    points = [{"method": a, "status": b, "points": n} for (a, b), n in tally.items()]
    failed = [f"{m.case}, {m.setting}: {m.status}" for m in failures(found)]
    flights = [
        {"method": f.method, "flights": f.flights, "compared": f.compared, "missed": f.missed,
         "invented": f.invented}
        for f in flown
    ]  # fmt: skip
    return {"cases": cases, "points": points, "failed": failed, "flights": flights}


def show_scenes(found: Sequence[Scene]) -> None:
    """Times, ratios and imports."""
    rows = [
        [s.name, f"{s.seconds:.2f}", f"{ratio:.2f}", _spent(s), str(s.modules), " ".join(s.heavy)]
        for s, ratio in zip(found, ratios(found), strict=True)
    ]
    table("What a scene costs", ["scene", "s", "ratio", "computing s", "modules", "heavy"], rows)


def _spent(scene: Scene) -> str:
    return "-" if scene.compute_s is None else f"{scene.compute_s:.3f}"


def scenes_faults(found: Sequence[Scene]) -> list[str]:
    """A line per command that failed."""
    return [f"scenes: {s.name}: exit code {s.code}" for s in found if s.code != 0]


def scenes_summary(found: Sequence[Scene]) -> list[dict[str, Any]]:
    """For run.json."""
    return [
        {"scene": s.name, "words": list(s.words), "exit_code": s.code, "ratio": ratio,
         "modules": s.modules, "heavy": list(s.heavy)}
        for s, ratio in zip(found, ratios(found), strict=True)
    ]  # fmt: skip
