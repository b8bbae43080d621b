"""The `cam` application. Nothing heavy is imported before a command is chosen."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from camcli.cli.basins_help import BASINS_HELP, BASINS_OPTIONS
from camcli.cli.bench_help import BENCH_HELP, BENCH_OPTIONS
from camcli.cli.classify_help import CLASSIFY_HELP, CLASSIFY_OPTIONS
from camcli.cli.figures_help import FIGURES_HELP, FIGURES_OPTIONS, WITHOUT
from camcli.cli.options import Request, command
from camcli.cli.profile_help import PROFILE_HELP, PROFILE_OPTIONS

app = typer.Typer(
    name="cam",
    help="Bifurcations of a cam and a follower that can lift off, bounce, chatter and come back.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

LABELS_HELP = """
\b
Labels: P(m;s1:...:sm), an orbit of m turns with s_i impacts in its i-th turn (inf: a complete
chatter); contact: the follower never leaves the cam; aperiodic: no period up to 64 turns fits;
undecided: the record holds too few impacts to tell.
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
sweep.png    impact phases beside the cam's c, c', c''; stroboscopic positions

\b
In speeds.csv, impacts counts the recorded turns. sweep.direction up or down carries the state from
speed to speed in that order; fixed starts each speed alike and keeps the order of the range.
--lyapunov fills lyapunov_per_period: largest exponent, -inf where the follower rests, else empty.
--explain gives every change its cause as cam classify does, numbered in sweep.png; direction fixed.
"""
    + LABELS_HELP
)

DETACH_HELP = """Where contact is lost, where chattering ends, and which spring would hold.

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
accumulation_at_corner  a burst ends exactly on the corner `region`; looked for between the speeds
                        of the range (--points), from rest at each lift-off
completion_loss         its end reaches, one turn later, the phase of the next lift-off
hold_stiffness, hold_preload, hold_both
                        first detachment with the spring that --hold-to found (in run.json)

\b
Every critical speed has a bracket and a status in run.json: ok; never; at-standstill; jump (the
end of the chatter jumps over a corner); unresolved, exit code 3. A curve of corner hits may end
where its impact ceases to exist: run.json says where.
"""

ORBITS_HELP = """Periodic orbits: found, solved, followed, and every bifurcation on the way.

\b
branch.csv        branch, label, rpm, stable (0 or 1), region, theta_deg_1.. (impacts; of an orbit
                  that rests: departures), q_m, v_m_per_s at the strobe, multiplier_1_re, ...,
                  trace, det; a point per row in the order of the branch
bifurcations.csv  branch, label, kind, rpm, rpm_error, corner, trace_left, det_left, trace_right,
                  det_right, classification
curve.csv         with --curve: a bifurcation in two parameters; curve.png its picture
orbits.png        branches, multipliers, corner impacts

\b
--rpm X       the orbits at one speed; --rpm LO:HI follows them through the range, both ways
--at X        where they are found; from the scene's start, a cloud of starts and, with one impact,
              from the closed equation, which gives all of them
--label L     only this orbit, 'P(3;3:3:2)'; an unstable one is looked for among close returns
--parameter   restitution, damping, gravity, stiffness, preload or mass instead of rpm, over --range
--branches N  how many branches that leave from bifurcations are followed too
--curve KIND  continue the located bifurcations of a kind in rpm and --in PARAMETER over --range

\b
Kinds: period-doubling (1 + trace + det = 0); fold (the parameter turns round); corner-impact (an
impact reaches a corner of the cam); grazing (a contact appears in a flight, or an impact fades);
for orbits that rest: chatter-completion, departure (a departure from rest appears or vanishes),
itinerary (an impact appears, fades or moves to another turn), detachment (contact is first lost).
A branch ends at one of these, or at end-of-range.
Classification of a corner impact, from the traces and determinants on both sides: persistence,
nonsmooth-fold, border-period-doubling, robust-chaos, no-attractor, dangerous, degenerate; run.json
has the inequalities, and what a simulation shows on either side.
A root that penetrates the cam or would pull is virtual: reported in run.json, never as an orbit.
"""

HOLD_TO = Annotated[
    str | None,
    typer.Option("--hold-to", help="Find the spring that holds up to this speed.", metavar="RPM"),
]

SWEEP_OPTIONS = {
    name: (Annotated[bool, typer.Option(f"--{name}", help=text)], False)
    for name, text in (
        ("lyapunov", "Measure the largest exponent at each speed."),
        ("explain", "Find the cause of every change."),
    )
}

ORBITS_OPTIONS = {
    name: (Annotated[kind | None, typer.Option(*words, help=text, metavar=metavar)], None)
    for name, kind, words, metavar, text in (
        ("at", str, ("--at",), "RPM", "Speed at which orbits are found."),
        ("label", str, ("--label",), "LABEL", "Only this orbit, e.g. 'P(3;3:3:2)'."),
        ("parameter", str, ("--parameter",), "NAME", "What varies along a branch. Default: rpm."),
        ("range", str, ("--range",), "LO:HI", "Range of --parameter, or of --in."),
        ("branches", int, ("--branches",), "N", "Branches followed that leave from events."),
        ("curve", str, ("--curve",), "KIND", "Continue bifurcations of this kind."),
        ("second", str, ("--in",), "NAME", "Second parameter of --curve."),
    )
}


def _simulate(request: Request) -> int:
    from camcli.cli.simulate import run

    return run(request)


def _sweep(request: Request) -> int:
    from camcli.cli.sweep import run

    return run(request)


def _detach(request: Request) -> int:
    from camcli.cli.detach import run

    return run(request)


def _orbits(request: Request) -> int:
    from camcli.cli.orbits import run

    return run(request)


def _classify(request: Request) -> int:
    from camcli.cli.classify import run

    return run(request)


def _basins(request: Request) -> int:
    from camcli.cli.basins import run

    return run(request)


def _figures(request: Request) -> int:
    from camcli.cli.figures import run

    return run(request)


def _bench(request: Request) -> int:
    from camcli.cli.bench import run

    return run(request)


command(app, "simulate", _simulate, SIMULATE_HELP + PROFILE_HELP, PROFILE_OPTIONS)
command(app, "sweep", _sweep, SWEEP_HELP, SWEEP_OPTIONS)
command(app, "detach", _detach, DETACH_HELP, {"hold_to": (HOLD_TO, None)})
command(app, "orbits", _orbits, ORBITS_HELP, ORBITS_OPTIONS)
command(app, "basins", _basins, BASINS_HELP, BASINS_OPTIONS)
command(app, "classify", _classify, CLASSIFY_HELP, CLASSIFY_OPTIONS)
command(app, "bench", _bench, BENCH_HELP, BENCH_OPTIONS)
command(app, "figures", _figures, FIGURES_HELP, FIGURES_OPTIONS, WITHOUT)


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
