"""Picture of the periodic orbits of one speed: impacts on the cam, states, multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import OrbitsResult
from camcli.plots import style
from camcli.plots.axes import lift_curves, padded, spread
from camcli.plots.multipliers import draw_plane
from camcli.plots.orbit_lines import colours, phases, radius
from camcli.plots.orbit_zoom import pair
from camcli.system import System

LEFT, RIGHT, BOTTOM = 140, 60, 95  # px, margins
HEAD, LIFT, GAP, PLANE = 96, 270, 30, 480  # px
WIDE = style.WIDTH - LEFT - RIGHT
MOST = 16  # orbits listed
CURVES = ((r"$c$ (m)"), (r"$c_\theta$ (m/rad)"), (r"$c_{\theta\theta}$ (m/rad²)"))
COLUMNS = (20, 60, 340, 480, 760)  # px: mark, label, stability, multipliers, phases


@style.look()
def draw_single(study: OrbitsResult, system: System, heading) -> Figure:
    """Picture of a study without branches."""
    listed = min(len(study.orbits), MOST + 1)
    top = HEAD + style.LINE * (listed + 1 if listed else 0) + 50
    height = top + (LIFT + GAP) * len(CURVES) - GAP + 130 + PLANE + BOTTOM
    if not study.orbits:
        height = HEAD + 260
    figure = style.page(height)
    for line, (words, look) in enumerate(heading):
        style.write(figure, 20, 14 + 40 * line, words, **look)
    if not study.orbits:
        axes = style.place(figure, LEFT, HEAD + 20, WIDE, 200, xticks=[], yticks=[])
        style.note(axes, _nothing(study))
        return figure
    shades = colours([[orbit] for orbit in study.orbits])
    _list(figure, study.orbits, shades)
    _draw_cam(figure, top, study.orbits, shades, system)
    top += (LIFT + GAP) * len(CURVES) - GAP + 130
    _draw_states(style.place(figure, LEFT, top, PLANE, PLANE), study.orbits, shades, system)
    left = style.WIDTH - RIGHT - PLANE
    axes = style.place(figure, left, top, PLANE, PLANE)
    _draw_multipliers(axes, study.orbits, shades)
    return figure


def _nothing(study: OrbitsResult) -> str:
    absent = study.absent
    if absent is None:
        return "no periodic orbit was found"
    label = style.motion(study.question.label or "orbit")
    if absent.nearest is None:
        ends = f"{style.number(absent.low)} to {style.number(absent.high)}"
        return f"no {label} was found from {ends} rpm"
    speed, end = absent.nearest
    return f"no {label} here; it exists up to {speed:.9g} rpm: {end.replace('-', ' ')}"


def _list(figure: Figure, orbits: Sequence[PeriodicOrbit], shades: Sequence[str]) -> None:
    """A row per orbit: its mark, label, verdict, multipliers and phases."""
    height = style.LINE * (min(len(orbits), MOST + 1) + 1)
    axes = style.place(figure, 0, HEAD, style.WIDTH, height, frame_on=False)
    axes.set(xlim=(0, style.WIDTH), ylim=(height, 0), xticks=[], yticks=[])
    heads = ("", "orbit", "", r"multipliers $\mu$", "phases (deg)")
    _row(axes, 0, heads, color=style.CAM)
    for row, (orbit, shade) in enumerate(zip(orbits, shades, strict=True), 1):
        if row > MOST:
            _row(axes, row, ("", f"and {len(orbits) - MOST} more, in the tables", "", "", ""))
            break
        _dots(axes, [COLUMNS[0] + 12], [(row + 0.5) * style.LINE], orbit, shade)
        _row(axes, row, _cells(orbit))


def _row(axes: Axes, row: int, cells: Sequence[str], **look) -> None:
    for left, words in zip(COLUMNS, cells, strict=True):
        axes.text(left, (row + 0.5) * style.LINE, words, va="center_baseline", **look)


def _cells(orbit: PeriodicOrbit) -> tuple[str, ...]:
    at = [f"{phase:.2f}" for phase in phases(orbit)]
    shown = ", ".join(at if len(at) <= 6 else [*at[:5], "…"])
    return (
        "",
        style.motion(orbit.label, 22),
        "stable" if orbit.stable else "unstable",
        pair(orbit.trace, orbit.det),
        f"leaves at {shown}" if orbit.resting and at else shown,
    )


def _dots(axes: Axes, x, y, orbit: PeriodicOrbit, shade: str, size: float = 5.0) -> None:
    """Stable orbits filled, unstable ones open."""
    look = {"markersize": size, "markeredgewidth": 1.1, "linestyle": "", "zorder": 5}
    face = shade if orbit.stable else "white"
    axes.plot(x, y, "o", markeredgecolor=shade, markerfacecolor=face, **look)


def _draw_cam(
    figure: Figure, top: int, orbits: Sequence[PeriodicOrbit], shades, system: System
) -> None:
    """The cam's lift and its derivatives over the turn with the impacts on them."""
    theta, orders = lift_curves(system.cam, len(CURVES))
    for k, name in enumerate(CURVES):
        axes = style.place(figure, LEFT, top + k * (LIFT + GAP), WIDE, LIFT)
        axes.plot(theta, orders[k], color=style.CAM, linewidth=0.9, zorder=2)
        axes.margins(y=0.1)
        for orbit, shade in zip(orbits, shades, strict=True):
            at = phases(orbit)
            _dots(axes, at, [_height(theta, orders[k], phase) for phase in at], orbit, shade)
            look = {"linewidth": 0.7, "linestyle": "-" if orbit.stable else (0, (3.2, 1.6))}
            for phase in at:
                axes.axvline(phase, color=shade, alpha=0.6, zorder=1, **look)
        axes.set(xlim=(0.0, 360.0), ylabel=name, xticks=range(0, 361, 30))
        axes.tick_params(labelbottom=k == len(CURVES) - 1)
        _corner_lines(axes, system, k == 0)
    axes.set_xlabel(r"cam angle $\theta$ (deg)")


