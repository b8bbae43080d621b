"""Picture of periodic orbits: their branches over a parameter, or those of one speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import degrees

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from camcli.analysis.orbits.locate import LOST
from camcli.analysis.orbits.study import Branch, OrbitsResult
from camcli.plots import style
from camcli.plots.axes import padded, phase_range, spread
from camcli.plots.multipliers import draw_paths, draw_plane, draw_real
from camcli.plots.orbit_keys import (
    UNITS,
    draw_lists,
    number_branches,
    number_events,
    quantity,
    rows,
)
from camcli.plots.orbit_lines import (
    Event,
    Strand,
    branch_colours,
    draw,
    events,
    mark,
    paths,
    phases,
    positions,
    radius,
    strands,
)
from camcli.plots.orbit_single import draw_single
from camcli.plots.orbit_zoom import ZOOM, draw_zoom, zooms
from camcli.system import System

LEFT, RIGHT, BOTTOM = 140, 60, 95  # px, margins
HEAD, NUMBERS, GAP, STEP = 96, 84, 36, 155  # px: titles, numbers of events, between panels
PHASE, STROBE, PLANE = 600, 330, 500  # px, heights of the panels
WIDE = style.WIDTH - LEFT - RIGHT
ROOM = 0.02  # of the range of the parameter, beyond it
PANELS = ("branches", "multipliers", "events")
NAMES = {
    "rpm": "cam speed",
    "restitution": "coefficient of restitution",
    "damping": "damping",
    "gravity": "gravity",
    "stiffness": "stiffness",
    "preload": "preload",
    "mass": "mass",
}


@dataclass(frozen=True)
class _Scene:
    """A study with what its panels share."""

    study: OrbitsResult
    colours: list[str]
    events: list[Event]
    corners: dict[str, float]

    @property
    def branches(self) -> list[Branch]:
        """Of the study."""
        return self.study.branches

    def lines(self, of: Callable) -> list[list[Strand]]:
        """What `of` makes of the points of every branch."""
        return [of(branch.points) for branch in self.branches]


@style.look()
def draw_orbits(study: OrbitsResult, system: System, panels: Sequence[str] = PANELS) -> Figure:
    """Picture of a study, or of some of its panels."""
    if not study.branches:
        return draw_single(study, system, heading(study))
    corners = style.corner_names(system.corners_deg)
    found = events(study.bifurcations, corners)
    scene = _Scene(study, branch_colours(study.branches), found, corners)
    close = zooms(study.branches, found, corners) if "events" in panels else []
    top = HEAD + style.LINE * rows(study.branches, found) + NUMBERS
    branches, multipliers = "branches" in panels, "multipliers" in panels
    height = top + (PHASE + GAP + STROBE) * branches + (PLANE + BOTTOM) * multipliers
    height += STEP * branches * (multipliers or bool(close)) or BOTTOM * branches
    height += (ZOOM + 60) * len(close)
    figure = style.page(height)
    for line, (words, look) in enumerate(heading(study)):
        style.write(figure, 20, 14 + 40 * line, words, **look)
    parameter = study.question.parameter
    draw_lists(figure, HEAD, study.branches, scene.colours, found, parameter)
    if branches:
        below = style.place(figure, LEFT, top + PHASE + GAP, WIDE, STROBE)
        _draw_phases(style.place(figure, LEFT, top, WIDE, PHASE), scene)
        _draw_positions(below, scene, system)
        top += PHASE + GAP + STROBE + STEP
    if multipliers:
        _draw_multipliers(figure, top, scene)
        top += PLANE + BOTTOM + 20
    for zoom in close:
        draw_zoom(
            figure,
            top,
            zoom,
            scene.branches,
            scene.colours,
            found,
            axis_name(study.question.parameter),
        )
        top += ZOOM + 60
    return figure


def heading(study: OrbitsResult) -> list[tuple[str, dict]]:
    """Title and subtitle with their looks."""
    ask = study.question
    at = quantity(ask.rpm, "rpm")
    if ask.span is None:
        title = f"Periodic orbits at {at}"
    else:
        ends = f"{style.number(ask.span.low)} to {quantity(ask.span.high, ask.parameter)}"
        varied = ends if ask.parameter == "rpm" else f"{NAMES[ask.parameter]} {ends}, {at}"
        title = f"Periodic orbits, {varied}"
    count = f"{len(study.orbits)} orbit" + ("s" if len(study.orbits) != 1 else "")
    where = at
    if ask.span is not None and ask.parameter != "rpm":
        where = f"{NAMES[ask.parameter]} {quantity(study.value, ask.parameter)}"
    words = f"{count} found at {where}"
    if ask.label is not None:
        words += f", only {style.motion(ask.label)} asked for"
    if ask.stable is not None:
        words += f", only {'stable' if ask.stable else 'unstable'} ones followed"
    if study.absent is not None and study.orbits:
        words += f", none at {quantity(study.absent.rpm, 'rpm')}"
    return [(title, {"size": 9, "weight": "bold"}), (words, {})]


def axis_name(parameter: str) -> str:
    """Label of the axis of a parameter."""
    return f"{NAMES[parameter]} ({UNITS[parameter] or '-'})"


def _range(axes: Axes, scene: _Scene) -> None:
    """The range of the parameter, and a line at every event in it."""
    span = scene.study.question.span
    values = [orbit.value for branch in scene.branches for orbit in branch.points]
    low, high = (min(values), max(values)) if span is None else (span.low, span.high)
    room = ROOM * (high - low) or 0.01 * abs(high) or 1.0
    axes.set_xlim(low - room, high + room)
    for event in scene.events:
        axes.axvline(event.value, color=style.GUIDE, linewidth=0.5, linestyle=(0, (1, 2)), zorder=1)


def _draw_phases(axes: Axes, scene: _Scene) -> None:
    """Phases of the impacts, or of the departures of an orbit that rests."""
    lines = scene.lines(partial(strands, of=phases, turn=360.0))
    every = [x for branch in scene.branches for orbit in branch.points for x in phases(orbit)]
    low, high = phase_range(np.array(every))
    axes.set_ylim(low, high)
    if not every:
        style.note(axes, "the follower never leaves the cam")
    _range(axes, scene)
    _curves(axes, scene, lines, phases)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
    for orbit in (
        branch.points[-k] for branch in scene.branches for k in (0, 1) if branch.ends[k] == LOST
    ):
        mark(axes, LOST, [orbit.value] * len(phases(orbit)), phases(orbit))
    _corner_lines(axes, scene.corners)
    if (low, high) == (0.0, 360.0):
        axes.yaxis.set_major_locator(MultipleLocator(60))
    axes.set_ylabel(_phase_name(scene.branches))
    axes.tick_params(labelbottom=False)
    number_events(axes, scene.events, WIDE, PHASE)
    names = [str(branch.number) for branch in scene.branches]
    number_branches(axes, lines, names, scene.colours, scene.events)


def _phase_name(branches: Sequence[Branch]) -> str:
    rests = {orbit.resting for branch in branches for orbit in branch.points}
    what = {(False,): "impact", (True,): "departure"}.get(tuple(rests), "impact or departure")
    return rf"{what} phase $\theta$ (deg)"


def _curves(axes: Axes, scene: _Scene, lines: Sequence[Sequence[Strand]], of: Callable) -> None:
    """All branches; one of a single point as a dot."""
    for branch, mine, colour in zip(scene.branches, lines, scene.colours, strict=True):
        draw(axes, mine, colour)
        if len(branch.points) == 1:
            values = of(branch.points[0])
            x = [branch.points[0].value] * len(values)
            axes.plot(x, values, "o", color=colour, markersize=3.0, zorder=4)


def _corner_lines(axes: Axes, corners: dict[str, float]) -> None:
    """The cam's corners as lines named at the right edge."""
    low, high = axes.get_ylim()
    seen = {name: phase for name, phase in corners.items() if low <= phase <= high}
    places = spread(list(seen.values()), 24.0 * (high - low) / PHASE, low, high)
    for (name, phase), place in zip(seen.items(), places, strict=True):
        axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
        at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
        axes.text(1.012, place, name, color=style.CAM, **at)


