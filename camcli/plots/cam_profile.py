"""Picture of the cam: lift, derivatives, contact force and curvature over one turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.cam_profile import Curvature, Profile
from camcli.plots import style
from camcli.plots.force import draw_forces, newtons

LEFT, RIGHT, TOP, BOTTOM = 145, 25, 140, 85  # px, margins
PANEL, GAP = 262, 46  # px, height of a panel and the distance to the next
BELOW = 165  # px, above the two panels of curvature
HALF = 520  # px, width of these
CAPTION = {"loc": "right", "fontsize": 8, "pad": 3, "color": style.CAM}
TICKS = range(0, 361, 30)
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
    tops = {name: TOP + k * (PANEL + GAP) for k, name in enumerate(over_turn)}
    below = TOP + len(over_turn) * (PANEL + GAP) - GAP
    bent = below + BELOW
    height = (bent + PANEL if CURVATURE in panels else below) + BOTTOM
    wide = style.WIDTH - LEFT - RIGHT
    figure = style.page(height)
    style.write(figure, 20, 14, _title(profile), size=9, weight="bold")
    style.write(figure, 20, 50, _second_line(profile), color=style.CAM)
    drawn = []
    for name, top in tops.items():
        axes = style.place(figure, LEFT, top, wide, PANEL)
        DRAW[name](axes, profile, measured)
        _turn(axes, profile, name == over_turn[-1], name == over_turn[0])
        drawn.append(axes)
    _legend(figure, *drawn)
    if CURVATURE in panels:
        _curvatures(figure, profile, bent)
    return figure


def _title(profile: Profile) -> str:
    low, high = profile.ranges["c"]
    return f"Cam with a lift of {1e3 * (high.value - low.value):.4g} mm"


def _second_line(profile: Profile) -> str:
    if profile.first is None or not profile.first.finite:
        return "no speed marks a first detachment"
    first = profile.first
    return f"first detachment at {first.rpm:.6g} rpm, {first.theta_deg:.5g} deg"


def _curve(axes: Axes, profile: Profile, values, label: str, color: str = style.CAM) -> None:
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.plot(profile.theta_deg, values, color=color)
    axes.set_ylabel(label)


def _lift(axes: Axes, profile: Profile, measured: Measured | None) -> None:
    axes.plot(profile.theta_deg, profile.c, color=style.CAM, label="cam")
    axes.set_ylabel("$c$ (m)")
    if measured is not None:
        look = {"linestyle": "", "marker": ".", "markersize": 2.0, "zorder": 3}
        axes.plot(
            measured.theta_deg, measured.c, color=style.MEASURED, label="rows of the table", **look
        )
    low, high = profile.ranges["c"]
    room = high.value - low.value or abs(high.value) or 1.0
    axes.set_ylim(low.value - 0.06 * room, high.value + 0.22 * room)


def _slope(axes: Axes, profile: Profile, _: Measured | None) -> None:
    _curve(axes, profile, profile.c1, "$c_\\theta$ (m/rad)")


def _accel(axes: Axes, profile: Profile, measured: Measured | None) -> None:
    _curve(axes, profile, profile.c2, r"$c_{\theta\theta}$ (m/rad²)")
    if measured is None:
        return
    axes.set_title(measured.words, **CAPTION)
    count = len(measured.bounds)
    share = (np.asarray(profile.theta_deg) / 360.0 * count).astype(int)
    bound = np.asarray(measured.bounds)[np.minimum(share, count - 1)]
    c2 = np.asarray(profile.c2)
    axes.fill_between(
        profile.theta_deg, c2 - bound, c2 + bound, color=style.DOUBT, linewidth=0, zorder=0.4,
        label="bound on its error",
    )  # fmt: skip


def _force(axes: Axes, profile: Profile, _: Measured | None) -> None:
    force = profile.force
    draw_forces(axes, [force])
    words = f"at {style.number(force.rpm)} rpm, least {newtons(force.lowest_n, 4)}"
    axes.set_title(words, **CAPTION)


DRAW = {"lift": _lift, "velocity": _slope, "acceleration": _accel, "force": _force}


def _turn(axes: Axes, profile: Profile, labelled: bool, named: bool) -> None:
    """The axis of phases, and the corners as dotted lines."""
    axes.set_xlim(0.0, 360.0)
    axes.set_xticks(TICKS, [str(tick) for tick in TICKS] if labelled else [])
    if labelled:
        axes.set_xlabel(r"cam angle $\theta$ (deg)")
    names = sorted(profile.corners, key=profile.corners.__getitem__)
    if len(names) > 26:
        return
    dots = {"color": style.GUIDE, "linewidth": 0.6, "linestyle": (0, (1, 2)), "zorder": 0.5}
    for name in names:
        axes.axvline(profile.corners[name], **dots)
    if not named:
        return
    places = style.spread([profile.corners[name] for name in names], 5.0, 2.0, 358.0)
    for name, place in zip(names, places, strict=True):
        text = {"ha": "center", "va": "top", "color": style.CAM}
        axes.text(place, 0.97, name, transform=axes.get_xaxis_transform(), **text)


def _legend(figure: Figure, *panels: Axes) -> None:
    handles, names = [], []
    for axes in panels:
        some, words = axes.get_legend_handles_labels()
        handles, names = handles + some, names + words
    if len(names) < 2:
        return
    tight = {"borderaxespad": 0.0, "columnspacing": 1.5, "handletextpad": 0.5, "handlelength": 1.6}
    above = 1.0 - (TOP - 58) / round(figure.get_figheight() * style.DPI)
    figure.legend(
        handles, names, loc="upper left", bbox_to_anchor=(20 / style.WIDTH, above),
        ncol=len(names), borderpad=0.0, **tight,
    )  # fmt: skip


def _curvatures(figure: Figure, profile: Profile, top: float) -> None:
    bent = profile.curvature
    right = style.WIDTH - RIGHT - HALF
    flat = style.place(figure, LEFT, top, HALF, PANEL)
    knife = style.place(figure, right, top, HALF, PANEL)
    for axes in (flat, knife):
        _turn(axes, profile, True, False)
        axes.set_xticks(range(0, 361, 60))
    _flat(figure, flat, profile, bent, top)
    words = "knife edge, roller: curvature of the pitch curve (1/m)"
    style.write(figure, right - 75, top - 64, words, color=style.CAM)
    if bent.knife is None:
        knife.set_yticks([])
        style.note(knife, "unknown without the base radius\n(--base-radius)")
        return
    _curve(knife, profile, bent.knife, "")
    if bent.roller is not None:
        knife.set_title(f"largest roller {bent.roller.value:.4g} m", **CAPTION)


def _flat(figure: Figure, axes: Axes, profile: Profile, bent: Curvature, top: float) -> None:
    less = "" if bent.base_radius is not None else " less the base radius"
    words = f"flat face: radius of curvature{less} (m)"
    style.write(figure, LEFT - 125, top - 64, words, color=style.CAM)
    _curve(axes, profile, bent.flat, "", style.TROUBLE if bent.undercut else style.CAM)
    text = f"needs a base radius above {bent.least_base_radius:.4g} m"
    look = {**CAPTION, "color": style.TROUBLE if bent.undercut else style.CAM}
    axes.set_title(f"undercut: {text}" if bent.undercut else text, **look)
