"""Picture of one orbit: motion over the cam, relative position, relative phase plane."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, floor
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from camcli.analysis.simulate import FLIGHT, STICKING, Simulation
from camcli.cams.compile import column
from camcli.plots import style
from camcli.plots.axes import (
    TURN_DEG,
    corner_lines,
    length_axis,
    lift,
    mark,
    places_beside,
    say,
    unit_axis,
)
from camcli.plots.mechanism import Outline, draw_machine
from camcli.plots.picture import Panel, Picture
from camcli.quantities import THETA, TIME, Q, U, Units, V, labelled
from camcli.system import System, kind_of_cam, turns_per_second, units_of
from camcli.words.simulate import motion_title, slowed, stopped
from camcli.words.speeds import on_the_cam

STEPS = (30, 60, 90, 180, 360)  # degrees between ticks; beyond, several turns
TICK, TIME_TICK = 21.0, 42.0  # pt, from one tick to the next at least, of the angle and of time
ROOM_OF_NAMES = 2.6  # times that above a curve, where names of corners stand above it
ROOM_OF_MARKS = 0.08  # of the relative positions, on either side of these
NAMED_TURNS = 4.5  # turns up to which corners are drawn
NAMES = {"chatter": "chatter accumulates"}  # of events, where it is another than their kind
LAYERS = {"chatter": 4.5}  # of marks, above 4: a triangle covers less of a diamond than this of it
BLINK = 1e-9  # turns: closer is the same time
ASIDE = 1e-13  # of the time, from a corner to what stands for its sides
GAP = "relative position $q - c$"
AROUND = 8.0  # deg, before a detachment in the panel `passage`
FINER = 8  # points from one row to the next
MOST_POINTS = 400_000
PALE_FLIGHT = style.mixed(style.FLIGHT, 0.55)  # of every second turn
WIDE_FLIGHT = 0.3  # of the largest gap: flights with an arrow in the phase plane


@dataclass(frozen=True)
class Trace:
    """The last turns over the cam angle (deg, from turn to turn), smooth between the samples.

    `q`, `cam`, `gap` (m), `u` (m/s) and `bend` (c_thetatheta, m/rad2) are by point; the corners of
    the cam are among the points. `sticks` holds from a point to the next, and so does `seated`:
    at rest on the seat of a cam with lash. `lobe` (m) is that cam less its lash, below the seat
    where it is clear of the follower; without lash it is the cam itself. `events` has (angle, q)
    of every kind, `jumps` (u_minus, u_plus) of the impacts, `section` the states (q, v) at the
    strobe phase; `origin` is the angle at time 0; `units` are the machine's.
    """

    low: float
    high: float
    origin: float
    angle: np.ndarray
    q: np.ndarray
    cam: np.ndarray
    gap: np.ndarray
    u: np.ndarray
    bend: np.ndarray
    sticks: np.ndarray
    seated: np.ndarray
    lobe: np.ndarray
    events: dict[str, np.ndarray]
    jumps: np.ndarray
    section: np.ndarray
    units: Units

    @classmethod
    def of(cls, simulation: Simulation, system: System, turns: int) -> Trace:
        """The last turns of a simulation that has a trajectory."""
        per_second = turns_per_second(simulation.rpm)
        columns = map(np.array, zip(*simulation.trajectory, strict=True))
        t, theta, q, v, _, c_dot, contact = columns
        first = floor(t[0] * per_second + BLINK)
        last = max(ceil(t[-1] * per_second - BLINK), first + 1)
        first = max(last - turns, first)
        begin = (first - BLINK) / per_second
        degrees = TURN_DEG * per_second
        origin = round(float(theta[0] - degrees * t[0]), 9) % TURN_DEG
        strobes = abs(t * per_second - np.round(t * per_second)) < BLINK
        section = np.column_stack([q, v])[strobes]
        kept = t >= begin
        t = t[kept]
        q = q[kept]
        v = v[kept]
        c_dot = c_dot[kept]
        sticks = contact[kept] == STICKING
        corners = (np.degrees(simulation.corners) - origin) / degrees  # some below zero
        turns_of = [corners + k / per_second for k in range(first, last + 1)]
        fine, segment = _fine(t, np.concatenate(turns_of))
        angle = degrees * fine + origin
        cam, slope, bend = lift(system.cam, np.radians(angle))
        at, rate = _cubic(t, q, v, fine, segment)
        resting = sticks[segment]
        gap = np.where(resting, 0.0, at - cam)
        u = rate - slope * np.radians(degrees)
        if any(column(system.cam, "slope_jump")):  # a row at a kink knows which side it is of
            u_of_row = v - c_dot
            u = np.where(fine == t[segment], u_of_row[segment], u)
        events: dict[str, list[tuple[float, float]]] = {}
        jumps = []
        for time, _, _, kind, place, u_minus, u_plus in simulation.events:
            if time < begin:
                continue
            events.setdefault(kind, []).append((time * degrees + origin, place))
            if kind == "impact":
                jumps.append((u_minus, u_plus))
        return cls(
            low=TURN_DEG * first + origin,
            high=TURN_DEG * last + origin,
            origin=origin,
            angle=angle,
            q=cam + gap,
            cam=cam,
            gap=gap,
            u=np.where(resting, 0.0, u),
            bend=bend,
            sticks=resting,
            seated=resting & _on_seat(system, angle),
            lobe=_lobe(system, angle) if system.lash else cam,
            events={kind: np.array(points) for kind, points in events.items()},
            jumps=np.array(jumps).reshape(-1, 2),
            section=section,
            units=units_of(system),
        )

    def during(self, values: np.ndarray, state: np.ndarray) -> np.ndarray:
        """Values on the segments where a state holds, nan elsewhere."""
        return np.where(state | np.append(False, state[:-1]), values, np.nan)


def _on_seat(system: System, angle: np.ndarray) -> np.ndarray:
    """Whether the follower is held up by its seat at angles, deg."""
    starts = column(system.cam, "start")
    seats = np.array(column(system.cam, "seat"), dtype=bool)
    return seats[np.searchsorted(starts, np.radians(angle % TURN_DEG), side="right") - 1]


def _lobe(system: System, angle: np.ndarray) -> np.ndarray:
    """The lobe less its lash at angles (deg), m."""
    return lift(system.as_drawn.cam, np.radians(angle))[0] - system.lash


def _fine(t: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Times that are dense enough for a smooth curve, and the row that each of them comes after.

    The rows themselves are among them; an impact has two rows at one time, so that time is there
    twice. So is every corner of the cam that lies between the rows, once on either side of it.
    """
    parts = max(2, min(FINER, MOST_POINTS // len(t)))  # from each row to the next
    points = np.full(len(t), parts)
    points[-1] = 1  # the last row stands alone
    segment = np.repeat(np.arange(len(t)), points)
    share = np.append(np.tile(np.arange(parts) / parts, len(t) - 1), 0.0)
    fine = t[segment] + share * np.append(np.diff(t), 0.0)[segment]
    aside = ASIDE * t[-1]  # some roundings of the largest time
    inside = corners[(corners - aside >= t[0]) & (corners < t[-1])]  # no side before the first row
    sides = np.sort(np.concatenate([inside - aside, inside + aside]))
    place = np.searchsorted(fine, sides, side="right")
    after = np.searchsorted(t, sides, side="right") - 1
    return np.insert(fine, place, sides), np.insert(segment, place, after)


def _cubic(
    t: np.ndarray, y: np.ndarray, slope: np.ndarray, x: np.ndarray, segment: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes at times x of the cubics through the rows, each with both slopes there.

    Where time stands still (an impact), the slope is nan: a gap in the curve.
    """
    if len(t) < 2:
        return y[segment], slope[segment]
    k = np.minimum(segment, len(t) - 2)
    h = np.diff(t)[k]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (x - t[k]) / h
        rise = np.diff(y)[k] / h
        start = slope[k]
        end = slope[k + 1]
        square, cube = 3.0 * rise - 2.0 * start - end, start + end - 2.0 * rise
        values = y[k] + h * s * (start + s * (square + s * cube))
        slopes = start + s * (2.0 * square + 3.0 * s * cube)
    first = np.append(True, np.diff(segment) > 0)
    jumps = np.where(first, slope[segment], np.nan)
    return np.where(h > 0.0, values, y[segment]), np.where(h > 0.0, slopes, jumps)


def draw_simulation(simulation: Simulation, system: System, turns: int) -> Picture:
    """Picture of the last `turns` turns of a simulation."""
    title = f"Time response at {motion_title(simulation, kind_of_cam(system))}"
    trace = Trace.of(simulation, system, turns) if simulation.trajectory else None

    def panel(draw: Any, height: float, **more: Any) -> Panel:
        if trace is None:
            return Panel(lambda axes: say(axes, "no trajectory was sampled"), height, **more)
        return Panel(lambda axes: draw(axes, trace, simulation), height, **more)

    panels = {
        "motion": panel(_draw_motion, 58.0),
        "gap": panel(_draw_gap, 52.0, across=2),
        "phase": panel(_draw_phase, 52.0, across=2),
        "passage": panel(_draw_passage, 52.0, usual=False),
        "section": panel(_draw_section, 60.0, across=2, usual=False),
    }
    return Picture(title, panels, words=stopped(simulation), colour=style.TROUBLE)


def _draw_motion(axes: Axes, trace: Trace, simulation: Simulation) -> None:
    """Positions of cam and follower, coloured by the contact, with all events; time above."""
    low, high = float(trace.lobe.min()), float(trace.q.max())
    room = 0.06 * (high - low) or 0.06 * abs(high) or 1.0
    named = _named_corners(trace, simulation)
    axes.set(ylim=(low - room, high + room * (ROOM_OF_NAMES if named else 1.0)))
    unit_axis(axes.yaxis, Q.name, trace.units)
    axes.fill_between(trace.angle, low - room, trace.lobe, color=style.CAM_BODY, linewidth=0)
    clear = trace.cam - trace.lobe > BLINK * float(np.ptp(trace.cam))  # of the follower
    has_lash = bool(clear.any())
    name = "lobe less lash, or seat" if has_lash else "cam"
    axes.plot(trace.angle, trace.cam, color=style.CAM, linewidth=0.8, label=name)
    if has_lash:
        below = np.where(clear, trace.lobe, np.nan)
        axes.plot(
            trace.angle,
            below,
            color=style.CAM,
            lw=0.8,
            ls="--",
            label="lobe, clear of the follower",
        )
    _draw_contact(axes, trace, trace.q, named=True)
    for kind, points in trace.events.items():
        name = NAMES.get(kind, kind)
        mark(axes, kind, points[:, 0], points[:, 1], label=name, zorder=LAYERS.get(kind, 4.0))
    angle_axis(axes, trace)
    for first, _ in named:
        places = np.arange(first, trace.high, TURN_DEG)
        corner_lines(axes, [("", place) for place in places], "x")
    look: dict[str, Any] = {"color": style.CAM, "size": style.NOTE, "ha": "center"}
    spots = places_beside(axes, [first for first, _ in named], "x")
    for (_, name), x in zip(named, spots, strict=True):
        axes.text(x, 0.985, name, transform=axes.get_xaxis_transform(), va="top", **look)
    rate = 6.0 * simulation.rpm  # deg/s

    def to_s(angle: Any) -> Any:
        return (angle - trace.origin) / rate

    def to_deg(time: Any) -> Any:
        return time * rate + trace.origin

    above = axes.secondary_xaxis("top", functions=(to_s, to_deg))
    above.set_xlabel(TIME.label)
    wide = axes.get_window_extent().width / style.DPI * 72.0
    above.xaxis.set_major_locator(MaxNLocator(max(2, int(wide / TIME_TICK)), steps=[1, 2, 5, 10]))


def _named_corners(trace: Trace, simulation: Simulation) -> list[tuple[float, str]]:
    """The corners of the cam where they first are (deg), with their names; none of many turns."""
    if trace.high - trace.low > NAMED_TURNS * TURN_DEG:
        return []
    corners = style.corner_names(simulation.corners).items()
    return sorted((trace.low + (phase - trace.low) % TURN_DEG, name) for name, phase in corners)


def _draw_contact(axes: Axes, trace: Trace, values: np.ndarray, named: bool = False) -> None:
    """Values over the cam angle: flight as a line, rests as thick ones."""
    on_lobe = trace.sticks & ~trace.seated
    slowing = on_lobe & (trace.bend < -BLINK * abs(trace.bend).max())
    states = {
        f"follower in {FLIGHT}": (~trace.sticks, style.FLIGHT, 1.0),
        "at rest on its seat": (trace.seated, style.CAM, 3.0),
        rf"{STICKING}, $\ddot{{c}} \geq 0$": (on_lobe & ~slowing, style.STICKING, 3.0),
        rf"{STICKING}, $\ddot{{c}} < 0$": (slowing, style.SLOWING, 3.0),
    }
    for name, (state, colour, width) in states.items():
        if state.any():
            part = trace.during(values, state)
            label = name if named else None
            axes.plot(trace.angle, part, color=colour, linewidth=width, label=label)


def _draw_gap(axes: Axes, trace: Trace, _: Simulation) -> None:
    """Relative position over the cam angle."""
    axes.axhline(0.0, color=style.CAM, linewidth=0.6)
    _draw_contact(axes, trace, trace.gap)
    for kind, points in trace.events.items():
        mark(axes, kind, points[:, 0], np.zeros(len(points)), zorder=LAYERS.get(kind, 4.0))
    axes.margins(y=ROOM_OF_MARKS)
    length_axis(axes.yaxis, GAP, trace.gap.max())
    angle_axis(axes, trace)


def _draw_phase(axes: Axes, trace: Trace, _: Simulation) -> None:
    """Relative phase plane: flights as curves, impacts as jumps at q = c, sticking as a point."""
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    flight = (trace.during(values, ~trace.sticks) for values in (trace.gap, trace.u))
    axes.plot(*flight, color=style.FLIGHT)
    _draw_ways(axes, trace)
    ends = np.column_stack([trace.jumps, np.full(len(trace.jumps), np.nan)]).ravel()
    axes.plot(np.zeros_like(ends), ends, "o-", color=style.IMPACT, linewidth=0.5, ms=2.0)
    if trace.sticks.any():
        axes.plot([0.0], [0.0], color=style.STICKING, marker="o", ms=5.0, zorder=4)
    length_axis(axes.xaxis, GAP, trace.gap.max())
    axes.set_ylabel(U.label)


def _draw_ways(axes: Axes, trace: Trace) -> None:
    """An arrow where each of the wide flights turns back to the cam; it shows the way of time."""
    turning = (trace.u[:-1] > 0.0) & (trace.u[1:] <= 0.0) & ~trace.sticks[:-1] & ~trace.sticks[1:]
    wide = trace.gap[:-1] > WIDE_FLIGHT * trace.gap.max()
    arrow: dict[str, Any] = {
        "arrowstyle": "-|>,head_width=0.32,head_length=0.6",
        "color": style.FLIGHT,
        "linewidth": 0.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
    }
    for k in np.flatnonzero(turning & wide):
        tail = (trace.gap[k], trace.u[k])
        head = (trace.gap[k + 1], trace.u[k + 1])
        axes.annotate("", head, tail, arrowprops=arrow, zorder=5)


def _draw_passage(axes: Axes, trace: Trace, simulation: Simulation) -> None:
    """Relative position around the last detachment, the turns drawn over one another.

    Turns follow one another in two shades, and so do the impacts in them.
    """
    points = trace.events.get("detachment", np.array([[trace.high - AROUND, 0.0]]))
    middle = points[-1, 0] % TURN_DEG
    phase = (trace.angle - middle + TURN_DEG / 2.0) % TURN_DEG - TURN_DEG / 2.0 + middle
    low, high = middle - AROUND, middle + AROUND / 2.0
    gap = np.where((phase > low) & (phase < high), trace.gap, np.nan)
    impacts = trace.events.get("impact", np.empty((0, 2)))[:, 0]
    turn, impact_turn = (
        np.floor((x - middle + TURN_DEG / 2.0) / TURN_DEG) for x in (trace.angle, impacts)
    )
    shades = [
        (style.FLIGHT, style.IMPACT, "impact"),
        (PALE_FLIGHT, "white", "impact of every second turn"),
    ]
    if simulation.repeats == 1:  # then both turns are the same
        del shades[1]
    for own, (colour, face, name) in enumerate(shades):
        for sticking, shade, width in ((False, colour, 1.0), (True, style.STICKING, 3.0)):
            there = (trace.sticks == sticking) & (turn % len(shades) == own)
            part = trace.during(gap, there)
            part = np.where(turn % len(shades) == own, part, np.nan)  # not on to the turn after it
            axes.plot(np.where(np.isnan(part), np.nan, phase), part, color=shade, lw=width)
        at = impacts[impact_turn % len(shades) == own]
        at = (at - middle + TURN_DEG / 2.0) % TURN_DEG - TURN_DEG / 2.0 + middle
        at = at[(at > low) & (at < high)]
        look: dict[str, Any] = {"mfc": face, "mec": style.IMPACT, "ms": 3.0, "mew": 0.6}
        axes.plot(at, np.zeros(len(at)), "o", zorder=4, label=name, **look)
    axes.axhline(0.0, color=style.CAM, linewidth=0.6)
    inside = gap[phase < middle]
    largest = float(np.nanmax(inside) or 2.5 * np.nanmax(gap) or 1.0)  # it may rest before
    axes.set(xlim=(low, high), ylim=(-0.03 * largest, 0.4 * largest))
    axes.set_xlabel(THETA.label)
    length_axis(axes.yaxis, GAP, 0.4 * largest)
    corner_lines(axes, style.corner_names(simulation.corners).items(), "x")


def _draw_section(axes: Axes, trace: Trace, _: Simulation) -> None:
    """The states of all recorded turns at the strobe phase."""
    axes.plot(*trace.section.T, "o", color=style.IMPACT, ms=1.5, mew=0.0, rasterized=True)
    unit_axis(axes.xaxis, "stroboscopic $q$", trace.units)
    axes.set_ylabel(labelled("stroboscopic $v$", V.unit))


def angle_axis(axes: Axes, trace: Trace) -> None:
    """Ticks in degrees within the turn, or in turns where there are many; a line per turn."""
    span = trace.high - trace.low
    most = max(2, int(axes.get_window_extent().width / style.DPI * 72.0 / TICK))
    step = next((s for s in STEPS if span <= s * most), 360 * ceil(span / TURN_DEG / most))
    ticks = step * np.arange(ceil(trace.low / step - 1e-9), floor(trace.high / step + 1e-9) + 1)
    within = step < TURN_DEG
    names = [f"{tick % 360 if within else tick // 360:d}" for tick in ticks]
    axes.set(xlim=(trace.low, trace.high), xticks=ticks)
    axes.set_xticklabels(names)
    axes.set_xlabel(THETA.label if within else "cam angle (turns)")
    for tick in ticks[ticks % 360 == 0]:
        axes.axvline(tick, color=style.GUIDE, linewidth=0.5, zorder=0.5)


# --- the machine in motion

DPI, WIDE, HIGH = 100, 9.6, 5.4  # inches: 960 x 540 pixels
WORDS, NUMBERS = 10, 9  # pt, of words and of numbers along axes
MOST_TICKS = 6  # along the positions
FRAMES, FRAMES_PER_S = 60, 30  # of a turn, which takes two seconds
NEAR_FRAMES, NEAR_DEG = 180, 8.0  # of a turn, so close to a hard impact
HARD = 0.1  # of the hardest impact


def hard_impacts(trace: Trace) -> np.ndarray:
    """Angles (deg) of the impacts with at least HARD of the hardest one's velocity."""
    angles = trace.events.get("impact", np.empty((0, 2)))[:, 0]
    speeds = np.abs(trace.jumps[:, 0])
    return angles[speeds >= HARD * speeds.max(initial=0.0)]


def frame_angles(
    low: float,
    high: float,
    impacts: np.ndarray,
    frames: int = FRAMES,
    near_frames: int = NEAR_FRAMES,
) -> np.ndarray:
    """Cam angles (deg) of the frames from low to high: close together near the impacts.

    A turn has `frames` of them. Where a frame or the one before is within NEAR_DEG of an impact,
    they are as close as if a turn had `near_frames`. The last one is as far from the end as the
    others are from one another.
    """
    wide, narrow = TURN_DEG / frames, TURN_DEG / near_frames
    found = [low]
    while True:
        place = found[-1]
        near = (impacts > place - NEAR_DEG) & (impacts < place + wide + NEAR_DEG)
        place += narrow if near.any() else wide
        if place >= high - 1e-6:
            return np.array(found)
        found.append(place)


def draw_frames(
    simulation: Simulation,
    system: System,
    outline: Outline,
    turns: int,
    frames: int = FRAMES,
    near_frames: int = NEAR_FRAMES,
) -> Iterator[Figure]:
    """The last `turns` turns as one figure that is drawn anew for each frame.

    Of a motion with a shorter period one period, so that the end joins the beginning. frames,
    near_frames: of a turn, see `frame_angles`.
    """
    trace = Trace.of(simulation, system, min(turns, simulation.repeats or turns))
    turn = trace.low // TURN_DEG * TURN_DEG  # the first one shown is counted from 0
    angles = trace.angle - turn
    low = trace.low - turn
    high = trace.high - turn
    kind = kind_of_cam(system)
    places = frame_angles(low, high, hard_impacts(trace) - turn, frames, near_frames)
    evenly = ceil((high - low) / TURN_DEG * frames)
    slower_near_impacts = near_frames / frames if len(places) > evenly else 1.0
    speed = slowed(simulation.rpm, frames / FRAMES_PER_S, slower_near_impacts)
    with style.look():
        figure = Figure(figsize=(WIDE, HIGH), dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        machine, course = figure.subplots(1, 2, width_ratios=(2, 3))
        _draw_course(course, trace, angles, kind)
        course.set(xlim=(low, high))
        course.xaxis.set_major_locator(MultipleLocator(60 if high - low <= TURN_DEG else 180))
        course.set_title(f"{motion_title(simulation, kind)}\n{speed}", size=WORDS)
        line = course.axvline(color=style.GUIDE, lw=0.8)
        (dot,) = course.plot([], [], "o")
        figure.canvas.draw()
        figure.set_layout_engine("none")
    highest = float(trace.gap.max() / outline.ratio + outline.radius.max())
    for angle in places:
        gap = float(np.interp(angle, angles, trace.gap))
        q = float(np.interp(angle, angles, trace.q))
        line.set_xdata([angle])
        dot.set(data=([angle], [q]), color=style.FLIGHT if gap > 0.0 else style.STICKING)
        with style.look():
            machine.clear()
            draw_machine(machine, outline, gap / outline.ratio, angle % TURN_DEG, highest)
        yield figure


def _draw_course(axes: Axes, trace: Trace, angles: np.ndarray, kind: str) -> None:
    """The positions of cam and follower beside the machine; rests are thicker than flights.

    angles: those of the trace, counted from the first turn shown, deg; kind: of the cam.
    """
    axes.fill_between(angles, trace.cam.min(), trace.cam, color=style.CAM_BODY, lw=0)
    axes.plot(angles, trace.cam, color=style.CAM, lw=0.8)
    states = {
        "in flight": (~trace.sticks, style.FLIGHT, 1.4),
        f"at rest {on_the_cam(kind)}": (trace.sticks & ~trace.seated, style.STICKING, 3.0),
        "at rest on the seat": (trace.seated, style.CAM, 3.0),
    }
    for words, (state, colour, width) in states.items():
        if state.any():
            part = trace.during(trace.q, state)
            axes.plot(angles, part, color=colour, lw=width, label=words)
    unit_axis(axes.yaxis, "position", trace.units, size=WORDS)
    axes.set_xlabel(THETA.label, size=WORDS)
    axes.tick_params(labelsize=NUMBERS)
    axes.yaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 5, 10]))
    axes.legend(loc="upper left", fontsize=WORDS)
