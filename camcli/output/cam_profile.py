"""profile.csv: the cam over one turn."""

from __future__ import annotations

from collections.abc import Iterator

from camcli.analysis.cam_profile import Profile
from camcli.output.tables import header, mixed_rows
from camcli.system import System, omega_of

PROFILE = (
    "theta_deg",
    "c_m",
    "c_theta_m_per_rad",
    "c_thetatheta_m_per_rad2",
    "force_n",
)


def profile_csv(system: System, profile: Profile) -> Iterator[str]:
    """profile.csv: a row per phase, two at a corner, left side first."""
    f, omega = system.follower, omega_of(profile.force.rpm)
    yield header(PROFILE)
    for theta, c, c1, c2 in zip(profile.theta_deg, profile.c, profile.c1, profile.c2, strict=True):
        spring = f.mass * f.gravity + f.preload + f.stiffness * c
        force = spring + omega * (f.damping * c1 + f.mass * (omega * c2))
        yield from mixed_rows([(theta, c, c1, c2, force)])
