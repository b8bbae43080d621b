"""Picture of one orbit: motion over the cam, relative position, relative phase plane."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.simulate import FLIGHT, STICKING, Simulation
from camcli.errors import OK, STATUSES
from camcli.plots import style
from camcli.plots.trace import Trace

LEFT, RIGHT = 125, 25  # px, margins of the panels
HALF = 570  # px, width of the lower left panel
HEIGHT = 1245
STEPS = (30, 60, 90, 180)  # degrees between ticks; beyond, whole turns
MARKS = {  # event: colour, marker, size, name
    "impact": (style.IMPACT, "o", 2.0, "impact"),
    "chatter": (style.CHATTER, "^", 5.5, "chatter accumulates"),
    "detachment": (style.DETACHMENT, "D", 4.5, "detachment"),
}


@style.look()
def draw_simulation(simulation: Simulation, turns: int) -> Figure:
    """Picture of the last `turns` turns of a simulation."""
    trace = Trace.of(simulation, turns)
    figure = style.page(HEIGHT)
    _heading(figure, simulation)
    wide = style.WIDTH - LEFT - RIGHT
    motion = style.place(figure, LEFT, 205, wide, 440)
    gap = style.place(figure, LEFT, 755, HALF, 395)
    phase = style.place(figure, LEFT + 720, 755, wide - 720, 395)
    motion.set_ylabel("position (m)")
    gap.set_ylabel("relative position $q - c$ (m)")
    phase.set_xlabel("relative position $q - c$ (m)")
    phase.set_ylabel(r"relative velocity $v - \dot c$ (m/s)")
    if trace is None:
        for axes in (motion, gap, phase):
            axes.set(xticks=[], yticks=[])
            style.note(axes, "no trajectory was sampled")
        return figure
    _draw_motion(motion, trace, simulation)
    _draw_gap(gap, trace)
    _draw_phase(phase, trace)
    _angle_axis(motion, trace, wide)
    _angle_axis(gap, trace, HALF)
    _clock(motion, trace, simulation.rpm)
    _legend(figure, motion)
    return figure


def _heading(figure: Figure, simulation: Simulation) -> None:
    title = f"Time response at {style.number(simulation.rpm)} rpm, {style.motion(simulation.label)}"
    if simulation.status != OK:
        status = STATUSES[simulation.status]
        text = f"stopped ({status.name}): {status.cause}"
        style.write(figure, 20, 50, text, color=style.TROUBLE)
    style.write(figure, 20, 14, title, size=9, weight="bold")


def _draw_motion(axes: Axes, trace: Trace, simulation: Simulation) -> None:
    """Positions of cam and follower, coloured by the contact, with all events."""
    q = trace.cam + trace.gap
    low, high = float(trace.cam.min()), float(q.max())
    room = 0.06 * (high - low) or 0.06 * abs(high) or 1.0
    axes.set_ylim(low - room, high + 2.0 * room)
    axes.fill_between(trace.angle, low - room, trace.cam, color=style.CAM_BODY, linewidth=0)
    axes.plot(trace.angle, trace.cam, color=style.CAM, linewidth=0.8, label="cam")
    _contact(axes, trace, q)
    for kind, points in trace.events.items():
        _mark(axes, kind, points[:, 0], points[:, 1])
    _corners(axes, trace, simulation.corners_deg)


def _contact(axes: Axes, trace: Trace, values: np.ndarray) -> None:
    """Values over the cam angle: flight as a line, sticking as a thick one."""
    if not trace.sticks.all():
        flight = trace.during(values, sticking=False)
        axes.plot(trace.angle, flight, color=style.FLIGHT, label=f"follower in {FLIGHT}")
    if trace.sticks.any():
        rest = trace.during(values, sticking=True)
        axes.plot(trace.angle, rest, color=style.STICKING, linewidth=3.0, label=STICKING)


def _mark(axes: Axes, kind: str, x: np.ndarray, y: np.ndarray) -> None:
    colour, marker, size, name = MARKS[kind]
    edge = {"markeredgewidth": 0.0 if kind == "impact" else 0.5, "markeredgecolor": "white"}
    look = {"marker": marker, "markersize": size, "color": colour, "linestyle": "", "zorder": 4}
    axes.plot(x, y, label=name, **look, **edge)


def _corners(axes: Axes, trace: Trace, corners_deg: Sequence[float]) -> None:
    """Corners of the cam as dotted lines, named in the first turn shown."""
    names = style.corner_names(corners_deg)
    if trace.high - trace.low > 4.5 * 360.0:
        return
    first = {name: trace.low + (phase - trace.low) % 360.0 for name, phase in names.items()}
    names = sorted(first, key=first.__getitem__)
    gap = 0.014 * (trace.high - trace.low)
    places = style.spread([first[name] for name in names], gap, trace.low, trace.high)
    dots = {"color": style.GUIDE, "linewidth": 0.6, "linestyle": (0, (1, 2)), "zorder": 0.5}
    for name, place in zip(names, places, strict=True):
        for angle in np.arange(first[name], trace.high, 360.0):
            axes.axvline(angle, **dots)
        text = {"ha": "center", "va": "top", "color": style.CAM}
        axes.text(place, 0.985, name, transform=axes.get_xaxis_transform(), **text)


def _draw_gap(axes: Axes, trace: Trace) -> None:
    """Relative position over the cam angle."""
    axes.axhline(0.0, color=style.CAM, linewidth=0.6)
    _contact(axes, trace, trace.gap)
    for kind, points in trace.events.items():
        _mark(axes, kind, points[:, 0], np.zeros(len(points)))


def _draw_phase(axes: Axes, trace: Trace) -> None:
    """Relative phase plane: flights as curves, impacts as jumps at q = c, sticking as a point."""
    for line in (axes.axvline, axes.axhline):
        line(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    flight = trace.during(trace.gap, sticking=False), trace.during(trace.u, sticking=False)
    axes.plot(*flight, color=style.FLIGHT)
    ends = np.column_stack([trace.jumps, np.full(len(trace.jumps), np.nan)]).ravel()
    axes.plot(np.zeros_like(ends), ends, "o-", color=style.IMPACT, linewidth=0.5, markersize=2.0)
    if trace.sticks.any():
        axes.plot([0.0], [0.0], color=style.STICKING, marker="o", markersize=5.0, zorder=4)


def _angle_axis(axes: Axes, trace: Trace, width: int) -> None:
    """Ticks in degrees within the turn, or in turns where there are many; a line per turn."""
    axes.set_xlim(trace.low, trace.high)
    span = trace.high - trace.low
    step = next((step for step in STEPS if span / step * 62 <= width), None)
    if step is None:
        step = 360 * ceil(span / 360.0 * 62 / width)
    ticks = step * np.arange(ceil(trace.low / step - 1e-9), floor(trace.high / step + 1e-9) + 1)
    if step < 360:
        axes.set_xticks(ticks, [f"{tick % 360:d}" for tick in ticks])
        axes.set_xlabel(r"cam angle $\theta$ (deg)")
    else:
        axes.set_xticks(ticks, [f"{tick // 360:d}" for tick in ticks])
        axes.set_xlabel("cam angle (turns)")
    for tick in ticks[ticks % 360 == 0]:
        axes.axvline(tick, color=style.GUIDE, linewidth=0.5, zorder=0.5)


def _clock(axes: Axes, trace: Trace, rpm: float) -> None:
    """A second axis above: time."""
    clock = axes.secondary_xaxis(
        "top",
        functions=(
            lambda angle: (angle - trace.origin) / (6.0 * rpm),
            lambda time: time * (6.0 * rpm) + trace.origin,
        ),
    )
    clock.set_xlabel("time (s)")


def _legend(figure: Figure, motion: Axes) -> None:
    handles, names = motion.get_legend_handles_labels()
    above = (20 / style.WIDTH, 1.0 - 84 / HEIGHT)
    tight = {"borderaxespad": 0.0, "columnspacing": 1.5, "handletextpad": 0.5, "handlelength": 1.6}
    figure.legend(
        handles,
        names,
        loc="upper left",
        bbox_to_anchor=above,
        ncol=len(names),
        borderpad=0.0,
        **tight,
    )
