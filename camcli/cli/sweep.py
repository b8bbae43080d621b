"""cam sweep"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from typer import Option

from camcli.cli.options import Cluster, Request, Shard

if TYPE_CHECKING:
    from camcli.api.result import Result

SHOWN = 40  # rows of the table on stdout


def sweep(
    request: Request,
    lyapunov: Annotated[
        bool, Option("--lyapunov", help="Measure the largest exponent at each speed.")
    ] = False,
    explain: Annotated[bool, Option("--explain", help="Find the cause of every change.")] = False,
    shard: Shard = None,
    cluster: Cluster = None,
) -> int:
    """Brute-force bifurcation diagram over a range of speeds.

    \b
    impacts.csv  rpm, period, theta_deg, q_m, u_minus_m_per_s
    strobe.csv   rpm, period, q_m, v_m_per_s, impacts, chatter: the state at the start of each
                 recorded period, impacts in it and whether a complete chatter ended in it
    speeds.csv   rpm, label, impacts, lyapunov_per_period, status
    corners.csv  corner impacts of the solved branches (--explain), columns as bifurcations.csv
    sweep.tables: npz writes impacts.npz and strobe.npz instead (numpy.load); none neither
    sweep.png    impact phases beside the cam's c, c', c''; stroboscopic positions

    \b
    In speeds.csv, impacts counts the recorded turns. sweep.direction up or down carries the
    state from speed to speed in that order; fixed starts every speed alike.
    --lyapunov fills lyapunov_per_period: the largest exponent, -inf where the follower rests.
    --explain gives every change its cause as cam classify does, numbered in sweep.png.

    \b
    Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a
    complete chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64
    turns fits; undecided: too few impacts to tell. A label is what the record shows; near
    358 rpm a long cycle through inf may be an accident of rounding: cam classify tells.
    Status: ok; impact-budget, no-return, unresolved: the record ends early, exit code 3.
    """
    from camcli.cli.run import given, run, speed_range

    values = speed_range(request, "sweep") | given(
        {
            "sweep.lyapunov": (lyapunov, "--lyapunov"),
            "sweep.explain": (explain, "--explain"),
        }
    )
    return run("sweep", request, values, show, shard=shard, cluster=cluster)


def show(result: Result) -> None:
    """Print the ranges of one label, and the explanation if there is one."""
    from camcli.api.sweep import ranges
    from camcli.cli.classify import show_explanation
    from camcli.cli.report import plural, table

    found, explanation = result.values
    groups = ranges(found)
    rows = [
        [label, f"{a.rpm:.10g}", f"{b.rpm:.10g}", str(n), status]
        for label, status, a, b, n in groups
    ]
    title = f"{plural(len(found.speeds), 'speed')}, {plural(len(groups), 'range')} of one label"
    if len(rows) > SHOWN:
        title += f", the first {SHOWN} (all of them in speeds.csv)"
    table(title, ["label", "from (rpm)", "to (rpm)", "speeds", "status"], rows[:SHOWN])
    if explanation is not None:
        show_explanation(explanation)
