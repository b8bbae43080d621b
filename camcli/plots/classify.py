"""Picture of classified motions: impact phases, largest exponent and labels, over speed."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from camcli.analysis.classify import ClassifiedMotion
from camcli.analysis.explain.attractor import impacts_of
from camcli.analysis.explain.changes import CriticalEvent
from camcli.errors import Status
from camcli.plots import style
from camcli.plots.axes import (
    axis_name,
    corner_lines,
    number_events,
    padded,
    phase_axis,
    phase_range,
    say,
    trouble_ticks,
)
from camcli.plots.critical_speeds import Numbered, event_lists, numbered
from camcli.plots.density import PER_MM, Columns, Image
from camcli.plots.picture import COMPACT, Panel, Picture
from camcli.plots.sweep import colour_of, in_order
from camcli.quantities import EXPONENT
from camcli.system import System, kind_of_cam
from camcli.words.classify import (
    ALL_FORGET,
    FORGETS,
    OTHERS,
    kinds_words,
    motions_at,
    picture_title,
    range_text,
    rests,
)

PHASES, GROWTH, STRIP = 72.0, 44.0, 16.0  # mm
BELOW = 0.12  # of the range of exponents: below these are the marks of what has none
PALE, STRONG = 0.8, 0.25  # of a rectangle: white in its colour; the part that has none in it


@dataclass(frozen=True)
class _Scene:
    """Motions in ascending order, where each is drawn, and what the panels share."""

    motions: list[ClassifiedMotion]
    x: list[float]
    columns: Columns
    events: list[Numbered]
    system: System | None
    key: str  # what is varied

    @property
    def speeds(self) -> str:
        """Their range."""
        kind = "" if self.system is None else kind_of_cam(self.system)
        return range_text(self.motions, self.key, kind)


def draw_classify(
    motions: Sequence[ClassifiedMotion],
    system: System | None = None,
    events: Sequence[CriticalEvent] = (),
    key: str = "rpm",
) -> Picture:
    """Picture of classified motions over what is varied, with the corners of the system.

    Motions of one and the same speed stand side by side. `events` are listed and numbered.
    """
    rising = sorted(motions, key=lambda motion: motion.value)
    x = [motion.value for motion in rising]
    alone = len(set(x)) == 1
    if alone:
        x = [float(k) for k in range(1, len(x) + 1)]
        events = ()
    scene = _Scene(rising, x, Columns.of(sorted(set(x))), numbered(events), system, key)
    draws = {"phases": (_draw_phases, PHASES), "exponents": (_draw_exponents, GROWTH)}
    draws["labels"] = _draw_labels, STRIP
    finite = [
        motion.exponents is not None and isfinite(motion.exponents.largest) for motion in rising
    ]
    panels = {
        name: Panel(
            partial(_draw, scene=scene, draw=draw),
            height,
            key,
            usual=name != "exponents" or any(finite),
        )
        for name, (draw, height) in draws.items()
    }
    title = picture_title(0 if alone else len(set(x)), scene.speeds, key)
    words = kinds_words(rising)
    if not any(finite) and any(motion.exponents is not None for motion in rising):
        words += f"; {ALL_FORGET}"
    return Picture(title, panels, caption=words, lists=event_lists(scene.events), tall=COMPACT)


def _draw(axes: Axes, scene: _Scene, draw: Any) -> None:
    """A panel over what is varied, with its events; over motions counted where that is one value.

    draw: what draws the panel's own content, given the axes and the scene. The events have
    their numbers above the panel of the phases alone.
    """
    axes.set_xlim(scene.columns.low, scene.columns.high)
    draw(axes, scene)
    pairs = [(number, event.rpm) for number, event in scene.events]
    number_events(axes, pairs, named=draw is _draw_phases)
    axes.set_xlabel(axis_name(scene.key))
    if len({motion.value for motion in scene.motions}) == 1:
        one = len(scene.motions) == 1
        axes.set_xticks([] if one else scene.x)
        axes.set_xlabel(motions_at(one, scene.speeds))


def _draw_phases(axes: Axes, scene: _Scene) -> None:
    """Impacts as clouds, each in the colour of its kind of motion."""
    every = [np.degrees(impacts_of(motion.record)[0]) % 360.0 for motion in scene.motions]
    places = {x: k for k, x in enumerate(dict.fromkeys(scene.x))}
    low, high = phase_range(np.concatenate(every))
    kinds = [style.kind_of_label(motion.label) for motion in scene.motions]
    images = {
        kind: Image(scene.columns, low, high, round(PHASES * PER_MM)) for kind in in_order(kinds)
    }
    for x, phases, kind in zip(scene.x, every, kinds, strict=True):
        images[kind].take(places[x], phases)
    for kind, image in images.items():
        image.draw(axes, colour_of(kind))
        axes.plot([], [], "s", color=colour_of(kind), ms=4, label=kind)
    phase_axis(axes, low, high)
    if not any(map(len, every)):
        say(axes, "no impact at any of these speeds")
    bad = [x for x, m in zip(scene.x, scene.motions, strict=True) if m.status != Status.OK]
    trouble_ticks(axes, bad)
    if scene.system is not None:
        corner_lines(axes, style.corner_names(scene.system.corners).items(), "y")


def _colour(motion: ClassifiedMotion) -> str:
    """The colour of a motion, as in a sweep."""
    return colour_of(style.kind_of_label(motion.label))


def _draw_exponents(axes: Axes, scene: _Scene) -> None:
    """Largest exponents with their standard errors; those that are -inf at the bottom."""
    axes.axhline(0.0, color=style.CAM, linewidth=0.8, zorder=1)
    look: dict[str, Any] = {"fmt": "o", "ms": 2.6, "mew": 0.0, "linewidth": 0.8, "zorder": 4}
    ends = [0.0]  # of the error bars, and the line at zero
    forgetful = []  # where the largest exponent is -inf
    has_bars = False
    for x, motion in zip(scene.x, scene.motions, strict=True):
        if motion.exponents is None:
            continue
        largest = motion.exponents.largest
        if largest == -inf:
            forgetful.append(x)
        if not isfinite(largest):
            continue
        error = motion.exponents.spread if isfinite(motion.exponents.spread) else 0.0
        axes.errorbar(x, largest, error, color=_colour(motion), **look)
        ends += [largest - error, largest + error]
        has_bars = has_bars or error > 0.0
    low, high = padded(ends, 0.5)
    axes.set_ylim(low - BELOW * (high - low) if forgetful else low, high)
    if forgetful:
        at: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "label": FORGETS}
        places = [0.03] * len(forgetful)
        axes.plot(forgetful, places, "v", color=style.STICKING, ms=3.2, mew=0.0, **at)
    bars = ",\n± standard error" if has_bars else ""
    axes.set_ylabel(EXPONENT.label + bars)


def _draw_labels(axes: Axes, scene: _Scene) -> None:
    """Rectangles in the colours of the motions; several motions of a speed on one another.

    A rectangle goes on over neighbouring speeds whose motions have the same labels.
    """
    low, high = axes.get_xlim()
    axes.set(ylim=(0.0, 1.0), yticks=[], ylabel="label")
    places = sorted(set(scene.x))
    edges = [low, *((a + b) / 2.0 for a, b in pairwise(places)), high]
    groups: list[list[ClassifiedMotion]] = [[] for _ in places]  # the motions at each place
    for motion, x in zip(scene.motions, scene.x, strict=True):
        groups[places.index(x)].append(motion)
    begin = 0
    for _, alike in groupby(groups, lambda group: [(m.label, rests(m)) for m in group]):
        members = list(alike)
        end = begin + len(members)
        height = 1.0 / len(members[0])
        for row, motion in enumerate(members[0]):
            bottom = 1.0 - (row + 1) * height
            box = _Box(edges[begin], bottom, edges[end] - edges[begin], height)
            _draw_label(axes, motion, box)
        begin = end


class _Box(NamedTuple):
    """A rectangle: left along the axis of speeds, the others as shares of the panel's height."""

    left: float
    bottom: float
    wide: float
    high: float


