"""The `cam` application. Nothing heavy is imported before a command is chosen."""

from __future__ import annotations

import sys

import typer

from camcli.cli.options import Request, command

app = typer.Typer(
    name="cam",
    help="Bifurcations of a cam and a follower that can lift off, bounce, chatter and come back.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

SIMULATE_HELP = """Time response of one orbit: exact events and a sampled trajectory.

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

SWEEP_HELP = """Brute-force bifurcation diagram over a range of speeds.

\b
impacts.csv  rpm, period, theta_deg, q_m, u_minus_m_per_s
strobe.csv   rpm, period, q_m, v_m_per_s, impacts, chatter: the state at the start of each
             recorded period, impacts in it and whether a complete chatter ended in it (0 or 1)
speeds.csv   rpm, label, impacts, lyapunov_per_period, status
sweep.png    impact phases beside the cam's c, c', c''; stroboscopic positions

\b
Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a complete
chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64 fits.
Status: ok; impact-budget, no-return, unresolved: the row ends early, exit code 3.
sweep.direction up or down carries the state from speed to speed, fixed starts each one alike.
"""


def _simulate(request: Request) -> int:
    from camcli.cli.simulate import run

    return run(request)


def _sweep(request: Request) -> int:
    from camcli.cli.sweep import run

    return run(request)


command(app, "simulate", _simulate, SIMULATE_HELP)
command(app, "sweep", _sweep, SWEEP_HELP)


@app.command("schema", help="Print the scene's JSON Schema, for editors.")
def schema() -> None:
    """cam schema"""
    import json

    from camcli.scene import json_schema

    print(json.dumps(json_schema(), indent=2))


def main() -> None:
    """Run `cam`, turning every failure into words and an exit code."""
    from camcli.cli.panel import guarded

    sys.exit(guarded(lambda: app(standalone_mode=False)))
