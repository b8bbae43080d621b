"""The lists above a picture of branches: which colour is which branch, which mark which event.

Also the numbers where they belong: beside the branches and above the events.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camcli.analysis.orbits.locate import LOST, OK
from camcli.analysis.orbits.study import Branch
from camcli.plots import style
from camcli.plots.axes import spread
from camcli.plots.orbit_lines import DASHES, Event, Strand, mark

LONGEST, WORDS = 24, 33  # rows of a list, characters of a branch in it
MIDDLE = 455  # px, where the list of events begins
COLUMNS = (30, 70, 345, 500, 585)  # px from there: number, name, place, branches, notes
CLEAR, ROOMY = 17.0, 45.0  # px from a branch's number to all else: least, and enough
EDGE = 0.03  # of a panel, where no number is put
TRIED = 300  # points of a branch at most that are looked at
UNITS = {
    "rpm": "rpm",
    "restitution": "",
    "damping": "N s/m",
    "gravity": "m/s²",
    "stiffness": "N/m",
    "preload": "N",
    "mass": "kg",
}


def quantity(value: float, parameter: str) -> str:
    """A value of the parameter with its unit."""
    return f"{style.number(float(f'{value:.9g}'))} {UNITS[parameter]}".rstrip()


def rows(branches: Sequence[Branch], events: Sequence[Event]) -> int:
    """Lines of text that the lists need."""
    return 1 + min(max(len(branches), len(events)), LONGEST + 1)


def draw_lists(
    figure: Figure, top: int, branches, colours, events: Sequence[Event], parameter: str
) -> None:
    """Branches on the left, events on the right, from `top` downwards."""
    height = style.LINE * rows(branches, events)
    axes = style.place(figure, 0, top, style.WIDTH, height, frame_on=False)
    axes.set(xlim=(0, style.WIDTH), ylim=(height, 0), xticks=[], yticks=[])
    _line(axes, 20, 0, "stable", style.CAM, "-")
    _line(axes, 200, 0, "unstable", style.CAM, DASHES)
    for row, (branch, colour) in enumerate(zip(branches, colours, strict=True), 1):
        if row <= LONGEST:
            _line(axes, 20, row, _branch(branch, events, parameter), colour, "-")
    for row, event in enumerate(events, 1):
        if row <= LONGEST:
            _event(axes, row, event)
    for left, count in ((20, len(branches)), (MIDDLE, len(events))):
        if count > LONGEST:
            _text(axes, left, LONGEST + 1, f"and {count - LONGEST} more, in the tables")
    if events:
        unit = UNITS[parameter]
        heads = ("no.", "event", f"at ({unit})" if unit else "at", "branch", "")
        for left, word in zip(COLUMNS, heads, strict=True):
            _text(axes, MIDDLE + left, 0, word, color=style.CAM)


def _text(axes: Axes, left: float, row: int, words: str, **more) -> None:
    axes.text(left, (row + 0.5) * style.LINE, words, va="center_baseline", **more)


def _line(axes: Axes, left: int, row: int, words: str, colour: str, dashes) -> None:
    y = (row + 0.5) * style.LINE
    axes.plot([left, left + 44], [y, y], color=colour, linewidth=1.4, linestyle=dashes)
    _text(axes, left + 58, row, words)


def _branch(branch: Branch, events: Sequence[Event], parameter: str) -> str:
    names = [style.motion(label, 22) for label in branch.labels]
    words = f"{branch.number}   {names[0]}" + (f" to {names[-1]}" if len(names) > 1 else "")
    source = [event.number for event in events if branch.number in event.leaves]
    if source:
        words += f", from event {source[0]}"
    lost = [branch.points[-k] for k in (0, 1) if branch.ends[k] == LOST]
    if lost:
        words += f", lost at {quantity(lost[0].value, parameter)}"
    return words if len(words) <= WORDS else words[: WORDS - 1] + "…"


def _event(axes: Axes, row: int, event: Event) -> None:
    mark(axes, event.source.kind, [MIDDLE + 10], [(row + 0.5) * style.LINE])
    on = ", ".join(map(str, event.branches))
    notes = [event.source.classification.replace("-", " ")]
    notes += [f"{', '.join(map(str, event.leaves))} leaves"] if event.leaves else []
    notes += [event.source.status] if event.source.status != OK else []
    value = style.number(float(f"{event.value:.9g}"))
    cells = (str(event.number), event.name, value, on, "; ".join(filter(None, notes)))
    for left, words in zip(COLUMNS, cells, strict=True):
        _text(axes, MIDDLE + left, row, words)


def number_events(axes: Axes, events: Sequence[Event], wide: int, tall: int) -> None:
    """The events' numbers above a panel, each with a line to its place."""
    low, high = axes.get_xlim()
    seen = [event for event in events if low <= event.value <= high and event.number <= LONGEST]
    gap = (40.0 if len(events) > 9 else 30.0) * (high - low) / wide
    places = spread([event.value for event in seen], gap, low, high)
    at = {"transform": axes.get_xaxis_transform(), "clip_on": False}
    for event, place in zip(seen, places, strict=True):
        ends = [1.0, 1.0 + 8.0 / tall, 1.0 + 24.0 / tall]
        axes.plot([event.value, event.value, place], ends, color=style.GUIDE, linewidth=0.5, **at)
        axes.text(place, 1.0 + 28.0 / tall, str(event.number), ha="center", va="bottom", **at)


def number_branches(
    axes: Axes, every: Sequence[Sequence[Strand]], names, colours, events: Sequence[Event]
) -> None:
    """The branches' numbers on their lines, each where most room is; none where there is not."""
    pixels = [_pixels(axes, [(x, y) for s in lines for x, y in zip(s.x, s.y, strict=True)])
              for lines in every]  # fmt: skip
    taken = [_pixels(axes, [(event.value, y) for event in events for y in event.phases])]
    box = axes.get_window_extent()
    for k, (mine, name, colour) in enumerate(zip(pixels, names, colours, strict=True)):
        room = np.array([box.width, box.height]) * EDGE
        inside = (mine > room).all(axis=1) & (mine < [box.width, box.height] - room).all(axis=1)
        mine = mine[inside]
        others = np.concatenate([*taken, *pixels[:k], *pixels[k + 1 :]])
        if not len(mine) or not len(others):
            away = np.full(len(mine), np.inf)
        else:
            away = np.hypot(*(mine[:, None] - others[None]).transpose(2, 0, 1)).min(axis=1)
        if not len(mine) or away.max() < CLEAR:
            continue
        good = mine[away >= min(ROOMY, away.max())]
        best = good[int(np.argmin(np.round(abs(good[:, 0] - mine[:, 0].mean()), 3)))]
        taken.append(np.array([best, best + 12.0, best - 12.0]))
        place = axes.transData.inverted().transform(best + np.array([box.x0, box.y0]))
        patch = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        look = {"size": 7, "weight": "bold", "ha": "center", "va": "center_baseline", "zorder": 5}
        axes.text(*place, name, color=colour, bbox=patch, **look)


def _pixels(axes: Axes, points: Sequence[tuple[float, float]]) -> np.ndarray:
    """Points in pixels from the lower left corner of the axes."""
    if not points:
        return np.empty((0, 2))
    box = axes.get_window_extent()
    few = np.asarray(points[:: 1 + len(points) // TRIED], dtype=float)
    return axes.transData.transform(few) - [box.x0, box.y0]
