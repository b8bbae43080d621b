"""What `cam orbits --help` says, and the options of this command alone."""

from __future__ import annotations

from typing import Annotated

import typer

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
