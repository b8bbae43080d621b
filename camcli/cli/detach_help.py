"""What `cam detach --help` says, and the options of this command alone."""

from __future__ import annotations

from typing import Annotated

import typer

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

HOLD_TO = Annotated[
    str | None,
    typer.Option("--hold-to", help="Find the spring that holds up to this speed.", metavar="RPM"),
]

DETACH_OPTIONS = {"hold_to": (HOLD_TO, None)}
