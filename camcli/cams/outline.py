"""The cam as a body, for drawings: its outline in its own frame, and where a follower touches it.

A follower on a line through the axis touches with a knife edge, so that the outline is the polar
curve R(theta) = base_radius + c(theta) - lowest c; an eccentric turns under a flat face and is a
circle about a point beside the axis. A cam whose base radius nobody has told is drawn with one.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

from camcli.cams.compile import column
from camcli.cams.regions import corner_list
from camcli.kernel.cam_table import TURN, Cam, lift, stretch_at

DRAWN = 1.5  # base radius of a drawing in lifts, where the scene has none


@dataclass(frozen=True)
class Outline:
    """Points of the outline (m), closed, counted by the cam angle from the x axis.

    The body is turned by -theta and a quarter turn to stand under an upright follower, whose face
    (`flat` or a knife edge) is at the height q + rise above the axis.
    """

    x: list[float]
    y: list[float]
    rise: float  # m, from q to the height above the axis
    base_radius: float  # m
    told: bool  # False where base_radius is only that of the drawing
    flat: bool
    corners: dict[str, tuple[float, float, float]]  # name -> x, y (m) and phase (rad)


def outline(cam: Cam, kind: str, base_radius: float | None = None, points: int = 720) -> Outline:
    """The outline of a cam of one of the scene's kinds; `points` beside those at its corners."""
    places = {corner.theta: corner.name for corner in corner_list(cam)}
    angles = sorted({TURN * k / points for k in range(points)} | set(places))
    c = [lift(cam, stretch_at(cam, theta), theta)[0] for theta in angles]
    low, high = min(column(cam, "start_c") + c), max(column(cam, "start_c") + c)
    radius = DRAWN * (high - low) if base_radius is None else base_radius
    flat = kind == "eccentric"
    if flat:
        beside = (high - low) / 2.0  # the centre, towards the phase of the highest c
        reach = [(radius * cos(a) - beside, radius * sin(a)) for a in angles]
        rise = radius - beside - low
    else:
        rise = radius - low
        reach = [((q + rise) * cos(a), (q + rise) * sin(a)) for a, q in zip(angles, c, strict=True)]
    named = zip(angles, reach, strict=True)
    return Outline(
        x=[x for x, _ in reach],
        y=[y for _, y in reach],
        rise=rise,
        base_radius=radius,
        told=base_radius is not None,
        flat=flat,
        corners={places[a]: (*point, a) for a, point in named if a in places},
    )
