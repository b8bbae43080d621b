"""Picture of classified motions: impact phases, largest exponent and labels, over speed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from camcli.analysis.classify import APERIODIC, Motion
from camcli.analysis.explain.events import Event
from camcli.analysis.integrate import IMPACT
from camcli.analysis.sweep import status_name
from camcli.errors import OK
from camcli.plots import style
from camcli.plots.density import Cloud, Columns, one_point, phase_range, shares
from camcli.plots.event_keys import (
    Numbered,
    draw_lines,
    draw_list,
    draw_numbers,
    list_height,
    numbered,
    numbers_height,
)
from camcli.plots.growth_panel import Growth, draw_growth, remark
from camcli.plots.label_strip import KEY, ROW, draw_key, draw_strip, rests, swatches
from camcli.system import System

LEFT, RIGHT, BOTTOM = 140, 60, 95  # px, margins
HEAD, GAP = 110, 62  # px: title and key of the kinds, between panels
PHASES, GROWTH = 560, 340  # px, heights of the panels
WIDE = style.WIDTH - LEFT - RIGHT
FULLEST = 0.1  # share of a column's impacts per pixel from which it is darkest
WIDEST, SINGLE = 16, 100  # px at most, column of a speed, of a motion where all have one speed
PERIODIC, RESTING, CHAOS, UNKNOWN, CONTACT = (
    "periodic", "periodic with rest on the cam", "aperiodic", "undecided", "always in contact",
)  # fmt: skip
COLOURS = {
    PERIODIC: style.FLIGHT,
    RESTING: style.STICKING,
    CHAOS: style.APERIODIC,
    UNKNOWN: style.UNDECIDED,
    CONTACT: style.CONTACT,
}


@dataclass(frozen=True)
class _Scene:
    """Motions in ascending order, where each is drawn, and what the panels share."""

    motions: list[Motion]
    x: list[float]
    columns: Columns
    events: list[Numbered]
    single: bool

    def pairs(self) -> list[tuple[float, Motion]]:
        """Every motion with its place."""
        return list(zip(self.x, self.motions, strict=True))

    def frame(self, axes: Axes, lines: bool = True) -> None:
        """The range of the speeds, a line at every event; motions counted where there is one."""
        axes.set_xlim(self.columns.low, self.columns.high)
        if self.single:
            axes.set_xticks([] if len(self.x) == 1 else self.x)
        if lines:
            draw_lines(axes, self.events)


def kind(motion: Motion) -> str:
    """What a motion is drawn as."""
    if motion.label == "contact":
        return CONTACT
    if motion.orbit is not None:
        return RESTING if rests(motion) else PERIODIC
    return CHAOS if motion.label == APERIODIC else UNKNOWN


@style.look()
def draw_classify(
    motions: Sequence[Motion],
    system: System | None = None,
    events: Sequence[Event] = (),
) -> Figure:
    """Picture of classified motions, with the corners of the system.

    Motions of one and the same speed stand side by side. `events` are listed and numbered.
    """
    scene = _scene(motions, events)
    top = HEAD + list_height(scene.events) + numbers_height(scene.events) + 10
    height = top + PHASES + GAP + GROWTH + KEY + 20 + ROW + BOTTOM
    height -= 30 * (len(scene.x) == 1)  # no numbers below the strip
    figure = style.page(height)
    style.write(figure, 20, 14, _title(scene), size=9, weight="bold")
    _key(figure, scene)
    draw_list(figure, HEAD, scene.events)
    axes = style.place(figure, LEFT, top, WIDE, PHASES)
    _draw_phases(axes, scene, system)
    draw_numbers(axes, scene.events, WIDE, PHASES)
    top += PHASES + GAP
    axes = style.place(figure, LEFT, top, WIDE, GROWTH)
    scene.frame(axes)
    known = [Growth(x, m.exponents, COLOURS[kind(m)]) for x, m in scene.pairs() if m.exponents]
    draw_growth(axes, known)
    words = remark(known, len(scene.motions))
    style.write(figure, LEFT, top - 32, words, size=7, color=style.CAM)
    top += GROWTH + 20
    draw_key(figure, LEFT, top, scene.motions)
    axes = style.place(figure, LEFT, top + KEY, WIDE, ROW)
    scene.frame(axes, False)
    draw_strip(axes, scene.motions, scene.x)
    axes.set_xlabel(_abscissa(scene))
    return figure


def _scene(motions: Sequence[Motion], events: Sequence[Event]) -> _Scene:
    motions = sorted(motions, key=lambda motion: motion.rpm)
    rpms = sorted({motion.rpm for motion in motions})
    if len(rpms) > 1:
        columns = Columns.of(rpms, WIDE)
        if len(rpms) < WIDE:
            columns = _bars(rpms, columns.low, columns.high, WIDEST)
        return _Scene(motions, [motion.rpm for motion in motions], columns, numbered(events), False)
    x = [float(k) for k in range(1, len(motions) + 1)]
    columns = _bars(x, 0.5, len(x) + 0.5, min(SINGLE, 0.6 * WIDE / max(1, len(x))))
    return _Scene(motions, x, columns, [], True)


def _bars(x: Sequence[float], low: float, high: float, widest: float) -> Columns:
    """Columns of at most so many pixels around ascending values."""
    places = (np.asarray(x) - low) / (high - low) * WIDE
    middle = np.arange(WIDE) + 0.5
    nearest = np.searchsorted((places[1:] + places[:-1]) / 2.0, middle)
    near = abs(middle - places[nearest]) <= widest / 2.0
    return Columns(low, high, len(places), np.arange(len(places)), np.where(near, nearest, -1))


def _title(scene: _Scene) -> str:
    ends = [style.number(scene.motions[k].rpm) for k in (0, -1)]
    if scene.single:
        return f"Motions at {ends[0]} rpm"
    return f"Motions at {len(set(scene.x))} speeds, {' to '.join(ends)} rpm"


def _abscissa(scene: _Scene) -> str:
    if not scene.single:
        return "cam speed (rpm)"
    many = "motion" if len(scene.motions) == 1 else "motions, numbered,"
    return f"{many} at {style.number(scene.motions[0].rpm)} rpm"


def _key(figure: Figure, scene: _Scene) -> None:
    """A colour for every kind, with the number of its motions; then what is not ok."""
    count = Counter(map(kind, scene.motions))
    troubles = Counter(status_name(m.status) for m in scene.motions if m.status != OK)
    entries = [(COLOURS[name], False, f"{name} ({count[name]})") for name in COLOURS if count[name]]
    if troubles:
        said = ", ".join(f"{name} {many}" for name, many in sorted(troubles.items()))
        entries.append((style.TROUBLE, False, f"not ok: {said}"))
    swatches(figure, 20.0, 54, entries)


def _phases_of(motion: Motion) -> np.ndarray:
    """Impact phases of the record, deg."""
    tape = motion.tape
    keep = (np.asarray(tape.kind) == IMPACT) & (np.asarray(tape.period) >= 0)
    return np.degrees(np.asarray(tape.theta, dtype=float)[keep]) % 360.0


def _draw_phases(axes: Axes, scene: _Scene, system: System | None) -> None:
    every = [_phases_of(motion) for motion in scene.motions]
    low, high = phase_range(Cloud.of(every))
    axes.set_ylim(low, high)
    scene.frame(axes)
    if not any(map(len, every)):
        style.note(axes, "no impact at any of these speeds")
    places = {x: k for k, x in enumerate(dict.fromkeys(scene.x))}
    values, clouds = {}, {}
    for name in COLOURS:
        columns: list[list[np.ndarray]] = [[] for _ in places]
        for (x, motion), phases in zip(scene.pairs(), every, strict=True):
            if kind(motion) == name:
                columns[places[x]].append(phases)
        values[name] = [np.concatenate([*parts, np.empty(0)]) for parts in columns]
        clouds[name] = Cloud.of(values[name])
    least = one_point(list(clouds.values()), scene.columns)
    norm = LogNorm(min(least, 0.1 * FULLEST), FULLEST, clip=True)
    extent = (scene.columns.low, scene.columns.high, low, high)
    for name in (UNKNOWN, CHAOS, RESTING, PERIODIC):
        picture = shares(values[name], clouds[name], scene.columns, low, high, PHASES)
        look = {"interpolation": "none", "cmap": _shades(COLOURS[name]), "norm": norm}
        axes.imshow(picture, extent=extent, origin="lower", aspect="auto", zorder=2, **look)
    rpms = [x for x, motion in scene.pairs() if motion.status != OK]
    ticks = {"marker": "|", "markersize": 7, "markeredgewidth": 0.9, "linestyle": ""}
    bottom = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    axes.plot(rpms, [0.0] * len(rpms), color=style.TROUBLE, **ticks, **bottom)
    _corners(axes, system)
    if (low, high) == (0.0, 360.0):
        axes.yaxis.set_major_locator(MultipleLocator(60))
    axes.set_ylabel(r"impact phase $\theta$ (deg)")
    axes.tick_params(labelbottom=False)


def _shades(colour: str) -> LinearSegmentedColormap:
    """From a tint of a colour to a shade of it."""
    light, dark = (tuple(a + s * (b - a) for a in to_rgb(colour)) for s, b in ((0.6, 1), (0.45, 0)))
    return LinearSegmentedColormap.from_list(colour, [(0.0, light), (0.6, colour), (1.0, dark)])


def _corners(axes: Axes, system: System | None) -> None:
    """The cam's corners as lines named at the right edge."""
    low, high = axes.get_ylim()
    names = {} if system is None else style.corner_names(system.corners_deg)
    seen = {name: phase for name, phase in names.items() if low <= phase <= high}
    places = style.spread(list(seen.values()), 24.0 * (high - low) / PHASES, low, high)
    for (name, phase), place in zip(seen.items(), places, strict=True):
        axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
        at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
        axes.text(1.012, place, name, color=style.CAM, **at)
