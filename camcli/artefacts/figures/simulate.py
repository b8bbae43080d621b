"""Picture of one orbit: motion over the cam, relative position, relative phase plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.simulate import FLIGHT, STICKING, Simulation
from camcli.artefacts.figures import style
from camcli.errors import OK, STATUSES

LEFT, RIGHT = 120, 30  # px, margins of the panels
HEIGHT = 1230
BLINK = 1e-9  # turns: closer is the same time
STEPS = (30, 60, 90, 180)  # degrees between ticks; beyond, whole turns
MARKS = {  # event: colour, marker, size, name
    "impact": (style.IMPACT, "o", 2.0, "impact"),
    "chatter": (style.CHATTER, "^", 5.5, "chatter accumulates"),
    "detachment": (style.DETACHMENT, "D", 4.5, "detachment"),
}


@dataclass(frozen=True)
class _Trace:
    """What is shown: degrees since the first strobe, m, m/s; `sticks` holds to the next row."""

    low: float
    high: float
    angle: np.ndarray
    q: np.ndarray
    c: np.ndarray
    gap: np.ndarray
    u: np.ndarray
    sticks: np.ndarray
    events: dict[str, tuple[np.ndarray, np.ndarray]]  # angle, q


def draw_simulation(simulation: Simulation, path_or_buffer, *, turns: int) -> None:
    """Write the PNG of the last `turns` turns of a simulation to a path or a binary buffer."""
    trace = _trace(simulation, turns)
    with style.page(path_or_buffer, HEIGHT) as figure:
        _heading(figure, simulation)
        wide = style.WIDTH - LEFT - RIGHT
        motion = style.place(figure, LEFT, 190, wide, 440)
        gap = style.place(figure, LEFT, 740, 570, 390)
        phase = style.place(figure, LEFT + 720, 740, wide - 720, 390)
        if trace is None:
            for axes in (motion, gap, phase):
                style.note(axes, "no trajectory was sampled")
        else:
            _draw_motion(motion, trace, simulation)
            _draw_gap(gap, trace)
            _draw_phase(phase, trace)
            _angle_axis(motion, trace, wide)
            _angle_axis(gap, trace, 570)
            _legend(figure, motion, phase)
        _label(motion, gap, phase)


def _heading(figure: Figure, simulation: Simulation) -> None:
    title = f"Time response at {style.number(simulation.rpm)} rpm, {style.motion(simulation.label)}"
    style.write(figure, 20, 16, title, size=9, weight="bold")
    if simulation.status != OK:
        status = STATUSES[simulation.status]
        text = f"stopped ({status.name}): {status.cause}"
        style.write(figure, 20, 16 + 1.2 * style.LINE, text, color=style.TROUBLE)


def _label(motion: Axes, gap: Axes, phase: Axes) -> None:
    motion.set_ylabel("position (m)")
    gap.set_ylabel("relative position $q - c$ (m)")
    phase.set_xlabel("relative position $q - c$ (m)")
    phase.set_ylabel(r"relative velocity $v - \dot c$ (m/s)")


def _trace(simulation: Simulation, turns: int) -> _Trace | None:
    """The last turns in columns; None where the simulation has no trajectory."""
    rows = simulation.trajectory
    if not rows:
        return None
    per_second = simulation.rpm / 60.0
    last = max(ceil(rows[-1][0] * per_second - BLINK), floor(rows[0][0] * per_second + BLINK) + 1)
    first = max(last - turns, floor(rows[0][0] * per_second + BLINK))
    begin = (first - BLINK) / per_second
    shift = round(rows[0][1] - 360.0 * per_second * rows[0][0], 9) % 360.0
    kept = [row for row in rows if row[0] >= begin]
    t, _, q, v, c, c_dot = np.array([row[:6] for row in kept], dtype=float).T
    return _Trace(
        low=360.0 * first + shift,
        high=360.0 * last + shift,
        angle=360.0 * per_second * t + shift,
        q=q,
        c=c,
        gap=q - c,
        u=v - c_dot,
        sticks=np.array([row[6] == STICKING for row in kept]),
        events=_events(simulation, begin, shift),
    )


def _events(simulation: Simulation, begin: float, shift: float) -> dict:
    found = {}
    for kind in MARKS:
        rows = [row for row in simulation.events if row[3] == kind and row[0] >= begin]
        angle = np.array([row[0] for row in rows]) * (6.0 * simulation.rpm) + shift
        found[kind] = angle, np.array([row[4] for row in rows])
    return found


def _during(values: np.ndarray, state: np.ndarray) -> np.ndarray:
    """Values on the segments that begin in a state, nan elsewhere."""
    ends = np.concatenate([[False], state[:-1]])
    return np.where(state | ends, values, np.nan)


def _draw_motion(axes: Axes, trace: _Trace, simulation: Simulation) -> None:
    """Positions of cam and follower, coloured by the contact, with all events."""
    low, high = float(trace.c.min()), float(max(trace.q.max(), trace.c.max()))
    room = 0.06 * (high - low) or 0.06 * abs(high) or 1.0
    axes.set_ylim(low - room, high + 1.8 * room)
    axes.fill_between(trace.angle, low - room, trace.c, color=style.CAM_BODY, linewidth=0)
    axes.plot(trace.angle, trace.c, color=style.CAM, linewidth=0.8, label="cam")
    _contact(axes, trace, trace.q, trace.c)
    for kind, (angle, q) in trace.events.items():
        _mark(axes, kind, angle, q)
    _corners(axes, trace, simulation.corners_deg)
    period = 60.0 / simulation.rpm
    shift = trace.low % 360.0
    clock = axes.secondary_xaxis(
        "top",
        functions=(
            lambda angle: (angle - shift) / 360.0 * period,
            lambda time: time / period * 360.0 + shift,
        ),
    )
    clock.set_xlabel("time (s)")


def _contact(axes: Axes, trace: _Trace, flying: np.ndarray, resting: np.ndarray) -> None:
    """Flight and sticking lines over the cam angle."""
    line = {"linewidth": 3.0, "color": style.STICKING}
    if trace.sticks.any():
        axes.plot(trace.angle, _during(resting, trace.sticks), label=STICKING, **line)
    if not trace.sticks.all():
        flight = _during(flying, ~trace.sticks)
        axes.plot(trace.angle, flight, color=style.FLIGHT, label=f"follower in {FLIGHT}")


def _mark(axes: Axes, kind: str, x: np.ndarray, y: np.ndarray) -> None:
    if not len(x):
        return
    colour, marker, size, name = MARKS[kind]
    edge = {"markeredgewidth": 0.5, "markeredgecolor": "white"} if kind != "impact" else {}
    more = {"linestyle": "", "color": colour, "label": name, "zorder": 4, "markeredgewidth": 0}
    axes.plot(x, y, marker=marker, markersize=size, **(more | edge))


def _corners(axes: Axes, trace: _Trace, corners_deg: Sequence[float]) -> None:
    """Corners of the cam as dotted lines, named in the first turn shown."""
    names = style.corner_names(corners_deg)
    if trace.high - trace.low > 4.5 * 360.0 or not names:
        return
    phases = [trace.low + (corner - trace.low) % 360.0 for corner in names.values()]
    order = sorted(range(len(phases)), key=phases.__getitem__)
    gap = 0.014 * (trace.high - trace.low)
    places = style.spread([phases[k] for k in order], gap, trace.low, trace.high)
    for k, place in zip(order, places, strict=True):
        for angle in np.arange(phases[k], trace.high, 360.0):
            axes.axvline(angle, color=style.GUIDE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=0.5)
        text = {"ha": "center", "va": "top", "color": style.CAM}
        axes.text(place, 0.985, list(names)[k], transform=axes.get_xaxis_transform(), **text)


def _draw_gap(axes: Axes, trace: _Trace) -> None:
    """Relative position over the cam angle."""
    axes.axhline(0.0, color=style.CAM, linewidth=0.6)
    _contact(axes, trace, trace.gap, np.zeros_like(trace.gap))
    for kind, (angle, _) in trace.events.items():
        _mark(axes, kind, angle, np.zeros_like(angle))


def _draw_phase(axes: Axes, trace: _Trace) -> None:
    """Relative phase plane: flights as curves, impacts as jumps at q = c."""
    jumps = np.flatnonzero(np.diff(trace.angle) == 0.0)
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5)
    gap = np.insert(_during(trace.gap, ~trace.sticks), jumps + 1, np.nan)
    u = np.insert(_during(trace.u, ~trace.sticks), jumps + 1, np.nan)
    axes.plot(gap, u, color=style.FLIGHT)
    for k in jumps:
        ends = trace.u[k : k + 2]
        axes.plot(trace.gap[k : k + 2], ends, color=style.IMPACT, linewidth=0.5)
    rests = {"color": style.STICKING, "marker": "o", "markersize": 5.0, "zorder": 4}
    if trace.sticks.any():
        axes.plot([0.0], [0.0], **rests)


def _angle_axis(axes: Axes, trace: _Trace, width: int) -> None:
    """Ticks in degrees within the turn, or in turns where there are many; a line per turn."""
    axes.set_xlim(trace.low, trace.high)
    span = trace.high - trace.low
    step = next((step for step in STEPS if span / step * 62 <= width), None)
    if step is None:
        axes.set_xlabel("cam angle (turns)")
        axes.xaxis.set_major_locator("auto")
        return
    ticks = np.arange(ceil(trace.low / step - BLINK), floor(trace.high / step + BLINK) + 1) * step
    axes.set_xticks(ticks, [f"{tick % 360:g}" for tick in ticks])
    axes.set_xlabel(r"cam angle $\theta$ (deg)")
    for tick in ticks[ticks % 360 == 0]:
        axes.axvline(tick, color=style.GUIDE, linewidth=0.5, zorder=0.5)


def _legend(figure: Figure, motion: Axes, phase: Axes) -> None:
    handles, names = motion.get_legend_handles_labels()
    place = (LEFT / style.WIDTH, 1.0 - 60 / HEIGHT)
    more = {"ncol": len(names), "borderaxespad": 0.0, "columnspacing": 1.4, "handletextpad": 0.5}
    figure.legend(handles, names, loc="upper left", bbox_to_anchor=place, **more)