def _draw_label(axes: Axes, motion: ClassifiedMotion, box: _Box) -> None:
    """A rectangle whose foot has the motion's full colour; the rest is pale, for the words."""
    colour = _colour(motion)
    foot = STRONG * box.high
    corner = (box.left, box.bottom)
    pale = style.mixed(colour, PALE)
    axes.add_patch(Rectangle(corner, box.wide, box.high, facecolor=pale, linewidth=0.0))
    axes.add_patch(Rectangle(corner, box.wide, foot, facecolor=colour, linewidth=0.0))
    _name(axes, motion, (box.left, box.bottom + foot), box.wide, (1.0 - STRONG) * box.high)


def _name(axes: Axes, motion: ClassifiedMotion, corner: Any, wide: float, high: float) -> None:
    """The label, else the period, in the middle of a rectangle where there is room."""
    frame, (left, right) = axes.get_window_extent(), axes.get_xlim()
    names = [motion.label.replace("inf", "∞")]
    names += [str(motion.period)] if motion.label not in OTHERS else []
    text = axes.text(
        corner[0] + 0.5 * wide,
        corner[1] + 0.5 * high,
        "",
        size=style.NOTE,
        ha="center",
        va="center_baseline",
        color="black",
    )
    for name in names:
        text.set_text(name)
        box = text.get_window_extent()
        fits = 1.3 * box.width <= wide * frame.width / (right - left)
        if fits and 1.1 * box.height <= high * frame.height:
            return
    text.remove()
