"""Pictures of periodic orbits: branches over a parameter, orbits of one speed, curves in two."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from camcli.analysis.orbits.curves import Curve
from camcli.analysis.orbits.kinds import Bracket, Kind
from camcli.analysis.orbits.one_period import MOST_SHOWN
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.analysis.orbits.study import Branch, OrbitsResult
from camcli.analysis.simulate import Simulation
from camcli.analysis.sweep import Sweep
from camcli.plots import style
from camcli.plots.axes import (
    DASHED,
    LIFT_PANELS,
    TURN_DEG,
    axis_name,
    corner_lines,
    gathered,
    length_axis,
    lift_axis,
    lift_curves,
    mark,
    mark_look,
    mark_points,
    number_events,
    padded,
    phase_axis,
    phase_range,
    say,
    strobe_axis,
    turn_axis,
    unit_axis,
)
from camcli.plots.branch_lines import (
    Event,
    Strand,
    colours,
    curved,
    draw_outside,
    draw_paths,
    draw_plane,
    draw_real,
    draw_strands,
    events_of,
    line_look,
    number_pairs,
    paths,
    phases,
    positions,
    radius,
    strands,
    turning_real,
)
from camcli.plots.density import Columns, Image
from camcli.plots.picture import Panel, Picture, Rows
from camcli.plots.proofs import (
    SAMPLE,
    WITHOUT_GAP,
    draw_attraction,
    draw_band,
    proved_steps,
    proved_stretches,
)
from camcli.plots.simulate import GAP, Trace, angle_axis
from camcli.plots.sweep import CONSTANT
from camcli.quantities import THETA, Q, U, labelled
from camcli.system import System, kind_of_cam, units_of
from camcli.words.events import event_words
from camcli.words.in_print import label_text, name_and_unit, number_text, pair
from camcli.words.orbits import (
    NO_MULTIPLIERS,
    branch_words,
    curve_name,
    heading,
    nothing_found,
    side_words,
    value_text,
)
from camcli.words.sweep import NO_STROBE

if TYPE_CHECKING:
    from camcli.analysis.orbits.codim2 import CodimTwo
    from camcli.analysis.orbits.curve_proofs import CurveRange

PHASE, STROBE, PLANE, LIFT, ZOOM = 70.0, 40.0, 66.0, 32.0, 56.0  # mm, heights of the panels
ROOM = 0.02  # of the range of the parameter, beyond it
APART = 0.05  # between two rings that can be told from each other
SPEEDS = 14  # numbers along the paths of complex pairs, at most
BAND_LAYER = 2.5  # above what is simulated, below the branches
IMAGE = 700  # cells of simulated impacts, from bottom to top
MOST_LISTED = 14  # rows of the lists of branches and events
MOST_PHASES = 6  # of the impacts of an orbit, in the list of the orbits of one speed


@dataclass(frozen=True)
class _Scene:
    """A study with what its panels share."""

    study: OrbitsResult
    branches: Sequence[Branch]
    colours: list[str]
    events: list[Event]
    corners: dict[str, float]
    parameter: str
    system: System
    simulated: Sweep | None
    proved: list[list[bool]]  # of each branch, whether from each of its points to the next

    def lines(self, of: Callable[[Sequence[PeriodicOrbit]], list[Strand]]) -> list[list[Strand]]:
        """What `of` makes of the points of every branch."""
        return [of(branch.points) for branch in self.branches]

    def every(self, of: Callable[[PeriodicOrbit], Sequence[float]]) -> np.ndarray:
        """Values of all points of all branches."""
        points = (orbit for branch in self.branches for orbit in branch.points)
        return np.array([value for orbit in points for value in of(orbit)])


def draw_orbits(
    study: OrbitsResult,
    system: System,
    simulated: Sweep | None = None,
    periods: Sequence[Simulation] = (),
) -> Picture:
    """Picture of a study; of the orbits of one speed where no branches were followed.

    simulated: motions over the parameter, whose impacts are drawn behind the branches.
    periods: one period of each of the first orbits of one speed.
    """
    title, words = heading(study, kind_of_cam(system))
    if not study.branches:
        panels, lists = _single(study, system, periods)
        return Picture(title, panels, caption=words, lists=lists)
    corners = style.corner_names(system.corners)
    events = events_of(study.bifurcations, corners)
    shades = colours([branch.points for branch in study.branches])
    parameter = study.question.parameter
    proved = [_proved_steps(study, branch) for branch in study.branches]
    scene = _Scene(
        study, study.branches, shades, events, corners, parameter, system, simulated, proved
    )
    attractions = _attractions(study)
    abreast = 3 if len(attractions) == 1 else 2  # a single one stands beside the multipliers
    moves = _positions_differ(scene)
    remembers = bool(scene.every(lambda orbit: [radius(orbit)]).any())
    plane, multipliers = (
        Panel(partial(draw, scene=scene), PLANE, across=abreast, usual=remembers)
        for draw in (_draw_plane, _draw_real)
    )
    shown = {
        "phases": Panel(partial(_draw_phases, scene=scene), PHASE, parameter),
        "positions": Panel(partial(_draw_positions, scene=scene), STROBE, parameter, usual=moves),
        "plane": plane,
        "multipliers": multipliers,
        **attractions,
    }
    words += "" if moves else f"; {NO_STROBE}"
    words += "" if remembers else f"; {NO_MULTIPLIERS}"
    for zoom in hidden(scene):
        name = f"event {zoom.event.number}"
        event = zoom.event
        shown[name] = Panel(partial(_draw_zoom, zoom=zoom, scene=scene), ZOOM, across=2)
        shown[f"{name} in words"] = Panel(partial(_write_sides, event=event), ZOOM, across=2)
    some_proved = any(any(steps) for steps in scene.proved)
    lists = lists_of(scene.branches, shades, events, parameter, some_proved)
    return Picture(title, shown, caption=words, lists=lists)


def _positions_differ(scene: _Scene) -> bool:
    """Whether orbits, or simulated motions, are not all at one stroboscopic position."""
    every = np.concatenate([scene.every(positions), *_simulated(scene, "strobe")])
    return len(every) < 2 or bool(np.ptp(every) > CONSTANT * scene.system.lift)


def _attractions(study: OrbitsResult) -> dict[str, Panel]:
    """A panel for each orbit that was proved to attract: which impacts lead to it."""
    proofs = [] if study.proofs is None else study.proofs.orbits
    proved = [(o, p) for o, p in zip(study.orbits, proofs, strict=False) if p.axes]
    shades = colours([[orbit] for orbit, _ in proved])
    panels = {}
    for number, ((orbit, proof), shade) in enumerate(zip(proved, shades, strict=True), 1):
        name = "attraction" if len(proved) == 1 else f"attraction {number}"
        draw = partial(
            draw_attraction,
            orbit=orbit,
            ellipses=proof.axes,
            colour=shade,
            parameter=study.question.parameter,
        )
        panels[name] = Panel(draw, PLANE, across=3 if len(proved) == 1 else 2)
    return panels


# --- panels over the parameter


def _over_parameter(axes: Axes, scene: _Scene, named: bool) -> None:
    """The range of the parameter, and a line at every event in it."""
    span = scene.study.question.span
    values = scene.every(lambda orbit: [orbit.value])
    low, high = (values.min(), values.max()) if span is None else (span.low, span.high)
    room = ROOM * (high - low) or 0.01 * abs(high) or 1.0
    axes.set(xlim=(low - room, high + room), xlabel=axis_name(scene.parameter))
    numbered = [(event.number, event.value) for event in scene.events[:MOST_LISTED]]
    number_events(axes, numbered, named)


def _draw_branches(axes: Axes, scene: _Scene, of: Callable, turn: float) -> list[list[Strand]]:
    """All branches; one of a single point as a dot; where one could not be followed a mark."""
    every = scene.lines(partial(strands, of=of, turn=turn))
    for branch, steps in zip(scene.branches, scene.proved, strict=True):
        _draw_proved(axes, branch, steps, of, turn)
    for branch, mine, colour in zip(scene.branches, every, scene.colours, strict=True):
        draw_strands(axes, mine, colour)
        if len(branch.points) == 1:
            values = of(branch.points[0])
            x = [branch.points[0].value] * len(values)
            axes.plot(x, values, "o", color=colour, ms=3.0, zorder=4)
        if scene.simulated:
            for line in axes.lines:
                if line.get_zorder() > BAND_LAYER:
                    line.set_path_effects([withStroke(linewidth=2.6, foreground="white")])
        for orbit in _lost(branch):
            mark(axes, Kind.LOST, [orbit.value] * len(of(orbit)), of(orbit))
    return every


def _proved_steps(study: OrbitsResult, branch: Branch) -> list[bool]:
    """Whether a branch is proved from each of its points to the next."""
    ranges = [] if study.proofs is None else study.proofs.ranges
    return proved_steps(branch.points, [one for one in ranges if one.branch == branch.number])


def _draw_proved(
    axes: Axes,
    branch: Branch,
    steps: Sequence[bool],
    of: Callable,
    turn: float,
    refined: Callable[[Sequence[PeriodicOrbit]], Sequence[PeriodicOrbit]] = list,
) -> None:
    """The band along the parts of a branch that are proved.

    steps: whether it is proved from each point to the next; of: what the panel shows of an orbit, a
    value for each line; turn: values wrap round there, 0 where they do not. refined: returns the
    points of a part with more of them in between, where straight lines would cut corners.
    """
    for part in proved_stretches(steps):
        for strand in strands(refined(branch.points[part]), of, turn):
            width = line_look(strand.stable)["linewidth"]
            draw_band(axes, strand.x, strand.y, width, BAND_LAYER)


def _draw_phases(axes: Axes, scene: _Scene) -> None:
    """Phases of the impacts, or of the departures of an orbit that rests."""
    every = scene.every(phases)
    rests = {orbit.resting for branch in scene.branches for orbit in branch.points}
    what = " or ".join({False: "impact", True: "departure"}[rest] for rest in sorted(rests))
    some = [x for x in _simulated(scene, "impacts") if len(x)]
    ends = gathered(*(np.array([end(x) for x in some]) for end in (np.min, np.max)))
    limits = phase_range(np.concatenate([every, ends]))
    _draw_simulated(axes, scene, "impacts", limits)
    phase_axis(axes, *limits, what)
    if not len(every):
        say(axes, "there is no impact")
    _over_parameter(axes, scene, named=True)
    lines = _draw_branches(axes, scene, phases, TURN_DEG)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
    corner_lines(axes, scene.corners.items(), "y")
    number_branches(axes, lines, scene.branches, scene.colours, scene.events)


def _simulated(scene: _Scene, section: str) -> list[np.ndarray]:
    """The phases (deg) or positions (m) of every simulated motion."""
    speeds = scene.simulated.speeds if scene.simulated else []
    return [np.asarray(getattr(speed, section)[1], dtype=float) for speed in speeds]


def _draw_simulated(
    axes: Axes,
    scene: _Scene,
    section: str,
    limits: tuple[float, float],
    span: tuple = (-np.inf, np.inf),
) -> None:
    """Simulated motions, grey, within limits and a part of the parameter."""
    values = [speed.value for speed in scene.simulated.speeds] if scene.simulated else []
    if any(span[0] <= value <= span[1] for value in values):
        image = Image(Columns.of(values, span=span), *limits, IMAGE)
        for k, found in enumerate(_simulated(scene, section)):
            image.take(k, found)
        image.draw(axes, style.SIMULATED)
        axes.plot([], [], "s", color=style.SIMULATED, ms=4, label="simulated")
    axes.set_ylim(limits)


def _lost(branch: Branch) -> list[PeriodicOrbit]:
    """The points at which a branch could not be followed further."""
    return [branch.points[-k] for k in (0, 1) if branch.ends[k] == Kind.LOST]


def _draw_positions(axes: Axes, scene: _Scene) -> None:
    """Stroboscopic positions."""
    seen = np.concatenate([scene.every(positions), *_simulated(scene, "strobe")])
    _draw_simulated(axes, scene, "strobe", padded(seen, zero=scene.system.lift))
    _over_parameter(axes, scene, named=False)
    _draw_branches(axes, scene, positions, 0.0)
    for event in scene.events:
        mark(axes, event.source.kind, [event.value] * len(event.positions), event.positions)
    strobe_axis(axes.yaxis, scene.system)


def _draw_plane(axes: Axes, scene: _Scene) -> None:
    """Multipliers in the complex plane."""
    points = [p for branch in scene.branches for p in branch.points]
    rings: list[float] = []
    for size in sorted((p.det**0.5 for p in points if p.trace**2 < 4 * p.det), reverse=True):
        if not rings or size < rings[-1] - APART:
            rings.append(size)
    draw_plane(axes, float(scene.every(lambda orbit: [radius(orbit)]).max()), rings[:2])
    (name, unit), every = name_and_unit(scene.parameter), scene.lines(paths)
    for lines, colour in zip(every, scene.colours, strict=True):
        draw_paths(axes, lines, colour)
    values = scene.every(lambda orbit: [orbit.value])
    ticks = MaxNLocator(SPEEDS, steps=[1, 2, 5, 10]).tick_values(values.min(), values.max())
    numbered = number_pairs(axes, every, ticks)
    numbers = f"; numbers: {unit or 'its values'}" if numbered else ""
    axes.set_title(f"arrows: rising {name}{numbers}")


def _draw_real(axes: Axes, scene: _Scene) -> None:
    """Their real parts over the parameter."""
    _over_parameter(axes, scene, named=False)
    draw_real(axes, scene.lines(paths), scene.colours)
    real = [value for branch in scene.branches for value in turning_real(branch.points)]
    for value in real[:2]:
        axes.axvline(value, color=style.GUIDE, linewidth=0.6, linestyle=DASHED)
    said = ", ".join(value_text(float(f"{value:.6g}"), scene.parameter) for value in real[:2])
    axes.set_title(f"a complex pair turns real at {said}" if real else "")


# --- lists above the panels, and the numbers in them

WORDS, NAMED = 33, 14  # characters of a branch in the list, and of the label of an event's orbit
CLEAR, ROOMY = 6.0, 16.0  # pt from a branch's number to all else: least, and enough
EDGE = 0.03  # of a panel, where no number is put
TRIED = 300  # points of a branch at most that are looked at


def lists_of(
    branches: Sequence[Branch],
    shades: Sequence[str],
    events: Sequence[Event],
    parameter: str,
    proved: bool = False,
) -> list[Rows]:
    """Branches, and events; proved: whether a part of a branch is."""
    rows: list[list[Any]] = [["", "branch (dashed: unstable)"]]
    for branch, colour in zip(branches[:MOST_LISTED], shades, strict=False):
        rows.append([{"color": colour, "linewidth": 1.4}, _branch_words(branch, events, parameter)])
    unit = name_and_unit(parameter)[1]
    told: list[list[Any]] = [["", "", "event", unit or "value", "branch"]]
    for event in events[:MOST_LISTED]:
        notes = [event.source.classification.replace("-", " ")]
        notes += [f"{', '.join(map(str, event.leaves))} leaves"] if event.leaves else []
        notes += [event.source.status] if event.source.status != Bracket.OK else []
        value = number_text(float(f"{event.value:.9g}"))
        on = ", ".join(map(str, event.branches))
        what = event.words(label_text(event.source.label, NAMED))
        cells = what, value, on, "; ".join(filter(None, notes))
        told.append([mark_look(event.source.kind), str(event.number), *cells])
    for mine, count in ((rows, len(branches)), (told, len(events))):
        if count > MOST_LISTED:
            mine.append([f"and {count - MOST_LISTED} more, in the tables"])
    if proved:
        rows.append([SAMPLE, WITHOUT_GAP])
    return [rows, told] if events else [rows]


def _branch_words(branch: Branch, events: Sequence[Event], parameter: str) -> str:
    source = [event.number for event in events if branch.number in event.leaves]
    words = branch_words(branch, parameter, source[0] if source else None, WORDS)
    return textwrap.shorten(words, WORDS, placeholder="…") if len(words) > WORDS else words


def number_branches(
    axes: Axes,
    strands: Sequence[Sequence[Strand]],
    branches: Sequence[Branch],
    shades: Sequence[str],
    events: Sequence[Event],
) -> None:
    """Write each branch's number on its line, where the other lines and events are farthest away.

    A branch has no number where nothing on its line is as far as CLEAR points from all others.

    strands: the lines of each branch, in data coordinates, in the order of `branches` and of their
    colours, `shades`.
    """
    box = axes.get_window_extent()
    point = style.DPI / 72.0
    size = np.array(box.size)

    def pixels(points: Sequence[tuple[float, float]]) -> np.ndarray:
        few = np.reshape(points[:: 1 + len(points) // TRIED], (-1, 2))
        return axes.transData.transform(few) - box.p0

    lines = [[(x, y) for s in own for x, y in zip(s.x, s.y, strict=True)] for own in strands]
    taken = [pixels([(event.value, y) for event in events for y in event.phases])]
    for k, (branch, colour) in enumerate(zip(branches, shades, strict=True)):
        mine = pixels(lines[k])
        mine = mine[((mine > EDGE * size) & (mine < (1.0 - EDGE) * size)).all(axis=1)]
        others = np.concatenate([*taken, *(pixels(own) for n, own in enumerate(lines) if n != k)])
        away = np.hypot(*(mine[:, None] - others[None]).transpose(2, 0, 1)).min(1, initial=np.inf)
        if not len(mine) or away.max() < CLEAR * point:
            continue
        good = mine[away >= min(ROOMY * point, away.max())]
        best = good[int(np.argmin(np.round(abs(good[:, 0] - mine[:, 0].mean()), 3)))]
        taken.append(best[None] + [[0.0, 0.0], [5.0 * point, 0.0], [-5.0 * point, 0.0]])
        x, y = axes.transData.inverted().transform(best + box.p0)
        look: dict[str, Any] = {"size": style.NOTE, "weight": "bold", "color": colour, "zorder": 5}
        look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        axes.text(x, y, str(branch.number), ha="center", va="center_baseline", **look)


# --- a corner impact that hides beside another event, enlarged, with the numbers on both sides

MOST_ZOOMS = 2
HIDDEN = 0.005  # of the range, the distance to another event that hides a corner impact
AROUND = 1.8  # times that distance, shown on either side
REACH = 2.2  # times the phase's way from there to the corner, shown on either side
CHARS, LINES = 56, 17  # of the words beside it
UNSAID = "The theorem"  # beginning of sentences left to the report


@dataclass(frozen=True)
class Zoom:
    """A corner impact, the phase of its corner, and how far around it is shown."""

    event: Event
    corner_deg: float
    aside: float
    reach: float


def hidden(scene: _Scene) -> list[Zoom]:
    """Zooms on the corner impacts that are hardest to see, in ascending order of the parameter."""
    values = scene.every(lambda orbit: [orbit.value])
    found = []
    for event in scene.events:
        source = event.source
        corner = scene.corners.get(event.source.corner)
        if source.kind != Kind.CORNER_IMPACT or corner is None or source.left is None:
            continue
        most = HIDDEN * np.ptp(values)
        near = [other for other in scene.events if 0.0 < abs(other.value - event.value) < most]
        if near:
            other = min(near, key=lambda other: abs(other.value - event.value))
            way = min(abs(phase - corner) for phase in other.phases)
            aside = AROUND * abs(other.value - event.value)
            found.append(Zoom(event, corner, aside, REACH * max(way, 0.05)))
    first = sorted(found, key=lambda zoom: zoom.aside)[:MOST_ZOOMS]
    return sorted(first, key=lambda zoom: zoom.event.value)


def _draw_zoom(axes: Axes, zoom: Zoom, scene: _Scene) -> None:
    """The phases (deg) of the branches near an event that is too small to be seen elsewhere."""
    low, high = zoom.event.value - zoom.aside, zoom.event.value + zoom.aside
    axes.set_xlabel(axis_name(scene.parameter))
    axes.set_ylabel(labelled(r"phase $\theta$", THETA.unit) + ", enlarged")
    refined = partial(curved, low=low, high=high)
    lines = scene.lines(lambda points: strands(refined(points), phases, TURN_DEG))

    # as high as the branches near the corner go, and the corner itself
    shown = [zoom.corner_deg]
    for strands_of_branch in lines:
        for strand in strands_of_branch:
            for value, phase in zip(strand.x, strand.y, strict=True):
                if low <= value <= high and abs(phase - zoom.corner_deg) <= zoom.reach:
                    shown.append(phase)
    room = 0.1 * (max(shown) - min(shown)) or 0.1
    heights = (min(shown) - room, max(shown) + room)

    _draw_simulated(axes, scene, "impacts", heights, (low, high))
    axes.set_xlim(low, high)
    for branch, steps in zip(scene.branches, scene.proved, strict=True):
        _draw_proved(axes, branch, steps, phases, TURN_DEG, refined)
    for strands_of_branch, colour in zip(lines, scene.colours, strict=True):
        draw_strands(axes, strands_of_branch, colour)
    inside = [event for event in scene.events if low <= event.value <= high]
    for event in inside:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
    corner_lines(axes, scene.corners.items(), "y")
    number_events(axes, [(event.number, event.value) for event in inside], named=True)
    number_branches(axes, lines, scene.branches, scene.colours, inside)


def _write_sides(axes: Axes, event: Event) -> None:
    """The linear parts on both sides of the corner and what follows from them."""
    source = event.source
    words = [line.replace("+-", "±") for line in event_words(source) if not line.startswith(UNSAID)]
    lines = side_words(source)
    lines += [re.sub(r"(?<= )-(?=\d)", "−", line) for line in words]
    text = [part for line in lines for part in textwrap.wrap(line, CHARS, subsequent_indent="  ")]
    text = text if len(text) <= LINES else [*text[: LINES - 1], "…"]
    axes.axis("off")
    axes.set_title(f"{event.number}: {label_text(source.label, 24)}, {event.name}", loc="left")
    axes.text(0.0, 0.98, "\n".join(text), va="top", size=6.5, linespacing=1.3)


# --- orbits of one speed


def _single(
    study: OrbitsResult, system: System, periods: Sequence[Simulation]
) -> tuple[dict, list[Rows]]:
    """Panels and the list of a study without branches."""
    orbits = study.orbits
    if not orbits:
        said = nothing_found(study, kind_of_cam(system))
        return {"orbits": Panel(lambda axes: say(axes, said), 40.0)}, []
    shades = colours([[orbit] for orbit in orbits])
    more: dict[str, Any] = {"orbits": orbits, "shades": shades}
    panels = {}
    if periods:  # empty where they could not be simulated
        pairs = zip(periods, orbits, strict=False)
        traces = [Trace.of(period, system, orbit.turns) for period, orbit in pairs]
        draw = partial(_draw_motion, traces=traces, **more)
        panels["motion"] = Panel(draw, PHASE, "theta")
        draw = partial(_draw_orbit, traces=traces, **more)
        panels["orbit"] = Panel(draw, PLANE, across=2)
    panels["plane"] = Panel(partial(_draw_multipliers, **more), PLANE, across=2)
    for name, panel in _attractions(study).items():
        panels[name] = replace(panel, across=2)
    for k, name in enumerate(LIFT_PANELS):
        draw = partial(_draw_impacts, order=k, system=system, **more)
        panels[name] = Panel(draw, LIFT, "theta", usual=False)
    draw = partial(_draw_states, system=system, **more)
    panels["section"] = Panel(draw, PLANE, across=2, usual=False)
    return panels, [_orbit_rows(orbits, shades)]


def _orbit_rows(orbits: Sequence[PeriodicOrbit], shades: Sequence[str]) -> list[list[Any]]:
    """The list of the orbits of one speed: mark, label, stability, multipliers and phases."""
    rows: list[list[Any]] = [["", "orbit", "", "multipliers", labelled("phases", THETA.unit)]]
    for orbit, shade in zip(orbits[:MOST_SHOWN], shades, strict=False):
        at = [f"{phase:.2f}" for phase in phases(orbit)]
        if len(at) > MOST_PHASES:
            at = [*at[: MOST_PHASES - 1], "…"]
        leaves = "leaves at " if orbit.resting and at else ""
        verdict = "stable" if orbit.stable else "unstable"
        label = label_text(orbit.label, 22)
        multipliers = pair(orbit.trace, orbit.det)
        rows.append([_dot(orbit, shade), label, verdict, multipliers, leaves + ", ".join(at)])
    if len(orbits) > MOST_SHOWN:
        rows.append([f"and {len(orbits) - MOST_SHOWN} more, in the tables"])
    return rows


def _draw_motion(
    axes: Axes, traces: Sequence[Trace], orbits: Sequence[PeriodicOrbit], shades: Sequence[str]
) -> None:
    """Positions over one period, from its first strobe; rests are thicker."""
    longest = max(traces, key=lambda trace: trace.high - trace.low)
    axes.plot(longest.angle, longest.cam, color=style.CAM, lw=0.8, label="cam")
    for trace, orbit, shade in zip(traces, orbits, shades, strict=False):
        axes.plot(trace.angle, trace.q, color=shade, zorder=3, **line_look(orbit.stable))
        if trace.sticks.any():
            rests = trace.during(trace.q, trace.sticks)
            axes.plot(trace.angle, rests, color=style.STICKING, lw=3.0, zorder=2, label="sticking")
        for points in (trace.events[kind] for kind in trace.events if kind == "impact"):
            mark(axes, "impact", points[:, 0], points[:, 1], label="impact")
    unit_axis(axes.yaxis, Q.name, longest.units)
    angle_axis(axes, longest)


def _draw_orbit(
    axes: Axes, traces: Sequence[Trace], orbits: Sequence[PeriodicOrbit], shades: Sequence[str]
) -> None:
    """The relative phase plane."""
    axes.axvline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    axes.axhline(0.0, color=style.GUIDE, linewidth=0.5, zorder=0.5)
    for trace, orbit, shade in zip(traces, orbits, shades, strict=False):
        closed = (np.append(values, values[0]) for values in (trace.gap, trace.u))
        axes.plot(*closed, color=shade, **line_look(orbit.stable))
    length_axis(axes.xaxis, GAP, max(trace.gap.max() for trace in traces))
    axes.set_ylabel(U.label)


def _dot(orbit: PeriodicOrbit, shade: str) -> dict[str, Any]:
    """Stable orbits filled, unstable ones open."""
    face = shade if orbit.stable else "white"
    return {"marker": "o", "ls": "None", "ms": 5.0, "mew": 1.1, "mec": shade, "mfc": face}


def _draw_impacts(
    axes: Axes, order: int, orbits: Sequence[PeriodicOrbit], shades: Sequence[str], system: System
) -> None:
    """The cam's lift, or a derivative, over the turn with the impacts on it."""
    theta, orders = lift_curves(system.cam, order + 1)
    values = orders[order]
    good = np.isfinite(theta)
    axes.plot(theta, values, color=style.CAM, linewidth=0.9, zorder=2)
    axes.margins(y=0.1)
    for orbit, shade in zip(orbits, shades, strict=True):
        at = phases(orbit)
        heights = np.interp(at, theta[good], values[good])  # on a corner: either side's value
        axes.plot(at, heights, zorder=5, **_dot(orbit, shade))
        for phase in at:
            look = {**line_look(orbit.stable), "linewidth": 0.7}
            axes.axvline(phase, color=shade, alpha=0.6, zorder=1, **look)
    lift_axis(axes.yaxis, list(LIFT_PANELS)[order], units_of(system))
    turn_axis(axes, style.corner_names(system.corners), named=order == 0)


