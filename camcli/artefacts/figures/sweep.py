"""Picture of a sweep: impact phases beside the cam, stroboscopic positions below."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, PercentFormatter

from camcli.analysis.sweep import Speed, Sweep, status_name
from camcli.artefacts.figures import style
from camcli.artefacts.figures.density import (
    TURN_DEG,
    Cloud,
    Columns,
    enlarged_range,
    one_point,
    padded,
    phase_range,
    shares,
)
from camcli.errors import OK
from camcli.kernel.profile import PIECE, TERMS
from camcli.profiles.table import column
from camcli.system import System

LEFT, WIDE, RIGHT = 365, 925, 50  # px, of the diagrams
CAM_LEFT, CAM_WIDE, CAM_GAP = 105, 68, 16  # px, of the three cam curves beside them
GAP, BOTTOM = 36, 90  # px, between panels and below the last
CHARS = 118  # in a line of the subtitle
FULLEST = 0.1  # share of a speed's points in a pixel from which it is darkest
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


def draw_sweep(sweep: Sweep, system: System, path_or_buffer, *, start_text: str) -> None:
    """Write the PNG of a sweep to a path or a binary buffer.

    `start_text` says how the orbits were started; it stands below the title.
    """
    speeds = sorted(sweep.speeds, key=lambda speed: speed.rpm)
    panels = _panels(speeds)
    lines = textwrap.wrap(_subtitle(speeds, start_text), CHARS)
    top = 70 + style.LINE * len(lines) + 20
    heights = [panel.height for panel in panels] or [200]
    height = top + sum(heights) + GAP * (len(heights) - 1) + BOTTOM
    with style.page(path_or_buffer, height) as figure:
        style.write(figure, 20, 16, _title(speeds), size=9, weight="bold")
        style.write(figure, 20, 66, "\n".join(lines), linespacing=1.25)
        if not panels:
            empty = style.place(figure, LEFT, top, WIDE, heights[0], xticks=[], yticks=[])
            style.note(empty, "nothing was recorded")
            return
        _draw_panels(figure, panels, speeds, system, top)


def _title(speeds: Sequence[Speed]) -> str:
    if not speeds:
        return "Bifurcation diagram"
    low, high = style.number(speeds[0].rpm), style.number(speeds[-1].rpm)
    return (
        f"Bifurcation diagram, {low} rpm"
        if low == high
        else (f"Bifurcation diagram, {low} to {high} rpm")
    )


def _subtitle(speeds: Sequence[Speed], start_text: str) -> str:
    text = f"{start_text}; {len(speeds)} speed" + ("s" if len(speeds) != 1 else "")
    troubles = Counter(status_name(speed.status) for speed in _troubled(speeds))
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        text += f"; {troubles.total()} not ok, red ticks below the diagrams ({kinds})"
    return text


def _troubled(speeds: Sequence[Speed]) -> list[Speed]:
    return [speed for speed in speeds if speed.status != OK]


def _panels(speeds: Sequence[Speed]) -> list[_Panel]:
    """What there is to show, from top to bottom."""
    panels = []
    if any(speed.impacts is not None for speed in speeds):
        cloud = Cloud.of([() if s.impacts is None else s.impacts[1] for s in speeds])
        enlarged = enlarged_range(cloud)
        height = 640 if enlarged is None else 430
        panels.append(_Panel(cloud, *phase_range(cloud), height, True, enlarged))
        if enlarged is not None:
            panels.append(_Panel(cloud, *enlarged, 520, True))
    if any(speed.strobe is not None for speed in speeds):
        cloud = Cloud.of([() if s.strobe is None else s.strobe[1] for s in speeds])
        largest = float(np.abs(cloud.values).max(initial=0.0))
        panels.append(_Panel(cloud, *padded(cloud.values, 0.1 * largest or 1.0), 430, False))
    return panels


def _draw_panels(figure, panels: Sequence[_Panel], speeds, system: System, top: int) -> None:
    columns = Columns.of([speed.rpm for speed in speeds], WIDE)
    faintest = min(one_point([panel.cloud for panel in panels]), 0.1 * FULLEST)
    norm = LogNorm(faintest, FULLEST, clip=True)
    corners = style.corner_names(system.corners_deg)
    image, last_phases = None, [panel.phases for panel in panels].count(True) - 1
    for n, panel in enumerate(panels):
        axes = style.place(figure, LEFT, top, WIDE, panel.height)
        image = _draw_cloud(axes, panel, columns, norm) or image
        axes.set_xlim(columns.low, columns.high)
        axes.set_ylim(panel.low, panel.high)
        _draw_troubles(axes, speeds)
        if panel.phases:
            _draw_corners(axes, panel, corners)
            _draw_cam(figure, panel, system, corners, top, n == last_phases)
        else:
            axes.set_ylabel("stroboscopic position $q$ (m)")
        if n < len(panels) - 1:
            axes.tick_params(labelbottom=False)
        else:
            axes.set_xlabel("cam speed (rpm)")
        top += panel.height + GAP
    if image is not None:
        _draw_key(figure, image)


def _draw_cloud(axes: Axes, panel: _Panel, columns: Columns, norm: LogNorm):
    """The points as one image on the pixels of the panel; words where there are none."""
    if not len(panel.cloud.values):
        what = "no impact" if panel.phases else "no whole turn recorded"
        style.note(axes, f"{what} at any of these speeds")
        return None
    if panel.enlarged is not None:
        axes.axhspan(*panel.enlarged, color=style.BAND, linewidth=0, zorder=0)
    return axes.imshow(
        shares(panel.cloud, columns, panel.low, panel.high, panel.height),
        extent=(columns.low, columns.high, panel.low, panel.high),
        origin="lower",
        aspect="auto",
        interpolation="none",
        cmap=style.DENSITY,
        norm=norm,
        zorder=2,
    )


def _draw_troubles(axes: Axes, speeds: Sequence[Speed]) -> None:
    """A red tick below every speed whose status is not ok."""
    rpms = [speed.rpm for speed in _troubled(speeds)]
    ticks = {"marker": "|", "markersize": 7, "markeredgewidth": 0.9, "linestyle": ""}
    bottom = {"transform": axes.get_xaxis_transform(), "clip_on": False, "zorder": 5}
    axes.plot(rpms, [0.0] * len(rpms), color=style.TROUBLE, **ticks, **bottom)


def _draw_corners(axes: Axes, panel: _Panel, corners: dict[str, float]) -> None:
    """Thin lines at the corners of the cam, named at the right edge."""
    seen = {name: phase for name, phase in corners.items() if panel.low <= phase <= panel.high}
    gap = 24.0 * (panel.high - panel.low) / panel.height
    places = style.spread(list(seen.values()), gap, panel.low, panel.high)
    for (name, phase), place in zip(seen.items(), places, strict=True):
        axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
        at = {"transform": axes.get_yaxis_transform(), "va": "center_baseline", "ha": "left"}
        axes.text(1.012, place, name, color=style.CAM, **at)


def _draw_cam(figure: Figure, panel: _Panel, system, corners, top: int, labelled: bool) -> None:
    """The cam's lift and its derivatives beside a panel, over the same phases."""
    theta, orders = _lift(system)
    for k, (name, unit) in enumerate(CURVES):
        left = CAM_LEFT + k * (CAM_WIDE + CAM_GAP)
        axes = style.place(figure, left, top, CAM_WIDE, panel.height)
        axes.plot(orders[k], theta, color=style.CAM, linewidth=0.9)
        for phase in corners.values():
            axes.axhline(phase, color=style.GUIDE, linewidth=0.5, zorder=1)
        axes.set_ylim(panel.low, panel.high)
        axes.xaxis.set_major_locator(MaxNLocator(1))
        _phase_axis(axes, panel, k == 0)
        if labelled:
            axes.set_xlabel(f"{name}\n({unit})")
        else:
            axes.tick_params(labelbottom=False)