def _draw_positions(axes: Axes, scene: _Scene, system: System) -> None:
    every = [q for branch in scene.branches for orbit in branch.points for q in positions(orbit)]
    largest = max(map(abs, every), default=0.0)
    axes.set_ylim(*padded(np.array(every), 0.1 * largest or 1.0))
    _range(axes, scene)
    _curves(axes, scene, scene.lines(partial(strands, of=positions)), positions)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.positions), event.positions)
    phase = style.number(round(degrees(system.strobe), 9))
    axes.set_ylabel(rf"$q$ (m) at $\theta$ = {phase} deg")
    axes.set_xlabel(axis_name(scene.study.question.parameter))


def _draw_multipliers(figure: Figure, top: int, scene: _Scene) -> None:
    """The plane beside the real parts over the parameter."""
    lines = scene.lines(paths)
    plane = style.place(figure, LEFT, top, PLANE, PLANE)
    largest = max(radius(orbit) for branch in scene.branches for orbit in branch.points)
    draw_plane(plane, largest)
    rising = f"multipliers; arrows: rising {NAMES[scene.study.question.parameter]}"
    style.write(figure, LEFT, top - 36, rising)
    for k, (mine, colour) in enumerate(zip(lines, scene.colours, strict=True)):
        draw_paths(plane, mine, colour, 0.62 - 0.24 * (k % 3) / 2.0)
    left = LEFT + PLANE + 150
    axes = style.place(figure, left, top, style.WIDTH - RIGHT - left, PLANE)
    _range(axes, scene)
    draw_real(axes, lines, scene.colours)
    axes.set_xlabel(axis_name(scene.study.question.parameter))
