"""cam detach"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING, Annotated

from typer import Option

from camcli.cli.options import Request
from camcli.errors import Fault, SceneError

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.detachment import CriticalSpeed
    from camcli.api.result import Result

ROUNDING = 1e-9  # N: a force that is zero up to rounding is printed as zero


def detach(
    request: Request,
    hold_to: Annotated[
        str | None,
        Option("--hold-to", help="Find the spring that holds up to this speed.", metavar="RPM"),
    ] = None,
) -> int:
    """Where contact is lost, where chattering ends, and which spring would hold.

    \b
    detach.csv        quantity, region, theta_deg, rpm, omega_rad_per_s
    accumulation.csv  rpm, theta_deg: where a complete chatter ends, a row per burst and speed
    corner_hits.csv   impact, corner, rpm: impact n after lift-off lands on a corner
    force.csv         rpm, theta_deg, force_n: contact force of a follower kept on the cam
    detach.png        impacts with accumulation curve and corner hits; the contact force

    \b
    Regions A1, A2, ... lie between the cam's corners a, b, c, ... Quantities of detach.csv:
    first_detachment        lowest speed at which the contact force reaches zero anywhere
    opens, fills            contact begins to be lost in a region; is lost all over it (inf: never)
    accumulation_at_corner  a burst ends exactly on the corner `region`; looked for between the
                            speeds of the range (--points), from rest at each lift-off
    completion_loss         its end reaches, one turn later, the phase of the next lift-off
    hold_stiffness, hold_preload, hold_both
                            first detachment with the spring that --hold-to found (in run.json)

    \b
    Every critical speed has a bracket and a status in run.json: ok; never; at-standstill; jump
    (the end of the chatter jumps over a corner); unresolved, exit code 3. A curve of corner hits
    may end where its impact ceases to exist: run.json says where.
    """
    from camcli.cli.run import given, run, speed_range
    from camcli.scene import parse_rpm

    values = speed_range(request, "detach")
    if request.rpm is not None and ":" not in request.rpm:
        values["detach.force_rpm"] = ([parse_rpm(request.rpm)], "--rpm")
    values |= given({"detach.hold_to": (_top(hold_to), "--hold-to")})
    return run("detach", request, values, show)


def _top(text: str | None) -> float | None:
    """The speed of --hold-to."""
    from camcli.scene import parse_rpm

    if text is None:
        return None
    try:
        rpm = parse_rpm(text)
    except SceneError as error:
        raise SceneError(*(replace(fault, where="--hold-to") for fault in error.faults)) from None
    if isinstance(rpm, tuple):
        found = f"found the range '{text}'"
        raise SceneError(Fault("--hold-to", "", found, "expected one speed", "give its top"))
    return rpm


def show(result: Result) -> None:
    """Print the tables, then the sentences."""
    from camcli.cli.report import table
    from camcli.output.detach import burst_ranges, sentences

    found = result.values
    rows = [_row(c) for c in found.critical_speeds if c.finite]
    if rows:
        columns = ["speed", "region", "theta (deg)", "rpm", "bracket", "status"]
        table("Critical speeds", columns, rows)
    hits = [
        [str(h.impact), h.corner, f"{h.rpm:.9f}", f"{h.high - h.low:.1e}", h.status]
        for h in found.hits
    ]
    if hits:
        table("Impacts on corners", ["impact", "corner", "rpm", "bracket (rpm)", "status"], hits)
    force = [
        [f"{f.rpm:.10g}", f"{f.lowest_n if abs(f.lowest_n) > ROUNDING else 0.0:.6g}",
         f"{f.lowest_deg:.8g}"]
        for f in found.forces
    ]  # fmt: skip
    table("Least contact force if kept on the cam", ["rpm", "least (N)", "theta (deg)"], force)
    spans = [[t, f"{a:.10g}", f"{b:.10g}", str(n)] for t, a, b, n in burst_ranges(found)]
    table("Bursts after settling", ["chattering", "from (rpm)", "to (rpm)", "speeds"], spans)
    springs = [
        [h.quantity.removeprefix("hold_"), f"{h.stiffness:.10g}", f"{h.preload:.10g}",
         "" if h.theta_deg is None else f"{h.theta_deg:.6g}", _speed(h.detaches_rpm), h.status]
        for h in found.holds
        if h.stiffness is not None
    ]  # fmt: skip
    if springs:
        columns = ["least", "k (N/m)", "preload (N)", "at (deg)", "detaches (rpm)", "status"]
        table("Springs that hold contact", columns, springs)
    for line in sentences(found):
        print(f"- {line}")


def _row(c: CriticalSpeed) -> list[str]:
    from camcli.analysis.contact_loss.detachment import Quantity

    accumulates = c.quantity is Quantity.ACCUMULATION
    name = "accumulates at" if accumulates else c.quantity.replace("_", " ")
    return [
        name, c.region, f"{c.theta_deg:.8f}", f"{c.rpm:.9f}", f"{c.high - c.low:.1e}", c.status
    ]  # fmt: skip


def _speed(rpm: float | None) -> str:
    if rpm is None:
        return ""
    return "never" if rpm == inf else f"{rpm:.10g}"
