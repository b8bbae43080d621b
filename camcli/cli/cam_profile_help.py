"""What `cam simulate --help` says about --profile-only, and its options."""

from typing import Annotated

import typer

PROFILE_HELP = """
\b
--profile-only writes and draws the cam instead of a simulation:
profile.csv  theta_deg, c_m, c_theta_m_per_rad, c_thetatheta_m_per_rad2, and the contact force at
             the speed, force_n; two rows at a corner, left side first
profile.png  c and its derivatives, contact force, radius of curvature, with the corners named
Curvature assumes a follower that moves along a line through the axis: at base_radius + c minus the
lowest c from it. base_radius is the cam's, or that of --base-radius.
"""

PROFILE_OPTIONS = {
    "profile_only": (
        Annotated[
            bool, typer.Option("--profile-only", help="Write and draw the cam, simulate nothing.")
        ],
        False,
    ),
    "base_radius": (
        Annotated[
            float | None,
            typer.Option("--base-radius", help="Radius of the base circle, m.", metavar="M"),
        ],
        None,
    ),
}
