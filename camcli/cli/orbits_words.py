"""What `cam orbits` says: tables for people, and the same as plain values for run.json."""

from __future__ import annotations

from typing import Any

from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Bifurcation, Branch, OrbitsResult
from camcli.cli.report import table
from camcli.output.orbits import DEG
from camcli.plots.event_words import event_words

SHOWN_PHASES = 6


def show(result: OrbitsResult) -> None:
    """Print orbits, branches, bifurcations and curves, then sentences."""
    if result.orbits:
        rows = [_orbit_row(orbit) for orbit in result.orbits]
        columns = ["orbit", "stable", "impacts at (deg)", "multipliers", "trace", "det"]
        table(f"Periodic orbits at {result.question.rpm:.10g} rpm", columns, rows)
    if result.branches:
        columns = ["branch", "labels", "from", "to", "points", "ends"]
        table(f"Branches in {result.question.parameter}", columns, _branch_rows(result))
    if result.bifurcations:
        columns = ["branch", "orbit", "event", result.question.parameter, "error", "class"]
        rows = [_event_row(b) for b in result.bifurcations]
        table("Bifurcations", columns, rows)
    for number, c in enumerate(result.curves, 1):
        table(
            f"Curve {number}: {c.kind} of {c.label}{c.corner and f' at {c.corner}'}",
            [c.first, c.second, "impacts at (deg)"],
            [
                [f"{p.first:.10g}", f"{p.second:.10g}", _phases(p.orbit)]
                for p in c.points[:: max(1, len(c.points) // 12)]
            ],
        )
    for line in remarks(result):
        print(f"- {line}")


def remarks(result: OrbitsResult) -> list[str]:
    """Sentences: absent labels, virtual orbits, corner impacts, what is impossible."""
    said = _absence(result)
    if result.virtual:
        said.append(
            f"{len(result.virtual)} further roots at {result.question.rpm:.10g} rpm are virtual: "
            "they penetrate the cam or would pull (run.json)"
        )
    told = set()
    for b in result.bifurcations:
        key = (b.kind, b.label, f"{b.value:.10g}")
        words = event_words(b)
        if words and key not in told:
            told.add(key)
            said.append(f"{b.kind} of {b.label} at {b.value:.10g}: {' '.join(words)}{_rests_on(b)}")
    if result.branches:
        said.append(_no_torus(result))
    if result.question.curve and not result.curves:
        said.append(f"no {result.question.curve} was located, so there is no curve to continue")
    said += [f"curve {n} ends: {c.ends[0]}; {c.ends[1]}" for n, c in enumerate(result.curves, 1)]
    return said


def _rests_on(b: Bifurcation) -> str:
    """The two inequalities that decide between the classes, with their numbers."""
    if not b.inequalities:
        return ""
    told = [
        f"{i.text} {'holds' if i.holds else 'fails'} ({i.left:.6g})" for i in b.inequalities[:2]
    ]
    return f" Rests on: {'; '.join(told)}."


def _no_torus(result: OrbitsResult) -> str:
    largest = max(orbit.det for branch in result.branches for orbit in branch.points)
    if largest < 1.0:
        return (
            f"Neimark-Sacker bifurcations are impossible: det = r^(2 impacts) exp(-b T/m) is at "
            f"most {largest:.6g} on these branches, below 1"
        )
    return (
        "det reaches 1 where nothing dissipates: there orbits are centres or saddles, none attracts"
    )


def _absence(result: OrbitsResult) -> list[str]:
    absent = result.absent
    if absent is None:
        at = result.question.rpm
        return [] if result.orbits else [f"no periodic orbit found at {at:.10g} rpm"]
    text = f"{result.question.label} was not found at {absent.rpm:.10g} rpm"
    if absent.nearest is None:
        return [f"{text}, nor at 24 speeds from {absent.low:.10g} to {absent.high:.10g} rpm"]
    value, cause = absent.nearest[0], absent.nearest[1].replace("-", " ")
    return [f"{text}; the nearest speed at which it was found is {value:.13g} rpm ({cause})"]


def _orbit_row(orbit: PeriodicOrbit) -> list[str]:
    large, small = orbit.multipliers
    return [
        orbit.label, "yes" if orbit.stable else "no", _phases(orbit), _pair(large, small),
        f"{orbit.trace:.10g}", f"{orbit.det:.10g}",
    ]  # fmt: skip


def _pair(large: complex, small: complex) -> str:
    if large.imag:
        return f"{large.real:.7g} +- {large.imag:.7g} i"
    return f"{large.real:.7g}, {small.real:.7g}"


def _phases(orbit: PeriodicOrbit) -> str:
    words = [f"{theta * DEG:.8g}" for theta in orbit.theta[:SHOWN_PHASES]]
    more = len(orbit.theta) - len(words)
    return ", ".join(words) + (f" and {more} more" if more > 0 else "")


def _branch_rows(result: OrbitsResult) -> list[list[str]]:
    return [
        [
            str(branch.number), ", ".join(branch.labels[:3]), f"{branch.points[0].value:.10g}",
            f"{branch.points[-1].value:.10g}", str(len(branch.points)), " | ".join(branch.ends),
        ]
        for branch in result.branches
    ]  # fmt: skip


def _event_row(b: Bifurcation) -> list[str]:
    kind = f"{b.kind} at {b.corner}" if b.corner else b.kind
    return [str(b.branch), b.label, kind, f"{b.value:.13g}", f"{b.error:.1e}", b.classification]


def summary(result: OrbitsResult) -> dict[str, Any]:
    """The result of run.json."""
    return {
        "words": remarks(result),
        "orbits": [_orbit(orbit) for orbit in result.orbits],
        "virtual": [_orbit(orbit) for orbit in result.virtual],
        "branches": [_branch(branch) for branch in result.branches],
        "bifurcations": [_event(b) for b in result.bifurcations],
        "curves": [
            {"kind": c.kind, "label": c.label, "corner": c.corner, "points": len(c.points),
             "ends": list(c.ends)}
            for c in result.curves
        ],
    }  # fmt: skip


def _orbit(orbit: PeriodicOrbit) -> dict[str, Any]:
    return {
        "label": orbit.label, "rpm": orbit.rpm, "stable": orbit.stable, "verdict": orbit.verdict,
        "theta_deg": [theta * DEG for theta in orbit.theta], "regions": list(orbit.regions),
        "multipliers": [[z.real, z.imag] for z in orbit.multipliers],
        "trace": orbit.trace, "det": orbit.det,
    }  # fmt: skip


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "branch": branch.number, "origin": branch.origin, "labels": branch.labels,
        "from": branch.points[0].value, "to": branch.points[-1].value,
        "points": len(branch.points), "ends": list(branch.ends),
    }  # fmt: skip


def _event(b: Bifurcation) -> dict[str, Any]:
    return {
        "branch": b.branch, "label": b.label, "kind": b.kind, "value": b.value, "error": b.error,
        "status": b.status, "corner": b.corner, "classification": b.classification,
        "continues_as_branch": b.continues, "prediction_agrees": b.agrees, "words": event_words(b),
        "inequalities": [
            {"text": i.text, "left": i.left, "right": i.right, "holds": i.holds}
            for i in b.inequalities
        ],
    }  # fmt: skip
