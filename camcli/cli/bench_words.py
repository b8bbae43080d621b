"""What `cam bench` prints: tables for people, and the same as plain values for run.json."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import isnan
from typing import Any

from camcli.analysis.bench.clock import NOT_REACHED
from camcli.analysis.bench.flights import MOST_OF_PEERS, Flights
from camcli.analysis.bench.precision import ABSENT, Measured, failures
from camcli.analysis.bench.row import FAILED, Outcome
from camcli.analysis.bench.scenes import Scene, ratios
from camcli.analysis.bench.verdicts import EXACT, Verdict, verdicts
from camcli.cli.report import table

FLOWN = ("asked", "flights", "compared", "missed", "invented")


def show_stability(outcomes: Sequence[Outcome]) -> None:
    """The rows."""
    rows = [[o.case, o.observed, o.status, _seconds(o.seconds)] for o in outcomes]
    table("Extreme cases", ["case", "observed", "status", "s"], rows)


def _seconds(value: float) -> str:
    return "-" if isnan(value) else f"{value:.2g}"


def _number(value: float) -> float | None:
    return None if isnan(value) else value


def stability_faults(outcomes: Sequence[Outcome]) -> list[str]:
    """A line per failed row, and one for those that the clock left no time for."""
    bad = [o for o in outcomes if o.status == FAILED]
    lines = [f"stability: row {o.case}: expected {o.expected}: {o.observed}" for o in bad]
    return lines + _unreached("stability", "rows", outcomes)


def _unreached(part: str, what: str, found: Sequence[Any]) -> list[str]:
    """A line where the clock left no time for some."""
    count = sum(x.status == NOT_REACHED for x in found)
    return [f"{part}: {count} of {len(found)} {what} not reached, time was up"] if count else []


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
        rows = [[f.method, *(str(getattr(f, name)) for name in FLOWN)] for f in flown]
        table("Random flights", ["method", *FLOWN], rows)


def _verdict(v: Verdict) -> list[str]:
    ours = [v.case, _seconds(v.ours.seconds), f"{v.ours.error:.1e}", f"{v.ours.of_bound:.2g}"]
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
        if m.status != NOT_REACHED
    ]
    lines += _unreached("precision", "points of ours", [m for m in found if m.ours])
    lines += [
        f"precision: random flights: {f.missed} contacts missed, {f.invented} invented by ours"
        for f in flown[:1]
        if f.missed or f.invented
    ]
    return lines


def precision_notes(found: Sequence[Measured], flown: Sequence[Flights]) -> list[str]:
    """What is not in the numbers, though nothing is wrong."""
    lines = _unreached("precision", "points of others", [m for m in found if not m.ours])
    if any(m.status == ABSENT for m in found):
        lines.append(
            "heyoka is not installed, its points are left out: pip install 'camcli[bench]'"
        )
    lines += [
        f"precision: time was up after {f.flights} of {f.asked} random flights"
        for f in flown[:1]
        if f.flights < f.asked
    ]
    if flown and flown[0].asked > MOST_OF_PEERS:
        lines.append(f"precision: the others fly the first {MOST_OF_PEERS} random flights only")
    return lines


def precision_summary(found: Sequence[Measured], flown: Sequence[Flights]) -> dict[str, Any]:
    """For run.json."""
    cases = [
        {
            "case": v.case,
            "seconds": v.ours.seconds,
            "error_turns": _number(v.ours.error),
            "of_bound": _number(v.ours.of_bound),
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
    flights = [{name: getattr(f, name) for name in ("method", *FLOWN)} for f in flown]
    return {"cases": cases, "points": points, "failed": failed, "flights": flights}


def show_scenes(found: Sequence[Scene]) -> None:
    """Times, ratios and imports."""
    rows = [
        [s.name, s.status, *_times(s, ratio), str(s.modules), " ".join(s.heavy)]
        for s, ratio in zip(found, ratios(found), strict=True)
    ]
    columns = ["scene", "status", "s", "ratio", "computing s", "modules", "heavy"]
    table("What a scene costs", columns, rows)


def _times(scene: Scene, ratio: float) -> list[str]:
    if scene.status == NOT_REACHED:
        return ["-"] * 3
    spent = "-" if scene.compute_s is None else f"{scene.compute_s:.3f}"
    return [f"{scene.seconds:.2f}", f"{ratio:.2f}", spent]


def scenes_faults(found: Sequence[Scene]) -> list[str]:
    """A line per command that failed, and one for those that the clock left no time for."""
    lines = [f"scenes: {s.name}: exit code {s.code}" for s in found if s.status == FAILED]
    return lines + _unreached("scenes", "commands", found)


def scenes_summary(found: Sequence[Scene]) -> list[dict[str, Any]]:
    """For run.json."""
    return [
        {"scene": s.name, "words": list(s.words), "status": s.status, "exit_code": s.code,
         "ratio": _number(ratio), "modules": s.modules, "heavy": list(s.heavy)}
        for s, ratio in zip(found, ratios(found), strict=True)
    ]  # fmt: skip
