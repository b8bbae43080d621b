"""Picture of classified motions: impact phases, largest exponent and labels, over speed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure

from camcli.analysis.classify import Motion
from camcli.analysis.explain.events import Event
from camcli.analysis.exponents import Exponents
from camcli.analysis.labels import APERIODIC, UNDECIDED
from camcli.analysis.sweep import status_name
from camcli.errors import Status
from camcli.kernel.orbit_loop import IMPACT
from camcli.plots import style
from camcli.plots.axes import (
    TURN_DEG,
    corners_upwards,
    numbers_height,
    padded,
    phase_axis,
    phase_range,
    trouble_ticks,
)
from camcli.plots.density import Cloud, Columns, Pixels, draw_shares, shading, take_all
from camcli.plots.event_list import Numbered, draw_events, draw_list, list_height, numbered
from camcli.plots.label_strip import KEY, ROW, draw_strip, draw_strip_key, draw_swatches, rests
from camcli.plots.style import BOTTOM, LEFT, WIDE
from camcli.system import System

HEAD, GAP = 110, 62  # px: title and key of the kinds, between panels
PHASES, GROWTH = 560, 340  # px, heights of the panels
WIDEST, SINGLE = 16, 100  # px at most, column of a speed, of a motion where all have one speed
BELOW = 0.16  # of the panel of exponents, for -inf
FORGETS = "−∞: the follower rests on the cam, which forgets every difference"
PERIODIC, RESTING, CONTACT = "periodic", "periodic with rest on the cam", "always in contact"
COLOURS = {
    PERIODIC: style.FLIGHT,
    RESTING: style.STICKING,
    APERIODIC: style.APERIODIC,
    UNDECIDED: style.UNDECIDED,
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

    @classmethod
    def of(cls, motions: Sequence[Motion], events: Sequence[Event]) -> _Scene:
        """Motions over speed; those of one and the same speed side by side."""
        rising = sorted(motions, key=lambda motion: motion.rpm)
        x = [motion.rpm for motion in rising]
        if len(set(x)) > 1:
            return cls(rising, x, Columns.of(sorted(set(x)), WIDE, WIDEST), numbered(events), False)
        x = [float(k) for k in range(1, len(rising) + 1)]
        widest = min(SINGLE, 0.6 * WIDE / max(1, len(x)))
        return cls(rising, x, Columns.of(x, WIDE, widest, (0.5, len(x) + 0.5)), [], True)

    def pairs(self) -> list[tuple[float, Motion]]:
        """Every motion with its place."""
        return list(zip(self.x, self.motions, strict=True))

    def frame(self, axes: Axes) -> None:
        """The range of the speeds; motions counted where there is one."""
        axes.set_xlim(self.columns.low, self.columns.high)
        if self.single:
            axes.set_xticks([] if len(self.x) == 1 else self.x)

    @property
    def speeds(self) -> str:
        """Their range."""
        ends = dict.fromkeys(style.number(self.motions[k].rpm) for k in (0, -1))
        return f"{' to '.join(ends)} rpm"


def kind(motion: Motion) -> str:
    """What a motion is drawn as."""
    if motion.label == "contact":
        return CONTACT
    if motion.orbit is not None:
        return RESTING if rests(motion) else PERIODIC
    return APERIODIC if motion.label == APERIODIC else UNDECIDED


@style.look()
def draw_classify(
    motions: Sequence[Motion], system: System | None = None, events: Sequence[Event] = ()
) -> Figure:
    """Picture of classified motions, with the corners of the system.

    Motions of one and the same speed stand side by side. `events` are listed and numbered.
    """
    scene = _Scene.of(motions, events)
    top = HEAD + list_height(scene.events) + numbers_height(len(scene.events)) + 10
    height = top + PHASES + GAP + GROWTH + KEY + 20 + ROW + BOTTOM
    height -= 30 * (len(scene.x) == 1)  # no numbers below the strip
    many = f"{len(set(scene.x))} speeds, " if not scene.single else ""
    figure = style.page(height, f"Motions at {many}{scene.speeds}")
    _draw_key(figure, scene)
    draw_list(figure, HEAD, scene.events)
    _draw_phases(style.place(figure, LEFT, top, WIDE, PHASES), scene, system)
    top += PHASES + GAP
    axes = style.place(figure, LEFT, top, WIDE, GROWTH)
    scene.frame(axes)
    draw_events(axes, scene.events, numbers=False)
    known = [Growth(x, m.exponents, COLOURS[kind(m)]) for x, m in scene.pairs() if m.exponents]
    draw_growth(axes, known)
    words = remark(known, len(scene.motions))
    style.write(figure, LEFT, top - 32, words, size=7, color=style.CAM)
    top += GROWTH + 20
    draw_strip_key(figure, LEFT, top, scene.motions)
    axes = style.place(figure, LEFT, top + KEY, WIDE, ROW)
    scene.frame(axes)
    draw_strip(axes, scene.motions, scene.x)
    axes.set_xlabel("cam speed (rpm)")
    if scene.single:
        count = "motion" if len(scene.motions) == 1 else "motions, numbered,"
        axes.set_xlabel(f"{count} at {scene.speeds}")
    return figure


def _draw_key(figure: Figure, scene: _Scene) -> None:
    """A colour for every kind, with the number of its motions; then what is not ok."""
    count = Counter(map(kind, scene.motions))
    troubles = Counter(status_name(m.status) for m in scene.motions if m.status != Status.OK)
    entries = [(COLOURS[name], False, f"{name} ({count[name]})") for name in COLOURS if count[name]]
    if troubles:
        said = ", ".join(f"{name} {many}" for name, many in sorted(troubles.items()))
        entries.append((style.TROUBLE, False, f"not ok: {said}"))
    draw_swatches(figure, 20.0, 54, entries)


def _impact_phases(motion: Motion) -> np.ndarray:
    """Of the record, deg."""
    record = motion.record
    keep = (np.asarray(record.kind) == IMPACT) & (np.asarray(record.period) >= 0)
    return np.degrees(np.asarray(record.theta, dtype=float)[keep]) % TURN_DEG


def _draw_phases(axes: Axes, scene: _Scene, system: System | None) -> None:
    """Impacts as a cloud for each kind of motion, in its colour."""
    every = [_impact_phases(motion) for motion in scene.motions]
    low, high = phase_range(Cloud.of(every).extremes())
    phase_axis(axes, low, high)
    scene.frame(axes)
    draw_events(axes, scene.events, numbers=True)
    if not any(map(len, every)):
        style.note(axes, "no impact at any of these speeds")
    places = {x: k for k, x in enumerate(dict.fromkeys(scene.x))}
    values: dict[str, list[np.ndarray]] = {name: [np.empty(0)] * len(places) for name in COLOURS}
    for (x, motion), phases in zip(scene.pairs(), every, strict=True):
        mine = values[kind(motion)]
        mine[places[x]] = np.concatenate([mine[places[x]], phases])
    clouds = {name: Cloud.of(columns) for name, columns in values.items()}
    norm = shading(list(clouds.values()), scene.columns)
    for name in (UNDECIDED, APERIODIC, RESTING, PERIODIC):
        pixels = Pixels(scene.columns, low, high, PHASES)
        take_all(values[name], pixels.take)
        draw_shares(axes, pixels, clouds[name], _shades(COLOURS[name]), norm)
    trouble_ticks(axes, [x for x, motion in scene.pairs() if motion.status != Status.OK])
    if system is not None:
        corners_upwards(axes, style.corner_names(system.corners_deg).items())
    axes.set_ylabel(r"impact phase $\theta$ (deg)")
    axes.tick_params(labelbottom=False)


def _shades(colour: str) -> LinearSegmentedColormap:
    """From a tint of a colour to a shade of it."""
    red, green, blue = to_rgb(colour)
    light = 0.4 * red + 0.6, 0.4 * green + 0.6, 0.4 * blue + 0.6
    dark = 0.55 * red, 0.55 * green, 0.55 * blue
    stops: list[Any] = [(0.0, light), (0.6, colour), (1.0, dark)]
    return LinearSegmentedColormap.from_list(colour, stops)


# --- largest exponents


@dataclass(frozen=True)
class Growth:
    """The exponents of a motion, where they are drawn, and in which colour."""

    x: float
    exponents: Exponents
    colour: str

    @property
    def largest(self) -> float:
        """Exponent in 1/turn."""
        return self.exponents.largest

    @property
    def spread(self) -> float:
        """Its standard error, 0 where none is known."""
        return self.exponents.spread if isfinite(self.exponents.spread) else 0.0


def draw_growth(axes: Axes, known: Sequence[Growth]) -> None:
    """Exponents with their error bars; those that are -inf on a band at the bottom."""
    finite = [one for one in known if isfinite(one.largest)]
    minus = [one for one in known if one.largest == -inf]
    ends = [one.largest + sign * one.spread for one in finite for sign in (-1.0, 1.0)]
    low, high = padded(np.array([0.0, *ends]), 0.5)
    floor = low - BELOW * (high - low) / (1.0 - BELOW) if minus else low
    axes.set_ylim(floor, high)
    axes.axhline(0.0, color=style.CAM, linewidth=0.8, zorder=1)
    for one in finite:
        axes.plot([one.x], [one.largest], "o", color=one.colour, ms=2.6, mew=0.0, zorder=4)
        bar = [one.largest - one.spread, one.largest + one.spread]
        axes.plot([one.x, one.x], bar, color=one.colour, linewidth=0.8, zorder=4)
    ticks = [tick for tick in axes.get_yticks() if low <= tick <= high] if finite else [0.0]
    names = [f"{tick:.6g}".replace("-", "−") for tick in ticks]
    if minus:
        _draw_forgetting(axes, minus, floor, low)
        ticks, names = [0.5 * (floor + low), *ticks], ["−∞", *names]
    axes.set_yticks(ticks, names)
    axes.set_ylabel("largest exponent (1/turn)")
    axes.tick_params(labelbottom=False)


def _draw_forgetting(axes: Axes, minus: Sequence[Growth], floor: float, low: float) -> None:
    """The band of those that are -inf, with the reason."""
    axes.axhspan(floor, low, color=style.CAM_BODY, linewidth=0, zorder=0)
    for colour in dict.fromkeys(one.colour for one in minus):
        at = [one.x for one in minus if one.colour == colour]
        y = [floor + 0.25 * (low - floor)] * len(at)
        axes.plot(at, y, "v", color=colour, ms=3.2, mew=0.0, zorder=4)
    patch = {"facecolor": style.CAM_BODY, "edgecolor": "none", "pad": 0.5}
    place: dict[str, Any] = {"ha": "center", "va": "center", "bbox": patch, "zorder": 5}
    place["transform"] = axes.get_yaxis_transform()
    axes.text(0.5, floor + 0.72 * (low - floor), FORGETS, size=7, color=style.CAM, **place)


def remark(known: Sequence[Growth], motions: int) -> str:
    """What the bars are, and for how many motions nothing is known."""
    said = ["bars: ± one standard error"] if any(one.spread > 0.0 for one in known) else []
    if len(known) < motions:
        said.append(f"not known for {motions - len(known)} of {motions} motions")
    return "; ".join(said)
