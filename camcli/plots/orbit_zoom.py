"""A corner impact that hides beside another event, enlarged, with the numbers on both sides."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from camcli.analysis.border_collision import Side
from camcli.analysis.orbits.locate import CORNER
from camcli.analysis.orbits.shooter import multipliers
from camcli.analysis.orbits.study import Branch
from camcli.plots import style
from camcli.plots.event_words import event_words
from camcli.plots.orbit_keys import number_branches, number_events
from camcli.plots.orbit_lines import Event, Strand, curved, draw, mark, phases, strands

ZOOM, TALL, LEFT, WIDE = 560, 440, 160, 545  # px: with its axis, the panel
MOST = 2  # panels
HIDDEN = 0.005  # of the range, the distance to another event that hides a corner impact
AROUND = 1.8  # times that distance, shown on either side
REACH = 2.2  # times the phase's way from there to the corner, shown on either side
CHARS = 54
UNSAID = "The theorem"  # beginning of sentences left to the report


@dataclass(frozen=True)
class Zoom:
    """A corner impact, the range around it, and how far its phase is shown at most."""

    event: Event
    x: tuple[float, float]
    reach: float
    corners: dict[str, float]


def zooms(
    branches: Sequence[Branch], events: Sequence[Event], corners: dict[str, float]
) -> list[Zoom]:
    """Of the corner impacts those hardest to see, in ascending order."""
    values = [orbit.value for branch in branches for orbit in branch.points]
    width = max(values) - min(values)
    found = []
    for event in events:
        if event.source.kind != CORNER or event.source.corner not in corners:
            continue
        near = [other for other in events if 0.0 < abs(other.value - event.value) < HIDDEN * width]
        if event.source.left is None or not near:
            continue
        other = min(near, key=lambda other: abs(other.value - event.value))
        away = abs(other.value - event.value)
        at = corners[event.source.corner]
        way = min(abs(phase - at) for phase in other.phases)
        found.append((away, _zoom(event, AROUND * away, REACH * max(way, 0.05), corners)))
    first = sorted(found, key=lambda pair: pair[0])[:MOST]
    return [zoom for _, zoom in sorted(first, key=lambda pair: pair[1].event.value)]


def _zoom(event: Event, aside: float, way: float, corners: dict[str, float]) -> Zoom:
    return Zoom(event, (event.value - aside, event.value + aside), way, corners)


def draw_zoom(
    figure: Figure, top: int, zoom: Zoom, branches, colours, events: Sequence[Event], name: str
) -> None:
    """The panel on the left, words on the right."""
    axes = style.place(figure, LEFT, top + 60, WIDE, TALL)
    axes.set(xlim=zoom.x, xlabel=name, ylabel=r"phase $\theta$ (deg), enlarged")
    axes.locator_params(axis="x", nbins=5)
    lines = [strands(curved(branch.points, *zoom.x), phases, 360.0) for branch in branches]
    low, high = _heights(zoom, lines)
    axes.set_ylim(low, high)
    for mine, colour in zip(lines, colours, strict=True):
        draw(axes, mine, colour)
    inside = [event for event in events if zoom.x[0] <= event.value <= zoom.x[1]]
    for event in inside:
        mark(axes, event.source.kind, [event.value] * len(event.phases), event.phases)
        dots = {"linewidth": 0.5, "linestyle": (0, (1, 2)), "zorder": 1}
        axes.axvline(event.value, color=style.GUIDE, **dots)
    for letter, phase in zoom.corners.items():
        if low < phase < high:
            axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
            at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
            axes.text(1.02, phase, letter, color=style.CAM, **at)
    number_events(axes, inside, WIDE, TALL)
    names = [str(branch.number) for branch in branches]
    number_branches(axes, lines, names, colours, inside)
    _words(figure, top + 24, zoom.event)


def _heights(zoom: Zoom, every: Sequence[Sequence[Strand]]) -> tuple[float, float]:
    """Range of the phases near the corner."""
    at, (low, high) = zoom.corners[zoom.event.source.corner], zoom.x
    points = [(x, y) for lines in every for s in lines for x, y in zip(s.x, s.y, strict=True)]
    near = [y for x, y in points if low <= x <= high and abs(y - at) <= zoom.reach]
    room = 0.1 * (max([at, *near]) - min([at, *near])) or 0.1
    return min([at, *near]) - room, max([at, *near]) + room


def _words(figure: Figure, top: int, event: Event) -> None:
    left, source = LEFT + WIDE + 65, event.source
    title = f"{event.number}: {style.motion(source.label, 24)}, {event.name}"
    style.write(figure, left, top, title, weight="bold")
    lines = [
        f"impact before the corner (left): {side(source.left)}",
        f"impact after the corner (right): {side(source.right)}",
        *(
            re.sub(r"(?<= )-(?=\d)", "−", words.replace("+-", "±"))
            for words in event_words(source)
            if not words.startswith(UNSAID)
        ),
    ]
    text = [part for line in lines for part in textwrap.wrap(line, CHARS, subsequent_indent="  ")]
    room = ZOOM // style.LINE - 2
    text = text if len(text) <= room else [*text[: room - 1], "…"]
    style.write(figure, left, top + 40, "\n".join(text), linespacing=1.25, size=7)


def side(one: Side) -> str:
    """Trace, determinant and multipliers of one side."""
    trace = f"{one.trace:.6g}".replace("-", "−")
    return f"trace {trace}, determinant {one.det:.6g}, µ = {pair(one.trace, one.det)}"


def pair(trace: float, det: float) -> str:
    """The two multipliers as numbers."""
    upper, lower = multipliers(trace, det)
    if upper.imag:
        text = f"{upper.real:.4g} ± {upper.imag:.4g}i"
    else:
        text = f"{upper.real:.4g}, {lower.real:.4g}" if upper != lower else f"{upper.real:.4g}"
    return text.replace("-", "−")
