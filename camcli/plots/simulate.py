"""Picture of one orbit: motion over the cam, relative position, relative phase plane."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from camcli.analysis.simulate import FLIGHT, STICKING, Simulation
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import TURN_DEG, corner_lines, mark, places_beside, say
from camcli.plots.picture import Panel, Picture

STEPS = (30, 60, 90, 180, 360)  # degrees between ticks; beyond, several turns
TICK = 21.0  # pt, from one tick to the next at least
NAMED_TURNS = 4.5  # turns up to which corners are drawn
NAMES = {"chatter": "chatter accumulates"}  # of events, where it is another than their kind
BLINK = 1e-9  # turns: closer is the same time
FINER = 8  # points from one row to the next
MOST_POINTS = 400_000


@dataclass(frozen=True)
class Trace:
    """The last turns over the cam angle (deg, from turn to turn), smooth between the samples.

    `cam`, `gap` (m) and `u` (m/s) are by point; `sticks` holds from a point to the next. `events`
    has (angle, q) of every kind, `jumps` (u_minus, u_plus) of the impacts; `origin` is the angle
    at time 0.
    """

    low: float
    high: float
    origin: float
    angle: np.ndarray
    cam: np.ndarray
    gap: np.ndarray
    u: np.ndarray
    sticks: np.ndarray
    events: dict[str, np.ndarray]
    jumps: np.ndarray

    @classmethod
    def of(cls, simulation: Simulation, turns: int) -> Trace:
        """The last turns of a simulation that has a trajectory."""
        rows = simulation.trajectory
        per_second = simulation.rpm / 60.0
        first = floor(rows[0][0] * per_second + BLINK)
        last = max(ceil(rows[-1][0] * per_second - BLINK), first + 1)
        first = max(last - turns, first)
        begin = (first - BLINK) / per_second
        degrees = TURN_DEG * per_second
        origin = round(rows[0][1] - degrees * rows[0][0], 9) % TURN_DEG
        kept = [row for row in rows if row[0] >= begin]
        t, _, q, v, c, c_dot = np.array([row[:6] for row in kept], dtype=float).T
        parts = max(2, min(FINER, MOST_POINTS // len(kept)))
        gap, u = _finer(t, q - c, v - c_dot, parts)
        sticks = [row[6] == STICKING for row in kept]
        events: dict[str, list[tuple[float, float]]] = {}
        for row in simulation.events:
            if row[0] >= begin:
                events.setdefault(row[3], []).append((row[0] * degrees + origin, row[4]))
        jumps = [row[5:7] for row in simulation.events if row[0] >= begin and row[3] == "impact"]
        return cls(
            low=TURN_DEG * first + origin,
            high=TURN_DEG * last + origin,
            origin=origin,
            angle=degrees * _finer(t, t, np.ones_like(t), parts)[0] + origin,
            cam=_finer(t, c, c_dot, parts)[0],
            gap=np.maximum(gap, min(0.0, float((q - c).min()))),
            u=u,
            sticks=np.append(np.repeat(sticks[:-1], parts), sticks[-1]).astype(bool),
            events={kind: np.array(points) for kind, points in events.items()},
            jumps=np.array(jumps).reshape(-1, 2),
        )

    def during(self, values: np.ndarray, sticking: bool) -> np.ndarray:
        """Values on the segments of one state of the contact, nan elsewhere."""
        begins = self.sticks == sticking
        return np.where(begins | np.append(False, begins[:-1]), values, np.nan)


def _finer(
    t: np.ndarray, y: np.ndarray, slope: np.ndarray, parts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes of the cubic through both at the rows, `parts` points per segment.

    Where time stands still (a jump of the slope), the slopes within are nan: a gap in the curve.
    """
    x = np.arange(parts) / parts
    h = np.diff(t)[:, None]
    rise = np.diff(y)[:, None]
    start, end = h * slope[:-1, None], h * slope[1:, None]
    square, cube = 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise
    values = y[:-1, None] + x * (start + x * (square + x * cube))
    slopes = start + x * (2.0 * square + 3.0 * x * cube)
    slopes = np.divide(slopes, h, out=np.full_like(slopes, np.nan), where=h > 0.0)
    slopes[:, 0] = slope[:-1]
    return np.append(values.ravel(), y[-1]), np.append(slopes.ravel(), slope[-1])


def draw_simulation(simulation: Simulation, turns: int) -> Picture:
    """Picture of the last `turns` turns of a simulation."""
    title = f"Time response at {style.number(simulation.rpm)} rpm, {style.motion(simulation.label)}"
    status = Status(simulation.status)
    stopped = f"stopped ({status.text}): {status.cause}" if simulation.status != Status.OK else ""
    trace = Trace.of(simulation, turns) if simulation.trajectory else None

    def panel(draw: Any, height: float, across: int = 1) -> Panel:
        if trace is None:
            return Panel(lambda axes: say(axes, "no trajectory was sampled"), height, across=across)
        return Panel(lambda axes: draw(axes, trace, simulation), height, across=across)

    panels = {
        "motion": panel(_draw_motion, 58.0),
        "gap": panel(_draw_gap, 52.0, across=2),
        "phase": panel(_draw_phase, 52.0, across=2),
    }
    return Picture(title, panels, stopped, style.TROUBLE)


