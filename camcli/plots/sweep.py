"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from camcli.analysis.integrate import Settings
from camcli.analysis.sweep import FIXED, Sweep
from camcli.plots import style
from camcli.plots.density import (
    TURN_DEG,
    Cloud,
    Columns,
    Pixels,
    enlarged_range,
    lift_curves,
    one_point,
    padded,
    phase_range,
)
from camcli.plots.event_keys import (
    draw_lines,
    draw_list,
    draw_numbers,
    list_height,
    numbered,
    numbers_height,
)
from camcli.plots.survey import Survey, count
from camcli.system import System

if TYPE_CHECKING:
    from camcli.analysis.explain.events import Event

LEFT, RIGHT = 130, 50  # px, margins of the diagrams
CAM, CAM_GAP = 72, 18  # px, width of the three curves of the cam beside them
GAP, BOTTOM = 36, 90  # px, between panels and below the last
LIST_GAP = 14  # px above a list of events
SMALL = 0.02  # m: a cam that is smaller throughout is drawn in mm
SPACED = {"linespacing": 1.0, "fontsize": 7}
KEY = 140  # px, height of the scales above the panels; half is enough without the cam
CHARS = 108  # in a line of the subtitle
FULLEST = 0.1  # share of a column's points per pixel from which it is darkest
CURVES = (("$c$", "m"), (r"$c_\theta$", "m/rad"), (r"$c_{\theta\theta}$", "m/rad²"))


@dataclass(frozen=True)
class _Panel:
    """One diagram: its points, the range of its vertical axis and its height in pixels."""

    cloud: Cloud
    low: float
    high: float
    height: int
    phases: bool
    enlarged: tuple[float, float] | None = None  # shown again in the next panel


@style.look()
def draw_sweep(
    sweep: Sweep, system: System, settings: Settings, events: Sequence[Event] = ()
) -> Figure:
    """Picture of a sweep; `settings` tell how its orbits were started.

    `events` are listed below the title and numbered above the panels.
    """
    found = numbered(events)
    survey = Survey.of(sweep.speeds)
    panels = _panels(survey)
    lines = textwrap.wrap(
        _subtitle(survey, _started(sweep, settings)), CHARS, break_on_hyphens=False
    )
    head = 54 + style.LINE * len(lines) + (LIST_GAP if found else 0)
    top = head + list_height(found) + numbers_height(found)
    top += KEY if panels and panels[0].phases else KEY // 2
    heights = [panel.height for panel in panels] or [200]
    height = top + sum(heights) + GAP * (len(heights) - 1) + BOTTOM
    figure = style.page(height)
    style.write(figure, 20, 14, _title(survey), size=9, weight="bold")
    style.write(figure, 20, 54, "\n".join(lines), linespacing=1.25)
    draw_list(figure, head, found)
    if not panels:
        wide = style.WIDTH - LEFT - RIGHT
        empty = style.place(figure, LEFT, top, wide, heights[0], xticks=[], yticks=[])
        style.note(empty, "nothing was recorded")
        return figure
    _draw_panels(figure, panels, sweep, survey, system, top, found)
    return figure


def _title(survey: Survey) -> str:
    rpm = survey.rpm
    if not len(rpm):
        return "Bifurcation diagram"
    ends = dict.fromkeys(style.number(float(end)) for end in (rpm.min(), rpm.max()))
    return f"Bifurcation diagram, {' to '.join(ends)} rpm"


def _started(sweep: Sweep, settings: Settings) -> str:
    """How the orbits were started."""
    start, turns = settings.start, settings.transient
    if start.q is None and start.v is None:
        place = "at rest on the cam"
    else:
        q = "on the cam" if start.q is None else f"q = {start.q:g} m"
        v = "the cam's v" if start.v is None else f"v = {start.v:g} m/s"
        place = f"at {q}, {v}"
    if sweep.direction == FIXED or not sweep.speeds:
        return f"each speed started {place}, {turns} turns of transient"
    return (
        f"carried {sweep.direction} from {sweep.speeds[0].rpm:g} rpm, started there {place}; "
        f"{turns} turns of transient at each speed"
    )


def _subtitle(survey: Survey, started: str) -> str:
    many, troubles = len(survey.rpm), survey.troubles()
    parts = [started, f"{many} speed" + ("s" if many != 1 else "")]
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        parts.append(f"{troubles.total()} not ok, marked at the bottom edge ({kinds})")
    return "; ".join(part for part in parts if part)


def _panels(survey: Survey) -> list[_Panel]:
    """What there is to show, from top to bottom."""
    panels = []
    if (cloud := survey.impacts) is not None:
        enlarged = enlarged_range(cloud)
        height = 640 if enlarged is None else 430
        panels.append(_Panel(cloud, *phase_range(cloud), height, True, enlarged))
        if enlarged is not None:
            panels.append(_Panel(cloud, *enlarged, 520, True))
    if (cloud := survey.strobe) is not None:
        largest = float(np.abs(cloud.extremes()).max(initial=0.0))
        panels.append(_Panel(cloud, *padded(cloud.extremes(), 0.1 * largest or 1.0), 430, False))
    return panels


def _count(panels: Sequence[_Panel], columns: Columns, sweep: Sweep) -> list[np.ndarray]:
    """The picture of every panel, by one pass over the speeds."""
    pixels = [Pixels(columns, panel.low, panel.high, panel.height) for panel in panels]
    count(sweep.speeds, [(one, panel.phases) for one, panel in zip(pixels, panels, strict=True)])
    return [one.shares(panel.cloud) for one, panel in zip(pixels, panels, strict=True)]


