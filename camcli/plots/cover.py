"""Picture of the covers of all orbits with two impacts: boxes of their phases, and why empty."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import degrees
from typing import Any

from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.ticker import MultipleLocator

from camcli.analysis.orbits.all_orbits import AllOrbits, Cover
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.plots import style
from camcli.plots.axes import TURN_DEG, corner_lines
from camcli.plots.picture import Panel, Picture
from camcli.quantities import THETA, labelled
from camcli.system import System
from camcli.words.all_orbits import HOLDS_ORBIT, REASONS, cover_words
from camcli.words.in_print import label_text

HEIGHT = 95.0  # mm, of a panel
TICK = 90  # deg
PAPER = "white"
LINE, PALER = 0.15, 0.45  # pt, between boxes; share of white in its colour
LEAST, ROOM = 10.0, 2.0  # deg: of flights that are shown, and above the longest possible one
AT_EDGE = {"order", "flight"}  # reasons that exclude all longer and shorter flights

Box = Sequence[tuple[float, float]]  # lowest and highest phase of each impact, rad


def draw_cover(
    found: AllOrbits, system: System, title: str, caption: str, words: str = ""
) -> Picture:
    """A panel for each number of turns: the phase of an impact, and how far it is to the other.

    words: below the title.
    """
    covers = [one for one in found.covers if one.drawn]
    corners = style.corner_names(system.corners)
    panels = {
        f"cover {one.turns}": Panel(
            partial(_draw, cover=one, orbits=found.orbits, corners=corners),
            HEIGHT,
            across=min(2, len(covers)),
        )
        for one in covers
    }
    return Picture(title, panels, caption=caption, words=words)


def _draw(
    axes: Axes, cover: Cover, orbits: Sequence[PeriodicOrbit], corners: dict[str, float]
) -> None:
    """The boxes in the colour of what excludes an orbit or of those that hold one; the orbits."""
    low, high = _range(cover)
    for reason, colour in {**style.EXCLUDED, "": style.HOLDS_ORBIT}.items():
        shapes = [_corners(box) for box, why in cover.drawn if why == reason]
        seen = [shape for shape in shapes if _overlaps(shape, low, high)]
        if seen:
            # Where boxes are small their edges meet: they are pale, not white, which is no box.
            edge = style.mixed(colour, PALER)
            boxes = PolyCollection(seen, facecolors=colour, edgecolors=edge, linewidths=LINE)
            axes.add_collection(boxes)
            name = REASONS[reason] if reason else HOLDS_ORBIT
            axes.plot([], [], "s", color=colour, ms=5, label=name)
    labels = list(dict.fromkeys(orbit.label for orbit in orbits))  # orbits of one look alike
    shades = style.apart([style.label_colour(label) for label in labels])
    colours = dict(zip(labels, shades, strict=True))
    for orbit in orbits:
        _draw_orbit(axes, orbit, cover.turns, colours[orbit.label])
    corner_lines(axes, corners.items(), "x", named=False)
    axes.set(
        xlim=(0.0, TURN_DEG),
        ylim=(low, high),
        xlabel=labelled("phase of the first impact", THETA.unit),
        ylabel=labelled("from it to the second", THETA.unit),
        title=cover_words(cover),
    )
    axes.xaxis.set_major_locator(MultipleLocator(TICK))


def _draw_orbit(axes: Axes, orbit: PeriodicOrbit, turns: int, colour: str) -> None:
    """The mark of an orbit in a cover of so many turns, where it belongs to it; unstable: open."""
    places = _places(orbit, turns)
    if not places:
        return
    x, y = zip(*places, strict=True)
    name = f"{label_text(orbit.label)}, {'stable' if orbit.stable else 'unstable'}"
    look: dict[str, Any] = {"ms": 4.5, "mec": colour, "mew": 1.0, "zorder": 5, "clip_on": False}
    axes.plot(x, y, "o", mfc=colour if orbit.stable else PAPER, label=name, **look)


def _corners(box: Box) -> list[tuple[float, float]]:
    """The corners of a box: phase of the first impact, and from it to the second, deg."""
    (left, right), (low, high) = ([degrees(x) for x in ends] for ends in box)
    return [(left, low - left), (right, low - right), (right, high - right), (left, high - left)]


def _overlaps(shape: Sequence[tuple[float, float]], low: float, high: float) -> bool:
    """Whether a box reaches into a range of flights, deg."""
    lengths = [length for _, length in shape]
    return min(lengths) < high and max(lengths) > low


def _range(cover: Cover) -> tuple[float, float]:
    """The lengths (deg) that the longest flight of an orbit may have."""
    least = cover.turns * TURN_DEG / 2
    inside = [_corners(box) for box, why in cover.drawn if why not in AT_EDGE]
    longest = max((length for shape in inside for _, length in shape), default=0.0)
    return least, min(2 * least, max(least + LEAST, longest + ROOM))


def _places(orbit: PeriodicOrbit, turns: int) -> list[tuple[float, float]]:
    """Phase and length (deg) of the longest flight of an orbit of two impacts.

    One that is another gone through twice is there too; empty where it has not two impacts.
    """
    root = orbit.root
    if root is None or turns % orbit.turns or root.count * (turns // orbit.turns) != 2:
        return []
    lengths = [degrees(root.flight_length(k)) for k in range(root.count)]
    first = lengths.index(max(lengths))
    start = degrees(root.theta[first])
    return [(start, lengths[first])]
