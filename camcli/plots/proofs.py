"""What is proved, in a picture: a band along a line, and ellipses that attract about impacts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from camcli.plots import style
from camcli.plots.branch_lines import SAME, phases, steady
from camcli.quantities import THETA, U_PLUS, labelled
from camcli.system import omega_of
from camcli.words.in_print import label_text
from camcli.words.orbits import value_text

if TYPE_CHECKING:  # it imports ball arithmetic
    from camcli.analysis.orbits.orbit import PeriodicOrbit
    from camcli.analysis.orbits.proofs import Axes as EllipseAxes
    from camcli.analysis.orbits.proofs import Range

WIDER = 2.6  # pt, by which the band is wider than its line
BAND: dict[str, Any] = {"color": style.PROVED, "ls": "-", "solid_capstyle": "butt"}
SAMPLE = {**BAND, "lw": WIDER + 0.9}  # what a list shows of it
WITHOUT_GAP = "proved without a gap"
PALER = 0.75  # share of white in the colour that fills an ellipse
POINTS = 181  # of the outline of an ellipse
MOST_PHASES = 3  # of the impacts, named above it


def draw_band(
    axes: Axes, x: Sequence[float], y: Sequence[float], line_width: float, zorder: float
) -> None:
    """The band along a line of so many pt; both axes keep their range."""
    width = line_width + WIDER
    axes.plot(x, y, lw=width, zorder=zorder, scalex=False, scaley=False, **BAND)


def proved_stretches(steps: Sequence[bool]) -> Iterator[slice]:
    """The points of a line between which each step is proved, as long as there is no gap.

    steps: whether the line is proved from each of its points to the next.
    """
    first = 0
    for proved, parts in groupby(steps):
        last = first + len(list(parts))
        if proved:
            yield slice(first, last + 1)
        first = last


def proved_steps(points: Sequence[PeriodicOrbit], ranges: Sequence[Range]) -> list[bool]:
    """Whether a branch is proved from each of its points to the next.

    ranges: those of this branch, proved or not. A range names the values of its ends, which are
    points of the branch, and whether its orbits are stable. Where a branch turns round and comes
    back, the way is meant that has points at both ends; where two have, none counts as proved.
    """
    pairs = list(pairwise(points))
    ways = _ways(points)
    steps = [False] * len(pairs)
    for one in ranges:
        if one.failed_step is not None:
            continue
        low, high = value_of(one.low), value_of(one.high)
        room = SAME * max(abs(low), abs(high))
        inside: dict[int, list[int]] = {}  # steps within the range, by the way that they are on
        for k, (before, after) in enumerate(pairs):
            lower, upper = sorted((before.value, after.value))
            inside_range = low - room <= lower and upper <= high + room
            if inside_range and steady(before, after) == one.stable:
                inside.setdefault(ways[k], []).append(k)
        meant = []
        for own in inside.values():
            values = [point.value for k in own for point in pairs[k]]
            if min(values) <= low + room and max(values) >= high - room:
                meant.append(own)
        if len(meant) == 1:
            for k in meant[0]:
                steps[k] = True
    return steps


def _ways(points: Sequence[PeriodicOrbit]) -> list[int]:
    """For each step of a branch how many times it has turned round before."""
    turns = 0
    rising = None
    ways = []
    for before, after in pairwise(points):
        if abs(after.value - before.value) > SAME * abs(before.value):
            now = after.value > before.value
            if rising is not None and now != rising:
                turns += 1
            rising = now
        ways.append(turns)
    return ways


def value_of(text: str) -> float:
    """The double next to an end of a range, "[middle +/- radius]" or the text of a double."""
    return float(text.strip("[]").partition(" +/- ")[0])


def draw_attraction(
    axes: Axes, orbit: PeriodicOrbit, ellipses: EllipseAxes, colour: str, parameter: str
) -> None:
    """About each impact of an orbit the ellipse of impacts from which all motions tend to it.

    Phases and rebound velocities are counted from those of the impact. Of several impacts each
    ellipse has its number at a place of its own.
    """
    omega = omega_of(orbit.rpm)
    around = np.linspace(0.0, 2.0 * np.pi, POINTS)
    name = f"impacts from which every motion tends to {label_text(orbit.label)}: proved"
    for number, (a, b, c, d) in enumerate(ellipses, 1):
        phase = np.degrees(a * np.cos(around) + b * np.sin(around))
        rate = omega * (c * np.cos(around) + d * np.sin(around))
        fill = style.mixed(colour, PALER)
        label = name if number == 1 else None
        axes.fill(phase, rate, facecolor=fill, edgecolor=colour, lw=1.0, zorder=2, label=label)
        if len(ellipses) > 1:
            k = (number - 1) * (POINTS - 1) // len(ellipses)
            look: dict[str, Any] = {"fontsize": style.NOTE, "ha": "center", "va": "center"}
            look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
            axes.annotate(str(number), (phase[k], rate[k]), zorder=5, **look)
    axes.plot([0.0], [0.0], "o", color=colour, ms=3.5, zorder=4)
    axes.set(
        xlabel=labelled(r"$\theta$ less the impact's", THETA.unit),
        ylabel=labelled(f"{U_PLUS.name}\nless the impact's", U_PLUS.unit),
    )
    shown = [f"{phase:.2f}" for phase in phases(orbit)[:MOST_PHASES]]
    if len(orbit.theta) > MOST_PHASES:
        shown.append("…")
    impacts = "impact" if len(orbit.theta) == 1 else "impacts"
    axes.set_title(f"{value_text(orbit.value, parameter)}, {impacts} at {', '.join(shown)} deg")
