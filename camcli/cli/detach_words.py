"""The tables that `cam detach` prints."""

from __future__ import annotations

from math import inf

from camcli.analysis.contact_loss.detachment import CriticalSpeed, Quantity
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.cli.report import table
from camcli.output.detach import burst_ranges, sentences

ROUNDING = 1e-9  # N: a force that is zero up to rounding is printed as zero


def show(result: ContactLoss) -> None:
    """Print the tables, then the sentences."""
    rows = [_row(c) for c in result.critical_speeds if c.finite]
    if rows:
        columns = ["speed", "region", "theta (deg)", "rpm", "bracket", "status"]
        table("Critical speeds", columns, rows)
    hits = [
        [str(h.impact), h.corner, f"{h.rpm:.9f}", f"{h.high - h.low:.1e}", h.status]
        for h in result.hits
    ]
    if hits:
        table("Impacts on corners", ["impact", "corner", "rpm", "bracket (rpm)", "status"], hits)
    force = [
        [f"{f.rpm:.10g}", f"{f.lowest_n if abs(f.lowest_n) > ROUNDING else 0.0:.6g}",
         f"{f.lowest_deg:.8g}"]
        for f in result.forces
    ]  # fmt: skip
    table("Least contact force if kept on the cam", ["rpm", "least (N)", "theta (deg)"], force)
    spans = [[t, f"{a:.10g}", f"{b:.10g}", str(n)] for t, a, b, n in burst_ranges(result)]
    table("Bursts after settling", ["chattering", "from (rpm)", "to (rpm)", "speeds"], spans)
    springs = [
        [h.quantity.removeprefix("hold_"), f"{h.stiffness:.10g}", f"{h.preload:.10g}",
         "" if h.theta_deg is None else f"{h.theta_deg:.6g}", _speed(h.detaches_rpm), h.status]
        for h in result.holds
        if h.stiffness is not None
    ]  # fmt: skip
    if springs:
        columns = ["least", "k (N/m)", "preload (N)", "at (deg)", "detaches (rpm)", "status"]
        table("Springs that hold contact", columns, springs)
    for line in sentences(result):
        print(f"- {line}")


def _row(c: CriticalSpeed) -> list[str]:
    accumulates = c.quantity is Quantity.ACCUMULATION
    name = "accumulates at" if accumulates else c.quantity.replace("_", " ")
    return [
        name, c.region, f"{c.theta_deg:.8f}", f"{c.rpm:.9f}", f"{c.high - c.low:.1e}", c.status
    ]  # fmt: skip


def _speed(rpm: float | None) -> str:
    if rpm is None:
        return ""
    return "never" if rpm == inf else f"{rpm:.10g}"
