"""Picture of the cam: lift, derivatives, contact force and curvature over one turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.cam_profile import Profile
from camcli.plots import style
from camcli.plots.axes import TURN_DEG, corners_across, draw_forces, legend, newtons

LEFT, RIGHT, TOP, BOTTOM = 145, 25, 140, 85  # px, margins
PANEL, GAP = 262, 46  # px, height of a panel and the distance to the next
BELOW = 165  # px, above the two panels of curvature
HALF = 520  # px, width of these
CURVATURE = "curvature"
PANELS = ("lift", "velocity", "acceleration", "force", CURVATURE)  # from top to bottom


@dataclass(frozen=True)
class Measured:
    """A measured table: its rows, and the bound on c_thetatheta in equal shares of the turn."""

    theta_deg: Sequence[float]
    c: Sequence[float]
    bounds: Sequence[float]
    words: str


@style.look()
def draw_profile(
    profile: Profile, measured: Measured | None = None, panels: Sequence[str] = PANELS
) -> Figure:
    """Picture of a cam; `panels` are some of PANELS."""
    over_turn = [name for name in PANELS if name in panels and name != CURVATURE]
    below = TOP + len(over_turn) * (PANEL + GAP) - GAP
    height = (below + BELOW + PANEL if CURVATURE in panels else below) + BOTTOM
    low, high = profile.ranges["c"]
    title = f"Cam with a lift of {1e3 * (high.value - low.value):.4g} mm"
    figure = style.page(height, title, _first_detachment(profile), style.CAM)
    handles: list[Any] = []
    names: list[str] = []
    for k, name in enumerate(over_turn):
        wide = style.WIDTH - LEFT - RIGHT
        axes = style.place(figure, LEFT, TOP + k * (PANEL + GAP), wide, PANEL)
        DRAW[name](axes, profile, measured)
        _turn(axes, profile, 30, labelled=name == over_turn[-1], named=k == 0)
        some, words = axes.get_legend_handles_labels()
        handles, names = handles + some, names + words
    if len(names) > 1:
        legend(figure, TOP - 54, handles, names, len(names))
    if CURVATURE in panels:
        _draw_curvatures(figure, profile, below + BELOW)
    return figure


def _first_detachment(profile: Profile) -> str:
    if profile.first is None or not profile.first.finite:
        return "no speed marks a first detachment"
    first = profile.first
    return f"first detachment at {first.rpm:.6g} rpm, {first.theta_deg:.5g} deg"


def _turn(
    axes: Axes, profile: Profile, step: int, labelled: bool = True, named: bool = False
) -> None:
    """The axis of phases, and the corners as dotted lines."""
    axes.set(xlim=(0.0, TURN_DEG), xticks=range(0, 361, step))
    axes.tick_params(labelbottom=labelled)
    if labelled:
        axes.set_xlabel(r"cam angle $\theta$ (deg)")
    if len(profile.corners) <= style.MOST_CORNERS:
        corners_across(axes, profile.corners.items(), named, inside=True)


def _caption(axes: Axes, words: str, colour: str = style.CAM) -> None:
    axes.set_title(words, loc="right", fontsize=8, pad=3, color=colour)


def _curve(axes: Axes, profile: Profile, values: Sequence[float], colour: str = style.CAM) -> None:
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.plot(profile.theta_deg, values, color=colour)


def _draw_lift(axes: Axes, profile: Profile, measured: Measured | None) -> None:
    axes.plot(profile.theta_deg, profile.c, color=style.CAM, label="cam")
    axes.set_ylabel("$c$ (m)")
    if measured is not None:
        theta, rows = measured.theta_deg, "rows of the table"
        axes.plot(theta, measured.c, ".", color=style.MEASURED, ms=2.0, zorder=3, label=rows)
    low, high = profile.ranges["c"]
    room = high.value - low.value or abs(high.value) or 1.0
    axes.set_ylim(low.value - 0.06 * room, high.value + 0.22 * room)


def _draw_slope(axes: Axes, profile: Profile, _: Measured | None) -> None:
    _curve(axes, profile, profile.c1)
    axes.set_ylabel("$c_\\theta$ (m/rad)")


def _draw_acceleration(axes: Axes, profile: Profile, measured: Measured | None) -> None:
    _curve(axes, profile, profile.c2)
    axes.set_ylabel(r"$c_{\theta\theta}$ (m/rad²)")
    if measured is None:
        return
    _caption(axes, measured.words)
    count = len(measured.bounds)
    share = (np.asarray(profile.theta_deg) / TURN_DEG * count).astype(int)
    bound = np.asarray(measured.bounds)[np.minimum(share, count - 1)]
    c2 = np.asarray(profile.c2)
    band: dict[str, Any] = {"color": style.DOUBT, "lw": 0, "label": "bound on its error"}
    axes.fill_between(profile.theta_deg, c2 - bound, c2 + bound, zorder=0.4, **band)


def _draw_force(axes: Axes, profile: Profile, _: Measured | None) -> None:
    force = profile.force
    draw_forces(axes, [force])
    _caption(axes, f"at {style.number(force.rpm)} rpm, least {newtons(force.lowest_n, 4)}")


DRAW = {
    "lift": _draw_lift,
    "velocity": _draw_slope,
    "acceleration": _draw_acceleration,
    "force": _draw_force,
}


def _draw_curvatures(figure: Figure, profile: Profile, top: float) -> None:
    """What a flat face sees of the cam, and what a knife edge or a roller sees."""
    bent, right = profile.curvature, style.WIDTH - RIGHT - HALF
    less = "" if bent.base_radius is not None else " less the base radius"
    heads = (
        (LEFT - 125, f"flat face: radius of curvature{less} (m)"),
        (right - 75, "knife edge, roller: curvature of the pitch curve (1/m)"),
    )
    for left, words in heads:
        style.write(figure, left, top - 64, words, color=style.CAM)
    flat, knife = (style.place(figure, left, top, HALF, PANEL) for left in (LEFT, right))
    for axes in (flat, knife):
        _turn(axes, profile, 60)
    colour = style.TROUBLE if bent.undercut else style.CAM
    _curve(flat, profile, bent.flat, colour)
    needs = f"needs a base radius above {bent.least_base_radius:.4g} m"
    _caption(flat, f"undercut: {needs}" if bent.undercut else needs, colour)
    if bent.knife is None:
        knife.set_yticks([])
        style.note(knife, "unknown without the base radius\n(--base-radius)")
        return
    _curve(knife, profile, bent.knife)
    if bent.roller is not None:
        _caption(knife, f"largest roller {bent.roller.value:.4g} m")
