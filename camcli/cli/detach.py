"""cam detach"""

from __future__ import annotations

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
    from camcli.cli.run import given, ranges, run
    from camcli.scene import parse_rpm

    values = ranges(request, "detach")
    if request.rpm is not None and ":" not in request.rpm:
        values["detach.force_rpm"] = ([parse_rpm(request.rpm)], "--rpm")
    top = None if hold_to is None else parse_rpm(hold_to, "--hold-to")
    if isinstance(top, tuple):
        found = f"found the range '{hold_to}'"
        raise SceneError(Fault("--hold-to", "", found, "expected one speed", "give its top"))
    values |= given({"detach.hold_to": (top, "--hold-to")})
    return run("detach", request, values, show)


def show(result: Result) -> None:
    """Print the tables, then the sentences."""
    from camcli.cli.report import table
    from camcli.output.detach import burst_ranges, sentences

    found = result.values
    critical = [
        [
            _name(c),
            c.region,
            f"{c.theta_deg:.8f}",
            f"{c.rpm:.9f}",
            f"{c.high - c.low:.1e}",
            c.status,
        ]
        for c in found.critical_speeds
        if c.finite
    ]
    hits = [
        [h.impact, h.corner, f"{h.rpm:.9f}", f"{h.high - h.low:.1e}", h.status] for h in found.hits
    ]
    force = [
        [f.rpm, f"{f.lowest_n if abs(f.lowest_n) > ROUNDING else 0.0:.6g}", f"{f.lowest_deg:.8g}"]
        for f in found.forces
    ]
    springs = [
        [h.quantity.removeprefix("hold_"), h.stiffness, h.preload,
         "" if h.theta_deg is None else f"{h.theta_deg:.6g}",
         "never" if h.detaches_rpm == inf else h.detaches_rpm, h.status]
        for h in found.holds
        if h.stiffness is not None
    ]  # fmt: skip
    for title, columns, rows in (
        ("Critical speeds", "speed, region, theta (deg), rpm, bracket, status", critical),
        ("Impacts on corners", "impact, corner, rpm, bracket (rpm), status", hits),
        ("Least contact force if kept on the cam", "rpm, least (N), theta (deg)", force),
        ("Bursts after settling", "chattering, from (rpm), to (rpm), speeds", burst_ranges(found)),
        ("Springs that hold contact",
         "least, k (N/m), preload (N), at (deg), detaches (rpm), status", springs),
    ):  # fmt: skip
        if rows:
            table(title, columns.split(", "), [[_cell(value) for value in row] for row in rows])
    for line in sentences(found):
        print(f"- {line}")


def _name(c: CriticalSpeed) -> str:
    name = c.quantity.replace("_", " ")
    return "accumulates at" if name.startswith("accumulation") else name


def _cell(value: str | float | None) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{value:.10g}"
