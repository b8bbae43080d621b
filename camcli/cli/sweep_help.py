"""What `cam simulate --help` and `cam sweep --help` say, and the options of sweep alone."""

from __future__ import annotations

from typing import Annotated

import typer

LABELS_HELP = """
\b
Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a complete
chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64 turns fits;
undecided: the record holds too few impacts to tell. A label is what the record shows: a long cycle
through inf may be one that rounding has closed (near 358 rpm); cam classify tells.
Status: ok; impact-budget, no-return, unresolved: the record ends early, exit code 3.
"""

SIMULATE_HELP = (
    """Time response of one orbit: exact events and a sampled trajectory.

\b
trajectory.csv  t_s, theta_deg, q_m, v_m_per_s, c_m, c_dot_m_per_s, contact (flight, sticking)
events.csv      t_s, period, theta_deg, event, q_m, u_minus_m_per_s, u_plus_m_per_s
simulate.png    position, relative position and relative phase plane of the last turns

\b
Events: impact; chatter (impacts have accumulated, the follower now sticks); detachment.
An impact has two rows in trajectory.csv, just before and just after. t_s counts from the
first recorded turn (run.transient), period from the strobe phase; a start off the strobe phase
without transient records the turn's rest before the first strobe as period -1.
"""
    + LABELS_HELP
)

SWEEP_HELP = (
    """Brute-force bifurcation diagram over a range of speeds.

\b
impacts.csv  rpm, period, theta_deg, q_m, u_minus_m_per_s
strobe.csv   rpm, period, q_m, v_m_per_s, impacts, chatter: the state at the start of each
             recorded period, impacts in it and whether a complete chatter ended in it (0 or 1)
speeds.csv   rpm, label, impacts, lyapunov_per_period, status
corners.csv  corner impacts of the solved branches (--explain), columns as bifurcations.csv
sweep.tables: npz writes impacts.npz and strobe.npz instead (numpy.load), none neither of them
sweep.png    impact phases beside the cam's c, c', c''; stroboscopic positions

\b
In speeds.csv, impacts counts the recorded turns. sweep.direction up or down carries the state from
speed to speed in that order; fixed starts each speed alike and keeps the order of the range.
--lyapunov fills lyapunov_per_period: largest exponent, -inf where the follower rests, else empty.
--explain gives every change its cause as cam classify does, numbered in sweep.png; direction fixed.
"""
    + LABELS_HELP
)

MANY = {
    "shard": (
        Annotated[
            str | None,
            typer.Option("--shard", help="Only part I of N; cam merge joins them.", metavar="I/N"),
        ],
        None,
    ),
    "cluster": (
        Annotated[
            str | None,
            typer.Option(
                "--cluster", help="Dask scheduler HOST:PORT, or local.", metavar="ADDRESS"
            ),
        ],
        None,
    ),
}

SWEEP_OPTIONS = MANY | {
    name: (Annotated[bool, typer.Option(f"--{name}", help=text)], False)
    for name, text in (
        ("lyapunov", "Measure the largest exponent at each speed."),
        ("explain", "Find the cause of every change."),
    )
}