def _draw_motion(axes: Axes, trace: Trace, simulation: Simulation) -> None:
    """Positions of cam and follower, coloured by the contact, with all events; time above."""
    q = trace.cam + trace.gap
    low, high = float(trace.cam.min()), float(q.max())
    room = 0.06 * (high - low) or 0.06 * abs(high) or 1.0
    axes.set(ylim=(low - room, high + room), ylabel="position (m)")
    axes.fill_between(trace.angle, low - room, trace.cam, color=style.CAM_BODY, linewidth=0)
    axes.plot(trace.angle, trace.cam, color=style.CAM, linewidth=0.8, label="cam")
    _draw_contact(axes, trace, q, named=True)
    for kind, points in trace.events.items():
        mark(axes, kind, points[:, 0], points[:, 1], label=NAMES.get(kind, kind), zorder=4)
    _angle_axis(axes, trace)
    if trace.high - trace.low <= NAMED_TURNS * TURN_DEG:
        named = sorted(
            (trace.low + (phase - trace.low) % TURN_DEG, name)
            for name, phase in style.corner_names(simulation.corners_deg).items()
        )
        for first, _ in named:
            places = np.arange(first, trace.high, TURN_DEG)
            corner_lines(axes, [("", place) for place in places], "x")
        look: dict[str, Any] = {"color": style.CAM, "size": style.NOTE, "ha": "center"}
        spots = places_beside(axes, [first for first, _ in named], "x")
        for (_, name), x in zip(named, spots, strict=True):
            axes.text(x, 0.985, name, transform=axes.get_xaxis_transform(), va="top", **look)
    degrees_per_second = 6.0 * simulation.rpm

    def seconds(angle: Any) -> Any:
        return (angle - trace.origin) / degrees_per_second

    def degrees(time: Any) -> Any:
        return time * degrees_per_second + trace.origin

    axes.secondary_xaxis("top", functions=(seconds, degrees)).set_xlabel("time (s)")


def _draw_contact(axes: Axes, trace: Trace, values: np.ndarray, named: bool = False) -> None:
    """Values over the cam angle: flight as a line, sticking as a thick one."""
    looks = (
        (False, style.FLIGHT, 1.0, f"follower in {FLIGHT}"),
        (True, style.STICKING, 3.0, STICKING),
    )
    for sticking, colour, width, name in looks:
        if (trace.sticks == sticking).any():
            label = name if named else None
            part = trace.during(values, sticking)
            axes.plot(trace.angle, part, color=colour, linewidth=width, label=label)


def _draw_gap(axes: Axes, trace: Trace, _: Simulation) -> None:
    """Relative position over the cam angle."""
    axes.axhline(0.0, color=style.CAM, linewidth=0.6)
    _draw_contact(axes, trace, trace.gap)
    for kind, points in trace.events.items():
        mark(axes, kind, points[:, 0], np.zeros(len(points)), zorder=4)
    axes.set_ylabel("relative position $q - c$ (m)")
    _angle_axis(axes, trace)


def _draw_phase(axes: Axes, trace: Trace, _: Simulation) -> None:
    """Relative phase plane: flights as curves, impacts as jumps at q = c, sticking as a point."""
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    flight = trace.during(trace.gap, sticking=False), trace.during(trace.u, sticking=False)
    axes.plot(*flight, color=style.FLIGHT)
    ends = np.column_stack([trace.jumps, np.full(len(trace.jumps), np.nan)]).ravel()
    axes.plot(np.zeros_like(ends), ends, "o-", color=style.IMPACT, linewidth=0.5, ms=2.0)
    if trace.sticks.any():
        axes.plot([0.0], [0.0], color=style.STICKING, marker="o", ms=5.0, zorder=4)
    axes.set_xlabel("relative position $q - c$ (m)")
    axes.set_ylabel(r"relative velocity $v - \dot c$ (m/s)")


def _angle_axis(axes: Axes, trace: Trace) -> None:
    """Ticks in degrees within the turn, or in turns where there are many; a line per turn."""
    span = trace.high - trace.low
    most = max(2, int(axes.get_window_extent().width / style.DPI * 72.0 / TICK))
    step = next((s for s in STEPS if span <= s * most), 360 * ceil(span / TURN_DEG / most))
    ticks = step * np.arange(ceil(trace.low / step - 1e-9), floor(trace.high / step + 1e-9) + 1)
    within = step < TURN_DEG
    names = [f"{tick % 360 if within else tick // 360:d}" for tick in ticks]
    axes.set(xlim=(trace.low, trace.high), xticks=ticks)
    axes.set_xticklabels(names)
    axes.set_xlabel(r"cam angle $\theta$ (deg)" if within else "cam angle (turns)")
    for tick in ticks[ticks % 360 == 0]:
        axes.axvline(tick, color=style.GUIDE, linewidth=0.5, zorder=0.5)