def _phase_axis(axes: Axes, panel: _Panel, labelled: bool) -> None:
    if (panel.low, panel.high) == (0.0, TURN_DEG):
        axes.set_yticks(range(0, 361, 60))
    if labelled:
        axes.set_ylabel(r"impact phase $\theta$ (deg)")
    else:
        axes.tick_params(labelleft=False, left=False)


def _lift(system: System) -> tuple[np.ndarray, list[np.ndarray]]:
    """Phases in degrees, and c, c_theta, c_thetatheta there; nan between stretches."""
    cam = system.cam
    pieces = np.asarray(cam.pieces, dtype=float).reshape(-1, PIECE)
    starts, ends = column(cam, "START"), column(cam, "END")
    first, count = column(cam, "FIRST"), column(cam, "COUNT")
    theta, orders = [], [[] for _ in CURVES]
    for n, (start, end) in enumerate(zip(starts, ends, strict=True)):
        x = np.linspace(start, end, 2 + int((end - start) * 200))
        k = ((x - start) / (end - start) * count[n]).astype(int)
        piece = pieces[int(first[n]) + np.minimum(k, int(count[n]) - 1)]
        theta += [np.degrees(x), [np.nan]]
        for order, rows in enumerate(orders):
            terms = piece[:, 1 + order * TERMS : 1 + (order + 1) * TERMS]
            powers = (x - piece[:, 0])[:, None] ** np.arange(TERMS)
            rows += [(terms * powers).sum(axis=1), [np.nan]]
    return np.concatenate(theta), [np.concatenate(rows) for rows in orders]


def _draw_key(figure: Figure, image) -> None:
    """What the shades mean, right of the title."""
    key = style.place(figure, LEFT + WIDE - 240, 22, 240, 16)
    figure.colorbar(image, cax=key, orientation="horizontal", extend="max")
    key.xaxis.set_major_formatter(PercentFormatter(1.0))
    key.minorticks_off()