def _draw_states(
    axes: Axes, orbits: Sequence[PeriodicOrbit], shades: Sequence[str], system: System
) -> None:
    """The orbits as points of the stroboscopic map."""
    for orbit, shade in zip(orbits, shades, strict=True):
        axes.plot(*zip(*orbit.states, strict=True), zorder=5, **_dot(orbit, shade))
    q, rate = np.array([state for orbit in orbits for state in orbit.states]).T
    room = [0.5 * abs(values).max() or system.lift for values in (q, rate)]
    axes.set(xlim=padded(q, room[0]), ylim=padded(rate, room[1]))
    strobe_axis(axes.xaxis, system)
    unit_axis(axes.yaxis, r"stroboscopic $q_\theta$", units_of(system), "m/rad")


def _draw_multipliers(axes: Axes, orbits: Sequence[PeriodicOrbit], shades: Sequence[str]) -> None:
    draw_plane(axes, max(map(radius, orbits)))
    for orbit, shade in zip(orbits, shades, strict=True):
        real, imag = ([part(mu) for mu in orbit.multipliers] for part in (np.real, np.imag))
        axes.plot(real, imag, zorder=5, **_dot(orbit, shade))
        draw_outside(axes, orbit.multipliers, shade)


# --- curves in two parameters

CURVE_STYLES = ("-", DASHED, ":", "-.")  # in turn, so that print in grey tells curves apart
THICK = 1.8  # pt wider, the curves of the second turn
CURVE_BAND_LAYER = 1.5  # below the curves


