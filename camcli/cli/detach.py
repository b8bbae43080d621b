"""cam detach"""

from __future__ import annotations

from functools import partial
from math import inf
from typing import TYPE_CHECKING, Annotated

from typer import Option

from camcli.cli.options import Request
from camcli.errors import Fault, SceneError

if TYPE_CHECKING:
    from camcli.analysis.contact_loss.detachment import CriticalSpeed
    from camcli.analysis.contact_loss.study import ContactLoss
    from camcli.api.result import Result

ROUNDING = 1e-9  # N: a force that is zero up to rounding is printed as zero


def detach(
    request: Request,
    hold_to: Annotated[
        str | None,
        Option("--hold-to", help="Find the spring that holds up to this speed.", metavar="RPM"),
    ] = None,
    verbose: Annotated[
        bool, Option("--verbose", "-v", help="Print the theory: critical speeds, bursts, corners.")
    ] = False,
) -> int:
    """Where contact is lost, where chattering ends, and which spring would hold.

    \b
    detach.csv        quantity, region, theta_deg, rpm, omega_rad_per_s
    accumulation.csv  rpm, theta_deg: where a complete chatter ends, a row per burst and speed
    corner_hits.csv   impact, corner, rpm: impact n after lift-off lands on a corner
    force.csv         rpm, theta_deg, force_n, pressure_pa: contact force of a follower kept on the
                      cam; with the section `contact` of the scene the Hertz pressure
    speeds.csv        columns as in cam sweep: the motion at some speeds past the first loss of
                      contact: loft, landing, bounces on the shut cam, contact forces. On the
                      screen "at lift" is the lift at the hardest landing, "bounces" the impacts a
                      turn, a tenth as hard or harder, within a hundredth of the lift
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
    return run("detach", request, values, partial(show, verbose=verbose))


def show(result: Result, verbose: bool = False) -> None:
    """Print what an engineer asks; the theory behind it only where it is asked for."""
    from camcli.output.detach import plainly, theory

    _show_answers(result)
    if verbose:
        _show_theory(result.values)
    for line in plainly(result.values) + (theory(result.values) if verbose else []):
        print(f"- {line}")
    if not verbose:
        print(
            "(critical speeds with their brackets, corner hits and bursts: --verbose, or run.json)"
        )


def _show_answers(result: Result) -> None:
    """Past the loss of contact; the contact force; the springs of --hold-to."""
    from camcli.cli.report import table
    from camcli.output.detach import WAYS
    from camcli.output.verdict import crank_of, units_of

    found, units, crank = result.values, units_of(result.system), crank_of(result.scene)
    names = ["cam (rpm)", *["crank (rpm)"] * bool(crank)]

    exact = 4 if result.scene.cam.kind == "table" else 6  # digits of a speed

    def speed(rpm: float) -> list[str]:
        return [f"{x * rpm:.{exact}g}" for x in (1.0, crank) if x]

    def between(low: float | None, high: float | None) -> str:
        return "" if low is None or high is None else f"{low:.4g} to {high:.4g}"

    past = [
        [*speed(s.rpm), _cell(x.max_gap_m, units.per_m), _cell(x.max_impact_m_per_s),
         _cell(x.landing_deg, digits=4), _cell(x.landing_lift_m, units.per_m),
         _cell(x.shut_bounces_per_turn), between(x.min_contact_force_n, x.max_contact_force_n)]
        for s in found.past
        for x in (s.loads,)
    ]  # fmt: skip
    columns = f"loft ({units.length}), lands (m/s), at (deg), at lift ({units.length})"
    columns += ", bounces, force (N)"
    forces = [
        [*speed(f.rpm), _cell(f.lowest_n if abs(f.lowest_n) > ROUNDING else 0.0, digits=4),
         _cell(f.lowest_deg, digits=4), _cell(f.highest(f.force_n)[0], digits=4),
         *([_cell(f.highest(f.pressure_pa)[0], 1e-6)] if f.pressure_pa else [])]
        for f in found.forces
    ]  # fmt: skip
    pressed = ", Hertz (MPa)" if found.forces and found.forces[0].pressure_pa else ""
    springs = [
        [WAYS[h.quantity], _cell(h.stiffness, 1.0 / units.per_m, 4), _cell(h.preload, digits=4),
         _cell(h.nose_n, digits=4),
         "never" if h.detaches_rpm == inf else _cell(h.detaches_rpm, digits=exact), h.status]
        for h in found.holds
        if h.stiffness is not None
    ]  # fmt: skip
    for title, heads, rows in (
        ("Past the loss of contact", [*names, *columns.split(", ")], past),
        ("Contact force if the follower is kept on the cam",
         [*names, *f"least (N), at (deg), largest (N){pressed}".split(", ")], forces),
        ("Springs that hold contact",
         ["spring", *f"rate ({units.stiffness}), preload (N), at full lift (N)"
          ", holds to (rpm), status".split(", ")], springs),
    ):  # fmt: skip
        if rows:
            table(title, heads, rows)


def _show_theory(found: ContactLoss) -> None:
    """Critical speeds, corner hits and bursts."""
    from camcli.cli.report import table
    from camcli.output.detach import burst_ranges

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
        [str(h.impact), h.corner, f"{h.rpm:.9f}", f"{h.high - h.low:.1e}", h.status]
        for h in found.hits
    ]
    bursts = [
        [text, f"{low:.10g}", f"{high:.10g}", str(n)] for text, low, high, n in burst_ranges(found)
    ]
    for title, columns, rows in (
        ("Critical speeds", "speed, region, theta (deg), rpm, bracket, status", critical),
        ("Impacts on corners", "impact, corner, rpm, bracket (rpm), status", hits),
        ("Bursts after settling", "chattering, from (rpm), to (rpm), speeds", bursts),
    ):
        if rows:
            table(title, columns.split(", "), rows)


def _name(c: CriticalSpeed) -> str:
    name = c.quantity.replace("_", " ")
    return "accumulates at" if name.startswith("accumulation") else name


def _cell(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    return "" if value is None else f"{value * scale:.{digits}g}"
