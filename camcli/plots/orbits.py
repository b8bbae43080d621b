"""Pictures of periodic orbits: their branches over a parameter, and curves in two parameters."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.border_collision import Side
from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Branch, OrbitsResult
from camcli.plots import style
from camcli.plots.axes import (
    DASHED,
    TURN_DEG,
    at_strobe,
    corners_upwards,
    event_lines,
    event_numbers,
    legend,
    mark,
    padded,
    phase_axis,
    phase_range,
    row_middle,
    text_row,
    text_rows,
)
from camcli.plots.event_words import event_words
from camcli.plots.multipliers import draw_paths, draw_plane, draw_real, pair
from camcli.plots.orbit_lines import (
    Event,
    Strand,
    colours,
    curved,
    draw_strands,
    events_of,
    paths,
    phases,
    positions,
    radius,
    strands,
)
from camcli.plots.orbit_single import draw_single
from camcli.plots.style import BOTTOM, LEFT, RIGHT, WIDE
from camcli.system import System

HEAD, NUMBERS, GAP, STEP = 96, 84, 36, 155  # px: titles, numbers of events, between panels
PHASE, STROBE, PLANE = 600, 330, 500  # px, heights of the panels
ROOM = 0.02  # of the range of the parameter, beyond it
PANELS = ("branches", "multipliers", "events")
PARAMETERS = {  # name and unit
    "rpm": ("cam speed", "rpm"),
    "restitution": ("coefficient of restitution", ""),
    "damping": ("damping", "N s/m"),
    "gravity": ("gravity", "m/s²"),
    "stiffness": ("stiffness", "N/m"),
    "preload": ("preload", "N"),
    "mass": ("mass", "kg"),
}


@dataclass(frozen=True)
class _Scene:
    """A study with what its panels share."""

    study: OrbitsResult
    branches: Sequence[Branch]
    colours: list[str]
    events: list[Event]
    corners: dict[str, float]
    parameter: str

    def lines(self, of: Callable[[Sequence[PeriodicOrbit]], list[Strand]]) -> list[list[Strand]]:
        """What `of` makes of the points of every branch."""
        return [of(branch.points) for branch in self.branches]

    def every(self, of: Callable[[PeriodicOrbit], Sequence[float]]) -> np.ndarray:
        """Values of all points of all branches."""
        points = (orbit for branch in self.branches for orbit in branch.points)
        return np.array([value for orbit in points for value in of(orbit)])


@style.look()
def draw_orbits(study: OrbitsResult, system: System, panels: Sequence[str] = PANELS) -> Figure:
    """Picture of a study, or of some of its panels; of the orbits of one speed without branches."""
    title, words = _heading(study)
    if not study.branches:
        return draw_single(study, system, title, words)
    corners = style.corner_names(system.corners_deg)
    events = events_of(study.bifurcations, corners)
    shades = colours([branch.points for branch in study.branches])
    scene = _Scene(study, study.branches, shades, events, corners, study.question.parameter)
    zooms = hidden(scene.branches, events, corners) if "events" in panels else []
    top = HEAD + style.LINE * list_rows(scene.branches, events) + NUMBERS
    branches, multipliers = "branches" in panels, "multipliers" in panels
    height = top + (PHASE + GAP + STROBE) * branches + (PLANE + BOTTOM) * multipliers
    height += STEP * branches * (multipliers or bool(zooms)) or BOTTOM * branches
    figure = style.page(height + (ZOOM + 60) * len(zooms), title, words)
    draw_lists(figure, HEAD, scene.branches, shades, events, scene.parameter)
    if branches:
        upper = style.place(figure, LEFT, top, WIDE, PHASE)
        lower = style.place(figure, LEFT, top + PHASE + GAP, WIDE, STROBE)
        _draw_phases(upper, scene)
        _draw_positions(lower, scene, system)
        top += PHASE + GAP + STROBE + STEP
    if multipliers:
        _draw_multipliers(figure, top, scene)
        top += PLANE + BOTTOM + 20
    for zoom in zooms:
        _draw_zoom(figure, top, zoom, scene)
        top += ZOOM + 60
    return figure


def _heading(study: OrbitsResult) -> tuple[str, str]:
    """Title and what stands below it."""
    ask = study.question
    at, name = quantity(ask.rpm, "rpm"), PARAMETERS[ask.parameter][0]
    if ask.span is None:
        title = f"Periodic orbits at {at}"
    else:
        ends = f"{style.number(ask.span.low)} to {quantity(ask.span.high, ask.parameter)}"
        title = f"Periodic orbits, {ends if ask.parameter == 'rpm' else f'{name} {ends}, {at}'}"
    varied = ask.span is not None and ask.parameter != "rpm"
    where = f"{name} {quantity(study.value, ask.parameter)}" if varied else at
    count = len(study.orbits)
    words = f"{count} orbit{'s' if count != 1 else ''} found at {where}"
    if ask.label is not None:
        words += f", only {style.motion(ask.label)} asked for"
    if ask.stable is not None:
        words += f", only {'stable' if ask.stable else 'unstable'} ones followed"
    if study.absent is not None and study.orbits:
        words += f", none at {quantity(study.absent.rpm, 'rpm')}"
    return title, words


def quantity(value: float, parameter: str) -> str:
    """A value of the parameter with its unit."""
    return f"{style.number(float(f'{value:.9g}'))} {PARAMETERS[parameter][1]}".rstrip()


def axis_name(parameter: str) -> str:
    """Label of the axis of a parameter."""
    name, unit = PARAMETERS[parameter]
    return f"{name} ({unit or '-'})"


# --- panels over the parameter


def _range(axes: Axes, scene: _Scene) -> None:
    """The range of the parameter, and a line at every event in it."""
    span, values = scene.study.question.span, scene.every(lambda orbit: [orbit.value])
    low, high = (values.min(), values.max()) if span is None else (span.low, span.high)
    room = ROOM * (high - low) or 0.01 * abs(high) or 1.0
    axes.set_xlim(low - room, high + room)
    event_lines(axes, [event.value for event in scene.events])


def _draw_phases(axes: Axes, scene: _Scene) -> None:
    """Phases of the impacts, or of the departures of an orbit that rests."""
    every = scene.every(phases)
    phase_axis(axes, *phase_range(every))
    if not len(every):
        style.note(axes, "the follower never leaves the cam")
    _range(axes, scene)
    lines = scene.lines(partial(strands, of=phases, turn=TURN_DEG))
    _draw_branches(axes, scene, lines, phases)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
    for branch in scene.branches:
        for orbit in _lost(branch):
            mark(axes, Kind.LOST, [orbit.value] * len(phases(orbit)), phases(orbit))
    corners_upwards(axes, scene.corners.items())
    rests = {orbit.resting for branch in scene.branches for orbit in branch.points}
    what = " or ".join({False: "impact", True: "departure"}[rest] for rest in sorted(rests))
    axes.set_ylabel(rf"{what} phase $\theta$ (deg)")
    axes.tick_params(labelbottom=False)
    _number_events(axes, scene.events)
    number_branches(axes, lines, scene.branches, scene.colours, scene.events)


def _lost(branch: Branch) -> list[PeriodicOrbit]:
    """The points at which a branch could not be followed further."""
    return [branch.points[-k] for k in (0, 1) if branch.ends[k] == Kind.LOST]


def _draw_branches(
    axes: Axes,
    scene: _Scene,
    lines: Sequence[Sequence[Strand]],
    of: Callable[[PeriodicOrbit], Sequence[float]],
) -> None:
    """All branches; one of a single point as a dot."""
    for branch, mine, colour in zip(scene.branches, lines, scene.colours, strict=True):
        draw_strands(axes, mine, colour)
        if len(branch.points) == 1:
            values = of(branch.points[0])
            x = [branch.points[0].value] * len(values)
            axes.plot(x, values, "o", color=colour, ms=3.0, zorder=4)


def _draw_positions(axes: Axes, scene: _Scene, system: System) -> None:
    """Stroboscopic positions."""
    every = scene.every(positions)
    axes.set_ylim(*padded(every, 0.1 * abs(every).max(initial=0.0) or 1.0))
    _range(axes, scene)
    _draw_branches(axes, scene, scene.lines(partial(strands, of=positions)), positions)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.positions), event.positions)
    axes.set_ylabel(f"$q$ (m) at {at_strobe(system)}")
    axes.set_xlabel(axis_name(scene.parameter))


def _draw_multipliers(figure: Figure, top: int, scene: _Scene) -> None:
    """The plane beside the real parts over the parameter."""
    lines = scene.lines(paths)
    plane = style.place(figure, LEFT, top, PLANE, PLANE)
    draw_plane(plane, float(scene.every(lambda orbit: [radius(orbit)]).max()))
    rising = f"multipliers; arrows: rising {PARAMETERS[scene.parameter][0]}"
    style.write(figure, LEFT, top - 36, rising)
    for k, (mine, colour) in enumerate(zip(lines, scene.colours, strict=True)):
        draw_paths(plane, mine, colour, 0.62 - 0.24 * (k % 3) / 2.0)
    left = LEFT + PLANE + 150
    axes = style.place(figure, left, top, style.WIDTH - RIGHT - left, PLANE)
    _range(axes, scene)
    draw_real(axes, lines, scene.colours)
    axes.set_xlabel(axis_name(scene.parameter))


# --- lists above the panels, and the numbers in them

LONGEST, WORDS = 24, 33  # rows of a list, characters of a branch in it
MIDDLE = 455  # px, where the list of events begins
COLUMNS = [MIDDLE + x for x in (30, 70, 345, 500, 585)]  # number, name, place, branches, notes
CLEAR, ROOMY = 17.0, 45.0  # px from a branch's number to all else: least, and enough
EDGE = 0.03  # of a panel, where no number is put
TRIED = 300  # points of a branch at most that are looked at


def list_rows(branches: Sequence[Branch], events: Sequence[Event]) -> int:
    """Lines of text that the lists need."""
    return 1 + min(max(len(branches), len(events)), LONGEST + 1)


def draw_lists(
    figure: Figure,
    top: int,
    branches: Sequence[Branch],
    shades: Sequence[str],
    events: Sequence[Event],
    parameter: str,
) -> None:
    """Branches on the left, events on the right, from `top` downwards."""
    axes = text_rows(figure, top, list_rows(branches, events))
    _line(axes, 20, 0, "stable", style.CAM, "-")
    _line(axes, 200, 0, "unstable", style.CAM, DASHED)
    for row, (branch, colour) in enumerate(zip(branches[:LONGEST], shades, strict=False), 1):
        _line(axes, 20, row, _branch_words(branch, events, parameter), colour, "-")
    if events:
        unit = PARAMETERS[parameter][1]
        heads = ("no.", "event", f"at ({unit})" if unit else "at", "branch")
        text_row(axes, 0, COLUMNS, heads, color=style.CAM)
    for row, event in enumerate(events[:LONGEST], 1):
        mark(axes, event.source.kind, [MIDDLE + 10], [row_middle(row)])
        text_row(axes, row, COLUMNS, _event_cells(event))
    for left, count in ((20, len(branches)), (MIDDLE, len(events))):
        if count > LONGEST:
            text_row(axes, LONGEST + 1, [left], [f"and {count - LONGEST} more, in the tables"])


def _line(axes: Axes, left: int, row: int, words: str, colour: str, dashes: Any) -> None:
    y = [row_middle(row)] * 2
    axes.plot([left, left + 44], y, color=colour, linewidth=1.4, linestyle=dashes)
    text_row(axes, row, [left + 58], [words])


def _branch_words(branch: Branch, events: Sequence[Event], parameter: str) -> str:
    names = [style.motion(label, 22) for label in branch.labels]
    words = f"{branch.number}   {names[0]}" + (f" to {names[-1]}" if len(names) > 1 else "")
    source = [event.number for event in events if branch.number in event.leaves]
    if source:
        words += f", from event {source[0]}"
    for orbit in _lost(branch)[:1]:
        words += f", lost at {quantity(orbit.value, parameter)}"
    return words if len(words) <= WORDS else words[: WORDS - 1] + "…"


def _event_cells(event: Event) -> tuple[str, ...]:
    notes = [event.source.classification.replace("-", " ")]
    notes += [f"{', '.join(map(str, event.leaves))} leaves"] if event.leaves else []
    notes += [event.source.status] if event.source.status != Bracket.OK else []
    value, on = style.number(float(f"{event.value:.9g}")), ", ".join(map(str, event.branches))
    return str(event.number), event.name, value, on, "; ".join(filter(None, notes))


def _number_events(axes: Axes, events: Sequence[Event]) -> None:
    """The numbers of the listed events above a panel."""
    event_numbers(axes, [(event.number, event.value) for event in events[:LONGEST]])


def number_branches(
    axes: Axes,
    every: Sequence[Sequence[Strand]],
    branches: Sequence[Branch],
    shades: Sequence[str],
    events: Sequence[Event],
) -> None:
    """The branches' numbers on their lines, each where most room is; none where there is not."""
    pixels = [
        _pixels(axes, [(x, y) for s in lines for x, y in zip(s.x, s.y, strict=True)])
        for lines in every
    ]
    taken = [_pixels(axes, [(event.value, y) for event in events for y in event.phases])]
    box = axes.get_window_extent()
    edge = np.array([box.width, box.height]) * EDGE
    for k, (branch, colour) in enumerate(zip(branches, shades, strict=True)):
        mine = pixels[k]
        mine = mine[((mine > edge) & (mine < [box.width, box.height] - edge)).all(axis=1)]
        if not len(mine):
            continue
        others = np.concatenate([*taken, *pixels[:k], *pixels[k + 1 :]])
        steps = mine[:, None] - others[None]
        away = np.hypot(steps[..., 0], steps[..., 1]).min(axis=1, initial=np.inf)
        if away.max() < CLEAR:
            continue
        good = mine[away >= min(ROOMY, away.max())]
        best = good[int(np.argmin(np.round(abs(good[:, 0] - mine[:, 0].mean()), 3)))]
        taken.append(np.array([best, best + 12.0, best - 12.0]))
        x, y = axes.transData.inverted().transform(best + np.array([box.x0, box.y0]))
        look: dict[str, Any] = {"size": 7, "weight": "bold", "color": colour, "zorder": 5}
        look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        axes.text(x, y, str(branch.number), ha="center", va="center_baseline", **look)