def _draw_panels(
    figure: Figure, panels, sweep: Sweep, survey: Survey, system: System, top: int, events
) -> None:
    left = LEFT + (len(CURVES) * (CAM + CAM_GAP) + CAM_GAP if panels[0].phases else 0)
    columns = Columns.of(survey.rpm, style.WIDTH - left - RIGHT)
    faintest = one_point([panel.cloud for panel in panels], columns)
    norm = LogNorm(min(faintest, 0.1 * FULLEST), FULLEST, clip=True)
    image, above = None, top
    pictures = _count(panels, columns, sweep)
    for n, (panel, picture) in enumerate(zip(panels, pictures, strict=True)):
        axes = style.place(figure, left, top, columns.width, panel.height)
        image = _draw_cloud(axes, panel, picture, columns, norm) or image
        axes.set(xlim=(columns.low, columns.high), ylim=(panel.low, panel.high))
        axes.tick_params(labelbottom=panel is panels[-1])
        draw_lines(axes, events)
        if n == 0:
            draw_numbers(axes, events, columns.width, panel.height)
        _draw_troubles(axes, survey.troubled)
        if panel.phases:
            axes.tick_params(left=False, labelleft=False)
            _draw_corners(axes, panel, system)
            _draw_cam(figure, panel, system, top, n == 0)
        else:
            phase = style.number(round(degrees(system.strobe), 9))
            axes.set_ylabel(rf"stroboscopic $q$ (m), $\theta$ = {phase} deg")
        top += panel.height + GAP
    axes.set_xlabel("cam speed (rpm)")
    if image is not None:
        _draw_key(figure, image, above - 60 - numbers_height(events))


def _draw_cloud(axes: Axes, panel: _Panel, picture, columns: Columns, norm: LogNorm):
    """The points as one image on the pixels of the panel; words where there are none."""
    if not panel.cloud.count.any():
        what = "no impact" if panel.phases else "no whole turn recorded"
        style.note(axes, f"{what} at any of these speeds")
        return None
    if panel.enlarged is not None:
        axes.axhspan(*panel.enlarged, color=style.BAND, linewidth=0, zorder=0)
    return axes.imshow(
        picture,
        extent=(columns.low, columns.high, panel.low, panel.high),
        origin="lower",
        aspect="auto",
        interpolation="none",
        cmap=style.DENSITY,
        norm=norm,
        zorder=2,
    )


def _draw_troubles(axes: Axes, rpms: np.ndarray) -> None:
    """A red tick below every speed whose status is not ok."""
    ticks = {"marker": "|", "markersize": 7, "markeredgewidth": 0.9, "linestyle": ""}
    bottom = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    axes.plot(rpms, np.zeros(len(rpms)), color=style.TROUBLE, **ticks, **bottom)


def _corner_lines(axes: Axes, panel: _Panel, system: System) -> dict[str, float]:
    """A thin line at every corner of the cam in the panel; returns those by name."""
    names = style.corner_names(system.corners_deg)
    seen = {name: phase for name, phase in names.items() if panel.low <= phase <= panel.high}
    for phase in seen.values():
        axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
    return seen


def _draw_corners(axes: Axes, panel: _Panel, system: System) -> None:
    """The corners' lines, named at the right edge."""
    seen = _corner_lines(axes, panel, system)
    gap = 24.0 * (panel.high - panel.low) / panel.height
    places = style.spread(list(seen.values()), gap, panel.low, panel.high)
    for name, place in zip(seen, places, strict=True):
        at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
        axes.text(1.012, place, name, color=style.CAM, **at)


def _draw_cam(figure: Figure, panel: _Panel, system: System, top: int, first: bool) -> None:
    """The cam's lift and its derivatives beside a panel, over the same phases."""
    theta, orders = lift_curves(system.cam, len(CURVES))
    milli = bool(np.nanmax(np.abs(orders)) < SMALL)
    for k, (name, unit) in enumerate(CURVES):
        left = LEFT + k * (CAM + CAM_GAP)
        axes = style.place(figure, left, top, CAM, panel.height)
        axes.plot(orders[k] * (1e3 if milli else 1.0), theta, color=style.CAM, linewidth=0.9)
        _corner_lines(axes, panel, system)
        axes.set_ylim(panel.low, panel.high)
        if (panel.low, panel.high) == (0.0, TURN_DEG):
            axes.set_yticks(range(0, 361, 60))
        axes.tick_params(left=k == 0, labelleft=k == 0, bottom=False, labelbottom=False)
        if k == 0:
            axes.set_ylabel(r"impact phase $\theta$ (deg)" + ("" if first else ", enlarged"))
        if first:
            axes.xaxis.set_major_locator(MaxNLocator(2, steps=[1, 2, 5, 10], min_n_ticks=2))
            axes.tick_params(axis="x", top=True, labeltop=True, labelrotation=90)
            middle = left + CAM / 2
            style.write(
                figure, middle, top - 124, f"{name}\n{'m' * milli}{unit}", ha="center", **SPACED
            )


def _draw_key(figure: Figure, image, top: int) -> None:
    """What the shades mean, above the right end of the first panel."""
    left = style.WIDTH - RIGHT - 260
    key = style.place(figure, left, top, 260, 14)
    figure.colorbar(image, cax=key, orientation="horizontal", extend="max")
    key.xaxis.set_major_formatter(lambda share, _: f"{100.0 * share:g} %")
    key.minorticks_off()
    words = "share of a column's points per pixel"
    style.write(figure, left - 14, top - 8, words, ha="right")