def _height(theta: np.ndarray, values: np.ndarray, phase: float) -> float:
    """The curve at a phase; on a corner, either side's value."""
    good = np.isfinite(theta)
    return float(np.interp(phase, theta[good], values[good]))


def _corner_lines(axes: Axes, system: System, named: bool) -> None:
    corners = style.corner_names(system.corners_deg)
    places = spread(list(corners.values()), 0.018 * 360.0, 0.0, 360.0)
    for (name, phase), place in zip(corners.items(), places, strict=True):
        dots = {"linewidth": 0.6, "linestyle": (0, (1, 2)), "zorder": 0.5}
        axes.axvline(phase, color=style.GUIDE, **dots)
        if named:
            text = {"ha": "center", "va": "bottom", "color": style.CAM}
            axes.text(place, 1.02, name, transform=axes.get_xaxis_transform(), **text)


def _draw_states(axes: Axes, orbits: Sequence[PeriodicOrbit], shades, system: System) -> None:
    """The orbits as points of the stroboscopic map."""
    for orbit, shade in zip(orbits, shades, strict=True):
        _dots(axes, *zip(*orbit.states, strict=True), orbit, shade)
    for values, limit in zip(_columns(orbits), (axes.set_xlim, axes.set_ylim), strict=True):
        low, high = padded(values, 0.5 * abs(values).max() or 1.0)
        limit(low - 0.1 * (high - low), high + 0.1 * (high - low))
    axes.locator_params(nbins=5)
    phase = style.number(round(degrees(system.strobe), 9))
    axes.set_xlabel(rf"stroboscopic $q$ (m), $\theta$ = {phase} deg")
    axes.set_ylabel(r"stroboscopic $q_\theta$ (m/rad)")


def _columns(orbits: Sequence[PeriodicOrbit]) -> np.ndarray:
    """All positions, and all rates."""
    return np.array([state for orbit in orbits for state in orbit.states]).T


def _draw_multipliers(axes: Axes, orbits: Sequence[PeriodicOrbit], shades) -> None:
    draw_plane(axes, max(radius(orbit) for orbit in orbits))
    for orbit, shade in zip(orbits, shades, strict=True):
        pairs = [(mu.real, mu.imag) for mu in orbit.multipliers]
        _dots(axes, *zip(*pairs, strict=True), orbit, shade)