def draw_curves(
    curves: Sequence[Curve],
    names: tuple[str, str],
    points: Sequence[CodimTwo] = (),
    ranges: Sequence[CurveRange] = (),
) -> Picture:
    """Picture of bifurcation curves over two parameters of these names; an open circle is an end.

    points: of codimension two, with a mark and a number each; ranges: parts of the curves that were
    tried to be proved.
    """
    draw = partial(_draw_curves, curves=curves, names=names, points=points, ranges=ranges)
    return Picture("Bifurcations in two parameters", {"curves": Panel(draw, 105.0, shape=1.0)})


def _draw_curves(
    axes: Axes,
    curves: Sequence[Curve],
    names: tuple[str, str],
    points: Sequence[CodimTwo],
    ranges: Sequence[CurveRange],
) -> None:
    """Each curve named with its orbit and why it ends, in the colour of the orbit."""
    axes.set(xlabel=axis_name(names[0]), ylabel=axis_name(names[1]))
    if not curves:
        say(axes, "no bifurcation of this kind was located")
    wanted = [style.label_colour(curve.label) for curve in curves]
    known = {end for point in points for end in point.ends}
    for number, (curve, colour) in enumerate(zip(curves, style.apart(wanted), strict=True), 1):
        turn, which = divmod(number - 1, len(CURVE_STYLES))
        width = 1.0 + THICK * (turn % 2)
        x, y = curve.line.first, curve.line.second
        axes.plot(x, y, color=colour, label=curve_name(curve), ls=CURVE_STYLES[which], lw=width)
        for part in ranges:
            if part.curve == number and part.failed_step is None:
                steps = slice(part.first - 1, part.last)
                draw_band(axes, x[steps], y[steps], width, CURVE_BAND_LAYER)
        for place, end in zip((0, -1), curve.ends, strict=True):
            marked = (number, -place) in known
            if curve.points and end != "end-of-range" and not marked:
                axes.plot([x[place]], [y[place]], "o", color=colour, mfc="white", zorder=5)
    if any(part.failed_step is None for part in ranges):
        axes.plot([], [], label=WITHOUT_GAP, **SAMPLE)
    mark_points(axes, points)