def _pixels(axes: Axes, points: Sequence[tuple[float, float]]) -> np.ndarray:
    """Points in pixels from the lower left corner of the axes."""
    if not points:
        return np.empty((0, 2))
    box = axes.get_window_extent()
    few = np.asarray(points[:: 1 + len(points) // TRIED], dtype=float)
    return axes.transData.transform(few) - [box.x0, box.y0]


# --- a corner impact that hides beside another event, enlarged, with the numbers on both sides

ZOOM, TALL, ZOOM_LEFT, ZOOM_WIDE = 560, 440, 160, 545  # px: with its axis, the panel
MOST = 2  # panels
HIDDEN = 0.005  # of the range, the distance to another event that hides a corner impact
AROUND = 1.8  # times that distance, shown on either side
REACH = 2.2  # times the phase's way from there to the corner, shown on either side
CHARS = 54
UNSAID = "The theorem"  # beginning of sentences left to the report


@dataclass(frozen=True)
class Zoom:
    """A corner impact, the phase of its corner, and how far around it is shown."""

    event: Event
    corner_deg: float
    aside: float
    reach: float

    @property
    def range(self) -> tuple[float, float]:
        """Of the parameter."""
        return self.event.value - self.aside, self.event.value + self.aside


def hidden(
    branches: Sequence[Branch], events: Sequence[Event], corners: dict[str, float]
) -> list[Zoom]:
    """Of the corner impacts those hardest to see, in ascending order."""
    values = [orbit.value for branch in branches for orbit in branch.points]
    width = max(values) - min(values)
    found = []
    for event in events:
        source = event.source
        if source.kind != Kind.CORNER_IMPACT or source.corner not in corners or source.left is None:
            continue
        near = [other for other in events if 0.0 < abs(other.value - event.value) < HIDDEN * width]
        if near:
            other = min(near, key=lambda other: abs(other.value - event.value))
            corner = corners[source.corner]
            way = min(abs(phase - corner) for phase in other.phases)
            aside = AROUND * abs(other.value - event.value)
            found.append(Zoom(event, corner, aside, REACH * max(way, 0.05)))
    first = sorted(found, key=lambda zoom: zoom.aside)[:MOST]
    return sorted(first, key=lambda zoom: zoom.event.value)


def _draw_zoom(figure: Figure, top: int, zoom: Zoom, scene: _Scene) -> None:
    """The panel on the left, words on the right."""
    axes = style.place(figure, ZOOM_LEFT, top + 60, ZOOM_WIDE, TALL)
    (low, high), name = zoom.range, axis_name(scene.parameter)
    axes.set(xlim=(low, high), xlabel=name, ylabel=r"phase $\theta$ (deg), enlarged")
    axes.locator_params(axis="x", nbins=5)
    lines = scene.lines(lambda points: strands(curved(points, low, high), phases, TURN_DEG))
    points = [(x, y) for mine in lines for s in mine for x, y in zip(s.x, s.y, strict=True)]
    near = [y for x, y in points if low <= x <= high and abs(y - zoom.corner_deg) <= zoom.reach]
    bottom, highest = min([zoom.corner_deg, *near]), max([zoom.corner_deg, *near])
    room = 0.1 * (highest - bottom) or 0.1
    axes.set_ylim(bottom - room, highest + room)
    for mine, colour in zip(lines, scene.colours, strict=True):
        draw_strands(axes, mine, colour)
    inside = [event for event in scene.events if low <= event.value <= high]
    for event in inside:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
    event_lines(axes, [event.value for event in inside])
    corners_upwards(axes, scene.corners.items())
    _number_events(axes, inside)
    number_branches(axes, lines, scene.branches, scene.colours, inside)
    _write_sides(figure, top + 24, zoom.event)


def _write_sides(figure: Figure, top: int, event: Event) -> None:
    """The linear parts on both sides of the corner and what follows from them."""
    left, source = ZOOM_LEFT + ZOOM_WIDE + 65, event.source
    title = f"{event.number}: {style.motion(source.label, 24)}, {event.name}"
    style.write(figure, left, top, title, weight="bold")
    words = [line.replace("+-", "±") for line in event_words(source) if not line.startswith(UNSAID)]
    sides = ("before the corner (left)", source.left), ("after the corner (right)", source.right)
    lines = [f"impact {where}: {_side(side)}" for where, side in sides if side is not None]
    lines += [re.sub(r"(?<= )-(?=\d)", "−", line) for line in words]
    text = [part for line in lines for part in textwrap.wrap(line, CHARS, subsequent_indent="  ")]
    room = ZOOM // style.LINE - 2
    text = text if len(text) <= room else [*text[: room - 1], "…"]
    style.write(figure, left, top + 40, "\n".join(text), linespacing=1.25, size=7)


def _side(one: Side) -> str:
    """Trace, determinant and multipliers of one side."""
    trace = f"{one.trace:.6g}".replace("-", "−")
    return f"trace {trace}, determinant {one.det:.6g}, µ = {pair(one.trace, one.det)}"


# --- curves in two parameters

CURVE_HEAD, CURVE_HEIGHT = 60, 800  # px, above the legend, of the panel
CURVE_STYLES = ("-", "--", ":", "-.")


@style.look()
def draw_curves(curves: Sequence[Curve], second: str) -> Figure:
    """Picture of bifurcation curves over rpm and a second parameter; an open circle is an end."""
    early = any(end != "end-of-range" for curve in curves for end in curve.ends)
    top = CURVE_HEAD + style.LINE * max(1, len(curves) + early) + 20
    figure = style.page(top + CURVE_HEIGHT + BOTTOM, "Bifurcations in two parameters")
    axes = style.place(figure, LEFT, top, WIDE, CURVE_HEIGHT)
    if not curves:
        style.note(axes, "no bifurcation of this kind was located")
        axes.set(xticks=[], yticks=[])
        return figure
    shades = style.apart([style.label_colour(curve.label) for curve in curves])
    for k, (curve, colour) in enumerate(zip(curves, shades, strict=True)):
        dashes = CURVE_STYLES[shades[:k].count(colour) % len(CURVE_STYLES)]
        _draw_curve(axes, curve, colour, dashes)
    if early:
        name = "the curve ends within range"
        axes.plot([], [], "o", color=style.CAM, mfc="white", label=name)
    legend(figure, CURVE_HEAD - 6, *axes.get_legend_handles_labels())
    axes.set_xlabel(axis_name(curves[0].first))
    axes.set_ylabel(axis_name(second))
    return figure


def _draw_curve(axes: Axes, curve: Curve, colour: str, dashes: str) -> None:
    """A curve, named with its orbit and why it ends, in the colour of the orbit."""
    corner = f" at {curve.corner}" if curve.corner else ""
    name = f"{curve.kind.replace('-', ' ')}{corner} of {style.motion(curve.label)}"
    ends = {end for end in curve.ends if end != "end-of-range"}
    name += f" (ends: {'; '.join(sorted(ends))})" if ends else ""
    x, y = [point.first for point in curve.points], [point.second for point in curve.points]
    axes.plot(x, y, color=colour, linestyle=dashes, label=name)
    for place, end in zip((0, -1), curve.ends, strict=True):
        if curve.points and end != "end-of-range":
            axes.plot([x[place]], [y[place]], "o", color=colour, mfc="white", zorder=5)
