"""What `cam detach` says: tables for people, and the same as plain values for run.json."""

from __future__ import annotations

from math import inf, isfinite
from typing import Any

from camcli.analysis.contact_loss.accumulation_range import ranges
from camcli.analysis.contact_loss.detachment import Critical
from camcli.analysis.contact_loss.hold import NOT_NEEDED
from camcli.analysis.contact_loss.study import Study
from camcli.cli.report import table

SLIGHT_N = 1e-9  # N


def remarks(result: Study, rpms: list[float]) -> list[str]:
    """Sentences: what no number says."""
    said = list(result.detachment.words)
    never = [loss.region.name for loss in result.detachment.losses if loss.opens.rpm == inf]
    if never and result.detachment.first is not None:
        said.append(f"contact is never lost in {', '.join(never)}, at any speed")
    first = result.detachment.first
    if first is not None and first.rpm > max(rpms):
        said.append(f"contact is held at every speed up to {max(rpms):.10g} rpm, all asked for")
    elif first is not None and first.rpm < min(rpms):
        said.append(f"contact is lost at every speed asked for, {min(rpms):.10g} rpm and above")
    said += [
        f"at {f.rpm:.10g} rpm, a little above the opening of {f.region}: {f.words}"
        for f in result.follows
    ]
    said += [
        f"impact {hit.impact} of the burst from {hit.burst} ends at {hit.rpm:.10g} rpm before it "
        f"lands on {hit.corner}: it was at {hit.ends_deg[0]:.6g} deg, the next contact is at "
        f"{hit.ends_deg[1]:.6g} deg"
        for hit in result.ended
    ]
    said += [
        f"at {c.rpm:.10g} rpm the end of the burst from {c.burst} jumps over {c.region}"
        for c in result.jumps
    ]
    told = [h for h in result.holds if h.stiffness is None or h.status == NOT_NEEDED]
    said += [f"{h.quantity}: {h.words}" for h in told]
    return said


def show(result: Study, rpms: list[float]) -> None:
    """Print the tables, then the sentences."""
    rows = [_row(c) for c in result.criticals if c.finite]
    columns = ["speed", "region", "theta (deg)", "rpm", "bracket", "status"]
    if rows:
        table("Critical speeds", columns, rows)
    hits = [
        [str(h.impact), h.corner, f"{h.rpm:.9f}", f"{h.high - h.low:.1e}", h.status]
        for h in result.hits
    ]
    if hits:
        table("Impacts on corners", ["impact", "corner", "rpm", "bracket (rpm)", "status"], hits)
    force = [
        [f"{f.rpm:.10g}", f"{_plain_force(f.lowest_n):.6g}", f"{f.lowest_deg:.8g}"]
        for f in result.forces
    ]
    table("Least contact force if kept on the cam", ["rpm", "least (N)", "theta (deg)"], force)
    spans = [[w, f"{a:.10g}", f"{b:.10g}", str(n)] for w, a, b, n in ranges(result.speeds)]
    table("Bursts after settling", ["chattering", "from (rpm)", "to (rpm)", "speeds"], spans)
    _show_holds(result)
    for line in remarks(result, rpms):
        print(f"- {line}")


def _plain_force(newton: float) -> float:
    """Without the rounding noise of a force that is zero."""
    return 0.0 if abs(newton) < SLIGHT_N else newton


def _show_holds(result: Study) -> None:
    rows = [
        [
            h.quantity.removeprefix("hold_"),
            f"{h.stiffness:.10g}",
            f"{h.preload:.10g}",
            "" if h.theta_deg is None else f"{h.theta_deg:.6g}",
            _text(h.detaches_rpm),
            h.status,
        ]
        for h in result.holds
        if h.stiffness is not None
    ]
    if rows:
        columns = ["least", "k (N/m)", "preload (N)", "at (deg)", "detaches (rpm)", "status"]
        table("Springs that hold contact", columns, rows)


def _row(c: Critical) -> list[str]:
    name = {"accumulation_at_corner": "accumulates at"}.get(c.quantity, c.quantity)
    numbers = [f"{c.theta_deg:.8f}", f"{c.rpm:.9f}", f"{c.high - c.low:.1e}"]
    return [name.replace("_", " "), c.region, *numbers, c.status]


def _text(value: float | None) -> str:
    if value is None:
        return ""
    return "never" if value == inf else f"{value:.10g}"


def summary(result: Study, rpms: list[float]) -> dict[str, Any]:
    """The result of run.json; a speed that does not exist is null."""
    return {
        "words": remarks(result, rpms),
        "critical_speeds": [_critical(c) for c in result.criticals],
        "just_above_opening": [
            _finite({k: v for k, v in vars(f).items() if k != "words"}) for f in result.follows
        ],
        "corner_hits": [_hit(hit) for hit in result.hits],
        "corner_hits_ended": [_hit(hit) for hit in result.ended],
        "accumulation_jumps": [_critical(c) for c in result.jumps],
        "bursts": [
            {"bursts": words, "from_rpm": a, "to_rpm": b, "speeds": n}
            for words, a, b, n in ranges(result.speeds)
        ],
        "least_force": [
            {"rpm": f.rpm, "force_n": f.lowest_n, "theta_deg": f.lowest_deg} for f in result.forces
        ],
        "hold": [_finite(vars(h)) for h in result.holds],
    }


def _critical(c: Critical) -> dict[str, Any]:
    values = {"theta_deg": c.theta_deg if c.finite else None, "rpm": c.rpm}
    ends = {"low_rpm": c.low, "high_rpm": c.high, "status": c.status}
    burst = {"burst": c.burst} if c.burst else {}
    return _finite({"quantity": c.quantity, "region": c.region, **values, **ends, **burst})


def _hit(hit) -> dict[str, Any]:
    row = {"impact": hit.impact, "corner": hit.corner, "rpm": hit.rpm, "burst": hit.burst}
    ends = (
        {}
        if hit.ends_deg is None
        else {"before_deg": hit.ends_deg[0], "after_deg": hit.ends_deg[1]}
    )
    return {**row, "low_rpm": hit.low, "high_rpm": hit.high, "status": hit.status, **ends}


def _finite(values: dict[str, Any]) -> dict[str, Any]:
    return {
        key: None if isinstance(value, float) and not isfinite(value) else value
        for key, value in values.items()
    }
