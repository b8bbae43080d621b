"""Picture of the periodic orbits of one speed: impacts on the cam, states, multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import OrbitsResult
from camcli.plots import style
from camcli.plots.axes import (
    DASHED,
    TURN_DEG,
    at_strobe,
    corners_across,
    lift_curves,
    padded,
    row_middle,
    text_row,
    text_rows,
)
from camcli.plots.multipliers import draw_plane, pair
from camcli.plots.orbit_lines import colours, phases, radius
from camcli.plots.style import BOTTOM, LEFT, RIGHT, WIDE
from camcli.system import System

HEAD, LIFT, GAP, PLANE = 96, 270, 30, 480  # px
MOST = 16  # orbits listed
CURVES = (r"$c$ (m)", r"$c_\theta$ (m/rad)", r"$c_{\theta\theta}$ (m/rad²)")
COLUMNS = (60, 340, 480, 760)  # px: label, stability, multipliers, phases
DOT = 32  # px, of an orbit in the list


def draw_single(study: OrbitsResult, system: System, title: str, words: str) -> Figure:
    """Picture of a study without branches; part of draw_orbits, which makes the heading."""
    orbits = study.orbits
    if not orbits:
        figure = style.page(HEAD + 260, title, words)
        axes = style.place(figure, LEFT, HEAD + 20, WIDE, 200, xticks=[], yticks=[])
        style.note(axes, _nothing(study))
        return figure
    top = HEAD + style.LINE * (min(len(orbits), MOST + 1) + 1) + 50
    below = top + (LIFT + GAP) * len(CURVES) - GAP + 130
    figure = style.page(below + PLANE + BOTTOM, title, words)
    shades = colours([[orbit] for orbit in orbits])
    _draw_list(figure, orbits, shades)
    _draw_impacts(figure, top, orbits, shades, system)
    axes = style.place(figure, LEFT, below, PLANE, PLANE)
    _draw_states(axes, orbits, shades)
    axes.set_xlabel(f"stroboscopic $q$ (m), {at_strobe(system)}")
    axes = style.place(figure, style.WIDTH - RIGHT - PLANE, below, PLANE, PLANE)
    draw_plane(axes, max(radius(orbit) for orbit in orbits))
    for orbit, shade in zip(orbits, shades, strict=True):
        real, imag = ([part(mu) for mu in orbit.multipliers] for part in (np.real, np.imag))
        _dots(axes, real, imag, orbit, shade)
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


def _draw_list(figure: Figure, orbits: Sequence[PeriodicOrbit], shades: Sequence[str]) -> None:
    """A row per orbit: its mark, label, verdict, multipliers and phases."""
    axes = text_rows(figure, HEAD, min(len(orbits), MOST + 1) + 1)
    heads = ("orbit", "", r"multipliers $\mu$", "phases (deg)")
    text_row(axes, 0, COLUMNS, heads, color=style.CAM)
    for row, (orbit, shade) in enumerate(zip(orbits[:MOST], shades, strict=False), 1):
        _dots(axes, [DOT], [row_middle(row)], orbit, shade)
        at = [f"{phase:.2f}" for phase in phases(orbit)]
        shown = ", ".join(at if len(at) <= 6 else [*at[:5], "…"])
        leaves = "leaves at " if orbit.resting and at else ""
        verdict = "stable" if orbit.stable else "unstable"
        multipliers = pair(orbit.trace, orbit.det)
        cells = style.motion(orbit.label, 22), verdict, multipliers, leaves + shown
        text_row(axes, row, COLUMNS, cells)
    if len(orbits) > MOST:
        text_row(axes, MOST + 1, COLUMNS, [f"and {len(orbits) - MOST} more, in the tables"])


def _dots(
    axes: Axes, x: Sequence[float], y: Sequence[float], orbit: PeriodicOrbit, shade: str
) -> None:
    """Stable orbits filled, unstable ones open."""
    face = shade if orbit.stable else "white"
    axes.plot(x, y, "o", ms=5.0, mew=1.1, mec=shade, mfc=face, zorder=5)


def _draw_impacts(
    figure: Figure,
    top: int,
    orbits: Sequence[PeriodicOrbit],
    shades: Sequence[str],
    system: System,
) -> None:
    """The cam's lift and its derivatives over the turn with the impacts on them."""
    theta, orders = lift_curves(system.cam, len(CURVES))
    good = np.isfinite(theta)
    corners = style.corner_names(system.corners_deg)
    for k, (name, values) in enumerate(zip(CURVES, orders, strict=True)):
        axes = style.place(figure, LEFT, top + k * (LIFT + GAP), WIDE, LIFT)
        axes.plot(theta, values, color=style.CAM, linewidth=0.9, zorder=2)
        axes.margins(y=0.1)
        for orbit, shade in zip(orbits, shades, strict=True):
            at = phases(orbit)
            heights = np.interp(at, theta[good], values[good])  # on a corner: either side's value
            _dots(axes, at, heights.tolist(), orbit, shade)
            line: Any = "-" if orbit.stable else DASHED
            for phase in at:
                axes.axvline(phase, color=shade, alpha=0.6, zorder=1, linewidth=0.7, linestyle=line)
        axes.set(xlim=(0.0, TURN_DEG), ylabel=name, xticks=range(0, 361, 30))
        axes.tick_params(labelbottom=k == len(CURVES) - 1)
        corners_across(axes, corners.items(), named=k == 0)
    axes.set_xlabel(r"cam angle $\theta$ (deg)")


def _draw_states(axes: Axes, orbits: Sequence[PeriodicOrbit], shades: Sequence[str]) -> None:
    """The orbits as points of the stroboscopic map."""
    for orbit, shade in zip(orbits, shades, strict=True):
        q, rate = zip(*orbit.states, strict=True)
        _dots(axes, q, rate, orbit, shade)
    every = np.array([state for orbit in orbits for state in orbit.states])
    limits = []
    for values in every.T:
        low, high = padded(values, 0.5 * abs(values).max() or 1.0)
        limits.append((low - 0.1 * (high - low), high + 0.1 * (high - low)))
    axes.set(xlim=limits[0], ylim=limits[1])
    axes.locator_params(nbins=5)
    axes.set_ylabel(r"stroboscopic $q_\theta$ (m/rad)")
